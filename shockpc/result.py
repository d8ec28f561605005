"""What an analysis gives back: frozen records of arrays, each with its unit and its axes."""

from dataclasses import dataclass, field, fields

import numpy as np

from shockpc.core.directions import ExtremeDirections
from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, Plane
from shockpc.model.assembly import Assembly
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["Bracket", "ContactImpulse", "Health", "JointLoad", "PointShock", "ShockProfile", "StanceImpulse"]


@dataclass(frozen=True, eq=False)
class PointShock:
    """Shock at a sensor, or at a point that was asked for.

    Attributes:
        frame: its name.
        body: the body it is fixed to.
        position: (3,) world [m].
        delta_v: (3,) jump of its velocity, in the frame's own axes [m/s].
        shock: |Δv| / v_in [1].
        directions: the strikes that it feels most and least.
        peak_g: peak acceleration for the scene's pulse, in multiples of gravity; None without a pulse.
    """

    frame: str
    body: str
    position: Array
    delta_v: Array
    shock: float
    directions: ExtremeDirections
    peak_g: float | None


@dataclass(frozen=True, eq=False)
class ContactImpulse:
    """What the ground does at a contact.

    Attributes:
        frame: its name.
        point: (3,) where it strikes, world [m].
        impulse: (3,) of the ground on the robot, world axes [N s]; None where only the sum over several contacts is determined.
        moment: (3,) about that point, of a flat contact, world axes [N m s]; None for a point, or without an impulse.
        friction_needed: tangential over normal impulse, the least coefficient of friction that makes it stick [1]; None without an
            impulse, or where the ground would have to pull.
        approach: (3,) velocity of the contact point before the impact, world axes [m/s].
        mass_sticking: effective mass along the ground's normal if the contact sticks [kg]; inf if it cannot give way.
        mass_frictionless: the same if it slides [kg].
        mitigation: impact mitigation factor, 1 if the joints hide the robot from the ground [1]; None unless its base is free.
    """

    frame: str
    point: Array
    impulse: Array | None
    moment: Array | None
    friction_needed: float | None
    approach: Array
    mass_sticking: float
    mass_frictionless: float
    mitigation: float | None


@dataclass(frozen=True, eq=False)
class StanceImpulse:
    """What the ground does at a foot that stands already.

    Attributes:
        frame: its name.
        point: (3,) where it stands, world [m].
        impulse: (3,) of the ground on the robot, world axes [N s]; None where only the sum over several feet is determined.
        friction_needed: tangential over normal impulse [1]; None without an impulse, or where the ground would have to pull.
    """

    frame: str
    point: Array
    impulse: Array | None
    friction_needed: float | None


@dataclass(frozen=True, eq=False)
class JointLoad:
    """Impulse that a body receives through its joint: what its bearings and gearbox have to carry.

    Attributes:
        joint: its name.
        force: (3,) on the body from its parent, world axes [N s].
        moment: (3,) about the joint's origin, world axes [N m s].
        along: part of the moment (of the force, if prismatic) along the joint's axis: what the drive carries [N m s, N s]; None
            for a joint of more than one axis.
    """

    joint: str
    force: Array
    moment: Array
    along: float | None


@dataclass(frozen=True)
class Bracket:
    """The same landing with three models of the drives, the choice that moves the answer most; shock at one place [1].

    Attributes:
        place: a body (its centre of mass), or a sensor.
        free: no drive takes part; None if massless bodies then make it unsolvable.
        as_modelled: as the scene says.
        locked: every drive holds; None if the contact could not give way then.
    """

    place: str
    free: float | None
    as_modelled: float | None
    locked: float | None


@dataclass(frozen=True)
class Health:
    """How far to trust a profile.

    Attributes:
        rank: independent contact rows.
        rows: contact rows.
        residual: largest violation of the impulsive equation of motion, relative [1].
        error_estimate: largest of `body_errors` over the bodies that move [1].
        body_errors: estimated error of every body's jump, relative to the body's own motion [1]: from the difference between two
            independent solutions, in joint space and in maximal coordinates, or from samples of what rounding does to the better
            one; the true error is not above ten times that. Infinite where no digit is sure.
        method: how the reported numbers were computed.
        warnings: each with its consequence.
        double_error: true error of the solution in double precision, largest over the bodies [1].
        data_sensitivity: what a change of every datum in its last digit does to the result [1]; None if it was not asked for.
        bits: precision of the arithmetic behind the reported numbers.
    """

    rank: int
    rows: int
    residual: float
    error_estimate: float
    body_errors: tuple[float, ...]
    method: str
    warnings: tuple[str, ...]
    double_error: float = 0.0
    data_sensitivity: float | None = None
    bits: int = 53

    @property
    def error_bound(self) -> float:
        """Largest error of the reported motion of a body, relative to its motion [1]."""
        return self.error_estimate

    @property
    def body_error_bounds(self) -> tuple[float, ...]:
        """The same for every body."""
        return self.body_errors


@dataclass(frozen=True, eq=False)
class ShockProfile:
    """The shock of one landing, body by body; index i of every array is body i of the robot.

    Attributes:
        scene: what was computed, with every default filled in.
        robot: the robot.
        plane: in which CoPc and RoPc are read.
        v_in: speed of the contact against the ground, by which shock is normalised [m/s].
        strike: (3,) velocity of the (fastest) contact against the ground, world axes [m/s].
        q: (nq,) configuration in Pinocchio's layout.
        delta_qd: (nv,) jump of the joint velocities, Pinocchio's layout [rad/s, m/s].
        maps: (nb, 6, 3) jump (Δω, Δv) of every body, as below, for a strike of 1 m/s along world x, y and z.
        position: (nb, 3) origins of the body frames, world [m].
        rotation: (nb, 3, 3) of the body frames, body to world.
        delta_omega: (nb, 3) jump of angular velocity, body axes [rad/s].
        delta_v: (nb, 3) jump of velocity of the body frame's origin, body axes [m/s].
        copc: (nb, 3) centre of percussion, body coordinates [m]; NaN where the body does not turn in the plane.
        copc_world: (nb, 3) the same in the world [m].
        ropc: (nb,) radius of percussion [m]; inf where the body does not turn in the plane.
        translates: (nb,) whether the body does not turn in the plane, by more than rounding.
        pitch: (nb,) pitch of the spatial screw [m/rad]; NaN where the body does not turn at all.
        off_plane: (nb,) share of the jump that the plane cannot show [1].
        shock_com: (nb,) shock at the centre of mass [1].
        shock_min: (nb,) least shock over the body's geometry [1]; NaN without geometry.
        shock_max: (nb,) greatest shock over the body's geometry [1]; NaN without geometry.
        points: sensors and asked-for points.
        contacts: what the ground does where the robot strikes.
        stance: what it does where the robot stands already.
        total_impulse: (3,) of the ground on the robot, all contacts and standing feet together, world axes [N s].
        total_moment: (3,) of the same about the robot's centre of mass, world axes [N m s].
        directions: the strikes that every body's centre of mass feels most and least; arrays over the bodies.
        loads: impulse through every joint.
        energy_lost: kinetic energy that the impact takes [J].
        energy_share: of the kinetic energy before it [1]; None where that is not determined (fixed base, standing feet).
        bracket: the same landing with free, modelled and locked drives.
        assembly: what closing the loops changed; None without loops.
        joint_model: "free" (no reflected inertia), "geared" (every joint has some), "locked" (every joint holds) or "mixed".
        health: how far to trust all this.
    """

    scene: Scene
    robot: Robot
    plane: Plane
    v_in: float
    strike: Array
    q: Array
    delta_qd: Array
    maps: Array = field(repr=False)
    position: Array = field(repr=False)
    rotation: Array = field(repr=False)
    delta_omega: Array
    delta_v: Array
    copc: Array
    copc_world: Array = field(repr=False)
    ropc: Array
    translates: np.ndarray = field(repr=False)
    pitch: Array = field(repr=False)
    off_plane: Array
    shock_com: Array
    shock_min: Array
    shock_max: Array
    points: tuple[PointShock, ...]
    contacts: tuple[ContactImpulse, ...]
    stance: tuple[StanceImpulse, ...]
    total_impulse: Array
    total_moment: Array
    directions: ExtremeDirections = field(repr=False)
    loads: tuple[JointLoad, ...] = field(repr=False)
    energy_lost: float
    energy_share: float | None
    bracket: tuple[Bracket, ...]
    assembly: Assembly | None
    joint_model: str
    health: Health

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                # A view of its own, so that only the record is sealed and not what it was made from.
                sealed = value.view()
                sealed.flags.writeable = False
                object.__setattr__(self, item.name, sealed)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of every array."""
        return tuple(body.name for body in self.robot.bodies)

    @property
    def moved(self) -> np.ndarray:
        """(nb,) whether the strike moves the body by more than rounding; on a fixed base most bodies stay where they are."""
        motion = np.linalg.norm(self.delta_omega, axis=1) + np.linalg.norm(self.delta_v, axis=1)
        return np.asarray(motion > 1e-12 * motion.max())

    def shock_at(self, body: str, r: Array) -> Array:
        """Shock at points of a body, |Δv + Δω × r| / v_in [1]. Args: r (..., 3) in the body's frame [m]."""
        i = self.bodies.index(body)
        return shock_at(self.delta_omega[i], self.delta_v[i], np.asarray(r, dtype=float), self.v_in)
