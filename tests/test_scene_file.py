"""Scenes as TOML: every key is read, mistakes are named, and what is written is read back the same."""

import dataclasses
import json
import math
import re
import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, get_args, get_origin, get_type_hints

import jsonschema
import numpy as np
import pytest
from commands import dog_in, good
from hypothesis import given
from hypothesis import strategies as st
from robot_texts import refused

from shockpc import (
    Closure,
    Contact,
    Joints,
    LoopEnd,
    Part,
    Point,
    Posture,
    Rotor,
    Scene,
    Strike,
    read_scene,
    shock_profile,
)
from shockpc.landing.scenes.scene_fields import options_of
from shockpc.landing.scenes.scene_file import check_scene, scene_schema, scene_table, scene_text
from shockpc.studies.analyze.report import document as document_of
from shockpc.text.errors import SceneError, ShockError
from shockpc.text.printed import json_text

pytestmark = pytest.mark.smoke

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
imu_bandwidth = "400Hz"
ground_tolerance = 0.01
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
drives = "none"
rotor.lf_hip = { inertia = 1e-4, gear = "harmonic", gear_ratio = 9, stiffness = 500 }
stiffness = { rf_hip = 300 }
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
kind = "edge"
edge = [0, 1, 0]
restitution = 0.25
restitution_along = "directions"
normal = [0.1, 0, 1]
velocity = [0.1, 0, -1]
[[contact]]
frame = "rf_foot"
at = "lowest"
directions = ["z"]
[[point]]
frame = "trunk_imu"
offset = [0.01, 0, 0]
[[point]]
frame = "trunk"
[[part]]
name = "IMU"
at = "trunk_imu:0,0,0.01"
rating = "half-sine 1500 g 0.5 ms"
natural_frequency = 300
imu_bandwidth = "200Hz:2"
[[part]]
name = "camera"
at = "rf_foot"
critical_velocity_change = 2
[[part]]
name = "gear"
joint = "rf_hip"
momentary_torque = 20
torque_duration = 0.003
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "landing.toml"
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    return path


def by_key(value, at: str = "") -> dict:
    """The values of a table by their keys with dots between, those of a list of tables by their
    numbers.
    """
    if isinstance(value, list) and value and isinstance(value[0], dict):
        value = dict(enumerate(value))
    if isinstance(value, dict):
        return {
            key: x
            for name, part in value.items()
            for key, x in by_key(part, f"{at}.{name}").items()
        }
    return {at[1:]: value}


def test_every_key_is_read(here):
    """The scene holds what the file says, with absolute paths, and nothing else than defaults
    besides.
    """
    table = tomllib.loads(EVERY_KEY)
    table |= {"robot": str(here / "dog/dog.urdf.xacro"), "srdf": str(here / "dog/dog.srdf")}
    table["packages"] = {"dog_description": str(here / "dog")}
    contact, point = (
        {field.name: field.default for field in dataclasses.fields(kind)}
        for kind in (Contact, Point)
    )
    table["contact"] = [as_lists(contact | given) for given in table["contact"]]
    for key in ("edge", "normal", "velocity", "offset"):
        del table["contact"][1][key]
    table["point"] = [as_lists(point | given) for given in table["point"]]
    table["joints"]["carried"] = True
    assert scene_table(read_scene(write(here, EVERY_KEY))) == table | {"gravity": True}


def as_lists(table):
    return {key: list(value) if isinstance(value, tuple) else value for key, value in table.items()}


CHANGES = {
    "ground_tolerance = 0.01": "ground_tolerance = 1",
    'base = "planar"': 'base = "free"',
    'srdf = "dog/dog.srdf"': 'srdf = "other.srdf"',
    'stance = ["rh_foot"]': "",
    'assemble = ["*_hip"]': 'assemble = ["rf_hip"]',
    'v_in = "com"': "",
    'dog_description = "dog"': 'dog_description = "cat"',
    'reference = "standing"': 'reference = "crouched"',
    'model = "geared"': 'model = "locked"',
    'drives = "none"': 'drives = "nosuch.toml"',
    "stiffness = { rf_hip = 300 }": "",
    'locked = ["lh_hip"]': "",
    'kind = "point"\ndirections': 'kind = "frame"\ndirections',
    'kind = "edge"': 'kind = "flat"',
    "edge = [0, 1, 0]": "edge = [1, 0, 2]",
    'frame = "lf_foot"': 'frame = "lf_leg"',
    'frame = "rf_foot"': 'frame = "rf_leg"',
    'at = "frame"': 'at = "lowest"',
    'at = "lowest"': 'at = "frame"',
    'directions = ["z"]': "",
    'directions = ["x", [0, 0, 1]]': 'directions = ["x"]',
    'restitution_along = "directions"': "",
    'frame = "trunk_imu"': 'frame = "lf_leg"',
    'frame = "trunk"\n': 'frame = "rf_leg"\n',
    'name = "IMU"': 'name = "front IMU"',
    'name = "camera"': 'name = "other camera"',
    'name = "gear"\njoint = "rf_hip"': 'name = "gear"\njoint = "lf_hip"',
    'at = "rf_foot"': 'at = "lf_foot"',
}
"""A change to every line of EVERY_KEY without a number."""

LINES = [
    line
    for line in EVERY_KEY.splitlines()[1:]
    if "=" in line and not any(line in old for old in CHANGES)
]
DIGITS = {
    line: re.sub(r"\d(?=\D*$)", lambda digit: str((int(digit[0]) + 1) % 10), line) for line in LINES
}
"""Every other line with its last digit changed."""


@pytest.fixture(scope="module")
def before(tmp_path_factory):
    """A folder with the files of the scene and others, and the results of the scene there."""
    folder = dog_in(tmp_path_factory.mktemp("before").resolve()).parent
    (folder / "other.srdf").write_text((folder / "dog/dog.srdf").read_text().replace("0.3", "0.35"))
    shutil.copytree(folder / "dog", folder / "cat")
    (folder / "cat/leg.xacro").write_text(
        (folder / "cat/leg.xacro").read_text().replace('mass value="0.5"', 'mass value="0.6"')
    )
    found = results(write(folder, EVERY_KEY))
    assert "bodies" in found
    return folder, found


@pytest.mark.slow
@pytest.mark.parametrize("old", CHANGES | DIGITS)
def test_every_key_counts(before, old):
    """A change to any line of the scene changes the numbers, or is refused."""
    folder, found = before
    assert EVERY_KEY.count(old) == 1
    assert results(write(folder, EVERY_KEY.replace(old, (CHANGES | DIGITS)[old]))) != found


def results(path: Path) -> object:
    """The document of a scene without the scene itself; or the refusal."""
    try:
        document = json.loads(json_text(document_of(shock_profile(read_scene(path)))))
    except ShockError as refusal:
        return str(refusal)
    return {key: part for key, part in document.items() if key != "scene"}


def write_scene(folder: Path, scene: Scene) -> Path:
    return write(folder, scene_text(scene, folder))


NUMBERS, PLANE = (
    "a list of 3 numbers up to 1e+12, not",
    'plane has to be "auto", "xz", "yz" or "xy" or a list of 3 numbers up to 1e+12',
)
MISTAKES = {
    "foot = 1": "foot: no such key; valid here: robot, base, plane, srdf, packages",
    'base = "loose"': 'base has to be "free", "planar" or "fixed", not "loose"',
    "plane = [0, 1]": f"{PLANE}, not [0, 1]",
    'plane = [0, 1, "z"]': f'{PLANE}, not [0, 1, "z"]',
    'packages = "dog"': 'packages has to be a table, each of its values text in quotes, not "dog"',
    '[packages]\n"a.b" = 1': 'packages."a.b" has to be text in quotes, not 1',
    'packages = { leg = "a\\u0000" }': '"a\\u0000" cannot be the path of a file: it holds a NUL character',
    'posture = "standing"': 'posture has to be a table, not "standing"',
    "[posture]\nrefrence = 'x'": "posture.refrence: no such key; nearest: reference",
    "[posture]\nbase_position = [0, 0]": f"posture.base_position has to be {NUMBERS} [0, 0]",
    "[posture]\njoints_deg = { knee = '9' }": 'posture.joints_deg.knee has to be a number up to 1e+12, not "9"',
    "[posture]\njoints = { knee = 1e999 }": "posture.joints.knee has to be a number up to 1e+12, not Infinity",
    "[strike]\nvelocity = [0, 0, -inf]": f"strike.velocity has to be {NUMBERS} [0, 0, -Infinity]",
    "x = 1\n[strike]\nspeed = 'fast'\nsped = 1": (
        'strike.speed has to be a number up to 1e+12, not "fast"; strike.sped: no such key; '
        "nearest: speed; x: no such key; valid"
    ),
    "contact = 3": "contact has to be a list of tables, each begun with [[contact]], not 3",
    'contact = ["foot", 3]': "contact[1] has to be a table, not 3",
    "[[contact]]\nframe = 'foot'\n[[contact]]": "contact[1].frame is missing",
    "[[contact]]\nframe = 'f'\ndirections = 'z'": 'contact[0].directions has to be a list, each of its entries "x", "y" or "z" or',
    "[[contact]]\nframe = 'f'\ndirections = ['x', 'w']": f'contact[0].directions[1] has to be "x", "y" or "z" or {NUMBERS} "w"',
    "[[closure]]\na = { frame = 'f' }\nb = { link = 'g' }": (
        "closure[0].b.frame is missing; every loop end needs it; closure[0].b.link: no such key; "
        "valid here: frame, offset"
    ),
    "[joints]\nrotor = 1": "joints.rotor has to be a table, each of its values a table, not 1",
    "[joints]\nrotor = { hip = { gear_ratio = 1 } }": "joints.rotor.hip.inertia is missing",
    "srdf = 2020-01-01": 'srdf has to be text in quotes, not "2020-01-01"',
    'srdf = "leg': "is not TOML, as a scene file has to be: Illegal character '\\n' (at line 2, column 12)",
    'srdf = "\udcff"': "is not TOML, as a scene file has to be: 'utf-8' codec can't decode byte 0xff in position 22",
    "<robot/>": "is not TOML, as a scene file has to be: Invalid statement (at line 2, column 1)",
    "robot = 'leg'": "is not TOML, as a scene file has to be: Cannot overwrite a value (at line 2, column 14)",
}
WITHOUT_ROBOT = {
    "": "robot is missing",
    "robot = 3": "robot has to be text in quotes, not 3",
    "robots = 'leg'": "robot is missing; every scene needs it; robots: no such key; nearest: robot",
    'robot = "a\\u0000.urdf"': '"a\\u0000.urdf" cannot be the path of a file: it holds a NUL character',
}
EXTREMES = {
    f"plane = {'[' * 2000}": "thousands of digits, or tables or keys nested too deep",
    f"{'.'.join('a' * 2000)} = 1": "keys nested too deep",
    f"[strike]\nvelocity.{'.'.join('a' * 2000)} = 1": "thousands of digits, or tables or keys nested too deep",
    f"range_g = {'9' * 5000}": "thousands of digits, or tables or keys nested too deep",
    f"range_g = {'9' * 400}": "range_g has to be a number up to 1e+12, not 99999",
    f"range_g = 0x{'f' * 5000}": "thousands of digits, or tables or keys nested too deep",
}


def mistake(here, text):
    """The message of a scene file that is refused."""
    with pytest.raises(SceneError) as refusal:
        read_scene(write(here, text + "\n"))
    return str(refusal.value).replace(str(here), "HERE")


def test_mistakes_are_named(here):
    """File, key, what it holds and what would be valid; all mistakes at once."""
    for text, expected in (
        WITHOUT_ROBOT | {f'robot = "leg"\n{line}': x for line, x in MISTAKES.items()}
    ).items():
        message = mistake(here, text)
        assert message.startswith("HERE/landing.toml"), text
        assert expected in re.sub(r"; line \d+: ", "; ", message)


def test_mistakes_have_their_lines(here):
    """Of a key, of a table of an array, of an unknown table, and of a drive outside its table."""
    text = 'robot = "leg"\nfrictoin = 1\n[[contact]]\nframe = "a"\n[[contact]]\nofset = [0]\n'
    message = mistake(here, text)
    assert message.startswith("HERE/landing.toml:5: contact[1].frame is missing")
    assert "; line 6: contact[1].ofset: no such key; nearest: offset" in message
    assert "; line 2: frictoin: no such key; nearest: friction" in message
    table = mistake(here, 'robot = "leg"\n[posture]\n[[posture.sensor]]\nat = "a"\n')
    assert table.startswith("HERE/landing.toml:3: posture.sensor: no such key")
    drive = mistake(here, 'robot = "leg"\narmature = 0.1\n')
    assert drive == "HERE/landing.toml:2: armature: no such key; it belongs in [joints]"


@pytest.mark.parametrize("text", EXTREMES, ids=lambda text: text[:20])
def test_files_that_no_scene_needs(here, text):
    """Extreme nesting and numbers end in one message, not in a traceback."""
    message = mistake(here, f'robot = "leg"\n{text}')
    assert EXTREMES[text] in message
    assert "HERE/landing.toml" in message


# Scenes from Python


HEEL = Contact(frame="heel")


@pytest.mark.parametrize("contact", ["heel", HEEL, ("heel",), [HEEL], (HEEL,)])
def test_contacts_from_python_become_a_tuple_of_contacts(contact):
    """A name, a contact, or several of either."""
    assert Scene(robot="leg", contact=contact).contact == (HEEL,)


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        (
            {"contact": Contact(frame="heel", offset=(0.0, 0.0))},
            f"contact[0].offset has to be {NUMBERS} [0.0, 0.0]",
        ),
        ({"contact": 3}, "contact[0] has to be a table, not 3"),
        ({"plane": "zx"}, f'{PLANE}, not "zx"'),
        ({"plane": (math.inf, 0.0, 1.0)}, f"{PLANE}, not [Infinity, 0.0, 1.0]"),
        ({"strike": Strike(speed="1")}, 'strike.speed has to be a number up to 1e+12, not "1"'),
        (
            {"strike": Strike(speed=math.nan)},
            "strike.speed has to be a number up to 1e+12, not NaN",
        ),
        (
            {"posture": Posture(joints={"knee": True})},
            "posture.joints.knee has to be a number up to 1e+12, not true",
        ),
        (
            {"posture": Posture(base_position=(1e200, 0.0, 0.0))},
            f"posture.base_position has to be {NUMBERS} [1e+200, 0.0, 0.0]",
        ),
        ({"joints": None}, "joints has to be a table, not null"),
        ({"robot": 3}, "robot has to be text in quotes, not 3"),
    ],
)
def test_scenes_from_python_are_checked_as_files_are(part, expected):
    """The key, what it holds, and what would be valid."""
    refused(
        SceneError, [expected], shock_profile, Scene(**({"robot": "leg", "contact": "heel"} | part))
    )


def test_vectors_from_python_become_tuples():
    """A list, an array or integers."""
    contact = Contact(frame="heel", offset=np.array([0.0, 0.1, 0.2]), directions=["x", [0, 0, 1]])
    expected = Contact(frame="heel", offset=(0.0, 0.1, 0.2), directions=("x", (0.0, 0.0, 1.0)))
    assert check_scene(Scene(robot="leg", contact=contact)).contact == (expected,)


def test_files_that_do_not_exist(here):
    refused(
        SceneError, [f'no scene file "away.toml" (looked in {here})'], read_scene, Path("away.toml")
    )
    refused(
        SceneError,
        [f'"{here}/dog" is a folder; give the scene file in it'],
        read_scene,
        here / "dog",
    )
    refused(SceneError, ["holds a NUL character"], read_scene, Path("a\0.toml"))


# Written and read again


TEXTS = st.text(st.characters(codec="utf-8"), max_size=12)
NAMES = st.one_of(
    TEXTS,
    st.sampled_from(
        [
            "a.b",
            'say "foot"',
            "knee=1",
            "\x7f",
            "\x00\x1f",
            "\\",
            "é",
            "𝛥ω",
            "[x]",
            "#",
            "'",
            "a b",
            "\u2028",
        ]
    ),
)
FLOATS = st.one_of(st.floats(0.0, 1.0), st.floats(-1e12, 1e12))  # most bounds are 0 or 1


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
        return st.lists(values(parts[0]), max_size=2).map(tuple)
    if origin is tuple:
        return st.tuples(*map(values, parts))
    if parts:
        return st.one_of(*map(values, parts))
    return {float: FLOATS, bool: st.booleans(), str: NAMES, type(None): st.none()}[kind]


def records(kind, **given):
    """Any record of this type whose options are valid."""
    options = options_of(kind)

    def valid(name, hint):
        return values(hint).filter(
            lambda value: name not in options or not options[name].fault(value)
        )

    return st.builds(
        kind, **({name: valid(name, hint) for name, hint in get_type_hints(kind).items()} | given)
    )


NO_PATH = NAMES.filter(lambda name: "/" not in name and "\0" not in name and not Path(name).suffix)
SCENES = records(
    Scene,
    robot=NO_PATH,
    srdf=st.none(),
    packages=st.just({}),
    joints=records(Joints, drives=st.sampled_from([None, "none"])),
)


@pytest.mark.slow
@given(SCENES)
def test_a_written_scene_is_read_back(tmp_path_factory, scene):
    """With any names (quotes, dots, control characters), and joints in their order, which matters."""
    folder = tmp_path_factory.mktemp("scene")
    again = read_scene(write_scene(folder, scene))
    assert again == scene
    assert list(again.posture.joints) == list(scene.posture.joints)
    assert list(again.posture.joints_deg) == list(scene.posture.joints_deg)


def test_what_is_empty_is_written_where_it_is_not_the_default(tmp_path):
    scene = Scene(
        robot="dog",
        contact=Contact(frame="foot", directions=()),
        posture=Posture(joint_quaternions={"hip": ()}),
    )
    assert read_scene(write_scene(tmp_path, scene)) == scene


def test_text_of_a_scene(here):
    """What is set, and what a contact or a point has by default; paths are relative to the file."""
    text = by_key(tomllib.loads(scene_text(read_scene(write(here, EVERY_KEY)), here / "dog")))
    given = by_key(tomllib.loads(EVERY_KEY)) | {
        "robot": "dog.urdf.xacro",
        "srdf": "dog.srdf",
        "packages.dog_description": ".",
    }
    assert {key: text.get(key) for key in given} == given
    contact = {"kind": "auto", "restitution": 0, "restitution_along": "normal"}
    defaults = {"gravity": True, "joints.carried": True, "point.1.offset": [0, 0, 0]} | {
        f"contact.1.{key}": value for key, value in contact.items()
    }
    assert {key: value for key, value in text.items() if key not in given} == defaults


PATHS = """stick.urdf HERE/stick.urdf | ../stick.urdf UP/stick.urdf | dog/../stick.urdf HERE/stick.urdf | ./stick HERE/stick
/robots/stick.urdf /robots/stick.urdf | ~/stick.urdf HOME/stick.urdf | stick stick | anymal_b anymal_b | ./anymal_b HERE/anymal_b"""


@pytest.mark.parametrize(
    ("robot", "read"), [pair.split() for pair in PATHS.replace("\n", " | ").split(" | ")]
)
def test_paths_are_relative_to_the_file(here, monkeypatch, robot, read):
    """A name stays a name; a path counts from where the scene really lies, wherever the command
    runs and whatever links to it.
    """
    monkeypatch.setenv("HOME", "/home/someone")
    (here / "links").mkdir()
    path = here / "links" / "landing.toml"
    # editors put such a mark before a text
    path.symlink_to(write(here, f'\ufeffrobot = "{robot}"\n'))
    monkeypatch.chdir("/")
    expected = (
        read.replace("HERE", str(here))
        .replace("UP", str(here.parent))
        .replace("HOME", "/home/someone")
    )
    scene = read_scene(path)
    assert scene.robot == expected
    assert read_scene(write_scene(here, scene)) == scene


# The schema


def test_schema_knows_every_key(capfd, here):
    """The schema for editors lists exactly the keys that the reader takes, and refuses all others."""
    schema = json.loads(good(capfd, "schema"))
    assert schema == scene_schema()
    assert schema["title"] == "shockpc scene"
    records = {
        kind.__name__: kind
        for kind in (Scene, Posture, Strike, Contact, Point, Part, Joints, Rotor, Closure, LoopEnd)
    }
    for name, record in records.items():
        part = schema if name == "Scene" else schema["$defs"][name]
        assert list(part["properties"]) == [field.name for field in dataclasses.fields(record)]
        assert part["additionalProperties"] is False
        required = [
            f.name
            for f in dataclasses.fields(record)
            if f.default is f.default_factory is dataclasses.MISSING
        ]
        assert part.get("required", []) == required
    # Neither friction nor a contact stiffness goes with a contact that slides and a pulse: see
    # test_ground, test_stops, test_flex.
    table = tomllib.loads(EVERY_KEY)
    closure = table["closure"][0]
    used = {
        "Scene": {
            *table,
            "friction",
            "contact_stiffness",
            "tangential_stiffness",
            "contact_damping",
            "contact_law",
            "gravity",
        }
        | {"stops", "stop_restitution", "stop_stiffness", "flex"},
        "Posture": {*table["posture"], "base_quaternion", "joint_quaternions"},
        "Contact": {*table["contact"][0]},
    }
    used |= {
        "Strike": {*table["strike"], "velocity", "drop_height", "forward_speed"},
        "Point": {*table["point"][0]},
        "Part": {key for part in table["part"] for key in part},
        "Joints": {*table["joints"], "carried", "motors", "torque"},
    }
    rotors = table["joints"]["rotor"].values()
    used |= {
        "Rotor": {key for rotor in rotors for key in rotor},
        "Closure": {*closure},
        "LoopEnd": {*closure["a"]},
    }
    assert used == {
        name: {field.name for field in dataclasses.fields(record)}
        for name, record in records.items()
    }


def test_schema_accepts_valid_scenes_alone():
    validator = jsonschema.Draft202012Validator(scene_schema())
    table = tomllib.loads(EVERY_KEY)
    for valid in (table, scene_table(Scene(robot="leg", contact="heel"))):
        validator.validate(valid)
    for change in (
        {"foot": 1},
        {"base": "loose"},
        {"plane": [0, 1]},
        {"strike": {"speed": "fast"}},
        {"contact": [{}]},
    ):
        (fault,) = validator.iter_errors(table | change)
        assert not fault.path or fault.path[0] in change


def test_a_contact_may_be_a_name(here):
    """As in Python: a name or a list of names stands for contacts at the frames of these names; the
    schema says so.
    """
    for text, contact in (('"foot"', "foot"), ('["foot", "hip"]', ("foot", "hip"))):
        assert (
            read_scene(write(here, f'robot = "leg"\ncontact = {text}\n')).contact
            == Scene(robot="leg", contact=contact).contact
        )
    validator = jsonschema.Draft202012Validator(scene_schema())
    assert not list(validator.iter_errors({"robot": "leg", "contact": "foot"}))
    assert not list(validator.iter_errors({"robot": "leg", "contact": ["foot", {"frame": "hip"}]}))
    assert list(validator.iter_errors({"robot": "leg", "contact": 3}))
