"""The reported bounds against an independent solution in maximal coordinates."""

import flint
import mpmath
import numpy as np
import pytest
from maximal import BALLS, DIGITS, MPMATH, maximal_jumps
from proof_check import body_errors, check, excess
from random_landings import random_landing
from trees import known_robot

from shockpc import Scene, Strike, shock_profile

BLOCKS, EACH = 12, 20


@pytest.mark.parametrize("block", range(BLOCKS))
def test_no_error_is_above_the_reported_bound(block):
    """Of 240 random landings, some of which are refused; and no row is wrongly left out as dependent."""
    found = [check(number) for number in range(EACH * block, EACH * (block + 1))]
    assert [one for one in found if one.violated] == []
    assert sum(not one.message for one in found) >= EACH // 2


@pytest.mark.parametrize("number", sorted({*range(0, 60, 4)} - {8, 16, 20, 48}))  # which are refused
def test_two_libraries_of_long_numbers_agree(number):
    """The independent solution is the same with Arb's balls and with mpmath's numbers."""
    robot, scene = random_landing(number)
    profile = shock_profile(scene, robot)
    balls, numbers = (maximal_jumps(profile.landing, profile.choice.rows, kind) for kind in (BALLS, MPMATH))
    with flint.ctx.workdps(DIGITS), mpmath.workdps(DIGITS):
        size = max(abs(value.mid()) for value in balls.jumps.ravel())
        for ball, value in zip(balls.jumps.ravel(), numbers.jumps.ravel(), strict=True):
            assert abs(ball - flint.arb(mpmath.nstr(value, DIGITS))) < size * flint.arb("1e-50")


def test_contacts_that_contradict_one_another_are_refused_beside_a_loop():
    """Two points of one body at different heights that rebound: the digits of the loop are no excuse for what is left, 1.6e-5."""
    found = check(4011753)
    assert "cannot be stopped" in found.message


def solved(robot, scene):
    """The independent solution of a scene, and its profile."""
    profile = shock_profile(scene, robot)
    return maximal_jumps(profile.landing, profile.choice.rows), profile


OBLIQUE = Strike(velocity=(0.3, 0.2, -1.0))


@pytest.mark.parametrize("name", ["panda", "talos_full"])
def test_mimic_joints_agree(name):
    """Followers tied by rows (here) and left out as columns (package, Eq. 7) give the same answer."""
    robot = known_robot(name)
    exact, profile = solved(robot, Scene(robot=name, contact=robot.links[-1], strike=OBLIQUE))
    assert len(exact.impulse) == 3 + len(robot.mimics)
    assert excess(profile, exact) <= 1.0


def test_an_error_is_seen():
    """The exact answer rounded to doubles has an error of rounding; one digit that is changed shows in its body alone."""
    exact, profile = solved(known_robot("anymal_b"), Scene(robot="anymal_b", contact="LF_FOOT", strike=OBLIQUE))
    rounded = np.vectorize(float)(exact.jumps[..., 3])
    assert body_errors(profile.landing, exact, rounded).max() < 1e-15
    rounded[3] *= 1.0 + 1e-6
    errors = body_errors(profile.landing, exact, rounded)
    assert errors[3] == pytest.approx(1e-6, rel=1e-6)
    assert np.delete(errors, 3).max() < 1e-15


def test_a_landing_is_the_same_wherever_it_is_drawn():
    (robot, scene), (again, same) = random_landing(5), random_landing(5)
    assert scene == same
    assert [body.mass for body in robot.bodies] == [body.mass for body in again.bodies]
