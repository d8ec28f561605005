"""What is derived from a solution: loads, energy, effective masses, extreme directions, pulses, and
the normalising speed.
"""

import dataclasses
import math

import dense
import numpy as np
import pytest
from panels import land, scene
from robot_texts import INERTIA, LIMIT, joint, link, urdf
from trees import known_robot, robot_from

from shockpc import Contact, Joints, Point, Posture, Scene, SceneError, Strike, shock_profile
from shockpc.core.most_severe import most_severe_direction
from shockpc.core.pulse import SHAPES, peak_acceleration, pulse_from
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.landing.scenes.strike import GRAVITY

FEET = {
    "anymal_b": ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"),
    "anymal_c": ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"),
    "go2": ("FL_foot", "FR_foot", "RL_foot", "RR_foot"),
    "solo12": ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"),
    "hyq": ("lf_foot", "rf_foot", "lh_foot", "rh_foot"),
}
MODELS = {
    "free": Joints(),
    "locked": Joints(model="locked"),
    "geared": Joints(armature={"*": 0.05}),
}
SOMERSAULT = Strike(velocity=(0.0, 0.0, -2.0), angular_velocity=(0.0, 3.0, 0.0))


def struck(name, *feet, **changes):
    contact = tuple(Contact(frame=foot) for foot in feet or FEET[name][:1])
    return shock_profile(
        Scene(**({"robot": name, "contact": contact} | changes)), known_robot(name)
    )


# Impulses through the joints


def test_loads_of_a_loop_are_those_of_the_cut_closed_again():
    """About its end, where the loop of Skippy's drive is closed, only the pin loads the rod: r × F
    is its change of momentum.
    """
    profile = land("fig3")
    rod = profile.bodies.index("rod")
    body, R = profile.robot.bodies[rod], profile.rotation[rod]
    force = next(load.force for load in profile.loads if load.joint == "crank_pin")
    end = profile.robot.frame("rod_end").offset
    change = R @ body.inertia @ profile.delta_omega[rod]
    change = change + np.cross(
        R @ (body.com - end), body.mass * dense.velocity(profile, rod, body.com)
    )
    np.testing.assert_allclose(np.cross(R @ -end, force), change, atol=1e-15)
    assert np.abs(change).max() > 1e-6


def test_a_knee_carries_more_when_locked():
    """ANYmal C, one foot, 1 m/s: 2.6 N s through the knee with free joints, 37.9 N s with locked
    ones.
    """
    loads = [
        {load.joint: load.force for load in struck("anymal_c", joints=MODELS[joints]).loads}
        for joints in ("free", "locked")
    ]
    assert [float(np.linalg.norm(load["LF_KFE"])) for load in loads] == pytest.approx(
        [2.6, 37.9], abs=0.06
    )


# Effective masses, mitigation, friction


def test_joints_that_move_the_contact_by_rounding_alone_mitigate_nothing(tmp_path):
    """A contact on the axis of the only joint, which is there to 17 digits: factors of exactly
    zero, stuck or sliding.
    """
    tilted = '<origin xyz="0.18 0.192 0.144"/>'  # 0.3 m along the axis
    axle = joint("axle", "base", "wheel", "continuous", "0.6 0.64 0.48", "")
    text = urdf(
        link("base"),
        link("wheel"),
        '<link name="hub"/>',
        axle,
        joint("end", "wheel", "hub", "fixed", more=tilted),
    )
    (tmp_path / "wheel.urdf").write_text(text)
    (contact,) = shock_profile(
        Scene(robot=str(tmp_path / "wheel.urdf"), contact=Contact(frame="hub"))
    ).contacts
    assert (contact.mitigation, contact.mitigation_frictionless) == (0.0, 0.0)


def response(H, J, K):
    """Velocity of a point after unit impulses on it along x, y and z (3, 3), while the rows K stay
    held.
    """
    whole = np.block([[H, K.T], [K, np.zeros((len(K), len(K)))]])
    pushed = np.concatenate([J.T, np.zeros((len(K), 3))])
    # Rows of a planar loop repeat one another, so their impulses are not unique; the motion is.
    return J @ np.linalg.lstsq(whole, pushed, rcond=1e-12)[0][: len(H)]


@pytest.mark.parametrize(
    ("name", "stance", "loop"),
    [
        ("go2", (), ()),
        ("go2", ("FR_foot", "RL_foot"), ()),
        ("fig3", (), ("rod_end", "leg_lever")),
        ("fig3", ("head",), ("rod_end", "leg_lever")),
    ],
    ids=["alone", "stance", "closure", "stance and closure"],
)
def test_effective_masses_while_stance_and_closures_hold(name, stance, loop):
    """1 / (nᵀ A n) and nᵀ A⁻¹ n for the response A of the point; what is held lets the point move
    less.
    """
    found = (
        scene(name) if loop else Scene(robot=name, contact="FL_foot", joints=Joints(drives="none"))
    )
    if stance:
        found = dataclasses.replace(found, strike=Strike(), stance=stance)
    profile = shock_profile(found, robot_of(found) if loop else known_robot(name))
    model, q, (contact,) = profile.robot.model, profile.q, profile.contacts
    H, J = dense.inertia(model, q), dense.point_rows(model, q, contact.frame)
    free = response(H, J, np.zeros((0, model.nv)))
    held = [dense.point_rows(model, q, frame) for frame in stance]
    if loop:
        held.append(dense.point_rows(model, q, loop[0]) - dense.point_rows(model, q, loop[1]))
    A = response(H, J, np.concatenate(held)) if held else free
    assert contact.effective_mass_frictionless == pytest.approx(1.0 / A[2, 2], rel=1e-9)
    # Skippy is planar: nothing moves along y.
    moving = np.abs(A).max(axis=0) > 1e-12 * np.abs(A).max()
    assert contact.effective_mass_sticking == pytest.approx(
        np.linalg.inv(A[np.ix_(moving, moving)])[-1, -1], rel=1e-7
    )
    if held:
        reduced = np.linalg.eigvalsh(free - A)
        assert reduced[0] > -1e-9 * np.abs(free).max()
        assert reduced[-1] > 1e-4 * np.abs(free).max()


def light_foot(size):
    """A foot that slides along x below a trunk; its mass [kg] and inertia [kg m²] are this number."""
    moments = '<inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'
    slide = joint(
        "slide", "trunk", "foot", "prismatic", "1 0 0", f'<origin xyz="0.1 0 -0.3"/>{LIMIT}'
    )
    return urdf(
        link("trunk", "10", moments.format(0.3)),
        link("foot", repr(size), moments.format(size)),
        slide,
    )


STRAIGHT_LEG = urdf(
    '<link name="world"/>',
    *(link(name, inertia=f'<origin xyz="0 0 -0.2"/>{INERTIA}') for name in ("thigh", "foot")),
    joint("hip", "world", "thigh", "continuous", more='<origin xyz="0 0 1"/>'),
    joint("knee", "thigh", "foot", more=f'<origin xyz="0 0 -0.4"/>{LIMIT}'),
)


@pytest.mark.parametrize("directions", [("z",), ("x", "y", "z")], ids=["frictionless", "sticking"])
@pytest.mark.parametrize("size", [1e-2, 1e-8, 1e-13, 1e-15])
def test_the_impulse_of_a_single_contact_is_its_effective_mass_times_the_speed(directions, size):
    """Also of a foot that is much lighter than the trunk, and of a leg that is straight but for a
    small angle.
    """
    end = Contact(
        frame="foot",
        offset=(0.0, 0.0, -0.4),
        directions=tuple(axis for axis in directions if axis != "y"),
    )
    cases = [
        (light_foot(size), Contact(frame="foot", directions=directions), Posture()),
        (STRAIGHT_LEG, end, Posture(joints={"knee": 1e-4 * size**0.1})),
    ]
    for text, contact, posture in cases:
        profile = shock_profile(
            Scene(robot="r", contact=(contact,), posture=posture), robot_from(text)
        )
        (found,) = profile.contacts
        mass = (
            found.effective_mass_frictionless
            if directions == ("z",)
            else found.effective_mass_sticking
        )
        assert found.impulse[2] == pytest.approx(mass, rel=1e-14)


def test_effective_masses_of_an_anymal_c():
    """0.46 kg if the foot slides, 2.71 kg if it sticks."""
    contact = struck("anymal_c").contacts[0]
    assert (contact.effective_mass_frictionless, contact.effective_mass_sticking) == pytest.approx(
        (0.46, 2.71), abs=0.006
    )


@pytest.mark.parametrize(
    ("name", "factor"), [("anymal_c", 0.721), ("go2", 0.780), ("solo12", 0.783), ("hyq", 0.866)]
)
def test_impact_mitigation_factors(name, factor):
    """det(1 − Λ Λ_L⁻¹), Wensing et al. (T-RO 2017), one foot; by Pinocchio's H, whose base rows
    alone are the locked robot.

    Without friction 1 − m / m_L, of the effective masses along the normal.
    """
    profile = struck(name, joints=Joints(model="free"))
    H, J = (
        of(profile.robot.model, profile.q, *more)
        for of, more in ((dense.inertia, ()), (dense.point_rows, FEET[name][:1]))
    )
    A, A_locked = (
        response(H, J, np.zeros((0, len(H)))),
        response(H[:6, :6], J[:, :6], np.zeros((0, 6))),
    )
    assert profile.contacts[0].mitigation == pytest.approx(
        np.linalg.det(A - A_locked) / np.linalg.det(A), rel=1e-9
    )
    assert profile.contacts[0].mitigation == pytest.approx(factor, abs=6e-4)
    assert profile.contacts[0].mitigation_frictionless == pytest.approx(
        1.0 - A_locked[2, 2] / A[2, 2], rel=1e-9
    )
    if name == "go2":
        assert profile.contacts[0].mitigation_frictionless == pytest.approx(0.948, abs=6e-4)
    locked = struck(name, joints=Joints(model="locked")).contacts[0]
    masses = profile.contacts[0].effective_mass_frictionless / locked.effective_mass_frictionless
    assert profile.contacts[0].mitigation_frictionless == pytest.approx(1.0 - masses, rel=1e-9)
    assert locked.mitigation_frictionless == 0.0
    fixed = struck(name, base="fixed").contacts[0]
    assert (fixed.mitigation, fixed.mitigation_frictionless) == (None, None)


@pytest.mark.parametrize(
    ("rotor", "mass", "factor"), [(None, 1.0, 10.0 / 11.0), (10.0, 6.0, 5.0 / 11.0)]
)
def test_impact_mitigation_factor_of_a_slider(rotor, mass, factor):
    """Wensing et al. (T-RO 2017), the example in one dimension: 10 kg on 1 kg, 0.91; 0.45 with a
    rotor that reflects 10 kg.
    """
    slide = joint(
        "slide", "trunk", "foot", "prismatic", "0 0 1", f'<origin xyz="0 0 -0.5"/>{LIMIT}'
    )
    robot = robot_from(urdf(link("trunk", "10"), link("foot", "1"), slide))
    joints = Joints(armature={} if rotor is None else {"slide": rotor})
    (contact,) = shock_profile(Scene(robot="r", contact="foot", joints=joints), robot).contacts
    assert (contact.effective_mass_sticking, contact.mitigation) == pytest.approx(
        (mass, factor), rel=1e-12
    )
    assert contact.mitigation_frictionless == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "friction"), [("go2", 0.44), ("anymal_c", 0.57), ("solo12", 0.62), ("hyq", 0.72)]
)
def test_friction_that_a_standard_stance_needs(name, friction):
    """The most that any one foot, landing alone straight down, needs to stick."""
    contacts = [struck(name, foot, joints=Joints(drives="none")).contacts[0] for foot in FEET[name]]
    for contact in contacts:
        assert contact.friction_needed == pytest.approx(
            np.hypot(*contact.impulse[:2]) / contact.impulse[2], rel=1e-12
        )
    assert max(contact.friction_needed for contact in contacts) == pytest.approx(
        friction, abs=0.006
    )


# The most and the least severe directions


@pytest.mark.parametrize("name", ["anymal_b", "go2"])
def test_extreme_directions_against_the_whole_sphere(name):
    """No strike of a fine sphere is outside the extremes, and the extremes are the shocks of
    strikes along their directions.
    """
    k = np.arange(4000) + 0.5
    polar, around = np.arccos(1.0 - 2.0 * k / len(k)), math.pi * (1.0 + math.sqrt(5.0)) * k
    sphere = np.stack(
        [np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)], axis=1
    )
    profile = struck(name)
    found = profile.directions
    for i, body in enumerate(profile.robot.bodies):
        v = profile.maps[i, 3:] + np.cross(profile.maps[i, :3].T, body.com).T
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


SINGULAR_VALUES = {
    "any": lambda rng: rng.uniform(size=(500, 3)),
    "nearly equal": lambda rng: np.column_stack(
        [np.ones(500), 1.0 - 10.0 ** rng.uniform(-16.0, -1.0, 500), rng.uniform(size=500)]
    ),
    "one": lambda rng: np.outer(np.ones(500), [1.0, 0.0, 0.0]),
    "two": lambda rng: np.outer(np.ones(500), [1.0, 0.5, 0.0]),
    "small": lambda rng: np.outer(np.ones(500), [1.0, 1e-9, 1e-9]),
    "equal": lambda rng: np.ones((500, 3)),
    "none": lambda rng: np.zeros((500, 3)),
}


@pytest.mark.parametrize("scale", [1.0, 1e-150, 1e150])
@pytest.mark.parametrize("name", SINGULAR_VALUES)
def test_the_formula_of_the_most_severe_direction_gives_the_greatest_singular_value(name, scale):
    rng = np.random.default_rng(5)
    left, right = np.linalg.qr(rng.normal(size=(2, 500, 3, 3)))[0]
    maps = scale * np.einsum("nij,nj,nkj->nik", left, SINGULAR_VALUES[name](rng), right)
    direction, shock = most_severe_direction(maps, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(shock, np.linalg.svd(maps, compute_uv=False)[:, 0], rtol=1e-14)
    np.testing.assert_allclose(
        np.linalg.norm(np.einsum("nij,nj->ni", maps, direction), axis=1), shock, rtol=1e-14
    )
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-14)
    assert (direction[:, 2] <= 0.0).all()


def test_the_most_severe_strike_is_what_a_scene_gives_in_that_direction():
    """A landing with that velocity has that shock at the sensor, more than straight down."""
    (first, *_) = struck("go2", point=(Point(frame="imu"),)).points
    (again, *_) = struck(
        "go2",
        point=(Point(frame="imu"),),
        strike=Strike(velocity=tuple(map(float, first.directions.most_severe))),
    ).points
    assert again.shock == pytest.approx(first.directions.most_severe_shock, rel=1e-9)
    assert again.shock > first.shock


# Pulses


t = (np.arange(200000) + 0.5) / 200000


@pytest.mark.parametrize(
    ("shape", "form"),
    [
        ("half-sine", np.sin(math.pi * t)),
        ("saw-tooth", t),
        ("haversine", np.sin(math.pi * t) ** 2),
        ("rectangle", np.ones_like(t)),
    ],
)
def test_a_pulse_has_the_area_of_its_jump(shape, form):
    """IEC 60068-2-27: the integral of the pulse is Δv, whatever its shape."""
    assert shape in SHAPES
    assert peak_acceleration(1.7, pulse_from(f"{shape}:11ms")) * float(
        form.mean()
    ) * 0.011 == pytest.approx(1.7, rel=1e-9)


def test_the_peak_at_a_sensor_is_that_of_its_jump():
    """π Δv / (2 T): 1 m/s in 5 ms is 32 g.

    Beyond a sensor's range there is a warning; without a pulse there is no peak.
    """
    assert peak_acceleration(1.0, pulse_from("half-sine:5ms")) / GRAVITY == pytest.approx(
        32.0, abs=0.1
    )
    profile = struck("anymal_b", pulse="half-sine:5ms", range_g=0.1)
    sensor = next(point for point in profile.points if point.frame == "imu_link")
    assert sensor.peak_g == pytest.approx(
        math.pi * np.linalg.norm(sensor.delta_v) / (2.0 * 0.005) / GRAVITY
    )
    along = math.pi * np.abs(sensor.delta_v).max() / (2.0 * 0.005) / GRAVITY
    (warned,) = [warning for warning in profile.health.warnings if warning.kind == "sensor"]
    assert warned[:3] == ("sensor", "imu_link", pytest.approx(along))
    assert profile.value("range_share", "point")[0] == pytest.approx(along / 0.1)
    assert struck("anymal_b").points[0].peak_g is None


# The speed by which shock is normalised


def test_v_in_of_the_centre_of_mass():
    """Falling without turning, contact and centre of mass have one speed; in a somersault shock is
    scaled by their ratio.
    """
    by_contact, by_com = (
        struck("anymal_b", strike=Strike(speed=2.0), v_in=v_in).v_in for v_in in ("contact", "com")
    )
    assert by_com == pytest.approx(by_contact, rel=1e-14)
    by_contact, by_com = (
        struck("anymal_b", strike=SOMERSAULT, v_in=v_in) for v_in in ("contact", "com")
    )
    lever = dense.centre_of_mass(by_com) - by_com.position[0]
    assert by_com.v_in == pytest.approx(
        np.linalg.norm(SOMERSAULT.velocity + np.cross(SOMERSAULT.angular_velocity, lever)),
        rel=1e-12,
    )
    ratio = by_contact.v_in / by_com.v_in
    np.testing.assert_allclose(by_com.shock_com, by_contact.shock_com * ratio, rtol=1e-12)
    np.testing.assert_allclose(by_com.ropc * ratio, by_contact.ropc, rtol=1e-12)
    np.testing.assert_allclose(by_com.copc, by_contact.copc)


def test_a_centre_of_mass_at_rest_normalises_nothing():
    """The beam's middle is half its length from the pivot: −0.5 + 1 · 0.5 = 0."""
    found = scene("fig1_d")
    spinning = Strike(velocity=(0.0, 0.0, -0.5), angular_velocity=(0.0, -1.0, 0.0))
    with pytest.raises(SceneError, match='v_in = "contact"'):
        _ = shock_profile(
            Scene(robot=found.robot, contact=found.contact, strike=spinning, v_in="com")
        ).v_in


def test_with_several_contacts_v_in_is_the_fastest():
    """Also where the fastest is not the first."""
    profile = struck("anymal_b", "LF_FOOT", "RH_FOOT", strike=SOMERSAULT)
    speeds = [float(np.linalg.norm(contact.approach)) for contact in profile.contacts]
    assert profile.v_in == pytest.approx(max(speeds))
    assert min(speeds) < 0.9 * max(speeds)
