"""The window on the plane that a picture shows, its scale, and how lengths and sensors are written in it."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.result import ShockProfile
from shockpc.show.figure.silhouette import to_plane

__all__ = ["ARROW", "Window", "length", "letter", "strike_in_plane", "strikes_in_plane"]

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
    """The letter that stands for a sensor: a to z, then aa, ab and so on."""
    return (letter(index // 26 - 1) if index >= 26 else "") + chr(ord("a") + index % 26)


def strike_in_plane(profile: ShockProfile) -> Array:
    """The strike (2,) along e1 and e2, relative to its speed [1]."""
    return to_plane(profile.strike, profile.plane) / float(np.linalg.norm(profile.strike))


def strikes_in_plane(profile: ShockProfile) -> Array:
    """The velocity (n, 2) of every contact along e1 and e2, relative to the speed of the fastest [1]."""
    return to_plane(np.stack([contact.approach for contact in profile.contacts]), profile.plane) / float(
        np.linalg.norm(profile.strike)
    )


def length(metres: float) -> str:
    """A length to about two digits, with its unit."""
    if metres >= 1e5:
        return "> 100 km"
    return f"{metres:.{0 if metres >= 10.0 else 2 if metres >= 0.1 else 3}f} m"
