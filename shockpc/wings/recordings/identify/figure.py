"""Figure of identified unknowns: the error over each of them, and measured over predicted jumps.

The jumps are predicted before and after the identification.
"""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.show.figure.style import CURVES, INK, MARKERS, faded, new_chart, plain_numbers
from shockpc.show.wording import robot_name, varied_text
from shockpc.text.printed import count, printable
from shockpc.wings.recordings.identify.predictor import Predicted
from shockpc.wings.recordings.identify.study import Identification
from shockpc.wings.recordings.identify.uncertainty import IdentifiedValue

CLEAR_MINIMUM = 0.2
"""Smallest error, in errors before, up to which errors are drawn in logarithms."""

ACROSS, REACH, LARGE_MARKS = 3, 1.1, 200
"""Panels in a row, reach of the frame of jumps, and number of landings up to which marks are large.

The reach is half the width of the frame, in largest measured jumps.
"""

ERRORS_HEIGHT, JUMPS_HEIGHT = 1.9, 3.2
"""Heights of a row of panels of errors, and of the panels of jumps [inches]."""


class ErrorAxis(NamedTuple):
    """The axis of errors, which all panels share.

    Attributes:
        before: error with the values before.
        low: lower end.
        high: upper end.
        logarithmic: whether it is logarithmic.
    """

    before: float
    low: float
    high: float
    logarithmic: bool


def draw(study: Identification) -> Figure:
    """Draw both."""
    p = len(study.unknowns)
    across = min(max(p, 2), ACROSS)
    rows = -(-p // across)
    errors_height = ERRORS_HEIGHT * rows
    robot = robot_name(study.predictor.robot)
    figure = new_chart(
        1.2 + 2.5 * across,
        0.7 + errors_height + JUMPS_HEIGHT,
        f"{robot}: {count(int(study.used.sum()), 'landing')}",
    )
    above, below = figure.subfigures(
        2, 1, squeeze=False, height_ratios=[errors_height, JUMPS_HEIGHT]
    ).ravel()
    panels = above.subplots(rows, across, squeeze=False, sharey=True).ravel()
    _draw_errors(list(panels), study)
    if p == across:
        panels[p - 1].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    else:
        panels[0].legend()
    _draw_jumps(list(below.subplots(1, 2, sharex=True, sharey=True)), study)
    return figure


def _draw_errors(panels: list[Axes], study: Identification) -> None:
    """Draw the error over each unknown in a panel of its own."""
    scans = [study.scan(j) for j in range(len(study.unknowns))]
    axis = _error_axis(study.errors["before"], [errors for _, errors in scans])
    for panel, unknown, (values, errors) in zip(panels, study.unknowns, scans, strict=False):
        _draw_error(panel, unknown, values, errors, axis)
    for panel in panels[len(scans) :]:
        panel.set_axis_off()
    panels[0].set_ylabel("error (median) [-]")


def _error_axis(before: float, scans: list[Array]) -> ErrorAxis:
    """The axis of errors that has room for the errors of all unknowns."""
    least = min(float(errors.min()) for errors in scans)
    largest = [min(float(errors.max()), 2.0) for errors in scans]
    most = max(1.1 * before, *largest)
    if least < CLEAR_MINIMUM * before:
        return ErrorAxis(before, 0.7 * max(least, 1e-4 * most), most, True)
    return ErrorAxis(before, 0.0, most, False)


def _draw_error(
    panel: Axes, unknown: IdentifiedValue, values: Array, errors: Array, axis: ErrorAxis
) -> None:
    """Draw the errors over the values of an unknown, and its interval."""
    title = f"{unknown.value:.3g}"
    if np.isfinite(unknown.low):
        title += f" ({unknown.low:.3g} … {unknown.high:.3g})"
        panel.axvspan(
            unknown.low,
            unknown.high,
            color=faded(CURVES[0], 0.75),
            linewidth=0.0,
            label="95 % interval",
        )
    else:
        title += f", {unknown.state}"
    panel.plot(values, errors, color=CURVES[0], label="error with this value")
    error = np.interp(unknown.value, values, errors)
    panel.plot(unknown.value, error, "o", color=INK, markersize=3.5, label="value found")
    panel.axhline(axis.before, color=INK, linewidth=0.7, linestyle="--", label="error before")
    variation = unknown.variation
    subject = varied_text(variation.subject, variation.unit)
    panel.set(xlabel=f"{subject} [{variation.unit}]", title=title, ylim=(axis.low, axis.high))
    panel.grid(True)
    if variation.law == "log-uniform":
        panel.set_xscale("log")
        plain_numbers(panel.xaxis)
    if axis.logarithmic:
        panel.set_yscale("log")
        plain_numbers(panel.yaxis)


def _draw_jumps(panels: list[Axes], study: Identification) -> None:
    """Draw predicted against measured jumps of the largest group, before and after."""
    measured = study.predictor.measured
    groups = [column.group for column in measured]
    largest = max(dict.fromkeys(groups), key=groups.count)
    columns = [k for k, group in enumerate(groups) if group == largest]
    reach = REACH * float(np.nanmax(np.abs(study.after.measured[study.used][:, columns]))) or 1.0
    unit = measured[columns[0]].unit
    before = f"before: error {study.errors['before']:.2f}"
    after = f"after: error {study.errors['after']:.2f}, left out {study.errors['left out']:.2f}"
    for panel, title, predicted in (
        (panels[0], before, study.before),
        (panels[1], after, study.after),
    ):
        panel.plot([-reach, reach], [-reach, reach], color=INK, linewidth=0.6)
        _mark_jumps(panel, study, predicted, columns, reach)
        panel.set(xlim=(-reach, reach), ylim=(-reach, reach), box_aspect=1.0, title=title)
        panel.set_xlabel(f"predicted jump [{unit}]")
        panel.grid(True)
    panels[0].set_ylabel(f"measured jump [{unit}]")
    panels[1].legend(markerscale=2.0, loc="upper left", bbox_to_anchor=(1.02, 1.0))


def _mark_jumps(
    panel: Axes, study: Identification, predicted: Predicted, columns: list[int], reach: float
) -> None:
    """Mark the jumps of the landings that are used; predictions out of reach are on the edge."""
    size = 2.5 if len(study.used) < LARGE_MARKS else 1.5
    for k, column in enumerate(columns):
        x = np.clip(predicted.jumps[study.used, column], -reach, reach)
        panel.plot(
            x,
            predicted.measured[study.used, column],
            MARKERS[k // len(CURVES) % len(MARKERS)],
            label=printable(study.predictor.measured[column].name, 30),
            color=CURVES[k % len(CURVES)],
            markersize=size,
            clip_on=False,
        )
