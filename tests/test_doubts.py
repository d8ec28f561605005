"""Numbers that lose more digits than the jumps: each is right to 1e-9, or a warning names it; ordinary robots have none of that."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp
from trees import known_robot

from shockpc.bench.build import Link, box, robot_of, rod
from shockpc.bench.cases import family
from shockpc.bench.cases.chains import chain
from shockpc.bench.exact import DIGITS, cross, widen
from shockpc.bench.measure import measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.percussion import radii
from shockpc.bench.reference import reference
from shockpc.bench.system import system_of
from shockpc.core.contact_mass import delassus
from shockpc.core.impulse import solve_impact
from shockpc.core.maximal import mobility
from shockpc.errors import SceneError
from shockpc.health import judge
from shockpc.landing import complete, resolve
from shockpc.model.contact import Contact
from shockpc.model.dynamics import tree
from shockpc.model.equation import solve
from shockpc.model.joint_model import Joints
from shockpc.model.motion import velocity_before
from shockpc.model.posture import Posture
from shockpc.model.rows import about_com, point_block
from shockpc.profile import shock_profile
from shockpc.results.doubts import direction_doubts, impulse_doubts, load_doubts, total_doubts
from shockpc.results.loads import joint_loads
from shockpc.scene import Point, Scene, Strike

RIGHT = 1e-9
ORDINARY = [
    ("anymal_b", ("LF_FOOT",)),
    ("anymal_b", ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")),
    ("solo12", ("FL_FOOT",)),
    ("talos", ("left_sole_link", "right_sole_link")),
    ("quadruped", ("hind_foot",)),
]


@pytest.mark.parametrize(
    ("joints", "base"),
    [(Joints(), "free"), (Joints(), "fixed"), (Joints(model="locked"), "free")],
    ids=["free", "base fixed", "joints locked"],
)
@pytest.mark.parametrize(("name", "feet"), ORDINARY)
def test_ordinary_robots_raise_no_doubt(name, feet, joints, base):
    profile = shock_profile(
        Scene(robot=name, contact=tuple(Contact(frame=foot) for foot in feet), joints=joints, base=base), known_robot(name)
    )
    assert [w for w in profile.health.warnings if any(word in w for word in ("good to about", "rounding", "repeat"))] == []
    assert profile.health.error_estimate < 1e-11


def judged(name="anymal_b", foot="LF_FOOT", **changes):
    """All that the doubts are about, for one landing: robot, landing, bodies, verdict."""
    robot = known_robot(name)
    landing = resolve(complete(Scene(robot=name, contact=(Contact(frame=foot),), **changes), robot), robot)
    bodies = tree(robot, landing.state, landing.drives.armature, landing.G)
    solution = solve(robot, landing.state, landing.rows, landing.drives.armature, landing.G)
    return robot, landing, bodies, judge(robot, landing.state, bodies, landing.rows, solution)


def with_second(verdict, **changes):
    """The verdict with another second opinion."""
    return verdict._replace(second=verdict.second._replace(found=verdict.second.found._replace(**changes)))


@pytest.mark.parametrize(("off", "told"), [(1e-12, 0), (1e-8, 1)])
def test_what_two_solutions_do_not_share_is_doubted(off, told):
    """Impulses, loads and maps that differ in the twelfth digit pass; in the eighth each kind is named, with ten times as much."""
    robot, landing, bodies, verdict = judged(stance=("RH_FOOT",))
    found = verdict.second.found
    loads = joint_loads(robot, landing.state, bodies, landing.rows, verdict.solution)
    warned = [
        impulse_doubts(landing.rows, with_second(verdict, impulse=found.impulse * (1.0 + off))),
        load_doubts(robot, bodies, landing.rows, loads, with_second(verdict, through=found.through * (1.0 + off)), 1.0),
        direction_doubts(robot, landing.state, with_second(verdict, twists=found.twists * (1.0 + off))),
    ]
    assert [len(lines) for lines in warned] == [told] * 3
    total = total_doubts(landing.rows, 2, np.zeros(3), 1.0, with_second(verdict, impulse=found.impulse * (1.0 + off)))
    assert [line.split(":")[0] for line in total] == ["total impulse of the ground", "loss of kinetic energy of the robot"] * told
    if told:
        impulse, load, direction = (lines[0] for lines in warned)
        assert impulse == 'impulse of contact "LF_FOOT", stance "RH_FOOT": good to about 1e-07 of itself only'
        assert load.startswith('load of joint "LF_HAA", ')
        assert direction.startswith("most and least severe impact direction of base, ")


def test_both_formulations_give_the_same_loads_and_mobility():
    """What passes through the joints, and how a foot gives way while another stands: maximal coordinates against joint space."""
    robot, landing, bodies, verdict = judged(stance=("RH_FOOT",), joints=Joints(armature={"*_KFE": 0.1}))
    loads = joint_loads(robot, landing.state, bodies, landing.rows, verdict.solution)
    names = [robot.model.names[body.joint] for body in robot.bodies]
    for load in loads:
        through = verdict.second.found.through[names.index(load.joint), :, -1]
        np.testing.assert_allclose([*load.moment, *load.force], through, atol=1e-12)
    touch, (equation, state) = landing.touches[0], (verdict.solution.equation, landing.state)
    W = point_block(state, touch.body, touch.point, np.eye(3))[0]
    A = mobility(bodies, about_com(landing.rows.W[0, 3:], bodies), about_com(W, bodies))
    np.testing.assert_allclose(delassus(equation.H[0], equation.J_c[0, :3], equation.J_c[0, 3:]), A, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("ratio", [1e4, 1e6, 1e8])
def test_the_bracket_is_right_or_doubted(ratio):
    """Free drives in a scene with locked ones, against the exact answer of the free chain."""
    robot, scene = family("mass ratio").build("struck heavy, rooted light", ratio)
    scene = replace(scene, point=(Point(frame="link0"), Point(frame="link1")))
    locked = shock_profile(replace(scene, joints=Joints(model="locked")), robot)
    system = system_of(robot, scene)
    truth = reference(robot, system.scene, system.landing)
    doubted = any(w.startswith("shock with free drives: ") for w in locked.health.warnings)
    for bracket, body in zip(locked.bracket[1:], (0, 1), strict=True):
        with mp.workdps(DIGITS):
            v = truth.jumps[body][3:]
            exact = float(mp.sqrt(v @ v)) / locked.v_in
        assert abs(bracket.free / exact - 1.0) <= RIGHT or doubted


@pytest.mark.parametrize(("ratio", "doubted"), [(1e2, False), (1e4, False), (3e4, True), (1e8, False)])
def test_strikes_from_elsewhere_are_right_or_doubted(ratio, doubted):
    """A chain on its side, struck from above: what a strike along it would do, exactly, against the maps."""
    robot = chain(np.geomspace(1.0, ratio, 6), np.full(6, 0.4), out_of_plane=False)
    joints = dict(zip(robot.joint_names, (0.7, -0.9, 0.5, -0.3, 0.8), strict=True))
    contact = (Contact(frame="link5", offset=(0.0, 0.0, 0.4)),)
    scene = Scene(robot="chain", posture=Posture(base_rpy_deg=(90.0, 0.0, 0.0), joints=joints), contact=contact)
    profile, system = shock_profile(scene, robot), system_of(robot, scene)
    off = np.zeros(6)
    for k, velocity in enumerate(np.eye(3)):
        truth = reference(robot, system.scene, system.landing._replace(before=system.landing.before._replace(velocity=velocity)))
        with mp.workdps(DIGITS):
            for i, body in enumerate(robot.bodies):
                apart = widen(profile.maps[i][:, k]) - truth.jumps[i]
                v = apart[3:] + cross(apart[:3], widen(body.com))
                off[i] = np.hypot(off[i], float(mp.sqrt(v @ v)))
    size = np.linalg.norm(profile.directions.most_severe_shock[:, None], axis=1)
    wrong = [body.name for body, share in zip(robot.bodies, off / size, strict=True) if share > RIGHT]
    told = [w for w in profile.health.warnings if w.startswith("worst and least_severe strike of ")]
    assert all(any(name in line for line in told) for name in wrong)
    # In between, joint space has lost some digits of them and is still good enough for the strike itself.
    assert bool(told) == doubted


def test_radii_are_right_or_doubted_or_none():
    """A strike that passes the centre of mass ever nearer: RoPc is right to 1e-9, or warned of, or the body translates."""
    found = [one for case in family("through the centre").cases() for one in radii(case)]
    off = [one for one in found if one.ropc is not None and one.ropc > RIGHT]
    assert len(off) >= 1
    assert [one for one in off if not one.warned] == []
    assert all(one.ropc < 0.1 for one in off)
    assert any(one.ropc is None for one in found)
    assert any(one.ropc is not None and one.ropc <= RIGHT and not one.warned for one in found)


def test_a_long_column_struck_along_itself_translates():
    """A short rod between long ones, turned by nothing but rounding: no radius of percussion is made of noise."""
    links = []
    for i, length in enumerate((100.0, 0.01, 70.0)):
        com, inertia = rod(1.0, np.array([0.0, 0.0, length]))
        origin = np.array([0.0, 0.0, (0.0, 100.0, 0.01)[i]])
        links.append(Link(i - 1, "revolute", origin, np.array([0.0, 1.0, 0.0]), 1.0, com, inertia))
    tilt = np.radians(37.0)
    strike = Strike(velocity=(float(np.sin(tilt)), 0.0, float(np.cos(tilt))))
    posture = Posture(base_rpy_deg=(0.0, 37.0, 0.0))
    scene = Scene(
        robot="column",
        contact=(Contact(frame="link0"),),
        posture=posture,
        strike=replace(strike, velocity=(-strike.velocity[0], 0.0, -strike.velocity[2])),
    )
    profile = shock_profile(scene, robot_of(links, "column"))
    assert profile.translates.all()
    assert np.isinf(profile.ropc).all()


@pytest.mark.parametrize(
    ("apart", "rank", "marginal"),
    [(0.0, 1, False), (1e-17, 1, False), (1e-15, 1, True), (1e-14, 2, True), (1e-13, 2, False), (1e-3, 2, False)],
)
def test_rank_is_decided_on_both_sides_of_its_threshold(apart, rank, marginal):
    """Rows that repeat but for rounding, rows that nobody can tell, rows that differ: 8 n ε is 3.6e-15 here."""
    found = solve_impact(np.eye(2), np.array([[1.0, 0.0], [1.0, apart]]), np.ones((2, 1)))
    assert (int(found.rank), bool(found.marginal)) == (rank, marginal)


def held_against_the_truth(robot, scene):
    """What the bench makes of the product's own method for a landing."""
    case = replace(family("mass ratio").case("struck heavy, rooted light", 1e8), build=lambda: (robot, scene))
    return measure(case, DIRECT[:1], 0.0).results[0]


def landing_at_a_hinge(distance, seed):
    """A chain in some posture that lands on both links at one hinge, on points that far from it [m], and on its end."""
    rng = np.random.default_rng(seed)
    robot = chain(np.full(4, 1.0), np.full(4, 0.4))
    near = [tuple(float(x) for x in distance * rng.normal(size=3)) for _ in range(2)]
    upper = Contact(frame="link1", offset=(near[1][0], near[1][1], 0.4 + near[1][2]))
    posture = Posture(
        base_rpy_deg=tuple(rng.uniform(-90.0, 90.0, 3)), joints={name: float(rng.uniform(-1, 1)) for name in robot.joint_names}
    )
    return robot, Scene(
        robot="chain", contact=(Contact(frame="link2", offset=near[0]), upper, Contact(frame="link3")), posture=posture
    )


@pytest.mark.parametrize("distance", [0.0, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-6])
@pytest.mark.parametrize("seed", [0, 1, 5])
def test_two_contacts_at_almost_one_hinge_keep_the_promise(distance, seed):
    """Their rows nearly repeat one another, two solutions may part by as much as they are, and the estimate knows."""
    result = held_against_the_truth(*landing_at_a_hinge(distance, seed))
    assert result.outcome in ("right", "told")
    assert result.margin <= 1.0


@pytest.mark.parametrize(("distance", "told"), [(0.0, False), (1e-14, True), (1e-13, True), (1e-6, False)])
def test_rows_that_nobody_can_tell_are_told(distance, told):
    """One point, rounding's guess on both sides of the rank, or two points."""
    robot, scene = landing_at_a_hinge(distance, 0)
    health = shock_profile(scene, robot).health
    assert any("repeat one another so nearly" in w for w in health.warnings) == told
    assert (health.error_estimate >= 1.0) == told


@pytest.mark.parametrize("approach", [1e-2, 1e-4, 1e-6, 1e-8])
def test_an_approach_that_is_a_small_difference_is_right_or_doubted(approach):
    """A robot falls at 3 m/s and draws its foot in almost as fast: what is left of the speed is known to fewer digits."""
    robot = known_robot("anymal_b")
    still = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT", directions=("z",)),))

    def falling(rate):
        return replace(still, strike=Strike(velocity=(0.0, 0.0, -3.0), joint_velocities={"LF_KFE": rate}))

    one, two = (float(shock_profile(falling(rate), robot).contacts[0].approach[2]) for rate in (0.0, 1.0))
    scene = falling((-approach - one) / (two - one))
    result = held_against_the_truth(robot, scene)
    assert result.margin <= 1.0
    assert result.outcome in ("right", "told")
    told = any("small differences of large ones" in w for w in shock_profile(scene, robot).health.warnings)
    assert told == (approach < 1e-3)


def test_a_body_at_rest_is_not_moved_by_rounding():
    """A light link between a foot that stands and the ground: both solutions agree that it rests, or it is said to be rounding."""
    for light in (1e-3, 1e-6, 1e-9):
        robot = chain(np.array([5.0, light, 200.0]), np.full(3, 0.4))
        posture = Posture(joints={"joint1": 0.4, "joint2": -0.7})
        scene = Scene(robot="chain", posture=posture, stance=("link1",), contact=(Contact(frame="link2", offset=(0.0, 0.0, 0.4)),))
        result = held_against_the_truth(robot, scene)
        assert result.outcome in ("right", "told")
        assert result.margin <= 1.0


@pytest.mark.parametrize("light", [1e-3, 1e-5])
@pytest.mark.parametrize("distance", [1e-5, 1e-8])
def test_rows_of_a_light_link_are_not_left_out_in_silence(light, distance):
    """Two contacts on a link of grams between one of half a ton and one of five: inertia hides the second, the rows show it."""
    robot = chain(np.array([500.0, light, 5000.0]), np.full(3, 0.4))
    posture = Posture(joints={"joint1": 0.4, "joint2": -0.7})
    contacts = tuple(Contact(frame="link1", offset=(d, 0.1, 0.2)) for d in (0.0, distance))
    scene = Scene(robot="chain", posture=posture, contact=contacts)
    result = held_against_the_truth(robot, scene)
    assert result.margin <= 1.0
    assert result.outcome in ("right", "told")


def test_rates_of_joints_do_not_move_a_planar_base():
    """The exact answer of a contact on the base, which no joint's rate can change, is the product's."""
    robot = chain(np.full(3, 1.0), np.full(3, 0.4))
    for rate in (0.0, 3.0):
        scene = Scene(
            robot="chain", base="planar", contact=(Contact(frame="link0"),), strike=Strike(joint_velocities={"joint2": rate})
        )
        system, profile = system_of(robot, scene), shock_profile(scene, robot)
        truth = reference(robot, system.scene, system.landing)
        np.testing.assert_allclose(
            profile.contacts[0].impulse @ system.landing.touches[0].directions.T, [float(x) for x in truth.impulse], atol=1e-12
        )


def test_a_point_that_nothing_can_move_is_refused_in_every_posture():
    """The hip of a robot on a stand lies on the only axis that turns: what rounding leaves of its lever is no lever."""
    robot = known_robot("anymal_b")
    for rpy in ((0.0, 0.0, 0.0), (11.0, 23.0, 37.0), (10.0, -20.0, 30.0), (30.0, 25.0, 45.0)):
        for directions in (("z",), ("x", "y", "z")):
            scene = Scene(
                robot="anymal_b",
                base="fixed",
                posture=Posture(base_rpy_deg=rpy),
                contact=(Contact(frame="LF_HIP", directions=directions),),
            )
            with pytest.raises(SceneError, match="cannot be stopped"):
                shock_profile(scene, robot)


@pytest.mark.parametrize(("speed", "told"), [(1e-2, False), (1e-7, True)])
def test_a_normalising_speed_that_is_a_small_difference_is_told(speed, told):
    """Two rods, one up and one down: their centre of mass hardly moves, and shock is divided by what it does."""
    robot = chain(np.full(2, 1.0), np.full(2, 0.4))
    rates = {"joint1": -2.0}

    def moving(z):
        strike = Strike(velocity=(0.0, 0.0, z), joint_velocities=rates)
        return Scene(robot="chain", contact=(Contact(frame="link0"),), strike=strike, v_in="com", posture=BENT)

    # The centre of mass moves at a constant besides the velocity given, so two speeds tell which one leaves `speed`.
    landing = resolve(complete(moving(-1.0), robot), robot)
    com = [velocity_before(landing.state, landing.before, i, body.com)[0] for i, body in enumerate(robot.bodies)]
    x, y, z = np.mean(com, axis=0)
    strike = Strike(velocity=(-x, -y, -1.0 - z - speed), joint_velocities=rates)
    scene = Scene(robot="chain", contact=(Contact(frame="link0"),), strike=strike, v_in="com", posture=BENT)
    profile = shock_profile(scene, robot)
    assert profile.v_in == pytest.approx(speed, rel=1e-6)
    assert any("by which all shock is divided" in w for w in profile.health.warnings) == told


BENT = Posture(base_rpy_deg=(10.0, 20.0, 30.0), joints={"joint1": 0.8})


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-8])
def test_loads_beside_redundant_contacts_are_right_or_doubted(distance):
    """A slab lands on its four corners, which repeat one another, and an arm on its end: the arm's load is unique all the same."""
    slab = Link(-1, "", np.zeros(3), np.array([0.0, 1.0, 0.0]), 10.0, np.zeros(3), box(10.0, (0.3, 0.3, 0.3)))
    arm = Link(
        0,
        "revolute",
        np.array([0.15, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        2.0,
        np.array([0.31, 0.0, 0.0]),
        box(2.0, (0.4, 0.1, 0.1)),
    )
    robot = robot_of([slab, arm], "slab")
    corners = tuple(Contact(frame="link0", offset=(x, y, -0.15)) for x in (-0.13, 0.13) for y in (-0.13, 0.13))
    end = Contact(frame="link1", offset=(0.31 + distance, 0.0, -0.15), directions=("z",))
    scene = Scene(robot="slab", contact=(*corners, end))
    profile, system = shock_profile(scene, robot), system_of(robot, scene)
    truth = reference(robot, system.scene, system.landing)
    with mp.workdps(DIGITS):
        exact = np.array([float(2 * truth.twists[1][3 + k] - (truth.impulse[12] if k == 2 else 0)) for k in range(3)])
    off = np.linalg.norm(profile.loads[0].force - exact) / np.linalg.norm(exact)
    told = any(w.startswith('load of joint "joint1"') for w in profile.health.warnings)
    assert off <= RIGHT or told
    assert told == (distance < 1e-4)


@pytest.mark.parametrize(("distance", "told"), [(0.1, False), (1e-10, True)])
def test_the_locked_bracket_of_contacts_close_together_is_told(distance, told):
    """Two feet on two legs, so far apart: with free drives each leg gives way, locked they hold one body at almost one point."""
    robot = known_robot("anymal_b")
    fore = Contact(frame="LF_FOOT")
    landing = resolve(complete(Scene(robot="anymal_b", contact=(fore,)), robot), robot)
    state, touch, hind = landing.state, landing.touches[0], robot.frame("LH_FOOT")
    place = state.position[0, touch.body] + state.rotation[0, touch.body] @ touch.point + [distance, 0.0, 0.0]
    local = state.rotation[0, hind.body].T @ (place - state.position[0, hind.body])
    offset = hind.rotation.T @ (local - hind.offset)
    near = Contact(frame="LH_FOOT", offset=(float(offset[0]), float(offset[1]), float(offset[2])))
    profile = shock_profile(Scene(robot="anymal_b", contact=(fore, near)), robot)
    assert any(w.startswith("shock with locked drives: ") for w in profile.health.warnings) == told
