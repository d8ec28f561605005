"""The landings of a table: ranges of every quantity, and measured against predicted jumps.

The landings themselves are a table too.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from shockpc.evaluation.column import Column
from shockpc.evaluation.table import Table
from shockpc.profile import profile_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.header import JOINT_MODELS, unknown_lines
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Cell, Heading, Lines, Row, Sheet, sheet_of
from shockpc.show.wording import LEFT_OUT, proof_lines, robot_line, without_value
from shockpc.text.errors import ShockError
from shockpc.text.printed import cause_lines, causes, count, few, shown_as
from shockpc.wings.recordings.recorded.study import FEWEST, STATISTICS, Validation
from shockpc.wings.recordings.tables.landings import CLOSED_BY, RATES_BY, RecordedLandings

ROWS = 10
"""Landings that are shown on a terminal."""

MESSAGES = 5
"""Different messages of rows that could not be computed that are shown."""

MEASURED_NOTES = (
    "r: correlation; slope: of the regression of measured on predicted jumps; error: median over "
    "the landings of ‖predicted − measured‖ / ‖measured‖. (energy): in the norm √(ΔᵀHΔ) with the "
    "landing's inertia; velocities that were not measured are set so that the norm is least",
    "skill: 1 − Σ(predicted − measured)² / Σ measured², against no jump; (mean): against the mean "
    "of the other landings; "
    "below 0 is worse than these",
    "n: number of landings that were both measured and predicted; CSV and JSON have 95 % "
    f"intervals (low, high), by drawing landings with replacement. Fewer than {FEWEST} landings "
    "give neither an interval nor r",
    "gravity and the drives act between the two measurements, but are not in the prediction",
)


def recorded_report(
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
    try:
        computed = [profile_of(landings.first)]
    except ShockError:
        computed = []  # the row of this landing says why

    def body(full: bool) -> Iterator[Section]:
        yield Lines([*unknown_lines(computed), *_header(table, landings)])
        if validation is not None:
            yield Picture(
                "measured",
                "measured over predicted jumps",
                "wings.recordings.recorded.figure:draw_validation",
                (landings, validation),
            )
            yield agreement_sheet(validation, full)
        yield _extents(landings, results)
        yield Picture(
            "recorded",
            "distributions of the results",
            "wings.recordings.recorded.figure:draw_recorded",
            (landings, results),
        )
        yield _shown_rows(landings, results, order, rank).largest(None if full else ROWS, "landing")

    sheets = {
        "landings": lambda: _rows(results, order),
        "quantities": lambda: _extents(landings, results),
    }
    if validation is not None:
        sheets["measured"] = lambda: agreement_sheet(validation, full=True, intervals=True)
    return Report(
        name="recorded",
        title=f"Landings of {table}",
        body=body,
        lead=2,
        closing=list(_closing(landings, results, validation)),
        warnings=[*_making_energy(landings, results), *_warnings(landings)],
        sheets=sheets,
        document=lambda: {
            "table": table,
            "robot": landings.robot.name,
            "scene": landings.first.scene,
            "given": landings.table.given,
            "of_scene": landings.table.missing,
            "unknowns": [unknown for profile in computed for unknown in profile.unknowns],
        },
        tables=True,
        landings=worst or {},
    )


def _header(table: str, study: RecordedLandings) -> Iterator[tuple[str, str]]:
    rows = study.table
    yield "table", f"{table}: {count(study.rows, 'landing')}"
    yield robot_line(study.robot)
    yield "in the table", ", ".join(rows.given)
    yield "of the scene", ", ".join(rows.missing) or "nothing"
    contacts: dict[str, None] = {}
    for landing in study.resolved:
        frames = [contact.frame for contact in landing.scene.contact]
        contacts[" + ".join(frames)] = None
    yield "contact", few(list(contacts), 4, noun=" sets of contacts")
    friction = rows.friction[~np.isnan(rows.friction)]
    if friction.size:
        text = " to ".join(dict.fromkeys(f"{x:g}" for x in (friction.min(), friction.max())))
        if rows.measured:
            text += "; measured jumps are compared with the motion with friction"
        yield "friction", text
    model = study.first.joint_model
    drives = f"{model.name}: {model.drives}" if model.drives else JOINT_MODELS[model.name]
    yield "joint model", drives


def _extents(landings: RecordedLandings, results: Table) -> Sheet:
    rows: list[Row] = []
    for column in _shown(results):
        values = results.columns[column.name]
        known = values[np.isfinite(values)]
        extent = [None] * 4
        if known.size:
            extent = np.quantile(known, (0.0, 0.5, 0.95, 1.0)).tolist()
        worst = results.worst(1, column)
        name = str(landings.table.names[worst[0]]) if worst else None
        rows.append((column.name, column.unit, *extent, name))
    percentile = Heading("percentile_95", "95 %")
    return Sheet(
        "quantities",
        ("quantity", "unit", "minimum", "median", percentile, "maximum", "worst in landing"),
        rows,
    )


def _rows(results: Table, order: Sequence[int]) -> Sheet:
    """A row for every landing."""
    sheet = sheet_of(results, "landings", messages="message")
    # The first column has the names of the landings; keys of the others are their names.
    _, *headings = [Heading(name, name, unit) for name, unit in results.units.items()]
    rows = [sheet.rows[i] for i in order]
    return sheet._replace(header=["landing", *headings, "message"], rows=rows)


def _shown_rows(
    study: RecordedLandings, results: Table, order: Sequence[int], rank: Column | None
) -> Sheet:
    """The table of landings with the columns that people read."""
    keys = ["landing"]
    # One contact is in the header.
    several = len(set(study.table.labels["contact"].tolist())) > 1
    for name in study.table.labels:
        if name != "name" and (name != "contact" or several):
            keys.append(name)
    keys += [column.name for column in _shown(results)]
    if results.messages:
        keys.append("message")
    title = "landings" if rank is None else f"landings, ranked by {rank.name}"
    return _rows(results, order).only(*keys)._replace(title=title)


def _shown(results: Table) -> list[Column]:
    """The columns that people read: what was asked for, and the energy made if there is some."""
    return [
        column
        for column in results.computed
        if column in results.main or (results.columns[column.name] > 0.0).any()
    ]


def agreement_sheet(validation: Validation, full: bool = False, intervals: bool = False) -> Sheet:
    """Agreement of measured and predicted jumps.

    Each quantity has a row, each statistic a column.

    Args:
        validation: the comparison.
        full: whether single quantities are listed besides their groups.
        intervals: whether the statistics have their intervals.
    """
    header: list[str | Heading] = ["joint model", "after [ms]", "quantity", "unit", "n"]
    for name in STATISTICS:
        key = name.replace(" (", "_").removesuffix(")")
        header.append(Heading(key, name))
        if intervals:
            header += [Heading(f"{key}_low", f"{name} low"), Heading(f"{key}_high", f"{name} high")]
    rows: list[Row] = []
    for agreement in validation.agreements:
        if full or agreement.group:
            after = None if agreement.time is None else 1e-3 * agreement.time
            row: list[Cell] = [
                agreement.model,
                after,
                agreement.name,
                agreement.unit,
                agreement.n,
            ]
            for name in STATISTICS:
                value, low, high = agreement.statistics[name]
                row += [value, low, high] if intervals else [value]
            rows.append(tuple(row))
    return Sheet("measured against predicted jumps", header, rows, MEASURED_NOTES)


def _closing(
    study: RecordedLandings, results: Table, validation: Validation | None
) -> Iterator[str]:
    columns = results.columns
    if study.closes and not np.isnan(columns[CLOSED_BY]).all():
        by = float(np.nanmax(columns[CLOSED_BY]))
        rates_by = float(np.nanmax(columns[RATES_BY]))
        yield (
            f"loops: closing them changes positions of the table by at most {by:.2g} rad (m), "
            f"rates by {rates_by:.2g} rad/s (m/s)"
        )
    if len(results.messages) < study.rows:
        empty = [column for column in results.computed if np.isnan(columns[column.name]).all()]
        yield from without_value((column.name, column.selection.quantity) for column in empty)
    if study.first.scene.yields:
        yield LEFT_OUT
    # Of the rows without a proof in the table, those that were compared with one.
    proven = columns["proven"].astype(bool)
    errors = columns["double_error"][~proven]
    errors = errors[~np.isnan(errors)]
    compared = errors.size if any(column.shock for column in results.computed) else 0
    yield from proof_lines(int(proven.sum()), compared, errors.max(initial=0.0), results.computed)
    # A quantity that some landings lack; those without any value are named above.
    computed = np.array([i not in results.messages for i in range(study.rows)])
    for column in results.computed:
        missing = int(np.sum(np.isnan(columns[column.name]) & computed))
        if 0 < missing < np.sum(computed):
            why = column.selection.quantity.scope.missing or "it does not exist there"
            yield f"no {column.name} in {count(missing, 'landing')}: {why}"
    names = study.table.names
    refused = [(str(names[i]), text) for i, text in results.messages.items()]
    yield from _without_result("computed", refused)
    if validation is not None:
        failures = [(f"{row} ({model})", text) for model, row, text in validation.failures]
        yield from _without_result("predicted", failures)


def _without_result(verb: str, messages: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Lines on landings that were not computed, or not predicted, each with its message."""
    if messages:
        yield f"not {verb}: {count(len(messages), 'landing')}"
        yield from (f"  {line}" for line in cause_lines(causes(messages), "landings", MESSAGES))


def _making_energy(study: RecordedLandings, results: Table) -> Iterator[str]:
    """A warning of rows that are no landings, because restitution would make energy.

    With friction these rows slide.
    """
    names = [
        column.name
        for column in results.computed
        if column.selection.quantity.relations.role == "gain"
    ]
    (name,) = names
    gained = np.nan_to_num(results.columns[name])
    if study.by_friction:
        gained = np.where(np.isnan(study.table.friction), gained, 0.0)
    n = int(np.sum(gained > 0.0))
    if n:
        worst = study.table.names[int(gained.argmax())]
        yield (
            f"warning: the impact would gain kinetic energy in {n} of "
            f"{count(study.rows, 'landing')}, which is not feasible, at most {gained.max():.3g} J "
            f"in landing {worst}; take less restitution, the same for all contacts, or "
            "--restitution-along directions"
        )


def _warnings(landings: RecordedLandings) -> Iterator[str]:
    yield from (f"warning: {text}" for text in landings.table.warnings)
    yield from (
        f"warning: {warning}" for warning in landings.first.warnings if warning.kind == "scene"
    )
    for joint in landings.robot.single_joints:
        low, high = joint.limits
        if joint.name in landings.table.joints and joint.kind in ("revolute", "prismatic"):
            values = landings.table.Q[:, joint.q.start]
            outside = np.maximum(low - values, values - high)
            if n := int(np.sum(outside > 1e-4)):
                most = shown_as(float(outside.max()), joint.unit)
                yield (
                    f'warning: joint "{joint.name}" is outside its limits in '
                    f"{count(n, 'landing')}, by at most {most}"
                )
