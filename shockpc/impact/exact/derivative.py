"""Derivatives of an impact in ball arithmetic: difference quotients whose step is so small that only the derivative is left.

With a step h the quotient (f(h) − f(0)) / h is off by h/2 of the second derivative. With h = 2^-100 that is 4e-31, and the digits
that the difference loses are covered by the working precision, which is raised until the quotient is known to the last digit of a
double. What is computed in double precision has central differences instead, with a stated error.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.exact.balls import Balls, balls, entries, rotation_matrix, to_double
from shockpc.impact.exact.proof import Proof
from shockpc.impact.exact.solution import BallImpact
from shockpc.robot.robot import Robot

STEP = 2.0**-100
BITS = 256

Path: TypeAlias = Callable[[BallImpact, float], BallImpact]
"""From an impact, and by how much a parameter changes, to the impact with that change."""


def derivatives(proof: Proof, paths: Sequence[Path], number: Callable[[BallImpact], Any], size: float) -> Array:
    """The derivatives (p,) of a number of an impact by p parameters, the doubles nearest to the exact ones.

    Args:
        proof: of the impact.
        paths: how each parameter changes it.
        number: in ball arithmetic.
        size: its natural size.

    Raises:
        SingularError: an impact beside the given one has no solution.
    """

    def quotients(impact: BallImpact) -> Array:
        here = number(impact)
        return to_double(np.array([(number(path(impact, STEP)) - here) / STEP for path in paths], dtype=object), size)

    return proof.read(quotients, BITS)


def central_difference(function: Callable[[float], float], here: float, step: float) -> tuple[float, float]:
    """The derivative of a function at zero by central differences, and their error.

    Of two steps h and h/2 the differences D(h) and D(h/2) give (4 D(h/2) − D(h)) / 3, off by h⁴ (Richardson). The error is stated
    as |D(h) − D(h/2)|, or as the part of the second differences that does not vanish with h, which is that of a kink, if that is
    larger.

    Args:
        function: of the parameter.
        here: its value at zero.
        step: h; the function is evaluated there, at half of it, and at the opposite of both.
    """
    steps = np.array([step, step / 2.0])
    after, before = np.array([[function(t) for t in signed] for signed in (steps, -steps)])
    (whole, half), (bend, kink) = (after - before) / (2.0 * steps), (after - 2.0 * here + before) / steps
    return float((4.0 * half - whole) / 3.0), float(max(abs(whole - half), abs(2.0 * kink - bend)))


def displaced(robot: Robot, q: Array, rates: Array, t: float) -> Balls:
    """The configuration (nq,) reached from q with joint velocities during a time, to first order in it.

    Args:
        robot: the robot.
        q: (nq,) configuration.
        rates: (nv,) joint velocities, Pinocchio's layout; none of a floating base.
        t: the time [s].
    """
    out = balls(q)
    for part in robot.single_joints:
        if not rates[part.v].any():
            continue
        at, step, first, end = out[part.q], balls(t * rates[part.v]), part.q.start, part.q.stop
        if part.kind in ("revolute", "prismatic"):
            out[part.q] = at + step
        elif part.kind in ("continuous", "planar"):
            c, s = at[-2:]
            if part.kind == "planar":
                out[first : first + 2] = at[:2] + np.array([c * step[0] - s * step[1], s * step[0] + c * step[1]])
            out[end - 2 : end] = c - s * step[-1], s + c * step[-1]
        else:
            vector, scalar, half = at[-4:-1], at[-1], step[-3:] / 2
            if part.kind == "free":
                out[first : first + 3] = at[:3] + entries(rotation_matrix(at[-4:])) @ step[:3]
            out[end - 4 : end] = *(vector + scalar * half + np.cross(vector, half)), scalar - np.sum(vector * half)
    return out
