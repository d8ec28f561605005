"""Records that say how far to trust the numbers of a landing, and what fills them."""

from collections.abc import Callable
from typing import Any, NamedTuple

from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few


class Health(NamedTuple):
    """Errors of a profile by its arithmetic, for the robot as loaded.

    Attributes:
        rank: number of independent contact and closure rows.
        rows: number of these rows.
        error_bound: proven error of the reported jumps, relative to each body's motion, the largest
            over the bodies [1].
        body_error_bounds: the same for every body.
        double_error: true error of the solution in double precision, the largest over the bodies
            [1]; inf if it has none.
        data_sensitivity: how far the result moves when every datum changes in its last digit, the
            largest over the bodies [1].
        bits: precision of the ball arithmetic.
        warnings: each with its consequence.
    """

    rank: int
    rows: int
    error_bound: float
    body_error_bounds: tuple[float, ...]
    double_error: float
    data_sensitivity: float
    bits: int
    warnings: tuple[Diagnostic, ...]


class Unknown(NamedTuple):
    """Something that a landing takes for granted; `str` gives it in words, with what to give.

    Attributes:
        kind: what it is about: "drives", "inertia", "geometry", "springs", "contact", "posture",
            "base" or "duration".
        status: "unknown" or "simulation model" of drives that nobody knows, "implausible" of
            inertias, and "missing" of geometry; "published", "derived" or "identified" of drives
            that are known, and "chosen" or "assumed" of the rest.
        subjects: names of the joints, links or contacts.
        deciding: those of the joints that decide about the first number of the answer, the ones
            that count most first.
        text: what is not known, or was chosen; of contacts without their names.
        remedy: what to give, or to change.
        effect: largest over smallest value of the first number that what is known allows [1]; 1
            where that is not computed.
    """

    kind: str
    status: str
    subjects: tuple[str, ...]
    deciding: tuple[str, ...]
    text: str
    remedy: str
    effect: float

    def __str__(self) -> str:
        return f"{self.named}; {self.remedy}" if self.remedy else self.named

    @property
    def named(self) -> str:
        """The text of what is not known, or was chosen, without what to give."""
        return f"{few(self.subjects, 4)}: {self.text}" if self.kind == "contact" else self.text

    @property
    def known(self) -> bool:
        """True if a source of the drives, or a rule by which it was chosen, stands for it."""
        return self.status not in ("unknown", "simulation model", "implausible", "missing")


class Judge(NamedTuple):
    """Functions that judge a profile; whoever makes the profile gives them.

    Attributes:
        health: the arithmetic, with the warnings.
        warnings: what is doubtful, without the rest of it, which takes longer.
        unknowns: what it takes for granted.
    """

    health: Callable[[Any], Health]
    warnings: Callable[[Any], tuple[Diagnostic, ...]]
    unknowns: Callable[[Any], tuple[Unknown, ...]]
