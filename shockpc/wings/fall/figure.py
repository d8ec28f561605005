"""A strip of silhouettes in the moment of the worst impacts, the struck parts named and coloured."""

import math

import numpy as np
from matplotlib.figure import Figure

from shockpc.quantities.selection import select
from shockpc.show.figure.layout import MARGIN, Page
from shockpc.show.figure.picture import outlined
from shockpc.show.figure.style import BANDS, INK, PAPER, faded
from shockpc.show.figure.view import view_of
from shockpc.show.figure.window import Window
from shockpc.show.header import joint_model_text
from shockpc.show.tables import rounded
from shockpc.show.wording import robot_name
from shockpc.text.printed import few, printable
from shockpc.wings.fall.study import Falls, StrikeResult

PICTURES, COLUMNS = 12, 4
"""Most pictures, and most in a line."""

WIDTH, CAPTION, GAP = 1.7, 0.56, 0.14
"""Width of a picture, height of what is written under it, and distance to the next [inches]."""

STRUCK, STANDS, BODY = BANDS[6], BANDS[4], faded(INK, 0.86)
"""Colours of what strikes, of what is on the ground already and presses, and of all else."""


def draw_falls(falls: Falls) -> Figure:
    """Draw the worst strike of each kind in the order of the table, on one scale; each falls
    towards the right.
    """
    kinds: dict[tuple[object, ...], list[StrikeResult]] = {}
    for result in falls.results:
        kinds.setdefault(_kind(result), []).append(result)
    alike = list(kinds.values())[:PICTURES]
    results = [kind[0] for kind in alike]
    views = [view_of(result.profile) for result in results]
    sizes = np.array([view.high - view.low for view in views])
    inch = float(sizes[:, 0].max()) / (WIDTH - 0.1)
    height = float(sizes[:, 1].max()) / inch + 0.15
    lines = math.ceil(len(results) / COLUMNS)
    across, step, drop = math.ceil(len(results) / lines), WIDTH + GAP, height + CAPTION + GAP
    what = f"dropped from {falls.drop:g} m" if falls.drop is not None else "tipping over"
    name, _, place = falls.rank.partition("@")
    entry = select(name).quantity
    ranked = printable(entry.title + f" of {place}" * bool(place), 60)
    heading = (
        f"{robot_name(falls.results[0].profile.robot)} {what}: the worst strike of each kind, by "
        f"{ranked}",
        "red: struck; blue: stands and presses; dot: contact; each falls towards the right; one "
        "scale",
        *(f"joint model: {joint_model_text(result.profile)}" for result in results[:1]),
    )
    page = Page(MARGIN + max(across * step - GAP, 7.0), lines * drop, heading)
    for k, (kind, result, view) in enumerate(zip(alike, results, views, strict=True)):
        x, y = (
            MARGIN + (k % across) * step,
            page.low + (lines - 1 - k // across) * drop + CAPTION + GAP,
        )
        ground, middle = float(view.contacts[:, 1].min()), float(view.low[0] + view.high[0]) / 2.0
        corner = np.array([middle - WIDTH * inch / 2.0, ground - 0.06 * inch])
        window = Window(corner, corner + np.array([WIDTH, height]) * inch, inch)
        axes = page.picture(x, y, window)
        strike, frames = result.strike, result.profile.robot.frames
        struck, stands = (
            {frames[link].body for link in links} for links in (strike.struck, strike.stands)
        )
        order = sorted(
            view.drawn, key=lambda drawn: (drawn.body in struck) + (drawn.body in stands)
        )
        for number, drawn in enumerate(drawn for drawn in order if not drawn.region.is_empty):
            colour = STRUCK if drawn.body in struck else STANDS if drawn.body in stands else BODY
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
        turned = "" if strike.forward is None else f", {math.degrees(strike.rotation):.0f} deg"
        first, *others = strike.struck
        named = printable(first, 40) + f" and {len(others)} more" * bool(others)
        motion = f"{strike.speed:.3g} m/s, {strike.motion}{turned}"
        value = f"{rounded(result.values[falls.rank])} {entry.unit}".removesuffix(" 1")
        names = few([printable(one.strike.name, 40) for one in kind], 2)
        page.caption(x, y, [f"{k + 1}  {names}", value, named, motion], WIDTH)
    return page.figure


def _kind(result: StrikeResult) -> tuple[object, ...]:
    """What strikes and how: bodies of one mass are the same on either side of the robot."""
    robot, strike = result.profile.robot, result.strike
    bodies = {robot.frames[link].body for link in strike.struck}
    return strike.motion, *sorted(f"{robot.masses[body]:.2g}" for body in bodies)
