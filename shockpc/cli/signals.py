"""Ctrl-C and SIGTERM: both unwind a run, so that files which are half written are removed."""

import signal
from typing import Any

__all__ = ["interrupted_code", "listen", "was_interrupted"]

_received: list[int] = []


def listen() -> None:
    """Handle both signals, save those that the caller wants ignored (nohup, or a job in the background)."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)


def was_interrupted() -> bool:
    """Whether a signal has come: an import that is interrupted may raise another error than KeyboardInterrupt."""
    return bool(_received)


def interrupted_code() -> int:
    """The exit code, as shells count: 128 and the signal's number, so 130 after Ctrl-C and 143 after SIGTERM."""
    return 128 + (_received[0] if _received else signal.SIGINT)


def _stop(number: int, _: Any) -> None:
    """Unwind whatever runs."""
    _received.append(number)
    raise KeyboardInterrupt
