"""The paper's figures as scenes: each panel is a TOML file in `robots/scenes`, which `shockpc analyze` reads as well."""

from collections.abc import Sequence
from typing import NamedTuple

from shockpc.errors import SceneError, UnknownName

__all__ = ["FIGURES", "Panel", "PaperFigure", "paper_figures"]


class Panel(NamedTuple):
    """One panel of a figure: the letter or angle under it, the name of its scene file without ".toml", and what it shows."""

    label: str
    scene: str
    words: str


class PaperFigure(NamedTuple):
    """A figure of the paper that is drawn from a model; the note says what is assumed or not given in the paper."""

    number: int
    title: str
    panels: tuple[Panel, ...]
    note: str


FIGURES = (
    PaperFigure(
        1,
        "a slender beam on a slider",
        (
            Panel("A", "fig1_a", "at the centre of mass"),
            Panel("B", "fig1_b", "elsewhere: the tip"),
            Panel("C", "fig1_c", "at 2/3, the CoPc of O"),
            Panel("D", "fig1_d", "at the pivot O"),
        ),
        "The pivot O is the left end. The text does not give the impact point of B; Eq. 3 allows the tip or a third of the length.",
    ),
    PaperFigure(
        2,
        "a human leg",
        (
            Panel("A", "fig2_a", "walking"),
            Panel("B", "fig2_b", "running"),
            Panel("C", "fig2_c", "climbing stairs"),
            Panel("D", "fig2_d", "C with a torso"),
            Panel("E", "fig2_e", "steep, with a torso"),
            Panel("F", "fig2_f", "E with a foot"),
        ),
        "The text gives neither the strike angles nor the angle of the lower leg; the scene files state the values chosen here.",
    ),
    PaperFigure(
        3,
        "Skippy",
        (Panel("Skippy", "fig3", "after a vertical jump"),),
        "Assumed, not published with the paper: all masses, most lengths, the drive, and the IMU locations a and b.",
    ),
    PaperFigure(
        5,
        "a quadruped on its hind leg",
        (
            Panel("0°", "fig5_00", "straight legs"),
            Panel("10°", "fig5_10", "leg segments from the vertical"),
            Panel("20°", "fig5_20", "leg segments from the vertical"),
            Panel("30°", "fig5_30", "leg segments from the vertical"),
        ),
        "The text does not give the directions of knees and torso; here the hind knee points forward and the nose is up.",
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
