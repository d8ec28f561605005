"""xacro to URDF, without ROS: in a child process that reads no file itself and ends within 10 s and 1 GB.

The child asks for every file and package that a document names, and gets what lies in the open folders. Python expressions in the
document run in the child, with no environment, where an audit hook refuses everything but computing (`xacro_child.py`).
"""

import contextlib
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
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.printed import listed
from shockpc.robot.files import Markup, OpenFolders, parse_xml, read_text
from shockpc.robot.limits import LINKS

__all__ = ["expand_xacro"]

SECONDS = 10.0
MEMORY = 2**30
_CHILD = Path(__file__).with_name("xacro_child.py")
# xacro's lines about where something happened mean nothing without the file at hand.
_PLACES = ("when ", "in file:", "included from:", "instantiated from:")


def expand_xacro(markup: Markup, folders: OpenFolders, arguments: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Expand a xacro file, which may read from these folders, with values for its arguments.

    Returns:
        The URDF text, with mesh paths as found, and what xacro warned of.

    Raises:
        RobotError: an argument is unknown or lacks a value, a file it includes is missing, not well-formed or outside the open
            folders, or xacro cannot expand it within the limits.
    """
    name = folders.file.name
    declared: dict[str, bool] = {}
    _declare(declared, markup.text, markup.root)
    libraries = {
        str(Path(spec.origin).parent.parent) for spec in map(importlib.util.find_spec, ("xacro", "yaml")) if spec and spec.origin
    }
    request = {
        "text": markup.text,
        "file": str(folders.file),
        "arguments": dict(arguments),
        "libraries": sorted(libraries),
        "limits": [SECONDS, MEMORY, LINKS],
    }
    answer, in_time = _run(request, folders, declared)
    if answer is None:
        what = "ended without a result" if in_time else "did not end"
        raise RobotError(
            f"{name}: xacro {what} within {SECONDS:g} s and {MEMORY / 2**30:g} GB; look for a macro, an expression or a number "
            "that grows without end"
        )
    if "error" in answer:
        missing = sorted(each for each, has_default in declared.items() if not has_default and each not in arguments)
        if missing and "has no value" in answer["error"]:
            said = "argument {} has" if len(missing) == 1 else "arguments {} have"
            typed = " ".join(f"--xacro {each}:=VALUE" for each in missing)
            raise RobotError(f"{name}: xacro {said.format(listed(missing))} no value; give: {typed}")
        raise RobotError(answer["error"])
    for argument in arguments:
        if not declared:
            raise RobotError(f"{name} has no xacro arguments, so --xacro {argument}=… has no effect; leave it out")
        if argument not in declared:
            near = difflib.get_close_matches(argument, declared, n=1)
            nearest = f"; nearest: {listed(near)}" if near else ""
            raise RobotError(f'{name} has no xacro argument "{argument}"{nearest}. It has {listed(sorted(declared))}')
    warnings = dict.fromkeys(line for line in answer["printed"].splitlines() if line.strip() and not line.startswith(_PLACES))
    return answer["urdf"], tuple(f"{name}: xacro: {line.removeprefix('warning: ')}" for line in warnings)


def _run(request: dict[str, Any], folders: OpenFolders, declared: dict[str, bool]) -> tuple[dict[str, Any] | None, bool]:
    """The child's result, None without one; and whether it ended in time."""
    answer, in_time = None, True
    with (
        contextlib.suppress(BrokenPipeError),  # what a dead child has not read
        subprocess.Popen(
            [sys.executable, "-I", "-S", "-B", "-X", "utf8", str(_CHILD)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            encoding="utf-8",
            env={},
        ) as child,
    ):
        clock = threading.Timer(SECONDS, child.kill)
        clock.start()
        try:
            answer = _converse(child, request, folders, declared)
        finally:
            in_time = clock.is_alive()
            clock.cancel()
            child.kill()
    return answer, in_time


def _converse(
    child: "subprocess.Popen[str]", request: dict[str, Any], folders: OpenFolders, declared: dict[str, bool]
) -> dict[str, Any] | None:
    """Answer the child's questions until it has a result; None if it dies."""
    assert child.stdin is not None
    assert child.stdout is not None
    answer: dict[str, Any] = request
    try:
        while True:
            child.stdin.write(json.dumps(answer) + "\n")
            child.stdin.flush()
            line = child.stdout.readline()
            if not line:
                return None
            question = json.loads(line)
            if "read" in question:
                answer = {"text": _read(question["read"], folders, declared)}
            elif "glob" in question:
                answer = {"files": sorted(glob.glob(question["glob"]))}
            elif "find" in question:
                answer = {"folder": str(folders.package(question["find"], f"$(find {question['find']})"))}
            else:
                return dict(question)
    except (BrokenPipeError, ValueError):
        return None


def _read(filename: str, folders: OpenFolders, declared: dict[str, bool]) -> str | None:
    """The text of a file that a document names, None if it does not exist; its arguments are added to those declared."""
    place = folders.resolve(Path(filename), filename)
    if not os.path.exists(place):
        return None
    text = read_text(place)
    if text.startswith("<"):
        _declare(declared, text, parse_xml(text, place.name))
    return text


def _declare(declared: dict[str, bool], text: str, root: Element) -> None:
    """Add the arguments that a xacro document declares, which have a default, and those that it uses."""
    declared.update((element.get("name", ""), True) for element in root.iter("xacro:arg"))
    for name in re.findall(r"\$\(\s*arg\s+([^\s)]+)\s*\)", text):
        declared.setdefault(name, False)
