"""Error against run time on logarithmic axes, for the benchmark."""

from typing import Any

from matplotlib.figure import Figure

from shockpc.show.figure.style import CURVES, INK, PAPER, new_chart
from shockpc.text.printed import printable

MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
FLOOR = 1e-17
"""Errors below this are drawn here."""


def draw_error_time(
    title: str, series: dict[str, list[tuple[float, float]]], accurate: float
) -> Figure:
    """Draw run time [s] and error [1] of the results of several methods, by the method's name.

    A line shows the largest error of an accurate result.
    """
    figure = new_chart(8.0, 4.6, printable(title, 90))
    axes = figure.add_subplot(
        xscale="log",
        yscale="log",
        xlabel="run time [µs]",
        ylabel="largest error over the bodies [-]",
    )
    axes.axhline(
        accurate, color=INK, linewidth=0.8, linestyle="--", label=f"accurate: below {accurate:g}"
    )
    for k, (name, points) in enumerate(series.items()):
        style: dict[str, Any] = {
            "linestyle": "none",
            "markersize": 4.0,
            "markeredgewidth": 0.3,
            "markeredgecolor": PAPER,
        }
        style |= {
            "marker": MARKS[k % len(MARKS)],
            "color": CURVES[(k + k // len(CURVES)) % len(CURVES)],
            "alpha": 0.8,
        }
        times, errors = (
            [1e6 * seconds for seconds, _ in points],
            [max(error, FLOOR) for _, error in points],
        )
        axes.plot(times, errors, label=printable(name, 60), **style)
    axes.set_ylim(bottom=FLOOR / 3.0)
    axes.grid(True)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:.0e}")
    figure.legend(loc="outside right upper")
    return figure
