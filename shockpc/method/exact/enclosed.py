"""Eq. 4 of one posture enclosed: which rows are independent, and the balls of that choice."""

from collections.abc import Callable, Iterator
from typing import TypeVar

from shockpc.core.impulse import RowChoice, Solution
from shockpc.method.equation import Equation, Posed
from shockpc.method.exact.arithmetic import SingularError
from shockpc.method.exact.proof import Proof

P = TypeVar("P", bound=Proof)


def enclosed(
    equation: Equation,
    posed: Posed,
    solution: Solution,
    most: Callable[[int], tuple[int, float]],
    made: Callable[[Posed, RowChoice], P],
) -> P | None:
    """The proof with the first choice of rows that balls find independent; None if there is none.

    Args:
        equation: Eq. 4 in the posture (N = 1).
        posed: the same, from which balls are evaluated.
        solution: of it in doubles.
        most: of the posture's number (0), how many rows can be independent, and the effect of
            rounding on the others.
        made: makes a proof; `Proof`, or a subclass.

    Raises:
        SingularError: no inertia resists a motion.
    """
    for choice in _choices(equation, solution, most):
        try:
            proof = made(posed, choice)
        except SingularError as singular:
            if singular.of_inertia:
                raise
            continue
        proof.condition = float(solution.condition[0])
        return proof
    return None


def _choices(
    equation: Equation, solution: Solution, most: Callable[[int], tuple[int, float]]
) -> Iterator[RowChoice]:
    """Choices of independent rows: that of the solution; or all, which are looked at more closely
    if balls find that they are not.
    """
    if solution.choices:
        yield solution.choices[0]
        return
    yield RowChoice.every(len(equation.b[0]))
    yield equation.row_choice(most(0), solution.scale[0])
