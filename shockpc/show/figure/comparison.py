"""Designs side by side: the changes as bars, beside the first design.

Designs that look different are drawn too.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.evaluation.comparison import (
    STANDARD,
    WITH_FRICTION,
    Comparison,
    Difference,
    Differences,
)
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.layout import LEFT, Page
from shockpc.show.figure.picture import letter
from shockpc.show.figure.plane import draw_row
from shockpc.show.figure.style import CURVES, INK, PAPER
from shockpc.show.figure.view import PlaneView, view_of
from shockpc.show.figure.window import Window, windows_of
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
"""Largest numbers of rows of a quantity, and of designs beside the first one.

A struck limb with more bodies has more rows.
"""

BAR, THIN, LETTER, WIDTH, GAP, FOOT = 0.2, 0.04, 0.062, 2.6, 0.36, 1.25
"""Sizes of the panels [inches].

They are the height of a row, the least height of one of its bars, the widths of a letter beside
them, of the bars and between panels, and the room under the pictures.
"""

HEADING, SPACE = 1.3, 0.3
"""Heights of a heading over rows and of the space under them, in rows."""

KEYS = (0.9, 1.6)
"""Height of the key in two columns and in one [inches]."""


Sections: TypeAlias = Sequence[tuple[Differences, Sequence[Difference]]]
"""Quantities with their rows."""


class _Sizes(NamedTuple):
    """Sizes on the page [inches].

    Attributes:
        left: width of the pictures.
        pictures: their height, with the room under them.
        names: width of the names of rows.
        bars: height of the bars.
        beside: whether the key is in one column under the pictures, beside the bars; else it is in
            two columns under both.
        height: of all.
    """

    left: float
    pictures: float
    names: float
    bars: float
    beside: bool
    height: float


def draw_comparison(comparison: Comparison, header: Sequence[tuple[str, str]]) -> Figure:
    """Draw bars of the changes beside the first design.

    A design that stands and is struck in the same way is not drawn again.

    Args:
        comparison: of the designs.
        header: letter and description of each.
    """
    letters = [name for name, _ in header[: MOST_DESIGNS + 1]]
    drawn = _drawn(comparison.profiles[: len(letters)])
    sections = [(section, _rows(section)) for section in _sections(comparison)]
    # A section without a number to draw has no heading.
    sections = [(section, rows) for section, rows in sections if rows]
    points = _points(sections)
    views = _views(comparison, drawn, points)
    widest = 4.4 if len(drawn) == 1 else 7.0
    windows = windows_of(views, (0.1, 0.1), (widest, 3.6), (1.6, 1.6), arrow=0.45)
    # Names first, because the longest one decides where the bars begin.
    labels = []
    for section, rows in sections:
        labels += [_label(row, section, views[0], points) for row in rows]
    sizes = _sizes(windows, labels, len(sections), len(letters))

    # Pictures at the left and bars at the right, both from the top.
    x = LEFT + sizes.left + 2.0 * GAP + sizes.names
    page = Page(x + WIDTH + 0.9, sizes.height, _heading(comparison, header, letters))
    low, top = page.low, page.low + sizes.height
    page.low = top - sizes.pictures
    draw_row(page, page.low + FOOT, views, windows, [letters[k] for k in drawn], GAP)
    page.bar(LEFT, sizes.left)
    if sizes.beside:
        page.key((LEFT, page.low - 0.2), 1)
    else:
        page.key((LEFT, low + KEYS[0] - 0.2), 2)
    panel = (x, top - sizes.bars, sizes.bars, sizes.names)
    _draw_bars(page, panel, sections, labels, letters)
    return page.figure


def _drawn(profiles: Sequence[ShockProfile]) -> list[int]:
    """The designs that are drawn: of those that stand and are struck in the same way the first."""
    stands: list[tuple[Any, ...]] = []
    drawn = []
    for k, profile in enumerate(profiles):
        position = profile.position.round(9).tobytes()
        contacts = tuple(contact.frame for contact in profile.contacts)
        stand = (profile.robot.source.path, position, contacts)
        if stand not in stands:
            drawn.append(k)
        stands.append(stand)
    return drawn


def _points(sections: Sections) -> list[str]:
    """The points that rows are of, by their names in the first design."""
    names: dict[str, None] = {}
    for section, rows in sections:
        if section.selection.quantity.of == "point":
            names |= dict.fromkeys(map(_name, rows))
    return list(names)


def _sizes(windows: Sequence[Window], labels: Sequence[str], sections: int, designs: int) -> _Sizes:
    """The sizes on the page.

    Args:
        windows: of the pictures.
        labels: names of the rows.
        sections: number of quantities.
        designs: number of designs.
    """
    left = sum(window.sides[0] + GAP for window in windows) - GAP
    pictures = windows[0].sides[1] + FOOT
    row = max(BAR, THIN * (designs - 1))
    bars = row * (len(labels) + (HEADING + SPACE) * sections)
    beside = pictures + KEYS[1] <= bars + 0.6
    height = bars + 0.6
    if not beside:
        height = max(pictures, bars + 0.6) + KEYS[0]
    return _Sizes(
        left=max(left, 3.4),
        pictures=pictures,
        names=LETTER * max(map(len, labels), default=0) + 0.1,
        bars=bars,
        beside=beside,
        height=height,
    )


def _heading(
    comparison: Comparison, header: Sequence[tuple[str, str]], letters: Sequence[str]
) -> list[str]:
    """The title, a line for each design, and what the pictures do not show."""
    title = f"Shock: changes from {letters[0]}"
    if len(letters) == 2:
        title += f" to {letters[1]}"
    lines = [title, *(f"{name}: {printable(text)}" for name, text in header[: len(letters)])]
    more = len(header) - len(letters)
    if more:
        lines.append(f"{count(more, 'more design')} in the tables")
    if any(profile.scene.friction is not None for profile in comparison.profiles):
        lines.append("colours and CoPc: of contacts that stick, not with friction")
    return lines


def _views(comparison: Comparison, drawn: Sequence[int], points: Sequence[str]) -> list[PlaneView]:
    """The pictures, with these points; partners have one number, and one letter."""
    first = _with_points(view_of(comparison.profiles[0]), comparison.profiles[0], points)
    views = [first]
    bodies = comparison.profiles[0].bodies
    for k in drawn[1:]:
        profile, partners = comparison.profiles[k], comparison.partners[k - 1]
        names = [partners["point"].get(name, name) for name in points]
        view = _with_points(view_of(profile), profile, names)
        numbers = _numbers(first.numbers, bodies, profile.bodies, partners["body"])
        views.append(view._replace(numbers=numbers))
    return views


def _with_points(view: PlaneView, profile: ShockProfile, names: Sequence[str]) -> PlaneView:
    """A picture with only these points, as far as the design has them."""
    known = [point.frame for point in profile.points]
    rows = [known.index(name) for name in names if name in known]
    return view._replace(sensors=view.sensors[rows])


def _numbers(
    numbers: Mapping[int, int],
    first: Sequence[str],
    bodies: Sequence[str],
    partners: Mapping[str, str],
) -> dict[int, int]:
    """The numbers of the bodies of a design: those of their partners in the first design.

    Args:
        numbers: by index of a body of the first design.
        first: its bodies.
        bodies: of the other design.
        partners: names of these by the names of the first.
    """
    matched = {}
    for i, number in numbers.items():
        if first[i] in partners:
            matched[bodies.index(partners[first[i]])] = number
    return matched


def _sections(comparison: Comparison) -> list[Differences]:
    """The quantities that are drawn: those that were asked for, then some of the others."""
    known = {section.selection.name: section for section in comparison.quantities}
    always = [name for name in (*STANDARD, *WITH_FRICTION) if name in known]
    asked = list(known)[: len(known) - len(always)]
    return [known[name] for name in dict.fromkeys((*asked, *DRAWN_QUANTITIES)) if name in known]


def _rows(section: Differences) -> list[Difference]:
    """The rows that are drawn: those of every table, and the largest changes."""
    rows = [row for row in section.rows if _shares(row)]
    firm = []
    if section.selection.quantity.of != "point":
        firm = [row for row in rows if row.always]
    most = max(MOST_ROWS - len(firm), 1)
    others = [row for row in rows if row not in firm][:most]
    return [row for row in rows if row in firm or row in others]


def _name(row: Difference) -> str:
    """The name of its place in the first design."""
    return row.place.split(" / ")[0]


def _shares(row: Difference) -> list[float]:
    """The changes relative to the first design [%]; none if the first is zero or infinite.

    They are NaN where a value does not exist.
    """
    first = row.values[0]
    if not first or not math.isfinite(first):
        return []
    return [float(share) for share in np.array(row.shares, dtype=float)]


def _label(row: Difference, section: Differences, view: PlaneView, points: Sequence[str]) -> str:
    """Name of a row, with the number or letter that it has in the picture."""
    name = printable(row.place)
    kind = section.selection.quantity.of
    if kind == "body" and row.body in view.numbers:
        return f"{name}   {view.numbers[row.body]}"
    if kind == "point" and len(points) == len(view.sensors):
        return f"{name}   {letter(points.index(_name(row)))}"
    return name


def _percent(share: float) -> str:
    """A change in per cent, to two digits, of large ones to one per cent."""
    if not share:
        return "0"
    text = f"{share:+.0f} %" if abs(share) >= 10.0 else f"{share:+.2g} %"
    return text.replace("-", "−")


def _draw_bars(
    page: Page,
    panel: tuple[float, float, float, float],
    sections: Sections,
    labels: Sequence[str],
    letters: Sequence[str],
) -> None:
    """Draw a group of bars for each row.

    Args:
        page: where.
        panel: left and lower edge, height, and room for names [inches].
        sections: quantities with their rows.
        labels: names of the rows.
        letters: of the designs.
    """
    x, y, height, names = panel
    axes = page.axes(x, y, WIDTH, height)
    designs = len(letters) - 1
    # The vertical axis counts rows, downwards.
    rows: list[Difference] = []
    ticks: list[float] = []
    at = 0.0
    for section, of_section in sections:
        _write_heading(axes, section, -names / WIDTH, at + 0.45)
        at += HEADING
        for row in of_section:
            rows.append(row)
            ticks.append(at)
            at += 1.0
        at += SPACE
    shares = [_shares(row)[:designs] for row in rows]
    values = np.array(shares).reshape(len(rows), designs)
    _draw_groups(axes, np.array(ticks), values, letters)
    # The bars of a single design leave room for their numbers.
    if designs == 1:
        for tick, row, change in zip(ticks, rows, values[:, 0].tolist(), strict=True):
            _write_change(axes, tick, row, change)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    low, high = float(np.nanmin(values, initial=0.0)), float(np.nanmax(values, initial=0.0))
    # Room for numbers beyond the longest bars, and some width where nothing changes.
    room = 0.3 * (high - low) or 1.0
    axes.set(
        xlim=(low - room, high + room),
        ylim=(at, 0.0),
        xlabel=f"change relative to {letters[0]} [%]",
    )
    axes.set_yticks(ticks, labels)
    # One design needs no legend, as the axis names it.
    if designs > 1:
        corner = (1.0, 1.0)
        columns = min(designs, 4)
        axes.legend(loc="lower right", bbox_to_anchor=corner, ncols=columns, borderpad=0.0)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)


def _write_heading(axes: Axes, section: Differences, x: float, y: float) -> None:
    """Write the title of a quantity over its rows."""
    quantity = section.selection.quantity
    axes.text(
        x,
        y,
        f"{quantity.title} [{quantity.unit.replace('1', '-')}]",
        fontweight="bold",
        va="center",
        transform=axes.get_yaxis_transform(),
        bbox={"boxstyle": "square,pad=0.1", "facecolor": PAPER, "edgecolor": "none"},
    )


def _draw_groups(axes: Axes, ticks: Array, values: Array, letters: Sequence[str]) -> None:
    """Draw the bars of all rows (n,): a group of the changes (n, designs) at each tick (n,)."""
    designs = values.shape[1]
    thickness = 0.8 / designs
    for k, changes in enumerate(values.T):
        from_tick = (k - (designs - 1) / 2.0) * thickness
        axes.barh(
            ticks + from_tick,
            np.nan_to_num(changes),
            height=0.9 * thickness,
            color=CURVES[k % len(CURVES)],
            label=letters[k + 1],
        )


def _write_change(axes: Axes, tick: float, row: Difference, change: float) -> None:
    """Write the change [%] of a row of two designs at its bar, and both numbers beside it."""
    before, after = row.values[:2]
    if not math.isfinite(change) or after is None:
        return
    side, shift = ("left", 3.0) if change >= 0.0 else ("right", -3.0)
    axes.annotate(
        _percent(change),
        (change, tick),
        (shift, 0.0),
        textcoords="offset points",
        va="center",
        ha=side,
        fontsize=6.0,
    )
    numbers = f"{before:.4g} → {after:.4g}" if change else f"{before:.4g}"
    beside = axes.get_yaxis_transform()
    axes.text(1.02, tick, numbers, va="center", fontsize=6.0, transform=beside)
