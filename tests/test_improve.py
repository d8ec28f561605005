"""Improving: optima that are known, brute force, and what the study says of its optimum; the cost
as optimisers take it.
"""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
from commands import run, says
from identify_draws import LEG
from robot_texts import LIMIT, joint, link, urdf
from scipy.optimize import minimize
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Point,
    Posture,
    Scene,
    ShockCost,
    SolveError,
    Strike,
    StudyError,
    improve,
    resolve,
    shock_maps,
    shock_profile,
    symbolic,
)
from shockpc.evaluation.column import ground_columns
from shockpc.evaluation.evaluate import Evaluation
from shockpc.landing.scenes.scene_file import read_scene
from shockpc.studies.improve.report import improve_report
from shockpc.studies.improve.search import RUNS, search


def anymal(restitution=0.0, **changes):
    return Scene(
        robot="anymal_b", contact=(Contact(frame="LF_FOOT", restitution=restitution),), **changes
    )


@pytest.fixture(autouse=True)
def few_runs(monkeypatch):
    """Of a few joints, four runs find the optimum that eighty find."""
    monkeypatch.setattr("shockpc.studies.improve.search.RUNS", 4)


LEGS = [("LF_HFE", "0:70"), ("LF_KFE", "-120:-20")]


def worst_by_grid(cost, n):
    """The smallest worst value over n × n points that meet the constraints."""
    axes = [np.linspace(*span, n) for span in cost.bounds]
    X = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    worst, allowed = worst_and_allowed(cost, X)
    return np.where(allowed, worst, np.inf).min()


def worst_and_allowed(cost, X):
    """The worst measure (m,) at points, and whether the constraints hold."""
    measures = cost.measured(X)
    return measures[:, ~cost.constraints].max(axis=1), (measures[:, cost.constraints] >= 0.0).all(
        axis=1
    )


def test_a_rod_is_struck_at_its_centre_of_percussion():
    """A free slender rod that is struck across at 2/3 of its length does not move at its other end."""
    robot = known_robot("beam")
    (body,) = robot.bodies
    scene = Scene(robot="beam", contact=(Contact(frame="tip"),))
    found = improve(
        scene,
        "shock@pivot",
        vary={"offset-x": "-0.9:-0.05"},
        robot=robot,
        any_ground=True,
        starts=1,
    )
    lever = body.com[0] - robot.frame("pivot").offset[0]
    assert found.values[1] < 1e-9
    assert 1.0 + found.x[0] == pytest.approx(
        lever + body.inertia[1, 1] / (body.mass * lever), abs=1e-9
    )
    assert "nothing" in improve_report(found).text("table")


def test_two_links_by_brute_force():
    robot = known_robot("leg")
    scene = Scene(
        robot="leg", contact=(Contact(frame=robot.links[-1]),), strike=Strike(strike_angle_deg=20.0)
    )
    vary = [(name, "-60:60") for name in robot.joint_names[:1]] + [("base-pitch", "-40:40")]
    found = improve(scene, "shock@upper_leg", vary=vary, robot=robot, any_ground=True)
    assert found.values[1] <= worst_by_grid(found.cost, 200) * (1.0 + 1e-9)


def test_anymal_against_a_grid_of_maps():
    """The trunk's IMU over HFE and KFE, 40 000 postures by `shock_maps`, for two strikes."""
    robot = known_robot("anymal_b")
    angles = (-15.0, 20.0)
    scenes = {f"{angle:g} deg": anymal(strike=Strike(strike_angle_deg=angle)) for angle in angles}
    found = improve(scenes, "shock@imu_link", vary=LEGS, robot=robot, any_ground=True)
    landing = resolve(scenes["20 deg"], robot)
    hfe, knee = (np.radians(np.linspace(*span, 200)) for span in found.cost.bounds)
    Q = np.repeat(landing.q[None], 200 * 200, axis=0)
    Q[:, robot.joint("LF_HFE").q.start], Q[:, robot.joint("LF_KFE").q.start] = (
        np.repeat(hfe, 200),
        np.tile(knee, 200),
    )
    strikes = [(np.sin(np.radians(a)), 0.0, -np.cos(np.radians(a))) for a in angles]
    grid = shock_maps(landing, Q).worst("imu_link", strikes).shock.min()
    optimum = found.values[1]
    assert optimum <= grid * (1.0 + 1e-9)
    assert optimum == pytest.approx(grid, rel=0.1)  # which lies between points of the grid
    assert max(one.points[0].shock for one in found.after.values()) == pytest.approx(
        optimum, rel=1e-14
    )


@pytest.mark.slow
@pytest.mark.parametrize("any_ground", [False, True])
def test_never_worse_than_random_landings_and_the_same_from_another_seed(any_ground):
    """2 000 random landings; on any ground all of them are allowed."""
    robot = known_robot("anymal_b")
    scenes = {f"e = {e}": anymal(restitution=e) for e in (0.0, 0.3)}
    vary = [*LEGS, ("LF_HAA", "-25:25"), ("base-pitch", "-15:15"), ("strike-angle", "0:25")]
    how = {"vary": vary, "robot": robot, "any_ground": any_ground, "starts": 8}
    first = improve(scenes, "shock@imu_link", seed=0, **how)
    if not any_ground:  # as its constraints make local optima
        other = improve(scenes, "shock@imu_link", seed=1, **how)
        assert other.values[1] == pytest.approx(first.values[1], abs=1e-5)
    cost = first.cost
    X = cost.bounds[:, 0] + np.random.default_rng(5).random((2_000, len(vary))) * np.ptp(
        cost.bounds, axis=1
    )
    random, allowed = worst_and_allowed(cost, X)
    assert allowed.sum() == 2_000 if any_ground else allowed.sum() > 10
    assert first.values[1] <= random[allowed].min()
    assert cost.feasible(first.x)
    ground = [
        profile.value("feasible", "robot")[0] + profile.value("feasible_if_tilted", "robot")[0]
        for profile in first.after.values()
    ]
    assert any_ground or ground == [1.0] * len(ground)


@pytest.mark.slow
def test_a_constraint_holds_the_optimum_and_is_named():
    robot, scene = known_robot("anymal_b"), anymal()
    free = improve(scene, "shock@imu_link", vary=LEGS, robot=robot, starts=2)
    names = [place.name for place in free.after[""].places("joint")]
    load = free.after[""].value("joint_impulse", "joint")[names.index("LF_KFE")]
    limit = 0.9 * load
    held = improve(
        scene,
        "shock@imu_link",
        vary=LEGS,
        robot=robot,
        starts=2,
        keep=[f"joint_impulse@LF_KFE<={float(limit)!r}"],
    )
    assert held.after[""].value("joint_impulse", "joint")[names.index("LF_KFE")] <= limit
    assert held.values[1] >= free.values[1]
    exactly = improve(
        scene,
        "shock@imu_link",
        vary={"LF_HFE": "40:50"},
        robot=robot,
        starts=0,
        keep="depth_below_contacts<=0",
        any_ground=True,
    )
    assert (
        exactly.after[""].value("depth_below_contacts", "robot")[0] == 0.0
    )  # which is never below zero
    with pytest.raises(StudyError, match="no point meets the constraints"):
        improve(
            scene,
            "shock@imu_link",
            vary={"LF_KFE": "-60:-50"},
            robot=robot,
            starts=0,
            keep=["joint_impulse@LF_KFE<=1e-3"],
        )


@pytest.mark.parametrize("limit", ["joint_impulse@LF_KFE<=1e-3", "peak_force@LF_FOOT<=1"])
def test_a_run_that_cannot_meet_its_constraints_ends_soon(monkeypatch, limit):
    """One that no posture meets, and a number that has no value anywhere; SLSQP would compute a
    thousand points.
    """
    cost, points, linearized = (
        ShockCost(anymal(), "shock@imu_link", LEGS, known_robot("anymal_b"), keep=limit),
        [],
        ShockCost.linearized,
    )
    monkeypatch.setattr(
        ShockCost, "linearized", lambda cost, X: points.append(X) or linearized(cost, X)
    )
    (run_,) = search(cost, [cost.x0])
    assert run_.value == np.inf
    assert len(points) < 100


@pytest.mark.parametrize(
    ("quantity", "variables"),
    [
        ("mitigation@LF_FOOT", LEGS),
        (
            "shock@imu_link:0.1,0.02,0",
            [
                ("*_HFE", "-60:60"),
                ("base-pitch", "-20:20"),
                ("base-roll", "-20:20"),
                ("strike-angle", "0:30"),
            ],
        ),
        ("delta_qd@LF_KFE", [*LEGS, ("base-yaw", "-40:40")]),
        ("joint_impulse@LF_KFE", LEGS),
        (
            "shock@imu_link",
            [("mass:*_SHANK", "0.8x:1.2x"), ("LF_KFE", "-120:-20"), ("speed", "0.5:2")],
        ),
        ("ropc@base", [("armature:*_KFE", "0.01:0.1"), ("place:LF_KFE", "0.8x:1.2x")]),
    ],
)
def test_the_gradient_of_a_cost_is_that_of_differences(quantity, variables):
    cost = ShockCost(
        anymal(strike=Strike(strike_angle_deg=10.0)), quantity, variables, known_robot("anymal_b")
    )
    x = np.clip(
        cost.x0, *(cost.bounds.T + 0.1 * np.ptp(cost.bounds, axis=1) * np.array([[1], [-1]]))
    )
    for k, (low, high) in enumerate(cost.bounds):
        h = 1e-4 * (high - low)
        steps = [cost(x + s * h * np.eye(len(x))[k]) for s in (2, 1, -1, -2)]
        slope = (-steps[0] + 8 * steps[1] - 8 * steps[2] + steps[3]) / (12 * h)
        assert cost.gradient(x)[k] * (high - low) == pytest.approx(
            slope * (high - low), rel=1e-6, abs=1e-7
        )


def test_heights_and_pulls_are_the_same_landing_by_landing_as_in_many_postures():
    """No table lists these quantities, so that they are not to be looked up in one."""
    robot = known_robot("anymal_b")
    of_many = ShockCost(anymal(), "shock@imu_link", LEGS, robot)
    # The force on contacts of finite stiffness is computed in one landing at a time.
    of_one = ShockCost(anymal(contact_stiffness=1e5), "peak_force@LF_FOOT", LEGS, robot)
    X = of_many.x0 + np.array([[0.0, 0.0], [5.0, -5.0]])
    constraints = of_one.measured(X)[:, 1:]
    assert constraints.shape[1] > 10
    np.testing.assert_allclose(constraints, of_many.measured(X)[:, 1:], rtol=1e-9)


@pytest.mark.slow
def test_the_gradient_of_a_cost_is_that_of_symbols():
    cost = ShockCost(anymal(), "shock@imu_link", LEGS, known_robot("anymal_b"), ground=False)
    symbols, x = (
        symbolic(anymal(), ["shock@imu_link"], robot=known_robot("anymal_b")),
        cost.x0 + 3.0,
    )
    landing = resolve(cost.scene(x), known_robot("anymal_b"))
    slope = symbols.gradient(landing.q[None], landing.before.velocity)["shock@imu_link"][0]
    wanted = [np.radians(slope[landing.robot.joint(name).v.start]) for name in ("LF_HFE", "LF_KFE")]
    np.testing.assert_allclose(cost.gradient(x), wanted, rtol=1e-9)


@pytest.mark.parametrize("feet", [("LF_FOOT",), ("LF_FOOT", "RH_FOOT")])
def test_the_slopes_of_all_terms_are_those_of_differences(feet):
    """Of several points at once: numbers, impulses of the ground, clearances, and the difference in
    height of two feet.
    """
    robot = known_robot("anymal_b")
    scenes = {
        f"{a} deg": Scene(
            robot="anymal_b",
            contact=tuple(Contact(frame=foot) for foot in feet),
            strike=Strike(strike_angle_deg=a),
        )
        for a in (-10.0, 15.0)
    }
    vary = [
        *LEGS,
        ("RF_HAA", "-30:30"),
        ("RH_KFE", "20:120"),
        ("base-pitch", "-20:20"),
        ("base-roll", "-20:20"),
    ]
    cost = ShockCost(scenes, "shock@imu_link", vary, robot, keep=["delta_qd@RH_KFE<=30"])
    assert cost.exact
    assert {term.column.selection.name for term in cost.terms} >= {
        "shock",
        "push",
        "clearance",
        *(["spread"] if feet[1:] else []),
    }
    width = np.ptp(cost.bounds, axis=1)
    X = cost.bounds[:, 0] + width * np.random.default_rng(3).random((4, len(vary)))
    measures, found = cost.linearized(X)
    np.testing.assert_allclose(measures, cost.measured(X), rtol=1e-12)
    for k, h in enumerate(1e-5 * width):
        up, down = (cost.measured(X + s * h * np.eye(len(vary))[k]) for s in (1.0, -1.0))
        np.testing.assert_allclose(
            found[:, :, k], (up - down) / (2.0 * h), rtol=1e-6, atol=1e-7 / width[k]
        )


def test_an_optimum_stands_on_its_feet_with_its_trunk_clear_of_the_ground():
    """Go2's optimum lay with its trunk 5 mm below its feet, which the ground's tolerance allows of
    feet alone.

    The slopes of how far the centre of mass is beside the feet are those of differences.
    """
    robot, scene = (
        known_robot("go2"),
        Scene(robot="go2", contact=tuple(Contact(frame=f"{leg}_foot") for leg in ("FL", "RR"))),
    )
    vary = {joint: "-60:100" for joint in robot.joint_names if joint.endswith("_thigh_joint")} | {
        "FR_hip_joint": "-40:40"
    }
    vary |= {"*_calf_joint": "-156:-50"}
    found = improve(scene, "shock@imu", vary=vary, robot=robot, starts=3)
    assert [
        warning for warning in found.after[""].health.warnings if warning.kind == "standing"
    ] == []
    cost = found.cost
    limits = {
        term.column.place.name: term.limit
        for term in cost.terms
        if term.column.selection.name == "clearance"
    }
    assert limits["base"] == limits["FR_thigh"] == -limits["FR_calf"] == scene.ground_tolerance
    width = np.ptp(cost.bounds, axis=1)
    X = cost.bounds[:, 0] + width * np.random.default_rng(2).random((20, len(width)))
    (k,) = [k for k, term in enumerate(cost.terms) if term.column.selection.name == "overhang"]
    slopes = cost.linearized(X)[1][:, k]
    for j, h in enumerate(1e-6 * width):
        up, down = (cost.measured(X + s * h * np.eye(len(width))[j])[:, k] for s in (1.0, -1.0))
        np.testing.assert_allclose(slopes[:, j], (up - down) / (2.0 * h), rtol=0.0, atol=1e-8)


def test_any_number_of_points_is_linearized_at_once():
    """More configurations beside the points than the engine computes in one chunk."""
    cost = ShockCost(
        anymal(),
        "shock@imu_link",
        [*LEGS, ("base-pitch", "-20:20")],
        known_robot("anymal_b"),
        ground=False,
    )
    X = cost.bounds[:, 0] + np.random.default_rng(1).random((2800, 3)) * np.ptp(cost.bounds, axis=1)
    for part, last in zip(cost.linearized(X), cost.linearized(X[-1:]), strict=True):
        np.testing.assert_allclose(part[-1:], last, rtol=1e-12)


def test_slopes_of_a_robot_without_geometry():
    """Relative to the velocity of the centre of mass, which is that of the strike."""
    robot = robot_from(
        urdf(
            link("a"),
            link("b"),
            joint("j", "a", "b", axis="0 1 0", more='<origin xyz="0.1 0 -.2"/>' + LIMIT),
        )
    )
    scene = Scene(
        robot=robot.label,
        contact=(Contact(frame="b", offset=(0.1, 0.0, -0.2)),),
        v_in="com",
        strike=Strike(strike_angle_deg=10.0),
    )
    cost = ShockCost(scene, "shock_com@a", {"j": "-60:60"}, robot)
    assert cost.exact
    slope = (cost([20.0 + 1e-3]) - cost([20.0 - 1e-3])) / 2e-3
    np.testing.assert_allclose(cost.gradient([20.0]), slope, rtol=1e-7)


@pytest.mark.slow
def test_twelve_joints_have_the_same_optimum_from_every_seed(monkeypatch):
    """ANYmal B on each of its feet, five strike angles; many local optima lie within 20 % of the
    smallest.
    """
    monkeypatch.setattr("shockpc.studies.improve.search.RUNS", RUNS)
    robot = known_robot("anymal_b")
    vary = dict[str, str]()
    for leg, sign in (("LF", 1), ("RF", 1), ("LH", -1), ("RH", -1)):
        ends = [(-30, 30), *(sorted((sign * a, sign * b)) for a, b in ((0, 70), (-110, -20)))]
        vary |= {
            f"{leg}_{joint}": f"{low}:{high}"
            for joint, (low, high) in zip(("HAA", "HFE", "KFE"), ends, strict=True)
        }
    scenes = {
        foot: Scene(robot="anymal_b", contact=(Contact(frame=foot),))
        for foot in ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
    }
    first, other = (
        improve(
            scenes,
            "shock@imu_link",
            robot=robot,
            vary=vary,
            over={"strike-angle": "-20:20:5"},
            seed=seed,
        )
        for seed in (0, 1)
    )
    assert other.values[1] == pytest.approx(first.values[1], rel=1e-5)
    assert first.values[1] < 5.04e-4


@pytest.mark.slow
def test_a_foot_whose_sole_has_no_shapes_has_the_same_optimum_from_every_seed():
    """Where its geometry reaches too far below the sole, it does not count as the contact: its
    height above the contact jumps.
    """
    robot, scene = (
        known_robot("talos"),
        Scene(robot="talos", contact=(Contact(frame="left_sole_link"),)),
    )
    first, other = (
        improve(scene, "shock@imu_link", robot=robot, seed=seed, starts=8) for seed in (0, 1)
    )
    assert other.values[1] == pytest.approx(first.values[1], rel=1e-4)
    assert any(
        "lowest point above the contact at left_sole_link >=" in text for text in first.active
    )


@pytest.mark.parametrize("feet", [("left_sole_link",), ("left_sole_link", "right_sole_link")])
@pytest.mark.slow
def test_constraints_of_the_ground_are_those_of_feasible(feet):
    """In random postures of a robot whose soles have no shapes; their slopes are those of
    differences.
    """
    robot = known_robot("talos")
    scene = Scene(robot="talos", contact=tuple(Contact(frame=foot) for foot in feet))
    vary = {
        "leg_left_4_joint": "20:80",
        "leg_left_5_joint": "-40:40",
        "base-pitch": "-20:20",
        "base-roll": "-20:20",
    }
    cost = ShockCost(scene, "shock@imu_link", vary, robot)
    width = np.ptp(cost.bounds, axis=1)
    X = cost.bounds[:, 0] + width * np.random.default_rng(0).random((2000, len(vary)))
    allowed = Evaluation(
        cost.groups[0].at(X), ground_columns(cost.groups[0].first), prove=0
    ).table.feasible
    # A link without a foot has to keep clear by the ground's tolerance, of which `feasible` only
    # allows the other side.
    held = worst_and_allowed(cost, X)[1]
    clearances = np.array([term.column.selection.name == "clearance" for term in cost.terms])
    close = (
        cost.measured(X)[:, clearances].min(axis=1)
        > -2.0 * scene.ground_tolerance / cost.groups[0].first.length
    )
    np.testing.assert_array_equal(held[~close], allowed[~close])
    assert not (held & ~allowed).any()
    assert 5 < held.sum() < 1900
    _, found = cost.linearized(X[:5])
    chosen = [k for k, term in enumerate(cost.terms) if term.column.selection.name == "reach"]
    for k, h in enumerate(1e-6 * width):
        up, down = (cost.measured(X[:5] + s * h * np.eye(len(vary))[k]) for s in (1.0, -1.0))
        np.testing.assert_allclose(
            found[:, chosen, k], ((up - down) / (2.0 * h))[:, chosen], rtol=0, atol=1e-8
        )


def test_a_cost_goes_into_scipy_in_two_lines():
    cost = ShockCost(anymal(), "shock@imu_link", LEGS, known_robot("anymal_b"))
    result = minimize(cost, cost.x0, jac=cost.gradient, bounds=cost.bounds)
    assert result.fun < cost(cost.x0)
    posture = cost.scene(result.x).posture.joints_deg
    assert posture["LF_KFE"] == pytest.approx(result.x[1])
    assert shock_profile(cost.scene(result.x)).points[0].shock == pytest.approx(
        result.fun, rel=1e-9
    )


def test_a_cost_can_be_sent_to_other_processes():
    """As optimisers do that evaluate points side by side."""
    cost = ShockCost(
        anymal(),
        "shock@imu_link",
        LEGS,
        known_robot("anymal_b"),
        keep="joint_impulse@LF_KFE<=1.2",
        ground=False,
    )
    sent, x = pickle.loads(pickle.dumps(cost)), np.array([40.0, -60.0])
    assert (sent(x), sent.names, sent.feasible(x)) == (cost(x), cost.names, cost.feasible(x))


@pytest.mark.slow
def test_the_command_writes_the_optimum(tmp_path, capfd):
    words = (
        "improve",
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--at",
        "imu_link",
        "--vary",
        "LF_HFE=0:70",
        "--vary",
        "LF_KFE=-120:-20",
        "--starts",
        "1",
        "--out",
        tmp_path / "out",
    )
    assert run(capfd, *words, "--over", "strike-angle=-10,10").code == 0
    document = json.loads((tmp_path / "out" / "improve.json").read_text())
    files = sorted((tmp_path / "out").glob("optimum-*.toml"))
    assert len(files) == 2
    shocks = [shock_profile(read_scene(file)).points[0].shock for file in files]
    (number,) = document["tables"]["quantities"]
    assert max(shocks) == pytest.approx(number["optimum"], rel=1e-12)
    assert number["optimum"] < number["as_given"]
    assert all(
        (tmp_path / "out" / f"{name}.svg").stat().st_size > 1e4 for name in ("compare", "runs")
    )
    assert run(capfd, *words).code == 0
    assert [file.name for file in (tmp_path / "out").glob("optimum-*.toml")] == ["optimum-1.toml"]


def test_one_of_several_points_has_to_be_named():
    points = Point(frame="imu_link"), Point(frame="LF_HIP")
    with pytest.raises(StudyError, match="several points: imu_link, LF_HIP; name one"):
        improve(anymal(point=points), vary=LEGS, robot=known_robot("anymal_b"))


@pytest.mark.slow
def test_what_cannot_be_improved_says_so(capfd):
    robot = known_robot("anymal_b")
    for quantity, vary, text in (
        ("v_in", LEGS, "neither better nor worse"),
        ("shock@imu_link", [("contact", "*_FOOT")], "has no range"),
        ("shock@imu_link", [("LF_KFE", "-50,-50")], "has no range"),
        ("error_bound@base", LEGS, "cannot be followed"),
        ("peak_force@LF_FOOT", LEGS, "peak force at LF_FOOT has no value"),
        ("shock@imu_link", [*LEGS, ("friction", "0.2:0.8")], "would change nothing here"),
    ):
        with pytest.raises(StudyError, match=text):
            improve(anymal(), quantity, vary=vary, robot=robot)
    with pytest.raises(StudyError, match="would change nothing here"):
        improve(anymal(friction=0.5), "shock@imu_link", vary=LEGS, robot=robot)
    with pytest.raises(SolveError, match="no mass or inertia resists it"):
        improve(Scene(robot="icub", contact=(Contact(frame="l_foot"),)), robot=known_robot("icub"))
    with pytest.raises(StudyError, match="name a variable with --vary"):
        improve(
            Scene(robot="cassie", contact=(Contact(frame="left-foot"),)),
            robot=known_robot("cassie"),
        )
    cassie = Scene(robot="cassie", contact=(Contact(frame="left-foot"),))
    impulse = "joint_impulse@knee_left"  # of which redundant loops leave one part undetermined
    for quantity, keep in ((impulse, []), ("shock@imu", [f"{impulse}<=2"])):
        with pytest.raises(
            StudyError, match=r"through knee_left has no value .* is not determined"
        ):
            improve(
                cassie,
                quantity,
                vary={"knee_left": "-110:-50"},
                keep=keep,
                robot=known_robot("cassie"),
                starts=0,
            )
    feet = tuple(Contact(frame=foot) for foot in ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"))
    with pytest.raises(StudyError, match=r"LF_FOOT.*not determined.*--any-ground"):
        improve(
            Scene(robot="anymal_b", contact=feet, joints=Joints(model="locked")),
            vary={"speed": "1:2"},
            robot=robot,
            starts=0,
        )
    with pytest.raises(StudyError, match="never below zero"):
        improve(anymal(), "shock@imu_link", vary=LEGS, robot=robot, keep=["delta_qd@LF_KFE<=-3"])
    with pytest.raises(StudyError, match="strike-angle is in both"):
        improve(
            anymal(),
            "shock@imu_link",
            vary={"strike-angle": "0:20"},
            over={"strike-angle": "0,10"},
            robot=robot,
        )
    with pytest.raises(StudyError, match="is not KEY@PLACES<=LIMIT"):
        improve(anymal(), "shock@imu_link", vary=LEGS, robot=robot, keep=["joint_impulse@LF_KFE=2"])


def test_a_number_of_either_sign_is_less_where_its_size_is():
    robot, vary = known_robot("anymal_b"), [("LF_HFE", "0:70"), ("LF_KFE", "-120:-20")]
    found = improve(anymal(), "delta_qd@LF_KFE", vary=vary, robot=robot, any_ground=True, starts=2)
    before, after = found.values
    assert abs(after) < abs(before)
    assert "better than the optimum" not in improve_report(found).text("table")


def test_the_best_of_many_points_is_improved_even_beside_the_landing_as_given():
    """A knee whose shock has a narrow minimum near the landing as given, which its own run leaves."""
    scene = anymal(posture=Posture(joints_deg={"LF_HFE": 34.4, "LF_KFE": -81.1}))
    found = improve(
        scene,
        "shock@imu_link",
        vary={"LF_KFE": "-120:-20"},
        robot=known_robot("anymal_b"),
        any_ground=True,
    )
    dense = found.cost.measured(np.linspace(-120.0, -20.0, 10_001)[:, None])[
        :, ~found.cost.constraints
    ].max(axis=1)
    assert found.values[1] <= dense.min()


def test_landings_in_different_postures_have_no_single_value_as_given():
    scenes = {f"{a}": anymal(posture=Posture(joints_deg={"LF_KFE": a})) for a in (-74.2, -60.0)}
    found = improve(
        scenes,
        "shock@imu_link",
        vary={"LF_KFE": "-62:-58"},
        robot=known_robot("anymal_b"),
        any_ground=True,
    )
    assert np.isnan(found.variables[0].before)
    assert np.isnan(found.variables[0].set_back)


def test_joints_of_over_are_no_variables():
    """Patterns count as the joints that they mean."""
    robot = known_robot("anymal_b")
    found = improve(anymal(), robot=robot, over={"*_KFE": "-70,-60"}, any_ground=True, starts=1)
    assert [one.subject for one in found.cost.variations] == ["LF_HAA", "LF_HFE"]
    with pytest.raises(StudyError, match="LF_KFE is in both"):
        improve(anymal(), vary={"LF_KFE": "-100:-50"}, robot=robot, over={"*_KFE": "-70,-60"})


@pytest.mark.slow
def test_variables_by_default_are_those_of_all_landings():
    found = improve(
        anymal(),
        robot=known_robot("anymal_b"),
        over={"contact": "LF_FOOT,RH_FOOT"},
        any_ground=True,
        starts=1,
    )
    assert {one.subject[:2] for one in found.cost.variations} == {"LF", "RH"}
    scenes = {f"{a}": anymal(posture=Posture(joints_deg={"LF_KFE": a})) for a in (-74.2, -60.0)}
    found = improve(scenes, robot=known_robot("anymal_b"), any_ground=True, starts=1)
    assert found.cost.bounds[2] == pytest.approx([-74.2 - 45.0, -74.2 + 45.0])


def test_what_changes_nothing_stays_as_given():
    """A common factor of all masses, and turning the robot about the vertical below a vertical
    strike.
    """
    for vary in ({"mass:*": "0.5x:1.5x"}, {"base-yaw": "-180:180"}):
        found = improve(
            anymal(), "shock@imu_link", vary=vary, robot=known_robot("anymal_b"), starts=1
        )
        np.testing.assert_array_equal(found.x, found.cost.x0)
        assert "no point is better" in improve_report(found).text("table")


def test_a_variable_that_changes_nothing_stays_as_given():
    """Of several, those that matter alone change."""
    vary = {"base-yaw": "-180:180", "speed": "0.5:2", "LF_KFE": "-120:-20"}
    found = improve(
        anymal(),
        "shock@imu_link",
        vary=vary,
        robot=known_robot("anymal_b"),
        any_ground=True,
        starts=3,
    )
    np.testing.assert_array_equal(found.x[:2], [0.0, 1.0])
    assert found.values[1] < 0.01 * found.values[0]


def test_what_each_variable_does():
    """Set back to its value as given, also outside its range; and up to where the target is 5 %
    worse, by a dense scan.
    """
    robot = known_robot("anymal_b")
    found = improve(
        anymal(),
        "shock@imu_link",
        vary={"LF_HFE": "45:70", "*_KFE": "-60:-20"},
        robot=robot,
        any_ground=True,
    )
    (hfe, knees), cost = found.variables, found.cost
    assert hfe.set_back == pytest.approx(cost(np.array([cost.given[0], found.x[1]])), rel=1e-9)
    assert np.isnan(knees.before)
    assert np.isnan(knees.set_back)
    for k, one in enumerate(found.variables):
        X = np.repeat(found.x[None], 4001, axis=0)
        X[:, k] = np.linspace(*cost.bounds[k], 4001)
        near = cost.measured(X)[:, ~cost.constraints].max(axis=1) <= 1.05 * cost(found.x)
        step = np.ptp(cost.bounds[k]) / 4000
        run = np.flatnonzero(near)
        assert (near[run.min() : run.max() + 1]).all()
        assert one.low == pytest.approx(X[run.min(), k], abs=3 * step)
        assert one.high == pytest.approx(X[run.max(), k], abs=3 * step)


def test_friction_counts_where_the_scene_has_it():
    """A foot that slides: the cost is the shock with friction, and one of contacts that stick is
    refused.
    """
    robot, scene = known_robot("anymal_b"), anymal(friction=0.3)
    cost = ShockCost(scene, "shock_friction@imu_link", LEGS, robot)
    x = np.array([45.0, -60.0])
    assert cost(x) == pytest.approx(
        shock_profile(cost.scene(x), robot).value("shock_friction", "point")[0], rel=1e-9
    )
    with pytest.raises(StudyError, match="would change nothing here"):
        ShockCost(scene, "shock@imu_link", LEGS, robot)
    found = improve(
        replace(scene, point=(Point(frame="imu_link"),)), vary=LEGS[:1], robot=robot, starts=0
    )
    assert found.values[1] < found.values[0]
    assert says(improve_report(found).text("table"), "accuracy", "in double precision")


def test_ranges_without_the_landing_as_given_are_named():
    """Any reflected inertia of the knees is worse than none, which the landing as given has."""
    vary = {"armature:*_KFE": "0.01:0.1"}
    found = improve(anymal(), "shock@imu_link", vary=vary, robot=known_robot("anymal_b"), starts=0)
    assert found.values[1] > found.values[0]
    assert says(
        improve_report(found).text("table"), "better than the optimum", "outside", "armature:*_KFE"
    )


def test_joints_that_differ_as_given_and_have_one_value_are_named():
    """ANYmal B stands with its front and hind knees bent opposite ways, which no common angle does."""
    vary = {"*_KFE": "-30:-20"}
    found = improve(
        anymal(),
        "shock@imu_link",
        vary=vary,
        robot=known_robot("anymal_b"),
        starts=0,
        any_ground=True,
    )
    assert found.values[1] > found.values[0]
    assert says(
        improve_report(found).text("table"), "better than the optimum", "differ", "*_KFE [deg]"
    )


def test_a_gradient_counts_end_stops():
    """A knee that is bent to its end stop, which the impact would bend further."""
    robot = known_robot("go2")
    bent = Posture(joints={"FL_calf_joint": robot.joint("FL_calf_joint").limits[0]})
    scene = Scene(robot="go2", contact=(Contact(frame="FL_foot"),), stops=True, posture=bent)
    cost, h = (
        ShockCost(scene, "shock@imu", {"FL_thigh_joint": "-40:120", "base-pitch": "-20:20"}, robot),
        1e-3 * np.eye(2),
    )
    slope = [(cost(cost.x0 + step) - cost(cost.x0 - step)) / 2e-3 for step in h]
    np.testing.assert_allclose(cost.gradient(cost.x0), slope, rtol=1e-5)


def test_a_singular_posture_has_the_gradient_of_differences():
    """Contacts at a hip and the trunk, whose distance the hip does not change as it stands: six
    rows, of which five count.
    """
    contacts = tuple(
        Contact(frame=frame, at="frame") for frame in ("root_joint", "FR_thigh_shoulder")
    )
    scene = Scene(robot="laikago", contact=contacts)
    cost = ShockCost(
        scene, "shock_com@FR_hip", {"base-roll": "-30:10"}, known_robot("laikago"), ground=False
    )
    slope = (cost([-9.999]) - cost([-10.001])) / 2e-3
    assert cost.exact
    assert abs(slope) > 1e-4
    assert cost.gradient([-10.0])[0] == pytest.approx(slope, rel=1e-6)


def test_landings_on_a_rail_have_speeds_of_their_own():
    """A leg that falls along a joint of its file, from two heights: its base does not move before
    the impact, the joint does.
    """
    robot = robot_from(LEG)
    scenes = {
        f"{h} m": Scene(
            robot=robot.label, contact=(Contact(frame="foot"),), strike=Strike(drop_height=h)
        )
        for h in (0.2, 0.5)
    }
    cost = ShockCost(scenes, "delta_qd@knee", {"knee": "-90:-10"}, robot, ground=False)
    for angle in (-50.0, -20.0):
        profiles = [shock_profile(*case) for case in cost.cases(np.array([angle])).values()]
        knee = [place.name for place in profiles[0].places("joint")].index("knee")
        values = [abs(profile.value("delta_qd", "joint")[knee]) for profile in profiles]
        assert values[0] < 0.9 * values[1]
        assert cost([angle]) == pytest.approx(max(values), rel=1e-9)


def test_points_that_are_none_say_so():
    cost = ShockCost(anymal(), "shock@imu_link", LEGS, known_robot("anymal_b"))
    for x in ([1.0], [[1.0, 2.0]], ["low", "high"], None):
        with pytest.raises(StudyError, match=r"x has shape .*; give 2 values"):
            cost(x)
    assert cost([np.nan, -50.0]) == np.inf
    assert np.isnan(cost.gradient([np.nan, -50.0])).all()
    assert not cost.feasible([np.nan, -50.0])
    for landings in ([anymal()], None):
        with pytest.raises(StudyError, match="it has to be Scene"):
            ShockCost(landings, "shock@imu_link", LEGS)
    for quantity in (None, 3, [None]):
        with pytest.raises(StudyError, match="it has to be str"):
            ShockCost(anymal(), quantity, LEGS)


def test_what_is_not_said_is_the_imu_and_the_leg():
    """Without a quantity and variables: the shock at the IMU, or at the trunk's centre of mass,
    over the joints of the leg.
    """
    found = improve(anymal(), robot=known_robot("anymal_b"), starts=0)
    assert found.cost.quantity == "shock@imu_link"
    assert [one.subject for one in found.cost.variations] == ["LF_HAA", "LF_HFE", "LF_KFE"]
    np.testing.assert_allclose(
        found.cost.bounds - found.cost.given[:, None], [[-45.0, 45.0]] * 3, rtol=1e-12
    )
    assert says(
        improve_report(found).text("table"),
        "by default",
        "shock@imu_link",
        "LF_HAA, LF_HFE, LF_KFE",
    )
    named = improve(
        anymal(point=(Point(frame="LF_HIP"),)),
        vary=LEGS[:1],
        robot=known_robot("anymal_b"),
        starts=0,
    )
    assert named.cost.quantity == "shock@LF_HIP"
    assert "by default" not in improve_report(named).text("table")
    leg = known_robot("leg")
    found = improve(
        Scene(robot="leg", contact=(Contact(frame=leg.links[-1]),)),
        robot=leg,
        starts=0,
        any_ground=True,
    )
    assert found.cost.quantity == f"shock_com@{leg.bodies[0].name}"
    assert found.values[1] <= found.values[0]


@pytest.mark.slow
def test_a_landing_as_given_without_a_value_is_no_measure():
    """A contact that would have to be pulled needs no friction that is a number: 5 % are then those
    of the optimum.
    """
    posture = Posture(joints_deg={"LF_HAA": -60.0, "LF_HFE": 80.0, "LF_KFE": -30.0})
    found = improve(
        anymal(posture=posture, strike=Strike(strike_angle_deg=80.0)),
        "friction_needed@LF_FOOT",
        robot=known_robot("anymal_b"),
        vary={"strike-angle": "-80:80", "LF_HFE": "0:90"},
        any_ground=True,
    )
    assert np.isnan(found.values[0])
    assert all(one.high - one.low < 1.0 for one in found.variables)
    assert "as given     the number has no value" in improve_report(found).text("table")


def test_an_optimum_is_given_at_both_ends_of_the_drives(capfd):
    """Nobody knows the drives of A1: the ends are free and locked joints, stated apart here."""
    free, leg = (
        Scene(robot="a1", contact=(Contact(frame="FL_foot"),)),
        {"FL_thigh_joint": "0:70", "FL_calf_joint": "-120:-55"},
    )
    locked = replace(free, joints=Joints(model="locked"))
    study, stated = (improve(landing, "shock@imu_link", vary=leg) for landing in (free, locked))
    assert not stated.ends
    (given, after), end = stated.values, study.ends["largest"]
    assert end.given == pytest.approx(given, rel=1e-12)
    assert end.best == pytest.approx(after, rel=1e-6)
    assert end.there == pytest.approx(ShockCost(locked, "shock@imu_link", leg)(study.x), rel=1e-9)
    assert study.ends["smallest"].best == study.ends["smallest"].there == study.values[1], (
        "free joints are what is modelled"
    )
    words = (
        "improve",
        "a1",
        "--contact",
        "FL_foot",
        "--vary",
        "FL_thigh_joint=0:70",
        "--vary",
        "FL_calf_joint=-120:-55",
    )
    text = run(capfd, *words).out
    assert says(
        text,
        "largest drives",
        f"{end.given:.4g} → {end.there:.4g} at this optimum; {end.best:.4g} at the best",
    )
    assert says(text, "number or variable", "as modelled", "smallest", "largest")
    assert "largest drives" not in run(capfd, *words, "--joints", "free").out
