"""How wrong a result is: the error of every body against the reference, with the subtraction done in long numbers."""

import mpmath
import numpy as np
from mpmath import mp

from shockpc.bench.exact import DIGITS, Exact, cross, widen
from shockpc.bench.reference import Reference
from shockpc.core.spatial import Array
from shockpc.health import gyration_radii
from shockpc.model.robot import Robot

__all__ = ["STILL", "body_errors"]

STILL = 1e-9
"""A body slower than this share of the fastest one is measured against that: below it there is nothing to be wrong about."""


def body_errors(robot: Robot, truth: Reference, jumps: Array) -> Array:
    """Relative error (nb,) of every body's jump: |Δ − Δ*| / |Δ*| with |Δ|² = |v_com|² + (r_g |ω|)².

    The size of a body's motion is that of its centre of mass and of its turning at the radius of gyration, and at least `STILL`
    of the fastest body's. What is not finite is infinitely wrong.

    Args:
        robot: the robot.
        truth: the reference.
        jumps: (nb, 6) body coordinates at the body frames' origins.
    """
    radius = np.maximum(gyration_radii(robot), 1e-6)
    with mp.workdps(DIGITS):
        own = [_size(twist[:3], twist[3:], r) for twist, r in zip(truth.twists, radius, strict=True)]
        floor = mpmath.mpf(STILL) * max(own)
        errors = np.full(len(radius), np.inf)
        for i, body in enumerate(robot.bodies):
            if not np.all(np.isfinite(jumps[i])):
                continue
            off = widen(jumps[i]) - truth.jumps[i]
            v_com = off[3:] + cross(off[:3], widen(body.com))
            size = max(own[i], floor)
            error = _size(off[:3], v_com, radius[i])
            errors[i] = float(error / size) if size > 0 else float(error)
    return errors


def _size(omega: Exact, v: Exact, radius: float) -> mpmath.mpf:
    """One number for a motion [m/s]."""
    return mp.sqrt(v @ v + mpmath.mpf(radius) ** 2 * (omega @ omega))
