"""SDFormat: the same robot as its URDF, however its poses, axes and ends are written."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from robot_texts import loaded, refusal

from shockpc import Contact, Joints, Scene, shock_profile
from shockpc.landing.joint_model import joint_model

MOMENTS = "<inertia><ixx>.1</ixx><iyy>.2</iyy><izz>.25</izz><ixy>.01</ixy></inertia>"
URDF = """<robot name="leg">
<link name="trunk"><inertial><origin xyz=".1 0 0"/><mass value="5"/><inertia ixx=".1" iyy=".2" izz=".25" ixy=".01" ixz="0" iyz="0"/>
</inertial></link><link name="imu"/>
<joint name="imu_fixed" type="fixed"><origin xyz="0 .05 .1"/><parent link="trunk"/><child link="imu"/></joint>
<link name="shank"><inertial><origin xyz="0 -.1 0" rpy=".5 0 0"/><mass value="1"/>
<inertia ixx=".1" iyy=".2" izz=".25" ixy=".01" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0 -.2 0"/><geometry><sphere radius=".02"/></geometry></collision></link>
<joint name="knee" type="revolute"><origin xyz=".2 0 -.1" rpy=".3 0 0"/><parent link="trunk"/><child link="shank"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="7" velocity="0"/></joint></robot>"""
SHANK = f"""<inertial><pose>0 -.1 0 .5 0 0</pose><mass>1</mass>{MOMENTS}</inertial>
<collision name="c"><pose>0 -.2 0 0 0 0</pose><geometry><sphere><radius>.02</radius></sphere></geometry></collision>"""
ENDS = "<parent>trunk</parent><child>shank</child>"
LIMIT = "<limit><lower>-1</lower><upper>2</upper><effort>7</effort></limit>"
PLACED = '<pose relative_to="trunk">.2 0 -.1 .3 0 0</pose>'
WRITTEN = {
    "relative to a link": (PLACED, "", f"<xyz>0 0 1</xyz>{LIMIT}"),
    "in the model": (
        "<pose degrees='true'>.2 0 .4 17.188733853924695 0 0</pose>",
        "",
        f"<xyz>0 0 1</xyz>{LIMIT}",
    ),
    "degrees=1": (
        "<pose degrees='1'>.2 0 .4 17.188733853924695 0 0</pose>",
        "",
        f"<xyz>0 0 1</xyz>{LIMIT}",
    ),
    "quaternion": (
        f'<pose relative_to="trunk" rotation_format="quat_xyzw">.2 0 -.1 {2 * np.sin(0.15)} 0 0 '
        f"{2 * np.cos(0.15)}</pose>",
        "",
        f"<xyz>0 0 1</xyz>{LIMIT}",
    ),
    "frame until 1.6": (
        PLACED.replace("relative_to", "frame"),
        "",
        f"<xyz>0 0 1</xyz>{LIMIT}",
        "revolute",
        "1.6",
    ),
    "axis until 1.6": (
        PLACED,
        "",
        f"<xyz>0 {-np.sin(0.3)} "
        f"{np.cos(0.3)}</xyz><use_parent_model_frame>TRUE</use_parent_model_frame>{LIMIT}",
        "Revolute",
        "1.6",
    ),
    "relative to the joint": ('<pose relative_to="knee"/>', PLACED, f"<xyz>0 0 1</xyz>{LIMIT}"),
    "axis of the model": (
        PLACED,
        "",
        f'<xyz expressed_in="__model__">0 {-np.sin(0.3)} {np.cos(0.3)}</xyz>{LIMIT}',
    ),
}


def sdf(
    pose: str = PLACED,
    joint_pose: str = "",
    axis: str = WRITTEN["relative to a link"][2],
    kind: str = "revolute",
    version: str = "1.9",
) -> str:
    """The leg as an SDF."""
    sensor = '<sensor type="imu" name="imu"><pose>0 .05 .1 0 0 0</pose></sensor>'
    trunk = (
        f'<link name="trunk"><pose>0 0 .5 0 0 0</pose><inertial><pose>.1 0 0 0 0 '
        f"0</pose><mass>5</mass>{MOMENTS}</inertial>{sensor}"
    )
    joint = f'<joint name="knee" type="{kind}">{joint_pose}{ENDS}<axis>{axis}</axis></joint>'
    return (
        f'<sdf version="{version}"><model name="leg">{trunk}</link><link '
        f'name="shank">{pose}{SHANK}</link>{joint}</model></sdf>'
    )


@pytest.mark.parametrize("written", WRITTEN)
def test_an_sdf_is_the_urdf_of_the_same_robot(written: str, tmp_path: Path):
    """Inertia matrix, limits and shock agree with the URDF, however the poses are written."""
    robot, reference = loaded(tmp_path, sdf(*WRITTEN[written]), "leg.sdf"), loaded(tmp_path, URDF)
    assert (robot.name, robot.warnings, robot.joint_names) == ("leg", (), reference.joint_names)
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = pin.integrate(reference.model, reference.start, rng.normal(size=reference.model.nv))
        H, expected = (pin.crba(one.model, one.model.createData(), q) for one in (robot, reference))
        np.testing.assert_allclose(H, expected, atol=1e-14)
    np.testing.assert_allclose(robot.model.lowerPositionLimit[7:], -1.0)
    np.testing.assert_allclose(robot.model.upperEffortLimit[6:], 7.0)
    one, other = (
        shock_profile(Scene(robot="leg", contact=(Contact(frame="shank"),)), leg)
        for leg in (robot, reference)
    )
    np.testing.assert_allclose(
        one.value("shock", "point"), other.value("shock", "point"), rtol=1e-12
    )
    assert one.points[0].frame == "imu"


def test_a_link_without_inertial_has_the_mass_of_the_format(tmp_path: Path):
    """1 kg and 1 kg m², as in Gazebo, with a warning; a limit of inf is none."""
    text = sdf(
        axis=(
            "<xyz>0 0 "
            "1</xyz><limit><lower>-inf</lower><upper>inf</upper><effort>inf</effort></limit>"
        )
    )
    bare = loaded(tmp_path, text.replace(SHANK, ""), "leg.sdf")
    assert 'links "shank" have no <inertial>' in bare.warnings[0]
    shank = bare.model.inertias[bare.model.getJointId("knee")]
    assert shank.mass == 1.0
    np.testing.assert_array_equal(shank.inertia, np.eye(3))
    assert bare.joints[-1].kind == "continuous"


def test_a_frame_is_one_of_the_link_that_it_is_attached_to(tmp_path: Path):
    """By way of another frame, and of a joint."""
    frames = (
        '<frame name="end" attached_to="knee"><pose>0 -.2 0 0 0 0</pose></frame><frame name="toe" '
        'attached_to="end"/>'
    )
    robot = loaded(tmp_path, sdf().replace("</model>", f"{frames}</model>"), "leg.sdf")
    toe = robot.model.frames[robot.model.getFrameId("toe")]
    assert toe.parentJoint == robot.model.getJointId("knee")
    np.testing.assert_allclose(toe.placement.translation, [0.0, -0.2, 0.0], atol=1e-15)


def test_the_ends_of_a_joint_may_be_frames(tmp_path: Path):
    """The joint stands at the frame that is its child; both links are those to which the frames are
    attached.
    """
    frames = (
        f'<frame name="hip" attached_to="trunk"/><frame name="socket" attached_to="shank"><pose>0 '
        f"0 .1 0 0 0</pose></frame>{ENDS}"
    )
    text = sdf(joint_pose="<pose>0 0 -.1 0 0 0</pose>").replace(
        "</model>", f"{frames.replace(ENDS, '')}</model>"
    )
    named = text.replace(ENDS, "<parent>hip</parent><child>socket</child>")
    one, other = loaded(tmp_path, named, "leg.sdf"), loaded(tmp_path, URDF)
    q = pin.integrate(
        other.model, other.start, np.random.default_rng(0).normal(size=other.model.nv)
    )
    np.testing.assert_allclose(
        *(pin.crba(leg.model, leg.model.createData(), q) for leg in (one, other)), atol=1e-14
    )


def test_frames_may_hang_on_one_another_without_end(tmp_path: Path):
    """1500 of them, each a millimetre from the one before; more than 2000 links are refused before
    they are placed.
    """
    one = '<frame name="f{}" attached_to="{}"><pose>.001 0 0 0 0 0</pose></frame>'
    chain = "".join(one.format(i, f"f{i - 1}" if i else "trunk") for i in range(1500))
    robot = loaded(tmp_path, sdf().replace("</model>", f"{chain}</model>"), "leg.sdf")
    np.testing.assert_allclose(
        robot.model.frames[robot.model.getFrameId("f1499")].placement.translation,
        [1.5, 0, 0],
        atol=1e-12,
    )
    assert "40003 links" in refusal(
        tmp_path, sdf().replace("</model>", f"{one.format(0, 'trunk') * 40_000}</model>"), "leg.sdf"
    )


def test_a_drive_of_drake_adds_its_inertia_times_the_square_of_the_ratio(tmp_path: Path):
    """I n², whatever the sign of n, as Drake's mass matrix has it."""
    drive = "<drake:rotor_inertia>1e-4</drake:rotor_inertia><drake:gear_ratio>-9</drake:gear_ratio>"
    driven = loaded(tmp_path, sdf(joint_pose=drive), "leg.sdf")
    np.testing.assert_allclose(driven.model.armature, [0.0] * 6 + [0.0081], rtol=1e-12)
    assert loaded(
        tmp_path, sdf(joint_pose="<drake:gear_ratio>9</drake:gear_ratio>"), "leg.sdf"
    ).gear_ratios == {"knee": 9.0}


MIMICS = {
    '<drake:mimic joint="knee" multiplier="2" offset="0.1"/>': "",
    "": (
        "<mimic "
        'joint="knee"><multiplier>2</multiplier><offset>0.5</offset><reference>0.2</reference></mimic>'
    ),
}


@pytest.mark.parametrize("in_joint", MIMICS, ids=["Drake", "SDFormat"])
def test_a_joint_follows_another(in_joint: str, tmp_path: Path):
    """Both ways of writing q = 2 (q_knee - 0.2) + 0.5."""
    toe = (
        '<link name="toe"><inertial><mass>1</mass></inertial></link><joint name="ankle" '
        'type="revolute">'
    )
    toe += (
        f"{in_joint}<parent>shank</parent><child>toe</child><axis>{MIMICS[in_joint]}<xyz>0 1 "
        f"0</xyz></axis></joint></model>"
    )
    (mimic,) = loaded(tmp_path, sdf().replace("</model>", toe), "leg.sdf").mimics
    assert (mimic.joint, dict(mimic.leaders)) == ("ankle", {"knee": 2.0})
    np.testing.assert_allclose(mimic.offset, 0.1, rtol=1e-12)


UNKNOWN = {
    "<mass>5</mass>": ("<mas>6</mas>", ["trunk", "<mas>", "nearest: <mass>"]),
    "<pose>0 0 .5 0 0 0</pose>": (
        '<pose degree="1">0 0 .5 0 0 0</pose>',
        ["trunk", "degree of", "nearest: degrees"],
    ),
    LIMIT: ("<limits><lower>-1</lower></limits>", ["knee", "<limits>", "nearest: <limit>"]),
    "<child>": (
        "<use_parent_model_frame>1</use_parent_model_frame><child>",
        ["knee", "<use_parent_model_frame>"],
    ),
    "</model>": ('<lnik name="battery"/></model>', ['"battery"', "<lnik>", "nearest: <link>"]),
    ENDS: (f"{ENDS}<pose>0 0 0 0 0 0</pose><pose>0 0 1 0 0 0</pose>", ["knee", "<pose>", "first"]),
    LIMIT + "</axis>": (
        f"{LIMIT}</axis><drake:rotr_inertia>1</drake:rotr_inertia>",
        ["knee", "nearest: <drake:rotor_inertia>"],
    ),
    "<axis>": (
        "<axis><drake:gear_ratio>9</drake:gear_ratio>",
        ["knee", "joint/axis/drake:gear_ratio"],
    ),
    '<sensor type="imu"': (
        '<kinematic>1</kinematic><sensor type="imu"',
        ["trunk", "link/kinematic"],
    ),
}


@pytest.mark.parametrize("written", UNKNOWN, ids=range(len(UNKNOWN)))
def test_what_is_left_out_is_reported_by_name(written: str, tmp_path: Path):
    """With the link or joint and the nearest name; what other programs read, and what is read as
    before, is not reported.
    """
    instead, words = UNKNOWN[written]
    text = sdf().replace(
        "</model>",
        "<drake:other/><plugin name='p' filename='f'><a/></plugin><state_of_a_program/></model>",
    )
    assert loaded(tmp_path, text, "leg.sdf").warnings == ()
    said = " ".join(loaded(tmp_path, text.replace(written, instead, 1), "leg.sdf").warnings)
    assert [word for word in words if word not in said] == []


def test_a_joint_may_be_called_like_its_link(tmp_path: Path):
    """Version 1.4, whose axes are those of the model and whose poses are relative to it."""
    axis = f"<xyz>0 {-np.sin(0.3)} {np.cos(0.3)}</xyz>{LIMIT}"
    text = sdf("<pose>.2 0 .4 .3 0 0</pose>", axis=axis).replace(
        'joint name="knee"', 'joint name="shank"'
    )
    old, reference = loaded(tmp_path, text.replace("1.9", "1.4"), "leg.sdf"), loaded(tmp_path, URDF)
    q = pin.integrate(
        reference.model, reference.start, np.random.default_rng(0).normal(size=reference.model.nv)
    )
    np.testing.assert_allclose(
        *(pin.crba(one.model, one.model.createData(), q) for one in (old, reference)), atol=1e-14
    )


def test_a_link_away_from_its_joint_is_moved_there(tmp_path: Path):
    """Its frame is that of the joint, with a warning; its mass stays where it is."""
    away = '<pose relative_to="trunk">.2 -.3 -.1 .3 0 0</pose>'
    moved, plain = (
        loaded(tmp_path, sdf(away, joint_pose), "leg.sdf") for joint_pose in (PLACED, "")
    )
    assert 'the frames of links "shank" are moved' in moved.warnings[0]
    centres = [
        pin.centerOfMass(leg.model, leg.model.createData(), leg.start) for leg in (moved, plain)
    ]
    np.testing.assert_allclose(*centres, atol=1e-14)


AROUND = (
    '<frame name="a" attached_to="{}"><pose relative_to="trunk"/></frame><frame name="b" '
    'attached_to="a"/></model>'
)
REFUSED = {
    sdf().replace(
        "</model>", AROUND.format("b")
    ): 'a frame is attached to "a", which is attached to it',
    sdf().replace(
        "</model>", AROUND.format("nobody")
    ): 'a frame is attached to "nobody", which does not exist',
    sdf().replace(
        "<inertial>", '<inertial auto="1">', 1
    ): 'link "trunk": <inertial auto> is not read',
    sdf().replace("<inertial>", '<inertial auto="yes">', 1): 'auto is "yes"',
    sdf().replace(
        "<pose>.1 0 0", '<pose relative_to="shank">.1 0 0', 1
    ): '<inertial> is relative to "shank"',
    sdf(version="1.0"): 'version "1.0"',
    sdf().replace(
        "<lower>-1<", "<lower>+-inf<"
    ): 'joint "knee": <lower> is "+-inf"; it has to be one finite number',
    sdf(axis="<xyz>0 1</xyz>"): 'joint "knee": <xyz> is "0 1"; it has to be 3 finite numbers',
    sdf().replace(' version="1.9"', ""): "has no version",
    sdf(kind="continuous")
    .replace("<axis>", "<axiss>")
    .replace("</axis>", "</axiss>"): 'joint "knee" is continuous and has no <axis>',
    sdf().replace("<child>shank</child>", ""): 'joint "knee": it names no child link',
    sdf().replace("<model", "<world><joint/></world><model"): "<joint> (world/joint) is not read",
    sdf(kind="universal"): 'joint "knee" is of type "universal", which is not read',
    sdf(
        pose='<pose relative_to="nobody"/>'
    ): 'a pose is relative to "nobody", which does not exist',
    sdf(
        pose='<pose relative_to="shank"/>'
    ): 'a pose is relative to "shank", which is relative to it',
    sdf(pose="<pose>1 2</pose>"): '<pose> is "1 2"; it has to be 6 finite numbers',
    sdf(
        axis="<xyz>0 0 1</xyz><dynamics><spring_stiffness>3</spring_stiffness></dynamics>"
    ): 'joint "knee" has a spring',
    '<sdf version="1.9"/>': "has 0 models that may move; give a file with one",
    '<sdf version="1.9"><model name="a"><include><uri>model://b</uri></include></model></sdf>': "<include> (include) is not read",
}


@pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
def test_what_is_not_read_is_refused(text: str, tmp_path: Path):
    """By its name."""
    assert REFUSED[text] in refusal(tmp_path, text, "leg.sdf")


@pytest.mark.parametrize("effort", ["", "<effort>-1</effort>", "<effort>inf</effort>"])
def test_a_joint_of_unlimited_effort_is_no_passive_one(effort: str, tmp_path: Path):
    """Nothing is known of its drive, also beside a joint whose effort is limited."""
    toe = (
        '<link name="toe"><inertial><mass>1</mass></inertial></link><joint name="ankle" '
        'type="revolute"><parent>shank</parent>'
    )
    toe += (
        f"<child>toe</child><axis><xyz>0 1 "
        f"0</xyz><limit><lower>-1</lower><upper>1</upper>{effort}</limit></axis></joint></model>"
    )
    robot = loaded(tmp_path, sdf().replace("</model>", toe), "leg.sdf")
    unknown = joint_model(robot, Joints()).unknown
    assert [name for name in ("knee", "ankle") if unknown[robot.joint(name).v].all()] == [
        "knee",
        "ankle",
    ]
