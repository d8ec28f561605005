"""The motion of a robot before it strikes.

It is the velocity and rotation of its base, and the rates of its joints.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array, Plane, velocity_at
from shockpc.landing.closure import closure_constraint
from shockpc.landing.joint_model import JointModel
from shockpc.landing.movable import movable_columns
from shockpc.landing.posture import settable_joints
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.approach import Motion
from shockpc.method.constraints import Constraint, row_jacobian, slices_of
from shockpc.method.dynamics import Dynamics
from shockpc.robot.bodies_and_joints import Joint, Loop
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import usual_base
from shockpc.text.errors import SceneError


def motion_before(
    robot: Robot,
    scene: Scene,
    contacts: Sequence[Constraint],
    loops: Sequence[Loop],
    joints: JointModel,
    plane: Plane,
    state: Dynamics,
) -> Motion:
    """The motion of a scene, in which its loops stay closed.

    Raises:
        SceneError: the base, a rail or a loop does not allow it.
    """
    rates, fixed = rates_of(robot, scene, joints)
    velocity = scene.strike.vector(plane)
    rail = _rail(robot, scene, contacts, state)
    if rail is not None:
        velocity = np.zeros(3)
        rates[rail] = _fall_along(robot, scene, rail, state)
        fixed[rail] = True
    if loops and rates.any():
        closures = [closure_constraint(loop) for loop in loops]
        rates = with_loops(robot, state, closures, rates, fixed, plane)
    return Motion(velocity, _rotation(scene, plane), rates)


def _rotation(scene: Scene, plane: Plane) -> Array:
    """Angular velocity (3,) before the impact.

    A velocity may be the ground's, but a rotation has to be possible for the base.
    """
    omega = np.array(scene.strike.angular_velocity or (0.0, 0.0, 0.0), dtype=float)
    turns = {"fixed": 0.0 * omega, "planar": plane.normal * (plane.normal @ omega)}.get(
        scene.base or "free", omega
    )
    across = float(np.linalg.norm(omega - turns))
    if across > 1e-9 * float(np.linalg.norm(omega)):
        normal = ", ".join(f"{x:g}" for x in plane.normal + 0.0)
        raise SceneError(
            f"before the impact a {scene.base} base cannot turn at {across:.3g} rad/s"
            + (f" across the plane's normal ({normal})" if scene.base == "planar" else "")
            + "; leave that part of the angular velocity out, or free the base"
        )
    return omega


def _rail(
    robot: Robot, scene: Scene, contacts: Sequence[Constraint], state: Dynamics
) -> int | None:
    """The joint velocity along which a robot falls that its file ties to the world.

    None where it is not dropped on a rail.

    The rail is the first joint towards a contact that lifts what it carries, if it slides.
    """
    dropped = scene.strike.drop_height is not None
    if not dropped or scene.base != "fixed" or usual_base(robot).base != "fixed":
        return None
    lifts = np.abs(mass_lifted(robot, state))
    moves_mass = lifts > 1e-9 * lifts.max(initial=1e-300)
    carrying = state.ancestors[contacts[0].body] & moves_mass
    if robot.free_base:
        carrying[:6] = False
    if not carrying.any():
        return None
    first = int(np.argmax(carrying))
    return first if _joint_at(robot, first).kind == "prismatic" else None


def _joint_at(robot: Robot, v: int) -> Joint:
    """The joint whose velocities begin with one."""
    return next(joint for joint in robot.single_joints if joint.v.start == v)


def mass_lifted(robot: Robot, state: Dynamics) -> Array:
    """∂(m z)/∂q (nv,): how fast unit joint velocities lift the mass of the robot [kg m/s]."""
    com = state.position[0] + (state.rotation[0] @ robot.coms[..., None])[..., 0]
    lifted = velocity_at(state.J[0, :3].T, state.J[0, 3:].T, com[:, None])[..., 2]
    return np.asarray(robot.masses @ (lifted * state.ancestors[: len(com)]))


def _fall_along(robot: Robot, scene: Scene, rail: int, state: Dynamics) -> float:
    """The rate [m/s] of a rail after a fall from the scene's drop height.

    ½ H v² = m g h, of all that the rail carries.

    Raises:
        SceneError: its rate, or a motion across the rail, is given too.
    """
    strike = scene.strike
    height = strike.drop_height or 0.0
    lift = mass_lifted(robot, state)[rail]
    name = _joint_at(robot, rail).name
    named: list[str] = []
    for pattern in strike.joint_velocities:
        named += [joint.name for joint in settable_joints(robot, pattern)]
    if name in named or strike.strike_angle_deg or strike.forward_speed:
        both = "that rate, or the drop height"
        if name not in named:
            both = "the strike angle and the forward speed"
        raise SceneError(
            f'the robot falls along its rail "{name}", whose rate follows from the drop height; '
            f"leave out {both}"
        )
    m = float(robot.masses @ state.ancestors[: len(robot.bodies), rail])
    speed = np.sqrt(2.0 * GRAVITY * height * m / state.H[0, rail, rail])
    return float(-np.sign(lift) * speed)


def rates_of(robot: Robot, scene: Scene, joints: JointModel) -> tuple[Array, np.ndarray]:
    """Joint velocities (nv,) before the impact, and a mask (nv,) of those given or locked.

    Followers move with their leaders.
    """
    rates = np.zeros(robot.model.nv)
    fixed = joints.locked.copy()
    fixed[:6] |= robot.free_base
    for pattern, rate in scene.strike.joint_velocities.items():
        for joint in settable_joints(robot, pattern):
            rates[joint.v] = rate
            fixed[joint.v] = True
    for mimic in robot.mimics:
        # A follower never moves by itself, so its rate is as good as given.
        follower = robot.joint(mimic.joint).v
        fixed[follower] = True
        rates[follower] = 0.0
        for leader, multiplier in mimic.leaders.items():
            rates[follower] += multiplier * rates[robot.joint(leader).v]
    return rates, fixed


def with_loops(
    robot: Robot,
    state: Dynamics,
    constraints: list[Constraint],
    rates: Array,
    fixed: np.ndarray,
    plane: Plane,
) -> Array:
    """The rates (nv,) with which the loops stay closed while the given ones stay.

    The others change by as little as possible.

    Raises:
        SceneError: the given ones open a loop.
    """
    K = row_jacobian(state, constraints)[0]
    if not fixed.all():
        free = movable_columns(robot, "fixed", plane, state.rotation[:, 0], fixed)
        G = np.eye(len(rates)) if free is None else free[0]
        # K (q̇ + G x) = 0 with the smallest x
        x = np.linalg.lstsq(K @ G, -K @ rates, rcond=1e-10)[0]
        rates = rates + G @ x
    opening = np.abs(K @ rates)
    if opening.max() > 1e-9 * np.abs(rates).max():
        largest = [float(opening[rows].max()) for rows in slices_of(constraints)]
        worst = constraints[int(np.argmax(largest))]
        raise SceneError(
            f"the joint velocities open {worst.name} at {opening.max():.3g} m/s; give rates that "
            f"the loop allows, or fewer of them",
            constraints=[worst.frame],
        )
    return rates


def separating(approach: Array, constraints: Sequence[Constraint]) -> np.ndarray:
    """Mask (..., c) of the contacts that make a landing no impact.

    They leave the ground, or none approaches it and they move along it.

    A contact may slide while another one strikes. End stops always strike.

    Args:
        approach: (..., c, 3) velocities of the contact points before the impact [m/s].
        constraints: of the contacts.
    """
    normals = np.array([constraint.normal for constraint in constraints])
    stops = np.array([constraint.kind == "stop" for constraint in constraints])
    leaving = np.where(stops, -np.inf, (approach * normals).sum(axis=-1))
    rounding = 1e-9 * np.linalg.norm(approach, axis=-1).max(axis=-1, keepdims=True)
    none_approaches = ~np.any(leaving < -rounding, axis=-1, keepdims=True)
    slides = leaving >= -rounding
    return np.asarray((leaving > rounding) | (none_approaches & slides))
