"""The search for an optimum as figures: the target over the steps of the runs, and the front of two numbers."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.wording import size_at_place
from shockpc.studies.improve.study import Improvement


def draw_runs(study: Improvement) -> Figure:
    """Draw the best value so far over the steps of each run; the constraints may not hold at a step between others."""
    figure = new_chart(5.0, 3.6, "The runs; black: to the optimum")
    axes, lower = figure.add_subplot(), study.costs[0].power > 0.0
    for k, run in reversed(list(enumerate(study.runs))):
        steps = np.flatnonzero(np.isfinite(run))
        reached = (np.minimum if lower else np.maximum).accumulate(run[steps])
        colour, width, opacity = (CURVES[0], 0.6, 0.5) if k else (INK, 1.8, 1.0)
        axes.step(steps, reached, where="post", color=colour, linewidth=width, alpha=opacity, marker=".", markersize=2.5)
    known = np.concatenate([run[np.isfinite(run)] for run in study.runs])
    if known.size and known.min() > 0.0 and known.max() > 20.0 * known.min():
        axes.set_yscale("log")
        plain_numbers(axes.yaxis)
    else:
        axes.ticklabel_format(useOffset=False)
    axes.set(xlabel="step", ylabel=size_at_place(study.costs[0].quantity, study.costs[0].column))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    return figure


def draw_front(study: Improvement) -> Figure:
    """Draw the front of two numbers, with the landings as given."""
    figure = new_chart(5.0, 3.6, "What one number costs in the other")
    axes, points = figure.add_subplot(), np.array([point.values for point in study.front])
    axes.plot(*points.T, color=CURVES[0], marker="o", markersize=4.0, linewidth=1.2, label="front")
    # The front has magnitudes of numbers of either sign.
    axes.plot(*(abs(before) for before, _ in study.values), color=INK, marker="s", linestyle="none", label="as given")
    x, y = (size_at_place(cost.quantity, cost.column) for cost in study.costs)
    axes.set(xlabel=x, ylabel=y)
    axes.legend()
    return figure
