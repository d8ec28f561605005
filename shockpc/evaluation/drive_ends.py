"""A study with all drives at the smallest inertias that are possible, and with all at the largest.

These are two corners of what is known. Drives in between may give values outside these two, as the
range of a number over the drives (`judgement.drive_range`) shows. An optimum or a limit has no such
law, so the study is made again.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Literal, TypeVar

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.kinds.joints import LEAST_INERTIA, reflected_rotor
from shockpc.landing.joint_model import JointModel, joint_model
from shockpc.landing.scenes.joint_options import Joints, Rotor
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import check_scene
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import ShockWarning
from shockpc.text.errors import ShockError, attempt

End = Literal["smallest", "largest"]
"""The inertias that all drives have."""

ENDS: tuple[End, End] = ("smallest", "largest")

MOVED = 0.01
"""Share of a number by which it differs between the ends for both to be given."""

BETWEEN = "the smallest to the largest possible inertias"
"""The inertias between which answers are compared, in words."""

AT_BOTH = "with the smallest and the largest possible inertias"
"""Over tables of both ends."""

BEYOND = "drives in between may give values outside these two"
"""The limitation of these two ends, in words."""

T = TypeVar("T")


def at_drive_ends(
    modelled: T, cases: Mapping[str, tuple[Scene, Robot]], compute: Callable[[dict[str, Scene]], T]
) -> dict[End, T | ShockError]:
    """A study at both ends of the drives, or the error; nothing if all drives are known exactly.

    Args:
        modelled: the study for the drives as modelled, which is that of an end with the same
            inertias.
        cases: scene and robot of each landing, by name.
        compute: makes the study of the landings with other drives, by name.
    """
    cases = {name: (check_scene(scene), robot) for name, (scene, robot) in cases.items()}
    models = {name: joint_model(robot, scene.joints) for name, (scene, robot) in cases.items()}
    unknown = [np.any(model.low < model.high) for model in models.values()]
    if not any(unknown):
        return {}
    studies: dict[End, T | ShockError] = {}
    for end in ENDS:
        if all(_as_modelled(model, end) for model in models.values()):
            studies[end] = modelled
            continue
        scenes: dict[str, Scene] = {}
        for name, (scene, robot) in cases.items():
            joints = _joints_at(robot, scene.joints, models[name], end)
            scenes[name] = replace(scene, joints=joints)
        # The study with the drives as modelled has given the warnings of these landings already.
        with warnings.catch_warnings(action="ignore", category=ShockWarning):
            studies[end] = attempt(compute, scenes)
    return studies


def any_moves(ends: Mapping[End, T | ShockError], moves: Callable[[T], bool]) -> bool:
    """True if an end has no answer, or one that differs.

    Args:
        ends: of `at_drive_ends`.
        moves: True for a study that differs from that with the drives as modelled.
    """
    return any(isinstance(end, ShockError) or moves(end) for end in ends.values())


def answer_lines(
    modelled: T, ends: Mapping[End, T | ShockError], answer: Callable[[T], str]
) -> list[str]:
    """A line for the answer as modelled, and for that at each end.

    Args:
        modelled: the study with the drives as modelled.
        ends: of `at_drive_ends`.
        answer: the answer of a study in words.
    """
    lines = [f"  as modelled: {answer(modelled)}"]
    for end, result in ends.items():
        words = f"none, because {result}" if isinstance(result, ShockError) else answer(result)
        lines.append(f"  {end} inertias: {words}")
    return lines


def _inertias(model: JointModel, end: End) -> Array:
    """The reflected inertias (nv,) of an end; infinite where a joint is held."""
    return model.low if end == "smallest" else model.high


def _as_modelled(model: JointModel, end: End) -> bool:
    """True if an end has the inertias of the model."""
    return np.array_equal(_inertias(model, end), model.armature)


def _joints_at(robot: Robot, joints: Joints, model: JointModel, end: End) -> Joints:
    """The joints of a scene as in a joint model, drives that are not known exactly at an end."""
    inertias = _inertias(model, end)
    unknown = model.low < model.high
    locked = _held_joints(robot, model.locked | np.isinf(inertias))
    armature: dict[str, float] = {}
    rotor: dict[str, Rotor] = {}
    stiffness: dict[str, float] = {}
    for joint in robot.single_joints:
        if joint.kind == "free" or joint.name in locked:
            continue
        v = joint.v.start
        inertia = float(inertias[v])
        per_turn = float(model.per_turn[v])
        if model.stiffness[v] > 0.0:
            stiffness[joint.name] = float(model.stiffness[v])
        if model.rotor[v] > 0.0 and not unknown[v]:
            # A rotor behind a spring, as it is.
            spring = float(model.drive_stiffness[v])
            rotor[joint.name] = reflected_rotor(float(model.rotor[v]), spring, per_turn)
        elif inertia > 0.0 and per_turn:
            rotor[joint.name] = reflected_rotor(inertia, np.inf, per_turn)
        elif inertia > 0.0 or robot.model.armature[v] > 0.0:
            armature[joint.name] = max(inertia, LEAST_INERTIA)
    return Joints(
        drives="none",
        motors=joints.motors,
        carried=joints.carried,
        armature=armature,
        rotor=rotor,
        stiffness=stiffness,
        torque=joints.torque,
        locked=tuple(locked),
    )


def _held_joints(robot: Robot, held: np.ndarray) -> list[str]:
    """The joints all of whose velocities (nv,) are held, and those that follow only such joints."""
    names = [
        joint.name for joint in robot.single_joints if held[joint.v].all() and joint.kind != "free"
    ]
    for mimic in robot.mimics:
        follows_held = mimic.leaders and set(mimic.leaders) <= set(names)
        if follows_held and mimic.joint not in names:
            names.append(mimic.joint)
    return names
