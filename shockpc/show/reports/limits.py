"""Joint limits that a bound on a number sets: for every strike angle the values allowed, for every posture the strike angles."""

import math
from collections.abc import Callable
from typing import Any

from shockpc.evaluation.variation import OF_THE_GROUND
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import header_lines, warning_lines
from shockpc.studies.limits import JointLimits, StrikeLimits

MARKS = {"bound": "", "range": "*", "loop": "†"}

ENDS = {"range": "end of the range, not a limit", "loop": "the loop cannot be closed beyond"}

ROWS, RECORDS = 12, 100
"""Postures of the table for people and of the document, about."""


def limits_report(found: JointLimits) -> Report:
    """The limits of a joint."""
    unit = f" {found.shown_unit}".removesuffix(" -")
    low, high, step = (found.shown(value) for value in (*found.range, found.step))
    scan = f"{found.subject} from {low:g} to {high:g}{unit}, scanned in steps of {step:g}{unit}"
    if found.of_joints:
        least, greatest = (f"{found.shown(end):g}" if math.isfinite(end) else "none" for end in found.file_limits)
        scan += f"; the file's limits are {least} and {greatest}"
    return Report(
        name="limits",
        title=f"Limits of {found.subject} for the {found.target.title}",
        body=lambda _: [
            Lines([*header_lines(found.profile), ("joint" if found.of_joints else "varied", scan)]),
            Picture("limits", f"{found.target.title} over {found.subject} and strike angle", "limits:draw_limits", (found,)),
            _allowed(found),
            _postures(found, ROWS),
        ],
        closing=_no_dependence(found) or _none_allowed(found),
        warnings=_warnings(found),
        sheets={"limits": lambda: sheet_of(found.table), "postures": lambda: _postures(found)},
        document=lambda: _document(found),
    )


def _no_dependence(found: JointLimits) -> list[str]:
    """That the number is the same for all values, where that is the answer."""
    if not found.unchanged:
        return []
    keeps = "every value keeps" if found.limits[-1].allowed else "no value keeps"
    if any(one.allowed for one in found.limits) and not found.limits[-1].allowed:
        keeps = "at some strike angles every value keeps"
    text = f"{found.target.name} does not depend on {found.subject} in this range: {keeps} the bound"
    if found.subject in OF_THE_GROUND and not found.target.selection.quantity.of_ground(found.profile.scene):
        text += (
            "; it is of rigid contacts that stick; name a quantity that depends on the ground, such as shock_friction or peak_force"
        )
    return [text]


def _none_allowed(found: JointLimits) -> list[str]:
    """That no value keeps the bound, or none that does is feasible, where that is the answer."""
    if any(one.usable for one in found.limits):
        return []
    rows = [one for one in found.limits if not math.isnan(one.best)]
    best = min(rows, key=lambda one: found.bound.sign * one.best, default=None)
    text = f"no value of {found.subject} keeps {found.target.name} {_bound(found)} at any of these strike angles"
    if any(one.allowed for one in found.limits):
        text += " where flat ground allows the landing"
    if best is not None:
        text += (
            f"; the {_extremes(found)[0]} that is feasible is {best.best:.3g} at {_text(found, best.best_at)} {found.shown_unit}"
        )
    remedy = "allow more, or give another range with --range"
    if not any(one.feasible for one in found.limits):
        remedy = "flat ground allows no landing of this range; give another with --range, or a greater --ground-tolerance"
    return [f"{text}; {remedy}"]


def _warnings(found: JointLimits) -> list[str]:
    warnings = warning_lines(found.profile)
    for low, high, reason in found.scan.unreachable:
        ends = f"{_text(found, low)} to {_text(found, high)} {found.shown_unit}"
        warnings.append(f"warning: from {ends} there is no result: {reason}")
    n = len(found.scan.values)
    if found.scan.inaccurate:
        warnings.append(
            f"warning: in {found.scan.inaccurate} of {n} postures the equations are ill-conditioned; "
            "double precision may be off by more than 1e-9 there: compare with shockpc analyze"
        )
    if found.profile.scene.friction is not None and not found.target.selection.quantity.of_ground(found.profile.scene):
        warnings.append(
            "warning: the friction counts in the column feasible alone, as contacts slide and open with it; the number bounded "
            "is that of contacts that stick"
        )
    if found.target.selection.quantity.per_landing(found.profile.scene):
        warnings.append(
            f"warning: {found.target.name} is computed in one posture and for one strike at a time; "
            "--step, --range and --strikes say how many of them"
        )
    at_scene, every = (int((~found.scan.feasible(*strikes)).sum()) for strikes in (found.limits[0].strikes, found.strikes))
    if at_scene or every:
        warnings.append(
            f"warning: flat ground does not allow {at_scene} of {n} postures at the scene's strike, and {every} at some strike of "
            "the range: a contact would have to be pulled, another link is lower or contacts differ in height by more than "
            f"{1e3 * found.profile.scene.ground_tolerance:g} mm (--ground-tolerance), or friction makes energy; column feasible"
        )
    return warnings


def _document(found: JointLimits) -> dict[str, Any]:
    """The document, schema `shockpc.limits/1`: angles in degrees, positions in metres."""
    worst, at = found.worst
    best_word, worst_word = _extremes(found)

    def value(number: float) -> float:
        return _degrees(number) if found.unit == "rad" else round(number, 9) + 0.0

    return {
        "scene": found.profile.scene,
        "target": found.target.name,
        "target_unit": found.target.selection.quantity.unit,
        "joints": found.joints,
        "unit": found.unit.replace("rad", "deg"),
        "max": None if found.bound.below else found.bound.value,
        "min": found.bound.value if found.bound.below else None,
        "warnings": found.profile.health.warnings,
        "range": tuple(map(value, found.range)),
        "file_limits": tuple(map(value, found.file_limits)),
        "step": value(found.step),
        "strike_angles_deg": tuple(map(_degrees, found.strikes)),
        "limits": [
            {
                "strike_angles_deg": tuple(map(_degrees, one.strikes)),
                "allowed": tuple(i._replace(low=value(i.low), high=value(i.high)) for i in one.allowed),
                "feasible": [tuple(map(value, run)) for run in one.feasible],
                "allowed_and_feasible": [tuple(map(value, run)) for run in one.usable],
                best_word: one.best,
                f"{best_word}_at": value(one.best_at),
            }
            for one in found.limits
        ],
        "postures": [
            {
                "value": value(float(found.scan.values[k])),
                worst_word: worst[k],
                f"{worst_word}_at_strike_angle_deg": _degrees(at[k]),
                "allowed_strike_angles_deg": [tuple(map(_degrees, part)) for part in found.allowed_strikes[k]],
            }
            for k in range(0, len(found.scan.values), _every(found, RECORDS))
        ],
        "unreachable": [{"low": value(a), "high": value(b), "reason": reason} for a, b, reason in found.scan.unreachable],
        "inaccurate_postures": found.scan.inaccurate,
    }


def _allowed(found: JointLimits) -> Sheet:
    """For every strike angle the values of the joint that keep the bound."""
    rows: list[Row] = []
    for one in found.limits:
        runs = (", ".join(_run(found, *run) for run in runs) or "none" for runs in (one.allowed, one.feasible, one.usable))
        rows.append((_strikes(found, one), *runs, one.best, None if math.isnan(one.best) else _text(found, one.best_at)))
    ends = {end for one in found.limits for interval in one.allowed for end in interval[2:]}
    name, unit = found.target.selection.name, found.shown_unit
    return Sheet(
        f"values of {found.subject} that keep {found.target.name} {_bound(found)}",
        (
            "strike angle [deg]",
            f"allowed [{unit}]",
            f"feasible [{unit}]",
            f"both [{unit}]",
            f"{_extremes(found)[0]} {name} [{found.target.unit}]",
            f"at [{unit}]",
        ),
        rows,
        [f"{MARKS[end]} {words}" for end, words in ENDS.items() if end in ends],
    )


def _postures(found: JointLimits, most: int | None = None) -> Sheet:
    """For every posture the worst strike, and the strikes that keep the bound. Args: most, number of rows, about."""
    worst, at = found.worst
    every = 1 if most is None else _every(found, most)
    rows: list[Row] = []
    for k in range(0, len(found.scan.values), every):
        allowed = ", ".join(f"{math.degrees(a):.1f} … {math.degrees(b):.1f}" for a, b in found.allowed_strikes[k]) or "none"
        value = _text(found, float(found.scan.values[k]))
        rows.append((value, found.scan.at_scene_strike[k], worst[k], f"{math.degrees(at[k]):.1f}", allowed))
    low, high = map(math.degrees, found.strikes)
    varied = "joint" if found.of_joints else found.subject
    unit = found.target.unit
    header = (
        f"{varied} [{found.shown_unit}]", f"at the scene's strike [{unit}]", f"{_extremes(found)[1]} [{unit}]",
        "at strike angle [deg]", "strike angles allowed [deg]",
    )  # fmt: skip
    notes = () if every == 1 else (f"every {every}th value of the scan; --out writes all",)
    return Sheet(f"{found.target.title} over strike angles from {low:g} to {high:g} deg", header, rows, notes)


def _every(found: JointLimits, most: int) -> int:
    """Step through the scan with at most about so many rows, at round values where the scan has them."""
    least = max(math.ceil((len(found.scan.values) - 1) / most), 1)
    return next((k for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if k >= least), least)


def _strikes(found: JointLimits, one: StrikeLimits) -> str:
    """The strike angles of a row."""
    low, high = (f"{round(math.degrees(angle), 4) + 0.0:g}" for angle in one.strikes)
    if one.strikes[0] < one.strikes[1]:
        return f"any of {low} … {high}"
    return f"{low}, the scene's" if one is found.limits[0] else low


def _run(found: JointLimits, low: float, high: float, low_end: str = "bound", high_end: str = "bound") -> str:
    """A range of values, rounded inwards to four digits; signs where something else than the bound ends an allowed one."""
    return f"{_text(found, low, math.ceil)}{MARKS[low_end]} … {_text(found, high, math.floor)}{MARKS[high_end]}"


def _text(found: JointLimits, value: float, whole: Callable[[float], int] = round) -> str:
    """A value in the unit of tables: of a joint to four digits and two decimals, else to four digits of the greatest of the range.

    Args:
        found: the limits.
        value: in SI units.
        whole: how it becomes a whole number of its last digit.
    """
    value = found.shown(value)
    most = abs(value) if found.of_joints else max(abs(found.shown(end)) for end in found.range)
    decimals = max(0, 3 - math.floor(math.log10(most * (1.0 + 5e-5) or 1.0)))
    decimals = min(decimals, 2) if found.of_joints else decimals
    # An end that is a round number but for rounding errors stays one.
    return f"{whole(round(value * 10.0**decimals, 4)) / 10.0**decimals:.{decimals}f}"


def _bound(found: JointLimits) -> str:
    side = "above" if found.bound.below else "below"
    return f"at or {side} {found.bound.value:g} {found.target.unit}".removesuffix(" -")


def _extremes(found: JointLimits) -> tuple[str, str]:
    """Words for the best and for the worst value."""
    return ("greatest", "least") if found.bound.below else ("least", "greatest")


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 9) + 0.0
