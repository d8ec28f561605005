"""Contacts: which frame is meant, where the point is, what it stops, and every message about them."""

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import joint, link, urdf
from trees import known_robot, robot_from

from shockpc.errors import SceneError, UnknownName
from shockpc.model.contact import Contact, match_frames, touch
from shockpc.model.dynamics import dynamics
from shockpc.model.posture import Posture, configuration
from shockpc.model.rows import point_block, row_jacobian
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

UP = np.array([0.0, 0.0, 1.0])
SEEDS = st.integers(0, 2**32 - 1)


# Names


def named(*links):
    """A base that carries links of these names."""
    joints = [joint(f"j{i}", "base", name) for i, name in enumerate(links)]
    return robot_from(urdf(link("base"), *map(link, links), *joints))


def test_an_exact_name_beats_a_pattern():
    """A link called "foot" is meant by "foot", though "foot_left" contains it; in another case it is a part of both."""
    robot = named("foot", "foot_left")
    assert match_frames(robot, "foot") == ("foot",)
    assert match_frames(robot, "FOOT") == ("foot", "foot_left")


def test_a_name_that_looks_like_a_glob_means_itself():
    """An exact name is looked for first, whatever signs it holds."""
    assert match_frames(named("foot*", "foot_left"), "foot*") == ("foot*",)


@pytest.mark.parametrize("pattern", ["*_FOOT", "*_foot", "[LR]?_Foot", "foot", "FOOT"])
def test_globs_and_parts_of_names_ignore_case(pattern):
    """Four feet by a glob or by a part of their names, in the order of the bodies."""
    assert match_frames(known_robot("anymal_b"), pattern) == ("LF_FOOT", "LH_FOOT", "RF_FOOT", "RH_FOOT")


def test_an_exact_name_may_be_any_frame():
    """Joints are frames too; patterns look at links alone."""
    robot = known_robot("anymal_b")
    assert match_frames(robot, "LF_KFE") == ("LF_KFE",)
    with pytest.raises(UnknownName):
        match_frames(robot, "*_KFE")


@pytest.mark.parametrize(
    ("pattern", "hint"),
    [
        ("LF_FOTO", 'nearest: "LF_FOOT", "RF_FOOT", "LH_FOOT"'),
        ("lf_foto", 'nearest: "LF_FOOT", "RF_FOOT", "LH_FOOT"'),
        ("zzz*", "no name is similar"),
        ("", "no name is similar"),
    ],
)
def test_a_name_that_nothing_has_gets_the_nearest(pattern, hint):
    """No match: the name, the robot, the nearest names and the command that lists all."""
    with pytest.raises(UnknownName) as refusal:
        match_frames(known_robot("anymal_b"), pattern)
    assert str(refusal.value) == f'no link or frame "{pattern}" in robot "anymal"; {hint}. To list them: shockpc robots anymal_b'


# Points


@given(SEEDS)
def test_contact_rows_are_the_derivative_of_the_point(seed):
    """J_c q̇ is how fast the point moves: central differences of its place along pin.integrate, in every direction of motion."""
    rng = np.random.default_rng(seed)
    robot = known_robot("anymal_b")
    frame, offset = "LH_FOOT", tuple(rng.uniform(-0.1, 0.1, 3).tolist())
    joints = dict(zip(robot.joint_names, rng.uniform(-1.0, 1.0, 12).tolist(), strict=True))
    q = configuration(robot, Posture(base_rpy_deg=tuple(rng.uniform(-90.0, 90.0, 3).tolist()), joints=joints))
    state = dynamics(robot, q[None])
    found = touch(robot, Contact(frame=frame, offset=offset), state.rotation[0], UP)
    J_c = row_jacobian(state, point_block(state, found.body, found.point, found.directions))[0]

    data = robot.model.createData()
    index = robot.model.getFrameId(frame)

    def place(step):
        pin.framesForwardKinematics(robot.model, data, pin.integrate(robot.model, q, step))
        return data.oMf[index].act(np.array(offset))

    h = 1e-6
    moved = np.stack([(place(h * e) - place(-h * e)) / (2.0 * h) for e in np.eye(robot.model.nv)], axis=1)
    np.testing.assert_allclose(J_c, moved, atol=1e-9)  # h² of curvature and 1e-16 / h of rounding


def test_an_offset_is_in_the_frame_s_own_axes():
    """The contact of an offset foot lies where Pinocchio puts that point of that frame."""
    robot = known_robot("hyq")
    contact = Contact(frame="lf_foot", offset=(0.1, -0.2, 0.3))
    profile = shock_profile(Scene(robot="hyq", contact=(contact,), posture=Posture(base_rpy_deg=(10.0, 20.0, 30.0))), robot)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, profile.q)
    expected = data.oMf[robot.model.getFrameId("lf_foot")].act(np.array(contact.offset))
    np.testing.assert_allclose(profile.contacts[0].point, expected, atol=1e-14)


def footed(geometry, origin="0 0 0", rpy="0 0 0"):
    """A base with one foot of some collision geometry."""
    shape = f'<collision><origin xyz="{origin}" rpy="{rpy}"/><geometry>{geometry}</geometry></collision>'
    return robot_from(urdf(link("base"), link("foot", more=shape), joint("ankle", "base", "foot")))


def lowest(robot, rpy, up=UP, offset=(0.0, 0.0, 0.0)):
    """The lowest point of the foot under a turned base, from the foot's origin, world axes."""
    state = dynamics(robot, configuration(robot, Posture(base_rpy_deg=rpy))[None])
    found = touch(robot, Contact(frame="foot", at="lowest", offset=offset), state.rotation[0], up)
    assert found.body == 1
    return state.rotation[0, 1] @ found.point, state.rotation[0, 1]


ANGLES = st.tuples(*[st.floats(-180.0, 180.0)] * 3)


@given(ANGLES)
def test_the_lowest_point_of_a_sphere_is_below_its_centre(rpy):
    """However the foot is turned: centre minus radius."""
    point, R = lowest(footed('<sphere radius="0.03"/>', "0.1 0.02 -0.3"), rpy)
    np.testing.assert_allclose(point, R @ [0.1, 0.02, -0.3] - [0.0, 0.0, 0.03], atol=1e-15)


@given(ANGLES)
def test_the_lowest_point_of_a_box_is_its_lowest_corner(rpy):
    """Turned at random a box stands on one corner; nothing of it is lower."""
    point, R = lowest(footed('<box size="0.2 0.1 0.04"/>'), rpy)
    corners = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.02, 0.02)]) @ R.T
    assert point[2] == pytest.approx(corners[:, 2].min(), abs=2e-7)  # what is level to a millionth of the box shares its middle


@pytest.mark.parametrize(
    ("rpy", "expected"),
    [((0.0, 0.0, 0.0), (0.0, 0.0, -0.02)), ((90.0, 0.0, 0.0), (0.0, 0.0, -0.05)), ((0.0, 90.0, 0.0), (0.0, 0.0, -0.1)),
     ((45.0, 0.0, 0.0), (0.0, -0.03 / math.sqrt(2.0), -0.07 / math.sqrt(2.0)))],
)  # fmt: skip
def test_a_level_sole_or_edge_strikes_in_its_middle(rpy, expected):
    """Of all that is equally low the middle counts: of a face, or of an edge."""
    point, _ = lowest(footed('<box size="0.2 0.1 0.04"/>'), rpy)
    np.testing.assert_allclose(point, expected, atol=1e-12)


@pytest.mark.parametrize("turn", [0.0, 0.7, 1.3, 2.8, 3.0, 17.0])
def test_a_wheel_strikes_below_its_axle(turn):
    """A wheel on its rim touches straight below its axle, however far it has rolled."""
    wheel = footed('<cylinder radius="0.1" length="0.04"/>', rpy=f"{math.pi / 2!r} 0 0")
    point, _ = lowest(wheel, (0.0, turn, 0.0))
    np.testing.assert_allclose(point, [0.0, 0.0, -0.1], atol=1e-9)


@given(st.floats(-80.0, 80.0).filter(lambda angle: abs(angle) > 0.1))
def test_a_tilted_cylinder_stands_on_the_rim(angle):
    """The lowest point of a tilted peg is on the circle of its lower end, not on a corner of a polygon."""
    point, _ = lowest(footed('<cylinder radius="0.1" length="0.04"/>', rpy="0 0 0.05"), (angle, 0.0, 0.0))
    a = math.radians(angle)
    expected = [0.0, 0.02 * math.sin(a) - math.copysign(0.1 * math.cos(a), a), -0.02 * math.cos(a) - 0.1 * abs(math.sin(a))]
    np.testing.assert_allclose(point, expected, atol=1e-9)


@given(ANGLES)
def test_the_lowest_point_is_a_support_point_of_all_pieces(rpy):
    """Of a foot made of a ball and a box, the lower of the two; the offset is added in the foot's axes."""
    second = '<collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.1 0.04"/></geometry></collision>'
    robot = robot_from(footed('<sphere radius="0.03"/>', "-0.1 0 0").source.xml.replace("</collision>", "</collision>" + second, 1))
    point, R = lowest(robot, rpy, offset=(0.01, 0.02, 0.03))
    point = point - R @ [0.01, 0.02, 0.03]
    box = np.array([[0.1 + x, y, z] for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.02, 0.02)]) @ R.T
    assert point[2] == pytest.approx(min((R @ [-0.1, 0.0, 0.0])[2] - 0.03, box[:, 2].min()), abs=4e-7)


def test_only_the_link_s_own_geometry_counts():
    """A shin fixed under the foot's body may be lower; the foot's own lowest point is asked for."""
    text = footed('<sphere radius="0.03"/>').source.xml
    toe = '<link name="toe"><collision><origin xyz="0 0 -1"/><geometry><sphere radius="0.5"/></geometry></collision></link>'
    fixed = joint("weld", "foot", "toe", "fixed", more="")
    robot = robot_from(text.replace("</robot>", toe + fixed + "</robot>"))
    np.testing.assert_allclose(lowest(robot, (0.0, 0.0, 0.0))[0], [0.0, 0.0, -0.03], atol=1e-15)


# Directions


def refusal(contact, robot=None, up=UP):
    robot = robot or known_robot("anymal_b")
    state = dynamics(robot, configuration(robot, Posture())[None])
    with pytest.raises(SceneError) as raised:
        touch(robot, contact, state.rotation[0], up)
    return str(raised.value)


def test_directions_are_world_axes_or_vectors_of_any_length():
    """The letter "x" is (1, 0, 0), and a vector counts by its direction."""
    robot = known_robot("anymal_b")
    state = dynamics(robot, configuration(robot, Posture())[None])
    contact = Contact(frame="LF_FOOT", directions=("z", (3.0, 0.0, 4.0), (0.0, -2.0, 0.0)))
    found = touch(robot, contact, state.rotation[0], UP)
    np.testing.assert_allclose(found.directions, [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -1.0, 0.0]], atol=1e-16)


@given(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, -0.1)))
def test_a_sliding_contact_is_pushed_along_its_normal_alone(velocity):
    """Kept along z: no tangential impulse, no friction needed, the normal velocity undone and the rest left to itself."""
    contact = (Contact(frame="LF_FOOT", directions=("z",)),)
    profile = shock_profile(Scene(robot="anymal_b", contact=contact, strike=Strike(velocity=velocity)), known_robot("anymal_b"))
    impulse = profile.contacts[0].impulse
    np.testing.assert_array_equal(impulse[:2], 0.0)
    assert impulse[2] > 0.0
    assert profile.contacts[0].friction_needed == 0.0
    assert profile.health.rank == profile.health.rows == 1


def test_what_is_kept_along_any_three_axes_sticks():
    """Three independent directions stop the point whichever they are."""
    robot = known_robot("anymal_b")
    axes = ((1.0, 0.2, 0.0), (0.0, 1.0, 0.3), (0.1, 0.0, 1.0))
    one, other = (
        shock_profile(Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT", directions=kept),)), robot)
        for kept in (("x", "y", "z"), axes)
    )
    np.testing.assert_allclose(other.delta_qd, one.delta_qd, rtol=0, atol=1e-12 * np.abs(one.delta_qd).max())


def test_a_direction_without_length_is_refused():
    """Zero is no direction."""
    assert refusal(Contact(frame="LF_FOOT", directions=("z", (0.0, 0.0, 0.0)))) == (
        'contact "LF_FOOT" has a direction without a length; valid are "x", "y", "z" and vectors'
    )


def test_a_contact_that_keeps_nothing_is_refused():
    """Nothing kept, nothing struck."""
    assert refusal(Contact(frame="LF_FOOT", directions=())) == (
        'contact "LF_FOOT" keeps no direction, so nothing stops it; valid are "x", "y", "z" and vectors'
    )


def test_a_contact_that_keeps_only_the_ground_is_refused():
    """Held along the ground alone it falls through it."""
    assert refusal(Contact(frame="LF_FOOT", directions=("x", "y"))) == (
        'contact "LF_FOOT" keeps only directions along the ground, so nothing stops its fall; '
        "add the ground's normal (0, 0, 1) to its directions"
    )


@pytest.mark.parametrize("e", [-0.1, 1.01])
def test_restitution_lies_between_zero_and_one(e):
    """Less than nothing does not come back, and no ball rises above where it fell from."""
    assert refusal(Contact(frame="LF_FOOT", restitution=e)) == (
        f'contact "LF_FOOT" has restitution {e:g}; it lies between 0 (stays down) and 1 (bounces fully)'
    )


def test_a_link_without_collision_geometry_has_no_lowest_point():
    """The message says what to do instead."""
    assert refusal(Contact(frame="foot", at="lowest"), named("foot")) == (
        'link "foot" has no collision geometry that could be read, so it has no lowest point; '
        "give the contact point by its offset, or name a link that has collision geometry"
    )


def test_a_frame_of_the_world_cannot_strike():
    """What is bolted to the world does not fall."""
    text = (
        '<mujoco model="m"><worldbody><body name="post"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        '<body name="leg"><joint name="hip" axis="0 1 0"/><inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body>'
        "</body></worldbody></mujoco>"
    )
    assert refusal(Contact(frame="post"), robot_from(text, ".xml")) == (
        'contact "post" is fixed to the world, so it cannot strike; choose a frame on a moving link'
    )


def test_a_frame_that_is_not_there_is_named_with_the_nearest():
    """A contact takes exact names; patterns are for the command line."""
    robot = known_robot("anymal_b")
    state = dynamics(robot, configuration(robot, Posture())[None])
    with pytest.raises(UnknownName) as raised:
        touch(robot, Contact(frame="LF_FOOD"), state.rotation[0], UP)
    assert str(raised.value) == (
        'no frame "LF_FOOD" in robot "anymal"; nearest: "LF_FOOT", "RF_FOOT", "LH_FOOT". To list them: shockpc robots anymal_b'
    )
