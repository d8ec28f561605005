"""Convex pieces of a body: what they are, how far they reach, and their surfaces."""

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, read_only
from shockpc.robot.bodies_and_joints import Body, Frame
from shockpc.robot.shapes.mesh import Mesh, hull

_SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "ellipsoid": 3}
"""The number of sizes of a primitive."""

_SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
_BOX = np.array([side[:1] + side[k : k + 2] for side in _SIDES for k in (1, 2)])
"""Triangles of a box."""

LARGEST_COORDINATE = 1e6
"""Largest coordinate or radius of a shape [m]; more is an error in the file."""


class Shape(NamedTuple):
    """One convex piece of a body, without approximation.

    It is the Minkowski sum of the hull of some points and an ellipsoid.

    A box or a mesh is only the hull. A sphere and an ellipsoid have one point; a capsule and a
    cylinder two, the cylinder with a flat ellipsoid, a disc.

    Attributes:
        link: the link it belongs to.
        points: (k, 3) in the body's frame [m]. For a mesh, points of which it is the hull:
            `outer_vertices`, or all vertices.
        rounding: (3, 3) semi-axes of the ellipsoid in orthogonal columns, in the body's frame [m].
        mesh: the surface itself, where the piece is the hull of something that need not be convex.
        name: of its geom, if the file gives one.
    """

    link: str
    points: Array
    rounding: Array = read_only(np.zeros((3, 3)))
    mesh: Mesh | None = None
    name: str = ""

    def reach(self, directions: Array) -> Array:
        """Return the reach (m,) of the shape along unit vectors (m, 3) [m].

        It is the shape's support function.
        """
        return np.asarray(
            (directions @ self.points.T).max(axis=1)
            + np.linalg.norm(directions @ self.rounding, axis=1)
        )

    def farthest(self, direction: Array) -> Array:
        """Return points (k, 3) [m] among which are the farthest along a unit vector (3,)."""
        along = direction @ self.rounding
        length = float(np.linalg.norm(along))
        # All points of a disc across the direction are equally far, to a part in a million; its
        # centre represents them.
        level = length <= 1e-6 * float(np.abs(self.rounding).max())
        return self.points if level else np.asarray(self.points + self.rounding @ along / length)

    def belongs_to(self, frame: Frame) -> bool:
        """True if it is one of the shapes of this link, or the geom of this name."""
        return frame.name == (self.link if frame.kind == "link" else self.name)

    def placed(self, rotation: Array, offset: Array) -> "Shape":
        """Return the shape in another frame.

        The present frame has this rotation (3, 3) and this origin (3,) [m] in it.
        """
        points = read_only(self.points @ rotation.T + offset)
        mesh = self.mesh and self.mesh._replace(
            vertices=read_only(self.mesh.vertices @ rotation.T + offset)
        )
        return Shape(self.link, points, read_only(rotation @ self.rounding), mesh, self.name)


def primitive(link: str, kind: str, size: Array) -> Shape:
    """A shape around the origin, its axis along z.

    The size is as MuJoCo has it: half the sides or axes, or radius and half length [m].

    Raises:
        ValueError: there is no such shape, or it has too few or negative sizes.
    """
    if len(size) < _SIZES.get(kind, math.inf) or min(size) < 0.0:
        raise ValueError(f"a <{kind}> with these dimensions is not a valid shape")
    if kind == "box":
        signs = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
        return Shape(link, signs * size[:3])
    # points: the centre, or the two ends of the axis of a capsule or cylinder
    points = np.zeros((1, 3))
    if kind in ("capsule", "cylinder"):
        points = np.outer([-1.0, 1.0], [0.0, 0.0, size[1]])
    # rounding: an ellipsoid, a ball, or the disc of a cylinder about each of them
    axes = np.array(size[:3])
    if kind != "ellipsoid":
        axes = size[0] * np.array([1.0, 1.0, float(kind != "cylinder")])
    return Shape(link, points, np.diag(axes))


def checked_shape(shape: Shape) -> Shape:
    """The shape, if it has a size that a robot may have.

    Raises:
        ValueError: it extends too far, or has coordinates that are not finite.
    """
    largest = max(np.abs(shape.points).max(), np.abs(shape.rounding).max())
    if not largest <= LARGEST_COORDINATE:  # nor if it is NaN
        raise ValueError(
            f"it extends beyond {LARGEST_COORDINATE:.0e} m, or has coordinates that are not finite"
        )
    return shape


def inertia_box(body: Body) -> Shape | None:
    """The box of uniform density with the body's mass and inertia; None if there is none.

    It has the sides a_x = sqrt(6 (I_y + I_z − I_x) / m), and likewise a_y and a_z.
    """
    if not body.mass > 0.0:
        return None
    moments, axes = np.linalg.eigh(body.inertia)
    squared = 6.0 * (moments.sum() - 2.0 * moments) / body.mass
    # A plate or a rod has sides of zero, which rounding may make negative.
    if squared.max() <= 0.0 or squared.min() < -1e-9 * squared.max():
        return None
    half = 0.5 * np.sqrt(np.maximum(squared, 0.0))
    return Shape(body.name, read_only(body.com + primitive(body.name, "box", half).points @ axes.T))


class HalfSpaces(NamedTuple):
    """The convex set of the points r with normals · r ≤ offsets.

    Attributes:
        normals: (m, 3) unit vectors, outward.
        offsets: (m,) [m].
    """

    normals: Array
    offsets: Array

    def depth(self, r: Array) -> float:
        """Depth of a point (3,) inside all faces; below zero outside [m]."""
        return float((self.offsets - self.normals @ r).min())


def facets(shape: Shape) -> list[Array]:
    """The surface of a shape, each facet as its corners (k, 3) in the body's frame [m].

    The surface of a mesh is its triangles. A round shape is a polyhedron with its corners on the
    surface, inside it by at most 0.25 % of the largest semi-axis. A flat shape is its surface.
    """
    if shape.mesh is not None:
        return list(shape.mesh.vertices[shape.mesh.triangles])
    points = _corners(shape)
    if not shape.rounding.any() and len(points) == 8:
        edges = points[[1, 2, 4]] - points[0]
        shortest, *_, longest = sorted(np.linalg.norm(edges, axis=1))
        # A box needs no library, whose import takes as long as reading the meshes of a robot.
        if shortest > 1e-6 * longest:
            return list(points[_BOX])
    polyhedron = hull(points)
    return [points] if polyhedron is None else list(points[polyhedron.simplices])


def half_spaces(shape: Shape) -> HalfSpaces | None:
    """The half-spaces of a convex shape.

    None for a mesh, which need not be convex, and for a flat shape, which has no inside.
    """
    polyhedron = None if shape.mesh is not None else hull(_corners(shape))
    if polyhedron is None:
        return None
    faces = np.unique(polyhedron.equations.round(12), axis=0)
    return HalfSpaces(faces[:, :3], -faces[:, 3])


def _corners(shape: Shape) -> Array:
    """Points (k, 3) of the surface whose hull represents the shape."""
    semi, ball = np.linalg.norm(shape.rounding, axis=0), _ball_points()
    if not semi.any():
        return shape.points
    edge = ball[np.all(np.abs(ball[:, semi == 0.0]) < 1e-9, axis=1)]
    return np.asarray((shape.points[:, None] + edge @ shape.rounding.T).reshape(-1, 3))


@functools.cache
def _ball_points() -> Array:
    """Points on the unit sphere.

    They are a circle of 64 at every 32nd part of the half turn, and the poles.
    """
    latitudes = math.pi * (np.arange(1, 32) / 32 - 0.5)
    angles = 2.0 * math.pi * np.arange(64) / 64
    latitude, angle = np.meshgrid(latitudes, angles, indexing="ij")
    x = np.cos(latitude) * np.cos(angle)
    y = np.cos(latitude) * np.sin(angle)
    rings = np.stack([x, y, np.sin(latitude)], axis=-1)
    return np.concatenate([rings.reshape(-1, 3), [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
