"""Designs side by side: what changes as bars, beside the first design, and beside those that look
different.
"""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from shockpc.evaluation.comparison import (
    STANDARD,
    WITH_FRICTION,
    Comparison,
    Difference,
    Differences,
)
from shockpc.show.figure.layout import LEFT, Page
from shockpc.show.figure.picture import letter
from shockpc.show.figure.plane import draw_row
from shockpc.show.figure.style import CURVES, INK, PAPER
from shockpc.show.figure.view import View, view_of
from shockpc.show.figure.window import windows_of
from shockpc.text.printed import count, printable

DRAWN_QUANTITIES = (
    "shock",
    "shock_com",
    "joint_impulse",
    "effective_mass_sticking",
    *WITH_FRICTION[:2],
    "joint_impulse_friction",
)
"""Quantities that are drawn besides those that are asked for, which come first."""

MOST_ROWS, MOST_DESIGNS = 6, len(CURVES)
"""Rows of one quantity, unless the limb that is struck has more bodies; and designs beside the
first one.
"""

BAR, THIN, LETTER, WIDTH, GAP, FOOT = 0.2, 0.04, 0.062, 2.6, 0.36, 1.25
"""Height of a row, least height of one of its bars, width of a letter beside them, of the bars,
between panels, and room under the
pictures [inches]."""

KEYS = (0.9, 1.6)
"""Height of the key in two columns and in one [inches]."""


def draw_comparison(comparison: Comparison, header: Sequence[tuple[str, str]]) -> Figure:
    """Draw bars of the changes beside the first design; one that stands and is struck in the same
    way is not drawn again.

    Args:
        comparison: of the designs.
        header: letter and description of each.
    """
    profiles, letters = comparison.profiles, [name for name, _ in header[: MOST_DESIGNS + 1]]
    stands = [
        (
            profile.robot.source.path,
            profile.position.round(9).tobytes(),
            tuple(contact.frame for contact in profile.contacts),
        )
        for profile in profiles[: len(letters)]
    ]
    drawn = [k for k, stand in enumerate(stands) if stand not in stands[:k]]
    sections = [(section, rows) for section in _sections(comparison) if (rows := _rows(section))]
    points = list(
        dict.fromkeys(
            _name(row)
            for section, rows in sections
            for row in rows
            if section.selection.quantity.of == "point"
        )
    )
    views = _views(comparison, drawn, points)
    windows = windows_of(
        views, (0.1, 0.1), (4.4 if len(drawn) == 1 else 7.0, 3.6), (1.6, 1.6), arrow=0.45
    )
    left = max(sum(window.sides[0] + GAP for window in windows) - GAP, 3.4)
    labels = [_label(row, section, views[0], points) for section, rows in sections for row in rows]
    n, bar = len(labels) + 1.6 * len(sections), max(BAR, THIN * (len(letters) - 1))
    names = LETTER * max(map(len, labels), default=0) + 0.1
    x, pictures, bars = LEFT + left + 2.0 * GAP + names, windows[0].sides[1] + FOOT, bar * n + 0.6
    # The key is in one column under the pictures where these are so much lower than the bars, else
    # in two under both.
    beside = pictures + KEYS[1] <= bars
    tall = bars if beside else max(pictures, bars) + KEYS[0]
    title = f"Shock: changes from {letters[0]}" + (f" to {letters[1]}" if len(letters) == 2 else "")
    lines = [f"{name}: {printable(text)}" for name, text in header[: len(letters)]]
    lines += [f"{count(len(header) - len(letters), 'more design')} in the tables"] * (
        len(header) > len(letters)
    )
    sliding = any(profile.scene.friction is not None for profile in profiles)
    lines += ["colours and CoPc: of contacts that stick, not with friction"] * sliding
    page = Page(x + WIDTH + 0.9, tall, [title, *lines])
    top = page.low + tall
    page.low = top - pictures
    draw_row(page, page.low + FOOT, views, windows, [letters[k] for k in drawn], GAP)
    page.bar(LEFT, left)
    page.key((LEFT, (page.low if beside else top - tall + KEYS[0]) - 0.2), 1 if beside else 2)
    _draw_bars(page, (x, top - bar * n, bar * n, names), sections, labels, letters)
    return page.figure


def _views(comparison: Comparison, drawn: Sequence[int], points: Sequence[str]) -> list[View]:
    """The pictures, with these points; partners have one number, and one letter."""
    views, first = list[View](), comparison.profiles[0].bodies
    for k in drawn:
        profile, view = comparison.profiles[k], view_of(comparison.profiles[k])
        known = [point.frame for point in profile.points]
        names = [
            comparison.partners[k - 1]["point"].get(name, name) if k else name for name in points
        ]
        numbers = view.numbers
        if k:
            bodies, matched = profile.bodies, comparison.partners[k - 1]["body"]
            numbers = {
                bodies.index(matched[first[i]]): number
                for i, number in views[0].numbers.items()
                if first[i] in matched
            }
        sensors = view.sensors[[known.index(name) for name in names if name in known]]
        views.append(view._replace(numbers=numbers, sensors=sensors))
    return views


def _sections(comparison: Comparison) -> list[Differences]:
    """The quantities that are drawn."""
    known = {section.selection.name: section for section in comparison.quantities}
    asked = list(known)[: len(known) - sum(name in known for name in (*STANDARD, *WITH_FRICTION))]
    return [known[name] for name in dict.fromkeys((*asked, *DRAWN_QUANTITIES)) if name in known]


def _rows(section: Differences) -> list[Difference]:
    """The rows that are drawn: those of every table, and the largest changes."""
    rows, of_points = (
        [row for row in section.rows if _shares(row)],
        section.selection.quantity.of == "point",
    )
    firm = [row for row in rows if row.always and not of_points]
    others = [row for row in rows if row not in firm][: max(MOST_ROWS - len(firm), 1)]
    return [row for row in rows if row in firm or row in others]


def _name(row: Difference) -> str:
    """The name of its place in the first design."""
    return row.place.split(" / ")[0]


def _shares(row: Difference) -> list[float] | None:
    """The changes relative to the first design [%]; NaN where one does not exist, None if the first
    is zero, or infinite.
    """
    first = row.values[0]
    if not first or not math.isfinite(first):
        return None
    return [
        math.nan if change is None or not math.isfinite(change) else 100.0 * change / abs(first)
        for change in row.changes
    ]


def _label(row: Difference, section: Differences, view: View, points: Sequence[str]) -> str:
    """Name of a row, with the number or letter that it has in the picture."""
    kind, mark = section.selection.quantity.of, ""
    if kind == "body" and row.body in view.numbers:
        mark = str(view.numbers[row.body])
    elif kind == "point" and len(points) == len(view.sensors):
        mark = letter(points.index(_name(row)))
    return f"{printable(row.place)}   {mark}" if mark else printable(row.place)


def _percent(share: float) -> str:
    """A change in per cent, to two digits, of large ones to one per cent."""
    return (
        "0"
        if not share
        else f"{share:+.{0 if abs(share) >= 10.0 else 2}{'f' if abs(share) >= 10.0 else 'g'}} %".replace(
            "-", "−"
        )
    )


def _draw_bars(
    page: Page,
    place: tuple[float, float, float, float],
    sections: Sequence[tuple[Differences, list[Difference]]],
    labels: Sequence[str],
    letters: Sequence[str],
) -> None:
    """Draw a group of bars for each row.

    Args: place, left and lower edge, height, and room for names [inches].
    """
    x, y, tall, names = place
    axes = page.axes(x, y, WIDTH, tall)
    ticks, shares, at = list[float](), list[list[float]](), 0.0
    for section, rows in sections:
        quantity = section.selection.quantity
        heading = f"{quantity.title} [{quantity.unit.replace('1', '-')}]"
        backing = {"boxstyle": "square,pad=0.1", "facecolor": PAPER, "edgecolor": "none"}
        axes.text(
            -names / WIDTH,
            at + 0.45,
            heading,
            fontweight="bold",
            va="center",
            transform=axes.get_yaxis_transform(),
            bbox=backing,
        )
        at += 1.3
        for row in rows:
            ticks.append(at)
            shares.append((_shares(row) or [])[: len(letters) - 1])
            at += 1.0
        at += 0.3
    values = np.array(shares).reshape(len(ticks), len(letters) - 1)
    low, high = float(np.nanmin(values, initial=0.0)), float(np.nanmax(values, initial=0.0))
    room = 0.3 * (high - low) or 1.0
    thick = 0.8 / values.shape[1]
    for k, changes in enumerate(values.T):
        middles = np.array(ticks) + (k - (values.shape[1] - 1) / 2.0) * thick
        axes.barh(
            middles,
            np.nan_to_num(changes),
            height=0.9 * thick,
            color=CURVES[k % len(CURVES)],
            label=letters[k + 1],
        )
    rows_ = [row for _, rows in sections for row in rows]
    for tick, row, changes in zip(ticks, rows_, values, strict=True):
        if values.shape[1] == 1 and math.isfinite(changes[0]) and row.values[1] is not None:
            text = (
                f"{row.values[0]:.4g} → {row.values[1]:.4g}"
                if changes[0]
                else f"{row.values[0]:.4g}"
            )
            axes.annotate(
                _percent(changes[0]),
                (changes[0], tick),
                (3.0 if changes[0] >= 0.0 else -3.0, 0.0),
                textcoords="offset points",
                va="center",
                ha="left" if changes[0] >= 0.0 else "right",
                fontsize=6.0,
            )
            axes.text(
                1.02, tick, text, va="center", fontsize=6.0, transform=axes.get_yaxis_transform()
            )
    axes.axvline(0.0, color=INK, linewidth=0.8)
    axes.set(
        xlim=(low - room, high + room),
        ylim=(at, 0.0),
        xlabel=f"change relative to {letters[0]} [%]",
    )
    axes.set_yticks(ticks, labels)
    if values.shape[1] > 1:
        axes.legend(
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=min(values.shape[1], 4),
            borderpad=0.0,
        )
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)
