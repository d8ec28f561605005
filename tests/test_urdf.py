"""URDF: what the parser would drop is corrected or refused, by the name of the link or joint at fault."""

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import INERTIA, LIMIT, arm, joint, link, urdf

from shockpc.errors import RobotError
from shockpc.robot.build import build_model
from shockpc.robot.files import parse_xml
from shockpc.robot.robot import load_robot
from shockpc.robot.source import read_source


def refusal(tmp_path: Path, text: str) -> str:
    """The text of the error that reading this file raises."""
    path = tmp_path / "dog.urdf"
    path.write_text(text)
    with pytest.raises(RobotError) as caught:
        read_source(str(path))
    return str(caught.value)


def test_robot_without_a_name_is_named_after_its_file(tmp_path: Path):
    """URDF's parser refuses a nameless robot; the file's stem serves."""
    path = tmp_path / "dog.v2.urdf"
    path.write_text(arm().replace(' name="r"', ""))
    source = read_source(str(path))
    assert source.robot_name == "dog"
    assert build_model(source).name == "dog"


def test_blanks_around_numbers_are_harmless(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """The parser drops an inertia whose mass is " 2 "; it is read as 2."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm(tip=link("tip", mass=" 2 ")))
    assert build_model(read_source(str(path))).inertias[2].mass == 2.0
    assert capfd.readouterr() == ("", "")


def test_prefixes_need_no_declaration(tmp_path: Path):
    """Old files hold prefixed elements without a namespace; they are ignored."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm().replace("</robot>", "<controller:gazebo_ros/></robot>"))
    assert read_source(str(path)).robot_name == "r"


def test_broken_shapes_are_left_out_with_a_warning(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """A shape that cannot be read costs that shape, a line, and no number."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm(tip=link("tip", more='<visual><geometry><box size="1 x 1"/></geometry></visual>')))
    source = read_source(str(path))
    assert source.warnings == (
        'dog.urdf: link "tip": a <visual> without a valid shape is left out; '
        "it is missing in figures and extremes; no other number changes",
    )
    assert build_model(source).inertias[2].mass == 1.0
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("leader", "said"), [("nobody", '"nobody", which does not exist'), ("elbow", "itself")])
def test_mimic_without_a_leader_moves_freely(leader: str, said: str, tmp_path: Path):
    """A follower without a leader is a joint of its own, and that is said."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm(elbow=joint("elbow", "base", "tip", more=f'{LIMIT}<mimic joint="{leader}"/>')))
    source = read_source(str(path))
    assert source.warnings == (f'dog.urdf: joint "elbow" mimics {said}; it is computed as a joint that moves freely',)
    assert "<mimic" not in source.xml


@pytest.mark.parametrize("leader", ["lead", "nobody"])
def test_a_joint_mimics_once(leader: str, tmp_path: Path):
    """Of two leaders one would be lost, so both are refused."""
    elbow = joint("elbow", "base", "tip", more=f'{LIMIT}<mimic joint="lead"/><mimic joint="{leader}" multiplier="2"/>')
    text = urdf(link("base"), link("tip"), elbow, link("third"), joint("lead", "base", "third"))
    assert refusal(tmp_path, text) == 'dog.urdf: joint "elbow" has several <mimic>, and a joint can follow only one; keep one'


@pytest.mark.parametrize(("kind", "count"), [("floating", 6), ("planar", 3)])
@pytest.mark.parametrize("many", ["lead", "elbow"])
def test_only_joints_with_one_degree_of_freedom_follow_or_lead(kind: str, count: int, many: str, tmp_path: Path):
    """A floating joint has no number that could follow another."""
    kinds = {"lead": "revolute", "elbow": "revolute", many: kind}
    elbow = joint("elbow", "base", "tip", kinds["elbow"], "0 0 1", f'{LIMIT}<mimic joint="lead"/>')
    lead = joint("lead", "base", "third", kinds["lead"], "0 0 1")
    (tmp_path / "dog.urdf").write_text(urdf(link("base"), link("tip"), elbow, link("third"), lead))
    with pytest.raises(RobotError) as caught:
        load_robot(str(tmp_path / "dog.urdf"))
    assert str(caught.value) == (
        f'dog.urdf: joint "elbow" is to follow "lead", but "{many}" has {count} degrees of freedom, and only a joint with one can '
        "follow or lead; give it one axis, or take the coupling out"
    )


TREE = {
    urdf(): "dog.urdf has no <link>, so there is no robot in it; if it only defines macros, give the file that uses them",
    urdf('<link name="a"/>'): "dog.urdf: no link has mass, so nothing in it can be struck; give at least one link an <inertial>",
    urdf(link("a", mass="0")): "dog.urdf: no link has mass, so nothing in it can be struck; give at least one link an <inertial>",
    urdf(link("a"), "<link/>"): "dog.urdf: <link> number 2 has no name; give it one",
    arm(elbow=joint("", "base", "tip")): "dog.urdf: <joint> number 1 has no name; give it one",
    urdf(link("a"), link("a")): 'dog.urdf: two links are called "a"; names have to be unique, so rename one',
    urdf(link("a"), link("b"), link("c"), joint("j", "a", "b"), joint("j", "a", "c")): (
        'dog.urdf: two joints are called "j"; names have to be unique, so rename one'
    ),
    urdf(link("universe")): 'dog.urdf: link "universe" has the name that Pinocchio gives to the world; rename it',
    arm(elbow=joint("root_joint", "base", "tip")): (
        'dog.urdf: joint "root_joint" has the name that Pinocchio gives to the free base; rename it'
    ),
    arm(elbow=joint("elbow", "base", "hand")): (
        'dog.urdf: joint "elbow": its child is link "hand", which does not exist; every joint has to join two links of the file'
    ),
    arm(elbow=joint("elbow", "body", "tip")): (
        'dog.urdf: joint "elbow": its parent is link "body", which does not exist; every joint has to join two links of the file'
    ),
    arm().replace('<parent link="base"/>', ""): (
        'dog.urdf: joint "elbow": it names no parent link; every joint has to join two links of the file'
    ),
    urdf(link("a"), link("b")): ('dog.urdf: 2 links have no parent: "a", "b"; a robot has one root, so join the others to it'),
    urdf(*(link(name) for name in "abcdefg")): (
        'dog.urdf: 7 links have no parent: "a", "b", "c", "d", "e", …; a robot has one root, so join the others to it'
    ),
    urdf(link("a"), link("b"), joint("j", "a", "b"), joint("k", "b", "a")): (
        'dog.urdf: joints "j", "k" form a circle that no root link carries; a URDF is a tree, so remove one of its joints'
    ),
    urdf(link("a"), link("b"), link("c"), joint("j", "b", "c"), joint("k", "c", "b")): (
        'dog.urdf: joints "j", "k" form a circle that no root link carries; a URDF is a tree, so remove one of its joints'
    ),
    urdf(link("a"), link("b"), joint("j", "b", "b")): (
        'dog.urdf: joint "j" forms a circle that no root link carries; a URDF is a tree, so remove one of its joints'
    ),
    urdf(link("a"), link("b"), link("c"), joint("j", "a", "b"), joint("k", "a", "c"), joint("l", "b", "c")): (
        'dog.urdf: link "c" is the child of two joints, "k" and "l"; a URDF is a tree, so cut the loop at one of them'
    ),
    arm(elbow=joint("elbow", "base", "tip", "ball")): (
        'dog.urdf: joint "elbow" is of type "ball", which URDF does not have; '
        'it has "revolute", "continuous", "prismatic", "fixed", "floating", "planar"'
    ),
}


@pytest.mark.parametrize("text", TREE)
def test_not_a_tree_of_bodies(text: str, tmp_path: Path):
    """A URDF that is not connected is refused by the name of the link or joint at fault."""
    assert refusal(tmp_path, text) == TREE[text]


NUMBERS = {
    arm(tip=link("tip", mass="nan")): 'link "tip": mass is "nan"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="inf")): 'link "tip": mass is "inf"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="1e999")): 'link "tip": mass is "1e999"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="1,5")): 'link "tip": mass is "1,5"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="0x10")): 'link "tip": mass is "0x10"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="${m}")): 'link "tip": mass is "${m}"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="-1")): 'link "tip": mass -1 kg is negative; no body has that',
    arm(tip=link("tip").replace('<mass value="1"/>', "<mass/>")): (
        'link "tip": mass is missing; it has to be one finite number, such as 0.5'
    ),
    arm(tip=link("tip").replace('<mass value="1"/>', "")): (
        'link "tip": its <inertial> has no <mass>; add it, or drop the <inertial> of a link without mass'
    ),
    arm(tip=link("tip", inertia="")): (
        'link "tip": its <inertial> has no <inertia>; add it, or drop the <inertial> of a link without mass'
    ),
    arm(tip=link("tip", inertia=INERTIA.replace('ixy="0"', ""))): (
        'link "tip": ixy is missing; it has to be one finite number, such as 0.5'
    ),
    arm(tip=link("tip", inertia=INERTIA.replace('iyy="0.1"', 'iyy="-0.1"'))): (
        'link "tip": iyy = -0.1 kg m² is negative; no body has that moment of inertia'
    ),
    arm(tip=link("tip", inertia='<origin xyz="0 0"/>' + INERTIA)): (
        'link "tip": <inertial> origin xyz is "0 0"; it has to be 3 finite numbers, such as 0 0 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", axis="0 0 0")): (
        'joint "elbow": its axis is 0 0 0, so it has no direction; give it one'
    ),
    arm(elbow=joint("elbow", "base", "tip", axis="0 nan 0")): (
        'joint "elbow": axis is "0 nan 0"; it has to be 3 finite numbers, such as 0 0 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=f'<origin rpy="0 x 0"/>{LIMIT}')): (
        'joint "elbow": <joint> origin rpy is "0 x 0"; it has to be 3 finite numbers, such as 0 0 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", more="")): (
        'joint "elbow" is revolute and has no <limit>, which URDF requires; add one, or make it continuous'
    ),
    arm(elbow=joint("elbow", "base", "tip", "prismatic", more="")): (
        'joint "elbow" is prismatic and has no <limit>, which URDF requires; add one'
    ),
    arm(elbow=joint("elbow", "base", "tip", more='<limit lower="-1" upper="1" velocity="1"/>')): (
        'joint "elbow": <limit> effort is missing; it has to be one finite number, such as 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=f'{LIMIT}<dynamics damping="x"/>')): (
        'joint "elbow": <dynamics> damping is "x"; it has to be one finite number, such as 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=f'{LIMIT}<mimic joint="other" multiplier="nan"/>')).replace(
        "</robot>", f"{link('third')}{joint('other', 'base', 'third')}</robot>"
    ): 'joint "elbow": <mimic> multiplier is "nan"; it has to be one finite number, such as 0.5',
    arm(elbow=joint("elbow", "base", "tip", "planar", axis="0 1 0", more="")): (
        'joint "elbow": planar with the normal 0 1 0 (1 0 0 where none is written); Pinocchio moves every planar joint in x and '
        'y. Turn the joint\'s <origin> so that <axis xyz="0 0 1"/> is the normal'
    ),
}


@pytest.mark.parametrize("text", NUMBERS)
def test_numbers_that_no_body_has(text: str, tmp_path: Path):
    """One bad number refuses the file by name; the parser alone would go on without that body's mass."""
    assert refusal(tmp_path, text) == f"dog.urdf: {NUMBERS[text]}"


def test_rounding_below_zero_is_no_negative_moment(tmp_path: Path):
    """Moments of −5e-20, as in iCub's file, are left over by an exporter."""
    path = tmp_path / "dog.urdf"
    path.write_text(arm(tip=link("tip", inertia=INERTIA.replace("0.1", "-5.4e-20"))))
    assert read_source(str(path)).robot_name == "r"


def test_refusals_are_silent(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """No refusal prints anything: its text is in the error alone."""
    for text in (*TREE, *NUMBERS):
        refusal(tmp_path, text)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["a1", "go2", "laikago", "panda", "quadruped", "solo12", "talos", "ur5"])
def test_mujoco_reads_the_same_robot(name: str):
    """A second reader of URDF: masses, and the inertia matrix of the joints in a posture drawn at random, with the base held."""
    robot = load_robot(name)
    root = parse_xml(robot.source.xml, name)
    for link_ in root.iter("link"):
        for part in (*link_.findall("visual"), *link_.findall("collision")):
            link_.remove(part)
    for joint_ in root.iter("joint"):
        for mimic in joint_.findall("mimic"):
            joint_.remove(mimic)
    model = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode")).compile()
    data, q = mujoco.MjData(model), np.array(pin.neutral(robot.model))
    columns = np.empty(model.nv, dtype=int)
    rng = np.random.default_rng(1)
    for number in range(model.njnt):
        joint_ = robot.joint(model.joint(number).name)
        columns[model.jnt_dofadr[number]] = joint_.v.start
        data.qpos[model.jnt_qposadr[number]] = value = rng.uniform(-1.0, 1.0)
        q[joint_.q] = (np.cos(value), np.sin(value)) if joint_.kind == "continuous" else value
    mujoco.mj_forward(model, data)
    theirs = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, theirs)
    ours = pin.crba(robot.model, robot.model.createData(), q)
    ours = (np.triu(ours) + np.triu(ours, 1).T)[np.ix_(columns, columns)]
    np.testing.assert_allclose(ours - np.diag(robot.model.armature[columns]), theirs, atol=1e-11 * np.abs(theirs).max())
    assert model.nv == robot.model.nv - 6
