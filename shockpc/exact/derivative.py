"""Derivatives of an impact in ball arithmetic: central differences whose step is so small that only the derivative is left.

With a step h the error of a central difference is h²/6 of the third derivative. With h = 2^-100 that is 1e-61, and the digits
that the difference loses are covered by the working precision, which is raised until the quotient is known to the last digit of a
double.
"""

from collections.abc import Callable, Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.exact.balls import Balls, balls, entries, rotation_matrix, to_double
from shockpc.exact.proof import Proof
from shockpc.exact.solution import BallImpact
from shockpc.landing import PosedLanding
from shockpc.robot.record import Robot

__all__ = ["derivatives", "displaced"]

STEP = 2.0**-100
BITS = 256


def derivatives(proof: Proof, paths: Sequence[Callable[[float], PosedLanding]], outputs: Callable[[BallImpact], Balls]) -> Array:
    """The derivatives (p, n) of n results of an impact along p paths of its landing, the doubles nearest to the exact ones.

    Args:
        proof: of the landing, where every path is at t = 0.
        paths: from t to landings; the configuration and contact points may be balls.
        outputs: the results (n,).

    Raises:
        SingularError: an impact beside the given one has no solution.
    """

    def differences(impact: BallImpact) -> Array:
        size = np.array([abs(float(value)) for value in outputs(impact)])
        found = np.zeros((len(paths), len(outputs(impact))))
        for k, path in enumerate(paths):
            after, before = (outputs(BallImpact(path(t), proof.choice)) for t in (STEP, -STEP))
            found[k] = to_double((after - before) / (2.0 * STEP), size)
        return found

    return proof.read(differences, BITS)


def displaced(robot: Robot, q: Array, rates: Array, t: float) -> Balls:
    """The configuration (nq,) reached from q with joint velocities during a time, to first order in it.

    Args:
        robot: the robot.
        q: (nq,) configuration.
        rates: (nv,) joint velocities, Pinocchio's layout; none of a floating base.
        t: the time [s]; the second order is the same for t and −t, so that it cancels in a central difference.
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
