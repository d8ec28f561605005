"""The JSON document: exactly schema `shockpc.profile/1`, and exactly the numbers of the profile."""

import json
import math

import numpy as np
import pytest
from altered import Altered, health
from commands import ROBOTS, python
from pydantic import TypeAdapter

import shockpc
from shockpc import Closure, Contact, Joints, LoopEnd, Part, Point, Posture, Scene, Strike, shock_profile
from shockpc.landing.dynamics import PINOCCHIO
from shockpc.quantities.table import QUANTITIES
from shockpc.show.document import document
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import json_text

pytestmark = pytest.mark.smoke

DOG = {"robot": str(ROBOTS / "dog" / "dog.urdf.xacro"), "packages": {"dog_description": str(ROBOTS / "dog")}}
FEET = tuple(Contact(frame=f"{name}_foot") for name in ("lf", "rf", "lh", "rh"))
SCENES = {
    "dog on one foot": Scene(**DOG, contact=FEET[:1]),
    "dog on all feet": Scene(**DOG, contact=FEET, strike=Strike(drop_height=0.2), base="planar"),
    "dog that slides": Scene(
        **DOG,
        xacro={"payload": "1.5"},
        contact=Contact(frame="lf_foot", at="lowest", directions=("z",), restitution=0.5),
        posture=Posture(reference="crouched", base_rpy_deg=(5.0, 15.0, 0.0), joints_deg={"rh_*": -30.0}),
        point=(Point(frame="trunk", offset=(0.1, 0.0, 0.05)),),
        strike=Strike(velocity=(0.5, 0.1, -1.0)),
    ),
    "beam that translates": Scene(robot="beam", contact="center"),
    "anymal on a fixed base": Scene(robot="anymal_b", contact="LF_FOOT", base="fixed"),
    "dog whose front legs are tied together": Scene(
        **DOG,
        posture=Posture(joints_deg={"lf_hip": 20.0}),
        closure=(Closure(a=LoopEnd(frame="lf_foot"), b=LoopEnd(frame="rf_foot"), directions=("x", "z")),),
        contact=FEET[:1],
        joints=Joints(armature={"*_hip": 0.01}, locked=("lh_hip",)),
        pulse="half-sine:5ms",
        range_g=16.0,
        v_in="com",
        stance=("rh_foot",),
        part=(
            Part(name="camera", at="trunk:0,0,0.1", rating="half-sine 1500 g 0.5 ms", natural_frequency=300.0),
            Part(name="gear", joint="*_hip", momentary_torque=20.0),
        ),
    ),
    "talos on its soles": Scene(
        robot="talos", contact=(Contact(frame="left_sole_link", kind="flat"), Contact(frame="right_sole_link")), plane="yz"
    ),
    "dog with friction": Scene(**DOG, contact=FEET[:1], friction=0.1, strike=Strike(strike_angle_deg=30.0)),
    "dog on springs": Scene(**DOG, contact=FEET[:2], contact_stiffness=1e5, joints=Joints(armature={"*_hip": 0.01})),
    "dog on all feet, locked": Scene(**DOG, contact=FEET, joints=Joints(model="locked")),
    "beam that is pulled": Scene(
        robot="beam", contact=tuple(Contact(frame=frame, directions=("z",)) for frame in ("percussion", "tip"))
    ),
}

STRIKES = "most_severe:strike least_severe:strike"
FOOT = (
    "frame:str point:vector impulse:vector? friction_needed:float? approach:vector? mass_sticking:float? mass_frictionless:float? "
    "mitigation:float? mitigation_frictionless:float? moment:vector? effective_mass:float? pull:float?"
)
RECORDS = {
    "document": "schema:str shockpc:str pinocchio:str robot:robot scene:dict v_in:float bodies:body* points:point* "
    "contacts:contact* joint_model:str health:health stance:foot* total:total energy:energy joints:joint* bracket:row* "
    "assembly:assembly? loads_unique:bool depth:float? feasible:float needs_tilt:float friction:sliding? stiffness:springs? "
    "drives:drives margin_lost:lost? parts:part*",
    "lost": "contact_stiffness:float? place:str refused:str",
    "part": "part:str body:str joint:str? critical:critical? withstands:torque? delta_v:vector? shock:float? "
    "velocity_margin:float? peak_g:float? acceleration_margin:float? along:float? torque:float? "
    "part_margin:float? governed_by:str? missing:str?",
    "torque": "momentary_torque:float? duration:float? given:bool",
    "critical": "velocity_change:float acceleration:float? both:bool basis:str",
    "drives": "source:str? unknown:str* springs:str* spring_time:float?",
    "robot": "name:str file:str mass:float n_bodies:int nv:int",
    "body": "body:str links:str* placement:placement delta_omega:vector delta_v:vector copc:vector? copc_world:vector? ropc:float? "
    f"translates:bool pitch:float? off_plane:float shock_com:float shock_min:float? shock_max:float? {STRIKES} peak_g:float? "
    "delta_v_com:vector error_bound:float delta_v_max:float?",
    "placement": "position:vector rotation:matrix",
    "strike": "direction:vector shock:float",
    "point": f"frame:str body:str delta_v:vector shock:float {STRIKES} peak_g:float? position:vector shock_free:float? "
    "shock_locked:float? shock_springs_free:float? range_share:float?",
    "contact": FOOT,
    "health": "rank:int rows:int error_bound:float? body_error_bounds:float?* double_error:float data_sensitivity:float? bits:int "
    "warnings:warning*",
    "warning": "kind:str subject:str value:float? text:str",
    "foot": FOOT,
    "total": "impulse:vector moment:vector",
    "energy": "lost:float? share:float? made:float?",
    "joint": "joint:str position:float force:vector moment:vector along:float? delta_qd:float? joint_impulse:float "
    "joint_moment:float stop_impulse:float? stop_acts:bool rate_after:float? joint_torque_share:float?",
    "row": "place:str free:float? as_modelled:float locked:float? springs_free:float?",
    "assembly": "gap:float turn:float left:float retried:bool moved:step*",
    "step": "joint:str by:float",
    "sliding": "coefficient:float unchanged:bool total:total energy_lost:float solutions:int residual:float contacts:slip* "
    "bodies:struck* points:felt* joints:loaded*",
    "slip": "frame:str state:str impulse:vector slip:vector",
    "struck": "body:str delta_omega:vector delta_v:vector copc:vector? ropc:float? shock_com:float",
    "felt": "frame:str delta_v:vector shock:float peak_g:float?",
    "loaded": "joint:str along:float? delta_qd:float? joint_impulse:float joint_moment:float stop_impulse:float? stop_acts:bool "
    "rate_after:float?",
    "springs": "contact_stiffness:float difference:float compression:float contacts:pressed* bodies:jolted* points:shaken* "
    "joints:turned* modes:mode* springs_count:float? spectra:dict?",
    "pressed": "frame:str duration:float peak_force:float peak_force_time:float restitution:float",
    "shaken": "frame:str peak_acceleration:float peak_acceleration_time:float delta_v_compressed:vector shock_compressed:float "
    "delta_v_separated:vector shock_separated:float",
    "turned": "joint:str peak_joint_force:float peak_joint_moment:float peak_torque:float? peak_stop:float "
    "delta_qd_compressed:float? delta_qd_separated:float?",
    "jolted": "body:str shock_com_compressed:float shock_com_separated:float",
    "mode": "frequency:float energy:float force_share:dict contacts_share:float",
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
        return [fault for k, part in enumerate(value) for fault in misfits(LISTS.get(kind, kind[:-1]), part, f"{place}[{k}]")]
    if kind in RECORDS:
        keys = dict(word.split(":") for word in RECORDS[kind].split())
        if not isinstance(value, dict) or list(value) != list(keys):
            return [f"{place} is {value}"]
        return [fault for key, part in keys.items() for fault in misfits(part, value[key], f"{place}.{key}")]
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


def same(read, value):
    """Whether a value is read back to the last bit; null stands for what is not there, and for numbers that are not finite."""
    if isinstance(value, str | bool | None):
        return read == value
    array = np.asarray(value, dtype=float)
    return read is None if not np.isfinite(array).any() else np.array_equal(read, array)


def at(row, path):
    """What stands at a path such as "most_severe.shock"."""
    for key in path.split("."):
        row = row[key]
    return row


def test_document_is_the_table(profile):
    """Every quantity of every place is in the document, to the last bit, and so are the robot, the assembly and the warnings.

    What only a friction or a stiffness gives has sections of its own, with the same places.
    """
    read, robot, assembly = json.loads(json_text(document(profile))), profile.robot, profile.assembly
    assert (read["schema"], read["shockpc"], read["pinocchio"]) == ("shockpc.profile/1", shockpc.__version__, PINOCCHIO)
    size = {"name": robot.name, "file": robot.label, "mass": robot.mass, "n_bodies": len(robot.bodies), "nv": robot.model.nv}
    assert (read["robot"], read["joint_model"]) == (size, profile.joint_model)
    rows = {
        "robot": [read | read["health"] | {"mass": read["robot"]["mass"]}],
        "body": read["bodies"],
        "point": read["points"],
        "joint": read["joints"],
        "part": read["parts"],
    }
    rows["contact"] = [*read["contacts"], *read["stance"]]
    lists = {"body": "bodies", "point": "points", "joint": "joints", "contact": "contacts"}
    for quantity in QUANTITIES:
        section, _, path = (quantity.path or quantity.key).rpartition(":")
        if section and read[section] is None:
            continue
        path = f"placement.{path}" if (quantity.of, path) == ("body", "position") else path
        values = profile.values(quantity)
        shown = rows if not section else {kind: read[section].get(key) for kind, key in lists.items()} | {"robot": [read[section]]}
        assert len(values) == len(shown[quantity.of])
        assert all(same(at(row, path), value) for row, value in zip(shown[quantity.of], values, strict=True)), quantity.key
    assert [(body["body"], tuple(body["links"])) for body in read["bodies"]] == [(body.name, body.links) for body in robot.bodies]
    assert [body["placement"]["rotation"] for body in read["bodies"]] == profile.rotation.tolist()
    assert [foot["frame"] for foot in read["stance"]] == list(profile.scene.stance)
    assert [tuple(row.values()) for row in read["bracket"]] == list(profile.bracket)
    assert [tuple(warning.values()) for warning in read["health"]["warnings"]] == list(profile.health.warnings)
    moved = None if assembly is None else [{"joint": name, "by": by} for name, by, _ in assembly.moved]
    assert read["assembly"] == (
        assembly
        and {"gap": assembly.gap, "turn": assembly.turn, "left": assembly.left, "retried": assembly.retried, "moved": moved}
    )


def test_nulls_stand_where_things_do_not_exist():
    """Centres of what only translates; impulses, moments and loads that are not unique; friction where the ground would pull."""
    names = "beam that translates", "dog on all feet, locked", "beam that is pulled"
    beam, dog, pulled = (document(shock_profile(SCENES[name])) for name in names)
    assert [beam["bodies"][0][key] for key in ("copc", "copc_world", "ropc", "pitch", "shock_max")] == [None] * 4 + [1.0]
    assert (dog["loads_unique"], pulled["loads_unique"], dog["health"]["rank"], dog["health"]["rows"]) == (False, True, 6, 12)
    assert [(contact["impulse"], contact["friction_needed"]) for contact in dog["contacts"]] == [(None, None)] * 4
    assert [contact["impulse"][2] for contact in pulled["contacts"]] == pytest.approx([1.5, -0.5])
    assert [contact["friction_needed"] for contact in pulled["contacts"]] == [0.0, None]


def test_scene_in_the_document_is_the_whole_scene(profile):
    """Its `scene` alone computes the same bytes again; strike, base and posture are there even if nobody named them."""
    read = json.loads(json_text(document(profile)))
    assert {"robot", "base", "plane", "posture", "strike", "contact"} <= set(read["scene"])
    assert "reference" in read["scene"]["posture"]
    again = TypeAdapter(Scene).validate_python(read["scene"])
    assert json_text(document(shock_profile(again))) == json_text(document(profile))


def test_same_bytes_every_time():
    """Two processes, with other hash seeds, write the same bytes."""
    code = "import sys; from shockpc.cli.entry import main; main(sys.argv[1:])"
    words = ("analyze", "anymal_b", "--contact", "*_FOOT", "--strike-angle", "30", "--format", "json")
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
    records = [body for body in read["bodies"] if f"\n  {json.dumps(body, ensure_ascii=False)}" in text]
    assert records == read["bodies"]  # a record a line


def test_health_without_a_number_is_null():
    """What was not computed, or is without bound, is null; warnings are objects."""
    profile = shock_profile(SCENES["beam that is pulled"])
    warning = Diagnostic("sensor", "imu", math.inf, "beyond its range")
    warned = health(error_bound=math.inf, body_error_bounds=(math.inf,), data_sensitivity=None, warnings=(warning,))
    found = document(Altered(profile, health=warned))["health"]
    assert [found[key] for key in ("error_bound", "body_error_bounds", "data_sensitivity")] == [None, [None], None]
    assert found["warnings"] == [{"kind": "sensor", "subject": "imu", "value": None, "text": "beyond its range"}]
