"""What an analysis gives back: a landing, its solution and its proof; everything else is computed when it is read."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np

from shockpc.core.percussion import shock_at
from shockpc.core.spatial import Array, jump_at
from shockpc.diagnostic import Diagnostic
from shockpc.results.accuracy import Health, data_warnings, double_error
from shockpc.results.balance import energy, gained, total_impulse
from shockpc.results.bracket import joint_bracket
from shockpc.results.contacts import contact_impulses, pulled, stance_impulses
from shockpc.results.loads import joint_loads
from shockpc.results.percussion import body_percussion, shock_ranges
from shockpc.results.plausibility import implausible
from shockpc.results.points import com_directions, point_shocks, saturated
from shockpc.results.proof import nearly_singular
from shockpc.results.solved import Solved, body_frames, derived
from shockpc.robot.geometry import body_outline

__all__ = ["ShockMaps", "ShockProfile"]

T = TypeVar("T")


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
        return np.asarray(jump_at(self.maps[:, body], self.rotation[:, body] @ point))


def _part(read: "Callable[[ShockProfile], T]") -> cached_property[T]:
    """A part of something else that the profile holds; arrays cannot be written to."""

    def protected(profile: "ShockProfile") -> T:
        found = read(profile)
        if isinstance(found, np.ndarray):
            found = found.view()
            found.flags.writeable = False
        return found

    return cached_property(protected)


class ShockProfile(Solved):
    """The shock of one landing, body by body; index i of every array is body i of the robot.

    The reported numbers are those of the proof: midpoints of enclosures, rounded to doubles. All but the parts of `Solved` are
    computed when they are first read.

    Attributes:
        scene: what was computed, with every default filled in.
        bodies: names of the bodies.
        plane: in which CoPc and RoPc are given.
        q: (nq,) configuration in Pinocchio's layout.
        joint_model: "free" (no reflected inertia), "geared" (every joint has some), "locked" (every joint holds) or "mixed".
        assembly: what closing the loops changed; None without loops.
        position: (nb, 3) origins of the body frames, world [m].
        rotation: (nb, 3, 3) of the body frames, body to world.
        delta_qd: (nv,) jump of the joint velocities, Pinocchio's layout [rad/s, m/s].
        maps: (nb, 6, 3) jump (Δω, Δv) of every body for a strike of 1 m/s along world x, y and z, body axes.
        delta_omega: (nb, 3) jump of angular velocity, body axes [rad/s] (Eqs. 8 and 9).
        delta_v: (nb, 3) jump of velocity of the body frame's origin, body axes [m/s] (Eqs. 8 and 9).
        moved: (nb,) whether the strike moves the body by more than 1e-12 of the fastest one.
        strike: (3,) velocity of the fastest contact before the impact, world axes [m/s].
        copc, copc_world, ropc, translates, pitch, off_plane, shock_com: centres and radii of percussion, as in `BodyPercussion`.
        shock_min: (nb,) least shock over the body's geometry [1]; NaN without geometry.
        shock_max: (nb,) greatest shock over the body's geometry [1]; NaN without geometry.
        points: shock at sensors and points.
        directions: most and least severe impact directions of the bodies' centres of mass.
        contacts: impulses, friction and effective masses of the contacts.
        stance: impulses of the standing feet.
        total_impulse: (3,) impulse of the ground on the robot, all contacts and standing feet together, world axes [N s].
        total_moment: (3,) moment of the same about the robot's centre of mass, world axes [N m s].
        loads: impulses through the joints.
        energy_lost: kinetic energy that the impact takes [J].
        energy_share: the same of the kinetic energy before it [1]; None where that is not determined (fixed base, standing feet).
        bracket: shock with free, modelled and locked joints.
        health: how far to trust the numbers (sensitivity to the data, warnings).
    """

    scene = _part(lambda profile: profile.landing.scene)
    bodies = _part(lambda profile: tuple(body.name for body in profile.robot.bodies))
    plane = _part(lambda profile: profile.landing.plane)
    q = _part(lambda profile: profile.landing.q)
    joint_model = _part(lambda profile: profile.landing.joint_model.name)
    assembly = _part(lambda profile: profile.landing.assembly)

    _frames = derived(body_frames)
    position = _part(lambda profile: profile._frames[0])
    rotation = _part(lambda profile: profile._frames[1])
    delta_qd = _part(lambda profile: profile.proof.delta_qd[:, 3])
    maps = _part(lambda profile: profile.proof.jumps[..., :3])
    delta_omega = _part(lambda profile: profile.proof.jumps[:, :3, 3])
    delta_v = _part(lambda profile: profile.proof.jumps[:, 3:, 3])
    moved = _part(lambda profile: _moved(profile.proof.jumps[..., 3]))
    strike = _part(lambda profile: profile.approach[np.argmax(np.linalg.norm(profile.approach, axis=1))])

    percussion = derived(body_percussion)
    copc = _part(lambda profile: profile.percussion.copc)
    copc_world = _part(lambda profile: profile.percussion.copc_world)
    ropc = _part(lambda profile: profile.percussion.ropc)
    translates = _part(lambda profile: profile.percussion.translates)
    pitch = _part(lambda profile: profile.percussion.pitch)
    off_plane = _part(lambda profile: profile.percussion.off_plane)
    shock_com = _part(lambda profile: profile.percussion.shock_com)

    _range = derived(shock_ranges)
    shock_min = _part(lambda profile: profile._range[0])
    shock_max = _part(lambda profile: profile._range[1])
    points = derived(point_shocks)
    directions = derived(com_directions)

    contacts = derived(contact_impulses)
    stance = derived(stance_impulses)
    _total = derived(total_impulse)
    total_impulse = _part(lambda profile: profile._total[0])
    total_moment = _part(lambda profile: profile._total[1])
    loads = derived(joint_loads)
    _energy = derived(energy)
    energy_lost = _part(lambda profile: profile._energy[0])
    energy_share = _part(lambda profile: profile._energy[1])
    bracket = derived(joint_bracket)

    @derived
    def health(self) -> Health:
        """How far to trust the numbers (sensitivity to the data, warnings)."""
        landing, proof, robot = self.landing, self.proof, self.robot.name
        most, data = data_warnings(self, self.translates)
        return Health(
            rank=len(self.choice.rows),
            rows=len(proof.impulse),
            error_bound=float(np.max(proof.bounds)),
            body_error_bounds=tuple(map(float, proof.bounds)),
            double_error=double_error(landing, proof, self.double_jumps[..., 3]),
            data_sensitivity=most,
            bits=proof.bits,
            warnings=(
                *(Diagnostic("robot", robot, None, text) for text in self.robot.warnings),
                *landing.warnings,
                *implausible(landing, self.contacts),
                *nearly_singular(landing, proof),
                *data,
                *pulled(self),
                *gained(self, self.energy_lost),
                *saturated(landing.scene, self.points),
                *(Diagnostic("geometry", robot, None, text) for text in body_outline(self.robot).warnings),
            ),
        )

    def shock_at(self, body: str, r: Array) -> Array:
        """Shock at points of a body, |Δv + Δω × r| / v_in [1]. Args: r (..., 3) in the body's frame [m]."""
        i = self.bodies.index(body)
        return np.asarray(shock_at(self.delta_omega[i], self.delta_v[i], np.asarray(r, dtype=float), self.v_in))


def _moved(jumps: Array) -> np.ndarray:
    """Which bodies (nb,) move by more than 1e-12 of the fastest one. Args: jumps (nb, 6)."""
    motion = np.linalg.norm(jumps[:, :3], axis=1) + np.linalg.norm(jumps[:, 3:], axis=1)
    return np.asarray(motion > 1e-12 * motion.max())
