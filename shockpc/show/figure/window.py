"""The part of the plane that a picture shows, and its scale."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.show.figure.view import PlaneView

ROUNDS = 4
"""Rounds in which the scale and the room for arrows are found, as each depends on the other."""


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
        """True for points (..., 2) [m] inside, at least a margin [inches] from the border."""
        slack = margin * self.inch
        inside = (points >= self.low + slack) & (points <= self.high - slack)
        return np.asarray(np.all(inside, axis=-1))


def windows_of(
    views: Sequence[PlaneView],
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
    for _ in range(ROUNDS):
        corners = [_corners(view, near, length) for view in views]
        low, high = np.array(corners).swapaxes(0, 1)
        low[:, 1] = low[:, 1].min()
        high[:, 1] = high[:, 1].max()
        # Length of an inch of paper, by the width of all and by the height.
        wide = np.sum(high[:, 0] - low[:, 0])
        tall = high[0, 1] - low[0, 1]
        room = most[0] - 2.0 * pad * len(views), most[1] - 2.0 * pad
        by_width, by_height = float(wide / room[0]), float(tall / room[1])
        inch = max(by_width, by_height, 1e-9)
        length = arrow * inch
    middles = (low + high) / 2.0
    least_halves = np.array(least) * inch / 2.0
    halves = np.maximum((high - low) / 2.0 + pad * inch, least_halves)
    windows = []
    for middle, half in zip(middles, halves, strict=True):
        windows.append(Window(middle - half, middle + half, inch, length))
    return windows


def _corners(view: PlaneView, near: tuple[float, float], length: float) -> tuple[Array, Array]:
    """Lower left and upper right corner of what a window holds [m].

    Args:
        view: a landing.
        near: as in `windows_of`.
        length: of the arrow of the fastest contact [m].
    """
    slack = np.array(near) * view.size
    low, high = view.low - slack, view.high + slack
    centres = []
    for body, centre in view.centres.items():
        if body in view.numbers and np.all((centre > low) & (centre < high)):
            centres.append(centre)
    tips = view.contacts + length * view.velocities
    points = np.vstack([view.low, view.high, view.contacts, tips, view.sensors, *centres])
    return points.min(axis=0), points.max(axis=0)
