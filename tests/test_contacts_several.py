"""Several contacts at once, feet that stand already, and landing while turning."""

import dataclasses
import itertools

import dense
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import body, floating, joint, link, mjcf, refused, urdf
from trees import known_robot, robot_from

from shockpc import (
    Closure,
    Contact,
    Joints,
    LoopEnd,
    Scene,
    SceneError,
    Strike,
    resolve,
    shock_profile,
)

FEET = tuple(Contact(frame=foot) for foot in ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"))
LEFT = FEET[:1]
DIAGONAL = FEET[::3]
V = (0.3, 0.1, -1.0)
LOCKED = Joints(model="locked")


def anymal(contact=DIAGONAL, strike=None, **changes):
    scene = Scene(robot="anymal_b", contact=contact, strike=strike or Strike(velocity=V), **changes)
    return shock_profile(scene, known_robot("anymal_b"))


def after(profile):
    """Velocity of every contact point after the impact (n, 3), world axes."""
    found = []
    for contact, block in zip(profile.contacts, profile.landing.constraints, strict=False):
        found.append(
            contact.approach + dense.velocity(profile, block.body, np.reshape(block.point, 3))
        )
    return np.array(found)


# At once


def test_each_contact_has_its_own_directions_and_restitution():
    """−e of the approach along each direction that is kept, and an impulse along these alone."""
    slanted = np.array([0.6, 0.0, 0.8])
    contacts = (
        Contact(frame="LF_FOOT", restitution=0.4, restitution_along="directions"),
        Contact(frame="RH_FOOT", directions=("z",), restitution=0.1),
        Contact(frame="RF_FOOT", directions=(tuple(slanted),)),
    )
    profile = anymal(contacts)
    left, right, kept = after(profile)
    np.testing.assert_allclose(left, -0.4 * np.array(V), atol=1e-12)
    assert right[2] == pytest.approx(0.1, abs=1e-12)
    assert np.abs(right[:2] - V[:2]).max() > 1e-3
    assert kept @ slanted == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(profile.contacts[1].impulse[:2], 0.0, atol=1e-15)
    np.testing.assert_allclose(np.cross(profile.contacts[2].impulse, slanted), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    "normal", [None, (0.3, -0.2, 1.0), (-1.0, 0.0, 0.0)], ids=["ground", "slope", "wall"]
)
def test_a_sticking_contact_rebounds_along_its_normal_alone(normal):
    """v⁺ = −e (n·v⁻) n, whichever way the directions are given, while another contact has another
    normal.
    """
    n = np.array(normal or (0.0, 0.0, 1.0)) / np.linalg.norm(normal or (0.0, 0.0, 1.0))
    skew = ((1.0, 1.0, 0.0), (0.0, 1.0, 1.0), (1.0, 0.0, 1.5))
    for directions in (("x", "y", "z"), skew):
        hand = Contact(frame="LF_FOOT", restitution=0.4, normal=normal, directions=directions)
        profile = anymal(
            (hand, Contact(frame="RH_FOOT", restitution=0.1)),
            strike=Strike(velocity=(0.7, 0.1, -1.0)),
        )
        left, right = after(profile)
        np.testing.assert_allclose(left, -0.4 * (n @ profile.approach[0]) * n, atol=1e-12)
        np.testing.assert_allclose(right, [0.0, 0.0, 0.1], atol=1e-12)
        along = n @ profile.contacts[0].impulse
        if profile.contacts[0].friction_needed is not None:
            needed = np.linalg.norm(profile.contacts[0].impulse - along * n) / along
            assert profile.contacts[0].friction_needed == pytest.approx(needed, rel=1e-12)
        else:
            assert profile.contacts[0].tensile_impulse == pytest.approx(-along, rel=1e-12)


def test_a_normal_needs_a_length():
    with pytest.raises(SceneError, match='the normal of contact "LF_FOOT" has no length'):
        anymal((Contact(frame="LF_FOOT", normal=(0.0, 0.0, 0.0)),))


def test_a_sole_rebounds_at_each_of_its_points():
    """Its tilt is reversed with the velocity along the normal, its twist is stopped."""
    profile = box(dataclasses.replace(SOLE, restitution=0.5))
    (rise,) = after(profile)
    omega = np.array(TUMBLE.angular_velocity)
    np.testing.assert_allclose(rise, [0.0, 0.0, -0.5 * profile.approach[0, 2]], atol=1e-12)
    np.testing.assert_allclose(
        omega + profile.delta_omega[0], [-0.5 * omega[0], -0.5 * omega[1], 0.0], atol=1e-12
    )


def test_a_contact_with_its_own_velocity():
    """As a robot whose foot has that velocity: the jumps depend on J q̇⁻ alone, and on nothing else
    of the strike.
    """
    velocity = (0.3, 0.2, -2.0)
    foot = Contact(frame="LF_FOOT", velocity=velocity, restitution=0.3)
    found, same = (
        anymal((foot,)),
        anymal((dataclasses.replace(foot, velocity=None),), strike=Strike(velocity=velocity)),
    )
    np.testing.assert_allclose(found.approach, [velocity], atol=0.0)
    np.testing.assert_allclose(found.delta_qd, same.delta_qd, rtol=1e-14)
    assert found.energy_lost == pytest.approx(same.energy_lost, rel=1e-14)
    assert found.energy_share is None
    assert not np.any(found.maps)


# Redundant contacts


BOX = urdf(
    link("box", "3", '<inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0" ixz="0" iyz="0"/>'),
    link("flap"),
    joint("j", "box", "flap"),
    name="box",
)
TUMBLE = Strike(velocity=(0.2, -0.1, -1.0), angular_velocity=(0.5, 1.0, -2.0))
CORNERS = tuple(Contact(frame="box", offset=(x, y, -0.1)) for x in (-0.2, 0.2) for y in (-0.1, 0.1))
SOLE = Contact(frame="box", offset=(0.05, 0.02, -0.1), kind="flat")


def box(*contacts, strike=TUMBLE):
    return shock_profile(
        Scene(robot="box.urdf", contact=contacts, strike=strike, joints=LOCKED), robot_from(BOX)
    )


@pytest.mark.parametrize(
    ("which", "rank"),
    [((0,), 3), ((0, 1), 5), ((0, 1, 2), 6), ((0, 1, 2, 3), 6)],
    ids=["a point", "a line", "three points", "a sole"],
)
def test_the_rank_of_sticking_points_on_a_rigid_body(which, rank):
    """One leaves three rotations, two leave one about their line, three or more leave none;
    impulses are unique at one alone.
    """
    profile = box(*(CORNERS[k] for k in which), strike=Strike(velocity=TUMBLE.velocity))
    assert (profile.health.rank, profile.health.rows) == (rank, 3 * len(which))
    omega = profile.rotation[0] @ profile.delta_omega[0]
    assert np.linalg.matrix_rank(omega[None], 1e-12) == (rank < 6)
    if rank == 5:
        np.testing.assert_allclose(
            np.cross(omega, np.subtract(CORNERS[1].offset, CORNERS[0].offset)), 0.0, atol=1e-12
        )
    assert [contact.impulse is None for contact in profile.contacts] == [rank > 3] * len(which)
    np.testing.assert_allclose(after(profile), 0.0, atol=1e-12)


def test_a_flat_contact_is_its_four_corners():
    """A contact of kind "flat" at any point of the sole stops what four sticking corners stop."""
    flat, four = box(SOLE), box(*CORNERS)
    assert (flat.health.rank, flat.health.rows) == (6, 6)
    np.testing.assert_allclose(flat.delta_v, four.delta_v, atol=1e-12)
    np.testing.assert_allclose(flat.delta_omega, four.delta_omega, atol=1e-12)


def test_the_effective_mass_of_a_flat_contact_is_its_impulse_for_a_unit_strike():
    """A sole that also stops rotation meets more inertia than a point of it: upᵀ Λ up of all its
    rows, from a dense inverse.
    """
    profile = shock_profile(
        Scene(
            robot="talos",
            contact=Contact(frame="left_sole_link", kind="flat"),
            joints=Joints(model="free"),
        )
    )
    (contact,), model, q = profile.contacts, profile.robot.model, profile.q
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    J = pin.getFrameJacobian(
        model, data, model.getFrameId("left_sole_link"), pin.LOCAL_WORLD_ALIGNED
    )
    mass = np.linalg.inv(J @ np.linalg.solve(dense.inertia(model, q), J.T))[2, 2]
    assert contact.effective_mass_sticking == pytest.approx(mass, rel=1e-10)
    assert contact.effective_mass == pytest.approx(float(contact.impulse[2]), rel=1e-12)


def test_a_flat_contact_that_slides_may_twist():
    """Without friction the sole does not tilt, but may rotate about the ground's normal, about
    which it takes no moment.
    """
    profile = box(dataclasses.replace(SOLE, directions=("z",)))
    omega = profile.rotation[0] @ profile.delta_omega[0]
    np.testing.assert_allclose(omega[:2], (-0.5, -1.0), atol=1e-12)
    assert abs(omega[2]) < 1.0
    assert profile.health.rows == 3
    assert profile.contacts[0].moment[2] == 0.0
    assert np.abs(profile.contacts[0].moment[:2]).min() > 1e-3


def test_a_flat_contact_takes_a_moment_of_its_own():
    """About the contact's point: with the impulse it is all that the ground does to a box on one
    sole; a point has none.
    """
    (contact,), (linear, angular) = (profile := box(SOLE)).contacts, dense.momentum(profile)
    np.testing.assert_allclose(contact.impulse, linear, atol=1e-12)
    np.testing.assert_allclose(
        contact.moment, angular - np.cross(contact.point, linear), atol=1e-12
    )
    assert box(CORNERS[0]).contacts[0].moment is None
    # How two soles on one rigid body share their load is not determined.
    twins = box(SOLE, dataclasses.replace(SOLE, offset=(-0.1, 0.0, -0.1)))
    assert [(one.impulse, one.moment) for one in twins.contacts] == [(None, None)] * 2


@pytest.mark.parametrize(
    "changes",
    [
        {"contact": LEFT * 2},
        {"contact": LEFT, "stance": ("LF_FOOT",)},
        {"stance": ("RF_FOOT",) * 2},
    ],
)
def test_a_point_that_is_named_twice_is_refused(changes):
    """As a contact, as a stance or as both."""
    scene = Scene(**({"robot": "anymal_b", "contact": DIAGONAL[1:]} | changes))
    refused(
        SceneError,
        ('"LF_FOOT"' if "contact" in changes else '"RF_FOOT"', "remove one"),
        resolve,
        scene,
        known_robot("anymal_b"),
    )


# Pulling and standing


def pulls(profile):
    """Subject and value of each warning of a foot that the ground would have to pull."""
    return [(one.subject, one.value) for one in profile.health.warnings if one.kind == "contact"]


def test_a_contact_that_would_have_to_pull_is_reported():
    """A long box struck at its end and near its middle: the ground would have to pull the near
    point down.
    """
    contacts = [Contact(frame="box", offset=(x, 0.0, -0.1), directions=("z",)) for x in (0.02, 0.3)]
    profile = box(*contacts, strike=Strike(velocity=TUMBLE.velocity))
    (pulled,) = (contact for contact in profile.contacts if contact.impulse[2] < 0.0)
    assert pulls(profile) == [('contact "box"', pytest.approx(pulled.impulse[2]))]
    assert [contact.friction_needed is None for contact in profile.contacts] == [
        one is pulled for one in profile.contacts
    ]


def test_a_standing_foot_does_not_move():
    """Its velocity after the impact is zero by Pinocchio's kinematics; the landing on the other
    foot is another one.
    """
    standing, alone = anymal(LEFT, stance=("RH_FOOT",)), anymal(LEFT)
    rows = dense.point_rows(standing.robot.model, standing.q, "RH_FOOT")
    np.testing.assert_allclose(rows @ standing.delta_qd, 0.0, atol=1e-12)
    assert np.abs(standing.delta_v - alone.delta_v).max() > 1e-3
    assert (standing.energy_share, alone.stance) == (None, ())
    # It is reported as a contact is: where it stands, its impulse, and the friction it needs.
    (foot,), frame = standing.stance, standing.robot.frame("RH_FOOT")
    assert foot.frame == "RH_FOOT"
    place = standing.position[frame.body] + standing.rotation[frame.body] @ frame.offset
    np.testing.assert_allclose(foot.point, place, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        foot.impulse, dense.momentum(standing)[0] - standing.contacts[0].impulse, atol=1e-11
    )
    assert foot.friction_needed == pytest.approx(
        np.hypot(*foot.impulse[:2]) / foot.impulse[2], rel=1e-12
    )


def test_a_standing_foot_that_would_have_to_pull_is_reported():
    """For every pair of feet that stand: a warning and no needed friction for those that are
    pulled, and for no other.
    """
    reported = set()
    for striking, *standing in itertools.permutations(FEET, 3):
        profile = anymal((striking,), stance=tuple(foot.frame for foot in standing))
        down = [foot for foot in profile.stance if foot.impulse[2] < 0.0]
        assert [foot.friction_needed is None for foot in profile.stance] == [
            foot in down for foot in profile.stance
        ]
        assert pulls(profile) == [
            (f'stance "{foot.frame}"', pytest.approx(foot.impulse[2])) for foot in down
        ]
        reported.add(len(down))
    assert reported == {0, 1}


def test_the_normal_impulse_of_a_foot_may_be_determined_alone():
    """Two feet of a rigid robot repeat one another along their line, but the normal part of each is
    still determined.
    """
    profile = anymal(
        (Contact(frame="LF_FOOT", directions=("z",)),), stance=("RF_FOOT", "LH_FOOT"), joints=LOCKED
    )
    assert (profile.health.rank, profile.health.rows) == (6, 7)
    (right, left), (struck,) = profile.stance, profile.contacts
    assert [(foot.impulse, foot.friction_needed) for foot in profile.stance] == [(None, None)] * 2
    # The moment about one foot gives the impulse at the other, except for its part along their
    # line.
    linear, angular = dense.momentum(profile)
    line = left.point - right.point
    about = (
        angular
        - np.cross(right.point, linear)
        - np.cross(struck.point - right.point, struck.impulse)
    )
    second = np.cross(about, line)[2] / (line @ line)
    first = linear[2] - struck.impulse[2] - second
    assert max(first, second) < -1.0
    assert pulls(profile) == [
        ('stance "RF_FOOT"+stance "LH_FOOT"', pytest.approx(min(first, second)))
    ]


def test_no_impulse_is_needed_across_the_plane_of_a_planar_base():
    """A row along which nothing can move takes no impulse: the impulse and the friction are those
    of a free base.
    """
    free, planar = (
        shock_profile(
            Scene(robot="leg", base=base, contact="heel", strike=Strike(strike_angle_deg=20.0)),
            known_robot("leg"),
        ).contacts[0]
        for base in ("free", "planar")
    )
    np.testing.assert_allclose(planar.impulse, free.impulse, atol=1e-12)
    assert planar.friction_needed == pytest.approx(free.friction_needed)


# Mitigation


def test_mitigation_lies_between_0_and_1_where_it_is_defined():
    """Zero for a rigid robot; the product of the shares along the directions in which joints move
    the contact.
    """
    leg = shock_profile(Scene(robot="leg", contact="heel"), known_robot("leg"))
    H, J = dense.inertia(leg.robot.model, leg.q), dense.point_rows(leg.robot.model, leg.q, "heel")
    A, A_locked = J @ np.linalg.solve(H, J.T), J[:, :6] @ np.linalg.solve(H[:6, :6], J[:, :6].T)
    shares = np.linalg.eigvals(np.eye(3) - np.linalg.solve(A, A_locked)).real
    assert leg.contacts[0].mitigation == pytest.approx(np.prod(shares[shares > 1e-9]), rel=1e-9)
    assert box(CORNERS[0]).contacts[0].mitigation == pytest.approx(0.0, abs=1e-12)
    free = anymal(LEFT)
    # A loop within the robot ties it to nothing.
    feet = [free.robot.frame(foot) for foot in ("LH_FOOT", "RH_FOOT")]
    left, right = (free.position[f.body] + free.rotation[f.body] @ f.offset for f in feet)
    offset = (free.rotation[feet[0].body] @ feet[0].rotation).T @ (right - left)
    inner = Closure(
        a=LoopEnd(frame="LH_FOOT", offset=tuple(map(float, offset))), b=LoopEnd(frame="RH_FOOT")
    )
    for profile in (free, anymal(LEFT, closure=(inner,))):
        assert 0.0 < profile.contacts[0].mitigation < 1.0


@pytest.mark.parametrize(
    ("other", "defined"), [('body2="arm"', True), ("", False)], ids=["to its arm", "to the world"]
)
def test_no_mitigation_for_a_robot_tied_to_the_world(other, defined):
    """A loop to the world holds its base, though the base has a free joint."""
    hips = (
        '<joint name="h1" axis="1 0 0"/><joint name="h2" axis="0 1 0"/><joint name="h3" axis="0 0 '
        '1"/>'
    )
    limbs = body("leg", joints=hips) + body("arm", joints=hips.replace('"h', '"a'))
    tie = f'<equality><connect body1="base" {other} anchor="-0.2 0.1 0.1"/></equality>'
    robot = robot_from(mjcf(floating(limbs), after=tie), ".xml")
    contact = Contact(frame="leg", offset=(0.1, 0.05, -0.3))
    (found,) = shock_profile(Scene(robot="m", contact=(contact,)), robot).contacts
    assert (found.mitigation is not None) == defined


# Landing while turning


def test_only_the_approach_of_the_contact_matters():
    """A somersault and a fall with the same velocity at the foot are one impact (nothing else
    enters Eq. 4).
    """
    turning = anymal(LEFT, Strike(velocity=(0.2, 0.0, -3.0), angular_velocity=(0.0, 4.0, 0.0)))
    falling = anymal(LEFT, Strike(velocity=tuple(map(float, turning.contacts[0].approach))))
    np.testing.assert_allclose(turning.delta_qd, falling.delta_qd, atol=1e-12)
    assert turning.v_in == pytest.approx(falling.v_in)
