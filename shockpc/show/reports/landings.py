"""The landings of a table: ranges of every quantity, the landings themselves, and measured jumps against predicted ones."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.evaluation.columns import Column
from shockpc.evaluation.recorded import CLOSED_BY, RATES_BY, RecordedLandings
from shockpc.evaluation.table import Table
from shockpc.quantities.profile import ShockProfile
from shockpc.show.reports.report import Picture, Report, Section, picture_files
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.show.wording import JOINT_MODELS, LEFT_OUT, count, proof_lines, robot_line, shown_as, without_value
from shockpc.studies.landings import FEWEST, STATISTICS, Agreement, Validation
from shockpc.text.printed import cause_lines, causes, few

ROWS = 10
"""Landings that are shown on a terminal."""

MESSAGES = 5
"""Different messages of rows that could not be computed that are shown."""

MEASURED_NOTES = (
    "r: correlation; slope: of the regression of measured on predicted jumps; error: median over the landings of "
    "‖predicted − measured‖ / ‖measured‖; (energy): in the norm √(ΔᵀHΔ) of the landing's inertia, in which velocities of all units "
    "count by their kinetic energy, those that were not measured by the least that is possible",
    "skill: 1 − Σ(predicted − measured)² / Σ measured², against no jump; (mean): against the mean of the other landings; "
    "below 0 is worse than these",
    "n: landings that were measured and predicted, of which the others of the row are; in brackets: 95 % interval, by drawing "
    f"landings with replacement; of fewer than {FEWEST} landings there is neither an interval nor r",
    "gravity and the drives act between the two measurements, and are no part of the prediction",
)


def landings_report(
    table: str,
    landings: RecordedLandings,
    results: Table,
    rank: Column | None = None,
    validation: Validation | None = None,
    worst: Mapping[str, ShockProfile] | None = None,
) -> Report:
    """The landings of a table.

    Args:
        table: its name.
        landings: its rows.
        results: what was computed of them.
        rank: the column by which they are ranked, if they are.
        validation: of what the table measured, if it did.
        worst: the worst landings by name, which report.html shows.
    """
    order = list(range(len(results))) if rank is None else results.ranked(rank).tolist()

    def body(full: bool) -> Iterator[Section]:
        yield Lines(list(_header(table, landings)))
        if validation is not None:
            yield Picture("measured", "measured over predicted jumps", "landings:draw_validation", (landings, validation))
            yield agreement_sheet(validation, full)
        yield _extents(landings, results)
        yield Picture("landings", "distributions of the results", "landings:draw_landings", (landings, results))
        yield _rows(landings, results, order, rank, None if full else ROWS)

    sheets = {"landings": lambda: _rows(landings, results, order, rank, None, exact=True)}
    if validation is not None:
        sheets["measured"] = lambda: _measured(validation)
    return Report(
        name="landings",
        title=f"Landings of {table}",
        body=body,
        lead=2,
        closing=list(_closing(landings, results, validation)),
        warnings=[*_making_energy(landings, results), *_warnings(landings)],
        sheets=sheets,
        document=lambda: _document(table, landings, results, order, validation),
        others=("measured.csv", *picture_files("measured")),
        landings=worst or {},
    )


def _header(table: str, study: RecordedLandings) -> Iterator[tuple[str, str]]:
    rows, robot, landings = study.table, study.robot, list(study.resolved)
    yield "table", f"{table}: {count(study.rows, 'landing')}"
    yield robot_line(robot)
    yield "in the table", ", ".join(rows.given)
    yield "of the scene", ", ".join(rows.missing) or "nothing"
    contacts = dict.fromkeys(" + ".join(contact.frame for contact in landing.scene.contact) for landing in landings)
    yield "contact", few(list(contacts), 4, what=" sets of contacts")
    if (mu := rows.friction[~np.isnan(rows.friction)]).size:
        extent = " to ".join(dict.fromkeys(f"{x:g}" for x in (mu.min(), mu.max())))
        yield "friction", f"{extent}{'; what was measured is compared with the motion with friction' * bool(rows.measured)}"
    models = dict.fromkeys((landing.joint_model.name, landing.joint_model.drives) for landing in landings)
    yield "joint model", "; ".join(f"{name}: {drives}" if drives else JOINT_MODELS[name] for name, drives in models)


def _extents(landings: RecordedLandings, results: Table) -> Sheet:
    rows: list[Row] = []
    for column in _shown(results):
        values = results.columns[column.name]
        known, worst = values[np.isfinite(values)], results.worst(1, column)
        extent = np.quantile(known, (0.0, 0.5, 0.95, 1.0)).tolist() if known.size else [None] * 4
        rows.append((column.heading, *extent, str(landings.table.names[worst[0]]) if worst else None))
    return Sheet("quantities", ("quantity", "least", "median", "95 %", "greatest", "worst in landing"), rows)


def _rows(
    study: RecordedLandings, results: Table, order: Sequence[int], rank: Column | None, most: int | None, exact: bool = False
) -> Sheet:
    """A row for every landing. Args: exact, whether all columns are wanted, for programs."""
    names = _numbers(study, results) if exact else tuple(column.name for column in _shown(results))
    labels, messages = study.table.labels, exact or bool(results.messages)
    if not exact and len(set(labels["contact"].tolist())) == 1:
        labels = {name: values for name, values in labels.items() if name != "contact"}  # as the header says
    heads = {"name": "landing"} | {column.name: column.heading for column in results.computed}
    rows: list[Row] = []
    for i in order[:most]:
        values = (results.columns[name][i] for name in names)
        cells = (("no", "yes")[int(value)] if value.dtype.kind == "b" else float(value) for value in values)
        rows.append((*(values[i].item() for values in labels.values()), *cells, *[results.messages.get(i)] * messages))
    header = (*(heads.get(name, name) for name in (*labels, *names)), *["message"] * messages)
    title = "landings" if rank is None else f"landings, ranked by {rank.name}"
    left = len(order) - len(rows)
    return Sheet(title, header, rows, [f"{count(left, 'landing')} not shown; --out or --format csv gives all"] if left else ())


def _shown(results: Table) -> list[Column]:
    """The columns that people read: what was asked for, and the energy made if there is some."""
    return [column for column in results.computed if column in results.main or (results.columns[column.name] > 0.0).any()]


def _numbers(study: RecordedLandings, results: Table) -> list[str]:
    """The headings of the columns of numbers."""
    return [name for name in results.columns if name not in study.table.labels]


def agreement_sheet(validation: Validation, full: bool = False) -> Sheet:
    """How well measured and predicted jumps agree. Args: full, whether single quantities are listed besides their groups."""
    rows: list[Row] = []
    for agreement in validation.agreements:
        if full or agreement.group:
            time = None if agreement.time is None else f"{agreement.time:g}"
            statistics = (_interval(*agreement.statistics[key]) for key in STATISTICS)
            name = f"{agreement.name} [{agreement.unit}]"
            rows.append((agreement.model, time, name, str(agreement.n), *statistics))
    header = ("joint model", "after [ms]", "quantity", "n", *STATISTICS)
    return Sheet("measured against predicted jumps", header, rows, MEASURED_NOTES)


def _interval(value: float, low: float, high: float) -> str | None:
    """A statistic with its interval."""
    if math.isnan(value):
        return None
    return f"{value:.2f}" + ("" if math.isnan(low) else f" ({low:.2f} … {high:.2f})")


def _measured(validation: Validation) -> Sheet:
    """The same with all digits."""
    rows = [
        (each.model, each.time, each.name, each.unit, each.n, *(x for key in STATISTICS for x in each.statistics[key]))
        for each in validation.agreements
    ]
    statistics = (f"{key}{end}" for key in STATISTICS for end in ("", " low", " high"))
    return Sheet("", ("joint model", "after [ms]", "quantity", "unit", "n", *statistics), rows)


def _closing(study: RecordedLandings, results: Table, validation: Validation | None) -> Iterator[str]:
    columns = results.columns
    if study.closes and not np.isnan(columns[CLOSED_BY]).all():
        by, rates = (float(np.nanmax(columns[name])) for name in (CLOSED_BY, RATES_BY))
        yield f"loops: closing them changes positions of the table by at most {by:.2g} rad (m), rates by {rates:.2g} rad/s (m/s)"
    if len(results.messages) < study.rows:
        empty = [column for column in results.computed if np.isnan(columns[column.name]).all()]
        yield from without_value((column.name, column.selection.quantity) for column in empty)
    if any(landing.scene.contact_stiffness is not None for landing in study.resolved):
        yield LEFT_OUT
    compared = columns["double_error"][~columns["proven"].astype(bool) & ~np.isnan(columns["double_error"])]
    number = compared.size if any(column.shock for column in results.computed) else 0
    yield from proof_lines(int(np.sum(columns["proven"])), number, compared.max(initial=0.0), results.computed)
    computed = np.array([i not in results.messages for i in range(study.rows)])
    for column in results.computed:
        if 0 < (missing := int(np.sum(np.isnan(columns[column.name]) & computed))) < np.sum(computed):
            why = column.selection.quantity.missing or "it does not exist there"
            yield f"no {column.name} in {count(missing, 'landing')}: {why}"
    refused = [(str(study.table.names[i]), text) for i, text in results.messages.items()]
    failures = [(f"{row} ({model})", text) for model, row, text in validation.failures] if validation else []
    for what, messages in (("computed", refused), ("predicted", failures)):
        if messages:
            yield f"not {what}: {count(len(messages), 'landing')}"
            yield from (f"  {line}" for line in cause_lines(causes(messages), "landings", MESSAGES))


def _making_energy(study: RecordedLandings, results: Table) -> Iterator[str]:
    """A warning of rows that are no landings, because restitution would make energy; with friction they are those that slide."""
    (made,) = (results.columns[column.name] for column in results.computed if column.selection.quantity.role == "gain")
    made = np.where(np.isnan(study.table.friction) | (not study.by_friction), np.nan_to_num(made), 0.0)
    if n := int(np.sum(made > 0.0)):
        most, name = float(made.max()), study.table.names[int(made.argmax())]
        yield (
            f"warning: the impact would make kinetic energy in {n} of {count(study.rows, 'landing')}, which is not feasible, at "
            f"most {most:.3g} J in landing {name}; take less restitution, one for all contacts, or --restitution-along directions"
        )


def _warnings(landings: RecordedLandings) -> Iterator[str]:
    yield from (f"warning: {text}" for text in landings.table.warnings)
    yield from (f"warning: {warning}" for warning in landings.first.warnings if warning.kind == "scene")
    for joint in landings.robot.single_joints:
        low, high = joint.limits
        if joint.name in landings.table.joints and joint.kind in ("revolute", "prismatic"):
            values = landings.table.Q[:, joint.q.start]
            outside = np.maximum(low - values, values - high)
            if n := int(np.sum(outside > 1e-4)):
                most = shown_as(float(outside.max()), joint.unit)
                yield f'warning: joint "{joint.name}" is outside its limits in {count(n, "landing")}, by at most {most}'


def _document(
    table: str, study: RecordedLandings, results: Table, order: Sequence[int], validation: Validation | None
) -> dict[str, Any]:
    return {
        "table": table,
        "robot": study.robot.name,
        "scene": study.first.scene,
        "given": study.table.given,
        "of_scene": study.table.missing,
        "columns": [{"name": column.name, "unit": column.selection.quantity.unit} for column in results.computed],
        "rows": [
            {
                "landing": str(study.table.names[i]),
                **{name: values[i].item() for name, values in study.table.labels.items() if name != "name"},
                **{name: results.columns[name][i] for name in _numbers(study, results)},
                "message": results.messages.get(i),
            }
            for i in order
        ],
        "measured": [_agreement(each) for each in validation.agreements] if validation else [],
    }


def _agreement(each: Agreement) -> dict[str, Any]:
    """How well one quantity, or group, agrees."""
    statistics = {key: dict(zip(("value", "low", "high"), each.statistics[key], strict=True)) for key in STATISTICS}
    return {"model": each.model, "time_ms": each.time, "quantity": each.name, "unit": each.unit, "n": each.n, **statistics}
