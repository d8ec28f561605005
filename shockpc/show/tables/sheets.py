"""A profile as tables: the same rows for the terminal, for Markdown and for CSV."""

import fnmatch
import math
from collections.abc import Sequence
from typing import NamedTuple

from shockpc.printed import few
from shockpc.result import ShockProfile
from shockpc.show.header import contact_name, count

__all__ = ["Cell", "Sheet", "accuracy_line", "bodies_sheet", "contacts_sheet", "fits", "points_sheet", "summary_sheet"]

Cell = str | float | None
"""Content of a table: a text, a number, or nothing, for which NaN stands as well."""

OUT_OF_PLANE = 25.0
"""Share of a body's motion out of the plane above which a note says what its CoPc and RoPc describe [%]."""


class Sheet(NamedTuple):
    """A table: a title, a header with units, rows, and notes under it."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]
    notes: tuple[str, ...] = ()


def bodies_sheet(profile: ShockProfile, pattern: str | None = None, fold: bool = True) -> Sheet:
    """One row for each body.

    Args:
        profile: the result.
        pattern: a glob, or a part of a name; only these bodies are shown.
        fold: for people: bodies that the impact does not move become a note, and a word says why a CoPc is missing.
    """
    matching = [i for i, name in enumerate(profile.bodies) if pattern is None or fits(name, pattern)]
    shown = [i for i in matching if profile.moved[i] or not fold]
    rows: list[tuple[Cell, ...]] = []
    for i in shown:
        copc: tuple[Cell, ...] = tuple(profile.copc[i])
        if profile.translates[i]:
            word = "translates" if math.isnan(profile.pitch[i]) else "out of plane"
            copc = (word if fold else None, None, None)
        shocks = (profile.shock_com[i], profile.shock_min[i], profile.shock_max[i], 100.0 * profile.off_plane[i])
        row = (profile.bodies[i], math.hypot(*profile.delta_omega[i]), *copc, profile.ropc[i], *shocks)
        rows.append(row if fold else (*row, "yes" if profile.translates[i] else "no"))
    notes = []
    if any(100.0 * profile.off_plane[i] > OUT_OF_PLANE for i in shown):
        notes.append(
            f"out of plane above {OUT_OF_PLANE:.0f} %: CoPc and RoPc describe only the part of that body's motion that lies in the "
            "plane; the shock is that of the whole motion"
        )
    if still := [profile.bodies[i] for i in matching if i not in shown]:
        notes.append(f"{count(len(still), 'body', 'bodies')} not shown, not moved by the impact: {few(still, 6)}")
    if hidden := len(profile.bodies) - len(matching):
        notes.append(f"{count(hidden, 'body', 'bodies')} not shown, no match for {pattern}")
    header: tuple[str, ...] = (
        "body", "|Δω| [rad/s]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]", "RoPc [m]",
        "shock at CoM [-]", "least [-]", "greatest [-]", "out of plane [%]",
    )  # fmt: skip
    header += () if fold else ("no rotation in the plane",)
    return Sheet("bodies (CoPc in body coordinates; shock relative to the strike)", header, rows, tuple(notes))


def points_sheet(profile: ShockProfile) -> Sheet:
    """One row for each sensor and each requested point; peak accelerations where the scene gives a pulse."""
    pulse, range_g = profile.scene.pulse, profile.scene.range_g
    header: tuple[str, ...] = ("point", "on body", "Δv x [m/s]", "Δv y [m/s]", "Δv z [m/s]", "shock [-]")
    header += () if pulse is None else ("peak [g]",) if range_g is None else ("peak [g]", f"of {range_g:g} g [%]")
    rows: list[tuple[Cell, ...]] = []
    for point in profile.points:
        share = None if range_g is None else 100.0 * (point.peak_g or 0.0) / range_g
        row = (point.frame, point.body, *point.delta_v, point.shock, point.peak_g, share)
        rows.append(row[: len(header)])
    title = "sensors and points (Δv in the frame's own axes" + (f"; peak acceleration for a pulse {pulse})" if pulse else ")")
    return Sheet(title, header, rows)


def contacts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each contact and each stance foot, and their sum where there are several."""
    rows: list[tuple[Cell, ...]] = []
    notes: tuple[str, ...] = ()
    named = [(contact.frame, contact) for contact in profile.contacts]
    for name, contact in named + [(f"{foot.frame} (stance)", foot) for foot in profile.stance]:
        if contact.impulse is None:
            rows.append((name, "not unique", None, None, None))
            notes = ("the contact rows are redundant, so only the sum of the impulses is unique",)
        else:
            rows.append((name, *contact.impulse, "tensile" if contact.friction_needed is None else contact.friction_needed))
    if len(rows) > 1:
        rows.append(("total", *profile.total_impulse, None))
        moment = ", ".join(f"{m:.4g}" for m in profile.total_moment.round(12) + 0.0)
        notes += (f"total moment ({moment}) N m s about the centre of mass of the robot",)
    header = ("contact", "impulse x [N s]", "impulse y [N s]", "impulse z [N s]", "friction to stick [-]")
    return Sheet("contacts (impulse of the ground on the robot, world axes)", header, rows, notes)


def accuracy_line(profile: ShockProfile) -> str:
    """The proven error bound, and what double precision and the last digit of the data contribute."""
    health = profile.health
    line = f"accuracy: proven to {health.error_bound:.0e} of each body's motion ({health.bits} bits); double precision alone "
    line += f"was off by {health.double_error:.0e}" if math.isfinite(health.double_error) else "finds no solution"
    if health.data_sensitivity is None:
        return line
    return f"{line}; last-digit changes of the data move it by {health.data_sensitivity:.0e}"


def summary_sheet(profiles: Sequence[ShockProfile], pattern: str | None = None) -> Sheet:
    """Several landings side by side: shock at every body's centre of mass and at every point, a column for each landing."""
    rows: list[tuple[Cell, ...]] = [
        (body, *(profile.shock_com[i] for profile in profiles))
        for i, body in enumerate(profiles[0].bodies)
        if (pattern is None or fits(body, pattern)) and any(profile.moved[i] for profile in profiles)
    ]
    rows += [
        (f"at {point.frame}", *(profile.points[k].shock for profile in profiles)) for k, point in enumerate(profiles[0].points)
    ]
    header = ("shock at", *map(contact_name, profiles))
    return Sheet("summary: shock at each body's CoM and at each point [-], by contact", header, rows)


def fits(name: str, pattern: str) -> bool:
    """Whether a name matches a glob, or contains a text; upper and lower case are the same."""
    name, pattern = name.casefold(), pattern.casefold()
    return fnmatch.fnmatchcase(name, pattern) if any(sign in pattern for sign in "*?[") else pattern in name
