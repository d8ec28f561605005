"""Commands as they are typed: what each option means, and what a run leaves behind."""

import csv
import io
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from commands import STICK, Outcome, dog_in, good, run

import shockpc.show.folder
from shockpc import Contact, Point, Posture, Scene, Strike, read_scene, shock_profile
from shockpc.core.spatial import velocity_at
from shockpc.model.joint_model import Joints
from shockpc.scene import GRAVITY
from shockpc.show.document import to_json
from shockpc.show.files import MANIFEST

DOG = ("dog/dog.urdf.xacro", "--package", "dog_description=dog")
FEET = ("lf_foot", "lh_foot", "rf_foot", "rh_foot")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder with a stick, as robot.urdf, and the dog's package in it; figures are not drawn."""
    folder = tmp_path.resolve()
    monkeypatch.chdir(folder)
    (folder / "robot.urdf").write_text(STICK)
    dog_in(folder)
    monkeypatch.setattr(shockpc.show.folder, "landing_figure", lambda _: {})
    return folder


def document(capfd, *words):
    """The JSON document of an analysis."""
    return json.loads(good(capfd, "analyze", *words, "--format", "json"))


def listed(folder):
    """What lies in a folder of results, save the list of its files."""
    return {path.name for path in folder.iterdir()} - {MANIFEST}


def computed(**scene):
    """The JSON text of the dog's profile, by way of Python."""
    robot = {"robot": "dog/dog.urdf.xacro", "packages": {"dog_description": "dog"}}
    return to_json([shock_profile(Scene(**robot, **scene))])


# The five commands of the first page


def test_any_robot_file(capfd, here):
    out = good(capfd, "analyze", "robot.urdf", "--contact", "foot")
    assert out.startswith(
        f"robot        {here}/robot.urdf (stick, 2.5 kg, 2 moving bodies)\nposture      neutral\nbase         free; "
    )
    assert "\ncontact      foot at (0.000, 0.000, -0.400) m, sticks\n" in out


def test_robot_by_name(capfd):
    out = good(capfd, "analyze", "anymal_b", "--contact", "LF_FOOT", "--posture", "standing")
    assert out.startswith("robot        anymal_b (anymal, 30.48 kg, 13 moving bodies)\nposture      standing\nbase         free; ")
    assert out == good(capfd, "analyze", "ANYmal-B", "--contact", "LF_FOOT")


def test_xacro_with_arguments_and_package(capfd, here, monkeypatch):
    """Four feet match: a case for each, then a summary with the feet as columns."""
    monkeypatch.chdir(here / "dog")
    words = ("--xacro", "payload:=1.5", "--package", "dog_description=.", "--contact", "*_foot", "--strike-angle", "30")
    out = good(capfd, "analyze", "dog.urdf.xacro", *words)
    assert out.count("(dog, 7.5 kg, 5 moving bodies, payload:=1.5)\n") == 4
    assert re.findall(r"^contact      (\w+) at ", out, re.MULTILINE) == list(FEET)
    assert out.count("\nstrike       1 m/s, 30 deg from the vertical: velocity (0.5, 0, -0.866) m/s\n") == 4
    summary = out.partition("\nsummary: ")[2].splitlines()
    assert summary[1].split() == ["shock", "at", *FEET]
    assert [line.split()[0] for line in summary[3:]] == ["trunk", "lf_leg", "lh_leg", "rf_leg", "rh_leg", "at"]
    # The dog is its own mirror image: left and right feet do the same to the trunk.
    assert len(set(summary[3].split()[1:])) == 2


def test_landing_on_two_feet_with_files(capfd, here):
    words = ("--contact", "lf_foot+rf_foot", "--set", "*_kfe_joint=-60", "--base-rpy", "0,15,0", "--out", "out/")
    out = good(capfd, "analyze", "hyq", *words)
    assert "standing, *_kfe_joint = -60 deg, base at roll 0, pitch 15, yaw 0 deg\n" in out
    assert re.search(r"^contact      lf_foot at \(.*\) m, sticks; rf_foot at \(.*\) m, sticks$", out, re.MULTILINE)
    assert listed(here / "out") == {*("profile.json", "bodies.csv", "points.csv", "contacts.csv", "report.md")}


def test_scene_in_a_file(capfd, here):
    (here / "landing.toml").write_text('robot = "robot.urdf"\n[[contact]]\nframe = "foot"\n')
    assert good(capfd, "analyze", "landing.toml") == good(capfd, "analyze", "robot.urdf", "--contact", "foot")


def test_kinds_are_told_by_content(capfd, here):
    """A robot or a scene is what it holds, whatever it is called."""
    (here / "robot").write_text(STICK)
    (here / "landing").write_text('# a scene\nrobot = "./robot"\n[[contact]]\nframe = "foot"\n')
    expected = document(capfd, "robot.urdf", "--contact", "foot")["bodies"]
    assert document(capfd, "./robot", "--contact", "foot")["bodies"] == expected
    assert document(capfd, "./landing")["bodies"] == expected


# Contacts


def contacts(found):
    return [[contact["frame"] for contact in one["contacts"]] for one in (found if isinstance(found, list) else [found])]


@pytest.mark.parametrize(
    ("words", "landings"),
    [
        (("--contact", "lf_foot"), [["lf_foot"]]),
        (("--contact", "foot"), [[foot] for foot in FEET]),
        (("--contact", "L?_FOOT"), [["lf_foot"], ["lh_foot"]]),
        (("--contact", "lf_foot", "--contact", "rh_foot"), [["lf_foot"], ["rh_foot"]]),
        (("--contact", "lf_foot", "--contact", "l*_foot"), [["lf_foot"], ["lh_foot"]]),
        (("--contact", "lf_foot+rh_foot"), [["lf_foot", "rh_foot"]]),
        (("--contact", "lf_foot + rh_foot"), [["lf_foot", "rh_foot"]]),
        (("--contact", "l*_foot+rh_foot"), [["lf_foot", "lh_foot", "rh_foot"]]),
        (("--contact", "*_foot", "--together"), [list(FEET)]),
        (("--contact", "lf_foot", "--contact", "rf_foot", "--together"), [["lf_foot", "rf_foot"]]),
        (("--contact", "lf_hip"), [["lf_hip"]]),
        (("--contact", "trunk_imu"), [["trunk_imu"]]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_contacts(capfd, here, words, landings):
    """An exact frame, else links by glob or part of a name; several matches are several cases, A+B is one landing."""
    assert contacts(document(capfd, *DOG, *words)) == landings


def test_together_is_plus(capfd, here):
    both = ("--contact", "lf_foot", "--contact", "rf_foot", "--together")
    assert good(capfd, "analyze", *DOG, *both) == good(capfd, "analyze", *DOG, "--contact", "lf_foot+rf_foot")


def test_frame_whose_name_holds_a_plus(capfd, here):
    """An exact name is that frame, even if it could be read otherwise."""
    (here / "odd.urdf").write_text(STICK.replace('"foot"', '"left+right"').replace('"ankle"', '"a:b"'))
    found = document(capfd, "odd.urdf", "--contact", "left+right", "--point", "a:b", "--point", "a:b:0,0,0.1")
    assert contacts(found) == [["left+right"]]
    assert [point["frame"] for point in found["points"]] == ["a:b", "a:b:0,0,0.1"]


def test_offset_moves_the_contact(capfd, here):
    """In the frame's own axes."""
    plain, moved = (document(capfd, *DOG, "--contact", "lf_foot", "--offset", offset) for offset in ("0,0,0", "0.01,0,-0.02"))
    leg = next(body for body in plain["bodies"] if body["body"] == "lf_leg")
    shift = np.subtract(moved["contacts"][0]["point"], plain["contacts"][0]["point"])
    assert shift == pytest.approx(np.array(leg["placement"]["rotation"]) @ [0.01, 0.0, -0.02], abs=1e-15)


def test_lowest_point(capfd, here):
    """A round foot of 20 mm strikes 20 mm below its centre, however the leg stands; --contact-point frame undoes it."""
    words = (*DOG, "--contact", "lf_foot")
    at_frame, lowest, undone = (
        document(capfd, *words, *more) for more in ((), ("--contact-point", "lowest"), ("--contact-point", "frame"))
    )
    assert np.subtract(lowest["contacts"][0]["point"], at_frame["contacts"][0]["point"]) == pytest.approx([0, 0, -0.02], abs=1e-15)
    assert undone == at_frame


def test_sliding_contact(capfd, here):
    """Without friction there is an impulse along the normal alone."""
    found = document(capfd, *DOG, "--contact", "lf_foot", "--slide", "--strike-angle", "30")
    assert found["contacts"][0]["impulse"][:2] == [0.0, 0.0]
    assert found["contacts"][0]["friction_needed"] == 0.0
    assert found["health"]["rows"] == 1


@pytest.mark.parametrize("plane", ["xy", "0,0,2"])
@pytest.mark.parametrize("velocity", ["0.5,-1,0", "0,-1,0"])
def test_sliding_in_a_plane_seen_from_above(capfd, here, plane, velocity):
    """Struck within it, the ground is the plane's own: up is world y."""
    found = document(capfd, *DOG, "--contact", "lf_foot", "--slide", "--plane", plane, "--velocity", velocity)
    impulse = found["contacts"][0]["impulse"]
    assert impulse[1] > 0.0
    assert (impulse[0], impulse[2]) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("strike", "speed"),
    [
        ((), 1.0),
        (("--speed", "2", "--strike-angle", "0"), 2.0),
        (("--drop-height", "0.1"), math.sqrt(2 * GRAVITY * 0.1)),
        (("--velocity", "0,0,-1"), 1.0),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_sliding_out_of_a_plane_seen_from_above(capfd, here, strike, speed):
    """Struck from above, as it is by default and after a fall, up is world z as ever."""
    found = document(capfd, *DOG, "--contact", "lf_foot", "--slide", "--plane", "xy", *strike)
    (contact,) = found["contacts"]
    assert contact["approach"] == pytest.approx([0.0, 0.0, -speed], abs=1e-15)
    assert contact["impulse"][:2] == [0.0, 0.0]
    assert contact["impulse"][2] > 0.0


@pytest.mark.parametrize(
    ("plane", "forward"),
    [
        ("xz", (1, 0)),
        ("0,-2,0", (1, 0)),
        ("0,2,0", (1, 0)),
        ("yz", (0, 1)),
        ("1,0,0", (0, 1)),
        ("-1,0,0", (0, 1)),
        ("1,-1,0", (math.sqrt(0.5), math.sqrt(0.5))),
        ("-1,-1,0", (math.sqrt(0.5), -math.sqrt(0.5))),
    ],
)
def test_forward_is_where_the_world_s_axes_point(capfd, here, plane, forward):
    """Whichever way the normal points: a strike of 30 degrees moves to world x, or to world y in a plane across x."""
    strike = ("--plane", plane, "--strike-angle", "30", "--speed", "2")
    found = document(capfd, *DOG, "--contact", "lf_foot", *strike)
    assert found["contacts"][0]["approach"] == pytest.approx([*forward, -math.sqrt(3)], abs=1e-15)


@pytest.mark.parametrize("plane", ["xz", "yz", "xy", "0,-1,0.1", "1,1,1"])
def test_a_fall_goes_down_in_every_plane(capfd, here, plane):
    """Against world z, also where the plane leans or is seen from above."""
    words = (*DOG, "--contact", "lf_foot", "--plane", plane)
    assert document(capfd, *words)["contacts"][0]["approach"] == pytest.approx([0.0, 0.0, -1.0], abs=1e-15)
    fallen = document(capfd, *words, "--drop-height", "0.2")["contacts"][0]["approach"]
    assert fallen == pytest.approx([0.0, 0.0, -math.sqrt(2 * GRAVITY * 0.2)], abs=1e-15)


def test_restitution(capfd, here):
    """Everything grows by 1 + e."""
    plain, bouncing = (document(capfd, *DOG, "--contact", "lf_foot", "--restitution", e) for e in ("0", "0.5"))
    for one, other in zip(plain["bodies"], bouncing["bodies"], strict=True):
        assert other["shock_com"] == pytest.approx(1.5 * one["shock_com"], rel=1e-12)


# Posture and base


def test_posture_by_name(capfd, here):
    """Standing by default, for the dog has such a posture; the header always says which."""
    default, standing, crouched, neutral = (
        document(capfd, *DOG, "--contact", "lf_foot", *more)
        for more in ((), ("--posture", "standing"), ("--posture", "crouched"), ("--posture", "neutral"))
    )
    assert default == standing
    assert [one["scene"]["posture"]["reference"] for one in (crouched, neutral)] == ["crouched", "neutral"]
    assert len({json.dumps(one["bodies"]) for one in (default, crouched, neutral)}) == 3


def test_postures_from_another_file(capfd, here):
    (here / "other.srdf").write_text((here / "dog/dog.srdf").read_text().replace('"crouched"', '"folded"'))
    found = document(capfd, *DOG, "--contact", "lf_foot", "--srdf", "other.srdf", "--posture", "folded")
    assert found["scene"]["srdf"] == str(here / "other.srdf")
    assert found["bodies"] == document(capfd, *DOG, "--contact", "lf_foot", "--posture", "crouched")["bodies"]


def test_joints_are_set_in_degrees(capfd, here):
    """By name or glob, the later word over the earlier."""
    words = (*DOG, "--contact", "lf_foot", "--set", "*_hip=30", "--set", "lf_hip=-15", "--format", "json")
    angles = {"*_hip": 30.0, "lf_hip": -15.0}
    assert good(capfd, "analyze", *words) == computed(contact=(Contact(frame="lf_foot"),), posture=Posture(joints_deg=angles))
    leg = json.loads(good(capfd, "analyze", *words))["bodies"][1]
    assert leg["body"] == "lf_leg"
    assert math.degrees(math.atan2(leg["placement"]["rotation"][0][2], leg["placement"]["rotation"][0][0])) == pytest.approx(-15)


def test_joint_outside_its_limits_is_a_warning(capfd, here):
    out = good(capfd, "analyze", *DOG, "--contact", "lf_foot", "--set", "lf_hip=90")
    assert (
        '\nwarning: joint "lf_hip" stands 4.06 deg outside its limits [-85.9, 85.9]; the profile is computed there all the same\n'
        in out
    )


def test_base_is_turned(capfd, here):
    """Roll, pitch and yaw in degrees about the world's axes."""
    trunk = document(capfd, *DOG, "--contact", "lf_foot", "--base-rpy", "0,15,0")["bodies"][0]
    c, s = math.cos(math.radians(15)), math.sin(math.radians(15))
    assert np.allclose(trunk["placement"]["rotation"], [[c, 0, s], [0, 1, 0], [-s, 0, c]], atol=1e-15)


def test_base_moves_as_it_may(capfd, here):
    """Free in space, in the plane only, or not at all."""
    words = (*DOG, "--contact", "lf_foot", "--slide", "--base")
    free, planar, fixed = (document(capfd, *words, kind) for kind in ("free", "planar", "fixed"))
    assert free == document(capfd, *words[:-1])
    assert np.linalg.norm(free["bodies"][0]["delta_omega"]) > 0
    trunk = planar["bodies"][0]
    assert np.abs([trunk["delta_omega"][0], trunk["delta_omega"][2], trunk["delta_v"][1]]).max() < 1e-12
    assert abs(trunk["delta_omega"][1]) > 0.1
    assert fixed["bodies"][0]["shock_com"] == 0.0


# Strike and plane


@pytest.mark.parametrize(
    ("words", "strike", "velocity"),
    [
        ("", {}, (0, 0, -1)),
        ("--speed 2", {"speed": 2.0}, (0, 0, -2)),
        ("--strike-angle 30", {"strike_angle_deg": 30.0}, (0.5, 0, -math.sqrt(0.75))),
        ("--strike-angle=-30 --speed 2", {"strike_angle_deg": -30.0, "speed": 2.0}, (-1, 0, -math.sqrt(3))),
        ("--velocity 0.5,0.1,-1", {"velocity": (0.5, 0.1, -1.0)}, (0.5, 0.1, -1)),
        ("--drop-height 0.2", {"drop_height": 0.2}, (0, 0, -math.sqrt(2 * 9.80665 * 0.2))),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_strikes(capfd, here, words, strike, velocity):
    """Angle and speed in the plane, a velocity, or a free fall: v = √(2 g h)."""
    words = (*DOG, "--contact", "lf_foot", *words.split())
    assert good(capfd, "analyze", *words, "--format", "json") == computed(
        contact=(Contact(frame="lf_foot"),), strike=Strike(**strike)
    )
    found = document(capfd, *words)
    assert found["contacts"][0]["approach"] == pytest.approx(velocity, abs=1e-15)
    assert found["v_in"] == pytest.approx(np.linalg.norm(velocity), rel=1e-15)
    assert GRAVITY == 9.80665


def test_motion_before_the_strike(capfd, here):
    """Rotation and joint rates come on top of the velocity."""
    words = ("--velocity", "0,0,-1", "--angular-velocity", "0,2,0", "--joint-velocity", "*_hip=1", "--joint-velocity", "lf_hip=-1")
    strike = Strike(velocity=(0.0, 0.0, -1.0), angular_velocity=(0.0, 2.0, 0.0), joint_velocities={"*_hip": 1.0, "lf_hip": -1.0})
    expected = computed(contact=(Contact(frame="lf_foot"),), strike=strike)
    assert good(capfd, "analyze", *DOG, "--contact", "lf_foot", *words, "--format", "json") == expected


def test_drives(capfd, here):
    """What the drives do, for all joints or by pattern."""
    words = ("--joints", "geared", "--armature", "*_hip=0.01", "--armature", "lf_hip=0.02", "--lock", "lh_hip")
    joints = Joints(model="geared", armature={"*_hip": 0.01, "lf_hip": 0.02}, locked=("lh_hip",))
    expected = computed(contact=(Contact(frame="lf_foot"),), joints=joints)
    assert good(capfd, "analyze", *DOG, "--contact", "lf_foot", *words, "--format", "json") == expected


def test_stance_and_sensors(capfd, here):
    words = ("--stance", "rh_foot", "--v-in", "com", "--pulse", "half-sine:5ms", "--range-g", "16")
    scene = {"stance": ("rh_foot",), "v_in": "com", "pulse": "half-sine:5ms", "range_g": 16.0}
    expected = computed(contact=(Contact(frame="lf_foot"),), **scene)
    assert good(capfd, "analyze", *DOG, "--contact", "lf_foot", *words, "--format", "json") == expected


@pytest.mark.parametrize(
    ("plane", "same", "strike"),
    [
        ("xz", "0,-2,0", ("--strike-angle", "10")),
        ("yz", "1,0,0", ("--strike-angle", "10")),
        ("xy", "0,0,0.5", ("--velocity", "0.2,-1,0")),
    ],
)
def test_planes(capfd, here, plane, same, strike):
    """A plane by its name is the one across its normal, of any length."""
    words = (*DOG, "--contact", "lf_foot", *strike, "--plane")
    named, across = document(capfd, *words, plane), document(capfd, *words, same)
    assert named["scene"]["plane"] == plane
    assert across["scene"]["plane"] == [float(x) for x in same.split(",")]
    assert named["bodies"] == across["bodies"]


# What is shown


def test_points(capfd, here):
    """Every sensor that the robot names, then every point asked for: Δv in the frame's own axes."""
    found = document(capfd, *DOG, "--contact", "lf_foot", "--point", "lh_leg", "--point", "trunk:0.1,0,0.05")
    assert [(point["frame"], point["body"]) for point in found["points"]] == [
        ("trunk_imu", "trunk"),
        ("lh_leg", "lh_leg"),
        ("trunk:0.1,0,0.05", "trunk"),
    ]
    trunk, point = found["bodies"][0], found["points"][2]
    expected = velocity_at(np.array(trunk["delta_omega"]), np.array(trunk["delta_v"]), np.array([0.1, 0.0, 0.05]))
    assert point["delta_v"] == pytest.approx(expected, abs=1e-15)
    assert point["shock"] == pytest.approx(np.linalg.norm(expected) / found["v_in"])


def body_rows(text):
    """The names in the table of bodies."""
    table = text.partition("\nbodies (")[2].partition("\n\n")[0].splitlines()
    return [line.split()[0] for line in table[4:] if not line.startswith("(")]


def test_bodies_by_pattern(capfd, here):
    """Only those that fit, in tables and CSV; the JSON document is always whole."""
    words = (*DOG, "--contact", "lf_foot", "--bodies", "?f_*")
    out = good(capfd, "analyze", *words)
    assert body_rows(out) == ["lf_leg", "rf_leg"]
    assert "\n(3 bodies not shown, no match for ?f_*)\n" in out
    table = good(capfd, "analyze", *words, "--format", "csv")
    assert [row[1] for row in csv.reader(io.StringIO(table))] == ["body", "lf_leg", "rf_leg"]
    assert document(capfd, *words) == document(capfd, *words[:-2])
    out = good(capfd, "analyze", *DOG, "--contact", "lf_foot", "--bodies", "leg")
    assert "\n(1 body not shown, no match for leg)\n" in out


def test_unmoved_bodies_are_folded(capfd, here):
    """On a fixed base the other legs stay where they are: one line says so."""
    out = good(capfd, "analyze", *DOG, "--contact", "lf_foot", "--slide", "--base", "fixed")
    assert body_rows(out) == ["lf_leg"]
    assert "\n(4 bodies not shown, not moved by the impact: trunk, lh_leg, rf_leg, rh_leg)\n" in out


def test_formats(capfd, here):
    """One analysis, four ways to carry it; all on standard output, and nothing else there."""
    words = ("analyze", *DOG, "--contact", "*f_foot")
    table, markdown, table_again = (good(capfd, *words, *more) for more in ((), ("--format", "markdown"), ("--format", "table")))
    assert table == table_again
    assert re.findall(r"^## .*$", markdown, re.MULTILINE) == [
        "## Shock of dog landing on lf_foot",
        "## Shock of dog landing on rf_foot",
    ]
    rows = list(csv.DictReader(io.StringIO(good(capfd, *words, "--format", "csv"))))
    documents = document(capfd, *words[1:])
    shocks = [(one["contacts"][0]["frame"], body["body"], body["shock_com"]) for one in documents for body in one["bodies"]]
    assert [(row["contact"], row["body"], float(row["shock at CoM [-]"])) for row in rows] == shocks


def test_csv_leaves_warnings_to_standard_error(capfd, here):
    """A spreadsheet has no place for them; each is said once, however many landings it holds for."""
    words = ("analyze", *DOG, "--contact", "*f_foot", "--set", "lh_hip=-90", "--format", "csv")
    outcome = run(capfd, *words)
    assert outcome._replace(out="") == Outcome(
        0,
        "",
        'shockpc: warning: joint "lh_hip" stands 4.06 deg outside its limits [-85.9, 85.9]; '
        "the profile is computed there all the same\n",
    )
    assert outcome.out.startswith("contact,body,")


STAGES = [
    "imports",
    "robot file",
    "posture, inertia, Jacobians and rows",
    "steps 1 and 2: impulsive equation of motion, bodies",
    "check in maximal coordinates",
    "step 3: centres and radii of percussion",
    "shock over geometry",
    "sensors, points and contacts",
    "loads, energy and the bracket of drives",
    "doubts about what follows from the jumps",
    "output",
]


def explained(capfd, *words):
    """What --explain says: stages, and what was left out."""
    plain, outcome = good(capfd, "analyze", *words), run(capfd, "analyze", *words, "--explain")
    assert (outcome.code, outcome.out) == (0, plain)
    title, *lines = outcome.err.splitlines()
    assert title == "what this run did:"
    stages = [match.group(1) for line in lines if (match := re.fullmatch(r" +\d+\.\d\d ms  (.+)", line))]
    left_out = dict(line.removeprefix("  left out     ").split(": ", 1) for line in lines[len(stages) :])
    return stages, left_out


def test_explain(capfd, here):
    """Stages with their cost and what the scene did not need, on standard error; the results are the same."""
    stages, left_out = explained(capfd, *DOG, "--contact", "lf_foot")
    assert stages == STAGES
    assert left_out == {
        "closure rows and assembly": "nothing closes a loop",
        "reduction to free velocities (Eq. 7)": "every joint velocity is free, save where the bracket locks the drives",
        "reflected inertia": "no drive has any",
        "stance rows": "no foot stands already",
        "peak accelerations": "no pulse is given",
        "sliding": "every contact sticks",
        "figure, and matplotlib with it": "no --out",
    }


def test_explain_adds_up(capfd, here):
    """Several landings share their stages; what is used is not called left out."""
    words = ("--contact", "*_foot", "--base", "planar", "--slide", "--armature", "*=0.01", "--pulse", "half-sine:5ms", "--out", "o")
    stages, left_out = explained(capfd, *DOG, *words)
    assert stages == STAGES
    assert set(left_out) == {"closure rows and assembly", "stance rows"}


def test_explain_tells_what_a_robot_has_none_of(capfd, here):
    """No sensor, no point: said. One direction given three times does not stick."""
    (here / "one.toml").write_text('robot = "leg"\n\n[[contact]]\nframe = "lower_leg"\ndirections = ["z", "z", "z"]\n')
    _, left_out = explained(capfd, "one.toml")
    assert left_out["sensors and points"] == "the robot has no sensor, and no point is asked for"
    assert "sliding" not in left_out


# Files


def test_folder_of_results(capfd, here):
    """profile.json is what standard output would carry; the report is the Markdown, with the figure in it."""
    words = ("analyze", *DOG, "--contact", "lf_foot", "--strike-angle", "20")
    out = good(capfd, *words, "--out", "results/today", "--format", "json")
    folder = here / "results/today"
    assert (folder / "profile.json").read_text(encoding="utf-8") == out
    report = (folder / "report.md").read_text(encoding="utf-8")
    assert report.replace("![shock profile of dog](shock.svg)\n\n", "") == good(capfd, *words, "--format", "markdown")
    assert report.count("](shock.svg)") == 1


def test_folder_for_each_landing(capfd, here):
    """Several landings: a folder for each, and a summary."""
    words = ("analyze", *DOG, "--contact", "*f_foot")
    found = json.loads(good(capfd, *words, "--out", "out", "--format", "json"))
    assert listed(here / "out") == {"lf_foot", "rf_foot", "summary.csv", "summary.md"}
    for one in found:
        folder = here / "out" / one["contacts"][0]["frame"]
        assert json.loads((folder / "profile.json").read_text(encoding="utf-8")) == one
    summary = list(csv.reader(io.StringIO((here / "out/summary.csv").read_text(encoding="utf-8"))))
    assert summary[0] == ["shock at", "lf_foot", "rf_foot"]
    assert [float(x) for x in summary[1][1:]] == [one["bodies"][0]["shock_com"] for one in found]
    markdown = (here / "out/summary.md").read_text(encoding="utf-8")
    assert good(capfd, *words, "--format", "markdown").endswith(markdown)


def test_names_that_would_lead_out_of_the_folder(capfd, here):
    """A link may be called anything; its folder still lies inside."""
    odd = STICK.replace('"foot"', '"../foot"').replace('"shin"', '".."')
    (here / "odd.urdf").write_text(odd)
    before = {*here.iterdir()}
    good(capfd, "analyze", "odd.urdf", "--contact", "*", "--out", "out/deep")
    assert {*here.iterdir()} - before == {here / "out"}
    assert listed(here / "out/deep") == {"body", "_.", "_._foot", "summary.csv", "summary.md"}


def test_names_that_differ_in_odd_signs_alone(capfd, here):
    """Two contacts never share a folder or a scene file: the later one is numbered, whatever the case of its letters."""
    odd = STICK.replace('"foot"', '"a:foot"').replace('"shin"', '"a/foot"').replace('"body"', '"A_FOOT"')
    (here / "odd.urdf").write_text(odd)
    found = document(capfd, "odd.urdf", "--contact", "*", "--out", "out", "--save-scene", "landing.toml")
    frames = [one["contacts"][0]["frame"] for one in found]
    assert frames == ["A_FOOT", "a/foot", "a:foot"]
    names = ["A_FOOT", "a_foot-2", "a_foot-3"]
    assert listed(here / "out") == {*names, "summary.csv", "summary.md"}
    assert {path.name for path in here.glob("*.toml")} == {f"landing.{name}.toml" for name in names}
    for name, frame, one in zip(names, frames, found, strict=True):
        assert json.loads((here / "out" / name / "profile.json").read_text(encoding="utf-8")) == one
        assert read_scene(here / f"landing.{name}.toml").contact == (Contact(frame=frame),)
    summary = list(csv.reader(io.StringIO((here / "out/summary.csv").read_text(encoding="utf-8"))))
    assert summary[0] == ["shock at", *frames]


def test_pattern_of_bodies_in_a_folder(capfd, here):
    """--bodies narrows the tables of --out, report and CSV, and leaves the document whole."""
    words = (*DOG, "--contact", "lf_foot")
    good(capfd, "analyze", *words, "--bodies", "?f_*", "--out", "out")
    table = list(csv.reader(io.StringIO((here / "out/bodies.csv").read_text(encoding="utf-8"))))
    assert [row[0] for row in table] == ["body", "lf_leg", "rf_leg"]
    assert json.loads((here / "out/profile.json").read_text(encoding="utf-8")) == document(capfd, *words)


def test_a_root_link_called_world_is_bolted_down(capfd, here):
    """A base of that name is the ground, so it is fixed by default; it may still be freed."""
    (here / "bolted.urdf").write_text(STICK.replace('"body"', '"world"'))
    words = ("bolted.urdf", "--contact", "foot", "--slide", "--set", "knee=30")
    out = good(capfd, "analyze", *words)
    assert "\nposture      neutral, knee = 30 deg\nbase         fixed to the world; --base free releases it\n" in out
    default, fixed, free = (document(capfd, *words, *more) for more in ((), ("--base", "fixed"), ("--base", "free")))
    assert default == fixed
    assert (default["scene"]["base"], free["scene"]["base"]) == ("fixed", "free")
    assert default["bodies"][0]["shock_com"] == 0.0
    assert free["bodies"][0]["shock_com"] > 0.0
    other = document(capfd, "robot.urdf", *words[1:])
    assert other["scene"]["base"] == "free"
    assert [body["shock_com"] for body in other["bodies"]] == [body["shock_com"] for body in free["bodies"]]


LANDINGS = [
    ("robot.urdf", "--contact", "foot"),
    ("anymal_b", "--contact", "LF_FOOT", "--strike-angle", "30", "--speed", "2"),
    ("anymal_b", "--contact", "LF_FOOT+RF_FOOT", "--slide", "--base-rpy", "3,-5,10", "--drop-height", "0.1"),
    (
        "leg",
        "--contact",
        "heel",
        "--xacro",
        "mass=4",
        "--base",
        "planar",
        "--plane",
        "xz",
        "--set",
        "kn*=-20",
        "--restitution",
        "0.3",
    ),
    (*DOG, "--contact", "lf_foot", "--contact-point", "lowest", "--posture", "crouched", "--velocity", "0.5,0.1,-1"),
    (*DOG, "--contact", "lf_foot", "--offset", "0,0,-0.02", "--point", "trunk:0.1,0,0", "--plane", "0,-1,0.1"),
    (*DOG, "--contact", "lf_foot", "--xacro", "payload:=1.5", "--srdf", "dog/dog.srdf", "--set", "*=7", "--set", "lf_hip=12.5"),
    (*DOG, "--contact", "lf_foot", "--joints", "geared", "--armature", "*=0.1", "--lock", "rh*", "--stance", "lh_foot"),
    (*DOG, "--contact", "lf_foot", "--v-in", "com", "--pulse", "half-sine:5ms", "--range-g", "16", "--angular-velocity", "0,1,0"),
    (*DOG, "--contact", "lf_foot", "--joint-velocity", "lf_hip=-1", "--assemble", "*_hip"),
]


@pytest.mark.parametrize("words", LANDINGS, ids=lambda words: " ".join(words[-4:]))
def test_saved_scene_gives_the_same_bytes(capfd, here, monkeypatch, words):
    """Whatever was typed: the scene that is saved, run anywhere, writes the same document, and saves the same scene."""
    (here / "scenes").mkdir()
    typed = good(capfd, "analyze", *words, "--format", "json", "--save-scene", "scenes/landing.toml")
    monkeypatch.chdir("/")
    again = good(capfd, "analyze", here / "scenes/landing.toml", "--format", "json", "--save-scene", here / "scenes/again.toml")
    assert again == typed
    assert (here / "scenes/again.toml").read_bytes() == (here / "scenes/landing.toml").read_bytes()


def test_saved_scene_can_move_with_its_robot(capfd, here):
    """Paths are relative to the scene: a folder that holds both may go anywhere."""
    good(capfd, "analyze", *DOG, "--contact", "lf_foot", "--save-scene", "landing.toml")
    assert str(here) not in (here / "landing.toml").read_text()
    before = document(capfd, "landing.toml")["bodies"]
    (here / "elsewhere").mkdir()
    for name in ("dog", "landing.toml"):
        (here / name).rename(here / "elsewhere" / name)
    assert document(capfd, "elsewhere/landing.toml")["bodies"] == before


def test_saved_scenes_of_several_landings(capfd, here):
    """A file for each, named after its contact."""
    typed = document(capfd, *DOG, "--contact", "*f_foot", "--save-scene", "landing.toml")
    assert {path.name for path in here.glob("*.toml")} == {"landing.lf_foot.toml", "landing.rf_foot.toml"}
    assert [document(capfd, f"landing.{foot}.toml") for foot in ("lf_foot", "rf_foot")] == typed


def test_scene_saved_over_itself(capfd, here):
    """What is typed can be written back into the scene."""
    good(capfd, "analyze", "robot.urdf", "--contact", "foot", "--save-scene", "landing.toml")
    good(capfd, "analyze", "landing.toml", "--speed", "3", "--save-scene", "landing.toml")
    assert read_scene(Path("landing.toml")).strike == Strike(speed=3.0, strike_angle_deg=0.0)


SCENE = """
robot = "dog/dog.urdf.xacro"
base = "planar"
plane = "xz"
pulse = "half-sine:5ms"
assemble = ["*"]
stance = ["rh_foot"]
[packages]
dog_description = "dog"
[xacro]
payload = "1.5"
[posture]
reference = "crouched"
base_rpy_deg = [0, 15, 0]
joints = { lf_hip = 0.1 }
joints_deg = { rf_hip = 10, lh_hip = 20 }
[strike]
speed = 2.0
strike_angle_deg = 30
[joints]
armature = { "*" = 0.1 }
locked = ["rh_hip"]
[[contact]]
frame = "lf_foot"
offset = [0, 0, -0.02]
[[point]]
frame = "trunk"
"""


@pytest.mark.parametrize(
    ("words", "key", "value"),
    [
        ("--base free", "base", "free"),
        ("--plane yz --base free", "plane", "yz"),
        ("--plane 0,-2,0", "plane", (0.0, -2.0, 0.0)),
        ("--xacro payload:=2", "xacro", {"payload": "2"}),
        ("--posture standing", "posture.reference", "standing"),
        ("--base-rpy 0,5,0", "posture.base_rpy_deg", (0.0, 5.0, 0.0)),
        ("--set lf_hip=5", "posture.joints_deg", {"rf_hip": 10.0, "lh_hip": 20.0, "lf_hip": 5.0}),
        ("--set rf_hip=5", "posture.joints_deg", {"lh_hip": 20.0, "rf_hip": 5.0}),
        ("--speed 3", "strike", Strike(speed=3.0, strike_angle_deg=30.0)),
        ("--strike-angle 10", "strike", Strike(speed=2.0, strike_angle_deg=10.0)),
        ("--velocity 0,0,-1", "strike", Strike(velocity=(0.0, 0.0, -1.0))),
        ("--drop-height 1", "strike", Strike(drop_height=1.0)),
        ("--angular-velocity 0,1,0", "strike", Strike(speed=2.0, strike_angle_deg=30.0, angular_velocity=(0.0, 1.0, 0.0))),
        ("--contact rf_foot", "contact", (Contact(frame="rf_foot"),)),
        ("--offset 0,0,0", "contact", (Contact(frame="lf_foot"),)),
        ("--restitution 0.5", "contact", (Contact(frame="lf_foot", offset=(0, 0, -0.02), restitution=0.5),)),
        ("--contact-point lowest", "contact", (Contact(frame="lf_foot", offset=(0, 0, -0.02), at="lowest"),)),
        ("--point lh_foot", "point", (Point(frame="trunk"), Point(frame="lh_foot"))),
        ("--stance lh_foot", "stance", ("lh_foot",)),
        ("--assemble lh_hip", "assemble", ("lh_hip",)),
        ("--joints geared", "joints.model", "geared"),
        ("--armature lf_hip=0.2", "joints.armature", {"*": 0.1, "lf_hip": 0.2}),
        ("--lock lh_hip", "joints.locked", ("rh_hip", "lh_hip")),
        ("--v-in com", "v_in", "com"),
        ("--pulse rectangle:1ms", "pulse", "rectangle:1ms"),
        ("--range-g 8", "range_g", 8.0),
    ],
)
def test_typed_words_go_over_the_file(capfd, here, words, key, value):
    """One key changes, and no other."""
    (here / "landing.toml").write_text(SCENE)
    good(capfd, "analyze", "landing.toml", "--save-scene", "plain.toml")
    good(capfd, "analyze", "landing.toml", *words.split(), "--save-scene", "typed.toml")
    plain, typed = vars(read_scene(here / "plain.toml")), vars(read_scene(here / "typed.toml"))
    top, _, rest = key.partition(".")
    found = typed[top] if not rest else vars(typed[top])[rest]
    assert found == value
    if isinstance(value, dict):
        assert list(found) == list(value), "later words go over earlier ones, so their order counts"
    allowed = {top, "base"} if "--base" in words else {top}
    assert {name for name in typed if typed[name] != plain[name]} <= allowed


# Help


def test_help(capfd):
    """Without a word, and for every command: one plain sentence each."""
    out = good(capfd, "--help")
    assert good(capfd) == out == good(capfd, "-h")
    commands = dict(re.findall(r"^  (\w+) +(\S.*)$", out.partition("\nCommands:\n")[2], re.MULTILINE))
    assert (
        commands.items()
        >= {
            "analyze": "Compute the shock of a landing on every body of a robot.",
            "robots": "List the robots known by name, or check and show one.",
            "schema": "Print the JSON Schema of scene files, for editors.",
        }.items()
    )
    for command, sentence in commands.items():
        text = good(capfd, command, "-h")
        assert text.startswith(f"Usage: shockpc {command} ")
        assert sentence in " ".join(text.split())


def test_every_option_is_explained(capfd):
    """No option without a sentence."""
    options = re.split(r"\n  (?=-)", good(capfd, "analyze", "--help"))[1:]
    assert len(options) > 30
    assert [option for option in options if not re.search(r"\.(\s+\[default:\s+\w+\])?\s*$", option)] == []


def test_a_pulse_that_nothing_feels_is_warned_of(capfd):
    """A robot without sensors, and no point asked for: no peak is computed, and the table says so."""
    words = ("analyze", "solo12", "--contact", "FL_FOOT", "--pulse", "half-sine:2ms")
    assert "warning: a pulse is given, but the robot has no sensor" in good(capfd, *words)
    assert "a pulse is given" not in good(capfd, *words, "--point", "base_link")
