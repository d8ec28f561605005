"""A landing in the plane of the figure: silhouettes and shock of the bodies, places of all marks, the window that holds them."""

import functools
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike

from shockpc.core.spatial import Array, Plane, plane_from
from shockpc.model.closure import all_loops
from shockpc.model.dynamics import dynamics
from shockpc.result import ShockProfile
from shockpc.robot.geometry import Shape, inertia_box, outline
from shockpc.robot.robot import Robot
from shockpc.show.figure.silhouette import Region, silhouette, to_plane

__all__ = ["Drawn", "Field", "View", "Window", "body_shapes", "field_of", "numbered", "view_of", "windows_of"]

FEW = 6
"""A robot with up to this many bodies has all of them numbered."""

RESOLUTION = 1e-3
"""Largest distance of a silhouette from the true one, as a share of the robot's size in the figure."""

ARROW = 0.13
"""Length of the arrow of the fastest contact, as a share of the robot's size."""

_SIDES = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


class Field(NamedTuple):
    """Normalised shock of a body over plane coordinates u: |c + A (u − origin)|.

    Its square is a quadratic form: circles about the CoPc if the body moves in the plane. For a body that also moves out of the
    plane the shock depends on depth as well; the field is then that on the surface through its middle.

    The origin (2,) [m] is that of the body's frame, c (3,) its Δv over v_in [1], A (3, 2) the derivative along e1 and e2 [1/m].
    """

    origin: Array
    c: Array
    A: Array

    def at(self, u: Array) -> Array:
        """Shock (...) at plane coordinates u (..., 2) [1]."""
        return np.asarray(np.linalg.norm(self.c + (u - self.origin) @ self.A.T, axis=-1))


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
    """A landing in plane coordinates [m].

    Attributes:
        drawn: bodies, farthest first.
        struck: indices of the bodies between contacts and base, base first.
        low, high: (2,) lower left and upper right corner of all bodies.
        contacts: (n, 2) contact points.
        velocities: (n, 2) of these before the impact, relative to the speed of the fastest [1].
        joints: (n, 2) joints between bodies, and those that close loops.
        sensors: (n, 2) sensors and points.
        centres: CoPc (2,) of each body that rotates in the plane, by its index.
        radii: (n,) RoPc of all bodies.
    """

    drawn: tuple[Drawn, ...]
    struck: tuple[int, ...]
    low: Array
    high: Array
    contacts: Array
    velocities: Array
    joints: Array
    sensors: Array
    centres: dict[int, Array]
    radii: Array

    @property
    def size(self) -> float:
        """The larger side of the robot [m]."""
        return max(float((self.high - self.low).max()), 1e-6)


def view_of(profile: ShockProfile) -> View:
    """Project a landing; the viewer looks against the plane's normal, with e1 to the right and e2 up."""
    robot, plane = profile.robot, profile.plane
    regions, world, boxed, size = _silhouettes(robot, tuple(profile.q.tolist()), tuple(plane.normal.tolist()))
    struck = {0}
    for contact in profile.scene.contact:
        i = robot.frame(contact.frame).body
        while i > 0:
            struck.add(i)
            i = robot.parents[i]
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
    approach = np.stack([contact.approach for contact in profile.contacts]) / float(np.linalg.norm(profile.strike))
    loops = [loop for loop in all_loops(robot, profile.scene.closure) if not loop.turns]
    ends = [next((i, p) for i, p in zip(loop.bodies, loop.points, strict=True) if i >= 0) for loop in loops]
    pins = [*profile.position[1 if robot.free_base else 0 :], *(profile.position[i] + profile.rotation[i] @ p for i, p in ends)]
    centres = to_plane(profile.copc_world, plane)
    return View(
        drawn=tuple(drawn),
        struck=tuple(sorted(struck)),
        low=bounds[:2],
        high=bounds[2:],
        contacts=to_plane(np.stack([contact.point for contact in profile.contacts]), plane),
        velocities=to_plane(approach, plane),
        joints=to_plane(np.array(pins).reshape(-1, 3), plane),
        sensors=to_plane(np.array([point.position for point in profile.points]).reshape(-1, 3), plane),
        centres={i: centres[i] for i in range(len(centres)) if not profile.translates[i]},
        radii=profile.ropc,
    )


def numbered(profile: ShockProfile, view: View) -> list[int]:
    """Bodies that carry a number: all of a small robot; else those between contacts and base, and the heaviest."""
    bodies = profile.robot.bodies
    if len(bodies) <= FEW:
        return list(range(len(bodies)))
    return sorted({*view.struck, max(range(len(bodies)), key=lambda i: bodies[i].mass)})


def field_of(profile: ShockProfile, body: int, points: Array) -> Field:
    """The field of a body on the surface through the middle of points (n, 3) on it, world axes [m]."""
    plane = profile.plane
    omega, v = profile.rotation[body] @ profile.delta_omega[body], profile.rotation[body] @ profile.delta_v[body]
    A = np.stack([np.cross(omega, plane.e1), np.cross(omega, plane.e2)], axis=1)
    depth, slope = _middle(points - profile.position[body], plane)
    deeper = np.cross(omega, plane.normal)
    v, A = v + depth * deeper, A + np.outer(deeper, slope)
    return Field(to_plane(profile.position[body], plane), v / profile.v_in, A / profile.v_in)


def _middle(points: Array, plane: Plane) -> tuple[float, Array]:
    """The plane through the middle of points: its depth at the origin [m] and its slope (2,) along e1 and e2 [1].

    Least squares of the depth; a slope that the points determine poorly, such as across a thin rod, stays near zero.
    """
    u, h = to_plane(points, plane), points @ plane.normal
    off, deep = u - u.mean(axis=0), h - h.mean()
    spread = off.T @ off
    slope = np.linalg.solve(spread + (0.01 * (np.trace(spread) + deep @ deep) + 1e-12) * np.eye(2), off.T @ deep)
    return float(h.mean() - slope @ u.mean(axis=0)), slope


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
        return np.asarray(np.all((points >= self.low + slack) & (points <= self.high - slack), axis=-1))


def windows_of(
    views: Sequence[View],
    numbers: Sequence[Collection[int]],
    near: tuple[float, float],
    most: tuple[float, float],
    least: tuple[float, float],
    pad: float = 0.25,
) -> list[Window]:
    """Windows side by side, on one scale and of one height.

    Each holds the robot, contacts with their velocities, sensors, and the centres of percussion that are near.

    Args:
        views: one for each window.
        numbers: bodies whose centres of percussion are held if they are near.
        near: distance of a centre from the robot, sideways and up, as a share of the robot's size, up to which it is near.
        most: width of all windows together, and their height [inches].
        least: width of each window, and their height [inches].
        pad: room around what a window holds [inches].
    """
    arrow = ARROW * max(view.size for view in views)
    corners = []
    for view, own in zip(views, numbers, strict=True):
        slack = np.array(near) * view.size
        wide = Window(view.low - slack, view.high + slack, 1.0)
        centres = [centre for i, centre in view.centres.items() if i in own and wide.holds(centre)]
        held: list[ArrayLike] = [
            [view.low, view.high],
            view.contacts,
            view.contacts + arrow * view.velocities,
            view.sensors,
            centres,
        ]
        every = np.concatenate([np.reshape(points, (-1, 2)) for points in held])
        corners.append((every.min(axis=0), every.max(axis=0)))
    low, high = np.array(corners).swapaxes(0, 1)
    low[:, 1], high[:, 1] = low[:, 1].min(), high[:, 1].max()
    wide_, tall = np.sum(high[:, 0] - low[:, 0]), high[0, 1] - low[0, 1]
    inch = max(float(wide_ / (most[0] - 2.0 * pad * len(views))), float(tall / (most[1] - 2.0 * pad)), 1e-9)
    half = np.maximum((high - low) / 2.0 + pad * inch, np.array(least) * inch / 2.0)
    return [Window(middle - side, middle + side, inch, arrow) for middle, side in zip((low + high) / 2.0, half, strict=True)]
