"""One description of a table: terminal, Markdown, CSV and JSON of every study show the same cells."""

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import pytest
from test_agreement import SCENES
from test_table import STUDIES
from trees import known_robot

from shockpc import Scene, shock_profile
from shockpc.bench.report import bench_report
from shockpc.quantities.renamed import former_key
from shockpc.show.tables import SHOWN, Sheet, as_csv, as_markdown, as_records, as_text, escaped
from shockpc.studies.analyze.report import analyze_report
from shockpc.studies.batch.report import batch_report
from shockpc.studies.check.report import check_report
from shockpc.studies.compare.report import compare_report
from shockpc.studies.improve.report import improve_report
from shockpc.studies.limits.report import limits_report
from shockpc.studies.place.report import place_report
from shockpc.studies.quantities.report import quantities_report
from shockpc.studies.robots.report import robot_report, robots_report
from shockpc.studies.sensitivity.report import sensitivity_report
from shockpc.studies.sweep.report import sweep_report
from shockpc.studies.sweep.summary import summarise
from shockpc.wings.fall.report import fall_report
from shockpc.wings.paper.report import paper_report
from shockpc.wings.paper.study import FIGURES
from shockpc.wings.recordings.identify.report import identify_report
from shockpc.wings.recordings.recorded.report import recorded_report
from shockpc.wings.recordings.touchdowns.report import touchdowns_report

WORDS = ("-", "s", "m", "m/s", "rad/s", "kg", "N", "N s", "N m s", "N m", "J", "Hz", "g", "deg")
REPORTS = {
    "batch": batch_report,
    "check_budgets": check_report,
    "compare": compare_report,
    "fall": fall_report,
    "identify": lambda found: identify_report(Path("tosses.csv"), found),
    "improve": improve_report,
    "recorded": lambda found: recorded_report("log.csv", found.landings, found.table),
    "limits": limits_report,
    "place": place_report,
    "sensitivity": sensitivity_report,
    "sweep": lambda found: sweep_report(summarise(found, found.table, found.landings.variations)),
    "touchdowns": lambda found: touchdowns_report(Path("log.csv"), found),
}


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
            [one.key for one in sheet.columns],
            [one.heading(exact=True) for one in sheet.columns],
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
                for one in sheet.columns
                for key in (one.key, former_key(one.key))
                if one.unit
            }
        assert not {one.exact_unit for one in sheet.columns} & SHOWN.keys()
    blocks = [*report.body(True), *report.body(False), *(report.brief() if report.brief else ())]
    shown = [block for block in blocks if isinstance(block, Sheet)]
    assert shown
    for sheet in shown:
        cells = sheet.without(*IN_WORDS.get(report.name, ()))
        assert any(is_part(cells, whole) for whole in sheets.values()), sheet
        text, markdown = as_text(sheet), as_markdown(sheet)
        for row in sheet.rows:
            for column, cell in zip(sheet.columns, row, strict=True):
                assert escaped(column.shown(cell)) in markdown
                assert column.shown(cell)[:30] in text
    return sheets


def is_part(sheet, whole):
    """Whether a table has only cells of another, under the same keys and with the same units."""
    units = {one.key: one.exact_unit for one in whole.columns}
    if not all(
        one.exact_unit in ("", units.get(one.key), *WORDS) and one.key in units
        for one in sheet.columns
    ):
        return False
    rows = [tuple(map(str, row)) for row in whole.only(*(one.key for one in sheet.columns)).rows]
    return all(tuple(map(str, row)) in rows for row in sheet.rows)


def test_every_study_is_among_these():
    assert STUDIES.keys() == REPORTS.keys()


@pytest.mark.slow
@pytest.mark.parametrize("name", REPORTS)
def test_every_format_of_a_study_has_the_same_cells(name, tmp_path):
    found = STUDIES[name][0](tmp_path)
    check(REPORTS[name](found))


@pytest.mark.parametrize(
    "made",
    [
        lambda: robots_report({"anymal_b": known_robot("anymal_b"), "none": None}, 1),
        lambda: robot_report(known_robot("anymal_b")),
        lambda: quantities_report("joint*"),
        lambda: paper_report(FIGURES[:1]),
        lambda: bench_report(known_robot("leg"), Scene(robot="leg", contact="heel"), 0.0),
    ],
    ids=["robots", "robot", "quantities", "paper", "bench"],
)
def test_every_format_of_what_is_no_study_has_the_same_cells(made):
    check(made())


@pytest.mark.parametrize("name", SCENES)
def test_every_format_of_a_landing_has_the_same_cells(name):
    profile = shock_profile(SCENES[name], known_robot("anymal_b"))
    check(analyze_report({"one": profile}))
    other = shock_profile(
        replace(SCENES[name], contact="RF_FOOT", stance=()), known_robot("anymal_b")
    )
    check(analyze_report({"one": profile, "other": other}))
