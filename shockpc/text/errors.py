"""The errors of the package, a tree with one root.

ShockError                 the root; its text is the whole message for a user
├── UnknownName            no such robot, frame, joint, body or posture; lists the nearest names
├── RobotError             a robot file is missing, unreadable, not a robot, or not physical
├── SceneError             the scene cannot be computed: posture, strike, contact, plane or file
├── SolveError             no unique solution (a moving body without mass, a singular posture)
├── StudyError             a study cannot be computed as asked: its ranges, budgets or landings
├── OutputError            a result cannot be written to the given place
└── DefectError            an unexpected exception while one landing of many was computed

Every error has the exit code of a command that it ends: 2 for bad arguments or files, 3 for a model
that cannot be solved, 70 for an error in shockpc itself, as any other exception. Codes 0 (done) and
1 (a budget is exceeded) belong to no error.
"""

import re
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from shockpc.text.printed import printable

T = TypeVar("T")


class ShockError(Exception):
    """Root of the tree. The text says what was found, what it means and what to change.

    Args:
        text: the message.
        constraints: names of the contacts, standing feet and loops concerned.
        bodies: names of the bodies concerned.
        joints: names or globs of the joints concerned.
        rows: numbers of the rows concerned: of a table, or of the equation.

    Attributes: as the arguments; the tuples are empty where nothing of their kind is the cause.
    """

    exit_code = 2

    def __init__(
        self,
        text: str = "",
        *,
        constraints: Iterable[str] = (),
        bodies: Iterable[str] = (),
        joints: Iterable[str] = (),
        rows: Iterable[int] = (),
    ) -> None:
        self.constraints = tuple(constraints)
        self.bodies = tuple(bodies)
        self.joints = tuple(joints)
        self.rows = tuple(rows)
        super().__init__(text)

    @property
    def names(self) -> tuple[str, ...]:
        """The texts in quotation marks: names of any kind, and values as they were given."""
        return tuple(re.findall('"([^"]*)"', str(self)))

    @property
    def data(self) -> dict[str, tuple[Any, ...]]:
        """The arguments beside the text, for an error that reports this one."""
        return {key: getattr(self, key) for key in ("constraints", "bodies", "joints", "rows")}


class UnknownName(ShockError):
    """No such robot, frame, joint, body or posture.

    Args:
        kind: kind of the name, such as "frame".
        name: the unknown name.
        known: all valid names.
        where: where the name was searched, such as 'robot "hyq"'; may be empty.
        listing: the command that lists all valid names; may be empty.
        hint: what else would be valid; may be empty.
    """

    def __init__(
        self, kind: str, name: str, known: Iterable[str], where: str, listing: str, hint: str = ""
    ):
        import difflib

        self.kind = kind
        self.name = name
        self.known = tuple(known)
        self.where = where
        self.listing = listing
        self.hint = hint
        folded = {k.casefold(): k for k in reversed(self.known)}
        close = difflib.get_close_matches(name.casefold(), folded, n=3, cutoff=0.5)
        nearest = ", ".join(_quoted(folded[k]) for k in close)
        text = f"no {kind} {_quoted(name)}"
        if where:
            text += f" in {printable(where)}"
        if nearest:
            text += f"; nearest: {nearest}"
        elif self.known and len(self.known) <= 12:
            text += "; there are: " + ", ".join(map(_quoted, self.known))
        elif not hint:
            text += "; no name is similar" if self.known else "; there are none"
        if hint:
            text += f"; {printable(hint)}"
        if listing:
            text += f". To list them: {printable(listing)}"
        super().__init__(text)

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.kind, self.name, self.known, self.where, self.listing, self.hint)


class RobotError(ShockError):
    """A robot file is missing, unreadable, not a robot, or has values that no body can have."""


class SceneError(ShockError):
    """A scene cannot be computed as asked: its posture, strike, contact, plane or file."""


class SolveError(ShockError):
    """The impulsive equation of motion has no unique solution for this model and scene."""

    exit_code = 3


class StudyError(ShockError):
    """A study of several landings cannot be computed as asked: its ranges, budgets or landings."""


class OutputError(ShockError):
    """A result cannot be written to the given place."""


class DefectError(ShockError):
    """An unexpected exception while one landing of many was computed.

    Args:
        text: the message.
        trace: where it arose.
    """

    exit_code = 70

    def __init__(self, text: str, trace: str):
        self.trace = trace
        super().__init__(text)

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (str(self), self.trace)


def refusal(error: Exception) -> ShockError:
    """The error of one landing of many, which is the message of its row.

    An unexpected exception is a defect of shockpc.
    """
    if isinstance(error, ShockError):
        return error
    import traceback

    origin = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{origin.filename.rpartition('/')[2]}, line {origin.lineno}"
    text = (
        f"an error in shockpc itself, please report it: {type(error).__name__} in {where}: {error}"
    )
    return DefectError(text, "".join(traceback.format_exception(error)))


def attempt(compute: Callable[..., T], *arguments: Any) -> T | ShockError:
    """The value of a function, or the error of one landing of many that it raises, as `refusal`."""
    try:
        return compute(*arguments)
    except Exception as error:
        return refusal(error)


def traces(errors: Iterable[object]) -> list[str]:
    """The places in the code where the unexpected exceptions among some errors arose."""
    return [error.trace for error in errors if isinstance(error, DefectError)]


def _quoted(name: str) -> str:
    """A name as messages show it: quoted, at most 80 characters, without control characters."""
    return f'"{printable(name, 80)}"'
