"""Landings side by side in the plane, on one scale."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.layout import LEFT, Page, TableRows
from shockpc.show.figure.picture import letter
from shockpc.show.figure.plane import FOOT, draw_row
from shockpc.show.figure.view import PlaneView, view_of
from shockpc.show.figure.window import Window, windows_of
from shockpc.show.header import angle_text, joint_model_text
from shockpc.text.printed import printable

GAP, BAR = 0.15, 4.6
"""Room between panels, and smallest width of the bar under them [inches]."""


def draw_panels(
    profiles: Sequence[ShockProfile],
    title: str,
    labels: Sequence[str],
    captions: Sequence[Sequence[str]],
    note: str = "",
) -> Figure:
    """Draw landings from left to right.

    A body has the same number in every panel, and so has its centre of percussion. Centres outside
    a panel are given under it.

    Args:
        profiles: of the landings, each with a panel.
        title: of the figure.
        labels: printed large under each panel.
        captions: lines under each label.
        note: under the tables, in italics.
    """
    views, number = _numbered([view_of(profile) for profile in profiles], profiles)
    # Panels have one scale and one height, so that lengths compare.
    windows = windows_of(views, (0.7, 0.26), (7.6, 3.6), (1.25, 1.0), arrow=0.45)
    # The panel with most lines under it says how high the page is.
    under: list[list[str]] = []
    for lines, profile, view, window in zip(captions, profiles, views, windows, strict=True):
        under.append([*lines, *_outside(profile, view, window)])
    foot = FOOT + 0.3 + 0.13 * max(map(len, under))
    width = max(sum(window.sides[0] + GAP for window in windows) - GAP, BAR)
    # Panels may differ in their joint model; each is named once.
    models = " or ".join(dict.fromkeys(joint_model_text(profile) for profile in profiles))
    bodies: TableRows = [("", "body")]
    for name, k in number.items():
        bodies.append((str(k), printable(name.replace("_", " "), 40)))
    page = Page(
        LEFT + width,
        windows[0].sides[1] + foot,
        (title, f"joint model: {models}"),
        [bodies, *_sensors(profiles, labels)],
        [note],
    )
    y = page.low + foot
    # Pictures first: their middles are those of the texts under them.
    middles = draw_row(page, y, views, windows, labels, GAP)
    for middle, window, texts in zip(middles, windows, under, strict=True):
        text_width = window.sides[0] + GAP
        for n, text in enumerate(texts):
            page.write(middle, y - 0.6 - 0.13 * n, text, 7.0, text_width, ha="center")
    page.bar(LEFT, BAR)
    page.key()
    return page.figure


def _numbered(
    views: Sequence[PlaneView], profiles: Sequence[ShockProfile]
) -> tuple[list[PlaneView], dict[str, int]]:
    """Views in which a body has the same number, and these numbers by its name.

    They are of all bodies that have one in a view.
    """
    number: dict[str, int] = {}
    for profile, view in zip(profiles, views, strict=True):
        for i in view.numbers:
            number.setdefault(profile.bodies[i], len(number) + 1)
    numbered: list[PlaneView] = []
    for profile, view in zip(profiles, views, strict=True):
        by_body: dict[int, int] = {}
        for i, name in enumerate(profile.bodies):
            if name in number:
                by_body[i] = number[name]
        numbered.append(view._replace(numbers=by_body))
    return numbered, number


def _sensors(profiles: Sequence[ShockProfile], labels: Sequence[str]) -> list[TableRows]:
    """The meaning of the letters of sensors: one table, or one for each panel if they differ."""
    tables: list[TableRows] = []
    for profile in profiles:
        tables.append(
            [(letter(k), printable(point.frame, 40)) for k, point in enumerate(profile.points)]
        )
    if all(rows == tables[0] for rows in tables):
        return [[("", "sensor or point"), *tables[0]]] if tables[0] else []
    return [
        [("", f"sensor or point of {label}"), *rows]
        for label, rows in zip(labels, tables, strict=True)
        if rows
    ]


def _outside(profile: ShockProfile, view: PlaneView, window: Window) -> list[str]:
    """The strike on the panel's robot, and the centres of percussion outside the panel."""
    lines = [f"strike angle {angle_text(profile)} deg"]
    for i, number in view.numbers.items():
        if i in view.centres and not window.holds(view.centres[i], 0.05):
            x, z = view.centres[i].round(2) + 0.0
            lines.append(f"CoPc {number} at ({x:.2f}, {z:.2f}) m")
    return lines
