"""A contact sheet: many landings as small pictures on one page, in one colour scale."""

import math

import numpy as np
import shapely
from matplotlib.figure import Figure

from shockpc.printed import printable
from shockpc.result import ShockProfile
from shockpc.show.figure.page import MARGIN, Page
from shockpc.show.figure.picture import arrow, draw_bodies
from shockpc.show.figure.style import INK, PAPER
from shockpc.show.figure.view import View, view_of, windows_of
from shockpc.studies.batch import Batch, BatchRow

__all__ = ["draw_contact_sheet", "thumbnail"]

COLUMNS = 8
"""Most pictures in a line."""

WIDTH, HEIGHT, CAPTION, GAP, FOOT, BAR = 1.45, 1.15, 0.42, 0.12, 0.42, 4.6
"""Sides of a picture, height of what is written under it, distance to the next, room for the colour bar, and its width [inches]."""

FINE = 400.0
"""Part of a robot's size that is the smallest detail."""


def thumbnail(profile: ShockProfile) -> View:
    """The small picture of a landing."""
    view = view_of(profile)
    drawn = tuple(one._replace(region=shapely.simplify(one.region, view.size / FINE)) for one in view.drawn)
    return view._replace(drawn=drawn)


def draw_contact_sheet(batch: Batch) -> Figure:
    """Draw all landings in the order of the table, which is that of their numbers; each robot fills its picture."""
    rows = [row for row in batch.rows if row.picture is not None]
    across = max(min(COLUMNS, len(rows)), 1)
    lines, step, drop = math.ceil(len(rows) / across), WIDTH + GAP, HEIGHT + CAPTION + GAP
    heading = (
        f"{len(rows)} landings, ranked by the greatest shock over the trunk",
        "arrow: velocity of the contact before the impact; numbers are of the trunk; each robot on its own scale",
    )
    page = Page(MARGIN + max(across * step - GAP, BAR), lines * drop + FOOT, heading)
    for k, row in enumerate(rows):
        x, y = MARGIN + (k % across) * step, page.low + FOOT + (lines - 1 - k // across) * drop + CAPTION + GAP
        _picture(page, row.picture, x, y)
        page.line(x, y - 0.04, f"{k + 1}  {printable(row.robot, 40)}", 7.5, WIDTH, "bold")
        page.line(x, y - 0.16, f"on {printable(row.contact, 40)}", 7.0, WIDTH)
        page.line(x, y - 0.28, _words(row), 7.0, WIDTH)
    page.bar(MARGIN, BAR)
    return page.figure


def _words(row: BatchRow) -> str:
    """Shock and radius of percussion of the trunk."""
    shock = f"{row.shock_com:.2g} at CoM" if row.shock_max is None else f"up to {row.shock_max:.2g}"
    return f"{shock}; RoPc {row.ropc:.3g} m"


def _picture(page: Page, view: View, x: float, y: float) -> None:
    """One robot in a rectangle of `WIDTH` and `HEIGHT` whose lower left corner is (x, y) [inches]."""
    (window,) = windows_of([view], [()], (0.0, 0.0), (WIDTH, HEIGHT), (WIDTH, HEIGHT), pad=0.05)
    axes = page.picture(x, y, window)
    draw_bodies(axes, view)
    for place, velocity in zip(view.contacts, view.velocities, strict=True):
        axes.plot(*place, "o", markersize=2.6, markerfacecolor=INK, markeredgecolor=PAPER, markeredgewidth=0.3, zorder=7)
        if float(np.linalg.norm(velocity)) > 0.05:
            arrow(axes, place, place + window.arrow * velocity, 1.0, 5.0)
