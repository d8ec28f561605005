"""Sweeps: every row is what the single analysis of its landing gives, whoever computes it."""

import dataclasses
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest
from commands import STICK, says
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from random_landings import random_landing
from robot_texts import floating, mjcf
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Point,
    Rotor,
    Scene,
    ShockError,
    Strike,
    read_scene,
    resolve,
    shock_profile,
)
from shockpc.evaluation.column import Column
from shockpc.evaluation.column_values import proven_columns
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.vary import read_changes
from shockpc.landing.places import Place
from shockpc.quantities.selection import select
from shockpc.robot.changes import changed, links_with_mass
from shockpc.show.wording import proof_lines
from shockpc.studies.sweep.study import sweep
from shockpc.studies.sweep.summary import PERCENTILES, Summary, _extent, summarise
from shockpc.text.errors import StudyError, UnknownName

ANYMAL = Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),))


@pytest.fixture(scope="module")
def anymal():
    return known_robot("anymal_b")


def table(made: Evaluation) -> tuple[dict, dict]:
    """All rows of a sweep, and its messages by row."""
    whole = made.table
    return whole.columns, whole.messages


def summary_of(made: Evaluation) -> Summary:
    """The summary of a sweep."""
    landings = made.landings
    varied = [
        one
        for one in landings.variations
        if landings.sample is not None and one.kind.word != "contact"
    ]
    return summarise(
        made, made.table, varied, keep=landings.sample is None and len(landings.variations) <= 2
    )


def check(made: Evaluation, rows=None, tolerance=1e-12) -> int:
    """Compare rows of a sweep with the single analysis; the number of rows that are computed."""
    columns, messages = table(made)
    rows, refused, done = list(range(made.landings.rows) if rows is None else rows), set(), 0
    for row in rows:
        try:
            exact = proven_columns(shock_profile(*made.landings.case(row)), made.computed)
        except ShockError:
            refused.add(row)
            continue
        done += 1
        for name, value in exact.items():
            found = float(columns[name][row])
            if columns["proven"][row]:
                assert found == value or (math.isnan(found) and math.isnan(value))
            elif "most_severe_direction" in name:
                continue  # two directions may be as severe as one another
            elif not math.isfinite(value):
                assert found == value or (math.isnan(found) and math.isnan(value)), name
            elif name.startswith(("copc", "ropc")):
                # Lengths are quotients by a rotation; the distance of the centre sets their scale.
                body = name.partition("@")[2]
                far = max(
                    abs(float(exact[f"{key}@{body}"]))
                    for key in ("ropc", *(f"copc.{axis}" for axis in "xyz"))
                )
                assert abs(found - value) <= 10 * tolerance * max(1.0, far**2), name
            else:
                assert abs(found - value) <= tolerance * max(1.0, abs(value)), name
    assert refused == messages.keys() & set(rows)
    return done


@pytest.mark.slow
def test_grid_of_everything_equals_the_single_analysis(anymal):
    """Joints by glob, attitude, strike angle and speed, contact, offset, mass, centre of mass,
    inertia and armature at once.
    """
    vary = {
        "*_KFE": "-90:-30:2",
        "base-pitch": [0, 12],
        "strike-angle": "-20:40:2",
        "speed": [0.5],
        "contact": "LF_FOOT,RH_FOOT",
        "offset-z": [0, -0.02],
        "mass:base": "1x:3e6x:2",
        "com-x:LF_THIGH": [0.03],
        "inertia:LF_SHANK": "2x,3x",
        "armature:*": "0,0.05",
        "inertia-yz:LF_THIGH": [0.002],
    }
    made = sweep(
        ANYMAL,
        robot=anymal,
        vary=vary,
        at=["imu_link", Point(frame="LF_SHANK", offset=(0, 0, 0.1))],
        bodies=["base", "LF_THIGH"],
    )
    assert made.landings.rows == 2**8
    rows = np.random.default_rng(1).choice(made.landings.rows, 24, replace=False).tolist()
    assert check(made, rows) == len(rows)


@pytest.mark.parametrize("angles", [[20], [0, 20]])
def test_shock_over_a_body_in_few_rows_equals_the_single_analysis(anymal, angles):
    """Of one row, too: the jumps of the bodies that are asked for are all that a row needs."""
    for column in ("shock_max@LF_SHANK", "shock_min@LF_SHANK", "shock_max@base"):
        made = sweep(ANYMAL, {"strike-angle": angles}, robot=anymal, quantities=[column], prove=0)
        assert check(made, range(len(angles))) == len(angles)


def test_a_fall_has_its_height_at_every_strike_angle(anymal):
    """With a forward speed beside that of the fall."""
    scene = replace(ANYMAL, strike=Strike(drop_height=0.3))
    assert (
        check(
            sweep(scene, {"strike-angle": "-30:45:3"}, robot=anymal, quantities=["v_in"], prove=0)
        )
        == 3
    )


@pytest.mark.parametrize("angles", [[20.0], [-40.0, 20.0]])
def test_the_greatest_shock_over_a_box_is_that_of_a_corner(angles):
    """In one landing and in many: the largest |Δv + Δω × r| of its eight corners, and as a share of
    the strike's 2 m/s.

    The contact is a point, because which part of a sole carries depends on the strike, and rows
    keep that of the scene.
    """
    box = (
        '<collision><origin xyz="0.02 0 -0.2"/><geometry><box size="0.06 0.04 '
        '0.4"/></geometry></collision>'
    )
    robot = robot_from(STICK.replace('<link name="shin">', f'<link name="shin">{box}'))
    contact = Contact(frame="foot", at="frame", kind="point")
    scene = Scene(robot="stick", contact=contact, strike=Strike(speed=2.0))
    corners = np.stack(np.meshgrid([-0.01, 0.05], [-0.02, 0.02], [-0.4, 0.0]), axis=-1).reshape(
        -1, 3
    )
    columns, _ = table(
        sweep(
            scene,
            {"strike-angle": angles},
            robot=robot,
            quantities=["shock_max@shin", "delta_v_max@shin"],
            prove=0,
        )
    )
    for row, angle in enumerate(angles):
        profile = shock_profile(
            replace(scene, strike=Strike(speed=2.0, strike_angle_deg=angle)), robot
        )
        k = profile.bodies.index("shin")
        greatest = np.linalg.norm(
            profile.delta_v[k] + np.cross(profile.delta_omega[k], corners), axis=1
        ).max()
        assert columns["delta_v_max@shin"][row] == pytest.approx(greatest, rel=1e-12)
        assert columns["shock_max@shin"][row] == pytest.approx(greatest / 2.0, rel=1e-12)
        assert profile.value("shock_max", "body")[k] == pytest.approx(greatest / 2.0, rel=1e-12)


def test_rows_that_doubles_cannot_solve_are_proven():
    """Beside a body of 2e19 kg the inertia of a shin is lost in rounding; extreme directions of
    such rows exist all the same.
    """
    robot = robot_from(STICK.replace('value="2"', 'value="2e19"'))
    scene = Scene(robot="stick", contact=(Contact(frame="foot"),))
    made = sweep(scene, {"knee": "-20:20:3"}, robot=robot, bodies=["body", "shin"])
    assert check(made) == 3
    assert table(made)[0]["proven"].all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "contact", "changes"),
    [
        ("hyq", "lf_foot", {}),
        ("solo12", "FL_FOOT+HR_FOOT", {}),
        ("talos", "left_sole_link", {"joints": Joints(model="locked")}),
        (
            "anymal_b",
            "LF_FOOT",
            {"stance": ("RH_FOOT",), "joints": Joints(armature={"*_KFE": 0.05})},
        ),
        ("go2", "FL_foot", {"base": "planar"}),
        (
            "a1",
            "FL_foot",
            {
                "v_in": "com",
                "strike": Strike(joint_velocities={"FL_*": 0.1}, angular_velocity=(0.1, 0.2, 0.0)),
            },
        ),
        (
            "bolt",
            "FL_FOOT",
            {"strike": Strike(velocity=(0.3, 0.1, -1.0), joint_velocities={"FL_KFE": 0.1})},
        ),
    ],
)
def test_sample_within_the_limits_equals_the_single_analysis(robot, contact, changes):
    """Random postures of robots with free, geared and locked joints, several contacts, standing
    feet and moving joints.
    """
    scene = Scene(
        robot=robot, contact=tuple(Contact(frame=name) for name in contact.split("+")), **changes
    )
    loaded = known_robot(robot)
    made = sweep(
        scene,
        {"strike-angle": "-30:30"} if scene.strike.velocity is None else {},
        robot=loaded,
        sample=6,
        seed=3,
        bodies=[loaded.bodies[0].name, loaded.bodies[-1].name],
    )
    assert check(made) > 0
    columns, _ = table(made)
    for joint in loaded.joints[1:]:
        if joint.axis is not None and joint.kind == "revolute" and f"{joint.name} [deg]" in columns:
            values = np.radians(columns[f"{joint.name} [deg]"])
            assert np.all((values >= joint.limits[0] - 1e-12) & (values <= joint.limits[1] + 1e-12))


@pytest.mark.slow
@settings(parent=settings(), max_examples=settings().max_examples // 2)
@given(st.integers(0, 3000))
def test_sweeps_of_random_landings_equal_the_single_analysis(number):
    """Trees with joints of all kinds, closures, mimics, drives, standing feet and moving joints:
    unflagged rows to 1e-12.
    """
    robot, scene = random_landing(number)
    single = [
        joint.name
        for joint in robot.joints
        if joint.axis is not None and joint.name in robot.joint_names
    ]
    followers = {mimic.joint for mimic in robot.mimics}
    vary = [(f"joint:{name}", [0.0, 0.1]) for name in single if name not in followers][:2]
    vary.append(
        ("armature:*", [0.02, 0.5])
        if not scene.joints.armature and not scene.joints.locked and robot.joint_names
        else ("offset-x", [0.0, 0.05])
    )
    heavy = [
        link
        for link in robot.links
        if number % 2 and robot.model.frames[robot.model.getFrameId(link)].inertia.mass
    ]
    vary += (
        [
            (f"mass:{heavy[-1]}", "1x,1.5x"),
            (f"com-y:{heavy[0]}", [0.0, 0.02]),
            (f"inertia:{heavy[-1]}", "1.1x"),
        ]
        if heavy
        else []
    )
    try:
        made = sweep(scene, robot=robot, vary=vary, bodies=[robot.bodies[-1].name], prove=0)
    except ShockError:
        reject()
    check(
        made,
        np.random.default_rng(number)
        .choice(made.landings.rows, min(made.landings.rows, 3), replace=False)
        .tolist(),
    )


INERTIAL = {
    "mass:*": "±5%",
    "com-x:*": "±0.01",
    "com-y:*": "-0.01:0.02",
    "com-z:*": "0.005+-0.002",
    "inertia:*": "0.8x:1.2x:log",
}
"""Variations of inertias for `vary_each`."""

ROTOR = Rotor(inertia=1e-4, gear_ratio=100.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "contact", "changes", "armature"),
    [
        (
            "anymal_c",
            "LF_FOOT",
            {"joints": Joints(armature={"*": 0.05}), "v_in": "com"},
            "*=0.5x:2x",
        ),
        (
            "go2",
            "FL_foot+RR_foot",
            {"stance": ("FR_foot",), "strike": Strike(joint_velocities={"FL_*": 0.1})},
            "FL_*=0:0.1",
        ),
        (
            "talos",
            "left_sole_link",
            {"base": "planar", "joints": Joints(rotor={"leg_*": ROTOR})},
            "*=±9%",
        ),
        ("solo12", "FL_FOOT", {"joints": Joints(locked=("FL_HAA",))}, "*=0,0.01"),
    ],
)
def test_inertias_of_rows_equal_the_single_analysis_of_the_changed_robot(
    robot, contact, changes, armature
):
    """Each link's mass, centre of mass and inertia and the joints' armature at once, in one posture
    and in many.
    """
    contacts, loaded = tuple(Contact(frame=name) for name in contact.split("+")), known_robot(robot)
    scene = Scene(robot=robot, contact=contacts, **changes)
    pattern, _, values = armature.partition("=")
    quantities = (
        "mass",
        "energy_share",
        "total_moment",
        "delta_v_com",
        "out_of_plane_share",
        "joint_impulse",
        "delta_qd",
    )
    for postures in ({}, {"*": None}):
        vary, each = {f"armature:{pattern}": values}, INERTIAL | postures
        made = sweep(
            scene,
            robot=loaded,
            vary=vary,
            vary_each=each,
            sample=2,
            seed=2,
            lhs=True,
            quantities=quantities,
            prove=0,
        )
        assert check(made) == 2


SPRUNG = {"*_hip_joint": Rotor(inertia=1e-4, gear_ratio=6.0, stiffness=100.0)}


def sprung(k: float = 1.0, **changes) -> Joints:
    """Hips with springs before their rotors, of k times 100 N m/rad."""
    return Joints(
        rotor={name: replace(motor, stiffness=100.0 * k) for name, motor in SPRUNG.items()},
        **changes,
    )


@pytest.mark.parametrize(
    ("joints", "vary", "same"),
    [
        (sprung(), {"joint-stiffness:*_hip_joint": "0.5x,2x"}, (sprung(0.5), sprung(2.0))),
        (sprung(), {"joint-stiffness:*_hip_joint": "150"}, (sprung(1.5),)),
        (
            sprung(),
            {"joint-stiffness:F[LR]_calf_joint": "50"},
            (sprung(stiffness={"F[LR]_calf_joint": 50.0}),),
        ),
        (
            sprung(stiffness={"*": 40.0, "FL_*": 30.0}),
            {"joint-stiffness:*": "0.5x"},
            (sprung(0.5, stiffness={"*": 20.0, "FL_*": 15.0}),),
        ),
        (
            sprung(armature={"*": 0.01}),
            {"armature:*": "3x"},
            (
                Joints(
                    armature={"*": 0.03},
                    rotor={"*_hip_joint": Rotor(inertia=3e-4, gear_ratio=6.0, stiffness=100.0)},
                ),
            ),
        ),
        (sprung(drives="none"), {"armature:*_calf_joint": "0"}, (sprung(drives="none"),)),
        (
            sprung(model="rigid", stiffness={"FL_calf_joint": 9.0}),
            {"armature:RR_calf_joint": "1x"},
            (sprung(model="rigid", stiffness={"FL_calf_joint": 9.0}),),
        ),
    ],
)
def test_drives_of_rows_are_those_of_a_scene(joints, vary, same):
    """On contacts of finite stiffness the springs count: the peaks are those of the scene with the
    drives written out.
    """
    scene = Scene(
        robot="go2", contact=(Contact(frame="FL_foot"),), contact_stiffness=1e5, joints=joints
    )
    go2, key = known_robot("go2"), "peak_acceleration"
    made = sweep(scene, vary, robot=go2, quantities=[f"{key}@imu"], prove=0)
    expected = [
        shock_profile(replace(scene, joints=other), go2).value(key, "point")[0] for other in same
    ]
    np.testing.assert_allclose(table(made)[0][f"{key}@imu"], expected, rtol=1e-9)


def test_lengths_of_rows_equal_the_single_analysis_of_the_changed_robot(anymal):
    """With masses and a contact that vary as well; the place of a joint is its distance from the
    one before, times the factor.
    """
    vary = {
        "place:*_KFE": "0.8x,1.3x",
        "mass:base": "0.9x,1.2x",
        "strike-angle": "0,30",
        "contact": "LF_FOOT,RH_FOOT",
    }
    made = sweep(ANYMAL, vary, robot=anymal, at=["imu_link"], bodies=["LF_SHANK"])
    assert check(made) == made.landings.rows == 16
    _, longer = made.landings.case(15)
    number = anymal.model.getJointId("LF_KFE")
    placed = [robot.model.jointPlacements[number].translation for robot in (anymal, longer)]
    np.testing.assert_allclose(placed[1], 1.3 * placed[0], rtol=1e-14)
    for values, text in (
        ("0,0,-0.3", "varied by factors"),
        ("0.8x:1.2x", "drawn from by --sample"),
    ):
        with pytest.raises(StudyError, match=text):
            sweep(ANYMAL, {"place:LF_KFE": values}, robot=anymal)


def test_a_mass_that_no_body_has_is_the_message_of_its_row(anymal):
    _, messages = table(made := sweep(ANYMAL, robot=anymal, vary={"mass:LF_SHANK": [0.5, 1e30]}))
    assert list(messages) == [1]
    assert "cannot be computed with" in messages[1]
    assert check(made) == 1


def truncated(u):
    """Quantiles of the standard normal distribution within three standard deviations."""
    normal = NormalDist()
    low = normal.cdf(-3.0)
    return np.array([normal.inv_cdf(low + x * (1.0 - 2.0 * low)) for x in u])


@pytest.mark.parametrize(
    ("text", "quantiles"),
    [
        ("1:9", lambda u: 1 + 8 * u),
        ("1:16:log", lambda u: 16**u),
        ("5+-0.5", lambda u: 5 + 0.5 * truncated(u)),
    ],
)
def test_distributions_have_their_quantiles(anymal, text, quantiles):
    """Row k of a Latin hypercube, in order, lies between the quantiles k/n and (k + 1)/n."""
    made, n = sweep(ANYMAL, robot=anymal, vary={"mass:LF_SHANK": text}, sample=2000, lhs=True), 2000
    x, edges = (
        np.sort(made.landings._values(0)[made.landings.axes[0]][:, 0]),
        quantiles(np.arange(n + 1) / n),
    )
    assert np.all((x >= edges[:-1] - 1e-12) & (x <= edges[1:] + 1e-12))


def test_factors_of_drives_are_log_uniform_and_of_masses_uniform(anymal):
    geared = replace(ANYMAL, joints=Joints(armature={"*": 0.05}, stiffness={"LF_KFE": 50.0}))
    vary = {"armature:*": "0.5x:2x", "joint-stiffness:*": "0.5x:2x", "mass:LF_SHANK": "0.5x:2x"}
    made = sweep(geared, robot=anymal, vary=vary, sample=4000, lhs=True, prove=0)
    medians = [np.median(made.landings._values(0)[one]) for one in made.landings.axes]
    assert medians == pytest.approx([1.0, 1.0, 1.25], rel=1e-3)  # the posture is held


@pytest.mark.parametrize("n", [1, 2, 60001, 200000])
def test_any_number_of_rows_keeps_the_strata(anymal, n):
    """Also a prime one, and over several parts; quantities are not permuted alike."""
    made = sweep(
        ANYMAL, robot=anymal, vary={"*_KFE": "0:1", "strike-angle": "0:1"}, sample=n, lhs=True
    )
    x, y = (
        np.concatenate(
            [made.landings._values(k)[axis][:, 0] for k in range(len(made.landings.chunks))]
        )
        for axis in made.landings.axes
    )
    assert np.array_equal(np.unique(np.floor(x * n)), np.arange(n))
    assert np.array_equal(np.unique(np.floor(y * n)), np.arange(n))
    assert n < 60001 or abs(np.corrcoef(x, y)[0, 1]) < 0.02


def test_summary_of_a_sample_holds_percentiles_and_rank_correlations(anymal):
    """Against SciPy, with ties, rows without a number and a constant column."""
    from scipy.stats import spearmanr

    vary = {"*_KFE": [-100, -60, -30], "strike-angle": "0:120", "com-x:LF_HIP": [0.01]}
    made = sweep(
        ANYMAL, robot=anymal, vary=vary, sample=400, quantities=["mass"], at=["imu_link"], prove=0
    )
    columns, messages = table(made)
    assert messages
    summary = summary_of(made)
    shock = columns["shock@imu_link"]
    known = ~np.isnan(shock)
    assert summary.extents[0].percentiles == tuple(
        np.sort(shock[known])[math.ceil(known.sum() * p / 100) - 1] for p in PERCENTILES
    )
    for one, row in zip(summary.varied, summary.correlations, strict=True):
        if one.kind.word.startswith("com"):
            assert np.isnan(row[0])
        else:
            assert row[0] == pytest.approx(
                spearmanr(columns[one.column][known], shock[known]).statistic, abs=1e-12
            )
    assert np.isnan(
        summary.correlations[:, [one.column.name for one in summary.extents].index("mass@anymal")]
    ).all()


def test_base_quaternion_from_angles_is_that_of_a_scene(anymal):
    """Roll, pitch and yaw of the base in one array give the posture that a scene gives."""
    made = sweep(
        ANYMAL,
        robot=anymal,
        vary={"base-roll": "-170:170", "base-pitch": "-89:89", "base-yaw": "-180:180"},
        sample=8,
    )
    Q = made.landings._postures(
        resolve(*made.landings.case(0)), made.landings._values(0), np.arange(8)
    )
    for row in range(8):
        q = resolve(*made.landings.case(row)).q
        assert min(np.abs(Q[row] - q).max(), np.abs(Q[row, 3:7] + q[3:7]).max()) < 1e-12


def test_flagged_rows_are_the_proven_answer():
    """Redundant rows ask for a proof in every posture, and every row is the midpoint of its
    enclosure.
    """
    robot = known_robot("solo12")
    feet = tuple(Contact(frame=name) for name in ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"))
    scene = Scene(robot="solo12", contact=feet, joints=Joints(model="locked"))
    made = sweep(scene, robot=robot, vary={"speed": [0.5, 2.0], "*_KFE": [60, 80]}, prove=0)
    columns, _ = table(made)
    assert columns["proven"].all()
    assert np.all(columns["double_error"] < 1e-9)
    assert check(made) == 4


def test_loops_are_closed_in_every_row():
    """A row whose loop cannot be closed has a message; the others have their closed posture."""
    robot, scene = next(
        (r, s) for r, s in map(random_landing, range(0, 400)) if s.closure and len(r.bodies) > 5
    )
    joint = next(j.name for j in robot.joints if j.axis is not None and j.name in robot.joint_names)
    made = sweep(scene, robot=robot, vary={f"joint:{joint}": "-20:20:5"}, prove=0)
    assert made.landings.separate
    check(made)


def test_rods_on_ball_joints_turn_as_the_loops_need():
    """Followed from the first posture or closed at once, Cassie's legs end in one configuration."""
    scene = read_scene(Path(__file__).parents[1] / "robots" / "measured" / "cassie.toml")
    joints = {"hip_pitch_right": 20.0, "knee_left": -70.0}
    made = sweep(scene, {name: [value] for name, value in joints.items()}, prove=0)
    followed, alone = (
        resolve(*made.landings.case(0)),
        resolve(
            replace(scene, posture=replace(scene.posture, joints_deg=joints)), made.landings.robot
        ),
    )
    np.testing.assert_allclose(followed.q, alone.q, atol=1e-10)


def test_plane_is_checked_before_anything_is_computed(anymal):
    with pytest.raises(ShockError, match=r'plane.*"auto", "xz", "yz".*3 numbers'):
        sweep(replace(ANYMAL, plane="sagittal"), robot=anymal, vary={"speed": [1.0]})


def test_strikes_that_leave_the_ground_are_rows_with_a_message(anymal):
    made = sweep(ANYMAL, robot=anymal, vary={"strike-angle": [0, 60, 100]})
    columns, messages = table(made)
    assert list(messages) == [2]
    assert says(messages[2], '"LF_FOOT"', "not approach")
    assert np.isnan(columns["shock_com@base"]).tolist() == [False, False, True]


def test_sample_depends_on_the_seed_alone(anymal):
    """The same seed gives the same rows, another one others, whoever computes them."""
    one, same, other = (
        list(sweep(ANYMAL, robot=anymal, sample=300, seed=seed, prove=3)) for seed in (1, 1, 2)
    )
    with ThreadPoolExecutor(2) as executor:
        threaded = list(sweep(ANYMAL, robot=anymal, sample=300, seed=1, prove=3).tables(executor))
    for a, b, c in zip(one, same, threaded, strict=True):
        for name, values in a.columns.items():
            np.testing.assert_array_equal(values, b.columns[name])
            np.testing.assert_array_equal(values, c.columns[name])
    assert not np.array_equal(one[0].columns["LF_KFE [deg]"], other[0].columns["LF_KFE [deg]"])


def test_parts_cover_every_row_once(anymal):
    for options in (
        {"sample": 131071},
        {"vary": {"*_KFE": "-100:-20:977", "*_HFE": "-10:10:101", "strike-angle": "0:30:7"}},
    ):
        made = sweep(ANYMAL, robot=anymal, **options)
        assert [a for a, _ in made.landings.chunks] == [
            0,
            *(b for _, b in made.landings.chunks[:-1]),
        ]
        assert made.landings.chunks[-1][1] == made.landings.solves
        assert made.landings.rows == made.landings.solves * made.landings.strikes


def test_quantities_by_name_are_those_of_the_single_analysis(anymal):
    """Of a glob of joints, a point, a component, all contacts and the robot; the summary shows
    those that are asked for.
    """
    asked = [
        "joint_impulse@*_KFE",
        "delta_v.x@LF_SHANK:0,0,-0.1",
        "effective_mass",
        "energy_lost",
        "depth_below_contacts",
        "body.delta_v@RH_THIGH",
    ]
    made = sweep(ANYMAL, robot=anymal, vary={"LF_KFE": "-110:-60:3"}, quantities=asked, prove=0)
    names = [column.name for column in made.computed if column.requested]
    assert names == [
        "depth_below_contacts@anymal",
        *(f"joint_impulse@{leg}_KFE" for leg in ("LF", "LH", "RF", "RH")),
        "delta_v.x@LF_SHANK:0,0,-0.1",
        "effective_mass@LF_FOOT",
        "energy_lost@anymal",
        "body.delta_v@RH_THIGH",
    ]
    assert check(made) == 3
    with pytest.raises(UnknownName, match='nearest: "joint_impulse"'):
        sweep(ANYMAL, robot=anymal, vary={"LF_KFE": "-110:-60:3"}, quantities=["joint_impuls"])
    with pytest.raises(UnknownName, match='no joint "LF_KNEE"'):
        sweep(
            ANYMAL,
            robot=anymal,
            vary={"LF_KFE": "-110:-60:3"},
            quantities=["joint_impulse@LF_KNEE"],
        )


WITH_FRICTION = (
    "shock_friction@imu_link",
    "along_friction@LF_KFE",
    "total_moment_friction",
    "impulse_friction",
    "ropc_friction@base",
)


@pytest.mark.parametrize(
    ("changes", "in_arrays"),
    [
        ({"contact": (Contact(frame="LF_FOOT", restitution=0.3),)}, True),
        (
            {
                "contact": (Contact(frame="LF_FOOT"), Contact(frame="RH_FOOT")),
                "joints": Joints(locked=("LF_HAA",)),
            },
            True,
        ),
        (
            {"contact": (Contact(frame="LF_FOOT", directions=("x", "z")),), "stance": ("RF_FOOT",)},
            True,
        ),
        ({"contact": (Contact(frame="LF_FOOT", kind="flat"),)}, False),
    ],
)
def test_rows_with_friction_equal_the_single_analysis(anymal, changes, in_arrays):
    """Many at once, unless soles or loops hold rows rigidly; contacts that stick, slide and
    separate.
    """
    scene = replace(ANYMAL, friction=0.25, **changes)
    made = sweep(
        scene,
        {"LF_KFE": [-90.0, -60.0], "strike-angle": [-50.0, 0.0, 40.0]},
        robot=anymal,
        quantities=WITH_FRICTION,
        prove=0,
    )
    assert check(made) > 3
    assert made.table.columns["proven"].all() != in_arrays


def test_undetermined_impulses_are_left_out_of_a_sweep(anymal):
    """Of redundant contacts no single joint's impulse is determined, as of the contacts themselves;
    the energy is.
    """
    scene = Scene(
        robot="anymal_b",
        contact=tuple(Contact(frame=f) for f in ("LF_FOOT", "RF_FOOT", "LH_FOOT")),
        joints=Joints(model="locked"),
    )
    columns, _ = table(
        sweep(
            scene,
            robot=anymal,
            vary={"speed": [1.0]},
            quantities=["joint_impulse@LF_HAA", "impulse.z", "energy_lost"],
        )
    )
    assert np.isnan(columns["joint_impulse@LF_HAA"]).all()
    assert np.isnan(columns["impulse.z@LF_FOOT"]).all()
    assert columns["energy_lost@anymal"][0] > 0.0


def test_the_centre_of_mass_is_that_of_the_changed_robot():
    """A centre of mass that is moved takes the point of the body's shock with it."""
    scene = Scene(robot="go2", contact=(Contact(frame="FL_foot"),))
    made = sweep(
        scene,
        robot=known_robot("go2"),
        vary={"com-x:base": [0.0, 0.2]},
        quantities=("delta_v_com@base", "effective_mass_sticking"),
    )
    assert check(made) == 2


def test_contacts_may_differ_in_number():
    """A landing on one foot has no second contact; the friction of each is that of the single
    analysis.
    """
    scene = Scene(robot="go2", contact=(Contact(frame="FL_foot"),))
    made = sweep(
        scene,
        robot=known_robot("go2"),
        vary={"contact": "FL_foot+FR_foot,RL_foot"},
        quantities=("impulse",),
    )
    assert check(made) == 2
    assert np.isnan(table(made)[0]["impulse@contact 2"]).tolist() == [False, True]
    with pytest.raises(StudyError, match="the contact varies"):
        sweep(
            scene,
            robot=known_robot("go2"),
            vary={"contact": "FL_foot,RL_foot"},
            quantities=("impulse@FL_foot",),
        )


def test_a_change_of_a_link_changes_that_link_alone():
    """Mass and moments of the body grow by those of the link; the centre of mass moves by its
    share.
    """
    robot = known_robot("anymal_c")
    more = changed(robot, read_changes("mass:battery=1.5x"))
    assert more.mass - robot.mass == pytest.approx(
        0.5 * links_with_mass(robot, "battery")["battery"]
    )
    assert np.flatnonzero(more.masses != robot.masses).tolist() == [0]
    moved = changed(robot, read_changes("com-z:battery=0.1"))
    share = links_with_mass(robot, "battery")["battery"] / robot.masses[0]
    np.testing.assert_allclose(moved.coms[0] - robot.coms[0], [0.0, 0.0, 0.1 * share], atol=1e-12)
    same = changed(robot, read_changes("inertia:LF_THIGH=2x; inertia:LF_THIGH=0.5x"))
    np.testing.assert_allclose(same.inertias, robot.inertias, atol=1e-15)
    with pytest.raises(UnknownName, match='main link of its body is "base_inertia"'):
        changed(robot, read_changes("mass:base=2x"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("vary", "options", "error", "words"),
    [
        ({}, {}, StudyError, "nothing varies"),
        ({"*_KFE": [1]}, {"seed": -1}, StudyError, "seed must be ≥ 0 and ≤ 1e+15, got -1"),
        ({"*_KFE": [1]}, {"prove": -1}, StudyError, "prove must be ≥ 0"),
        ({}, {"sample": 10**12}, StudyError, "sample must be ≥ 1 and ≤ 1e+08, got 1e+12"),
        ({"*_KFE": "-90:-30:1000000", "speed": "1:2:1000000"}, {}, StudyError, "1e+12 landings"),
        ({"*_KFE": "0:1:0"}, {}, StudyError, "from 1 to 1000000"),
        ({"*_KFE": "0:1:1e3"}, {}, StudyError, "from 1 to 1000000"),
        ({"*_KFE": "0:1:1000000000"}, {}, StudyError, "from 1 to 1000000"),
        ({"*_KFE": []}, {}, StudyError, "list of values is empty"),
        ({"*_KFE": "-90:-30"}, {}, StudyError, "--sample N"),
        ({"*_KFE": "-90:2000:3"}, {}, StudyError, 'outside the limits of joint "LF_KFE"'),
        ({"*_KFE": "a:b:c"}, {}, StudyError, "not a finite number"),
        ({"*_KNEE": [1]}, {}, UnknownName, 'no joint or quantity "*_KNEE"'),
        ({"*_KFE": [1], "LF_KFE": [2]}, {}, StudyError, '"LF_KFE" is varied twice'),
        ({"strike-angle": [0, 200]}, {}, ShockError, "must lie in"),
        ({"speed": [-1]}, {}, ShockError, "above zero"),
        ({"mass:base": "0x:1x:3"}, {}, StudyError, "not above zero"),
        ({"mass:nothing": "1x"}, {}, UnknownName, "nothing"),
        ({"mass: base": "1x"}, {}, UnknownName, 'no link with mass " base"'),
        ({"speed ": [1]}, {}, UnknownName, 'no joint or quantity "speed "'),
        ({"mass": "1x"}, {}, StudyError, "mass names no link; write mass:LINK=VALUES"),
        ({"inertia:base": "1,2"}, {}, StudyError, "by factors"),
        ({"armature:*": [-1]}, {}, StudyError, "below zero"),
        ({"contact": ""}, {}, ShockError, ""),
        ({"mass:base": "±40%"}, {"sample": 9}, StudyError, "not above zero"),
        (
            {"armature:*": "0.5x:2x"},
            {"sample": 9},
            StudyError,
            "no reflected inertia to multiply; give values in kg m²",
        ),
        (
            {"joint-stiffness:*": "0.5x:2x"},
            {"sample": 9},
            StudyError,
            "the rotor behind a spring is not known",
        ),
        ({"joint-stiffness:*": [0]}, {}, StudyError, "not above zero"),
        ({"speed": "±0.1"}, {"sample": 9}, StudyError, "give it too"),
        ({"speed": "±5%"}, {"sample": 9}, StudyError, "a factor such as"),
        ({"speed": "1±0"}, {"sample": 9}, StudyError, "no standard deviation"),
        ({"com-x:LF_HIP": "0:1:log"}, {"sample": 9}, StudyError, "no logarithm"),
        ({"*_KFE": [-60]}, {"lhs": True}, StudyError, "--sample"),
        ({}, {"sample": 0}, StudyError, "sample must be ≥ 1"),
        ({"*_KFE": [-60]}, {"at": ["nose"]}, UnknownName, "nose"),
        ({"*_KFE": [-60]}, {"bodies": ["nose"]}, UnknownName, "nose"),
    ],
)
def test_sweeps_that_make_no_sense_are_refused(anymal, vary, options, error, words):
    with pytest.raises(error) as refused:
        sweep(ANYMAL, robot=anymal, vary=vary, **options)
    assert words in str(refused.value)


def test_prismatic_joints_are_varied_in_metres():
    text = STICK.replace('type="revolute"', 'type="prismatic"')
    robot = robot_from(text, ".urdf")
    made = sweep(
        Scene(robot="stick", contact=(Contact(frame="foot"),)),
        robot=robot,
        vary={"knee": "-0.1:0.1:3"},
    )
    assert made.headings[0] == "knee [m]"
    assert check(made) == 3


@pytest.mark.parametrize(
    "values",
    [[1.0, 1.0 + 2e-16, 1.0], [0.0, 5e-324], [1.5e300, np.nextafter(1.5e300, 2e300)], [2.0, 2.0]],
)
def test_values_that_differ_by_rounding_alone_are_counted(values):
    """80 intervals do not fit between neighbouring doubles; all values are counted about the middle
    of a wider range.
    """
    column = Column(select("shock"), Place("imu"))
    extent = _extent(
        column,
        Table(
            (column,),
            {column.name: np.array(values), "proven": np.zeros(len(values), dtype=bool)},
            {},
        ),
        0,
    )
    assert extent.counts[39:41].sum() == extent.counts.sum() == len(values)
    assert extent.span[0] <= min(values) <= max(values) <= extent.span[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("feet", "mu", "e", "along", "seed"),
    [("LF_FOOT", 0.3, 0.7, "normal", 0), ("LF_FOOT+RH_FOOT", 0.8, 0.9, "directions", 2)],
)
def test_landings_that_gain_energy_with_friction_are_refused_in_a_sweep_too(
    anymal, feet, mu, e, along, seed
):
    """Rows are refused where the single analysis is, in posture, attitude and strike at random; of
    the others the numbers agree.
    """
    contacts = tuple(
        Contact(frame=foot, restitution=e, restitution_along=along) for foot in feet.split("+")
    )
    scene, vary = (
        Scene(robot="anymal_b", contact=contacts, friction=mu),
        {"base-pitch": "-30:30", "strike-angle": "-60:60"},
    )
    vary |= {"*_HFE": "-40:60", "*_KFE": "-120:-20"}
    made = sweep(scene, vary, robot=anymal, at=["imu_link"], sample=60, seed=seed, prove=0)
    assert 0 < check(made) < 60
    _, messages = table(made)
    assert all("would gain" in text for text in messages.values())


@pytest.mark.parametrize("friction", [None, 0.5])
def test_rows_that_level_ground_does_not_allow(anymal, friction):
    """Those of which the single analysis warns: of a link below the ground, and, where friction
    lets it not open, of a pull.
    """
    scene = dataclasses.replace(ANYMAL, friction=friction)
    vary = {"LF_KFE": "-150:-20:6", "strike-angle": [0.0, 70.0]}
    made = sweep(scene, vary, robot=anymal, at=["imu_link"], prove=0)
    expected = []
    for row in range(made.landings.rows):
        profile = shock_profile(*made.landings.case(row))
        warnings = " ".join(map(str, profile.health.warnings))
        pulled = "pulled" in warnings and (
            friction is None or profile.friction.state == ("sticks",)
        )
        expected.append([pulled, "below the contact, so" in warnings])
    columns, _ = table(made)
    allowed = ~np.any(expected, axis=1)
    np.testing.assert_array_equal(columns["feasible@anymal"], allowed)
    assert {True, False} == set(allowed.tolist())
    pulled, below = np.array(expected).T
    shock = columns["shock@imu_link"]
    for feasible in (False, True):
        one = dataclasses.replace(made, feasible=feasible)
        kept, _ = table(one)
        for name in columns:
            np.testing.assert_array_equal(kept[name], columns[name][allowed | (not feasible)])
        summary = summary_of(one)
        assert summary.refused == (np.sum(~allowed), np.sum(pulled), 0, np.sum(below & ~pulled))
        (extent,) = summary.extents
        assert shock[extent.best_row] == shock[allowed].min() > shock.min()
        assert shock[extent.greatest_row] == shock[allowed | (not feasible)].max()
    np.testing.assert_array_equal(kept["row"], np.flatnonzero(allowed))


def test_an_option_that_says_that_it_varies_is_one_of_a_sweep(anymal):
    """Damping of soft contacts: each row is the analysis with that damping."""
    scene = replace(ANYMAL, contact_stiffness=1e5)
    made = sweep(
        scene,
        {"contact-damping": "10,200"},
        robot=anymal,
        quantities=["contact.restitution@LF_FOOT"],
        prove=0,
    )
    table = made.table
    alone = [
        shock_profile(replace(scene, contact_damping=value), anymal) for value in (10.0, 200.0)
    ]
    expected = [float(profile.value("restitution", "contact")[0]) for profile in alone]
    assert table.values("contact.restitution@LF_FOOT") == pytest.approx(expected, rel=1e-12)
    assert expected[0] != pytest.approx(expected[1], rel=1e-3)


def test_landings_that_are_compared_with_a_proof_are_others_only_beside_proven_ones():
    assert " in 3 landings: " in next(proof_lines(0, 3, 1e-16, ()))
    assert " in 1 other landing: " in [*proof_lines(2, 1, 1e-16, ())][1]


def test_a_ball_joint_and_a_point_mass_are_set_as_an_analysis_sets_them():
    """Rows in double precision are the proven landings of the scenes and robots that they stand
    for.
    """
    ball = (
        '<joint name="hip" type="ball"/><inertial pos="0 0 -.1" mass="1" diaginertia=".1 .2 .25"/>'
    )
    leg = f'<body name="leg">{ball}<site name="foot" pos="0.1 0 -0.3"/></body>'
    robot = robot_from(mjcf(floating(leg)), ".xml")
    vary = {"turn-x:hip": [-10.0, 20.0], "turn-y:hip": [0.0, 30.0], "point-mass:leg": [0.0, 0.5]}
    table = sweep(
        Scene(robot="m", contact="foot"), vary, robot=robot, quantities=["shock_com@base"], prove=8
    ).table
    assert len(set(np.round(table.columns["shock_com@base"], 9))) == 8
    assert table.columns["double_error"].max() < 1e-12


@pytest.mark.parametrize("speeds", [{"speed": 1.0}, {"velocity": (0.1, 0.0, -1.0)}])
def test_a_strike_angle_does_not_vary_in_a_horizontal_plane(speeds):
    """There is no direction from which it is measured, also where the velocity is given."""
    scene = Scene(robot="go2", contact="FL_foot", plane="xy", strike=Strike(**speeds))
    with pytest.raises(ShockError, match=r"^no strike angle is defined in a horizontal plane"):
        sweep(scene, {"strike-angle": [0.0, 10.0]})
