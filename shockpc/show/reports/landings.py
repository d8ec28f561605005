"""The landings of a table: ranges of every quantity, the landings themselves, and measured jumps against predicted ones."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from shockpc.show.header import JOINT_MODELS, count, proven_text, shown_as
from shockpc.show.reports.report import Block, Picture, Report
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.studies.columns import Column
from shockpc.studies.landings.comparison import STATISTICS, Agreement, Comparison
from shockpc.studies.landings.study import CLOSED_BY, RATES_BY, Found

SHORT = 10
"""Landings that are shown on a terminal."""

MESSAGES = 5
"""Different messages of rows that could not be computed that are shown."""

MEASURED_NOTES = (
    "r: correlation; slope: of the regression of measured on predicted jumps; error: median over the landings of "
    "‖predicted − measured‖ / ‖measured‖",
    "skill: 1 − Σ(predicted − measured)² / Σ measured², against no jump; (mean): against the mean of the other landings; "
    "below 0 is worse than these",
    "in brackets: 95 % interval, by drawing landings with replacement",
    "gravity and the drives act between the two measurements, and are no part of the prediction",
)


def landings_report(table: str, found: Found, rank: Column | None = None, comparison: Comparison | None = None) -> Report:
    """The landings of a table.

    Args:
        table: its name.
        found: the landings.
        rank: the column by which they are ranked, if they are.
        comparison: of what the table measured, if it did.
    """
    order = found.ranked(rank)

    def body(full: bool) -> Iterator[Block]:
        yield Lines(list(_header(table, found)))
        yield _extents(found)
        caption = "measured over predicted jumps" if comparison else "results of the landings"
        yield Picture("landings", caption, "landings:draw_landings", (found, comparison))
        yield _rows(found, order, rank, None if full else SHORT)
        if comparison is not None:
            yield agreement_sheet(comparison, full)

    sheets = {"landings": lambda: _rows(found, order, rank, None, exact=True)}
    if comparison is not None:
        sheets["measured"] = lambda: _measured(comparison)
    return Report(
        name="landings",
        title=f"Landings of {table}",
        body=body,
        closing=list(_closing(found, comparison)),
        warnings=list(_warnings(found)),
        sheets=sheets,
        document=lambda: _document(table, found, order, comparison),
    )


def _header(table: str, found: Found) -> Iterator[tuple[str, str]]:
    made, landing = found.made, found.made.first
    robot, rows = made.robot, made.table
    yield "table", f"{table}: {count(made.rows, 'landing')}"
    yield "robot", f"{robot.label} ({robot.name}, {robot.mass:.4g} kg)"
    yield "in the table", ", ".join(rows.given)
    yield "of the scene", ", ".join(rows.missing) or "nothing"
    if rows.contact is None:
        yield "contact", " + ".join(contact.frame for contact in landing.scene.contact)
    yield "joint model", JOINT_MODELS[landing.joint_model.name]


def _extents(found: Found) -> Sheet:
    rows: list[Row] = []
    for column in found.made.computed:
        values = found.columns[column.name]
        known = values[np.isfinite(values)]
        if known.size:
            worst = np.nanargmin if column.selection.quantity.worse == "less" else np.nanargmax
            greatest = found.made.table.names[int(worst(np.where(np.isfinite(values), values, np.nan)))]
            rows.append((column.heading, *np.quantile(known, (0.0, 0.5, 0.95, 1.0)).tolist(), str(greatest)))
        else:
            rows.append((column.heading, None, None, None, None, None))
    return Sheet("quantities", ("quantity", "least", "median", "95 %", "greatest", "worst in landing"), rows)


def _rows(found: Found, order: Sequence[int], rank: Column | None, most: int | None, exact: bool = False) -> Sheet:
    """A row for every landing. Args: exact, whether all columns are wanted, for programs."""
    made = found.made
    names = [column.name for column in made.computed]
    names += [name for name in made.headings[1:] if exact and name not in names]
    heads = {column.name: column.heading for column in made.computed}
    rows: list[Row] = []
    for i in order[:most]:
        values = (found.columns[name][i] for name in names)
        cells = tuple(("no", "yes")[int(value)] if value.dtype.kind == "b" else float(value) for value in values)
        message = (found.messages.get(i),) if exact or found.messages else ()
        rows.append((str(made.table.names[i]), *cells, *message))
    header = ("landing", *(heads.get(name, name) for name in names), *(("message",) if exact or found.messages else ()))
    title = "landings" if rank is None else f"landings, ranked by {rank.name}"
    left = len(order) - len(rows)
    return Sheet(title, header, rows, [f"{count(left, 'landing')} not shown; --out or --format csv gives all"] if left else ())


def agreement_sheet(comparison: Comparison, full: bool = False) -> Sheet:
    """How well measured and predicted jumps agree. Args: full, whether single quantities are listed besides their groups."""
    rows: list[Row] = []
    for one in comparison.agreements:
        if full or one.group or "@" in one.name:
            time = None if one.time is None else f"{one.time:g}"
            rows.append((one.model, time, f"{one.name} [{one.unit}]", *(_interval(*one.statistics[key]) for key in STATISTICS)))
    return Sheet("measured against predicted jumps", ("joint model", "after [ms]", "quantity", *STATISTICS), rows, MEASURED_NOTES)


def _interval(value: float, low: float, high: float) -> str | None:
    """A statistic with its interval."""
    if math.isnan(value):
        return None
    return f"{value:.2f}" + ("" if math.isnan(low) else f" ({low:.2f} … {high:.2f})")


def _measured(comparison: Comparison) -> Sheet:
    """The same with all digits."""
    rows = [
        (one.model, one.time, one.name, one.unit, *(x for key in STATISTICS for x in one.statistics[key]))
        for one in comparison.agreements
    ]
    header = (
        "joint model",
        "after [ms]",
        "quantity",
        "unit",
        *(f"{key}{end}" for key in STATISTICS for end in ("", " low", " high")),
    )
    return Sheet("", header, rows)


def _closing(found: Found, comparison: Comparison | None) -> Iterator[str]:
    made, columns = found.made, found.columns
    if made.first.loops and not np.isnan(columns[CLOSED_BY]).all():
        by, rates = (float(np.nanmax(columns[name])) for name in (CLOSED_BY, RATES_BY))
        yield f"loops: closing them changes positions of the table by at most {by:.2g} rad (m), rates by {rates:.2g} rad/s (m/s)"
    proven = int(np.sum(columns["proven"]))
    if proven:
        yield proven_text(proven, made.computed)
    compared = columns["double_error"][~columns["proven"].astype(bool) & ~np.isnan(columns["double_error"])]
    if compared.size and any(column.shock for column in made.computed):
        yield (
            f"double precision, compared with a proof in {count(compared.size, 'other landing')}: off by at most "
            f"{compared.max():.0e} of the point's most severe shock"
        )
    failures = [text for _, _, text in comparison.failures] if comparison else []
    for what, texts in (("computed", list(found.messages.values())), ("predicted", failures)):
        if texts:
            yield f"not {what}: {count(len(texts), 'landing')}"
            yield from (f"  {n} x {text}" for text, n in Counter(texts).most_common(MESSAGES))


def _warnings(found: Found) -> Iterator[str]:
    for joint in found.made.robot.single_joints:
        low, high = joint.limits
        if joint.name in found.made.table.joints and joint.kind in ("revolute", "prismatic"):
            values = found.made.table.Q[:, joint.q.start]
            outside = np.maximum(low - values, values - high)
            if n := int(np.sum(outside > 1e-4)):
                most = shown_as(float(outside.max()), joint.unit)
                yield f'warning: joint "{joint.name}" is outside its limits in {count(n, "landing")}, by at most {most}'


def _document(table: str, found: Found, order: Sequence[int], comparison: Comparison | None) -> dict[str, Any]:
    made = found.made
    names = made.headings[1:]
    return {
        "table": table,
        "robot": made.robot.name,
        "scene": made.first.scene,
        "given": made.table.given,
        "of_scene": made.table.missing,
        "columns": [{"name": column.name, "unit": column.selection.quantity.unit} for column in made.computed],
        "rows": [
            {
                "landing": str(made.table.names[i]),
                **{name: found.columns[name][i] for name in names},
                "message": found.messages.get(i),
            }
            for i in order
        ],
        "measured": [_agreement(one) for one in comparison.agreements] if comparison else [],
    }


def _agreement(one: Agreement) -> dict[str, Any]:
    """How well one quantity, or group, agrees."""
    statistics = {key: dict(zip(("value", "low", "high"), one.statistics[key], strict=True)) for key in STATISTICS}
    return {"model": one.model, "time_ms": one.time, "quantity": one.name, "unit": one.unit, **statistics}
