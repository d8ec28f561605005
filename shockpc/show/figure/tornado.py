"""The largest effects on a number of a landing as a tornado chart: one bar for each parameter, changed by one step up and down."""

import numpy as np
from matplotlib.figure import Figure

from shockpc.printed import printable
from shockpc.show.figure.style import BANDS, INK, new_chart
from shockpc.show.header import contact_name
from shockpc.show.reports.sensitivity import effect_words, step_words
from shockpc.studies.sensitivity import Sensitivity

MOST = 16
"""Bars."""

HEIGHT = 0.24
"""Of one bar with the space around it [inches]."""


def draw_tornado(study: Sensitivity) -> Figure:
    """Draw the chart."""
    effects = study.ranked[:MOST]
    target = printable(study.target.title, 80)
    landing = f"{printable(study.profile.robot.name)} landing on {printable(contact_name(study.profile), 60)}"
    figure = new_chart(7.2, 1.45 + HEIGHT * len(effects), f"What changes the {target} of {landing}")
    axes, rows = figure.add_subplot(), range(len(effects))
    changes = np.array([effect.derivative * effect.step for effect in effects])
    largest = max(float(np.abs(changes).max()), 1e-9 * abs(study.value)) or 1.0
    # Nothing can have less than none of a mass or of an inertia.
    lower = [effect.kind not in ("mass", "armature") or effect.value >= effect.step for effect in effects]
    bars = axes.barh(rows, changes, left=study.value, height=0.72, color=BANDS[6], label="change as given (the number)")
    axes.barh(rows, np.where(lower, -changes, 0.0), left=study.value, height=0.72, color=BANDS[4], label="the opposite change")
    shares = [f"{100.0 * change / study.value:+.3g} %".replace("-", "−") for change in changes]
    axes.bar_label(bars, shares, padding=3.0, fontsize=6.5)
    names = [f"{effect_words(effect)}{f' of {effect.name}' if effect.name else ''}   {step_words(effect)}" for effect in effects]
    axes.set_yticks(rows, [printable(name, 70) for name in names])
    axes.invert_yaxis()
    axes.axvline(study.value, color=INK, linewidth=0.8)
    axes.set_xlim(study.value - 1.22 * largest, study.value + 1.22 * largest)
    axes.set_xlabel(f"{target} [{study.target.unit}]; now {study.value:.4g}; effects to first order")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)
    figure.legend(loc="outside lower right", ncols=2, fontsize=7.0)
    return figure
