"""The map of a number over joint and strike angle, with the bound and the robot file's limits."""

import math
from typing import Any

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


def draw_limits(study: JointLimits) -> Figure:
    """Draw the map."""
    scale, unit = UNITS.get(study.unit, (1.0, study.unit))
    figure = new_chart(7.2, 4.6, _title(study))
    axes, strip = figure.subplots(2, 1, sharex=True, height_ratios=(14, 1))

    n = len(study.scan.values)
    # More postures than the figure has columns of pixels would take time and show nothing.
    drawn = np.unique(np.linspace(0, n - 1, min(SAMPLES, n)).astype(int))
    x = scale * study.scan.values[drawn]
    y, numbers = _rows(study, drawn)
    bands = _draw_bands(axes, study, x, y, numbers.T)

    # Limits of the file and the scene, where they are on the map, and the words below it.
    words = [f"dotted: strike with the {'minimum' if study.bound.below else 'maximum'}"]
    ends = [end for end in study.file_limits if study.range[0] <= end <= study.range[1]]
    for end in ends:
        for part in (axes, strip):
            dashes: Any = (0, (5, 3))
            part.axvline(scale * end, color=INK, linewidth=1.2, linestyle=dashes, clip_on=False)
    if ends:
        words.append("dashed: limits in the file")
    # The scene itself may be outside the map.
    value, angle = study.present[0], math.degrees(study.present[1])
    low, high = study.range
    if low <= value <= high and y[0] <= angle <= y[-1]:
        words.append("circle: the scene")
        circle: dict[str, Any] = {"markersize": 5.0, "color": PAPER, "markeredgecolor": INK}
        axes.plot([scale * value], [angle], "o", **circle)

    # The strip below has what is allowed at every strike.
    for interval in study.limits[-1].intervals:
        strip.axvspan(scale * interval.low, scale * interval.high, color=ALLOWED)
    axes.set(ylabel="strike angle [deg]", xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    axes.tick_params(labelbottom=False)
    strip.set(yticks=[], xlabel=f"{varied_text(study.subject, unit)} [{unit}]")
    beside: dict[str, Any] = {"rotation": 0.0, "ha": "right", "va": "center", "fontsize": 6.5}
    strip.set_ylabel("allowed at\nevery strike", **beside)

    layout: dict[str, Any] = {"drawedges": True, "aspect": 28, "pad": 0.02}
    ends_of_bar: dict[str, Any] = {"extendrect": True, "extendfrac": "auto"}
    bar = figure.colorbar(bands, ax=[axes, strip], format="%.3g", **layout, **ends_of_bar)
    bar.set_label(f"{_label(study)}; black line: the bound")
    bar.ax.tick_params(length=0.0)
    figure.supxlabel("; ".join(words), fontsize=7.0, x=0.02, ha="left")
    return figure


def _title(study: JointLimits) -> str:
    number = printable(study.target.title, 60)
    foot = printable(contact_name(study.profile.scene), 60)
    return (
        f"{number[:1].upper()}{number[1:]} of {robot_name(study.profile.robot)} landing on {foot}"
    )


def _label(study: JointLimits) -> str:
    """The number and its unit."""
    if study.target.shock:
        return SHOCK
    title = study.target.selection.quantity.title.partition(",")[0]
    return f"{title} [{study.target.unit}]"


def _draw_bands(axes: Axes, study: JointLimits, x: Array, y: Array, numbers: Array) -> Any:
    """Draw the number in bands of colour, the bound, and the strike angle of the worst number.

    Args:
        axes: the axes.
        study: the limits.
        x: (n,) values, as they are shown.
        y: (S,) strike angles [deg].
        numbers: (S, n).

    Returns: the bands.
    """
    bound = study.bound.value
    levels, colours = [bound * share for share in SHARES], COLOURS
    if study.bound.below:
        levels, colours = [bound * share for share in LEAST], COLOURS[::-1]
    style: dict[str, Any] = {"colors": colours, "extend": "max", "antialiased": False}
    bands = axes.contourf(x, y, numbers, levels=levels, **style)
    axes.contour(x, y, numbers, levels=[bound], colors=INK, linewidths=1.6)

    worst = y[np.argmax(study.bound.violation(numbers), axis=0)]
    jumps = np.abs(np.diff(worst, append=worst[-1])) > JUMP
    axes.plot(x, np.where(jumps, np.nan, worst), ":", color=INK, linewidth=1.1)
    return bands


def _rows(study: JointLimits, drawn: np.ndarray) -> tuple[Array, Array]:
    """Strike angles (T,) of a map [deg], and the number (n, T) in some values of the scan.

    Between the angles of the scan the square of the number is interpolated, because that of a
    length has no kink where the length is zero.
    """
    inside = study.scan.inside(study.strikes)
    angles = np.degrees(study.scan.angles[inside])
    numbers = study.scan.numbers[drawn][:, inside]
    if len(angles) == 1:
        return angles + np.array([-BESIDE, BESIDE]), np.repeat(numbers, 2, axis=1)
    finer = np.linspace(angles[0], angles[-1], FINER * len(angles))
    between = np.full((len(numbers), len(finer)), np.nan)
    known = np.isfinite(numbers).all(axis=1)
    squares = CubicSpline(angles, numbers[known] ** 2, axis=1)(finer)
    between[known] = np.sqrt(np.maximum(squares, 0.0))
    return finer, between
