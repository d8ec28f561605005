"""Curves on logarithmic axes, for the bench: errors over a parameter, errors over run time.

Like the figure of a landing it draws with matplotlib's objects and leaves its global state alone; the same numbers give the same
file.
"""

import math
from pathlib import Path
from typing import NamedTuple

import matplotlib
from matplotlib.figure import Figure

from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.files import write_whole

__all__ = ["COLOURS", "FLOOR", "MARKS", "Curve", "save_curves"]

COLOURS = ("#1f5f9f", "#c2512f", "#3f8f4f", "#7a4fa0", "#a08020", "#208f8f", "#a0406f", "#606060")
FLOOR = 1e-17
"""The least ordinate; what lies below is drawn on it."""

MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")


class Curve(NamedTuple):
    """One curve.

    Attributes:
        label: in the legend; empty for none.
        x: abscissae; a zero is drawn at the left edge.
        y: ordinates; a zero lies on the floor, and None, where there is no number, is a cross at the top edge.
        style: number of its colour and mark.
        dashed: whether it is drawn as a dashed line.
        joined: whether its points are joined at all.
    """

    label: str
    x: tuple[float, ...]
    y: tuple[float | None, ...]
    style: int
    dashed: bool = False
    joined: bool = True


def save_curves(path: Path, title: str, x_label: str, y_label: str, curves: list[Curve], names: tuple[str, ...] = ()) -> None:
    """Draw curves on two logarithmic axes, as SVG; over names, if the abscissae are their numbers.

    Args:
        path: of the file.
        title: over the figure.
        x_label: with its unit.
        y_label: with its unit.
        curves: what to draw.
        names: what the abscissae 0, 1, 2 … stand for; their axis is then linear.

    Raises:
        OutputError: the file cannot be written.
    """
    abscissae = {x for curve in curves for x in curve.x}
    decades = [round(math.log10(x)) for x in abscissae if x > 0.0] or [0]
    first, last = min(decades), max(decades)
    zero = 10.0 ** (first - max(1.0, 0.1 * (last - first)))
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "shockpc", "font.size": 8.5, "text.color": INK}):
        figure = Figure(figsize=(7.2, 4.2), facecolor=PAPER)
        below = 0.27 if names else 0.13
        axes = figure.add_axes((0.1, below, 0.55, 0.89 - below))
        crosses = 0
        for curve in curves:
            places = [x if names else x or zero for x in curve.x]
            known = [y is not None and math.isfinite(y) for y in curve.y]
            axes.plot(
                [x for x, there in zip(places, known, strict=True) if there],
                [max(y or 0.0, FLOOR) for y, there in zip(curve.y, known, strict=True) if there],
                linestyle=(":" if curve.dashed else "-") if curve.joined else "none",
                marker=None if curve.dashed and curve.joined else MARKS[(curve.style + curve.style // len(COLOURS)) % len(MARKS)],
                fillstyle="none" if curve.dashed else "full",
                markersize=4,
                linewidth=1.1,
                color=COLOURS[curve.style % len(COLOURS)],
                label=curve.label or "_",
            )
            if not curve.dashed and not all(known):
                # One under the other, for several curves may have none at the same place.
                missing = [x for x, there in zip(places, known, strict=True) if not there]
                height = [0.97 - 0.045 * crosses] * len(missing)
                crosses += 1
                colour = COLOURS[curve.style % len(COLOURS)]
                axes.plot(missing, height, "x", color=colour, markersize=5, transform=axes.get_xaxis_transform(), label="_")
        if crosses:
            axes.plot([], [], "x", color=INK, markersize=5, label="no number")
        axes.set_yscale("log")
        axes.set_ylim(FLOOR / 2.0, max(axes.get_ylim()[1], 1e-8) * (1e3 if crosses else 1.0))
        if names:
            axes.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=6.5)
        else:
            axes.set_xscale("log")
            if 0.0 in abscissae:
                shown = range(first, last + 1, (last - first) // 7 + 1)
                axes.set_xticks([zero, *(10.0**k for k in shown)], ["0", *(f"$10^{{{k}}}$" for k in shown)])
                axes.minorticks_off()
        axes.grid(True, which="major", linewidth=0.4, color="#d0d0d0")
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        axes.set_title(title, fontsize=9.5, loc="left")
        axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), frameon=False, fontsize=7.5)
        write_whole(path, lambda part: figure.savefig(part, format="svg", metadata={"Date": None}))
