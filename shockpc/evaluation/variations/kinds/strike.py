"""Kinds of the strike: the speed before the impact and its angle."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shockpc.evaluation.variations.variation import Kind, Options, Variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import plane_of, with_plane
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


@dataclass(frozen=True)
class OfStrike(Kind):
    """A number of the strike: a change of it needs only another product with the maps."""

    def stage(self, factor: bool) -> int:
        return 2

    def check_landing(self, varied: Variation, scene: Scene, robot: Robot) -> None:
        """Refuse values with which a strike has no velocity."""
        plane = plane_of(scene)
        for value in varied.values or varied.span or ():
            struck, _ = varied.applied(scene, robot, value)
            struck.strike.vector(plane)

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.word}", repr(float(value)))]


@dataclass(frozen=True)
class Speed(OfStrike):
    """The speed before the impact [m/s]."""

    def refuse_scene(self, scene: Scene) -> None:
        if scene.strike.velocity is not None or scene.strike.drop_height is not None:
            raise StudyError(
                "speed is varied, but the velocity is given as a vector or a drop height; leave "
                "that out"
            )

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        return replace(scene, strike=replace(scene.strike, speed=float(value)))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return [float(np.linalg.norm(landing.before.velocity))]


@dataclass(frozen=True)
class StrikeAngle(OfStrike):
    """The angle of the velocity from the vertical, in the plane of the strike [deg]."""

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        # The strike turns in the plane of the scene as it is given.
        scene = with_plane(scene)
        return replace(scene, strike=scene.strike.turned(float(value), plane_of(scene)))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return [math.degrees(landing.strike_angle)]


SPEED = Speed("speed", "m/s")
STRIKE_ANGLE = StrikeAngle("strike-angle", "deg")
