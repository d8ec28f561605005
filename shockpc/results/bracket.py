"""The same landing with free, modelled and locked joints: the choice that changes the answer most."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import solve_impact
from shockpc.core.percussion import norm
from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError, SolveError
from shockpc.exact.balls import balls, nearest
from shockpc.exact.proof import Enclosure, Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.model.dynamics import dynamics
from shockpc.model.joint_model import JointModel
from shockpc.results.points import spots
from shockpc.results.proof import proven
from shockpc.results.speed import speed_in

__all__ = ["Bracket", "joint_bracket"]


class Bracket(NamedTuple):
    """The same landing with three models of the joints; shock at one place [1].

    Attributes:
        place: a body (its centre of mass), or a sensor.
        free: no reflected inertia; None if massless bodies then make it unsolvable.
        as_modelled: as the scene says.
        locked: every joint holds; None if the contact could not give way then, or hardly, or rounding would decide whether its
            rows are independent.
    """

    place: str
    free: float | None
    as_modelled: float | None
    locked: float | None


def joint_bracket(landing: Landing, proof: Proof, v_in: float) -> tuple[Bracket, ...]:
    """Shock at the heaviest body's centre of mass and at every sensor and point, for three models of the joints."""
    robot = landing.robot
    every = robot.driven
    as_modelled = proof.enclosure
    free = as_modelled if landing.joint_model.name == "free" else _variant(landing, np.zeros_like(every), "free")
    locked = as_modelled if landing.joint_model.name == "locked" else _variant(landing, every, "locked")
    heaviest = int(np.argmax(robot.masses))
    places = [(robot.bodies[heaviest].name, heaviest, robot.coms[heaviest])]
    places += [(spot.label, spot.frame.body, spot.r) for spot in spots(robot, landing.scene.point) if spot.frame.body >= 0]
    bodies, r = [body for _, body, _ in places], np.array([point for *_, point in places])
    shocks = [_shocks(enclosure, landing, bodies, r, v_in) for enclosure in (free, as_modelled, locked)]
    return tuple(Bracket(name, *found) for (name, *_), found in zip(places, zip(*shocks, strict=True), strict=True))


def _variant(landing: Landing, locked: np.ndarray, name: str) -> Enclosure | None:
    """The landing without reflected inertia and with other joints locked; None where that is refused."""
    joints = JointModel(np.zeros(len(locked)), locked, name)
    changed, state = replace(landing, joint_model=joints), dynamics(landing.robot, landing.q[None])
    try:
        equation = changed.equation(state)
        impact = solve_impact(equation.inertia, equation.J_c, equation.b, equation.terms)
        return proven(changed, equation, impact)[1].enclosure
    except (SceneError, SolveError):
        return None


def _shocks(enclosure: Enclosure | None, landing: Landing, bodies: list[int], r: Array, v_in: float) -> list[float | None]:
    """Shock at points (n, 3) of bodies; None without a solution."""
    if enclosure is None:
        return [None] * len(bodies)

    def read(impact: ExactImpact) -> Array:
        jumps = impact.body_jumps[bodies][..., 3]
        speed = norm(velocity_at(jumps[:, :3], jumps[:, 3:], balls(r)))
        size = np.abs(np.array([[float(x) for x in jump] for jump in jumps])).max(axis=1)
        return nearest(speed / speed_in(impact, landing), size / v_in)

    return [float(shock) for shock in enclosure.read(read)]
