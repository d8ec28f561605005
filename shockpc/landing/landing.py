"""A landing: what strikes, what is held, what is free and how the robot moves before the impact."""

import functools
from dataclasses import fields, replace
from typing import Self

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.impulse import RowLimits
from shockpc.core.pulse import Pulse
from shockpc.core.spatial import Array, Plane, freeze, read_only, velocity_at
from shockpc.landing.closure import Assembly, closure_constraint
from shockpc.landing.contact import locate_lowest_point
from shockpc.landing.end_stops import velocity_at_stop
from shockpc.landing.joint_model import JointModel
from shockpc.landing.movable import movable_columns, refuse_immovable
from shockpc.landing.places import (
    Place,
    PlaceKind,
    body_places,
    joint_places,
    part_places,
    point_places,
)
from shockpc.landing.rank import Mechanism
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.method.approach import Motion, twist_before
from shockpc.method.base import Base
from shockpc.method.constraints import Constraint, constraint_point
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.method.equation import Equation, Posed, System, equation_of
from shockpc.robot.bodies_and_joints import Loop
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.trace import Trace

LIFTED = 0.1
"""Share of the largest speed of a centre of mass, per joint rate, from which on a body counts as
lifted [1].
"""


@frozen()
class Landing:
    """A scene resolved on a robot, in any posture.

    Its methods take the robot's state in N postures.

    Attributes:
        scene: complete, with every default filled in.
        robot: the robot.
        plane: of the study.
        up: (3,) unit normal of the ground, world axes: of all contacts, or vertical where they
            differ.
        contacts: rows of what strikes; those at a lowest point are placed in each posture.
        lifted: bodies of the feet that the impact on the others lifts, which have no rows.
        stance: rows of the feet that stand already.
        loops: what is closed.
        joint_model: armature and locked joints.
        before: how the robot moves before the impact.
        pulse: of the impact, if the scene gives one.
    """

    scene: Scene
    robot: Robot
    plane: Plane
    up: Array
    contacts: tuple[Constraint, ...]
    lifted: tuple[int, ...]
    stance: tuple[Constraint, ...]
    loops: tuple[Loop, ...]
    joint_model: JointModel
    before: Motion
    pulse: Pulse | None

    def __repr__(self) -> str:
        held = [constraint.name for constraint in (*self.contacts, *self.stance)]
        return f"{type(self).__name__}({self.robot.label}: {', '.join(held)})"

    @property
    def base(self) -> Base:
        """The motion that the base may have."""
        return self.scene.base or "free"

    @property
    def translates(self) -> bool:
        """True if the robot moves without rotation before the impact, as a whole.

        The jumps are then linear in its velocity.
        """
        moves = self.before.omega.any() or self.before.joint_rates.any()
        return not moves and all(contact.velocity is None for contact in self.contacts)

    @property
    def floating(self) -> bool:
        """True if the base moves freely, no foot stands and no loop ties the robot to the world."""
        is_tied = any(-1 in loop.bodies for loop in self.loops)
        return self.base == "free" and not self.stance and not is_tied

    @property
    def strike_angle(self) -> float:
        """Angle of the base's velocity in the plane, from straight down towards forward [rad]."""
        velocity = self.before.velocity
        return float(np.arctan2(velocity @ self.plane.forward, -velocity[2]))

    @property
    def system(self) -> System:
        """The data of Eq. 4 beside a posture and the constraints."""
        joints = self.joint_model
        return System(
            self.robot,
            self.base,
            self.plane,
            joints.locked,
            joints.armature,
            read_only(joints.coupling),
            self.before,
        )

    @property
    def mechanism(self) -> Mechanism:
        """The robot and what of it is free."""
        return Mechanism(self.robot, self.base, self.plane, self.joint_model.locked, self.loops)

    def row_limits(self, state: Dynamics, constraints: tuple[Constraint, ...]) -> RowLimits:
        """The number of some rows that can be independent in any posture, as `Mechanism`'s.

        With it comes the effect of rounding on the others.
        """
        return self.mechanism.row_limits(constraints, state)

    def rows(self, state: Dynamics) -> tuple[Constraint, ...]:
        """The constraints: contacts, then standing feet, then loops."""
        contacts = (
            locate_lowest_point(contact, state.rotation[:, contact.body])
            for contact in self.contacts
        )
        return (*contacts, *self.stance, *(closure_constraint(loop) for loop in self.loops))

    def equation(self, state: Dynamics, with_strike: bool = True) -> Equation:
        """The impulsive equation of motion, reduced to the free velocities (Eqs. 4 and 7).

        Args:
            state: the robot in N postures, with the armature of its joints.
            with_strike: whether b has a column for the scene's strike, besides those of the unit
                strikes.
        """
        system = self.system if with_strike else self.system._replace(before=None)
        refuse_immovable(self.robot, self.base, self.joint_model.locked)
        return equation_of(system, state, self.rows(state))

    def free_columns(self, state: Dynamics) -> Array | None:
        """The columns G (N, nv, ny) of the free joint velocities (Eq. 7); None if all are free."""
        return movable_columns(
            self.robot, self.base, self.plane, state.rotation[:, 0], self.joint_model.locked
        )

    def at(self, q: Array) -> "PosedLanding":
        """This landing in one posture.

        Args: q (nq,) configuration in which every loop is closed.
        """
        values = {part.name: getattr(self, part.name) for part in fields(Landing)}
        return PosedLanding(
            **values, q=np.array(q), state=dynamics(self.robot, q[None], self.joint_model)
        )

    def moving(self, before: Motion, velocities: Array) -> Self:
        """This landing with another motion before the impact, or with one for each of N postures.

        Args:
            before: the motions.
            velocities: ([N,] c, 3) of the contacts, world axes; those count that have a velocity
                [m/s].
        """
        contacts = list(self.contacts)
        for k, contact in enumerate(contacts):
            if contact.velocity is not None:
                contacts[k] = contact._replace(velocity=velocities[..., k, :])
        return replace(self, before=before, contacts=tuple(contacts))

    def motions(self, rows: slice) -> Self:
        """This landing, which has a motion for each of N postures, with those of some of them."""
        contacts = list(self.contacts)
        for k, contact in enumerate(contacts):
            if contact.velocity is not None:
                contacts[k] = contact._replace(velocity=contact.velocity[rows])
        before = Motion(*(part[rows] for part in self.before))
        return replace(self, before=before, contacts=tuple(contacts))

    def note_omissions(self, trace: Trace) -> None:
        """Note in a trace what this landing does not need."""
        base_free = self.base == "free" or not self.robot.free_base
        joints_free = not self.robot.mimics and not self.joint_model.locked.any()
        free = base_free and joints_free
        for needless, part, why in (
            (not self.loops, "closure rows and assembly", "nothing closes a loop"),
            (free, "reduction to free velocities (Eq. 7)", "every joint velocity is free"),
            (not self.joint_model.armature.any(), "reflected inertia", "no joint has any"),
            (not self.stance, "stance rows", "no foot stands already"),
            (self.scene.pulse is None, "peak accelerations", "no pulse is given"),
            (self.scene.friction is None, "contacts that slide", "no friction is given"),
            (
                not self.scene.yields,
                "forces and their times",
                "no contact stiffness is given",
            ),
        ):
            if needless:
                trace.skip(part, why)


@frozen()
class PosedLanding(Landing):
    """A landing in one posture.

    Attributes:
        q: (nq,) configuration, loops closed.
        state: the robot in that posture (N = 1).
        assembly: what closing the loops changed; None without loops.
        warnings: joints outside their limits, and parts of the scene that have no effect.
        acting: rows of the end stops that act, where they are known.
        asked: the contacts as they were asked for; those of the scene say at which point they
            strike and of which kind they are.
        asked_rows: their rows, as points at their frames where the scene leaves that open.
        chosen: what the scene as it was asked for leaves open, and its default fills in: "posture",
            and "base" where that depends on the limbs.
    """

    q: Array
    state: Dynamics
    assembly: Assembly | None = None
    warnings: tuple[Diagnostic, ...] = ()
    acting: tuple[Constraint, ...] = ()
    asked: tuple[Contact, ...] = ()
    asked_rows: tuple[Constraint, ...] = ()
    chosen: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make its arrays read-only."""
        freeze(*vars(self).values())

    @functools.cached_property
    def trunk(self) -> int:
        """The index of the body that an answer is about if there is no sensor.

        It is the base, or with a fixed base another body.

        That body is the heaviest of those that carry what strikes and that the joints can lift
        along the ground's normal: their centre of mass moves by at least a tenth of what that of
        any of them does. If there is none, it is what strikes.
        """
        robot, state = self.robot, self.state
        if self.base != "fixed":
            return 0
        struck = [contact.body for contact in self.contacts]
        carries = np.any(state.ancestors[struck], axis=0)
        carriers: list[int] = []
        for i, joint in enumerate(robot.joints):
            if carries[joint.v].any() and i not in struck:
                carriers.append(i)

        # Speeds of the centres of mass along the normal for unit joint rates.
        velocities = velocity_at(state.J[0, :3].T, state.J[0, 3:].T, self._coms[:, None])
        moves = state.ancestors[: len(robot.bodies)] & ~self.joint_model.locked
        if robot.free_base:
            moves[:, :6] = False
        speeds = np.max(np.abs(velocities @ self.up) * moves, axis=1, initial=0.0)
        most = max((speeds[i] for i in carriers), default=0.0)
        lifted = []
        if most > 0.0:
            lifted = [i for i in carriers if speeds[i] >= LIFTED * most]
        return max(lifted or struck, key=lambda i: robot.masses[i])

    @property
    def _coms(self) -> Array:
        """Centres of mass (nb, 3) of the bodies, world axes, from the base [m]."""
        arms = (self.state.rotation[0] @ self.robot.coms[..., None])[..., 0]
        return np.asarray(self.state.position[0] + arms)

    @property
    def without_stops(self) -> "PosedLanding":
        """This landing without the rows of stops that act."""
        return replace(self, acting=()) if self.acting else self

    def rows(self, state: Dynamics) -> tuple[Constraint, ...]:
        """As for any landing, then the stops that act."""
        return (*super().rows(state), *self.acting)

    def row_limits(self, state: Dynamics, constraints: tuple[Constraint, ...]) -> RowLimits:
        """As for any landing; other postures have the number of the landing's posture."""
        return self.mechanism.row_limits(constraints, state, self.state.Q[0])

    def equation(self, state: Dynamics, with_strike: bool = True) -> Equation:
        """As for any landing; that of the landing's posture is computed once."""
        return (
            self._equation
            if with_strike and state is self.state
            else super().equation(state, with_strike)
        )

    @functools.cached_property
    def _equation(self) -> Equation:
        equation = super().equation(self.state)
        freeze(equation)
        return equation

    @functools.cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints in this posture, as `rows`, each with one point (3,)."""
        constraints = tuple(
            constraint._replace(point=np.reshape(constraint.point, 3))
            for constraint in self.rows(self.state)
        )
        freeze(constraints)
        return constraints

    @property
    def posed(self) -> Posed:
        """The data from which balls are evaluated."""
        return Posed(self.system, self.q, self.constraints)

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
        frames = [constraint.frame for constraint in (*self.contacts, *self.stance)]
        places: list[Place] = []
        for k, frame in enumerate(frames):
            times = frames[: k + 1].count(frame)
            name = frame if times == 1 else f"{frame} ({times})"
            places.append(Place(name, number=k))
        return tuple(places)

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """The places of one kind.

        They are the robot, its bodies, the sensors and points, the joints, or the contacts and
        standing feet.
        """
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

    @property
    def hinges(self) -> np.ndarray:
        """The joint velocities of hinges in links that bend."""
        return np.zeros(0, dtype=int)

    def carried(self, place: Place) -> Place:
        """A place of the robot on the body that it moves with; links that bend have several."""
        return place

    @functools.cached_property
    def fastest_approach(self) -> float:
        """Speed of the fastest contact before the impact [m/s]."""
        velocities = (
            contact_velocity(self, self.state, constraint)
            for constraint in self.constraints[: len(self.contacts)]
        )
        return max(float(np.linalg.norm(velocity)) for velocity in velocities)

    @functools.cached_property
    def length(self) -> float:
        """Length of the robot [m]: over which a rotation too small to matter is measured."""
        extent = np.ptp(np.concatenate([self.state.position[0], self._coms]), axis=0)
        return float(np.linalg.norm(extent)) + float(self.robot.gyration.max()) or 1.0


class OfLanding:
    """Base class of what belongs to one resolved landing: it has the landing's robot and scene.

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
        """The scene that lands, with every default filled in."""
        return self.landing.scene


def contact_velocity(landing: Landing, state: Dynamics, constraint: Constraint) -> Array:
    """Velocity (N, 3) of a contact point before the impact, world axes [m/s]."""
    if constraint.velocity is not None:
        return np.broadcast_to(constraint.velocity, (len(state.J), 3))
    if constraint.kind == "stop":
        return velocity_at_stop(state, constraint, landing.before)
    twist = twist_before(state, landing.before, constraint.body)
    return np.asarray(velocity_at(twist[:, :3], twist[:, 3:], constraint_point(state, constraint)))
