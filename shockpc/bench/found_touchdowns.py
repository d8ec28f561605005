"""Touchdowns that are found in logs of a simulated quadruped, against its known contacts."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from shockpc import Contact, Scene, load_robot
from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot
from shockpc.show.tables import Row, Sheet
from shockpc.wings.recordings.touchdowns.study import touchdowns

FEET = ("LF", "RF", "LH", "RH")

STEP = 5e-4
"""Time step of the simulation, whose samples are the log at 2 kHz [s]."""

SAMPLES_APART = 40
"""Number of samples without contact before one that counts as a touchdown.

A contact of the simulation chatters.
"""

HIP_TO_FOOT = -0.32
"""Height of a foot that stands above its hip [m]."""

MATCH = 6e-3
"""By how much a touchdown may be early or late and count as found [s]."""

TROTS = (0.30, 0.36, 0.42)
"""Periods of the trots [s]."""

FALLS = 24
"""Falls, from attitudes and with rates of a seeded sample."""

LOGS = ((1, 0.0), (2, 0.0), (4, 0.0), (10, 0.0), (2, 1e-4), (2, 3e-4), (2, 1e-3))
"""Samples of the simulation for each one in the log, and noise of positions in it [m, rad]."""


def quadruped_mjcf() -> str:
    """A quadruped with two joints a leg, in the text of an MJCF."""
    legs, motors, sensors = "", "", ""
    for foot, x, y in zip(FEET, (0.2, 0.2, -0.2, -0.2), (0.12, -0.12, 0.12, -0.12), strict=True):
        legs += (
            f'<body name="{foot}_thigh" pos="{x} {y} 0"><joint name="{foot}_hip" axis="0 1 0" '
            'armature="0.005" range="-170 170"/>'
            '<inertial pos="0 0 -.08" mass="0.6" diaginertia="0.002 0.002 0.0005"/>'
            f'<body name="{foot}_shank" pos="0 0 -.2"><joint name="{foot}_knee" axis="0 1 0" '
            'armature="0.005" range="-170 170"/>'
            '<inertial pos="0 0 -.08" mass="0.15" diaginertia="0.0005 0.0005 0.00005"/>'
            f'<geom name="{foot}_foot" type="sphere" size=".02" pos="0 0 -.2" mass="0.02" '
            'solref="0.005 1"/>'
            f'<site name="{foot}_site" pos="0 0 -.2" size=".03"/></body></body>'
        )
        motors += f'<motor joint="{foot}_hip"/><motor joint="{foot}_knee"/>'
        sensors += f'<touch site="{foot}_site"/>'
    return (
        '<mujoco model="dog"><compiler autolimits="true"/><option timestep="0.0005" '
        'integrator="implicitfast"/>'
        '<worldbody><geom type="plane" size="9 9 1"/>'
        '<body name="trunk" pos="0 0 .36"><freejoint/><inertial pos="0 0 0" mass="9" '
        'diaginertia="0.06 0.2 0.22"/>'
        f"{legs}</body></worldbody><actuator>{motors}</actuator><sensor>{sensors}</sensor></mujoco>"
    )


def _hip_and_knee(x: float, z: float) -> tuple[float, float]:
    """The angles of a leg with links of 0.2 m whose foot is at (x, z)."""
    knee = -np.arccos(np.clip((x * x + z * z) / 0.08 - 1.0, -1.0, 1.0))
    return float(np.arctan2(-x, -z) - np.arctan2(np.sin(knee), 1.0 + np.cos(knee))), float(knee)


class Simulated(NamedTuple):
    """A motion of the quadruped at 2 kHz.

    Attributes:
        time: (n,) [s].
        qpos: (n, nq) as MuJoCo has it.
        qvel: (n, nv) the same.
        touchdowns: of each foot the last samples before it touches the ground.
    """

    time: Array
    qpos: Array
    qvel: Array
    touchdowns: list[list[int]]

    def log(self, step: int = 1, noise: float = 0.0, seed: int = 0) -> dict[str, Any]:
        """Every so many samples as columns, with noise of positions [m, rad]."""
        rng, qpos = np.random.default_rng(seed), self.qpos[::step].copy()
        qpos += noise * rng.standard_normal(qpos.shape)
        qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1)[:, None]
        return {"time": self.time[::step], "qpos": qpos}


def simulated_trot(period: float = 0.36, seconds: float = 2.0) -> Simulated:
    """A trot on the spot. Args: period [s]; seconds, how long it lasts."""
    return _simulated(np.array([0.0, 0.0, 0.36, 1.0, 0.0, 0.0, 0.0]), np.zeros(6), period, seconds)


def simulated_fall(seed: int, seconds: float = 1.5) -> Simulated:
    """A fall from a tilted attitude, with rates, onto legs that are held.

    Args: seed of these; seconds, how long it lasts.
    """
    rng = np.random.default_rng(seed)
    axis = rng.standard_normal(3)
    angle = rng.uniform(0.2, 0.8)
    x, y, z = np.sin(angle / 2) * axis / np.linalg.norm(axis)
    pose = np.array([0.0, 0.0, rng.uniform(0.6, 0.9), np.cos(angle / 2), x, y, z])
    velocity = np.concatenate([rng.uniform(-0.5, 0.5, 3), rng.uniform(-2.0, 2.0, 3)])
    return _simulated(pose, velocity, None, seconds)


def _simulated(pose: Array, velocity: Array, period: float | None, seconds: float) -> Simulated:
    """The motion from a pose (7,) and a velocity (6,) of the base.

    It is a trot with a period, or one with legs that are held.
    """
    import mujoco  # an extra

    model = mujoco.MjModel.from_xml_string(quadruped_mjcf())
    data = mujoco.MjData(model)
    data.qpos[:7] = pose
    data.qpos[7:] = [*_hip_and_knee(0.0, HIP_TO_FOOT)] * len(FEET)
    data.qvel[:6] = velocity

    n = round(seconds / STEP)
    time = np.asarray(np.arange(n) * STEP)
    force = np.zeros((n, len(FEET)))
    qpos, qvel = np.zeros((n, model.nq)), np.zeros((n, model.nv))
    for k in range(n):
        _set_motors(data, period)
        # The sample is the state before the step, as its force is.
        qpos[k], qvel[k] = data.qpos, data.qvel
        mujoco.mj_step(model, data)
        force[k] = data.sensordata
    return Simulated(time, qpos, qvel, [_touchdowns(on) for on in (force > 0.0).T])


def _set_motors(data: Any, period: float | None) -> None:
    """Let springs and dampers in the joints, with limited torques, follow the angles of a trot."""
    for i, foot in enumerate(FEET):
        motors = slice(2 * i, 2 * i + 2)
        targets = np.array(_hip_and_knee(*_foot_of_trot(foot, data.time, period)))
        spring = 100.0 * (targets - data.qpos[7:][motors])
        damper = 6.0 * data.qvel[6:][motors]
        data.ctrl[motors] = np.clip(spring - damper, -40.0, 40.0)


def _foot_of_trot(foot: str, time: float, period: float | None) -> tuple[float, float]:
    """Where a foot is before and below its hip in a trot, at a time [s]; held without a period [m].

    It swings forwards in the first half of its period, and backwards on the ground in the second.
    The robot stands still for 0.2 s at first.
    """
    if period is None or time <= 0.2:
        return 0.0, HIP_TO_FOOT
    # Diagonal pairs of feet are half a period apart.
    delay = 0.5 if foot in ("RF", "LH") else 0.0
    phase = (time / period + delay) % 1.0
    if phase < 0.5:
        lift = 0.08 * np.sin(2.0 * np.pi * phase)
        return 0.018 * (4.0 * phase - 1.0), HIP_TO_FOOT + lift
    return 0.018 * (3.0 - 4.0 * phase), HIP_TO_FOOT


def _touchdowns(on: np.ndarray) -> list[int]:
    """The last samples before a foot touches the ground, by whether it is on it (n,).

    Those right after other samples on the ground are chatter.
    """
    touchdowns: list[int] = []
    for k in np.flatnonzero(on[1:] & ~on[:-1]).tolist():
        if not on[max(k - SAMPLES_APART, 0) : k + 1].any():
            touchdowns.append(k)
    return touchdowns


def found_touchdowns(budget: float = 0.0) -> Sheet:
    """Numbers of touchdowns of simulated logs that are found, and that are invented.

    Args: budget, of clocks; here are none.
    """
    del budget
    header = ("log", "touchdowns", "found", "invented", "late, median [ms]")
    note = (
        f"a quadruped in MuJoCo; found: within {1e3 * MATCH:g} ms; trots of {len(TROTS)} periods, "
        f"{FALLS} falls on held legs"
    )
    trots = [simulated_trot(period) for period in TROTS]
    falls = [simulated_fall(seed) for seed in range(FALLS)]
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "dog.xml")
        file.write_text(quadruped_mjcf(), encoding="utf-8")
        contacts = tuple(Contact(frame=f"{foot}_foot") for foot in FEET)
        scene = Scene(robot=str(file), contact=contacts)
        robot = load_robot(str(file))
        for step, noise in LOGS:
            for name, motions in (("trots", trots), ("falls", falls)):
                text = f"{name}, {1e-3 / (STEP * step):g} kHz"
                if noise:
                    text += f", noise of {1e3 * noise:g} mm and mrad"
                rows.append((text, *_counts(motions, step, noise, scene, robot)))
    return Sheet("touchdowns found in simulated logs", header, rows, [note])


def _counts(
    motions: Sequence[Simulated], step: int, noise: float, scene: Scene, robot: Robot
) -> Row:
    """Numbers of touchdowns, of those found and of others found, and their median delay [s]."""
    known, invented = 0, 0
    delays: list[float] = []
    for seed, motion in enumerate(motions):
        columns = motion.log(step, noise, seed)
        landings = touchdowns(columns, scene, robot=robot).landings
        for foot, samples in zip(FEET, motion.touchdowns, strict=True):
            # Times of this foot that are found and not yet matched.
            times = []
            for landing in landings:
                if f"{foot}_foot" in landing.contacts:
                    times.append(float(columns["time"][landing.first]))
            for true in motion.time[samples].tolist():
                known += 1
                nearest = min(times, key=lambda time: abs(time - true), default=np.inf)
                if abs(nearest - true) <= MATCH:
                    times.remove(nearest)
                    delays.append(nearest - true)
            invented += len(times)
    return known, len(delays), invented, float(np.median(delays)) if delays else None
