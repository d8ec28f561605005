"""Normalised shock over the plane of the figure, and where it is below a value.

|Δv(s, t)|² = |c + A (s, t)|² is a quadratic form, so what lies below a value is an ellipse: a disc about the CoPc if the body
moves in the plane. For a body that also moves across it, shock depends on depth as well; the field is then the one on the plane
that runs through the middle of the body, along the limb.
"""

import math
from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.spatial import Array, Plane
from shockpc.result import ShockProfile
from shockpc.show.figure.silhouette import Region, to_plane

__all__ = ["Field", "below", "field_of"]


class Field(NamedTuple):
    """Shock over plane coordinates: |c + A (u − origin)|.

    Attributes:
        origin: (2,) of the body's frame in plane coordinates [m].
        c: (3,) Δv of that origin over v_in [1].
        A: (3, 2) how it changes along e1 and e2 [1/m].
    """

    origin: Array
    c: Array
    A: Array

    def at(self, u: Array) -> Array:
        """Shock (...) at plane coordinates u (..., 2) [1]."""
        return np.asarray(np.linalg.norm(self.c + (u - self.origin) @ self.A.T, axis=-1))


def field_of(profile: ShockProfile, body: int, points: Array | None = None) -> Field:
    """The field of a body on its middle surface.

    Args:
        profile: the shock of a landing.
        body: index.
        points: (n, 3) of the body's surface, world axes [m], to find its middle surface by; without them it is the plane through
            the origin of the body's frame.
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
    """The plane that runs through the middle of points: its depth at the origin [m] and its slope (2,) along e1 and e2 [1].

    Least squares of the depth; a slope that the points hardly show, such as across a thin rod, stays near zero.
    """
    u, h = to_plane(points, plane), points @ plane.normal
    off, deep = u - u.mean(axis=0), h - h.mean()
    spread = off.T @ off
    slope = np.linalg.solve(spread + (0.01 * (np.trace(spread) + deep @ deep) + 1e-12) * np.eye(2), off.T @ deep)
    return float(h.mean() - slope @ u.mean(axis=0)), slope


def below(field: Field, value: float, box: tuple[float, float, float, float]) -> Region:
    """Where in a box shock is at most a value: a box and an ellipse are convex, and so is what they share.

    It is the hull of the arcs of the ellipse inside the box and of the box's corners inside the ellipse, so that an ellipse of
    a kilometre is as exact as one of a centimetre.

    Args:
        field: of a body.
        value: [1]; infinity gives the box.
        box: x and y of its lower left and of its upper right corner [m].
    """
    low, high = np.array(box[:2]), np.array(box[2:])
    middle, half = (low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    c = field.c + field.A @ (middle - field.origin)
    A = field.A * half
    moments, axes = np.linalg.eigh(A.T @ A)
    if math.isinf(value) or moments[1] <= (1e-9 * np.linalg.norm(c)) ** 2:
        return shapely.Polygon(corners) if np.linalg.norm(c) <= value else shapely.Polygon()
    # A body that turns about an axis in the plane alone has parallel lines for levels; ever longer ellipses come to the same.
    moments = np.maximum(moments, 1e-12 * moments[1])
    slope = axes.T @ (A.T @ c)
    centre = -slope / moments
    rest = float(c @ c - slope @ (slope / moments))
    squared = value**2 - max(rest, 0.0)
    if squared <= 0.0:
        return shapely.Polygon()
    reach = math.sqrt(squared) / np.sqrt(moments)

    corner = (((corners - middle) / half) @ axes - centre) / reach
    angles = _arcs(corner)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    inside = corners[np.linalg.norm(corner, axis=1) <= 1.0]
    arcs = middle + half * ((centre + reach * circle) @ axes.T)
    return shapely.MultiPoint(np.concatenate([arcs, inside])).convex_hull if len(arcs) + len(inside) else shapely.Polygon()


def _arcs(corner: Array) -> Array:
    """Angles along the arcs of the unit circle that lie inside a convex quadrilateral.

    Args:
        corner: (4, 2) corners in order.
    """
    side = np.roll(corner, -1, axis=0) - corner
    outward = np.stack([side[:, 1], -side[:, 0]], axis=1)
    outward *= np.sign(side[0, 0] * side[1, 1] - side[0, 1] * side[1, 0])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    distance = np.sum(outward * corner, axis=1)
    crossed = np.abs(distance) < 1.0
    direction = np.arctan2(outward[:, 1], outward[:, 0])[crossed]
    spread = np.arccos(distance[crossed])
    breaks = np.sort(np.mod(np.concatenate([direction - spread, direction + spread]), 2.0 * math.pi))
    if not len(breaks):
        breaks = np.array([0.0])
    following = np.append(breaks[1:], breaks[0] + 2.0 * math.pi)
    halfway = (breaks + following) / 2.0
    inside = np.all(np.stack([np.cos(halfway), np.sin(halfway)], axis=1) @ outward.T <= distance, axis=1)
    pairs = list(zip(breaks[inside], following[inside], strict=True))
    return np.concatenate([np.linspace(a, b, 192) for a, b in pairs]) if pairs else np.empty(0)
