"""The largest effects on a number of some landings as a tornado chart: a bar for each change up and
one for the opposite change.
"""

import math

from matplotlib.figure import Figure
from matplotlib.patches import Patch

from shockpc.show.figure.style import BANDS, CURVES, INK, new_chart
from shockpc.show.wording import contact_name, robot_name, varied_text
from shockpc.studies.sensitivity.report import step_words
from shockpc.studies.sensitivity.study import Sensitivity
from shockpc.text.printed import count, printable

MOST_BARS = 16
"""Bars."""

HEIGHT = 0.24
"""Of one bar with the space around it [inches]."""

LEAST_SHOWN = 0.001
"""Smallest effect that is written as a number [%]."""

COLOURS = {True: BANDS[6], False: CURVES[0], None: CURVES[7]}
"""Of a change that makes the number worse, one that makes it better, and one of a number that
neither direction makes worse.
"""


def draw_tornado(study: Sensitivity) -> Figure:
    """Draw the chart of a study in which some derivative exists."""
    effects, single = study.ranked[:MOST_BARS], len(study.profiles) == 1
    target = printable(study.target.title, 80)
    what = (
        contact_name(study.profiles[0])
        if single
        else f"{count(len(study.profiles), 'landing')}, {'mean' if study.mean else 'worst'}"
    )
    landing = (
        f"{robot_name(study.profiles[0].robot)}{' landing on' if single else ','} "
        f"{printable(what, 60)}"
    )
    figure = new_chart(7.2, 1.5 + HEIGHT * len(effects), f"What changes the {target}: {landing}")
    axes, rows = figure.add_subplot(), range(len(effects))
    largest = max(
        abs(change)
        for effect in effects
        for change in (effect.up, effect.down)
        if not math.isnan(change)
    )
    largest = max(largest, 1e-9 * abs(study.value)) or 1.0
    for row, effect in enumerate(effects):
        for change, solid in ((effect.down, False), (effect.up, True)):
            if not math.isnan(change):
                colour = COLOURS[study.worse(change)]
                axes.barh(
                    row,
                    change,
                    left=study.value,
                    height=0.72,
                    facecolor=colour if solid else "none",
                    edgecolor=colour,
                )
        percent = 100.0 * effect.up / study.value
        share = (
            f"{percent:+.3g} %".replace("-", "−")
            if abs(percent) >= LEAST_SHOWN
            else f"< {LEAST_SHOWN} %"
            if percent
            else "0 %"
        )
        end = study.value + effect.up
        side, shift = ("left", 3.0) if effect.up >= 0.0 else ("right", -3.0)
        axes.annotate(
            share,
            (end, row),
            (shift, 0.0),
            textcoords="offset points",
            ha=side,
            va="center",
            fontsize=6.5,
        )
    axes.set_yticks(
        rows, [f"{varied_text(one.parameter, one.unit)}   +{step_words(one)}" for one in effects]
    )
    axes.set_ylim(len(effects) - 0.4, -0.6)
    axes.axvline(study.value, color=INK, linewidth=0.8)
    axes.set_xlim(study.value - 1.25 * largest, study.value + 1.25 * largest)
    axes.set_xlabel(
        f"{target} [{study.target.unit}]; now {study.value:.4g}; effects to first order"
    )
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)
    known = study.target.selection.quantity.worse != "neither"
    marks = (
        [Patch(color=COLOURS[True], label="worse"), Patch(color=COLOURS[False], label="better")]
        if known
        else []
    )
    marks += [
        Patch(facecolor=INK, edgecolor=INK, label="change as given, with its effect"),
        Patch(facecolor="none", edgecolor=INK, label="the opposite change"),
    ]
    figure.legend(handles=marks, loc="outside lower right", ncols=len(marks), fontsize=7.0)
    return figure
