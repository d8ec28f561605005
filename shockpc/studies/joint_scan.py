"""A landing with a joint at many values: the shock at a point in each posture, for every strike angle.

With E the map from the strike's components to the velocity of the point, the shock of a strike at the angle θ is
|E (sin θ, cos θ)|. Its square is uᵀ gram u with gram = EᵀE and u = (sin θ, cos θ), or m + r cos(2θ − φ).
"""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from shockpc.core.spatial import Array, cross_matrix
from shockpc.errors import SceneError, ShockError, StudyError
from shockpc.landing import PosedLanding
from shockpc.model.closure import assemble
from shockpc.model.posture import held_joints, set_joints
from shockpc.places import Place
from shockpc.profile import FASTEST_PLAUSIBLE_RATE, ILL_CONDITIONED, profile_of, shock_maps
from shockpc.robot.record import Joint
from shockpc.solve import UNPHYSICAL

__all__ = ["JointScan", "greatest_shock", "wave"]


class JointScan:
    """A landing with some joints at other values, the same for all of them.

    Args:
        landing: in the scene's posture.
        place: where the shock is computed.
        joints: that are moved.
        values: to which they are moved, ascending [rad, m].
        fine: to which the value is found beyond which a loop cannot be closed [rad, m].

    Attributes:
        values: (n,) those that can be reached [rad, m].
        gram: (n, 2, 2) of each of their postures; NaN without a result.
        unreachable: (least value, greatest value, reason) of the ranges in which a loop cannot be closed or there is no result.
        inaccurate: number of postures in which rounding may show above 1e-9.

    Raises:
        StudyError: no loop can be closed at any value.
    """

    def __init__(self, landing: PosedLanding, place: Place, joints: tuple[Joint, ...], values: Array, fine: float) -> None:
        self._landing, self._place, self._joints = landing, place, joints
        posture, moved = landing.scene.posture, {joint.name for joint in joints}
        self._held = held_joints(landing.robot, posture, landing.scene.assemble)
        for mimic in landing.robot.mimics:
            if not moved.isdisjoint(mimic.leaders):
                self._held[landing.robot.joint(mimic.joint).v] = True
        for joint in joints:
            self._held[joint.v] = True
        found, open_ = self._postures(values, fine)
        self.values, self._Q = np.array(list(found)), np.stack(list(found.values()))
        maps = shock_maps(landing, self._Q)
        ranks, counts = np.unique(maps.rank, return_counts=True)
        self._rank = int(ranks[np.argmax(counts)])
        self.gram, refused, self.inaccurate = self._grams(self._Q)
        self.unreachable = tuple(sorted({*open_, *_ranges(self.values, refused)}))

    def greatest(self, value: float, strikes: tuple[float, float]) -> float:
        """The greatest shock over some strikes [rad] at a value; beyond any bound where there is no result."""
        near = self._Q[int(np.argmin(np.abs(self.values - value)))]
        gram = self._grams(self._posture(value, near)[None])[0]
        return float(np.nan_to_num(greatest_shock(gram, strikes)[0][0], nan=UNPHYSICAL))

    def _posture(self, value: float, near: Array) -> Array:
        """The configuration (nq,) with the joint at a value [rad, m]; loops are closed from a configuration near it."""
        landing, q = self._landing, near.copy()
        set_joints(landing.robot, [(joint, value) for joint in self._joints], q)
        return assemble(landing.robot, q, landing.loops, landing.plane, self._held).q if landing.loops else q

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

    def _grams(self, Q: Array) -> tuple[Array, dict[int, str], int]:
        """EᵀE (n, 2, 2) in some configurations (n, nq), the reason where there is none, and in how many rounding may show.

        Where other rows are independent than in most postures of the scan, or the motion is very fast, the posture is singular or
        nearly so, and is proven; NaN where it has no verdict.
        """
        landing, body = self._landing, self._place.body
        maps = shock_maps(landing, Q)
        E, refused = maps.at(body, self._place.r), dict[int, str]()
        singular = (maps.rank != self._rank) | ~(np.abs(maps.maps).max(axis=(1, 2, 3)) < FASTEST_PLAUSIBLE_RATE)
        for k in np.flatnonzero(singular).tolist():
            there = landing.at(Q[k])
            try:
                jumps = profile_of(there).proof.jumps[body, :, :3]
            except ShockError as refusal:
                E[k], refused[k] = np.nan, str(refusal)
                continue
            E[k] = there.state.rotation[0, body] @ (jumps[3:] - cross_matrix(self._place.r) @ jumps[:3])
        E = E @ np.stack([landing.plane.forward, [0.0, 0.0, -1.0]], axis=1)
        return np.swapaxes(E, -1, -2) @ E, refused, int((~singular & (maps.condition > ILL_CONDITIONED)).sum())


def _ranges(values: Array, refused: dict[int, str]) -> Iterator[tuple[float, float, str]]:
    """The ranges of consecutive postures without a result, with the first one's reason."""
    for first in sorted(refused.keys() - {k + 1 for k in refused}):
        last = next(k for k in itertools.count(first) if k + 1 not in refused)
        yield float(values[first]), float(values[last]), refused[first]


def wave(gram: Array) -> tuple[Array, Array, Array]:
    """m, r and φ (n,) of the squared shock m + r cos(2θ − φ). Args: gram (n, 2, 2)."""
    a, b, c = gram[:, 0, 0], gram[:, 0, 1], gram[:, 1, 1]
    return (a + c) / 2.0, np.hypot((c - a) / 2.0, b), np.arctan2(b, (c - a) / 2.0)


def greatest_shock(gram: Array, strikes: tuple[float, float]) -> tuple[Array, Array]:
    """The greatest shock (n,) over a range of strike angles [rad], and the strike angle (n,) that has it [rad].

    Args:
        gram: (n, 2, 2) of the postures.
        strikes: least and greatest strike angle.
    """
    low, high = strikes
    angles = [np.full(len(gram), low), np.full(len(gram), high)]
    if high > low:
        inner = wave(gram)[2] / 2.0
        angles += [np.where((x > low) & (x < high), x, low) for x in (inner, inner - math.pi, inner + math.pi)]
    candidates = np.stack(angles)
    u = np.stack([np.sin(candidates), np.cos(candidates)], axis=-1)
    squares = np.einsum("kni,nij,knj->kn", u, gram, u)
    best = np.argmax(squares, axis=0)[None]
    shock = np.sqrt(np.maximum(np.take_along_axis(squares, best, axis=0)[0], 0.0))
    return shock, np.take_along_axis(candidates, best, axis=0)[0]
