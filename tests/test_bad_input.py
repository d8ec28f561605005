"""What a user can get wrong: each slip has its one message, its exit code, and leaves nothing behind."""

import errno
import gc
import os
import signal
import subprocess
import sys
import tempfile
import time
import types
from pathlib import Path

import pytest
from commands import STICK, Outcome, dog_in, environment, good, run
from robot_texts import LIMIT, floating, joint, link, mjcf, urdf

import shockpc.profile
from shockpc.cli.entry import entry

SHOCKPC = (sys.executable, "-m", "shockpc")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder with a stick.urdf and the dog's package in it."""
    folder = tmp_path.resolve()
    monkeypatch.chdir(folder)
    (folder / "stick.urdf").write_text(STICK)
    dog_in(folder)
    return folder


def refused(capfd, here, text, *words, code=2):
    """A command that has to fail with this text alone, and without a trace in the folder."""
    before = sorted(here.rglob("*"))
    assert run(capfd, *words) == Outcome(code, "", f"shockpc: {text.replace('HERE', str(here))}\n")
    assert sorted(here.rglob("*")) == before


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
    "armature.xml": mjcf(
        floating().replace('<freejoint name="root"/>', '<joint name="root" type="free" armature="-0.2"/>'),
    ),
    "twice.urdf": STICK.replace("</joint>", '<mimic joint="a"/><mimic joint="b"/></joint>', 1),
    "gapped.urdf": STICK.replace('parent link="body"', 'parent link="bdy"'),
}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "missing.urdf",
            'no file "missing.urdf" (looked in HERE). Give the path of a robot file, or the name of a known robot: shockpc robots',
        ),
        (
            "away/robot",
            'no file "away/robot" (looked in HERE). Give the path of a robot file, or the name of a known robot: shockpc robots',
        ),
        ("dog", 'no robot "dog"; no name is similar. To list them: shockpc robots'),
        ("anymal", 'no robot "anymal"; nearest: "anymal_c", "anymal_b", "anymal_kinova". To list them: shockpc robots'),
        ("./dog", '"HERE/dog" is a folder; give the robot file in it'),
        ("empty.urdf", "empty.urdf is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF)"),
        ("blank.urdf", "blank.urdf is empty; a robot file begins with <robot> (URDF, xacro) or <mujoco> (MJCF)"),
        (
            "broken.urdf",
            "broken.urdf: line 3, column 3: mismatched tag; the file is not well-formed XML, so nothing of it is used",
        ),
        (
            "letter.urdf",
            "letter.urdf: line 1, column 1: syntax error; the file is not well-formed XML, so nothing of it is used",
        ),
        (
            "world.sdf",
            "world.sdf begins with <sdf>: an SDF file, which Pinocchio's wheel cannot read; convert it to URDF. "
            "Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)",
        ),
        (
            "page.html",
            "page.html begins with <html>: a web page; download the file itself (on GitHub: the raw file). "
            "Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)",
        ),
        (
            "any.xml",
            "any.xml begins with <note>: no kind of robot known here. Robots begin with <robot> (URDF, xacro) or <mujoco> (MJCF)",
        ),
        (
            "macros.urdf.xacro",
            "macros.urdf.xacro has no <link>, so there is no robot in it; if it only defines macros, give the file that uses them",
        ),
        ("nan.urdf", 'nan.urdf: link "body": mass is "nan"; it has to be one finite number, such as 0.5'),
        ("inf.urdf", 'inf.urdf: link "body": ixx is "inf"; it has to be one finite number, such as 0.5'),
        ("negative.urdf", 'negative.urdf: link "shin": mass -0.5 kg is negative; no body has that'),
        (
            "massless.urdf",
            "massless.urdf: no link has mass, so nothing in it can be struck; give at least one link an <inertial>",
        ),
        (
            "entity.urdf",
            "entity.urdf: line 1: a DOCTYPE can define entities, and those are never expanded here; "
            "delete the DOCTYPE and write out what its entities stand for",
        ),
        (
            "armature.xml",
            'armature.xml: joint "root": armature -0.2 is negative; no rotor has that',
        ),
        (
            "twice.urdf",
            'twice.urdf: joint "knee" has several <mimic>, and a joint can follow only one; keep one',
        ),
        (
            "gapped.urdf",
            'gapped.urdf: joint "knee": its parent is link "bdy", which does not exist; '
            "every joint has to join two links of the file",
        ),
    ],
    ids=lambda value: value if " " not in value else "",
)
@pytest.mark.parametrize("command", ["analyze", "robots"])
def test_robot_files(capfd, here, command, name, text):
    """A file that holds no robot is refused alike by both commands that read one."""
    if name in FILES:
        (here / name).write_text(FILES[name])
    refused(capfd, here, text, command, name, *(("--contact", "foot") if command == "analyze" else ()))


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), 'no contact is given, so nothing strikes robot "stick"; name one with --contact, such as "foot"'),
        (
            ("--contact", "wheel"),
            'no link or frame "wheel" in robot "stick"; there are: "body", "shin", "foot", "root_joint", "knee", "ankle". '
            "To list them: shockpc robots HERE/stick.urdf",
        ),
        (
            ("--contact", "fot"),
            'no link or frame "fot" in robot "stick"; nearest: "foot". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "*_paw"),
            'no link or frame "*_paw" in robot "stick"; there are: "body", "shin", "foot", "root_joint", "knee", "ankle". '
            "To list them: shockpc robots HERE/stick.urdf",
        ),
        (("--contact", "foot+"), '--contact: "foot+" holds an empty name; valid are a name, A+B, or a glob such as "*_foot"'),
        (
            ("--contact", "foot+foot"),
            '--contact: "foot+foot" names "foot" twice, and one contact strikes once; leave one of them out',
        ),
        (("--contact", ""), '--contact: "" holds an empty name; valid are a name, A+B, or a glob such as "*_foot"'),
        (
            ("--contact", "foot", "--point", "nose"),
            'no frame "nose" in robot "stick"; nearest: "knee". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "foot", "--posture", "sitting"),
            'no posture "sitting" in robot "stick"; there are: "neutral". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "foot", "--set", "hip=3"),
            'no joint "hip" in robot "stick"; there are: "knee". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "foot", "--set", "root_joint=3"),
            'no joint "root_joint" in robot "stick"; there are: "knee". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "foot", "--lock", "hip"),
            'no joint "hip" in robot "stick"; there are: "knee". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "foot", "--stance", "sole"),
            'no link or frame "sole" in robot "stick"; there are: "body", "shin", "foot", "root_joint", "knee", "ankle". '
            "To list them: shockpc robots HERE/stick.urdf",
        ),
        (
            ("--contact", "foot", "--bodies", "shnk"),
            'no body "shnk" in robot "stick"; nearest: "shin". To list them: shockpc robots HERE/stick.urdf',
        ),
        (
            ("--contact", "foot", "--xacro", "payload:=2"),
            "stick.urdf is not a xacro file, so --xacro payload=… means nothing to it; leave it out",
        ),
        (
            ("--contact", "foot", "--srdf", "no.srdf"),
            'no file "HERE/no.srdf"',
        ),
        (
            ("--contact", "foot", "--srdf", "stick.urdf"),
            "stick.urdf is not an SRDF: an SRDF begins with <robot> and holds <group_state> postures, no links",
        ),
        (
            ("--contact", "foot", "--package", "dog=nowhere"),
            'package "dog": there is no folder "nowhere"; correct --package dog=DIR',
        ),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_names(capfd, here, words, text):
    """A name that the robot does not have is met with the nearest, or with all of them, and the command that lists them."""
    refused(capfd, here, text, "analyze", "stick.urdf", *words)


TURN = "turn its velocity towards the ground, or list it under stance if it stands there already"
STRIKE_WAYS = "the strike is given in two ways; keep one of: speed with strike angle, velocity, drop height"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            "--base fixed --angular-velocity 0,2,0",
            "the base is fixed, so it cannot turn before the impact; leave out the angular velocity, or free the base",
        ),
        (
            "--base planar --angular-velocity 1,3,0",
            "the base is planar, so before the impact it turns about the plane's normal (0, -1, 0) only, but the angular velocity "
            "has 1 rad/s across it; leave that part out, or free the base",
        ),
        (
            "--angular-velocity 1e300,0,0",
            "strike.angular_velocity[0] is 1e+300, which is out of range; give a number up to 1e+09",
        ),
        (
            "--joint-velocity knee=1e200",
            "strike.joint_velocities.knee is 1e+200, which is out of range; give a number up to 1e+09",
        ),
        (
            "--joints locked --armature knee=0.1",
            '"knee" is locked, so a reflected inertia changes nothing there; leave out the lock, or the armature or rotor',
        ),
        (
            "--strike-angle 90",
            'contact "foot" moves along the ground, approaching it at 6.1e-17 m/s, so there is no impact; '
            "strike angle is 90 deg, try one above -90 and below 90 deg",
        ),
        (
            "--strike-angle 120",
            'contact "foot" is leaving the ground at 0.5 m/s, so there is no impact; '
            "strike angle is 120 deg, try one above -90 and below 90 deg",
        ),
        (
            "--strike-angle=-135 --speed 2",
            'contact "foot" is leaving the ground at 1.4 m/s, so there is no impact; '
            "strike angle is -135 deg, try one above -90 and below 90 deg",
        ),
        (
            "--velocity 0,0,0.31",
            'contact "foot" is leaving the ground at 0.31 m/s, so there is no impact; ' + TURN,
        ),
        (
            "--velocity 1,0,0",
            'contact "foot" moves along the ground, approaching it at 0 m/s, so there is no impact; ' + TURN,
        ),
        ("--velocity 0,-1", '--velocity: "0,-1" is not three numbers with commas between them, such as 0.5,0,-1'),
        ("--velocity 0,0,-1,0", '--velocity: "0,0,-1,0" is not three numbers with commas between them, such as 0.5,0,-1'),
        ("--velocity 0,0,down", '--velocity: "down" is not a finite number'),
        ("--velocity 0,0,-inf", '--velocity: "-inf" is not a finite number'),
        ("--speed nan", '--speed: "nan" is not a finite number'),
        ("--speed 0", "a strike speed of 0 m/s gives no impact; it has to be above zero"),
        ("--speed=-1", "a strike speed of -1 m/s gives no impact; it has to be above zero"),
        ("--drop-height 0", "a drop height of 0 m gives no impact; it has to be above zero"),
        (
            "--velocity 0,0,0",
            'contact "foot" moves along the ground, approaching it at 0 m/s, so there is no impact; ' + TURN,
        ),
        ("--speed 1e308", "a strike at 1e+308 m/s cannot be computed; its speed has to lie between 1e-09 and 1e+09 m/s"),
        ("--speed 1e-300", "a strike at 1e-300 m/s cannot be computed; its speed has to lie between 1e-09 and 1e+09 m/s"),
        ("--velocity 0,0,-1e200", "a strike at 1e+200 m/s cannot be computed; its speed has to lie between 1e-09 and 1e+09 m/s"),
        ("--drop-height 1e308", "a strike at inf m/s cannot be computed; its speed has to lie between 1e-09 and 1e+09 m/s"),
        ("--drop-height 1e999", '--drop-height: "1e999" is not a finite number'),
        ("--strike-angle steep", '--strike-angle: "steep" is not a finite number'),
        *(
            (
                f"--plane {plane} --strike-angle{angle}",
                "a plane seen from above holds no vertical to measure a strike angle from; give the strike's velocity",
            )
            for plane, angle in (("xy", " 10"), ("0,0,-2", "=-0.5"))
        ),
        (
            "--plane xy --strike-angle 181",
            "a strike angle of 181 deg is no angle; it lies between -180 and 180 deg",
        ),
        ("--velocity 0,0,-1 --speed 2", STRIKE_WAYS),
        ("--velocity 0,0,-1 --drop-height 1", STRIKE_WAYS),
        ("--drop-height 1 --strike-angle 10", STRIKE_WAYS),
        ("--restitution 1.5", 'contact "foot" has restitution 1.5; it lies between 0 (stays down) and 1 (bounces fully)'),
        ("--restitution=-0.1", 'contact "foot" has restitution -0.1; it lies between 0 (stays down) and 1 (bounces fully)'),
        ("--restitution nan", '--restitution: "nan" is not a finite number'),
        ("--offset 0,0", '--offset: "0,0" is not three numbers with commas between them, such as 0,0,-0.02'),
        ("--offset 0,0,nan", '--offset: "nan" is not a finite number'),
        ("--base-rpy 15", '--base-rpy: "15" is not three numbers with commas between them, such as 0,15,0'),
        ("--plane zx", '--plane: "zx" is no plane; valid are xz, yz, xy or a normal such as 0,-1,0'),
        ("--plane 0,1", '--plane: "0,1" is not three numbers with commas between them, such as 0,-1,0'),
        (
            "--plane 0,0,0",
            "plane: a plane's normal needs a finite length above zero, not [0.0, 0.0, 0.0]; "
            "valid are xz, yz, xy or a normal such as 0,-1,0",
        ),
        ("--point body:1,2", '--point body: "1,2" is not three numbers with commas between them, such as 0,0,0.1'),
        ("--point body:", '--point body: "" is not three numbers with commas between them, such as 0,0,0.1'),
        ("--point body:1,2,x", '--point body: "x" is not a finite number'),
        ("--set knee", "--set: \"knee\" is not JOINT=VALUE, such as '*_knee=-60'"),
        ("--set knee=", "--set: \"knee=\" is not JOINT=VALUE, such as '*_knee=-60'"),
        ("--set =30", "--set: \"=30\" is not JOINT=VALUE, such as '*_knee=-60'"),
        ("--set knee=bent", '--set knee: "bent" is not a finite number'),
        ("--armature knee", "--armature: \"knee\" is not JOINT=INERTIA, such as '*_KFE=0.05'"),
        ("--armature knee=heavy", '--armature knee: "heavy" is not a finite number'),
        (
            "--armature knee=-1",
            'armature of "knee" is -1; a reflected inertia has to be above zero; for none use model = "free"',
        ),
        (
            "--armature root_joint=1",
            '"root_joint" is the floating base of robot "stick", which has no drive; name a joint',
        ),
        ("--joint-velocity knee", "--joint-velocity: \"knee\" is not JOINT=RATE, such as '*_knee=2.5'"),
        ("--joint-velocity knee=fast", '--joint-velocity knee: "fast" is not a finite number'),
        ("--angular-velocity 1", '--angular-velocity: "1" is not three numbers with commas between them, such as 0,3,0'),
        (
            "--pulse square:5ms",
            'pulse: there is no pulse shape "square"; valid are half-sine, saw-tooth, haversine, rectangle, '
            "with a length such as half-sine:5ms",
        ),
        ("--range-g 16", "a sensor's range is given in g, but no pulse; give one too, such as half-sine:5ms"),
        ("--range-g=-1", "a sensor's range of -1 g has to be above zero"),
        ("--range-g wide", '--range-g: "wide" is not a finite number'),
        (
            "--lock knee --base fixed",
            'nothing of robot "stick" can move: its base is fixed and no joint is free; free one of them',
        ),
        ("--xacro payload", '--xacro: "payload" is not NAME:=VALUE, such as payload:=1.5'),
        ("--package dog", '--package: "dog" is not NAME=DIR, such as dog_description=../dog'),
        (
            "--contact-point lowest",
            'link "foot" has no collision geometry that could be read, so it has no lowest point; '
            "give the contact point by its offset, or name a link that has collision geometry",
        ),
    ],
    ids=lambda value: value if value.startswith("--") and len(value) < 40 else "",
)
def test_values(capfd, here, words, text):
    """A value that means nothing, or no impact, names the option and what would be valid."""
    refused(capfd, here, text, "analyze", "stick.urdf", "--contact", "foot", *words.split())


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ("analyze", "missing argument 'robot'. To see what is valid: shockpc analyze --help"),
        ("anymal_b", "no such command 'anymal_b'. To see what is valid: shockpc --help"),
        ("anlyze", "no such command 'anlyze'. Did you mean 'analyze'? To see what is valid: shockpc --help"),
        (
            "analyze leg --contct heel",
            "no such option: --contct (Possible options: --contact, --contact-point, --point). "
            "To see what is valid: shockpc analyze --help",
        ),
        ("analyze leg --contact", "option '--contact' requires an argument. To see what is valid: shockpc analyze --help"),
        ("analyze leg heel", "got unexpected extra argument(s) (heel). To see what is valid: shockpc analyze --help"),
        (
            "analyze leg --contact heel --format yaml",
            "invalid value for '--format': 'yaml' is not one of 'table', 'json', 'csv', 'markdown'. "
            "To see what is valid: shockpc analyze --help",
        ),
        (
            "analyze leg --contact heel --base loose",
            "invalid value for '--base': 'loose' is not one of 'free', 'planar', 'fixed'. "
            "To see what is valid: shockpc analyze --help",
        ),
        (
            "analyze leg --contact heel --contact-point deepest",
            "invalid value for '--contact-point': 'deepest' is not one of 'frame', 'lowest'. "
            "To see what is valid: shockpc analyze --help",
        ),
        ("schema landing.toml", "got unexpected extra argument(s) (landing.toml). To see what is valid: shockpc schema --help"),
        ("robots --posture x", "no such option: --posture. To see what is valid: shockpc robots --help"),
    ],
    ids=lambda value: value if len(value) < 40 else "",
)
def test_usage(capfd, here, words, text):
    """A slip in the words themselves points to the help of that command."""
    refused(capfd, here, text, *words.split())


def test_xacro_arguments(capfd, here):
    """An argument that the file does not have is met with those that it has."""
    words = ("analyze", "dog/dog.urdf.xacro", "--package", "dog_description=dog", "--contact", "lf_foot", "--xacro", "paylod:=2")
    refused(capfd, here, 'dog.urdf.xacro has no xacro argument "paylod"; nearest: "payload". It has "payload"', *words)


def test_fixed_base_cannot_be_freed(capfd, here):
    (here / "arm.xml").write_text(
        '<mujoco model="arm"><worldbody><body name="arm"><joint name="j" axis="0 1 0"/>'
        '<geom name="g" type="box" size="0.2 0.02 0.02" mass="1"/></body></worldbody></mujoco>'
    )
    text = (
        'robot "arm" has a fixed base in its file, so base = "free" cannot be had; '
        'give its root body a <freejoint/>, or use base = "fixed"'
    )
    refused(capfd, here, text, "analyze", "arm.xml", "--contact", "arm", "--base", "free")


@pytest.mark.parametrize("scene", [False, True])
def test_srdf_of_an_mjcf(capfd, here, scene):
    """Postures that nothing would read are refused, typed or in a scene."""
    (here / "dog.xml").write_text(mjcf(floating()))
    (here / "landing.toml").write_text('robot = "dog.xml"\nsrdf = "dog/dog.srdf"\n[[contact]]\nframe = "base"\n')
    text = (
        "dog.xml is an MJCF, whose postures are its keyframes, so the SRDF dog.srdf means nothing to it; leave it out, or write "
        "its postures as <key> elements of a <keyframe>"
    )
    words = ("landing.toml",) if scene else ("dog.xml", "--contact", "base", "--srdf", "dog/dog.srdf")
    refused(capfd, here, text, "analyze", *words)


def test_model_that_cannot_be_solved(capfd, here):
    """Moving bodies without mass leave no verdict, and are named."""
    text = (
        'bodies "l_gripper", "r_gripper" of robot "RomeoH37" can move, but no mass or inertia resists it, so the inertia matrix '
        "cannot be inverted; give mass and inertia in the file (mass on a joint's axis does not resist turning about it), or lock "
        "the joints with --lock"
    )
    refused(capfd, here, text, "analyze", "romeo_laas_small", "--contact", "l_sole", code=3)


def test_strike_that_the_mechanism_cannot_meet(capfd, here):
    """A stick on a fixed base cannot give way along itself: the contact, the direction and the remedy are named."""
    text = (
        'contact "foot" cannot be stopped: 1 m/s are left along (0 0 1), because the mechanism cannot move that way here, '
        "or another contact asks for the opposite; leave that direction out of the contact or of the strike, or free the base"
    )
    refused(capfd, here, text, "analyze", "stick.urdf", "--contact", "foot", "--base", "fixed")


# Files to write


LANDING = ("analyze", "stick.urdf", "--contact", "foot")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--out", "stick.urdf"), '"stick.urdf" is a file; name a folder with --out'),
        (("--out", "stick.urdf/a/b"), '"stick.urdf/a/b" would lie in "stick.urdf", which is a file; name a folder with --out'),
        (("--save-scene", "dog"), '"dog" is a folder; name a file with --save-scene, such as landing.toml'),
        (
            ("--save-scene", "away/landing.toml"),
            'there is no folder "away" for --save-scene; make it, or name another file',
        ),
        (
            ("--save-scene", "dog/dog.srdf"),
            '"dog/dog.srdf" is there already and holds no scene; name another file with --save-scene',
        ),
        *(
            (
                ("--save-scene", name),
                f'"{name}" would be read as a robot; name a scene with --save-scene, such as landing.toml',
            )
            for name in ("stick.urdf", "new.urdf", "new.urdf.xacro", "new.XACRO", "new.xml", "away/new.mjcf")
        ),
        (
            ("--save-scene", "stick.urdf/landing.toml"),
            '"stick.urdf" is a file; name a folder with --save-scene',
        ),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_places_that_cannot_be_written(capfd, here, words, text):
    refused(capfd, here, text, *LANDING, *words)


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
    text = f'nothing can be written in folder "{folder}": Permission denied; name another with {option}, or change its permissions'
    refused(capfd, here, text, *LANDING, option, place)


def test_bad_command_leaves_no_folder(capfd, here):
    """A folder of results is made only when there are results."""
    assert run(capfd, "analyze", "stick.urdf", "--contact", "wheel", "--out", "results/today").code == 2
    assert not (here / "results").exists()


def test_disk_that_runs_full(capfd, here, monkeypatch):
    """A file that could be written only in part is not there at all, and the one it was to replace is as it was."""
    good(capfd, *LANDING, "--save-scene", "landing.toml")
    before = (here / "landing.toml").read_bytes()
    write = Path.write_bytes

    def fill_up(path, data):
        write(path, data[: len(data) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", fill_up)
    text = '"landing.toml" cannot be written: No space left on device'
    refused(capfd, here, text, *LANDING, "--speed", "2", "--save-scene", "landing.toml")
    assert (here / "landing.toml").read_bytes() == before


def test_standard_output_that_runs_full(capfd, monkeypatch):
    class Full:
        """A stream on a full disk."""

        def write(self, _):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        def fileno(self):
            return self.file.fileno()

    full = Full()
    with tempfile.TemporaryFile() as full.file:
        monkeypatch.setattr(sys, "stdout", full)
        outcome = run(capfd, "schema")
    assert outcome == Outcome(2, "", "shockpc: standard output cannot be written: No space left on device\n")


def test_closed_standard_output(capfd, monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    text = "shockpc: standard output is closed; open it, or write files with --out\n"
    assert run(capfd, "schema") == Outcome(2, "", text)


# Interruptions


STOPPED = "shockpc: interrupted; no file was left half-written\n"


def test_interrupt_during_the_analysis(capfd, here, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(shockpc.profile, "shock_profile", stop)
    before = sorted(here.rglob("*"))
    assert run(capfd, *LANDING, "--out", "results", "--save-scene", "landing.toml") == Outcome(130, "", STOPPED)
    assert sorted(here.rglob("*")) == before


def test_interrupt_while_a_file_is_written(capfd, here, monkeypatch):
    """Ctrl-C in the middle of a file: neither the file nor a part of it is there."""
    write = Path.write_bytes

    def stop(path, data):
        write(path, data[: len(data) // 2])
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", stop)
    before = sorted(here.rglob("*"))
    assert run(capfd, *LANDING, "--save-scene", "landing.toml") == Outcome(130, "", STOPPED)
    assert sorted(here.rglob("*")) == before


def test_interrupt_from_the_keyboard(here):
    """A real signal to a real process, which waits for a robot file that never comes."""
    pipe = here / "robot.urdf"
    os.mkfifo(pipe)
    words = [*SHOCKPC, "analyze", str(pipe), "--contact", "foot"]
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=hear_the_keyboard
    ) as process:
        try:
            writing = opened_by_reader(pipe, process)
            process.send_signal(signal.SIGINT)
            # A signal that comes just before the read begins waits until the read ends (no EINTR): let it end.
            os.close(writing)
            out, err = process.communicate(timeout=PATIENCE)
        finally:
            # Whatever went wrong, nothing is left that waits for ever.
            process.kill()
    assert Outcome(process.returncode, out, err) == Outcome(130, "", STOPPED)


PATIENCE = 60.0
"""How long a process may take before the test fails instead of hanging [s]."""


def hear_the_keyboard():
    """A process that was started in the background, or with nohup, hands on to its children that SIGINT is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def opened_by_reader(pipe, process):
    """The writing end of a named pipe once the process reads from it: from then on it is inside the command."""
    end = time.monotonic() + PATIENCE
    while process.poll() is None and time.monotonic() < end:
        try:
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        except OSError as error:
            assert error.errno == errno.ENXIO  # noqa: PT017 - no reader yet
            time.sleep(0.01)
    pytest.fail(f"the process did not come to read its robot; it ended with {process.poll()}")


def test_reader_that_goes_away(here):
    """`shockpc … | head` is no error, and says nothing; not even the help."""
    for words in (LANDING, ("--help",)):
        reading, writing = os.pipe()
        os.close(reading)
        done = subprocess.run([*SHOCKPC, *words], stdout=writing, stderr=subprocess.PIPE, text=True, cwd=here, check=False)
        os.close(writing)
        assert (done.returncode, done.stderr) == (0, "")


def test_output_is_utf8_everywhere(here):
    """A terminal that knows ASCII alone gets the same bytes as any other."""
    plain, ascii_only = (
        subprocess.run([*SHOCKPC, *LANDING], capture_output=True, env=environment({"PYTHONIOENCODING": code}), cwd=here, check=True)
        for code in ("utf-8", "ascii")
    )
    assert "|Δω|".encode() in plain.stdout
    assert plain.stdout == ascii_only.stdout


def test_fault_of_our_own(capfd, here, monkeypatch):
    """A bug shows where it is, and never ends with 1, which a script would read as a gate that is exceeded."""

    def slip(*_):
        raise ZeroDivisionError("by no fault of the user")

    monkeypatch.setattr(shockpc.profile, "shock_profile", slip)
    outcome = run(capfd, *LANDING)
    lines = outcome.err.splitlines()
    assert outcome._replace(err="") == Outcome(3, "", "")
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-2:] == [
        "ZeroDivisionError: by no fault of the user",
        "shockpc: this is a fault in shockpc itself, not in what you gave it; please report the lines above",
    ]


def test_file_that_cannot_be_read(capfd, here, monkeypatch):
    def refuse(path, *_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    (here / "landing.toml").write_text('robot = "stick.urdf"\n')
    (here / "landing").write_text('robot = "stick.urdf"\n')
    for method in ("open", "read_bytes", "read_text"):
        monkeypatch.setattr(Path, method, refuse)
    refused(capfd, here, '"landing.toml" cannot be read: Permission denied; check its permissions', "analyze", "landing.toml")
    text = '"HERE/stick.urdf" cannot be read: Permission denied; check its permissions'
    refused(capfd, here, text, *LANDING)
    refused(capfd, here, '"HERE/landing" cannot be read: Permission denied; check its permissions', "analyze", "./landing")


def test_names_that_are_no_utf8(capfd, here):
    """A scene file cannot hold such a name, so it is not written."""
    odd = os.fsdecode(b"st\xffck.urdf")
    (here / odd).write_text(STICK)
    before = sorted(here.rglob("*"))
    outcome = run(capfd, "analyze", odd, "--contact", "foot", "--save-scene", "landing.toml")
    text = '"landing.toml" cannot be written: the name of a file or folder in it is not UTF-8; rename that'
    assert outcome == Outcome(2, "", f"shockpc: {text}\n")
    assert sorted(here.rglob("*")) == before


def test_environment_is_not_needed(here):
    """A command runs without a home, a locale or a terminal."""
    done = subprocess.run([*SHOCKPC, *LANDING], capture_output=True, env={"PATH": environment({})["PATH"]}, cwd=here, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


class EndError(Exception):
    """What stands for the end of the process."""


@pytest.fixture
def door(monkeypatch):
    """The door of the command, in this process: it ends by an exception, with its exit code."""

    def end(code):
        raise EndError(code)

    monkeypatch.setattr(os, "_exit", end)
    monkeypatch.setattr(gc, "disable", lambda: None)
    monkeypatch.setitem(os.environ, "OPENBLAS_NUM_THREADS", "1")
    return entry


def test_interrupt_while_libraries_are_imported(door, capfd, monkeypatch):
    class Slow(types.ModuleType):
        """A module that is interrupted while it is imported."""

        def __getattr__(self, name):
            raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "shockpc.cli.main", Slow("shockpc.cli.main"))
    with pytest.raises(EndError) as end:
        door()
    assert end.value.args == (130,)
    assert capfd.readouterr() == ("", STOPPED)


@pytest.mark.parametrize(("words", "code"), [(["schema"], 0), (["schema", "x"], 2)])
def test_door_ends_with_the_exit_code(door, capfd, monkeypatch, words, code):
    monkeypatch.setattr(sys, "argv", ["shockpc", *words])
    with pytest.raises(EndError) as end:
        door()
    assert end.value.args == (code,)
    assert bool(capfd.readouterr().out) == (code == 0)


def test_door_bears_closed_streams(door, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["shockpc", "schema"])
    monkeypatch.setattr(sys, "stdout", None)
    with pytest.raises(EndError) as end:
        door()
    assert end.value.args == (2,)


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        (
            "[joints]\nrotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } }",
            'rotor of "knee" reflects 1e+36 kg m², which cannot be computed with; it may reflect up to 1e+12, and a joint that '
            'holds is model = "locked"',
        ),
        (
            "[joints]\nrotor = { knee = { inertia = 1, gear_ratio = 1 } }\narmature = { knee = 2 }",
            '"knee" is given an armature and a rotor, which are two ways to say one thing; keep one of them',
        ),
        ('stance = ["body", "body"]', '"body" is listed twice as a stance; leave one of them out'),
        (
            'stance = ["ankle"]',
            '"foot", which is the same point as "ankle", is both a contact and a stance, but a foot strikes or stands; '
            "leave one of them out",
        ),
    ],
)
def test_scenes_that_say_too_much(capfd, here, lines, text):
    """A drive in two ways or beyond numbers, a foot twice."""
    (here / "twice.toml").write_text(f'robot = "stick.urdf"\n{lines}\n[[contact]]\nframe = "foot"\n')
    refused(capfd, here, text, "analyze", "twice.toml")


@pytest.mark.parametrize(
    ("mass", "text"),
    [
        (
            "1e-17",
            "weighs 1e-17 kg, and below 2.2e-16 kg its centre of mass is lost in reading; give it the mass that it has, or 0",
        ),
        (
            "1e300",
            "weighs 1e+300 kg and has moments of inertia up to 0.1 kg m², which cannot be computed with; give numbers up to 1e+24",
        ),
    ],
)
def test_masses_beyond_numbers(capfd, here, mass, text):
    """A mass whose place would be lost in reading, and one whose square has no number."""
    robot = urdf(link("body"), link("shin", mass=mass), joint("knee", "body", "shin", more=LIMIT), name="stick")
    (here / "stick.urdf").write_text(robot)
    refused(capfd, here, f'stick.urdf: body "shin" {text}', "analyze", "stick.urdf", "--contact", "shin")


def test_a_folder_where_a_file_has_to_go(capfd, here):
    """Found before anything is written, so that nothing is half there."""
    (here / "out" / "profile.json").mkdir(parents=True)
    text = '"out/profile.json" is a folder, where a file has to go; move it, or name another with --out'
    refused(capfd, here, text, *LANDING, "--out", "out")
