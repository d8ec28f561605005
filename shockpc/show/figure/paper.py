"""A figure of the paper, computed again: its panels side by side, on one scale and with one set of colours."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.paper.scenes import Panel, PaperFigure
from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.marks import draw_marks
from shockpc.show.figure.page import colour_bar, joint_model, scale_bar
from shockpc.show.figure.palette import PAPER
from shockpc.show.figure.paper_key import draw_key, key_height
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.style import STYLE, blank
from shockpc.show.figure.view import View, view_of
from shockpc.show.figure.window import ARROW, Window, strike_in_plane
from shockpc.show.strike import strike_angle

__all__ = ["draw_paper_figure"]

WIDEST, TALLEST = 9.6, 3.6
"""Sides of all panels together [inches]."""

MARGIN, HEAD, CAPTION, PAD = 0.2, 0.5, 0.5, 0.2
"""Room around everything, for the title, under each panel for its words, and around what a panel holds [inches]."""

FOOT = 0.62
"""Room for the colour bar [inches]."""

LEAST, BAR = 1.6, 4.6
"""Least width of a panel, and width of the colour bar [inches]."""

POINTER = 0.5
"""Room for pointers beside a robot, beyond the pad [inches]."""

WHOLE = 0.98
"""Share of a RoPc's circle that has to be in its panel for it to be drawn: arcs that run into the next panel mislead."""

NEAR = np.array([0.7, 0.26])
"""How far beyond the robot, sideways and up, as a share of its size, a centre of percussion may lie and still be in the panel."""


def draw_paper_figure(figure: PaperFigure, profiles: Sequence[ShockProfile]) -> Figure:
    """Draw a figure of the paper.

    The contacts of all panels stand at one height. Bodies carry the same number in every panel; a centre of percussion carries
    the number of its body.

    Args:
        figure: what it is.
        profiles: of its panels.
    """
    with matplotlib.rc_context(STYLE):
        views = [view_of(profile) for profile in profiles]
        names = list(dict.fromkeys(body for profile in profiles for body in profile.bodies))
        windows, widths, height = _windows(profiles, views)
        page_width = 2.0 * MARGIN + max(sum(widths), BAR + 1.6)
        foot = FOOT + key_height(figure, profiles, names, page_width - 2.0 * MARGIN)
        page_height = HEAD + height + CAPTION + foot + MARGIN / 2.0
        drawing = Figure(figsize=(page_width, page_height), facecolor=PAPER)
        page = drawing.add_axes((0.0, 0.0, 1.0, 1.0))
        blank(page, (0.0, page_width), (0.0, page_height))
        page.text(MARGIN, page_height - 0.12, f"Figure {figure.number}: {figure.title}", fontsize=11, fontweight="bold", va="top")
        models = " or ".join(dict.fromkeys(joint_model(profile) for profile in profiles))
        page.text(MARGIN, page_height - 0.33, f"joint model: {models}", fontsize=7.5, va="top")
        x, bottom = MARGIN + (page_width - 2.0 * MARGIN - sum(widths)) / 2.0, foot + CAPTION + MARGIN / 2.0
        signs: set[str] = set()
        for part, profile, view, window, width in zip(figure.panels, profiles, views, windows, widths, strict=True):
            place = (x / page_width, bottom / page_height, width / page_width, height / page_height)
            picture = drawing.add_axes(place)
            blank(picture, (window.low[0], window.high[0]), (window.low[1], window.high[1]))
            draw_bodies(picture, view)
            numbers = {i: names.index(body) + 1 for i, body in enumerate(profile.bodies)}
            signs |= draw_marks(picture, profile, view, window, numbers, WHOLE, tied=True)
            _caption(page, part, profile, x + width / 2.0, bottom - 0.04)
            x += width
        colour_bar(page, MARGIN, foot - 0.05, BAR)
        scale_bar(page, windows[0], MARGIN + BAR + 1.3, foot - 0.13)
        draw_key(page, figure, profiles, names, signs, (MARGIN, foot - FOOT, page_width - 2.0 * MARGIN))
    return drawing


def _windows(profiles: Sequence[ShockProfile], views: Sequence[View]) -> tuple[list[Window], list[float], float]:
    """The windows of all panels on one scale, their widths, and the height that they share [inches]."""
    held = [_contents(profile, view) for profile, view in zip(profiles, views, strict=True)]
    sides = [_beyond(profile, view) for profile, view in zip(profiles, views, strict=True)]
    feet = [np.mean([to_plane(contact.point, p.plane) for contact in p.contacts], axis=0) for p in profiles]
    places = [points - foot for points, foot in zip(held, feet, strict=True)]
    inch = 1e-9
    # The arrows' length is one of paper, so what they need of the plane follows from the scale, and the scale from that.
    for _ in range(4):
        full = [
            np.concatenate([one, [ARROW * inch * strike_in_plane(p)], _with_room(view, foot, side, inch)])
            for one, p, view, foot, side in zip(places, profiles, views, feet, sides, strict=True)
        ]
        wide = sum(float(np.ptp(one[:, 0])) for one in full) / (WIDEST - 2.0 * PAD * len(full))
        low, high = min(one[:, 1].min() for one in full), max(one[:, 1].max() for one in full)
        inch = max(wide, float(high - low) / (TALLEST - 2.0 * PAD))
    windows, widths = [], []
    for one, foot in zip(full, feet, strict=True):
        left, right = one[:, 0].min(), one[:, 0].max()
        width = max(float(right - left) / inch + 2.0 * PAD, LEAST)
        middle = (left + right) / 2.0
        lower, upper = (middle - width * inch / 2.0, low - PAD * inch), (middle + width * inch / 2.0, high + PAD * inch)
        windows.append(Window(foot + np.array(lower), foot + np.array(upper), inch))
        widths.append(width)
    return windows, widths, float(high - low) / inch + 2.0 * PAD


def _contents(profile: ShockProfile, view: View) -> np.ndarray:
    """Points (n, 2) that a panel should hold [m]."""
    places = [view.low, view.high, *(to_plane(contact.point, profile.plane) for contact in profile.contacts)]
    near = NEAR * view.size
    for centre in to_plane(profile.copc_world, profile.plane)[~profile.translates]:
        if np.all(centre > view.low - near) and np.all(centre < view.high + near):
            places.append(centre)
    return np.array(places)


def _beyond(profile: ShockProfile, view: View) -> set[int]:
    """The sides of a panel at which pointers will stand, −1 left and 1 right; only a steep one stands above or below."""
    near = NEAR * view.size
    sides = set()
    for i in np.flatnonzero(~profile.translates):
        centre = to_plane(profile.copc_world[i], profile.plane)
        if np.any(centre < view.low - near) or np.any(centre > view.high + near):
            dx, dy = centre - to_plane(profile.position[i], profile.plane)
            sides |= {int(np.sign(dx))} if 2.0 * abs(dx) > abs(dy) else set()
    return sides


def _with_room(view: View, foot: np.ndarray, sides: set[int], inch: float) -> np.ndarray:
    """Points (n, 2) beside the robot that keep room for pointers, from the contacts [m]."""
    edge = {-1: view.low[0], 1: view.high[0]}
    return np.array([[edge[side] + side * POINTER * inch, view.low[1]] - foot for side in sides]).reshape(-1, 2)


def _caption(page: Axes, part: Panel, profile: ShockProfile, x: float, y: float) -> None:
    """Letter or angle of a panel, what it shows, and how it is struck."""
    page.text(x, y, part.label, fontsize=10, fontweight="bold", ha="center", va="top")
    page.text(x, y - 0.18, part.words, fontsize=7.5, ha="center", va="top")
    page.text(x, y - 0.32, f"θ = {strike_angle(profile)}°".replace("-", "−"), fontsize=7.5, ha="center", va="top")
