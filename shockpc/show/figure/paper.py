"""A figure of the paper, computed again: its panels side by side."""

from matplotlib.figure import Figure

from shockpc.paper.claim import PaperFigure
from shockpc.show.figure.canvas import render
from shockpc.show.figure.panels import draw_panels
from shockpc.show.figure.view import view_of
from shockpc.show.header import joint_model_text

__all__ = ["draw_paper_figure", "paper_figure_files"]


def paper_figure_files(figure: PaperFigure) -> dict[str, bytes]:
    """A figure of the paper as SVG and PNG, by file name."""
    files = render(lambda: draw_paper_figure(figure))
    return {f"figure{figure.number}.{format_}": data for format_, data in files.items()}


def draw_paper_figure(figure: PaperFigure) -> Figure:
    """Draw a figure of the paper, all bodies numbered."""
    profiles = figure.profiles
    names = list(dict.fromkeys(body for profile in profiles for body in profile.bodies))
    return draw_panels(
        profiles,
        [view_of(profile) for profile in profiles],
        [{i: names.index(body) + 1 for i, body in enumerate(profile.bodies)} for profile in profiles],
        f"Figure {figure.number}: {figure.title}",
        "joint model: " + " or ".join(dict.fromkeys(joint_model_text(profile) for profile in profiles)),
        [panel.label for panel in figure.panels],
        [[panel.words] for panel in figure.panels],
        figure.note,
    )
