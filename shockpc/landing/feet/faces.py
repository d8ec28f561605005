"""The part of each sole that carries a landing: all of it, an edge, a corner, or nothing.

Each corner of a sole pushes or leaves the ground, in one problem for all feet of the landing
(`core.corners`). The speed at which the points of a sole leave the ground is an affine function and
not negative, so it is zero on a face of the sole: on all of it (flat), on an edge, on a corner, or
nowhere, if the impact on the other feet lifts it. The rows of this face, held in both directions,
have the same jump. All soles are flat exactly where every centre of pressure lies within its sole.

The face belongs to the inertia of the joints: locked joints, or other rotors, have another.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.corners import CornerImpulse, corner_impulse
from shockpc.core.spatial import Array, cross
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import Constraint, constraint_point, slices_of, world_point
from shockpc.method.dynamics import Dynamics
from shockpc.text.errors import SolveError

STILL = 1e-9
"""Share of the largest speed up to which a corner stays on the ground [1]."""


class Generators(NamedTuple):
    """Impulses along the rows of a landing of flat soles, as `corner_impulse` takes them.

    Attributes:
        free: (nc, p) combinations of rows that act in both directions.
        pushes: (nc, m) of a unit push at each corner.
        contact: (m,) number of the contact that each corner belongs to.
    """

    free: Array
    pushes: Array
    contact: np.ndarray


def carrying_faces(landing: PosedLanding) -> dict[int, np.ndarray]:
    """The numbers of the corners of each sole that carry, by the number of its contact.

    A foot that the impact on the others lifts has none.

    Args:
        landing: its contacts with a `sole` are flat.

    Raises:
        SolveError: the corners that carry are not found.
    """
    soles = {
        number: constraint.sole
        for number, constraint in enumerate(landing.contacts)
        if len(constraint.sole)
    }
    if not soles:
        return {}
    equation = landing.equation(landing.state)
    b = equation.b[0, :, 3]
    try:
        to_metric = np.linalg.cholesky(equation.H[0])
    except np.linalg.LinAlgError:
        # The solution says what is wrong with the inertia.
        return {number: np.arange(len(corners)) for number, corners in soles.items()}
    generators = _generators(landing.state, equation.constraints)
    X = np.linalg.solve(to_metric, equation.J_c[0].T)
    speed = _corner_impulse(X, b, generators.free, generators.pushes).speed
    still = speed <= STILL * np.abs(b).max(initial=0.0)
    return {number: np.flatnonzero(still[generators.contact == number]) for number in soles}


def entering_speeds(landing: PosedLanding, lifted: Sequence[int]) -> list[float]:
    """The largest speeds at which soles enter the ground that the others lift, without them.

    They are shares of the largest speed to be undone [1], below zero where a sole leaves the
    ground.

    Args:
        landing: its contacts with a `sole` are flat.
        lifted: numbers of these contacts, which take no impulse.

    Raises:
        SolveError: the corners that carry are not found.
    """
    equation = landing.equation(landing.state)
    b, rows = equation.b[0, :, 3], slices_of(equation.constraints)
    generators = _generators(landing.state, equation.constraints)
    X = np.linalg.solve(np.linalg.cholesky(equation.H[0]), equation.J_c[0].T)
    numbers = np.arange(len(b))
    of_lifted = np.concatenate([numbers[rows[number]] for number in lifted])
    free = generators.free[:, ~generators.free[of_lifted].any(axis=0)]
    pushes = generators.pushes[:, ~np.isin(generators.contact, lifted)]
    impulse = _corner_impulse(X, b, free, pushes).impulse
    speed = generators.pushes.T @ (X.T @ (X @ impulse) + b)
    speed = speed / np.abs(b).max(initial=0.0)
    largest = []
    for number in lifted:
        of_contact = speed[generators.contact == number]
        largest.append(-float(of_contact.min()))
    return largest


def _corner_impulse(X: Array, b: Array, free: Array, pushes: Array) -> CornerImpulse:
    """As `corner_impulse`.

    Raises:
        SolveError: the search does not end.
    """
    try:
        return corner_impulse(X, b, free, pushes)
    except ArithmeticError as refusal:
        remedy = "say what of the sole carries, by the kind of the contact (--contact-kind)"
        raise SolveError(f"{refusal}; {remedy}") from None


def _generators(state: Dynamics, constraints: Sequence[Constraint]) -> Generators:
    """The generators of a landing. Args: constraints, all rows, those with a `sole` flat."""
    size = sum(constraint.size for constraint in constraints)
    free = [np.zeros((size, 0))]
    pushes = [np.zeros((size, 0))]
    contact: list[int] = []
    for number, (constraint, rows) in enumerate(
        zip(constraints, slices_of(constraints), strict=True)
    ):
        unit = np.eye(size)[:, rows]
        if not len(constraint.sole):
            free.append(unit)
            continue
        of_sole, of_corners = _of_sole(state, constraint)
        free.append(unit @ of_sole)
        pushes.append(unit @ of_corners)
        contact += [number] * len(constraint.sole)
    columns = np.concatenate(free, axis=1), np.concatenate(pushes, axis=1)
    return Generators(*columns, np.array(contact))


def _of_sole(state: Dynamics, constraint: Constraint) -> tuple[Array, Array]:
    """Combinations of a flat sole's rows: (k, p) act in both directions, (k, m) are pushes.

    The pushes are a unit push at each corner.

    Args: the rows are forces, tilts, and a twist if it sticks.
    """
    n = len(constraint.forces)
    unit = np.eye(constraint.size)
    forces, tilts, twist = unit[:, :n], unit[:, n : n + 2], unit[:, n + 2 :]
    corners = world_point(state, constraint.body, constraint.sole[:, None])[:, 0]
    from_point = corners - constraint_point(state, constraint)
    # Forces along the ground: combinations of the forces' axes that are across the normal.
    along_ground = np.linalg.svd((constraint.forces @ constraint.normal)[None])[2][1:]
    # They act on the sole, and the contact's point may lie above that.
    height = from_point.mean(axis=0) @ constraint.normal * constraint.normal
    at_sole = cross(height, along_ground @ constraint.forces) @ constraint.moments[:2].T
    sliding = forces @ along_ground.T + tilts @ at_sole.T
    # A push at a corner is a normal force at the contact's point, and its moment about that.
    normal_force = np.linalg.lstsq(constraint.forces.T, constraint.normal, rcond=None)[0]
    moments = cross(from_point, constraint.normal) @ constraint.moments[:2].T
    pushes = (forces @ normal_force)[:, None] + tilts @ moments.T
    return np.concatenate([sliding, twist], axis=1), pushes
