"""Times at which a contact touches, by a column of flags or of forces in a log."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.text.errors import StudyError, UnknownName

OFF = 20e-3
"""Time without contact before a touchdown [s].

For half of that time after it there is contact, if the foot does not bounce.
"""

BOUNCE = 10.0
"""Mean force from which a foot that bounces has landed too, in thresholds of the force.

It is the mean over that time after a touchdown.
"""

FORCE = 0.05
"""Force of a contact, in weights of the robot, but at least 1 N."""

SIGNS = ("contact", "touch", "force", "fz", "grf")
"""Words beside the name of a foot, in a column of flags or forces."""


class Flag(NamedTuple):
    """A column that says when a contact touches.

    Attributes:
        column: its name.
        signal: (n,) its values over their threshold: those above 1 say contact.
        force: the threshold of a force [N]; None where the column has flags.
    """

    column: str
    signal: Array
    force: float | None

    def touches(self, t: Array, first: int) -> tuple[list[int], list[int]]:
        """The last samples before touchdowns, and before contacts that are too short for one.

        Samples are counted from the first.

        Args:
            t: (m,) times of a part of the log without gaps [s].
            first: its first sample.
        """
        signal = self.signal[first : first + len(t)]
        on = signal > 1.0
        landings: list[int] = []
        short: list[int] = []
        for k in np.flatnonzero(on[1:] & ~on[:-1]).tolist():
            before, after = np.searchsorted(t, (t[k] - OFF, t[k] + OFF))
            if on[before : k + 1].any():
                continue
            stays = on[k + 1 : after + 1].mean() >= 0.5
            if stays or signal[k + 1 : after + 1].mean() >= BOUNCE:
                landings.append(k)
            else:
                short.append(k)
        return landings, short


def flags_of(
    columns: Mapping[str, np.ndarray],
    frames: Sequence[str],
    named: Mapping[str, str],
    force: float | None,
    weight: float,
) -> dict[int, Flag]:
    """The columns of flags or forces by the number of their contact.

    Args:
        columns: of the log that are no state of the robot.
        frames: the contacts.
        named: names of columns by frame; by default one that is called like it.
        force: threshold of forces [N]; by default a share of the weight.
        weight: of the robot [N].

    Raises:
        UnknownName: no contact, or no column of numbers, has such a name.
        StudyError: a threshold is given, and there are no forces, or a column that is named has no
            number.
    """
    numbers = {
        name: values
        for name, values in columns.items()
        if values.dtype.kind in "fiub" and values.ndim == 1
    }
    # A column without any number says nothing, so that the heights of the foot do.
    told = [name for name, values in numbers.items() if np.isfinite(values).any()]
    threshold = max(1.0, FORCE * weight) if force is None else force
    if unknown := [frame for frame in named if frame not in frames]:
        raise UnknownName("contact", unknown[0], frames, "those that are looked at", "")
    flags: dict[int, Flag] = {}
    for c, frame in enumerate(frames):
        name = named.get(frame) or _named_like(frame, told)
        if name is None:
            continue
        if name not in numbers:
            raise UnknownName(
                "column", name, numbers, "this log, of numbers that are no state of the robot", ""
            )
        if name not in told:
            raise StudyError(
                f'column {name} has no number, so it does not say when "{frame}" touches; name '
                f"another column with --flag, or leave --flag out"
            )
        flags[c] = _flag(name, numbers[name], threshold)
    if force is not None and all(flag.force is None for flag in flags.values()):
        raise StudyError(
            "contact_force is the threshold of columns of forces, but no contact has a column of "
            "forces; name it with --flag FRAME=COLUMN, or leave the threshold out"
        )
    return flags


def _named_like(frame: str, columns: Iterable[str]) -> str | None:
    """The first column whose name is that of a contact and one of `SIGNS`; None without one."""
    plain = {_plain(sign + frame) for sign in SIGNS} | {_plain(frame + sign) for sign in SIGNS}
    return next((name for name in columns if _plain(name) in plain), None)


def _flag(name: str, values: np.ndarray, threshold: float) -> Flag:
    """The flag of a column; cells without a number have that of the last one before.

    Args:
        name: of the column.
        values: (n,) in it.
        threshold: from which a force counts as contact [N].
    """
    values = values.astype(float)
    known = np.isfinite(values)
    # Those before the first number have that one.
    latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), np.argmax(known)))
    values = np.where(known, values, 0.0)[latest]
    if np.isin(values, (0.0, 1.0)).all():
        return Flag(name, np.abs(values) / 0.5, None)
    return Flag(name, np.abs(values) / threshold, threshold)


def _plain(name: str) -> str:
    """A name without what separates its words."""
    return re.sub("[^a-z0-9]", "", name.casefold())
