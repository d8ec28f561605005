"""A landing on contacts of finite stiffness over time: forces, accelerations and torques; and shock response spectra of points."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from shockpc.core.spatial import Array
from shockpc.impact.stiffness import DAMPING, SPECTRUM, CompliantLanding
from shockpc.landing.scene import GRAVITY
from shockpc.quantities.ground import ALONG
from shockpc.quantities.points import DELTA_V
from shockpc.quantities.profile import ShockProfile
from shockpc.show.figure.style import CURVES, INK, new_chart
from shockpc.show.wording import contact_name, robot_name
from shockpc.text.printed import printable

CURVES_SHOWN = 6
"""Most curves of a panel, those of the largest peaks."""

SAMPLES = 600
"""Times of a curve."""

DECADE = 12.0
"""Ratio of the limits of a logarithmic axis up to which the numbers between powers of ten are written."""


def draw_time(profile: ShockProfile) -> Figure:
    """Draw forces of the contacts, accelerations of points and torques along the axes of joints."""
    compliant = _compliant(profile)
    figure = new_chart(
        7.2,
        5.4,
        f"{_landing_text(profile)}, over time",
    )
    motion, places = compliant.motion, profile.places("contact")
    ends = sorted({0.0, motion.duration, *(event.time for event in motion.events)})
    t = np.unique(
        np.concatenate([np.linspace(0.0, motion.duration, SAMPLES), ends, np.nextafter(ends, np.inf)]).clip(0.0, ends[-1])
    )
    # At the end all contacts are open, and without restitution the force drops to zero in that instant.
    t = np.append(t, t[-1])
    force = motion.at(t).force
    if motion.separated:
        force[-1] = 0.0
    size = [np.linalg.norm(force[:, compliant.number == c], axis=1) for c in range(len(profile.landing.contacts))]
    normal = force[:, motion.elements.normal & (compliant.number < len(profile.landing.contacts))]
    panels: list[tuple[str, list[str], Array]] = [("force [N]", [place.name for place in places], np.array(size))]
    points = [place for place in profile.places("point") if place.body >= 0]
    for title, entry, where, scale in (
        ("acceleration [g]", DELTA_V, points, GRAVITY),
        ("torque [N m, N]", ALONG, profile.places("joint"), 1.0),
    ):
        values = compliant.history(entry.compute, where, t) / scale if where else np.zeros((len(t), 0, 1))
        values = np.linalg.norm(values, axis=2) if values.shape[2] > 1 else values[..., 0]
        if entry is ALONG:
            peaks = profile.value("peak_torque", "joint")
            values, where = values[:, peaks > 0.0], [place for place, peak in zip(where, peaks, strict=True) if peak > 0.0]
        if where:
            panels.append((title, [place.name for place in where], values.T))
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (title, names, curves) in zip(rows, panels, strict=True):
        _plot(axes, 1e3 * t, names, curves)
        axes.set_ylabel(title)
    for k in range(normal.shape[1]):
        rows[0].plot(1e3 * t, normal[:, k], color=CURVES[k % len(CURVES)], linewidth=0.8, linestyle=(0, (4, 2)))
    rows[0].axvline(1e3 * compliant.compressed, color=INK, linewidth=0.6, linestyle=":")
    rows[-1].set_xlabel("time after touchdown [ms]")
    rows[-1].set_xlim(0.0, 1e3 * motion.duration)
    words = "dashed: along the normal; dotted: end of compression; frozen geometry, double precision, not proven"
    figure.supxlabel(words, fontsize=7.0, x=0.02, ha="left")
    return figure


def draw_spectrum(profile: ShockProfile) -> Figure:
    """Draw the shock response spectrum of each point, without damping and with 5 %."""
    compliant, points = _compliant(profile), [place for place in profile.places("point") if place.body >= 0]
    figure = new_chart(7.2, 3.8, f"Shock response spectrum, {_landing_text(profile)}")
    axes = figure.add_subplot(
        xscale="log", yscale="log", xlabel="natural frequency [Hz]", ylabel="largest response along an axis [g]"
    )
    for line, damping in zip(("solid", "dashed"), DAMPING, strict=True):
        response = compliant.spectrum(DELTA_V.compute, points, damping) / GRAVITY
        for k, place in enumerate(points[: len(CURVES)]):
            label = f"{printable(place.name, 40)}, damping {100.0 * damping:g} %"
            axes.plot(SPECTRUM, response[:, k], color=CURVES[k], linestyle=line, linewidth=1.1, label=label)
    axes.margins(x=0.0)
    axes.grid(True, which="both")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    low, high = axes.get_ylim()
    axes.yaxis.set_minor_formatter("{x:g}" if high < DECADE * low else NullFormatter())
    figure.legend(loc="outside right upper", fontsize=7.0)
    return figure


def _landing_text(profile: ShockProfile) -> str:
    """The robot as it was asked for, and its contacts."""
    return f"{robot_name(profile.robot)} landing on {printable(contact_name(profile), 60)}"


def _compliant(profile: ShockProfile) -> CompliantLanding:
    """The landing on contacts of finite stiffness."""
    assert profile.stiffness is not None
    return profile.stiffness


def _plot(axes: Axes, t: Array, names: Sequence[str], curves: Array) -> None:
    """Draw the curves (n, T) of the largest peaks, each with its name beside the panel, so that equal ones are all seen."""
    order = np.argsort(-np.abs(curves).max(axis=1, initial=0.0), kind="stable")[:CURVES_SHOWN]
    for k, i in enumerate(sorted(order.tolist())):
        axes.plot(t, curves[i], color=CURVES[k % len(CURVES)], linewidth=2.2 - 0.22 * k, label=printable(names[i], 30))
    left = len(names) - len(order)
    axes.legend(
        loc="center left", bbox_to_anchor=(1.0, 0.5), title=f"{left} smaller not drawn" if left else None, title_fontsize=6.5
    )
    axes.grid(True)
    axes.margins(x=0.0)
