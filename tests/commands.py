"""Commands run as a user types them, in this process, with what they print on either stream."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from robot_texts import joint, link, urdf

from shockpc.cli.entry import main

ROBOTS = Path(__file__).parent / "robots"

STICK = urdf(
    link(
        "body",
        "2",
        '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/><origin xyz="0.01 0 '
        '0.05"/>',
    ),
    link(
        "shin",
        "0.5",
        '<inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0002"/><origin xyz="0 0 '
        '-0.2"/>',
    ),
    '<link name="foot"/>',
    joint("knee", "body", "shin", more='<limit lower="-2" upper="2" effort="10" velocity="10"/>'),
    joint("ankle", "shin", "foot", "fixed", more='<origin xyz="0 0 -0.4"/>'),
    name="stick",
)
"""A body on a shin, with a foot at its end."""

IMU = '<link name="imu_link"/>' + joint(
    "imu_fixed", "body", "imu_link", "fixed", more='<origin xyz="0.02 0 0.1"/>'
)
STICK_WITH_IMU = STICK.replace("</robot>", IMU + "</robot>")
"""The same with an IMU on the body."""

SLOW = """
import pathlib, shockpc.profile, sys, time
def slow(*_):
    pathlib.Path("ready").touch()
    time.sleep(60)
shockpc.profile.profile_of_scene = slow
from shockpc.cli.entry import entry
entry()
"""
"""Code of a command that computes for a minute; it makes the file `ready` when it begins."""


class Outcome(NamedTuple):
    """How a command ended, and what it printed."""

    code: int
    out: str
    err: str


def run(capfd: pytest.CaptureFixture[str], *words: object) -> Outcome:
    """Run a command in this process.

    Both streams are read as files, so that what a C++ library prints is read too.
    """
    capfd.readouterr()
    code = main([str(word) for word in words])
    return Outcome(code, *capfd.readouterr())


def good(capfd: pytest.CaptureFixture[str], *words: object) -> str:
    """Run a command that has to succeed and to print nothing on standard error; what it prints."""
    outcome = run(capfd, *words)
    assert outcome._replace(out="") == Outcome(0, "", ""), outcome.err
    return outcome.out


def document(capfd: pytest.CaptureFixture[str], *words: object) -> Any:
    """The JSON document of an analysis."""
    return json.loads(good(capfd, "analyze", *words, "--format", "json"))


def says(texts: str | Iterable[str], *parts: str) -> bool:
    """Whether one of some texts, or one line of a text, has all these names and numbers."""
    lines = texts.splitlines() if isinstance(texts, str) else texts
    return any(all(part in line for part in parts) for line in lines)


def python(code: str, *words: str, **changes: str) -> subprocess.CompletedProcess[str]:
    """Run Python code in a separate process."""
    return subprocess.run(
        [sys.executable, "-c", code, *words],
        capture_output=True,
        text=True,
        env=environment(changes),
        check=False,
    )


def interrupted(folder: Path, number: signal.Signals, *words: str) -> Outcome:
    """Run a command in a separate process, in a folder, and send a signal while it computes."""

    def allow_signals() -> None:
        """A process that was started in the background, or with nohup, passes on to its children
        that SIGINT is ignored.
        """
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    piped: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(
        [sys.executable, "-c", SLOW, *words], cwd=folder, preexec_fn=allow_signals, **piped
    ) as process:
        try:
            while not (folder / "ready").exists() and process.poll() is None:
                time.sleep(0.01)
            process.send_signal(number)
            # Both streams end when no process holds them any more.
            printed = process.communicate(timeout=60)
        finally:
            process.kill()
    return Outcome(process.returncode, *printed)


def environment(changes: Mapping[str, str]) -> dict[str, str]:
    """The environment of a command in a separate process."""
    return {**os.environ, **changes}


def dog_in(folder: Path) -> Path:
    """A copy of the dog's package in a folder; the folder of the package."""
    return Path(shutil.copytree(ROBOTS / "dog", folder / "dog"))


def vector(row, key):
    """The components of a vector in a row of a document's table."""
    return [row[f"{key}_{axis}"] for axis in "xyz"]
