"""Warnings about a result, as records, so that no code decides by the words of a message."""

import re
import sys
import warnings
from collections.abc import Callable, Iterable
from types import FrameType
from typing import NamedTuple, TypeVar

from shockpc.text.printed import few

T = TypeVar("T")

KINDS = (
    "size",
    "standing",
    "base",
    "energy",
    "drives",
    "inertia",
    "robot",
    "unit",
    "height",
    "contact",
    "scene",
    "straight",
    "posture",
    "data",
    "part",
    "sensor",
    "geometry",
    "limits",
)
"""Kinds of warnings in the order of their effect.

They mean no number, another landing or robot than is meant, unreliable numbers, damage, or a remark
that changes no number.
"""


class Diagnostic(NamedTuple):
    """A warning; `str` gives its text.

    Attributes:
        kind: what it is about, one of `KINDS`: "size" where impulses are too large to be
            determined, "standing" where the robot does not stand on its feet, "base" where it hangs
            on a base that its file holds, "straight" where a leg is straight in a posture that
            nobody chose.
        subject: name of the body, joint, contact or sensor concerned; empty if it is the whole
            landing.
        value: the number that gave rise to it, if there is one, in SI units.
        text: what was found, and its consequence.
    """

    kind: str
    subject: str
    value: float | None
    text: str

    def __str__(self) -> str:
        return self.text

    @property
    def cause(self) -> tuple[str, str]:
        """Its kind, and its text without names and numbers.

        Warnings of several places have one cause where these are equal.
        """
        said = {name for name in self.subject.split("+") if name and name in self.text}
        names = sorted(said, key=lambda name: (-len(name), name))
        parts = [
            r" \(\d+ alike: .*\)$",
            *(rf"(?<!\w){re.escape(name)}(?!\w)" for name in names),
            '"[^"]*"',
            r"[-+]?\d[\d.e+-]*",
        ]
        return self.kind, re.sub("|".join(parts), "", self.text)

    @property
    def rank(self) -> int:
        """Its place in the order of effects."""
        return KINDS.index(self.kind) if self.kind in KINDS else len(KINDS)

    @property
    def size(self) -> float:
        """Its rank among those of its cause, greater for worse: the magnitude of its value.

        Of a margin the less is the worse.
        """
        return abs(self.value or 0.0) * (-1.0 if self.kind == "part" else 1.0)


def alike(warnings: Iterable[tuple[Diagnostic, T]]) -> list[list[tuple[Diagnostic, T]]]:
    """Warnings, each with what has it, in lists of one cause in the order of `KINDS`.

    In each list the worst is first.
    """
    groups: dict[object, list[tuple[Diagnostic, T]]] = {}
    for pair in warnings:
        groups.setdefault(pair[0].cause, []).append(pair)
    return sorted(
        (sorted(group, key=lambda pair: -pair[0].size) for group in groups.values()),
        key=lambda group: group[0][0].rank,
    )


def by_cause(warnings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """The worst warning of each cause, with the number and names of its places.

    They are in the order of `KINDS`.
    """
    by_rank: list[Diagnostic] = []
    for group in alike((warning, warning.subject) for warning in warnings):
        worst, names = group[0][0], [name for _, name in group]
        # a single one, or of one subject, which differ in something else
        if len(set(names)) < max(len(names), 2):
            by_rank += [warning for warning, _ in group]
        else:
            text = f"{worst} ({len(names)} alike: {few(names, 4)})"
            by_rank.append(worst._replace(subject="+".join(names), text=text))
    return tuple(by_rank)


class ShockWarning(UserWarning):
    """A Python warning of a landing; its text is that of the diagnostic.

    Args:
        diagnostic: the record, which is an attribute too.
    """

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(diagnostic)


def warn(find: Callable[[], Iterable[Diagnostic]]) -> None:
    """Give diagnostics as Python warnings, once for each cause, whatever its numbers.

    They are given at the line outside the package that asked.

    Args:
        find: gives them; it is not called where a filter ignores `ShockWarning`, as some take time
            to find.
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
    while (
        frame is not None
        and frame.f_globals.get("__name__", "").partition(".")[0] == __name__.partition(".")[0]
    ):
        level, frame = level + 1, frame.f_back
    once = {(diagnostic.cause, diagnostic.subject): diagnostic for diagnostic in find()}
    for diagnostic in by_cause(once.values()):
        warnings.warn(ShockWarning(diagnostic), stacklevel=level)
