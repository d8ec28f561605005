"""`shockpc identify`: simulated landings with known values, what data do not tell, and the measured
tosses of two blocks.
"""

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import good, run, says
from identify_draws import BLOCKS, blocks, csv_text, leg, leg_scene, simulated

from shockpc import (
    Joints,
    Rotor,
    Scene,
    StudyError,
    identify,
    read_scene,
    resolve,
    shock_profile,
    sweep,
)
from shockpc.core.coulomb import solve_each, solve_friction
from shockpc.evaluation.column_values import proven_columns
from shockpc.evaluation.variations.vary import variation
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.method.dynamics import dynamics
from shockpc.wings.recordings.identify.predictor import Predictor
from shockpc.wings.recordings.identify.report import identify_report
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.prediction import (
    base_in_world,
    energy_norms,
    mobilities,
    predicting,
)
from shockpc.wings.recordings.tables.reader import rows_of
from shockpc.wings.recordings.tables.table_files import read_table

TOSSED = Scene(robot=str(BLOCKS), contact="elbow_1_corner_1")
GROUND = {"friction": "0:1.5", "restitution": "0:1"}
DRIVES = {"armature:hip": "0.0003:0.3:log", "armature:knee": "0.0003:0.3:log"}


def rng(seed=0):
    return np.random.default_rng(seed)


def written(folder, table):
    """The table as a CSV file."""
    (folder / "table.csv").write_text(csv_text(table))
    return "table.csv"


# Predictions


def test_many_landings_with_friction_are_solved_as_one():
    """Contacts that slide, stick, are frictionless, cannot move along a tangent, and such as gain
    energy.
    """
    draw, n = rng(1), 400
    B = draw.normal(size=(n, 3, 6))
    A, velocity = B @ B.swapaxes(1, 2), draw.normal(size=(n, 3))
    A[:50, 1], A[:50, :, 1], velocity[:50, 1], velocity[50:60, :2] = 0.0, 0.0, 0.0, 0.0
    velocity[:, 2] = -np.abs(velocity[:, 2])
    mu, e = draw.uniform(0.0, 1.5, n), draw.uniform(0.0, 1.0, n) * (draw.random(n) < 0.5)
    mu[60:80], mu[80:100] = 0.0, 1e9
    found, refused = solve_each(A, velocity, mu, e), 0
    for i in range(n):
        solutions = solve_friction(A[i], velocity[i : i + 1], mu[i : i + 1], e[i : i + 1])
        best = min(
            solutions,
            key=lambda solution: (solution.gains_energy, set(solution.state) != {"sticks"}),
            default=None,
        )
        refused += (none := best is None or best.gains_energy)
        np.testing.assert_allclose(
            found[i], np.full(3, np.nan) if none else best.impulse[0], rtol=1e-7, atol=1e-9
        )
    assert 0 < refused < n / 2


@pytest.mark.parametrize("kind", ["friction", "sticks", "scaled"])
def test_predictions_are_those_of_the_landings(kind):
    """The jumps that the engine computes row by row, with a proof or friction_of each, for the
    scene with these values.
    """
    table = blocks(rng(), 8)
    robot, subjects = (
        robot_of(TOSSED),
        {"friction": ("friction", "restitution"), "sticks": ("restitution",), "scaled": ()}[kind],
    )
    rows = rows_of(table, landing_of(TOSSED, robot))
    unknowns = tuple(variation(robot, name, "0:1") for name in subjects)
    predictor = Predictor(rows, robot, unknowns, rows.measured)
    study = predictor.study((0.3, 0.25)[: len(unknowns)])
    keys = predicting(study, friction=kind == "friction")
    chunk = study.chunk(0, study.data(0))
    list(chunk.groups)
    landings = [proven_columns(chunk.profile(i), tuple(keys.values())) for i in range(study.rows)]
    expected = base_in_world(
        study,
        keys,
        {name: np.array([landing[name] for landing in landings]) for name in landings[0]},
    )
    found = predictor((0.3, 0.25)[: len(unknowns)])
    np.testing.assert_allclose(
        found.jumps, np.stack([expected[m.key] for m in rows.measured], axis=1), atol=1e-10
    )


@pytest.mark.slow
def test_energies_count_what_the_base_cannot_do(here):
    """Of a leg on a rail: ΔᵀHΔ of its three joints, and of two of them the smallest for whatever
    the third does.
    """
    table = leg(rng(), 4, here, noise=0.0)
    table |= {"before_rail": -np.ones(4), "after_rail": np.zeros(4)}
    scene, robot = leg_scene(here), robot_of(leg_scene(here))
    study = RecordedLandings(robot, rows_of(table, landing_of(scene, robot)))
    v = np.array([robot.joint(name).v.start for name in ("rail", "hip", "knee")])
    H, jumps = dynamics(robot, study.table.Q).H[:, v][:, :, v], rng(1).normal(size=(4, 3))
    whole = np.sqrt(np.einsum("ni,nij,nj->n", jumps, H, jumps))
    np.testing.assert_allclose(energy_norms(mobilities(study), v, jumps), whole, rtol=1e-12)
    jumps[:, 0] = -np.einsum("ni,ni->n", H[:, 0, 1:], jumps[:, 1:]) / H[:, 0, 0]
    least = np.sqrt(np.einsum("ni,nij,nj->n", jumps, H, jumps))
    jumps[:, 0] = np.nan
    np.testing.assert_allclose(energy_norms(mobilities(study), v, jumps), least, rtol=1e-12)
    known = dict.fromkeys(DRIVES, 0.01)
    table = simulated(
        scene,
        {k: x for k, x in table.items() if k[:5] != "after"},
        known,
        dict.fromkeys(("rail", "hip", "knee"), 0.0),
        rng(),
    )
    found = identify(table, scene, DRIVES)
    assert found.values == pytest.approx(known, rel=1e-3)
    assert [column.group for column in found.predictor.measured] == [
        "sliding rates",
        "joint rates",
        "joint rates",
    ]


def test_sweeps_vary_restitution_and_rotors(here):
    leg(rng(), 3, here)
    scene = replace(
        leg_scene(here), joints=Joints(rotor={"knee": Rotor(inertia=1e-5, gear_ratio=9.0)})
    )
    table = sweep(
        scene, {"restitution": [0.0, 0.5], "rotor:knee": [1e-5, 1e-4]}, quantities=["delta_qd@knee"]
    ).table
    contact = replace(scene.contact[0], restitution=0.5)
    joints = Joints(rotor={"knee": Rotor(inertia=1e-4, gear_ratio=9.0)})
    expected = shock_profile(replace(scene, contact=contact, joints=joints)).delta_qd[
        robot_of(scene).joint("knee").v.start
    ]
    assert table.columns["delta_qd@knee"][-1] == pytest.approx(expected, rel=1e-9)


# Values


def test_values_without_noise_are_exact():
    """The motion of both blocks tells friction and restitution; landings left out are predicted."""
    found = identify(blocks(rng(), 20, noise=0.0), TOSSED, GROUND)
    assert found.values == pytest.approx({"friction": 0.3, "restitution": 0.25}, abs=1e-4)
    assert found.errors["left out"] < 1e-3 < 0.1 < found.errors["before"]
    assert found.scene.friction == found.values["friction"]
    assert not found.statements


def test_intervals_hold_noisy_values():
    """These draws are as most are; tests/identify_draws.py counts how many."""
    found = identify(blocks(rng(3), 40), TOSSED, GROUND)
    for one, true in zip(found.unknowns, (0.3, 0.25), strict=True):
        assert one.state == "identified"
        assert one.low < true < one.high
        assert one.high - one.low < 0.1
    assert (
        found.errors["free impulse"]
        < found.errors["after"]
        < found.errors["left out"] * 1.1
        < found.errors["before"]
    )


@pytest.mark.slow
def test_a_drive_is_found_from_a_start_that_is_ten_times_off(here, capfd):
    """And drives.toml and scene.toml hold it, for every command."""
    table = leg(rng(), 12, here, noise=0.0)
    start = replace(leg_scene(here), joints=Joints(armature={"hip": 0.04, "knee": 0.0009}))
    found = identify(table, start, DRIVES)
    assert found.errors["after"] < 1e-3 < 0.05 < found.errors["before"]
    assert found.values == pytest.approx({"armature:hip": 0.004, "armature:knee": 0.009}, rel=1e-3)
    words = [word for name, values in DRIVES.items() for word in ("--unknown", f"{name}={values}")]
    out = good(
        capfd,
        "identify",
        written(here, table),
        "leg.urdf",
        "--contact",
        "foot",
        "--directions",
        "xz",
        *words,
        "--out",
        "out",
    )
    assert re.search(r"armature:knee +kg m² +0.0090 ", out)
    drives = tomllib.loads((here / "out" / "drives.toml").read_text())["drive"]
    assert [drive["joint"] for drive in drives] == [["hip"], ["knee"]]
    for drive in drives:  # no nearer than drives of one type agree
        assert drive["range"] == pytest.approx(
            [0.8 * drive["armature"], 1.2 * drive["armature"]], rel=1e-3
        )
    assert all(
        drive["status"] == "identified" and drive["source"].startswith("table.csv, 12 landings, ")
        for drive in drives
    )
    scene = read_scene(here / "out" / "scene.toml")
    by_hand = replace(leg_scene(here), joints=Joints(drives=str(here / "out" / "drives.toml")))
    for landing in (scene, by_hand):
        armature = resolve(landing, robot_of(landing)).joint_model.armature
        np.testing.assert_allclose(armature[-3:], [0.0, 0.004, 0.009], rtol=1e-3)
    good(capfd, "analyze", "out/scene.toml")
    document = json.loads((here / "out" / "identify.json").read_text())
    assert document["tables"]["identify"][1]["value"] == pytest.approx(0.009, rel=1e-3)
    assert {"identify.svg", "landings.csv", "report.md"} <= {
        file.name for file in (here / "out").iterdir()
    }


def test_a_rotor_behind_a_gear(here):
    """Its reflected inertia is the armature."""
    table = leg(rng(), 12, here, true={"armature:knee": 81.0 * 1e-4}, noise=0.0)
    scene = replace(
        leg_scene(here), joints=Joints(rotor={"knee": Rotor(inertia=1e-6, gear_ratio=9.0)})
    )
    assert identify(table, scene, {"rotor:knee": "1e-6:1e-2:log"}).values[
        "rotor:knee"
    ] == pytest.approx(1e-4, rel=1e-3)


def test_velocities_before_that_are_too_small():
    """A factor on what was measured before; the jumps are to the velocities after it."""
    table = blocks(rng(), 20, noise=0.0)
    table |= {name: 0.9 * values for name, values in table.items() if name.startswith("before_")}
    found = identify(table, TOSSED, {**GROUND, "scale:before": "0.5:2"})
    assert found.values == pytest.approx(
        {"friction": 0.3, "restitution": 0.25, "scale:before": 1.0 / 0.9}, abs=1e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "more", [{}, {"gravity": False}, {"torque": {"knee": 4.0}}, {"motors": "none"}]
)
def test_a_contact_stiffness_from_velocities_at_a_time(here, more):
    """While the contact still presses; how stiff it is cannot be told from the end alone.

    What else counts on it may be given.
    """
    table = leg(rng(), 5, here, noise=0.0)
    scene = leg_scene(here)
    joints = {key: more[key] for key in more if key != "gravity"}
    scene = replace(
        scene,
        contact_stiffness=5e4,
        gravity=more.get("gravity", True),
        joints=replace(scene.joints, **joints),
    )
    table |= {
        name.replace("after_", "after1ms_"): table.pop(name) for name in ("after_hip", "after_knee")
    }
    rows = rows_of(table, landing_of(scene, robot_of(scene)))
    jumps = Predictor(rows, robot_of(scene), (), rows.measured)(None).jumps
    table |= {
        f"after1ms_{column.name}": table[f"before_{column.name}"] + jump
        for column, jump in zip(rows.measured, jumps.T, strict=True)
    }
    found = identify(
        table,
        replace(scene, contact_stiffness=2e4) if more else leg_scene(here),
        {"contact-stiffness": "1e4:1e6:log"},
    )
    assert found.values["contact-stiffness"] == pytest.approx(5e4, rel=1e-3)
    with pytest.raises(StudyError, match="does not say when it was measured"):
        identify(leg(rng(), 5, here), leg_scene(here), {"contact-stiffness": (1e4, 1e6)})


def test_one_wild_landing_changes_little():
    table = blocks(rng(3), 25)
    found = identify(table, TOSSED, GROUND)
    table["after_wx"] = table["after_wx"].copy()
    table["after_wx"][5] += 500.0
    wild = identify(table, TOSSED, GROUND)
    for one, other in zip(wild.unknowns, found.unknowns, strict=True):
        assert one.value == pytest.approx(other.value, abs=0.5 * (other.high - other.low))


def test_rows_and_cells_without_numbers_are_left_out():
    """A landing that cannot be read does not count, nor what was not measured of another."""
    table = blocks(rng(), 20, noise=0.0)
    table["after_vz"], table["before_vz"] = table["after_vz"].copy(), table["before_vz"].copy()
    table["after_vz"][3], table["before_vz"][4] = np.nan, np.nan
    found = identify(table, TOSSED, GROUND)
    assert found.values == pytest.approx({"friction": 0.3, "restitution": 0.25}, abs=1e-4)
    assert np.flatnonzero(~found.used).tolist() == [4]


# What the data do not tell


def test_an_unknown_without_influence():
    """A spring gives no impulse in an instant."""
    found = identify(
        blocks(rng(), 20),
        TOSSED,
        {"friction": "0:1.5", "joint-stiffness:hinge_1_to_2": "1:1000:log"},
    )
    assert [one.state for one in found.unknowns] == ["identified", "no influence"]
    assert says(found.statements[0], "joint-stiffness:hinge_1_to_2", "no influence")


@pytest.mark.slow
def test_unknowns_that_do_the_same(here):
    """An inertia of the rail and the mass that slides on it."""
    table = leg(rng(), 20, here, true={"armature:rail": 0.5}, noise=0.0)
    found = identify(table, leg_scene(here), {"armature:rail": "0.1:2", "mass:hub": "1:3"})
    assert [one.state for one in found.unknowns] == ["not identifiable"] * 2
    assert says(found.statements[0], "armature:rail", "mass:hub")
    assert found.errors["after"] < 1e-3


def test_a_value_at_its_bound():
    found = identify(blocks(rng(), 30), TOSSED, {"friction": "0.6:1.5", "restitution": "0:1"})
    friction, restitution = found.unknowns
    assert (friction.state, friction.value, restitution.state) == (
        "at its bound",
        0.6,
        "identified",
    )
    assert np.isnan([friction.low, friction.high]).all()
    assert any(text.startswith("friction is at the bound 0.6") for text in found.statements)


def test_nothing_is_identified_where_the_error_does_not_fall(here):
    """Of 15 landings the scene predicts eight exactly, and the fit moves away from them for the
    sake of seven others.
    """
    scene = replace(leg_scene(here), joints=Joints(armature={"hip": 0.004, "knee": 0.009}))
    table, others = (
        leg(rng(), 15, here, true={"armature:hip": 0.004, "armature:knee": knee}, noise=0.0)
        for knee in (0.009, 0.016)
    )
    for name in table:
        if name.startswith("after"):
            table[name][:7] = others[name][:7]
    found = identify(table, scene, {"armature:knee": "0.0003:0.3:log"})
    (knee,) = found.unknowns
    assert found.errors["after"] > found.errors["before"]
    assert (knee.state, np.isnan(knee.low)) == ("error does not fall", True)
    assert found.statements[0].startswith("nothing is identified: the error is ")
    drives = identify_report(Path("t.csv"), found).more(here)["drives.toml"]
    assert [drive.get("status") for drive in tomllib.loads(drives)["drive"]] == [None, None]
    same = identify(leg(rng(), 15, here, noise=0.0), scene, {"armature:knee": "0.0003:0.3:log"})
    assert same.unknowns[0].state == "identified"


def test_control_that_holds_a_joint_acts_as_inertia(here):
    """M Δq̇ + Δ(impulse of the damping) = 0: a damping k_d over a window t is an armature k_d t, in
    the data and in the answer.
    """
    damping, window = 2.0, 6e-3
    held = leg(
        rng(),
        12,
        here,
        true={"armature:hip": 0.004, "armature:knee": 0.009 + damping * window},
        noise=0.0,
    )
    held = {re.sub("^after_", "after6ms_", name): values for name, values in held.items()}
    found = identify(
        held, leg_scene(here), {"armature:hip": "0.0003:0.3:log", "armature:knee": "0.0003:0.3:log"}
    )
    assert found.values["armature:knee"] - damping * window == pytest.approx(0.009, rel=1e-3)
    (text,) = [text for text in found.statements if "damping k_d" in text]
    assert says(
        text, "move very little", "0.006 s × k_d in 6 ms", "0.012 kg m² at k_d = 2 N m s/rad"
    )
    assert not any(
        "damping k_d" in text for text in identify(blocks(rng(), 20), TOSSED, GROUND).statements
    )


def test_landings_in_one_posture_identify_nothing(here):
    """However many there are."""
    found = identify(
        leg(rng(), 30, here, alike=0.005), leg_scene(here), {"armature:knee": "0.0003:0.3:log"}
    )
    assert found.unknowns[0].state == "not identifiable"
    assert np.isnan(found.unknowns[0].low)
    assert "not identifiable: the 30 landings are all alike" in found.statements[0]


@pytest.mark.slow
def test_noise_weighs_what_was_measured_and_tells_a_wrong_model():
    """Velocities that no pattern fits are not used; with the true noise nothing is left, with less
    the model is wrong.
    """
    table = blocks(rng(1), 40)
    noise = {"v?": 0.1, "w?": 1.0}
    found = identify(table, TOSSED, GROUND, noise=noise)
    assert [column.name for column in found.predictor.measured] == [
        "vx",
        "vy",
        "vz",
        "wx",
        "wy",
        "wz",
    ]
    assert not any("beyond the noise" in text for text in found.statements)
    wrong = identify(
        table, TOSSED, GROUND, noise={name: 0.5 * sigma for name, sigma in noise.items()}
    )
    ratios = [
        float(ratio)
        for text in wrong.statements
        for ratio in re.findall(r"the remaining error is (\S+) times the given noise", text)
    ]
    assert ratios == [pytest.approx(2.0, abs=0.3)]


def test_a_model_that_is_wrong_beyond_the_scatter(here):
    """Twice the jump of the knee is none of any drive at the hip."""
    table = leg(rng(), 30, here, true={"armature:hip": 0.004}, noise=0.05)
    table["after_knee"] = table["before_knee"] + 2.0 * (table["after_knee"] - table["before_knee"])
    found = identify(table, leg_scene(here), {"armature:hip": "0.0003:0.3:log"})
    assert any(
        "still wrong by more than the scatter" in text and "knee" in text
        for text in found.statements
    )


def test_what_was_not_measured_is_not_wrong(here):
    """Cells and columns without a number are no jump of zero."""
    table = leg(rng(), 30, here, true={"armature:hip": 0.004}, noise=0.05)
    table["after_knee"][::2] = np.nan
    table["after_hip"][:] = np.nan
    found = identify(table, leg_scene(here), {"armature:knee": "0.0003:0.3:log"})
    assert "hip" not in [column.name for column in found.predictor.measured]
    assert not any("still wrong by more than the scatter" in text for text in found.statements)


# Measured


@pytest.mark.slow
def test_the_measured_tosses_of_two_blocks():
    """Those with one clear contact: an independent solution found friction 0.19, restitution 0.29
    and an error of 0.30.
    """
    table = read_table(BLOCKS.parent / "elbow_landings.csv")
    table = {name: values[table["gap"] > 0.006] for name, values in table.items() if name != "gap"}
    found = identify(table, TOSSED, GROUND)
    friction, restitution = found.unknowns
    assert friction.value == pytest.approx(0.19, abs=0.03)
    assert restitution.value == pytest.approx(0.29, abs=0.05)
    assert friction.low < 0.19 < friction.high
    assert found.errors["left out"] <= 0.32 < found.errors["before"]
    assert found.errors["free impulse"] < 0.2


# Refusals


@pytest.mark.parametrize(
    ("unknown", "changes", "text"),
    [
        ({"friction": "0.3"}, {}, "is no range; give LOW:HIGH"),
        ({"friction": "0.3±0.1"}, {}, "is no range"),
        ({"strike-angle": "0:30"}, {}, "is of how the robot lands"),
        ({"friction": "-1:1"}, {}, "friction must be ≥ 0"),
        ({}, {}, "give each unknown once"),
        (GROUND, {"after": 6.0}, "nothing was measured after 6 ms"),
        (GROUND, {"noise": {"hinge": 1.0}}, "fits nothing that was measured"),
    ],
)
def test_refusals(unknown, changes, text):
    with pytest.raises(Exception, match=text) as refusal:
        identify(blocks(rng(), 5), TOSSED, unknown, **changes)
    assert isinstance(refusal.value, StudyError.__base__)


def test_a_table_that_says_too_little():
    table = blocks(rng(), 6)
    with pytest.raises(StudyError, match="do not identify 2 unknowns"):
        identify({name: values[:2] for name, values in table.items()}, TOSSED, GROUND)
    with pytest.raises(StudyError, match="measured no velocity after the impact"):
        identify(
            {name: values for name, values in table.items() if not name.startswith("after_")},
            TOSSED,
            GROUND,
        )


def test_a_table_in_which_nothing_was_moved():
    """Velocities measured after the impact that are those before it say nothing of a landing, and
    no error is relative to them.
    """
    table = blocks(rng(), 6)
    still = table | {
        name: table[name.replace("after", "before")] for name in table if name.startswith("after")
    }
    with pytest.raises(
        StudyError, match="in 6 of the table all measured velocities are those before"
    ):
        identify(still, TOSSED, GROUND)


def test_the_command_says_what_it_lacks(capfd, here):
    name = written(here, blocks(rng(), 6))
    words = ("identify", name, str(BLOCKS), "--contact", "elbow_1_corner_1")
    assert "friction has no range" in run(capfd, *words, "--unknown", "friction").err
    assert run(capfd, *words).code == 2
