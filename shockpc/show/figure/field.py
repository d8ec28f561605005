"""Normalised shock over the plane of the figure, and the region where it is below a value.

|Δv(s, t)|² is a quadratic form of the plane coordinates: circles about the CoPc if the body moves in the plane. For a body that
also moves out of the plane the shock depends on depth as well; the field is then that on the surface through its middle.
"""

import math
from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.spatial import Array, Plane
from shockpc.result import ShockProfile
from shockpc.show.figure.silhouette import Region, contoured, to_plane

__all__ = ["Field", "below", "field_of"]

CELLS = 96
"""Cells along a side of the grid on which a field is contoured. The error of a quadratic is a 16 000th of the side."""


class Field(NamedTuple):
    """Shock over plane coordinates u: |c + A (u − origin)|.

    The origin (2,) [m] is that of the body's frame, c (3,) its Δv over v_in [1], A (3, 2) the derivative along e1 and e2 [1/m].
    """

    origin: Array
    c: Array
    A: Array

    def at(self, u: Array) -> Array:
        """Shock (...) at plane coordinates u (..., 2) [1]."""
        return np.asarray(np.linalg.norm(self.c + (u - self.origin) @ self.A.T, axis=-1))


def field_of(profile: ShockProfile, body: int, points: Array | None = None) -> Field:
    """The field of a body on its middle surface.

    Points (n, 3) of the body's surface, world axes [m], determine that surface; without them it is the plane through the origin of
    the body's frame.
    """
    plane = profile.plane
    omega, v = profile.rotation[body] @ profile.delta_omega[body], profile.rotation[body] @ profile.delta_v[body]
    A = np.stack([np.cross(omega, plane.e1), np.cross(omega, plane.e2)], axis=1)
    if points is not None:
        depth, slope = _middle(points - profile.position[body], plane)
        deeper = np.cross(omega, plane.normal)
        v, A = v + depth * deeper, A + np.outer(deeper, slope)
    return Field(to_plane(profile.position[body], plane), v / profile.v_in, A / profile.v_in)


def _middle(points: Array, plane: Plane) -> tuple[float, Array]:
    """The plane through the middle of points: its depth at the origin [m] and its slope (2,) along e1 and e2 [1].

    Least squares of the depth; a slope that the points determine poorly, such as across a thin rod, stays near zero.
    """
    u, h = to_plane(points, plane), points @ plane.normal
    off, deep = u - u.mean(axis=0), h - h.mean()
    spread = off.T @ off
    slope = np.linalg.solve(spread + (0.01 * (np.trace(spread) + deep @ deep) + 1e-12) * np.eye(2), off.T @ deep)
    return float(h.mean() - slope @ u.mean(axis=0)), slope


def below(field: Field, value: float, box: tuple[float, float, float, float]) -> Region:
    """The part of a box where shock is at most a value, from a contour of the squared shock.

    The box is x and y of its lower left and of its upper right corner [m]; an infinite value gives all of it.
    """
    if math.isinf(value):
        return shapely.box(*box)
    x, y = np.linspace(box[0], box[2], CELLS + 1), np.linspace(box[1], box[3], CELLS + 1)
    return contoured(x, y, field.at(np.stack(np.meshgrid(x, y), axis=-1)) ** 2, -1.0, value**2)
