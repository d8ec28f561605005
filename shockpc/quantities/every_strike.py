"""A landing for every velocity of the base: jumps, impulses, and what contradicts the contacts, as
matrices that it multiplies.
"""

import math
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.pulse import peak_acceleration
from shockpc.core.spatial import Array
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import LandingProof, residual
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import PlaceKind
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.quantity import evaluate
from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile


class EveryStrike(NamedTuple):
    """What follows from the velocity s of the base [m/s, world axes]: a number is its matrix (4,)
    times (s, 1).

    Attributes:
        jumps: (nb, 6, 4) of the bodies (Δω, Δv at the origin of the frame), world axes [rad/s,
            m/s].
        contacts: (nc, 3, 4) impulses of the ground at contacts and standing feet, world axes [N s];
            NaN where not determined.
        loads: (nj, 7, 4) impulses through the joints: along the axis [N m s, N s], force [N s],
            moment [N m s]; NaN the same.
        left: (k, 4) velocity that a solution leaves along each row that depends on others [m/s,
            rad/s].
        speeds: (nr, 4) velocity before the impact along every row.
        motion: (4, 4) of which (s, 1) on both sides is the square of the size of the motion.
        rounding: (k,) share of that size which rounding may leave.
    """

    jumps: Array
    contacts: Array
    loads: Array
    left: Array
    speeds: Array
    motion: Array
    rounding: Array


def every_strike(proof: LandingProof) -> EveryStrike:
    """The matrices of a solution, from its jumps and impulses for unit strikes and for that of the
    scene.
    """
    residuals = residual(proof)
    motion = _affine(proof, residuals.motion)
    return EveryStrike(
        _affine(proof, proof.jumps),
        *_impulses(proof),
        _affine(proof, residuals.left),
        _affine(proof, residuals.speeds),
        motion.T @ motion,
        residuals.rounding,
    )


def _affine(proof: LandingProof, values: Array) -> Array:
    """Matrices (..., 4) of values (..., 4) for strikes of 1 m/s along x, y and z without other
    motion, then for the scene's.
    """
    constant = values[..., 3] - values[..., :3] @ proof.landing.before.velocity
    return np.concatenate([values[..., :3], constant[..., None]], axis=-1)


def _impulses(proof: LandingProof) -> tuple[Array, Array]:
    """The matrices of the impulses of contacts and standing feet (nc, 3, 4), and through the joints
    (nj, 7, 4).
    """
    landing, row_space = proof.landing, proof.row_space
    equation = landing.equation(landing.state)._replace(G=None)
    solution = Solution(
        proof.delta_qd[None],
        proof.impulse[None],
        np.ones((1, len(proof.impulse))),
        np.array([len(row_space.rows)]),
        np.ones(1),
        {0: row_space},
        {0: proof.impulse[row_space.rows]},
    )
    strikes = np.concatenate([np.eye(3), np.zeros((1, 3))])
    impact = DoubleImpact(landing, equation, solution, proof.jumps[None], strikes=strikes[None])

    def matrices(kind: PlaceKind, *keys: str) -> Array:
        values = (evaluate(quantity(kind, key), impact, landing.places(kind))[0] for key in keys)
        parts = np.concatenate(
            [part.reshape(*part.shape[:2], math.prod(part.shape[2:])) for part in values], axis=-1
        )
        parts[:3] -= parts[3]
        least = 1e-12 * np.nanmax(np.abs(parts), initial=0.0)  # below which it is rounding
        return np.asarray(np.where(np.abs(parts) < least, 0.0, parts).transpose(1, 2, 0))

    loads = matrices("joint", "along", "force", "moment")
    return matrices("contact", "impulse"), loads if row_space.unique.all() else np.full_like(
        loads, np.nan
    )


def contact_normals(profile: ShockProfile) -> Array:
    """Directions (c, 3) against which the contacts strike, world; of an end stop the opposite of
    its approach.
    """
    pairs = zip(profile.contacts, profile.landing.blocks, strict=False)  # standing feet come last
    return np.array(
        [
            -one.approach / np.linalg.norm(one.approach) if block.kind == "stop" else block.normal
            for one, block in pairs
        ]
    )


def peak_per_speed(landing: PosedLanding) -> float | None:
    """The peak acceleration for a jump of 1 m/s, by the pulse of the scene [g s/m]; None without
    one.
    """
    return None if landing.pulse is None else peak_acceleration(1.0, landing.pulse) / GRAVITY


class StrikeAxes(NamedTuple):
    """Axes (3,) in which a strike has an angle and a heading, world.

    Attributes:
        forward: along the ground, in the plane.
        left: along the ground.
        up: away from it.
    """

    forward: Array
    left: Array
    up: Array

    @classmethod
    def of(cls, profile: ShockProfile) -> "StrikeAxes":
        """Those of a landing."""
        forward, up = profile.plane.forward, profile.landing.up
        forward = forward - up * (forward @ up)
        forward /= np.linalg.norm(forward)
        return cls(forward, np.cross(up, forward), up)

    def polar(self, velocity: Array) -> tuple[float, float, float]:
        """Angle from straight down and heading of the horizontal part from forward to the left
        [rad], and speed [m/s].

        A velocity (3,) that goes backward has a negative angle.
        """
        x, y, z = (
            float(velocity @ self.forward),
            float(velocity @ self.left),
            float(velocity @ self.up),
        )
        speed, level = math.hypot(x, y, z), math.hypot(x, y)
        angle, heading = math.atan2(level, -z), math.atan2(y, x) if level > 1e-9 * speed else 0.0
        return (-angle, math.atan2(-y, -x), speed) if x < -1e-9 * speed else (angle, heading, speed)
