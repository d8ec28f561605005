"""The child process of `xacro`: expands one document, and asks its parent for every file and
package that the document names.

Expressions are evaluated by `expression`, with those functions of xacro that only compute.
Messages are one line of JSON each, over standard input and output. It imports nothing else of this
package, so that it starts quickly.
"""

import builtins
import errno
import importlib
import io
import json
import os
import resource
import sys
import types
from typing import Any, cast

# Of what xacro offers to expressions, all but `type` and `vars`, which lead to the methods of any
# class; and all of `math`.
_PYTHON = (
    "list dict map len str float int bool min max round sorted range abs all any complex divmod "
    "enumerate filter frozenset hash"
)
_PYTHON += " isinstance issubclass ord repr reversed slice set sum tuple zip"
_XACRO = "load_yaml abs_filename dotify arg message warning error print_location fatal tokenize"
_OFFERED = {*_PYTHON.split(), *_XACRO.split(), "python", "xacro", "math"}


def main() -> None:
    """Serve one request."""
    requests, answers = sys.stdin, sys.stdout
    request = json.loads(requests.readline())

    def answer(**message: object) -> None:
        answers.write(json.dumps(message) + "\n")
        answers.flush()

    def ask(**question: str) -> Any:
        answer(**question)
        return json.loads(requests.readline())

    sys.path += [*request["libraries"], os.path.dirname(__file__)]
    # The last two are otherwise imported later, when nothing can be imported any more.
    libraries = (
        "xacro",
        "xacro.substitution_args",
        "expression",
        "yaml",
        "xml.dom.expatbuilder",
    )
    xacro, substitution_args, expression, *_ = [
        cast(Any, importlib.import_module(library)) for library in libraries
    ]
    # so that a later xacro which calls them elsewhere fails
    vars(builtins).update(eval=None, exec=None)

    class Arguments(dict[str, str]):
        def __missing__(self, name: str) -> str:
            return str(ask(missing=name))

    def open_from_parent(filename: str, *_: object, **__: object) -> io.StringIO:
        text = ask(read=filename)
        if text is None:
            raise FileNotFoundError(errno.ENOENT, "no such file", filename)
        return io.StringIO(text)

    xacro.open = open_from_parent
    xacro.glob = types.SimpleNamespace(glob=lambda pattern: ask(glob=pattern))
    xacro.filestack, xacro.macrostack = [request["file"]], []
    substitution_args._eval_find = lambda package: ask(find=package)
    substitution_args._eval_dirname = lambda _: os.path.dirname(xacro.filestack[-1])
    symbols = xacro._global_symbols
    for table in (symbols, symbols["python"], symbols["xacro"]):
        for name in table.keys() - _OFFERED - symbols["math"].keys():
            dict.pop(table, name)
    functions = {**symbols["math"], **symbols["python"], "true": True, "false": False}

    def substitute(text: str, context: dict[str, Any]) -> str:
        values = {
            name: substitution_args.convert_value(value, "auto")
            for name, value in context["arg"].items()
        }
        return str(expression.evaluate(text, {**values, **functions}))

    xacro.safe_eval = expression.evaluate
    substitution_args._eval = substitute
    sys.stdout = sys.stderr = printed = io.StringIO()
    seconds, memory, links = request["limits"]
    for limit, most in (
        (resource.RLIMIT_CPU, int(seconds) + 1),
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, 0),
    ):
        resource.setrlimit(limit, (most, most))

    try:
        document = xacro.parse(request["text"])
        xacro.process_doc(document, mappings=Arguments(request["arguments"]))
        count = len(document.getElementsByTagName("link"))
        if count > links:
            raise xacro.XacroException(f"it has {count} links, more than {links}")
        urdf = document.documentElement.toxml()
    except Exception as error:
        answer(error=_explained(error, xacro))
    else:
        answer(urdf=urdf, printed=printed.getvalue())


def _explained(error: BaseException, xacro: Any) -> str:
    """Turn whatever xacro raised into one line: the innermost cause, and the file it happened in."""
    cause, places = error, ""
    while isinstance(inner := getattr(cause, "exc", None), BaseException):
        cause, places = inner, f"{getattr(cause, 'suffix', None) or ''} {places}"
    where = os.path.basename(next(file for file in reversed(xacro.filestack) if file))
    if isinstance(cause, FileNotFoundError):
        return f'{where} includes "{cause.filename}", which does not exist'
    if isinstance(cause, RecursionError):
        return f"{where}: xacro does not come to an end; a macro or an include calls itself"
    if isinstance(cause, MemoryError):
        return (
            f"{where}: xacro needs more memory than it may have; look for a macro or an expression "
            f"that grows without end"
        )
    detail = " ".join(f"{cause} {places}".split())[:500] or type(cause).__name__
    if isinstance(cause, TypeError) and any(word in detail for word in ("operand", "concatenate")):
        return (
            f"{where}: an argument or property holds a text where arithmetic needs a number: "
            f"{detail}"
        )
    return f"{where}: xacro cannot expand it: {detail}"


if __name__ == "__main__":
    main()
