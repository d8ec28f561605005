"""What a body looks like: convex pieces for extremes, triangles for silhouettes, and a box where a body shows nothing.

Loaded only if asked for: no number of the method needs it, and no mesh is read for a body of plain shapes.
"""

import functools
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import coal
import numpy as np

from shockpc.core.extremes import Pieces
from shockpc.core.spatial import Array, read_only
from shockpc.robot.geometry import Geometries, Kind, Piece, read_geometries
from shockpc.robot.meshes import Mesh
from shockpc.robot.robot import Body, Robot

__all__ = ["Outline", "Shape", "inertia_box", "outline"]

RIM = 64
"""Corners of the polygon that stands for a circle: it lies inside, by at most 1 − cos(π/64) = 0.12 % of the radius."""

FLAT = 1e-3
"""A mesh thinner than this share of its width counts as flat."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One convex piece of a body: the hull of some points, rounded by a radius (a sphere is one point, a capsule two).

    Attributes:
        link: the link it belongs to.
        points: (k, 3) in the body's frame [m]. For a mesh, the corners of its convex hull.
        radius: of the rounding [m].
        mesh: the surface itself, where the piece is the hull of something that need not be convex.
        discs: (centre, axis, radius) of the round faces that some of the points only approximate.
    """

    link: str
    points: Array = field(repr=False)
    radius: float = 0.0
    mesh: Mesh | None = field(default=None, repr=False)
    discs: tuple[tuple[Array, Array, float], ...] = field(default=(), repr=False)

    def lowest(self, up: Array) -> Array:
        """Points (k, 3) among which the lowest ones are, exact for round faces too. Args: up (3,), a unit vector, body frame."""
        below = [self.points - self.radius * up]
        for centre, axis, radius in self.discs:
            level = up - axis * float(axis @ up)
            length = float(np.linalg.norm(level))
            # A disc that lies flat is lowest everywhere; its middle stands for it.
            below.append((centre - radius * level / length if length > 1e-9 else centre)[None])
        return np.concatenate(below)


class Outline(NamedTuple):
    """The shapes of a robot.

    Attributes:
        shapes: one tuple for each body, in the order of `robot.bodies`; empty for a body that has no such geometry.
        pieces: the same as points in one array.
        warnings: at most one line, about the shapes that could not be read.
    """

    shapes: tuple[tuple[Shape, ...], ...]
    pieces: Pieces
    warnings: tuple[str, ...]


@functools.lru_cache(maxsize=8)
def outline(robot: Robot, kind: Kind) -> Outline:
    """The shapes of every body, as the robot's file gives them.

    Boxes are exact, and so are spheres and capsules (by their radius); circles become polygons of 64 corners inside
    them, ellipsoids points on their surface (short by at most 0.25 %); meshes keep their triangles beside the
    corners of their hull. A shape that cannot be read is left out and told in the warning. The answers for the last few
    robots are kept.

    Args:
        robot: the robot.
        kind: "collision" or "visual" geometry.
    """
    read = read_geometries(robot, kind)
    shapes: list[list[Shape]] = [[] for _ in robot.bodies]
    hulls: dict[int, Array] = {}
    for piece in read.pieces:
        frame = robot.frames.get(piece.link)
        if frame is not None and frame.body >= 0:
            rotation, offset = frame.rotation @ piece.rotation, frame.rotation @ piece.offset + frame.offset
            shape = _shape(piece, rotation, offset, hulls)
            if shape is not None:
                shapes[frame.body].append(shape)
    pieces = Pieces.of([[(shape.points, shape.radius) for shape in own] for own in shapes])
    return Outline(tuple(map(tuple, shapes)), pieces, _warnings(robot, kind, read, shapes))


def inertia_box(body: Body) -> Shape | None:
    """The box of uniform density that has the body's mass and inertia: a_x = sqrt(6 (I_y + I_z − I_x) / m) and so on.

    Args:
        body: the body.

    Returns: its eight corners; None if the body has no mass, or an inertia that no body can have.
    """
    if not body.mass > 0.0:
        return None
    moments, axes = np.linalg.eigh(body.inertia)
    squared = 6.0 * (moments.sum() - 2.0 * moments) / body.mass
    # A plate or a rod has sides of zero, which rounding may put below.
    if squared.max() <= 0.0 or squared.min() < -1e-9 * squared.max():
        return None
    half = 0.5 * np.sqrt(np.maximum(squared, 0.0))
    return Shape(body.name, read_only(body.com + _box(half) @ axes.T))


def _shape(piece: Piece, rotation: Array, offset: Array, hulls: dict[int, Array]) -> Shape | None:
    """A piece in the frame of its body; None for what has no extent of its own, such as a plane.

    Args:
        piece: as the file has it.
        rotation: (3, 3) of the piece in the body's frame.
        offset: (3,) of its origin there [m].
        hulls: of the meshes met so far, by identity; four legs often share one.
    """
    g, radius, mesh = piece.geometry, 0.0, None
    rounds: list[tuple[float, float]] = []
    match g:
        case coal.Box():
            points = _box(g.halfSide)
        case coal.Sphere():
            points, radius = np.zeros((1, 3)), g.radius
        case coal.Capsule():
            points, radius = np.array([[0.0, 0.0, -g.halfLength], [0.0, 0.0, g.halfLength]]), g.radius
        case coal.Cylinder():
            points = np.concatenate([_rim(g.radius, -g.halfLength), _rim(g.radius, g.halfLength)])
            rounds = [(-g.halfLength, g.radius), (g.halfLength, g.radius)]
        case coal.Cone():
            points = np.concatenate([_rim(g.radius, -g.halfLength), [[0.0, 0.0, g.halfLength]]])
            rounds = [(-g.halfLength, g.radius)]
        case coal.Ellipsoid():
            points = _ball() * g.radii
        case Mesh():
            if id(g) not in hulls:
                hulls[id(g)] = _hull(g.vertices)
            points = hulls[id(g)]
            if len(g.triangles):
                mesh = Mesh(read_only(g.vertices @ rotation.T + offset), g.triangles)
        case coal.ConvexBase():
            points = g.points()
        case _:
            return None
    discs = tuple((rotation[:, 2] * z + offset, rotation[:, 2], radius) for z, radius in rounds)
    return Shape(piece.link, read_only(points @ rotation.T + offset), float(radius), mesh, discs)


def _box(half: Array) -> Array:
    signs = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, 8).T
    return signs * half


@functools.cache
def _circle() -> Array:
    angle = 2.0 * math.pi * np.arange(RIM) / RIM
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(RIM)], axis=1)


def _rim(radius: float, z: float) -> Array:
    return np.asarray(_circle() * radius + np.array([0.0, 0.0, z]))


@functools.cache
def _ball() -> Array:
    """Points on the unit sphere: a circle of 64 at every 32nd part of the half turn, and the poles."""
    latitude = math.pi * (np.arange(1, 32) / 32 - 0.5)
    rings = [_circle() * math.cos(a) + np.array([0.0, 0.0, math.sin(a)]) for a in latitude]
    return np.concatenate([*rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])


def _hull(vertices: Array) -> Array:
    """Corners of the convex hull; all vertices where it is flat, because coal crashes on a hull without volume."""
    if len(vertices) < 5:
        return vertices
    spread = np.linalg.eigvalsh(np.cov(vertices.T))
    if spread[0] <= FLAT**2 * spread[-1]:
        return vertices
    points = coal.StdVec_Vec3s()
    points.extend(list(vertices))
    try:
        return np.asarray(coal.ConvexBase.convexHull(points, False, "Qt").points())
    except RuntimeError:
        # coal gives up on corners with very many neighbours, such as a cone's tip; all vertices have the same hull.
        return vertices


def _warnings(robot: Robot, kind: Kind, read: Geometries, shapes: list[list[Shape]]) -> tuple[str, ...]:
    """The shapes that could not be read, folded into one line that ends with its consequence."""
    if not read.unread:
        return ()
    frames = [robot.frames[lost.link] for lost in read.unread if lost.link in robot.frames]
    bare = [robot.bodies[i].name for i in sorted({frame.body for frame in frames if frame.body >= 0}) if not shapes[i]]
    names = ", ".join(f'"{name}"' for name in bare[:4]) + (f" and {len(bare) - 4} more" if len(bare) > 4 else "")
    consequence = f"no {kind} geometry is left for {names}" if bare else "every body keeps others"
    total = len(read.unread) + len(read.pieces)
    one = len(read.unread) == 1
    count = f"a {kind} shape" if one else f"{len(read.unread)} of {total} {kind} shapes"
    return (f"{count} could not be read ({'' if one else 'first: '}{read.unread[0].reason}); {consequence}",)
