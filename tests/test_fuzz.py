"""Hostile inputs through the command line, a fixed few; `make fuzz` runs any number of them."""

import shutil
import subprocess
import sys
from pathlib import Path

import hostile
import pytest
from commands import ROBOTS, run

from shockpc.cli.app import COMMANDS


def fuzzed(*words):
    """What the fuzzer prints; a separate process, which forks."""
    command = [sys.executable, "fuzz.py", *words]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=Path(__file__).parent
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_hostile_inputs():
    """No traceback, crash, hang, incomplete file or exit code that means something else."""
    assert fuzzed("200", "--workers", "2").startswith("200 cases, 0 violated")


def test_every_command_gets_hostile_inputs():
    assert {line.split()[0] for line in hostile.COMMANDS} == set(COMMANDS)


def test_a_case_is_a_function_of_its_number(monkeypatch):
    """Tables are written anew for each case, so a case that is repeated by its number has the same
    bytes.
    """
    for folder in hostile.CONTINUED:
        monkeypatch.setitem(hostile.UNFINISHED, f"{folder}/rows.csv", b"1,2")
    for number in range(60):
        assert hostile.case(number) == hostile.case(number)


def test_a_command_leaves_nothing_to_the_next(capfd, tmp_path, monkeypatch):
    """The fuzzer's commands have a process each; in one process, what others have read or refused
    changes nothing.
    """
    monkeypatch.chdir(shutil.copytree(ROBOTS / "stick", tmp_path / "stick"))
    urdf, more = (
        "analyze robot.urdf --contact",
        ("foot --joints locked", "foot", "nothing", "arm --contact-point lowest --format json"),
    )
    lines = [
        "analyze scene.toml --all",
        "analyze robot.xml --contact foot",
        *(f"{urdf} {end}" for end in more),
    ]
    first = [run(capfd, *line.split()) for line in lines]
    assert [outcome.code for outcome in first] == [0, 0, 0, 0, 2, 0]
    assert [run(capfd, *line.split()) for line in reversed(lines)] == first[::-1]


@pytest.mark.parametrize("script", ["soak.py", "fuzz.py"])
def test_what_a_script_needs_is_named_where_it_is_missing(script: str):
    """A package of the tests that is not installed: exit code 2, the package and what installs it,
    no traceback.
    """
    path = str(Path(__file__).with_name(script))
    absent = (
        "import sys, runpy; sys.modules['numpy'] = None; sys.path.insert(0, "
        "sys.argv[1].rpartition('/')[0])"
    )
    done = subprocess.run(
        [sys.executable, "-c", f"{absent}; runpy.run_path(sys.argv[1], run_name='__main__')", path],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert (
        done.stderr.count("\n"),
        done.stderr.split()[0],
        "pip install '.[dev]'" in done.stderr,
    ) == (1, "numpy", True)
