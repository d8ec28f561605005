"""What an analysis gives back: a landing, its solution and its proof; everything else is computed when it is read."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from shockpc.core.directions import ExtremeDirections
from shockpc.core.impulse import RowChoice
from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, Plane, read_only
from shockpc.diagnostic import Diagnostic
from shockpc.exact.proof import Proof
from shockpc.landing import Landing, pulse_of
from shockpc.model.closure import Assembly
from shockpc.model.rows import Equation
from shockpc.results.accuracy import Health, data_warnings, double_error
from shockpc.results.bracket import Bracket, joint_bracket
from shockpc.results.contacts import (
    ContactImpulse,
    StanceImpulse,
    TotalImpulse,
    contact_impulses,
    pulled,
    stance_impulses,
    total_impulse,
)
from shockpc.results.directions import directions_at
from shockpc.results.energy import Energy, energy, gained
from shockpc.results.geometry import shock_ranges
from shockpc.results.loads import JointLoad, joint_loads
from shockpc.results.percussion import BodyPercussion, body_percussion
from shockpc.results.placement import Placement, placement
from shockpc.results.plausibility import implausible
from shockpc.results.points import PointShock, point_shocks, saturated
from shockpc.results.proof import nearly_singular
from shockpc.results.speed import Speed, normalising_speed
from shockpc.robot.robot import Robot
from shockpc.scene import Scene
from shockpc.trace import Trace, derived

__all__ = ["ShockMaps", "ShockProfile", "Solution"]


class Solution(NamedTuple):
    """Steps 1 and 2 in double precision, in the scene's posture.

    Attributes:
        equation: Eq. 4.
        choice: which rows are independent.
        jumps: (nb, 6, 4) jump (Δω, Δv) of every body in body coordinates, as in `Proof`.
        impulse: (nc, 4) along every row [N s].
    """

    equation: Equation
    choice: RowChoice
    jumps: Array
    impulse: Array


class ShockMaps(NamedTuple):
    """The shock of a landing in N postures: Δv is linear in the strike, so every strike angle and speed is a product.

    Attributes:
        maps: (N, nb, 6, 3) jump (Δω, Δv at the body frame's origin) of every body for a strike of 1 m/s along world x, y and z;
            world axes, double precision [rad/s, m/s].
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) origins of the body frames, from the base [m].
        rank: (N,) number of independent contact and closure rows.
        condition: (N,) estimated factor by which rounding is enlarged [1]; inf where double precision has no solution.
        prove: (N,) whether the posture needs a proof: its rows depend on one another, or nearly, rounding may show above 1e-9, or
            joints move so fast that it may be singular, which `shock_profile` refuses.
    """

    maps: Array
    rotation: Array
    position: Array
    rank: np.ndarray
    condition: Array
    prove: np.ndarray

    def at(self, body: int, point: Array) -> Array:
        """Maps (N, 3, 3) from strike to jump of a point of a body, world axes. Args: point (3,) in the body's frame [m]."""
        x, y, z = ((self.rotation[:, body] @ point)[:, i, None] for i in range(3))
        (a, b, c), v = (self.maps[:, body, i] for i in range(3)), self.maps[:, body, 3:]
        return v + np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)


@dataclass(frozen=True, eq=False)
class ShockProfile:
    """The shock of one landing, body by body; index i of every array is body i of the robot.

    The reported numbers are those of the proof: midpoints of enclosures, rounded to doubles.

    Attributes:
        landing: the scene resolved on the robot.
        solution: of Eq. 4 in double precision.
        proof: enclosures of the exact solution.
        trace: collects what each part cost, if one is kept.
    """

    landing: Landing
    solution: Solution = field(repr=False)
    proof: Proof = field(repr=False)
    trace: Trace | None = field(default=None, repr=False)

    @property
    def scene(self) -> Scene:
        """What was computed, with every default filled in."""
        return self.landing.scene

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.landing.robot

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of every array."""
        return tuple(body.name for body in self.robot.bodies)

    @property
    def plane(self) -> Plane:
        """In which CoPc and RoPc are given."""
        return self.landing.plane

    @property
    def q(self) -> Array:
        """Configuration (nq,) in Pinocchio's layout."""
        return read_only(self.landing.q)

    @property
    def joint_model(self) -> str:
        """Joint model: "free" (no reflected inertia), "geared" (every joint has some), "locked" (every joint holds) or "mixed"."""
        return self.landing.joint_model.name

    @property
    def assembly(self) -> Assembly | None:
        """What closing the loops changed; None without loops."""
        return self.landing.assembly

    @derived
    def placement(self) -> Placement:
        """Frames of the bodies."""
        return placement(self.landing, self.proof)

    @property
    def position(self) -> Array:
        """Origins (nb, 3) of the body frames, world [m]."""
        return read_only(self.placement.position)

    @property
    def rotation(self) -> Array:
        """Orientations (nb, 3, 3) of the body frames, body to world."""
        return read_only(self.placement.rotation)

    @property
    def delta_qd(self) -> Array:
        """Jump (nv,) of the joint velocities, Pinocchio's layout [rad/s, m/s]."""
        return read_only(self.proof.delta_qd[:, 3])

    @property
    def maps(self) -> Array:
        """Jump (nb, 6, 3) of every body (Δω, Δv) for a strike of 1 m/s along world x, y and z."""
        return read_only(self.proof.jumps[..., :3])

    @property
    def delta_omega(self) -> Array:
        """Jump (nb, 3) of angular velocity, body axes [rad/s] (Eqs. 8 and 9)."""
        return read_only(self.proof.jumps[:, :3, 3])

    @property
    def delta_v(self) -> Array:
        """Jump (nb, 3) of velocity of the body frame's origin, body axes [m/s] (Eqs. 8 and 9)."""
        return read_only(self.proof.jumps[:, 3:, 3])

    @property
    def moved(self) -> np.ndarray:
        """Whether (nb,) the strike moves the body by more than 1e-12 of the fastest one."""
        motion = np.linalg.norm(self.delta_omega, axis=1) + np.linalg.norm(self.delta_v, axis=1)
        return np.asarray(motion > 1e-12 * motion.max())

    @derived
    def speed(self) -> Speed:
        """Speeds before the impact."""
        return normalising_speed(self.landing, self.proof.enclosure)

    @property
    def v_in(self) -> float:
        """Speed by which shock is normalised: of the fastest contact, or of the centre of mass [m/s]."""
        return self.speed.v_in

    @property
    def strike(self) -> Array:
        """Velocity (3,) of the fastest contact before the impact, world axes [m/s]."""
        return self.speed.strike

    @derived
    def percussion(self) -> BodyPercussion:
        """Centres and radii of percussion (Eqs. 11 and 12)."""
        return body_percussion(self.landing, self.proof, self.v_in)

    @property
    def copc(self) -> Array:
        """Centre of percussion (nb, 3), body coordinates [m]; NaN where the body does not rotate in the plane."""
        return self.percussion.copc

    @property
    def copc_world(self) -> Array:
        """The same in the world [m]."""
        return self.percussion.copc_world

    @property
    def ropc(self) -> Array:
        """Radius of percussion (nb,) [m]; inf where the body does not rotate in the plane."""
        return self.percussion.ropc

    @property
    def translates(self) -> np.ndarray:
        """Whether (nb,) the body does not rotate in the plane, by more than the rounding of files."""
        return self.percussion.translates

    @property
    def pitch(self) -> Array:
        """Pitch (nb,) of the spatial screw [m/rad]; NaN where the body does not rotate at all."""
        return self.percussion.pitch

    @property
    def off_plane(self) -> Array:
        """Share (nb,) of the jump that the plane cannot show [1]."""
        return self.percussion.off_plane

    @property
    def shock_com(self) -> Array:
        """Shock (nb,) at the centre of mass [1]."""
        return self.percussion.shock_com

    @derived
    def geometry(self) -> tuple[Array, Array, tuple[Diagnostic, ...]]:
        """Least and greatest shock over the bodies' geometry."""
        return shock_ranges(self.robot, self.proof.jumps[..., 3], self.v_in)

    @property
    def shock_min(self) -> Array:
        """Least shock (nb,) over the body's geometry [1]; NaN without geometry."""
        return self.geometry[0]

    @property
    def shock_max(self) -> Array:
        """Greatest shock (nb,) over the body's geometry [1]; NaN without geometry."""
        return self.geometry[1]

    @derived
    def points(self) -> tuple[PointShock, ...]:
        """Shock at sensors and points."""
        return point_shocks(self.landing, self.proof, self.v_in, pulse_of(self.scene))

    @derived
    def directions(self) -> ExtremeDirections:
        """Most and least severe impact directions of the bodies' centres of mass."""
        bodies = list(range(len(self.robot.bodies)))
        return directions_at(self.proof.enclosure, bodies, self.robot.coms, self.landing.up)

    @derived
    def contacts(self) -> tuple[ContactImpulse, ...]:
        """Impulses, friction and effective masses of the contacts."""
        return contact_impulses(self.landing, self.proof, self.speed.approach, self.solution.equation)

    @derived
    def stance(self) -> tuple[StanceImpulse, ...]:
        """Impulses of the standing feet."""
        return stance_impulses(self.landing, self.proof)

    @derived
    def total(self) -> TotalImpulse:
        """Impulse of the ground as a whole."""
        return total_impulse(self.landing, self.proof)

    @property
    def total_impulse(self) -> Array:
        """Impulse (3,) of the ground on the robot, all contacts and standing feet together, world axes [N s]."""
        return self.total.force

    @property
    def total_moment(self) -> Array:
        """Moment (3,) of the same about the robot's centre of mass, world axes [N m s]."""
        return self.total.moment

    @derived
    def loads(self) -> tuple[JointLoad, ...]:
        """Impulses through the joints."""
        return joint_loads(self.landing, self.proof)

    @derived
    def energy(self) -> Energy:
        """Kinetic energy that the impact takes."""
        return energy(self.landing, self.proof)

    @property
    def energy_lost(self) -> float:
        """Kinetic energy that the impact takes [J]."""
        return self.energy.lost

    @property
    def energy_share(self) -> float | None:
        """The same of the kinetic energy before it [1]; None where that is not determined (fixed base, standing feet)."""
        return self.energy.share

    @derived
    def bracket(self) -> tuple[Bracket, ...]:
        """Shock with free, modelled and locked joints."""
        return joint_bracket(self.landing, self.proof, self.v_in)

    @derived
    def health(self) -> Health:
        """How far to trust the numbers (sensitivity to the data, warnings)."""
        choice, rows = self.solution.choice, len(self.proof.impulse)
        most, data = data_warnings(self.landing, self.proof, self.translates)
        return Health(
            rank=len(choice.rows),
            rows=rows,
            error_bound=float(np.max(self.proof.bounds)),
            body_error_bounds=tuple(map(float, self.proof.bounds)),
            double_error=double_error(self.landing, self.proof, self.solution.jumps[..., 3]),
            data_sensitivity=most,
            bits=self.proof.bits,
            warnings=(
                *(Diagnostic("robot", self.robot.name, None, text) for text in self.robot.warnings),
                *self.landing.warnings,
                *implausible(self.landing, self.contacts),
                *nearly_singular(self.landing, self.proof),
                *data,
                *pulled(self.landing, self.proof),
                *gained(self.landing, self.energy),
                *saturated(self.scene, self.points),
                *self.geometry[2],
            ),
        )

    def shock_at(self, body: str, r: Array) -> Array:
        """Shock at points of a body, |Δv + Δω × r| / v_in [1]. Args: r (..., 3) in the body's frame [m]."""
        i = self.bodies.index(body)
        return np.asarray(shock_at(self.delta_omega[i], self.delta_v[i], np.asarray(r, dtype=float), self.v_in))
