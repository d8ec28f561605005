"""The figure of a landing: the robot in the plane, each body coloured by the shock at each of its points."""

import textwrap

import numpy as np
from matplotlib.figure import Figure

from shockpc.printed import few, printable
from shockpc.result import ShockProfile
from shockpc.robot.geometry import outline
from shockpc.show.figure.bodies import draw_bodies
from shockpc.show.figure.canvas import add_axes, new_page
from shockpc.show.figure.marks import draw_marks, letter
from shockpc.show.figure.page import LINE, coordinates, key, plane_names, remarks, shock_bar, table, title
from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.view import View, numbered, view_of
from shockpc.show.figure.window import windows_of
from shockpc.show.header import joint_model_text, posture_text, strike_text

__all__ = ["draw_landing"]

MOST, LEAST = (5.4, 6.4), (3.4, 2.2)
"""Largest and smallest sides of the picture [inches]."""

MARGIN, LEFT, HEAD, FOOT, COLUMN = 0.2, 0.62, 0.86, 1.0, 3.3
"""Room around everything, for the vertical coordinate, the title, the colour bar, and the column beside the picture [inches]."""

ROWS = 14
"""Most bodies, and most sensors, that are listed."""

NEAR = (0.15, 0.15)
"""Distance from the robot, as a share of its size, up to which a centre of percussion is in the picture."""

OUT_OF_PLANE = 0.1
"""Share of a body's motion out of the plane above which the figure says so [1]."""


def draw_landing(profile: ShockProfile) -> Figure:
    """Draw the robot in its plane; e1 points right, e2 up, nearer limbs cover farther ones.

    Colours are those of the three-dimensional field |Δv + Δω × r| / v_in. For a body that moves in the plane it does not depend on
    depth; for others it is taken on the surface through the middle of the body. CoPc and RoPc are those of the motion in the plane.
    """
    view = view_of(profile)
    numbers = {i: n for n, i in enumerate(numbered(profile, view), start=1)}
    rows, points, notes = _body_rows(profile, numbers), _point_rows(profile), _notes(profile, view, numbers)
    tall = LINE * (len(rows) + len(points) + len(notes) + 12.0)
    (window,) = windows_of([profile], [view], [view.struck], NEAR, MOST, (LEAST[0], max(LEAST[1], tall - FOOT)))
    width, height = window.sides
    x, y = LEFT + width + 2.0 * MARGIN, height + FOOT
    figure, page = new_page(x + COLUMN + MARGIN, y + HEAD)
    picture = add_axes(figure, LEFT, FOOT, width, height)
    coordinates(picture, window, plane_names(profile))
    signs = draw_bodies(picture, view) | draw_marks(picture, profile, view, window, numbers)
    if all(drawn.region.is_empty for drawn in view.drawn):
        nothing = "no body of this robot has a shape, or an inertia that a body can have"
        picture.text(0.5, 0.9, nothing, ha="center", transform=picture.transAxes)
    title(page, MARGIN, y + HEAD - 0.14, _title(profile), x + COLUMN - MARGIN)
    shock_bar(figure, LEFT, 0.48, width)
    y = table(page, x, y, (0.0, 0.2, 1.65, 2.08, 2.68, COLUMN), rows)
    y = remarks(page, x, y, notes)
    if points:
        y = table(page, x, y - LINE, (0.0, 0.2, 2.68, COLUMN), points)
    key(page, signs, (x, y - LINE))
    return figure


def _title(profile: ShockProfile) -> tuple[str, str, str]:
    """Robot and contacts; posture, base and strike; joint model."""
    contacts = few([printable(contact.frame, 30) for contact in profile.contacts], 4, " + ")
    robot = printable(profile.robot.source.name or profile.robot.name, 40)
    scene = profile.scene
    words = [f"posture {posture_text(profile)}", f"base {scene.base or 'free'}", f"strike {strike_text(profile)}"]
    words += ["contact slides"] * any(not contact.sticks for contact in scene.contact)
    words += [f"restitution {e:g}" for e in [max(contact.restitution for contact in scene.contact)] if e]
    return f"{robot}: shock of landing on {contacts}", "; ".join(words), f"joint model: {joint_model_text(profile)}"


def _body_rows(profile: ShockProfile, numbers: dict[int, int]) -> list[tuple[str, ...]]:
    """The numbered bodies: name, CoPc, RoPc and shock."""
    axes = profile.scene.plane if isinstance(profile.scene.plane, str) else ("e1", "e2")
    rows: list[tuple[str, ...]] = [("", "body", f"CoPc {axes[0]}", f"{axes[1]} [m]", "RoPc [m]", "shock [-]")]
    for i, number in list(numbers.items())[:ROWS]:
        low, high = profile.shock_min[i], profile.shock_max[i]
        shock = f"{_shock(low)}–{_shock(high)}" if np.isfinite(high) else _shock(profile.shock_com[i])
        centre = ("none", "") if profile.translates[i] else map(_metres, to_plane(profile.copc_world[i], profile.plane))
        rows.append((str(number), printable(profile.bodies[i], 16), *centre, _metres(float(profile.ropc[i])), shock))
    if len(numbers) > ROWS:
        rows.append(("", f"and {len(numbers) - ROWS} more", "", "", "", ""))
    return rows


def _point_rows(profile: ShockProfile) -> list[tuple[str, ...]]:
    """Sensors and points: name, peak acceleration for a given pulse, and shock."""
    if not profile.points:
        return []
    rows: list[tuple[str, ...]] = [("", "sensor or point", "peak [g]" if profile.scene.pulse else "", "shock [-]")]
    for k, point in enumerate(profile.points[:ROWS]):
        peak = "" if point.peak_g is None else f"{point.peak_g:.3g}"
        rows.append((letter(k), printable(point.frame, 24), peak, _shock(point.shock)))
    if len(profile.points) > ROWS:
        rows.append(("", f"and {len(profile.points) - ROWS} more", "", ""))
    return rows


def _notes(profile: ShockProfile, view: View, numbers: dict[int, int]) -> list[str]:
    """What limits the picture: motion out of the plane, and bodies that cannot be drawn; lines of text."""
    notes = []
    share = {number: float(profile.off_plane[i]) for i, number in numbers.items() if profile.off_plane[i] > OUT_OF_PLANE}
    if share:
        notes.append(
            f"{', '.join(map(str, share))}: up to {100.0 * max(share.values()):.0f} % of the motion is out of the plane; colours "
            "hold in the middle of the body, CoPc and RoPc for the motion in the plane."
        )
    unseen = [printable(profile.bodies[drawn.body], 20) for drawn in view.drawn if drawn.region.is_empty]
    if unseen:
        notes.append(f"not drawn, neither shape nor valid inertia: {few(unseen, 3)}")
    lost = [printable(shape.mesh.rpartition("/")[2], 24) for shape in outline(profile.robot, "visual").unread if shape.mesh]
    if lost:
        notes.append(f"meshes that are missing or cannot be read: {few(list(dict.fromkeys(lost)), 2)}")
    if profile.scene.pulse is not None and profile.points:
        notes.append(f"peak acceleration for a pulse {printable(profile.scene.pulse)}")
    return [part for note in notes for part in textwrap.wrap(note, 58)]


def _shock(value: float) -> str:
    """A shock in at most seven characters."""
    return f"{value:.2f}" if value < 1e3 else f"{value:.1e}"


def _metres(value: float) -> str:
    """A length to about three digits."""
    return (f"{round(value, 2) + 0.0:.2f}" if abs(value) < 9.995 else f"{value:.3g}").replace("-", "−")
