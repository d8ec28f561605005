"""Shock of a body over the plane of the figure."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.silhouette import to_plane

FITTED = 5000
"""Points of a body, about, to which the surface through its middle is fitted."""

STEEP = 0.01
"""Share of the spread of points that keeps a slope which they determine poorly near zero."""


class Field(NamedTuple):
    """Normalised shock of a body over plane coordinates u [m], |c + A u|.

    c (3,) is in [1], A (3, 2) in [1/m]. The square of the shock is a quadratic form: circles about
    the CoPc if the body moves in the plane. For a body that also moves out of the plane the shock
    depends on depth as well; the field is then that on the surface through its middle.
    """

    c: Array
    A: Array

    def at(self, u: Array) -> Array:
        """Shock (...) at plane coordinates u (..., 2) [1]."""
        return np.asarray(np.linalg.norm(self.c + u @ self.A.T, axis=-1))


def field_of(profile: ShockProfile, body: int, points: Array) -> Field:
    """The field of a body on the plane through the middle of points (n, 3) on it, world axes [m].

    A slope of that plane which the points determine poorly, such as across a thin rod, stays near
    zero.
    """
    plane, v_in = profile.plane, profile.v_in
    middle, slope = _plane_through(profile, points[:: 1 + len(points) // FITTED])

    # |Δv + Δω × (r − p)| / v_in at r = u_1 e1 + u_2 e2 + (middle + slope · u) n.
    omega = profile.rotation[body] @ profile.delta_omega[body]
    v = profile.rotation[body] @ profile.delta_v[body]
    along, up, deeper = np.cross(omega, [plane.e1, plane.e2, plane.normal])
    c = v + middle * deeper - np.cross(omega, profile.position[body])
    A = np.stack([along, up], axis=1) + np.outer(deeper, slope)
    return Field(c / v_in, A / v_in)


def _plane_through(profile: ShockProfile, points: Array) -> tuple[float, Array]:
    """Depth middle + slope · u of a plane through points (n, 3) [m], and its slope (2,) [1].

    Least squares of the depth h over the plane coordinates u.
    """
    u, h = to_plane(points, profile.plane), points @ profile.plane.normal
    off = u - u.mean(axis=0)
    deep = h - h.mean()
    # (Uᵀ U + ridge) slope = Uᵀ h, both from their means.
    spread = off.T @ off
    ridge = STEEP * (np.trace(spread) + deep @ deep) + 1e-12
    slope = np.linalg.solve(spread + ridge * np.eye(2), off.T @ deep)
    return float(h.mean() - slope @ u.mean(axis=0)), slope
