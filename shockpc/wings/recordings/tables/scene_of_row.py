"""The scene of a row: its posture, motion and torques over those of the scene it lacks."""

from collections.abc import Container
from dataclasses import replace

import numpy as np

from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Posture
from shockpc.landing.scenes.strike import Strike


def with_scene_of_row(landing: PosedLanding, joints: Container[str]) -> PosedLanding:
    """A landing with the scene of its row, in which loops are closed already.

    Args: joints, names of those whose positions the table gives.
    """
    scene = replace(
        landing.scene,
        posture=_posture(landing, joints),
        strike=_strike(landing),
        contact=_contacts(landing),
        joints=_joints(landing),
    )
    return replace(landing, scene=scene)


def _posture(landing: PosedLanding, joints: Container[str]) -> Posture:
    """The posture of the row, over that of the scene in whichever way that gives it."""
    robot = landing.robot
    q = landing.q
    posture = landing.scene.posture
    quaternions = dict(posture.joint_quaternions)
    for joint in robot.single_joints:
        if joint.kind == "ball" and (landing.loops or joint.name in joints):
            quaternions[joint.name] = tuple(q[joint.q].tolist())
    posture = replace(
        posture,
        joints={joint.name: joint.value(q) for joint in robot.independent_joints},
        joints_deg={},
        joint_quaternions=quaternions,
    )
    if not robot.free_base:
        return posture
    position = tuple(q[:3].tolist())
    quaternion = tuple(q[3:7].tolist())
    return replace(posture, base_rpy_deg=None, base_position=position, base_quaternion=quaternion)


def _strike(landing: PosedLanding) -> Strike:
    """The motion of the row before the impact."""
    before = landing.before
    # Rates of a closed loop depend on one another, so that all are written if any is not zero.
    loops_move = bool(landing.loops) and before.joint_rates.any()
    rates: dict[str, float] = {}
    for joint in landing.robot.independent_joints:
        if loops_move or before.joint_rates[joint.v].any():
            rates[joint.name] = float(before.joint_rates[joint.v][0])
    return Strike(
        velocity=tuple(before.velocity.tolist()),
        angular_velocity=tuple(before.omega.tolist()) if before.omega.any() else None,
        joint_velocities=rates,
    )


def _contacts(landing: PosedLanding) -> tuple[Contact, ...]:
    """The contacts of the scene with the velocities of the row."""
    contacts: list[Contact] = []
    for contact, constraint in zip(landing.scene.contact, landing.contacts, strict=True):
        velocity = None
        if constraint.velocity is not None:
            velocity = tuple(constraint.velocity.tolist())
        contacts.append(replace(contact, velocity=velocity))
    return tuple(contacts)


def _joints(landing: PosedLanding) -> Joints:
    """The joints of the scene with the torques of the row.

    Torques have an effect on finite stiffness only.
    """
    joints = landing.scene.joints
    torque = landing.joint_model.torque
    if not (np.isfinite(torque).any() and landing.scene.yields):
        return joints
    torques: dict[str, float] = {}
    for joint in landing.robot.single_joints:
        if joint.axis is not None and np.isfinite(torque[joint.v][0]):
            torques[joint.name] = float(torque[joint.v][0])
    return replace(joints, torque=torques)
