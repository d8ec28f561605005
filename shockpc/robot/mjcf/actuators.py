"""Reflected inertia, springs, gears and motors of the joints of a compiled MJCF."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.mjcf.kinds import FREE, ON_JOINT, SLIDE
from shockpc.text.errors import RobotError


def armature_of(m: Any) -> Array:
    """Reflected inertia (nv,) of joints and of the actuators that act on them [kg m², kg].

    An actuator adds gear² times its own.

    Raises:
        RobotError: an armature is negative, or belongs to a tendon or to an actuator that does not
            act on a hinge or slide joint.
    """
    armature = np.array(m.dof_armature)
    for number in np.flatnonzero(getattr(m, "tendon_armature", ())):
        _refuse_armature("tendon", m.tendon(number).name)
    for number in np.flatnonzero(getattr(m, "actuator_armature", ())):
        joint = int(m.actuator_trnid[number, 0])
        if m.actuator_trntype[number] > ON_JOINT or m.jnt_type[joint] < SLIDE:
            _refuse_armature("actuator", m.actuator(number).name)
        gear = m.actuator_gear[number, 0]
        armature[m.jnt_dofadr[joint]] += m.actuator_armature[number] * gear**2
    for dof in np.flatnonzero(armature < 0):
        _refuse_armature("joint", m.joint(m.dof_jntid[dof]).name)
    return armature


def _refuse_armature(kind: str, name: str) -> None:
    raise RobotError(
        f'{kind} "{name}" has an armature that is not computed; give the hinge or slide joints an '
        "armature not below zero (of an actuator times gear²), or set it to 0"
    )


def springs_of(m: Any, joints: Sequence[int]) -> dict[str, float]:
    """Stiffness of the springs of some joints, by joint [N m/rad, N/m]; a free joint has none."""
    stiffness = np.reshape(m.jnt_stiffness, (m.njnt, -1))[:, 0]
    sprung = [joint for joint in joints if stiffness[joint] > 0 and m.jnt_type[joint] != FREE]
    return {m.joint(joint).name: float(stiffness[joint]) for joint in sprung}


def gear_ratios_of(m: Any, joints: Sequence[int]) -> dict[str, float]:
    """Gear of the actuators of some joints that have no reflected inertia, by joint."""
    armature = armature_of(m)
    ratios: dict[str, float] = {}
    for number, joint in _driven(m, joints):
        gear = float(m.actuator_gear[number, 0])
        if gear != 1.0 and not armature[m.jnt_dofadr[joint]]:
            ratios[m.joint(joint).name] = gear
    return ratios


def motors_of(m: Any, joints: Sequence[int]) -> dict[str, float]:
    """The largest effort of the actuators of some joints, by joint [N m, N].

    The forcerange limits the force of an actuator. The ctrlrange limits it too where the actuator
    is a motor, whose force is its control. The gear multiplies the force. Without a limit it is
    infinite.
    """
    motors: dict[str, float] = {}
    for number, joint in _driven(m, joints):
        force = np.inf
        if m.actuator_forcelimited[number]:
            force = np.abs(m.actuator_forcerange[number]).max()
        is_motor = m.actuator_gaintype[number] == m.actuator_biastype[number] == 0
        if m.actuator_ctrllimited[number] and is_motor:
            control = np.abs(m.actuator_ctrlrange[number]).max()
            force = min(force, abs(m.actuator_gainprm[number, 0]) * control)
        motors[m.joint(joint).name] = float(force * abs(m.actuator_gear[number, 0]))
    return motors


def _driven(m: Any, joints: Sequence[int]) -> list[tuple[int, int]]:
    """Actuators of some hinge and slide joints, each with the joint on which it acts."""
    driven = []
    for number in np.flatnonzero(m.actuator_trntype <= ON_JOINT).tolist():
        joint = int(m.actuator_trnid[number, 0])
        if joint in joints and m.jnt_type[joint] >= SLIDE:
            driven.append((number, joint))
    return driven
