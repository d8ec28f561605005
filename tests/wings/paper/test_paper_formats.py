"""All formats of the report of the paper have the same cells."""

from cells import check

from shockpc.wings.paper.report import paper_report
from shockpc.wings.paper.study import FIGURES


def test_every_format_has_the_same_cells():
    check(paper_report(FIGURES[:1]))
