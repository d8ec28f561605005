"""A landing on contacts of finite stiffness over time, and shock response spectra of points.

It has forces, accelerations and torques.
"""

from collections.abc import Sequence
from dataclasses import replace
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.low_pass import LowPass
from shockpc.core.spatial import Array
from shockpc.landing.contact import contact_name
from shockpc.landing.places import Place
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import DELTA_V, low_passes
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.wording import robot_name
from shockpc.text.printed import count, printable
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding, compliant_landing
from shockpc.wings.compliant.over_time.spectra import DAMPING, SPECTRUM, spectrum
from shockpc.wings.compliant.show.histories import moving_points
from shockpc.wings.compliant.show.panels import (
    ACCELERATION,
    TimePanel,
    events_of,
    normal_forces,
    panels_of,
    times_of,
)

CURVES_SHOWN, SMALL = 6, 0.05
"""Most curves of a panel, and smallest peak of them as a share of the largest.

The curves are those of the largest peaks.
"""

MOST_EVENTS = 8
"""Most events that are written."""

AFTER, BEYOND = 0.03, 1.5
"""Time that is shown after the end, and that for peaks of readings.

The first is a share of the duration, the second a multiple of the times of the peaks.
"""

ROOM = 5.6
"""Width of the panels, about [inches]."""

LETTER, LINE, LETTERS = 4.3, 9.5, 120
"""Width of a letter and height of a line [pt], and letters of a line below the panels.

Width and height are those over the first panel.
"""

SAMPLES = 600
"""Times of a curve."""


def draw_time(profile: ShockProfile) -> Figure:
    """Draw forces of contacts, accelerations of points and torques along the axes of joints.

    Those of rigid links are drawn too.
    """
    compliant = compliant_landing(profile.landing)
    figure = new_chart(7.2, 5.4, f"{_landing_text(profile)}, over time")
    t = times_of(compliant)
    panels = panels_of(profile, compliant, t)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]

    # The same landing with rigid links shows what bending changes.
    of_rigid: list[Array | None] = [None] * len(panels)
    if profile.scene.flex:
        landing = replace(profile.landing, scene=replace(profile.landing.scene, flex={}))
        of_rigid = [panel.curves for panel in panels_of(profile, compliant_landing(landing), t)]

    points = moving_points(profile.places("point"))
    filters = low_passes(profile.landing, points)
    for axes, panel, rigid in zip(rows, panels, of_rigid, strict=True):
        _plot(axes, 1e3 * t, panel, rigid)
        if panel.heading == ACCELERATION:
            _plot_readings(axes, compliant, points, filters)
    # Dashed beside the force of each contact: its part along the normal.
    for k, force in enumerate(normal_forces(profile, compliant, t).T):
        colour = CURVES[k % len(CURVES)]
        rows[0].plot(1e3 * t, force, color=colour, linewidth=0.8, linestyle=(0, (4, 2)))
    rows[-1].set_xlabel("time after touchdown [ms]")
    end = _last_shown(compliant, points, filters)
    rows[-1].set_xlim(0.0, 1e3 * (1.0 + AFTER) * end)

    left_out = _write_events(list(rows), events_of(profile, compliant))
    # The line below the figure explains only what is drawn.
    words = ["dashed: along the normal", "dotted: what happens to a contact"]
    if any(filters):
        words.append("dash-dotted: what an accelerometer reads")
    if profile.scene.flex:
        words.append("thin: rigid links")
    if left_out:
        words.append(f"{count(left_out, 'more event')} not written")
    words.append("frozen geometry, double precision")
    figure.supxlabel(fill("; ".join(words), LETTERS), fontsize=7.0, x=0.02, ha="left")
    return figure


def _last_shown(
    compliant: CompliantLanding, points: Sequence[Place], filters: Sequence[LowPass | None]
) -> float:
    """Time until which the landing is shown [s].

    What accelerometers read goes on after the end, and may have its peak there.
    """
    last = compliant.motion.duration
    for place, low_pass in zip(points, filters, strict=True):
        if low_pass is not None:
            _, times = compliant.peaks(DELTA_V.compute, [place], low_pass)
            last = max(last, BEYOND * float(times[0]))
    return last


def _plot_readings(
    axes: Axes,
    compliant: CompliantLanding,
    points: Sequence[Place],
    filters: Sequence[LowPass | None],
) -> None:
    """Draw what accelerometers at points read behind their filters.

    The curves are dash-dotted, in the colours of the raw ones.
    """
    colours = {line.get_label(): line.get_color() for line in axes.get_lines()}
    for place, low_pass in zip(points, filters, strict=True):
        colour = colours.get(printable(place.name, 30))
        if low_pass is None or not colour:
            continue
        t = np.linspace(0.0, compliant.filtered(low_pass).duration, SAMPLES)
        acceleration = compliant.history(DELTA_V.compute, [place], t, low_pass)[:, 0]
        read = np.linalg.norm(acceleration, axis=1) / GRAVITY
        axes.plot(1e3 * t, read, color=colour, linewidth=1.2, linestyle="dashdot")


def _write_events(rows: Sequence[Axes], events: Sequence[tuple[float, str]]) -> int:
    """Mark events in all panels and write them over the first one; returns how many are left.

    None is written over another.
    """
    lines: list[list[tuple[float, float]]] = []
    written = events[:MOST_EVENTS]
    for time, text in written:
        for axes in rows:
            axes.axvline(1e3 * time, color=INK, linewidth=0.6, linestyle=":")
        _write_event(rows[0], 1e3 * time, text, lines)
    return len(events) - len(written)


def _write_event(axes: Axes, x: float, text: str, lines: list[list[tuple[float, float]]]) -> None:
    """Write an event over a panel, at an abscissa x, in the first line with room."""
    low, high = axes.get_xlim()
    width, length = 72.0 * ROOM, LETTER * len(text)
    left = width * (x - low) / (high - low) - length / 2.0
    left = min(max(left, 0.0), width - length)
    line = _free_line(lines, left, left + length)
    side = "center"
    if left == 0.0:
        side, x = "left", low
    elif left == width - length:
        side, x = "right", high
    axes.annotate(
        text,
        (x, 1.0),
        (0.0, 3.0 + LINE * line),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        ha=side,
        va="bottom",
        fontsize=7.0,
    )


def _free_line(lines: list[list[tuple[float, float]]], left: float, right: float) -> int:
    """The first line with room for a text from left to right [pt], which is then taken."""
    for k, taken in enumerate(lines):
        is_beside = [left > end + LETTER or right < start - LETTER for start, end in taken]
        if all(is_beside):
            taken.append((left, right))
            return k
    lines.append([(left, right)])
    return len(lines) - 1


def draw_spectrum(profile: ShockProfile) -> Figure:
    """Draw the shock response spectrum of each point, without damping and with 5 %."""
    compliant = compliant_landing(profile.landing)
    points = moving_points(profile.places("point"))
    filters = low_passes(profile.landing, points)
    figure = new_chart(7.2, 3.8, f"Shock response spectrum, {_landing_text(profile)}")
    axes = figure.add_subplot(
        xscale="log",
        yscale="log",
        xlabel="natural frequency [Hz]",
        ylabel="largest response along an axis [g]",
    )
    for style, damping in zip(("solid", "dashed"), DAMPING, strict=True):
        response = spectrum(compliant, DELTA_V.compute, points, damping) / GRAVITY
        named = zip(points, filters, response.T, CURVES, strict=False)
        for place, low_pass, raw, colour in named:
            label = f"{printable(place.name, 40)}, damping {100.0 * damping:g} %"
            line: dict[str, Any] = {"color": colour, "linestyle": style}
            axes.plot(SPECTRUM, raw, **line, linewidth=1.1, label=label)
            if low_pass is not None:
                behind = spectrum(compliant, DELTA_V.compute, [place], damping, low_pass)
                label = f"{label}, behind {low_pass}"
                axes.plot(SPECTRUM, behind[:, 0] / GRAVITY, **line, linewidth=0.6, label=label)
    axes.margins(x=0.0)
    axes.grid(True, which="both")
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    figure.legend(loc="outside right upper", fontsize=7.0)
    return figure


def _landing_text(profile: ShockProfile) -> str:
    """The robot as it was asked for, and its contacts."""
    return f"{robot_name(profile.robot)} landing on {printable(contact_name(profile.scene), 60)}"


def _plot(axes: Axes, t: Array, panel: TimePanel, rigid: Array | None) -> None:
    """Draw the curves of the largest peaks, each with its name beside the panel.

    Equal ones are all seen then.

    Args: rigid, the same of rigid links, where some bend; they are thin.
    """
    peaks = np.abs(panel.curves).max(axis=1, initial=0.0)
    shown = min(CURVES_SHOWN, int(np.sum(peaks >= SMALL * peaks.max())))
    order = np.argsort(-peaks, kind="stable")[:shown]
    for k, i in enumerate(sorted(order.tolist())):
        colour, label = CURVES[k % len(CURVES)], printable(panel.names[i], 30)
        axes.plot(t, panel.curves[i], color=colour, linewidth=2.2 - 0.22 * k, label=label)
        if rigid is not None:
            axes.plot(t, rigid[i], color=colour, linewidth=0.7, alpha=0.8)
    left_out = len(panel.names) - len(order)
    axes.legend(
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        title=f"{left_out} smaller not drawn" if left_out else None,
        title_fontsize=6.5,
    )
    axes.set_ylabel(panel.heading)
    axes.grid(True)
    axes.margins(x=0.0)
