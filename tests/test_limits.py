"""Joint limits: against dense sweeps and analyses of single postures, loops included, and the
paper's statement about HyQ.
"""

import dataclasses
import functools
import json
import math
from pathlib import Path

import numpy as np
import pandas
import pytest
from commands import STICK, good, run, says
from panels import scene
from trees import known_robot

from shockpc.evaluation.variations.kinds.posture import motion_range
from shockpc.impact.drive_response import with_inertias
from shockpc.landing.closure import follow
from shockpc.landing.posture import fixed_joints, set_joints
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.joint_options import Joints
from shockpc.landing.scenes.scene import Contact, Part, Point, Posture, Scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.landing.scenes.strike import Strike
from shockpc.profile import profile_of, shock_profile
from shockpc.quantities.selection import select
from shockpc.studies.limits.report import limits_report
from shockpc.studies.limits.study import limits
from shockpc.studies.place.study import place
from shockpc.studies.sensitivity.study import sensitivity
from shockpc.studies.sweep.study import sweep
from shockpc.text.errors import SolveError, StudyError

IMU = Point(frame="trunk_imu")
HYQ = Scene(robot="hyq", contact=(Contact(frame="lf_foot"),))
SPAN = (math.radians(-150.0), 0.0)


@functools.cache
def hyq(bound, **changes):
    return limits(
        HYQ,
        "lf_kfe_joint",
        IMU,
        bound,
        **{"joint_range": SPAN, "robot": known_robot("hyq")} | changes,
    )


def analysed(base, robot, joint, value, strike, frame):
    """The shock of one posture and one strike angle, or one `Strike`, as `shock_profile` proves it."""
    posture = dataclasses.replace(
        base.posture, joints_deg={**base.posture.joints_deg, joint: math.degrees(value)}
    )
    strike = strike if isinstance(strike, Strike) else Strike(strike_angle_deg=math.degrees(strike))
    changed = dataclasses.replace(base, posture=posture, strike=strike, point=(Point(frame=frame),))
    return next(
        point.shock for point in shock_profile(changed, robot).points if point.frame == frame
    )


def keeps(limits, values):
    """Whether each of some values is in an interval that keeps the bound."""
    return [any(one.low <= value <= one.high for one in limits.intervals) for value in values]


def usable(limits, values):
    """Whether each of some values is in an interval that is feasible besides."""
    return [any(low <= value <= high for low, high in limits.usable) for value in values]


def ends_at_the_bound(limits):
    """The ends of the intervals at which the number is the bound."""
    ends = []
    for low, high, low_end, high_end, _ in limits.intervals:
        ends += [low] if low_end == "bound" else []
        ends += [high] if high_end == "bound" else []
    return ends


@pytest.mark.slow
@pytest.mark.parametrize("bound", [0.0052, 0.02, 0.1])
def test_intervals_against_a_dense_sweep(bound):
    """Every value of a scan ten times as dense is allowed where its shock is below the bound, and
    only there.
    """
    found, dense = hyq(bound, step=math.radians(0.5)), hyq(1.0, step=math.radians(0.05))
    for one in found.limits:
        shock, _ = dense.scan.worst(one.strikes)
        clear = np.abs(shock / bound - 1.0) > 1e-5
        allowed = np.array(keeps(one, dense.scan.values))
        np.testing.assert_array_equal(allowed[clear], (shock <= bound)[clear])
        # Flat ground begins or ceases to allow the landing at a value of the scan.
        feasible = dense.scan.feasible(one.strikes)
        in_scan = np.isin(dense.scan.values.round(9), found.scan.values.round(9))
        both = np.array(usable(one, dense.scan.values))
        np.testing.assert_array_equal(both[in_scan & clear], (allowed & feasible)[in_scan & clear])
        scanned, _ = found.scan.worst(one.strikes)
        assert one.best == scanned[found.scan.feasible(one.strikes)].min()


def test_a_looser_bound_allows_more():
    """The intervals of a bound hold those of each smaller one."""
    values = np.radians(np.linspace(-150.0, 0.0, 1501))
    tight, loose = (hyq(bound, step=math.radians(0.5)) for bound in (0.02, 0.05))
    for one, another in zip(tight.limits, loose.limits, strict=True):
        inner, outer = (np.array(keeps(each, values)) for each in (one, another))
        assert outer[inner].all()
        assert outer.sum() > inner.sum() > 0


def test_statement_of_the_paper_for_hyq():
    """Section 4: the torso is nearly free of shock, but not as the leg approaches its singular
    configuration.

    The paper sees it at segments 10° from the vertical, a knee of 20°. A bound of a tenth of the
    strike sets the limit of HyQ's front knee near there, and the limit in its file, 20°, allows
    more shock than that; of the hind knee it sets a smaller one.
    """
    found = hyq(0.1)
    assert math.degrees(found.limits[-1].intervals[-1].high) == pytest.approx(-24.5, abs=0.01)
    assert math.degrees(found.file_limits[1]) == pytest.approx(-20.0)
    severe, degrees = found.scan.worst(found.strikes)[0], np.degrees(found.scan.values)
    assert severe[np.argmin(np.abs(degrees + 86.0))] < 0.01
    straightening = (degrees > -80.0) & (degrees < -1.0)
    assert np.all(np.diff(severe[straightening]) > 0.0)
    assert severe[-1] > 0.5
    hind = limits(
        dataclasses.replace(HYQ, contact=(Contact(frame="lh_foot"),)),
        "lh_kfe_joint",
        IMU,
        0.1,
        joint_range=(0.0, math.radians(150.0)),
        robot=known_robot("hyq"),
    )
    assert 5.0 < math.degrees(hind.limits[-1].intervals[0].low) < 20.0


def test_a_posture_without_a_result_keeps_no_bound():
    """Nothing can stop a straight leg on a fixed base along itself; nearby the shock grows beyond
    any bound.
    """
    contact = (Contact(frame="hind_foot", directions=("x", "z")),)
    posture = Posture(reference="neutral", joints_deg={"hind_knee": 40.0})
    base = Scene(robot="quadruped", base="fixed", posture=posture, contact=contact)
    shin = Point(frame="hind_lower_leg")
    span = (math.radians(-20.0), math.radians(20.0))
    found = limits(
        base, "hind_knee", shin, 3.0, joint_range=span, step=math.pi / 180.0, strikes=(0.0, 0.2)
    )
    straight = len(found.scan.values) // 2
    ((low, high, reason),) = found.scan.unreachable
    assert low == high == found.scan.values[straight] == 0.0
    assert "cannot be stopped" in reason
    assert np.flatnonzero(np.isnan(found.scan.worst(found.strikes)[0])).tolist() == [straight]
    for one in found.limits:
        assert keeps(one, [0.0]) == [False]
        assert len(ends_at_the_bound(one)) == 2
    with pytest.raises(SolveError, match="no value of hind_knee has a result"):
        limits(base, "hind_knee", shin, 3.0, joint_range=(-1e-9, 1e-9), strikes=(0.0, 0.0))


@pytest.mark.slow
def test_loops_move_with_the_joint():
    """The other joints close the loop in every posture, as an analysis of that posture does."""
    base = scene("five_bar")
    robot = robot_of(base)
    found = limits(
        base,
        "front_hip",
        Point(frame="imu_link"),
        0.1,
        step=math.radians(2.0),
        strikes=(0.0, 0.3),
        joint_range=(math.radians(-40.0), math.radians(80.0)),
        robot=robot,
    )
    assert (found.scan.unreachable, len(found.scan.values)) == ((), 61)
    for one in found.limits[:2]:
        for end in ends_at_the_bound(one):
            shock = analysed(base, robot, "front_hip", end, one.strikes[0], "imu_link")
            assert shock == pytest.approx(0.1, rel=1e-4)


@pytest.mark.slow
def test_loop_that_cannot_be_closed_ends_the_range():
    """With lower links of the length of the upper ones, the hips cannot be turned apart by any
    angle.
    """
    xacro = {"lower_length": "0.1", "spread": "0.12"}
    angles = {"front_hip": 20.0, "rear_hip": -20.0, "front_knee": -50.0, "rear_knee": 50.0}
    posture = Posture(joints_deg=angles)
    base = dataclasses.replace(scene("five_bar"), xacro=xacro, posture=posture)
    imu = Point(frame="imu_link")
    found = limits(base, "front_hip", imu, 2.0, step=math.radians(5.0), robot=robot_of(base))
    assert found.scan.unreachable

    # The knees are apart by at most two lower links, 0.2 m, which are then in line.
    def knee(x, hip):
        return np.array([x, 0.0]) + 0.1 * np.array([math.sin(hip), -math.cos(hip)])

    rear = knee(-0.06, math.radians(-20.0))
    first, last = found.scan.values[[0, -1]]
    reach = max(np.linalg.norm(knee(0.06, hip) - rear) for hip in (first, last))
    assert 0.19 < reach <= 0.2 + 1e-9
    assert -math.pi < first or last < math.pi
    assert any("loop" in interval for one in found.limits for interval in one.intervals)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"bound": 0.0}, "max must be > 0, got 0"),
        ({"bound": math.nan}, "max must be finite, got nan"),
        (
            {"joint_range": (0.0, -1.0)},
            "the range of lf_kfe_joint is 0:-57.296; give its minimum and maximum with --range",
        ),
        ({"strikes": (0.0, 1.6)}, "0:91.67 is not a range of strike angles"),
        ({"step": 0.0}, "a step of 0 in a range of 150 is not possible"),
        ({"step": 1e-9}, "a step of 5.7.*e-08 in a range of 150 .* at most 200000 postures"),
        ({"bound": 1e308}, "max must be > 0 and ≤ 1e.12"),
    ],
)
def test_questions_without_an_answer(changes, text):
    with pytest.raises(StudyError, match=text):
        hyq(**{"bound": 0.1} | changes)


@pytest.mark.parametrize(
    ("study", "ground", "told"),
    [
        (
            lambda scene: limits(scene, "lf_kfe_joint", IMU, 0.1),
            {"contact_stiffness": 1e5},
            "a contact stiffness, which would",
        ),
        (
            lambda scene: sensitivity(scene, IMU, vary={"strike-angle": "0:10"}),
            {"contact_stiffness": 1e5},
            "a contact stiffness, which would",
        ),
        (
            lambda scene: place({"lf": scene}),
            {"friction": 0.3, "contact_stiffness": 1e5},
            "a contact stiffness, which",
        ),
    ],
)
def test_a_ground_that_would_change_nothing_is_refused(study, ground, told):
    with pytest.raises(StudyError, match=told):
        study(dataclasses.replace(HYQ, **ground))


PARTS = dataclasses.replace(
    HYQ,
    joints=Joints(armature={"*": 0.02}),
    part=(Part(name="IMU", at="trunk_imu", rating="half-sine 50 g 11 ms"),),
)
PULSE, STIFF = {"pulse": "half-sine:5ms"}, {"contact_stiffness": 1e5}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "target", "bound"),
    [
        (HYQ, "friction_needed@lf_foot", {"max": 0.4}),
        (dataclasses.replace(HYQ, **PULSE), "peak_g@trunk_imu", {"max": 5.0}),
        (HYQ, "joint_moment@lf_hfe_joint", {"max": 0.05}),
        (HYQ, "delta_qd@lf_kfe_joint", {"max": 8.0}),
        (HYQ, "delta_v.x@trunk_imu", {"max": 0.02}),
        (dataclasses.replace(PARTS, **PULSE), "part_margin@IMU", {"min": 10.0}),
        (dataclasses.replace(PARTS, **PULSE), "joint_torque_share@lf_kfe_joint", {"max": 0.02}),
        (
            dataclasses.replace(PARTS, **STIFF, gravity=False),
            "joint_torque_share@lf_kfe_joint",
            {"max": 0.15},
        ),
        (HYQ, "effective_mass@lf_foot", {"max": 2.0}),
        (HYQ, "mitigation@lf_foot", {"min": 0.84}),
        (
            dataclasses.replace(HYQ, strike=Strike(drop_height=0.1)),
            "joint_impulse@lf_kfe_joint",
            {"max": 4.0},
        ),
    ],
)
def test_a_bound_on_any_quantity_ends_where_the_analysis_meets_it(base, target, bound):
    """The number at the ends of the intervals is the bound, in its unit, at every strike angle;
    inside it keeps it.
    """
    (value,), key, below = bound.values(), target.partition("@")[0], "min" in bound
    span = {"joint_range": SPAN, "step": math.radians(5.0), "robot": known_robot("hyq")}
    found = limits(base, "lf_kfe_joint", target, **bound, **span)
    for one in (found.limits[0], found.limits[-1]):
        numbers, _ = found.scan.worst(one.strikes)
        expected = numbers >= value if below else numbers <= value
        np.testing.assert_array_equal(keeps(one, found.scan.values), expected)
    ends = []
    for one in found.limits[:-1] or found.limits:
        ends += [(one.strikes[0], end) for end in ends_at_the_bound(one)]
    assert ends
    for angle, end in ends:
        posture = Posture(joints_deg={"lf_kfe_joint": math.degrees(end)})
        strike = dataclasses.replace(base.strike, strike_angle_deg=math.degrees(angle))
        profile = shock_profile(
            dataclasses.replace(base, posture=posture, strike=strike), known_robot("hyq")
        )
        number = profile.numbers(select(key), [found.target.place])[0]
        # Linear over 0.02°, a 256th of the step, in which a narrow interval bends.
        assert abs(number) == pytest.approx(value, rel=5e-4)


def test_a_step_beyond_the_range_finds_the_same_end():
    coarse, fine = (hyq(0.1, step=step, strikes=(0.0, 0.0)).limits[0] for step in (3.5, None))
    (end,) = ends_at_the_bound(fine)
    assert ends_at_the_bound(coarse) == pytest.approx([end], abs=1e-6)


@pytest.mark.parametrize(
    ("target", "bound", "text"),
    [
        (
            "mitigation@lf_foot",
            {"max": 0.9},
            "the less value of mitigation@lf_foot is the worse one; bound it by min",
        ),
        (
            "shock@trunk_imu",
            {"min": 0.1},
            "the greater value of shock@trunk_imu is the worse one; bound it by max",
        ),
        ("shock@trunk_imu", {}, "one bound is needed"),
    ],
)
def test_a_bound_is_on_the_side_that_is_worse(target, bound, text):
    with pytest.raises(StudyError, match=text):
        limits(HYQ, "lf_kfe_joint", target, **bound, robot=known_robot("hyq"))


def test_the_least_margin_allowed_on_the_command_line(capfd, tmp_path):
    """The words are of the side of the bound, and the map is drawn."""
    part = (
        "--part",
        "trunk_imu=half-sine 50 g 11 ms",
        "--quantity",
        "part_margin",
        "--min",
        1e4,
        "--step",
        2,
        "--out",
        tmp_path,
    )
    text = good(capfd, "limits", "hyq", "--contact", "lf_foot", "--joint", "lf_kfe_joint", *part)
    assert says(text, "lf_kfe_joint", "part_margin@trunk_imu", "above 10000")
    assert "the best is" in text
    document = json.loads((tmp_path / "limits.json").read_text())
    assert (document["max"], document["min"]) == (None, 1e4)
    assert (tmp_path / "limits.svg").exists()


QUESTION = ("hyq", "--contact", "lf_foot", "--joint", "lf_kfe_joint", "--at", "trunk_imu")


def test_no_value_allowed_is_an_answer(capfd):
    """The command ends with exit code 0, and says what the smallest number is where flat ground
    allows the landing.
    """
    found = hyq(1e-4, strikes=(0.0, 0.0), step=math.radians(0.5))
    (one,) = found.limits
    assert one.intervals == ()
    assert found.table.units["feasible"] == ""
    best = np.argmin(np.where(found.scan.feasible((0.0, 0.0)), found.scan.at_scene_strike, 1.0))
    assert (one.best, one.best_at) == (found.scan.at_scene_strike[best], found.scan.values[best])
    words = ("limits", *QUESTION, "--max", 1e-4, "--strikes", "0:0", "--step", 0.5)
    text = good(capfd, *words, "--range", "-150:0")
    assert says(text, "below 0.0001", f"{one.best:.3g} at {math.degrees(one.best_at):.4g} deg")
    tight = good(capfd, *words, "--range", "-150:-140")
    assert "flat ground allows no landing of this range" in tight
    loose = good(capfd, *words, "--range", "-150:-140", "--ground-tolerance", 1, "--format", "json")
    tables = json.loads(loose)["tables"]
    assert tables["limits"][0]["feasible"] is None
    assert -150.0 <= tables["best"][0]["at_deg"] <= -140.0


def test_postures_that_level_ground_does_not_allow_are_named(capfd):
    """Feasible are the values whose analysis has no warning of a contact that would be pulled, or
    of a link below the ground.
    """
    found = hyq(0.1, strikes=(0.0, 0.0), step=math.radians(5.0))
    expected = []
    for value in found.scan.values:
        posture = Posture(joints_deg={"lf_kfe_joint": math.degrees(value)})
        changed = dataclasses.replace(HYQ, posture=posture)
        warnings = list(map(str, shock_profile(changed, known_robot("hyq")).health.warnings))
        expected.append(not any("pulled" in text or "meets" in text for text in warnings))
    assert {True, False} == set(expected)
    assert found.scan.feasible((0.0, 0.0)).tolist() == expected
    allowed = keeps(found.limits[0], found.scan.values)
    assert usable(found.limits[0], found.scan.values) == (np.array(allowed) & expected).tolist()
    words = ("--max", 0.1, "--range", "-150:0", "--strikes", "0:0", "--step", 5)
    text = good(capfd, "limits", *QUESTION, *words)
    assert f"not allow {expected.count(False)} of {len(expected)} postures" in text


def test_command(capfd, tmp_path):
    """Table, document, spreadsheet and folder agree."""
    words = ("limits", *QUESTION, "--max", 0.1, "--range", "-150:0", "--step", 2)
    table = good(capfd, *words, "--out", tmp_path)
    found = json.loads(good(capfd, *words, "--format", "json"))
    assert found == json.loads((tmp_path / "limits.json").read_text())
    assert found["schema"] == "shockpc.limits/2"
    assert (found["file_limits"], found["range"]) == ([-140.0, -20.0], [-150.0, 0.0])
    assert run(capfd, *words, "--format", "csv").out == (tmp_path / "limits.csv").read_text()
    expected = hyq(0.1, step=math.radians(2.0))
    rows = iter(found["tables"]["limits"])
    for one in expected.limits:
        for interval in one.intervals:
            row = next(rows)
            angles = [row["strike_from_deg"], row["strike_to_deg"]]
            values = [row["low_deg"], row["high_deg"]]
            assert np.radians([*angles, *values]) == pytest.approx([*one.strikes, *interval[:2]])
            assert (row["low_end"], row["high_end"], row["feasible"]) == interval[2:]
    assert next(rows, None) is None
    assert f"{math.degrees(interval.high):.2f}" in table
    postures = pandas.read_csv(tmp_path / "postures.csv")
    assert set(map(str, postures.dtypes)) == {"float64"}
    worst, _ = expected.scan.worst(expected.strikes)
    np.testing.assert_allclose(postures.iloc[:, 2], worst, rtol=1e-12)
    files = {file.name for file in tmp_path.iterdir() if file.name[0] != "."}
    sheets = {f"{sheet}.csv" for sheet in ("limits", "best", "drives", "postures")}
    figures = {"limits.svg", "limits.png"}
    assert files == {"limits.json", "report.md", "report.html", *sheets, *figures}
    outcome = run(capfd, "limits", *QUESTION, "--max", 0.1, "--range", "12")
    assert (outcome.code, outcome.out) == (2, "")
    assert '"12" is not 2 values with ":" between them, such as -30:75' in outcome.err


def test_a_number_that_does_not_depend_on_what_varies(capfd):
    """The report says so, and names quantities that depend on it."""
    words = (*QUESTION[:3], "--joint", "friction", "--range", "0.1:0.8", "--strikes", "0:30")
    text = good(capfd, "limits", *words, "--step", 0.1, "--at", "trunk_imu", "--max", 0.1)
    assert says(text, "shock@trunk_imu does not depend on friction", "shock_friction or peak_force")
    assert says(text, "friction", "0.1 to 0.8", "steps of 0.1")
    assert "file's limits" not in text
    other = ("--quantity", "shock_friction@trunk_imu", "--max", 1, "--step", 0.35)
    assert "does not depend" not in good(capfd, "limits", *words, *other)


def test_the_only_place_of_a_quantity_need_not_be_named():
    found = limits(
        HYQ,
        "lf_kfe_joint",
        "friction_needed",
        0.6,
        joint_range=SPAN,
        step=0.1,
        robot=known_robot("hyq"),
    )
    assert found.target.name == "friction_needed@lf_foot"


LEG = """<robot name="leg"><link name="base"/>
<joint name="hip" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" effort="9" velocity="9"/></joint>
<link name="upper"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><origin xyz="0 0 -0.3"/><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/>
  <limit lower="0.2" upper="1.5" effort="9" velocity="9"/></joint>
<link name="lower"><inertial><origin xyz="0 0 -0.4"/><mass value="0.5"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="ankle" type="fixed"><origin xyz="0 0 -0.4"/><parent link="lower"/><child link="foot"/></joint>
<link name="foot"/></robot>"""


@pytest.mark.parametrize("bound", [0.6, 1.0, 3.0])
@pytest.mark.parametrize("step", [0.01, 0.2])
def test_impulse_of_a_two_link_leg(tmp_path, bound, step):
    """The upper link (length l, mass m at the knee, inertia I) is vertical, the lower one (k, n at
    the foot, I) turned by β.

    With H = [[A, C cos β], [C cos β, B]] for their rotations, A = (m + n) l² + I, B = n k² + I, C =
    n l k, the mobility of the foot along the vertical is w = k² sin² β A / (A B − C² cos² β). The
    foot slides, so at 1 m/s the impulse is cos θ / w.
    """
    (tmp_path / "leg.urdf").write_text(LEG)
    contact = Contact(frame="foot", directions=("z",))
    posture = Posture(reference="neutral", joints={"knee": 1.0})
    scene = Scene(
        robot=str(tmp_path / "leg.urdf"), base="fixed", contact=(contact,), posture=posture
    )
    found = limits(scene, "knee", "total_impulse", bound, strikes=(-0.3, 0.5), step=step)
    m, n, upper, k, inertia = 2.0, 0.5, 0.3, 0.4, 1e-3
    A, B, C = (m + n) * upper**2 + inertia, n * k**2 + inertia, n * upper * k
    best = (A * B - (C * math.cos(1.5)) ** 2) / (A * (k * math.sin(1.5)) ** 2)
    assert [one.strikes for one in found.limits][-1] == (-0.3, 0.5)
    for one in found.limits:
        low, high = one.strikes
        cosine = math.cos(min(max(0.0, low), high))
        expected = math.asin(math.sqrt((A * B - C**2) / (bound / cosine * k**2 * A - C**2)))
        first, last = one.intervals[0], one.intervals[-1]
        assert (first.low_end, last.high_end) == ("bound", "range")
        assert (first.low, last.high) == (pytest.approx(expected, abs=2e-6), 1.5)
        assert one.best == pytest.approx(cosine * best, rel=1e-9)


def test_a_joint_is_looked_at_in_the_same_range_by_every_study():
    """ANYmal B's file has limits of ±540°; a turn holds every posture. HyQ's are those of the file."""
    for name, frame, point, joint in (
        ("anymal_b", "LF_FOOT", "imu_link", "LF_KFE"),
        ("hyq", "lf_foot", "trunk_imu", "lf_kfe_joint"),
    ):
        robot = known_robot(name)
        scene = Scene(robot=name, contact=(Contact(frame=frame),))
        (drawn,) = sweep(scene, {f"joint:{joint}": None}, robot=robot, sample=9).landings.variations
        found = limits(
            scene, joint, Point(frame=point), 0.1, strikes=(0.0, 0.0), step=0.5, robot=robot
        )
        assert drawn.span == pytest.approx(np.degrees(found.range), abs=1e-12)
        assert found.range == motion_range([robot.joint(joint)])
        assert found.range[1] - found.range[0] <= 2.0 * math.pi


@pytest.mark.parametrize(
    ("low", "high", "taken"), [(-150.0, 0.0, True), (-150.0, 359.0, True), (-150.0, 400.0, False)]
)
def test_limits_and_sweeps_take_the_same_values(low, high, taken):
    """Also beyond the limits of the file, as the question may be where they should be; but not
    beyond a whole turn.
    """
    robot, text = known_robot("hyq"), 'outside the limits of joint "lf_kfe_joint"'
    span = (math.radians(low), math.radians(high))
    for study in (
        lambda: sweep(HYQ, {"lf_kfe_joint": [low, high]}, robot=robot),
        lambda: limits(
            HYQ,
            "lf_kfe_joint",
            IMU,
            0.1,
            joint_range=span,
            strikes=(0.0, 0.0),
            step=0.5,
            robot=robot,
        ),
    ):
        if taken:
            study()
        else:
            with pytest.raises(StudyError, match=text):
                study()


def test_a_sweep_beyond_the_limits_of_the_file_says_so(capfd, tmp_path):
    text = run(
        capfd,
        "sweep",
        "hyq",
        "--contact",
        "lf_foot",
        "--vary",
        "lf_kfe_joint=-150:-10:3",
        "--out",
        tmp_path,
    )
    assert says(text.out + text.err, "lf_kfe_joint", "-150 to -10 deg", "-140 to -20 deg")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "subject", "span", "target"),
    [
        (HYQ, "mass:trunk", (20.0, 90.0), "shock@trunk_imu"),
        (
            dataclasses.replace(HYQ, **STIFF),
            "contact-stiffness",
            (1e4, 2e5),
            "peak_acceleration@trunk_imu",
        ),
        (HYQ, "base-pitch", (-0.4, 0.4), "shock@trunk_imu"),
        (HYQ, "speed", (0.5, 2.0), "delta_v@trunk_imu"),
    ],
)
def test_other_variations_have_limits_too(base, subject, span, target):
    """Ends are where a sweep of the same quantity, row by row, meets the bound."""
    robot = known_robot("hyq")
    given = {
        "joint_range": span,
        "strikes": (0.0, 0.0),
        "robot": robot,
        "step": (span[1] - span[0]) / 8,
    }
    bound = (
        float(np.median(limits(base, subject, target, 1.0, **given).scan.at_scene_strike)) * 1.001
    )
    found = limits(base, subject, target, bound, **given)
    size = math.degrees(1.0) if found.unit == "rad" else 1.0
    ends = ends_at_the_bound(found.limits[-1])
    assert ends
    table = sweep(
        base, {subject: [size * end for end in ends]}, robot=robot, quantities=[target], prove=0
    ).table
    np.testing.assert_allclose(table.values(table.column(target)), bound, rtol=1e-5)


@pytest.mark.parametrize(
    ("subject", "text"),
    [
        ("strike-angle", "limits are found over strike angles"),
        ("contact", "contacts have names, which have no order"),
    ],
)
def test_what_has_no_limits(subject, text):
    with pytest.raises(StudyError, match=text):
        limits(HYQ, subject, IMU, 0.1, joint_range=(0.0, 1.0), robot=known_robot("hyq"))


def test_a_loop_is_followed_to_its_last_digit():
    """A last step below the tolerance closes what is open by little more; the loop is not refused
    for it.
    """
    base = dataclasses.replace(
        scene("five_bar"), posture=Posture(joints_deg={"front_hip": 62.0, "rear_hip": -60.0})
    )
    landing = resolve(base, robot_of(base))
    joint, held = landing.robot.joint("front_hip"), fixed_joints(landing.robot, base.posture, ())
    for value in np.radians(np.linspace(62.0, 62.5, 200)):
        q = landing.q.copy()
        set_joints(landing.robot, [(joint, value)], q)
        assert joint.value(
            follow(landing.robot, landing.q, q, landing.loops, landing.plane, held)
        ) == pytest.approx(value, abs=1e-12)


@pytest.mark.slow
def test_a_loop_is_followed_as_in_a_sweep():
    """Limits and sweep have one number for one landing, here of Cassie, whose rods let several
    joints move with the knee.
    """
    robot = str(Path(__file__).parents[1] / "robots" / "cassie.xml")
    base, value = Scene(robot=robot, contact=(Contact(frame="left-toe"),)), -138.2
    span = (math.radians(value), math.radians(-136.0))
    found = limits(
        base, "knee_left", "shock_com@cassie-pelvis", 0.01, joint_range=span, strikes=(0.0, 0.0)
    )
    row = sweep(base, {"knee_left": value}, quantities=["shock_com@cassie-pelvis"], prove=0).table
    swept = next(x[0] for name, x in row.columns.items() if name.startswith("shock_com"))
    assert found.scan.at_scene_strike[0] == pytest.approx(swept, rel=1e-12)


@pytest.mark.parametrize(
    "strike", [Strike(velocity=(0.6, 0.3, -0.9)), Strike(drop_height=0.2, forward_speed=0.7)]
)
def test_a_sweep_turns_every_strike_as_limits_do(strike):
    """The part of the velocity in the plane turns, and the vertical one stays after a fall; the
    rows are those of an analysis.
    """
    base, angles = dataclasses.replace(HYQ, strike=strike, point=(IMU,)), [-10.0, 0.0, 25.0]
    swept = sweep(
        base,
        {"strike-angle": angles},
        robot=known_robot("hyq"),
        quantities=["shock@trunk_imu"],
        prove=0,
    )
    table = swept.table
    plane = resolve(base, known_robot("hyq")).plane
    given = strike.vector(plane)
    for row, angle in enumerate(np.radians(angles)):
        down = -given[2] if strike.drop_height else math.hypot(given[0], given[2]) * math.cos(angle)
        turned = Strike(velocity=(down * math.tan(angle), given[1], -down))
        expected = shock_profile(dataclasses.replace(base, strike=turned), known_robot("hyq"))
        assert swept.landings.case(row)[0].plane == "xz"
        assert table.columns["shock@trunk_imu"][row] == pytest.approx(
            expected.points[0].shock, rel=1e-10
        )


def test_rows_that_rounding_may_change_are_counted(tmp_path):
    """In double precision a shin of 1e9 kg m² loses the digits of the others; no row is proven."""
    (tmp_path / "stick.urdf").write_text(STICK.replace('izz="0.0002"', 'izz="2e9"', 1))
    foot = (Contact(frame="foot"),)
    stick = Scene(robot=str(tmp_path / "stick.urdf"), contact=foot, joints=Joints(model="free"))
    found = limits(stick, "knee", "shock_com@body", 0.2, step=0.5)
    assert found.scan.inaccurate > 0.9 * len(found.scan.values)
    assert says(limits_report(found).warnings, f"{found.scan.inaccurate} of", "ill-conditioned")


def test_limits_are_given_at_both_ends_of_the_drives(capfd):
    """At the limit of an end, the landing whose drives have these inertias has a shock that is the
    bound.
    """
    words = (
        "limits",
        "go2",
        "--contact",
        "FL_foot",
        "--joint",
        "FL_calf_joint",
        "--at",
        "imu",
        "--max",
        "0.1",
    )
    text = good(capfd, *words)
    assert says(text, "as modelled: -84.7 to -50.82 deg at the scene's strike angle")
    assert says(text, "largest inertias: -84.7 to -67.1 deg at the scene's strike angle")
    given = Scene(robot="go2", contact=(Contact(frame="FL_foot"),), point=(Point(frame="imu"),))
    robot = robot_of(given)
    found = limits(
        given, "FL_calf_joint", Point(frame="imu"), 0.1, strikes=(0.0, 0.0), robot=robot
    ).ends["largest"]
    (limit,) = ends_at_the_bound(found.limits[0])
    landing = resolve(
        dataclasses.replace(
            given, posture=Posture(joints_deg={"FL_calf_joint": math.degrees(limit)})
        ),
        robot,
    )
    model = landing.joint_model
    (point,) = profile_of(with_inertias(landing, model.high - model.armature)).points
    assert point.shock == pytest.approx(0.1, rel=1e-6)
    assert "drives: " not in good(capfd, *words, "--joints", "free"), "the drives are known"
    assert not limits(
        given,
        "armature:FL_calf_joint",
        Point(frame="imu"),
        0.1,
        joint_range=(0.005, 0.05),
        robot=robot,
    ).ends
