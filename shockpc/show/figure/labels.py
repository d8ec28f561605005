"""Put short labels beside marks so that they cover neither each other nor a mark."""

import math
from typing import NamedTuple

import numpy as np
import shapely
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shockpc.core.spatial import Array
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.figure.silhouette import Region
from shockpc.show.figure.window import Window

__all__ = ["Labels"]

SIDES = ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
REACHES = (1.0, 2.2, 3.6, 5.5, 8.0)
SIZE = 7.5
"""Of the letters [pt]."""

MARK, EDGE, ACROSS, INSIDE = 20.0, 2.0, 0.5, 0.1
"""What it costs to hide a mark, to hide an edge, to stand on the other side of a body, and to hide its colours, against 0.05 for
every step away from the mark."""


class _Box(NamedTuple):
    x0: float
    y0: float
    x1: float
    y1: float

    def shared(self, other: "_Box") -> float:
        """Area in common [m²]."""
        width = min(self.x1, other.x1) - max(self.x0, other.x0)
        height = min(self.y1, other.y1) - max(self.y0, other.y0)
        return max(width, 0.0) * max(height, 0.0)


class Labels:
    """The labels of one picture, placed one after the other, each at the freest place around its mark.

    Args:
        axes: in plane coordinates.
        window: what the picture shows.
        bodies: all silhouettes together; a label rather stands beside them, or well inside.
    """

    def __init__(self, axes: Axes, window: Window, bodies: Region):
        self._axes, self._inch = axes, window.inch
        self._window = _Box(*window.low, *window.high)
        self._bodies = bodies
        self._taken: list[_Box] = []
        shapely.prepare(bodies)

    def keep_free(self, place: Array, radius: float) -> None:
        """Let no label cover a mark at a place (2,) [m] of that radius [inches]."""
        x, y, r = float(place[0]), float(place[1]), radius * self._inch
        self._taken.append(_Box(x - r, y - r, x + r, y + r))

    def clearance(self, place: Array) -> float:
        """Distance from a place (2,) [m] to the middle of the nearest mark or label [inches]; infinity if there is none."""
        near = [math.hypot(place[0] - (b.x0 + b.x1) / 2.0, place[1] - (b.y0 + b.y1) / 2.0) for b in self._taken]
        return min(near, default=math.inf) / self._inch

    def crosses(self, start: Array, end: Array) -> bool:
        """Whether a line between two places (2,) [m] runs over a body, a mark or a label."""
        line = shapely.LineString([start, end])
        return bool(shapely.intersects(self._bodies, line)) or any(line.intersects(shapely.box(*box)) for box in self._taken)

    def tag(self, place: Array, text: str) -> None:
        """Write a number into a ring at a place (2,) [m]."""
        self._axes.plot(*place, "o", markersize=9.5, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5, zorder=6.5)
        self._axes.text(
            float(place[0]), float(place[1]), text, fontsize=6.5, color=INK, ha="center", va="center_baseline", zorder=6.6
        )
        self.keep_free(place, 0.08)

    def between(self, places: Array, mark: Array) -> NDArray[np.bool_]:
        """Whether straight lines from places (n, 2) to a mark (2,) [m] run over other marks or labels (n,)."""
        lines = shapely.linestrings(np.stack([places, np.broadcast_to(mark, places.shape)], axis=1))
        boxes = shapely.box(*np.array(self._taken).reshape(-1, 4).T)
        others = shapely.union_all(boxes[~shapely.intersects_xy(boxes, *mark)])
        return np.asarray(shapely.intersects(lines, others))

    def tie(self, place: Array, mark: Array) -> None:
        """Draw a thin line from a tag to a mark, both (2,) [m], and keep labels off it."""
        self._axes.plot(*zip(place, mark, strict=True), color=INK, linewidth=0.4, zorder=3.5)
        for share in np.linspace(0.0, 1.0, 40):
            self.keep_free(place + share * (mark - place), 0.01)

    def place(self, mark: Array, text: str, gap: float = 0.06) -> None:
        """Write a short text near a mark, with a thin line to the mark if it could not be next to it.

        Args:
            mark: (2,) where it stands [m].
            text: short.
            gap: from the mark to the text [inches].
        """
        x, y = float(mark[0]), float(mark[1])
        width = (0.62 * len(text) + 0.5) * SIZE / 72.0 * self._inch
        height = 1.25 * SIZE / 72.0 * self._inch
        beside = not shapely.intersects_xy(self._bodies, x, y)
        chosen, least, far = _Box(x, y, x + width, y + height), math.inf, False
        for reach in REACHES:
            for right, up in SIDES:
                d = gap * reach * self._inch * (1.0 if right == 0 or up == 0 else 0.75)
                cx, cy = x + right * (d + width / 2.0), y + up * (d + height / 2.0)
                cx = min(max(cx, self._window.x0 + width / 2.0), self._window.x1 - width / 2.0)
                cy = min(max(cy, self._window.y0 + height / 2.0), self._window.y1 - height / 2.0)
                box = _Box(cx - width / 2.0, cy - height / 2.0, cx + width / 2.0, cy + height / 2.0)
                covered = shapely.intersection(self._bodies, shapely.box(*box)).area / (width * height)
                # Half on a body and half off it is worst: that hides an edge.
                cost = MARK * sum(box.shared(other) for other in self._taken)
                cost += (EDGE * min(covered, 1.0 - covered) + INSIDE * covered + 0.05 * reach) * width * height
                if beside and shapely.intersects(self._bodies, shapely.LineString([(x, y), (cx, cy)])):
                    cost += ACROSS * width * height
                if cost < least:
                    chosen, least, far = box, cost, reach > REACHES[0]
        self._taken.append(chosen)
        cx, cy = (chosen.x0 + chosen.x1) / 2.0, (chosen.y0 + chosen.y1) / 2.0
        if far:
            self._axes.plot([x, cx], [y, cy], color=INK, linewidth=0.4, zorder=7.5)
        backing = {"boxstyle": "round,pad=0.06", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
        self._axes.text(cx, cy, text, fontsize=SIZE, fontweight="bold", color=INK, ha="center", va="center", zorder=8, bbox=backing)
