"""A contact sheet: the worst landing of each robot as a small picture on one page, in one colour
scale.
"""

import math
from pathlib import Path

from matplotlib.figure import Figure

from shockpc.quantities.selection import select
from shockpc.show.figure.layout import MARGIN, Page
from shockpc.show.figure.picture import draw_bodies, draw_velocities
from shockpc.show.figure.view import windows_of
from shockpc.show.tables import rounded
from shockpc.show.wording import landing_names
from shockpc.studies.batch.study import Batch
from shockpc.text.printed import printable

COLUMNS = 8
"""Most pictures in a line."""

WIDTH, HEIGHT, CAPTION, GAP, FOOT, BAR = 1.45, 1.15, 0.42, 0.12, 0.42, 4.6
"""Sides of a picture, height of what is written under it, distance to the next, room for the colour
bar, and its width [inches].
"""


LEAST_WIDTH, SCALE = 6.0, 0.5
"""Of the pictures together: room for the lines above them [inches]; of lines and marks in such
small pictures.
"""


def draw_contact_sheet(batch: Batch) -> Figure:
    """Draw the worst landing of each robot, or of each scene, in the order of the table; each robot
    fills its picture.
    """
    rows = [row for row in batch.robots if row.picture is not None]
    across = max(min(COLUMNS, len(rows)), 1)
    lines, step, drop = math.ceil(len(rows) / across), WIDTH + GAP, HEIGHT + CAPTION + GAP
    heading = (
        f"Worst landing of each robot, by the {printable(select(batch.rank).quantity.title, 60)}",
        "arrow: velocity of the contact before the impact; each robot is scaled to fit",
        *["–: nobody knows the drives, so the number may lie anywhere in the range"]
        * any(not row.drives_known for row in rows),
        *["dash-dotted: box of an inertia, of a body without a shape"]
        * any(one.box for row in rows for one in row.picture.drawn),
    )
    page = Page(MARGIN + max(across * step - GAP, LEAST_WIDTH), lines * drop + FOOT, heading)
    short = batch.short_names
    for k, row in enumerate(rows):
        x, y = (
            MARGIN + (k % across) * step,
            page.low + FOOT + (lines - 1 - k // across) * drop + CAPTION + GAP,
        )
        (window,) = windows_of(
            [row.picture], (0.0, 0.0), (WIDTH, HEIGHT), (WIDTH, HEIGHT), pad=0.05, arrow=0.22
        )
        axes = page.picture(x, y, window)
        draw_bodies(axes, row.picture, 400.0, SCALE)
        draw_velocities(axes, row.picture, window, SCALE)
        value, found = row.values[batch.rank], row.range
        number = f"{batch.rank} {rounded(value)}"
        if found is not None:
            number = f"{rounded(value)} ({rounded(found.smallest)} … {rounded(found.largest)})"
        (landing,) = landing_names([row.contact.split("+")], row.feet)
        rank = f"{k + 1} " if row.drives_known else "– "
        name = f"{rank} {printable(short.get(row.robot, row.robot), 40)}"
        scene = f", {Path(row.source).name}" * row.source.endswith(".toml")
        page.caption(
            x, y, [name, f"on {printable(landing + scene, 40)}", printable(number, 40)], WIDTH
        )
    page.bar(MARGIN, BAR)
    return page.figure
