"""Random landings, printed numbers against an independent solution: the error is never above the
reported bound.
"""

from typing import NamedTuple
from unittest import mock

import flint
import numpy as np
from maximal import DIGITS, maximal_jumps
from random_landings import random_landing

from shockpc import SceneError, ShockProfile, SolveError, shock_maps, shock_profile
from shockpc.profile import ILL_CONDITIONED

MET = 1e-9
"""Speed of a row that was left out as dependent, after the impact, over the largest speed to be
undone.
"""


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
    return checked(number)[0]


def checked(number: int) -> tuple[Checked, ShockProfile | None]:
    """What came of a landing, and its profile; None if it is refused."""
    robot, scene = random_landing(number)
    try:
        profile = shock_profile(scene, robot)
    except SceneError as refusal:
        return Checked(number, str(refusal), 0.0, 0.0), None
    except SolveError as failure:  # every body has a mass and every set of rows an independent part
        return Checked(
            number, str(failure), 0.0 if str(failure).startswith("no verdict") else np.inf, 0.0
        ), None
    exact = maximal_jumps(profile.landing, profile.row_space.rows)
    return Checked(
        number, "", excess(profile, exact), float(exact.missed.max(initial=0.0))
    ), profile


def excess(profile, exact) -> float:
    """Largest over the bodies of true error over reported bound, which is relative to the motion of
    each body.

    The maps are the doubles nearest to the exact ones, so that each entry is off by half a unit in
    the last place of the largest.
    """
    errors = body_errors(profile.landing, exact, np.hstack([profile.delta_omega, profile.delta_v]))
    bounds = profile.proof.bounds
    off, true = difference(exact.jumps[..., :3], profile.maps)
    maps = np.abs(off).max(axis=(1, 2)) / np.maximum(
        2.0**-53 * np.abs(true).max(axis=(1, 2)), 1e-300
    )
    return float(
        max(
            np.max(np.where(errors > 0.0, errors / np.where(bounds > 0.0, bounds, 1e-300), 0.0)),
            maps.max(),
        )
    )


def body_errors(landing, exact, jumps) -> np.ndarray:
    """True error (nb,) of the jump of every body (nb, 6), relative to the body's motion.

    The size of a motion is the root of |v|² + (r |ω|)², with v at the origin of the body frame and
    the radius of gyration r.
    """
    length = landing.robot.rotation_lengths
    error, motion = (
        np.hypot(np.linalg.norm(x[:, 3:], axis=1), length * np.linalg.norm(x[:, :3], axis=1))
        for x in difference(exact.jumps[..., 3], jumps)
    )
    return error / np.where(motion > 0.0, motion, 1.0)


def difference(exact, values) -> tuple[np.ndarray, np.ndarray]:
    """Exact minus printed numbers, subtracted in long numbers; and the exact ones.

    What the balls leave open is no difference.
    """
    with flint.ctx.workdps(DIGITS):
        off = exact - np.vectorize(flint.arb, otypes=[object])(values)
        return np.vectorize(lambda ball: float(ball.abs_lower()))(off), np.vectorize(float)(exact)


def assert_maps_are_those_of_the_proof(profile):
    """The largest error of both ways to solve with H: as a matrix, and along the tree, as for many
    postures of large robots.
    """
    with mock.patch("shockpc.method.dynamics.WHOLE_ARRAYS", 0):
        along_the_tree = shock_maps(profile.landing, profile.q[None])
    return max(
        error_of_maps(profile, found)
        for found in (shock_maps(profile.landing, profile.q[None]), along_the_tree)
    )


def error_of_maps(profile, found):
    """Maps in double precision: within 1e-9 of each body's motion unless flagged; flagged are
    dependent rows and ill conditions.
    """
    exact = (profile.rotation[:, None] @ profile.maps.reshape(-1, 2, 3, 3)).reshape(-1, 6, 3)
    weight = np.repeat([profile.robot.rotation_lengths, np.ones(len(exact))], 3, axis=0).T[
        ..., None
    ]
    size, off = (
        np.linalg.norm(weight * part, axis=(1, 2)) for part in (exact, found.maps[0] - exact)
    )
    moves = size > 1e-13 * size.max()
    error = float(np.max(off[moves] / size[moves], initial=0.0))
    assert found.prove[0] or not (
        found.rank[0] < len(profile.proof.impulse) or found.condition[0] > ILL_CONDITIONED
    )
    assert found.rank[0] == len(profile.row_space.rows)
    if not found.prove[0]:
        assert error <= 1e-9
        # Bodies that move little lose more digits than the fastest.
        assert np.max(off) <= 1e-12 * max(1.0, found.condition[0] / 1e2) * size.max()
    return error
