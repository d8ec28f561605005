"""Step 1 on arrays alone: the paper's equation, its special forms, and rows that repeat or
contradict one another.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shockpc.core.impulse import TOLERANCE, independent_rows, solve_impact, weakest_columns

pytestmark = pytest.mark.smoke

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(1, 12)
TIGHT = 1e-9  # conditions up to 1e6 in what is drawn here


def system(seed, n, rows, k=2):
    """A random inertia with units over three decades, rows, speeds to be undone, and the generator
    that made them.
    """
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-1.5, 1.5, (n, 1))
    return (
        A @ A.T + 0.01 * np.diag(np.diag(A @ A.T)),
        rng.normal(size=(rows, n)),
        rng.normal(size=(rows, k)),
        rng,
    )


def solved(H, J, b, terms=None):
    """Jump, impulses and the row space, if it was needed, of one posture."""
    sizes = np.abs(J) if terms is None else terms
    found = solve_impact(H[None], J[None], b[None], lambda: sizes[None], TOLERANCE)
    assert found.rank[0] == (len(found.row_spaces[0].rows) if found.row_spaces else len(J))
    return found.delta_qd[0], found.impulse[0], found.row_spaces.get(0), int(found.rank[0])


def apart(one, other, tolerance):
    """Whether two arrays differ by less than a share of the largest entry."""
    np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * np.abs(other).max())


@given(SEEDS, SIZES, st.data())
def test_the_solution_meets_the_equation_of_the_paper(seed, n, data):
    """Eq. 4, assembled whole and solved as one matrix, gives the same jump and the same
    multipliers.
    """
    nc = data.draw(st.integers(1, n))
    H, J, b, _ = system(seed, n, nc)
    whole = np.block([[H, J.T], [J, np.zeros((nc, nc))]])
    direct = np.linalg.solve(whole, np.vstack([np.zeros((n, 2)), -b]))
    delta_qd, impulse, _, rank = solved(H, J, b)
    # A square J all but fixes the jump, however badly it is conditioned.
    apart(delta_qd, direct[:n], TIGHT * np.linalg.cond(J))
    apart(impulse, -direct[n:], TIGHT * np.linalg.cond(J))
    assert rank == nc


@given(SEEDS, st.integers(2, 12), st.data())
def test_contact_at_the_joints_is_the_partition_of_eq_6(seed, n, data):
    """Where the contact stops joints themselves (Eq. 5, H Δq̇ = [ι; 0]): Δq̇₁ = −q̇₁⁻ and Δq̇₂ =
    H₂₂⁻¹ H₂₁ q̇₁⁻.
    """
    n1 = data.draw(st.integers(1, n - 1))
    H, _, q1, _ = system(seed, n, n1)
    delta_qd, impulse, *_ = solved(H, np.eye(n)[:n1], q1)
    apart(H @ delta_qd, np.vstack([impulse, np.zeros((n - n1, 2))]), TIGHT)
    apart(delta_qd[:n1], -q1, TIGHT)
    apart(delta_qd[n1:], np.linalg.solve(H[n1:, n1:], H[n1:, :n1] @ q1), TIGHT)


@given(SEEDS, st.integers(2, 10), st.integers(1, 3), st.data())
def test_repeated_rows_change_no_jump(seed, n, k, data):
    """Rows that are sums of others leave Δq̇ and J_cᵀ λ alone and lower the rank; impulses along
    all of these are not determined.
    """
    nc = data.draw(st.integers(1, min(n, 4)))
    H, J, b, rng = system(seed, n, nc)
    mix = rng.normal(size=(k, nc))
    mix[:, 0] = 0.0  # the first row stays alone
    more, speeds = np.vstack([J, mix @ J]), np.vstack([b, mix @ b])
    alone, doubled = (
        solved(H, J, b),
        solved(H, more, speeds, np.vstack([np.abs(J), np.abs(mix) @ np.abs(J)])),
    )
    worse = TIGHT * np.linalg.cond(J)
    apart(doubled[0], alone[0], worse)
    assert doubled[3] == nc
    apart(more.T @ doubled[1], J.T @ alone[1], worse)
    row_space = doubled[2]
    assert row_space.unique[0]
    apart(doubled[1][0], alone[1][0], worse * np.abs(alone[1]).max() / np.abs(alone[1][0]).max())
    assert not row_space.unique[1:nc].any()
    assert np.linalg.matrix_rank(more[row_space.rows]) == nc
    # Impulses that are determined take no part in the distribution over the others.
    place = row_space.rows.tolist().index(0)
    np.testing.assert_array_equal(row_space.distribution[0], np.eye(nc)[place])
    np.testing.assert_array_equal(row_space.distribution[1:, place], 0.0)
    # The distribution does the same to the robot.
    apart(more.T @ row_space.distribution, more[row_space.rows].T, worse)


@pytest.mark.parametrize(
    ("distance", "rank", "uncertain"),
    [
        (0.0, 1, False),
        (1e-16, 1, False),
        (1e-14, 1, True),
        (5e-14, 2, True),
        (1e-12, 2, False),
        (1e-6, 2, False),
        (1.0, 2, False),
    ],
)
def test_rows_count_as_repeated_only_within_rounding(distance, rank, uncertain):
    """Two rows an angle apart: two, one, or so near the limit of 64 ε √2 that rounding decides."""
    J = np.array([[1.0, 0.0, 0.0], [1.0, distance, 0.0]])
    row_space = independent_rows(J, np.abs(J), np.ones(3), np.ones(2))
    assert (len(row_space.rows), row_space.uncertain) == (rank, uncertain)


def test_a_row_that_hardly_moves_hides_no_other():
    """A row of 1e-12 of its terms, beside two that are 1e-6 apart: each is compared with its
    rounding.
    """
    J = np.array([[1.0, 0.0, 0.0], [1.0, 1e-6, 0.0], [0.0, 0.0, 1e-12]])
    row_space = independent_rows(
        J, np.array([[1.0, 0.0, 0.0], [1.0, 1e-6, 0.0], [0.0, 0.0, 1.0]]), np.ones(3), np.ones(3)
    )
    assert row_space.rows.tolist() == [0, 1, 2]


@pytest.mark.parametrize("unit", [1e-4, 1e-2, 1.0, 1e4])
def test_units_decide_no_rank(unit):
    """Rows and joint velocities written in other units are as independent as they were."""
    H, J, b, _ = system(3, 6, 3)
    s = np.diag([1.0, unit, 1.0, 1.0 / unit, 1.0, 1.0])
    plain, scaled = solved(H, J, b), solved(s @ H @ s, unit * J @ s, unit * b)
    assert scaled[3] == plain[3] == 3
    np.testing.assert_allclose(s @ scaled[0], plain[0], rtol=1e-9)


@pytest.mark.parametrize(("small", "rank"), [(1e-8, 3), (1e-17, 2)])
def test_a_row_along_which_nothing_moves_takes_no_impulse(small, rank):
    """One along which the mechanism moves a little does."""
    delta_qd, impulse, _, found = solved(
        np.eye(3), np.diag([1.0, 1.0, small]), np.ones((3, 1)), np.eye(3)
    )
    assert found == rank
    assert bool(impulse[2, 0]) is (rank == 3)
    np.testing.assert_allclose(delta_qd[2], -1.0 / small if rank == 3 else 0.0, rtol=1e-12)


SINGULAR = {
    "no inertia": (np.diag([1.0, 0.0, 2.0]), [1]),
    "inertia of rounding": (np.diag([1.0, 1e-30, 2.0]), [1]),
    "shared by two": (np.array([[1.0, 0, 0], [0, 1.0, 1.0], [0, 1.0, 1.0]]), [1, 2]),
    "none at all": (np.zeros((2, 2)), [0, 1]),
}


@pytest.mark.parametrize("name", SINGULAR)
def test_velocities_without_inertia_are_found(name):
    """One without inertia is named by itself, those that share one are named together; in many
    postures they give no number.
    """
    H, columns = SINGULAR[name]
    assert weakest_columns(H) == columns
    both = np.stack([H, np.eye(len(H))])
    J = np.ones((2, 1, len(H)))
    found = solve_impact(both, J, np.ones((2, 1, 1)), lambda: J, TOLERANCE)
    assert (found.condition[0] < 1e15) == (name == "inertia of rounding")
    np.testing.assert_allclose(found.delta_qd[1], -1.0 / len(H))
