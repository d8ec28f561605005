"""How a robot moves before it strikes: the velocity and rotation of its base, and the rates of its
joints.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array, Plane, velocity_at
from shockpc.landing.closure import closure_constraint
from shockpc.landing.joint_model import JointModel
from shockpc.landing.movable import free_columns
from shockpc.landing.posture import settable_joints
from shockpc.landing.scene import Scene
from shockpc.landing.strike import GRAVITY
from shockpc.method.approach import Motion
from shockpc.method.constraints import Constraint, row_jacobian, slices_of
from shockpc.method.dynamics import Dynamics
from shockpc.robot.elements import Loop
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import usual_base
from shockpc.text.errors import SceneError


def motion_of(
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
    rates, given = rates_of(robot, scene, joints)
    velocity, rail = scene.strike.vector(plane), _rail(robot, scene, contacts, state)
    if rail is not None:
        velocity, rates[rail], given[rail] = (
            np.zeros(3),
            _fall_along(robot, scene, rail, state),
            True,
        )
    if loops and rates.any():
        rates = with_loops(
            robot, state, [closure_constraint(loop) for loop in loops], rates, given, plane
        )
    return Motion(velocity, _rotation(scene, plane), rates)


def _rotation(scene: Scene, plane: Plane) -> Array:
    """Angular velocity (3,) before the impact; a velocity may be the ground's, but a rotation has
    to be possible for the base.
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
    """The joint velocity along which a robot that its file ties to the world falls; None where it
    is not dropped on a rail.

    The rail is the first joint towards a contact that lifts what it carries, if it slides.
    """
    if (
        scene.strike.drop_height is None
        or scene.base != "fixed"
        or usual_base(robot).base != "fixed"
    ):
        return None
    lifts = mass_lifted(robot, state)
    carrying = np.flatnonzero(
        state.ancestors[contacts[0].body]
        & (np.abs(lifts) > 1e-9 * np.abs(lifts).max(initial=1e-300))
    )
    carrying = carrying[carrying >= 6 * robot.free_base]
    if (
        not len(carrying)
        or next(joint for joint in robot.single_joints if joint.v.start == carrying[0]).kind
        != "prismatic"
    ):
        return None
    return int(carrying[0])


def mass_lifted(robot: Robot, state: Dynamics) -> Array:
    """∂(m z)/∂q (nv,): how fast unit joint velocities lift the mass of the robot [kg m/s]."""
    com = state.position[0] + (state.rotation[0] @ robot.coms[..., None])[..., 0]
    lifted = velocity_at(state.J[0, :3].T, state.J[0, 3:].T, com[:, None])[..., 2]
    return np.asarray(robot.masses @ (lifted * state.ancestors[: len(com)]))


def _fall_along(robot: Robot, scene: Scene, rail: int, state: Dynamics) -> float:
    """The rate [m/s] of a rail after a fall from the scene's drop height, of all that it carries: ½
    H v² = m g h.

    Raises:
        SceneError: its rate, or a motion across the rail, is given too.
    """
    strike, lift, height = (
        scene.strike,
        mass_lifted(robot, state)[rail],
        scene.strike.drop_height or 0.0,
    )
    name = next(joint.name for joint in robot.single_joints if joint.v.start == rail)
    given = [
        joint.name
        for pattern in strike.joint_velocities
        for joint in settable_joints(robot, pattern)
    ]
    if name in given or strike.strike_angle_deg or strike.forward_speed:
        raise SceneError(
            f'the robot falls along its rail "{name}", whose rate follows from the drop height; '
            f"leave out "
            + (
                "that rate, or the drop height"
                if name in given
                else "the strike angle and the forward speed"
            )
        )
    carried = float(robot.masses @ state.ancestors[: len(robot.bodies), rail])
    return float(
        -np.sign(lift) * np.sqrt(2.0 * GRAVITY * height * carried / state.H[0, rail, rail])
    )


def rates_of(robot: Robot, scene: Scene, joints: JointModel) -> tuple[Array, np.ndarray]:
    """Joint velocities (nv,) before the impact, followers with their leaders; and which of them
    (nv,) are given or locked.
    """
    rates, given = np.zeros(robot.model.nv), joints.locked.copy()
    given[:6] |= robot.free_base
    for pattern, rate in scene.strike.joint_velocities.items():
        for joint in settable_joints(robot, pattern):
            rates[joint.v], given[joint.v] = rate, True
    for mimic in robot.mimics:
        # A follower never moves by itself, so its rate is as good as given.
        follower = robot.joint(mimic.joint).v
        given[follower] = True
        rates[follower] = sum(
            multiplier * rates[robot.joint(leader).v]
            for leader, multiplier in mimic.leaders.items()
        )
    return rates, given


def with_loops(
    robot: Robot,
    state: Dynamics,
    constraints: list[Constraint],
    rates: Array,
    given: np.ndarray,
    plane: Plane,
) -> Array:
    """The rates (nv,) with which the loops stay closed while the given ones stay: the others change
    by as little as possible.

    Raises:
        SceneError: the given ones open a loop.
    """
    K = row_jacobian(state, constraints)[0]
    if not given.all():
        G = free_columns(robot, "fixed", plane, state.rotation[:, 0], given)
        columns = np.eye(len(rates)) if G is None else G[0]
        rates = rates + columns @ np.linalg.lstsq(K @ columns, -K @ rates, rcond=1e-10)[0]
    opening = np.abs(K @ rates)
    if opening.max() > 1e-9 * np.abs(rates).max():
        worst = max(
            zip(constraints, slices_of(constraints), strict=True),
            key=lambda pair: float(opening[pair[1]].max()),
        )[0]
        raise SceneError(
            f"the joint velocities open {worst.name} at {opening.max():.3g} m/s; give rates that "
            f"the loop allows, or fewer of them",
            blocks=[worst.frame],
        )
    return rates


def separating(approach: Array, constraints: Sequence[Constraint]) -> np.ndarray:
    """Which contacts (..., c) make a landing no impact: they leave the ground, or none approaches
    it and they move along it.

    A contact may slide while another one strikes. End stops always strike.

    Args:
        approach: (..., c, 3) velocities of the contact points before the impact [m/s].
        constraints: of the contacts.
    """
    normals, stops = (
        np.array([constraint.normal for constraint in constraints]),
        np.array([constraint.kind == "stop" for constraint in constraints]),
    )
    leaving = np.where(stops, -np.inf, (approach * normals).sum(axis=-1))
    rounding = 1e-9 * np.linalg.norm(approach, axis=-1).max(axis=-1, keepdims=True)
    together = ~np.any(leaving < -rounding, axis=-1, keepdims=True)
    return np.asarray((leaving > rounding) | (together & (leaving >= -rounding)))
