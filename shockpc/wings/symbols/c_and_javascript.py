"""A program as statements of C or JavaScript, cut into functions that compilers are quick with."""

from collections.abc import Mapping
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
"""The same of JavaScript."""


class Pieces(NamedTuple):
    """The statements of a program, in pieces.

    Attributes:
        bodies: the statements of each piece.
        slots: size of the workspace w, which holds what a later piece needs.
    """

    bodies: list[str]
    slots: int


def pieces(
    program: Program, inputs: Mapping[str, int], words: Mapping[str, str], declare: str, size: int
) -> Pieces:
    """The statements of a program that read its inputs and write `out`.

    Args:
        program: the program.
        inputs: sizes of the arrays that its inputs are in, by name, in their order.
        words: operations as expressions, `C` or `JAVASCRIPT`.
        declare: what stands before the name of a value, such as "const".
        size: operations in a piece: compilers take long over long functions, or do not compile
            them.
    """
    texts = [f"{name}[{k}]" for name, n in inputs.items() for k in range(n)] + [
        digits(x, words) for x in program.constants.tolist()
    ]
    names, first, operands = list(OPERATIONS), program.first, program.operands.tolist()
    home = [-1] * first + [k // size for k in range(len(operands))]
    slots: dict[int, int] = {}
    for k, values in enumerate(operands):
        for value in values:
            if home[value] not in (-1, k // size):
                slots.setdefault(value, len(slots))
    wanted: dict[int, list[int]] = {}
    for k, value in enumerate(program.outputs.tolist()):
        wanted.setdefault(value, []).append(k)
    bodies = []
    for piece, start in enumerate(range(0, max(len(operands), 1), size)):
        lines, known = (
            [
                f"out[{k}]={texts[value]};"
                for value in wanted
                if home[value] < 0 and not piece
                for k in wanted[value]
            ],
            set(),
        )
        for k in range(start, min(start + size, len(operands))):
            arguments = operands[k][: 1 + (program.operation[k] < UNARY)]
            for value in arguments:
                if home[value] not in (-1, piece) and value not in known:
                    known.add(value)
                    lines.append(f"{declare} x{value - first}=w[{slots[value]}];")
            read = (texts[value] if value < first else f"x{value - first}" for value in arguments)
            lines.append(f"{declare} x{k}={words[names[program.operation[k]]].format(*read)};")
            value = first + k
            lines += [f"w[{slots[value]}]=x{k};"] if value in slots else []
            lines += [f"out[{n}]=x{k};" for n in wanted.get(value, ())]
        bodies.append("\n".join(lines))
    return Pieces(bodies, len(slots))


def digits(value: float, words: Mapping[str, str]) -> str:
    """A number in code, with all of its digits. Args: words, as for `pieces`."""
    text = repr(abs(value))
    text = words.get(text, text)
    return f"(-{text})" if value < 0.0 else text
