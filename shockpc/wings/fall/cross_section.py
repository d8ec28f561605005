"""A rigid convex body in the plane of its fall: corners, arms, energy and balance."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.text.errors import StudyError

SETTLES = math.radians(5.0)
"""Rotation up to which a body that comes to rest on another side still stands [rad]."""


class SectionMotion(NamedTuple):
    """Rotation [rad], place of the centre of mass forward and up [m], and their rates."""

    theta: float
    x: float
    z: float
    vx: float
    vz: float
    omega: float


@dataclass(frozen=True, eq=False)
class CrossSection:
    """A rigid body in the plane of its fall.

    Attributes:
        mass: [kg]
        inertia: about the centre of mass [kg m²].
        corners: (n, 2) of its convex hull at rotation zero, in the order in which they meet the
            ground as it tips forward.
        level: (n,) rotation at which the side from each corner to the next one is on the ground,
            increasing within a turn [rad].
    """

    mass: float
    inertia: float
    corners: Array
    level: Array

    @classmethod
    def of(cls, mass: float, inertia: float, points: Array) -> "CrossSection":
        """The section of a body with points (k, 2) on its surface.

        The points are forward and up from the centre of mass [m].

        Raises:
            StudyError: the points are on a line.
        """
        try:
            corners = points[ConvexHull(points).vertices]  # anticlockwise
        except QhullError:
            raise StudyError(
                "the geometry is a point or a line in the plane of the fall, over which nothing "
                "can tip"
            ) from None
        sides = np.roll(corners, -1, axis=0) - corners
        level = np.arctan2(sides[:, 1], sides[:, 0])
        first = int(np.argmin(level))
        return cls(mass, inertia, np.roll(corners, -first, axis=0), np.roll(level, -first))

    def side(self, corner: int) -> float:
        """Rotation at which the side from a corner to the next one is on the ground [rad].

        Corners are counted on from turn to turn.
        """
        turn, k = divmod(corner, len(self.level))
        return float(self.level[k]) + 2.0 * math.pi * turn

    def lowest(self, theta: float) -> int:
        """The lowest corner at a rotation [rad]; of two on the ground the forward one.

        Corners are counted on from turn to turn.
        """
        turn = int((theta - float(self.level[0])) // (2.0 * math.pi))
        within = np.searchsorted(self.level, theta - 2.0 * math.pi * turn, side="right")
        return int(within) + turn * len(self.level)

    def at(self, corner: int, theta: float) -> tuple[float, float]:
        """A corner from the centre of mass, forward and up [m]."""
        a, b = self.corners[corner % len(self.corners)]
        c = math.cos(theta)
        s = math.sin(theta)
        return float(a * c + b * s), float(b * c - a * s)

    def arm(self, corner: int) -> tuple[float, float, float]:
        """The arm of a corner: distance to the centre of mass c [m], angle φ [rad] and κ [1].

        φ is from the vertical at rotation zero.
        """
        a, b = self.corners[corner % len(self.corners)].tolist()
        c = math.hypot(a, b)
        return c, math.atan2(-a, -b), self.mass * c * c / (self.inertia + self.mass * c * c)

    def energy(self, motion: SectionMotion) -> float:
        """Kinetic and potential energy [J]."""
        speed = motion.vx**2 + motion.vz**2
        kinetic = 0.5 * (self.mass * speed + self.inertia * motion.omega**2)
        return kinetic + self.mass * GRAVITY * motion.z

    def pivoting(self, corner: int, theta: float, omega: float, x: float = 0.0) -> SectionMotion:
        """The motion about a corner at rest at a place [m]."""
        a, b = self.at(corner, theta)
        return SectionMotion(theta, x - a, -b, -omega * b, omega * a, omega)

    def forces(
        self, corner: int, theta: Array | float, squared: Array | float
    ) -> tuple[Array, Array]:
        """Forces T and N of the ground on a corner that sticks, by mass [m/s²].

        They are along the ground and upward. Args: squared, ω².
        """
        c, angle, kappa = self.arm(corner)
        sine, cosine = np.sin(theta + angle), np.cos(theta + angle)
        turning = kappa * GRAVITY * sine
        return (
            turning * cosine - squared * c * sine,
            GRAVITY - turning * sine - squared * c * cosine,
        )

    def squared_rate(self, corner: int, theta: Array | float, start: SectionMotion) -> Array:
        """ω² of a body that pivots about a corner from a motion [rad²/s²]."""
        c, angle, kappa = self.arm(corner)
        gain = 2.0 * kappa * GRAVITY / c * (math.cos(start.theta + angle) - np.cos(theta + angle))
        return np.asarray(start.omega**2 + gain)

    def balance(self, corner: int) -> tuple[int, float]:
        """Corner and rotation in which the body balances, tipping on from a corner.

        It falls forward from there by itself.

        The rotation is that at which the centre of mass is above the corner, or at which the corner
        meets the ground if the centre of mass is in front of it then. Sides that are on the ground
        within a rotation of `SETTLES` belong to the support if the body comes to rest on them.
        """
        k = corner
        while self.side(k) <= SETTLES:
            k += 1
            if self.arm(k)[1] + self.side(k - 1) < 0.0:
                corner = k
        while self.arm(corner)[1] + self.side(corner) < 0.0:
            corner += 1
        return corner, max(-self.arm(corner)[1], self.side(corner - 1))

    def least_rate(self, corner: int, theta: float) -> float:
        """The rate on a corner at a rotation with which the body just reaches the balance [rad/s].

        It rolls there without slip.
        """
        # Backwards from the balance, where it is at rest: what was gained on the way up is
        # subtracted (it is negative), and each change of corner had kept a share of the rate.
        last, top = self.balance(corner)
        squared = 0.0
        for k in range(last, corner - 1, -1):
            low = theta if k == corner else self.side(k - 1)
            at_rest = SectionMotion(low, 0.0, 0.0, 0.0, 0.0, 0.0)
            squared = max(squared - float(self.squared_rate(k, top, at_rest)), 0.0)
            if k > corner:
                squared /= self._kept(k - 1, k, low) ** 2
                top = low
        return math.sqrt(squared)

    def _kept(self, old: int, new: int, theta: float) -> float:
        """Share of the rate that is left as a sticking body rolls from a corner to another one.

        Both corners are on the ground.
        """
        (a, b), (c, d) = self.at(old, theta), self.at(new, theta)
        about_old = self.inertia + self.mass * (a * c + b * d)
        return about_old / (self.inertia + self.mass * (c * c + d * d))
