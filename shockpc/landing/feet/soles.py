"""The corners of a foot: the points of its geometry with which it stands on the ground.

They are corners of the three-dimensional hull of all shapes that lie within the ground's tolerance
of the lowest point. A face that the height of the tolerance only cuts has none there, and what lies
within another shape has none either. Seen from above their hull is the sole: an area, a line of two
corners, or a single point.
"""

import math
from collections.abc import Sequence

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, cross
from shockpc.landing.scenes.directions import across
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.geometry import robot_size
from shockpc.robot.shapes.lowest import height_of_lowest
from shockpc.robot.shapes.striking import striking

INSIDE, SHARE = 0.02, 0.01
"""Distance of a contact point from the lowest point of its link, in the middle of a foot or on the
centre line of a beam: 2 cm [m] and a hundredth of the robot's size."""

ROUND = 0.5
"""A round shape that reaches below its points by more than this share of its largest semi-axis is
round at its lowest point; one that reaches less, such as a disc that stands, is flat there [1]."""

RINGS, AROUND = 17, 16
"""Parallels of a round shape, and points on each, that represent its part near the ground."""

PLANE, FLAT = 0.1, 0.5
"""Limits of meshes, which do not say whether they are round: height up to which points belong to
the face under their middle, as a share of the ground's tolerance; share of the area near the ground
that this face has at least. That share is 0.1 for a ball and 0.3 for a wheel.
"""

WIDE = 1.5
"""Width of the sole in which a frame without geometry lies, in units of `most_inside`: the end of a
beam is narrower [1]."""

DEPTH = 0.02
"""Depth in the hull of all shapes up to which a point is on it, as a share of the ground's
tolerance [1]."""

SLOPES = np.tan(np.radians([1.0, 3.0, 8.0, 20.0, 45.0]))
"""Slopes of the planes from which that depth is measured, besides the level one [1]."""

LEVEL = 1e-9
"""Height up to which points are equally high, whatever the ground's tolerance is [m]."""

FAR, HIGH = 10.0, 1e3
"""Distance and height of the auxiliary points with which the search for a face begins [m]."""

_ANGLES = 2.0 * math.pi * np.arange(64) / 64
DIRECTIONS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
"""Directions (2, 64) in which the extent of an area is measured."""


@memoized()
def most_inside(robot: Robot) -> float:
    """The distance by which a contact point may be off the lowest point of its link [m]."""
    return INSIDE + SHARE * robot_size(robot)


def distance_aside(point: Array, points: Array, up: Array) -> float:
    """Horizontal distance of a point (3,) from the hull of points (k, 3) [m].

    It is 0 above or below the hull.
    """
    if len(points) == 1:
        # The usual foot is a ball.
        return float(np.linalg.norm(cross(point - points[0], up)))
    aside = (point - points) @ np.transpose(across(up)) @ DIRECTIONS
    return max(0.0, float(aside.min(axis=0).max()))


@memoized(most=100)
def sole_corners(
    robot: Robot,
    name: str,
    normal: tuple[float, float, float],
    tolerance: float,
) -> Array | None:
    """The corners (n, 3) of the sole of a frame, in its body's frame [m]; None if it is a point.

    A frame without shapes has the sole of its body if that is wide, unlike the end of a beam, and
    if it lies in the middle of it or is the name of a foot.

    Args:
        robot: the robot.
        name: of the frame.
        normal: unit normal of the ground, in the axes of the body.
        tolerance: of the ground [m].
    """
    strikes = striking(robot, name)
    if not strikes.shapes:
        return None
    up = np.array(normal)
    tolerance = tolerance + LEVEL
    low = height_of_lowest(strikes.shapes, up)
    near = [shape for shape in strikes.shapes if height_of_lowest([shape], up) <= low + tolerance]
    if len(near) == 1 and _is_round(near[0]):
        return None
    points = _corners(near, up, low, tolerance)
    if len(points) < 2:
        return None
    if strikes.is_place and not _has_sole(robot, name, near, up, low + tolerance):
        return None
    return points


def _corners(shapes: Sequence[Shape], up: Array, low: float, tolerance: float) -> Array:
    """The corners (n, 3) of the hull of shapes that lie near the ground, around it.

    Args:
        shapes: of a body, each with a point within the tolerance.
        up: (3,) unit normal of the ground, in the axes of the body.
        low: height of the lowest point of the body over its origin [m].
        tolerance: of the ground [m].
    """
    axes = np.array(across(up))
    meshes = [shape for shape in shapes if shape.mesh is not None]
    corners: list[Array] = []
    for shape in shapes:
        if shape.mesh is None:
            corners.append(_corners_of_primitive(shape, up, low + tolerance))
    if meshes:
        corners.append(_corners_of_meshes(meshes, up, low, tolerance))
    points = np.concatenate(corners)
    if len(shapes) > 1:
        points = points[_depth_in_hull(points, shapes, up, axes) <= DEPTH * tolerance]
    return np.asarray(points[_on_outline(points @ axes.T)])


def _is_round(shape: Shape) -> bool:
    """True if a shape is a ball, the usual foot."""
    semi_axes = np.linalg.norm(shape.rounding, axis=0)
    return len(shape.points) == 1 and bool(semi_axes.min() > (1.0 - LEVEL) * semi_axes.max())


def _corners_of_primitive(shape: Shape, up: Array, height: float) -> Array:
    """The corners (n, 3) of a box or a round shape below a height over the origin of the body [m].

    A ball has its lowest point, a lying rod the lowest point of each end, a standing disc points on
    its rim. A lying cylinder that is not longer than thick is a wheel, with one point in its
    middle.
    """
    semi_axes = np.linalg.norm(shape.rounding, axis=0)
    along = up @ shape.rounding
    reach = float(np.linalg.norm(along))
    if not reach > ROUND * semi_axes.max():
        points = _points_of(shape, up)
        return np.asarray(points[points @ up <= height])
    tips = shape.points - shape.rounding @ along / reach
    length = float(np.linalg.norm(np.ptp(tips, axis=0)))
    tips = tips[tips @ up <= height]
    is_wheel = length <= 2.0 * semi_axes.max()
    return tips.mean(axis=0, keepdims=True) if is_wheel else np.asarray(tips)


def _corners_of_meshes(meshes: Sequence[Shape], up: Array, low: float, tolerance: float) -> Array:
    """The corners (n, 3) of the meshes of a body; one point if they are round near the ground.

    Args:
        meshes: with a point within the tolerance.
        up: (3,) unit normal of the ground, in the axes of the body.
        low: height of the lowest point of the body over its origin [m].
        tolerance: of the ground [m].
    """
    parts = [_below(mesh, up, low + tolerance) for mesh in meshes]
    vertices = np.concatenate([below for below, _ in parts])
    cuts = np.concatenate([cut for _, cut in parts])
    points = np.concatenate([vertices, cuts])
    flat = points @ np.transpose(across(up))
    outline = _extreme(flat)
    if is_thin(outline):
        return vertices
    above_face = _height_above_face(flat - outline.mean(axis=0), points @ up - low)
    on_face = above_face <= PLANE * tolerance
    has_face = False
    if on_face.any():
        face = _extreme(flat[on_face])
        has_face = area(face) > FLAT * area(outline)
    if not has_face:
        return np.asarray(vertices[(vertices @ up).argmin()][None])
    return np.asarray(vertices[on_face[: len(vertices)]])


def _depth_in_hull(points: Array, shapes: Sequence[Shape], up: Array, axes: Array) -> Array:
    """Depth (n,) of points in the hull of some shapes, seen from below [m].

    Planes that touch the shapes, one level and others tilted, bound the hull.

    Args:
        points: (n, 3), in the frame of the body.
        shapes: of the body.
        up: (3,) unit normal of the ground, in the axes of the body.
        axes: (2, 3) that span the ground.
    """
    sixteen = DIRECTIONS.T[::4] @ axes
    tilted = [slope * sixteen - up for slope in SLOPES]
    outward = np.concatenate([-up[None], *tilted])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    reach = np.max([shape.reach(outward) for shape in shapes], axis=0)
    below_planes = reach - points @ outward.T
    return np.asarray(below_planes.min(axis=1))


def _has_sole(
    robot: Robot,
    name: str,
    shapes: Sequence[Shape],
    up: Array,
    height: float,
) -> bool:
    """True if a frame without shapes has the sole of its body.

    Args:
        robot: the robot.
        name: of the frame.
        shapes: of the body, that reach below the height.
        up: (3,) unit normal of the ground, in the axes of the body.
        height: over the body's origin up to which points belong to the sole [m].
    """
    offset = robot.frame(name).offset
    inside = most_inside(robot)
    is_foot = striking(robot, name).is_foot
    if not is_foot and abs(up @ offset - height_of_lowest(shapes, up)) > inside:
        return False
    near: list[Array] = []
    for shape in shapes:
        near += _below(shape, up, height)
    aside = (np.concatenate(near) - offset) @ np.transpose(across(up)) @ DIRECTIONS
    width = np.ptp(aside, axis=0)
    from_middle = np.abs(aside.min(axis=0) + aside.max(axis=0)) / 2.0
    is_central = is_foot or bool(np.all(from_middle <= width / 4.0))
    return bool(width.min() > WIDE * inside) and is_central


def _on_outline(flat: Array) -> np.ndarray:
    """The numbers of those of points (n, 2) that are the farthest in some direction, each once."""
    if not len(flat):
        return np.zeros(0, dtype=int)
    farthest = (flat @ DIRECTIONS).argmax(axis=0)
    return np.array(list(dict.fromkeys(farthest.tolist())))


def _extreme(flat: Array) -> Array:
    """The points (64, 2) that are farthest in each direction, of points (n, 2).

    They are in order around the hull.
    """
    x, y = flat.T
    dx, dy = DIRECTIONS[:, : DIRECTIONS.shape[1] // 2, None]
    along = dx * x + dy * y
    farthest = np.concatenate([along.argmax(axis=1), along.argmin(axis=1)])
    return np.asarray(flat[farthest])


def area(polygon: Array) -> float:
    """Area of a polygon by its corners (n, 2), in their order around it [m²]."""
    x, y = (polygon - polygon.mean(axis=0)).T
    # ½ |Σ x_k y_{k+1} − y_k x_{k+1}|
    twice = x @ np.roll(y, -1) - y @ np.roll(x, -1)
    return abs(float(0.5 * twice))


def ends_of(corners: Array) -> tuple[Array, Array]:
    """The two of some corners (k, 3) that are farthest apart; a single one twice."""
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    i, j = np.unravel_index(int(apart.argmax()), apart.shape)
    return corners[i], corners[j]


def is_thin(polygon: Array) -> bool:
    """True if a polygon (n, 2), corners in their order, is a line or a point."""
    return area(polygon) <= LEVEL * float(np.ptp(polygon, axis=0).max()) ** 2


def _height_above_face(flat: Array, height: Array) -> Array:
    """Heights (n,) of points above the face of their hull at the origin; infinite if there is none.

    The face is found by the simplex method: the convex combination of points that is at the origin
    and lowest. It begins with three auxiliary points.

    Args:
        flat: (n, 2) their horizontal positions [m].
        height: (n,) [m].
    """
    angle = 2.0 * math.pi * np.arange(3) / 3
    auxiliary = FAR * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    positions = np.concatenate([auxiliary, flat])
    rows = np.column_stack([np.ones(len(positions)), positions])
    cost = np.concatenate([np.full(3, HIGH), height])
    basis = np.arange(3)
    for _ in range(len(rows)):
        above = cost - rows @ np.linalg.solve(rows[basis], cost[basis])
        entering = int(above.argmin())
        if above[entering] > -LEVEL:
            break
        # The shares of the basis in the origin, and by how much those of the entering point differ.
        sides = np.stack([[1.0, 0.0, 0.0], rows[entering]], axis=1)
        shares, change = np.linalg.solve(rows[basis].T, sides).T
        decreases = change > LEVEL
        ratio = np.where(decreases, shares / np.where(decreases, change, 1.0), np.inf)
        basis[int(ratio.argmin())] = entering
    # An auxiliary point stays in the basis where the origin is outside of the hull.
    if basis.min() <= 2:
        return np.full(len(flat), np.inf)
    return np.asarray(above[3:])


def _below(shape: Shape, up: Array, height: float) -> tuple[Array, Array]:
    """Points (n, 3) of a shape below a height [m], and those (m, 3) where its edges are cut there.

    Their hull is the part of the shape below. Points on it represent a round shape. All is in the
    frame of the body, and the height is over its origin.
    """
    if shape.mesh is not None:
        points = shape.mesh.vertices
        edges = shape.mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    else:
        points = _points_of(shape, up)
        edges = np.stack(np.triu_indices(len(points), 1), axis=1)
    over = points @ up - height
    is_cut = over[edges[:, 0]] * over[edges[:, 1]] < 0.0
    start, end = edges[is_cut].T
    share = (over[start] / (over[start] - over[end]))[:, None]
    cuts = points[start] + share * (points[end] - points[start])
    return points[over <= 0.0], cuts


def _points_of(shape: Shape, up: Array) -> Array:
    """Points (n, 3) of a box, or on a round shape, which they represent."""
    if not shape.rounding.any():
        return shape.points
    around = _ball(up @ shape.rounding) @ shape.rounding.T
    return np.asarray((shape.points[:, None] + around).reshape(-1, 3))


def _ball(axis: Array) -> Array:
    """Points (n, 3) on the unit ball, on parallels about an axis, which may be zero."""
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    latitude = math.pi * np.arange(1, RINGS - 1) / (RINGS - 1)
    angle = 2.0 * math.pi * np.arange(AROUND) / AROUND
    first, second = across(axis)
    around = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    parallels = np.cos(latitude)[:, None, None] * axis + np.sin(latitude)[:, None, None] * around
    return np.concatenate([[axis, -axis], parallels.reshape(-1, 3)])
