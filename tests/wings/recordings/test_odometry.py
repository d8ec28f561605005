"""Low-level logs: the base's velocity by standing feet, gyros, jumps of accelerometers, and samples
that are repeated.
"""

import functools
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from robot_texts import STEPPER
from scipy.spatial.transform import Rotation
from test_touchdowns import scene_of, stepped, stepping

import shockpc
from shockpc import Contact, Joints, Posture, Scene, load_robot
from shockpc.bench.found_touchdowns import FEET, _hip_and_knee, quadruped_mjcf
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Point
from shockpc.text.errors import StudyError, UnknownName
from shockpc.wings.recordings.logs.repeats import repetitions
from shockpc.wings.recordings.recorded.study import compare_measured

LEGS = ("FL", "FR", "RL", "RR")
SCENE = Scene(robot="go2", contact=tuple(Contact(frame=f"{leg}_foot", at="frame") for leg in LEGS))
LANDS, STEP = 0.1, 1e-3
BEFORE, AFTER = (
    np.array([0.4, -0.1, -0.3, 0.3, -0.5, 0.2]),
    np.array([0.3, 0.1, 0.05, -0.2, 0.4, 0.1]),
)
"""Velocity and angular velocity of the base in its axes before FR lands, and after."""


@functools.cache
def walk():
    """A motion of Go2, integrated by Pinocchio: its feet stand while its base moves as above, but
    FR swings until it lands.
    """
    robot = load_robot("go2")
    model, data = robot.model, robot.model.createData()
    legs = [
        [robot.joint(f"{leg}_{part}_joint").v.start for part in ("hip", "thigh", "calf")]
        for leg in LEGS
    ]

    def rates(q, time):
        v = np.zeros(model.nv)
        v[:6] = BEFORE if time < LANDS else AFTER
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        for leg, at in zip(LEGS, legs, strict=True):
            J = pin.getFrameJacobian(
                model, data, model.getFrameId(f"{leg}_foot"), pin.LOCAL_WORLD_ALIGNED
            )[:3]
            v[at] = (
                [0.3, -0.5, 1.0]
                if leg == "FR" and time < LANDS
                else np.linalg.solve(J[:, at], -J[:, :6] @ v[:6])
            )
        return v

    times, Q = np.arange(0.0, 0.16, STEP), [landing_of(SCENE, robot).q]
    for time in times[:-1]:
        middle = pin.integrate(model, Q[-1], 0.5 * STEP * rates(Q[-1], time))
        Q.append(pin.integrate(model, Q[-1], STEP * rates(middle, time + 0.5 * STEP)))
    return robot, times, np.array(Q)


def low_level(standing=LEGS, attitude=False, gyro=False):
    """A log of that motion: joints, flags of the feet (those that are not named are in the air),
    attitude and gyro.
    """
    robot, time, Q = walk()
    columns = {"time": time} | {
        f"q_{name}": Q[:, robot.joint(name).q.start]
        for name in robot.joint_names
        if name.startswith(LEGS)
    }
    for leg in LEGS:
        columns[f"{leg}_foot_contact"] = (
            (leg in standing) * ((time > LANDS - 0.5 * STEP) | (leg != "FR")) * 1.0
        )
    if attitude:
        columns |= dict(zip(("qx", "qy", "qz", "qw"), Q[:, 3:7].T, strict=True))
    if gyro:
        twist = np.where(time[:, None] < LANDS, BEFORE, AFTER)
        columns |= {f"w{axis}_body": twist[:, 3 + k] for k, axis in enumerate("xyz")}
    return columns


@pytest.mark.parametrize(
    ("standing", "more"),
    [
        (LEGS, {}),
        (LEGS, {"attitude": True}),
        (("FL", "FR"), {"gyro": True}),
        (("FR", "RL", "RR"), {"attitude": True, "gyro": True}),
    ],
)
def test_standing_feet_tell_how_the_base_moves(standing, more):
    """Velocities before and after are those that were integrated; without an attitude the base has
    that of the scene.
    """
    robot, _, Q = walk()
    found = shockpc.touchdowns(low_level(standing, **more), SCENE, robot=robot)
    (landing,) = found.landings
    assert (landing.contacts, landing.message) == (("FR_foot",), "")
    for prefix, twist, at in (
        ("", BEFORE, landing.first - 1.5),
        ("after6ms_", AFTER, landing.last + 6),
        ("after30ms_", AFTER, landing.last + 30),
    ):
        rotation = (
            Rotation.from_quat(Q[round(at), 3:7]).as_matrix() if "attitude" in more else np.eye(3)
        )
        table = found.table.columns
        values = [table[f"{prefix}{kind}{axis}"][0] for kind in "vw" for axis in "xyz"]
        np.testing.assert_allclose(
            values, [*rotation @ twist[:3], *rotation @ twist[3:]], atol=2e-3
        )
    # The table is one that `recorded` takes, and the base has this velocity in it.
    rows = shockpc.recorded(found.table, SCENE, ["delta_v@imu"], robot=robot)
    np.testing.assert_allclose(
        rows.landings.table.before.velocity[0],
        [found.table.columns[f"v{axis}"][0] for axis in "xyz"],
    )


def test_a_gyro_with_missing_samples_tells_how_the_base_turns():
    """Of two samples one, none at the ends of the log, beside an attitude that is too slow for
    slopes.
    """
    columns, n = low_level(("FL", "FR"), attitude=True, gyro=True), np.arange(160)
    for name in columns:
        if name in ("qx", "qy", "qz", "qw"):
            columns[name] = np.where(n % 8 == 0, columns[name], np.nan)
        elif name.startswith("w"):
            columns[name] = np.where((n % 2 == 0) & (n > 3) & (n < 150), columns[name], np.nan)
    found = shockpc.touchdowns(columns, SCENE, robot=walk()[0])
    assert [one.message for one in found.landings] == [""]
    for prefix, twist, at in (("", BEFORE, 97), ("after30ms_", AFTER, 129)):
        rotation = Rotation.from_quat(walk()[2][at, 3:7]).as_matrix()
        values = [
            found.table.columns[f"{prefix}{kind}{axis}"][0] for kind in "vw" for axis in "xyz"
        ]
        np.testing.assert_allclose(
            values, [*rotation @ twist[:3], *rotation @ twist[3:]], atol=5e-3
        )


@pytest.mark.parametrize(
    ("standing", "more", "reason"),
    [
        (("FR",), {"gyro": True}, "no foot stands"),
        (("FL", "FR"), {}, "without a gyro"),
        (("FL", "FR", "RR"), {}, "without a gyro"),
    ],
)
def test_a_base_velocity_that_is_not_known_is_not_that_of_the_scene(standing, more, reason):
    """The row says why, its cells are empty, and it is no landing at 1 m/s; with the columns left
    out, that is asked for.
    """
    robot = walk()[0]
    found = shockpc.touchdowns(low_level(standing, **more), SCENE, robot=robot)
    assert found.landings[0].message.startswith(
        f"no base velocity: {'' if 'no foot' in reason else str(len(standing) - 1)}"
    )
    assert reason in found.landings[0].message
    assert "no base velocity before 1 of 1 touchdowns" in " ".join(found.warnings)
    assert np.isnan([found.table.columns[f"v{axis}"][0] for axis in "xyz"]).all()
    with pytest.raises(StudyError, match=r"column vx.*--map vx="):
        shockpc.recorded(found.table, SCENE, robot=robot)
    rename = {
        f"{kind}{axis}": ""
        for kind in "vw"
        for axis in "xyz"
        if f"{kind}{axis}" in found.table.columns
    }
    rows = shockpc.recorded(found.table, SCENE, robot=robot, rename=rename).landings.table
    np.testing.assert_allclose(rows.before.velocity, [[0.0, 0.0, -1.0]])


def test_feet_that_slip_are_said():
    """Beside a foot whose joint drifts the other three give another motion: neither is the base's,
    so its cells are empty.
    """
    columns = low_level(gyro=True)
    columns["q_RL_calf_joint"] = columns["q_RL_calf_joint"] + 3.0 * columns["time"]
    found = shockpc.touchdowns(columns, SCENE, robot=walk()[0])
    assert (
        "no base velocity: the standing feet move against each other" in found.landings[0].message
    )
    assert np.isnan(
        [
            found.table.columns[f"{prefix}v{axis}"][0]
            for prefix in ("", "after6ms_")
            for axis in "xyz"
        ]
    ).all()
    with pytest.raises(StudyError, match="column vx"):
        shockpc.recorded(found.table, SCENE, robot=walk()[0])


def test_flags_that_are_not_known_at_first_are_no_touchdown():
    """They are those of the first sample that has one."""
    columns = low_level(attitude=True, gyro=True)
    columns["FL_foot_contact"] = np.where(
        np.arange(len(columns["time"])) % 10 < 3, np.nan, columns["FL_foot_contact"]
    )
    found = shockpc.touchdowns(columns, SCENE, robot=walk()[0])
    assert [(one.contacts, one.stance) for one in found.landings] == [
        (("FR_foot",), ("FL_foot", "RL_foot", "RR_foot"))
    ]
    assert not any("not used" in text for text in found.warnings)


def test_two_feet_tell_how_a_planar_base_moves(here):
    """Without gyro and attitude: two legs of two joints, whose angles follow from where the base
    is, in closed form.
    """
    (here / "dog.xml").write_text(quadruped_mjcf())
    feet = tuple(Contact(frame=f"{foot}_foot", at="frame") for foot in FEET)
    scene = Scene(
        robot=str(here / "dog.xml"),
        base="planar",
        contact=feet,
        posture=Posture(base_rpy_deg=(0.0, 0.0, 0.0)),
    )
    time, columns = np.arange(0.0, 0.2, STEP), {}
    x, z, pitch = 0.3 * (time - LANDS), 0.32 - 0.2 * (time - LANDS), 0.5 * (time - LANDS)
    for foot, hip in zip(FEET, (0.2, 0.2, -0.2, -0.2), strict=True):
        ahead, down = hip - x, -z  # the foot from the base, in axes of the world
        inside = np.stack(
            [
                np.cos(pitch) * ahead - np.sin(pitch) * down - hip,
                np.sin(pitch) * ahead + np.cos(pitch) * down,
            ],
            axis=1,
        )
        columns[f"{foot}_hip"], columns[f"{foot}_knee"] = np.array(
            [_hip_and_knee(*at) for at in inside]
        ).T
        columns[f"{foot}_foot_contact"] = (
            1.0 * (time > LANDS - 0.5 * STEP) if foot == "RF" else np.full(len(time), foot != "RH")
        )
    found = shockpc.touchdowns({"time": time} | columns, scene)
    assert [one.message for one in found.landings] == [""]
    for prefix in ("", "after6ms_"):
        values = [
            found.table.columns[f"{prefix}{key}"][0] for key in ("vx", "vy", "vz", "wx", "wy", "wz")
        ]
        np.testing.assert_allclose(values, [0.3, 0.0, -0.2, 0.0, 0.5, 0.0], atol=5e-3)


JUMP, TURN = np.array([0.3, -0.2, 0.9]), np.array([0.4, -1.5, 0.2])


def shaken(rate=4000.0, refreshed=1):
    """The stepper with an accelerometer at its body and a gyro: a line, a jump in 3 ms from the
    touchdown at 0.2 s, and gravity.
    """
    columns = stepping(rate, stops=(0.2, 0.2))
    t = columns["time"]
    pulse = np.where(
        (t > 0.2) & (t <= 0.203), np.pi / 2.0 / 0.003 * np.sin(np.pi * (t - 0.2) / 0.003), 0.0
    )
    noise = 1e-3 * np.random.default_rng(0).standard_normal((3, len(t)))
    ramp = np.clip((t - 0.2) / 0.003, 0.0, 1.0)
    for k, axis in enumerate("xyz"):
        columns[f"a{axis}@body"] = (0.3 - k) + 9.81 * (axis == "z") + JUMP[k] * pulse + noise[k]
        columns[f"w{axis}@body"] = 0.1 + 2.0 * k * t + TURN[k] * ramp
    if refreshed > 1:
        for name in [name for name in columns if name.startswith("a")]:
            columns[name] = columns[name][np.arange(len(t)) // refreshed * refreshed]
    return columns


@pytest.mark.parametrize(("refreshed", "atol"), [(1, 8e-3), (2, 0.03)])
def test_jumps_of_an_accelerometer_and_a_gyro(here, refreshed, atol):
    """Without gravity and the motion before, at the sensor and at another point of its body, as
    `recorded` takes them.
    """
    scene = scene_of(here, STEPPER, "left_foot", "right_foot")
    scene = replace(scene, point=(Point(frame="body", offset=(0.2, 0.0, 0.1)),))
    found = shockpc.touchdowns(shaken(refreshed=refreshed), scene)
    table, at = found.table.columns, scene.point[0].label
    for time in (6, 12, 30):
        for name, jump in (("delta_v", JUMP), ("delta_omega", TURN)):
            np.testing.assert_allclose(
                [table[f"after{time}ms_{name}.{axis}@body"][0] for axis in "xyz"], jump, atol=atol
            )
        there = [table[f"after{time}ms_delta_v.{axis}@{at}"][0] for axis in "xyz"]
        np.testing.assert_allclose(there, JUMP + np.cross(TURN, [0.2, 0.0, 0.1]), atol=atol)
    assert any("is there 2 times: a new one comes 2000" in text for text in found.warnings) == (
        refreshed == 2
    )
    study = shockpc.recorded(found.table, scene)
    assert {one.group for one in study.landings.table.measured if "@" in one.name} == {
        "delta_v",
        "delta_omega",
    }
    assert {
        one.jump[0] > 0.0 for one in study.landings.table.measured if one.name == "delta_v.y@body"
    } == {False}
    lacking = shockpc.touchdowns({name: x for name, x in shaken().items() if name[0] != "w"}, scene)
    assert f'no jump of "{at}": an accelerometer is on its body, and no gyro' in lacking.warnings


@pytest.mark.parametrize(
    ("change", "warning"),
    [
        (lambda a, _: a / 9.81, 'accelerometer at "body" mostly reads 0.83, as if in g'),
        (lambda a, _: np.clip(a, -157.0, 157.0), "az@body stays at 157"),
        (lambda a, t: np.where((t > 0.2005) & (t < 0.2025), np.nan, a), ""),
    ],
    ids=["in g", "saturated", "a gap in the impact"],
)
def test_jumps_of_an_accelerometer_are_doubted(here, change, warning):
    """With another unit or at the end of its range with a warning; over missing samples there is no
    integral.
    """
    columns = shaken()
    assert not [
        text for text in stepped(here, columns).warnings if "@body" in text or '"body"' in text
    ]
    changed = {
        name: change(x, columns["time"]) if name[0] == "a" else x for name, x in columns.items()
    }
    found = stepped(here, changed)
    jumps = [found.table.columns[f"after6ms_delta_v.{axis}@body"][0] for axis in "xyz"]
    assert np.isnan(jumps).all() == (not warning)
    assert bool(warning) == any(warning in text for text in found.warnings)
    assert ("samples are missing" in found.landings[0].message) == (not warning)


def test_columns_of_sensors_that_cannot_be(here):
    columns = shaken()
    turning = {name: np.degrees(x) if name[0] == "w" else x for name, x in columns.items()}
    assert any('gyro of "body" reads up to' in text for text in stepped(here, turning).warnings)
    with pytest.raises(StudyError, match='lacks "az@body"'):
        stepped(here, {name: x for name, x in columns.items() if name != "az@body"})
    with pytest.raises(UnknownName, match='no frame "bdy"'):
        stepped(here, {name.replace("@body", "@bdy"): x for name, x in columns.items()})


def test_repeated_samples():
    """Of a sensor with new values at a third of the rate; neither coarse encoders nor a robot at
    rest repeat regularly.
    """
    rng = np.random.default_rng(0)
    values = rng.standard_normal((100, 3))
    assert [repetitions(np.repeat(values, n, axis=0)) for n in (1, 2, 3)] == [1, 2, 3]
    assert repetitions(np.round(10.0 * np.sin(0.01 * np.arange(2000.0)))[:, None]) == 1
    assert repetitions(np.concatenate([np.repeat(values[:1], 300, axis=0), values])) == 1


def test_the_sign_of_vectors_at_points():
    """Four feet that stick under locked joints stop the whole robot: all of its points jump by −v,
    and r and slope are 1.
    """
    scene = Scene(
        robot="go2",
        contact=tuple(Contact(frame=f"{leg}_foot") for leg in LEGS),
        joints=Joints(model="locked"),
    )
    vx, vz = np.linspace(-0.5, 0.5, 10), np.linspace(-2.0, -1.0, 10)
    jumps = {
        f"after_delta_v.{axis}@{at}": -v
        for axis, v in (("x", vx), ("z", vz))
        for at in ("imu", "base:0.2,0.1,0")
    }
    table = {"name": np.arange(10).astype(str), "vx": vx, "vz": vz} | jumps
    rows = shockpc.recorded(table, scene, ["delta_v.x@imu", "delta_v@imu"]).table.columns
    np.testing.assert_allclose(rows["delta_v.x@imu"], -vx, atol=1e-9)
    np.testing.assert_allclose(rows["delta_v@imu"], np.hypot(vx, vz), atol=1e-9)
    groups = {
        one.name: one
        for one in compare_measured(table, {"locked": scene}, load_robot("go2")).agreements
        if one.group
    }
    assert list(groups) == ["delta_v"]
    assert groups["delta_v"].measured.shape == (10, 4)
    assert [
        groups["delta_v"].statistics[name][0] for name in ("r", "slope", "error")
    ] == pytest.approx([1.0, 1.0, 0.0], abs=1e-9)
    with pytest.raises(StudyError, match=r"write delta_v\.z@imu"):
        shockpc.recorded(table, scene, ["delta_v@imu.z"])
