"""Numbers that a designer asks for: loads, energy, effective masses, worst strikes, pulses, and what shock is normalised by."""

import dataclasses
import math

import numpy as np
import pinocchio as pin
import pytest
from shockpc.core.contact_mass import delassus, effective_masses
from shockpc.core.loads import joint_impulses, kinetic_energy
from shockpc.health import judge
from trees import known_robot

from shockpc.core.pulse import SHAPES, peak_acceleration, pulse_from
from shockpc.errors import SceneError
from shockpc.landing import complete, resolve
from shockpc.model.contact import Contact
from shockpc.model.dynamics import tree
from shockpc.model.equation import solve
from shockpc.model.joint_model import Joints
from shockpc.model.motion import twists_before
from shockpc.paper.landings import land, robot_of, scene
from shockpc.profile import shock_profile
from shockpc.scene import GRAVITY, Point, Scene, Strike

ONE_FOOT = {"anymal_b": "LF_FOOT", "anymal_c": "LF_FOOT", "go2": "FL_foot", "solo12": "FL_FOOT", "hyq": "lf_foot"}


def struck(name, contact=None, **changes):
    given = {"robot": name, "contact": contact or (Contact(frame=ONE_FOOT[name]),)}
    return shock_profile(Scene(**(given | changes)), known_robot(name))


# Impulses through the joints


@pytest.mark.parametrize(
    "joints", [Joints(), Joints(model="locked"), Joints(armature={"*": 0.05})], ids=["free", "locked", "geared"]
)
@pytest.mark.parametrize("name", ["anymal_b", "go2", "hyq"])
def test_joint_impulses_balance_to_the_root(name, joints):
    """Leaf to root, F_i = I_i Δv_i − f_i + Σ F_child; what is left at the floating base is zero."""
    robot = known_robot(name)
    found = complete(Scene(robot=name, contact=(Contact(frame=ONE_FOOT[name]),), joints=joints), robot)
    landing = resolve(found, robot)
    bodies = tree(robot, landing.state, landing.drives.armature, landing.G)
    solution = solve(robot, landing.state, landing.rows, landing.drives.armature, landing.G)
    solution, *_ = judge(robot, landing.state, bodies, landing.rows, solution)
    jump = solution.jumps[0, :, :, -1]
    R = landing.state.rotation[0]
    com = np.stack([body.com for body in robot.bodies])
    world = np.concatenate(
        [(R @ jump[:, :3, None])[..., 0], (R @ (jump[:, 3:] + np.cross(jump[:, :3], com))[..., None])[..., 0]], axis=1
    )
    wrench = np.einsum("c,cbk->bk", solution.impact.impulse[0, :, -1], landing.rows.W[0])
    through = joint_impulses(bodies, world, wrench)
    size = np.linalg.norm(solution.impact.impulse[0, :, -1])
    # An armature's reaction on the base is inside the joint, so nothing of it is left at the root either.
    np.testing.assert_allclose(through[0], 0.0, atol=1e-11 * size)
    assert np.abs(through[1:]).max() > 1e-3 * size


def test_the_knee_of_an_anymal_carries_15_times_more_when_locked():
    """ANYmal C, one foot, 1 m/s: 2.6 N·s through the knee with free joints, 37.9 N·s with locked ones."""
    found = []
    for joints in (Joints(), Joints(model="locked")):
        loads = {load.joint: load for load in struck("anymal_c", joints=joints).loads}
        found.append(float(np.linalg.norm(loads["LF_KFE"].force)))
    assert found == pytest.approx([2.6, 37.9], abs=0.06)


def test_a_free_joint_carries_no_moment_about_its_axis():
    for load in struck("anymal_b").loads:
        assert abs(load.along) < 1e-12


def test_loads_of_a_loop_are_those_of_the_cut_closed_again():
    """About its end, where the loop of Skippy's drive is closed, only the pin turns the rod: r × F is its change of momentum."""
    profile = land("fig3")
    rod = profile.bodies.index("rod")
    body, R = profile.robot.bodies[rod], profile.rotation[rod]
    force = next(load.force for load in profile.loads if load.joint == "crank_pin")
    end = profile.robot.frame("rod_end").offset
    v = R @ (profile.delta_v[rod] + np.cross(profile.delta_omega[rod], body.com))
    change = R @ body.inertia @ profile.delta_omega[rod] + np.cross(R @ (body.com - end), body.mass * v)
    np.testing.assert_allclose(np.cross(R @ -end, force), change, atol=1e-15)
    assert np.abs(change).max() > 1e-6


# Energy


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(
    "strike",
    [
        Strike(velocity=(0.3, 0.1, -1.0)),
        Strike(velocity=(0.0, 0.0, -2.0), angular_velocity=(1.0, 2.0, -0.5), joint_velocities={"*_KFE": 3.0}),
    ],
    ids=["falling", "turning"],
)
@pytest.mark.parametrize("joints", [Joints(), Joints(armature={"*": 0.05})], ids=["free", "geared"])
def test_the_energy_lost_is_the_drop_in_kinetic_energy(e, strike, joints):
    """½ Σ m v² + ½ ω·Iω of every body and every rotor, before less after."""
    robot = known_robot("anymal_b")
    contacts = tuple(Contact(frame=foot, restitution=e) for foot in ("LF_FOOT", "RH_FOOT"))
    found = complete(Scene(robot="anymal_b", contact=contacts, strike=strike, joints=joints), robot)
    profile = shock_profile(found, robot)
    landing = resolve(found, robot)
    bodies = tree(robot, landing.state, landing.drives.armature, None)
    before = twists_before(landing.state, landing.before)[0]
    R = profile.rotation
    jump = np.concatenate([(R @ profile.delta_omega[..., None])[..., 0], (R @ profile.delta_v[..., None])[..., 0]], axis=1)
    at_frame = profile.position - landing.state.origin[0]

    def energy(share):
        omega = before[:, :3] + share * jump[:, :3]
        v = before[:, 3:] + np.cross(before[:, :3], bodies.com)
        v = v + share * (jump[:, 3:] + np.cross(jump[:, :3], bodies.com - at_frame))
        drives = landing.before.joint_rates + share * profile.delta_qd
        return kinetic_energy(bodies, np.concatenate([omega, v], axis=1), drives)

    assert profile.energy_lost == pytest.approx(energy(0.0) - energy(1.0), abs=1e-10 * energy(0.0))
    assert profile.energy_share == pytest.approx(profile.energy_lost / energy(0.0), abs=1e-10)
    if e == 1.0:
        assert profile.energy_lost == pytest.approx(0.0, abs=1e-10)
    else:
        assert profile.energy_lost > 0.0


def test_one_sticking_point_takes_half_v_lambda_v():
    """½ vᵀ Λ v for an inelastic strike: straight down it is half the sticking mass."""
    for name in ONE_FOOT:
        profile = struck(name)
        assert profile.energy_lost == pytest.approx(0.5 * profile.contacts[0].mass_sticking, rel=1e-9)


# Effective masses and mitigation


def test_effective_masses_of_an_anymal_c():
    """0.46 kg if the foot slides, 2.71 kg if it sticks: which one is meant has to be said."""
    contact = struck("anymal_c").contacts[0]
    assert (contact.mass_frictionless, contact.mass_sticking) == pytest.approx((0.46, 2.71), abs=0.006)


def test_effective_masses_by_their_definition():
    """Λ = (J H⁻¹ Jᵀ)⁻¹ from Pinocchio's own H and J."""
    profile = struck("go2")
    model, data = profile.robot.model, profile.robot.model.createData()
    H = pin.crba(model, data, profile.q)
    H = np.triu(H) + np.triu(H, 1).T
    pin.computeJointJacobians(model, data, profile.q)
    pin.updateFramePlacements(model, data)
    J = pin.getFrameJacobian(model, data, model.getFrameId("FL_foot"), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)[:3]
    A = J @ np.linalg.solve(H, J.T)
    assert profile.contacts[0].mass_frictionless == pytest.approx(1.0 / A[2, 2], rel=1e-9)
    assert profile.contacts[0].mass_sticking == pytest.approx(np.linalg.inv(A)[2, 2], rel=1e-9)


def point_rows(robot, q, frame):
    """Rows (3, nv) of the velocity of a frame's origin along world x, y and z, from Pinocchio."""
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    return pin.getFrameJacobian(model, data, model.getFrameId(frame), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)[:3]


def gives_way(H, J, K):
    """How fast a point moves after a unit impulse on it along x, y and z (3, 3), while the rows K stay held: their KKT, solved."""
    whole = np.block([[H, K.T], [K, np.zeros((len(K), len(K)))]])
    pushed = np.concatenate([J.T, np.zeros((len(K), 3))])
    # Rows of a planar loop repeat one another, so their own impulses are not unique; what moves is.
    return J @ np.linalg.lstsq(whole, pushed, rcond=1e-12)[0][: len(H)]


STANDING = ("FR_foot", "RL_foot")
PINNED = ("rod_end", "leg_lever")


@pytest.mark.parametrize(
    ("name", "contact", "changes", "stands", "loop"),
    [
        ("go2", "FL_foot", {}, (), ()),
        ("go2", "FL_foot", {"stance": STANDING}, STANDING, ()),
        ("skippy", "toe", {}, (), PINNED),
        ("skippy", "toe", {"stance": ("head",)}, ("head",), PINNED),
    ],
    ids=["alone", "stance", "closure", "stance and closure"],
)
def test_effective_masses_while_stance_and_closures_hold(name, contact, changes, stands, loop):
    """What is held makes a point resist more: against a unit impulse on it, with those rows in the equation of motion."""
    found = scene("fig3") if name == "skippy" else Scene(robot=name, contact=(Contact(frame=contact),))
    found = dataclasses.replace(found, strike=Strike(joint_velocities={"*": 0.0}), **changes) if stands else found
    profile = shock_profile(found, robot_of(found) if loop else known_robot(name))
    robot, q = profile.robot, profile.q
    H = pin.crba(robot.model, robot.model.createData(), q)
    H = np.triu(H) + np.triu(H, 1).T
    J = point_rows(robot, q, contact)
    held = [point_rows(robot, q, frame) for frame in stands]
    if loop:
        held.append(point_rows(robot, q, loop[0]) - point_rows(robot, q, loop[1]))
    K = np.concatenate([np.zeros((0, robot.model.nv)), *held])
    A = gives_way(H, J, K)
    np.testing.assert_allclose(delassus(H, J, K), A, rtol=0.0, atol=1e-9 * np.abs(A).max())
    masses = profile.contacts[0].mass_frictionless, profile.contacts[0].mass_sticking
    up = np.array([0.0, 0.0, 1.0])
    assert masses == pytest.approx(effective_masses(A, up), rel=1e-7)
    assert masses[0] == pytest.approx(1.0 / A[2, 2], rel=1e-9)
    if len(K):
        alone = gives_way(H, J, np.zeros((0, robot.model.nv)))
        gained = np.linalg.eigvalsh(alone - A)
        assert gained[0] > -1e-9 * np.abs(alone).max()
        # Far above rounding, so that a wrong sign of what is held cannot pass.
        assert gained[-1] > 1e-4 * np.abs(alone).max()


@pytest.mark.parametrize(("name", "factor"), [("anymal_c", 0.721), ("go2", 0.780), ("solo12", 0.783), ("hyq", 0.866)])
def test_impact_mitigation_factors(name, factor):
    """Wensing et al. (T-RO 2017), one foot, no armature."""
    assert struck(name, joints=Joints(model="free")).contacts[0].mitigation == pytest.approx(factor, abs=6e-4)


def test_mitigation_has_no_meaning_on_a_fixed_base():
    assert struck("go2", base="fixed").contacts[0].mitigation is None


# Worst and least_severe strikes


@pytest.mark.parametrize("name", ["anymal_b", "go2"])
def test_worst_and_kindest_strikes_against_the_whole_sphere(name):
    """No strike of a fine sphere is worse than the worst or kinder than the least_severe, and both are nearly met."""
    k = np.arange(4000) + 0.5
    polar, around = np.arccos(1.0 - 2.0 * k / len(k)), math.pi * (1.0 + math.sqrt(5.0)) * k
    sphere = np.stack([np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)], axis=1)
    profile = struck(name)
    found = profile.directions
    for i, body in enumerate(profile.robot.bodies):
        if not profile.moved[i]:
            continue
        maps = profile.maps[i]
        v = maps[3:] + np.cross(maps[:3].T, body.com).T
        shock = np.linalg.norm(v @ sphere.T, axis=0)
        assert found.least_severe_shock[i] - 1e-12 <= shock.min()
        assert shock.max() <= found.most_severe_shock[i] + 1e-12
        assert shock.max() == pytest.approx(found.most_severe_shock[i], rel=2e-3)
        for direction, size in (
            (found.most_severe[i], found.most_severe_shock[i]),
            (found.least_severe[i], found.least_severe_shock[i]),
        ):
            assert np.linalg.norm(v @ direction) == pytest.approx(size, abs=1e-12)
            assert np.linalg.norm(direction) == pytest.approx(1.0)
            assert direction[2] <= 1e-12


def test_the_worst_strike_is_what_the_scene_gives_when_struck_so():
    first = struck("go2", point=(Point(frame="imu"),))
    direction = first.points[0].directions.most_severe
    again = struck("go2", point=(Point(frame="imu"),), strike=Strike(velocity=tuple(map(float, direction))))
    assert again.points[0].shock == pytest.approx(first.points[0].directions.most_severe_shock, rel=1e-9)
    assert again.points[0].shock > first.points[0].shock


# Pulses


@pytest.mark.parametrize(("shape", "form"), [("half-sine", np.sin), ("saw-tooth", None), ("haversine", None), ("rectangle", None)])
def test_a_pulse_has_the_area_of_its_jump(shape, form):
    """IEC 60068-2-27: the integral of the pulse is Δv, whatever its shape."""
    T, jump = 0.011, 1.7
    t = (np.arange(200000) + 0.5) / 200000
    profile = {
        "half-sine": np.sin(math.pi * t),
        "saw-tooth": t,
        "haversine": np.sin(math.pi * t) ** 2,
        "rectangle": np.ones_like(t),
    }[shape]
    peak = peak_acceleration(jump, pulse_from(f"{shape}:11ms"))
    assert peak * float(profile.mean()) * T == pytest.approx(jump, rel=1e-9)
    assert shape in SHAPES


def test_one_metre_a_second_in_five_milliseconds_is_32_g():
    assert peak_acceleration(1.0, pulse_from("half-sine:5ms")) / GRAVITY == pytest.approx(32.0, abs=0.1)


def test_the_peak_at_a_sensor_is_that_of_its_jump():
    profile = struck("anymal_b", pulse="half-sine:5ms", range_g=16.0)
    sensor = next(point for point in profile.points if point.frame == "imu_link")
    assert sensor.peak_g == pytest.approx(math.pi * np.linalg.norm(sensor.delta_v) / (2.0 * 0.005) / GRAVITY)
    assert struck("anymal_b").points[0].peak_g is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"pulse": "triangle:5ms"},
            'pulse: there is no pulse shape "triangle"; valid are half-sine, saw-tooth, haversine, rectangle, '
            "with a length such as half-sine:5ms",
        ),
        (
            {"pulse": "half-sine:0ms"},
            'pulse: a pulse of length "0ms" is not above zero; valid are half-sine, saw-tooth, haversine, rectangle, '
            "with a length such as half-sine:5ms",
        ),
        (
            {"pulse": "half-sine"},
            'pulse: "" is not the length of a pulse; valid are half-sine, saw-tooth, haversine, rectangle, '
            "with a length such as half-sine:5ms",
        ),
        ({"range_g": 16.0}, "a sensor's range is given in g, but no pulse; give one too, such as half-sine:5ms"),
        ({"pulse": "half-sine:5ms", "range_g": 0.0}, "a sensor's range of 0 g has to be above zero"),
    ],
    ids=["shape", "no time", "no length", "no pulse", "no range"],
)
def test_a_pulse_that_is_none_is_refused(changes, message):
    with pytest.raises(SceneError) as refusal:
        struck("anymal_b", **changes)
    assert str(refusal.value) == message


# What shock is normalised by


def test_v_in_from_the_centre_of_mass():
    """Falling without turning, contact and centre of mass are one speed; in a somersault shock is scaled by their ratio."""
    falling = [struck("anymal_b", strike=Strike(speed=2.0), v_in=v_in) for v_in in ("contact", "com")]
    assert falling[1].v_in == pytest.approx(falling[0].v_in, rel=1e-14)
    turning = Strike(velocity=(0.0, 0.0, -2.0), angular_velocity=(0.0, 3.0, 0.0))
    by_contact, by_com = (struck("anymal_b", strike=turning, v_in=v_in) for v_in in ("contact", "com"))
    model, data = by_com.robot.model, by_com.robot.model.createData()
    qd = np.zeros(model.nv)
    qd[:3], qd[3:6] = by_com.rotation[0].T @ (0.0, 0.0, -2.0), by_com.rotation[0].T @ (0.0, 3.0, 0.0)
    pin.centerOfMass(model, data, by_com.q, qd)
    assert by_com.v_in == pytest.approx(float(np.linalg.norm(data.vcom[0])), rel=1e-12)
    ratio = by_contact.v_in / by_com.v_in
    np.testing.assert_allclose(by_com.shock_com, by_contact.shock_com * ratio, rtol=1e-12)
    np.testing.assert_allclose(by_com.ropc * ratio, by_contact.ropc, rtol=1e-12)
    np.testing.assert_allclose(by_com.copc, by_contact.copc)


def test_a_centre_of_mass_at_rest_normalises_nothing():
    found = scene("fig1_d")
    spinning = Strike(velocity=(0.0, 0.0, -0.5), angular_velocity=(0.0, -1.0, 0.0))
    # The beam's middle is half its length from the pivot: −0.5 + 1 · 0.5 = 0.
    with pytest.raises(SceneError, match=r"^the robot's centre of mass is at rest before the impact, so it cannot normalise shock"):
        shock_profile(Scene(robot=found.robot, contact=found.contact, strike=spinning, v_in="com"))


def test_with_several_contacts_v_in_is_the_fastest():
    turning = Strike(velocity=(0.0, 0.0, -2.0), angular_velocity=(0.0, 3.0, 0.0))
    profile = struck("anymal_b", (Contact(frame="LF_FOOT"), Contact(frame="RH_FOOT")), strike=turning)
    speeds = [float(np.linalg.norm(contact.approach)) for contact in profile.contacts]
    assert profile.v_in == pytest.approx(max(speeds))
    assert min(speeds) < 0.9 * max(speeds)


@pytest.mark.parametrize(
    ("name", "feet", "friction"),
    [
        ("go2", ("FL_foot", "FR_foot", "RL_foot", "RR_foot"), 0.44),
        ("anymal_c", ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"), 0.57),
        ("solo12", ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"), 0.62),
        ("hyq", ("lf_foot", "rf_foot", "lh_foot", "rh_foot"), 0.72),
    ],
)
def test_friction_that_a_standard_stance_needs(name, feet, friction):
    """The most that any one foot, landing alone straight down, needs to stick."""
    needed = [struck(name, (Contact(frame=foot),)).contacts[0].friction_needed for foot in feet]
    assert max(needed) == pytest.approx(friction, abs=0.006)
