"""Robots as tables: the list of those known by name, and the contents of one."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from shockpc.core.interval import interval_text
from shockpc.landing.joint_model import joint_model
from shockpc.landing.joint_options import Joints
from shockpc.landing.posture import reference_name
from shockpc.method.dynamics import PINOCCHIO
from shockpc.robot.checkup import check_robot
from shockpc.robot.drives import PUBLIC, catalogue_drives
from shockpc.robot.elements import Drive
from shockpc.robot.feet_and_sensors import each_foot, recognised, sensors
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import is_arm, usual_base
from shockpc.show.document import record
from shockpc.show.header import base_text, moving_text
from shockpc.show.report import Report
from shockpc.show.tables import Column, Lines, Row, Sheet
from shockpc.text.errors import RobotError
from shockpc.text.printed import count, few


def robots_report(robots: Mapping[str, Robot | None], supplied: int) -> Report:
    """Every robot that is known by name: a row each.

    Args:
        robots: by name; None for one that cannot be loaded.
        supplied: number of those, the first, that come with shockpc.
    """
    header = (
        *("robot", "bodies", "mass [kg]"),
        Column("feet", "feet, or tips of the limbs", width=38),
        Column("postures", "postures", width=32),
        "message",
    )
    sheet = Sheet(
        "robots known by name", header, [_known(name, robot) for name, robot in robots.items()]
    )
    lost = [name for name, robot in robots.items() if robot is None]
    notes = (
        f"the first {supplied} come with shockpc, the others with example-robot-data",
        *(
            [f"cannot be loaded, which shockpc robots NAME says why: {', '.join(lost)}"]
            if lost
            else []
        ),
        "analyze one: shockpc analyze NAME --contact FOOT",
        "show one with all its links, joints and postures: shockpc robots NAME",
    )
    return Report(
        name="robots",
        title="Robots",
        body=lambda _: [sheet.without("message")._replace(notes=notes)],
        sheets={"robots": lambda: sheet},
        document=dict,
        tables=True,
    )


def _known(name: str, robot: Robot | None) -> Row:
    """A row of the list."""
    if robot is None:
        return name, None, None, None, None, f"cannot be loaded; shockpc robots {name} says why"
    masses = robot.masses[robot.movable(usual_base(robot).base)]
    return (
        name,
        len(masses),
        float(masses.sum()),
        ", ".join(each_foot(robot)),
        ", ".join(robot.postures) or "neutral",
        None,
    )


def robot_report(robot: Robot) -> Report:
    """The contents of a robot, and the check-up of its file."""
    drives = _drives(robot)
    bodies, joints, findings = _bodies(robot), _joints(robot), check_robot(robot)
    reading = _second_reading(robot) if robot.source.kind == "urdf" else None
    checkup = [f"{finding.level}: {finding.where}: {finding.text}" for finding in findings] or [
        "nothing found"
    ]
    return Report(
        name="robot",
        title=f"Robot {robot.name}",
        body=lambda _: [
            Lines(_lines(robot)),
            bodies,
            joints,
            *([Lines(list(map(_drive_line, drives)), "drives", whole=True)] if drives else []),
            Lines(checkup, "check-up", whole=True),
            *([] if reading is None else [Lines(reading, "second reader", whole=True)]),
        ],
        sheets={
            "bodies": lambda: bodies,
            "joints": lambda: joints,
            "drives": lambda: _drives_sheet(drives),
        },
        document=lambda: {
            "name": robot.name,
            "mass": float(robot.masses[robot.movable(usual_base(robot).base)].sum()),
            "file": str(robot.source.path),
            "base": usual_base(robot).base,
            "feet": each_foot(robot),
            "sensors": sensors(robot),
            "postures": tuple(robot.postures),
            "default_posture": reference_name(robot, None),
            "mimics": [record(mimic, "joint", "leaders", "offset") for mimic in robot.mimics],
            "check_up": findings,
            "second_reader": reading,
        },
        tables=True,
    )


def _second_reading(robot: Robot) -> list[str]:
    """Whether a second reader of URDFs reads the same robot; a line each."""
    try:
        from shockpc.robot.second_reader import second_reading

        reading = second_reading(robot)
    except RobotError as refusal:
        return [f"warning: {refusal}"]
    what = (
        f"{reading.links} links, {reading.joints} joints, limits, mimics, inertias and placements "
        f"at random configurations"
    )
    lines = [f"warning: yourdfpy: {difference}" for difference in reading.differences] or [
        f"yourdfpy reads the same {what}"
    ]
    return [*lines, *(f"note: yourdfpy's check: {fault}" for fault in reading.faults)]


class _Known(NamedTuple):
    """What is known of the drives of some joints: their names, the reflected inertia with its ends,
    and from where.

    Those that are not used by default are of a simulation model, or of unknown inertia.
    """

    joints: str
    low: float
    armature: float
    high: float
    status: str
    used: bool
    source: str


def _drives(robot: Robot) -> list[_Known]:
    """What is known of the drives; one for all joints with the same numbers from the same source.

    Those that a landing takes by default come first, then those of the catalogue that it does not
    take.
    """
    model = joint_model(robot, Joints())
    by_joint = robot.default_drives.by_joint if robot.default_drives is not None else {}
    found: list[_Known] = []
    for source in model.sources:
        groups: dict[tuple[float, float, float], list[str]] = {}
        for name in source.joints:
            v = robot.joint(name).v.start
            numbers = (
                float(model.low[v]),
                float(model.armature[v] + model.rotor[v]),
                float(model.high[v]),
            )
            groups.setdefault(numbers, []).append(name)
        for numbers, names in groups.items():
            parts = _parts(by_joint.get(names[0], Drive(joint=())))
            found.append(
                _Known(", ".join(names), *numbers, source.status, True, f"{parts}{source.text}")
            )
    for drive in catalogue_drives(robot.source.name):
        if drive.status not in PUBLIC:
            (low, high), inertia = drive.interval, drive.reflected or 0.0
            found.append(
                _Known(
                    ", ".join(drive.joint),
                    low,
                    inertia,
                    high,
                    str(drive.status),
                    False,
                    f"{_parts(drive)}{drive.source}",
                )
            )
    return found


def _parts(drive: Drive) -> str:
    """The parts of a drive, before its source."""
    values = {
        "rotor {} kg m²": drive.rotor_inertia,
        "gear ratio {}": drive.gear_ratio,
        "spring of {} N m/rad": drive.drive_stiffness,
    }
    texts = [
        text.format(interval_text(value)) for text, value in values.items() if value is not None
    ]
    return f"{', '.join(texts)}; " if texts else ""


def _drives_sheet(drives: list[_Known]) -> Sheet:
    rows: list[Row] = [
        (*drive[:5], "yes" if drive.used else "no", drive.source) for drive in drives
    ]
    header = (
        Column("joints", "joints"),
        Column("low", "smallest reflected inertia", "kg m², kg"),
        Column("armature", "as modelled", "kg m², kg"),
        Column("high", "largest", "kg m², kg"),
        *("status", "used", "source"),
    )
    return Sheet("drives", header, rows)


def _drive_line(drive: _Known) -> str:
    """What is known of some drives, for people."""
    most = f"{drive.high:.3g}" if math.isfinite(drive.high) else "locked"
    between = "" if drive.low == drive.high else f" ({drive.low:.3g} to {most})"
    number = f"{drive.armature:.3g} kg m²{between}, {drive.status}"
    known = drive.status if drive.status == "unknown" else number
    unused = "" if drive.used else ", not used by default"
    return f"{few(drive.joints.split(', '), 4)}: {known}{unused}: {drive.source}"


def _lines(robot: Robot) -> list[tuple[str, str]]:
    """What a designer needs to know of a robot; (name, text)."""
    srdf = (
        f" (from {robot.source.srdf.name})"
        if robot.source.srdf is not None and robot.postures
        else ""
    )
    postures = f"{', '.join(robot.postures)}{srdf}, neutral" if robot.postures else "neutral"
    followers = ", ".join(
        " ".join(
            [
                f"{m.joint} =",
                *(f"{by:g} {name} +" for name, by in m.leaders.items()),
                f"{m.offset:g}",
            ]
        )
        for m in robot.mimics
    )
    base = usual_base(robot).base
    velocities = robot.model.nv - 6 * (robot.free_base and base == "fixed")
    size = f"{moving_text(robot, base)}, {count(velocities, 'velocity')}"
    ends = "feet" if recognised(robot) and not is_arm(robot) else "tips"
    lines = {
        "robot": f"{robot.name}, {size}",
        "file": str(robot.source.path),
        "base": base_text(robot, base),
        ends: few(each_foot(robot), 12),
        "sensors": few(sensors(robot), 12)
        or "no link or site is named like an IMU, gyro, accelerometer or camera",
        "postures": f"{postures}; {reference_name(robot, None)} by default",
        "mimic": followers,
    }
    return [(name, text) for name, text in lines.items() if text or name != "mimic"]


def _bodies(robot: Robot) -> Sheet:
    """Every link, site and geom that can be a contact or a point: a row for each body, and under it
    what is fixed to it.
    """
    rows: list[Row] = []
    places = [frame for frame in robot.frames.values() if frame.kind in ("site", "geom")]
    for i, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        rows.append(
            (
                body.name,
                "body",
                robot.bodies[joint.parent].name if joint.parent >= 0 else "world",
                float(body.mass),
            )
        )
        rows += [(link, "link", body.name, None) for link in body.links[1:]]
        rows += [(place.name, place.kind, body.name, None) for place in places if place.body == i]
    header = (
        Column("name", "name"),
        Column("kind", "what"),
        Column("parent", "joined or fixed to"),
        Column("mass", "mass of the body", "kg"),
    )
    return Sheet("bodies, and what is fixed to them", header, rows)


def _joints(robot: Robot) -> Sheet:
    rows: list[Row] = []
    for joint in robot.single_joints:
        armature = float(max(robot.model.armature[joint.v], default=0.0))
        kind = "free base" if joint.kind == "free" else joint.kind
        if joint.v.stop - joint.v.start != 1:
            rows.append((joint.name, kind, None, None, None, armature))
            continue
        factor, unit = (1.0, "m") if joint.unit == "m" else (180.0 / math.pi, "deg")
        limits = [bound * factor if abs(bound) < 1e30 else None for bound in joint.limits]
        rows.append((joint.name, kind, *limits, unit, armature))
    header = (Column("name", "joint"), "kind", "lower", "upper", "unit", "armature [kg m², kg]")
    return Sheet(f"joints (read by Pinocchio {PINOCCHIO})", header, rows)
