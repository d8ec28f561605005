"""The search for an optimum as figures: the target over the steps of the runs, and the front of two
numbers.
"""

import itertools

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shockpc.show.figure.style import CURVES, INK, faded, new_chart, plain_numbers
from shockpc.show.wording import count, size_at_place
from shockpc.studies.improve.study import Improvement


def draw_runs(study: Improvement) -> Figure:
    """Draw the best value so far of each run over its steps; the constraints may not hold at a step
    between others.
    """
    figure = new_chart(5.0, 3.6, f"{count(len(study.runs), 'run')}: the best value so far")
    axes, better = figure.add_subplot(), np.fmin if study.costs[0].power > 0.0 else np.fmax
    # A run that has ended, or has no value at a step, keeps what it has reached.
    reached = better.accumulate(
        np.array(list(itertools.zip_longest(*study.runs, fillvalue=np.nan)))
    )
    others, last = reached[:, 1:], len(study.runs[0])
    known = np.isfinite(others).any(axis=1)
    for part, shade, label in (
        (((0, 100), 0.8, "all other runs"), ((25, 75), 0.5, "half of them")) if known.any() else ()
    ):
        low, high = np.nanpercentile(others[known], part, axis=1)
        axes.fill_between(
            np.flatnonzero(known),
            low,
            high,
            step="post",
            color=faded(CURVES[0], shade),
            linewidth=0.0,
            label=label,
        )
    axes.step(
        range(last),
        reached[:last, 0],
        where="post",
        color=INK,
        linewidth=1.6,
        label="to the optimum",
    )
    axes.plot(last - 1, reached[last - 1, 0], "o", color=INK, markersize=4.0)
    axes.legend()
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
    axes.plot(
        *(abs(before) for before, _ in study.values),
        color=INK,
        marker="s",
        linestyle="none",
        label="as given",
    )
    x, y = (size_at_place(cost.quantity, cost.column) for cost in study.costs)
    axes.set(xlabel=x, ylabel=y)
    axes.legend()
    return figure
