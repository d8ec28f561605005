"""The base of a robot: which joint or link of the file it is, how it moves, and what the header
says of it.
"""

import json
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from commands import good, run, says
from robot_texts import BODY, HINGE, INERTIA, LIMIT, arm, body, joint, link, mjcf, urdf, written
from trees import known_robot, robot_from

from shockpc import Contact, Joints, Posture, Scene, Strike, load_robot, shock_profile
from shockpc.judgement.standing import posture_marks
from shockpc.landing.joint_model import joint_model
from shockpc.landing.resolve import resolve
from shockpc.robot.usual_base import hangs, usual_base
from shockpc.show.header import base_text
from shockpc.studies.analyze.report import document
from shockpc.studies.sweep.study import sweep

SCENE = Scene(
    robot="quadruped",
    contact="front_foot",
    posture=Posture(base_rpy_deg=(5.0, -10.0, 20.0), joints_deg={"*_knee": -20.0}),
    strike=Strike(strike_angle_deg=20.0),
)
CHANGES = {
    "as it is": {},
    "armature": {"joints": Joints(armature={"*": 0.05})},
    "locked": {"joints": Joints(model="locked")},
    "fixed": {"base": "fixed", "posture": Posture()},
    "planar": {"base": "planar", "posture": Posture()},
    "turning": {"strike": Strike(velocity=(0.0, 0.0, -1.0), angular_velocity=(0.1, 2.0, 0.3))},
    "standing on another foot": {"stance": ("hind_foot",)},
}


def in_a_world(text, root, kind="floating", name="world", turned=""):
    """The URDF with another root link, to which a mark is fixed and that carries the robot on a
    joint.
    """
    joints = joint("fix", name, "mark", "fixed", more="") + joint(
        "carrier", name, root, kind, "0 0 1", turned
    )
    return re.sub(
        r"(<robot[^>]*>)", rf'\1<link name="{name}"/><link name="mark"/>{joints}', text, count=1
    )


def with_postures(text):
    """The robot of a URDF with the postures of the quadruped."""
    return robot_from(text, srdf=known_robot("quadruped").source.srdf.read_text())


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize(
    ("kind", "name"), [("floating", "world"), ("floating", "footprint"), ("planar", "world")]
)
def test_a_massless_root_that_carries_the_robot_on_a_floating_joint_is_the_world(
    kind, name, change
):
    """Every number is that of the same robot without that link and joint, whatever is fixed to the
    link.
    """
    plain = known_robot("quadruped")
    text = in_a_world(plain.source.xml, plain.bodies[0].name, kind, name)
    scene = replace(SCENE, **CHANGES[change])
    found, expected = (
        document(shock_profile(scene, robot)) for robot in (with_postures(text), plain)
    )
    assert (found.pop("robot") | {"file": ""}, found.pop("scene") | {"robot": ""}) == (
        expected.pop("robot") | {"file": ""},
        expected.pop("scene") | {"robot": ""},
    )
    notes, known = (
        [warning["text"] for warning in one["health"].pop("warnings")] for one in (found, expected)
    )
    added = [note for note in notes if note not in known]
    assert [says(note, '"carrier"', "floating base", "--base planar") for note in added] == [
        True
    ] * (kind == "planar")
    assert found == expected


def test_the_origin_of_that_joint_is_where_the_base_starts():
    """In the neutral posture the base is turned as the file says; one that a scene places stands
    there.
    """
    plain = known_robot("quadruped")
    text = in_a_world(
        plain.source.xml, plain.bodies[0].name, turned='<origin xyz="1 2 3" rpy="0.3 -0.2 0.1"/>'
    )
    turned = tuple(np.degrees((0.3, -0.2, 0.1)).tolist())
    for posture in (
        Posture(reference="neutral"),
        Posture(reference="neutral", base_rpy_deg=turned),
    ):
        found = shock_profile(replace(SCENE, posture=posture), robot_from(text))
        expected = shock_profile(
            replace(SCENE, posture=replace(posture, base_rpy_deg=turned)), plain
        )
        np.testing.assert_allclose(found.delta_v, expected.delta_v, rtol=1e-12, atol=1e-13)


def test_a_floating_joint_has_no_drive():
    """Also where it carries a loose body: a pattern passes over it, locked joints leave it free."""
    robot = robot_from(
        urdf(*map(link, "abc"), joint("j", "a", "b"), joint("six", "a", "c", "floating", more="")),
    )
    for joints in (Joints(locked=("*",)), Joints(model="locked")):
        assert joint_model(robot, joints).locked.tolist() == [False] * 6 + [True] + [False] * 6
    assert (
        joint_model(robot, Joints(armature={"*": 0.1})).armature.tolist()
        == [0.0] * 6 + [0.1] + [0.0] * 6
    )


def test_a_massless_root_under_a_hinge_is_computed_with_the_base_that_the_message_names(
    capfd, tmp_path
):
    """The message says --base fixed, and that works."""
    robot = written(tmp_path, arm(base='<link name="base"/>'))
    command = ("analyze", robot, "--contact", "tip", "--offset", "0.3,0,0", "--base", "free")
    code, out, err = run(capfd, *command)
    assert (code, out) == (3, "")
    assert 'bodies "base", "tip" of robot "r" can move' in err
    assert "bolt the robot's massless root down with --base fixed" in err
    assert "fixed to the world" in good(capfd, *command[:-2], "--base", "fixed")


HEADERS = {
    arm(): "falls freely; --base planar or --base fixed restrains it",
    arm(
        tip=link("tip") + link("a") + link("b") + joint("ja", "tip", "a") + joint("jb", "a", "b")
    ): (
        "fixed to the world, because the robot has no feet and hangs on its root by one chain; "
        "--base free releases it"
    ),
    arm(base=link("world"), elbow=joint("elbow", "world", "tip")): (
        'fixed to the world, because its root link is called "world"; --base free releases it'
    ),
    mjcf(body("tip", BODY, HINGE)): "fixed in the file; --base free releases it",
}


@pytest.mark.parametrize("text", HEADERS)
def test_the_header_says_whether_an_arm_is_bolted_down_and_what_changes_it(text, capfd, tmp_path):
    robot = written(tmp_path, text, "arm.xml" if "<mujoco" in text else "arm.urdf")
    for command in (
        ("analyze", robot, "--contact", "tip", "--offset", "0.3,0,0"),
        ("robots", robot),
    ):
        more = ("--all",) if command[0] == "analyze" else ()
        assert f"\nbase         {HEADERS[text]}\n" in good(capfd, *command, *more)


def test_robots_calls_the_ends_of_an_arm_tips(capfd, tmp_path):
    text = next(text for text, header in HEADERS.items() if "has no feet" in header)
    printed = good(capfd, "robots", written(tmp_path, text, "arm.urdf"))
    assert "\ntips  " in printed
    assert "\nfeet  " not in printed


LEGS = body("shin", BODY + body("foot", BODY, HINGE.replace('"j"', '"ankle"')), HINGE)
KEY = '<keyframe><key name="home" qpos="{}0.3 -0.2"/></keyframe>'


@pytest.mark.parametrize("base", ["free", "planar"])
def test_the_base_of_an_mjcf_that_fixes_it_can_be_freed(base, tmp_path, capfd):
    """Every number is that of the file with a <freejoint/> in its top-level body and keyframe; by
    option, scene and Python.
    """
    held = mjcf(body("trunk", BODY + LEGS, "", 'pos="0 0 1"'), after=KEY.format(""))
    freed = held.replace('pos="0 0 1">', 'pos="0 0 1"><freejoint/>').replace(
        'qpos="', 'qpos="0 0 1 1 0 0 0 '
    )
    texts = {
        "held.xml": held,
        "freed.xml": freed,
        "scene.toml": f'robot = "held.xml"\nbase = "{base}"\n[[contact]]\nframe = "foot"',
    }
    held, freed, scene = (written(tmp_path, text, name) for name, text in texts.items())
    options = ("--contact", "foot", "--base", base, "--format", "json")
    expected = json.loads(good(capfd, "analyze", freed, *options))
    python = document(shock_profile(Scene(robot=held, contact="foot", base=base)))
    assert load_robot(held, free=True).free_base
    assert not load_robot(held).free_base
    for found in (
        good(capfd, "analyze", held, *options),
        good(capfd, "analyze", scene, "--format", "json"),
        json.dumps(python),
    ):
        numbers = json.loads(found)
        assert numbers["scene"]["posture"]["reference"] == "home"
        assert numbers["tables"] == expected["tables"]


FLOATING = body("trunk", BODY + LEGS, "<freejoint/>", 'pos="0 0 1"')
FLOATING_KEY = KEY.format("0.5 0 0.8 1 0 0 0 ")
HUNG = (
    '<equality><weld name="hook" body1="world" body2="trunk" anchor="0.1 0 0.2" relpose="0.3 0.2 '
    '1.6 0.9 0.1 0.3 -0.2"/></equality>'
)
HOLDS = {"hung": HUNG, "from the trunk": '<equality><weld body1="trunk"/></equality>'}


@pytest.mark.parametrize("holds", HOLDS.values(), ids=HOLDS)
def test_a_base_that_a_weld_of_the_file_holds_is_fixed(holds, tmp_path, capfd):
    """It is where MuJoCo's rows of the weld are closed, whatever a keyframe says; the numbers are
    those of a base fixed there.
    """
    text = mjcf(FLOATING, '<compiler angle="radian"/>', holds + FLOATING_KEY)
    hung, loose = (
        written(tmp_path, text, "hung.xml"),
        written(tmp_path, text.replace(holds, ""), "loose.xml"),
    )
    contact = Contact(frame="foot", directions=("z",))
    found = shock_profile(
        Scene(robot=hung, contact=contact, strike=Strike(velocity=(0.3, 0.2, -1.0)))
    )
    model = mujoco.MjModel.from_xml_path(hung)
    data = mujoco.MjData(model)
    data.qpos[:] = np.concatenate([found.q[:3], found.q[[6, 3, 4, 5]], found.q[7:]])
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(
        data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY],
        np.zeros(6),
        atol=1e-12,
    )
    posture = Posture(base_position=tuple(found.q[:3]), base_quaternion=tuple(found.q[3:7]))
    held = replace(found.scene, robot=loose, base="fixed", posture=posture)
    expected = document(shock_profile(held))
    for base in (None, "fixed"):
        numbers = document(shock_profile(replace(found.scene, robot=hung, base=base)))
        assert numbers["tables"] == expected["tables"]
    said = "\nbase         fixed to the world by a weld of the file; --base free releases it\n"
    for command in (("analyze", hung, "--contact", "foot", "--slide"), ("robots", hung)):
        assert said in good(capfd, *command)


@pytest.mark.parametrize("base", ["free", "planar"])
def test_a_weld_of_the_base_is_left_out_where_the_base_is_to_move(base, tmp_path):
    """Every number is that of the file without the weld, and a warning says that it is left out."""
    text = mjcf(FLOATING, after=HUNG + FLOATING_KEY)
    hung, loose = (
        written(tmp_path, text, "hung.xml"),
        written(tmp_path, text.replace(HUNG, ""), "loose.xml"),
    )
    found, expected = (
        shock_profile(Scene(robot=robot, contact="foot", base=base)) for robot in (hung, loose)
    )
    assert document(found)["tables"] == document(expected)["tables"]
    left_out = 'hung.xml: the weld of "trunk" to the world is left out, because the base is to move'
    assert {*map(str, found.health.warnings)} - {*map(str, expected.health.warnings)} == {left_out}


def test_the_header_names_what_else_ties_the_base_to_the_world(tmp_path, capfd):
    """A base that turns about a point of the world does not fall freely."""
    text = mjcf(FLOATING, after='<equality><connect body1="trunk" anchor="0 0 0.1"/></equality>')
    options = ("--contact", "foot", "--velocity", "1,0,-1")
    assert '\nbase         held to the world by "trunk–world" of the file' in good(
        capfd, "analyze", written(tmp_path, text, "r.xml"), *options
    )


@pytest.mark.parametrize(
    ("bodies", "parts"),
    [
        (
            body("left", at="") + body("right", joints=HINGE.replace('"j"', '"k"')),
            ("2 bodies", '"left", "right"', "the trunk, with a <freejoint/>"),
        ),
        (body("arm"), ('body "arm"', 'joint "j"', "<freejoint/>")),
    ],
)
def test_a_base_that_cannot_be_freed(bodies, parts, tmp_path, capfd):
    """Legs that hang on the world apart from one another, and a body on a joint of its own."""
    robot = written(tmp_path, mjcf(bodies), "legs.xml")
    outcome = run(capfd, "analyze", robot, "--contact", "*", "--base", "free")
    assert (outcome.code, outcome.out) == (2, "")
    for part in ("cannot be freed", *parts):
        assert part in outcome.err


# The default


ARM = urdf(
    link("stand", "8"),
    link("upper", "2"),
    link("fore", "1", f'<origin xyz="0.1 0 0"/>{INERTIA}'),
    link("hand", "0.5"),
    joint("j1", "stand", "upper", more=f'<origin xyz="0 0 0.1"/>{LIMIT}'),
    joint("j2", "upper", "fore", more=f'<origin xyz="0.3 0 0.1"/>{LIMIT}'),
    joint("j3", "fore", "hand", axis="1 0 0", more=f'<origin xyz="0.2 0.1 0"/>{LIMIT}'),
)
STRIKES = Contact(frame="hand", offset=(0.1, 0.05, 0.0), directions=("z",))


def test_an_arm_stands_fixed_and_its_stand_is_no_part_of_it(tmp_path, capfd):
    """Every number is that of an arm whose stand weighs something else, and that of the same arm on
    a root link "world".
    """
    light = ARM.replace('<mass value="8"/>', '<mass value="3"/>', 1)
    in_world = ARM.replace("stand", "world")
    robots = [robot_from(text) for text in (ARM, light, in_world)]
    assert [usual_base(robot) for robot in robots] == [
        ("fixed", "arm"),
        ("fixed", "arm"),
        ("fixed", "world"),
    ]
    for v_in in ("contact", "com"):
        profiles = [
            shock_profile(Scene(robot="r.urdf", contact=STRIKES, v_in=v_in), robot)
            for robot in robots
        ]
        numbers = [
            [profile.delta_qd, profile.total_moment, profile.value("mass", "robot"), profile.v_in]
            for profile in profiles
        ]
        for other in numbers[1:]:
            for one, same in zip(numbers[0], other, strict=True):
                np.testing.assert_allclose(one, same, rtol=1e-12)
        assert float(numbers[0][2][0]) == pytest.approx(3.5)
    path = written(tmp_path, ARM, "arm.urdf")
    command = ("analyze", path, "--contact", "hand", "--offset", "0.1,0.05,0", "--slide")
    first, *_ = good(capfd, *command).splitlines()
    assert "CoM of fore" in first or "CoM of upper" in first
    assert "3.5 kg, 3 moving bodies" in good(capfd, "robots", path)
    document = json.loads(good(capfd, "robots", path, "--format", "json"))
    assert (document["mass"], document["base"]) == (3.5, "fixed")


@pytest.mark.parametrize(
    ("change", "base"),
    [
        (lambda text: text.replace("hand", "foot"), "free"),
        (lambda text: text.replace("stand", "drone"), "free"),
        (
            lambda text: text.replace(
                "</robot>", link("tail") + joint("j4", "stand", "tail") + "</robot>"
            ),
            "free",
        ),
        (lambda text: text.replace('name="j3" type="revolute"', 'name="j3" type="fixed"'), "free"),
        (lambda text: text.replace("hand", "tool"), "fixed"),
    ],
)
def test_only_a_single_chain_without_feet_is_an_arm(change, base):
    assert usual_base(robot_from(change(ARM))).base == base


def dog(trunk):
    """Legs of two joints at the corners of a trunk."""
    parts = []
    for name, x, y in (("FL", 0.2, 0.1), ("FR", 0.2, -0.1), ("RL", -0.2, 0.1), ("RR", -0.2, -0.1)):
        parts += [
            link(f"{name}_thigh", "0.6"),
            link(f"{name}_calf", "0.2"),
            link(f"{name}_foot", "0.05"),
        ]
        parts += [
            joint(f"{name}_hip", trunk, f"{name}_thigh", more=f'<origin xyz="{x} {y} 0"/>{LIMIT}'),
            joint(
                f"{name}_knee",
                f"{name}_thigh",
                f"{name}_calf",
                more=f'<origin xyz="0 0 -0.2"/>{LIMIT}',
            ),
            joint(
                f"{name}_end",
                f"{name}_calf",
                f"{name}_foot",
                "fixed",
                more='<origin xyz="0 0 -0.2"/>',
            ),
        ]
    return parts


def test_a_legged_robot_that_its_file_bolts_to_a_link_called_world_is_freed():
    """Every number is that of the same robot without that link, and the body has the name of its
    trunk.
    """
    hold = joint("hold", "world", "trunk", "fixed", more="")
    held = robot_from(urdf('<link name="world"/>', hold, link("trunk", "8"), *dog("trunk")))
    plain = robot_from(urdf(link("trunk", "8"), *dog("trunk")))
    assert (usual_base(held), usual_base(plain)) == (("free", "legs"), ("free", "falls"))
    assert [body.name for body in held.bodies] == [body.name for body in plain.bodies]
    scene = Scene(robot="r.urdf", contact=("FL_foot", "RR_foot"))
    found, expected = (shock_profile(scene, robot) for robot in (held, plain))
    np.testing.assert_allclose(found.delta_v, expected.delta_v, rtol=0.0, atol=1e-12)
    assert [one.text for one in found.unknowns if one.kind == "base"] == [
        "the base is freed, because legs hang on it"
    ]
    assert not [one for one in expected.unknowns if one.kind == "base"]
    assert "because legs hang on that; --base fixed holds it" in base_text(held, "free")
    assert base_text(held, "fixed") == "fixed to the world; --base free releases it"


def test_legs_on_a_rail_fall_along_it():
    """A root link "world" stays the ground where a joint lies between it and the legs."""
    rail = joint("rail", "world", "trunk", "prismatic", "0 0 1")
    robot = robot_from(urdf('<link name="world"/>', rail, link("trunk", "8"), *dog("trunk")))
    assert usual_base(robot) == ("fixed", "world")
    assert not hangs(robot, "fixed")


def test_with_a_fixed_base_answers_are_about_a_body_that_the_joints_lift():
    """On a rail the trunk; of an arm no link that only turns about the ground's normal, however
    heavy it is.
    """
    rail = joint("rail", "world", "trunk", "prismatic", "0 0 1")
    rig = robot_from(urdf('<link name="world"/>', rail, link("trunk", "8"), *dog("trunk")))
    turret = ARM.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>', 1).replace(
        '<mass value="2"/>', '<mass value="20"/>'
    )
    for robot, contact, name in ((rig, "FL_foot", "trunk"), (robot_from(turret), STRIKES, "fore")):
        landing = resolve(
            Scene(robot="r.urdf", contact=contact, posture=Posture(joints={"*": 0.3})), robot
        )
        assert (landing.base, robot.bodies[landing.trunk].name) == ("fixed", name)
        table = sweep(landing.scene, {"strike-angle": (0.0, 10.0)}, robot=robot).table
        assert np.all(table.columns[f"shock_com@{name}"] > 0.0)


def test_the_first_line_says_that_a_robot_hangs_on_a_base_that_its_file_holds(tmp_path, capfd):
    """Legs of an MJCF without a free joint: no landing; with --base free it is one."""
    legs = "".join(
        body(f"{side}_foot", at=f'pos="0 {y} -0.3"', joints=HINGE.replace('"j"', f'"{side}"'))
        for side, y in (("left", 0.1), ("right", -0.1))
    )
    path = written(tmp_path, mjcf(f'<body name="trunk">{BODY}{legs}</body>'), "biped.xml")
    command = ("analyze", path, "--contact", "left_foot", "--offset", "0.1,0,0")
    first, *others = good(capfd, *command).splitlines()
    assert "left_foot only, the base held" in first
    assert any(
        "hangs on it" in line and "no landing; release it with --base free" in line
        for line in others
    )
    assert "base held" not in good(capfd, *command, "--base", "free")
    profile = shock_profile(
        Scene(robot=path, contact=Contact(frame="left_foot", offset=(0.1, 0.0, 0.0)))
    )
    assert posture_marks(profile.scene, profile.health.warnings) == ("base fixed",)
