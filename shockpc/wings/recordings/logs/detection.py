"""Touchdowns of a foot that falls: kinks of its height over time.

Before and behind each sample a straight line is fitted to the heights. A touchdown is where the
slope of the line ahead exceeds that of the line behind by more than noise explains, the foot fell
and then does not, had been up, and stays down.
"""

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array

WINDOW, FEWEST = 6e-3, 3
"""Time [s] and samples that a line is fitted to, whichever is longer."""

WIDEST = 25e-3
"""Largest such time, where noisy heights would hide the smallest jump [s]."""

LEAST_JUMP, SIGNIFICANT = 0.15, 5.0
"""Smallest jump of a slope that is a kink [m/s], and that in standard deviations.

These are by the noise of the heights.
"""

STILL_FALLING = 0.5
"""Share of the slope before a kink that may be left after it."""

FULL_FALL = 0.9
"""Share of the slope of its fall with which a foot still falls.

The last such sample is that of the touchdown. The force of the ground takes some milliseconds to
stop the foot, so that the lines cross later.
"""

CLEARANCE = 5e-3
"""Height from which a foot comes down again after a landing, beyond noise [m]."""

REST, SHORTEST = 40e-3, 20e-3
"""Time for which a foot has to stay down, and at the end of a log at least [s]."""

REBOUND, SINKING = 10e-3, 0.25
"""Rise in that time beyond noise that a foot may have [m], and share of its fall that it may sink.

The share is of the speed with which it fell.
"""

NOISE = 6.0
"""Standard deviations beyond which a height is more than noise."""


def line_slopes(t: Array, x: Array, n: int) -> tuple[Array, Array]:
    """Slopes (N,) of the straight lines through the n intervals behind and ahead of each sample.

    At the ends the intervals are fewer, and the slope of a single sample is NaN.

    The weights of the samples are those of least squares for equal intervals; the slopes are exact
    for any intervals of a line.

    Args:
        t: (N,) times, rising [s].
        x: (N,) values.
        n: number of intervals, at least 2.
    """
    return _slopes_behind(t, x, n), _slopes_behind(-t[::-1], -x[::-1], n)[::-1]


def _slopes_behind(t: Array, x: Array, n: int) -> Array:
    behind, t = np.full(len(t), np.nan), t - t[0]
    for m in range(2, min(n, len(t) - 1)):
        weight = np.arange(m + 1) - 0.5 * m
        behind[m] = weight @ x[: m + 1] / (weight @ t[: m + 1])
    if len(t) > n:
        weight = np.arange(n + 1) - 0.5 * n
        behind[n:] = np.correlate(x, weight) / np.correlate(t, weight)
    return behind


def noise(x: Array) -> float:
    """Standard deviation of the noise of a smooth signal (N,).

    It is by third differences, which have 20 times its variance.
    """
    return float(1.4826 * np.median(np.abs(np.diff(x, 3))) / np.sqrt(20.0)) if len(x) > 3 else 0.0


def slope_noise(sigma: float, period: float, n: int) -> float:
    """Standard deviation of a slope through n intervals.

    Args: sigma of the values; period of the samples [s].
    """
    return sigma / (period * math.sqrt(n * (n + 1) * (n + 2) / 12.0))


class FootLanding(NamedTuple):
    """A landing of a foot.

    Attributes:
        sample: the last one before the first of its points is stopped.
        points: numbers of those that are stopped within the time that counts as together.
        speed: of the line behind, with which the first of them fell [m/s].
    """

    sample: int
    points: tuple[int, ...]
    speed: float


def foot_landings(t: Array, heights: Array, together: float) -> tuple[list[FootLanding], list[int]]:
    """The landings of a foot, and the samples at which it may bounce.

    There it is stopped but does not stay.

    Args:
        t: (N,) times without gaps, rising [s].
        heights: (N, p) of its points above level ground, wherever that is [m].
        together: time within which points are stopped that land together [s].
    """
    if len(t) < 2 * FEWEST:
        return [], []
    lowest = heights.min(axis=1)
    tolerance = NOISE * max(map(noise, heights.T))
    kinks: list[tuple[int, int, _Kink]] = []
    for p, height in enumerate(heights.T):
        for kink in _kinks(t, height):
            kinks.append((kink.last, p, kink))
    kinks.sort()

    landings: list[FootLanding] = []
    rebounds: list[int] = []
    since = 0
    for sample, p, kink in kinks:
        # Points of a foot that stop together are one landing.
        if landings and t[sample] - t[landings[-1].sample] <= together:
            points = {*landings[-1].points, p}
            landings[-1] = landings[-1]._replace(points=tuple(sorted(points)))
            continue
        if landings and t[sample] - t[since] <= REST:
            continue
        outcome = _after_kink(t, lowest, kink, since, tolerance)
        if outcome == "unknown":
            break
        if outcome == "rebounds":
            rebounds.append(sample)
        if outcome == "lands":
            landings.append(FootLanding(sample, (p,), kink.speed))
            since = kink.sample
    return landings, rebounds


def _after_kink(
    t: Array, lowest: Array, kink: "_Kink", since: int, tolerance: float
) -> Literal["lands", "rebounds", "goes on", "unknown"]:
    """What a foot does after a kink.

    It lands if it was up before, and neither sinks nor bounces after it.

    Args:
        t: (N,) times [s].
        lowest: (N,) height of its lowest point [m].
        kink: of one of its points.
        since: sample of the landing before.
        tolerance: height beyond noise [m].
    """
    end = int(np.searchsorted(t, t[kink.sample] + REST + 1e-9))
    after = lowest[kink.sample : end]
    rest = t[end - 1] - t[kink.sample]
    if rest < SHORTEST:
        return "unknown"  # whether it stays is not known
    highest = lowest[min(since, kink.last) : kink.last + 1].max()
    was_up = highest >= after[0] + CLEARANCE + tolerance
    sinks = after[0] - after.min() > SINKING * kink.speed * rest + tolerance
    if not was_up or sinks:
        return "goes on"
    return "rebounds" if after.max() > after[0] + REBOUND + tolerance else "lands"


class _Kink(NamedTuple):
    """A point that fell and does not any more.

    Attributes:
        last: the last sample before the touchdown.
        sample: of the kink of its height.
        speed: of the fall [m/s].
    """

    last: int
    sample: int
    speed: float


def _kinks(t: Array, height: Array) -> Iterator[_Kink]:
    """The kinks at which a point stops. Args: t (N,) [s], height (N,) [m]."""
    sigma = noise(height)
    period = float(np.median(np.diff(t)))
    threshold, n = _threshold(t, height, sigma, period)
    behind, ahead = line_slopes(t, height, n)
    jump = np.nan_to_num(ahead - behind, nan=-np.inf)
    falls = behind <= -0.5 * np.maximum(jump, threshold)
    stops = (jump >= threshold) & falls & (ahead >= STILL_FALLING * behind)
    jump = np.where(stops, jump, -np.inf)
    for k in np.flatnonzero(stops).tolist():
        first = max(k - n, 0)
        # Of kinks nearer than the length of the lines the largest one is the stop.
        if jump[k] < jump[first : k + n + 1].max():
            continue
        fall = float(np.nanmin(behind[first : k + 1]))
        m = _fewest_intervals(sigma, period, n, fall)
        slowest = FULL_FALL * fall + 2.0 * slope_noise(sigma, period, m)
        begin = max(k - 2 * n, 0)
        near = slice(begin, k + n + 1)
        last = _last_falling(t[near], height[near], m, slowest)
        yield _Kink(first if last is None else begin + last, k, -fall)


def _last_falling(t: Array, height: Array, m: int, slowest: float) -> int | None:
    """The middle sample of the last line of m intervals that falls at least so fast.

    None without such a line.

    Args:
        t: (N,) [s].
        height: (N,) [m].
        m: intervals of a line.
        slowest: the largest slope, below zero [m/s].
    """
    slopes = (height[m:] - height[:-m]) / (t[m:] - t[:-m])
    falling = np.flatnonzero(slopes <= slowest)
    return m - m // 2 + int(falling[-1]) if len(falling) else None


def _threshold(t: Array, height: Array, sigma: float, period: float) -> tuple[float, int]:
    """The least change of speed that is a kink [m/s], and the intervals of the lines that show it.

    Lines are as short as noise permits.

    Args:
        t: (N,) [s].
        height: (N,) [m].
        sigma: noise of a height [m].
        period: between samples [s].
    """
    best = math.inf, 0
    for n in range(intervals(t, WINDOW), intervals(t, WIDEST) + 1):
        slopes, _ = line_slopes(t, height, n)
        deviation = max(slope_noise(sigma, period, n), _scatter(slopes, n))
        best = min(best, (SIGNIFICANT * math.sqrt(2.0) * deviation, n))
        if best[0] <= LEAST_JUMP:
            break
    return max(LEAST_JUMP, best[0]), best[1]


def _fewest_intervals(sigma: float, period: float, n: int, fall: float) -> int:
    """As few intervals, up to n, as noise permits for the speed of a fall [m/s]."""
    for m in range(1, n):
        if 2.0 * slope_noise(sigma, period, m) <= (1.0 - FULL_FALL) * -fall:
            return m
    return n


def _scatter(slope: Array, n: int) -> float:
    """Standard deviation of slopes about smooth ones.

    It is by second differences of those that share no sample (6 times its variance).

    It also shows what wanders from sample to sample, such as an estimated position.

    Args:
        slope: (N,) of the lines behind each sample [m/s].
        n: intervals of a line.
    """
    s = slope[2 : len(slope) - 2]
    # s_i − 2 s_{i+n+1} + s_{i+2n+2}
    second = s[: -2 * n - 2] - 2.0 * s[n + 1 : -n - 1] + s[2 * n + 2 :]
    if len(second) <= 40 * n:
        return 0.0
    return float(1.4826 * np.median(np.abs(second)) / math.sqrt(6.0))


def intervals(t: Array, window: float) -> int:
    """Number of intervals in a window [s], at least those between the fewest samples.

    Args: t (N,) times [s].
    """
    return max(FEWEST - 1, round(window / float(np.median(np.diff(t)))))
