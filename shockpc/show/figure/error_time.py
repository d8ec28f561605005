"""Error against run time on logarithmic axes, for the benchmark."""

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.files import write_whole

__all__ = ["save_error_time"]

COLOURS = ("#1f5f9f", "#c2512f", "#3f8f4f", "#7a4fa0", "#a08020", "#208f8f", "#a0406f", "#606060")
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
FLOOR = 1e-17
"""Errors below this are drawn here."""


def save_error_time(path: Path, title: str, series: dict[str, list[tuple[float, float]]], accurate: float) -> None:
    """Draw run time and error of several methods as SVG.

    Args:
        path: of the file.
        title: over the figure.
        series: (run time [s], error [1]) of every result, by the method's name.
        accurate: largest error of an accurate result, drawn as a line.

    Raises:
        OutputError: the file cannot be written.
    """
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "shockpc", "font.size": 8.5, "text.color": INK}):
        figure = Figure(figsize=(8.0, 4.6), facecolor=PAPER, layout="constrained")
        axes = figure.add_subplot()
        axes.axhline(accurate, color=INK, linewidth=0.8, linestyle="--", label=f"accurate: below {accurate:g}")
        for k, (name, points) in enumerate(series.items()):
            axes.plot(
                [1e6 * seconds for seconds, _ in points],
                [max(error, FLOOR) for _, error in points],
                linestyle="none",
                marker=MARKS[k % len(MARKS)],
                markersize=4.0,
                markeredgewidth=0.3,
                markeredgecolor=PAPER,
                color=COLOURS[(k + k // len(COLOURS)) % len(COLOURS)],
                alpha=0.8,
                label=name,
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylim(bottom=FLOOR / 3.0)
        axes.grid(True, which="major", linewidth=0.4, color="#d0d0d0")
        axes.set_xlabel("run time [µs]")
        axes.set_ylabel("largest error over the bodies [-]")
        axes.set_title(title, fontsize=9.5, loc="left")
        figure.legend(loc="outside right upper", frameon=False, fontsize=7.5)
        write_whole(path, lambda part: figure.savefig(part, format="svg", metadata={"Date": None}))
