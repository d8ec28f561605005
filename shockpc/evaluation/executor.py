"""Executors of the parts of a study: this process, several on this machine, or a cluster.

Studies know the interface only of `concurrent.futures.Executor`; None is this process.
"""

import logging
import multiprocessing
import os
import signal
import socket
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from typing import Any, TypeVar

import shockpc
from shockpc.text.cache import version_of_code
from shockpc.text.errors import StudyError
from shockpc.text.paths import Inputs, inputs
from shockpc.text.printed import listed

S = TypeVar("S")
T = TypeVar("T")

PATIENCE = 10.0
"""Time to wait for the scheduler of a cluster [s]."""

ABSENT = 10
"""Number of checks in sequence that find no worker of a cluster before that is said.

They are half a second apart, so that it is known within ten seconds.
"""


@contextmanager
def executor(
    jobs: int, cluster: str | None = None, waiting: Callable[[str], object] | None = None
) -> Iterator[Executor | None]:
    """An executor of so many processes; None, which means this one, for 1.

    When it is left by an error, what still runs is ended.

    Args:
        jobs: number of processes.
        cluster: address of the scheduler of a Dask cluster, such as tcp://host:8786, which computes
            instead.
        waiting: called with a message if the cluster has no worker, at first or later, which is
            then waited for; None refuses such a cluster.

    Raises:
        StudyError: a process died; the cluster cannot be reached, has no worker or loses all of
            them, or `distributed` is not installed.
    """
    with (
        _dask(cluster, waiting)
        if cluster is not None
        else processes(jobs)
        if jobs > 1
        else nullcontext() as workers
    ):
        yield workers


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """So many processes of this machine, also one."""
    # Forked processes have the libraries loaded already, which saves each of them half a second.
    context = multiprocessing.get_context("fork") if sys.platform == "linux" else None
    with ProcessPoolExecutor(jobs, context, _prepare_worker) as pool:
        finished = False
        try:
            yield pool
            finished = True
        except BrokenProcessPool:
            raise StudyError(
                "a worker process died, perhaps because the memory was used up; try again with "
                "fewer processes: --jobs 1"
            ) from None
        finally:
            if not finished:
                pool.shutdown(wait=False, cancel_futures=True)
                for child in multiprocessing.active_children():
                    child.terminate()


def _prepare_worker() -> None:
    """Leave Ctrl-C to the first process, which ends this one, and end with it however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when the first one has ended, even if that was killed."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


@contextmanager
def _dask(address: str, waiting: Callable[[str], object] | None) -> Iterator[Executor]:
    """The executor of a running Dask cluster."""
    client = _client(address)
    cluster = _Cluster(client, address, waiting)
    from distributed import KilledWorker

    watcher = threading.Thread(target=cluster.watch, daemon=True)
    try:
        cluster.wait_for_workers()
        _refuse_other_code(client.run(version_of_code, on_error="return"))
        watcher.start()
        yield cluster.executor
    except KilledWorker as death:
        raise StudyError(
            f"several workers of the cluster died while computing the same part: {death}; give "
            "them more memory"
        ) from None
    except (CancelledError, RuntimeError) as end:
        if cluster.lost.is_set():
            lost = cluster.missing.replace("has no worker", "lost all its workers")
            raise StudyError(f"{lost}; or wait for them with --wait") from None
        if isinstance(end, RuntimeError):
            raise
        raise StudyError(f'the cluster at "{address}" went away; start it again') from None
    finally:
        cluster.ended.set()
        if watcher.is_alive():
            watcher.join(PATIENCE)
        client.close(timeout=1)


def _client(address: str) -> Any:
    """The client of a Dask scheduler.

    Raises:
        StudyError: `distributed` cannot be imported, or no scheduler answers.
    """
    install = "install it with: pip install distributed pyarrow"
    try:
        from distributed import Client
    except ImportError as refusal:
        if isinstance(refusal, ModuleNotFoundError) and refusal.name == "distributed":
            raise StudyError(f'a cluster needs the package "distributed"; {install}') from None
        raise StudyError(
            f'the package "distributed" is installed but cannot be imported '
            f"({' '.join(str(refusal).split())}); {install}"
        ) from None
    # It reports every part of a lost worker, which is computed again.
    logging.getLogger("distributed.client").setLevel(logging.ERROR)
    answer: Future[Any] = Future()

    def connect() -> None:
        try:
            answer.set_result(Client(address, timeout=f"{PATIENCE}s", set_as_default=False))
        except BaseException as refusal:
            answer.set_exception(refusal)

    # A server that is no scheduler may send nothing for ever, or numbers that are read as sizes;
    # neither is under the timeout.
    threading.Thread(target=connect, daemon=True).start()
    try:
        return answer.result(1.1 * PATIENCE)
    except Exception as refusal:
        why = " ".join(str(refusal).split()) or f"nothing within {PATIENCE:g} s"
        raise StudyError(
            f'no Dask scheduler answers at "{address}" ({why}); start one with: dask scheduler'
        ) from None


class _Cluster:
    """The workers of a Dask cluster, with a watch over their absence.

    Args:
        client: of its scheduler.
        address: of that.
        waiting: as for `executor`.

    Attributes:
        executor: submits tasks to the workers.
        missing: the message that there is no worker.
        lost: set when all workers have gone, and tasks were cancelled.
        ended: to be set when the watch may end.
    """

    def __init__(self, client: Any, address: str, waiting: Callable[[str], object] | None) -> None:
        self.client = client
        self.missing = (
            f'the cluster at "{address}" has no worker; start some with: dask worker {address}'
        )
        self.waiting = waiting
        self.lost = threading.Event()
        self.ended = threading.Event()
        self.executor = client.get_executor(pure=False)
        self._submit = self.executor.submit
        self._submitted = weakref.WeakSet[Future[Any]]()
        self.executor.submit = self._remembered
        self._absent = 0
        self._pause = PATIENCE / 20.0

    def _remembered(self, *task: Any) -> Future[Any]:
        """Submit a task, which can be cancelled later."""
        future: Future[Any] = self._submit(_by_the_same_code, version_of_code(), *task)
        self._submitted.add(future)
        return future

    def wait_for_workers(self) -> None:
        """Wait for the first worker.

        Raises:
            StudyError: there is none, and none is waited for.
        """
        try:
            self.client.wait_for_workers(1, timeout=ABSENT * self._pause)
        except TimeoutError:
            if self.waiting is None:
                raise StudyError(f"{self.missing}; or wait for them with --wait") from None
            self.waiting(f"{self.missing}; waiting for them")
            self._absent = ABSENT

    def watch(self) -> None:
        """Cancel tasks, or report the wait, after some seconds without workers."""
        while not self.ended.wait(self._pause):
            try:
                present = bool(self.client.nthreads())
            except OSError:
                return  # the scheduler went away, which cancels what runs
            self._absent = 0 if present else self._absent + 1
            if self._absent != ABSENT:
                continue
            if self.waiting is not None:
                self.waiting(f"{self.missing}; waiting for them")
                continue
            self.lost.set()
            # It reports what is cancelled.
            logging.getLogger("tornado.application").setLevel(logging.CRITICAL)
            for future in list(self._submitted):
                future.cancel()
            return


def _refuse_other_code(versions: Mapping[str, object]) -> None:
    """Refuse workers whose package is not this one.

    Args: versions, by worker, or the error in place of a version.

    Raises:
        StudyError: another version, or other code, would compute other rows.
    """
    differing = [worker for worker, version in versions.items() if version != version_of_code()]
    if differing:
        verb = "has" if len(differing) == 1 else "have"
        raise StudyError(
            f"{listed(differing, 3)} of the cluster {verb} another version or other code of "
            f"shockpc; install version {shockpc.__version__} from the same files there"
        )


def _by_the_same_code(version: str, function: Callable[..., T], *arguments: Any) -> T:
    """The result of a function, by a worker with this version of the package.

    Other workers may join the cluster at any time.

    Raises:
        StudyError: the worker has another version, or other code.
    """
    if version_of_code() != version:
        _refuse_other_code({socket.gethostname(): version})
    return function(*arguments)


def in_order(
    workers: Executor | None, function: Callable[[S], T], parts: Iterable[S], ahead: int = 64
) -> Iterator[T]:
    """Yield the results of parts in their order, while later ones are computed.

    Args:
        workers: do the work; this process if there are none.
        function: of a part; it can be pickled, and so can the parts.
        parts: what is computed.
        ahead: number of parts that other processes may compute before the first one has been read,
            which limits the memory.
    """
    if workers is None:
        yield from map(function, parts)
        return
    waiting: deque[Future[tuple[T, Inputs]]] = deque()

    def first() -> T:
        value, read = waiting.popleft().result()
        inputs.update(read)
        return value

    try:
        for part in parts:
            waiting.append(workers.submit(_with_inputs, function, part))
            if len(waiting) > ahead:
                yield first()
        while waiting:
            yield first()
    finally:
        for future in waiting:
            future.cancel()


def _with_inputs(function: Callable[[S], T], part: S) -> tuple[T, Inputs]:
    """The result of a part, and the files that were read for it, which no output may replace."""
    before = inputs.copy()
    return function(part), dict(inputs.items() - before.items())
