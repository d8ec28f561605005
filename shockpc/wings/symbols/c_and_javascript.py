"""A program as statements of C or JavaScript, cut into functions that compilers are quick with."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from shockpc.wings.symbols.programs import OPERATIONS, UNARY, Program

C = {
    "add": "{}+{}",
    "subtract": "{}-{}",
    "multiply": "{}*{}",
    "divide": "{}/{}",
    "maximum": "fmax({},{})",
    "minimum": "fmin({},{})",
    "less": "({}<{})",
    "less_equal": "({}<={})",
    "negative": "-{}",
    "reciprocal": "1.0/{}",
    "sqrt": "sqrt({})",
    "sin": "sin({})",
    "cos": "cos({})",
    "absolute": "fabs({})",
    "sign": "(({0}>0.0)-({0}<0.0))",
    "not": "({}==0.0)",
    "nan": "NAN",
    "inf": "INFINITY",
}
"""Operations, and the numbers that have no digits, as expressions of C99."""

JAVASCRIPT = C | {
    "maximum": "Math.max({},{})",
    "minimum": "Math.min({},{})",
    "less": "({}<{}?1:0)",
    "less_equal": "({}<={}?1:0)",
    "sqrt": "Math.sqrt({})",
    "sin": "Math.sin({})",
    "cos": "Math.cos({})",
    "absolute": "Math.abs({})",
    "sign": "Math.sign({})",
    "not": "({}===0?1:0)",
    "nan": "NaN",
    "inf": "Infinity",
}
"""Words of JavaScript."""


NAMES = tuple(OPERATIONS)
"""Names of operations by number."""


class StatementPieces(NamedTuple):
    """The statements of a program, in pieces.

    Attributes:
        bodies: the statements of each piece.
        slots: size of the workspace w, which holds what a later piece needs.
    """

    bodies: list[str]
    slots: int


def pieces(
    program: Program, inputs: Mapping[str, int], words: Mapping[str, str], declare: str, size: int
) -> StatementPieces:
    """The statements of a program that read its inputs and write `out`.

    Args:
        program: the program.
        inputs: sizes of the arrays that its inputs are in, by name, in their order.
        words: operations as expressions, `C` or `JAVASCRIPT`.
        declare: what stands before the name of a value, such as "const".
        size: operations in a piece: compilers take long over long functions, or do not compile
            them.
    """
    statements = _Statements(program, inputs, words, declare, size)
    starts = range(0, max(len(statements.operands), 1), size)
    bodies = ["\n".join(statements.of_piece(start)) for start in starts]
    return StatementPieces(bodies, len(statements.slots))


class _Statements:
    """The statements of a program with numbered values.

    Inputs and constants come first, then the results of operations.

    Args: as for `pieces`.

    Attributes:
        operands: of each operation.
        slots: places in the workspace of values that a later piece needs, by value.
    """

    def __init__(
        self,
        program: Program,
        inputs: Mapping[str, int],
        words: Mapping[str, str],
        declare: str,
        size: int,
    ) -> None:
        self.first = program.first
        self.operands = program.operands.tolist()
        self.operation = program.operation
        self.words = words
        self.declare = declare
        self.size = size
        self.texts: list[str] = []
        for name, n in inputs.items():
            self.texts += [f"{name}[{k}]" for k in range(n)]
        self.texts += [digits(x, words) for x in program.constants.tolist()]
        self.outputs: dict[int, list[int]] = {}
        for k, value in enumerate(program.outputs.tolist()):
            self.outputs.setdefault(value, []).append(k)
        self.slots: dict[int, int] = {}
        for k, values in enumerate(self.operands):
            for value in values:
                if not self._is_here(value, k // size):
                    self.slots.setdefault(value, len(self.slots))

    def _is_here(self, value: int, piece: int) -> bool:
        """True if a value is an input, a constant, or computed in a piece."""
        return value < self.first or (value - self.first) // self.size == piece

    def of_piece(self, start: int) -> list[str]:
        """The statements of the operations from one on."""
        lines: list[str] = []
        if start == 0:
            for value in self.outputs:
                if value < self.first:
                    lines += [f"out[{k}]={self.texts[value]};" for k in self.outputs[value]]
        read: set[int] = set()
        for k in range(start, min(start + self.size, len(self.operands))):
            lines += self._of_operation(k, read)
        return lines

    def _of_operation(self, k: int, read: set[int]) -> Iterator[str]:
        """The statements of an operation. Args: read, values that its piece has read from w."""
        arguments = self.operands[k]
        if self.operation[k] >= UNARY:
            arguments = arguments[:1]
        for value in arguments:
            if value not in read and not self._is_here(value, k // self.size):
                read.add(value)
                yield f"{self.declare} x{value - self.first}=w[{self.slots[value]}];"
        word = self.words[NAMES[self.operation[k]]]
        yield f"{self.declare} x{k}={word.format(*map(self._name, arguments))};"
        result = self.first + k
        if result in self.slots:
            yield f"w[{self.slots[result]}]=x{k};"
        for n in self.outputs.get(result, ()):
            yield f"out[{n}]=x{k};"

    def _name(self, value: int) -> str:
        """A value in an expression."""
        return self.texts[value] if value < self.first else f"x{value - self.first}"


def digits(value: float, words: Mapping[str, str]) -> str:
    """A number in code, with all of its digits. Args: words, as for `pieces`."""
    text = repr(abs(value))
    text = words.get(text, text)
    return f"(-{text})" if value < 0.0 else text
