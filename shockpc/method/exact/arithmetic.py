"""The interface of an arithmetic: its numbers, matrices of them, and both made of doubles.

Balls (`balls`) enclose the exact answer for one posture, symbols (`symbols`) become code for any.
Arrays of numbers are NumPy arrays of objects, so that the formulas of arrays of doubles run on them
as well.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

import numpy as np

from shockpc.core.spatial import Array

Numbers: TypeAlias = np.ndarray[Any, np.dtype[Any]]
"""An array of numbers of an arithmetic; what is written for doubles takes it as well."""


class Number(Protocol):
    """A number, or what stands for one; the other operand may be a double."""

    def __add__(self, other: Any, /) -> Any: ...
    def __radd__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __rsub__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __rmul__(self, other: Any, /) -> Any: ...
    def __truediv__(self, other: Any, /) -> Any: ...
    def __rtruediv__(self, other: Any, /) -> Any: ...
    def __neg__(self) -> Any: ...
    def __abs__(self) -> Any: ...

    def sqrt(self) -> Any:
        """The square root."""

    def sin_cos(self) -> tuple[Any, Any]:
        """The sine and the cosine."""

    def nonnegative_part(self) -> Any:
        """A number that is not below zero, without what its error would allow there."""

    def max(self, other: Any, /) -> Any:
        """The larger of two."""


class Matrix(Protocol):
    """A matrix of numbers; the other operand of a product may be a number."""

    def __add__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __neg__(self) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __truediv__(self, other: Any, /) -> Any: ...
    def __getitem__(self, place: Any, /) -> Any: ...
    def __setitem__(self, place: Any, value: Any, /) -> None: ...

    def nrows(self) -> int:
        """Number of rows."""

    def ncols(self) -> int:
        """Number of columns."""

    def transpose(self) -> Any:
        """The transpose."""

    def entries(self) -> list[Any]:
        """The entries, row after row."""

    def table(self) -> list[list[Any]]:
        """The rows."""

    def solve(self, right: Any, /, *, algorithm: Literal["lu"]) -> Any:
        """The solution X of A X = right.

        Raises:
            ZeroDivisionError: a pivot may be zero.
        """


class NoValueError(TypeError):
    """A formula compares numbers, or rounds them to doubles, and symbols have no values."""


class SingularError(ArithmeticError):
    """A pivot may be zero, and the equation has no proven solution.

    No inertia resists a motion, rows depend on one another, or the precision is too low to tell.

    Attributes:
        of_inertia: whether it is the inertia's.
    """

    def __init__(self, of_inertia: bool) -> None:
        super().__init__(of_inertia)
        self.of_inertia = of_inertia


class Arithmetic(NamedTuple):
    """An arithmetic, by the constructors of its numbers and matrices.

    Attributes:
        number: of a double, exactly, or of a number.
        block: of a matrix: (n, m) of zeros, (n, m, entries), or of its rows.
        symmetric: makes of a matrix whose exact value is symmetric one in which both halves are the
            same expression.
    """

    number: Callable[..., Any]
    block: Callable[..., Any]
    symmetric: Callable[[Any], Any] = lambda M: M

    def numbers(self, values: Array | Numbers) -> Numbers:
        """An array of doubles, exactly, or of numbers."""
        array = np.asarray(values)
        out = np.empty(array.size, dtype=object)
        out[:] = [self.number(value) for value in array.ravel().tolist()]
        return out.reshape(array.shape)

    def matrix(self, values: Array | Numbers) -> Any:
        """A matrix (n, m) of doubles, exactly, or of numbers."""
        array = np.asarray(values)
        return self.block(*array.shape, array.ravel().tolist())

    def eye(self, n: int) -> Any:
        """The identity (n, n)."""
        return self.matrix(np.eye(n))

    def column(self, values: Sequence[Any]) -> Any:
        """A vector as a matrix (n, 1)."""
        return self.block(len(values), 1, list(values))

    def cross_matrix(self, r: Matrix) -> Any:
        """The matrix [r]× with [r]× u = r × u. Args: r (3, 1)."""
        x, y, z = r.entries()
        return self.block(3, 3, [0, -z, y, z, 0, -x, -y, x, 0])

    def rotation(self, quaternion: Iterable[Any]) -> Any:
        """The rotation (3, 3) of a quaternion (x, y, z, w), exactly orthogonal.

        The quaternion, of doubles or numbers, is divided by its length.
        """
        x, y, z, w = (self.number(value) for value in quaternion)
        squares = x * x + y * y + z * z + w * w
        s = 2 / squares
        xx, yy, zz = s * (x * x), s * (y * y), s * (z * z)
        xy, xz, yz = s * (x * y), s * (x * z), s * (y * z)
        wx, wy, wz = s * (w * x), s * (w * y), s * (w * z)
        return self.block(
            [
                [1 - yy - zz, xy - wz, xz + wy],
                [xy + wz, 1 - xx - zz, yz - wx],
                [xz - wy, yz + wx, 1 - xx - yy],
            ]
        )


def entries(M: Matrix) -> Numbers:
    """The entries (n, m) of a matrix as an array."""
    out = np.empty(M.nrows() * M.ncols(), dtype=object)
    out[:] = M.entries()
    return out.reshape(M.nrows(), M.ncols())


def solve(A: Matrix, B: Matrix, of_inertia: bool = False) -> Any:
    """The solution X of A X = B, by elimination. Args: of_inertia, whether A is an inertia.

    Raises:
        SingularError: a pivot may be zero.
    """
    try:
        return A.solve(B, algorithm="lu")
    except ZeroDivisionError:
        raise SingularError(of_inertia) from None
