"""Simulated landings against what is known of them: rows that turn with the robot, and jumps that no shared velocity changes."""

import dataclasses
import math

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from shockpc.bench.assembler import assembler
from shockpc.bench.build import Link, box, robot_of
from shockpc.bench.cases import family
from shockpc.bench.compliant import compliant
from shockpc.bench.mujoco_peer import mujoco_model, to_mujoco, to_pinocchio
from shockpc.bench.simulate import Stepper, land
from shockpc.bench.system import jumps_between, loops_in, moving, rows_at, system_of
from shockpc.model.bodies import gyration_radii
from shockpc.model.closure import Closure, Place
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.rows import row_jacobian
from shockpc.robot.robot import load_robot
from shockpc.scene import Scene, Strike

BOX = robot_of([Link(-1, "", np.zeros(3), np.eye(3)[1], 2.0, np.zeros(3), box(2.0, (0.4, 0.2, 0.1)))])
CORNER = (0.2, 0.0, -0.05)


def corner_scene(directions, velocity):
    contact = Contact(frame="link0", offset=CORNER, directions=directions)
    return Scene(robot="box", base="planar", contact=(contact,), strike=Strike(velocity=velocity))


def elsewhere(system, seed=0):
    """A posture far from the scene's own."""
    step = 0.5 * np.random.default_rng(seed).normal(size=system.model.nv)
    return pin.integrate(system.model, system.landing.q, step)


def test_rows_of_a_foot_are_pinocchio_s_in_every_posture():
    """The point of contact stays where it is on the foot, and the directions where they are in the world."""
    robot = load_robot("anymal_b")
    contacts = (Contact(frame="LF_FOOT"), Contact(frame="RH_FOOT", directions=("z",)))
    system = system_of(robot, Scene(robot="anymal_b", contact=contacts, stance=("LH_FOOT",)))
    model, data = system.model, system.model.createData()
    for q in (system.landing.q, elsewhere(system), elsewhere(system, 1)):
        H, J_c = assembler(system, model.createData())(q)
        lf, rh, lh = (
            pin.computeFrameJacobian(model, data, q, model.getFrameId(foot), pin.LOCAL_WORLD_ALIGNED)[:3]
            for foot in ("LF_FOOT", "RH_FOOT", "LH_FOOT")
        )
        np.testing.assert_allclose(J_c, np.vstack([lf, rh[2:], lh]), atol=1e-14)
        np.testing.assert_allclose(H, pin.crba(model, data, q), atol=1e-13)


LOOP = Closure(a=Place(frame="LF_FOOT"), b=Place(frame="RF_FOOT"), kind="frame", directions=("x", (0.0, 1.0, 1.0)))
HELD = {
    "sole and stance": Scene(robot="talos", contact=(Contact(frame="left_sole_link", kind="flat"),), stance=("right_sole_link",)),
    "loop": Scene(robot="anymal_b", contact=(Contact(frame="LH_FOOT"),), closure=(LOOP,)),
}


@pytest.mark.parametrize("what", [*HELD, "four-bar"])
def test_all_rows_are_the_product_s_in_every_posture(what):
    """Two ways to the same rows: the quick one of the rivals, and that of the product, which is made for many postures."""
    scene = HELD.get(what)
    four_bar = family("flat four-bar").case("crank struck", 1.0)
    system = system_of(*four_bar.build()) if scene is None else system_of(load_robot(scene.robot), scene)
    for q in (system.landing.q, elsewhere(system)):
        state = dynamics(system.robot, q[None])
        expected = row_jacobian(state, rows_at(system, state).W)[0]
        np.testing.assert_allclose(assembler(system, system.model.createData())(q)[1], expected, atol=1e-13)


@pytest.mark.parametrize("bodies", [(-1, 2), (2, -1)])
def test_rows_of_a_loop_to_the_world_are_the_product_s(bodies):
    system = system_of(load_robot("anymal_b"), HELD["loop"])
    (loop,) = loops_in(system)
    tied = system._replace(robot=dataclasses.replace(system.robot, loops=(loop._replace(bodies=bodies),)))
    tied = tied._replace(b=np.zeros(len(system.b) + 5))
    q = elsewhere(system)
    state = dynamics(tied.robot, q[None])
    expected = row_jacobian(state, rows_at(tied, state).W)[0]
    np.testing.assert_allclose(assembler(tied, system.model.createData())(q)[1], expected, atol=1e-13)


@pytest.mark.parametrize("speed", [1.0, 10.0])
def test_a_velocity_along_a_ground_without_friction_changes_nothing(speed):
    """One sees the same landing from a train."""
    still, passing = (compliant(corner_scene(("z",), (along, 0.0, -1.0)), BOX) for along in (0.0, speed))
    assert len(still.grounds) == len(passing.grounds)
    for one, other in zip(still.grounds, passing.grounds, strict=True):
        assert other.error == pytest.approx(one.error, rel=1e-9)
        assert other.travel == pytest.approx(one.travel, rel=1e-9)
    assert (passing.tenth, passing.hundredth, passing.mass) == pytest.approx((still.tenth, still.hundredth, still.mass), rel=1e-9)


def swing(directions, velocity, pulse, steps=4000):
    """The same box on the same spring in three coordinates (x, z, turn about y): its jump until it lets go, and the rigid one."""
    inverse = np.diag([1.0 / 2.0, 1.0 / 2.0, 1.0 / box(2.0, (0.4, 0.2, 0.1))[1, 1]])
    rows = [("x", "z").index(direction) for direction in directions]
    corner = np.array([CORNER[0], CORNER[2]])

    def arm(turn):
        c, s = math.cos(turn), math.sin(turn)
        return np.array([[c, s], [-s, c]]) @ corner

    def jacobian(turn):
        x, z = arm(turn)
        return np.array([[1.0, 0.0, z], [0.0, 1.0, -x]])[rows]

    v = before = np.array([velocity[0], velocity[2], 0.0])
    behind = np.linalg.inv(jacobian(0.0) @ inverse @ jacobian(0.0).T)
    rigid = -inverse @ jacobian(0.0).T @ behind @ jacobian(0.0) @ before
    k, h, q, power = (0.5 * math.pi / pulse) ** 2 * behind, pulse / steps, np.zeros(3), 1.0

    def pushed(q):
        return (q[:2] + arm(q[2]) - corner)[rows]

    while power > 0.0:  # until the spring stops taking energy
        half = v + 0.5 * h * (-inverse @ jacobian(q[2]).T @ k @ pushed(q))
        middle = q + 0.5 * h * half
        q, v = q + h * half, v + h * (-inverse @ jacobian(middle[2]).T @ k @ pushed(middle))
        power = pushed(q) @ k @ jacobian(q[2]) @ v
    return v - before, rigid, q[2]


@pytest.mark.parametrize("directions", [("x", "z"), ("z",)], ids=["sticks", "slides"])
def test_a_body_that_turns_on_soft_ground(directions):
    """It turns by some 20 degrees on the softest ground, and the corner that is pushed turns with it."""
    velocity = (0.3, 0.0, -2.0)
    found = compliant(corner_scene(directions, velocity), BOX)
    size = np.array([1.0, 1.0, gyration_radii(BOX)[0]])
    assert abs(swing(directions, velocity, found.grounds[0].pulse)[2]) > 0.3
    for ground in found.grounds[:5]:
        jump, rigid, _ = swing(directions, velocity, ground.pulse)
        expected = np.linalg.norm(size * (jump - rigid)) / np.linalg.norm(size * rigid)
        assert ground.error == pytest.approx(expected, rel=0.02, abs=1e-3)  # what 200 steps are worth


def test_a_free_flight_is_no_jump():
    """A body that spins and flies has the same velocity later, though every part of it in the body's axes is another."""
    system = system_of(BOX, corner_scene(("z",), (3.0, 0.0, -1.0)))
    q = system.landing.q
    before = moving(system, q, np.array([3.0, 0.2, -1.0, 0.0, 2.0, 0.0]))
    turned = pin.integrate(system.model, q, np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0]))
    R = pin.Quaternion(turned[3:7]).matrix()
    after = moving(system, turned, np.concatenate([R.T @ [3.0, 0.2, -1.0], [0.0, 2.0, 0.0]]))
    np.testing.assert_allclose(jumps_between(system, before, after), 0.0, atol=1e-15)


def test_a_landing_ends_where_its_robot_has_turned_to():
    """What a simulated landing gives is a posture and the velocities in it: on a soft pad the base has other axes by then."""
    system = system_of(BOX, corner_scene(("z",), (5.0, 0.0, -1.0)))
    robot = Stepper(system, 0.0)
    q, v = land(robot, np.ones(1), 0.05, 20.0)
    (jump,) = jumps_between(system, moving(system, system.landing.q, robot.before), moving(system, q, v))
    assert np.arccos(pin.Quaternion(q[3:7]).matrix()[0, 0]) > 0.3
    np.testing.assert_allclose(jump[[0, 2, 3, 4]], 0.0, atol=0.01)  # nothing pushes it along the ground


@pytest.mark.parametrize("name", ["anymal_b", "talos"])
def test_mujoco_s_state_is_read_in_the_posture_that_it_has(name):
    """World velocities of all bodies, from MuJoCo itself and from its state written in Pinocchio's layout."""
    foot = {"anymal_b": "LF_FOOT", "talos": "left_sole_link"}[name]
    system = system_of(load_robot(name), Scene(robot=name, contact=(Contact(frame=foot),)))
    peer = mujoco_model(system.model, [], system.landing.q, 1.0, 1.0)
    data = mujoco.MjData(peer)
    data.qpos[:] = to_mujoco(system.model, elsewhere(system))
    data.qvel[:] = np.random.default_rng(2).normal(size=peer.nv)
    mujoco.mj_forward(peer, data)
    q, v = to_pinocchio(system.model, data.qpos, data.qvel)
    np.testing.assert_allclose(q, elsewhere(system), atol=1e-12)
    ours, theirs = moving(system, q, v), np.zeros(6)
    for joint in range(1, system.model.njoints):
        mujoco.mj_objectVelocity(peer, data, mujoco.mjtObj.mjOBJ_XBODY, joint, theirs, 0)
        R, twist = ours.oMi[joint].rotation, ours.v[joint]
        np.testing.assert_allclose(np.concatenate([R @ twist.angular, R @ twist.linear]), theirs, atol=1e-11)
