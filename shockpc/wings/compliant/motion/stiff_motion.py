"""The motion of a landing on elements of finite stiffness, and what is read from it.

Between two events all forces are sums of oscillations, which dampers let decay, and so is
everything that is linear in them.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import Effort, growth, integral
from shockpc.wings.compliant.motion.elastic_modes import ElasticModes
from shockpc.wings.compliant.motion.elements import Elements
from shockpc.wings.compliant.motion.events import Event
from shockpc.wings.compliant.motion.peaks import largest_lengths
from shockpc.wings.compliant.motion.segment import Segment


class History(NamedTuple):
    """The motion at T times.

    Attributes:
        force: (T, r) force of each element on the robot along its row [N, N m]; positive along a
            normal where the ground pushes.
        displacement: (T, n) x [rad, m].
        jump: (T, n) change of velocity ẋ(t) − q̇⁻ [rad/s, m/s].
    """

    force: Array
    displacement: Array
    jump: Array


class StiffMotion(NamedTuple):
    """A landing, solved.

    Attributes:
        elements: the springs and dampers that it was computed for.
        modes: the modes of the elements that are loaded first, without dampers.
        segments: in order; the motion ends with the last.
        events: in order.
        separated: whether all contacts are open at the end.
        to_velocity: (n, d) from u to ẋ.
        unresisted_velocity: (n,) part of ẋ before impact that no element resists [rad/s, m/s].
        gravity: (n,) accelerations of free fall [rad/s², m/s²].
        unresisted_gravity: (n,) part of these that no element resists.
    """

    elements: Elements
    modes: ElasticModes
    segments: tuple[Segment, ...]
    events: tuple[Event, ...]
    separated: bool
    to_velocity: Array
    unresisted_velocity: Array
    gravity: Array
    unresisted_gravity: Array

    @property
    def duration(self) -> float:
        """Time from impact to the end [s]."""
        return self.segments[-1].start + self.segments[-1].length

    def first(self, kind: str) -> Array:
        """The time (r,) of the first event of a kind at each element [s]; infinite without one."""
        times = {event.element: event.time for event in reversed(self.events) if event.kind == kind}
        return np.array([times.get(i, np.inf) for i in range(len(self.elements.rows))])

    def impulse_time(self, rows: np.ndarray, share: float) -> Array:
        """The time (c,) by which each of c rows has given a share of its impulse until the end.

        The force of a row never changes sign.
        """
        impulses = [segment.impulse(segment.length)[rows] for segment in self.segments]
        until = np.cumsum(impulses, axis=0)
        times = np.zeros(len(rows))
        for i, (row, total) in enumerate(zip(rows.tolist(), until[-1].tolist(), strict=True)):
            if not total > 0.0:
                continue
            k = int(np.argmax(until[:, i] >= share * total))
            before = until[k - 1, i] if k else 0.0
            segment = self.segments[k]
            times[i] = segment.start + _impulse_time(segment, row, share * total - before)
        return times

    @property
    def response(self) -> Array:
        """M⁻¹Bᵀ (n, r): accelerations for unit forces of the elements.

        They are in [1/kg, 1/(kg m), 1/(kg m²)].
        """
        return np.asarray(self.to_velocity @ (self.elements.rows @ self.to_velocity).T)

    def at(self, times: Array) -> History:
        """The motion at times (T,) from 0 to the duration [s]; at an event, just before it."""
        times = np.asarray(times, dtype=float)
        ends = np.array([segment.start + segment.length for segment in self.segments])
        number = np.minimum(np.searchsorted(ends, times), len(ends) - 1)
        r, d = len(self.elements.rows), self.to_velocity.shape[1]
        force = np.empty((len(times), r))
        jump, path = np.empty((2, len(times), d))
        for k in np.unique(number):
            now, segment = number == k, self.segments[k]
            force[now] = segment.forces(times[now] - segment.start)
            jump[now], path[now] = segment.after(times[now] - segment.start)
        # x = T ∫u dt + c t + g t² / 2, of what no element resists
        displacement = path @ self.to_velocity.T
        displacement = displacement + np.outer(times, self.unresisted_velocity)
        displacement = displacement + np.outer(times**2 / 2.0, self.unresisted_gravity)
        jump = jump @ self.to_velocity.T + np.outer(times, self.unresisted_gravity)
        return History(force, displacement, jump)

    def peak(self, outputs: Array, constant: Array | float = 0.0) -> tuple[Array, Array]:
        """The largest lengths of vectors P f + p, linear in forces f, and when they are reached.

        Args:
            outputs: (m, k, r) P; of what is linear in accelerations beyond free fall, G (ẍ − g), it
                is G `response`.
            constant: (m, k) p.

        Returns: (m,) lengths, NaN where P is, and (m,) times [s]. Each oscillation is sampled
            thirty times, the largest local maxima of the samples are refined to rounding, and
            intervals in which a larger one may lie are sampled again.

        Raises:
            ArithmeticError: the frequencies lie too far apart to sample the motion, or it takes too
                many terms.
        """
        # What is constant is the force of one more element.
        constant = np.broadcast_to(constant, outputs.shape[:2])
        P = np.nan_to_num(np.dstack([outputs, constant]))
        segments = []
        for segment in self.segments:
            for piece in segment.pieces():
                level, wave = np.append(piece.level, 1.0), np.pad(piece.wave, ((0, 1), (0, 0)))
                segments.append(piece._replace(level=level, wave=wave))
        at_start = np.array([segment.level + segment.wave.real.sum(axis=1) for segment in segments])
        least = np.square(P @ at_start.T).sum(axis=1).max(axis=1)
        length, time = largest_lengths(P, segments, least, Effort())
        return np.where(np.isnan(outputs).any(axis=(1, 2)), np.nan, length), time


def _impulse_time(segment: Segment, row: int, impulse: float) -> float:
    """The time after the start of a segment at which a row has given an impulse [s].

    The force of the row is positive. Newton's method finds the time within bounds, since the
    impulse grows with time.
    """
    wave, level = segment.wave[row], float(segment.level[row])
    t, low, high = segment.length, 0.0, segment.length
    for _ in range(60):
        last = t
        # ∫ level + Re Σ_j wave_j exp(λ_j t) dt
        oscillating = float((integral(segment.rate, np.asarray(t)) @ wave).real)
        excess = t * level + oscillating - impulse
        force = level + float(((1.0 + growth(segment.rate * t)) @ wave).real)
        if excess < 0.0:
            low = t
        else:
            high = t
        t = t - excess / force if force > 0.0 else high
        if force > 0.0 and abs(t - last) <= 1e-8 * segment.length:
            break
        if not low < t < high:
            t = (low + high) / 2.0
    return t
