"""A landing with its solution and its proof, of which every result is a function; places, speeds and v_in read from the proof.

Shock is normalised by v_in, the speed of the fastest contact or of the centre of mass (shock paper, Section 3.3).
"""

import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from shockpc.core.impulse import RowChoice
from shockpc.core.percussion import norm
from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.exact.balls import Balls, balls, nearest
from shockpc.exact.proof import Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.model.rows import Equation
from shockpc.robot.record import Robot
from shockpc.trace import Trace

__all__ = ["Solved", "body_frames", "derived", "shock_in", "speed_in", "world"]

T = TypeVar("T")
S = TypeVar("S", bound="Solved")


def derived(compute: Callable[[S], T]) -> functools.cached_property[T]:
    """A property that is computed when it is first read; its time counts as a stage of the trace, named as its docstring begins."""
    label = re.split(r"[.:;(]", compute.__doc__ or "")[0].strip()

    @functools.wraps(compute)
    def timed(owner: S) -> T:
        with owner.trace.stage(label):
            return compute(owner)

    return functools.cached_property(timed)


def _normalising_speed(of: "Solved") -> float:
    """Speed by which shock is normalised."""
    fastest = float(np.abs(np.concatenate(of.landing.before)).max())
    v_in = of.read(lambda impact: nearest(speed_in(impact, of.landing), 1e-12 * fastest)).item()
    if not v_in > 0.0:
        raise SceneError(
            'the robot\'s centre of mass is at rest before the impact, so it cannot normalise shock; use v_in = "contact"'
        )
    return v_in


def _approach(of: "Solved") -> Array:
    """Velocities of the contact points before the impact."""
    fastest = float(np.abs(np.concatenate(of.landing.before)).max())
    return of.read(lambda impact: nearest(_approach_in(impact, of.landing), fastest))


@dataclass(frozen=True, eq=False)
class Solved:
    """A landing with its solution.

    Attributes:
        landing: the scene resolved on the robot.
        equation: Eq. 4 in the scene's posture, in double precision.
        double_jumps: (nb, 6, 4) its solution, the jump (Δω, Δv) of every body in body coordinates, as in `Proof`.
        proof: enclosures of the exact solution.
        trace: collects what each part cost.
        v_in: speed by which shock is normalised, of the fastest contact or of the centre of mass [m/s].
        approach: (n, 3) velocity of every contact point before the impact, world axes [m/s].
    """

    landing: Landing
    equation: Equation = field(repr=False)
    double_jumps: Array = field(repr=False)
    proof: Proof = field(repr=False)
    trace: Trace = field(repr=False)

    v_in = derived(_normalising_speed)
    approach = derived(_approach)

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.landing.robot

    @property
    def choice(self) -> RowChoice:
        """Which rows are independent."""
        return self.proof.enclosure.inputs.choice

    def read(self, compute: Callable[[ExactImpact], T]) -> T:
        """What a function makes of the exact impact."""
        return self.proof.enclosure.read(compute)


def speed_in(impact: ExactImpact, landing: Landing) -> Balls:
    """The speed v_in (1,)."""
    if landing.scene.v_in == "com":
        robot = landing.robot
        velocities, mass = impact.velocities_before(range(len(robot.bodies)), robot.coms), balls(robot.masses)
        return np.asarray(norm(np.sum(velocities * mass[:, None], axis=0) / np.sum(mass))[None])
    speeds = norm(_approach_in(impact, landing))
    return np.array([max(speeds.tolist(), key=float)], dtype=object)


def _approach_in(impact: ExactImpact, landing: Landing) -> Balls:
    """Velocity (n, 3) of every contact point before the impact, world axes."""
    blocks = impact.inputs.blocks[: len(landing.contacts)]
    return impact.velocities_before([block.body for block in blocks], np.array([block.point for block in blocks]))


def shock_in(impact: ExactImpact, landing: Landing, bodies: Sequence[int], r: Array) -> Array:
    """Shock (n,) at points of bodies [1]. Args: r (n, 3) in the bodies' frames [m]."""
    jumps, v_in = impact.body_jumps[..., 3], speed_in(impact, landing)
    speed = norm(velocity_at(jumps[bodies, :3], jumps[bodies, 3:], balls(r)))
    return nearest(speed / v_in, np.abs(jumps.astype(float)).max() / float(v_in[0]))


def world(impact: ExactImpact, landing: Landing, bodies: Sequence[int], r: Array | Balls) -> Array:
    """Positions (n, 3) of points of bodies, world [m]. Args: r (n, 3) in the bodies' frames [m]."""
    origin = landing.state.origin[0]
    reach = float(np.abs(origin).max() + np.abs(landing.state.position[0]).max()) + 1e-3
    size = reach + np.abs(r.astype(float)).max(axis=1, keepdims=True)
    return nearest(impact.points(bodies, r) + balls(origin), size)


def body_frames(of: Solved) -> tuple[Array, Array]:
    """Frames of the bodies: origins (nb, 3) in the world [m], and rotations (nb, 3, 3), body to world."""
    bodies = range(len(of.robot.bodies))
    zero = np.zeros((len(bodies), 3))
    return of.read(lambda impact: (world(impact, of.landing, bodies, zero), nearest(impact.orientations, 1.0)))
