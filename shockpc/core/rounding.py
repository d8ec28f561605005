"""What rounding may have done to a mechanism's numbers before they are solved with: random changes of that size.

Placements are products of rotations and translations, so every number that is not exact by nature (a zero, a one) carries an
absolute error: a few units of rounding in a direction, the same times the size of the mechanism in a position.
"""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.tree import Tree

__all__ = ["UNITS", "shaken_inertia", "shaken_jacobian", "shaken_rows", "shaken_tree", "units_of"]

UNITS = 4.0 * float(np.finfo(float).eps)
"""Size of the changes at least: a few units in the last place of a number near one."""


def units_of(rotation: Array) -> float:
    """Size of the changes [1]: what the placements (n, 3, 3) lack to rotations shows how far rounding has added up on the way."""
    lack = np.swapaxes(rotation, -1, -2) @ rotation - np.eye(3)
    return max(UNITS, float(np.abs(lack).max()))


def _noise(draw: np.random.Generator, units: float, values: Array) -> Array:
    return draw.uniform(-units, units, values.shape)


def _directions(draw: np.random.Generator, units: float, values: Array) -> Array:
    """Parts of unit vectors, changed where they are neither zero nor one."""
    exact = (values == 0.0) | (np.abs(values) == 1.0)
    return np.where(exact, values, values + _noise(draw, units, values))


def _positions(draw: np.random.Generator, units: float, values: Array, size: float) -> Array:
    """Coordinates, changed by the size of the mechanism times rounding where they are not zero."""
    return np.where(values == 0.0, values, values + size * _noise(draw, units, values))


def shaken_tree(draw: np.random.Generator, units: float, tree: Tree, size: float) -> Tree:
    """A mechanism as another order of the same arithmetic might have left it. Args: size of the mechanism [m]."""
    largest = np.abs(tree.inertia).max(axis=(1, 2), keepdims=True)
    wobble = np.where(tree.inertia == 0.0, 0.0, largest * _noise(draw, units, tree.inertia))
    return tree._replace(
        mass=tree.mass * (1.0 + _noise(draw, units, tree.mass)),
        com=_positions(draw, units, tree.com, size),
        inertia=tree.inertia + 0.5 * (wobble + np.swapaxes(wobble, 1, 2)),
        joint=_positions(draw, units, tree.joint, size),
        S=_directions(draw, units, tree.S),
    )


def shaken_rows(draw: np.random.Generator, units: float, W: Array, size: float) -> Array:
    """Rows (..., 6) of moment and force, changed likewise."""
    return np.concatenate([_positions(draw, units, W[..., :3], size), _directions(draw, units, W[..., 3:])], axis=-1)


def shaken_jacobian(draw: np.random.Generator, units: float, J: Array, size: float) -> Array:
    """Twists (..., 6, nv), angular part first, changed likewise."""
    return np.concatenate([_directions(draw, units, J[..., :3, :]), _positions(draw, units, J[..., 3:, :], size)], axis=-2)


def shaken_inertia(draw: np.random.Generator, units: float, H: Array, terms: Array) -> Array:
    """A joint-space inertia (..., nv, nv), changed by rounding of the terms that its entries are sums of.

    Args:
        draw: of random numbers.
        units: size of the changes.
        H: the inertia.
        terms: (nv,) size of the terms of its diagonal; they may be far larger than what is left of them.
    """
    d = np.sqrt(np.maximum(np.abs(np.diagonal(H, axis1=-2, axis2=-1)), terms))
    wobble = np.where(H == 0.0, 0.0, d[..., :, None] * d[..., None, :] * _noise(draw, units, H))
    upper = np.triu(wobble)
    return H + upper + np.swapaxes(np.triu(upper, 1), -1, -2)
