"""What is drawn over the bodies: centres and radii of percussion, joints, sensors and the velocities of the contacts."""

from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch
from matplotlib.path import Path

from shockpc.core.spatial import Array
from shockpc.model.closure import loop_of
from shockpc.result import ShockProfile
from shockpc.show.figure.labels import Labels
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.figure.silhouette import Region, to_plane
from shockpc.show.figure.view import View
from shockpc.show.figure.window import ARROW, Window, velocities_in_plane

__all__ = ["SIGNS", "arrow", "draw_marks", "letter"]

ARROW_SIGN = Path([(-1, 0), (0.3, 0), (0.3, 0.25), (1, 0), (0.3, -0.25), (0.3, 0)])
CROSSED = Path.make_compound_path(Path.unit_circle(), Path([[-1, 0], [1, 0], [0, -1], [0, 1]], [1, 2, 1, 2]))

_MARK: dict[str, Any] = {"linestyle": "none", "color": INK, "markeredgecolor": INK}

SIGNS: dict[str, dict[str, Any]] = {
    "arrow": _MARK | {"marker": ARROW_SIGN, "markersize": 14.0, "markeredgewidth": 1.5},
    "ring": _MARK | {"marker": "o", "markersize": 12.0, "fillstyle": "none", "markeredgewidth": 1.2, "zorder": 7},
    "centre": _MARK | {"marker": CROSSED, "markersize": 8.0, "markerfacecolor": PAPER, "markeredgewidth": 1.0, "zorder": 7},
    "circle": {"color": INK, "linestyle": (0, (5, 3)), "linewidth": 0.55, "zorder": 0.5},
    "joint": _MARK | {"marker": "o", "markersize": 2.6, "markerfacecolor": PAPER, "markeredgewidth": 0.5, "zorder": 4},
    "sensor": _MARK | {"marker": "D", "markersize": 4.2, "markerfacecolor": "#ffd24d", "markeredgewidth": 0.7, "zorder": 7},
}
"""Look of every sign; that of the arrow is for the key."""

OWN = 0.07
"""Room that a centre of percussion takes around itself [inches]."""

WHOLE = 0.75
"""Share of the circle of radius RoPc that has to be inside the picture for the circle to be drawn."""


def draw_marks(axes: Axes, profile: ShockProfile, view: View, window: Window, numbers: dict[int, int]) -> set[str]:
    """Draw all marks and return which of `SIGNS` occur.

    Args:
        axes: in plane coordinates [m].
        profile: the shock of a landing.
        view: the bodies in the plane.
        window: the part of the plane that the axes show.
        numbers: by index of the body, the number of the body and of its centre of percussion.
    """
    labels = Labels(axes, window, shapely.union_all([drawn.region for drawn in view.drawn]))
    centres = to_plane(profile.copc_world, profile.plane)
    visible = [i for i in numbers if not profile.translates[i] and window.holds(centres[i], 0.05)]
    sensors = [to_plane(point.position, profile.plane) for point in profile.points]
    joints = [place for place in _joints(profile) if window.holds(place)]
    found = {"joint": joints, "centre": [centres[i] for i in visible], "sensor": sensors}
    for sign, room in (("joint", 0.03), ("sensor", 0.06), ("centre", OWN)):
        for place in found[sign]:
            labels.keep_free(place, room)
    signs = {
        _velocity(axes, to_plane(contact.point, profile.plane), velocity, labels, window)
        for contact, velocity in zip(profile.contacts, velocities_in_plane(profile), strict=True)
    }
    for sign, places in found.items():
        for place in places:
            axes.plot(*place, **SIGNS[sign])
            signs.add(sign)
    _tags(view, numbers, labels)
    groups: list[list[int]] = []
    for i in visible:
        near = [group for group in groups if np.linalg.norm(centres[group[0]] - centres[i]) < OWN * window.inch]
        (near[0].append(i) if near else groups.append([i]))
        signs |= _circle(axes, centres[i], float(profile.ropc[i]), window)
    for group in groups:
        labels.place(centres[group[0]], ", ".join(str(numbers[i]) for i in group), gap=OWN)
    for k, place in enumerate(sensors):
        labels.place(place, letter(k), gap=0.06)
    return signs


def letter(index: int) -> str:
    """The letter that stands for a sensor: a to z, then aa, ab and so on."""
    return (letter(index // 26 - 1) if index >= 26 else "") + chr(ord("a") + index % 26)


def arrow(tail: Array, tip: Array, width: float, head: float, colour: str = INK, zorder: float = 7.0) -> FancyArrowPatch:
    """An arrow between two points (2,)."""
    style: dict[str, Any] = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "joinstyle": "miter", "posA": tail, "posB": tip}
    return FancyArrowPatch(mutation_scale=head, linewidth=width, color=colour, zorder=zorder, **style)


def _circle(axes: Axes, centre: Array, radius: float, window: Window) -> set[str]:
    """Draw the circle on which shock is 1, if enough of it is inside the picture; return the sign."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if np.mean([window.holds(point) for point in circle]) < WHOLE:
        return set()
    axes.plot(*circle.T, **SIGNS["circle"])
    return {"circle"}


def _tags(view: View, numbers: dict[int, int], labels: Labels) -> None:
    """Write the number of every numbered body on its visible part."""
    nearer: Region = shapely.MultiPolygon()
    for drawn in reversed(view.drawn):
        if drawn.body in numbers:
            visible = shapely.difference(drawn.region, nearer)
            if visible.area > 0.15 * drawn.region.area:
                labels.tag(visible, str(numbers[drawn.body]))
        if not drawn.outlined:
            nearer = shapely.union(nearer, drawn.region)


def _joints(profile: ShockProfile) -> Array:
    """Places (n, 2) of the joints between bodies, and of those that close loops [m]."""
    robot = profile.robot
    loops = (*robot.loops, *(loop_of(robot, closure) for closure in profile.scene.closure))
    ends = [next((i, p) for i, p in zip(loop.bodies, loop.points, strict=True) if i >= 0) for loop in loops if not loop.turns]
    closed = [profile.position[i] + profile.rotation[i] @ p for i, p in ends]
    return to_plane(np.array([*profile.position[1 if robot.free_base else 0 :], *closed]).reshape(-1, 3), profile.plane)


def _velocity(axes: Axes, place: Array, velocity: Array, labels: Labels, window: Window) -> str:
    """Draw the velocity of a contact: an arrow, or a ring if it is almost perpendicular to the plane; return which."""
    axes.plot(*place, "o", markersize=5.0, markerfacecolor=INK, markeredgecolor=PAPER, markeredgewidth=0.6, zorder=7)
    labels.keep_free(place, 0.09)
    speed = float(np.linalg.norm(velocity))
    if speed < 0.05:
        axes.plot(*place, **SIGNS["ring"])
        return "ring"
    tip = place + ARROW * window.inch * velocity
    for width, colour, zorder in ((4.2, PAPER, 6.8), (1.9, INK, 7.0)):
        axes.add_patch(arrow(place, tip, width, 13.0 * min(1.0, 0.3 + speed), colour, zorder))
    for share in (0.35, 0.7, 1.0):
        labels.keep_free(place + share * (tip - place), 0.07)
    return "arrow"
