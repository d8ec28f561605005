"""xacro to URDF, without ROS: in a child process with limits of time and memory, which reads nothing outside the open folders.

xacro opens files, looks for patterns and finds packages by functions given here alone, and sees nothing of the environment but
ROS_PACKAGE_PATH. No code of a document runs: `xacro_expression` evaluates its expressions, with those functions of xacro that only
compute.
"""

import builtins
import difflib
import errno
import functools
import glob
import importlib
import io
import os
import re
import sys
import types
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

from shockpc.errors import RobotError
from shockpc.paths import LARGEST_FILE
from shockpc.printed import listed
from shockpc.robot.child import LIMITS, in_child
from shockpc.robot.files import OpenFolders, parse_xml, read_text
from shockpc.robot.limits import LINKS
from shockpc.robot.xacro_expression import evaluate

# xacro's lines about where something happened mean nothing without the file at hand.
_PLACES = ("when ", "in file:", "included from:", "instantiated from:")
_ARGUMENT = r"""<xacro:arg\s[^>]*?\bname\s*=\s*["']([^"']+)|(?:\$\(\s*arg\s+|\bxacro\.arg\(\s*["'])([^\s"')]+)"""
# Of what xacro offers to expressions, all but `type` and `vars`, which lead to the methods of any class; and all of `math`.
_PYTHON = (
    "list dict map len str float int bool min max round sorted range abs all any complex divmod enumerate filter frozenset hash"
)
_PYTHON += " isinstance issubclass ord repr reversed slice set sum tuple zip"
_XACRO = "load_yaml abs_filename dotify arg message warning error print_location fatal tokenize"
_OFFERED = {*_PYTHON.split(), *_XACRO.split(), "python", "xacro", "math"}


def expand_xacro(text: str, folders: OpenFolders, arguments: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Expand the text of a xacro file, which may read from these folders, with values for its arguments.

    Returns: the URDF text, with mesh paths as found, and what xacro warned of.

    Raises:
        RobotError: arguments are unknown or lack a value, a file is missing, not well-formed or outside the open folders, or xacro
            cannot expand it within the limits.
    """
    answer = in_child(functools.partial(_expanded, text, folders, arguments))
    if answer is None:
        raise _endless(folders)
    urdf, warnings, seen = answer
    folders.seen.update(seen)
    return urdf, warnings


def _endless(folders: OpenFolders) -> RobotError:
    limits = f"{LIMITS}, of which {LARGEST_FILE // 2**20} MB are text"
    cause = "look for a macro, an expression or a number that grows without end"
    return RobotError(f"{folders.file.name}: xacro gave no result within {limits}; {cause}")


def _expanded(text: str, folders: OpenFolders, arguments: Mapping[str, str]) -> tuple[str, tuple[str, ...], dict[Path, Any]]:
    """As `expand_xacro`, in the child, which is changed; with the state of the files that were read."""
    # The last two are otherwise imported later, when nothing can be imported any more.
    libraries = ("xacro", "xacro.substitution_args", "yaml", "xml.dom.expatbuilder")
    xacro, substitution_args, *_ = [cast(Any, importlib.import_module(library)) for library in libraries]
    vars(builtins).update(eval=None, exec=None)  # so that a later xacro which calls them elsewhere fails
    for name in os.environ.keys() - {"ROS_PACKAGE_PATH"}:
        del os.environ[name]
    name, texts, missing, refusals = folders.file.name, [text], dict[str, str](), list[RobotError]()

    class Arguments(dict[str, str]):
        def __missing__(self, argument: str) -> str:
            missing[argument] = "1"
            return "1"

    def refusing(function: Callable[[str], Any]) -> Callable[..., Any]:
        """The function, whose refusal counts whatever xacro makes of it."""

        def called(argument: str, *_: object, **__: object) -> Any:
            try:
                return function(_printable(argument, name))
            except RobotError as refusal:
                refusals.append(refusal)
                raise

        return called

    def read(filename: str) -> io.StringIO:
        place = folders.resolve(Path(filename), filename)
        if not os.path.exists(place):
            raise FileNotFoundError(errno.ENOENT, "no such file", filename)
        texts.append(read_text(place))
        if texts[-1].startswith("<"):
            parse_xml(texts[-1], place.name)  # for its checks
        return io.StringIO(texts[-1])

    def matching(pattern: str) -> list[str]:
        folder, named = os.path.split(pattern)  # wildcards among folders could search the whole disk
        names = glob.glob(named, root_dir=folders.resolve(Path(folder), pattern))
        return sorted(os.path.join(folder, each) for each in names)

    xacro.open, xacro.glob = refusing(read), types.SimpleNamespace(glob=refusing(matching))
    xacro.filestack, xacro.macrostack = [str(folders.file)], []
    substitution_args._eval_find = refusing(lambda package: str(folders.package(package, f"$(find {package})")))
    substitution_args._eval_dirname = lambda _: os.path.dirname(xacro.filestack[-1])
    symbols = xacro._global_symbols
    for table in (symbols, symbols["python"], symbols["xacro"]):
        for offered in table.keys() - _OFFERED - symbols["math"].keys():
            dict.pop(table, offered)
    functions = {**symbols["math"], **symbols["python"], "true": True, "false": False}

    def substitute(expression: str, context: dict[str, Any]) -> str:
        values = {key: substitution_args.convert_value(value, "auto") for key, value in context["arg"].items()}
        return str(evaluate(expression, {**values, **functions}))

    xacro.safe_eval, substitution_args._eval = evaluate, substitute
    sys.stdout = sys.stderr = printed = io.StringIO()
    urdf, failure = "", None
    try:
        document = xacro.parse(text)
        xacro.process_doc(document, mappings=Arguments(arguments))
        if (count := len(document.getElementsByTagName("link"))) > LINKS:
            raise xacro.XacroException(f"it has {count} links, more than {LINKS}")
        urdf = _printable(document.documentElement.toxml(), name)
    except Exception as error:
        failure = refusals[0] if refusals else RobotError(_explained(error, xacro))
    if missing:  # for which a value stood in that may be the cause of a failure
        have = "argument {} has" if len(missing) == 1 else "arguments {} have"
        give = " ".join(f"--xacro {argument}:=VALUE" for argument in missing)
        raise RobotError(f"{name}: xacro {have.format(listed(missing))} no value; give: {give}")
    if failure is not None:
        raise failure
    if len(urdf) + len(printed.getvalue()) > LARGEST_FILE:
        raise _endless(folders)
    known = {match[1] or match[2] for part in texts for match in re.finditer(_ARGUMENT, part)}
    for argument in arguments:
        if argument not in known:
            near = difflib.get_close_matches(argument, known, n=1)
            nearest = f"; nearest: {listed(near)}" if near else ""
            has = f"It has {listed(sorted(known))}" if known else "It has none, so leave it out"
            raise RobotError(f'{name} has no xacro argument "{argument}"{nearest}. {has}')
    lines = dict.fromkeys(line for line in printed.getvalue().splitlines() if line.strip() and not line.startswith(_PLACES))
    return urdf, tuple(f"{name}: xacro: {line.removeprefix('warning: ')}" for line in lines), folders.seen


def _printable(text: str, name: str) -> str:
    """A text that XML can hold."""
    if re.search("[\0\ud800-\udfff]", text):
        what = "a NUL character or half of a surrogate pair (\\ud800 to \\udfff)"
        whose = "an expression, an argument or a YAML file"
        raise RobotError(f"{name}: {whose} contains {what}, which no XML text can; remove it")
    return text


def _explained(error: BaseException, xacro: Any) -> str:
    """Turn whatever xacro raised into one line: the innermost cause, and the file it happened in."""
    cause, places = error, ""
    while isinstance(inner := getattr(cause, "exc", None), BaseException):
        cause, places = inner, f"{getattr(cause, 'suffix', None) or ''} {places}"
    if isinstance(cause, RobotError):
        return str(cause)
    where = os.path.basename(next(file for file in reversed(xacro.filestack) if file))
    if isinstance(cause, FileNotFoundError):
        return f'{where} includes "{cause.filename}", which does not exist'
    if isinstance(cause, RecursionError):
        return f"{where}: xacro does not come to an end; a macro or an include calls itself"
    if isinstance(cause, MemoryError):
        return f"{where}: xacro needs more memory than it may have; look for a macro or an expression that grows without end"
    detail = " ".join(f"{cause} {places}".split())[:500] or type(cause).__name__
    if isinstance(cause, TypeError) and any(word in detail for word in ("operand", "concatenate")):
        return f"{where}: an argument or property holds a text where arithmetic needs a number: {detail}"
    return f"{where}: xacro cannot expand it: {detail}"
