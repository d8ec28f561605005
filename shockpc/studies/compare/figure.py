"""Designs side by side: what changes as bars, beside the first design, and beside those that look different."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from shockpc.show.figure.layout import LEFT, Page
from shockpc.show.figure.picture import letter
from shockpc.show.figure.plane import draw_row
from shockpc.show.figure.style import CURVES, INK, PAPER
from shockpc.show.figure.view import View, view_of, windows_of
from shockpc.studies.compare.study import STANDARD, WITH_FRICTION, Comparison, Difference, Differences
from shockpc.text.printed import printable

DRAWN_QUANTITIES = ("shock", "shock_com", "joint_impulse", "mass_sticking", *WITH_FRICTION[:2], "joint_impulse_friction")
"""Quantities that are drawn besides those that are asked for, which come first."""

MOST_ROWS = 6
"""Bars of one quantity, unless the limb that is struck has more bodies."""

BAR, LETTER, WIDTH, GAP, FOOT = 0.2, 0.062, 2.6, 0.36, 0.95
"""Height of a row of bars, width of a letter beside them, of the bars, between panels, and room under the pictures [inches]."""


def draw_comparison(comparison: Comparison, header: Sequence[tuple[str, str]]) -> Figure:
    """Draw bars of the changes beside the first design; one that stands and is struck in the same way is not drawn again.

    Args:
        comparison: of the designs.
        header: letter and description of each.
    """
    profiles, letters = comparison.profiles, [name for name, _ in header]
    stands = [
        (profile.robot.source.path, profile.position.round(9).tobytes(), tuple(contact.frame for contact in profile.contacts))
        for profile in profiles
    ]
    drawn = [k for k, stand in enumerate(stands) if stand not in stands[:k]]
    views = _views(comparison, drawn)
    windows = windows_of(views, (0.1, 0.1), (4.4 if len(drawn) == 1 else 7.0, 3.6), (1.6, 1.6), arrow=0.45)
    left = sum(window.sides[0] + GAP for window in windows) - GAP
    sections = [(section, rows) for section in _sections(comparison) if (rows := _rows(section))]
    labels = [_label(row, section, comparison, views) for section, rows in sections for row in rows]
    n = len(labels) + 1.6 * len(sections)
    names = LETTER * max(map(len, labels), default=0) + 0.1
    x = LEFT + max(left, 3.4) + 2.0 * GAP + names
    width = max(x + WIDTH + 0.9, x - names + 5.6)
    tall = max(windows[0].sides[1] + FOOT + 0.3, BAR * n + 1.1)
    title = f"Shock: changes from {letters[0]}" + (f" to {letters[1]}" if len(letters) == 2 else "")
    lines = [f"{name}: {printable(text)}" for name, text in header]
    sliding = any(profile.scene.friction is not None for profile in profiles)
    lines += ["colours and CoPc: of contacts that stick, not with friction"] * sliding
    page = Page(width, tall, [title, *lines])
    draw_row(page, page.low + FOOT + 0.3, views, windows, [letters[k] for k in drawn], GAP)
    page.bar(LEFT, max(left, 3.4))
    y = page.low + tall - BAR * n - 0.25
    page.key((x - names, y - 0.43), 2)
    _draw_bars(page, (x, y, n, names), sections, labels, letters)
    return page.figure


def _views(comparison: Comparison, drawn: Sequence[int]) -> list[View]:
    """The pictures; partners have one number."""
    views = [view_of(comparison.profiles[k]) for k in drawn]
    first = comparison.profiles[0].bodies
    for n, k in enumerate(drawn[1:], start=1):
        bodies, matched = comparison.profiles[k].bodies, comparison.partners[k - 1]["body"]
        numbers = {bodies.index(matched[first[i]]): number for i, number in views[0].numbers.items() if first[i] in matched}
        views[n] = views[n]._replace(numbers=numbers)
    return views


def _sections(comparison: Comparison) -> list[Differences]:
    """The quantities that are drawn."""
    known = {section.selection.name: section for section in comparison.quantities}
    asked = list(known)[: len(known) - sum(name in known for name in (*STANDARD, *WITH_FRICTION))]
    return [known[name] for name in dict.fromkeys((*asked, *DRAWN_QUANTITIES)) if name in known]


def _rows(section: Differences) -> list[Difference]:
    """The rows that are drawn: those of every table, and the largest changes."""
    rows = [row for row in section.rows if _shares(row)]
    others = [row for row in rows if not row.always][: max(MOST_ROWS - sum(row.always for row in rows), 1)]
    return [row for row in rows if row.always or row in others]


def _shares(row: Difference) -> list[float] | None:
    """The changes relative to the first design [%]; NaN where one does not exist, None if the first is zero, or infinite."""
    first = row.values[0]
    if not first or not math.isfinite(first):
        return None
    return [math.nan if change is None or not math.isfinite(change) else 100.0 * change / abs(first) for change in row.changes]


def _label(row: Difference, section: Differences, comparison: Comparison, views: Sequence[View]) -> str:
    """Name of a row, with the number or letter that it has in the picture."""
    kind, mark = section.selection.quantity.of, ""
    if kind == "body" and row.body in views[0].numbers:
        mark = str(views[0].numbers[row.body])
    if kind == "point" and len(views) == 1:
        names = [point.frame for point in comparison.profiles[0].points]
        mark = letter(names.index(row.place)) if row.place in names else ""
    return f"{printable(row.place)}   {mark}" if mark else printable(row.place)


def _percent(share: float) -> str:
    """A change in per cent, to two digits, of large ones to one per cent."""
    return (
        "0" if not share else f"{share:+.{0 if abs(share) >= 10.0 else 2}{'f' if abs(share) >= 10.0 else 'g'}} %".replace("-", "−")
    )


def _draw_bars(
    page: Page,
    place: tuple[float, float, float, float],
    sections: Sequence[tuple[Differences, list[Difference]]],
    labels: Sequence[str],
    letters: Sequence[str],
) -> None:
    """Draw a group of bars for each row. Args: place, left and lower edge [inches], height in rows, and room for names [inches]."""
    x, y, n, names = place
    axes = page.axes(x, y, WIDTH, BAR * n)
    ticks, shares, at = list[float](), list[list[float]](), 0.0
    for section, rows in sections:
        quantity = section.selection.quantity
        heading = f"{quantity.title} [{quantity.unit.replace('1', '-')}]"
        backing = {"boxstyle": "square,pad=0.1", "facecolor": PAPER, "edgecolor": "none"}
        axes.text(
            -names / WIDTH, at + 0.45, heading, fontweight="bold", va="center", transform=axes.get_yaxis_transform(), bbox=backing
        )
        at += 1.3
        for row in rows:
            ticks.append(at)
            shares.append(_shares(row) or [])
            at += 1.0
        at += 0.3
    values = np.array(shares).reshape(len(ticks), len(letters) - 1)
    low, high = float(np.nanmin(values, initial=0.0)), float(np.nanmax(values, initial=0.0))
    room = 0.3 * (high - low) or 1.0
    thick = 0.8 / values.shape[1]
    for k, changes in enumerate(values.T):
        middles = np.array(ticks) + (k - (values.shape[1] - 1) / 2.0) * thick
        axes.barh(middles, np.nan_to_num(changes), height=0.9 * thick, color=CURVES[k % len(CURVES)], label=letters[k + 1])
    rows_ = [row for _, rows in sections for row in rows]
    for tick, row, changes in zip(ticks, rows_, values, strict=True):
        if values.shape[1] == 1 and math.isfinite(changes[0]) and row.values[1] is not None:
            text = f"{row.values[0]:.4g} → {row.values[1]:.4g}" if changes[0] else f"{row.values[0]:.4g}"
            axes.annotate(
                _percent(changes[0]), (changes[0], tick), (3.0 if changes[0] >= 0.0 else -3.0, 0.0),
                textcoords="offset points", va="center", ha="left" if changes[0] >= 0.0 else "right", fontsize=6.0,
            )  # fmt: skip
            axes.text(1.02, tick, text, va="center", fontsize=6.0, transform=axes.get_yaxis_transform())
    axes.axvline(0.0, color=INK, linewidth=0.8)
    axes.set(xlim=(low - room, high + room), ylim=(n, 0.0), xlabel=f"change relative to {letters[0]} [%]")
    axes.set_yticks(ticks, labels)
    if values.shape[1] > 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=min(values.shape[1], 4), borderpad=0.0)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)
