"""All formats of the report of a fall have the same cells."""

import pytest
from cells import check
from test_table import STUDIES

from shockpc.wings.fall.report import fall_report


@pytest.mark.slow
def test_every_format_has_the_same_cells(tmp_path):
    check(fall_report(STUDIES["fall"][0](tmp_path)))
