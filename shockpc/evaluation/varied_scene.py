"""One quantity of a landing set to a value: the scene and the robot that the single analysis takes."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np

from shockpc.core.segments import Flex
from shockpc.evaluation.variation import (
    ATTITUDE,
    COMPONENT,
    DRIVEN,
    OF_A_LINK,
    OF_CONTACTS,
    OF_THE_SCENE,
    OFFSET,
    Variation,
    refuse_repeated,
    several_joints,
    variation,
)
from shockpc.landing.contact import contact_name, contacts_like
from shockpc.landing.flexible import flexes_of
from shockpc.landing.joint_model import JointModel, joint_model
from shockpc.landing.joint_options import Joints, Rotor
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import configuration, displaced
from shockpc.landing.scene import ORIGIN, Scene
from shockpc.landing.scene_file import plane_of, with_plane
from shockpc.robot.changes import ADDED, Change, Property, changed, links_with_mass
from shockpc.robot.gear import Gear
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

LEAST_INERTIA = np.finfo(float).tiny
"""A reflected inertia that acts as none [kg m², kg]."""

T = TypeVar("T")


def refuse_given_otherwise(scene: Scene, kind: str) -> None:
    """Refuse to vary a number that a scene does not have, because it gives the strike or the
    attitude in another way.

    Args:
        scene: the landing.
        kind: of what varies.

    Raises:
        StudyError: the speed varies, and the strike is a vector or a drop height; or the base's
            attitude is a quaternion.
    """
    strike = scene.strike
    if kind == "speed" and (strike.velocity is not None or strike.drop_height is not None):
        raise StudyError(
            "speed is varied, but the velocity is given as a vector or a drop height; leave that "
            "out"
        )
    if kind in ATTITUDE and scene.posture.base_quaternion is not None:
        raise StudyError(
            "the base's attitude is varied, but the scene gives it as a quaternion; give "
            "base_rpy_deg instead"
        )


def with_offsets(scene: Scene) -> Scene:
    """A scene in which the offsets of all contacts vary: points, from their frames' origins unless
    it says otherwise.
    """
    contacts = (
        replace(
            contact,
            at="frame" if contact.at == "auto" else contact.at,
            kind="point" if contact.kind == "auto" else contact.kind,
        )
        for contact in scene.contact
    )
    return replace(scene, contact=tuple(contacts))


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
    refuse_given_otherwise(scene, varied.kind)
    posture, strike = scene.posture, scene.strike
    axis = "xyz".find(varied.kind[-1])
    if varied.kind == "joint":
        others = {name: x for name, x in posture.joints_deg.items() if name != varied.target}
        return replace(
            scene, posture=replace(posture, joints_deg={**others, varied.target: float(value)})
        ), robot
    if varied.kind in COMPONENT:
        q, steps = configuration(robot, posture)[None], np.zeros((1, robot.model.nv))
        turned = several_joints(robot, varied.subject, varied.kind, varied.target)
        steps[0, [v for _, v in turned]] = (
            math.radians(float(value)) if varied.unit == "deg" else float(value)
        )
        (q,) = displaced(robot, q, steps)
        coordinates = {joint.name: joint.coordinates(q) for joint, _ in turned}
        return replace(
            scene,
            posture=replace(
                posture, joint_quaternions={**posture.joint_quaternions, **coordinates}
            ),
        ), robot
    if varied.kind.startswith("base-"):
        angles = list(posture.base_rpy_deg or (0.0, 0.0, 0.0))
        angles[list(ATTITUDE).index(varied.kind)] = float(value)
        return replace(
            scene, posture=replace(posture, base_rpy_deg=(angles[0], angles[1], angles[2]))
        ), robot
    if varied.kind == "speed":
        return replace(scene, strike=replace(strike, speed=float(value))), robot
    if varied.kind == "strike-angle":
        scene = with_plane(scene)  # that of the scene as it is given, in which the strike turns
        return replace(scene, strike=strike.turned(float(value), plane_of(scene))), robot
    if varied.kind == "contact":
        names = [str(value)] if str(value) in robot.frames else str(value).split("+")
        return replace(scene, contact=contacts_like(scene.contact, names)), robot
    if varied.kind.startswith("offset-"):
        moved = []
        for contact in with_offsets(scene).contact:
            offset = list(contact.offset or ORIGIN)
            offset[axis] = float(value)
            moved.append(replace(contact, offset=(offset[0], offset[1], offset[2])))
        return replace(scene, contact=tuple(moved)), robot
    if varied.kind in OF_THE_SCENE:
        given: dict[str, Any] = {OF_THE_SCENE[varied.kind]: float(value)}
        return replace(scene, **given), robot
    if varied.kind in OF_CONTACTS:
        fields: dict[str, Any] = {OF_CONTACTS[varied.kind]: float(value)}
        return replace(
            scene, contact=tuple(replace(contact, **fields) for contact in scene.contact)
        ), robot
    if varied.kind == "rotor":
        motor = replace(
            scene.joints.rotor.get(varied.target, Rotor(inertia=1.0)), inertia=float(value)
        )
        joints = replace(scene.joints, rotor=_set_last(scene.joints.rotor, {varied.target: motor}))
        return replace(scene, joints=joints), robot
    if varied.kind == "armature":
        return replace(scene, joints=_with_armature(scene, robot, varied, float(value))), robot
    if varied.kind == "joint-stiffness":
        return replace(scene, joints=_with_stiffness(scene, robot, varied, float(value))), robot
    if varied.kind == "flex":
        return _with_flex(scene, robot, varied, float(value)), robot
    return scene, changed(robot, robot_changes(robot, varied, value))


def present_value(landing: PosedLanding, varied: Variation) -> float:
    """The value that a landing has of a quantity [its unit]: 1 of a factor, 0 of what is added; NaN
    where it has not one number.
    """
    scene, robot, model, kind = landing.scene, landing.robot, landing.joint_model, varied.kind
    if varied.factor or kind in ADDED or kind in COMPONENT:
        return float(varied.factor)
    values: Iterable[float | None] = ()
    if kind == "joint":
        scale = math.degrees(1.0) if varied.unit == "deg" else 1.0
        values = [scale * joint.value(landing.q) for joint in varied.joints(robot)]
    elif kind == "strike-angle":
        values = [math.degrees(landing.strike_angle)]
    elif kind == "speed":
        values = [float(np.linalg.norm(landing.before.velocity))]
    elif kind in ATTITUDE:
        level = abs(landing.q[6]) == 1.0  # as if the base were not turned
        given = scene.posture.base_rpy_deg or ((0.0, 0.0, 0.0) if level else (None,) * 3)
        values = [given[list(ATTITUDE).index(kind)]]
    elif kind in OFFSET:
        values = [(contact.offset or ORIGIN)[list(OFFSET).index(kind)] for contact in scene.contact]
    elif kind in OF_THE_SCENE:
        values = [getattr(scene, OF_THE_SCENE[kind])]
    elif kind == "mass":
        values = links_with_mass(robot, varied.target).values()
    elif kind == "flex":
        flexes = _flexes(scene, robot)
        values = [flexes.get(body, Flex()).EI for body in robot.match_bodies(varied.target)]
    elif kind in DRIVEN:
        chosen = robot.velocities(robot.match_joints(varied.target)) & ~model.locked
        values = (
            model.armature
            if kind == "armature"
            else np.where(model.stiffness > 0.0, model.stiffness, np.nan)
        )[chosen].tolist()
    known = set(values)
    return value if len(known) == 1 and (value := known.pop()) is not None else math.nan


def robot_changes(robot: Robot, varied: Variation, value: Any) -> list[Change]:
    """The changes of a robot that set a quantity, as in `applied`; none where it is one of the
    landing.
    """
    if varied.kind not in (*OF_A_LINK, "place"):
        return []
    # Joints that do not move keep their place, and the points on what they carry.
    patterns = robot.match_joints(varied.target) if varied.kind == "place" else (varied.target,)
    return [
        Change(cast(Property, varied.kind), name, float(value), varied.factor) for name in patterns
    ]


def scene_grid(
    name: str, scene: Scene, robot: Robot, vary: Iterable[tuple[str, Any]]
) -> dict[str, Scene]:
    """All combinations of the values of several quantities, by a name that states them.

    Args:
        name: of the landing that is varied, with which the names begin, unless it is the contact
            and another one replaces that.
        scene: that landing.
        robot: its robot.
        vary: subjects with their values, as in `variation`.

    Raises:
        ShockError: a value is not possible, a quantity is one of the robot, not of the landing, or
            varied twice, or a range has no number of values.
    """
    variations = [variation(robot, subject, values) for subject, values in vary]
    refuse_repeated(robot, variations)
    replaced = name == contact_name(scene) and any(
        varied.kind == "contact" for varied in variations
    )
    scenes = {"" if replaced else name: scene}
    for varied in variations:
        subject = varied.subject
        if varied.kind in (*OF_A_LINK, "place"):
            raise StudyError(
                f"{subject}: the robot is the same in all of these landings; compare robots with "
                f"shockpc compare"
            )
        if not varied.values:
            raise StudyError(f"{subject} needs values: a:b:n (n values from a to b) or a,b,c")
        texts = [value if isinstance(value, str) else f"{value:g}" for value in varied.values]
        scenes = {
            f"{label} {subject}={text}".strip(): applied(known, robot, varied, value)[0]
            for label, known in scenes.items()
            for text, value in zip(texts, varied.values, strict=True)
        }
    return scenes


def armature_set(scene: Scene, robot: Robot, varied: Variation) -> np.ndarray:
    """Which joint velocities (nv,) have the reflected inertia that a variation sets, or multiplies.

    Raises:
        ShockError: none has, because the joints are locked, or no inertia is there to be
            multiplied.
    """
    if varied.factor:
        model = _given_drives(scene, robot)
        return _multiplied(robot, varied, (model.armature + model.rotor > 0.0) & ~model.locked)
    low, high = (
        joint_model(robot, _armature_given(scene, varied.target, value)).armature
        for value in (1.0, 2.0)
    )
    return np.asarray(low != high)


def _given_drives(scene: Scene, robot: Robot) -> JointModel:
    """The drives as they are given, whether or not their springs yield."""
    joints = scene.joints
    return joint_model(robot, replace(joints, model=None) if joints.model == "rigid" else joints)


def _multiplied(robot: Robot, varied: Variation, there: np.ndarray) -> np.ndarray:
    """The joint velocities (nv,) of a variation by factors that have something to multiply.

    Args: there (nv,), which have.
    """
    chosen: np.ndarray = there & robot.velocities(robot.match_joints(varied.target))
    if not chosen.any():
        what, unit, prismatic = DRIVEN[varied.kind]
        example = {"armature": "0.01:0.1", "joint-stiffness": "100:1000"}[varied.kind]
        raise StudyError(
            f"{varied.subject}: these joints have no {what} to multiply; give values in {unit} "
            f"({prismatic} if prismatic), such as "
            f"{example}"
        )
    return chosen


def _armature_given(scene: Scene, pattern: str, value: float) -> Joints:
    """The joint model with the reflected inertia of some joints replaced by one above zero."""
    return replace(scene.joints, armature=_set_last(scene.joints.armature, {pattern: value}))


def _set_last(values: Mapping[str, T], given: Mapping[str, T]) -> dict[str, T]:
    """Values by pattern with others after them, over which later ones go."""
    return {name: value for name, value in values.items() if name not in given} | dict(given)


def _with_armature(scene: Scene, robot: Robot, varied: Variation, value: float) -> Joints:
    """The joint model with the reflected inertia of some joints, before a spring or not, replaced
    or multiplied.
    """
    if value < 0.0:
        raise StudyError(f"{varied.subject}: a reflected inertia of {value:g} is below zero")
    if not varied.factor:
        return _armature_given(scene, varied.target, max(value, LEAST_INERTIA))
    joints, model, chosen = (
        scene.joints,
        _given_drives(scene, robot),
        armature_set(scene, robot, varied),
    )
    with_rotor = {name for pattern in joints.rotor for name in robot.match_joints(pattern)}
    armature, rotor = dict[str, float](), dict[str, Rotor]()
    for name, v in _first_velocities(robot, chosen):
        inertia, k = (
            max(value * float(model.armature[v] + model.rotor[v]), LEAST_INERTIA),
            float(model.drive_stiffness[v]),
        )
        if np.isfinite(k) or name in with_rotor or model.per_turn[v]:
            rotor[name] = reflected_rotor(inertia, k, float(model.per_turn[v]))
        else:
            armature[name] = inertia
    return replace(
        joints, armature=_set_last(joints.armature, armature), rotor=_set_last(joints.rotor, rotor)
    )


def reflected_rotor(inertia: float, k: float, per_turn: float) -> Rotor:
    """A rotor by its inertia at the joint [kg m²], the spring before it [N m/rad], and as
    `JointModel.per_turn`.
    """
    stiffness = k if np.isfinite(k) else None
    if not per_turn:
        return Rotor(inertia=inertia, gear_ratio=1.0, stiffness=stiffness)
    gear: Gear = "planetary" if per_turn > 0.0 else "harmonic"
    return Rotor(
        inertia=inertia * per_turn**2,
        gear_ratio=1.0 / abs(per_turn),
        stiffness=stiffness,
        gear=gear,
    )


def _with_stiffness(scene: Scene, robot: Robot, varied: Variation, value: float) -> Joints:
    """The joint model with the stiffness of the springs of some joints, at the joint or before
    rotors, replaced or multiplied.

    A joint without a spring gets one at the joint.

    Raises:
        ShockError: there is no spring to multiply, a joint has two, its rotor is not known, or the
            joints are locked.
    """
    joints, model = scene.joints, _given_drives(scene, robot)
    sprung, behind = model.stiffness > 0.0, np.isfinite(model.drive_stiffness)
    chosen = (
        ~model.locked & robot.actuated_dofs & robot.velocities(robot.match_joints(varied.target))
    )
    if varied.factor:
        chosen = _multiplied(robot, varied, chosen & (sprung | behind))
    faults = {
        "these joints are locked, so a spring changes nothing there; vary others": not chosen.any(),
        "the inertia of the rotor behind a spring is not known, so the spring has no effect; give "
        "it with --rotor": (chosen & behind & (model.rotor == 0.0)).any(),
        "a joint has a spring at the joint and one before its rotor; give factors, such as "
        "0.5x:2x, which multiply both": ((chosen & sprung & behind).any() and not varied.factor),
    }
    for text, wrong in faults.items():
        if wrong:
            raise StudyError(f"{varied.subject}: {text}")
    stiffness, rotor = dict[str, float](), dict[str, Rotor]()
    for name, v in _first_velocities(robot, chosen):
        if sprung[v] or not behind[v]:
            stiffness[name] = value * float(model.stiffness[v] if varied.factor else 1.0)
        if behind[v]:
            k = value * float(model.drive_stiffness[v] if varied.factor else 1.0)
            rotor[name] = reflected_rotor(float(model.rotor[v]), k, float(model.per_turn[v]))
    return replace(
        joints,
        stiffness=_set_last(joints.stiffness, stiffness),
        rotor=_set_last(joints.rotor, rotor),
    )


def _flexes(scene: Scene, robot: Robot) -> dict[int, Flex]:
    """How the bodies bend that do."""
    return {
        body: flex
        for pattern, flex in flexes_of(scene.flex)
        for body in robot.match_bodies(pattern)
    }


def _with_flex(scene: Scene, robot: Robot, varied: Variation, value: float) -> Scene:
    """The scene with the bending stiffness of some links replaced, or all stiffnesses of those
    multiplied that bend.

    Raises:
        ShockError: none of them bends.
    """
    bodies, given = robot.match_bodies(varied.target), _flexes(scene, robot)
    if varied.factor and not (bodies := tuple(body for body in bodies if body in given)):
        raise StudyError(
            f"{varied.subject}: these links do not bend, so nothing is multiplied; give values in "
            f"N m², such as 100:1000"
        )
    changed_ones = {
        robot.bodies[body].name: given[body].scaled(value)
        if varied.factor
        else given.get(body, Flex())._replace(EI=value, frequency=None)
        for body in bodies
    }
    return replace(
        scene, flex=_set_last(scene.flex, {name: str(flex) for name, flex in changed_ones.items()})
    )


def _first_velocities(robot: Robot, chosen: np.ndarray) -> Iterator[tuple[str, int]]:
    """The joints of which some velocities (nv,) are, each with the first of its velocities."""
    return ((name, v) for name in robot.joint_names if chosen[v := robot.joint(name).v.start])
