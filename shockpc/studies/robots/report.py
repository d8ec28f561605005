"""Robots as tables: the list of those known by name, and the contents of one."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from shockpc.core.interval import interval_text
from shockpc.landing.joint_model import NOTHING, joint_model
from shockpc.landing.posture import reference_name
from shockpc.landing.scenes.joint_options import Joints
from shockpc.method.dynamics import PINOCCHIO
from shockpc.robot.bodies_and_joints import Drive, Mimic
from shockpc.robot.checkup import check_robot
from shockpc.robot.drives.drive_file import PUBLIC, catalogue_drives
from shockpc.robot.feet_and_sensors import each_foot, recognised, sensors
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import is_arm, usual_base
from shockpc.show.document import record
from shockpc.show.header import base_text, moving_text
from shockpc.show.report import Report, Section
from shockpc.show.tables import Heading, Lines, Row, Sheet
from shockpc.text.errors import RobotError
from shockpc.text.printed import count, few

NO_SENSOR = "no link or site is named like an IMU, gyro, accelerometer or camera"
"""In place of the sensors of a robot that has none."""

NO_LIMIT = 1e30
"""Limits of this size are none [rad, m]."""


def robots_report(robots: Mapping[str, Robot | None], supplied: int) -> Report:
    """Every robot that is known by name: a row each.

    Args:
        robots: by name; None for one that cannot be loaded.
        supplied: number of those, the first, that come with shockpc.
    """
    header = (
        *("robot", "bodies", "mass [kg]"),
        Heading("feet", "feet, or tips of the limbs", width=38),
        Heading("postures", "postures", width=32),
        "message",
    )
    rows = [_known(name, robot) for name, robot in robots.items()]
    sheet = Sheet("robots known by name", header, rows)
    notes = [f"the first {supplied} come with shockpc, the others with example-robot-data"]
    lost = [name for name, robot in robots.items() if robot is None]
    if lost:
        notes.append(f"cannot be loaded, which shockpc robots NAME says why: {', '.join(lost)}")
    notes += [
        "analyze one: shockpc analyze NAME --contact FOOT",
        "show one with all its links, joints and postures: shockpc robots NAME",
    ]
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
    bodies, joints = _bodies(robot), _joints(robot)
    findings = check_robot(robot)
    checkup = [f"{finding.level}: {finding.where}: {finding.text}" for finding in findings]
    reading = None
    if robot.source.kind == "urdf":
        reading = _second_reading(robot)

    body: list[Section] = [Lines(_lines(robot)), bodies, joints]
    if drives:
        body.append(Lines(list(map(_drive_line, drives)), "drives", whole=True))
    body.append(Lines(checkup or ["nothing found"], "check-up", whole=True))
    if reading is not None:
        body.append(Lines(reading, "second reader", whole=True))
    return Report(
        name="robot",
        title=f"Robot {robot.name}",
        body=lambda _: body,
        sheets={
            "bodies": lambda: bodies,
            "joints": lambda: joints,
            "drives": lambda: _drives_sheet(drives),
        },
        document=lambda: _document(robot) | {"check_up": findings, "second_reader": reading},
        tables=True,
    )


def _document(robot: Robot) -> dict[str, Any]:
    """The entries of a robot's document that are no tables, without the check-up."""
    base = usual_base(robot).base
    return {
        "name": robot.name,
        "mass": float(robot.masses[robot.movable(base)].sum()),
        "file": str(robot.source.path),
        "base": base,
        "feet": each_foot(robot),
        "sensors": sensors(robot),
        "postures": tuple(robot.postures),
        "default_posture": reference_name(robot, None),
        "mimics": [record(mimic, "joint", "leaders", "offset") for mimic in robot.mimics],
    }


def _second_reading(robot: Robot) -> list[str]:
    """Lines on the differences to a second reader of URDFs, and on the faults that it reports."""
    try:
        from shockpc.robot.urdf.second_reader import second_reading

        reading = second_reading(robot)
    except RobotError as refusal:
        return [f"warning: {refusal}"]
    lines = [f"warning: yourdfpy: {difference}" for difference in reading.differences]
    if not lines:
        lines.append(
            f"yourdfpy reads the same {reading.links} links, {reading.joints} joints, limits, "
            f"mimics, inertias and placements at random configurations"
        )
    return lines + [f"note: yourdfpy's check: {fault}" for fault in reading.faults]


class _Known(NamedTuple):
    """The known properties of the drives of some joints.

    Attributes:
        joints: their names.
        low: smallest reflected inertia [kg m², kg].
        armature: the one of the model [kg m², kg].
        high: the largest; infinite where the joint is held.
        status: how it is known.
        used: whether a landing takes it by default; not of a simulation model, or of unknown
            inertia.
        source: parts of the drive, and where they are from.
    """

    joints: str
    low: float
    armature: float
    high: float
    status: str
    used: bool
    source: str


def _drives(robot: Robot) -> list[_Known]:
    """The known properties of drives; one for all joints with the same numbers and source.

    Those that a landing takes by default come first, then those of the catalogue that it does not
    take.
    """
    return [*_used_drives(robot), *_unused_drives(robot)]


def _used_drives(robot: Robot) -> Iterator[_Known]:
    """The drives that a landing takes by default."""
    model = joint_model(robot, Joints())
    by_joint = {} if robot.default_drives is None else robot.default_drives.by_joint
    for source in model.sources:
        joints_by_numbers: dict[tuple[float, float, float], list[str]] = {}
        for name in source.joints:
            v = robot.joint(name).v.start
            numbers = model.low[v], model.armature[v] + model.rotor[v], model.high[v]
            low, armature, high = map(float, numbers)
            joints_by_numbers.setdefault((low, armature, high), []).append(name)
        for numbers, names in joints_by_numbers.items():
            parts = _parts(by_joint.get(names[0], Drive(joint=())))
            text = f"{parts}{source.text}"
            yield _Known(", ".join(names), *numbers, source.status, used=True, source=text)


def _unused_drives(robot: Robot) -> Iterator[_Known]:
    """The drives of the catalogue that a landing does not take."""
    for drive in catalogue_drives(robot.source.name):
        if drive.status not in PUBLIC:
            low, high = drive.interval
            inertia = drive.reflected or 0.0
            text = f"{_parts(drive)}{drive.source}"
            status = str(drive.status)
            yield _Known(", ".join(drive.joint), low, inertia, high, status, False, text)


def _parts(drive: Drive) -> str:
    """The parts of a drive, before its source."""
    values = {
        "rotor {} kg m²": drive.rotor_inertia,
        "gear ratio {}": drive.gear_ratio,
        "spring of {} N m/rad": drive.drive_stiffness,
    }
    texts = []
    for text, value in values.items():
        if value is not None:
            texts.append(text.format(interval_text(value)))
    return f"{', '.join(texts)}; " if texts else ""


def _drives_sheet(drives: list[_Known]) -> Sheet:
    rows: list[Row] = []
    for drive in drives:
        used = "yes" if drive.used else "no"
        inertias = drive.low, drive.armature, drive.high
        rows.append((drive.joints, *inertias, drive.status, used, drive.source))
    header = (
        Heading("joints", "joints"),
        Heading("low", "smallest reflected inertia", "kg m², kg"),
        Heading("armature", "as modelled", "kg m², kg"),
        Heading("high", "largest", "kg m², kg"),
        *("status", "used", "source"),
    )
    return Sheet("drives", header, rows)


def _drive_line(drive: _Known) -> str:
    """The known properties of some drives, for people."""
    names = few(drive.joints.split(", "), 4)
    if drive.source.startswith(NOTHING):
        return f"{names}: {drive.source}"
    known = drive.status
    if drive.status != "unknown":
        known = f"{_inertia_text(drive)}, {drive.status}"
    unused = "" if drive.used else ", not used by default"
    return f"{names}: {known}{unused}: {drive.source}"


def _inertia_text(drive: _Known) -> str:
    """The reflected inertia with its interval."""
    text = f"{drive.armature:.3g} kg m²"
    if drive.low == drive.high:
        return text
    most = f"{drive.high:.3g}" if math.isfinite(drive.high) else "locked"
    return f"{text} ({drive.low:.3g} to {most})"


def _lines(robot: Robot) -> list[tuple[str, str]]:
    """Lines (name, text) with what a designer needs to know of a robot."""
    base = usual_base(robot).base
    velocities = robot.model.nv
    if robot.free_base and base == "fixed":
        velocities -= 6
    ends = "feet" if recognised(robot) and not is_arm(robot) else "tips"
    sensors_text = few(sensors(robot), 12)
    lines = {
        "robot": f"{robot.name}, {moving_text(robot, base)}, {count(velocities, 'velocity')}",
        "file": str(robot.source.path),
        "base": base_text(robot, base),
        ends: few(each_foot(robot), 12),
        "sensors": sensors_text or NO_SENSOR,
        "postures": f"{_postures_text(robot)}; {reference_name(robot, None)} by default",
    }
    if robot.mimics:
        lines["mimic"] = ", ".join(map(_mimic_text, robot.mimics))
    return list(lines.items())


def _postures_text(robot: Robot) -> str:
    """The postures of a robot, and the file that they are from."""
    if not robot.postures:
        return "neutral"
    names = ", ".join(robot.postures)
    if robot.source.srdf is not None:
        names += f" (from {robot.source.srdf.name})"
    return f"{names}, neutral"


def _mimic_text(mimic: Mimic) -> str:
    """The position of a joint that follows others, by theirs."""
    terms = [f"{factor:g} {name}" for name, factor in mimic.leaders.items()]
    return f"{mimic.joint} = {' + '.join([*terms, f'{mimic.offset:g}'])}"


def _bodies(robot: Robot) -> Sheet:
    """Every link, site and geom that can be a contact or a point.

    A row for each body, and under it what is fixed to it.
    """
    rows: list[Row] = []
    places = [frame for frame in robot.frames.values() if frame.kind in ("site", "geom")]
    for i, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        parent = "world"
        if joint.parent >= 0:
            parent = robot.bodies[joint.parent].name
        rows.append((body.name, "body", parent, float(body.mass)))
        rows += [(link, "link", body.name, None) for link in body.links[1:]]
        rows += [(place.name, place.kind, body.name, None) for place in places if place.body == i]
    header = (
        Heading("name", "name"),
        Heading("kind", "what"),
        Heading("parent", "joined or fixed to"),
        Heading("mass", "mass of the body", "kg"),
    )
    return Sheet("bodies, and what is fixed to them", header, rows)


def _joints(robot: Robot) -> Sheet:
    """Every joint with its limits, None where there are none, and its armature."""
    rows: list[Row] = []
    for joint in robot.single_joints:
        armature = float(max(robot.model.armature[joint.v], default=0.0))
        kind = "free base" if joint.kind == "free" else joint.kind
        if joint.v.stop - joint.v.start != 1:
            rows.append((joint.name, kind, None, None, None, armature))
            continue
        factor, unit = math.degrees(1.0), "deg"
        if joint.unit == "m":
            factor, unit = 1.0, "m"
        limits: list[float | None] = []
        for limit in joint.limits:
            limits.append(limit * factor if abs(limit) < NO_LIMIT else None)
        rows.append((joint.name, kind, *limits, unit, armature))
    header = (Heading("name", "joint"), "kind", "lower", "upper", "unit", "armature [kg m², kg]")
    return Sheet(f"joints (read by Pinocchio {PINOCCHIO})", header, rows)
