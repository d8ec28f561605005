"""URDF: what the parser would drop is corrected or refused, by the name of the link or joint at fault."""

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import INERTIA, LIMIT, arm, joint, link, loaded, refusal, urdf

from shockpc.robot.files import parse_xml
from shockpc.robot.robot import load_robot


def test_what_carries_no_meaning_is_corrected(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """A robot without a name gets its file's, blanks around numbers go, prefixes need no declaration; all without a word."""
    text = arm(tip=link("tip", mass=" 2 ")).replace(' name="r"', "").replace("</robot>", "<controller:gazebo_ros/></robot>")
    robot = loaded(tmp_path, text, "dog.v2.urdf")
    assert (robot.name, robot.model.name, robot.model.inertias[2].mass, robot.warnings) == ("dog", "dog", 2.0, ())
    # Moments of −5e-20, as in iCub's file, are left over by an exporter.
    loaded(tmp_path, arm(tip=link("tip", inertia=INERTIA.replace("0.1", "-5.4e-20"))))
    assert capfd.readouterr() == ("", "")


MIMIC = '<mimic joint="{}"/>'
CORRECTED = {
    arm(elbow=joint("elbow", "base", "tip", more=LIMIT + MIMIC.format("nobody"))): (
        'joint "elbow" mimics "nobody", which does not exist; it is computed as a joint that moves freely'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=LIMIT + MIMIC.format("elbow"))): (
        'joint "elbow" mimics itself; it is computed as a joint that moves freely'
    ),
}


@pytest.mark.parametrize("text", CORRECTED)
def test_what_is_left_out_is_a_warning(text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """It costs that element and a line, and no number."""
    robot = loaded(tmp_path, text)
    assert robot.warnings == (f"dog.urdf: {CORRECTED[text]}",)
    assert (robot.bodies[1].mass, robot.mimics) == (1.0, ())
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("kind", "count"), [("floating", 6), ("planar", 3)])
@pytest.mark.parametrize("many", ["lead", "elbow"])
def test_only_joints_with_one_degree_of_freedom_follow_or_lead(kind: str, count: int, many: str, tmp_path: Path):
    """A floating joint has no number that could follow another."""
    kinds = {"lead": "revolute", "elbow": "revolute", many: kind}
    elbow = joint("elbow", "base", "tip", kinds["elbow"], "0 0 1", LIMIT + MIMIC.format("lead"))
    lead = joint("lead", "base", "third", kinds["lead"], "0 0 1")
    assert refusal(tmp_path, urdf(link("base"), link("tip"), elbow, link("third"), lead)) == (
        f'dog.urdf: joint "elbow" is to follow joint "lead", but "{many}" has {count} degrees of freedom, and only a joint with '
        "one can follow or lead; give it one axis, or take the coupling out"
    )


def test_followers_in_a_circle(tmp_path: Path):
    """One has to lead; what follows the circle from outside is not part of it."""
    follow = {"a": "b", "b": "a", "c": "a", "d": ""}
    joints = [
        joint(name, "base", f"l{name}", more=LIMIT + (MIMIC.format(leader) if leader else "")) for name, leader in follow.items()
    ]
    text = urdf(link("base"), *(link(f"l{name}") for name in follow), *joints)
    assert refusal(tmp_path, text) == 'dog.urdf: mimic joints "a", "b" follow one another in a circle; one of them has to lead'


def chain(count: int) -> str:
    """So many links, each hanging on the one before."""
    joints = (joint(f"j{k}", f"l{k}", f"l{k + 1}", "fixed") for k in range(count - 1))
    return urdf(*(link(f"l{k}") for k in range(count)), *joints)


TREE = {
    urdf(): ": it has no <link>, so there is no robot in it; if it defines macros, give the file that uses "
    "them; if it is an SRDF, give the URDF, and this file with --srdf",
    urdf('<link name="a"/>'): ": no link has mass, so nothing in it can be struck; give at least one link an <inertial>",
    urdf(link("a", mass="0")): ": no link has mass, so nothing in it can be struck; give at least one link an <inertial>",
    urdf(link("a"), "<link/>"): ": <link> number 2 has no name; give it one",
    arm(elbow=joint("", "base", "tip")): ": <joint> number 1 has no name; give it one",
    urdf(link("a"), link("a")): ': two links are called "a"; names have to be unique, so rename one',
    urdf(link("a"), link("b"), link("c"), joint("j", "a", "b"), joint("j", "a", "c")): (
        ': two joints are called "j"; names have to be unique, so rename one'
    ),
    urdf(link("universe")): ': link "universe" has the name that Pinocchio gives to the world; rename it',
    arm(elbow=joint("root_joint", "base", "tip")): (
        ': joint "root_joint" has the name that Pinocchio gives to the free base; rename it'
    ),
    arm(elbow=joint("elbow", "base", "hand")): (
        ': joint "elbow": its child is link "hand", which does not exist; every joint has to join two links of the file'
    ),
    arm(elbow=joint("elbow", "body", "tip")): (
        ': joint "elbow": its parent is link "body", which does not exist; every joint has to join two links of the file'
    ),
    arm().replace('<parent link="base"/>', ""): (
        ': joint "elbow": it names no parent link; every joint has to join two links of the file'
    ),
    urdf(link("a"), link("b")): (': 2 links have no parent: "a", "b"; a robot has one root, so join the others to it'),
    urdf(*(link(name) for name in "abcdefg")): (
        ': 7 links have no parent: "a", "b", "c", "d", "e" and 2 more; a robot has one root, so join the others to it'
    ),
    urdf(link("a"), link("b"), joint("j", "a", "b"), joint("k", "b", "a")): (
        ': a circle that no root link carries holds "j", "k"; a URDF is a tree, so remove one of these joints'
    ),
    urdf(link("a"), link("b"), link("c"), joint("j", "b", "c"), joint("k", "c", "b")): (
        ': a circle that no root link carries holds "j", "k"; a URDF is a tree, so remove one of these joints'
    ),
    urdf(link("a"), link("b"), joint("j", "b", "b")): (
        ': a circle that no root link carries holds "j"; a URDF is a tree, so remove one of these joints'
    ),
    urdf(link("a"), link("b"), link("c"), joint("j", "a", "b"), joint("k", "a", "c"), joint("l", "b", "c")): (
        ': link "c" is the child of two joints, "k" and "l"; a URDF is a tree, so cut the loop at one of them'
    ),
    arm(elbow=joint("elbow", "base", "tip", "ball")): (
        ': joint "elbow" is of type "ball", which URDF does not have; '
        'it has "revolute", "continuous", "prismatic", "fixed", "floating", "planar"'
    ),
}


NUMBERS = {
    **{
        arm(tip=link("tip", mass=mass)): f': link "tip": <mass> value is "{mass}"; it has to be one finite number, such as 0.5'
        for mass in ("inf", "1e999", "0x10", "${m}")
    },
    **{
        arm(tip=link("tip", mass=mass)): (
            f': link "tip": <mass> value is {mass} kg, which cannot be computed with; give numbers up to 1e+24, and masses of '
            "at least 1e-15 kg, or 0"
        )
        for mass in ("1e+25", "1e-19")
    },
    arm(elbow=joint("elbow", "base", "tip", more=f'<origin xyz="0 -1e+25 0"/>{LIMIT}')): (
        ': joint "elbow": <origin> xyz is -1e+25 m, which cannot be computed with; give numbers up to 1e+24, and masses of '
        "at least 1e-15 kg, or 0"
    ),
    arm(elbow=joint("elbow", "base", "tip", more=LIMIT + 2 * MIMIC.format("lead"))): (
        ': joint "elbow" has several <mimic>, and a joint can follow only one; keep one'
    ),
    arm(tip=link("tip", mass="nan")): ': link "tip": <mass> value is "nan"; it has to be one finite number, such as 0.5',
    **{
        arm(tip=link("tip", mass=mass)): f': link "tip": <mass> value is "{mass}"; it has to be one finite number, such as 0.5'
        for mass in ("1e400", "1_0")
    },
    urdf(
        link("l0"), *(f"{link(f'l{k}')}{joint(f'j{k}', 'l0', f'l{k}', 'floating', more='')}" for k in range(1, 102))
    ): ": it moves with 612 velocities, and up to 606 are computed; fix joints that do not matter",
    arm(tip=link("tip", mass="1,5")): ': link "tip": <mass> value is "1,5"; it has to be one finite number, such as 0.5',
    arm(tip=link("tip", mass="-1")): ': link "tip": mass -1 kg is negative; give the mass that the body has, or 0',
    arm(tip=link("tip").replace('<mass value="1"/>', "<mass/>")): (
        ': link "tip": <mass> value is missing; it has to be one finite number, such as 0.5'
    ),
    arm(tip=link("tip").replace('<mass value="1"/>', "")): (
        ': link "tip": <mass> value is missing; it has to be one finite number, such as 0.5'
    ),
    arm(tip=link("tip", inertia="")): (': link "tip": <inertia> ixx is missing; it has to be one finite number, such as 0.5'),
    arm(tip=link("tip", inertia=INERTIA.replace('ixy="0"', ""))): (
        ': link "tip": <inertia> ixy is missing; it has to be one finite number, such as 0.5'
    ),
    arm(tip=link("tip", inertia=INERTIA.replace('iyy="0.1"', 'iyy="-0.1"'))): (
        ': link "tip": iyy = -0.1 kg m² is negative; give the moment of inertia that the body has'
    ),
    arm(tip=link("tip", inertia='<origin xyz="0 0"/>' + INERTIA)): (
        ': link "tip": <origin> xyz is "0 0"; it has to be 3 finite numbers, such as 0 0 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", axis="0 0 0")): (
        ': joint "elbow": its axis is 0 0 0, so it has no direction; give it one, of length 1'
    ),
    arm(elbow=joint("elbow", "base", "tip", axis="0 nan 0")): (
        ': joint "elbow": <axis> xyz is "0 nan 0"; it has to be 3 finite numbers, such as 0 0 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=f'<origin rpy="0 x 0"/>{LIMIT}')): (
        ': joint "elbow": <origin> rpy is "0 x 0"; it has to be 3 finite numbers, such as 0 0 0.5'
    ),
    arm(elbow=joint("elbow", "base", "tip", more="")): (
        ': joint "elbow" is revolute and has no <limit>, which URDF requires; add one, or make it continuous'
    ),
    arm(elbow=joint("elbow", "base", "tip", "prismatic", more="")): (
        ': joint "elbow" is prismatic and has no <limit>, which URDF requires; add one'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=f'{LIMIT}<mimic joint="other" multiplier="nan"/>')).replace(
        "</robot>", f"{link('third')}{joint('other', 'base', 'third')}</robot>"
    ): ': joint "elbow": <mimic> multiplier is "nan"; it has to be one finite number, such as 0.5',
    arm(elbow=joint("elbow", "base", "tip", "planar", axis="0 1 0", more="")): (
        ': joint "elbow": planar with the normal 0 1 0 (1 0 0 where none is written), but Pinocchio moves it in x and y; '
        'turn the joint\'s <origin> so that <axis xyz="0 0 1"/> is the normal'
    ),
}


def test_what_does_not_move_is_kept_from_the_parser(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """Its parser refuses a file for a deep element, a comment or a colour that mean nothing for the motion, and prints."""
    deep, colour = "<a>" * 480 + "</a>" * 480, '<material name="m"><color rgba="300 0 0 1"/></material>'
    visual = f'<visual><geometry><sphere radius="1"/></geometry>{colour}</visual>'
    plain, decorated = arm(), arm(tip=link("tip", more=visual)).replace("</robot>", f"{deep}<?php x?>{colour}</robot>")
    assert loaded(tmp_path, decorated).model == loaded(tmp_path, plain).model
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("text", [*TREE, *NUMBERS])
def test_what_is_no_tree_of_bodies_is_refused(text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """By the name of the link or joint at fault, and nothing is printed; the parser alone would go on without that body's mass."""
    assert refusal(tmp_path, text) == f"dog.urdf{(TREE | NUMBERS)[text]}"
    assert capfd.readouterr() == ("", "")


def test_sizes_are_limited(tmp_path: Path):
    """A chain of 600 links is read, one of 601 is not, nor are 2001 links."""
    assert len(loaded(tmp_path, chain(600)).links) == 600
    assert refusal(tmp_path, chain(601)) == (
        'dog.urdf: link "l600" is the end of a chain of more than 600 links, which is not computed'
    )
    star = urdf(*(link(f"l{k}") for k in range(2001)), *(joint(f"j{k}", "l0", f"l{k}") for k in range(1, 2001)))
    assert (
        refusal(tmp_path, star)
        == "dog.urdf: it has 2001 links, and up to 2000 are read; leave out those that neither move nor weigh"
    )


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
