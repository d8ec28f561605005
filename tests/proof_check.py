"""Random landings, printed numbers against an independent solution: the error is never above the reported bound."""

from typing import NamedTuple

import flint
import numpy as np
from maximal import DIGITS, maximal_jumps
from random_landings import random_landing

from shockpc.core.impulse import independent_rows
from shockpc.errors import ShockError
from shockpc.landing import complete, resolve
from shockpc.model.equation import solve
from shockpc.profile import shock_profile

MET = 1e-9
"""Speed of a row that was left out as dependent, after the impact, over the largest speed to be undone."""

UNMOVED = 1e-13
"""A body that moves by less than this share of the fastest one is compared with the fastest one."""


class Checked(NamedTuple):
    """What came of one landing.

    Attributes:
        number: of the landing.
        message: why the package refused it; empty if it did not.
        excess: largest over the bodies of true error over reported bound [1]: at most 1.
        missed: largest speed of a row left out as dependent [1]: at most `MET`.
    """

    number: int
    message: str
    excess: float
    missed: float

    @property
    def violated(self) -> bool:
        return not (self.excess <= 1.0 and self.missed <= MET)


def check(number: int) -> Checked:
    """Draw a landing, analyse it, and solve it independently."""
    robot, scene = random_landing(number)
    try:
        profile = shock_profile(scene, robot)
    except ShockError as refusal:
        return Checked(number, str(refusal), 0.0, 0.0)
    landing, rows = resolved(profile)
    exact = maximal_jumps(robot, profile.scene, landing, rows)
    return Checked(number, "", excess(profile, exact), float(exact.missed.max(initial=0.0)))


def resolved(profile):
    """The resolved landing of a profile, and the rows that were found independent."""
    landing = resolve(complete(profile.scene, profile.robot), profile.robot)
    solution = solve(profile.robot, landing.state, landing.rows, landing.drives.armature, landing.G)
    impact, equation = solution.impact, solution.equation
    return landing, independent_rows(equation.H[0], equation.J_c[0], int(impact.rank[0]), impact.dead[0])


def excess(profile, exact) -> float:
    """Largest of |exact - printed| over the reported bound, with the motion of each body as its unit."""
    bounds = 10.0 * np.asarray(profile.health.body_error_bounds) + 1e-14
    errors = body_errors(profile.robot, exact, np.hstack([profile.delta_omega, profile.delta_v]))
    return float(np.max(errors / bounds))


def body_errors(robot, exact, jumps, column=3) -> np.ndarray:
    """True error (nb,) of every body's jump (nb, 6), relative to the body's own motion; the difference is taken in long numbers.

    The size of a motion is the root of |v|² + (r |ω|)², with the velocity v of the centre of mass and the radius of gyration r.
    """
    trace = np.maximum(np.trace(robot.inertias, axis1=1, axis2=2), 0.0)
    radius = np.sqrt(trace / 3.0 / np.where(robot.masses > 0.0, robot.masses, np.inf))
    radius = np.where(radius > 0.0, radius, radius[radius > 0.0].min(initial=1.0))
    with flint.ctx.workdps(DIGITS):
        off = np.vectorize(float)(exact.jumps[:, :, column] - np.vectorize(flint.arb, otypes=[object])(jumps))
    true = np.vectorize(float)(exact.at_com[:, :, column])
    off[:, 3:] += np.cross(off[:, :3], robot.coms)
    error, motion = (np.hypot(np.linalg.norm(x[:, 3:], axis=1), radius * np.linalg.norm(x[:, :3], axis=1)) for x in (off, true))
    return error / np.where(motion > UNMOVED * motion.max(), motion, motion.max() or 1.0)
