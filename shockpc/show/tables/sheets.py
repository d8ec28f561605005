"""A profile as tables: the same rows for the terminal, for Markdown and for CSV. Computes nothing."""

import fnmatch
import math
from typing import NamedTuple

import numpy as np

from shockpc.result import ContactImpulse, ShockProfile, StanceImpulse
from shockpc.robot.robot import Robot
from shockpc.show.strike import strike_text

__all__ = [
    "UNDRIVEN",
    "Cell",
    "Sheet",
    "bodies_sheet",
    "bodies_text",
    "contact_name",
    "contacts_sheet",
    "fits",
    "header_lines",
    "health_lines",
    "points_sheet",
    "summary_sheet",
]

Cell = str | float | None
"""What a table holds: a name, a number, or nothing."""

UNMOVED = "the strike does not move them"

UNDRIVEN = "none (no joint that could be driven)"
"""The joint model of a robot that is one body."""

OFF_PLANE = 25.0
"""Share of a body's motion outside the plane from which its CoPc is called into question [%]."""


class Sheet(NamedTuple):
    """A table: a title, a header with units, rows of text, numbers or nothing, and notes under it."""

    title: str
    header: tuple[str, ...]
    rows: list[tuple[Cell, ...]]
    notes: tuple[str, ...] = ()


def header_lines(profile: ShockProfile) -> list[tuple[str, str]]:
    """What was computed: robot, posture, contact, strike, joint model, plane; (name, text)."""
    robot, scene = profile.robot, profile.scene
    base = {"free": "base free", "planar": "base moves in the plane only", "fixed": "base fixed"}[scene.base or "free"]
    turned = scene.posture.base_rpy_deg
    turn = f", base turned by roll {turned[0]:g}, pitch {turned[1]:g}, yaw {turned[2]:g} deg" if turned else ""
    changed = dict.fromkeys([*scene.posture.joints, *scene.posture.joints_deg])
    sets = f", with {', '.join(changed)} set" if changed else ""
    mass = f"{robot.mass:.4g} kg, {bodies_text(robot)}"
    return [
        ("robot", f"{robot.label} ({robot.name}, {mass})"),
        ("posture", f"{scene.posture.reference}{sets}{turn}; {base}"),
        ("contact", "; ".join(_contact_text(profile, i) for i in range(len(profile.contacts)))),
        ("strike", strike_text(profile)),
        ("joint model", JOINT_MODELS[profile.joint_model] if robot.joint_names else UNDRIVEN),
        ("plane", _plane_text(profile)),
    ]


JOINT_MODELS = {
    "free": "free (no reflected inertia: drives offer no resistance; a stiff gearbox changes these numbers a lot)",
    "geared": "geared (every drive resists by its reflected inertia)",
    "locked": "locked (every drive holds, so the robot is one rigid body)",
    "mixed": "mixed (some drives resist or hold, the others turn freely)",
}


def bodies_sheet(profile: ShockProfile, pattern: str | None = None, fold: bool = True) -> Sheet:
    """One row for each body.

    Args:
        profile: the result.
        pattern: a glob, or a part of a name; only these bodies are shown.
        fold: for people: bodies that the strike does not move become a note, and a word says why a CoPc is missing.
    """
    rows: list[tuple[Cell, ...]] = []
    still, hidden, moved = [], 0, profile.moved
    for i, name in enumerate(profile.bodies):
        if pattern is not None and not fits(name, pattern):
            hidden += 1
            continue
        if fold and not moved[i]:
            still.append(name)
            continue
        copc: tuple[Cell, ...] = tuple(map(float, profile.copc[i]))
        if profile.translates[i]:
            # A table says why there is no point; a file of numbers has a column of its own for that.
            word = "translates" if math.isnan(profile.pitch[i]) else "turns across"
            copc = (word if fold else None, None, None)
        rows.append(
            (
                name,
                math.hypot(*profile.delta_omega[i]),
                *copc,
                float(profile.ropc[i]),
                float(profile.shock_com[i]),
                _or_none(profile.shock_min[i]),
                _or_none(profile.shock_max[i]),
                100.0 * float(profile.off_plane[i]),
                *(() if fold else ("yes" if profile.translates[i] else "no",)),
            )
        )
    notes = []
    if rows and max(float(row[9] or 0.0) for row in rows) > OFF_PLANE:
        notes.append(
            f"off-plane above {OFF_PLANE:.0f} %: CoPc and RoPc describe only the part of that body's motion that lies in the "
            "plane; the shock columns hold in space"
        )
    if still:
        listed = ", ".join(still[:6]) + (f" and {len(still) - 6} more" if len(still) > 6 else "")
        notes.append(
            f"{len(still)} bodies not shown, {UNMOVED}: {listed}"
            if len(still) > 1
            else f"1 body not shown, the strike does not move it: {listed}"
        )
    if hidden:
        notes.append(
            f"{hidden} bodies not shown, their names do not fit {pattern}"
            if hidden > 1
            else f"1 body not shown, its name does not fit {pattern}"
        )
    header: tuple[str, ...] = (
        "body", "|Δω| [rad/s]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]", "RoPc [m]",
        "shock at CoM [-]", "least [-]", "greatest [-]", "off-plane [%]",
    )  # fmt: skip
    header += () if fold else ("no turn in the plane",)
    return Sheet("bodies (CoPc in body coordinates; shock relative to the strike)", header, rows, tuple(notes))


def points_sheet(profile: ShockProfile) -> Sheet:
    """One row for each sensor and each point asked for; peak accelerations where the scene gives a pulse."""
    rows: list[tuple[Cell, ...]] = [(p.frame, p.body, *map(float, p.delta_v), p.shock) for p in profile.points]
    header: tuple[str, ...] = ("point", "on body", "Δv x [m/s]", "Δv y [m/s]", "Δv z [m/s]", "shock [-]")
    title = "sensors and points (Δv in the frame's own axes)"
    pulse, range_g = profile.scene.pulse, profile.scene.range_g
    if pulse is None:
        return Sheet(title, header, rows)
    header, title = (*header, "peak [g]"), f"{title[:-1]}; peak for a pulse {pulse}, the weakest input of all)"
    rows = [(*row, point.peak_g) for row, point in zip(rows, profile.points, strict=True)]
    if range_g is not None:
        header = (*header, f"of {range_g:g} g [%]")
        rows = [(*row, 100.0 * (point.peak_g or 0.0) / range_g) for row, point in zip(rows, profile.points, strict=True)]
    return Sheet(title, header, rows)


def contacts_sheet(profile: ShockProfile) -> Sheet:
    """One row for each contact and each foot that stands, and their sum where there are several."""
    rows: list[tuple[Cell, ...]] = []
    notes: tuple[str, ...] = ()
    grounded: list[ContactImpulse | StanceImpulse] = [*profile.contacts, *profile.stance]
    for contact in grounded:
        name = contact.frame if isinstance(contact, ContactImpulse) else f"{contact.frame} (stands)"
        if contact.impulse is None:
            rows.append((name, "not unique", None, None, None))
            notes = ("where contacts repeat one another only the sum of their impulses is determined",)
        else:
            needed: Cell = "pulls" if contact.friction_needed is None else contact.friction_needed
            rows.append((name, *map(float, contact.impulse), needed))
    if len(rows) > 1:
        rows.append(("together", *map(float, profile.total_impulse), None))
        moment = ", ".join(f"{m:.4g}" for m in profile.total_moment.round(12) + 0.0)
        notes += (f"together they turn the robot by ({moment}) N m s about its centre of mass",)
    header = ("contact", "impulse x [N s]", "impulse y [N s]", "impulse z [N s]", "friction to stick [-]")
    return Sheet("contacts (impulse of the ground on the robot, world axes)", header, rows, notes)


def health_lines(profile: ShockProfile) -> list[str]:
    """How far to trust it: one line, then one for each warning."""
    health = profile.health
    error = (
        f"error estimate {health.error_estimate:.0e} of each body's motion"
        if math.isfinite(health.error_estimate)
        else "no digit sure"
    )
    line = (
        f"health: {health.rank} of {health.rows} contact rows independent, residual {health.residual:.0e}, {error}; {health.method}"
    )
    return [line, *(f"warning: {warning}" for warning in health.warnings)]


def bodies_text(robot: Robot) -> str:
    """How many bodies move."""
    return "1 moving body" if len(robot.bodies) == 1 else f"{len(robot.bodies)} moving bodies"


def contact_name(profile: ShockProfile) -> str:
    """The contacts of a landing, as they are typed."""
    return "+".join(contact.frame for contact in profile.contacts)


def summary_sheet(profiles: list[ShockProfile], pattern: str | None = None) -> Sheet:
    """Several landings side by side: shock at every body's centre of mass and at every point, a column for each contact."""
    names = [contact_name(profile) for profile in profiles]
    rows: list[tuple[Cell, ...]] = []
    for i, body in enumerate(profiles[0].bodies):
        if (pattern is None or fits(body, pattern)) and any(profile.moved[i] for profile in profiles):
            rows.append((body, *(float(profile.shock_com[i]) for profile in profiles)))
    for k, point in enumerate(profiles[0].points):
        rows.append((f"at {point.frame}", *(profile.points[k].shock for profile in profiles)))
    return Sheet("summary: shock at each body's CoM and at each point [-], by contact", ("shock at", *names), rows)


def fits(name: str, pattern: str) -> bool:
    """Whether a name fits a glob, or contains a text, whatever the case."""
    name, pattern = name.casefold(), pattern.casefold()
    return fnmatch.fnmatchcase(name, pattern) if any(sign in pattern for sign in "*?[") else pattern in name


def _or_none(value: float) -> float | None:
    """A number, or None for NaN."""
    return None if math.isnan(value) else float(value)


def _contact_text(profile: ShockProfile, i: int) -> str:
    """Where a contact strikes and what it keeps."""
    asked, found = profile.scene.contact[i], profile.contacts[i]
    where = ", ".join(f"{x:.3f}" for x in found.point + 0.0)
    kept = [d if isinstance(d, str) else "(" + " ".join(f"{u:g}" for u in d) + ")" for d in asked.directions]
    grip = "sticks" if asked.sticks else f"slides, kept along {' '.join(kept)}"
    bounce = f", restitution {asked.restitution:g}" if asked.restitution else ""
    lowest = ", its lowest point" if asked.at == "lowest" else ""
    comes = ""
    if np.linalg.norm(found.approach - profile.strike) > 1e-9 * np.linalg.norm(profile.strike):
        comes = ", comes at ({}) m/s".format(", ".join(f"{v:.4g}" for v in found.approach.round(12) + 0.0))
    return f"{asked.frame}{lowest} at ({where}) m, {grip}{bounce}{comes}"


def _plane_text(profile: ShockProfile) -> str:
    """The plane by its name, or by its normal."""
    named = {"xz": "xz (sagittal)", "yz": "yz (frontal)", "xy": "xy (from above)"}
    plane = profile.scene.plane
    return named[plane] if isinstance(plane, str) else "normal (" + ", ".join(f"{n:.4g}" for n in profile.plane.normal) + ")"
