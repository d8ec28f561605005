"""xacro to URDF, without ROS: in a child process that reads no file itself and ends within 10 s and 1 GB.

The child asks for every file and package that a document names, and gets what lies in the open folders. Python expressions in the
document run in the child, with no environment, where an audit hook refuses everything but computing (`xacro_child.py`).
"""

import difflib
import glob
import importlib.util
import json
import os
import re
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from shockpc.errors import RobotError
from shockpc.printed import listed
from shockpc.robot.files import OpenFolders, parse_xml, read_text
from shockpc.robot.limits import LINKS

__all__ = ["expand_xacro"]

SECONDS = 10.0
MEMORY = 2**30
_CHILD = Path(__file__).with_name("xacro_child.py")
# xacro's lines about where something happened mean nothing without the file at hand.
_PLACES = ("when ", "in file:", "included from:", "instantiated from:")
_ARGUMENT = re.compile(r"""<xacro:arg\s[^>]*?\bname\s*=\s*["']([^"']+)|\$\(\s*arg\s+([^\s)]+)""")


def expand_xacro(text: str, folders: OpenFolders, arguments: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Expand the text of a xacro file, which may read from these folders, with values for its arguments.

    Returns: the URDF text, with mesh paths as found, and what xacro warned of.

    Raises:
        RobotError: an argument is unknown or lacks a value, a file is missing, not well-formed or outside the open folders, or
            xacro cannot expand it within the limits.
    """
    name, texts = folders.file.name, [text]
    found = [spec.origin for spec in map(importlib.util.find_spec, ("xacro", "yaml")) if spec and spec.origin]
    request = {"text": text, "file": str(folders.file), "arguments": dict(arguments), "limits": [SECONDS, MEMORY, LINKS]}
    request["libraries"] = sorted({str(Path(origin).parent.parent) for origin in found})
    answer = _result(request, folders, texts)
    if answer is None:
        cause = "look for a macro, an expression or a number that grows without end"
        raise RobotError(f"{name}: xacro gave no result within {SECONDS:g} s and {MEMORY / 2**30:g} GB; {cause}")
    if "error" in answer:
        raise RobotError(answer["error"])
    known = {match[1] or match[2] for text in texts for match in _ARGUMENT.finditer(text)}
    for argument in arguments:
        if argument not in known:
            near = difflib.get_close_matches(argument, known, n=1)
            nearest = f"; nearest: {listed(near)}" if near else ""
            has = f"It has {listed(sorted(known))}" if known else "It has none, so leave it out"
            raise RobotError(f'{name} has no xacro argument "{argument}"{nearest}. {has}')
    warnings = dict.fromkeys(line for line in answer["printed"].splitlines() if line.strip() and not line.startswith(_PLACES))
    return answer["urdf"], tuple(f"{name}: xacro: {line.removeprefix('warning: ')}" for line in warnings)


def _result(request: dict[str, Any], folders: OpenFolders, texts: list[str]) -> dict[str, Any] | None:
    """Start the child and answer its questions until it has a result; None if it ends without one."""
    command = [sys.executable, "-I", "-S", "-B", "-X", "utf8", str(_CHILD)]
    pipe = subprocess.PIPE
    with (
        suppress(BrokenPipeError, json.JSONDecodeError),  # the child has ended
        subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, encoding="utf-8", env={}) as child,
    ):
        assert child.stdin is not None
        assert child.stdout is not None
        clock = threading.Timer(SECONDS, child.kill)
        clock.start()
        answer: Any = request
        try:
            while True:
                child.stdin.write(json.dumps(answer) + "\n")
                child.stdin.flush()
                match json.loads(child.stdout.readline()):
                    case {"read": file}:
                        answer = _read(file, folders, texts)
                    case {"glob": pattern}:
                        folder, named = os.path.split(pattern)  # wildcards among folders could search the whole disk
                        answer = sorted(
                            os.path.join(folder, name) for name in glob.glob(named, root_dir=folders.resolve(Path(folder), pattern))
                        )
                    case {"find": package}:
                        answer = str(folders.package(package, f"$(find {package})"))
                    case result:
                        return dict(result)
        finally:
            clock.cancel()
            child.kill()
    return None


def _read(filename: str, folders: OpenFolders, texts: list[str]) -> str | None:
    """The text of a file that a document names, which is added to those read; None if it does not exist."""
    place = folders.resolve(Path(filename), filename)
    if not os.path.exists(place):
        return None
    texts.append(read_text(place))
    if texts[-1].startswith("<"):
        parse_xml(texts[-1], place.name)  # for its checks
    return texts[-1]
