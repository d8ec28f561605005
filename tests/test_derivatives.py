"""Derivatives of shock maps by the posture: against balls, central differences and Pinocchio; and
what maps give by name.
"""

import numpy as np
import pinocchio as pin
import pytest
from robot_texts import LIMIT, joint, link, urdf
from trees import known_robot, robot_from

from shockpc import Contact, Joints, Posture, Scene, SceneError, StudyError, resolve, shock_maps
from shockpc.impact.derivatives import derivatives
from shockpc.impact.landed import solved
from shockpc.method.dynamics import dynamics
from shockpc.profile import profile_of
from shockpc.robot.load import load_robot

STRIKE = (0.3, 0.1, -1.0)


def on(robot, *feet, **options):
    """A scene of feet of a robot; options of contacts, and of the scene."""
    contact = {name: options.pop(name) for name in ("kind", "at", "directions") if name in options}
    return Scene(
        robot=robot, contact=tuple(Contact(frame=foot, **contact) for foot in feet), **options
    )


IN_SERIES = """<mujoco><worldbody><body name="trunk" pos="0 0 1"><freejoint/><geom size=".2" mass="3" pos=".05 .1 0"/>
<body name="thigh" pos=".2 0 0"><joint name="pitch" axis="0 1 0"/><joint name="roll" axis="1 0 0" pos=".02 0 .01"/>
<joint name="rail" type="slide" axis="0 0 1"/><geom size=".1" mass="1" pos="0 .03 -.2"/><body name="shank" pos=".05 0 -.4">
<joint name="ball" type="ball"/><geom size=".1" mass=".7" pos=".1 .2 0"/></body></body></body></worldbody></mujoco>"""

LANDINGS = {
    "one foot": on("anymal_b", "LF_FOOT"),
    "two feet, geared": on(
        "anymal_b", "LF_FOOT", "RH_FOOT", joints=Joints(armature={"*_KFE": 0.05})
    ),
    "locked joints": on("anymal_b", "LF_FOOT", "RF_FOOT", joints=Joints(locked=("*_HAA", "RH*"))),
    "all locked, redundant": on(
        "anymal_b", "LF_FOOT", "LH_FOOT", "RF_FOOT", joints=Joints(model="locked")
    ),
    "base in the plane": on("anymal_b", "LF_FOOT", base="planar", directions=("x", "z")),
    "base fixed": on("anymal_b", "LF_FOOT", base="fixed"),
    "sliding": on("anymal_b", "LF_FOOT", directions=("z",)),
    "standing foot": on("hyq", "lf_foot", stance=("rh_foot",)),
    "flat foot": on("talos", "left_sole_link", kind="flat"),
    "lowest point of a sphere": on("go2", "FL_foot", at="lowest"),
    "followers": on("panda", "panda_leftfinger"),
    "loop": on("five_bar", "toe"),
    "two loops and ball joints": on("cassie", "left-foot"),
    "several joints of one body": on(IN_SERIES, "shank", at="lowest", base="planar"),
    "rotors that links carry": on("go1", "FL_foot", "RR_foot", at="frame", kind="point"),
}


def beside(landing, Q, k, steps):
    """Maps, joint jumps and impulses in postures Q moved along velocity k by steps."""
    robot = landing.robot
    unit = np.eye(robot.model.nv)[k]
    moved = np.array([pin.integrate(robot.model, q, h * unit) for h in steps for q in Q])
    state = dynamics(robot, moved, landing.joint_model)
    equation, solution, maps = solved(landing, state, with_strike=False)
    values = maps, equation.full(solution.delta_qd), solution.impulse
    return [value.reshape(len(steps), len(Q), *value.shape[1:]) for value in values]


@pytest.mark.parametrize("name", LANDINGS)
def test_derivatives_are_those_of_central_differences(name):
    scene = LANDINGS[name]
    landing = resolve(
        scene,
        robot_from(IN_SERIES, ".xml") if scene.robot == IN_SERIES else known_robot(scene.robot),
    )
    robot, rng = landing.robot, np.random.default_rng(0)
    nv = robot.model.nv
    Q = np.array(
        [pin.integrate(robot.model, landing.q, 0.05 * rng.standard_normal(nv)) for _ in range(2)]
    )
    equation, solution, _ = solved(
        landing, dynamics(robot, Q, landing.joint_model), with_strike=False
    )
    found = derivatives(landing, equation, solution)
    h, weights = 1e-4, np.array([-1.0, 8.0, -8.0, 1.0]) / 12.0
    for k in range(0, nv, 5 if nv > 30 else 1):
        for derivative, values in zip(
            found, beside(landing, Q, k, h * np.array([2.0, 1.0, -1.0, -2.0])), strict=True
        ):
            slope = np.tensordot(weights, values, 1) / h
            known = np.isfinite(derivative[..., k])  # impulses along redundant rows have none
            assert known.all() or derivative is found.impulse
            size = np.nanmax(np.abs(derivative), initial=1.0)
            np.testing.assert_allclose(
                derivative[..., k][known], slope[known], rtol=0, atol=3e-9 * size
            )


def in_balls(landing, q, k, h):
    """The derivative (nb, 6, 3) of the maps along velocity k from enclosures: central differences
    of the sixth order.
    """
    nv, total = landing.robot.model.nv, 0.0
    for step, weight in ((1, 45.0), (2, -9.0), (3, 1.0)):
        for sign in (1, -1):
            posed = landing.at(
                pin.integrate(landing.robot.model, q, sign * step * h * np.eye(nv)[k])
            )
            jumps = profile_of(posed).proof.jumps[..., :3].reshape(-1, 2, 3, 3)
            total = total + sign * weight / (60.0 * h) * (
                posed.state.rotation[0][:, None] @ jumps
            ).reshape(-1, 6, 3)
    return total


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("one foot", range(3, 9)),
        ("flat foot", (4, 8, 20)),
        ("two feet, geared", (5, 8, 17)),
        ("two loops and ball joints", (9, 12)),
        ("rotors that links carry", (4, 7)),
    ],
)
def test_derivatives_in_balls(name, columns):
    landing = resolve(LANDINGS[name], known_robot(LANDINGS[name].robot))
    found = shock_maps(landing, landing.q[None], derivatives=True).derivatives[0]
    for k in columns:
        exact = in_balls(landing, landing.q, k, 1e-4)
        np.testing.assert_allclose(found[..., k], exact, rtol=0, atol=1e-9 * np.abs(found).max())


def pinocchio_contact(model, name):
    """A contact that sticks, as Pinocchio's impulse dynamics takes it: data of the robot, models,
    their data, and settings.
    """
    frame = model.frames[model.getFrameId(name)]
    contact = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D,
        model,
        frame.parentJoint,
        frame.placement,
        pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    )
    data, models, datas = model.createData(), [contact], [contact.createData()]
    pin.initConstraintDynamics(model, data, models, datas)
    return data, models, datas, pin.ProximalSettings(1e-14, 0.0, 1)


def test_derivatives_of_a_long_chain_are_those_of_pinocchio():
    axes = ("0 1 0", "1 0 0", "0 0.6 0.8")
    joints = (
        joint(
            f"j{k}",
            f"l{k}",
            f"l{k + 1}",
            axis=axes[k % 3],
            more='<origin xyz="0.1 0 0.02"/>' + LIMIT,
        )
        for k in range(39)
    )
    robot = robot_from(urdf(*(link(f"l{k}") for k in range(40)), *joints))
    model, q = robot.model, robot.start.copy()
    q[7:] = 0.1 * np.sin(np.arange(model.nq - 7))
    landing = resolve(
        Scene(robot=robot.label, base="free", contact=(Contact(frame=robot.links[-1]),)), robot
    )
    equation, solution, _ = solved(landing, dynamics(robot, q[None]), with_strike=False)
    found = derivatives(landing, equation, solution)
    data, models, datas, settings = pinocchio_contact(model, robot.links[-1])
    for s in range(3):
        v = np.zeros(model.nv)
        v[:3] = np.eye(3)[s]  # the base is not turned
        pin.impulseDynamics(model, data, q, v, models, datas, 0.0, settings)
        pin.computeImpulseDynamicsDerivatives(model, data, models, datas, 0.0, settings)
        # Pinocchio holds q̇⁻ in the base's axes, which turn with it; the strike here is one of the
        # world.
        columns = slice(6, None)
        np.testing.assert_allclose(
            found.delta_qd[0, :, s, columns], data.ddq_dq[:, columns], rtol=0, atol=1e-8
        )


def test_names_give_what_the_maps_hold():
    robot = known_robot("anymal_b")
    landing = resolve(on("anymal_b", "LF_FOOT"), robot)
    Q = np.array(
        [
            pin.integrate(
                robot.model, landing.q, 0.1 * np.random.default_rng(k).standard_normal(18)
            )
            for k in range(3)
        ]
    )
    maps = shock_maps(landing, Q, derivatives=True)
    place = "imu_link:0.1,0.02,0.03"
    np.testing.assert_array_equal(maps.delta_v(place, STRIKE), maps.at(place) @ STRIKE)
    assert maps.shock("imu_link")[1] == pytest.approx(
        np.linalg.norm(maps.at("imu_link")[1, :, 2]), rel=1e-14
    )
    profile = profile_of(landing.at(Q[0]))
    shock = profile.points  # the file's sensors
    assert {one.frame: one.shock for one in shock}["imu_link"] == pytest.approx(
        maps.shock("imu_link")[0], rel=1e-12
    )
    worst = maps.worst(place, strikes := [(np.sin(a), 0.0, -np.cos(a)) for a in (-0.4, 0.0, 0.4)])
    every = [maps.shock(place, strike) for strike in strikes]
    np.testing.assert_array_equal(worst.shock, np.max(every, axis=0))
    h = 1e-5
    for k in (4, 8, 17):
        up, down = (
            shock_maps(
                landing, np.array([pin.integrate(robot.model, q, step * np.eye(18)[k]) for q in Q])
            )
            for step in (h, -h)
        )
        for one, value in {
            f"shock@{place}": lambda m: m.shock(place),
            f"most_severe@{place}": lambda m: np.linalg.norm(m.at(place), 2, axis=(1, 2)),
            f"delta_v@{place}": lambda m: m.delta_v(place),
        }.items():
            np.testing.assert_allclose(
                maps.gradient(one)[..., k], (value(up) - value(down)) / (2 * h), atol=2e-8
            )
        slope = (up.worst(place, strikes).shock - down.worst(place, strikes).shock) / (2 * h)
        np.testing.assert_allclose(worst.gradient[:, k], slope, atol=2e-8)


@pytest.mark.parametrize("e", [0.0, 0.3])
def test_joint_jumps_and_impulses_are_those_of_pinocchio(e):
    robot = known_robot("anymal_b")
    scene = Scene(
        robot="anymal_b",
        contact=(Contact(frame="LF_FOOT", restitution=e, restitution_along="directions"),),
    )
    maps = shock_maps(resolve(scene, robot), robot.start[None])
    model, q, v = robot.model, robot.start, np.random.default_rng(1).standard_normal(18)
    data, models, datas, settings = pinocchio_contact(model, "LF_FOOT")
    after = pin.impulseDynamics(model, data, q, v, models, datas, e, settings).copy()
    np.testing.assert_allclose(maps.joint_jumps(v)[0], after - v, atol=1e-11)
    np.testing.assert_allclose(maps.impulse(v)[0, 0], data.impulse_c, atol=1e-11)
    np.testing.assert_array_equal(maps.joint_jumps([v])[0], maps.joint_jumps(v)[0])
    with pytest.raises(SceneError, match="qd has shape"):
        maps.joint_jumps(v[1:])


def test_a_singular_posture_says_so():
    """The stretched leg of a robot on a fixed base: its foot moves in one direction less than
    beside it.
    """
    robot = known_robot("quadruped")
    scene = on("quadruped", "front_foot", base="fixed", directions=("x", "z"))
    bent, straight = (
        resolve(
            Scene(**{**vars(scene), "posture": Posture(joints_deg={"front_knee": angle})}), robot
        )
        for angle in (20.0, 0.0)
    )
    maps = shock_maps(bent, np.stack([bent.q, straight.q]), derivatives=True)
    assert maps.prove[1]
    assert np.isfinite(maps.derivatives[0]).all()
    with pytest.raises(StudyError, match=r"posture 1 .* has no derivatives: it is singular"):
        maps.gradient("shock@torso", STRIKE)


def test_a_lowest_point_that_jumps_says_so():
    """A box that lands flat rests on four corners, and on one as soon as it turns."""
    box = '<collision><geometry><box size="0.4 0.3 0.2"/></geometry></collision>'
    robot = robot_from(urdf(link("box", more=box)))
    scene = Scene(robot=robot.label, contact=(Contact(frame="box", at="lowest", kind="point"),))
    with pytest.raises(StudyError, match="several points of a contact are equally low"):
        shock_maps(resolve(scene, robot), robot.start[None], derivatives=True).gradient("shock@box")
    tilted = resolve(
        Scene(**{**vars(scene), "posture": Posture(base_rpy_deg=(3.0, 4.0, 0.0))}), robot
    )
    assert np.isfinite(
        shock_maps(tilted, tilted.q[None], derivatives=True).gradient("shock@box:0.1,0,0")
    ).all()


def test_maps_without_derivatives_or_of_other_quantities_say_what_to_do():
    robot = known_robot("anymal_b")
    scene = on("anymal_b", "LF_FOOT")
    maps = shock_maps(scene, robot.start[None])
    np.testing.assert_array_equal(
        maps.at("imu_link"), shock_maps(resolve(scene, robot), robot.start[None]).at("imu_link")
    )
    with pytest.raises(StudyError, match="derivatives=True"):
        maps.gradient("shock@imu_link")
    with pytest.raises(StudyError, match="valid are shock@PLACE"):
        maps.gradient("copc@imu_link")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (
            lambda maps: maps.shock("imu_link", [1.0, 2.0]),
            "a contact velocity is three numbers that are not all zero",
        ),
        (
            lambda maps: maps.gradient("shock@imu_link", [0.0, 0.0, 0.0]),
            "a contact velocity is three numbers that are not all zero",
        ),
        (lambda maps: maps.delta_v("imu_link", [np.nan, 0.0, 0.0]), "give finite numbers"),
        (lambda maps: maps.worst("imu_link", "down"), "give finite numbers"),
        (lambda maps: maps.shock(13), "no body 13"),
        (lambda maps: maps.at(0, [1.0]), "point has shape"),
        (lambda maps: maps.joint_jumps([None] * 18), "give finite numbers"),
    ],
)
def test_arguments_that_are_none_say_so(call, text):
    robot = known_robot("anymal_b")
    maps = shock_maps(
        resolve(on("anymal_b", "LF_FOOT"), robot), robot.start[None], derivatives=True
    )
    with pytest.raises(SceneError, match=text):
        call(maps)
    assert maps.worst(0, [STRIKE]).gradient.shape == (1, 18)


def test_derivatives_that_do_not_fit_are_refused(monkeypatch):
    landing = resolve(on("solo12", "FL_FOOT", at="frame"), known_robot("solo12"))

    def full(shape):
        raise MemoryError

    monkeypatch.setattr("shockpc.profile.np.empty", full)
    with pytest.raises(StudyError, match=r"2 postures take .*GiB; give fewer postures"):
        shock_maps(landing, [landing.q] * 2, derivatives=True)


def test_maps_refuse_points_that_nothing_moves_and_what_is_no_body(tmp_path):
    """A site of the world is of no body, and maps do not take it for one of the last body's."""
    file = tmp_path / "flag.xml"
    file.write_text(
        '<mujoco model="flag"><worldbody><site name="flag" pos="1 0 0"/>'
        '<body name="base"><freejoint/><geom type="box" size=".2 .1 .1" mass="3"/>'
        '<site name="foot" pos="0 0 -.1"/></body></worldbody></mujoco>'
    )
    contact = Contact(frame="foot", at="frame", kind="point")
    robot = load_robot(str(file))
    landing = resolve(Scene(robot=str(file), contact=(contact,)), robot)
    maps = shock_maps(landing, robot.start[None], derivatives=True)
    for read in (maps.at, maps.derivatives_at, maps.shock):
        with pytest.raises(StudyError, match='"flag" is fixed to the world'):
            read("flag")
        for place in (True, 0.0, -1, 1, None):
            with pytest.raises(SceneError, match="there is no body"):
                read(place)
    np.testing.assert_array_equal(maps.at(np.int64(0)), maps.at(0))
    with pytest.raises(SceneError, match="write foot:x,y,z"):
        maps.at("foot", [0.0, 0.0, 0.1])
    with pytest.raises(StudyError, match="quantity is 3"):
        maps.gradient(3)


def test_a_shock_is_asked_for_at_points_of_a_named_frame():
    robot = load_robot("go2")
    profile = profile_of(resolve(Scene(robot="go2", contact=(Contact(frame="FL_foot"),)), robot))
    for r in ([0.0, 0.0], ["a", "b", "c"], [[0.0], [1.0, 2.0]]):
        with pytest.raises(SceneError, match="give points of three numbers"):
            profile.shock_at("imu", r)
    for r in ("a", 1.0, None):
        with pytest.raises(StudyError, match="r is "):
            profile.shock_at("imu", r)
    with pytest.raises(StudyError, match="frame is 3"):
        profile.shock_at(3, [0.0, 0.0, 0.0])
    assert profile.shock_at("imu", [[0, 0, 0]] * 2).shape == (2,)
