"""What a user can get wrong: one message on standard error, its exit code, and no file left behind.

Each case names what its message has to contain; the whole messages are in the snapshots.
"""

import errno
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from commands import STICK, Outcome, environment, good, python, run
from robot_texts import LIMIT, floating, joint, link, mjcf, urdf

import shockpc.profile

SHOCKPC = (sys.executable, "-m", "shockpc")
LANDING = ("analyze", "stick.urdf", "--contact", "foot")


def refusal(capfd, here, *words, code=2):
    """The message of a command that has to fail with this code, print nothing else and change no file."""
    before = sorted(here.rglob("*"))
    outcome = run(capfd, *words)
    assert outcome._replace(err="") == Outcome(code, "", "")
    assert sorted(here.rglob("*")) == before
    assert outcome.err.startswith("shockpc: ")
    assert outcome.err.count("\n") == 1
    return outcome.err.removeprefix("shockpc: ").replace(str(here), "HERE").rstrip("\n")


def contains(message, *parts):
    """Whether a message contains all these names and numbers."""
    missing = [part for part in parts if part not in message]
    assert missing == [], message
    return True


def by_command(cases):
    """Cases as parameters: a command line, and what its message has to contain."""
    return [pytest.param(shlex.split(line), parts, id=line) for line, parts in cases.items()]


# Robot files


FILES = {
    "empty.urdf": "",
    "blank.urdf": " \n\t\n",
    "broken.urdf": "<robot name='r'>\n  <link name='a'>\n</robot>\n",
    "letter.urdf": "Dear robot,\n",
    "world.sdf": "<sdf version='1.6'/>",
    "page.html": "<html><body>Not found</body></html>",
    "any.xml": "<note/>",
    "macros.urdf.xacro": (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="leg" params=""/></robot>'
    ),
    "nan.urdf": STICK.replace('mass value="2"', 'mass value="nan"'),
    "negative.urdf": STICK.replace('mass value="0.5"', 'mass value="-0.5"'),
    "inf.urdf": STICK.replace('ixx="0.02"', 'ixx="inf"'),
    "massless.urdf": STICK.replace('mass value="2"', 'mass value="0"').replace('mass value="0.5"', 'mass value="0"'),
    "entity.urdf": f'<!DOCTYPE robot [<!ENTITY m "2">]>{STICK.partition("?>")[2]}',
    "twice.urdf": STICK.replace("</joint>", '<mimic joint="a"/><mimic joint="b"/></joint>', 1),
    "gapped.urdf": STICK.replace('parent link="body"', 'parent link="bdy"'),
    "light.urdf": urdf(link("body"), link("shin", mass="1e-19"), joint("knee", "body", "shin", more=LIMIT)),
    "heavy.urdf": urdf(link("body"), link("shin", mass="1e300"), joint("knee", "body", "shin", more=LIMIT)),
}

ROBOTS = {
    "missing.urdf": ('"missing.urdf"', "shockpc robots"),
    "away/robot": ('"away/robot"', "shockpc robots"),
    "dog": ('no robot "dog"', "shockpc robots"),
    "anymal": ('no robot "anymal"', '"anymal_c"', '"anymal_b"', "shockpc robots"),
    "./dog": ('"HERE/dog" is a folder',),
    "''": ("empty",),
    "'~nobody-of-that-name/robot.urdf'": ("~nobody-of-that-name",),
    "x" * 300: ("255 bytes",),
    "x" * 300 + ".urdf": ("255 bytes",),
    "empty.urdf": ("empty.urdf", "empty"),
    "blank.urdf": ("blank.urdf", "empty"),
    "broken.urdf": ("broken.urdf", "line 3"),
    "letter.urdf": ("letter.urdf", "line 1"),
    "world.sdf": ("world.sdf", "SDF"),
    "page.html": ("page.html", "web page"),
    "any.xml": ("any.xml", "<note>"),
    "macros.urdf.xacro": ("macros.urdf.xacro", "<link>"),
    "nan.urdf": ("nan.urdf", '"body"', "nan"),
    "inf.urdf": ("inf.urdf", '"body"', "ixx", "inf"),
    "negative.urdf": ("negative.urdf", '"shin"', "-0.5"),
    "massless.urdf": ("massless.urdf", "mass"),
    "entity.urdf": ("entity.urdf", "DOCTYPE"),
    "twice.urdf": ("twice.urdf", '"knee"', "<mimic>"),
    "gapped.urdf": ("gapped.urdf", '"knee"', '"bdy"'),
    "light.urdf": ("light.urdf", '"shin"', "1e-19"),
    "heavy.urdf": ("heavy.urdf", '"shin"', "1e+300"),
}


@pytest.mark.parametrize("command", ["analyze", "robots"])
@pytest.mark.parametrize(("words", "parts"), by_command(ROBOTS))
def test_robot_files(capfd, here, command, words, parts):
    """A file that holds no robot is refused by both commands that read one."""
    (name,) = words
    if name in FILES:
        (here / name).write_text(FILES[name])
    assert contains(refusal(capfd, here, command, name, *(("--contact", "shin") if command == "analyze" else ())), *parts)


def test_model_that_cannot_be_solved(capfd, here):
    """Moving bodies without mass give no result, and are named."""
    message = refusal(capfd, here, "analyze", "romeo_laas_small", "--contact", "l_sole", code=3)
    assert contains(message, '"l_gripper"', '"r_gripper"', '"RomeoH37"', "--lock")


def test_strike_that_the_mechanism_cannot_meet(capfd, here):
    """A stick on a fixed base cannot move along itself: the contact and the direction are named."""
    assert contains(refusal(capfd, here, *LANDING, "--base", "fixed"), '"foot"', "(0 0 1)", "base")


def test_fixed_base_cannot_be_freed(capfd, here):
    arm = (
        '<mujoco model="arm"><worldbody><body name="arm"><joint name="j" axis="0 1 0"/>'
        '<geom name="g" type="box" size="0.2 0.02 0.02" mass="1"/></body></worldbody></mujoco>'
    )
    (here / "arm.xml").write_text(arm)
    message = refusal(capfd, here, "analyze", "arm.xml", "--contact", "arm", "--base", "free")
    assert contains(message, '"arm"', "fixed", "<freejoint/>")


@pytest.mark.parametrize("scene", [False, True])
def test_srdf_of_an_mjcf(capfd, here, scene):
    """Postures that nothing would read are refused, typed or in a scene."""
    (here / "dog.xml").write_text(mjcf(floating()))
    (here / "landing.toml").write_text('robot = "dog.xml"\nsrdf = "dog/dog.srdf"\n[[contact]]\nframe = "base"\n')
    words = ("landing.toml",) if scene else ("dog.xml", "--contact", "base", "--srdf", "dog/dog.srdf")
    assert contains(refusal(capfd, here, "analyze", *words), "dog.xml", "dog.srdf", "<keyframe>")


# Names and values


FRAMES = ('"body"', '"shin"', '"foot"', '"root_joint"', '"knee"', '"ankle"', "shockpc robots HERE/stick.urdf")

WITHOUT_FOOT = {
    "": ("no contact is defined", '"stick"', "--contact", '"foot"'),
    "--contact wheel": ('"wheel"', *FRAMES),
    "--contact fot": ('"fot"', 'nearest: "foot"'),
    "--contact *_paw": ('"*_paw"', *FRAMES),
    "--contact foot+": ("--contact", '"foot+"', "A+B"),
    "--contact foot+foot": ("--contact", '"foot+foot"', "twice"),
    "--contact ''": ("--contact", '""'),
}

WITH_FOOT = {
    "--point nose": ('"nose"', '"knee"'),
    "--posture sitting": ('"sitting"', '"neutral"'),
    "--set hip=3": ('"hip"', '"knee"'),
    "--set root_joint=3": ('"root_joint"', '"knee"'),
    "--lock hip": ('"hip"', '"knee"'),
    "--stance sole": ('"sole"', *FRAMES),
    "--bodies shnk": ('"shnk"', '"shin"'),
    "--xacro payload:=2": ("stick.urdf", "--xacro payload"),
    "--srdf no.srdf": ("no.srdf",),
    "--srdf stick.urdf": ("stick.urdf", "SRDF"),
    "--srdf ''": ("--srdf", "empty"),
    "--package dog=nowhere": ('"dog"', '"nowhere"', "--package dog=DIR"),
    "--package dog=~nobody-of-that-name": ("--package", "~nobody-of-that-name"),
    "--package dog": ("--package", '"dog"', "NAME=DIR"),
    "--xacro payload": ("--xacro", '"payload"', "NAME:=VALUE"),
    # Velocity before the impact
    "--base fixed --angular-velocity 0,2,0": ("base is fixed", "angular velocity"),
    "--base planar --angular-velocity 1,3,0": ("base is planar", "(0, -1, 0)", "1 rad/s"),
    "--angular-velocity 1e300,0,0": ("angular_velocity[0]", "1e+300", "1e+09"),
    "--joint-velocity knee=1e200": ("joint_velocities.knee", "1e+200", "1e+09"),
    "--strike-angle 90": ('"foot"', "90 deg", "no impact"),
    "--strike-angle 120": ('"foot"', "0.5 m/s", "120 deg", "no impact"),
    "--strike-angle=-135 --speed 2": ('"foot"', "1.4 m/s", "-135 deg", "no impact"),
    "--velocity 0,0,0.31": ('"foot"', "0.31 m/s", "no impact"),
    "--velocity 0,0,0": ('"foot"', "0 m/s", "no impact"),
    "--velocity 0,-1": ("--velocity", '"0,-1"', "0.5,0,-1"),
    "--velocity 0,0,down": ("--velocity", '"down"', "finite number"),
    "--velocity 0,0,-1e200": ("1e+200 m/s", "1e-09", "1e+09"),
    "--speed nan": ("--speed", '"nan"', "finite number"),
    "--speed 0": ("0 m/s", "above zero"),
    "--speed=-1": ("-1 m/s", "above zero"),
    "--speed 1e308": ("1e+308 m/s", "1e-09", "1e+09"),
    "--speed 1e-300": ("1e-300 m/s", "1e-09", "1e+09"),
    "--drop-height 0": ("0 m", "above zero"),
    "--drop-height 1e308": ("m/s", "1e-09", "1e+09"),
    "--drop-height 1e999": ("--drop-height", '"1e999"', "finite number"),
    "--plane xy --strike-angle 10": ("strike angle", "velocity"),
    "--plane 0,0,-2 --strike-angle=-0.5": ("strike angle", "velocity"),
    "--plane xy --strike-angle 181": ("181 deg", "-180", "180"),
    "--velocity 0,0,-1 --speed 2": ("two ways",),
    "--velocity 0,0,-1 --drop-height 1": ("two ways",),
    "--drop-height 1 --strike-angle 10": ("two ways",),
    # Contact, posture, joints
    "--restitution 1.5": ('"foot"', "1.5", "0", "1"),
    "--restitution=-0.1": ('"foot"', "-0.1", "0", "1"),
    "--offset 0,0": ("--offset", '"0,0"', "0,0,-0.02"),
    "--contact-point lowest": ('"foot"', "collision geometry", "offset"),
    "--base-rpy 15": ("--base-rpy", '"15"', "0,15,0"),
    "--set knee": ("--set", '"knee"', "JOINT=VALUE", "'*_knee=-60'"),
    "--set knee=": ("--set", '"knee="', "JOINT=VALUE"),
    "--set =30": ("--set", '"=30"', "JOINT=VALUE"),
    "--set knee=bent": ("--set", "knee", '"bent"', "finite number"),
    "--joint-velocity knee": ("--joint-velocity", '"knee"', "JOINT=RATE"),
    "--angular-velocity 1": ("--angular-velocity", '"1"', "0,3,0"),
    "--armature knee": ("--armature", '"knee"', "JOINT=INERTIA"),
    "--armature knee=-1": ('"knee"', "-1", "above zero"),
    "--armature root_joint=1": ('"root_joint"', '"stick"', "no drive"),
    "--joints locked --armature knee=0.1": ('"knee"', "locked", "armature"),
    "--lock knee --base fixed": ('"stick"', "fixed", "no joint is free"),
    # What is computed
    "--plane zx": ("--plane", '"zx"', "xz, yz, xy"),
    "--plane 0,1": ("--plane", '"0,1"', "0,-1,0"),
    "--plane 0,0,0": ("plane", "normal", "xz, yz, xy"),
    "--point body:1,2": ("--point body", '"1,2"', "0,0,0.1"),
    "--point body:": ("--point body", '""'),
    "--point body:1,2,x": ("--point body", '"x"', "finite number"),
    "--pulse square:5ms": ("pulse", '"square"', "half-sine, saw-tooth, haversine, rectangle", "half-sine:5ms"),
    "--range-g 16": ("range", "pulse", "half-sine:5ms"),
    "--range-g=-1": ("-1 g", "above zero"),
}

USAGE = {
    "analyze": ("missing argument", "ROBOT", "shockpc analyze --help"),
    "stick.urdf": ('"stick.urdf"', "shockpc analyze stick.urdf --contact NAME"),
    "anymal_b": ('"anymal_b"', "shockpc analyze anymal_b --contact NAME"),
    "analyse stick.urdf": ("'analyse'", "'analyze'", "shockpc --help"),
    "fly": ("'fly'", "shockpc --help"),
    "analyze leg --contct heel": ("--contct", "--contact", "shockpc analyze --help"),
    "analyze leg --contact": ("'--contact'", "requires an argument", "shockpc analyze --help"),
    "analyze leg heel": ("(heel)", "shockpc analyze --help"),
    "analyze leg --contact heel --format yaml": ("'--format'", "'yaml'", "'table', 'json', 'csv', 'markdown'"),
    "analyze leg --contact heel --base loose": ("'--base'", "'loose'", "'free', 'planar', 'fixed'"),
    "analyze leg --contact heel --contact-point deepest": ("'--contact-point'", "'deepest'", "'frame', 'lowest'"),
    "schema landing.toml": ("(landing.toml)", "shockpc schema --help"),
    "robots --posture x": ("--posture", "shockpc robots --help"),
    "analyze dog/dog.urdf.xacro --package dog_description=dog --contact lf_foot --xacro paylod:=2": ('"paylod"', '"payload"'),
}

COMMANDS = {
    **{f"analyze stick.urdf {line}".strip(): parts for line, parts in WITHOUT_FOOT.items()},
    **{f"analyze stick.urdf --contact foot {line}": parts for line, parts in WITH_FOOT.items()},
    **USAGE,
}


@pytest.mark.parametrize(("words", "parts"), by_command(COMMANDS))
def test_commands_that_cannot_be_run(capfd, here, snapshot, words, parts):
    """A message has the option or the name, what was typed, and what would be valid."""
    message = refusal(capfd, here, *words)
    assert contains(message, *parts)
    assert message == snapshot


@pytest.mark.parametrize(
    ("lines", "parts"),
    [
        ("[joints]\nrotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } }", ('"knee"', "1e+36", "1e+12")),
        ("[joints]\nrotor = { knee = { inertia = 1, gear_ratio = 1 } }\narmature = { knee = 2 }", ('"knee"', "armature", "rotor")),
        ('stance = ["body", "body"]', ('"body"', "twice")),
        ('stance = ["ankle"]', ('"foot"', '"ankle"', "contact", "stance")),
        ('srdf = "~nobody-of-that-name/r.srdf"', ("twice.toml", "~nobody-of-that-name")),
        ('srdf = "r\\u0000.srdf"', ("twice.toml", "NUL character")),
        (f"x = {'[' * 2000}{']' * 2000}", ("twice.toml", "levels deep")),
        (f"x = {'1' * 5000}", ("twice.toml", "digits")),
    ],
    ids=lambda value: value[:30] if isinstance(value, str) else "",
)
def test_scene_files(capfd, here, lines, parts):
    """A drive in two ways or beyond numbers, a foot twice, paths that no file has, TOML that exceeds the reader."""
    (here / "twice.toml").write_text(f'robot = "stick.urdf"\n{lines}\n[[contact]]\nframe = "foot"\n')
    assert contains(refusal(capfd, here, "analyze", "twice.toml"), *parts)


# Files to write


PLACES = {
    "--out stick.urdf": ('"stick.urdf" is a file', "--out"),
    "--out stick.urdf/a/b": ('"stick.urdf/a/b"', '"stick.urdf", which is a file', "--out"),
    "--out ''": ("--out", "empty"),
    f"--out {'x' * 256}": ("--out", "255 bytes"),
    "--out ~nobody-of-that-name/out": ("--out", "~nobody-of-that-name"),
    "--save-scene ''": ("--save-scene", "empty"),
    "--save-scene dog": ('"dog" is a folder', "--save-scene"),
    "--save-scene away/landing.toml": ('"away"', "--save-scene"),
    "--save-scene dog/dog.srdf": ('"dog/dog.srdf" exists already', "--force", "--save-scene"),
    "--save-scene stick.urdf/landing.toml": ('"stick.urdf" is a file', "--save-scene"),
    **{
        f"--save-scene {name} --force": (f'"{name}" would be read as a robot', "--save-scene")
        for name in ("stick.urdf", "new.urdf", "new.urdf.xacro", "new.XACRO", "new.xml", "away/new.mjcf")
    },
}


@pytest.mark.parametrize(("words", "parts"), by_command(PLACES))
def test_places_that_cannot_be_written(capfd, here, words, parts):
    assert contains(refusal(capfd, here, *LANDING, *words), *parts)


def test_folders_whose_name_is_not_utf_8(capfd, here, monkeypatch):
    """A JSON document cannot hold such a name: nothing is written there, also if it is the current folder."""
    odd = here / os.fsdecode(b"b\xff")
    odd.mkdir()
    (odd / "stick.urdf").write_text(STICK)
    for words in (("--out", odd / "out"), ("--save-scene", odd / "landing.toml")):
        assert contains(refusal(capfd, here, *LANDING, *words), words[0], "\\xff", "UTF-8")
    assert contains(refusal(capfd, here, "analyze", odd / "stick.urdf", "--contact", "foot"), "\\xff", "UTF-8")
    monkeypatch.chdir(odd)
    assert contains(refusal(capfd, here, *LANDING, "--out", "out"), "\\xff", "UTF-8")


def test_deleted_current_folder(capfd, here, monkeypatch):
    (here / "gone").mkdir()
    monkeypatch.chdir(here / "gone")
    (here / "gone").rmdir()
    assert contains(refusal(capfd, here, *LANDING), "current folder no longer exists")


@pytest.mark.parametrize("option", ["--out", "--save-scene"])
def test_write_protected_folder(capfd, here, monkeypatch, option):
    """Found out before anything is computed."""

    def refuse(**_):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    def never(*_):
        raise AssertionError("computed before the folder was tried")

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    monkeypatch.setattr(shockpc.profile, "shock_profile", never)
    place, folder = ("locked", "locked") if option == "--out" else ("landing.toml", ".")
    assert contains(refusal(capfd, here, *LANDING, option, place), f'"{folder}"', "Permission denied", option)


def test_a_folder_where_a_file_has_to_go(capfd, here):
    """Found before anything is written, so that no results are incomplete."""
    (here / "out" / "profile.json").mkdir(parents=True)
    assert contains(refusal(capfd, here, *LANDING, "--out", "out"), '"out/profile.json" is a folder', "--out")


def test_files_of_others_are_not_replaced(capfd, here):
    """--save-scene replaces a file with --force only, and with several landings none of them is replaced."""
    good(capfd, *LANDING, "--save-scene", "landing.toml")
    before = (here / "landing.toml").read_bytes()
    assert contains(refusal(capfd, here, *LANDING, "--speed", "2", "--save-scene", "landing.toml"), '"landing.toml"', "--force")
    assert (here / "landing.toml").read_bytes() == before
    good(capfd, *LANDING, "--speed", "2", "--save-scene", "landing.toml", "--force")
    assert (here / "landing.toml").read_bytes() != before
    (here / "feet.shin.toml").write_text("mine")
    message = refusal(capfd, here, "analyze", "stick.urdf", "--contact", "*", "--save-scene", "feet.toml")
    assert contains(message, '"feet.shin.toml"', "--force")


def test_disk_that_runs_full(capfd, here, monkeypatch):
    """A file that could be written only in part is not there at all, and the one it was to replace is as it was."""
    good(capfd, *LANDING, "--save-scene", "landing.toml")
    before = (here / "landing.toml").read_bytes()

    def fill_up(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "replace", fill_up)
    message = refusal(capfd, here, *LANDING, "--speed", "2", "--save-scene", "landing.toml", "--force")
    assert contains(message, '"landing.toml"', "No space left on device")
    assert (here / "landing.toml").read_bytes() == before


@pytest.mark.parametrize("words", [LANDING, ("analyze", "landing.toml"), ("analyze", "./landing")], ids=lambda words: words[1])
def test_files_that_cannot_be_read(here, words):
    """In a process of its own, in which no file of the folder can be opened."""
    for name in ("landing.toml", "landing"):
        (here / name).write_text('robot = "stick.urdf"\n')
    code = """
import errno, os, sys
def refuse(event, arguments):
    if event == "open" and os.path.basename(str(arguments[0])) in ("stick.urdf", "landing", "landing.toml"):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(arguments[0]))
sys.addaudithook(refuse)
from shockpc.cli.entry import entry
entry()
"""
    done = python(code, *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert contains(done.stderr, "shockpc: ", words[1].removeprefix("./"), "Permission denied")


@pytest.mark.parametrize("name", ["stick.toml", "stick"])
def test_pipes_are_not_waited_for(capfd, here, name):
    """Neither as a scene nor as a robot."""
    os.mkfifo(here / name)
    assert contains(refusal(capfd, here, "analyze", f"./{name}", "--contact", "foot"), name, "pipe")


# Streams


RESULT, MISTAKE = " ".join([*SHOCKPC, *LANDING, "--explain"]), " ".join([*SHOCKPC, "analyze", "missing.urdf"])


@pytest.mark.parametrize("streams", ["2>&-", "2>/dev/full", ">/dev/null 2>&-", "<&-", "2>&1 | true"])
@pytest.mark.parametrize(("command", "code"), [(RESULT, 0), (MISTAKE, 2)], ids=["result", "mistake"])
def test_exit_codes_do_not_depend_on_standard_error(here, streams, command, code):
    """Nobody can read a message there, but the command ends as ever; a reader who goes away is no error."""
    line = f"{command} {streams}; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, cwd=here, check=False)
    assert done.returncode == code
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(("streams", "reason"), [(">/dev/full", "No space left on device"), (">&-", "closed")])
def test_standard_output_that_cannot_be_written(here, streams, reason):
    done = subprocess.run(["bash", "-c", f"{RESULT} {streams}"], capture_output=True, text=True, cwd=here, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("shockpc: standard output ")
    assert reason in done.stderr


def test_help_for_a_reader_who_goes_away(here):
    """`shockpc --help | head` is no error, and prints no message."""
    done = subprocess.run(
        ["bash", "-c", f"{' '.join(SHOCKPC)} --help | true; exit ${{PIPESTATUS[0]}}"], capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")


def test_output_is_utf8_everywhere(here):
    """A terminal that knows ASCII alone gets the same bytes as any other."""
    normal, ascii_only = (
        subprocess.run([*SHOCKPC, *LANDING], capture_output=True, env=environment({"PYTHONIOENCODING": code}), cwd=here, check=True)
        for code in ("utf-8", "ascii")
    )
    assert "|Δω|".encode() in normal.stdout
    assert normal.stdout == ascii_only.stdout


def test_environment_is_not_needed(here):
    """A command runs without a home, a locale or a terminal."""
    needed = {name: value for name, value in os.environ.items() if name in ("PATH", "PYTHONPATH")}
    done = subprocess.run([*SHOCKPC, *LANDING], capture_output=True, env=needed, cwd=here, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


# Interruptions


STOPPED = "shockpc: interrupted; no incomplete file was left\n"


@pytest.mark.parametrize("options", [("--out", "results"), ("--save-scene", "landing.toml")])
@pytest.mark.parametrize("place", ["shockpc.profile.shock_profile", "pathlib.Path.replace"])
def test_interrupted_runs_leave_no_file(capfd, here, monkeypatch, options, place):
    """Neither while it computes nor in the middle of writing, when a file is complete but does not have its name yet."""

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(place, stop)
    before = {path for path in here.rglob("*") if path.is_file()}
    assert run(capfd, *LANDING, *options) == Outcome(130, "", STOPPED)
    assert {path for path in here.rglob("*") if path.is_file()} == before


SLOW = """
import pathlib, shockpc.profile, sys, time
def slow(*_):
    pathlib.Path("ready").touch()
    time.sleep(60)
shockpc.profile.shock_profile = slow
from shockpc.cli.entry import entry
entry()
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_from_outside(here, number, code):
    """Ctrl-C and SIGTERM end a command in the same way, with the exit codes that shells give them."""
    words = [sys.executable, "-c", SLOW, *LANDING]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=allow_signals) as process:
        try:
            while not (here / "ready").exists() and process.poll() is None:
                time.sleep(0.01)
            process.send_signal(number)
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
    assert Outcome(process.returncode, out, err) == Outcome(code, "", STOPPED)


def allow_signals():
    """A process that was started in the background, or with nohup, passes on to its children that SIGINT is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("module", ["shockpc.cli.app", "typer", "pinocchio", "matplotlib.figure"])
@pytest.mark.parametrize("swallowed", [False, True])
def test_interrupted_imports(here, module, swallowed):
    """One message, also where a library turns the interruption into an error of its own."""
    code = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Interrupted:
    def find_spec(self, name, *_):
        if name == {module!r}:
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                raise {"ImportError('damaged') from None" if swallowed else ""}
sys.meta_path.insert(0, Interrupted())
from shockpc.cli.entry import entry
entry()
"""
    done = python(code, *LANDING, "--out", "out")
    assert Outcome(done.returncode, done.stdout, done.stderr) == Outcome(130, "", STOPPED)


def test_error_of_our_own(capfd, here, monkeypatch):
    """A bug shows where it is, and never ends with 1, which a script would read as a limit that is exceeded."""

    def slip(*_):
        raise ZeroDivisionError("not caused by the user")

    monkeypatch.setattr(shockpc.profile, "shock_profile", slip)
    outcome = run(capfd, *LANDING)
    assert outcome._replace(err="") == Outcome(3, "", "")
    lines = outcome.err.splitlines()
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-2] == "ZeroDivisionError: not caused by the user"
    assert contains(lines[-1], "shockpc: ", "error in shockpc itself", "report")
