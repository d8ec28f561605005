"""Joint limits that a bound on the shock sets: for every strike angle the values allowed, for every posture the strike angles."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from shockpc.show.document import head, plain
from shockpc.show.header import header_lines
from shockpc.show.reports.report import Report
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.limits import Interval, ShockLimits, StrikeLimits

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["limits_report"]

MARKS = {"bound": "", "range": "*", "loop": "†"}

ENDS = {"range": "end of the range, not a limit", "loop": "the loop cannot be closed beyond"}

ROWS = 12
"""Postures of the table for people, about."""


def limits_report(found: ShockLimits) -> Report:
    """The limits of a joint."""

    def draw() -> "Figure":
        from shockpc.show.figure.limits import draw_limits

        return draw_limits(found)

    return Report(
        name="limits",
        title=f"Limits of {'+'.join(found.joints)} for the shock at {found.point}",
        header=[*header_lines(found.profile), ("joint", _scan(found))],
        tables=lambda _: [_allowed(found), _postures(found, ROWS)],
        closing=_warnings(found),
        sheets={"limits": lambda: _intervals(found), "postures": lambda: _postures(found)},
        document=lambda: _document(found),
        picture="limits",
        caption="shock over joint and strike angle",
        draw=draw,
    )


def _document(found: ShockLimits) -> dict[str, Any]:
    """The document, schema `shockpc.limits/1`: angles in degrees, positions in metres."""
    greatest, at = found.most_severe

    def value(number: float) -> float:
        return round(_number(found, number) / (1.0 if found.unit == "rad" else 1e3), 9) + 0.0

    def degrees(angles: tuple[float, ...]) -> list[float]:
        return [round(math.degrees(angle), 9) + 0.0 for angle in angles]

    return {
        **head("limits"),
        "scene": plain(found.profile.scene),
        "point": found.point,
        "joints": list(found.joints),
        "unit": "deg" if found.unit == "rad" else "m",
        "max_shock": found.max_shock,
        "warnings": plain(found.profile.health.warnings),
        "range": [value(end) for end in found.range],
        "file_limits": [value(end) if math.isfinite(end) else None for end in found.file_limits],
        "step": value(found.step),
        "strike_angles_deg": degrees(found.strikes),
        "limits": [
            {
                "strike_angles_deg": degrees(one.strikes),
                "allowed": [{**i._asdict(), "low": value(i.low), "high": value(i.high)} for i in one.allowed],
                "least_shock": plain(one.least),
                "least_at": value(one.least_at),
            }
            for one in found.limits
        ],
        "postures": [
            {
                "value": value(float(found.scan.values[k])),
                "most_severe_shock": plain(greatest[k]),
                "most_severe_strike_angle_deg": degrees((at[k],))[0],
                "allowed_strike_angles_deg": [degrees(part) for part in found.allowed_strikes(k)],
            }
            for k in range(0, len(found.scan.values), _every(found, 100))
        ],
        "unreachable": [{"low": value(a), "high": value(b), "reason": reason} for a, b, reason in found.scan.unreachable],
        "inaccurate_postures": found.scan.inaccurate,
    }


def _allowed(found: ShockLimits) -> Sheet:
    """For every strike angle the values of the joint that keep the bound."""
    unit = _unit(found)
    rows: list[tuple[Cell, ...]] = [
        (
            _strikes(found, one),
            ", ".join(_interval(found, interval) for interval in one.allowed) or "none",
            one.least,
            f"{_number(found, one.least_at):.2f}",
        )
        for one in found.limits
    ]
    ends = {end for one in found.limits for interval in one.allowed for end in interval[2:]}
    return Sheet(
        f"values of {'+'.join(found.joints)} that keep the shock at {found.point} at or below {found.max_shock:g}",
        ("strike angle [deg]", f"allowed [{unit}]", "least shock [-]", f"at [{unit}]"),
        rows,
        tuple(f"{MARKS[end]} {words}" for end, words in ENDS.items() if end in ends),
    )


def _postures(found: ShockLimits, most: int | None = None) -> Sheet:
    """For every posture the most severe strike, and the strikes that keep the bound. Args: most, number of rows, about."""
    greatest, at = found.most_severe
    own = found.shock(np.array([found.own[1]]))[:, 0]
    every = 1 if most is None else _every(found, most)
    rows: list[tuple[Cell, ...]] = [
        (
            f"{_number(found, float(found.scan.values[k])):.2f}",
            float(own[k]),
            float(greatest[k]),
            f"{math.degrees(at[k]):.1f}",
            ", ".join(f"{math.degrees(a):.1f} … {math.degrees(b):.1f}" for a, b in found.allowed_strikes(k)) or "none",
        )
        for k in range(0, len(found.scan.values), every)
    ]
    low, high = (math.degrees(angle) for angle in found.strikes)
    notes = () if every == 1 else (f"every {every}th posture of the scan; --out writes all",)
    header = (
        f"joint [{_unit(found)}]",
        "shock of the scene's strike [-]",
        "greatest [-]",
        "at strike angle [deg]",
        "strike angles allowed [deg]",
    )
    return Sheet(f"shock at {found.point} over strike angles from {low:g} to {high:g} deg", header, rows, notes)


def _intervals(found: ShockLimits) -> Sheet:
    """A row for every interval, for a spreadsheet."""
    unit = _unit(found)
    rows: list[tuple[Cell, ...]] = []
    for one in found.limits:
        strikes = tuple(math.degrees(angle) for angle in one.strikes)
        rows += [(*strikes, _number(found, i.low), _number(found, i.high), i.low_end, i.high_end) for i in one.allowed]
    header = ("least strike angle [deg]", "greatest strike angle [deg]", f"low [{unit}]", f"high [{unit}]", "low end", "high end")
    return Sheet("", header, rows)


def _scan(found: ShockLimits) -> str:
    """The question in words."""
    unit, (low, high) = _unit(found), (_number(found, end) for end in found.range)
    limits = [f"{_number(found, end):g}" if math.isfinite(end) else "none" for end in found.file_limits]
    return (
        f"{'+'.join(found.joints)} from {low:g} to {high:g} {unit}, scanned in steps of {_number(found, found.step):g} {unit}; "
        f"the file's limits are {limits[0]} and {limits[1]}"
    )


def _warnings(found: ShockLimits) -> list[str]:
    """What limits the answer."""
    unit = _unit(found)
    warnings = [f"warning: {warning}" for warning in found.profile.health.warnings]
    warnings += [
        f"warning: from {_number(found, low):.2f} to {_number(found, high):.2f} {unit} there is no result: {reason}"
        for low, high, reason in found.scan.unreachable
    ]
    if found.scan.inaccurate:
        warnings.append(
            f"warning: in {found.scan.inaccurate} of {len(found.scan.values)} postures the equations are ill-conditioned; "
            "double precision may be off by more than 1e-9 there: compare with shockpc analyze"
        )
    return warnings


def _every(found: ShockLimits, most: int) -> int:
    """Step through the scan with at most about so many rows, at round values where the scan has them."""
    n = len(found.scan.values) - 1
    least = max(math.ceil(n / most), 1)
    return next((k for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if k >= least), least)


def _strikes(found: ShockLimits, one: StrikeLimits) -> str:
    """The strike angles of a row."""
    low, high = (f"{round(math.degrees(angle), 4) + 0.0:g}" for angle in one.strikes)
    if one.strikes[0] < one.strikes[1]:
        return f"any of {low} … {high}"
    return f"{low}, the scene's" if one is found.limits[0] else low


def _interval(found: ShockLimits, interval: Interval) -> str:
    """An interval, rounded inwards to hundredths; signs where something else than the bound ends it."""
    low, high = math.ceil(100.0 * _number(found, interval.low) - 1e-6), math.floor(100.0 * _number(found, interval.high) + 1e-6)
    return f"{low / 100.0:.2f}{MARKS[interval.low_end]} … {high / 100.0:.2f}{MARKS[interval.high_end]}"


def _unit(found: ShockLimits) -> str:
    """The unit of printed values."""
    return "deg" if found.unit == "rad" else "mm"


def _number(found: ShockLimits, value: float) -> float:
    """A value of the joint in that unit."""
    return round(math.degrees(value) if found.unit == "rad" else 1e3 * value, 9) + 0.0
