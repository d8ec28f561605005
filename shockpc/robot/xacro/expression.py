"""Expressions of xacro files: checked on their syntax tree, then evaluated by Python.

What is not listed here is refused. A name stands for what the caller's table holds. A dot becomes a
call of `_attribute`, which reads an entry of a dictionary of xacro or one of the methods listed
here, and no other attribute of any object. So no function can be called but these methods and those
in the table. Time and memory are limited by the process.
"""

import ast
import warnings
from typing import Any

_ALLOWED = (
    ast.Expression,
    *(ast.Constant, ast.Name, ast.List, ast.Tuple, ast.Dict),
    *(ast.UnaryOp, ast.unaryop, ast.BinOp, ast.operator, ast.BoolOp, ast.boolop),
    *(ast.Compare, ast.cmpop, ast.IfExp),
    *(ast.Subscript, ast.Slice, ast.Attribute, ast.Call, ast.keyword),
    *(ast.ListComp, ast.GeneratorExp, ast.comprehension),
    *(ast.Load, ast.Store),
)
_CONSTANTS = (int, float, complex, str, type(None))
_MAY_HOLD = (
    "may hold numbers, texts, lists, dictionaries, their entries, operators, comprehensions and "
    "calls of xacro's functions"
)

_METHODS = {
    str: "capitalize count endswith find index isalnum isalpha isdigit join lower lstrip partition "
    "removeprefix removesuffix replace rfind rpartition rsplit rstrip split startswith strip title "
    "upper zfill",
    tuple: "count index",
    list: "append copy count extend index insert pop remove reverse",
    dict: "copy get items keys pop update values",
}

_ATTRIBUTE = "attribute of"
"""The name of `_attribute` among the names of an expression, in which none has a blank."""


def evaluate(text: str, names: dict[str, Any]) -> Any:
    """The value of an expression, whose names the table explains.

    Args:
        text: the expression.
        names: the table, to which what evaluation needs is added.

    Raises:
        SyntaxError: something in it is refused.
        Exception: what Python raises.
    """
    with warnings.catch_warnings():
        # Of odd code, such as `1 is 1`, which would stand among the messages of the document.
        warnings.simplefilter("ignore")
        tree = _Checked().visit(ast.parse(text.strip(), "<expression>", "eval"))
        code = compile(ast.fix_missing_locations(tree), "<expression>", "eval")
    # As of a plain dictionary, because a table of xacro says that a name is defined again.
    dict.update(names, {"__builtins__": {}, _ATTRIBUTE: _attribute})
    return eval(code, names)


class _Checked(ast.NodeTransformer):
    """Makes a syntax tree one in which every dot is a call of `_attribute`."""

    def visit(self, node: ast.AST) -> Any:
        """The node, checked with all that it holds.

        Raises:
            SyntaxError: it is refused.
            NameError: a name is one of Python's own.
        """
        if isinstance(node, ast.Name) and node.id.startswith("__"):
            raise NameError(f"name '{node.id}' is not defined")
        if not isinstance(node, _ALLOWED) or _hides_something(node):
            shown = ast.unparse(node)[:80]
            raise SyntaxError(f"{shown} is not allowed: an expression {_MAY_HOLD}")
        return super().visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.Call:
        """The call that reads an attribute."""
        function = ast.Name(_ATTRIBUTE, ast.Load())
        return ast.Call(function, [self.visit(node.value), ast.Constant(node.attr)], [])


def _hides_something(node: ast.AST) -> bool:
    """True if a node that is allowed has what is not.

    That is bytes, an ellipsis, `**`, or a dot or an index as a variable of a comprehension.
    """
    if isinstance(node, ast.Constant):
        return not isinstance(node.value, _CONSTANTS)
    if isinstance(node, ast.Dict):
        return None in node.keys
    if isinstance(node, ast.Call):
        return any(keyword.arg is None for keyword in node.keywords)
    if isinstance(node, ast.Attribute | ast.Subscript):
        return not isinstance(node.ctx, ast.Load)
    return isinstance(node, ast.comprehension) and bool(node.is_async)


def _attribute(owner: Any, name: str) -> Any:
    """The value of a dot: a method that only computes, or an entry.

    The entry is one of a namespace or a YAML dictionary.
    """
    for kind, methods in _METHODS.items():
        if isinstance(owner, kind) and name in methods.split():
            return getattr(owner, name)
    entry = getattr(type(owner), "__getattr__", None)
    if isinstance(owner, dict) and entry is not None:
        return entry(owner, name)
    raise AttributeError(f"an expression cannot read .{name} of {type(owner).__name__}")
