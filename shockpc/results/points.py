"""Shock at sensors and at points that were asked for."""

from typing import NamedTuple

import numpy as np

from shockpc.core.directions import ExtremeDirections, extreme_directions
from shockpc.core.percussion import norm
from shockpc.core.pulse import Pulse, peak_acceleration
from shockpc.core.spatial import Array, velocity_at
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import balls, nearest
from shockpc.exact.proof import Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.results.directions import directions_at
from shockpc.results.placement import world
from shockpc.results.speed import speed_in
from shockpc.robot.landmarks import sensors
from shockpc.robot.robot import Frame, Robot
from shockpc.scene import GRAVITY, Point, Scene

__all__ = ["PointShock", "Spot", "point_shocks", "saturated", "spot_of", "spots"]


class PointShock(NamedTuple):
    """Shock at a sensor, or at a point that was asked for.

    Attributes:
        frame: its name.
        body: the body it is fixed to.
        position: (3,) world [m].
        delta_v: (3,) jump of its velocity, in the frame's own axes [m/s].
        shock: |Δv| / v_in [1].
        directions: the most and the least severe impact direction.
        peak_g: peak acceleration for the scene's pulse, in multiples of gravity; None without a pulse.
    """

    frame: str
    body: str
    position: Array
    delta_v: Array
    shock: float
    directions: ExtremeDirections
    peak_g: float | None


class Spot(NamedTuple):
    """A named point on a robot.

    Attributes:
        label: as it is typed, FRAME or FRAME:x,y,z.
        frame: on which it lies.
        r: (3,) in the body's frame [m].
    """

    label: str
    frame: Frame
    r: Array


def spots(robot: Robot, asked: tuple[Point, ...]) -> tuple[Spot, ...]:
    """The robot's sensors, then the points asked for; each once.

    Raises:
        UnknownName: the robot has no frame of that name.
    """
    found = {name: Spot(name, robot.frames[name], robot.frames[name].offset) for name in sensors(robot)}
    found |= {spot.label: spot for spot in (spot_of(robot, point) for point in asked)}
    return tuple(found.values())


def spot_of(robot: Robot, point: Point) -> Spot:
    """The point that a scene or a study names.

    Raises:
        UnknownName: the robot has no frame of that name.
    """
    frame, offset = robot.frame(point.frame), np.asarray(point.offset, dtype=float)
    return Spot(point.label, frame, frame.offset + frame.rotation @ offset)


def point_shocks(landing: Landing, proof: Proof, v_in: float, pulse: Pulse | None) -> tuple[PointShock, ...]:
    """Shock at every sensor and point of a landing.

    Args:
        landing: the landing.
        proof: of its solution.
        v_in: speed by which shock is normalised [m/s].
        pulse: for peak accelerations.
    """
    found = spots(landing.robot, landing.scene.point)
    moving = [spot for spot in found if spot.frame.body >= 0]
    bodies = [spot.frame.body for spot in moving]
    r = np.array([spot.r for spot in moving]).reshape(-1, 3)
    axes = np.array([spot.frame.rotation for spot in moving]).reshape(-1, 3, 3)
    size = np.linalg.norm(proof.jumps[bodies, :, 3], axis=-1)

    def shocks(impact: ExactImpact) -> tuple[Array, Array, Array, Array]:
        jumps = impact.body_jumps[bodies][..., 3]
        delta_v = velocity_at(jumps[:, :3], jumps[:, 3:], balls(r))
        turned, speed = np.sum(balls(axes) * delta_v[:, :, None], axis=1), norm(delta_v)
        return (
            nearest(turned, size[:, None]),
            nearest(speed / speed_in(impact, landing), size / v_in),
            nearest(speed, size),
            world(impact, landing, bodies, r),
        )

    none = np.zeros((0, 3)), np.zeros(0), np.zeros(0), np.zeros((0, 3))
    delta_v, shock, speed, position = proof.enclosure.read(shocks) if moving else none
    directions = directions_at(proof.enclosure, bodies, r, landing.up) if moving else None
    results: list[PointShock] = []
    k = 0
    for label, frame, place in found:
        i = frame.body
        if i < 0 or directions is None:
            still = extreme_directions(np.zeros((3, 3)), landing.up)
            results.append(PointShock(label, "world", place, np.zeros(3), 0.0, still, None))
            continue
        results.append(
            PointShock(
                frame=label,
                body=landing.robot.bodies[i].name,
                position=position[k],
                delta_v=delta_v[k],
                shock=float(shock[k]),
                directions=ExtremeDirections(*(part[k] for part in directions)),
                peak_g=None if pulse is None else peak_acceleration(float(speed[k]), pulse) / GRAVITY,
            )
        )
        k += 1
    return tuple(results)


def saturated(scene: Scene, points: tuple[PointShock, ...]) -> tuple[Diagnostic, ...]:
    """A warning for every sensor whose peak exceeds its range, and for a pulse without a sensor or point."""
    if scene.pulse is not None and not points:
        text = "a pulse is given, but the robot has no sensor and no point is asked for, so there is no peak; name one with --point"
        return (Diagnostic("sensor", "", None, text),)
    over = [point for point in points if point.peak_g is not None and point.peak_g > (scene.range_g or np.inf)]
    return tuple(
        Diagnostic(
            "sensor",
            point.frame,
            point.peak_g,
            f'"{point.frame}" would see {point.peak_g:.3g} g, beyond its range of {scene.range_g:g} g; its reading saturates',
        )
        for point in over
    )
