"""What elements of finite stiffness do, what can happen to them, and what tells of it."""

from enum import IntEnum, StrEnum
from typing import NamedTuple


class Phase(IntEnum):
    """An element is without force, is loaded with its stiffness k, or is unloaded with k / e², and held where e = 0."""

    OPEN = 0
    LOADING = 1
    UNLOADING = 2


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

A normal force has *eased* to what constant forces make; after that, its contact *turns* back towards the ground; a contact with a
damper is *slow*, with which its compression counts as ended; an open one has *cleared* the ground that it had compressed.
"""


class Event(NamedTuple):
    """What happens to an element at a time [s]; to a contact, at its normal."""

    time: float
    element: int
    kind: EventKind


class Signal(IntEnum):
    """What is watched of an element: its rate, its force, its gap, its force with that of its damper.

    The last one is the force that an open contact with a damper would have on the ground that it has compressed.
    """

    RATE = 0
    FORCE = 1
    GAP = 2
    TOTAL = 3
    PUSH = 4


WATCHED = {
    EventKind.UNLOADS: Signal.RATE,
    EventKind.RELOADS: Signal.FORCE,
    EventKind.REVERSES: Signal.FORCE,
    EventKind.SLIPS: Signal.FORCE,
    EventKind.OPENS: Signal.TOTAL,
    EventKind.CLOSES: Signal.GAP,
    EventKind.EASES: Signal.TOTAL,
    EventKind.TURNS: Signal.RATE,
    EventKind.SLOWS: Signal.RATE,
    EventKind.CLEARS: Signal.GAP,
}
"""What tells of each event."""


class Watch(NamedTuple):
    """What may happen to an element: it does when offset + sign · the signal of that event falls below −tolerance.

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
