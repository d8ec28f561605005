"""Postures and rotors that an SRDF gives to the robot of a URDF.

It is read here and not by Pinocchio, which drops a continuous joint that is given by its angle and keeps two states of one
name apart.
"""

import math
from pathlib import Path

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.robot.files import read_xml

__all__ = ["rotor_armature", "srdf_postures"]


def rotor_armature(path: Path, model: pin.Model) -> Array:
    """Reflected inertia (nv,) that an SRDF's <rotor_params> give, gear_ratio² times the rotor's inertia, over the model's own.

    The attribute that holds the rotor's inertia is called mass there [kg m²].

    Raises:
        RobotError: a number is missing, or is none that a rotor can have.
    """
    armature = np.array(model.armature)
    for entry in read_xml(path).root.iterfind("rotor_params/joint"):
        name = entry.get("name", "")
        if not model.existJointName(name):
            continue
        mass, gear = entry.get("mass", ""), entry.get("gear_ratio", "")
        inertia, ratio = _numbers(mass), _numbers(gear)
        if len(inertia) != 1 or len(ratio) != 1 or inertia[0] < 0.0:
            raise RobotError(
                f'{path.name}: the rotor of joint "{name}" has mass "{mass}" and gear_ratio "{gear}"; '
                "it takes one number each, the inertia of the rotor [kg m²] not below zero"
            )
        joint = model.joints[model.getJointId(name)]
        armature[joint.idx_v : joint.idx_v + joint.nv] = ratio[0] ** 2 * inertia[0]
    return armature


def srdf_postures(path: Path, model: pin.Model) -> dict[str, Array]:
    """Configurations (nq,) by name: what a state does not set is neutral; joints that the model does not have are passed over.

    States of one name (an arm's and a leg's) make one posture.

    Raises:
        RobotError: the file cannot be read, or gives a joint a number of values that it cannot take.
    """
    root = read_xml(path).root
    if root.tag != "robot":
        raise RobotError(f"{path.name} begins with <{root.tag}>, so it is no SRDF; give a file with <robot> and <group_state>")
    postures: dict[str, Array] = {}
    for state in root.iter("group_state"):
        name = state.get("name", "")
        q = postures.setdefault(name, np.asarray(pin.neutral(model)))
        for entry in state.iter("joint"):
            joint_name, text = entry.get("name", ""), entry.get("value", "")
            if not model.existJointName(joint_name):
                continue
            joint = model.joints[model.getJointId(joint_name)]
            values = _numbers(text)
            if len(values) == 1 and joint.nq == 2:
                values = [math.cos(values[0]), math.sin(values[0])]
            if len(values) != joint.nq:
                raise RobotError(
                    f'{path.name}: posture "{name}" gives joint "{joint_name}" the value "{text}", but it takes {joint.nq} numbers'
                )
            q[joint.idx_q : joint.idx_q + joint.nq] = values
    return {name: read_only(q) for name, q in postures.items()}


def _numbers(text: str) -> list[float]:
    """Finite numbers with blanks between them; none at all if one is not."""
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return []
    return values if all(math.isfinite(value) for value in values) else []
