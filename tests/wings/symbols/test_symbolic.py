"""A landing in symbols: against balls, against maps in doubles, and its gradients against
differences and derivatives in balls.
"""

import subprocess
import sys

import casadi
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import LIMIT, joint, link, urdf
from test_derivatives import IN_SERIES, in_balls, on
from trees import known_robot, robot_from

from shockpc import (
    Contact,
    Joints,
    Scene,
    SceneError,
    SolveError,
    Strike,
    StudyError,
    resolve,
    shock_maps,
    symbolic,
)
from shockpc.method.exact.arithmetic import NoValueError
from shockpc.profile import ILL_CONDITIONED, profile_of
from shockpc.quantities.selection import QUANTITIES, WITHOUT_SYMBOLS
from shockpc.text.cache import cache_folder
from shockpc.wings.symbols.casadi_functions import compiled_program
from shockpc.wings.symbols.programs import OPERATIONS, Program
from shockpc.wings.symbols.symbolic import SymbolicLanding
from shockpc.wings.symbols.symbols import SymbolImpact

MOVING = Strike(
    strike_angle_deg=20.0, angular_velocity=(0.2, -0.4, 0.1), joint_velocities={"LF_KFE": 1.5}
)

LANDINGS = {
    "one foot, moving": on("anymal_b", "LF_FOOT", at="frame", strike=MOVING),
    "two feet, geared": on(
        "anymal_b", "LF_FOOT", "RH_FOOT", at="frame", joints=Joints(armature={"*_KFE": 0.05})
    ),
    "base in the plane, locked": on(
        "anymal_b",
        "LF_FOOT",
        base="planar",
        at="frame",
        directions=("x", "z"),
        joints=Joints(locked=("*_HAA", "RH*")),
    ),
    "sliding": on("hyq", "lf_foot", at="frame", directions=("z",), stance=()),
    "followers": on("panda", "panda_leftfinger", at="frame"),
    "several joints of one body": on(IN_SERIES, "shank", at="frame"),
    "rotors that links carry": on(
        "solo8",
        "FL_FOOT",
        at="frame",
        kind="point",
        strike=Strike(joint_velocities={"FL_KFE": 1.5}),
    ),
}


def landing_of(name):
    scene = LANDINGS[name]
    return resolve(
        scene,
        robot_from(IN_SERIES, ".xml") if scene.robot == IN_SERIES else known_robot(scene.robot),
    )


def postures(landing, n, size=0.3):
    robot, rng = landing.robot, np.random.default_rng(1)
    Q = np.array(
        [
            pin.integrate(robot.model, landing.q, size * rng.standard_normal(robot.model.nv))
            for _ in range(n)
        ]
    )
    for q in Q:
        robot.set_followers(q)
    return Q


@pytest.mark.slow
@pytest.mark.parametrize("name", LANDINGS)
def test_every_quantity_is_that_of_balls_or_refused(name):
    landing = landing_of(name)
    q, before = casadi.SX.sym("q", landing.robot.model.nq), casadi.SX.sym("before", 3)
    impact, asked, values, refused = SymbolImpact.of(landing, q, before), [], [], set()
    for entry in QUANTITIES:
        places = [
            place for place in landing.places(entry.of) if place.body >= 0 or entry.of != "point"
        ]
        if entry.computation.postures != "many" or not places or entry.of == "part":
            continue
        try:
            values.append(np.asarray(entry.compute(impact, places), dtype=object).ravel())
            asked.append((entry, places))
        except NoValueError:
            refused.add(entry.key)
    assert refused <= WITHOUT_SYMBOLS
    flat = [getattr(value, "e", value) for part in values for value in part]
    program, _ = compiled_program(
        (q, before), casadi.densify(casadi.vertcat(*map(casadi.SX, flat)))
    )
    Q = postures(landing, 2)
    found = program(np.concatenate([Q, np.tile(landing.before.velocity, (2, 1))], axis=1))
    for k, q in enumerate(Q):
        profile, start = profile_of(landing.at(q)), 0
        for entry, places in asked:
            wanted = np.asarray(profile.value(entry.key, entry.of, places), dtype=float)
            here = found[k, start : start + wanted.size].reshape(wanted.shape)
            start += wanted.size
            known = np.isfinite(wanted)
            size = np.abs(wanted[known]).max(initial=1e-3)
            np.testing.assert_allclose(
                here[known], wanted[known], rtol=1e-9, atol=1e-10 * size, err_msg=entry.key
            )


@pytest.mark.slow
@pytest.mark.parametrize("name", LANDINGS)
def test_gradients_are_those_of_five_point_differences(name):
    landing = landing_of(name)
    body = landing.robot.bodies[-1].name
    symbols = SymbolicLanding(landing, [f"shock_com@{body}", f"copc@{body}"])
    Q, strike, nv = postures(landing, 2, 0.1), np.array([0.3, 0.1, -1.0]), landing.robot.model.nv
    values, slopes = symbols.slopes(Q, strike)
    h, weights = 2e-4, np.array([-1.0, 8.0, -8.0, 1.0]) / 12.0
    steps = h * np.array([2.0, 1.0, -1.0, -2.0])[:, None, None] * np.eye(nv + 3)
    moved = np.array(
        [
            pin.integrate(landing.robot.model, q, step)
            for q in Q
            for step in steps[..., :nv].reshape(-1, nv)
        ]
    )
    beside = symbols.value(moved, np.tile(strike + steps[..., nv:].reshape(-1, 3), (2, 1)))
    for key, found in slopes.items():
        slope = (
            np.tensordot(weights, beside[key].reshape(2, 4, nv + 3, *values[key].shape[1:]), (0, 1))
            / h
        )
        atol = 1e-8 * np.nanmax(np.abs(found), initial=1e-3)
        np.testing.assert_allclose(np.moveaxis(found, -1, 1), slope, rtol=0, atol=atol, err_msg=key)


@pytest.mark.slow
def test_gradient_in_balls():
    landing = landing_of("two feet, geared")
    found = SymbolicLanding(landing, ["delta_v@RF_SHANK"]).gradient(
        landing.q[None], (0.0, 0.0, 1.0)
    )["delta_v@RF_SHANK"][0]
    body = [body.name for body in landing.robot.bodies].index("RF_SHANK")
    R, jump = landing.state.rotation[0, body], profile_of(landing).proof.jumps[body, 3:, 2]
    for k in (5, 8, 17):
        turn = R.T @ landing.state.J[0, :3, k] * landing.robot.ancestors[body, k]
        # in axes that turn
        exact = R.T @ in_balls(landing, landing.q, k, 1e-4)[body, 3:, 2] - np.cross(turn, jump)
        np.testing.assert_allclose(found[:, k], exact, rtol=0, atol=1e-9 * np.abs(found).max())


def test_whole_velocities_before_the_impact():
    landing, rng = landing_of("two feet, geared"), np.random.default_rng(0)
    Q, qd = postures(landing, 3), rng.standard_normal((3, landing.robot.model.nv))
    found = SymbolicLanding(landing, ["delta_qd", "impulse", "shock@imu_link"], "velocity").value(
        Q, qd
    )
    maps = shock_maps(landing, Q)
    jumps, impulse = maps.joint_jumps(qd), maps.impulse(qd)
    for k, name in enumerate(landing.robot.joint_names[-12:]):
        np.testing.assert_allclose(found[f"delta_qd@{name}"], jumps[:, 6 + k], rtol=0, atol=1e-11)
    for k, place in enumerate(landing.contact_places):
        np.testing.assert_allclose(
            found[f"impulse@{place.name}"],
            impulse[:, k],
            rtol=0,
            atol=1e-11 * np.abs(impulse).max(),
        )


def test_nothing_strikes_at_rest():
    """Such a motion is refused; where joints move and contacts do not, what is divided by their
    speed has no value.
    """
    limbs = (joint(f"to {name}", "trunk", name, more=LIMIT) for name in ("leg", "arm"))
    robot = robot_from(urdf(*map(link, ("trunk", "leg", "arm")), *limbs))
    landing = resolve(
        Scene(robot=robot.label, contact=(Contact(frame="leg", offset=(0.1, 0.0, -0.3)),)), robot
    )
    Q = np.tile(landing.q, (2, 1))
    for strike in (np.zeros(3), [1e-200, 0.0, 0.0]):
        with pytest.raises(SceneError, match="strike is zero"):
            SymbolicLanding(landing, ["delta_v@trunk"]).value(Q, strike)
    moved = np.eye(8)[robot.joint("to arm").v.start]
    symbols = SymbolicLanding(landing, ["shock@trunk", "delta_v@trunk"], "velocity")
    with pytest.raises(SceneError, match="velocity is zero in row 1"):
        symbols.gradient(Q, np.stack([moved, 0.0 * moved]))
    found, slopes = symbols.value(Q, moved), symbols.gradient(Q, moved)
    assert np.isnan(found["shock@trunk"]).all()
    assert not found["delta_v@trunk"].any()
    assert np.isnan(slopes["shock@trunk"]).any(axis=1).all()


@pytest.mark.parametrize("base", ["free", "fixed", "planar"])
@pytest.mark.slow
def test_condition_tells_every_posture_that_is_off(base):
    scene = on(
        "anymal_b",
        "LF_FOOT",
        at="frame",
        base=base,
        **({"directions": ("x", "z")} if base == "planar" else {}),
    )
    landing = resolve(scene, known_robot("anymal_b"))
    n, knee = 400, landing.robot.joint("LF_KFE")
    Q = np.tile(landing.q, (n, 1))
    # a leg that is stretched is singular where the base is held
    Q[:, knee.q.start] = np.geomspace(1e-9, 1.0, n)
    found, maps = SymbolicLanding(landing, ["shock_com@LF_SHANK"]).value(Q), shock_maps(landing, Q)
    exact = [
        profile_of(landing.at(q)).shock_com[3] if maps.condition[k] < 1e13 else np.nan
        for k, q in enumerate(Q)
        if not k % 40
    ]
    error = np.abs(found["shock_com@LF_SHANK"][::40] / exact - 1.0)
    assert (error[found["condition"][::40] < ILL_CONDITIONED] < 1e-9).all()
    ratio = found["condition"] / maps.condition
    assert ((ratio > 0.02) & (ratio < 50.0)).all()
    assert ((found["pivot"] <= 1.0 + 1e-12) & (found["pivot"] > 0.0)).all()


def test_what_no_program_can_say_is_refused_by_name():
    refused = [
        (on("cassie", "left-foot"), "closed by a loop"),
        (on("go2", "FL_foot", at="lowest"), "--offset"),
        (on("anymal_b", "LF_FOOT", at="frame", friction=0.5), "friction"),
        (on("anymal_b", "LF_FOOT", at="frame", contact_stiffness=1e5), "contact stiffness"),
        (on("anymal_b", "LF_FOOT", at="frame", stops=True), "end stops"),
        (
            on(
                "anymal_b",
                "LF_FOOT",
                "LH_FOOT",
                "RF_FOOT",
                at="frame",
                joints=Joints(model="locked"),
            ),
            "are dependent",
        ),
    ]
    for scene, words in refused:
        with pytest.raises(SceneError, match=words):
            symbolic(scene, robot=known_robot(scene.robot))
    massless = robot_from(
        urdf(
            link("l0"),
            link("l1"),
            link("l2", "0", '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'),
            joint("j0", "l0", "l1", more=LIMIT),
            joint("j1", "l1", "l2", more=LIMIT),
        )
    )
    with pytest.raises(SolveError, match="l2"):
        SymbolicLanding(
            resolve(
                Scene(robot=massless.label, contact=(Contact(frame="l1", at="frame"),)), massless
            ),
            ["v_in"],
        )
    landing = landing_of("one foot, moving")
    for quantity in (
        "most_severe@imu_link",
        "shock_max@base",
        "effective_mass",
        "feasible",
        "shock_free@imu_link",
        "bits",
    ):
        with pytest.raises(StudyError, match=quantity.split("@")[0]):
            SymbolicLanding(landing, [quantity])
    with pytest.raises(StudyError, match="shock@PLACE"):
        SymbolicLanding(landing, [])
    with pytest.raises(StudyError, match="peak_g"):
        SymbolicLanding(landing, ["peak_g@imu_link"])


@pytest.mark.slow
def test_programs_are_kept_and_made_again_where_a_file_is_wrong(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    landing = landing_of("sliding")
    first = SymbolicLanding(landing, ["v_in", "shock_com@trunk"])
    (file,) = cache_folder().iterdir()
    monkeypatch.setattr(
        "shockpc.wings.symbols.symbols.traced", lambda *_: pytest.fail("a graph is made again")
    )
    again = SymbolicLanding(landing, ["v_in", "shock_com@trunk"])
    np.testing.assert_array_equal(again.program.operands, first.program.operands)
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    whole = file.read_bytes()
    for wrong in (whole[:1000], whole[:-5] + b"abcde", b""):
        file.write_bytes(wrong)
        SymbolicLanding(landing, ["v_in", "shock_com@trunk"])
        assert file.read_bytes() == whole
    tmp_path.joinpath("shockpc").rename(tmp_path / "kept")
    tmp_path.joinpath("shockpc").write_text("no folder")
    SymbolicLanding(landing, ["v_in", "shock_com@trunk"])


def test_a_changed_robot_has_programs_of_its_own():
    found = []
    for mass in ("1", "2"):
        robot = robot_from(urdf(link("l0"), link("l1", mass), joint("j0", "l0", "l1", more=LIMIT)))
        landing = resolve(
            Scene(robot="leg.urdf", contact=(Contact(frame="l1", at="frame"),)), robot
        )
        found.append(
            SymbolicLanding(landing, ["total_impulse.z"]).value(landing.q[None])[
                f"total_impulse.z@{robot.name}"
            ][0]
        )
    assert found == pytest.approx([2.0, 3.0], rel=0.5)
    assert found[1] - found[0] > 0.5


def test_without_casadi(monkeypatch):
    """What was made before is computed; what has to be made says what to install; and nothing else
    imports it.
    """
    landing = landing_of("sliding")
    before = SymbolicLanding(landing, ["v_in"]).value(landing.q[None])
    monkeypatch.setattr("shockpc.wings.symbols.landing_programs.has_symbols", lambda: False)
    kept = SymbolicLanding(landing, ["v_in"]).value(landing.q[None])
    assert kept["condition"] == pytest.approx(before["condition"], rel=1e-12)
    with pytest.raises(StudyError, match="pip install casadi"):
        SymbolicLanding(landing, ["total_moment"])
    code = (
        "import sys; from shockpc import Contact, Scene, shock_profile; "
        "shock_profile(Scene(robot='solo12', contact=(Contact(frame='FL_FOOT'),))).points; "
        "sys.exit('casadi' in sys.modules)"
    )
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=True)


@pytest.mark.slow
def test_steps_grow_with_the_length_of_a_chain():
    steps = []
    for n in (10, 20):
        joints = (
            joint(
                f"j{k}",
                f"l{k}",
                f"l{k + 1}",
                axis=("0 1 0", "1 0 0")[k % 2],
                more='<origin xyz="0.1 0 0.02"/>' + LIMIT,
            )
            for k in range(n)
        )
        robot = robot_from(urdf(*(link(f"l{k}") for k in range(n + 1)), *joints))
        landing = resolve(
            Scene(robot=robot.label, contact=(Contact(frame=f"l{n}", at="frame"),)), robot
        )
        steps.append(len(SymbolicLanding(landing, ["shock_com@l0"]).program.operation))
    assert steps[1] < 2.3 * steps[0]


def test_the_function_of_casadi_is_the_program():
    landing = landing_of("one foot, moving")
    symbols = SymbolicLanding(landing, ["shock@imu_link", "impulse@LF_FOOT"])
    Q = postures(landing, 3)
    function, found = symbols.casadi(), symbols.value(np.tile(Q, (100, 1)))
    few = symbols.value(Q)
    assert all(
        np.allclose(few[name], found[name][:3], rtol=1e-11, atol=1e-13) for name in symbols.names
    )
    for k, q in enumerate(Q):
        outputs = function(q=q, strike=landing.before.velocity)
        np.testing.assert_allclose(
            outputs["impulse_LF_FOOT"].full()[:, 0], found["impulse@LF_FOOT"][k], rtol=1e-13
        )
        np.testing.assert_allclose(
            float(outputs["shock_imu_link"]), found["shock@imu_link"][k], rtol=1e-13
        )


def test_programs_of_every_operation():
    names = list(OPERATIONS)
    operands = np.array([(0, 1)] * len(names), dtype=np.int32)
    program = Program(
        2,
        np.array([np.nan]),
        np.arange(len(names), dtype=np.uint8),
        operands,
        np.arange(2, 3 + len(names)),
    )
    X = np.random.default_rng(0).uniform(0.1, 2.0, (5000, 2))
    found = program(X)
    assert np.isnan(found[:, 0]).all()
    for k, (name, function) in enumerate(OPERATIONS.items()):
        np.testing.assert_array_equal(found[:, 1 + k], function(*X.T[: function.nin]), err_msg=name)
