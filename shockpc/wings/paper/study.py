"""The paper's figures: each panel is a scene in `robots/scenes`, for `shockpc analyze` too."""

from collections.abc import Sequence

from shockpc import UnknownName
from shockpc.wings.paper.beam import BEAM
from shockpc.wings.paper.claim import PaperFigure
from shockpc.wings.paper.leg import LEG
from shockpc.wings.paper.quadruped import QUADRUPED
from shockpc.wings.paper.skippy import SKIPPY

FIGURES = (BEAM, LEG, SKIPPY, QUADRUPED)
DRAWN = (
    "the paper that can be drawn (figure 4 is a photograph; the claim in its caption is listed "
    "with figure 2)"
)


def paper_figures(wanted: Sequence[str]) -> list[PaperFigure]:
    """The figures that are named, or all of them without names, in the paper's order.

    A name may be "2", "fig2" or "Figure 2".

    Raises:
        UnknownName: the paper has no such figure, or it is a photograph.
    """
    known = [str(figure.number) for figure in FIGURES]
    numbers = [
        text.casefold().removeprefix("fig").removeprefix("ure").strip(" ._") for text in wanted
    ]
    for text, number in zip(wanted, numbers, strict=True):
        if number not in known:
            raise UnknownName("figure", text, known, DRAWN, "shockpc paper --help")
    return [
        figure
        for figure, number in zip(FIGURES, known, strict=True)
        if number in (numbers or known)
    ]
