"""The JSON document: exactly schema `shockpc.profile/2`, and exactly the numbers of the profile."""

import json
import math

import jsonschema
import numpy as np
import pytest
from altered import Altered, health
from commands import ROBOTS, python
from pydantic import TypeAdapter

import shockpc
from shockpc import (
    Closure,
    Contact,
    Joints,
    LoopEnd,
    Part,
    Point,
    Posture,
    Scene,
    Strike,
    shock_profile,
)
from shockpc.landing.scenes.scene_file import scene_schema
from shockpc.method.dynamics import PINOCCHIO
from shockpc.quantities.selection import QUANTITIES
from shockpc.show.document import headed
from shockpc.studies.analyze.landing_document import content
from shockpc.studies.analyze.report import document
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import json_text

pytestmark = pytest.mark.smoke

DOG = {
    "robot": str(ROBOTS / "dog" / "dog.urdf.xacro"),
    "packages": {"dog_description": str(ROBOTS / "dog")},
}
FEET = tuple(Contact(frame=f"{name}_foot") for name in ("lf", "rf", "lh", "rh"))
SCENES = {
    "dog on one foot": Scene(**DOG, contact=FEET[:1]),
    "dog on all feet": Scene(**DOG, contact=FEET, strike=Strike(drop_height=0.2), base="planar"),
    "dog that slides": Scene(
        **DOG,
        xacro={"payload": "1.5"},
        contact=Contact(frame="lf_foot", at="lowest", directions=("z",), restitution=0.5),
        posture=Posture(
            reference="crouched", base_rpy_deg=(5.0, 15.0, 0.0), joints_deg={"rh_*": -30.0}
        ),
        point=(Point(frame="trunk", offset=(0.1, 0.0, 0.05)),),
        strike=Strike(velocity=(0.5, 0.1, -1.0)),
    ),
    "beam that translates": Scene(robot="beam", contact="center"),
    "anymal on a fixed base": Scene(robot="anymal_b", contact="LF_FOOT", base="fixed"),
    "dog whose front legs are tied together": Scene(
        **DOG,
        posture=Posture(joints_deg={"lf_hip": 20.0}),
        closure=(
            Closure(a=LoopEnd(frame="lf_foot"), b=LoopEnd(frame="rf_foot"), directions=("x", "z")),
        ),
        contact=FEET[:1],
        joints=Joints(armature={"*_hip": 0.01}, locked=("lh_hip",)),
        pulse="half-sine:5ms",
        range_g=16.0,
        v_in="com",
        stance=("rh_foot",),
        part=(
            Part(
                name="camera",
                at="trunk:0,0,0.1",
                rating="half-sine 1500 g 0.5 ms",
                natural_frequency=300.0,
            ),
            Part(name="gear", joint="*_hip", momentary_torque=20.0),
        ),
    ),
    "talos on its soles": Scene(
        robot="talos",
        contact=(Contact(frame="left_sole_link", kind="flat"), Contact(frame="right_sole_link")),
        plane="yz",
    ),
    "dog with friction": Scene(
        **DOG, contact=FEET[:1], friction=0.1, strike=Strike(strike_angle_deg=30.0)
    ),
    "dog on springs": Scene(
        **DOG, contact=FEET[:2], contact_stiffness=1e5, joints=Joints(armature={"*_hip": 0.01})
    ),
    "dog on all feet, locked": Scene(**DOG, contact=FEET, joints=Joints(model="locked")),
    "beam that is pulled": Scene(
        robot="beam",
        contact=tuple(Contact(frame=frame, directions=("z",)) for frame in ("percussion", "tip")),
    ),
}

RECORDS = {
    "document": "schema:str shockpc:str pinocchio:str unknowns:unknown* range:range? robot:robot "
    "scene:dict bodies:body* joint_model:str drives:drives "
    "health:health loads_unique:bool assembly:assembly? friction:sliding? stiffness:springs? tables:dict units:dict",
    "unknown": "kind:str status:str subjects:str* deciding:str* text:str remedy:str effect:float?",
    "range": "quantity:str at:str value:float smallest:float largest:float kind:str deciding:str*",
    "robot": "name:str file:str n_bodies:int nv:int",
    "body": "body:str links:str* rotation:matrix",
    "drives": "source:str? unknown:str* springs:str* spring_time:float?",
    "health": "rank:int rows:int error_bound:float? body_error_bounds:float?* double_error:float data_sensitivity:float? bits:int "
    "warnings:warning*",
    "warning": "kind:str subject:str value:float? text:str",
    "assembly": "gap:float turn:float left:float retried:bool moved:step*",
    "step": "joint:str by:float",
    "sliding": "coefficient:float unchanged:bool solutions:int",
    "springs": "contact_stiffness:float springs_count:float? spectra:dict?",
}
"""The keys of every record in their order, and what they hold; ? may be null, * is a list."""
LISTS = {"vector": "float", "matrix": "vector"}
"""What is a list of three."""


def misfits(kind: str, value: object, place: str = "document") -> list[str]:
    """Where a value is not of a kind."""
    if kind.endswith("?") and value is None:
        return []
    kind = kind.removesuffix("?")
    if kind.endswith("*") or kind in LISTS:
        if not isinstance(value, list) or (kind in LISTS and len(value) != 3):
            return [f"{place} is {value}"]
        return [
            fault
            for k, part in enumerate(value)
            for fault in misfits(LISTS.get(kind, kind[:-1]), part, f"{place}[{k}]")
        ]
    if kind in RECORDS:
        keys = dict(word.split(":") for word in RECORDS[kind].split())
        if not isinstance(value, dict) or list(value) != list(keys):
            return [f"{place} is {value}"]
        return [
            fault
            for key, part in keys.items()
            for fault in misfits(part, value[key], f"{place}.{key}")
        ]
    right = type(value).__name__ == kind and (kind != "float" or math.isfinite(value))
    return [] if right else [f"{place} is {value!r}"]


@pytest.fixture(scope="module", params=SCENES)
def profile(request):
    return shock_profile(SCENES[request.param])


def test_document_fits_its_schema(profile):
    """Every key is there, in its order, with a value of its kind; and no other key."""
    written = json_text(document(profile))
    assert misfits("document", json.loads(written)) == []
    assert written.endswith("}\n")


TABLES = {
    "robot": "landing",
    "body": "bodies",
    "point": "points",
    "joint": "joints",
    "part": "parts",
    "contact": "contacts",
}


def test_tables_hold_every_quantity(profile):
    """To the last bit, at every place; one that no place has is left out.

    Beside them are robot, assembly and warnings.
    """
    read, robot, assembly = (
        json.loads(json_text(document(profile))),
        profile.robot,
        profile.assembly,
    )
    assert (read["schema"], read["shockpc"], read["pinocchio"]) == (
        "shockpc.profile/2",
        shockpc.__version__,
        PINOCCHIO,
    )
    size = {
        "name": robot.name,
        "file": robot.label,
        "n_bodies": len(robot.bodies),
        "nv": robot.model.nv,
    }
    assert (read["robot"], read["joint_model"]) == (size, profile.joint_model)
    for quantity in QUANTITIES:
        if quantity.of == "part":
            continue
        values, tables = profile.value(quantity.key, quantity.of), read["tables"]
        rows = (
            [read["health"]]
            if (quantity.of, quantity.computation.on) == ("robot", "health")
            else tables.get(TABLES[quantity.of], [])
        )
        if quantity.key.startswith(("most_severe", "least_severe")):
            rows = tables.get("directions", [])
            rows = rows[: len(robot.bodies)] if quantity.of == "body" else rows[len(robot.bodies) :]
        keys = [f"{quantity.key}_{axis}" for axis in "xyz"] if quantity.vector else [quantity.key]
        for row, value in zip(rows, values, strict=False):  # the contacts end with their total
            known = [
                None if not np.isfinite(x) and not np.isposinf(x) else x
                for x in np.atleast_1d(value)
            ]
            found = [float(x) if isinstance(x, str) else x for x in map(row.get, keys)]
            assert found == known, quantity.key
    assert [(body["body"], tuple(body["links"])) for body in read["bodies"]] == [
        (body.name, body.links) for body in robot.bodies
    ]
    assert [body["rotation"] for body in read["bodies"]] == profile.rotation.tolist()
    standing = [
        row["contact"] for row in read["tables"]["contacts"] if "stance" in (row["what"] or "")
    ]
    assert standing == [foot.frame for foot in profile.stance]
    bracket = [(row.free, row.as_modelled, row.locked) for row in profile.bracket]
    keys = ("shock_free", "shock", "shock_locked")
    assert [tuple(map(row.get, keys)) for row in read["tables"]["shocks"]] == bracket
    assert [tuple(warning.values()) for warning in read["health"]["warnings"]] == list(
        profile.health.warnings
    )
    moved = (
        None if assembly is None else [{"joint": name, "by": by} for name, by, _ in assembly.moved]
    )
    assert read["assembly"] == (
        assembly
        and {
            "gap": assembly.gap,
            "turn": assembly.turn,
            "left": assembly.left,
            "retried": assembly.retried,
            "moved": moved,
        }
    )


def test_nulls_stand_where_things_do_not_exist():
    """Centres of what only translates; impulses, moments and loads that are not unique; friction
    where the ground would pull.
    """
    names = "beam that translates", "dog on all feet, locked", "beam that is pulled"
    beam, dog, pulled = (document(shock_profile(SCENES[name])) for name in names)
    keys = ("copc_x", "copc_world_x", "ropc", "screw_pitch", "shock_max")
    assert [beam["tables"]["bodies"][0].get(key) for key in keys] == [None, None, "inf", None, 1.0]
    assert (
        dog["loads_unique"],
        pulled["loads_unique"],
        dog["health"]["rank"],
        dog["health"]["rows"],
    ) == (False, True, 6, 12)
    assert [row["what"] for row in dog["tables"]["contacts"]] == ["not unique"] * 4 + [None]
    assert [row["impulse_z"] for row in pulled["tables"]["contacts"]] == pytest.approx(
        [1.5, -0.5, 1.0]
    )
    assert [row["friction_needed"] for row in pulled["tables"]["contacts"]] == [0.0, None, None]


@pytest.mark.slow
def test_scene_in_the_document_is_the_whole_scene(profile):
    """Its `scene` alone computes the same again; strike, base and posture are there even if nobody
    named them.

    What was chosen is stated in this scene, and so no longer among what it takes for granted. The
    twist that a sole needs is known where its corners are, which a contact of a given kind does not
    look for.
    """
    read = json.loads(json_text(document(profile)))
    assert {"robot", "base", "plane", "posture", "strike", "contact"} <= set(read["scene"])
    assert "reference" in read["scene"]["posture"]
    jsonschema.validate(read["scene"], scene_schema())
    again = TypeAdapter(Scene).validate_python(read["scene"])
    computed = json.loads(json_text(document(shock_profile(again))))
    for one in (read, computed):
        one["unknowns"] = [unknown for unknown in one["unknowns"] if unknown["status"] != "chosen"]
        for contact in (*one["tables"]["contacts"], one["units"]["contacts"]):
            contact.pop("twist_needed", None)
    assert json_text(computed) == json_text(read)


def test_same_bytes_every_time():
    """Two processes, with other hash seeds, write the same bytes."""
    code = "import sys; from shockpc.cli.entry import main; main(sys.argv[1:])"
    words = (
        "analyze",
        "anymal_b",
        "--contact",
        "*_FOOT",
        "--strike-angle",
        "30",
        "--format",
        "json",
    )
    first, second = (python(code, *words, PYTHONHASHSEED=seed) for seed in ("1", "2"))
    assert (first.returncode, first.stderr) == (0, "")
    assert first.stdout == second.stdout
    assert len(json.loads(first.stdout)) == 4


def test_text_of_numbers(profile):
    """Shortest round trip, no -0.0, no NaN, Unicode as it is."""
    text = json_text(document(profile))
    assert "NaN" not in text
    assert "Infinity" not in text
    assert "-0.0," not in text.replace("\n", ",")
    read = json.loads(text)
    assert json_text(read) == text
    records = [
        body for body in read["bodies"] if f"\n  {json.dumps(body, ensure_ascii=False)}" in text
    ]
    assert records == read["bodies"]  # a record a line


def test_health_without_a_number_is_null():
    """What was not computed, or is without bound, is null; warnings are objects."""
    profile = shock_profile(SCENES["beam that is pulled"])
    warning = Diagnostic("sensor", "imu", math.inf, "beyond its range")
    warned = health(
        error_bound=math.inf,
        body_error_bounds=(math.inf,),
        data_sensitivity=None,
        warnings=(warning,),
    )
    found = headed("profile", content(Altered(profile, health=warned)))["health"]
    assert [found[key] for key in ("error_bound", "body_error_bounds", "data_sensitivity")] == [
        None,
        [None],
        None,
    ]
    assert found["warnings"] == [
        {"kind": "sensor", "subject": "imu", "value": None, "text": "beyond its range"}
    ]
