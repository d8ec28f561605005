"""How far a command is: one line on standard error, on a terminal alone, which goes before anything else is written there."""

import sys
import time
from collections.abc import Callable

from shockpc.cli.signals import was_interrupted

__all__ = ["doing", "progress"]


def progress(what: str, total: int) -> Callable[..., None]:
    """A function to call with the name of each part that is done, or with a number of `parts`; its line goes after the last.

    Args:
        what: is counted, such as "robots read".
        total: number of parts.

    Raises:
        KeyboardInterrupt: when it is called after a signal.
    """
    count, start = 0, time.monotonic()

    def show(name: str = "", parts: int = 1) -> None:
        nonlocal count
        count += parts
        if was_interrupted():
            # A signal that comes while a library calls back is lost there.
            raise KeyboardInterrupt
        rate = count / max(time.monotonic() - start, 1e-9)
        text = f"{what}: {count} of {total}, {name or f'{rate:.0f} a second'}, {(total - count) / rate:.0f} s left"
        doing(text if count < total else "")

    return show


def doing(what: str = "") -> None:
    """Replace the line by what is being done; by nothing, to remove it."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\033[K{what}")
        sys.stderr.flush()
