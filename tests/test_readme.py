"""The README and the guide: their commands, Python and scenes run, and the output that they show is
the output.
"""

import inspect
import json
import pkgutil
import re
import shlex
import shutil
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from commands import ROBOTS, STICK_WITH_IMU, dog_in, good
from trees import known_robot

from shockpc.evaluation.variations.kinds.registry import WORDS
from shockpc.landing.joint_model import joint_model
from shockpc.landing.scenes.scene import Joints, Scene
from shockpc.landing.scenes.scene_file import scene_from
from shockpc.robot.catalogue import ROBOT_SUFFIXES
from shockpc.robot.shapes.mesh_files import FORMATS as MESHES
from shockpc.studies.guide.command import files_of

README = Path(__file__).parent.parent / "README.md"
GUIDE = files_of("md")
PAGES = (README, *GUIDE.values())
TEXTS = {page: page.read_text(encoding="utf-8") for page in PAGES}
METHOD, VARY = GUIDE["method"], GUIDE["vary"]
TEXT = "".join(TEXTS.values())

POSTURES = """<robot name="stick">
  <group name="all"><joint name="root_joint"/><joint name="knee"/></group>
  <group_state name="standing" group="all">
    <joint name="root_joint" value="0 0 0.4 0 0 0 1"/>
    <joint name="knee" value="-0.2"/>
  </group_state>
</robot>
"""
OPTIONAL = ("casadi", "crocoddyl", "torch", "jax")
"""Libraries that some examples need and shockpc does not."""

SCENE = 'robot = "robot.urdf"\n[[contact]]\nframe = "foot"\n'


class Block(NamedTuple):
    """A fenced block: its language and its text."""

    language: str
    text: str


class Typed(NamedTuple):
    """A command line, and the output shown under it; empty if none is."""

    line: str
    shown: str


BLOCKS = [
    Block(*found)
    for found in re.findall(r"^```(\w*)[^\n]*\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)
]


def commands() -> list[Typed]:
    """Every `shockpc …` in a fenced block.

    After a prompt, what follows is its output; `…` on a line stands for any lines.
    """
    found = []
    for block in BLOCKS:
        if block.language in ("python", "toml", "json", "xml"):
            continue
        lines = block.text.replace("\\\n", " ").splitlines()
        prompted = any(line.startswith("$ ") for line in lines)
        for k, line in enumerate(lines):
            if prompted and not line.startswith("$ "):
                continue
            words = line.removeprefix("$ ")
            if words.startswith("shockpc "):
                end = next(
                    (n for n in range(k + 1, len(lines)) if lines[n].startswith("$ ")), len(lines)
                )
                found.append(
                    Typed(words, "\n".join(lines[k + 1 : end]).strip("\n") if prompted else "")
                )
    return found


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with the files that the README names as the reader's."""
    folder = tmp_path / "work"
    shutil.copytree(ROBOTS / "dog", folder)
    dog_in(tmp_path)
    monkeypatch.chdir(folder)
    for name in ("robot", "leg"):
        (folder / f"{name}.urdf").write_text(STICK_WITH_IMU, encoding="utf-8")
        (folder / f"{name}.srdf").write_text(POSTURES, encoding="utf-8")
    scenes = [
        block.text
        for block in BLOCKS
        if block.language == "toml" and block.text.startswith("robot = ")
    ]
    (folder / "landing.toml").write_text(scenes[0] if scenes else SCENE, encoding="utf-8")
    (folder / "log.csv").write_text(
        next(block.text for block in BLOCKS if block.language == "csv"), encoding="utf-8"
    )
    (folder / "budgets.toml").write_text(
        next(block.text for block in BLOCKS if "[[budget]]" in block.text), encoding="utf-8"
    )
    return folder


def words_of(line: str) -> list[str]:
    """The words of a command without its comment, and without the commands that its output goes to."""
    words = shlex.split(line, comments=True)
    cut = next((k for k, word in enumerate(words) if word in ("|", ">", "&&", ";")), len(words))
    return words[1:cut]


def plain(text: str) -> str:
    """Text without the sizes of rounding errors, which differ between machines, and blanks at the
    ends of lines.
    """
    text = re.sub(r"off by \S+;|move it by \S+", "…", text)
    return "\n".join(line.rstrip() for line in text.splitlines())


@pytest.mark.usefixtures("no_figures")
def test_commands_run(capfd, here, monkeypatch):
    """In the order of the page and in one folder, so that a later command may use what an earlier
    one wrote.
    """
    monkeypatch.setattr("shockpc.studies.improve.search.RUNS", 4)
    found, printed = dict.fromkeys(commands()), dict[str, str]()
    assert found, "the pages show no command"
    for typed in found:
        out = printed.get(typed.line) or plain(good(capfd, *words_of(typed.line)))
        printed[typed.line] = out
        for part in re.split(r"^ *(?:…|\.\.\.) *$", plain(typed.shown), flags=re.MULTILINE):
            assert part.strip("\n") in out, typed.line


GO2 = "analyze go2 --contact FL_foot"


def analyzed(capfd, command):
    """The document that a command prints."""
    return json.loads(good(capfd, *shlex.split(command), "--format", "json"))


def trunk_of(document, key="shock"):
    """A number of the trunk's centre of mass, as the tables of the guide show it."""
    return f"{document['tables']['shocks'][0][key]:.4f}"


def calf_of(document):
    """The shock at the centre of mass of the calf that strikes, as the pages show it."""
    (calf,) = (row for row in document["tables"]["bodies"] if row["body"] == "FL_calf")
    return f"{calf['shock_com']:.2f}"


def test_level_feet_do_not_strike_at_once(capfd):
    """Later by the height over the speed, which is longer than half a period of the foot's
    effective mass on its stiffness.
    """
    sentence = (
        r"a foot that is (\S+) mm higher strikes (\S+) ms later at 1 m/s, and one foot of Go2 is "
        r"on contacts of (\S+) N/m for "
        r"(\S+) ms\."
    )
    ((height, delay, stiffness, contact),) = re.findall(sentence, " ".join(TEXTS[METHOD].split()))
    (foot,) = analyzed(capfd, GO2)["tables"]["contacts"]
    assert height == delay
    assert contact == f"{1e3 * np.pi * np.sqrt(foot['effective_mass'] / float(stiffness)):.1f}"
    assert float(contact) < float(delay)


def coupled_rows():
    """The shock at the trunk without and with the coupling of rotors, by the words of the landing."""
    rows = re.findall(
        r"^\| `(\S+ --contact \S+)` \| (0\.\d{4}) \| (0\.\d{4}) \|$", TEXTS[METHOD], re.MULTILINE
    )
    return {landing: numbers for landing, *numbers in rows}


def test_shock_by_drives(capfd, here):
    """The table of drives: each row's options give its number at the trunk, and "the same rotors"
    are those of the catalogue.
    """
    assert f"`shockpc {GO2}`" in TEXTS[METHOD]
    rows = re.findall(r"^\| ([^|]+) \| (?:`(.+)`)? ?\| (0\.\d{4}) \|$", TEXTS[METHOD], re.MULTILINE)
    assert len(rows) == 6
    sentence = (
        "at its trunk is {free} with free joints, {} with the rotors of its drives, and {locked} "
        "with locked joints"
    )
    shocks = {options.removeprefix("--joints "): shock for _, options, shock in rows}
    assert sentence.format(
        shocks[""], **{name: shocks[name] for name in ("free", "locked")}
    ) in " ".join(TEXTS[README].split())
    ends = [calf_of(analyzed(capfd, f"{GO2} --joints {model}")) for model in ("free", "locked")]
    for page in (README, METHOD):
        assert "Go2's calf has {} with free and {} with locked joints".format(*ends) in " ".join(
            TEXTS[page].split()
        )
    drives = joint_model(known_robot("go2"), Joints())
    for label, options, shock in rows:
        found = analyzed(capfd, f"{GO2} {options}")
        assert (
            trunk_of(found, "shock_separated" if "--contact-stiffness" in options else "shock")
            == shock
        ), options
        if label.startswith("the same") and "rotor" in options:
            model = joint_model(known_robot("go2"), scene_from(Scene, found["scene"], here).joints)
            np.testing.assert_allclose(model.armature + model.rotor, drives.armature, rtol=1e-12)


def test_the_springs_of_the_table_of_drives(capfd, here):
    """What the method says of springs behind the rotors is said of the row with a contact of finite
    stiffness.
    """
    (options,) = re.findall(
        r"^\| [^|]+ \| `(.+ --contact-stiffness .+)` \|", TEXTS[METHOD], re.MULTILINE
    )
    sentence = (
        r"the springs press the foot on the ground until (\d+) ms after touchdown, though it is "
        r"compressed after ([\d.]+) ms, "
        r"and they raise the shock to ([\d.]+) to ([\d.]+) at restitution 0 to 1\."
    )
    ((until, compressed, low, high),) = re.findall(sentence, " ".join(TEXTS[METHOD].split()))
    found = [analyzed(capfd, f"{GO2} {options} --restitution {e}") for e in (0.0, 0.5, 1.0)]
    (contact,), shocks = (
        found[0]["tables"]["contacts"],
        [one["tables"]["shocks"][0]["shock_separated"] for one in found],
    )
    assert (until, compressed) == (
        f"{1e3 * contact['duration']:.0f}",
        f"{1e3 * contact['peak_force_time']:.1f}",
    )
    assert (low, high) == (f"{min(shocks):.3f}", f"{max(shocks):.3f}")


def test_shock_by_rotors_that_links_carry(capfd, here):
    """The table of couplings: each landing without it and with it."""
    rows = coupled_rows()
    assert len(rows) == 5
    for landing, (without, coupled) in rows.items():
        assert trunk_of(analyzed(capfd, f"analyze {landing} --no-carried")) == without, landing
        assert trunk_of(analyzed(capfd, f"analyze {landing}")) == coupled, landing


def test_python_runs(capfd, here):
    found = [
        block.text
        for block in BLOCKS
        if block.language == "python"
        and not block.text.startswith(("def ", *(f"import {library}\n" for library in OPTIONAL)))
    ]
    assert found, "the README shows no Python"
    for text in found:
        exec(compile(text, "README.md", "exec"), {"__name__": "readme"})


def test_scenes_run(capfd, here):
    """A block of TOML that names a robot is a whole scene."""
    scenes = [
        block.text
        for block in BLOCKS
        if block.language == "toml" and block.text.startswith("robot = ")
    ]
    assert scenes, "the README shows no scene"
    for text in scenes:
        (here / "scene.toml").write_text(text, encoding="utf-8")
        assert good(capfd, "analyze", "scene.toml")


def test_the_equations_of_the_paper_are_where_the_guide_says():
    """Each has a function that says which equation it is, and a test."""
    rows = re.findall(
        r"^\| ([\d, ]+) \| [^|]* \| ([^|]*) \| ([^|]*) \|$", TEXTS[METHOD], re.MULTILINE
    )
    assert [int(number) for numbers, *_ in rows for number in numbers.split(", ")] == list(
        range(1, 13)
    )
    for numbers, places, tests in rows:
        functions = [
            pkgutil.resolve_name(f"shockpc.{name}")
            for name in re.findall(r"`([\w.]+:\w+)`", places)
        ]
        said = "".join(
            f"{one.__doc__}{inspect.getmodule(one).__doc__}" + inspect.getsource(one)
            for one in functions
        )
        named = re.findall(r"Eqs?\. ([\d, and]+)", said)
        assert set(numbers.split(", ")) & set(re.findall(r"\d+", " ".join(named))), numbers
        found = [pkgutil.resolve_name(name) for name in re.findall(r"`(\w+:\w+)`", tests)]
        assert found, numbers


def test_the_short_help_has_the_options_of_the_first_questions(capfd):
    """Those of the commands of the README that analyze a landing, and of the drives, the parts and
    the sensors of a robot.
    """
    shown = good(capfd, "analyze", "--help")
    used = {
        word
        for line in re.findall(r"shockpc analyze.*", TEXTS[README])
        for word in re.findall(r"--[a-z][a-z-]+", line)
    }
    used |= {"--part", "--rotor", "--armature", "--imu-bandwidth"}
    assert {
        option for option in used if not re.search(rf"(?m)^  (?:-\w, )?{option}\b", shown)
    } == set()


def test_what_varies_is_in_the_table_of_the_guide():
    (rows,) = re.findall(r"\| NAME \|.*?\n\n", TEXTS[VARY], re.DOTALL)
    assert set(re.findall(r"`([\w-]+(?::\w+)?)`", rows)) == set(WORDS)


def test_files_for_continuous_integration_are_whole():
    """Workflows can be copied as they are, and the hook of pre-commit runs a command."""
    documents = [yaml.safe_load(block.text) for block in BLOCKS if block.language == "yaml"]
    workflows, (hooks,) = (
        [one for one in documents if "jobs" in one],
        [one for one in documents if "repos" in one],
    )
    assert len(workflows) == 2
    for workflow in workflows:
        assert workflow.keys() == {"name", True, "jobs"}  # YAML reads `on` as yes
        assert {
            step.get("uses", "").split("@")[0] for step in workflow["jobs"]["shock"]["steps"]
        } >= {"actions/checkout"}
    (hook,) = yaml.safe_load((README.parent / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))
    assert hook["entry"] == "shockpc check"
    assert [one["id"] for repo in hooks["repos"] for one in repo["hooks"]] == [hook["id"]]
    # Without a point in it, what is no hash is a branch to pre-commit, which does not support
    # branches.
    assert all(re.fullmatch(r"[0-9a-f]{7,40}", repo["rev"]) for repo in hooks["repos"])


def test_the_hook_runs_for_every_file_that_a_check_reads():
    """Suffixes in both cases: SolidWorks writes .STL; and the baseline of the guide."""
    (hook,) = yaml.safe_load((README.parent / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))
    suffixes = (*(f".{mesh}" for mesh in MESHES), *ROBOT_SUFFIXES, ".srdf")
    names = [f"arm/part{case}" for suffix in suffixes for case in (suffix, suffix.upper())]
    assert [
        name for name in (*names, "base.json", "budgets.toml") if not re.search(hook["files"], name)
    ] == []
    assert not re.search(hook["files"], "controller.cpp")


def texts(drawing):
    """All that is written in an SVG."""
    return re.findall(r"<text[^>]*>(.*?)</text>", drawing.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("out", "drawn", "shown"),
    [
        ("go2", "shock", "go2"),
        ("place_go2", "place", "place_go2"),
        ("cassie", "measured", "cassie"),
        ("beyond", "robots", "bending"),
        *((name, name, name) for name in ("compare", "sensitivity")),
    ],
)
def test_pictures_are_those_of_the_commands(capfd, tmp_path, out, drawn, shown):
    """What `make gallery` would write says the same as what is committed."""
    rules = (README.parent / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
    words = re.search(
        rf'^\t@"\$\(BIN\)/shockpc" (.*) --out out/{out} > /dev/null$', rules, re.MULTILINE
    )
    assert words is not None
    good(capfd, *shlex.split(words[1]), "--out", tmp_path)
    assert texts(tmp_path / f"{drawn}.svg") == texts(
        README.parent / "robots" / "gallery" / f"{shown}.svg"
    )


def test_the_readme_is_short():
    """What a page says at length stands in the guide."""
    assert len(TEXTS[README].splitlines()) <= 150
    assert len(re.findall(r"!\[", TEXTS[README])) == 3


def test_the_readme_links_every_command(capfd):
    listed = re.findall(r"^  ([a-z]+)  +[A-Z]", good(capfd, "--help"), re.MULTILINE)
    assert sorted(re.findall(r"^\| \[`([a-z]+)`\]", TEXTS[README], re.MULTILINE)) == sorted(listed)


def shown_after(command):
    """The output that the README shows of a command."""
    return next(typed.shown for typed in commands() if typed.line == command)


def test_what_the_readme_says_of_its_first_answers():
    """The sentences under the table of robots and under the places have the numbers of these."""
    text = " ".join(TEXTS[README].split())
    rows = re.findall(
        r"^\S+  (\w+) .*? (\d\.\d+) +(\S+) +(\S+) ",
        shown_after("shockpc batch --robots quadrupeds"),
        re.MULTILINE,
    )
    shocks = {robot: numbers for robot, *numbers in rows}
    assert f"the velocity of Go2's IMU changes by {shocks['go2'][0]} m/s" in text
    assert f"the answer is a range, such as {shocks['a1'][1]} to {shocks['a1'][2]} for A1" in text
    places = re.findall(
        r"^(?:imu|best) +(\S+) +\S+ +(\S+) +(\S+) ", shown_after("shockpc place go2"), re.MULTILINE
    )
    imu, best = np.array(places, float)
    forward, up, _ = 100.0 * (best - imu)
    less = 100.0 * (1.0 - best[-1] / imu[-1])
    assert (
        f"Move it {forward:.0f} cm forward and {-up:.0f} cm down: the shock of the worst landing "
        f"is then {less:.0f} % less" in text
    )


MEASURED = (README.parent / "robots" / "measured" / "README.md").read_text(encoding="utf-8")


def measured(row):
    """The cells of a row of the tables of measured landings, without intervals.

    Args: row, how it begins.
    """
    (cells,) = re.findall(rf"^ *\| {re.escape(row)} \| (.*) \|$", MEASURED, re.MULTILINE)
    return [cell.split()[0] for cell in cells.split(" | ")]


def test_what_was_measured():
    """The table of the README has the numbers of the page of measured landings, which other tests
    compute.
    """
    text = " ".join(TEXTS[README].split())
    r, _, error, *_ = measured("with reflected inertia, springs free | 6 ms")
    assert f"joint rates 6 ms after contact: error {error}, r {r};" in text
    assert (
        f"error {measured('with reflected inertia, springs free | 30 ms')[2]} after 30 ms" in text
    )
    torques = measured("1e5 N/m, measured torques of the motors")[1:]
    assert "joint rates after 12 and 30 ms: error {} and {}".format(*torques) in text
    assert "without these torques: error {} and {}".format(*measured("1e5 N/m")[1:]) in text
    hinge = sorted(
        measured(law)[-1] for law in ("sticks", "friction 0.2", "friction 0.2, restitution 0.2")
    )
    assert f"hinge rate in a single toss: error {hinge[0]} to {hinge[-1]}" in text
    (r, _, late, _), (_, _, early, _) = measured("30 ms"), measured("15 ms")
    assert f"rates of both legs after 30 ms: error {late}, r {r}" in text
    r, _, error = measured("the other | 30 ms")
    assert f"the other leg: error {error}, r {r}; after 15 ms: error {early}" in text
    assert (
        f"12 to 15 % for Cassie's tarsi and {100 * float(late):.0f} % for the legs of a "
        f"compass-gait biped" in text
    )
    (trunk,) = re.findall(
        r"that lags, has a correlation of (\S+), worse than no jump", " ".join(MEASURED.split())
    )
    assert f"trunk velocity: r {trunk};" in text
    assert f"which foot: r {measured('with reflected inertia, drives as published')[0]}" in text
    assert "its correlation is 0.51" in MEASURED
    assert "a single touchdown: r 0.51" in text


def test_every_installation_is_of_a_clone():
    """The package is on no index; its extras are those of pyproject.toml."""
    extras = tomllib.loads((README.parent / "pyproject.toml").read_text(encoding="utf-8"))[
        "project"
    ]["optional-dependencies"]
    found = re.findall(r"pip install (\S+)", TEXT)
    assert set(found) - {"crocoddyl`)", "./shockpc"} == {
        one for one in found if one.startswith('".[')
    }
    assert {
        name for one in found for name in re.findall(r"[a-z]+", one.partition("[")[2])
    } <= extras.keys()
