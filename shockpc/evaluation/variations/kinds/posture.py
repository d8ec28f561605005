"""Kinds of the posture: positions of joints, motions of ball joints and the like, attitude."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.evaluation.variations.row_arrays import RowPostures
from shockpc.evaluation.variations.variation import Kind, Options, Target, Variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import (
    COMPONENTS,
    component,
    configuration,
    displaced,
    refuse_beyond_turn,
    settable_joints,
)
from shockpc.landing.scenes.scene import Scene
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed

ROUNDED = 1e-2
"""By how much a value may miss limits, which files state in rounded decimals [deg, m]."""


def common_unit(robot: Robot, subject: str, pattern: str, units: dict[str, str]) -> str:
    """The common unit of the joints that a pattern means.

    Args: units, by that of the joint, "rad" or "m".

    Raises:
        StudyError: their units differ.
    """
    common = {units[robot.joint(name).unit] for name in robot.match_joints(pattern)}
    if len(common) > 1:
        raise StudyError(
            f"{subject} means revolute and prismatic joints, which have different units; vary them "
            f"separately"
        )
    return common.pop()


@dataclass(frozen=True)
class JointPosition(Kind):
    """The position of joints of one degree of freedom [deg, m]; all that match have the same."""

    of: Target = "JOINT"
    option: str = "set"

    def subject(self, target: str) -> str:
        """The name alone, which stands for the joint's position."""
        return target

    def in_words(self, target: str, unit: str) -> str:
        words = {"deg": "angle of ", "m": "position of "}.get(unit, "")
        return words + "all " * ("*" in target) + target

    def settable(self, robot: Robot, target: str) -> tuple[Joint, ...]:
        """The joints that are set; a joint that follows another one is not among them."""
        return _settable(robot, target)

    def unit_of(self, robot: Robot, subject: str, target: str) -> str:
        return common_unit(robot, subject, target, {"rad": "deg", "m": "m"})

    def read(self, robot: Robot, subject: str, target: str, values: Any) -> Variation:
        """The joints with their values; without values, which are then the limits of each joint."""
        if values is not None:
            return super().read(robot, subject, target, values)
        varied = Variation(subject, self, target, self.unit_of(robot, subject, target))
        self.check(robot, varied, 0.0)
        return varied

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        """Refuse joints that a number cannot set, and angles beyond the limits and a whole turn."""
        joints = self.settable(robot, varied.target)
        if varied.unit != "deg":
            return
        for joint in joints:
            for value in varied.span or varied.values:
                if isinstance(value, float):
                    refuse_beyond_turn(joint, math.radians(value), varied.subject, StudyError)

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return [joint.name for joint in self.settable(robot, varied.target)]

    def each(self, robot: Robot, varied: Variation) -> tuple[Variation, ...]:
        single = super().each(robot, varied)
        for of_joint in single:
            self.check(robot, of_joint, 0.0)
        return single

    def sets(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return self.names(robot, varied)

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        # The last pattern of a posture counts.
        positions = {
            name: x for name, x in scene.posture.joints_deg.items() if name != varied.target
        }
        positions[varied.target] = float(value)
        return replace(scene, posture=replace(scene.posture, joints_deg=positions))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        joints = self.settable(landing.robot, varied.target)
        return [varied.per_unit * joint.value(landing.q) for joint in joints]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.option}", f"{varied.target}={float(value)!r}")]

    def set_posture(self, varied: Variation, rows: RowPostures, x: Array) -> None:
        for joint in self.settable(rows.landing.robot, varied.target):
            rows.set_position(joint, x)

    def usual(self, landing: PosedLanding) -> Iterable[Variation]:
        robot = landing.robot
        for name in robot.joint_names:
            if name not in robot.followers and robot.joint(name).axis is not None:
                yield Variation(name, self, name, self.unit_of(robot, name, name))


@memoized()
def _settable(robot: Robot, pattern: str) -> tuple[Joint, ...]:
    return settable_joints(robot, pattern, StudyError)


@dataclass(frozen=True)
class JointMotion(Kind):
    """A motion of joints with several degrees of freedom, from where they are in the landing.

    It is along or about an axis of what the joint moves [m, deg], as `COMPONENTS` lists them.
    """

    of: Target = "JOINT"
    added: bool = True

    def joints(self, robot: Robot, subject: str, pattern: str) -> list[tuple[Joint, int]]:
        """The joints that can move so, each with the index of this velocity.

        Raises:
            UnknownName: no joint fits.
            StudyError: none of them can move so.
        """
        joints = [robot.joint(name) for name in robot.match_joints(pattern)]
        moving = [(joint, component(joint, self.word)) for joint in joints]
        moving = [(joint, v) for joint, v in moving if v >= 0]
        if moving:
            return moving
        valid = []
        for joint in joints:
            valid += [f"{word}:{joint.name}" for word in COMPONENTS.get(joint.kind, ())]
        remedy = f"valid are {listed(valid, 6)}" if valid else "name a joint by itself"
        raise StudyError(f"{subject}: no joint moves so; {remedy}")

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        self.joints(robot, varied.subject, varied.target)

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return [joint.name for joint, _ in self.joints(robot, varied.subject, varied.target)]

    def velocities(self, robot: Robot, varied: Variation) -> list[int]:
        """The indices of the joint velocities of the motion."""
        return [v for _, v in self.joints(robot, varied.subject, varied.target)]

    def set_posture(self, varied: Variation, rows: RowPostures, x: Array) -> None:
        rows.move(self.velocities(rows.landing.robot, varied), x)

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        x = math.radians(float(value)) if varied.unit == "deg" else float(value)
        step = np.zeros(robot.model.nv)
        step[self.velocities(robot, varied)] = x
        (q,) = displaced(robot, configuration(robot, scene.posture)[None], step[None])
        coordinates = {**scene.posture.joint_quaternions, **self._coordinates(varied, robot, q)}
        return replace(scene, posture=replace(scene.posture, joint_quaternions=coordinates))

    def from_closed(self, varied: Variation, scene: Scene, robot: Robot, q: Array) -> Scene:
        """The scene with the coordinates of a configuration q, unless it gives its own."""
        coordinates = {**self._coordinates(varied, robot, q), **scene.posture.joint_quaternions}
        return replace(scene, posture=replace(scene.posture, joint_quaternions=coordinates))

    def _coordinates(
        self, varied: Variation, robot: Robot, q: Array
    ) -> dict[str, tuple[float, ...]]:
        """The coordinates of the joints in a configuration q (nq,), by name."""
        joints = self.joints(robot, varied.subject, varied.target)
        return {joint.name: joint.coordinates(q) for joint, _ in joints}

    def usual(self, landing: PosedLanding) -> Iterable[Variation]:
        robot = landing.robot
        for name in robot.joint_names:
            if name not in robot.followers and self.word in COMPONENTS.get(
                robot.joint(name).kind, ()
            ):
                yield Variation(self.subject(name), self, name, self.unit)


@dataclass(frozen=True)
class Attitude(Kind):
    """An angle of the base: roll, pitch or yaw [deg]."""

    unit: str = "deg"
    option: str = "base-rpy"

    def check_robot(self, robot: Robot, subject: str) -> None:
        if not robot.free_base:
            raise StudyError(
                f'{subject}: the base of robot "{robot.name}" is fixed in its file, so it cannot '
                f"be turned"
            )

    def refuse_scene(self, scene: Scene) -> None:
        if scene.posture.base_quaternion is not None:
            raise StudyError(
                "the base's attitude is varied, but the scene gives it as a quaternion; give "
                "base_rpy_deg instead"
            )

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        angles = list(scene.posture.base_rpy_deg or (0.0, 0.0, 0.0))
        angles[self.axis] = float(value)
        roll, pitch, yaw = angles
        return replace(scene, posture=replace(scene.posture, base_rpy_deg=(roll, pitch, yaw)))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        angles = landing.scene.posture.base_rpy_deg
        if angles is not None:
            return [angles[self.axis]]
        # The scene does not state the angles; they are known only if the base is not rotated.
        level = abs(landing.q[6]) == 1.0
        return [0.0 if level else None]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.option}", ",".join(map(repr, scene.posture.base_rpy_deg or ())))]

    def set_posture(self, varied: Variation, rows: RowPostures, x: Array) -> None:
        rows.rpy[:, self.axis] = x


JOINT_POSITION = JointPosition("joint")

ATTITUDES = (
    Attitude("base-roll", axis=0),
    Attitude("base-pitch", axis=1),
    Attitude("base-yaw", axis=2),
)

SHIFTS = tuple(JointMotion(word, "m") for word in ("shift-x", "shift-y", "shift-z"))
TURNS = tuple(JointMotion(word, "deg") for word in ("turn-x", "turn-y", "turn-z"))
JOINT_MOTIONS = (*SHIFTS, *TURNS)


def motion_range(joints: Iterable[Joint]) -> tuple[float, float]:
    """The range of a position that joints have in common, where none is given [rad, m].

    They are the limits in the robot's file. Of joints that turn by a whole turn or more it is one
    turn about zero, −180° to 180°, which holds every posture of theirs: files write "no limit" in
    many ways. Infinite where joints slide without limits; empty where the joints have no value in
    common.
    """
    low, high = -math.inf, math.inf
    turns = False
    for joint in joints:
        turns = turns or joint.unit == "rad"
        if joint.kind != "continuous":
            low = max(low, joint.limits[0])
            high = min(high, joint.limits[1])
    if turns and high - low >= 2.0 * math.pi:
        return -math.pi, math.pi
    return low, high


def beyond_limits(robot: Robot, varied: Variation) -> str:
    """A warning if positions of a joint are beyond the limits of the robot's file; else empty."""
    joints = varied.kind.settable(robot, varied.target)
    values = [value for value in varied.span or varied.values if isinstance(value, float)]
    if not joints or not values:
        return ""
    low = varied.per_unit * max(joint.limits[0] for joint in joints)
    high = varied.per_unit * min(joint.limits[1] for joint in joints)
    below = min(values) < low - ROUNDED
    above = max(values) > high + ROUNDED
    if not below and not above:
        return ""
    return (
        f"{varied.subject} from {min(values):g} to {max(values):g} {varied.unit} leaves the "
        f"limits of the robot file, {low:.6g} to {high:.6g} {varied.unit}; these landings are "
        "computed too"
    )
