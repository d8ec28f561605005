"""Each wing can be taken away, and one can be added, without a change elsewhere."""

import csv
import json
import os
import pkgutil
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import shockpc

PACKAGE = Path(shockpc.__file__).parent
TOP = PACKAGE.parent
WINGS = sorted(path.parent.name for path in PACKAGE.glob("wings/*/__init__.py"))
KEYS = {"compliant": {"stiffness", "gravity"}}
"""Keys that documents of the core lose without a wing; none is lost without the others."""

COMMANDS = (
    ("analyze", "go2", "--contact", "FL_foot"),
    ("analyze", "hyq", "--contact", "lf_foot", "--friction", "0.3"),
    ("sweep", "go2", "--contact", "FL_foot", "--vary", "strike-angle=-20:20:5", "--at", "base"),
)
EVERY_MODULE = """
import importlib, pkgutil, sys
import shockpc
assert shockpc.__file__.startswith(sys.argv[1]), shockpc.__file__
for module in pkgutil.walk_packages(shockpc.__path__, "shockpc."):
    if not module.name.endswith(("__main__", "torch")):
        importlib.import_module(module.name)
for name in shockpc.__all__:
    getattr(shockpc, name)
"""
CORE = (
    *("test_impulse.py", "test_profile.py", "test_columns.py", "test_names.py", "test_results.py"),
    *("test_friction.py", "test_low_pass.py", "test_links.py"),
)
"""Tests of the core that run without a wing: the equation, its results, rows and commands, links of pages."""


def python(top, *words):
    """A Python with the package of a folder."""
    env = {**os.environ, "PYTHONPATH": str(top), "COLUMNS": "100"}
    command = [sys.executable, *words]
    return subprocess.run(command, capture_output=True, text=True, cwd=top, env=env, check=False)


def copy_of(folder):
    """The package and its tests in another folder."""
    ignored = shutil.ignore_patterns("__pycache__")
    for name in ("shockpc", "tests", "robots", ".github"):
        shutil.copytree(TOP / name, folder / name, ignore=ignored)
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(TOP / name, folder)
    return folder


def document(top, words):
    """The JSON that a command writes."""
    done = python(top, "-m", "shockpc", *words, "--format", "json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def without(document, keys):
    """A document without some keys, at any depth."""
    if isinstance(document, dict):
        return {key: without(value, keys) for key, value in document.items() if key not in keys}
    if isinstance(document, list):
        return [without(value, keys) for value in document]
    return document


def refuses_a_contact_stiffness(top):
    """Check that an option of a wing that is not there is none, and is refused by name in a file."""
    landing = ("analyze", "go2", "--contact", "FL_foot")
    assert "--contact-stiffness" not in python(top, "-m", "shockpc", "analyze", "--help-all").stdout
    refused = python(top, "-m", "shockpc", *landing, "--contact-stiffness", "1e5")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "no such option: --contact-stiffness" in refused.stderr
    scene = top / "soft.toml"
    scene.write_text('robot = "go2"\ncontact = "FL_foot"\ncontact_stiffness = 1e5\n', "utf-8")
    refused = python(top, "-m", "shockpc", "analyze", str(scene))
    wanted = "soft.toml:3: contact_stiffness: no such key without the wing compliant"
    assert refused.returncode == 2
    assert wanted in refused.stderr


@pytest.mark.slow
@pytest.mark.parametrize("gone", [*((wing,) for wing in WINGS), tuple(WINGS)], ids="+".join)
def test_the_package_is_whole_without_a_wing(gone, tmp_path):
    top = copy_of(tmp_path)
    stub = top / "shockpc" / "__init__.pyi"
    lines = stub.read_text(encoding="utf-8").splitlines(keepends=True)
    for wing in gone:
        shutil.rmtree(top / "shockpc" / "wings" / wing)
        shutil.rmtree(top / "tests" / "wings" / wing, ignore_errors=True)
        lines = [line for line in lines if not line.startswith(f"from .wings.{wing}.")]
    stub.write_text("".join(lines), encoding="utf-8")
    shutil.rmtree(top / "shockpc" / "bench")  # it measures all of them

    done = python(top, "-c", EVERY_MODULE, str(top))
    assert done.returncode == 0, done.stderr
    for tool in (["ruff", "check", "shockpc"], ["mypy", "shockpc"]):
        done = python(top, "-m", *tool)
        assert done.returncode == 0, done.stdout
    done = python(top, "-c", "from importlinter.cli import lint_imports_command as run; run()")
    assert done.returncode == 0, done.stdout
    lost = set().union(*(KEYS.get(wing, set()) for wing in gone))
    for words in COMMANDS:
        assert without(document(TOP, words), lost) == without(document(top, words), lost)
    for words in ("--help", "guide"):
        assert python(top, "-m", "shockpc", words).returncode == 0
    if "compliant" in gone:
        refuses_a_contact_stiffness(top)
    tests = [str(top / "tests" / name) for name in CORE]
    done = python(top, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests)
    assert done.returncode == 0, done.stdout[-3000:]


PROBE = {
    "__init__.py": '"""A subject."""\n',
    "wing.py": '''"""Its doors."""

from shockpc.text.wings import Wing

WING = Wing(options="options", quantities="quantities")
''',
    "options.py": '''"""An option of a scene."""

from shockpc.landing.scenes.scene_fields import RESULTS, option

SCALE = option(1.0, "What the shock is multiplied by.", RESULTS, "X", above=0.0, varies=True)
OPTIONS = {"probe_scale": (float, SCALE)}
''',
    "quantities.py": '''"""A quantity."""

from shockpc.quantities.of_points import SHOCK


def scaled(impact, places):
    """Shock (N, S, n) times a number."""
    return SHOCK.compute(impact, places) * impact.landing.scene.probe_scale


QUANTITIES = (SHOCK._replace(key="scaled_shock", title="scaled shock", compute=scaled),)
''',
    "tally/__init__.py": 'HEADING, SUMMARY = "Decide", "Count the bodies that a landing shakes."\n',
    "tally/study.py": '''"""How many bodies a landing shakes."""

from typing import Annotated

from shockpc.evaluation.declare import study
from shockpc.landing.scenes.scene_fields import Option
from shockpc.landing.scenes.scene import Scene
from shockpc.profile import profile_of_scene
from shockpc.robot.robot import Robot

Least = Annotated[float, Option("Shock from which a body counts.", "Question", "S", least=0.0)]


@study("shockpc tally go2 --contact FL_foot --least 0.1", reads="scene")
def tally(scene: Scene, robot: Robot | None = None, least: Least = 0.1) -> int:
    """Count bodies."""
    return int((profile_of_scene(scene, robot).shock_com >= least).sum())
''',
    "tally/report.py": '''"""The report of a tally."""

from shockpc.show.report import Report
from shockpc.show.tables import Sheet


def tally_report(result: int) -> Report:
    """One number."""
    sheet = Sheet("bodies", ("bodies",), [(result,)])
    return Report(name="tally", body=lambda _: [sheet], sheets={"t": lambda: sheet}, document=dict)
''',
}
"""A wing with an option, a quantity and a command."""


@pytest.mark.slow
def test_an_option_a_quantity_and_a_command_are_added_by_a_folder(tmp_path):
    """No line of the core is changed: what the wing declares is in help, files, tables and sweeps."""
    top = copy_of(tmp_path)
    folder = top / "shockpc" / "wings" / "probe"
    (folder / "tally").mkdir(parents=True)
    for name, text in PROBE.items():
        (folder / name).write_text(text, encoding="utf-8")
    landing = ("go2", "--contact", "FL_foot")

    listed = python(top, "-m", "shockpc", "--help").stdout
    assert re.search(r"^ *tally +Count the bodies", listed, re.MULTILINE)
    done = python(top, "-m", "shockpc", "tally", *landing, "--least", "0.05")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[0] == "bodies"

    assert "--probe-scale X" in python(top, "-m", "shockpc", "analyze", "--help-all").stdout
    scaled = document(top, ("analyze", *landing, "--probe-scale", "3"))
    assert scaled["scene"]["probe_scale"] == 3.0
    for row in scaled["tables"]["points"]:
        assert row["scaled_shock"] == pytest.approx(3.0 * row["shock"], rel=1e-12)
    scene = top / "scene.toml"
    scene.write_text('robot = "go2"\ncontact = "FL_foot"\nprobe_scale = -1.0\n', encoding="utf-8")
    refused = python(top, "-m", "shockpc", "analyze", str(scene))
    assert refused.returncode == 2
    assert "probe_scale must be > 0" in refused.stderr
    asked = ("--vary", "probe-scale=1:2:2", "--quantity", "scaled_shock@imu", "--format", "csv")
    table = python(top, "-m", "shockpc", "sweep", *landing, *asked).stdout.splitlines()
    (scaled,) = (row for row in csv.DictReader(table) if row["quantity"] == "scaled_shock@imu")
    assert float(scaled["maximum"]) == pytest.approx(2.0 * float(scaled["minimum"]), rel=1e-12)


def test_the_core_names_no_wing_and_texts_name_what_is_there():
    """A text "module:function" is resolved; nothing below the wings has the word in a path."""
    named, missing = [], []
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        parts = path.relative_to(PACKAGE).parts
        if parts[0] not in ("wings", "bench") and parts != ("text", "wings.py"):
            named += [(str(path), word) for word in re.findall(r"wings\.\w+", text)]
        for reference in re.findall(r'"([a-z]\w*(?:\.[a-z]\w*)+:\w+)"', text):
            try:
                pkgutil.resolve_name(f"shockpc.{reference.removeprefix('shockpc.')}")
            except (ImportError, AttributeError):
                missing.append((str(path), reference))
    assert (named, missing) == ([], [])


SOFT = re.compile(r"contact_stiffness|[Cc]ompliant|stiff_[a-z]|\bflex|finite stiffness")
"""Words of what gives way, which is the subject of a wing."""

SOFT_LINES = 31
"""Lines of the core with such a word; the number may only fall."""


def test_the_core_says_ever_less_of_what_gives_way():
    lines = []
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.relative_to(PACKAGE).parts[0] not in ("wings", "bench"):
            every = path.read_text(encoding="utf-8").splitlines()
            lines += [f"{path.name}: {line.strip()}" for line in every if SOFT.search(line)]
    assert len(lines) <= SOFT_LINES, "\n".join(lines)
