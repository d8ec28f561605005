"""The touchdowns of a log: when which feet land, how fast, and what is missing."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.show.report import Picture, Report
from shockpc.show.tables import Heading, Lines, Row, Sheet, sheet_of
from shockpc.show.wording import robot_line
from shockpc.text.printed import count, few
from shockpc.wings.recordings.touchdowns.touchdowns import Touchdowns

ROWS = 12
"""Landings that are shown on a terminal."""

NOTE = "fall: speed at which the contacts came down, by their heights, the largest of several"


def touchdowns_report(log: Path, study: Touchdowns) -> Report:
    """The touchdowns of a log."""

    def body(full: bool) -> Iterator[Lines | Sheet | Picture]:
        yield Lines(list(_header(log, study)))
        sheet = _landings(study).without("time_last", "in_table")
        known = sheet.known()
        notes = [NOTE] if "fall" in known.keys else []
        yield known._replace(notes=notes).largest(None if full else ROWS, "landing")
        yield Picture(
            "touchdowns",
            "heights of the feet, touchdowns and windows",
            "wings.recordings.touchdowns.figure:draw_touchdowns",
            (study,),
        )

    return Report(
        name="touchdowns",
        title=f"Touchdowns of {log}",
        body=body,
        closing=list(_closing(study)),
        warnings=[f"warning: {text}" for text in study.warnings],
        sheets={
            "touchdowns": lambda: _table(study),
            "landings": lambda: _landings(study),
            "falls": lambda: _falls(study),
        },
        tables=True,
        document=lambda: _document(log, study),
    )


def _header(log: Path, study: Touchdowns) -> Iterator[tuple[str, str]]:
    time = study.log.time
    segments = len(np.unique(study.log.segment))
    text = (
        f"{log}: {count(len(time), 'sample')} in {time[-1] - time[0]:.4g} s, "
        f"{1.0 / np.median(np.diff(time)):.4g} a second"
    )
    if segments > 1:
        text += f", in {segments} segments"
    yield "log", text
    yield robot_line(study.robot)
    contacts = [f"{frame} by column {column}" for frame, column in study.flagged.items()]
    by_height = [frame for frame in study.frames if frame not in study.flagged]
    if study.heights is not None and by_height:
        contacts.append(f"{few(by_height, 8)} by height")
    yield "contacts", few(contacts, 8)
    windows = []
    for part, window in study.window.items():
        if np.isfinite(window):
            windows.append(f"{part} {1e3 * window:.3g} ms")
    yield "windows", ", ".join(windows) or "no velocities"


def _table(study: Touchdowns) -> Sheet:
    """The table that `shockpc recorded` takes, whose columns have only its names."""
    sheet = sheet_of(study.table)
    return sheet._replace(header=[Heading(name, name) for name in study.table.columns])


def _landings(study: Touchdowns) -> Sheet:
    """Every landing that was found, in the table or not."""
    rows: list[Row] = []
    time = study.log.time
    for landing in study.landings:
        first, last = (study.log.start + float(time[k]) for k in (landing.first, landing.last))
        fall = max((speed for speed in landing.speeds if not np.isnan(speed)), default=None)
        named = "+".join(landing.contacts), "+".join(landing.stance) or None
        rows.append(
            (
                landing.name,
                first,
                last,
                *named,
                fall,
                last - first,
                landing.table,
                landing.message or None,
            )
        )
    header = (
        "landing",
        "time [s]",
        "time last [s]",
        "contact",
        "stance",
        "fall [m/s]",
        "apart [ms]",
        "in table",
        "message",
    )
    return Sheet("touchdowns", header, rows)


def _falls(study: Touchdowns) -> Sheet:
    """The speed of each contact of a landing."""
    rows: list[Row] = []
    for landing in study.landings:
        for contact, speed in zip(landing.contacts, landing.speeds, strict=True):
            rows.append((landing.name, contact, speed))
    return Sheet("falls", ("landing", "contact", "fall [m/s]"), rows)


def _closing(study: Touchdowns) -> Iterator[str]:
    rows = sum(landing.table for landing in study.landings)
    if not study.landings:
        yield "no touchdowns are in this log: no foot falls, is stopped and stays down"
    elif rows < len(study.landings):
        left = count(len(study.landings) - rows, "touchdown")
        yield f"{left} of {len(study.landings)} not in the table; the messages say why"
    if rows:
        yield (
            f"--out DIR writes the table, touchdowns.csv: {count(rows, 'row')}, "
            "which shockpc recorded takes"
        )


def _document(log: Path, study: Touchdowns) -> dict[str, Any]:
    windows: dict[str, float | None] = {}
    for part, window in study.window.items():
        windows[part] = window if np.isfinite(window) else None
    return {
        "log": str(log),
        "robot": study.robot.name,
        "samples": len(study.log.time),
        "contacts": study.frames,
        "flags": dict(study.flagged),
        "windows": windows,
        "warnings": study.warnings,
    }
