"""The search for an optimum as a figure: the target over the steps of the runs."""

import itertools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shockpc.core.spatial import Array
from shockpc.show.figure.style import CURVES, INK, faded, new_chart, plain_numbers
from shockpc.show.wording import size_at_place
from shockpc.studies.improve.improvement import Improvement
from shockpc.text.printed import count

RANGES = (((0, 100), 0.8, "all other runs"), ((25, 75), 0.5, "half of them"))
"""Percentiles between which the other runs are shaded, how pale, and the label."""

LOGARITHMIC = 20.0
"""Ratio of the largest to the smallest value from which the axis is logarithmic."""


def draw_runs(improvement: Improvement) -> Figure:
    """Draw the best value so far of each run over its steps.

    The constraints may not hold at a step between others.
    """
    figure = new_chart(5.0, 3.6, f"{count(len(improvement.runs), 'run')}: the best value so far")
    axes = figure.add_subplot()
    better = np.fmin if improvement.cost.power > 0.0 else np.fmax
    # A run that has ended, or has no value at a step, keeps what it has reached.
    values = np.array(list(itertools.zip_longest(*improvement.runs, fillvalue=np.nan)))
    reached = better.accumulate(values)
    _shade(axes, reached[:, 1:])
    best = reached[: len(improvement.runs[0]), 0]
    axes.step(
        range(len(best)), best, where="post", color=INK, linewidth=1.6, label="to the optimum"
    )
    axes.plot(len(best) - 1, best[-1], "o", color=INK, markersize=4.0)
    axes.legend()
    known = values[np.isfinite(values)]
    if known.size and known.min() > 0.0 and known.max() > LOGARITHMIC * known.min():
        axes.set_yscale("log")
        plain_numbers(axes.yaxis)
    else:
        axes.ticklabel_format(useOffset=False)
    axes.set(
        xlabel="step", ylabel=size_at_place(improvement.cost.quantity, improvement.cost.column)
    )
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    return figure


def _shade(axes: Axes, reached: Array) -> None:
    """Shade where some runs are: their values (steps, runs)."""
    known = np.isfinite(reached).any(axis=1)
    if not known.any():
        return
    for percentiles, shade, label in RANGES:
        low, high = np.nanpercentile(reached[known], percentiles, axis=1)
        axes.fill_between(
            np.flatnonzero(known),
            low,
            high,
            step="post",
            color=faded(CURVES[0], shade),
            linewidth=0.0,
            label=label,
        )
