"""A strip of silhouettes at the worst impacts, the struck parts named and coloured."""

import math

import numpy as np
from matplotlib.figure import Figure

from shockpc.quantities.selection import select
from shockpc.show.figure.layout import MARGIN, Page
from shockpc.show.figure.picture import outlined
from shockpc.show.figure.style import BANDS, INK, PAPER, faded
from shockpc.show.figure.view import PlaneView, view_of
from shockpc.show.figure.window import Window
from shockpc.show.header import joint_model_text
from shockpc.show.tables import rounded
from shockpc.show.wording import robot_name
from shockpc.text.printed import few, printable
from shockpc.wings.fall.report import manner
from shockpc.wings.fall.results import StrikeResult
from shockpc.wings.fall.study import Falls

PICTURES, COLUMNS = 12, 4
"""Most pictures, and most in a line."""

WIDTH, CAPTION, GAP = 1.7, 0.56, 0.14
"""Width of a picture, height of what is written under it, and distance to the next [inches]."""

STRUCK, STANDS, BODY = BANDS[6], BANDS[4], faded(INK, 0.86)
"""Colours of what strikes, of what is on the ground already and presses, and of all else."""


def draw_falls(falls: Falls) -> Figure:
    """Draw the worst strike of each kind in the order of the table, on one scale.

    Each robot falls towards the right.
    """
    kinds: dict[tuple[object, ...], list[StrikeResult]] = {}
    for result in falls.results:
        kinds.setdefault(_kind(result), []).append(result)
    # Strikes of one kind are drawn once, by the worst of them.
    alike = list(kinds.values())[:PICTURES]
    views = [view_of(results[0].profile) for results in alike]

    # One scale for all: the widest is as wide as a picture.
    sizes = np.array([view.high - view.low for view in views])
    inch = float(sizes[:, 0].max()) / (WIDTH - 0.1)
    height = float(sizes[:, 1].max()) / inch + 0.15

    # As many in each line, where that is possible.
    lines = math.ceil(len(alike) / COLUMNS)
    across = math.ceil(len(alike) / lines)
    step = WIDTH + GAP
    drop = height + CAPTION + GAP
    page = Page(MARGIN + max(across * step - GAP, 7.0), lines * drop, _heading(falls))
    for k, (results, view) in enumerate(zip(alike, views, strict=True)):
        row, column = divmod(k, across)
        x = MARGIN + column * step
        y = page.low + (lines - 1 - row) * drop + CAPTION + GAP
        _draw_strike(page, x, y, results[0], view, height, inch)
        names = few([printable(result.strike.name, 40) for result in results], 2)
        page.caption(x, y, [f"{k + 1}  {names}", *_caption(falls, results[0])], WIDTH)
    return page.figure


def _heading(falls: Falls) -> tuple[str, ...]:
    """The lines above the pictures."""
    profile = falls.results[0].profile
    name, _, place = falls.rank.partition("@")
    ranked = select(name).quantity.title
    if place:
        ranked += f" of {place}"
    return (
        f"{robot_name(profile.robot)} {manner(falls)}: the worst strike of each kind, by "
        f"{printable(ranked, 60)}",
        "red: struck; blue: stands and presses; dot: contact; each falls towards the right; one "
        "scale",
        f"joint model: {joint_model_text(profile)}",
    )


def _caption(falls: Falls, result: StrikeResult) -> tuple[str, ...]:
    """Value, struck links and motion of a strike."""
    strike = result.strike
    unit = select(falls.rank.partition("@")[0]).quantity.unit
    value = f"{rounded(result.values[falls.rank])} {unit}".removesuffix(" 1")
    first, *more = strike.struck
    struck = printable(first, 40)
    if more:
        struck += f" and {len(more)} more"
    motion = f"{strike.speed:.3g} m/s, {strike.motion}"
    if strike.forward is not None:
        motion += f", {math.degrees(strike.rotation):.0f} deg"
    return value, struck, motion


def _draw_strike(
    page: Page,
    x: float,
    y: float,
    result: StrikeResult,
    view: PlaneView,
    height: float,
    inch: float,
) -> None:
    """Draw the silhouettes of a strike, its ground and its contacts.

    Args:
        page: on which it is drawn.
        x: left side of the picture [inches].
        y: lower side of the picture [inches].
        result: of the strike.
        view: of its landing.
        height: of the picture [inches].
        inch: length in the world of an inch [m].
    """
    ground = float(view.contacts[:, 1].min())
    middle = float(view.low[0] + view.high[0]) / 2.0
    corner = np.array([middle - WIDTH * inch / 2.0, ground - 0.06 * inch])
    window = Window(corner, corner + np.array([WIDTH, height]) * inch, inch)
    axes = page.picture(x, y, window)
    frames = result.profile.robot.frames
    struck = {frames[link].body for link in result.strike.struck}
    stands = {frames[link].body for link in result.strike.stands}

    # What strikes or stands is in front of all else.
    order = sorted(view.drawn, key=lambda drawn: (drawn.body in struck) + (drawn.body in stands))
    visible = [drawn for drawn in order if not drawn.region.is_empty]
    for number, drawn in enumerate(visible):
        colour: str | tuple[float, float, float] = BODY
        if drawn.body in struck:
            colour = STRUCK
        elif drawn.body in stands:
            colour = STANDS
        edge = outlined(
            axes, drawn.region, view.size / 400.0, linewidth=0.4, edgecolor=faded(INK, 0.35)
        )
        edge.set(facecolor=colour, zorder=1.0 + 0.01 * number)
    axes.axhspan(window.low[1], ground, facecolor=faded(INK, 0.6), zorder=0.5)
    axes.axhline(ground, color=INK, linewidth=0.7, zorder=5.0)
    axes.plot(
        *view.contacts.T,
        "o",
        color=INK,
        markersize=3.0,
        markeredgecolor=PAPER,
        markeredgewidth=0.4,
        zorder=6.0,
    )


def _kind(result: StrikeResult) -> tuple[object, ...]:
    """The kind of a strike: what strikes and how.

    Bodies of one mass are the same on either side of the robot.
    """
    robot, strike = result.profile.robot, result.strike
    bodies = {robot.frames[link].body for link in strike.struck}
    return strike.motion, *sorted(f"{robot.masses[body]:.2g}" for body in bodies)
