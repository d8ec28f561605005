"""The first root of sums of oscillations: none is passed over, none is invented."""

import numpy as np
import pytest

from shockpc.wings.compliant.motion.crossing import Effort, Signals, first_crossing


def signals(constant, cosine, sine, linear=0.0, either=False):
    """Signals without tolerance."""
    s = len(cosine)
    start = constant + np.sum(cosine, axis=1)
    full = [
        np.broadcast_to(np.asarray(value, dtype=float), s) for value in (0.0, start, linear, 0.0)
    ]
    return Signals(np.full(s, either), *full, np.asarray(cosine) - 1j * np.asarray(sine))


@pytest.mark.parametrize("dip", [1e-3, 1e-8])
def test_a_signal_that_only_just_reaches_zero(dip):
    """1 + (1 ± dip) cos t near t = π; a fast oscillation beside it changes nothing."""
    sigma = np.array([1.0, 40.0])
    reached, index = first_crossing(
        1j * sigma, signals(1.0, [[1.0 + dip, 0.0]], [[0.0, 0.0]]), 20.0, Effort()
    )
    assert index == 0
    assert reached == pytest.approx(np.arccos(-1.0 / (1.0 + dip)), abs=1e-8)
    assert first_crossing(
        1j * sigma, signals(1.0, [[1.0 - dip, 0.0]], [[0.0, 0.0]]), 20.0, Effort()
    ) == (20.0, None)


@pytest.mark.parametrize("seed", range(20))
def test_the_first_of_several_roots(seed):
    """As in a dense table of the same signals, of which one also grows."""
    rng = np.random.default_rng(seed)
    sigma, cosine, sine = (
        10.0 ** rng.uniform(-1.0, 2.0, 4),
        rng.normal(size=(3, 4)),
        rng.normal(size=(3, 4)),
    )
    sums = signals(
        1.0 - cosine.sum(axis=1) + rng.uniform(0.0, 3.0, 3), cosine, sine, [0.0, 0.1, -0.1]
    )
    time, index = first_crossing(1j * sigma, sums, 3.0, Effort())
    t = np.linspace(0.0, 3.0, 100001)
    angle = np.outer(t, sigma)
    values = (
        sums.start
        - cosine.sum(axis=1)
        + np.outer(t, sums.linear)
        + np.cos(angle) @ cosine.T
        + np.sin(angle) @ sine.T
    )
    below = np.flatnonzero(values.min(axis=1) < 0.0)
    if not len(below):
        assert (time, index) == (3.0, None)
    else:
        assert t[below[0]] - t[1] <= time <= t[below[0]]
        assert index == np.argmin(values[below[0]])


def test_a_signal_of_either_sign_ends_where_it_changes_sign():
    """The signal sin 2t − 2 sin t, −t³ at first, changes sign at π; and a straight line falls
    without any oscillation.
    """
    sigma = np.array([1.0, 2.0])
    time, _ = first_crossing(
        1j * sigma, signals(0.0, [[0.0, 0.0]], [[-2.0, 1.0]], either=True), 20.0, Effort()
    )
    assert time == pytest.approx(np.pi)
    assert first_crossing(
        1j * sigma, signals(1.0, [[0.0, 0.0]], [[0.0, 0.0]], -0.5), 20.0, Effort()
    ) == (2.0, 0)


@pytest.mark.parametrize("rise", [1e-9, 1e-3, 1.0])
@pytest.mark.parametrize("size", [0.0, 1e-3])
def test_a_signal_that_rises_first_falls_later(rise, size):
    """As the gap of a contact that hops: rise t − t² between two samples, also beside an
    oscillation.
    """
    hop = signals(0.0, [[0.0]], [[0.0]], rise)._replace(
        square=np.array([-1.0]), wave=np.array([[1j * size * rise]])
    )
    time, index = first_crossing(1j * np.array([1e-3]), hop, 20.0, Effort())
    assert (time, index) == (pytest.approx(rise * (1.0 - 1e-3 * size), rel=1e-6), 0)


def test_a_search_ends_where_a_signal_grows_faster_than_it_oscillates():
    """2 + t + cos 1e9 t never falls; what only does not fall by cancellation of its terms is
    searched, and refused.
    """
    assert first_crossing(
        1j * np.array([1e9]), signals(2.0, [[1.0]], [[0.0]], 1.0), 1e3, Effort()
    ) == (1e3, None)
    with pytest.raises(ArithmeticError, match="nothing changes"):
        first_crossing(
            1j * np.array([1.0, 1.0]), signals(1.0, [[0.6, -0.6]], [[0.0, 0.0]]), 1e9, Effort()
        )
