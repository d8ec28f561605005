"""A statement of the paper, the number that decides it under every reading of the text, and the verdict that follows."""

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

__all__ = ["Outcome", "Reading", "Statement", "outcomes"]


MOST_LISTED = 3
"""Combinations of readings that a verdict lists one by one."""


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
        """What follows: holds (whatever the reading), holds under or in some of them, or fails, because of something."""
        good = [outcome for outcome in self.outcomes if outcome.holds]
        if len(good) == len(self.outcomes):
            return "holds"
        if not good:
            return f"fails, because {self.because}"
        return f"holds {self._conditions(good)}; elsewhere it fails, because {self.because}"

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
        """For which readings it holds, in as few words as say it all."""
        every = {name: tuple(dict.fromkeys(dict(o.reading)[name] for o in self.outcomes)) for name in self._deciding()}
        found = list(dict.fromkeys(tuple(dict(o.reading)[name] for name in every) for o in good))
        kept = {name: tuple(x for x in every[name] if any(one[k] == x for one in found)) for k, name in enumerate(every)}
        if math.prod(map(len, kept.values())) == len(found):
            needed = [f"{name}: {_some(kept[name], every[name])}" for name in every if len(kept[name]) < len(every[name])]
            return f"under {'; '.join(needed)}"
        if len(found) <= MOST_LISTED:
            return "under " + ", or ".join("; ".join(f"{name}: {x}" for name, x in zip(every, one, strict=True)) for one in found)
        share = f"in {len(good)} of the {len(self.outcomes)} combinations of readings tried"
        alone = {name: tuple(dict(o.reading)[name] for o in self.along(name) if o.holds) for name in every if self.matters(name)}
        if not alone:
            always = "holds" if self.outcomes[0].holds else "fails"
            return f"{share}; changing one reading at a time from those taken, it always {always}"
        kinds = "; ".join(f"{name}: {_some(x, every[name])}" for name, x in alone.items())
        return f"{share}; changing one reading at a time from those taken, it holds for {kinds}"

    def _deciding(self) -> tuple[str, ...]:
        """The readings on which the verdict hangs, whatever the others are."""
        names = []
        for name in self.readings:
            seen: dict[tuple[tuple[str, str], ...], bool] = {}
            for o in self.outcomes:
                others = tuple(pair for pair in o.reading if pair[0] != name)
                if seen.setdefault(others, o.holds) != o.holds:
                    names.append(name)
                    break
        return tuple(names)


def outcomes(
    readings: tuple[Reading, ...],
    number: Callable[..., float],
    holds: Callable[[float], bool],
    together: bool = True,
    distinct: Callable[..., bool] | None = None,
) -> tuple[Outcome, ...]:
    """The outcomes under several readings, the one taken first.

    Args:
        readings: what is open.
        number: of the meanings of all readings, in order.
        holds: of that number.
        together: every combination; else one reading changed at a time.
        distinct: whether a combination, given by its meanings, is tried at all; by default each is. Where one option has no use
            for another reading, the combinations that differ in that reading alone would be one case counted many times.
    """
    options = [tuple(reading.options.items()) for reading in readings]
    chosen = list(itertools.product(*options))
    if not together:
        chosen = [one for one in chosen if sum(pick != first[0] for pick, first in zip(one, options, strict=True)) <= 1]
    found = []
    for one in chosen:
        if distinct is not None and not distinct(*(meaning for _, meaning in one)):
            continue
        value = float(number(*(meaning for _, meaning in one)))
        reading = tuple((r.name, option) for r, (option, _) in zip(readings, one, strict=True))
        found.append(Outcome(reading, value, bool(holds(value))))
    return tuple(found)


def _some(options: tuple[str, ...], every: tuple[str, ...]) -> str:
    """Options as a reader says them; what is left out, if that is shorter."""
    others = tuple(option for option in every if option not in options)
    return f"any but {_listed(others, 'and')}" if len(others) < len(options) else _listed(options, "or")


def _listed(options: tuple[str, ...], last: str) -> str:
    return options[0] if len(options) == 1 else f"{', '.join(options[:-1])} {last} {options[-1]}"
