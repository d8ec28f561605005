"""Executors: the same results wherever they are computed, and one message when a process dies."""

import os
import socket
import subprocess
import sys
import threading
import time

import pytest

from shockpc.evaluation import executor as executor_module
from shockpc.evaluation.executor import executor, in_order
from shockpc.text.cache import version_of_code
from shockpc.text.errors import StudyError
from shockpc.text.paths import inputs


def square(x):
    return x * x


def die(_):
    os._exit(1)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_the_same_wherever_they_are_computed(jobs):
    with executor(jobs) as pool:
        assert list(in_order(pool, square, range(9), ahead=3)) == [k * k for k in range(9)]


def test_one_process_computes_what_is_taken_and_no_more():
    seen = []
    results = in_order(None, seen.append, range(5))
    next(results)
    assert seen == [0]


def test_death_of_a_process_is_one_message():
    with pytest.raises(StudyError, match="--jobs 1"), executor(2) as pool:
        list(pool.map(die, range(2)))


def interrupted():
    """What a Ctrl-C does to a study whose processes have a minute's work each."""
    with executor(2) as pool:
        for _ in range(4):
            pool.submit(time.sleep, 60.0)
        raise KeyboardInterrupt


def test_interrupt_ends_what_still_runs():
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - start < 30.0


@pytest.mark.parametrize(
    "answer", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n" * 9], ids=["silent", "other"]
)
def test_a_server_that_is_no_scheduler_is_one_message(monkeypatch, answer):
    """Also one that accepts the connection and says nothing, or what is read as the size of a huge
    message.
    """
    monkeypatch.setattr("shockpc.evaluation.executor.PATIENCE", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as server:
        held = []

        def serve():
            held.append(server.accept()[0])
            held[0].sendall(answer)

        threading.Thread(target=serve, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        start = time.monotonic()
        with pytest.raises(StudyError, match="no Dask scheduler answers at"), executor(1, address):
            pass
    assert time.monotonic() - start < 30.0
    held[0].close()


KILLED = """
import time
from shockpc.evaluation.executor import executor
with executor(2) as pool:
    list(pool.map(abs, range(9)))
    for _ in range(4):
        pool.submit(time.sleep, 60.0)
    print("ready", flush=True)
    time.sleep(60.0)
"""


def test_workers_end_with_a_killed_parent():
    """They hold its standard output, which ends when the last of them has ended."""
    with subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"ready\n"
        process.kill()
        start = time.monotonic()
        assert process.stdout.read() == b""
        assert time.monotonic() - start < 20.0


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (None, ('needs the package "distributed"', "pip install distributed pyarrow")),
        (
            "import dask_that_is_lost",
            ("installed but cannot be imported", "No module named 'dask_that_is_lost'"),
        ),
        (
            "raise ImportError('cannot import name x\\nfrom dask')",
            ("installed but cannot be imported", "cannot import name x from dask"),
        ),
    ],
)
def test_why_a_cluster_cannot_be_used(tmp_path, monkeypatch, text, parts):
    """The package is missing, or it is there and one that it imports is missing or of another
    version.
    """
    monkeypatch.delitem(sys.modules, "distributed", raising=False)
    if text is None:
        monkeypatch.setitem(sys.modules, "distributed", None)
    else:
        (tmp_path / "distributed.py").write_text(text)
        monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(StudyError) as refusal, executor(1, "tcp://127.0.0.1:1"):
        pass
    assert all(part in str(refusal.value) for part in parts), refusal.value
    assert ("installed but" in str(refusal.value)) == (text is not None)


def test_workers_with_other_code_are_refused_by_name():
    """Those that are there before the first row, and those that join later, with their first part."""
    same = version_of_code()
    executor_module._refuse_other_code({"tcp://a:1": same, "tcp://b:2": same})
    for other in (
        "0.0.9 " + same.split()[1],
        same[:-1] + "x",
        AttributeError("no version_of_code"),
    ):
        with pytest.raises(
            StudyError, match='"tcp://b:2" of the cluster has another version or other code'
        ):
            executor_module._refuse_other_code({"tcp://a:1": same, "tcp://b:2": other})
    assert executor_module._by_the_same_code(same, divmod, 7, 2) == (3, 1)
    with pytest.raises(StudyError, match="another version or other code"):
        executor_module._by_the_same_code("0.0.9", divmod, 7, 2)


def remember(number):
    inputs[-1, number] = "table"
    return number


def test_what_processes_read_is_known_here():
    """No output may replace a file that only another process has read."""
    with executor(2) as pool:
        assert list(in_order(pool, remember, range(5))) == list(range(5))
    assert [inputs.pop((-1, k), None) for k in range(5)] == 5 * ["table"]
