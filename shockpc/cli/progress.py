"""How far a long command is: one line on standard error, on a terminal alone."""

import sys
from collections.abc import Callable

from shockpc.cli.signals import was_interrupted

__all__ = ["progress"]


def progress(what: str, total: int) -> Callable[[str], None]:
    """A function to call with the name of each part that is done; it removes its line after the last.

    Args:
        what: is counted, such as "robots read".
        total: number of parts.

    Raises:
        KeyboardInterrupt: when it is called after a signal.
    """
    count = 0

    def show(name: str) -> None:
        nonlocal count
        count += 1
        if was_interrupted():
            # A signal that comes while a library calls back is lost there.
            raise KeyboardInterrupt
        if sys.stderr.isatty():
            sys.stderr.write("\r\033[K" + (f"{what}: {count} of {total}, {name}" if count < total else ""))
            sys.stderr.flush()

    return show
