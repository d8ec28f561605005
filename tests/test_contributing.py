"""The recipes of CONTRIBUTING.md, executed in a copy of the package."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import shockpc

ROOT = Path(__file__).parent.parent
PAGE = ROOT / ".github" / "CONTRIBUTING.md"
BLOCKS = re.findall(r"^```(\w+) ?([^\n]*)\n(.*?)^```", PAGE.read_text("utf-8"), re.M | re.S)

ROOMS = ("core", "robot", "method", "landing", "impact", "quantities", "judgement", "evaluation")


def test_the_house_is_that_of_the_package():
    """Each folder and module stands in the list, and those of the same line in the layers too."""
    (house,) = re.findall(r"^## The house\n\n```\n(.*?)```", PAGE.read_text("utf-8"), re.M | re.S)
    listed = re.findall(r"^([\w./]+(?:  [\w./]+)*)", house, re.MULTILINE)
    names = {name.rstrip("/") for line in listed for name in line.split()}
    folder = ROOT / "shockpc"
    rooms = {path.parent.name for path in folder.glob("*/__init__.py")} | {"profile.py"}
    assert names == rooms


@pytest.mark.slow
def test_each_recipe_works(tmp_path):
    """A quantity, a kind of variation, a study, and a wing with a format, which can be deleted."""
    copy = tmp_path / "shockpc"
    package = Path(shockpc.__file__).parent
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "robots", copy / "robots")
    printed = []
    for language, place, text in BLOCKS:
        if language == "python":
            write(tmp_path, place, text)
        elif language == "sh":
            printed += [run(tmp_path, line) for line in text.splitlines()]
    quantity, table, drops, masses, *_, ball = [done.stdout for done in printed if done.stdout]
    assert "length of Δv" in quantity
    assert table.count("\n") > 3
    (low, high) = re.findall(r"(?m)^delta_v@imu +m/s +([\d.]+) +[\d.]+ +([\d.]+)", drops)[0]
    assert float(high) == pytest.approx(2.0 * float(low), rel=1e-3)  # v = √(2 g h)
    above = [float(mass) for mass in re.findall(r"(?m)^\w+_foot\S* +([\d.]+) *$", masses)]
    assert above
    assert min(above) > 1.0
    assert "0.4 kg" in ball
    shutil.rmtree(copy / "wings" / "ball")
    refused = run(tmp_path, "shockpc robots ball.xml", code=2)
    assert refused.stderr.startswith("shockpc: ball.xml begins with <ball>")


def write(folder, place, text):
    """Write a file of a recipe, or insert its lines after a line of a file that is there."""
    path, _, line = place.partition(", after ")
    file = folder / path
    if line:
        old = file.read_text("utf-8")
        assert old.count(f"\n{line}\n") == 1
        file.write_text(old.replace(f"\n{line}\n", f"\n{line}\n{text}"), "utf-8")
    else:
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, "utf-8")


def run(folder, line, code=0):
    """Run a line of a shell, in which `shockpc` is that of the copy."""
    command = re.sub(r"^shockpc", f'"{sys.executable}" -m shockpc', line)
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        command, shell=True, cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == code, done.stderr
    return done


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_has_tests(room):
    """The command that runs them finds some."""
    (line,) = re.findall(r"^grep -l .*", PAGE.read_text("utf-8"), re.MULTILINE)
    assert '"shockpc.robot" tests/test_*.py' in line
    tests = (ROOT / "tests").glob("test_*.py")
    assert any(f"shockpc.{room}" in path.read_text("utf-8") for path in tests)
