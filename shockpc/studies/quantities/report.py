"""The table of quantities, with a column for each property.

These are key, kind of place, unit, title, which change is worse, whether it can be written in
symbols, and when a value is missing.
"""

from shockpc.quantities.selection import QUANTITIES, has_symbolic_form
from shockpc.show.report import Report
from shockpc.show.tables import Sheet
from shockpc.text.names import match

COLUMNS = ("key", "of", "unit", "title", "worse")


def quantities_report(pattern: str | None = None) -> Report:
    """The quantities whose key or kind is a name, or matches a glob.

    Raises:
        UnknownName: there is none.
    """
    names: list[str] = []
    for quantity in QUANTITIES:
        names += [quantity.key, quantity.of]
    chosen = match("*" if pattern is None else pattern, names, "quantity", "", "shockpc quantities")
    rows = []
    for quantity in QUANTITIES:
        if quantity.key in chosen or quantity.of in chosen:
            symbols = "yes" if has_symbolic_form(quantity) else "no"
            values = [getattr(quantity, name) for name in COLUMNS]
            rows.append((*values, symbols, quantity.note))
    sheet = Sheet("quantities of a landing", (*COLUMNS, "symbols", "note"), rows)
    return Report(
        name="quantities",
        title="Quantities of a landing",
        body=lambda _: [sheet],
        sheets={"quantities": lambda: sheet},
        document=dict,
        tables=True,
    )
