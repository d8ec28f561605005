"""Short labels on a drawing, each where it covers as little as possible.

It avoids the marks, the bodies and the labels before it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes

from shockpc.core.spatial import Array
from shockpc.show.figure.silhouette import PlaneShape
from shockpc.show.figure.style import INK, PAPER, faded
from shockpc.show.figure.window import Window

PALE = faded(INK, 0.6)
"""Colour of marks that say little of a body."""

LETTERS, SMALL, TAG = 7.5, 6.0, 0.09
"""Size of labels and of those of circles [pt], and radius of a ring with a number [inches]."""

FARTHER = (1.0, 2.0)
"""Distances of a label from its mark that are tried, in gaps."""

THIN = 0.9
"""Half the width of a body, as a share of that radius, below which its number is beside it."""


class Labels:
    """Short labels on axes in plane coordinates.

    They are placed one after the other so that they cover as little as possible.
    """

    def __init__(self, axes: Axes, window: Window, bodies: PlaneShape):
        """Args: axes; window: what they show; bodies: all silhouettes together."""
        self._axes, self._inch, self._bodies = axes, window.inch, bodies
        self._edges: PlaneShape = bodies if bodies.is_empty else bodies.boundary
        self._window: PlaneShape = shapely.box(*window.low, *window.high)
        self._taken: PlaneShape = shapely.Polygon()

    def keep_free(self, point: Array, radius: float) -> None:
        """Let no label cover the disc around a point (2,) [m] of that radius [inches]."""
        self._taken = shapely.union(
            self._taken, shapely.Point(point).buffer(radius * self._inch, quad_segs=4)
        )

    def tag(self, region: PlaneShape, text: str) -> None:
        """Write a number in a ring at a region.

        It is at the centroid, in the middle of the widest part, or beside a region that is too
        thin.
        """
        free = shapely.difference(shapely.intersection(region, self._window), self._taken)
        free = max(shapely.get_parts(free), key=lambda part: float(part.area), default=None)
        if free is None or free.geom_type != "Polygon" or free.is_empty:
            return
        widest = shapely.maximum_inscribed_circle(free)
        (x, y), centroid = widest.coords[0], region.centroid
        room = TAG * self._inch
        if free.contains(centroid) and free.boundary.distance(centroid) > 0.6 * min(
            widest.length, room
        ):
            x, y = centroid.x, centroid.y
        if widest.length < THIN * room:
            angles = np.arange(16) * np.pi / 8.0
            directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            around = np.array([x, y]) + (1.15 * room + widest.length) * directions
            x, y = min(around.tolist(), key=lambda middle: round(self._covered(middle, room), 9))
        self._axes.plot(
            x,
            y,
            "o",
            markersize=9.5,
            markerfacecolor=PAPER,
            markeredgecolor=INK,
            markeredgewidth=0.5,
            zorder=6.5,
        )
        self._axes.text(x, y, text, fontsize=6.5, ha="center", va="center_baseline", zorder=6.6)
        self.keep_free(np.array([x, y]), TAG)

    def _covered(self, point: Sequence[float], radius: float) -> float:
        """The sum of what a disc covers, as shares of the disc.

        Marks and labels count most, then what is outside, then bodies.
        """
        disc = shapely.Point(point).buffer(radius, quad_segs=4)
        outside = disc.difference(self._window).area
        covered = (
            4.0 * disc.intersection(self._taken).area
            + 2.0 * outside
            + disc.intersection(self._bodies).area
        )
        return float(covered / disc.area)

    def place(self, mark: Array, text: str, gap: float, faint: bool = False) -> None:
        """Write a short text beside a mark (2,) [m], at a gap [inches], where it covers least."""
        size = self._size(text, LETTERS)
        sides = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
        middles = []
        for farther in FARTHER:
            for side in sides:
                nearer = 1.0 if 0 in side else 0.8  # to a corner
                distance = farther * gap * self._inch + size / 2.0
                middles.append(mark + np.array(side) * distance * nearer)
        style: dict[str, Any] = {"fontweight": "bold"}
        if faint:
            style = {"color": PALE, "fontweight": "normal"}
        self._write(middles, text, LETTERS, **style)

    def on_line(self, line: Array, text: str, faint: bool = False) -> None:
        """Write a short text on a line (n, 2) [m], where it covers least."""
        self._write(list(line[::6]), text, SMALL, color=PALE if faint else INK)

    def _size(self, text: str, letters: float) -> Array:
        """Width and height (2,) of a text [m]."""
        in_letters = np.array([0.62 * len(text) + 0.3, 1.25])
        return np.asarray(in_letters * letters / 72.0 * self._inch)

    def _write(self, middles: Sequence[Array], text: str, letters: float, **style: Any) -> None:
        """Write a text around that one of some points (2,) [m] where it covers least."""
        options, size = [], self._size(text, letters)
        for middle in middles:
            box = shapely.box(*(middle - size / 2.0), *(middle + size / 2.0))
            # What is covered counts most, then what is outside, then edges of bodies; all as shares
            # of the label.
            cost = (
                4.0 * box.intersection(self._taken).area + 2.0 * box.difference(self._window).area
            )
            cost += 0.5 * size[1] * box.intersection(self._edges).length
            options.append((round(float(cost / size.prod()), 9), middle, box))
        # Of points that cover as much the first one, which is the nearest.
        _, middle, box = min(options, key=lambda option: option[0])
        self._taken = shapely.union(self._taken, box)
        backing = {
            "boxstyle": "round,pad=0.06",
            "facecolor": PAPER,
            "edgecolor": "none",
            "alpha": 0.8,
        }
        self._axes.text(
            middle[0],
            middle[1],
            text,
            fontsize=letters,
            ha="center",
            va="center",
            zorder=8,
            bbox=backing,
            **style,
        )
