"""Kinds of the strike: the speed before the impact and its angle."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.row_arrays import RowStrikes
from shockpc.evaluation.variations.variation import Kind, Options, Variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import plane_of, with_plane
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError


@dataclass(frozen=True)
class OfStrike(Kind):
    """A number of the strike: a change of it needs only another product with the maps."""

    def check_landing(self, varied: Variation, scene: Scene, robot: Robot) -> None:
        """Refuse values with which a strike has no velocity."""
        plane = plane_of(scene)
        for value in varied.values or varied.span or ():
            struck, _ = varied.applied(scene, robot, value)
            struck.strike.vector(plane)

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.option}", repr(float(value)))]


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

    def set_strike(self, rows: RowStrikes, x: Array) -> None:
        rows.speed = x


@dataclass(frozen=True)
class StrikeAngle(OfStrike):
    """The angle of the velocity from the vertical, in the plane of the strike [deg]."""

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        # The strike turns in the plane of the scene as it is given.
        scene = with_plane(scene)
        return replace(scene, strike=scene.strike.turned(float(value), plane_of(scene)))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return [None if landing.plane.level else math.degrees(landing.strike_angle)]

    def set_strike(self, rows: RowStrikes, x: Array) -> None:
        rows.angle = x

    def has_derivatives(self, scene: Scene) -> bool:
        """True if the speed is the same at all angles, which it is not after a drop."""
        return scene.strike.drop_height is None

    def usual(self, landing: PosedLanding) -> Iterable[Variation]:
        return () if landing.plane.level else [Variation(self.word, self, "", self.unit)]


SPEED = Speed("speed", "m/s", scales=True, option="speed")
STRIKE_ANGLE = StrikeAngle("strike-angle", "deg", option="strike-angle")

STRIKE_KINDS = (
    SPEED,
    STRIKE_ANGLE,
)
