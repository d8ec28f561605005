"""A page with places in inches: a heading, and pictures over a bar of colours.

Beside them are tables, notes and a key.
"""

import math
import re
import textwrap
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from shockpc.show.figure.style import BANDS, EDGES, INK, SHOCK
from shockpc.show.figure.window import Window
from shockpc.text.printed import printable

TableRows = list[tuple[str, ...]]
"""A table of texts, its header first: a sign, a name, and numbers."""

LETTERS = 14.0
"""In an inch of a heading."""

LINE = 0.165
"""Height of a line of text [inches]."""

ROWS = 18
"""Most rows of a table."""

NOTE, UNDER = 0.85 * LINE, 0.3
"""Height of a line of a note, and between pictures and the notes under them [inches]."""

MARGIN, LEFT, COLUMN = 0.2, 0.62, 3.6
"""Room around everything, for the vertical coordinate of a picture, and for the column [inches]."""


class Page:
    """A page.

    Attributes:
        figure: that of matplotlib.
        low: lower edge of the room for pictures [inches].
    """

    def __init__(
        self,
        width: float,
        height: float,
        heading: Sequence[str],
        tables: Sequence[TableRows] = (),
        notes: Sequence[str] = (),
        column: float | None = None,
    ):
        """Write everything but the pictures.

        Args:
            width: right edge of the pictures [inches].
            height: of the pictures with what is under them [inches].
            heading: lines, the first one as title; the others are wrapped.
            tables: of the column; without any, there is no column.
            notes: in italics, under the tables, or under the pictures where that makes the page
                less high.
            column: left edge of the column [inches]; by default right of the pictures.
        """
        self._x = width + 2.0 * MARGIN if column is None else column
        across = width + MARGIN
        if tables:
            across = max(across, self._x + COLUMN + MARGIN)
        # Notes are under the tables, or under the pictures where the page then is less high.
        below = _wrapped(notes, width - LEFT)
        with_notes_below = height + UNDER + NOTE * len(below)
        if_below = max(with_notes_below, column_height(tables, ()))
        if_beside = max(height, column_height(tables, notes))
        under = bool(notes) and if_below < if_beside
        top = MARGIN + (if_below if under else if_beside)
        # The heading is as wide as the page, so its height follows last.
        lines = []
        for line in heading[1:]:
            lines += textwrap.wrap(line, int(LETTERS * (across - 2.0 * MARGIN)))
        self.low = top - height
        up = top + 0.5 + 0.18 * len(lines)
        self.figure = Figure(figsize=(across, up))
        # One axes in inches over the whole page, for texts anywhere on it.
        self._axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, across), ylim=(0.0, up))
        self._axes.set_axis_off()
        room = across - 2.0 * MARGIN
        self.write(MARGIN, up - 0.14, heading[0], 11.0, room, fontweight="bold")
        for k, text in enumerate(lines, start=1):
            self.write(MARGIN, up - 0.14 - 0.07 - 0.18 * k, text, 8.0, room, fontweight="normal")
        # `_y` goes down the column as tables and notes are written.
        self._y = top
        for rows in tables:
            self._table(_cut_rows(rows))
            self._y -= LINE
        if under:
            self._write_notes(LEFT, self.low - UNDER, below)
        elif notes:
            self._y = self._write_notes(self._x, self._y, _wrapped(notes, COLUMN)) - LINE

    def _write_notes(self, x: float, y: float, lines: Sequence[str]) -> float:
        """Write lines down from (x, y) [inches]; returns the place of the next."""
        for line in lines:
            self.write(x, y, line, 7.0, fontstyle="italic")
            y -= NOTE
        return y

    def _table(self, rows: TableRows) -> None:
        """Write rows into the column; numbers are under each other at their right edge."""
        stops = [0.0, 0.2]
        for k in reversed(range(len(rows[0]) - 2)):
            stops.append(COLUMN - 0.62 * k)
        for k, row in enumerate(rows):
            for column, (stop, cell) in enumerate(zip(stops, row, strict=False)):
                weight = "bold" if k == 0 or column == 0 else "normal"
                side = "left" if column < 2 else "right"
                self.write(self._x + stop, self._y, cell, fontweight=weight, ha=side)
            self._y -= LINE
            if k == 0:
                self._axes.plot(
                    [self._x, self._x + COLUMN], [self._y + 0.01] * 2, color=INK, linewidth=0.6
                )
                self._y -= 0.03

    def write(
        self,
        x: float,
        y: float,
        text: str,
        size: float = 7.5,
        width: float = math.inf,
        **style: str,
    ) -> None:
        """Write a line of text down from (x, y).

        Its letters are smaller if the width [inches] requires it.
        """
        letter = 0.72 if style.get("fontweight") == "bold" else 0.62
        needed = letter * max(len(text), 1) / 72.0
        options: dict[str, Any] = {**style, "fontsize": min(size, width / needed), "va": "top"}
        self._axes.text(x, y, re.sub(r"(?<!\w)-(?=\d)", "−", text), **options)

    def caption(self, x: float, y: float, lines: Sequence[str], width: float) -> None:
        """Write lines under a small picture, the first one bold.

        The lower left corner of the picture is at (x, y) [inches].
        """
        for k, text in enumerate(lines):
            if k == 0:
                self.write(x, y - 0.05, text, 7.5, width, fontweight="bold")
            else:
                self.write(x, y - 0.05 - 0.12 * k - 0.02, text, 7.0, width, fontweight="normal")

    def picture(
        self,
        x: float,
        y: float,
        window: Window,
        names: Sequence[str] = ("", ""),
        left: bool = True,
        bottom: bool = True,
    ) -> Axes:
        """Add axes that show a window.

        Args:
            x: left edge [inches].
            y: lower edge [inches].
            window: what they show.
            names: of the directions to the right and up; empty if there are no coordinates.
            left: whether the left edge has numbers.
            bottom: whether the lower edge has numbers.
        """
        axes = self.axes(x, y, *window.sides)
        axes.set(
            xlim=(window.low[0], window.high[0]),
            ylim=(window.low[1], window.high[1]),
            facecolor="none",
        )
        if not any(names):
            axes.set_axis_off()
        for axis, side, name, shown in zip(
            (axes.xaxis, axes.yaxis), window.sides, names, (bottom, left), strict=True
        ):
            axis.set_major_locator(MaxNLocator(max(1, round(side / 0.45)), steps=[1, 2, 5, 10]))
            axis.set_label_text(f"{name} [m]" if shown else "")
        axes.tick_params(labelleft=left, left=left, labelbottom=bottom)
        axes.spines["left"].set_visible(left)
        return axes

    def axes(self, x: float, y: float, width: float, height: float) -> Axes:
        """Add axes at a place [inches]."""
        w, h = self.figure.get_size_inches()
        return self.figure.add_axes((x / w, y / h, width / w, height / h))

    def bar(
        self,
        x: float,
        width: float,
        levels: Sequence[float] = EDGES,
        colours: Sequence[str] = BANDS,
        text: str = f"{SHOCK}; grey: 1.0 when rounded",
    ) -> None:
        """Show colours between levels, one more than colours, under the pictures.

        The text stands under the bar.
        """
        y, step = self.low + 0.14, width / len(colours)
        for k, colour in enumerate(colours):
            corner = (x + k * step, y)
            self._axes.add_artist(
                Rectangle(corner, step, 0.12, facecolor=colour, edgecolor=INK, linewidth=0.5)
            )
        for k, level in enumerate(levels):
            number = "∞" if math.isinf(level) else f"{round(level, 12):g}"
            self.write(x + k * step, y - 0.05, number, 7.0, ha="center")
        self.write(x + width / 2.0, y - 0.2, text, ha="center")

    def key(self, corner: tuple[float, float] | None = None, columns: int = 1) -> None:
        """Explain the signs of the pictures down from a corner [inches].

        By default it is the end of the column.
        """
        signs: dict[Any, Any] = {}
        for axes in self.figure.axes:
            handles, _ = axes.get_legend_handles_labels()
            signs |= {sign.get_label(): sign for sign in handles}
        self._axes.legend(
            handles=sorted(signs.values(), key=lambda sign: -sign.get_zorder()),
            loc="upper left",
            borderpad=0.0,
            borderaxespad=0.0,
            bbox_to_anchor=corner or (self._x, self._y),
            bbox_transform=self._axes.transData,
            ncols=columns,
        )


def _cut_rows(rows: TableRows) -> TableRows:
    """A table as it is shown."""
    left = len(rows) - ROWS - 1
    if left <= 0:
        return [*rows]
    return [*rows[: ROWS + 1], ("", f"and {left} more")]


def _wrapped(notes: Sequence[str], width: float) -> list[str]:
    """The lines of notes that are as wide as this [inches]."""
    letters = max(int(17.2 * width), 20)
    lines = []
    for note in notes:
        lines += textwrap.wrap(note, letters)
    return lines


def column_height(tables: Sequence[TableRows], notes: Sequence[str], signs: int = 7) -> float:
    """Height of a column with a key of so many signs [inches]."""
    if not tables:
        return 0.0
    rows = sum(len(_cut_rows(rows)) + 1.2 for rows in tables)
    return LINE * (rows + signs) + NOTE * len(_wrapped(notes, COLUMN))


def cut(name: str, most: int) -> str:
    """A name as it is printed, of at most so many characters; a longer one is cut at its end."""
    name = printable(name)
    return name if len(name) <= most else f"{name[: most - 1]}…"


def short(value: float, digits: int = 2) -> str:
    """A number with some decimals; large ones to three digits."""
    return f"{round(value, digits) + 0.0:.{digits}f}" if abs(value) < 9.995 else f"{value:.3g}"
