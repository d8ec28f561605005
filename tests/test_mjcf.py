"""MJCF: inertia matrix, placements and limits equal MuJoCo's; what cannot be computed is refused."""

import re
import resource
import sys
import warnings
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from commands import says
from robot_texts import BODY, HINGE, body, floating, loaded, mjcf, refusal, refused

from shockpc import (
    Contact,
    Joints,
    Posture,
    Robot,
    Scene,
    Strike,
    configuration_from_mujoco,
    load_robot,
    shock_profile,
)
from shockpc.core.spatial import in_body_axes
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import solved
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.quantities.quantity import quantity_values
from shockpc.quantities.selection import select
from shockpc.robot.mjcf.compiled import compiled
from shockpc.text.errors import RobotError, SceneError, SolveError, UnknownName

BOX = '<geom type="box" size=".1 .2 .3"/>'
MESH = '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
TURNED = 'pos="0.3 0.1 -.2" euler="10 20 30"'

ENDS = 'fromto="0.1 0.2 -0.3 0.4 -0.1 0.2"'

READ = {
    "joint free": mjcf(
        floating(body("b")).replace('<freejoint name="root"/>', '<joint type="free"/>')
    ),
    "inertial over a mesh": mjcf(floating(body("b", BODY + '<geom type="mesh" mesh="m"/>')), MESH),
    "weightless mesh": mjcf(
        floating(body("b", BOX + '<geom type="mesh" mesh="m" density="0"/>')), MESH
    ),
    "nameless bodies": mjcf(floating(body("b").replace('name="b"', "")).replace('name="base"', "")),
    "actuator gear": mjcf(
        floating(body("b", joints=HINGE)), after='<actuator><motor joint="j" gear="10"/></actuator>'
    ),
    "loop switched off": mjcf(
        floating(body("b"), body("c", joints="")),
        after='<equality><weld body1="b" body2="c" active="false"/></equality>',
    ),
    "sites between two ends": mjcf(
        floating(
            f'<site name="s0" type="capsule" size=".01" {ENDS}/>'
            + f'<frame {TURNED}><site name="s1" type="cylinder" size=".01" {ENDS}/></frame>'
            + body("b", BODY + '<site name="s2" type="box" size=".01" fromto="0 0 -.1 0 0 .3"/>')
        )
    ),
    "fixed base in a frame of the world": mjcf(
        f"<frame {TURNED}>{floating(body('b'), at=TURNED)}</frame>".replace(
            '<freejoint name="root"/>', ""
        )
    ),
    "mass of a mesh": mjcf(floating(body("b", '<geom type="mesh" mesh="m"/>')), MESH),
    "armature of a free joint": mjcf(
        floating(body("b")).replace('<freejoint name="root"/>', '<joint name="root" type="free"/>'),
        '<default><joint armature="0.2"/></default>',
    ),
    "armature of an actuator": mjcf(
        floating(body("b")),
        after='<actuator><motor joint="j" armature="0.1" gear="-3"/></actuator>',
    ),
    "height field, and a static body with a mesh": mjcf(
        '<geom type="hfield" hfield="h"/><body name="table"><geom type="mesh" mesh="lost"/></body>'
        + floating(body("b")),
        '<asset><hfield name="h" file="h.png" size="1 1 1 1"/><mesh name="lost" '
        'file="lost.stl"/></asset>',
    ),
    "static base whose inertial is incomplete": mjcf(
        f'<body name="base"><inertial pos="0 0 0" mass="1"/>{body("b")}</body>'
    ),
    "limits in degrees and in metres": mjcf(
        floating(
            body("b", joints='<joint name="j" axis="0 1 0" range="-30 90"/>')
            + body("c", joints='<joint name="k" type="slide" range="-.1 .2"/>')
        )
    ),
    "three joints of one body": mjcf(
        floating(
            body(
                "b",
                joints='<joint type="slide" axis="1 2 0" ref=".3"/>'
                '<joint name="mid" axis="0 1 1" pos="0 0 .2" ref="20" armature=".3" range="-10 '
                '20"/>'
                '<joint type="ball" pos=".1 .2 .3"/>',
            )
        )
    ),
    "geoms fitted to a mesh": mjcf(
        floating(body("b", '<geom type="capsule" mesh="m" density="200"/>')), MESH
    ),
    "nothing but sensors, pairs, skins and lights besides": mjcf(
        floating(
            body(
                "b",
                BODY
                + '<geom name="g" type="mesh" mesh="m" material="red"/><light/><camera name="c"/>',
            )
        ),
        MESH.replace(
            "</asset>",
            '<texture name="t" type="2d" file="t.png"/><material name="red" texture="t"/></asset>',
        ),
        '<contact><exclude body1="base" body2="b"/></contact><sensor><framepos objtype="geom" '
        'objname="g"/></sensor>',
    ),
    "spatial tendon over a sphere": mjcf(
        floating(
            '<site name="s"/>' + body("b", BODY + '<geom name="ball" size=".05"/><site name="t"/>')
        ),
        after=(
            '<tendon><spatial><site site="s"/><geom geom="ball"/><site '
            'site="t"/></spatial></tendon>'
        ),
    ),
    "table first": mjcf(
        '<body name="table" pos="1 0 0"><geom size=".1"/></body>' + floating(body("b"))
    ),
}


def from_text(folder: Path, text: str) -> Robot:
    """The robot of an MJCF with this text."""
    return loaded(folder, text, "dog.xml")


def without_assets(text: str) -> mujoco.MjModel:
    """MuJoCo's model of a text whose asset files do not exist."""
    spec = mujoco.MjSpec.from_string(text)
    for geom in [
        geom
        for geom in spec.geoms
        if geom.meshname == "lost" or geom.type == mujoco.mjtGeom.mjGEOM_HFIELD
    ]:
        spec.delete(geom)
    for item in [*(mesh for mesh in spec.meshes if mesh.file), *spec.hfields, *spec.textures]:
        spec.delete(item)
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return spec.compile()


def assert_equal(robot: Robot, theirs: mujoco.MjModel, qpos: np.ndarray) -> None:
    """Inertia matrix with armature, and the place of every body and site, in one configuration."""
    state = mujoco.MjData(theirs)
    state.qpos[:] = qpos
    mujoco.mj_forward(theirs, state)
    inertia = np.zeros((theirs.nv, theirs.nv))
    mujoco.mj_fullM(theirs, state, inertia)

    file = np.zeros(compiled(robot.source).model.nq)
    file[: theirs.nq] = state.qpos  # what is left out of the robot comes last
    q, to_world = configuration_from_mujoco(robot, file), np.eye(theirs.nv)
    if robot.free_base:
        # MuJoCo counts the base's linear velocity in the world's axes, Pinocchio in the base's.
        to_world[:3, :3] = state.xmat[theirs.jnt_bodyid[0]].reshape(3, 3).T
    data = robot.model.createData()
    ours = pin.crba(robot.model, data, q)
    ours = np.triu(ours) + np.triu(ours, 1).T
    assert np.abs(to_world.T @ ours @ to_world - inertia).max() < 1e-12 * np.abs(inertia).max()

    pin.framesForwardKinematics(robot.model, data, q)
    placed = [
        (theirs.body(k).name, pin.FrameType.BODY, state.xpos[k], state.xmat[k])
        for k in range(1, theirs.nbody)
    ]
    placed += [
        (theirs.site(k).name, pin.FrameType.OP_FRAME, state.site_xpos[k], state.site_xmat[k])
        for k in range(theirs.nsite)
    ]
    for name, kind, position, rotation in placed:
        if name:
            place = data.oMf[robot.model.getFrameId(name, kind)]
            np.testing.assert_allclose(place.translation, position, atol=1e-13)
            np.testing.assert_allclose(place.rotation.ravel(), rotation, atol=1e-13)


def test_a_qpos_that_the_file_has_not_is_refused(tmp_path: Path):
    robot = from_text(tmp_path, mjcf(floating(body("b"))))
    for qpos, part in (
        (np.zeros(7), "8 finite numbers"),
        (np.full(8, np.nan), "8 finite numbers"),
        (np.zeros(8), "length 0"),
    ):
        refused(SceneError, [part], configuration_from_mujoco, robot, qpos)
    refused(
        RobotError,
        ['quaternion="wxyz"'],
        configuration_from_mujoco,
        load_robot("anymal_b"),
        np.zeros(19),
    )


def drawn_at_random(theirs: mujoco.MjModel, seed: int) -> np.ndarray:
    """A configuration in MuJoCo's order."""
    qpos = np.array(theirs.qpos0)
    mujoco.mj_integratePos(theirs, qpos, np.random.default_rng(seed).normal(size=theirs.nv), 0.7)
    return qpos


@pytest.mark.parametrize("name", READ)
def test_inertia_and_placements_equal_mujocos(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    """In the posture that the file draws, and in another one; nothing is printed and no file is
    written.
    """
    robot = from_text(tmp_path, READ[name])
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == ["dog.xml"]
    theirs = without_assets(READ[name])
    for qpos in (theirs.qpos0, drawn_at_random(theirs, 1)):
        assert_equal(robot, theirs, qpos)
    assert robot.mass == pytest.approx(sum(body.mass for body in robot.bodies))


def random_mjcf(seed: int) -> str:
    """A tree of 2 to 9 bodies whose joints, places, inertias and geoms are drawn at random."""
    rng = np.random.default_rng(seed)

    def numbers(count: int) -> str:
        return " ".join(f"{value:.17g}" for value in rng.normal(size=count))

    children: dict[int, list[int]] = {0: []}
    for number in range(1, rng.integers(2, 10)):
        children[int(rng.integers(0, number))].append(number)
        children[number] = []

    def written(number: int) -> str:
        joints = "<freejoint/>" if number == 0 and rng.random() < 0.6 else ""
        count = 0 if joints else rng.choice((0, 1, 1, 1, 2, 3)) if number else 1
        for left in reversed(range(count)):
            # no joint of a body comes after a ball
            kind = rng.choice(("hinge", "hinge", "slide", "hinge" if left else "ball"))
            more = "" if kind == "ball" else f'axis="{numbers(3)}" ref="{rng.normal():.17g}"'
            joints += (
                f'<joint type="{kind}" pos="{numbers(3)}" armature="{rng.random():.17g}" {more}/>'
            )
        mass = (
            f'<geom type="box" size=".1 .2 .3" pos="{numbers(3)}" euler="{numbers(3)}"/><geom '
            f'size=".2" density="50"/>'
        )
        if rng.random() < 0.5:
            xx, yy, zz = rng.uniform(0.5, 0.9, 3)
            offdiagonal = " ".join(f"{value:.17g}" for value in rng.uniform(-0.05, 0.05, 3))
            mass = (
                f'<inertial pos="{numbers(3)}" mass="{rng.random() + 0.1}" fullinertia="{xx} {yy} '
                f'{zz} {offdiagonal}"/>'
            )
        inside = "".join(written(child) for child in children[number])
        frame = (
            f'<frame pos="{numbers(3)}" euler="{numbers(3)}"><site name="s{number}" '
            f'pos="{numbers(3)}"/>{inside}</frame>'
        )
        return (
            f'<body name="b{number}" pos="{numbers(3)}" '
            f'quat="{numbers(4)}">{joints}{mass}{frame}</body>'
        )

    sequence = "".join(rng.choice(list("xyzXYZ"), 3))
    return mjcf(written(0), f'<compiler angle="radian" eulerseq="{sequence}"/>')


@pytest.mark.parametrize("seed", range(40))
def test_random_trees_equal_mujocos(seed: int, tmp_path: Path):
    robot = from_text(tmp_path, random_mjcf(seed))
    theirs = mujoco.MjModel.from_xml_string(random_mjcf(seed))
    assert_equal(robot, theirs, drawn_at_random(theirs, seed))
    assert len(robot.bodies) == np.count_nonzero(theirs.body_jntnum)


def test_limits_are_in_radians_and_metres(tmp_path: Path):
    robot = from_text(tmp_path, READ["limits in degrees and in metres"])
    assert robot.joint("j").limits == pytest.approx((-np.pi / 6, np.pi / 2))
    assert robot.joint("k").limits == (-0.1, 0.2)
    robot = from_text(tmp_path, READ["three joints of one body"])
    assert [part.kind for part in robot.joints[1].parts] == ["prismatic", "revolute", "ball"]
    assert robot.joints[1].parts[1].limits == pytest.approx((-np.pi / 18, np.pi / 9))
    assert robot.joint_names == ("b_joint_1", "mid", "b_joint_3")


PLANAR = (
    '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/><joint '
    'name="pitch" axis="0 1 0"/>'
)


def test_joints_of_one_body_are_set_driven_and_locked_by_their_names(tmp_path: Path):
    """A planar trunk: the jump is that of MuJoCo's matrices with an armature added to z and the
    column of pitch left out.
    """
    text = mjcf(body("trunk", BODY + body("b", joints='<joint name="knee" axis="0 1 0"/>'), PLANAR))
    robot = from_text(tmp_path, text)
    values = {"x": 0.3, "z": 0.2, "pitch": 0.4, "knee": -0.7}
    scene = Scene(
        robot="dog",
        posture=Posture(joints=values),
        joints=Joints(armature={"z": 0.5}, locked=("pitch",)),
        contact=Contact(frame="b", offset=(0.1, 0.0, -0.3)),
        strike=Strike(velocity=(0.2, 0.0, -1.0)),
    )
    theirs = mujoco.MjModel.from_xml_string(text)
    state, M, J, free = mujoco.MjData(theirs), np.zeros((4, 4)), np.zeros((3, 4)), [0, 1, 3]
    state.qpos[:] = list(values.values())
    mujoco.mj_forward(theirs, state)
    mujoco.mj_fullM(theirs, state, M)
    M[1, 1] += 0.5
    number = theirs.body("b").id
    mujoco.mj_jac(
        theirs,
        state,
        J,
        None,
        state.xpos[number] + state.xmat[number].reshape(3, 3) @ [0.1, 0.0, -0.3],
        number,
    )
    M, J = M[np.ix_(free, free)], J[np.ix_([0, 2], free)]
    expected = np.linalg.solve(
        M, J.T @ np.linalg.solve(J @ np.linalg.solve(M, J.T), np.array([-0.2, 1.0]))
    )
    np.testing.assert_allclose(
        shock_profile(scene, robot).delta_qd, np.insert(expected, 2, 0.0), atol=1e-13
    )


SHARED = mjcf(
    floating(
        body(
            "b",
            BODY + body("c", joints='<joint name="knee" axis="0 1 0"/>'),
            '<joint name="rail" type="slide" axis="0.1 0.2 1"/><joint name="yaw" axis="0 0 1" '
            'pos="0 0.1 0.05" armature="0.02"/>'
            '<joint name="pitch" axis="0.2 1 0" pos="0.05 -0.1 0.02"/><joint name="roll" axis="1 0 '
            '0.1" pos="-0.1 0.03 0.2"/>',
        )
    )
)


@pytest.mark.parametrize("locked", [(), ("pitch",), ("rail", "roll"), ("*",)])
def test_moment_of_each_joint_of_a_body_is_about_its_own_anchor(
    tmp_path: Path, locked: tuple[str, ...]
):
    """MuJoCo's anchors and axes: moment · axis is the joint's row of M Δq̇ − Jᵀ λ without its
    armature, in balls and in doubles.

    Moments of joints that share a body differ by the lever between their anchors.
    """
    robot = from_text(tmp_path, SHARED)
    theirs, values = (
        mujoco.MjModel.from_xml_string(SHARED),
        {"rail": 0.2, "yaw": 0.7, "pitch": -0.5, "roll": 0.4, "knee": -0.9},
    )
    state, M, J = mujoco.MjData(theirs), np.zeros((theirs.nv, theirs.nv)), np.zeros((3, theirs.nv))
    state.qpos[:] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *values.values()]
    scene = Scene(
        robot="dog",
        posture=Posture(joints=values),
        joints=Joints(locked=locked),
        contact=Contact(frame="c", offset=(0.1, 0.0, -0.3)),
        strike=Strike(velocity=(0.2, 0.1, -1.0)),
    )
    mujoco.mj_forward(theirs, state)
    mujoco.mj_fullM(theirs, state, M)
    foot = theirs.body("c").id
    mujoco.mj_jac(
        theirs,
        state,
        J,
        None,
        state.xpos[foot] + state.xmat[foot].reshape(3, 3) @ [0.1, 0.0, -0.3],
        foot,
    )
    profile = shock_profile(scene, robot)
    (contact,) = profile.contacts
    # The base stands unturned at the origin, where the velocities of both libraries mean the same.
    carried = M @ profile.delta_qd - J.T @ contact.impulse - theirs.dof_armature * profile.delta_qd
    names = list(values)
    equation, solution, jumps = solved(profile.landing, profile.landing.state, True)
    double = DoubleImpact(
        profile.landing, equation, solution, in_body_axes(jumps, profile.landing.state.rotation)
    )
    places = profile.places("joint")
    moments, forces = (
        quantity_values(select(f"joint.{key}").quantity, double, places)[0, 0]
        for key in ("moment", "force")
    )
    assert [place.name for place in places] == names
    size = np.abs(carried).max() + np.abs(forces).max()
    proven = [[load.moment for load in profile.loads], [load.force for load in profile.loads]]
    for found, force in (proven, (moments, forces)):
        for k, name in enumerate(names):
            number = theirs.joint(name).id
            pushed = force[k] if name == "rail" else found[k]
            assert pushed @ state.xaxis[number] == pytest.approx(
                carried[6 + k], abs=1e-10 * size
            ), name
            # MuJoCo gives the anchor of a slide before it slides.
            slid = values[name] * state.xaxis[number] if name == "rail" else np.zeros(3)
            lever = state.xanchor[number] + slid - state.xanchor[theirs.joint("roll").id]
            if name != "knee":
                np.testing.assert_allclose(
                    found[k], found[3] - np.cross(lever, force[k]), atol=1e-10 * size, err_msg=name
                )
    assert size > 0.1


def test_armature_of_a_free_joint_is_mass_of_the_base(tmp_path: Path):
    """MuJoCo adds it to the inertia matrix whatever the joints do, so it is no drive's."""
    robot = from_text(tmp_path, READ["armature of a free joint"])
    assert not robot.model.armature[:6].any()
    assert robot.bodies[0].mass == pytest.approx(1.2)
    (warning,) = robot.warnings
    assert 'joint "root" is free and has armature 0.2' in warning
    assert "<freejoint/>" in warning
    other = from_text(
        tmp_path,
        READ["armature of a free joint"].replace(
            '<joint name="root" type="free"/>', "<freejoint/>"
        ),
    )
    assert (other.bodies[0].mass, other.warnings) == (1.0, ())


def test_frames_are_links_sites_joints_and_collision_geoms(tmp_path: Path):
    """Bodies that cannot move have frames too, fixed to the world; geoms that collide are found by
    their names: many are feet.
    """
    foot = (
        '<geom name="foot" size=".02" pos="0 0 -.3"/><geom name="skin" size=".1" contype="0" '
        'conaffinity="0"/>'
    )
    robot = from_text(
        tmp_path,
        mjcf(
            '<body name="table" pos="1 0 0"/>'
            + floating(body("b", BODY + foot + '<site name="imu"/>'))
        ),
    )
    kinds = {frame.name: (frame.kind, frame.body) for frame in robot.frames.values()}
    assert kinds == {
        "base": ("link", 0),
        "b": ("link", 1),
        "table": ("link", -1),
        "root": ("joint", 0),
        "j": ("joint", 1),
        "imu": ("site", 1),
        "foot": ("geom", 1),
    }
    np.testing.assert_array_equal(robot.frame("foot").offset, [0, 0, -0.3])
    np.testing.assert_array_equal(robot.frame("table").offset, [1, 0, 0])


def test_keyframes(tmp_path: Path):
    """A keyframe becomes a posture; one of the wrong size is left out with a line that says so."""
    keys = (
        '<keyframe><key name="home" qpos="1 2 3 2 0 0 0 .3"/><key name="old" qpos="1 2 3"/><key '
        'name="bad" qpos="{}"/></keyframe>'
    )
    robot = from_text(tmp_path, mjcf(floating(body("b")), after=keys.format("nan 2 3 1 0 0 0 .3")))
    np.testing.assert_array_equal(robot.postures["home"], [1, 2, 3, 0, 0, 0, 1, 0.3])
    assert list(robot.postures) == ["home"]
    warnings = [warning for warning in robot.warnings if "keyframe" in warning]
    assert [
        says(warning, f'"{name}"', "8 finite numbers")
        for name, warning in zip(("old", "bad"), warnings, strict=True)
    ] == [True] * 2


TWO = mjcf(
    body("box", '<geom size=".05" mass="9"/>', "<freejoint/>")
    + floating(body("b"))
    + body("door", BODY, '<joint name="hinge" axis="0 0 1"/>', 'pos="1 2 0"'),
    after="<keyframe><key name='home' qpos='9 9 9 1 0 0 0 1 2 3 1 0 0 0 .3 .4'/></keyframe>",
)


def test_of_several_robots_that_with_the_most_joints_is_computed(tmp_path: Path):
    """The others are named; configurations and frames are those of the robot that is left."""
    robot = from_text(tmp_path, TWO)
    (warning,) = robot.warnings
    assert says(
        warning, "3 robots", '"base", with the most joints', '"box" (9 kg), "door" (1 kg) left out'
    )
    assert [found.name for found in robot.bodies] == ["base", "b"]
    np.testing.assert_array_equal(robot.postures["home"], [1, 2, 3, 0, 0, 0, 1, 0.3])
    assert "door" not in robot.frames


@pytest.mark.parametrize("contact", ["box", "b*"])
def test_of_several_robots_that_with_the_contact_is_computed(tmp_path: Path, contact: str):
    """The first body that fits the contact decides; a contact of none of them is an unknown name."""
    from_text(tmp_path, TWO)
    scene = Scene(robot=str(tmp_path / "dog.xml"), contact="box")
    assert robot_of(Scene(robot=scene.robot), [contact]).links == ("box",)
    profile = shock_profile(scene)
    assert says(profile.robot.warnings[0], "3 robots", '"box"')
    np.testing.assert_allclose(profile.delta_v, [[0.0, 0.0, 1.0]], atol=1e-15)
    with pytest.raises(UnknownName):
        shock_profile(Scene(robot=scene.robot, contact="window"))


def test_what_is_tied_to_the_robot_belongs_to_it(tmp_path: Path):
    """Two arms that hold one another are one robot; a floating base that is tied to another moving
    tree is refused.
    """
    arms = body("left", BODY + '<geom size=".1"/>', '<joint name="l"/>') + body(
        "right", joints='<joint name="r"/>', at='pos="1 0 0"'
    )
    tie = '<equality><connect body1="{}" body2="{}" anchor="0 0 .1"/></equality>'
    text = mjcf(arms + body("door", BODY, '<joint name="d"/>'), after=tie.format("left", "right"))
    robot = from_text(tmp_path, text)
    assert [found.name for found in robot.bodies] == ["left", "right"]
    assert robot.parents == (-1, -1)
    assert robot.loops[0].bodies == (0, 1)
    assert '"door" (1 kg) left out' in robot.warnings[0]
    whole = mujoco.MjModel.from_xml_string(mjcf(arms))
    assert_equal(robot, whole, drawn_at_random(whole, 3))
    with pytest.raises(
        RobotError, match='equalities couple "base", "door", and with a floating base'
    ):
        from_text(tmp_path, TWO.replace("<keyframe>", tie.format("door", "b") + "<keyframe>"))


TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def test_includes_and_meshes_of_the_opened_folders(tmp_path: Path):
    """A folder called mjcf lies in the robot's: parts and meshes beside it are read, counted from
    the main file's folder.
    """
    for folder in ("mjcf", "parts", "meshes"):
        (tmp_path / folder).mkdir()
    limb = body("b", '<geom type="mesh" mesh="t"/>') + body("c", joints="")
    (tmp_path / "parts" / "limb.xml").write_text(f"<mujocoinclude>{limb}</mujocoinclude>")
    (tmp_path / "parts" / "all.xml").write_text(
        '<mujoco><compiler angle="radian" meshdir="../meshes"/><asset><mesh file="t.obj" scale="1 '
        '1 2"/></asset></mujoco>'
    )
    (tmp_path / "meshes" / "t.obj").write_text(TETRAHEDRON)
    text = mjcf(
        floating('<include file="../parts/limb.xml"/>'), '<include file="../parts/all.xml"/>'
    )
    robot = from_text(tmp_path / "mjcf", text)
    assert robot.joint_names == ("j",)
    assert robot.bodies[1].mass == pytest.approx(1000 / 3)
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "mjcf" / "dog.xml"))
    assert_equal(robot, theirs, theirs.qpos0)


def test_an_included_file_may_count_from_its_own_folder(tmp_path: Path):
    """As MuJoCo does where nothing is at the place that counts from the main file's folder."""
    parts = tmp_path / "parts" / "more"
    parts.mkdir(parents=True)
    (parts / "hand.xml").write_text(f"<mujocoinclude>{body('hand', joints='')}</mujocoinclude>")
    (tmp_path / "parts" / "limb.xml").write_text(
        '<mujocoinclude><include file="more/hand.xml"/></mujocoinclude>'
    )
    robot = from_text(tmp_path, mjcf(floating('<include file="parts/limb.xml"/>')))
    assert "hand" in robot.links
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "dog.xml"))
    assert_equal(robot, theirs, theirs.qpos0)
    (parts / "hand.xml").unlink()
    refused(
        RobotError,
        ['"more/hand.xml" is missing'],
        from_text,
        tmp_path,
        mjcf(floating('<include file="parts/limb.xml"/>')),
    )


@pytest.mark.parametrize("meshdir", ["", ' meshdir="meshes"'])
@pytest.mark.parametrize("place", ["", "meshes", "parts", "parts/more"])
def test_a_mesh_may_lie_beside_the_included_file_that_names_it(
    tmp_path: Path, place: str, meshdir: str
):
    """MuJoCo looks in the folder of meshes counted from the main file, then beside the file that
    has the mesh; so does this.
    """
    for folder in ("meshes", "parts/more"):
        (tmp_path / folder).mkdir(parents=True)
    asset = (
        f'<mujoco><compiler angle="radian"{meshdir}/><asset><mesh file="t.obj" scale="1 1 '
        f'2"/></asset></mujoco>'
    )
    (tmp_path / "parts" / "more" / "assets.xml").write_text(asset)
    (tmp_path / "parts" / "all.xml").write_text(
        '<mujoco><include file="more/assets.xml"/></mujoco>'
    )
    (tmp_path / place / "t.obj").write_text(TETRAHEDRON)
    text = mjcf(
        floating(body("b", '<geom type="mesh" mesh="t"/>')), '<include file="parts/all.xml"/>'
    )
    if place in ("meshes" if meshdir else "", "parts/more"):
        robot, theirs = (
            from_text(tmp_path, text),
            mujoco.MjModel.from_xml_path(str(tmp_path / "dog.xml")),
        )
        assert_equal(robot, theirs, theirs.qpos0)
    else:
        refused(RobotError, ['t.obj" is missing'], from_text, tmp_path, text)
        with pytest.raises(ValueError, match=r"t\.obj"):
            mujoco.MjModel.from_xml_path(str(tmp_path / "dog.xml"))


OPTIONS = (
    '<option apirate="100" timestep="1" mpr_iterations="50"><flag sensornoise="enable" '
    'contact="no"/></option>'
    '<visual><headlight active="1" odd="2"/></visual><statistic meansize="1" odd="3"/>'
)


def test_options_that_cannot_change_an_impact_may_be_those_of_another_version(tmp_path: Path):
    """MuJoCo itself refuses them; the robot is that of the file without them."""
    text = mjcf(floating(body("b")), '<compiler angle="radian"/>')
    with pytest.raises(ValueError, match="unrecognized attribute"):
        mujoco.MjModel.from_xml_string(text.replace("<worldbody>", f"{OPTIONS}<worldbody>"))
    robot = from_text(tmp_path, text.replace("<worldbody>", f"{OPTIONS}<worldbody>"))
    theirs = mujoco.MjModel.from_xml_string(text)
    assert_equal(robot, theirs, theirs.qpos0)
    assert robot.warnings == ()


@pytest.mark.parametrize(
    "size",
    [
        'njmax="1000000" nconmax="1000000"',
        'memory="64G"',
        'nkey="100000000"',
        'nuser_body="2000000000"',
    ],
)
def test_memory_of_a_simulation_is_not_reserved(size: str, tmp_path: Path):
    """It would be more than the compiler may take."""
    size = f"<size {size}/>"
    assert loaded(tmp_path, mjcf(floating(body("leg")), size), "m.xml").model.nv == 7


def test_attached_models(tmp_path: Path):
    """A model that another one attaches brings its includes and meshes."""
    (tmp_path / "legs").mkdir()
    (tmp_path / "legs" / "t.obj").write_text(TETRAHEDRON)
    (tmp_path / "legs" / "assets.xml").write_text(
        '<mujoco><asset><mesh name="m" file="t.obj"/></asset></mujoco>'
    )
    (tmp_path / "legs" / "leg.xml").write_text(
        mjcf(
            body("leg", '<geom type="mesh" mesh="m"/>', '<joint name="k"/>'),
            '<include file="assets.xml"/>',
        )
    )
    attached = '<frame pos="1 0 0"><attach model="leg" body="leg" prefix="left_"/></frame>'
    robot = from_text(
        tmp_path, mjcf(floating(attached), '<asset><model name="leg" file="legs/leg.xml"/></asset>')
    )
    assert robot.joint_names == ("left_k",)
    assert robot.bodies[1].mass == pytest.approx(1000 / 6)


def test_meshes_that_give_no_mass_are_not_read(tmp_path: Path):
    """Their geoms have no mass; a mesh for mass and for show is read for its mass."""
    asset = (
        '<asset><mesh name="m" file="t.obj"/><mesh name="n" file="lost.obj"/><mesh name="o" '
        'file="bad.stl"/></asset>'
    )
    (tmp_path / "t.obj").write_text(TETRAHEDRON)
    (tmp_path / "bad.stl").write_text("junk")
    geoms = "".join(f'<geom type="mesh" mesh="{name}"/>' for name in "mno")
    robot = from_text(
        tmp_path,
        mjcf(
            floating(
                body("b", BODY + geoms) + body("c", '<geom type="mesh" mesh="m"/>', "<joint/>")
            ),
            asset,
        ),
    )
    found = compiled(robot.source)
    assert (found.model.nmesh, [mesh.file for mesh in found.meshes.values()]) == (
        1,
        ["t.obj", "lost.obj", "bad.stl"],
    )
    assert [body.mass for body in robot.bodies] == pytest.approx([1.0, 1.0, 1000 / 6])


def test_without_mujoco(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """It is an optional dependency: the message says how to install it."""
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(RobotError, match=r"dog\.xml.*pip install mujoco"):
        from_text(tmp_path, READ["actuator gear"])


HELD = '<inertial pos="0 0 0" mass="{}" diaginertia="{}"/>'
SPATIAL = '<tendon><spatial name="t"><site site="s"/><site site="t"/></spatial></tendon>'
FIXED = '<tendon><fixed name="t"{}><joint joint="j" coef="1"/></fixed></tendon>'


def one(inside: str = BODY, joints: str = HINGE, before: str = "", **given: str) -> str:
    """A free base that carries a body."""
    return mjcf(floating(body("b", inside, joints, **given)), before)


def among(section: str) -> str:
    """A free base that carries two bodies, with a section after them."""
    return mjcf(floating(body("b"), body("c", joints='<joint name="k"/>')), after=section)


def mesh(file: str) -> str:
    """A body whose mass is that of a mesh."""
    return one(
        '<geom type="mesh" mesh="m"/>', before=f'<asset><mesh name="m" file="{file}"/></asset>'
    )


REFUSED = {
    "<mujoco/>": "no body in it has a joint",
    mjcf(body("b", joints="")): "no body in it has a joint",
    one(
        before="<compiler fancy='1'/>"
    ): "MuJoCo cannot compile it: .*unrecognized attribute: 'fancy'",
    one(joints='<joint axis="0 0 0"/>'): "MuJoCo cannot compile it: .*axis too small",
    one(HELD.format(-1, "1 1 1")): "MuJoCo cannot compile it: .*mass.*'b'",
    one(""): "MuJoCo cannot compile it: .*mass and inertia of moving bodies.*'b'",
    one(joints='<joint class="leg"/>'): "MuJoCo cannot compile it: .*unknown default class.*leg",
    mjcf(
        floating(body("b"), body("b", joints='<joint name="k"/>'))
    ): "MuJoCo cannot compile it: .*repeated name 'b'",
    one(HELD.format("nan", "1 1 1")): 'inertial: mass is "nan".*finite',
    one(at='pos="0 -inf 0"'): 'body "b": pos is "0 -inf 0".*finite',
    one(at='euler="NaN(1) 0 0"'): r'body "b": euler is "NaN\(1\) 0 0".*finite',
    one(HELD.format("1e200", "1e308 1e308 1e308")): r'body "b": mass is 1e\+200 kg',
    one(at='pos="0 0 1e100"'): r'body "b": pos is 1e\+100 m',
    one(
        joints='<joint name="j" armature="-0.1"/>'
    ): 'joint "j" has an armature that is not computed',
    mjcf(
        floating(f'<replicate count="200"><replicate count="200">{BODY}</replicate></replicate>')
    ): "elements.*20000.*count",
    mjcf(
        floating(f'<replicate count="2000">{body("b")}</replicate>')
    ): "2001 links, and up to 2000 are read",
    mjcf(floating(body("other", joints='<joint name="universe"/>'))): 'joint "universe".*rename',
    mjcf(floating(body("universe"))): 'body "universe".*rename',
    one(joints='<joint name="j+i"/><joint name="k" axis="0 1 0"/>'): r'joint "j\+i\+k".*rename',
    mesh("m.stl"): (
        'body "b" takes its mass from mesh "m", which cannot be read.*"m.stl" is '
        "missing.*<inertial>"
    ),
    mesh(
        "../../m.stl"
    ): 'body "b" takes its mass from mesh "m", which cannot be read.*outside the folders',
    among('<equality><joint name="n" joint1="j" joint2="k" polycoef="0 1 0.5 0 0"/></equality>'): (
        'the equality "n" couples joints by a curve, polycoef 0 1 0.5 0 0.*a0 a1 0 0 0'
    ),
    mjcf(
        floating('<site name="s"/>' + body("b", BODY + '<site name="t"/>')),
        after=SPATIAL + '<equality><tendon name="belt" tendon1="t"/></equality>',
    ): 'the equality "belt" couples tendons that are not fixed.*active="false"',
    among(
        '<equality><joint joint1="k" joint2="j"/><joint joint1="k" polycoef="0.1 0 0 0 '
        '0"/></equality>'
    ): ('the equality couples "k", but each of these follows already'),
    among(FIXED.format(' armature="0.5"')): 'tendon "t" has an armature that is not computed',
    among(FIXED.format("") + '<actuator><motor name="a" tendon="t" armature="0.1"/></actuator>'): (
        'actuator "a" has an armature that is not computed'
    ),
    # A missing, repeated or outlying part, and an attached model outside.
    mjcf(floating(), '<include file="none.xml"/>'): '"none.xml" is missing: no file',
    mjcf(floating(), '<include file="a.xml"/>'): 'includes "a.xml" twice',
    mjcf(
        floating(), '<include file="../secret.xml"/>'
    ): '"../secret.xml" leads to ".*/secret.xml", outside the folders',
    mjcf(
        floating(), '<asset><model name="s" file="../secret.xml"/></asset>'
    ): '"../secret.xml" leads to ".*/secret.xml"',
    mjcf(
        floating(), '<worldbody><body><flexcomp file="../x.obj"/></body></worldbody>'
    ): 'flexcomp: file is "../x.obj", a file that is not read here',
}


@pytest.mark.slow
@pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_computed_is_refused(
    text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    """The message names the file, the element and what is wrong with it, in one line; nothing else
    is printed.
    """
    folder = tmp_path / "dog"
    folder.mkdir()
    (folder / "package.xml").touch()
    (tmp_path / "secret.xml").write_text("<mujocoinclude/>")
    (folder / "a.xml").write_text('<mujocoinclude><include file="a.xml"/></mujocoinclude>')
    message = refusal(folder, text, "dog.xml")
    assert re.match(f"dog[.]xml(: | has | )[^\n]*{REFUSED[text]}", message), message
    assert "\n" not in message
    assert capfd.readouterr() == ("", "")
    assert {path.name for path in folder.iterdir()} == {"dog.xml", "package.xml", "a.xml"}


ONE = '<worldbody><body name="a"><freejoint/><geom size=".1"/></body></worldbody>'
GROWING = {
    "mesh": (
        f'<mujoco><asset><mesh name="m" builtin="supersphere" params="100000 1 '
        f'1"/></asset>{ONE}</mujoco>'
    ),
    "itself": f'<mujoco><asset><model name="s" file="itself.xml"/></asset>{ONE}</mujoco>',
    "levels": f'<mujoco><asset>{"".join(f"""<model name="n{k}" file="level0.xml"/>""" for k in range(4))}</asset>{ONE}</mujoco>',
}


@pytest.mark.parametrize("name", GROWING)
def test_what_grows_without_end_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A small file that asks MuJoCo for much time or memory costs neither, but a message."""
    monkeypatch.setattr("shockpc.robot.files.limited_process.SECONDS", 1)
    for k in range(12):
        text = (
            GROWING["levels"].replace("level0", f"level{k + 1}")
            if k < 11
            else f"<mujoco>{ONE}</mujoco>"
        )
        (tmp_path / f"level{k}.xml").write_text(text)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert "MuJoCo cannot compile it within" in refusal(tmp_path, GROWING[name], f"{name}.xml")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2**17  # kB


def test_a_count_with_a_sign_is_a_count(tmp_path: Path):
    text = mjcf(floating('<replicate count="+1000000"><geom size=".01"/></replicate>'))
    assert "elements after replication" in refusal(tmp_path, text, "dog.xml")


def test_a_point_weld_is_a_connect(tmp_path: Path):
    """torquescale="0" leaves the orientation free."""
    for scale, turns in (("0", False), ("2", True)):
        robot = from_text(
            tmp_path,
            among(f'<equality><weld torquescale="{scale}" body1="b" body2="c"/></equality>'),
        )
        assert [loop.holds_orientation for loop in robot.loops] == [turns]


def test_a_landing_that_a_fixed_base_cannot_do_says_how_to_free_it(tmp_path: Path):
    """Its legs may hang on the world apart from one another, and are robots of their own then."""
    leg = body("{0}", joints='<joint name="{0}_j" axis="0 1 0"/>')
    robot = loaded(tmp_path, mjcf(leg.format("a") + leg.format("b")), "dog.xml")
    parts = ["its file fixes the base", "--base free", "put them into one body with a <freejoint/>"]
    refused(SolveError, parts, shock_profile, Scene(robot="m", contact="a"), robot)
