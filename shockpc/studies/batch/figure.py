"""A contact sheet: small pictures of the worst landing of each robot, in a common colour scale."""

import itertools
import math
from pathlib import Path

from matplotlib.figure import Figure

from shockpc.quantities.selection import select
from shockpc.show.figure.layout import MARGIN, Page
from shockpc.show.figure.picture import draw_bodies, draw_velocities
from shockpc.show.figure.window import windows_of
from shockpc.show.tables import rounded
from shockpc.studies.batch.rows import Batch, BatchRow
from shockpc.studies.batch.tables import short_landing_name
from shockpc.text.printed import printable

COLUMNS = 8
"""Most pictures in a line."""

WIDTH, HEIGHT, CAPTION, GAP, FOOT, BAR = 1.45, 1.15, 0.42, 0.12, 0.42, 4.6
"""Sizes of the contact sheet [inches].

They are the sides of a picture, the height of what is written under it, the distance to the next,
the room for the colour bar, and its width.
"""


LEAST_WIDTH, SCALE = 6.0, 0.5
"""Least width of the pictures together [inches], and the scale of lines and marks in them.

The width is room for the lines above the pictures.
"""


def draw_contact_sheet(batch: Batch) -> Figure:
    """Draw the worst landing of each robot, or of each scene, in the order of the table.

    Each robot fills its picture.
    """
    rows = [row for row in batch.robots if row.picture is not None]
    across = max(min(COLUMNS, len(rows)), 1)
    lines = math.ceil(len(rows) / across)
    # From one picture to the next, to the right and down.
    step, drop = WIDTH + GAP, HEIGHT + CAPTION + GAP
    width = max(across * step - GAP, LEAST_WIDTH)
    page = Page(MARGIN + width, lines * drop + FOOT, _heading(batch, rows))
    for k, row in enumerate(rows):
        line, column = divmod(k, across)
        x = MARGIN + column * step
        lines_below = lines - 1 - line
        y = page.low + FOOT + lines_below * drop + CAPTION + GAP
        (window,) = windows_of(
            [row.picture], (0.0, 0.0), (WIDTH, HEIGHT), (WIDTH, HEIGHT), pad=0.05, arrow=0.22
        )
        axes = page.picture(x, y, window)
        draw_bodies(axes, row.picture, 400.0, SCALE)
        draw_velocities(axes, row.picture, window, SCALE)
        page.caption(x, y, _caption(batch, row, k + 1), WIDTH)
    page.bar(MARGIN, BAR)
    return page.figure


def _heading(batch: Batch, rows: list[BatchRow]) -> list[str]:
    """The lines above the pictures."""
    title = select(batch.rank.partition("@")[0]).quantity.title
    heading = [
        f"Worst landing of each robot, by the {printable(title, 60)}",
        "arrow: velocity of the contact before the impact; each robot is scaled to fit",
    ]
    if not all(row.drives_known for row in rows):
        heading.append("–: unknown drives, so the number may lie anywhere in the range")
    drawn = itertools.chain.from_iterable(row.picture.drawn for row in rows)
    if any(body.box for body in drawn):
        heading.append("dash-dotted: box of an inertia, of a body without a shape")
    return heading


def _caption(batch: Batch, row: BatchRow, rank: int) -> list[str]:
    """Rank and name of a robot, its landing, and the number by which it is ranked."""
    text = f"{rank} " if row.drives_known else "– "
    landing = short_landing_name(row)
    if row.of_scene:
        landing += f", {Path(row.source).name}"
    number = f"{batch.rank} {rounded(row.values[batch.rank])}"
    if row.range is not None:
        ends = f"{rounded(row.range.smallest)} … {rounded(row.range.largest)}"
        number = f"{rounded(row.values[batch.rank])} ({ends})"
    name = printable(batch.name_of(row), 40)
    return [f"{text} {name}", f"on {printable(landing, 40)}", printable(number, 40)]
