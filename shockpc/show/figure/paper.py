"""A figure of the paper: its panels side by side, with one scale, one set of colours and one key. Lengths on the page in inches."""

import textwrap
from collections.abc import Callable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from shockpc.core.spatial import Array
from shockpc.paper.scenes import PaperFigure
from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.marks import DASHED, SENSOR, draw_marks, percussion_mark
from shockpc.show.figure.page import colour_bar, joint_model, scale_bar
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.style import STYLE, blank
from shockpc.show.figure.view import View, view_of
from shockpc.show.figure.window import ARROW, Window, letter, strike_in_plane
from shockpc.show.strike import strike_angle

__all__ = ["draw_paper_figure"]

WIDEST, TALLEST, NARROWEST = 9.6, 3.6, 1.6
"""Largest sides of all panels together, and least width of a panel [inches]."""

MARGIN, HEAD, CAPTION, BAR, PAD, POINTER = 0.2, 0.5, 0.58, 0.62, 0.2, 0.5
"""Space around the page, for the title, a caption, the colour bar, around the contents of a panel, and for pointers [inches]."""

LINE, COLUMN = 0.19, 2.75
"""Height of a line and width of a column of the key [inches]."""

CIRCLE = 0.98
"""Share of the circle of a RoPc that has to lie in its panel for the circle to be drawn [1]."""

NEAR = np.array([0.7, 0.26])
"""Largest distance, sideways and up, of a CoPc from the robot for a panel to include it, over the robot's size [1]."""

WARNING = "#932c22"
"""Colour of the note."""


def draw_paper_figure(figure: PaperFigure, profiles: Sequence[ShockProfile]) -> Figure:
    """Draw a figure of the paper.

    The contacts of all panels are at the same height. A body has the same number in every panel, and its CoPc carries that number.

    Args:
        figure: the figure.
        profiles: the shock profiles of its panels.
    """
    with matplotlib.rc_context(STYLE):
        views = [view_of(profile) for profile in profiles]
        names = list(dict.fromkeys(body for profile in profiles for body in profile.bodies))
        windows, widths, height = _windows(profiles, views)
        width = max(sum(widths), 6.2)
        bodies = "bodies: " + ", ".join(f"{k} {name.replace('_', ' ')}" for k, name in enumerate(names, start=1))
        text, note = (textwrap.wrap(words, int(width / 0.054)) for words in (bodies, figure.note))
        columns = int(width // COLUMN)
        key = LINE * (len(text) + len(note) + -(-5 // columns))
        page_width, page_height = width + 2.0 * MARGIN, HEAD + height + CAPTION + BAR + key + MARGIN / 2.0
        drawing = Figure(figsize=(page_width, page_height), facecolor=PAPER)
        page = drawing.add_axes((0.0, 0.0, 1.0, 1.0))
        blank(page, (0.0, page_width), (0.0, page_height))
        page.text(MARGIN, page_height - 0.12, f"Figure {figure.number}: {figure.title}", fontsize=11, fontweight="bold", va="top")
        models = " or ".join(dict.fromkeys(map(joint_model, profiles)))
        page.text(MARGIN, page_height - 0.33, f"joint model: {models}", fontsize=7.5, va="top")
        x, y = MARGIN + (width - sum(widths)) / 2.0, page_height - HEAD - height
        signs: set[str] = set()
        for part, profile, view, window, wide in zip(figure.panels, profiles, views, windows, widths, strict=True):
            picture = drawing.add_axes((x / page_width, y / page_height, wide / page_width, height / page_height))
            blank(picture, (window.low[0], window.high[0]), (window.low[1], window.high[1]))
            draw_bodies(picture, view)
            numbers = {i: names.index(body) + 1 for i, body in enumerate(profile.bodies)}
            signs |= draw_marks(picture, profile, view, window, numbers, CIRCLE, tied=True)
            middle = x + wide / 2.0
            page.text(middle, y - 0.04, part.label, fontsize=10, fontweight="bold", ha="center", va="top")
            caption = f"{part.words}\nθ = {strike_angle(profile)}°".replace("-", "−")
            page.text(middle, y - 0.22, caption, fontsize=7.5, ha="center", va="top")
            x += wide
        y -= CAPTION
        colour_bar(page, MARGIN, y - 0.05, 4.6)
        scale_bar(page, windows[0], MARGIN + 5.9, y - 0.13)
        y -= BAR + LINE / 2.0
        y = _lines(page, text, y)
        for k, (sign, words) in enumerate(_signs(profiles, signs).items()):
            row, column = divmod(k, columns)
            _sign(page, sign, MARGIN + column * COLUMN, y - row * LINE)
            page.text(MARGIN + column * COLUMN + 0.28, y - row * LINE, words, fontsize=7.5, va="center")
        _lines(page, note, y - (row + 1) * LINE, fontstyle="italic", color=WARNING)
    return drawing


def _windows(profiles: Sequence[ShockProfile], views: Sequence[View]) -> tuple[list[Window], list[float], float]:
    """The windows of all panels at one scale, their widths, and the height that they share [inches]."""
    feet = [np.mean([to_plane(contact.point, p.plane) for contact in p.contacts], axis=0) for p in profiles]
    near = [_near(profile, view) for profile, view in zip(profiles, views, strict=True)]
    held = [
        np.array([view.low, view.high, foot, *centres]) - foot for view, foot, (centres, _) in zip(views, feet, near, strict=True)
    ]
    sides = [PAD + (POINTER if pointers else 0.0) for _, pointers in near]
    inch = 1e-9
    # An arrow has a fixed length on the page, so its length in the plane depends on the scale, which depends on the arrow.
    for _ in range(4):
        full = [np.concatenate([one, [ARROW * inch * strike_in_plane(p)]]) for one, p in zip(held, profiles, strict=True)]
        low, high = min(one[:, 1].min() for one in full), max(one[:, 1].max() for one in full)
        wide = sum(float(np.ptp(one[:, 0])) for one in full) / (WIDEST - 2.0 * sum(sides))
        inch = max(wide, float(high - low) / (TALLEST - 2.0 * PAD))
    widths = [max(float(np.ptp(one[:, 0])) / inch + 2.0 * side, NARROWEST) for one, side in zip(full, sides, strict=True)]
    windows = []
    for one, foot, width in zip(full, feet, widths, strict=True):
        left = (one[:, 0].min() + one[:, 0].max() - width * inch) / 2.0
        corners = np.array([[left, low - PAD * inch], [left + width * inch, high + PAD * inch]])
        windows.append(Window(foot + corners[0], foot + corners[1], inch))
    return windows, widths, float(high - low) / inch + 2.0 * PAD


def _near(profile: ShockProfile, view: View) -> tuple[Array, bool]:
    """The centres of percussion (n, 2) near the robot, which its panel includes [m], and whether there are others."""
    centres = to_plane(profile.copc_world, profile.plane)[~profile.translates]
    near = np.all((centres > view.low - NEAR * view.size) & (centres < view.high + NEAR * view.size), axis=1)
    return centres[near], not near.all()


def _signs(profiles: Sequence[ShockProfile], signs: set[str]) -> dict[str, str]:
    """The signs in the key with their meaning."""
    sensors = dict.fromkeys(point.frame for profile in profiles for point in profile.points)
    words = {
        "strike": "strike: velocity of the contact",
        "centre": "CoPc of the body with that number",
        "pointer": "distance of a CoPc beyond the border",
        "radius": "RoPc: shock is 1 on this circle",
        "sensor": ", ".join(f"{letter(k)} {name}" for k, name in enumerate(sensors)),
    }
    return {sign: text for sign, text in words.items() if sign in signs | {"strike", "centre"} or (sign == "sensor" and sensors)}


def _sign(page: Axes, sign: str, x: float, y: float) -> None:
    """One sign of the key."""

    def arrow(head: float, width: float) -> None:
        shape = FancyArrowPatch((x, y), (x + 0.2, y), arrowstyle="-|>", mutation_scale=head, shrinkA=0, shrinkB=0)
        shape.set(linewidth=width, color=INK)
        page.add_patch(shape)

    diamond: dict[str, Any] = {"markersize": 4.2, "markerfacecolor": SENSOR, "markeredgecolor": INK, "markeredgewidth": 0.7}
    draw: dict[str, Callable[[], object]] = {
        "strike": lambda: arrow(11.0, 1.9),
        "centre": lambda: percussion_mark(page, x + 0.1, y),
        "pointer": lambda: arrow(9.0, 1.0),
        "radius": lambda: page.plot([x, x + 0.2], [y, y], color=INK, linewidth=0.6, linestyle=DASHED),
        "sensor": lambda: page.plot(x + 0.1, y, "D", **diamond),
    }
    draw[sign]()


def _lines(page: Axes, lines: list[str], y: float, **style: Any) -> float:
    """Write lines of text downwards from y; returns the y of the next line."""
    for k, line in enumerate(lines):
        page.text(MARGIN, y - k * LINE, line, fontsize=7.5, va="center", **style)
    return y - len(lines) * LINE
