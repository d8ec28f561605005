"""The paper computed again, as tables: shock of every body, every statement with its verdict, and what the open readings do."""

import math
from collections.abc import Sequence

import numpy as np

from shockpc.paper.results import FigureResult
from shockpc.paper.statement import Outcome, Statement
from shockpc.show.tables.sheets import Cell, Sheet

__all__ = ["paper_bodies_sheet", "readings_sheet", "statement_lines", "statements_sheet"]


def paper_bodies_sheet(results: Sequence[FigureResult]) -> Sheet:
    """One row for every body of every panel."""
    rows: list[tuple[Cell, ...]] = []
    for result in results:
        for panel, profile in zip(result.figure.panels, result.profiles, strict=True):
            for i, body in enumerate(profile.bodies):
                where: tuple[Cell, ...] = ("translates", None) if profile.translates[i] else _in_plane(profile.copc[i])
                shown = f"{result.figure.number} {panel.label}"
                shock = (profile.shock_com[i], profile.shock_min[i], profile.shock_max[i])
                rows.append((shown, body, *where, float(profile.ropc[i]), *(None if math.isnan(x) else float(x) for x in shock)))
    header = ("figure", "body", "CoPc x [m]", "CoPc z [m]", "RoPc [m]", "shock at CoM [-]", "least [-]", "greatest [-]")
    notes = ("Figure 3: all masses and most lengths are assumed",) if any(r.figure.number == 3 for r in results) else ()
    return Sheet("bodies (CoPc in body coordinates, joints free; shock relative to the strike)", header, rows, notes)


def statements_sheet(results: Sequence[FigureResult]) -> Sheet:
    """One row for every statement: the number under the reading taken, its range under all readings, and the verdict."""
    rows: list[tuple[Cell, ...]] = []
    for statement in (statement for result in results for statement in result.statements):
        numbers = [outcome.number for outcome in statement.outcomes]
        rows.append(
            (
                statement.place,
                statement.says,
                statement.measure,
                statement.number,
                min(numbers),
                max(numbers),
                statement.verdict,
            )
        )
    header = ("place", "statement", "number", "as taken", "least", "greatest", "verdict")
    return Sheet("statements of the paper (least and greatest over all readings of the text)", header, rows)


def readings_sheet(results: Sequence[FigureResult]) -> Sheet:
    """One row for every open reading of every statement: the number under each option, and whether the verdict hangs on it."""
    rows: list[tuple[Cell, ...]] = []
    for statement in (statement for result in results for statement in result.statements):
        for name in statement.readings:
            options = "; ".join(_option(outcome, name) for outcome in statement.along(name))
            rows.append(
                (name, statement.place, statement.says, options, "matters" if statement.matters(name) else "does not matter")
            )
    rows.sort(key=lambda row: str(row[0]))
    header = (
        "left open",
        "place",
        "statement",
        "number under each reading, the one taken first (✗ where it fails)",
        "to the verdict",
    )
    return Sheet("what the text leaves open, one thing changed at a time", header, rows)


def statement_lines(statements: Sequence[Statement]) -> list[str]:
    """Every statement in two or more lines for a terminal: what it says, then number and verdict."""
    lines = []
    for statement in statements:
        lines.append(f"{statement.place}: {statement.says}")
        lines.append(f"    {statement.measure}: {_number(statement.number)}")
        lines.append(f"    {statement.verdict}")
    return lines


def _number(value: float) -> str:
    """A number to four digits; what is left of a zero as a power of ten."""
    return "inf" if math.isinf(value) else f"{value:.4g}"


def _option(outcome: Outcome, name: str) -> str:
    return f"{dict(outcome.reading)[name]} → {_number(outcome.number)}{'' if outcome.holds else ' ✗'}"


def _in_plane(copc: np.ndarray) -> tuple[Cell, ...]:
    return float(copc[0]), float(copc[2])
