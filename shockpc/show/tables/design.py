"""The numbers a designer asks for, as tables: drives, joints, severest strikes, energy. Computes nothing."""

import math

from shockpc.core.directions import ExtremeDirections
from shockpc.landing import ground_normal
from shockpc.result import ShockProfile
from shockpc.show.tables.sheets import Cell, Sheet

__all__ = ["balance_lines", "bracket_sheet", "directions_sheet", "loads_sheet"]

LEVEL = math.radians(1.0)
"""A strike that comes down by less than this along the ground is called level."""


def bracket_sheet(profile: ShockProfile) -> Sheet:
    """The same landing with free, modelled and locked drives."""
    rows: list[tuple[Cell, ...]] = [(b.place, b.free, b.as_modelled, b.locked) for b in profile.bracket]
    header = ("shock at", "drives free [-]", "as modelled [-]", "drives locked [-]")
    notes = ("– where the contact could not give way, or nothing could move",) if any(None in row for row in rows) else ()
    return Sheet("what the drives make of it (the choice that moves these numbers most)", header, rows, notes)


def directions_sheet(profile: ShockProfile, most: int | None = None) -> Sheet:
    """The strikes that each place feels most and least, at the same speed.

    Args:
        profile: the result.
        most: rows to show, those of the greatest shock; sensors and points always.
    """
    up = ground_normal(profile.plane, profile.scene.strike.vector(profile.plane))

    def cells(found: ExtremeDirections) -> tuple[Cell, ...]:
        most, least = (tuple(map(float, direction)) for direction in (found.most_severe, found.least_severe))
        way = "level" if abs(found.least_severe @ up) < LEVEL else "down"
        return float(found.most_severe_shock), *most, float(found.least_severe_shock), *least, way

    rows: list[tuple[Cell, ...]] = []
    moved, found = profile.moved, profile.directions
    for i, body in enumerate(profile.bodies):
        if moved[i]:
            rows.append((f"CoM of {body}", *cells(ExtremeDirections(*(numbers[i] for numbers in found)))))
    heaviest = max(profile.robot.bodies, key=lambda body: body.mass).name
    rows, notes = _largest(rows, most, "bodies", f"CoM of {heaviest}")
    for point in profile.points:
        rows.append((point.frame, *cells(point.directions)))
    header = ("place", "most severe [-]", "from x", "y", "z", "least severe [-]", "from x", "y", "z", "way")
    notes += ("among all directions, towards the ground or along it: one that is level is no landing",)
    return Sheet("most and least severe impact direction (direction of the velocity, world axes)", header, rows, notes)


def loads_sheet(profile: ShockProfile, most: int | None = None) -> Sheet:
    """Impulse through every joint.

    Args:
        profile: the result.
        most: rows to show, those of the greatest force.
    """
    rows: list[tuple[Cell, ...]] = [
        (load.joint, math.hypot(*load.force), math.hypot(*load.moment), None if load.along is None else abs(load.along))
        for load in profile.loads
    ]
    rows, notes = _largest(rows, most, "joints")
    if profile.health.rank < profile.health.rows:
        notes += ("some contact or closure rows repeat others or cannot move: of all loads that fit, these are the least",)
    header = ("joint", "force [N s]", "moment [N m s]", "along the axis [N m s, N s]")
    return Sheet("impulse through the joints", header, rows, notes)


def balance_lines(profile: ShockProfile) -> list[str]:
    """Energy, effective masses and how well the joints shield the robot; one line each."""
    share = "" if profile.energy_share is None else f", {100.0 * profile.energy_share:.3g} % of what there was"
    lines = [f"energy lost  {profile.energy_lost:.4g} J{share}"]
    for contact in profile.contacts:
        mitigation = (
            "no impact mitigation factor (it needs a free base, no standing foot, and joints that give way in every direction)"
            if contact.mitigation is None
            else f"impact mitigation factor {contact.mitigation:.3f}"
        )
        lines.append(
            f"{contact.frame}: effective mass {contact.mass_sticking:.4g} kg sticking, "
            f"{contact.mass_frictionless:.4g} kg frictionless, {mitigation}"
        )
    if profile.assembly is not None:
        found = profile.assembly
        moved = ", ".join(
            f"{name} by {math.degrees(by):.3g} deg" if unit == "rad" else f"{name} by {1e3 * by:.3g} mm"
            for name, by, unit in found.moved
        )
        turn = f" and {math.degrees(found.turn):.3g} deg" if found.turn > 0.0 else ""
        lines.append(f"loops closed from a gap of {1e3 * found.gap:.3g} mm{turn}: {moved or 'no joint had to move'}")
    return lines


def _largest(
    rows: list[tuple[Cell, ...]], most: int | None, what: str, always: str = ""
) -> tuple[list[tuple[Cell, ...]], tuple[str, ...]]:
    """The rows with the largest first number and the one named `always`, in their own order; how many are left out as a note."""
    if most is None or len(rows) <= most:
        return rows, ()
    kept = sorted(range(len(rows)), key=lambda k: (rows[k][0] != always, -float(rows[k][1] or 0.0)))[:most]
    return [rows[k] for k in sorted(kept)], (f"{len(rows) - most} {what} with less not shown; the report of --out has them all",)
