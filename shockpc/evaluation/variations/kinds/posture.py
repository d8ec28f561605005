"""Kinds of the posture: positions of joints, motions of ball joints and the like, attitude."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
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
    moves: bool = True

    def joints(self, robot: Robot, varied: Variation) -> tuple[Joint, ...]:
        """The joints that are set; a joint that follows another one is not among them."""
        return _settable(robot, varied.target)

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
        joints = self.joints(robot, varied)
        if varied.unit != "deg":
            return
        for joint in joints:
            for value in varied.span or varied.values:
                if isinstance(value, float):
                    refuse_beyond_turn(joint, math.radians(value), varied.subject, StudyError)

    def each(self, robot: Robot, varied: Variation) -> tuple[Variation, ...]:
        single = [
            replace(varied, subject=joint.name, target=joint.name)
            for joint in self.joints(robot, varied)
        ]
        for of_joint in single:
            self.check(robot, of_joint, 0.0)
        return tuple(single)

    def sets(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return [joint.name for joint in self.joints(robot, varied)]

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        # The last pattern of a posture counts.
        positions = {
            name: x for name, x in scene.posture.joints_deg.items() if name != varied.target
        }
        positions[varied.target] = float(value)
        return replace(scene, posture=replace(scene.posture, joints_deg=positions))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        scale = math.degrees(1.0) if varied.unit == "deg" else 1.0
        return [scale * joint.value(landing.q) for joint in self.joints(landing.robot, varied)]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [("--set", f"{varied.target}={float(value)!r}")]


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
    moves: bool = True

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
        known = []
        for joint in joints:
            known += [f"{word}:{joint.name}" for word in COMPONENTS.get(joint.kind, ())]
        remedy = f"valid are {listed(known, 6)}" if known else "name a joint by itself"
        raise StudyError(f"{subject}: no joint moves so; {remedy}")

    def check(self, robot: Robot, varied: Variation, smallest: float) -> None:
        self.joints(robot, varied.subject, varied.target)

    def names(self, robot: Robot, varied: Variation) -> Iterable[str]:
        return [joint.name for joint, _ in self.joints(robot, varied.subject, varied.target)]

    def moved(self, robot: Robot, varied: Variation, Q: Array, x: Array) -> Array:
        """Configurations (n, nq) after the motion.

        Args: Q (n, nq), before; x (n,), how far [rad, m].
        """
        steps = np.zeros((len(Q), robot.model.nv))
        chosen = [v for _, v in self.joints(robot, varied.subject, varied.target)]
        steps[:, chosen] = x[:, None]
        return displaced(robot, Q, steps)

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        x = math.radians(float(value)) if varied.unit == "deg" else float(value)
        q = configuration(robot, scene.posture)
        (q,) = self.moved(robot, varied, q[None], np.array([x]))
        return self.with_coordinates_of(varied, scene, robot, q, replaces=True)

    def with_coordinates_of(
        self, varied: Variation, scene: Scene, robot: Robot, q: Array, *, replaces: bool
    ) -> Scene:
        """The scene with the coordinates that these joints have in a configuration q (nq,).

        Args: replaces, whether they replace coordinates that the scene gives.
        """
        joints = self.joints(robot, varied.subject, varied.target)
        coordinates = {joint.name: joint.coordinates(q) for joint, _ in joints}
        stated = scene.posture.joint_quaternions
        merged = {**stated, **coordinates} if replaces else {**coordinates, **stated}
        return replace(scene, posture=replace(scene.posture, joint_quaternions=merged))


@dataclass(frozen=True)
class Attitude(Kind):
    """An angle of the base: roll, pitch or yaw [deg].

    Attributes:
        axis: 0, 1 or 2 of these.
    """

    unit: str = "deg"
    moves: bool = True
    axis: int = 0

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
        return [("--base-rpy", ",".join(map(repr, scene.posture.base_rpy_deg or ())))]


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
    if not isinstance(varied.kind, JointPosition):
        return ""
    scale = math.degrees(1.0) if varied.unit == "deg" else 1.0
    joints = varied.kind.joints(robot, varied)
    low = scale * max(joint.limits[0] for joint in joints)
    high = scale * min(joint.limits[1] for joint in joints)
    values = [value for value in varied.span or varied.values if isinstance(value, float)]
    if not values:
        return ""
    below = min(values) < low - ROUNDED
    above = max(values) > high + ROUNDED
    if not below and not above:
        return ""
    return (
        f"{varied.subject} from {min(values):g} to {max(values):g} {varied.unit} leaves the "
        f"limits of the robot file, {low:.6g} to {high:.6g} {varied.unit}; these landings are "
        "computed too"
    )
