"""Loops and coupled joints: rows added to the equation, independent coordinates (Eq. 7), and postures in which loops meet."""

import dataclasses

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from commands import good, run
from robot_texts import BODY, LIMIT, body, joint, link, mjcf, urdf
from trees import known_robot, robot_from

from shockpc.core.impulse import solve_impact
from shockpc.errors import RobotError, SceneError
from shockpc.landing import complete, resolve
from shockpc.model.closure import Closure, Place, closure_block, closure_gap, loop_of
from shockpc.model.columns import freedom
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture, configuration
from shockpc.model.rows import row_jacobian
from shockpc.paper.landings import land, robot_of, scene
from shockpc.paper.scenes import find_scene
from shockpc.profile import shock_profile
from shockpc.robot.couplings import Mimic
from shockpc.scene import Scene, Strike
from shockpc.show.tables.design import balance_lines

DIGITS = 1e-12


def nullspace(K):
    """Columns that span what rows K allow; rows may repeat."""
    _, s, Vt = np.linalg.svd(K)
    rank = int(np.sum(s > 1e-9 * s[0]))
    return Vt[rank:].T, rank


def both_ways(found, robot):
    """Δq̇ of a scene by Eq. 4 with every tie as a row, and by Eq. 7 with every tie as columns; and how many ties are independent."""
    landing = resolve(complete(found, robot), robot)
    H = landing.state.H[0] + np.diag(landing.drives.armature)
    J = row_jacobian(landing.state, landing.rows.W)[0]
    b = landing.rows.b[0]
    contacts = landing.rows.slices[len(found.contact) - 1].stop
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


SLOT = urdf(
    link("base"),
    link("bar"),
    link("slider"),
    joint("j1", "base", "bar", axis="0 -1 0", more=LIMIT),
    joint("j2", "base", "slider", axis="0 -1 0", more='<origin xyz="0.2 0 -0.3"/>' + LIMIT),
    name="slot",
)


@pytest.mark.parametrize("bodies", [(1, 2), (2, 1), (0, 2), (-1, 1), (1, -1)])
def test_rows_of_a_closure_are_the_rate_of_its_gap(bodies):
    """Also where the ends are apart along an axis that is left free, and while a loop is still open: held against differences."""
    robot = robot_from(SLOT)
    ends = {"a": Place(frame="bar", offset=(0.1, 0.2, 0.4)), "b": Place(frame="slider", offset=(-0.3, 0.1, -0.2))}
    loop = loop_of(robot, Closure(**ends, directions=("x", (0.3, -0.5, 0.8))))._replace(bodies=bodies)
    rng = np.random.default_rng(3)
    q = pin.integrate(robot.model, pin.neutral(robot.model), rng.normal(size=robot.model.nv))
    K = row_jacobian(dynamics(robot, q[None]), closure_block(dynamics(robot, q[None]), loop).W)[0]
    h = 1e-6
    for column, step in zip(K.T, np.eye(robot.model.nv), strict=True):
        after, before = (
            closure_gap(dynamics(robot, pin.integrate(robot.model, q, by)[None]), loop)[0] for by in (h * step, -h * step)
        )
        np.testing.assert_allclose(column, (after - before) / (2.0 * h), atol=1e-8)


def test_a_slot_is_the_same_wherever_its_origin_lies_along_it():
    """A pin in a slot: the slot's frame moved along the slot changes no number, and the momentum is what the contact gave."""
    robot = robot_from(SLOT)
    posture = Posture(joints={"j1": float(np.arctan2(-0.3, 0.2)), "j2": 0.2})
    tip = Contact(frame="slider", offset=(0.4, 0.0, -0.1))
    found = []
    for along in (0.0, 0.1, float(np.hypot(0.2, 0.3)), 1.0):
        slot = Closure(a=Place(frame="bar", offset=(along, 0.0, 0.0)), b=Place(frame="slider"), directions=("z",))
        profile = shock_profile(Scene(robot="slot.urdf", contact=(tip,), closure=(slot,), posture=posture), robot)
        found.append(np.concatenate([profile.delta_omega, profile.delta_v]))
        moment, (contact,) = np.zeros(3), profile.contacts
        for i, one in enumerate(profile.robot.bodies):
            R, omega = profile.rotation[i], profile.delta_omega[i]
            momentum = R @ (one.mass * (profile.delta_v[i] + np.cross(omega, one.com)))
            moment += np.cross(profile.position[i] + R @ one.com, momentum) + R @ one.inertia @ omega
        np.testing.assert_allclose(moment, np.cross(contact.point, contact.impulse), atol=1e-12)
    np.testing.assert_allclose(found[1:], np.broadcast_to(found[0], (3, *found[0].shape)), atol=1e-11)


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
    here = resolve(complete(four_bar(closure=(), assemble=()), robot), robot).state
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


def chains(inside, refs=(), default=""):
    """An MJCF of two chains on a trunk that turns, with equalities between them."""
    left = body("b1", joints='<joint name="p" axis="0 1 0"/>').replace(
        "</body>", body("b2", joints='<joint name="q" axis="1 1 0"/>') + "</body>"
    )
    right = body("c1", joints='<joint name="r" axis="0.2 1 0"/>', at='pos="0.1 0 0"').replace(
        "</body>", body("c2", joints='<joint name="s" axis="0 1 0.5"/>') + "</body>"
    )
    trunk = body("trunk", joints='<joint name="t" axis="0 1 0"/>').replace("</body>", left + right + "</body>")
    before = f'<compiler angle="radian"/><default>{default}</default>'
    text = mjcf(trunk, before, f"<equality>{inside}</equality>")
    for name, ref in dict(refs).items():
        text = text.replace(f'<joint name="{name}" ', f'<joint name="{name}" ref="{ref}" ')
    return text


def tied(inside, refs=(), default="", **qpos):
    """Such chains: the robot, and its MuJoCo model in one posture."""
    text = chains(inside, refs, default)
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


OFF_AXIS = 'pos="0.05 0.02 0.1" ref="0.3"'
HINGED = f'<joint name="t" axis="0 1 0" {OFF_AXIS}/>'
SCENERY = (
    '<body name="post" pos="0.5 0.1 0.2" euler="0.1 0.2 0.3"><geom size="0.1"/><site name="on_post" pos="0.1 0 0"/>'
    '<body name="branch" pos="0 0.3 0.1" euler="0 0.2 0"><site name="on_branch" pos="0.1 0 0"/></body></body>'
    '<site name="in_world" pos="0.3 0.2 0.1" euler="0.2 0 0.1"/>'
)


def amid_scenery(tie, base, after=""):
    """An MJCF of two chains with feet, whose joints lie off their bodies' origins, beside a post; its robot and MuJoCo's model."""
    foot = body("foot", BODY + '<site name="on_foot" pos="0 0.1 0.1" euler="0.3 0 0.2"/>', "", 'pos="0.1 0 -0.1" euler="0 0.4 0.2"')
    left = body("b", BODY + foot, f'<joint name="p" axis="1 1 0" {OFF_AXIS}/>', 'pos="0.3 0.1 -0.2" euler="0.3 0.2 0.1"')
    toe = body("toe", BODY, "", 'pos="0.1 0.15 -0.1" euler="0.2 0.4 0.2"')
    inside = BODY + '<site name="on_c" pos="0.1 0.1 0"/>' + toe
    right = body("c", inside, f'<joint name="r" axis="0 1 0.5" {OFF_AXIS}/>', 'pos="0.1 -0.2 0"')
    trunk = body("trunk", BODY + left + right, base, 'pos="0.3 0.1 1.2" euler="0.4 0.5 0.6"')
    text = mjcf(SCENERY + trunk, '<compiler angle="radian"/>', f"<equality>{tie}</equality>{after}")
    return robot_from(text, ".xml"), mujoco.MjModel.from_xml_string(text)


HELD = 'anchor="0.05 0.02 -0.1"'
POSE = 'relpose="0.3 0.1 0.35 0.98 0.1 0.2 0"'
ENDS = ("b c", "foot toe", "b post", "post b", "branch foot", "b branch", "b world", "world foot")
PLACES = ("on_c", "on_post", "on_branch", "in_world")
HOLDS = {"connect": (HELD,), "weld": ("", HELD, POSE, f"{POSE} {HELD}")}
TIES = (
    f'<connect body1="foot" {HELD}/>',
    *(
        f'<{kind} body1="{ends.split()[0]}" body2="{ends.split()[1]}" {how}/>'
        for kind, hows in HOLDS.items()
        for how in hows
        for ends in ENDS
    ),
    *(f'<{kind} site1="on_foot" site2="{place}"/>' for kind in HOLDS for place in PLACES),
)


@pytest.mark.parametrize("base", [HINGED, "<freejoint/>"], ids=["fixed base", "free base"])
@pytest.mark.parametrize("tie", TIES)
def test_ties_are_mujocos_wherever_they_hold(tie, base):
    """On bodies without joints, on joints off the origin, on what cannot move: MuJoCo's rows, and MuJoCo's gap."""
    robot, model = amid_scenery(tie, base)
    data, (loop,) = mujoco.MjData(model), robot.loops
    for bent in (0.0, 0.1):
        data.qpos[:] = model.qpos0
        data.qpos[-2:] += bent, -2.0 * bent
        mujoco.mj_forward(model, data)
        q, theirs = np.array(data.qpos), equality_rows(model, data)
        if robot.free_base:
            # MuJoCo counts the base's linear velocity in the world's axes, and quaternions from w on.
            q[3:7] = q[[4, 5, 6, 3]]
            theirs[:, :3] = theirs[:, :3] @ data.body("trunk").xmat.reshape(3, 3)
        state = dynamics(robot, q[None])
        ours, gap, a = row_jacobian(state, closure_block(state, loop).W)[0], closure_gap(state, loop)[0], loop.bodies[0]
        if a >= 0:
            # While a loop is open, its gap in axes that turn with the first body changes by that turning too.
            open_by = state.rotation[0, a] @ loop.rotations[0] @ gap[:3]
            theirs[:3] -= np.cross((state.J[0, :3] * state.moves[a]).T, open_by).T
        np.testing.assert_allclose(row_space(ours), row_space(theirs), atol=1e-9)
        residual = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
        turned = np.sin(np.linalg.norm(gap[3:]) / 2.0)  # the vector of a quaternion is so long
        assert np.linalg.norm(gap[:3]) == pytest.approx(np.linalg.norm(residual[:3]), abs=1e-12)
        assert turned == pytest.approx(np.linalg.norm(residual[3:]), abs=1e-12)


def test_a_base_tied_to_the_world_starts_where_it_is_drawn():
    """There the loop meets; a keyframe with the base in that place meets as well, and other robots start at the origin."""
    drawn = " ".join(map(str, amid_scenery("", "<freejoint/>")[1].qpos0))
    key = f'<keyframe><key name="home" qpos="{drawn}"/></keyframe>'
    robot, model = amid_scenery(f'<connect body1="foot" body2="post" {HELD}/>', "<freejoint/>", key)
    for reference in ("neutral", "home"):
        q = configuration(robot, Posture(reference=reference))
        np.testing.assert_allclose(q[:7], model.qpos0[[0, 1, 2, 4, 5, 6, 3]], atol=1e-12)
    assert np.abs(closure_gap(dynamics(robot, q[None]), robot.loops[0])).max() < 1e-12
    loose, _ = amid_scenery(f'<connect body1="foot" body2="toe" {HELD}/>', "<freejoint/>")
    np.testing.assert_array_equal(configuration(loose, Posture()), pin.neutral(loose.model))


@pytest.mark.parametrize("tie", [f'<connect body1="foot" body2="b" {HELD}/>', '<weld body1="post"/>'])
def test_what_is_fixed_already_is_not_tied(tie):
    """MuJoCo's rows of such an equality are zero, and here there are none."""
    robot, model = amid_scenery(tie, HINGED)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(equality_rows(model, data), 0.0, atol=1e-15)
    assert robot.loops == ()


@pytest.mark.parametrize(
    ("tie", "told"),
    [
        (
            f'<connect body1="foot" body2="pole" {HELD}/>',
            "MuJoCo cannot compile it: unknown element 'pole' in equality constraint 0",
        ),
        ('<weld site1="on_foot" site2="post"/>', "MuJoCo cannot compile it: unknown element 'post' in equality constraint 0"),
        (
            '<joint joint1="p" joint2="t"/>',
            "MuJoCo cannot compile it: only HINGE and SLIDE joint allowed in constraint",
        ),
    ],
)
def test_ties_of_what_cannot_be_tied_are_refused(tie, told):
    """MuJoCo says which body, site or joint it is."""
    with pytest.raises(RobotError) as caught:
        amid_scenery(tie, '<joint name="t" type="ball"/>')
    assert str(caught.value) == f"robot.xml: {told}"


def test_mjcf_joint_equalities_are_mujocos():
    """q₁ follows q₂ in proportion: MuJoCo's row is zero on every column of G."""
    robot, model, data = tied('<joint joint1="q" joint2="s" polycoef="0.1 -0.7 0 0 0"/>', q=0.1 - 0.7 * 0.3, s=0.3)
    G = freedom(robot, "fixed", None, np.eye(3)[None], np.zeros(5, dtype=bool))
    assert G is not None
    K = equality_rows(model, data)
    assert K.shape == (1, 5)
    np.testing.assert_allclose(K @ G[0], 0.0, atol=1e-15)
    assert G.shape[2] == 4


CHAINED = '<joint joint1="q" joint2="s" polycoef="0.1 -0.7 0 0 0"/>{}'
LED = '<joint joint1="p" joint2="q" polycoef="-0.2 2 0 0 0"/>'


@pytest.mark.parametrize(
    ("tie", "left"),
    [
        (CHAINED.format(LED), 3),
        (LED + CHAINED.format(""), 3),
        (CHAINED.format('<joint joint1="s" polycoef="0.3 0 0 0 0"/>'), 3),
        (CHAINED.format('<joint joint1="r" joint2="q" polycoef="0.1 0.5 0 0 0"/>' + LED), 2),
        (CHAINED.format('<joint joint1="p" joint2="s" polycoef="0 3 0 0 0"/>'), 3),
    ],
    ids=["followed", "followed, in the other order", "of a joint that holds", "by two", "of one leader"],
)
def test_followers_that_lead_are_mujocos(tie, left):
    """In whichever order the file says it: MuJoCo's rows are zero on G, and its residuals where the followers stand."""
    robot, model, data = tied(tie)
    q = configuration(robot, Posture())
    for name in "tpqrs":
        data.joint(name).qpos[0] = q[robot.model.joints[robot.model.getJointId(name)].idx_q]
    mujoco.mj_forward(model, data)
    G = freedom(robot, "fixed", None, np.eye(3)[None], np.zeros(5, dtype=bool))
    assert G is not None
    assert G.shape[2] == left
    np.testing.assert_allclose(equality_rows(model, data) @ G[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY], 0.0, atol=1e-15)


TWICE = '<joint joint1="q" joint2="s" polycoef="0.1 -0.7 0 0 0"/><joint joint1="q" joint2="p" polycoef="0.2 4 0 0 0"{}/>'


def test_of_two_ties_of_a_joint_one_is_turned_round_or_off():
    """The remedies that the refusal gives: MuJoCo's own rows of both, or of the one that is left, are zero on G."""
    with pytest.raises(RobotError, match='two equalities have joint1="q"'):
        tied(TWICE.format(""))
    round_ = TWICE.format("").replace('joint1="q" joint2="p" polycoef="0.2 4', 'joint1="p" joint2="q" polycoef="-0.05 0.25')
    for text, said, left in ((round_, TWICE.format(""), 3), (TWICE.format(' active="false"'), CHAINED.format(""), 4)):
        robot, _, _ = tied(text)
        model = mujoco.MjModel.from_xml_string(chains(said))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        G = freedom(robot, "fixed", None, np.eye(3)[None], np.zeros(5, dtype=bool))
        assert G is not None
        assert G.shape[2] == left
        np.testing.assert_allclose(equality_rows(model, data) @ G[0], 0.0, atol=1e-15)


CONNECT = '<connect body1="b2" body2="c2" anchor="0.05 0.02 -0.1"{}/>'
FOLLOW = '<joint joint1="q" joint2="s" polycoef="0.1 -0.7 0 0 0"{}/>'
WELDED = '<weld body1="b2" body2="c2"{}/>'


@pytest.mark.parametrize(
    ("default", "words", "active"),
    [
        ("", "", True),
        ("", ' active="true"', True),
        ("", ' active="false"', False),
        ('<equality active="false"/>', "", False),
        ('<equality active="false"/>', ' active="true"', True),
        ('<default class="off"><equality active="false"/></default>', "", True),
        ('<default class="off"><equality active="false"/></default>', ' class="off"', False),
        ('<default class="off"><equality active="false"/></default>', ' class="off" active="true"', True),
        ('<equality active="false"/><default class="on"><equality active="true"/></default>', ' class="on"', True),
        ('<equality active="false"/><default class="same"/>', ' class="same"', False),
    ],
)
def test_equalities_that_are_not_active_are_left_out(default, words, active):
    """As MuJoCo says it: by the equality itself, else by its class, else by the class above that."""
    robot, model, _ = tied("".join(tie.format(words) for tie in (CONNECT, FOLLOW, WELDED)), default=default)
    assert model.eq_active0.tolist() == [active] * 3
    assert (len(robot.loops), len(robot.mimics)) == ((2, 1) if active else (0, 0))


SECOND = '<connect{} body1="b2" body2="c2" anchor="0.05 0.32 -0.1"/>'
FIRST = SECOND.replace("0.32", "0.02")


@pytest.mark.parametrize("names", [("", ""), (' name="x"', ""), ("", ' name="equality 0"'), (' name="x"', ' name="y"')])
def test_two_points_between_two_bodies_are_a_hinge(names):
    """Both are there, named or not: their rows span what MuJoCo's do."""
    robot, model, data = tied(FIRST.format(names[0]) + SECOND.format(names[1]))
    assert [loop.name for loop in robot.loops] == ["b2–c2"] * 2
    state = dynamics(robot, np.array(data.qpos)[None])
    ours = np.concatenate([row_jacobian(state, closure_block(state, loop).W)[0] for loop in robot.loops])
    theirs = equality_rows(model, data)
    assert np.linalg.matrix_rank(theirs, 1e-9) > np.linalg.matrix_rank(theirs[:3], 1e-9)
    np.testing.assert_allclose(row_space(ours), row_space(theirs), atol=1e-9)


@pytest.mark.parametrize(
    "tie",
    [
        '<weld{} body1="b2" body2="c2" torquescale="0"/>',
        '<joint{} joint1="q" joint2="s" polycoef="0 1 0.5 0 0"/>',
    ],
)
def test_what_is_not_active_needs_no_remedy(tie):
    """An equality that could not be computed is left out like any other, by its own word or its class's."""
    off = '<default class="off"><equality active="false"/></default>'
    for words in (' active="false"', ' class="off"'):
        robot, _, _ = tied(tie.format(words), default=off)
        assert (robot.loops, robot.mimics) == ((), ())


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
    assert robot.mimics == (Mimic("q", "", 0.0, ref + 0.1),)


# Closing the posture


def test_the_posture_is_projected_onto_the_loop():
    """The gap before, the joints that moved and by how much; the ones that may not move do not."""
    robot = robot_from(FOUR_BAR)
    profile = shock_profile(four_bar(), robot)
    landing = resolve(complete(four_bar(), robot), robot)
    loop = loop_of(robot, LOOP)
    before = np.array(landing.q)
    before[7:] = np.radians([40.0, -60.0, 10.0])
    apart = closure_gap(dynamics(robot, before[None]), loop)[0]
    assert profile.assembly.gap == pytest.approx(np.linalg.norm(apart), rel=1e-12)
    assert np.linalg.norm(apart) > np.abs(apart).max()
    assert profile.assembly.turn == 0.0
    assert np.abs(closure_gap(landing.state, loop)).max() < 1e-12
    moved = pin.difference(robot.model, before, landing.q)
    assert moved[6] == 0.0
    assert min(moved[7:]) < 0.0 < max(moved[7:])
    assert [(name, unit) for name, _, unit in profile.assembly.moved] == [("b", "rad"), ("c", "rad")]
    assert [by for _, by, _ in profile.assembly.moved] == pytest.approx([moved[7], moved[8]], rel=1e-9)


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
    assert {name for name, _, _ in profile.assembly.moved} == {"b", "c"}
    assert {unit for _, _, unit in profile.assembly.moved} == {"rad"}


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


WELD = Closure(a=Place(frame="rod"), b=Place(frame="crank", offset=(0.0, 0.0, -0.2)), kind="frame")
"""Where the rod hangs: its ends meet always, and are turned by joint b."""


def test_a_closure_of_frames_tells_its_turn_beside_its_gap():
    """Degrees and millimetres are not mixed: ends at one place, turned by 60 degrees, are no gap but a turn."""
    profile = shock_profile(four_bar(closure=(WELD,), assemble=("b",)), robot_from(FOUR_BAR))
    assert profile.assembly.gap < 1e-15
    assert profile.assembly.turn == pytest.approx(np.radians(60.0), rel=1e-12)
    ((name, by, unit),) = profile.assembly.moved
    assert (name, unit) == ("b", "rad")
    assert by == pytest.approx(np.radians(60.0), rel=1e-9)
    assert balance_lines(profile)[-1] == f"loops closed from a gap of {1e3 * profile.assembly.gap:.3g} mm and 60 deg: b by 60 deg"


def test_a_closure_of_frames_that_cannot_close_says_by_how_much_it_is_turned():
    with pytest.raises(SceneError) as refusal:
        shock_profile(four_bar(closure=(WELD,), assemble=("c",)), robot_from(FOUR_BAR))
    text = str(refusal.value)
    head = 'closure "rod–crank" cannot be closed: its ends stay '
    assert text.startswith(head)
    apart, _, rest = text.removeprefix(head).partition(" mm apart")
    assert float(apart) < 1e-12
    assert rest == (
        ' and 60 deg turned; joints that may move: "c"; let others move with --assemble, '
        "or start from joint values nearer to the closed loop"
    )


SLIDE = urdf(
    link("ground"),
    link("arm"),
    link("slider"),
    joint("turn", "ground", "arm"),
    joint("slide", "arm", "slider", "prismatic", axis="1 0 0"),
    name="telescope",
)


def test_what_slides_to_close_a_loop_is_told_in_metres():
    """A slider by millimetres, with its sign; a hinge by degrees."""
    robot = robot_from(SLIDE)
    closure = Closure(a=Place(frame="slider"), b=Place(frame="ground", offset=(-0.03, 0.0, 0.04)), directions=("x", "z"))
    posture = Posture(joints={"turn": 0.0, "slide": -0.06})
    landing = Scene(robot="t", contact=(Contact(frame="slider"),), closure=(closure,), assemble=("*",), posture=posture)
    profile = shock_profile(landing, robot)
    # A slider at −50 mm, on an arm that turns the world's −x up by atan(4/3) about +y.
    assert [(name, unit) for name, _, unit in profile.assembly.moved] == [("turn", "rad"), ("slide", "m")]
    assert [by for _, by, _ in profile.assembly.moved] == pytest.approx([np.arctan2(4, 3), 0.01], rel=1e-9)
    assert profile.assembly.gap == pytest.approx(0.05, rel=1e-12)
    assert balance_lines(profile)[-1] == "loops closed from a gap of 50 mm: turn by 53.1 deg, slide by 10 mm"


PARALLEL = urdf(
    link("ground"),
    link("crank"),
    link("rod"),
    link("rocker"),
    joint("a", "ground", "crank", axis="0 -1 0", more='<origin xyz="0.1 0 0"/>' + LIMIT),
    joint(
        "b",
        "crank",
        "rod",
        axis="0 -1 0",
        more='<origin xyz="0 0 -0.2"/><mimic joint="a" multiplier="-1"/>' + LIMIT,
    ),
    joint("c", "ground", "rocker", axis="0 -1 0", more='<origin xyz="-0.1 0 0"/><mimic joint="a"/>' + LIMIT),
    name="parallel",
)
"""A parallelogram, all of whose joints follow one."""


def parallel(reach=0.2, **changes):
    closure = Closure(a=Place(frame="rod", offset=(-0.2, 0.0, 0.0)), b=Place(frame="rocker", offset=(0.0, 0.0, -reach)))
    given = {
        "robot": "p.urdf", "contact": (Contact(frame="rocker", offset=(0.0, 0.0, -0.2)),), "closure": (closure,),
        "posture": Posture(joints_deg={"a": 20.0}),
    }  # fmt: skip
    return Scene(**(given | changes))


def test_followers_are_held_by_their_leader():
    """What follows a joint that may not move cannot close a loop, and is not offered."""
    remedy = "; let others move with --assemble, or start from joint values nearer to the closed loop"
    for posture, listed in ((Posture(joints_deg={"a": 20.0}), "none"), (Posture(), '"a"')):
        with pytest.raises(SceneError) as refusal:
            shock_profile(parallel(0.25, posture=posture), robot_from(PARALLEL))
        assert str(refusal.value) == (
            'closure "rod–rocker" cannot be closed: its ends stay 50 mm apart; joints that may move: ' + listed + remedy
        )


def test_the_command_line_says_which_joints_close_the_loop(capfd):
    out = good(capfd, "analyze", find_scene("five_bar"), "--assemble", "rear_knee", "--assemble", "front_knee")
    assert "\nloops closed from a gap of 4.16 mm: front_knee by -0.659 deg, rear_knee by 0.659 deg\n" in out
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


@pytest.mark.parametrize("again", [LOOP, Closure(a=LOOP.b, b=LOOP.a), dataclasses.replace(LOOP, directions=("y",))])
def test_points_tied_twice_are_refused(again):
    """The same two points once more, in either order and along whatever; a little apart they are another closure."""
    with pytest.raises(SceneError) as refusal:
        shock_profile(four_bar(closure=(LOOP, again)), robot_from(FOUR_BAR))
    assert "tie the same points of the same bodies, so they are one closure; leave one of them out" in str(refusal.value)


def test_two_ties_along_the_axis_of_a_loop_are_two():
    """A hinge made of two points: the same shock as with one, for the loop is planar."""
    y = (0.0, 0.01, 0.0)
    beside = [dataclasses.replace(end, offset=tuple(np.add(end.offset, y).tolist())) for end in (LOOP.a, LOOP.b)]
    two, one = (
        shock_profile(four_bar(closure=closures), robot_from(FOUR_BAR))
        for closures in ((LOOP, Closure(a=beside[0], b=beside[1])), (LOOP,))
    )
    np.testing.assert_allclose(two.shock_com, one.shock_com, atol=1e-12)


def rates_of(found, robot):
    """Joint rates before the impact, and how fast they open the loops [m/s]."""
    landing = resolve(complete(found, robot), robot)
    loops = (*robot.loops, *(loop_of(robot, closure) for closure in found.closure))
    K = np.concatenate([row_jacobian(landing.state, closure_block(landing.state, loop).W)[0] for loop in loops])
    return landing.before.joint_rates, float(np.abs(K @ landing.before.joint_rates).max()), K


def swinging(**joints):
    return Strike(velocity=(0.0, 0.0, -1.0), joint_velocities=joints)


@pytest.mark.parametrize("leader", ["a", "b", "c"])
def test_rates_go_along_the_loop(leader):
    """One rate of a four-bar sets the others; the profile is the one with all of them given."""
    robot = robot_from(FOUR_BAR)
    rates, opening, _ = rates_of(four_bar(strike=swinging(**{leader: 1.3})), robot)
    assert rates["abc".index(leader) + 6] == 1.3
    assert opening < 1e-14
    np.testing.assert_array_equal(rates[:6], 0.0)
    assert np.abs(rates[6:]).min() > 0.1
    one = shock_profile(four_bar(strike=swinging(**{leader: 1.3})), robot)
    every = shock_profile(four_bar(strike=swinging(**dict(zip("abc", map(float, rates[6:]), strict=True)))), robot)
    np.testing.assert_allclose(one.delta_qd, every.delta_qd, atol=1e-12 * np.abs(every.delta_qd).max())
    np.testing.assert_allclose(one.contacts[0].approach, every.contacts[0].approach, atol=1e-13)
    assert np.linalg.norm(one.contacts[0].approach - [0.0, 0.0, -1.0]) > 0.05


def test_rates_that_are_not_given_are_the_least():
    """A loop of five bars leaves one free: of all that closes it, the completion is the shortest; what no loop asks for rests."""
    found = scene("five_bar")
    robot = robot_of(found)
    given = next(name for name in robot.joint_names if name.startswith("rear"))
    found = dataclasses.replace(
        found, strike=dataclasses.replace(found.strike, joint_velocities={given: 2.0}), contact=found.contact
    )
    rates, opening, K = rates_of(found, robot)
    index = robot.model.joints[robot.model.getJointId(given)].idx_v
    assert rates[index] == 2.0
    assert opening < 1e-13
    others = np.array([robot.model.joints[robot.model.getJointId(n)].idx_v for n in robot.joint_names if n != given])
    expected = -np.linalg.pinv(K[:, others], rcond=1e-10) @ K[:, index] * 2.0
    np.testing.assert_allclose(rates[others], expected, atol=1e-12)
    assert len(others) > np.linalg.matrix_rank(K[:, others], 1e-9)


@pytest.mark.parametrize("base", ["free", "planar"])
def test_followers_go_with_their_leader_along_a_loop(base):
    """The one rate of a parallelogram is given; its followers have no rate of their own to complete."""
    rates, opening, _ = rates_of(parallel(base=base, strike=swinging(a=0.7)), robot_from(PARALLEL))
    np.testing.assert_allclose(rates, [0.0] * 6 + [0.7, -0.7, 0.7], atol=1e-15)
    assert opening < 1e-15


def test_locked_joints_do_not_complete_a_loop():
    """A four-bar with a locked joint has no rate at all."""
    with pytest.raises(SceneError, match=r'^the joint velocities open closure "rod–rocker" at '):
        shock_profile(four_bar(strike=swinging(a=1.0), joints=Joints(locked=("b",))), robot_from(FOUR_BAR))


@pytest.mark.parametrize("joints", [{"a": 1.0, "b": 0.2}, {"a": 1.0, "b": 0.2, "c": 0.1}, {"a": 1.0, "c": 0.0}])
def test_rates_that_tear_a_loop_open_are_refused(joints):
    """Only what no completion fits, with the speed that is left; the least of all speeds where others may help."""
    robot = robot_from(FOUR_BAR)
    found = four_bar(strike=swinging(**joints))
    _, _, K = rates_of(four_bar(), robot)
    rates = np.array([joints.get(name, 0.0) for name in "abc"])
    free = [k for k, name in enumerate("abc") if name not in joints]
    if free:
        rates[free] = -np.linalg.lstsq(K[:, 6:][:, free], K[:, 6:] @ rates, rcond=None)[0]
    with pytest.raises(SceneError) as refusal:
        shock_profile(found, robot)
    assert str(refusal.value) == (
        f'the joint velocities open closure "rod–rocker" at {np.abs(K[:, 6:] @ rates).max():.3g} m/s; '
        "give rates that the loop allows, or fewer of them"
    )


def test_a_loop_does_not_care_where_the_tree_is_cut():
    """Cutting Skippy's drive at its crank pin or at its rod's end, the same robot lands."""
    found = scene("fig3")
    whole = land(found)
    assert known_robot("skippy").mass == pytest.approx(whole.robot.mass)
    swapped = dataclasses.replace(
        found, closure=(dataclasses.replace(found.closure[0], a=found.closure[0].b, b=found.closure[0].a),)
    )
    np.testing.assert_allclose(land(swapped).delta_qd, whole.delta_qd, atol=1e-12 * np.abs(whole.delta_qd).max())


def test_a_linkage_by_its_name_alone_is_open_and_says_so(capfd):
    """The file of a robot with a loop is a tree; which scene closes it is told, and the scene itself has nothing to warn of."""
    for name, closed in (("skippy", "fig3"), ("five_bar", "five_bar")):
        foot = scene(closed).contact[0].frame
        said = good(capfd, "analyze", name, "--contact", foot)
        assert "this robot's loop is open here, so its ends dangle; " in said
        assert f"{closed}.toml closes it" in said
        assert "dangle" not in good(capfd, "analyze", find_scene(closed))


def test_joints_to_assemble_without_a_loop_are_told(capfd):
    out = good(capfd, "analyze", "leg", "--contact", "lower_leg", "--assemble", "*")
    assert '"knee" may move to close loops, but nothing closes one, so nothing moved' in out
