"""Bending of links: what a scene says of it, as text and as a record."""

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from shockpc.core.number import NO_UNIT, number_from, whole_from
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError

FORMS = (
    "EI:674, EA:1e7 and GJ:500, tube:70e9,0.025,0.021 (E, outer and inner diameter), 180Hz:clamped "
    "or 180Hz:free, and hinges:4"
)
"""Forms of a flexible link, as examples."""

LARGEST = 1e12
"""Largest number of a link, in whatever unit: one that stiff is rigid."""

HINGES, MOST = 2, 50
"""Hinges of a flexible link by default, and the maximum."""


class Flex(NamedTuple):
    """Bending of a link; of EI and frequency one is given.

    Attributes:
        EI: bending stiffness [N m²].
        frequency: the first bending frequency of the link, with all that is fixed to it [Hz].
        clamped: whether it has that with its joint clamped; else free at both ends.
        EA: stiffness against stretch [N]; none stretches by default.
        GJ: stiffness against torsion [N m²]; none twists by default.
        hinges: number of hinges.
    """

    EI: float | None = None
    frequency: float | None = None
    clamped: bool = False
    EA: float | None = None
    GJ: float | None = None
    hinges: int = HINGES

    @property
    def springs(self) -> int:
        """The number of springs in its hinges."""
        return self.hinges * (2 + (self.EA is not None) + (self.GJ is not None))

    @property
    def _stiffnesses(self) -> dict[str, float]:
        """The stiffnesses that it has, by name."""
        values = {"EI": self.EI, "EA": self.EA, "GJ": self.GJ}
        return {name: value for name, value in values.items() if value is not None}

    def scaled(self, factor: float) -> "Flex":
        """The link with all its stiffnesses multiplied by a factor."""
        scaled: dict[str, Any] = {}
        for name, value in self._stiffnesses.items():
            scaled[name] = factor * value
        if self.frequency is not None:
            scaled["frequency"] = math.sqrt(factor) * self.frequency
        return self._replace(**scaled)

    def __str__(self) -> str:
        parts = []
        if self.frequency is not None:
            held = "clamped" if self.clamped else "free"
            parts.append(f"{self.frequency!r}Hz:{held}")
        parts += [f"{name}:{value!r}" for name, value in self._stiffnesses.items()]
        if self.hinges != HINGES:
            parts.append(f"hinges:{self.hinges!r}")
        return ",".join(parts)


def flex_from(text: str) -> Flex:
    """Bending of a link from its text.

    Such are "EI:674", "tube:70e9,0.025,0.021,hinges:4" and "180Hz:clamped,EA:1e7".

    A tube also stretches.

    Raises:
        ValueError: it is not of that form, or its numbers are not those of a link.
    """
    flex, kinds, stiffness = Flex(), list[str](), dict[str, float]()
    for part in re.split(r",(?=[^,]*:)", text):  # at the commas before a key
        name, _, value = (word.strip() for word in part.partition(":"))
        kind = "frequency" if name.endswith("Hz") else name
        if kind in kinds:
            raise ValueError(f'"{text}" gives {name} twice; keep one of them')
        kinds.append(kind)
        if kind == "tube":
            # An EA that is given goes over the tube's.
            stiffness = _tube(text, value) | stiffness
        elif kind == "frequency" and value in ("clamped", "free"):
            frequency = _positive(text, name, {"Hz": 1.0})
            flex = flex._replace(frequency=frequency, clamped=value == "clamped")
        elif kind in ("EI", "EA", "GJ"):
            stiffness[kind] = _positive(text, value)
        elif kind == "hinges" and _hinges(value):
            flex = flex._replace(hinges=_hinges(value))
        else:
            limits = f"; hinges are 1 to {MOST}" if kind == "hinges" else ""
            raise ValueError(
                f'"{part}" says nothing of how a link bends; valid are {FORMS}{limits}'
            )
    of_bending = [kind for kind in kinds if kind in ("EI", "tube", "frequency")]
    if len(of_bending) != 1:
        which = f"{' and '.join(of_bending)} are given" if of_bending else "none is given"
        raise ValueError(
            f'"{text}": one of EI, tube and frequency says how a link bends, but {which}; valid '
            f"are {FORMS}"
        )
    return flex._replace(EI=stiffness.get("EI"), EA=stiffness.get("EA"), GJ=stiffness.get("GJ"))


def _tube(text: str, value: str) -> dict[str, float]:
    """EI and EA of a tube: E π/64 (D⁴ − d⁴) [N m²] and E π/4 (D² − d²) [N].

    Args: text, of the link, for messages; value, "E,D,d".

    Raises:
        ValueError: these are not the numbers of a tube.
    """
    numbers = [number.strip() for number in value.split(",")]
    E = outer = inner = 0.0
    if len(numbers) == 3:
        E, outer = _positive(text, numbers[0]), _positive(text, numbers[1])
    if numbers[-1] not in ("0", "0.0"):
        inner = _positive(text, numbers[-1])
    if not outer > inner:
        raise ValueError(
            f'"{text}": a tube has E [Pa], outer and inner diameter [m], such as '
            f"tube:70e9,0.025,0.021"
        )
    EI = math.pi / 64.0 * E * (outer**4 - inner**4)
    EA = math.pi / 4.0 * E * (outer**2 - inner**2)
    if not max(EI, EA) <= LARGEST:
        raise ValueError(
            f'"{text}" gives EI of {EI:.3g} N m², above {LARGEST:g}: diameters are in metres, E '
            f"in Pa"
        )
    return {"EI": EI, "EA": EA}


def _hinges(text: str) -> int:
    """The number of hinges that a text gives; 0 if it is none from 1 to `MOST`."""
    try:
        count = whole_from(text)
    except ValueError:
        return 0
    return count if 1 <= count <= MOST else 0


def _positive(text: str, number: str, units: Mapping[str, float] = NO_UNIT) -> float:
    try:
        value = number_from(number, units)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= LARGEST:
        raise ValueError(
            f'"{text}": "{number}" is not a number above zero and up to {LARGEST:g}; valid are '
            f"{FORMS}"
        )
    return value


def flexes_of(texts: Mapping[str, str]) -> tuple[tuple[str, Flex], ...]:
    """Bending of links, each with its pattern.

    Args: texts, of a scene, by pattern.

    Raises:
        SceneError: a text says nothing of it.
    """
    flexes = []
    for pattern, text in texts.items():
        try:
            flexes.append((pattern, flex_from(text)))
        except ValueError as refusal:
            raise SceneError(f'flex of "{pattern}": {refusal}', bodies=[pattern]) from None
    return tuple(flexes)


def flexes_by_body(robot: Robot, flexes: Iterable[tuple[str, Flex]]) -> dict[int, Flex]:
    """Bending of the bodies that bend, by their index.

    Args: flexes, each with its name or a glob; of two that fit a body the latter.

    Raises:
        UnknownName: a pattern fits no body.
    """
    by_body: dict[int, Flex] = {}
    for pattern, flex in flexes:
        by_body |= dict.fromkeys(robot.match_bodies(pattern), flex)
    return by_body
