"""A landing: a scene resolved on a robot. What strikes, what is held, what is free and how the robot moves before the impact."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from shockpc.core.pulse import Pulse, pulse_from
from shockpc.core.spatial import Array, Plane
from shockpc.diagnostic import Diagnostic
from shockpc.errors import SceneError
from shockpc.model.closure import Assembly, all_loops, assemble, closure_block
from shockpc.model.columns import Base, free_columns
from shockpc.model.contact import Contact, contact_block, placed
from shockpc.model.dynamics import Dynamics, dynamics
from shockpc.model.joint_model import JointModel, joint_model
from shockpc.model.motion import Motion, approach_speeds, twist_before
from shockpc.model.posture import configuration, held_joints, outside_limits, reference_name, settable_joints
from shockpc.model.rows import Block, Equation, block_point, row_jacobian
from shockpc.robot.catalogue import closing_scene
from shockpc.robot.robot import Loop, Robot
from shockpc.scene import Scene, check_scene, plane_of
from shockpc.trace import Trace

__all__ = ["Landing", "complete", "contact_velocity", "ground_normal", "pulse_of", "resolve"]


@dataclass(frozen=True, eq=False)
class Landing:
    """A scene resolved on a robot. Its methods take the robot's state in N postures, of which the scene's own, q, is one.

    Attributes:
        scene: complete, with every default filled in.
        robot: the robot.
        plane: of the study.
        up: (3,) unit normal of the ground, world axes.
        contacts: rows of what strikes; those at a lowest point are placed in each posture.
        stance: rows of the feet that stand already.
        loops: what is closed.
        joint_model: armature and locked joints.
        before: how the robot moves before the impact.
        q: (nq,) configuration of the scene, loops closed.
        state: the robot in that posture (N = 1).
        assembly: what closing the loops changed; None without loops.
        warnings: joints outside their limits, and parts of the scene that have no effect.
    """

    scene: Scene
    robot: Robot
    plane: Plane = field(repr=False)
    up: Array = field(repr=False)
    contacts: tuple[Block, ...] = field(repr=False)
    stance: tuple[Block, ...] = field(repr=False)
    loops: tuple[Loop, ...] = field(repr=False)
    joint_model: JointModel = field(repr=False)
    before: Motion = field(repr=False)
    q: Array = field(repr=False)
    state: Dynamics = field(repr=False)
    assembly: Assembly | None = field(repr=False)
    warnings: tuple[Diagnostic, ...] = field(repr=False)

    @property
    def base(self) -> Base:
        """How the base may move."""
        return self.scene.base or "free"

    @property
    def floating(self) -> bool:
        """Whether the base moves freely, no foot stands and no loop ties the robot to the world."""
        return self.base == "free" and not self.stance and not any(-1 in loop.bodies for loop in self.loops)

    def rows(self, state: Dynamics) -> tuple[Block, ...]:
        """What is held, described: contacts, then standing feet, then loops."""
        contacts = (placed(contact, state.rotation[:, contact.body], self.up) for contact in self.contacts)
        return (*contacts, *self.stance, *(closure_block(loop) for loop in self.loops))

    def equation(self, state: Dynamics, own: bool = True) -> Equation:
        """The impulsive equation of motion (Eq. 4), reduced to the velocities that are free (Eq. 7).

        Args:
            state: the robot in N postures, with the armature of its joints.
            own: whether b has a column for the scene's own strike, besides those of the unit strikes.
        """
        blocks, G = self.rows(state), self.columns(state)
        J_c, b = row_jacobian(state, blocks), approach_speeds(state, blocks, self.before if own else None)
        if G is None:
            return Equation(state.inertia, J_c, b, None, state, blocks)
        return Equation(np.swapaxes(G, -1, -2) @ state.H @ G, J_c @ G, b, G, state, blocks)

    def columns(self, state: Dynamics) -> Array | None:
        """The columns G (N, nv, ny) of the free joint velocities (Eq. 7); None where all are free."""
        return free_columns(self.robot, self.base, self.plane, state.rotation[:, 0], self.joint_model.locked)

    def note_omissions(self, trace: Trace) -> None:
        """Note in a trace what this landing does not need."""
        free = not self.robot.mimics and not self.joint_model.locked.any() and (self.base == "free" or not self.robot.free_base)
        for needless, what, why in (
            (not self.loops, "closure rows and assembly", "nothing closes a loop"),
            (free, "reduction to free velocities (Eq. 7)", "every joint velocity is free"),
            (not self.joint_model.armature.any(), "reflected inertia", "no joint has any"),
            (not self.stance, "stance rows", "no foot stands already"),
            (self.scene.pulse is None, "peak accelerations", "no pulse is given"),
        ):
            if needless:
                trace.skip(what, why)


def complete(scene: Scene, robot: Robot) -> Scene:
    """The scene with every default filled in and every path absolute, so that it says all that is computed.

    Raises:
        SceneError: it has no contact, or holds a number that is not finite or a word that is not known.
        UnknownName: the robot has no such posture.
    """
    scene = check_scene(scene)
    if not scene.contact:
        raise SceneError(f'no contact is defined; name a link of robot "{robot.name}", such as "{robot.links[-1]}"')
    strike = scene.strike
    if strike.velocity is None and strike.drop_height is None:
        speed = 1.0 if strike.speed is None else strike.speed
        strike = replace(strike, speed=speed, strike_angle_deg=strike.strike_angle_deg or 0.0)
    return replace(
        scene,
        robot=robot.label,
        base=scene.base or robot.usual_base,
        srdf=None if scene.srdf is None else str(Path(scene.srdf).expanduser().resolve()),
        packages={name: str(Path(folder).expanduser().resolve()) for name, folder in scene.packages.items()},
        strike=strike,
        posture=replace(scene.posture, reference=reference_name(robot, scene.posture.reference)),
    )


def pulse_of(scene: Scene) -> Pulse | None:
    """The scene's pulse, if it has one.

    Raises:
        SceneError: it has no known shape or no length, or a sensor's range is given without it.
    """
    if scene.range_g is not None and not scene.range_g > 0.0:
        raise SceneError(f"a sensor's range of {scene.range_g:g} g has to be above zero")
    if scene.pulse is None:
        if scene.range_g is not None:
            raise SceneError("a sensor's range is given in g, but no pulse; give one too, such as half-sine:5ms")
        return None
    try:
        return pulse_from(scene.pulse)
    except ValueError as refusal:
        raise SceneError(f"pulse: {refusal}") from None


def resolve(scene: Scene, robot: Robot) -> Landing:
    """Resolve a scene on its robot.

    Raises:
        ShockError: a name is not known, a loop cannot be closed, a contact leaves the ground, nothing can move.
    """
    scene = complete(scene, robot)
    pulse_of(scene)
    plane = plane_of(scene)
    velocity = scene.strike.vector(plane)
    up = ground_normal(plane, velocity)
    joints = joint_model(robot, scene.joints)
    contacts = tuple(contact_block(robot, contact, up) for contact in scene.contact)
    stance = tuple(contact_block(robot, Contact(frame=frame), up, "stance") for frame in scene.stance)
    q = configuration(robot, scene.posture)
    loops = all_loops(robot, scene.closure)
    assembly = None
    if loops:
        assembly = assemble(robot, q, loops, plane, held_joints(robot, scene.posture, scene.assemble))
        q = assembly.q
    state = dynamics(robot, q[None], joints.armature)
    _refuse_rotation_of_the_base(scene, plane)
    before, given = _motion(robot, scene, velocity, joints)
    before = _with_loops(robot, state, loops, before, given | joints.locked, plane)
    warnings = outside_limits(robot, q)
    if scene.assemble and not loops:
        named = ", ".join(f'"{name}"' for pattern in scene.assemble for name in robot.match_joints(pattern))
        warnings += (Diagnostic("scene", "", None, f"{named} may move to close loops, but nothing closes one, so nothing moved"),)
    closing = None if loops else closing_scene(robot.source.path)
    if closing is not None:
        text = f"the loop of this robot is open here, so its ends are not held together; {closing} closes it"
        warnings += (Diagnostic("scene", robot.name, None, text),)
    landing = Landing(scene, robot, plane, up, contacts, stance, loops, joints, before, q, state, assembly, warnings)
    blocks = landing.rows(state)
    _refuse_twice(blocks)
    _refuse_separation(landing, state, blocks)
    landing.columns(state)
    return landing


def contact_velocity(landing: Landing, state: Dynamics, block: Block) -> Array:
    """Velocity (N, 3) of a contact point before the impact, world axes [m/s]."""
    twist = twist_before(state, landing.before, block.body)
    return np.asarray(twist[:, 3:] + np.cross(twist[:, :3], block_point(state, block)))


def ground_normal(plane: Plane, velocity: Array) -> Array:
    """(3,) world z; in a plane seen from above, and struck within it, the plane's own upward direction. Args: velocity (3,)."""
    level = abs(plane.normal[2]) > 1.0 - 1e-9
    return plane.e2 if level and velocity[2] == 0.0 else np.array([0.0, 0.0, 1.0])


def _motion(robot: Robot, scene: Scene, velocity: Array, joints: JointModel) -> tuple[Motion, np.ndarray]:
    """How the robot moves before the impact, followers with their leaders; and which rates (nv,) are given."""
    omega = np.array(scene.strike.angular_velocity or (0.0, 0.0, 0.0), dtype=float)
    rates, given = np.zeros(robot.model.nv), np.zeros(robot.model.nv, dtype=bool)
    if robot.free_base:
        given[:6] = True
    for pattern, rate in scene.strike.joint_velocities.items():
        for joint in settable_joints(robot, pattern):
            if joints.locked[joint.v].any() and rate != 0.0:
                raise SceneError(
                    f'joint "{joint.name}" is locked, so it cannot move at {rate:g} {joint.unit}/s before the impact; '
                    "free it or leave it out"
                )
            rates[joint.v], given[joint.v] = rate, True
    for mimic in robot.mimics:
        # A follower never moves by itself, so its rate is as good as given.
        follower = robot.joint(mimic.joint).v
        given[follower] = True
        rates[follower] = sum(multiplier * rates[robot.joint(leader).v] for leader, multiplier in mimic.leaders.items())
    return Motion(velocity, omega, rates), given


def _refuse_twice(blocks: tuple[Block, ...]) -> None:
    """Refuse two contacts at one point, and a foot that strikes and stands at once."""
    placed = [block for block in blocks if block.kind != "closure"]
    for k, block in enumerate(placed):
        for other in placed[:k]:
            if block.body != other.body or np.linalg.norm(block.point - other.point) > 1e-9:
                continue
            name, first = (f'"{one.frame}"' for one in (block, other))
            if block.kind != other.kind:
                same = "" if name == first else f", which is the same point as {name},"
                raise SceneError(
                    f"{first}{same} is both a contact and a stance, but a foot strikes or stands; leave one of them out"
                )
            raise SceneError(
                f"{name} is listed twice as a {block.kind}; leave one of them out"
                if name == first and block.kind == "stance"
                else f"{block.kind}s {first} and {name} are at one point of one body, so they are one {block.kind}; "
                "leave one of them out" + (", or move it by an offset" if block.kind == "contact" else "")
            )


def _refuse_rotation_of_the_base(scene: Scene, plane: Plane) -> None:
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
    blocks = [closure_block(loop) for loop in loops]
    K = row_jacobian(state, blocks)[0]
    rates = before.joint_rates
    if not held.all():
        G = free_columns(robot, "fixed", plane, state.rotation[:, 0], held)
        columns = np.eye(len(rates)) if G is None else G[0]
        rates = rates + columns @ np.linalg.lstsq(K @ columns, -K @ rates, rcond=1e-10)[0]
    opening = np.abs(K @ rates)
    if opening.max() > 1e-9 * np.abs(rates).max():
        worst = max(blocks, key=lambda block: float(np.abs(row_jacobian(state, [block])[0] @ rates).max()))
        raise SceneError(
            f"the joint velocities open {worst.name} at {opening.max():.3g} m/s; give rates that the loop allows, or fewer of them"
        )
    return before._replace(joint_rates=rates)


def _refuse_separation(landing: Landing, state: Dynamics, blocks: tuple[Block, ...]) -> None:
    """Refuse a contact that does not approach the ground, for it does not strike it."""
    for contact, block in zip(landing.contacts, blocks, strict=False):
        velocity = contact_velocity(landing, state, block)[0]
        leaving = float(velocity @ landing.up)
        if leaving >= -1e-9 * float(np.linalg.norm(velocity)):
            how = "is leaving the ground at" if leaving > 1e-9 else "moves along the ground, approaching it at"
            theta = landing.scene.strike.strike_angle_deg
            remedy = (
                f"strike angle is {theta:g} deg, try one above -90 and below 90 deg"
                if theta is not None and not math.cos(math.radians(theta)) > 1e-9
                else "turn its velocity towards the ground, or list it under stance if it stands there already"
            )
            raise SceneError(f'contact "{contact.frame}" {how} {abs(leaving):.2g} m/s, so there is no impact; {remedy}')
