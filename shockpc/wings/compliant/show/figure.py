"""A landing on contacts of finite stiffness over time, and shock response spectra of points.

It has forces, accelerations and torques.
"""

from collections.abc import Sequence
from dataclasses import replace
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.low_pass import LowPass
from shockpc.core.spatial import Array
from shockpc.landing.contact import contact_name
from shockpc.landing.places import Place
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import DELTA_V, low_passes
from shockpc.quantities.parts.peaks import ALONG
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.wording import robot_name
from shockpc.text.printed import count, printable
from shockpc.wings.compliant.of_profile import compliant_of
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding, compliant_landing
from shockpc.wings.compliant.over_time.spectra import DAMPING, SPECTRUM, spectrum

CURVES_SHOWN, SMALL = 6, 0.05
"""Most curves of a panel, and smallest peak of them as a share of the largest.

The curves are those of the largest peaks.
"""

MOST_EVENTS, SAME_TIME, STEP = 8, 0.01, 0.01
"""Most events that are written, their least distance in time, and least step of a force.

The distance is a share of the duration, the step, at an event along the ground, one of the largest
force.
"""

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

HAPPENS = {
    "unloads": "compression ends",
    "reloads": "compressed further",
    "reverses": "force reverses",
    "slips": "slips",
    "opens": "opens",
    "closes": "closes",
}
"""Events of a contact, in words."""

SAMPLES = 600
"""Times of a curve."""

ACCELERATION = "acceleration [g]"
"""Heading of a panel."""


def draw_time(profile: ShockProfile) -> Figure:
    """Draw forces of contacts, accelerations of points and torques along the axes of joints.

    Those of rigid links are drawn too.
    """
    compliant = _compliant(profile)
    figure = new_chart(7.2, 5.4, f"{_landing_text(profile)}, over time")
    t = _times(compliant)
    panels = _panels(profile, compliant, t)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]

    # The same landing with rigid links shows what bending changes.
    of_rigid: list[Array | None] = [None] * len(panels)
    if profile.scene.flex:
        landing = replace(profile.landing, scene=replace(profile.landing.scene, flex={}))
        of_rigid = [panel.curves for panel in _panels(profile, compliant_landing(landing), t)]

    points = _moving_points(profile)
    filters = low_passes(profile.landing, points)
    for axes, panel, rigid in zip(rows, panels, of_rigid, strict=True):
        _plot(axes, 1e3 * t, panel, rigid)
        if panel.heading == ACCELERATION:
            _plot_readings(axes, compliant, points, filters)
    _plot_normal_forces(rows[0], profile, compliant, t)
    rows[-1].set_xlabel("time after touchdown [ms]")
    end = _last_shown(compliant, points, filters)
    rows[-1].set_xlim(0.0, 1e3 * (1.0 + AFTER) * end)

    left_out = _write_events(list(rows), _events(profile, compliant))
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


class _Panel(NamedTuple):
    """Curves over time.

    Attributes:
        heading: of the ordinate, with the unit.
        names: of the curves.
        curves: (n, T); NaN after the end, of which the last time is the instant.
    """

    heading: str
    names: list[str]
    curves: Array


def _moving_points(profile: ShockProfile) -> list[Place]:
    """The points that are on a body."""
    return [place for place in profile.places("point") if place.body >= 0]


def _times(compliant: CompliantLanding) -> Array:
    """The times (T,) of the curves [s]: both sides of all events, and the end twice.

    At the end all contacts are open, and without restitution the force drops to zero in that
    instant; without springs in joints, all else with it.
    """
    motion = compliant.motion
    ends = sorted({0.0, motion.duration, *(event.time for event in motion.events)})
    even = np.linspace(0.0, motion.duration, SAMPLES)
    t = np.unique(np.concatenate([even, ends, np.nextafter(ends, np.inf)]).clip(0.0, ends[-1]))
    return np.append(t, t[-1])


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


def _forces(compliant: CompliantLanding, t: Array) -> Array:
    """Forces (T, r) of the elements at times (T,), of which the last is after the end."""
    force = compliant.motion.at(t).force
    force[-1] *= not compliant.motion.separated
    return force


def _panels(profile: ShockProfile, compliant: CompliantLanding, t: Array) -> list[_Panel]:
    """The panels of forces, accelerations and torques at times (T,)."""
    panels = [_force_panel(profile, compliant, t)]
    points = _moving_points(profile)
    if points:
        values = _history(compliant, DELTA_V, points, t)
        sizes = np.linalg.norm(values, axis=2) / GRAVITY
        panels.append(_Panel(ACCELERATION, [place.name for place in points], sizes.T))
    acting = profile.value("peak_torque", "joint") > 0.0
    joints = [place for place, acts in zip(profile.places("joint"), acting, strict=True) if acts]
    if joints:
        values = _history(compliant, ALONG, profile.places("joint"), t)
        torques = values[:, acting, 0]
        panels.append(_Panel("torque [N m, N]", [place.name for place in joints], torques.T))
    for panel in panels:
        panel.curves[:, t > compliant.motion.duration] = np.nan
    return panels


def _force_panel(profile: ShockProfile, compliant: CompliantLanding, t: Array) -> _Panel:
    """The forces of the contacts."""
    force, contacts = _forces(compliant, t), profile.landing.contacts
    sizes = []
    for c in range(len(contacts)):
        of_contact = force[:, compliant.number == c]
        sizes.append(np.linalg.norm(of_contact, axis=1))
    unit = "N, N m" if any(block.kind == "stop" for block in contacts) else "N"
    names = [place.name for place in profile.places("contact")]
    return _Panel(f"force [{unit}]", names, np.array(sizes))


def _history(
    compliant: CompliantLanding, quantity: Quantity, places: Sequence[Place], t: Array
) -> Array:
    """A quantity (T, n, k) at times (T,), of which the last is after the end."""
    values = compliant.history(quantity.compute, places, t)
    at_rest = compliant.motion.separated and bool((compliant.number >= 0).all())
    values[-1] *= not at_rest
    return values


def _plot_normal_forces(
    axes: Axes, profile: ShockProfile, compliant: CompliantLanding, t: Array
) -> None:
    """Draw the parts of the forces along the normals, dashed."""
    of_contacts = compliant.number < len(profile.landing.contacts)
    normal = _forces(compliant, t)[:, compliant.motion.elements.normal & of_contacts]
    for k, force in enumerate(normal.T):
        colour = CURVES[k % len(CURVES)]
        axes.plot(1e3 * t, force, color=colour, linewidth=0.8, linestyle=(0, (4, 2)))


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


def _events(profile: ShockProfile, compliant: CompliantLanding) -> list[tuple[float, str]]:
    """Events of contacts, (time [s], text): at their normals, and along the ground.

    Along the ground an event is a visible step of a force.

    What happens at almost the same time is one text.
    """
    motion, landing = compliant.motion, profile.landing
    # The numbers of contacts come first, then those of further end stops.
    stops = [contact.frame for contact in landing.acting][len(landing.contact_places) :]
    names = [*(place.name for place in profile.places("contact")), *stops]
    several = len(set(compliant.number[compliant.number >= 0].tolist())) > 1
    times = np.array([event.time for event in motion.events])
    # Elements along the ground change often; only steps that the figure shows are named.
    least_step = STEP * float(np.abs(motion.at(times).force).max(initial=0.0))
    events: list[tuple[float, list[str]]] = []
    for event in motion.events:
        contact = int(compliant.number[event.element])
        normal = bool(motion.elements.normal[event.element])
        # Just before the event, and just after it.
        around = np.array([event.time, np.nextafter(event.time, np.inf)])
        before, after = motion.at(around).force[:, event.element]
        visible = normal or abs(after - before) > least_step
        if contact < 0 or not visible:
            continue
        text = HAPPENS[event.kind]
        if not normal and event.kind != "slips":
            text += " along the ground"
        if several:
            text = f"{printable(names[contact], 20)} {text}"
        is_apart = True
        if events:
            is_apart = event.time - events[-1][0] > SAME_TIME * motion.duration
        if is_apart:
            events.append((event.time, []))
        if text not in events[-1][1]:
            events[-1][1].append(text)
    return [(time, ", ".join(texts)) for time, texts in events]


def _write_events(rows: Sequence[Axes], events: Sequence[tuple[float, str]]) -> int:
    """Mark events in all panels and write them over the first one; returns how many are left.

    None is written over another.
    """
    low, high = rows[0].get_xlim()
    width = 72.0 * ROOM
    lines: list[list[tuple[float, float]]] = []
    shown = events[:MOST_EVENTS]
    for time, text in shown:
        for axes in rows:
            axes.axvline(1e3 * time, color=INK, linewidth=0.6, linestyle=":")
        at = width * (1e3 * time - low) / (high - low)
        length = LETTER * len(text)
        left = min(max(at - length / 2.0, 0.0), width - length)
        line = _free_line(lines, left, left + length)
        side, x = "center", 1e3 * time
        if left == 0.0:
            side, x = "left", low
        elif left == width - length:
            side, x = "right", high
        rows[0].annotate(
            text,
            (x, 1.0),
            (0.0, 3.0 + LINE * line),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha=side,
            va="bottom",
            fontsize=7.0,
        )
    return len(events) - len(shown)


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
    compliant, points = _compliant(profile), _moving_points(profile)
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
        shown = zip(points, filters, response.T, CURVES, strict=False)
        for place, low_pass, raw, colour in shown:
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


def _compliant(profile: ShockProfile) -> CompliantLanding:
    """The landing over time."""
    compliant = compliant_of(profile)
    assert compliant is not None
    return compliant


def _plot(axes: Axes, t: Array, panel: _Panel, rigid: Array | None) -> None:
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
