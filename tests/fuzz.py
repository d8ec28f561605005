"""Thousands of hostile inputs through the command line: `python tests/fuzz.py 100000 [--from NUMBER] [--workers N]`.

Cases run one after the other in forks of this process, in which everything is imported; every tenth has a fork of its own. Where
this is root, the forks are nobody, who may write in the folder of the case alone. What must hold: exit code 0, 2 or 3, or 1 from
`check`; no traceback, signal or hang; on failure one message and no new file; complete files; valid JSON; no control character in
what is printed; nothing read outside the open folders; every 50th case gives the same bytes again.

Needs Linux and what the tests need: `pip install ".[dev]"`; exit code 2 where that is missing.

Ends with 1 if any of this does not hold, and prints the case; `--keep FOLDER --from NUMBER` writes its files. After an interrupt it
says with which --from it continues.
"""

import argparse
import collections
import contextlib
import ctypes
import functools
import gc
import io
import json
import multiprocessing
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from contextlib import redirect_stderr, redirect_stdout
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")  # one thread for each process

try:
    from hostile import COMMANDS, FILES, SECRETS, STUDIES, TOKEN, UNFINISHED, Case, case

    from shockpc.cli import process
    from shockpc.cli.entry import main as run_command
except ModuleNotFoundError as missing:
    print(f"{missing.name} is not installed; in a clone of the repository: pip install '.[dev]'", file=sys.stderr)
    sys.exit(2)

BLOCK = 20
"""Cases that a process takes at once."""

ALONE, AGAIN, LAST = 25, 50, 200
"""Every so many cases one has a fork of its own, one is repeated; and a fork ends after so many."""

NOBODY = 65534
"""Number of the user without privileges."""

SECONDS, WAIT, MEMORY = 20, 200.0, 3 * 2**30
"""What a case may take: time of the processor and by the clock [s], and bytes beside those that this process takes already."""


class Fork(NamedTuple):
    """A process that runs commands: its number, the connection over which it gets them, and those that it got."""

    process: int
    connection: Connection
    ran: list[list[str]]


class Outcome(NamedTuple):
    """How a case ended: exit code (negative for a signal, None for a hang), streams, and the files that it made."""

    code: int | None
    out: bytes
    err: bytes
    files: dict[str, bytes]


class Found(NamedTuple):
    """How a case ended, and what does not hold."""

    number: int
    ended: str
    violations: tuple[str, ...]


@functools.cache
def prepare() -> None:
    """Import everything that commands import when they run, so that forks have it."""
    with (
        tempfile.TemporaryDirectory(prefix="fuzz-") as name,
        redirect_stdout(io.StringIO()),
        redirect_stderr(io.StringIO()) as messages,
    ):
        Case(FILES, []).write(Path(name, "stick"))
        with contextlib.chdir(Path(name, "stick")):
            lines = [f"analyze robot.{kind} --contact foot --out out --format" for kind in ("urdf", "xml")]
            lines = [f"{line} {format_}" for line in lines for format_ in ("json", "csv", "markdown", "table")]
            for line in [*lines, "check budgets.toml --format junit", *COMMANDS]:
                if "--resume" not in line and run_command(line.split()) not in (0, 1):
                    sys.exit(f"shockpc {line}: {messages.getvalue()}")
            UNFINISHED.update({str(path): path.read_bytes() for path in sorted(Path("parts").rglob("*")) if path.is_file()})
    gc.freeze()


def check(number: int) -> Found:
    """Run a case and judge how it ended."""
    made = case(number)
    alone = number % ALONE == 0 or "--jobs" in made.words
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        first, violations = _judged(made, Path(name), alone)
        if violations and not alone:
            violations = _judged(made, Path(name), alone=True)[1] or [f"after other cases only: {what}" for what in violations]
        elif number % AGAIN == 0 and not {"--explain", "bench"} & set(made.words):  # which print run times
            violations += [] if _judged(made, Path(name), alone=True)[0] == first else ["other bytes on repetition"]
    return Found(number, str(first.code), tuple(violations))


def _judged(made: Case, folder: Path, alone: bool) -> tuple[Outcome, list[str]]:
    """Run a case: how it ended, and what does not hold."""
    outcome = _run(made, folder, alone)
    violations = _violations(made, outcome, folder)
    shutil.rmtree(folder / "stick")
    return outcome, violations


_forks: list[Fork] = []
"""The fork of this process, if it has one."""


def _run(made: Case, folder: Path, alone: bool) -> Outcome:
    """Run the command of a case in a fork; `alone`: in one of its own."""
    place, outside = folder / "stick", folder / "outside"
    made.write(place)
    for private in (outside, folder / "home"):
        private.mkdir(exist_ok=True)
    for name, data in SECRETS.items():
        (outside / name).write_bytes(data)
        os.utime(outside / name, (0, 1))  # reading it sets the time of the last access, where the file system records that
    before = set(place.rglob("*"))
    if _forks and (alone or len(_forks[0].ran) >= LAST):
        _end_fork()
    if not _forks:
        _forks.append(_start_fork())
    child, connection, ran = _forks[0]
    ran.append(made.words)
    connection.send((made.words, str(folder)))
    try:
        code = connection.recv() if connection.poll(WAIT) else None
        if alone or code is None:
            _end_fork()
    except EOFError:
        code = _end_fork()
    out, err = ((folder / stream).read_bytes() for stream in ("stdout", "stderr"))
    err = err.replace(f"/proc/{child}/".encode(), b"/proc/self/")  # each run has another number
    new = sorted(path for path in set(place.rglob("*")) - before if path.is_file())
    files = {str(path.relative_to(place)): path.read_bytes() for path in new}
    return Outcome(None if code == -signal.SIGXCPU else code, out, err, files)


def _start_fork() -> Fork:
    """Start a process that runs commands."""
    ours, theirs = multiprocessing.Pipe()
    child = os.fork()
    if child:
        theirs.close()
        return Fork(child, ours, [])
    try:
        os.setpgid(0, 0)
        multiprocessing.current_process()._config["daemon"] = False  # a worker of the pool may not have processes of its own
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        number = os.dup(theirs.fileno()) if theirs.fileno() == 3 else theirs.fileno()
        connection = Connection(os.dup2(number, 3))
        os.closerange(4, 64)
        process.prepare()
        warnings.simplefilter("ignore")
        sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
        taken = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
        while True:
            connection.send(_command(*connection.recv()))
    finally:
        os._exit(99)


def _end_fork() -> int:
    """End the fork and what it started; its exit code, or less the signal that ended it."""
    child, connection, _ = _forks.pop()
    connection.close()
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _command(words: list[str], folder: str) -> int:
    """Run a command in this process; its exit code."""
    for number, stream in enumerate(("stdout", "stderr"), 1):
        opened = os.open(Path(folder, stream), os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
        os.dup2(opened, number)
        os.close(opened)
    os.environ |= dict.fromkeys(("HOME", "TMPDIR"), str(Path(folder, "home")))
    tempfile.tempdir = None
    resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + SECONDS, resource.RLIM_INFINITY))
    os.chdir(Path(folder, "stick"))
    process.received.clear()
    sys.argv = ["shockpc", *words]
    try:
        code = run_command(words)
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    os.chdir("/")
    return code


def _drop_privileges() -> None:
    """Become nobody, where this is root. Of its rights only that of reading remains, as an interpreter may be in root's home."""
    if os.geteuid():
        return
    library, read_search = ctypes.CDLL(None, use_errno=True), 2  # CAP_DAC_READ_SEARCH
    library.prctl(8, 1, 0, 0, 0)  # PR_SET_KEEPCAPS
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)
    kept = (ctypes.c_uint32 * 6)(*[1 << read_search] * 3, 0, 0, 0)  # effective, permitted, inheritable
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)  # _LINUX_CAPABILITY_VERSION_3
    if library.capset(header, kept) or library.prctl(47, 2, read_search, 0, 0):  # PR_CAP_AMBIENT, PR_CAP_AMBIENT_RAISE
        raise OSError(ctypes.get_errno(), "the privileges cannot be dropped")


def _violations(made: Case, outcome: Outcome, folder: Path) -> list[str]:
    """All that does not hold."""
    code, words = outcome.code, made.words
    # A check, or a study in which some landings have no solution, writes what it has.
    checks, failed = words[0] == "check" or (code == 3 and words[0] in STUDIES), code in (2, 3)
    out, err = outcome.out.decode(errors="replace"), outcome.err.decode(errors="replace")
    if code is None or code < 0:
        return [f"hang or signal: {code}"]
    if "Traceback" in err:
        return [f"traceback: {err.splitlines()[-2]}"]
    lines = [line for line in err.splitlines() if not line.startswith("shockpc: ")]
    # A scene, like the command line, may name any file.
    named = re.search(
        "outside|link", " ".join([*words, *(str(data) for name, data in made.files.items() if name.endswith(".toml"))])
    )
    seen = [path.name for path in (folder / "outside").iterdir() if path.stat().st_atime > 1 and path.name in SECRETS]
    added = [path.name for path in (folder / "outside").iterdir() if path.read_bytes() != SECRETS.get(path.name)]
    # Documents hold names as they are.
    text = out + err if not {"json", "csv"} & set(words) else "".join(sign for sign in out + err if ord(sign) < 0x7F)
    last = re.findall(r"--format (\S+)", " ".join(words))[-1:]  # of several formats the last one is printed
    documents = {"stdout.json": outcome.out} if code == 0 and last == ["json"] and "--help" not in words else {}
    holds = {
        f"exit code {code}": code in (0, 2, 3) or (code == 1 and words[0] == "check"),
        f"files after a failure: {[*outcome.files]}": checks or not (failed and outcome.files),
        "on failure not one message": checks or not failed or (not out and err.count("\n") == 1),
        f"no message: {lines[:1]}": not lines or "--explain" in words,
        "a message of more than 3000 characters": all(len(line) < 3000 for line in err.splitlines()),
        "control characters": all(sign.isprintable() or sign == "\n" for sign in text),
        f"written outside the folder: {added}": not added,
        f"read outside the open folders: {seen}": bool(named) or not (seen or TOKEN in out + err),
        **{f"{name} is incomplete": _complete(name, content) for name, content in (outcome.files | documents).items()},
    }
    return [what for what, held in holds.items() if not held]


def _complete(name: str, content: bytes) -> bool:
    """Whether a file is what its name says, and no temporary one."""
    try:
        if name.endswith(".json"):
            json.loads(content, parse_constant=lambda _: float("no number"))
        elif name.endswith(".svg"):
            ElementTree.fromstring(content)
    except (ValueError, ElementTree.ParseError):
        return False
    end = b"IEND\xaeB`\x82" if name.endswith(".png") else b"PAR1" if name.endswith(".parquet") else b"\n"
    return content.endswith(end) and not re.search(r"(^|/)\.[^/]*\.[a-z0-9_]{8}(\.\w+)?$", name)


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description="Run commands on hostile inputs.")
    options.add_argument("count", type=int, nargs="?", default=100_000, help="cases [100000]")
    options.add_argument("--from", dest="first", type=int, default=0, metavar="NUMBER", help="number of the first case [0]")
    options.add_argument("--workers", type=int, default=os.cpu_count(), help="processes [one for each core]")
    options.add_argument("--keep", type=Path, metavar="FOLDER", help="write the files of the first case there, and run nothing")
    given = options.parse_args(words)
    prepare()
    if given.keep:
        case(given.first).write(given.keep)
        print(f"cd {given.keep}; shockpc", *map(repr, case(given.first).words))
        return 0
    ended, violated, start = collections.Counter(), 0, time.monotonic()
    signal_of_parent = signal.signal(signal.SIGINT, signal.SIG_IGN)  # inherited: only this process answers Ctrl-C
    with multiprocessing.get_context("fork").Pool(given.workers, _drop_privileges) as pool:
        signal.signal(signal.SIGINT, signal_of_parent)
        try:
            for found in pool.imap(check, range(given.first, given.first + given.count), BLOCK):
                ended[found.ended] += 1
                violated += bool(found.violations)
                for violation in found.violations:
                    print(f"case {found.number}: {violation}", flush=True)
                done = ended.total()
                if done % 500 == 0:
                    left = (given.count - done) * (time.monotonic() - start) / done / 60.0
                    print(f"{done} of {given.count}, {violated} violated, {left:.0f} min left", file=sys.stderr, flush=True)
        except KeyboardInterrupt:
            print(f"interrupted; continue with: --from {given.first + ended.total()} {given.count - ended.total()}")
            pool.terminate()
    codes = ", ".join(f"{code} {times} times" for code, times in sorted(ended.items()))
    print(f"{ended.total()} cases, {violated} violated, {time.monotonic() - start:.0f} s; exit codes: {codes}")
    return 1 if violated or ended.total() < given.count else 0


if __name__ == "__main__":
    sys.exit(main())
