"""A computation in a child process, within limits of time and memory.

The limits hold for whatever library it calls.

A fork of this process would hold for ever the locks that other threads hold at that moment, such as
those of a library. So the first computation starts a fresh interpreter, the server, which has one
thread: it imports the libraries once and forks for every computation, which then takes
milliseconds. It ends with this process.
"""

import atexit
import importlib
import os
import pickle
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from shockpc.text.paths import inputs

T = TypeVar("T")

SECONDS, MEMORY, ANSWER = 15, 2**30, 2**28
"""Time of the processor, memory beside that of the server [bytes], and size of the answer [bytes].
"""

LIMITS = f"{SECONDS} s, {MEMORY / 2**30:g} GB and an answer of {ANSWER // 2**20} MB"

_CODE = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    "from shockpc.robot.files.limited_process import serve; serve()"
)
_ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "MUJOCO_GL": "disable", "PYTHONHASHSEED": "0"}
"""Environment of the server: libraries start no threads, and load faster without windows; sets of
texts have the same order in every run.
"""


def in_child(
    work: Callable[[], T], libraries: Sequence[str] = (), seconds: int | None = None
) -> T | None:
    """The value of a function, computed in a separate process.

    The process has the folder and the environment of this one.

    What the function raises is raised here; that, its value and the function itself are picklable.
    What it prints is discarded.

    Args:
        work: the function.
        libraries: modules that it needs, which the server imports once, and this process at the
            same time.
        seconds: time of the processor; by default `SECONDS`.

    Returns: None if the child exceeds the limits or crashes.
    """
    folder = None
    with suppress(FileNotFoundError):  # where the folder no longer exists
        folder = os.getcwd()
    limit = SECONDS if seconds is None else seconds
    request = (folder, dict(os.environ), limit, MEMORY, pickle.dumps(work))
    data = _SERVER.answer(libraries, request)
    if not data:
        return None
    value, error, read = pickle.loads(data)
    inputs.update(read)
    if error is not None:
        raise error
    result: T = value
    return result


class _Server:
    """The server, as this process sees it.

    It is started when it is needed first, for one computation at a time.
    """

    _process: "subprocess.Popen[bytes] | None" = None

    def __init__(self) -> None:
        self._lock = threading.Lock()
        atexit.register(self._end)
        os.register_at_fork(after_in_child=self._forget)

    def answer(self, libraries: Sequence[str], request: tuple[Any, ...]) -> bytes:
        """The answer to a request; empty if there is none."""
        with self._lock:
            if self._process is not None and self._process.poll() is not None:
                self._end()  # something else has ended it
            process = self._process = self._process or _started()
            assert process.stdin is not None
            assert process.stdout is not None
            data = None
            try:
                with (
                    suppress(BrokenPipeError),
                    open(process.stdin.fileno(), "wb", closefd=False) as pipe,
                ):
                    pickle.dump((libraries, request), pipe)
                for library in libraries:
                    importlib.import_module(library)
                with (
                    open(process.stdout.fileno(), "rb", closefd=False) as pipe,
                    suppress(EOFError, pickle.UnpicklingError),
                ):
                    data = pickle.load(pipe)
            finally:
                if data is None:
                    self._end()
            return data or b""

    def _end(self) -> None:
        """End the server, and the child that computes."""
        if self._process is not None:
            with self._process as process:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
            self._process = None

    def _forget(self) -> None:
        """In a fork of this process: leave the server to the other."""
        self._lock = threading.Lock()
        if self._process is not None:
            for pipe in (self._process.stdin, self._process.stdout):
                assert pipe is not None
                pipe.close()
            self._process.returncode, self._process = 0, None


_SERVER = _Server()


def _started() -> "subprocess.Popen[bytes]":
    """A server.

    It encodes paths as this process does; in a separate group of processes, it is not interrupted
    with this one.
    """
    # As -I, but for the seed of hashes.
    isolated = ["-P", "-s", "-S", "-B", "-X", f"utf8={sys.flags.utf8_mode}"]
    command = [sys.executable, *isolated, "-c", _CODE]
    pipe = subprocess.PIPE
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    environment |= _ENVIRONMENT
    process = subprocess.Popen(
        command,
        bufsize=0,
        stdin=pipe,
        stdout=pipe,
        stderr=subprocess.DEVNULL,
        env=environment,
        process_group=0,
    )
    assert process.stdin is not None
    with suppress(BrokenPipeError):
        process.stdin.write(pickle.dumps(sys.path))
    return process


def serve() -> None:
    """Answer requests until standard input ends; this is the server."""
    answers = os.fdopen(os.dup(1), "wb")
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    with suppress(EOFError):
        while True:
            libraries, request = pickle.load(sys.stdin.buffer)
            for library in libraries:
                importlib.import_module(library)
            pickle.dump(_forked(*request), answers)
            answers.flush()


def _forked(*request: Any) -> bytes:
    """The answer of a child; empty if it exceeds the limits or crashes."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)  # so that writing more than is read ends
        _compute(writing, *request)
    os.close(writing)
    with open(reading, "rb") as pipe:
        data = pipe.read(ANSWER)
    _, status = os.waitpid(child, 0)
    return b"" if status else data


def _compute(
    writing: int,
    folder: str | None,
    environment: dict[str, str],
    seconds: int,
    memory: int,
    work: bytes,
) -> NoReturn:
    """Compute in the child, and write what comes of it."""
    code = 1
    try:
        signal.alarm(10 * seconds)  # of which a busy machine gives it a part
        os.environ.clear()
        os.environ.update(environment)
        if folder is not None:
            os.chdir(folder)
        _limit(seconds, memory)
        value = None
        error: Exception | None = None
        try:
            value = pickle.loads(work)()
        except Exception as raised:  # whatever it is, it is raised in the process that asked
            error = raised
        with open(writing, "wb") as pipe:
            pickle.dump((value, error, inputs), pipe)
        code = 0
    finally:
        os._exit(code)


def _limit(seconds: int, memory: int) -> None:
    """Limit this process.

    Args:
        seconds: time of the processor.
        memory: beside what is taken [bytes].
    """
    limits = {resource.RLIMIT_CPU: seconds, resource.RLIMIT_CORE: 0, resource.RLIMIT_FSIZE: 0}
    with suppress(OSError):  # elsewhere than on Linux, where memory cannot be limited
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
        limits[resource.RLIMIT_AS] = int(pages) * resource.getpagesize() + memory
    for limit, most in limits.items():
        _, hard = resource.getrlimit(limit)
        soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(limit, (soft, hard))
