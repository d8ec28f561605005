"""How far a long command is: one line on standard error, on a terminal alone."""

import sys
from collections.abc import Callable

__all__ = ["progress"]


def progress(what: str, total: int) -> Callable[[str], None]:
    """A function to call with the name of each part that is done; it removes its line after the last.

    Args:
        what: is counted, such as "robots read".
        total: number of parts.
    """
    count = 0

    def show(name: str) -> None:
        nonlocal count
        count += 1
        if sys.stderr.isatty():
            sys.stderr.write("\r\033[K" + (f"{what}: {count} of {total}, {name}" if count < total else ""))
            sys.stderr.flush()

    return show
