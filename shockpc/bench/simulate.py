"""Landing by simulation, what people do today: a stiff contact, and time in small steps on Pinocchio's articulated-body algorithm.

The feet are glued to the ground by pads of one stiffness and one damping in all directions; gravity is on. The pad is as hard as
one likes: the harder, the shorter the impact and the less the robot moves meanwhile, and in the limit its change of velocity is
that of the impulsive equation with e = 0. (Where all contacts share a restitution, that is one factor 1 + e.) But the direction
with the least mass behind it sets the length of a step, and the one with the most sets the length of the impact, so the number of
steps grows with the quotient of the two.
"""

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.bench.methods import Method, Prepared
from shockpc.bench.system import System, Unsuited, assembler, bodies_from, columns_along, velocity_at_impact
from shockpc.core.spatial import Array

__all__ = ["MOST_STEPS", "SIMULATED", "Landing", "Pad", "heaviest_mass", "land", "spring", "viscous"]

MOST_STEPS = 60_000
"""A simulation that needs more is not begun."""


class Pad(NamedTuple):
    """What lies between the robot and the ground: a force −k x − c v along each row.

    Attributes:
        stiffness: k [N/m].
        damping: c [N s/m].
        duration: until the contact is at rest [s].
    """

    stiffness: float
    damping: float
    duration: float


class Landing(NamedTuple):
    """How a simulated landing went.

    Attributes:
        delta: (nv,) change of the joint velocities; NaN if the simulation ran away.
        steps: taken.
        travel: largest way that a row was pushed in [m].
        rest: largest speed left along the rows, relative to the approach [1].
    """

    delta: Array
    steps: int
    travel: float
    rest: float


def viscous(mass: float, tau: float) -> Pad:
    """A pad without a spring, on which a mass comes to rest as e^(−t/τ)."""
    return Pad(0.0, mass / tau, 15.0 * tau)


def spring(mass: float, stiffness: float) -> Pad:
    """A spring with a damper that is critical for a mass; lighter directions are damped more. Duration: 12 √(m/k)."""
    return Pad(stiffness, 2.0 * float(np.sqrt(stiffness * mass)), 12.0 * float(np.sqrt(mass / stiffness)))


def heaviest_mass(system: System) -> float:
    """The largest effective mass of any combination of the rows, 1 / λ_min(J H⁻¹ Jᵀ) over what can move at all [kg]."""
    data = system.model.createData()
    H, J_c = assembler(system, data)(system.setting.q)
    if system.G is not None:
        H, J_c = system.G.T @ H @ system.G, J_c @ system.G
    arm = _by_row(system, Pad(0.0, 1.0, 0.0))[0]
    root = np.sqrt(arm)[:, None] * J_c
    gives = np.linalg.eigvalsh(root @ np.linalg.solve(H, root.T))
    return float(1.0 / gives[gives > 1e-10 * gives[-1]][0])


def land(system: System, pad: Pad, per_fastest: float = 2.0) -> Landing:
    """Simulate a landing with e = 0, by semi-implicit Euler.

    Args:
        system: what lands.
        pad: on what.
        per_fastest: steps in the time constant of the fastest row, 1 / λ_max(C J H⁻¹ Jᵀ); below 0.5 the integration is unstable.

    Raises:
        Unsuited: it takes more than `MOST_STEPS` steps.
    """
    model, data = system.model, system.model.createData()
    assemble, columns = assembler(system, data), columns_along(system)
    q, G = system.setting.q.copy(), columns(system.setting.q)
    damping, stiffness = _by_row(system, pad)
    H, J_c = assemble(q)
    h = _step(H if G is None else G.T @ H @ G, J_c if G is None else J_c @ G, damping) / per_fastest
    steps = int(np.ceil(pad.duration / h))
    if steps > MOST_STEPS:
        raise Unsuited(f"{steps} steps of {h:.1e} s are too many to simulate; the limit is {MOST_STEPS}")
    before = velocity_at_impact(system) if G is None else G @ np.linalg.lstsq(G, velocity_at_impact(system), rcond=None)[0]
    # What a held base carries along moves the ground instead.
    carried = system.b / (1.0 + _restitution(system)) - J_c @ before
    approach = float(np.abs(system.b).max())
    v, x, travel = before.copy(), np.zeros(len(J_c)), 0.0
    for _ in range(steps):
        H, J_c = assemble(q)
        push = -J_c.T @ (stiffness * x + damping * (J_c @ v + carried))
        if G is None:
            v = v + h * pin.aba(model, data, q, v, push)
        else:
            bias = pin.nonLinearEffects(model, data, q, v)
            G = turned if (turned := columns(q)) is not None else G
            v = v + h * (G @ np.linalg.solve(G.T @ H @ G, G.T @ (push - bias)))
        x = x + h * (J_c @ v + carried)
        if not np.abs(x).max() < 1e3:
            return Landing(np.full(len(v), np.nan), steps, np.inf, np.inf)
        q = pin.integrate(model, q, h * v)
        travel = max(travel, float(np.abs(x).max()))
    return Landing(v - before, steps, travel, float(np.abs(J_c @ v + carried).max()) / approach)


def _by_row(system: System, pad: Pad) -> tuple[Array, Array]:
    """Damping and stiffness of each row (nc,): a row that holds a rotation feels the pad at an arm of a tenth of a metre."""
    W = system.setting.rows.W[0]
    turns = ~np.any(W[..., 3:], axis=(1, 2))
    arm = np.where(turns, 0.1**2, 1.0)
    return pad.damping * arm, pad.stiffness * arm


def _step(H: Array, J_c: Array, damping: Array) -> float:
    """Time constant of the fastest row [s]."""
    root = np.sqrt(damping)[:, None] * J_c
    return float(1.0 / np.linalg.eigvalsh(root @ np.linalg.solve(H, root.T))[-1])


def _restitution(system: System) -> float:
    """The one restitution of all rows.

    Raises:
        Unsuited: they differ, or a loop would have to bounce with the contacts.
    """
    e = {block.restitution for block in system.setting.rows.blocks}
    if len(e) > 1:
        raise Unsuited("a glued contact stands for one restitution only")
    return e.pop()


def _on_viscous_pad(tau: float) -> Method:
    """The landing on a viscous pad of one time constant."""

    def prepare(system: System) -> Prepared:
        factor, pad = 1.0 + _restitution(system), viscous(heaviest_mass(system), tau)
        model, data = system.model, system.model.createData()

        def run() -> Any:
            delta = factor * land(system, pad).delta
            if np.all(np.isfinite(delta)):
                pin.forwardKinematics(model, data, system.setting.q, delta)
            return delta

        def read(delta: Any) -> Array:
            good = np.all(np.isfinite(delta))
            return bodies_from(system, data.v) if good else np.full((len(system.robot.bodies), 6), np.nan)

        return Prepared(run, read)

    return Method(f"simulated on ABA, τ = {tau:.0e} s", "viscous contact, semi-implicit Euler", prepare, "simulation")


SIMULATED = tuple(_on_viscous_pad(tau) for tau in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6))
"""From a foam mat to something harder than any ground."""
