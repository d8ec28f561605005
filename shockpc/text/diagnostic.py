"""What a user should know about a result: a warning as a record, so that no code decides by the words of a message."""

import re
import sys
import warnings
from collections.abc import Callable, Iterable
from types import FrameType
from typing import NamedTuple


class Diagnostic(NamedTuple):
    """A warning; `str` gives its text.

    Attributes:
        kind: what it is about: "robot", "scene", "limits", "inertia", "height", "posture", "unit", "geometry", "data", "contact",
            "sensor", "part", "energy", or "size" where impulses are too large to be determined.
        subject: name of the body, joint, contact or sensor concerned; empty if it is the whole landing.
        value: the number that gave rise to it, if there is one, in SI units.
        text: what was found, and its consequence.
    """

    kind: str
    subject: str
    value: float | None
    text: str

    def __str__(self) -> str:
        return self.text


class ShockWarning(UserWarning):
    """A Python warning of a landing; its text is that of the diagnostic.

    Args:
        diagnostic: the record, which is an attribute too.
    """

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(diagnostic)


def warn(found: Callable[[], Iterable[Diagnostic]]) -> None:
    """Give diagnostics as Python warnings, once for each cause, whatever its numbers, at the line outside the package that asked.

    Args:
        found: gives them; it is not called where a filter ignores `ShockWarning`, as some take time to find.
    """
    plain = (
        action
        for action, text, kind, module, line in warnings.filters
        if not (text or module or line) and issubclass(ShockWarning, kind)
    )
    if next(plain, "") == "ignore":
        return
    level = 1
    frame: FrameType | None = sys._getframe()
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == __name__.partition(".")[0]:
        level, frame = level + 1, frame.f_back
    causes = dict[tuple[str, ...], Diagnostic]()
    for one in found():
        causes.setdefault((one.kind, one.subject, *(word for word in one.text.split() if not re.search(r"\d", word))), one)
    for one in causes.values():
        warnings.warn(ShockWarning(one), stacklevel=level)
