"""The range of a number over the drives: the law by full solutions, its ends by all corners and by
draws, and what has none.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from shockpc import load_robot
from shockpc.core.drive_box import DriveBox
from shockpc.evaluation.drive_ends import at_drive_ends
from shockpc.evaluation.named_scenes import with_default_landings
from shockpc.impact.drive_response import with_inertias
from shockpc.judgement import drive_range
from shockpc.judgement.drive_range import deciding_joints, range_of
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene import Contact, Part, Point, Scene
from shockpc.landing.scenes.scene_file import robot_of
from shockpc.profile import profile_of, profile_of_scene
from shockpc.quantities.selection import select

ARM = """<robot name="mono">
<link name="trunk"><inertial><origin xyz="0 0 0.1"/><mass value="4"/>
<inertia ixx="0.03" iyy="0.04" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="thigh"><inertial><origin xyz="0 0 -0.1"/><mass value="0.6"/>
<inertia ixx="0.002" iyy="0.002" izz="0.0003" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="shank"><inertial><origin xyz="0 0 -0.1"/><mass value="0.3"/>
<inertia ixx="0.001" iyy="0.001" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="toe"/><link name="imu"/>
<joint name="hip" type="revolute"><parent link="trunk"/><child link="thigh"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.5" effort="20" velocity="10"/></joint>
<joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/><origin xyz="0 0 -0.2"/><axis xyz="0 1 0"/>
<limit lower="-2.5" upper="0" effort="20" velocity="10"/></joint>
<joint name="tip" type="fixed"><parent link="shank"/><child link="toe"/><origin xyz="0 0 -0.2"/></joint>
<joint name="imuj" type="fixed"><parent link="trunk"/><child link="imu"/><origin xyz="0.02 0 0.15"/></joint></robot>"""


class _Dense:
    """A robot of random numbers that strikes with three rows: an oracle that solves the whole of
    Eq. 4 for each set of drives.
    """

    def __init__(self, rng, n):
        nv = n + 6
        A = rng.normal(size=(nv, nv))
        self.H, self.J = A @ A.T / nv + 0.1 * np.eye(nv), rng.normal(size=(3, nv))
        self.b, self.point, self.n = self.J @ rng.normal(size=nv), rng.normal(size=(3, nv)), n
        self.armature = rng.uniform(0.0, 1.0, n)

    def solved(self, inertias):
        """Jumps and impulses; an infinite inertia holds its joint by a row of its own."""
        H, held = self.H.copy(), np.flatnonzero(np.isinf(inertias))
        for i, d in enumerate(inertias):
            H[6 + i, 6 + i] += d if np.isfinite(d) else 0.0
        J = np.vstack([self.J, np.eye(len(H))[6 + held]])
        b = np.concatenate([self.b, np.zeros(len(held))])
        whole = np.block([[H, J.T], [J, np.zeros((len(J), len(J)))]])
        return np.linalg.solve(whole, np.concatenate([np.zeros(len(H)), -b]))[: len(H)]

    def value(self, inertias):
        return float(np.linalg.norm(self.point @ self.solved(inertias)))

    def box(self, low, high):
        """The box, the number and its response, as a landing gives them."""
        H = self.H + np.diag(np.concatenate([np.zeros(6), self.armature]))
        X = np.linalg.solve(H, self.J.T)
        C = np.linalg.inv(H) - X @ np.linalg.solve(self.J @ X, X.T)
        x = self.solved(self.armature)
        mobility = np.diagonal(np.linalg.inv(H))[6:]
        box = DriveBox(C[6:, 6:], x[6:], low - self.armature, high - self.armature, mobility)
        return box, self.point @ x, self.point @ C[:, 6:]


def _random_box(rng, dense):
    low, high = (
        dense.armature * rng.uniform(0.0, 1.0, dense.n),
        dense.armature * rng.uniform(1.0, 4.0, dense.n),
    )
    low[rng.random(dense.n) < 0.3], high[rng.random(dense.n) < 0.3] = 0.0, np.inf
    return low, high


@pytest.mark.parametrize("seed", range(6))
def test_another_inertia_is_one_line_of_the_same_solution(seed):
    """Y + B w is the full solution with other inertias, less or more, and with joints that are
    held.
    """
    rng = np.random.default_rng(seed)
    dense = _Dense(rng, 5)
    box, Y, B = dense.box(*_random_box(rng, dense))
    for _ in range(8):
        inertias = dense.armature * rng.uniform(0.0, 3.0, 5)
        inertias[rng.random(5) < 0.3] = np.inf
        found = np.linalg.norm(Y + B @ box.impulses(inertias - dense.armature))
        assert found == pytest.approx(dense.value(inertias), rel=1e-9)


@pytest.mark.parametrize("climbed", [False, True], ids=["all corners", "climbed"])
def test_the_largest_is_at_a_corner_and_the_smallest_below_every_draw(climbed, monkeypatch):
    """Of 15 boxes no draw is above the largest corner, which nearly every climb finds, by full
    solutions.
    """
    monkeypatch.setattr("shockpc.core.drive_box.ALL_CORNERS", 0 if climbed else 8)
    missed, lower = 0, 0
    for seed in range(15):
        rng = np.random.default_rng(seed)
        dense = _Dense(rng, 4)
        low, high = _random_box(rng, dense)
        box, Y, B = dense.box(low, high)
        corners = max(
            dense.value(np.array(corner))
            for corner in itertools.product(*zip(low, high, strict=True))
        )
        smallest, largest = (dense.value(dense.armature + change) for change in box.lengths(Y, B))
        top = np.where(np.isinf(high), 1e3, high)
        draws = [dense.value(low + rng.random(4) ** 3 * (top - low)) for _ in range(100)]
        assert max(draws) <= corners * (1.0 + 1e-9)
        assert largest <= corners * (1.0 + 1e-9)
        missed += largest < corners * (1.0 - 1e-9)
        lower += min(draws) < smallest * (1.0 - 1e-3)
    assert missed <= climbed
    assert lower <= 1


def test_a_component_has_both_ends_at_corners():
    """A component with its sign is affine in each drive."""
    rng = np.random.default_rng(3)
    dense = _Dense(rng, 4)
    low, high = _random_box(rng, dense)
    box, Y, B = dense.box(low, high)
    corners = [
        (dense.point[:1] @ dense.solved(np.array(c)))[0]
        for c in itertools.product(*zip(low, high, strict=True))
    ]
    for change, wanted in zip(box.values(Y[:1], B[:1]), (min(corners), max(corners)), strict=True):
        assert (dense.point[:1] @ dense.solved(dense.armature + change))[0] == pytest.approx(
            wanted, rel=1e-9
        )


def test_contacts_that_need_a_joint_leave_it_free():
    """Of joints that the contacts drive all cannot be held: the corner is left out, and no false
    number comes of it.
    """
    J = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]])
    H, b = np.diag([1.0, 2.0, 3.0]), np.array([1.0, 0.0])
    X = np.linalg.solve(H, J.T)
    C, x = np.linalg.inv(H) - X @ np.linalg.solve(J @ X, X.T), -X @ np.linalg.solve(J @ X, b)
    box = DriveBox(C, x, np.zeros(3), np.full(3, np.inf), 1.0 / np.diagonal(H))
    assert np.isinf(box.most).tolist() == [True, False, False]
    # With one joint held the rows decide all: −1 or 0, 0 or −1, 1 or 0.
    assert np.abs(x + C @ box.impulses(box.lengths(x[1:2], C[1:2])[1]))[1] == pytest.approx(
        1.0, rel=1e-9
    )


def test_a_joint_whose_hold_makes_a_number_zero_is_held_in_spite_of_rounding():
    """The number is zero where the only joint is held: there the inverse of its inertia is zero up
    to rounding.
    """
    rng = np.random.default_rng(0)
    for _ in range(60):
        C, x, B = rng.uniform(0.5, 2.0, (1, 1)), rng.normal(size=1), rng.normal(size=(3, 1))
        box = DriveBox(C, x, np.zeros(1), np.array([np.inf]), np.diagonal(C))
        (change,) = box.lengths(B @ x / C[0], B)[0]
        assert change > 1e12


@pytest.fixture(scope="module")
def a1():
    part = Part(name="board", at="imu_link", critical_velocity_change=0.2)
    return profile_of_scene(
        Scene(robot="a1", contact=(Contact(frame="FL_foot"),), pulse="half-sine:5ms", part=(part,))
    )


def _place(profile, kind, name):
    return next(place for place in profile.places(kind) if place.name == name)


@pytest.mark.parametrize(
    ("metric", "kind", "name"),
    [
        ("shock", "point", "imu_link"),
        ("peak_g", "point", "imu_link"),
        ("delta_v.z", "point", "imu_link"),
        ("part_margin", "part", "board"),
        ("joint_impulse", "joint", "FL_hip_joint"),
        ("delta_qd", "joint", "FL_calf_joint"),
        ("impulse", "contact", "FL_foot"),
        ("total_moment", "robot", "a1"),
    ],
)
def test_numbers_of_a_landing_follow_without_solving_again(a1, metric, kind, name):
    """At the ends of a range, and anywhere, a number is that of the landing resolved with these
    inertias.
    """
    landing, selection, place = a1.landing, select(metric), _place(a1, kind, name)
    rng = np.random.default_rng(1)
    ((_, ends),) = drive_range._searched(landing, selection, [place])
    some = np.where(
        landing.joint_model.unknown, rng.uniform(0.0, 0.05, landing.robot.model.nv), 0.0
    )
    for change in (*(change for change, _ in ends), some):
        (anew,) = drive_range._values_of(with_inertias(landing, change), selection, [place])
        ((read,),) = drive_range._followed(landing, selection, [place], [change])
        assert read == pytest.approx(anew, rel=1e-8, abs=1e-11)
    found, value = range_of(a1, selection, place), a1.numbers(selection, [place])[0]
    assert found.kind == "corners"
    assert found.smallest <= value <= found.largest


def test_what_a_robot_with_unknown_drives_may_show(a1):
    """The struck leg's drives decide whether a1's IMU feels 0.0009 or 0.71; the margin is its
    inverse.
    """
    place = _place(a1, "point", "imu_link")
    shock = range_of(a1, select("shock"), place)
    assert (shock.smallest, shock.largest) == (
        pytest.approx(8.657e-4, rel=1e-3),
        pytest.approx(0.7145, rel=1e-3),
    )
    assert set(deciding_joints(a1, select("shock"), place)) <= {
        "FL_hip_joint",
        "FL_thigh_joint",
        "FL_calf_joint",
    }
    margin = range_of(a1, select("part_margin"), _place(a1, "part", "board"))
    assert (margin.smallest, margin.largest) == (
        pytest.approx(0.2 / shock.largest),
        pytest.approx(0.2 / shock.smallest),
    )


def test_neither_free_nor_locked_joints_bound_a_shock(tmp_path):
    """go1 on a hind foot has more than with locked joints, an arm less than with free ones."""
    scene = Scene(robot="go1", contact=(Contact(frame="RR_foot"),), joints={"drives": "none"})
    landing = landing_of(scene, robot_of(scene))
    driven = landing.robot.actuated_dofs
    unknown = landing.joint_model._replace(high=np.where(driven, np.inf, 0.0))
    profile = profile_of(replace(landing, joint_model=unknown))
    place = _place(profile, "point", "imu_link")
    found, locked = (
        range_of(profile, select("shock"), place),
        profile.numbers(select("shock_locked"), [place])[0],
    )
    assert locked == pytest.approx(0.8731, abs=1e-4)
    assert found.largest == pytest.approx(1.0346, abs=1e-4)
    (tmp_path / "arm.urdf").write_text(ARM)
    scene = Scene(
        robot=str(tmp_path / "arm.urdf"),
        contact=(Contact(frame="toe"),),
        point=(Point(frame="imu"),),
    )
    profile = profile_of_scene(replace(scene, posture={"joints_deg": {"hip": 60.0, "knee": -80.0}}))
    place = _place(profile, "point", "imu")
    found = range_of(profile, select("shock"), place)
    values = []
    for armature in (1e-5, 1e-4, 3e-4, 1e-3, 1e-2, 0.1, 1.0):
        other = replace(profile.scene, joints={"armature": {"*": float(armature)}})
        values.append(profile_of_scene(other, profile.robot).numbers(select("shock"), [place])[0])
    assert profile.numbers(select("shock"), [place])[0] == pytest.approx(0.0158, abs=1e-4)
    assert min(values) < 0.01335
    assert found.smallest <= min(values)
    assert max(values) <= found.largest


def test_effective_masses_only_grow_with_inertia(a1):
    """Those of 40 random sets of armatures lie between those of free and of locked joints, which
    are the ends.
    """
    selection, place, rng = (
        select("effective_mass"),
        a1.places("contact")[0],
        np.random.default_rng(2),
    )
    found, nv = range_of(a1, selection, place), a1.robot.model.nv
    assert found.kind == "exact"
    assert found.smallest == pytest.approx(a1.effective_mass, rel=1e-9)
    for _ in range(40):
        change = np.where(a1.landing.joint_model.unknown, np.exp(rng.uniform(-9.0, 0.0, nv)), 0.0)
        (mass,) = drive_range._values_of(with_inertias(a1.landing, change), selection, [place])
        assert found.smallest < mass < found.largest


def test_ranges_of_several_sensors_are_those_of_each_and_follow_from_the_jumps(a1):
    """Peaks of sensors at samples of the drives are those of landings resolved with these; so are
    motions, all at once.
    """
    share, scene = (
        select("range_share"),
        replace(a1.scene, range_g=16.0, point=(Point(frame="FL_calf"), Point(frame="trunk"))),
    )
    for given in (
        {"pulse": "half-sine:5ms"},
        {"contact_stiffness": 1e6},
        {"pulse": "half-sine:5ms", "friction": 0.3},
    ):
        profile = profile_of_scene(replace(scene, **given), a1.robot)
        landing, places = profile.landing, profile.places("point")
        searched, found = (
            drive_range._searched(landing, share, places),
            drive_range.ranges_of(profile, share, places),
        )
        for place, (kind, ends), ranges in zip(places, searched, found, strict=True):
            anew = [
                drive_range._values_of(with_inertias(landing, change), share, [place])[0]
                for change, _ in ends
            ]
            assert [value for _, value in ends] == pytest.approx(anew, rel=1e-8)
            assert (kind, len(ends) >= 2) == ("samples", True)
            alone = range_of(profile_of_scene(replace(scene, **given), a1.robot), share, place)
            assert alone[:2] == pytest.approx(ranges[:2], rel=1e-9)


def test_what_every_drive_decides_has_a_range_of_samples(a1):
    """Numbers of another kind are computed anew at some corners, and all where end stops act; the
    words are in the range.
    """
    assert range_of(a1, select("shock_max"), _place(a1, "body", "base")).kind == "samples"
    stopped = profile_of_scene(replace(a1.scene, stops=True), a1.robot)
    place = _place(stopped, "point", "imu_link")
    found = range_of(stopped, select("shock"), place)
    assert found.kind == "samples"
    assert found.smallest <= 8.7e-4
    assert found.largest >= 0.7


def test_another_face_of_a_sole_makes_a_range_one_of_samples():
    """G1's sole carries with an edge where its joints are stiff: its range has what locked joints
    give with their own face.
    """
    landing = landing_of(
        Scene(robot="g1", contact=(Contact(frame="left_ankle_roll_link"),)), load_robot("g1")
    )
    model = landing.joint_model
    wide = model._replace(
        low=0.0 * model.low, high=np.where(landing.robot.actuated_dofs, np.inf, 0.0)
    )
    profile = profile_of(replace(landing, joint_model=wide))
    place = profile.bracketed[1]
    found, narrow = (
        range_of(one, select("shock"), place) for one in (profile, profile_of(landing))
    )
    locked = profile.numbers(select("shock_locked"), [place])[0]
    assert (found.kind, narrow.kind) == ("samples", "corners")
    assert found.smallest <= narrow.smallest
    assert locked == pytest.approx(found.largest, rel=0.2)
    assert locked <= found.largest


def test_no_range_where_drives_are_given_or_do_not_count(a1):
    """Exact drives, free joints, points fixed to the world and numbers of other joint models have
    none.
    """
    place = _place(a1, "point", "imu_link")
    free = profile_of_scene(replace(a1.scene, joints={"model": "free"}), a1.robot)
    assert range_of(free, select("shock"), place) is None
    assert deciding_joints(free, select("shock"), place) == ()
    assert range_of(a1, select("shock_locked"), place) is None
    assert range_of(a1, select("data_sensitivity"), place) is None


@pytest.mark.parametrize("name", ["a1", "go1", "cassie", "panda"])
def test_the_scenes_of_both_ends_are_landings_with_these_inertias(name):
    """Scenes state what changed joint models do: of held joints, rotors that links carry, springs,
    fingers.
    """
    robot = robot_of(Scene(robot=name))
    (scene, *_) = with_default_landings({"": Scene(robot=name)}, robot).values()
    landing = landing_of(scene, robot)
    model = landing.joint_model
    changes = {"smallest": model.low - model.armature, "largest": model.high - model.armature}
    found = at_drive_ends(
        profile_of(landing),
        {"": (scene, robot)},
        lambda scenes: profile_of_scene(scenes[""], robot),
    )
    assert list(found) == ["smallest", "largest"]
    for end, change in changes.items():
        expected = profile_of(with_inertias(landing, change)).value("shock_com", "body")
        np.testing.assert_allclose(
            found[end].value("shock_com", "body"), expected, rtol=1e-12, atol=1e-15
        )
        if not np.any(change):
            continue  # which is the landing as modelled
        again = at_drive_ends(None, {"": (found[end].scene, robot)}, lambda scenes: None)
        assert again == {}, "the drives of an end are known"
