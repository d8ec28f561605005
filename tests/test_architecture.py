"""What linters cannot tell: public names, and what is imported before it is needed.

For the rest see pyproject.toml.
"""

import ast
import fnmatch
import json
import re
import tomllib
from pathlib import Path

import pytest
from commands import python

import shockpc

PACKAGE = Path(shockpc.__file__).parent
HEAVY = {
    "numpy",
    "pinocchio",
    "flint",
    "scipy",
    "trimesh",
    "collada",
    "matplotlib",
    "shapely",
    "pydantic",
    "mujoco",
}
HEAVY |= {"clarabel", "rich", "pandas"}


def test_names_of_the_package_are_those_of_their_modules():
    assert sorted(shockpc.__all__) == shockpc.__all__
    assert {getattr(getattr(shockpc, name), "__name__", name) for name in shockpc.__all__} == set(
        shockpc.__all__
    )
    assert set(shockpc.__all__) <= set(dir(shockpc))
    assert not hasattr(shockpc, "nothing")


def test_top_level_and_license():
    top = PACKAGE.parent
    ignored = [line.strip("/") for line in (top / ".gitignore").read_text(encoding="utf-8").split()]
    found = {path.name for path in top.iterdir() if not path.name.startswith(".")}
    found = {
        name for name in found if not any(fnmatch.fnmatch(name, pattern) for pattern in ignored)
    }
    assert found == {"pyproject.toml", "README.md", "Makefile", "shockpc", "robots", "tests"}
    project = tomllib.loads((top / "pyproject.toml").read_text(encoding="utf-8"))
    # the page is promised by every --help
    assert any(needed.startswith("plotly") for needed in project["project"]["dependencies"])
    assert project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"] == ["shockpc"]
    assert (PACKAGE / "LICENSE").read_text(encoding="utf-8").startswith("BSD 2-Clause License\n")


def test_docstrings_name_modules_that_are_there_and_no_name_is_given_twice():
    """A text such as `core.coulomb` is a module, or a name in one; a second value of a constant
    would hide the first.
    """
    rooms = "|".join(
        path.name
        for path in PACKAGE.iterdir()
        if (path / "__init__.py").is_file() and path.name != "robot"
    )
    gone, twice = [], []
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for name in re.findall(rf"`((?:{rooms})(?:\.\w+)+)`", text):
            place = PACKAGE.joinpath(*name.split("."))
            gone += [(path.name, name)] * (
                not any(
                    p.exists()
                    for p in (place, place.with_suffix(".py"), place.parent.with_suffix(".py"))
                )
            )
        given = [
            one.id
            for node in ast.parse(text).body
            if isinstance(node, ast.Assign)
            for one in node.targets
            if isinstance(one, ast.Name)
        ]
        twice += [(path.name, name) for name in given if given.count(name) > 1]
    assert (gone, twice) == ([], [])


REPORT = (
    "import sys, json; print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})), "
    "file=sys.stderr)"
)
COMMAND = f"""
import atexit, sys
atexit.register(lambda: exec({REPORT!r}))
from shockpc.cli.entry import main
main(sys.argv[1:])
"""
ANALYZE = ("analyze", "anymal_b", "--contact", "LF_FOOT", "--format")


def imported(code: str, *words: str) -> set[str]:
    """The heavy libraries that some code has imported by its end."""
    done = python(code, *words)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stderr.splitlines()[-1])) & HEAVY


@pytest.mark.slow
def test_nothing_is_imported_before_it_is_needed():
    """Importing the package and asking for help load no library; a profile needs no meshes, no
    drawing and no scene file.
    """
    computing = {"numpy", "pinocchio", "flint"}
    assert imported(f"import shockpc\n{REPORT}") == set()
    assert imported(
        f"import shockpc\nfor name in shockpc.__all__: getattr(shockpc, name)\n{REPORT}"
    ) == computing | {"scipy"}  # limits
    assert imported(COMMAND, "--help") == imported(COMMAND, "analyze", "--help") == set()
    assert imported(COMMAND, *ANALYZE, "json") == computing
    assert imported(COMMAND, *ANALYZE, "table") == computing
    assert imported(
        COMMAND, "analyze", "hyq", "--contact", "lf_foot", "--format", "json"
    ) == computing | {"collada"}
    table = (
        "from shockpc.evaluation.table import Table\nTable((), {'x': numpy.array([1.0, "
        "numpy.nan])}, {}).to_arrow()\n"
    )
    assert imported(f"import numpy\n{table}{REPORT}") == computing
