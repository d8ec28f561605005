"""The bodies of a robot in the plane of the figure: silhouettes, the order in which they are painted, and which ones are struck."""

from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.spatial import Array
from shockpc.result import ShockProfile
from shockpc.robot.geometry import Shape, inertia_box, outline
from shockpc.show.figure.field import Field, field_of
from shockpc.show.figure.silhouette import Region, silhouette, to_plane

__all__ = ["Drawn", "View", "view_of"]

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
        box: whether the silhouette is that of its inertia, because the file has no shape for it.
    """

    body: int
    region: Region
    field: Field
    outlined: bool
    far: bool
    box: bool


class View(NamedTuple):
    """The bodies of a profile in plane coordinates.

    Attributes:
        profile: the shock of a landing.
        drawn: bodies, farthest first.
        struck: indices of the bodies between contacts and base, base first.
        low, high: (2,) lower left and upper right corner of all silhouettes [m].
    """

    profile: ShockProfile
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
    shapes = _shapes(profile)
    world = [_points(profile, i, pieces) for i, (pieces, _) in enumerate(shapes)]
    every = to_plane(np.concatenate(world), plane)
    size = max(float(np.ptp(every, axis=0).max()), 1e-6)
    regions = []
    for i, (pieces, _) in enumerate(shapes):
        region = silhouette(pieces, profile.rotation[i], profile.position[i], plane, RESOLUTION * size)
        # Holes and gaps that are too fine to be seen are closed.
        closed = region.buffer(2.0 * RESOLUTION * size, join_style="mitre").buffer(-2.0 * RESOLUTION * size, join_style="mitre")
        regions.append(closed.simplify(0.5 * RESOLUTION * size))
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
        drawn.append(Drawn(i, regions[i], field_of(profile, i, world[i]), outlined, far, box=shapes[i][1]))
    bounds = shapely.total_bounds(regions)
    if np.isnan(bounds).any():
        bounds = np.concatenate([every.min(axis=0), every.max(axis=0)])
    return View(profile, tuple(drawn), tuple(sorted(struck)), bounds[:2], bounds[2:])


def _shapes(profile: ShockProfile) -> list[tuple[tuple[Shape, ...], bool]]:
    """The shapes of each body, visual rather than collision, and whether they are only the box of its inertia."""
    visual = outline(profile.robot, "visual").shapes
    collision = outline(profile.robot, "collision").shapes if not all(visual) else visual
    found: list[tuple[tuple[Shape, ...], bool]] = []
    for body, seen, solid in zip(profile.robot.bodies, visual, collision, strict=True):
        box = None if seen or solid else inertia_box(body)
        found.append(((box,), True) if box is not None else (seen or solid, False))
    return found


def _points(profile: ShockProfile, body: int, shapes: tuple[Shape, ...]) -> Array:
    """Points (n, 3) on the surface of a body, world axes [m]; its centre of mass if it has no shape."""
    rounded = [shape.points + shape.radius * side for shape in shapes for side in (_SIDES if shape.radius > 0.0 else _SIDES[:1])]
    points = np.concatenate(rounded) if rounded else profile.robot.bodies[body].com[None]
    return np.asarray(points @ profile.rotation[body].T + profile.position[body])
