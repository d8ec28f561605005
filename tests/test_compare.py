"""`shockpc compare`: every number is that of a single analysis; differences are ranked and matched
by name.
"""

import csv
import dataclasses
import io
import json
import math
import re
from itertools import pairwise

import numpy as np
import pytest
from commands import STICK_WITH_IMU, good, run, says
from robot_texts import loaded

from shockpc.evaluation.comparison import STANDARD, WITH_FRICTION
from shockpc.evaluation.designs import Design
from shockpc.evaluation.variations.vary import read_changes
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.strike import Strike
from shockpc.profile import shock_profile
from shockpc.quantities.selection import select
from shockpc.robot.changes import changed
from shockpc.robot.load import load_robot
from shockpc.show.report import Picture
from shockpc.studies.compare.report import compare_report
from shockpc.studies.compare.study import compare, design_with
from shockpc.text.errors import SolveError, StudyError

CHANGES = "mass:FL_calf=0.9x; armature:*_calf_joint=0.01"


def design(name, foot, **more):
    return Design(name, Scene(robot=name, contact=(Contact(frame=foot),), **more), load_robot(name))


@pytest.fixture(scope="module")
def dog():
    return design("go2", "FL_foot")


@pytest.fixture(scope="module")
def other(dog):
    return design_with(dog, read_changes(CHANGES))


@pytest.fixture(scope="module")
def found(dog, other):
    return compare([dog, other])


def numbers(comparison):
    return {
        (one.selection.name, row.place): row for one in comparison.quantities for row in one.rows
    }


def test_loads_that_are_not_determined_have_no_value(dog):
    """As in a sweep: on four feet with locked joints the contacts share the impulse in infinitely
    many ways.
    """
    feet = tuple(Contact(frame=f"{foot}_foot") for foot in ("FL", "FR", "RL", "RR"))
    locked = dataclasses.replace(
        dog, scene=dataclasses.replace(dog.scene, contact=feet, joints=Joints(model="locked"))
    )
    with pytest.raises(StudyError, match=r'"along" has no value at any joint.*redundant'):
        compare([locked, locked], ["along"])
    assert not {key for key, _ in numbers(compare([locked, locked]))} & {
        "joint_impulse",
        "joint_moment",
    }
    determined = {
        row.place: row.values
        for (key, _), row in numbers(compare([locked, dog])).items()
        if key == "joint_impulse"
    }
    assert all(values[0] is None and values[1] is not None for values in determined.values())


def test_every_number_is_that_of_a_single_analysis(dog):
    """Of the robot as it is, and of the changed robot, for quantities of every kind and those that
    are asked for.
    """
    changes = [
        changed(load_robot("go2"), read_changes(text)) for text in ("mass:FL_calf=1x", CHANGES)
    ]
    profiles = [shock_profile(dog.scene, robot) for robot in changes]
    asked = ("delta_qd@FL_*", "impulse.z", "energy_lost", "shock@base:0,0,0.1", "body.position")
    rows = numbers(compare([dog, design_with(dog, read_changes(CHANGES))], asked))
    expected = {
        (text, place.name): profile.value(wanted.key, wanted.of, [place])[0]
        for profile in profiles[1:]
        for text in STANDARD
        for wanted in [select(text).quantity]
        for place in profile.places(wanted.of)
    }
    known = {key: value for key, value in expected.items() if not math.isnan(value)}
    assert {
        key: row.values[1] for key, row in rows.items() if key[0] in STANDARD and ":" not in key[1]
    } == known
    for k, profile in enumerate(profiles):
        found = [
            rows[key].values[k]
            for key in (
                ("delta_qd", "FL_calf_joint"),
                ("impulse.z", "FL_foot"),
                ("energy_lost", "go2_description"),
                ("shock", "base:0,0,0.1"),
                ("body.position", "FL_calf"),
                ("joint_moment", "FL_calf_joint"),
            )
        ]
        load = next(load for load in profile.loads if load.joint == "FL_calf_joint")
        assert found == pytest.approx(
            [
                load.delta_qd,
                profile.contacts[0].impulse[2],
                profile.energy_lost,
                float(profile.shock_at("base", np.array([0.0, 0.0, 0.1]))),
                np.linalg.norm(profile.position[profile.bodies.index("FL_calf")]),
                np.linalg.norm(load.moment),
            ],
            rel=1e-14,
        )
    assert ("delta_qd", "FR_calf_joint") not in rows
    assert all(
        row.changes == (row.values[1] - row.values[0],)
        for row in rows.values()
        if None not in row.values
    )


def test_rows_begin_with_the_struck_limb_and_are_ranked_by_the_largest_change(found):
    """Radii of percussion by the change of their reciprocal, the shock per metre."""
    assert found.quantities[0].selection.name == "shock"
    for one in found.quantities:
        of = (lambda x: 1.0 / x) if one.selection.name == "ropc" else float
        rows, kind = list(one.rows), one.selection.quantity.of
        if kind in ("body", "joint"):
            limb = [f"FL_{part}{'_joint' * (kind == 'joint')}" for part in ("calf", "thigh", "hip")]
            limb = [name for name in limb if name in [row.place for row in rows]]
            assert [row.place for row in rows[: len(limb)]] == limb
            rows = rows[len(limb) :]
        sizes = [
            abs(of(row.values[1]) - of(row.values[0])) for row in rows if None not in row.values
        ]
        assert len(sizes) > 0
        assert all(a >= b for a, b in pairwise(sizes))


def test_short_tables_have_the_base(capfd):
    """It changes less than any other here."""
    text = good(capfd, "compare", "go2", "--contact", "FL_foot", "--change", "com-y:R*=0.01")
    table = text.partition("(shock_com)\n")[2].partition("\n\n")[0]
    assert [line.split()[0] for line in table.splitlines()[3:6]] == [
        "FL_calf",
        "FL_thigh",
        "FL_hip",
    ]
    assert "\nbase " in table
    assert "5 bodies with smaller values not shown" in table


def test_a_design_equals_itself(dog):
    assert {change for row in numbers(compare([dog, dog])).values() for change in row.changes} == {
        0.0
    }


def test_exchanged_designs_have_opposite_changes(found, dog, other):
    back = numbers(compare([other, dog]))
    for key, row in numbers(found).items():
        assert back[key].changes == tuple(
            None if change is None else -change for change in row.changes
        )


def test_third_design_is_compared_with_the_first(dog, other):
    third = design_with(dog, read_changes("mass:base=2x"))
    three, two = numbers(compare([dog, other, third])), numbers(compare([dog, third]))
    assert all(row.changes[1:] == two[key].changes for key, row in three.items())


LEGS = {"FL": "lf", "FR": "rf", "RL": "lh", "RR": "rh"}
LINKS = {"hip": "hipassembly", "thigh": "upperleg", "calf": "lowerleg"}
JOINTS = {"hip": "haa", "thigh": "hfe", "calf": "kfe"}


PAIRS = [
    ("base", "base_link"),
    ("imu", "trunk_imu"),
    *((f"{a}_{part}", f"{b}_{name}") for a, b in LEGS.items() for part, name in LINKS.items()),
    *(
        (f"{a}_{part}_joint", f"{b}_{name}_joint")
        for a, b in LEGS.items()
        for part, name in JOINTS.items()
    ),
]
"""Partners of Go2 in HyQ."""


def test_bodies_of_other_names_are_partners_as_given(dog):
    """By --pair alone; nothing is left over."""
    found = compare([dog, design("hyq", "lf_foot")], pairs=PAIRS)
    (partners,) = found.partners
    legs = {f"{a}_{part}": f"{b}_{name}" for a, b in LEGS.items() for part, name in LINKS.items()}
    assert partners["body"] == {"base": "base_link", **legs}
    assert partners["joint"] == {
        f"{a}_{part}_joint": f"{b}_{name}_joint"
        for a, b in LEGS.items()
        for part, name in JOINTS.items()
    }
    assert partners["point"] == {"imu": "trunk_imu"}
    assert found.unmatched == ()
    rows, hyq = numbers(found), shock_profile(found.designs[1].scene, found.designs[1].robot)
    assert (
        rows["shock_com", "FR_thigh / rf_upperleg"].values[1]
        == hyq.shock_com[hyq.bodies.index("rf_upperleg")]
    )
    assert ("effective_mass_sticking", "FL_foot / lf_foot") in rows


def test_new_names_change_nothing(tmp_path):
    """A robot of which every name is another one."""
    robots = [
        loaded(tmp_path, text, name)
        for name, text in (
            ("a.urdf", STICK_WITH_IMU),
            ("b.urdf", re.sub('(name|link)="(?!stick)', r'\1="new_', STICK_WITH_IMU)),
        )
    ]
    scenes = [
        Scene(robot=robot.label, contact=f"{new}foot")
        for robot, new in zip(robots, ("", "new_"), strict=True)
    ]
    found = compare(
        [Design(*parts) for parts in zip("ab", scenes, robots, strict=True)], pairs=[("*", "new_*")]
    )
    assert {change for row in numbers(found).values() for change in row.changes} == {0.0}
    assert found.unmatched == ()


def test_pairs_go_before_places_and_names(dog):
    """A glob has the same part in both; what is paired has no other partner."""
    other = design("hyq", "lf_foot")
    (partners,) = compare([dog, other], pairs=[("FL_hip", "rh_hipassembly")]).partners
    assert partners["body"]["FL_hip"] == "rh_hipassembly"
    assert "rh_hipassembly" not in [
        partner for name, partner in partners["body"].items() if name != "FL_hip"
    ]
    (partners,) = compare([dog, dog], pairs=[("FL_*", "RR_*")]).partners
    assert all(partners["body"][f"FL_{part}"] == f"RR_{part}" for part in LINKS)
    assert all(partners["joint"][f"FL_{part}_joint"] == f"RR_{part}_joint" for part in LINKS)
    third = compare([dog, other, dog], pairs=[("FL_hip", "rh_hipassembly"), ("FL_hip", "FR_hip")])
    assert [partners["body"]["FL_hip"] for partners in third.partners] == [
        "rh_hipassembly",
        "FR_hip",
    ]
    with pytest.raises(StudyError, match=r'"FL_hipp=lf_hip".*no body'):
        compare([dog, other], pairs=[("FL_hipp", "lf_hip")])


def test_designs_without_a_body_in_common_have_no_shock_of_bodies_to_compare(dog):
    with pytest.raises(StudyError, match="the designs have no bodies in common: of "):
        compare([dog, design("hyq", "lf_foot")], quantities=["shock_com"])


def test_what_has_no_partner_is_listed(dog):
    """What has another name has no partner, unless that is given."""
    found = compare([dog, design("solo8", "FL_FOOT")], pairs=[("base", "base_link")])
    assert {place for _, place in numbers(found) if "base" in place} == {"base / base_link"}
    listed = {(one.kind, one.name): one.designs for one in found.unmatched}
    assert listed["point", "imu"] == (0,)
    assert listed["body", "FL_calf"] == (0,)
    assert listed["joint", "FL_KFE"] == (1,)
    assert ("body", "base") not in listed


def test_two_landings_of_one_robot_are_told_apart(capfd):
    """Designs of the same name have letters of their own."""
    text = good(capfd, "compare", "go2", "go2", "--contact", "FL_foot", "--contact", "RL_foot")
    assert "A            go2: on FL_foot" in text
    assert "B            go2: on RL_foot" in text
    assert "\nFL_foot / RL_foot " in text


def test_one_robot_has_everything_in_common_with_its_changes(found):
    assert found.unmatched == ()


def test_a_warning_names_its_designs():
    """A knee strikes where the shank reaches lower; both designs do so, the second one on two legs."""
    knees = {
        name: tuple(Contact(frame=f"{leg}_calf", at="frame") for leg in legs)
        for name, legs in (("one", ["FL"]), ("two", ["FL", "FR"]))
    }
    dogs = [
        Design(name, Scene(robot="go2", contact=contact), load_robot("go2"))
        for name, contact in knees.items()
    ]
    closing = compare_report(compare([dogs[0], dogs[0], dogs[1]])).warnings
    assert [line.partition(": ")[0] for line in closing if "reach" in line] == [
        "warning of A and B",
        "warning of C",
    ]


def test_one_design_is_no_comparison(dog):
    with pytest.raises(StudyError, match="--change"):
        compare([dog])


def test_a_refusal_names_the_design(dog):
    """Two scenes of one robot cannot be told apart by the robot's name."""
    across = dataclasses.replace(
        dog.scene,
        strike=Strike(velocity=(0.0, 1.0, -1.0)),
        base="planar",
        plane="xz",
        joints=Joints(model="locked"),
    )
    with pytest.raises(SolveError, match=r"^across: no verdict: contact .* cannot be stopped"):
        compare([dog, Design("across", across, dog.robot)])


@pytest.mark.parametrize(
    ("joints", "told"),
    [(Joints(model="free"), "all joints free"), (Joints(armature={"*": 0.1}), "calf_joint")],
)
def test_change_of_an_armature_that_the_scene_overrides_is_refused(joints, told):
    with pytest.raises(StudyError, match=told):
        design_with(
            design("go2", "FL_foot", joints=joints), read_changes("armature:*_calf_joint=0.01")
        )


GO2 = ("compare", "go2", "--contact", "FL_foot", "--change", CHANGES)


def test_command_prints_a_table_for_each_quantity(capfd):
    text = good(capfd, *GO2)
    assert text.startswith("A            go2: on FL_foot")
    assert f"B            go2; {CHANGES}: on FL_foot" in text
    for key in STANDARD:
        assert f"\n{select(key).quantity.title} ({key})\n" in text


def test_documents_hold_the_same_numbers(capfd, tmp_path, found):
    good(capfd, *GO2, "--out", tmp_path)
    document = json.loads((tmp_path / "compare.json").read_text())
    assert document == json.loads(good(capfd, *GO2, "--format", "json"))
    assert document["schema"] == "shockpc.compare/2"
    assert [one["label"] for one in document["designs"]] == ["go2", f"go2; {CHANGES}"]
    assert document["designs"][1]["changes"] == CHANGES.split("; ")
    rows = numbers(found)
    written = {
        (row["quantity"], row["place"]): [row["A"], row["B"]]
        for row in document["tables"]["compare"]
    }
    assert written == {key: list(row.values) for key, row in rows.items()}
    table = list(csv.DictReader(io.StringIO((tmp_path / "compare.csv").read_text())))
    assert {(row["quantity"], row["place"]): float(row["B"]) for row in table} == {
        key: row.values[1] for key, row in rows.items()
    }
    report = (tmp_path / "report.md").read_text()
    assert "compare.svg" in report
    assert report.count("\n### ") == len(document["quantities"]) + 1, "and that of the drives"


def figure_of(*designs, pairs=()):
    """The figure as SVG."""
    report = compare_report(compare(designs, pairs=pairs))
    (picture,) = [block for block in report.body(True) if isinstance(block, Picture)]
    return picture.files()["compare.svg"].decode()


def test_figure_has_bars_beside_one_robot(dog, other):
    """A change of masses does not change the picture; names and paths are whole."""
    path = f"{'/a_long_name_of_a_folder' * 4}/robot.urdf"
    drawn = figure_of(dog, dataclasses.replace(other, label=path))
    assert path in drawn
    assert drawn.count(">x [m]<") == 1
    change = numbers(compare([dog, other]))["joint_impulse", "FL_calf_joint"]
    for text in (
        "FL_calf   4",
        "imu   a",
        "FL_calf_joint",
        f"{100 * change.changes[0] / change.values[0]:+.2g} %".replace("-", "−"),
    ):
        assert f">{text}<" in drawn


@pytest.mark.slow
def test_figure_shows_robots_that_look_different(dog):
    """In one colour scale; partners have one number."""
    drawn = figure_of(dog, design("hyq", "lf_foot"), pairs=PAIRS)
    assert drawn.count("normalised shock |Δv|") == 1
    assert drawn.count(">x [m]<") == 2
    assert ">FL_thigh / lf_upperleg   3<" in drawn
    assert (
        figure_of(dog, design_with(dog, read_changes("place:*_calf_joint=1.2x"))).count(">x [m]<")
        == 2
    )


def test_designs_may_be_scenes(capfd, tmp_path):
    """The same robot in two postures."""
    for name, knee in (("bent", -100), ("more", -80)):
        text = (
            f'robot = "anymal_b"\n[posture.joints_deg]\n"*F_KFE" = {knee}\n[[contact]]\nframe = '
            f'"LF_FOOT"\n'
        )
        (tmp_path / f"{name}.toml").write_text(text)
    document = json.loads(
        good(capfd, "compare", tmp_path / "bent.toml", tmp_path / "more.toml", "--format", "json")
    )
    assert [one["label"] for one in document["designs"]] == [
        str(tmp_path / "bent.toml"),
        str(tmp_path / "more.toml"),
    ]
    assert any(abs(row["B_minus_A"] or 0.0) > 1e-6 for row in document["tables"]["compare"])


def test_different_joint_models_are_said_to_be_part_of_the_changes(capfd):
    """The drives of Go2 are known and those of A1 are not: nearly all of the change is an effect of
    that.
    """
    words = ("compare", "go2", "a1", "--contact", "FL_foot")
    assert "A geared, B free" in run(capfd, *words).out
    assert "joint models" not in run(capfd, *words, "--joints", "free").out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("go2", "--contact", "FL_foot"), "a single design cannot be compared"),
        (("go2", "hyq", "--contact", "*_foot"), "has 4: FL_foot"),
        (
            ("go2", "hyq", "--contact", "*"),
            "has 31: base, FL_hip, FL_thigh, FL_calf, FL_foot, FL_calf_rotor and 25 more",
        ),
        (
            ("go2", "a1", "--contact", "FL_foot", "--change", "mass:base=2"),
            "several files are given",
        ),
        (("go2", "--contact", "FL_foot", "--change", "weight"), "is not a change"),
        (("go2", "--contact", "FL_foot", "--change", "mass:FL_cal=2x"), 'nearest: "FL_calf"'),
        (("go2", "nosuch", "--contact", "FL_foot"), 'no robot "nosuch"'),
        (("go2", "a1"), 'go2" has 9: FL_foot+FR_foot+RL_foot+RR_foot'),
    ],
)
def test_bad_arguments_are_refused(capfd, words, told):
    outcome = run(capfd, "compare", *words)
    assert (outcome.code, outcome.out) == (2, "")
    assert told in outcome.err


def test_a_quantity_at_no_place_of_all_designs_is_refused(capfd):
    """The second robot has no sensor, so there would be no table."""
    words = (
        "go2",
        "solo12",
        "--contact",
        "[FL][LF]_[fF]*",
        "--friction",
        "0.2",
        "--quantity",
        "shock_friction",
    )
    ended = run(capfd, "compare", *words)
    assert ended.code != 0
    assert all(
        word in ended.err for word in ("shock_friction", '"imu"', "of solo12 none", "--pair")
    )


def test_designs_that_land_with_friction_are_compared_with_friction(capfd, tmp_path):
    """On a ground on which the foot slides the numbers are those with friction of an analysis, and
    said to be not proven.
    """
    sliding = ("go2", "--contact", "FL_foot", "--strike-angle", "40", "--friction", "0.2")
    document = json.loads(
        run(capfd, "compare", *sliding, "--change", "mass:*_calf=0.9x", "--format", "json").out
    )
    names = [entry["quantity"] for entry in document["quantities"]]
    assert names == list(WITH_FRICTION)
    scene = Scene(
        robot="go2", contact="FL_foot", strike=Strike(strike_angle_deg=40.0), friction=0.2
    )
    profile = shock_profile(scene)
    values = profile.value("shock_com_friction", "body")
    shocks = dict(zip(profile.bodies, values.tolist(), strict=True))
    compared = {
        row["place"]: row["A"]
        for row in document["tables"]["compare"]
        if row["quantity"] == names[1]
    }
    assert compared == pytest.approx(shocks, rel=1e-12)
    assert abs(compared["base"] - profile.value("shock_com", "body")[0]) > 0.01
    text = run(
        capfd, "compare", *sliding, "--change", "mass:*_calf=0.9x", "--out", tmp_path / "out"
    ).out
    assert "in double precision: shock_friction" in text
    assert (
        "colours and CoPc: of contacts that stick" in (tmp_path / "out" / "compare.svg").read_text()
    )


def test_the_order_of_designs_is_judged_at_both_ends_of_the_drives(capfd):
    """Nobody knows the drives of A1: with locked joints, stated apart here, lighter calves have
    less impulse in the hips.
    """
    change = "mass:*_calf=0.8x"
    study = compare([Scene(robot="a1", contact=(Contact(frame="FL_foot"),))], changes=[change])
    locked = Scene(robot="a1", contact=(Contact(frame="FL_foot"),), joints=Joints(model="locked"))
    stated = compare([locked], changes=[change])
    assert not stated.ends
    for one, other in zip(study.ends["largest"].quantities, stated.quantities, strict=True):
        assert [row.place for row in one.rows] == [row.place for row in other.rows]
        for here, there in zip(one.rows, other.rows, strict=True):
            assert here.values == pytest.approx(there.values, rel=1e-9, abs=1e-12)
    words = ("compare", "a1", "--contact", "FL_foot", "--change", change)
    text = good(capfd, *words)
    assert says(
        text, "the order of the designs changes for 13 of 66 numbers: joint_impulse@FR_hip_joint"
    )
    assert says(text, "A smallest", "A largest", "B smallest", "B largest", "same order")
    assert "drives: " not in good(capfd, *words, "--joints", "locked")
