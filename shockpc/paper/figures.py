"""The paper's figures: each panel is a scene in `robots/scenes`, which `shockpc analyze` reads as well."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from shockpc.errors import SceneError, UnknownName
from shockpc.paper.beam import BEAM_CLAIMS
from shockpc.paper.claim import Claim
from shockpc.paper.landings import land
from shockpc.paper.leg import LEG_CLAIMS
from shockpc.paper.quadruped import QUADRUPED_CLAIMS
from shockpc.paper.skippy import SKIPPY_CLAIMS
from shockpc.result import ShockProfile

__all__ = ["FIGURES", "Panel", "PaperFigure", "paper_figures"]


class Panel(NamedTuple):
    """One panel of a figure: the letter or angle under it, the name of its scene file without ".toml", and what it shows."""

    label: str
    scene: str
    words: str


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper that is drawn from a model.

    Attributes:
        number: in the paper.
        title: short description.
        note: what is assumed or not given in the paper.
        claims: those that the models of the figure decide.
        panels: from left to right.
    """

    number: int
    title: str
    note: str
    claims: tuple[Claim, ...]
    panels: tuple[Panel, ...]

    @cached_property
    def profiles(self) -> tuple[ShockProfile, ...]:
        """The shock profile of every panel."""
        return tuple(land(panel.scene) for panel in self.panels)


FIGURES = (
    PaperFigure(
        1,
        "a slender beam on a slider",
        "The pivot O is the left end. The text does not give the impact point of B; Eq. 3 allows the tip or a third of the length.",
        BEAM_CLAIMS,
        (
            Panel("A", "fig1_a", "at the centre of mass"),
            Panel("B", "fig1_b", "elsewhere: the tip"),
            Panel("C", "fig1_c", "at 2/3, the CoPc of O"),
            Panel("D", "fig1_d", "at the pivot O"),
        ),
    ),
    PaperFigure(
        2,
        "a human leg",
        "The text gives neither the strike angles nor the angle of the lower leg; the scene files state the values chosen here.",
        LEG_CLAIMS,
        (
            Panel("A", "fig2_a", "walking"),
            Panel("B", "fig2_b", "running"),
            Panel("C", "fig2_c", "climbing stairs"),
            Panel("D", "fig2_d", "C with a torso"),
            Panel("E", "fig2_e", "steep, with a torso"),
            Panel("F", "fig2_f", "E with a foot"),
        ),
    ),
    PaperFigure(
        3,
        "Skippy",
        "Assumed, not published with the paper: all masses, most lengths, the drive, and the IMU locations a and b.",
        SKIPPY_CLAIMS,
        (Panel("Skippy", "fig3", "after a vertical jump"),),
    ),
    PaperFigure(
        5,
        "a quadruped on its hind leg",
        "The text does not give the directions of knees and torso; here the hind knee points forward and the nose is up.",
        QUADRUPED_CLAIMS,
        (
            Panel("0°", "fig5_00", "straight legs"),
            Panel("10°", "fig5_10", "leg segments from the vertical"),
            Panel("20°", "fig5_20", "leg segments from the vertical"),
            Panel("30°", "fig5_30", "leg segments from the vertical"),
        ),
    ),
)

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
