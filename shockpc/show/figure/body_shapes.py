"""The shapes of bodies that are drawn, and their silhouettes in a posture."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, corners_of_box, plane_from
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.convex import Shape, inertia_box
from shockpc.robot.shapes.geometry import drawn_outline, outline
from shockpc.show.figure.silhouette import Edges, PlaneShape, silhouette, surface, to_plane

RESOLUTION = 1.5e-3
"""Largest distance of a silhouette from the true one, as a share of the robot's size in the figure.
"""


class Silhouettes(NamedTuple):
    """The bodies of a robot in a posture, each by its index.

    Attributes:
        regions: silhouettes in plane coordinates [m].
        points: (n, 3) on the surface, world axes [m]; the centre of mass of what has no shape.
        boxed: whether the box of the inertia is one of the shapes.
    """

    regions: tuple[PlaneShape, ...]
    points: tuple[Array, ...]
    boxed: tuple[bool, ...]


@memoized(most=4)
def silhouettes(
    robot: Robot, rotation: bytes, position: bytes, normal: tuple[float, ...]
) -> Silhouettes:
    """The silhouettes of a robot; landings in one posture share them.

    Args:
        robot: the robot.
        rotation: (nb, 3, 3) of the bodies, to world axes; as bytes, by which results are kept.
        position: (nb, 3) of their frames' origins [m]; as bytes.
        normal: of the plane.
    """
    plane = plane_from(normal)
    turns = np.frombuffer(rotation).reshape(-1, 3, 3)
    origins = np.frombuffer(position).reshape(-1, 3)
    shapes: list[list[Shape]] = []
    points: list[Array] = []
    boxed: list[bool] = []
    for body, (unplaced, is_boxed), R, p in zip(
        robot.bodies, body_shapes(robot), turns, origins, strict=True
    ):
        placed = [shape.placed(R, p) for shape in unplaced]
        shapes.append(placed)
        if placed:
            points.append(surface(placed))
        else:
            centre_of_mass = body.com @ R.T + p
            points.append(centre_of_mass[None])
        boxed.append(is_boxed)
    extent = np.ptp(corners_of_box(to_plane(np.concatenate(points), plane)), axis=0)
    resolution = RESOLUTION * max(float(extent.max()), 1e-6)
    edges: dict[int, Edges] = {}
    regions = [silhouette(placed, plane, resolution, edges) for placed in shapes]
    closed = [_closed(region, 2.0 * resolution) for region in regions]
    return Silhouettes(tuple(closed), tuple(points), tuple(boxed))


def _closed(region: PlaneShape, fine: float) -> PlaneShape:
    """A region without holes and gaps that are too fine to be seen."""
    wider = region.buffer(fine, join_style="mitre")
    return wider.buffer(-fine, join_style="mitre").simplify(fine / 4.0)


def body_shapes(robot: Robot) -> list[tuple[tuple[Shape, ...], bool]]:
    """The shapes of each body, and whether the box of its inertia is among them.

    Shapes are visual rather than collision. The box stands for what has no shape.
    """
    visual, _, unread, _ = drawn_outline(robot)
    collision = visual if all(visual) else outline(robot, "collision").shapes
    missing = {shape.link for shape in unread}
    chosen: list[tuple[tuple[Shape, ...], bool]] = []
    for body, seen, solid in zip(robot.bodies, visual, collision, strict=True):
        shapes, box = seen or solid, inertia_box(body)
        # Where a mesh is missing, what is left may be the smallest part of a body, such as the
        # marker of a sensor on a trunk.
        lost = not shapes or not missing.isdisjoint(body.links)
        if lost and box is not None and _extent([box]) > _extent(shapes):
            chosen.append(((*shapes, box), True))
        else:
            chosen.append((shapes, False))
    return chosen


def _extent(shapes: Sequence[Shape]) -> float:
    """The largest extent of some shapes along an axis of their body [m]."""
    if not shapes:
        return 0.0
    return float(np.ptp(corners_of_box(surface(shapes)), axis=0).max())
