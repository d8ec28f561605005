"""Step 3: the shock at a point (shock paper, Eq. 2), and how far the jump of a body is planar.

Works in any axes, as long as velocities, points and the plane's normal are written in the same
ones. Arrays may carry leading axes, and may hold doubles or balls (`exact`): the formulas are the
same.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from shockpc.core.spatial import Array, velocity_at


def dot(a: Any, b: Any) -> Any:
    """Scalar products (...) of vectors (..., 3)."""
    return np.sum(a * b, axis=-1)


def norm(a: Any) -> Any:
    """Lengths (...) of vectors (..., 3)."""
    squares = np.asarray(dot(a, a))
    if squares.dtype != object:
        return np.sqrt(squares)
    # A ball around a sum of squares may reach below zero; the sum does not.
    return _each(lambda x: x.nonnegative_part().sqrt(), squares)


def larger(a: Any, b: Any) -> Any:
    """The larger of two arrays (...), entry by entry."""
    if np.asarray(a).dtype == object:
        return _each(lambda x, y: x.max(y), a, b)
    return np.maximum(a, b)


def _each(function: Callable[..., Any], *arrays: Any) -> Any:
    """A function of balls or symbols, entry by entry."""
    return np.asarray(np.frompyfunc(function, len(arrays), 1)(*arrays), dtype=object)


def translation(
    delta_omega: Array, delta_v: Array, normal: Array, v_in: float, length: float, tolerance: float
) -> tuple[Any, Any]:
    """Masks of the bodies that only translate in the plane, and of those that do not rotate.

    A body translates when its rotation moves no point within `length` by more than `tolerance` of
    v_in or of the body's velocity: files give angles and lengths with ten digits or so, and their
    rounding rotates bodies by as much.

    Args:
        delta_omega: (nb, 3) jump of angular velocity [rad/s].
        delta_v: (nb, 3) jump of velocity of the body frame's origin [m/s].
        normal: (nb, 3) unit normal of the plane.
        v_in: speed of the strike [m/s], above zero.
        length: size of the robot [m], above zero.
        tolerance: relative size of rounding in the file's numbers [1].

    Returns: (nb,) and (nb,) of bool.
    """
    floor = tolerance * np.maximum(v_in, np.linalg.norm(delta_v, axis=-1)) / length
    return np.abs(dot(delta_omega, normal)) <= floor, np.linalg.norm(delta_omega, axis=-1) <= floor


def shock_at(delta_omega: Any, delta_v: Any, r: Any, v_in: Any) -> Any:
    """Normalised shock at a point, |Δv + Δω × r| / v_in.

    In the plane it equals |r − p| / r_p (Eq. 2).

    Unlike p and r_p it stays exact however little the body rotates.

    Args:
        delta_omega: (..., 3) jump of angular velocity [rad/s].
        delta_v: (..., 3) jump of velocity of the body frame's origin [m/s].
        r: (..., 3) point from that origin [m].
        v_in: speed of the strike [m/s].
    """
    return norm(velocity_at(delta_omega, delta_v, r)) / v_in


def off_plane_share(
    delta_omega: Any, v_com: Any, normal: Any, gyration: Any, at_rest: Any = 0.0
) -> Any:
    """Share of a body's jump out of the plane: 0 all in the plane or at rest, 1 all across it.

    A planar picture cannot show this part.

    The larger of the share of the translation across the plane and the share of the rotation about
    axes in the plane, both measured as velocities (rotation times radius of gyration), so that the
    rounding of a part that vanishes never counts as a share.

    Args:
        delta_omega: (..., 3) jump of angular velocity [rad/s].
        v_com: (..., 3) jump of velocity of the centre of mass [m/s].
        normal: (..., 3) unit normal of the plane.
        gyration: (...) radius of gyration of the body about its centre of mass [m].
        at_rest: (...) velocity up to which a jump is rounding [m/s].
    """
    in_plane = normal * dot(delta_omega, normal)[..., None]
    rotation_off = gyration * norm(delta_omega - in_plane)
    translation_off = np.abs(dot(v_com, normal))
    size = larger(gyration * norm(delta_omega), norm(v_com))
    moves = np.asarray(size > at_rest, dtype=bool)
    share = larger(rotation_off, translation_off) / np.where(moves, size, 1)
    return np.where(moves, share, 0 * size)
