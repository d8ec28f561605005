"""The motion of a landing on elements of finite stiffness, and peaks of what follows from it.

`stiffness` solves it.

Between two events all forces are sums of oscillations, which dampers let decay, and so is
everything that is linear in them.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import (
    MOST_SAMPLES,
    ComplexArray,
    Effort,
    changes,
    growth,
    integral,
    oscillations,
    rate_of_change,
    real_sum,
)
from shockpc.wings.compliant.motion.events import Event

NEAR_MAXIMUM, MOST_MAXIMA = 0.95, 64
"""Share of the largest squared sample from which a local maximum is refined, and most of these."""

FINER, MOST_BETWEEN, HIDDEN = 16, 256, 1e-7
"""Parts of a divided interval, most intervals that are divided, and share of a hidden length.

An interval is one between two samples in which a larger length may lie; it is divided again. The
share is that of the largest length by which one may stay hidden.
"""

MOST_TOGETHER, SAMPLES_TOGETHER = 32, 2**13
"""Numbers of segments and of samples that are searched together for peaks.

What is known before limits what is searched.
"""

DECAYED = 40.0
"""Times the time constant of an oscillation after which nothing is left of it."""


class Elements(NamedTuple):
    """The springs of a landing, one for each of r rows.

    Attributes:
        rows: (r, n) velocity along each element for unit velocities of the n coordinates [m, 1].
        stiffness: (r,) k [N/m, N m/rad].
        restitution: (r,) e from 0 to 1; 1 for a spring without loss.
        contact: (r,) number of the contact that a row belongs to, −1 for a spring between bodies.
        normal: (r,) whether a row is the normal of its contact, along which the ground pushes. Each
            contact has one.
        damping: (r,) c of a viscous damper beside the spring [N s/m, N m s/rad]; zero for none.
            With one, e has no effect.
        load: (r,) force on the robot along the row at the impact [N, N m]: of a spring between
            bodies that is deflected already, or constant where the stiffness is zero. Contacts have
            none.
        relaxation: (r,) rate k / c at which a viscous damper c in series with the spring lets its
            force decay [1/s]; zero for none. With one, e has no effect.
        straight: (r,) whether a spring between bodies is one that keeps a link straight. What is
            left of a contact's force is compared with that of a robot in which these are rigid.
    """

    rows: Array
    stiffness: Array
    restitution: Array
    contact: np.ndarray
    normal: np.ndarray
    damping: Array | float = 0.0
    load: Array | float = 0.0
    relaxation: Array | float = 0.0
    straight: np.ndarray | bool = False

    @staticmethod
    def alike(
        rows: Array,
        stiffness: Array | float,
        restitution: Array | float = 1.0,
        contact: np.ndarray | int = -1,
        normal: np.ndarray | bool = False,
        damping: Array | float = 0.0,
        load: Array | float = 0.0,
        relaxation: Array | float = 0.0,
        straight: np.ndarray | bool = False,
    ) -> "Elements":
        """Elements along some rows, with one value for all of them or one for each.

        By default they are springs between bodies.
        """
        values = stiffness, restitution, contact, normal, damping, load, relaxation, straight
        return Elements(rows, *(np.broadcast_to(value, len(rows)) for value in values))

    @staticmethod
    def joined(*groups: "Elements") -> "Elements":
        """Groups of elements, one after the other.

        Rows of fewer coordinates do not move the last ones.
        """
        width = max(group.rows.shape[1] for group in groups)
        rows = []
        for group in groups:
            missing = width - group.rows.shape[1]
            rows.append(np.pad(group.rows, ((0, 0), (0, missing))))
        others = zip(*[group[1:] for group in groups], strict=True)
        return Elements(np.concatenate(rows), *map(np.concatenate, others))


class Modes(NamedTuple):
    """The m modes of the elements that are loaded first.

    Attributes:
        frequency: (m,) natural frequencies [Hz], descending.
        energy: (m,) kinetic energy before impact in each mode [J]. Its sum is the energy that the
            elements can take up.
        participation: (r, m) share of the elastic energy of each mode that is in each element [1].
        force: (r, m) amplitude of the force of each element in each mode [N, N m].
    """

    frequency: Array
    energy: Array
    participation: Array
    force: Array


class History(NamedTuple):
    """The motion at T times.

    Attributes:
        force: (T, r) force of each element on the robot along its row [N, N m]; positive along a
            normal where the ground pushes.
        displacement: (T, n) x [rad, m].
        jump: (T, n) change of velocity ẋ(t) − q̇⁻ [rad/s, m/s].
        acceleration: (T, n) ẍ [rad/s², m/s²].
    """

    force: Array
    displacement: Array
    jump: Array
    acceleration: Array


class Segment(NamedTuple):
    """The motion between two events, in m oscillations.

    Attributes:
        start: time of the first event [s].
        length: time until the second [s].
        rate: (m,) λ of each oscillation; its real part is the rate at which it decays, zero without
            dampers [rad/s].
        level: (r,) part of the forces of all elements that stays constant; at rest they would have
            it.
        wave: (r, m) with their other part, Re(wave · exp(λt)).
        swing: (d, m) with the part of u that oscillates, Re(swing · exp(λt)).
        drift, acceleration: (d,) the part of u at the start that no spring resists, and the
            constant rate at which it changes.
        jump: (d,) u(start) − u(0).
        displacement: (d,) ∫u dt until the start.
    """

    start: float
    length: float
    rate: ComplexArray
    level: Array
    wave: ComplexArray
    swing: ComplexArray
    drift: Array
    acceleration: Array
    jump: Array
    displacement: Array

    def forces(self, t: Array) -> Array:
        """The forces (..., r) at times t (...) after the start."""
        return self.level + oscillations(t[..., None] * self.rate, self.wave)

    def after(self, t: Array) -> tuple[Array, Array]:
        """The change of u since impact and ∫u dt (..., d), at times t (...) after the start."""
        t = t[..., None]
        # Of slow oscillations no digits cancel.
        change = changes(t * self.rate, self.swing) + t * self.acceleration
        path = real_sum(integral(self.rate, t), self.swing)
        path = path + t * self.drift + t * t / 2.0 * self.acceleration
        return self.jump + change, self.displacement + path

    def pieces(self) -> Iterator["Segment"]:
        """The forces in parts, each longer than the one before.

        The oscillations that decay fastest are only in the first.
        """
        begin, fastest = 0.0, float(-self.rate.real.min(initial=0.0))
        end = DECAYED / fastest if fastest > 0.0 else np.inf
        while begin < self.length:
            end = min(end, self.length)
            wave = self.wave * np.exp(self.rate * begin)
            yield self._replace(start=self.start + begin, length=end - begin, wave=wave)
            begin, end = end, 3.0 * end

    def impulse(self, t: float) -> Array:
        """The impulses (r,) of the forces from the start until a time t after it."""
        return np.asarray(t * self.level + real_sum(integral(self.rate, np.asarray(t)), self.wave))


class StiffMotion(NamedTuple):
    """A landing, solved.

    Attributes:
        elements: the springs and dampers that it was computed for.
        modes: the modes of the elements that are loaded first, without dampers.
        segments: in order; the motion ends with the last.
        events: in order.
        separated: whether all contacts are open at the end.
        to_velocity: (n, d) from u to ẋ.
        constant: (n,) part of ẋ before impact that no element resists [rad/s, m/s].
        gravity: (n,) accelerations of free fall [rad/s², m/s²].
        falling: (n,) part of these that no element resists.
    """

    elements: Elements
    modes: Modes
    segments: tuple[Segment, ...]
    events: tuple[Event, ...]
    separated: bool
    to_velocity: Array
    constant: Array
    gravity: Array
    falling: Array

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
        which = np.minimum(np.searchsorted(ends, times), len(ends) - 1)
        (r, d), T = (len(self.elements.rows), self.to_velocity.shape[1]), len(times)
        force, displacement, jump = (np.empty((T, columns)) for columns in (r, d, d))
        for k in np.unique(which):
            now, segment = which == k, self.segments[k]
            force[now] = segment.forces(times[now] - segment.start)
            jump[now], displacement[now] = segment.after(times[now] - segment.start)
        # x = T ∫u dt + c t + g t² / 2
        displacement = displacement @ self.to_velocity.T
        displacement = displacement + np.outer(times, self.constant)
        displacement = displacement + np.outer(times**2 / 2.0, self.falling)
        jump = jump @ self.to_velocity.T + np.outer(times, self.falling)
        return History(force, displacement, jump, force @ self.response.T + self.gravity)

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
        starts = np.array([segment.level + segment.wave.real.sum(axis=1) for segment in segments])
        at_starts = np.square(P @ starts.T).sum(axis=1).max(axis=1)
        largest, when = largest_lengths(P, segments, at_starts, Effort())
        return np.where(np.isnan(outputs).any(axis=(1, 2)), np.nan, largest), when


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


def _lengths(vectors: Array) -> Array:
    """The lengths (...) of vectors (..., k)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


def largest_lengths(
    outputs: Array, segments: Sequence[Segment], least: Array, effort: Effort
) -> tuple[Array, Array]:
    """The largest lengths of m vectors within some segments, and when they are reached.

    They are zero of a vector that stays shorter.

    Segments and vectors that cannot exceed what is known are left out by the sums of their
    amplitudes, and the others are halved until few samples do: what the first half holds limits
    what is searched in the second one.

    Args:
        outputs: (m, k, r) matrices that give the vectors of the forces.
        segments: one after the other.
        least: (m,) squared length that is known already.
        effort: counts what is computed.

    Returns: (m,) lengths and (m,) times.
    """
    (m, k, r), count = outputs.shape, len(segments)
    if count > MOST_TOGETHER:
        return _in_halves(outputs, segments, least, effort)
    rates, wave = _stacked(segments)
    modes, P = rates.shape[1], outputs.reshape(m * k, r)
    # Vectors are P f of the forces f, and their waves are P times those of the forces.
    waves = (P @ wave.view(float)).view(complex).reshape(count, m, k, modes)
    # What the amplitudes of a segment and a vector allow at most.
    size = np.abs(waves)
    larger = np.square(size.sum(axis=3)).sum(axis=2) >= (1.0 - 1e-9) * least
    kept, above = larger.any(axis=1), larger.any(axis=0)
    if not (kept.all() and above.all()):
        largest, when = np.zeros((2, m))
        if kept.any():
            few = [segments[i] for i in np.flatnonzero(kept).tolist()]
            largest[above], when[above] = largest_lengths(outputs[above], few, least[above], effort)
        return largest, when
    start, lengths = np.array([(segment.start, segment.length) for segment in segments]).T
    frequency = rate_of_change(rates[:, None, None], size)
    fastest = np.where(larger[..., None], frequency, 0.0).max(axis=(1, 2))
    # Samples are 0.2 rad of the fastest rate of change apart.
    steps = np.minimum(lengths * fastest / 0.2, 2.0 * MOST_SAMPLES).astype(int) + 1
    if count > 1 and steps.sum() > SAMPLES_TOGETHER:
        return _in_halves(outputs, segments, least, effort)
    if steps.sum() > MOST_SAMPLES:
        raise ArithmeticError(
            f"the fastest mode oscillates more than {MOST_SAMPLES // 30} times in {lengths[0]:.3g} "
            f"s; take the stiffest as rigid"
        )
    # A product of matrices takes a small share of the time of what it multiplies, the more rows the
    # smaller.
    samples = int((steps + 1).sum())
    effort.spend(samples * min(r, 8 + r // 8) * (modes + m * k))
    sampled = _Sampled(P, rates, wave, waves, start, lengths)
    return _largest_sampled(sampled, steps, least, effort)


def _in_halves(
    outputs: Array, segments: Sequence[Segment], least: Array, effort: Effort
) -> tuple[Array, Array]:
    """The lengths of `largest_lengths`, by halves.

    The result of the first half limits what is searched in the second one.
    """
    half = len(segments) // 2
    first, early = largest_lengths(outputs, segments[:half], least, effort)
    known = np.maximum(least, first**2)
    second, late = largest_lengths(outputs, segments[half:], known, effort)
    return np.maximum(first, second), np.where(second > first, late, early)


class _Sampled(NamedTuple):
    """Vectors of k components in n segments, as sums of j oscillations.

    Attributes:
        P: (m·k, r) what gives the m vectors of the forces.
        rates: (n, j) of the oscillations.
        wave: (n, r, j) with those of the forces.
        waves: (n, m, k, j) the same of the vectors.
        start: (n,) of each segment [s].
        lengths: (n,) of these [s].
    """

    P: Array
    rates: ComplexArray
    wave: ComplexArray
    waves: ComplexArray
    start: Array
    lengths: Array


def _largest_sampled(
    of: _Sampled, steps: np.ndarray, least: Array, effort: Effort
) -> tuple[Array, Array]:
    """The largest lengths (m,) of vectors and when they are reached.

    They are local maxima of samples, refined, and what is longer between samples.

    Args:
        of: the vectors.
        steps: (n,) of the samples in each segment.
        least: (m,) squared length that is known already.
        effort: counts what is computed.
    """
    count, m, k, _ = of.waves.shape
    step = of.lengths / steps
    # The samples of segment s are begins[s] to ends[s]; of_segment has s for each sample.
    ends = np.cumsum(steps + 1)
    begins = ends - steps - 1
    of_segment = np.repeat(np.arange(count), steps + 1)
    # Times after the start of each segment, of samples of all of them one after the other, each
    # with both of its ends.
    t = (np.arange(len(of_segment)) - begins[of_segment]) * step[of_segment]
    force = []
    for rate, wave, a, b in zip(of.rates, of.wave, begins, ends, strict=True):
        force.append(oscillations(t[a:b, None] * rate, wave))
    # Squared lengths of the vectors; each local maximum is refined between its two neighbours.
    square = np.square(np.concatenate(force) @ of.P.T).reshape(-1, m, k).sum(axis=2)
    sample, vector = np.nonzero(_local_maxima(square, begins, ends))
    at = t[sample]
    i = of_segment[sample]
    low = np.maximum(at - step[i], 0.0)
    high = np.minimum(at + step[i], of.lengths[i])
    length, at = _refined(of.rates[i], of.waves[i, vector], at, low, high)

    # Of values that are assigned to one place the last one stays: the largest, and of equal ones
    # the first.
    largest, when = np.zeros((2, m))
    order = np.argsort(-length, kind="stable")[::-1]
    largest[vector[order]] = length[order]
    when[vector[order]] = (of.start[i] + at)[order]

    # Between samples h apart a vector exceeds the longer one by κ h² / 8 at most, with the bound
    # κ = |Σ_j |λ_j|² |wave_j|| of its second derivative. Where that may exceed what is known, the
    # interval is searched.
    curved = np.abs(of.waves) * np.abs(of.rates[:, None, None]) ** 2
    bend = _lengths(curved.sum(axis=3))
    known = np.maximum(largest, np.sqrt(least))
    first = np.delete(np.arange(len(of_segment)), ends - 1)  # of each interval
    longer = np.sqrt(np.maximum(square[first], square[first + 1]))
    between = Intervals.all_of(of_segment[first], t[first], step, longer, bend, known)
    for segment, v, size, time in _longer_between(of, between, known, effort):
        if size > largest[v]:
            largest[v] = size
            when[v] = of.start[segment] + time
    return largest, when


class Intervals(NamedTuple):
    """Intervals (c,) between two samples of a vector.

    Attributes:
        segment: which one.
        vector: which one.
        low: where it begins, after the start of its segment [s].
        width: how long it is [s].
        longer: length of the vector at the end at which it is longer.
        bend: bound of its second derivative κ. Within an interval h it is longer than at both ends
            by κ h²/8 at most.
    """

    segment: np.ndarray
    vector: np.ndarray
    low: Array
    width: Array
    longer: Array
    bend: Array

    @staticmethod
    def all_of(
        segment: np.ndarray, low: Array, step: Array, longer: Array, bend: Array, known: Array
    ) -> "Intervals":
        """Those in which a vector may be longer than is known.

        Args:
            segment: (c,) of each interval.
            low: (c,) where it begins [s].
            step: (n,) length of the intervals of each segment [s].
            longer: (c, m) length of each vector at the longer end.
            bend: (n, m) bounds κ.
            known: (m,) largest lengths.
        """
        width = step[segment]
        above = longer + bend[segment] * width[:, None] ** 2 / 8.0
        i, vector = np.nonzero(above > (1.0 + HIDDEN) * known)
        segment = segment[i]
        return Intervals(
            segment, vector, low[i], width[i], longer[i, vector], bend[segment, vector]
        )

    def kept(self, known: Array) -> "Intervals":
        """The intervals in which a vector may be longer than is known (m,).

        They are at most `MOST_BETWEEN`, the most promising ones.
        """
        longest = self.longer + self.bend * self.width**2 / 8.0
        above = longest / np.maximum(known[self.vector], 1e-300)
        order = np.argsort(-above, kind="stable")[:MOST_BETWEEN]
        kept = order[above[order] > 1.0 + HIDDEN]
        return Intervals(*(part[kept] for part in self))


def _longer_between(
    of: _Sampled, between: Intervals, known: Array, effort: Effort
) -> Iterator[tuple[int, int, float, float]]:
    """Segment, vector, length and time of what is longer than is known.

    Intervals are divided until none can be longer.

    Args:
        of: the vectors.
        between: the intervals.
        known: (m,) largest lengths.
        effort: counts what is computed.
    """
    known = known.copy()
    between = between.kept(known)
    while len(between.segment):
        i, vector, width = between.segment, between.vector, between.width / FINER
        of_vector = of.waves[i, vector]
        effort.spend(len(i) * (FINER + 1) * of_vector[0].size)
        # Samples are FINER times denser in each interval, and the largest one is refined.
        t = between.low[:, None] + width[:, None] * np.arange(FINER + 1)
        turned = np.exp(t[..., None] * of.rates[i, None])
        sampled = _lengths((turned @ np.swapaxes(of_vector, 1, 2)).real)
        at = t[np.arange(len(i)), sampled.argmax(axis=1)]
        low, high = np.maximum(at - width, 0.0), np.minimum(at + width, of.lengths[i])
        length, at = _refined(of.rates[i], of_vector, at, low, high)
        lists = i.tolist(), vector.tolist(), length.tolist(), at.tolist()
        for segment, v, size, time in zip(*lists, strict=True):
            if size > known[v]:
                known[v] = size
                yield segment, v, size, time
        # Each part of an interval is an interval from now on.
        longer = np.maximum(sampled[:, 1:], sampled[:, :-1]).ravel()
        parts = i, vector, width, between.bend
        i, vector, width, bend = (np.repeat(part, FINER) for part in parts)
        between = Intervals(i, vector, t[:, :-1].ravel(), width, longer, bend).kept(known)


def _stacked(segments: Sequence[Segment]) -> tuple[ComplexArray, ComplexArray]:
    """The rates (n, j) and waves (n, r, j) of n segments.

    The first rate is zero, that of what stays constant.
    """
    modes = 1 + max(len(segment.rate) for segment in segments)
    rates = np.zeros((len(segments), modes), dtype=complex)
    wave = np.zeros((len(segments), len(segments[0].level), modes), dtype=complex)
    for i, segment in enumerate(segments):
        oscillating = slice(1, 1 + len(segment.rate))
        rates[i, oscillating] = segment.rate
        wave[i, :, 0], wave[i, :, oscillating] = segment.level, segment.wave
    return rates, wave


def _local_maxima(square: Array, begins: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Mask of the samples (s, m) of m signals that are maxima and nearly as large as the largest.

    They are maxima among their neighbours.

    A sample at the end of a segment may exceed those of the next, whose maximum lies between its
    samples: both count.

    Args:
        square: samples of all segments, one segment after the other.
        begins: index of the first sample of each segment.
        ends: one behind its last.
    """
    rises, falls = np.ones((2, *square.shape), dtype=bool)
    rises[1:] = square[1:] > square[:-1]
    falls[:-1] = ~rises[1:]
    rises[begins], falls[ends - 1] = True, True
    local = rises & falls & (square >= NEAR_MAXIMUM * square.max(axis=0))
    if np.count_nonzero(local) > MOST_MAXIMA * square.shape[1]:
        among = np.where(local, square, -1.0)
        local &= square >= np.partition(among, -MOST_MAXIMA, axis=0)[-MOST_MAXIMA]
    return np.asarray(local)


def _refined(
    rate: ComplexArray, waves: Array, t: Array, low: Array, high: Array
) -> tuple[Array, Array]:
    """The largest length (m,) of vectors near times t (m,), and its time, between bounds.

    The vectors are the real parts of waves (m, k, j) · exp(λt), λ (m, j). Newton's method on half
    the derivative of the squared length.
    """
    length, best, turning = np.full(len(t), -1.0), t, rate[:, None]
    derivatives = np.concatenate([waves, waves * turning, waves * turning**2], axis=1)
    for _ in range(8):
        turned = np.exp(turning[:, 0] * t[:, None])[..., None]
        values = (derivatives @ turned).real.reshape(len(t), 3, -1)
        value, speed, curve = values[:, 0], values[:, 1], values[:, 2]
        sizes = _lengths(value)
        longer = sizes > length
        length, best = np.where(longer, sizes, length), np.where(longer, t, best)
        # d/dt |v|²/2 = v · v̇ and its derivative v̇ · v̇ + v · v̈
        slope, bend = (value * speed).sum(axis=1), (speed * speed + value * curve).sum(axis=1)
        concave = bend < 0.0
        newton = -slope / np.where(concave, bend, -1.0)
        # Where the square is not concave, go to the bound that lies uphill.
        step = np.where(concave, newton, np.sign(slope) * (high - low))
        last, t = t, np.clip(t + step, low, high)
        if np.all(np.abs(t - last) <= 1e-6 * (high - low)):
            break
    # Where the last time agrees with the best one it has more digits.
    return length, np.where(np.abs(t - best) <= 1e-6 * (high - low), t, best)
