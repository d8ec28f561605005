"""Symbols (CasADi's expression graphs): an impact in them, for any posture.

The only importer of CasADi.

A symbol has no value. A formula that needs one, to compare it or to round it, cannot be written in
symbols: `NoValueError`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, reduce
from typing import Any, Literal, NoReturn, Self

import casadi
import numpy as np

from shockpc.core.impulse import RowSpace
from shockpc.core.percussion import norm
from shockpc.core.spatial import Array, cross
from shockpc.impact.exact_impact import ExactImpact
from shockpc.impact.impact import Impact
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import Motion
from shockpc.method.constraints import row_terms
from shockpc.method.exact.arithmetic import Arithmetic, NoValueError, Numbers, entries
from shockpc.method.exact.solution import ExactSolution
from shockpc.robot.robot import Robot
from shockpc.wings.symbols.programs import OPERATIONS, Program


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
        if len(shape) == 1:
            rows = shape[0]
            shape = (
                len(rows),
                len(rows[0]) if len(rows) else 0,
                [value for row in rows for value in row],
            )
        n, m, *values = shape
        self.m = casadi.SX(n, m)
        for k, value in enumerate(values[0] if values else ()):
            plain = _plain(value)
            if not (plain.is_zero() if isinstance(plain, casadi.SX) else plain == 0):
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
        return [[Symbol(self.m[i, k]) for k in range(m)] for i in range(n)]

    def entries(self) -> list[Symbol]:
        """The entries, row after row."""
        return [value for row in self.table() for value in row]

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


class SymbolSolution(ExactSolution):
    """Eq. 4 and the jumps in symbols, with the configuration in symbols.

    The arguments are those of `ExactSolution`.
    """

    arithmetic = SYMBOLS

    def set_motion(self, motion: Numbers) -> None:
        """Set the motion before the impact.

        Args: motion, symbols: the velocity of the base (3,), world axes, the rest as it is; or all
            joint velocities (nv,).
        """
        robot = self.posed.system.robot
        if len(motion) == 3:
            assert self.before is not None
            self.before = self.before._replace(velocity=motion)
        elif robot.free_base:
            turn = entries(self._placements[0][0])
            rates = np.concatenate([np.zeros(6), motion[6:]])
            self.before = Motion(turn @ motion[:3], turn @ motion[3:6], rates)
        else:
            self.before = Motion(np.zeros(3), np.zeros(3), motion)

    @cached_property
    def pivot(self) -> Symbol:
        """The smallest pivot of the Delassus matrix, scaled to a unit diagonal.

        It is 1 for orthogonal rows, 0 for dependent ones.
        """
        S = entries(self._by_rows[1])
        diagonal, pivots = np.diagonal(S).copy(), []
        for k in range(len(S)):
            pivots.append(S[k, k] / diagonal[k])
            S[k + 1 :, k + 1 :] = S[k + 1 :, k + 1 :] - S[k + 1 :, k, None] * (
                S[k, k + 1 :] / S[k, k]
            )
        return _least(pivots)

    @cached_property
    def condition(self) -> Symbol:
        """The factor by which rounding is enlarged in double precision [1].

        It is estimated as for `ShockMaps.condition`.

        It is that of the landing's strike alone, and a free base counts along the plane's axes, so
        it is not the same to the digit.
        """
        size, jump = self._sizes, entries(self._solution[0])[:, 3]
        light = _length(jump * size) / (_greatest(map(abs, jump)) * _least(size))
        found: Symbol = _length(self._stiff * size) / self.pivot * light.max(1.0)
        return found if self.posed.system.base == "free" else found * self._cancellation

    @cached_property
    def _responses(self) -> tuple[SymbolMatrix, Numbers]:
        """The first result of `_by_rows`, and the response (ny,) of an estimate.

        The norm of the inertia's inverse is estimated by it.
        """
        # In Pinocchio's order of the free velocities, whose last is the first here.
        signs = np.where(np.arange(len(self._sizes))[::-1] * 2654435761 % 7 < 4, 1.0, -1.0)
        J = self._rows[self.row_space.rows.tolist()]
        X = entries(
            self._by_inertia(self.arithmetic.matrix(np.column_stack([J.T, self._sizes * signs])))
        )
        return self.arithmetic.matrix(X[:, :-1]), X[:, -1]

    @cached_property
    def _by_rows(self) -> tuple[SymbolMatrix, SymbolMatrix]:
        """The matrices of `ExactSolution._by_rows`, in symbols."""
        X = self._responses[0]
        return X, self.arithmetic.symmetric(
            self.arithmetic.matrix(self._rows[self.row_space.rows.tolist()]) * X
        )

    @cached_property
    def _stiff(self) -> Numbers:
        return self._responses[1]

    @cached_property
    def _sizes(self) -> Numbers:
        """The square roots (ny,) of the inertias of the free velocities."""
        if self._mimics:
            return _roots(np.diagonal(entries(self._free_inertia)))
        # The diagonal of the joint-space inertia, by composite bodies, from the tips to the base.
        # With the column (ω, v) of a joint's motion at the base's origin, and the mass m, first
        # moment h and inertia I about it of all that the joint carries:
        # H_kk = armature + ωᵀ I ω + 2 ωᵀ (h × v) + m vᵀ v
        robot = self.posed.system.robot
        composite = self._moments_about_base()
        diagonal = self.own_inertia.copy()
        for i in range(len(composite) - 1, -1, -1):
            mass, h, inertia = composite[i]
            for k in range(robot.joints[i].v.start, robot.joints[i].v.stop):
                omega, v = self.state.J[0, :3, k], self.state.J[0, 3:, k]
                rotation = omega @ inertia @ omega
                coupling = 2 * (omega @ cross(h, v))
                diagonal[k] = diagonal[k] + rotation + coupling + (v @ v) * mass
            parent = robot.parents[i]
            if parent >= 0:
                pairs = zip(composite[parent], composite[i], strict=True)
                composite[parent] = [a + b for a, b in pairs]
        return _roots(diagonal[self._free])

    def _moments_about_base(self) -> list[list[Any]]:
        """Mass, first moment (3,) and inertia (3, 3) of each body about the base's origin."""
        moments_about_base: list[list[Any]] = []
        eye = self.exact(np.eye(3))
        for mass, (_, p), moments in zip(
            self._data.mass.tolist(), self._placements, self._moments, strict=True
        ):
            spatial, r = entries(moments), np.array(p.entries(), dtype=object)
            # The skew-symmetric part of the spatial inertia is that of h.
            h = np.array([spatial[2, 4], spatial[0, 5], spatial[1, 3]], dtype=object)
            # Steiner, r from the base's origin: h + m r, and
            # I + (m rᵀr + 2 rᵀh) 1 − m r rᵀ − r hᵀ − h rᵀ
            spherical = eye * (mass * (r @ r) + 2 * (r @ h))
            apart = spherical - np.outer(r, r) * mass - np.outer(r, h) - np.outer(h, r)
            inertia = spatial[:3, :3] + apart
            moments_about_base.append([self.arithmetic.number(mass), h + r * mass, inertia])
        return moments_about_base

    @cached_property
    def _cancellation(self) -> Symbol:
        """By how much terms cancel in the entries of the rows, as `Equation.cancellation` [1]."""
        terms = row_terms(self.state, self.posed.constraints)[0]
        for follower, leaders in reversed(self._mimics):
            for leader, by in leaders:
                terms[:, leader] = terms[:, leader] + terms[:, follower] * abs(by)
        return _greatest(norm(terms[:, self._free] / self._sizes) / norm(self._rows / self._sizes))


class SymbolImpact(ExactImpact):
    """An impact in symbols: posture and motion of its landing are symbols too."""

    solution: SymbolSolution
    has_values = False

    @classmethod
    def of(cls, landing: PosedLanding, q: casadi.SX, before: casadi.SX) -> Self:
        """The impact of a landing in whatever posture and motion.

        Args:
            landing: the landing; its posture is not used, and its motion not where the symbols say
                it.
            q: (nq,) symbols of the configuration.
            before: those of what is before the impact: the strike (3,), or all joint velocities
                (nv,).

        Raises:
            SingularError: no inertia resists a motion, or the rows depend on one another, in any
                posture.
        """
        rows = RowSpace.every(sum(block.size for block in landing.constraints))
        solution = SymbolSolution(landing.posed._replace(q=_symbols(q)), rows)
        solution.set_motion(_symbols(before))
        moving = replace(landing, q=solution.posed.q, before=solution.before or landing.before)
        return cls(solution, moving)

    @property
    def pivot(self) -> Symbol:
        """The value of `SymbolSolution`."""
        return self.solution.pivot

    @property
    def condition(self) -> Symbol:
        """The value of `SymbolSolution`."""
        return self.solution.condition

    def rounded(self, values: Numbers, size: Callable[[Array], Any]) -> Array:
        """Symbols have no values to be rounded.

        Raises:
            NoValueError: always.
        """
        raise NoValueError


def _roots(values: Numbers) -> Numbers:
    return np.array([value.sqrt() for value in values], dtype=object)


def _length(values: Numbers) -> Any:
    return norm(values).item()


def _greatest(values: Iterable[Symbol]) -> Symbol:
    return reduce(Symbol.max, values)


def _least(values: Iterable[Symbol]) -> Symbol:
    return -_greatest(-value for value in values)


def tangent(robot: Robot, q: casadi.SX) -> casadi.SX:
    """The derivatives (nq, nv) of a configuration by its tangent, Pinocchio's layout.

    Args: q (nq,).
    """
    T = casadi.SX(robot.model.nq, robot.model.nv)
    for joint in robot.single_joints:
        at, v = q[joint.q], joint.v
        if joint.kind in ("revolute", "prismatic"):
            T[joint.q.start, v.start] = 1.0
            continue
        if joint.kind == "continuous":
            T[joint.q, v] = casadi.vertcat(-at[1], at[0])
            continue
        if joint.kind == "planar":
            x, y = at[2], at[3]
            T[joint.q, v] = casadi.blockcat([[x, -y, 0], [y, x, 0], [0, 0, -y], [0, 0, x]])
            continue
        x, y, z, w = casadi.vertsplit(at[-4:])
        turns = slice(v.stop - 3, v.stop)
        T[joint.q.stop - 4 : joint.q.stop, turns] = (
            casadi.blockcat([[w, -z, y], [z, w, -x], [-y, x, w], [-x, -y, -z]]) / 2
        )
        if joint.kind == "free":
            T[joint.q.start : joint.q.start + 3, v.start : v.start + 3] = SYMBOLS.rotation(
                [x, y, z, w]
            ).m
    return T


def _symbols(vector: casadi.SX) -> Numbers:
    out = np.empty(vector.shape[0], dtype=object)
    out[:] = [Symbol(vector[k]) for k in range(vector.shape[0])]
    return out


def traced(
    landing: PosedLanding, given: int, formulas: Callable[[Impact], list[Any]]
) -> tuple[casadi.SX, casadi.SX, casadi.SX]:
    """Symbols of the configuration (nq,) and of the motion before (given,), and the results (m,).

    The results are those of the formulas.

    Raises:
        SingularError, NoValueError: as for `SymbolImpact`; a formula compares or rounds numbers.
    """
    q, before = casadi.SX.sym("q", landing.robot.model.nq), casadi.SX.sym("before", given)
    return q, before, _densified(formulas(SymbolImpact.of(landing, q, before)))


def program(n: int, formulas: Callable[[Numbers], Iterable[Any]]) -> Program:
    """The steps that arrays of formulas take of n numbers. Raises: as `traced`."""
    x = casadi.SX.sym("x", n)
    return compiled([x], _densified(formulas(_symbols(x))))[0]


def _densified(arrays: Iterable[Any]) -> casadi.SX:
    """The entries of arrays, one after another."""
    found = [value for part in arrays for value in np.asarray(part, dtype=object).ravel()]
    return casadi.densify(casadi.vertcat(*map(_expression, found)))


def with_slopes(y: casadi.SX, q: casadi.SX, before: casadi.SX, robot: Robot) -> casadi.SX:
    """Numbers (m,), then their derivatives (m, nv + given), row after row.

    They are by the tangent of q and by the motion before the impact.
    """
    slopes = casadi.horzcat(casadi.jacobian(y, q) @ tangent(robot, q), casadi.jacobian(y, before))
    return casadi.densify(casadi.vertcat(y, casadi.vec(slopes.T)))


NAMES = {
    casadi.OP_ADD: "add",
    casadi.OP_SUB: "subtract",
    casadi.OP_MUL: "multiply",
    casadi.OP_DIV: "divide",
    casadi.OP_FMAX: "maximum",
    casadi.OP_FMIN: "minimum",
    casadi.OP_LT: "less",
    casadi.OP_LE: "less_equal",
    casadi.OP_NEG: "negative",
    casadi.OP_INV: "reciprocal",
    casadi.OP_SQRT: "sqrt",
    casadi.OP_SIN: "sin",
    casadi.OP_COS: "cos",
    casadi.OP_FABS: "absolute",
    casadi.OP_SIGN: "sign",
    casadi.OP_NOT: "not",
    casadi.OP_SQ: "multiply",
    casadi.OP_TWICE: "add",  # of a value with itself
}
"""Operations of a program by CasADi's numbers."""


def compiled(inputs: Sequence[casadi.SX], outputs: casadi.SX) -> tuple[Program, str]:
    """The steps from vectors of inputs to one of outputs, and the text of their function.

    The inputs follow one another, and each expression is computed once.
    """
    function = casadi.Function("landing", [casadi.vertcat(*inputs)], [outputs], {"cse": True})
    return program_of(function), function.serialize()


def program_of(function: casadi.Function) -> Program:
    """The steps of a function of one vector."""
    numbers = {name: k for k, name in enumerate(OPERATIONS)}
    n = function.numel_in(0)
    steps = [
        (function.instruction_id(k), function.instruction_output(k), function.instruction_input(k))
        for k in range(function.n_instructions())
    ]
    # By their digits, because NaN is not equal to itself.
    texts = [
        float(function.instruction_constant(k)).hex()
        for k, (operation, *_) in enumerate(steps)
        if operation == casadi.OP_CONST
    ]
    constants = {text: n + k for k, text in enumerate(dict.fromkeys(texts))}

    # CasADi writes its registers again and again; each value of a program has a number of its own:
    # inputs first, then constants, then results of operations.
    unread = iter(texts)
    register: dict[int, int] = {}
    operations: list[int] = []
    operands: list[tuple[int, int]] = []
    results = [0] * function.numel_out(0)
    for operation, to, of in steps:
        if operation == casadi.OP_CONST:
            register[to[0]] = constants[next(unread)]
        elif operation == casadi.OP_INPUT:
            register[to[0]] = of[1]
        elif operation == casadi.OP_OUTPUT:
            results[to[1]] = register[of[0]]
        else:
            operands.append((register[of[0]], register[of[-1]]))
            register[to[0]] = n + len(constants) + len(operations)
            operations.append(numbers[NAMES[operation]])
    return Program(
        n,
        np.array([float.fromhex(text) for text in constants], dtype=float),
        np.array(operations, dtype=np.uint8),
        np.array(operands, dtype=np.int32).reshape(-1, 2),
        np.array(results, dtype=np.int32),
    )


def function_from(text: str) -> Callable[[Array], Any]:
    """The function of which this is the text, of arrays (n, N) with N columns."""
    function = casadi.Function.deserialize(text)
    return lambda columns: function(columns).full()


def function_of(
    text: str, inputs: Mapping[str, int], outputs: Mapping[str, slice]
) -> casadi.Function:
    """A function by its text.

    Args: inputs, sizes of the vectors that its input is made of; outputs, places among its outputs.
    """
    vectors = [casadi.SX.sym(name, size) for name, size in inputs.items()]
    rows = casadi.Function.deserialize(text)(casadi.vertcat(*vectors))
    return casadi.Function(
        "landing", vectors, [rows[part] for part in outputs.values()], [*inputs], [*outputs]
    )
