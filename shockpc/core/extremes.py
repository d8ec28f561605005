"""The least and the greatest shock over the bodies' geometry.

Geometry is a union of convex pieces, each the convex hull of some points, rounded by a radius (a sphere is one point with a
radius, a capsule two). |Δv(r)| is a convex function, so its greatest value is that of one of the points; its least value follows
from the distance between the screw axis and the projected hull. All pieces of all bodies are evaluated at once.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, cross_matrix

__all__ = ["Pieces", "greatest_shock", "shock_extremes"]


class Pieces(NamedTuple):
    """Convex pieces of bodies, one after the other.

    Attributes:
        points: (k, 3) points that span the pieces, each in its body's frame [m].
        start: (n,) where each piece's points begin; every piece has at least one.
        radius: (n,) rounding of each hull [m].
        body: (n,) index of the body each piece belongs to, ascending.
        piece: (k,) the piece each point belongs to.
    """

    points: Array
    start: np.ndarray
    radius: Array
    body: np.ndarray
    piece: np.ndarray

    @staticmethod
    def of(bodies: list[list[tuple[Array, float]]]) -> "Pieces":
        """Join the pieces of all bodies. Args: bodies, for each of them a list of (points (k, 3), radius) [m]."""
        hulls = [(i, points, radius) for i, own in enumerate(bodies) for points, radius in own]
        counts = np.array([len(points) for _, points, _ in hulls], dtype=int)
        return Pieces(
            np.concatenate([np.zeros((0, 3)), *(points for _, points, _ in hulls)]),
            np.cumsum(counts) - counts,
            np.array([radius for *_, radius in hulls], dtype=float),
            np.array([i for i, *_ in hulls], dtype=int),
            np.repeat(np.arange(len(hulls)), counts),
        )


def shock_extremes(delta_omega: Array, delta_v: Array, pieces: Pieces, v_in: float) -> tuple[Array, Array]:
    """Compute the least and greatest |Δv + Δω × r| / v_in over every body, exact for rounded hulls.

    The velocity is the sum of a part along ω, which is the same everywhere, and a part perpendicular to it, whose magnitude is |ω|
    times the distance from the screw axis. The perpendicular parts over a hull fill a convex polygon: its farthest point from the
    origin is a corner, its nearest lies on an edge, or is the origin itself if the polygon contains it.

    Args:
        delta_omega: (nb, 3) jump of angular velocity, body axes [rad/s].
        delta_v: (nb, 3) jump of velocity of the body frame's origin, body axes [m/s].
        pieces: the pieces of the bodies.
        v_in: speed of the strike [m/s].

    Returns: least (nb,), greatest (nb,) [1]; NaN for a body without pieces, and where an input is NaN.
    """
    spin = np.linalg.norm(delta_omega, axis=-1)
    # A body that does not rotate has the same velocity everywhere, so any axis will do.
    axis = np.where(spin[:, None] == 0.0, [0.0, 0.0, 1.0], delta_omega / np.where(spin == 0.0, 1.0, spin)[:, None])
    e1 = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=-1)])
    e1 /= np.linalg.norm(e1, axis=-1, keepdims=True)
    e = np.stack([e1, np.cross(axis, e1)], axis=1)
    # e · (Δv + Δω × r) = e · Δv + (e × Δω) · r, point by point in columns.
    offset, turning = (e @ delta_v[..., None])[..., 0], np.cross(e, delta_omega[:, None, :])
    body, points = pieces.body[pieces.piece], pieces.points
    perpendicular = np.array([offset[:, k][body] + sum(turning[:, k, i][body] * points[:, i] for i in range(3)) for k in range(2)])
    along = np.sum(axis * delta_v, axis=-1)[pieces.body]
    reach = spin[pieces.body] * pieces.radius
    nearest = np.maximum(0.0, _distances(perpendicular, pieces) - reach)
    farthest = np.sqrt(np.maximum.reduceat(_dot(perpendicular, perpendicular), pieces.start)) + reach
    least, greatest = np.full(len(spin), np.nan), np.full(len(spin), np.nan)
    whose, first = np.unique(pieces.body, return_index=True)
    least[whose] = np.minimum.reduceat(np.hypot(nearest, along), first) / v_in
    greatest[whose] = np.maximum.reduceat(np.hypot(farthest, along), first) / v_in
    return least, greatest


def greatest_shock(delta_omega: Array, delta_v: Array, pieces: Pieces) -> Array:
    """The greatest |Δv + Δω × r| over one body in many landings [m/s], as in `shock_extremes`.

    Args:
        delta_omega: (..., 3) jumps of angular velocity, body axes [rad/s].
        delta_v: (..., 3) jumps of velocity of the body frame's origin [m/s].
        pieces: of this body alone.

    Returns: (...); NaN without pieces.
    """
    omega, v = delta_omega.reshape(-1, 3), delta_v.reshape(-1, 3)
    greatest = np.full(len(omega), np.nan)
    together = max(1, 1_000_000 // max(len(pieces.points), 1))
    for k in range(0, len(omega) if len(pieces.points) else 0, together):
        part = slice(k, k + together)
        jump = v[part, :, None] + cross_matrix(omega[part]) @ pieces.points.T
        squared = np.maximum.reduceat(np.sum(jump * jump, axis=1), pieces.start, axis=1)
        spin = np.linalg.norm(omega[part], axis=-1, keepdims=True)
        along = np.sum(omega[part] * v[part], axis=-1, keepdims=True) / np.where(spin > 0.0, spin, 1.0)
        reach = np.sqrt(np.maximum(squared - along**2, 0.0)) + spin * pieces.radius
        greatest[part] = np.hypot(reach, along).max(axis=1)
    return greatest.reshape(delta_omega.shape[:-1])


def _distances(p: Array, pieces: Pieces) -> Array:
    """Distance (n,) of the origin from the convex hull of every piece's points p (2, k); 0 inside, NaN where one is not finite.

    The origin is inside unless all points, seen from it, lie within less than half a turn. Outside, the algorithm is Wolfe's (1976)
    in the plane: take the corner with the least component along the nearest point so far, and continue with the nearer of the two
    segments from the ends of the present edge to it. Every step reduces the distance, and the number of segments is finite.
    """
    start, piece = pieces.start, pieces.piece
    undefined = ~np.isfinite(np.add.reduceat(_dot(p, p), start))
    p = np.where(undefined[piece], 0.0, p)
    corner = p[:, _lowest(_dot(p, p), pieces)]
    x, y = corner[0][piece], corner[1][piece]
    angle = np.arctan2(x * p[1] - y * p[0], x * p[0] + y * p[1])
    outside = np.maximum.reduceat(angle, start) - np.minimum.reduceat(angle, start) < np.pi
    a = b = nearest = np.where(outside, corner, 0.0)
    while True:
        corner = p[:, _lowest(nearest[0][piece] * p[0] + nearest[1][piece] * p[1], pieces)]
        near_a, near_b = _nearest_on_segments(a, corner), _nearest_on_segments(b, corner)
        from_a = _dot(near_a, near_a) <= _dot(near_b, near_b)
        following = np.where(from_a, near_a, near_b)
        closer = _dot(following, following) < _dot(nearest, nearest)
        if not closer.any():
            return np.where(undefined, np.nan, np.sqrt(_dot(nearest, nearest)))
        a = np.where(closer & ~from_a, b, a)
        b, nearest = np.where(closer, corner, b), np.where(closer, following, nearest)


def _dot(a: Array, b: Array) -> Array:
    """Scalar products (n,) of the columns of a and b (2, n)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1])


def _lowest(values: Array, pieces: Pieces) -> np.ndarray:
    """Index (n,) of each piece's first point with its least value (k,)."""
    hits = np.flatnonzero(values == np.minimum.reduceat(values, pieces.start)[pieces.piece])
    return np.asarray(hits[np.searchsorted(hits, pieces.start)])


def _nearest_on_segments(a: Array, b: Array) -> Array:
    """The points of the segments a–b nearest to the origin, all (2, n)."""
    towards = b - a
    squared = _dot(towards, towards)
    t = np.clip(-_dot(towards, a) / np.where(squared > 0.0, squared, 1.0), 0.0, 1.0)
    return np.asarray(a + t * towards)
