"""The landings of a table: measured over predicted jumps, or how often each value occurs."""

import numpy as np
from matplotlib.figure import Figure

from shockpc.printed import printable
from shockpc.show.figure.style import BANDS, CURVES, INK, band, new_chart
from shockpc.studies.landings.comparison import Agreement, Comparison
from shockpc.studies.landings.study import Found

ACROSS, MOST = 4, 8
"""Joint models, and distributions, of one figure."""

WORST = 3
"""Landings that are named beside a distribution."""


def draw_landings(found: Found, comparison: Comparison | None) -> Figure:
    """Draw measured over predicted jumps of the largest group of quantities, or without a comparison the distributions."""
    if comparison is None:
        return _distributions(found)
    largest = max(comparison.agreements, key=lambda one: one.measured.shape[1]).name
    return _scatter(found, [one for one in comparison.agreements if one.name == largest])


def _scatter(found: Found, shown: list[Agreement]) -> Figure:
    """A panel for each joint model and time, one colour for each quantity."""
    models, times = list(dict.fromkeys(one.model for one in shown))[:ACROSS], list(dict.fromkeys(one.time for one in shown))
    title = f"{printable(found.made.robot.name)}: {shown[0].name}, measured against predicted jumps in {found.made.rows} landings"
    figure = new_chart(0.6 + 2.3 * len(models), 0.7 + 2.2 * len(times), title)
    panels = figure.subplots(len(times), len(models), squeeze=False, sharex=True, sharey=True)
    reach = 1.05 * max(float(np.nanmax(np.abs([one.measured, one.predicted]))) for one in shown)
    for one in shown:
        if one.model not in models:
            continue
        panel = panels[times.index(one.time), models.index(one.model)]
        panel.plot([-reach, reach], [-reach, reach], color=INK, linewidth=0.6)
        for k in range(one.measured.shape[1]):
            panel.plot(one.predicted[:, k], one.measured[:, k], ".", markersize=3.0, color=CURVES[k % len(CURVES)])
        r, error = one.statistics["r"][0], one.statistics["error"][0]
        when = "" if one.time is None else f", {one.time:g} ms"
        panel.set(
            title=f"{printable(one.model, 30)}{when}\nr {r:.2f}, median error {error:.2f}",
            xlim=(-reach, reach),
            ylim=(-reach, reach),
        )
        panel.grid(True)
    figure.supxlabel(f"predicted jump [{shown[0].unit}]")
    figure.supylabel(f"measured jump [{shown[0].unit}]")
    return figure


def _distributions(found: Found) -> Figure:
    """How often a value of each column occurs, with its worst landings named."""
    known = [(column, found.columns[column.name]) for column in found.made.computed]
    shown = [(column, finite) for column, values in known if (finite := values[np.isfinite(values)]).size][:MOST]
    title = f"{printable(found.made.robot.name)}: {found.made.rows} landings"
    if not shown:
        return new_chart(5.0, 1.0, f"{title}, none of which could be computed")
    figure = new_chart(6.4, 1.0 + 1.15 * len(shown), title)
    for panel, (column, values) in zip(figure.subplots(len(shown), 1, squeeze=False).ravel(), shown, strict=True):
        counts, edges = np.histogram(values, 60)
        middle = 0.5 * (edges[1:] + edges[:-1])
        colours = [BANDS[band(max(x, 0.0))] if column.shock else CURVES[0] for x in middle]
        panel.bar(edges[:-1], counts, np.diff(edges), align="edge", color=colours)
        panel.stairs(counts, edges, color=INK, linewidth=0.6)
        panel.axvline(float(np.median(values)), color=INK, linewidth=0.8, linestyle="--")
        worst = [str(found.made.table.names[i]) for i in found.ranked(column)[:WORST]]
        panel.set(title=f"{printable(column.heading, 60)}: worst in {printable(', '.join(worst), 60)}")
    figure.supylabel("number of landings")
    panel.set_xlabel("dashed: median")
    return figure
