"""The same landing with free, modelled and locked joints: the choice that changes the answer most."""

from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import RowChoice, solve_impact
from shockpc.core.percussion import norm
from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.exact.balls import balls, nearest
from shockpc.exact.equation import SingularError
from shockpc.exact.proof import Enclosure, Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.model.columns import free_columns
from shockpc.model.dynamics import dynamics
from shockpc.model.equation import impulsive_equation
from shockpc.model.rows import row_jacobian
from shockpc.results.points import spots
from shockpc.results.proof import UNPHYSICAL, greatest_motion
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
    free = as_modelled if landing.joint_model.name == "free" else _variant(landing, as_modelled, np.zeros_like(every))
    locked = as_modelled if landing.joint_model.name == "locked" else _variant(landing, as_modelled, every)
    heaviest = int(np.argmax(robot.masses))
    places = [(robot.bodies[heaviest].name, heaviest, robot.coms[heaviest])]
    places += [(spot.label, spot.frame.body, spot.r) for spot in spots(robot, landing.scene.point) if spot.frame.body >= 0]
    bodies, r = [body for _, body, _ in places], np.array([point for *_, point in places])
    shocks = [_shocks(enclosure, landing, bodies, r, v_in) for enclosure in (free, as_modelled, locked)]
    return tuple(Bracket(name, *found) for (name, *_), found in zip(places, zip(*shocks, strict=True), strict=True))


def _variant(landing: Landing, enclosure: Enclosure, locked: np.ndarray) -> Enclosure | None:
    """The landing without reflected inertia and with other joints locked; None where that cannot be solved, or not reliably."""
    state, blocks = dynamics(landing.robot, landing.q[None]), enclosure.inputs.blocks
    try:
        G = free_columns(landing.robot, landing.base, landing.plane, state.rotation[:, 0], locked)
    except SceneError:
        return None
    b = landing.approach(state, blocks)
    equation = impulsive_equation(state, blocks, b, G)
    impact = solve_impact(equation.inertia, equation.J_c, b, equation.terms)
    choice = impact.choices.get(0, RowChoice.every(b.shape[1]))
    if choice.uncertain:
        return None
    changed = enclosure.inputs._replace(armature=np.zeros(len(locked)), locked=locked, choice=choice)
    found = Enclosure(changed)
    try:
        delta = found.read(lambda impact: np.array([float(row[3]) for row in impact.delta_qd]))
        jumps = found.read(lambda impact: np.array([[float(x) for x in jump] for jump in impact.body_jumps[..., 3]]))
    except SingularError:
        return None
    left = np.abs(row_jacobian(state, blocks)[0] @ delta + b[0, :, 3])
    singular = greatest_motion(landing, jumps)[0] > UNPHYSICAL
    return found if left.max() <= 1e-6 * np.abs(b[0, :, 3]).max() and not singular else None


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
