"""What the figure shows of a robot: silhouettes in painter's order, the window around them, and which bodies matter."""

from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.spatial import Array, Plane
from shockpc.result import ShockProfile
from shockpc.robot.geometry import Shape, inertia_box, outline
from shockpc.show.figure.field import Field, field_of
from shockpc.show.figure.silhouette import Region, silhouette, to_plane

__all__ = ["Drawn", "View", "view_of"]

RESOLUTION = 1e-3
"""How far a silhouette may lie from the true one, as a share of the robot's size in the figure."""


_SIDES = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


class Drawn(NamedTuple):
    """A body as it is drawn.

    Attributes:
        body: index of the body.
        region: its silhouette in plane coordinates [m].
        field: shock over the plane.
        struck: whether the strike reaches the base through it, so that it is numbered and never hidden.
        glass: whether it stands in front of a struck body and is drawn by its edge only.
        far: whether it stands behind the base.
        box: whether the silhouette is that of its inertia, because the file has no shape for it.
    """

    body: int
    region: Region
    field: Field
    struck: bool
    glass: bool
    far: bool
    box: bool


class View(NamedTuple):
    """The picture in plane coordinates.

    Attributes:
        drawn: bodies, farthest first.
        struck: indices of the bodies between contacts and base, base first.
        low: (2,) lower left corner of all silhouettes [m].
        high: (2,) upper right corner of all silhouettes [m].
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
    """Lay out the bodies of a profile; the viewer looks against the plane's normal, e1 to the right and e2 up."""
    shapes = _shapes(profile)
    world = [_points(profile, i, pieces) for i, (pieces, _) in enumerate(shapes)]
    every = to_plane(np.concatenate(world), profile.plane)
    size = max(float(np.ptp(every, axis=0).max()), 1e-6)
    struck = _struck(profile)
    regions = [
        silhouette(pieces, profile.rotation[i], profile.position[i], profile.plane, RESOLUTION * size)
        for i, (pieces, _) in enumerate(shapes)
    ]
    depth = np.array([_depth(points, profile.plane) for points in world])
    base_depth = depth[struck[0]]
    drawn = []
    for i in np.argsort(depth, kind="stable"):
        hidden = [regions[k] for k in struck[1:] if depth[k] < depth[i] - RESOLUTION * size]
        covered = shapely.union_all(hidden).intersection(regions[i]).area if hidden else 0.0
        drawn.append(
            Drawn(
                body=int(i),
                region=regions[i],
                field=field_of(profile, int(i), world[i]),
                struck=int(i) in struck,
                glass=int(i) not in struck and covered > 0.1 * regions[i].area,
                far=int(i) not in struck and depth[i] < base_depth - 0.02 * size,
                box=shapes[i][1],
            )
        )
    bounds = shapely.total_bounds([region for region in regions if not region.is_empty])
    if np.isnan(bounds).any():
        bounds = np.concatenate([every.min(axis=0), every.max(axis=0)])
    return View(tuple(drawn), struck, bounds[:2], bounds[2:])


def _shapes(profile: ShockProfile) -> list[tuple[tuple[Shape, ...], bool]]:
    """What each body looks like, and whether that is only its inertia's box."""
    seen = outline(profile.robot, "visual").shapes
    solid = outline(profile.robot, "collision").shapes if not all(seen) else seen
    found: list[tuple[tuple[Shape, ...], bool]] = []
    for body, visual, collision in zip(profile.robot.bodies, seen, solid, strict=True):
        box = None if visual or collision else inertia_box(body)
        found.append(((box,), True) if box is not None else (visual or collision, False))
    return found


def _points(profile: ShockProfile, body: int, shapes: tuple[Shape, ...]) -> Array:
    """Points (n, 3) on the surface of a body, world axes [m]; its centre of mass if it has no shape."""
    rounded = [shape.points + shape.radius * side for shape in shapes for side in (_SIDES if shape.radius > 0.0 else _SIDES[:1])]
    points = np.concatenate(rounded) if rounded else profile.robot.bodies[body].com[None]
    return np.asarray(points @ profile.rotation[body].T + profile.position[body])


def _depth(points: Array, plane: Plane) -> float:
    """How near the middle of a body is to the viewer [m]."""
    towards = points @ plane.normal
    return float(towards.min() + towards.max()) / 2.0


def _struck(profile: ShockProfile) -> tuple[int, ...]:
    """The bodies between every contact and the base, base first."""
    robot = profile.robot
    reached = {0}
    for contact in profile.scene.contact:
        joint = robot.bodies[robot.frame(contact.frame).body].joint
        while joint > 0:
            reached.add(joint - 1)
            joint = robot.model.parents[joint]
    return tuple(sorted(reached))
