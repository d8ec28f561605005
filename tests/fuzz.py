"""Thousands of hostile inputs through the command line: `python tests/fuzz.py 100000 [--from NUMBER] [--workers N] [--keep FOLDER]`.

Each case runs in a fork of this process, in which everything is imported, so that a crash ends one case only. Ends with 1 if a
case is violated; after an interrupt it says with which --from it continues.

What must hold: exit code 0, 2 or 3, or 1 from `check`; no traceback, signal or hang; on failure one message and no new file;
complete files only; JSON that is valid; no control character in what is printed; nothing read outside the open folders; every 50th
case gives the same bytes again.
"""

import argparse
import collections
import json
import multiprocessing
import os
import re
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")  # one thread for each process

import hostile

from shockpc.cli.entry import entry
from shockpc.cli.main import main as run_command

BLOCK = 20
"""Cases that a process takes at once."""

SECONDS = 20.0
MEMORY = 3 * 2**30
"""Limits of a case, beside what this process takes already [s, bytes]."""


class Outcome(NamedTuple):
    """How a case ended: exit code (negative for a signal, None for a hang), streams, and the files that it made."""

    code: int | None
    out: bytes
    err: bytes
    files: dict[str, bytes]


class Found(NamedTuple):
    """A case, how it ended and all that is wrong with that."""

    number: int
    ended: str
    violations: tuple[str, ...]


def prepare() -> None:
    """Import everything that commands import when they run."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    hostile.write(
        hostile.Case({name: data.encode() if isinstance(data, str) else data for name, data in hostile.FILES.items()}, []), folder
    )
    before = os.getcwd()
    os.chdir(folder / "stick")
    streams = sys.stdout, sys.stderr
    with open(os.devnull, "w", encoding="utf-8") as sys.stdout:
        for words in (
            "analyze robot.urdf --contact foot --out out",
            "analyze robot.xml --contact foot --out out",
            "robots robot.urdf",
            "check budgets.toml",
        ):
            for format_ in ("json", "markdown") if "--out" in words or "check" in words else ("",):
                try:
                    run_command([*words.split(), *(("--format", format_) if format_ else ())])
                except SystemExit as end:
                    assert end.code == 0, words
    sys.stdout, sys.stderr = streams
    os.chdir(before)
    shutil.rmtree(folder)


def check(number: int) -> Found:
    """Run a case and judge how it ended."""
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        folder = Path(name)
        case, outcome = hostile.case(number), None
        for _ in range(2 if number % 50 == 0 else 1):
            shutil.rmtree(folder / "stick", ignore_errors=True)
            hostile.write(case, folder)
            violations = [] if outcome is None else list(_different(outcome, outcome := _run(case, folder)))
            outcome = outcome or _run(case, folder)
            violations += _violations(case, outcome, folder)
    first = outcome.err.decode(errors="replace").strip().splitlines()[-1:] or [""]
    return Found(
        number,
        f"{outcome.code}",
        tuple(f"{violation}  [{' '.join(case.words)[:200]}] {first[0][:300]!r}" for violation in violations),
    )


def _run(case: hostile.Case, folder: Path) -> Outcome:
    """Run the command of a case in a fork."""
    place = folder / "stick"
    outside = folder / "outside"
    outside.mkdir(exist_ok=True)
    for name, data in hostile.SECRETS.items():
        (outside / name).write_bytes(data.encode() if isinstance(data, str) else data)
        os.utime(outside / name, (0, 1))  # reading it sets the time of the last access, where the file system records that
    before = set(place.rglob("*"))
    streams = [os.open(folder / stream, os.O_CREAT | os.O_RDWR | os.O_TRUNC) for stream in ("stdout", "stderr")]
    child = os.fork()
    if not child:
        _become(case.words, place, streams)
    done = os.pidfd_open(child)
    in_time = bool(select.select([done], [], [], SECONDS)[0])
    os.close(done)
    try:
        os.killpg(child, signal.SIGKILL)  # what it started as well
    except ProcessLookupError:
        pass
    _, status = os.waitpid(child, 0)
    out, err = (_content(stream) for stream in streams)
    made = {str(path.relative_to(place)): path.read_bytes() for path in sorted(set(place.rglob("*")) - before) if path.is_file()}
    return Outcome(os.waitstatus_to_exitcode(status) if in_time else None, out, err, made)


def _become(words: list[str], place: Path, streams: list[int]) -> None:
    """Make this process the command."""
    try:
        os.setpgid(0, 0)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        for number, stream in enumerate(streams, start=1):
            os.dup2(stream, number)
        os.closerange(3, 64)
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
        taken = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
        os.chdir(place)
        sys.argv = ["shockpc", *words]
        entry()
    finally:
        os._exit(99)


def _content(stream: int) -> bytes:
    """What was written to a stream."""
    content = os.pread(stream, os.fstat(stream).st_size, 0)
    os.close(stream)
    return content


def _violations(case: hostile.Case, outcome: Outcome, folder: Path) -> list[str]:
    """All that must not be."""
    code, out, err, made = outcome
    text, messages = out.decode(errors="replace"), err.decode(errors="replace")
    found = []
    if code is None:
        return [f"hang: not done after {SECONDS:g} s"]
    if code < 0:
        return [f"signal {signal.Signals(-code).name}"]
    if code not in (0, 2, 3) and not (code == 1 and case.words[0] == "check"):
        found.append(f"exit code {code}")
    if "Traceback" in messages:
        found.append(f"traceback: {[line for line in messages.splitlines() if line][-2]}")
    if code in (2, 3):
        if made and case.words[0] != "check":
            found.append(f"files after a failure: {sorted(made)}")
        if code == 2 and "Traceback" not in messages and (messages.count("\n") != 1 or out and case.words[0] != "check"):
            found.append("not one message")
    if (
        any(not line.startswith("shockpc: ") for line in messages.splitlines())
        and "Traceback" not in messages
        and "--explain" not in case.words
    ):
        found.append(
            f"a line that is no message: {next(line for line in messages.splitlines() if not line.startswith('shockpc: '))[:200]!r}"
        )
    if len(messages) > 20_000 or any(len(line) > 3000 for line in messages.splitlines()):
        found.append("a message of more than 3000 characters")
    document = code in (0, 1) and "json" in case.words or "csv" in case.words  # holds names as they are
    for stream in (text, messages):
        odd = {sign for sign in stream if not sign.isprintable() and sign != "\n" and not (document and ord(sign) >= 0x80)}
        if odd:
            found.append(f"unprintable characters {sorted(odd)}")
        if hostile.TOKEN in stream:
            found.append("the content of a file outside the open folders")
    named = " ".join([*case.words, *(str(data) for name, data in case.files.items() if name.endswith(".toml"))])
    seen = [
        path.name for path in (folder / "outside").iterdir() if path.stat().st_atime > 1 and not re.search("outside|link", named)
    ]
    if seen:
        found.append(f"read outside the open folders: {seen}")
    documents = dict(made)
    if code == 0 and "json" in case.words and "--out" not in case.words[case.words.index("json") - 1 :]:
        documents["stdout.json"] = out
    for name, content in documents.items():
        if fault := _fault(name, content):
            found.append(f"{name}: {fault}")
    return found


def _fault(name: str, content: bytes) -> str:
    """What is wrong with a file that was written; empty if nothing is."""
    if Path(name).name.startswith(".") and Path(name).name != ".shockpc-files":
        return "a temporary file is left"
    if hostile.TOKEN.encode() in content:
        return "the content of a file outside the open folders"
    try:
        if name.endswith(".json"):
            json.loads(content, parse_constant=lambda word: float("x" + word))
        elif name.endswith(".svg"):
            ElementTree.fromstring(content)
        elif name.endswith(".png") and not content.endswith(b"IEND\xaeB`\x82"):
            return "incomplete"
        elif not content.endswith(b"\n") and not name.endswith(".png"):
            return "incomplete"
    except (ValueError, ElementTree.ParseError) as error:
        return f"not valid: {error}"
    return ""


def _different(one: Outcome, two: Outcome) -> list[str]:
    """Results that differ between two runs of a case."""
    same = [one.code == two.code, one.out == two.out, one.files == two.files]
    return [f"not repeatable: {what}" for what, held in zip(("exit code", "output", "files"), same, strict=True) if not held]


def main() -> int:
    options = argparse.ArgumentParser(description="Run commands on hostile inputs.")
    options.add_argument("count", type=int, nargs="?", default=100_000, help="cases [100000]")
    options.add_argument("--from", dest="first", type=int, default=0, metavar="NUMBER", help="number of the first case [0]")
    options.add_argument("--workers", type=int, default=os.cpu_count(), help="processes [one for each core]")
    options.add_argument("--keep", type=Path, metavar="FOLDER", help="write the files of the first case there, and run nothing")
    given = options.parse_args()
    if given.keep:
        hostile.write(case := hostile.case(given.first), given.keep)
        print(f"cd {given.keep}/stick; shockpc", *map(repr, case.words))
        return 0
    prepare()
    codes, violated, start = collections.Counter(), 0, time.monotonic()
    signal_of_parent = signal.signal(signal.SIGINT, signal.SIG_IGN)  # inherited: only this process answers Ctrl-C
    with multiprocessing.get_context("fork").Pool(given.workers) as pool:
        signal.signal(signal.SIGINT, signal_of_parent)
        try:
            for found in pool.imap(check, range(given.first, given.first + given.count), BLOCK):
                codes[found.ended] += 1
                violated += bool(found.violations)
                for violation in found.violations:
                    print(f"case {found.number}: {violation}", flush=True)
                done = codes.total()
                if done % 500 == 0 and sys.stderr.isatty():
                    left = (given.count - done) * (time.monotonic() - start) / done / 60.0
                    print(
                        f"\r{done} of {given.count}, {violated} violated, {left:.0f} min left", end="", file=sys.stderr, flush=True
                    )
        except KeyboardInterrupt:
            print(f"interrupted; continue with: --from {given.first + codes.total()} {given.count - codes.total()}")
            pool.terminate()
    print(f"{codes.total()} cases in {time.monotonic() - start:.0f} s, {violated} violated; exit codes:", end=" ")
    print(", ".join(f"{code} {times} times" for code, times in sorted(codes.items())))
    return 1 if violated or codes.total() < given.count else 0


if __name__ == "__main__":
    sys.exit(main())
