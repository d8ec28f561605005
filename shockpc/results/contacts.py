"""What the ground does at each contact."""

import numpy as np

from shockpc.core.contact_mass import delassus, effective_masses, impact_mitigation
from shockpc.core.spatial import Array
from shockpc.model.contact import Touch
from shockpc.model.dynamics import Dynamics
from shockpc.model.equation import Solution
from shockpc.model.rows import Rows, point_block, row_jacobian
from shockpc.result import ContactImpulse, StanceImpulse
from shockpc.robot.robot import Robot

__all__ = ["contact_impulses", "stance_impulses", "total_impulse"]


def contact_impulses(
    state: Dynamics, touches: tuple[Touch, ...], rows: Rows, solution: Solution, approach: Array, up: Array, floating: bool
) -> tuple[tuple[ContactImpulse, ...], tuple[str, ...]]:
    """Impulse, needed friction and effective masses at every contact, with a warning where the ground would have to pull.

    Args:
        state: the robot, first posture.
        touches: the contacts; their rows come first.
        rows: what is held.
        solution: for the scene's strike, in the last column.
        approach: (n, 3) velocity of every contact point before the impact [m/s].
        up: (3,) unit normal of the ground.
        floating: whether the base moves freely and nothing stands, without which impact mitigation has no meaning.
    """
    contacts: list[ContactImpulse] = []
    warnings: list[str] = []
    for touch, own, velocity in zip(touches, rows.slices, approach, strict=False):
        point = state.origin[0] + state.position[0, touch.body] + state.rotation[0, touch.body] @ touch.point
        J = row_jacobian(state, point_block(state, touch.body, touch.point, np.eye(3)))
        A = _gives_way(J, rows, solution, len(touches))
        free, stuck = effective_masses(A, up)
        # With every joint locked only the base's six velocities are left.
        mitigation = impact_mitigation(A, delassus(state.H[0, :6, :6], J[0, :, :6], np.zeros((0, 6)))) if floating else None
        forces = slice(own.start, own.start + len(touch.directions))
        found, friction, warning = _impulse(f'contact "{touch.frame}"', solution, forces, touch.directions, up)
        moment = None
        if found is not None and len(touch.turns) and solution.impact.unique[0, own].all():
            moment = solution.impact.impulse[0, forces.stop : own.stop, -1] @ touch.turns
        contacts.append(ContactImpulse(touch.frame, point, found, moment, friction, velocity, stuck, free, mitigation))
        warnings += warning
    return tuple(contacts), tuple(warnings)


def stance_impulses(
    robot: Robot, frames: tuple[str, ...], first: int, state: Dynamics, rows: Rows, solution: Solution, up: Array
) -> tuple[tuple[StanceImpulse, ...], tuple[str, ...]]:
    """Impulse and needed friction at every foot that stands, with a warning where the ground would have to pull.

    Args:
        robot: the robot.
        frames: the feet, in the order of their rows.
        first: index of the first foot's block among the rows.
        state: the robot, first posture.
        rows: what is held.
        solution: for the scene's strike, in the last column.
        up: (3,) unit normal of the ground.
    """
    found: list[StanceImpulse] = []
    warnings: list[str] = []
    for name, own in zip(frames, rows.slices[first:], strict=False):
        frame = robot.frame(name)
        point = state.origin[0] + state.position[0, frame.body] + state.rotation[0, frame.body] @ frame.offset
        impulse, friction, warning = _impulse(f'stance "{name}"', solution, own, np.eye(3), up)
        found.append(StanceImpulse(name, point, impulse, friction))
        warnings += warning
    return tuple(found), tuple(warnings)


def total_impulse(rows: Rows, blocks: int, impulse: Array, com: Array) -> tuple[Array, Array]:
    """Impulse (3,) of the ground on the robot [N s], and its moment (3,) about a point [N m s]; unique where its parts are not.

    Args:
        rows: what is held.
        blocks: how many of its blocks are the ground's.
        impulse: (nc,) along each row [N s].
        com: (3,) the point, from the base [m].
    """
    ground = slice(0, rows.slices[blocks - 1].stop)
    moment, force = np.split(np.einsum("c,cbk->k", impulse[ground], rows.W[0, ground]), 2)
    return force, moment - np.cross(com, force)


def _impulse(
    owner: str, solution: Solution, own: slice, axes: Array, up: Array
) -> tuple[Array | None, float | None, tuple[str, ...]]:
    """Impulse (3,) of some rows along axes (n, 3), the friction it needs, and a warning if it pulls; None where not unique."""
    unique, along = solution.impact.unique[0, own], solution.impact.impulse[0, own, -1]
    rising = np.abs(axes @ up) > 1e-9
    # Where two feet repeat one another along the line between them, what lifts each may still be determined.
    normal = float(along[rising] @ (axes[rising] @ up)) if unique[rising].all() else 0.0
    warning: tuple[str, ...] = ()
    if normal < -1e-12 * float(np.linalg.norm(along)):
        warning = (
            f"{owner} would have to be pulled down by {-normal:.3g} N s to keep to the ground; "
            "a real foot lifts off there, so leave it out",
        )
    if not unique.all():
        return None, None, warning
    impulse = along @ axes
    friction = float(np.linalg.norm(impulse - normal * up)) / normal if normal > 0.0 else None
    return impulse, friction, warning


def _gives_way(J: Array, rows: Rows, solution: Solution, n_touches: int) -> Array:
    """Delassus matrix (3, 3) of one contact point, J (1, 3, nv), while stance and closures hold but the other contacts do not."""
    equation = solution.equation
    first = rows.slices[n_touches - 1].stop
    return delassus(equation.H[0], (J if equation.G is None else J @ equation.G)[0], equation.J_c[0, first:])
