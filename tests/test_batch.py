"""`shockpc batch`: every row is that of a single analysis, wherever it is computed, and what fails
is a row that says why.
"""

import csv
import io
import json
import re
import signal

import numpy as np
import pytest
from commands import STICK, Outcome, good, interrupted, run, says

from shockpc.evaluation.executor import executor
from shockpc.judgement.drive_range import range_of
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.profile import shock_profile
from shockpc.quantities.selection import select
from shockpc.robot.catalogue import SETS, robots_of_set
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.load import load_robot
from shockpc.studies.batch.study import batch
from shockpc.text.errors import UnknownName

DOGS = ("anymal_b", "go2")


@pytest.fixture(scope="module")
def dogs():
    return batch(DOGS)


def test_every_row_is_a_single_analysis(dogs):
    assert len(dogs.rows) == 18
    for row in dogs.rows:
        profile = shock_profile(row.scene)
        trunk = int(np.argmax(profile.robot.masses))
        allowed = not any(one.kind in ("height", "contact") for one in profile.health.warnings)
        assert row.trunk == profile.bodies[trunk]
        assert row.values == {
            "mass": profile.robot.mass,
            "shock": max(point.shock for point in profile.points if "imu" in point.frame),
            "mitigation": min(contact.mitigation for contact in profile.contacts),
            "ropc": profile.ropc[trunk],
            "shock_max": profile.shock_max[trunk],
            "shock_com": profile.shock_com[trunk],
            "effective_mass_sticking": max(
                contact.effective_mass_sticking for contact in profile.contacts
            ),
            "friction_needed": max(contact.friction_needed for contact in profile.contacts),
            "feasible": float(allowed and len(profile.contacts) == 4),
            "error_bound": profile.health.error_bound,
        }
        assert row.feasible_if_tilted == (allowed and len(profile.contacts) < 4)
        assert row.sensors == {point.frame: point.shock for point in profile.points}


def test_quantities_that_are_asked_for_are_those_of_the_imu_the_trunk_or_the_worst():
    """By magnitude where there are signs; of the radius and the mitigation the smallest; nothing
    where one place has nothing.
    """
    texts = (
        "delta_v.x",
        "delta_qd",
        "joint_impulse@*_thigh*",
        "ropc@*",
        "impulse",
        "energy_lost",
        "peak_g",
    )
    scene = Scene(robot="go2", contact=(Contact(frame="FL_foot"),), pulse="half-sine:5ms")
    (row,) = batch(
        ["go2"], lambda name: (load_robot(name), [scene]), quantities=(*texts, "shock_min@*")
    ).rows
    assert row.values["shock_min@*"] is None
    profile = shock_profile(row.scene)
    (imu,) = profile.landing.points
    thigh = [np.linalg.norm(load.force) for load in profile.loads if "thigh" in load.joint]
    rates = [load.delta_qd for load in profile.loads]
    assert [row.values[text] for text in texts] == pytest.approx(
        [
            (profile.delta_v[0] + np.cross(profile.delta_omega[0], imu.r))[0],
            max(rates, key=abs),
            max(thigh),
            profile.ropc.min(),
            np.linalg.norm(profile.contacts[0].impulse),
            profile.energy_lost,
            np.pi / 2 * profile.points[0].shock * profile.v_in / 5e-3 / 9.80665,
        ],
        rel=1e-13,
    )
    with pytest.raises(UnknownName, match='nearest: "shock"'):
        batch(["go2"], quantities=("shok@imu",))


def test_what_redundant_contacts_leave_undetermined_is_none():
    """Two points of one foot share its impulse in any proportion."""
    row, *_ = batch(
        ["go2"],
        lambda name: (
            load_robot(name),
            [
                Scene(
                    robot=name,
                    contact=tuple(
                        Contact(frame="FL_calf", offset=(0.0, 0.0, -z)) for z in (0.1, 0.2)
                    ),
                )
            ],
        ),
        quantities=("joint_impulse",),
    ).rows
    assert row.values["joint_impulse"] is row.values["friction_needed"] is None
    assert row.values["shock_com"] > 0.0


def test_landings_that_level_ground_does_not_allow_are_named(capfd):
    """HyQ with one knee bent has the other feet below the contact."""
    text = good(capfd, "batch", "hyq", "--contact", "l?_foot", "--set", "lf_kfe_joint=-130")
    assert says(text, "1 landing", "hyq lf_foot")


def test_each_robot_lands_on_its_level_feet_on_edges_and_on_each_foot_in_its_standing_posture(dogs):
    for name in DOGS:
        rows, feet = [row for row in dogs.rows if row.robot == name], each_foot(load_robot(name))
        assert {row.contact for row in rows} >= {"+".join(feet), *feet}
        assert sum(row.contact.count("+") == 1 for row in rows) == 4
        assert {row.scene.posture.reference for row in rows} == {"standing"}


def test_rows_are_ranked_by_the_shock_at_the_imu(dogs):
    shocks = [row.values["shock"] for row in dogs.rows]
    assert shocks == sorted(shocks, reverse=True)
    assert {row.at for row in dogs.rows} == {"imu", "imu_link"}


def test_a_robot_is_its_worst_landing_and_has_no_rank_where_nobody_knows_its_drives(dogs):
    """The range of the number is that of the landing over its drives; A1's drives, which may be
    any, are behind Go2's.
    """
    found = batch(["a1", *DOGS])
    assert [(row.robot, row.drives_known, row.status) for row in found.robots] == [
        ("go2", True, "derived"),
        ("anymal_b", True, "derived"),
        ("a1", False, "unknown"),
    ]
    for row in found.robots:
        own = [other.values["shock"] for other in found.rows if other.robot == row.robot]
        assert row.values["shock"] == max(own)
        assert row.range.smallest <= row.values["shock"] <= row.range.largest
        profile = shock_profile(row.scene)
        (place,) = [place for place in profile.landing.points if place.name == row.at]
        assert row.range == range_of(profile, select("point.shock"), place)
    assert found.robots[-1].range.largest > 0.9


def test_robots_that_do_not_stand_on_bent_legs_are_marked():
    (row,) = batch(["ur5"]).robots
    assert row.marks == ("base fixed",)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rank", "sign"), [("friction_needed", -1.0), ("ropc", 1.0), ("delta_v.y@*", -1.0)]
)
def test_rows_are_ranked_by_any_quantity_the_worst_first(rank, sign):
    """The largest friction first, the smallest radius, the largest magnitude of what has a sign."""
    ranked = batch(["go2"], rank=rank)
    values = [sign * abs(row.values[rank]) for row in ranked.rows]
    assert (values == sorted(values), ranked.rank, rank in ranked.columns) == (True, rank, True)


def test_rows_of_a_scene_have_its_name(capfd, tmp_path):
    (tmp_path / "drop.toml").write_text('robot = "solo12"\n[[contact]]\nframe = "FL_FOOT"\n')
    text = good(capfd, "batch", "bolt", tmp_path / "drop.toml")
    assert re.search(r"^2 +solo12 \(drop.toml\) +trunk +FL ", text, re.MULTILINE)
    rows = list(
        csv.DictReader(
            io.StringIO(good(capfd, "batch", "bolt", tmp_path / "drop.toml", "--format", "csv"))
        )
    )
    assert {(row["scene"], row["robot"]) for row in rows} == {
        (str(tmp_path / "drop.toml"), "solo12"),
        ("", "bolt"),
    }


def test_a_quantity_without_a_value_says_why(capfd):
    text = good(capfd, "batch", "solo12", "--contact", "FL_FOOT", "--quantity", "peak_force")
    assert "peak_force has no value" in text


def test_rows_do_not_depend_on_where_they_are_computed(dogs):
    with executor(2) as pool:
        found = batch(DOGS, executor=pool)
    assert [(row.robot, row.contact, row.values, row.sensors) for row in found.rows] == [
        (row.robot, row.contact, row.values, row.sensors) for row in dogs.rows
    ]


def test_a_robot_that_fails_is_a_row_and_the_others_are_computed():
    """A name that nobody has, a robot whose fingers have no mass, and one that can be computed."""
    seen = []
    found = batch(["nosuch", "romeo", "bolt"], progress=lambda robots: seen.append)
    assert seen == ["nosuch", "romeo", "bolt"]
    assert {row.robot for row in found.rows} == {"bolt"}
    assert [(failure.robot, failure.contact) for failure in found.failures] == [
        ("nosuch", ""),
        ("romeo", "l_sole+r_sole"),
        ("romeo", "l_sole"),
        ("romeo", "r_sole"),
    ]
    assert "no mass or inertia" in found.failures[1].reason


def test_an_unexpected_error_is_the_message_of_its_row(monkeypatch):
    """A fault of the program in one landing costs that landing alone, and the message says where it
    is.
    """
    computed = shock_profile

    def fail_once(scene, robot, trace=None):
        if scene.contact == (Contact(frame="LF_FOOT"),):
            raise ZeroDivisionError("odd")
        return computed(scene, robot, trace)

    monkeypatch.setattr("shockpc.evaluation.profiles.profile_of_scene", fail_once)
    found = batch(["anymal_b"])
    assert len(found.rows) == 8
    (failure,) = found.failures
    assert (failure.robot, failure.contact) == ("anymal_b", "LF_FOOT")
    assert re.fullmatch(
        "an error in shockpc itself, .*ZeroDivisionError in test_batch.py, line [0-9]+: odd",
        failure.reason,
    )


@pytest.mark.parametrize(("name", "legs"), [("quadrupeds", 4), ("bipeds", 2), ("humanoids", 2)])
def test_robots_of_a_set_have_so_many_feet(name, legs):
    assert {len(each_foot(load_robot(robot))) for robot in SETS[name]} == {legs}


def test_all_robots_are_a_set():
    assert {robot for names in SETS.values() for robot in names} < set(robots_of_set("all"))
    with pytest.raises(UnknownName, match="quadrupeds"):
        robots_of_set("quadruped")


def test_a_foot_is_one_link_and_the_end_of_its_leg():
    """Of several links of a foot the sole; a body that carries another foot is none."""
    assert each_foot(load_robot("icub")) == ("l_sole", "r_sole")
    assert each_foot(load_robot("human")) == ("left_foot", "right_foot")
    assert each_foot(load_robot("g1")) == ("left_ankle_roll_link", "right_ankle_roll_link")


def test_command_prints_a_line_for_each_robot(capfd):
    """Ranked where the drives are known; with --landings a line for each landing."""
    text = good(capfd, "batch", "a1", *DOGS)
    lines = text.splitlines()
    assert lines[0] == "3 robots, each in its worst landing"
    assert [line.split()[:2] for line in lines[4:7]] == [
        ["1", "go2"],
        ["2", "anymal_b"],
        ["–", "a1"],
    ]
    assert max(map(len, lines[:7])) <= 100
    assert says(text, "–: unknown drives")
    lines = good(capfd, "batch", *DOGS, "--landings").splitlines()
    assert lines[0] == "18 landings, ranked by shock"
    assert [line.split()[0] for line in lines[4:22]].count("go2") == 9


def test_a_path_is_shown_once_and_drives_that_nobody_knows_have_no_rank(capfd, tmp_path):
    """Of one's robot file without drives, beside a robot of the catalogue."""
    (tmp_path / "stick.urdf").write_text(STICK)
    text = good(capfd, "batch", tmp_path / "stick.urdf", "bolt", "--landings")
    assert text.count(str(tmp_path)) == 1
    text = good(capfd, "batch", tmp_path / "stick.urdf", "bolt")
    assert next(line for line in text.splitlines() if "stick.urdf" in line).startswith("–")


def test_how_many_were_not_computed_is_said_and_the_exit_code_is_3_if_all_or_strictly_any(capfd):
    outcome = run(capfd, "batch", "bolt", "nosuch")
    assert outcome.code == 0
    assert [
        run(capfd, "batch", *words).code for words in (("bolt", "nosuch", "--strict"), ("nosuch",))
    ] == [3, 3]
    assert 'not computed: nosuch: no robot "nosuch"' in outcome.out
    assert "not computed: 3 landings: bodies" in (text := run(capfd, "batch", "romeo").out)
    assert text.count("no mass or inertia") == 1
    assert "(first: romeo l_sole+r_sole)" in text
    assert "bolt" in outcome.out
    assert (outcome.err.count("\n"), "1 of 4 landings" in outcome.err) == (1, True)


def test_documents_hold_the_same_rows(capfd, tmp_path, dogs):
    """CSV and JSON in full precision, Markdown for a report."""
    words = ("batch", "go2", "--contact", "F?_foot")
    expected = [row for row in dogs.rows if row.contact in ("FL_foot", "FR_foot")]
    good(capfd, *words, "--out", tmp_path)
    document = json.loads((tmp_path / "batch.json").read_text())
    assert document["schema"] == "shockpc.batch/2"
    assert [row["ropc"] for row in document["tables"]["batch"]] == [
        row.values["ropc"] for row in expected
    ]
    sensors = [
        (row["robot"], row["contact"], row["at"], row["shock"])
        for row in document["tables"]["sensors"]
    ]
    assert sensors == [
        (row.robot, row.contact, *pair) for row in expected for pair in row.sensors.items()
    ]
    table = list(csv.DictReader(io.StringIO((tmp_path / "batch.csv").read_text())))
    assert [float(row["shock_max [-]"]) for row in table] == [
        row.values["shock_max"] for row in expected
    ]
    assert json.loads(good(capfd, *words, "--format", "json")) == document
    assert good(capfd, *words, "--format", "csv") == (tmp_path / "batch.csv").read_text()
    assert (tmp_path / "report.md").read_text() == good(capfd, *words, "--format", "markdown")


def test_failures_are_in_every_document(capfd):
    for format_ in ("json", "csv", "markdown"):
        outcome = run(capfd, "batch", "bolt", "nosuch", "--format", format_)
        assert (outcome.code, outcome.err.count("could not be computed")) == (0, 1)
        assert "To list them: shockpc robots" in outcome.out


def test_options_hold_for_every_robot(capfd):
    """The same strike, joint model and contacts for all; the trunk then feels more."""
    words = (
        "--strike-angle",
        "20",
        "--armature",
        "*=0.05",
        "--contact",
        "*[LR]F_FOOT",
        "--format",
        "json",
    )
    words += ("--quantity", "shock_free@base", "--quantity", "shock_locked@base")
    document = json.loads(good(capfd, "batch", "anymal_b", *words))
    rows = document["tables"]["batch"]
    assert sorted(row["contact"] for row in rows) == ["LF_FOOT", "RF_FOOT"]
    assert {row["joints"] for row in rows} == {"geared"}
    assert all(row["shock_free@base"] < row["shock_com"] < row["shock_locked@base"] for row in rows)
    assert {row["scene"]["strike"]["strike_angle_deg"] for row in document["landings"]} == {20.0}


def test_a_scene_lands_as_it_says(capfd, tmp_path):
    (tmp_path / "landing.toml").write_text(
        'robot = "go2"\nplane = "yz"\n[[contact]]\nframe = "RL_foot"\n'
    )
    (row,) = json.loads(good(capfd, "batch", tmp_path / "landing.toml", "--format", "json"))[
        "landings"
    ]
    assert (row["robot"], row["contact"], row["scene"]["plane"]) == ("go2", "RL_foot", "yz")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "no robot is named"),
        (("--robots", "hexapods"), 'no set of robots "hexapods"'),
        (("bolt", "--figures"), "--out"),
        (("bolt", "--jobs", "0"), "must be ≥ 1 and ≤ 512, got 0"),
        (("bolt", "--robots", "*_knee=3"), "no set of robots"),
    ],
)
def test_bad_arguments_are_refused(capfd, words, told):
    outcome = run(capfd, "batch", *words)
    assert (outcome.code, outcome.out) == (2, "")
    assert told in outcome.err


@pytest.mark.parametrize("jobs", [1, 2])
def test_interrupt_ends_all_processes_and_leaves_no_file(tmp_path, jobs):
    words = ("batch", "bolt", "go2", "--jobs", str(jobs), "--out", str(tmp_path / "out"))
    expected = Outcome(130, "", "shockpc: interrupted; no incomplete file was left\n")
    assert interrupted(tmp_path, signal.SIGINT, *words) == expected
    assert not (tmp_path / "out").exists()


def test_contact_sheet_shows_the_worst_landing_of_each_robot(capfd, tmp_path):
    good(capfd, "batch", "solo8", "bolt", "a1", "--figures", "--jobs", "2", "--out", tmp_path)
    drawn = (tmp_path / "sheet.svg").read_text()
    rows = json.loads((tmp_path / "batch.json").read_text())["tables"]["robots"]
    assert (tmp_path / "sheet.png").stat().st_size > 10_000
    assert re.findall(r">on ([\w +]+)<", drawn) == [row["landing"] for row in rows]
    for row in rows:
        assert f">{row['rank'] or '–'}  {row['robot']}<" in drawn
    assert "sheet.svg" in (tmp_path / "report.md").read_text()


def test_with_friction_the_columns_say_which_law_of_contact_they_are_of(capfd):
    """Numbers of contacts that stick never stand beside a friction without a word; those with
    friction are not proven.
    """
    feet = ("hyq", "--contact", "l?_foot")
    sliding = (*feet, "--friction", "0.2", "--strike-angle", "40")
    assert "warning: these numbers are for contacts that stick" in good(capfd, "batch", *sliding)
    text = good(capfd, "batch", *sliding, "--quantity", "shock_com_friction")
    assert "in double precision: shock_com_friction" in text
    assert "contacts that stick" not in good(capfd, "batch", *feet)
