"""Phrases that reports share: names, numbers with their unit, how far they are proven."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from shockpc.quantities.quantity import Quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import usual_base
from shockpc.text.printed import count, few, printable

if TYPE_CHECKING:
    from shockpc.evaluation.column import Column

BRACKETED = 0.5
"""Share of a body's motion out of the plane above which its CoPc and RoPc are in brackets [1].

They describe the rest.
"""


def mostly_off_plane(profile: ShockProfile) -> np.ndarray:
    """True (n,) for bodies that move so much out of the plane that CoPc and RoPc say little."""
    return np.asarray(profile.out_of_plane_share > BRACKETED)


def number_text(number: int) -> str:
    """A small number as a word."""
    words = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight")
    return words[number] if number < len(words) else str(number)


def robot_name(robot: Robot) -> str:
    """The robot as it was asked for: its name in the catalogue, else that in its file."""
    return printable(robot.source.name or robot.name, 40)


def robot_line(robot: Robot) -> tuple[str, str]:
    """The robot of many landings, as lines of a header begin."""
    moving = robot.masses[robot.movable(usual_base(robot).base)]
    return "robot", f"{robot.label} ({robot.name}, {moving.sum():.4g} kg)"


SEPARATORS = "_-. /:"
"""Characters at which names of contacts are shortened."""


def landing_name(contacts: Sequence[str], feet: Sequence[str]) -> str:
    """A short name of a landing, such as "all four feet" and "FL + FR".

    Args:
        contacts: names of its contacts.
        feet: names of the feet of the robot.
    """
    if len(feet) > 1 and set(contacts) == set(feet):
        return "both feet" if len(feet) == 2 else f"all {number_text(len(feet))} feet"
    short = short_contact_names([contacts], feet)
    return " + ".join(short[name] for name in contacts)


def short_contact_names(landings: Iterable[Sequence[str]], feet: Sequence[str]) -> dict[str, str]:
    """Names of feet and contacts without what all of them begin or end with, by the whole names.

    Args:
        landings: names of the contacts of each.
        feet: names of the feet of the robot.
    """
    names = dict.fromkeys(feet)
    for contacts in landings:
        names |= dict.fromkeys(contacts)
    return dict(zip(names, _without_common(list(names)), strict=True))


def _without_common(names: list[str]) -> list[str]:
    """Names without what all of them begin or end with, up to a separator.

    They stay as they are where nothing would be left of one.
    """
    if len(names) < 2:
        return names
    ends = _without_common_beginning([name[::-1] for name in names])
    return _without_common_beginning([name[::-1] for name in ends])


def _without_common_beginning(names: list[str]) -> list[str]:
    """Names without what all of them begin with, up to a separator."""
    same = 0
    for letters in zip(*names, strict=False):
        if len(set(letters)) > 1:
            break
        same += 1
    while same and names[0][same - 1] not in SEPARATORS:
        same -= 1
    shorter = [name[same:] for name in names]
    return shorter if all(shorter) else names


def at_place(text: str) -> str:
    """A quantity and its places, typed as in "shock@imu_link", in words on a line of a figure."""
    return printable(text.replace("@", " at ", 1), 60)


def varied_text(name: str, unit: str) -> str:
    """A quantity that a sweep varies, in words.

    Args: name, as it is typed, such as "com-x:LINK" or "*_KFE"; unit, of its values.
    """
    from shockpc.evaluation.variations.kinds.registry import kind_and_target

    kind, target = kind_and_target(name)
    return printable(kind.in_words(target, unit), 60)


def size_at_place(text: str, column: "Column") -> str:
    """A quantity as `at_place`, with its unit, as a heading of sizes.

    Args: column, one of its numbers.
    """
    return f"{'size of ' if column.selection.signed else ''}{at_place(text)} [{column.unit}]"


def vector_text(values: Iterable[float]) -> str:
    """A vector to four digits."""
    return ", ".join(f"{round(float(value), 12) + 0.0:.4g}" for value in values)


STICKING = (
    "these numbers are for contacts that stick, and the friction only decides whether flat ground "
    "allows a landing; add --quantity shock_friction"
)
"""Text on what a friction changes where no quantity with friction was asked for."""


def proof_text(bound: float) -> str:
    """Bound on the rounding error of the jumps; not how far a real robot agrees with its file."""
    return f"rounding error below {bound:.0e} of each body's motion"


def proof_lines(
    proven: int, compared: int, largest: float, columns: "Iterable[Column]"
) -> Iterator[str]:
    """Lines on the number of proven landings, and on the error of double precision elsewhere.

    Args:
        proven: their number.
        compared: number of the others that were compared with a proof.
        largest: the largest difference in these, as in `double_difference`.
        columns: of the table.
    """
    if proven:
        landings = count(proven, "landing")
        yield f"exact (ill-conditioned, redundant, or a quantity that needs it): {landings}"
    if compared:
        rows = count(compared, "other landing" if proven else "landing")
        yield (
            f"double precision, compared with exact arithmetic in {rows}: off by at most "
            f"{largest:.0e} of the point's most severe shock"
        )
    in_doubles = [
        column.name for column in columns if column.selection.quantity.computation.exact != "always"
    ]
    if in_doubles:
        yield f"in double precision: {few(in_doubles, 4)}"


def without_value(columns: Iterable[tuple[str, Quantity]]) -> Iterator[str]:
    """The reasons why columns, of a name and a quantity, have no value in any landing."""
    for name, quantity in columns:
        if quantity.scope.missing:
            yield f"{name} has no value: {quantity.scope.missing}"


LEFT_OUT = (
    "on contacts of finite stiffness the change of geometry and springs before rotors of unknown "
    "inertia are left out; shockpc analyze reports where that matters in a landing"
)
"""Said of many landings, for which the warnings of each are not computed."""
