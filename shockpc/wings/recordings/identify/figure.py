"""What measured landings say about unknowns: the error over each of them, and predicted against
measured jumps before and after.
"""

import numpy as np
from matplotlib.figure import Figure

from shockpc.show.figure.style import CURVES, INK, MARKERS, faded, new_chart, plain_numbers
from shockpc.show.wording import robot_name, varied_text
from shockpc.text.printed import count, printable
from shockpc.wings.recordings.identify.study import Identification

CLEAR_MINIMUM = 0.2
"""Smallest error, in errors before, up to which errors are drawn in logarithms."""

ACROSS, REACH, LARGE_MARKS = 3, 1.1, 200
"""Panels beside one another; half the width of the frame of jumps, in largest measured ones;
landings that have large marks.
"""


def draw(study: Identification) -> Figure:
    """Draw both."""
    groups = [column.group for column in study.predictor.measured]
    group = max(dict.fromkeys(groups), key=groups.count)
    p, across = len(study.unknowns), min(max(len(study.unknowns), 2), ACROSS)
    robot = robot_name(study.predictor.robot)
    rows = -(-p // across)
    figure = new_chart(
        1.2 + 2.5 * across,
        0.7 + 1.9 * rows + 3.2,
        f"{robot}: {count(int(study.used.sum()), 'landing')}",
    )
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=[1.9 * rows, 3.2]).ravel()
    panels = above.subplots(rows, across, squeeze=False, sharey=True).ravel()
    scans = [study.scan(j) for j in range(p)]
    least = min(float(errors.min()) for _, errors in scans)
    most = max(
        1.1 * study.errors["before"], *(min(float(errors.max()), 2.0) for _, errors in scans)
    )
    deep = least < CLEAR_MINIMUM * study.errors["before"]
    for panel, one, (values, errors) in zip(panels, study.unknowns, scans, strict=False):
        if np.isfinite(one.low):
            panel.axvspan(
                one.low,
                one.high,
                color=faded(CURVES[0], 0.75),
                linewidth=0.0,
                label="95 % interval",
            )
        panel.plot(values, errors, color=CURVES[0], label="error with this value")
        panel.plot(
            one.value,
            np.interp(one.value, values, errors),
            "o",
            color=INK,
            markersize=3.5,
            label="value found",
        )
        panel.axhline(
            study.errors["before"], color=INK, linewidth=0.7, linestyle="--", label="error before"
        )
        panel.set(
            xlabel=f"{varied_text(one.variation.subject, one.variation.unit)} [{one.variation.unit}]",
            title=f"{one.value:.3g}"
            + (f" ({one.low:.3g} … {one.high:.3g})" if np.isfinite(one.low) else f", {one.state}"),
            yscale="log" if deep else "linear",
            ylim=(0.7 * max(least, 1e-4 * most) if deep else 0.0, most),
            xscale="log" if one.variation.law == "log-uniform" else "linear",
        )
        panel.grid(True)
        for axis, logarithmic in (
            (panel.xaxis, one.variation.law == "log-uniform"),
            (panel.yaxis, deep),
        ):
            if logarithmic:
                plain_numbers(axis)
    for panel in panels[p:]:
        panel.set_axis_off()
    panels[0].set_ylabel("error (median) [-]")
    panels[p - 1].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0)) if p == across else panels[
        0
    ].legend()
    columns = [k for k, name in enumerate(groups) if name == group]
    pairs = below.subplots(1, 2, sharex=True, sharey=True)
    reach = REACH * float(np.nanmax(np.abs(study.after.measured[study.used][:, columns]))) or 1.0
    unit = study.predictor.measured[columns[0]].unit
    for panel, key, predicted in zip(
        pairs, ("before", "after"), (study.before, study.after), strict=True
    ):
        panel.plot([-reach, reach], [-reach, reach], color=INK, linewidth=0.6)
        for k, column in enumerate(columns):
            size = 2.5 if len(study.used) < LARGE_MARKS else 1.5
            marks = {"color": CURVES[k % len(CURVES)], "markersize": size, "clip_on": False}
            panel.plot(
                np.clip(predicted.jumps[study.used, column], -reach, reach),
                predicted.measured[study.used, column],
                MARKERS[k // len(CURVES) % len(MARKERS)],
                label=printable(study.predictor.measured[column].name, 30),
                **marks,
            )
        error = f"error {study.errors[key]:.2f}" + (
            f", left out {study.errors['left out']:.2f}" if key == "after" else ""
        )
        panel.set(
            xlim=(-reach, reach), ylim=(-reach, reach), box_aspect=1.0, title=f"{key}: {error}"
        )
        panel.set_xlabel(f"predicted jump [{unit}]")
        panel.grid(True)
    pairs[0].set_ylabel(f"measured jump [{unit}]")
    pairs[1].legend(markerscale=2.0, loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return figure
