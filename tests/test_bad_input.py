"""What a user can get wrong: one message on standard error, its exit code, and no file left behind.

Beside each mistake stands a part of its message, which tells the reason, or what would be valid.
"""

import errno
import os
import shlex
import signal
import subprocess
import sys
import tempfile
from unittest.mock import Mock

import pytest
from commands import STICK, Outcome, environment, good, interrupted, python, run
from robot_texts import body, floating, joint, link, mjcf, urdf, xacro

import shockpc.profile
from shockpc import SolveError, read_scene
from shockpc.show.report import Report

SHOCKPC = (sys.executable, "-m", "shockpc")
LANDING = ("analyze", "stick.urdf", "--contact", "foot")


def refusal(capfd, here, *words, code=2):
    """The message of a command that has to fail with this code, print nothing else and change no
    file.
    """
    before = sorted(here.rglob("*"))
    outcome = run(capfd, *words)
    assert outcome._replace(err="") == Outcome(code, "", "")
    assert sorted(here.rglob("*")) == before
    assert outcome.err.startswith("shockpc: ")
    assert outcome.err.count("\n") == 1
    return outcome.err.removeprefix("shockpc: ").replace(str(here), "HERE").rstrip("\n")


def contains(message, *parts):
    """Whether a message contains all these names and numbers."""
    return [part for part in parts if part not in message] == [] or pytest.fail(
        f"{parts} in: {message}"
    )


def commands(text, **named):
    """Reasons and command lines as parameters.

    A line is the beginning of commands, ::, their ends with | between, => and a part of their
    message. Args: named, what words in capitals at the beginning stand for.
    """
    found = []
    for line in text.strip().splitlines():
        typed, _, reason = line.partition(" => ")
        begin, _, ends = typed.partition(":: ")
        words = [f"{named.get(begin, begin)} {end}".strip() for end in ends.split(" | ")]
        found += [pytest.param(reason, shlex.split(one), id=one) for one in words]
    return found


# Robot files


FILES = {
    "empty.urdf": ("", "begins with <robot> (URDF, xacro) or <mujoco> (MJCF) or <sdf> (SDFormat)"),
    "broken.urdf": (
        "<robot name='r'>\n  <link name='a'>\n</robot>\n",
        "line 3, column 3: mismatched tag",
    ),
    "macros.urdf.xacro": (xacro('<xacro:macro name="leg" params=""/>'), "no <link>"),
    "gapped.urdf": (
        STICK.replace('parent link="body"', 'parent link="bdy"'),
        'joint "knee": its parent is link "bdy"',
    ),
    "light.urdf": (
        urdf(link("body"), link("shin", mass="1e-19"), joint("knee", "body", "shin")),
        '"shin": <mass> value is 1e-19 kg',
    ),
}
"""One for each reason; the others are in the tests of readers."""

NO_FILES = {
    **dict.fromkeys(("missing.urdf", "away/robot"), "looked in HERE"),
    "dog": "no name is similar",
    "anymal": 'nearest: "anymal_c", "anymal_b"',
    "./dog": '"HERE/dog" is a folder; give the robot file in it',
    "": "the path is empty",
    "~nobody-of-that-name/robot.urdf": "begins with the home of a user whom this computer does not have",
    "x" * 300: f'"{"x" * 40}…{"x" * 39}"; no name is similar',
    "x" * 300 + ".urdf": f'{"x" * 34}.urdf" (looked in HERE)',
}


@pytest.mark.parametrize("name", [*NO_FILES, *FILES], ids=lambda name: name[:40])
def test_robot_files(capfd, here, name):
    """A file that holds no robot is refused by both commands that read one, in the same words."""
    text, reason = FILES.get(name, ("", NO_FILES.get(name)))
    if name in FILES:
        (here / name).write_text(text)
    message = refusal(capfd, here, "robots", name)
    assert contains(message, reason, name[:40].removeprefix("./"))
    assert (
        refusal(capfd, here, "analyze", name, "--contact", "shin").replace(
            "analyze --help", "robots --help"
        )
        == message
    )


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (
            "romeo_laas_small --contact l_sole",
            ('"l_gripper"', '"r_gripper"', '"RomeoH37"', "--lock"),
        ),
        (
            "stick.urdf --contact foot --base fixed",
            ("no verdict", 'posture "neutral"', "1 m/s", "(0 0 1)", "free the base"),
        ),
    ],
)
def test_models_that_cannot_be_solved(capfd, here, words, parts):
    """Bodies that move without mass, and a posture in which the mechanism cannot give way, have no
    result and are named.
    """
    assert contains(refusal(capfd, here, "analyze", *words.split(), code=3), *parts)


MODELS = {
    "arm.xml": mjcf('<body name="post">' + body("arm") + "</body>"),
    "dog.xml": mjcf(floating()),
    "srdf.toml": 'robot = "dog.xml"\nsrdf = "dog/dog.srdf"\n[[contact]]\nframe = "base"\n',
}


@pytest.mark.parametrize(
    ("reason", "words"),
    commands("""
analyze:: srdf.toml => is an MJCF, so the SRDF dog.srdf has no effect
analyze arm.xml:: --contact post | --contact arm --stance post => "post" is fixed to the world, so no impulse
analyze arm.xml:: --contact arm --base free => must be larger than mjMINVAL; Element name 'post'
analyze arm.xml:: --contact arm --base-rpy 0,0,0 => is fixed in its file, so it cannot be moved or turned; free it
"""),
)
def test_models_from_mjcf(capfd, here, reason, words):
    """A base that its file fixes cannot be freed or placed, and cannot strike; postures that
    nothing reads are refused.
    """
    for name, text in MODELS.items():
        (here / name).write_text(text)
    assert contains(refusal(capfd, here, *words), reason)


# Names and values


COMMANDS = """
STICK:: --contact wheel | --contact *_paw => "root_joint", "knee", "ankle"; the feet of this robot: "foot". To list them: shockpc
FOOT:: --stance sole => "root_joint", "knee", "ankle"; the feet of this robot: "foot". To list them: shockpc
STICK:: --contact fot => nearest: "foot"; the feet of this robot
STICK:: --contact foot+ | --contact '' => holds an empty name; valid are a name, A+B
STICK:: --contact foot+foot => names "foot" twice; remove one
FOOT:: --at nose => no frame "nose" in robot "stick"; nearest: "knee"
FOOT:: --at body:1,2 | --at body: | --at body:1,2,x => is not a point; give FRAME or FRAME:x,y,z
FOOT:: --body shnk => no body "shnk" in robot "stick"; nearest: "shin"
FOOT:: --posture sitting => there are: "neutral"
FOOT:: --set hip=3 | --set root_joint=3 | --lock hip => there are: "knee". To list them: shockpc robots HERE/stick.urdf
FOOT:: --set knee | --set knee= | --set =30 | --xacro payload | --package dog | --armature knee => is not NAME=VALUE: a name
FOOT:: --joint-velocity knee => is not NAME=VALUE: a name, an equals sign and a value
robots:: leg --xacro mass | leg --package dog => is not NAME=VALUE: a name
FOOT:: --set knee=9999 | --set *nee=-1e5 => deg is outside the limits of joint "knee", -114.592 to 114.592 deg, and more
SWEEP:: --set knee=9999 => and more than a whole turn; give values from -360 to 360 deg
FOOT:: --set knee=bent | --speed nan | --drop-height 1e999 | --velocity 0,0,down | --rotor knee=light => is not a finite number
FOOT:: --offset 0,0 | --base-rpy 15 | --velocity 0,-1 | --angular-velocity 1 | --plane 0,1 => is not 3 values with "," between
FOOT:: --xacro payload:=2 => stick.urdf is not a xacro file, so --xacro payload=… has no effect
FOOT:: --package dog=nowhere => correct --package dog=DIR
robots:: leg --package dog=/nowhere => correct --package dog=DIR
FOOT:: --package dog=~nobody-of-that-name => begins with the home of a user whom this computer does not have; give the folder itself
FOOT:: --srdf no.srdf => --srdf is not an option; srdf is a key of a scene's file
FOOT:: --forward-speed 1 => --forward-speed is not an option; strike.forward_speed is a key of a scene's file
FOOT:: --flat => --flat is not an option; write --contact-kind flat
FOOT:: --together => --together is not an option; write --contact A+B
FOOT:: --contact-point lowest => link "foot" has no collision geometry that could be read, so it has no lowest point
FOOT:: --strike-angle 90 => moves along the ground, approaching it at 6.1e-17 m/s, so there is no impact
FOOT:: --velocity 0,0,0 => moves along the ground, approaching it at 0 m/s
FOOT:: --strike-angle 120 => is leaving the ground at 0.5 m/s, so there is no impact; turn its velocity towards the ground
FOOT:: --strike-angle=-135 --speed 2 => is leaving the ground at 1.4 m/s
FOOT:: --velocity 0,0,0.31 => is leaving the ground at 0.31 m/s
FOOT:: --offset 0.1,0,0 --joint-velocity knee=-99 => is leaving the ground at 8.9 m/s
FOOT:: --speed 0 | --speed=-1 => must be > 0 m/s, got
FOOT:: --drop-height 0 => must be > 0 m, got 0
FOOT:: --range-g=-1 | --pulse half-sine:5ms --range-g 0 => must be > 0 g, got
FOOT:: --restitution 1.5 | --restitution=-0.1 => must be ≥ 0 and ≤ 1, got
FOOT:: --speed 1e308 | --velocity 0,0,-1e200 | --drop-height 1e308 | --joint-velocity knee=1e200 => up to 1e+12, not
FOOT:: --angular-velocity 1e300,0,0 | --plane zx | --plane zx --slide => up to 1e+12, not
FOOT:: --speed 1e-300 => it has to lie between 1e-09 and 1e+09 m/s
FOOT:: --velocity 0,0,-1 --speed 2 | --velocity 0,0,-1 --drop-height 1 | --drop-height 1 --speed 10 => is given in two ways
FOOT:: --base fixed --angular-velocity 0,2,0 => a fixed base cannot turn at 2 rad/s
FOOT:: --base planar --angular-velocity 1,3,0 => a planar base cannot turn at 1 rad/s across the plane's normal (0, -1, 0)
FOOT:: --plane 0,0,0 => a plane's normal needs a finite length above zero
FOOT:: --plane xy --strike-angle 181 => a strike angle of 181 deg is not valid; it must lie in [-180, 180] deg
FOOT:: --plane xy --strike-angle 10 | --plane 0,0,-2 --strike-angle=-0.5 => no strike angle is defined in a horizontal plane
FOOT:: --armature knee=-1 | --rotor knee=1e-4:9:0 | --joint-stiffness knee=0 => has to be above zero and at most 1e+12
FOOT:: --armature root_joint=1 | --lock root_joint => joint "root_joint" of robot "stick" floats, so it has no drive
FOOT:: --joints locked --armature knee=0.1 => is locked, so a reflected inertia or a spring changes nothing there
FOOT:: --rotor knee=1e-4 => has no gear ratio, and none is read of this joint from the file; add it: --rotor knee=INERTIA:RATIO
FOOT:: --rotor knee=1:2:3:4 => is not JOINT=INERTIA[:RATIO[:STIFFNESS]]
FOOT:: --rotor knee=1:2:cycloid => gears are planetary, belt, harmonic, spur
FOOT:: --pulse square:5ms => there is no pulse shape "square"; valid are half-sine, saw-tooth, haversine, rectangle
FOOT:: --pulse half-sine:0ms | --pulse half-sine:1e300ms => a pulse has a length from 1e-09 to 1000 s, not "
FOOT:: --pulse half-sine => "" is not the length of a pulse
FOOT:: --no-gravity => has an effect only on contacts of finite stiffness; give contact_stiffness too
FOOT:: --range-g 16 => a sensor's range needs accelerations; give a pulse
FOOT:: --drives nosuch.toml => no drives file "HERE/nosuch.toml"
FOOT:: --stance foot => coincide: they are the same point of the same body; remove one
FOOT:: --lock knee --base fixed => nothing of robot "stick" can move: its base is fixed and no joint is free
analyze leg:: --contct heel => no such option: --contct (Possible options: --contact,
analyze leg:: --contact => option '--contact' requires an argument
analyze leg:: heel => unexpected extra argument(s) (heel)
analyze leg --contact heel:: --format yaml => 'yaml' is not one of 'table', 'json', 'csv', 'markdown'
analyze leg --contact heel:: --base loose => 'loose' is not one of 'free', 'planar', 'fixed'
analyze leg --contact heel:: --contact-point deepest => 'deepest' is not one of 'auto', 'frame', 'lowest'
analyze dog/dog.urdf.xacro --package dog_description=dog --contact lf_foot:: --xacro paylod:=2 => "paylod"; nearest: "payload"
robots:: leg --xacro mas:=3 => has no xacro argument "mas"; nearest: "mass"
analyze => missing argument 'ROBOT'. To see what is valid: shockpc analyze --help
:: stick.urdf | anymal_b | fly | analyse stick.urdf => To analyze a robot: shockpc analyze ROBOT --contact NAME. To see
FOOT:: --all --format json | --all --format markdown => --all is for tables on a terminal and has no effect on --format
FOOT:: --body shin --format json => selects the bodies of tables and CSV files, but JSON has every body
FOOT:: --force => lets --save-scene replace a file; give --save-scene too
SWEEP:: --set knee=3 | --set *nee=3 => nee has no effect, because the value varies from landing to landing
sweep stick.urdf --contact foot:: --sample 3 --set knee=3 => --set knee has no effect
sweep stick.urdf --contact foot --vary speed=1,2:: --speed 3 => --speed has no effect, because the value varies
sweep stick.urdf --vary contact=foot,shin:: --contact foot => --contact has no effect
sweep stick.urdf --contact foot --vary base-pitch=0,5:: --base-rpy 1,2,0 => --base-rpy has no effect
sweep stick.urdf --contact foot --vary offset-x=0,0.1:: --offset 0.1,0,0.1 => --offset has no effect
sweep stick.urdf --contact foot --vary armature:knee=0.1,0.2:: --armature knee=0.1 => --armature knee has no effect
place stick.urdf --contact foot --vary strike-angle=0,9:: --strike-angle 3 => --strike-angle has no effect
SWEEP:: --contact-stiffness 1e5 --quantity peak_force@foot --range-g 4 => no number here depends on --range-g
limits stick.urdf --contact foot --joint knee --at body --max 0.2:: --pulse half-sine:5ms --range-g 4 => no number here depends on
SWEEP:: --pulse half-sine:5ms | --pulse half-sine:5ms --quantity shock@body => no number here depends on --pulse
batch stick.urdf --contact foot:: --pulse half-sine:5ms | --pulse half-sine:5ms --rank mass => add a quantity such as peak_g
compare stick.urdf --contact foot --change mass:shin=0.9x:: --part knee="5 N m" => no number here depends on --part
limits stick.urdf --contact foot --joint knee --at body --max 0.2:: --pulse half-sine:5ms => no number here depends on --pulse
recorded log.csv stick.urdf --contact foot:: --part knee="5 N m" --quantity delta_v@body => add a quantity such as part_margin
sensitivity stick.urdf --contact foot --at body --vary mass:*=0.9x:1.1x:: --group shin => leave one of the two out
recorded scenes:: --contact-stiffness 1e5 => shockpc batch scenes/*.toml
recorded log.csv stick.urdf --contact foot:: --contact-stiffness 1e5 => a contact stiffness, which would change nothing here
SWEEP:: --rows csv => --rows csv is the format of files, and needs a folder: --out DIR
SWEEP:: --wait => waits for the workers of a cluster; give its address with --cluster
SWEEP:: --jobs 2 --cluster tcp://host:8786 => --jobs 2 is for this machine, but a cluster computes
recorded log.csv stick.urdf --contact foot:: --command 1 --out out | --command 1 --format json => prints only the scene of one landing
robots:: --xacro mass:=3 | --meshes . | --package dog=dog => are for the files of one robot; name it
schema:: landing.toml => 'landing.toml' is not one of 'scene', 'budgets'
robots:: --posture x => no such option: --posture. To see what is valid: shockpc robots --help
robots:: dgo => no robot "dgo"; nearest: "go2", "go1"
"""

SWEEP = "sweep stick.urdf --contact foot --vary knee=10,20"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("reason", "words"),
    commands(
        COMMANDS, STICK="analyze stick.urdf", FOOT="analyze stick.urdf --contact foot", SWEEP=SWEEP
    ),
)
def test_commands_that_cannot_be_run(capfd, here, reason, words):
    """A message has the option or the name, what was typed, and what would be valid."""
    (here / "log.csv").write_text("knee\n0.1\n")
    (here / "scenes").mkdir()
    (here / "scenes" / "one.toml").write_text('robot = "../stick.urdf"\ncontact = "foot"\n')
    assert contains(refusal(capfd, here, *words), reason)


def test_an_option_is_named_once_if_several_of_its_numbers_vary(capfd, here):
    varied = ("--vary", "base-pitch=0,5", "--vary", "base-roll=0,5")
    landing = ("stick.urdf", "--contact", "foot", "--base-rpy", "1,2,0")
    message = refusal(capfd, here, "sweep", *landing, *varied)
    assert message.startswith("--base-rpy has no effect")


SCENES = {
    "[joints]\nrotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } }": 'the reflected inertia of "knee" is 1e+36',
    "[joints]\nrotor = { knee = { inertia = 1, gear_ratio = 1 } }\narmature = { knee = 2 }": "an armature and a rotor",
    "[strike]\nvelocity = [0, 0, -1]\nspeed = 1": "the contact velocity is given in two ways; "
    "keep one of",
    "[posture]\nbase_rpy_deg = [0, 0, 0]\nbase_quaternion = [0, 0, 0, 1]": "the base is turned twice",
    "[posture]\nbase_quaternion = [0, 0, 0, 3]": "base_quaternion has length 3",
    "[[contact]]\nframe = 'foot'\ndirections = []": 'contact "foot" keeps no direction',
    "[[contact]]\nframe = 'foot'\ndirections = ['x']": "keeps only directions along the ground",
    "[[contact]]\nframe = 'foot'\ndirections = ['z', [0, 0, 0]]": "has a direction without a length",
    'stance = ["body", "body"]': 'stance "body" and stance "body" coincide',
    'stance = ["ankle"]': 'contact "foot" and stance "ankle" coincide',
    f"stance = {['foot'] * 100}": "the scene has 101 contacts, and up to 100 are computed; leave some of them out",
    "[[point]]\nframe = 'foot'\n" * 1001: "the scene has 1001 points, and up to 1000 are computed",
    "[[part]]\nname = 'board'\nat = 'foot'\nrating = '50g@2ms'\n"
    * 1001: "the scene has 1001 parts, and up to 1000 are computed",
    'srdf = "~nobody-of-that-name/r.srdf"': "begins with the home of a user whom this computer does not have",
    'srdf = "r\\u0000.srdf"': "it holds a NUL character",
    **dict.fromkeys(
        (f"x = {'[' * 2000}{']' * 2000}", f"a{'.a' * 100_000} = 1", f"x = {'1' * 5000}"),
        "twice.toml holds an integer of thousands of digits, or tables or keys nested too deep",
    ),
}


@pytest.mark.parametrize("lines", SCENES, ids=lambda lines: lines[:60])
def test_scene_files(capfd, here, lines):
    """Values that are valid alone, but not together; paths that no file has, TOML that exceeds the
    reader.
    """
    contact = "" if "[[contact]]" in lines else '[[contact]]\nframe = "foot"\n'
    (here / "twice.toml").write_text(f'robot = "stick.urdf"\n{lines}\n{contact}')
    assert contains(refusal(capfd, here, "analyze", "twice.toml"), SCENES[lines])


# Files to write


PLACES = """
FOOT:: --out stick.urdf | --out stick.urdf/a/b | --save-scene stick.urdf/landing.toml => nothing can be written in folder "stick
FOOT:: --out '' => the path is empty; give a name
FOOT:: --out ~nobody-of-that-name/out => begins with the home of a user whom this computer does not have
FOOT:: --save-scene away/landing.toml => there is no folder "away" for --save-scene
FOOT:: --save-scene '' | --save-scene dog | --save-scene dog/dog.srdf => would not be read as a scene, whose name ends in .toml
FOOT:: --save-scene stick.urdf --force | --save-scene new.urdf --force | --save-scene new.xml => would not be read as a scene
FOOT:: --save-scene new.urdf.xacro --force | --save-scene new.XACRO => would not be read as a scene
FOOT:: --save-scene away/new.mjcf => would not be read as a scene, whose name ends in .toml
"""


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        *commands(PLACES, FOOT="analyze stick.urdf --contact foot"),
        pytest.param(
            "File name too long; name another with --out", [*LANDING, "--out", "x" * 256], id="long"
        ),
    ],
)
def test_places_that_cannot_be_written(capfd, here, reason, words):
    assert contains(refusal(capfd, here, *words), reason)


def test_folders_whose_name_is_not_utf_8(capfd, here, monkeypatch):
    """A JSON document cannot hold such a name: nothing is written there, also if it is the current
    folder.
    """
    odd = here / os.fsdecode(b"b\xff")
    odd.mkdir()
    (odd / "stick.urdf").write_text(STICK)
    for words in (("--out", odd / "out"), ("--save-scene", odd / "landing.toml")):
        assert contains(refusal(capfd, here, *LANDING, *words), words[0], "\\xff", "UTF-8")
    assert contains(
        refusal(capfd, here, "analyze", odd / "stick.urdf", "--contact", "foot"), "\\xff", "UTF-8"
    )
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
    monkeypatch.setattr(
        tempfile,
        "TemporaryFile",
        Mock(side_effect=PermissionError(errno.EACCES, os.strerror(errno.EACCES))),
    )
    monkeypatch.setattr(
        shockpc.profile,
        "shock_profile",
        Mock(side_effect=AssertionError("computed before the folder was tried")),
    )
    place, folder = ("locked", "locked") if option == "--out" else ("landing.toml", ".")
    assert contains(
        refusal(capfd, here, *LANDING, option, place), f'"{folder}"', "Permission denied", option
    )


def test_files_of_others_are_not_replaced(capfd, here):
    """--save-scene replaces a file with --force only, and with several landings none of them is
    replaced.
    """
    good(capfd, *LANDING, "--save-scene", "landing.toml")
    before = (here / "landing.toml").read_bytes()
    assert contains(
        refusal(capfd, here, *LANDING, "--speed", "2", "--save-scene", "landing.toml"),
        '"landing.toml"',
        "--force",
    )
    assert (here / "landing.toml").read_bytes() == before
    good(
        capfd, "analyze", "landing.toml", "--speed", "2", "--save-scene", "landing.toml", "--force"
    )
    assert read_scene(here / "landing.toml").strike.speed == 2.0
    (here / "feet.shin.toml").write_text("mine")
    message = refusal(
        capfd, here, "analyze", "stick.urdf", "--contact", "*", "--save-scene", "feet.toml"
    )
    assert contains(message, '"feet.shin.toml"', "--force")


def test_no_file_of_a_report_without_verdict(capfd, here, monkeypatch):
    """A number that only the report computes may have no verdict; then neither the scene nor a
    folder is written.
    """
    monkeypatch.setattr(Report, "text", Mock(side_effect=SolveError("no verdict: terms cancel")))
    outcome = run(capfd, *LANDING, "--save-scene", "landing.toml", "--out", "results")
    assert outcome.code == SolveError.exit_code
    assert contains(outcome.err, "no verdict: terms cancel")
    assert not (here / "landing.toml").exists()
    assert not (here / "results").exists()


@pytest.mark.parametrize(
    "words", [LANDING, ("analyze", "landing.toml")], ids=lambda words: words[1]
)
def test_files_that_cannot_be_read(here, words):
    """In a separate process, in which no file of the folder can be opened."""
    (here / "landing.toml").write_text('robot = "stick.urdf"\n')
    code = """
import errno, os, sys
def refuse(event, arguments):
    if event == "open" and os.path.basename(str(arguments[0])) in ("stick.urdf", "landing.toml"):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(arguments[0]))
sys.addaudithook(refuse)
from shockpc.cli.entry import entry
entry()
"""
    done = python(code, *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert contains(done.stderr, "shockpc: ", words[1], "Permission denied")


# Streams


RESULT, MISTAKE, HELP = (
    shlex.join([*SHOCKPC, *words])
    for words in ((*LANDING, "--explain"), ("analyze", "missing.urdf"), ("-h",))
)


def bash(line, folder, **options):
    """Run a line of bash in a folder."""
    return subprocess.run(
        ["bash", "-c", line], capture_output=True, text=True, cwd=folder, check=False, **options
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "code", "streams"),
    [
        *(
            (RESULT, 0, streams)
            for streams in ("2>&-", "2>/dev/full", ">/dev/null 2>&-", "<&-", "2>&1 | true")
        ),
        *((MISTAKE, 2, streams) for streams in ("2>&-", "2>/dev/full", "2>&1 | true")),
        (HELP, 0, "2>&1 | true"),
    ],
)
def test_exit_codes_do_not_depend_on_standard_error(here, command, code, streams):
    """Nobody can read a message there, but the command ends as ever; a reader who goes away is no
    error.
    """
    done = bash(f"{command} {streams}; exit ${{PIPESTATUS[0]}}", here)
    assert done.returncode == code
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("streams", "reason"), [(">/dev/full", "No space left on device"), (">&-", "closed")]
)
def test_standard_output_that_cannot_be_written(here, streams, reason):
    done = bash(f"{RESULT} {streams}", here)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("shockpc: standard output ")
    assert reason in done.stderr


def test_output_does_not_depend_on_the_environment(here):
    """In a terminal that knows ASCII alone, and without a home, a locale or a terminal, it is the
    same text in UTF-8.
    """
    # Kernels for other processors round differently, which the last line reports.
    needed = {
        name: value
        for name, value in os.environ.items()
        if name in ("PATH", "PYTHONPATH", "OPENBLAS_CORETYPE")
    }
    coded = [environment({"PYTHONIOENCODING": code}) for code in ("utf-8", "ascii")]
    normal, *others = [
        bash(shlex.join([*SHOCKPC, *LANDING]), here, env=given, encoding="utf-8")
        for given in (*coded, needed)
    ]
    assert "…" in normal.stdout
    for done in (normal, *others):
        assert Outcome(done.returncode, done.stdout, done.stderr) == Outcome(0, normal.stdout, "")


# Interruptions


STOPPED = "shockpc: interrupted; no incomplete file was left\n"


@pytest.mark.parametrize("options", [("--out", "results"), ("--save-scene", "landing.toml")])
@pytest.mark.parametrize("place", ["shockpc.profile.shock_profile", "pathlib.Path.replace"])
def test_interrupted_runs_leave_no_file(capfd, here, monkeypatch, options, place):
    """Neither while it computes nor in the middle of writing, when a file is complete but does not
    have its name yet.
    """
    monkeypatch.setattr(place, Mock(side_effect=KeyboardInterrupt))
    before = {path for path in here.rglob("*") if path.is_file()}
    assert run(capfd, *LANDING, *options) == Outcome(130, "", STOPPED)
    assert {path for path in here.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_from_outside(here, number, code):
    """Ctrl-C and SIGTERM end a command in the same way, with the exit codes that shells give them."""
    assert interrupted(here, number, *LANDING) == Outcome(code, "", STOPPED)


@pytest.mark.slow
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
    """A bug shows where it is, and ends with 70: 1 would mean a budget that is exceeded, 3 no
    verdict.
    """
    monkeypatch.setattr(
        shockpc.profile,
        "shock_profile",
        Mock(side_effect=ZeroDivisionError("not caused by the user")),
    )
    outcome = run(capfd, *LANDING)
    assert outcome._replace(err="") == Outcome(70, "", "")
    lines = outcome.err.splitlines()
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-2] == "ZeroDivisionError: not caused by the user"
    assert contains(lines[-1], "shockpc: ", "error in shockpc itself", "report")
