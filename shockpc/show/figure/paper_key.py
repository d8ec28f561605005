"""What the numbers and the signs of a figure of the paper mean, and what to know before it is held against the print."""

import textwrap
from collections.abc import Callable, Iterator, Sequence

from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from shockpc.paper.scenes import PaperFigure
from shockpc.result import ShockProfile
from shockpc.show.figure.marks import DASHED, SENSOR, percussion_mark
from shockpc.show.figure.palette import INK
from shockpc.show.figure.window import letter

__all__ = ["draw_key", "key_height"]

LINE, LETTER, SIGN = 0.19, 0.054, 0.28
"""Height of a line, mean width of a letter, and room for a sign [inches]."""

SIGNS = ("strike", "centre", "tie", "pointer", "radius", "sensor")

WARNING = "#932c22"
"""Ink of what has to be known before the figure is compared with the print."""


def key_height(figure: PaperFigure, profiles: Sequence[ShockProfile], names: Sequence[str], width: float) -> float:
    """Height of the key, with every sign that may occur [inches]."""
    rows = 1 + max((row for *_, row in _placed(_words(profiles, set(SIGNS)), width)), default=0)
    return LINE * (rows + len(_wrapped(_bodies(names), width)) + len(_wrapped(figure.note, width)) + 0.5)


def draw_key(
    page: Axes,
    figure: PaperFigure,
    profiles: Sequence[ShockProfile],
    names: Sequence[str],
    signs: set[str],
    place: tuple[float, float, float],
) -> None:
    """Write the key.

    Args:
        page: in inches.
        figure: what it is.
        profiles: of its panels.
        names: of the bodies, in the order of their numbers.
        signs: that the panels hold.
        place: left edge, upper edge, width [inches].
    """
    x, y, width = place
    y -= LINE / 2.0
    for line in _wrapped(_bodies(names), width):
        page.text(x, y, line, fontsize=7.5, va="center")
        y -= LINE
    row = 0
    for sign, words, indent, row in _placed(_words(profiles, signs), width):
        _draw(page, sign, x + indent, y - row * LINE)
        page.text(x + indent + SIGN, y - row * LINE, words, fontsize=7.5, va="center")
    y -= (row + 1) * LINE
    for line in _wrapped(figure.note, width):
        page.text(x, y, line, fontsize=7.5, fontstyle="italic", color=WARNING, va="center")
        y -= LINE


def _bodies(names: Sequence[str]) -> str:
    return "bodies: " + ", ".join(f"{k} {name.replace('_', ' ')}" for k, name in enumerate(names, start=1))


def _wrapped(text: str, width: float) -> list[str]:
    return textwrap.wrap(text, max(int(width / LETTER), 20))


def _words(profiles: Sequence[ShockProfile], signs: set[str]) -> list[tuple[str, str]]:
    """The signs that are explained, each with its words."""
    found = [
        ("strike", "strike: velocity of the contact"),
        ("centre", "CoPc of the body of that number" + (", tied to it" if "tie" in signs else "")),
    ]
    found += [("pointer", "its CoPc lies so far beyond the border")] * ("pointer" in signs)
    found += [("radius", "RoPc: shock is 1 on this circle")] * ("radius" in signs)
    sensors = list(dict.fromkeys(point.frame for profile in profiles for point in profile.points))
    if sensors:
        found.append(("sensor", ", ".join(f"{letter(k)} {name}" for k, name in enumerate(sensors))))
    return found


def _placed(words: list[tuple[str, str]], width: float) -> Iterator[tuple[str, str, float, int]]:
    """Sign, words, indent and row of every entry, in rows no wider than that [inches]."""
    x, row = 0.0, 0
    for sign, text in words:
        needed = SIGN + LETTER * len(text)
        if x > 0.0 and x + needed > width:
            x, row = 0.0, row + 1
        yield sign, text, x, row
        x += needed + 0.2


def _draw(page: Axes, sign: str, x: float, y: float) -> None:
    """One sign, in the room before its words."""

    def arrow(head: float, width: float) -> None:
        shape = FancyArrowPatch((x, y), (x + 0.2, y), arrowstyle="-|>", mutation_scale=head, shrinkA=0, shrinkB=0)
        shape.set(linewidth=width, color=INK)
        page.add_patch(shape)

    draw: dict[str, Callable[[], object]] = {
        "strike": lambda: arrow(11.0, 1.9),
        "centre": lambda: percussion_mark(page, x + 0.1, y),
        "pointer": lambda: arrow(9.0, 1.0),
        "radius": lambda: page.plot([x, x + 0.2], [y, y], color=INK, linewidth=0.6, linestyle=DASHED),
        "sensor": lambda: page.plot(
            x + 0.1, y, "D", markersize=4.2, markerfacecolor=SENSOR, markeredgecolor=INK, markeredgewidth=0.7
        ),
    }
    draw[sign]()
