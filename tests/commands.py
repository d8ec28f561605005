"""Commands run as a user types them, in this process, with what they print on either stream."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import pytest

from shockpc.cli.main import main

ROBOTS = Path(__file__).parent / "robots"

STICK = """<?xml version="1.0"?>
<robot name="stick">
  <link name="body">
    <inertial>
      <origin xyz="0.01 0 0.05"/>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/>
    </inertial>
  </link>
  <link name="shin">
    <inertial>
      <origin xyz="0 0 -0.2"/>
      <mass value="0.5"/>
      <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0002"/>
    </inertial>
  </link>
  <link name="foot"/>
  <joint name="knee" type="revolute">
    <parent link="body"/>
    <child link="shin"/>
    <axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="10" velocity="10"/>
  </joint>
  <joint name="ankle" type="fixed">
    <origin xyz="0 0 -0.4"/>
    <parent link="shin"/>
    <child link="foot"/>
  </joint>
</robot>
"""
"""A body on a shin, with a foot at its end."""


class Outcome(NamedTuple):
    """How a command ended, and what it printed."""

    code: int
    out: str
    err: str


def run(capfd: pytest.CaptureFixture[str], *words: object) -> Outcome:
    """Run a command in this process. Both streams are read as files, so that what a C++ library prints is read too."""
    capfd.readouterr()
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    out, err = capfd.readouterr()
    assert isinstance(end.value.code, int)
    return Outcome(end.value.code, out, err)


def good(capfd: pytest.CaptureFixture[str], *words: object) -> str:
    """Run a command that has to succeed and to print nothing on standard error; what it prints."""
    outcome = run(capfd, *words)
    assert outcome._replace(out="") == Outcome(0, "", ""), outcome.err
    return outcome.out


def python(code: str, *words: str, **changes: str) -> subprocess.CompletedProcess[str]:
    """Run Python code in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, env=environment(changes), check=False
    )


def environment(changes: Mapping[str, str]) -> dict[str, str]:
    """The environment of a command in a process of its own."""
    return {**os.environ, **changes}


def dog_in(folder: Path) -> Path:
    """A copy of the dog's package in a folder; the folder of the package."""
    return Path(shutil.copytree(ROBOTS / "dog", folder / "dog"))
