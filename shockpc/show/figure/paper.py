"""A figure of the paper, computed again: its panels side by side, on one scale and with one set of colours."""

import textwrap

from matplotlib.figure import Figure

from shockpc.paper.figures import Panel, PaperFigure
from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.canvas import add_axes, new_page, render
from shockpc.show.figure.marks import draw_marks, letter
from shockpc.show.figure.page import LINE, colour_bar, coordinates, key
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.view import view_of
from shockpc.show.figure.window import Window, windows_of
from shockpc.show.header import angle_text, joint_model_text

__all__ = ["draw_paper_figure", "paper_figure_files"]

MOST, LEAST = (9.6, 3.6), (1.55, 1.0)
"""Largest sides of all panels together, and smallest sides of one [inches]."""

LEFT, MARGIN, GAP, HEAD, CAPTION, FOOT, BAR = 0.62, 0.2, 0.15, 0.5, 0.75, 0.85, 4.6
"""Room for the vertical coordinate, at the other edges, between panels, for the title, for coordinates and labels below the panels,
and for the colour bar; and its width [inches]."""

NEAR = (0.7, 0.26)
"""Distance from the robot, sideways and up, as a share of its size, up to which a centre of percussion is in the panel."""


def paper_figure_files(figure: PaperFigure) -> dict[str, bytes]:
    """A figure of the paper as SVG and PNG, by file name."""
    files = render(lambda: draw_paper_figure(figure))
    return {f"figure{figure.number}.{format_}": data for format_, data in files.items()}


def draw_paper_figure(figure: PaperFigure) -> Figure:
    """Draw a figure of the paper.

    A body has the same number in every panel, and so has its centre of percussion. Centres outside a panel are given under it.
    """
    profiles = figure.profiles
    views = [view_of(profile) for profile in profiles]
    names = list(dict.fromkeys(body for profile in profiles for body in profile.bodies))
    numbers = [{i: names.index(body) + 1 for i, body in enumerate(profile.bodies)} for profile in profiles]
    windows = windows_of(views, numbers, NEAR, MOST, LEAST)
    widths, height = [window.sides[0] for window in windows], windows[0].sides[1]
    across = sum(widths) + GAP * (len(widths) - 1)
    width = LEFT + max(across, BAR + 3.5) + MARGIN
    captions = [_caption(*one) for one in zip(figure.panels, profiles, windows, numbers, strict=True)]
    sensors = list(dict.fromkeys(point.frame for profile in profiles for point in profile.points))
    words = ["bodies: " + ", ".join(f"{k} {name.replace('_', ' ')}" for k, name in enumerate(names, start=1))]
    words += ["sensors: " + ", ".join(f"{letter(k)} {name}" for k, name in enumerate(sensors))] if sensors else []
    words += textwrap.wrap(figure.note, int(width / 0.056))
    foot = FOOT + LINE * len(words)
    bottom = foot + CAPTION + 0.13 * max(map(len, captions))
    top = HEAD + height + bottom
    drawing, page = new_page(width, top)
    page.text(MARGIN, top - 0.12, f"Figure {figure.number}: {figure.title}", fontsize=11, fontweight="bold", va="top")
    models = " or ".join(dict.fromkeys(joint_model_text(profile) for profile in profiles))
    page.text(MARGIN, top - 0.33, f"joint model: {models}", va="top")
    x, signs = LEFT + (width - LEFT - MARGIN - across) / 2.0, set()
    for k, (part, profile, view, window) in enumerate(zip(figure.panels, profiles, views, windows, strict=True)):
        picture = add_axes(drawing, x, bottom, widths[k], height)
        coordinates(picture, window, profile, first=k == 0)
        signs |= draw_bodies(picture, view) | draw_marks(picture, view, window, numbers[k])
        middle, y = x + widths[k] / 2.0, bottom - 0.42
        page.text(middle, y, part.label, fontsize=10, fontweight="bold", ha="center", va="top")
        page.text(middle, y - 0.17, "\n".join(captions[k]), fontsize=7, ha="center", va="top", linespacing=1.25)
        x += widths[k] + GAP
    colour_bar(drawing, LEFT, foot - 0.1, BAR)
    key(page, signs, (LEFT + BAR + 0.4, foot))
    for k, text in enumerate(words):
        page.text(MARGIN, foot - FOOT - LINE * k, text, va="top", fontstyle="normal" if k <= bool(sensors) else "italic")
    return drawing


def _caption(part: Panel, profile: ShockProfile, window: Window, numbers: dict[int, int]) -> list[str]:
    """What a panel shows, how it is struck, and the centres of percussion outside it."""
    lines = [part.words, f"strike angle {angle_text(profile)} deg"]
    centres = to_plane(profile.copc_world, profile.plane)
    for i, number in numbers.items():
        if not profile.translates[i] and not window.holds(centres[i], 0.05):
            lines.append("CoPc {} at ({:.2f}, {:.2f}) m".format(number, *centres[i].round(2) + 0.0))
    return [line.replace(" -", " −").replace("(-", "(−") for line in lines]
