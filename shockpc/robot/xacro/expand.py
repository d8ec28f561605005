"""xacro to URDF, without ROS: in a child process that reads no file itself and ends within 10 s and
1 GB.

The child asks for every file and package that a document names, and gets what lies in the open
folders; of the environment it has only the seed of its hashes, so that every run gives the same
text. No code of a document runs: `expression` evaluates its expressions. What the child
answers is bounded and checked here.
"""

import difflib
import glob
import html
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

from shockpc.robot.files.reading import OpenFolders, parse_xml, read_text
from shockpc.robot.tolerances import LINKS
from shockpc.text.errors import RobotError
from shockpc.text.paths import LARGEST_FILE
from shockpc.text.printed import listed

SECONDS = 10.0
MEMORY = 2**30
_CHILD = Path(__file__).with_name("child.py")
_ENVIRONMENT = {"PYTHONHASHSEED": "0"}
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
"""What Python prints of a function or an iterator, which differs from run to run."""


def expand_xacro(
    text: str, folders: OpenFolders, arguments: Mapping[str, str]
) -> tuple[str, tuple[str, ...]]:
    """Expand the text of a xacro file, which may read from these folders, with values for its
    arguments.

    Returns: the URDF text, with mesh paths as found, and what xacro warned of.

    Raises:
        RobotError: arguments are unknown or lack a value, a file is missing, not well-formed or
            outside the open folders, or xacro cannot expand it within the limits.
    """
    name, texts, missing = folders.file.name, [text], dict[str, str]()
    origins = [
        spec.origin
        for spec in map(importlib.util.find_spec, ("xacro", "yaml"))
        if spec and spec.origin
    ]
    request = {
        "text": text,
        "file": str(folders.file),
        "arguments": dict(arguments),
        "limits": [SECONDS, MEMORY, LINKS],
    }
    request["libraries"] = sorted({str(Path(origin).parent.parent) for origin in origins})
    try:
        answer = _result(request, folders, texts, missing)
    except RobotError:
        if not missing:  # else a value that stands in for a missing one may be the cause
            raise
    if missing:
        have = "argument {} has" if len(missing) == 1 else "arguments {} have"
        give = " ".join(f"--xacro {argument}:=VALUE" for argument in missing)
        raise RobotError(f"{name}: xacro {have.format(listed(missing))} no value; give: {give}")
    if answer is None:
        cause = "look for a macro, an expression or a number that grows without end"
        limits = f"{SECONDS:g} s, {MEMORY / 2**30:g} GB and {LARGEST_FILE // 2**20} MB of text"
        raise RobotError(f"{name}: xacro gave no result within {limits}; {cause}")
    if "error" in answer:
        raise RobotError(answer["error"])
    known = {match[1] or match[2] for text in texts for match in _ARGUMENT.finditer(text)}
    for argument in arguments:
        if argument not in known:
            near = difflib.get_close_matches(argument, known, n=1)
            nearest = f"; nearest: {listed(near)}" if near else ""
            has = f"It has {listed(sorted(known))}" if known else "It has none, so leave it out"
            raise RobotError(f'{name} has no xacro argument "{argument}"{nearest}. {has}')
    warnings = dict.fromkeys(
        line
        for line in answer["printed"].splitlines()
        if line.strip() and not line.startswith(_PLACES)
    )
    return answer["urdf"], tuple(
        f"{name}: xacro: {line.removeprefix('warning: ')}" for line in warnings
    )


def _result(
    request: dict[str, Any], folders: OpenFolders, texts: list[str], missing: dict[str, str]
) -> dict[str, str] | None:
    """Start the child and answer its questions until it has a result; None if it ends without one,
    or answers anything else.
    """
    # As -I, but for the seed of hashes: with another in each run the order of a set, and hash(),
    # would give other names.
    command = [sys.executable, "-P", "-s", "-S", "-B", "-X", "utf8", str(_CHILD)]
    pipe = subprocess.PIPE
    with (
        suppress(BrokenPipeError, json.JSONDecodeError),  # the child has ended
        subprocess.Popen(
            command,
            stdin=pipe,
            stdout=pipe,
            stderr=subprocess.DEVNULL,
            encoding="utf-8",
            env=_ENVIRONMENT,
        ) as child,
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
                message = json.loads(child.stdout.readline(LARGEST_FILE))
                if not (
                    isinstance(message, dict)
                    and all(isinstance(value, str) for value in message.values())
                ):
                    return None
                if _NO_TEXT.search("".join(message.values())):
                    what = "a NUL character or half of a surrogate pair (\\ud800 to \\udfff)"
                    source = "an expression, an argument or a YAML file"
                    raise RobotError(
                        f"{folders.file.name}: {source} contains {what}, which no XML text can; "
                        f"remove it"
                    )
                if printed := _OBJECT.search("\n".join(message.values())):
                    remedy = (
                        "a Python object; call it, or take the numbers and texts out of it, as "
                        "list(...) and an index do"
                    )
                    raise RobotError(
                        f"{folders.file.name}: an expression gives <{html.unescape(printed[1])}>, "
                        f"{remedy}"
                    )
                match message:
                    case {"read": file}:
                        answer = _read(file, folders, texts)
                    case {"missing": argument}:
                        answer = missing[argument] = "1"
                    case {"glob": pattern}:
                        # wildcards among folders could search the whole disk
                        folder, named = os.path.split(pattern)
                        answer = sorted(
                            os.path.join(folder, name)
                            for name in glob.glob(
                                named, root_dir=folders.resolve(Path(folder), pattern)
                            )
                        )
                    case {"find": package}:
                        answer = str(folders.package(package, f"$(find {package})"))
                    case {"error": _} | {"urdf": _, "printed": _}:
                        return message
                    case _:
                        return None
        finally:
            clock.cancel()
            child.kill()
    return None


def _read(filename: str, folders: OpenFolders, texts: list[str]) -> str | None:
    """The text of a file that a document names, which is added to those read; None if it does not
    exist.
    """
    place = folders.resolve(Path(filename), filename)
    if not os.path.exists(place):
        return None
    texts.append(read_text(place))
    if texts[-1].startswith("<"):
        parse_xml(texts[-1], place.name)  # for its checks
    return texts[-1]
