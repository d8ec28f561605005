"""How wrong a result is: the error of every body against the reference, with the subtraction done in long numbers."""

import mpmath
import numpy as np
from mpmath import mp

from shockpc.bench.exact import DIGITS, Exact, cross, widen
from shockpc.bench.reference import Reference
from shockpc.core.spatial import Array
from shockpc.health import UNMOVED, gyration_radii
from shockpc.model.robot import Robot

__all__ = ["body_errors"]


def body_errors(robot: Robot, truth: Reference, jumps: Array) -> Array:
    """Error (nb,) of every body's jump relative to its own motion: |Δ − Δ*| / |Δ*| with |Δ|² = |v_com|² + (r_g |ω|)².

    The size of a body's motion is that of its centre of mass and of its turning at the radius of gyration. A body that the product
    does not tell from one that stands still (slower than `UNMOVED` of the fastest one) is measured against the fastest one. What is
    not finite is infinitely wrong.

    Args:
        robot: the robot.
        truth: the reference.
        jumps: (nb, 6) body coordinates at the body frames' origins.
    """
    radius = gyration_radii(robot)
    # A body without inertia of its own is measured by the smallest length that the others have, as the product does.
    radius = np.where(radius > 0.0, radius, radius[radius > 0.0].min(initial=1.0))
    with mp.workdps(DIGITS):
        own = [_size(twist[:3], twist[3:], r) for twist, r in zip(truth.twists, radius, strict=True)]
        fastest = max(own)
        errors = np.full(len(radius), np.inf)
        for i, body in enumerate(robot.bodies):
            if not np.all(np.isfinite(jumps[i])):
                continue
            off = widen(jumps[i]) - truth.jumps[i]
            v_com = off[3:] + cross(off[:3], widen(body.com))
            size = own[i] if own[i] > UNMOVED * fastest else fastest
            error = _size(off[:3], v_com, radius[i])
            errors[i] = float(error / size) if size > 0 else float(error)
    return errors


def _size(omega: Exact, v: Exact, radius: float) -> mpmath.mpf:
    """One number for a motion [m/s]."""
    return mp.sqrt(v @ v + mpmath.mpf(radius) ** 2 * (omega @ omega))
