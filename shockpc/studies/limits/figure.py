"""The map of a number over joint and strike angle, with the bound and the robot file's limits."""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

from shockpc.core.spatial import Array
from shockpc.landing.contact import contact_name
from shockpc.show.figure.style import BANDS, INK, PAPER, SHOCK, new_chart
from shockpc.show.wording import robot_name, varied_text
from shockpc.studies.limits.study import JointLimits
from shockpc.text.printed import UNITS, printable

SHARES = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0)
"""Limits of the bands as multiples of the bound; the last band is open."""

LEAST = (0.0, *(1.0 / share for share in SHARES[:0:-1]))
"""Limits of the bands as multiples of a bound that is the smallest value allowed."""

COLOURS = (*BANDS[:5], *BANDS[6:])
"""Five blues for what is allowed, four reds beyond the bound."""

ALLOWED = "#2f7d4f"

FINER = 5
"""Strike angles of the map for each of those that are computed."""

BESIDE = 1.0
"""Width of the map on each side of a single strike angle, which has no width [deg]."""

JUMP = 5.0
"""Between postures, the strike with the maximum is not joined over more than this [deg]."""

SAMPLES = 600
"""Postures of the map, at most."""

SCENE: dict[str, Any] = {"markersize": 5.0, "color": PAPER, "markeredgecolor": INK}
"""Style of the mark of the scene."""

BAR: dict[str, Any] = {
    "drawedges": True,
    "aspect": 28,
    "pad": 0.02,
    "extendrect": True,
    "extendfrac": "auto",
    "format": "%.3g",
}
"""Layout of the colour bar."""


class _Map(NamedTuple):
    """A number over values and strike angles, as it is drawn.

    Attributes:
        values: (n,) as they are shown.
        angles: (T,) strike angles [deg].
        numbers: (T, n).
    """

    values: Array
    angles: Array
    numbers: Array


def draw_limits(limits: JointLimits) -> Figure:
    """Draw the map, and below it a strip with what is allowed at every strike."""
    scale, unit = UNITS.get(limits.unit, (1.0, limits.unit))
    figure = new_chart(7.2, 4.6, _title(limits))
    axes, strip = figure.subplots(2, 1, sharex=True, height_ratios=(14, 1))
    drawn = _map(limits, scale)
    bands = _draw_bands(axes, limits, drawn)
    words = [f"dotted: strike with the {'minimum' if limits.bound.below else 'maximum'}"]

    # Limits of the file and the scene, where they are on the map.
    low, high = limits.range
    ends = [end for end in limits.file_limits if low <= end <= high]
    for end in ends:
        _draw_end(axes, scale * end)
        _draw_end(strip, scale * end)
    if ends:
        words.append("dashed: limits in the file")
    value, angle = limits.present[0], math.degrees(limits.present[1])
    if low <= value <= high and drawn.angles[0] <= angle <= drawn.angles[-1]:
        axes.plot([scale * value], [angle], "o", **SCENE)
        words.append("circle: the scene")

    # The last limits are those at all strikes of the range.
    for interval in limits.limits[-1].intervals:
        strip.axvspan(scale * interval.low, scale * interval.high, color=ALLOWED)
    # Map and strip share the horizontal axis, which is labelled once.
    axes.set(
        ylabel="strike angle [deg]",
        xlim=(drawn.values[0], drawn.values[-1]),
        ylim=(drawn.angles[0], drawn.angles[-1]),
    )
    axes.tick_params(labelbottom=False)
    strip.set(yticks=[], xlabel=f"{varied_text(limits.subject, unit)} [{unit}]")
    strip.set_ylabel(
        "allowed at\nevery strike", rotation=0.0, ha="right", va="center", fontsize=6.5
    )
    bar = figure.colorbar(bands, ax=[axes, strip], **BAR)
    bar.set_label(f"{_label(limits)}; black line: the bound")
    bar.ax.tick_params(length=0.0)
    figure.supxlabel("; ".join(words), fontsize=7.0, x=0.02, ha="left")
    return figure


def _draw_end(axes: Axes, value: float) -> None:
    """Draw a limit of the robot's file."""
    axes.axvline(value, color=INK, linewidth=1.2, linestyle=(0, (5, 3)), clip_on=False)


def _title(limits: JointLimits) -> str:
    number = printable(limits.target.title, 60)
    foot = printable(contact_name(limits.profile.scene), 60)
    return (
        f"{number[:1].upper()}{number[1:]} of {robot_name(limits.profile.robot)} landing on {foot}"
    )


def _label(limits: JointLimits) -> str:
    """The number and its unit."""
    if limits.target.shock:
        return SHOCK
    title = limits.target.selection.quantity.title.partition(",")[0]
    return f"{title} [{limits.target.unit}]"


def _draw_bands(axes: Axes, limits: JointLimits, drawn: _Map) -> Any:
    """Draw the number in bands of colour, the bound, and the strike angle of the worst number.

    Returns: the bands.
    """
    x, y, numbers = drawn
    bound = limits.bound.value
    levels, colours = [bound * share for share in SHARES], COLOURS
    if limits.bound.below:
        levels, colours = [bound * share for share in LEAST], COLOURS[::-1]
    style: dict[str, Any] = {"colors": colours, "extend": "max", "antialiased": False}
    bands = axes.contourf(x, y, numbers, levels=levels, **style)
    axes.contour(x, y, numbers, levels=[bound], colors=INK, linewidths=1.6)

    worst = y[np.argmax(limits.bound.violation(numbers), axis=0)]
    jumps = np.abs(np.diff(worst, append=worst[-1])) > JUMP
    axes.plot(x, np.where(jumps, np.nan, worst), ":", color=INK, linewidth=1.1)
    return bands


def _map(limits: JointLimits, scale: float) -> _Map:
    """The number over some values of the scan, shown as multiples of 1 / scale, and all strikes.

    Between the angles of the scan the square of the number is interpolated, because that of a
    length has no kink where the length is zero.
    """
    scan = limits.scan
    # More postures than the figure has columns of pixels would take time and show nothing.
    n = len(scan.values)
    shown = np.unique(np.linspace(0, n - 1, min(SAMPLES, n)).astype(int))
    inside = scan.inside(limits.strikes)
    angles = np.degrees(scan.angles[inside])
    numbers = scan.numbers[shown][:, inside]
    values = scale * scan.values[shown]
    if len(angles) == 1:
        return _Map(values, angles + np.array([-BESIDE, BESIDE]), np.repeat(numbers.T, 2, axis=0))
    finer = np.linspace(angles[0], angles[-1], FINER * len(angles))
    between = np.full((len(finer), len(values)), np.nan)
    known = np.isfinite(numbers).all(axis=1)
    squares = CubicSpline(angles, numbers[known].T ** 2)(finer)
    between[:, known] = np.sqrt(np.maximum(squares, 0.0))
    return _Map(values, finer, between)
