"""Shock, and its most and least severe impact directions, at sensors, at points that were asked for and at centres of mass."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.directions import ExtremeDirections, extreme_directions
from shockpc.core.percussion import norm
from shockpc.core.pulse import peak_acceleration
from shockpc.core.spatial import Array, jump_at, velocity_at
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import balls, nearest
from shockpc.exact.solution import ExactImpact
from shockpc.landing import pulse_of
from shockpc.results.solved import Solved, shock_in, world
from shockpc.robot.landmarks import sensors
from shockpc.robot.record import Frame, Robot
from shockpc.scene import GRAVITY, Point, Scene

__all__ = ["PointShock", "Spot", "com_directions", "point_shocks", "saturated", "spot_of", "spots"]


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


def point_shocks(of: Solved) -> tuple[PointShock, ...]:
    """Shock at sensors and points."""
    return tuple(_point_shock(of, spot) for spot in spots(of.robot, of.landing.scene.point))


def _point_shock(of: Solved, spot: Spot) -> PointShock:
    """Shock at one point."""
    landing, pulse, (label, frame, r) = of.landing, pulse_of(of.landing.scene), spot
    if frame.body < 0:
        still = extreme_directions(np.zeros((3, 3)), landing.up)
        return PointShock(label, "world", r, np.zeros(3), 0.0, still, None)
    bodies, size = [frame.body], np.abs(of.proof.jumps[..., 3]).max()

    def read(impact: ExactImpact) -> tuple[Array, ...]:
        jump = impact.body_jumps[frame.body, :, 3]
        delta_v = velocity_at(jump[:3], jump[3:], balls(r))
        turned = nearest(balls(frame.rotation.T) @ delta_v, size)
        return (
            world(impact, landing, bodies, r[None])[0],
            turned,
            shock_in(impact, landing, bodies, r[None]),
            nearest(norm(delta_v), size),
        )

    position, delta_v, shock, speed = of.read(read)
    directions = ExtremeDirections(*(part[0] for part in _directions_of(of, bodies, r[None])))
    peak_g = None if pulse is None else peak_acceleration(speed.item(), pulse) / GRAVITY
    return PointShock(label, of.robot.bodies[frame.body].name, position, delta_v, shock.item(), directions, peak_g)


def com_directions(of: Solved) -> ExtremeDirections:
    """Most and least severe impact directions of the bodies' centres of mass."""
    return _directions_of(of, range(len(of.robot.bodies)), of.robot.coms)


def _directions_of(of: Solved, bodies: Sequence[int], r: Array) -> ExtremeDirections:
    """The extreme directions of points of bodies, right to 1e-15 of the largest shock. Args: r (n, 3) in the bodies' frames [m]."""

    def maps(impact: ExactImpact) -> Array:
        found = jump_at(impact.body_jumps[bodies][..., :3], balls(r))
        return nearest(found, np.abs(found.astype(float)).max(axis=(1, 2), keepdims=True) + 1e-300)

    return extreme_directions(of.read(maps), of.landing.up)


def saturated(scene: Scene, points: tuple[PointShock, ...]) -> Iterator[Diagnostic]:
    """A warning for every sensor whose peak exceeds its range, and for a pulse without a sensor or point."""
    if scene.pulse is not None and not points:
        text = "a pulse is given, but the robot has no sensor and no point is asked for, so there is no peak; name one with --point"
        yield Diagnostic("sensor", "", None, text)
    for point in points:
        if point.peak_g is not None and point.peak_g > (scene.range_g or np.inf):
            text = f'"{point.frame}" would see {point.peak_g:.3g} g, beyond its range of {scene.range_g:g} g; its reading saturates'
            yield Diagnostic("sensor", point.frame, point.peak_g, text)
