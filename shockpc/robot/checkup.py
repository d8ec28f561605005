"""The check-up of a robot: all that is odd in its file but does not keep it from being computed, each with its consequence.

What does keep it is refused while it is read. Nothing is corrected here.
"""

from collections.abc import Iterator
from typing import Literal, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.errors import RobotError
from shockpc.printed import listed
from shockpc.robot.files import parse_xml
from shockpc.robot.limits import inertia_fault
from shockpc.robot.robot import Robot
from shockpc.robot.source import RobotSource
from shockpc.robot.urdf import vector

__all__ = ["Finding", "check_robot"]

_HEAVY = 500.0  # times the next heaviest body; grams read as kilograms stand out like this, a quadrotor's hull does not
_LIGHT = 1e-6  # of the whole robot


class Finding(NamedTuple):
    """One thing worth knowing about a robot.

    Attributes:
        level: "error" where strikes cannot be computed, "warning" where numbers may mislead, "note" otherwise.
        where: the link, body or joint.
        text: what was found, and its consequence.
    """

    level: Literal["error", "warning", "note"]
    where: str
    text: str


def check_robot(robot: Robot) -> tuple[Finding, ...]:
    """Check a robot for what may mislead. Returns what was found: errors first, then warnings, then notes."""
    root = parse_xml(robot.source.xml, robot.source.path.name)
    found = (*_masses(robot), *_links(robot, root), *_joints(robot, root), *_meshes(robot.source, root))
    return tuple(sorted(found, key=lambda finding: ("error", "warning", "note").index(finding.level)))


def _masses(robot: Robot) -> Iterator[Finding]:
    """Moving bodies without mass, and masses far from all the others."""
    names, masses = [body.name for body in robot.bodies], robot.masses
    beyond = masses @ robot.moves[:, [joint.v.start for joint in robot.joints]]  # with all that hangs on each body
    idle = [name for name, total in zip(names, beyond, strict=True) if total == 0]
    if idle:
        said = "no mass here nor on what hangs there, so the inertia matrix cannot be inverted; give mass, or make the joint fixed"
        yield Finding("error", _named("body", idle), said)
    carriers = [name for name, mass, total in zip(names, masses, beyond, strict=True) if mass == 0 < total]
    if carriers:
        yield Finding("note", _named("body", carriers), "no mass here; the shock follows from what hangs on the joints beyond")
    for body, (name, mass) in enumerate(zip(names, masses, strict=True)):
        next_mass = float(np.delete(masses, body).max(initial=0.0)) or mass
        if mass > _HEAVY * next_mass > 0:
            said = f"{mass:g} kg is {mass / next_mass:.0f} times the next heaviest; if it is meant in grams, every shock is wrong"
            yield Finding("warning", _named("body", [name]), said)
        elif 0 < mass < _LIGHT * robot.mass:
            said = f"less than a millionth of the robot's {robot.mass:g} kg; if it is a placeholder, its shock has no meaning"
            yield Finding("warning", _named("body", [name]), f"{mass:g} kg is {said}")


def _links(robot: Robot, root: Element) -> Iterator[Finding]:
    """Links with inertias that no body has, those with the same fault together; and links of a URDF that weigh nothing."""
    faults: dict[str, list[str]] = {}
    for frame in robot.model.frames:
        if frame.type == pin.FrameType.BODY and frame.inertia.mass > 0:
            fault = inertia_fault(frame.inertia.mass, frame.inertia.inertia)
            if fault is not None:
                faults.setdefault(fault, []).append(frame.name)
    for fault, links in faults.items():
        yield Finding("warning", _named("link", links), f"{fault}; shock is computed from it all the same")
    bare = [link for link in root.findall("link") if link.find("inertial") is None]
    names = [link.get("name", "") for link in bare if link.find("visual") is not None or link.find("collision") is not None]
    if names:
        yield Finding("note", _named("link", names), "shapes but no <inertial>, which counts as no mass")


def _joints(robot: Robot, root: Element) -> Iterator[Finding]:
    """Missing armature, followers, limits, and axes that are no unit vectors."""
    if not robot.model.armature.any():
        why = "URDF has no place for it" if robot.source.kind == "urdf" else "no joint gives one"
        yield Finding(
            "note",
            "every joint",
            f"zero armature ({why}): joints are computed without the inertia of their motors; "
            "with geared or locked joints the shock is different",
        )
    for mimic in robot.mimics:
        rule = "".join(f"multiplier {multiplier:g} and " for multiplier in mimic.leaders.values()) + f"offset {mimic.offset:g}"
        yield Finding("note", _named("joint", [mimic.joint]), f"mimics {mimic.led} with {rule}; it adds no freedom of its own")
    for joint in robot.single_joints:
        lower, upper = joint.limits
        if lower > upper:
            said = f"its lower limit {lower:g} is above its upper limit {upper:g}, so every posture is outside them"
            yield Finding("warning", _named("joint", [joint.name]), said)
        elif lower == upper:
            said = f"both its limits are {lower:g}, so every other posture is outside them; it is computed all the same"
            yield Finding("note", _named("joint", [joint.name]), said)
    for element in root.findall("joint"):
        for axis in element.findall("axis"):
            direction = vector(axis.get("xyz", "1 0 0"), 3)
            length = 1.0 if direction is None else float(np.linalg.norm(direction))
            if element.get("type") != "fixed" and abs(length - 1) > 1e-3:
                said = f"its axis {axis.get('xyz')} is {length:g} long, not 1; only its direction is used"
                yield Finding("note", _named("joint", [element.get("name", "")]), said)


def _meshes(source: RobotSource, root: Element) -> Iterator[Finding]:
    """Meshes that cannot be read."""
    uris = {uri: None for mesh in root.iter("mesh") for key in ("filename", "file") if (uri := mesh.get(key))}
    lost: list[str] = []
    for uri in uris:
        try:
            source.folders.asset(uri)
        except RobotError:
            lost.append(uri.rpartition("/")[2])
    if lost:
        yield Finding(
            "warning",
            f"{len(lost)} of {len(uris)} meshes",
            f"missing, or outside the folders that may be read: {listed(lost, 3)}; figures draw boxes of equal inertia instead, "
            "no number changes. If they lie in a package, say where: --package NAME=DIR",
        )


def _named(kind: str, names: list[str]) -> str:
    """One name or a few, as the subject of a finding."""
    plural = "bodies" if kind == "body" else f"{kind}s"
    return f"{plural if len(names) > 1 else kind} {listed(names, 3)}"
