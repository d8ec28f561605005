"""The postures and rotors of an SRDF.

It is read here and not by Pinocchio, which drops a continuous joint that is given by its angle and
keeps two states of one name apart.
"""

import math
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.files.reading import read_xml
from shockpc.robot.pinocchio_joints import has_free_base
from shockpc.robot.urdf.numbers import finite_numbers
from shockpc.text.errors import RobotError


def read_srdf(path: Path, model: pin.Model, start: Array) -> dict[str, Array]:
    """Read the postures (nq,) of an SRDF, and add its rotors' reflected inertia to the model.

    Other robots' joints are skipped.
    """
    root = read_xml(path, "SRDF file")
    if root.tag != "robot" or root.find("link") is not None:
        raise RobotError(
            f"{path.name} is not an SRDF: an SRDF begins with <robot> and holds <group_state> "
            f"postures, no links"
        )
    # What a state does not set is as at the start. States of one name (an arm's and a leg's) make
    # one posture.
    postures: dict[str, Array] = {}
    for state in root.iter("group_state"):
        title = state.get("name", "")
        q = postures.setdefault(title, np.array(start))
        for entry in state.iter("joint"):
            _set_joint(q, model, entry, f'{path.name}: posture "{title}"')
    for entry in root.iterfind("rotor_params/joint"):
        if model.existJointName(entry.get("name", "")):
            _add_rotor(model, entry, path.name)
    return {name: read_only(q) for name, q in postures.items()}


def _set_joint(q: Array, model: pin.Model, entry: Element, title: str) -> None:
    """Set what a state gives of a joint in a configuration (nq,). Args: title, of the posture."""
    name = entry.get("name", "")
    text = entry.get("value", "")
    base = name == "root_joint" and has_free_base(model)
    if not base and not model.existJointName(name):
        return
    joint = model.joints[1 if base else model.getJointId(name)]
    values = finite_numbers(text, joint.nq)
    angle = finite_numbers(text, 1)
    if joint.nq == 2 and angle is not None:  # a continuous joint, given by its angle
        values = np.array([math.cos(angle[0]), math.sin(angle[0])])
    if values is None:
        raise RobotError(
            f'{title} gives joint "{name}" the value "{text}", but it takes {joint.nq} numbers',
            joints=[name],
        )
    q[joint.idx_q : joint.idx_q + joint.nq] = values


def _add_rotor(model: pin.Model, entry: Element, file: str) -> None:
    """Set the reflected inertia of a joint, ratio² · inertia of the rotor."""
    name = entry.get("name", "")
    # The attribute that holds the inertia of the rotor is called mass.
    inertia = finite_numbers(entry.get("mass"), 1)
    ratio = finite_numbers(entry.get("gear_ratio"), 1)
    if inertia is None or ratio is None or inertia[0] < 0.0:
        raise RobotError(
            f'{file}: the rotor of joint "{name}" has mass "{entry.get("mass", "")}" and '
            f'gear_ratio "{entry.get("gear_ratio", "")}"; it takes one number each, the inertia of '
            f"the rotor [kg m²] not below zero",
            joints=[name],
        )
    joint = model.joints[model.getJointId(name)]
    model.armature[joint.idx_v : joint.idx_v + joint.nv] = ratio * ratio * inertia
