"""Equalities of MJCF files (connect, weld, joint, fixed tendon) compared with MuJoCo's constraint
rows and residuals.
"""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import BODY, body, mjcf, refused
from trees import robot_from

from shockpc import Contact, Posture, RobotError, Scene, shock_profile
from shockpc.landing.closure import closure_constraint, closure_gap
from shockpc.landing.posture import configuration
from shockpc.method.constraints import row_jacobian
from shockpc.method.dynamics import dynamics
from shockpc.method.selection_matrix import free_columns
from shockpc.robot.bodies_and_joints import Mimic

EQUALITY = mujoco.mjtConstraint.mjCNSTR_EQUALITY


def chains(inside, default="", **refs):
    """An MJCF of two chains, of joints p, q and r, s, on a trunk that rotates; bodies may be drawn
    at joint values not zero.
    """

    def hinge(name, axis):
        return f'<joint name="{name}" axis="{axis}" ref="{refs.get(name, 0.0)}"/>'

    left = body("b1", BODY + body("b2", joints=hinge("q", "1 1 0")), hinge("p", "0 1 0"))
    right = body(
        "c1",
        BODY + body("c2", joints=hinge("s", "0 1 0.5")),
        hinge("r", "0.2 1 0"),
        'pos="0.1 0 0"',
    )
    trunk = body("trunk", BODY + left + right, hinge("t", "0 1 0"))
    before = f'<compiler angle="radian"/><default>{default}</default>'
    return mjcf(trunk, before, f"<equality>{inside}</equality>")


OFF_AXIS = 'pos="0.05 0.02 0.1" ref="0.3"'
FIXED, FREE = f'<joint name="t" axis="0 1 0" {OFF_AXIS}/>', "<freejoint/>"
SCENERY = (
    '<body name="post" pos="0.5 0.1 0.2" euler="0.1 0.2 0.3"><geom size="0.1"/><site '
    'name="on_post" pos="0.1 0 0"/>'
    '<body name="branch" pos="0 0.3 0.1" euler="0 0.2 0"><site name="on_branch" pos="0.1 0 '
    '0"/></body></body>'
    '<site name="in_world" pos="0.3 0.2 0.1" euler="0.2 0 0.1"/>'
)


def amid_scenery(tie, base, after=""):
    """An MJCF of two chains with feet, whose joints lie off their bodies' origins, beside a post
    that cannot move.
    """
    foot = body(
        "foot",
        BODY + '<site name="on_foot" pos="0 0.1 0.1" euler="0.3 0 0.2"/>',
        "",
        'pos="0.1 0 -0.1" euler="0 0.4 0.2"',
    )
    left = body(
        "b",
        BODY + foot,
        f'<joint name="p" axis="1 1 0" {OFF_AXIS}/>',
        'pos="0.3 0.1 -0.2" euler="0.3 0.2 0.1"',
    )
    toe = body("toe", BODY, "", 'pos="0.1 0.15 -0.1" euler="0.2 0.4 0.2"')
    inside = BODY + '<site name="on_c" pos="0.1 0.1 0"/>' + toe
    right = body("c", inside, f'<joint name="r" axis="0 1 0.5" {OFF_AXIS}/>', 'pos="0.1 -0.2 0"')
    trunk = body("trunk", BODY + left + right, base, 'pos="0.3 0.1 1.2" euler="0.4 0.5 0.6"')
    return mjcf(SCENERY + trunk, '<compiler angle="radian"/>', f"<equality>{tie}</equality>{after}")


def mujoco_of(text, q=()):
    """MuJoCo's rows (n, nv) and residuals (n,) of the equalities of a file, in the posture it
    starts in or at qpos.
    """
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[: len(q)] = q
    mujoco.mj_forward(model, data)
    rows = np.zeros((data.nefc, model.nv))
    if data.efc_J.size == rows.size:
        rows[:] = np.asarray(data.efc_J).reshape(rows.shape)
    else:
        mujoco.mju_sparse2dense(
            rows, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind
        )
    kept = data.efc_type == EQUALITY
    return rows[kept], np.array(data.efc_pos[kept])


def row_space(K):
    """The projector onto the span of rows, which is all that matters of them."""
    _, s, Vt = np.linalg.svd(K, full_matrices=False)
    kept = Vt[s > 1e-9 * s[0]]
    return kept.T @ kept


def columns(robot):
    """Columns of the free velocities of a robot with a fixed base."""
    G = free_columns(robot, "fixed", None, np.eye(3)[None], np.zeros(robot.model.nv, dtype=bool))
    assert G is not None
    return G[0]


# Loops


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


@pytest.mark.slow
@pytest.mark.parametrize("base", [FIXED, FREE], ids=["fixed base", "free base"])
@pytest.mark.parametrize("tie", TIES)
def test_loops_are_mujoco_s(tie, base):
    """On bodies without joints, on joints off the origin, on what cannot move: MuJoCo's rows, and
    MuJoCo's gap, open or closed.
    """
    text = amid_scenery(tie, base)
    robot = robot_from(text, ".xml")
    (loop,) = robot.loops
    for bent in (0.0, 0.1):
        q = mujoco.MjModel.from_xml_string(text).qpos0
        q[-2:] += bent, -2.0 * bent
        theirs, residual = mujoco_of(text, q)
        if robot.free_base:
            # MuJoCo counts the base's linear velocity in the world's axes, and quaternions from w
            # on.
            q[3:7] = q[[4, 5, 6, 3]]
            theirs[:, :3] = theirs[:, :3] @ pin.Quaternion(q[3:7]).matrix()
        state = dynamics(robot, q[None])
        ours, gap, a = (
            row_jacobian(state, [closure_constraint(loop)])[0],
            closure_gap(state, loop)[0],
            loop.bodies[0],
        )
        if a >= 0:
            # While a loop is open, its gap in axes fixed in the first body changes with that body's
            # rotation too.
            open_by = state.rotation[0, a] @ loop.rotations[0] @ gap[:3]
            theirs[:3] += np.cross((state.J[0, :3] * state.ancestors[a]).T, open_by).T
        np.testing.assert_allclose(row_space(ours), row_space(theirs), atol=1e-9)
        assert np.linalg.norm(gap[:3]) == pytest.approx(np.linalg.norm(residual[:3]), abs=1e-12)
        # MuJoCo's residual is the vector part of a quaternion.
        assert np.sin(np.linalg.norm(gap[3:]) / 2.0) == pytest.approx(
            np.linalg.norm(residual[3:]), abs=1e-12
        )


SECOND = '<connect{} body1="b2" body2="c2" anchor="0.05 0.32 -0.1"/>'
FIRST = SECOND.replace("0.32", "0.02")


@pytest.mark.parametrize(
    "names", [("", ""), (' name="x"', ""), ("", ' name="equality 0"'), (' name="x"', ' name="y"')]
)
def test_two_points_between_two_bodies_are_a_hinge(names):
    """Both are kept, named or not: together their rows span what MuJoCo's do."""
    text = chains(FIRST.format(names[0]) + SECOND.format(names[1]))
    robot, (theirs, _) = robot_from(text, ".xml"), mujoco_of(text)
    assert [loop.name for loop in robot.loops] == ["b2–c2"] * 2
    ours = row_jacobian(
        dynamics(robot, np.zeros((1, 5))), [closure_constraint(loop) for loop in robot.loops]
    )[0]
    assert np.linalg.matrix_rank(theirs, 1e-9) > np.linalg.matrix_rank(theirs[:3], 1e-9)
    np.testing.assert_allclose(row_space(ours), row_space(theirs), atol=1e-9)


def test_a_base_tied_to_the_world_starts_where_it_is_drawn():
    """There the loop is closed; a keyframe with the base in that place is closed as well, and other
    robots start at the origin.
    """
    drawn = mujoco.MjModel.from_xml_string(amid_scenery("", FREE)).qpos0
    key = f'<keyframe><key name="home" qpos="{" ".join(map(str, drawn))}"/></keyframe>'
    robot = robot_from(
        amid_scenery(f'<connect body1="foot" body2="post" {HELD}/>', FREE, key), ".xml"
    )
    for reference in ("neutral", "home"):
        q = configuration(robot, Posture(reference=reference))
        np.testing.assert_allclose(q[:7], drawn[[0, 1, 2, 4, 5, 6, 3]], atol=1e-12)
    assert np.abs(closure_gap(dynamics(robot, q[None]), robot.loops[0])).max() < 1e-12
    loose = robot_from(amid_scenery(f'<connect body1="foot" body2="toe" {HELD}/>', FREE), ".xml")
    np.testing.assert_array_equal(configuration(loose, Posture()), pin.neutral(loose.model))


@pytest.mark.parametrize(
    "tie", [f'<connect body1="foot" body2="b" {HELD}/>', '<weld body1="post"/>']
)
def test_what_is_fixed_already_is_no_loop(tie):
    """MuJoCo's rows of such an equality are zero, and here there are none."""
    text = amid_scenery(tie, FIXED)
    np.testing.assert_allclose(mujoco_of(text)[0], 0.0, atol=1e-15)
    assert robot_from(text, ".xml").loops == ()


# Joints that follow others

FOLLOW = '<joint joint1="q" joint2="s" polycoef="0.1 -0.7 0 0 0"{}/>'
LED = '<joint joint1="p" joint2="q" polycoef="-0.2 2 0 0 0"/>'
ROUND = '<joint joint1="p" joint2="q" polycoef="-0.05 0.25 0 0 0"/>'
TWICE = '<joint joint1="q" joint2="p" polycoef="0.2 4 0 0 0"{}/>'
A = (
    '<fixed name="A"><joint joint="q" coef="0.5"/><joint joint="s" coef="-0.3"/><joint joint="p" '
    'coef="2"/></fixed>'
)
B = '<fixed name="B"><joint joint="r" coef="1"/><joint joint="s" coef="1.1"/></fixed>'
TENDONS = f"</equality><tendon>{A}{B}</tendon><equality>"


@pytest.mark.parametrize(
    ("tie", "same", "left"),
    [
        (FOLLOW, None, 4),
        (FOLLOW + LED, None, 3),
        (LED + FOLLOW, None, 3),
        (FOLLOW + '<joint joint1="s" polycoef="0.3 0 0 0 0"/>', None, 3),
        (FOLLOW + '<joint joint1="r" joint2="q" polycoef="0.1 0.5 0 0 0"/>' + LED, None, 2),
        (FOLLOW + '<joint joint1="p" joint2="s" polycoef="0 3 0 0 0"/>', None, 3),
        (FOLLOW + TWICE, None, 3),
        (TENDONS + '<tendon tendon1="A" polycoef="0.1 0 0 0 0"/>', None, 4),
        (TENDONS + '<tendon tendon1="A" tendon2="B" polycoef="0.1 0.7 0 0 0"/>' + FOLLOW, None, 3),
        (TENDONS + FOLLOW + '<tendon tendon1="A"/><tendon tendon1="B"/>', None, 2),
        (FOLLOW + ROUND, FOLLOW + TWICE, 3),
        (FOLLOW + TWICE.replace("{}", ' active="false"'), FOLLOW, 4),
    ],
    ids=[
        *(
            "one",
            "chain",
            "chain in the other order",
            "of a joint that holds",
            "by two",
            "of one leader",
            "twice",
        ),
        *("fixed tendon", "of another", "of all three", "inverted", "inactive"),
    ],
)
def test_followers_are_mujoco_s(tie, same, left):
    """MuJoCo's rows are zero on every column of G, and its residuals zero where the followers
    stand.
    """
    robot = robot_from(chains(tie.format("", "")), ".xml")
    G, q = columns(robot), configuration(robot, Posture(joints={"*": 0.2}))
    order = [robot.joint(name).q.start for name in "tpqrs"]
    rows, residual = mujoco_of(chains((same or tie).format("", "")), q[order])
    assert G.shape == (5, left)
    np.testing.assert_allclose(rows @ G, 0.0, atol=1e-15)
    np.testing.assert_allclose(residual, 0.0, atol=1e-15)


@pytest.mark.parametrize(
    "refs",
    [{}, {"q": 0.4, "s": -0.25}, {"q": 0.4}, {"s": -0.25}],
    ids=["zero", "both", "follower", "leader"],
)
def test_followers_count_from_where_the_file_draws_them(refs):
    """MuJoCo couples q1 − q1₀ with q2 − q2₀, and q₀ is a joint's ref: at our follower's place,
    MuJoCo's residual is zero.
    """
    text = chains(FOLLOW.format(""), **refs)
    robot = robot_from(text, ".xml")
    q = configuration(robot, Posture(joints={"s": 0.3}))
    assert q[robot.joint("s").q] == 0.3
    np.testing.assert_allclose(
        mujoco_of(text, q[[robot.joint(name).q.start for name in "tpqrs"]])[1], [0.0], atol=1e-15
    )


@pytest.mark.parametrize("ref", [0.0, 0.4])
def test_a_joint_equality_without_a_leader_holds_the_joint(ref):
    """At the constant q1 = q1₀ + a0, and its velocity does not jump."""
    text = chains('<joint joint1="q" polycoef="0.1 0.9 0 0 0"/>', q=ref)
    robot = robot_from(text, ".xml")
    profile = shock_profile(
        Scene(robot="m", contact=Contact(frame="b2", offset=(0.1, 0.0, -0.2))), robot
    )
    np.testing.assert_allclose(mujoco_of(text, profile.q)[1], [0.0], atol=1e-15)
    assert profile.q[robot.joint("q").q] == pytest.approx(ref + 0.1, abs=1e-15)
    assert profile.delta_qd[robot.joint("q").v] == 0.0
    assert robot.mimics == (Mimic("q", {}, ref + 0.1),)


# Active or not


CONNECT = '<connect body1="b2" body2="c2" anchor="0.05 0.02 -0.1"{}/>'
OFF = '<equality active="false"/>'


@pytest.mark.parametrize(
    ("default", "words", "active"),
    [
        ("", "", True),
        ("", ' active="true"', True),
        ("", ' active="false"', False),
        (OFF, "", False),
        (OFF, ' active="true"', True),
        (f'<default class="off">{OFF}</default>', "", True),
        (f'<default class="off">{OFF}</default>', ' class="off"', False),
        (f'<default class="off">{OFF}</default>', ' class="off" active="true"', True),
        (f'{OFF}<default class="on"><equality active="true"/></default>', ' class="on"', True),
        (f'{OFF}<default class="same"/>', ' class="same"', False),
    ],
)
def test_equalities_that_are_not_active_are_left_out(default, words, active):
    """As MuJoCo decides it: by the equality itself, else by its class, else by the class above
    that; a flag switches all off.
    """
    text = chains(
        "".join(tie.format(words) for tie in (CONNECT, FOLLOW, '<weld body1="b2" body2="c2"{}/>')),
        default,
    )
    robot = robot_from(text, ".xml")
    assert mujoco.MjModel.from_xml_string(text).eq_active0.tolist() == [active] * 3
    assert (len(robot.loops), len(robot.mimics)) == ((2, 1) if active else (0, 0))
    off = text.replace("<default>", '<option><flag equality="disable"/></option><default>', 1)
    assert (robot_from(off, ".xml").loops, robot_from(off, ".xml").mimics) == ((), ())
    if not active:
        beyond = (
            '<weld body1="b2" body2="c2" torquescale="0"{}/>',
            '<joint joint1="q" joint2="s" polycoef="0 1 0.5 0 0"{}/>',
        )
        robot = robot_from(chains("".join(tie.format(words) for tie in beyond), default), ".xml")
        assert (robot.loops, robot.mimics) == ((), ())


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (chains(FOLLOW.format("") + LED + TWICE.format("")), ('couples "q", "p", but',)),
        (amid_scenery(f'<connect body1="foot" body2="pole" {HELD}/>', FIXED), ("MuJoCo", "'pole'")),
        (amid_scenery('<weld site1="on_foot" site2="post"/>', FIXED), ("MuJoCo", "'post'")),
        (
            amid_scenery('<joint joint1="p" joint2="t"/>', '<joint name="t" type="ball"/>'),
            ("MuJoCo", "HINGE and SLIDE"),
        ),
    ],
    ids=["followers alone", "no such body", "no such site", "a ball joint"],
)
def test_equalities_that_cannot_be_are_refused(text, parts):
    """The message names the joint, or repeats what MuJoCo says."""
    refused(RobotError, ("robot.xml", *parts), robot_from, text, ".xml")
