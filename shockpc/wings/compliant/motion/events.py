"""What elements of finite stiffness do, what can happen to them, and what tells of it."""

from enum import StrEnum
from typing import NamedTuple

OPEN, LOADING, UNLOADING = range(3)
"""What an element does: it is without force, is loaded with its stiffness k, or is unloaded with k
/ e², and held where e = 0.
"""

RATE, FORCE, GAP, TOTAL, PUSH = range(5)
"""Signals of an element: its rate, its force, its gap, its force with that of its damper.

The last one is the force that an open contact with a damper would have on the ground that it has
compressed.
"""


class EventKind(StrEnum):
    """What can happen to an element. A normal that unloads is at the end of its compression."""

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
    """What happens to an element at a time [s]; to a contact, at its normal."""

    time: float
    element: int
    kind: EventKind


class Watch(NamedTuple):
    """What may happen to an element: it does when offset + sign · the signal of that event falls
    below −tolerance.

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
