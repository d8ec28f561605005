"""The reference itself: laws that hold to fifty digits, and closed forms."""

import mpmath
import numpy as np
import pytest
from mpmath import mp

from shockpc.bench.accuracy import body_errors
from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases import family
from shockpc.bench.exact import DIGITS, cross, shaken, widen
from shockpc.bench.exact_rows import mechanism
from shockpc.bench.reference import mobility, reference, solve_exactly
from shockpc.errors import SolveError
from shockpc.landing import complete, resolve
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

FIFTY = mpmath.mpf(10) ** -50

HARD = [
    ("robots", "one foot", 7.0),
    ("robots", "all feet, joints locked", 2.0),
    ("mass ratio", "struck heavy, rooted light", 1e10),
    ("knee", "fixed base, inclined", 1e-9),
    ("armature", "four feet", 1e8),
    ("light link", "toe", 1e-15),
    ("doubled contact", "alone", 1e-8),
    ("flat four-bar", "crank struck", 1e-10),
    ("restitution", "two feet", 1.0),
    ("far from the origin", "two feet", 1e9),
    ("links", "struck at the end", 50),
]


def posed(family_name, variant, value):
    robot, scene = family(family_name).case(variant, value).build()
    scene = complete(scene, robot)
    return robot, scene, resolve(scene, robot)


def exactly(robot, scene, landing):
    """The mechanism of a scene and its solution, with the shakes that decide on its rank."""
    m = mechanism(robot, scene, landing)
    return m, solve_exactly(m, lambda seed: mobility(mechanism(robot, scene, landing, shaken(seed))))


@pytest.mark.parametrize(("name", "variant", "value"), HARD)
def test_the_answer_put_back_meets_every_equation(name, variant, value):
    """Momentum along every joint and the speed of every row hold to more than fifty digits, on the hardest cases of the suite."""
    assert reference(*posed(name, variant, value)).violation < FIFTY


@pytest.mark.parametrize(("name", "variant", "value"), HARD[2:8])
def test_more_digits_change_nothing(name, variant, value):
    """With half as many digits again the same fifty come out."""
    robot, scene, landing = posed(name, variant, value)
    found = reference(robot, scene, landing)
    with mp.workdps(DIGITS + 50):
        _, finer = exactly(robot, scene, landing)
        size = max(abs(value) for value in finer.jumps.ravel())
        assert max(abs(value) for value in (finer.jumps - found.jumps).ravel()) < FIFTY * size


@pytest.mark.parametrize(("name", "variant", "value"), HARD[:2] + HARD[5:7])
def test_momentum_of_a_free_robot_changes_by_the_impulses_of_the_ground(name, variant, value):
    """Σ m Δv = Σ λ and Σ (c × m Δv + I Δω) = Σ p × λ, with bodies and impulses summed in the world."""
    robot, scene, landing = posed(name, variant, value)
    with mp.workdps(DIGITS):
        m, found = exactly(robot, scene, landing)
        gained, given = widen(np.zeros(6)), widen(np.zeros(6))
        for i, body in enumerate(robot.bodies):
            own = robot.model.inertias[body.joint]
            R = m.rotation[i]  # body frames of these robots are their joint frames
            omega, v = found.twists[i, :3], found.twists[i, 3:]
            spin = R @ widen(own.inertia) @ R.T @ omega
            gained = gained + np.concatenate([spin + cross(m.com[i], own.mass * v), own.mass * v])
        for x, row in zip(found.impulse, m.rows, strict=True):
            given = given + x * row.wrench[next(iter(row.wrench))]
        size = max(abs(value) for value in given)
        assert max(abs(value) for value in gained - given) < FIFTY * size


def test_a_full_bounce_keeps_the_energy():
    """With e = 1 a robot that fell without turning leaves with the kinetic energy it came with."""
    robot, scene, landing = posed("restitution", "two feet", 1.0)
    with mp.workdps(DIGITS):
        m, found = exactly(robot, scene, landing)
        strike = widen(landing.before.velocity)
        before = after = mp.zero
        for i, body in enumerate(robot.bodies):
            own = robot.model.inertias[body.joint]
            inertia = m.rotation[i] @ widen(own.inertia) @ m.rotation[i].T
            omega, v = found.twists[i, :3], strike + found.twists[i, 3:]
            before += own.mass * (strike @ strike)
            after += own.mass * (v @ v) + omega @ inertia @ omega
        assert abs(after - before) < FIFTY * before


def test_a_single_body_has_its_closed_form():
    """Struck upwards at a distance d beside its centre of mass, without friction: Δω = v d / (r² + d²), Δv = v r² / (r² + d²)."""
    robot = robot_of([Link(-1, "", np.zeros(3), np.eye(3)[1], 3.0, np.zeros(3), box(3.0, (0.4, 0.2, 0.1)))])
    contact = Contact(frame="link0", offset=(0.15, 0.0, 0.0), directions=("z",))
    scene = complete(Scene(robot="box", contact=(contact,), strike=Strike(speed=2.0)), robot)
    found = reference(robot, scene, resolve(scene, robot))
    with mp.workdps(DIGITS):
        d = mpmath.mpf(0.15)
        r2 = mpmath.mpf(float(robot.model.inertias[1].inertia[1, 1])) / 3
        expected = [0, -2 * d / (r2 + d * d), 0, 0, 0, 2 * r2 / (r2 + d * d)]
        assert max(abs(a - b) for a, b in zip(found.jumps[0], expected, strict=True)) < FIFTY


def test_two_bodies_on_a_slide_share_their_momentum():
    """A slide along the strike: the body above it goes on, the one below stops; a slide across it: both stop together."""
    links = [
        Link(-1, "", np.zeros(3), np.eye(3)[2], 2.0, np.zeros(3), box(2.0, (0.1, 0.1, 0.1))),
        Link(0, "prismatic", np.zeros(3), np.eye(3)[2], 3.0, np.zeros(3), box(3.0, (0.1, 0.1, 0.1))),
    ]
    for axis, expected in ((np.eye(3)[2], 0), (np.eye(3)[0], 1)):
        robot = robot_of([links[0], links[1]._replace(axis=axis)])
        scene = complete(Scene(robot="slide", contact=(Contact(frame="link0"),)), robot)
        found = reference(robot, scene, resolve(scene, robot))
        assert abs(found.jumps[0, 5] - 1) < FIFTY
        assert abs(found.jumps[1, 5] - expected) < FIFTY


def test_repeated_rows_are_counted_and_change_nothing():
    """Four sticking corners hold six directions, not twelve, and stop the box as two of its edges would."""
    robot, scene, landing = posed("corners", "sticking", 4)
    found = reference(robot, scene, landing)
    assert (found.rank, len(found.impulse)) == (6, 12)
    assert found.violation < FIFTY
    assert max(abs(value + expected) for value, expected in zip(found.jumps[0, 3:], landing.before.velocity, strict=True)) < FIFTY


def test_what_nothing_resists_is_refused():
    """A massless body at the end of a limb has no answer."""
    with pytest.raises(SolveError, match="nothing resists it"):
        reference(*posed("light link", "arm", 0.0))


KINDS = ("revolute", "continuous", "prismatic", "spherical", "planar")


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_joint_agrees_with_the_product(kind):
    """Two limbs of that kind under a body, turned away from every axis: product and reference agree to rounding."""
    axis = np.array([0.48, 0.6, 0.64])
    links = [Link(-1, "", np.zeros(3), axis, 5.0, np.array([0.1, 0.0, 0.0]), box(5.0, (0.3, 0.2, 0.1)))]
    for i in range(2):
        com, inertia = rod(1.0 + i, np.array([0.3, 0.1, -0.2]))
        links.append(Link(i, kind, np.array([0.2, -0.1, 0.1]), axis, 1.0 + i, com, inertia, rpy=(0.3, -0.2, 0.5)))
    robot = robot_of(links)
    joints = {name: 0.4 + 0.3 * i for i, name in enumerate(robot.joint_names)} if kind not in ("spherical", "planar") else {}
    scene = Scene(
        robot="kinds",
        posture=Posture(base_rpy_deg=(10.0, 20.0, 30.0), joints=joints),
        strike=Strike(velocity=(0.2, 0.1, -1.0)),
        contact=(Contact(frame="link2", offset=(0.1, 0.2, 0.3)),),
    )
    scene = complete(scene, robot)
    found = reference(robot, scene, resolve(scene, robot))
    assert found.violation < FIFTY
    profile = shock_profile(scene, robot)
    assert (
        body_errors(robot, found, np.hstack([profile.delta_omega, profile.delta_v])).own.max() < 1e-13
    )  # eight or ten joint rates


@pytest.mark.parametrize("name", ["panda", "talos_full"])
def test_mimic_joints_agree_with_the_product(name):
    """Followers tied by rows (here) and left out as columns (product, Eq. 7) give one answer."""
    from shockpc.robot.robot import load_robot

    robot = load_robot(name)
    scene = complete(Scene(robot=name, contact=(Contact(frame=robot.links[-1]),), strike=Strike(velocity=(0.3, 0.2, -1.0))), robot)
    found = reference(robot, scene, resolve(scene, robot))
    assert found.rank == 3 + len(robot.mimics)
    profile = shock_profile(scene, robot)
    assert body_errors(robot, found, np.hstack([profile.delta_omega, profile.delta_v])).own.max() < 1e-10  # 50 rates


def test_the_rounded_truth_has_no_error():
    """The reference, rounded to doubles, is right to rounding; a NaN is infinitely wrong, and so is its body alone."""
    robot, scene, landing = posed("restitution", "one foot", 0.5)
    found = reference(robot, scene, landing)
    rounded = found.jumps.astype(float)
    assert body_errors(robot, found, rounded).own.max() < 1e-15
    rounded[3, 1] = np.nan
    errors = body_errors(robot, found, rounded).own
    assert errors[3] == np.inf
    assert np.delete(errors, 3).max() < 1e-15
