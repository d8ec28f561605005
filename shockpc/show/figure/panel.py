"""The column beside the picture: the numbered bodies, the sensors, and what the signs mean. Inches on a page."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Rectangle

from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import BOXED
from shockpc.show.figure.marks import DASHED, SENSOR, percussion_mark
from shockpc.show.figure.palette import INK, PAPER, faded
from shockpc.show.figure.view import View
from shockpc.show.figure.window import length, letter

__all__ = ["PANEL", "panel", "panel_height"]

PANEL = 2.6
"""Width of the column [inches]."""

LINE = 0.165
"""Height of a line [inches]."""

ROWS = 14
"""Most bodies, and most sensors, that are listed."""

ACROSS = 0.1
"""Share of a body's motion across the plane above which the figure says so [1]."""


def panel_height(profile: ShockProfile, numbers: dict[int, int]) -> float:
    """Height that the column needs at most [inches]."""
    rows = min(len(numbers), ROWS) + (min(len(profile.points), ROWS) + 2.5 if profile.points else 0.0)
    return LINE * (rows + len(_across(profile, numbers)) + 14.0)


def panel(
    page: Axes, profile: ShockProfile, view: View, numbers: dict[int, int], signs: frozenset[str], x: float, y: float
) -> None:
    """Write the column downwards from (x, y) [inches].

    Args:
        page: in inches.
        profile: the shock of a landing.
        view: the bodies in the plane.
        numbers: by index of the body.
        signs: those that the picture holds.
        x: left edge.
        y: upper edge.
    """
    y = _heading(page, x, y, ("", "body", "RoPc", "shock range"))
    listed = list(numbers.items())
    for i, number in listed[:ROWS]:
        low, high = profile.shock_min[i], profile.shock_max[i]
        seen = f"{low:.2f}–{high:.2f}" if np.isfinite(high) else f"{profile.shock_com[i]:.2f}"
        radius = "none" if profile.translates[i] else length(float(profile.ropc[i]))
        _row(page, x, y, (str(number), profile.bodies[i], radius, seen))
        y -= LINE
    y = _more(page, x, y, len(listed))
    for line in _across(profile, numbers):
        page.text(x, y, line, fontsize=7, fontstyle="italic", va="top")
        y -= 0.85 * LINE
    y -= LINE * 0.9
    if profile.points:
        y = _heading(page, x, y, ("", "sensor or point", "", "shock"))
        for k, point in enumerate(profile.points[:ROWS]):
            _row(page, x, y, (letter(k), point.frame, "", f"{point.shock:.2f}"))
            y -= LINE
        y = _more(page, x, y, len(profile.points)) - LINE * 0.9
    _legend(page, profile, view, signs, x, y - LINE / 2.0)


def _across(profile: ShockProfile, numbers: dict[int, int]) -> list[str]:
    """What to keep in mind of bodies that move across the plane too; no line if none does."""
    share = {number: float(profile.off_plane[i]) for i, number in numbers.items() if profile.off_plane[i] > ACROSS}
    if not share:
        return []
    return textwrap.wrap(
        f"{_run(sorted(share))}: up to {100.0 * max(share.values()):.0f} % of the motion is across the plane; colours hold in "
        "the middle of the body, CoPc and RoPc for the part in the plane.",
        width=50,
    )


def _run(numbers: list[int]) -> str:
    """Numbers in order, three or more in a row as a range."""
    runs: list[list[int]] = []
    for n in numbers:
        if runs and n == runs[-1][-1] + 1:
            runs[-1].append(n)
        else:
            runs.append([n])
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)


def _more(page: Axes, x: float, y: float, count: int) -> float:
    """Say how many rows had no room; returns where to go on."""
    if count <= ROWS:
        return y
    page.text(x + 0.2, y, f"and {count - ROWS} more", fontsize=7.5, va="top")
    return y - LINE


def _heading(page: Axes, x: float, y: float, cells: tuple[str, str, str, str]) -> float:
    _row(page, x, y, cells, bold=True)
    page.plot([x, x + PANEL], [y - LINE * 0.95] * 2, color=INK, linewidth=0.6)
    return y - LINE * 1.15


def _row(page: Axes, x: float, y: float, cells: tuple[str, str, str, str], bold: bool = False) -> None:
    number, name, radius, shock = cells
    weight = "bold" if bold else "normal"
    page.text(x, y, number, fontsize=7.5, fontweight="bold", va="top")
    shown = name if len(name) <= 19 else name[:9] + "…" + name[-9:]
    page.text(x + 0.2, y, shown, fontsize=7.5, fontweight=weight, va="top")
    page.text(x + PANEL - 0.86, y, radius, fontsize=7.5, fontweight=weight, ha="right", va="top")
    page.text(x + PANEL, y, shock, fontsize=7.5, fontweight=weight, ha="right", va="top")


def _legend(page: Axes, profile: ShockProfile, view: View, signs: frozenset[str], x: float, y: float) -> None:
    """What each sign means; only those that the picture holds."""
    sign = x + 0.1

    def arrow(head: float, width: float, colour: str = INK) -> None:
        shape = FancyArrowPatch((x, y), (x + 0.2, y), arrowstyle="-|>", mutation_scale=head, shrinkA=0, shrinkB=0)
        shape.set(linewidth=width, color=colour)
        page.add_patch(shape)

    def say(words: str) -> None:
        nonlocal y
        page.text(x + 0.3, y, words, fontsize=7.5, va="center")
        y -= LINE

    arrow(11.0, 1.9)
    say("strike: velocity of the contact")
    page.plot(sign, y, "o", markersize=9.0, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5)
    page.text(sign, y, "1", fontsize=6.5, ha="center", va="center_baseline")
    say("body as listed")
    if "centre" in signs:
        percussion_mark(page, sign, y)
        say("its CoPc, the point without shock")
    if "other centre" in signs:
        page.plot(sign, y, "+", markersize=4.2, color=INK, markeredgewidth=0.7)
        say("CoPc of another body")
    if "pointer" in signs:
        arrow(9.0, 1.0)
        say("CoPc lies so far beyond the border")
    if "other pointer" in signs:
        arrow(5.0, 0.6, faded(INK, 0.45))
        say("CoPc of another body lies beyond")
    if "radius" in signs:
        page.plot([x, x + 0.2], [y, y], color=INK, linewidth=0.6, linestyle=DASHED)
        say("RoPc: shock is 1 on this circle")
    if "joint" in signs:
        page.plot(sign, y, "o", markersize=2.6, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5)
        say("joint")
    if profile.points:
        page.plot(sign, y, "D", markersize=4.2, markerfacecolor=SENSOR, markeredgecolor=INK, markeredgewidth=0.7)
        say("sensor or point")
    if any(drawn.glass for drawn in view.drawn):
        page.add_patch(Rectangle((x, y - 0.05), 0.2, 0.1, fill=False, edgecolor=faded(INK, 0.35), linewidth=0.5))
        say("in front of the struck limb")
    if any(drawn.box for drawn in view.drawn):
        page.add_patch(Rectangle((x, y - 0.05), 0.2, 0.1, fill=False, edgecolor=INK, linewidth=0.7, linestyle=BOXED))
        say("no shape in the file: box of its inertia")
