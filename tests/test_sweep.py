"""Sweeps: every row is what the single analysis of its landing gives, whoever computes it."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from commands import STICK
from hypothesis import given
from hypothesis import strategies as st
from random_landings import random_landing
from trees import robot_from

from shockpc import Contact, Joints, Point, Posture, Scene, ShockError, Strike, load_robot, resolve, shock_maps, shock_profile
from shockpc.core.directions import extreme_directions, most_severe_directions
from shockpc.core.extremes import greatest_shock, shock_extremes
from shockpc.core.spatial import plane_from
from shockpc.errors import RobotError, StudyError, UnknownName
from shockpc.results.geometry import body_pieces
from shockpc.robot.variant import changed_link, link_mass
from shockpc.studies.columns import proven_columns
from shockpc.studies.sweep import Sweep, sweep, sweep_of

ANYMAL = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),))


@pytest.fixture(scope="module")
def anymal():
    return load_robot("anymal_b")


def chunks(made: Sweep) -> list:
    return [made.chunk(k) for k in range(len(made.parts))]


def table(made: Sweep) -> tuple[dict, dict]:
    """All rows of a sweep, and its messages by row."""
    parts = chunks(made)
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
    return columns, {part.first + i: text for part in parts for i, text in part.messages.items()}


def check(made: Sweep, rows=None, tolerance=1e-12) -> int:
    """Compare rows of a sweep with the single analysis; the number of rows that are computed."""
    columns, messages = table(made)
    done = 0
    for row in range(made.rows) if rows is None else rows:
        try:
            exact = proven_columns(shock_profile(*made.case(row)), made.targets)
        except ShockError as refusal:
            assert row in messages, f"row {row}: {refusal}"
            continue
        assert row not in messages, messages[row]
        done += 1
        for name, value in exact.items():
            found = float(columns[name][row])
            if columns["proven"][row]:
                assert found == value or (math.isnan(found) and math.isnan(value))
            elif "most severe direction" in name:
                continue  # two directions may be as severe as one another
            elif not math.isfinite(value):
                assert found == value or (math.isnan(found) and math.isnan(value)), name
            elif "CoPc" in name or "RoPc" in name:
                # Lengths are quotients by a rotation; the distance of the centre sets their scale.
                far = max(abs(float(exact[other])) for other in exact if other.startswith(name.split(" CoPc")[0].split(" RoPc")[0]))
                assert abs(found - value) <= 10 * tolerance * max(1.0, far**2), name
            else:
                assert abs(found - value) <= tolerance * max(1.0, abs(value)), name
    return done


def test_grid_of_everything_equals_the_single_analysis(anymal):
    """Joints by glob, attitude, strike angle and speed, contact, offset, mass, centre of mass, inertia and armature at once."""
    vary = {
        "*_KFE": "-90:-30:2", "base-pitch": [0, 12], "strike-angle": "-20:40:2", "speed": [0.5], "contact": "LF_FOOT,RH_FOOT",
        "offset-z": [0, -0.02], "mass:base": "1x:3e6x:2", "com-x:LF_THIGH": [0.03], "inertia:LF_SHANK": "2x,3x", "armature:*": "0,0.05",
    }  # fmt: skip
    made = sweep_of(ANYMAL, anymal, vary, at=["imu_link", Point(frame="LF_SHANK", offset=(0, 0, 0.1))], bodies=["base", "LF_THIGH"])
    assert made.rows == 2**8
    rows = np.random.default_rng(1).choice(made.rows, 24, replace=False).tolist()
    assert check(made, rows) == len(rows)


@pytest.mark.parametrize(
    ("robot", "contact", "changes"),
    [
        ("hyq", "lf_foot", {}),
        ("solo12", "FL_FOOT+HR_FOOT", {}),
        ("talos", "left_sole_link", {"joints": Joints(model="locked")}),
        ("anymal_b", "LF_FOOT", {"stance": ("RH_FOOT",), "joints": Joints(armature={"*_KFE": 0.05})}),
        ("go2", "FL_foot", {"base": "planar"}),
        ("a1", "FL_foot", {"v_in": "com", "strike": Strike(joint_velocities={"FL_*": 0.1}, angular_velocity=(0.1, 0.2, 0.0))}),
        ("bolt", "FL_FOOT", {"strike": Strike(velocity=(0.3, 0.1, -1.0), joint_velocities={"FL_KFE": 0.1})}),
    ],
)
def test_sample_within_the_limits_equals_the_single_analysis(robot, contact, changes):
    """Random postures of robots with free, geared and locked joints, several contacts, standing feet and moving joints."""
    scene = Scene(robot=robot, contact=tuple(Contact(frame=name) for name in contact.split("+")), **changes)
    loaded = load_robot(robot)
    made = sweep_of(
        scene,
        loaded,
        {"strike-angle": "-30:30"} if scene.strike.velocity is None else {},
        sample=16,
        seed=3,
        bodies=[loaded.bodies[0].name, loaded.bodies[-1].name],
    )
    assert check(made) > 0
    columns, _ = table(made)
    for joint in loaded.joints[1:]:
        if joint.axis is not None and joint.kind == "revolute" and f"{joint.name} [deg]" in columns:
            values = np.radians(columns[f"{joint.name} [deg]"])
            assert np.all((values >= joint.limits[0] - 1e-12) & (values <= joint.limits[1] + 1e-12))


@given(st.integers(0, 3000))
def test_sweeps_of_random_landings_equal_the_single_analysis(number):
    """Trees with joints of all kinds, closures, mimics, drives, standing feet and moving joints: every unflagged row to 1e-12."""
    robot, scene = random_landing(number)
    single = [joint.name for joint in robot.joints if joint.axis is not None and joint.name in robot.joint_names]
    followers = {mimic.joint for mimic in robot.mimics}
    vary = [(f"joint:{name}", [0.0, 0.1]) for name in single if name not in followers][:2]
    vary.append(
        ("armature:*", [0.02, 0.5])
        if not scene.joints.armature and not scene.joints.locked and robot.joint_names
        else ("offset-x", [0.0, 0.05])
    )
    try:
        made = sweep_of(scene, robot, vary, bodies=[robot.bodies[-1].name], prove=0)
    except ShockError:
        return
    check(made)
