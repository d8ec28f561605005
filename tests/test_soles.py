"""What of a foot carries: soles whose corners push or leave the ground, against an independent
solution.
"""

import numpy as np
import pinocchio as pin
import pytest
from commands import good
from scipy.optimize import nnls
from standing import quadruped, soles

from shockpc import Scene, shock_profile
from shockpc.core.corners import corner_impulse, nonnegative_least_squares
from shockpc.landing.contact import contact_constraint
from shockpc.landing.feet import faces
from shockpc.landing.feet.auto_contact import with_own_faces
from shockpc.landing.feet.level_feet import default_landings
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Posture
from shockpc.landing.scenes.strike import Strike
from shockpc.robot.load import load_robot
from shockpc.text.errors import SolveError

SOLE = np.array([(x, y, -0.09) for x in (-0.08, 0.14) for y in (-0.045, 0.045)])
"""Corners of the soles of the biped of `standing.soles`, in the frame of the foot [m]."""


@pytest.fixture(scope="module")
def biped(tmp_path_factory):
    """A biped whose feet are boxes on ankles that pitch and roll."""
    return load_robot(soles(tmp_path_factory.mktemp("robots"), "biped"))


def unilateral(robot, q, corners, velocity, locked=(), restitution=0.0, stops=None):
    """The jump (nv,) of a robot that lands on corners which push or leave the ground, from
    Pinocchio's inertia and Jacobians.

    Each foot sticks along the ground and does not twist about the vertical. Those rows are
    eliminated, and SciPy finds the pushes.

    Args:
        robot: the robot.
        q: (nq,) its posture.
        corners: (n, 3) of each foot by the name of its frame, in the frame [m].
        velocity: (3,) before the impact [m/s].
        locked: joints that hold.
        restitution: along the normal.
        stops: joints at their end stops, which push only, with the sign of the rate away from them.
    """
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    H = pin.crba(model, data, q)
    H = np.triu(H) + np.triu(H, 1).T
    before = np.zeros(model.nv)
    before[:3] = data.oMf[model.getFrameId(robot.links[0])].rotation.T @ velocity
    held, rising = [], []
    for name, points in corners.items():
        frame = model.getFrameId(name, pin.FrameType.BODY)
        place = data.oMf[frame]
        J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        at = [J[:3] - pin.skew(place.rotation @ point) @ J[3:] for point in points]
        held += [at[0][0], at[0][1], J[5]]
        rising += [rows[2] for rows in at]
    for name, side in (stops or {}).items():
        rising.append(side * np.eye(model.nv)[model.joints[model.getJointId(name)].idx_v])
    free = [
        k
        for k in range(model.nv)
        if not any(model.joints[model.getJointId(name)].idx_v == k for name in locked)
    ]
    F, C = np.array(held)[:, free], np.array(rising)[:, free]
    L = np.linalg.cholesky(H[np.ix_(free, free)])
    # In the metric of the kinetic energy the jump is x = F̃ᵀ f + C̃ᵀ y.
    F, C = np.linalg.solve(L, F.T), np.linalg.solve(L, C.T)
    start = L.T @ before[free]
    stopped = np.linalg.lstsq(F.T, -(F.T @ start), rcond=1e-12)[0]
    # Rows of a foot and of its toe depend on one another.
    directions, sizes, _ = np.linalg.svd(F, full_matrices=False)
    Q = directions[:, sizes > 1e-12 * sizes[0]]
    across = C - Q @ (Q.T @ C)
    missing = (1.0 + restitution) * (C.T @ start) - C.T @ start + C.T @ (start + stopped)
    # y minimizes ½ yᵀ (across' across) y + missing · y; a vector with those products with the
    # columns stands for it.
    target = np.linalg.lstsq(across.T, -missing, rcond=1e-12)[0]
    y, _ = nnls(across, target)
    u = across.T @ across @ y + missing
    size = np.abs(missing).max()
    assert y.min() >= 0.0
    assert u.min() >= -1e-9 * size
    assert abs(y @ u) <= 1e-9 * size * max(y.max(), 1.0)
    jump = np.zeros(model.nv)
    jump[free] = np.linalg.solve(L.T, stopped + across @ y)
    return jump


def landed(robot, feet, **scene):
    """The profile of a landing on some feet."""
    return shock_profile(
        Scene(robot=robot.label, contact=tuple(Contact(frame=foot) for foot in feet), **scene),
        robot,
    )


ROLLS = ("left_ankle_roll", "right_ankle_roll")
PITCH = "left_ankle_pitch"
LEGS = tuple(
    f"{side}_{joint}" for side in ("left", "right") for joint in ("hip_roll", "hip_pitch", "knee")
)
LANDINGS = {
    "flat": (("left_foot",), (), (0.0, 0.0, -1.0), ("flat",)),
    "both flat": (("left_foot", "right_foot"), (), (0.0, 0.0, -1.0), ("flat", "flat")),
    "edge": (("left_foot",), ROLLS, (0.0, 0.0, -1.0), ("edge",)),
    "both with locked rolls": (
        ("left_foot", "right_foot"),
        ROLLS,
        (0.0, 0.0, -1.0),
        ("flat", "flat"),
    ),
    "corner": (("left_foot",), (*ROLLS, PITCH, "left_knee"), (0.8, 0.0, -1.0), ("corner",)),
    "oblique": (("left_foot", "right_foot"), ROLLS, (0.5, 0.4, -1.0), None),
}


@pytest.mark.parametrize("case", LANDINGS)
def test_the_face_that_carries_has_the_jump_of_corners_that_push_or_leave_the_ground(biped, case):
    feet, locked, velocity, kinds = LANDINGS[case]
    profile = landed(biped, feet, joints=Joints(locked=locked), strike=Strike(velocity=velocity))
    expected = unilateral(biped, profile.q, dict.fromkeys(feet, SOLE), np.array(velocity), locked)
    np.testing.assert_allclose(
        profile.delta_qd, expected, rtol=0, atol=1e-8 * np.abs(expected).max()
    )
    if kinds is not None:
        assert tuple(contact.kind for contact in profile.scene.contact) == kinds


def test_soles_rebound_along_their_normals(biped):
    """With restitution each point of the sole has its speed reversed, and corners push or leave
    faster than that.
    """
    contact = Contact(frame="left_foot", restitution=0.5)
    profile = shock_profile(
        Scene(robot=biped.label, contact=contact, joints=Joints(locked=ROLLS)), biped
    )
    expected = unilateral(
        biped, profile.q, {"left_foot": SOLE}, np.array([0.0, 0.0, -1.0]), ROLLS, restitution=0.5
    )
    assert profile.scene.contact[0].kind == "edge"
    np.testing.assert_allclose(
        profile.delta_qd, expected, rtol=0, atol=1e-8 * np.abs(expected).max()
    )


def test_all_soles_are_flat_exactly_where_each_centre_of_pressure_is_inside(biped):
    """As flat contacts the feet have centres of pressure; all lie within their soles, or the
    landing is not flat.
    """
    rng, flat = np.random.default_rng(11), 0
    names = [joint.name for joint in biped.single_joints[1:]]
    for _ in range(30):
        locked = tuple(name for name in names if rng.random() < 0.4)
        scene = {
            "joints": Joints(locked=locked),
            "strike": Strike(velocity=(*rng.uniform(-0.6, 0.6, 2).tolist(), -1.0)),
        }
        feet = ("left_foot", "right_foot")
        kinds = [contact.kind for contact in landed(biped, feet, **scene).scene.contact]
        given = tuple(Contact(frame=foot, at="lowest", kind="flat") for foot in feet)
        profile = shock_profile(Scene(robot=biped.label, contact=given, **scene), biped)
        if profile.redundant:
            continue  # how two soles on one rigid body share the impulse is not determined
        inside = []
        for contact, block in zip(profile.contacts, profile.landing.contacts, strict=True):
            R, p = (
                profile.landing.state.rotation[0, block.body],
                profile.landing.state.position[0, block.body],
            )
            x, y, _ = (
                R.T @ (contact.centre_of_pressure - p)
                if contact.centre_of_pressure is not None
                else (np.inf,) * 3
            )
            inside.append(-0.08 <= x <= 0.14 and abs(y) <= 0.045)
        assert (kinds == ["flat", "flat"]) == all(inside)
        flat += all(inside)
    assert 0 < flat < 30


def test_a_foot_that_the_others_lift_is_left_out_with_a_warning(biped):
    velocity = (0.0, 2.0, -1.0)
    profile = landed(
        biped,
        ("left_foot", "right_foot"),
        joints=Joints(locked=LEGS),
        strike=Strike(velocity=velocity),
    )
    assert [contact.frame for contact in profile.scene.contact] == ["left_foot"]
    assert any("right_foot is lifted" in str(warning) for warning in profile.landing.warnings)
    assert profile.landing.asked[1].frame == "right_foot"
    alone = unilateral(biped, profile.q, {"left_foot": SOLE}, np.array(velocity), LEGS)
    np.testing.assert_allclose(profile.delta_qd, alone, rtol=0, atol=1e-8 * np.abs(alone).max())


@pytest.mark.parametrize("endless", [1, 3])
def test_corners_that_are_not_found_are_refused_whenever_they_are_sought(
    biped, endless, monkeypatch
):
    """At first, and for the speed at which a lifted foot enters the ground without an impulse."""
    calls = iter(range(1, endless + 1))

    def ends_no_search(*given):
        if next(calls) == endless:
            raise ArithmeticError("the search for the corners that push does not end")
        return corner_impulse(*given)

    monkeypatch.setattr(faces, "corner_impulse", ends_no_search)
    with pytest.raises(SolveError, match=r"does not end; say what of the sole carries"):
        landed(
            biped,
            ("left_foot", "right_foot"),
            joints=Joints(locked=LEGS),
            strike=Strike(velocity=(0.0, 2.0, -1.0)),
        )


def test_a_warning_says_that_a_foot_which_is_left_out_enters_the_ground(biped):
    """Friction without a push lifts it; without that friction it falls on."""
    velocity = np.array([0.0, 2.0, -1.0])
    profile = landed(
        biped,
        ("left_foot", "right_foot"),
        joints=Joints(locked=LEGS),
        strike=Strike(velocity=tuple(velocity)),
    )
    model, data = biped.model, biped.model.createData()
    pin.computeJointJacobians(model, data, profile.q)
    pin.updateFramePlacements(model, data)
    frame = model.getFrameId("right_foot", pin.FrameType.BODY)
    rotation, J = (
        data.oMf[frame].rotation,
        pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED),
    )
    jumps = [(J[:3] - pin.skew(rotation @ corner) @ J[3:]) @ profile.delta_qd for corner in SOLE]
    lowest = min(velocity[2] + float(jump.reshape(-1)[2]) for jump in jumps)
    assert lowest < -0.1
    share = f"enters the ground at {-lowest / np.abs(velocity).max():.0%} of the contact velocity"
    assert any(share in str(warning) for warning in profile.landing.warnings)


def test_each_joint_model_has_its_own_faces(biped):
    """With free joints the column free, with locked ones the column locked of any landing, whatever
    carries in it.
    """
    profile, free, locked = (
        landed(biped, ("left_foot",), joints=joints)
        for joints in (
            Joints(locked=ROLLS),
            Joints(model="free"),
            Joints(model="locked"),
        )
    )
    assert [one.scene.contact[0].kind for one in (profile, free, locked)] == [
        "edge",
        "flat",
        "edge",
    ]
    (row,) = (row for row in profile.bracket if "imu" in row.place)
    shocks = [float(one.value("shock", "point")[0]) for one in (free, locked)]
    np.testing.assert_allclose([row.free, row.locked], shocks, rtol=1e-12)
    again = with_own_faces(profile.landing)
    assert again.scene.contact == profile.scene.contact


def test_a_saved_scene_has_the_edge_that_carries(biped):
    profile = landed(biped, ("left_foot",), joints=Joints(locked=ROLLS))
    again = shock_profile(profile.scene, biped)
    assert again.scene.contact == profile.scene.contact
    np.testing.assert_array_equal(again.delta_qd, profile.delta_qd)


def test_the_centre_of_pressure_of_an_edge_is_on_it_and_its_twist_needs_friction(biped):
    profile = landed(biped, ("left_foot",), joints=Joints(locked=ROLLS))
    (contact,), (block,) = profile.contacts, profile.landing.contacts
    R, p = (
        profile.landing.state.rotation[0, block.body],
        profile.landing.state.position[0, block.body],
    )
    x, y, z = R.T @ (contact.centre_of_pressure - p)
    assert -0.08 <= x <= 0.14
    np.testing.assert_allclose([abs(y), z], [0.045, -0.09], atol=1e-12)
    arm = np.linalg.norm(R.T @ (contact.centre_of_pressure - p) - SOLE, axis=1).mean()
    assert contact.twist_needed == pytest.approx(
        abs(contact.moment[2]) / (contact.impulse[2] * arm), rel=1e-9
    )


def test_a_point_of_a_sole_needs_no_friction_against_twist():
    """A point has no moment, whether or not its foot has a sole."""
    scene = Scene(
        robot="panda", base="fixed", contact=(Contact(frame="panda_leftfinger", at="frame"),)
    )
    profile = shock_profile(scene)
    (contact,), (block,) = profile.contacts, profile.landing.contacts
    assert len(block.sole)
    assert not len(block.moments)
    assert contact.twist_needed is None
    np.testing.assert_allclose(contact.centre_of_pressure, contact.point, atol=1e-12)


def test_permuted_and_doubled_corners_leave_the_ground_at_the_same_speeds():
    """The pushes are not unique with four corners; the speeds and the impulse along the rows are."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        X, free, b = rng.normal(size=(12, 6)), np.eye(6)[:, :3], rng.normal(size=6)
        places = rng.uniform(-0.1, 0.1, size=(4, 2))
        corners = np.zeros((6, 4))
        corners[3], corners[4:] = 1.0, places.T
        order = rng.integers(0, 4, size=9)
        order[:4] = rng.permutation(4)
        once, again = (
            corner_impulse(X, b, free, corners),
            corner_impulse(X, b, free, corners[:, order]),
        )
        np.testing.assert_allclose(again.speed, once.speed[order], atol=1e-10)
        np.testing.assert_allclose(again.impulse, once.impulse, atol=1e-10)
        assert min(once.push.min(), once.speed.min()) >= -1e-12
        assert once.push @ once.speed == pytest.approx(0.0, abs=1e-12)


def test_least_squares_without_negative_unknowns_agree_with_scipy():
    rng = np.random.default_rng(3)
    for _ in range(50):
        B, d = rng.normal(size=(8, 6)), rng.normal(size=8)
        B /= np.linalg.norm(B, axis=0)
        np.testing.assert_allclose(nonnegative_least_squares(B, d), nnls(B, d)[0], atol=1e-12)


# The feet of robots of other hands: several geoms, sites or links make a foot


def biped_text(foot: str, roll: bool) -> str:
    """A biped in MJCF whose hips, knees and ankles pitch.

    Args: foot, its parts, with {side}; roll, whether the ankles roll too.
    """
    legs = []
    for side, y in (("left", 0.1), ("right", -0.1)):
        inertia = "0.00054 0.0018 0.00198" if roll else "0.0006 0.0018 0.00198"
        parts = (
            f'<inertial pos=".02 0 -.03" mass=".6" '
            f'diaginertia="{inertia}"/>{foot.format(side=side)}'
        )
        if roll:
            cross = '<inertial pos="0 0 0" mass=".1" diaginertia="1e-4 1e-4 1e-4"/>'
            parts = (
                f'{cross}<body name="{side}_ankle_roll"><joint name="{side}_roll" axis="1 0 0" '
                f'range="-.5 .5"/>{parts}</body>'
            )
        legs.append(
            f'<body name="{side}_thigh" pos="0 {y} 0"><joint name="{side}_hip" axis="0 1 0" '
            f'range="-1.6 1.6"/>'
            '<inertial pos="0 0 -.15" mass="4" diaginertia=".04 .04 .008"/>'
            f'<body name="{side}_shank" pos="0 0 -.3"><joint name="{side}_knee" axis="0 1 0" '
            f'range="0 2.3"/>'
            '<inertial pos="0 0 -.15" mass="2" diaginertia=".02 .02 .004"/>'
            f'<body name="{side}_ankle{"_cross" * roll}" pos="0 0 -.3"><joint name="{side}_ankle" '
            f'axis="0 1 0" range="-1.2 .6"/>'
            f"{parts}</body></body></body>"
        )
    trunk = (
        '<freejoint/><inertial pos="0 0 .2" mass="20" diaginertia=".8 .7 .3"/><site name="imu" '
        'pos="0 0 .1"/>'
    )
    body = f'<body name="trunk" pos="0 0 .7">{trunk}{"".join(legs)}</body>'
    return (
        f'<mujoco><compiler angle="radian" '
        f'autolimits="true"/><worldbody>{body}</worldbody></mujoco>'
    )


def balls(form: str, radius: float = 0.005, higher: float = 0.0) -> str:
    """Four balls under a foot, each as a form says, the first one higher."""
    places = [
        (x, y, -0.045 + higher * (x < 0.0 < y)) for x in (-0.05, 0.12) for y in (0.025, -0.025)
    ]
    geoms = [f'type="sphere" size="{radius}"', *(f'pos="{x} {y} {z}"' for x, y, z in places)]
    return "".join(
        form.format(shape=geoms[0], place=place, k=k, side="{side}")
        for k, place in enumerate(geoms[1:])
    )


GEOMS, WELDED = (
    '<geom name="{side}_foot{k}" {shape} {place}/>',
    '<body name="{side}_foot{k}" {place}><geom {shape}/></body>',
)
BOX = '<geom type="box" size=".1 .05 .01" pos=".03 0 -.04"/>'
SITES = "".join(
    f'<site name="{{side}}_foot{k}" pos="{x} {y} -.05"/>'
    for k, (x, y) in enumerate([(-0.07, 0.05), (0.13, 0.05)])
)
CAPSULES = "".join(
    f'<geom name="{{side}}_toe{k}" type="capsule" fromto="-.07 {y} -.04 .13 {y} -.04" size=".01"/>'
    for k, y in enumerate((0.03, -0.03))
)
# Shock at the IMU, or the trunk's centre of mass without a roll, on both feet and on one:
# unilateral corners, on another's H and J.
FEET = {
    "named balls": (balls(GEOMS), True, "left_ankle_roll", 0.3456, 0.2021, "flat"),
    "unnamed balls": (
        balls("<geom {shape} {place}/>"),
        True,
        "left_ankle_roll",
        0.3456,
        0.2021,
        "flat",
    ),
    "balls on welded bodies": (balls(WELDED), True, "left_ankle_roll", 0.3456, 0.2021, "flat"),
    "capsules": (CAPSULES, True, "left_ankle_roll", 0.3456, 0.2021, "flat"),
    "sites on a box": (BOX + SITES, True, "left_ankle_roll", 0.3456, 0.2021, "flat"),
    "sites without geometry": (
        balls('<site name="{side}_foot{k}" {place}/>'),
        True,
        "left_ankle_roll",
        0.3456,
        0.2021,
        "flat",
    ),
    "box without roll": (BOX, False, "left_ankle", 0.3105, 0.1811, "edge"),
    "balls without roll": (balls(GEOMS), False, "left_ankle", 0.3105, 0.1816, "edge"),
    "one ball little higher": (
        balls(GEOMS, higher=0.004),
        False,
        "left_ankle",
        0.3105,
        0.1816,
        "edge",
    ),
}


@pytest.fixture(scope="module")
def of_text(tmp_path_factory):
    """A function that loads a robot from its text."""
    folder = tmp_path_factory.mktemp("texts")

    def load(text: str, name: str = "robot.xml"):
        (folder / name).write_text(text)
        return load_robot(folder / name)

    return load


def trunk_shock(profile) -> float:
    """The shock at the IMU of a biped whose ankles roll, else at the centre of mass of its trunk."""
    at_com = len(profile.robot.bodies) == 7
    return float(
        profile.value("shock_com", "body")[0] if at_com else profile.value("shock", "point")[0]
    )


@pytest.mark.parametrize("case", FEET)
def test_a_foot_strikes_with_all_of_its_parts_and_is_called_by_its_body(of_text, case):
    foot, roll, name, both, single, kind = FEET[case]
    robot = of_text(biped_text(foot, roll))
    first, *_, last = default_landings(robot, Scene(robot=robot.label))
    assert [contact.frame for contact in first] == [name, name.replace("left", "right")]
    profiles = [
        shock_profile(Scene(robot=robot.label, contact=contacts), robot)
        for contacts in (first, last)
    ]
    np.testing.assert_allclose(
        [trunk_shock(profile) for profile in profiles], [both, single], rtol=1e-3
    )
    assert [contact.kind for profile in profiles for contact in profile.scene.contact] == [
        "flat",
        "flat",
        kind,
    ]


def test_a_foot_and_its_toe_on_a_joint_strike_together_where_both_are_as_low(of_text):
    """The toe's point lies above its sole: the friction of both acts at one height all the same."""
    toe = (
        '<body name="{side}_toe" pos=".13 0 -.03"><joint name="{side}_toe_pitch" axis="0 1 0" '
        'range="-1 1"/>'
        '<inertial pos=".03 0 0" mass=".1" diaginertia="1e-4 1e-4 1e-4"/>'
        '<geom type="box" size=".04 .04 .01" pos=".04 0 -.01"/></body>'
    )
    robot = of_text(biped_text(BOX + toe, False).replace('_ankle" pos', '_foot" pos'), "toe.xml")
    heel = "left_foot"
    first, *_, last = default_landings(robot, Scene(robot=robot.label))
    assert sorted(contact.frame for contact in first[:2]) == [heel, "left_toe"]
    assert len(first) == 4
    soles = {
        heel: np.array([(x, y, -0.05) for x in (-0.07, 0.13) for y in (-0.05, 0.05)]),
        "left_toe": np.array([(x, y, -0.02) for x in (0.0, 0.08) for y in (-0.04, 0.04)]),
    }
    soles |= {name.replace("left", "right"): corners for name, corners in soles.items()}
    profile = shock_profile(Scene(robot=robot.label, contact=first), robot)
    expected = unilateral(robot, profile.q, soles, np.array([0.0, 0.0, -1.0]))
    np.testing.assert_allclose(
        profile.delta_qd, expected, rtol=0, atol=1e-7 * np.abs(expected).max()
    )
    # On one foot the toe is lifted, as the foot is on its edge.
    single = shock_profile(Scene(robot=robot.label, contact=last), robot)
    foot = {"right_foot": soles["right_foot"]}
    expected = unilateral(robot, single.q, foot, np.array([0.0, 0.0, -1.0]))
    np.testing.assert_allclose(
        single.delta_qd, expected, rtol=0, atol=1e-7 * np.abs(expected).max()
    )
    assert single.scene.contact[0].kind == "edge"
    assert profile.value("shock_com", "body")[0] > 0.1


def test_a_part_that_is_named_strikes_alone_and_the_whole_foot_is_a_remark(of_text, capfd):
    robot = of_text(biped_text(balls(GEOMS), True))
    printed = good(capfd, "analyze", robot.label, "--contact", "left_foot0")
    assert "left_foot0 only: imu 0.0686" in printed
    assert "left_ankle_roll only: imu 0.2021" in next(
        line for line in printed.splitlines() if line.startswith("whole foot")
    )
    assert "both feet together: imu 0.3456" in next(
        line for line in printed.splitlines() if line.startswith("level feet")
    )
    assert "whole foot" not in good(capfd, "analyze", robot.label, "--contact", "left_ankle_roll")


def test_the_line_of_level_feet_is_the_landing_on_them(of_text, capfd):
    robot = of_text(biped_text(BOX, False))
    alone = good(
        capfd, "analyze", robot.label, "--contact", "left_ankle", "--at", "trunk"
    ).splitlines()
    whole = good(
        capfd, "analyze", robot.label, "--contact", "left_ankle+right_ankle", "--at", "trunk"
    ).splitlines()
    together = next(line for line in alone if line.startswith("level feet")).rpartition(
        "both feet together: "
    )[2]
    assert (
        whole[0]
        .partition("both feet together: ")[2]
        .startswith(together.partition(" (")[0].partition(",")[0])
    )


def test_links_fixed_to_the_trunk_are_no_feet_of_a_robot_with_limbs(tmp_path):
    path = quadruped(tmp_path, "q", "ankle")
    text = path.read_text().replace("_foot", "_tip")
    pad = (
        '<link name="rubber_feet"><collision><geometry><box size="0.2 0.1 '
        '0.01"/></geometry></collision></link>'
    )
    pad += (
        '<joint name="pad" type="fixed"><parent link="base"/><child link="rubber_feet"/><origin '
        'xyz="0 0 -0.065"/></joint>'
    )
    landings = []
    for more in ("", pad):
        path.write_text(text.replace("</robot>", f"{more}</robot>"))
        robot = load_robot(path)
        landings.append(
            [
                [contact.frame for contact in contacts]
                for contacts in default_landings(robot, Scene(robot=str(path)))
            ]
        )
    assert landings[1] == landings[0]
    assert len(landings[0][0]) == 4


WHEEL = """<mujoco><worldbody><body name="chassis" pos="0 0 .4"><freejoint/>
<inertial pos="0 0 .05" mass="10" diaginertia=".2 .15 .2"/>{}</worldbody></mujoco>"""


def test_the_hub_of_a_wheel_is_not_its_lowest_point(of_text):
    legs = "".join(
        f'<body name="{side}_leg" pos="0 {y} 0"><joint axis="0 1 0"/>'
        '<inertial pos="0 0 -.1" mass=".5" diaginertia="1e-3 1e-3 1e-4"/>'
        f'<body name="{side}_wheel" pos=".1 0 -.2"><joint axis="0 1 0"/>'
        '<geom type="cylinder" size=".08 .02" zaxis="0 1 0" mass=".6"/>'
        f'<site name="{side}_hub"/></body></body>'
        for side, y in (("left", 0.2), ("right", -0.2))
    )
    robot = of_text(WHEEL.format(legs + "</body>"))
    contacts = default_landings(robot, Scene(robot=robot.label))[0]
    assert [contact.frame for contact in contacts] == ["left_wheel", "right_wheel"]
    profile = shock_profile(Scene(robot=robot.label, contact=contacts), robot)
    assert {(contact.at, contact.kind) for contact in profile.scene.contact} == {
        ("lowest", "point")
    }
    assert profile.contacts[0].point[2] == pytest.approx(0.4 - 0.2 - 0.08 - 0.4, abs=1e-12)


def test_a_joint_beside_a_toe_is_not_its_tip(of_text):
    """It is 27 mm above the tip, and 150 mm behind it."""
    rod = '<joint axis="0 1 0"/><geom type="capsule" fromto="{}" size="{}" mass="{}"/>'
    toe = f'<body name="toe" pos="0 0 -.2">{rod.format("0 0 0 .15 0 -.015", 0.012, 0.1)}</body>'
    leg = f'<body name="leg">{rod.format("0 0 0 0 0 -.2", 0.02, 1.0)}{toe}</body>'
    robot = of_text(WHEEL.format(leg + "</body>"))
    profile = shock_profile(Scene(robot=robot.label, contact="toe"), robot)
    assert profile.scene.contact[0].at == "lowest"
    np.testing.assert_allclose(
        profile.contacts[0].point - profile.landing.state.position[0, 2],
        [0.15, 0.0, -0.027],
        atol=2e-3,
    )


def test_geometry_of_what_is_fixed_to_a_contact_is_its_own(of_text):
    """A foot without shapes whose pad is fixed to it strikes as the pad does."""
    pad = '<body name="pad" pos="0 0 -.02"><geom type="box" size=".05 .03 .01" mass=".1"/></body>'
    leg = (
        f'<geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02" mass="1"/><body name="plate" '
        f'pos="0 0 -.2">{pad}</body>'
    )
    robot = of_text(WHEEL.format(f'<body name="leg"><joint axis="0 1 0"/>{leg}</body></body>'))
    profiles = [
        shock_profile(Scene(robot=robot.label, contact=name), robot) for name in ("plate", "pad")
    ]
    assert {profile.scene.contact[0].kind for profile in profiles} != {"point"}
    np.testing.assert_allclose(profiles[0].delta_qd, profiles[1].delta_qd, atol=1e-12)


def test_mujoco_lands_on_the_edge_of_a_foot_that_cannot_roll(of_text):
    """Its contacts are overdamped springs of 40 µs with friction 20, of the left foot only; 1 ms is
    simulated.
    """
    mujoco = pytest.importorskip("mujoco")
    robot = of_text(biped_text(BOX, False))
    profile = shock_profile(Scene(robot=robot.label, contact="left_ankle"), robot)
    ground = '<geom name="ground" type="plane" size="5 5 1" friction="20 1 1" solref="4e-5 5"/>'
    option = '<option timestep="2e-6" gravity="0 0 0" cone="elliptic"/>'
    text = biped_text(BOX.replace("<geom", '<geom name="{side}_sole"'), False)
    text = text.replace("<worldbody>", f"{option}<worldbody>{ground}")
    text = text.replace('name="right_sole"', 'contype="0" conaffinity="0"')
    text = text.replace('name="left_sole"', 'name="left_sole" friction="20 1 1" solref="4e-5 5"')
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for joint in robot.single_joints[1:]:
        data.joint(joint.name).qpos = joint.value(profile.q)
    mujoco.mj_kinematics(model, data)
    data.qpos[2] -= data.geom("left_sole").xpos[2] - 0.01
    data.qvel[2] = -1.0
    mujoco.mj_step(model, data, 500)
    # Of a body MuJoCo gives the velocity of its centre of mass.
    velocity = np.zeros(6)
    mujoco.mj_objectVelocity(
        model, data, mujoco.mjtObj.mjOBJ_BODY, model.body("trunk").id, velocity, 0
    )
    assert np.linalg.norm(velocity[3:] - [0.0, 0.0, -1.0]) == pytest.approx(
        trunk_shock(profile), rel=0.02
    )
    assert profile.scene.contact[0].kind == "edge"


def test_end_stops_and_soles_push_in_one_problem(of_text):
    """A knee at its limit, which the impact would bend further, on a foot of which an edge carries."""
    text = biped_text(BOX, False).replace(
        '"left_knee" axis="0 1 0" range="0 2.3"',
        '"left_knee" axis="0 1 0" range="0 .5235987755982988"',
    )
    robot = of_text(text)
    angles = {
        f"{side}_{joint}": angle
        for side in ("left", "right")
        for joint, angle in (("hip", -15), ("knee", 30), ("ankle", -15))
    }
    scene = Scene(
        robot=robot.label, contact="left_ankle", posture=Posture(joints_deg=angles), stops=True
    )
    profile = shock_profile(scene, robot)
    assert [block.frame for block in profile.landing.acting] == ["left_knee"]
    sole = np.array([(x, y, -0.05) for x in (-0.07, 0.13) for y in (-0.05, 0.05)])
    expected = unilateral(
        robot,
        profile.q,
        {"left_ankle": sole},
        np.array([0.0, 0.0, -1.0]),
        stops={"left_knee": -1.0},
    )
    np.testing.assert_allclose(
        profile.delta_qd, expected, rtol=0, atol=1e-7 * np.abs(expected).max()
    )


def test_a_single_site_that_is_named_like_a_foot_stands_for_the_whole_foot(of_text):
    """At a toe's tip, or above the sole; as long as the sole is wide, unlike the end of a beam."""
    whole = of_text(biped_text(BOX, True))
    expected = shock_profile(Scene(robot=whole.label, contact="left_ankle_roll"), whole)
    for place in (".13 0 -.05", "0 0 .03"):
        robot = of_text(
            biped_text(f'{BOX}<site name="{{side}}_toe" pos="{place}"/>', True), "site.xml"
        )
        profile = shock_profile(Scene(robot=robot.label, contact="left_toe"), robot)
        assert profile.scene.contact[0].kind == "flat"
        np.testing.assert_allclose(profile.delta_qd, expected.delta_qd, atol=1e-12)


@pytest.mark.parametrize(
    ("directions", "rows"), [(("x", "y", "z"), (6, 5, 4, 3)), (("z",), (3, 2, 1, 1))]
)
def test_rows_of_each_kind_that_sticks_or_slides(biped, directions, rows):
    given = [
        {"kind": "flat"},
        {"kind": "edge", "edge": (1.0, 0.0, 0.0)},
        {"kind": "corner"},
        {"kind": "point"},
    ]
    contacts = [
        Contact(frame="left_foot", at="lowest", directions=directions, **one) for one in given
    ]
    assert (
        tuple(
            contact_constraint(biped, contact, np.array([0.0, 0.0, 1.0])).size
            for contact in contacts
        )
        == rows
    )
