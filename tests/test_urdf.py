"""URDF: what the parser would drop is corrected or refused, by the name of the link or joint at
fault.
"""

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import INERTIA, LIMIT, arm, joint, link, loaded, refusal, urdf

from shockpc import load_robot
from shockpc.robot.files.reading import parse_xml


def test_what_carries_no_meaning_is_corrected(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """A robot without a name gets its file's, blanks around numbers go, prefixes need no
    declaration; all without a word.
    """
    text = (
        arm(tip=link("tip", mass=" 2 "))
        .replace(' name="r"', "")
        .replace("</robot>", "<controller:gazebo_ros/></robot>")
    )
    robot = loaded(tmp_path, text, "dog.v2.urdf")
    assert (robot.name, robot.model.name, robot.model.inertias[2].mass, robot.warnings) == (
        "dog",
        "dog",
        2.0,
        (),
    )
    # Moments of −5e-20, as in iCub's file, are left over by an exporter.
    loaded(tmp_path, arm(tip=link("tip", inertia=INERTIA.replace("0.1", "-5.4e-20"))))
    assert capfd.readouterr() == ("", "")


MIMIC = '<mimic joint="{}"/>'
LEAD = LIMIT + MIMIC.format("lead")
CORRECTED = {
    arm(elbow=joint("elbow", "base", "tip", more=LIMIT + MIMIC.format("nobody"))): (
        'joint "elbow": mimics "nobody", which does not exist, so it moves freely'
    ),
    arm(elbow=joint("elbow", "base", "tip", more=LIMIT + MIMIC.format("elbow"))): (
        'joint "elbow": mimics itself, so it moves freely'
    ),
}


@pytest.mark.parametrize("text", CORRECTED)
def test_what_is_left_out_is_a_warning(
    text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    """It costs that element and a line, and no number."""
    robot = loaded(tmp_path, text)
    assert robot.warnings == (f"dog.urdf: {CORRECTED[text]}",)
    assert (robot.bodies[1].mass, robot.mimics) == (1.0, ())
    assert capfd.readouterr() == ("", "")


def test_a_joint_whose_file_gives_no_limits_has_none(tmp_path: Path):
    """`<limit>` with an effort alone, as exporters write it for wheels; one of the two given, the
    other is zero, as in URDF.
    """
    for given, limits in (
        ("", (-np.inf, np.inf)),
        ('upper="1"', (0.0, 1.0)),
        ('lower="0" upper="0"', (0.0, 0.0)),
    ):
        more = f'<limit effort="1" velocity="1" {given}/>'
        assert loaded(tmp_path, elbow(more)).joint("elbow").limits == limits


def chain(count: int) -> str:
    """So many links, each hanging on the one before."""
    joints = (joint(f"j{k}", f"l{k}", f"l{k + 1}", "fixed") for k in range(count - 1))
    return urdf(*(link(f"l{k}") for k in range(count)), *joints)


def tip(mass: str = "1", **given: str) -> str:
    """Two links and a joint, the second link with this mass."""
    return arm(tip=link("tip", mass, **given))


def elbow(more: str = LIMIT, kind: str = "revolute", axis: str = "0 1 0", **ends: str) -> str:
    """Two links and a joint of this kind."""
    return arm(
        elbow=joint(
            **({"name": "elbow", "parent": "base", "child": "tip"} | ends),
            kind=kind,
            axis=axis,
            more=more,
        )
    )


def hung(links: str, *joints: str) -> str:
    """Links of one letter each, and joints of three: name, parent and child."""
    return urdf(*map(link, links), *(joint(*ends) for ends in joints))


NUMBER, NUMBERS = (
    "; it has to be one finite number, such as 0.5",
    "; it has to be 3 finite numbers, such as 0 0 0.5",
)
NAMED_TWICE = 'are called "{}"'
CIRCLE = "a circle that no root link carries"
REFUSED = {
    urdf(): "has no <link>",
    urdf('<link name="a"/>'): "no link has mass",
    urdf(link("a", mass="0")): "no link has mass",
    urdf(link("a"), "<link/>"): "<link> number 2 has no name",
    elbow(name=""): "<joint> number 1 has no name",
    hung("aa"): "two links " + NAMED_TWICE.format("a"),
    hung("abc", "jab", "jac"): "two joints " + NAMED_TWICE.format("j"),
    urdf(link("universe")): 'link "universe" has the name that Pinocchio gives to the world',
    elbow(
        name="root_joint"
    ): 'joint "root_joint" has the name that Pinocchio gives to the free base',
    elbow(child="hand"): (
        'joint "elbow": its child is link "hand", which does not exist; every joint has to join '
        "two links"
    ),
    elbow(parent="body"): (
        'joint "elbow": its parent is link "body", which does not exist; every joint has to join '
        "two links"
    ),
    arm().replace('<parent link="base"/>', ""): 'joint "elbow": it names no parent link',
    hung("ab"): '2 links have no parent: "a", "b"',
    hung("abcdefg"): '7 links have no parent: "a", "b", "c", "d", "e" and 2 more',
    hung("ab", "jab", "kba"): f'{CIRCLE} holds "j", "k"',
    hung("abc", "jbc", "kcb"): f'{CIRCLE} holds "j", "k"',
    hung("abcd", "jbc", "kcb", "lcd"): f'{CIRCLE} holds "j", "k"',
    hung("ab", "jbb"): f'{CIRCLE} holds "j"',
    hung("abc", "jab", "kac", "lbc"): 'link "c" is the child of two joints, "k" and "l"',
    elbow(kind="ball"): (
        'joint "elbow" is of type "ball", which URDF does not have; it has "revolute", '
        '"continuous", "prismatic"'
    ),
    **{
        tip(mass): f'link "tip": <mass> value is "{mass}"{NUMBER}'
        for mass in ("inf", "nan", "1e999", "1e400", "0x10", "${m}", "1,5")
    },
    **{
        tip(mass): (
            f'link "tip": <mass> value is {mass} kg, which cannot be computed with; give numbers '
            f"up to"
        )
        for mass in ("1e+25", "1e-19")
    },
    tip("-1"): 'link "tip": mass -1 kg is negative; give the mass that the body has, or 0',
    tip().replace('<mass value="1"/>', "<mass/>"): 'link "base": <mass> value is missing' + NUMBER,
    tip().replace('<mass value="1"/>', ""): 'link "base": <mass> value is missing' + NUMBER,
    tip(inertia=""): 'link "tip": <inertia> ixx is missing' + NUMBER,
    tip(inertia=INERTIA.replace('ixy="0"', "")): f'link "tip": <inertia> ixy is missing{NUMBER}',
    tip(inertia='<origin xyz="0 0"/>' + INERTIA): f'link "tip": <origin> xyz is "0 0"{NUMBERS}',
    elbow(axis="0 0 0"): 'joint "elbow": its axis is 0 0 0',
    elbow().replace('xyz="0 1 0"', ""): f'joint "elbow": <axis> xyz is missing{NUMBERS}',
    elbow(axis="0 nan 0"): f'joint "elbow": <axis> xyz is "0 nan 0"{NUMBERS}',
    elbow(f'<origin rpy="0 x 0"/>{LIMIT}'): f'joint "elbow": <origin> rpy is "0 x 0"{NUMBERS}',
    elbow(f'<origin xyz="0 -1e+25 0"/>{LIMIT}'): 'joint "elbow": <origin> xyz is -1e+25 m',
    elbow(""): 'joint "elbow" is revolute and has no <limit>',
    elbow("", "prismatic"): 'joint "elbow" is prismatic and has no <limit>',
    elbow(
        LEAD + MIMIC.format("lead")
    ): 'joint "elbow" has several <mimic>, and a joint can follow only one',
    elbow(f'{LIMIT}<mimic joint="other" multiplier="nan"/>').replace(
        "</robot>", f"{link('third')}{joint('other', 'base', 'third')}</robot>"
    ): f'joint "elbow": <mimic> multiplier is "nan"{NUMBER}',
    elbow("", "planar"): (
        'joint "elbow": planar with the normal 0 1 0 (1 0 0 where none is written), but Pinocchio '
        "moves it"
    ),
    urdf(
        link("l0"),
        *(
            f"{link(f'l{k}')}{joint(f'j{k}', 'l0', f'l{k}', 'floating', more='')}"
            for k in range(1, 168)
        ),
    ): "moves with 1008 velocities, and up to 1000 are computed",
    # A chain of 600 links is read, as are 2000 links.
    chain(601): 'link "l600" is the end of a chain of more than 600 links',
    urdf(
        *(link(f"l{k}") for k in range(2001)),
        *(joint(f"j{k}", "l0", f"l{k}") for k in range(1, 2001)),
    ): ("has 2001 links, and up to 2000 are read"),
    # A floating joint has no number that could follow another.
    urdf(
        *map(link, "abc"),
        joint("elbow", "a", "b", "floating", "0 0 1", LEAD),
        joint("lead", "a", "c"),
    ): (
        'joint "elbow" is to follow joint "lead", but "elbow" has 6 degrees of freedom, and only a '
        "joint with one can"
    ),
    urdf(
        *map(link, "abc"),
        joint("elbow", "a", "b", more=LEAD),
        joint("lead", "a", "c", "planar", "0 0 1"),
    ): (
        'joint "elbow" is to follow joint "lead", but "lead" has 3 degrees of freedom, and only a '
        "joint with one can"
    ),
    # What follows a circle from outside is not part of it.
    urdf(
        *map(link, "xabcd"),
        *(
            joint(f"j{k}", "x", k, more=LIMIT + MIMIC.format(f"j{at}") * bool(at))
            for k, at in zip("abcd", ("b", "a", "a", ""), strict=True)
        ),
    ): 'mimic joints "ja", "jb" follow one another in a circle',
}


@pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
def test_what_is_no_tree_of_bodies_is_refused(
    text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    """By the name of the link or joint at fault, in one line; the parser alone would go on without
    that body.
    """
    message = refusal(tmp_path, text)
    assert message.startswith("dog.urdf")
    assert REFUSED[text] in message
    assert "\n" not in message
    assert capfd.readouterr() == ("", "")


def test_what_does_not_move_is_kept_from_the_parser(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    """Its parser refuses a file for a deep element, a comment or a colour that mean nothing for the
    motion, and prints.
    """
    deep, colour = (
        "<a>" * 480 + "</a>" * 480,
        '<material name="m"><color rgba="300 0 0 1"/></material>',
    )
    visual = f'<visual><geometry><sphere radius="1"/></geometry>{colour}</visual>'
    assert len(loaded(tmp_path, chain(600)).links) == 600
    plain, decorated = (
        arm(),
        arm(tip=link("tip", more=visual)).replace("</robot>", f"{deep}<?php x?>{colour}</robot>"),
    )
    assert loaded(tmp_path, decorated).model == loaded(tmp_path, plain).model
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "name", ["a1", "go2", "laikago", "panda", "quadruped", "solo12", "talos", "ur5"]
)
def test_mujoco_reads_the_same_robot(name: str):
    """A second reader of URDF: masses, and the inertia matrix of the joints in a posture drawn at
    random, with the base held.
    """
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
    np.testing.assert_allclose(
        ours - np.diag(robot.model.armature[columns]), theirs, atol=1e-11 * np.abs(theirs).max()
    )
    assert model.nv == robot.model.nv - 6
