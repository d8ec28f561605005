"""xacro to URDF, without ROS, and without reaching beyond the open folders.

xacro keeps its state in module globals, opens whatever a file names, and evaluates Python found in it. All three are fenced
in here for the length of one call: the globals are set and put back, every file goes through `Reach`, every expression
through `expressions`.
"""

import contextlib
import difflib
import errno
import io
import os
import re
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from xml.dom import DOMException
from xml.etree.ElementTree import Element
from xml.parsers.expat import ExpatError

from shockpc.errors import RobotError
from shockpc.robot.expressions import checked_expression, checked_substitution
from shockpc.robot.markup import Markup, parse_markup, read_text
from shockpc.robot.reach import Reach

__all__ = ["expand_xacro"]

_LOCK = threading.RLock()  # xacro's globals and the standard streams are the whole process's


def expand_xacro(markup: Markup, reach: Reach, arguments: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Expand a xacro file.

    Args:
        markup: the file as read.
        reach: what it may read; `reach.file` is the file itself.
        arguments: values of its arguments.

    Returns:
        The URDF text, with mesh paths as found, and what xacro warned of.

    Raises:
        RobotError: an argument is unknown or lacks a value, a file it includes is missing, not well-formed or outside the
            open folders, or xacro cannot expand it.
    """
    import xacro
    import xacrodoc

    name = reach.file.name
    declared = set(_arguments(markup.text, markup.root))
    said = io.StringIO()
    failures = (
        xacro.XacroException,
        *(ArithmeticError, AssertionError, AttributeError, LookupError, NameError, OSError, RecursionError),
        *(SyntaxError, TypeError, ValueError, ExpatError, DOMException),
    )
    with _LOCK, _fence(xacro, reach, declared), contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        try:
            document = xacrodoc.XacroDoc.from_string(markup.text, subargs=dict(arguments), resolve_packages=False).dom
            text = str(document.documentElement.toxml())
        except failures as error:
            raise _explained(error, name, xacro) from None
    for argument in arguments:
        if argument not in declared:
            raise _unknown_argument(argument, declared, name)
    # Each of xacro's passes says the same again; the lines about where it happened mean nothing without the file at hand.
    place = ("when ", "in file:", "included from:", "instantiated from:")
    warnings = dict.fromkeys(line for line in said.getvalue().splitlines() if line.strip() and not line.startswith(place))
    return text, tuple(f"{name}: xacro: {line.removeprefix('warning: ')}" for line in warnings)


@contextlib.contextmanager
def _fence(xacro: ModuleType, reach: Reach, declared: set[str]) -> Iterator[None]:
    """Put this call's reach, file and rules into xacro's globals, and take them out again."""
    from xacro import substitution_args

    def open_inside(filename: str, *_: object, **__: object) -> io.StringIO:
        place = reach.require(Path(filename), filename)
        if not os.path.exists(place):
            raise FileNotFoundError(errno.ENOENT, "no such file", filename)
        text = read_text(place)
        if text.lstrip().startswith("<"):
            declared.update(_arguments(text, parse_markup(text, place.name)))
        return io.StringIO(text)

    def find(package: str) -> str:
        folder = reach.package(package)
        if folder is None:
            raise RobotError(
                f'{reach.file.name}: $(find {package}): no package "{package}" among those given, in ROS_PACKAGE_PATH or '
                f"above the file. Say where it is: --package {package}=DIR"
            )
        return str(folder)

    python = xacro._global_symbols["python"]
    swaps: list[tuple[dict[str, object], dict[str, object]]] = [
        (
            vars(xacro),
            {
                "open": open_inside,
                "safe_eval": checked_expression(xacro.safe_eval, reach.file.name),
                "filestack": [str(reach.file)],
                "macrostack": [],
            },
        ),
        (
            vars(substitution_args),
            {
                "_eval_find": find,
                "_eval": checked_substitution(substitution_args._eval, reach.file.name),
                "_eval_dirname": lambda _: os.path.dirname(xacro.filestack[-1]),
            },
        ),
        (substitution_args._eval_dict, {"find": find}),
    ]
    before = [(space, {key: space[key] for key in new if key in space}) for space, new in swaps]
    builtins = dict(python)
    try:
        for space, new in swaps:
            space.update(new)
        # type and vars lead from any value to every class in the process.
        for key in ("type", "vars"):
            dict.pop(python, key, None)
        yield
    finally:
        for (space, new), (_, old) in zip(swaps, before, strict=True):
            for key in new:
                space.pop(key, None)
            space.update(old)
        dict.update(python, builtins)
        xacro.substitution_args_context.clear()


def _arguments(text: str, root: Element) -> Iterator[str]:
    """The arguments that a xacro document declares or uses."""
    yield from (element.get("name", "") for element in root.iter("xacro:arg"))
    yield from re.findall(r"\$\(\s*arg\s+([^\s)]+)\s*\)", text)


def _unknown_argument(argument: str, declared: set[str], name: str) -> RobotError:
    """The error for an argument that the file does not have."""
    if not declared:
        return RobotError(f"{name} has no xacro arguments, so --xacro {argument}=… means nothing to it; leave it out")
    near = difflib.get_close_matches(argument, declared, n=1)
    nearest = f'; nearest: "{near[0]}"' if near else ""
    listed = ", ".join(f'"{known}"' for known in sorted(declared))
    return RobotError(f'{name} has no xacro argument "{argument}"{nearest}. It has {listed}')


def _explained(error: BaseException, name: str, xacro: ModuleType) -> RobotError:
    """Turn whatever xacro raised into one message: the innermost cause, and the file it happened in."""
    from xacro.substitution_args import ArgException

    cause: BaseException = error
    while True:
        if isinstance(cause, RobotError):
            return cause
        inner = getattr(cause, "exc", None)
        if not isinstance(inner, BaseException):
            break
        cause = inner
    files = [file for file in xacro.filestack or [] if file]
    where = Path(files[-1]).name if files else name
    if isinstance(cause, ArgException):
        return RobotError(f'{where}: xacro argument "{cause}" has no value; give it one: --xacro {cause}=VALUE')
    if isinstance(cause, FileNotFoundError):
        return RobotError(f'{where} includes "{cause.filename}", which does not exist')
    if isinstance(cause, RecursionError):
        return RobotError(f"{where}: xacro does not come to an end; a macro or an include calls itself")
    detail = " ".join(str(error).split()) or type(error).__name__
    if isinstance(cause, TypeError) and any(word in detail for word in ("operand", "concatenate")):
        return RobotError(f"{where}: an argument or property holds a text where arithmetic needs a number: {detail}")
    return RobotError(f"{where}: xacro cannot expand it: {detail}")
