"""The progress of a long command: one line on standard error, on a terminal alone."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from shockpc.cli.process import received
from shockpc.text.printed import printable
from shockpc.text.trace import Trace

SLOW = 1.0
"""Time after which a stage is named [s]."""


class ShownTrace(Trace):
    """A trace that names the stage that runs, once it has run for a second."""

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside."""
        with super().stage(name):
            clock = threading.Timer(SLOW, _write, [f"{name} …"])
            clock.daemon = True
            clock.start()
            try:
                yield
            finally:
                if clock.is_alive():
                    clock.cancel()
                else:
                    _write("")


def shown_trace() -> Trace:
    """A trace, whose stages a terminal shows."""
    return ShownTrace() if sys.stderr.isatty() else Trace()


def progress(noun: str, total: int, done: int = 0) -> Callable[..., None]:
    """A function to call with the name of each part that is done, or with a number of `parts`.

    Its line goes after the last part.

    Args:
        noun: is counted, such as "robots read".
        total: number of parts.
        done: number of parts that an earlier run has done.

    Raises:
        KeyboardInterrupt: when it is called after a signal.
    """
    count, start = done, time.monotonic()

    def show(name: str = "", parts: int = 1) -> None:
        nonlocal count
        count += parts
        if received:
            # A signal that comes while a library calls back is lost there.
            raise KeyboardInterrupt
        if sys.stderr.isatty():
            rate = (count - done) / max(time.monotonic() - start, 1e-9)
            text = (
                f"{noun}: {count} of {total}, {name or f'{rate:.0f} a second'}, "
                f"{(total - count) / rate:.0f} s left"
            )
            _write(text if count < total else "")

    return show


def _write(text: str) -> None:
    sys.stderr.write(f"\r\033[K{printable(text)}")
    sys.stderr.flush()
