"""A landing: a scene resolved on a robot. What strikes, what is held, what is free and how the robot moves before the impact."""

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Self

import numpy as np

from shockpc.core.inertia import definite
from shockpc.core.pulse import Pulse, pulse_from
from shockpc.core.spatial import Array, Plane, freeze, velocity_at
from shockpc.landing.closure import Assembly, all_loops, assemble, closure_block, follow
from shockpc.landing.contact import contact_block, locate_lowest_point
from shockpc.landing.dynamics import Dynamics, dynamics
from shockpc.landing.freedom import free_columns
from shockpc.landing.joint_model import JointModel, joint_model
from shockpc.landing.mobility import Mechanism
from shockpc.landing.motion import Motion, approach_speeds, twist_before
from shockpc.landing.places import Place, PlaceKind, body_places, joint_places, part_places, point_places
from shockpc.landing.posture import configuration, held_joints, outside_limits, reference_name, settable_joints
from shockpc.landing.ratings import check_parts, strength, torque_limits
from shockpc.landing.rows import Block, Equation, block_point, row_jacobian, slices_of
from shockpc.landing.scene import GRAVITY, Base, Contact, Scene, Strike
from shockpc.landing.scene_file import check_scene, plane_of, point_at, with_paths, with_plane
from shockpc.landing.stops import is_stop, striking_stop, velocity_at_stop
from shockpc.robot.catalogue import closing_scene
from shockpc.robot.robot import Loop, Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import SceneError
from shockpc.text.printed import listed
from shockpc.text.trace import Trace


@dataclass(frozen=True, eq=False)
class Landing:
    """A scene resolved on a robot, in whatever posture: its methods take the robot's state in N postures.

    Attributes:
        scene: complete, with every default filled in.
        robot: the robot.
        plane: of the study.
        up: (3,) unit normal of the ground, world axes: of all contacts, or vertical where they differ.
        contacts: rows of what strikes; those at a lowest point are placed in each posture.
        stance: rows of the feet that stand already.
        loops: what is closed.
        joint_model: armature and locked joints.
        before: how the robot moves before the impact.
        pulse: of the impact, if the scene gives one.
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
    pulse: Pulse | None = field(repr=False)

    @property
    def base(self) -> Base:
        """How the base may move."""
        return self.scene.base or "free"

    @property
    def translates(self) -> bool:
        """Whether the robot moves without rotation before the impact, as a whole: the jumps are then linear in its velocity."""
        moves = self.before.omega.any() or self.before.joint_rates.any()
        return not moves and all(contact.velocity is None for contact in self.contacts)

    @property
    def floating(self) -> bool:
        """Whether the base moves freely, no foot stands and no loop ties the robot to the world."""
        return self.base == "free" and not self.stance and not any(-1 in loop.bodies for loop in self.loops)

    @property
    def strike_angle(self) -> float:
        """Angle of the base's velocity in the plane, from straight down towards forward [rad]."""
        velocity = self.before.velocity
        return float(np.arctan2(velocity @ self.plane.forward, -velocity[2]))

    @property
    def mechanism(self) -> Mechanism:
        """The robot and what of it is free."""
        return Mechanism(self.robot, self.base, self.plane, self.joint_model.locked, self.loops)

    def most_independent(self, state: Dynamics, blocks: tuple[Block, ...]) -> Callable[[int], tuple[int, float]]:
        """How many of some rows can be independent in any posture, and the effect of rounding on the others, as `Mechanism`'s."""
        return self.mechanism.most_independent(blocks, state)

    def rows(self, state: Dynamics) -> tuple[Block, ...]:
        """What is held, described: contacts, then standing feet, then loops."""
        contacts = (locate_lowest_point(contact, state.rotation[:, contact.body]) for contact in self.contacts)
        return (*contacts, *self.stance, *(closure_block(loop) for loop in self.loops))

    def equation(self, state: Dynamics, with_strike: bool = True) -> Equation:
        """The impulsive equation of motion (Eq. 4), reduced to the velocities that are free (Eq. 7).

        Args:
            state: the robot in N postures, with the armature of its joints.
            with_strike: whether b has a column for the scene's own strike, besides those of the unit strikes.
        """
        blocks = self.rows(state)
        G = self.free_columns(state)
        J_c, b = row_jacobian(state, blocks), approach_speeds(state, blocks, self.before if with_strike else None)
        inertia = state.inertia if G is None else np.swapaxes(G, -1, -2) @ state.H @ G
        if self.robot.negative_moments:
            inertia = definite(inertia)  # NaN, which the proof refuses by name
        return Equation(inertia, J_c if G is None else J_c @ G, b, G, state, blocks)

    def free_columns(self, state: Dynamics) -> Array | None:
        """The columns G (N, nv, ny) of the free joint velocities (Eq. 7); None where all are free."""
        return free_columns(self.robot, self.base, self.plane, state.rotation[:, 0], self.joint_model.locked)

    def at(self, q: Array) -> "PosedLanding":
        """This landing in one posture. Args: q (nq,) configuration in which every loop is closed."""
        values = {part.name: getattr(self, part.name) for part in fields(Landing)}
        return PosedLanding(**values, q=np.array(q), state=dynamics(self.robot, q[None], self.joint_model.armature))

    def moving(self, before: Motion, velocities: Array) -> Self:
        """This landing with another motion before the impact, or with one for each of N postures.

        Args:
            before: the motions.
            velocities: ([N,] c, 3) of the contacts, world axes; those count that have a velocity of their own [m/s].
        """
        contacts = tuple(
            contact if contact.velocity is None else contact._replace(velocity=velocities[..., k, :])
            for k, contact in enumerate(self.contacts)
        )
        return replace(self, before=before, contacts=contacts)

    def motions(self, rows: slice) -> Self:
        """This landing, which has a motion for each of N postures, with those of some of them."""
        contacts = (contact if (v := contact.velocity) is None else contact._replace(velocity=v[rows]) for contact in self.contacts)
        return replace(self, before=Motion(*(part[rows] for part in self.before)), contacts=tuple(contacts))

    def note_omissions(self, trace: Trace) -> None:
        """Note in a trace what this landing does not need."""
        free = not self.robot.mimics and not self.joint_model.locked.any() and (self.base == "free" or not self.robot.free_base)
        for needless, what, why in (
            (not self.loops, "closure rows and assembly", "nothing closes a loop"),
            (free, "reduction to free velocities (Eq. 7)", "every joint velocity is free"),
            (not self.joint_model.armature.any(), "reflected inertia", "no joint has any"),
            (not self.stance, "stance rows", "no foot stands already"),
            (self.scene.pulse is None, "peak accelerations", "no pulse is given"),
            (self.scene.friction is None, "contacts that slide", "no friction is given"),
            (self.scene.contact_stiffness is None, "forces and their times", "no contact stiffness is given"),
        ):
            if needless:
                trace.skip(what, why)


@dataclass(frozen=True, eq=False)
class PosedLanding(Landing):
    """A landing in one posture.

    Attributes:
        q: (nq,) configuration, loops closed.
        state: the robot in that posture (N = 1).
        assembly: what closing the loops changed; None without loops.
        warnings: joints outside their limits, and parts of the scene that have no effect.
        acting: rows of the end stops that act, where they are known.
    """

    q: Array = field(repr=False)
    state: Dynamics = field(repr=False)
    assembly: Assembly | None = field(default=None, repr=False)
    warnings: tuple[Diagnostic, ...] = field(default=(), repr=False)
    acting: tuple[Block, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        """Make its arrays read-only."""
        freeze(*vars(self).values())

    @property
    def without_stops(self) -> "PosedLanding":
        """This landing without the rows of stops that act."""
        return replace(self, acting=()) if self.acting else self

    def rows(self, state: Dynamics) -> tuple[Block, ...]:
        """As for any landing, then the stops that act."""
        return (*super().rows(state), *self.acting)

    def most_independent(self, state: Dynamics, blocks: tuple[Block, ...]) -> Callable[[int], tuple[int, float]]:
        """As for any landing; postures beside its own have the number of that."""
        return self.mechanism.most_independent(blocks, state, self.state.Q[0])

    def equation(self, state: Dynamics, with_strike: bool = True) -> Equation:
        """As for any landing; that of its own posture is computed once."""
        return self._equation if with_strike and state is self.state else super().equation(state, with_strike)

    @functools.cached_property
    def _equation(self) -> Equation:
        equation = super().equation(self.state)
        freeze(equation)
        return equation

    @functools.cached_property
    def blocks(self) -> tuple[Block, ...]:
        """What is held in this posture, as `rows`, each with one point (3,)."""
        blocks = tuple(block._replace(point=np.reshape(block.point, 3)) for block in self.rows(self.state))
        freeze(blocks)
        return blocks

    @functools.cached_property
    def points(self) -> tuple[Place, ...]:
        """The robot's sensors and the points of the scene."""
        return point_places(self.robot, self.scene.point)

    @functools.cached_property
    def parts(self) -> tuple[Place, ...]:
        """The scene's parts."""
        return part_places(self.robot, self.scene.part)

    @property
    def mounted(self) -> tuple[Place, ...]:
        """The parts that are at a point."""
        return tuple(place for place in self.parts if place.joint < 0)

    @functools.cached_property
    def contact_places(self) -> tuple[Place, ...]:
        """The contacts, then the standing feet; a frame with several has numbers after its name."""
        frames = [block.frame for block in (*self.contacts, *self.stance)]
        times = [frames[: k + 1].count(frame) for k, frame in enumerate(frames)]
        names = [frame if n == 1 else f"{frame} ({n})" for frame, n in zip(frames, times, strict=True)]
        return tuple(Place(name, number=k) for k, name in enumerate(names))

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """The places of one kind: the robot, its bodies, the sensors and points, the joints, or the contacts and standing feet."""
        match kind:
            case "robot":
                return (Place(self.robot.name),)
            case "body":
                return body_places(self.robot)
            case "point":
                return self.points
            case "joint":
                return joint_places(self.robot)
            case "contact":
                return self.contact_places
            case "part":
                return self.parts

    @functools.cached_property
    def fastest_approach(self) -> float:
        """Speed of the fastest contact before the impact [m/s]."""
        velocities = (contact_velocity(self, self.state, block) for block in self.blocks[: len(self.contacts)])
        return max(float(np.linalg.norm(velocity)) for velocity in velocities)

    @functools.cached_property
    def length(self) -> float:
        """Length of the robot [m]: over which a rotation too small to matter is measured."""
        com = self.state.position[0] + (self.state.rotation[0] @ self.robot.coms[..., None])[..., 0]
        extent = np.ptp(np.concatenate([self.state.position[0], com]), axis=0)
        return float(np.linalg.norm(extent)) + float(self.robot.gyration.max()) or 1.0


class OfLanding:
    """What is of one resolved landing has its robot and scene.

    Attributes:
        landing: that one.
    """

    landing: PosedLanding

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.landing.robot

    @property
    def scene(self) -> Scene:
        """What lands, with every default filled in."""
        return self.landing.scene


def _complete(scene: Scene, robot: Robot) -> Scene:
    """The scene with every default filled in and every path absolute, so that it says all that is computed."""
    scene = check_scene(scene)
    if not scene.contact:
        raise SceneError(f'no contact is defined; name a link of robot "{robot.name}", such as "{robot.links[-1]}"')
    strike, base = scene.strike, scene.base or robot.usual_base
    alone = all(is_stop(robot, contact.frame) for contact in scene.contact)
    if strike == Strike(joint_velocities=strike.joint_velocities) and (alone or (base == "fixed" and strike.joint_velocities)):
        # The motion of a fixed base is that of the ground, of which there is none where the joints move.
        strike = replace(strike, velocity=(0.0, 0.0, 0.0))
    if strike.velocity is None and strike.drop_height is None:
        speed = 1.0 if strike.speed is None else strike.speed
        strike = replace(strike, speed=speed, strike_angle_deg=strike.strike_angle_deg or 0.0)
    scene = with_paths(scene, lambda path: str(Path(path).expanduser().resolve()))
    posture = replace(scene.posture, reference=reference_name(robot, scene.posture.reference))
    return with_plane(replace(scene, robot=robot.label, base=base, strike=strike, posture=posture))


def pulse_of(scene: Scene) -> Pulse | None:
    """The scene's pulse, if it has one.

    Raises:
        SceneError: it has no known shape or no length, or a sensor's range is given without it.
    """
    if scene.pulse is None:
        if scene.range_g is not None:
            raise SceneError("a sensor's range is given in g, but no pulse; give one too, such as half-sine:5ms")
        return None
    try:
        return pulse_from(scene.pulse)
    except ValueError as refusal:
        raise SceneError(f"pulse: {refusal}") from None


def _check_ground(scene: Scene, blocks: tuple[Block, ...]) -> None:
    """Refuse a friction, a contact stiffness or a tolerance of the ground that has no meaning for the scene."""
    mu, k = scene.friction, scene.contact_stiffness
    if scene.stop_restitution is not None and not scene.stops:
        raise SceneError("a restitution of end stops is given, but they are left out; give stops = true (--stops) too")
    strikes = any(block.kind == "stop" for block in blocks)
    if scene.stop_stiffness is not None and not ((scene.stops or strikes) and k is not None):
        raise SceneError("a stiffness of end stops needs stops = true (--stops) and the stiffness of the contacts; give these too")
    for value, what in ((scene.tangential_stiffness, "a stiffness along the ground"), (scene.contact_damping, "a contact damping")):
        if k is None and value is not None:
            raise SceneError(f"{what} is given without the stiffness along the normal; give contact_stiffness too")
    if k is None and (scene.joints.torque or scene.joints.motors):
        what = "torque" if scene.joints.torque else f'motors = "{scene.joints.motors}"'
        raise SceneError(f"{what} of joints: constant torques count on contacts of finite stiffness; give contact_stiffness too")
    if mu is None and k is None:
        return
    if mu is not None and k is not None:
        raise SceneError("friction and a contact stiffness are given; contacts of finite stiffness stick, so leave one of them out")
    option = "a contact stiffness" if mu is None else "friction"
    if scene.tangential_stiffness is not None and not scene.tangential_stiffness > 0.0:
        raise SceneError(f"tangential_stiffness must be > 0 N/m, got {scene.tangential_stiffness:g}")
    if scene.contact_damping is not None and any(contact.restitution for contact in scene.contact):
        raise SceneError("a contact damping and a restitution cannot be combined; keep one of them")
    for contact, block in zip(scene.contact, blocks, strict=True):
        if block.kind == "stop" and mu is not None:
            raise SceneError(f'contact "{contact.frame}" is an end stop, and friction is for the ground; leave it out')
        if block.kind == "stop":
            continue
        rank = np.linalg.matrix_rank(block.forces)
        if mu is not None and rank == 1:
            raise SceneError(
                f'contact "{contact.frame}" slides without friction, and a friction is given; leave out --slide (give it the '
                "directions x, y and z, or those along which it does not slide freely), or the friction",
                blocks=[contact.frame],
            )
        if np.linalg.matrix_rank(np.vstack([block.forces, block.normal]), tol=1e-9) > rank:
            raise SceneError(
                f'contact "{contact.frame}" has {option}, so the directions in which it is held have to span the ground\'s normal; '
                "give directions along the normal and along the ground, such as x and z",
                blocks=[contact.frame],
            )
    if k is None:
        return
    if (scene.stops or strikes) and scene.stop_stiffness is None:
        raise SceneError("contacts of finite stiffness are given, and rigid end stops; give the stops a stop_stiffness too")


def resolve(scene: Scene, robot: Robot) -> PosedLanding:
    """Resolve a scene on its robot.

    Raises:
        ShockError: as for `landing_of`, or a contact does not approach the ground.
    """
    landing = landing_of(scene, robot)
    _refuse_separation(landing)
    return landing


def landing_of(scene: Scene, robot: Robot) -> PosedLanding:
    """Resolve a scene on its robot, whether or not its contacts approach the ground.

    Raises:
        ShockError: a name is not known, a loop cannot be closed, or a part of the scene has no meaning.
    """
    scene = _complete(scene, robot)
    pulse, plane = pulse_of(scene), plane_of(scene)
    velocity = scene.strike.vector(plane)
    # Where the plane is seen from above and struck within it, the ground is vertical.
    up = plane.e2 if plane.level and velocity[2] == 0.0 else np.array([0.0, 0.0, 1.0])
    joints = joint_model(robot, scene.joints)
    q, assembly, warnings = configuration(robot, scene.posture), None, list[Diagnostic]()
    contacts = tuple(
        striking_stop(robot, contact, q, _rates(robot, scene, joints)[0])
        if is_stop(robot, contact.frame)
        else contact_block(robot, contact, up)
        for contact in scene.contact
    )
    standing = [point_at(robot, foot) for foot in scene.stance]
    stance = tuple(contact_block(robot, Contact(frame=one.frame, offset=one.offset), up, "stance") for one in standing)
    _check_ground(scene, contacts)
    normals = np.array([block.normal for block in (*contacts, *stance) if block.kind != "stop"])
    up = normals[0] if len(normals) and np.ptp(normals, axis=0).max() <= 1e-12 else up
    loops = all_loops(robot, scene.closure)
    if loops:
        assembly = assemble(robot, q, loops, plane, held_joints(robot, scene.posture, scene.assemble))
        q, warnings = assembly.q, [*assembly.warnings(robot.name)]
    warnings += outside_limits(robot, q)
    if scene.joints.model == "rigid" and not joint_model(robot, replace(scene.joints, model=None)).springs.any():
        text = "the springs are to be rigid, but no joint has a spring, so nothing changes; give one with a stiffness or a rotor"
        warnings.append(Diagnostic("scene", robot.name, None, text))
    if scene.assemble and not loops:
        named = listed(name for pattern in scene.assemble for name in robot.match_joints(pattern))
        warnings.append(Diagnostic("scene", "", None, f"{named} may move to close loops, but nothing closes one, so nothing moved"))
    if not loops and (closing := closing_scene(robot.source.path)) is not None:
        text = f"the loop of this robot is open here, so its ends are not held together; {closing} closes it"
        warnings.append(Diagnostic("scene", robot.name, None, text))
    state = dynamics(robot, q[None], joints.armature)
    rates, given = _rates(robot, scene, joints)
    rail = _rail(robot, scene, contacts, state)
    if rail is not None:
        velocity, rates[rail], given[rail] = np.zeros(3), _fall_along(robot, scene, rail, state), True
    if loops and rates.any():
        rates = with_loops(robot, state, [closure_block(loop) for loop in loops], rates, given, plane)
    before = Motion(velocity, _rotation(scene, plane), rates)
    landing = PosedLanding(
        scene, robot, plane, up, contacts, stance, loops, joints, before, pulse, np.array(q), state, assembly, tuple(warnings)
    )
    check_parts(scene.part)
    torque_limits(robot, scene.part)
    for place in landing.parts:
        if place.joint < 0:
            strength(scene.part[place.number])
    _refuse_twice(landing.blocks)
    return landing


def close_loops(scene: Scene, near: PosedLanding) -> Scene:
    """A scene whose loops start closed, assembled in the same way as those of another landing of the robot.

    The joints that close the loops, ball joints too, are followed from there while the others move, and set to where they come.

    Raises:
        ShockError: as for `resolve`.
    """
    robot, posture = near.robot, scene.posture
    held = held_joints(robot, posture, scene.assemble)
    q = follow(robot, near.q, configuration(robot, posture), near.loops, near.plane, held)
    values = [(joint, joint.value(q)) for joint in robot.independent_joints if not held[joint.v].any()]
    given = {joint.name: value if joint.kind == "prismatic" else math.degrees(value) for joint, value in values}
    balls = [joint for joint in robot.single_joints if joint.kind == "ball" and not held[joint.v].any()]
    turned = {ball.name: tuple(q[ball.q].tolist()) for ball in balls}
    others = {name: value for name, value in posture.joints_deg.items() if name not in given}
    posture = replace(posture, joints_deg={**others, **given}, joint_quaternions={**posture.joint_quaternions, **turned})
    return replace(scene, posture=posture, assemble=(*given, *turned))


def contact_velocity(landing: Landing, state: Dynamics, block: Block) -> Array:
    """Velocity (N, 3) of a contact point before the impact, world axes [m/s]."""
    if block.velocity is not None:
        return np.broadcast_to(block.velocity, (len(state.J), 3))
    if block.kind == "stop":
        return velocity_at_stop(state, block, landing.before)
    twist = twist_before(state, landing.before, block.body)
    return np.asarray(velocity_at(twist[:, :3], twist[:, 3:], block_point(state, block)))


def _rotation(scene: Scene, plane: Plane) -> Array:
    """Angular velocity (3,) before the impact; a velocity may be the ground's, but a rotation has to be possible for the base."""
    omega = np.array(scene.strike.angular_velocity or (0.0, 0.0, 0.0), dtype=float)
    turns = {"fixed": 0.0 * omega, "planar": plane.normal * (plane.normal @ omega)}.get(scene.base or "free", omega)
    across = float(np.linalg.norm(omega - turns))
    if across > 1e-9 * float(np.linalg.norm(omega)):
        normal = ", ".join(f"{x:g}" for x in plane.normal + 0.0)
        raise SceneError(
            f"before the impact a {scene.base} base cannot turn at {across:.3g} rad/s"
            + (f" across the plane's normal ({normal})" if scene.base == "planar" else "")
            + "; leave that part of the angular velocity out, or free the base"
        )
    return omega


def _rail(robot: Robot, scene: Scene, contacts: tuple[Block, ...], state: Dynamics) -> int | None:
    """The joint velocity along which a robot that its file ties to the world falls; None where it is not dropped on a rail.

    The rail is the first joint towards a contact that lifts what it carries, if it slides.
    """
    if scene.strike.drop_height is None or scene.base != "fixed" or robot.usual_base != "fixed":
        return None
    lifts = mass_lifted(robot, state)
    carrying = np.flatnonzero(state.supports[contacts[0].body] & (np.abs(lifts) > 1e-9 * np.abs(lifts).max(initial=1e-300)))
    carrying = carrying[carrying >= 6 * robot.free_base]
    if not len(carrying) or next(joint for joint in robot.single_joints if joint.v.start == carrying[0]).kind != "prismatic":
        return None
    return int(carrying[0])


def mass_lifted(robot: Robot, state: Dynamics) -> Array:
    """∂(m z)/∂q (nv,): how fast unit joint velocities lift the mass of the robot [kg m/s]."""
    com = state.position[0] + (state.rotation[0] @ robot.coms[..., None])[..., 0]
    lifted = velocity_at(state.J[0, :3].T, state.J[0, 3:].T, com[:, None])[..., 2]
    return np.asarray(robot.masses @ (lifted * state.supports[: len(com)]))


def _fall_along(robot: Robot, scene: Scene, rail: int, state: Dynamics) -> float:
    """The rate [m/s] of a rail after a fall from the scene's drop height, of all that it carries: ½ H v² = m g h.

    Raises:
        SceneError: its rate, or a motion across the rail, is given too.
    """
    strike, lift, height = scene.strike, mass_lifted(robot, state)[rail], scene.strike.drop_height or 0.0
    name = next(joint.name for joint in robot.single_joints if joint.v.start == rail)
    given = [joint.name for pattern in strike.joint_velocities for joint in settable_joints(robot, pattern)]
    if name in given or strike.strike_angle_deg or strike.forward_speed:
        raise SceneError(
            f'the robot falls along its rail "{name}", whose rate follows from the drop height; leave out '
            + ("that rate, or the drop height" if name in given else "the strike angle and the forward speed")
        )
    carried = float(robot.masses @ state.supports[: len(robot.bodies), rail])
    return float(-np.sign(lift) * np.sqrt(2.0 * GRAVITY * height * carried / state.H[0, rail, rail]))


def _rates(robot: Robot, scene: Scene, joints: JointModel) -> tuple[Array, np.ndarray]:
    """Joint velocities (nv,) before the impact, followers with their leaders; and which of them (nv,) are given or locked."""
    rates, given = np.zeros(robot.model.nv), joints.locked.copy()
    given[:6] |= robot.free_base
    for pattern, rate in scene.strike.joint_velocities.items():
        for joint in settable_joints(robot, pattern):
            rates[joint.v], given[joint.v] = rate, True
    for mimic in robot.mimics:
        # A follower never moves by itself, so its rate is as good as given.
        follower = robot.joint(mimic.joint).v
        given[follower] = True
        rates[follower] = sum(multiplier * rates[robot.joint(leader).v] for leader, multiplier in mimic.leaders.items())
    return rates, given


def with_loops(robot: Robot, state: Dynamics, blocks: list[Block], rates: Array, given: np.ndarray, plane: Plane) -> Array:
    """The rates (nv,) with which the loops stay closed while the given ones stay: the others change by the least.

    Raises:
        SceneError: the given ones open a loop.
    """
    K = row_jacobian(state, blocks)[0]
    if not given.all():
        G = free_columns(robot, "fixed", plane, state.rotation[:, 0], given)
        columns = np.eye(len(rates)) if G is None else G[0]
        rates = rates + columns @ np.linalg.lstsq(K @ columns, -K @ rates, rcond=1e-10)[0]
    opening = np.abs(K @ rates)
    if opening.max() > 1e-9 * np.abs(rates).max():
        worst = max(zip(blocks, slices_of(blocks), strict=True), key=lambda held: float(opening[held[1]].max()))[0]
        raise SceneError(
            f"the joint velocities open {worst.name} at {opening.max():.3g} m/s; give rates that the loop allows, or fewer of them",
            blocks=[worst.frame],
        )
    return rates


def _refuse_twice(blocks: tuple[Block, ...]) -> None:
    for one, other in itertools.combinations([block for block in blocks if block.kind != "closure"], 2):
        if one.body == other.body and np.linalg.norm(one.point - other.point) <= 1e-9:
            raise SceneError(
                f"{one.name} and {other.name} are at one point of one body, which strikes or stands once; leave one of them out"
                + (", or move it by an offset" if "contact" in (one.kind, other.kind) else ""),
                blocks=[one.frame, other.frame],
            )


def separating(approach: Array, blocks: Sequence[Block]) -> np.ndarray:
    """Which contacts (..., c) make a landing no impact: they leave the ground, or none approaches it and they move along it.

    A contact may slide while another one strikes. End stops always strike.

    Args:
        approach: (..., c, 3) velocities of the contact points before the impact [m/s].
        blocks: of the contacts.
    """
    normals, stops = np.array([block.normal for block in blocks]), np.array([block.kind == "stop" for block in blocks])
    leaving = np.where(stops, -np.inf, (approach * normals).sum(axis=-1))
    rounding = 1e-9 * np.linalg.norm(approach, axis=-1).max(axis=-1, keepdims=True)
    alone = ~np.any(leaving < -rounding, axis=-1, keepdims=True)
    return np.asarray((leaving > rounding) | (alone & (leaving >= -rounding)))


def _refuse_separation(landing: PosedLanding) -> None:
    """Refuse a contact that leaves the ground, or does not approach it as no other does: it does not strike it."""
    approach = np.stack([contact_velocity(landing, landing.state, block)[0] for block in landing.contacts])
    parting = separating(approach, landing.contacts).tolist()
    for contact, block, velocity, parts in zip(landing.scene.contact, landing.contacts, approach, parting, strict=True):
        if block.kind == "stop" and not np.linalg.norm(velocity) > 1e-9 * float(np.abs(landing.before.joint_rates).max()):
            raise SceneError(
                f'the centre of mass of body "{landing.robot.bodies[block.body].name}" lies on the axis of "{block.frame}", so its '
                "speed there is no measure of the strike; let another end stop strike",
                blocks=[block.frame],
            )
        if parts:
            leaving = float(velocity @ block.normal)
            how = "is leaving the ground at" if leaving > 1e-9 else "moves along the ground, approaching it at"
            raise SceneError(
                f'contact "{contact.frame}" {how} {abs(leaving):.2g} m/s, so there is no impact; turn its velocity towards the '
                "ground (a strike angle between -90 and 90 deg), or list it under stance if it stands there already",
                blocks=[contact.frame],
            )
