"""A landing in the plane of the figure: silhouettes and shock of the bodies, and all marks."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.spatial import Array, corners_of_box
from shockpc.landing.closure import all_loops
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.show.figure.body_shapes import RESOLUTION, Silhouettes, silhouettes
from shockpc.show.figure.field import Field, field_of
from shockpc.show.figure.silhouette import PlaneShape, to_plane
from shockpc.show.wording import mostly_off_plane

FEW = 6
"""A robot with up to this many bodies has all of them numbered."""

LARGEST_BOX = 1.5
"""Largest box of an inertia that is filled, for a robot without shapes.

It is relative to the extent of joints, centres of mass and contacts.
"""

COVERED, BEHIND = 0.1, 0.02
"""Limits for bodies that cover others, and for bodies that are far.

The first is the share of a body that covers the struck limb, from which on only its edge is drawn;
the second the distance behind the base, as a share of the robot's size, from which on it is far.
"""


class Drawn(NamedTuple):
    """A body as it is drawn.

    Attributes:
        body: index of the body.
        region: its silhouette in plane coordinates [m]; empty if it has neither shape nor inertia.
        field: shock over the plane.
        outlined: whether only its edge is drawn, because it is in front of the struck limb, or a
            box larger than the robot.
        far: whether it is behind the base.
        box: whether the silhouette is that of its inertia, because there is no shape of it to draw.
    """

    body: int
    region: PlaneShape
    field: Field
    outlined: bool
    far: bool
    box: bool


class PlaneView(NamedTuple):
    """A landing in plane coordinates [m].

    Attributes:
        drawn: bodies, farthest first.
        numbers: those of bodies and of their CoPc by index: all of a small robot; else those
            between contacts and base, and the heaviest.
        names: of the directions to the right and up.
        low, high: (2,) lower left and upper right corner of all bodies but boxes larger than the
            robot.
        contacts: (n, 2) contact points.
        velocities: (n, 2) of these before the impact, relative to the speed of the fastest [1].
        joints: (n, 2) joints between bodies, and those that close loops.
        sensors: (n, 2) sensors and points.
        centres: CoPc (2,) of each body that rotates in the plane, by its index.
        radii: (n,) RoPc of all bodies.
        faint: bodies that move mostly out of the plane, of which CoPc and RoPc say little.
    """

    drawn: tuple[Drawn, ...]
    numbers: dict[int, int]
    names: Sequence[str]
    low: Array
    high: Array
    contacts: Array
    velocities: Array
    joints: Array
    sensors: Array
    centres: dict[int, Array]
    radii: Array
    faint: frozenset[int]

    @property
    def size(self) -> float:
        """The larger side of the robot [m]."""
        return max(float((self.high - self.low).max()), 1e-6)


def view_of(profile: ShockProfile) -> PlaneView:
    """Project a landing.

    The viewer looks against the plane's normal, with e1 to the right and e2 up.
    """
    robot, plane = profile.robot, profile.plane
    shapes = silhouettes(
        robot, profile.rotation.tobytes(), profile.position.tobytes(), tuple(plane.normal.tolist())
    )
    too_large = _too_large(profile, shapes)
    of_robot = [
        to_plane(shapes.points[i], plane) for i in np.flatnonzero(np.logical_not(too_large))
    ]
    low, high = corners_of_box(np.vstack(of_robot))

    # Marks: contacts with their velocities, sensors, and the CoPc of bodies that rotate.
    contacts = np.stack([contact.point for contact in profile.contacts])
    approach = np.stack([contact.approach for contact in profile.contacts])
    speed = float(np.linalg.norm(profile.strike))
    sensors = np.array([point.position for point in profile.points]).reshape(-1, 3)
    centres = to_plane(profile.copc_world, plane)
    rotates = np.flatnonzero(~profile.translates).tolist()
    return PlaneView(
        drawn=_drawn(profile, shapes, too_large, float((high - low).max())),
        numbers={i: n for n, i in enumerate(numbered(profile), start=1)},
        names=_names(profile),
        low=low,
        high=high,
        contacts=to_plane(contacts, plane),
        velocities=to_plane(approach / speed, plane),
        joints=to_plane(_joints(profile), plane),
        sensors=to_plane(sensors, plane),
        centres={i: centres[i] for i in rotates},
        radii=profile.ropc,
        faint=frozenset(np.flatnonzero(mostly_off_plane(profile)).tolist()),
    )


def _names(profile: ShockProfile) -> Sequence[str]:
    """Names of the directions to the right and up."""
    if isinstance(profile.scene.plane, str):
        return profile.scene.plane
    names = []
    for axis in (profile.plane.e1, profile.plane.e2):
        numbers = ", ".join(f"{x + 0.0:.3g}" for x in axis)
        names.append(f"along ({numbers})")
    return names


def _too_large(profile: ShockProfile, shapes: Silhouettes) -> list[bool]:
    """True for each body that is the box of an inertia larger than the robot; none if all were."""
    coms = profile.position + (profile.rotation @ profile.robot.coms[..., None])[..., 0]
    contacts = [contact.point for contact in profile.contacts]
    marks = to_plane(np.vstack([profile.position, coms, *contacts]), profile.plane)
    bodies = list(zip(shapes.regions, shapes.boxed, strict=True))
    shaped = shapely.union_all([region for region, boxed in bodies if not boxed])
    extent_of_marks = float(np.ptp(marks, axis=0).max())
    largest = _extent_of(shaped) or LARGEST_BOX * extent_of_marks or math.inf
    too_large = [boxed and _extent_of(region) > largest for region, boxed in bodies]
    left = [
        region
        for region, larger in zip(shapes.regions, too_large, strict=True)
        if not larger and not region.is_empty
    ]
    return too_large if left else [False] * len(too_large)


def _drawn(
    profile: ShockProfile, shapes: Silhouettes, too_large: Sequence[bool], size: float
) -> tuple[Drawn, ...]:
    """The bodies, farthest first. Args: size, of the robot in the plane [m]."""
    depths = []
    for points in shapes.points:
        h = points @ profile.plane.normal
        depths.append((h.min() + h.max()) / 2.0)
    depth = np.array(depths)
    limb = _limb(profile.robot, _struck(profile))
    drawn = []
    for i in np.argsort(depth, kind="stable").tolist():
        region = shapes.regions[i]
        outlined, far = too_large[i], False
        if i not in limb and i != 0:
            behind = [k for k in limb if depth[k] < depth[i] - RESOLUTION * size]
            covered = shapely.union_all([shapes.regions[k] for k in behind])
            area = shapely.intersection(covered, region).area
            outlined = outlined or area > COVERED * region.area
            far = bool(depth[i] < depth[0] - BEHIND * size)
        field = field_of(profile, i, shapes.points[i])
        drawn.append(Drawn(i, region, field, outlined, far, shapes.boxed[i]))
    return tuple(drawn)


def _joints(profile: ShockProfile) -> Array:
    """Points (n, 3) of joints between bodies, and of those that close loops, world axes [m]."""
    robot = profile.robot
    joints = list(profile.position[1 if robot.free_base else 0 :])
    for loop in all_loops(robot, profile.scene.closure):
        if loop.holds_orientation:
            continue
        for body, point in zip(loop.bodies, loop.points, strict=True):
            if body >= 0:
                joints.append(profile.position[body] + profile.rotation[body] @ point)
                break
    return np.array(joints).reshape(-1, 3)


def _extent_of(region: PlaneShape) -> float:
    """The longer side of a region [m]; zero if it is empty."""
    if region.is_empty:
        return 0.0
    low_u, low_w, high_u, high_w = region.bounds
    return float(max(high_u - low_u, high_w - low_w))


def numbered(profile: ShockProfile) -> Sequence[int]:
    """The bodies that have numbers: all of a small robot, else a part.

    These are the bodies between contacts and base, and the heaviest.
    """
    masses = profile.robot.masses
    if len(masses) <= FEW:
        return range(len(masses))
    return sorted({*_struck(profile), int(np.argmax(masses))})


def _struck(profile: ShockProfile) -> set[int]:
    """The bodies between contacts and base."""
    robot = profile.robot
    struck = {0}
    for contact in profile.scene.contact:
        struck.update(robot.limb(robot.frame(contact.frame).body))
    return struck


def _limb(robot: Robot, struck: set[int]) -> set[int]:
    """The bodies between contacts and base, with those on them.

    Of a chain through the heaviest body, its other limbs are left out.
    """
    limb, heaviest = struck - {0}, int(np.argmax(robot.masses))
    holds_limbs = {heaviest, *robot.limb(heaviest)} if heaviest in limb else set()
    for i, parent in enumerate(robot.parents):
        if parent in limb - holds_limbs:  # parents come first
            limb.add(i)
    return limb
