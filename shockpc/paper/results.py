"""The figures of the paper computed: a shock profile for every panel, and the claims."""

from typing import NamedTuple

from shockpc.paper.beam import BEAM_CLAIMS
from shockpc.paper.claim import Claim
from shockpc.paper.landings import land
from shockpc.paper.leg import LEG_CLAIMS
from shockpc.paper.quadruped import QUADRUPED_CLAIMS
from shockpc.paper.scenes import PaperFigure
from shockpc.paper.skippy import SKIPPY_CLAIMS
from shockpc.result import ShockProfile

__all__ = ["CLAIMS", "FigureResult", "figure_result"]

CLAIMS = {1: BEAM_CLAIMS, 2: LEG_CLAIMS, 3: SKIPPY_CLAIMS, 5: QUADRUPED_CLAIMS}
"""All claims, by the number of the figure whose models decide them."""


class FigureResult(NamedTuple):
    """A figure, the shock profiles of its panels, and the claims that its models decide."""

    figure: PaperFigure
    profiles: tuple[ShockProfile, ...]
    claims: tuple[Claim, ...]


def figure_result(figure: PaperFigure) -> FigureResult:
    """Compute the panels of a figure."""
    return FigureResult(figure, tuple(land(panel.scene) for panel in figure.panels), CLAIMS[figure.number])
