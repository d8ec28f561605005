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
        shown = f"{file}: the xacro expression ${{{expression}}}"
        tree = _check(expression, shown)
        if tree is None or not any(isinstance(node, ast.Pow | ast.Mult) for node in ast.walk(tree)):
            return evaluate(expression, *names)
        names[0].update(_guards(shown))
        return evaluate(ast.unparse(ast.fix_missing_locations(_Guarded().visit(tree))), *names)

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
            raise _endless(shown)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and (_text(node.left) or _text(node.right)):
            raise _filling(shown)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "__" in node.value:
            raise _refused(shown, node.value)
    return tree


class _Guarded(ast.NodeTransformer):
    """Turns powers and products into calls that look at their values first: a property may hold any of them."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Replace a power or a product, inner ones first."""
        self.generic_visit(node)
        name = {ast.Pow: "guarded_power", ast.Mult: "guarded_product"}.get(type(node.op))
        return node if name is None else ast.Call(ast.Name(name, ast.Load()), [node.left, node.right], [])


def _guards(shown: str) -> dict[str, Callable[[Any, Any], Any]]:
    """The calls that stand for powers and products in an expression."""

    def power(base: Any, exponent: Any) -> Any:
        if abs(exponent) > 64:
            raise _endless(shown)
        return base**exponent

    def product(a: Any, b: Any) -> Any:
        for factor in (a, b):
            if isinstance(factor, str):
                raise RobotError(
                    f'{shown} multiplies by "{factor[:40]}", which is no number; correct the argument or property that holds it'
                )
            if isinstance(factor, list | tuple):
                raise _filling(shown)
        return a * b

    return {"guarded_power": power, "guarded_product": product}


def _endless(shown: str) -> RobotError:
    """The error for a power that might never end."""
    return RobotError(f"{shown} raises to a power that is not a plain number up to 64; it might never end, so it is not evaluated")


def _filling(shown: str) -> RobotError:
    """The error for a text that is repeated."""
    return RobotError(f"{shown} repeats a text, which might fill the memory; write it out")


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
