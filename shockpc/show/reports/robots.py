"""Robots as tables: the list of those known by name, and the contents of one."""

import math
from collections.abc import Sequence

from shockpc.model.dynamics import PINOCCHIO
from shockpc.model.posture import reference_name
from shockpc.printed import few, printable
from shockpc.robot.landmarks import feet, sensors
from shockpc.robot.record import Robot
from shockpc.show.header import base_text, count
from shockpc.show.tables import Row, Sheet

__all__ = ["catalogue_row", "catalogue_sheet", "joints_sheet", "links_sheet", "robot_lines"]

FEET_WIDTH, POSTURES_WIDTH = 38, 32
"""Characters of these columns, which keep the list within 120 columns of a terminal."""


def catalogue_row(name: str, robot: Robot) -> Row:
    """One robot in the list of all."""
    postures = _that_fit(tuple(robot.postures), POSTURES_WIDTH) or "neutral only"
    return name, str(len(robot.bodies)), float(robot.mass), _that_fit(feet(robot), FEET_WIDTH), postures


def catalogue_sheet(rows: list[Row], own: int) -> Sheet:
    """Every robot that is known by name: a row each, the project's own first."""
    notes = (
        f"the first {own} come with shockpc, the others with example-robot-data",
        "analyze one: shockpc analyze NAME --contact FOOT",
        "show one with all its links, joints and postures: shockpc robots NAME",
    )
    header = ("robot", "bodies", "mass [kg]", "feet, or tips of the limbs", "postures")
    return Sheet("robots known by name", header, rows, notes)


def robot_lines(robot: Robot) -> list[tuple[str, str]]:
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
    return [(name, printable(text)) for name, text in lines.items() if text or name != "mimic"]


def links_sheet(robot: Robot) -> Sheet:
    """Every link, site and geom that can be a contact or a point: a row for each body, and under it what is fixed to it."""
    rows: list[Row] = []
    places = [frame for frame in robot.frames.values() if frame.kind in ("site", "geom")]
    for i, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        rows.append((body.name, "body", robot.bodies[joint.parent].name if joint.parent >= 0 else "world", float(body.mass)))
        rows += [(link, "link", body.name, None) for link in body.links[1:]]
        rows += [(place.name, place.kind, body.name, None) for place in places if place.body == i]
    header = ("name", "what", "joined or fixed to", "mass of the body [kg]")
    return Sheet("bodies, and what is fixed to them", header, rows)


def joints_sheet(robot: Robot) -> Sheet:
    """Joints with their limits, in degrees where they rotate."""
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
    header = ("joint", "kind", "lower", "upper", "unit", "armature [kg m², kg]")
    return Sheet(f"joints (read by Pinocchio {PINOCCHIO})", header, rows)


def _that_fit(names: Sequence[str], width: int) -> str:
    """As many of the names as fit into a number of characters, and how many more there are."""
    return next(
        (text for most in range(len(names), 0, -1) if len(text := few(names, most)) <= width), printable(few(names, 1), width)
    )
