"""Which Python a xacro file may hold: arithmetic and lookups, nothing that leads to files, modules or the interpreter.

xacro evaluates `${…}` and `$(eval …)` as Python. Its own precautions can be walked around (a comprehension hides names from
them, and `$(eval …)` still sees every builtin), so each expression is read as a syntax tree first.
"""

import ast
import builtins
from collections.abc import Callable
from typing import Any

from shockpc.errors import RobotError

__all__ = ["checked_expression", "checked_substitution"]

# Attributes without an underscore that lead to frames, code and classes all the same.
_INSIDES = frozenset(
    {"gi_frame", "gi_code", "gi_yieldfrom", "cr_frame", "cr_code", "cr_await", "ag_frame", "ag_code", "mro", "format_map"}
    | {"f_back", "f_builtins", "f_code", "f_globals", "f_locals", "tb_frame", "tb_next"}
)
# What $(eval …) documents, of all the builtins that Python would hand to it.
_BUILTINS = frozenset({"abs", "bool", "dict", "float", "int", "len", "list", "map", "max", "min", "pow", "round", "str", "sum"})


def checked_expression(evaluate: Callable[..., Any], file: str) -> Callable[..., Any]:
    """Wrap xacro's evaluation of `${…}` so that an unsafe expression raises RobotError instead.

    Args:
        evaluate: xacro's own function of the expression and the names it may use.
        file: the robot file's name, for messages.
    """

    def checked(expression: str, *names: Any) -> Any:
        _check(expression, f"{file}: the xacro expression ${{{expression}}}")
        return evaluate(expression, *names)

    return checked


def checked_substitution(evaluate: Callable[..., Any], file: str) -> Callable[..., Any]:
    """Wrap xacro's evaluation of `$(eval …)` likewise; of the builtins only the harmless ones may be named."""

    def checked(expression: str, context: Any) -> Any:
        shown = f"{file}: the xacro expression $(eval {expression})"
        tree = _check(expression, shown)
        for node in ast.walk(tree) if tree else ():
            if isinstance(node, ast.Name) and hasattr(builtins, node.id) and node.id not in _BUILTINS:
                raise _refused(shown, node.id)
        return evaluate(expression, context)

    return checked


def _check(expression: str, shown: str) -> ast.AST | None:
    """Refuse an expression that names the insides of Python; None if it is not Python at all, which xacro will say."""
    try:
        tree = ast.parse(expression.strip(), mode="eval")
    except SyntaxError:
        return None
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and (node.attr.startswith("_") or node.attr in _INSIDES):
            raise _refused(shown, node.attr)
        if isinstance(node, ast.Name) and node.id.startswith("__"):
            raise _refused(shown, node.id)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not _small(node.right):
            raise RobotError(
                f"{shown} raises to a power that is not a plain number up to 64; it might never end, so it is not evaluated"
            )
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and (_text(node.left) or _text(node.right)):
            raise RobotError(f"{shown} repeats a text, which might fill the memory; write it out")
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "__" in node.value:
            raise _refused(shown, node.value)
    return tree


def _small(node: ast.AST) -> bool:
    """Whether an exponent is a plain number up to 64, or a name, which xacro gives a plain number."""
    if isinstance(node, ast.UnaryOp):
        node = node.operand
    return isinstance(node, ast.Name) or (
        isinstance(node, ast.Constant) and isinstance(node.value, int | float) and abs(node.value) <= 64
    )


def _text(node: ast.AST) -> bool:
    """Whether a factor is a text or a list written out."""
    return isinstance(node, ast.List | ast.Tuple) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _refused(shown: str, name: str) -> RobotError:
    """The error for an expression that reaches too far."""
    return RobotError(f'{shown} uses "{name}", which could reach files or programs; it is not evaluated')
