"""The figure of a landing: the robot in the plane, each body coloured by the shock at each of its points.

The only door to matplotlib and shapely; nothing imports it until a figure is asked for. It draws with matplotlib's objects and
leaves its global state alone.
"""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.marks import draw_marks
from shockpc.show.figure.page import colour_bar, scale_bar, title
from shockpc.show.figure.palette import PAPER
from shockpc.show.figure.panel import PANEL, panel, panel_height
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.style import STYLE, blank, save_drawing
from shockpc.show.figure.view import View, view_of
from shockpc.show.figure.window import ARROW, Window, strikes_in_plane

__all__ = ["draw", "save_figure"]

WIDEST, TALLEST, NARROWEST = 5.4, 6.6, 3.6
"""Sides of the picture [inches]."""

MARGIN, HEAD, FOOT, GAP, PAD = 0.2, 0.86, 0.88, 0.3, 0.32
"""Room around everything, for the title, for the colour bar, beside the picture, and around what it holds [inches]."""

FEW = 6
"""Most bodies of a robot that are all numbered."""

NEAR = 0.15
"""How far beyond the robot, as a share of its size, a centre of percussion may lie and still be in the picture."""


def draw(profile: ShockProfile) -> Figure:
    """Draw the robot in its plane; e1 points right, e2 up, nearer limbs cover farther ones.

    Colours are those of the three-dimensional field |Δv + Δω × r| / v_in. For a body that moves in the plane it does not depend on
    depth; for others it is taken on the plane through the middle of the body, along the limb. CoPc and RoPc are those of the
    motion in the plane, through the origin of the body's frame.

    Args:
        profile: the shock of a landing.
    """
    with matplotlib.rc_context(STYLE):
        view = view_of(profile)
        numbers = {i: n for n, i in enumerate(_numbered(profile, view), start=1)}
        tall = panel_height(profile, numbers)
        window, width, height = _window(profile, _contents(profile, view), tall - FOOT)
        page_width = MARGIN + width + GAP + PANEL + MARGIN
        page_height = HEAD + max(height + FOOT, tall) + MARGIN / 2.0
        figure = Figure(figsize=(page_width, page_height), facecolor=PAPER)
        page = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        blank(page, (0.0, page_width), (0.0, page_height))
        top = page_height - HEAD
        picture = figure.add_axes((MARGIN / page_width, (top - height) / page_height, width / page_width, height / page_height))
        blank(picture, (window.low[0], window.high[0]), (window.low[1], window.high[1]))
        draw_bodies(picture, view)
        signs = draw_marks(picture, profile, view, window, numbers)
        title(page, profile, MARGIN, page_height - 0.14, page_width - 2.0 * MARGIN)
        colour_bar(page, MARGIN + 0.05, top - height - 0.14, width - 0.1)
        scale_bar(page, window, MARGIN + width - 0.05, top - height - 0.75)
        panel(page, profile, view, numbers, signs, MARGIN + width + GAP, top)
    return figure


def save_figure(profile: ShockProfile, folder: Path) -> tuple[Path, Path]:
    """Write shock.svg and shock.png, the same bytes every time; a file is there whole or not at all.

    Args:
        profile: the shock of a landing.
        folder: exists already.

    Returns: the paths of both.

    Raises:
        OutputError: the folder cannot be written.
    """
    return save_drawing(lambda: draw(profile), folder, "shock")


def _numbered(profile: ShockProfile, view: View) -> list[int]:
    """Bodies that carry a number: all of a small robot; else those between contacts and base, and the heaviest."""
    bodies = profile.robot.bodies
    if len(bodies) <= FEW:
        return list(range(len(bodies)))
    return sorted({*view.struck, max(range(len(bodies)), key=lambda i: bodies[i].mass)})


def _contents(profile: ShockProfile, view: View) -> Array:
    """Points (n, 2) that the picture should hold: the robot, contacts, sensors, and centres of percussion close by [m]."""
    places = [view.low, view.high, *(to_plane(contact.point, profile.plane) for contact in profile.contacts)]
    places += [to_plane(point.position, profile.plane) for point in profile.points]
    centres = to_plane(profile.copc_world, profile.plane)
    near = NEAR * view.size
    for i in view.struck:
        if np.all(centres[i] > view.low - near) and np.all(centres[i] < view.high + near):
            places.append(centres[i])
    return np.array(places)


def _window(profile: ShockProfile, contents: Array, least: float) -> tuple[Window, float, float]:
    """The window around the contents and the strike arrows, and the picture's width and height on paper [inches]."""
    feet = np.stack([to_plane(contact.point, profile.plane) for contact in profile.contacts])
    held, inch = contents, 0.0
    # The arrows' length is one of paper, so what they need of the plane follows from the scale, and the scale from that.
    for _ in range(3):
        low, high = held.min(axis=0), held.max(axis=0)
        size = np.maximum(high - low, 1e-6)
        inch = float(max(size[0] / (WIDEST - 2.0 * PAD), size[1] / (TALLEST - 2.0 * PAD)))
        held = np.concatenate([contents, feet + ARROW * inch * strikes_in_plane(profile)])
    low, high = held.min(axis=0), held.max(axis=0)
    paper = np.maximum((high - low) / inch + 2.0 * PAD, (NARROWEST, least))
    middle = (low + high) / 2.0
    return Window(middle - paper * inch / 2.0, middle + paper * inch / 2.0, inch), float(paper[0]), float(paper[1])
