"""The report of a comparison."""

from shockpc.show.comparison import compare_report

__all__ = ["compare_report"]
