"""No command writes over, or removes, a file that it reads: every form of input, in the place of an
output.
"""

import os
import shutil
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from commands import ROBOTS, STICK, good, run

LANDINGS = {"knee": np.array([0.1, 0.2, 0.3]), "vz": np.array([-1.0, -1.2, -0.9])}
CSV = "knee,vz\n0.1,-1\n0.2,-1.2\n"
DRIVES = '[[drive]]\njoint = ["knee"]\narmature = 0.01\nsource = "measured"\n'
BUDGET = (
    '[[case]]\nname = "land"\nscene = "{}"\n\n[[budget]]\nat = "body"\nmetric = "shock"\nmax = 5\n'
)
LANDING = '{}\n[[contact]]\nframe = "foot"\n'
CASES = {
    "urdf": 'robot = "robot.urdf"\nsrdf = "robot.srdf"',
    "xacro": 'robot = "robot.urdf.xacro"',
    "mjcf": 'robot = "robot.xml"',
    "geared": 'robot = "robot.urdf"\n[joints]\ndrives = "drives.toml"',
}
"""Scenes of robots in each format, in the folder of the stick."""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a robot in each format, its meshes, scenes, budgets, drives and recorded
    landings.
    """
    folder = Path(shutil.copytree(ROBOTS / "stick", tmp_path / "stick"))
    for name, text in CASES.items():
        (folder / f"{name}.toml").write_text(LANDING.format(text))
        (folder / f"{name}-budgets.toml").write_text(BUDGET.format(f"{name}.toml"))
    (folder / "drives.toml").write_text(DRIVES)
    (folder / "plain.urdf").write_text(STICK)
    (folder / "table.csv").write_text(CSV)
    np.savez(folder / "table.npz", **LANDINGS)
    pyarrow.parquet.write_table(pyarrow.table(LANDINGS), folder / "table.parquet")
    (folder / "log.csv").write_text(
        "time,z,knee\n" + "".join(f"{0.001 * k},1,0\n" for k in range(99))
    )
    (folder / "scenes").mkdir()
    (folder / "scenes" / "jump.toml").write_text(LANDING.format('robot = "../plain.urdf"'))
    monkeypatch.chdir(folder)
    return folder


FILES = {
    "budgets": ("urdf-budgets.toml", "urdf", ()),
    "scene": ("urdf.toml", "urdf", ()),
    "URDF": ("robot.urdf", "urdf", ()),
    "SRDF": ("robot.srdf", "urdf", ()),
    "visual mesh": ("part.stl", "urdf", ("--out", "out")),
    "collision mesh": ("part.obj", "urdf", ("--out", "out")),
    "package": ("package.xml", "urdf", ("--out", "out")),
    "xacro": ("robot.urdf.xacro", "xacro", ()),
    "xacro include": ("macros.xacro", "xacro", ()),
    "xacro YAML": ("values.yaml", "xacro", ()),
    "MJCF": ("robot.xml", "mjcf", ()),
    "MJCF include": ("more.xml", "mjcf", ()),
    "MJCF mesh that weighs": ("part.stl", "mjcf", ()),
    "drives": ("drives.toml", "geared", ()),
    "baseline": ("baseline.json", "urdf", ("--baseline", "baseline.json")),
}
"""What a check reads: the file, the case, and further words of the command."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "again", [False, True], ids=["first command", "second command of a process"]
)
@pytest.mark.parametrize("form", FILES)
def test_no_file_of_a_check_is_replaced(capfd, here, form, again):
    """--format json=FILE may name any file; robots, meshes and drives of an earlier command are
    kept in memory, but are inputs.
    """
    file, case, more = FILES[form]
    if form == "baseline":
        good(
            capfd,
            "check",
            f"{case}-budgets.toml",
            *more,
            "--update-baseline",
            "--format",
            "table=first.txt",
        )
    elif again:
        run(capfd, "check", f"{case}-budgets.toml", "--out", "before")
    before = (here / file).read_bytes()
    for name in (file, "link.json", "other.json"):
        if name == "link.json":
            (here / name).symlink_to(file)
        elif name == "other.json":
            os.link(here / file, here / name)
        outcome = run(capfd, "check", f"{case}-budgets.toml", *more, "--format", f"json={name}")
        assert (outcome.code, (here / file).read_bytes()) == (2, before), outcome.err
        assert f'"{name}" is read by the same command' in outcome.err


def test_budgets_are_not_the_summary_of_a_job(capfd, here, monkeypatch):
    before = (here / "urdf-budgets.toml").read_bytes()
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "urdf-budgets.toml")
    assert run(capfd, "check", "urdf-budgets.toml", "--format", "github").code == 2
    assert (here / "urdf-budgets.toml").read_bytes() == before


def with_srdf(file: object) -> str:
    """A scene of a robot with this file of postures."""
    scene = f'robot = "plain.urdf"\nsrdf = "{file}"\n[[contact]]\nframe = "foot"\n'
    Path("with_srdf.toml").write_text(scene)
    return "with_srdf.toml"


LAND = ("--contact", "foot")
TABLE = ("plain.urdf", *LAND, "--prove", 0)
OUT = ("--out", "out")
COMMANDS = {
    "table as CSV": ("table.csv", "landings.csv", lambda file: ("recorded", file, *TABLE)),
    "table as NPZ": ("table.npz", "landings.csv", lambda file: ("recorded", file, *TABLE)),
    "table as Parquet": ("table.parquet", "recorded.json", lambda file: ("recorded", file, *TABLE)),
    "table of several processes": (
        "table.csv",
        "recorded.svg",
        lambda file: ("recorded", file, *TABLE, "--jobs", 2),
    ),
    "robot of a table": (
        "plain.urdf",
        "report.md",
        lambda file: ("recorded", "table.csv", file, *TABLE[1:]),
    ),
    "analyze": ("plain.urdf", "bodies.csv", lambda file: ("analyze", file, *LAND)),
    "analyze a scene": ("urdf.toml", "profile.json", lambda file: ("analyze", file)),
    "analyze a case": ("urdf-budgets.toml", "shock.svg", lambda file: ("analyze", f"{file}:land")),
    "SRDF": (
        "robot.srdf",
        "joints.csv",
        lambda file: ("analyze", with_srdf(file)),
    ),
    "drives": (
        "drives.toml",
        "report.html",
        lambda file: ("analyze", "plain.urdf", *LAND, "--drives", file),
    ),
    "mesh": ("part.stl", "shock.png", lambda _: ("analyze", "robot.urdf", *LAND)),
    "batch": ("plain.urdf", "batch.csv", lambda file: ("batch", file, "robot.xml")),
    "batch of several processes": (
        "plain.urdf",
        "batch.csv",
        lambda file: ("batch", file, "robot.xml", "--jobs", 2),
    ),
    "compare": ("plain.urdf", "compare.svg", lambda file: ("compare", file, "robot.urdf", *LAND)),
    "limits": (
        "plain.urdf",
        "postures.csv",
        lambda file: ("limits", file, *LAND, "--joint", "knee", "--at", "body", "--max", 0.5),
    ),
    "sensitivity": (
        "plain.urdf",
        "report.md",
        lambda file: ("sensitivity", file, *LAND, "--at", "body"),
    ),
    "place": (
        "plain.urdf",
        "places.csv",
        lambda file: ("place", file, *LAND, "--body", "body", "--within", "0:0.1,0:0.1,0:0.1"),
    ),
    "bench": ("plain.urdf", "landing.md", lambda file: ("bench", file, *LAND)),
    "sweep": (
        "plain.urdf",
        "summary.md",
        lambda file: ("sweep", file, *LAND, "--vary", "knee=0:10:3", "--rows", "csv"),
    ),
    "touchdowns": (
        "log.csv",
        "touchdowns.csv",
        lambda file: ("touchdowns", file, "plain.urdf", *LAND),
    ),
}
"""The input, the output in its place, and the command on the input."""


@pytest.mark.slow
@pytest.mark.parametrize("form", COMMANDS)
def test_no_output_of_a_study_replaces_its_input(capfd, here, form):
    """An output of the study, in the folder of results, is another name of its input."""
    name, output, words = COMMANDS[form]
    before = (here / name).read_bytes()
    (here / "out").mkdir()
    os.link(here / name, here / "out" / output)
    outcome = run(capfd, *words(name), *OUT)
    assert outcome.code == 2, outcome
    assert f'"out/{output}" is read by the same command' in outcome.err
    assert (here / "out" / output).samefile(here / name)
    assert (here / name).read_bytes() == before


@pytest.mark.parametrize("name", ["landings.csv", "recorded.json", "report.md", "measured.csv"])
def test_an_input_in_the_folder_of_results_stays(capfd, here, name):
    """Refused where a result would have its name; kept where an earlier run could have left a
    result there.
    """
    (here / "out").mkdir()
    robot, table = (
        ("plain.urdf", f"out/{name}") if name.endswith(".csv") else (f"out/{name}", "table.csv")
    )
    (here / ("table.csv" if robot == "plain.urdf" else "plain.urdf")).rename(here / "out" / name)
    before = (here / "out" / name).read_bytes()
    outcome = run(capfd, "recorded", table, robot, *TABLE[1:], *OUT)
    assert outcome.code == (0 if name == "measured.csv" else 2), outcome
    assert (here / "out" / name).read_bytes() == before


@pytest.mark.slow
def test_a_second_run_without_measurements_leaves_none(capfd, here):
    """The files measured.* are results of `recorded`: those of an earlier table do not stay beside
    the new results.
    """
    (here / "measured.csv").write_text(
        "knee,before_knee,vz,after_knee\n0.1,0,-1,2\n0.2,0,-1.2,3\n0.3,0,-1.1,2.5\n"
    )
    of_measurements = {"measured.csv", "measured.svg", "measured.png"}
    for table, left in (("measured.csv", of_measurements), ("table.csv", set())):
        assert run(capfd, "recorded", table, *TABLE, *OUT).code == 0
        assert {path.name for path in (here / "out").glob("measured.*")} == left
        (here / "out" / "mine.csv").write_text("mine")
    assert (here / "out" / "mine.csv").read_text() == "mine"
    assert [path.name for path in (here / "out").glob(".*")] == [".recorded.sha256"]


def test_a_part_of_rows_is_no_link_to_an_input(capfd, here):
    """A folder that --resume continues, computed by other processes, which have not read the input."""
    words = ("sweep", "plain.urdf", *LAND, "--vary", "knee=0:10:3", "--rows", "parquet", *OUT)
    assert run(capfd, *words).code == 0
    before = (here / "plain.urdf").read_bytes()
    (part,) = (here / "out" / "rows").iterdir()
    part.unlink()
    part.symlink_to(here / "plain.urdf")
    outcome = run(capfd, *words, "--resume", "--jobs", 2)
    assert (outcome.code, (here / "plain.urdf").read_bytes()) == (2, before), outcome.err


@pytest.mark.parametrize(
    ("form", "name"),
    [("scene", "geared.toml"), ("drives", "drives.toml"), ("budgets", "urdf-budgets.toml")],
)
def test_a_saved_scene_replaces_a_scene_alone(capfd, here, form, name):
    """--force is for the scene that a command reads, not for another file of TOML that it reads."""
    before = (here / name).read_bytes()
    read = "urdf-budgets.toml:land" if form == "budgets" else "geared.toml"
    outcome = run(capfd, "analyze", read, "--speed", 2, "--save-scene", name, "--force")
    assert outcome.code == (0 if form == "scene" else 2), outcome.err
    assert ((here / name).read_bytes() == before) == (form != "scene")
