"""Joint limits that a bound on a number sets.

They are the values allowed for every strike angle, and the number in every posture.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND, answer_lines, any_moves
from shockpc.evaluation.unused_ground import NAME_ONE
from shockpc.evaluation.variations.kinds.registry import kind_and_target
from shockpc.show.header import header_lines, other_warning_lines
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Heading, Lines, Row, Sheet, sheet_of
from shockpc.studies.limits.intervals import StrikeLimits
from shockpc.studies.limits.study import JointLimits
from shockpc.text.errors import ShockError
from shockpc.text.printed import in_degrees

ENDS = {
    "range": "the range of the study ends there, which is no limit",
    "loop": "the loop cannot be closed beyond",
    "ground": "flat ground begins or ceases to allow the landing",
}
"""Reasons why an interval ends, besides the bound, in words."""

ROWS = 12
"""Postures of the table on a terminal, about."""

ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
"""Numbers of values of a scan between the rows of the table on a terminal."""

UNCHANGED = 1e-9
"""Share of a number by which rounding may change it."""

LEAST_MOVE = {"rad": "1 degree", "m": "1 cm"}
"""Least motion of a limit that is reported, by unit; 1 % of the range otherwise."""


def limits_report(limits: JointLimits) -> Report:
    """The limits of a joint."""
    sheets = {
        "limits": lambda: _allowed(limits),
        "best": lambda: _best(limits),
        "postures": lambda: _postures(limits),
    }
    if limits.ends:
        sheets["drives"] = lambda: _drives(limits)
    return Report(
        name="limits",
        title=f"Limits of {limits.subject} for the {limits.target.title}",
        body=lambda full: _body(limits, None if full else ROWS),
        closing=[*_no_dependence(limits), *_none_allowed(limits), *_over_drives(limits)],
        warnings=_warnings(limits),
        sheets=sheets,
        document=lambda: _document(limits),
        tables=True,
    )


def _body(limits: JointLimits, rows: int | None) -> list[Section]:
    """The sections. Args: limits; rows, of the table of postures, about, or all."""
    heading = "joint" if limits.of_joints else "varied"
    caption = f"{limits.target.title} over {limits.subject} and strike angle"
    return [
        Lines([*header_lines(limits.profile), (heading, _scan_text(limits))]),
        Picture("limits", caption, "studies.limits.figure:draw_limits", (limits,)),
        _allowed(limits),
        _best(limits),
        _postures(limits, rows),
    ]


def _scan_text(limits: JointLimits) -> str:
    """The quantity that varies, its range and the limits of the file."""
    unit = _unit(limits)
    low, high, step = (f"{limits.shown(value):g}" for value in (*limits.range, limits.step))
    text = f"{limits.subject} from {low} to {high}{unit}, scanned in steps of {step}{unit}"
    if limits.of_joints:
        least, greatest = (_limit_text(limits, limit) for limit in limits.file_limits)
        text += f"; the file's limits are {least} and {greatest}"
    return text


def _limit_text(limits: JointLimits, limit: float) -> str:
    return f"{limits.shown(limit):g}" if math.isfinite(limit) else "none"


def _unit(limits: JointLimits) -> str:
    """The unit of values after a number."""
    return f" {limits.shown_unit}".removesuffix(" -")


def _over_drives(limits: JointLimits) -> list[str]:
    """The limits at both ends of the drives, where they differ."""
    if not limits.ends:
        return []
    if not any_moves(limits.ends, limits.moves):
        least = LEAST_MOVE.get(limits.unit, "1 % of the range")
        return [f"drives: from {BETWEEN}, no limit moves by more than {least}"]
    head = f"drives: the limits move from {BETWEEN}; {BEYOND}"
    return [head, *answer_lines(limits, limits.ends, _allowed_words)]


def _allowed_words(limits: JointLimits) -> str:
    """The values allowed at the strike of the scene, and at all strikes of the range."""
    texts = [
        f"{_usable_words(limits, limits.limits[0])} at the scene's strike angle",
        f"{_usable_words(limits, limits.limits[-1])} at all strike angles",
    ]
    return "; ".join(dict.fromkeys(texts))


def _usable_words(limits: JointLimits, at_end: StrikeLimits) -> str:
    """The values that keep the bound and that flat ground allows."""
    pieces = []
    for low, high in at_end.usable:
        pieces.append(f"{limits.shown(low):.4g} to {limits.shown(high):.4g}{_unit(limits)}")
    return " and ".join(pieces) or "no value"


def _no_dependence(limits: JointLimits) -> list[str]:
    """That the number is the same for all values, but for rounding, where it is."""
    if not _unchanged(limits.scan.numbers):
        return []
    text = f"{limits.target.name} does not depend on {limits.subject} in this range"
    kind, _ = kind_and_target(limits.subject)
    if kind.of_ground:
        text += f"; {NAME_ONE}"
    return [text]


def _unchanged(numbers: Array) -> bool:
    """True if numbers (n, S) are the same in all rows that have them, but for rounding."""
    numbers = numbers[np.isfinite(numbers).all(axis=1)]
    if len(numbers) < 2:
        return False
    largest = np.abs(numbers).max(axis=0)
    return bool(np.all(np.ptp(numbers, axis=0) <= UNCHANGED * largest))


def _depends_on_ground(limits: JointLimits) -> bool:
    return limits.target.selection.quantity.of_ground(limits.profile.scene)


def _none_allowed(limits: JointLimits) -> list[str]:
    """That no value keeps the bound where flat ground allows the landing, and the best number."""
    if any(of_strikes.usable for of_strikes in limits.limits):
        return []
    text = f"no feasible value of {limits.subject} keeps {limits.target.name} {_bound(limits)}"
    feasible = [of_strikes for of_strikes in limits.limits if not math.isnan(of_strikes.best)]
    if not feasible:
        return [
            f"{text}: flat ground allows no landing of this range; give another with --range, or "
            "a larger --ground-tolerance"
        ]
    best = min(feasible, key=lambda of_strikes: limits.bound.sign * of_strikes.best)
    at = f"{limits.shown(best.best_at):.4g}{_unit(limits)}"
    return [
        f"{text}: the best is {best.best:.3g} at {at}; allow more, or give another range with "
        f"--range"
    ]


def _warnings(limits: JointLimits) -> list[str]:
    """The warnings of the landing, the scan and the ground."""
    warnings = other_warning_lines(limits.profile)
    n = len(limits.scan.values)
    scene, target = limits.profile.scene, limits.target
    for low, high, reason in limits.scan.unreachable:
        ends = f"{limits.shown(low):.4g} to {limits.shown(high):.4g} {limits.shown_unit}"
        warnings.append(f"warning: from {ends} there is no result: {reason}")
    if limits.scan.inaccurate:
        warnings.append(
            f"warning: in {limits.scan.inaccurate} of {n} postures the equations are "
            f"ill-conditioned; double precision may be off by more than 1e-9 there: compare with "
            f"shockpc analyze"
        )
    if scene.friction is not None and not _depends_on_ground(limits):
        warnings.append(
            "warning: the friction changes only the column feasible, as contacts slide and open "
            "with it; the bounded number is for contacts that stick"
        )
    if target.selection.quantity.per_landing(scene):
        warnings.append(
            f"warning: {target.name} is computed in one posture and at one strike angle at a "
            "time; --step, --range and --strikes set their number"
        )
    at_scene = n - int(limits.scan.feasible(limits.limits[0].strikes).sum())
    at_some = n - int(limits.scan.feasible(limits.strikes).sum())
    if at_scene or at_some:
        tolerance = f"{1e3 * scene.ground_tolerance:g} mm (--ground-tolerance)"
        warnings.append(
            f"warning: flat ground does not allow {at_scene} of {n} postures at the scene's "
            f"strike angle, and {at_some} at some strike angle of the range: a contact would have "
            "to be pulled, the impact would gain energy, or another link is lower or contacts "
            f"differ in height by more than {tolerance}; column feasible"
        )
    return warnings


def _document(limits: JointLimits) -> dict[str, Any]:
    """The entries of the document that are no tables: angles in degrees, positions in metres."""

    def value(number: float) -> float:
        return in_degrees(number) if limits.unit == "rad" else round(number, 9) + 0.0

    unreachable = []
    for low, high, reason in limits.scan.unreachable:
        unreachable.append({"low": value(low), "high": value(high), "reason": reason})
    return {
        "scene": limits.profile.scene,
        "target": limits.target.name,
        "target_unit": limits.target.selection.quantity.unit,
        "joints": limits.joints,
        "unit": limits.unit.replace("rad", "deg"),
        "max": None if limits.bound.below else limits.bound.value,
        "min": limits.bound.value if limits.bound.below else None,
        "warnings": limits.profile.health.warnings,
        "range": tuple(map(value, limits.range)),
        "file_limits": tuple(map(value, limits.file_limits)),
        "step": value(limits.step),
        "strike_angles_deg": tuple(map(in_degrees, limits.strikes)),
        "unreachable": unreachable,
        "inaccurate_postures": limits.scan.inaccurate,
    }


def _allowed(limits: JointLimits) -> Sheet:
    """The intervals of values that keep the bound, for every strike angle.

    It says where flat ground allows them.
    """
    title = f"values of {limits.subject} that keep {limits.target.name} {_bound(limits)}"
    table = limits.table
    ends = {*table.columns["low end"], *table.columns["high end"]}
    notes = [f"{end}: {words}" for end, words in ENDS.items() if end in ends]
    return sheet_of(table, title, notes)


def _drives(limits: JointLimits) -> Sheet:
    """The rows of `_allowed` with the smallest and the largest inertias of the drives."""
    header: Sequence[str | Heading] = _allowed(limits).header
    rows: list[Row] = []
    for end, at_end in limits.ends.items():
        if isinstance(at_end, ShockError):
            rows.append((end, *(None,) * len(header)))
        else:
            rows += [(end, *row) for row in _allowed(at_end).rows]
    return Sheet(AT_BOTH, ("drives", *header), rows)


def _best(limits: JointLimits) -> Sheet:
    """The best number where flat ground allows the landing, for every strike angle.

    Of several strikes it is that of the worst.
    """
    number = f"best {limits.target.selection.name} [{limits.target.unit}]"
    rows: list[Row] = []
    for strikes, _, best, best_at in limits.limits:
        rows.append((*map(in_degrees, strikes), best, limits.shown(best_at)))
    title = f"best {limits.target.title} where flat ground allows the landing"
    at = f"at [{limits.shown_unit}]"
    return Sheet(title, ("strike from [deg]", "strike to [deg]", number, at), rows)


def _postures(limits: JointLimits, most: int | None = None) -> Sheet:
    """The number in every posture of the scan, at the scene's and at the worst strike of the range.

    Args:
        limits: the result.
        most: number of postures, about; None for all.
    """
    scan, unit = limits.scan, limits.target.unit
    every = 1
    notes = []
    if most is not None:
        every = _every(len(scan.values), most)
    if every > 1:
        notes.append(f"one in {every} values of the scan is shown; --out writes all")
    worst, at = scan.worst(limits.strikes)
    rows: list[Row] = []
    for k in range(0, len(scan.values), every):
        numbers = float(scan.at_scene_strike[k]), float(worst[k])
        rows.append((limits.shown(float(scan.values[k])), *numbers, in_degrees(at[k])))
    header = (
        f"{'joint' if limits.of_joints else limits.subject} [{limits.shown_unit}]",
        f"at the scene's strike [{unit}]",
        f"worst [{unit}]",
        "at strike angle [deg]",
    )
    low, high = map(math.degrees, limits.strikes)
    title = f"{limits.target.title} over strike angles from {low:g} to {high:g} deg"
    return Sheet(title, header, rows, notes)


def _every(values: int, most: int) -> int:
    """Step through the values of a scan with at most about so many rows, a round number."""
    least = max(math.ceil((values - 1) / most), 1)
    return next((step for step in ROUND if step >= least), least)


def _bound(limits: JointLimits) -> str:
    side = "above" if limits.bound.below else "below"
    return f"at or {side} {limits.bound.value:g} {limits.target.unit}".removesuffix(" -")
