"""Symbols: numbers and matrices as expression graphs of CasADi.

A symbol has no value. A formula that needs one, to compare it or to round it, cannot be written in
symbols: `NoValueError`.
"""

import itertools
from collections.abc import Iterable, Sequence
from typing import Any, Literal, NoReturn

import casadi
import numpy as np

from shockpc.method.exact.arithmetic import Arithmetic, NoValueError, Numbers


class Symbol:
    """A number as an expression of the inputs."""

    __slots__ = ("e",)

    def __init__(self, value: Any = 0) -> None:
        self.e = _expression(value)

    def __add__(self, other: Any) -> "Symbol":
        return Symbol(self.e + _plain(other))

    def __sub__(self, other: Any) -> "Symbol":
        return Symbol(self.e - _plain(other))

    def __rsub__(self, other: Any) -> "Symbol":
        return Symbol(_plain(other) - self.e)

    def __mul__(self, other: Any) -> "Symbol":
        return Symbol(self.e * _plain(other))

    def __truediv__(self, other: Any) -> "Symbol":
        return Symbol(self.e / _plain(other))

    def __rtruediv__(self, other: Any) -> "Symbol":
        return Symbol(_plain(other) / self.e)

    def __pow__(self, exponent: int) -> "Symbol":
        return Symbol(self.e**exponent)

    def __neg__(self) -> "Symbol":
        return Symbol(-self.e)

    def __abs__(self) -> "Symbol":
        return Symbol(casadi.fabs(self.e))

    __radd__, __rmul__ = __add__, __mul__

    def sqrt(self) -> "Symbol":
        """The square root."""
        return Symbol(casadi.sqrt(self.e))

    def sin_cos(self) -> "tuple[Symbol, Symbol]":
        """The sine and the cosine."""
        return Symbol(casadi.sin(self.e)), Symbol(casadi.cos(self.e))

    def nonnegative_part(self) -> "Symbol":
        """Itself."""
        return self

    def max(self, other: Any) -> "Symbol":
        """The larger of two."""
        return Symbol(casadi.fmax(self.e, _plain(other)))

    def __bool__(self) -> bool:
        """True if it is not zero, as far as that is known without its value."""
        return not self.e.is_zero()

    def __float__(self) -> float:
        if not self.e.is_constant():
            raise NoValueError
        return float(self.e)

    def _compare(self, other: object) -> NoReturn:
        raise NoValueError

    __lt__ = __le__ = __gt__ = __ge__ = _compare


def _plain(value: Any) -> Any:
    return value.e if isinstance(value, Symbol) else value


def _expression(value: Any) -> casadi.SX:
    plain = _plain(value)
    return plain if isinstance(plain, casadi.SX) else casadi.SX(plain)


class SymbolMatrix:
    """A matrix of expressions, with the operations of python-flint's `arb_mat`.

    They are those that the exact path uses; zeros take no operations.

    Args:
        shape: (n, m) of zeros, (n, m, entries), the rows, or a matrix of CasADi.
    """

    __slots__ = ("m",)

    def __init__(self, *shape: Any) -> None:
        if isinstance(shape[0], casadi.SX):
            self.m = shape[0]
            return
        values: Sequence[Any] = ()
        if len(shape) == 1:
            rows = shape[0]
            n, m = len(rows), len(rows[0]) if len(rows) else 0
            values = list(itertools.chain.from_iterable(rows))
        else:
            n, m = shape[:2]
            if len(shape) > 2:
                values = shape[2]
        self.m = casadi.SX(n, m)
        for k, value in enumerate(values):
            plain = _plain(value)
            is_zero = plain.is_zero() if isinstance(plain, casadi.SX) else plain == 0
            if not is_zero:
                self.m[k // m, k % m] = plain

    def __add__(self, other: "SymbolMatrix") -> "SymbolMatrix":
        return SymbolMatrix(self.m + other.m)

    def __sub__(self, other: "SymbolMatrix") -> "SymbolMatrix":
        return SymbolMatrix(self.m - other.m)

    def __neg__(self) -> "SymbolMatrix":
        return SymbolMatrix(-self.m)

    def __mul__(self, other: Any) -> "SymbolMatrix":
        if not isinstance(other, SymbolMatrix):
            return SymbolMatrix(casadi.sparsify(self.m * _plain(other)))
        if not self.m.shape[1]:
            return SymbolMatrix(self.m.shape[0], other.m.shape[1])
        return SymbolMatrix(casadi.sparsify(self.m @ other.m))

    def __truediv__(self, other: Any) -> "SymbolMatrix":
        return SymbolMatrix(self.m / _plain(other))

    def __getitem__(self, place: Any) -> Symbol:
        return Symbol(self.m[place])

    def __setitem__(self, place: Any, value: Any) -> None:
        self.m[place] = _plain(value)

    def nrows(self) -> int:
        """Number of rows."""
        return int(self.m.shape[0])

    def ncols(self) -> int:
        """Number of columns."""
        return int(self.m.shape[1])

    def transpose(self) -> "SymbolMatrix":
        """The transpose."""
        return SymbolMatrix(self.m.T)

    def table(self) -> list[list[Symbol]]:
        """The rows."""
        n, m = self.m.shape
        rows = []
        for i in range(n):
            rows.append([Symbol(self.m[i, k]) for k in range(m)])
        return rows

    def entries(self) -> list[Symbol]:
        """The entries, row after row."""
        return list(itertools.chain.from_iterable(self.table()))

    def solve(self, right: "SymbolMatrix", /, *, algorithm: Literal["lu"]) -> "SymbolMatrix":
        """The solution X of A X = right by elimination in the order of the rows.

        This suits a positive definite A.

        Raises:
            ZeroDivisionError: a pivot is zero in every posture.
        """
        del algorithm
        A, X, n = casadi.SX(self.m), casadi.SX(right.m), self.m.shape[0]
        for k in range(n):
            if A[k, k].is_zero():
                raise ZeroDivisionError
            for i in range(k + 1, n):
                if not A[i, k].is_zero():
                    by = A[i, k] / A[k, k]
                    A[i, k:], X[i, :] = A[i, k:] - by * A[k, k:], X[i, :] - by * X[k, :]
        for k in range(n - 1, -1, -1):
            for i in range(k + 1, n):
                if not A[k, i].is_zero():
                    X[k, :] = X[k, :] - A[k, i] * X[i, :]
            X[k, :] = X[k, :] / A[k, k]
        return SymbolMatrix(casadi.sparsify(X))


SYMBOLS = Arithmetic(
    Symbol, SymbolMatrix, lambda M: SymbolMatrix(casadi.triu2symm(casadi.triu(M.m)))
)
"""The arithmetic of symbols."""


def densified(arrays: Iterable[Any]) -> casadi.SX:
    """The entries of arrays, one after another."""
    values: list[casadi.SX] = []
    for part in arrays:
        values += map(_expression, np.asarray(part, dtype=object).ravel())
    return casadi.densify(casadi.vertcat(*values))


def symbols_of(vector: casadi.SX) -> Numbers:
    """The entries of a vector as symbols."""
    symbols = np.empty(vector.shape[0], dtype=object)
    for k in range(vector.shape[0]):
        symbols[k] = Symbol(vector[k])
    return symbols
