"""The child process of `xacro`: expands one document, and asks its parent for every file and package that the document names.

Messages are one line of JSON each, over standard input and output. It imports nothing of this package, so that it starts quickly.
"""

import errno
import importlib
import io
import json
import os
import resource
import sys
import types
from typing import Any, cast

__all__ = ["main"]

# What an expression may do, of all that Python reports to an audit hook: compute.
_COMPUTING = {"builtins.id", "code.__new__", "compile", "exec", "object.__getattr__", "sys._getframe"}


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

    sys.path += request["libraries"]
    # The last two are otherwise imported later, when nothing can be imported any more.
    libraries = ("xacro", "xacro.substitution_args", "yaml", "xml.dom.expatbuilder")
    xacro, substitution_args, *_ = [cast(Any, importlib.import_module(library)) for library in libraries]

    def open_from_parent(filename: str, *_: object, **__: object) -> io.StringIO:
        text = ask(read=filename)
        if text is None:
            raise FileNotFoundError(errno.ENOENT, "no such file", filename)
        return io.StringIO(text)

    xacro.open = open_from_parent
    xacro.glob = types.SimpleNamespace(glob=lambda pattern: ask(glob=pattern))
    xacro.filestack, xacro.macrostack = [request["file"]], []
    substitution_args._eval_find = substitution_args._eval_dict["find"] = lambda package: ask(find=package)
    substitution_args._eval_dirname = lambda _: os.path.dirname(xacro.filestack[-1])
    sys.stdout = sys.stderr = printed = io.StringIO()
    seconds, memory, links = request["limits"]
    for limit, most in ((resource.RLIMIT_CPU, int(seconds) + 1), (resource.RLIMIT_AS, memory), (resource.RLIMIT_FSIZE, 0)):
        resource.setrlimit(limit, (most, most))

    def audit(event: str, arguments: tuple[Any, ...]) -> None:
        if event not in _COMPUTING:
            detail = f" ({str(arguments[0])[:80]})" if arguments else ""
            raise PermissionError(f'an expression asks for "{event}"{detail}, and expressions may only compute')

    sys.addaudithook(audit)
    try:
        document = xacro.parse(request["text"])
        xacro.process_doc(document, mappings=request["arguments"])
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
    cause = error
    while isinstance(inner := getattr(cause, "exc", None), BaseException):
        cause = inner
    where = os.path.basename(next(file for file in reversed(xacro.filestack) if file))
    kind = type(cause).__name__
    if kind == "ArgException":
        return f'{where}: xacro argument "{cause}" has no value; give: --xacro {cause}:=VALUE'
    if isinstance(cause, FileNotFoundError):
        return f'{where} includes "{cause.filename}", which does not exist'
    if isinstance(cause, RecursionError):
        return f"{where}: xacro does not come to an end; a macro or an include calls itself"
    if isinstance(cause, MemoryError):
        return f"{where}: xacro needs more memory than it may have; look for a macro or an expression that grows without end"
    detail = " ".join(str(error).split())[:500] or kind
    if isinstance(cause, TypeError) and any(word in detail for word in ("operand", "concatenate")):
        return f"{where}: an argument or property holds a text where arithmetic needs a number: {detail}"
    return f"{where}: xacro cannot expand it: {detail}"


if __name__ == "__main__":
    main()
