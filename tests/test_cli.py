"""Commands as they are typed: what each option means, and what a run writes."""

import csv
import io
import json
import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from commands import STICK, good, run

import shockpc
import shockpc.show.folder
from shockpc import Contact, Point, Posture, Scene, Strike, read_scene, shock_profile
from shockpc.core.spatial import velocity_at
from shockpc.model.joint_model import Joints
from shockpc.scene import GRAVITY
from shockpc.show.document import to_json
from shockpc.show.files import MANIFEST

DOG = ("dog/dog.urdf.xacro", "--package", "dog_description=dog")
FEET = ("lf_foot", "lh_foot", "rf_foot", "rh_foot")


@pytest.fixture(autouse=True)
def _no_figures(monkeypatch):
    """Drawing them takes longer than all else; other tests look at them."""
    monkeypatch.setattr(shockpc.show.folder, "landing_figure", lambda _: {})


def document(capfd, *words):
    """The JSON document of an analysis."""
    return json.loads(good(capfd, "analyze", *words, "--format", "json"))


def listed(folder):
    """What lies in a folder of results, save the list of its files."""
    return {path.name for path in folder.iterdir()} - {MANIFEST}


# Robots and scenes


def test_a_command_line_is_a_scene_in_python(capfd, here):
    """The same document from options of every kind and from the records of the library."""
    words = "--contact lf_foot --contact-point lowest --restitution 0.2 --posture crouched --set *_hip=30 --set lf_hip=-15"
    words += " --base-rpy 0,15,0 --velocity 0.5,0.1,-1 --angular-velocity 0,2,0 --joint-velocity rf_hip=1 --stance rh_foot"
    words += " --joints geared --armature *_hip=0.01 --lock lh_hip --plane 0,-2,0 --v-in com --pulse half-sine:5ms --range-g 16"
    scene = Scene(
        robot="dog/dog.urdf.xacro",
        packages={"dog_description": "dog"},
        contact=(Contact(frame="lf_foot", at="lowest", restitution=0.2),),
        posture=Posture(reference="crouched", joints_deg={"*_hip": 30.0, "lf_hip": -15.0}, base_rpy_deg=(0.0, 15.0, 0.0)),
        strike=Strike(velocity=(0.5, 0.1, -1.0), angular_velocity=(0.0, 2.0, 0.0), joint_velocities={"rf_hip": 1.0}),
        stance=("rh_foot",),
        joints=Joints(model="geared", armature={"*_hip": 0.01}, locked=("lh_hip",)),
        plane=(0.0, -2.0, 0.0),
        v_in="com",
        pulse="half-sine:5ms",
        range_g=16.0,
    )
    assert good(capfd, "analyze", *DOG, *words.split(), "--format", "json") == to_json([shock_profile(scene)])


def test_robot_by_file_and_by_name(capfd, here):
    out = good(capfd, "analyze", "stick.urdf", "--contact", "foot")
    assert out.startswith(f"robot        {here}/stick.urdf (stick, 2.5 kg, 2 moving bodies)\n")
    out = good(capfd, "analyze", "anymal_b", "--contact", "LF_FOOT", "--posture", "standing")
    assert out.startswith("robot        anymal_b (anymal, 30.48 kg, 13 moving bodies)\n")
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


def test_scene_in_a_file(capfd, here):
    """A robot or a scene is recognised by its content, whatever its name."""
    expected = document(capfd, "stick.urdf", "--contact", "foot")
    (here / "robot").write_text(STICK)
    for name in ("landing.toml", "landing"):
        (here / name).write_text('# a scene\nrobot = "./robot"\n[[contact]]\nframe = "foot"\n')
        assert document(capfd, f"./{name}")["bodies"] == expected["bodies"]
    assert document(capfd, "./robot", "--contact", "foot")["bodies"] == expected["bodies"]


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
    """An exact frame, else links by glob or part of a name; several matches are several landings, A+B is one."""
    assert contacts(document(capfd, *DOG, *words)) == landings


def test_frame_whose_name_holds_a_plus(capfd, here):
    """An exact name is that frame, even if it could be read otherwise."""
    (here / "odd.urdf").write_text(STICK.replace('"foot"', '"left+right"').replace('"ankle"', '"a:b"'))
    found = document(capfd, "odd.urdf", "--contact", "left+right", "--point", "a:b", "--point", "a:b:0,0,0.1")
    assert contacts(found) == [["left+right"]]
    assert [point["frame"] for point in found["points"]] == ["a:b", "a:b:0,0,0.1"]


@pytest.mark.parametrize(
    ("plane", "strike", "up"),
    [
        *((plane, ("--velocity", velocity), 1) for plane in ("xy", "0,0,2") for velocity in ("0.5,-1,0", "0,-1,0")),
        ("xy", (), 2),
        ("xy", ("--speed", "2", "--strike-angle", "0"), 2),
        ("xy", ("--drop-height", "0.1"), 2),
        ("xy", ("--velocity", "0,0,-1"), 2),
    ],
)
def test_sliding_in_a_horizontal_plane(capfd, here, plane, strike, up):
    """With a velocity in that plane, up is world y; with a vertical one, as by default and after a fall, it is world z."""
    (contact,) = document(capfd, *DOG, "--contact", "lf_foot", "--slide", "--plane", plane, *strike)["contacts"]
    assert contact["approach"][up] < 0.0
    assert contact["impulse"].pop(up) > 0.0
    assert contact["impulse"] == [0.0, 0.0]


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
def test_forward_is_world_x_or_world_y(capfd, here, plane, forward):
    """For either sign of the normal: a strike of 30 degrees moves to world x, or to world y in a plane perpendicular to x."""
    strike = ("--plane", plane, "--strike-angle", "30", "--speed", "2")
    found = document(capfd, *DOG, "--contact", "lf_foot", *strike)
    assert found["contacts"][0]["approach"] == pytest.approx([*forward, -math.sqrt(3)], abs=1e-15)


@pytest.mark.parametrize("plane", ["xz", "yz", "xy", "0,-1,0.1", "1,1,1"])
def test_a_fall_is_vertical_in_every_plane(capfd, here, plane):
    """Against world z, also where the plane is inclined or horizontal."""
    for words, speed in ((), 1.0), (("--drop-height", "0.2"), math.sqrt(2 * GRAVITY * 0.2)):
        (contact,) = document(capfd, *DOG, "--contact", "lf_foot", "--plane", plane, *words)["contacts"]
        assert contact["approach"] == pytest.approx([0.0, 0.0, -speed], abs=1e-15)


# Plane


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


def test_formats(capfd, here):
    """One analysis, four formats, on standard output."""
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


def test_csv_reports_warnings_on_standard_error(capfd, here):
    """A spreadsheet has no place for them; each is reported once, however many landings have it."""
    outcome = run(capfd, "analyze", *DOG, "--contact", "*f_foot", "--set", "lh_hip=-90", "--format", "csv")
    assert outcome.code == 0
    assert outcome.out.startswith("contact,body,")
    assert re.fullmatch(r'shockpc: warning: joint "lh_hip" .*4\.06 deg.*\n', outcome.err)


def body_rows(text):
    """The names in the table of bodies."""
    table = text.partition("\nbodies (")[2].partition("\n\n")[0].splitlines()
    return [line.split()[0] for line in table[4:] if not line.startswith("(")]


def test_bodies_by_pattern(capfd, here):
    """Only those that match, in tables and CSV; the JSON document is always complete."""
    words = (*DOG, "--contact", "lf_foot")
    matching = (*words, "--bodies", "?f_*")
    assert body_rows(good(capfd, "analyze", *matching)) == ["lf_leg", "rf_leg"]
    table = good(capfd, "analyze", *matching, "--format", "csv")
    assert [row[1] for row in csv.reader(io.StringIO(table))] == ["body", "lf_leg", "rf_leg"]
    assert document(capfd, *matching, "--out", "out") == document(capfd, *words)
    table = (here / "out/bodies.csv").read_text(encoding="utf-8")
    assert [row[0] for row in csv.reader(io.StringIO(table))] == ["body", "lf_leg", "rf_leg"]


def test_a_link_stands_for_the_body_that_it_is_part_of(capfd, here):
    """HyQ's trunk is fixed to base_link; a name that fits links of several bodies is refused, with these bodies."""
    assert body_rows(good(capfd, "analyze", "hyq", "--contact", "lf_foot", "--bodies", "trunk")) == ["base_link"]
    outcome = run(capfd, "analyze", *DOG, "--contact", "lf_foot", "--bodies", "_foot")
    assert outcome.code == 2
    assert all(f'"{leg}_leg"' in outcome.err for leg in ("lf", "lh", "rf", "rh"))


def explained(capfd, *words):
    """What --explain reports: the times of what ran [ms], and why the rest did not run."""
    plain, outcome = good(capfd, "analyze", *words), run(capfd, "analyze", *words, "--explain")
    assert (outcome.code, outcome.out) == (0, plain)
    ran, _, skipped = outcome.err.partition("what did not run\n")
    title, *lines = ran.splitlines()
    assert title == "what ran"
    times = {name: float(time) for time, name in (re.fullmatch(r" +(\d+\.\d\d) ms  (.+)", line).groups() for line in lines)}
    return times, dict(line.strip().split(": ", 1) for line in skipped.splitlines())


def test_explain(capfd, here):
    """What ran with its time, once for several landings, and what was not needed; the results are the same."""
    times, skipped = explained(capfd, *DOG, "--contact", "*_foot")
    total = times.pop("in all")
    assert total == pytest.approx(sum(times.values()), abs=0.01 * len(times))
    assert list(times)[:2] == ["imports", "robot file"]
    assert list(times)[-1] == "output"
    assert skipped["figure, and matplotlib with it"] == "no --out"
    assert skipped["peak accelerations"] == "no pulse is given"
    _, skipped = explained(capfd, *DOG, "--contact", "lf_foot", "--pulse", "half-sine:5ms", "--out", "out")
    assert not {"figure, and matplotlib with it", "peak accelerations"} & set(skipped)


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


def test_names_of_files_stay_inside_the_folder(capfd, here):
    """A link may have any name; its folder still lies inside, and its name is not too long for a file."""
    (here / "odd.urdf").write_text(
        STICK.replace('"foot"', '"../foot"').replace('"shin"', '".."').replace('"body"', f'"{"x" * 300}"')
    )
    before = {*here.iterdir()}
    good(capfd, "analyze", "odd.urdf", "--contact", "*", "--out", "out/deep")
    assert {*here.iterdir()} - before == {here / "out"}
    assert listed(here / "out/deep") == {"x" * 200, "_.", "_._foot", "summary.csv", "summary.md"}


def test_names_that_differ_in_special_characters_only(capfd, here):
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


def test_a_root_link_called_world_is_fixed(capfd, here):
    """A base of that name is the ground, so it is fixed by default; --base free frees it."""
    (here / "bolted.urdf").write_text(STICK.replace('"body"', '"world"'))
    words = ("bolted.urdf", "--contact", "foot", "--slide", "--set", "knee=30")
    out = good(capfd, "analyze", *words)
    assert "\nposture      neutral, knee = 30 deg\nbase         fixed to the world, because" in out
    default, fixed, free = (document(capfd, *words, *more) for more in ((), ("--base", "fixed"), ("--base", "free")))
    assert default == fixed
    assert (default["scene"]["base"], free["scene"]["base"]) == ("fixed", "free")
    assert default["bodies"][0]["shock_com"] == 0.0
    assert free["bodies"][0]["shock_com"] > 0.0


LANDINGS = [
    ("stick.urdf", "--contact", "foot"),
    ("anymal_b", "--contact", "LF_FOOT", "--strike-angle", "30", "--speed", "2"),
    ("anymal_b", "--contact", "LF_FOOT+RF_FOOT", "--slide", "--base-rpy", "3,-5,10", "--drop-height", "0.1"),
    ("leg", "--contact", "heel", "--xacro", "mass=4", "--base", "planar", "--set", "kn*=-20", "--restitution", "0.3"),
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
    good(capfd, "analyze", "stick.urdf", "--contact", "foot", "--save-scene", "landing.toml")
    good(capfd, "analyze", "landing.toml", "--speed", "3", "--save-scene", "landing.toml", "--force")
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
def test_an_option_replaces_what_the_scene_file_says(capfd, here, words, key, value):
    """One key changes, and no other."""
    (here / "landing.toml").write_text(SCENE)
    good(capfd, "analyze", "landing.toml", "--save-scene", "plain.toml")
    good(capfd, "analyze", "landing.toml", *words.split(), "--save-scene", "typed.toml")
    plain, typed = vars(read_scene(here / "plain.toml")), vars(read_scene(here / "typed.toml"))
    top, _, rest = key.partition(".")
    found = typed[top] if not rest else vars(typed[top])[rest]
    assert found == value
    if isinstance(value, dict):
        assert list(found) == list(value), "later entries take precedence, so their order counts"
    allowed = {top, "base"} if "--base" in words else {top}
    assert {name for name in typed if typed[name] != plain[name]} <= allowed


# Help


def test_help(capfd):
    """Without a word, and for every command: what it does in one sentence."""
    out = good(capfd, "--help")
    assert good(capfd) == out == good(capfd, "-h")
    commands = dict(re.findall(r"^  (\w+) +(\S.*)$", out.partition("\nCommands:\n")[2].partition("\n\n")[0], re.MULTILINE))
    assert set(commands) >= {"analyze", "bench", "check", "paper", "robots", "schema"}
    for command, sentence in commands.items():
        text = good(capfd, command, "-h")
        assert text.startswith(f"Usage: shockpc {command} ")
        assert sentence.removesuffix("...") in " ".join(text.split())


def test_whole_help(capfd, snapshot):
    """Options in groups, which of them may be repeated, examples and exit codes."""
    assert good(capfd, "analyze", "--help") == snapshot


def test_every_option_is_explained_and_declared_once(capfd):
    """An option has a sentence; what several commands take, they take in the same words."""
    options = re.split(r"\n  (?=-)", good(capfd, "analyze", "--help"))[1:]
    assert len(options) > 30
    assert [option for option in options if not re.search(r"\.\s", f"{option}\n")] == []
    shared = good(capfd, "robots", "--help").partition("Robot files:\n")[2].partition("\n\n")[0]
    assert shared
    assert shared in good(capfd, "analyze", "--help")


def test_examples_of_the_help_run(capfd, here):
    examples = re.findall(r"^ +shockpc (analyze .*)$", good(capfd, "analyze", "--help"), re.MULTILINE)
    assert len(examples) == 3
    (here / "robot.urdf").write_text(STICK.replace('"foot"', '"hind_foot"').replace('"knee"', '"hind_knee"'))
    for example in examples:
        assert good(capfd, *shlex.split(example))


def test_version(capfd):
    assert good(capfd, "--version") == f"shockpc {shockpc.__version__}\n"


def test_a_pulse_without_a_sensor_gives_a_warning(capfd):
    """A robot without sensors, and no point given: no peak is computed, and the table says so."""
    words = ("analyze", "solo12", "--contact", "FL_FOOT", "--pulse", "half-sine:2ms")
    assert "warning: a pulse is given, but the robot has no sensor" in good(capfd, *words)
    assert "a pulse is given" not in good(capfd, *words, "--point", "base_link")
