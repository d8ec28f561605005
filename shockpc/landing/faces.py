"""What of each sole carries a landing: all of it, an edge, a corner, or nothing.

Each corner of a sole pushes or leaves the ground, in one problem for all feet of the landing
(`core.corners`). The speed at which the points of a sole leave the ground is an affine function and
not negative, so it is zero on a face of the sole: on all of it (flat), on an edge, on a corner, or
nowhere, if the impact on the other feet lifts it. The rows of this face, held in both directions,
have the same jump. All soles are flat exactly where every centre of pressure lies within its sole.

The face belongs to the inertia of the joints: locked joints, or other rotors, have another.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.corners import corner_impulse
from shockpc.core.spatial import Array, cross
from shockpc.landing.constraints import ConstraintBlock, block_point, slices_of
from shockpc.landing.directions import across
from shockpc.landing.dynamics import Dynamics
from shockpc.landing.landing import PosedLanding
from shockpc.landing.soles import is_thin
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


def carrying_faces(landing: PosedLanding, soles: Mapping[int, Array]) -> dict[int, Array]:
    """The corners (k, 3) of each sole that carry, by the number of its contact [m].

    A foot that the impact on the others lifts has none.

    Args:
        landing: which has these contacts as flat ones.
        soles: their corners (n, 3), from the base, world axes [m].

    Raises:
        SolveError: the corners that carry are not found.
    """
    equation = landing.equation(landing.state)
    b = equation.b[0, :, 3]
    try:
        to_metric = np.linalg.cholesky(equation.H[0])
    except np.linalg.LinAlgError:
        return dict(soles)  # the solution says what is wrong with the inertia
    generators = _generators(landing.state, equation.blocks, soles)
    X = np.linalg.solve(to_metric, equation.J_c[0].T)
    try:
        speed = corner_impulse(X, b, generators.free, generators.pushes).speed
    except ArithmeticError as refusal:
        remedy = "say what of the sole carries, by the kind of the contact (--contact-kind)"
        raise SolveError(f"{refusal}; {remedy}") from None
    still = speed <= STILL * np.abs(b).max(initial=0.0)
    faces = dict[int, Array]()
    for number, corners in soles.items():
        faces[number] = corners[still[generators.contact == number]]
    return faces


def is_whole(face: Array, sole: Array, up: Array) -> bool:
    """Whether a face (k, 3) is all of a sole (n, 3) that has an area. Args: up, (3,) unit normal of the ground."""
    return len(face) == len(sole) and not is_thin(sole @ np.transpose(across(up)))


def ends_of(face: Array) -> tuple[Array, Array]:
    """The two corners (3,) of a face (k, 3) that are farthest apart; a single one twice."""
    apart = np.linalg.norm(face[:, None] - face, axis=2)
    i, j = np.unravel_index(int(apart.argmax()), apart.shape)
    return face[i], face[j]


def _generators(
    state: Dynamics,
    blocks: Sequence[ConstraintBlock],
    soles: Mapping[int, Array],
) -> Generators:
    """The generators of a landing. Args: blocks, all rows; soles, as of `carrying_faces`."""
    rows, size = slices_of(blocks), sum(block.size for block in blocks)
    free, pushes, contact = [np.zeros((size, 0))], [np.zeros((size, 0))], list[int]()
    for number, block in enumerate(blocks):
        of_block = np.eye(size)[:, rows[number]]
        if number not in soles:
            free.append(of_block)
            continue
        n = len(block.forces)
        forces, tilts, twist = of_block[:, :n], of_block[:, n : n + 2], of_block[:, n + 2 :]
        # Forces along the ground: combinations of the forces' axes that are across the normal.
        along_ground = np.linalg.svd((block.forces @ block.normal)[None])[2][1:]
        free += [forces @ along_ground.T, twist]
        # A push at a corner is a force along the normal at the contact's point, and its moment about that.
        normal_force = np.linalg.lstsq(block.forces.T, block.normal, rcond=None)[0]
        arms = soles[number] - block_point(state, block)
        moments = cross(arms, block.normal) @ block.moments[:2].T
        pushes.append((forces @ normal_force)[:, None] + tilts @ moments.T)
        contact += [number] * len(moments)
    columns = np.concatenate(free, axis=1), np.concatenate(pushes, axis=1)
    return Generators(*columns, np.array(contact))
