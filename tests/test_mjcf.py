"""MJCF: what is read equals MuJoCo's own reading, to the last digits."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import BODY, HINGE, body, floating, mjcf

from shockpc.robot.build import build_model
from shockpc.robot.source import RobotSource, read_source


@pytest.fixture(autouse=True)
def logs_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """MuJoCo writes its warnings into a file in the current folder."""
    monkeypatch.chdir(tmp_path)


BOX = '<geom type="box" size=".1 .2 .3"/>'
MESH = '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
FRAMED_JOINT = '<frame pos="1 0 0" euler="0 0 30"><joint axis="1 2 3" pos="0 1 0"/></frame>'
TURNED = 'pos="0.3 0.1 -.2" euler="10 20 30"'

ENDS = 'fromto="0.1 0.2 -0.3 0.4 -0.1 0.2"'
PLACED = '<site name="site{}" pos="0.1 0.2 -0.3" euler="30 20 10"/>'
HAND = body("hand", PLACED.format(2) + body("thumb", PLACED.format(3) + body("tip", BODY + PLACED.format(4)), ""), "")

READ = {
    "plain": mjcf(floating(body("b"))),
    "joint free": mjcf(floating(body("b")).replace('<freejoint name="root"/>', '<joint type="free"/>')),
    "base placed and turned": mjcf(floating(body("b"), at='pos="0 0 1" euler="0 30 0"')),
    "fixed base placed and turned": mjcf(
        floating(body("b"), at='pos="0 0 1" euler="0 30 0"').replace('<freejoint name="root"/>', "")
    ),
    "joint position": mjcf(floating(body("b", joints='<joint axis="0 1 0" pos="0.05 0 0.1"/>'))),
    "long axis": mjcf(floating(body("b", joints='<joint axis="0 2 1"/>'))),
    "slide": mjcf(floating(body("b", joints='<joint type="slide" axis="0 3 0"/>'))),
    "ball": mjcf(floating(body("b", joints='<joint type="ball" pos="0 .1 0"/>'))),
    "two hinges": mjcf(floating(body("b", joints='<joint axis="0 1 0" pos="0 0 .1"/><joint axis="1 0 0" pos="0 .1 0"/>'))),
    "reference angle": mjcf(floating(body("b", joints='<joint axis="0 1 0" ref="30"/>'))),
    "armature": mjcf(floating(body("b", joints='<joint armature="0.3"/>'))),
    "default armature": mjcf(floating(body("b")), "<default><joint armature='0.2'/></default>"),
    "default joint position": mjcf(floating(body("b")), '<default><joint pos="0 0.2 .1"/></default>'),
    "default geom mass": mjcf(floating(body("b", BOX)), '<default><geom mass="3"/></default>'),
    "default geom density": mjcf(floating(body("b", BOX)), '<default><geom density="100"/></default>'),
    "classes": mjcf(
        floating(body("b", at='pos="1 0 0" childclass="c"', joints='<joint/><joint class="d" pos="0 1 0"/>')),
        '<default><joint axis="1 0 0"/><default class="c"><joint armature=".2"/><default class="d"><joint axis="0 0 1"/>'
        "</default></default></default>",
    ),
    "defaults below the bodies": mjcf(floating(body("b")), after="<default><joint armature='.2'/></default>"),
    "defaults twice": mjcf(floating(body("b")), "<default><joint damping='1'/></default><default><joint armature='.2'/></default>"),
    "compiler below": mjcf(floating(body("b", at='euler=".1 .2 .3"')), after='<compiler angle="radian"/>'),
    "compiler twice": mjcf(floating(body("b", at='euler=".1 .2 .3"')), '<compiler autolimits="true"/><compiler angle="radian"/>'),
    "world twice": mjcf(floating(body("b"))).replace(
        "</mujoco>", '<worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>'
    ),
    "euler": mjcf(floating(body("b", at=TURNED))),
    "euler ZYX": mjcf(floating(body("b", at=TURNED)), '<compiler eulerseq="ZYX"/>'),
    "euler xYz": mjcf(floating(body("b", at=TURNED)), '<compiler eulerseq="xYz"/>'),
    "zaxis down": mjcf(floating(body("b", at='zaxis="0 0 -2"'))),
    "xyaxes half turn": mjcf(floating(body("b", at='xyaxes="-1 0 0 0 1 0"'))),
    "frame": mjcf(
        floating(
            f'<frame pos="0 0 1" euler="0 20 0">{body("b", at=TURNED)}<geom type="capsule" size=".1" fromto="0 0 0 1 0 0"/>'
            f'<frame axisangle="1 1 0 40">{body("c", joints=FRAMED_JOINT)}'
            '<geom type="box" size=".1 .2 .3" euler="10 0 0"/></frame></frame>'
        ).replace(BODY, "", 1)
    ),
    "frame with a class": mjcf(
        floating(f'<frame childclass="c">{body("b", joints="<joint/>")}</frame>'),
        '<default><default class="c"><joint armature=".2" axis="1 0 0"/></default></default>',
    ),
    "inertias from geoms": mjcf(floating(body("b", BODY + BOX)), '<compiler inertiafromgeom="true"/>'),
    "inertias from some geoms": mjcf(
        floating(body("b", BOX.replace("/>", ' group="1"/>') + BOX.replace("/>", ' group="3"/>'))),
        '<compiler inertiagrouprange="1 2"/>',
    ),
    "euler zyx": mjcf(floating(body("b", at=TURNED)), '<compiler eulerseq="zyx"/>'),
    "axisangle": mjcf(floating(body("b", at='pos="0.3 0.1 -.2" axisangle="1 1 0 30"'))),
    "xyaxes": mjcf(floating(body("b", at='xyaxes="1 1 0 0 1 1"'))),
    "zaxis": mjcf(floating(body("b", at='zaxis="1 1 0"'))),
    "quaternion": mjcf(floating(body("b", at='quat="1 1 0 0"'))),
    "full inertia": mjcf(floating(body("b", '<inertial pos="0 .1 0" mass="1" fullinertia=".1 .2 .25 .01 .02 .03"/>'))),
    "turned inertia": mjcf(floating(body("b", '<inertial pos="0 .1 0" axisangle="0 2 1 30" mass="1" diaginertia=".1 .2 .25"/>'))),
    "geoms": mjcf(floating(body("b", BOX + '<geom type="capsule" size=".05" fromto="0 0 0 .1 .2 -.4" mass="2"/>'))),
    "inertial over geoms": mjcf(floating(body("b", BODY + BOX))),
    "inertial over a mesh": mjcf(floating(body("b", BODY + '<geom type="mesh" mesh="m"/>')), MESH),
    "weightless mesh": mjcf(floating(body("b", BOX + '<geom type="mesh" mesh="m" density="0"/>')), MESH),
    "body without joint": mjcf(floating(body("b", joints=""))),
    "nameless bodies": mjcf(floating(body("b").replace('name="b"', "")).replace('name="base"', "")),
    "actuator gear": mjcf(floating(body("b", joints=HINGE)), after='<actuator><motor joint="j" gear="10"/></actuator>'),
    "loop switched off": mjcf(
        floating(body("b"), body("c", joints="")), after='<equality><weld body1="b" body2="c" active="false"/></equality>'
    ),
    "sites": mjcf(
        '<site name="in_world" pos="1 2 3" euler="10 0 20"/>'
        + floating(
            PLACED.format(0)
            + body("b", BODY + PLACED.format(1) + HAND, '<joint axis="0 1 0" pos="0.05 0 0.1"/>')
            + body("c", BODY + PLACED.format(5), '<joint axis="0 1 0" pos="0 0 .1"/><joint axis="1 0 0" pos="0 .1 0"/>')
        )
    ),
    "sites on a fixed base": mjcf(f'<body name="base">{PLACED.format(0)}{body("b", BODY + HAND, "<joint/>")}</body>'),
    "sites between two ends": mjcf(
        floating(
            f'<site name="s0" type="capsule" size=".01" {ENDS}/>'
            + f'<frame {TURNED}><site name="s1" type="cylinder" size=".01" {ENDS}/></frame>'
            + body("b", BODY + '<site name="s2" type="box" size=".01" fromto="0 0 -.1 0 0 .3"/>')
        )
    ),
    "robot in a frame of the world": mjcf(
        f'<frame {TURNED}><frame pos="0 0 1"><site name="s0"/>{floating(body("b"), at=TURNED)}</frame></frame>'
    ),
    "fixed base in a frame of the world": mjcf(
        f"<frame {TURNED}>{floating(body('b'), at=TURNED)}</frame>".replace('<freejoint name="root"/>', "")
    ),
    "table first": mjcf('<body name="table" pos="1 0 0"><geom size=".1"/></body>' + floating(body("b"))),
}


def read(folder: Path, text: str) -> RobotSource:
    """Read an MJCF with this text."""
    (folder / "dog.xml").write_text(text)
    return read_source(str(folder / "dog.xml"))


@pytest.mark.parametrize("name", READ)
def test_inertia_equals_mujocos(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    """Joint-space inertia and the place of every body and site are MuJoCo's, in MuJoCo's own reference posture."""
    model = build_model(read(tmp_path, READ[name]))
    assert capfd.readouterr() == ("", "")
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "dog.xml"))
    state = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, state)
    inertia = np.zeros((theirs.nv, theirs.nv))
    mujoco.mj_fullM(theirs, state, inertia)

    q = next(entry.data() for entry in model.referenceConfigurations if entry.key() == "qpos0").copy()
    to_world = np.eye(model.nv)
    if theirs.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        q[:3], q[3:7] = theirs.qpos0[:3], theirs.qpos0[[4, 5, 6, 3]]
        # MuJoCo counts the base's linear velocity in the world's axes, Pinocchio in the base's own.
        to_world[:3, :3] = state.xmat[theirs.jnt_bodyid[0]].reshape(3, 3).T
    data = model.createData()
    ours = pin.crba(model, data, q)
    ours = np.triu(ours) + np.triu(ours, 1).T
    assert np.abs(to_world.T @ ours @ to_world - inertia).max() < 1e-13 * np.abs(inertia).max()

    pin.framesForwardKinematics(model, data, q)
    for number in range(1, theirs.nbody):
        body_name = theirs.body(number).name
        if body_name and body_name != "table":
            place = data.oMf[model.getFrameId(body_name, pin.FrameType.BODY)]
            np.testing.assert_allclose(place.translation, state.xpos[number], atol=1e-14)
            np.testing.assert_allclose(place.rotation.ravel(), state.xmat[number], atol=1e-14)
    for number in range(theirs.nsite):
        place = data.oMf[model.getFrameId(theirs.site(number).name, pin.FrameType.OP_FRAME)]
        np.testing.assert_allclose(place.translation, state.site_xpos[number], atol=1e-14)
        np.testing.assert_allclose(place.rotation.ravel(), state.site_xmat[number], atol=1e-14)


def test_what_cannot_move_is_left_out(tmp_path: Path):
    """Furniture is left out with a line that says so."""
    source = read(tmp_path, READ["table first"])
    assert source.warnings == ('dog.xml: "table" cannot move and is left out; a strike on the robot does not reach it',)
    assert source.robot_name == "m"
    assert source.kind == "mjcf"


def test_keyframes(tmp_path: Path):
    """A keyframe becomes a posture; one of the wrong size is left out with a line that says so."""
    keys = '<keyframe><key name="home" qpos="1 2 3 1 0 0 0 .3"/><key name="old" qpos="1 2 3"/></keyframe>'
    source = read(tmp_path, mjcf(floating(body("b")), after=keys))
    assert source.warnings == ('dog.xml: keyframe "old" does not hold 8 finite numbers; the posture is left out',)
    postures = {entry.key(): entry.data() for entry in build_model(source).referenceConfigurations}
    np.testing.assert_array_equal(postures["home"], [1, 2, 3, 0, 0, 0, 1, 0.3])
    assert "old" not in postures


def test_includes_and_mesh_folder(tmp_path: Path):
    """Included parts take their place, counted from the main file's folder; the mesh folder becomes absolute."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "limb.xml").write_text(f"<mujocoinclude>{body('b')}{body('c', joints='')}</mujocoinclude>")
    (tmp_path / "parts" / "all.xml").write_text(
        '<mujoco><compiler angle="radian" meshdir="meshes"/><worldbody><light/></worldbody></mujoco>'
    )
    source = read(tmp_path, mjcf(floating('<include file="parts/limb.xml"/>'), '<include file="parts/all.xml"/>'))
    assert "<include" not in source.xml
    assert f'meshdir="{tmp_path}/meshes"' in source.xml
    assert [name for name in build_model(source).names] == ["universe", "root", "j"]


def test_weightless_meshes_are_left_out(tmp_path: Path):
    """Pinocchio gives a mesh 1 kg, so one without weight goes, and that is said."""
    assert read(tmp_path, READ["weightless mesh"]).warnings == (
        'dog.xml: body "b": 1 mesh without weight left out of its figure; give the body an <inertial> to see them',
    )
