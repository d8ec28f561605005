"""Whole profiles: redundant and contradicting contacts, strikes and planes, joint models, and bodies without inertia."""

import math

import numpy as np
import pytest
from dense import velocity
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import joint, link, urdf
from trees import known_robot, robot_from

from shockpc.errors import SceneError, SolveError
from shockpc.landing import resolve
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.profile import shock_maps, shock_profile
from shockpc.results.percussion import ROUNDED
from shockpc.scene import GRAVITY, Point, Scene, Strike

CORNERS = [(x, y, -0.1) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]
ANYMAL_FEET = ("LF_FOOT", "LH_FOOT", "RF_FOOT", "RH_FOOT")


def box():
    """A body of 2 kg with its origin in the middle and no joints."""
    return robot_from(urdf(link("box", mass="2"), name="box"))


def land(robot, contacts, velocity=(0.0, 0.0, -1.0), **changes):
    return shock_profile(Scene(robot=robot.label, contact=tuple(contacts), strike=Strike(velocity=velocity), **changes), robot)


def refusal(robot, contacts, kind=SolveError, **changes):
    with pytest.raises(kind) as raised:
        land(robot, contacts, **changes)
    return str(raised.value)


# Contacts that repeat one another


@given(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-2.0, -0.1)))
def test_a_box_on_its_corners_stops(velocity):
    """Four sticking corners, twelve rows of which six are independent: no motion is left, and no single impulse is determined."""
    profile = land(box(), [Contact(frame="box", offset=corner) for corner in CORNERS], velocity)
    assert (profile.health.rank, profile.health.rows) == (6, 12)
    np.testing.assert_allclose(profile.delta_qd, [*np.negative(velocity), 0.0, 0.0, 0.0], atol=1e-13)
    assert [contact.impulse for contact in profile.contacts] == [None] * 4
    assert [contact.friction_needed for contact in profile.contacts] == [None] * 4
    assert profile.translates.tolist() == [True]


def test_a_box_on_frictionless_corners_needs_three():
    """Four normals, rank three: the box stops falling and keeps sliding."""
    contacts = [Contact(frame="box", offset=corner, directions=("z",)) for corner in CORNERS]
    profile = land(box(), contacts, (0.4, 0.0, -1.0))
    assert (profile.health.rank, profile.health.rows) == (3, 4)
    np.testing.assert_allclose(profile.delta_qd, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], atol=1e-13)


def test_a_locked_robot_on_four_feet_is_a_box():
    """All joints locked, four feet at once: six of twelve rows, everything stops, and no impulse of a single foot is reported."""
    robot = known_robot("anymal_b")
    profile = land(robot, [Contact(frame=foot) for foot in ANYMAL_FEET], (0.2, 0.1, -1.0), joints=Joints(model="locked"))
    assert (profile.health.rank, profile.health.rows) == (6, 12)
    assert [contact.impulse for contact in profile.contacts] == [None] * 4
    jump = (profile.rotation @ profile.delta_v[..., None])[..., 0]
    np.testing.assert_allclose(jump, np.tile([-0.2, -0.1, 1.0], (13, 1)), atol=1e-12)
    np.testing.assert_allclose(profile.delta_omega, 0.0, atol=1e-12)
    assert profile.translates.all()
    assert np.isinf(profile.ropc).all()


@pytest.mark.parametrize("base", ["free", "planar", "fixed"])
def test_four_feet_at_once_stop_all_four(base):
    """On every base the velocity of each foot is undone; legs of three joints give every foot its own three rows."""
    robot = known_robot("anymal_b")
    profile = land(robot, [Contact(frame=foot) for foot in ANYMAL_FEET], (0.2, 0.1, -1.0), base=base)
    assert (profile.health.rank, profile.health.rows) == (12, 12)
    for contact in profile.contacts:
        frame = robot.frames[contact.frame]
        np.testing.assert_allclose(velocity(profile, frame.body, frame.offset), [-0.2, -0.1, 1.0], atol=1e-13)
        assert contact.impulse is not None


def test_bodies_that_nothing_moves_are_at_rest():
    """Two feet of a robot on a fixed base: the other legs and the base have jumps of zero."""
    profile = land(known_robot("anymal_b"), [Contact(frame="LF_FOOT"), Contact(frame="RH_FOOT")], base="fixed")
    still = [i for i, name in enumerate(profile.bodies) if name[:2] in ("LH", "RF", "ba")]
    assert len(still) == 7
    assert not profile.delta_v[still].any()
    assert not profile.delta_omega[still].any()
    assert not profile.moved[still].any()
    assert profile.translates[still].all()


@pytest.mark.parametrize("distance", [0.4, 1e-3, 1e-6, 3e-9])
def test_two_corners_are_an_axis(distance):
    """Two sticking points leave a rotation about the line through them: five of six rows, the one along the line shared."""
    profile = land(box(), [Contact(frame="box", offset=(0.3, y, -0.1)) for y in (0.0, distance)])
    assert (profile.health.rank, profile.health.rows) == (5, 6)
    assert [contact.impulse is None for contact in profile.contacts] == [True, True]
    # About the line: I_o ω = m v · arm, with I_o = 0.1 + 2 (0.3² + 0.1²).
    np.testing.assert_allclose(profile.delta_omega[0], [0.0, -2.0 * 0.3 / (0.1 + 2.0 * (0.3**2 + 0.1**2)), 0.0], atol=1e-15)


def test_one_point_twice_is_refused():
    """The same point of the same body is one contact, whatever the frames are called."""
    contacts = [Contact(frame="box", offset=(0.3, 0.0, -0.1))] * 2
    assert refusal(box(), contacts, kind=SceneError) == (
        'contact "box" and contact "box" are at one point of one body, which strikes or stands once; '
        "leave one of them out, or move it by an offset"
    )


# Contacts that cannot be met


def test_a_contact_that_the_mechanism_cannot_follow_is_refused():
    """Legs that move in x–z on a fixed base: a foot struck from the side cannot give way."""
    robot = known_robot("quadruped")
    assert refusal(robot, [Contact(frame="hind_foot")], base="fixed", velocity=(0.0, 0.3, -1.0)) == (
        'no verdict: contact "hind_foot" cannot be stopped in posture "standing": 0.3 m/s are left along (0 1 0), because '
        "the mechanism cannot move that way here, or another contact asks for the opposite; "
        "leave that direction out of the contact or of the strike, take another contact point or posture, or free the base"
    )
    profile = land(robot, [Contact(frame="hind_foot")], base="fixed", velocity=(0.3, 0.0, -1.0))
    assert (profile.health.rank, profile.health.rows) == (2, 3)


def test_a_straight_leg_on_a_fixed_base_cannot_give_way():
    """A straight knee cannot shorten, so nothing can be stopped along the leg; a bend of 1e-6 gives a huge rate."""
    robot = known_robot("quadruped")
    posture = Posture(reference="neutral")
    message = refusal(robot, [Contact(frame="hind_foot")], base="fixed", posture=posture)
    assert message.startswith(
        'no verdict: contact "hind_foot" cannot be stopped in posture "neutral": 1 m/s are left along (0 0 1), because '
    )
    bend = 1e-6
    profile = land(
        robot, [Contact(frame="hind_foot")], base="fixed", posture=Posture(reference="neutral", joints={"hind_knee": bend})
    )
    # Two segments l, hip rate α and knee rate β about −y: ẋ = l (α + (α+β) cos b), ż = l (α + β) sin b, to be −0 and +1.
    beta_alpha = 1.0 / (0.4 * math.sin(bend))
    alpha = -beta_alpha * math.cos(bend)
    hip, knee = (robot.model.joints[robot.model.getJointId(name)].idx_v for name in ("hind_hip", "hind_knee"))
    np.testing.assert_allclose(profile.delta_qd[[hip, knee]], [alpha, beta_alpha - alpha], rtol=1e-9)


@pytest.mark.parametrize("bend", [1e-4, 1e-7, 1e-9])
def test_a_huge_rate_in_one_leg_hides_no_contradiction_in_another(bend):
    """A hind leg that is nearly straight gives way at a rate of one over its bend; the front leg is straight and cannot."""
    posture = Posture(reference="neutral", joints={"hind_knee": bend})
    contacts = [Contact(frame="hind_foot"), Contact(frame="front_foot")]
    message = refusal(known_robot("quadruped"), contacts, base="fixed", posture=posture)
    assert message.startswith(
        'no verdict: contact "front_foot" cannot be stopped in posture "neutral": 1 m/s are left along (0 0 1), because '
    )


@pytest.mark.parametrize("e", [1e-8, 1e-5, 1.0])
def test_contacts_that_contradict_one_another_are_refused(e):
    """Two points of one body, one to rebound along the line through both and one not: which is met would decide the result."""
    contacts = [Contact(frame="box", offset=(x, 0.0, -0.1), restitution=r) for x, r in ((-0.3, 0.0), (0.3, e))]
    message = refusal(box(), contacts, velocity=(0.5, 0.0, -1.0))
    assert message.startswith(
        f'no verdict: contact "box" cannot be stopped in posture "neutral": {0.5 * e:.3g} m/s are left along (1 0 0), because '
    )
    land(box(), contacts)  # straight down nothing contradicts


# A column: pure translation


@pytest.mark.parametrize("base", ["free", "planar"])
def test_a_straight_column_struck_along_its_axis_only_translates(base):
    """No CoPc, infinite RoPc, uniform shock of 1 in every body, and no pitch."""
    profile = land(known_robot("leg"), [Contact(frame="heel")], base=base, posture=Posture(reference="straight"))
    assert profile.translates.all()
    assert np.isinf(profile.ropc).all()
    assert np.isnan(profile.copc).all()
    assert np.isnan(profile.copc_world).all()
    np.testing.assert_allclose(profile.shock_com, 1.0, rtol=1e-12)
    np.testing.assert_allclose(profile.shock_min, 1.0, rtol=1e-12)
    np.testing.assert_allclose(profile.shock_max, 1.0, rtol=1e-12)
    np.testing.assert_allclose(profile.off_plane, 0.0, atol=1e-12)


@pytest.mark.parametrize("knee", [1e-9, 1e-6, 1e-3])
def test_a_bent_column_rotates_however_little_it_is_bent(knee):
    """RoPc is proportional to one over the bend, down to a billionth of a radian."""
    posture = Posture(reference="straight", joints={"knee": knee})
    profile = land(known_robot("leg"), [Contact(frame="heel")], posture=posture)
    assert not profile.translates.any()
    reference = land(known_robot("leg"), [Contact(frame="heel")], posture=Posture(reference="straight", joints={"knee": 1e-4}))
    np.testing.assert_allclose(profile.ropc * knee, reference.ropc * 1e-4, rtol=1e-5)  # the square of the bend


# NaN where nothing exists, and only there


@given(
    st.sampled_from(["go2", "talos", "quadruped"]),
    st.sampled_from(["free", "planar"]),
    st.floats(-80.0, 80.0),
    st.floats(0.0, 1.0),
    st.sampled_from(["xz", "yz", "xy", (1.0, 1.0, 0.2)]),
)
def test_only_what_does_not_exist_is_nan(name, base, angle, e, plane):
    """Every number of a profile is finite, but centre, radius and pitch of a body that only translates or does not turn."""
    robot = known_robot(name)
    foot = {"go2": "FL_foot", "talos": "left_sole_link", "quadruped": "hind_foot"}[name]
    x = math.sin(math.radians(angle))
    velocity = (x, 0.0, -math.cos(math.radians(angle)))
    profile = land(robot, [Contact(frame=foot, restitution=e)], velocity, base=base, plane=plane)
    for part in ("delta_qd", "maps", "position", "rotation", "delta_omega", "delta_v", "off_plane", "shock_com"):
        assert np.isfinite(getattr(profile, part)).all(), part
    np.testing.assert_array_equal(np.isnan(profile.copc).any(axis=1), profile.translates)
    np.testing.assert_array_equal(np.isnan(profile.copc_world).any(axis=1), profile.translates)
    np.testing.assert_array_equal(np.isinf(profile.ropc), profile.translates)
    assert np.isfinite(profile.pitch[~profile.translates]).all()
    assert np.all((profile.off_plane >= 0.0) & (profile.off_plane <= 1.0 + 1e-12))
    assert profile.health.error_bound <= 2.3e-16


def test_least_and_greatest_shock_enclose_the_points_of_a_body():
    """Whatever point of a body's box is asked for lies between its least and its greatest shock."""
    robot = known_robot("quadruped")
    profile = land(robot, [Contact(frame="hind_foot")])
    i = profile.bodies.index("torso")
    along = np.linspace(-0.4, 0.4, 41)
    shock = profile.shock_at("torso", np.stack([along, 0 * along, 0 * along], axis=1))
    assert profile.shock_min[i] <= shock.min()
    assert shock.max() <= profile.shock_max[i]
    assert profile.shock_com[i] == pytest.approx(shock[20], rel=1e-12)


def test_the_shock_of_a_point_follows_from_its_body():
    """A sensor's jump is v + ω × r in its own axes, and its shock the length of that over the strike's speed."""
    robot = known_robot("anymal_b")
    profile = land(robot, [Contact(frame="LF_FOOT")], (0.3, 0.1, -2.0), point=(Point(frame="RH_FOOT", offset=(0.1, 0.2, 0.3)),))
    found = {point.frame: point for point in profile.points}
    assert list(found) == ["imu_link", "RH_FOOT:0.1,0.2,0.3"]
    for name, offset in (("imu_link", (0.0, 0.0, 0.0)), ("RH_FOOT", (0.1, 0.2, 0.3))):
        frame = robot.frames[name]
        r = frame.offset + frame.rotation @ offset
        point = found[name if name == "imu_link" else "RH_FOOT:0.1,0.2,0.3"]
        jump = profile.delta_v[frame.body] + np.cross(profile.delta_omega[frame.body], r)
        np.testing.assert_allclose(frame.rotation @ point.delta_v, jump, atol=1e-14)
        assert point.shock == pytest.approx(np.linalg.norm(jump) / profile.v_in, rel=1e-13)
        assert point.shock == pytest.approx(profile.shock_at(point.body, r), rel=1e-13)
        np.testing.assert_allclose(point.position, profile.position[frame.body] + profile.rotation[frame.body] @ r, atol=1e-14)


# Strikes


@pytest.mark.parametrize(
    ("strike", "vector"),
    [
        (Strike(), (0.0, 0.0, -1.0)),
        (Strike(speed=2.0), (0.0, 0.0, -2.0)),
        (Strike(speed=2.0, strike_angle_deg=30.0), (1.0, 0.0, -math.sqrt(3.0))),
        (Strike(strike_angle_deg=-30.0), (-0.5, 0.0, -math.sqrt(3.0) / 2.0)),
        (Strike(velocity=(0.1, 0.2, -0.3)), (0.1, 0.2, -0.3)),
        (Strike(drop_height=0.5), (0.0, 0.0, -math.sqrt(GRAVITY))),
    ],
)
def test_a_strike_is_the_velocity_it_says(strike, vector):
    """The angle is counted from the vertical, positive moving forward; a fall of h ends at sqrt(2 g h)."""
    profile = shock_profile(Scene(robot="leg", contact=(Contact(frame="heel"),), strike=strike), known_robot("leg"))
    np.testing.assert_allclose(profile.strike, vector, atol=1e-15)
    assert profile.v_in == pytest.approx(np.linalg.norm(vector), rel=1e-15)


def test_a_scene_without_a_contact_is_refused():
    assert refusal(known_robot("leg"), [], kind=SceneError) == 'no contact is defined; name a link of robot "leg", such as "heel"'


# Bodies without inertia


def pendulum(mass, inertia, com, carry=""):
    """A box that carries a bob on a hinge, and a foot on the bob."""
    moments = f'<inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/>'
    bob = f'<link name="bob"><inertial><origin xyz="{com}"/><mass value="{mass}"/>{moments}</inertial></link>'
    hinge = joint("hinge", "box", "bob", "continuous", "0.1 1 0.2", more='<origin xyz="0.3 0.1 -0.2" rpy="0.3 0.4 0.5"/>')
    tip = '<link name="tip"/>' + joint("tip_fixed", "bob", "tip", "fixed", more='<origin xyz="0.2 0.1 -0.3"/>')
    return robot_from(urdf(link("box"), bob, hinge, tip, carry))


TILTED = Posture(base_rpy_deg=(10.0, 20.0, 30.0), joints={"hinge": 0.7})


@pytest.mark.parametrize(("mass", "com"), [("0", "0 0 0"), ("1", "0 0 0"), ("1", "0.01 0.1 0.02")])
def test_a_body_that_nothing_resists_is_named(mass, com):
    """A bob without mass, or with all of it on its axis: the message names the body, not the contact."""
    message = refusal(pendulum(mass, "0", com), [Contact(frame="tip")], posture=TILTED)
    assert message == (
        'body "bob" of robot "r" can move, but no mass or inertia resists it, so the inertia matrix cannot be inverted; give mass '
        "and inertia in the file (mass on a joint's axis does not resist turning about it), or lock the joints with --lock"
    )


@pytest.mark.parametrize("inertia", ["1e-6", "1e-12", "1e-16"])
def test_a_tiny_inertia_goes_to_its_limit(inertia):
    """As the inertia of the bob vanishes the shock tends to a limit."""
    light = land(pendulum("1", inertia, "0 0 0"), [Contact(frame="tip")], posture=TILTED)
    limit = land(pendulum("1", "1e-9", "0 0 0"), [Contact(frame="tip")], posture=TILTED)
    np.testing.assert_allclose(light.ropc, limit.ropc, rtol=1e3 * max(float(inertia), 1e-9))
    assert light.health.error_bound <= 2.3e-16


def test_a_massless_link_in_between_is_no_obstacle():
    """A bracket without mass between two hinges, as files have them, carries the shock like a body of hardly any mass."""
    extra = link("end", mass="0.5") + joint("second", "bob", "end", axis="1 0 0")
    profiles = [
        land(pendulum(mass, inertia, "0 0 0", extra), [Contact(frame="end", offset=(0.1, 0.2, -0.1))], posture=TILTED)
        for mass, inertia in (("0", "0"), ("1e-9", "1e-12"))
    ]
    np.testing.assert_allclose(profiles[0].delta_qd, profiles[1].delta_qd, rtol=1e-6)
    assert not profiles[0].translates.any()


# What a profile says of itself


def test_a_profile_is_read_only():
    """No array of it can be written to."""
    profile = shock_profile(Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),)), known_robot("anymal_b"))
    for name in ("q", "delta_qd", "maps", "position", "rotation", "delta_omega", "delta_v", "copc", "ropc", "total_impulse"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(profile, name)[...] = 0


@pytest.mark.parametrize(("share", "translates"), [(0.5, True), (2.0, False)])
@pytest.mark.parametrize("speed", [1e-3, 1.0, 1e3])
def test_a_rotation_within_the_rounding_of_files_is_a_translation(share, translates, speed):
    """A box struck so near its centre that its own size rotates by a share of ROUNDED, at every speed."""
    gyration = math.sqrt(0.1 / 2.0)
    beside = share * ROUNDED * gyration
    profile = land(box(), [Contact(frame="box", offset=(beside, 0.0, 0.0))], (0.0, 0.0, -speed))
    assert profile.translates.tolist() == [translates]
    assert profile.ropc[0] == (math.inf if translates else pytest.approx(gyration / (share * ROUNDED), rel=1e-12))
    assert np.isnan(profile.copc).all() == np.isnan(profile.pitch[0]) == translates


def test_a_profile_holds_the_complete_scene():
    """Defaults are filled in: posture, base, speed and angle."""
    profile = shock_profile(Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),)), known_robot("anymal_b"))
    assert profile.scene.posture.reference == "standing"
    assert profile.scene.base == "free"
    assert (profile.scene.strike.speed, profile.scene.strike.strike_angle_deg) == (1.0, 0.0)
    again = shock_profile(profile.scene, known_robot("anymal_b"))
    np.testing.assert_array_equal(again.delta_v, profile.delta_v)
    assert again.scene == profile.scene


@pytest.mark.parametrize(("armature", "model"), [({}, "free"), ({"*": 0.01}, "geared"), ({"*_KFE": 0.01}, "mixed")])
def test_the_joint_model_is_reported(armature, model):
    """Free, geared, or some of each."""
    profile = land(known_robot("anymal_b"), [Contact(frame="LF_FOOT")], joints=Joints(armature=armature))
    assert profile.joint_model == model


def test_reflected_inertia_goes_from_free_to_locked():
    """As it vanishes the joints are free, as it grows they are locked."""
    robot = known_robot("anymal_b")

    def jump(**joints):
        return land(robot, [Contact(frame="LF_FOOT")], joints=Joints(**joints)).delta_v

    free, locked = jump(), jump(model="locked")
    np.testing.assert_allclose(jump(armature={"*": 1e-12}), free, atol=1e-7)
    np.testing.assert_allclose(jump(armature={"*": 1e12}), locked, atol=1e-7)
    assert np.abs(free - locked).max() > 0.1


def test_the_joint_model_of_a_go2_decides_the_jump_of_its_trunk():
    """Two front feet straight down: the base jumps by −0.003 with free joints, 0.07, 0.25 and 0.48 geared, 0.80 locked."""
    robot = known_robot("go2")

    def jump(**joints):
        profile = land(robot, [Contact(frame="FL_foot"), Contact(frame="FR_foot")], joints=Joints(**joints))
        return (profile.rotation[0] @ profile.delta_v[0])[2]

    found = [jump(), *(jump(armature={"*": a}) for a in (0.01, 0.05, 0.2)), jump(model="locked")]
    np.testing.assert_allclose(found, [-0.003, 0.07, 0.25, 0.48, 0.80], atol=0.006)  # two digits were written down


def test_wrong_calls_are_refused_in_words(tmp_path):
    """A robot's name is no scene, a path may be a Path, and a configuration holds rotations."""
    with pytest.raises(SceneError, match="'anymal_b' is not a Scene"):
        shock_profile("anymal_b")
    file = tmp_path / "r.urdf"
    file.write_text(urdf(link("box")))
    profile = shock_profile(Scene(robot=file, contact=Contact(frame="box", offset=(0.1, 0.0, -0.1))))
    for wrong in (0.0, np.nan):
        with pytest.raises(SceneError, match="row 1 of Q"):
            shock_maps(resolve(profile.scene, profile.robot), np.stack([profile.q, profile.q * wrong]))
