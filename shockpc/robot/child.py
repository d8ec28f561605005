"""A computation in a child process, within limits of time and memory that hold for whatever library it calls."""

import os
import pickle
import resource
import signal
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from shockpc.text.paths import inputs

T = TypeVar("T")

SECONDS, MEMORY, ANSWER = 15, 2**30, 2**28
"""Time of the processor, memory beside that of this process [bytes], and size of the answer [bytes]."""

LIMITS = f"{SECONDS} s, {MEMORY / 2**30:g} GB and an answer of {ANSWER // 2**20} MB"


def in_child(work: Callable[[], T]) -> T | None:
    """The value of a function, computed in a fork of this process, which has the libraries loaded already.

    What the function raises is raised here; its value and that are picklable. What it prints is discarded.

    Returns: None if the child exceeds the limits or crashes.
    """
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # about other threads, none of which the child needs
        child = os.fork()
    if not child:
        _answer(work, writing)
    os.close(writing)
    try:
        with open(reading, "rb") as pipe:
            data = pipe.read(ANSWER)
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        _, status = os.waitpid(child, 0)
    if status:
        return None
    value, error, read = pickle.loads(data)
    inputs.update(read)
    if error is not None:
        raise error
    found: T = value
    return found


def _answer(work: Callable[[], Any], writing: int) -> NoReturn:
    code = 1
    try:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(10 * SECONDS)  # of which a busy machine gives it a part
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        limits = {resource.RLIMIT_CPU: SECONDS, resource.RLIMIT_CORE: 0, resource.RLIMIT_FSIZE: 0}
        with suppress(OSError):  # elsewhere than on Linux, where memory cannot be limited
            taken = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
            limits[resource.RLIMIT_AS] = taken + MEMORY
        for limit, most in limits.items():
            hard = resource.getrlimit(limit)[1]
            resource.setrlimit(limit, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
        value, error = None, None
        try:
            value = work()
        except Exception as raised:
            error = raised
        with open(writing, "wb") as pipe:
            pickle.dump((value, error, inputs), pipe)
        code = 0
    finally:
        os._exit(code)
