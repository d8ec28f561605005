"""Linear algebra in one thread.

Threads slow down matrices of this size, and other processes make them wait for one another.
"""

import functools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

SINGLE = 80
"""Size of a matrix up to which linear algebra libraries use one thread by themselves."""


@contextmanager
def one_thread(size: int) -> Iterator[None]:
    """A context in which linear algebra uses one thread. Args: size of the largest matrix in it."""
    if size <= SINGLE:
        yield
        return
    with _controller().limit(limits=1):
        yield


@functools.cache
def _controller() -> Any:
    """The controller of this process's linear algebra libraries.

    Finding them takes milliseconds.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
