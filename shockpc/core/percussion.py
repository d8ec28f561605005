"""Step 3: reduce a body's jump in velocity to its centre and radius of percussion (shock paper, Eqs. 2, 11 and 12).

Works in any axes, as long as velocities, points and the plane's normal are written in the same ones. All arrays may carry leading
axes.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, velocity_at

__all__ = ["Percussion", "off_plane_share", "percussion", "shock_at"]


class Percussion(NamedTuple):
    """Where a body feels nothing, and how fast shock grows from there.

    Attributes:
        copc: (..., 3) centre of percussion from the body frame's origin, in the plane through that origin [m]; NaN if the
            body only translates.
        ropc: (...) radius of percussion, the distance from the centre at which shock equals the strike [m]; inf if it only
            translates.
        translates: (...) True where rotation in the plane is no larger than rounding, so that no point is at rest.
        pitch: (...) pitch of the spatial screw, ω·v / |ω|² [m/rad]; NaN if the body does not rotate at all.
    """

    copc: Array
    ropc: Array
    translates: np.ndarray
    pitch: Array


def percussion(
    delta_omega: Array,
    delta_v: Array,
    normal: Array,
    v_in: float | Array,
    length: float | Array,
    tolerance: float | Array,
    turn_error: float | Array = 0.0,
) -> Percussion:
    """The planar centre p = n × Δv / (n·Δω) and radius r_p = |v_in| / |n·Δω|.

    A body translates when its rotation moves no point within `length` by more than `tolerance` of v_in or of its own velocity, or
    is no larger than its own error: in double precision that is how a pure translation looks, never an exact zero.

    Args:
        delta_omega: (..., 3) jump of angular velocity [rad/s].
        delta_v: (..., 3) jump of velocity of the body frame's origin [m/s].
        normal: (..., 3) unit normal of the plane.
        v_in: speed of the strike [m/s], above zero.
        length: size of the robot [m], above zero.
        tolerance: relative size of rounding in the velocities [1].
        turn_error: error of the jump of angular velocity [rad/s].
    """
    turn = np.sum(delta_omega * normal, axis=-1)
    spin = np.linalg.norm(delta_omega, axis=-1)
    floor = np.maximum(tolerance * np.maximum(v_in, np.linalg.norm(delta_v, axis=-1)) / length, turn_error)
    translates = np.abs(turn) <= floor
    still = spin <= floor
    safe_turn = np.where(translates, 1.0, turn)
    copc = np.where(translates[..., None], np.nan, np.cross(normal, delta_v) / safe_turn[..., None])
    ropc = np.where(translates, np.inf, v_in / np.abs(safe_turn))
    safe_spin = np.where(still, 1.0, spin)
    pitch = np.where(still, np.nan, np.sum(delta_omega * delta_v, axis=-1) / safe_spin**2)
    return Percussion(copc, ropc, translates, pitch)


def shock_at(delta_omega: Array, delta_v: Array, r: Array, v_in: float | Array) -> Array:
    """Normalised shock at a point, |Δv + Δω × r| / v_in; in the plane it equals |r − p| / r_p (Eq. 2).

    Unlike p and r_p it stays exact however little the body rotates.

    Args:
        delta_omega: (..., 3) jump of angular velocity [rad/s].
        delta_v: (..., 3) jump of velocity of the body frame's origin [m/s].
        r: (..., 3) point from that origin [m].
        v_in: speed of the strike [m/s].
    """
    return np.asarray(np.linalg.norm(velocity_at(delta_omega, delta_v, r), axis=-1) / v_in)


def off_plane_share(delta_omega: Array, v_com: Array, normal: Array, gyration: Array) -> Array:
    """How much of a body's jump a planar picture cannot show: 0 all in the plane, 1 all across it.

    The larger of the share of the translation across the plane and the share of the rotation about axes in the plane, both
    measured as velocities (rotation times radius of gyration), so that the rounding of a part that vanishes never counts as a
    share of its own.

    Args:
        delta_omega: (..., 3) jump of angular velocity [rad/s].
        v_com: (..., 3) jump of velocity of the centre of mass [m/s].
        normal: (..., 3) unit normal of the plane.
        gyration: (...) radius of gyration of the body about its centre of mass [m].
    """
    rotation = gyration * np.linalg.norm(delta_omega, axis=-1)
    translation = np.linalg.norm(v_com, axis=-1)
    turn = np.sum(delta_omega * normal, axis=-1)
    rotation_off = gyration * np.linalg.norm(delta_omega - normal * turn[..., None], axis=-1)
    translation_off = np.abs(np.sum(v_com * normal, axis=-1))
    size = np.maximum(rotation, translation)
    return np.where(size > 0.0, np.maximum(rotation_off, translation_off) / np.where(size > 0.0, size, 1.0), 0.0)
