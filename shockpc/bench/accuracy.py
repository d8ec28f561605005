"""How wrong a result is: the error of every body against the reference, with the subtraction done in long numbers."""

from typing import NamedTuple

import mpmath
import numpy as np
from mpmath import mp

from shockpc.bench.exact import DIGITS, Exact, cross, widen
from shockpc.bench.reference import Reference
from shockpc.core.spatial import Array, velocity_at
from shockpc.health import UNMOVED
from shockpc.model.bodies import gyration_radii, turning_lengths
from shockpc.robot.robot import Robot

__all__ = ["Errors", "apart", "body_errors"]


class Errors(NamedTuple):
    """How wrong a result is at every body.

    Attributes:
        own: (nb,) relative to the body's own motion [1].
        whole: (nb,) relative to the fastest body's [1]: what a plot of all bodies would show.
    """

    own: Array
    whole: Array


def body_errors(robot: Robot, truth: Reference, jumps: Array) -> Errors:
    """Errors of every body's jump: |Δ − Δ*| with |Δ|² = |v_com|² + (r_g |ω|)², relative.

    The size of a body's motion is that of its centre of mass and of its turning at the radius of gyration. A body that the product
    does not tell from one that stands still (slower than `UNMOVED` of the fastest one) is measured against the fastest one in both
    ways. What is not finite is infinitely wrong.

    Args:
        robot: the robot.
        truth: the reference.
        jumps: (nb, 6) body coordinates at the body frames' origins.
    """
    radius = turning_lengths(robot)
    own, whole = np.full(len(radius), np.inf), np.full(len(radius), np.inf)
    with mp.workdps(DIGITS):
        speeds = [_size(twist[:3], twist[3:], r) for twist, r in zip(truth.twists, radius, strict=True)]
        fastest = max(speeds) or mp.one
        for i, body in enumerate(robot.bodies):
            if not np.all(np.isfinite(jumps[i])):
                continue
            off = widen(jumps[i]) - truth.jumps[i]
            error = _size(off[:3], off[3:] + cross(off[:3], widen(body.com)), radius[i])
            whole[i] = float(error / fastest)
            own[i] = float(error / speeds[i]) if speeds[i] > UNMOVED * fastest else whole[i]
    return Errors(own, whole)


def apart(robot: Robot, found: Array, expected: Array) -> Array:
    """Difference (nb,) of two results relative to the fastest body's motion, in doubles: for more than rounding.

    Args:
        robot: the robot.
        found: (nb, 6) jumps in body coordinates.
        expected: (nb, 6) the same.
    """
    radius = gyration_radii(robot)[:, None]
    com = np.stack([body.com for body in robot.bodies])

    def speed(jumps: Array) -> Array:
        return np.asarray(np.linalg.norm(np.hstack([radius * jumps[:, :3], velocity_at(jumps[:, :3], jumps[:, 3:], com)]), axis=1))

    return np.asarray(speed(found - expected) / speed(expected).max())


def _size(omega: Exact, v: Exact, radius: float) -> mpmath.mpf:
    """One number for a motion [m/s]."""
    return mp.sqrt(v @ v + mpmath.mpf(radius) ** 2 * (omega @ omega))
