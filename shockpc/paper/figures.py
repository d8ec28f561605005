"""The paper's figures: each panel is a scene in `robots/scenes`, which `shockpc analyze` reads as well."""

from collections.abc import Sequence

from shockpc.errors import SceneError, UnknownName
from shockpc.paper.beam import BEAM
from shockpc.paper.claim import PaperFigure
from shockpc.paper.leg import LEG
from shockpc.paper.quadruped import QUADRUPED
from shockpc.paper.skippy import SKIPPY

__all__ = ["FIGURES", "paper_figures"]

FIGURES = (BEAM, LEG, SKIPPY, QUADRUPED)

NO_FIGURE_4 = (
    "Figure 4 of the paper is a photograph of a leg prosthesis, so there is nothing to draw; the claim in its caption is listed "
    'with figure 2: shockpc paper 2. Figures that can be drawn: "1", "2", "3", "5"'
)


def paper_figures(wanted: Sequence[str]) -> tuple[PaperFigure, ...]:
    """The figures that are wanted, such as "2", "fig2" or "Figure 2", in the paper's order; all of them if none is named.

    Raises:
        UnknownName: the paper has no such figure.
        SceneError: the figure is a photograph.
    """
    known = {str(figure.number): figure for figure in FIGURES}
    chosen = set()
    for text in wanted:
        number = text.casefold().removeprefix("figure").removeprefix("fig").strip(" ._")
        if number == "4":
            raise SceneError(NO_FIGURE_4)
        if number not in known:
            raise UnknownName("figure", text, known, "the paper", "shockpc paper --help")
        chosen.add(number)
    return tuple(figure for number, figure in known.items() if not chosen or number in chosen)
