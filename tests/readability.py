"""How hard the code of the package is to read once, and the functions to begin with.

python tests/readability.py [N]      # N functions are listed, ten unless given

Heavy steps have more than six operations: calls, operators, comparisons and subscripts; a
comprehension, a conditional expression and an assignment within an expression count twice. The
elements of a display are steps of their own. Heavy comprehensions have two sources, two conditions,
or another comprehension or a conditional expression in them. Functions are listed by their size
times the names that are in use at once.
"""

import ast
import sys
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[1] / "shockpc"
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
TWICE = (*COMPREHENSIONS, ast.IfExp, ast.NamedExpr)
ONCE = (ast.Call, ast.BinOp, ast.UnaryOp, ast.Compare, ast.BoolOp, ast.Subscript, ast.Lambda)
DISPLAYS = (ast.List, ast.Set, ast.Dict)
MOST_OPERATIONS, LARGE = 6, 200


class Function(NamedTuple):
    """A function and what was counted in it."""

    place: str
    size: int
    names: int
    heavy_steps: int
    heavy_comprehensions: int
    comments: int


def operations(node):
    """The operations of an expression."""
    own = 2 * isinstance(node, TWICE) + isinstance(node, ONCE)
    children = [child for child in ast.iter_child_nodes(node) if not isinstance(child, ast.stmt)]
    return own + sum(map(operations, children))


def steps(statement):
    """The operations of each step of a statement, without the statements in it."""
    parts = [part for part in ast.iter_child_nodes(statement) if isinstance(part, ast.expr)]
    found = []
    while parts:
        part = parts.pop()
        if isinstance(part, DISPLAYS):
            parts += [child for child in ast.iter_child_nodes(part) if isinstance(child, ast.expr)]
        else:
            found.append(operations(part))
    return found or [0]


def is_heavy(node):
    """Whether a comprehension is hard to read once."""
    if not isinstance(node, COMPREHENSIONS):
        return False
    conditions = sum(len(source.ifs) for source in node.generators)
    nested = any(isinstance(part, TWICE) for part in ast.walk(node) if part is not node)
    return len(node.generators) > 1 or conditions > 1 or nested


def names_in_use(function):
    """The largest number of local names that have a value which is still used."""
    first, last = {}, {}
    for node in ast.walk(function):
        if isinstance(node, ast.arg):
            first.setdefault(node.arg, node.lineno)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            first[node.id] = min(first.get(node.id, node.lineno), node.lineno)
    for node in ast.walk(function):
        if isinstance(node, ast.Name) and node.id in first:
            last[node.id] = max(last.get(node.id, 0), node.lineno)
    lines = range(function.lineno, function.end_lineno + 1)
    return max(sum(first[name] <= line <= last[name] for name in last) for line in lines)


def functions_of(path):
    """The functions of a file."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.FunctionDef):
            continue
        inside = [part for statement in node.body for part in ast.walk(statement)]
        statements = [part for part in inside if isinstance(part, ast.stmt)]
        body = lines[node.lineno - 1 : node.end_lineno]
        yield Function(
            place=f"{path.relative_to(PACKAGE.parent)}:{node.lineno} {node.name}",
            size=sum(isinstance(part, ast.expr) for part in inside),
            names=names_in_use(node),
            heavy_steps=sum(max(steps(one)) > MOST_OPERATIONS for one in statements),
            heavy_comprehensions=sum(map(is_heavy, inside)),
            comments=sum("# " in line for line in body),
        )


def main(listed):
    """Print the figures and the first functions."""
    functions = [one for path in sorted(PACKAGE.rglob("*.py")) for one in functions_of(path)]
    large = [one for one in functions if one.size > LARGE]
    silent = [one for one in large if not one.comments]
    print(
        f"readability: {sum(one.heavy_steps for one in functions)} heavy steps, "
        f"{sum(one.heavy_comprehensions for one in functions)} heavy comprehensions; of "
        f"{len(large)} large functions {len(silent)} have no comment"
    )
    print("size, names in use, heavy steps, heavy comprehensions, comments of the first functions")
    functions.sort(key=lambda one: one.size * one.names, reverse=True)
    for one in functions[:listed]:
        numbers = (one.size, one.names, one.heavy_steps, one.heavy_comprehensions, one.comments)
        print("".join(f"{number:5d}" for number in numbers), "", one.place)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
