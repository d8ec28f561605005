"""The table of quantities: key, kind of place, unit, title, which change is worse, and when a value is missing."""

from shockpc.errors import UnknownName
from shockpc.quantities.table import QUANTITIES
from shockpc.show.document import record
from shockpc.show.reports.report import Report
from shockpc.show.tables import Sheet, fits

__all__ = ["quantities_report"]

COLUMNS = ("key", "of", "unit", "title", "worse", "note")


def quantities_report(pattern: str | None = None) -> Report:
    """The quantities whose key or kind matches a pattern.

    Raises:
        UnknownName: there is none.
    """
    chosen = [one for one in QUANTITIES if pattern is None or any(fits(name, pattern) for name in (one.key, one.of))]
    if not chosen and pattern is not None:
        raise UnknownName("quantity", pattern, [one.key for one in QUANTITIES], "the table of quantities", "shockpc quantities")
    rows = [record(one, *COLUMNS) for one in chosen]
    sheet = Sheet("quantities of a landing", ("key", "of", "unit", "title", "worse", "note"), [tuple(row.values()) for row in rows])
    return Report(
        name="quantities",
        title="Quantities of a landing",
        tables=lambda _: [sheet],
        sheets={"quantities": lambda: sheet},
        document=lambda: {"quantities": rows},
    )
