"""What a landing prints on a terminal by default: shocks and joint impulses, the worst first, and what decides on them."""

import math
from collections.abc import Sequence

from shockpc.quantities.profile import ShockProfile
from shockpc.show.tables import Cell, Row, Sheet, rounded
from shockpc.show.wording import BRACKETED, mostly_off_plane
from shockpc.text.printed import few

WORST = 6
"""Bodies in the table of shocks, the heaviest among them, unless they are asked for by name."""

USUAL = {"posture": "standing", "base": "falls freely", "plane": "xz"}
"""Beginnings of lines of the header that say what is so unless options say otherwise."""


def landing_lines(lines: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """The lines of the header that say something of this landing."""
    return [(name, text) for name, text in lines if name not in USUAL or not text.startswith(USUAL[name])]


def shocks_sheet(profile: ShockProfile, bodies: Sequence[int] | None = None) -> Sheet:
    """The shock at sensors, points and centres of mass, the worst first, with CoPc and RoPc of the bodies.

    Args:
        profile: the result.
        bodies: indices of the only bodies that are shown.
    """
    of_points: list[Row] = [(point.frame, point.shock, None, None, None, None, None) for point in profile.points]
    trunk = int(profile.robot.masses.argmax())
    shown = sorted(moving_bodies(profile, bodies), key=lambda i: -math.inf if i == trunk else -float(profile.shock_com[i]))
    shown = shown[:WORST] if bodies is None else shown
    of_bodies: list[Row] = []
    for i in shown:
        plane = (in_plane(profile, i, float(x)) for x in (profile.ropc[i], *profile.copc[i]))
        of_bodies.append((f"CoM of {profile.bodies[i]}", profile.shock_com[i], profile.shock_max[i], *plane))
    heads = ("shock at", "shock [-]", "greatest on the body [-]", "RoPc [m]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]")
    notes = without_geometry(profile, shown)
    if mostly_off_plane(profile)[shown].any():
        share = f"over {100.0 * BRACKETED:.0f} % of the body's motion"
        notes = (f"in brackets: {share} is out of the plane, of which these say nothing", *notes)
    sheet = Sheet("shock relative to the strike (CoPc in body coordinates)", heads, [*of_points, *of_bodies], notes)
    return worst_first(sheet)


def moving_bodies(profile: ShockProfile, bodies: Sequence[int] | None) -> list[int]:
    """Those that the impact moves, by their indices. Args: bodies, the only ones that are shown."""
    return [i for i in (range(len(profile.bodies)) if bodies is None else bodies) if profile.moved[i]]


def worst_first(sheet: Sheet) -> Sheet:
    """A table whose second column decides on the order."""
    return sheet._replace(rows=sorted(sheet.rows, key=lambda row: -float(row[1] or 0.0)))


def without_geometry(profile: ShockProfile, bodies: Sequence[int]) -> tuple[str, ...]:
    """Why there is no least and greatest shock of some of these bodies; a note, or none."""
    names = [profile.bodies[i] for i in bodies if math.isnan(profile.shock_max[i])]
    return (f"–: no geometry over which to take the shock: {few(names, 4)}",) if names else ()


def in_plane(profile: ShockProfile, i: int, value: Cell) -> Cell:
    """A number of a body that describes its motion in the plane, as text in brackets where most of it is out of the plane."""
    doubtful = mostly_off_plane(profile)[i] and isinstance(value, float) and not math.isnan(value)
    return f"({rounded(value)})" if doubtful else value
