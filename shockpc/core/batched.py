"""The shock of many states, from what a simulator has of each: its inertia and Jacobians.

The arrays may be of any library.
"""

from typing import Any, NamedTuple

import numpy as np


class BatchedShock(NamedTuple):
    """The impact of B states; arrays of the library that the inputs are of.

    What cannot be computed of a state is NaN.

    Attributes:
        shock: (B, p) of the points, |Δv| over the speed of the fastest contact [1].
        impulse: (B, c, d) of the ground along the rows of the contacts [N s].
        pivot: (B,) smallest share of a row that the other rows leave free, min 1 / (A⁻¹)_kk of the
            Delassus matrix A scaled to a unit diagonal: 1 for rows that do not affect one another,
            0 for rows that depend on one another. The smallest eigenvalue of A lies between it and
            its c d-th part. Where it is below the square root of the type's precision (1e-8 for 64
            bits, 3e-4 for 32), the numbers are not to be trusted.
    """

    shock: Any
    impulse: Any
    pivot: Any


def batched_shock(
    xp: Any,
    M: Any,
    J_c: Any,
    J_p: Any,
    v: Any,
    restitution: Any = 0.0,
    locked: Any = None,
    contacts: Any = None,
    v_in: Any = None,
) -> BatchedShock:
    """The impact of B states (Eq. 4).

    A state with NaN, or whose matrices are singular, does not change the others. Arrays of 16 bits
    are computed with in 32.

    Args:
        xp: the library, `numpy`, `torch` or `jax.numpy`, also under `jax.jit`.
        M: (B, nv, nv) joint-space inertia [kg, kg m, kg m²].
        J_c: (B, c, d, nv) Jacobians of c contact points along the d directions that the ground
            holds.
        J_p: (B, p, 3, nv) Jacobians of p points.
        v: (B, nv) velocity before the impact [rad/s, m/s].
        restitution: e, a number or (B, c, 1) [1].
        locked: (nv,) bool, velocities that the impact does not change.
        contacts: (B, c) bool, which of them are held: feet that strike, and feet that stand
            already, whose velocity is zero; all by default. Where none is, the shock is NaN without
            `v_in`, else 0.
        v_in: (B,) speed that normalises shock [m/s]; by default that of the fastest contact, along
            its d directions.

    Raises:
        ValueError: an array has another shape or type than stated. Arrays of numbers have the type
            of M.
    """
    _refuse_other_arrays(M, J_c, J_p, v, restitution, locked, contacts, v_in)
    M, J_c, J_p = _promoted(xp, M), _promoted(xp, J_c), _promoted(xp, J_p)
    v, restitution, v_in = _promoted(xp, v), _promoted(xp, restitution), _promoted(xp, v_in)
    v_contacts = (J_c @ v[:, None, :, None])[..., 0]
    # Masks, because a selection would give each state a shape of its own, which compilers refuse.
    strikes = xp.ones_like(v_contacts)
    if contacts is not None:
        strikes = strikes * contacts[..., None]
    v_contacts = strikes * v_contacts
    free = _free(xp, v.sum(0), locked)  # the sum has the shape (nv,), and the type and device of v
    B, c, d, nv = J_c.shape
    J = (J_c * strikes[..., None]).reshape(B, c * d, nv) * free

    # A = J Y with Y = M⁻¹ Jᵀ. A velocity that is locked has the row and the column of a unit
    # matrix in M, so that it stays as it is.
    Y = _solve(xp, _held(xp, M, free), J.mT)
    # Eq. 4: A f = −(1 + e) J v, with the rows of contacts that are not held left out.
    undone = ((1.0 + restitution) * v_contacts).reshape(B, c * d, 1)
    impulse, pivot = _impulses(xp, J @ Y, undone, strikes.reshape(B, c * d))

    # Shock |J_p Δq̇| / v_in with Δq̇ = Y f.
    jump = (J_p @ (Y @ impulse)[:, None])[..., 0]
    if v_in is None:
        v_in = xp.amax(_length(xp, v_contacts), -1)
    return BatchedShock(_length(xp, jump) / v_in[:, None], impulse.reshape(B, c, d), pivot)


def _impulses(xp: Any, A: Any, undone: Any, strikes: Any) -> tuple[Any, Any]:
    """The impulses f (B, n, 1) with A f = −(1 + e) J v, and the smallest pivot (B,).

    Args:
        xp: the library.
        A: (B, n, n) Delassus matrices.
        undone: (B, n, 1) (1 + e) J v.
        strikes: (B, n) one for each row that strikes, else zero.
    """
    # A scaled to a unit diagonal; a contact that does not strike has the row and the column of a
    # unit matrix.
    diagonal = xp.linalg.diagonal(A)
    scale = xp.where(diagonal > 0.0, diagonal, 1.0) ** -0.5
    eye = _eye(xp, strikes.sum(0))
    scaled = A * scale[..., None] * scale[:, None] + eye * (1.0 - strikes)[..., None]

    # A⁻¹ is for the pivots. The last digit on the diagonal keeps rows that depend on one another
    # from a division by zero.
    right = xp.concatenate([scale[..., None] * undone, xp.ones_like(undone) * eye], -1)
    solved = _solve(xp, scaled + xp.finfo(A.dtype).eps * eye, right)
    impulse = -scale[..., None] * solved[..., :1]
    inverse_diagonal = xp.linalg.diagonal(solved[..., 1:])
    return impulse, 1.0 / xp.amax(abs(inverse_diagonal), -1)


def effective_mass(xp: Any, M: Any, J_c: Any, locked: Any = None) -> Any:
    """Effective mass (B, c) of each contact point alone along the last of its directions [kg].

    m = (A⁻¹)_dd with A = J M⁻¹ Jᵀ (Khatib 1995): give the normal last. With three directions the
    point sticks, with the normal alone it slides. Of dependent rows it is NaN.

    Args: as of `batched_shock`.
    """
    M, J_c = _promoted(xp, M), _promoted(xp, J_c)
    inverse = _inverse(xp, _mobility(xp, M, J_c, _free(xp, M[0, 0], locked)))
    return inverse[..., -1, -1]


def mitigation(xp: Any, M: Any, J_c: Any, base: int = 6, locked: Any = None) -> Any:
    """Impact mitigation factor (B, c) of each contact point alone [1].

    ξ = det(1 − A⁻¹ A_L) with A = J M⁻¹ Jᵀ, and A_L the same with every joint locked (Wensing et
    al., T-RO 2017, Eq. 8): 0 for a rigid robot, 1 where the joints take all of the impact.

    Args:
        xp: the library.
        M: (B, nv, nv) joint-space inertia.
        J_c: (B, c, 3, nv) Jacobians of the contact points.
        base: how many of the velocities are those of the free base, which come first.
        locked: (nv,) bool, velocities that the impact does not change.
    """
    M, J_c = _promoted(xp, M), _promoted(xp, J_c)
    d = J_c.shape[2]
    A = _mobility(xp, M, J_c, _free(xp, M[0, 0], locked))
    M_base = M[:, :base, :base]
    A_L = _mobility(xp, M_base, J_c[..., :base], _free(xp, M_base[0, 0], None))
    share = _solve(xp, A.reshape(-1, d, d), A_L.reshape(-1, d, d)).reshape(A.shape)
    return xp.linalg.det(_eye(xp, share[0, 0, 0]) - share)


def _free(xp: Any, like: Any, locked: Any) -> Any:
    """Mask (nv,) of the free velocities, one or zero, of the type of an array (nv,)."""
    ones = xp.ones_like(like)
    return ones if locked is None else ones * ~locked


def _held(xp: Any, M: Any, free: Any) -> Any:
    """The inertia with the rows and columns of a unit matrix where velocities are not free."""
    return M * (free[:, None] * free) + _eye(xp, free) * (1.0 - free)


def _mobility(xp: Any, M: Any, J: Any, free: Any) -> Any:
    """A = J M⁻¹ Jᵀ (B, c, d, d) of each contact alone [1/kg]."""
    B, c, d, nv = J.shape
    rows = J.reshape(B, c * d, nv) * free
    response = _solve(xp, _held(xp, M, free), rows.mT).mT.reshape(B, c, d, nv)
    return rows.reshape(B, c, d, nv) @ response.mT


def _inverse(xp: Any, A: Any) -> Any:
    """Inverses (..., d, d); NaN where a matrix is singular."""
    d = A.shape[-1]
    unit = xp.ones_like(A) * _eye(xp, A[0, 0, 0])
    return _solve(xp, A.reshape(-1, d, d), unit.reshape(-1, d, d)).reshape(A.shape)


def _promoted(xp: Any, array: Any) -> Any:
    """An array of 16 bits in 32; others as they are.

    In 32 bits sums over a robot keep three digits.
    """
    if _kind(array) not in ("float16", "bfloat16"):
        return array
    return array.to(xp.float32) if hasattr(array, "to") else array.astype(xp.float32)


def _refuse_other_arrays(
    M: Any, J_c: Any, J_p: Any, v: Any, restitution: Any, locked: Any, contacts: Any, v_in: Any
) -> None:
    """Refuse arrays whose shapes would be broadcast to another meaning, and masks of numbers.

    Raises a ValueError. Only shapes and types are read, which a device and a compiler have
    without a computation.
    """
    for name, array, dimensions in (("M", M, 3), ("J_c", J_c, 4), ("J_p", J_p, 4), ("v", v, 2)):
        if len(_shape(array)) != dimensions:
            raise ValueError(
                f"{name} has the shape {_shape(array)}; it needs {dimensions} dimensions"
            )

    # Types that differ would be promoted, which the array libraries do differently.
    if "float" not in _kind(M) or _kind(J_c) != _kind(M):
        raise ValueError(
            f"M has the type {_kind(M)} and J_c {_kind(J_c)}; both have to be of one floating type"
        )

    # J_c (B, c, 3, nv) sets the numbers of states, contacts and velocities of all arrays.
    B, c, _, nv = J_c.shape
    number = _kind(M)
    expected = {
        "M": (M, (B, nv, nv), number),
        "J_p": (J_p, (B, J_p.shape[1], 3, nv), number),
        "v": (v, (B, nv), number),
        "restitution": (restitution, (B, c, 1), number),
        "locked": (locked, (nv,), "bool"),
        "contacts": (contacts, (B, c), "bool"),
        "v_in": (v_in, (B,), number),
    }
    for name, (array, shape, kind) in expected.items():
        is_number = name == "restitution" and _shape(array) == ()
        if array is None or is_number:
            continue
        if _shape(array) != shape:
            raise ValueError(
                f"{name} has the shape {_shape(array)}; with J_c {tuple(J_c.shape)} it has to be "
                f"{shape}"
            )
        # A mask of numbers would scale rows instead of selecting them.
        if _kind(array) != kind:
            reason = "" if kind == "bool" else ", as M has"
            raise ValueError(f"{name} has the type {_kind(array)}; it has to be {kind}{reason}")


def _shape(array: Any) -> tuple[int, ...]:
    """The shape of an array; of a number, and of what is no array, ()."""
    return tuple(getattr(array, "shape", ()))


def _kind(array: Any) -> str:
    """The name of an array's type, such as "float32"."""
    return str(getattr(array, "dtype", type(array).__name__)).rpartition(".")[2]


def _eye(xp: Any, like: Any) -> Any:
    """The unit matrix (n, n) of the type, and on the device, of an array (n,)."""
    ones = xp.ones_like(like)
    index = xp.cumsum(ones, 0)
    return (index[:, None] == index) * ones


def _solve(xp: Any, matrices: Any, right: Any) -> Any:
    """Solutions X of A X = B, for A (B, n, n) and B (B, n, k); NaN where A is singular.

    An error would end the computation of all states.
    """
    # of PyTorch; `solve` would wait for the device to ask whether a matrix is singular
    if hasattr(xp.linalg, "solve_ex"):
        solution, singular = xp.linalg.solve_ex(matrices, right)
        return xp.where((singular == 0)[:, None, None], solution, xp.nan)
    try:
        return xp.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:  # NumPy does not say which state
        if len(matrices) == 1:
            return xp.full_like(right, xp.nan)
        solutions = []
        for k in range(len(matrices)):
            solutions.append(_solve(xp, matrices[k : k + 1], right[k : k + 1]))
        return xp.concatenate(solutions)


def _length(xp: Any, vectors: Any) -> Any:
    """Lengths of vectors (..., n), whose gradient is zero where they are."""
    square = (vectors * vectors).sum(-1)
    zero = square == 0.0
    return xp.where(zero, 0.0, xp.where(zero, 1.0, square) ** 0.5)
