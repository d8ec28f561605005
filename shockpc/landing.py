"""From a scene to what the method works on: the robot in its posture, what is held, what is free, how it moves before."""

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, Plane
from shockpc.errors import SceneError
from shockpc.model.assembly import Assembly, assemble
from shockpc.model.closure import all_loops, closure_block
from shockpc.model.columns import freedom
from shockpc.model.contact import Touch, stance_block, touch, touch_block
from shockpc.model.dynamics import Dynamics, dynamics
from shockpc.model.joint_model import Transmission, transmission
from shockpc.model.motion import Motion, velocity_before
from shockpc.model.posture import configuration, held_joints, outside_limits, reference_name
from shockpc.model.rows import Rows, row_jacobian, stack
from shockpc.robot.catalogue import closing_scene
from shockpc.robot.couplings import Loop
from shockpc.robot.robot import Robot
from shockpc.scene import Scene, plane_of, refuse_nonsense

WORLD = "world"
"""A root link of this name stands for the ground: the robot is bolted to it unless the scene says otherwise."""

__all__ = ["Landing", "complete", "ground_normal", "resolve"]


class Landing(NamedTuple):
    """A scene made arrays.

    Attributes:
        plane: of the study.
        up: (3,) unit normal of the ground, world axes.
        q: (nq,) configuration, loops closed.
        state: the robot in that posture (N = 1).
        touches: the contacts.
        rows: contacts, then standing feet, then closures.
        drives: what the joints do.
        G: (1, nv, ny) columns of the free velocities, or None where all are.
        before: how the robot moves before the impact.
        approach: (nc, 3) velocity of every contact point before the impact, world axes [m/s].
        anchored: whether a loop ties the robot to the world.
        assembly: what closing the loops changed; None without loops.
        warnings: joints outside their limits, a loop that stays open, joints to assemble that close none.
    """

    plane: Plane
    up: Array
    q: Array
    state: Dynamics
    touches: tuple[Touch, ...]
    rows: Rows
    drives: Transmission
    G: Array | None
    before: Motion
    approach: Array
    anchored: bool
    assembly: Assembly | None
    warnings: tuple[str, ...]


def complete(scene: Scene, robot: Robot) -> Scene:
    """The scene with every default filled in and every path absolute, so that it says all that is computed.

    Raises:
        SceneError: it has no contact, or holds a number that is not finite or a word that is not known.
        UnknownName: the robot has no such posture.
    """
    refuse_nonsense(scene)
    if not scene.contact:
        raise SceneError(
            f'no contact is given, so nothing strikes; name a link of robot "{robot.name}", such as "{robot.links[-1]}"'
        )
    strike = scene.strike
    if strike.velocity is None and strike.drop_height is None:
        speed = 1.0 if strike.speed is None else strike.speed
        strike = replace(strike, speed=speed, strike_angle_deg=strike.strike_angle_deg or 0.0)
    return replace(
        scene,
        robot=robot.label,
        base=scene.base or ("free" if robot.free_base and robot.bodies[0].name != WORLD else "fixed"),
        srdf=None if scene.srdf is None else str(Path(scene.srdf).expanduser().resolve()),
        packages={name: str(Path(folder).expanduser().resolve()) for name, folder in scene.packages.items()},
        strike=strike,
        posture=replace(scene.posture, reference=reference_name(robot, scene.posture.reference)),
    )


def resolve(scene: Scene, robot: Robot) -> Landing:
    """Evaluate a complete scene.

    Raises:
        ShockError: a name is not known, a loop cannot be closed, a contact leaves the ground, nothing can move.
    """
    plane = plane_of(scene)
    velocity = scene.strike.vector(plane)
    up = ground_normal(plane, velocity)
    drives = transmission(robot, scene.joints)
    q = configuration(robot, scene.posture)
    loops = all_loops(robot, scene.closure)
    assembly = None
    if loops:
        assembly = assemble(robot, q, loops, plane, held_joints(robot, scene.posture, scene.assemble))
        q = assembly.q
    state = dynamics(robot, q[None])
    touches = tuple(touch(robot, contact, state.rotation[0], up) for contact in scene.contact)
    _refuse_twice(robot, touches, scene.stance)
    _refuse_turning_of_the_base(scene, plane)
    before, given = _motion(robot, scene, velocity, drives)
    before = _with_loops(robot, state, loops, before, given | drives.locked, plane)
    rows = stack(
        [
            *(touch_block(state, found, before) for found in touches),
            *(stance_block(robot, state, frame) for frame in scene.stance),
            *(closure_block(state, loop) for loop in loops),
        ]
    )
    approach = np.concatenate([velocity_before(state, before, found.body, found.point) for found in touches])
    _refuse_separation(scene, touches, approach, up)
    G = freedom(robot, scene.base or "free", plane, state.rotation[:, 0], drives.locked)
    outside = outside_limits(robot, q)
    if scene.assemble and not loops:
        named = ", ".join(f'"{name}"' for pattern in scene.assemble for name in robot.match_joints(pattern))
        outside += (f"{named} may move to close loops, but nothing closes one, so nothing moved",)
    closing = None if loops else closing_scene(robot.source.path)
    if closing is not None:
        outside += (f"this robot's loop is open here, so its ends dangle; {closing} closes it",)
    return Landing(
        plane, up, q, state, touches, rows, drives, G, before, approach, any(-1 in loop.bodies for loop in loops), assembly, outside
    )


def ground_normal(plane: Plane, velocity: Array) -> Array:
    """(3,) world z; in a plane seen from above, and struck within it, the plane's own upward direction. Args: velocity (3,)."""
    level = abs(plane.normal[2]) > 1.0 - 1e-9
    return plane.e2 if level and velocity[2] == 0.0 else np.array([0.0, 0.0, 1.0])


def _motion(robot: Robot, scene: Scene, velocity: Array, drives: Transmission) -> tuple[Motion, np.ndarray]:
    """How the robot moves before the impact, followers with their leaders; and which rates (nv,) are given."""
    omega = np.array(scene.strike.angular_velocity or (0.0, 0.0, 0.0), dtype=float)
    rates, given = np.zeros(robot.model.nv), np.zeros(robot.model.nv, dtype=bool)
    if robot.free_base:
        given[:6] = True
    followers = {mimic.joint: mimic.leader for mimic in robot.mimics}
    for pattern, rate in scene.strike.joint_velocities.items():
        for name in robot.match_joints(pattern):
            joint = robot.model.joints[robot.model.getJointId(name)]
            if joint.nv != 1:
                raise SceneError(f'joint "{name}" has {joint.nv} degrees of freedom, so one rate cannot set it; leave it out')
            if name in followers:
                if name == pattern:
                    raise SceneError(f'joint "{name}" follows joint "{followers[name]}"; give the rate of that one')
                continue
            if drives.locked[joint.idx_v] and rate != 0.0:
                unit = "m/s" if joint.shortname().startswith("JointModelP") else "rad/s"
                raise SceneError(
                    f'joint "{name}" is locked, so it cannot move at {rate:g} {unit} before the impact; free it or leave it out'
                )
            rates[joint.idx_v], given[joint.idx_v] = rate, True
    for mimic in robot.mimics:
        # A follower never moves by itself, so its rate is as good as given.
        given[robot.model.joints[robot.model.getJointId(mimic.joint)].idx_v] = True
        if robot.model.existJointName(mimic.leader):
            leader, follower = (robot.model.joints[robot.model.getJointId(n)].idx_v for n in (mimic.leader, mimic.joint))
            rates[follower] = mimic.multiplier * rates[leader]
    return Motion(velocity, omega, rates), given


def _refuse_twice(robot: Robot, touches: tuple[Touch, ...], stance: tuple[str, ...]) -> None:
    """Two contacts at one point are one contact, and a foot strikes or stands."""
    places = [("contact", found.frame, found.body, found.point) for found in touches]
    places += [("stance", name, robot.frame(name).body, robot.frame(name).offset) for name in stance]
    for k, (kind, name, body, point) in enumerate(places):
        for other_kind, other, other_body, other_point in places[:k]:
            if body != other_body or np.linalg.norm(point - other_point) > 1e-9:
                continue
            if kind != other_kind:
                same = "" if name == other else f', which is the same point as "{name}",'
                raise SceneError(
                    f'"{other}"{same} is both a contact and a stance, but a foot strikes or stands; leave one of them out'
                )
            raise SceneError(
                f'"{name}" is listed twice as a {kind}; leave one of them out'
                if name == other and kind == "stance"
                else f'{kind}s "{other}" and "{name}" are at one point of one body, so they are one {kind}; '
                "leave one of them out" + (", or move it by an offset" if kind == "contact" else "")
            )


def _refuse_turning_of_the_base(scene: Scene, plane: Plane) -> None:
    """A velocity may be the ground's as well as the base's; a rotation may not, so the base has to be able to turn like that."""
    omega = np.array(scene.strike.angular_velocity or (0.0, 0.0, 0.0), dtype=float)
    if scene.base == "fixed" and omega.any():
        raise SceneError("the base is fixed, so it cannot turn before the impact; leave out the angular velocity, or free the base")
    across = float(np.linalg.norm(omega - plane.normal * (plane.normal @ omega)))
    if scene.base == "planar" and across > 1e-9 * float(np.linalg.norm(omega)):
        normal = ", ".join(f"{x:g}" for x in plane.normal + 0.0)
        raise SceneError(
            f"the base is planar, so before the impact it turns about the plane's normal ({normal}) only, but the angular velocity "
            f"has {across:.3g} rad/s across it; leave that part out, or free the base"
        )


def _with_loops(robot: Robot, state: Dynamics, loops: tuple[Loop, ...], before: Motion, held: np.ndarray, plane: Plane) -> Motion:
    """The motion in which joints that are given no rate move as the loops make them, by the least; the given ones stay.

    Raises:
        SceneError: the given rates open a loop whatever the others do.
    """
    if not loops or not before.joint_rates.any():
        return before
    blocks = [closure_block(state, loop) for loop in loops]
    K = np.concatenate([row_jacobian(state, block.W)[0] for block in blocks])
    rates = before.joint_rates
    if not held.all():
        G = freedom(robot, "fixed", plane, state.rotation[:, 0], held)
        columns = np.eye(len(rates)) if G is None else G[0]
        rates = rates + columns @ np.linalg.lstsq(K @ columns, -K @ rates, rcond=1e-10)[0]
    opening = np.abs(K @ rates)
    if opening.max() > 1e-9 * np.abs(rates).max():
        worst = next(b for b in blocks if np.abs(row_jacobian(state, b.W)[0] @ rates).max() == opening.max())
        raise SceneError(
            f"the joint velocities open {worst.name} at {opening.max():.3g} m/s; give rates that the loop allows, or fewer of them"
        )
    return before._replace(joint_rates=rates)


def _refuse_separation(scene: Scene, touches: tuple[Touch, ...], approach: Array, up: Array) -> None:
    """A contact that does not approach the ground does not strike it."""
    for found, velocity in zip(touches, approach, strict=True):
        leaving = float(velocity @ up)
        if leaving >= -1e-9 * float(np.linalg.norm(velocity)):
            how = "is leaving the ground at" if leaving > 1e-9 else "moves along the ground, approaching it at"
            theta = scene.strike.strike_angle_deg
            remedy = (
                f"strike angle is {theta:g} deg, try one above -90 and below 90 deg"
                if theta is not None and not math.cos(math.radians(theta)) > 1e-9
                else "turn its velocity towards the ground, or list it under stance if it stands there already"
            )
            raise SceneError(f'contact "{found.frame}" {how} {abs(leaving):.2g} m/s, so there is no impact; {remedy}')
