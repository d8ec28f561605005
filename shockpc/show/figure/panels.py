"""Landings side by side in one figure, on one scale and with one set of colours."""

import textwrap
from collections.abc import Sequence

from matplotlib.figure import Figure

from shockpc.printed import printable
from shockpc.result import ShockProfile
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.canvas import add_axes, new_page
from shockpc.show.figure.marks import draw_marks, letter
from shockpc.show.figure.page import LINE, coordinates, key, line, plane_names, shock_bar
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.view import numbered, view_of
from shockpc.show.figure.window import Window, windows_of
from shockpc.show.header import angle_text, joint_model_text

__all__ = ["draw_panels"]

MOST, LEAST = (9.6, 3.6), (1.55, 1.0)
"""Largest sides of all panels together, and smallest sides of one [inches]."""

LEFT, MARGIN, GAP, HEAD, CAPTION, FOOT, BAR = 0.62, 0.2, 0.15, 0.5, 0.75, 0.85, 4.6
"""Room for the vertical coordinate, at the other edges, between panels, for the title, for coordinates and labels below the panels,
and for the colour bar; and its width [inches]."""

NEAR = (0.7, 0.26)
"""Distance from the robot, sideways and up, as a share of its size, up to which a centre of percussion is in the panel."""


def draw_panels(
    profiles: Sequence[ShockProfile],
    title: str,
    labels: Sequence[str],
    captions: Sequence[Sequence[str]],
    note: str = "",
) -> Figure:
    """Draw landings from left to right.

    A body has the same number in every panel, and so has its centre of percussion. Centres outside a panel are given under it.

    Args:
        profiles: of the landings, each with a panel.
        title: of the figure.
        labels: printed large under each panel.
        captions: lines under each label.
        note: under the key, in italics.
    """
    views = [view_of(profile) for profile in profiles]
    chosen = [profile.bodies[i] for profile, view in zip(profiles, views, strict=True) for i in numbered(profile, view)]
    number = {name: k for k, name in enumerate(dict.fromkeys(chosen), start=1)}
    numbers = [{i: number[name] for i, name in enumerate(profile.bodies) if name in number} for profile in profiles]
    windows = windows_of(profiles, views, numbers, NEAR, MOST, LEAST)
    widths, height = [window.sides[0] for window in windows], windows[0].sides[1]
    across = sum(widths) + GAP * (len(widths) - 1)
    width = LEFT + max(across, BAR + 3.5) + MARGIN
    under = [[*lines, *_outside(*one)] for lines, one in zip(captions, zip(profiles, windows, numbers, strict=True), strict=True)]
    words = ["bodies: " + ", ".join(f"{k} {printable(name.replace('_', ' '), 40)}" for name, k in number.items())]
    words += _sensors(profiles, labels)
    notes = textwrap.wrap(note, int(width / 0.056))
    foot = FOOT + LINE * (len(words) + len(notes))
    bottom = foot + CAPTION + 0.13 * max(map(len, under))
    top = HEAD + height + bottom
    drawing, page = new_page(width, top)
    line(page, MARGIN, top - 0.12, title, 11.0, width - 2.0 * MARGIN, "bold")
    models = " or ".join(dict.fromkeys(joint_model_text(profile) for profile in profiles))
    line(page, MARGIN, top - 0.33, f"joint model: {models}", 7.5, width - 2.0 * MARGIN)
    x, signs = LEFT + (width - LEFT - MARGIN - across) / 2.0, set()
    for k, (profile, view, window) in enumerate(zip(profiles, views, windows, strict=True)):
        picture = add_axes(drawing, x, bottom, widths[k], height)
        coordinates(picture, window, plane_names(profile), left=k == 0)
        signs |= draw_bodies(picture, view) | draw_marks(picture, profile, view, window, numbers[k])
        middle, y = x + widths[k] / 2.0, bottom - 0.42
        page.text(middle, y, labels[k], fontsize=10, fontweight="bold", ha="center", va="top")
        page.text(middle, y - 0.17, "\n".join(under[k]), fontsize=7, ha="center", va="top", linespacing=1.25)
        x += widths[k] + GAP
    shock_bar(drawing, LEFT, foot - 0.1, BAR)
    key(page, signs, (LEFT + BAR + 0.4, foot))
    for k, text in enumerate(words):
        line(page, MARGIN, foot - FOOT - LINE * k, text, 7.5, width - 2.0 * MARGIN)
    for k, text in enumerate(notes, start=len(words)):
        page.text(MARGIN, foot - FOOT - LINE * k, text, va="top", fontstyle="italic")
    return drawing


def _sensors(profiles: Sequence[ShockProfile], labels: Sequence[str]) -> list[str]:
    """What the letters of sensors mean: one line, or one for each panel if they mean different ones."""
    keys = [", ".join(f"{letter(k)} {printable(point.frame, 40)}" for k, point in enumerate(one.points)) for one in profiles]
    if len(set(keys)) == 1:
        return [f"sensors: {keys[0]}"] if keys[0] else []
    return [f"sensors of {label}: {text or 'none'}" for label, text in zip(labels, keys, strict=True)]


def _outside(profile: ShockProfile, window: Window, numbers: dict[int, int]) -> list[str]:
    """How the panel's robot is struck, and the centres of percussion outside the panel."""
    lines = [f"strike angle {angle_text(profile)} deg"]
    centres = to_plane(profile.copc_world, profile.plane)
    for i, number in numbers.items():
        if not profile.translates[i] and not window.holds(centres[i], 0.05):
            lines.append("CoPc {} at ({:.2f}, {:.2f}) m".format(number, *centres[i].round(2) + 0.0))
    return [line.replace(" -", " −").replace("(-", "(−") for line in lines]
