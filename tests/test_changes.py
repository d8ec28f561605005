"""A changed robot: the masses, centres of mass, inertias and reflected inertias that were asked
for, and nothing else.
"""

import numpy as np
import pytest
import robot_texts
from robot_texts import LIMIT, joint, link, loaded, urdf

from shockpc.evaluation.variations.vary import read_changes
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Posture, Scene
from shockpc.profile import shock_profile
from shockpc.robot.changes import Change, changed, links_with_mass
from shockpc.robot.load import load_robot
from shockpc.robot.shapes import geometry
from shockpc.robot.shapes.geometry import outline
from shockpc.text.errors import RobotError, StudyError, UnknownName


@pytest.fixture(scope="module")
def dog():
    return load_robot("anymal_b")


def kinetic(robot, q, v):
    """Kinetic energy of the bodies, each from its mass, centre of mass and inertia."""
    import pinocchio as pin

    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q, v)
    found = 0.0
    for body in robot.bodies:
        twist = pin.SE3(body.rotation, body.offset).actInv(data.v[body.joint])
        speed = twist.linear + np.cross(twist.angular, body.com)
        found += (
            0.5 * body.mass * speed @ speed + 0.5 * twist.angular @ body.inertia @ twist.angular
        )
    return found


@pytest.mark.parametrize(
    "text",
    [
        "mass:*_SHANK=0.9x",
        "com-z:base_inertia=-0.03",
        "inertia:LF_THIGH=1.7x",
        "inertia-xz:LF_THIGH=0.002",
        "mass:base_inertia=20; com-y:*_HIP=0.01",
        " mass : base_inertia = 20 ",
    ],
)
def test_bodies_and_model_agree_after_a_change(dog, text):
    """The kinetic energy of Pinocchio's model is the sum over the bodies' records."""
    import pinocchio as pin

    robot = changed(dog, read_changes(text))
    rng = np.random.default_rng(1)
    q, v = dog.postures["standing"], rng.normal(size=dog.model.nv)
    H = pin.crba(robot.model, robot.model.createData(), q)
    H = np.triu(H) + np.triu(H, 1).T
    assert 0.5 * v @ H @ v == pytest.approx(kinetic(robot, q, v), rel=1e-13)
    assert kinetic(robot, q, v) != pytest.approx(kinetic(dog, q, v), rel=1e-6)


def test_mass_of_a_link_changes_in_proportion_with_its_inertia():
    """A link that is a body of its own."""
    robot = load_robot("leg")
    heavy = changed(robot, [Change("mass", robot.links[0], 2.0, True)])
    assert heavy.masses[0] == 2.0 * robot.masses[0]
    np.testing.assert_allclose(heavy.inertias[0], 2.0 * robot.inertias[0], rtol=1e-13, atol=1e-18)
    np.testing.assert_array_equal(heavy.coms, robot.coms)
    np.testing.assert_array_equal(heavy.masses[1:], robot.masses[1:])
    assert heavy.mass == pytest.approx(robot.mass + robot.masses[0], rel=1e-14)


def test_mass_as_a_number_is_the_same_as_its_factor(dog):
    number = changed(
        dog, [Change("mass", "LF_SHANK", 0.5 * links_with_mass(dog, "LF_SHANK")["LF_SHANK"], False)]
    )
    factor = changed(dog, [Change("mass", "LF_SHANK", 0.5, True)])
    np.testing.assert_allclose(number.inertias, factor.inertias, rtol=1e-12)
    assert not np.allclose(number.inertias, dog.inertias, rtol=1e-6)


def test_changes_of_one_link_add_up(dog):
    """Of a link that is only a part of its body, in any order."""
    texts = (
        "mass:base_inertia=0.8x; inertia:base_inertia=1.5x; mass:base_inertia=1.25x",
        "inertia:base_inertia=1.5x",
    )
    twice, once = (changed(dog, read_changes(text)) for text in texts)
    for name in ("masses", "coms", "inertias"):
        np.testing.assert_allclose(
            getattr(twice, name), getattr(once, name), rtol=1e-13, atol=1e-16
        )


def test_centre_of_mass_moves_along_the_axes_of_the_link():
    robot = load_robot("leg")
    moved = changed(robot, [Change("com-x", robot.links[0], 0.02, False)]).coms - robot.coms
    np.testing.assert_allclose(moved[0], [0.02, 0.0, 0.0], atol=1e-16)
    assert not moved[1:].any()


def test_a_glob_means_the_links_that_have_mass(dog):
    """Frames without mass are no obstacle to it, but are refused by name."""
    robot = changed(dog, read_changes("mass:*=2x"))
    np.testing.assert_allclose(robot.masses, 2.0 * dog.masses, rtol=1e-9)
    other = load_robot("go2")
    with pytest.raises(UnknownName, match='"imu" has no mass; the main link of its body is "base"'):
        changed(other, [Change("mass", "imu", 2.0, True)])
    assert changed(other, read_changes("mass:*=2x")).mass == pytest.approx(
        2.0 * other.mass, rel=1e-9
    )


def test_armature_of_the_robot_is_that_of_the_scene(dog):
    """A changed robot with free text and the original with the same armature in its scene give the
    same shock.
    """
    scene = Scene(robot="anymal_b", contact="LF_FOOT")
    by_robot = shock_profile(scene, changed(dog, read_changes("armature:*_KFE=0.05")))
    by_scene = shock_profile(
        Scene(robot="anymal_b", contact="LF_FOOT", joints=Joints(armature={"*_KFE": 0.05})), dog
    )
    np.testing.assert_array_equal(by_robot.maps, by_scene.maps)


def test_no_change_is_no_change(dog):
    robot = changed(dog, read_changes("mass:*=1x; inertia:*=1x; com-x:*=0; armature:*=0"))
    scene = Scene(robot="anymal_b", contact="LF_FOOT")
    np.testing.assert_array_equal(shock_profile(scene, robot).maps, shock_profile(scene, dog).maps)


def test_a_body_of_an_mjcf_changes_without_those_that_it_carries_rigidly(tmp_path):
    """Its inertia is kept apart from theirs, as that of a link of a URDF is."""
    bodies = robot_texts.body("b", joints=""), robot_texts.body("c")
    robot = robot_texts.loaded(tmp_path, robot_texts.mjcf(robot_texts.floating(*bodies)), "dog.xml")
    more = changed(robot, [Change("mass", "b", 3.0, True)])
    assert (links_with_mass(more, "base")["base"], links_with_mass(more, "b")["b"]) == (1.0, 3.0)
    assert more.masses.tolist() == [4.0, 1.0]


def test_an_unknown_property_is_refused():
    with pytest.raises(UnknownName, match='no property "com-w"; nearest: "com-'):
        Change("com-w", "trunk", 0.02, factor=False)


def test_original_stays_as_it_is(dog):
    before = (
        [np.array(inertia.toDynamicParameters()) for inertia in dog.model.inertias],
        np.array(dog.model.armature),
    )
    changed(dog, read_changes("mass:*=2x; armature:*=1"))
    for inertia, old in zip(dog.model.inertias, before[0], strict=True):
        np.testing.assert_array_equal(inertia.toDynamicParameters(), old)
    np.testing.assert_array_equal(dog.model.armature, before[1])


def test_geometry_is_read_once_for_all_variants(dog, monkeypatch):
    """The meshes of a variant are those that were read for the original."""
    seen = outline(dog, "collision")
    monkeypatch.setattr(geometry, "shared_xml", None)
    shared = outline(changed(dog, read_changes("mass:base=0.9x")), "collision")
    np.testing.assert_array_equal(shared.pieces.points, seen.pieces.points)


def test_uniform_scaling_of_all_masses_changes_no_shock(dog):
    """Shock is a velocity, and the impulse grows with the mass."""
    scene = Scene(robot="anymal_b", contact="LF_FOOT")
    heavy = shock_profile(scene, changed(dog, read_changes("mass:*=2x")))
    light = shock_profile(scene, dog)
    np.testing.assert_allclose(heavy.maps, light.maps, rtol=1e-9, atol=1e-12)
    assert heavy.contacts[0].effective_mass_sticking == pytest.approx(
        2.0 * light.contacts[0].effective_mass_sticking, rel=1e-9
    )


FOREARM = urdf(
    link("trunk", "2"),
    link("mount", "0.3"),
    link("shin", "0.5"),
    link("foot", "0.2"),
    link("toe", "0.1"),
    joint("clamp", "trunk", "mount", "fixed", more='<origin xyz="0.1 0 -0.1" rpy="0 0.3 0"/>'),
    joint("knee", "mount", "shin", more=f'{LIMIT}<origin xyz="0 0.05 -0.2" rpy="0.2 0 0"/>'),
    joint("ankle", "shin", "foot", "fixed", more='<origin xyz="0 0 -0.4" rpy="0 0.5 0"/>'),
    joint("ball", "foot", "toe", more=f'{LIMIT}<origin xyz="0.1 0 0"/>'),
)


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        ("place:knee=0,0.05,-0.3", "0 0.05 -0.2", "0 0.05 -0.3"),
        ("place:ankle=1.5x", "0 0 -0.4", "0 0 -0.6000000000000001"),
        ("place:clamp=0.2,0.1,-0.1", "0.1 0 -0.1", "0.2 0.1 -0.1"),
        ("place:ball=0,0,0", "0.1 0 0", "0 0 0"),
    ],
)
def test_a_moved_joint_is_that_of_the_edited_file(tmp_path, text, old, new):
    """Also a fixed one, which moves links of its body and the joints on them."""
    first, edited = (
        loaded(tmp_path, part, name)
        for name, part in (
            ("a.urdf", FOREARM),
            ("b.urdf", FOREARM.replace(f'xyz="{old}"', f'xyz="{new}"')),
        )
    )
    moved = changed(first, read_changes(text))
    scene = Scene(robot="a.urdf", contact="toe", posture=Posture(joints_deg={"knee": 20}))
    for a, b in (
        (moved, edited),
        (
            first,
            changed(
                moved, read_changes(f"place:{text[6:].partition('=')[0]}={old.replace(' ', ',')}")
            ),
        ),
    ):
        mine, other = shock_profile(scene, a), shock_profile(scene, b)
        np.testing.assert_allclose(mine.maps, other.maps, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(mine.position, other.position, atol=1e-14)
        np.testing.assert_allclose(a.coms, b.coms, atol=1e-15)
        assert mine.contacts[0].effective_mass_sticking == pytest.approx(
            other.contacts[0].effective_mass_sticking, rel=1e-12
        )


def test_geometry_moves_with_its_link(dog):
    """The shank's collision geometry, and the foot on it, are where the new placements of their
    links are.
    """
    lowered = changed(dog, read_changes("place:LF_KFE=0,0,-0.3; place:LF_SHANK_TO_ADAPTER=1.1x"))
    knee = dog.joint("LF_KFE")
    np.testing.assert_allclose(lowered.joint("LF_KFE").offset, [0.0, 0.0, -0.3])
    np.testing.assert_array_equal(lowered.joint("LF_KFE").rotation, knee.rotation)
    body = dog.body("LF_FOOT")
    by = lowered.frames["LF_FOOT"].offset - dog.frames["LF_FOOT"].offset
    assert np.linalg.norm(by) > 0.01
    for before, after in zip(
        outline(dog, "collision").shapes[body],
        outline(lowered, "collision").shapes[body],
        strict=True,
    ):
        np.testing.assert_allclose(
            after.points - before.points,
            np.tile(0 * by if before.link == "LF_SHANK" else by, (len(before.points), 1)),
            atol=1e-12,
        )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("place:LF_KFE=0.3", "three numbers"),
        ("place:LF_KFE=0,0,inf", "is not a change"),
        ("mass:base=1,2,3", "one number"),
        ("thigh=0.9x", "is not a change"),
        ("weight:base=2", "properties are mass"),
        ("mass:base=", "is not a change"),
        ("mass:base=nan", "is not a change"),
        ("mass:base=inf", "is not a change"),
        ("mass:base=-1", "below zero"),
        ("inertia:base=0.2", "six entries"),
        ("com-x:base=2x", "metres"),
        ("inertia-xy:base=2x", "not by a factor"),
        (" ; ", "holds no change"),
    ],
)
def test_refusal_of_a_change_says_what_is_valid(text, words):
    with pytest.raises(StudyError, match=words):
        read_changes(text)


def test_unknown_names_are_refused(dog):
    with pytest.raises(UnknownName, match="LF_SHANK"):
        changed(dog, [Change("mass", "LF_SHNK", 0.9, True)])
    with pytest.raises(UnknownName, match="joint"):
        changed(dog, [Change("armature", "knee", 0.9, True)])
    with pytest.raises(StudyError, match="no effect"):
        changed(dog, [Change("armature", "*", 2.0, True)])
    with pytest.raises(UnknownName, match='"LF_KFE"'):
        changed(dog, read_changes("place:LF_KFF=0,0,-0.3"))
    with pytest.raises(UnknownName, match="joint"):
        changed(dog, read_changes("place:root_joint=0,0,-0.3"))
    with pytest.raises(RobotError, match="cannot be computed with"):
        changed(dog, [Change("mass", "LF_SHANK", 1e30, False)])
