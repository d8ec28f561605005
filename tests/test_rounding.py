"""Angles and lengths that a CAD program rounded: a mechanism moves as the exact one does, and is
not locked by what is left.
"""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from robot_texts import link, urdf
from scipy.spatial.transform import Rotation
from trees import robot_from

from shockpc import Contact, Posture, Scene, SolveError, Strike, resolve, shock_maps, shock_profile
from shockpc.robot.rounding import rounding_of
from shockpc.show.header import header_lines
from shockpc.studies.analyze.report import landing_report

WIDE = '<limit lower="-5" upper="5" effort="1" velocity="1"/>'
FALL = (0.3, 0.0, -1.0)
QUARTER = -math.pi / 2.0


def chain(angle, links=2, rail=True, turn="{} 0 0", back=None):
    """A leg whose joints turn about y: a rotation by the angle, as it is written, brings their axes
    there.

    Args:
        angle: text of a quarter turn.
        links: how many.
        rail: whether a trunk that slides along z carries it, or the world.
        turn: roll, pitch and yaw of the first joint.
        back: text of the angle by which every second joint turns back, if any.
    """
    names = [f"link{k}" for k in range(links)]
    parts, carrier = ['<link name="world"/>'], "world"
    if rail:
        parts += [
            link("trunk"),
            _joint("rail", "world", "trunk", "0 0 1", "0 0 1", "0 0 0", "prismatic"),
        ]
        carrier = "trunk"
    for k, name in enumerate(names):
        rpy = (
            turn.format(angle)
            if k == 0
            else "0 0 0"
            if back is None
            else f"{(back, angle)[k % 2 == 0]} 0 0"
        )
        turned = k == 0 or back is None or k % 2 == 0
        place = (
            "0.02 0.1 0" if k == 0 else ("0 0.3 0" if back is None or not turned else "0 0 -0.3")
        )
        axis = "0 0 1" if turned else "0 1 0"
        parts += [link(name), _joint(f"joint{k}", carrier, name, axis, place, rpy)]
        carrier = name
    last = "0 0.3 0" if back is None or links % 2 else "0 0 -0.3"
    parts += [
        '<link name="foot"/>',
        _joint("ankle", carrier, "foot", "1 0 0", last, "0 0 0", "fixed"),
    ]
    return robot_from(urdf(*parts, name="chain"))


def _joint(name, parent, child, axis, place, rpy, kind="revolute"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}" rpy="{rpy}"/><axis xyz="{axis}"/>{WIDE}</joint>'
    )


def landing(robot, bend=40.0, strike=FALL, frame="foot"):
    joints = [name for name in robot.joint_names if name.startswith("joint")]
    angles = dict(zip(joints, (0.6 * bend, -bend, 0.8 * bend), strict=False))
    return Scene(
        robot="chain",
        contact=Contact(frame=frame),
        posture=Posture(joints_deg=angles),
        strike=Strike(velocity=strike),
    )


def numbers(profile):
    """Shock, impulses of the contact and through the joints, effective masses."""
    contact = profile.contacts[0]
    return np.concatenate(
        [
            profile.shock_com,
            contact.impulse,
            [contact.effective_mass],
            profile.value("joint_impulse", "joint"),
            np.linalg.norm(profile.delta_omega, axis=1),
        ]
    )


def written(digits):
    """A quarter turn to so many decimals."""
    return f"{QUARTER:.{digits}f}"


SHAPES = list(itertools.product((2, 3), (True, False), (None, "back")))


@pytest.mark.slow
@pytest.mark.parametrize("digits", [2, 3, 4, 5, 6, 7, 9, 12, 16])
@pytest.mark.parametrize(("links", "rail", "back"), SHAPES)
def test_a_leg_with_rounded_angles_lands_as_with_exact_ones(digits, links, rail, back):
    """Chains of two and three links, on a rail and on the world, with axes turned there, or there
    and back at every joint.
    """

    def robot(count):
        other = (
            None
            if back is None
            else f"{-QUARTER:.{count}f}"
            if count < 7
            else f"{-QUARTER:.{count - 1}f}"
        )
        return chain(written(count), links, rail, back=other)

    exact, rounded = (shock_profile(landing(given), given) for given in (robot(17), robot(digits)))
    np.testing.assert_allclose(numbers(rounded), numbers(exact), rtol=1e-3, atol=2e-3)
    assert rounded.health.rank == exact.health.rank == 2
    assert not any(warning.kind == "size" for warning in rounded.health.warnings)


@pytest.mark.parametrize("angle", ["-1.6", "-1.5707", "-1.57079", "-1.570800", "-1.5708E+00"])
def test_angles_cut_off_or_written_in_other_ways(angle):
    """One decimal, digits cut off instead of rounded, zeros at the end, an exponent."""
    profile = shock_profile(landing(robot := chain(angle)), robot)
    assert profile.health.rank == 2
    np.testing.assert_allclose(
        profile.shock_com,
        shock_profile(landing(exact := chain(repr(QUARTER))), exact).shock_com,
        atol=2e-2,
    )


@pytest.mark.parametrize(
    ("digits", "about"),
    list(itertools.product((4, 6), ((0.3, -0.5, 1.2), (0.785398, 0.5236, 0.0)))),
)
def test_axes_in_any_direction(digits, about):
    """A plane in any attitude, whose second joint's frame is written with its digits."""
    roll, pitch, yaw = (f"{angle:.{digits}f}" for angle in about)

    def robot(turn):
        parts = [link("a"), link("b"), '<link name="world"/>', '<link name="foot"/>']
        joints = [
            _joint("joint0", "world", "a", "0 0 1", "0 0 1", f"{roll} {pitch} {yaw}"),
            _joint("joint1", "a", "b", "0 1 0", "0.3 0 0", f"{turn} 0 0"),
            _joint("ankle", "b", "foot", "1 0 0", "0.3 0 0", "0 0 0", "fixed"),
        ]
        return robot_from(urdf(parts[2], *parts[:2], parts[3], *joints, name="turned"))

    exact, rounded = robot(repr(-QUARTER)), robot(f"{-QUARTER:.{digits}f}")
    posed = resolve(landing(exact, strike=(0.0, 0.0, -1.0)), exact)
    # The strike lies in the plane of motion, along which the contact can be stopped.
    J = posed.equation(posed.state).J_c[0]
    strike = J @ np.array([1.0, 0.4])
    strike *= -np.sign(strike[2]) / np.linalg.norm(strike)
    found = [
        shock_profile(landing(given, strike=tuple(strike.tolist())), given)
        for given in (exact, rounded)
    ]
    assert [profile.health.rank for profile in found] == [2, 2]
    np.testing.assert_allclose(
        found[1].delta_omega, found[0].delta_omega, atol=1e-3 * np.abs(found[0].delta_omega).max()
    )


@pytest.mark.parametrize(
    ("words", "rank"), [("-0.4330 0.7500 -0.5000", 2), ("-0.433 0.75 -0.5", 2), ("0 0.6 0.8", 3)]
)
def test_an_axis_of_few_decimals_is_rounded_where_its_length_is_not_one(words, rank):
    """Two parallel joints, and a third that should be: with zeros at the end, without, and a skew
    one that is meant.
    """
    axes = ("-0.4330127018922193 0.75 -0.5",) * 2 + (words,)
    parts, carrier, place = ['<link name="world"/>'], "world", "0 0 0"
    for k, axis in enumerate(axes):
        parts += [link(f"link{k}"), _joint(f"joint{k}", carrier, f"link{k}", axis, place, "0 0 0")]
        carrier, place = f"link{k}", "0.075 -0.12990381056766578 -0.2598076211353316"
    parts += [
        '<link name="foot"/>',
        _joint("ankle", carrier, "foot", "1 0 0", place, "0 0 0", "fixed"),
    ]
    robot = robot_from(urdf(*parts, name="chain"))
    in_plane = landing(robot, strike=(0.0, -0.5, -0.75))
    assert shock_profile(in_plane, robot).health.rank == rank


def test_what_is_left_out_stands_in_the_line_of_the_contact():
    """With the direction, which an exact leg does not have to name."""
    lines = {
        digits: dict(header_lines(shock_profile(landing(r := chain(written(digits))), r)))[
            "contact"
        ]
        for digits in (4, 17)
    }
    assert "not along (0 1 0), where only rounding of the file moves it" in lines[4]
    assert "not along" not in lines[17]


@pytest.mark.parametrize("digits", [2, 4, 6])
def test_a_strike_along_it_is_refused(digits):
    """The ground cannot stop what the mechanism cannot move."""
    with pytest.raises(SolveError, match=r"cannot be stopped.*\(0 1 0\)"):
        shock_profile(landing(r := chain(written(digits)), strike=(0.0, 0.2, -1.0)), r)


@pytest.mark.parametrize("bend", [1.0, 0.1, 1e-2, 1e-3])
def test_a_leg_that_is_nearly_straight_stays_one(bend):
    """On the world, where its direction is nearly singular: rounded angles change nothing of that."""
    found = [
        shock_profile(landing(r := chain(written(digits), rail=False), bend, (0.1, 0.0, -1.0)), r)
        for digits in (17, 4)
    ]
    assert [profile.health.rank for profile in found] == [2, 2]
    np.testing.assert_allclose(
        found[1].delta_omega,
        found[0].delta_omega,
        rtol=1e-3,
        atol=1e-6 * np.abs(found[0].delta_omega).max(),
    )


@pytest.mark.parametrize("digits", [2, 3, 4, 6, 16])
def test_a_leg_that_is_straight_but_for_rounding_is_refused(digits):
    """The knee's angle is rounded, so that the leg on the world is not quite straight; exactly
    straight, it is refused.
    """
    parts = [
        '<link name="world"/>',
        link("link0"),
        _joint("joint0", "world", "link0", "0 1 0", "0 0 1", "0 0 0"),
        link("link1"),
    ]
    parts += [
        _joint("joint1", "link0", "link1", "0 1 0", "0 0 -0.3", f"0 {written(digits)} 0"),
        '<link name="foot"/>',
    ]
    robot = robot_from(
        urdf(
            *parts,
            _joint("ankle", "link1", "foot", "1 0 0", "0.3 0 0", "0 0 0", "fixed"),
            name="chain",
        )
    )

    def straight(bend):
        posture = Posture(joints_deg={"joint0": 10.0, "joint1": bend})
        strike, contact = (
            Strike(velocity=(0.2, 0.0, -1.0)),
            Contact(frame="foot", directions=("x", "z")),
        )
        return Scene(robot="chain", contact=contact, posture=posture, strike=strike)

    with pytest.raises(
        SolveError, match="cannot be stopped" if digits == 16 else "singular or nearly so"
    ):
        shock_profile(straight(0.0), robot)
    assert shock_profile(straight(1.0), robot).health.rank == 2


def test_a_tilt_that_is_meant_stays():
    """0.02 rad are no rounding of a number with four decimals: the leg is locked by a contact that
    sticks, as it is drawn.
    """
    robot = chain(f"{QUARTER + 0.02:.4f}")
    assert shock_profile(landing(robot), robot).health.rank == 3


def mjcf_chain(write, axis="0 0 1", rail=True):
    """A leg in a plane, whose second joint's frame is turned about several axes, as an MJCF.

    Args:
        write: attribute for a rotation.
        axis: of the second joint, along y of the world.
        rail: whether a trunk that slides along z carries it, or the world.
    """
    mass = '<inertial pos="0 0 0" mass="1" diaginertia=".1 .1 .1"/>'
    turned = Rotation.from_euler("xyz", TURNED, degrees=True)
    place = turned.inv().apply([0.3, 0.0, -0.1])
    shin = (
        f'<body name="b" pos="0.1 0.1 -0.3" {write(turned)}><joint name="joint1" '
        f'axis="{axis}"/>{mass}'
    )
    shin += f'<site name="foot" pos="{" ".join(map(repr, place.tolist()))}"/></body>'
    thigh = f'<body name="a"><joint name="joint0" axis="0 1 0"/>{mass}{shin}</body>'
    slide = f'<body name="trunk"><joint name="rail" type="slide" axis="0 0 1"/>{mass}{thigh}</body>'
    return robot_from(
        f'<mujoco model="chain"><worldbody>{slide if rail else thigh}</worldbody></mujoco>', ".xml"
    )


TURNED = (45.0, 30.0, 60.0)
ALONG_Y = Rotation.from_euler("xyz", TURNED, degrees=True).inv().apply([0.0, 1.0, 0.0])
WRITTEN = {
    "quat": lambda turn: turn.as_quat()[[3, 0, 1, 2]],
    "euler": lambda turn: turn.as_euler("XYZ", degrees=True),
    "axisangle": lambda turn: np.append(
        turn.as_rotvec() / turn.magnitude(), np.degrees(turn.magnitude())
    ),
    "xyaxes": lambda turn: turn.as_matrix()[:, :2].T.ravel(),
}


@pytest.mark.slow
@pytest.mark.parametrize("rail", [True, False])
@pytest.mark.parametrize("digits", [4, 5, 6, 7])
@pytest.mark.parametrize("key", WRITTEN)
def test_rotations_about_several_axes_in_every_form_of_an_mjcf(key, digits, rail):
    """Quaternions, angles in degrees and axes, rounded, land as the exact rotation."""

    def robot(count):
        axis = " ".join(f"{x:.{count}f}" for x in ALONG_Y)
        return mjcf_chain(
            lambda turn: f'{key}="{" ".join(f"{x:.{count}f}" for x in WRITTEN[key](turn))}"',
            axis,
            rail,
        )

    exact, rounded = (shock_profile(landing(given), given) for given in (robot(17), robot(digits)))
    assert rounded.health.rank == exact.health.rank == 2
    np.testing.assert_allclose(numbers(rounded), numbers(exact), rtol=1e-3, atol=2e-3)


def leg_of_a_free_trunk(angle, turn=(0.0, 0.0, 0.0), digits=17):
    """Two links whose joints turn about y below a trunk that can fall, their frames turned by an
    angle about x, or any way.
    """
    turned = (
        Rotation.from_euler("xyz", turn)
        if any(turn)
        else Rotation.from_euler("x", -90.0, degrees=True)
    )
    rpy = " ".join(f"{angle:.{digits}f}" for angle in turn) if any(turn) else f"{angle} 0 0"
    axis = " ".join(f"{x:.{digits}f}" for x in turned.inv().apply([0.0, 1.0, 0.0]))
    thigh, shin = (
        " ".join(map(repr, turned.inv().apply(v).tolist()))
        for v in ((0.1, 0.0, -0.28), (-0.12, 0.0, -0.27))
    )
    joints = [
        _joint("joint0", "trunk", "a", axis, "0.25 0.1 0", rpy),
        _joint("joint1", "a", "b", axis, thigh, "0 0 0"),
        _joint("ankle", "b", "foot", "1 0 0", shin, "0 0 0", "fixed"),
    ]
    return robot_from(
        urdf(
            link("trunk", mass="3"),
            link("a"),
            link("b"),
            '<link name="foot"/>',
            *joints,
            name="leg",
        )
    )


def on_a_trunk(base, roll, **contact):
    """The landing of that leg on its foot, the trunk rolled [deg]."""
    posture = Posture(joints_deg={"joint0": 24.0, "joint1": -40.0}, base_rpy_deg=(roll, 0.0, 0.0))
    given = {"posture": posture, "strike": Strike(velocity=FALL), "base": base}
    return Scene(robot="leg", contact=Contact(**{"frame": "foot", **contact}), **given)


def test_no_landing_depends_on_the_one_before():
    """Of the same robot at another point of the same link, and with the base in another attitude."""
    hip, elsewhere = (
        landing(chain("-1.5708"), frame="link0"),
        Contact(frame="link0", offset=(0.1, 0.3, 0.0)),
    )
    rail, trunk = chain("-1.5708"), leg_of_a_free_trunk("-1.5708")
    shock_profile(dataclasses.replace(hip, strike=Strike(velocity=(0.0, 0.0, -1.0))), rail)
    shock_profile(on_a_trunk("planar", 0.0), trunk)
    for first, scene, other in (
        (rail, dataclasses.replace(hip, contact=elsewhere), chain("-1.5708")),
        (trunk, on_a_trunk("planar", 2.0), leg_of_a_free_trunk("-1.5708")),
    ):
        after, alone = shock_profile(scene, first), shock_profile(scene, other)
        assert after.health.rank == alone.health.rank
        np.testing.assert_array_equal(numbers(after), numbers(alone))


@pytest.mark.parametrize("digits", [2, 4, 6, 17])
def test_a_contact_that_slides_is_refused_where_only_rounding_moves_it(digits):
    """Its one row is what rounding left, and there is no other to compare it with."""
    robot = leg_of_a_free_trunk(written(digits))
    upright, lying = (on_a_trunk("fixed", roll, directions=("z",)) for roll in (0.0, 90.0))
    assert shock_profile(upright, robot).health.rank == 1
    with pytest.raises(SolveError, match=r"cannot be stopped.*\(0 0 1\)"):
        shock_profile(lying, robot)


@pytest.mark.parametrize("law", [{"contact_stiffness": 1e5}, {"friction": 0.3}])
@pytest.mark.parametrize("digits", [2, 3, 4, 5, 6])
@pytest.mark.parametrize(
    "turn", [(math.pi, math.pi / 2.0, math.pi / 2.0), (math.pi / 4.0, math.pi / 6.0, math.pi / 3.0)]
)
def test_soft_contacts_and_friction_leave_it_out_as_well(turn, digits, law):
    """Of a robot that moves in its plane, as of the exact one."""
    scene = dataclasses.replace(
        on_a_trunk("planar", 0.0),
        posture=Posture(joints_deg={"joint0": 10.0, "joint1": -15.0}),
        **law,
    )
    exact, rounded = (
        shock_profile(scene, leg_of_a_free_trunk("", turn, count)) for count in (17, digits)
    )
    np.testing.assert_allclose(
        rounded.shock_com, exact.shock_com, rtol=5.0 * 10.0**-digits, atol=5.0 * 10.0**-digits
    )


def test_postures_of_one_batch_have_their_own_ranks():
    """Attitudes of a planar base in which the leg moves in the plane, and out of it."""
    robot = leg_of_a_free_trunk("-1.5708")
    posed = resolve(on_a_trunk("planar", 0.0), robot)
    Q = np.stack([resolve(on_a_trunk("planar", roll), robot).q for roll in (0.0, 2.0, 0.0, 30.0)])
    assert shock_maps(posed, Q).rank.tolist() == [2, 3, 2, 3]


def test_many_postures_in_double_precision_move_as_exact_ones():
    """Every posture has the rank of the exact leg, and is flagged for a proof."""
    found = []
    for angle in ("-1.5708", repr(QUARTER)):
        robot = chain(angle)
        posed = resolve(landing(robot), robot)
        Q = np.tile(posed.q, (3, 1))
        Q[:, -1] += [0.0, 0.2, 0.4]
        found.append(shock_maps(posed, Q))
    assert found[0].rank.tolist() == found[1].rank.tolist() == [2, 2, 2]
    np.testing.assert_allclose(found[0].maps, found[1].maps, atol=1e-4)


def test_numbers_too_large_are_the_first_warning():
    """Whatever locks the leg, and the headline does not show them."""
    robot = chain(f"{QUARTER + 2e-3:.6f}")
    profile = shock_profile(landing(robot), robot)
    first = profile.health.warnings[0]
    assert (first.kind, first.value > 100.0) == ("size", True)
    assert dict(landing_report(profile).body(False)[0].lines)["joint"].startswith(
        "largest impulse: not determined"
    )


def test_an_angle_too_large_for_whole_turns_has_a_finite_rounding():
    """1e308 rad are more multiples of 15 degrees than a double can count."""
    robot = mjcf_chain(lambda turn: 'euler="-1e308 .1 0"')
    assert np.all(np.isfinite(rounding_of(robot)))
