"""Tables of recorded landings: what columns mean, rows in arrays against single landings, and
measured jumps against predicted.
"""

import csv
import io
import json
import re
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pyarrow.parquet
import pytest
from commands import good, run, says, vector
from log_file import written
from matplotlib.backends.backend_agg import FigureCanvasAgg
from robot_texts import body, floating, mjcf
from scipy.spatial.transform import Rotation
from trees import known_robot, robot_from

import shockpc
from shockpc import Contact, Joints, Posture, Scene, load_robot, read_scene, resolve, shock_profile
from shockpc.bench.measured import IGNORED, LAWS, measured_landings, measured_steps, measured_tosses
from shockpc.evaluation.column import Column, selected
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene_file import robot_of, scene_text
from shockpc.method.approach import Motion
from shockpc.text.errors import SceneError, SolveError, StudyError, UnknownName
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding
from shockpc.wings.recordings.recorded import study as recorded
from shockpc.wings.recordings.recorded.figure import draw_validation
from shockpc.wings.recordings.recorded.report import agreement_sheet
from shockpc.wings.recordings.recorded.study import (
    DRAWS,
    SEED,
    STATISTICS,
    Agreement,
    Validation,
    compare_measured,
)
from shockpc.wings.recordings.tables import table_files as files
from shockpc.wings.recordings.tables.evaluation import recorded_landings
from shockpc.wings.recordings.tables.landings import CLOSED_BY
from shockpc.wings.recordings.tables.reader import rows_of
from shockpc.wings.recordings.tables.table_files import read_table

SCENE = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),))
JOINTS = ("LF_HAA", "LF_HFE", "LF_KFE", "RH_KFE")
FIVE_BAR = Path(__file__).parents[3] / "robots" / "scenes" / "five_bar.toml"


def table(n=6, seed=1):
    """Random landings of ANYmal B: a few joints, attitude, velocities."""
    rng = np.random.default_rng(seed)
    q = np.concatenate([[1.0, 0.0, 0.0, 0.0] + 0.2 * rng.standard_normal((n, 4))])
    columns = dict(
        zip(("qw", "qx", "qy", "qz"), (q / np.linalg.norm(q, axis=1)[:, None]).T, strict=True)
    )
    columns |= {"vx": rng.normal(0.0, 0.1, n), "vz": -1.0 - rng.random(n)} | {
        key: rng.normal(0.0, 0.5, n) for key in ("wx", "wy", "wz")
    }
    for name in JOINTS:
        columns |= {
            f"q_{name}": rng.uniform(-0.5, 0.5, n),
            f"before_{name}": rng.normal(0.0, 0.3, n),
        }
    return columns


def study(columns, scene=SCENE, quantities=(), robot=None, prove=0):
    """The landings of a table."""
    robot = robot or known_robot("anymal_b")
    return recorded_landings(
        rows_of(columns, landing_of(scene, robot)), robot, quantities, prove=prove
    )


def compute(made):
    """The landings of a table, and what is computed of them."""
    table = made.table
    return SimpleNamespace(
        study=made.landings,
        computed=made.computed,
        table=table,
        columns=table.columns,
        messages=table.messages,
    )


def test_each_row_is_the_landing_of_its_own_posture_and_motion():
    """All quantities of a row in arrays are those that a single landing, written as a scene, has
    with a proof.
    """
    robot, wanted = (
        known_robot("anymal_b"),
        (
            "delta_v@imu_link",
            "shock@imu_link",
            "friction_needed",
            "energy_share",
            "v_in",
            "delta_qd",
        ),
    )
    found = compute(study(table(), quantities=wanted, prove=2))
    assert not found.messages
    assert not found.columns["proven"].any()
    for i in range(6):
        profile = shock_profile(found.study.case(i), robot)
        for column in found.computed:
            (value,) = profile.numbers(column.selection, [column.place])
            assert found.columns[column.name][i] == pytest.approx(value, rel=1e-9, abs=1e-12)
    assert np.isfinite(found.columns["double_error"]).sum() == 2


def test_a_table_in_python_is_its_columns_or_its_file(tmp_path):
    """As every other study: shockpc.recorded gives an evaluation whose table has the same numbers."""
    columns, robot = table(), known_robot("anymal_b")
    first, second = (
        shockpc.recorded(given, SCENE, ("shock@imu_link",), robot=robot).table
        for given in (columns, written(tmp_path / "log.csv", columns))
    )
    np.testing.assert_allclose(
        first.values("shock@imu_link"), second.values("shock@imu_link"), rtol=1e-12
    )
    assert first.worst(1, "shock@imu_link") == [int(np.argmax(first.values("shock@imu_link")))]
    assert first.percentile("shock@imu_link", 100) == first.values("shock@imu_link").max()
    assert first.to_arrow().column_names == [*first.columns, "message"]
    with pytest.raises(StudyError, match="table is 3, of type int"):
        shockpc.recorded(3, SCENE)


def test_velocities_in_the_axes_of_the_base_are_turned_to_the_world():
    """vx_body … are R⁻¹ v; _deg is in degrees."""
    columns, robot = table(), known_robot("anymal_b")
    rotation = Rotation.from_quat(
        np.stack([columns[key] for key in ("qx", "qy", "qz", "qw")], axis=1)
    )
    in_body = rotation.inv().apply(np.stack([columns["vx"], np.zeros(6), columns["vz"]], axis=1))
    other = {key: values for key, values in columns.items() if key not in ("vx", "vz", "q_LF_KFE")}
    other |= {f"v{axis}_body": in_body[:, k] for k, axis in enumerate("xyz")} | {
        "q_LF_KFE_deg": np.degrees(columns["q_LF_KFE"])
    }
    first, second = (rows_of(one, resolve(SCENE, robot)) for one in (columns, other))
    np.testing.assert_allclose(second.before.velocity, first.before.velocity, atol=1e-12)
    np.testing.assert_allclose(second.Q, first.Q, atol=1e-12)
    assert "base vy" in first.missing
    assert "base vy" not in second.missing


def test_arrays_of_mujoco():
    """The base's angular velocity in qvel is in its axes; the order of joints is that of the file."""
    robot = robot_from(mjcf(floating(body("leg", joints='<joint name="a" axis="0 1 0"/>'))), ".xml")
    scene = Scene(robot="m.xml", contact=(Contact(frame="leg", offset=(0.0, 0.0, -0.3)),))
    attitude = Rotation.from_euler("xyz", [0.3, -0.2, 0.5])
    qpos, omega = (
        np.array([[0.1, 0.2, 0.3, *np.roll(attitude.as_quat(), 1), 0.4]]),
        np.array([0.1, 0.2, 0.3]),
    )
    both = {"qpos": qpos, "qvel": np.array([[0.0, 0.1, -1.0, *omega, 0.7]])}
    arrays = rows_of(both, resolve(scene, robot))
    named = dict(zip(("x", "y", "z", "qw", "qx", "qy", "qz"), qpos.T, strict=False))
    named |= {
        "a": np.array([0.4]),
        "before_a": np.array([0.7]),
        "vx": np.zeros(1),
        "vy": np.array([0.1]),
        "vz": np.array([-1.0]),
    }
    named |= {
        key: np.array([value])
        for key, value in zip(("wx", "wy", "wz"), attitude.apply(omega), strict=True)
    }
    expected = rows_of(named, resolve(scene, robot))
    np.testing.assert_allclose(arrays.Q, expected.Q, atol=1e-15)
    for one, other in zip(arrays.before, expected.before, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-15)
    for name in ("a", "before_a", "vz"):  # which mean what the arrays hold
        for columns in (both | {name: named[name]}, {name: named[name]} | both):
            with pytest.raises(StudyError, match="two columns of the table mean"):
                rows_of(columns, resolve(scene, robot))


def test_a_scene_holds_the_rotation_of_a_ball_joint(tmp_path):
    """The scene of a row has it as its key, written and read; the rates of such a joint it cannot
    hold.
    """
    robot = robot_from(
        mjcf(floating(body("leg", joints='<joint name="hip" type="ball"/>'))), ".xml"
    )
    scene = Scene(robot="m.xml", contact=(Contact(frame="leg", offset=(0.1, 0.0, -0.3)),))
    turned = Rotation.from_euler("xyz", [0.3, -0.2, 0.5]).as_quat()
    qpos, qvel = (
        np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *np.roll(turned, 1)]]),
        np.array([[0.1, 0.0, -1.0, *np.zeros(6)]]),
    )
    made = recorded_landings(rows_of({"qpos": qpos, "qvel": qvel}, landing_of(scene, robot)), robot)
    case = made.landings.case(0)
    np.testing.assert_allclose(case.posture.joint_quaternions["hip"], turned, atol=1e-15)
    (tmp_path / "row.toml").write_text(scene_text(case, tmp_path))
    again, expected = (
        shock_profile(replace(read_scene(tmp_path / "row.toml"), robot="m.xml"), robot),
        made.landings.profile(0),
    )
    np.testing.assert_allclose(again.q, expected.q, atol=1e-15)
    np.testing.assert_allclose(again.delta_v, expected.delta_v, atol=1e-12)
    assert not np.allclose(
        again.delta_v, shock_profile(replace(case, posture=Posture()), robot).delta_v, atol=1e-3
    )
    with pytest.raises(SceneError, match=r'joint "hip" \(ball\) has length 2'):
        shock_profile(
            replace(case, posture=Posture(joint_quaternions={"hip": (0.0, 0.0, 0.0, 2.0)})), robot
        )
    qvel[0, 7] = 0.2
    spinning = recorded_landings(
        rows_of({"qpos": qpos, "qvel": qvel}, landing_of(scene, robot)), robot
    )
    with pytest.raises(StudyError, match=r'"hip".*3 degrees of freedom'):
        spinning.landings.case(0)


def test_a_recorded_angle_that_a_scene_would_refuse_is_not_written_as_one():
    """Beyond its limits and a whole turn: the row is computed, and its scene is refused, as it
    would be when it is read.
    """
    robot, contact = known_robot("go2"), (Contact(frame="FL_foot"),)
    made = study(
        {"FL_thigh_joint": np.array([7.5, 6.0]), "FL_calf_joint": np.array([-1.5, -1.2])},
        Scene(robot="go2", contact=contact),
        robot=robot,
    )
    assert len(made.table.messages) == 0
    with pytest.raises(StudyError, match=r'row 0.*429\.718 deg.*"FL_thigh_joint"'):
        made.landings.case(0)
    np.testing.assert_allclose(
        shock_profile(made.landings.case(1), robot).delta_v,
        made.landings.profile(1).delta_v,
        rtol=1e-12,
        atol=1e-14,
    )


def test_arrays_of_ros_and_recorded_messages():
    """JointState with its names, as arrays and as columns of a recorded topic."""
    names, position, velocity = np.array(JOINTS[:2]), np.array([[0.1, 0.2]]), np.array([[0.3, 0.4]])
    columns = {f"/joint_states/{name}/position": position[:, k] for k, name in enumerate(names)}
    columns |= {f"/joint_states/{name}/velocity": velocity[:, k] for k, name in enumerate(names)}
    landing = resolve(SCENE, known_robot("anymal_b"))
    rows = [
        rows_of(one, landing)
        for one in ({"name": names, "position": position, "velocity": velocity}, columns)
    ]
    for one in rows:
        assert [landing.robot.joint(name).value(one.Q[0]) for name in names] == pytest.approx(
            [0.1, 0.2]
        )
        assert [
            one.before.joint_rates[0, landing.robot.joint(name).v.start] for name in names
        ] == pytest.approx([0.3, 0.4])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"qw": np.full(6, 0.9)}, r"row 0: the base's quaternion .* has length"),
        ({"vz": np.full(6, np.nan)}, "row 0, column vz: nan is not a finite number"),
        ({"contact": np.array(["LF_FOT"] * 6)}, r'row 0: no contact "LF_FOT" .*LF_FOOT'),
        ({"q_LF_KNEE": np.zeros(6)}, r'no joint "LF_KNEE" in robot "anymal"; nearest: .*LF_KFE'),
        ({"after_LF_HIP": np.zeros(6)}, 'no joint "LF_HIP"'),
        ({"LF_KFE": np.zeros(6)}, 'two columns of the table mean joint "LF_KFE"'),
        ({"after_RF_KFE": np.zeros(6)}, "no rate of this joint before the impact"),
        ({"vx_body": np.zeros(6)}, "two columns of the table mean"),
        ({"short": np.zeros(5)}, "differ in length"),
    ],
)
def test_columns_that_cannot_be_right_are_refused(change, message):
    with pytest.raises((StudyError, UnknownName), match=message):
        rows_of(table() | change, resolve(SCENE, known_robot("anymal_b")))


def test_a_table_without_a_landing_is_refused_by_the_name_of_its_first_row():
    columns = table() | {"name": np.array(list("abcdef")), "vz": np.full(6, np.nan)}
    with pytest.raises(StudyError, match='landing "a", row 0, column vz') as refused:
        rows_of(columns, resolve(SCENE, known_robot("anymal_b")))
    assert refused.value.rows == (0, 1, 2, 3, 4, 5)


@pytest.mark.parametrize(
    ("column", "cell", "message"),
    [
        ("vz", "", "column vz: nan is not a finite number (as an empty cell"),
        ("vz", "fast", 'column vz: "fast" is not a number'),
        ("vz", "inf", "column vz: inf is not a finite number"),
        ("q_LF_KFE", "1e300", "column q_LF_KFE: 1e+300 is beyond"),
        ("before_LF_KFE", "-1_0", 'column before_LF_KFE: "-1_0" is not a number'),
        ("after_LF_KFE", "1e308", "column after_LF_KFE: 1e+308 is beyond"),
        ("after_LF_KFE", "broken", 'column after_LF_KFE: "broken" is not a number'),
        ("qw", "0", "the base's quaternion (qx, qy, qz, qw) has length"),
        ("friction", "-1", "column friction: -1 is not a valid friction"),
        ("friction", "ice", 'column friction: "ice" is not a number'),
        ("contact", "LF_FOT", 'no contact "LF_FOT"'),
        ("contact", "LF_FOOT+LF_FOOT", 'names "LF_FOOT" twice'),
        ("contact", "*", "means"),
        (
            None,
            None,
            "column qw: nan is not a finite number (as an empty cell, or a row with too few or too "
            "many, is read)",
        ),
    ],
)
def test_a_row_that_is_wrong_has_a_message(here, column, cell, message):
    """Whichever row it is, the other rows are as without it, and no file is refused.

    A row may also be cut off.
    """
    columns = {"contact": np.array(["LF_FOOT"] * 6)} | table() | {"friction": np.full(6, 0.5)}
    columns |= {"after_LF_KFE": columns["before_LF_KFE"] + 1.0}
    quantities = ("delta_v@imu_link", "delta_qd_friction@LF_KFE")
    whole = compute(study(columns, quantities=quantities))
    cells = {name: [str(x) for x in values.tolist()] for name, values in columns.items()}
    for wrong in (0, 3):
        rows = [list(row) for row in zip(*cells.values(), strict=True)]
        if column is None:
            del rows[wrong][5:]
        else:
            rows[wrong][list(cells).index(column)] = cell
        (here / "log.csv").write_text("\n".join(",".join(row) for row in [list(cells), *rows]))
        results = compute(study(read_table(here / "log.csv"), quantities=quantities))
        assert list(results.messages) == [wrong]
        assert message in results.messages[wrong]
        for name in [column.name for column in whole.computed]:
            assert np.isnan(results.columns[name][wrong])
            np.testing.assert_allclose(
                np.delete(results.columns[name], wrong),
                np.delete(whole.columns[name], wrong),
                rtol=1e-12,
            )


def test_what_looks_like_degrees_by_limits_is_a_warning(here, capfd):
    """Outside of limits in radians and inside of them in degrees; zeros for both limits are none,
    and rates have none.
    """
    joint = (
        '<joint name="{0}" type="{1}"><parent link="trunk"/><child link="{0}"/><axis xyz="0 1 '
        '0"/>{2}</joint>'
    )
    link = (
        '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link>'
    )
    legs = {
        "limited": ("revolute", '<limit lower="-1" upper="1" effort="1" velocity="1"/>'),
        "zeros": ("revolute", '<limit effort="1" velocity="1"/>'),
        "turning": ("continuous", ""),
    }
    text = "".join(map(link.format, ("trunk", *legs))) + "".join(
        joint.format(name, *leg) for name, leg in legs.items()
    )
    (here / "legs.urdf").write_text(f'<robot name="legs">{text}</robot>')
    columns = {name: np.array([1.036, 40.0]) for name in legs} | {
        "before_limited": np.array([500.0, 1.0])
    }
    written(here / "log.csv", columns | {"pitch": np.array([0.1, 15.0])})
    outcome = run(
        capfd,
        "recorded",
        here / "log.csv",
        here / "legs.urdf",
        "--contact",
        "limited",
        "--format",
        "json",
        "--out",
        "out",
    )
    assert outcome.code == 0
    assert [row["message"] for row in json.loads(outcome.out)["tables"]["landings"]] == [None, None]
    warnings = [
        line
        for line in (here / "out" / "report.md").read_text().splitlines()
        if "looks like degrees" in line
    ]
    assert len(warnings) == 2
    assert says(warnings[0], "limited", "40 in row 1", "degrees", "-1 and 1 rad")
    assert "column pitch: 15 in row 1" in warnings[1]


@pytest.mark.parametrize("stamp", ["time", "t"])
def test_a_time_series_is_no_table_of_landings(here, capfd, stamp):
    """A jump sampled at 500 Hz is refused as one, however short; its rows in another order, with
    names, or landings of a gait are not, nor short ones with contacts or what was measured after.
    """
    time = np.arange(0.0, 0.6, 0.002)
    rng = np.random.default_rng(2)
    series = {stamp: time, "z": 0.5 + 1.5 * time - 4.9 * time**2, "vz": np.full(len(time), -1.0)}
    series |= {
        name: 0.1 * k + 0.3 * np.sin(12.0 * time + k) + 1e-4 * rng.standard_normal(len(time))
        for k, name in enumerate(JOINTS)
    }
    landing, mixed = resolve(SCENE, known_robot("anymal_b")), rng.permutation(len(time))
    for columns in (
        series,
        {**series, "force": series["z"]},
        {**series, "vz": np.where(time > 0.02, -1.0, np.nan)},
    ):
        with pytest.raises(StudyError, match=r"300 rows.*touchdowns"):
            rows_of(columns, landing)
    gait = {name: 0.4 + 0.02 * rng.standard_normal(300) for name in JOINTS} | {
        stamp: 0.5 * np.arange(300)
    }
    shuffled = {name: values[mixed] for name, values in series.items()}
    untimed = {name: series[name] for name in JOINTS}
    named = series | {"name": np.array([f"sample {i}" for i in range(len(time))])}
    for columns in (gait, shuffled, untimed, named):
        assert len(rows_of(columns, landing).names) == 300
    for rows in (3, 60):
        short = {name: values[:rows] for name, values in series.items()}
        with pytest.raises(StudyError, match=rf"{rows} rows.*touchdowns"):
            rows_of(short, landing)
        touched = short | {"contact": np.array(["LF_FOOT"] * rows)}
        measured = short | {"after_vz": np.zeros(rows)}
        slower = short | {stamp: 0.1 * np.arange(rows)}
        for columns in (touched, measured, slower):
            assert len(rows_of(columns, landing).names) == rows
    written(here / "log.csv", series)
    outcome = run(capfd, "recorded", here / "log.csv", "anymal_b", "--contact", "LF_FOOT")
    assert outcome.code == 2
    assert "shockpc touchdowns LOG ROBOT" in outcome.err


def test_columns_by_other_names():
    """A joint is renamed in all of its columns; what gets no name is left out; a name that fits no
    column is refused.
    """
    landing, columns = resolve(SCENE, known_robot("anymal_b")), table()
    other = {name.replace("LF_", "front left "): values for name, values in columns.items()} | {
        "battery": np.ones(6)
    }
    renamed = rows_of(other, landing, {"front left *": "LF_*", "battery": ""})
    np.testing.assert_array_equal(renamed.Q, rows_of(columns, landing).Q)
    with pytest.raises(StudyError, match='no column for "tail"'):
        rows_of(columns, landing, {"tail": "LF_KFE"})


def test_rows_with_contacts_of_their_own():
    """Rows of different contacts are computed as these; a row that leaves the ground has a message
    instead of numbers.
    """
    columns = table() | {"contact": np.array(["LF_FOOT", "RH_FOOT", "LF_FOOT+RH_FOOT"] * 2)}
    columns["vz"] = np.where(np.arange(6) == 4, 3.0, columns["vz"])
    found = compute(study(columns, quantities=("shock@imu_link", "impulse")))
    assert list(found.messages) == [4]
    assert "does not approach the ground" in found.messages[4]
    assert np.isnan(found.columns["shock@imu_link"][4])
    for i in (1, 2):
        profile = found.study.profile(i)
        assert [contact.frame for contact in profile.contacts] == str(columns["contact"][i]).split(
            "+"
        )
        assert found.columns["shock@imu_link"][i] == pytest.approx(
            profile.value("shock", "point")[0], rel=1e-9
        )
    assert np.isnan(found.columns["impulse@contact 2"]).tolist() == [True, True, False] * 2


def test_loops_are_closed_by_the_least_change():
    """What a measuring error opens is closed, and by how much is a column; what no measuring error
    opens is refused.
    """
    scene = replace(read_scene(FIVE_BAR), assemble=("*",))
    robot = load_robot(scene.robot)
    q, names = resolve(scene, robot).q, robot.joint_names
    exact = {name: np.full(3, robot.joint(name).value(q)) for name in names}
    rates = {f"before_{name}": np.zeros(3) for name in names}
    noisy = exact | rates | {"front_knee": exact["front_knee"] + [0.0, 0.01, 0.8]}
    found = compute(study(noisy, scene, ("shock_com@body",), robot))
    by = found.columns[CLOSED_BY]
    assert by[0] < 1e-9
    assert 1e-3 < by[1] < 0.01
    assert list(found.messages) == [2]
    assert "the loops are open" in found.messages[2]
    given = {name: values for name, values in (exact | rates).items() if not name.endswith("knee")}
    followed = compute(study(given, scene, ("shock_com@body",), robot))
    assert followed.columns["shock_com@body"] == pytest.approx(
        np.full(3, found.columns["shock_com@body"][0]), rel=1e-9
    )


def test_a_scene_holds_a_row_with_loops():
    """Of Cassie's rods, on ball joints, the table gives neither positions nor rates; the scene has
    the numbers of its row.
    """
    folder = Path(__file__).parents[3] / "robots" / "measured"
    scene, columns = read_scene(folder / "cassie.toml"), read_table(folder / "cassie_landings.csv")
    landing = landing_of(scene, known_robot(scene.robot))
    rows = rows_of(
        {name: x[:1] for name, x in columns.items()},
        landing,
        {"second_foot_later_ms": "", "ankle_spring_joint_*": ""},
    )
    made = recorded_landings(rows, landing.robot, prove=0)
    row, alone = made.landings.profile(0), shock_profile(made.landings.case(0), landing.robot)
    np.testing.assert_allclose(alone.q, row.q, atol=1e-12)
    np.testing.assert_allclose(
        alone.landing.before.joint_rates, row.landing.before.joint_rates, atol=1e-10
    )
    np.testing.assert_allclose(alone.shock_com, row.shock_com, rtol=1e-10)


def test_motions_of_many_postures_are_those_of_each():
    """Kinetic energy and velocities before the impact with a motion for every posture."""
    columns = table()
    made = study(columns, quantities=("energy_lost", "total_impulse.z", "approach@LF_FOOT"))
    found = compute(made)
    for i in range(6):
        profile = made.landings.profile(i)
        assert found.columns[made.computed[0].name][i] == pytest.approx(
            profile.value("energy_lost", "robot"), rel=1e-9
        )
        assert found.columns["approach@LF_FOOT"][i] == pytest.approx(
            np.linalg.norm(profile.contacts[0].approach), rel=1e-12
        )
    assert isinstance(made.landings.table.before, Motion)


def equal_to_single_landings(results, robot):
    """Whether all rows have the numbers that their scenes have with a proof."""
    for i in sorted(set(range(results.study.rows)) - results.messages.keys()):
        profile = shock_profile(results.study.case(i), robot)
        for column in results.computed:
            place = column.at(profile.landing)
            value = np.nan if place is None else profile.numbers(column.selection, [place])[0]
            assert results.columns[column.name][i] == pytest.approx(
                value, rel=1e-9, abs=1e-12, nan_ok=True
            )


def test_velocities_of_contacts_are_those_of_the_scene():
    """vx@FRAME … is the velocity of that contact, whatever the robot's motion; the others move with
    the robot.
    """
    robot, rng = known_robot("anymal_b"), np.random.default_rng(3)
    given = {f"v{axis}@LF_FOOT": rng.normal(-1.0 if axis == "z" else 0.0, 0.1, 6) for axis in "xyz"}
    feet = np.array(["LF_FOOT", "RH_FOOT", "LF_FOOT+RH_FOOT"] * 2)
    given["vx@LF_FOOT"][1] = np.nan  # a row in which that contact does not strike
    results = compute(
        study(
            table() | given | {"contact": feet},
            quantities=("shock@imu_link", "delta_v@imu_link", "approach"),
        )
    )
    equal_to_single_landings(results, robot)
    velocities = [contact.velocity for i in (0, 1, 2) for contact in results.study.case(i).contact]
    assert velocities == [
        tuple(given[f"v{axis}@LF_FOOT"][0] for axis in "xyz"),
        None,
        (*(given[f"v{a}@LF_FOOT"][2] for a in "xyz"),),
        None,
    ]
    with pytest.raises(StudyError, match=r"row 0: the velocity of contact .* not given in full"):
        study(table() | given | {"vz@LF_FOOT": np.full(6, np.nan)})


def test_a_contact_without_a_velocity_of_its_own_moves_with_the_robot(tmp_path):
    """An empty cell is no velocity, in that row alone; where only some of the components are empty,
    that row is refused.
    """
    given = {f"v{axis}@LF_FOOT": np.full(6, -1.0) for axis in "xyz"}
    cells = {name: [str(x) for x in values.tolist()] for name, values in (table() | given).items()}
    for name in given:
        cells[name][1] = ""
    cells["vz@LF_FOOT"][4] = ""
    lines = [",".join(cells), *(",".join(row) for row in zip(*cells.values(), strict=True))]
    (tmp_path / "log.csv").write_text("\n".join(lines))
    quantities = ("delta_v@imu_link", "approach.x")
    results = compute(study(read_table(tmp_path / "log.csv"), quantities=quantities))
    assert {row: "not given in full" in text for row, text in results.messages.items()} == {4: True}
    without, whole = (
        compute(study(columns, quantities=quantities)) for columns in (table(), table() | given)
    )
    expected = {
        name: np.where(np.arange(6) == 1, without.columns[name], whole.columns[name])
        for name in without.columns
    }
    for name in [column.name for column in without.computed]:
        np.testing.assert_allclose(
            np.delete(results.columns[name], 4), np.delete(expected[name], 4), rtol=1e-12
        )


def test_missing_values_of_parquet_are_empty_and_lists_are_rows(tmp_path):
    columns = {
        "contact": ["LF_FOOT", None, "RH_FOOT"],
        "vx@LF_FOOT": [0.5, None, None],
        "qpos": [[1.0, 2.0]] * 3,
    }
    pyarrow.parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
    columns = read_table(tmp_path / "log.parquet")
    assert columns["contact"].tolist() == ["LF_FOOT", "", "RH_FOOT"]
    assert np.isnan(columns["vx@LF_FOOT"]).tolist() == [False, True, True]
    assert columns["qpos"].shape == (3, 2)


def test_the_order_of_contacts_in_a_row_means_nothing():
    """Rows of the same contacts are of one landing, whose columns have the contacts' names."""
    rows = {name: values[[0, 0]] for name, values in table().items()} | {
        "contact": np.array(["RH_FOOT+LF_FOOT", "LF_FOOT+RH_FOOT"])
    }
    results = compute(study(rows, quantities=("impulse.z",)))
    assert len(results.study.table.scenes) == 1
    for foot in ("LF_FOOT", "RH_FOOT"):
        one, other = results.columns[f"impulse.z@{foot}"]
        assert one == other > 0.0


def test_contacts_of_a_table_keep_what_the_scene_says_of_them(here, capfd):
    """The restitution of a scene's contact holds for the rows; a row without a contact has that of
    the scene.
    """
    (here / "scene.toml").write_text(
        'robot = "anymal_b"\n[[contact]]\nframe = "RF_FOOT"\nrestitution = 0.5\n'
    )
    written(here / "log.csv", {"vz": np.array([-1.0, -1.0]), "contact": np.array(["LF_FOOT", ""])})
    words = ("--quantity", "delta_v@imu_link", "--format", "json")
    rows = json.loads(good(capfd, "recorded", "log.csv", "scene.toml", *words))["tables"][
        "landings"
    ]
    for row, foot in zip(rows, ("LF_FOOT", "RF_FOOT"), strict=True):
        analysis = (
            "analyze",
            "anymal_b",
            "--contact",
            foot,
            "--restitution",
            0.5,
            "--velocity=0,0,-1",
            "--format",
            "json",
        )
        (point,) = [
            point
            for point in json.loads(good(capfd, *analysis))["tables"]["points"]
            if point["point"] == "imu_link"
        ]
        assert row["delta_v@imu_link"] == pytest.approx(
            np.linalg.norm(vector(point, "delta_v")), rel=1e-12
        )


@pytest.mark.parametrize("bad", ["LF_FOT", "*_FOOT", "", " "])
def test_a_first_row_without_a_valid_contact_is_a_message_of_that_row(here, capfd, bad):
    """Also without a contact of the scene, where one of the rows stands for it; the others are as
    with it.
    """
    written(
        here / "log.csv", {"vz": np.full(3, -1.0), "contact": np.array([bad, "LF_FOOT", "RF_FOOT"])}
    )
    (here / "scene.toml").write_text('robot = "anymal_b"\ncontact = "LH_FOOT"\n')
    words = ("--quantity", "delta_v@imu_link", "--format", "json")
    rows, others = (
        json.loads(run(capfd, "recorded", "log.csv", scene, *words).out)["tables"]["landings"]
        for scene in ("anymal_b", "scene.toml")
    )
    assert (rows[0]["delta_v@imu_link"], rows[1:]) == (None, others[1:])
    assert "contact" in rows[0]["message"]
    written(here / "log.csv", {"vz": np.full(1, -1.0), "contact": np.array([bad or "a"])})
    assert run(capfd, "recorded", "log.csv", "anymal_b").code == 2


def test_friction_of_each_row():
    """The quantities with friction, and whether the ground allows the landing, are those of a scene
    with the row's.
    """
    friction = {"friction": np.array([0.05, 0.4, 0.8, 0.05, 0.4, 0.0])}
    results = compute(
        study(
            table() | friction,
            quantities=("delta_v_friction@imu_link", "feasible", "friction_needed"),
        )
    )
    equal_to_single_landings(results, known_robot("anymal_b"))
    assert [results.study.case(i).friction for i in range(6)] == friction["friction"].tolist()


def test_what_the_ground_allows_depends_on_the_friction_of_the_row_however_it_is_named():
    """KEY and KIND.KEY mean one quantity: rows that gain energy are refused under both names."""
    scene = replace(SCENE, contact=(Contact(frame="LF_FOOT", restitution=0.9),))
    columns = table(12) | {"vx": np.linspace(-2.0, 2.0, 12), "friction": np.full(12, 0.8)}
    by_key, by_kind = (
        compute(study(columns, scene, (name,))) for name in ("feasible", "robot.feasible")
    )
    assert by_key.messages == by_kind.messages != {}
    np.testing.assert_array_equal(by_kind.table.feasible, by_key.table.feasible)


def test_rows_that_gain_energy_with_friction_are_refused():
    """Slip that reverses with a high restitution: the rows and the single analyses refuse the same
    landings.
    """
    scene = replace(SCENE, contact=(Contact(frame="LF_FOOT", restitution=0.9),), friction=0.8)
    results = compute(study(table(12) | {"vx": np.linspace(-2.0, 2.0, 12)}, scene, ("feasible",)))
    refused = {}
    for row in range(12):
        try:
            results.study.profile(row)
        except SolveError as refusal:
            refused[row] = str(refusal)
    assert refused == results.messages
    assert 0 < len(refused) < 12


def test_contacts_of_rows_are_like_those_of_the_scene():
    """A contact that a row names has the restitution and the offset of the scene's."""
    contact = Contact(frame="LF_FOOT", restitution=0.4, offset=(0.0, 0.0, -0.02))
    columns = table() | {"contact": np.array(["LF_FOOT", "RH_FOOT"] * 3)}
    cases = study(columns, replace(SCENE, contact=(contact,)))
    definite = replace(contact, at="frame", kind="point")
    assert [cases.landings.case(i).contact for i in (0, 1)] == [
        (definite,),
        (replace(definite, frame="RH_FOOT"),),
    ]


# Measured against predicted


def measured(columns, robot, noise=0.0):
    """A table with the jumps that the model predicts, and noise."""
    made = study(columns, SCENE, ("delta_qd", "delta_v@imu_link"), robot)
    found, rng = compute(made), np.random.default_rng(5)
    after = {
        f"after_{name}": columns[f"before_{name}"] + found.columns[f"delta_qd@{name}"]
        for name in JOINTS
    }
    noisy = {
        name: values + noise * rng.standard_normal(len(values)) for name, values in after.items()
    }
    return columns | noisy | {"after_delta_v@imu_link": found.columns["delta_v@imu_link"]}


def test_a_perfect_prediction():
    """Correlation, slope and skill are 1, the error 0; of the joints together, of each, and of a
    quantity at a point.
    """
    robot = known_robot("anymal_b")
    comparison = compare_measured(measured(table(12), robot), {"free": SCENE}, robot)
    assert {one.name for one in comparison.agreements} == {
        "joint rates",
        *JOINTS,
        "delta_v@imu_link",
    }
    for one in comparison.agreements:
        for key in STATISTICS:
            expected = (
                np.nan
                if key == "error (energy)" and "@" in one.name
                else float(not key.startswith("error"))
            )
            assert one.statistics[key] == pytest.approx((expected,) * 3, abs=1e-8, nan_ok=True)


def test_statistics_of_a_noisy_measurement():
    """Against NumPy's correlation and line, and a leave-one-out mean written as a loop."""
    robot = known_robot("anymal_b")
    columns = measured(table(12), robot, 0.3)
    one = compare_measured(columns, {"free": SCENE}, robot).agreements[0]
    p, m = one.predicted, one.measured
    np.testing.assert_allclose(
        m, np.stack([columns[f"after_{j}"] - columns[f"before_{j}"] for j in JOINTS], axis=1)
    )
    values = {key: one.statistics[key][0] for key in STATISTICS}
    assert values["r"] == pytest.approx(np.corrcoef(p.ravel(), m.ravel())[0, 1])
    assert values["slope"] == pytest.approx(np.polyfit(p.ravel(), m.ravel(), 1)[0])
    assert values["error"] == pytest.approx(
        np.median(np.linalg.norm(p - m, axis=1) / np.linalg.norm(m, axis=1))
    )
    assert values["skill"] == pytest.approx(1.0 - np.sum((p - m) ** 2) / np.sum(m**2))
    mean = np.stack([np.delete(m, i, axis=0).mean(axis=0) for i in range(12)])
    assert values["skill (mean)"] == pytest.approx(
        1.0 - np.sum((p - m) ** 2) / np.sum((m - mean) ** 2)
    )
    assert one.statistics["r"][1] < values["r"] < one.statistics["r"][2]


def test_rows_with_contacts_of_their_own_need_none_of_the_scene():
    """The same as with the scene's contact given; a row without a contact is no landing, and has
    not that of another row.
    """
    columns = table(3) | {
        "contact": np.array(["RF_FOOT", "LF_FOOT+RF_FOOT", ""]),
        "name": np.array(["a", "b", "c"]),
    }
    bare, robot = Scene(robot="anymal_b"), known_robot("anymal_b")
    found = recorded.recorded(columns, bare).table
    filled = columns | {"contact": np.array(["RF_FOOT", "LF_FOOT+RF_FOOT", "LF_FOOT"])}
    given = recorded.recorded(filled, SCENE, robot=robot).table
    np.testing.assert_allclose(
        found.values("shock@imu_link")[:2], given.values("shock@imu_link")[:2], rtol=1e-12
    )
    assert list(found.messages) == [2]
    assert found.to_pandas()[["name", "contact"]][:2].values.tolist() == [
        ["a", "RF_FOOT"],
        ["b", "LF_FOOT+RF_FOOT"],
    ]
    after = filled | {f"after_{name}": columns[f"before_{name}"] + 0.1 for name in JOINTS}
    assert compare_measured(after, {"free": bare}, robot).agreements[0].n == 3


def test_statistics_of_few_landings_say_of_how_many():
    """Nine of twelve are predicted: too few for a correlation and for intervals."""
    robot = known_robot("anymal_b")
    columns = measured(table(12), robot, 0.3)
    # these move away from the ground
    columns["vz"] = np.where(np.arange(12) < 3, 1.0, columns["vz"])
    comparison = compare_measured(columns, {"free": SCENE}, robot)
    assert len(comparison.failures) == 3
    for one in comparison.agreements:
        assert one.n == 9
        assert np.isnan(one.statistics["r"]).all()
        assert np.isnan([interval for _, *interval in one.statistics.values()]).all()
        assert np.isfinite(one.statistics["error"][0])
    assert {row[4] for row in agreement_sheet(comparison, full=True).rows} == {9}


def test_equal_measured_jumps_have_no_correlation():
    """0.1 is no sum of powers of 2, so that means of it deviate from it by rounding."""
    robot = known_robot("anymal_b")
    columns = table(10)
    columns |= {f"after_{name}": columns[f"before_{name}"] * 0.0 + 0.1 for name in JOINTS[:1]}
    columns |= {f"before_{name}": columns[f"before_{name}"] * 0.0 for name in JOINTS[:1]}
    one = compare_measured(columns, {"free": SCENE}, robot).agreements[0]
    assert np.ptp(one.measured) == 0.0
    assert np.isnan([one.statistics["r"], one.statistics["skill (mean)"]]).all()
    assert np.isfinite([one.statistics["error"], one.statistics["skill"]]).all()


def test_copies_of_a_landing_in_a_draw_do_not_foretell_it():
    """The interval of the skill against the mean of the other landings: drawn again, those without
    the landing itself by a loop.
    """
    robot, n = known_robot("anymal_b"), 10
    one = compare_measured(measured(table(n), robot, 0.3), {"free": SCENE}, robot).agreements[0]
    p, m = one.predicted, one.measured
    skills = []
    for draw in np.random.default_rng(SEED).integers(n, size=(DRAWS, n)):
        means = (
            np.stack([m[draw[draw != i]].mean(axis=0) for i in draw])
            if len(set(draw.tolist())) > 1
            else np.nan
        )
        skills.append(1.0 - np.sum((p - m)[draw] ** 2) / np.sum((m[draw] - means) ** 2))
    assert one.statistics["skill (mean)"][1:] == pytest.approx(
        np.nanpercentile(skills, (2.5, 97.5)).tolist(), rel=1e-9
    )


def test_a_cell_that_is_empty_was_not_measured(tmp_path):
    """The statistics are those of the cells that are there, written as loops; a landing without any
    is left out of them.
    """
    robot, lost = (
        known_robot("anymal_b"),
        [(0, "LF_HAA"), (3, "RH_KFE"), (3, "LF_KFE"), *((5, name) for name in JOINTS)],
    )
    columns = measured(table(12), robot, 0.3)
    cells = {name: [str(x) for x in values.tolist()] for name, values in columns.items()}
    for (row, name), empty in zip(lost, ("", "nan", " ", "", "NaN", "", "n/a"), strict=True):
        cells[f"after_{name}"][row] = empty
    lines = [",".join(cells), *(",".join(row) for row in zip(*cells.values(), strict=True))]
    (tmp_path / "log.csv").write_text("\n".join(lines))
    comparison = compare_measured(read_table(tmp_path / "log.csv"), {"free": SCENE}, robot)
    assert not comparison.failures
    one, p = (
        comparison.agreements[0],
        compare_measured(columns, {"free": SCENE}, robot).agreements[0].predicted,
    )
    assert {(i, JOINTS[k]) for i, k in np.argwhere(np.isnan(one.measured)).tolist()} == set(lost)
    m, known = one.measured, np.isfinite(one.measured)
    values = {key: statistic[0] for key, statistic in one.statistics.items()}
    assert values["r"] == pytest.approx(np.corrcoef(p[known], m[known])[0, 1])
    assert values["slope"] == pytest.approx(np.polyfit(p[known], m[known], 1)[0])
    measured_rows = [i for i in range(12) if known[i].any()]
    errors = [
        np.linalg.norm((p - m)[i, known[i]]) / np.linalg.norm(m[i, known[i]]) for i in measured_rows
    ]
    assert values["error"] == pytest.approx(np.median(errors))
    assert values["skill"] == pytest.approx(
        1.0 - np.sum((p - m)[known] ** 2) / np.sum(m[known] ** 2)
    )
    others = [m[i, k] - np.nanmean(np.delete(m[:, k], i)) for i, k in np.argwhere(known)]
    assert values["skill (mean)"] == pytest.approx(
        1.0 - np.sum((p - m)[known] ** 2) / np.sum(np.square(others))
    )


def test_the_error_in_the_energy_norm():
    """√(2 T) of the differences, by Pinocchio's kinetic energy; without the base's velocities that
    of no momentum of the whole.
    """
    robot, rng, n = known_robot("anymal_b"), np.random.default_rng(4), 5
    names = [joint.name for joint in robot.single_joints[1:]]
    columns = table(n) | {"vy": np.zeros(n)} | {f"before_{name}": np.zeros(n) for name in names}
    base = ("vx", "vy", "vz", "wx", "wy", "wz")
    joints = {f"after_{name}": rng.standard_normal(n) for name in names}
    whole = {f"after_{key}": columns[key] + rng.standard_normal(n) for key in base}
    found = {}
    for after in (joints | whole, joints, {"after_vz": whole["after_vz"]}):
        comparison = compare_measured(columns | after, {"free": SCENE}, robot)
        found |= {(one.name, len(after)): one for one in comparison.agreements}
    assert ("all velocities", len(joints)) not in found
    assert [
        key for key, x in found["all velocities", 18].statistics.items() if np.isfinite(x[0])
    ] == ["error (energy)"]
    model, data = robot.model, robot.model.createData()
    Q = study(columns).landings.table.Q

    def norms(every, alone):
        """Of all velocities (n, 18) in the order of base and joints, and of the joints with the
        base's best.
        """
        sizes = []
        for q, jumps in zip(Q, every, strict=True):
            R = pin.XYZQUATToSE3(q[:7]).rotation
            v = np.concatenate([R.T @ jumps[:3], R.T @ jumps[3:6], jumps[6:]])
            M = pin.crba(model, data, q)
            if alone:
                M = np.triu(M) + np.triu(M, 1).T
                v[:6] = -np.linalg.solve(M[:6, :6], M[:6, 6:] @ v[6:])
            sizes.append(np.sqrt(2.0 * pin.computeKineticEnergy(model, data, q, v)))
        return np.array(sizes)

    order = [(kind, 18) for kind in ("base velocity", "base angular velocity", "joint rates")]
    p, m = (
        np.concatenate([getattr(found[key], which) for key in order], axis=1)
        for which in ("predicted", "measured")
    )
    for key, alone in (
        (("all velocities", 18), False),
        (("joint rates", 18), True),
        (("joint rates", 12), True),
    ):
        expected = np.median(norms(p - m, alone) / norms(m, alone))
        assert found[key].statistics["error (energy)"][0] == pytest.approx(expected, rel=1e-9)
    single = found["base velocity", 1].statistics
    assert single["error (energy)"] == pytest.approx(single["error"], nan_ok=True)


def test_a_group_of_one_joint_is_shown():
    columns = table() | {"after_LF_KFE": np.linspace(-1.0, 1.0, 6)}
    comparison = compare_measured(columns, {"free": SCENE}, known_robot("anymal_b"))
    assert {row[2:4] for row in agreement_sheet(comparison).rows} == {("joint rates", "rad/s")}


def test_base_velocities_are_compared_in_world_axes():
    """after_vz less vz against the jump of the base's frame, turned to the world."""
    robot, columns = known_robot("anymal_b"), table()
    one = compare_measured(
        columns | {"after_vz": columns["vz"] + 0.5}, {"free": SCENE}, robot
    ).agreements[0]
    made = study(columns)
    for i in range(6):
        profile = made.landings.profile(i)
        jump = profile.landing.state.rotation[0, 0] @ profile.delta_v[0]
        assert one.predicted[i, 0] == pytest.approx(jump[2], rel=1e-9)
    np.testing.assert_allclose(one.measured, 0.5)


@pytest.mark.parametrize(
    "change",
    [
        {"friction": 0.1},
        {"friction": 0.1, "contact": (Contact(frame="LF_FOOT", restitution=0.3),)},
        {"contact": (Contact(frame="LF_FOOT", restitution=0.3),)},
        {"contact": (Contact(frame="LF_FOOT", directions=("x", "z")),)},
        {"stance": ("RH_FOOT",)},
        {"stance": ("RH_FOOT",), "friction": 0.3},
    ],
    ids=[
        "friction",
        "friction and restitution",
        "restitution",
        "directions",
        "stance",
        "stance and friction",
    ],
)
def test_the_prediction_is_of_the_whole_scene(change):
    """Measured are the jumps of each row analyzed alone, with friction where there is one: the
    error is 0, of a plain scene not.
    """
    robot, scene, columns = (
        known_robot("anymal_b"),
        replace(SCENE, **change),
        table() | {"name": np.array(list("abcdef"))},
    )
    made, sliding = study(columns, scene), "_friction" * ("friction" in change)
    after = {
        key: columns.get(key[6:], columns.get(f"before_{key[6:]}", np.zeros(6))).copy()
        for key in ("after_vz", "after_LF_KFE")
    }
    after["after_delta_v.x@imu_link"] = np.zeros(6)
    for i in range(6):
        profile = shock_profile(made.landings.case(i), robot)
        rotation = profile.landing.state.rotation[0, 0]
        after["after_vz"][i] += (rotation @ profile.value(f"delta_v{sliding}", "body")[0])[2]
        joints = [place.name for place in profile.places("joint")]
        after["after_LF_KFE"][i] += profile.value(f"delta_qd{sliding}", "joint")[
            joints.index("LF_KFE")
        ]
        points = [place.name for place in profile.places("point")]
        after["after_delta_v.x@imu_link"][i] = profile.value(f"delta_v{sliding}", "point")[
            points.index("imu_link"), 0
        ]
    comparison = compare_measured(columns | after, {"whole": scene, "plain": SCENE}, robot)
    assert not comparison.failures
    errors = {(one.model, one.name): one.statistics["error"][0] for one in comparison.agreements}
    for name in ("base velocity", "joint rates", "delta_v.x@imu_link"):
        assert errors["whole", name] < 1e-9 < 1e-3 < errors["plain", name]


def test_a_measured_quantity_that_does_not_exist_with_friction_is_refused():
    columns = table() | {"after_shock_max@base": np.ones(6)}
    with pytest.raises(StudyError, match="after_shock_max@base cannot be predicted with friction"):
        compare_measured(columns, {"free": replace(SCENE, friction=0.3)}, known_robot("anymal_b"))


@pytest.mark.parametrize(
    ("model", "joints"), [("free", Joints()), ("locked", Joints(locked=("LF_KFE",)))]
)
def test_finite_stiffness_ends_at_the_impulse(model, joints):
    """Long after contact the velocities are the impulse model's, at first there is no change; a
    locked joint keeps its rate.
    """
    robot, columns = known_robot("anymal_b"), table()
    after = {f"after{ms}ms_{name}": columns[name] for ms in (0.0001, 500) for name in ("vx", "vz")}
    after |= {f"after{ms}ms_LF_KFE": columns["before_LF_KFE"] for ms in (0.0001, 500)}
    stiff = replace(SCENE, contact_stiffness=1e5, gravity=False, joints=joints)
    comparison = compare_measured(columns | after, {model: stiff}, robot)
    found = {(one.model, one.time, one.name): one.predicted for one in comparison.agreements}
    assert not comparison.failures
    for name in ("vx", "vz", "joint rates"):
        impulsive = found[model, 500.0, name]
        np.testing.assert_allclose(
            found[f"{model}, contacts of 100000 N/m", 500.0, name], impulsive, atol=1e-7
        )
        assert (
            np.abs(found[f"{model}, contacts of 100000 N/m", 0.0001, name]).max()
            <= 1e-3 * np.abs(impulsive).max()
        )


def test_efforts_of_a_table_are_torques_of_its_rows():
    """An empty cell is the torque of the scene; the scene of a row has them; without a contact
    stiffness they change nothing.
    """
    robot, columns = known_robot("anymal_b"), table()
    columns |= {"effort_LF_KFE": np.array([0.0, 5.0, -5.0, 5.0, np.nan, 5.0])}
    stiff = replace(
        SCENE, contact_stiffness=1e5, joints=Joints(torque={"LF_KFE": 2.0, "RH_KFE": 3.0})
    )
    peaks = ("peak_joint_moment@LF_KFE", "peak_acceleration@imu_link")
    made = compute(study(columns, stiff, peaks))
    assert not made.messages
    for i, torque in enumerate([0.0, 5.0, -5.0, 5.0, 2.0, 5.0]):
        scene = made.study.case(i)
        assert scene.joints.torque == {"LF_KFE": torque, "RH_KFE": 3.0}
        profile = shock_profile(scene, robot)
        names = [place.name for place in profile.places("joint")]
        peak = profile.value("peak_joint_moment", "joint")[names.index("LF_KFE")]
        assert made.columns[peaks[0]][i] == pytest.approx(peak, rel=1e-9)
    plain = study(columns, SCENE, ("delta_v@imu_link",)).table
    del columns["effort_LF_KFE"]
    same = study(columns, SCENE, ("delta_v@imu_link",)).table
    np.testing.assert_array_equal(
        plain.columns["delta_v@imu_link"], same.columns["delta_v@imu_link"]
    )


def test_velocities_at_a_time_are_columns():
    """Changes of velocity on contacts of finite stiffness, with free fall; of a row that cannot be
    followed the message.
    """
    columns = table()
    made = study(columns, replace(SCENE, contact_stiffness=1e5))
    selection, (place,) = selected(made.landings.first, "delta_v.x@base")
    wanted = tuple(Column(selection, place, time=time) for time in (2.0, 8.0))
    found = replace(made, computed=wanted).table.columns
    for i in range(6):
        motion = CompliantLanding(made.landings.landing(i), 0.008)
        for column in wanted:
            jump = motion.impact_at(column.time / 1e3).strike_jumps[0, 0, 0, 3]
            assert found[f"delta_v.x@base after {column.time:g} ms"][i] == pytest.approx(
                jump, rel=1e-9
            )
    falls = study(columns | {"vz": np.full(6, 1.0)}, replace(SCENE, contact_stiffness=1e5))
    assert len(replace(falls, computed=wanted).table.messages) == 6


def statistics_of(sheet, k):
    """The statistics of a table as the guide shows them, by joint model and what a column says, of
    times in ms.
    """
    found = {}
    for row in sheet.rows:
        texts = found.setdefault((row[0], round(1e3 * row[k], 6) if k == 1 else row[k]), [])
        for value, low, high in zip(row[5::3], row[6::3], row[7::3], strict=True):
            text = "–"
            if not np.isnan(value):
                text = f"{value:.2f}" + ("" if np.isnan(low) else f" ({low:.2f} … {high:.2f})")
            texts.append(text)
    return found


@pytest.mark.slow
def test_measured_landings_of_cassie(monkeypatch):
    """The table of robots/measured is what the benchmark computes; it shows no intervals of single
    joints.
    """
    statistics = recorded._statistics
    none = dict.fromkeys(STATISTICS, (np.nan,) * 3)
    monkeypatch.setattr(
        recorded,
        "_statistics",
        lambda y, x, energy: statistics(y, x, energy) if y.shape[1] > 1 else none,
    )
    text = (Path(__file__).parents[3] / "robots" / "measured" / "README.md").read_text(
        encoding="utf-8"
    )
    lines = re.findall(
        r"^\| (.*springs.*) \| (\d+) ms \| (\S+) \| (\S+) \| (.*) \| (\S+) \| (\S+) \|$",
        text,
        re.MULTILINE,
    )
    sheet = statistics_of(measured_landings(), 1)
    assert len(lines) == 9
    for model, time, *shown in lines:
        found = sheet[model, float(time)][:5]
        assert [cell if k == 2 else cell.split()[0] for k, cell in enumerate(found)] == shown


@pytest.mark.slow
def test_measured_joints_near_the_ground():
    """The errors of Cassie's tarsi just after contact, and the correlation of its trunk, on the
    pages.
    """
    folder = Path(__file__).parents[3] / "robots" / "measured"
    scene, columns = read_scene(folder / "cassie.toml"), read_table(folder / "cassie_landings.csv")
    found = compare_measured(columns, {"geared": scene}, robot_of(scene), IGNORED).agreements
    soon = {one.name: (one.measured, one.predicted) for one in found if one.time == 6.0}
    errors = [
        np.median(np.abs(x - y) / np.abs(y))
        for y, x in (soon[f"ankle_joint_{side}"] for side in ("left", "right"))
    ]
    assert [f"{100.0 * error:.0f}" for error in errors] == ["12", "15"]
    assert f"{np.corrcoef(*map(np.ravel, soon['base velocity']))[0, 1]:.2f}" == "-0.24"
    text = " ".join((folder / "README.md").read_text(encoding="utf-8").split())
    assert "the tarsus (`ankle_joint`) to 12–15 %" in text
    assert "has a correlation of -0.24" in text


@pytest.mark.slow
def test_measured_tosses_of_two_hinged_blocks():
    """The tables of both READMEs are what the benchmark computes; published are 0.40, 0.376, 0.306."""
    root = Path(__file__).parents[3]
    text = (root / "robots" / "measured" / "README.md").read_text(encoding="utf-8")
    lines = re.findall(
        r"^\| (sticks|friction.*?) \| (.*) \| (\S+) \| (\S+) \| (\S+) \|$", text, re.MULTILINE
    )
    sheet = statistics_of(measured_tosses(), 2)
    assert [law for law, *_ in lines] == list(LAWS)
    for law, energy, *hinge in lines:
        assert sheet[law, "all velocities"][3] == energy
        assert [cell.split()[0] for cell in sheet[law, "joint rates"][:3]] == hinge
    shown = re.search(
        r"error in energy (\S+) if the corner sticks.*; (\S+) with friction 0.2, (\S+) with",
        (root / "README.md").read_text("utf-8"),
    )
    errors = [sheet[law, "all velocities"][3].split()[0] for law in LAWS]
    assert list(shown.groups()) == errors
    assert [float(x) for x in errors] == pytest.approx([0.40, 0.376, 0.306], abs=0.01)


def test_measured_steps_of_a_compass_gait_biped():
    """The table of the README is what the benchmark computes; each foot strikes with its own row's
    contact.
    """
    text = (Path(__file__).parents[3] / "robots" / "measured" / "README.md").read_text(
        encoding="utf-8"
    )
    lines = re.findall(r"^\| (30|15) ms \| (\S+) \| (\S+) \| (.*) \| (\S+) \|$", text, re.MULTILINE)
    sheet = statistics_of(measured_steps(), 1)
    assert len(lines) == 2
    for time, r, slope, error, skill in lines:
        found = sheet["free", float(time)]
        assert [found[0].split()[0], found[1].split()[0], found[2], found[4].split()[0]] == [
            r,
            slope,
            error,
            skill,
        ]


def test_legs_of_a_compass_gait_biped():
    """The README's other table: the leg that strikes and the other one, of whichever name, and all
    signs of that after 30 ms.
    """
    folder = Path(__file__).parents[3] / "robots" / "measured"
    columns, file = (
        read_table(folder / "sydney" / "landings.csv"),
        folder / "sydney" / "sydney_compass_gait.urdf",
    )
    foot = Contact(frame="inner_foot", directions=("x", "z"))
    scene = Scene(robot=str(file), base="planar", joints=Joints(model="free"), contact=(foot,))
    found = compare_measured(columns, {"free": scene}, load_robot(str(file))).agreements
    legs = {(one.name, one.time): one for one in found if not one.group}
    inner = columns["contact"] == "inner_foot"
    lines = re.findall(
        r"^\| the (landing leg|other) \| (\d+) ms \| (.*) \|$",
        (folder / "README.md").read_text("utf-8"),
        re.MULTILINE,
    )
    assert len(lines) == 4
    for leg, time, numbers in lines:
        pair = [
            legs[f"{name}_joint", float(time)]
            for name in (("inner", "outer") if leg != "other" else ("outer", "inner"))
        ]
        y, x = (
            np.where(inner, *(getattr(one, of)[:, 0] for one in pair))
            for of in ("measured", "predicted")
        )
        slope, error = np.cov(x, y)[0, 1] / np.var(x, ddof=1), np.median(np.abs(x - y) / np.abs(y))
        assert [
            f"{value:.2f}" for value in (np.corrcoef(x, y)[0, 1], slope, error)
        ] == numbers.split(" | ")
        assert (x * y > 0.0).all() or (leg, time) != ("other", "30")


def test_names_that_are_numbers_keep_their_digits():
    """In a table of numbers 1000001 is not 1e+06; a refusal names the row in the same way."""
    scene, names = Scene(robot="go2", contact="FL_foot"), np.array([1000001.0, 1000002.0, 0.5])
    rows = shockpc.recorded(
        {"name": names, "vz": np.array([-1.0, -2.0, -3.0])}, scene, ["shock@imu"]
    )
    assert rows.landings.table.names.tolist() == ["1000001", "1000002", "0.5"]
    with pytest.raises(StudyError, match='landing "1000001"'):
        shockpc.recorded({"name": names[:1], "vz": np.array([np.nan])}, scene)


# The command


def test_the_command_ranks_and_prints_a_row_as_a_scene(here, capfd):
    """CSV, JSON, Parquet and NPZ hold the same numbers; the scene of the worst row gives them
    again.
    """
    columns = table() | {"name": np.array([f"jump {k}" for k in range(6)])}
    written(here / "log.csv", columns)
    np.savez(here / "log.npz", **columns)
    words = ("anymal_b", "--contact", "LF_FOOT", "--rank", "delta_v@imu_link", "--prove", 0)
    csv_text = run(capfd, "recorded", here / "log.csv", *words, "--format", "csv").out
    assert (
        csv_text
        == run(
            capfd, "recorded", here / "log.npz", *words, "--format", "csv", "--out", here / "out"
        ).out
    )
    rows = list(csv.DictReader(csv_text.splitlines()))
    values = [float(row["delta_v@imu_link [m/s]"]) for row in rows]
    assert values == sorted(values, reverse=True)
    document = json.loads((here / "out" / "recorded.json").read_text())
    assert [row["delta_v@imu_link"] for row in document["tables"]["landings"]] == values
    assert {"recorded.svg", "landings.csv", "report.md"} <= {
        file.name for file in (here / "out").iterdir()
    }
    scene = run(capfd, "recorded", here / "log.csv", *words, "--command", rows[0]["landing"]).out
    (here / "worst.toml").write_text(scene)
    outcome = run(capfd, "analyze", here / "worst.toml", "--format", "json")
    (imu,) = (
        point
        for point in json.loads(outcome.out)["tables"]["points"]
        if point["point"] == "imu_link"
    )
    assert np.linalg.norm(vector(imu, "delta_v")) == pytest.approx(values[0], rel=1e-12)


@pytest.mark.parametrize(
    ("option", "value", "column", "kept"),
    [
        ("--speed", "2", "vz", None),
        ("--drop-height", "0.3", "vz", None),
        ("--strike-angle", "20", "vx", None),
        ("--velocity", "0.3,0.2,-1", "vx", "0,0.2,0"),
        ("--angular-velocity", "0,1,0", "wy", None),
        ("--base-rpy", "0,5,0", "pitch_deg", "3,0,0"),
        ("--set", "LF_KFE=-50", "q_LF_KFE", "*_KFE=-50"),
        ("--joint-velocity", "LF_KFE=1", "before_LF_KFE", "*_KFE=1"),
        ("--friction", "0.4", "mu", None),
        ("--stance", "RH_FOOT", "stance", None),
        ("--torque", "LF_KFE=30", "effort_LF_KFE", "*_KFE=30"),
        ("--contact", "RF_FOOT", "contact", None),
    ],
)
def test_an_option_that_a_column_overrides_is_refused(here, capfd, option, value, column, kept):
    """Without the column it changes the landings, and what the table lacks may be given."""
    columns = table() | {"pitch_deg": np.linspace(-3.0, 3.0, 6), "mu": np.full(6, 0.6)}
    columns = {
        name: values for name, values in columns.items() if name not in ("qw", "qx", "qy", "qz")
    }
    columns |= {"stance": np.array(["RF_FOOT"] * 6)} if option == "--stance" else {}
    columns |= {"contact": np.array(["LF_FOOT"] * 6)} if option == "--contact" else {}
    columns |= {"effort_LF_KFE": np.full(6, 20.0)} if option == "--torque" else {}
    contact = () if option == "--contact" else ("--contact", "LF_FOOT")
    words = (
        "recorded",
        written(here / "log.csv", columns),
        "anymal_b",
        *contact,
        "--prove",
        0,
        "--format",
        "csv",
    )
    words += ("--quantity", "shock_friction@imu_link") if option == "--friction" else ()
    words += (
        ("--quantity", "peak_force", "--contact-stiffness", 1e5, "--map", "mu=")
        if option == "--torque"
        else ()
    )
    refused = run(capfd, *words, option, value)
    assert (refused.code, refused.out) == (2, "")
    assert (
        f'{option}{" " + value.partition("=")[0] if "=" in value else ""} (column "{column}")'
        in refused.err
    )
    rest = [] if option != "--velocity" else ["--map", "vz="]
    changed = run(capfd, *words, option, value, "--map", f"{column}=", *rest)
    assert changed.code == 0
    assert changed.out != good(capfd, *words)
    if kept is not None:
        good(capfd, *words, option, kept)


def test_all_of_the_robot_in_one_column_overrides_options_too(here, capfd):
    np.savez(here / "log.npz", qpos=np.zeros((2, 19)), qvel=np.zeros((2, 18)))
    words = ("recorded", here / "log.npz", "anymal_b", "--contact", "LF_FOOT", "--prove", 0)
    for option, column in (
        ("--set=LF_KFE=-50", "qpos"),
        ("--base-rpy=0,5,0", "qpos"),
        ("--posture=standing", "qpos"),
        ("--speed=2", "qvel"),
    ):
        assert f'(column "{column}")' in run(capfd, *words, option).err


def test_a_folder_of_scenes_is_a_batch(here, capfd):
    """Rows that were written as scenes have the same shock there, and no folder is a table."""
    (here / "scenes").mkdir()
    cases = study(table(), quantities=("shock@imu_link",)).landings
    for i in range(3):
        (here / "scenes" / f"jump {i}.toml").write_text(scene_text(cases.case(i), here / "scenes"))
    files = sorted((here / "scenes").glob("*.toml"))
    found = json.loads(
        good(capfd, "batch", *files, "--quantity", "shock@imu_link", "--format", "json")
    )
    shocks = {row["scene"]: row["shock@imu_link"] for row in found["tables"]["batch"]}
    expected = {
        str(file): cases.profile(i).value("shock", "point")[0] for i, file in enumerate(files)
    }
    assert shocks == pytest.approx(expected, rel=1e-9)
    assert (
        "shockpc batch scenes/*.toml" in run(capfd, "recorded", "scenes", "--command", "jump 0").err
    )
    assert "a table needs a robot" in run(capfd, "recorded", written(here / "log.csv", table())).err


def test_times_are_carried_through_and_the_worst_landings_are_shown(here, capfd):
    """The column of times stands beside the names in every file; report.html has the worst
    landings, the figures name them.
    """
    stamps = np.array([100.25, 101.5, 102.0, 103.0, 104.0, 105.0])
    columns = table() | {"name": np.array([f"jump {k}" for k in range(6)]), "stamp": stamps}
    written(here / "log.csv", measured(columns, known_robot("anymal_b"), 0.1))
    words = ("anymal_b", "--contact", "LF_FOOT", "--prove", 0, "--out", here / "out")
    assert run(capfd, "recorded", here / "log.csv", *words, "--rank", "shock@imu_link").code == 0
    rows = list(
        csv.DictReader((here / "out" / "landings.csv").read_text(encoding="utf-8").splitlines())
    )
    assert {row["landing"]: float(row["time"]) for row in rows} == dict(
        zip(columns["name"].tolist(), stamps.tolist(), strict=True)
    )
    page = (here / "out" / "report.html").read_text(encoding="utf-8")
    assert f">{rows[0]['landing']}</option>" in page
    assert {"recorded.png", "measured.png"} <= {file.name for file in (here / "out").iterdir()}
    assert rows[0]["landing"] in (here / "out" / "recorded.svg").read_text(encoding="utf-8")


def test_measured_cells_that_are_empty_are_left_out_of_figure_and_report(here, capfd):
    columns = table() | {
        "after_LF_KFE": np.array(["", "1.5", "nan", "0.5", "0.1", "-0.4"]),
        "after_RH_KFE": np.array([""] * 6),
    }
    written(here / "log.csv", columns)
    words = ("--contact", "LF_FOOT", "--friction", 0.4, "--prove", 0, "--out", here / "out")
    text = good(capfd, "recorded", here / "log.csv", "anymal_b", *words)
    assert "friction     0.4; measured jumps are compared with the motion with friction\n" in text
    document = json.loads((here / "out" / "recorded.json").read_text())
    found = {one["quantity"]: one["error"] for one in document["tables"]["measured"]}
    assert found["joint rates"] == found["LF_KFE"] > 0.0
    assert found["RH_KFE"] is None
    assert (here / "out" / "measured.svg").exists()


@pytest.mark.slow
def test_rows_in_parts_are_continued(here, capfd):
    """A part that is missing is computed by --resume; another table is refused."""
    written(here / "log.csv", table())
    words = (
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--prove",
        0,
        "--out",
        here / "out",
        "--rows",
        "parquet",
    )
    assert run(capfd, "recorded", here / "log.csv", *words).code == 0
    (part,) = (here / "out" / "rows").iterdir()
    content = part.read_bytes()
    part.unlink()
    assert run(capfd, "recorded", here / "log.csv", *words, "--resume").code == 0
    assert part.read_bytes() == content
    written(here / "log.csv", table(seed=2))
    outcome = run(capfd, "recorded", here / "log.csv", *words, "--resume")
    assert outcome.code == 2
    assert "which differs in table, so it cannot be continued" in outcome.err
    before = {path: path.read_bytes() for path in (here / "out").rglob("*") if path.is_file()}
    outcome = run(capfd, "recorded", here / "log.csv", *words[:-2])
    assert outcome.code == 2
    assert "holds the rows of another run" in outcome.err
    assert {
        path: path.read_bytes() for path in (here / "out").rglob("*") if path.is_file()
    } == before


def test_a_joint_model_that_is_refused_leaves_no_files(here, capfd):
    """Of several joint models one may contradict the options; that is said before the rows are
    written.
    """
    written(here / "log.csv", measured(table(), known_robot("anymal_b"), 0.1))
    words = (
        "--contact",
        "LF_FOOT",
        "--drives",
        "none",
        "--joints",
        "free,geared",
        "--rows",
        "csv",
        "--out",
        here / "out",
    )
    outcome = run(capfd, "recorded", here / "log.csv", "anymal_b", *words)
    assert outcome.code == 2
    assert "geared" in outcome.err
    assert not (here / "out").exists()


@pytest.mark.parametrize("drives", [("--drives", "go1"), ("--armature", "*=0.02")])
def test_joint_models_are_compared_with_the_drives_that_each_of_them_has(here, capfd, drives):
    """Free joints have none, geared ones those given, locked ones do not move: the rows are those
    of each model alone.
    """
    knee = np.linspace(-1.8, -1.2, 12)
    written(
        here / "log.csv",
        {
            "q_FL_calf_joint": knee,
            "before_FL_calf_joint": 0.0 * knee,
            "after_FL_calf_joint": np.cos(9.0 * knee),
            "vz": -1.0 - knee**2,
        },
    )
    models = {"free": ("--drives", "none"), "geared": drives, "locked": ()}

    def predicted(*words):
        outcome = run(
            capfd,
            "recorded",
            here / "log.csv",
            "go2",
            "--contact",
            "FL_foot",
            "--prove",
            0,
            "--format",
            "json",
            *words,
        )
        assert (outcome.code, outcome.err) == (0, "")
        found = json.loads(outcome.out)["tables"]["measured"]
        return {
            one["joint_model"]: [row for row in found if row["joint_model"] == one["joint_model"]]
            for one in found
        }

    together = predicted(*drives, "--joints", ",".join(models))
    assert together == {
        model: predicted(*words, "--joints", model)[model] for model, words in models.items()
    }
    assert together["free"] != together["geared"]


def test_rigid_springs_are_left_out_where_there_are_none(here, capfd):
    """Of several joint models; the first that is left counts for the rows."""
    written(here / "log.csv", measured(table(), known_robot("anymal_b"), 0.1))
    words = (
        "--contact",
        "LF_FOOT",
        "--drives",
        "none",
        "--prove",
        0,
        "--format",
        "json",
        "--joints",
    )
    outcome = run(capfd, "recorded", here / "log.csv", "anymal_b", *words, "rigid,locked,free")
    assert outcome.code == 0
    assert says(outcome.err, "rigid", 'no joint of "anymal"')
    document = json.loads(outcome.out)
    assert list(dict.fromkeys(one["joint_model"] for one in document["tables"]["measured"])) == [
        "locked",
        "free",
    ]
    assert (
        document["tables"]["landings"]
        == json.loads(good(capfd, "recorded", here / "log.csv", "anymal_b", *words, "locked"))[
            "tables"
        ]["landings"]
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("q_LF_KFE,vz\n0.1\n", "row 0 has 1 cells"),
        ("q_LF_KFE,vz\n0.1,fast\n0.1,fast\n", 'row 0, column vz: "fast" is not a number'),
        ("vz,vz\n-1,-1\n", 'two columns "vz"'),
        ("q_LF_KFE,vz\n0.1,-1,3\n", "row 0 has 3 cells, and the header 2"),
        ("q_LF_KFE,friction\n0.1,ice\n", 'row 0, column friction: "ice" is not a number'),
        ("vz\n", "has no rows"),
        ("", "has no rows"),
        (f'vz,note\n-1,"{"x" * 140_000}"\n', "line 2: field larger than field limit (131072)"),
        ('vz,note\n-1,"open\n-2,b\n', "is a quotation mark not closed?"),
        (
            "vz,note\n-1," + "x" * 130_000 + "\n-1," * 3000,
            "takes 1488 MB, and up to 1024 MB are read",
        ),
        (f"vz,qpos_{'9' * 5000}\n-1,0\n", "no joint"),
        (f"vz,after{'9' * 500}ms_LF_KFE\n-1,0\n", "no joint"),
        ("vz\n-1_0\n", 'row 0, column vz: "-1_0" is not a number'),
        ("vz\n-\uff11\n", 'row 0, column vz: "-\uff11" is not a number'),
    ],
)
def test_files_that_are_no_table(here, capfd, text, message):
    (here / "log.csv").write_text(text)
    outcome = run(capfd, "recorded", here / "log.csv", "anymal_b", "--contact", "LF_FOOT")
    assert outcome.code == 2
    assert message in outcome.err


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"LF_KFE": np.array([1j, 2.0])}, "LF_KFE is complex128 of shape (2,)"),
        ({"LF_KFE": np.float64(1.0)}, "LF_KFE is float64 of shape ()"),
        ({"LF_KFE": np.zeros(2, dtype="datetime64[s]")}, "column LF_KFE has to hold numbers"),
        (
            {"name": np.array(["LF_KFE", "LF_HFE"]), "position": np.zeros((3, 1))},
            "position has shape (3, 1), and name has 2 joints",
        ),
        ({"contact": np.array([b"LF_FOOT", b"\xff"])}, "cannot be read: 'utf-8' codec"),
        ({"vz": np.array(["-1_0"])}, 'row 0, column vz: "-1_0" is not a number'),
        ({"vz": np.array(["-\u0661"])}, 'row 0, column vz: "-\u0661" is not a number'),
        ({"vz": np.zeros((2**24 + 1, 0))}, "has 1.68e+07 rows"),
        (None, "cannot be read"),
    ],
)
def test_arrays_that_are_no_table(here, capfd, arrays, message):
    """Numbers that would lose a part, and a file that is no archive."""
    if arrays is None:
        (here / "log.npz").write_bytes(b"PK\x03\x04 not an archive")
    else:
        np.savez(here / "log.npz", **arrays)
    outcome = run(capfd, "recorded", here / "log.npz", "anymal_b", "--contact", "LF_FOOT")
    assert outcome.code == 2
    assert message in outcome.err


@pytest.mark.parametrize(("place", "bits"), [(6, 1), (8, 40), (60, 255)])
def test_an_archive_that_is_damaged(tmp_path, place, bits):
    """It says that it is encrypted, or packed in an unknown way; or its packed bytes are others."""
    np.savez_compressed(tmp_path / "log.npz", LF_KFE=np.linspace(0.0, 1.0, 50))
    data = bytearray((tmp_path / "log.npz").read_bytes())
    for start in {data.find(b"PK\x03\x04"), data.find(b"PK\x01\x02") + 2} if place < 60 else {0}:
        data[start + place] ^= bits
    (tmp_path / "log.npz").write_bytes(data)
    with pytest.raises(StudyError, match="cannot be read"):
        read_table(tmp_path / "log.npz")


def archive_of(path, packing=zipfile.ZIP_STORED, **members):
    """An archive with these bytes as members."""
    with zipfile.ZipFile(path, "w", packing) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)


def header_of(shape, descr="<f8"):
    """The header of an array in NumPy's format."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        file, {"descr": descr, "fortran_order": False, "shape": shape}
    )
    return file.getvalue()


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"vz": b"hello"}, 'its member "vz" is no array'),
        ({"vz": header_of((10**10,)) + bytes(80)}, 'its member "vz" is no array'),
        ({"vz": header_of((10**6,)) + bytes(80)}, 'its member "vz" is no array'),
        ({"vz": header_of((-1,))}, 'its member "vz" is no array'),
        ({"vz": header_of((10**9,), "|V0")}, "it has 1e+09 rows"),
        ({"vz": header_of((1,), "|O") + bytes(8)}, 'its member "vz" is no array'),
        ({"vz": header_of((1,)).replace(b"(1,)", b"[[[[")}, 'its member "vz" is no array'),
    ],
)
def test_members_that_are_no_arrays(tmp_path, members, message):
    """Whatever a header says of its array, what is not there, or no array of numbers or texts, is a
    message.
    """
    archive_of(tmp_path / "log.npz", **members)
    with pytest.raises(StudyError, match=re.escape(message)):
        read_table(tmp_path / "log.npz")


def test_a_member_that_is_packed_wrongly(tmp_path):
    archive_of(tmp_path / "log.npz", zipfile.ZIP_LZMA, vz=header_of((1000,)) + bytes(8000))
    data = bytearray((tmp_path / "log.npz").read_bytes())
    data[50:70] = bytes(255 - byte for byte in data[50:70])
    (tmp_path / "log.npz").write_bytes(data)
    with pytest.raises(StudyError, match="cannot be read"):
        read_table(tmp_path / "log.npz")


def test_an_archive_that_expands_is_refused_by_its_directory(tmp_path, monkeypatch):
    """A thousand times its size, of which nothing is unpacked."""
    monkeypatch.setattr(files, "LARGEST_TABLE", 2**24)
    archive_of(tmp_path / "log.npz", zipfile.ZIP_DEFLATED, vz=bytes(2**25))
    assert (tmp_path / "log.npz").stat().st_size < 2**16
    monkeypatch.setattr(zipfile.ZipFile, "read", None)
    with pytest.raises(StudyError, match="it takes 32 MB, and up to 16 MB are read"):
        read_table(tmp_path / "log.npz")


def test_a_parquet_file_that_expands_is_refused_by_its_header(tmp_path, monkeypatch):
    """Two million values in a few kilobytes, and 50 MB of texts that are one text."""
    monkeypatch.setattr(files, "LARGEST_TABLE", 2**23)
    pyarrow.parquet.write_table(
        pyarrow.table({"c": pyarrow.nulls(2**21, pyarrow.float64())}), tmp_path / "log.parquet"
    )
    same = pyarrow.array(["x" * 10_000]).dictionary_encode().take(pyarrow.array([0] * 5000))
    pyarrow.parquet.write_table(
        pyarrow.table({"note": same}), tmp_path / "texts.parquet", store_schema=False
    )
    assert (tmp_path / "log.parquet").stat().st_size < 2**16
    with pytest.raises(StudyError, match="it takes 191 MB, and up to 8 MB are read"):
        read_table(tmp_path / "texts.parquet")
    monkeypatch.setattr(pyarrow.parquet.ParquetFile, "read", None)
    with pytest.raises(StudyError, match="it takes 16 MB, and up to 8 MB are read"):
        read_table(tmp_path / "log.parquet")


@pytest.mark.parametrize("index", [2, 7, -1])
def test_an_index_beyond_a_dictionary_of_parquet_is_refused(monkeypatch, tmp_path, index):
    """A damaged file; an index of exactly the size of the dictionary must not be taken for a
    missing value.
    """
    wrong = pyarrow.DictionaryArray.from_arrays(
        pyarrow.array([0, index], pyarrow.int32()), ["a", "b"], safe=False
    )
    pyarrow.parquet.write_table(pyarrow.table({"note": ["a", "b"]}), tmp_path / "log.parquet")
    batches = pyarrow.table({"note": wrong}).to_batches()
    monkeypatch.setattr(pyarrow.parquet.ParquetFile, "iter_batches", lambda _: batches)
    monkeypatch.setattr(pyarrow.parquet.ParquetFile, "schema_arrow", batches[0].schema)
    with pytest.raises(StudyError, match="cannot be read: Dictionary indices invalid"):
        read_table(tmp_path / "log.parquet")


def test_missing_texts_of_parquet_are_empty(tmp_path):
    """The conversion of a dictionary by pyarrow gives the first of its texts for a missing one."""
    texts = pyarrow.array(["a", None, "b", "a"])
    for kept in (True, False):
        columns = {
            "plain": texts,
            "coded": texts.dictionary_encode(),
            "number": pyarrow.array([1.5, None] * 2).dictionary_encode(),
        }
        pyarrow.parquet.write_table(
            pyarrow.table(columns), tmp_path / "log.parquet", store_schema=kept
        )
        read = read_table(tmp_path / "log.parquet")
        assert read["plain"].tolist() == read["coded"].tolist() == ["a", "", "b", "a"]
        assert np.isnan(read["number"].astype(float)).tolist() == [False, True] * 2


def test_measured_over_predicted_jumps_hides_no_point():
    """What lies beyond the frame is an arrow on its edge, with its count; where nothing was
    predicted to jump, words say so.
    """
    measured = np.array([[1.0], [-1.0], [0.5]])
    statistics = dict.fromkeys(("r", "error"), (np.nan,) * 3)
    shown = [
        Agreement(
            "free",
            None,
            "joint rates",
            "rad/s",
            True,
            measured,
            np.array([[9.0], [-0.5], [-7.0]]),
            {**statistics, "r": (0.4,) * 3},
            3,
        ),
        Agreement(
            "locked", None, "joint rates", "rad/s", True, measured, np.zeros((3, 1)), statistics, 3
        ),
    ]
    of_knee = SimpleNamespace(name="knee", group="joint rates", time=None)
    leg = SimpleNamespace(name="leg", source=SimpleNamespace(name=""))
    recorded = SimpleNamespace(robot=leg, rows=3, table=SimpleNamespace(measured=[of_knee]))
    figure = draw_validation(recorded, Validation(tuple(shown), ()))
    free, locked = figure.axes
    reach = free.get_xlim()[1]
    arrows = {
        line.get_marker(): line.get_xydata().tolist()
        for line in free.lines
        if line.get_marker() in "<>"
    }
    assert arrows == {">": [[reach, 1.0]], "<": [[-reach, 0.5]]}
    assert "arrows: 2 of 3 beyond" in [text.get_text() for text in free.texts]
    assert locked.get_title() == "locked\nno jump predicted"
    assert "nan" not in free.get_title()
    FigureCanvasAgg(figure).draw()
    assert figure.legends[0].get_window_extent().x0 >= locked.get_window_extent().x1


CORRUPTED = """
import io, sys
import numpy as np, pyarrow, pyarrow.parquet
from shockpc.wings.recordings.tables.table_files import read_table
from pathlib import Path
table = pyarrow.table({"q": [0.1, None, 0.3], "contact": ["a", "b", None]})
out = io.BytesIO()
pyarrow.parquet.write_table(table, out)
data = out.getvalue()
path = Path("t.parquet")
for k in range(len(data) - 700, len(data) - 8):
    path.write_bytes(data[:k] + bytes([data[k] ^ 3]) + data[k + 1 :])
    try:
        read_table(path)
    except Exception as refusal:
        assert type(refusal).__name__ == "StudyError", repr(refusal)
"""


def test_a_corrupted_header_of_a_parquet_file_is_a_message(tmp_path):
    """Whatever single byte of it is wrong: neither an end of the process nor an unexpected
    exception.
    """
    done = subprocess.run(
        [sys.executable, "-c", CORRUPTED], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-500:]


def test_an_inertia_that_is_singular_in_double_precision_has_no_energy(capfd, here):
    """Of a follower with the mass of the Earth: the other statistics do not need it."""
    light = (
        '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
        'izz="1"/></inertial>'
    )
    heavy = light.replace('mass value="1"', 'mass value="1e24"').replace(
        "<inertial>", '<inertial><origin xyz="0 0.1 0"/>'
    )
    (here / "heavy.urdf").write_text(
        f'<robot name="heavy"><link name="body">{light}</link><link '
        f'name="shin">{light}</link><link name="arm">{heavy}</link>'
        '<joint name="knee" type="continuous"><parent link="body"/><child link="shin"/><axis '
        'xyz="0 1 0"/></joint>'
        '<joint name="shoulder" type="continuous"><parent link="body"/><child link="arm"/><axis '
        'xyz="1 0 0"/>'
        '<mimic joint="knee" multiplier="0.5"/></joint></robot>'
    )
    (here / "log.csv").write_text(
        "contact,q_knee,before_knee,vz,after_knee\nshin,0.1,0,-1,0.5\nshin,0.2,0.1,-1,0.5\n"
    )
    outcome = run(capfd, "recorded", "log.csv", "heavy.urdf", "--format", "json")
    assert outcome.code == 0, outcome.err
    agreement = json.loads(outcome.out)["tables"]["measured"][-1]
    assert agreement["error_energy"] is None
    assert agreement["error"] > 0.0


def test_what_nobody_knows_of_the_robot_stands_first(capfd, tmp_path):
    """A1's drives decide about the predictions; in the document too.

    With joints that are stated to be free nothing is unknown.
    """
    (tmp_path / "log.csv").write_text("FL_calf_joint\n-1.8\n-1.7\n")
    words = ("recorded", tmp_path / "log.csv", "a1", "--contact", "FL_foot")
    assert good(capfd, *words).startswith("unknown      the drives of all 12 joints are not known")
    kinds = [
        (one["kind"], one["status"])
        for one in json.loads(good(capfd, *words, "--format", "json"))["unknowns"]
    ]
    assert kinds[0] == ("drives", "unknown")
    assert not good(capfd, *words, "--joints", "free").startswith("unknown")
