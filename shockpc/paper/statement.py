"""A statement of the paper, the number that decides it under every reading of the text, and the verdict that follows."""

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

__all__ = ["Outcome", "Reading", "Statement", "outcomes"]


class Reading(NamedTuple):
    """Something that the text leaves open, or a condition that a statement may hang on.

    Attributes:
        name: what is open.
        options: the ways to read it by their names, the one taken first.
    """

    name: str
    options: Mapping[str, object]


class Outcome(NamedTuple):
    """What came out under one reading of everything.

    Attributes:
        reading: (name, option) of every open reading.
        number: that decides the statement.
        holds: whether the statement is true of it.
    """

    reading: tuple[tuple[str, str], ...]
    number: float
    holds: bool


@dataclass(frozen=True)
class Statement:
    """A statement of the paper, judged.

    Attributes:
        figure: that it is made about or shown with.
        place: where it stands.
        says: what it says, in our words.
        measure: what the number is, with its unit.
        outcomes: under the reading taken, then under the others.
        because: why it fails where it does.
    """

    figure: int
    place: str
    says: str
    measure: str
    outcomes: tuple[Outcome, ...]
    because: str = ""

    @property
    def number(self) -> float:
        """The number under the reading taken."""
        return self.outcomes[0].number

    @property
    def verdict(self) -> str:
        """Holds (whatever the reading), holds under …, or fails, because …"""
        good = [outcome for outcome in self.outcomes if outcome.holds]
        if len(good) == len(self.outcomes):
            return "holds"
        if not good:
            return f"fails, because {self.because}"
        return f"holds under {self._conditions(good)}; elsewhere it fails, because {self.because}"

    def matters(self, name: str) -> bool:
        """Whether the verdict depends on a reading, the others being as taken."""
        return len({outcome.holds for outcome in self.along(name)}) > 1

    def along(self, name: str) -> tuple[Outcome, ...]:
        """The outcomes under every option of one reading, the others being as taken."""
        base = dict(self.outcomes[0].reading)
        return tuple(o for o in self.outcomes if all(option == base[other] for other, option in o.reading if other != name))

    @property
    def readings(self) -> tuple[str, ...]:
        """Names of the readings that it was computed under, where there is more than one option."""
        options: dict[str, set[str]] = {}
        for outcome in self.outcomes:
            for name, option in outcome.reading:
                options.setdefault(name, set()).add(option)
        return tuple(name for name, found in options.items() if len(found) > 1)

    def _conditions(self, good: list[Outcome]) -> str:
        """For which readings it holds: option by option where that says all, else by how many, and which of them alone do harm."""
        every = {name: tuple(dict.fromkeys(dict(o.reading)[name] for o in self.outcomes)) for name in self.readings}
        kept = {name: tuple(x for x in every[name] if any(dict(o.reading)[name] == x for o in good)) for name in every}
        size = 1
        for options in kept.values():
            size *= len(options)
        narrowed = [f"{name}: {_either(kept[name])}" for name in every if len(kept[name]) < len(every[name])]
        if size == len(good):
            return "; ".join(narrowed)
        share = f"{len(good)} of {len(self.outcomes)} readings"
        if not self.outcomes[0].holds:
            return "; ".join([share, *narrowed])
        alone = {name: tuple(dict(o.reading)[name] for o in self.along(name) if o.holds) for name in every if self.matters(name)}
        if not alone:
            return f"{share}, whichever one is changed alone"
        return "; ".join([f"{share}, of those changed alone", *(f"{name}: {_either(options)}" for name, options in alone.items())])


def outcomes(readings: tuple[Reading, ...], number: Callable[..., float], holds: Callable[[float], bool]) -> tuple[Outcome, ...]:
    """The outcome under every combination of readings, the one taken first.

    Args:
        readings: what is open.
        number: of the meanings of all readings, in order.
        holds: of that number.
    """
    return tuple(_every(readings, number, holds))


def _every(readings: tuple[Reading, ...], number: Callable[..., float], holds: Callable[[float], bool]) -> Iterator[Outcome]:
    for chosen in itertools.product(*(reading.options.items() for reading in readings)):
        found = number(*(meaning for _, meaning in chosen))
        reading = tuple((r.name, option) for r, (option, _) in zip(readings, chosen, strict=True))
        yield Outcome(reading, float(found), bool(holds(found)))


def _either(options: tuple[str, ...]) -> str:
    """Options as a reader says them."""
    return options[0] if len(options) == 1 else ", ".join(options[:-1]) + " or " + options[-1]
