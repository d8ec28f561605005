"""Several contacts at once, feet that stand already, and landing while turning."""

import dataclasses
import itertools

import numpy as np
import pinocchio as pin
import pytest
from commands import good
from robot_texts import body, floating, joint, link, mjcf, urdf
from trees import known_robot, robot_from

from shockpc.errors import SceneError
from shockpc.landing import complete, resolve
from shockpc.model.closure import Closure, Place
from shockpc.model.contact import Contact
from shockpc.model.joint_model import Joints
from shockpc.model.motion import velocity_before
from shockpc.model.posture import Posture
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike

FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
DIAGONAL = (Contact(frame="LF_FOOT"), Contact(frame="RH_FOOT"))


def anymal(contact=DIAGONAL, strike=Strike(velocity=(0.3, 0.1, -1.0)), **changes):  # noqa: B008 - frozen
    return shock_profile(Scene(robot="anymal_b", contact=contact, strike=strike, **changes), known_robot("anymal_b"))


def after(profile):
    """Velocity of every contact point after the impact (n, 3), world axes."""
    robot, found = profile.robot, []
    for asked, contact in zip(profile.scene.contact, profile.contacts, strict=True):
        frame = robot.frame(asked.frame)
        r = frame.offset + frame.rotation @ np.asarray(asked.offset)
        i = frame.body
        jump = profile.rotation[i] @ (profile.delta_v[i] + np.cross(profile.delta_omega[i], r))
        found.append(contact.approach + jump)
    return np.array(found)


def momentum(profile):
    """Jump of the linear momentum, and of the angular momentum about the world's origin."""
    linear, angular = np.zeros(3), np.zeros(3)
    for i, one in enumerate(profile.robot.bodies):
        R = profile.rotation[i]
        v = R @ (profile.delta_v[i] + np.cross(profile.delta_omega[i], one.com))
        place = profile.position[i] + R @ one.com
        linear += one.mass * v
        angular += one.mass * np.cross(place, v) + R @ one.inertia @ profile.delta_omega[i]
    return linear, angular


def pinocchios(profile, contacts, qd, e=0.0):
    """Velocity after the impact by Pinocchio's own impulse dynamics, for sticking points (frame, offset)."""
    model = profile.robot.model
    data = model.createData()
    rows = []
    pin.computeJointJacobians(model, data, profile.q)
    for frame, offset in contacts:
        found = profile.robot.frame(frame)
        body = profile.robot.bodies[found.body]
        place = pin.SE3(body.rotation, body.offset) * pin.SE3(found.rotation, found.offset) * pin.SE3(np.eye(3), np.asarray(offset))
        i = model.addFrame(pin.Frame(f"struck {frame} {offset}", body.joint, 0, place, pin.FrameType.OP_FRAME))
        data = model.createData()
        pin.computeJointJacobians(model, data, profile.q)
        pin.updateFramePlacements(model, data)
        rows.append(pin.getFrameJacobian(model, data, i, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)[:3])
    data = model.createData()
    return np.array(pin.impulseDynamics(model, data, profile.q, qd, np.concatenate(rows), e, 0.0))


@pytest.fixture
def unshared():
    """A robot whose model a test may add frames to."""
    from shockpc.robot.robot import load_robot

    return load_robot("anymal_b")


# At once


def test_a_plus_b_lands_on_both(capfd):
    """A+B is one landing: both feet stop."""
    out = good(capfd, "analyze", "anymal_b", "--contact", "LF_FOOT+RH_FOOT", "--format", "markdown")
    assert out.count("## Shock of") == 1
    np.testing.assert_allclose(after(anymal()), 0.0, atol=1e-12)


def test_two_contacts_are_not_two_landings():
    """Landing on two feet is not the sum of landing on each: they load one another through the trunk."""
    geared = Joints(armature={"*": 0.05})
    both = anymal(joints=geared)
    apart = [anymal((contact,), joints=geared) for contact in DIAGONAL]
    assert np.abs(both.delta_v - sum(one.delta_v for one in apart)).max() > 0.02


def test_sticking_and_sliding_mix_with_a_restitution_each():
    """Every row does its own: −e of the approach along what is kept, anything along what slides."""
    contacts = (
        Contact(frame="LF_FOOT", restitution=0.4),
        Contact(frame="RH_FOOT", directions=("z",), restitution=0.1),
        Contact(frame="RF_FOOT", directions=((0.6, 0.0, 0.8),)),
    )
    profile = anymal(contacts)
    left, right, slanted = after(profile)
    v = np.array([0.3, 0.1, -1.0])
    np.testing.assert_allclose(left, -0.4 * v, atol=1e-12)
    assert right[2] == pytest.approx(0.1, abs=1e-12)
    assert np.abs(right[:2] - v[:2]).max() > 1e-3
    assert slanted @ [0.6, 0.0, 0.8] == pytest.approx(0.0, abs=1e-12)
    # What slides is pushed along what it keeps, and nowhere else.
    np.testing.assert_allclose(profile.contacts[1].impulse[:2], 0.0, atol=1e-15)
    np.testing.assert_allclose(np.cross(profile.contacts[2].impulse, [0.6, 0.0, 0.8]), 0.0, atol=1e-12)


def test_several_contacts_are_pinocchios(unshared):
    """Two sticking feet: the whole jump is that of pin.impulseDynamics."""
    scene = Scene(robot="anymal_b", contact=DIAGONAL, strike=Strike(velocity=(0.3, 0.1, -1.0)))
    profile = shock_profile(scene, unshared)
    qd = np.zeros(unshared.model.nv)
    qd[:3] = profile.rotation[0].T @ (0.3, 0.1, -1.0)
    expected = pinocchios(profile, [("LF_FOOT", (0.0, 0.0, 0.0)), ("RH_FOOT", (0.0, 0.0, 0.0))], qd)
    np.testing.assert_allclose(profile.delta_qd, expected - qd, atol=1e-11)


# Redundant contacts


def test_four_feet_of_a_locked_robot_repeat_one_another():
    """Rank 6 of 12: the jump, the total impulse and its moment are unique; each foot's share is not, and that is said."""
    four = tuple(Contact(frame=foot) for foot in FEET)
    profile = anymal(four, joints=Joints(model="locked"))
    assert (profile.health.rank, profile.health.rows) == (6, 12)
    assert all(contact.impulse is None for contact in profile.contacts)
    np.testing.assert_allclose(after(profile), 0.0, atol=1e-12)
    # Stopped dead: the total impulse is the momentum that was there.
    linear, _ = momentum(profile)
    np.testing.assert_allclose(linear, profile.robot.mass * np.array([-0.3, -0.1, 1.0]), rtol=1e-12)
    three = anymal(four[:3], joints=Joints(model="locked"))
    np.testing.assert_allclose(profile.delta_v, three.delta_v, atol=1e-11)
    np.testing.assert_allclose(momentum(profile)[1], momentum(three)[1], atol=1e-10)


@pytest.mark.parametrize("joints", [Joints(), Joints(armature={"*": 0.05})], ids=["free", "geared"])
def test_the_impulses_of_several_feet_are_the_momentum(joints):
    """Linear and angular momentum balance with what the ground does at each foot."""
    profile = anymal(tuple(Contact(frame=foot) for foot in FEET), joints=joints)
    linear, angular = momentum(profile)
    impulses = np.array([contact.impulse for contact in profile.contacts])
    points = np.array([contact.point for contact in profile.contacts])
    np.testing.assert_allclose(impulses.sum(axis=0), linear, atol=1e-10)
    if joints == Joints():
        np.testing.assert_allclose(np.cross(points, impulses).sum(axis=0), angular, atol=1e-10)


BOX = urdf(
    link("box", "3", '<inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0" ixz="0" iyz="0"/>'),
    link("flap"),
    joint("j", "box", "flap"),
    name="box",
)
CORNERS = tuple((x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.1, 0.1))


def box(contacts, **changes):
    given = {
        "robot": "box.urdf",
        "contact": tuple(contacts),
        "strike": Strike(velocity=(0.2, -0.1, -1.0)),
        "joints": Joints(model="locked"),
    }
    return shock_profile(Scene(**(given | changes)), robot_from(BOX))


def corner(k):
    return Contact(frame="box", offset=CORNERS[k])


@pytest.mark.parametrize(
    ("which", "rank"),
    [((0,), 3), ((0, 1), 5), ((0, 1, 2), 6), ((0, 1, 2, 3), 6)],
    ids=["a point", "a line", "three points", "a sole"],
)
def test_a_point_a_line_and_a_flat_foot(which, rank):
    """One sticking point leaves three rotations, two leave one about their line, three or more leave nothing."""
    profile = box(corner(k) for k in which)
    assert (profile.health.rank, profile.health.rows) == (rank, 3 * len(which))
    turn = profile.rotation[0] @ profile.delta_omega[0]
    if rank == 5:
        line = np.subtract(CORNERS[1], CORNERS[0])
        np.testing.assert_allclose(np.cross(turn, line), 0.0, atol=1e-12)
        assert np.linalg.norm(turn) > 0.1
    if rank == 6:
        np.testing.assert_allclose(turn, 0.0, atol=1e-12)


def test_a_flat_contact_is_its_four_corners():
    """A contact of kind "flat" at any point of the sole stops what four sticking corners stop."""
    flat = box(
        [Contact(frame="box", offset=(0.05, 0.02, -0.1), kind="flat")],
        strike=Strike(velocity=(0.2, -0.1, -1.0), angular_velocity=(0.5, 1.0, -2.0)),
    )
    four = box([corner(k) for k in range(4)], strike=Strike(velocity=(0.2, -0.1, -1.0), angular_velocity=(0.5, 1.0, -2.0)))
    assert (flat.health.rank, flat.health.rows) == (6, 6)
    np.testing.assert_allclose(flat.delta_v, four.delta_v, atol=1e-12)
    np.testing.assert_allclose(flat.delta_omega, four.delta_omega, atol=1e-12)


def test_a_flat_contact_that_slides_may_twist():
    """Without friction a sole is kept from tilting, not from turning about the ground's normal."""
    profile = box(
        [Contact(frame="box", offset=(0.0, 0.0, -0.1), kind="flat", directions=("z",))],
        strike=Strike(velocity=(0.2, -0.1, -1.0), angular_velocity=(0.5, 1.0, -2.0)),
    )
    turn = profile.rotation[0] @ profile.delta_omega[0]
    np.testing.assert_allclose(turn[:2], (-0.5, -1.0), atol=1e-12)
    assert abs(turn[2]) < 1.0
    assert profile.health.rows == 3


# Pulling, standing, planar


def test_a_contact_that_would_have_to_pull_is_flagged():
    """A long box on its end and at a point behind its middle: the ground would have to hold the near point down."""
    middle, end = (Contact(frame="box", offset=(x, 0.0, -0.1), directions=("z",)) for x in (0.02, 0.3))
    profile = box([middle, end])
    pulled = [contact.frame for contact in profile.contacts if contact.impulse[2] < 0.0]
    assert len(pulled) == 1
    (warning,) = (text for text in profile.health.warnings if "pulled" in text)
    size = -min(contact.impulse[2] for contact in profile.contacts)
    assert warning == (
        f'contact "box" would have to be pulled down by {size:.3g} N s to keep to the ground; '
        "a real foot lifts off there, so leave it out"
    )
    assert [contact.friction_needed for contact in profile.contacts].count(None) == 1


def test_a_standing_foot_does_not_move():
    """Whatever strikes elsewhere, a foot in stance keeps its place; and it changes what the others do."""
    standing = anymal((Contact(frame="LF_FOOT"),), stance=("RH_FOOT",))
    model, data = standing.robot.model, standing.robot.model.createData()
    pin.forwardKinematics(model, data, standing.q, standing.delta_qd)
    pin.updateFramePlacements(model, data)
    still = pin.getFrameVelocity(model, data, model.getFrameId("RH_FOOT"), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    np.testing.assert_allclose(still.linear, 0.0, atol=1e-12)
    alone = anymal((Contact(frame="LF_FOOT"),))
    assert np.abs(standing.delta_v - alone.delta_v).max() > 1e-3
    assert standing.energy_share is None


def turned(profile):
    """Jump of the angular momentum about the robot's centre of mass."""
    linear, angular = momentum(profile)
    bodies = profile.robot.bodies
    places = [profile.position[i] + profile.rotation[i] @ one.com for i, one in enumerate(bodies)]
    com = np.average(places, axis=0, weights=[one.mass for one in bodies])
    return angular - np.cross(com, linear)


TOTALS = {
    "two feet": {},
    "a foot, and two that stand": {"contact": DIAGONAL[:1], "stance": ("RH_FOOT", "RF_FOOT")},
    "four feet, not unique": {
        "contact": tuple(Contact(frame=foot) for foot in FEET), "joints": Joints(locked=("*",)),
    },
    "two stand, not unique": {
        "contact": (Contact(frame="LF_FOOT", directions=("z",)),),
        "stance": ("RF_FOOT", "LH_FOOT"),
        "joints": Joints(locked=("*",)),
    },
    "a flat foot and a sliding one": {
        "contact": (Contact(frame="LF_FOOT", kind="flat"), Contact(frame="RH_FOOT", directions=("z",))),
        "posture": Posture(base_rpy_deg=(3.0, -8.0, 40.0)),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", TOTALS)
def test_what_the_ground_does_in_all_is_the_momentum(name):
    """Total impulse and its moment about the centre of mass, also where the feet's shares are not determined."""
    strike = Strike(velocity=(0.3, 0.1, -1.0), angular_velocity=(0.2, -0.4, 0.3) if "stance" not in TOTALS[name] else None)
    profile = anymal(strike=strike, **TOTALS[name])
    np.testing.assert_allclose(profile.total_impulse, momentum(profile)[0], atol=1e-10)
    np.testing.assert_allclose(profile.total_moment, turned(profile), atol=1e-10)
    found = [*profile.contacts, *profile.stance]
    unknown = {"four feet, not unique": [True] * 4, "two stand, not unique": [False, True, True]}.get(name, [False] * len(found))
    assert [one.impulse is None for one in found] == unknown
    if not any(unknown):
        np.testing.assert_allclose(sum(one.impulse for one in found), profile.total_impulse, atol=1e-10)


def test_a_flat_contact_carries_a_moment_of_its_own():
    """About the contact's point: with the impulse it is all that the ground does to a box on one sole; a point has none."""
    flat = Contact(frame="box", offset=(0.05, 0.02, -0.1), kind="flat")
    strike = Strike(velocity=(0.2, -0.1, -1.0), angular_velocity=(0.5, 1.0, -2.0))
    profile = box([flat], strike=strike)
    (contact,) = profile.contacts
    linear, angular = momentum(profile)
    np.testing.assert_allclose(contact.impulse, linear, atol=1e-12)
    np.testing.assert_allclose(contact.moment, angular - np.cross(contact.point, linear), atol=1e-12)
    assert box([corner(0)]).contacts[0].moment is None
    # What slides may twist: no moment about the ground's normal.
    sliding = box([dataclasses.replace(flat, directions=("z",))], strike=strike).contacts[0]
    assert sliding.moment[2] == 0.0
    assert np.abs(sliding.moment[:2]).min() > 1e-3
    # Two soles on one rigid body share their load in no way that is known.
    twins = box([flat, dataclasses.replace(flat, offset=(-0.1, 0.0, -0.1))], strike=strike)
    assert [(one.impulse, one.moment) for one in twins.contacts] == [(None, None)] * 2


def test_a_standing_foot_is_reported_as_a_contact_is():
    """Where it stands, its impulse, and the friction it needs: the numbers of a contact that stays at rest."""
    standing = anymal((Contact(frame="LF_FOOT"),), stance=("RH_FOOT",))
    (foot,) = standing.stance
    assert foot.frame == "RH_FOOT"
    frame = standing.robot.frame("RH_FOOT")
    np.testing.assert_array_equal(foot.point, standing.position[frame.body] + standing.rotation[frame.body] @ frame.offset)
    struck = standing.contacts[0].impulse
    np.testing.assert_allclose(foot.impulse, momentum(standing)[0] - struck, atol=1e-11)
    assert foot.friction_needed == pytest.approx(np.hypot(*foot.impulse[:2]) / foot.impulse[2], rel=1e-12)
    assert anymal().stance == ()


def dragged(name, impulse):
    """The warning of a foot that stands and would leave the ground."""
    return (
        f'stance "{name}" would have to be pulled down by {-impulse:.3g} N s to keep to the ground; '
        "a real foot lifts off there, so leave it out"
    )


def test_a_standing_foot_that_would_have_to_pull_is_flagged():
    """Of all pairs of feet that stand, those are named that the ground would have to hold down, and no other."""
    flagged = []
    for feet in itertools.permutations(FEET, 3):
        profile = anymal((Contact(frame=feet[0]),), stance=feet[1:])
        down = [foot for foot in profile.stance if foot.impulse[2] < 0.0]
        assert [foot.friction_needed is None for foot in profile.stance] == [foot in down for foot in profile.stance]
        assert profile.health.warnings == tuple(dragged(foot.frame, foot.impulse[2]) for foot in down)
        flagged.append(len(down))
    assert set(flagged) == {0, 1}


def test_a_standing_foot_is_flagged_by_its_normal_alone():
    """Two feet of a rigid robot repeat one another along their line, but what each is pulled down by is still determined."""
    one = Contact(frame="LF_FOOT", directions=("z",))
    profile = anymal((one,), stance=("RF_FOOT", "LH_FOOT"), joints=Joints(model="locked"))
    assert (profile.health.rank, profile.health.rows) == (6, 7)
    right, left = profile.stance
    assert [(foot.impulse, foot.friction_needed) for foot in profile.stance] == [(None, None)] * 2
    # Moments about one of them leave what the other carries, but for its part along the line.
    linear, angular = momentum(profile)
    (struck,) = profile.contacts
    line = left.point - right.point
    about = angular - np.cross(right.point, linear) - np.cross(struck.point - right.point, struck.impulse)
    second = np.cross(about, line)[2] / (line @ line)
    first = linear[2] - struck.impulse[2] - second
    assert (first < -1.0, second < -1.0) == (True, True)
    assert profile.health.warnings == (dragged("RF_FOOT", first), dragged("LH_FOOT", second))


def test_what_is_fixed_to_the_world_stands_anyway():
    stand = '<body name="stand" pos="0 0 1">' + body("arm") + "</body>"
    robot = robot_from(mjcf(stand), ".xml")
    scene = Scene(robot="m", contact=(Contact(frame="arm", offset=(0.1, 0.0, -0.2)),), stance=("stand",))
    with pytest.raises(SceneError) as refusal:
        shock_profile(scene, robot)
    assert str(refusal.value) == 'stance "stand" is fixed to the world, so it stands anyway; name a frame on a moving link'


def test_across_the_plane_of_a_planar_base_no_impulse_is_needed():
    """What cannot move and did not move is no unknown: the impulse in the plane is unique, and the friction is told."""
    strike = Strike(strike_angle_deg=20.0)
    free, planar = (
        shock_profile(Scene(robot="leg", base=base, contact=(Contact(frame="heel"),), strike=strike), known_robot("leg"))
        for base in ("free", "planar")
    )
    np.testing.assert_allclose(planar.contacts[0].impulse, free.contacts[0].impulse, atol=1e-12)
    assert planar.contacts[0].friction_needed == pytest.approx(free.contacts[0].friction_needed)


def test_no_mitigation_where_the_joints_can_do_nothing():
    """Across the plane of a planar mechanism the factor would be zero whatever its joints are."""
    leg = shock_profile(Scene(robot="leg", contact=(Contact(frame="heel"),)), known_robot("leg"))
    assert [contact.mitigation for contact in leg.contacts] == [None]
    # A robot all of whose joints are locked, or that has none, mitigates nothing, and that is a number.
    assert box([corner(0)]).contacts[0].mitigation == pytest.approx(0.0, abs=1e-12)
    loose = anymal((Contact(frame="LF_FOOT"),))
    assert 0.0 < loose.contacts[0].mitigation < 1.0
    state = {"robot": "anymal_b", "contact": (Contact(frame="LF_FOOT"),), "strike": Strike(velocity=(0.3, 0.1, -1.0))}
    # A loop within the robot ties it to nothing.
    feet = [known_robot("anymal_b").frame(foot) for foot in ("LH_FOOT", "RH_FOOT")]
    left, right = (loose.position[f.body] + loose.rotation[f.body] @ f.offset for f in feet)
    body = loose.rotation[feet[0].body] @ feet[0].rotation
    inner = Closure(a=Place(frame="LH_FOOT", offset=tuple(map(float, body.T @ (right - left)))), b=Place(frame="RH_FOOT"))
    within = shock_profile(Scene(**state, closure=(inner,)), known_robot("anymal_b"))
    assert 0.0 < within.contacts[0].mitigation < 1.0


@pytest.mark.parametrize(("other", "told"), [('body2="arm"', True), ("", False)], ids=["to its own arm", "to the world"])
def test_no_mitigation_on_a_robot_tied_to_the_world(other, told):
    """Its base is free in name only."""
    hips = '<joint name="h1" axis="1 0 0"/><joint name="h2" axis="0 1 0"/><joint name="h3" axis="0 0 1"/>'
    limbs = body("leg", joints=hips) + body("arm", joints=hips.replace('"h', '"a'))
    tie = f'<equality><connect body1="base" {other} anchor="-0.2 0.1 0.1"/></equality>'
    robot = robot_from(mjcf(floating(limbs), after=tie), ".xml")
    contact = Contact(frame="leg", offset=(0.1, 0.05, -0.3))
    (found,) = shock_profile(Scene(robot="m", contact=(contact,)), robot).contacts
    assert (found.mitigation is not None) == told


def test_two_contacts_at_one_point_are_refused():
    with pytest.raises(SceneError) as refusal:
        anymal((Contact(frame="LF_FOOT"), Contact(frame="LF_FOOT")))
    assert str(refusal.value) == (
        'contacts "LF_FOOT" and "LF_FOOT" are at one point of one body, so they are one contact; '
        "leave one of them out, or move it by an offset"
    )


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        (
            Contact(frame="LF_FOOT", directions=((0.0, 0.0, 0.0),)),
            'contact "LF_FOOT" has a direction without a length; valid are "x", "y", "z" and vectors',
        ),
        (
            Contact(frame="LF_FOOT", directions=("x", "y")),
            'contact "LF_FOOT" keeps only directions along the ground, so nothing stops its fall; '
            "add the ground's normal (0, 0, 1) to its directions",
        ),
        (
            Contact(frame="LF_FOOT", restitution=1.5),
            'contact "LF_FOOT" has restitution 1.5; it lies between 0 (stays down) and 1 (bounces fully)',
        ),
    ],
    ids=["no length", "along the ground", "restitution"],
)
def test_a_contact_that_makes_no_sense_is_refused(contact, message):
    with pytest.raises(SceneError) as refusal:
        anymal((contact,))
    assert str(refusal.value) == message


# Landing while turning


MOTIONS = {
    "a somersault": Strike(velocity=(0.2, 0.0, -3.0), angular_velocity=(0.0, 4.0, 0.0)),
    "a tumble": Strike(velocity=(0.2, -0.3, -3.0), angular_velocity=(1.0, -2.0, 0.5)),
    "a swinging leg": Strike(velocity=(0.2, 0.0, -1.0), joint_velocities={"LF_HFE": 3.0, "LF_KFE": -4.0}),
    "everything": Strike(
        velocity=(0.2, 0.1, -3.0), angular_velocity=(1.0, -2.0, 0.5), joint_velocities={"*_KFE": 2.0, "LF_HAA": -1.0}
    ),
}


def rates(profile, strike):
    """The motion before the impact as Pinocchio's velocity."""
    model = profile.robot.model
    qd = np.zeros(model.nv)
    qd[:3] = profile.rotation[0].T @ strike.velocity
    qd[3:6] = profile.rotation[0].T @ (strike.angular_velocity or (0.0, 0.0, 0.0))
    for pattern, rate in strike.joint_velocities.items():
        for name in profile.robot.match_joints(pattern):
            qd[model.joints[model.getJointId(name)].idx_v] = rate
    return qd


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("e", [0.0, 0.3])
def test_landing_while_turning_is_pinocchios(name, e, unshared):
    """Each contact's approach follows from the whole motion, and the jump is that of pin.impulseDynamics."""
    strike = MOTIONS[name]
    contacts = tuple(dataclasses.replace(contact, restitution=e) for contact in DIAGONAL)
    profile = shock_profile(Scene(robot="anymal_b", contact=contacts, strike=strike), unshared)
    qd = rates(profile, strike)
    expected = pinocchios(profile, [("LF_FOOT", (0.0, 0.0, 0.0)), ("RH_FOOT", (0.0, 0.0, 0.0))], qd, e)
    np.testing.assert_allclose(profile.delta_qd, expected - qd, atol=1e-11 * np.abs(qd).max())
    np.testing.assert_allclose(after(profile), -e * np.array([c.approach for c in profile.contacts]), atol=1e-11)


@pytest.mark.parametrize("name", MOTIONS)
def test_every_point_approaches_as_the_motion_says(name):
    """Its velocity is v_base + ω × r + J_joints q̇, point by point."""
    scene = Scene(robot="anymal_b", contact=DIAGONAL, strike=MOTIONS[name])
    robot = known_robot("anymal_b")
    landing = resolve(complete(scene, robot), robot)
    profile = shock_profile(scene, robot)
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, landing.q, rates(profile, MOTIONS[name]))
    pin.updateFramePlacements(model, data)
    for touch in landing.touches:
        there = pin.getFrameVelocity(model, data, model.getFrameId(touch.frame), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        found = velocity_before(landing.state, landing.before, touch.body, touch.point)[0]
        np.testing.assert_allclose(found, there.linear, atol=1e-13 * 10)


def test_only_the_approach_of_the_contact_matters():
    """A somersault and a fall with the same velocity at the foot are one impact (nothing else enters Eq. 4)."""
    turning = anymal((Contact(frame="LF_FOOT"),), MOTIONS["a somersault"])
    falling = anymal((Contact(frame="LF_FOOT"),), Strike(velocity=tuple(map(float, turning.contacts[0].approach))))
    np.testing.assert_allclose(turning.delta_qd, falling.delta_qd, atol=1e-12)
    assert turning.v_in == pytest.approx(falling.v_in)


def test_a_locked_joint_cannot_swing():
    with pytest.raises(SceneError) as refusal:
        anymal(strike=MOTIONS["a swinging leg"], joints=Joints(locked=("LF_KFE",)))
    assert (
        str(refusal.value) == 'joint "LF_KFE" is locked, so it cannot move at -4 rad/s before the impact; free it or leave it out'
    )


def test_a_foot_that_swings_up_does_not_strike():
    with pytest.raises(
        SceneError, match=r'^contact "LF_FOOT" is leaving the ground at .* m/s, so there is no impact; turn its velocity'
    ):
        anymal((Contact(frame="LF_FOOT"),), Strike(velocity=(0.0, 0.0, -0.1), joint_velocities={"LF_KFE": -30.0, "LF_HFE": 20.0}))
