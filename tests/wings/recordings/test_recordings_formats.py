"""All formats of reports of recordings have the same cells."""

from pathlib import Path

import pytest
from cells import check
from test_table import STUDIES

from shockpc.wings.recordings.identify.report import identify_report
from shockpc.wings.recordings.recorded.report import recorded_report
from shockpc.wings.recordings.touchdowns.report import touchdowns_report

REPORTS = {
    "identify": lambda found: identify_report(Path("tosses.csv"), found),
    "recorded": lambda found: recorded_report("log.csv", found.landings, found.table),
    "touchdowns": lambda found: touchdowns_report(Path("log.csv"), found),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", REPORTS)
def test_every_format_has_the_same_cells(name, tmp_path):
    check(REPORTS[name](STUDIES[name][0](tmp_path)))
