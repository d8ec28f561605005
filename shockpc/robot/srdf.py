"""Postures and rotors that an SRDF gives to the robot of a URDF.

It is read here and not by Pinocchio, which drops a continuous joint that is given by its angle and keeps two states of one
name apart.
"""

import math
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.robot.files import read_xml
from shockpc.robot.urdf import vector

__all__ = ["read_srdf"]


def read_srdf(path: Path, model: pin.Model) -> tuple[dict[str, Array], Array]:
    """Read an SRDF; joints that the model does not have are passed over.

    Args:
        path: the file.
        model: the robot's.

    Returns:
        Configurations (nq,) by name, in which what a state does not set is neutral, and states of one name (an arm's and a leg's)
        make one posture; and the reflected inertia (nv,) that its <rotor_params> give, over the model's own.

    Raises:
        RobotError: the file cannot be read, or a number is missing or cannot be what it is to be.
    """
    root = read_xml(path).root
    if root.tag != "robot":
        raise RobotError(f"{path.name} begins with <{root.tag}>, so it is no SRDF; give a file with <robot> and <group_state>")
    postures: dict[str, Array] = {}
    for state in root.iter("group_state"):
        name = state.get("name", "")
        q = postures.setdefault(name, np.asarray(pin.neutral(model)))
        for entry in state.iter("joint"):
            if model.existJointName(entry.get("name", "")):
                joint = model.joints[model.getJointId(entry.get("name", ""))]
                q[joint.idx_q : joint.idx_q + joint.nq] = _values(entry, joint.nq, f'{path.name}: posture "{name}"')
    armature = np.array(model.armature)
    for entry in root.iterfind("rotor_params/joint"):
        if model.existJointName(entry.get("name", "")):
            joint = model.joints[model.getJointId(entry.get("name", ""))]
            armature[joint.idx_v : joint.idx_v + joint.nv] = _reflected_inertia(entry, path.name)
    return {name: read_only(q) for name, q in postures.items()}, armature


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
    return ratio[0] ** 2 * inertia[0]
