"""An optimum as figures: the worst landing as given and at the optimum, the target over the steps of the runs; and a front."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shockpc.show.figure.landing import draw_row
from shockpc.show.figure.layout import LEFT, Page
from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.figure.view import view_of, windows_of
from shockpc.show.wording import at_place, joint_model_text, robot_name
from shockpc.studies.improve import Improvement
from shockpc.text.printed import printable

GAP, FOOT, CHART = 0.25, 0.95, 2.7
"""Between panels, under the pictures, and width of the chart [inches]."""


def draw_improvement(study: Improvement) -> Figure:
    """Draw both silhouettes with their shock, and the runs."""
    profiles = study.before[study.worst], study.after[study.worst]
    views = [view_of(profile) for profile in profiles]
    windows = windows_of(views, (0.1, 0.1), (6.6, 3.4), (1.6, 1.6), arrow=0.45)
    width = sum(window.sides[0] + GAP for window in windows)
    x, tall = LEFT + width + 0.75, max(max(window.sides[1] for window in windows) + FOOT + 0.3, 2.9)
    (before, after), target = study.values[0], at_place(study.cost.quantities[0])
    page = Page(
        x + CHART,
        tall,
        [
            f"{target}: {before:.3g} as given, {after:.3g} at the optimum",
            printable(f"{robot_name(profiles[0].robot)}, {study.worst}".removesuffix(", "), 100),
            f"joint model: {joint_model_text(profiles[0])}",
        ],
    )
    draw_row(page, page.low + FOOT + 0.3, views, windows, ("as given", "optimum"), GAP)
    page.bar(LEFT, width - GAP)
    axes = page.axes(x, page.low + 0.75, CHART - 0.1, tall - 1.25)
    for k, run in enumerate(study.runs):
        # The constraints may not hold at a step between others.
        held = np.flatnonzero(np.isfinite(run))
        colour = INK if k == 0 else CURVES[k % len(CURVES)]
        reached = (np.minimum if study.values[0][1] <= study.values[0][0] else np.maximum).accumulate(run[held])
        axes.step(held, reached, where="post", color=colour, linewidth=1.6 if k == 0 else 0.9, marker=".", markersize=2.5)
    known = np.concatenate([run[np.isfinite(run)] for run in study.runs])
    if known.size and known.min() > 0.0 and known.max() > 20.0 * known.min():
        axes.set_yscale("log")
        plain_numbers(axes.yaxis)
    axes.set(xlabel="step (black: run to the optimum)", ylabel=_label(study, 0))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    return page.figure


def _label(study: Improvement, role: int) -> str:
    return f"{at_place(study.cost.quantities[role])} [{study.columns[role].unit}]"


def draw_front(study: Improvement) -> Figure:
    """Draw the front of two numbers, with the landings as given."""
    figure = new_chart(5.0, 3.6, "What one number costs in the other")
    axes, points = figure.add_subplot(), np.array([point.values for point in study.front])
    axes.plot(*points.T, color=CURVES[0], marker="o", markersize=4.0, linewidth=1.2, label="front")
    axes.plot(study.values[0][0], study.values[1][0], color=INK, marker="s", linestyle="none", label="as given")
    axes.set(**{f"{axis}label": _label(study, role) for role, axis in enumerate("xy")})
    axes.legend()
    return figure
