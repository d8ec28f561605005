"""Loops and coupled joints: rows added to the equation, independent coordinates (Eq. 7), and postures in which loops meet."""

import dataclasses

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from commands import good, run
from robot_texts import body, joint, link, mjcf, urdf
from trees import known_robot, robot_from

from shockpc.core.impulse import solve_impact
from shockpc.errors import SceneError
from shockpc.model.closure import Closure, Place, closure_block, closure_gap, loop_of
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.freedom import freedom
from shockpc.model.posture import Posture
from shockpc.model.rows import row_jacobian
from shockpc.model.transmission import Joints
from shockpc.paper.landings import land, robot_of, scene
from shockpc.paper.scenes import find_scene
from shockpc.profile import shock_profile
from shockpc.scene import Scene, Strike
from shockpc.setting import complete, setting_of

DIGITS = 1e-12


def nullspace(K):
    """Columns that span what rows K allow; rows may repeat."""
    _, s, Vt = np.linalg.svd(K)
    rank = int(np.sum(s > 1e-9 * s[0]))
    return Vt[rank:].T, rank


def both_ways(found, robot):
    """Δq̇ of a scene by Eq. 4 with every tie as a row, and by Eq. 7 with every tie as columns; and how many ties are independent."""
    setting = setting_of(complete(found, robot), robot)
    H = setting.state.H[0] + np.diag(setting.drives.armature)
    J = row_jacobian(setting.state, setting.rows.W)[0]
    b = setting.rows.b[0]
    contacts = setting.rows.slices[len(found.contact) - 1].stop
    ties = [J[contacts:]]
    for mimic in robot.mimics:
        row = np.zeros((1, robot.model.nv))
        row[0, robot.model.joints[robot.model.getJointId(mimic.joint)].idx_v] = 1.0
        row[0, robot.model.joints[robot.model.getJointId(mimic.leader)].idx_v] -= mimic.multiplier
        ties.append(row)
    K = np.concatenate(ties)
    G, rank = nullspace(K)
    rows = solve_impact(H, np.concatenate([J[:contacts], K]), np.concatenate([b[:contacts], np.zeros((len(K), b.shape[1]))]))
    columns = solve_impact(G.T @ H @ G, J[:contacts] @ G, b[:contacts])
    return rows.delta_qd, G @ columns.delta_qd, rank


CRANK = Place(frame="rod", offset=(0.0, 0.0, -0.3))
FOUR_BAR = urdf(
    link("ground"),
    link("crank"),
    link("rod"),
    link("rocker"),
    joint(
        "a", "ground", "crank", axis="0 -1 0", more='<origin xyz="0.1 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>'
    ),
    joint("b", "crank", "rod", axis="0 -1 0", more='<origin xyz="0 0 -0.2"/><limit lower="-3" upper="3" effort="1" velocity="1"/>'),
    joint(
        "c",
        "ground",
        "rocker",
        axis="0 -1 0",
        more='<origin xyz="-0.15 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>',
    ),
    name="four_bar",
)
LOOP = Closure(a=CRANK, b=Place(frame="rocker", offset=(0.0, 0.0, -0.35)))
BENT = Posture(joints_deg={"a": 40.0, "b": -60.0, "c": 10.0})
FALL = Strike(velocity=(0.4, 0.0, -1.0))


def four_bar(**changes):
    given = {
        "robot": "four_bar.urdf", "contact": (Contact(frame="rocker", offset=(0.0, 0.0, -0.35)),), "closure": (LOOP,),
        "assemble": ("b", "c"), "posture": BENT, "strike": FALL,
    }  # fmt: skip
    return Scene(**(given | changes))


def chain_of_followers():
    follow = '<mimic joint="{}" multiplier="{}" offset="{}"/><limit lower="-3" upper="3" effort="1" velocity="1"/>'
    place = '<origin xyz="0.05 0.02 -0.3" rpy="0.1 0.2 0.3"/>'
    joints = [
        joint("j1", "a", "b", more=place + '<limit lower="-3" upper="3" effort="1" velocity="1"/>'),
        joint("j2", "b", "c", axis="0.3 1 0", more=place + follow.format("j1", -1.5, 0.2)),
        joint("j3", "c", "d", axis="0 1 0.4", more=place + follow.format("j2", 0.5, -0.1)),
    ]
    return urdf(*map(link, "abcd"), *joints, name="followers")


CASES = {
    "four-bar": lambda: (four_bar(), robot_from(FOUR_BAR)),
    "Skippy": lambda: (scene("fig3"), robot_of(scene("fig3"))),
    "five-bar": lambda: (scene("five_bar"), robot_of(scene("five_bar"))),
    "mimic chain": lambda: (
        Scene(
            robot="f.urdf", contact=(Contact(frame="d", offset=(0.1, 0.0, -0.2)),), posture=Posture(joints={"j1": 0.4}), strike=FALL
        ),
        robot_from(chain_of_followers()),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_rows_and_independent_coordinates_agree(name):
    """Section 3.1.1: stacking the ties under the contacts, or leaving dependent velocities out, is the same impact."""
    found, robot = CASES[name]()
    rows, columns, _ = both_ways(found, robot)
    profile = shock_profile(found, robot)
    size = np.abs(rows).max()
    np.testing.assert_allclose(rows, columns, rtol=0.0, atol=DIGITS * size)
    np.testing.assert_allclose(profile.delta_qd, rows[:, -1], rtol=0.0, atol=DIGITS * size)


def test_a_planar_loop_closed_by_a_point_in_space_repeats_a_row():
    """Two of the three rows of a planar closure are independent; that is normal, and the rank is told."""
    for found, robot in (CASES["four-bar"](), CASES["Skippy"](), CASES["five-bar"]()):
        _, _, ties = both_ways(found, robot)
        profile = shock_profile(found, robot)
        assert ties == 2
        assert (profile.health.rank, profile.health.rows) == (5, 6)
        assert not profile.health.warnings


def test_directions_leave_the_repeated_row_out():
    one = shock_profile(four_bar(), robot_from(FOUR_BAR))
    other = shock_profile(four_bar(closure=(dataclasses.replace(LOOP, directions=("x", "z")),)), robot_from(FOUR_BAR))
    assert (other.health.rank, other.health.rows) == (5, 5)
    np.testing.assert_allclose(other.delta_qd, one.delta_qd, rtol=0.0, atol=1e-12 * np.abs(one.delta_qd).max())


def test_the_ends_of_a_loop_stay_together():
    """Both ends of the closure have one velocity after the impact, whatever was asked of the contact."""
    for e in (0.0, 0.7):
        found = four_bar(contact=(Contact(frame="rocker", offset=(0.0, 0.0, -0.35), restitution=e),))
        profile = shock_profile(found, robot_from(FOUR_BAR))
        ends = []
        for place in (LOOP.a, LOOP.b):
            i = profile.bodies.index(place.frame)
            ends.append(profile.rotation[i] @ (profile.delta_v[i] + np.cross(profile.delta_omega[i], place.offset)))
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
        np.testing.assert_allclose(ends[1], -(1.0 + e) * np.array([0.4, 0.0, -1.0]), atol=1e-12)


def test_an_open_loop_is_another_robot():
    """Ignoring the loop changes what the base feels: a closure is never dropped in silence."""
    robot = robot_from(FOUR_BAR)
    closed = shock_profile(four_bar(), robot)
    values = dict(zip("abc", map(float, closed.q[7:]), strict=True))
    opened = shock_profile(four_bar(closure=(), assemble=(), posture=Posture(joints=values)), robot)
    assert opened.assembly is None
    assert abs(closed.shock_com[0] / opened.shock_com[0] - 1.0) > 0.05


def test_a_frame_closure_welds_two_bodies():
    """A closure of kind "frame" between a rod and the link that it hangs on is a locked joint."""
    robot = robot_from(FOUR_BAR)
    hand = Contact(frame="rod", offset=(0.0, 0.0, -0.3))
    here = setting_of(complete(four_bar(closure=(), assemble=()), robot), robot).state
    turned = here.rotation[0, 1].T @ (here.position[0, 2] - here.position[0, 1])
    weld = Closure(a=Place(frame="crank", offset=tuple(map(float, turned))), b=Place(frame="rod"), kind="frame")
    posture = Posture(joints_deg={"a": 40.0, "b": 0.0, "c": 10.0})
    welded = shock_profile(four_bar(closure=(weld,), contact=(hand,), assemble=("b",), posture=posture), robot)
    locked = shock_profile(four_bar(closure=(), contact=(hand,), assemble=(), posture=posture, joints=Joints(locked=("b",))), robot)
    np.testing.assert_allclose(welded.delta_v, locked.delta_v, atol=1e-12)
    np.testing.assert_allclose(welded.delta_omega, locked.delta_omega, atol=1e-12)
    assert welded.health.rank == 3 + 1


# Followers


def test_followers_stand_where_their_leader_puts_them():
    """q₂ = −1.5 q₁ + 0.2 and q₃ = 0.5 q₂ − 0.1, through the chain."""
    found, robot = CASES["mimic chain"]()
    q = shock_profile(found, robot).q[7:]
    np.testing.assert_allclose(q, [0.4, -1.5 * 0.4 + 0.2, 0.5 * (-1.5 * 0.4 + 0.2) - 0.1], atol=1e-15)


def test_followers_move_as_their_leader_does():
    found, robot = CASES["mimic chain"]()
    j1, j2, j3 = shock_profile(found, robot).delta_qd[6:]
    np.testing.assert_allclose((j2, j3), (-1.5 * j1, -0.75 * j1), rtol=1e-12)


# MJCF against MuJoCo itself


def tied_with_refs(inside, q_ref, s_ref):
    """The same chains, where the file draws the bodies at joint values other than zero."""
    return tied(inside, {"q": q_ref, "s": s_ref})


def tied(inside, refs=(), **qpos):
    """An MJCF of two chains on a trunk that turns, with an equality between them; its robot and its MuJoCo model in one posture."""
    left = body("b1", joints='<joint name="p" axis="0 1 0"/>').replace(
        "</body>", body("b2", joints='<joint name="q" axis="1 1 0"/>') + "</body>"
    )
    right = body("c1", joints='<joint name="r" axis="0.2 1 0"/>', at='pos="0.1 0 0"').replace(
        "</body>", body("c2", joints='<joint name="s" axis="0 1 0.5"/>') + "</body>"
    )
    trunk = body("trunk", joints='<joint name="t" axis="0 1 0"/>').replace("</body>", left + right + "</body>")
    text = mjcf(trunk, '<compiler angle="radian"/>', f"<equality>{inside}</equality>")
    for name, ref in dict(refs).items():
        text = text.replace(f'<joint name="{name}" ', f'<joint name="{name}" ref="{ref}" ')
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for name, value in qpos.items():
        data.joint(name).qpos[0] = value
    mujoco.mj_forward(model, data)
    return robot_from(text, ".xml"), model, data


def equality_rows(model, data):
    """MuJoCo's own Jacobian of its equalities (n, nv)."""
    rows = np.asarray(data.efc_J).reshape(-1, model.nv) if data.efc_J.size == data.nefc * model.nv else None
    if rows is None:
        rows = np.zeros((data.nefc, model.nv))
        mujoco.mju_sparse2dense(rows, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    return rows[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]


def row_space(K):
    """The projector onto the span of rows, which is all that matters of them."""
    _, s, Vt = np.linalg.svd(K, full_matrices=False)
    kept = Vt[s > 1e-9 * s[0]]
    return kept.T @ kept


@pytest.mark.parametrize(
    ("tie", "rank"),
    [
        ('<connect body1="b2" body2="c2" anchor="0.05 0.02 -0.1"/>', 3),
        ('<connect body1="b2" anchor="0.05 0.02 -0.1"/>', 3),
        ('<weld body1="b2" body2="c2"/>', 4),
    ],
    ids=["connect", "connect to the world", "weld"],
)
def test_mjcf_loops_are_mujocos(tie, rank):
    """The rows of connect and weld span what MuJoCo's own constraint Jacobian spans, in the posture the file starts in."""
    robot, model, data = tied(tie)
    (loop,) = robot.loops
    state = dynamics(robot, np.array(data.qpos)[None])
    assert np.abs(closure_gap(state, loop)).max() < 1e-12
    ours = row_jacobian(state, closure_block(state, loop).W)[0]
    theirs = equality_rows(model, data)
    assert np.linalg.matrix_rank(theirs, 1e-9) == rank
    np.testing.assert_allclose(row_space(ours), row_space(theirs), atol=1e-9)


def test_mjcf_joint_equalities_are_mujocos():
    """q₁ follows q₂ in proportion: MuJoCo's row is zero on every column of G."""
    robot, model, data = tied('<joint joint1="q" joint2="s" polycoef="0.1 -0.7 0 0 0"/>', q=0.1 - 0.7 * 0.3, s=0.3)
    G = freedom(robot, "fixed", None, np.eye(3)[None], np.zeros(5, dtype=bool))
    assert G is not None
    K = equality_rows(model, data)
    assert K.shape == (1, 5)
    np.testing.assert_allclose(K @ G[0], 0.0, atol=1e-15)
    assert G.shape[2] == 4


REFS = {"": (0.0, 0.0), "both": (0.4, -0.25), "follower": (0.4, 0.0), "leader": (0.0, -0.25)}


@pytest.mark.parametrize("refs", REFS)
@pytest.mark.parametrize("polycoef", ["0.1 -0.7 0 0 0", "0 1 0 0 0", "-0.3 2.5 0 0 0"])
def test_joint_equalities_count_from_where_the_file_starts(refs, polycoef):
    """MuJoCo couples q1 − q1₀ with q2 − q2₀, and q₀ is a joint's ref: where our follower stands, MuJoCo's residual is zero."""
    robot, model, data = tied_with_refs(f'<joint joint1="q" joint2="s" polycoef="{polycoef}"/>', *REFS[refs])
    scene = Scene(robot="m", contact=(Contact(frame="c2", offset=(0.1, 0.0, -0.2)),), posture=Posture(joints={"s": 0.3}))
    q = shock_profile(scene, robot).q
    for name in "tpqrs":
        data.joint(name).qpos[0] = q[robot.model.joints[robot.model.getJointId(name)].idx_q]
    mujoco.mj_forward(model, data)
    residual = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    np.testing.assert_allclose(residual, [0.0], atol=1e-15)
    (mimic,) = robot.mimics
    assert data.joint("s").qpos[0] == 0.3
    assert mimic.multiplier == float(polycoef.split()[1])


@pytest.mark.parametrize("ref", [0.0, 0.4])
def test_a_joint_equality_without_a_leader_holds_the_joint(ref):
    """A constant: q1 = q1₀ + a0, and the joint does not move."""
    robot, model, data = tied_with_refs('<joint joint1="q" polycoef="0.1 0.9 0 0 0"/>', ref, 0.0)
    profile = shock_profile(Scene(robot="m", contact=(Contact(frame="b2", offset=(0.1, 0.0, -0.2)),)), robot)
    index = robot.model.joints[robot.model.getJointId("q")]
    data.joint("q").qpos[0] = profile.q[index.idx_q]
    mujoco.mj_forward(model, data)
    assert profile.q[index.idx_q] == pytest.approx(ref + 0.1, abs=1e-15)
    assert data.efc_pos[0] == pytest.approx(0.0, abs=1e-15)
    assert profile.delta_qd[index.idx_v] == 0.0


# Closing the posture


def test_the_posture_is_projected_onto_the_loop():
    """The gap before, the joints that moved and by how much; the ones that may not move do not."""
    robot = robot_from(FOUR_BAR)
    profile = shock_profile(four_bar(), robot)
    setting = setting_of(complete(four_bar(), robot), robot)
    loop = loop_of(robot, LOOP)
    before = np.array(setting.q)
    before[7:] = np.radians([40.0, -60.0, 10.0])
    assert profile.assembly.gap == pytest.approx(np.abs(closure_gap(dynamics(robot, before[None]), loop)).max(), rel=1e-12)
    assert np.abs(closure_gap(setting.state, loop)).max() < 1e-12
    moved = pin.difference(robot.model, before, setting.q)
    assert moved[6] == 0.0
    assert dict(profile.assembly.moved) == pytest.approx({"b": abs(moved[7]), "c": abs(moved[8])}, rel=1e-9)


def test_a_posture_that_meets_already_is_left_alone():
    robot = robot_from(FOUR_BAR)
    closed = shock_profile(four_bar(), robot)
    values = dict(zip("abc", map(float, closed.q[7:]), strict=True))
    again = shock_profile(four_bar(posture=Posture(joints=values)), robot)
    assert again.assembly.gap < 1e-12
    assert again.assembly.moved == ()


def test_without_assemble_all_joints_move_that_the_posture_does_not_set():
    robot = robot_from(FOUR_BAR)
    profile = shock_profile(four_bar(assemble=(), posture=Posture(joints_deg={"a": 40.0})), robot)
    assert {name for name, _ in profile.assembly.moved} == {"b", "c"}


def test_a_loop_that_cannot_close_says_by_how_much():
    with pytest.raises(SceneError) as refusal:
        shock_profile(
            four_bar(closure=(dataclasses.replace(LOOP, b=Place(frame="rocker", offset=(0.0, 0.0, -0.9))),)), robot_from(FOUR_BAR)
        )
    # Crank and rod are 0.5 m long together at most, the rocker's end 0.9 m away from its axis, 0.25 m beside the crank's.
    text = str(refusal.value)
    assert text.startswith('closure "rod–rocker" cannot be closed: its ends stay ')
    assert text.endswith(
        'mm apart; joints that may move: "b", "c"; let others move with --assemble, '
        "or start from joint values nearer to the closed loop"
    )
    assert 100.0 < float(text.split("stay ")[1].split(" mm")[0]) < 700.0


def test_the_command_line_says_which_joints_close_the_loop(capfd):
    out = good(capfd, "analyze", find_scene("five_bar"), "--assemble", "rear_knee", "--assemble", "front_knee")
    assert "loops closed from a gap of 3.77 mm: front_knee by 0.0115, rear_knee by 0.0115" in out
    outcome = run(capfd, "analyze", find_scene("five_bar"), "--assemble", "rear_knee")
    assert outcome.code == 2
    assert 'closure "toe–rear_end" cannot be closed: its ends stay' in outcome.err


@pytest.mark.parametrize(
    ("closure", "message"),
    [
        (
            Closure(a=Place(frame="rod"), b=Place(frame="rod")),
            'closure "rod–rod" holds body "rod" to itself, which closes no loop; name frames on two bodies',
        ),
        (
            Closure(a=Place(frame="rod"), b=Place(frame="rocker"), directions=((0.0, 0.0, 0.0),)),
            'closure "rod–rocker" has a direction without a length; valid are "x", "y", "z" and vectors',
        ),
        (
            Closure(a=Place(frame="rod"), b=Place(frame="rocker"), directions=()),
            'closure "rod–rocker" keeps no direction, so nothing stops it; valid are "x", "y", "z" and vectors',
        ),
        (
            Closure(a=Place(frame="rodd"), b=Place(frame="rocker")),
            'no frame "rodd" in robot "four_bar"; nearest: "rod", "ground". To list them: shockpc robots',
        ),
    ],
    ids=["to itself", "no length", "no direction", "no frame"],
)
def test_a_closure_that_makes_no_sense_is_refused(closure, message):
    with pytest.raises(Exception) as refusal:  # noqa: PT011 - the whole text is compared
        shock_profile(four_bar(closure=(closure,)), robot_from(FOUR_BAR))
    assert str(refusal.value).startswith(message)


def test_rates_that_tear_a_loop_open_are_refused():
    with pytest.raises(
        SceneError, match=r'^the joint velocities open closure "rod–rocker" at .* m/s; give rates that the loop allows'
    ):
        shock_profile(four_bar(strike=Strike(velocity=(0.0, 0.0, -1.0), joint_velocities={"a": 1.0})), robot_from(FOUR_BAR))


def test_a_loop_does_not_care_where_the_tree_is_cut():
    """Cutting Skippy's drive at its crank pin or at its rod's end, the same robot lands."""
    found = scene("fig3")
    whole = land(found)
    assert known_robot("skippy").mass == pytest.approx(whole.robot.mass)
    swapped = dataclasses.replace(
        found, closure=(dataclasses.replace(found.closure[0], a=found.closure[0].b, b=found.closure[0].a),)
    )
    np.testing.assert_allclose(land(swapped).delta_qd, whole.delta_qd, atol=1e-12 * np.abs(whole.delta_qd).max())
