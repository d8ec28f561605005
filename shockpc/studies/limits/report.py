"""Joint limits that a bound on a number sets: for every strike angle the values allowed, for every posture the strike angles."""

import math
from collections.abc import Callable
from typing import Any

from shockpc.evaluation.variation import OF_THE_GROUND
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import header_lines, warning_lines
from shockpc.studies.limits.study import JointLimits, StrikeLimits
from shockpc.text.printed import in_degrees

MARKS = {"bound": "", "range": "*", "loop": "†"}

ENDS = {"range": "end of the range, not a limit", "loop": "the loop cannot be closed beyond"}

ROWS, RECORDS = 12, 100
"""Postures of the table for people and of the document, about."""


def limits_report(study: JointLimits) -> Report:
    """The limits of a joint."""
    unit = f" {study.shown_unit}".removesuffix(" -")
    low, high, step = (study.shown(value) for value in (*study.range, study.step))
    scan = f"{study.subject} from {low:g} to {high:g}{unit}, scanned in steps of {step:g}{unit}"
    if study.of_joints:
        least, greatest = (f"{study.shown(end):g}" if math.isfinite(end) else "none" for end in study.file_limits)
        scan += f"; the file's limits are {least} and {greatest}"
    return Report(
        name="limits",
        title=f"Limits of {study.subject} for the {study.target.title}",
        body=lambda _: [
            Lines([*header_lines(study.profile), ("joint" if study.of_joints else "varied", scan)]),
            Picture(
                "limits",
                f"{study.target.title} over {study.subject} and strike angle",
                "studies.limits.figure:draw_limits",
                (study,),
            ),
            _allowed(study),
            _postures(study, ROWS),
        ],
        closing=_no_dependence(study) or _none_allowed(study),
        warnings=_warnings(study),
        sheets={"limits": lambda: sheet_of(study.table), "postures": lambda: _every_posture(study)},
        document=lambda: _document(study),
    )


def _no_dependence(study: JointLimits) -> list[str]:
    """That the number is the same for all values, where that is the answer."""
    if not study.unchanged:
        return []
    keeps = "every value keeps" if study.limits[-1].allowed else "no value keeps"
    if any(one.allowed for one in study.limits) and not study.limits[-1].allowed:
        keeps = "at some strike angles every value keeps"
    text = f"{study.target.name} does not depend on {study.subject} in this range: {keeps} the bound"
    if study.subject in OF_THE_GROUND and not study.target.selection.quantity.of_ground(study.profile.scene):
        text += (
            "; it is of rigid contacts that stick; name a quantity that depends on the ground, such as shock_friction or peak_force"
        )
    return [text]


def _none_allowed(study: JointLimits) -> list[str]:
    """That no value keeps the bound, or none that does is feasible, where that is the answer."""
    if any(one.usable for one in study.limits):
        return []
    rows = [one for one in study.limits if not math.isnan(one.best)]
    best = min(rows, key=lambda one: study.bound.sign * one.best, default=None)
    text = f"no value of {study.subject} keeps {study.target.name} {_bound(study)} at any of these strike angles"
    if any(one.allowed for one in study.limits):
        text += " where flat ground allows the landing"
    if best is not None:
        text += (
            f"; the {_extremes(study)[0]} that is feasible is {best.best:.3g} at {_text(study, best.best_at)} {study.shown_unit}"
        )
    remedy = "allow more, or give another range with --range"
    if not any(one.feasible for one in study.limits):
        remedy = "flat ground allows no landing of this range; give another with --range, or a greater --ground-tolerance"
    return [f"{text}; {remedy}"]


def _warnings(study: JointLimits) -> list[str]:
    warnings = warning_lines(study.profile)
    for low, high, reason in study.scan.unreachable:
        ends = f"{_text(study, low)} to {_text(study, high)} {study.shown_unit}"
        warnings.append(f"warning: from {ends} there is no result: {reason}")
    n = len(study.scan.values)
    if study.scan.inaccurate:
        warnings.append(
            f"warning: in {study.scan.inaccurate} of {n} postures the equations are ill-conditioned; "
            "double precision may be off by more than 1e-9 there: compare with shockpc analyze"
        )
    if study.profile.scene.friction is not None and not study.target.selection.quantity.of_ground(study.profile.scene):
        warnings.append(
            "warning: the friction counts in the column feasible alone, as contacts slide and open with it; the number bounded "
            "is that of contacts that stick"
        )
    if study.target.selection.quantity.per_landing(study.profile.scene):
        warnings.append(
            f"warning: {study.target.name} is computed in one posture and for one strike at a time; "
            "--step, --range and --strikes say how many of them"
        )
    at_scene, every = (int((~study.scan.feasible(*strikes)).sum()) for strikes in (study.limits[0].strikes, study.strikes))
    if at_scene or every:
        warnings.append(
            f"warning: flat ground does not allow {at_scene} of {n} postures at the scene's strike, and {every} at some strike of "
            "the range: a contact would have to be pulled, the impact would make energy, or another link is lower or contacts "
            f"differ in height by more than {1e3 * study.profile.scene.ground_tolerance:g} mm (--ground-tolerance); column feasible"
        )
    return warnings


def _document(study: JointLimits) -> dict[str, Any]:
    """The document, schema `shockpc.limits/1`: angles in degrees, positions in metres."""
    worst, at = study.worst
    best_word, worst_word = _extremes(study)

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
        "limits": [
            {
                "strike_angles_deg": tuple(map(in_degrees, one.strikes)),
                "allowed": tuple(i._replace(low=value(i.low), high=value(i.high)) for i in one.allowed),
                "feasible": [tuple(map(value, run)) for run in one.feasible],
                "allowed_and_feasible": [tuple(map(value, run)) for run in one.usable],
                best_word: one.best,
                f"{best_word}_at": value(one.best_at),
            }
            for one in study.limits
        ],
        "postures": [
            {
                "value": value(float(study.scan.values[k])),
                worst_word: worst[k],
                f"{worst_word}_at_strike_angle_deg": in_degrees(at[k]),
                "allowed_strike_angles_deg": [tuple(map(in_degrees, part)) for part in study.allowed_strikes[k]],
            }
            for k in range(0, len(study.scan.values), _every(study, RECORDS))
        ],
        "unreachable": [{"low": value(a), "high": value(b), "reason": reason} for a, b, reason in study.scan.unreachable],
        "inaccurate_postures": study.scan.inaccurate,
    }


def _allowed(study: JointLimits) -> Sheet:
    """For every strike angle the values of the joint that keep the bound."""
    rows: list[Row] = []
    for one in study.limits:
        runs = (", ".join(_run(study, *run) for run in runs) or "none" for runs in (one.allowed, one.feasible, one.usable))
        rows.append((_strikes(study, one), *runs, one.best, None if math.isnan(one.best) else _text(study, one.best_at)))
    ends = {end for one in study.limits for interval in one.allowed for end in interval[2:]}
    name, unit = study.target.selection.name, study.shown_unit
    return Sheet(
        f"values of {study.subject} that keep {study.target.name} {_bound(study)}",
        (
            "strike angle [deg]",
            f"allowed [{unit}]",
            f"feasible [{unit}]",
            f"both [{unit}]",
            f"{_extremes(study)[0]} {name} [{study.target.unit}]",
            f"at [{unit}]",
        ),
        rows,
        [f"{MARKS[end]} {words}" for end, words in ENDS.items() if end in ends],
    )


def _postures(study: JointLimits, most: int | None = None) -> Sheet:
    """For every posture the worst strike, and the strikes that keep the bound. Args: most, number of rows, about."""
    worst, at = study.worst
    every = 1 if most is None else _every(study, most)
    rows: list[Row] = []
    for k in range(0, len(study.scan.values), every):
        allowed = ", ".join(f"{math.degrees(a):.1f} … {math.degrees(b):.1f}" for a, b in study.allowed_strikes[k]) or "none"
        value = _text(study, float(study.scan.values[k]))
        rows.append((value, study.scan.at_scene_strike[k], worst[k], f"{math.degrees(at[k]):.1f}", allowed))
    low, high = map(math.degrees, study.strikes)
    varied = "joint" if study.of_joints else study.subject
    unit = study.target.unit
    header = (
        f"{varied} [{study.shown_unit}]", f"at the scene's strike [{unit}]", f"{_extremes(study)[1]} [{unit}]",
        "at strike angle [deg]", "strike angles allowed [deg]",
    )  # fmt: skip
    notes = () if every == 1 else (f"every {every}th value of the scan; --out writes all",)
    return Sheet(f"{study.target.title} over strike angles from {low:g} to {high:g} deg", header, rows, notes)


def _every_posture(study: JointLimits) -> Sheet:
    """The same with all digits, a row for each interval of the strikes that keep the bound; without ends where none does."""
    worst, at = study.worst
    of_joints, name, unit = "joint" if study.of_joints else study.subject, _extremes(study)[1], study.target.unit
    header = (
        f"{of_joints} [{study.shown_unit}]", f"at the scene's strike [{unit}]", f"{name} [{unit}]", "at strike angle [deg]",
        "least strike angle allowed [deg]", "greatest strike angle allowed [deg]",
    )  # fmt: skip
    rows: list[Row] = []
    for k, value in enumerate(study.scan.values.tolist()):
        numbers = study.shown(value), study.scan.at_scene_strike[k], worst[k], in_degrees(at[k])
        rows += [(*numbers, *map(in_degrees, kept)) for kept in study.allowed_strikes[k] or [(math.nan, math.nan)]]
    return Sheet("", header, rows)


def _every(study: JointLimits, most: int) -> int:
    """Step through the scan with at most about so many rows, at round values where the scan has them."""
    least = max(math.ceil((len(study.scan.values) - 1) / most), 1)
    return next((k for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if k >= least), least)


def _strikes(study: JointLimits, one: StrikeLimits) -> str:
    """The strike angles of a row."""
    low, high = (f"{round(math.degrees(angle), 4) + 0.0:g}" for angle in one.strikes)
    if one.strikes[0] < one.strikes[1]:
        return f"any of {low} … {high}"
    return f"{low}, the scene's" if one is study.limits[0] else low


def _run(study: JointLimits, low: float, high: float, low_end: str = "bound", high_end: str = "bound") -> str:
    """A range of values, rounded inwards to four digits; signs where something else than the bound ends an allowed one."""
    return f"{_text(study, low, math.ceil)}{MARKS[low_end]} … {_text(study, high, math.floor)}{MARKS[high_end]}"


def _text(study: JointLimits, value: float, whole: Callable[[float], int] = round) -> str:
    """A value in the unit of tables: of a joint to four digits and two decimals, else to four digits of the greatest of the range.

    Args:
        study: the limits.
        value: in SI units.
        whole: how it becomes a whole number of its last digit.
    """
    value = study.shown(value)
    most = abs(value) if study.of_joints else max(abs(study.shown(end)) for end in study.range)
    decimals = max(0, 3 - math.floor(math.log10(most * (1.0 + 5e-5) or 1.0)))
    decimals = min(decimals, 2) if study.of_joints else decimals
    # An end that is a round number but for rounding errors stays one.
    return f"{whole(round(value * 10.0**decimals, 4)) / 10.0**decimals:.{decimals}f}"


def _bound(study: JointLimits) -> str:
    side = "above" if study.bound.below else "below"
    return f"at or {side} {study.bound.value:g} {study.target.unit}".removesuffix(" -")


def _extremes(study: JointLimits) -> tuple[str, str]:
    """Words for the best and for the worst value."""
    return ("greatest", "least") if study.bound.below else ("least", "greatest")
