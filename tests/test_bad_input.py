"""What a user can get wrong: one message on standard error, its exit code, and no file left behind.

The messages are in the snapshots, each as a whole: what was found, what it means, and what would be valid.
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
from shockpc.show.reports.report import Report

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
    return [part for part in parts if part not in message] == []


def commands(text):
    """Command lines as parameters: each line of the text is the beginning of a command, ::, and its ends with | between."""
    lines = [line.partition(":: ") for line in text.strip().splitlines()]
    words = [f"{begin} {end}".strip() for begin, _, ends in lines for end in ends.split(" | ")]
    return [pytest.param(shlex.split(line), id=line) for line in words]


# Robot files


FILES = {
    "empty.urdf": "",
    "broken.urdf": "<robot name='r'>\n  <link name='a'>\n</robot>\n",
    "macros.urdf.xacro": xacro('<xacro:macro name="leg" params=""/>'),
    "gapped.urdf": STICK.replace('parent link="body"', 'parent link="bdy"'),
    "light.urdf": urdf(link("body"), link("shin", mass="1e-19"), joint("knee", "body", "shin")),
}
"""One for each reason; the others are in the tests of readers."""

NO_FILES = ["missing.urdf", "away/robot", "dog", "anymal", "./dog", "", "~nobody-of-that-name/robot.urdf"]


@pytest.mark.parametrize("name", [*NO_FILES, "x" * 300, "x" * 300 + ".urdf", *FILES], ids=lambda name: name[:40])
def test_robot_files(capfd, here, snapshot, name):
    """A file that holds no robot is refused by both commands that read one, in the same words."""
    if name in FILES:
        (here / name).write_text(FILES[name])
    message = refusal(capfd, here, "robots", name)
    assert message == snapshot
    assert refusal(capfd, here, "analyze", name, "--contact", "shin").replace("analyze --help", "robots --help") == message


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        ("romeo_laas_small --contact l_sole", ('"l_gripper"', '"r_gripper"', '"RomeoH37"', "--lock")),
        ("stick.urdf --contact foot --base fixed", ("no verdict", 'posture "neutral"', "1 m/s", "(0 0 1)", "free the base")),
    ],
)
def test_models_that_cannot_be_solved(capfd, here, words, parts):
    """Bodies that move without mass, and a posture in which the mechanism cannot give way, have no result and are named."""
    assert contains(refusal(capfd, here, "analyze", *words.split(), code=3), *parts)


MODELS = {
    "arm.xml": mjcf('<body name="post">' + body("arm") + "</body>"),
    "dog.xml": mjcf(floating()),
    "srdf.toml": 'robot = "dog.xml"\nsrdf = "dog/dog.srdf"\n[[contact]]\nframe = "base"\n',
}


@pytest.mark.parametrize(
    "words",
    commands("""
analyze:: dog.xml --contact base --srdf dog/dog.srdf | srdf.toml
analyze arm.xml:: --contact arm --base free | --contact post | --contact arm --stance post | --contact arm --base-rpy 0,0,0
"""),
)
def test_models_from_mjcf(capfd, here, snapshot, words):
    """A base that its file fixes cannot be freed or placed, and cannot strike; postures that nothing reads are refused."""
    for name, text in MODELS.items():
        (here / name).write_text(text)
    assert refusal(capfd, here, *words) == snapshot


# Names and values


COMMANDS = """
analyze stick.urdf:: --contact wheel | --contact fot | --contact *_paw | --contact foot+ | --contact foot+foot | --contact ''
FOOT:: --at nose | --at body:1,2 | --at body: | --at body:1,2,x | --stance sole | --body shnk
FOOT:: --posture sitting | --set hip=3 | --set root_joint=3 | --set knee | --set knee= | --set =30 | --set knee=bent | --lock hip
FOOT:: --xacro payload:=2 | --xacro payload | --package dog=nowhere | --package dog=~nobody-of-that-name | --package dog
FOOT:: --srdf no.srdf | --srdf stick.urdf | --srdf '' | --offset 0,0 | --base-rpy 15 | --contact-point lowest
FOOT:: --strike-angle 90 | --strike-angle 120 | --strike-angle=-135 --speed 2 | --speed nan | --speed 0 | --speed=-1
FOOT:: --speed 1e308 | --speed 1e-300 | --velocity 0,0,0.31 | --velocity 0,0,0 | --velocity 0,-1 | --velocity 0,0,down
FOOT:: --velocity 0,0,-1e200 | --drop-height 0 | --drop-height 1e308 | --drop-height 1e999 | --joint-velocity knee=1e200
FOOT:: --velocity 0,0,-1 --speed 2 | --velocity 0,0,-1 --drop-height 1 | --drop-height 1 --speed 10 | --joint-velocity knee
FOOT:: --angular-velocity 1 | --angular-velocity 1e300,0,0
FOOT:: --base fixed --angular-velocity 0,2,0 | --base planar --angular-velocity 1,3,0
FOOT:: --plane zx | --plane zx --slide | --plane 0,1 | --plane 0,0,0 | --plane xy --strike-angle 181
FOOT:: --plane xy --strike-angle 10 | --plane 0,0,-2 --strike-angle=-0.5 | --restitution 1.5 | --restitution=-0.1
FOOT:: --armature knee | --armature knee=-1 | --armature root_joint=1 | --joints locked --armature knee=0.1
FOOT:: --pulse square:5ms | --pulse half-sine:0ms | --pulse half-sine | --range-g 16 | --range-g=-1
FOOT:: --pulse half-sine:5ms --range-g 0 | --offset 0.1,0,0 --joint-velocity knee=-99 | --drives nosuch.toml
FOOT:: --rotor knee=1e-4 | --rotor knee=1:2:3:4 | --rotor knee=1e-4:9:0 | --joint-stiffness knee=0 | --rotor knee=light
FOOT:: --stance foot | --lock root_joint | --lock knee --base fixed
analyze leg:: --contct heel | --contact | heel
analyze leg --contact heel:: --format yaml | --base loose | --contact-point deepest
analyze dog/dog.urdf.xacro --package dog_description=dog --contact lf_foot:: --xacro paylod:=2
:: analyze | stick.urdf | anymal_b | analyse stick.urdf | fly | schema landing.toml | robots --posture x
robots:: dgo | leg --xacro mas:=3 | leg --xacro mass | leg --package dog | leg --package dog=/nowhere
""".replace("FOOT", "analyze stick.urdf --contact foot")


@pytest.mark.parametrize("words", commands(COMMANDS))
def test_commands_that_cannot_be_run(capfd, here, snapshot, words):
    """A message has the option or the name, what was typed, and what would be valid."""
    assert refusal(capfd, here, *words) == snapshot


SCENES = [
    "[joints]\nrotor = { knee = { inertia = 1e12, gear_ratio = 1e12 } }",
    "[joints]\nrotor = { knee = { inertia = 1, gear_ratio = 1 } }\narmature = { knee = 2 }",
    "[strike]\nvelocity = [0, 0, -1]\nspeed = 1",
    "[posture]\nbase_rpy_deg = [0, 0, 0]\nbase_quaternion = [0, 0, 0, 1]",
    "[posture]\nbase_quaternion = [0, 0, 0, 3]",
    *(f"[[contact]]\nframe = 'foot'\ndirections = {directions}" for directions in ("[]", "['x']", "['z', [0, 0, 0]]")),
    'stance = ["body", "body"]',
    'stance = ["ankle"]',
    'srdf = "~nobody-of-that-name/r.srdf"',
    'srdf = "r\\u0000.srdf"',
    f"x = {'[' * 2000}{']' * 2000}",
    f"a{'.a' * 100_000} = 1",
    f"x = {'1' * 5000}",
]


def test_scene_files(capfd, here, snapshot):
    """Values that are valid alone, but not together; paths that no file has, TOML that exceeds the reader."""
    messages = []
    for lines in SCENES:
        contact = "" if "[[contact]]" in lines else '[[contact]]\nframe = "foot"\n'
        (here / "twice.toml").write_text(f'robot = "stick.urdf"\n{lines}\n{contact}')
        messages.append(refusal(capfd, here, "analyze", "twice.toml"))
    assert messages == snapshot


# Files to write


PLACES = """
LANDING:: --out stick.urdf | --out stick.urdf/a/b | --out '' | --out ~nobody-of-that-name/out
LANDING:: --save-scene '' | --save-scene dog | --save-scene away/landing.toml | --save-scene stick.urdf/landing.toml
LANDING:: --save-scene dog/dog.srdf | --save-scene stick.urdf --force | --save-scene new.urdf --force
LANDING:: --save-scene new.urdf.xacro --force | --save-scene new.XACRO | --save-scene new.xml | --save-scene away/new.mjcf
""".replace("LANDING", " ".join(LANDING))


@pytest.mark.parametrize("words", [*commands(PLACES), pytest.param([*LANDING, "--out", "x" * 256], id="long")])
def test_places_that_cannot_be_written(capfd, here, snapshot, words):
    assert refusal(capfd, here, *words) == snapshot


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
    monkeypatch.setattr(tempfile, "TemporaryFile", Mock(side_effect=PermissionError(errno.EACCES, os.strerror(errno.EACCES))))
    monkeypatch.setattr(shockpc.profile, "shock_profile", Mock(side_effect=AssertionError("computed before the folder was tried")))
    place, folder = ("locked", "locked") if option == "--out" else ("landing.toml", ".")
    assert contains(refusal(capfd, here, *LANDING, option, place), f'"{folder}"', "Permission denied", option)


def test_files_of_others_are_not_replaced(capfd, here):
    """--save-scene replaces a file with --force only, and with several landings none of them is replaced."""
    good(capfd, *LANDING, "--save-scene", "landing.toml")
    before = (here / "landing.toml").read_bytes()
    assert contains(refusal(capfd, here, *LANDING, "--speed", "2", "--save-scene", "landing.toml"), '"landing.toml"', "--force")
    assert (here / "landing.toml").read_bytes() == before
    good(capfd, "analyze", "landing.toml", "--speed", "2", "--save-scene", "landing.toml", "--force")
    assert read_scene(here / "landing.toml").strike.speed == 2.0
    (here / "feet.shin.toml").write_text("mine")
    message = refusal(capfd, here, "analyze", "stick.urdf", "--contact", "*", "--save-scene", "feet.toml")
    assert contains(message, '"feet.shin.toml"', "--force")


def test_no_file_of_a_report_without_verdict(capfd, here, monkeypatch):
    """A number that only the report computes may have no verdict; then neither the scene nor a folder is written."""
    monkeypatch.setattr(Report, "text", Mock(side_effect=SolveError("no verdict: terms cancel")))
    outcome = run(capfd, *LANDING, "--save-scene", "landing.toml", "--out", "results")
    assert outcome.code == SolveError.exit_code
    assert contains(outcome.err, "no verdict: terms cancel")
    assert not (here / "landing.toml").exists()
    assert not (here / "results").exists()


@pytest.mark.parametrize("words", [LANDING, ("analyze", "landing.toml")], ids=lambda words: words[1])
def test_files_that_cannot_be_read(here, words):
    """In a process of its own, in which no file of the folder can be opened."""
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


@pytest.mark.parametrize("name", ["stick.toml", "stick"])
def test_pipes_are_not_waited_for(capfd, here, name):
    """Neither as a scene nor as a robot."""
    os.mkfifo(here / name)
    assert contains(refusal(capfd, here, "analyze", f"./{name}", "--contact", "foot"), name, "pipe")


# Streams


RESULT, MISTAKE, HELP = (
    shlex.join([*SHOCKPC, *words]) for words in ((*LANDING, "--explain"), ("analyze", "missing.urdf"), ("-h",))
)


def bash(line, folder, **options):
    """Run a line of bash in a folder."""
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, cwd=folder, check=False, **options)


@pytest.mark.parametrize("streams", ["2>&-", "2>/dev/full", ">/dev/null 2>&-", "<&-", "2>&1 | true"])
@pytest.mark.parametrize(("command", "code"), [(RESULT, 0), (MISTAKE, 2), (HELP, 0)], ids=["result", "mistake", "help"])
def test_exit_codes_do_not_depend_on_standard_error(here, streams, command, code):
    """Nobody can read a message there, but the command ends as ever; a reader who goes away is no error."""
    done = bash(f"{command} {streams}; exit ${{PIPESTATUS[0]}}", here)
    assert done.returncode == code
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(("streams", "reason"), [(">/dev/full", "No space left on device"), (">&-", "closed")])
def test_standard_output_that_cannot_be_written(here, streams, reason):
    done = bash(f"{RESULT} {streams}", here)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("shockpc: standard output ")
    assert reason in done.stderr


def test_output_does_not_depend_on_the_environment(here):
    """In a terminal that knows ASCII alone, and without a home, a locale or a terminal, it is the same text in UTF-8."""
    # Kernels for other processors round differently, which the last line reports.
    needed = {name: value for name, value in os.environ.items() if name in ("PATH", "PYTHONPATH", "OPENBLAS_CORETYPE")}
    coded = [environment({"PYTHONIOENCODING": code}) for code in ("utf-8", "ascii")]
    normal, *others = [bash(shlex.join([*SHOCKPC, *LANDING]), here, env=given, encoding="utf-8") for given in (*coded, needed)]
    assert "…" in normal.stdout
    for done in (normal, *others):
        assert Outcome(done.returncode, done.stdout, done.stderr) == Outcome(0, normal.stdout, "")


# Interruptions


STOPPED = "shockpc: interrupted; no incomplete file was left\n"


@pytest.mark.parametrize("options", [("--out", "results"), ("--save-scene", "landing.toml")])
@pytest.mark.parametrize("place", ["shockpc.profile.shock_profile", "pathlib.Path.replace"])
def test_interrupted_runs_leave_no_file(capfd, here, monkeypatch, options, place):
    """Neither while it computes nor in the middle of writing, when a file is complete but does not have its name yet."""
    monkeypatch.setattr(place, Mock(side_effect=KeyboardInterrupt))
    before = {path for path in here.rglob("*") if path.is_file()}
    assert run(capfd, *LANDING, *options) == Outcome(130, "", STOPPED)
    assert {path for path in here.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_from_outside(here, number, code):
    """Ctrl-C and SIGTERM end a command in the same way, with the exit codes that shells give them."""
    assert interrupted(here, number, *LANDING) == Outcome(code, "", STOPPED)


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
    """A bug shows where it is, and ends with 70: 1 would mean a budget that is exceeded, 3 no verdict."""
    monkeypatch.setattr(shockpc.profile, "shock_profile", Mock(side_effect=ZeroDivisionError("not caused by the user")))
    outcome = run(capfd, *LANDING)
    assert outcome._replace(err="") == Outcome(70, "", "")
    lines = outcome.err.splitlines()
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-2] == "ZeroDivisionError: not caused by the user"
    assert contains(lines[-1], "shockpc: ", "error in shockpc itself", "report")
