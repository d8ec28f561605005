"""Logs: touchdowns of simulated and of prescribed motions, whose contacts are known; what is
written of them; refusals.
"""

import json
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from commands import good, run, says
from log_file import written
from robot_texts import LIMITS, SOLID, STEPPER, joint, link, urdf
from rosbags.rosbag1 import Writer as WriterOfRos1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as WriterOfRos2
from rosbags.typesys import Stores, get_typestore

import shockpc
from shockpc import Contact, Scene, load_robot
from shockpc.bench.found_touchdowns import FEET, found_touchdowns, quadruped_mjcf, simulated_trot
from shockpc.text.errors import StudyError, UnknownName
from shockpc.wings.recordings.logs.bags import read_bag
from shockpc.wings.recordings.logs.detection import line_slopes, noise
from shockpc.wings.recordings.logs.logs import read_log

RAIL = urdf(
    '<link name="world"/>',
    link("body", "1", SOLID),
    link("shank", "0.2", SOLID + '<origin xyz="0 0 -0.1"/>'),
    '<link name="foot"/>',
    joint("rail", "world", "body", "prismatic", "0 0 1", LIMITS),
    joint("knee", "body", "shank", more='<origin xyz="0 0 -0.2"/>' + LIMITS),
    joint("ankle", "shank", "foot", "fixed", more='<origin xyz="0 0 -0.2"/>'),
    name="rail",
)
"""A leg on a vertical rail."""


@pytest.fixture(scope="module")
def trotting():
    return simulated_trot()


@pytest.fixture(scope="module")
def dog_scene(tmp_path_factory):
    file = tmp_path_factory.mktemp("dog") / "dog.xml"
    file.write_text(quadruped_mjcf())
    return Scene(robot=str(file), contact=tuple(Contact(frame=f"{foot}_foot") for foot in FEET))


def scene_of(folder, text, *feet, name="robot.urdf"):
    (folder / name).write_text(text)
    return Scene(robot=str(folder / name), contact=tuple(Contact(frame=foot) for foot in feet))


def stepping(rate=1000.0, stops=(0.2, 0.203), speed=1.0, length=0.5, **more):
    """A log of the stepper whose feet fall at a speed until they are stopped, at different times;
    its body goes on falling.
    """
    time = np.arange(0.0, length, 1.0 / rate)
    z = 0.6 - 0.1 * time
    columns = {"time": time, "z": z, "qw": np.ones(len(time))} | dict.fromkeys(
        ("x", "y", "qx", "qy", "qz"), np.zeros(len(time))
    )
    for side, stop in zip(("left", "right"), stops, strict=True):
        columns[f"{side}_leg"] = speed * np.maximum(stop - time, 0.0) + 0.5 - z
    return columns | more


def stepped(here, columns, **options):
    """The touchdowns of a log of the stepper."""
    return shockpc.touchdowns(
        columns, scene_of(here, STEPPER, "left_foot", "right_foot"), **options
    )


def test_slopes_are_those_of_least_squares():
    """On either side of each sample; of unequal steps on a line too.

    The noise of a parabola is that added to it.
    """
    rng = np.random.default_rng(0)
    t, x = np.arange(30) * 1e-3, rng.standard_normal(30)
    behind, ahead = line_slopes(t, x, 5)
    for k in range(5, 25):
        np.testing.assert_allclose(behind[k], np.polyfit(t[k - 5 : k + 1], x[k - 5 : k + 1], 1)[0])
        np.testing.assert_allclose(ahead[k], np.polyfit(t[k : k + 6], x[k : k + 6], 1)[0])
    np.testing.assert_allclose(behind[3], np.polyfit(t[:4], x[:4], 1)[0])
    assert np.isnan(behind[:2]).all()
    assert np.isnan(ahead[-2:]).all()
    uneven = np.cumsum(rng.uniform(1.0, 2.0, 30))
    np.testing.assert_allclose(line_slopes(uneven, 3.0 * uneven + 1.0, 4)[0][2:], 3.0)
    time = np.arange(4000) * 1e-3
    assert noise(3.0 * time**2 + 0.01 * rng.standard_normal(4000)) == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize("rate", [2000.0, 1000.0, 500.0])
def test_a_leg_on_a_rail_falls_and_stops(here, rate):
    """The last sample of the fall is found exactly; the rail's rate before is that of the middle of
    the window, and 0 after.
    """
    time = np.arange(0.0, 0.6, 1.0 / rate)
    fall = np.maximum(0.3 - 4.905 * time**2, 0.0)
    knee = 0.5 + 0.2 * np.sin(20.0 * time)
    columns = {"time": time, "rail": fall + 0.2 + 0.2 * np.cos(knee), "knee": knee}
    found = shockpc.touchdowns(columns, scene_of(here, RAIL, "foot"))
    (landing,) = found.landings
    assert landing.first == np.flatnonzero(fall > 0.0)[-1]
    window = found.window["joints"]
    middle = time[landing.first] - 0.5 * window
    foot = -9.81 * middle - 0.2 * np.sin(0.5 + 0.2 * np.sin(20.0 * middle)) * 4.0 * np.cos(
        20.0 * middle
    )
    np.testing.assert_allclose(found.table.columns["before_rail"], foot, rtol=2e-3)
    np.testing.assert_allclose(
        found.table.columns["before_knee"], 4.0 * np.cos(20.0 * middle), rtol=2e-3
    )
    after = time[landing.first] + 0.012
    np.testing.assert_allclose(
        found.table.columns["after12ms_knee"], 4.0 * np.cos(20.0 * after), rtol=2e-2, atol=2e-3
    )
    np.testing.assert_allclose(found.table.columns["q_knee"], knee[landing.first], rtol=1e-12)


@pytest.mark.parametrize(
    ("step", "noise", "error"),
    [
        (1, 0.0, 2e-3),
        (2, 0.0, 2e-3),
        (4, 0.0, 3e-3),
        (10, 0.0, 6e-3),
        (1, 1e-4, 3e-3),
        (2, 1e-4, 6e-3),
    ],
)
def test_a_simulated_trot(trotting, dog_scene, step, noise, error):
    """At 2 kHz to 200 Hz, clean and with noise: every touchdown is found within a few samples, and
    none is invented.
    """
    columns = trotting.log(step, noise)
    found = shockpc.touchdowns(columns, dog_scene)
    assert sum(map(len, trotting.touchdowns)) > 20
    for foot, touchdowns in zip(FEET, trotting.touchdowns, strict=True):
        times = [
            columns["time"][landing.first]
            for landing in found.landings
            if f"{foot}_foot" in landing.contacts
        ]
        np.testing.assert_allclose(times, trotting.time[touchdowns], atol=error)
    assert ("none is given" in " ".join(found.warnings)) == (step == 10)
    assert any(name.startswith("before_") for name in found.table.columns) == (step < 10)


def test_velocities_of_a_trot_are_those_of_the_simulation(trotting, dog_scene):
    """In the middle of the window before a touchdown, and 6 ms after it; angular velocities of the
    base are in world axes.
    """
    found = shockpc.touchdowns(trotting.log(), dog_scene)
    rows, names = (
        [landing for landing in found.landings if landing.table],
        [f"{foot}_{name}" for foot in FEET for name in ("hip", "knee")],
    )
    for prefix, base, at in (
        ("before_", "", [k.first - 3 for k in rows]),
        ("after6ms_", "after6ms_", [k.last + 12 for k in rows]),
    ):
        truth = trotting.qvel[at].copy()
        truth[:, 3:6] = [rotation(trotting.qpos[k, 3:7]) @ trotting.qvel[k, 3:6] for k in at]
        keys = [
            *(base + key for key in ("vx", "vy", "vz", "wx", "wy", "wz")),
            *(prefix + name for name in names),
        ]
        values = np.stack([found.table.columns[key] for key in keys], axis=1)
        for part, error in ((slice(0, 3), 0.01), (slice(3, 6), 0.05), (slice(6, None), 0.1)):
            errors = np.abs(values[:, part] - truth[:, part])
            assert np.quantile(errors, 0.9) < error * (1.0 if prefix == "before_" else 4.0)


def rotation(quaternion):
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


@pytest.mark.slow
def test_the_table_is_one_that_landings_takes(here, trotting, dog_scene, capfd):
    """From the log to measured against predicted jumps on the command line; the figure and the
    table are written.
    """
    np.savez(here / "walk.npz", **trotting.log(), tau=np.zeros(len(trotting.time)))
    printed = good(
        capfd, "touchdowns", "walk.npz", dog_scene.robot, "--contact", "*_foot", "--out", "found"
    )
    assert 'columns that are not used: "tau"' in printed
    assert {file.name for file in (here / "found").iterdir()} >= {
        "touchdowns.csv",
        "touchdowns.json",
        "touchdowns.svg",
        "report.md",
    }
    found = json.loads(
        good(
            capfd,
            "recorded",
            "found/touchdowns.csv",
            dog_scene.robot,
            "--prove",
            0,
            "--format",
            "json",
        )
    )
    (rates,) = (
        row
        for row in found["tables"]["measured"]
        if row["quantity"] == "joint rates" and row["after"] == pytest.approx(6e-3)
    )
    assert rates["r"] > 0.7
    words = ("touchdowns", "walk.npz", dog_scene.robot, "--contact", "*_foot", "--map", "tau=")
    printed = good(capfd, *words, "--format", "csv")
    assert printed == (here / "found" / "touchdowns.csv").read_text()
    document = json.loads(good(capfd, *words, "--format", "json"))
    assert len(document["tables"]["touchdowns"]) == printed.count("\n") - 1


@pytest.mark.parametrize(
    ("together", "rows"), [(5.0, ["left_foot+right_foot"]), (2.0, ["left_foot", "right_foot"])]
)
def test_feet_that_touch_together(here, together, rows):
    """Within the time they are one landing, from the first foot's touchdown to the last one's; else
    the first stands.
    """
    found = stepped(here, stepping(), within_time=together)
    assert found.table.columns["contact"].tolist() == rows
    assert (found.landings[0].first, found.landings[-1].last) == (200, 203)
    assert found.table.columns.get("stance", np.array([""])).tolist()[-1] == (
        "" if len(rows) == 1 else "left_foot"
    )


def test_standing_feet_of_a_table_are_the_stance_of_its_landings(here):
    """A row with a standing foot is the landing of the scene that names it; an unknown foot is the
    message of its row.
    """
    scene = scene_of(here, STEPPER, "left_foot", "right_foot")
    columns = {
        "contact": np.array(["left_foot"] * 3),
        "stance": np.array(["right_foot", "", "tail"]),
        "vz": -np.ones(3),
        "vx": np.zeros(3),
    }
    results = shockpc.recorded(columns, scene, ["delta_v@body"]).table
    for k, stance in enumerate([("right_foot",), ()]):
        single = Scene(robot=scene.robot, contact="left_foot", stance=stance)
        alone = shockpc.recorded(
            {"vz": -np.ones(1), "vx": np.zeros(1)}, single, ["delta_v@body"]
        ).table
        assert results.columns["delta_v@body"][k] == pytest.approx(
            alone.columns["delta_v@body"][0], rel=1e-12
        )
    assert results.columns["delta_v@body"][0] != pytest.approx(
        results.columns["delta_v@body"][1], rel=1e-3
    )
    assert "tail" in results.messages[2]


def test_flags_and_forces(here):
    """A column named like a foot, or one that is named, says when it touches; chatter is one; a
    short force must be large.
    """
    columns = stepping()
    t = columns["time"]
    force = np.where((t > 0.2985) | (np.abs(t - 0.1) < 0.003), 40.0, 0.5) * (
        np.abs(t - 0.305) > 0.0006
    )
    columns |= {"left_foot_force": force, "sensor": (t > 0.4).astype(float)}
    found = stepped(here, columns, flags={"right_foot": "sensor"})
    assert [(landing.first, landing.contacts) for landing in found.landings] == [
        (298, ("left_foot",)),
        (400, ("right_foot",)),
    ]
    assert found.flagged == {"left_foot": "left_foot_force", "right_foot": "sensor"}
    assert found.landings[1].stance == ("left_foot",)
    assert "exceeds 1.86 N" in " ".join(found.warnings)
    assert (
        len(stepped(here, columns, flags={"right_foot": "sensor"}, contact_force=50.0).landings)
        == 1
    )
    bounces = stepped(
        here,
        columns | {"left_foot_force": 400.0 * (np.abs(t - 0.1) < 0.003)},
        flags={"right_foot": "sensor"},
    )
    assert [landing.first for landing in bounces.landings] == [97, 400]
    with pytest.raises(StudyError, match="no contact has a column of forces"):
        stepped(
            here,
            columns | {"left_foot_force": 1.0 * (force > 1.0)},
            flags={"right_foot": "sensor"},
            contact_force=50.0,
        )
    with pytest.raises(UnknownName, match='no column "sensr"'):
        stepped(here, columns, flags={"right_foot": "sensr"})


def test_a_column_without_a_number_says_nothing_of_when_a_foot_touches(here):
    """The heights do then, or the foot is not looked for; a column that is named is refused."""
    columns = stepping()
    empty = {"left_foot_contact": np.full(len(columns["time"]), np.nan)}
    by_heights, found = stepped(here, columns), stepped(here, columns | empty)
    assert not found.flagged
    assert found.landings
    assert len(found.landings) == len(by_heights.landings)
    del columns["z"]
    with pytest.raises(StudyError, match="is not in this log"):
        stepped(here, columns | empty)
    with pytest.raises(StudyError, match="left_foot_contact has no number"):
        stepped(here, columns | empty, flags={"left_foot": "left_foot_contact"})


def test_an_option_that_the_log_overrides_is_refused(here, capfd):
    """As with a table of landings.

    A joint that the log lacks may be given, and is then where it is said to be.
    """
    scene_of(here, STEPPER, "left_foot", "right_foot")
    columns = stepping()
    np.savez(here / "log.npz", **columns)
    words = ("touchdowns", "log.npz", "robot.urdf", "--contact", "*_foot", "--format", "json")
    for option, column in (
        ("--set=right_leg=0.1", "right_leg"),
        ("--base-rpy=1,0,0", "qw"),
        ("--posture=neutral", "left_leg"),
    ):
        outcome = run(capfd, *words, option)
        assert (outcome.code, outcome.out) == (2, "")
        assert f'(column "{column}")' in outcome.err
    lacking = (*words, "--map", "right_leg=", "--set=right_leg=0.1")
    (warning,) = json.loads(good(capfd, *lacking))["warnings"]
    assert says(warning, 'position of "right_leg"', "scene")


def test_a_rail_that_is_not_in_the_log_is_known_by_a_flight(here):
    """The centre of mass falls freely between contacts while the knee moves; a flight that would
    begin downwards gives no row.
    """
    scene, time = scene_of(here, RAIL, "foot"), np.arange(0.0, 0.6, 1e-3)
    knee = 0.8 + 0.3 * np.sin(15.0 * time)
    # Heights of the centre of mass and of the foot from the rail's zero.
    com, foot = -(0.2 + 0.1 * np.cos(knee)) / 6.0, -0.2 - 0.2 * np.cos(knee)
    flight = time[100:] - time[100]
    rail = -foot[100] + com[100] + 1.2 * flight - 4.905 * flight**2 - com[100:]
    touch = 100 + int(np.flatnonzero(rail + foot[100:] < 0.0)[1]) - 1
    on = (np.arange(len(time)) <= 100) | (np.arange(len(time)) > touch)
    columns = {"time": time, "knee": knee, "foot_contact": on.astype(float)}
    (landing,) = shockpc.touchdowns(columns, scene).landings
    assert landing.first == touch > 250
    middle = np.gradient(rail, time[100:])[[touch - 102, touch - 101]].mean()
    np.testing.assert_allclose(
        shockpc.touchdowns(columns, scene).table.columns["before_rail"], middle, rtol=0.02
    )
    bent = shockpc.touchdowns(
        columns
        | {
            "knee": np.where(time < 0.14, 0.0, 1.5),
            "foot_contact": (np.abs(time - 0.13) > 0.025) * 1.0,
        },
        scene,
    )
    assert [one.table for one in bent.landings] == [False]
    assert "no flight before it that begins upwards" in bent.landings[0].message


@pytest.mark.parametrize("lacking", ["z", "left_leg"])
def test_what_the_heights_need_and_the_log_lacks_is_said(here, lacking):
    """Without the base's height or a joint of a leg, no heights; with flags there are touchdowns,
    none of them invented.
    """
    columns = stepping()
    del columns[lacking]
    with pytest.raises(StudyError, match="is not in this log") as refusal:
        stepped(here, columns)
    assert lacking in str(refusal.value)
    flag = (columns["time"] > 0.2).astype(float)
    found = stepped(here, columns | {"left_foot_contact": flag, "right_foot_contact": flag})
    assert found.table.columns["contact"].tolist() == ["left_foot+right_foot"]
    assert found.heights is None
    absent = {"z": {"z"}, "left_leg": {"q_left_leg", "before_left_leg"}}[lacking]
    assert not absent & found.table.columns.keys()
    if lacking == "z":  # of the feet that stand after it, and none stands before
        assert found.table.columns["after6ms_vz"] == pytest.approx(-0.1)
        assert np.isnan(found.table.columns["vz"]).all()
        assert found.landings[0].message == "no base velocity: no foot stands"


@pytest.mark.parametrize(
    ("rate", "warned", "given"), [(1000.0, False, True), (400.0, True, True), (250.0, True, False)]
)
def test_the_rate_of_samples_decides(here, rate, warned, given):
    found = stepped(here, stepping(rate))
    assert any("samples a second" in text for text in found.warnings) == warned
    assert ("before_left_leg" in found.table.columns) == given
    assert len(found.landings) == 1


@pytest.mark.parametrize("jitter", [0.0, 2e-4])
def test_velocities_are_given_at_every_rate_that_has_some(here, jitter):
    """At 400 Hz the window of 5 ms holds two samples around 6 and 12 ms; of times that are off it
    holds two before.
    """
    time = np.arange(200) / 400.0 + jitter * np.sin(7.0 * np.arange(200))
    z = 0.6 - 0.1 * time
    legs = dict.fromkeys(("left_leg", "right_leg"), np.maximum(0.2013 - time, 0.0) + 0.5 - z)
    found = stepped(
        here,
        stepping(400.0) | legs | {"time": time, "z": z},
        after=(1.0, 6.0, 12.0, 30.0, 290.0, 310.0),
    )
    (landing,) = found.landings
    table = found.table.columns
    assert table["before_left_leg"] == pytest.approx(-0.9)
    assert [table[f"after{time}ms_left_leg"][0] for time in (6, 12, 30, 290)] == pytest.approx(
        [0.1] * 4
    )
    assert np.isnan([table[f"after{time}ms_left_leg"][0] for time in (1, 310)]).all()
    assert (
        landing.message.count("310 ms")
        == landing.message.count("no velocities 1 ms after it, as")
        == 1
    )


def test_all_feet_are_looked_at_whatever_strikes_in_the_scene(here):
    """As the command does; `contacts` restricts it, and the table's own contacts are enough for a
    scene without any.
    """
    scene = scene_of(here, STEPPER, "left_foot")
    found = shockpc.touchdowns(stepping(), scene)
    assert found.frames == ("left_foot", "right_foot")
    assert shockpc.touchdowns(stepping(), scene, contacts=["right_foot"]).frames == ("right_foot",)
    few = shockpc.touchdowns(
        {name: x for name, x in stepping().items() if name != "right_leg"}, scene
    )
    assert few.frames == ("left_foot",)
    assert any("right_foot" in text and "right_leg" in text for text in few.warnings)
    rows = shockpc.recorded(found.table, Scene(robot=scene.robot)).table.to_pandas()
    assert rows[["name", "contact"]].values.tolist() == [["1", "left_foot+right_foot"]]


def test_a_window_with_too_few_samples_is_refused(here):
    with pytest.raises(StudyError, match="at least 4 ms"):
        stepped(here, stepping(500.0), window=2.0)


def test_rates_that_lag_are_said_and_not_used(here):
    """A rate that a filter delays by 5 ms."""
    columns, swing = stepping(), 0.05 * np.sin(15.0 * stepping()["time"]) ** 3
    columns["left_leg"] = columns["left_leg"] + swing
    columns["z"] = columns["z"] - swing
    plain = stepped(here, columns)
    rate = np.gradient(columns["left_leg"], columns["time"])
    late = stepped(
        here, columns | {"qd_left_leg": np.concatenate([np.full(5, rate[0]), rate[:-5]])}
    )
    assert 'by 5.0 ms, and are not used: "left_leg"' in " ".join(late.warnings)
    assert not any(
        "lag" in text
        for text in (*plain.warnings, *stepped(here, columns | {"qd_left_leg": rate}).warnings)
    )
    for name, values in plain.table.columns.items():
        np.testing.assert_array_equal(late.table.columns[name], values)


def test_slower_samples_are_brought_to_the_clock_of_the_fast_ones(here):
    """A base of 250 Hz whose quaternion changes its sign beside joints of 1 kHz; over a gap of it
    nothing is found.
    """
    columns = stepping()
    slow = np.arange(len(columns["time"])) % 4 == 0
    for name in ("x", "y", "z", "qw", "qx", "qy", "qz"):
        columns[name] = np.where(slow, columns[name], np.nan)
    columns["qw"] = columns["qw"] * np.where(np.arange(len(slow)) % 8 == 0, 1.0, -1.0)
    found = stepped(here, columns)
    assert [landing.first for landing in found.landings] == [200]
    assert found.window == {"joints": pytest.approx(3e-3), "base": np.inf}
    np.testing.assert_allclose(found.table.columns["before_left_leg"], -0.9, rtol=1e-9)
    columns["z"][150:250] = np.nan
    found = stepped(here, columns)
    assert found.landings == ()
    assert 'left out, with no number near them in "z"' in " ".join(found.warnings)


def test_a_log_without_touchdowns_and_its_ends(here, capfd):
    """Feet that fall in the air and rise again, or stand, do not land; what of a landing is cut off
    is said.
    """
    swing = stepping()
    for side in ("left", "right"):
        swing[f"{side}_leg"] = 0.5 - swing["z"] + 0.05 * np.cos(2.0 * np.pi * 5.0 * swing["time"])
    assert stepped(here, swing).landings == ()
    assert {name: len(x) for name, x in stepped(here, swing).table.columns.items()} == {
        "name": 0,
        "time": 0,
        "contact": 0,
    }
    written(here / "swing.csv", swing)
    assert "no touchdowns" in good(capfd, "touchdowns", "swing.csv", "robot.urdf", "--out", "none")
    late = stepped(
        here, {name: values[:250] for name, values in stepping().items()}, after=(6.0, 45.0, 60.0)
    )
    assert "no velocities 45, 60 ms after it" in late.landings[0].message
    assert np.isnan(late.table.columns["after45ms_left_leg"]).all()
    assert np.isfinite(late.table.columns["after6ms_left_leg"]).all()
    early = stepped(here, stepping(stops=(0.0015, 0.0015)))
    assert [landing.table for landing in early.landings] in ([], [False])


HOSTILE = {
    "no time": (lambda c: c.pop("time"), "a log has a column of times"),
    "time runs back": (lambda c: c["time"].__setitem__(300, 0.1), "runs back in row 300"),
    "seconds": (lambda c: c.update(time=c["time"] * 1e3), "too far for the motion of a leg"),
    "no number": (lambda c: c.update(z=np.full(500, np.nan)), "is not in this log"),
    "infinite": (lambda c: c["z"].__setitem__(7, np.inf), "inf in row 7"),
    "text": (lambda c: c.update(z=np.array(["up"] * 500)), 'holds "up"'),
    "length": (lambda c: c.update(z=c["z"][:-1]), "differ in length"),
    "one time": (lambda c: c.update(time=np.zeros(500)), "one time"),
    "one moment": (
        lambda c: c.update(time=np.arange(500) * 1e-303),
        "1e-303 s apart, too near for the motion of a leg",
    ),
    "out of range": (lambda c: c["z"].__setitem__(7, 1e200), r"1e\+200 in row 7"),
    "nothing": (lambda c: [c.pop(name) for name in [*c][1:]], "no positions"),
    "no times": (lambda c: c.update(time=np.full(500, np.nan)), "has 0 times"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_log_that_cannot_be_read_is_one_message(here, case):
    change, text = HOSTILE[case]
    columns = stepping()
    columns["time"] = columns["time"].copy()
    change(columns)
    with pytest.raises(StudyError, match=text):
        stepped(here, columns)


def test_clocks(here):
    """Times in other units, dates, nanoseconds since 1970, rows without a time and repeated ones;
    all give the same touchdown.
    """
    columns = stepping()
    time = columns.pop("time")
    stamps = (1_700_000_000 * 10**9 + np.round(time * 1e9)).astype(np.int64)
    for clock in (
        {"time_ms": 1e3 * time},
        {"t": time},
        {"timestamp": stamps},
        {"stamp_ns": stamps - stamps[0]},
        {"time": stamps.astype("datetime64[ns]")},
        {"time": time + 1.7e9},
    ):
        (landing,) = stepped(here, columns | clock).landings
        assert landing.first == 200
    broken = time.copy()
    broken[[10, 20]] = np.nan, broken[19]
    found = stepped(here, columns | {"time": broken})
    assert found.landings[0].first == 198
    assert [text for text in found.warnings if "left out" in text] == [
        "1 of 500 samples have no time, and are left out",
        "1 of 500 samples have the time of the sample before them, and are left out",
    ]


def test_pickles_are_not_opened(here, capfd):
    np.savez(here / "log.npz", time=np.array([object()]), z=np.zeros(1))
    (here / "robot.urdf").write_text(STEPPER)
    outcome = run(capfd, "touchdowns", "log.npz", "robot.urdf")
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1


class Bag:
    """Writes bags of ROS 1, of ROS 2, and MCAP with joints at 1 kHz and other topics."""

    def __init__(self, path, kind):
        self.store, self.kind = (
            get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE),
            kind,
        )
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        self.writer = (
            WriterOfRos1(path)
            if kind == "bag"
            else WriterOfRos2(path, version=9, storage_plugin=plugin)
        )
        self.connections = {}

    def header(self, seconds):
        ns = 1_700_000_000 * 10**9 + round(seconds * 1e9)
        stamp = self.store.types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9)
        more = {"seq": 0} if self.kind == "bag" else {}
        return self.store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **more)

    def make(self, kind, *values):
        return self.store.types[f"geometry_msgs/msg/{kind}"](*values)

    def write(self, topic, message, seconds):
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        raw = (
            self.store.serialize_ros1(message, kind)
            if self.kind == "bag"
            else self.store.serialize_cdr(message, kind)
        )
        self.writer.write(self.connections[topic], round(seconds * 1e9), raw)

    def joints(self, topic, seconds, names, positions):
        kind = self.store.types["sensor_msgs/msg/JointState"]
        self.write(
            topic,
            kind(self.header(seconds), names, np.array(positions), np.zeros(0), np.zeros(0)),
            seconds,
        )

    def pose(self, topic, seconds, xyz, wxyz):
        kind, (w, *rest) = self.store.types["geometry_msgs/msg/PoseStamped"], wxyz
        pose = self.make("Pose", self.make("Point", *xyz), self.make("Quaternion", *rest, w))
        self.write(topic, kind(self.header(seconds), pose), seconds)


def recorded(path, kind, others=()):
    """A bag of the stepper's motion, with joints and poses of other topics."""
    columns = stepping()
    bag = Bag(path, kind)
    with bag.writer:
        for k, seconds in enumerate(columns["time"].tolist()):
            legs = [columns["left_leg"][k], columns["right_leg"][k]]
            bag.joints("/joint_states", seconds, ["left_leg", "right_leg"], legs)
            for topic in others:
                bag.joints(topic, seconds, ["left_leg", "right_leg"], [0.0, 0.0])
            if k % 2 == 0:
                at = seconds + 3e-4
                bag.pose(
                    "/mocap/pose",
                    at,
                    (0.0, 0.0, 0.6 - 0.1 * at),
                    (-1.0 if k % 4 else 1.0, 0.0, 0.0, 0.0),
                )
    return path


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_bags(here, kind):
    """Joints at 1 kHz and poses at 500 Hz between them are the motion that was written; a damaged
    file is one message.
    """
    path = recorded(here / ("log.bag" if kind == "bag" else "log"), kind)
    found = stepped(here, path)
    np.testing.assert_allclose(
        found.table.columns["time"], [1_700_000_000.2], rtol=1e-15, atol=1e-6
    )
    assert [landing.last - landing.first for landing in found.landings] == [3]
    np.testing.assert_allclose(found.table.columns["vz"], -0.1, rtol=1e-6)
    np.testing.assert_allclose(found.table.columns["before_left_leg"], -0.9, rtol=1e-6)
    file = path if path.is_file() else path / f"log.{kind}"
    if path.is_dir():
        assert stepped(here, file).landings == found.landings
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with pytest.raises(StudyError, match="cannot be read"):
        stepped(here, path)


def test_topics_of_a_bag(here, capfd):
    """Of several topics of joints the usual one is read; if none is, they are named; those that are
    asked for are read alone.
    """
    path = recorded(here / "log.bag", "bag", ["/wanted", "/sensed"])
    robot = load_robot(scene_of(here, STEPPER, "left_foot").robot)
    log = read_log(path, robot, {})
    assert says(log.remarks, '"/joint_states", not of "/sensed", "/wanted"')
    asked = read_log(path, robot, {}, ["/wanted", "/mocap/pose"])
    assert np.ptp(asked.positions["q_left_leg"]) == 0.0
    with pytest.raises(UnknownName, match='no topic "/wantd"'):
        read_log(path, robot, {}, ["/wantd"])
    bag = Bag(here / "two.bag", "bag")
    with bag.writer:
        for topic in ("/a", "/b"):
            bag.joints(topic, 0.1, ["left_leg"], [0.0])
    outcome = run(capfd, "touchdowns", "two.bag", "robot.urdf")
    assert outcome.code == 2
    assert '"/a", "/b"; select with --topic' in outcome.err


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_attitude_and_twist_of_a_bag(here, kind):
    """Imu gives the attitude, TwistStamped velocities in world axes, Odometry the pose and
    velocities in the base's axes.
    """
    path, attitude = here / ("log.bag" if kind == "bag" else "log"), (0.5, 0.5, -0.5, 0.5)
    bag, odometry = Bag(path, kind), Bag(here / ("odom.bag" if kind == "bag" else "odom"), kind)
    types = bag.store.types

    def twist(seconds):
        return bag.make(
            "Twist", bag.make("Vector3", 0.1, -0.2, seconds), bag.make("Vector3", 1.0, 2.0, 3.0)
        )

    def quaternion(wxyz):
        return bag.make("Quaternion", *wxyz[1:], wxyz[0])

    with bag.writer, odometry.writer:
        for k in range(20):
            seconds = 0.01 * k
            bag.joints("/joint_states", seconds, ["left_leg"], [0.5 * seconds])
            bag.write(
                "/base_twist",
                types["geometry_msgs/msg/TwistStamped"](bag.header(seconds), twist(seconds)),
                seconds,
            )
            # A covariance of −1 says that there is no orientation.
            known = np.full(9, -1.0 if k == 7 else 0.0)
            q = quaternion((1.0, 0.0, 0.0, 0.0) if k == 7 else attitude)
            turning, gravity = (
                bag.make("Vector3", seconds, 0.0, 0.0),
                bag.make("Vector3", 0.0, 0.0, 9.81),
            )
            header = bag.header(seconds)
            header.frame_id = "imu"
            imu = types["sensor_msgs/msg/Imu"](
                header, q, known, turning, np.zeros(9), gravity, np.zeros(9)
            )
            bag.write("/imu/data", imu, seconds)
            pose = bag.make(
                "Pose", bag.make("Point", 1.0, 2.0, 3.0 + seconds), quaternion(attitude)
            )
            with_pose, with_twist = (
                types[f"geometry_msgs/msg/{name}WithCovariance"] for name in ("Pose", "Twist")
            )
            message = types["nav_msgs/msg/Odometry"](
                bag.header(seconds),
                "base",
                with_pose(pose, np.zeros(36)),
                with_twist(twist(seconds), np.zeros(36)),
            )
            odometry.write("/odom", message, seconds)
    remarks = []
    columns = read_bag(path, (), remarks)
    time = 1e-9 * (columns["time_ns"] - columns["time_ns"][0])
    for name, value in zip(("qw", "qx", "qy", "qz"), attitude, strict=True):
        np.testing.assert_allclose(columns[name], np.where(np.arange(20) == 7, np.nan, value))
    np.testing.assert_allclose(columns["vz"], time, atol=1e-9)
    np.testing.assert_allclose([columns["vx"], columns["vy"]], [[0.1] * 20, [-0.2] * 20])
    np.testing.assert_allclose(
        [columns["wx"], columns["wy"], columns["wz"]], [[1.0] * 20, [2.0] * 20, [3.0] * 20]
    )
    assert any('attitude of the base is taken from "/imu/data"' in remark for remark in remarks)
    np.testing.assert_allclose(
        columns["wx@imu"], np.where(np.arange(20) == 7, np.nan, time), atol=1e-9
    )
    np.testing.assert_allclose(columns["az@imu"], np.where(np.arange(20) == 7, np.nan, 9.81))
    columns = read_bag(here / odometry.writer.path.name, (), [])
    np.testing.assert_allclose(columns["z"], 3.0 + time, atol=1e-9)
    np.testing.assert_allclose(columns["vz_body"], time, atol=1e-9)
    np.testing.assert_allclose(columns["qy"], -0.5)


NOISES = ("noise of 0.1 mm and mrad", "noise of 0.3 mm and mrad", "noise of 1 mm and mrad")
LOGS_OF_THE_GUIDE = {
    "trots, 2 and 1 kHz, and 500 Hz": ("trots, 2 kHz", "trots, 1 kHz", "trots, 0.5 kHz"),
    "the same at 200 Hz, which gives only times": ("trots, 0.2 kHz",),
    "the same at 1 kHz, noise of 0.1, 0.3 and 1 mm (base) and mrad (joints)": tuple(
        f"trots, 1 kHz, {noise}" for noise in NOISES
    ),
    "falls on legs that are held, 2 and 1 kHz": ("falls, 2 kHz", "falls, 1 kHz"),
    "the same at 500 and 200 Hz": ("falls, 0.5 kHz", "falls, 0.2 kHz"),
    "the same at 1 kHz, noise of 0.1, 0.3 and 1 mm and mrad": tuple(
        f"falls, 1 kHz, {noise}" for noise in NOISES
    ),
}
"""Rows of the guide's table, and the logs of the benchmark that each sums up."""


@pytest.mark.slow
def test_the_table_of_the_guide_is_that_of_the_benchmark():
    """Touchdowns found of all, false ones, and the median delay, of the logs of each row."""
    page = (Path(shockpc.__file__).parent / "wings/recordings/logs.md").read_text(encoding="utf-8")
    computed = {row[0]: row[1:] for row in found_touchdowns().rows}
    for row, logs in LOGS_OF_THE_GUIDE.items():
        (line,) = re.findall(rf"^\| {re.escape(row)} \| (.*) ms \|$", page, re.MULTILINE)
        found, false, late = (set(re.findall(r"[\d.]+", cell)) for cell in line.split(" | "))
        touchdowns_of_logs, found_in_logs, false_in_logs, delays = zip(
            *(computed[log] for log in logs), strict=True
        )
        assert found == set(map(str, [*found_in_logs, *touchdowns_of_logs]))
        assert false == set(map(str, false_in_logs))
        limits = [min(delays), max(delays)]
        assert late == {f"{1e3 * delay:.1f}".replace("0.0", "0") for delay in limits}
