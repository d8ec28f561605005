"""Computations in a child process: what comes back, the limits, and that no thread of this process
can hold one up.
"""

import functools
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from robot_texts import body, floating, loaded, mjcf

from shockpc.robot.files import limited_process
from shockpc.robot.files.limited_process import in_child

TEXT = mjcf(floating(body("b")))


def test_values_and_errors_come_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """In the folder and the environment of this process as they are, with nothing printed."""
    assert in_child(functools.partial(sum, [1, 2])) == 3
    assert in_child(functools.partial(print, "much")) is None
    with pytest.raises(ValueError, match="invalid literal"):
        in_child(functools.partial(int, "x"))
    monkeypatch.setenv("SHOCKPC_NEW", "1")
    monkeypatch.chdir(tmp_path)
    assert in_child(functools.partial(os.getenv, "SHOCKPC_NEW")) == "1"
    assert in_child(os.getcwd) == str(tmp_path)


@pytest.mark.parametrize(
    "work", [functools.partial(os._exit, 3), os.abort, functools.partial(bytes, 2**29)]
)
def test_a_crash_or_a_large_answer_is_none(work: Callable[[], object]):
    """And the next one is computed."""
    assert in_child(work) is None
    assert in_child(functools.partial(sum, [1, 2])) == 3


def test_memory_and_time_are_limited(monkeypatch: pytest.MonkeyPatch):
    """1 GB more than the libraries take; and ten times the time of the processor, on the clock."""
    with pytest.raises(MemoryError):
        in_child(functools.partial(bytearray, 2**31))
    monkeypatch.setattr(limited_process, "SECONDS", 1)
    begin = time.monotonic()
    assert in_child(functools.partial(pow, 3, 10**9)) is None
    assert time.monotonic() - begin < 11.0


def test_this_process_is_not_forked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Its threads may hold locks; the process that is forked has one thread."""
    monkeypatch.setattr(
        os, "fork", lambda: pytest.fail("a fork of a process that may hold threads")
    )
    assert loaded(tmp_path, TEXT, "dog.xml").mass > 0.0
    assert limited_process._SERVER._process is not None
    if sys.platform == "linux":
        assert len(os.listdir(f"/proc/{limited_process._SERVER._process.pid}/task")) == 1


def test_several_threads_load_robots(tmp_path: Path):
    """One after the other."""
    masses, folders = [], [tmp_path / str(k) for k in range(4)]
    for folder in folders:
        folder.mkdir()
    threads = [
        threading.Thread(target=lambda f=f: masses.append(loaded(f, TEXT, "dog.xml").mass))
        for f in folders
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(masses) == 4
    assert len(set(masses)) == 1


def test_a_server_that_was_ended_is_started_again():
    """As by the operating system when memory is short."""
    assert in_child(functools.partial(sum, [1])) == 1
    process = limited_process._SERVER._process
    assert process is not None
    process.send_signal(signal.SIGKILL)
    while process.poll() is None:
        time.sleep(0.01)
    assert in_child(functools.partial(sum, [1, 2])) == 3


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_a_fork_of_this_process_has_a_server_of_its_own():
    """And does not end this one's."""
    assert in_child(functools.partial(sum, [1])) == 1
    forked = os.fork()
    if not forked:
        code = 1
        try:
            code = 0 if in_child(functools.partial(sum, [1, 2])) == 3 else 1
            limited_process._SERVER._end()
        finally:
            os._exit(code)
    assert os.waitpid(forked, 0)[1] == 0
    assert in_child(functools.partial(sum, [1, 2])) == 3
