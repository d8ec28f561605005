"""The house: who may import whom, what is public, what lies where."""

import ast
import fnmatch
import importlib
import json
import sys
from pathlib import Path

import pytest
from commands import python

import shockpc

PACKAGE = Path(shockpc.__file__).parent
TOP = PACKAGE.parent

LAYERS = (
    {"errors", "paths", "printed", "trace"},
    {"core"},
    {"robot"},
    {"model"},
    {"scene"},
    {"scene_file", "landing", "result"},
    {"blame"},
    {"health", "results"},
    {"profile"},
    {"studies", "paper"},
    {"show"},
    {"bench"},
    {"cli"},
    {"__main__"},
)
"""From the ground up; a module imports from its own layer and those before it."""

OWNERS = {
    "scipy": ("shockpc.core", "shockpc.robot.meshes"),
    "pinocchio": ("shockpc.robot", "shockpc.model", "shockpc.bench"),  # in the bench it is a rival
    "trimesh": "shockpc.robot.meshes",
    "collada": "shockpc.robot.meshes",
    "xacro": "shockpc.robot",
    "matplotlib": "shockpc.show",
    "shapely": "shockpc.show",
    "pydantic": "shockpc.scene_file",
    "mujoco": ("shockpc.robot.mjcf", "shockpc.bench"),
    "typer": "shockpc.cli",
}
"""Libraries that one part of the package alone may know."""


def owners(library: str) -> tuple[str, ...]:
    """The parts of the package that may know a library."""
    found = OWNERS[library]
    return (found,) if isinstance(found, str) else found


MODULES = {
    ".".join(path.relative_to(TOP).with_suffix("").parts).removesuffix(".__init__"): path for path in sorted(PACKAGE.rglob("*.py"))
}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}


def imports(name: str) -> list[tuple[str, str]]:
    """All that a module imports, wherever it does so: (module, name in it)."""
    found = []
    for node in ast.walk(TREES[name]):
        if isinstance(node, ast.Import):
            found += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name} uses a relative import"
            found += [(str(node.module), alias.name) for alias in node.names]
    return [(f"{module}.{part}", "") if f"{module}.{part}" in MODULES else (module, part) for module, part in found]


def layer(module: str) -> int:
    """The layer of a module of the package."""
    part = module.split(".")[1]
    return next(k for k, names in enumerate(LAYERS) if part in names)


INSIDE = [name for name in MODULES if name != "shockpc"]


@pytest.mark.parametrize("name", INSIDE)
def test_nobody_imports_upwards(name):
    """Data flows one way."""
    used = [module for module, _ in imports(name) if module.startswith("shockpc.")]
    assert [module for module in used if layer(module) > layer(name)] == []


def test_no_module_imports_itself_by_a_detour():
    """No cycles, not even those that a late import would hide."""
    waiting = {name: {module for module, _ in imports(name) if module in INSIDE} for name in INSIDE}
    while ready := [
        name for name, used in waiting.items() if not used & set(waiting) or not any(name in others for others in waiting.values())
    ]:
        for name in ready:
            del waiting[name]
    assert sorted(waiting) == []


@pytest.mark.parametrize("name", sorted(MODULES))
def test_libraries_stay_with_their_owners(name):
    """Only `model` knows Pinocchio, only `show` knows matplotlib."""
    used = {module.split(".")[0] for module, _ in imports(name)}
    strangers = [
        library for library in used & set(OWNERS) if not f"{name}.".startswith(tuple(f"{owner}." for owner in owners(library)))
    ]
    assert strangers == []


@pytest.mark.parametrize("name", [name for name in MODULES if name.startswith("shockpc.core")])
def test_core_knows_arrays_alone(name):
    """The mathematics has never heard of robots."""
    known = {"shockpc.core", "shockpc.errors", "numpy", "scipy", *sys.stdlib_module_names}
    assert [m for m, _ in imports(name) if ".".join(m.split(".")[: 1 + m.startswith("shockpc")]) not in known] == []


@pytest.mark.parametrize("name", sorted(MODULES))
def test_exports_are_the_public_names(name):
    """`__all__` holds every public function and class and no ghost, in order."""
    module = importlib.import_module(name)
    defined = {n.name for n in TREES[name].body if isinstance(n, ast.FunctionDef | ast.ClassDef) and n.name[0] != "_"}
    listed = getattr(module, "__all__", [])
    assert defined <= set(listed)
    assert [name for name in listed if not hasattr(module, name)] == []
    assert len(set(listed)) == len(listed)


@pytest.mark.parametrize("name", sorted(MODULES))
def test_imports_take_public_names_only(name):
    """What another module needs is in `__all__` of the one that has it."""
    taken = [(module, part) for module, part in imports(name) if module.startswith("shockpc.") and part]
    assert [(m, part) for m, part in taken if part not in getattr(importlib.import_module(m), "__all__", ())] == []
    assert [(m, part) for m, part in imports(name) if m == "shockpc" and part not in ("", "__version__")] == []


@pytest.mark.parametrize("name", sorted(MODULES))
def test_everything_public_has_a_docstring(name):
    tree = TREES[name]
    public = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.ClassDef) and n.name[0] != "_"]
    nested = {inner for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) for inner in ast.walk(n) if inner is not n}
    assert [n.name for n in public if n not in nested and not ast.get_docstring(n)] == []
    assert ast.get_docstring(tree) or not tree.body


def test_package_exports_load():
    """Every name of the package is there, and is the one that its home module has."""
    assert sorted(shockpc.__all__) == shockpc.__all__
    for name in shockpc.__all__:
        assert getattr(shockpc, name).__module__.startswith("shockpc.")
    with pytest.raises(AttributeError, match=r"^module 'shockpc' has no attribute 'nothing'$"):
        shockpc.nothing  # noqa: B018


def test_top_level_holds_only_what_belongs_there():
    ignored = [line.strip("/") for line in (TOP / ".gitignore").read_text(encoding="utf-8").split()]
    found = {path.name for path in TOP.iterdir() if not path.name.startswith(".")}
    found = {name for name in found if not any(fnmatch.fnmatch(name, pattern) for pattern in ignored)}
    assert found == {"pyproject.toml", "README.md", "Makefile", "shockpc", "robots", "tests"}


def test_license_is_inside_the_package():
    text = (PACKAGE / "LICENSE").read_text(encoding="utf-8")
    assert text.startswith("BSD 2-Clause License\n")
    assert "Redistributions in binary form must reproduce the above copyright notice" in text


LOADED = "import sys, json; print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})), file=sys.stderr)"
COMMAND = f"""
import atexit, sys
atexit.register(lambda: exec({LOADED!r}))
from shockpc.cli.main import main
main(sys.argv[1:])
"""


def loaded(code: str, *words: str) -> set[str]:
    """The libraries that some code has imported by its end."""
    done = python(code, *words)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stderr.splitlines()[-1]))


def test_importing_the_package_imports_nothing_else():
    assert loaded(f"import shockpc\n{LOADED}") & {*OWNERS, "numpy", "rich"} == set()


def test_public_names_need_no_drawing():
    """Computing a profile in Python imports neither matplotlib nor a reader of meshes."""
    code = f"import shockpc\nfor name in shockpc.__all__: getattr(shockpc, name)\n{LOADED}"
    assert loaded(code) & set(OWNERS) == {"pinocchio"}


def test_help_imports_no_numbers():
    assert loaded(COMMAND, "--help") & {*OWNERS, "numpy", "rich"} == {"typer"}
    assert loaded(COMMAND, "analyze", "--help") & {*OWNERS, "numpy", "rich"} == {"typer"}


def test_analyze_imports_only_what_it_needs():
    """A JSON document needs no figure, no scene file and no xacro, and neither does a table."""
    needed = {"pinocchio", "typer"}
    for words in (("--format", "json"), ("--format", "table")):
        assert loaded(COMMAND, "analyze", "anymal_b", "--contact", "LF_FOOT", *words) & {*OWNERS, "rich"} == needed
