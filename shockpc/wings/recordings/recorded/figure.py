"""The landings of a table: a histogram of each column, and measured over predicted jumps.

The worst landings are named.
"""

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column
from shockpc.evaluation.table import Table
from shockpc.show.figure.style import CURVES, INK, MARKERS, histogram, new_chart
from shockpc.show.wording import robot_name
from shockpc.text.printed import count, printable
from shockpc.wings.recordings.recorded.study import ALL, FEWEST, Agreement, Validation
from shockpc.wings.recordings.tables.landings import RecordedLandings

MOST_PANELS, WORST, BINS = 8, 3, 60
"""Distributions of one figure, landings that are named beside each, and its most bins."""

FRAME_REACH = 1.4
"""Half the width of the frame of a comparison, in largest measured jumps.

Predictions beyond it are arrows on its edge.
"""


def draw_recorded(study: RecordedLandings, results: Table) -> Figure:
    """Draw how often a value of each column occurs, with the worst landings beside it.

    These have their names and values.
    """
    title = f"{robot_name(study.robot)}: {count(study.rows, 'landing')}"
    shown = [column for column in results.main if _known(results, column).size][:MOST_PANELS]
    if not shown:
        return new_chart(5.0, 1.0, f"{title}, none of which could be computed")
    figure = new_chart(6.4, 0.9 + 1.15 * len(shown), title)
    panels = figure.subplots(len(shown), 1, squeeze=False).ravel()
    for panel, column in zip(panels, shown, strict=True):
        _draw_distribution(panel, study, results, column)
    figure.supylabel("number of landings")
    panels[-1].set_xlabel("dashed: median; triangles: the worst landings")
    return figure


def _known(results: Table, column: Column) -> Array:
    """The values of a column that are known."""
    values = results.columns[column.name]
    return np.asarray(values[np.isfinite(values)])


def _draw_distribution(
    panel: Axes, study: RecordedLandings, results: Table, column: Column
) -> None:
    """Draw the distribution of a column, and its worst landings."""
    values = _known(results, column)
    # Few landings have few bins, so that the shape is not that of chance.
    bins = min(BINS, math.ceil(2.0 * values.size**0.5))
    counts, edges = np.histogram(values, bins)
    histogram(panel, counts, edges, float(np.median(values)))
    lines = ["worst:"]
    worst = results.worst(WORST, column)
    severity = [float(results.columns[column.name][i]) for i in worst]
    for i, value in zip(worst, severity, strict=True):
        lines.append(f"{value:.3g}  {printable(str(study.table.names[i]), 24)}")
    below: dict[str, Any] = {"clip_on": False, "transform": panel.get_xaxis_transform()}
    panel.plot(severity, np.full(len(worst), -0.06), "^", color=INK, markersize=4.0, **below)
    panel.text(1.02, 1.0, "\n".join(lines), va="top", transform=panel.transAxes)
    panel.set(title=printable(f"{column.title} [{column.unit}]", 80))
    panel.tick_params(axis="x", pad=6.0)


def draw_validation(study: RecordedLandings, validation: Validation) -> Figure:
    """Draw measured over predicted jumps of the largest group.

    Joint models are columns, times are rows.
    """
    groups = [agreement for agreement in validation.agreements if agreement.name != ALL]
    # The figure has room for one group.
    largest = max(groups, key=lambda agreement: agreement.measured.shape[1])
    shown = [agreement for agreement in validation.agreements if agreement.name == largest.name]
    models = list(dict.fromkeys(agreement.model for agreement in shown))
    times = list(dict.fromkeys(agreement.time for agreement in shown))
    subject = printable(largest.name, 40)
    title = f"{robot_name(study.robot)}: {subject} in {count(study.rows, 'landing')}"
    figure = new_chart(2.4 + 1.75 * len(models), 0.7 + 2.0 * len(times), title)
    panels = figure.subplots(len(times), len(models), squeeze=False, sharex=True, sharey=True)
    # One frame for all panels, so that they compare; what is predicted exactly is on its diagonal.
    reach = _reach(shown)
    for panel in panels.ravel():
        panel.set(xlim=(-reach, reach), ylim=(-reach, reach), box_aspect=1.0)
        panel.plot([-reach, reach], [-reach, reach], color=INK, linewidth=0.6)
        panel.grid(True)
    quantities = _quantities(study, largest)
    # The joint model stands above its column, the time beside its row.
    for agreement in shown:
        panel = panels[times.index(agreement.time), models.index(agreement.model)]
        lines = [_agreement(agreement)]
        if agreement.time == times[0]:
            lines = [*textwrap.wrap(printable(agreement.model, 60), 22), *lines]
        _draw_jumps(panel, agreement, quantities, reach)
        panel.set(title="\n".join(lines))
    for time, panel in zip(times, panels[:, 0], strict=True):
        label = f"measured jump [{largest.unit}]"
        if time is not None:
            label = f"after {time:g} ms\n{label}"
        panel.set_ylabel(label)
    for panel in panels[-1]:
        panel.set_xlabel(f"predicted jump [{largest.unit}]")
    # Panels share their marks, so that one legend, of the panel with most of them, is enough.
    fullest = panels[times.index(largest.time), models.index(largest.model)]
    figure.legend(*fullest.get_legend_handles_labels(), loc="outside right upper")
    return figure


def _quantities(study: RecordedLandings, agreement: Agreement) -> list[str]:
    """Names of the measured quantities that are in a group."""
    names = []
    for column in study.table.measured:
        if column.time == agreement.time and agreement.name in (column.group, column.name):
            names.append(column.name)
    return names


def _reach(shown: list[Agreement]) -> float:
    """Half the width of the frame of a comparison."""
    measured = max(_largest(agreement.measured) for agreement in shown)
    predicted = max(_largest(agreement.predicted) for agreement in shown)
    return min(FRAME_REACH * measured, 1.05 * max(measured, predicted)) or 1.0


def _largest(values: Array) -> float:
    """The largest absolute value of those that are known; 0 without one."""
    return float(np.nan_to_num(np.abs(values)).max())


def _draw_jumps(panel: Axes, agreement: Agreement, quantities: list[str], reach: float) -> None:
    """Draw measured over predicted jumps; those out of reach are arrows on the edge."""
    for k, name in enumerate(quantities):
        x = agreement.predicted[:, k]
        y = agreement.measured[:, k]
        # The layout counts what is not clipped twice where panels are square, and the legend
        # would be over them.
        style: dict[str, Any] = {
            "color": CURVES[k % len(CURVES)],
            "linestyle": "none",
            "clip_on": False,
            "in_layout": False,
        }
        inside = np.abs(x) <= reach
        panel.plot(
            x[inside],
            y[inside],
            marker=MARKERS[k // len(CURVES) % len(MARKERS)],
            markersize=2.5,
            label=printable(name, 30),
            **style,
        )
        for arrow, edge, beyond in (("<", -reach, x < -reach), (">", reach, x > reach)):
            at_edge = np.full(beyond.sum(), edge)
            panel.plot(at_edge, y[beyond], marker=arrow, markersize=4.0, **style)
    outside = int(np.sum(np.abs(agreement.predicted) > reach))
    if outside:
        panel.text(
            0.98,
            0.02,
            f"arrows: {outside} of {agreement.predicted.size} beyond",
            size=6.0,
            ha="right",
            transform=panel.transAxes,
        )


def _agreement(agreement: Agreement) -> str:
    """Text of how well predictions agree, in words where there is no correlation."""
    r = agreement.statistics["r"][0]
    error = agreement.statistics["error"][0]
    if np.isfinite(r):
        spread = f", median error {error:.2f}" if np.isfinite(error) else ""
        return f"r {r:.2f}{spread} (n = {agreement.n})"
    known = agreement.predicted[np.isfinite(agreement.predicted)]
    if not known.size:
        return "not predicted"
    if not known.any():
        return "no jump predicted"
    if agreement.n < FEWEST:
        return f"too few for r (n = {agreement.n})"
    return "r undetermined"
