"""The Pinocchio model of a checked URDF on a free base, with its mimic joints, and the postures and rotors of its SRDF.

The SRDF is read here and not by Pinocchio, which drops a continuous joint that is given by its angle and keeps two states of one
name apart.
"""

import math
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.robot.couplings import Built, Mimic, leaders_first
from shockpc.robot.files import parse_xml, read_xml
from shockpc.robot.source import RobotSource
from shockpc.robot.urdf import moving_parts, vector

__all__ = ["WORLD", "build_urdf"]

WORLD = "world"
"""A root link of this name stands for the ground: the robot is fixed to it unless the scene says otherwise."""


def build_urdf(source: RobotSource) -> Built:
    """Build the Pinocchio model of a URDF.

    Raises:
        RobotError: Pinocchio refuses the text, joints follow one another in a circle, or the SRDF cannot be read.
    """
    root = parse_xml(source.xml, source.path.name)
    try:
        model, start, notes = _on_its_base(root, source.path.name)
    except (ValueError, RuntimeError, IndexError) as refusal:
        raise RobotError(f"{source.path.name}: Pinocchio cannot read it: {' '.join(str(refusal).split())}") from None
    postures = _read_srdf(source.srdf, model, start) if source.srdf is not None else {}
    # A fixed joint follows nothing; one that follows a fixed joint keeps its offset.
    mimics = [
        Mimic(joint.get("name", ""), {rule.get("joint", ""): float(rule.get("multiplier", "1"))}, float(rule.get("offset", "0")))
        for joint in root.iter("joint")
        for rule in joint.findall("mimic")
        if model.existJointName(joint.get("name", ""))
    ]
    freedom = {name: joint.nv for name, joint in zip(model.names, model.joints, strict=True)}
    return Built(model, start, postures, leaders_first(mimics, freedom, source.path.name), notes=notes)


def _on_its_base(urdf: Element, file: str) -> tuple[pin.Model, Array, tuple[str, ...]]:
    """The model on a floating base, the configuration (nq,) in which its joints are neutral, and warnings.

    A root link that is called "world", or has no mass, and carries nothing but a floating or planar joint is the world, and that
    joint is the floating base. It stands where its configuration says; its origin in the file is only where it starts.
    """
    model = pin.buildModelFromXML(moving_parts(urdf), pin.JointModelFreeFlyer())
    notes: tuple[str, ...] = ()
    root = next(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)
    carried = [joint for joint, parent in enumerate(model.parents) if parent == 1]
    kind = model.joints[carried[0]].shortname() if len(carried) == 1 and (root == WORLD or not model.inertias[1].mass) else ""
    if kind in ("JointModelFreeFlyer", "JointModelPlanar"):
        name = model.names[carried[0]]
        if kind == "JointModelPlanar":
            next(joint for joint in urdf.findall("joint") if joint.get("name") == name).set("type", "floating")
            notes = (
                f'{file}: joint "{name}" is planar and carries the whole robot, so it is computed as a floating base; '
                "--base planar keeps it in the plane of the study",
            )
        model = pin.buildModelFromXML(moving_parts(urdf))
    start = pin.neutral(model)
    start[:7] = pin.SE3ToXYZQUAT(model.jointPlacements[1])
    model.jointPlacements[1] = pin.SE3.Identity()
    return model, read_only(start), notes


def _read_srdf(path: Path, model: pin.Model, start: Array) -> dict[str, Array]:
    """Read the postures (nq,) of an SRDF, and add its rotors' reflected inertia to the model; other robots' joints are skipped.

    What a state does not set is as at the start. States of one name (an arm's and a leg's) make one posture.

    Raises:
        RobotError: the file is no SRDF, or a number is missing or cannot be what it is to be.
    """
    root = read_xml(path, "SRDF file").root
    if root.tag != "robot" or root.find("link") is not None:
        raise RobotError(f"{path.name} is not an SRDF: an SRDF begins with <robot> and holds <group_state> postures, no links")
    postures: dict[str, Array] = {}
    for state in root.iter("group_state"):
        name = state.get("name", "")
        q = postures.setdefault(name, np.array(start))
        for entry in state.iter("joint"):
            called = entry.get("name", "")
            if called == "root_joint" or model.existJointName(called):
                joint = model.joints[1 if called == "root_joint" else model.getJointId(called)]
                q[joint.idx_q : joint.idx_q + joint.nq] = _values(entry, joint.nq, f'{path.name}: posture "{name}"')
    armature = np.array(model.armature)
    for entry in root.iterfind("rotor_params/joint"):
        if model.existJointName(entry.get("name", "")):
            joint = model.joints[model.getJointId(entry.get("name", ""))]
            armature[joint.idx_v : joint.idx_v + joint.nv] = _reflected_inertia(entry, path.name)
    model.armature = armature
    return {name: read_only(q) for name, q in postures.items()}


def _values(entry: Element, size: int, whose: str) -> tuple[float, ...]:
    """The coordinates of a joint in a posture; a continuous joint may be given by its angle."""
    text = entry.get("value", "")
    angle = vector(text, 1)
    if size == 2 and angle:
        return math.cos(angle[0]), math.sin(angle[0])
    values = vector(text, size)
    if values is None:
        raise RobotError(f'{whose} gives joint "{entry.get("name")}" the value "{text}", but it takes {size} numbers')
    return values


def _reflected_inertia(entry: Element, file: str) -> float:
    """gear_ratio² times the rotor's inertia [kg m²]; the attribute that holds that inertia is called mass."""
    mass, gear = entry.get("mass", ""), entry.get("gear_ratio", "")
    inertia, ratio = vector(mass, 1), vector(gear, 1)
    if inertia is None or ratio is None or inertia[0] < 0.0:
        raise RobotError(
            f'{file}: the rotor of joint "{entry.get("name")}" has mass "{mass}" and gear_ratio "{gear}"; '
            "it takes one number each, the inertia of the rotor [kg m²] not below zero"
        )
    return ratio[0] * ratio[0] * inertia[0]
