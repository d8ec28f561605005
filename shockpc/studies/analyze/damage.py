"""The damage boundary of parts, peak acceleration over velocity change, with the landings that they
go through.
"""

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from shockpc.landing.ratings import Strength
from shockpc.quantities.records import PartMargin
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.wording import contact_name, robot_name
from shockpc.text.printed import printable

MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
"""One for each landing."""


def draw_damage(profiles: Sequence[ShockProfile]) -> Figure:
    """Draw the boundary of each part at a point in a colour; its velocity change and peak in each
    landing are a mark.

    Where only a survived pulse is known, its bounds are dashed. A landing without a known peak is a
    line at its velocity change.
    """
    figure = new_chart(6.6, 4.0, f"Damage boundary of parts of {robot_name(profiles[0].robot)}")
    axes = figure.add_subplot(
        xscale="log", yscale="log", xlabel="velocity change [m/s]", ylabel="peak acceleration [g]"
    )
    axes.grid(True)
    drawn = [_at_points(profile) for profile in profiles]
    x = [
        v
        for pairs in drawn
        for one, bound in pairs
        for v in (one.speed_change, bound.velocity_change)
    ]
    y = [a for pairs in drawn for one, bound in pairs for a in (one.peak_g, bound.acceleration)]
    (left, right), (low, high) = _window(x, (0.1, 10.0)), _window(y, (10.0, 1000.0))
    axes.set(xlim=(left, right), ylim=(low, high))
    for k, (one, bound) in enumerate(drawn[0]):
        colour, name = CURVES[k % len(CURVES)], printable(one.part, 32)
        v, a = bound.velocity_change, bound.acceleration
        if bound.both:
            axes.plot([v, v, left], [low, a, a], color=colour, linestyle=(0, (5, 2)), label=name)
        else:
            corner = low / 2.0 if math.isnan(a) else a
            axes.plot([v, v, right], [high, corner, corner], color=colour, label=name)
            axes.fill_between([v, right], corner, high, color=colour, alpha=0.08, linewidth=0.0)
    for m, (profile, pairs) in enumerate(zip(profiles, drawn, strict=True)):
        mark: dict[str, Any] = {
            "marker": MARKS[m % len(MARKS)],
            "linestyle": "none",
            "markerfacecolor": "none",
            "markersize": 6.5 + m,
        }
        axes.plot(
            [], [], color=INK, label=f"landing on {printable(contact_name(profile), 32)}", **mark
        )
        for k, (one, _) in enumerate(pairs):
            dv, colour = one.speed_change, CURVES[k % len(CURVES)]
            if one.peak_g is None:
                axes.axvline(dv, color=colour, linewidth=0.8, linestyle=":")
            axes.plot(
                [dv],
                [low * 1.12 if one.peak_g is None else one.peak_g],
                color=colour,
                clip_on=False,
                zorder=5,
                **mark,
            )
    for axis in (axes.xaxis, axes.yaxis):
        plain_numbers(axis)
    figure.legend(loc="outside right upper")
    survived = {bound.both for _, bound in drawn[0]}
    words = ["solid: damage is possible in the shaded area"] * (False in survived)
    words += ["dashed: no damage to the left and below (a survived pulse, lower bounds)"] * (
        True in survived
    )
    words += [
        "dotted: velocity change of a landing whose peak is not known without a pulse or a contact "
        "stiffness"
    ] * (profiles[0].impact_length is None)
    figure.supxlabel("\n".join(words), fontsize=7.0, x=0.02, ha="left")
    return figure


def _at_points(profile: ShockProfile) -> list[tuple[PartMargin, Strength]]:
    """The parts at points, with their damage boundary."""
    return [(one, one.strength) for one in profile.parts if isinstance(one.strength, Strength)]


def _window(values: Sequence[float | None], usual: tuple[float, float]) -> tuple[float, float]:
    """Limits of a logarithmic axis around the values above zero, a factor of 4 wider, so that a
    power of ten lies between them.

    Without any value they are the usual ones.
    """
    known = [value for value in values if value is not None and 0.0 < value < math.inf]
    return (min(known) / 4.0, max(known) * 4.0) if known else usual
