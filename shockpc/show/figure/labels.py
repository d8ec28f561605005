"""Place short labels beside marks so that they cover as little as possible."""

import numpy as np
import shapely
from matplotlib.axes import Axes

from shockpc.core.spatial import Array
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.figure.silhouette import Region
from shockpc.show.figure.window import Window

__all__ = ["Labels"]

SIZE = 7.5
"""Of the letters [pt]."""

TAG = 0.09
"""Radius of a ring with a number [inches]."""


class Labels:
    """The labels of one picture, placed one after the other on axes in plane coordinates; `bodies` are all silhouettes together."""

    def __init__(self, axes: Axes, window: Window, bodies: Region):
        self._axes, self._inch, self._edges = axes, window.inch, bodies.boundary
        self._window: Region = shapely.box(*window.low, *window.high)
        self._taken: Region = shapely.Polygon()

    def keep_free(self, place: Array, radius: float) -> None:
        """Let no label cover the disc around a place (2,) [m] of that radius [inches]."""
        self._taken = shapely.union(self._taken, shapely.Point(place).buffer(radius * self._inch, quad_segs=4))

    def tag(self, region: Region, text: str) -> None:
        """Write a number in a ring inside a region: at its centroid if there is room, else in the middle of its widest part."""
        free = max(shapely.get_parts(shapely.difference(region, self._taken)), key=lambda part: float(part.area), default=None)
        if free is None or free.geom_type != "Polygon" or free.is_empty:
            return
        widest = shapely.maximum_inscribed_circle(free)
        (x, y), centroid = widest.coords[0], region.centroid
        if free.contains(centroid) and free.boundary.distance(centroid) > 0.6 * min(widest.length, TAG * self._inch):
            x, y = centroid.x, centroid.y
        self._axes.plot(x, y, "o", markersize=9.5, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5, zorder=6.5)
        self._axes.text(x, y, text, fontsize=6.5, ha="center", va="center_baseline", zorder=6.6)
        self.keep_free(np.array([x, y]), TAG)

    def place(self, mark: Array, text: str, gap: float) -> None:
        """Write a short text beside a mark (2,) [m], at a gap [inches] on the side where it covers least."""
        width, height = np.array([0.62 * len(text) + 0.3, 1.25]) * SIZE / 72.0 * self._inch
        best, least = None, np.inf
        for right, up in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            shift = np.array([right * (gap * self._inch + width / 2.0), up * (gap * self._inch + height / 2.0)])
            x, y = mark + shift * (1.0 if right == 0 or up == 0 else 0.8)
            box = shapely.box(x - width / 2.0, y - height / 2.0, x + width / 2.0, y + height / 2.0)
            # What is covered counts most, then what is outside, then edges of bodies.
            cost = 4.0 * box.intersection(self._taken).area + 2.0 * box.difference(self._window).area
            cost += 0.5 * height * box.intersection(self._edges).length
            if cost < least - 1e-9 * width * height:
                best, least = (x, y, box), cost
        assert best is not None
        x, y, box = best
        self._taken = shapely.union(self._taken, box)
        backing = {"boxstyle": "round,pad=0.06", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
        self._axes.text(x, y, text, fontsize=SIZE, fontweight="bold", ha="center", va="center", zorder=8, bbox=backing)
