"""What flat ground cannot touch, limbs that are straight because no posture is known, and numbers
in another unit: warned of.
"""

import math
import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from commands import run, says
from robot_texts import LIMIT, arm, joint, link, mjcf, refused, urdf, written
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Design,
    Joints,
    Point,
    Posture,
    Robot,
    Scene,
    SceneError,
    ShockWarning,
    Strike,
    compare,
    read_scene,
    shock_profile,
)
from shockpc.evaluation.budgets import Budget, Budgets, Case, DesignVariation
from shockpc.evaluation.cost import ShockCost
from shockpc.landing.resolve import resolve
from shockpc.method.constraints import constraint_point
from shockpc.method.dynamics import dynamics
from shockpc.quantities.ground.levels import levels
from shockpc.robot.feet_and_sensors import each_foot, feet
from shockpc.robot.shapes import geometry
from shockpc.robot.shapes.geometry import inflated_inertias
from shockpc.studies.batch.study import batch
from shockpc.studies.check.study import check_budgets
from shockpc.studies.limits.study import limits
from shockpc.studies.sweep.study import sweep
from shockpc.studies.sweep.summary import summarise

LEG = """
<body name="{0}_thigh" pos="{1} .1 0">
  <joint name="{0}_roll" axis="1 0 0"/><joint name="{0}_hip" axis="0 1 0"/>
  <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>
  <body name="{0}_calf" pos="0 0 -.2">
    <joint name="{0}_knee" axis="0 1 0"/><inertial pos="0 0 -.1" mass=".5" diaginertia=".005 .005 .005"/>
    <geom name="{0}" class="foot"/>
  </body>
</body>"""
DOG = f"""
<mujoco model="dog">
  <default><default class="foot"><geom type="sphere" size=".02" pos="0 0 -.2"/></default></default>
  <worldbody><body name="trunk"><freejoint/><inertial pos="0 0 0" mass="12" diaginertia=".1 .2 .2"/>
    <geom type="box" size=".2 .1 .05"/>{LEG.format("FL", ".2")}{LEG.format("HL", "-.2")}
  </body></worldbody>
</mujoco>"""
"""A dog of two legs: feet, balls of 2 cm radius, 0.4 m below the hips and 0.4 m apart; the trunk's
bottom is 5 cm below them.
"""


@pytest.fixture(scope="module")
def dog() -> Robot:
    return robot_from(DOG, ".xml")


def warned(robot: Robot, *kinds: str, **scene):
    """The warnings of these kinds."""
    found = shock_profile(Scene(robot=robot.label, **scene), robot).health.warnings
    return [warning for warning in found if warning.kind in kinds]


# Feet


def test_a_foot_without_a_link_is_a_geom(dog: Robot, tmp_path: Path, capfd):
    """The geom's centre is the contact point, and its lowest point the sphere's; it is what a
    refused command suggests.
    """
    for ours, drop in ((Contact(frame="FL"), 0.2), (Contact(frame="FL", at="lowest"), 0.22)):
        same = Contact(frame="FL_calf", offset=(0, 0, -drop))
        found, expected = (
            shock_profile(Scene(robot=dog.label, contact=(one,)), dog).delta_v
            for one in (ours, same)
        )
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-15)
    assert feet(dog) == ("FL", "HL")
    assert (
        "--vary contact=FL+HL,FL,HL"
        in run(capfd, "sweep", written(tmp_path, DOG, "dog.xml"), "--vary", "speed=1").err
    )
    unnamed = written(
        tmp_path, DOG.replace('name="FL" ', "").replace('name="HL" ', ""), "unnamed.xml"
    )
    assert (
        "--vary contact=FL_calf+HL_calf,FL_calf,HL_calf"
        in run(capfd, "sweep", unnamed, "--vary", "speed=1").err
    )


@pytest.mark.parametrize("name", ["a_foot", "toe_site"])
def test_a_site_named_like_a_foot_comes_first(name: str):
    """Before geoms of that name, and before those of other names, wherever on the body it is."""
    robot = robot_from(
        DOG.replace('<geom name="FL"', f'<site name="{name}"/><geom name="FL"'), ".xml"
    )
    assert feet(robot) == (name,)


ROD = (
    '<body name="{0}_toe_rod" pos="0 0 -.1"><joint axis="0 1 0"/><geom type="capsule" size=".01" '
    'fromto="0 0 0 0 0 -.3"/></body>'
)
FOOT = (
    '<body name="{0}_foot" pos="0 0 -.4"><joint axis="0 1 0"/><geom type="box" size=".1 .05 '
    '.02"/>{1}</body>'
)
TOE = '<body name="toe_{0}"><joint/><geom size=".02"/></body>'


def humanoid(beyond: str = "", shin: float = 0.4) -> Robot:
    """A humanoid with a hand, a camera and two shanks, of a length [m], which carry what is beyond
    them.
    """
    legs = [
        f'''<body name="{side}_shank" pos="0 {y} -.5"><joint axis="0 1 0"/>{beyond.format(side, TOE.format(side))}
        <geom type="capsule" size=".03" fromto="0 0 0 0 0 {-shin}"/></body>'''
        for side, y in (("left", 0.1), ("right", -0.1))
    ]
    torso = """<body name="torso"><joint axis="0 0 1"/><geom type="box" size=".1 .1 .3" pos="0 0 .4"/>
      <body name="camera_head" pos="0 0 .8"><joint/><geom size=".1"/></body>
      <body name="finger" pos="0 .3 .2"><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 0 0 -.4"/></body>
    </body>"""
    pelvis = '<body name="pelvis" pos="0 0 1"><freejoint/><geom type="box" size=".1 .1 .1"/>'
    return robot_from(mjcf(f"{pelvis}{torso}{''.join(legs)}</body>"), ".xml")


@pytest.mark.parametrize(
    ("beyond", "expected"),
    [(ROD + FOOT.replace("{1}", ""), "{}_foot"), (ROD + FOOT, "toe_{}"), ("", "{}_shank")],
    ids=["foot", "foot with a toe", "shank"],
)
def test_feet_are_low_ends_of_limbs(beyond: str, expected: str):
    """Neither rods of an ankle nor fingers nor a camera; a leg has one foot, however many of its
    bodies are named so.
    """
    robot = humanoid(beyond)
    assert feet(robot) == each_foot(robot) == tuple(map(expected.format, ("left", "right")))


def legged(
    *parts: str, sides: tuple[str, ...] = ("left", "right"), turned: dict[str, str] | None = None
) -> Robot:
    """A URDF of legs under a base, each of these parts, in which {0} is the side; some legs are
    turned about the x axis.
    """
    hips = [
        joint(
            f"hip_{side}",
            "base",
            f"thigh_{side}",
            more=f'<origin xyz="0 0.1 0" rpy="{(turned or {}).get(side, "0 0 0")}"/>' + LIMIT,
        )
        for side in sides
    ]
    return robot_from(
        urdf(
            link("base"),
            *(part.format(side) for side in sides for part in (link("thigh_{0}"), *parts)),
            *hips,
        )
    )


def fixed_at(parent: str, child: str, place: str, kind: str = "fixed") -> str:
    """A joint of a leg. Args: place: of the child, in the parent [m]."""
    return joint(f"to_{child}", parent, child, kind, more=f'<origin xyz="{place}"/>' + LIMIT)


SHANK = link("shank_{0}") + fixed_at("thigh_{0}", "shank_{0}", "0 0 -0.3", "revolute")
LIMBS = {
    "a foot's frame at the knee, and a toe fixed below it": (
        (
            link("foot_{0}") + fixed_at("thigh_{0}", "foot_{0}", "0 0 -0.3", "revolute"),
            link("toe_{0}") + fixed_at("foot_{0}", "toe_{0}", "0 0 -0.3"),
        ),
        "toe_{}",
    ),
    "rods named toe on the shank, which end just above the ankle": (
        (
            SHANK,
            link("toe_a_{0}") + fixed_at("shank_{0}", "toe_a_{0}", "0.02 0 -0.1"),
            link("toe_b_{0}") + fixed_at("toe_a_{0}", "toe_b_{0}", "0 0 -0.19"),
            link("ankle_{0}") + fixed_at("shank_{0}", "ankle_{0}", "0 0 -0.3", "revolute"),
        ),
        "ankle_{}",
    ),
    "screws of a shank that is drawn last but two": (
        (
            SHANK,
            *(
                link(f"screw_{k}_{{0}}", "1e-4")
                + fixed_at("shank_{0}", f"screw_{k}_{{0}}", "0 0 -0.01")
                for k in (1, 2)
            ),
        ),
        "shank_{}",
    ),
    "a heel and a sole of one foot": (
        (
            SHANK,
            *(
                link(f"{name}_{{0}}") + fixed_at("shank_{0}", f"{name}_{{0}}", "0 0 -0.3")
                for name in ("foot_heel", "sole")
            ),
        ),
        "sole_{}",
    ),
}


@pytest.mark.parametrize("case", LIMBS)
def test_names_choose_only_among_the_low_ends_of_limbs(case: str):
    """Where the frame that is named like a foot is at the knee, or a body follows that reaches
    lower, it is none.
    """
    parts, expected = LIMBS[case]
    assert each_foot(legged(*parts)) == (expected.format("left"), expected.format("right"))


def test_legs_that_are_drawn_folded_have_feet_too():
    """Of four legs of the same masses two are drawn upwards; an arm, whose masses are others, has
    no foot.
    """
    sides = ("lf", "rf", "lh", "rh")
    turned = {"lf": "3.141592653589793 0 0", "rh": "3.141592653589793 0 0"}
    robot = legged(
        SHANK,
        link("end_{0}") + fixed_at("shank_{0}", "end_{0}", "0 0 -0.3"),
        sides=sides,
        turned=turned,
    )
    assert sorted(feet(robot)) == sorted(f"end_{side}" for side in sides)
    arm = (
        link("upper", "0.3")
        + fixed_at("base", "upper", "0.1 0 0.1", "revolute")
        + link("hand", "0.2")
        + fixed_at("upper", "hand", "0 0 0.3", "revolute")
    )
    armed = robot_from(robot.source.xml.replace("</robot>", f"{arm}</robot>"))
    assert sorted(feet(armed)) == sorted(f"end_{side}" for side in sides)


def test_where_only_the_shank_is_named_its_lowest_point_is_struck():
    """Its frame is at the knee, which no landing hits; one little above the lowest point is struck,
    whatever its name is.
    """
    for robot, at in (
        (humanoid(), "lowest"),
        (humanoid(shin=0.005), "frame"),
        (humanoid(FOOT), "frame"),
    ):
        landed = resolve(Scene(robot=robot.label, contact=each_foot(robot)), robot)
        assert [contact.at for contact in landed.scene.contact] == [at] * 2


# Heights

PITCHED = Posture(base_rpy_deg=(0, 15, 0))
KNEE = Posture(joints_deg={"FL_knee": 60})
KNEE_OF = {leg: Contact(frame=f"{leg}_calf", at="frame") for leg in ("FL", "HL")}
RISE = 0.4 * math.sin(math.radians(15.0))


@pytest.mark.parametrize(
    ("contacts", "scene", "found"),
    [
        (("FL",), {}, []),
        (("FL", "HL"), {}, []),
        (("FL_calf",), {}, []),
        ((KNEE_OF["FL"],), {}, [("FL_calf", 0.22)]),
        ((Contact(frame="FL_calf", at="lowest"),), {}, []),
        ((KNEE_OF["FL"], KNEE_OF["HL"]), {}, [("FL_calf+HL_calf", 0.22)]),
        ((Contact(frame="trunk", at="frame"),), {}, [("trunk", 0.05), ("trunk", 0.37)]),
        (("FL",), {"posture": PITCHED}, []),
        (("HL",), {"posture": PITCHED}, [("HL", RISE)]),
        (("FL", "HL"), {"posture": PITCHED}, [("HL", RISE)]),
        (("HL",), {"posture": PITCHED, "stance": ("FL",)}, [("HL", RISE)]),
        (("FL", "HL"), {"posture": Posture(base_rpy_deg=(0, 0.7, 0))}, []),
        (
            ("FL", "HL"),
            {"posture": Posture(base_rpy_deg=(0, 0.75, 0))},
            [("HL", 0.4 * math.sin(math.radians(0.75)))],
        ),
        (
            ("FL", "HL"),
            {"posture": Posture(base_rpy_deg=(0, 0.75, 0)), "ground_tolerance": 0.006},
            [],
        ),
        (("FL",), {"posture": KNEE, "ground_tolerance": 0.11}, []),
        (("FL", "HL"), {"posture": KNEE}, [("FL", 0.1)]),
        (("FL",), {"posture": KNEE}, [("FL", 0.1)]),
        (("FL",), {"posture": KNEE, "base": "fixed"}, []),
    ],
)
def test_heights(dog: Robot, contacts, scene, found):
    """A link that reaches below its contact point, another part of a robot that is not bolted down,
    contacts at two heights.
    """
    seen = warned(dog, "height", contact=contacts, **scene)
    assert [(one.subject, pytest.approx(one.value)) for one in seen] == found
    assert all(f"{one.value:.2g} m" in one.text for one in seen)


def test_a_link_that_moves_with_the_contact_is_named_before_another_foot():
    """The sole below the frame that is struck is as low as the other feet, which are not the cause."""
    sole = FOOT.format(
        "{0}", '<body name="{0}_sole" pos="0 0 -.1"><geom type="box" size=".1 .05 .01"/></body>'
    )
    robot = humanoid(sole)
    (warning,) = warned(robot, "height", contact=("right_foot",))
    assert 'meets "right_sole" first; it moves with the contact' in warning.text


@pytest.mark.parametrize("name", ["a1", "anymal_b", "b1", "hyq"])
def test_robots_that_stand_are_not_warned_of(name: str):
    """On one foot and on all."""
    robot = known_robot(name)
    for contacts in (*((foot,) for foot in each_foot(robot)), each_foot(robot)):
        assert warned(robot, "height", "straight", "unit", contact=contacts) == []


def test_only_warnings_read_geometry(monkeypatch: pytest.MonkeyPatch):
    """An analysis without them reads the geometry of what strikes and of its body, and none where
    point and kind are given.
    """
    robot, read, shapes = replace(robot_from(DOG, ".xml")), [], geometry._shapes
    monkeypatch.setattr(
        geometry, "_shapes", lambda *given: read.append(given[3:]) or shapes(*given)
    )
    shock_profile(
        Scene(robot=robot.label, contact=(Contact(frame="FL", at="frame", kind="point"),)), robot
    )
    assert read == []
    profile = shock_profile(Scene(robot=robot.label, contact=("FL",)), robot)
    assert read == [("FL",), ("FL_calf",)]
    assert profile.health.warnings
    assert len(read) == 3


# Posture

HOME = '<keyframe><key name="home" qpos="0 0 0 1 0 0 0 0 0 0 0 0 0"/></keyframe>'


def test_a_straight_limb_that_nobody_chose(dog: Robot):
    """With the mitigation factor of that contact; not in a posture of the file, bent or not, nor
    where a joint is set.
    """
    profile = shock_profile(Scene(robot=dog.label, contact=("FL",)), dog)
    (warning,) = (one for one in profile.health.warnings if one.kind == "straight")
    assert (warning.subject, warning.value) == ("FL", profile.contacts[0].mitigation)
    assert "no standing posture found: neutral" in warning.text
    assert f"mitigation {warning.value:.2g}; set joints with --set" in warning.text
    home = robot_from(DOG.replace("</worldbody>", f"</worldbody>{HOME}"), ".xml")
    assert warned(home, "straight", contact=("FL",)) == []
    assert (
        warned(dog, "straight", contact=("FL",), posture=Posture(joints_deg={"HL_knee": 0})) == []
    )
    bent = robot_from(
        DOG.replace('_calf" pos="0 0 -.2"', '_calf" pos="0 0 -.2" euler="0 40 0"'), ".xml"
    )
    assert warned(bent, "straight", contact=("FL",)) == []
    assert warned(dog, "straight", contact=("trunk",)) == []
    every = warned(dog, "straight", contact=("FL", "HL"))
    assert [(one.subject, "2 alike" in one.text) for one in every] == [("FL+HL", True)]


SQUARE = [(0.2, 0.1), (0.2, -0.1), (-0.2, 0.1), (-0.2, -0.1)]
HEXAGON = [(math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)) for k in range(6)]


def test_a_single_foot_whose_joints_are_set_may_be_beside_the_centre_of_mass():
    """A leg on a rig lands as it is set; where nothing is set, it lies."""
    foot = joint("knee", "thigh", "tip_foot", more=f'{LIMIT}<origin xyz="0 0 -0.3"/>')
    robot = robot_from(
        urdf(link("base"), link("thigh"), link("tip_foot"), joint("hip", "base", "thigh"), foot)
    )
    for x, count in ((0.0, 0), (1.0, 1)):
        moved = robot_from(robot.source.xml.replace('xyz="0 0 -0.3"', f'xyz="{x} 0 -0.3"'))
        for set_, expected in (({}, count), ({"hip": 5.0}, 0)):
            found = warned(
                moved,
                "standing",
                contact=("tip_foot",),
                posture=Posture(reference="neutral", joints_deg=set_),
            )
            assert len(found) == expected


@pytest.mark.parametrize(
    ("feet", "turn"),
    [
        ([(x, y, -0.3) for x, y in SQUARE], None),
        ([(x, -0.3, y) for x, y in SQUARE], "90,0,0"),
        ([(-0.3, x, y) for x, y in SQUARE], "0,-90,0"),
        ([(x, y, 0.3) for x, y in SQUARE], "180,0,0"),
        ([(x, y, 0.0) for x, y in HEXAGON], ""),
    ],
)
def test_a_robot_that_lies_is_told_the_turn_by_which_it_stands(
    feet: list[tuple[float, float, float]], turn: str | None
):
    """Which does that; legs that sprawl to all sides are not put down by a turn, so none is named."""
    legs = []
    for k, (x, y, z) in enumerate(feet):
        legs += [link(f"leg{k}_thigh", "0.1"), joint(f"hip{k}", "base", f"leg{k}_thigh")]
        place = f'{LIMIT}<origin xyz="{x} {y} {z}"/>'
        legs += [
            link(f"leg{k}_foot", "0.1"),
            joint(f"knee{k}", f"leg{k}_thigh", f"leg{k}_foot", more=place),
        ]
    robot = robot_from(urdf(link("base", "10"), *legs))
    found = warned(robot, "standing", contact=("leg0_foot",), posture=Posture(reference="neutral"))
    assert [re.findall(r"--base-rpy ?([-\d,]*)", one.text) for one in found] == (
        [] if turn is None else [[turn]]
    )
    if turn:
        rotation = pin.rpy.rpyToMatrix(np.radians([float(angle) for angle in turn.split(",")]))
        assert (np.array(feet) @ rotation.T)[:, 2] == pytest.approx(-0.3)


# Units


@pytest.mark.parametrize(
    ("scene", "meant"),
    [
        (
            {"posture": Posture(joints_deg={"FL_knee": -1.4})},
            "FL_knee = -1.4 deg: if radians are meant, give -80.21 deg",
        ),
        ({"posture": Posture(joints_deg={"*_knee": -3, "FL_knee": 0.5})}, "give -171.9, 28.65 deg"),
        (
            {"posture": Posture(base_rpy_deg=(0, 0.26, 0))},
            "pitch = 0.26 deg: if radians are meant, give 14.9 deg",
        ),
        (
            {"strike": Strike(strike_angle_deg=0.26)},
            "strike angle = 0.26 deg: if radians are meant, give 14.9 deg",
        ),
        (
            {"posture": Posture(joints={"FL_knee": -60.0})},
            "FL_knee = -60 rad: if degrees are meant, give -1.047 rad",
        ),
        (
            {"joints": Joints(armature={"*_knee": 50})},
            "50 kg m², on a robot of 15 kg; if kg cm² are meant, give 0.005 kg m²",
        ),
        ({"posture": Posture(joints_deg={"FL_knee": -2, "HL_knee": 1})}, None),
        ({"posture": Posture(joints_deg={"FL_knee": -30.5, "HL_knee": 1.5})}, None),
        ({"posture": Posture(joints_deg={"FL_knee": 0.01})}, None),
        ({"posture": Posture(joints={"FL_knee": -1.4})}, None),
        ({"joints": Joints(armature={"*_knee": 5})}, None),
    ],
)
def test_units(dog: Robot, scene, meant):
    """The value and its unit, and what it would be in the other."""
    texts = [one.text for one in warned(dog, "unit", contact=("FL",), **scene)]
    assert len(texts) == (meant is not None)
    assert all(meant in text for text in texts)


def test_grams():
    """Of a robot of 12 kg; a large reflected inertia is not odd on one that heavy."""
    robot = robot_from(DOG.replace('mass="12"', 'mass="12000"'), ".xml")
    (warning,) = warned(robot, "unit", contact=("FL",), joints=Joints(armature={"*_knee": 50}))
    assert says(warning.text, "1.2e+04 kg", "grams", "12 kg")


@pytest.mark.parametrize(
    "path",
    sorted((Path(__file__).parents[1] / "robots/scenes").glob("*.toml")),
    ids=lambda path: path.stem,
)
def test_scenes_of_the_paper(path):
    """Only one of them has more of the robot below its contact than the thickness of a beam: the
    heel of case F.
    """
    found = [warning.kind for warning in shock_profile(read_scene(path)).health.warnings]
    assert found == ["height"] * (path.stem == "fig2_f")


def test_the_lowest_point_may_be_struck_where_all_geometry_is_visual():
    """What is warned of is what the remedy strikes."""
    contact, human = Contact(frame="left_foot", at="frame"), known_robot("human")
    (below,) = (
        w
        for w in shock_profile(Scene(robot="human", contact=contact), human).health.warnings
        if "lowest" in str(w)
    )
    lowest = shock_profile(Scene(robot="human", contact=replace(contact, at="lowest")), human)
    assert not any("contact point" in str(warning) for warning in lowest.health.warnings)
    frame = shock_profile(Scene(robot="human", contact=contact), human)
    assert frame.contacts[0].point[2] - lowest.contacts[0].point[2] == pytest.approx(below.value)


def test_depth_is_how_far_another_foot_is_below_the_contact(dog: Robot):
    """A bent knee raises its foot by 0.2 m (1 − cos θ); the straight leg is that far below, in a
    sweep and in one landing.
    """
    scene = Scene(robot=dog.label, contact="FL")
    made = sweep(
        scene,
        {"FL_knee": [0.0, 30.0, 70.0]},
        robot=dog,
        quantities=["depth_below_contacts"],
        prove=0,
    )
    expected = 0.2 * (1.0 - np.cos(np.radians([0.0, 30.0, 70.0])))
    np.testing.assert_allclose(
        made.chunk(0).columns["depth_below_contacts@dog"], expected, atol=1e-12
    )
    assert [
        float(shock_profile(*made.landings.case(k)).value("depth_below_contacts", "robot")[0])
        for k in range(3)
    ] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("struck", ["FL", "FL_site"], ids=["geom", "site at its centre"])
@pytest.mark.parametrize("tolerance", [None, 0.0, 0.02])
def test_feasible_is_a_landing_whose_lowest_points_agree_to_the_tolerance(
    struck: str, tolerance: float | None
):
    """A bent knee raises its round foot by 0.2 m (1 − cos θ) above the other one, whatever frame of
    the foot is struck.

    While the other foot is level, only a tilt makes the landing.
    """
    robot = robot_from(
        DOG.replace('<geom name="FL"', '<site name="FL_site" pos="0 0 -.2"/><geom name="FL"'),
        ".xml",
    )
    rise = np.array([0.0, 0.0049, 0.0051, 0.0199, 0.0201])
    scene = Scene(
        robot=robot.label,
        contact=struck,
        **({} if tolerance is None else {"ground_tolerance": tolerance}),
    )
    made = sweep(
        scene,
        {"FL_knee": np.degrees(np.arccos(1.0 - rise / 0.2)).tolist()},
        robot=robot,
        quantities=["feasible"],
        prove=0,
    )
    nothing = [0.0] * len(rise)
    allowed = rise <= (0.005 if tolerance is None else tolerance)
    found = made.chunk(0)
    assert [found.columns[f"{key}@dog"].tolist() for key in ("feasible", "feasible_if_tilted")] == [
        nothing,
        allowed.tolist(),
    ]
    assert found.feasible.tolist() == allowed.tolist()
    profiles = [shock_profile(*made.landings.case(k)) for k in range(len(rise))]
    assert [float(profile.value("feasible", "robot")[0]) for profile in profiles] == nothing
    assert [
        float(profile.value("feasible_if_tilted", "robot")[0]) for profile in profiles
    ] == allowed.tolist()
    assert [
        not any(one.kind == "height" for one in profile.health.warnings) for profile in profiles
    ] == allowed.tolist()


@pytest.mark.parametrize("base", ["free", "fixed"])
def test_contacts_at_two_heights_are_not_feasible(dog: Robot, base: str):
    for angle, allowed in ((0.7, 1.0), (0.75, 0.0)):
        posture = Posture(base_rpy_deg=(0, angle, 0), joints_deg={"*_knee": 10})
        profile = shock_profile(
            Scene(robot=dog.label, contact=("FL", "HL"), base=base, posture=posture), dog
        )
        assert profile.value("feasible", "robot")[0] == allowed


def test_warnings_of_a_landing_are_python_warnings(capfd):
    """Once for each cause, at the line that asked; the command does not give them twice."""
    scene = Scene(robot="anymal_b", contact=Contact(frame="LF_SHANK", at="frame"))
    with pytest.warns(ShockWarning, match="LF_SHANK") as caught:
        profile = shock_profile(scene)
    found = [warning.message.diagnostic for warning in caught if warning.category is ShockWarning]
    assert found == list(profile.health.warnings)
    assert {warning.filename for warning in caught} == {__file__}
    assert any('at = "lowest"' in str(one) for one in found)
    other = replace(scene, strike=Strike(speed=2.0))
    with pytest.warns(ShockWarning) as caught:
        compare(
            [
                Design(name, one, known_robot("anymal_b"))
                for name, one in (("a", scene), ("b", other))
            ]
        )
    assert len(caught) == len(found)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        outcome = run(
            capfd, "analyze", "anymal_b", "--contact", "LF_SHANK", "--contact-point", "frame"
        )
    assert "0.25 m of the robot" in outcome.out
    assert "ShockWarning" not in outcome.out + outcome.err


def test_an_impact_that_makes_energy_is_not_feasible_in_any_study():
    """Restitution along the normal and an approach along the ground; it makes ½ λ · (v⁻ + v⁺),
    along the ground alone.
    """
    robot = known_robot("anymal_b")
    tilted = Posture(base_rpy_deg=(-3.0, 3.0, 0.0))  # no other foot is level
    contact = (Contact(frame="LF_FOOT", restitution=1.0),)
    scene = Scene(
        robot="anymal_b", posture=tilted, contact=contact, point=(Point(frame="imu_link"),)
    )
    angles = np.array([-20.0, -5.0, 0.0, 20.0])
    struck = [replace(scene, strike=Strike(strike_angle_deg=angle)) for angle in angles.tolist()]
    profiles = [shock_profile(one, robot) for one in struck]
    made = np.array(
        [
            0.5 * one.contacts[0].impulse[0] * np.sin(np.radians(x))
            for one, x in zip(profiles, angles, strict=True)
        ]
    )
    expected, allowed = np.maximum(made, 0.0), made <= 0.0
    assert allowed.tolist() == [False, False, True, True]
    for profile, energy, feasible in zip(profiles, expected, allowed, strict=True):
        found = [profile.value(key, "robot")[0] for key in ("energy_gained", "feasible")]
        assert found == pytest.approx([energy, float(feasible)], rel=1e-9)
        assert [one.kind for one in profile.health.warnings if one.kind == "energy"] == [
            "energy"
        ] * (not feasible)
    swept = sweep(scene, {"strike-angle": angles.tolist()}, robot=robot, at=["imu_link"], prove=0)
    rows = swept.table
    np.testing.assert_allclose(rows.values("energy_gained"), expected, rtol=1e-9)
    assert rows.feasible.tolist() == allowed.tolist()
    summary = summarise(swept, rows)
    assert summary.refused._asdict() == {"rows": 2, "pulled": 0, "gained": 2, "below": 0}
    assert summary.extents[0].best_row == 2
    cost = ShockCost(scene, "shock@imu_link", {"strike-angle": "-20:20"}, robot)
    assert [cost.feasible([angle]) for angle in angles] == allowed.tolist()
    span = {"joint_range": (0.8, 1.2), "step": 0.4, "strikes": (-0.4, -0.3), "robot": robot}
    found = limits(scene, "mass:base", Point(frame="imu_link"), 1.0, **span)
    assert [found.scan.feasible(one.strikes).any() for one in found.limits] == [
        one.strikes[0] >= 0.0 for one in found.limits
    ]
    varied = (DesignVariation(quantity="strike-angle", values="-20:0"),)
    case = Case(
        name="steep", robot="anymal_b", posture=tilted, contact=contact, vary=varied, designs=8
    )
    budget = Budget(metric="shock", at="imu_link", max=1.0, percentile=50.0)
    notes = check_budgets(Budgets(cases=(case,), budgets=(budget,), path=None, lines=())).notes
    assert any("steep" in note and "energy in 8 of 8 designs" in note for note in notes)
    batched = batch(["anymal_b"], lambda name: (robot, struck))
    assert [row.values["feasible"] for row in batched.rows] == [
        float(row.scene.strike.strike_angle_deg >= 0.0) for row in batched.rows
    ]


@pytest.mark.parametrize("name", ["hyq", "anymal_b", "talos"])
def test_bodies_that_cannot_be_the_lowest_are_left_out(name: str):
    """In random postures depth, heights of contacts and the lowest shape are those with every body
    measured.
    """
    robot = known_robot(name)
    landing = resolve(Scene(robot=name, contact=feet(robot)[0]), robot)
    rng = np.random.default_rng(3)
    steps = rng.uniform(-1.5, 1.5, (200, robot.model.nv))
    state = dynamics(
        robot, np.stack([pin.integrate(robot.model, landing.q, step) for step in steps])
    )
    points = np.stack([constraint_point(state, landing.constraints[0])], axis=1)
    few, every = (
        levels(landing, state.rotation, state.position, points, every=every)
        for every in (False, True)
    )
    np.testing.assert_allclose(few.depth, every.depth, atol=1e-12)
    np.testing.assert_allclose(few.contacts, every.contacts, atol=1e-12)
    assert np.any(few.depth > 0.0)
    assert np.any(np.isinf(few.surface))
    deep = few.depth > 0.0
    lowest = [
        np.where(one.of_no_contact, one.surface, np.inf)[deep].argmin(axis=1)
        for one in (few, every)
    ]
    np.testing.assert_array_equal(*lowest)


def test_a_tolerance_below_zero_is_refused(dog: Robot):
    landing = Scene(robot=dog.label, contact="FL", ground_tolerance=-0.001)
    refused(SceneError, ["ground_tolerance must be ≥ 0 m, got -0.001"], shock_profile, landing, dog)


# Inertias

PLACEHOLDER = DOG.replace(
    'mass=".5" diaginertia=".005 .005 .005"', 'mass=".1" diaginertia="{0} {0} {0}"'
)


@pytest.mark.parametrize(("moment", "found"), [(0.001, False), (0.1, True), (1000.0, True)])
def test_moments_of_inertia_that_no_body_within_the_robot_has(
    moment: float, found: bool, tmp_path: Path, capfd
):
    """Named with the radius of gyration √(I/m), by the analysis and by the check-up, and heights
    are as without them.
    """
    robot = robot_from(PLACEHOLDER.format(moment), ".xml")
    assert [one.value for one in warned(robot, "inertia", contact=("FL",))] == [
        pytest.approx(math.sqrt(moment / 0.1))
    ] * found
    text = "".join(one.text for one in warned(robot, "inertia", contact=("FL",)))
    assert [f'"{leg}_calf" ({math.sqrt(moment / 0.1):.3g} m)' in text for leg in ("FL", "HL")] == [
        found
    ] * 2
    listing = run(capfd, "robots", written(tmp_path, PLACEHOLDER.format(moment), "dog.xml")).out
    assert ("radius of gyration" in listing) == found
    seen = warned(robot, "height", contact=("FL",), posture=KNEE)
    assert [(one.subject, pytest.approx(one.value)) for one in seen] == [("FL", 0.1)]


@pytest.mark.parametrize("name", ["a1", "anymal_b", "g1", "go2", "icub", "solo12", "talos"])
def test_inertias_of_real_robots_fit_into_them(name: str):
    """Also where a sensor's link has a placeholder too small to matter."""
    assert inflated_inertias(known_robot(name)) == ()


def test_without_shapes_a_body_may_be_larger_than_the_distances_between_frames():
    """A pole on a small base, of which no shape is known, is no placeholder; 0.1 kg with 5 or 1000
    kg m² is.
    """
    for moment, found in ((0.1, False), (5.0, True), (1000.0, True)):
        tip = link(
            "tip",
            "0.1",
            f'<inertia ixx="{moment}" ixy="0" ixz="0" iyy="{moment}" iyz="0" izz="0.1"/>',
        )
        assert [name for name, *_ in inflated_inertias(robot_from(arm(tip=tip), ".urdf"))] == [
            "tip"
        ] * found


def test_a_link_without_geometry_names_those_of_its_body_that_have_some():
    """The sole has none of its own, the foot that carries it has."""
    robot = humanoid(FOOT.format("{0}", '<body name="{0}_sole" pos="0 0 -.1"/>'))
    landing = Scene(robot="m", contact=(Contact(frame="left_sole", at="lowest"),))
    refused(
        SceneError,
        ['"left_sole" has no collision geometry', 'of its body, "left_foot" has some'],
        shock_profile,
        landing,
        robot,
    )


# Friction


def test_friction_that_is_not_enough_differs_in_print():
    needed = shock_profile(Scene(robot="go2", contact="FL_foot")).value(
        "friction_needed", "contact"
    )[0]
    found = shock_profile(Scene(robot="go2", contact="FL_foot", friction=(1.0 - 1e-6) * needed))
    (text,) = (str(one) for one in found.health.warnings if "friction" in str(one))
    at_stick, given = map(float, re.findall(r"0\.\d+", text))
    assert 0.0 < at_stick - given < 1e-5


def test_a_contact_that_slides_is_not_told_to_be_left_out():
    """It would be pulled only if it stuck; with friction it is pushed."""
    strike = Strike(strike_angle_deg=-60.0)
    plain, slides = (
        shock_profile(Scene(robot="hyq", contact="lf_foot", strike=strike, friction=friction))
        for friction in (None, 0.3)
    )
    assert [
        "leave it out" in str(one) for one in plain.health.warnings if one.kind != "drives"
    ] == [True]
    assert slides.value("impulse_friction", "contact")[0, 2] > 0.0
    told = [str(one) for one in slides.health.warnings if one.kind != "drives"]
    assert ["it slides, so use the results with friction" in one for one in told] == [True]
