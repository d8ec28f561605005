"""A landing in the plane: each body is coloured by the shock at each of its points."""

from collections.abc import Sequence

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.spatial import Array
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.shapes.geometry import drawn_outline
from shockpc.show.figure.layout import LEFT, Page, TableRows, column_height, cut, short
from shockpc.show.figure.picture import draw_bodies, draw_marks, letter
from shockpc.show.figure.style import INK, band, settings
from shockpc.show.figure.view import PlaneView, view_of
from shockpc.show.figure.window import Window, windows_of
from shockpc.show.header import joint_model_text, plane_text, posture_text, strike_text
from shockpc.show.wording import BRACKETED, robot_name
from shockpc.text.printed import count, few, printable
from shockpc.text.wings import from_wings

FOOT = 0.8
"""Room for coordinates and the colour bar [inches]."""

LOW, HIGH = 3.8, 6.4
"""Height of the picture of a tall robot at least, and at most [inches]."""

WARNINGS = 3
"""Warnings that are written in full."""

PICTURE = (5.4, 4.2)
"""Largest width and height of a picture on axes that are given [inches]."""

OUT_OF_PLANE = 0.1
"""Share of a body's motion out of the plane above which the figure says so [1]."""


def draw_landing(profile: ShockProfile) -> Figure:
    """Draw the robot in its plane; e1 points right, e2 up, nearer limbs cover farther ones.

    Colours are those of the three-dimensional field |Δv + Δω × r| / v_in. For a body that moves in
    the plane it does not depend on depth; for others it is taken on the surface through the middle
    of the body. CoPc and RoPc are those of the motion in the plane.
    """
    view = view_of(profile)
    tables, notes = (
        [_body_rows(profile, view), *([_point_rows(profile)] if profile.points else [])],
        _notes(profile, view),
    )
    dashed = list[Array]()
    for overlay in from_wings("report", "overlay"):
        lines, note = overlay(profile)
        if lines:
            dashed += lines
            notes.append(note)
    # A picture much higher than the column beside it would leave the page blank under that.
    tallest = min(max(column_height(tables, notes) - FOOT, LOW), HIGH)
    (window,) = windows_of([view], (0.15, 0.15), (5.4, tallest), (3.4, 2.2))
    width, height = window.sides
    page = Page(LEFT + width, height + FOOT, _heading(profile), tables, notes)
    axes = draw_picture(page, LEFT, page.low + FOOT, view, window)
    for line in dashed:
        axes.plot(*line.T, color=INK, linewidth=1.6, linestyle=(0, (2, 1)), zorder=6.0)
    page.bar(LEFT, width)
    page.key()
    return page.figure


def landing_figure(profile: ShockProfile, axes: Axes | None = None) -> Figure:
    """The figure of a landing in its plane, to be restyled; as `ShockProfile.figure`."""
    with settings():
        if axes is None:
            return draw_landing(profile)
        view = view_of(profile)
        (window,) = windows_of([view], (0.15, 0.15), PICTURE, (3.4, 2.2))
        axes.set_aspect("equal")
        axes.set_xlim(window.low[0], window.high[0])
        axes.set_ylim(window.low[1], window.high[1])
        axes.set_xlabel(f"{view.names[0]} [m]")
        axes.set_ylabel(f"{view.names[1]} [m]")
        draw_bodies(axes, view)
        draw_marks(axes, view, window)
        figure = axes.get_figure(root=True)
        assert isinstance(figure, Figure)
        return figure


def draw_picture(
    page: Page, x: float, y: float, view: PlaneView, window: Window, left: bool = True
) -> Axes:
    """Draw a landing with its coordinates, from (x, y) to the right and up [inches].

    Returns: the axes.
    """
    axes = page.picture(x, y, window, view.names, left)
    draw_bodies(axes, view)
    draw_marks(axes, view, window)
    return axes


def draw_row(
    page: Page,
    y: float,
    views: Sequence[PlaneView],
    windows: Sequence[Window],
    names: Sequence[str],
    gap: float,
) -> list[float]:
    """Draw landings beside one another with a name under each, from the left and y up [inches].

    Returns: the middle of each.
    """
    x, middles = LEFT, list[float]()
    for view, window, name in zip(views, windows, names, strict=True):
        draw_picture(page, x, y, view, window, left=x == LEFT)
        middles.append(x + window.sides[0] / 2.0)
        page.write(
            middles[-1], y - 0.42, name, 10.0, window.sides[0], fontweight="bold", ha="center"
        )
        x += window.sides[0] + gap
    return middles


def _heading(profile: ShockProfile) -> list[str]:
    contacts = few([printable(contact.frame, 30) for contact in profile.contacts], 4, " + ")
    robot = robot_name(profile.robot)
    scene = profile.scene
    words = [
        f"posture {posture_text(profile)}",
        f"base {scene.base or 'free'}",
        f"speed {strike_text(profile)}",
    ]
    if scene.plane != "xz":
        words.append(f"plane {plane_text(profile).partition(';')[0]}")
    if not all(contact.sticks for contact in scene.contact):
        words.append("contact slides")
    kinds = {contact.kind for contact in scene.contact}
    words += [f"{kind} of a sole" for kind in ("edge", "corner") if kind in kinds]
    restitution = max(contact.restitution for contact in scene.contact)
    if restitution:
        words.append(f"restitution {restitution:g}")
    return [
        f"{robot}: shock of landing on {contacts}",
        "; ".join(words),
        f"joint model: {joint_model_text(profile)}",
    ]


def _body_rows(profile: ShockProfile, view: PlaneView) -> TableRows:
    """The numbered bodies: name, CoPc, RoPc and shock."""
    axes = profile.scene.plane if isinstance(profile.scene.plane, str) else ("e1", "e2")
    rows: TableRows = [("", "body", f"CoPc {axes[0]}", f"{axes[1]} [m]", "RoPc [m]", "shock [-]")]
    for i, number in view.numbers.items():
        low, high = profile.shock_min[i], profile.shock_max[i]
        shock = f"{short(profile.shock_com[i])} CoM"
        if np.isfinite(high):
            shock = f"{short(low)}–{short(high)}"
        numbers = [short(x) for x in view.centres.get(i, ())]
        numbers.append(short(profile.ropc[i]))
        if i in view.faint:
            numbers = [f"({number})" for number in numbers]
        cells = numbers if i in view.centres else ["none", "", *numbers]
        rows.append((str(number), cut(profile.bodies[i], 18), *cells, shock))
    return rows


def _point_rows(profile: ShockProfile) -> TableRows:
    """Sensors and points: name, peak acceleration for a given pulse, and shock."""
    rows: TableRows = [
        ("", "sensor or point", "peak [g]" if profile.scene.pulse else "", "shock [-]")
    ]
    for k, point in enumerate(profile.points):
        peak = "" if point.peak_g is None else f"{point.peak_g:.3g}"
        rows.append((letter(k), cut(point.frame, 30), peak, short(point.shock)))
    return rows


def _notes(profile: ShockProfile, view: PlaneView) -> list[str]:
    """Notes on the coordinates' frame, the limits of the picture, and bodies that are not drawn.

    The warnings of the landing follow.
    """
    notes = ["CoPc in world axes, as in the picture; report and CSV give it in body axes."]
    notes += [*_out_of_plane_notes(profile, view), *_colour_notes(profile, view)]
    unseen = [drawn.body for drawn in view.drawn if drawn.region.is_empty]
    if unseen:
        names = [printable(profile.bodies[i], 20) for i in unseen]
        notes.append(f"not drawn, neither shape nor valid inertia: {few(names, 3)}")
    lost: dict[str, None] = {}
    for shape in drawn_outline(profile.robot).unread:
        if shape.mesh:
            lost[printable(shape.mesh.rpartition("/")[2], 24)] = None
    if lost:
        notes.append(f"meshes that are missing or cannot be read: {few(list(lost), 2)}")
    if profile.scene.pulse is not None and profile.points:
        notes.append(f"peak acceleration for a pulse {printable(profile.scene.pulse)}")
    warnings = profile.health.warnings
    notes += [f"warning: {printable(str(warning), 220)}" for warning in warnings[:WARNINGS]]
    if len(warnings) > WARNINGS:
        notes.append(f"{count(len(warnings) - WARNINGS, 'more warning')} in the report")
    return notes


def _out_of_plane_notes(profile: ShockProfile, view: PlaneView) -> list[str]:
    """The numbered bodies that move out of the plane."""
    shares: dict[int, float] = {}
    for i, number in view.numbers.items():
        share = float(profile.out_of_plane_share[i])
        if share > OUT_OF_PLANE:
            shares[number] = share
    if not shares:
        return []
    numbers = ", ".join(map(str, shares))
    brackets = ""
    if not view.faint.isdisjoint(view.numbers):
        brackets = f", which are in brackets above {100.0 * BRACKETED:.0f} %"
    return [
        f"{numbers}: up to {100.0 * max(shares.values()):.0f} % of the motion is out of the plane; "
        "colours hold in the middle of the body, CoPc and RoPc for the motion in the plane"
        f"{brackets}."
    ]


def _colour_notes(profile: ShockProfile, view: PlaneView) -> list[str]:
    """The numbered bodies whose colours are above the shock of the table."""
    texts = []
    for drawn in view.drawn:
        i = drawn.body
        if i not in view.numbers or drawn.outlined or drawn.region.is_empty:
            continue
        shock = float(drawn.field.at(shapely.get_coordinates(drawn.region)).max())
        listed = float(np.fmax(profile.shock_max[i], profile.shock_com[i]))
        if band(shock) > band(listed):
            texts.append(f"{short(shock)} on {view.numbers[i]}")
    if not texts:
        return []
    return [
        f"colours are on what is drawn and reach {', '.join(texts)}; the table is over the "
        "collision geometry, or at the CoM of a body without it."
    ]
