"""Landing by simulation, what people do today: a stiff contact, and time in small steps on Pinocchio's articulated-body algorithm.

The feet are glued to the ground by pads of one damping in all directions. The pad is as hard as one likes: the harder, the shorter
the impact and the less the robot moves meanwhile, and in the limit its change of velocity is that of the impulsive equation with
e = 0. (Where all contacts share a restitution, that is one factor 1 + e.) But the direction with the least mass behind it sets the
length of a step, and the one with the most sets the length of the impact, so the number of steps grows with the quotient of the
two. There is no gravity: to fall until the contact is at rest is none of the contact's doing, and would be most of the error.
"""

from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.bench.assembler import assembler
from shockpc.bench.methods import Method, Prepared
from shockpc.bench.system import System, Unsuited, columns_along, jumps_between, moving, velocity_at_impact
from shockpc.core.spatial import Array

__all__ = ["MOST_STEPS", "SIMULATED", "Stepper", "land"]

REST = 15.0
"""Time constants until a contact is at rest."""

MOST_STEPS = 60_000
"""A simulation that needs more is not begun."""


class Stepper:
    """A robot without gravity in small steps of semi-implicit Euler, pushed along its rows.

    It is watched from where its base is at rest before the impact: a velocity that the whole robot shares changes nothing, but
    written in axes that turn with the base it would have to be turned back in every step, and no step does that exactly.

    Args:
        system: what moves.
        restitution: of the rows.
    """

    def __init__(self, system: System, restitution: float):
        self.model = pin.Model(system.model)
        self.model.gravity.linear = np.zeros(3)
        self.data = self.model.createData()
        self._start, self._assemble, self._columns = system.landing.q, assembler(system, self.data), columns_along(system)
        self.before, self.G = velocity_at_impact(system), system.G
        if self.G is not None:
            self.before = self.G @ np.linalg.lstsq(self.G, self.before, rcond=None)[0]
        if system.robot.free_base:
            self.before[:3] = 0.0
        self.begin()
        # What the base carries along moves the ground instead.
        self.carried = system.b / (1.0 + restitution) - self.J_c @ self.before

    def begin(self) -> None:
        """Back to the moment of the impact."""
        self.q, self.v = self._start.copy(), self.before
        self.assemble()

    def assemble(self) -> None:
        """Inertia and rows of the posture it is in now, and the columns of what may move."""
        self.H, self.J_c = self._assemble(self.q)
        self.G = turned if (turned := self._columns(self.q)) is not None else self.G

    def mobility(self) -> Array:
        """The speed along each row for a unit impulse along each other (nc, nc)."""
        H, J_c = (self.H, self.J_c) if self.G is None else (self.G.T @ self.H @ self.G, self.J_c @ self.G)
        return np.asarray(J_c @ np.linalg.solve(H, J_c.T))

    def speed(self, v: Array) -> Array:
        """Speed along the rows (nc,) against the ground at joint velocities v."""
        return np.asarray(self.J_c @ v + self.carried)

    def acceleration(self, force: Array) -> Array:
        """Of the joints (nv,) under a force along each row (nc,)."""
        push = self.J_c.T @ force
        if self.G is None:
            return np.asarray(pin.aba(self.model, self.data, self.q, self.v, push))
        push = push - pin.nonLinearEffects(self.model, self.data, self.q, self.v)
        return np.asarray(self.G @ np.linalg.solve(self.G.T @ self.H @ self.G, self.G.T @ push))

    def step(self, a: Array, h: float) -> None:
        """Go on for h seconds with an acceleration."""
        self.v = self.v + h * a
        self.q = pin.integrate(self.model, self.q, h * self.v)


def land(robot: Stepper, arm: Array, tau: float, per_fastest: float = 2.0) -> tuple[Array, Array]:
    """Simulate a landing with e = 0 on a viscous pad.

    Args:
        robot: what lands.
        arm: what the pad counts for in each row (nc,).
        tau: the heaviest effective mass comes to rest as e^(−t/τ) [s].
        per_fastest: steps in the time constant of the fastest row; below 0.5 the integration is unstable.

    Returns: posture (nq,) and joint velocities (nv,) after it, these NaN if the simulation ran away.

    Raises:
        Unsuited: it takes more than `MOST_STEPS` steps.
    """
    robot.begin()
    root = np.sqrt(arm)
    gives = np.linalg.eigvalsh(root[:, None] * robot.mobility() * root)
    slowest = gives[gives > 1e-10 * gives[-1]][0]
    damping, h = arm / (slowest * tau), tau * slowest / gives[-1] / per_fastest
    steps = int(np.ceil(REST * tau / h))
    if steps > MOST_STEPS:
        raise Unsuited(f"{steps} steps of {h:.1e} s are too many to simulate; the limit is {MOST_STEPS}")
    for _ in range(steps):
        robot.assemble()
        robot.step(robot.acceleration(-damping * robot.speed(robot.v)), h)
        if not np.abs(h * robot.v).max() < 1e3:
            return robot.q, np.full(len(robot.v), np.nan)
    return robot.q, robot.v


def _arm(system: System) -> Array:
    """What a pad counts for in each row (nc,): one that holds a rotation feels it at an arm of a tenth of a metre."""
    turns = ~np.any(system.landing.rows.W[0][..., 3:], axis=(1, 2))
    return np.where(turns, 0.1**2, 1.0)


def _restitution(system: System) -> float:
    """The one restitution of all rows.

    Raises:
        Unsuited: they differ, or a loop would have to bounce with the contacts.
    """
    e = {block.restitution for block in system.landing.rows.blocks}
    if len(e) > 1:
        raise Unsuited("a glued contact stands for one restitution only")
    return e.pop()


def _on_viscous_pad(tau: float, per_fastest: int) -> Method:
    """The landing on a viscous pad of one time constant, with so many steps in that of the fastest row."""

    def prepare(system: System) -> Prepared:
        restitution, arm = _restitution(system), _arm(system)
        robot = Stepper(system, restitution)
        start = moving(system, system.landing.q, robot.before)

        def run() -> Any:
            return moving(system, *land(robot, arm, tau, per_fastest))

        def read(end: Any) -> Array:
            return (1.0 + restitution) * jumps_between(system, start, end)

        return Prepared(run, read)

    name = f"simulated on ABA, τ = {tau:.0e} s, {per_fastest} steps in the shortest τ"
    return Method(name, "viscous contact, semi-implicit Euler", prepare, "simulation")


SIMULATED = tuple(_on_viscous_pad(tau, per_fastest) for per_fastest in (2, 10) for tau in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6))
"""From a foam mat to something harder than any ground, in long steps and in short ones."""
