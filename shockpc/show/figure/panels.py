"""Charts side by side on shared logarithmic axes, one for each case: the error of each method against its run time."""

import math
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from shockpc.show.figure.canvas import render
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.files import write_text

__all__ = ["Panel", "save_panels"]

COLOURS = ("#1f5f9f", "#c2512f", "#3f8f4f", "#7a4fa0", "#a08020", "#208f8f", "#a0406f", "#606060")
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
FLOOR = 1e-17
"""The least ordinate; smaller ones are drawn on it."""

COLUMNS = 3
GOOD: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": "--"}
SHAPE: dict[str, Any] = {"markersize": 5.0, "markeredgewidth": 0.5, "markeredgecolor": PAPER}


class Panel(NamedTuple):
    """The results of one case.

    Attributes:
        title: over the panel.
        points: abscissa and ordinate of each series, by its name; those of one series are joined.
        absent: names of the series that have a result without a number, by the kind of that result.
    """

    title: str
    points: dict[str, list[tuple[float, float]]]
    absent: dict[str, list[str]]


def save_panels(
    path: Path, title: str, x_label: str, y_label: str, looks: dict[str, tuple[int, int]], panels: list[Panel], good: float
) -> None:
    """Draw panels as SVG, and the key to all of them in the last cell.

    Args:
        path: of the file.
        title: over the figure.
        x_label: with its unit.
        y_label: with its unit.
        looks: numbers of the colour and the mark of every series, by its name.
        panels: what to draw.
        good: an ordinate below which a number is good, drawn as a line.

    Raises:
        OutputError: the file cannot be written.
    """

    def draw() -> Figure:
        rows = math.ceil((len(panels) + 1) / COLUMNS)
        figure = Figure(figsize=(8.4, 0.7 + 2.9 * rows), facecolor=PAPER, layout="constrained")
        figure.suptitle(title.replace("$", r"\$"), fontsize=9.5, x=0.01, ha="left")
        grid = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        lines = {
            name: Line2D([], [], color=COLOURS[colour], marker=MARKS[mark], linestyle="none", **SHAPE)
            for name, (colour, mark) in looks.items()
        }
        for k, axes in enumerate(grid):
            if k < len(panels):
                _draw(axes, panels[k], lines, good)
                # The cells below the last panels have no axis of their own.
                axes.tick_params(labelbottom=k + COLUMNS >= len(panels), labelleft=k % COLUMNS == 0)
            else:
                axes.set_axis_off()
        key = {**lines, f"below: error under {good:g}": Line2D([], [], **GOOD)}
        grid[len(panels)].legend(key.values(), key.keys(), loc="upper left", fontsize=7.0, borderaxespad=0.0)
        figure.supxlabel(x_label, fontsize=8.5)
        figure.supylabel(y_label, fontsize=8.5)
        return figure

    write_text(path, render(draw, formulas=True)["svg"])


def _draw(axes: Axes, panel: Panel, lines: dict[str, Line2D], good: float) -> None:
    """One case; a series without a number stands above it with its mark."""
    axes.set(xscale="log", yscale="log")
    axes.grid(True, which="major", linewidth=0.4, color="#d8d8d8")
    axes.axhline(good, **GOOD)
    for name, found in panel.points.items():
        x, y = [x for x, _ in found], [max(y, FLOOR) for _, y in found]
        axes.plot(x, y, color=lines[name].get_color(), marker=lines[name].get_marker(), linewidth=0.9, **SHAPE)
    axes.set_title(panel.title.replace("$", r"\$"), fontsize=7.5, loc="left", pad=16.0)
    if panel.absent:
        most = max(len(names) for names in panel.absent.values())
        axes.legend(
            [tuple(lines[name] for name in names) for names in panel.absent.values()], list(panel.absent),
            handler_map={tuple: HandlerTuple(ndivide=None)}, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.1,
            ncols=len(panel.absent), handlelength=1.1 * most, handletextpad=0.4, columnspacing=1.0, fontsize=6.5,
        )  # fmt: skip
