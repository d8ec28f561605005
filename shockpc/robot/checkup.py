"""The check-up of a robot: implausible data of its file, each with its consequence.

They can be computed all the same.

What cannot be computed is refused while the file is read. Nothing is corrected here.
"""

from collections.abc import Iterator
from typing import Literal, NamedTuple, TypeAlias
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.robot.files.reading import shared_xml
from shockpc.robot.files.tags import URDF, unread
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.shapes.geometry import inertias_about_origins, inflated_inertias, size_text
from shockpc.robot.tolerances import inertia_fault, negative_moment
from shockpc.robot.urdf.numbers import finite_numbers
from shockpc.robot.urdf.places import AXIS
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed, plural

# times the next heaviest body; grams read as kilograms stand out like this, a quadrotor's hull does
# not
_HEAVY = 500.0
_LIGHT = 1e-6  # of the whole robot


_NO_ARMATURE = {
    "urdf": (
        "none is read: no armature or rotor_inertia of <dynamics>, no rotor inertia of a "
        "<transmission>, no rotor_params"
    ),
    "mjcf": "no joint and no actuator on a joint has one",
    "pinocchio": "the model has none, and no rotorInertia with a rotorGearRatio",
}
"""The result of the search, by the kind of the file."""


Level: TypeAlias = Literal["error", "warning", "note"]


class Finding(NamedTuple):
    """One thing worth knowing about a robot.

    Attributes:
        level: "error" where strikes cannot be computed, "warning" where numbers may mislead, "note"
            otherwise.
        where: the link, body or joint.
        text: what was found, and its consequence.
    """

    level: Level
    where: str
    text: str


def check_robot(robot: Robot) -> tuple[Finding, ...]:
    """The findings that may mislead in a robot: errors first, then warnings, then notes."""
    root = shared_xml(robot.source.xml, robot.source.path.name)
    implausible = (
        *_read(robot, root),
        *_masses(robot),
        *_links(robot, root),
        *_about_origins(robot),
        *_drives(robot),
        *_rotors(robot),
        *_joints(robot),
        *_axes(root),
        *_meshes(robot.source, root),
    )
    names_by_text: dict[tuple[Level, str, str], list[str]] = {}
    for level, kind, name, text in implausible:
        names_by_text.setdefault((level, kind, text), []).append(name)
    findings = []
    for (level, kind, text), names in names_by_text.items():
        where = names[0]
        if kind:
            noun = kind if len(names) == 1 else plural(kind)
            where = f"{noun} {listed(names, 3)}"
        findings.append(Finding(level, where, text))
    levels = ("error", "warning", "note")
    return tuple(sorted(findings, key=lambda finding: levels.index(finding.level)))


def _read(robot: Robot, root: Element) -> Iterator[tuple[Level, str, str, str]]:
    """The findings of reading: warnings, what is left out for a reason, and loops.

    The loops are those that a URDF closes.
    """
    file = robot.source.path.name
    for warning in (*robot.source.warnings, *robot.notes):
        yield "warning", "", file, warning.removeprefix(f"{file}: ")
    if robot.source.kind == "urdf":
        for content in unread(root, URDF):
            if content.treatment == "note":
                yield "note", "", file, content.text
        for loop in robot.loops:
            if not loop.name.endswith(AXIS):
                yield "note", "loop", loop.name, "read from the file, and closed in every landing"


def _masses(robot: Robot) -> Iterator[tuple[Level, str, str, str]]:
    """Moving bodies without mass, and masses far from all the others."""
    masses = robot.masses
    # with all that each body carries
    carried = masses @ robot.ancestors[:, [joint.v.start for joint in robot.joints]]
    for k, (body, mass) in enumerate(zip(robot.bodies, masses, strict=True)):
        next_heaviest = float(np.delete(masses, k).max(initial=0.0)) or mass
        if carried[k] == 0:
            text = (
                "no mass here nor on the bodies that it carries, so the inertia matrix cannot be "
                "inverted"
            )
            yield "error", "body", body.name, f"{text}; give mass, or make the joint fixed"
        elif mass == 0:
            yield (
                "note",
                "body",
                body.name,
                "no mass here; the shock follows from what the joints beyond carry",
            )
        elif mass > _HEAVY * next_heaviest:
            text = (
                f"{mass:g} kg is {mass / next_heaviest:.0f} times the next heaviest; if it is "
                f"meant in grams, every shock is wrong"
            )
            yield "warning", "body", body.name, text
        elif mass < _LIGHT * robot.mass:
            text = f"{mass:g} kg is less than a millionth of the robot's {robot.mass:g} kg"
            yield (
                "warning",
                "body",
                body.name,
                f"{text}; if it is a placeholder, its shock has no meaning",
            )


def _links(robot: Robot, root: Element) -> Iterator[tuple[Level, str, str, str]]:
    """Links with inertias that no body has, and links of a URDF that weigh nothing."""
    for frame in robot.model.frames:
        if frame.inertia.mass > 0 and frame.type == pin.FrameType.BODY:
            fault = inertia_fault(frame.inertia.mass, frame.inertia.inertia)
            if fault is not None:
                computed = "shock is computed from it all the same"
                if negative_moment(frame.inertia.mass, frame.inertia.inertia):
                    computed += ", except where the inertia matrix is not positive definite"
                yield "warning", "link", frame.name, f"{fault}; {computed}"
    for name, radius in inflated_inertias(robot):
        text = (
            f"its moments of inertia have a radius of gyration of {radius:.3g} m, and "
            f"{size_text(robot)}; if they are placeholders, every shock is wrong"
        )
        yield "warning", "link", name, text
    for link in root.findall("link"):
        shaped = link.find("visual") is not None or link.find("collision") is not None
        if shaped and link.find("inertial") is None:
            text = "shapes but no <inertial>, which is read as no mass"
            yield "note", "link", link.get("name", ""), text


def _drives(robot: Robot) -> Iterator[tuple[Level, str, str, str]]:
    """Reflected inertia that is missing, that a simulator was given, or that is known otherwise."""
    armature, drives = robot.model.armature, robot.default_drives
    if robot.settings:
        largest = {float(armature[robot.joint(name).v].max()) for name in robot.settings}
        values = " or ".join(f"{inertia:g}" for inertia in sorted(largest))
        text = (
            f"its reflected inertia of {values} is the same for joints of different or unknown "
            "effort, as in settings of a simulator; give the drives with --drives, --rotor or "
            "--armature"
        )
        known = {} if drives is None else drives.by_joint
        for name in sorted(robot.settings - set(known)):
            yield "warning", "joint", name, text
    if drives is not None:
        used = f"{drives.label} are used by default"
        text = f"no reflected inertia is read from the file: {used}"
        if armature.any():
            text = f"{used}, over the reflected inertia of the file"
        yield "note", "", "every joint", f"{text}; --drives none leaves them out"
    elif not armature.any():
        text = (
            "zero armature "
            f"({_NO_ARMATURE.get(robot.source.kind, 'none is read from the file')}): joints are "
            "computed without the inertia of their motors; with it, or with locked joints, the "
            "shock is different"
        )
        yield "note", "", "every joint", text


def _rotors(robot: Robot) -> Iterator[tuple[Level, str, str, str]]:
    """Gear ratios without a rotor, and rotors that are links fixed to the stator."""
    bodies = {body.name for body in robot.bodies}
    for joint in robot.single_joints:
        if joint.name in robot.gear_ratios and not robot.model.armature[joint.v].any():
            text = (
                f"gear ratio {robot.gear_ratios[joint.name]:g} without the inertia of a rotor, so "
                f"it adds no reflected inertia; --rotor gives the inertia"
            )
            yield "note", "joint", joint.name, text
        rotor = f"{joint.name.removesuffix('_joint')}_rotor"
        if rotor in robot.links and rotor not in bodies:
            text = (
                "fixed to the stator, so counted as mass that does not spin with the motor; the "
                "reflected inertia is not in it"
            )
            yield "note", "link", rotor, text


def _about_origins(robot: Robot) -> Iterator[tuple[Level, str, str, str]]:
    """A warning where the inertias look as if they were given about the links' origins."""
    if links := inertias_about_origins(robot):
        text = (
            f"the inertias of {listed(links, 3)} look as if they were about the links' origins, "
            f"but files "
            "should give them about the centres of mass. They are used as they are: correct the "
            "file"
        )
        yield "warning", "", robot.source.path.name, text


def _joints(robot: Robot) -> Iterator[tuple[Level, str, str, str]]:
    """Followers, and limits that leave no range."""
    for mimic in robot.mimics:
        yield "note", "joint", mimic.joint, "following others (mimic), without a degree of freedom"
    for joint in robot.single_joints:
        lower, upper = joint.limits
        if lower > upper:
            text = (
                f"its lower limit {lower:g} is above its upper limit {upper:g}, so every posture "
                f"is outside them"
            )
            yield "warning", "joint", joint.name, text
        elif lower == upper:
            text = f"both its limits are {lower:g}, so every other posture is outside them"
            yield "note", "joint", joint.name, text


def _axes(root: Element) -> Iterator[tuple[Level, str, str, str]]:
    """Axes of a URDF that are no unit vectors."""
    for joint in root.findall("joint"):
        axis = joint.find("axis")
        if axis is None or joint.get("type") == "fixed":
            continue
        direction = finite_numbers(axis.get("xyz"), 3)
        if direction is None:
            continue
        length = float(np.linalg.norm(direction))
        if abs(length - 1) > 1e-3:
            text = (
                f"its axis {axis.get('xyz')} is {length:g} long, not 1; only its direction is used"
            )
            yield "note", "joint", joint.get("name", ""), text


def _meshes(source: RobotSource, root: Element) -> Iterator[tuple[Level, str, str, str]]:
    """Meshes of the file that are missing, or that may not be read."""
    uris: dict[str, None] = {}
    for mesh in root.iter("mesh"):
        for key in ("filename", "file"):
            if key in mesh.attrib:
                uris[mesh.attrib[key]] = None
    missing: list[str] = []
    for uri in uris:
        try:
            source.folders.asset(uri)
        except RobotError:
            missing.append(uri.rpartition("/")[2])
    if missing:
        text = (
            f"missing, or outside the folders that may be read: {listed(missing, 3)}; contacts on "
            "these links are at the origins of their frames, extremes leave them out, and figures "
            "draw boxes of equal inertia. Give their folder: --package NAME=DIR, or --meshes DIR"
        )
        yield "warning", "", f"{len(missing)} of {len(uris)} meshes", text
