"""Expressions of xacro files, evaluated by walking over their syntax: nothing is compiled, and what
is not listed here is refused.

A name stands for what the caller's table holds. A dot reads an entry of a dictionary of xacro or
one of the methods listed here, and no other attribute of any object; so no function can be called
but these methods and those in the table.
"""

import ast
import operator
from collections import ChainMap
from collections.abc import Mapping
from typing import Any

LARGEST = 10**6
"""Bits of a power, characters of a text, items of a list or a range."""
_OPERATORS: dict[type[ast.AST], Any] = {
    **{
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: operator.truediv,
        ast.Mod: operator.mod,
    },
    **{
        ast.FloorDiv: operator.floordiv,
        ast.Pow: operator.pow,
        ast.LShift: operator.lshift,
        ast.RShift: operator.rshift,
    },
    **{
        ast.BitAnd: operator.and_,
        ast.BitOr: operator.or_,
        ast.BitXor: operator.xor,
        ast.Invert: operator.invert,
    },
    **{
        ast.UAdd: operator.pos,
        ast.USub: operator.neg,
        ast.Not: operator.not_,
        ast.Is: operator.is_,
        ast.IsNot: operator.is_not,
    },
    **{
        ast.Eq: operator.eq,
        ast.NotEq: operator.ne,
        ast.Lt: operator.lt,
        ast.LtE: operator.le,
        ast.Gt: operator.gt,
    },
    **{
        ast.GtE: operator.ge,
        ast.In: lambda item, items: item in items,
        ast.NotIn: lambda item, items: item not in items,
    },
}
_METHODS = {
    str: "capitalize count endswith find index isalnum isalpha isdigit join lower lstrip partition removeprefix removesuffix "
    "replace rfind rpartition rsplit rstrip split startswith strip title upper zfill",
    tuple: "count index",
    list: "append copy count extend index insert pop remove reverse",
    dict: "copy get items keys pop update values",
}


def evaluate(text: str, names: Mapping[str, Any]) -> Any:
    """The value of an expression, whose names the table explains; raises what Python would, and
    SyntaxError for what is refused.
    """
    return _value(ast.parse(text.strip(), "<expression>", "eval").body, names)


def _value(node: ast.AST, names: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=int() | float() | complex() | str() | None as value):
            return value
        case ast.Name(id=name):
            try:
                return names[name]
            except KeyError:
                raise NameError(f"name '{name}' is not defined") from None
        case ast.List(elts=parts):
            return [_value(part, names) for part in parts]
        case ast.Tuple(elts=parts):
            return tuple(_value(part, names) for part in parts)
        case ast.Dict(keys=keys, values=parts) if None not in keys:
            return {
                _value(key, names): _value(part, names)
                for key, part in zip(keys, parts, strict=True)
                if key
            }
        case ast.UnaryOp(op=operation, operand=first):
            return _OPERATORS[type(operation)](_value(first, names))
        case ast.BinOp(left=first, op=operation, right=second):
            left, right = _value(first, names), _value(second, names)
            _check_size(operation, left, right)
            return _OPERATORS[type(operation)](left, right)
        case ast.BoolOp(op=operation, values=parts):
            for part in parts:
                if bool(value := _value(part, names)) is isinstance(operation, ast.Or):
                    break
            return value
        case ast.Compare(left=first, ops=comparisons, comparators=parts):
            left, value = _value(first, names), True
            for comparison, part in zip(comparisons, parts, strict=True):
                if value:
                    right = _value(part, names)
                    left, value = right, _OPERATORS[type(comparison)](left, right)
            return value
        case ast.IfExp(test=test, body=first, orelse=second):
            return _value(first if _value(test, names) else second, names)
        case ast.Subscript(value=first, slice=second):
            owner, key = _value(first, names), _value(second, names)
            if not isinstance(owner, (str, list, tuple, dict, range)):
                raise TypeError(
                    f"{type(owner).__name__} has no entries, so there is no [{str(key)[:80]}]"
                )
            return owner[key]
        case ast.Slice(lower=first, upper=second, step=third):
            return slice(*(part and _value(part, names) for part in (first, second, third)))
        case ast.Attribute(value=first, attr=name):
            return _attribute(_value(first, names), name)
        case ast.Call(func=first, args=parts, keywords=keywords) if all(
            keyword.arg for keyword in keywords
        ):
            function, values = _value(first, names), [_value(part, names) for part in parts]
            result = function(
                *values, **{str(keyword.arg): _value(keyword.value, names) for keyword in keywords}
            )
            _check_size(None, result, 1)
            return result
        case (
            ast.ListComp(elt=first, generators=loops)
            | ast.GeneratorExp(elt=first, generators=loops)
        ):
            return _comprehension(first, loops, names)
    may = "may hold numbers, texts, lists, dictionaries, their entries, operators, comprehensions and calls of xacro's functions"
    raise SyntaxError(f"{ast.unparse(node)[:80]} is not allowed: an expression {may}")


def _attribute(owner: Any, name: str) -> Any:
    """What a dot gives: a method that only computes, or an entry of a namespace or a YAML
    dictionary.
    """
    if any(
        isinstance(owner, kind) and name in methods.split() for kind, methods in _METHODS.items()
    ):
        return getattr(owner, name)
    entry = getattr(type(owner), "__getattr__", None) if isinstance(owner, dict) else None
    if entry:
        return entry(owner, name)
    raise AttributeError(f"an expression cannot read .{name} of {type(owner).__name__}")


def _comprehension(
    element: ast.AST, loops: list[ast.comprehension], names: Mapping[str, Any]
) -> list[Any]:
    """The values of an element within loops, the outermost first."""
    if not loops:
        return [_value(element, names)]
    values: list[Any] = []
    for item in _value(loops[0].iter, names):
        match loops[0].target:
            case ast.Name(id=name):
                variables = {name: item}
            case ast.Tuple(elts=targets):
                variables = dict(
                    zip([ast.unparse(target) for target in targets], item, strict=True)
                )
            case target:
                raise SyntaxError(
                    f"{ast.unparse(target)} is not allowed as a variable of a comprehension"
                )
        inner = ChainMap(variables, names)  # type: ignore[arg-type]
        if all(_value(test, inner) for test in loops[0].ifs):
            values += _comprehension(element, loops[1:], inner)
            _check_size(None, values, 1)
    return values


def _check_size(operation: ast.AST | None, left: Any, right: Any) -> None:
    """Refuse a result that would take all time and memory; without an operation, a value that does."""
    match operation, left, right:
        case ast.Pow(), int(), int():
            size = left.bit_length() * right
        case ast.LShift(), int(), int():
            size = left.bit_length() + right
        case (ast.Mult() | None, str() | list() | tuple() | dict() | range(), int()):
            size = len(left) * right
        case ast.Mult(), int(), str() | list() | tuple():
            size = left * len(right)
        case _:
            return
    if size > LARGEST:
        raise OverflowError(
            f"more than {LARGEST} bits, characters or items; look for what grows without end"
        )
