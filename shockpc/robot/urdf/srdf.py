"""The postures and rotors of an SRDF.

It is read here and not by Pinocchio, which drops a continuous joint that is given by its angle and
keeps two states of one name apart.
"""

import math
from pathlib import Path

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.files.reading import read_xml
from shockpc.robot.urdf.numbers import vector
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
        q = postures.setdefault(state.get("name", ""), np.array(start))
        for entry in state.iter("joint"):
            name, text = entry.get("name", ""), entry.get("value", "")
            base = name == "root_joint" and model.joints[1].shortname() == "JointModelFreeFlyer"
            if not base and not model.existJointName(name):
                continue
            joint = model.joints[1 if base else model.getJointId(name)]
            values, angle = vector(text, joint.nq), vector(text, 1)
            if joint.nq == 2 and angle is not None:  # a continuous joint, given by its angle
                values = np.array([math.cos(angle[0]), math.sin(angle[0])])
            if values is None:
                message = (
                    f'{path.name}: posture "{state.get("name", "")}" gives joint "{name}" the '
                    f'value "{text}"'
                )
                raise RobotError(f"{message}, but it takes {joint.nq} numbers", joints=[name])
            q[joint.idx_q : joint.idx_q + joint.nq] = values
    for entry in root.iterfind("rotor_params/joint"):
        name = entry.get("name", "")
        if model.existJointName(name):
            # The attribute that holds the inertia of the rotor is called mass.
            inertia, ratio = (vector(entry.get(key), 1) for key in ("mass", "gear_ratio"))
            if inertia is None or ratio is None or inertia[0] < 0.0:
                raise RobotError(
                    f'{path.name}: the rotor of joint "{name}" has mass "{entry.get("mass", "")}" '
                    f"and gear_ratio "
                    f'"{entry.get("gear_ratio", "")}"; it takes one number each, the inertia of '
                    f"the rotor [kg m²] not below zero",
                    joints=[name],
                )
            joint = model.joints[model.getJointId(name)]
            model.armature[joint.idx_v : joint.idx_v + joint.nv] = ratio * ratio * inertia
    return {name: read_only(q) for name, q in postures.items()}
