"""URDF: what is not read is reported by name, and what only some readers know is read."""

import time

import numpy as np
import pinocchio as pin
import pytest
from robot_texts import INERTIA, LIMIT, arm, joint, link, refused, urdf
from trees import robot_from

from shockpc import Contact, Joints, Posture, RobotError, Rotor, Scene, shock_profile
from shockpc.landing.closure import closure_constraint, closure_gap
from shockpc.landing.joint_model import joint_model
from shockpc.landing.scenes.scene import Closure, LoopEnd
from shockpc.method.constraints import row_jacobian
from shockpc.method.dynamics import dynamics
from shockpc.robot.checkup import check_robot
from shockpc.robot.feet_and_sensors import sensors
from shockpc.robot.files import tags
from shockpc.robot.files.reading import parse_xml
from shockpc.robot.files.tags import URDF, unread
from shockpc.robot.shapes.geometry import outline


def elbow(more: str = "", kind: str = "revolute") -> str:
    return arm(elbow=joint("elbow", "base", "tip", kind, more=LIMIT + more))


def tip(more: str) -> str:
    return arm(tip=link("tip", more=more))


def at_top(*parts: str) -> str:
    return arm().replace("</robot>", f"{''.join(parts)}</robot>")


def transmission(
    joint_part: str = "", actuator: str = "", more: str = "", attributes: str = ""
) -> str:
    return (
        f'<transmission name="t">{more}<joint '
        f'name="elbow"{attributes}>{joint_part}</joint><actuator name="a">{actuator}</actuator>'
        "</transmission>"
    )


REPORTED = {
    elbow('<orgin xyz="0 0 1"/>'): ('joint "elbow"', "<orgin>", "nearest: <origin>"),
    elbow('<Origin xyz="0 0 1"/>'): ("<Origin>", "nearest: <origin>"),
    elbow('<origin xyz="0 0 1" rpz="0 0 1"/>'): (
        "rpz of joint/origin",
        'joint "elbow"',
        "nearest: rpy",
    ),
    elbow('<dynamics dampening="2"/>'): ("dampening of joint/dynamics", "nearest: damping"),
    elbow("<origin>0 0 1</origin>"): ("<origin>", '"0 0 1"'),
    elbow('<origin xyz="0 0 1"/><origin xyz="0 0 2"/>'): (
        'joint "elbow"',
        "<origin>",
        "xyz 0 0 1 and 0 0 2",
    ),
    elbow('<axis xyz="1 0 0"/>'): ('joint "elbow"', "<axis>", "xyz 0 1 0 and 1 0 0"),
    elbow('<limit lower="-2" upper="1" effort="1" velocity="1"/>'): ("<limit>", "lower -1 and -2"),
    elbow('<origin rpy="0 0 90"/>'): ("joint/origin rpy", '"0 0 90"', "radians"),
    elbow('<drake:rotor_inertia value="1e-4"/>'): ("joint/drake:rotor_inertia", "transmission"),
    elbow('<insert_block name="origin"/>'): ("joint/insert_block", "xacro"),
    arm(elbow=joint("elbow", "base", "tip", axis='0 1 0" rpy="0 0 1')): (
        "joint/axis rpy",
        '"0 0 1"',
    ),
    tip('<inertail><mass value="2"/></inertail>'): (
        'link "tip"',
        "<inertail>",
        "nearest: <inertial>",
    ),
    tip(f'<inertial><mass value="2"/>{INERTIA}</inertial>'): ("<inertial>", "mass value 1 and 2"),
    tip("<colision/>"): ("<colision>", "nearest: <collision>"),
    tip('<collision><geometry><box size="1 1 1"/><sphere radius="1"/></geometry></collision>'): (
        "<box> and <sphere>",
    ),
    tip(
        '<collision><origin xyz="0 0 1" yaw="1"/><geometry><box size="1 1 '
        '1"/></geometry></collision>'
    ): ("yaw of link/collision",),
    tip('<origin xyz="0 0 -0.5"/>'): ('link "tip"', "link/origin", "0 0 -0.5"),
    tip("<weight/>"): ("<weight>",),
    arm(tip=link("tip", inertia=INERTIA.replace("/>", ' izx="0.05"/>'))): (
        "link/inertial/inertia izx",
    ),
    arm(tip=link("tip").replace('name="tip"', 'name="tip" drake_ignore="true"')): (
        "link drake_ignore",
    ),
    at_top('<jont name="a" type="fixed"/>'): ("<jont>", "nearest: <joint>"),
    at_top('<coupling of="elbow"/>'): ("<coupling>",),
    at_top('<gazebo><joint name="close" type="revolute"/></gazebo>'): (
        'joint "close"',
        "gazebo/joint",
        "left open",
    ),
    at_top("<gazebo><include/></gazebo>"): ("gazebo/include", "mass"),
    at_top("<drake:linear_bushing_rpy/>"): ("drake:linear_bushing_rpy", "left open"),
    at_top('<loop_joint name="close"><link1 link="base"/></loop_joint>'): ('"close"', "left open"),
    at_top('<loop_joint name="close"><link1 link="base"/><link2 link="tap"/></loop_joint>'): (
        '"tap"',
        "left open",
    ),
    at_top(
        '<loop_joint name="c"><link1 link="base"/><link2 link="tip"/><axis xyz="0 0 '
        '0"/></loop_joint>'
    ): (
        '"c"',
        "axis without a direction",
        "left open",
    ),
    at_top(
        '<loop_joint name="c" type="screw"><link1 link="base"/><link2 link="tip"/></loop_joint>'
    ): ('"screw"', "left open"),
    at_top('<frame name="f" link="tip" xzy="0 0 1"/>'): ('frame "f"', "xzy of frame"),
    at_top(
        '<transmission name="t"><joint name="elbow"/><actuator '
        'name="m"><machanicalReduction>9</machanicalReduction></actuator>'
        "</transmission>"
    ): ('actuator "m"', "<machanicalReduction>", "nearest: <mechanicalReduction>"),
    at_top(
        '<transmission name="t"><joint name="elbow"/><actuator name="m"><drake:rotr_inertia '
        'value="1"/></actuator>'
        "</transmission>"
    ): ('actuator "m"', "<drake:rotr_inertia>", "nearest: <drake:rotor_inertia>"),
    at_top('<gazebo reference="tip"><inertial><mass>3</mass></inertial></gazebo>'): (
        'gazebo "tip"',
        "gazebo/inertial",
    ),
    at_top("<gazebo><static> True </static></gazebo>"): ("gazebo/static", "--base fixed"),
    at_top('<Joint name="a" type="fixed"><parent link="base"/></Joint>'): (
        'Joint "a"',
        "Joint/parent",
    ),
    at_top('<module><link name="battery"/></module>'): ("<module>",),
    at_top('<sensor name="imu" type="imu"><parent link="tip"/><orgin xyz="0 0 1"/></sensor>'): (
        '"imu"',
        "nearest: <origin>",
    ),
    at_top('<sensor name="imu" type="imu"><parent link="tip"/><origin xzy="0 0 1"/></sensor>'): (
        '"imu"',
        "xzy of sensor/origin",
    ),
    at_top(
        '<gazebo reference="tip"><sensor type="imu"><poze>0 0 1 0 0 0</poze></sensor></gazebo>'
    ): ("nearest: <pose>",),
    at_top('<mujoco><compiler settotalmas="5"/></mujoco>'): (
        "settotalmas of mujoco/compiler",
        "nearest: settotalmass",
    ),
    at_top('<mujoco><compiler settotalmass="5"/></mujoco>'): ("settotalmass", '"5"'),
    at_top('<include filename="leg.xacro"/>'): ("include",),
}


@pytest.mark.parametrize("text", REPORTED)
def test_what_is_not_read_is_one_warning_that_names_it(text: str):
    """A misspelt or unknown name, a tag or attribute that no reader applies, and copies that
    differ.
    """
    (warning,) = robot_from(text).warnings
    for part in REPORTED[text]:
        assert part in warning


HARMLESS = [
    elbow('<origin xyz="0 0 1"/><origin xyz="0 0 1.0" rpy="0 0 0"/>'),
    elbow(
        '<limit lower="-1" upper="1" effort="1" velocity="1"/><calibration rising="0"/><dynamics '
        'friction="0.2"/>'
    ),
    elbow(
        '<limit lower="-1" upper="1" effort="1" velocity="9"/><dynamics damping="1" '
        'friction="2"/><dynamics damping="1.0"/>'
    ),
    elbow(
        '<safety_controller k_velocity="1"/><vendor:thing link="tip" orgin="1"/><axis xyz="0 1 0" '
        'rpy="0 0 0"/>'
    ),
    tip(
        '<origin xyz="0 0 0"/><gravity>1</gravity><visual name="v"><geometry><box size="1 1 '
        '1"/></geometry><material/></visual>'
    ),
    arm(tip=link("tip", inertia=INERTIA.replace("/>", ' izx="0.0" iyx="0"/>'))),
    at_top(
        "<vendor:thing link='tip'/>",
        "<something_else/>",
        "<gazebo reference='tip'><orgin/></gazebo>",
        "<mujoco><option/></mujoco>",
    ),
    at_top('<vendor:thing quat_xyzw="0 0 0 1"/>', "<gazebo><static>0</static></gazebo>"),
    at_top(
        '<material name="tip"/>',
        '<mujoco><compiler inertiafromgeom="false" settotalmass="-1"/></mujoco>',
    ),
]


@pytest.mark.parametrize("text", HARMLESS)
def test_what_changes_no_shock_is_no_warning(text: str):
    """Identical copies, names of other programs, and what controllers, simulators and viewers read."""
    assert robot_from(text).warnings == ()


def test_many_of_a_kind_are_one_warning_with_their_number_in_milliseconds():
    """A hundred links with a misspelt origin each are one line; a hundred links take 10 ms."""
    links = "".join(
        link(f"l{k}", more='<colision/><visual><origin xyz="0 0 1"/></visual>') for k in range(100)
    )
    joints = "".join(
        joint(f"j{k}", f"l{k}", f"l{k + 1}", more=f'{LIMIT}<orgin xyz="0 0 1"/>') for k in range(99)
    )
    root = parse_xml(urdf(links, joints), "r.urdf")
    seconds = []
    for _ in range(5):
        start = time.process_time()
        collision, origin = unread(root, URDF)
        seconds.append(time.process_time() - start)
    assert "100 × <colision>" in collision.text
    assert "99 × <orgin>" in origin.text
    assert min(seconds) < 0.01


def test_of_many_kinds_the_first_are_compared_with_known_names(monkeypatch):
    """A comparison takes 0.1 ms, and a file may hold a million names."""
    compared: list[str] = []
    nearest = tags._nearest

    def counted(name: str, known: tuple[str, ...], cutoff: float) -> str:
        compared.append(name)
        return nearest(name, known, cutoff)

    monkeypatch.setattr(tags, "_nearest", counted)
    parts = "".join(f"<lmit{k}/>" for k in range(100))
    root = parse_xml(urdf(link("l"), f'<joint name="j" type="fixed">{parts}</joint>'), "r.urdf")
    *first, summary = unread(root, URDF)
    assert [record.text.partition("; ")[2] for record in first] == ["nearest: <limit>"] * 20
    assert summary.text == "80 other kinds of tags and attributes are not read either"
    assert compared == [f"lmit{k}" for k in range(20)]


TURNED = "0.1 -0.2 0.3 0.9"


@pytest.mark.parametrize("version", ["1.1", "1.2"])
def test_quaternions_are_rotations_of_every_origin(version: str):
    """quat_xyzw of any length, for the versions that have it: in joints, inertials, collisions and
    visuals, as in Pinocchio.
    """
    origin = f'<origin xyz="0.1 0.2 0.3" quat_xyzw="{TURNED}"/>'
    shape = f"{origin}<geometry><box size='1 2 3'/></geometry>"
    long = INERTIA.replace('izz="0.1"', 'izz="0.15"')
    inertial = f'<inertial>{origin}<mass value="2"/>{long}</inertial>'
    text = urdf(
        link("base"),
        f'<link name="tip">{inertial}<collision>{shape}</collision><visual>{shape}</visual></link>',
        joint("elbow", "base", "tip", more=LIMIT + origin),
    ).replace("<robot", f'<robot version="{version}"')
    robot, peer = robot_from(text), pin.buildModelFromXML(text)
    assert robot.warnings == ()
    for ours, theirs in (
        (robot.model.jointPlacements[2], peer.jointPlacements[1]),
        (robot.model.inertias[2], peer.inertias[1]),
    ):
        assert ours.isApprox(theirs, 1e-14)
    rotation = pin.Quaternion(
        np.array(list(map(float, TURNED.split())))
        / np.linalg.norm(list(map(float, TURNED.split())))
    ).matrix()
    for kind in ("collision", "visual"):
        points = outline(robot, kind).shapes[1][0].points
        corners = (points - [0.1, 0.2, 0.3]) @ rotation
        np.testing.assert_allclose(np.abs(corners), np.tile([0.5, 1.0, 1.5], (8, 1)), atol=1e-14)


@pytest.mark.parametrize(
    ("text", "version", "parts"),
    [
        (elbow('<origin quat_xyzw="0 0 0 1"/>'), "", ('"elbow"', "quat_xyzw", 'version="1.1"')),
        (elbow('<origin quat_xyzw="0 0 0 1"/>'), "1.0", ('"elbow"', "quat_xyzw", 'version="1.1"')),
        (tip('<visual><origin quat_xyzw="0 0 0 1"/></visual>'), "1.0", ('"tip"', "quat_xyzw")),
        (
            elbow('<origin quat_xyzw="0 0 0 1" rpy="0 0 0"/>'),
            "1.1",
            ('"elbow"', "rpy", "quat_xyzw"),
        ),
        (elbow('<origin quat_xyzw="0 0 0 0"/>'), "1.1", ('"elbow"', "quat_xyzw")),
        (arm(), "2.0", ("version", '"2.0"')),
        (
            at_top(transmission("<rotor_inertia value='1'/><gear_ratio value='1e160'/>")),
            "",
            ("reflected inertia", "cannot be computed"),
        ),
        (tip("").replace("<mass ", "<mas "), "", ("<mass>", "<mas>")),
        (at_top('<drake:joint name="ball" type="ball"/>'), "", ('"ball"', "drake:joint")),
    ],
)
def test_what_readers_understand_differently_is_refused(
    text: str, version: str, parts: tuple[str, ...]
):
    """Quaternions beside angles or before version 1.1, other versions, and joints that URDF does
    not have.
    """
    given = f'<robot version="{version}"' if version else "<robot"
    refused(RobotError, parts, robot_from, text.replace("<robot", given))


def test_armature_of_dynamics_is_the_reflected_inertia_at_the_joint():
    """It is noted, and the check-up no longer says that there is none; a spring may have a position
    of rest.
    """
    robot = robot_from(
        elbow('<dynamics armature="0.02" spring_stiffness="30" spring_reference="0.5"/>')
    )
    assert (robot.model.armature[6:].tolist(), robot.springs, robot.warnings) == (
        [0.02],
        {"elbow": 30.0},
        (),
    )
    assert robot.relaxed is not None
    assert robot.relaxed[7] == 0.5
    (note,) = [finding.text for finding in check_robot(robot)]
    assert "joint/dynamics armature" in note
    (warning,) = robot_from(elbow('<dynamics armature="0.02" rotor_inertia="0.03"/>')).warnings
    assert "0.02 and 0.03" in warning


@pytest.mark.parametrize(
    ("text", "ratio"),
    [
        (transmission("<mechanicalReduction>9</mechanicalReduction>"), 9.0),
        (
            transmission(
                "<mechanical_reduction>3</mechanical_reduction>",
                "<mechanicalReduction>-2</mechanicalReduction>",
            ),
            -6.0,
        ),
        (transmission(attributes=' mechanical_reduction="7"'), 7.0),
        (transmission(more="<mechanicalReduction>5</mechanicalReduction>"), 5.0),
        (
            f"<ros2_control>{transmission('<mechanical_reduction>9.0</mechanical_reduction>')}</ros2_control>",
            9.0,
        ),
        (
            f"<ros2_control>{transmission('', '<mechanical_reduction>4</mechanical_reduction>')}</ros2_control>",
            4.0,
        ),
    ],
)
def test_reductions_serve_a_rotor(text: str, ratio: float):
    """They stand in <joint>, <actuator> or beside both, as elements or attributes, also in
    <ros2_control>; two are multiplied.
    """
    robot = robot_from(at_top(text))
    assert (robot.gear_ratios, robot.warnings) == ({"elbow": ratio}, ())
    assert joint_model(robot, Joints(rotor={"elbow": Rotor(inertia=1e-4)})).armature[
        6
    ] == pytest.approx(1e-4 * ratio**2, rel=1e-14)


@pytest.mark.parametrize(
    "empty",
    ["<mechanicalReduction/>", "<mechanicalReduction> </mechanicalReduction>", "<gear_ratio/>"],
)
def test_an_empty_ratio_is_no_ratio_of_one(empty: str):
    """It is warned of, and refused beside the inertia of a rotor, which is reflected by its square."""
    robot = robot_from(at_top(transmission(empty)))
    assert robot.gear_ratios == {}
    assert 'the ratio of its transmission is "' in robot.warnings[0]
    inertia = "<motorInertia>1e-4</motorInertia>"
    refused(RobotError, ('"elbow"', "ratio"), robot_from, at_top(transmission(empty, inertia)))


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (elbow('<dynamics armature=""/>'), ("armature", '""')),
        (elbow('<dynamics stiffness=""/>'), ("stiffness", '""')),
        (
            at_top(transmission("<mechanicalReduction>9</mechanicalReduction>", "<motorInertia/>")),
            ("rotor inertia", '""'),
        ),
    ],
)
def test_an_empty_number_of_a_drive_is_not_zero(text: str, parts: tuple[str, ...]):
    """Empty numbers are refused as other texts are."""
    refused(RobotError, ('"elbow"', *parts), robot_from, text)


@pytest.mark.parametrize("key", ["damping", "spring_reference"])
@pytest.mark.parametrize("written", ["", "x"])
def test_damping_and_rest_that_cannot_be_read_are_warnings(key: str, written: str):
    (warning,) = robot_from(elbow(f'<dynamics stiffness="30" {key}="{written}"/>')).warnings
    assert f'its {key} is "{written}"' in warning


def test_a_mesh_without_a_name_is_missing():
    robot = robot_from(tip('<visual><geometry><mesh filename=""/></geometry></visual>'))
    assert "1 of 1 meshes" in " ".join(finding.where for finding in check_robot(robot))


def test_contradictions_of_transmissions_are_warnings():
    """Two ratios of one joint, a ratio that is no number, and a rotor inertia for several joints."""
    two = transmission("<mechanicalReduction>9</mechanicalReduction>") + transmission(
        "<mechanicalReduction>8</mechanicalReduction>"
    )
    robot = robot_from(at_top(two))
    assert robot.gear_ratios == {"elbow": 9.0}
    assert "9 and 8" in robot.warnings[0]
    (warning,) = robot_from(
        at_top(transmission("<mechanicalReduction>x</mechanicalReduction>"))
    ).warnings
    assert '"x"' in warning
    several = transmission(more='<joint name="wrist"/>', actuator="<motorInertia>1</motorInertia>")
    (warning,) = robot_from(at_top(several)).warnings
    assert '"t"' in warning


PLACES = (
    '<frame name="grip" link="tip" xyz="0.1 0 0" rpy="0 0 0.5"/>',
    '<fixed_frame name="mark"><parent link="tip"/><origin xyz="0.1 0 0" rpy="0 0 '
    '0.5"/></fixed_frame>',
    '<sensor name="gyro" type="imu"><parent link="tip"/><origin xyz="0.1 0 0" rpy="0 0 '
    '0.5"/></sensor>',
    '<gazebo reference="tip"><sensor name="ins" type="imu"><pose>0.1 0 0 0 0 '
    "0.5</pose></sensor></gazebo>",
    '<gazebo reference="tip"><sensor name="lidar" type="ray"><pose>0.1 0 0 0 0 '
    "0.5</pose></sensor></gazebo>",
)


def test_frames_and_sensors_are_named_places():
    """Those of Drake and Isaac Sim, sensors with a link, and the IMUs of Gazebo; IMUs are sensors
    whatever they are called.
    """
    robot = robot_from(at_top(*PLACES))
    assert robot.warnings == ()
    for name in ("grip", "mark", "gyro", "ins"):
        frame = robot.frame(name)
        assert (frame.body, frame.kind) == (1, "site")
        np.testing.assert_allclose(frame.offset, [0.1, 0.0, 0.0], atol=1e-16)
        np.testing.assert_allclose(frame.rotation, pin.rpy.rpyToMatrix(0.0, 0.0, 0.5), atol=1e-15)
    assert "lidar" not in robot.frames
    assert sensors(robot) == ("gyro", "ins")


def four_bar(loop: str, base: str = "") -> str:
    """A leg of two bars beside a crank and a rod, all about y, whose ends a loop may join."""
    return urdf(
        link("base"),
        link("thigh"),
        link("shank"),
        link("crank"),
        link("rod"),
        joint("hip", "base", "thigh"),
        joint("knee", "thigh", "shank", more=f'<origin xyz="0 0 -0.2"/>{LIMIT}'),
        joint("crank_j", "base", "crank", more=f'<origin xyz="-0.05 0 0"/>{LIMIT}'),
        joint("rod_j", "crank", "rod", more=f'<origin xyz="0 0 -0.05"/>{LIMIT}'),
        loop,
        base,
    )


ENDS = '<{a} link="rod" xyz="0 0 -0.15"/><{b} link="shank" xyz="-0.05 0 0"/>'
LINKS = ENDS.format(a="link1", b="link2")
FRAMES = (
    '<frame name="end_a" link="rod" xyz="0 0 -0.15"/><frame name="end_b" link="shank" xyz="-0.05 0 '
    '0"/>'
    '<frame name="sole" link="shank" xyz="0 0 -0.2"/>'
)


@pytest.mark.parametrize(
    ("loop", "rows"),
    [
        (f'<loop_joint name="c" type="revolute">{LINKS}<axis xyz="0 2 0"/></loop_joint>', 5),
        (f'<loop_joint name="c">{LINKS}<axis xyz="0 1 0"/></loop_joint>', 5),
        (f'<loop_joint name="c">{ENDS.format(a="link1", b="link1")}</loop_joint>', 3),
        (f'<loop_joint name="c" type="spherical">{LINKS}</loop_joint>', 3),
        (f'<loop_joint name="c" type="fixed">{LINKS}</loop_joint>', 6),
        (f'<loop_joint name="c" type="prismatic">{LINKS}<axis xyz="0 0 1"/></loop_joint>', 5),
        (
            "<drake:ball_constraint><drake:ball_constraint_body_A "
            'name="rod"/><drake:ball_constraint_p_AP value="0 0 -0.15"/>'
            '<drake:ball_constraint_body_B name="shank"/><drake:ball_constraint_p_BQ value="-0.05 '
            '0 0"/></drake:ball_constraint>',
            3,
        ),
    ],
)
def test_loop_joints_hold_what_their_type_holds(loop: str, rows: int):
    """The rows of a closure are the derivative of its gap, and as many as the joint takes freedoms."""
    robot = robot_from(four_bar(loop))
    assert robot.warnings == ()
    K = row_jacobian(
        dynamics(robot, robot.start[None]), [closure_constraint(one) for one in robot.loops]
    )[0]
    assert K.shape == (rows, robot.model.nv)
    step = 1e-5

    def gap(v: int, sign: int) -> np.ndarray:
        q = pin.integrate(robot.model, robot.start, sign * step * np.eye(robot.model.nv)[v])
        return np.concatenate(
            [closure_gap(dynamics(robot, q[None]), one)[0] for one in robot.loops]
        )

    numerical = np.column_stack(
        [(gap(v, 1) - gap(v, -1)) / (2.0 * step) for v in range(robot.model.nv)]
    )
    np.testing.assert_allclose(K, numerical, atol=1e-9)  # of central differences


@pytest.mark.parametrize("kind", ["", ' type="revolute"', ' type="spherical"'])
def test_a_loop_of_a_urdf_is_a_closure_of_the_scene(kind: str):
    """A planar four-bar jumps as with the closure of a scene between the same points, in the same
    closed posture.
    """
    loop = f'<loop_joint name="c"{kind}>{LINKS}<axis xyz="0 1 0"/></loop_joint>'
    posture = Posture(joints={"hip": -0.4, "knee": 0.8})
    profiles = []
    for text in (four_bar(loop, FRAMES), four_bar(FRAMES)):
        robot = robot_from(text)
        closures = (
            () if robot.loops else (Closure(a=LoopEnd(frame="end_a"), b=LoopEnd(frame="end_b")),)
        )
        foot = Contact(frame="sole", at="frame", kind="point")
        profiles.append(
            shock_profile(
                Scene(robot="r.urdf", contact=(foot,), posture=posture, closure=closures), robot
            )
        )
    one, other = profiles
    assert one.landing.loops
    np.testing.assert_allclose(one.q, other.q, atol=1e-9)
    np.testing.assert_allclose(one.delta_qd, other.delta_qd, atol=1e-9)


def test_links_without_mass_at_the_end_of_a_rod_are_a_ball_joint_with_their_loop():
    """Two joints without mass and a hinge that closes the loop, as in Drake's Cassie, are the ball
    joint at the rod's end.
    """
    ends = (
        '<link name="roll"/>',
        '<link name="pitch"/>',
        joint("r", "rod", "roll", axis="1 0 0", more=f'<origin xyz="0 0 -0.15"/>{LIMIT}'),
        joint("p", "roll", "pitch", axis="0 0 1"),
    )
    loop = (
        '<loop_joint name="c"><link1 link="pitch"/><link2 link="shank" xyz="-0.05 0 0"/><axis '
        'xyz="0 1 0"/></loop_joint>'
    )
    robot = robot_from(four_bar(loop, "".join(ends)))
    plain = robot_from(four_bar(f'<loop_joint name="c">{LINKS}</loop_joint>'))
    assert robot.joint_names == plain.joint_names
    ((ours,), (theirs,)) = robot.loops, plain.loops
    np.testing.assert_allclose(ours.points, theirs.points, atol=1e-15)
    assert len(ours.axes) == 3
    assert not ours.holds_orientation
    assert '"p", "r"' in robot.warnings[0]


def test_the_size_of_a_robot_without_shapes_is_that_of_its_frames():
    """The check-up gives the length that was measured, and on what."""
    far = INERTIA.replace("0.1", "100")
    robot = robot_from(
        arm(
            tip=link("tip", inertia=far),
            elbow=joint("elbow", "base", "tip", more=f'<origin xyz="0.4 0 0"/>{LIMIT}'),
        ),
        ".urdf",
    )
    (text,) = [finding.text for finding in check_robot(robot) if "gyration" in finding.text]
    assert "0.4 m" in text
    assert "without shapes" in text


def test_shapes_of_drake_are_read():
    """A capsule and an ellipsoid with Drake's prefix reach as far as they say, also after an
    element that is no shape.
    """
    shapes = (
        '<drake:declare_convex/><drake:capsule radius="0.1" length="0.4"/>',
        '<drake:ellipsoid a="0.1" b="0.2" c="0.3"/>',
    )
    text = arm(
        tip=link(
            "tip",
            more="".join(
                f"<collision><geometry>{shape}</geometry></collision>" for shape in shapes
            ),
        )
    )
    robot = robot_from(text)
    found = outline(robot, "collision")
    assert (robot.warnings, found.warnings) == ((), ())
    capsule, ellipsoid = found.shapes[1]
    np.testing.assert_allclose(capsule.reach(np.eye(3)), [0.1, 0.1, 0.3], atol=1e-15)
    np.testing.assert_allclose(ellipsoid.reach(np.eye(3)), [0.1, 0.2, 0.3], atol=1e-15)
