"""The error of the rigid answer over the duration of contact."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from shockpc.paper.beyond import LIMIT, Compared
from shockpc.show.figure.style import CURVES, INK, new_chart

TICKS = 0.3, 0.5, 1.0, 2.0, 3.0, 5.0
"""Of Tc/T1."""


def draw_errors(title: str, study: Sequence[Compared], names: Sequence[str]) -> Figure:
    """Draw the errors of a study, with exact modes as lines and by segments as dots. Args: names of what is compared."""
    figure = new_chart(8.0, 4.2, title)
    axes = figure.add_subplot(xscale="log", yscale="log", xlabel="duration of contact over first bending period, Tc/T1 = Tc f1 [-]")
    axes.set_ylabel("largest error over the points of contact [-]")
    axes.axhline(LIMIT, color=INK, linewidth=0.8, linestyle="--", label=f"{100 * LIMIT:g} %")
    ratios = [one.ratio for one in study]
    for k, name in enumerate(names):
        axes.plot(ratios, [one.exact[k] for one in study], color=CURVES[k], label=f"{name}, modes")
        axes.plot(ratios, [one.segments[k] for one in study], "o", color=CURVES[k], markersize=3.5, label=f"{name}, segments")
    axes.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylim(1e-3, 2.0)
    axes.grid(True)
    figure.legend(loc="outside right upper")
    return figure
