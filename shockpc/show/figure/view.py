"""The bodies of a robot in the plane of the figure: silhouettes, the order in which they are painted, and which ones are struck."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.spatial import Array, plane_from
from shockpc.model.dynamics import dynamics
from shockpc.result import ShockProfile
from shockpc.robot.geometry import Shape, inertia_box, outline
from shockpc.robot.robot import Robot
from shockpc.show.figure.field import Field, field_of
from shockpc.show.figure.silhouette import Region, silhouette, to_plane

__all__ = ["Drawn", "View", "body_shapes", "numbered", "view_of"]

FEW = 6
"""A robot with up to this many bodies has all of them numbered."""

RESOLUTION = 1e-3
"""Largest distance of a silhouette from the true one, as a share of the robot's size in the figure."""

_SIDES = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


class Drawn(NamedTuple):
    """A body as it is drawn.

    Attributes:
        body: index of the body.
        region: its silhouette in plane coordinates [m]; empty if it has neither shape nor inertia.
        field: shock over the plane.
        outlined: whether only its edge is drawn, because it is in front of a body between contact and base.
        far: whether it is behind the base.
        box: whether the silhouette is that of its inertia, because there is no shape of it to draw.
    """

    body: int
    region: Region
    field: Field
    outlined: bool
    far: bool
    box: bool


class View(NamedTuple):
    """The bodies in plane coordinates.

    Attributes:
        drawn: bodies, farthest first.
        struck: indices of the bodies between contacts and base, base first.
        low, high: (2,) lower left and upper right corner of all silhouettes [m].
    """

    drawn: tuple[Drawn, ...]
    struck: tuple[int, ...]
    low: Array
    high: Array

    @property
    def size(self) -> float:
        """The larger side of the robot [m]."""
        return float((self.high - self.low).max())


def view_of(profile: ShockProfile) -> View:
    """Project the bodies of a profile; the viewer looks against the plane's normal, with e1 to the right and e2 up."""
    robot, plane = profile.robot, profile.plane
    regions, world, boxed, size = _silhouettes(robot, tuple(profile.q.tolist()), tuple(plane.normal.tolist()))
    struck = {0}
    for contact in profile.scene.contact:
        i = robot.frame(contact.frame).body
        while i > 0:
            struck.add(i)
            i = robot.joints[i].parent
    depth = np.array([(h.min() + h.max()) / 2.0 for h in (points @ plane.normal for points in world)])
    drawn = []
    for i in map(int, np.argsort(depth, kind="stable")):
        hidden = shapely.union_all([regions[k] for k in struck - {0} if depth[k] < depth[i] - RESOLUTION * size])
        outlined = i not in struck and shapely.intersection(hidden, regions[i]).area > 0.1 * regions[i].area
        far = i not in struck and bool(depth[i] < depth[0] - 0.02 * size)
        drawn.append(Drawn(i, regions[i], field_of(profile, i, world[i]), outlined, far, boxed[i]))
    bounds = shapely.total_bounds(regions)
    if np.isnan(bounds).any():
        every = to_plane(np.concatenate(world), plane)
        bounds = np.concatenate([every.min(axis=0), every.max(axis=0)])
    return View(tuple(drawn), tuple(sorted(struck)), bounds[:2], bounds[2:])


def numbered(profile: ShockProfile, view: View) -> list[int]:
    """Bodies that carry a number: all of a small robot; else those between contacts and base, and the heaviest."""
    bodies = profile.robot.bodies
    if len(bodies) <= FEW:
        return list(range(len(bodies)))
    return sorted({*view.struck, max(range(len(bodies)), key=lambda i: bodies[i].mass)})


@functools.lru_cache(maxsize=4)
def _silhouettes(
    robot: Robot, q: tuple[float, ...], normal: tuple[float, ...]
) -> tuple[tuple[Region, ...], tuple[Array, ...], tuple[bool, ...], float]:
    """The silhouettes of a robot in a configuration; landings in one posture share them.

    Returns: silhouettes, points (n, 3) on the surface [m], whether the box of the inertia is one of the shapes, all by body; the
        robot's size [m].
    """
    plane, state = plane_from(normal), dynamics(robot, np.array([q]))
    rotation, position = state.rotation[0], state.position[0] + state.origin[0]
    shapes = body_shapes(robot)
    world = tuple(_points(robot, i, pieces) @ rotation[i].T + position[i] for i, (pieces, _) in enumerate(shapes))
    size = max(float(np.ptp(to_plane(np.concatenate(world), plane), axis=0).max()), 1e-6)
    regions = [silhouette(pieces, rotation[i], position[i], plane, RESOLUTION * size) for i, (pieces, _) in enumerate(shapes)]
    # Holes and gaps that are too fine to be seen are closed.
    fine = 2.0 * RESOLUTION * size
    closed = [region.buffer(fine, join_style="mitre").buffer(-fine, join_style="mitre").simplify(fine / 4.0) for region in regions]
    return tuple(closed), world, tuple(boxed for _, boxed in shapes), size


def body_shapes(robot: Robot) -> list[tuple[tuple[Shape, ...], bool]]:
    """The shapes of each body, visual rather than collision, and whether the box of its inertia stands for what has no shape."""
    visual = outline(robot, "visual").shapes
    collision = outline(robot, "collision").shapes if not all(visual) else visual
    missing = {shape.link for shape in outline(robot, "visual").unread}
    found: list[tuple[tuple[Shape, ...], bool]] = []
    for body, seen, solid in zip(robot.bodies, visual, collision, strict=True):
        shapes, box = seen or solid, inertia_box(body)
        # Where a mesh is missing, what is left may be the least part of a body, such as the marker of a sensor on a trunk.
        alone = not shapes or (not missing.isdisjoint(body.links) and box is not None and _extent((box,)) > _extent(shapes))
        found.append(((*shapes, box), True) if box is not None and alone else (shapes, False))
    return found


def _extent(shapes: Sequence[Shape]) -> float:
    """The greatest extent of some shapes along an axis of their body [m]."""
    return float(np.ptp(np.concatenate([shape.points for shape in shapes]), axis=0).max())


def _points(robot: Robot, body: int, shapes: tuple[Shape, ...]) -> Array:
    """Points (n, 3) on the surface of a body, in its frame [m]; its centre of mass if it has no shape."""
    rounded = [shape.points + shape.radius * side for shape in shapes for side in (_SIDES if shape.radius > 0.0 else _SIDES[:1])]
    return np.concatenate(rounded) if rounded else robot.bodies[body].com[None]
