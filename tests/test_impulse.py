"""Step 1 on arrays alone: the paper's equation, its special forms, and contacts that repeat or contradict one another."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shockpc.core.impulse import independent_rows, residuals, solve_impact, weakest_columns
from shockpc.errors import SolveError

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(1, 12)
TIGHT = 1e-9  # cond(H) up to 1e6 in what is drawn here


def system(seed, n, rows, k=2):
    """A random inertia with units over three decades, rows, and speeds to undo."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-1.5, 1.5, (n, 1))
    return A @ A.T + 0.01 * np.diag(np.diag(A @ A.T)), rng.normal(size=(rows, n)), rng.normal(size=(rows, k)), rng


@given(SEEDS, SIZES, st.data())
def test_the_solution_meets_the_paper_s_equation(seed, n, data):
    """Eq. 4, assembled whole and solved as one matrix, gives the same jump and the same multipliers."""
    nc = data.draw(st.integers(1, n))
    H, J, b, _ = system(seed, n, nc)
    K = np.block([[H, J.T], [J, np.zeros((nc, nc))]])
    direct = np.linalg.solve(K, np.vstack([np.zeros((n, 2)), -b]))
    found = solve_impact(H, J, b)
    # A square J all but fixes the jump, however badly it is conditioned.
    worse = np.linalg.cond(J) * TIGHT
    np.testing.assert_allclose(found.delta_qd, direct[:n], rtol=0, atol=worse * np.abs(direct[:n]).max())
    np.testing.assert_allclose(found.impulse, -direct[n:], rtol=0, atol=worse * np.abs(direct[n:]).max())
    assert found.rank == nc
    assert found.unique.all()


@given(SEEDS, st.integers(2, 12), st.data())
def test_contact_at_the_joints_is_the_partition_of_eq_6(seed, n, data):
    """Where the contact stops joints themselves: Δq̇₁ = −q̇₁⁻ and Δq̇₂ = H₂₂⁻¹ H₂₁ q̇₁⁻."""
    n1 = data.draw(st.integers(1, n - 1))
    H, _, q1, _ = system(seed, n, n1)
    found = solve_impact(H, np.eye(n)[:n1], q1).delta_qd
    np.testing.assert_allclose(found[:n1], -q1, rtol=0, atol=TIGHT * np.abs(q1).max())
    other = np.linalg.solve(H[n1:, n1:], H[n1:, :n1] @ q1)
    np.testing.assert_allclose(found[n1:], other, rtol=0, atol=TIGHT * np.abs(other).max())


@given(SEEDS, st.integers(3, 12), st.data())
def test_loops_as_rows_and_loops_as_columns_agree(seed, n, data):
    """Section 3.1.1: K Δq̇ = 0 stacked under the contact, and q̇ = G ẏ with K G = 0, are the same mechanism."""
    loops = data.draw(st.integers(1, n - 2))
    H, K, _, rng = system(seed, n, loops)
    G = np.linalg.svd(K)[2][loops:].T @ rng.normal(size=(n - loops, n - loops))
    J, b = rng.normal(size=(1, n)), np.ones((1, 1))
    stacked = solve_impact(H, np.vstack([J, K]), np.vstack([b, np.zeros((loops, 1))])).delta_qd
    reduced = G @ solve_impact(G.T @ H @ G, J @ G, b).delta_qd
    worse = TIGHT * max(np.linalg.cond(G), np.linalg.cond(K))
    np.testing.assert_allclose(reduced, stacked, rtol=0, atol=worse * np.abs(stacked).max())


@given(SEEDS, st.integers(2, 10), st.integers(1, 3), st.data())
def test_repeated_rows_change_no_jump(seed, n, k, data):
    """Rows that repeat others leave Δq̇ and J_cᵀ λ alone, lower the rank, and make the impulses of their kin not unique."""
    nc = data.draw(st.integers(1, min(n, 4)))
    H, J, b, rng = system(seed, n, nc)
    mix = rng.normal(size=(k, nc))
    mix[:, 0] = 0.0  # the first row stays alone
    alone, doubled = solve_impact(H, J, b), solve_impact(H, np.vstack([J, mix @ J]), np.vstack([b, mix @ b]))
    worse = TIGHT * np.linalg.cond(J)
    np.testing.assert_allclose(doubled.delta_qd, alone.delta_qd, rtol=0, atol=worse * np.abs(alone.delta_qd).max())
    assert doubled.rank == nc
    total = np.vstack([J, mix @ J]).T @ doubled.impulse
    np.testing.assert_allclose(total, J.T @ alone.impulse, rtol=0, atol=worse * np.abs(J.T @ alone.impulse).max())
    assert doubled.unique[0]
    np.testing.assert_allclose(doubled.impulse[0], alone.impulse[0], rtol=0, atol=worse * np.abs(alone.impulse).max())
    if nc > 1:
        assert not doubled.unique[1:].any()
    momentum, contact = residuals(H, np.vstack([J, mix @ J]), np.vstack([b, mix @ b]), doubled.delta_qd, doubled.impulse)
    assert momentum < 1e-9
    assert contact.max() < 1e-9


@given(SEEDS, st.integers(3, 10))
def test_the_independent_rows_say_all(seed, n):
    """Of rows that repeat each other as many are chosen as the rank says, and they alone give the same jump."""
    H, J, b, rng = system(seed, n, 2)
    J, b = np.vstack([J, J[::-1], J.sum(axis=0), 0.0 * J[0]]), np.vstack([b, b[::-1], b.sum(axis=0), 0.0 * b[0]])
    order = rng.permutation(6)
    J, b = J[order], b[order]
    found = solve_impact(H, J, b)
    chosen = independent_rows(H, J, int(found.rank), found.dead)
    assert found.rank == len(chosen) == len(set(chosen.tolist())) == np.linalg.matrix_rank(J[chosen]) == 2
    again = solve_impact(H, J[chosen], b[chosen])
    worse = TIGHT * np.linalg.cond(J[chosen])
    np.testing.assert_allclose(again.delta_qd, found.delta_qd, rtol=0, atol=worse * np.abs(found.delta_qd).max())


@pytest.mark.parametrize(("apart", "rank"), [(0.0, 1), (1e-16, 1), (1e-12, 2), (1e-6, 2), (1.0, 2)])
def test_rows_count_as_repeated_only_within_rounding(apart, rank):
    """Two rows an angle apart are two down to 1e-12 and one at 1e-16: the border is rounding in H, here 8 · 3 · 2e-16."""
    J = np.array([[1.0, 0.0, 0.0], [1.0, apart, 0.0]])
    assert solve_impact(np.eye(3), J, np.ones((2, 1))).rank == rank


@pytest.mark.parametrize("unit", [1e-4, 1e-2, 1.0, 1e4])
def test_units_decide_no_rank(unit):
    """Rows and joint rates written in other units are as independent as they were."""
    H, J, b, _ = system(3, 6, 3)
    s = np.diag([1.0, unit, 1.0, 1.0 / unit, 1.0, 1.0])
    plain = solve_impact(H, J, b)
    scaled = solve_impact(s @ H @ s, unit * J @ s, unit * b)
    assert scaled.rank == plain.rank == 3
    np.testing.assert_allclose(s @ scaled.delta_qd, plain.delta_qd, rtol=1e-9)


@pytest.mark.parametrize(("small", "rank"), [(1e-8, 3), (1e-17, 2)])
def test_a_row_that_nothing_moves_along_is_no_row(small, rank):
    """A direction in which the mechanism cannot move takes no impulse; one in which it moves a little does."""
    J = np.diag([1.0, 1.0, small])
    found = solve_impact(np.eye(3), J, np.ones((3, 1)))
    assert found.rank == rank
    assert found.unique.all()
    assert bool(found.impulse[2, 0]) is (rank == 3)
    np.testing.assert_allclose(found.delta_qd[2], -1.0 / small if rank == 3 else 0.0, rtol=1e-12)


def test_contradicting_rows_leave_a_residual():
    """One row asked for two speeds: the answer is a compromise that balances momentum, and the contact's residual tells."""
    J, b = np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([[1.0], [3.0]])
    found = solve_impact(np.eye(2), J, b)
    np.testing.assert_allclose(found.delta_qd, [[-2.0], [0.0]], atol=1e-14)
    momentum, contact = residuals(np.eye(2), J, b, found.delta_qd, found.impulse)
    assert momentum < 1e-14
    assert contact.min() > 0.1


def test_a_row_that_is_left_is_told_apart_from_one_that_is_hard():
    """A row met at a rate of 1e9 does not make room for one that cannot be met at all."""
    J, b = np.array([[1e-9, 0.0], [0.0, 1e-30]]), np.ones((2, 1))
    found = solve_impact(np.eye(2), J, b)
    np.testing.assert_allclose(found.delta_qd, [[-1e9], [0.0]])
    np.testing.assert_allclose(residuals(np.eye(2), J, b, found.delta_qd, found.impulse)[1], [0.0, 1.0], atol=1e-12)


def test_nearly_repeated_rows_that_agree_do_not_contradict():
    """Two rows 1e-12 apart carry impulses of 1e12; that is hard to balance to the last digit, but no contradiction."""
    H, J, b, _ = system(1, 5, 1, k=1)
    J = np.vstack([J, J + 1e-12 * np.array([1.0, -2.0, 0.5, 1.0, 0.3])])
    b = np.vstack([b, b])
    found = solve_impact(H, J, b)
    momentum, contact = residuals(H, J, b, found.delta_qd, found.impulse)
    assert momentum < 1e-12
    assert contact.max() < 1e-6


@given(SEEDS, SIZES, st.integers(1, 5))
def test_a_batch_is_every_system_by_itself(seed, n, count):
    """Leading axes are carried through the solve and the residual."""
    systems = [system(seed + i, n, min(n, 3)) for i in range(count)]
    H, J, b = (np.stack([one[part] for one in systems]) for part in range(3))
    together = solve_impact(H, J, b)
    left = residuals(H, J, b, together.delta_qd, together.impulse)
    for i in range(count):
        for part, alone in zip(together, solve_impact(H[i], J[i], b[i]), strict=True):
            np.testing.assert_allclose(part[i], alone, rtol=1e-12, atol=1e-12 * np.abs(np.asarray(alone, dtype=float)).max())
        alone = residuals(H[i], J[i], b[i], together.delta_qd[i], together.impulse[i])
        for line, own in zip(left, alone, strict=True):
            np.testing.assert_allclose(line[i], own, atol=1e-13)


def test_more_rows_than_rates_is_no_obstacle():
    """A block on four corners: twelve rows, six rates, rank six, every rate undone."""
    corners = np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-0.5, 0.5)])
    rows = np.concatenate([np.hstack([np.eye(3), -_skew(corner)]) for corner in corners])
    b = np.tile(np.array([[0.3], [0.0], [-1.0]]), (4, 1))
    found = solve_impact(np.diag([2.0, 2.0, 2.0, 0.1, 0.2, 0.3]), rows, b)
    np.testing.assert_allclose(found.delta_qd[:, 0], [-0.3, 0.0, 1.0, 0.0, 0.0, 0.0], atol=1e-13)
    assert found.rank == 6
    assert not found.unique.any()
    np.testing.assert_allclose(found.impulse.reshape(4, 3).sum(axis=0), [-0.6, 0.0, 2.0], atol=1e-13)


def _skew(r):
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


@pytest.mark.parametrize("diagonal", [(1.0, 0.0, 2.0), (1.0, -1.0, 2.0), (np.nan, 1.0, 1.0)])
def test_an_inertia_with_an_empty_diagonal_is_refused(diagonal):
    """A rate that moves no mass has no answer."""
    with pytest.raises(SolveError) as refusal:
        solve_impact(np.diag(diagonal), np.eye(3)[:1], np.ones((1, 1)))
    assert str(refusal.value) == "the joint-space inertia has a zero or negative diagonal, so it cannot be inverted"


def test_an_inertia_that_is_not_positive_definite_is_refused():
    """Two rates that move one mass the same way have no answer of their own."""
    with pytest.raises(SolveError) as refusal:
        solve_impact(np.ones((2, 2)) - 1e-9 * np.eye(2)[::-1] + 0.0 * np.eye(2) - 1e-8 * np.eye(2), np.eye(2)[:1], np.ones((1, 1)))
    assert str(refusal.value) == "the joint-space inertia is not positive definite, so it cannot be inverted"
    assert refusal.value.exit_code == 3


def test_a_rate_with_the_inertia_of_rounding_is_refused():
    """An inertia of 1e-33 beside 1 is what rounding makes of zero: a point mass on its own axis."""
    H = np.array([[1.0, 1e-17], [1e-17, 1e-33]])
    with pytest.raises(SolveError):
        solve_impact(H, np.array([[1.0, 0.3], [0.2, 1.0]]), np.ones((2, 1)))


@pytest.mark.parametrize(
    ("H", "columns"),
    [
        (np.diag([1.0, 0.0, 2.0]), [1]),
        (np.diag([1.0, 1e-30, 2.0]), [1]),
        (np.array([[1.0, 0, 0], [0, 1.0, 1.0], [0, 1.0, 1.0]]), [1, 2]),
        (np.zeros((2, 2)), [0, 1]),
    ],
)
def test_the_columns_to_blame_are_found(H, columns):
    """A rate without inertia is named by itself, rates that share one are named together."""
    assert weakest_columns(H) == columns
