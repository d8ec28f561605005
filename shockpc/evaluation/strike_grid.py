"""Landings that differ in one quantity, each at other strike angles."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.landings import Chunk, Group, LandingsBeside, Refusal
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.varied import VariedLandings
from shockpc.evaluation.varied_scene import applied
from shockpc.landing.resolve import close_loops
from shockpc.landing.scene import Strike
from shockpc.profile import profile_of_scene
from shockpc.quantities.profile import ShockProfile

PART = 1024
"""Largest number of postures of a chunk."""


@dataclass(frozen=True, eq=False)
class StrikeGrid(LandingsBeside):
    """Landings that differ in one quantity, each at other strike angles.

    The strike angle turns the part of the velocity that is in the plane; after a fall from a drop height its vertical component
    stays. The part out of the plane, and what else moves, stays as it is.

    Attributes:
        landing: in the scene's posture.
        varied: the quantity, with its values in n postures.
        angles: (n, S) strike angles of each posture [rad].
        Q: (n, nq) configurations of a joint's values; None for other quantities.
    """

    varied: Variation
    angles: Array = field(repr=False)
    Q: Array | None = field(default=None, repr=False)

    noun = "limits"

    @property
    def kinds(self) -> tuple[str, ...]:
        """What varies."""
        return (self.varied.kind,)

    @property
    def strikes(self) -> int:
        """Number of strike angles of each posture."""
        return int(self.angles.shape[1])

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.angles.size

    @property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """Of `PART` postures each."""
        n = len(self.angles)
        return tuple((k, min(k + PART, n)) for k in range(0, n, PART))

    @property
    def headings(self) -> tuple[str, ...]:
        """Of the value and of the strike angle."""
        return self.varied.column, "strike angle [rad]"

    @property
    def description(self) -> dict[str, Any]:
        """The values, and the strike angles of each."""
        return {"subject": self.varied.subject, "values": self.varied.values, "strike angles": self.angles.tolist()}

    def chunk(self, k: int, data: None) -> Chunk:
        """Some postures: those of a joint in one landing, those of another quantity as in a sweep."""
        (a, b), S = self.chunks[k], self.strikes
        angles, values = self.angles[a:b], self.varied.values[a:b]
        speeds, Q = np.full(b - a, self.speed), None if self.Q is None else self.Q[a:b]
        if self.varied.kind == "speed":  # of one posture
            speeds, Q = np.array(values), np.repeat(self.landing.q[None], b - a, axis=0)
        sweep = VariedLandings(self.scene, self.robot, (replace(self.varied, values=values),))

        def groups() -> Iterator[Group | Refusal]:
            for group in sweep.chunk(0, None).groups if Q is None else [Group(np.arange(b - a), self.landing, Q)]:
                if isinstance(group, Refusal):
                    yield group
                else:
                    yield group._replace(strikes=self.velocities(angles[group.postures], speeds[group.postures, None]))

        def profile(i: int) -> ShockProfile:
            if Q is None:
                scene, robot = sweep.case(i // S)
            else:
                scene, robot = applied(self.scene, self.robot, self.varied, values[i // S])
                scene = close_loops(scene, self.landing.at(Q[i // S])) if self.landing.loops else scene
            x, y, z = self.velocities(angles.flat[i], speeds[i // S]).tolist()
            given = scene.strike
            strike = Strike(velocity=(x, y, z), angular_velocity=given.angular_velocity, joint_velocities=given.joint_velocities)
            return profile_of_scene(replace(scene, strike=strike), robot)

        labels = {self.headings[0]: np.repeat(values, S), self.headings[1]: angles.ravel()}
        return Chunk(labels, groups(), profile)

    @property
    def out_of_plane(self) -> Array:
        """The part (3,) of the base's velocity that is out of the plane, world axes [m/s]."""
        return np.asarray((self.landing.before.velocity @ self.landing.plane.normal) * self.landing.plane.normal)

    @property
    def speed(self) -> float:
        """Of the base in the plane [m/s]."""
        return float(np.linalg.norm(self.landing.before.velocity - self.out_of_plane))

    def velocities(self, angles: Any, speed: Any) -> Array:
        """The velocities (..., 3) of the base at strike angles (...) [rad], world axes [m/s].

        Args:
            angles: the strike angles.
            speed: in the plane (...), after a fall at the strike angle of the scene [m/s].
        """
        if self.scene.strike.drop_height is not None:
            speed = speed * np.cos(self.landing.strike_angle) / np.cos(angles)
        sine, cosine = np.sin(angles)[..., None], np.cos(angles)[..., None]
        in_plane = sine * self.landing.plane.forward - cosine * np.array([0.0, 0.0, 1.0])
        return np.asarray(np.asarray(speed)[..., None] * in_plane + self.out_of_plane)
