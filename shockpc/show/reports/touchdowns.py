"""The touchdowns of a log: when which feet land, how fast, and what is missing."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import count, robot_line
from shockpc.studies.touchdowns import Touchdowns
from shockpc.text.printed import few

ROWS = 12
"""Landings that are shown on a terminal."""

NOTE = "fall: speed at which the contacts came down, by their heights"


def touchdowns_report(log: Path, found: Touchdowns) -> Report:
    """The touchdowns of a log."""

    def body(full: bool) -> Iterator[Lines | Sheet | Picture]:
        yield Lines(list(_header(log, found)))
        yield _landings(found, None if full else ROWS)
        yield Picture("touchdowns", "heights of the feet, touchdowns and windows", "touchdowns:draw_touchdowns", (found,))

    return Report(
        name="touchdowns",
        title=f"Touchdowns of {log}",
        body=body,
        closing=list(_closing(found)),
        warnings=[f"warning: {text}" for text in found.warnings],
        sheets={"touchdowns": lambda: sheet_of(found.table)},
        document=lambda: _document(log, found),
    )


def _header(log: Path, found: Touchdowns) -> Iterator[tuple[str, str]]:
    time, segments = found.log.time, len(np.unique(found.log.segment))
    yield (
        "log",
        (
            f"{log}: {count(len(time), 'sample')} in {time[-1] - time[0]:.4g} s, {1.0 / np.median(np.diff(time)):.4g} a second"
            + (f", in {segments} segments" if segments > 1 else "")
        ),
    )
    yield robot_line(found.robot)
    flagged = [f"{frame} by column {column}" for frame, column in found.flagged.items()]
    kinks = [frame for frame in found.frames if frame not in found.flagged] if found.heights is not None else []
    yield "contacts", few([*flagged, *([f"{few(kinks, 8)} by height"] if kinks else [])], 8)
    windows = (f"{part} {1e3 * window:.3g} ms" for part, window in found.window.items() if np.isfinite(window))
    yield "windows", ", ".join(windows) or "no velocities"


def _landings(found: Touchdowns, most: int | None) -> Sheet:
    rows: list[Row] = []
    time = found.log.time
    for landing in found.landings[:most]:
        falls = [f"{speed:.2f}" for speed in landing.speeds if not np.isnan(speed)]
        apart = 1e3 * (time[landing.last] - time[landing.first])
        start = f"{found.log.start + time[landing.first]:.4f}"
        rows.append(
            (landing.name, start, "+".join(landing.contacts), "+".join(landing.stance) or None,
             ", ".join(falls) or None, apart, landing.message or None)
        )  # fmt: skip
    header = ("landing", "time [s]", "contact", "stance", "fall [m/s]", "apart [ms]", "message")
    keep = [k for k in range(len(header)) if k < 3 or any(row[k] is not None for row in rows)]
    left = len(found.landings) - len(rows)
    notes = [NOTE] if 4 in keep else []
    notes += [f"{count(left, 'landing')} not shown; --out or --format json gives all"] if left else []
    return Sheet("touchdowns", [header[k] for k in keep], [[row[k] for k in keep] for row in rows], notes)


def _closing(found: Touchdowns) -> Iterator[str]:
    rows = sum(landing.table for landing in found.landings)
    if not found.landings:
        yield "no touchdowns are in this log: no foot falls, is stopped and stays down"
    elif rows < len(found.landings):
        left = count(len(found.landings) - rows, "touchdown")
        yield f"{left} of {len(found.landings)} not in the table; the messages say why"
    if rows:
        yield f"--out DIR writes the table, touchdowns.csv: {count(rows, 'row')}, which shockpc landings takes"


def _document(log: Path, found: Touchdowns) -> dict[str, Any]:
    time = found.log.time
    return {
        "log": str(log),
        "robot": found.robot.name,
        "samples": len(time),
        "contacts": found.frames,
        "flags": dict(found.flagged),
        "windows": {part: window if np.isfinite(window) else None for part, window in found.window.items()},
        "landings": [
            {
                "landing": landing.name,
                "time": found.log.start + time[landing.first],
                "time_last": found.log.start + time[landing.last],
                "contact": landing.contacts,
                "stance": landing.stance,
                "fall_speed": [None if np.isnan(speed) else speed for speed in landing.speeds],
                "in_table": landing.table,
                "message": landing.message,
            }
            for landing in found.landings
        ],
        "warnings": found.warnings,
    }
