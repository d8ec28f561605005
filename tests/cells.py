"""What all formats of a report have in common: the cells of its tables."""

import csv
import io
import json

from shockpc.quantities.renamed import former_key
from shockpc.show.tables import SHOWN, Sheet, as_csv, as_markdown, as_records, as_text, escaped

WORDS = ("-", "s", "m", "m/s", "rad/s", "kg", "N", "N s", "N m s", "N m", "J", "Hz", "g", "deg")

IN_WORDS = {"check": ("result", "landing", "limit")}
"""Columns of tables for people that say in words what others of CSV and JSON hold, by report."""


def known(cell):
    return cell is not None and cell == cell


def check(report):
    """Every cell of CSV is that of JSON, and every table for people is a part of one of these, with
    the same cells.
    """
    sheets = {name: sheet() for name, sheet in report.sheets.items()}
    written = json.loads(report.text("json")) if report.tables else {}
    assert not report.tables or (written["schema"], list(written["tables"])) == (
        f"shockpc.{report.name}/2",
        list(sheets),
    )
    for name, sheet in sheets.items():
        keys, headings = (
            [one.key for one in sheet.headings],
            [one.with_unit(exact=True) for one in sheet.headings],
        )
        assert len(set(keys)) == len(keys), name
        assert len(set(headings)) == len(headings), name
        header, *lines = csv.reader(io.StringIO(as_csv(sheet)))
        assert header == headings
        records = written["tables"][name] if written else json.loads(json.dumps(as_records(sheet)))
        former = [former_key(key) for key in keys if former_key(key) != key]
        assert [list(row) for row in records] == [[*keys, *former]] * len(lines)
        for row, line in zip(records, lines, strict=True):
            assert all(row[former_key(key)] == row[key] for key in keys)
            for value, cell in zip([row[key] for key in keys], line, strict=True):
                if isinstance(value, str):
                    assert cell.removeprefix("'") == value
                else:
                    assert cell == (
                        ""
                        if value is None
                        else ("no", "yes")[value]
                        if isinstance(value, bool)
                        else repr(value)
                    )
        if written:
            assert written["units"][name] == {
                key: one.exact_unit
                for one in sheet.headings
                for key in (one.key, former_key(one.key))
                if one.unit
            }
        assert not {one.exact_unit for one in sheet.headings} & SHOWN.keys()
    blocks = [*report.body(True), *report.body(False), *(report.brief() if report.brief else ())]
    shown = [block for block in blocks if isinstance(block, Sheet)]
    assert shown
    for sheet in shown:
        cells = sheet.without(*IN_WORDS.get(report.name, ()))
        assert any(is_part(cells, whole) for whole in sheets.values()), sheet
        text, markdown = as_text(sheet), as_markdown(sheet)
        for row in sheet.rows:
            for column, cell in zip(sheet.headings, row, strict=True):
                assert escaped(column.shown(cell)) in markdown
                assert column.shown(cell)[:30] in text
    return sheets


def is_part(sheet, whole):
    """Whether a table has only cells of another, under the same keys and with the same units."""
    units = {one.key: one.exact_unit for one in whole.headings}
    if not all(
        one.exact_unit in ("", units.get(one.key), *WORDS) and one.key in units
        for one in sheet.headings
    ):
        return False
    rows = [tuple(map(str, row)) for row in whole.only(*(one.key for one in sheet.headings)).rows]
    return all(tuple(map(str, row)) in rows for row in sheet.rows)
