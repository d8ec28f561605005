"""The damage boundary of parts, peak acceleration over velocity change, with their landings."""

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.landing.contact import contact_name
from shockpc.landing.ratings import Strength
from shockpc.quantities.records import PartMargin
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.wording import robot_name
from shockpc.text.printed import printable

MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
"""One for each landing."""


def draw_damage(profiles: Sequence[ShockProfile]) -> Figure:
    """Draw the boundary of each part at a point in a colour.

    Its velocity change and peak in each landing are a mark. Where only a survived pulse is known,
    its bounds are dashed. A landing without a known peak is a line at its velocity change.
    """
    figure = new_chart(6.6, 4.0, f"Damage boundary of parts of {robot_name(profiles[0].robot)}")
    axes = figure.add_subplot(
        xscale="log", yscale="log", xlabel="velocity change [m/s]", ylabel="peak acceleration [g]"
    )
    axes.grid(True)
    x: list[float | None] = []
    y: list[float | None] = []
    for profile in profiles:
        for part, bound in _at_points(profile):
            x += [part.speed_change, bound.velocity_change]
            y += [part.peak_g, bound.acceleration]
    axes.set(xlim=_window(x, (0.1, 10.0)), ylim=_window(y, (10.0, 1000.0)))
    boundaries = _at_points(profiles[0])
    for k, (part, bound) in enumerate(boundaries):
        _draw_boundary(axes, part, bound, CURVES[k % len(CURVES)])
    for number, profile in enumerate(profiles):
        _draw_landing(axes, number, profile)
    for axis in (axes.xaxis, axes.yaxis):
        plain_numbers(axis)
    figure.legend(loc="outside right upper")
    words = []
    if not all(bound.both for _, bound in boundaries):
        words.append("solid: damage is possible in the shaded area")
    if any(bound.both for _, bound in boundaries):
        words.append("dashed: no damage to the left and below (a survived pulse, lower bounds)")
    if profiles[0].impact_length is None:
        words.append(
            "dotted: velocity change of a landing whose peak is not known without a pulse or a "
            "contact stiffness"
        )
    figure.supxlabel("\n".join(words), fontsize=7.0, x=0.02, ha="left")
    return figure


def _draw_boundary(axes: Axes, part: PartMargin, bound: Strength, colour: str) -> None:
    """Draw what a part withstands."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    name = printable(part.part, 32)
    v, a = bound.velocity_change, bound.acceleration
    if bound.both:
        axes.plot([v, v, left], [low, a, a], color=colour, linestyle=(0, (5, 2)), label=name)
        return
    corner = low / 2.0 if math.isnan(a) else a
    axes.plot([v, v, right], [high, corner, corner], color=colour, label=name)
    axes.fill_between([v, right], corner, high, color=colour, alpha=0.08, linewidth=0.0)


def _draw_landing(axes: Axes, number: int, profile: ShockProfile) -> None:
    """Draw velocity change and peak of the parts in a landing. Args: number, of the landing."""
    mark: dict[str, Any] = {
        "marker": MARKS[number % len(MARKS)],
        "linestyle": "none",
        "markerfacecolor": "none",
        "markersize": 6.5 + number,
    }
    name = printable(contact_name(profile.scene), 32)
    axes.plot([], [], color=INK, label=f"landing on {name}", **mark)
    low, _ = axes.get_ylim()
    for k, (part, _) in enumerate(_at_points(profile)):
        colour = CURVES[k % len(CURVES)]
        peak = part.peak_g
        if peak is None:
            axes.axvline(part.speed_change, color=colour, linewidth=0.8, linestyle=":")
            peak = low * 1.12
        axes.plot([part.speed_change], [peak], color=colour, clip_on=False, zorder=5, **mark)


def _at_points(profile: ShockProfile) -> list[tuple[PartMargin, Strength]]:
    """The parts at points, with their damage boundary."""
    parts = []
    for part in profile.parts:
        if isinstance(part.strength, Strength):
            parts.append((part, part.strength))
    return parts


def _window(values: Sequence[float | None], usual: tuple[float, float]) -> tuple[float, float]:
    """Limits of a logarithmic axis around the values above zero, a factor of 4 wider.

    A power of ten lies between them. Without any value they are the usual ones.
    """
    known = [value for value in values if value is not None and 0.0 < value < math.inf]
    return (min(known) / 4.0, max(known) * 4.0) if known else usual
