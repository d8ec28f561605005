"""Thousands of hostile inputs through the command line: `python tests/fuzz.py 100000 [--from
NUMBER] [--workers N]`.

Each case is a fork of this process, in which everything is imported, and its command a fork of that
one, with limits of time and memory. Where this is root, all of them are nobody, who may read every
file and write in the folder of the case alone. What must hold: exit code 0, 2 or 3, or 1 from
`check`; no traceback, signal or hang; on failure one message and no new file; complete files; valid
JSON; no control character in what is printed; nothing read outside the open folders; every 50th
case gives the same bytes again.

Needs Linux, util-linux and what the tests need: `pip install ".[dev]"`; exit code 2 where that is
missing.

Ends with 1 if any of this does not hold, and prints the case; `--keep FOLDER --from NUMBER` writes
its files. After an interrupt it says with which --from it continues.
"""

import argparse
import collections
import contextlib
import gc
import io
import json
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
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

# one thread for each process
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")

try:
    from hostile import COMMANDS, FILES, OUTSIDE, STUDIES, TOKEN, UNFINISHED, Case, case

    from shockpc.cli import process
    from shockpc.cli.entry import main as run_command
except ModuleNotFoundError as missing:
    print(
        f"{missing.name} is not installed; in a clone of the repository: pip install '.[dev]'",
        file=sys.stderr,
    )
    sys.exit(2)

AGAIN = 50
"""Every so many cases one is repeated."""

VIOLATED = 100
"""What a case adds to the exit code of its command where something does not hold."""

SECONDS, WAIT, MEMORY = 40, 400, 3 * 2**30
"""What a case may take: time of the processor and by the clock [s], and bytes beside those that
this process takes already.
"""

NOBODY = (
    "--reuid=65534 --regid=65534 --clear-groups --inh-caps=-all,+dac_read_search "
    "--ambient-caps=-all,+dac_read_search"
)
"""Of root's rights only that of reading remains, as an interpreter may be in root's home."""


class Outcome(NamedTuple):
    """How a command ended: exit code (negative for a signal), streams, and the files that it made."""

    code: int
    out: bytes
    err: bytes
    files: dict[str, bytes]


def prepare(folder: Path) -> None:
    """Run every command once, so that forks have what is imported then, and keep the files of
    unfinished studies.
    """
    write(FILES, folder)
    with (
        contextlib.chdir(folder / "stick"),
        redirect_stdout(io.StringIO()),
        redirect_stderr(io.StringIO()) as messages,
    ):
        for line in COMMANDS:
            if "--resume" not in line and run_command(line.split()) not in (0, 1):
                sys.exit(f"shockpc {line}: {messages.getvalue()}")
        UNFINISHED.update(
            {
                str(path): path.read_bytes()
                for path in sorted(Path("parts").rglob("*"))
                if path.is_file()
            }
        )
    gc.freeze()


def write(files: dict[str, bytes], folder: Path) -> None:
    """Make the folder of a case anew; the files that it may name but not read are in `outside`
    beside it.
    """
    for name in ("stick", "outside", "home"):
        shutil.rmtree(folder / name, ignore_errors=True)
        (folder / name).mkdir(parents=True)
    for path, data in {
        **{f"stick/{name}": data for name, data in files.items()},
        **OUTSIDE,
    }.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
        # reading it sets the time of the last access, where the file system records that
        os.utime(folder / path, (0, 1))


def run(made: Case, folder: Path) -> Outcome:
    """Run the command of a case in a fork."""
    write(made.files, folder)
    if not (child := os.fork()):
        try:
            os._exit(_command(made.words, folder))
        finally:
            os._exit(99)
    _, status = os.waitpid(child, 0)
    with contextlib.suppress(ProcessLookupError):  # what it has started
        os.killpg(child, signal.SIGKILL)
    out, err = ((folder / stream).read_bytes() for stream in ("stdout", "stderr"))
    err = err.replace(f"/proc/{child}/".encode(), b"/proc/self/")  # each run has another number
    there = {
        str(path.relative_to(folder / "stick")): path
        for path in sorted((folder / "stick").rglob("*"))
        if path.is_file()
    }
    files = {name: path.read_bytes() for name, path in there.items() if name not in made.files}
    return Outcome(os.waitstatus_to_exitcode(status), out, err, files)


def _command(words: list[str], folder: Path) -> int:
    """Run a command in this process; its exit code."""
    os.setpgid(0, 0)
    for number, stream in ((0, os.devnull), (1, folder / "stdout"), (2, folder / "stderr")):
        os.dup2(os.open(stream, os.O_CREAT | os.O_RDWR | os.O_TRUNC), number)
    os.closerange(3, 64)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    process.prepare()
    sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
    os.environ |= dict.fromkeys(("HOME", "TMPDIR"), str(folder / "home"))
    tempfile.tempdir = None
    os.chdir(folder / "stick")
    sys.argv = ["shockpc", *words]
    taken = (
        int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        * resource.getpagesize()
    )
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
    resource.setrlimit(
        resource.RLIMIT_CPU, (int(time.process_time()) + SECONDS, resource.RLIM_INFINITY)
    )
    signal.alarm(WAIT)
    try:
        code = run_command(words)
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    return code


def violations(made: Case, outcome: Outcome, folder: Path) -> list[str]:
    """All that does not hold."""
    code, words = outcome.code, made.words
    # A check, or a study in which some landings have no solution, writes what it has.
    checks, failed = words[0] == "check" or (code == 3 and words[0] in STUDIES), code in (2, 3)
    out, err = outcome.out.decode(errors="replace"), outcome.err.decode(errors="replace")
    if code < 0:
        return [f"hang or signal: {signal.Signals(-code).name}"]
    if "Traceback" in err:
        return [f"traceback: {err.splitlines()[-2]}"]
    lines = [line for line in err.splitlines() if not line.startswith("shockpc: ")]
    # A scene, like the command line, may name any file.
    named = "outside" in " ".join(
        [*words, *(str(data) for name, data in made.files.items() if name.endswith(".toml"))]
    )
    seen = [path.name for path in (folder / "outside").iterdir() if path.stat().st_atime > 1]
    added = [
        path.name
        for path in (folder / "outside").iterdir()
        if path.read_bytes() != OUTSIDE.get(f"outside/{path.name}")
    ]
    # Documents hold names as they are.
    text = (
        out + err
        if not {"json", "csv"} & set(words)
        else "".join(sign for sign in out + err if ord(sign) < 0x7F)
    )
    # of several formats the last one is printed
    last = re.findall(r"--format (\S+)", " ".join(words))[-1:]
    documents = (
        {"stdout.json": outcome.out}
        if code == 0 and last == ["json"] and "--help" not in words
        else {}
    )
    holds = {
        f"exit code {code}": code in (0, 2, 3) or (code == 1 and words[0] == "check"),
        f"files after a failure: {[*outcome.files]}": checks or not (failed and outcome.files),
        "on failure not one message": checks or not failed or (not out and err.count("\n") == 1),
        f"no message: {lines[:1]}": not lines or "--explain" in words,
        "a message of more than 3000 characters": all(
            len(line) < 3000 for line in err.splitlines()
        ),
        "control characters": all(sign.isprintable() or sign == "\n" for sign in text),
        f"written outside the folder: {added}": not added,
        f"read outside the open folders: {seen}": named or not (seen or TOKEN in out + err),
        **{
            f"{name} is incomplete": complete(name, content)
            for name, content in (outcome.files | documents).items()
        },
    }
    return [what for what, held in holds.items() if not held]


def complete(name: str, content: bytes) -> bool:
    """Whether a file is what its name says, and no temporary one."""
    try:
        if name.endswith(".json"):
            json.loads(content, parse_constant=lambda _: float("no number"))
        elif name.endswith(".svg"):
            ElementTree.fromstring(content)
    except (ValueError, ElementTree.ParseError):
        return False
    end = (
        b"IEND\xaeB`\x82"
        if name.endswith(".png")
        else b"PAR1"
        if name.endswith(".parquet")
        else b"\n"
    )
    return content.endswith(end) and not re.search(r"(^|/)\.[^/]*\.[a-z0-9_]{8}(\.\w+)?$", name)


def check(number: int) -> int:
    """Run a case and print what does not hold; the exit code of its command, with `VIOLATED` added
    if anything is printed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # only the first process answers Ctrl-C
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        made = case(number)
        first = run(made, Path(name))
        found = violations(made, first, Path(name))
        # which print run times
        if not found and number % AGAIN == 0 and not {"--explain", "bench"} & set(made.words):
            found = ["other bytes on repetition"] * (run(made, Path(name)) != first)
    for violation in found:
        print(f"case {number}: {violation}", flush=True)
    return max(first.code, 0) + VIOLATED * bool(found)


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description="Run commands on hostile inputs.")
    options.add_argument("count", type=int, nargs="?", default=100_000, help="cases [100000]")
    options.add_argument(
        "--from",
        dest="first",
        type=int,
        default=0,
        metavar="NUMBER",
        help="number of the first case [0]",
    )
    options.add_argument(
        "--workers", type=int, default=os.cpu_count(), help="cases at once [one for each core]"
    )
    options.add_argument(
        "--keep",
        type=Path,
        metavar="FOLDER",
        help="write the files of the first case there, and run nothing",
    )
    given = options.parse_args(words)
    if not os.geteuid() and not given.keep:
        os.execvp("setpriv", ["setpriv", *NOBODY.split(), sys.executable, *sys.argv])
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        os.environ["HOME"] = name
        prepare(Path(name))
    if given.keep:
        made = case(given.first)
        write(made.files, given.keep)
        print(f"cd {given.keep}/stick; shockpc", *map(repr, made.words))
        return 0
    # The threads of libraries are idle, and a fork that waits for one of them would be reported.
    warnings.filterwarnings("ignore", "This process", DeprecationWarning)
    ended: collections.Counter[int] = collections.Counter()
    running, start, following = 0, time.monotonic(), given.first
    try:
        while running or following < given.first + given.count:
            if running < given.workers and following < given.first + given.count:
                if not os.fork():
                    os._exit(check(following))
                running, following = running + 1, following + 1
            else:
                ended[os.waitstatus_to_exitcode(os.wait()[1])] += 1
                running -= 1
                if ended.total() % 500 == 0:
                    print(
                        f"{ended.total()} of {given.count}, {time.monotonic() - start:.0f} s",
                        file=sys.stderr,
                        flush=True,
                    )
    except KeyboardInterrupt:
        print(
            f"interrupted; continue with: --from {following - running} "
            f"{given.first + given.count - following + running}"
        )
    violated = sum(times for code, times in ended.items() if code >= VIOLATED)
    codes = ", ".join(f"{code % VIOLATED} {times} times" for code, times in sorted(ended.items()))
    print(
        f"{ended.total()} cases, {violated} violated, {time.monotonic() - start:.0f} s; exit "
        f"codes: {codes}"
    )
    return 1 if violated or ended.total() < given.count else 0


if __name__ == "__main__":
    sys.exit(main())
