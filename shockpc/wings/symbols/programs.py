"""Straight-line arithmetic as a list of steps, which NumPy runs for many rows at once."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, NamedTuple, Self

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.spatial import Array

OPERATIONS = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "maximum": np.fmax,
    "minimum": np.fmin,
    "less": np.less,
    "less_equal": np.less_equal,
    "negative": np.negative,
    "reciprocal": np.reciprocal,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "absolute": np.absolute,
    "sign": np.sign,
    "not": np.logical_not,
}
"""The operations by name; those from "negative" on have one operand. Comparisons are 1 or 0."""

UNARY = list(OPERATIONS).index("negative")
"""Number of the first operation with one operand."""

BLOCK = 2048
"""Rows that are computed together.

More leave the processor's cache; fewer cost more calls of NumPy for each row.
"""


class Plan(NamedTuple):
    """The steps of a program with registers.

    A later value takes the register of one that nobody reads again.

    Attributes:
        registers: how many the results of steps need, beside those of inputs and constants.
        steps: function, places of its operands, and place of its result: inputs and constants by
            their numbers, then registers.
        outputs: places of the results.
    """

    registers: int
    steps: list[tuple[Callable[..., Any], tuple[int, ...]]]
    outputs: list[int]


@frozen()
class Program:
    """Steps that compute numbers of numbers.

    Values are numbered: the inputs, then the constants, then the result of each step.

    Attributes:
        inputs: number of inputs.
        constants: (c,) values that do not change.
        operation: (n,) of each step, its place in `OPERATIONS`.
        operands: (n, 2) numbers of the values that it takes; twice the same where it takes one.
        outputs: (m,) numbers of the values that are the result.
    """

    inputs: int
    constants: Array
    operation: np.ndarray
    operands: np.ndarray
    outputs: np.ndarray

    @property
    def first(self) -> int:
        """Number of the first step's result."""
        return self.inputs + len(self.constants)

    def __call__(self, X: Array) -> Array:
        """The results (N, m) of N rows of inputs (N, inputs).

        Memory beside the result does not grow with N.
        """
        n = len(X)
        plan = self._plan
        size = min(BLOCK, n)
        out = np.empty((n, len(self.outputs)))
        read = np.empty((self.inputs, size))
        registers = np.empty((plan.registers, size))
        # A single number is repeated by NumPy, which leaves the cache to what differs between rows.
        rows = [*read, *self.constants[:, None], *registers]
        steps = []
        for function, places in plan.steps:
            steps.append((function, [rows[place] for place in places]))
        results = [rows[place] for place in plan.outputs]
        with np.errstate(all="ignore"):
            for k in range(0, n, BLOCK):
                part = X[k : k + BLOCK]
                read[:, : len(part)] = part.T
                for function, operands in steps:
                    function(*operands)
                for column, row in zip(out[k : k + BLOCK].T, results, strict=True):
                    column[:] = row[: len(part)] if len(row) == size else row
        return out

    def arrays(self) -> dict[str, np.ndarray]:
        """Its attributes as arrays."""
        return {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """The program of which these are `arrays`, among others."""
        return cls(int(arrays["inputs"]), *(arrays[field.name] for field in fields(cls)[1:]))

    @functools.cached_property
    def _plan(self) -> Plan:
        # The last step that reads each value; inputs, constants and outputs are kept to the end.
        first, m = self.first, len(self.operation)
        last = np.full(first + m, -1)
        last[self.operands] = np.arange(m)[:, None]  # of several readers the last
        last[self.outputs] = m
        last[:first] = m
        ends = last.tolist()

        functions = list(OPERATIONS.values())
        unused: list[int] = []
        steps = []
        end = first
        places = list(range(first))
        coded = zip(self.operation.tolist(), self.operands.tolist(), strict=True)
        for k, (operation, (a, b)) in enumerate(coded):
            operands = (places[a],) if operation >= UNARY else (places[a], places[b])
            # An entry is written after those of the operands are read, so that a result may take
            # the place of one.
            unused += [places[value] for value in {a, b} if ends[value] == k]
            end += not unused
            places.append(unused.pop() if unused else end - 1)
            steps.append((functions[operation], (*operands, places[-1])))
        return Plan(end - first, steps, [places[value] for value in self.outputs.tolist()])
