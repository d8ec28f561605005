"""What is drawn over the bodies: centres and radii of percussion, joints, sensors, strikes and the scale bar."""

import math
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch

from shockpc.core.spatial import Array
from shockpc.record import ShockProfile
from shockpc.show.figure_labels import Labels
from shockpc.show.figure_view import View
from shockpc.show.palette import INK, PAPER
from shockpc.show.silhouette import to_plane

__all__ = ["Window", "draw_marks", "letter", "percussion_mark", "strike_in_plane"]

ARROW = 0.62
"""Length of a strike arrow [inches]."""


class Window(NamedTuple):
    """The part of the plane that the picture shows.

    Attributes:
        low: (2,) lower left corner [m].
        high: (2,) upper right corner [m].
        inch: length of an inch of paper [m].
    """

    low: Array
    high: Array
    inch: float

    def holds(self, point: Array, margin: float = 0.0) -> bool:
        """Whether a point (2,) [m] lies inside, at least a margin [inches] from the border."""
        slack = margin * self.inch
        return bool(np.all(point >= self.low + slack) and np.all(point <= self.high - slack))


def letter(index: int) -> str:
    """The letter that stands for a sensor: a … z, then aa, ab, …"""
    return (letter(index // 26 - 1) if index >= 26 else "") + chr(ord("a") + index % 26)


def strike_in_plane(profile: ShockProfile) -> Array:
    """The strike (2,) along e1 and e2, relative to its speed [1]."""
    return to_plane(profile.strike, profile.plane) / float(np.linalg.norm(profile.strike))


def draw_marks(axes: Axes, profile: ShockProfile, view: View, window: Window, numbers: dict[int, int]) -> None:
    """Draw all marks.

    Args:
        axes: in plane coordinates [m].
        profile: the shock of a landing.
        view: the bodies in the plane.
        window: what the picture shows.
        numbers: by index of the body, the number of its centre of percussion.
    """
    labels = Labels(axes, window.inch, (*window.low, *window.high))
    _joints(axes, profile, window)
    for contact in profile.contacts:
        _strike(axes, to_plane(contact.point, profile.plane), strike_in_plane(profile), labels, window)
    _scale_bar(axes, window, labels)
    centres = to_plane(profile.copc_world, profile.plane)
    visible = [i for i in numbers if window.holds(centres[i], 0.05)]
    sensors = [to_plane(point.position, profile.plane) for point in profile.points]
    for i in visible:
        labels.keep_free(*centres[i], 0.07)
    for place in sensors:
        labels.keep_free(*place, 0.06)
    for drawn in view.drawn:
        i = drawn.body
        if i not in numbers and not profile.translates[i] and window.holds(centres[i], 0.05):
            _small_centre(axes, centres[i])
    for i in visible:
        percussion_mark(axes, *centres[i])
        _radius(axes, centres[i], float(profile.ropc[i]), window)
        labels.place(*centres[i], str(numbers[i]), weight="bold")
    for k, place in enumerate(sensors):
        axes.plot(*place, "D", markersize=4.2, markerfacecolor="#ffd24d", markeredgecolor=INK, markeredgewidth=0.7, zorder=7)
        labels.place(*place, letter(k), weight="bold")
    for i in numbers:
        if i not in visible and not profile.translates[i]:
            start = np.clip(to_plane(profile.position[i], profile.plane), window.low, window.high)
            _pointer(axes, start, centres[i], numbers[i], labels, window)


def percussion_mark(axes: Axes, x: float, y: float) -> None:
    """The sign of a centre of percussion: a crossed circle."""
    axes.plot(x, y, "o", markersize=7.5, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=1.0, zorder=7)
    axes.plot(x, y, "+", markersize=7.5, color=INK, markeredgewidth=0.9, zorder=7)


def _small_centre(axes: Axes, place: Array) -> None:
    axes.plot(*place, "+", markersize=5.0, color=PAPER, markeredgewidth=1.8, zorder=6)
    axes.plot(*place, "+", markersize=4.2, color=INK, markeredgewidth=0.7, zorder=6)


def _radius(axes: Axes, centre: Array, radius: float, window: Window) -> None:
    """The circle on which shock equals the strike, if the picture has room for all of it."""
    if all(window.holds(centre + radius * np.array(d)) for d in ((1, 0), (-1, 0), (0, 1), (0, -1))):
        axes.add_patch(Circle(tuple(centre), radius, fill=False, edgecolor=INK, linewidth=0.6, linestyle=(0, (5, 3)), zorder=5))


def _joints(axes: Axes, profile: ShockProfile, window: Window) -> None:
    """A dot at every joint between two bodies."""
    first = 1 if profile.robot.free_base else 0
    for place in to_plane(profile.position[first:], profile.plane):
        if window.holds(place):
            axes.plot(*place, "o", markersize=2.6, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5, zorder=4)


def _strike(axes: Axes, place: Array, direction: Array, labels: Labels, window: Window) -> None:
    """The velocity at which a contact comes down, from the contact on; a ringed cross or dot if it is across the plane."""
    length = ARROW * window.inch
    axes.plot(*place, "o", markersize=4.0, color=INK, zorder=7)
    if np.linalg.norm(direction) < 0.05:
        axes.plot(*place, "o", markersize=12.0, fillstyle="none", color=INK, markeredgewidth=1.2, zorder=7)
        labels.keep_free(*place, 0.09)
        return
    tip = place + length * direction
    for width, colour, z in ((4.2, PAPER, 6.8), (1.9, INK, 7.0)):
        axes.add_patch(
            FancyArrowPatch(
                tuple(place), tuple(tip), arrowstyle="-|>", mutation_scale=13, linewidth=width, color=colour,
                shrinkA=0, shrinkB=0, joinstyle="miter", zorder=z,
            )
        )
    for share in (0.0, 0.35, 0.7, 1.0):
        labels.keep_free(*(place + share * (tip - place)), 0.07)


def _pointer(axes: Axes, start: Array, centre: Array, number: int, labels: Labels, window: Window) -> None:
    """An arrow at the border towards a centre outside the picture, with its number and how far behind the border it lies."""
    direction = centre - start
    distance = float(np.linalg.norm(direction))
    direction /= distance
    inset = 0.04 * window.inch
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(direction > 0.0, window.high - inset - start, window.low + inset - start) / direction
    tip = start + direction * float(np.nanmin(np.where(np.abs(direction) > 1e-12, reach, np.nan)))
    tail = tip - 0.3 * window.inch * direction
    axes.add_patch(
        FancyArrowPatch(tuple(tail), tuple(tip), arrowstyle="-|>", mutation_scale=9, linewidth=1.0, color=INK, shrinkA=0, shrinkB=0, zorder=7)
    )
    percussion_mark(axes, *tail)
    labels.keep_free(*tail, 0.07)
    labels.keep_free(*tip, 0.05)
    labels.place(*tail, f"{number}: {length(float(np.linalg.norm(centre - tip)))}", weight="bold")


def length(metres: float) -> str:
    """A length to two or three digits, with its unit; kilometres and millimetres where metres would be long."""
    for unit, size in (("km", 1000.0), ("m", 1.0), ("mm", 1e-3)):
        if metres >= 0.9995 * size or unit == "mm":
            value = metres / size
            digits = max(0, 1 - math.floor(math.log10(value))) if value > 0.0 else 0
            return f"{value:.{min(digits, 2)}f} {unit}" if value < 1e4 else f"{value:.0e} {unit}"
    raise AssertionError


def _scale_bar(axes: Axes, window: Window, labels: Labels) -> None:
    """A bar of a round length near a fifth of the picture, at its lower left."""
    width = float(window.high[0] - window.low[0])
    power = 10.0 ** math.floor(math.log10(0.25 * width))
    bar = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= 0.25 * width)
    x, y = window.low + 0.14 * window.inch
    tick = 0.035 * window.inch
    axes.plot([x, x, x, x + bar, x + bar, x + bar], [y - tick, y + tick, y, y, y - tick, y + tick], color=INK, linewidth=1.0, zorder=8)
    axes.text(x + bar / 2.0, y + 0.05 * window.inch, length(bar), fontsize=7.5, ha="center", va="bottom", color=INK, zorder=8)
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        labels.keep_free(x + share * bar, y + 0.05 * window.inch, 0.12)
