"""The map of a number over joint and strike angle, with the bound and the limits of the robot's
file.
"""

import itertools
import math

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

from shockpc.core.spatial import Array
from shockpc.show.figure.style import BANDS, INK, PAPER, SHOCK, new_chart
from shockpc.show.wording import contact_name, robot_name, varied_text
from shockpc.studies.limits.study import JointLimits
from shockpc.text.printed import UNITS, printable

SHARES = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 4.0)
"""Limits of the bands as multiples of the bound; the last band is open."""

LEAST = (0.0, *(1.0 / share for share in SHARES[:0:-1]))
"""The same where the bound is the smallest value allowed."""

COLOURS = (*BANDS[:5], *BANDS[6:])
"""Five blues for what is allowed, four reds beyond the bound."""

ALLOWED = "#2f7d4f"

FINER = 5
"""Strike angles of the map for each of those that are computed."""

BESIDE = 1.0
"""How far the map goes beside a single strike angle, which has no width [deg]."""

SAMPLES = 600
"""Postures of the map, at most."""


def draw_limits(study: JointLimits) -> Figure:
    """Draw the map."""
    scale, unit = UNITS.get(study.unit, (1.0, study.unit))
    robot, foot = robot_name(study.profile.robot), printable(contact_name(study.profile), 60)
    figure = new_chart(
        7.2,
        4.6,
        f"{study.target.title[:1].upper()}{printable(study.target.title, 60)[1:]} of {robot} "
        f"landing on {foot}",
    )
    axes, strip = figure.subplots(2, 1, sharex=True, height_ratios=(14, 1))
    chosen = np.unique(
        np.linspace(0, len(study.scan.values) - 1, min(SAMPLES, len(study.scan.values))).astype(int)
    )
    y, numbers = _map(study, chosen)
    x, numbers = scale * study.scan.values[chosen], numbers.T
    below, bound = study.bound.below, study.bound.value
    levels = [bound * share for share in (LEAST if below else SHARES)]
    drawn = axes.contourf(
        x,
        y,
        numbers,
        levels=levels,
        colors=COLOURS[:: -1 if below else 1],
        extend="max",
        antialiased=False,
    )
    axes.contour(x, y, numbers, levels=[bound], colors=INK, linewidths=1.6)
    greatest = y[np.argmax(study.bound.violation(numbers), axis=0)]
    axes.plot(
        x,
        np.where(np.abs(np.diff(greatest, append=greatest[-1])) > 5.0, np.nan, greatest),
        ":",
        color=INK,
        linewidth=1.1,
    )
    words = [f"dotted: strike with the {'minimum' if below else 'maximum'}"]
    ends = [end for end in study.file_limits if study.range[0] <= end <= study.range[1]]
    for end, part in itertools.product(ends, (axes, strip)):
        part.axvline(scale * end, color=INK, linewidth=1.2, linestyle=(0, (5, 3)), clip_on=False)
    if ends:
        words.append("dashed: limits in the file")
    if (
        study.range[0] <= study.present[0] <= study.range[1]
        and y[0] <= math.degrees(study.present[1]) <= y[-1]
    ):
        words.append("circle: the scene")
        axes.plot(
            [scale * study.present[0]],
            [math.degrees(study.present[1])],
            "o",
            markersize=5.0,
            color=PAPER,
            markeredgecolor=INK,
        )
    for interval in study.limits[-1].allowed:
        strip.axvspan(scale * interval.low, scale * interval.high, color=ALLOWED)
    axes.set(ylabel="strike angle [deg]", xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    strip.set(yticks=[], xlabel=f"{varied_text('+'.join(study.joints), unit)} [{unit}]")
    strip.set_ylabel(
        "allowed at\nevery strike", rotation=0.0, ha="right", va="center", fontsize=6.5
    )
    bar = figure.colorbar(
        drawn,
        ax=[axes, strip],
        drawedges=True,
        aspect=28,
        pad=0.02,
        format="%.3g",
        extendrect=True,
        extendfrac="auto",
    )
    title = study.target.selection.quantity.title.partition(",")[0]
    label = SHOCK if study.target.shock else f"{title} [{study.target.unit}]"
    bar.set_label(f"{label}; black line: the bound")
    bar.ax.tick_params(length=0.0)
    axes.tick_params(labelbottom=False)
    figure.supxlabel("; ".join(words), fontsize=7.0, x=0.02, ha="left")
    return figure


def _map(study: JointLimits, chosen: np.ndarray) -> tuple[Array, Array]:
    """Strike angles (T,) of a map [deg], and the number (n, T) in some postures of the scan.

    Between the angles of the scan the square of the number is interpolated: that of a length has no
    kink where the length is zero.
    """
    inside = study.scan.inside(study.strikes)
    angles, numbers = np.degrees(study.scan.angles[inside]), study.scan.numbers[chosen][:, inside]
    if len(angles) == 1:
        return angles + np.array([-BESIDE, BESIDE]), np.repeat(numbers, 2, axis=1)
    finer = np.linspace(angles[0], angles[-1], FINER * len(angles))
    between = np.full((len(numbers), len(finer)), np.nan)
    known = np.isfinite(numbers).all(axis=1)
    squares = CubicSpline(angles, numbers[known] ** 2, axis=1)(finer)
    between[known] = np.sqrt(np.maximum(squares, 0.0))
    return finer, between
