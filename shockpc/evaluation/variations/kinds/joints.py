"""Kinds of joints: the drives' inertias and springs, and the places of joints."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.kinds.posture import common_unit
from shockpc.evaluation.variations.row_arrays import RowInertias
from shockpc.evaluation.variations.variation import (
    Factors,
    Kind,
    Options,
    Scale,
    Target,
    Variation,
)
from shockpc.landing.joint_model import JointModel, joint_model
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.joint_options import Joints, Rotor
from shockpc.landing.scenes.scene import Scene
from shockpc.robot.changes import Change
from shockpc.robot.gear import Gear
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError

LEAST_INERTIA = np.finfo(float).tiny
"""A reflected inertia that acts as none [kg m², kg]."""

T = TypeVar("T")


@dataclass(frozen=True)
class OfDrive(Kind):
    """A number of the drives of joints.

    Attributes:
        unit_of_revolute: of its values for revolute joints.
        unit_of_prismatic: of its values for prismatic joints.
    """

    of: Target = "JOINT"
    log_factors: bool = True
    nonnegative: bool = True
    uncertain: bool = True
    of_drives: bool = True
    unit_of_revolute: str = ""
    unit_of_prismatic: str = ""

    zero: ClassVar[bool] = False
    """True if a value may be zero."""

    example: ClassVar[str] = ""
    """Example of values, for messages."""

    def unit_of(self, robot: Robot, subject: str, target: str) -> str:
        units = {"rad": self.unit_of_revolute, "m": self.unit_of_prismatic}
        return common_unit(robot, subject, target, units)

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        fault = ""
        if smallest < 0.0:
            fault = "below"
        elif smallest == 0.0 and not self.zero:
            fault = "not above"
        if fault:
            raise StudyError(f"{varied.subject}: a {self.title} of {smallest:g} is {fault} zero")

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return robot.match_joints(varied.target)

    def multiplied(self, robot: Robot, varied: Variation, with_number: np.ndarray) -> np.ndarray:
        """Joint velocities (nv,) that factors multiply: those of the target with a number.

        Raises:
            StudyError: there are none.
        """
        chosen: np.ndarray = with_number & robot.velocities(robot.match_joints(varied.target))
        if not chosen.any():
            raise StudyError(
                f"{varied.subject}: these joints have no {self.title} to multiply; give values in "
                f"{self.unit_of_revolute} ({self.unit_of_prismatic} if prismatic), such as "
                f"{self.example}"
            )
        return chosen


@dataclass(frozen=True)
class Armature(OfDrive):
    """The reflected inertia of joints, before a spring or not [kg m²; kg of prismatic joints]."""

    factors: Factors = "also"
    of_rotors: bool = True
    option: str = "armature"
    changes_designs: bool = True

    zero: ClassVar[bool] = True
    example: ClassVar[str] = "0.01:0.1"

    def velocities(self, varied: Variation, scene: Scene, robot: Robot) -> np.ndarray:
        """The joint velocities (nv,) with the inertia that is set, or multiplied, as a mask.

        Raises:
            ShockError: none has, because the joints are locked, or no inertia is there to be
                multiplied.
        """
        if varied.factor:
            model = _given_drives(scene, robot)
            inertia = model.armature + model.rotor
            return self.multiplied(robot, varied, (inertia > 0.0) & ~model.locked)
        # Two values show which entries follow the value.
        low = joint_model(robot, _with_armature(scene, varied.target, 1.0)).armature
        high = joint_model(robot, _with_armature(scene, varied.target, 2.0)).armature
        return np.asarray(low != high)

    def check_landing(self, varied: Variation, scene: Scene, robot: Robot) -> None:
        """Refuse joints that are locked, and factors of no inertia."""
        self.velocities(varied, scene, robot)

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        return replace(scene, joints=self._joints_with(varied, scene, robot, float(value)))

    def _joints_with(self, varied: Variation, scene: Scene, robot: Robot, value: float) -> Joints:
        """The joint model with the inertias replaced or multiplied."""
        if value < 0.0:
            raise StudyError(f"{varied.subject}: a reflected inertia of {value:g} is below zero")
        if not varied.factor:
            return _with_armature(scene, varied.target, max(value, LEAST_INERTIA))
        joints = scene.joints
        model = _given_drives(scene, robot)
        chosen = self.velocities(varied, scene, robot)
        with_rotor = _matching(robot, joints.rotor)
        armature: dict[str, float] = {}
        rotor: dict[str, Rotor] = {}
        for name, v in _first_velocities(robot, chosen):
            reflected = value * float(model.armature[v] + model.rotor[v])
            inertia = max(reflected, LEAST_INERTIA)
            spring = float(model.drive_stiffness[v])
            # A rotor keeps its gear and its spring.
            if np.isfinite(spring) or name in with_rotor or model.per_turn[v]:
                rotor[name] = reflected_rotor(inertia, spring, float(model.per_turn[v]))
            else:
                armature[name] = inertia
        return replace(
            joints,
            armature=_set_last(joints.armature, armature),
            rotor=_set_last(joints.rotor, rotor),
        )

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return _of_unlocked(varied, landing, landing.joint_model.armature)

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        if varied.factor or not value > 0.0:
            return None
        return [(f"--{self.option}", f"{varied.target}={float(value)!r}")]

    def overridden(self, robot: Robot, target: str, scene: Scene) -> str:
        joints = scene.joints
        set_here = _matching(robot, (*joints.armature, *joints.rotor))
        for name in robot.match_joints(target):
            if name in set_here:
                return f'sets that of joint "{name}"'
        if joints.drives and joints.drives != "none":
            return f"takes the drives from {joints.drives}"
        return "makes all joints free" if joints.model == "free" else ""

    def set_inertia(self, varied: Variation, rows: RowInertias, x: Array) -> None:
        velocities = self.velocities(varied, rows.landing.scene, rows.landing.robot)
        rows.set_armature(velocities, x, varied.factor)

    def usual(self, landing: PosedLanding) -> Iterable[Variation]:
        """The reflected inertias of the joints that are not locked.

        A factor keeps the rotor, with its gear and its spring; another inertia would leave them
        out.
        """
        robot, model = landing.robot, landing.joint_model
        with_rotor = _matching(robot, landing.scene.joints.rotor)
        for name in robot.joint_names:
            joint = robot.joint(name)
            if name in robot.followers or model.locked[joint.v].all():
                continue
            factor = name in with_rotor or bool(model.per_turn[joint.v].any())
            unit = "-" if factor else self.unit_of(robot, name, name)
            yield Variation(self.subject(name), self, name, unit, factor=factor)

    def scale(self, varied: Variation, landing: PosedLanding, value: float) -> Scale:
        if varied.factor:
            return super().scale(varied, landing, value)
        v = landing.robot.joint(varied.target).v.start
        H = landing.state.H[0]
        # The inertia that the joint moves; with all others free it resists by less.
        moved = 1.0 / float(np.linalg.inv(H)[v, v])
        return Scale(moved, value or float(H[v, v]), value)


@dataclass(frozen=True)
class RotorInertia(OfDrive):
    """The inertia of rotors about their axes, before the gear [kg m²].

    The option for rotors gives their gear ratio and their spring too.
    """

    of_rotors: bool = True

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        rotors = scene.joints.rotor
        rotor = replace(rotors.get(varied.target, Rotor(inertia=1.0)), inertia=float(value))
        joints = replace(scene.joints, rotor=_set_last(rotors, {varied.target: rotor}))
        return replace(scene, joints=joints)


@dataclass(frozen=True)
class JointStiffness(OfDrive):
    """The stiffness of springs at joints or before rotors [N m/rad, N/m]."""

    factors: Factors = "also"
    lasting: bool = True
    option: str = "joint-stiffness"

    example: ClassVar[str] = "100:1000"

    def stage(self, factor: bool) -> int:
        """1 for factors, which leave it as it is which joints have a spring; 0 otherwise."""
        return 1 if factor else 0

    def check_landing(self, varied: Variation, scene: Scene, robot: Robot) -> None:
        """Refuse joints in which a spring has no effect, or is not there to be multiplied."""
        self.scene_with(varied, scene, robot, 1.0)

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        """The scene with springs replaced or multiplied; a joint without one gets one.

        Raises:
            ShockError: there is no spring to multiply, a joint has two, its rotor is not known, or
                the joints are locked.
        """
        joints = scene.joints
        model = _given_drives(scene, robot)
        at_joint = model.stiffness > 0.0
        at_rotor = np.isfinite(model.drive_stiffness)
        chosen = self._velocities(varied, robot, model)
        stiffness: dict[str, float] = {}
        rotor: dict[str, Rotor] = {}
        for name, v in _first_velocities(robot, chosen):
            # Factors multiply what is there.
            of_joint = float(model.stiffness[v]) if varied.factor else 1.0
            of_rotor = float(model.drive_stiffness[v]) if varied.factor else 1.0
            if at_joint[v] or not at_rotor[v]:
                stiffness[name] = float(value) * of_joint
            if at_rotor[v]:
                inertia, per_turn = float(model.rotor[v]), float(model.per_turn[v])
                rotor[name] = reflected_rotor(inertia, float(value) * of_rotor, per_turn)
        joints = replace(
            joints,
            stiffness=_set_last(joints.stiffness, stiffness),
            rotor=_set_last(joints.rotor, rotor),
        )
        return replace(scene, joints=joints)

    def _velocities(self, varied: Variation, robot: Robot, model: JointModel) -> np.ndarray:
        """The joint velocities (nv,) that have the springs, as a mask.

        Raises:
            StudyError: as for `scene_with`.
        """
        at_joint = model.stiffness > 0.0
        at_rotor = np.isfinite(model.drive_stiffness)
        matching: np.ndarray = robot.velocities(robot.match_joints(varied.target))
        chosen: np.ndarray = matching & robot.actuated_dofs & ~model.locked
        if varied.factor:
            chosen = self.multiplied(robot, varied, chosen & (at_joint | at_rotor))
        text = ""
        if not chosen.any():
            text = "these joints are locked, so a spring changes nothing there; vary others"
        elif (chosen & at_rotor & (model.rotor == 0.0)).any():
            text = (
                "the inertia of the rotor behind a spring is not known, so the spring has no "
                "effect; give it with --rotor"
            )
        elif (chosen & at_joint & at_rotor).any() and not varied.factor:
            text = (
                "a joint has two springs, at the joint and before its rotor; give factors, such "
                "as 0.5x:2x, which multiply both"
            )
        if text:
            raise StudyError(f"{varied.subject}: {text}")
        return chosen

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        stiffness = landing.joint_model.stiffness
        springs = np.where(stiffness > 0.0, stiffness, np.nan)
        return _of_unlocked(varied, landing, springs)

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        if varied.factor or scene.joints.rotor != base.joints.rotor:
            return None
        return [(f"--{self.option}", f"{varied.target}={float(value)!r}")]


@dataclass(frozen=True)
class JointPlace(Kind):
    """The places of joints in the frames of the links that carry them, and so lengths of links."""

    of: Target = "JOINT"
    factors: Factors = "only"
    nonnegative: bool = True
    uncertain: bool = True
    of_robot: bool = True
    changes_lengths: bool = True
    changes_designs: bool = True

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        robot.match_joints(varied.target)
        if not varied.factor:
            raise StudyError(
                f"{varied.subject}: places, and so lengths, are varied by factors; give them with "
                f"an x, such as 0.8x:1.2x:5"
            )

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return robot.match_joints(varied.target)

    def robot_changes(self, varied: Variation, robot: Robot, value: Any) -> list[Change]:
        """Joints that do not move keep their place, and the points on what they carry."""
        names = robot.match_joints(varied.target)
        return [Change(self.word, name, float(value), varied.factor) for name in names]


def reflected_rotor(inertia: float, k: float, per_turn: float) -> Rotor:
    """A rotor by its inertia at the joint.

    Args:
        inertia: of the rotor, reflected to the joint [kg m²].
        k: stiffness of the spring between them [N m/rad]; infinite without one.
        per_turn: as `JointModel.per_turn`.
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


def _given_drives(scene: Scene, robot: Robot) -> JointModel:
    """The drives as they are given, whether or not their springs yield."""
    joints = scene.joints
    if joints.model == "rigid":
        joints = replace(joints, model=None)
    return joint_model(robot, joints)


def _matching(robot: Robot, patterns: Iterable[str]) -> set[str]:
    """The joints that match any of some patterns."""
    names: set[str] = set()
    for pattern in patterns:
        names.update(robot.match_joints(pattern))
    return names


def _with_armature(scene: Scene, pattern: str, value: float) -> Joints:
    """The joint model with the reflected inertia of some joints replaced by one above zero."""
    armature = _set_last(scene.joints.armature, {pattern: value})
    return replace(scene.joints, armature=armature)


def _set_last(values: Mapping[str, T], set_to: Mapping[str, T]) -> dict[str, T]:
    """Values by pattern, with others after them, as later ones go over earlier ones."""
    return {name: value for name, value in values.items() if name not in set_to} | dict(set_to)


def _first_velocities(robot: Robot, chosen: np.ndarray) -> Iterator[tuple[str, int]]:
    """The joints of which some velocities (nv,) are, each with the first of its velocities."""
    for name in robot.joint_names:
        v = robot.joint(name).v.start
        if chosen[v]:
            yield name, v


def _of_unlocked(varied: Variation, landing: PosedLanding, values: np.ndarray) -> list[float]:
    """The values (nv,) of the joints that match and are not locked."""
    matching = landing.robot.velocities(landing.robot.match_joints(varied.target))
    of_joints: list[float] = values[matching & ~landing.joint_model.locked].tolist()
    return of_joints


ARMATURE = Armature(
    "armature", title="reflected inertia", unit_of_revolute="kg m²", unit_of_prismatic="kg"
)
ROTOR = RotorInertia(
    "rotor", title="rotor inertia", unit_of_revolute="kg m²", unit_of_prismatic="kg m²"
)
JOINT_STIFFNESS = JointStiffness(
    "joint-stiffness", title="stiffness", unit_of_revolute="N m/rad", unit_of_prismatic="N/m"
)
PLACE = JointPlace("place")
