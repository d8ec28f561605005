"""xacro to URDF, without ROS: in a child process that ends within 10 s and 1 GB.

xacro opens every file and finds every package by functions of `_Document`, which read what lies in
the open folders. It sees no environment. No code of a document runs: `expression` evaluates its
expressions, with those functions of xacro that only compute.
"""

import difflib
import errno
import functools
import glob
import html
import importlib
import io
import os
import re
import sys
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from shockpc.robot.files.limited_process import MEMORY, in_child
from shockpc.robot.files.reading import OpenFolders, parse_xml, read_text
from shockpc.robot.tolerances import LINKS
from shockpc.robot.xacro.expression import evaluate
from shockpc.text.errors import RobotError
from shockpc.text.paths import LARGEST_FILE
from shockpc.text.printed import listed

SECONDS = 10
_LIBRARIES = ("xacro", "xacro.substitution_args", "yaml", "xml.dom.expatbuilder", __name__)
# Of what xacro offers to expressions, all but `type` and `vars`, which lead to the methods of any
# class; and all of `math`.
_PYTHON = (
    "list dict map len str float int bool min max round sorted range abs all any complex divmod "
    "enumerate filter frozenset hash isinstance issubclass ord repr reversed slice set sum tuple "
    "zip"
)
_XACRO = "load_yaml abs_filename dotify arg message warning error print_location fatal tokenize"
_OFFERED = {*_PYTHON.split(), *_XACRO.split(), "python", "xacro", "math"}
# xacro's lines about where something happened mean nothing without the file at hand.
_PLACES = ("when ", "in file:", "included from:", "instantiated from:")
# Up to the next element, so that the time is linear in the length of a text in which none ends.
_ARGUMENT = re.compile(
    r"""<xacro:arg\s[^<>]*?\bname\s*=\s*["']([^"']+)|(?:\$\(\s*arg\s+|\bxacro\.arg\(\s*["'])([^\s"')]+)"""
)
_NO_TEXT = re.compile("[\0\ud800-\udfff]")
_OBJECT = re.compile(
    r"""(?:&lt;|<)((?:[^<>&"']|<locals>|&lt;locals&gt;){1,200}) at 0x[0-9a-f]+(?:&gt;|>)"""
)
"""The text that Python prints of a function or an iterator, which differs from run to run."""


class _Expanded(NamedTuple):
    """The result of expanding a document.

    Attributes:
        urdf: the text.
        printed: what xacro says of it.
        texts: of the document and all that it includes.
        seen: the state of their files.
    """

    urdf: str
    printed: str
    texts: list[str]
    seen: dict[Path, Any]


def expand_xacro(
    text: str, folders: OpenFolders, arguments: Mapping[str, str]
) -> tuple[str, tuple[str, ...]]:
    """Expand the text of a xacro file, with values for its arguments.

    The file may read from these folders.

    Returns: the URDF text, with mesh paths as found, and what xacro warned of.

    Raises:
        RobotError: arguments are unknown or lack a value, a file is missing, not well-formed or
            outside the open folders, or xacro cannot expand it within the limits.
    """
    name = folders.file.name
    work = functools.partial(_expanded, text, folders, dict(arguments))
    expanded = in_child(work, _LIBRARIES, SECONDS)
    if expanded is None:
        cause = "look for a macro, an expression or a number that grows without end"
        limits = f"{SECONDS:g} s, {MEMORY / 2**30:g} GB and {LARGEST_FILE // 2**20} MB of text"
        raise RobotError(f"{name}: xacro gave no result within {limits}; {cause}")
    folders.seen.update(expanded.seen)
    _refuse_unknown(arguments, expanded.texts, name)
    lines = [line for line in expanded.printed.splitlines() if line.strip()]
    warnings = dict.fromkeys(line for line in lines if not line.startswith(_PLACES))
    return expanded.urdf, tuple(
        f"{name}: xacro: {line.removeprefix('warning: ')}" for line in warnings
    )


def _refuse_unknown(arguments: Mapping[str, str], texts: list[str], name: str) -> None:
    """Refuse arguments that no text of a document has. Args: name, of the file."""
    known: set[str] = set()
    for text in texts:
        known |= {match[1] or match[2] for match in _ARGUMENT.finditer(text)}
    for argument in arguments:
        if argument not in known:
            near = difflib.get_close_matches(argument, known, n=1)
            nearest = f"; nearest: {listed(near)}" if near else ""
            has = f"It has {listed(sorted(known))}" if known else "It has none, so leave it out"
            raise RobotError(f'{name} has no xacro argument "{argument}"{nearest}. {has}')


def _expanded(text: str, folders: OpenFolders, arguments: dict[str, str]) -> _Expanded | None:
    """A document, expanded in this process, which is a child; None if it becomes too long.

    Raises:
        RobotError: as for `expand_xacro`.
    """
    xacro: Any = importlib.import_module("xacro")
    document = _Document(text, folders)
    _confine(xacro, document)
    printed = io.StringIO()
    sys.stdout = sys.stderr = printed
    failure: Exception | None = None
    urdf = ""
    try:
        tree = xacro.parse(text)
        xacro.process_doc(tree, mappings=_Arguments(arguments, document.missing))
        links = len(tree.getElementsByTagName("link"))
        if links > LINKS:
            raise xacro.XacroException(f"it has {links} links, more than {LINKS}")
        urdf = document.checked(tree.documentElement.toxml())
    except Exception as error:  # whatever a document makes xacro raise
        failure = error
    # A value that stands in for a missing one may be the cause of a failure.
    document.refuse_missing()
    if failure is not None:
        raise document.explained(failure, xacro.filestack)
    lines = document.checked(printed.getvalue())
    if len(urdf) + len(lines) > LARGEST_FILE:
        return None
    return _Expanded(urdf, lines, document.texts, folders.seen)


def _confine(xacro: Any, document: "_Document") -> None:
    """Give xacro the functions of a document in place of its own.

    Its own read the disk, the environment and what Python can do.
    """
    substitution: Any = importlib.import_module("xacro.substitution_args")
    xacro.open = document.open
    xacro.glob = types.SimpleNamespace(glob=document.glob)
    xacro.filestack = [str(document.folders.file)]
    xacro.macrostack = []
    substitution.os = types.SimpleNamespace(environ={}, path=os.path)
    substitution._eval_find = document.find
    substitution._eval_dirname = lambda _: os.path.dirname(xacro.filestack[-1])

    symbols = xacro._global_symbols
    for table in (symbols, symbols["python"], symbols["xacro"]):
        for name in table.keys() - _OFFERED - symbols["math"].keys():
            dict.pop(table, name)
    functions = {**symbols["math"], **symbols["python"], "true": True, "false": False}

    def substitute(text: str, context: dict[str, Any]) -> str:
        values = {
            name: substitution.convert_value(value, "auto")
            for name, value in context["arg"].items()
        }
        return str(evaluate(text, {**values, **functions}))

    xacro.safe_eval = evaluate
    substitution._eval = substitute
    # so that a later xacro which evaluates a text elsewhere fails
    for module in (xacro, substitution):
        module.eval = module.exec = None


class _Arguments(dict[str, str]):
    """Values of a document's arguments, of which one that is missing is 1."""

    def __init__(self, values: Mapping[str, str], missing: list[str]) -> None:
        super().__init__(values)
        self._missing = missing

    def __missing__(self, name: str) -> str:
        self._missing.append(name)
        self[name] = "1"
        return "1"


class _Document:
    """A document that is expanded: what it may read, and what was met.

    Attributes:
        folders: that it may read.
        texts: its own and those that it included.
        missing: its arguments without a value.
    """

    def __init__(self, text: str, folders: OpenFolders) -> None:
        self.folders = folders
        self.texts = [text]
        self.missing: list[str] = []

    def open(self, filename: str, *_: object, **__: object) -> io.StringIO:
        """A file that the document names, in place of Python's `open`."""
        file = self.folders.resolve(Path(self.checked(filename)), filename)
        if not os.path.exists(file):
            raise FileNotFoundError(errno.ENOENT, "no such file", filename)
        text = read_text(file)
        if text.startswith("<"):
            parse_xml(text, file.name)  # for its checks
        self.texts.append(text)
        return io.StringIO(text)

    def glob(self, pattern: str) -> list[str]:
        """The files of a folder that a pattern names.

        A wildcard among folders could search the whole disk.
        """
        folder, named = os.path.split(self.checked(pattern))
        root = self.folders.resolve(Path(folder), pattern)
        return sorted(os.path.join(folder, name) for name in glob.glob(named, root_dir=root))

    def find(self, package: str) -> str:
        """The folder of a package."""
        return str(self.folders.package(self.checked(package), f"$(find {package})"))

    def checked(self, text: str) -> str:
        """A text that XML can hold, and that is the same in every run.

        Raises:
            RobotError: it is not.
        """
        name = self.folders.file.name
        if _NO_TEXT.search(text):
            raise RobotError(
                f"{name}: an expression, an argument or a YAML file contains a NUL character or "
                f"half of a surrogate pair (\\ud800 to \\udfff), which no XML text can; remove it"
            )
        printed = _OBJECT.search(text)
        if printed:
            raise RobotError(
                f"{name}: an expression gives <{html.unescape(printed[1])}>, a Python object; call "
                f"it, or take the numbers and texts out of it, as list(...) and an index do"
            )
        return text

    def refuse_missing(self) -> None:
        """Refuse arguments without a value."""
        if self.missing:
            have = "argument {} has" if len(self.missing) == 1 else "arguments {} have"
            give = " ".join(f"--xacro {argument}:=VALUE" for argument in self.missing)
            raise RobotError(
                f"{self.folders.file.name}: xacro {have.format(listed(self.missing))} no value; "
                f"give: {give}"
            )

    def explained(self, error: BaseException, files: list[str | None]) -> RobotError:
        """Whatever xacro raised as one line: the innermost cause, and the file it happened in.

        Args:
            error: what it raised.
            files: those that it was reading, the last one inside the others.
        """
        cause, places = error, ""
        while isinstance(inner := getattr(cause, "exc", None), BaseException):
            places = f"{getattr(cause, 'suffix', None) or ''} {places}"
            cause = inner
        if isinstance(cause, RobotError):
            return cause
        named = [file for file in files if file]
        text = f"{os.path.basename(named[-1])}{_reason(cause, places)}"
        return RobotError(self.checked(text))


def _reason(cause: BaseException, places: str) -> str:
    """The reason of a failure, in words, behind the name of a file.

    Args: places, where, as xacro says.
    """
    if isinstance(cause, FileNotFoundError):
        return f' includes "{cause.filename}", which does not exist'
    if isinstance(cause, RecursionError):
        return ": xacro does not come to an end; a macro or an include calls itself"
    if isinstance(cause, MemoryError):
        return (
            ": xacro needs more memory than it may have; look for a macro or an expression that "
            "grows without end"
        )
    detail = " ".join(f"{cause} {places}".split())[:500] or type(cause).__name__
    if isinstance(cause, TypeError) and any(word in detail for word in ("operand", "concatenate")):
        return f": an argument or property holds a text where arithmetic needs a number: {detail}"
    return f": xacro cannot expand it: {detail}"
