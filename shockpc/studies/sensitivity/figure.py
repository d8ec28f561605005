"""The largest effects on a number of some landings as a tornado chart.

It has a bar for each change up, and one for the opposite change.
"""

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from shockpc.landing.contact import contact_name
from shockpc.show.figure.style import BANDS, CURVES, INK, new_chart
from shockpc.show.wording import robot_name, varied_text
from shockpc.studies.sensitivity.study import Sensitivity
from shockpc.text.printed import count, printable

MOST_BARS = 16
"""Bars."""

HEIGHT = 0.24
"""Height of a bar with the space around it [inches]."""

LEAST_SHOWN = 0.001
"""Smallest effect that is written as a number [%]."""

COLOURS = {True: BANDS[6], False: CURVES[0], None: CURVES[7]}
"""Colours of changes that make the number worse, and better; None: neither direction is worse."""


def draw_tornado(sensitivity: Sensitivity) -> Figure:
    """Draw the chart of a study in which some derivative exists."""
    effects = sensitivity.ranked[:MOST_BARS]
    target = printable(sensitivity.target.title, 80)
    title = f"What changes the {target}: {_landings_text(sensitivity)}"
    figure = new_chart(7.2, 1.5 + HEIGHT * len(effects), title)
    axes = figure.add_subplot()
    for row, effect in enumerate(effects):
        _draw_bar(axes, sensitivity, row, effect.down, solid=False)
        _draw_bar(axes, sensitivity, row, effect.up, solid=True)
        _write_share(axes, sensitivity, row, effect.up)
    names = [
        f"{varied_text(effect.parameter, effect.unit)}   +{effect.step_text}" for effect in effects
    ]
    axes.set_yticks(range(len(effects)), names)
    # Rows go down, with the largest effect at the top.
    axes.set_ylim(len(effects) - 0.4, -0.6)
    axes.axvline(sensitivity.value, color=INK, linewidth=0.8)
    # Room for the shares beside the longest bar, also where rounding is all that there is.
    largest = max(effect.largest for effect in effects)
    reach = 1.25 * (max(largest, 1e-9 * abs(sensitivity.value)) or 1.0)
    axes.set_xlim(sensitivity.value - reach, sensitivity.value + reach)
    axes.set_xlabel(
        f"{target} [{sensitivity.target.unit}]; now {sensitivity.value:.4g}; effects to first order"
    )
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)

    # The colour says better or worse, where the quantity has such a sense; the filling says which
    # of the two opposite changes it is.
    marks = []
    if sensitivity.target.selection.quantity.worse != "neither":
        marks.append(Patch(color=COLOURS[True], label="worse"))
        marks.append(Patch(color=COLOURS[False], label="better"))
    solid = "change as given, with its effect"
    marks.append(Patch(facecolor=INK, edgecolor=INK, label=solid))
    marks.append(Patch(facecolor="none", edgecolor=INK, label="the opposite change"))
    figure.legend(handles=marks, loc="outside lower right", ncols=len(marks), fontsize=7.0)
    return figure


def _landings_text(sensitivity: Sensitivity) -> str:
    """The robot and its landings."""
    first = sensitivity.profiles[0]
    name = robot_name(first.robot)
    if len(sensitivity.profiles) == 1:
        return f"{name} landing on {printable(contact_name(first.scene), 60)}"
    over = "mean" if sensitivity.mean else "worst"
    return f"{name}, {count(len(sensitivity.profiles), 'landing')}, {over}"


def _draw_bar(
    axes: Axes, sensitivity: Sensitivity, row: int, change: float, *, solid: bool
) -> None:
    """Draw the bar of a change of the target; none of one that does not exist."""
    if math.isnan(change):
        return
    colour = COLOURS[sensitivity.worse(change)]
    axes.barh(
        row,
        change,
        left=sensitivity.value,
        height=0.72,
        facecolor=colour if solid else "none",
        edgecolor=colour,
    )


def _write_share(axes: Axes, sensitivity: Sensitivity, row: int, change: float) -> None:
    """Write a change of the target in per cent beside the end of its bar."""
    side, shift = ("left", 3.0) if change >= 0.0 else ("right", -3.0)
    axes.annotate(
        _percent(100.0 * change / sensitivity.value),
        (sensitivity.value + change, row),
        (shift, 0.0),
        textcoords="offset points",
        ha=side,
        va="center",
        fontsize=6.5,
    )


def _percent(percent: float) -> str:
    """A change [%] in words."""
    if abs(percent) >= LEAST_SHOWN:
        return f"{percent:+.3g} %".replace("-", "−")
    return f"< {LEAST_SHOWN} %" if percent else "0 %"
