"""Put short labels beside marks so that they cover neither each other nor a mark."""

from typing import NamedTuple

from matplotlib.axes import Axes

from shockpc.show.palette import INK, PAPER

__all__ = ["Labels"]

SIDES = ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
REACHES = (1.0, 2.2, 3.6)


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
        inch: length of an inch of paper in the picture [m].
        window: x and y of the lower left and the upper right corner of the picture [m].
    """

    def __init__(self, axes: Axes, inch: float, window: tuple[float, float, float, float]):
        self._axes, self._inch, self._window = axes, inch, _Box(*window)
        self._taken: list[_Box] = []

    def keep_free(self, x: float, y: float, radius: float) -> None:
        """Let no label cover a mark at (x, y) [m] of that radius [inches]."""
        r = radius * self._inch
        self._taken.append(_Box(x - r, y - r, x + r, y + r))

    def place(self, x: float, y: float, text: str, *, size: float = 7.5, weight: str = "normal", gap: float = 0.06) -> None:
        """Write a text near a mark, with a thin line to the mark if it could not be next to it.

        Args:
            x: of the mark [m].
            y: of the mark [m].
            text: short.
            size: of the letters [pt].
            weight: of the letters.
            gap: from the mark to the text [inches].
        """
        width = (0.62 * len(text) + 0.5) * size / 72.0 * self._inch
        height = 1.25 * size / 72.0 * self._inch
        chosen, least, far = _Box(x, y, x + width, y + height), float("inf"), False
        for reach in REACHES:
            for right, up in SIDES:
                d = gap * reach * self._inch * (1.0 if right == 0 or up == 0 else 0.75)
                cx, cy = x + right * (d + width / 2.0), y + up * (d + height / 2.0)
                box = _Box(cx - width / 2.0, cy - height / 2.0, cx + width / 2.0, cy + height / 2.0)
                outside = width * height - box.shared(self._window)
                cost = 3.0 * outside + sum(box.shared(other) for other in self._taken) + 1e-3 * reach * width * height
                if cost < least:
                    chosen, least, far = box, cost, reach > REACHES[1]
        self._taken.append(chosen)
        centre = ((chosen.x0 + chosen.x1) / 2.0, (chosen.y0 + chosen.y1) / 2.0)
        if far:
            self._axes.plot([x, centre[0]], [y, centre[1]], color=INK, linewidth=0.4, zorder=7.5)
        self._axes.text(
            *centre,
            text,
            fontsize=size,
            fontweight=weight,
            color=INK,
            ha="center",
            va="center",
            zorder=8,
            bbox={"boxstyle": "round,pad=0.12", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8},
        )
