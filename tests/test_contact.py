"""Contacts: which frame is meant, where the point is, what it stops, and what is refused."""

import math
from dataclasses import replace

import dense
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import joint, link, urdf
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Posture,
    Scene,
    Strike,
    read_scene,
    recorded,
    shock_profile,
    sweep,
)
from shockpc.landing.contact import contact_constraint, locate_lowest_point
from shockpc.landing.posture import configuration
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.method.constraints import constraint_point, row_jacobian
from shockpc.method.dynamics import dynamics

UP = np.array([0.0, 0.0, 1.0])
ANGLES = st.tuples(*[st.floats(-180.0, 180.0)] * 3)


def land(contact, robot="anymal_b", **changes):
    return shock_profile(Scene(robot=robot, contact=(contact,), **changes), known_robot(robot))


# Points


@given(st.integers(0, 2**32 - 1))
def test_contact_rows_are_the_derivative_of_the_point(seed):
    """J_c is the velocity of the point: central differences of its place along pin.integrate, and
    Pinocchio's Jacobian.
    """
    rng = np.random.default_rng(seed)
    robot = known_robot("anymal_b")
    frame, offset = "LH_FOOT", rng.uniform(-0.1, 0.1, 3)
    joints = dict(zip(robot.joint_names, rng.uniform(-1.0, 1.0, 12).tolist(), strict=True))
    q = configuration(
        robot, Posture(base_rpy_deg=tuple(rng.uniform(-90.0, 90.0, 3).tolist()), joints=joints)
    )
    state = dynamics(robot, q[None])
    found = contact_constraint(robot, Contact(frame=frame, offset=tuple(offset.tolist())), UP)
    J_c = row_jacobian(state, [locate_lowest_point(found, state.rotation[:, found.body])])[0]
    data, index = robot.model.createData(), robot.model.getFrameId(frame)

    def place(step):
        pin.framesForwardKinematics(robot.model, data, pin.integrate(robot.model, q, step))
        return data.oMf[index].act(offset)

    h = 1e-6
    moved = np.stack(
        [(place(h * e) - place(-h * e)) / (2.0 * h) for e in np.eye(robot.model.nv)], axis=1
    )
    np.testing.assert_allclose(J_c, moved, atol=1e-9)  # h² of curvature and 1e-16 / h of rounding
    np.testing.assert_allclose(J_c, dense.point_rows(robot.model, q, frame, offset), atol=1e-13)


def shape(geometry, origin="0 0 0", rpy="0 0 0"):
    return (
        f'<collision><origin xyz="{origin}" '
        f'rpy="{rpy}"/><geometry>{geometry}</geometry></collision>'
    )


def footed(*shapes, more=""):
    """A base with one foot of some collision geometry."""
    return robot_from(
        urdf(link("base"), link("foot", more="".join(shapes)), joint("ankle", "base", "foot"), more)
    )


def lowest(robot, rpy, offset=(0.0, 0.0, 0.0)):
    """The lowest point of the foot under a rotated base, from the foot's origin, world axes; and
    the foot's orientation.
    """
    state = dynamics(robot, configuration(robot, Posture(base_rpy_deg=rpy))[None])
    found = contact_constraint(robot, Contact(frame="foot", at="lowest", offset=offset), UP)
    point = constraint_point(state, locate_lowest_point(found, state.rotation[:, found.body]))[0]
    return point - state.position[0, 1], state.rotation[0, 1]


BALL = shape('<sphere radius="0.03"/>', "-0.1 0.02 -0.3")
BOX = '<box size="0.2 0.1 0.04"/>'
CORNERS = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.02, 0.02)])


@given(ANGLES)
def test_the_lowest_point_is_a_support_point_of_all_pieces(rpy):
    """Of a ball (its centre minus the radius), of a box (its lowest corner) and of both; the offset
    is added in the foot's axes.
    """
    point, R = lowest(footed(BALL), rpy)
    ball = R @ [-0.1, 0.02, -0.3] - 0.03 * UP
    np.testing.assert_allclose(point, ball, atol=1e-15)
    corner = ((CORNERS + np.array([0.1, 0.0, 0.0])) @ R.T)[:, 2].min()
    for shapes, height in (
        ((shape(BOX, "0.1 0 0"),), corner),
        ((BALL, shape(BOX, "0.1 0 0")), min(ball[2], corner)),
    ):
        point, _ = lowest(footed(*shapes), rpy, (0.01, 0.02, 0.03))
        # Points that are level to a millionth of the box share their mean.
        assert (point - R @ [0.01, 0.02, 0.03])[2] == pytest.approx(height, abs=4e-7)


@pytest.mark.parametrize(
    ("rpy", "expected"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, -0.02)),
        ((90.0, 0.0, 0.0), (0.0, 0.0, -0.05)),
        ((0.0, 90.0, 0.0), (0.0, 0.0, -0.1)),
        ((45.0, 0.0, 0.0), (0.0, -0.03 / math.sqrt(2.0), -0.07 / math.sqrt(2.0))),
    ],
)
def test_a_level_sole_or_edge_strikes_in_its_middle(rpy, expected):
    """Where a face or an edge is equally low, its middle counts."""
    np.testing.assert_allclose(lowest(footed(shape(BOX)), rpy)[0], expected, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.3, 2.8, 3.0, 17.0])
def test_a_wheel_strikes_below_its_axle(angle):
    """The contact point is vertically below the axle, however far the wheel has rolled."""
    wheel = footed(shape('<cylinder radius="0.1" length="0.04"/>', rpy=f"{math.pi / 2!r} 0 0"))
    np.testing.assert_allclose(lowest(wheel, (0.0, angle, 0.0))[0], [0.0, 0.0, -0.1], atol=1e-9)


@given(st.floats(-80.0, 80.0).filter(lambda angle: abs(angle) > 0.1))
def test_a_tilted_cylinder_stands_on_its_rim(angle):
    """The lowest point of a tilted cylinder is on the circle of its lower end, not on a corner of a
    polygon.
    """
    point, _ = lowest(
        footed(shape('<cylinder radius="0.1" length="0.04"/>', rpy="0 0 0.05")), (angle, 0.0, 0.0)
    )
    a = math.radians(angle)
    expected = [
        0.0,
        0.02 * math.sin(a) - math.copysign(0.1 * math.cos(a), a),
        -0.02 * math.cos(a) - 0.1 * abs(math.sin(a)),
    ]
    np.testing.assert_allclose(point, expected, atol=1e-9)


def test_only_the_link_s_own_geometry_counts():
    """A link fixed to the foot may be lower; the foot's lowest point is asked for."""
    ball = shape('<sphere radius="0.5"/>', "0 0 -1")
    toe = f'<link name="toe">{ball}</link>'
    robot = footed(BALL, more=toe + joint("weld", "foot", "toe", "fixed", more=""))
    np.testing.assert_allclose(lowest(robot, (0.0, 0.0, 0.0))[0], [-0.1, 0.02, -0.33], atol=1e-15)


# Directions


@given(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, -0.1)))
def test_a_sliding_contact_is_pushed_along_its_normal_alone(velocity):
    """Kept along z: no tangential impulse, no friction needed, one row, and the point keeps its
    tangential freedom.
    """
    profile = land(Contact(frame="LF_FOOT", directions=("z",)), strike=Strike(velocity=velocity))
    (contact,) = profile.contacts
    np.testing.assert_array_equal(contact.impulse[:2], 0.0)
    assert contact.impulse[2] > 0.0
    assert (contact.friction_needed, profile.health.rank, profile.health.rows) == (0.0, 1, 1)


@pytest.mark.parametrize(
    "directions",
    [((1.0, 0.2, 0.0), (0.0, 1.0, 0.3), (0.1, 0.0, 1.0)), ("z", (3.0, 0.0, 4.0), (0.0, -2.0, 0.0))],
    ids=["skew vectors", "a letter, and vectors of any length"],
)
def test_a_contact_kept_along_three_independent_directions_sticks(directions):
    """Which three they are does not matter: the jump and the impulse are those of x, y and z."""
    one, other = (
        land(Contact(frame="LF_FOOT", directions=kept)) for kept in (("x", "y", "z"), directions)
    )
    np.testing.assert_allclose(
        other.delta_qd, one.delta_qd, rtol=0, atol=1e-12 * np.abs(one.delta_qd).max()
    )
    np.testing.assert_allclose(other.contacts[0].impulse, one.contacts[0].impulse, atol=1e-12)


# Where a contact strikes, and whether it is a sole, where nobody says so


def leg(*shapes: str, at: str = "0 0 0"):
    """A trunk on a leg with a knee and an ankle, and a foot of some geometry at a place below the
    ankle.
    """
    parts = (
        link("base", "8"),
        link("shank", "1"),
        link("foot", "0.3", more="".join(shapes)),
        link("toe", "0.01"),
    )
    places = (
        (joint("knee", "base", "shank"), "0 0 0"),
        (joint("ankle", "shank", "foot"), "0 0 -0.3"),
    )
    places += ((joint("toe_joint", "foot", "toe", "fixed", more=""), at),)
    placed = (text.replace("</joint>", f'<origin xyz="{xyz}"/></joint>') for text, xyz in places)
    return robot_from(urdf(*parts, *placed))


WHEEL = shape('<cylinder radius="0.08" length="0.04"/>', "0 0 0", "1.5707963 0 0")
LANDS = {
    "sole": ((shape(BOX, "0.02 0 -0.08"),), {}, ("lowest", "flat")),
    "sole little below the ankle": ((shape(BOX, "0.02 0 0"),), {}, ("frame", "flat")),
    "level within the tolerance": (
        (shape(BOX, "0.02 0 -0.08", "0 0.02 0"),),
        {},
        ("lowest", "flat"),
    ),
    "tilted": ((shape(BOX, "0.02 0 -0.08", "0 0.3 0"),), {}, ("frame", "edge")),
    "toe alone": ((shape('<box size="0.04 0.1 0.02"/>', "0.12 0 -0.08"),), {}, ("frame", "edge")),
    "edge": ((shape('<box size="0.2 0 0.02"/>', "0 0 -0.08"),), {}, ("frame", "edge")),
    "corner": ((shape(BOX, "0.02 0 -0.08", "0.2 0.3 0"),), {}, ("lowest", "point")),
    "two rods": (
        tuple(
            shape('<cylinder radius="0.01" length="0.2"/>', f"0 {y} -0.08", "0 1.5707963 0")
            for y in (-0.04, 0.04)
        ),
        {},
        ("lowest", "flat"),
    ),
    "disc": (
        (shape('<cylinder radius="0.05" length="0.02"/>', "0 0 -0.08"),),
        {},
        ("lowest", "flat"),
    ),
    "ball": ((shape('<sphere radius="0.1"/>'),), {}, ("lowest", "point")),
    "wheel": ((WHEEL,), {}, ("lowest", "point")),
    "no geometry": ((), {}, ("frame", "point")),
    "offset": ((shape(BOX, "0.02 0 -0.08"),), {"offset": (0.02, 0.0, -0.1)}, ("frame", "point")),
    "offset of zeros": (
        (shape(BOX, "0.02 0 -0.08"),),
        {"offset": (0.0, 0.0, 0.0)},
        ("frame", "point"),
    ),
    "given": ((shape(BOX, "0.02 0 -0.08"),), {"at": "frame", "kind": "point"}, ("frame", "point")),
    "on a slope": ((shape(BOX, "0.02 0 -0.08"),), {"normal": (0.0, 0.3, 1.0)}, ("frame", "edge")),
    "slides and rebounds": (
        (shape(BOX, "0.02 0 -0.08"),),
        {"directions": ("z",), "restitution": 1.0},
        ("lowest", "flat"),
    ),
}


@pytest.mark.parametrize("case", LANDS)
def test_a_contact_is_what_carries_of_the_sole(case: str):
    """Whatever the link is called; a part beside the centre of pressure carries with its edge, a
    round foot is a point.
    """
    shapes, fields, expected = LANDS[case]
    robot = leg(*shapes)
    scene = shock_profile(
        Scene(robot=robot.label, contact=Contact(frame="foot", **fields)), robot
    ).scene
    assert (scene.contact[0].at, scene.contact[0].kind) == expected


def test_a_frame_in_a_sole_is_flat_and_a_toe_is_a_point():
    """Neither has geometry of its own; the foot that carries them has."""
    for at, kind in (("0.02 0 -0.1", "flat"), ("0.11 0 -0.1", "point"), ("0.02 0 -0.02", "point")):
        robot = leg(shape(BOX, "0.02 0 -0.08"), at=at)
        (contact,) = shock_profile(Scene(robot=robot.label, contact="toe"), robot).scene.contact
        assert (contact.at, contact.kind) == ("frame", kind)


@pytest.mark.parametrize(
    ("name", "frame", "sensor", "shock"),
    [
        ("g1", "left_ankle_roll_link", "imu_in_pelvis", 0.245673),
        ("talos", "left_sole_link", "imu_link", 0.735733),
        ("go2", "FL_foot", "imu", 0.057668),
    ],
)
def test_feet_of_robots_that_exist(name: str, frame: str, sensor: str, shock: float):
    """By a dense solution of the equations with Pinocchio's inertia and Jacobians."""
    profile = land(Contact(frame=frame), name, joints=Joints(carried=False))
    places = [place.name for place in profile.landing.points]
    assert profile.value("shock", "point")[places.index(sensor)] == pytest.approx(shock, abs=1e-6)


def test_a_contact_means_the_same_in_every_way_of_asking(tmp_path):
    """The resolved scene says what it became; a sweep and a table keep what the scene gives, in any
    order.
    """
    file = tmp_path / "leg.urdf"
    file.write_text(
        leg(shape(BOX, "0.02 0 -0.08")).source.xml.replace(
            'name="shank">', f'name="shank">{shape(BOX, "0 0 -0.1")}'
        )
    )
    (tmp_path / "scene.toml").write_text('robot = "leg.urdf"\ncontact = "foot"\n')
    scene = Scene(robot=file, contact=Contact(frame="foot", restitution=0.5))
    robot, given, place = (
        robot_of(scene),
        Contact(frame="foot", at="lowest", kind="flat", restitution=0.5),
        "shock_com@base",
    )
    expected = [
        shock_profile(Scene(robot=file, contact=one)).value("shock_com", "body")[0]
        for one in (given, replace(given, frame="shank", kind="point"))
    ]
    read = shock_profile(read_scene(tmp_path / "scene.toml"))
    assert (read.scene.contact[0].at, read.scene.contact[0].kind) == ("lowest", "flat")
    assert (
        shock_profile(read.scene).value("shock_com", "body")[0]
        == read.value("shock_com", "body")[0]
    )
    for names, values in ((["foot", "shank"], expected), (["shank", "foot"], expected[::-1])):
        swept = (
            sweep(scene, {"contact": names}, robot=robot, quantities=[place], prove=0)
            .chunk(0)
            .columns[place]
        )
        table = recorded({"contact": np.array(names)}, scene, quantities=[place]).table.columns[
            place
        ]
        np.testing.assert_allclose([swept, table], [values] * 2, atol=1e-12)
    # Offsets that vary are from the origin, not from the lowest point, at zero too.
    moved = (
        sweep(scene, {"offset-z": [0.0, -0.1]}, robot=robot, quantities=[place], prove=0)
        .chunk(0)
        .columns[place]
    )
    offsets = (replace(given, at="frame", kind="point", offset=(0.0, 0.0, z)) for z in (0.0, -0.1))
    at_offsets = [
        shock_profile(Scene(robot=file, contact=one)).value("shock_com", "body")[0]
        for one in offsets
    ]
    np.testing.assert_allclose(moved, at_offsets, atol=1e-12)


def test_geometry_that_cannot_be_read_is_reported_by_the_contact():
    """A missing mesh would move the contact to the frame without a word."""
    robot = leg(shape('<mesh filename="foot.stl"/>'))
    (warning,) = (
        one
        for one in resolve(Scene(robot=robot.label, contact="foot"), robot).warnings
        if one.kind == "geometry"
    )
    assert warning.subject == "foot"
    assert "foot.stl" in warning.text
