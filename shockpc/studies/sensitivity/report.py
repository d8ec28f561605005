"""What changes a number of a landing: one row for every parameter, the largest effect first."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from shockpc.evaluation.drive_ends import BETWEEN, BEYOND, MOVED
from shockpc.show.document import record
from shockpc.show.header import shared_lines, shared_warnings
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Lines, Sheet, sheet_of
from shockpc.show.wording import shown_as
from shockpc.studies.sensitivity.study import Effect, Sensitivity
from shockpc.text.errors import ShockError
from shockpc.text.printed import count, listed

ROWS = 16
"""Rows of the table on a terminal."""


def sensitivity_report(study: Sensitivity) -> Report:
    """The effects."""
    landings = dict(zip(study.landings, study.profiles, strict=True))
    now = f"{study.target.title}: {study.value:.4g} {study.target.unit}".removesuffix(" -")
    if len(landings) > 1:
        now += f", {_over(study)}; the worst is {study.worst}"
    picture = Picture(
        "sensitivity",
        f"the largest effects on the {study.target.title}",
        "studies.sensitivity.figure:draw_tornado",
        (study,),
    )
    return Report(
        name="sensitivity",
        title=f"What changes the {study.target.title}",
        body=lambda full: [
            Lines([*shared_lines(landings), ("target", now)]),
            *([picture] if study.ranked else []),
            _table(study, None if full else ROWS),
        ],
        closing=_over_drives(study),
        warnings=shared_warnings(landings),
        sheets={"sensitivity": lambda: _effects(study), "derivatives": lambda: _derivatives(study)}
        | ({"drives": lambda: _drives(study)} if study.ends else {}),
        document=lambda: _document(study),
        tables=True,
    )


def _moves(study: Sensitivity) -> bool:
    """Whether the number, or one of the largest effects on it, differs by more than 1 % between the
    ends of the drives.
    """
    for found in study.ends.values():
        if isinstance(found, ShockError):
            return True
        effects = {one.parameter: one.up for one in found.ranked}
        pairs = [
            (study.value, found.value),
            *((one.up, effects.get(one.parameter)) for one in study.ranked[:ROWS]),
        ]
        if any(b is None or not math.isclose(a, b, rel_tol=MOVED) for a, b in pairs):
            return True
    return False


def _over_drives(study: Sensitivity) -> list[str]:
    """How the answer depends on the drives."""
    if not study.ends:
        return []
    if not _moves(study):
        return [
            f"drives: from {BETWEEN}, neither the number nor any of the largest effects changes by "
            f"more than 1 %"
        ]
    lines = [f"drives: the effects change from {BETWEEN}; {BEYOND}"]
    for words, found in (
        ("as modelled", study),
        *((f"{end} inertias", found) for end, found in study.ends.items()),
    ):
        if isinstance(found, ShockError):
            lines.append(f"  {words}: none, because {found}")
            continue
        number = f"{study.target.title} {found.value:.4g} {study.target.unit}".removesuffix(" -")
        largest = (
            f"; the largest effect is that of {found.ranked[0].parameter}" if found.ranked else ""
        )
        lines.append(f"  {words}: {number}{largest}")
    return lines


def _drives(study: Sensitivity) -> Sheet:
    """The change of the number by each step, as a share of it, as modelled and with the ends of the
    drives.
    """
    name = study.target.selection.name
    header = ["parameter", f"change of {name} [%]", *(f"{end} [%]" for end in study.ends)]
    shares = [_shares(study), *(_shares(found) for found in study.ends.values())]
    rows = [
        (one.parameter, *(share.get(one.parameter) for share in shares)) for one in study.ranked
    ]
    note = "smallest, largest: the change with the smallest and the largest possible inertias"
    return Sheet(f"effect on the {study.target.title}, by the drives", header, rows, [note])


def _shares(study: Sensitivity | ShockError) -> dict[str, float]:
    """The change by each step as a share of the number, by parameter; none of a number that is
    zero.
    """
    if isinstance(study, ShockError) or not study.value:
        return {}
    return {one.parameter: one.up / study.value for one in study.ranked}


def _over(study: Sensitivity) -> str:
    return f"{'mean' if study.mean else 'the worst'} of {count(len(study.landings), 'landing')}"


def step_words(change: Effect) -> str:
    """How far it is changed: a share, an angle or a length."""
    if not math.isnan(change.share):
        return f"{100.0 * change.share:.3g} %"
    return shown_as(change.step, change.unit).removesuffix(" -")


def _document(study: Sensitivity) -> dict[str, Any]:
    """What is no table of the document."""
    return {
        "target": study.target.name,
        "unit": study.target.selection.quantity.unit,
        "worse": study.target.selection.quantity.worse,
        "over": "mean" if study.mean else "worst",
        **record(study, "value", "percent"),
        "landings": [
            {
                "landing": name or None,
                "value": float(value),
                "warnings": profile.health.warnings,
                "scene": profile.scene,
            }
            for name, value, profile in zip(
                study.landings, study.values, study.profiles, strict=True
            )
        ],
    }


def _effects(study: Sensitivity) -> Sheet:
    """A row for each effect, the largest first, then those without a derivative, with the reason;
    also by the drives.
    """
    sheet = sheet_of(replace(study.table, messages={}))
    effects = (*study.ranked, *(effect for effect in study.effects if effect.reason))
    drives = _drives(study)
    ends, nothing = {one[0]: one[2:] for one in drives.rows}, [None] * len(study.ends)
    rows = [
        (*row, *ends.get(effect.parameter, nothing), step_words(effect), effect.reason or None)
        for row, effect in zip(sheet.rows, effects, strict=True)
    ]
    order = [0, 1, 2, 3, -2, *range(4, len(sheet.header) + len(study.ends)), -1]
    header = (*sheet.header, *drives.header[2:], "change", "reason")
    return sheet._replace(
        header=[header[k] for k in order], rows=[[row[k] for k in order] for row in rows]
    )


def _derivatives(study: Sensitivity) -> Sheet:
    """The derivative of the number in each landing by each parameter, in its unit over that of the
    parameter.
    """
    unit = study.target.selection.quantity.unit
    rows = [
        (
            effect.parameter,
            name or None,
            value,
            f"{unit}/{effect.unit}".replace("-/-", "-").replace("-/", "1/").removesuffix("/-"),
        )
        for effect in study.effects
        for name, value in zip(study.landings, np.asarray(effect.derivatives).tolist(), strict=True)
    ]
    return Sheet("derivatives", ("parameter", "landing", "derivative", "unit"), rows)


def _table(study: Sensitivity, most: int | None) -> Sheet:
    """The effects of one step. Args: most, number of rows; None for all."""
    single, whole = len(study.landings) == 1, _effects(study)
    hidden = [
        column.key
        for column in whole.columns
        if column.key.startswith("error_") or (single and column.key[:9] == "opposite_")
    ]
    moves = _moves(study)
    hidden += [] if moves else study.ends
    known = whole.where(lambda row: row["reason"] is None).without("step", "reason", *hidden)
    known = known._replace(notes=_drives(study).notes if moves else ())
    sheet = known.largest(most, "parameter", range(len(known.rows), 0, -1))
    without: dict[str, list[str]] = {}
    for effect in study.effects:
        if effect.reason:
            without.setdefault(effect.reason, []).append(effect.parameter)
    opposite = (
        "a change of the opposite sign has the opposite effect"
        if single or study.mean
        else "another landing may become the worst"
    )
    shown = study.ranked[: len(sheet.rows)]
    accuracy = (
        f"derivatives are differences, with an error of at most "
        f"{max(study.error(shown), 1e-15):.0e} of each"
    )
    notes = [
        "as in sweep: point-mass, com and inertia are added to a link; with its mass the inertia "
        "changes in proportion",
        "1 % of an inertia: of the mean moment of the link, or of an armature, without one of the "
        "inertia that the joint moves",
        f"to first order: {opposite}; the effect of a larger change is not in proportion",
        *sheet.notes,
        *([accuracy] if shown else []),
        *(
            f"{listed(names, 4)}: no derivative, because {reason}"
            for reason, names in without.items()
        ),
    ]
    title = f"effect on the {study.target.title}{'' if single else f', {_over(study)}'}"
    return sheet._replace(title=title, notes=notes)
