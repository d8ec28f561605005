"""Eq. 4 of one posture enclosed: which rows are independent, and the balls with these."""

from collections.abc import Callable, Iterator
from typing import TypeVar

from shockpc.core.impulse import RowLimits, RowSpace, Solution
from shockpc.method.equation import Equation, Posed
from shockpc.method.exact.arithmetic import SingularError
from shockpc.method.exact.proof import Proof

P = TypeVar("P", bound=Proof)


def enclosed(
    equation: Equation,
    posed: Posed,
    solution: Solution,
    limits: RowLimits,
    prove: Callable[[Posed, RowSpace], P],
) -> P | None:
    """The proof with the first rows that balls find independent; None if there are none.

    Args:
        equation: Eq. 4 in the posture (N = 1).
        posed: the same, from which balls are evaluated.
        solution: of it in doubles.
        limits: of the rows in each posture, of which there is one.
        prove: makes a proof; `Proof`, or a subclass.

    Raises:
        SingularError: no inertia resists a motion.
    """
    for row_space in _row_spaces(equation, solution, limits):
        try:
            proof = prove(posed, row_space)
        except SingularError as singular:
            if singular.of_inertia:
                raise
            continue
        proof.condition = float(solution.condition[0])
        return proof
    return None


def _row_spaces(equation: Equation, solution: Solution, limits: RowLimits) -> Iterator[RowSpace]:
    """Row spaces to be tried: that of the solution, or else all rows.

    If balls find that all rows are dependent, the next is that of their singular values.
    """
    if solution.row_spaces:
        yield solution.row_spaces[0]
        return
    yield RowSpace.every(len(equation.b[0]))
    yield equation.row_space(limits(0), solution.scale[0])
