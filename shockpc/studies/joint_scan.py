"""A landing with a joint at many values: a number in each posture, for every strike angle."""

import contextlib
import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.columns import BLOCK, Column, Postures, postures
from shockpc.impact.solve import UNPHYSICAL
from shockpc.landing.closure import follow
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import held_joints, set_joints
from shockpc.profile import FASTEST_PLAUSIBLE_RATE, ILL_CONDITIONED, profile_of
from shockpc.robot.robot import Joint
from shockpc.text.errors import SceneError, ShockError, SolveError, StudyError

Read: TypeAlias = Callable[[Postures, slice], Array]

ANGLES, AGAIN, ROUNDS = 43, 12, 6
"""Strike angles of a range among which the greatest number is sought, how many between the two beside it, and how often: to 1e-6 of
the range, which is 1e-12 of a smooth number."""

KEPT = 4096
"""Postures of a scan up to which their solutions are kept: 6 kB each of ANYmal B, 10 kB of Talos."""

STEPS = 3
"""Of regula falsi, which leave less than 1e-6 rad of the 0.04 rad between two strike angles."""


class Bound(NamedTuple):
    """A bound on a number; of one that may be negative on its magnitude.

    Attributes:
        value: the bound, above zero.
        below: whether it is the least value allowed, and not the greatest.
    """

    value: float
    below: bool

    @property
    def sign(self) -> float:
        """1 where greater numbers are worse, −1 where less are."""
        return -1.0 if self.below else 1.0

    def excess(self, numbers: Array) -> Array:
        """By how much numbers exceed the bound, relative to it or to them; beyond any bound where there is no number."""
        with np.errstate(divide="ignore"):
            ratio = np.divide(self.value, numbers) if self.below else np.divide(numbers, self.value)
        return np.nan_to_num(ratio - 1.0, nan=UNPHYSICAL, posinf=UNPHYSICAL)

    def number(self, excess: float) -> float:
        """The number with an excess."""
        return self.value / (1.0 + excess) if self.below else self.value * (1.0 + excess)


class JointScan:
    """A landing with some joints at other values, the same for all of them.

    The strike angle turns the part of the velocity in the plane; the part out of it, and what else moves, stays as it is.

    Args:
        landing: in the scene's posture.
        target: the number; of one that may be negative the magnitude.
        bound: of the number.
        feasible: the column that tells whether flat ground allows a landing.
        joints: that are moved.
        values: to which they are moved, ascending [rad, m].
        fine: to which the value is found beyond which a loop cannot be closed [rad, m].

    Attributes:
        values: (n,) those that can be reached [rad, m].
        own: (n,) the number for the scene's own strike; NaN without a result.
        unreachable: (least value, greatest value, reason) of the ranges in which a loop cannot be closed or there is no result.
        inaccurate: number of postures in which rounding may show above 1e-9.

    Raises:
        StudyError: no loop can be closed at any value.
    """

    def __init__(
        self,
        landing: PosedLanding,
        target: Column,
        bound: Bound,
        feasible: Column,
        joints: tuple[Joint, ...],
        values: Array,
        fine: float,
    ) -> None:
        self._landing, self._target, self._bound, self._feasible, self._joints = landing, target, bound, feasible, joints
        velocity, normal = landing.before.velocity, landing.plane.normal
        self._out_of_plane = (velocity @ normal) * normal
        self._speed = float(np.linalg.norm(velocity - self._out_of_plane))
        posture, moved = landing.scene.posture, {joint.name for joint in joints}
        self._proofs: dict[bytes, Postures | ShockError] = {}
        self._kept: list[Postures] | None = None
        self._held = held_joints(landing.robot, posture, landing.scene.assemble)
        led = [mimic.joint for mimic in landing.robot.mimics if not moved.isdisjoint(mimic.leaders)]
        self._held |= landing.robot.velocities([*moved, *led])
        found, open_ = self._postures(values, fine)
        self.values, self._Q = np.array(list(found)), np.stack(list(found.values()))
        blocks = list(self._blocks(self._Q))
        self._kept = blocks if len(self._Q) <= KEPT else None
        ranks, counts = np.unique(np.concatenate([block.solution.rank for block in blocks]), return_counts=True)
        self._rank, refused = int(ranks[np.argmax(counts)]), dict[int, str]()
        self.inaccurate = sum(int((~self._singular(block) & (block.condition > ILL_CONDITIONED)).sum()) for block in blocks)
        self.own = self._each(self._Q, self._at(np.full((len(self._Q), 1), self.own_angle)), refused)[:, 0]
        self.unreachable = tuple(sorted({*open_, *_ranges(self.values, refused)}))

    @property
    def own_angle(self) -> float:
        """The scene's strike angle [rad]."""
        return self._landing.strike_angle

    def over(self, angles: Array) -> Array:
        """The number (n, S) in every posture at strike angles (S,) or (n, S) [rad]; NaN without a result."""
        return self._each(self._Q, self._at(np.broadcast_to(angles, (len(self._Q), np.shape(angles)[-1]))))

    def feasible(self, low: float, high: float) -> np.ndarray:
        """Whether (n,) flat ground allows the landing of every posture at all strike angles of a range [rad]."""
        angles = np.broadcast_to(_range(low, high), (len(self._Q), len(_range(low, high))))
        return np.asarray((self._each(self._Q, self._at(angles, self._feasible)) == 1.0).all(axis=1))

    def worst(self, low: float, high: float, value: float | None = None) -> tuple[Array, Array]:
        """The worst number (n,) over a range of strike angles [rad], NaN without a result, and the strike angle (n,) of it.

        Args:
            low: least strike angle.
            high: greatest strike angle.
            value: one value of the joint, of which this is asked [rad, m]; by default those of the scan.
        """
        Q = self._Q
        if value is not None:
            Q = self._posture(value, Q[int(np.argmin(np.abs(self.values - value)))])[None]

        def search(block: Postures, rows: slice) -> Array:
            row = np.arange(len(block.condition))
            angles = np.tile(_range(low, high), (len(row), 1))
            numbers = self._numbers(block, angles, self._target)
            missing = np.isnan(numbers).any(axis=1)
            for _ in range(ROUNDS if high > low else 0):
                best = self._worst(numbers)
                before, after = (angles[row, np.clip(best + by, 0, angles.shape[1] - 1)] for by in (-1, 1))
                angles = np.linspace(before, after, AGAIN, axis=1)
                numbers = self._numbers(block, angles, self._target)
            best = self._worst(numbers)
            return np.stack([np.where(missing, np.nan, numbers[row, best]), angles[row, best]], axis=1)

        found = self._each(Q, search)
        return found[:, 0], found[:, 1]

    def kept(self, low: float, high: float) -> list[list[tuple[float, float]]]:
        """For every posture the intervals of strike angles at which the number keeps the bound [rad].

        An interval that lies between two of `ANGLES` strike angles is not seen.
        """
        angles = _range(low, high)
        beyond = self._bound.excess(self.over(angles))
        inside = beyond <= 0.0
        k, j = np.nonzero(inside[:, 1:] != inside[:, :-1])
        ends, sides = [angles[j], angles[j + 1]], [beyond[k, j], beyond[k, j + 1]]
        for _ in range(STEPS if len(k) else 0):
            middle = ends[0] - sides[0] * (ends[1] - ends[0]) / (sides[1] - sides[0])
            there = self._bound.excess(self._each(self._Q[k], self._at(middle[:, None]))[:, 0])
            same = (there <= 0.0) == (sides[0] <= 0.0)
            for side, replaced in enumerate((same, ~same)):
                ends[side], sides[side] = np.where(replaced, middle, ends[side]), np.where(replaced, there, sides[side])
        roots = ends[0] - sides[0] * (ends[1] - ends[0]) / (sides[1] - sides[0])
        found = []
        for row, flags in enumerate(inside):
            at = [*angles[:1][flags[:1]].tolist(), *roots[k == row].tolist(), *angles[-1:][flags[-1:]].tolist()]
            found.append(list(zip(at[::2], at[1::2], strict=False)))
        return found

    def _posture(self, value: float, near: Array) -> Array:
        """The configuration (nq,) with the joint at a value [rad, m]; loops are followed from a closed one near it."""
        landing, q = self._landing, near.copy()
        set_joints(landing.robot, [(joint, value) for joint in self._joints], q)
        return follow(landing.robot, near, q, landing.loops, landing.plane, self._held) if landing.loops else q

    def _postures(self, values: Array, fine: float) -> tuple[dict[float, Array], list[tuple[float, float, str]]]:
        """The configurations (nq,) by the values that can be reached, ascending, and the ranges that cannot be, with the reason.

        A loop is followed from the scene's own posture in both directions, each from the one before, so that it stays assembled in
        the same way; where it can no longer be closed, the walk ends.
        """
        start = int(np.argmin(np.abs(values - self._joints[0].value(self._landing.q))))
        found: dict[float, Array] = {}
        refused: list[tuple[float, float, str]] = []
        for walk in (values[start:].tolist(), values[start::-1].tolist()):
            near, last = self._landing.q, None
            for value in walk:
                try:
                    near = self._posture(value, near)
                except SceneError as refusal:
                    if last is not None:
                        last, near = self._farthest(last, value, near, fine)
                        found[last] = near
                    beyond = value if last is None else last
                    refused.append((min(beyond, walk[-1]), max(beyond, walk[-1]), str(refusal)))
                    break
                found[value], last = near, value
        if not found:
            raise StudyError(f"no value in the range can be assembled: {refused[0][2]}")
        return dict(sorted(found.items())), refused

    def _farthest(self, good: float, bad: float, near: Array, fine: float) -> tuple[float, Array]:
        """The last value that a loop can reach between one that it can and one that it cannot, and its configuration."""
        while abs(bad - good) > fine:
            middle = (good + bad) / 2.0
            try:
                near, good = self._posture(middle, near), middle
            except SceneError:
                bad = middle
        return good, near

    def _blocks(self, Q: Array) -> Iterator[Postures]:
        """Steps 1 and 2 in configurations (n, nq), some at a time; those of the scan once, if they are not too many."""
        if Q is self._Q and self._kept is not None:
            yield from self._kept
            return
        for k in range(0, len(Q), BLOCK):
            yield postures(self._landing, Q[k : k + BLOCK], [self._target])

    def _singular(self, block: Postures) -> np.ndarray:
        """Whether postures are singular or nearly so: other rows are independent than in most, or joints move very fast."""
        fast = ~(np.abs(block.equation.full(block.solution.delta_qd)).max(axis=(1, 2)) < FASTEST_PLAUSIBLE_RATE)
        return np.asarray((block.solution.rank != self._rank) | fast)

    def _at(self, angles: Array, target: Column | None = None) -> Read:
        """Reads the number (or another column) at strike angles (n, S) [rad]."""
        return lambda block, rows: self._numbers(block, angles[rows], target or self._target)

    def _each(self, Q: Array, read: Read, refused: dict[int, str] | None = None) -> Array:
        """What is read of configurations (n, nq), a row of each; NaN without a result. Singular postures are proven.

        Args:
            Q: the configurations.
            read: reads rows (m, ...) of a block; it is given the block, and which configurations are in it.
            refused: collects why there is no result, by the number of the configuration.
        """
        parts = []
        for k, block in zip(range(0, len(Q), BLOCK), self._blocks(Q), strict=True):
            part = read(block, slice(k, k + BLOCK))
            for i in np.flatnonzero(self._singular(block)).tolist():
                proven = self._proven(Q[k + i])
                part[i] = np.nan if isinstance(proven, ShockError) else read(proven, slice(k + i, k + i + 1))[0]
                if refused is not None and isinstance(proven, ShockError):
                    refused[k + i] = str(proven)
            parts.append(part)
        return np.concatenate(parts)

    def _numbers(self, block: Postures, angles: Array, target: Column) -> Array:
        """A number (m, S) of some postures at strike angles (m, S) [rad]; NaN where a contact does not approach the ground."""
        forward, up = self._landing.plane.forward, np.array([0.0, 0.0, 1.0])
        in_plane = self._speed * (np.sin(angles)[..., None] * forward - np.cos(angles)[..., None] * up)
        values, parting = block.values(in_plane + self._out_of_plane, [target])
        numbers, leaves = values[target.name], parting.any(axis=-1)
        if target.selection.quantity.alone(self._landing.scene):
            for i, s in np.argwhere(~leaves).tolist():
                before = self._landing.before._replace(velocity=in_plane[i, s] + self._out_of_plane)
                with contextlib.suppress(ShockError):  # there is no verdict, and no number
                    profile = profile_of(replace(self._landing.at(block.Q[i]), before=before))
                    numbers[i, s] = profile.numbers(target.selection, [target.place])[0]
        return np.where(leaves, np.nan, np.abs(numbers) if target.selection.signed else numbers)

    def _worst(self, numbers: Array) -> np.ndarray:
        """Indices (n,) of the worst among numbers (n, S)."""
        return np.asarray(np.argmax(np.nan_to_num(self._bound.sign * numbers, nan=-np.inf), axis=1))

    def _proven(self, q: Array) -> "Postures | ShockError":
        """One posture with the jumps and impulses of the proof, or why there is no verdict; each is computed once."""
        key = q.tobytes()
        if key not in self._proofs:
            try:
                self._proofs[key] = self._proof(q)
            except ShockError as refusal:
                self._proofs[key] = refusal
        return self._proofs[key]

    def _proof(self, q: Array) -> Postures:
        profile, (block,) = profile_of(self._landing.at(q)), self._blocks(q[None])
        if self._target.selection.quantity.shared and profile.redundant:
            raise SolveError("contacts or loops are redundant in this posture, so the number is not determined")
        proof = profile.proof
        solution = block.solution._replace(delta_qd=proof.delta_qd[None], impulse=proof.impulse[None])
        bodies = range(len(self._landing.robot.bodies)) if block.bodies is None else block.bodies
        return block._replace(equation=block.equation._replace(G=None), solution=solution, jumps=proof.jumps[None, list(bodies)])


def _range(low: float, high: float) -> Array:
    return np.linspace(low, high, ANGLES) if high > low else np.array([low])


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive postures without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]
