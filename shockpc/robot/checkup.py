"""The check-up of a robot file: all that is odd in it but does not keep it from being computed, each with its consequence.

What does keep it is refused while it is read. Nothing is corrected here.
"""

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple
from xml.etree.ElementTree import Element

import pinocchio as pin

from shockpc.errors import RobotError
from shockpc.robot.build import build_model
from shockpc.robot.files import parse_xml
from shockpc.robot.inertias import inertia_fault, written_inertias
from shockpc.robot.source import RobotSource, resolve_asset
from shockpc.robot.urdf_numbers import vector

__all__ = ["Finding", "check_robot"]

_HEAVY = 500.0  # times the next heaviest body; grams read as kilograms stand out like this, a quadrotor's hull does not
_LIGHT = 1e-6  # of the whole robot


class Finding(NamedTuple):
    """One thing worth knowing about a robot file.

    Attributes:
        level: "error" where strikes cannot be computed, "warning" where numbers may mislead, "note" otherwise.
        where: the link, body or joint.
        text: what was found, and its consequence.
    """

    level: Literal["error", "warning", "note"]
    where: str
    text: str


def check_robot(source: RobotSource) -> tuple[Finding, ...]:
    """Check a robot file for what may mislead.

    Args:
        source: the robot as read.

    Returns:
        What was found, errors first, then warnings, then notes; empty if there is nothing.

    Raises:
        RobotError: Pinocchio cannot build the robot.
    """
    root, model = parse_xml(source.xml, source.path.name), build_model(source)
    found = [
        *_bodies_without_mass(model),
        *_inertias(root),
        *_links_without_inertia(root),
        *_armature(model, source.kind),
        *_joints(root),
        *_meshes(source, root),
    ]
    order = ("error", "warning", "note")
    return tuple(sorted(found, key=lambda finding: order.index(finding.level)))


def _bodies_without_mass(model: pin.Model) -> Iterator[Finding]:
    """Moving bodies without mass, and masses far from all the others."""
    names = {joint: model.names[joint] for joint in range(1, model.njoints)}
    for frame in reversed(list(model.frames)):
        if frame.parentJoint in names and frame.type == frame.type.BODY:
            names[frame.parentJoint] = frame.name
    masses = {joint: float(model.inertias[joint].mass) for joint in names}
    beyond = dict(masses)  # with all that hangs on it
    for joint in reversed(names):
        if model.parents[joint] in beyond:
            beyond[model.parents[joint]] += beyond[joint]
    idle = [names[joint] for joint in names if beyond[joint] == 0]
    if idle:
        one = len(idle) == 1
        yield Finding(
            "error",
            _named("body", idle),
            f"{'moves' if one else 'move'} without mass, and so does all that hangs on {'it' if one else 'them'}, so the inertia "
            "matrix cannot be inverted; give mass, or make the joint fixed",
        )
    carriers = [names[joint] for joint in names if masses[joint] == 0 and beyond[joint] > 0]
    if carriers:
        said = "moves without mass of its own; its shock" if len(carriers) == 1 else "move without mass of their own; their shock"
        yield Finding("note", _named("body", carriers), f"{said} follows from what hangs on the joints beyond")
    total = sum(masses.values())
    for joint, mass in masses.items():
        next_mass = max((other for key, other in masses.items() if key != joint), default=mass)
        if mass > _HEAVY * next_mass > 0:
            yield Finding(
                "warning",
                _named("body", [names[joint]]),
                f"{mass:g} kg is {mass / next_mass:.0f} times the next heaviest; if it is meant in grams, every shock is wrong",
            )
        elif 0 < mass < _LIGHT * total:
            yield Finding(
                "warning",
                _named("body", [names[joint]]),
                f"{mass:g} kg is less than a millionth of the robot's {total:g} kg; if it stands for nothing real, "
                "neither does its shock",
            )


def _inertias(root: Element) -> Iterator[Finding]:
    """Inertias that no body has; links with the same fault share a finding."""
    faults: dict[str, list[str]] = {}
    for link, mass, entries in written_inertias(root):
        fault = inertia_fault(mass, entries)
        if fault is not None:
            faults.setdefault(fault, []).append(link)
    for fault, links in faults.items():
        yield Finding("warning", _named("link", links), f"{fault}; shock is computed from it all the same")


def _links_without_inertia(root: Element) -> Iterator[Finding]:
    """Links of a URDF that can be seen or hit and weigh nothing."""
    names = [
        link.get("name", "")
        for link in root.findall("link")
        if link.find("inertial") is None and (link.find("visual") is not None or link.find("collision") is not None)
    ]
    if names:
        verb = "has a shape and no <inertial>; it counts" if len(names) == 1 else "have shapes and no <inertial>; they count"
        yield Finding("note", _named("link", names), f"{verb} as without mass")


def _armature(model: pin.Model, kind: str) -> Iterator[Finding]:
    """Rotors that nobody wrote down."""
    if model.armature.any():
        return
    why = "URDF has no place for it" if kind == "urdf" else "no joint gives one"
    yield Finding(
        "note",
        "every joint",
        f"zero armature ({why}): joints count as free of their motors, and with geared or locked joints the shock is another",
    )


def _joints(root: Element) -> Iterator[Finding]:
    """Followers, limits and axes of a URDF's joints."""
    for joint in root.findall("joint"):
        where = _named("joint", [joint.get("name", "")])
        for mimic in joint.findall("mimic"):
            rule = f"multiplier {mimic.get('multiplier', '1')} and offset {mimic.get('offset', '0')}"
            yield Finding("note", where, f'mimics "{mimic.get("joint")}" with {rule}; it adds no freedom of its own')
        for limit in joint.findall("limit") if joint.get("type") in ("revolute", "prismatic") else ():
            lower, upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
            if lower > upper:
                said = f"its lower limit {lower:g} is above its upper limit {upper:g}, so every posture is outside them"
                yield Finding("warning", where, said)
            elif lower == upper:
                said = f"both its limits are {lower:g}, so every other posture is outside them; it is computed all the same"
                yield Finding("note", where, said)
        for axis in joint.findall("axis"):
            length = sum(value * value for value in vector(axis.get("xyz"), 3) or ()) ** 0.5
            if joint.get("type") != "fixed" and abs(length - 1) > 1e-3:
                yield Finding("note", where, f"its axis {axis.get('xyz')} is {length:g} long, not 1; only its direction is used")


def _meshes(source: RobotSource, root: Element) -> Iterator[Finding]:
    """Meshes that cannot be had."""
    uris = [
        mesh.get("filename") or mesh.get("file") or ""
        for mesh in root.iter("mesh")
        if "filename" in mesh.attrib or "file" in mesh.attrib
    ]
    lost: list[str] = []
    for uri in dict.fromkeys(uris):
        try:
            resolve_asset(source, uri)
        except RobotError:
            lost.append(uri.rpartition("/")[2])
    if lost:
        yield Finding(
            "warning",
            f"{len(lost)} of {len(set(uris))} meshes",
            f"missing, or outside the folders that may be read: {_listed(lost)}; figures draw boxes of equal inertia instead, "
            "no number changes. If they lie in a package, say where: --package NAME=DIR",
        )


def _named(kind: str, names: list[str]) -> str:
    """One name or a few, as the subject of a finding."""
    plural = "bodies" if kind == "body" else f"{kind}s"
    return f"{plural if len(names) > 1 else kind} {_listed(names)}"


def _listed(names: Iterable[str], most: int = 3) -> str:
    """The first few names, and how many more there are."""
    quoted = [f'"{name}"' for name in names]
    return ", ".join(quoted[:most]) + (f" and {len(quoted) - most} more" if len(quoted) > most else "")
