"""Drawing of a landing on axes: bodies in the colours of their shock, and marks.

The marks are centres and radii of percussion, joints, sensors and velocities.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, FancyArrowPatch, Patch, PathPatch, Rectangle
from matplotlib.path import Path

from shockpc.core.spatial import Array
from shockpc.show.figure.field import Field
from shockpc.show.figure.labels import PALE, Labels
from shockpc.show.figure.silhouette import PlaneShape
from shockpc.show.figure.style import BANDS, EDGES, INK, PAPER, band, faded
from shockpc.show.figure.view import PlaneView
from shockpc.show.figure.window import Window

GOLD = "#ffd24d"
"""Colour of sensors."""

ARROW_SIGN = Path([(-1, 0), (0.3, 0), (0.3, 0.25), (1, 0), (0.3, -0.25), (0.3, 0)])
CROSSED = Path.make_compound_path(
    Path.unit_circle(), Path([[-1, 0], [1, 0], [0, -1], [0, 1]], [1, 2, 1, 2])
)


def sign(label: str, zorder: float = 7.0, **style: Any) -> dict[str, Any]:
    """Arguments with which `Axes.plot` draws a mark, and what it means."""
    return {
        "linestyle": "none",
        "color": INK,
        "markerfacecolor": PAPER,
        "label": label,
        "zorder": zorder,
        **style,
    }


SIGNS = {
    "arrow": sign(
        "velocity of the contact before the impact",
        8.0,
        marker=ARROW_SIGN,
        markersize=14.0,
        markerfacecolor=INK,
    ),
    "ring": sign(
        "contact that moves perpendicular to the plane",
        marker="o",
        markersize=12.0,
        fillstyle="none",
    ),
    "centre": sign("CoPc of the body with this number", marker=CROSSED, markersize=8.0),
    "circle": sign(
        "RoPc of the body with this number: shock is 1 there",
        0.5,
        linestyle=(0, (5, 3)),
        linewidth=0.55,
    ),
    "faint centre": sign(
        "CoPc of a body that moves mostly out of the plane",
        5.9,
        marker=CROSSED,
        markersize=8.0,
        color=PALE,
        markeredgewidth=0.7,
    ),
    "faint circle": sign("its RoPc", 0.4, linestyle=(0, (2, 4)), linewidth=0.45, color=PALE),
    "joint": sign("joint", 4.0, marker="o", markersize=2.6, markeredgewidth=0.5),
    "sensor": sign(
        "sensor or point", marker="D", markersize=4.2, markerfacecolor=GOLD, markeredgewidth=0.7
    ),
}
"""Marks of a landing; the style of the arrow is for the key."""

OUTLINED, BOXED = (
    "body in front of the struck limb",
    "box of the inertia: there is no shape to draw",
)
"""Meaning of edges."""

DOTTED = (0, (4, 1.5, 1, 1.5))
"""Line style of a body that is drawn as the box of its inertia."""

OWN = 0.07
"""Room that a centre of percussion takes around itself [inches]."""

WHOLE = 0.75
"""Share of the circle of radius RoPc that has to be inside the picture for the circle to be drawn.
"""


def draw_bodies(axes: Axes, view: PlaneView, fine: float = 4000.0, scale: float = 1.0) -> None:
    """Paint every body, farthest first, on axes in plane coordinates [m].

    Args:
        axes: on which.
        view: of which bodies.
        fine: the robot's size, in smallest details.
        scale: of lines, of which a small picture has thinner ones.
    """
    for order, drawn in enumerate(view.drawn):
        if drawn.region.is_empty:
            continue
        fade, zorder = 0.35 if drawn.far or drawn.outlined else 0.0, 1.0 + 0.01 * order
        style = {
            "linewidth": scale * (0.5 if fade else 0.7),
            "linestyle": DOTTED if drawn.box else "solid",
            "edgecolor": faded(INK, fade),
        }
        label = None
        if drawn.box:
            label = BOXED
        elif drawn.outlined:
            label = OUTLINED
        edge = outlined(
            axes, drawn.region, view.size / fine, zorder=zorder + 0.005, label=label, **style
        )
        if drawn.outlined:
            continue
        for k, patch in layers(drawn.region, drawn.field):
            axes.add_artist(patch).set(
                facecolor=faded(BANDS[k], 0.6 * fade), zorder=zorder, clip_path=edge
            )
    if all(drawn.region.is_empty for drawn in view.drawn):
        nothing = "no body has a shape\nor a valid inertia"
        axes.text(0.5, 0.9, nothing, ha="center", va="top", transform=axes.transAxes)


def layers(region: PlaneShape, field: Field) -> list[tuple[int, Patch]]:
    """Bands, highest first, each with the ellipse in which shock is at most the band's upper limit.

    The first one covers the body. Painted one over the other, what stays visible of each has a
    shock in its band.
    """
    x0, y0, x1, y1 = region.bounds
    U, sigma, turn = np.linalg.svd(field.A, full_matrices=False)
    # Over the body, shock does not change visibly along a direction of a smaller singular value.
    smallest = 1e-3 / max(x1 - x0, y1 - y0)
    scale = np.maximum(sigma, smallest)

    # Centre of the ellipses: A u + c is smallest there, along the directions that count.
    middle = np.array([x0 + x1, y0 + y1]) / 2.0
    away = U.T @ (field.c + field.A @ middle) / scale
    centre = middle - turn.T @ np.where(sigma > smallest, away, 0.0)

    least = field.at(centre)
    top = band(field.at(shapely.get_coordinates(region)).max())
    angle = math.degrees(math.atan2(turn[0, 1], turn[0, 0]))
    patches: list[tuple[int, Patch]] = [(top, Rectangle((x0, y0), x1 - x0, y1 - y0, linewidth=0.0))]
    for k in reversed(range(top)):
        edge = EDGES[k + 1]
        if edge > least:
            # |A u + c|² = least² + (sigma_1 u_1)² + (sigma_2 u_2)² = edge²
            width, height = 2.0 * math.sqrt(edge**2 - least**2) / scale
            ellipse = Ellipse((centre[0], centre[1]), width, height, angle=angle, linewidth=0.0)
            patches.append((k, ellipse))
    return patches


def outlined(axes: Axes, region: PlaneShape, detail: float, **style: Any) -> PathPatch:
    """Draw the edges of a region, which is not empty, up to the smallest detail [m]."""
    rings = shapely.get_rings(shapely.get_parts(shapely.simplify(region, detail)))
    path = Path.make_compound_path(*(Path(ring.coords, closed=True) for ring in rings))
    patch = PathPatch(path, facecolor="none", joinstyle="round", **style)
    axes.add_artist(patch)
    return patch


def draw_marks(axes: Axes, view: PlaneView, window: Window) -> None:
    """Draw all marks over the bodies on axes that show a window."""
    labels = Labels(axes, window, shapely.union_all([drawn.region for drawn in view.drawn]))
    visible: dict[int, Array] = {}
    for i in view.numbers:
        if i in view.centres and window.holds(view.centres[i], 0.05):
            visible[i] = view.centres[i]
    _draw_signs(axes, view, window, labels, visible)
    draw_velocities(axes, view, window)
    for point, velocity in zip(view.contacts, view.velocities, strict=True):
        for share in (0.0, 0.35, 0.7, 1.0):
            labels.keep_free(point + share * window.arrow * velocity, 0.08)
    _tags(view, labels)
    circles = _draw_circles(axes, view, window, visible)

    # Labels, those of centres first.
    for group in _near_one_another(view, window, visible):
        faint = group[0] in view.faint
        text = _numbers(view, group)
        centre = visible[group[0]]
        labels.place(centre, f"({text})" if faint else text, gap=OWN, faint=faint)
    for k, point in enumerate(view.sensors):
        labels.place(point, letter(k), gap=0.06)
    for same in circles:
        line = _circle(visible[same[0]], view.radii[same[0]])
        labels.on_line(line, _numbers(view, same), faint=same[0] in view.faint)


def _numbers(view: PlaneView, bodies: Sequence[int]) -> str:
    return ", ".join(str(view.numbers[i]) for i in bodies)


def _draw_signs(
    axes: Axes, view: PlaneView, window: Window, labels: Labels, visible: Mapping[int, Array]
) -> None:
    """Draw joints, centres of percussion and sensors, and keep labels off them."""
    firm: list[Array] = []
    faint: list[Array] = []
    for i, centre in visible.items():
        (faint if i in view.faint else firm).append(centre)
    joints = [point for point in view.joints if window.holds(point)]
    kinds = (
        ("joint", joints, 0.03),
        ("centre", firm, OWN),
        ("faint centre", faint, OWN),
        ("sensor", view.sensors, 0.06),
    )
    for sign, points, room in kinds:
        for point in points:
            axes.plot(*point, **SIGNS[sign])
            labels.keep_free(point, room)


def _near_one_another(
    view: PlaneView, window: Window, visible: Mapping[int, Array]
) -> list[list[int]]:
    """Bodies whose centres of percussion are so near one another that they have one label."""
    groups: list[list[int]] = []
    for i, centre in visible.items():
        for group in groups:
            alike = (group[0] in view.faint) is (i in view.faint)
            if alike and np.linalg.norm(visible[group[0]] - centre) < OWN * window.inch:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _draw_circles(
    axes: Axes, view: PlaneView, window: Window, visible: Mapping[int, Array]
) -> list[list[int]]:
    """Draw the circles of radius RoPc that are mostly visible; bodies with the same circle."""
    circles: dict[tuple[Any, ...], list[int]] = {}
    for i, centre in visible.items():
        circle = _circle(centre, view.radii[i])
        if window.holds(circle).mean() <= WHOLE:
            continue
        faint = i in view.faint
        axes.plot(*circle.T, **SIGNS["faint circle" if faint else "circle"])
        inches = np.append(centre, view.radii[i]) / window.inch
        circles.setdefault((*inches.round(1).tolist(), faint), []).append(i)
    return list(circles.values())


def _circle(centre: Array, radius: float) -> Array:
    """Points (n, 2) of a circle, the last one as the first."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    return np.asarray(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def letter(index: int) -> str:
    """The letter that stands for a sensor: a to z, then aa, ab and so on."""
    before = letter(index // 26 - 1) if index >= 26 else ""
    return before + chr(ord("a") + index % 26)


def draw_velocities(axes: Axes, view: PlaneView, window: Window, scale: float = 1.0) -> None:
    """Draw the velocity of each contact: an arrow, or a ring if almost perpendicular to the plane.

    Marks may be smaller.
    """
    for point, velocity in zip(view.contacts, view.velocities, strict=True):
        axes.plot(
            *point,
            "o",
            color=INK,
            markersize=5.0 * scale,
            markeredgecolor=PAPER,
            markeredgewidth=0.6 * scale,
            zorder=7.5,
        )
        speed = float(np.linalg.norm(velocity))
        if speed < 0.05:
            axes.plot(*point, **SIGNS["ring"] | {"markersize": 12.0 * scale})
            continue
        axes.plot([], [], **SIGNS["arrow"])
        style: dict[str, Any] = {
            "shrinkA": 0,
            "shrinkB": 0,
            "facecolor": INK,
            "edgecolor": PAPER,
            "linewidth": scale,
            "zorder": 7,
        }
        style |= {"arrowstyle": "simple,head_length=8.5,head_width=10.0,tail_width=3.0"}
        tip = point + window.arrow * velocity
        axes.add_artist(
            FancyArrowPatch(point, tip, mutation_scale=scale * min(1.0, 0.5 + speed), **style)
        )


def _tags(view: PlaneView, labels: Labels) -> None:
    """Write the number of every numbered body on its visible part."""
    nearer: PlaneShape = shapely.MultiPolygon()
    for drawn in reversed(view.drawn):
        if drawn.body in view.numbers:
            visible = shapely.difference(drawn.region, nearer)
            if visible.area > 0.15 * drawn.region.area:
                labels.tag(visible, str(view.numbers[drawn.body]))
        if not drawn.outlined:
            nearer = shapely.union(nearer, drawn.region)
