"""The least and the greatest shock over a body's geometry.

Geometry is a union of convex pieces, each the convex hull of some points, rounded by a radius (a sphere is one point with a
radius, a capsule two). |Δv(r)| is convex, so its greatest value lies on the hull; its least is the distance of a projected
convex set from the screw axis.
"""

import numpy as np

from shockpc.core.spatial import Array, velocity_at

__all__ = ["shock_extremes"]


def shock_extremes(delta_omega: Array, delta_v: Array, points: Array, radius: float, v_in: float) -> tuple[float, float]:
    """Least and greatest |Δv + Δω × r| / v_in over one convex piece, exact for the hull of `points` rounded by `radius`.

    The velocity splits into a part along ω, the same everywhere, and a part across it, which is the distance from the screw axis
    times |ω|. Velocities across the axis form a flat convex polygon: its farthest point is a corner, its nearest lies on an edge,
    or is the axis itself if the polygon holds it.

    Args:
        delta_omega: (3,) jump of angular velocity [rad/s].
        delta_v: (3,) jump of velocity of the body frame's origin [m/s].
        points: (k, 3) points whose convex hull is the piece, body frame [m].
        radius: rounding of that hull [m].
        v_in: speed of the strike [m/s].
    """
    spin = float(np.linalg.norm(delta_omega))
    v = velocity_at(delta_omega, delta_v, points)
    if spin == 0.0:
        uniform = float(np.linalg.norm(delta_v)) / v_in
        return uniform, uniform
    axis = delta_omega / spin
    e1 = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    e1 /= np.linalg.norm(e1)
    across = v @ np.stack([e1, np.cross(axis, e1)], axis=1)
    along = float(axis @ delta_v)
    reach = spin * radius
    nearest = max(0.0, _distance_to_hull(across) - reach)
    farthest = float(np.linalg.norm(across, axis=-1).max()) + reach
    return float(np.hypot(nearest, along)) / v_in, float(np.hypot(farthest, along)) / v_in


def _distance_to_hull(p: Array) -> float:
    """Distance of the origin from the convex hull of p (k, 2); 0 inside.

    The origin is inside unless two neighbours in angle are more than half a turn apart. Outside, Wolfe's step in the plane: from
    the nearest point found so far, fetch the corner that lies furthest towards the origin and keep the better of the two edges to
    it; every round comes strictly nearer, and there are finitely many edges.
    """
    angle = np.sort(np.arctan2(p[:, 1], p[:, 0]))
    if np.diff(angle, append=angle[0] + 2 * np.pi).max() <= np.pi:
        return 0.0
    a = b = nearest = p[np.argmin(np.linalg.norm(p, axis=-1))]
    while True:
        corner = p[np.argmin(p @ nearest)]
        near_a, near_b = _nearest_on_segment(a, corner), _nearest_on_segment(b, corner)
        following = min(near_a, near_b, key=np.linalg.norm)
        if not np.linalg.norm(following) < np.linalg.norm(nearest):
            return float(np.linalg.norm(nearest))
        a, b, nearest = (a if following is near_a else b), corner, following


def _nearest_on_segment(a: Array, b: Array) -> Array:
    """The point of the segment a–b nearest to the origin, both (2,)."""
    towards = b - a
    squared = float(towards @ towards)
    t = min(1.0, max(0.0, -float(towards @ a) / squared)) if squared > 0.0 else 0.0
    return np.asarray(a + t * towards)
