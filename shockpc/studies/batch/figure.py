"""A contact sheet: the worst landing of each robot as a small picture on one page, in one colour scale."""

import math
from pathlib import Path

from matplotlib.figure import Figure

from shockpc.quantities.selection import select
from shockpc.show.figure.layout import MARGIN, Page
from shockpc.show.figure.picture import draw_bodies, draw_velocities
from shockpc.show.figure.view import windows_of
from shockpc.show.tables import rounded
from shockpc.studies.batch.study import Batch
from shockpc.text.printed import printable

COLUMNS = 8
"""Most pictures in a line."""

WIDTH, HEIGHT, CAPTION, GAP, FOOT, BAR = 1.45, 1.15, 0.42, 0.12, 0.42, 4.6
"""Sides of a picture, height of what is written under it, distance to the next, room for the colour bar, and its width [inches]."""


LEAST_WIDTH, SCALE = 6.0, 0.5
"""Of the pictures together: room for the lines above them [inches]; of lines and marks in such small pictures."""


def draw_contact_sheet(batch: Batch) -> Figure:
    """Draw the worst landing of each robot, or of each scene, in the order of the table; each robot fills its picture."""
    worst = {row.source: row for row in reversed(batch.rows) if row.picture is not None}
    rows = [row for row in batch.rows if worst.get(row.source) is row]
    across = max(min(COLUMNS, len(rows)), 1)
    lines, step, drop = math.ceil(len(rows) / across), WIDTH + GAP, HEIGHT + CAPTION + GAP
    heading = (
        f"Worst landing of each robot, by the {printable(select(batch.rank).quantity.title, 60)}",
        "arrow: velocity of the contact before the impact; numbers are of the trunk; each robot is scaled to fit",
        *["*: what drives the joints is known"] * any(row.drives_known for row in rows),
        *["dash-dotted: box of an inertia, of a body without a shape"] * any(one.box for row in rows for one in row.picture.drawn),
    )
    page = Page(MARGIN + max(across * step - GAP, LEAST_WIDTH), lines * drop + FOOT, heading)
    short = batch.short_names
    for k, row in enumerate(rows):
        x, y = MARGIN + (k % across) * step, page.low + FOOT + (lines - 1 - k // across) * drop + CAPTION + GAP
        (window,) = windows_of([row.picture], (0.0, 0.0), (WIDTH, HEIGHT), (WIDTH, HEIGHT), pad=0.05, arrow=0.22)
        axes = page.picture(x, y, window)
        draw_bodies(axes, row.picture, 400.0, SCALE)
        draw_velocities(axes, row.picture, window, SCALE)
        greatest, ranked = row.values["shock_max"], row.values[batch.rank]
        if batch.rank != "shock_max":
            number = f"{batch.rank} {rounded(ranked)}"
        else:
            shock = f"{row.values['shock_com']:.2g} at CoM" if greatest is None else f"up to {greatest:.2g}"
            ropc = row.values["ropc"]
            number = shock if ropc is None else f"{shock}; RoPc {ropc:.3g} m"
        name = f"{k + 1}  {printable(short.get(row.robot, row.robot), 40)}{' *' * row.drives_known}"
        scene = f", {Path(row.source).name}" * row.source.endswith(".toml")
        page.caption(x, y, [name, f"on {printable(row.contact + scene, 40)}", printable(number, 40)], WIDTH)
    page.bar(MARGIN, BAR)
    return page.figure
