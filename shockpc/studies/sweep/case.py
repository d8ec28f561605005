"""One quantity of a landing set to a value: the scene and the robot that the single analysis takes."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Literal, cast

import numpy as np

from shockpc.errors import StudyError
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints, joint_model
from shockpc.robot.changes import Change, Property, changed
from shockpc.robot.record import Robot
from shockpc.scene import Scene
from shockpc.studies.sweep.variation import ATTITUDE, OF_A_LINK, Variation, variation

REFLECTED = "kg m² (kg if prismatic), such as 0.01:0.1"
"""What a reflected inertia is given in."""


def applied(scene: Scene, robot: Robot, varied: Variation, value: Any) -> tuple[Scene, Robot]:
    """A scene and its robot with one quantity set.

    Args:
        scene: the landing.
        robot: its robot.
        varied: the quantity.
        value: a number in its unit, or the name of a contact.

    Raises:
        ShockError: the value is not possible.
    """
    posture, strike = scene.posture, scene.strike
    axis = "xyz".find(varied.kind[-1])
    if varied.kind == "joint":
        others = {name: x for name, x in posture.joints_deg.items() if name != varied.target}
        return replace(scene, posture=replace(posture, joints_deg={**others, varied.target: float(value)})), robot
    if varied.kind.startswith("base-"):
        angles = list(posture.base_rpy_deg or (0.0, 0.0, 0.0))
        angles[list(ATTITUDE).index(varied.kind)] = float(value)
        return replace(scene, posture=replace(posture, base_rpy_deg=(angles[0], angles[1], angles[2]))), robot
    if varied.kind in ("strike-angle", "speed"):
        if strike.velocity is not None or (varied.kind == "speed" and strike.drop_height is not None):
            raise StudyError(f"{varied.kind} is varied, but the velocity is given as a vector or a drop height; leave that out")
        if strike.forward_speed is not None:
            raise StudyError(f"{varied.kind} is varied, but the scene gives a forward speed; leave that out")
        strike = replace(strike, speed=float(value)) if varied.kind == "speed" else replace(strike, strike_angle_deg=float(value))
        return replace(scene, strike=strike), robot
    if varied.kind == "contact":
        like = scene.contact[0] if scene.contact else Contact(frame="")
        names = [str(value)] if str(value) in robot.frames else str(value).split("+")
        return replace(scene, contact=tuple(replace(like, frame=name) for name in names)), robot
    if varied.kind.startswith("offset-"):
        moved = []
        for contact in scene.contact:
            offset = list(contact.offset)
            offset[axis] = float(value)
            moved.append(replace(contact, offset=(offset[0], offset[1], offset[2])))
        return replace(scene, contact=tuple(moved)), robot
    if varied.kind == "friction":
        return replace(scene, friction=float(value)), robot
    if varied.kind == "contact-stiffness":
        return replace(scene, contact_stiffness=float(value)), robot
    if varied.kind == "armature":
        return replace(scene, joints=_with_armature(scene, robot, varied, float(value))), robot
    # Joints that do not move keep their place, and the points on what they carry.
    patterns = robot.match_joints(varied.target) if varied.kind == "place" else (varied.target,)
    return scene, changed(robot, [Change(cast(Property, varied.kind), name, float(value), varied.factor) for name in patterns])


def scene_grid(name: str, scene: Scene, robot: Robot, vary: Iterable[tuple[str, Any]]) -> dict[str, Scene]:
    """All combinations of the values of several quantities, by a name that states them.

    Args:
        name: of the landing that is varied, with which the names begin.
        scene: that landing.
        robot: its robot.
        vary: subjects with their values, as in `variation`.

    Raises:
        ShockError: a value is not possible, a quantity is one of the robot, not of the landing, or a range has no number of values.
    """
    scenes = {name: scene}
    for subject, values in vary:
        varied = variation(robot, subject, values)
        if varied.kind in (*OF_A_LINK, "place"):
            raise StudyError(f"{subject}: the robot is the same in all of these landings; compare robots with shockpc compare")
        if not varied.values:
            raise StudyError(f"{subject} needs values: a:b:n (n values from a to b) or a,b,c")
        scenes = {
            f"{label} {subject}={value if isinstance(value, str) else f'{value:g}'}": applied(known, robot, varied, value)[0]
            for label, known in scenes.items()
            for value in varied.values
        }
    return scenes


def armature_set(scene: Scene, robot: Robot, varied: Variation) -> np.ndarray:
    """Which joint velocities (nv,) have the reflected inertia that a variation sets, or multiplies.

    Raises:
        ShockError: none has, because the joints are locked, or no inertia is there to be multiplied.
    """
    if varied.factor:
        model = joint_model(robot, scene.joints)
        if model.springs.any():
            raise StudyError(f"{varied.subject}: the drives have springs, which are not multiplied; give values in {REFLECTED}")
        chosen = robot.velocities(robot.match_joints(varied.target))
        chosen &= (model.armature > 0.0) & ~model.locked
        if not chosen.any():
            raise StudyError(f"{varied.subject}: these joints have no reflected inertia to multiply; give values in {REFLECTED}")
        return chosen
    low, high = (joint_model(robot, _armature_given(scene, varied.target, value)).armature for value in (1.0, 2.0))
    return np.asarray(low != high)


def _armature_given(scene: Scene, pattern: str, value: float) -> Joints:
    """The joint model with the reflected inertia of some joints replaced by one above zero."""
    others = {name: x for name, x in scene.joints.armature.items() if name != pattern}
    return replace(scene.joints, armature={**others, pattern: value})


def _with_armature(scene: Scene, robot: Robot, varied: Variation, value: float) -> Joints:
    """The joint model with the reflected inertia of some joints replaced or multiplied; zero makes them free."""
    if value > 0.0 and not varied.factor:
        return _armature_given(scene, varied.target, value)
    present = joint_model(robot, scene.joints)
    armature = np.where(armature_set(scene, robot, varied), value * present.armature, present.armature)
    kept = {name: float(armature[robot.joint(name).v.start]) for name in robot.joint_names}
    kept = {name: x for name, x in kept.items() if x > 0.0 and not present.locked[robot.joint(name).v].any()}
    model: Literal["free", "locked"] = "locked" if scene.joints.model == "locked" else "free"
    return replace(scene.joints, model=model, drives="none", armature=kept, rotor={})
