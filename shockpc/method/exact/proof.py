"""The proof of Eq. 4 in one posture: enclosures of its results.

The precision is raised until every enclosure is narrow enough to be rounded to the nearest double.
Proven means: for the robot as loaded, the posture, and the rows that were found independent.
"""

import math
import threading
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, cast

import numpy as np
from flint import ctx

from shockpc.core.impulse import RowSpace
from shockpc.core.spatial import Array, freeze, read_only
from shockpc.method.equation import Posed
from shockpc.method.exact.arithmetic import SingularError
from shockpc.method.exact.balls import Balls, BallSolution, PrecisionError, radii, to_double
from shockpc.method.exact.kinematics import Data
from shockpc.text.errors import SolveError

T = TypeVar("T")

LEAST_BITS, MOST_BITS = 128, 8192
"""Precision to begin with, and at which a pivot that still may be zero is zero."""

LEAST_MOTION = 1e-200
"""Share of the fastest motion below which a body is proven to be at rest, and not how fast it
moves.
"""

NARROW = 2.0**-70
"""Width of an enclosure, as a share of the motion, with which it is rounded to doubles."""

PRECISION = threading.RLock()
"""Held while balls are computed: their precision is one setting of the whole process."""


class Proof:
    """Eq. 4 and the jumps of one posture in ball arithmetic, and what was proven of them.

    Its arrays cannot be written to.

    Args:
        posed: the system in its posture, and what is held.
        row_space: which of the rows are independent.

    Attributes:
        posed: the system in its posture, and what is held.
        row_space: which of the rows are independent.
        jumps: (nb, 6, 4) jump (Δω, Δv) of every body in body coordinates at its frame's origin, for
            strikes of 1 m/s along world x, y and z and for the motion before the impact [rad/s,
            m/s]; the doubles nearest to the exact ones.
        delta_qd: (nv, 4) jump of the joint velocities [rad/s, m/s].
        impulse: (nc, 4) impulse along every row, of the ground on the robot [N s].
        bounds: (nb,) proven error of the last column of the jumps relative to each body's motion,
            `LEAST_MOTION` at least [1].
        bits: precision at which they were proven.

    Raises:
        SingularError: no inertia resists a motion, or the rows depend on one another.
    """

    def __init__(self, posed: Posed, row_space: RowSpace) -> None:
        self.posed, self.row_space = posed, row_space
        freeze(row_space)
        self._bits, self._numbers = LEAST_BITS, None
        length = posed.system.robot.rotation_lengths
        self.jumps, self.bounds = map(
            read_only, self.read(lambda numbers: _jumps(numbers.jumps[0], length))
        )
        self.delta_qd = read_only(self.read(lambda numbers: round_velocities(numbers.delta_qd[0])))
        self.impulse = read_only(self.read(_impulse))
        self.bits = self._bits

    def numbers_of(self, solution: BallSolution) -> Any:
        """The argument that `read` passes to its function.

        The solution, or what a subclass computes from it.
        """
        return solution

    condition = math.inf
    """Estimated factor by which the inertia and the rows enlarge rounding, as in `Solution`;
    `enclosed` gives it.
    """

    _numbers: Any

    def __getstate__(self) -> dict[str, object]:
        return vars(self) | {"_numbers": None}

    def read(
        self,
        compute: Callable[..., T],
        *arguments: Any,
        size: Callable[[Any, Array], Any] | None = None,
    ) -> T:
        """The value of a function of the solution in balls, at the lowest sufficient precision.

        That is the lowest at which it raises no `PrecisionError` or `SingularError`.

        Args:
            compute: the function, of what `numbers_of` makes of the solution.
            arguments: its further ones.
            size: natural size of the values, of the numbers and the values; they are rounded to
                doubles relative to it, if given.

        Raises:
            SolveError: the number is not known closely enough at the highest precision.
            SingularError: a pivot may be zero there: no inertia resists a motion, or rows are
                dependent.
        """
        with PRECISION:
            while True:
                with ctx.workprec(self._bits):
                    try:
                        if self._numbers is None:
                            solution = BallSolution(self.posed, self.row_space)
                            self._numbers = self.numbers_of(solution)
                        values: Any = compute(self._numbers, *arguments)
                        if size is not None:
                            values = self._numbers.rounded(values, partial(size, self._numbers))
                        return cast(T, values)
                    except (PrecisionError, SingularError) as failure:
                        if self._bits >= MOST_BITS:
                            if isinstance(failure, SingularError):
                                raise
                            raise SolveError(
                                f"no verdict: {MOST_BITS} bits do not give a number of robot "
                                f'"{self.posed.system.robot.name}", because terms cancel: masses '
                                "and lengths lie too many orders of magnitude apart, or a chain is "
                                "too long"
                            ) from None
                self._bits *= 2
                self._numbers = None

    def with_other_data(self, compute: Callable[[BallSolution], T], posed: Posed, data: Data) -> T:
        """The value of a function of the solution with other data, at the precision of the proof.

        Args:
            compute: the function.
            posed: another posture.
            data: other numbers of the robot.

        Raises:
            PrecisionError: a ball is too wide.
            SingularError: there is no solution.
        """
        with PRECISION, ctx.workprec(self.bits):
            return compute(BallSolution(posed, self.row_space, data))


def _jumps(jumps: Balls, length: Array) -> tuple[Array, Array]:
    """The jumps of all bodies as doubles (nb, 6, 4), and the proven error of the last column.

    The error (nb,) is relative to the motion.
    """
    values = jumps.astype(float)
    radius = radii(jumps)
    size = motion(values, length)
    width = motion(radius, length)
    reference = np.maximum(size[:, 3], LEAST_MOTION * size[:, 3].max())
    largest = size.max(axis=1, keepdims=True)
    if np.any(width[:, 3] > NARROW * reference) or np.any(width > NARROW * largest):
        raise PrecisionError
    # What may be zero is zero; the rest is off by its rounding to a double at most.
    values[np.abs(values) <= radius] = 0.0
    lost = np.abs(values[..., 3]) * 2.0**-53 + 2.0 * radius[..., 3]
    error = motion(lost[..., None], length)[:, 0]
    return values, error / np.where(reference > 0.0, reference, 1.0)


def motion(jumps: Array, length: Array) -> Array:
    """Size (nb, k) of jumps (nb, 6, k) as speeds.

    The velocity of the frame's origin, and rotation times a length (nb,).
    """
    speeds = np.concatenate([jumps[:, :3] * length[:, None, None], jumps[:, 3:]], axis=1)
    # Unlike a sum of squares, hypot does not underflow.
    return np.asarray(np.hypot.reduce(speeds, axis=1))


def round_velocities(velocities: Balls) -> Array:
    """Joint velocities (nv, m) as doubles, each joint's relative to the joint's velocity.

    Raises:
        PrecisionError: a ball is too wide.
    """
    size = np.abs(velocities.astype(float))
    of_joint = size.max(axis=1, keepdims=True)
    floor = 1e-30 * size.max(initial=0.0)
    return to_double(velocities, np.maximum(of_joint, floor))


def _impulse(solution: BallSolution) -> Array:
    """The impulses (nc, m) of a solution as doubles, each relative to the largest.

    Raises:
        PrecisionError: a ball is too wide.
    """
    impulse = solution.impulse[0]
    return to_double(impulse, _size(impulse))


def _size(values: Balls) -> float:
    return float(np.abs(values.astype(float)).max(initial=0.0))
