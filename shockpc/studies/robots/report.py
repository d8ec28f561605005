"""Robots as tables: the list of those known by name, and the contents of one."""

import math
from collections.abc import Mapping

from shockpc.landing.dynamics import PINOCCHIO
from shockpc.landing.posture import reference_name
from shockpc.robot.checkup import check_robot
from shockpc.robot.drives import catalogue_drives
from shockpc.robot.elements import Drive
from shockpc.robot.feet_and_sensors import feet, sensors
from shockpc.robot.robot import Robot
from shockpc.show.document import record
from shockpc.show.header import base_text
from shockpc.show.report import Report
from shockpc.show.tables import Column, Lines, Row, Sheet
from shockpc.show.wording import count
from shockpc.text.errors import RobotError
from shockpc.text.printed import few


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
    sheet = Sheet("robots known by name", header, [_known(name, robot) for name, robot in robots.items()])
    lost = [name for name, robot in robots.items() if robot is None]
    notes = (
        f"the first {supplied} come with shockpc, the others with example-robot-data",
        *([f"cannot be loaded, which shockpc robots NAME says why: {', '.join(lost)}"] if lost else []),
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
    return name, len(robot.bodies), float(robot.mass), ", ".join(feet(robot)), ", ".join(robot.postures) or "neutral", None


def robot_report(robot: Robot) -> Report:
    """The contents of a robot, and the check-up of its file."""
    drives = catalogue_drives(robot.source.name)
    bodies, joints, findings = _bodies(robot), _joints(robot), check_robot(robot)
    reading = _second_reading(robot) if robot.source.kind == "urdf" else None
    checkup = [f"{finding.level}: {finding.where}: {finding.text}" for finding in findings] or ["nothing found"]
    return Report(
        name="robot",
        title=f"Robot {robot.name}",
        body=lambda _: [
            Lines(_lines(robot)),
            bodies,
            joints,
            *([Lines(list(map(_drive_text, drives)), "drives known", whole=True)] if drives else []),
            Lines(checkup, "check-up", whole=True),
            *([] if reading is None else [Lines(reading, "second reader", whole=True)]),
        ],
        sheets={"bodies": lambda: bodies, "joints": lambda: joints},
        document=lambda: {
            **record(robot, "name", "mass"),
            "file": str(robot.source.path),
            "base": robot.usual_base,
            "feet": feet(robot),
            "sensors": sensors(robot),
            "postures": tuple(robot.postures),
            "default_posture": reference_name(robot, None),
            "mimics": [record(mimic, "joint", "leaders", "offset") for mimic in robot.mimics],
            "drives": [{**vars(drive), "armature": drive.reflected} for drive in drives],
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
    what = f"{reading.links} links, {reading.joints} joints, limits, mimics, inertias and placements at random configurations"
    lines = [f"warning: yourdfpy: {difference}" for difference in reading.differences] or [f"yourdfpy reads the same {what}"]
    return [*lines, *(f"note: yourdfpy's check: {fault}" for fault in reading.faults)]


def _drive_text(drive: Drive) -> str:
    """A drive with its status and source; one of a simulation model is not used by default."""
    values = {
        "rotor {:.3g} kg m²": drive.rotor_inertia,
        "gear ratio {:g}": drive.gear_ratio,
        "{:.3g} kg m² at the joint": drive.reflected,
        "behind a spring of {:g} N m/rad": drive.drive_stiffness,
        "spring of the joint {:g} N m/rad": drive.stiffness,
    }
    status = f"{drive.status}, not used by default" if drive.status == "simulation model" else drive.status
    return (
        f"{', '.join(drive.joint)}: {', '.join(t.format(x) for t, x in values.items() if x is not None)} ({status}; {drive.source})"
    )


def _lines(robot: Robot) -> list[tuple[str, str]]:
    """What a designer needs to know of a robot; (name, text)."""
    srdf = f" (from {robot.source.srdf.name})" if robot.source.srdf is not None and robot.postures else ""
    postures = f"{', '.join(robot.postures)}{srdf}, neutral" if robot.postures else "neutral"
    followers = ", ".join(
        " ".join([f"{m.joint} =", *(f"{by:g} {name} +" for name, by in m.leaders.items()), f"{m.offset:g}"]) for m in robot.mimics
    )
    size = f"{robot.mass:.4g} kg, {count(len(robot.bodies), 'moving body')}, {count(robot.model.nv, 'velocity')}"
    lines = {
        "robot": f"{robot.name}, {size}",
        "file": str(robot.source.path),
        "base": base_text(robot, robot.usual_base),
        "feet": few(feet(robot), 12),
        "sensors": few(sensors(robot), 12) or "no link or site is named like an IMU, gyro, accelerometer or camera",
        "postures": f"{postures}; {reference_name(robot, None)} by default",
        "mimic": followers,
    }
    return [(name, text) for name, text in lines.items() if text or name != "mimic"]


def _bodies(robot: Robot) -> Sheet:
    """Every link, site and geom that can be a contact or a point: a row for each body, and under it what is fixed to it."""
    rows: list[Row] = []
    places = [frame for frame in robot.frames.values() if frame.kind in ("site", "geom")]
    for i, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        rows.append((body.name, "body", robot.bodies[joint.parent].name if joint.parent >= 0 else "world", float(body.mass)))
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
