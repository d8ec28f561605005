"""The experiment of the guide: a quadruped with five accelerometers is dropped on one foot, here in
MuJoCo with links that bend.
"""

import json
import re
import shlex
from pathlib import Path

import mujoco
import numpy as np
import pytest
from commands import good
from log_file import written

import shockpc
from shockpc.bench.found_touchdowns import FEET, quadruped_mjcf
from shockpc.wings.recordings.recorded.study import STATISTICS

GUIDE = Path(shockpc.__file__).parent / "wings/recordings/logs.md"
CORNERS = {
    "fl": (0.2, 0.1),
    "fr": (0.2, -0.1),
    "rl": (-0.2, 0.1),
    "rr": (-0.2, -0.1),
    "imu": (0.03, 0.0),
}
"""Where accelerometers are on the trunk [m]."""

STEP, EVERY, LASTS, HEIGHT, BENDING = 1e-4, 1, 0.06, 0.1, 3000.0
"""Of the simulation [s]; every how many samples one is in the log; time and height of a drop [s,
m]; a shank's hinge [N m/rad].
"""


def rig():
    """The quadruped with frames for the sensors, in the text of an MJCF."""
    sites = "".join(f'<site name="{name}" pos="{x} {y} 0.02"/>' for name, (x, y) in CORNERS.items())
    return quadruped_mjcf().replace("<freejoint/>", f"<freejoint/>{sites}")


def bending():
    """The same with shanks of two halves and a hinge between them, and with sensors."""
    text = rig().replace('timestep="0.0005"', f'timestep="{STEP}"')
    for foot in FEET:
        half = '<inertial pos="0 0 {}" mass="0.075" diaginertia="0.00025 0.00025 0.000025"/>'
        text = text.replace(
            f'<inertial pos="0 0 -.08" mass="0.15" diaginertia="0.0005 0.0005 0.00005"/><geom '
            f'name="{foot}_foot"',
            half.format(-0.04)
            + f'<body name="{foot}_half" pos="0 0 -.08">'
            + f'<joint name="{foot}_flex" axis="0 1 0" stiffness="{BENDING}" damping="0.05"/>'
            + half.format(-0.04)
            + f'<geom name="{foot}_foot"',
        ).replace(
            f'<site name="{foot}_site" pos="0 0 -.2" size=".03"/>',
            f'<site name="{foot}_site" pos="0 0 -.12" size=".03"/></body>',
        )
        text = text.replace(
            f'name="{foot}_foot" type="sphere" size=".02" pos="0 0 -.2"',
            f'name="{foot}_foot" type="sphere" size=".02" pos="0 0 -.12"',
        )
    sensors = (
        "".join(f'<accelerometer name="a_{name}" site="{name}"/>' for name in CORNERS)
        + '<gyro name="w" site="imu"/>'
    )
    return text.replace("</sensor>", f"{sensors}</sensor>")


def drops(count, seed=0):
    """A log of drops from the same height, one after another, each on another leg in another
    posture.
    """
    model = mujoco.MjModel.from_xml_string(bending())
    rng, data, rows = np.random.default_rng(seed), mujoco.MjData(model), []
    joints = [f"{foot}_{part}" for foot in FEET for part in ("hip", "knee")]
    at, rates = (
        np.array([getattr(model.joint(name), of)[0] for name in joints])
        for of in ("qposadr", "dofadr")
    )
    speed = np.sqrt(2.0 * 9.81 * HEIGHT)
    for drop in range(count):
        mujoco.mj_resetData(model, data)
        wanted = np.tile([0.9, -2.2], 4)  # folded
        leg = drop % 4
        wanted[2 * leg : 2 * leg + 2] = [rng.uniform(0.1, 0.6), rng.uniform(-1.2, -0.4)]
        roll, pitch = rng.uniform(-0.15, 0.15, 2)
        data.qpos[3:7] = [
            np.cos(roll / 2) * np.cos(pitch / 2),
            np.sin(roll / 2),
            np.sin(pitch / 2),
            0.0,
        ]
        data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
        data.qpos[at] = wanted
        mujoco.mj_kinematics(model, data)
        data.qpos[2] += (
            0.02 - min(data.geom(f"{foot}_foot").xpos[2] for foot in FEET) + 0.03 * speed
        )
        data.qvel[2] = -speed + 0.03 * 9.81
        for k in range(round(LASTS / STEP)):
            data.ctrl[:] = 60.0 * (wanted - data.qpos[at]) - data.qvel[rates]
            mujoco.mj_step(model, data)
            if k % EVERY == 0:
                rows.append(
                    [2.0 * drop + k * STEP, *data.qpos[3:7], *data.qpos[at], *data.sensordata]
                )
    names = [
        "time",
        "qw",
        "qx",
        "qy",
        "qz",
        *(f"q_{name}" for name in joints),
        *(f"{foot}_foot_force" for foot in FEET),
    ]
    names += [f"a{axis}@{name}" for name in CORNERS for axis in "xyz"] + [
        f"w{axis}@imu" for axis in "xyz"
    ]
    return dict(zip(names, np.array(rows).T, strict=True))


@pytest.mark.slow
def test_the_experiment_of_the_guide(here, capfd):
    """Its commands, word by word, on 16 simulated drops: drives are told from free and locked
    joints by five accelerometers.
    """
    columns = drops(16)
    (here / "rig.urdf").write_text(rig())
    written(here / "drops.csv", columns)
    find, compare = re.findall(
        r"^    shockpc (.*(?:drops\.csv|drops/touchdowns\.csv) .*)$",
        GUIDE.read_text("utf-8"),
        re.MULTILINE,
    )
    printed = good(capfd, *shlex.split(find))
    assert "no base velocity: no foot stands" in printed
    good(capfd, *shlex.split(compare))
    measured = json.loads((here / "decided" / "recorded.json").read_text())["tables"]["measured"]
    found = {
        (row["joint_model"], name): row[name.replace(" (", "_").removesuffix(")")]
        for row in measured
        for name in STATISTICS
        if row["quantity"] == "delta_v" and row["after"] == pytest.approx(6e-3) and row["n"] == 16
    }
    table = re.findall(
        r"^\| (geared|free|locked) \| (\S+) \| (\S+) \| (\S+) \|$",
        GUIDE.read_text("utf-8"),
        re.MULTILINE,
    )
    assert [model for model, *_ in table] == ["geared", "free", "locked"]
    for model, *shown in table:  # contacts differ between versions of MuJoCo
        assert [found[model, name] for name in ("r", "slope", "error")] == pytest.approx(
            [float(x) for x in shown], rel=0.05
        )
    assert found["geared", "r"] > 0.95 > 0.9 > max(found["free", "r"], found["locked", "r"])
    assert (
        found["geared", "error"] < 0.3 < 0.6 < min(found["free", "error"], found["locked", "error"])
    )
    assert (
        found["locked", "slope"]
        < 0.3
        < 0.6
        < found["geared", "slope"]
        < 1.2
        < found["free", "slope"]
    )
