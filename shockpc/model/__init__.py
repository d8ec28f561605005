"""Robots: from a file to arrays. The only place that imports Pinocchio."""

__all__ = ["CHECKED"]

CHECKED = {"extra": "forbid", "allow_inf_nan": False}
"""How scene files are checked against the records they become: no unknown keys, no numbers that are not finite."""
