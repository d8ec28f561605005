"""A landing on contacts of finite stiffness over time: forces, accelerations and torques; and shock
response spectra of points.
"""

from collections.abc import Sequence
from dataclasses import replace
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.low_pass import LowPass
from shockpc.core.spatial import Array
from shockpc.landing.places import Place
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.of_points import DELTA_V, low_passes
from shockpc.quantities.peaks import ALONG
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.style import CURVES, INK, new_chart, plain_numbers
from shockpc.show.wording import contact_name, robot_name
from shockpc.text.printed import count, printable
from shockpc.wings.compliant.course import CompliantLanding, compliant_landing
from shockpc.wings.compliant.of_profile import compliant_of
from shockpc.wings.compliant.spectra import DAMPING, SPECTRUM, spectrum

CURVES_SHOWN, SMALL = 6, 0.05
"""Most curves of a panel, those of the largest peaks, and smallest peak of them as a share of the
largest.
"""

MOST_EVENTS, SAME_TIME, STEP = 8, 0.01, 0.01
"""Most events that are written, how far apart in time they are at least, as a share of the
duration, and minimum step of a force at
an event along the ground, as a share of the largest force."""

AFTER, BEYOND = 0.03, 1.5
"""Time that is shown after the end, as a share of the duration; and until when the peaks of
readings are shown, in their times.
"""

ROOM = 5.6
"""Width of the panels, about [inches]."""

LETTER, LINE, LETTERS = 4.3, 9.5, 120
"""Width of a letter and height of a line over the first panel [pt]; letters of a line below the
panels.
"""

HAPPENS = {
    "unloads": "compression ends",
    "reloads": "compressed further",
    "reverses": "force reverses",
    "slips": "slips",
    "opens": "opens",
    "closes": "closes",
}
"""What happens to a contact, in words."""

SAMPLES = 600
"""Times of a curve."""


def draw_time(profile: ShockProfile) -> Figure:
    """Draw forces of the contacts, accelerations of points and torques along the axes of joints,
    also of rigid links.
    """
    compliant = _compliant(profile)
    figure = new_chart(7.2, 5.4, f"{_landing_text(profile)}, over time")
    motion = compliant.motion
    ends = sorted({0.0, motion.duration, *(event.time for event in motion.events)})
    t = np.unique(
        np.concatenate(
            [np.linspace(0.0, motion.duration, SAMPLES), ends, np.nextafter(ends, np.inf)]
        ).clip(0.0, ends[-1])
    )
    # At the end all contacts are open, and without restitution the force drops to zero in that
    # instant; without springs in joints, all else with it.
    t = np.append(t, t[-1])
    panels = _panels(profile, compliant, t)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    rigid: list[Array | None] = [None] * len(panels)
    if profile.scene.flex:
        landing = replace(profile.landing, scene=replace(profile.landing.scene, flex={}))
        rigid = [curves for *_, curves in _panels(profile, compliant_landing(landing), t)]
    points = [place for place in profile.places("point") if place.body >= 0]
    filters = low_passes(profile.landing, points)
    for axes, (title, names, curves), of_rigid in zip(rows, panels, rigid, strict=True):
        _plot(axes, 1e3 * t, names, curves, of_rigid)
        axes.set_ylabel(title)
        if title.startswith("acceleration"):
            _plot_readings(axes, compliant, points, filters)
    normal = _forces(compliant, t)[
        :, motion.elements.normal & (compliant.number < len(profile.landing.contacts))
    ]
    for k in range(normal.shape[1]):
        rows[0].plot(
            1e3 * t,
            normal[:, k],
            color=CURVES[k % len(CURVES)],
            linewidth=0.8,
            linestyle=(0, (4, 2)),
        )
    rows[-1].set_xlabel("time after touchdown [ms]")
    # What accelerometers read goes on after the end, and may have its peak there.
    read = [
        compliant.peaks(DELTA_V.compute, [place], one)[1][0]
        for place, one in zip(points, filters, strict=True)
        if one
    ]
    end = max([motion.duration, *(BEYOND * float(time) for time in read)])
    rows[-1].set_xlim(0.0, 1e3 * (1.0 + AFTER) * end)
    left = _write_events(list(rows), _events(profile, compliant))
    words = "dashed: along the normal; dotted: what happens to a contact"
    words += "; dash-dotted: what an accelerometer reads" * any(
        filters
    ) + "; thin: rigid links" * bool(profile.scene.flex)
    words += (
        f"; {count(left, 'more event')} not written" * bool(left)
        + "; frozen geometry, double precision"
    )
    figure.supxlabel(fill(words, LETTERS), fontsize=7.0, x=0.02, ha="left")
    return figure


def _forces(compliant: CompliantLanding, t: Array) -> Array:
    """Forces (T, r) of the elements at times (T,), of which the last is after the end."""
    force = compliant.motion.at(t).force
    force[-1] *= not compliant.motion.separated
    return force


def _panels(
    profile: ShockProfile, compliant: CompliantLanding, t: Array
) -> list[tuple[str, list[str], Array]]:
    """Heading, names and curves (n, T) of each panel, at times (T,); NaN after the end, of which
    the last time is the instant.
    """
    force, contacts = _forces(compliant, t), profile.landing.contacts
    at_rest = compliant.motion.separated and bool((compliant.number >= 0).all())
    size = [np.linalg.norm(force[:, compliant.number == c], axis=1) for c in range(len(contacts))]
    unit = "N, N m" if any(block.kind == "stop" for block in contacts) else "N"
    panels = [
        (f"force [{unit}]", [place.name for place in profile.places("contact")], np.array(size))
    ]
    points = [place for place in profile.places("point") if place.body >= 0]
    for title, entry, where, scale in (
        ("acceleration [g]", DELTA_V, points, GRAVITY),
        ("torque [N m, N]", ALONG, profile.places("joint"), 1.0),
    ):
        values = (
            compliant.history(entry.compute, where, t) / scale
            if where
            else np.zeros((len(t), 0, 1))
        )
        values[-1] *= not at_rest
        values = np.linalg.norm(values, axis=2) if values.shape[2] > 1 else values[..., 0]
        if entry is ALONG:
            peaks = profile.value("peak_torque", "joint")
            values, where = (
                values[:, peaks > 0.0],
                [place for place, peak in zip(where, peaks, strict=True) if peak > 0.0],
            )
        if where:
            panels.append((title, [place.name for place in where], values.T))
    for _, _, curves in panels:
        curves[:, t > compliant.motion.duration] = np.nan
    return panels


def _plot_readings(
    axes: Axes,
    compliant: CompliantLanding,
    points: Sequence[Place],
    filters: Sequence[LowPass | None],
) -> None:
    """Draw what accelerometers at points read behind their filters, dash-dotted, in the colours of
    the raw curves.
    """
    colors = {line.get_label(): line.get_color() for line in axes.get_lines()}
    for place, low_pass in zip(points, filters, strict=True):
        if low_pass is not None and (color := colors.get(printable(place.name, 30))):
            t = np.linspace(0.0, compliant.filtered(low_pass).duration, SAMPLES)
            read = (
                np.linalg.norm(
                    compliant.history(DELTA_V.compute, [place], t, low_pass)[:, 0], axis=1
                )
                / GRAVITY
            )
            axes.plot(1e3 * t, read, color=color, linewidth=1.2, linestyle="dashdot")


def _events(profile: ShockProfile, compliant: CompliantLanding) -> list[tuple[float, str]]:
    """What happens to contacts, (time [s], text): at their normals, and along the ground where it
    is a visible step of a force.

    What happens at almost the same time is one text.
    """
    motion, stops = (
        compliant.motion,
        [contact.frame for contact in profile.landing.acting][
            len(profile.landing.contact_places) :
        ],
    )
    names = [*(place.name for place in profile.places("contact")), *stops]
    events: list[tuple[float, list[str]]] = []
    least = STEP * float(
        np.abs(motion.at(np.array([event.time for event in motion.events])).force).max(initial=0.0)
    )
    for event in motion.events:
        contact, normal = (
            int(compliant.number[event.element]),
            bool(motion.elements.normal[event.element]),
        )
        before, after = motion.at(np.array([event.time, np.nextafter(event.time, np.inf)])).force[
            :, event.element
        ]
        if contact < 0 or not (normal or abs(after - before) > least):
            continue
        text = HAPPENS[event.kind] + " along the ground" * (not normal and event.kind != "slips")
        text = (
            f"{printable(names[contact], 20)} {text}"
            if len(set(compliant.number[compliant.number >= 0].tolist())) > 1
            else text
        )
        if not events or event.time - events[-1][0] > SAME_TIME * motion.duration:
            events.append((event.time, []))
        if text not in events[-1][1]:
            events[-1][1].append(text)
    return [(time, ", ".join(texts)) for time, texts in events]


def _write_events(rows: Sequence[Axes], events: Sequence[tuple[float, str]]) -> int:
    """Mark events in all panels and write them over the first one, none over another; how many are
    left.
    """
    low, high = rows[0].get_xlim()
    width = 72.0 * ROOM
    lines: list[list[tuple[float, float]]] = []
    shown = events[:MOST_EVENTS]
    for time, text in shown:
        for axes in rows:
            axes.axvline(1e3 * time, color=INK, linewidth=0.6, linestyle=":")
        at, long = width * (1e3 * time - low) / (high - low), LETTER * len(text)
        left = min(max(at - long / 2.0, 0.0), width - long)
        line = next(
            (
                k
                for k, taken in enumerate(lines)
                if all(left > b + LETTER or left + long < a - LETTER for a, b in taken)
            ),
            len(lines),
        )
        lines += [[]] * (line == len(lines))
        lines[line] = [*lines[line], (left, left + long)]
        side = "left" if left == 0.0 else "right" if left == width - long else "center"
        x = {"left": low, "right": high, "center": 1e3 * time}[side]
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


def draw_spectrum(profile: ShockProfile) -> Figure:
    """Draw the shock response spectrum of each point, without damping and with 5 %."""
    compliant, points = (
        _compliant(profile),
        [place for place in profile.places("point") if place.body >= 0],
    )
    figure = new_chart(7.2, 3.8, f"Shock response spectrum, {_landing_text(profile)}")
    axes = figure.add_subplot(
        xscale="log",
        yscale="log",
        xlabel="natural frequency [Hz]",
        ylabel="largest response along an axis [g]",
    )
    for line, damping in zip(("solid", "dashed"), DAMPING, strict=True):
        response = spectrum(compliant, DELTA_V.compute, points, damping) / GRAVITY
        for k, place in enumerate(points[: len(CURVES)]):
            label = f"{printable(place.name, 40)}, damping {100.0 * damping:g} %"
            axes.plot(
                SPECTRUM,
                response[:, k],
                color=CURVES[k],
                linestyle=line,
                linewidth=1.1,
                label=label,
            )
            if (low_pass := low_passes(profile.landing, [place])[0]) is not None:
                read = (
                    spectrum(compliant, DELTA_V.compute, [place], damping, low_pass)[:, 0] / GRAVITY
                )
                axes.plot(
                    SPECTRUM,
                    read,
                    color=CURVES[k],
                    linestyle=line,
                    linewidth=0.6,
                    label=f"{label}, behind {low_pass}",
                )
    axes.margins(x=0.0)
    axes.grid(True, which="both")
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    figure.legend(loc="outside right upper", fontsize=7.0)
    return figure


def _landing_text(profile: ShockProfile) -> str:
    """The robot as it was asked for, and its contacts."""
    return f"{robot_name(profile.robot)} landing on {printable(contact_name(profile), 60)}"


def _compliant(profile: ShockProfile) -> CompliantLanding:
    """The landing over time."""
    compliant = compliant_of(profile)
    assert compliant is not None
    return compliant


def _plot(axes: Axes, t: Array, names: Sequence[str], curves: Array, rigid: Array | None) -> None:
    """Draw the curves (n, T) of the largest peaks, each with its name beside the panel, so that
    equal ones are all seen.

    Args: rigid, the same of rigid links, where some bend; they are thin.
    """
    peaks = np.abs(curves).max(axis=1, initial=0.0)
    order = np.argsort(-peaks, kind="stable")[
        : min(CURVES_SHOWN, np.sum(peaks >= SMALL * peaks.max()))
    ]
    for k, i in enumerate(sorted(order.tolist())):
        axes.plot(
            t,
            curves[i],
            color=CURVES[k % len(CURVES)],
            linewidth=2.2 - 0.22 * k,
            label=printable(names[i], 30),
        )
        if rigid is not None:
            axes.plot(t, rigid[i], color=CURVES[k % len(CURVES)], linewidth=0.7, alpha=0.8)
    left = len(names) - len(order)
    axes.legend(
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        title=f"{left} smaller not drawn" if left else None,
        title_fontsize=6.5,
    )
    axes.grid(True)
    axes.margins(x=0.0)
