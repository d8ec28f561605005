"""The largest lengths of vectors that are linear in the forces of a motion.

Each oscillation is sampled thirty times. The largest local maxima of the samples are refined to
rounding, and intervals in which a larger one may lie are sampled again.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import (
    MOST_SAMPLES,
    ComplexArray,
    Effort,
    oscillations,
    rate_of_change,
)
from shockpc.wings.compliant.motion.segment import Segment

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


class LargestLengths(NamedTuple):
    """The largest lengths (m,) of m vectors, and when (m,) they are reached [s]."""

    length: Array
    time: Array


class _Vectors(NamedTuple):
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

    @staticmethod
    def of_segments(outputs: Array, segments: Sequence[Segment]) -> "_Vectors":
        """The vectors P f of the forces f in some segments. Args: outputs (m, k, r), P."""
        m, k, r = outputs.shape
        rates, wave = _stacked(segments)
        P = outputs.reshape(m * k, r)
        waves = (P @ wave.view(float)).view(complex).reshape(len(segments), m, k, -1)
        start, lengths = np.array([(segment.start, segment.length) for segment in segments]).T
        return _Vectors(P, rates, wave, waves, start, lengths)


class _Samples(NamedTuple):
    """Samples of the vectors in all segments, one segment after the other.

    Each segment has a sample at its start and at its end.

    Attributes:
        segment: (s,) of each sample.
        t: (s,) time after the start of that segment [s].
        square: (s, m) squared length of each vector.
        step: (n,) between samples of each segment [s].
        begins: (n,) the first sample of each segment.
        ends: (n,) one behind its last.
    """

    segment: np.ndarray
    t: Array
    square: Array
    step: Array
    begins: np.ndarray
    ends: np.ndarray


class _Maxima(NamedTuple):
    """Local maxima (c,): segment, vector, length, and time after the start of the segment [s]."""

    segment: np.ndarray
    vector: np.ndarray
    length: Array
    time: Array


class _Intervals(NamedTuple):
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

    def kept(self, known: Array) -> "_Intervals":
        """The intervals in which a vector may be longer than is known (m,).

        They are at most `MOST_BETWEEN`, the most promising ones.
        """
        longest = self.longer + self.bend * self.width**2 / 8.0
        above = longest / np.maximum(known[self.vector], 1e-300)
        order = np.argsort(-above, kind="stable")[:MOST_BETWEEN]
        kept = order[above[order] > 1.0 + HIDDEN]
        return _Intervals(*(values[kept] for values in self))


def largest_lengths(
    outputs: Array, segments: Sequence[Segment], least: Array, effort: Effort
) -> LargestLengths:
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

    Raises:
        ArithmeticError: the frequencies lie too far apart, or it takes too many terms.
    """
    if len(segments) > MOST_TOGETHER:
        return _in_halves(outputs, segments, least, effort)
    vectors = _Vectors.of_segments(outputs, segments)
    size = np.abs(vectors.waves)
    may_exceed = _may_exceed(size, least)
    if not (may_exceed.any(axis=1).all() and may_exceed.any(axis=0).all()):
        return _where_possible(outputs, segments, least, effort, may_exceed)
    steps = _steps(vectors, size, may_exceed)
    if len(segments) > 1 and steps.sum() > SAMPLES_TOGETHER:
        return _in_halves(outputs, segments, least, effort)
    if steps.sum() > MOST_SAMPLES:
        raise ArithmeticError(
            f"the fastest mode oscillates more than {MOST_SAMPLES // 30} times in "
            f"{vectors.lengths[0]:.3g} s; take the stiffest as rigid"
        )
    effort.spend(_terms(vectors, steps))
    return _largest_sampled(vectors, steps, least, effort)


def _may_exceed(size: Array, least: Array) -> np.ndarray:
    """Mask (n, m) of the segments in which the amplitudes let a vector exceed what is known.

    Args: size (n, m, k, j), amplitudes; least (m,), squared length that is known.
    """
    longest = np.square(size.sum(axis=3)).sum(axis=2)
    return np.asarray(longest >= (1.0 - 1e-9) * least)


def _where_possible(
    outputs: Array,
    segments: Sequence[Segment],
    least: Array,
    effort: Effort,
    may_exceed: np.ndarray,
) -> LargestLengths:
    """The lengths of `largest_lengths`, of what may exceed what is known (n, m)."""
    kept, above = may_exceed.any(axis=1), may_exceed.any(axis=0)
    length, time = np.zeros((2, len(outputs)))
    if kept.any():
        few = [segments[i] for i in np.flatnonzero(kept).tolist()]
        length[above], time[above] = largest_lengths(outputs[above], few, least[above], effort)
    return LargestLengths(length, time)


def _in_halves(
    outputs: Array, segments: Sequence[Segment], least: Array, effort: Effort
) -> LargestLengths:
    """The lengths of `largest_lengths`, by halves.

    The result of the first half limits what is searched in the second one.
    """
    half = len(segments) // 2
    first = largest_lengths(outputs, segments[:half], least, effort)
    known = np.maximum(least, first.length**2)
    second = largest_lengths(outputs, segments[half:], known, effort)
    time = np.where(second.length > first.length, second.time, first.time)
    return LargestLengths(np.maximum(first.length, second.length), time)


def _steps(vectors: _Vectors, size: Array, may_exceed: np.ndarray) -> np.ndarray:
    """Numbers (n,) of steps, 0.2 rad of the fastest rate of change, between samples of segments."""
    frequency = rate_of_change(vectors.rates[:, None, None], size)
    fastest = np.where(may_exceed[..., None], frequency, 0.0).max(axis=(1, 2))
    steps = np.minimum(vectors.lengths * fastest / 0.2, 2.0 * MOST_SAMPLES)
    return np.asarray(steps.astype(int) + 1)


def _terms(vectors: _Vectors, steps: np.ndarray) -> int:
    """The number of terms that the samples take.

    A product of matrices takes a small share of the time of what it multiplies, the more rows the
    smaller.
    """
    components, r = vectors.P.shape
    samples = int((steps + 1).sum())
    terms: int = samples * min(r, 8 + r // 8) * (vectors.rates.shape[1] + components)
    return terms


def _largest_sampled(
    vectors: _Vectors, steps: np.ndarray, least: Array, effort: Effort
) -> LargestLengths:
    """The largest lengths of vectors: refined maxima of samples, and what is longer between these.

    Args:
        vectors: m of them.
        steps: (n,) of the samples in each segment.
        least: (m,) squared length that is known already.
        effort: counts what is computed.
    """
    samples = _sampled(vectors, steps)
    maxima = _refined_maxima(vectors, samples)
    # Of values that are assigned to one place the last one stays: the largest, and of equal ones
    # the first.
    length, time = np.zeros((2, len(least)))
    order = np.argsort(-maxima.length, kind="stable")[::-1]
    vector = maxima.vector[order]
    length[vector] = maxima.length[order]
    time[vector] = (vectors.start[maxima.segment] + maxima.time)[order]

    known = np.maximum(length, np.sqrt(least))
    between = _intervals(vectors, samples, known)
    for segment, v, longer, at in _longer_between(vectors, between, known, effort):
        if longer > length[v]:
            length[v] = longer
            time[v] = vectors.start[segment] + at
    return LargestLengths(length, time)


def _sampled(vectors: _Vectors, steps: np.ndarray) -> _Samples:
    """Samples of the vectors. Args: steps (n,), of the samples in each segment."""
    n, m, k, _ = vectors.waves.shape
    step = vectors.lengths / steps
    ends = np.cumsum(steps + 1)
    begins = ends - steps - 1
    segment = np.repeat(np.arange(n), steps + 1)
    t = (np.arange(len(segment)) - begins[segment]) * step[segment]
    force = []
    for rate, wave, a, b in zip(vectors.rates, vectors.wave, begins, ends, strict=True):
        force.append(oscillations(t[a:b, None] * rate, wave))
    components = np.concatenate(force) @ vectors.P.T
    square = np.square(components).reshape(-1, m, k).sum(axis=2)
    return _Samples(segment, t, square, step, begins, ends)


def _refined_maxima(vectors: _Vectors, samples: _Samples) -> _Maxima:
    """The local maxima of samples, each refined between its two neighbours."""
    sample, vector = np.nonzero(_local_maxima(samples))
    t, i = samples.t[sample], samples.segment[sample]
    low = np.maximum(t - samples.step[i], 0.0)
    high = np.minimum(t + samples.step[i], vectors.lengths[i])
    length, time = _refined(vectors.rates[i], vectors.waves[i, vector], t, low, high)
    return _Maxima(i, vector, length, time)


def _intervals(vectors: _Vectors, samples: _Samples, known: Array) -> _Intervals:
    """The intervals between samples in which a vector may be longer than is known (m,).

    Between samples h apart a vector exceeds the longer one by κ h² / 8 at most, with the bound
    κ = |Σ_j |λ_j|² |wave_j|| of its second derivative.
    """
    curved = np.abs(vectors.waves) * np.abs(vectors.rates[:, None, None]) ** 2
    bend = _lengths(curved.sum(axis=3))
    # Each sample but the last one of a segment begins an interval.
    first = np.delete(np.arange(len(samples.t)), samples.ends - 1)
    longer = np.sqrt(np.maximum(samples.square[first], samples.square[first + 1]))
    segment = samples.segment[first]
    width = samples.step[segment]
    above = longer + bend[segment] * width[:, None] ** 2 / 8.0
    interval, vector = np.nonzero(above > (1.0 + HIDDEN) * known)
    segment = segment[interval]
    return _Intervals(
        segment,
        vector,
        samples.t[first[interval]],
        width[interval],
        longer[interval, vector],
        bend[segment, vector],
    )


def _longer_between(
    vectors: _Vectors, intervals: _Intervals, known: Array, effort: Effort
) -> Iterator[tuple[int, int, float, float]]:
    """Segment, vector, length and time of what is longer than is known (m,).

    Intervals are divided until none can be longer.
    """
    known = known.copy()
    intervals = intervals.kept(known)
    while len(intervals.segment):
        waves = vectors.waves[intervals.segment, intervals.vector]
        effort.spend(len(waves) * (FINER + 1) * waves[0].size)
        t, size = _sampled_again(vectors, waves, intervals)
        maxima = _largest_of_each(vectors, waves, intervals, t, size)
        for segment, v, length, time in zip(*(part.tolist() for part in maxima), strict=True):
            if length > known[v]:
                known[v] = length
                yield segment, v, length, time
        intervals = _parts(intervals, t, size).kept(known)


def _sampled_again(
    vectors: _Vectors, waves: ComplexArray, intervals: _Intervals
) -> tuple[Array, Array]:
    """Times and lengths (c, s) of samples that are `FINER` times denser in each interval.

    Args: waves (c, k, j), of the vector of each interval.
    """
    width = intervals.width / FINER
    t = intervals.low[:, None] + width[:, None] * np.arange(FINER + 1)
    turned = np.exp(t[..., None] * vectors.rates[intervals.segment, None])
    return t, _lengths((turned @ np.swapaxes(waves, 1, 2)).real)


def _largest_of_each(
    vectors: _Vectors, waves: ComplexArray, intervals: _Intervals, t: Array, size: Array
) -> _Maxima:
    """The largest sample of each interval, refined. Args: of `_sampled_again`, and its result."""
    i, width = intervals.segment, intervals.width / FINER
    at = t[np.arange(len(i)), size.argmax(axis=1)]
    low, high = np.maximum(at - width, 0.0), np.minimum(at + width, vectors.lengths[i])
    length, time = _refined(vectors.rates[i], waves, at, low, high)
    return _Maxima(i, intervals.vector, length, time)


def _parts(intervals: _Intervals, t: Array, size: Array) -> _Intervals:
    """The parts of intervals between samples, each an interval. Args: of `_sampled_again`."""
    longer = np.maximum(size[:, 1:], size[:, :-1]).ravel()
    values = intervals.segment, intervals.vector, intervals.width / FINER, intervals.bend
    segment, vector, width, bend = (np.repeat(value, FINER) for value in values)
    return _Intervals(segment, vector, t[:, :-1].ravel(), width, longer, bend)


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


def _lengths(vectors: Array) -> Array:
    """The lengths (...) of vectors (..., k)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


def _local_maxima(samples: _Samples) -> np.ndarray:
    """Mask (s, m) of the samples that are maxima among their neighbours, and nearly the largest.

    A sample at the end of a segment may exceed those of the next, whose maximum lies between its
    samples: both count.
    """
    square = samples.square
    rises, falls = np.ones((2, *square.shape), dtype=bool)
    rises[1:] = square[1:] > square[:-1]
    falls[:-1] = ~rises[1:]
    rises[samples.begins], falls[samples.ends - 1] = True, True
    local = rises & falls & (square >= NEAR_MAXIMUM * square.max(axis=0))
    if np.count_nonzero(local) > MOST_MAXIMA * square.shape[1]:
        among = np.where(local, square, -1.0)
        local &= square >= np.partition(among, -MOST_MAXIMA, axis=0)[-MOST_MAXIMA]
    return np.asarray(local)


def _refined(
    rate: ComplexArray, waves: ComplexArray, t: Array, low: Array, high: Array
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
