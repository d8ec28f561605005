"""Arrows at the border towards what lies outside the picture."""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from shockpc.core.spatial import Array
from shockpc.result import ShockProfile
from shockpc.show.figure.labels import Labels
from shockpc.show.figure.palette import INK, faded
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.window import Window, length

__all__ = ["draw_pointers"]

APART = 0.3
"""Least distance between two numbered pointers [inches]."""

LONG = 0.28
"""Length of a numbered pointer [inches]."""

MOVED = 0.6
"""How far along the border a numbered pointer may give way to a body or a mark [inches]; further on it would mislead."""


def draw_pointers(
    axes: Axes, profile: ShockProfile, bodies: list[int], numbers: dict[int, int], labels: Labels, window: Window
) -> None:
    """Point from the border to each centre of percussion outside; a numbered one says how far behind the border it lies.

    Args:
        axes: in plane coordinates [m].
        profile: the shock of a landing.
        bodies: indices of the bodies whose centre lies outside, the numbered ones first.
        numbers: by index of the body.
        labels: of the picture.
        window: what the picture shows.
    """
    centres = to_plane(profile.copc_world, profile.plane)
    marks: list[_Pointer] = []
    for i in bodies:
        slack = 0.1 * window.inch
        start = np.clip(to_plane(profile.position[i], profile.plane), window.low + slack, window.high - slack)
        direction = (centres[i] - start) / float(np.linalg.norm(centres[i] - start))
        border = _exit(start, direction, window)
        if i not in numbers:
            _arrow(axes, border, direction, window, 0.1, 5.0, faded(INK, 0.45))
            continue
        mark = _Pointer(border, direction, float(np.linalg.norm(centres[i] - border)), [numbers[i]])
        same = next((other for other in marks if mark.like(other, window)), None)
        if same is None:
            marks.append(mark)
        else:
            same.numbers.append(numbers[i])
    tips: list[Array] = []
    for mark in marks:
        tips.append(_beside(mark, tips, labels, window))
        tail = _arrow(axes, tips[-1], mark.direction, window, LONG, 10.0, INK)
        for share, radius in ((0.0, 0.05), (0.25, 0.07), (0.6, 0.04), (1.0, 0.04)):
            labels.keep_free(tips[-1] + share * (tail - tips[-1]), radius)
    # All arrows before any words, so that none is written over.
    for mark, tip in zip(marks, tips, strict=True):
        middle = tip - 0.5 * LONG * window.inch * mark.direction
        labels.place(middle, f"{', '.join(map(str, mark.numbers))}: {length(mark.distance)}", gap=0.08)


class _Pointer(NamedTuple):
    """Where a pointer stands, where it points, how far the centre is behind the border [m], and whose centre it is."""

    border: Array
    direction: Array
    distance: float
    numbers: list[int]

    def like(self, other: "_Pointer", window: Window) -> bool:
        """Whether a reader could not tell the two apart."""
        near = np.linalg.norm(self.border - other.border) < 0.3 * window.inch
        parallel = self.direction @ other.direction > 0.999
        return bool(near and parallel and abs(self.distance - other.distance) < 0.02 * other.distance)


def _exit(start: Array, direction: Array, window: Window) -> Array:
    """Where a ray from inside the window leaves it."""
    inset = 0.03 * window.inch
    room = np.where(direction > 0.0, window.high - inset - start, window.low + inset - start)
    moves = np.abs(direction) > 1e-12
    return np.asarray(start + direction * float((room[moves] / direction[moves]).min()))


def _beside(mark: _Pointer, taken: list[Array], labels: Labels, window: Window) -> Array:
    """The place on the border nearest to the wanted one that is off other pointers, and off bodies and marks if one is near."""
    place = mark.border
    step = 0.05 * window.inch
    inset = 0.03 * window.inch
    upright = min(abs(place[0] - window.low[0]), abs(place[0] - window.high[0])) < 1.01 * inset
    along = np.array([0.0, 1.0]) if upright else np.array([1.0, 0.0])
    shifts = [sign * k * step * along for k in range(40) for sign in (1.0, -1.0)]
    places = [place + shift for shift in shifts if window.holds(place + shift)]
    free = [there for there in places if all(np.linalg.norm(there - other) > APART * window.inch for other in taken)]
    clear = (there for there in free if np.linalg.norm(there - place) < MOVED * window.inch and _clear(there, mark, labels, window))
    return np.asarray(next(clear, free[0] if free else place))


def _clear(tip: Array, mark: _Pointer, labels: Labels, window: Window) -> bool:
    """Whether an arrow with its head there covers nothing."""
    return not labels.crosses(tip, tip - LONG * window.inch * mark.direction)


def _arrow(axes: Axes, tip: Array, direction: Array, window: Window, inches: float, head: float, colour: str) -> Array:
    """An arrow of that length with its head at the tip; returns its tail."""
    tail = tip - inches * window.inch * direction
    axes.add_patch(
        FancyArrowPatch(
            tuple(tail),
            tuple(tip),
            arrowstyle="-|>",
            mutation_scale=head,
            linewidth=1.0 if inches > 0.2 else 0.6,
            color=colour,
            shrinkA=0,
            shrinkB=0,
            zorder=7,
        )
    )
    return np.asarray(tail)
