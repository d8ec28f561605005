"""A table of a landing as people read it."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.tables import Sheet

Keys = Mapping[str, str]
"""Headings of columns by key in the order of reading; an empty one stands for that of the sheet.

The key of a vector stands for its components, and {} in its heading for the component.
"""


class View(NamedTuple):
    """A table that people read of a landing: some columns of a sheet that has every quantity.

    Columns without any cell are left out. `keys` and `title` are functions of the landing where
    they depend on it.

    Attributes:
        sheet: the table with every quantity.
        condition: whether a landing has the view.
        keys: of the columns; None for all of the sheet.
        title: over it; by default that of the sheet.
        notes: under it, after those of the sheet.
        sizes: of the rows, of which a terminal shows those of the largest; by default it shows all.
        row: what a row is, for the note on those that are not shown.
        ranked: key of the column whose largest numbers come first; by default the order is that of
            the sheet.
        brief: whether it belongs to the answer, which a terminal shows without --all.
    """

    sheet: Callable[[ShockProfile], Sheet]
    condition: Callable[[ShockProfile], object]
    keys: Keys | Callable[[ShockProfile], Keys] | None
    title: str | Callable[[ShockProfile], str] = ""
    notes: Callable[[ShockProfile], Sequence[str]] = lambda _: ()
    sizes: Callable[[ShockProfile, Sheet], Sequence[float]] | None = None
    row: str = ""
    ranked: str = ""
    brief: bool = False

    def of(self, profile: ShockProfile, most: int | None = None) -> Sheet:
        """The table of a landing. Args: profile; most, rows of a long table, None for all."""
        keys = self.keys(profile) if callable(self.keys) else self.keys
        title = self.title(profile) if callable(self.title) else self.title
        sheet = self.sheet(profile)
        view = sheet if keys is None else _headed(sheet, keys)
        notes = (*sheet.notes, *self.notes(profile))
        view = view._replace(title=title or sheet.title, notes=notes)
        if self.sizes is not None:
            view = view.largest(most, self.row, self.sizes(profile, view))
        if self.ranked:
            view = view.ranked(self.ranked)
        return view.known()


def _headed(sheet: Sheet, keys: Keys) -> Sheet:
    """Some columns of a sheet that it has, under their headings."""
    headings = {}
    for key, heading in keys.items():
        headings[key] = heading
        for axis in "xyz":
            headings[f"{key}_{axis}"] = heading.format(axis)
    return sheet.only(*headings).headed(headings)


def kept(*keys: str) -> dict[str, str]:
    """Columns with the headings of the sheet."""
    return dict.fromkeys(keys, "")
