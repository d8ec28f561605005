"""Errors of the rigid answer over the duration of contact."""

import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from matplotlib.artist import Artist
from matplotlib.figure import Figure

from shockpc.show.figure.style import CURVES, INK, new_chart

Curves: TypeAlias = Mapping[str, tuple[Sequence[float], Sequence[float]]]

TICKS = 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0
"""Ticks of durations of contact, in first bending periods."""

STYLES, MARKS = ("-", (0, (5, 2)), (0, (1.5, 1.2))), "os^"
"""Line styles and marks of the curves of a panel.

The curves have to be told apart without their colours.
"""


def draw_errors(title: str, panels: Sequence[tuple[str, Curves, Curves]], limit: float) -> Figure:
    """Draw errors over the duration of contact times the first bending frequency.

    The panels are beside and below each other.

    Args:
        title: of the figure.
        panels: a title, what is drawn as lines, and what as dots; abscissas and ordinates by name.
        limit: error up to which an answer counts as right.
    """
    # Four panels are two by two.
    columns = 2 if len(panels) == 4 else min(len(panels), 3)
    rows = math.ceil(len(panels) / columns)
    figure = new_chart(3.2 * columns + 2.6, 3.0 * rows + 0.8, title)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    named: dict[str, Artist] = {}
    for axes, (text, lines, dots) in zip(grid.flat, panels, strict=True):
        axes.set(xscale="log", yscale="log", ylim=(1e-3, 2.0))
        axes.set_title(text, fontsize=8.0)
        axes.axhline(limit, color=INK, linewidth=1.2, label=f"{100.0 * limit:g} %")
        for colour, style, (name, values) in zip(CURVES, STYLES, lines.items(), strict=False):
            axes.plot(*values, linestyle=style, color=colour, label=name)
        for colour, mark, (name, values) in zip(CURVES, MARKS, dots.items(), strict=False):
            hollow = {"markersize": 4.0, "markerfacecolor": "none"}
            axes.plot(*values, mark, color=colour, label=name, **hollow)
        # A curve that several panels have is named once.
        named |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        axes.grid(True)
    # Decades alone would be too few ticks.
    low, high = grid[0, 0].get_xbound()
    ticks = [tick for tick in TICKS if low <= tick <= high]
    for axes in grid.flat:
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.yaxis.set_major_formatter("{x:g}")
    figure.supxlabel(
        "duration of contact over the period of the first bending mode, Tc f1 = Tc/T1 [-]",
        fontsize=8.0,
    )
    figure.supylabel("error [-]", fontsize=8.0)
    figure.legend(list(named.values()), list(named), loc="outside right upper")
    return figure
