"""What is drawn over the bodies: centres and radii of percussion, joints, sensors and strikes."""

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from shockpc.core.spatial import Array
from shockpc.model.closure import loop_of
from shockpc.result import ShockProfile
from shockpc.show.figure.labels import Labels
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.figure.pointers import draw_pointers
from shockpc.show.figure.silhouette import Region, to_plane
from shockpc.show.figure.view import View
from shockpc.show.figure.window import ARROW, Window, letter, strikes_in_plane

__all__ = ["DASHED", "SENSOR", "draw_marks", "percussion_mark"]

DASHED = (0, (5, 3))
SENSOR = "#ffd24d"

OWN = 0.07
"""Half the room that a centre of percussion keeps for itself; its number stands right beside that [inches]."""

APART = 0.08
"""Distance from its body at which a centre of percussion is no longer seen to belong to it [inches]."""


def draw_marks(
    axes: Axes, profile: ShockProfile, view: View, window: Window, numbers: dict[int, int], whole: float = 0.45, tied: bool = False
) -> frozenset[str]:
    """Draw all marks.

    Args:
        axes: in plane coordinates [m].
        profile: the shock of a landing.
        view: the bodies in the plane.
        window: what the picture shows.
        numbers: by index of the body, the number that it and its centre of percussion carry.
        whole: share of a RoPc's circle for which the picture has to have room.
        tied: whether a line goes from each numbered body to its centre of percussion.

    Returns: which signs occur, of "centre", "other centre", "tie", "radius", "pointer", "other pointer" and "joint".
    """
    labels = Labels(axes, window, shapely.union_all([drawn.region for drawn in view.drawn]))
    centres = to_plane(profile.copc_world, profile.plane)
    turning = [drawn.body for drawn in view.drawn if not profile.translates[drawn.body]]
    visible = [i for i in turning if window.holds(centres[i], 0.05)]
    numbered = [i for i in numbers if i in visible]
    sensors = [to_plane(point.position, profile.plane) for point in profile.points]
    signs = {"joint"} if _joints(axes, profile, labels, window) else set()
    for i in numbered:
        labels.keep_free(centres[i], OWN)
    for place in sensors:
        labels.keep_free(place, 0.06)
    for contact, velocity in zip(profile.contacts, strikes_in_plane(profile), strict=True):
        _strike(axes, to_plane(contact.point, profile.plane), velocity, labels, window)
    if _tags(axes, view, numbers, labels, window, {i: centres[i] for i in numbered} if tied else {}):
        signs.add("tie")
    for i in visible:
        if i not in numbers:
            _small_centre(axes, centres[i])
            signs.add("other centre")
    for i in numbered:
        percussion_mark(axes, *centres[i])
        signs.add("centre")
        if _radius(axes, centres[i], float(profile.ropc[i]), window, whole):
            signs.add("radius")
    # Pointers come before the labels of marks: theirs are the longest, and a short one finds its place around an arrow.
    beyond = [i for i in (*numbers, *turning) if i in turning and i not in visible]
    draw_pointers(axes, profile, list(dict.fromkeys(beyond)), numbers, labels, window)
    for group in _together(numbered, centres, 0.07 * window.inch):
        labels.place(centres[group[0]], ", ".join(str(numbers[i]) for i in group), gap=OWN + 0.005)
    for k, place in enumerate(sensors):
        axes.plot(*place, "D", markersize=4.2, markerfacecolor=SENSOR, markeredgecolor=INK, markeredgewidth=0.7, zorder=7)
        labels.place(place, letter(k))
    signs |= {"pointer" if i in numbers else "other pointer" for i in beyond}
    return frozenset(signs)


def _together(bodies: list[int], centres: Array, near: float) -> list[list[int]]:
    """Bodies whose centres fall on one another, so that they can share a label; `near` [m]."""
    groups: list[list[int]] = []
    for i in bodies:
        group = next((g for g in groups if np.linalg.norm(centres[g[0]] - centres[i]) < near), None)
        if group is None:
            groups.append([i])
        else:
            group.append(i)
    return groups


def percussion_mark(axes: Axes, x: float, y: float) -> None:
    """The sign of a centre of percussion: a crossed circle."""
    axes.plot(x, y, "o", markersize=7.5, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=1.0, zorder=7)
    axes.plot(x, y, "+", markersize=7.5, color=INK, markeredgewidth=0.9, zorder=7)


def _small_centre(axes: Axes, place: Array) -> None:
    axes.plot(*place, "+", markersize=5.0, color=PAPER, markeredgewidth=1.8, zorder=6)
    axes.plot(*place, "+", markersize=4.2, color=INK, markeredgewidth=0.7, zorder=6)


def _radius(axes: Axes, centre: Array, radius: float, window: Window, whole: float) -> bool:
    """The circle on which shock equals the strike, if the picture has room for that share of it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    fits = bool(np.mean([window.holds(point) for point in circle]) > whole)
    if fits:
        axes.plot(*circle.T, color=INK, linewidth=0.55, linestyle=DASHED, zorder=0.5)
    return fits


def _tags(axes: Axes, view: View, numbers: dict[int, int], labels: Labels, window: Window, tied: dict[int, Array]) -> bool:
    """The number of every numbered body, on what is seen of it, and whether any has a line to the body's centre apart from it."""
    lines = False
    nearer: Region = shapely.MultiPolygon()
    for drawn in reversed(view.drawn):
        if drawn.body in numbers:
            parts = shapely.get_parts(shapely.difference(drawn.region, nearer))
            seen = max(parts, key=lambda part: part.area, default=None)
            if seen is not None and seen.geom_type == "Polygon" and seen.area > 0.15 * drawn.region.area:
                centre = tied.get(drawn.body)
                if centre is not None and shapely.distance(drawn.region, shapely.Point(centre)) < APART * window.inch:
                    centre = None
                place = _tag_place(seen, labels, window, centre)
                labels.tag(place, str(numbers[drawn.body]))
                if centre is not None:
                    labels.tie(place, centre)
                    lines = True
        if not drawn.glass:
            nearer = shapely.union(nearer, drawn.region)
    return lines


def _tag_place(seen: Region, labels: Labels, window: Window, centre: Array | None) -> Array:
    """A place well inside a polygon, clear of marks, near its middle, and with a free way to the centre that it is tied to."""
    x0, y0, x1, y1 = seen.bounds
    grid = np.stack(np.meshgrid(np.linspace(x0, x1, 25), np.linspace(y0, y1, 25)), axis=-1).reshape(-1, 2)
    grid = np.concatenate([grid, [[seen.centroid.x, seen.centroid.y], shapely.get_coordinates(seen.point_on_surface())[0]]])
    grid = grid[shapely.contains_xy(seen, *grid.T)]
    depth = shapely.distance(shapely.points(grid), seen.boundary) / window.inch
    middle = np.linalg.norm(grid - [seen.centroid.x, seen.centroid.y], axis=1) / window.inch
    clear = np.array([labels.clearance(place) for place in grid])
    score = np.minimum(depth, 0.1) + np.minimum(clear, 0.2) - 0.05 * middle
    if centre is not None:
        score -= 0.2 * labels.between(grid, centre)
    return np.asarray(grid[np.argmax(score)])


def _joints(axes: Axes, profile: ShockProfile, labels: Labels, window: Window) -> bool:
    """A dot at every joint between two bodies, and where a loop is closed."""
    first = 1 if profile.robot.free_base else 0
    loops = (*profile.robot.loops, *(loop_of(profile.robot, closure) for closure in profile.scene.closure))
    ends = [next((i, p) for i, p in zip(loop.bodies, loop.points, strict=True) if i >= 0) for loop in loops if not loop.turns]
    joints = [*profile.position[first:], *(profile.position[i] + profile.rotation[i] @ p for i, p in ends)]
    places = [place for place in to_plane(np.array(joints).reshape(-1, 3), profile.plane) if window.holds(place)]
    for place in places:
        labels.keep_free(place, 0.03)
        axes.plot(*place, "o", markersize=2.6, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5, zorder=4)
    return bool(places)


def _strike(axes: Axes, place: Array, velocity: Array, labels: Labels, window: Window) -> None:
    """The velocity at which a contact comes down, from the contact on; only a ring around it if it hardly moves in the plane."""
    axes.plot(*place, "o", markersize=5.0, markerfacecolor=INK, markeredgecolor=PAPER, markeredgewidth=0.6, zorder=7)
    labels.keep_free(place, 0.09)
    speed = float(np.linalg.norm(velocity))
    if speed < 0.05:
        axes.plot(*place, "o", markersize=12.0, fillstyle="none", color=INK, markeredgewidth=1.2, zorder=7)
        return
    tip = place + ARROW * window.inch * velocity
    for width, colour, z in ((4.2, PAPER, 6.8), (1.9, INK, 7.0)):
        axes.add_patch(
            FancyArrowPatch(
                tuple(place),
                tuple(tip),
                arrowstyle="-|>",
                mutation_scale=13.0 * min(1.0, 0.3 + speed),
                linewidth=width,
                color=colour,
                shrinkA=0,
                shrinkB=0,
                joinstyle="miter",
                zorder=z,
            )
        )
    for share in (0.35, 0.7, 1.0):
        labels.keep_free(place + share * (tip - place), 0.07)
