"""Elements of finite stiffness: their phases, events, and the signals that tell of these."""

from enum import StrEnum
from typing import NamedTuple

OPEN, LOADING, UNLOADING = range(3)
"""Phases of an element: without force, loaded, or unloaded.

It is loaded with its stiffness k, and unloaded with k / e², or held where e = 0.
"""

RATE, FORCE, GAP, TOTAL, PUSH = range(5)
"""Signals of an element: its rate, its force, its gap, its force with that of its damper.

The last one is the force that an open contact with a damper would have on the ground that it has
compressed.
"""


class EventKind(StrEnum):
    """Kind of event of an element.

    A normal that unloads is at the end of its compression.
    """

    UNLOADS = "unloads"
    RELOADS = "reloads"
    REVERSES = "reverses"
    SLIPS = "slips"
    OPENS = "opens"
    CLOSES = "closes"
    EASES = "eases"
    TURNS = "turns"
    SLOWS = "slows"
    CLEARS = "clears"


UNFELT = EventKind.EASES, EventKind.TURNS, EventKind.SLOWS, EventKind.CLEARS
"""These change no force and are no events of a motion; after them it may be at its end.

A normal force has *eased* to what constant forces make; after that, its contact *turns* back
towards the ground; a contact with a damper is *slow*, with which its compression counts as ended;
an open one has *cleared* the ground that it had compressed.
"""


WATCHED = {
    EventKind.UNLOADS: RATE,
    EventKind.RELOADS: FORCE,
    EventKind.REVERSES: FORCE,
    EventKind.SLIPS: FORCE,
    EventKind.OPENS: TOTAL,
    EventKind.CLOSES: GAP,
    EventKind.EASES: TOTAL,
    EventKind.TURNS: RATE,
    EventKind.SLOWS: RATE,
    EventKind.CLEARS: GAP,
}
"""The signal that tells of each event."""


class Event(NamedTuple):
    """An event of an element at a time [s]; of a contact, at its normal."""

    time: float
    element: int
    kind: EventKind


class Watch(NamedTuple):
    """An event that may happen to an element, and the signal that is watched for it.

    It happens when offset + sign · the signal falls below −tolerance.

    Attributes:
        element: its number.
        kind: the event.
        tolerance: what counts as zero.
        offset: constant.
        sign: 1 or −1.
        either: whether the signal counts with the sign that it has first.
    """

    element: int
    kind: EventKind
    tolerance: float
    offset: float
    sign: float
    either: bool = False
