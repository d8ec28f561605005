"""A contact sheet: many landings as small pictures on one page, in one colour scale."""

import math
from typing import NamedTuple

import numpy as np
import shapely
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.printed import printable
from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.canvas import add_axes, new_page
from shockpc.show.figure.marks import arrow
from shockpc.show.figure.page import line, shock_bar
from shockpc.show.figure.palette import INK, PAPER
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.view import View, view_of
from shockpc.show.figure.window import fitted, velocities_in_plane
from shockpc.studies.batch import Batch, BatchRow

__all__ = ["Thumbnail", "draw_contact_sheet", "thumbnail"]

COLUMNS = 8
"""Most pictures in a line."""

WIDTH, HEIGHT, CAPTION, GAP = 1.45, 1.15, 0.42, 0.12
"""Sides of a picture, height of what is written under it, and the distance to the next [inches]."""

MARGIN, HEAD, FOOT, BAR = 0.2, 0.55, 0.62, 4.6
"""Room at the edges, for the title and for the colour bar; and the width of that [inches]."""

ARROW = 0.22
"""Length of the arrow of the fastest contact [inches]."""

FINE = 400.0
"""Part of a robot's size that is the smallest detail."""


class Thumbnail(NamedTuple):
    """A landing as a small picture.

    Attributes:
        view: the bodies.
        contacts: (n, 2) contact points in plane coordinates [m].
        velocities: (n, 2) of these points before the impact, relative to the fastest [1].
    """

    view: View
    contacts: Array
    velocities: Array


def thumbnail(profile: ShockProfile) -> Thumbnail:
    """The small picture of a landing."""
    view = view_of(profile)
    drawn = tuple(one._replace(region=shapely.simplify(one.region, view.size / FINE)) for one in view.drawn)
    contacts = to_plane(np.stack([contact.point for contact in profile.contacts]), profile.plane)
    return Thumbnail(view._replace(drawn=drawn), contacts, velocities_in_plane(profile))


def draw_contact_sheet(batch: Batch) -> Figure:
    """Draw all landings in the order of the table, which is that of their numbers; each robot fills its picture."""
    rows = [row for row in batch.rows if row.picture is not None]
    across = max(min(COLUMNS, len(rows)), 1)
    lines = math.ceil(len(rows) / across)
    step, drop = WIDTH + GAP, HEIGHT + CAPTION + GAP
    width = max(2.0 * MARGIN + across * step - GAP, 2.0 * MARGIN + BAR)
    height = HEAD + lines * drop + FOOT
    figure, page = new_page(width, height)
    room = width - 2.0 * MARGIN
    line(page, MARGIN, height - 0.12, f"{len(rows)} landings, ranked by the greatest shock over the trunk", 11.0, room, "bold")
    line(
        page,
        MARGIN,
        height - 0.34,
        "arrow: velocity of the contact before the impact; numbers are of the trunk; each robot on its own scale",
        7.5,
        room,
    )
    for k, row in enumerate(rows):
        x, y = MARGIN + (k % across) * step, height - HEAD - (k // across) * drop - HEIGHT
        _picture(figure, row.picture, x, y)
        line(page, x, y - 0.04, f"{k + 1}  {printable(row.robot, 40)}", 7.5, WIDTH, "bold")
        line(page, x, y - 0.16, f"on {printable(row.contact, 40)}", 7.0, WIDTH)
        line(page, x, y - 0.28, _words(row), 7.0, WIDTH)
    shock_bar(figure, MARGIN, 0.5, BAR)
    return figure


def _words(row: BatchRow) -> str:
    """Shock and radius of percussion of the trunk."""
    shock = f"{row.shock_com:.2g} at CoM" if row.shock_max is None else f"up to {row.shock_max:.2g}"
    return f"{shock}; RoPc {row.ropc:.3g} m"


def _picture(figure: Figure, picture: Thumbnail, x: float, y: float) -> None:
    """One robot in a rectangle of `WIDTH` and `HEIGHT` whose lower left corner is (x, y) [inches]."""
    view, arrows = picture.view, ARROW * picture.velocities
    held = np.concatenate([[view.low, view.high], picture.contacts])
    (window,) = fitted([held], [picture.contacts], [arrows], 0.05, (WIDTH, HEIGHT), (WIDTH, HEIGHT))
    axes = add_axes(figure, x, y, WIDTH, HEIGHT)
    axes.set(xlim=(window.low[0], window.high[0]), ylim=(window.low[1], window.high[1]))
    axes.set_axis_off()
    draw_bodies(axes, view)
    for place, shift in zip(picture.contacts, arrows, strict=True):
        axes.plot(*place, "o", markersize=2.6, markerfacecolor=INK, markeredgecolor=PAPER, markeredgewidth=0.3, zorder=7)
        if float(np.linalg.norm(shift)) > 0.05 * ARROW:
            axes.add_patch(arrow(place, place + window.inch * shift, 1.0, 5.0))
