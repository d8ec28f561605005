"""A landing in the plane of the figure: silhouettes and shock of the bodies, places of all marks,
the window that holds them.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, corners_of_box, plane_from
from shockpc.landing.closure import all_loops
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.geometry import drawn_outline, outline
from shockpc.robot.robot import Robot
from shockpc.robot.shapes import Shape, inertia_box
from shockpc.show.figure.silhouette import Edges, PlaneShape, silhouette, surface, to_plane
from shockpc.show.wording import mostly_off_plane

FEW = 6
"""A robot with up to this many bodies has all of them numbered."""

LARGEST_BOX = 1.5
"""Largest box of an inertia that is filled, relative to the extent of joints, centres of mass and
contacts if there is no shape.
"""

RESOLUTION = 1.5e-3
"""Largest distance of a silhouette from the true one, as a share of the robot's size in the figure.
"""


FITTED = 5000
"""Points of a body, about, to which the surface through its middle is fitted."""


class Field(NamedTuple):
    """Normalised shock of a body over plane coordinates u [m]: |c + A u|, c (3,) [1] and A (3, 2)
    [1/m].

    Its square is a quadratic form: circles about the CoPc if the body moves in the plane. For a
    body that also moves out of the plane the shock depends on depth as well; the field is then that
    on the surface through its middle.
    """

    c: Array
    A: Array

    def at(self, u: Array) -> Array:
        """Shock (...) at plane coordinates u (..., 2) [1]."""
        return np.asarray(np.linalg.norm(self.c + u @ self.A.T, axis=-1))


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


class View(NamedTuple):
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


def view_of(profile: ShockProfile) -> View:
    """Project a landing; the viewer looks against the plane's normal, with e1 to the right and e2
    up.
    """
    robot, plane = profile.robot, profile.plane
    regions, world, boxed = _silhouettes(
        robot, profile.rotation.tobytes(), profile.position.tobytes(), tuple(plane.normal.tolist())
    )
    struck = _struck(profile)
    limb = _limb(robot, struck)
    directions = [f"along ({', '.join(f'{x + 0.0:.3g}' for x in e)})" for e in (plane.e1, plane.e2)]
    depth = np.array(
        [(h.min() + h.max()) / 2.0 for h in (points @ plane.normal for points in world)]
    )
    coms = profile.position + (profile.rotation @ robot.coms[..., None])[..., 0]
    places = to_plane(
        np.vstack([profile.position, coms, *(contact.point for contact in profile.contacts)]), plane
    )
    shaped = shapely.union_all(
        [region for region, box in zip(regions, boxed, strict=True) if not box]
    )
    largest = _extent_of(shaped) or LARGEST_BOX * float(np.ptp(places, axis=0).max()) or math.inf
    too_large = [
        box and _extent_of(region) > largest for region, box in zip(regions, boxed, strict=True)
    ]
    if all(larger or region.is_empty for larger, region in zip(too_large, regions, strict=True)):
        too_large = [False] * len(regions)  # nothing else is left to draw
    corners = np.vstack(
        [
            to_plane(points, plane)
            for points, larger in zip(world, too_large, strict=True)
            if not larger
        ]
    )
    low, high = corners_of_box(corners)
    size = float((high - low).max())
    drawn = []
    for i in map(int, np.argsort(depth, kind="stable")):
        behind = shapely.union_all(
            [regions[k] for k in limb if depth[k] < depth[i] - RESOLUTION * size]
        )
        outlined = (
            i not in limb | {0}
            and shapely.intersection(behind, regions[i]).area > 0.1 * regions[i].area
        )
        outlined |= too_large[i]
        far = i not in limb | {0} and bool(depth[i] < depth[0] - 0.02 * size)
        drawn.append(Drawn(i, regions[i], field_of(profile, i, world[i]), outlined, far, boxed[i]))
    approach = np.stack([contact.approach for contact in profile.contacts]) / float(
        np.linalg.norm(profile.strike)
    )
    loops = [loop for loop in all_loops(robot, profile.scene.closure) if not loop.holds_orientation]
    ends = [
        next((i, p) for i, p in zip(loop.bodies, loop.points, strict=True) if i >= 0)
        for loop in loops
    ]
    pins = [
        *profile.position[1 if robot.free_base else 0 :],
        *(profile.position[i] + profile.rotation[i] @ p for i, p in ends),
    ]
    centres = to_plane(profile.copc_world, plane)
    return View(
        drawn=tuple(drawn),
        numbers={i: n for n, i in enumerate(numbered(profile), start=1)},
        names=profile.scene.plane if isinstance(profile.scene.plane, str) else directions,
        low=low,
        high=high,
        contacts=to_plane(np.stack([contact.point for contact in profile.contacts]), plane),
        velocities=to_plane(approach, plane),
        joints=to_plane(np.array(pins).reshape(-1, 3), plane),
        sensors=to_plane(
            np.array([point.position for point in profile.points]).reshape(-1, 3), plane
        ),
        centres={i: centres[i] for i in range(len(centres)) if not profile.translates[i]},
        radii=profile.ropc,
        faint=frozenset(np.flatnonzero(mostly_off_plane(profile)).tolist()),
    )


def _extent_of(region: PlaneShape) -> float:
    """The longer side of a region [m]; zero if it is empty."""
    low_u, low_w, high_u, high_w = region.bounds
    return 0.0 if region.is_empty else max(high_u - low_u, high_w - low_w)


def numbered(profile: ShockProfile) -> Sequence[int]:
    """The bodies that have numbers: all of a small robot; else those between contacts and base, and
    the heaviest.
    """
    masses = profile.robot.masses
    return (
        range(len(masses))
        if len(masses) <= FEW
        else sorted({*_struck(profile), int(np.argmax(masses))})
    )


def _struck(profile: ShockProfile) -> set[int]:
    """The bodies between contacts and base."""
    robot = profile.robot
    return {
        0,
        *(
            i
            for contact in profile.scene.contact
            for i in robot.limb(robot.frame(contact.frame).body)
        ),
    }


def _limb(robot: Robot, struck: set[int]) -> set[int]:
    """The bodies between contacts and base, with those on them; of a chain through the heaviest
    body without its other limbs.
    """
    limb, heaviest = struck - {0}, int(np.argmax(robot.masses))
    holds_limbs = {heaviest, *robot.limb(heaviest)} if heaviest in limb else set()
    for i, parent in enumerate(robot.parents):
        if parent in limb - holds_limbs:  # parents come first
            limb.add(i)
    return limb


def field_of(profile: ShockProfile, body: int, points: Array) -> Field:
    """The field of a body on the plane through the middle of points (n, 3) on it, world axes [m].

    Least squares of the depth; a slope that the points determine poorly, such as across a thin rod,
    stays near zero.
    """
    plane, points = profile.plane, points[:: 1 + len(points) // FITTED]
    u, h = to_plane(points, plane), points @ plane.normal
    off, deep = u - u.mean(axis=0), h - h.mean()
    spread = off.T @ off
    slope = np.linalg.solve(
        spread + (0.01 * (np.trace(spread) + deep @ deep) + 1e-12) * np.eye(2), off.T @ deep
    )
    middle = h.mean() - slope @ u.mean(axis=0)

    omega, v = (
        profile.rotation[body] @ profile.delta_omega[body],
        profile.rotation[body] @ profile.delta_v[body],
    )
    along, up, deeper = np.cross(omega, [plane.e1, plane.e2, plane.normal])
    c = v + middle * deeper - np.cross(omega, profile.position[body])
    return Field(
        c / profile.v_in, (np.stack([along, up], axis=1) + np.outer(deeper, slope)) / profile.v_in
    )


@memoized(most=4)
def _silhouettes(
    robot: Robot, rotation: bytes, position: bytes, normal: tuple[float, ...]
) -> tuple[tuple[PlaneShape, ...], tuple[Array, ...], tuple[bool, ...]]:
    """The silhouettes of a robot; landings in one posture share them.

    Args:
        robot: the robot.
        rotation: (nb, 3, 3) of the bodies, to world axes; as bytes, by which results are kept.
        position: (nb, 3) of their frames' origins [m]; as bytes.
        normal: of the plane.

    Returns: silhouettes, points (n, 3) on the surface [m] or the centre of mass of what has no
        shape, and whether the box of the inertia is one of the shapes, all by body.
    """
    plane = plane_from(normal)
    places = list(
        zip(
            np.frombuffer(rotation).reshape(-1, 3, 3),
            np.frombuffer(position).reshape(-1, 3),
            strict=True,
        )
    )
    shapes_of_bodies = body_shapes(robot)
    shapes = [
        [shape.placed(*place) for shape in unplaced]
        for (unplaced, _), place in zip(shapes_of_bodies, places, strict=True)
    ]
    bodies = zip(shapes, robot.bodies, places, strict=True)
    world = tuple(
        surface(placed) if placed else (body.com @ turn.T + origin)[None]
        for placed, body, (turn, origin) in bodies
    )
    size = max(
        float(np.ptp(corners_of_box(to_plane(np.concatenate(world), plane)), axis=0).max()), 1e-6
    )
    # Holes and gaps that are too fine to be seen are closed.
    fine = 2.0 * RESOLUTION * size
    edges: dict[int, Edges] = {}
    regions = [silhouette(placed, plane, RESOLUTION * size, edges) for placed in shapes]
    closed = [
        region.buffer(fine, join_style="mitre")
        .buffer(-fine, join_style="mitre")
        .simplify(fine / 4.0)
        for region in regions
    ]
    return tuple(closed), world, tuple(boxed for _, boxed in shapes_of_bodies)


def body_shapes(robot: Robot) -> list[tuple[tuple[Shape, ...], bool]]:
    """The shapes of each body, visual rather than collision, and whether the box of its inertia
    stands for what has no shape.
    """
    visual, _, unread, _ = drawn_outline(robot)
    collision = outline(robot, "collision").shapes if not all(visual) else visual
    missing = {shape.link for shape in unread}
    chosen: list[tuple[tuple[Shape, ...], bool]] = []
    for body, seen, solid in zip(robot.bodies, visual, collision, strict=True):
        shapes, box = seen or solid, inertia_box(body)
        # Where a mesh is missing, what is left may be the smallest part of a body, such as the
        # marker of a sensor on a trunk.
        lost = not shapes or not missing.isdisjoint(body.links)
        boxed = (
            (*shapes, box) if lost and box is not None and _extent([box]) > _extent(shapes) else ()
        )
        chosen.append((boxed or shapes, bool(boxed)))
    return chosen


def _extent(shapes: Sequence[Shape]) -> float:
    """The largest extent of some shapes along an axis of their body [m]."""
    return float(np.ptp(corners_of_box(surface(shapes)), axis=0).max()) if shapes else 0.0


class Window(NamedTuple):
    """The part of the plane that a picture shows.

    Attributes:
        low, high: (2,) lower left and upper right corner [m].
        inch: length of an inch of paper [m].
        arrow: length of the arrow of the fastest contact [m].
    """

    low: Array
    high: Array
    inch: float
    arrow: float = 0.0

    @property
    def sides(self) -> tuple[float, float]:
        """Width and height on paper [inches]."""
        width, height = (self.high - self.low) / self.inch
        return float(width), float(height)

    def holds(self, points: Array, margin: float = 0.0) -> Array:
        """Whether points (..., 2) [m] lie inside, at least a margin [inches] from the border."""
        slack = margin * self.inch
        return np.asarray(
            np.all((points >= self.low + slack) & (points <= self.high - slack), axis=-1)
        )


def windows_of(
    views: Sequence[View],
    near: tuple[float, float],
    most: tuple[float, float],
    least: tuple[float, float],
    pad: float = 0.25,
    arrow: float = 0.62,
) -> list[Window]:
    """Windows side by side, on one scale and of one height.

    Each holds the robot, contacts with their velocities, sensors, and the centres of percussion
    that are near.

    Args:
        views: one for each window.
        near: distance of a numbered centre of percussion from the robot, sideways and up, as a
            share of the robot's size, up to which it is near.
        most: width of all windows together, and their height [inches].
        least: width of each window, and their height [inches].
        pad: room around what a window holds [inches].
        arrow: length of the arrow of the fastest contact [inches].
    """
    length = 0.0
    # An arrow has its length on paper, so the room that it needs depends on the scale, and the
    # scale on that room.
    for _ in range(4):
        corners = []
        for view in views:
            slack = np.array(near) * view.size
            numbered = [centre for i, centre in view.centres.items() if i in view.numbers]
            centres = [
                centre
                for centre in numbered
                if np.all((centre > view.low - slack) & (centre < view.high + slack))
            ]
            tips = view.contacts + length * view.velocities
            points = np.vstack([view.low, view.high, view.contacts, tips, view.sensors, *centres])
            corners.append((points.min(axis=0), points.max(axis=0)))
        low, high = np.array(corners).swapaxes(0, 1)
        low[:, 1], high[:, 1] = low[:, 1].min(), high[:, 1].max()
        wide, tall = np.sum(high[:, 0] - low[:, 0]), high[0, 1] - low[0, 1]
        inch = max(
            float(wide / (most[0] - 2.0 * pad * len(views))),
            float(tall / (most[1] - 2.0 * pad)),
            1e-9,
        )
        length = arrow * inch
    half = np.maximum((high - low) / 2.0 + pad * inch, np.array(least) * inch / 2.0)
    return [
        Window(middle - side, middle + side, inch, length)
        for middle, side in zip((low + high) / 2.0, half, strict=True)
    ]
