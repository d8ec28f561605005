"""What a user should know about a result: a warning as a record, so that no code decides by the words of a message."""

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
