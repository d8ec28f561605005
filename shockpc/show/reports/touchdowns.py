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


def touchdowns_report(log: Path, study: Touchdowns) -> Report:
    """The touchdowns of a log."""

    def body(full: bool) -> Iterator[Lines | Sheet | Picture]:
        yield Lines(list(_header(log, study)))
        yield _landings(study, None if full else ROWS)
        yield Picture("touchdowns", "heights of the feet, touchdowns and windows", "touchdowns:draw_touchdowns", (study,))

    return Report(
        name="touchdowns",
        title=f"Touchdowns of {log}",
        body=body,
        closing=list(_closing(study)),
        warnings=[f"warning: {text}" for text in study.warnings],
        sheets={"touchdowns": lambda: sheet_of(study.table)},
        document=lambda: _document(log, study),
    )


def _header(log: Path, study: Touchdowns) -> Iterator[tuple[str, str]]:
    time, segments = study.log.time, len(np.unique(study.log.segment))
    yield (
        "log",
        (
            f"{log}: {count(len(time), 'sample')} in {time[-1] - time[0]:.4g} s, {1.0 / np.median(np.diff(time)):.4g} a second"
            + (f", in {segments} segments" if segments > 1 else "")
        ),
    )
    yield robot_line(study.robot)
    flagged = [f"{frame} by column {column}" for frame, column in study.flagged.items()]
    kinks = [frame for frame in study.frames if frame not in study.flagged] if study.heights is not None else []
    yield "contacts", few([*flagged, *([f"{few(kinks, 8)} by height"] if kinks else [])], 8)
    windows = (f"{part} {1e3 * window:.3g} ms" for part, window in study.window.items() if np.isfinite(window))
    yield "windows", ", ".join(windows) or "no velocities"


def _landings(study: Touchdowns, most: int | None) -> Sheet:
    rows: list[Row] = []
    time = study.log.time
    for landing in study.landings[:most]:
        falls = [f"{speed:.2f}" for speed in landing.speeds if not np.isnan(speed)]
        apart = 1e3 * (time[landing.last] - time[landing.first])
        start = f"{study.log.start + time[landing.first]:.4f}"
        rows.append(
            (landing.name, start, "+".join(landing.contacts), "+".join(landing.stance) or None,
             ", ".join(falls) or None, apart, landing.message or None)
        )  # fmt: skip
    header = ("landing", "time [s]", "contact", "stance", "fall [m/s]", "apart [ms]", "message")
    keep = [k for k in range(len(header)) if k < 3 or any(row[k] is not None for row in rows)]
    left = len(study.landings) - len(rows)
    notes = [NOTE] if 4 in keep else []
    notes += [f"{count(left, 'landing')} not shown; --out or --format json gives all"] if left else []
    return Sheet("touchdowns", [header[k] for k in keep], [[row[k] for k in keep] for row in rows], notes)


def _closing(study: Touchdowns) -> Iterator[str]:
    rows = sum(landing.table for landing in study.landings)
    if not study.landings:
        yield "no touchdowns are in this log: no foot falls, is stopped and stays down"
    elif rows < len(study.landings):
        left = count(len(study.landings) - rows, "touchdown")
        yield f"{left} of {len(study.landings)} not in the table; the messages say why"
    if rows:
        yield f"--out DIR writes the table, touchdowns.csv: {count(rows, 'row')}, which shockpc landings takes"


def _document(log: Path, study: Touchdowns) -> dict[str, Any]:
    time = study.log.time
    return {
        "log": str(log),
        "robot": study.robot.name,
        "samples": len(time),
        "contacts": study.frames,
        "flags": dict(study.flagged),
        "windows": {part: window if np.isfinite(window) else None for part, window in study.window.items()},
        "landings": [
            {
                "landing": landing.name,
                "time": study.log.start + time[landing.first],
                "time_last": study.log.start + time[landing.last],
                "contact": landing.contacts,
                "stance": landing.stance,
                "fall_speed": [None if np.isnan(speed) else speed for speed in landing.speeds],
                "in_table": landing.table,
                "message": landing.message,
            }
            for landing in study.landings
        ],
        "warnings": study.warnings,
    }
