"""Results for design as tables: effect of the joint model, impact directions, joint loads, energy and effective masses."""

import math

from shockpc.core.directions import ExtremeDirections
from shockpc.result import ShockProfile
from shockpc.show.header import count
from shockpc.show.tables.sheets import Cell, Sheet

__all__ = ["balance_lines", "bracket_sheet", "directions_sheet", "loads_sheet"]

PARALLEL = math.radians(1.0)
"""Largest angle to the ground of an impact direction that is called parallel to it."""

NO_MITIGATION = (
    "no impact mitigation factor (it requires a free base, no stance, and joints that move the contact in every direction)"
)


def bracket_sheet(profile: ShockProfile) -> Sheet:
    """The same landing with free joints, with the joints as modelled, and with locked joints."""
    rows = [(b.place, b.free, b.as_modelled, b.locked) for b in profile.bracket]
    header = ("shock at", "joints free [-]", "as modelled [-]", "joints locked [-]")
    notes = ("–: not solvable with that joint model",) if any(None in row for row in rows) else ()
    return Sheet("effect of the joint model", header, rows, notes)


def directions_sheet(profile: ShockProfile, most: int | None = None) -> Sheet:
    """The impact directions with the greatest and the least shock at each place, at the same speed.

    Args:
        profile: the result.
        most: rows to show, those of the greatest shock; sensors and points always.
    """
    up = profile.landing.up

    def row(place: str, found: ExtremeDirections) -> tuple[Cell, ...]:
        way = "parallel" if abs(found.least_severe @ up) < PARALLEL else "towards"
        return place, found.most_severe_shock, *found.most_severe, found.least_severe_shock, *found.least_severe, way

    found = zip(profile.bodies, profile.moved, zip(*profile.directions, strict=True), strict=True)
    rows = [row(f"CoM of {body}", ExtremeDirections(*own)) for body, moved, own in found if moved]
    heaviest = max(profile.robot.bodies, key=lambda body: body.mass).name
    rows, notes = _largest(rows, most, ("body", "bodies"), f"CoM of {heaviest}")
    rows += [row(point.frame, point.directions) for point in profile.points]
    header = ("place", "most severe [-]", "x [-]", "y [-]", "z [-]", "least severe [-]", "x [-]", "y [-]", "z [-]", "to the ground")
    notes += ("over all directions towards the ground or parallel to it; an impact parallel to the ground is no landing",)
    return Sheet("most and least severe impact direction (unit vector of the velocity, world axes)", header, rows, notes)


def loads_sheet(profile: ShockProfile, most: int | None = None) -> Sheet:
    """Impulse through every joint, or through those with the greatest force."""
    rows: list[tuple[Cell, ...]] = [
        (load.joint, math.hypot(*load.force), math.hypot(*load.moment), None if load.along is None else abs(load.along))
        for load in profile.loads
    ]
    rows, notes = _largest(rows, most, ("joint", "joints"))
    if profile.health.rank < profile.health.rows:
        notes += ("contact or closure rows are redundant: these are the joint loads of least norm",)
    header = ("joint", "force [N s]", "moment [N m s]", "along the axis [N m s, N s]")
    return Sheet("impulse through the joints", header, rows, notes)


def balance_lines(profile: ShockProfile) -> list[str]:
    """Energy, effective masses, impact mitigation and the closing of loops; one line each."""
    share = "" if profile.energy_share is None else f", {100.0 * profile.energy_share:.3g} % of the kinetic energy before impact"
    lines = [f"energy lost: {profile.energy_lost:.4g} J{share}"]
    for contact in profile.contacts:
        mitigation = NO_MITIGATION if contact.mitigation is None else f"impact mitigation factor {contact.mitigation:.3f}"
        masses = f"{contact.mass_sticking:.4g} kg sticking, {contact.mass_frictionless:.4g} kg frictionless"
        lines.append(f"{contact.frame}: effective mass {masses}, {mitigation}")
    if profile.assembly is not None:
        found = profile.assembly
        moved = [
            f"{name} by {math.degrees(by):.3g} deg" if unit == "rad" else f"{name} by {1e3 * by:.3g} mm"
            for name, by, unit in found.moved
        ]
        turn = f" and {math.degrees(found.turn):.3g} deg" if found.turn > 0.0 else ""
        how = ", ".join(moved) or "no joint had to move"
        lines.append(f"loops closed from a gap of {1e3 * found.gap:.3g} mm{turn}: {how}")
    return lines


def _largest(
    rows: list[tuple[Cell, ...]], most: int | None, noun: tuple[str, str], always: str = ""
) -> tuple[list[tuple[Cell, ...]], tuple[str, ...]]:
    """The rows with the largest first number and the one named `always`, in their own order; a note says how many are left out."""
    if most is None or len(rows) <= most:
        return rows, ()
    kept = sorted(range(len(rows)), key=lambda k: (rows[k][0] != always, -float(rows[k][1] or 0.0)))[:most]
    return [rows[k] for k in sorted(kept)], (f"{count(len(rows) - most, *noun)} with smaller values not shown; --out writes all",)
