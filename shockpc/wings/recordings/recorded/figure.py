"""The landings of a table: how often each value occurs with the worst landings named, and measured
over predicted jumps.
"""

import math
import textwrap

import numpy as np
from matplotlib.figure import Figure

from shockpc.evaluation.table import Table
from shockpc.show.figure.style import CURVES, INK, MARKERS, histogram, new_chart
from shockpc.show.wording import robot_name
from shockpc.text.printed import count, printable
from shockpc.wings.recordings.logs.landings import RecordedLandings
from shockpc.wings.recordings.recorded.study import ALL, FEWEST, Agreement, Validation

MOST_PANELS, WORST, BINS = 8, 3, 60
"""Distributions of one figure, landings that are named beside each, and its most bins."""

FRAME_REACH = 1.4
"""Half the width of the frame of a comparison, in largest measured jumps; predictions beyond it are
arrows on its edge.
"""


def draw_recorded(study: RecordedLandings, results: Table) -> Figure:
    """Draw how often a value of each column occurs, and the worst landings beside it by name and
    value.
    """
    known = [
        (column, values[np.isfinite(values)])
        for column in results.main
        for values in [results.columns[column.name]]
    ]
    shown = [(column, values) for column, values in known if values.size][:MOST_PANELS]
    title = f"{robot_name(study.robot)}: {count(study.rows, 'landing')}"
    if not shown:
        return new_chart(5.0, 1.0, f"{title}, none of which could be computed")
    figure = new_chart(6.4, 0.9 + 1.15 * len(shown), title)
    for panel, (column, values) in zip(
        figure.subplots(len(shown), 1, squeeze=False).ravel(), shown, strict=True
    ):
        # Few landings have few bins, so that the shape is not that of chance.
        counts, edges = np.histogram(values, min(BINS, math.ceil(2.0 * values.size**0.5)))
        histogram(panel, counts, edges, float(np.median(values)))
        worst = results.worst(WORST, column)
        severity = [float(results.columns[column.name][i]) for i in worst]
        below = {"clip_on": False, "transform": panel.get_xaxis_transform()}
        panel.plot(severity, np.full(len(worst), -0.06), "^", color=INK, markersize=4.0, **below)
        names = [
            f"{value:.3g}  {printable(str(study.table.names[i]), 24)}"
            for i, value in zip(worst, severity, strict=True)
        ]
        panel.text(1.02, 1.0, "\n".join(["worst:", *names]), va="top", transform=panel.transAxes)
        panel.set(title=printable(f"{column.title} [{column.unit}]", 80))
        panel.tick_params(axis="x", pad=6.0)
    figure.supylabel("number of landings")
    panel.set_xlabel("dashed: median; triangles: the worst landings")
    return figure


def draw_validation(study: RecordedLandings, validation: Validation) -> Figure:
    """Draw measured over predicted jumps of the largest group: a column for each joint model, a row
    for each time.
    """
    largest = max(
        (each for each in validation.agreements if each.name != ALL),
        key=lambda agreement: agreement.measured.shape[1],
    )
    shown = [agreement for agreement in validation.agreements if agreement.name == largest.name]
    quantities = [
        each.name
        for each in study.table.measured
        if largest.name in (each.group, each.name) and each.time == largest.time
    ]
    models, times = (
        list(dict.fromkeys(key))
        for key in zip(*((each.model, each.time) for each in shown), strict=True)
    )
    title = (
        f"{robot_name(study.robot)}: {printable(largest.name, 40)} in "
        f"{count(study.rows, 'landing')}"
    )
    figure = new_chart(2.4 + 1.75 * len(models), 0.7 + 2.0 * len(times), title)
    panels = figure.subplots(len(times), len(models), squeeze=False, sharex=True, sharey=True)
    measured, predicted = (
        max(float(np.nan_to_num(np.abs(values)).max()) for values in kind)
        for kind in ([each.measured for each in shown], [each.predicted for each in shown])
    )
    reach = min(FRAME_REACH * measured, 1.05 * max(measured, predicted)) or 1.0
    for panel in panels.ravel():
        panel.set(xlim=(-reach, reach), ylim=(-reach, reach), box_aspect=1.0)
        panel.plot([-reach, reach], [-reach, reach], color=INK, linewidth=0.6)
        panel.grid(True)
    for each in shown:
        panel = panels[times.index(each.time), models.index(each.model)]
        for k, name in enumerate(quantities):
            x, y = each.predicted[:, k], each.measured[:, k]
            # The layout counts what is not clipped twice where panels are square, and the legend
            # would be over them.
            look = {
                "color": CURVES[k % len(CURVES)],
                "linestyle": "none",
                "clip_on": False,
                "in_layout": False,
            }
            inside = np.abs(x) <= reach
            marker = MARKERS[k // len(CURVES) % len(MARKERS)]
            panel.plot(
                x[inside],
                y[inside],
                marker=marker,
                markersize=2.5,
                label=printable(name, 30),
                **look,
            )
            for arrow, edge, beyond in (("<", -reach, x < -reach), (">", reach, x > reach)):
                panel.plot(
                    np.full(beyond.sum(), edge), y[beyond], marker=arrow, markersize=4.0, **look
                )
        outside = int(np.sum(np.abs(each.predicted) > reach))
        first = [*textwrap.wrap(printable(each.model, 60), 22)] if each.time == times[0] else []
        if outside:
            panel.text(
                0.98,
                0.02,
                f"arrows: {outside} of {each.predicted.size} beyond",
                size=6.0,
                ha="right",
                transform=panel.transAxes,
            )
        panel.set(title="\n".join([*first, _agreement(each)]))
    for time, panel in zip(times, panels[:, 0], strict=True):
        panel.set_ylabel(
            ("" if time is None else f"after {time:g} ms\n") + f"measured jump [{largest.unit}]"
        )
    for panel in panels[-1]:
        panel.set_xlabel(f"predicted jump [{largest.unit}]")
    handles, labels = panels[
        times.index(largest.time), models.index(largest.model)
    ].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    return figure


def _agreement(each: Agreement) -> str:
    """How well predictions agree, in words where there is no correlation."""
    r, error = each.statistics["r"][0], each.statistics["error"][0]
    if not np.isfinite(r):
        known = each.predicted[np.isfinite(each.predicted)]
        few = f"too few for r (n = {each.n})" if each.n < FEWEST else "r undetermined"
        return (
            "no jump predicted"
            if known.size and not known.any()
            else few
            if known.size
            else "not predicted"
        )
    return (
        f"r {r:.2f}"
        + (f", median error {error:.2f}" if np.isfinite(error) else "")
        + f" (n = {each.n})"
    )
