"""The part of the plane that a picture shows, and its scale."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.result import ShockProfile
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.view import View

__all__ = ["ARROW", "Window", "fitted", "velocities_in_plane", "windows_of"]

ARROW = 0.62
"""Length of the arrow of the fastest contact [inches]."""

PAD = 0.25
"""Room around what a picture holds [inches]."""


class Window(NamedTuple):
    """The part of the plane that a picture shows: its corners (2,) [m], and the length of an inch of paper [m]."""

    low: Array
    high: Array
    inch: float

    @property
    def sides(self) -> tuple[float, float]:
        """Width and height on paper [inches]."""
        width, height = (self.high - self.low) / self.inch
        return float(width), float(height)

    def holds(self, point: Array, margin: float = 0.0) -> bool:
        """Whether a point (2,) [m] lies inside, at least a margin [inches] from the border."""
        slack = margin * self.inch
        return bool(np.all(point >= self.low + slack) and np.all(point <= self.high - slack))


def velocities_in_plane(profile: ShockProfile) -> Array:
    """The velocity (n, 2) of every contact before the impact along e1 and e2, relative to the speed of the fastest [1]."""
    approach = np.stack([contact.approach for contact in profile.contacts])
    return to_plane(approach, profile.plane) / float(np.linalg.norm(profile.strike))


def windows_of(
    profiles: Sequence[ShockProfile],
    views: Sequence[View],
    numbered: Sequence[Iterable[int]],
    near: tuple[float, float],
    most: tuple[float, float],
    least: tuple[float, float],
) -> list[Window]:
    """Windows side by side, on one scale and of one height.

    Each holds the robot, contacts with their velocities, sensors, and the centres of percussion that are near.

    Args:
        profiles: one for each window.
        views: of their bodies.
        numbered: bodies whose centres of percussion are held if they are near.
        near: distance of a centre from the robot, sideways and up, as a share of the robot's size, up to which it is near.
        most: width of all windows together, and their height [inches].
        least: width of each window, and their height [inches].
    """
    held = [_contents(*one, near) for one in zip(profiles, views, numbered, strict=True)]
    feet = [to_plane(np.stack([contact.point for contact in p.contacts]), p.plane) for p in profiles]
    return fitted(held, feet, [ARROW * velocities_in_plane(profile) for profile in profiles], PAD, most, least)


def fitted(
    held: Sequence[Array],
    feet: Sequence[Array],
    arrows: Sequence[Array],
    pad: float,
    most: tuple[float, float],
    least: tuple[float, float],
) -> list[Window]:
    """Windows side by side, on one scale and of one height.

    Args:
        held: (n, 2) points that each window holds [m].
        feet: (n, 2) points in each where arrows begin [m].
        arrows: (n, 2) from there [inches].
        pad: room around what a window holds [inches].
        most: width of all windows together, and their height [inches].
        least: width of each window, and their height [inches].
    """
    inch = 0.0
    # The arrows have a fixed length on paper, so the room that they need depends on the scale, and the scale on that room.
    for _ in range(4):
        full = [np.concatenate([h, foot + inch * arrow]) for h, foot, arrow in zip(held, feet, arrows, strict=True)]
        low, high = np.array([one.min(axis=0) for one in full]), np.array([one.max(axis=0) for one in full])
        low[:, 1], high[:, 1] = low[:, 1].min(), high[:, 1].max()
        wide, tall = np.sum(high[:, 0] - low[:, 0]), high[0, 1] - low[0, 1]
        inch = max(float(wide / (most[0] - 2.0 * pad * len(held))), float(tall / (most[1] - 2.0 * pad)), 1e-9)
    half = np.maximum((high - low) / 2.0 + pad * inch, np.array(least) * inch / 2.0)
    return [Window(middle - side, middle + side, inch) for middle, side in zip((low + high) / 2.0, half, strict=True)]


def _contents(profile: ShockProfile, view: View, numbered: Iterable[int], near: tuple[float, float]) -> Array:
    """Points (n, 2) that a picture should hold [m]."""
    world = [*(point.position for point in profile.points), *(contact.point for contact in profile.contacts)]
    centres = to_plane(profile.copc_world[list(numbered)], profile.plane)
    slack = np.array(near) * view.size
    is_near = np.all((centres > view.low - slack) & (centres < view.high + slack), axis=1)
    return np.concatenate([[view.low, view.high], to_plane(np.array(world), profile.plane), centres[is_near]])
