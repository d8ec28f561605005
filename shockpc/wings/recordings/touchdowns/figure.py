"""The touchdowns of a log: heights of the feet over time, and some touchdowns enlarged.

These have the windows of the velocities.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.show.figure.style import CURVES, INK, faded, new_chart
from shockpc.show.wording import robot_name
from shockpc.text.printed import count, printable
from shockpc.wings.recordings.touchdowns.touchdowns import Touchdown, Touchdowns

PANELS, COLUMNS = 6, 3
"""Most touchdowns that are drawn by themselves, and how many of them beside each other."""

BEFORE, BEYOND = 30.0, 6.0
"""Time that is drawn before a touchdown, and after the last window [ms]."""

POINTS = 4000
"""Samples of a curve of the whole log, about."""


def draw_touchdowns(study: Touchdowns) -> Figure:
    """Draw the heights, or flags, over time with all touchdowns, and some touchdowns under it.

    These show what was taken before and after.
    """
    shown = _spread(study.landings)
    columns = max(1, min(COLUMNS, len(shown)))
    rows = -(-len(shown) // columns)
    title = f"{robot_name(study.robot)}: {count(len(study.landings), 'touchdown')} in a log"
    figure = new_chart(7.2, 2.4 + 1.9 * rows, title)
    grid = figure.add_gridspec(1 + rows, columns, height_ratios=[1.25, *[1.0] * rows])
    overview = figure.add_subplot(grid[0, :])
    _draw_overview(overview, study)
    figure.legend(*overview.get_legend_handles_labels(), loc="outside right upper")
    for k, landing in enumerate(shown):
        row, column = divmod(k, columns)
        axes = figure.add_subplot(grid[1 + row, column])
        _draw_detail(axes, study, landing)
        if column == 0:
            axes.set_ylabel(_label(study))
    if shown:
        figure.supxlabel(
            "time from a touchdown [ms]; dashed, triangles: last samples before feet touch; "
            "shaded: windows of the velocities",
            fontsize=7.0,
            x=0.02,
            ha="left",
        )
    return figure


def _spread(landings: Sequence[Touchdown]) -> list[Touchdown]:
    """The touchdowns that are drawn by themselves, spread evenly over all."""
    if not landings:
        return []
    numbers = np.unique(np.linspace(0, len(landings) - 1, PANELS).astype(int))
    return [landings[k] for k in numbers]


def _draw_overview(axes: Axes, study: Touchdowns) -> None:
    """Draw the whole log, with the last samples before touchdowns marked."""
    t = study.log.time
    step = max(1, len(t) // POINTS)
    _draw_curves(axes, study, t[::step], slice(None, None, step), t[0])
    for landing in study.landings:
        time = t[landing.first] - t[0]
        if study.heights is None:
            axes.axvline(time, color=INK, linewidth=0.4, linestyle="--")
        else:
            frames = [study.frames.index(frame) for frame in landing.contacts]
            y = 1e3 * study.heights[landing.first, frames]
            axes.plot(np.full(len(frames), time), y, "v", color=INK, markersize=2.5)
    axes.set(xlabel="time from the first sample [s]", ylabel=_label(study))
    axes.margins(x=0.0)


def _label(study: Touchdowns) -> str:
    return "flag, or force [N]" if study.heights is None else "height [mm]"


def _draw_curves(
    axes: Axes, study: Touchdowns, x: np.ndarray, samples: slice, start: float
) -> None:
    """Draw the heights [mm] of all contacts, or what the log has instead.

    Gaps of the log stay open.
    """
    breaks = np.flatnonzero(np.diff(study.log.segment[samples]))
    for c, frame in enumerate(study.frames):
        if study.heights is not None:
            y = 1e3 * study.heights[samples, c]
        elif frame in study.flagged:
            y = study.log.others[study.flagged[frame]][samples].astype(float)
        else:
            continue
        y = y.copy()
        y[breaks] = np.nan
        colour = CURVES[c % len(CURVES)]
        axes.plot(x - start, y, color=colour, linewidth=0.9, label=printable(frame, 24))


def _draw_detail(axes: Axes, study: Touchdowns, landing: Touchdown) -> None:
    """Draw one touchdown. Windows of joints are shaded, or of the base if there are none."""
    t = study.log.time
    start = t[landing.first]
    window = min(study.window.values())
    after: list[float] = []
    spans: list[tuple[float, float]] = []
    if landing.table and np.isfinite(window):
        after = [t[landing.last] - start + time for time in study.after]
    if after:
        spans = [(-window, 0.0)]
        spans += [(time - 0.5 * window, time + 0.5 * window) for time in after]
    end = start + max([*after, 0.03]) + 1e-3 * BEYOND
    a, b = np.searchsorted(t, (start - 1e-3 * BEFORE, end))
    _draw_curves(axes, study, 1e3 * (t[a:b] - start), slice(int(a), int(b)), 0.0)
    for low, high in spans:
        axes.axvspan(1e3 * low, 1e3 * high, color=faded(INK, 0.85), linewidth=0.0)
    for sample in {landing.first, landing.last}:
        axes.axvline(1e3 * (t[sample] - start), color=INK, linewidth=0.5, linestyle="--")
    contacts = printable("+".join(landing.contacts), 26)
    axes.set(title=f"{landing.name}: {contacts}", xlim=(-BEFORE, 1e3 * (end - start)))
