"""Joint limits that a bound on a number sets: for every strike angle the values allowed, and the
number in every posture.
"""

import math
from collections.abc import Sequence
from typing import Any

from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND
from shockpc.evaluation.kinds.contacts import OfGround
from shockpc.evaluation.kinds.registry import KINDS
from shockpc.show.header import header_lines, warning_lines
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Row, Sheet, sheet_of
from shockpc.studies.limits.study import JointLimits
from shockpc.text.errors import ShockError
from shockpc.text.printed import in_degrees

ENDS = {
    "range": "the range of the study ends there, which is no limit",
    "loop": "the loop cannot be closed beyond",
    "ground": "flat ground begins or ceases to allow the landing",
}
"""What ends an interval besides the bound."""

ROWS = 12
"""Postures of the table on a terminal, about."""


def limits_report(study: JointLimits) -> Report:
    """The limits of a joint."""
    unit = f" {study.shown_unit}".removesuffix(" -")
    low, high, step = (study.shown(value) for value in (*study.range, study.step))
    scan = f"{study.subject} from {low:g} to {high:g}{unit}, scanned in steps of {step:g}{unit}"
    if study.of_joints:
        least, greatest = (
            f"{study.shown(end):g}" if math.isfinite(end) else "none" for end in study.file_limits
        )
        scan += f"; the file's limits are {least} and {greatest}"
    return Report(
        name="limits",
        title=f"Limits of {study.subject} for the {study.target.title}",
        body=lambda full: [
            Lines([*header_lines(study.profile), ("joint" if study.of_joints else "varied", scan)]),
            Picture(
                "limits",
                f"{study.target.title} over {study.subject} and strike angle",
                "studies.limits.figure:draw_limits",
                (study,),
            ),
            _allowed(study),
            _best(study),
            _postures(study, None if full else ROWS),
        ],
        closing=[*(_no_dependence(study) or _none_allowed(study)), *_over_drives(study)],
        warnings=_warnings(study),
        sheets={
            "limits": lambda: _allowed(study),
            "best": lambda: _best(study),
            "postures": lambda: _postures(study),
        }
        | ({"drives": lambda: _drives(study)} if study.ends else {}),
        document=lambda: _document(study),
        tables=True,
    )


def _over_drives(study: JointLimits) -> list[str]:
    """How the limits depend on the drives: those of both ends for the strike of the scene where
    they move.
    """
    if not study.ends:
        return []
    if not any(isinstance(one, ShockError) or study.moves(one) for one in study.ends.values()):
        least = {"rad": "1 degree", "m": "1 cm"}.get(study.unit, "1 % of the range")
        return [f"drives: from {BETWEEN}, no limit moves by more than {least}"]
    lines = [
        f"drives: the limits move from {BETWEEN}; {BEYOND}",
        f"  as modelled: {_allowed_words(study)}",
    ]
    for end, found in study.ends.items():
        words = f"none, because {found}" if isinstance(found, ShockError) else _allowed_words(found)
        lines.append(f"  {end} inertias: {words}")
    return lines


def _allowed_words(study: JointLimits) -> str:
    """What is allowed at the strike of the scene, and at all strikes of the range."""
    first, last, unit = study.limits[0], study.limits[-1], f" {study.shown_unit}".removesuffix(" -")
    texts = []
    for one, where in ((first, "at the scene's strike angle"), (last, "at all strike angles")):
        pieces = [
            f"{study.shown(low):.4g} to {study.shown(high):.4g}{unit}" for low, high in one.usable
        ]
        texts.append(f"{' and '.join(pieces) or 'no value'} {where}")
    return "; ".join(dict.fromkeys(texts))


def _drives(study: JointLimits) -> Sheet:
    """The rows of `_allowed` with the smallest and the largest inertias of the drives."""
    header: Sequence[str | Column] = _allowed(study).header
    rows: list[Row] = []
    for end, found in study.ends.items():
        if isinstance(found, ShockError):
            rows.append((end, *(None,) * len(header)))
            continue
        rows += [(end, *row) for row in _allowed(found).rows]
    return Sheet(AT_BOTH, ("drives", *header), rows)


def _no_dependence(study: JointLimits) -> list[str]:
    """That the number is the same for all values, where that is the answer."""
    if not study.unchanged:
        return []
    keeps = "every value keeps" if study.limits[-1].allowed else "no value keeps"
    if any(one.allowed for one in study.limits) and not study.limits[-1].allowed:
        keeps = "at some strike angles every value keeps"
    text = (
        f"{study.target.name} does not depend on {study.subject} in this range: {keeps} the bound"
    )
    if isinstance(
        KINDS.get(study.subject), OfGround
    ) and not study.target.selection.quantity.of_ground(study.profile.scene):
        text += (
            "; it is of rigid contacts that stick; name a quantity that depends on the ground, "
            "such as shock_friction or peak_force"
        )
    return [text]


def _none_allowed(study: JointLimits) -> list[str]:
    """That no value keeps the bound, or none that does is feasible, where that is the answer."""
    if any(one.usable for one in study.limits):
        return []
    rows = [one for one in study.limits if not math.isnan(one.best)]
    best = min(rows, key=lambda one: study.bound.sign * one.best, default=None)
    text = (
        f"no value of {study.subject} keeps {study.target.name} {_bound(study)} at any of these "
        f"strike angles"
    )
    if any(one.allowed for one in study.limits):
        text += " where flat ground allows the landing"
    if best is not None:
        text += (
            f"; the best that is feasible is {best.best:.3g} at {study.shown(best.best_at):.4g} "
            f"{study.shown_unit}"
        )
    remedy = "allow more, or give another range with --range"
    if not any(one.feasible for one in study.limits):
        remedy = (
            "flat ground allows no landing of this range; give another with --range, or a greater "
            "--ground-tolerance"
        )
    return [f"{text}; {remedy}"]


def _warnings(study: JointLimits) -> list[str]:
    warnings = warning_lines(study.profile)
    for low, high, reason in study.scan.unreachable:
        ends = f"{study.shown(low):.4g} to {study.shown(high):.4g} {study.shown_unit}"
        warnings.append(f"warning: from {ends} there is no result: {reason}")
    n = len(study.scan.values)
    if study.scan.inaccurate:
        warnings.append(
            f"warning: in {study.scan.inaccurate} of {n} postures the equations are "
            f"ill-conditioned; "
            "double precision may be off by more than 1e-9 there: compare with shockpc analyze"
        )
    if study.profile.scene.friction is not None and not study.target.selection.quantity.of_ground(
        study.profile.scene
    ):
        warnings.append(
            "warning: the friction changes only the column feasible, as contacts slide and open "
            "with it; the bounded "
            "number is for contacts that stick"
        )
    if study.target.selection.quantity.per_landing(study.profile.scene):
        warnings.append(
            f"warning: {study.target.name} is computed in one posture and for one strike at a "
            f"time; "
            "--step, --range and --strikes say how many of them"
        )
    at_scene, every = (
        int((~study.scan.feasible(strikes)).sum())
        for strikes in (study.limits[0].strikes, study.strikes)
    )
    if at_scene or every:
        warnings.append(
            f"warning: flat ground does not allow {at_scene} of {n} postures at the scene's "
            f"strike, and {every} at some strike of the range: a contact would have to be pulled, "
            "the impact would gain energy, or another link is lower or contacts differ in height "
            f"by more than {1e3 * study.profile.scene.ground_tolerance:g} mm "
            "(--ground-tolerance); column feasible"
        )
    return warnings


def _document(study: JointLimits) -> dict[str, Any]:
    """What is no table of the document: angles in degrees, positions in metres."""

    def value(number: float) -> float:
        return in_degrees(number) if study.unit == "rad" else round(number, 9) + 0.0

    return {
        "scene": study.profile.scene,
        "target": study.target.name,
        "target_unit": study.target.selection.quantity.unit,
        "joints": study.joints,
        "unit": study.unit.replace("rad", "deg"),
        "max": None if study.bound.below else study.bound.value,
        "min": study.bound.value if study.bound.below else None,
        "warnings": study.profile.health.warnings,
        "range": tuple(map(value, study.range)),
        "file_limits": tuple(map(value, study.file_limits)),
        "step": value(study.step),
        "strike_angles_deg": tuple(map(in_degrees, study.strikes)),
        "unreachable": [
            {"low": value(a), "high": value(b), "reason": reason}
            for a, b, reason in study.scan.unreachable
        ],
        "inaccurate_postures": study.scan.inaccurate,
    }


def _allowed(study: JointLimits) -> Sheet:
    """For every strike angle the intervals of values that keep the bound, and whether flat ground
    allows them.
    """
    ends = {end for one in study.limits for piece in one.pieces for end in piece[2:4]}
    notes = [f"{end}: {words}" for end, words in ENDS.items() if end in ends]
    sheet = sheet_of(
        study.table,
        f"values of {study.subject} that keep {study.target.name} {_bound(study)}",
        notes,
    )
    rows = [(*row[:-1], {"yes": True, "no": False}.get(str(row[-1]))) for row in sheet.rows]
    return sheet._replace(header=[*sheet.header[:-1], "feasible"], rows=rows)


def _best(study: JointLimits) -> Sheet:
    """For every strike angle the best number where flat ground allows the landing, of the worst of
    several strikes.
    """
    number, unit = (
        f"best {study.target.selection.name} [{study.target.unit}]",
        f"at [{study.shown_unit}]",
    )
    rows = [
        (*map(in_degrees, one.strikes), one.best, study.shown(one.best_at)) for one in study.limits
    ]
    title = f"best {study.target.title} where flat ground allows the landing"
    return Sheet(title, ("strike from [deg]", "strike to [deg]", number, unit), rows)


def _postures(study: JointLimits, most: int | None = None) -> Sheet:
    """For every posture of the scan the number at the scene's strike, and at the worst strike of
    the range.

    Args:
        study: the limits.
        most: number of postures, about; None for all.
    """
    worst, at = study.worst
    every = 1 if most is None else _every(study, most)
    varied, unit = "joint" if study.of_joints else study.subject, study.target.unit
    header = (
        f"{varied} [{study.shown_unit}]",
        f"at the scene's strike [{unit}]",
        f"worst [{unit}]",
        "at strike angle [deg]",
    )
    scan = study.scan
    rows: list[Row] = [
        (
            study.shown(float(scan.values[k])),
            float(scan.at_scene_strike[k]),
            float(worst[k]),
            in_degrees(at[k]),
        )
        for k in range(0, len(scan.values), every)
    ]
    low, high = map(math.degrees, study.strikes)
    notes = () if every == 1 else (f"every {every}th value of the scan; --out writes all",)
    return Sheet(
        f"{study.target.title} over strike angles from {low:g} to {high:g} deg", header, rows, notes
    )


def _every(study: JointLimits, most: int) -> int:
    """Step through the scan with at most about so many rows, at round values where the scan has
    them.
    """
    least = max(math.ceil((len(study.scan.values) - 1) / most), 1)
    return next(
        (k for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if k >= least), least
    )


def _bound(study: JointLimits) -> str:
    side = "above" if study.bound.below else "below"
    return f"at or {side} {study.bound.value:g} {study.target.unit}".removesuffix(" -")
