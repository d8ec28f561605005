"""Commands as they are typed: what each option means, and what a run writes."""

import csv
import io
import json
import math
import re
import shlex
import subprocess
import sys
import time
import tomllib

import numpy as np
import pytest
from commands import STICK, document, good, run, vector
from identify_draws import BLOCKS, csv_text, leg
from test_readme import commands, words_of
from test_scene_file import EVERY_KEY, by_key

import shockpc
import shockpc.show.figure.style
import shockpc.show.report
from shockpc import read_scene, shock_profile
from shockpc.cli import progress
from shockpc.cli.app import COMMANDS
from shockpc.cli.options import EVERYBODY
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.studies.analyze.report import document as document_of
from shockpc.text.printed import json_text

pytestmark = pytest.mark.usefixtures("no_figures")

DOG = ("dog/dog.urdf.xacro", "--package", "dog_description=dog")
LEVEL = ("--ground-tolerance", 0.01)
"""In the posture of its file, the dog's front feet are 7.4 mm above its hind feet."""
FEET = ("lf_foot", "lh_foot", "rf_foot", "rh_foot")


def on_a_foot(capfd, *words):
    """The document of the dog landing on its left front foot."""
    return document(capfd, *DOG, "--contact", "lf_foot", *words)


SUMMARY = {"summary.csv", "landings.csv", "summary.md", ".summary.sha256"}
"""Files of several landings."""


def listed(folder):
    """What lies in a folder of results."""
    return {path.name for path in folder.iterdir()}


# Robots and scenes


def test_robots_and_scenes(capfd, here):
    """A file, a name however it is written, or a scene."""
    out = good(capfd, "analyze", "stick.urdf", "--contact", "foot")
    assert out.split("\n\n")[1].startswith(
        f"robot        {here}/stick.urdf (stick, 2.5 kg, 2 moving bodies)\n"
    )
    assert "\nrobot        anymal_b (anymal, 30.48 kg, 13 " in good(
        capfd, "analyze", "ANYmal-B", "--contact", "LF_FOOT"
    )
    expected = document(capfd, "stick.urdf", "--contact", "foot")["tables"]
    (here / "robot").write_text(STICK)
    (here / "landing.toml").write_text(
        '# a scene\nrobot = "./robot"\n[[contact]]\nframe = "foot"\n'
    )
    assert document(capfd, "./landing.toml")["tables"] == expected
    assert document(capfd, "./robot", "--contact", "foot")["tables"] == expected


def test_xacro_with_arguments_and_package(capfd, here, monkeypatch):
    """Four feet match: a case for each, then a summary with the feet as columns."""
    monkeypatch.chdir(here / "dog")
    words = (
        "--xacro",
        "payload:=1.5",
        "--package",
        "dog_description=.",
        "--contact",
        "*_foot",
        "--strike-angle",
        "30",
    )
    out = good(capfd, "analyze", "dog.urdf.xacro", *words, "--all")
    assert out.count("(dog, 7.5 kg, 5 moving bodies, payload:=1.5)\n") == 4
    assert re.findall(r"^contact      (\w+) at ", out, re.MULTILINE) == list(FEET)
    assert (
        out.count(
            "\nvelocity     contact at 1 m/s, 30 deg from the vertical: (0.5, 0, -0.866) m/s\n"
        )
        == 4
    )
    summary = out.partition("\nsummary: ")[2].splitlines()
    assert summary[1].split() == ["shock", "at", *FEET]
    assert [line.split()[0] for line in summary[4:]] == [
        "trunk",
        "lf_leg",
        "lh_leg",
        "rf_leg",
        "rh_leg",
        "at",
    ]
    # The dog is its mirror image: left and right feet do the same to the trunk.
    assert len(set(summary[4].split()[1:])) == 2


# Contacts


def contacts(found):
    """The landings, with + between the contacts of one."""
    return [
        one["tables"]["landing"][0]["contact"]
        for one in (found if isinstance(found, list) else [found])
    ]


CONTACTS = {
    "lf_foot": ["lf_foot"],
    "l?_foot": ["lf_foot", "lh_foot"],
    "lf_foot,rh_foot": ["lf_foot", "rh_foot"],
    "lf_foot,l*_foot": ["lf_foot", "lh_foot"],
    "lf_foot + rh_foot": ["lf_foot+rh_foot"],
    "l*_foot+rh_foot": ["lf_foot+lh_foot+rh_foot"],
    "l*_foot+r*_foot": ["+".join(FEET)],
    "lf_hip": ["lf_hip"],
    "trunk_imu": ["trunk_imu"],
}


@pytest.mark.parametrize("names", CONTACTS)
def test_contacts(capfd, here, names):
    """An exact frame, else a glob of links; several matches are several landings, A+B is one."""
    words = [
        word
        for name in names.split(",")
        for word in ([name] if name.startswith("--") else ["--contact", name])
    ]
    assert contacts(document(capfd, *DOG, *words)) == list(CONTACTS[names])


def test_frame_whose_name_holds_a_plus(capfd, here):
    """An exact name is that frame, even if it could be read otherwise."""
    (here / "odd.urdf").write_text(
        STICK.replace('"foot"', '"left+right"').replace('"ankle"', '"a:b"')
    )
    found = document(
        capfd, "odd.urdf", "--contact", "left+right", "--at", "a:b", "--at", "a:b:0,0,0.1"
    )
    assert contacts(found) == ["left+right"]
    assert [row["point"] for row in found["tables"]["points"]] == ["a:b", "a:b:0,0,0.1"]


@pytest.mark.parametrize(
    ("words", "up"),
    [
        *(
            (f"{plane} --velocity {velocity}", 1)
            for plane in ("xy", "0,0,2")
            for velocity in ("0.5,-1,0", "0,-1,0")
        ),
        *(
            (f"xy {strike}", 2)
            for strike in (
                "",
                "--speed 2 --strike-angle 0",
                "--drop-height 0.1",
                "--velocity 0,0,-1",
            )
        ),
    ],
)
def test_sliding_in_a_horizontal_plane(capfd, here, words, up):
    """With a velocity in that plane, up is world y; with a vertical one, as by default and after a
    fall, it is world z.
    """
    (contact,) = on_a_foot(capfd, "--slide", "--plane", *words.split())["tables"]["contacts"]
    impulse = vector(contact, "impulse")
    assert vector(contact, "approach")[up] < 0.0
    assert impulse.pop(up) > 0.0
    assert impulse == [0.0, 0.0]


HALF = math.sqrt(0.5)
PLANES = [
    *((plane, (1, 0)) for plane in ("xz", "0,-2,0", "0,2,0")),
    *((plane, (0, 1)) for plane in ("yz", "1,0,0", "-1,0,0")),
    ("1,-1,0", (HALF, HALF)),
    ("-1,-1,0", (HALF, -HALF)),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plane", "forward"), [*PLANES, ("xy", None), ("0,-1,0.1", None), ("1,1,1", None)]
)
def test_a_fall_is_vertical_and_forward_is_world_x_or_world_y(capfd, here, plane, forward):
    """For either sign of the normal a strike of 30 degrees moves to x, or to y in a plane across x;
    a fall is against world z.
    """
    landings = {("--drop-height", "0.2"): [0.0, 0.0, -math.sqrt(2 * GRAVITY * 0.2)]}
    if forward:
        landings["--strike-angle", "30", "--speed", "2"] = [*forward, -math.sqrt(3)]
    for words, approach in landings.items():
        (contact,) = on_a_foot(capfd, "--plane", plane, *words)["tables"]["contacts"]
        assert vector(contact, "approach") == pytest.approx(approach, abs=1e-15)


# What is shown


def test_formats(capfd, here):
    """One analysis, four formats, on standard output; warnings of a table in CSV go to standard
    error, each once.
    """
    words = (
        "analyze",
        *DOG,
        "--contact",
        "*f_foot",
        "--set",
        "lh_hip=-90",
        "--ground-tolerance",
        0.1,
    )
    assert good(capfd, *words) == good(capfd, *words, "--format", "table")
    titles = re.findall(r"^## .*$", good(capfd, *words, "--format", "markdown"), re.MULTILINE)
    assert titles == [f"## Shock of dog landing on {foot}_foot" for foot in ("lf", "rf")]
    code, out, err = run(capfd, *words, "--format", "csv")
    assert code == 0
    assert re.fullmatch(r'shockpc: warning: joint "lh_hip": 4\.06 deg.*\n', err)
    documents, rows = document(capfd, *words[1:]), list(csv.DictReader(io.StringIO(out)))
    shocks = [
        (row["contact"], row["body"], row["shock_com"])
        for one in documents
        for row in one["tables"]["bodies"]
    ]
    assert [(row["contact"], row["body"], float(row["shock at CoM [-]"])) for row in rows] == shocks


@pytest.mark.parametrize(
    "words",
    [
        (
            "limits",
            "--joint",
            "lf_hip",
            "--at",
            "trunk_imu",
            "--max",
            "0.5",
            "--range",
            "0:10",
            "--step",
            "5",
        ),
        ("sensitivity", "--at", "trunk_imu"),
        ("place",),
        ("compare", "--change", "mass:trunk=1.1x"),
    ],
)
def test_warnings_of_studies_in_csv(capfd, here, words):
    """They go to standard error, where the table for people has them as well."""
    landing = (words[0], *DOG, "--contact", "lf_foot", "--set", "lh_hip=-90", *words[1:])
    warnings = re.findall(r"^warning.*$", good(capfd, *landing), re.MULTILINE)
    assert any('"lh_hip"' in warning for warning in warnings)
    assert run(capfd, *landing, "--format", "csv").err == "".join(
        f"shockpc: {warning}\n" for warning in warnings
    )


@pytest.mark.parametrize("contact", [(), ("--contact", "lf_foot")])
def test_the_answer_is_short(capfd, here, contact):
    """A landing of a quadruped, or one on each of its feet, is at most 44 lines; all bodies that
    are asked for are shown.
    """
    assert len(good(capfd, "analyze", "hyq", *contact).splitlines()) <= 44
    every = good(capfd, "analyze", "hyq", *contact, "--body", "*")
    assert all(
        re.search(rf"^(CoM of )?{body} ", every, re.MULTILINE)
        for body in ("rh_hipassembly", "rh_lowerleg")
    )


def test_bodies_by_pattern(capfd, here):
    """Only those that match have rows in CSV and in JSON, where all else is complete."""
    words = ("--body", "?f_*", "--out", "out")
    some, every = on_a_foot(capfd, *words), on_a_foot(capfd)
    assert some["tables"].pop("bodies") == [
        row for row in every["tables"].pop("bodies") if row["body"] in ("lf_leg", "rf_leg")
    ]
    assert some == every
    printed = good(
        capfd, "analyze", *DOG, *LEVEL, "--contact", "lf_foot", *words, "--format", "csv"
    )
    assert [row[:2] for row in csv.reader(io.StringIO(printed))] == [
        ["contact", "body"],
        ["lf_foot", "lf_leg"],
        ["lf_foot", "rf_leg"],
    ]
    assert (here / "out/bodies.csv").read_text(encoding="utf-8") == printed


def test_a_link_stands_for_the_body_that_it_is_part_of(capfd, here):
    """HyQ's trunk is fixed to base_link; a glob of links means all their bodies."""
    out = good(capfd, "analyze", "hyq", "--contact", "lf_foot", "--body", "trunk", "--all")
    assert "\nbase_link " in out
    assert "\n(12 bodies not shown, no match for --body)\n" in out
    out = good(
        capfd,
        "analyze",
        *DOG,
        *LEVEL,
        "--contact",
        "lf_foot",
        "--body",
        "*_foot",
        "--format",
        "csv",
    )
    assert [row["body"] for row in csv.DictReader(io.StringIO(out))] == [
        "lf_leg",
        "lh_leg",
        "rf_leg",
        "rh_leg",
    ]


def test_explain(capfd, here):
    """What ran with its time, once for several landings, and what was not needed; the results are
    the same.
    """
    words = ("analyze", *DOG, "--contact", "*_foot")
    code, out, err = run(capfd, *words, "--explain")
    assert (code, out) == (0, good(capfd, *words))
    ran, _, skipped = err.partition("what did not run\n")
    lines = [
        re.fullmatch(r" +(\d+\.\d\d) ms  (.+)", line).groups() for line in ran.splitlines()[1:]
    ]
    *times, total = [float(time) for time, _ in lines]
    assert total == pytest.approx(sum(times), abs=0.01 * len(times))
    names = [name for _, name in lines]
    assert (names[:2], names[-2:]) == (["imports", "robot file"], ["output", "in all"])
    assert "figure, and matplotlib with it: no --out\n" in skipped
    assert "peak accelerations: no pulse is given\n" in skipped
    err = run(capfd, *words, "--explain", "--pulse", "half-sine:5ms", "--out", "out").err
    assert "figure" not in err.partition("what did not run\n")[2]
    assert "peak accelerations: " not in err


# Files


def test_names_of_files_stay_inside_the_folder(capfd, here):
    """A link may have any name; its folder still lies inside, and its name is not too long for a
    file.
    """
    (here / "odd.urdf").write_text(
        STICK.replace('"foot"', '"../foot"')
        .replace('"shin"', '".."')
        .replace('"body"', f'"{"x" * 300}"')
    )
    before = {*here.iterdir()}
    good(capfd, "analyze", "odd.urdf", "--contact", "*", "--out", "out/deep")
    assert {*here.iterdir()} - before == {here / "out"}
    assert listed(here / "out/deep") == {"x" * 200, "_.", "_._foot", *SUMMARY}


def test_a_folder_and_a_scene_for_each_landing(capfd, here):
    """Named after the contact, and numbered where names differ only in case or special characters;
    a summary of all.
    """
    odd = (
        STICK.replace('"foot"', '"a:foot"')
        .replace('"shin"', '"a/foot"')
        .replace('"body"', '"A_FOOT"')
    )
    (here / "odd.urdf").write_text(odd)
    words = ("odd.urdf", "--contact", "*")
    found = document(capfd, *words, "--out", "out", "--save-scene", "landing.toml")
    names, frames = ["A_FOOT", "a_foot-2", "a_foot-3"], ["A_FOOT", "a/foot", "a:foot"]
    assert contacts(found) == frames
    assert listed(here / "out") == {*names, *SUMMARY}
    assert {path.name for path in here.glob("*.toml")} == {f"landing.{name}.toml" for name in names}
    for name, one in zip(names, found, strict=True):
        assert json.loads((here / "out" / name / "profile.json").read_text(encoding="utf-8")) == one
        again = document(capfd, f"landing.{name}.toml")
        # What was chosen for the landing is given in the scene that was saved.
        assert again["unknowns"] == [
            unknown for unknown in one["unknowns"] if unknown["status"] != "chosen"
        ]
        assert {**again, "unknowns": []} == {**one, "unknowns": []}
    summary = list(csv.reader(io.StringIO((here / "out/summary.csv").read_text(encoding="utf-8"))))
    assert summary[0] == ["shock at", *(f"{frame} [-]" for frame in frames)]
    assert [float(x) for x in summary[1][1:]] == [
        one["tables"]["bodies"][0]["shock_com"] for one in found
    ]
    assert good(capfd, "analyze", *words, "--format", "markdown").endswith(
        (here / "out/summary.md").read_text(encoding="utf-8")
    )


def test_landings_beside_others_that_cannot_be_computed_are_given(capfd, here):
    """Where the base rotates backwards the hind feet leave the ground: they are named with the
    reason, and the others computed.
    """
    words = ("analyze", "go2", "--angular-velocity", "0,5,0")
    shown, failed = (
        run(capfd, *words, "--contact", "*_foot", "--save-scene", "go2.toml"),
        ["RL_foot", "RR_foot"],
    )
    assert shown.code == 0
    assert (
        re.findall(r"^not computed: (\w+): .* is leaving the ground", shown.out, re.MULTILINE)
        == failed
    )
    assert "2 of 4 landings could not be computed" in shown.err
    assert {path.name for path in here.glob("go2.*")} == {"go2.FL_foot.toml", "go2.FR_foot.toml"}
    *found, rest = json.loads(run(capfd, *words, "--contact", "*_foot", "--format", "json").out)
    assert contacts(found) == ["FL_foot", "FR_foot"]
    assert found[0] == document(capfd, "go2", "--contact", "FL_foot", *words[2:])
    assert [failure["landing"] for failure in rest["failures"]] == failed
    assert (
        "not computed: RL_foot" in run(capfd, *words, "--contact", "?L_foot", "--format", "csv").err
    )
    assert run(capfd, *words, "--strict").code == 3
    none = run(capfd, *words, "--contact", "R*_foot")
    assert (none.code, none.out) == (2, "")
    assert (
        'shockpc: contact "RR_foot" is leaving' in none.err
        or 'shockpc: contact "RL_foot" is leaving' in none.err
    )


LANDINGS = [
    ("stick.urdf", "--contact", "foot"),
    ("anymal_b", "--contact", "LF_FOOT", "--strike-angle", "30", "--speed", "2"),
    (
        "anymal_b",
        "--contact",
        "LF_FOOT+RF_FOOT",
        "--slide",
        "--base-rpy",
        "3,-5,10",
        "--drop-height",
        "0.1",
    ),
    (
        "leg",
        "--contact",
        "heel",
        "--xacro",
        "mass=4",
        "--base",
        "planar",
        "--set",
        "kn*=-20",
        "--restitution",
        "0.3",
    ),
    (
        *DOG,
        "--contact",
        "lf_foot",
        "--contact-point",
        "lowest",
        "--posture",
        "crouched",
        "--velocity",
        "0.5,0.1,-1",
    ),
    (
        *DOG,
        "--contact",
        "lf_foot",
        "--offset",
        "0,0,-0.02",
        "--at",
        "trunk:0.1,0,0",
        "--plane",
        "0,-1,0.1",
    ),
    (
        *DOG,
        "--contact",
        "lf_foot",
        "--xacro",
        "payload:=1.5",
        "--set",
        "*=7",
        "--set",
        "lf_hip=12.5",
    ),
    (
        *DOG,
        "--contact",
        "lf_foot",
        "--joints",
        "geared",
        "--armature",
        "*=0.1",
        "--lock",
        "rh*",
        "--stance",
        "lh_foot",
    ),
    (
        *DOG,
        "--contact",
        "lf_foot",
        "--v-in",
        "com",
        "--pulse",
        "half-sine:5ms",
        "--range-g",
        "16",
        "--angular-velocity",
        "0,1,0",
    ),
    (
        *DOG,
        "--contact",
        "lf_foot",
        "--joint-velocity",
        "lf_hip=-1",
        "--assemble",
        "*_hip",
        "--lock",
        "lh_hip",
    ),
]


def without_chosen(document):
    """A document without what was chosen for its landing."""
    return document | {
        "unknowns": [one for one in document["unknowns"] if one["status"] != "chosen"]
    }


@pytest.mark.slow
@pytest.mark.parametrize("words", LANDINGS, ids=lambda words: " ".join(words[-4:]))
def test_saved_scene_gives_the_same_bytes(capfd, here, monkeypatch, words):
    """Whatever was typed: the scene that is saved gives the same document, run anywhere and in
    Python, and the same scene.

    What was chosen for the one that was typed is stated in the saved one, and so no longer among
    what is taken for granted.
    """
    (here / "scenes").mkdir()
    typed = good(
        capfd, "analyze", *words, "--format", "json", "--save-scene", "scenes/landing.toml"
    )
    monkeypatch.chdir("/")
    read = json_text(document_of(shock_profile(read_scene(here / "scenes/landing.toml"))))
    again = good(
        capfd,
        "analyze",
        here / "scenes/landing.toml",
        "--format",
        "json",
        "--save-scene",
        here / "scenes/again.toml",
    )
    assert again == read
    assert without_chosen(json.loads(again)) == without_chosen(json.loads(typed))
    assert (here / "scenes/again.toml").read_bytes() == (here / "scenes/landing.toml").read_bytes()


NO_SPEED = {"strike.speed": None, "strike.strike_angle_deg": None}
OPTIONS = {
    "--base free": {"base": "free"},
    "--plane yz --base free": {"base": "free", "plane": "yz"},
    "--plane 0,-2,0": {"plane": [0, -2, 0]},
    "--xacro payload:=2": {"xacro.payload": "2"},
    "--posture crouched": {"posture.reference": "crouched"},
    "--base-rpy 0,5,0": {"posture.base_rpy_deg": [0, 5, 0]},
    "--set lf_hip=5": {"posture.joints_deg.lf_hip": 5},
    "--set lf_hip=5 --set rh_*=5": {"posture.joints_deg.lf_hip": 5, "posture.joints_deg.rh_*": 5},
    "--speed 3": {"strike.speed": 3},
    "--strike-angle 10": {"strike.strike_angle_deg": 10},
    "--velocity 0,0,-1": {**NO_SPEED, "strike.velocity": [0, 0, -1]},
    "--drop-height 1": {**NO_SPEED, "strike.drop_height": 1},
    "--angular-velocity 0,1,0": {"strike.angular_velocity": [0, 1, 0]},
    "--v-in contact": {"v_in": "contact"},
    "--offset 0,0,0": {"contact.0.offset": [0, 0, 0]},
    "--restitution 0.5": {"contact.0.restitution": 0.5, "contact.1.restitution": 0.5},
    "--contact-point lowest": {"contact.0.at": "lowest"},
    "--at lh_foot": {"point.2.frame": "lh_foot", "point.2.offset": [0, 0, 0]},
    "--stance lh_foot": {"stance": ["lh_foot"]},
    "--assemble lh_hip": {"assemble": ["lh_hip"]},
    "--joints geared": {"joints.model": "geared"},
    "--armature rf_hip=0.2": {"joints.armature.rf_hip": 0.2},
    "--lock rh_hip": {"joints.locked": ["lh_hip", "rh_hip"]},
    "--pulse rectangle:1ms": {"pulse": "rectangle:1ms"},
    "--range-g 8": {"range_g": 8},
    "--imu-bandwidth 50Hz:2": {"imu_bandwidth": "50Hz:2"},
}
"""What each option changes in the scene of EVERY_KEY; None where it takes a key away."""


@pytest.mark.slow
def test_an_option_replaces_what_the_scene_file_says(capfd, here):
    """The keys of the saved scene that each option changes, and no others; later joints take
    precedence, so they come last.
    """
    (here / "landing.toml").write_text(
        re.sub(r'model = "geared"\n|\[\[closure\]\](.|\n)*?(?=\[\[contact)', "", EVERY_KEY)
    )

    def saved(words):
        good(
            capfd,
            "analyze",
            "landing.toml",
            *words.split(),
            "--save-scene",
            "typed.toml",
            "--force",
        )
        return by_key(tomllib.loads((here / "typed.toml").read_text()))

    plain = saved("")
    for words, expected in OPTIONS.items():
        found = saved(words)
        assert {
            key: found.get(key) for key in plain | found if plain.get(key) != found.get(key)
        } == expected, words
    assert [key for key in saved("--set lf_hip=5 --set rh_*=5") if "joints_deg" in key][
        -1
    ].endswith("rh_*")
    other, contact = saved("--contact rf_foot"), re.compile(r"contact\.")
    assert {k: x for k, x in other.items() if not contact.match(k)} == {
        k: x for k, x in plain.items() if not contact.match(k)
    }
    given = {
        key.removeprefix("contact.0."): value for key, value in other.items() if contact.match(key)
    }
    assert given.pop("restitution_along") == "normal"
    plain_contact = {"kind": "point", "directions": ["x", "y", "z"], "restitution": 0}
    assert given == {"frame": "rf_foot", "offset": [0, 0, 0], "at": "frame"} | plain_contact


# Help


def test_help(capfd, monkeypatch):
    """Without a word, and for every command: what it does in one sentence, on a terminal of 80
    columns.
    """
    monkeypatch.setenv("COLUMNS", "80")
    out = good(capfd, "--help")
    assert (
        good(capfd)
        == out
        == good(capfd, "-h")
        == good(capfd, "help")
        == good(capfd, "help", "help")
    )
    assert good(capfd, "--version") == f"shockpc {shockpc.__version__}\n"
    cited = good(capfd, "--cite")
    assert re.findall(r"^@\w+\{(\w+),$", cited, re.MULTILINE) == ["driessen2021shock", "shockpc"]
    assert f"version = {{{shockpc.__version__}}}" in cited
    commands = dict(
        re.findall(r"^  (\w+) +(\S.*\.)$", out.partition("\nBegin:\n")[2], re.MULTILINE)
    )
    assert set(commands) == set(COMMANDS)
    for command, sentence in commands.items():
        text = good(capfd, command, "-h")
        assert all(len(line) <= 80 for line in text.splitlines())
        assert " by default" not in text
        assert re.match(rf"Usage: shockpc {command} [^{{}}]*\n\n  {re.escape(sentence)}\n", text)
        assert "Arguments:" not in text.partition("Robot files:")[2]


@pytest.mark.parametrize("command", COMMANDS)
def test_help_fits_two_screens(capfd, monkeypatch, command):
    """The help of a command is at most 80 lines of 100 columns; with --help-all it has all of the
    options of a landing.
    """
    monkeypatch.setenv("COLUMNS", "100")
    text = good(capfd, command, "--help")
    assert len(text.splitlines()) <= 80
    if "--help-all" in text:
        assert "--cluster" not in text
        assert "--assemble" in good(capfd, command, "--help-all")


def test_the_short_help_of_an_analysis(capfd, monkeypatch):
    """At most 40 lines of options on a terminal of 80 columns, with defaults, and which of them
    repeat.
    """
    monkeypatch.setenv("COLUMNS", "80")
    text = good(capfd, "analyze", "--help").partition("Landing (")[2].partition("  Exit codes")[0]
    assert sum(line.startswith("  ") for line in text.splitlines()) <= 40
    assert re.search(r"--contact .*May\s+be\s+repeated\.\s+--set", text, re.DOTALL)
    assert re.search(r"--speed .*\[default: 1\]\s+--strike", text, re.DOTALL)
    listed = re.findall(r"^  --([\w-]+)", text.partition("Output:")[0], re.MULTILINE)
    assert tuple(name.replace("-", "_") for name in listed) == EVERYBODY


def test_options_of_a_command_come_before_the_shared_ones(capfd):
    """Shared options are in the same groups in every command, and the help says which options may
    be repeated.
    """
    text = good(capfd, "place", "--help")
    headings = re.findall(r"^(\w.*):$", text, re.MULTILINE)
    assert headings[:3] == ["Arguments", "Landings", "Where a sensor may be"]
    of_limits = re.findall(r"^(\w.*):$", good(capfd, "limits", "--help"), re.MULTILINE)
    assert headings[3:] == of_limits[2:]
    everything = good(capfd, "place", "--help-all")
    assert (
        good(capfd, "robots", "--help").partition("Robot files:\n")[2].partition("\n\n")[0]
        in everything
    )
    assert set(re.findall(r"^  (--[\w-]+)", text, re.MULTILINE)) < set(
        re.findall(r"^  (--[\w-]+)", everything, re.MULTILINE)
    )
    assert re.search(
        r"--lock JOINT +Locked joints, which keep "
        r"the\s+rate\s+that\s+they\s+have\.\s+May\s+be\s+repeated\.",
        everything,
    )


@pytest.mark.parametrize(
    ("words", "refused", "others"),
    [
        (
            "fall go2",
            [
                "--contact",
                "--stance",
                "--normal",
                "--speed",
                "--strike-angle",
                "--drop-height",
                "--joint-velocity",
            ],
            {"--set", "--friction", "--lock", "--pulse"},
        ),
        (
            "place go2",
            [
                "--contact-stiffness",
                "--contact-damping",
                "--stop-stiffness",
                "--motors",
                "--torque",
                "--flex",
                "--part",
            ],
            {"--set", "--friction", "--lock", "--pulse"},
        ),
        (
            "identify log.csv go2 --unknown friction=0:1",
            ["--at", "--part", "--pulse", "--range-g", "--v-in", "--ground-tolerance"],
            {"--set", "--contact", "--friction", "--lock", "--drives"},
        ),
        (
            "touchdowns walk.csv go2",
            [
                "--speed",
                "--drop-height",
                "--joint-velocity",
                "--friction",
                "--joints",
                "--lock",
                "--pulse",
                "--stance",
                "--at",
            ],
            {"--set", "--contact", "--contact-point", "--offset", "--normal", "--base"},
        ),
    ],
)
def test_an_option_that_a_command_always_refuses_is_not_its_option(capfd, words, refused, others):
    """Others of a landing are.

    What a scene file gives is refused in words, which tests of the studies see to, or not used.
    """
    command, *inputs = words.split()
    offered = set(re.findall(r"^  (--[\w-]+)", good(capfd, command, "--help-all"), re.MULTILINE))
    assert not offered & set(refused)
    assert others <= offered
    for option in refused:
        outcome = run(capfd, command, *inputs, option, "1")
        assert (outcome.code, outcome.out) == (2, "")
        assert f"no such option: {option}" in outcome.err


def test_an_option_has_one_unit_in_all_commands(capfd):
    """Each takes a value in every command that has it, or in none, and of the same unit."""
    meanings: dict[str, set[tuple[bool, str]]] = {}
    for command in COMMANDS:
        text = good(
            capfd,
            command,
            *(["--help-all"] if "--help-all" in good(capfd, command, "--help") else ["--help"]),
        )
        lines = re.sub(r"\n {4,}", "   ", text)
        for name, value, sentence in re.findall(
            r"^  (--[\w-]+)(?: (\S.*?))?   *(\S.*)$", lines, re.MULTILINE
        ):
            units = re.findall(r"\[([^\[\]]*)\]\.", re.sub(r" +", " ", sentence))
            unit = re.sub(r"(, |^)at (most|least) .*", "", units[-1]) if units else ""
            meanings.setdefault(name, set()).add((bool(value), unit))
    assert len(meanings) > 100
    assert {name: of for name, of in meanings.items() if len(of) > 1} == {}


def without_folder(words):
    """The words of a command but for where it writes."""
    return words[: words.index("--out")] if "--out" in words else words


ON_PAGES = [without_folder(words_of(typed.line)) for typed in commands()]


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_examples_of_the_help_run(capfd, here, command):
    """Every help has one to three, above its options; those that a page shows as well run as its
    commands.
    """
    (here / "robot.urdf").write_text(
        STICK.replace('"foot"', '"hind_foot"').replace('"knee"', '"hind_knee"')
    )
    (here / "budgets.toml").write_text(
        '[[case]]\nname = "a"\nrobot = "hyq"\n[[case.contact]]\nframe = "lf_foot"\n'
        '[[budget]]\nat = "trunk_imu"\nmetric = "shock"\nmax = 9\n'
    )
    (here / "log.csv").write_text("LF_KFE,vz\n-0.8,-1\n")
    samples = "".join(f"{k / 1000},0.5,0,0.4,-0.8,0\n" for k in range(50))
    (here / "walk.csv").write_text(f"time,z,LF_HAA,LF_HFE,LF_KFE,force\n{samples}")
    if command == "identify":
        (here / "drops.csv").write_text(csv_text(leg(np.random.default_rng(0), 6, here)))
        (here / "leg.toml").write_text(
            'robot = "leg.urdf"\n[[contact]]\nframe = "foot"\ndirections = ["x", "z"]\n'
        )
        (here / "blocks.urdf").write_text(BLOCKS.read_text())
        (here / "tosses.csv").write_text(
            "\n".join(BLOCKS.with_name("elbow_landings.csv").read_text().splitlines()[:9]) + "\n"
        )
    shown = good(capfd, command, "--help").partition("Examples:")[2].replace("\\\n", " ")
    examples = re.findall(r"^ +shockpc (.*)$", shown, re.MULTILINE)
    assert 1 <= len(examples) <= 3
    for example in examples:
        words = shlex.split(example.partition(">")[0])
        assert words[0] == command
        assert without_folder(words) in ON_PAGES or good(capfd, *words)


@pytest.mark.slow
def test_docstrings_can_be_left_out():
    """Python without docstrings and assertions prints the same table and the same help."""
    for words in (["analyze", "beam", "--contact", "pivot"], ["analyze", "--help"]):
        done = [
            subprocess.run(
                [sys.executable, *optimised, "-m", "shockpc", *words],
                capture_output=True,
                text=True,
                check=True,
            )
            for optimised in ([], ["-OO"])
        ]
        assert done[0].stdout == done[1].stdout != ""


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            "sweep go2 --contact FL_foot --vary speed=1,2 --drives none --joints rigid",
            "no joint has a spring, so nothing changes",
        ),
        (
            "sweep go2 --contact FL_foot --vary speed=1,2 --restitution-along directions",
            '"FL_foot" is along its directions, but no',
        ),
        (
            "recorded log.csv go2 --contact FL_foot --restitution-along directions",
            '"FL_foot" is along its directions, but no',
        ),
        (
            "analyze go2 --contact FL_foot --restitution-along directions --all",
            '"FL_foot" is along its directions, but no',
        ),
        (
            "sweep go2 --contact FL_foot --vary speed=1,2 --assemble FL_calf_joint",
            '"FL_calf_joint" may move to close loops, but',
        ),
        ("place go2 --contact FL_foot --at FR_calf", 'no place on base, so left out: "FR_calf"'),
    ],
)
def test_what_changes_nothing_in_a_landing_is_said(capfd, here, words, text):
    """It is no mistake, as where designs or landings are compared, of which others have a spring or
    a restitution.
    """
    (here / "log.csv").write_text("vz\n-1\n-2\n")
    assert text in " ".join(good(capfd, *words.split()).split())


def test_a_pulse_without_a_sensor_gives_a_warning(capfd):
    """A robot without sensors, and no point given: no peak is computed, and the table says so."""
    words = ("analyze", "solo12", "--contact", "FL_FOOT", "--pulse", "half-sine:2ms")
    assert "warning: a pulse is given, but there is no sensor" in good(capfd, *words)
    assert "a pulse is given" not in good(capfd, *words, "--at", "base_link")


@pytest.mark.parametrize(("slow", "shown"), [(0.0, "\r\033[Kreading …\r\033[K"), (60.0, "")])
def test_a_stage_that_takes_long_is_named_on_a_terminal(slow, shown, monkeypatch):
    """The line is gone when the stage ends; a short stage writes nothing."""
    terminal = io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(progress, "SLOW", slow)
    monkeypatch.setattr("sys.stderr", terminal)
    with progress.shown_trace().stage("reading"):
        time.sleep(0.2)
    assert terminal.getvalue() == shown


@pytest.mark.parametrize(
    ("words", "missing"),
    [(("--contact-stiffness", "1e5"), "--out"), (("--out", "out"), "--contact-stiffness")],
)
def test_a_spectrum_that_would_not_be_drawn_is_refused(capfd, here, words, missing):
    ended = run(capfd, "analyze", "go2", "--contact", "FL_foot", "--spectrum", *words)
    assert ended.code != 0
    assert re.search(f"give {missing}[^;]* too", ended.err)
