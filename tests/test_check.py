"""`shockpc check`: budgets of landings, their formats, their baseline, and the exit code of each
outcome.
"""

import csv
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree as ET

import jsonschema
import numpy as np
import pytest
import yaml
from commands import STICK, STICK_WITH_IMU, good, run, says

import shockpc
from shockpc import Contact, Scene, ShockError, Strike, StudyError, assert_shock, shock_profile
from shockpc.evaluation.budgets import Budget, Budgets, Case, read_budgets
from shockpc.evaluation.variations.vary import read_changes
from shockpc.judgement.drive_range import DRIVES_REMEDY
from shockpc.landing.scenes.scene_file import plane_of
from shockpc.quantities.selection import QUANTITIES, select
from shockpc.robot.changes import changed
from shockpc.studies.check.command import EPILOG
from shockpc.studies.check.design_record import design_changes, design_record
from shockpc.studies.check.outcome import Outcome
from shockpc.studies.check.report import cause_notes, check_report
from shockpc.studies.check.study import check_budgets
from shockpc.studies.sweep.study import sweep
from shockpc.text.printed import printable

ACTION = Path(__file__).parents[1] / ".github/actions/check/action.yml"
GEOMETRY = (
    '<link name="shin"><collision><origin xyz="0 0 -0.2"/><geometry><box size="0.02 0.02 '
    '0.4"/></geometry></collision>'
)
NO_INERTIA = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
ROBOT = STICK_WITH_IMU.replace('<link name="shin">', GEOMETRY)
SCENE = (
    'robot = "stick.urdf"\npulse = "half-sine:5ms"\n[[contact]]\nframe = '
    '"foot"\n[posture]\njoints_deg = { knee = 20 }\n'
)
CASE = '[[case]]\nname = "land"\nscene = "landing.toml"\n'
ANGLES = CASE + "strike_angle_deg = [0, 15, 30]\n"
STUCK = '[[case]]\nname = "stuck"\nrobot = "massless.urdf"\n[[case.contact]]\nframe = "foot"\n'
EVERY_METRIC = {
    "shock": ("imu_link", "body", "foot:0,0,0.1"),
    "shock_max": ("shin",),
    "peak_g": ("imu_link", "body"),
    "ropc": ("body", "shin"),
    "joint_impulse": ("knee",),
    "friction_needed": ("foot",),
    "effective_mass": ("foot",),
}


def budget(**keys):
    """A budget in TOML."""
    return "[[budget]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())


PASSES, FAILS = (
    budget(at="imu_link", metric="shock", max=10),
    budget(at="imu_link", metric="shock", max=1e-3),
)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder with a stick, one whose shin has no mass, and a scene."""
    folder = tmp_path.resolve()
    monkeypatch.chdir(folder)
    for name in ("GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE"):
        monkeypatch.delenv(name, raising=False)
    (folder / "stick.urdf").write_text(ROBOT)
    massless = re.sub(
        r'<mass value="0.5"/>\s*<inertia .*?/>', '<mass value="0"/>' + NO_INERTIA, STICK
    )
    (folder / "massless.urdf").write_text(massless)
    (folder / "landing.toml").write_text(SCENE)
    return folder


def write(here, *parts, name="budgets.toml"):
    """A file of budgets."""
    (here / name).write_text("".join(parts), encoding="utf-8")
    return here / name


def document(capfd, *words, code=0):
    """The JSON document of a check."""
    outcome = run(capfd, "check", *words, "--format", "json")
    assert (outcome.code, outcome.err) == (code, "")
    return json.loads(outcome.out)


def refusal(capfd, *words):
    """The message of a check that is refused."""
    outcome = run(capfd, "check", *words)
    assert (outcome.code, outcome.out, outcome.err.count("\n")) == (2, "", 1), outcome
    return outcome.err

    # The numbers


NEEDS = "the scene gives no friction", "the scene gives no contact stiffness"
"""Why quantities have no value in a landing on rigid contacts that stick."""


def every_quantity():
    """A budget for every quantity of an analysis without friction or stiffness at all places, with
    limits that nothing exceeds.
    """
    entries = [entry for entry in QUANTITIES if not entry.scope.missing.startswith(NEEDS)]
    return [budget(metric=f"{entry.of}.{entry.key}", min=-1e12, max=1e12) for entry in entries]


def in_document(document, outcome):
    """The number of an outcome in the document of `analyze`; None where there is none, or no such
    place.
    """
    kind, key = outcome["metric"].split(".")
    place, entry, tables = outcome["at"], select(outcome["metric"]).quantity, document["tables"]
    if kind == "robot":
        records = [tables["landing"][0] | document["health"]]
    elif key.startswith(("most_severe", "least_severe")):
        records = [
            row
            for row in tables["directions"]
            if row["place"] == (f"CoM of {place}" if kind == "body" else place)
        ]
    else:
        records = [
            row for row in tables[{"body": "bodies"}.get(kind, f"{kind}s")] if row[kind] == place
        ]
    if not records:
        assert place.endswith("(centre of mass)")
        return None
    names = [f"{key}_{axis}" for axis in "xyz"] if entry.vector else [key]
    found = [records[0].get(name) for name in names]  # a column is there if some place has a value
    return None if None in found else found if entry.vector else found[0]


def test_every_quantity_is_that_of_an_analysis(capfd, here):
    """Each number of the table at each place is that of the document of the same landing; a missing
    one has a reason.
    """
    gear = '[joints.armature]\nknee = 0.01\n[[part]]\nname = "gear"\njoint = "knee"\n'
    sensor = (
        '[[part]]\nname = "IMU"\nat = "imu_link"\nrating = "half-sine 1500 g 0.5 '
        'ms"\nimu_bandwidth = "200Hz:2"\n'
    )
    (here / "landing.toml").write_text('imu_bandwidth = "200Hz"\n' + SCENE + gear + sensor)
    write(here, CASE, *every_quantity())
    analysis = json.loads(good(capfd, "analyze", "landing.toml", "--format", "json"))
    outcomes = document(capfd, code=3)["tables"]["check"]
    compared = set()
    for outcome in outcomes:
        expected = in_document(analysis, outcome)
        assert outcome["value"] is not None or (outcome["reason"] and expected is None), outcome
        if expected is not None:
            expected = np.linalg.norm(expected) if isinstance(expected, list) else float(expected)
            assert outcome["value"] == pytest.approx(expected, rel=1e-15, abs=1e-16)
            compared.add(outcome["metric"])
    # Of a foot that is a point, of joints without springs, of end stops, which the scene leaves
    # out, of sensors without range.
    undefined = {
        "contact.moment",
        "contact.twist_needed",
        "point.shock_springs_free",
        "joint.stop_impulse",
        "point.range_share",
    }
    assert (
        compared
        == {
            f"{entry.of}.{entry.key}"
            for entry in QUANTITIES
            if not entry.scope.missing.startswith(NEEDS)
        }
        - undefined
    )


def test_a_body_is_its_centre_of_mass_where_a_point_is_needed(here):
    """With the names of metrics that budgets always had; the mass is that of the contact as the
    scene has it.
    """
    scene = shockpc.read_scene(here / "landing.toml")
    sliding = Scene(**(vars(scene) | {"contact": (Contact(frame="foot", directions=("z",)),)}))
    metrics = (
        ("shock", "body"),
        ("peak_g", "body"),
        ("delta_v", "body"),
        ("shock", "foot:0,0,0.1"),
        ("effective_mass", "foot"),
    )
    for landing in (scene, sliding):
        wanted = tuple(Budget(at=at, metric=metric, max=1e9) for metric, at in metrics)
        outcomes = check_budgets(
            Budgets(None, (Case(name="land", **vars(landing)),), wanted, ())
        ).outcomes
        profile = shock_profile(landing)
        shock, contact = profile.shock_com[0], profile.contacts[0]
        peak, speed = np.pi / 2 * shock * profile.v_in / 5e-3 / 9.80665, shock * profile.v_in
        foot = float(profile.shock_at("shin", np.array([0.0, 0.0, -0.3])))
        mass = (
            contact.effective_mass_sticking
            if landing is scene
            else contact.effective_mass_frictionless
        )
        assert [outcome.value for outcome in outcomes] == pytest.approx(
            [shock, peak, speed, foot, mass], rel=1e-15
        )


def test_numbers_of_either_sign_need_both_limits_and_may_drift_in_neither_direction(capfd, here):
    """A joint's rate that jumps down is as severe as one that jumps up; a baseline tolerance holds
    on both sides.
    """
    write(here, CASE, budget(at="knee", metric="delta_qd", max=1.0))
    assert "may be of either sign; give both min and max" in refusal(capfd)
    (here / "landing.toml").write_text(SCENE.replace("knee = 20", "knee = -20"))
    names = ("delta_qd", "copc.x")
    write(here, CASE, *(budget(at="*", metric=name, baseline_tolerance="1%") for name in names))
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    for factor, status in (
        (0.98, "exceeded"),
        (0.995, "passed"),
        (1.005, "passed"),
        (1.02, "exceeded"),
    ):
        before = json.loads((here / "base.json").read_text())
        assert (
            min(entry["value"] for entry in before["values"] if entry["metric"] == "delta_qd") < 0.0
        )
        for entry in before["values"]:
            entry["value"] *= factor
        (here / "changed.json").write_text(json.dumps(before))
        outcomes = document(capfd, "--baseline", "changed.json", code=int(status == "exceeded"))[
            "tables"
        ]["check"]
        assert {one["status"] for one in outcomes} == {status}


def test_strike_angles_superpose(here):
    """The landings of a list of angles are products of one map with the strike, which is linear in
    its velocity.
    """
    angles = (-30.0, 0.0, 15.0, 75.0)
    scene = shockpc.read_scene(here / "landing.toml")
    budgets = Budgets(
        None,
        (Case(name="land", **vars(scene), strike_angle_deg=angles),),
        (Budget(at="body", metric="shock", max=9.0),),
        (),
    )
    profile = shock_profile(scene)
    map_of_com = profile.maps[0, 3:] - np.cross(profile.robot.coms[0], profile.maps[0, :3], axis=0)
    for angle, outcome in zip(angles, check_budgets(budgets).outcomes, strict=True):
        strike = np.array([np.sin(np.radians(angle)), 0.0, -np.cos(np.radians(angle))])
        assert outcome.value == pytest.approx(np.linalg.norm(map_of_com @ strike), rel=1e-14)


@pytest.mark.parametrize(
    ("metric", "at", "expected"),
    [
        ("shock", "*", ["body (centre of mass)", "shin (centre of mass)", "imu_link"]),
        ("shock", "imu_joint*", None),
        ("shock", "knee", ["knee"]),
        ("ropc", "*", ["body", "shin"]),
        ("ropc", "imu_link", ["body (carries imu_link)"]),
        ("joint_impulse", "k*", ["knee"]),
        ("joint_impulse", "foot", None),
        ("friction_needed", "*", ["foot"]),
        ("effective_mass", "shin", None),
        ("energy_lost", "*", ["stick"]),
        ("out_of_plane_share", "imu*", ["body"]),
    ],
)
def test_places_by_name_and_glob(here, metric, at, expected):
    """A name or a glob means points, bodies, joints or contacts, whichever the metric belongs to."""
    case = Case(name="land", **vars(shockpc.read_scene(here / "landing.toml")))
    budgets = Budgets(None, (case,), (Budget(at=at, metric=metric, max=9.0),), ())
    if expected is None:
        with pytest.raises(
            ShockError, match=f'case "land": no .* "{re.escape(at)}" in robot "stick"'
        ):
            check_budgets(budgets)
    else:
        assert [outcome.at for outcome in check_budgets(budgets).outcomes] == expected


def test_a_case_may_change_its_scene_file_or_need_none(capfd, here):
    """Keys of a scene in a case replace those of its file; a case without a file has them all."""
    inline = SCENE.replace("[[contact]]", "[[case.contact]]").replace("[posture]", "[case.posture]")
    write(
        here,
        CASE,
        "strike = { speed = 2 }\n",
        f'[[case]]\nname = "inline"\n{inline}',
        budget(at="knee", metric="joint_impulse", max=9),
    )
    fast, inline = (one["value"] for one in document(capfd)["tables"]["check"])
    assert fast == pytest.approx(2.0 * inline, rel=1e-14)


# Exit codes


@pytest.mark.parametrize(
    ("parts", "code"),
    [
        ((CASE, PASSES), 0),
        ((CASE, FAILS), 1),
        ((CASE, PASSES, FAILS), 1),
        ((CASE, FAILS, 'severity = "warning"\n'), 0),
        ((CASE, budget(at="body", metric="ropc", min=1e6)), 1),
        ((CASE, budget(at="nowhere", metric="shock", max=1)), 2),
        ((CASE, STUCK, budget(at="body", metric="shock", max=9)), 3),
        ((CASE, STUCK, budget(at="body", metric="shock", max=1e-9)), 1),
        ((CASE, STUCK, budget(at="body", metric="shock", max=9, severity="warning")), 0),
        ((CASE, budget(at="body", metric="shock_max", max=9)), 3),
    ],
    ids=[
        "met",
        "exceeded",
        "one of two",
        "warning",
        "below",
        "unknown",
        "unsolved",
        "both",
        "unsolved warning",
        "no geometry",
    ],
)
def test_exit_codes(capfd, here, parts, code):
    """0 met, 1 exceeded, 2 bad input, 3 not computed and nothing exceeded; a budget of severity
    warning passes in any case.
    """
    write(here, *parts)
    assert run(capfd, "check").code == code


# Drives that are not known

A1 = '[[case]]\nname = "a1"\nrobot = "a1"\ncontact = "FL_foot"\n'
UNKNOWN = budget(at="trunk", metric="shock", max=0.01)


@pytest.mark.parametrize(
    ("parts", "statuses", "code"),
    [
        ((A1, UNKNOWN), ["undecided"], 3),
        ((A1, 'joints = { model = "free" }\n', UNKNOWN), ["passed"], 0),
        ((A1, 'joints = { drives = "go2" }\n', UNKNOWN), ["exceeded"], 1),
        ((A1, UNKNOWN, 'severity = "warning"\n'), ["undecided"], 0),
        (
            (A1, UNKNOWN, budget(at="FL_calf", metric="shock", max=0.5)),
            ["undecided", "exceeded"],
            1,
        ),
        ((A1, budget(at="trunk", metric="shock", max=0.9)), ["passed"], 0),
        ((A1, budget(at="trunk", metric="shock", min=0.1)), ["undecided"], 3),
        ((A1, budget(at="trunk", metric="shock", min=1e-6, max=1e-5)), ["exceeded"], 1),
        ((A1, budget(at="FL_foot", metric="effective_mass", max=1.0)), ["undecided"], 3),
        ((A1, budget(at="FL_foot", metric="effective_mass", max=8.0)), ["passed"], 0),
    ],
    ids=[
        "unknown",
        "none",
        "given",
        "warning",
        "exceeded",
        "above",
        "min",
        "both",
        "mass",
        "all masses",
    ],
)
def test_what_the_drives_decide_is_undecided(capfd, here, parts, statuses, code):
    """A limit that some drives meet and others do not is not passed; one that all meet is, and what
    exceeds another one wins.
    """
    write(here, *parts)
    found = document(capfd, code=code)
    assert [row["status"] for row in found["tables"]["check"]] == statuses
    for row in found["tables"]["check"]:
        if row["smallest"] is not None:
            assert row["smallest"] <= row["value"] <= row["largest"]


def test_undecided_in_every_format(capfd, here):
    """Every format has both ends, and the joints that decide; the page opens on that landing."""
    free = A1.replace('"a1"', '"free"', 1) + 'joints = { model = "free" }\n'
    write(here, free, A1, UNKNOWN)
    out = run(
        capfd,
        "check",
        "--format",
        "table",
        "--format",
        "junit=j.xml",
        "--format",
        "github=g.txt",
        "--format",
        "json=c.json",
    )
    assert out.code == 3
    assert out.out.startswith("budgets of 2 landings: 1 passed, 0 exceeded, 1 undecided; ")
    row = out.out.splitlines()[3]
    assert row.split() == [
        "undecided",
        "a1",
        "trunk",
        "shock",
        "-",
        "9.29e-04",
        "8.66e-04",
        "0.7145",
        "≤",
        "0.01",
    ]
    deciding = "the drives of FL_calf_joint, FL_thigh_joint, FL_hip_joint decide"
    assert out.out.count(deciding) == 1
    assert out.out.count(DRIVES_REMEDY) == 1
    assert all(
        word in out.out for word in ("--drives", "--rotor", "--armature", 'joints.model = "free"')
    )
    failure = ET.parse(here / "j.xml").getroot().find(".//failure")
    assert failure.get("type") == "undecided"
    reason = "from 0.000866 to 0.715 over the drives, so max 0.01 may be met or not; " + deciding
    assert failure.get("message") == reason
    # What to do is the same for all rows: it is a note, and in annotations, which stand alone.
    assert DRIVES_REMEDY in failure.text
    ((kind, properties, text),) = commands((here / "g.txt").read_text())
    assert (kind, properties["title"]) == ("error", "shockpc: undecided: shock at trunk")
    assert deciding in text
    assert DRIVES_REMEDY in text
    stated = json.loads((here / "c.json").read_text())
    assert f"where drives decide, {DRIVES_REMEDY}" in stated["notes"]
    (row,) = (row for row in stated["tables"]["check"] if row["status"] == "undecided")
    assert row["reason"] == reason
    assert (row["smallest"], row["largest"]) == (
        pytest.approx(8.66e-4, rel=1e-3),
        pytest.approx(0.7145, rel=1e-3),
    )
    assert row["range_kind"] == "corners"
    assert list(check_report(check_budgets(here / "budgets.toml")).landings) == ["a1", "free"]


def test_a_baseline_is_compared_as_modelled(capfd, here):
    """A robot that has not changed passes, whatever its drives; a change for the worse is exceeded."""
    write(here, A1, budget(at="trunk", metric="shock", baseline_tolerance="5%"))
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    (row,) = document(capfd, "--baseline", "base.json")["tables"]["check"]
    assert (row["status"], row["smallest"]) == ("passed", None)
    stated = json.loads((here / "base.json").read_text())
    stated["values"][0]["value"] /= 2.0
    (here / "base.json").write_text(json.dumps(stated))
    write(here, A1, budget(at="trunk", metric="shock", max=0.01, baseline_tolerance="5%"))
    (row,) = document(capfd, "--baseline", "base.json", code=1)["tables"]["check"]
    assert (row["status"], "baseline" in row["reason"]) == ("exceeded", True)


def test_margins_and_percentiles_are_decided_by_all_drives(capfd, here):
    """A part survives free joints and not stiff ones; random masses do not say what the drives are,
    and random drives do.
    """
    part = '[[case.part]]\nname = "board"\nat = "imu_link"\ncritical_velocity_change = 0.2\n'
    write(here, A1, part, budget(at="board", metric="part_margin", min=1))
    (row,) = document(capfd, code=3)["tables"]["check"]
    assert (row["status"], row["smallest"]) == ("undecided", pytest.approx(0.2 / 0.7145, rel=1e-3))
    for each, status, code in (("mass:*", "undecided", 3), ("armature:*", "passed", 0)):
        values = "±5%" if each == "mass:*" else "1e-9±1e-10"
        vary = f'designs = 4\n[[case.vary]]\neach = "{each}"\nvalues = "{values}"\n'
        write(here, A1, vary, budget(at="trunk", metric="shock", max=0.01, percentile=95))
        (row,) = document(capfd, code=code)["tables"]["check"]
        assert row["status"] == status


def test_assert_shock_fails_where_drives_decide():
    """The message is that of the table."""
    scene = Scene(robot="a1", contact=Contact(frame="FL_foot"))
    with pytest.raises(
        AssertionError, match=r"from 0\.000866 to 0\.715 over the drives, so max 0\.01 may be met"
    ):
        assert_shock(scene, at="imu_link", max=0.01)
    assert_shock(scene, at="imu_link", max=0.8)


def test_redundant_contacts_have_no_single_impulse(capfd, here):
    """What is determined only as a sum is never compared: along their line, two points of one body
    share it in any proportion.
    """
    joint = (
        '<joint name="beside" type="fixed"><origin xyz="0.1 0 0"/><parent link="foot"/><child '
        'link="twin"/></joint>'
    )
    twin = f'<link name="twin"/>{joint}</robot>'
    (here / "stick.urdf").write_text(ROBOT.replace("</robot>", twin))
    (here / "landing.toml").write_text(SCENE + '[[contact]]\nframe = "twin"\n')
    write(
        here,
        CASE,
        *(
            budget(metric=metric, max=9)
            for metric in ("joint_impulse", "joint_moment", "friction_needed", "impulse")
        ),
    )
    outcomes = document(capfd, code=3)["tables"]["check"]
    assert [one["value"] for one in outcomes] == [None] * 6
    assert all(
        "redundant" in one["reason"] and "not determined" in one["reason"] for one in outcomes
    )


# Files of budgets


def test_budgets_in_a_pyproject(capfd, here):
    """The same tables under [tool.shockpc] give the same numbers; a budgets.toml in the folder goes
    first.
    """
    write(here, ANGLES, FAILS)
    plain = document(capfd, code=1)
    nested = (ANGLES + FAILS).replace("[[", "[[tool.shockpc.")
    write(here, '[project]\nname = "dog"\n', nested, name="pyproject.toml")
    assert [
        one["value"] for one in document(capfd, "pyproject.toml", code=1)["tables"]["check"]
    ] == [one["value"] for one in plain["tables"]["check"]]
    write(here, CASE, PASSES)
    assert document(capfd)["file"].endswith("budgets.toml")
    (here / "budgets.toml").unlink()
    found = document(capfd, code=1)
    assert found["file"] == str(here / "pyproject.toml")
    assert [one["line"] for one in found["tables"]["check"]] == [7, 7, 7]
    (here / "pyproject.toml").write_text('[project]\nname = "dog"\n')
    assert "no table [tool.shockpc]" in refusal(capfd)
    (here / "pyproject.toml").unlink()
    assert "no budgets.toml" in refusal(capfd)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ("there is no case", "[[case]]")),
        (CASE, ("there is no budget", "[[budget]]")),
        ("[[buget]]\n", ("buget: no such key; nearest: budget",)),
        ("case = 3\n", ("case has to be a list of tables, each begun with [[case]]",)),
        (
            CASE + "strike_angel_deg = [0]\n" + PASSES,
            ("case[0].strike_angel_deg: no such key; nearest: strike_angle_deg",),
        ),
        (
            CASE + "strik = { speed = 2 }\n" + PASSES,
            ("case[0].strik: no such key; nearest: strike",),
        ),
        (
            CASE + "strike = { sped = 2 }\n" + PASSES,
            ("case[0].strike.sped: no such key; nearest: speed",),
        ),
        (
            CASE + "strike_angle_deg = 15\n" + PASSES,
            ("case[0].strike_angle_deg has to be a list", "not 15"),
        ),
        ("baseline = 3\n" + CASE + PASSES, ("baseline has to be text in quotes, not 3",)),
        (CASE + CASE + PASSES, ('two cases have the name "land"',)),
        ('[[case]]\nname = "land"\n' + PASSES, ("case[0] has neither a scene nor a robot",)),
        (
            '[[case]]\nscene = "landing.toml"\n' + PASSES,
            ("case[0].name is missing; every case needs it",),
        ),
        (
            '[[case]]\nname = "a"\nscene = "away.toml"\n' + PASSES,
            ('no scene file "HERE/away.toml"',),
        ),
        ('[[case]]\nname = "a"\nscene = ""\n' + PASSES, ("case[0]: the path is empty",)),
        (
            CASE + budget(at="a", metrc="shock"),
            ("budget[0].metric is missing", "budget[0].metrc: no such key; nearest: metric"),
        ),
        (
            CASE + budget(at="a", metric="shok", max=1),
            ('budget[0]: no quantity "shok"', 'nearest: "shock"', "shockpc quantities"),
        ),
        (
            CASE + budget(at="a", metric="shock"),
            ("budget[0]: shock at a has no limit; give max, min or baseline_tolerance",),
        ),
        (
            CASE + budget(at="a", metric="shock", max=1, min=2),
            ("budget[0]: shock at a: min 2 is above max 1",),
        ),
        (
            CASE + budget(at="a", metric="shock", baseline_tolerance="5 percent"),
            ('"5 percent" is not valid', '"5%"'),
        ),
        *(
            (
                CASE + budget(at="a", metric="shock", baseline_tolerance=text),
                (f'"{text}" is not valid',),
            )
            for text in ("1e400%", "nan", "inf", "1_0%", "١%", "-5%", "5", "0.01 kg")
        ),
        *(
            (CASE + f"{PASSES.replace('10', number)}", ("budget[0].max has to be a number",))
            for number in ("nan", "inf", "1e400", "true", '"1"')
        ),
        (
            CASE + budget(at="a", metric="shock", max=1, severity="fatal"),
            ('severity has to be "error" or "warning"',),
        ),
        (
            CASE + budget(case="lnd*", at="body", metric="shock", max=1),
            ('no case "lnd*"', "budget[0]", '"land"'),
        ),
        (
            CASE + budget(at="imu_lnk", metric="shock", max=1),
            ('no point or body "imu_lnk"', '"imu_link"'),
        ),
        (
            CASE + budget(at="imu_link:1,2", metric="shock", max=1),
            ('"imu_link:1,2" is not a point', "imu_link:0,0,0.1"),
        ),
        (
            CASE + "strike = { velocity = [0, 0, -1] }\nstrike_angle_deg = [0]\n" + PASSES,
            ("given in two ways",),
        ),
        (CASE + "strike = { speed = 2 }\ndrop_height = 0.2\n" + PASSES, ("given in two ways",)),
        (
            CASE + "strike = { velocity = [0, 0, -1] }\ndrop_height = 0.2\n" + PASSES,
            ("given in two ways",),
        ),
        (
            CASE + "strike = { drop_height = 0.1 }\ndrop_height = 0.2\n" + PASSES,
            ("drop_height is given for the case and",),
        ),
        (
            CASE + "strike = { strike_angle_deg = 9 }\nstrike_angle_deg = [0]\n" + PASSES,
            ("strike_angle_deg is given for the",),
        ),
        (CASE + "strike_angle_deg = [170]\n" + PASSES, ('case "land"', "strike angle")),
        (
            STUCK + budget(at="body", metric="peak_g", max=1),
            ("peak_g needs the duration of the impact", "half-sine:5ms"),
        ),
        ("[[case]\n", ("budgets.toml:1 is not TOML, as a budgets file has to be",)),
    ],
)
def test_bad_budgets(capfd, here, text, said):
    """What is wrong in a file is refused before anything is computed, with its place and what would
    be valid.
    """
    write(here, text)
    message = refusal(capfd).replace(str(here), "HERE")
    assert [part for part in said if part not in message] == [], message


def test_a_case_without_a_budget_is_noted(capfd, here):
    """A case that no budget belongs to is not computed, and that is said."""
    write(here, CASE, STUCK, budget(case="land", at="body", metric="shock", max=9))
    found = document(capfd)
    assert found["landings"] == 1
    assert 'case "stuck" has no budget' in found["notes"]


# Formats

ODD = "a<b>&\"c'|,:% 100\n::error::d\x1b[2J`é"


def odd(here):
    """A failing and a passing budget of a case whose name would break every format."""
    write(here, CASE.replace('"land"', json.dumps(ODD)), FAILS, PASSES)


def test_text_and_json(capfd, here):
    odd(here)
    outcome = run(capfd, "check")
    assert outcome.code == 1
    assert all(line.isprintable() for line in outcome.out.splitlines())
    assert not any(line.lstrip().startswith("::") for line in outcome.out.splitlines())
    assert outcome.out.startswith(
        "budgets of 1 landing: 1 passed, 1 exceeded; rounding error below "
    )
    rows = [
        line.split()[0]
        for line in outcome.out.splitlines()
        if line.startswith(("exceeded", "passed"))
    ]
    found = document(capfd, code=1)
    assert found["schema"] == "shockpc.check/2"
    assert (found["exit_code"], found["counts"]) == (
        1,
        {"passed": 1, "exceeded": 1, "undecided": 0, "not_computed": 0, "skipped": 0},
    )
    assert 0.0 < found["error_bound"] <= 1e-15
    assert [one["case"] for one in found["tables"]["check"]] == [ODD, ODD]
    assert [one["status"] for one in found["tables"]["check"]] == rows == ["exceeded", "passed"]
    assert (
        reason := found["tables"]["check"][0]["reason"]
    ) == f"{found['tables']['check'][0]['value']:.6g} is above max 0.001"
    assert outcome.out.count(reason) == outcome.out.count("exceeded  ") == 1


def test_an_infinite_radius_is_a_value(capfd, here):
    """A body that only translates has an infinite radius of percussion: above every max, and JSON
    names it.
    """
    (here / "landing.toml").write_text(
        SCENE.replace("knee = 20", "knee = 0").replace('"foot"', '"foot"\ndirections = ["z"]')
    )
    text = ROBOT.replace('xyz="0.01 0 0.05"', 'xyz="0 0 0.05"')
    (here / "stick.urdf").write_text(text)
    write(
        here,
        CASE,
        budget(at="body", metric="ropc", max=1e9),
        budget(at="body", metric="ropc", min=1),
    )
    above, below = document(capfd, code=1)["tables"]["check"]
    assert (above["value"], above["status"], below["status"]) == ("inf", "exceeded", "passed")
    assert run(capfd, "check", "--baseline", "base.json", "--update-baseline").code == 1
    assert run(capfd, "check", "--baseline", "base.json").code == 1
    write(here, CASE, budget(at="body", metric="ropc", baseline_tolerance="5%"))
    assert run(capfd, "check", "--baseline", "base.json").code == 0
    (here / "stick.urdf").write_text(ROBOT)
    assert run(capfd, "check", "--baseline", "base.json").code == 1


def test_junit(capfd, here):
    """A suite for each case, a test for each budget; counts agree with what is listed."""
    write(
        here,
        CASE.replace('"land"', json.dumps(ODD)),
        STUCK,
        FAILS.replace("imu_link", "body"),
        FAILS.replace("imu_link", "body") + 'severity = "warning"\n',
    )
    assert run(capfd, "check", "--format", "junit=report.xml") == (1, "", "")
    root = ET.parse(here / "report.xml").getroot()
    suites = root.findall("testsuite")
    assert root.tag == "testsuites"
    assert [suite.get("name") for suite in suites] == [
        ODD.replace("\n", "\\n").replace("\x1b", "\\x1b"),
        "stuck",
    ]
    for part in (*suites, root):
        tests = list(part.iter("testcase"))
        assert int(part.get("tests")) == len(tests)
        assert int(part.get("failures")) == len(list(part.iter("failure")))
        assert int(part.get("errors")) == len(list(part.iter("error")))
    first, second, *stuck = root.iter("testcase")
    assert [child.tag for child in first] == ["failure"]
    assert "is above max 0.001" in first.find("failure").get("message")
    assert [child.tag for child in second] == ["system-out"]
    error, warning = stuck
    assert error.find("error").get("type") == "not computed"
    assert [child.tag for child in warning] == ["system-out"]
    assert (first.get("file"), first.get("line")) == ("budgets.toml", "9")
    names = [(test.get("classname"), test.get("name")) for test in root.iter("testcase")]
    assert names[0][1] == "shock at body (centre of mass): max"
    for part in (*suites, root):
        times = [float(test.get("time")) for test in part.iter("testcase")]
        assert float(part.get("time")) == pytest.approx(sum(times), abs=1e-3)
    assert float(root.get("time")) > 0.0


def test_csv_says_each_thing_once(capfd, here):
    """The columns are those of the table in Python, of which none repeats another in other words."""
    write(here, CASE, PASSES, FAILS + 'severity = "warning"\n')
    rows = list(csv.DictReader(run(capfd, "check", "--format", "csv").out.splitlines()))
    keys = {heading.partition(" [")[0] for heading in rows[0]}
    columns = check_budgets(here / "budgets.toml").table.columns
    assert keys == {heading.removesuffix("_deg") for heading in columns}
    assert [row["status"] for row in rows] == ["passed", "exceeded"]
    assert not keys & {"result", "verdict", "landing", "limit"}


COMMAND = re.compile(r"::(?P<kind>error|warning)(?: (?P<properties>[^\n]*?))?::(?P<data>[^\n]*)")


def commands(text):
    """GitHub's workflow commands, parsed as its runner parses them: (kind, properties, message)."""

    def plain(part, property_=False):
        for code, sign in [
            ("%0D", "\r"),
            ("%0A", "\n"),
            *([("%3A", ":"), ("%2C", ",")] if property_ else []),
            ("%25", "%"),
        ]:
            part = part.replace(code, sign)
        return part

    found = []
    for line in text.splitlines():
        match = COMMAND.fullmatch(line)
        assert match, line
        pairs = (pair.split("=", 1) for pair in match["properties"].split(","))
        found.append(
            (match["kind"], {key: plain(value, True) for key, value in pairs}, plain(match["data"]))
        )
    return found


def test_github(capfd, here, monkeypatch):
    """An annotation at the line of the budget, and a table in the job's summary after what is there
    already.
    """
    (here / "robot").mkdir()
    for name in ("stick.urdf", "landing.toml"):
        (here / name).rename(here / "robot" / name)
    write(
        here / "robot",
        CASE.replace('"land"', json.dumps(ODD)),
        FAILS,
        FAILS,
        'severity = "warning"\n',
        PASSES,
        name="a,b:c%.toml",
    )
    (here / "summary.md").write_text("# Before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(here / "summary.md"))
    monkeypatch.setenv("GITHUB_WORKSPACE", str(here))
    monkeypatch.chdir(here / "robot")
    outcome = run(capfd, "check", "a,b:c%.toml", "--format", "github")
    assert (outcome.code, outcome.err) == (1, "")
    (kind, properties, message), warning = commands(outcome.out)
    assert kind == "error"
    assert properties == {
        "file": "robot/a,b:c%.toml",
        "line": "4",
        "title": "shockpc: shock at imu_link",
    }
    assert message.startswith(f"{printable(ODD)}: shock at imu_link: ")
    assert says(message, "max 0.001", "free", "'a,b:c%.toml:a<b>")
    assert warning[0] == "warning"
    summary = (here / "summary.md").read_text(encoding="utf-8")
    assert summary.startswith(
        "# Before\n### Budgets of 1 landing: 1 passed, 1 exceeded, 1 exceeded with a warning"
    )
    assert len(table(summary)) == 3


def test_the_action_runs_the_check(here):
    """The step of the composite action, run as a runner does: with the inputs in the environment."""
    action = yaml.safe_load(ACTION.read_text())
    step = next(step for step in action["runs"]["steps"] if "shockpc check" in step.get("run", ""))
    inputs = {name: entry["default"] for name, entry in action["inputs"].items()}
    given = {name: inputs[text.split(".")[1].rstrip(" }")] for name, text in step["env"].items()}
    given["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    write(here, ANGLES, FAILS)
    done = subprocess.run(
        ["bash", "-ec", step["run"]],
        env=os.environ | given,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (1, "")
    assert "::error" in done.stdout
    assert (here / "shock" / "junit.xml").is_file()


def test_github_shows_ten_annotations(capfd, here):
    """Errors go first; the tenth annotation counts those that are left out."""
    warnings = (FAILS + 'severity = "warning"\n') * 4
    write(here, ANGLES, warnings, FAILS, FAILS)
    outcome = run(capfd, "check", "--format", "github")
    found = commands(outcome.out)
    assert [kind for kind, *_ in found] == ["error"] * 6 + ["warning"] * 4
    assert found[-1][2] == "9 more budgets not met; the summary of the run lists them"


def table(text):
    """The rows of a Markdown table as dictionaries."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    assert len({len(row) for row in cells}) == 1
    assert all(re.fullmatch("-+:?", cell) for cell in cells[1])
    return [dict(zip(cells[0], row, strict=True)) for row in cells[2:]]


def test_markdown_shows_the_change_against_the_baseline(capfd, here):
    """A tenth more mass in the body: the table has both numbers and the change in percent."""
    write(
        here,
        CASE.replace('"land"', json.dumps(ODD)),
        budget(at="foot", metric="effective_mass", baseline_tolerance="1%"),
    )
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    before = json.loads((here / "base.json").read_text())["values"][0]["value"]
    (here / "stick.urdf").write_text(ROBOT.replace('mass value="2"', 'mass value="2.2"'))
    outcome = run(capfd, "check", "--baseline", "base.json", "--format", "markdown")
    assert (outcome.code, outcome.err) == (1, "")
    (row,) = table(outcome.out)
    value = document(capfd, "--baseline", "base.json", code=1)["tables"]["check"][0]["value"]
    assert float(row["value"]) == pytest.approx(value, rel=1e-3)
    assert float(row["baseline"]) == pytest.approx(before, rel=1e-3)
    assert float(row["change [%]"]) == pytest.approx(100.0 * (value / before - 1.0), rel=1e-3)
    assert row["limit"] == "≤ baseline + 1%"
    assert "<b>" not in outcome.out


def test_several_formats_at_once(capfd, here):
    """Each goes into its file; standard output holds one document."""
    write(here, CASE, PASSES)
    files = [
        "--format",
        "json=r.json",
        "--format",
        "junit=r.xml",
        "--format",
        "markdown=r.md",
        "--format",
        "github=r.txt",
    ]
    files += ["--format", "csv=r.csv"]
    assert good(capfd, "check", *files, "--format", "table").startswith(
        "budgets of 1 landing: 1 passed"
    )
    assert json.loads((here / "r.json").read_text())["exit_code"] == 0
    assert ET.parse(here / "r.xml").getroot().get("tests") == "1"
    assert len(table((here / "r.md").read_text())) == 1
    assert (here / "r.txt").read_text() == ""
    assert next(csv.DictReader((here / "r.csv").read_text().splitlines()))["status"] == "passed"
    assert "one document" in refusal(capfd, "--format", "json", "--format", "table")
    assert "valid are table, json, csv" in refusal(capfd, "--format", "yaml")
    assert 'no folder "away"' in refusal(capfd, "--format", "json=away/r.json")
    assert "is a folder" in refusal(capfd, "--format", "json=.")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--format", "json=stick.urdf"), '"stick.urdf" is read by the same command'),
        (("--format", "json=landing.toml"), '"landing.toml" is read by the same command'),
        (
            ("--baseline", "budgets.toml", "--update-baseline"),
            '"budgets.toml" is read by the same command',
        ),
        (("--format", "json=a", "--format", "junit=./a"), '"a" would be written twice'),
    ],
)
def test_outputs_replace_neither_inputs_nor_one_another(capfd, here, words, text):
    """And none of them is written."""
    write(here, CASE, PASSES)
    before = {path: path.read_text() for path in here.iterdir()}
    assert text in refusal(capfd, *words, "--format", "markdown=new.md")
    assert {path: path.read_text() for path in here.iterdir()} == before


def test_folder_of_results(capfd, here):
    """JSON, CSV, JUnit, Markdown and HTML of one check; the CSV has a number in each column of
    numbers.
    """
    write(here, ANGLES.replace("[0,", "[-10, 0,"), PASSES, FAILS)
    run(capfd, "check", "--out", "out")
    files = {"check.json", "check.csv", "report.html", "report.md", "junit.xml"}
    assert {path.name for path in (here / "out").iterdir()} == files | {".check.sha256"}
    with (here / "out" / "check.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = json.loads((here / "out" / "check.json").read_text())["tables"]["check"]
    assert [float(row["value"]) for row in rows] == [one["value"] for one in found]
    assert [float(row["strike_angle [deg]"]) for row in rows] == [-10, -10, 0, 0, 15, 15, 30, 30]
    passed = sum(one["status"] == "passed" for one in found)
    assert f"Budgets: {passed} passed, {len(found) - passed} exceeded" in (
        here / "out" / "report.html"
    ).read_text(encoding="utf-8")


# The baseline

TOLERANCES = "".join(
    budget(at=at, metric=metric, baseline_tolerance="0%")
    for metric, places in EVERY_METRIC.items()
    for at in places
)


def test_a_baseline_agrees_with_itself(capfd, here):
    """What was written is met with no tolerance at all, although it holds six digits."""
    write(here, ANGLES, TOLERANCES)
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    text = (here / "base.json").read_text(encoding="utf-8")
    found = document(capfd, "--baseline", "base.json")
    assert {one["change"] for one in found["tables"]["check"]} == {0.0}
    base = json.loads(text)
    assert base["shockpc"] == shockpc.__version__
    assert base["designs"][0]["joint_model"] == "free"
    assert all(float(f"{one['value']:.6g}") == one["value"] for one in base["values"])
    assert str(here) not in text
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    assert (here / "base.json").read_text(encoding="utf-8") == text


def test_the_order_of_a_baseline_is_that_of_its_names(capfd, here):
    """Budgets in another order write the same bytes."""
    write(here, ANGLES, CASE.replace('"land"', '"a"'), TOLERANCES)
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    parts = ["[[budget]]" + part for part in TOLERANCES.split("[[budget]]")[1:]]
    write(
        here,
        *reversed(parts),
        CASE.replace('"land"', '"a"'),
        ANGLES.replace("[0, 15, 30]", "[30, 0, 15]"),
    )
    good(capfd, "check", "--baseline", "again.json", "--update-baseline")
    assert (here / "base.json").read_bytes() == (here / "again.json").read_bytes()


@pytest.mark.parametrize(
    ("keys", "factor", "code"),
    [
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "5%"}, 1.04, 0),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "5%"}, 1.06, 1),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "5%"}, 0.5, 0),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "5%", "min": 0}, 0.5, 1),
        (
            {"metric": "effective_mass", "at": "foot", "baseline_tolerance": "5%", "max": 1e-3},
            1.0,
            1,
        ),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "1e9 kg"}, 2.0, 0),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "0.01%"}, 1.0002, 1),
        (
            {"metric": "effective_mass", "at": "foot", "baseline_tolerance": "0.01%, 1e9 kg"},
            1.0002,
            0,
        ),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "5%, 1e-9"}, 1.06, 1),
        ({"metric": "effective_mass", "at": "foot", "baseline_tolerance": "1e-9 kg"}, 1.06, 1),
        (
            {
                "metric": "effective_mass",
                "at": "foot",
                "baseline_tolerance": "5%",
                "severity": "warning",
            },
            1.06,
            0,
        ),
    ],
)
def test_tolerance_of_a_baseline(capfd, here, keys, factor, code):
    """All masses and inertias times a factor: so is the effective mass, and only a change for the
    worse counts.
    """
    write(here, CASE, budget(**keys))
    run(capfd, "check", "--baseline", "base.json", "--update-baseline")
    scaled = re.sub(
        r'(mass value|i[xyz]{2})="([^"]*)"',
        lambda found: f'{found[1]}="{float(found[2]) * factor!r}"',
        ROBOT,
    )
    (here / "stick.urdf").write_text(scaled)
    found = document(capfd, "--baseline", "base.json", code=code)
    assert found["tables"]["check"][0]["change"] == pytest.approx(factor - 1.0, abs=1e-5)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("knee = 20", "knee = 21"), "scene.posture.joints_deg.knee is 21.0 here and 20.0 there"),
        (("[[contact]]", 'plane = "yz"\n[[contact]]'), 'scene.plane is "yz" here and "xz" there'),
        (
            ("[posture]", "[strike]\nspeed = 2\n[posture]"),
            "scene.strike.speed is 2.0 here and 1.0 there",
        ),
        (
            ("[posture]", '[joints]\nmodel = "locked"\n[posture]'),
            'scene.joints.model is "locked" here and not set there',
        ),
    ],
)
def test_a_baseline_of_another_scene_is_refused(capfd, here, change, said):
    """Another landing has other numbers by right; the message names what differs."""
    write(here, ANGLES, PASSES)
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    (here / "landing.toml").write_text(SCENE.replace(*change))
    message = refusal(capfd, "--baseline", "base.json")
    assert said in message
    assert "--update-baseline" in message


def test_a_baseline_of_another_folder_or_with_more_points_is_accepted(capfd, here):
    """Where files are, and which points are read out besides, is not the landing."""
    write(here, ANGLES, PASSES, 'baseline_tolerance = "0%"\n')
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    (here / "moved").mkdir()
    for name in ("stick.urdf", "landing.toml", "budgets.toml"):
        (here / name).rename(here / "moved" / name)
    (here / "moved" / "landing.toml").write_text(SCENE + "[[point]]\nframe = 'foot'\n")
    good(capfd, "check", "moved/budgets.toml", "--baseline", "base.json")


def damaged_baselines():
    """Baselines against which a worse design could pass: values that are no numbers, entries that
    are there twice.
    """
    entry = (
        '{"case": "land", "strike_angle_deg": ANGLE, "at": "imu_link", "metric": "shock", "value": '
        "VALUE}"
    )
    text = (
        f'{{"schema": "shockpc.baseline/2", "shockpc": "1", "cases": {{}}, "designs": [], '
        f'"values": [{entry}]}}'
    )
    for value in (
        "NaN",
        "Infinity",
        '"inf"',
        "1e400",
        "1" + "0" * 400,
        "true",
        '"1_0"',
        "null",
        '1, "value": 2',
        "[1]",
    ):
        yield text.replace("VALUE", value).replace("ANGLE", "null")
    for angle in ("NaN", "[]"):
        yield text.replace("VALUE", "1").replace("ANGLE", angle)
    yield text.replace(entry, f"{entry}, {entry}").replace("VALUE", "1").replace("ANGLE", "0")
    design = (
        '{"cases": ["land"], "joint_model": "free", "drives": "", "joints": {}, "points": {}, '
        '"bodies": BODIES}'
    )
    of_design = text.replace('"designs": []', f'"designs": [{design}]').replace("VALUE", "1")
    specific = ('"x"', '"2"', '[1, "2"]', "NaN", "1e300", "[]", "[[1]]", "[1, [2]]")
    for bodies in (
        "[]",
        '{"a": 1}',
        '{"a": {"axes": [1]}}',
        *(f'{{"a": {{"mass": {value}}}}}' for value in specific),
    ):
        yield of_design.replace("BODIES", bodies).replace("ANGLE", "0")
    yield (
        text.replace("{}", '{"land": ' + "[" * 900 + "]" * 900 + "}")
        .replace("VALUE", "1")
        .replace("ANGLE", "0")
    )


def test_baselines_that_cannot_be_used(capfd, here):
    """Missing, not one, of another schema, or without a case or a value that a tolerance needs."""
    write(here, CASE, PASSES)
    assert 'no baseline "base.json"' in refusal(capfd, "--baseline", "base.json")
    assert "is a folder" in refusal(capfd, "--baseline", ".")
    assert "needs the file" in refusal(capfd, "--update-baseline")
    for text in (
        "",
        "[]",
        "{}",
        '{"schema": "shockpc.baseline/2"}',
        "[" * 100_000,
        '{"schema": "shockpc.baseline/2", "designs": [], "cases": {}, "shockpc": "1", "values": '
        "[3]}",
        *damaged_baselines(),
    ):
        (here / "base.json").write_text(text)
        assert "is not a baseline" in refusal(capfd, "--baseline", "base.json")
    (here / "base.json").write_text('{"schema": "other/1"}')
    assert "has schema other/1" in refusal(capfd, "--baseline", "base.json")
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    write(here, CASE, PASSES, budget(at="body", metric="shock", baseline_tolerance="5%"))
    assert 'has no shock at "body (centre of mass)"' in refusal(capfd, "--baseline", "base.json")
    write(here, CASE, budget(at="body", metric="shock", max=9))
    assert document(capfd, "--baseline", "base.json")["tables"]["check"][0]["baseline"] is None
    write(here, CASE.replace('"land"', '"other"'), PASSES)
    assert 'has no case "other"' in refusal(capfd, "--baseline", "base.json")


def test_a_baseline_is_whole_or_left_as_it_was(capfd, here):
    """A baseline without every number would let the missing ones change unnoticed."""
    write(here, CASE, PASSES)
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    before = (here / "base.json").read_bytes()
    write(here, CASE, STUCK, budget(at="body", metric="shock", max=9))
    outcome = run(capfd, "check", "--baseline", "base.json", "--update-baseline")
    assert outcome.code == 3
    assert '"base.json" is not changed' in outcome.err
    assert (here / "base.json").read_bytes() == before


def changes_of(scene, *texts):
    """What changed of go2's design by the changes of a text."""
    robot = shockpc.load_robot("go2")
    before, now = (
        design_record(shockpc.resolve(scene, changed(robot, texts_of)))
        for texts_of in ((), *(read_changes(t) for t in texts))
    )
    return list(design_changes(json.loads(json.dumps(before)), now))


def test_equal_changes_are_named_by_a_glob():
    """Numbers are those of the file and of the change; what does not change is not named."""
    robot, scene = shockpc.load_robot("go2"), Scene(robot="go2", contact="FL_foot")
    masses = {
        name.removeprefix("FL"): robot.masses[robot.body(name)]
        for name in ("base", "FL_hip", "FL_thigh", "FL_calf")
    }
    heavier = {
        f"{'*' * (name != 'base')}{name} mass {m:.3g} → {1.1 * m:.3g} kg"
        for name, m in masses.items()
    }
    assert {*changes_of(scene, "mass:*=1.1x")} == {*heavier, "* inertia × 1.1"}
    assert changes_of(scene, "mass:F*_hip=2x")[0].startswith(f"F*_hip mass {masses['_hip']:.3g} → ")
    assert changes_of(scene, "mass:FL_hip=2x; mass:RR_hip=2x")[0].startswith("FL_hip, RR_hip mass ")
    com = robot.bodies[0].com[2]
    assert changes_of(scene, "com-z:base=-0.02")[0].startswith(
        f"base centre of mass z {com:.3g} → "
    )
    armature = float(
        shockpc.resolve(scene, robot).joint_model.armature[robot.joint("FL_calf_joint").v][0]
    )
    geared = "armature:*_calf_joint=0.01"
    assert changes_of(scene, geared) == [
        f"*_calf_joint armature {armature:.3g} → 0.01 kg m²",
        f"*_calf_joint coupling of its rotor {armature / 12.13:.3g} → 0 kg m²",
    ]
    free = Scene(robot="go2", contact="FL_foot", joints=shockpc.Joints(drives="none"))
    assert changes_of(free, geared) == [
        "joint model free → mixed",
        "*_calf_joint armature 0 → 0.01 kg m²",
    ]
    assert changes_of(scene, "mass:*=1x") == []


def test_a_changed_gate_names_what_changed(capfd, here):
    """Mass, place of a sensor, of a foot and of a joint, and the joint model; one line on each
    output.
    """
    write(here, CASE, budget(at="imu_link", metric="shock", baseline_tolerance="0%"))
    good(capfd, "check", "--baseline", "base.json", "--update-baseline")
    text = (here / "base.json").read_text(encoding="utf-8")
    assert '"com": [0.01, 0.0, 0.05]' in text
    assert "since the baseline" not in good(capfd, "check", "--baseline", "base.json")
    changed_robot = ROBOT.replace('mass value="2"', 'mass value="1.5"').replace(
        'xyz="0.02 0 0.1"', 'xyz="0.5 0 0.1" rpy="0 0 0.5"'
    )
    changed_robot = changed_robot.replace('xyz="0 0 -0.4"', 'xyz="0 0 -0.45"')
    (here / "stick.urdf").write_text(changed_robot)
    outcome = run(
        capfd, "check", "--baseline", "base.json", "--format", "table", "--format", "junit=j.xml"
    )
    assert outcome.code == 1
    told = (
        "body mass 2 → 1.5 kg; foot place z -0.4 → -0.45 m; imu_link place x 0.02 → 0.5 m; "
        "imu_link rotated by 28.6 deg"
    )
    assert f"(joint model of land: free)\n(since the baseline: land: {told})" in outcome.out
    assert (
        f"; joint model free; since the baseline: {told}; shockpc analyze"
        in ET.parse(here / "j.xml").getroot().find(".//failure").text
    )
    assert document(capfd, "--baseline", "base.json", code=1)["changes"] == {
        "land": told.split("; ")
    }
    (here / "stick.urdf").write_text(ROBOT.replace('lower="-2"', 'lower="-1"'))
    base = json.loads(text)
    base["values"][0]["value"] *= 0.9
    (here / "base.json").write_text(json.dumps(base))
    assert (
        "since the baseline: land: no change of the bodies"
        in run(capfd, "check", "--baseline", "base.json").out
    )


def test_a_baseline_does_not_depend_on_the_folder_of_the_drives(capfd, here):
    """The path of a file of drives was a part of the scene."""
    for name in ("a", "b"):
        (here / name).mkdir()
        shutil.copy(here / "stick.urdf", here / name)
        (here / name / "drives.toml").write_text(
            '[[drive]]\njoint = ["knee"]\narmature = 0.01\nstatus = "published"\nsource = "x"\n'
        )
        (here / name / "landing.toml").write_text(f'{SCENE}[joints]\ndrives = "drives.toml"\n')
        write(here / name, CASE, PASSES)
    good(capfd, "check", "a/budgets.toml", "--baseline", "base.json", "--update-baseline")
    good(capfd, "check", "b/budgets.toml", "--baseline", "base.json")


def test_the_command_of_a_row_gives_its_number(capfd, here):
    """Of a case that changes its scene, at each strike angle, for quantities of every kind of
    place.
    """
    changes = "[case.strike]\nspeed = 2\n[case.posture.joints_deg]\nknee = 35\n"
    wanted = (
        *((metric, at) for metric, places in EVERY_METRIC.items() for at in places),
        ("delta_v", "body"),
        ("energy_lost", "*"),
    )
    write(
        here,
        CASE.replace('"land"', "\"land 'a'\""),
        "strike_angle_deg = [-10, 0.1]\n",
        changes,
        *(budget(at=at, metric=metric, min=-1e-9, max=-1e-9) for metric, at in wanted),
    )
    for outcome in document(capfd, code=1)["tables"]["check"]:
        (first, *words), place = shlex.split(outcome["command"]), outcome["at"]
        assert first == "shockpc"
        analysis = json.loads(good(capfd, *words, "--format", "json"))
        entry = select(outcome["metric"]).quantity
        at = (
            analysis["tables"]["points"][-1 if ":" in words[-1] else 0]["point"]
            if entry.of == "point"
            else place
        )
        row = {"metric": f"{entry.of}.{entry.key}", "at": at}
        value = in_document(analysis, row)
        assert outcome["value"] == pytest.approx(np.linalg.norm(value), rel=1e-14), outcome
    assert "budgets.toml:land 'a'" in shlex.split(outcome["command"])
    assert (
        "\nto compute these numbers anew\nshockpc analyze 'budgets.toml:land '"
        in run(capfd, "check").out
    )


def test_the_command_of_a_percentile_gives_its_number(capfd, here):
    write(here, VARIES, budget(at="imu_link", metric="shock", percentile=95, max=1e-6))
    (outcome,) = document(capfd, code=1)["tables"]["check"]
    words = shlex.split(outcome["command"])[1:]
    good(capfd, *words, "--prove=0", "--format=csv")
    summary = json.loads((here / "designs" / "summary.json").read_text())
    shown = next(row for row in summary["tables"]["summary"] if row["quantity"] == "shock@imu_link")
    assert shown["percentile_95"] == pytest.approx(outcome["value"], rel=1e-12)


def test_a_case_that_is_not_there_is_refused(capfd, here):
    write(here, CASE, PASSES)
    outcome = run(capfd, "analyze", "budgets.toml:lnd")
    assert (outcome.code, outcome.out) == (2, "")
    assert 'no case "lnd" in budgets.toml; nearest: "land"' in outcome.err


def test_a_budget_of_a_baseline_alone_is_skipped_without_one(capfd, here):
    """Its number is shown; the others are checked."""
    write(here, CASE, PASSES, budget(at="foot", metric="effective_mass", baseline_tolerance="5%"))
    out = good(capfd, "check", "--format", "table", "--format", "junit=j.xml")
    assert "1 passed, 0 exceeded, 1 skipped" in out
    assert "without a baseline no baseline_tolerance was checked" in out
    (row,) = [line for line in out.splitlines() if line.startswith("skipped")]
    assert "≤ baseline + 5%" in row
    assert ET.parse(here / "j.xml").getroot().get("skipped") == "1"
    assert document(capfd)["counts"] == {
        "passed": 1,
        "exceeded": 0,
        "undecided": 0,
        "not_computed": 0,
        "skipped": 1,
    }


def test_a_check_that_compares_nothing_is_refused(capfd, here):
    """It ended with exit code 0: budgets with only a baseline_tolerance have no limit without a
    baseline.
    """
    write(here, CASE, budget(at="foot", metric="effective_mass", baseline_tolerance="5%"))
    assert "there is no baseline to compare with" in refusal(capfd)


@pytest.mark.parametrize("file", ["budgets.toml", "pyproject.toml"])
def test_the_file_of_budgets_may_name_the_baseline(capfd, here, file):
    """Its path is relative to that file; --baseline replaces it."""
    (here / "gate").mkdir()
    wanted = budget(at="foot", metric="effective_mass", baseline_tolerance="5%")
    text = (CASE.replace("landing.toml", "../landing.toml") + wanted).replace(
        "[[", "[[tool.shockpc." * (file[0] == "p") or "[["
    )
    path = write(
        here / "gate",
        "[tool.shockpc]\n" * (file[0] == "p") + 'baseline = "base.json"\n',
        text,
        name=file,
    )
    assert f'no baseline "{here / "gate" / "base.json"}"' in refusal(capfd, path)
    good(capfd, "check", path, "--update-baseline")
    base = json.loads((here / "gate" / "base.json").read_text())
    assert document(capfd, path)["counts"]["passed"] == 1
    base["values"][0]["value"] /= 1.1
    (here / "other.json").write_text(json.dumps(base))
    assert document(capfd, path, "--baseline", "other.json", code=1)["counts"]["exceeded"] == 1


def test_keys_of_a_case_replace_those_of_its_scene_one_by_one(here):
    """A speed in the case left out the strike angle of the file without a word."""
    (here / "landing.toml").write_text(
        SCENE + "[strike]\nstrike_angle_deg = 30\n[joints]\narmature = { knee = 0.1, '*' = 0.2 }\n"
    )
    keys = "friction = 0.5\n[case.strike]\nspeed = 2\n[case.joints]\narmature = { knee = 0.3 }\n"
    (case,) = read_budgets(write(here, CASE + keys + PASSES)).cases
    ((_, scene),) = case.landings
    assert scene.strike == shockpc.Strike(speed=2.0, strike_angle_deg=30.0)
    assert list(scene.joints.armature.items()) == [("*", 0.2), ("knee", 0.3)]
    assert (scene.friction, scene.pulse) == (0.5, "half-sine:5ms")


def test_a_mass_at_the_contact_point_changes_the_effective_mass_alone(here):
    """It takes the velocity of the contact whatever its mass; what it weighs is added to the
    effective mass.
    """
    heavy = (
        NO_INERTIA.replace("<inertia ", '<inertial><mass value="0.3"/><inertia ') + "</inertial>"
    )
    (here / "heavy.urdf").write_text(
        ROBOT.replace('<link name="foot"/>', f'<link name="foot">{heavy}</link>')
    )
    light, heavy = (
        shock_profile(Scene(robot=f"{name}.urdf", contact="foot")) for name in ("stick", "heavy")
    )
    np.testing.assert_allclose(heavy.shock_com[0], light.shock_com[0], rtol=1e-13)
    for key in ("joint_impulse", "joint_moment"):
        np.testing.assert_allclose(
            heavy.value(key, "joint"), light.value(key, "joint"), rtol=1e-12, atol=1e-15
        )
    assert heavy.contacts[0].effective_mass_sticking == pytest.approx(
        light.contacts[0].effective_mass_sticking + 0.3, rel=1e-13
    )


# From Python


def test_assert_shock(here):
    """It passes, or fails with the row of the table."""
    scene = shockpc.read_scene(here / "landing.toml")
    assert_shock(scene, at="imu_link", max=10.0)
    assert_shock(here / "landing.toml", at="body", metric="ropc", min=1e-3)
    with pytest.raises(AssertionError) as failure:
        assert_shock(str(here / "landing.toml"), at="imu_link", metric="shock", max=1e-3)
    assert str(failure.value).startswith("landing: shock at imu_link: ")
    value = next(point.shock for point in shock_profile(scene).points if point.frame == "imu_link")
    (row,) = [line for line in str(failure.value).splitlines() if line.startswith("exceeded")]
    assert row.split()[:6] == ["exceeded", "landing", "imu_link", "shock", "-", f"{value:.4f}"]
    assert "is above max 0.001" in row


def test_assert_shock_refuses_what_it_cannot_compute(here):
    """No number is no assertion: the error says what to change."""
    scene = shockpc.read_scene(here / "landing.toml")
    with pytest.raises(ShockError, match="have to be finite"):
        assert_shock(scene, at="imu_link", max=float("nan"))
    with pytest.raises(ShockError, match="has no limit"):
        assert_shock(scene, at="imu_link")
    with pytest.raises(ShockError, match='nearest: "imu_link"'):
        assert_shock(scene, at="imu_lin", max=1.0)
    with pytest.raises(ShockError, match=r'no quantity "shok".*nearest: "shock"'):
        assert_shock(scene, at="imu_link", metric="shok", max=1.0)
    with pytest.raises(ShockError, match="the body has no geometry"):
        assert_shock(scene, at="body", metric="shock_max", max=1.0)
    with pytest.raises(ShockError, match="no mass or inertia resists it"):
        assert_shock(Scene(robot="massless.urdf", contact="foot"), at="body", max=1.0)


VARIES = (
    CASE
    + """designs = 100
[[case.vary]]
each = "mass:*"
values = "±10%"
[[case.vary]]
quantity = "com-z:body"
values = "±0.02"
"""
)


@pytest.mark.slow
@pytest.mark.parametrize("side", ["max", "min"])
def test_a_percentile_is_met_where_so_many_designs_meet_it(capfd, here, side):
    """The limit lies between two designs in order: just enough meet it, or one too few; numbers are
    those of single analyses.
    """
    # else drives that nobody knows decide
    (here / "landing.toml").write_text(SCENE + '[joints]\nmodel = "free"\n')
    case = read_budgets(write(here, VARIES + PASSES + "percentile = 95\n")).cases[0]
    robot = shockpc.load_robot("stick.urdf")
    made = sweep(
        case.landings[0][1],
        [("com-z:body", "±0.02")],
        vary_each=[("mass:*", "±10%")],
        sample=100,
        lhs=True,
        at=["imu_link"],
        robot=robot,
    )
    points = (shock_profile(*made.landings.case(row)).points for row in range(100))
    shocks = np.sort(
        [
            next(point.shock for point in of_design if point.frame == "imu_link")
            for of_design in points
        ]
    )
    if side == "min":
        shocks = shocks[::-1]
    for above, code in ((94, 0), (93, 1)):
        limit = {side: float(shocks[above] + shocks[above + 1]) / 2.0}
        path = write(here, VARIES + budget(at="imu_link", metric="shock", percentile=95, **limit))
        outcome = run(capfd, "check", path)
        assert outcome.code == code, outcome
    assert (
        f"{shocks[94]:.6g} (95 % of the designs) is {'above' if side == 'max' else 'below'} {side}"
        in outcome.out
    )


def test_a_percentile_of_designs_that_cannot_be_computed_is_no_verdict(capfd, here):
    """Not a percentile of the others."""
    far = VARIES + '[[case.vary]]\nquantity = "strike-angle"\nvalues = "80:100"\n'
    outcome = run(
        capfd,
        "check",
        write(here, far + budget(at="imu_link", metric="shock", percentile=95, max=10)),
    )
    assert outcome.code == 3
    assert "of 100 designs: contact" in outcome.out


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (VARIES + PASSES, "no budget of it has a percentile"),
        (CASE + PASSES + "percentile = 95\n", "nothing that varies"),
        (VARIES + PASSES + "percentile = 5\n", "from 50 to 100 %"),
        (VARIES + PASSES + 'percentile = 95\nbaseline_tolerance = "5%"\n', "a baseline has none"),
        (VARIES.replace("100", "0.5") + PASSES, "a whole number from 1"),
        (
            VARIES.replace("each", "quantity", 1).replace('"±10%"', '"±10%"\neach = "mass:*"')
            + PASSES,
            "either quantity",
        ),
        (VARIES.replace("±10%", "ten") + PASSES + "percentile = 95\n", "not a finite number"),
    ],
)
def test_percentiles_of_nothing_are_refused(capfd, here, text, message):
    outcome = run(capfd, "check", write(here, text))
    assert (outcome.code, outcome.out) == (2, "")
    assert message in outcome.err


def test_schema_accepts_valid_budgets_alone(capfd, here):
    """The schema for editors lists every metric and every key, and refuses all others."""
    validator = jsonschema.Draft202012Validator(json.loads(good(capfd, "schema", "budgets")))
    inline = (
        '[[case]]\nname = "inline"\nrobot = "stick.urdf"\nposture = { joints_deg = { knee = 3 } }\n'
    )
    every = {
        "case": "l*",
        "at": "shin",
        "max": 2,
        "min": 1,
        "baseline_tolerance": "5%",
        "severity": "warning",
    }
    validator.validate(
        tomllib.loads(ANGLES + inline + PASSES + budget(metric="body.delta_v.x", **every))
    )
    validator.validate(tomllib.loads(VARIES + PASSES + "percentile = 95\n"))
    for text in (
        CASE,
        PASSES,
        CASE + FAILS.replace('"shock"', '"shok"'),
        CASE + PASSES + "mx = 1\n",
        CASE + "robt = 1\n" + PASSES,
    ):
        assert len(list(validator.iter_errors(tomllib.loads(text)))) == 1


def test_the_file_of_the_help_is_valid(here):
    """The example in the help of the command is a file of budgets."""
    lines = [line[2:] for line in EPILOG.splitlines() if line.startswith("  ")]
    table = tomllib.loads("\n".join(lines))
    assert set(table) == {"baseline", "case", "budget"}
    path = Path(write(here, "\n".join(lines)))
    assert [case.name for case in read_budgets(path).cases] == ["land-front"]


def test_small_numbers_may_change_by_a_thousandth_of_the_largest():
    """Where the tolerance is a share: 5 % of 1 is 0.05, and of 1e-4 it is the thousandth, unless
    the tolerance says less.
    """
    least = Budget(metric="joint_impulse", baseline_tolerance="5%")
    assert [least.margin(one, 1.0) for one in (1.0, 1e-4)] == [0.05, 1e-3]
    assert Budget(metric="joint_impulse", baseline_tolerance="0.01%").margin(
        1e-4, 1.0
    ) == pytest.approx(1e-4)
    assert (
        Budget(metric="joint_impulse", baseline_tolerance="5%, 1e-2 N s").margin(1e-4, 1.0) == 1e-2
    )
    assert Budget(metric="joint_impulse", baseline_tolerance="5%, 0").margin(
        1e-4, 1.0
    ) == pytest.approx(5e-6)
    for text in ("1e-3 N s, 5%", "5%,", "5%, 1 kg", "5 kg"):
        with pytest.raises(StudyError, match="share and at least a change"):
            Budget(metric="joint_impulse", baseline_tolerance=text)


STRIKES = (
    "speed = 2.0\nstrike_angle_deg = 20.0",
    "velocity = [0.3, 0.0, -2.0]",
    "drop_height = 0.3\nforward_speed = 0.5",
)
CHANGED = {
    "--drop-height": ("drop_height = 0.2", "0.2"),
    "--speed": ("strike = { speed = 1.5 }", "1.5"),
    "--velocity": ("strike = { velocity = [0.1, 0.0, -1.5] }", "0.1,0,-1.5"),
    "--strike-angle": ("strike_angle_deg = [10]", "10"),
}


@pytest.mark.parametrize("strike", STRIKES)
@pytest.mark.parametrize("option", CHANGED)
def test_a_case_changes_the_strike_of_its_scene_as_an_option_does(capfd, here, strike, option):
    """One way of giving the velocity takes the place of another: a drop of a scene with an angle is
    vertical in both.
    """
    key, value = CHANGED[option]
    (here / "landing.toml").write_text(
        f'robot = "stick.urdf"\ncontact = "foot"\n[strike]\n{strike}\n'
    )
    write(here, f"{CASE}{key}\n", budget(metric="delta_v", at="*", max=9))
    (case,) = read_budgets(here / "budgets.toml").cases
    typed = run(capfd, "analyze", here / "landing.toml", option, value, "--format", "json")
    plane = plane_of(case.landings[0][1])
    np.testing.assert_array_equal(
        case.landings[0][1].strike.vector(plane),
        Strike(**json.loads(typed.out)["scene"]["strike"]).vector(plane),
    )


def test_a_number_of_designs_without_any_that_vary_is_refused():
    with pytest.raises(StudyError, match="nothing of the case varies"):
        Case(name="a", robot="go2", designs=50)


def test_a_case_may_give_a_drop_height(capfd, here):
    """In place of the strike's speed: v = √(2 g h)."""
    write(here, CASE + "drop_height = 0.2\n", budget(metric="delta_v", at="*", max=9))
    (case,) = read_budgets(here / "budgets.toml").cases
    assert case.landings[0][1].strike.drop_height == 0.2
    assert document(capfd)["tables"]["check"]


def test_numbers_that_the_same_joints_decide_have_one_note():
    """Whichever of these decides most, which for equal legs is rounding."""
    budget = Budget(metric="shock", max=0.1)
    outcomes = []
    for number, deciding in enumerate([("hip", "knee"), ("knee", "hip"), ("ankle",)]):
        outcomes.append(
            Outcome(
                case=f"case {number}",
                strike_angle_deg=None,
                at="trunk",
                budget=budget,
                line=None,
                value=0.1,
                baseline=None,
                status="undecided",
                reason="",
                deciding=deciding,
            )
        )
    notes = cause_notes(outcomes)
    assert [note.partition(" (first")[0] for note in notes] == [
        "undecided: 2 numbers: the drives of hip, knee decide",
        "undecided: case 2: shock at trunk: the drives of ankle decide",
    ]
