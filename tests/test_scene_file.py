"""Scenes as TOML: every key is read, mistakes are named, and what is written is read back the same."""

import dataclasses
import json
import math
import os
import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, get_args, get_origin, get_type_hints

import jsonschema
import numpy as np
import pytest
from commands import Outcome, good, run
from hypothesis import given
from hypothesis import strategies as st

from shockpc import Contact, Point, Posture, Scene, SceneError, Strike, read_scene
from shockpc.model.closure import Closure, Place
from shockpc.model.joint_model import Joints, Rotor
from shockpc.scene import check_scene, scene_schema, scene_table, scene_text

EVERY_KEY = """\
robot = "dog/dog.urdf.xacro"
base = "planar"
plane = [0, -1, 0]
srdf = "dog/dog.srdf"
stance = ["rh_foot"]
assemble = ["*_hip"]
v_in = "com"
pulse = "half-sine:5ms"
range_g = 16

[packages]
dog_description = "dog"

[xacro]
payload = "1.5"

[posture]
reference = "standing"
base_position = [0, 0, 0.5]
base_rpy_deg = [0, 15, 0]
joints = { lf_hip = 0.5 }
joints_deg = { "rh_*" = -15 }

[strike]
speed = 1.5
strike_angle_deg = 30
angular_velocity = [0, 0.5, 0]
joint_velocities = { "?f_hip" = 0.2 }

[joints]
model = "geared"
armature = { "*" = 0.01 }
rotor = { lf_hip = { inertia = 1e-4, gear_ratio = 9 } }
locked = ["lh_hip"]

[[closure]]
a = { frame = "lf_leg", offset = [0, 0, -0.1] }
b = { frame = "rf_leg", offset = [0, 0, -0.1] }
kind = "point"
directions = ["x", [0, 0, 1]]

[[contact]]
frame = "lf_foot"
offset = [0, 0, -0.02]
at = "frame"
directions = ["x", [0, 1, 0], "z"]
kind = "point"
restitution = 0.25

[[contact]]
frame = "rf_foot"
at = "lowest"
directions = ["z"]

[[point]]
frame = "trunk_imu"
offset = [0.01, 0, 0]

[[point]]
frame = "trunk"
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "landing.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_key_is_read(here):
    """The scene holds what the file says, with absolute paths, and nothing else than defaults besides."""
    table = tomllib.loads(EVERY_KEY)
    table |= {"robot": str(here / "dog/dog.urdf.xacro"), "srdf": str(here / "dog/dog.srdf")}
    table["packages"] = {"dog_description": str(here / "dog")}
    contact, point = ({field.name: field.default for field in dataclasses.fields(kind)} for kind in (Contact, Point))
    table["contact"] = [as_lists(contact | given) for given in table["contact"]]
    table["point"] = [as_lists(point | given) for given in table["point"]]
    assert scene_table(read_scene(write(here, EVERY_KEY))) == table


def as_lists(table):
    return {key: list(value) if isinstance(value, tuple) else value for key, value in table.items()}


def test_keys_that_exclude_one_another(here):
    """The other ways to give base and strike."""
    text = 'robot = "anymal_b"\n[posture]\nbase_quaternion = [0, 0, 0, 1]\n[strike]\n'
    turned = Posture(base_quaternion=(0.0, 0.0, 0.0, 1.0))
    assert read_scene(write(here, text + "velocity = [0, 0, -1]\n")) == Scene(
        robot="anymal_b", posture=turned, strike=Strike(velocity=(0.0, 0.0, -1.0))
    )
    assert read_scene(write(here, text + "drop_height = 1\n")) == Scene(
        robot="anymal_b", posture=turned, strike=Strike(drop_height=1.0)
    )


CHANGES = {
    'base = "planar"': 'base = "free"',
    "plane = [0, -1, 0]": 'plane = "yz"',
    'srdf = "dog/dog.srdf"': 'srdf = "other.srdf"',
    'stance = ["rh_foot"]': "",
    'assemble = ["*_hip"]': 'assemble = ["rf_hip"]',
    'v_in = "com"': "",
    'pulse = "half-sine:5ms"': 'pulse = "half-sine:6ms"',
    "range_g = 16": "range_g = 0.001",
    'dog_description = "dog"': 'dog_description = "cat"',
    'payload = "1.5"': "",
    'reference = "standing"': 'reference = "crouched"',
    "base_position = [0, 0, 0.5]": "",
    "base_rpy_deg = [0, 15, 0]": "",
    "joints = { lf_hip = 0.5 }": "",
    'joints_deg = { "rh_*" = -15 }': "",
    "speed = 1.5": "",
    "strike_angle_deg = 30": "",
    "angular_velocity = [0, 0.5, 0]": "",
    'joint_velocities = { "?f_hip" = 0.2 }': "",
    'model = "geared"': 'model = "locked"',
    'armature = { "*" = 0.01 }': "",
    "rotor = { lf_hip = { inertia = 1e-4, gear_ratio = 9 } }": "",
    'locked = ["lh_hip"]': "",
    'a = { frame = "lf_leg", offset = [0, 0, -0.1] }': 'a = { frame = "lf_leg", offset = [0, 0, -0.05] }',
    'b = { frame = "rf_leg", offset = [0, 0, -0.1] }': 'b = { frame = "rf_leg", offset = [0, 0, -0.15] }',
    'kind = "point"\ndirections': 'kind = "frame"\ndirections',
    'directions = ["x", [0, 0, 1]]': 'directions = ["x"]',
    'frame = "lf_foot"': 'frame = "lf_leg"',
    "offset = [0, 0, -0.02]": "",
    'at = "frame"': 'at = "lowest"',
    'directions = ["x", [0, 1, 0], "z"]': 'directions = ["z"]',
    'kind = "point"\nrestitution': 'kind = "flat"\nrestitution',
    "restitution = 0.25": "",
    'frame = "rf_foot"': 'frame = "rf_leg"',
    'at = "lowest"': "",
    'directions = ["z"]': "",
    'frame = "trunk_imu"': 'frame = "lf_leg"',
    "offset = [0.01, 0, 0]": "",
    'frame = "trunk"\n': 'frame = "rf_leg"\n',
}
"""A change to every line of EVERY_KEY."""


def test_every_line_has_a_change():
    lines = [line for line in EVERY_KEY.splitlines()[1:] if "=" in line]
    assert [line for line in lines if not any(line in old for old in CHANGES)] == []
    assert [old for old in CHANGES if EVERY_KEY.count(old) != 1] == []


@pytest.mark.parametrize("old", CHANGES)
def test_every_key_counts(capfd, here, old):
    """A change to any line of the scene changes the numbers, or is refused."""
    (here / "other.srdf").write_text((here / "dog/dog.srdf").read_text().replace("0.3", "0.35"))
    shutil.copytree(here / "dog", here / "cat")
    (here / "cat/leg.xacro").write_text((here / "cat/leg.xacro").read_text().replace('mass value="0.5"', 'mass value="0.6"'))
    before = results(capfd, write(here, EVERY_KEY))
    assert before[0].startswith("robot ")
    assert results(capfd, write(here, EVERY_KEY.replace(old, CHANGES[old]))) != before


def results(capfd: pytest.CaptureFixture[str], path: Path) -> tuple[str, object]:
    """The tables and the numbers of a scene, without the words of the scene itself; or the refusal, twice."""
    tables = run(capfd, "analyze", path)
    document = run(capfd, "analyze", path, "--format", "json")
    if tables.code:
        return tables.err, document.err
    return tables.out, {key: part for key, part in json.loads(document.out).items() if key != "scene"}


def write_scene(folder: Path, scene: Scene) -> Path:
    return write(folder, scene_text(scene, folder))


TOP_KEYS = (
    "robot, base, plane, srdf, packages, xacro, posture, strike, contact, stance, closure, assemble, joints, point, "
    "v_in, pulse, range_g"
)
NUMBER, VECTOR = "has to be a finite number, not", "has to be a list of 3 finite numbers, not"
PLANE = 'plane has to be "xz", "yz" or "xy" or a list of 3 finite numbers, not'
AXIS = '"x", "y" or "z" or a list of 3 finite numbers, not'
TABLES = "has to be a list of tables, each begun with [[contact]], not"
MISTAKES = {
    "": "robot is missing; every scene needs it",
    "robot = 3": "robot has to be text in quotes, not 3",
    "robots = 'leg'": "robot is missing; every scene needs it; robots: no such key; nearest: robot",
    "ROBOT\nfoot = 1": f"foot: no such key; valid here: {TOP_KEYS}",
    'ROBOT\nbase = "loose"': 'base has to be "free", "planar" or "fixed", not "loose"',
    "ROBOT\nplane = [0, 1]": f"{PLANE} [0, 1]",
    'ROBOT\nplane = [0, 1, "z"]': f'{PLANE} [0, 1, "z"]',
    'ROBOT\npackages = "dog"': 'packages has to be a table, each of its values text in quotes, not "dog"',
    'ROBOT\n[packages]\n"a.b" = 1': 'packages."a.b" has to be text in quotes, not 1',
    'ROBOT\nposture = "standing"': 'posture has to be a table, not "standing"',
    "ROBOT\n[posture]\nrefrence = 'x'": "posture.refrence: no such key; nearest: reference",
    "ROBOT\n[posture]\nbase_position = [0, 0]": f"posture.base_position {VECTOR} [0, 0]",
    "ROBOT\n[posture]\njoints_deg = { knee = '9' }": f'posture.joints_deg.knee {NUMBER} "9"',
    "ROBOT\n[posture]\njoints = { knee = 1e999 }": f"posture.joints.knee {NUMBER} Infinity",
    "ROBOT\n[strike]\nvelocity = [0, 0, -inf]": f"strike.velocity {VECTOR} [0, 0, -Infinity]",
    'ROBOT\ncontact = "foot"': f'contact {TABLES} "foot"',
    f"ROBOT\ncontact = '{'foot' * 30}'": f'contact {TABLES} "{("foot" * 30)[:58]}…',
    "ROBOT\n[[contact]]\nframe = 'foot'\n[[contact]]": "contact[1].frame is missing; every contact needs it",
    "ROBOT\n[[contact]]\nframe = 'f'\ndirections = 'z'": f'contact[0].directions has to be a list, each of its entries {AXIS} "z"',
    "ROBOT\n[[contact]]\nframe = 'f'\ndirections = ['x', 'w']": f'contact[0].directions[1] has to be {AXIS} "w"',
    "ROBOT\n[[closure]]\na = { frame = 'f' }\nb = { link = 'g' }": (
        "closure[0].b.frame is missing; every place needs it; closure[0].b.link: no such key; valid here: frame, offset"
    ),
    "ROBOT\n[joints]\nrotor = 1": "joints.rotor has to be a table, each of its values a table, not 1",
    "ROBOT\n[joints]\nrotor = { hip = { inertia = 1 } }": "joints.rotor.hip.gear_ratio is missing; every rotor needs it",
    "ROBOT\nx = 1\n[strike]\nspeed = 'fast'\nsped = 1": (
        f'strike.speed {NUMBER} "fast"; strike.sped: no such key; nearest: speed; x: no such key; valid here: {TOP_KEYS}'
    ),
}


@pytest.mark.parametrize(("text", "said"), MISTAKES.items())
def test_mistakes_are_named(here, text, said):
    """File, key, what it holds and what would be valid; all mistakes at once."""
    path = write(here, text.replace("ROBOT", 'robot = "leg"') + "\n")
    with pytest.raises(SceneError) as refusal:
        read_scene(path)
    assert str(refusal.value) == f"{path}: {said}"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (
            b'robot = "leg"\nrobot = "leg"\n',
            "PATH is not TOML, as a scene file has to be: Cannot overwrite a value (at line 2, column 14)",
        ),
        (b'robot = "leg\n', "PATH is not TOML, as a scene file has to be: Illegal character '\\n' (at line 1, column 13)"),
        (b"<robot/>\n", "PATH is not TOML, as a scene file has to be: Invalid statement (at line 1, column 1)"),
        (
            b'robot = "\xff"\n',
            "PATH is not UTF-8 text; a scene file is TOML, a robot file is URDF, xacro or MJCF, and all of these are text",
        ),
    ],
)
def test_files_that_are_not_toml(here, data, said):
    path = here / "landing.toml"
    path.write_bytes(data)
    with pytest.raises(SceneError) as refusal:
        read_scene(path)
    assert str(refusal.value) == said.replace("PATH", str(path))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"robot = {'[' * 2000}", "is nested hundreds of levels deep; a scene file needs four"),
        (f'robot = "leg"\n{".".join("a" * 2000)} = 1\n', "a: no such key; valid here: "),
        (
            f'robot = "leg"\n[strike]\nvelocity.{".".join("a" * 2000)} = 1\n',
            "is nested hundreds of levels deep; a scene file needs four",
        ),
        (f'robot = "leg"\nrange_g = {"9" * 5000}\n', "holds an integer of thousands of digits"),
        (f'robot = "leg"\nrange_g = 0x{"f" * 5000}\n', "range_g has to be a finite number, not an integer of thousands of digits"),
        (f'robot = "leg"\nrange_g = {"9" * 400}\n', "range_g has to be a finite number, not 99999"),
        ('robot = "a\\u0000.urdf"\n', '"a\\u0000.urdf" cannot be the path of a file: it holds a NUL character'),
        ('robot = "leg"\npackages = { leg = "a\\u0000" }\n', '"a\\u0000" cannot be the path of a file: it holds a NUL character'),
        ('robot = "leg"\nsrdf = 2020-01-01\n', 'srdf has to be text in quotes, not "2020-01-01"'),
    ],
)
def test_files_that_no_scene_needs(here, text, said):
    """Extreme nesting, numbers and paths end in one message, not in a traceback."""
    with pytest.raises(SceneError) as refusal:
        read_scene(write(here, text))
    assert said in str(refusal.value)
    assert "landing.toml" in str(refusal.value)


def test_a_path_of_a_scene_file_with_a_nul_character():
    with pytest.raises(SceneError, match="holds a NUL character"):
        read_scene(Path("a\0.toml"))


# Scenes from Python


HEEL = Contact(frame="heel")


@pytest.mark.parametrize("contact", ["heel", HEEL, ("heel",), [HEEL], (HEEL,)])
def test_contacts_from_python_become_a_tuple_of_contacts(contact):
    """A name, a contact, or several of either."""
    assert Scene(robot="leg", contact=contact).contact == (HEEL,)


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ({"contact": Contact(frame="heel", offset=(0.0, 0.0))}, f"contact[0].offset {VECTOR} [0.0, 0.0]"),
        ({"contact": 3}, "contact[0] has to be a table, not 3"),
        ({"plane": "zx"}, f'{PLANE} "zx"'),
        ({"strike": Strike(speed="1")}, f'strike.speed {NUMBER} "1"'),
        ({"posture": Posture(joints={"knee": True})}, f"posture.joints.knee {NUMBER} true"),
        ({"joints": None}, "joints has to be a table, not null"),
        ({"strike": Strike(speed=math.nan)}, f"strike.speed {NUMBER} NaN"),
        ({"plane": (math.inf, 0.0, 1.0)}, f"{PLANE} [Infinity, 0.0, 1.0]"),
        (
            {"posture": Posture(base_position=(1e200, 0.0, 0.0))},
            "posture.base_position[0] is 1e+200, which is out of range; give a number up to 1e+12",
        ),
    ],
)
def test_scenes_from_python_are_checked_as_files_are(part, said):
    """The key, what it holds, and what would be valid."""
    with pytest.raises(SceneError) as refusal:
        check_scene(Scene(**({"robot": "leg", "contact": "heel"} | part)))
    assert str(refusal.value) == said


def test_vectors_from_python_become_tuples():
    """A list, an array or integers."""
    contact = Contact(frame="heel", offset=np.array([0.0, 0.1, 0.2]), directions=["x", [0, 0, 1]])
    expected = Contact(frame="heel", offset=(0.0, 0.1, 0.2), directions=("x", (0.0, 0.0, 1.0)))
    assert check_scene(Scene(robot="leg", contact=contact)).contact == (expected,)


def test_files_that_do_not_exist(here):
    with pytest.raises(SceneError) as refusal:
        read_scene(Path("away.toml"))
    assert str(refusal.value) == f'no scene file "away.toml" (looked in {here})'
    with pytest.raises(SceneError) as refusal:
        read_scene(here / "dog")
    assert str(refusal.value) == f'"{here}/dog" is a folder; give the scene file in it'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "[strike]\nvelocity = [0, 0, -1]\nspeed = 1",
            "the strike is given in two ways; keep one of: speed with strike angle, velocity, drop height",
        ),
        (
            "[posture]\nbase_rpy_deg = [0, 0, 0]\nbase_quaternion = [0, 0, 0, 1]",
            "the base is turned twice, by base_rpy_deg and by base_quaternion; keep one of them",
        ),
        (
            "[posture]\nbase_quaternion = [0, 0, 0, 3]",
            "base_quaternion has length 3; a rotation (x, y, z, w) has length 1",
        ),
        (
            "[[contact]]\nframe = 'foot'\ndirections = []",
            'contact "foot" keeps no direction, so nothing stops it; valid are "x", "y", "z" and vectors',
        ),
        (
            "[[contact]]\nframe = 'foot'\ndirections = ['x']",
            'contact "foot" keeps only directions along the ground, so nothing stops its fall; '
            "add the ground's normal (0, 0, 1) to its directions",
        ),
        (
            "[[contact]]\nframe = 'foot'\ndirections = ['z', [0, 0, 0]]",
            'contact "foot" has a direction without a length; valid are "x", "y", "z" and vectors',
        ),
    ],
)
def test_scenes_that_contradict_themselves(capfd, here, text, said):
    """Values that are valid alone, but not together."""
    contact = "" if "[[contact]]" in text else '[[contact]]\nframe = "foot"\n'
    write(here, f'robot = "stick.urdf"\n{contact}{text}\n')
    assert run(capfd, "analyze", "landing.toml") == Outcome(2, "", f"shockpc: {said}\n")


# Written and read again


TEXTS = st.text(st.characters(codec="utf-8"), max_size=12)
NAMES = st.one_of(
    TEXTS, st.sampled_from(["a.b", 'say "foot"', "knee=1", "\x7f", "\x00\x1f", "\\", "é", "𝛥ω", "[x]", "#", "'", "a b", "\u2028"])
)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


def values(kind):
    """Any value of a field of this type."""
    origin, parts = get_origin(kind), get_args(kind)
    if dataclasses.is_dataclass(kind):
        return records(kind)
    if origin is Literal:
        return st.sampled_from(parts)
    if origin is Mapping:
        return st.dictionaries(NAMES, values(parts[1]), max_size=3)
    if parts[1:] == (...,):
        least = 1 if get_args(parts[0]) else 0  # directions are never empty
        return st.lists(values(parts[0]), min_size=least, max_size=2).map(tuple)
    if origin is tuple:
        return st.tuples(*map(values, parts))
    if parts:
        return st.one_of(*map(values, parts))
    return {float: NUMBERS, str: NAMES, type(None): st.none()}[kind]


def records(kind, **given):
    """Any record of this type."""
    return st.builds(kind, **({name: values(hint) for name, hint in get_type_hints(kind).items()} | given))


NO_PATH = NAMES.filter(lambda name: "/" not in name and "\0" not in name and not Path(name).suffix)
SCENES = records(Scene, robot=NO_PATH, srdf=st.none(), packages=st.just({}))


@given(SCENES)
def test_a_written_scene_is_read_back(tmp_path_factory, scene):
    """With any names (quotes, dots, control characters), and joints in their order, which matters."""
    folder = tmp_path_factory.mktemp("scene")
    again = read_scene(write_scene(folder, scene))
    assert again == scene
    assert list(again.posture.joints) == list(scene.posture.joints)
    assert list(again.posture.joints_deg) == list(scene.posture.joints_deg)


def test_text_of_a_scene(here, snapshot):
    """In order, only what is set, paths relative to the file."""
    scene = Scene(
        robot=str(here / "dog/dog.urdf.xacro"),
        srdf=str(here / "dog/dog.srdf"),
        packages={"dog_description": str(here / "dog"), "odd name": str(here)},
        xacro={"payload": "1.5"},
        posture=Posture(base_position=(0.0, 0.0, 0.5), joints_deg={"rh_*": -15.0}),
        strike=Strike(drop_height=0.2, joint_velocities={"lf_hip": 0.5}),
        contact=(Contact(frame='say "foot"', directions=("x", (0.0, 0.6, 0.8))),),
        stance=("lf_foot",),
        joints=Joints(rotor={"*_hip": Rotor(inertia=1e-5, gear_ratio=9.0)}, locked=("lh_hip",)),
        closure=(Closure(a=Place(frame="a"), b=Place(frame="b")),),
    )
    assert scene_text(scene, here / "dog") == snapshot


@pytest.mark.parametrize(
    ("robot", "read"),
    [
        ("stick.urdf", "HERE/stick.urdf"),
        ("../stick.urdf", "UP/stick.urdf"),
        ("dog/../stick.urdf", "HERE/stick.urdf"),
        ("./stick", "HERE/stick"),
        ("/robots/stick.urdf", "/robots/stick.urdf"),
        ("~/stick.urdf", "HOME/stick.urdf"),
        ("stick", "stick"),
        ("anymal_b", "anymal_b"),
    ],
)
def test_paths_are_relative_to_the_file(here, monkeypatch, robot, read):
    """A name stays a name; a path is looked for beside the scene, wherever the command runs."""
    monkeypatch.setenv("HOME", "/home/someone")
    path = write(here, f'robot = "{robot}"\n')
    monkeypatch.chdir("/")
    expected = read.replace("HERE", str(here)).replace("UP", str(here.parent)).replace("HOME", "/home/someone")
    scene = read_scene(path)
    assert scene.robot == expected
    assert read_scene(write_scene(here, scene)) == scene


def test_scene_behind_a_link(here):
    """A link to a scene file means that file: paths count from where it really lies."""
    (here / "links").mkdir()
    (here / "links" / "landing.toml").symlink_to(write(here, 'robot = "stick.urdf"\n'))
    assert read_scene(here / "links" / "landing.toml").robot == str(here / "stick.urdf")


def test_saved_path_without_a_suffix_stays_a_path(here):
    """A file called like a robot is still that file."""
    os.rename(here / "stick.urdf", here / "anymal_b")
    scene = Scene(robot=str(here / "anymal_b"))
    assert scene_text(scene, here).splitlines()[0] == 'robot = "./anymal_b"'


# The schema


def test_schema_knows_every_key(capfd, here):
    """The schema for editors lists exactly the keys that the reader takes, and refuses all others."""
    schema = json.loads(good(capfd, "schema"))
    assert schema == scene_schema()
    assert schema["title"] == "shockpc scene"
    records = {kind.__name__: kind for kind in (Scene, Posture, Strike, Contact, Point, Joints, Rotor, Closure, Place)}
    for name, record in records.items():
        part = schema if name == "Scene" else schema["$defs"][name]
        assert list(part["properties"]) == [field.name for field in dataclasses.fields(record)]
        assert part["additionalProperties"] is False
        required = [f.name for f in dataclasses.fields(record) if f.default is f.default_factory is dataclasses.MISSING]
        assert part.get("required", []) == required
    table = tomllib.loads(EVERY_KEY)
    closure = table["closure"][0]
    used = {"Scene": {*table}, "Posture": {*table["posture"], "base_quaternion"}, "Contact": {*table["contact"][0]}}
    used |= {"Strike": {*table["strike"], "velocity", "drop_height"}, "Point": {*table["point"][0]}, "Joints": {*table["joints"]}}
    used |= {"Rotor": {*table["joints"]["rotor"]["lf_hip"]}, "Closure": {*closure}, "Place": {*closure["a"]}}
    assert used == {name: {field.name for field in dataclasses.fields(record)} for name, record in records.items()}


def test_schema_accepts_valid_scenes_alone():
    validator = jsonschema.Draft202012Validator(scene_schema())
    table = tomllib.loads(EVERY_KEY)
    for valid in (table, scene_table(Scene(robot="leg", contact=(Contact(frame="heel"),)))):
        validator.validate(valid)
    for change in ({"foot": 1}, {"base": "loose"}, {"plane": [0, 1]}, {"strike": {"speed": "fast"}}, {"contact": [{}]}):
        (fault,) = validator.iter_errors(table | change)
        assert not fault.path or fault.path[0] in change


def test_a_byte_order_mark_is_ignored(here):
    """Some editors put one before the text."""
    path = here / "landing.toml"
    path.write_bytes(b'\xef\xbb\xbfrobot = "leg"\n[[contact]]\nframe = "heel"\n')
    assert read_scene(path).contact == (Contact(frame="heel"),)
