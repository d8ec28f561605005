"""Loops: rows added to the equation, independent coordinates (Eq. 7), and postures in which loops
are closed.
"""

import dataclasses

import dense
import numpy as np
import pinocchio as pin
import pytest
from panels import land, scene
from robot_texts import LIMIT, joint, link, refused, urdf
from trees import known_robot, robot_from

from shockpc import (
    Closure,
    Contact,
    Joints,
    LoopEnd,
    Posture,
    Scene,
    SceneError,
    Strike,
    UnknownName,
    resolve,
    shock_profile,
)
from shockpc.evaluation.variations.arguments import varied_landings
from shockpc.landing.closure import closure_constraint, closure_gap, loop_of
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.method.constraints import row_jacobian
from shockpc.method.dynamics import dynamics
from shockpc.studies.analyze.report import landing_report
from shockpc.studies.sweep.row_options import row_options
from shockpc.studies.sweep.study import sweep

FALL = Strike(velocity=(0.4, 0.0, -1.0))
WIDE = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


def assert_close(found, expected, digits=1e-12):
    """Equal to a share of the largest number."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=digits * np.abs(expected).max())


FOUR_BAR = robot_from(
    urdf(
        *map(link, ("ground", "crank", "rod", "rocker")),
        joint("a", "ground", "crank", axis="0 -1 0", more='<origin xyz="0.1 0 0"/>' + WIDE),
        joint("b", "crank", "rod", axis="0 -1 0", more='<origin xyz="0 0 -0.2"/>' + WIDE),
        joint("c", "ground", "rocker", axis="0 -1 0", more='<origin xyz="-0.15 0 0"/>' + WIDE),
        name="four_bar",
    )
)
TIP = LoopEnd(frame="rocker", offset=(0.0, 0.0, -0.35))
LOOP = Closure(a=LoopEnd(frame="rod", offset=(0.0, 0.0, -0.3)), b=TIP)
BENT = Posture(joints_deg={"a": 40.0, "b": -60.0, "c": 10.0})


def four_bar(**changes):
    given = {
        "robot": "four_bar.urdf",
        "contact": (Contact(frame=TIP.frame, offset=TIP.offset),),
        "closure": (LOOP,),
        "assemble": ("b", "c"),
        "posture": BENT,
        "strike": FALL,
    }
    return Scene(**(given | changes))


def closed(**changes):
    return shock_profile(four_bar(**changes), FOUR_BAR)


def followers():
    """Joints that follow others in a chain."""
    follow = '<mimic joint="{}" multiplier="{}" offset="{}"/>' + WIDE
    place = '<origin xyz="0.05 0.02 -0.3" rpy="0.1 0.2 0.3"/>'
    joints = [
        joint("j1", "a", "b", more=place + WIDE),
        joint("j2", "b", "c", axis="0.3 1 0", more=place + follow.format("j1", -1.5, 0.2)),
        joint("j3", "c", "d", axis="0 1 0.4", more=place + follow.format("j2", 0.5, -0.1)),
    ]
    contact = Contact(frame="d", offset=(0.1, 0.0, -0.2))
    scene = Scene(robot="f.urdf", contact=contact, posture=Posture(joints={"j1": 0.4}), strike=FALL)
    return scene, robot_from(urdf(*map(link, "abcd"), *joints, name="followers"))


CASES = {
    "four-bar": lambda: (four_bar(), FOUR_BAR),
    "Skippy": lambda: (scene("fig3"), robot_of(scene("fig3"))),
    "five-bar": lambda: (scene("five_bar"), robot_of(scene("five_bar"))),
    "followers": followers,
}


def closure_rows(model, q, closure):
    """Relative velocity (3, nv) of the two ends of a closure of points, world axes, by Pinocchio."""
    first, second = (
        dense.point_rows(model, q, place.frame, place.offset) for place in (closure.a, closure.b)
    )
    return first - second


# Rows and columns


@pytest.mark.parametrize("name", CASES)
def test_rows_and_independent_coordinates_agree(name):
    """Section 3.1.1: stacking the ties under the contact, or leaving dependent velocities out,
    gives the profile's jump.

    Two of the three rows of a planar closure are independent; that is normal, and only the rank
    says so.
    """
    found, robot = CASES[name]()
    profile = shock_profile(found, robot)
    assert (profile.health.rank, profile.health.rows) == ((5, 6) if found.closure else (3, 3))
    assert {warning.kind for warning in profile.health.warnings} <= {"drives"}
    model, q = robot.model, profile.q
    H = dense.inertia(model, q) + np.diag(profile.landing.joint_model.armature)
    J = np.concatenate(
        [dense.point_rows(model, q, contact.frame, contact.offset) for contact in found.contact]
    )
    b = np.concatenate([contact.approach for contact in profile.contacts])
    K = [closure_rows(model, q, closure) for closure in found.closure]
    for mimic in robot.mimics:
        rates = {mimic.joint: -1.0, **mimic.leaders}
        K.append(
            [
                [
                    rates.get(joint.name, 0.0)
                    for joint in robot.joints
                    for _ in range(joint.v.start, joint.v.stop)
                ]
            ]
        )
    K = np.concatenate(K)
    stacked, _ = dense.solve(H, np.concatenate([J, K]), np.concatenate([b, np.zeros(len(K))]))
    G = dense.nullspace(K)
    assert G.shape[1] == model.nv - 2
    assert_close(profile.delta_qd, stacked, 1e-11)
    assert_close(profile.delta_qd, G @ dense.solve(G.T @ H @ G, J @ G, b)[0], 1e-11)


@pytest.mark.parametrize("again", ["beside", "swapped"])
def test_what_holds_the_same_gives_the_same_shock(again):
    """A hinge made of two points is that of one where the loop is planar; and the ends of a closure
    can be exchanged.
    """
    beside = [
        dataclasses.replace(end, offset=(end.offset[0], 0.01, end.offset[2]))
        for end in (LOOP.a, LOOP.b)
    ]
    closures = {
        "beside": (LOOP, Closure(a=beside[0], b=beside[1])),
        "swapped": (Closure(a=LOOP.b, b=LOOP.a),),
    }[again]
    np.testing.assert_allclose(closed(closure=closures).shock_com, closed().shock_com, atol=1e-12)


def test_a_loop_can_be_cut_anywhere():
    """Skippy's drive cut at its crank pin or at its rod's end is the same robot."""
    found, whole = scene("fig3"), land("fig3")
    swapped = dataclasses.replace(found.closure[0], a=found.closure[0].b, b=found.closure[0].a)
    assert known_robot("skippy").mass == pytest.approx(whole.robot.mass)
    assert_close(land(dataclasses.replace(found, closure=(swapped,))).delta_qd, whole.delta_qd)


@pytest.mark.parametrize("e", [0.0, 0.7])
def test_the_ends_of_a_loop_stay_together(e):
    """Both ends have one velocity after the impact, which is −e of that before it, for they are the
    contact point.
    """
    profile = closed(
        contact=Contact(
            frame=TIP.frame, offset=TIP.offset, restitution=e, restitution_along="directions"
        )
    )
    for place in (LOOP.a, LOOP.b):
        jump = dense.velocity(profile, profile.bodies.index(place.frame), place.offset)
        np.testing.assert_allclose(jump, -(1.0 + e) * np.array(FALL.velocity), atol=1e-12)


def test_a_frame_closure_welds_two_bodies():
    """A closure of kind "frame" between a rod and the link that it hangs on is a locked joint."""
    weld = Closure(
        a=LoopEnd(frame="crank", offset=(0.0, 0.0, -0.2)), b=LoopEnd(frame="rod"), kind="frame"
    )
    posture = Posture(joints_deg={"a": 40.0, "b": 0.0, "c": 10.0})
    hand = {"contact": (Contact(frame="rod", offset=(0.0, 0.0, -0.3)),), "posture": posture}
    welded = closed(closure=(weld,), assemble=("b",), **hand)
    locked = closed(closure=(), assemble=(), joints=Joints(locked=("b",)), **hand)
    np.testing.assert_allclose(welded.delta_v, locked.delta_v, atol=1e-12)
    np.testing.assert_allclose(welded.delta_omega, locked.delta_omega, atol=1e-12)
    assert welded.health.rank == 3 + 1


# A pin in a slot

SLOT = robot_from(
    urdf(
        *map(link, ("base", "bar", "slider")),
        joint("j1", "base", "bar", axis="0 -1 0", more=LIMIT),
        joint("j2", "base", "slider", axis="0 -1 0", more='<origin xyz="0.2 0 -0.3"/>' + LIMIT),
        name="slot",
    )
)


@pytest.mark.parametrize("bodies", [(1, 2), (2, 1), (0, 2), (-1, 1), (1, -1)])
def test_rows_of_a_closure_are_the_derivative_of_its_gap(bodies):
    """Against central differences; also where the ends are apart along a direction that is left
    free, and while a loop is open.
    """
    ends = {
        "a": LoopEnd(frame="bar", offset=(0.1, 0.2, 0.4)),
        "b": LoopEnd(frame="slider", offset=(-0.3, 0.1, -0.2)),
    }
    loop = loop_of(SLOT, Closure(**ends, directions=("x", (0.3, -0.5, 0.8))))._replace(
        bodies=bodies
    )
    model = SLOT.model
    q = pin.integrate(model, pin.neutral(model), np.random.default_rng(3).normal(size=model.nv))
    steps = 1e-6 * np.concatenate([np.eye(model.nv), -np.eye(model.nv)])
    gaps = closure_gap(
        dynamics(SLOT, np.array([pin.integrate(model, q, step) for step in steps])), loop
    )
    K = row_jacobian(dynamics(SLOT, q[None]), [closure_constraint(loop)])[0]
    np.testing.assert_allclose(K.T, (gaps[: model.nv] - gaps[model.nv :]) / 2e-6, atol=1e-8)


def test_a_slot_is_the_same_wherever_its_origin_lies_along_it():
    """The slot's frame moved along the slot changes no number, and the momentum is what the contact
    gave.
    """
    posture = Posture(joints={"j1": float(np.arctan2(-0.3, 0.2)), "j2": 0.2})
    tip = Contact(frame="slider", offset=(0.4, 0.0, -0.1))
    found = []
    for along in (0.0, 0.1, float(np.hypot(0.2, 0.3)), 1.0):
        slot = Closure(
            a=LoopEnd(frame="bar", offset=(along, 0.0, 0.0)),
            b=LoopEnd(frame="slider"),
            directions=("z",),
        )
        profile = shock_profile(
            Scene(robot="slot.urdf", contact=(tip,), closure=(slot,), posture=posture), SLOT
        )
        found.append(np.concatenate([profile.delta_omega, profile.delta_v]))
        linear, angular = dense.momentum(profile)
        np.testing.assert_allclose(linear, profile.contacts[0].impulse, atol=1e-12)
        np.testing.assert_allclose(
            angular, np.cross(profile.contacts[0].point, profile.contacts[0].impulse), atol=1e-12
        )
    np.testing.assert_allclose(
        found[1:], np.broadcast_to(found[0], (3, *found[0].shape)), atol=1e-11
    )


# Closing the posture


def test_the_posture_is_projected_onto_the_loop():
    """The gap before, the joints that moved and by how much; joints that may not move do not, nor
    any where it is closed.
    """
    profile = closed()
    loop, (gap, turn, moved) = loop_of(FOUR_BAR, LOOP), profile.assembly[1:4]
    before = np.array(profile.q)
    before[7:] = np.radians([40.0, -60.0, 10.0])
    assert gap == pytest.approx(
        np.linalg.norm(closure_gap(dynamics(FOUR_BAR, before[None]), loop)), rel=1e-12
    )
    assert turn == 0.0
    assert np.abs(closure_gap(profile.landing.state, loop)).max() < 1e-12
    step = pin.difference(FOUR_BAR.model, before, profile.q)
    assert step[6] == 0.0
    assert moved == (
        ("b", pytest.approx(step[7], rel=1e-9), "rad"),
        ("c", pytest.approx(step[8], rel=1e-9), "rad"),
    )
    again = closed(
        posture=Posture(joints=dict(zip("abc", map(float, profile.q[7:]), strict=True)))
    ).assembly
    assert again.gap < 1e-12
    assert again.moved == ()
    # Without `assemble` all joints may move that the posture does not set.
    assert {
        name
        for name, *_ in closed(assemble=(), posture=Posture(joints_deg={"a": 40.0})).assembly.moved
    } == {"b", "c"}


WELD = Closure(
    a=LoopEnd(frame="rod"), b=LoopEnd(frame="crank", offset=(0.0, 0.0, -0.2)), kind="frame"
)
"""Where the rod hangs: its ends always meet, rotated against each other by joint b."""


def test_a_closure_of_frames_has_an_angle_beside_its_gap():
    """Ends at one point, rotated by 60 degrees, have no gap but an angle."""
    found = closed(closure=(WELD,), assemble=("b",)).assembly
    assert found.gap < 1e-15
    assert found.turn == pytest.approx(np.radians(60.0), rel=1e-12)
    assert found.moved == (("b", pytest.approx(np.radians(60.0), rel=1e-9), "rad"),)


def test_a_prismatic_joint_closes_a_loop_in_metres():
    """A slider at −50 mm, on an arm that rotates the world's −x up by atan(4/3) about +y."""
    robot = robot_from(
        urdf(
            *map(link, ("ground", "arm", "slider")),
            joint("turn", "ground", "arm"),
            joint("slide", "arm", "slider", "prismatic", axis="1 0 0"),
        )
    )
    closure = Closure(
        a=LoopEnd(frame="slider"),
        b=LoopEnd(frame="ground", offset=(-0.03, 0.0, 0.04)),
        directions=("x", "z"),
    )
    posture = Posture(joints={"turn": 0.0, "slide": -0.06})
    given = Scene(robot="t", contact="slider", closure=(closure,), assemble=("*",), posture=posture)
    found = resolve(given, robot).assembly
    expected = (
        ("turn", pytest.approx(np.arctan2(4, 3), rel=1e-9), "rad"),
        ("slide", pytest.approx(0.01, rel=1e-9), "m"),
    )
    assert found.moved == expected
    assert found.gap == pytest.approx(0.05, rel=1e-12)


PARALLEL = robot_from(
    urdf(
        *map(link, ("ground", "crank", "rod", "rocker")),
        joint("a", "ground", "crank", axis="0 -1 0", more='<origin xyz="0.1 0 0"/>' + LIMIT),
        joint(
            "b",
            "crank",
            "rod",
            axis="0 -1 0",
            more='<origin xyz="0 0 -0.2"/><mimic joint="a" multiplier="-1"/>' + LIMIT,
        ),
        joint(
            "c",
            "ground",
            "rocker",
            axis="0 -1 0",
            more='<origin xyz="-0.1 0 0"/><mimic joint="a"/>' + LIMIT,
        ),
        name="parallel",
    )
)
"""A parallelogram, all of whose joints follow one."""


def parallel(reach=0.2, **changes):
    closure = Closure(
        a=LoopEnd(frame="rod", offset=(-0.2, 0.0, 0.0)),
        b=LoopEnd(frame="rocker", offset=(0.0, 0.0, -reach)),
    )
    given = {
        "robot": "p.urdf",
        "contact": (Contact(frame="rocker", offset=(0.0, 0.0, -0.2)),),
        "closure": (closure,),
        "posture": Posture(joints_deg={"a": 20.0}),
    }
    return Scene(**(given | changes))


FAR = dataclasses.replace(LOOP, b=LoopEnd(frame="rocker", offset=(0.0, 0.0, -0.9)))


@pytest.mark.parametrize(
    ("given", "robot", "gap", "parts"),
    [
        # Crank and rod reach 0.5 m at most, the rocker's end is 0.9 m from its axis, which is 0.25
        # m beside the crank's.
        (
            four_bar(closure=(FAR,)),
            FOUR_BAR,
            (100.0, 700.0),
            ('"rod–rocker"', 'move: "b", "c")', "--assemble"),
        ),
        (
            four_bar(closure=(WELD,), assemble=("c",)),
            FOUR_BAR,
            (0.0, 1e-12),
            ('"rod–crank"', "60 deg", 'move: "c")'),
        ),
        # What follows a joint that may not move cannot close a loop, and is not offered.
        (parallel(0.25), PARALLEL, (49.99, 50.01), ('"rod–rocker"', "move: none)")),
        (
            parallel(0.25, posture=Posture()),
            PARALLEL,
            (49.99, 50.01),
            ('"rod–rocker"', 'move: "a")'),
        ),
    ],
    ids=["out of reach", "rotated", "leader held", "followers"],
)
def test_a_loop_that_cannot_be_closed_is_refused_with_its_gap(given, robot, gap, parts):
    """The message gives what is left, in millimetres and degrees, and the joints that may move."""
    text = refused(SceneError, parts, resolve, given, robot)
    assert gap[0] <= float(text.split("stay ")[1].split(" mm")[0]) <= gap[1]


def three_rods(longer=0.0, tilt=0.0, armature=0.0):
    """A body under three parallel bars of 0.1 m, which can swing; the third is longer, or its foot
    stands elsewhere [m].
    """
    bars = [(-0.03, 0.1, 0.0), (0.0, 0.1, 0.0), (0.05, 0.1 + longer, tilt)]
    joints = [
        joint(f"bar{k}", "base", f"rod{k}", axis="0 1 0", more=f'<origin xyz="{x} 0 0"/>' + WIDE)
        for k, (x, *_) in enumerate(bars)
    ]
    joints.append(
        joint("hinge", "rod0", "foot", axis="0 1 0", more='<origin xyz="0 0 -0.1"/>' + WIDE)
    )
    ends = [
        Closure(
            a=LoopEnd(frame=f"rod{k}", offset=(0.0, 0.0, -length)),
            b=LoopEnd(frame="foot", offset=(x + 0.03 + moved, 0.0, 0.0)),
        )
        for k, (x, length, moved) in enumerate(bars)
        if k
    ]
    robot = robot_from(
        urdf(*map(link, ("base", "rod0", "rod1", "rod2", "foot")), *joints, name="rods")
    )
    posture = Posture(joints_deg={"bar0": 20.0, "bar1": 20.0, "bar2": 20.0, "hinge": -20.0})
    return shock_profile(
        Scene(
            robot="r",
            contact="foot",
            closure=tuple(ends),
            assemble=("*",),
            posture=posture,
            strike=FALL,
            joints=Joints(armature={"*": armature} if armature else {}),
        ),
        robot,
    )


@pytest.mark.parametrize(
    "fault", [{"tilt": 1e-10}, {"longer": 1e-11}, {"longer": 1e-12}, {"longer": 1e-6}]
)
def test_bars_that_are_parallel_to_the_digits_of_a_file_are_parallel(fault):
    """They swing as exact ones do, with a warning; taken literally they would lock, and strain one
    another without bound.
    """
    exact, found = three_rods(), three_rods(**fault)
    assert not any("loops" in str(warning) for warning in exact.health.warnings)
    assert found.health.rank == exact.health.rank
    assert_close(found.delta_v, exact.delta_v, 1e-4)
    most = {
        key: max(np.linalg.norm(load.force) for load in profile.loads)
        for key, profile in (("", exact), ("fault", found))
    }
    assert most["fault"] < 2.0 * most[""]
    warnings = " ".join(str(warning) for warning in found.health.warnings)
    assert ("are taken as the same" in warnings) == (fault in ({"tilt": 1e-10}, {"longer": 1e-6}))
    assert ("mm apart, closed by least squares" in warnings) == (fault == {"longer": 1e-6})


@pytest.mark.parametrize("tilt", [1e-10, 3e-10, 1e-9, 3e-9, 1e-6])
def test_inertia_decides_no_redundancy(tilt):
    """Rows are the same rows with rotors of any inertia on the joints."""
    ranks = {
        armature: three_rods(tilt=tilt, armature=armature).health.rank
        for armature in (0.0, 1e-4, 0.03, 10.0)
    }
    assert len(set(ranks.values())) == 1, ranks


def neck(armature=0.0, digits=8):
    """A head on a body: two rods beside the head's bar turn a plate on it, held at two points each,
    as a motor does.

    The rods are as much longer and shorter as the plate is turned, so that the three bars meet in
    one point and the plate can move, to the digits of the file.
    """
    bar = np.array([-0.03, 0.04])
    low, high = (0.008 * np.array([np.cos(angle), np.sin(angle)]) for angle in (0.3, 0.304))

    def at(v, y=0.0):
        return f'pos="{v[0]:.{digits}f} {y} {v[1]:.{digits}f}"'

    inertia = '<inertial pos="0 0 0" mass="{}" diaginertia="{} {} {}"/>'
    rods, ends, ties = "", "", ""
    for k, sign in enumerate((1.0, -1.0)):
        rod = sign * low - bar - sign * high
        hinge = f'<joint name="rod{k}" axis="0 1 0"/>' + inertia.format(0.003, *[1e-6] * 3)
        rods += f'<body name="rod{k}" {at(sign * high)}>{hinge}'
        for end, y in enumerate((0.0, 0.1)):
            rods += f'<site name="a{k}{end}" {at(rod, y)}/>'
            ends += f'<site name="b{k}{end}" {at(sign * low, y)}/>'
            ties += f'<connect site1="a{k}{end}" site2="b{k}{end}"/>'
        rods += "</body>"
    light = inertia.format(0.003, *[1e-6] * 3)
    plate = f'<body name="plate" {at(bar)}><joint name="motor" axis="0 1 0"/>{light}{rods}</body>'
    head = (
        f'<body name="head"><joint name="pitch" axis="0 1 '
        f'0"/>{inertia.format(0.15, *[1e-4] * 3)}{plate}</body>'
    )
    neck = (
        f'<body name="yaw" pos="0.1 0 0.2"><joint name="yaw" axis="0 0 '
        f'1"/>{light}{ends}{head}</body>'
    )
    body = f'<body name="body"><freejoint/>{inertia.format(1.1, *[3e-3] * 3)}{neck}</body>'
    robot = robot_from(
        f'<mujoco model="neck"><worldbody>{body}</worldbody><equality>{ties}</equality></mujoco>',
        ".xml",
    )
    joints = Joints(armature={"*": armature} if armature else {})
    return shock_profile(
        Scene(robot="neck", contact="body", assemble=("*",), strike=FALL, joints=joints), robot
    )


@pytest.mark.parametrize("digits", [8, 6])
def test_rods_beside_a_bar_carry_no_more_with_rotors_on_the_joints(digits):
    """A neck that moves to the digits of its file does so with any inertia of its rotors; nothing
    undetermined is the headline.
    """
    found = {armature: neck(armature, digits) for armature in (0.0, 1e-3, 0.03, 1.0)}
    assert len({profile.health.rank for profile in found.values()}) == 1
    for profile in found.values():
        assert profile.value("joint_impulse", "joint").max() < 2.0 * np.linalg.norm(
            profile.total_impulse
        )
        headline = dict(landing_report(profile).body(False)[0].lines)["joint"]
        assert headline == "largest impulse: not determined, because rows are redundant"


def test_joints_that_strain_one_another_are_reported():
    """Bars a millionth out of parallel lock the foot, with impulses far above that of the contact."""
    (warning,) = (w for w in three_rods(tilt=1e-5).health.warnings if "N s" in str(w))
    assert warning.value > 100.0


def test_a_loop_is_followed_through_a_sweep():
    """Every row of a five-bar leg keeps the side to which its knees are bent, also where a start
    far away would not.
    """
    given = scene("five_bar")
    made = sweep(given, robot=robot_of(given), vary={"front_hip": "-90:30:25"}, prove=0)
    angles = []
    for row in range(made.landings.rows):
        case, robot = made.landings.case(row)
        q = resolve(case, robot).q
        angles.append(q[[robot.joint(f"{side}_knee").q.start for side in ("front", "rear")]])
    front, rear = np.array(angles).T
    hips = np.linspace(np.radians(-90), np.radians(30), 25)
    # Two equal legs: the knees stay symmetric, and the front one is stretched where the hips are
    # equal.
    np.testing.assert_allclose(rear, -front, atol=1e-9)
    assert np.all(np.diff(front) < 0.0)
    assert np.abs(np.diff(front)).max() < 0.1
    assert np.all(front * (np.radians(-60.0) - hips) > -1e-12)
    assert all(
        f"--set {side}_knee=" in row_options(made.landings, 3)[0] for side in ("front", "rear")
    )


def test_another_start_closes_a_loop_with_a_warning():
    """From knees bent the wrong way Gauss–Newton comes to no closed loop; from another start it
    does.
    """
    given = scene("five_bar")
    posture = dataclasses.replace(
        given.posture, joints_deg={**given.posture.joints_deg, "front_hip": -70.0}
    )
    profile = shock_profile(dataclasses.replace(given, posture=posture))
    assert profile.assembly.retried
    assert any(
        "perhaps assembled in another way" in str(warning) for warning in profile.health.warnings
    )


def test_joints_to_assemble_without_a_loop_and_open_loops_are_reported():
    """A warning for joints that had nothing to close, and for a linkage whose own scene would close
    it.
    """
    for name, frame, changes, parts in (
        ("leg", "lower_leg", {"assemble": ("*",)}, ('"knee"',)),
        ("skippy", scene("fig3").contact[0].frame, {}, ("fig3.toml",)),
        ("five_bar", scene("five_bar").contact[0].frame, {}, ("five_bar.toml",)),
    ):
        (warning,) = resolve(
            Scene(robot=name, contact=frame, **changes), known_robot(name)
        ).warnings
        assert warning.kind == "scene"
        assert all(part in str(warning) for part in parts)


# Refused


@pytest.mark.parametrize(
    ("closures", "error", "parts"),
    [
        (
            [Closure(a=LoopEnd(frame="rod"), b=LoopEnd(frame="rod"))],
            SceneError,
            ('"rod–rod"', 'body "rod"'),
        ),
        (
            [dataclasses.replace(LOOP, directions=((0.0, 0.0, 0.0),))],
            SceneError,
            ('"rod–rocker"', '"x", "y", "z"'),
        ),
        ([dataclasses.replace(LOOP, directions=())], SceneError, ('"rod–rocker"', '"x", "y", "z"')),
        (
            [dataclasses.replace(LOOP, a=LoopEnd(frame="rodd"))],
            UnknownName,
            ('"rodd"', '"four_bar"', '"rod"', "shockpc robots"),
        ),
        # The same two points once more, in either order and along whatever.
        *(
            ([LOOP, again], SceneError, ('"rod–rocker"', "same points"))
            for again in (
                LOOP,
                Closure(a=LOOP.b, b=LOOP.a),
                dataclasses.replace(LOOP, directions=("y",)),
            )
        ),
    ],
    ids=[
        "to itself",
        "no length",
        "no direction",
        "no frame",
        "twice",
        "the other way round",
        "in another direction",
    ],
)
def test_a_closure_that_cannot_be_is_refused(closures, error, parts):
    """The message names the closure and what would be valid."""
    refused(error, parts, resolve, four_bar(closure=tuple(closures)), FOUR_BAR)


# Joint rates before the impact


def swinging(**joints):
    return Strike(velocity=(0.0, 0.0, -1.0), joint_velocities=joints)


def rates_of(found, robot):
    """Joint rates before the impact, and the rows of the loops by Pinocchio."""
    landing = resolve(found, robot)
    K = np.concatenate([closure_rows(robot.model, landing.q, closure) for closure in found.closure])
    return landing.before.joint_rates, K


@pytest.mark.parametrize("leader", ["a", "b", "c"])
def test_one_rate_of_a_four_bar_sets_the_others(leader):
    """The loop stays closed; the profile is the one with all of them given."""
    rates, K = rates_of(four_bar(strike=swinging(**{leader: 1.3})), FOUR_BAR)
    assert rates["abc".index(leader) + 6] == 1.3
    np.testing.assert_allclose(K @ rates, 0.0, atol=1e-14)
    np.testing.assert_array_equal(rates[:6], 0.0)
    assert np.abs(rates[6:]).min() > 0.1
    one = closed(strike=swinging(**{leader: 1.3}))
    every = closed(strike=swinging(**dict(zip("abc", map(float, rates[6:]), strict=True))))
    assert_close(one.delta_qd, every.delta_qd)
    np.testing.assert_allclose(one.contacts[0].approach, every.contacts[0].approach, atol=1e-13)
    assert np.linalg.norm(one.contacts[0].approach - [0.0, 0.0, -1.0]) > 0.05


def test_rates_that_are_not_given_are_the_least():
    """A loop of five bars leaves one rate free: of all completions that keep it closed, the one of
    minimum norm is taken.
    """
    found = scene("five_bar")
    robot = robot_of(found)
    given = next(name for name in robot.joint_names if name.startswith("rear"))
    rates, K = rates_of(
        dataclasses.replace(
            found, strike=dataclasses.replace(found.strike, joint_velocities={given: 2.0})
        ),
        robot,
    )
    of_given = robot.joint(given).v.start
    others = [robot.joint(name).v.start for name in robot.joint_names if name != given]
    assert rates[of_given] == 2.0
    np.testing.assert_allclose(
        rates[others], -np.linalg.pinv(K[:, others], rcond=1e-10) @ K[:, of_given] * 2.0, atol=1e-12
    )
    np.testing.assert_allclose(K @ rates, 0.0, atol=1e-13)
    assert len(others) > np.linalg.matrix_rank(K[:, others], 1e-9)


@pytest.mark.parametrize("base", ["free", "planar"])
def test_followers_move_with_their_leader_along_a_loop(base):
    """The one rate of a parallelogram is given; its followers have no rate of their own to
    complete.
    """
    rates, K = rates_of(parallel(base=base, strike=swinging(a=0.7)), PARALLEL)
    np.testing.assert_allclose(rates, [0.0] * 6 + [0.7, -0.7, 0.7], atol=1e-15)
    np.testing.assert_allclose(K @ rates, 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("rates", "locked"),
    [
        ({"a": 1.0, "b": 0.2}, ()),
        ({"a": 1.0, "b": 0.2, "c": 0.1}, ()),
        ({"a": 1.0, "c": 0.0}, ()),
        ({"a": 1.0}, ("b",)),
    ],
)
def test_rates_that_open_a_loop_are_refused(rates, locked):
    """The message gives the speed that remains when the other joints help as far as they can; a
    locked joint does not.
    """
    _, K = rates_of(four_bar(), FOUR_BAR)
    left = np.array([rates.get(name, 0.0) for name in "abc"])
    free = [k for k, name in enumerate("abc") if name not in rates and name not in locked]
    if free:
        left[free] = -np.linalg.lstsq(K[:, 6:][:, free], K[:, 6:] @ left, rcond=None)[0]
    # The speed is the largest over the closure's axes, which the rod carries.
    speed = np.abs(resolve(four_bar(), FOUR_BAR).state.rotation[0, 2].T @ K[:, 6:] @ left).max()
    parts = '"rod–rocker"', f"{speed:.3g} m/s"
    refused(
        SceneError,
        parts,
        resolve,
        four_bar(strike=swinging(**rates), joints=Joints(locked=locked)),
        FOUR_BAR,
    )


@pytest.mark.parametrize(("name", "joint"), [("five_bar", "front_hip"), ("five_bar", "rear_hip")])
def test_postures_beside_a_landing_have_its_number_of_independent_rows(name, joint):
    """It is that of the same search started from each of them; and loops stay closed on the way
    there.
    """
    landing = resolve(case := scene(name), robot_of(case))
    value = landing.robot.joint(joint).value(landing.q)
    beside = varied_landings(
        case, {joint: np.degrees(value + np.array([-2e-3, 1e-4, 2e-3]))}, robot=landing.robot
    )
    Q = np.array([resolve(*beside.case(row)).q for row in range(3)])
    state = dynamics(landing.robot, Q)
    blocks = landing.rows(state)
    beside, anew = (
        landing.row_limits(state, blocks),
        landing.mechanism.row_limits(blocks, state),
    )
    for k in range(3):
        assert (
            beside(k)[0]
            == anew(k)[0]
            == landing.row_limits(landing.state, landing.rows(landing.state))(0)[0]
        )
        assert beside(k)[1] == pytest.approx(anew(k)[1], rel=0.1)
    assert all(np.abs(closure_gap(state, loop)).max() < 1e-9 for loop in landing.loops)
