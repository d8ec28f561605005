"""What the ground does at each contact."""

import numpy as np

from shockpc.core.contact_mass import delassus, effective_masses, impact_mitigation
from shockpc.core.spatial import Array
from shockpc.model.contact import Touch
from shockpc.model.dynamics import Dynamics
from shockpc.model.equation import Solution
from shockpc.model.rows import Rows, point_block, row_jacobian
from shockpc.record import ContactImpulse

__all__ = ["contact_impulses"]


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
    contacts, warnings = [], []
    for touch, own, velocity in zip(touches, rows.slices, approach, strict=False):
        point = state.origin[0] + state.position[0, touch.body] + state.rotation[0, touch.body] @ touch.point
        J = row_jacobian(state, point_block(state, touch.body, touch.point, np.eye(3)))
        A = _gives_way(J, rows, solution, len(touches))
        free, stuck = effective_masses(A, up)
        # With every joint locked only the base's six velocities are left.
        mitigation = impact_mitigation(A, delassus(state.H[0, :6, :6], J[0, :, :6], np.zeros((0, 6)))) if floating else None
        forces = slice(own.start, own.start + len(touch.directions))
        if not solution.impact.unique[0, forces].all():
            contacts.append(ContactImpulse(touch.frame, point, None, None, velocity, stuck, free, mitigation))
            continue
        impulse = solution.impact.impulse[0, forces, -1] @ touch.directions
        normal = float(impulse @ up)
        friction = None
        if normal > 0.0:
            friction = float(np.linalg.norm(impulse - normal * up)) / normal
        elif normal < -1e-12 * float(np.linalg.norm(impulse)):
            warnings.append(
                f'contact "{touch.frame}" would have to be pulled down by {-normal:.3g} N s to keep to the ground; '
                "a real foot lifts off there, so leave that contact out"
            )
        contacts.append(ContactImpulse(touch.frame, point, impulse, friction, velocity, stuck, free, mitigation))
    return tuple(contacts), tuple(warnings)


def _gives_way(J: Array, rows: Rows, solution: Solution, n_touches: int) -> Array:
    """Delassus matrix (3, 3) of one contact point, J (1, 3, nv), while stance and closures hold but the other contacts do not."""
    equation = solution.equation
    first = rows.slices[n_touches - 1].stop
    return delassus(equation.H[0], (J if equation.G is None else J @ equation.G)[0], equation.J_c[0, first:])
