"""A landing for every velocity of the base, as matrices that the velocity multiplies.

They give the jumps, the impulses, and what contradicts the contacts.
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
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.quantity import quantity_values
from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile

ROUNDING = 1e-12
"""Share of the largest entry below which one is rounding."""

LEVEL = 1e-9
"""Share of the speed below which a velocity has no part along an axis."""


class StrikeMatrices(NamedTuple):
    """Matrices of what follows from the velocity s of the base [m/s, world axes].

    A number is its matrix (4,) times (s, 1).

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


def strike_matrices(proof: LandingProof) -> StrikeMatrices:
    """The matrices of a solution, from its jumps and impulses for four strikes.

    These are the unit strikes, and that of the scene.
    """
    residuals = residual(proof)
    motion = _affine(proof, residuals.motion)
    impact = _for_unit_strikes(proof)
    loads = _matrices(impact, "joint", ("along", "force", "moment"))
    if not proof.row_space.unique.all():
        loads = np.full_like(loads, np.nan)
    return StrikeMatrices(
        jumps=_affine(proof, proof.jumps),
        contacts=_matrices(impact, "contact", ("impulse",)),
        loads=loads,
        left=_affine(proof, residuals.left),
        speeds=_affine(proof, residuals.speeds),
        motion=motion.T @ motion,
        rounding=residuals.rounding,
    )


def _affine(proof: LandingProof, values: Array) -> Array:
    """Matrices (..., 4) of values (..., 4) for four strikes.

    These are of 1 m/s along x, y and z without other motion, and the scene's.
    """
    constant = values[..., 3] - values[..., :3] @ proof.landing.before.velocity
    return np.concatenate([values[..., :3], constant[..., None]], axis=-1)


def _for_unit_strikes(proof: LandingProof) -> DoubleImpact:
    """The impact for strikes of 1 m/s along x, y and z, and for none."""
    landing, row_space = proof.landing, proof.row_space
    rank = len(row_space.rows)
    independent = proof.impulse[row_space.rows]
    solution = Solution(
        proof.delta_qd[None],
        proof.impulse[None],
        np.ones((1, len(proof.impulse))),
        np.array([rank]),
        np.ones(1),
        {0: row_space},
        {0: independent},
    )
    equation = landing.equation(landing.state)._replace(G=None)
    strikes = np.concatenate([np.eye(3), np.zeros((1, 3))])
    return DoubleImpact(landing, equation, solution, proof.jumps[None], strikes=strikes[None])


def _matrices(impact: DoubleImpact, kind: PlaceKind, keys: tuple[str, ...]) -> Array:
    """The matrices (n, m, 4) of quantities at n places, whose m components are side by side."""
    places = impact.landing.places(kind)
    components = []
    for key in keys:
        values = quantity_values(quantity(kind, key), impact, places)[0]
        width = math.prod(values.shape[2:])
        components.append(values.reshape(*values.shape[:2], width))
    values = np.concatenate(components, axis=-1)
    values[:3] -= values[3]
    rounding = ROUNDING * np.nanmax(np.abs(values), initial=0.0)
    return np.asarray(np.where(np.abs(values) < rounding, 0.0, values).transpose(1, 2, 0))


def contact_normals(profile: ShockProfile) -> Array:
    """Directions (c, 3) against which the contacts strike, world.

    That of an end stop is the opposite of its approach.
    """
    normals = []
    for contact, constraint in zip(profile.contacts, profile.landing.contacts, strict=True):
        normal = constraint.normal
        if constraint.kind == "stop":
            normal = -contact.approach / np.linalg.norm(contact.approach)
        normals.append(normal)
    return np.array(normals)


def peak_per_speed(landing: PosedLanding) -> float | None:
    """The peak acceleration of the scene's pulse for a jump of 1 m/s [g s/m]; None without one."""
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
        """Angle from straight down, heading from forward to the left [rad], and speed [m/s].

        The heading is that of the horizontal part, 0 where there is none. A velocity (3,) that goes
        backward has a negative angle.
        """
        x = float(velocity @ self.forward)
        y = float(velocity @ self.left)
        z = float(velocity @ self.up)
        speed = math.hypot(x, y, z)
        level = math.hypot(x, y)
        angle = math.atan2(level, -z)
        if x < -LEVEL * speed:
            return -angle, math.atan2(-y, -x), speed
        heading = math.atan2(y, x) if level > LEVEL * speed else 0.0
        return angle, heading, speed
