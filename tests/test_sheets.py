"""One description of a table: terminal, Markdown, CSV and JSON of every study show the same cells."""

from dataclasses import replace

import pytest
from cells import check
from test_agreement import SCENES
from test_table import STUDIES
from trees import known_robot

from shockpc import Scene, shock_profile
from shockpc.bench.report import bench_report
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

REPORTS = {
    "batch": batch_report,
    "check_budgets": check_report,
    "compare": compare_report,
    "improve": improve_report,
    "limits": limits_report,
    "place": place_report,
    "sensitivity": sensitivity_report,
    "sweep": lambda found: sweep_report(summarise(found, found.table, found.landings.variations)),
}


OF_WINGS = {"fall", "identify", "recorded", "touchdowns"}
"""Studies whose formats are checked beside the tests of their wing."""


def test_every_study_is_among_these():
    assert STUDIES.keys() == REPORTS.keys() | OF_WINGS


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
        lambda: bench_report(known_robot("leg"), Scene(robot="leg", contact="heel"), 0.0),
    ],
    ids=["robots", "robot", "quantities", "bench"],
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
