"""The paper computed again: the landing of every panel, and every statement with its verdict."""

from typing import NamedTuple

from shockpc.paper.beam import beam_statements
from shockpc.paper.landings import land
from shockpc.paper.leg_statements import leg_statements
from shockpc.paper.quadruped import quadruped_statements
from shockpc.paper.scenes import PaperFigure
from shockpc.paper.skippy import skippy_statements
from shockpc.paper.statement import Statement
from shockpc.result import ShockProfile

__all__ = ["FigureResult", "figure_result"]

STATEMENTS = {1: beam_statements, 2: leg_statements, 3: skippy_statements, 5: quadruped_statements}


class FigureResult(NamedTuple):
    """One figure, computed.

    Attributes:
        figure: which.
        profiles: of its panels.
        statements: that the paper makes about it, or that it can decide.
    """

    figure: PaperFigure
    profiles: tuple[ShockProfile, ...]
    statements: tuple[Statement, ...]


def figure_result(figure: PaperFigure) -> FigureResult:
    """Compute a figure of the paper and judge what the paper says of it."""
    return FigureResult(figure, tuple(land(panel.scene) for panel in figure.panels), STATEMENTS[figure.number]())
