"""Draw a landing on axes: bodies in the colours of their shock, centres and radii of percussion, joints, sensors, velocities."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, FancyArrowPatch, Patch, PathPatch, Rectangle
from matplotlib.path import Path

from shockpc.core.spatial import Array
from shockpc.show.figure.silhouette import PlaneShape
from shockpc.show.figure.style import BANDS, EDGES, INK, PAPER, band, faded
from shockpc.show.figure.view import Field, View, Window

GOLD = "#ffd24d"
"""Of sensors."""

PALE = faded(INK, 0.6)
"""Of marks that say little of a body."""

ARROW_SIGN = Path([(-1, 0), (0.3, 0), (0.3, 0.25), (1, 0), (0.3, -0.25), (0.3, 0)])
CROSSED = Path.make_compound_path(Path.unit_circle(), Path([[-1, 0], [1, 0], [0, -1], [0, 1]], [1, 2, 1, 2]))


def sign(label: str, zorder: float = 7.0, **look: Any) -> dict[str, Any]:
    """How `Axes.plot` draws a mark, and what it means."""
    return {"linestyle": "none", "color": INK, "markerfacecolor": PAPER, "label": label, "zorder": zorder, **look}


SIGNS = {
    "arrow": sign("velocity of the contact before the impact", 8.0, marker=ARROW_SIGN, markersize=14.0, markerfacecolor=INK),
    "ring": sign("contact that moves perpendicular to the plane", marker="o", markersize=12.0, fillstyle="none"),
    "centre": sign("CoPc of the body with this number", marker=CROSSED, markersize=8.0),
    "circle": sign("RoPc of the body with this number: shock is 1 there", 0.5, linestyle=(0, (5, 3)), linewidth=0.55),
    "faint centre": sign(
        "CoPc of a body that moves mostly out of the plane", 5.9, marker=CROSSED, markersize=8.0, color=PALE, markeredgewidth=0.7
    ),
    "faint circle": sign("its RoPc", 0.4, linestyle=(0, (2, 4)), linewidth=0.45, color=PALE),
    "joint": sign("joint", 4.0, marker="o", markersize=2.6, markeredgewidth=0.5),
    "sensor": sign("sensor or point", marker="D", markersize=4.2, markerfacecolor=GOLD, markeredgewidth=0.7),
}
"""Marks of a landing; the look of the arrow is for the key."""

OUTLINED, BOXED = "body in front of the struck limb", "box of the inertia: there is no shape to draw"
"""Meaning of edges."""

DOTTED = (0, (4, 1.5, 1, 1.5))
"""Line style of a body that is drawn as the box of its inertia."""

LETTERS, SMALL, TAG, OWN = 7.5, 6.0, 0.09, 0.07
"""Size of labels and of those of circles [pt], radius of a ring with a number, and room that a centre of percussion takes around
itself [inches]."""

FARTHER = (1.0, 2.0)
"""Distances of a label from its mark that are tried, in gaps."""

THIN = 0.9
"""Half the width of a body, as a share of that radius, below which its number is beside it."""

WHOLE = 0.75
"""Share of the circle of radius RoPc that has to be inside the picture for the circle to be drawn."""


def draw_bodies(axes: Axes, view: View, fine: float = 4000.0) -> None:
    """Paint every body, farthest first, on axes in plane coordinates [m]; the smallest detail is a part of the robot's size."""
    for order, drawn in enumerate(view.drawn):
        if drawn.region.is_empty:
            continue
        fade, zorder = 0.35 if drawn.far or drawn.outlined else 0.0, 1.0 + 0.01 * order
        style = {"linewidth": 0.5 if fade else 0.7, "linestyle": DOTTED if drawn.box else "solid", "edgecolor": faded(INK, fade)}
        label = BOXED if drawn.box else OUTLINED if drawn.outlined else None
        edge = outlined(axes, drawn.region, view.size / fine, zorder=zorder + 0.005, label=label, **style)
        for k, patch in [] if drawn.outlined else layers(drawn.region, drawn.field):
            axes.add_artist(patch).set(facecolor=faded(BANDS[k], 0.6 * fade), zorder=zorder, clip_path=edge)
    if all(drawn.region.is_empty for drawn in view.drawn):
        nothing = "no body of this robot has a shape, or an inertia that a body can have"
        axes.text(0.5, 0.9, nothing, ha="center", transform=axes.transAxes)


def layers(region: PlaneShape, field: Field) -> list[tuple[int, Patch]]:
    """Bands, highest first, each with the ellipse in which shock is at most the band's upper limit; the first one covers the body.

    Painted one over the other, what stays visible of each has a shock in its band.
    """
    x0, y0, x1, y1 = region.bounds
    U, sigma, turn = np.linalg.svd(field.A, full_matrices=False)
    # Over the body, shock does not change visibly along a direction of a smaller singular value.
    smallest = 1e-3 / max(x1 - x0, y1 - y0)
    middle = np.array([x0 + x1, y0 + y1]) / 2.0
    away = U.T @ (field.c + field.A @ middle) / np.maximum(sigma, smallest)
    centre = middle - turn.T @ np.where(sigma > smallest, away, 0.0)
    least, top = field.at(centre), band(field.at(shapely.get_coordinates(region)).max())
    patches: list[tuple[int, Patch]] = [(top, Rectangle((x0, y0), x1 - x0, y1 - y0, linewidth=0.0))]
    for k in reversed(range(top)):
        if EDGES[k + 1] > least:
            width, height = 2.0 * math.sqrt(EDGES[k + 1] ** 2 - least**2) / np.maximum(sigma, smallest)
            angle = math.degrees(math.atan2(turn[0, 1], turn[0, 0]))
            patches.append((k, Ellipse((centre[0], centre[1]), width, height, angle=angle, linewidth=0.0)))
    return patches


def outlined(axes: Axes, region: PlaneShape, detail: float, **style: Any) -> PathPatch:
    """Draw the edges of a region, which is not empty, up to the smallest detail [m]."""
    rings = shapely.get_rings(shapely.get_parts(shapely.simplify(region, detail)))
    path = Path.make_compound_path(*(Path(ring.coords, closed=True) for ring in rings))
    patch = PathPatch(path, facecolor="none", joinstyle="round", **style)
    axes.add_artist(patch)
    return patch


def draw_marks(axes: Axes, view: View, window: Window) -> None:
    """Draw all marks over the bodies on axes that show a window."""
    labels = Labels(axes, window, shapely.union_all([drawn.region for drawn in view.drawn]))
    visible = {i: view.centres[i] for i in view.numbers if i in view.centres and window.holds(view.centres[i], 0.05)}
    joints = [place for place in view.joints if window.holds(place)]
    firm, faint = ([centre for i, centre in visible.items() if (i in view.faint) is pale] for pale in (False, True))
    kinds = (("joint", joints, 0.03), ("centre", firm, OWN), ("faint centre", faint, OWN), ("sensor", view.sensors, 0.06))
    for sign, places, room in kinds:
        for place in places:
            axes.plot(*place, **SIGNS[sign])
            labels.keep_free(place, room)
    draw_velocities(axes, view, window)
    for place, velocity in zip(view.contacts, view.velocities, strict=True):
        for share in (0.0, 0.35, 0.7, 1.0):
            labels.keep_free(place + share * window.arrow * velocity, 0.08)
    _tags(view, labels)
    groups: list[list[int]] = []
    circles: dict[tuple[float, ...], list[int]] = {}
    for i, centre in visible.items():
        alike = [group for group in groups if (group[0] in view.faint) is (i in view.faint)]
        near = [group for group in alike if np.linalg.norm(visible[group[0]] - centre) < OWN * window.inch]
        (near[0].append(i) if near else groups.append([i]))
        circle = _circle(centre, view.radii[i])
        if window.holds(circle).mean() > WHOLE:
            axes.plot(*circle.T, **SIGNS["faint circle" if i in view.faint else "circle"])
            circles.setdefault((*(np.append(centre, view.radii[i]) / window.inch).round(1), i in view.faint), []).append(i)
    for group in groups:
        text = ", ".join(str(view.numbers[i]) for i in group)
        labels.place(visible[group[0]], f"({text})" if group[0] in view.faint else text, gap=OWN, faint=group[0] in view.faint)
    for k, place in enumerate(view.sensors):
        labels.place(place, letter(k), gap=0.06)
    for same in circles.values():
        line = _circle(visible[same[0]], view.radii[same[0]])
        labels.on_line(line, ", ".join(str(view.numbers[i]) for i in same), faint=same[0] in view.faint)


def _circle(centre: Array, radius: float) -> Array:
    """Points (n, 2) of a circle, the last one as the first."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    return np.asarray(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def letter(index: int) -> str:
    """The letter that stands for a sensor: a to z, then aa, ab and so on."""
    return (letter(index // 26 - 1) if index >= 26 else "") + chr(ord("a") + index % 26)


def draw_velocities(axes: Axes, view: View, window: Window, scale: float = 1.0) -> None:
    """Draw the velocity of each contact: an arrow, or a ring if it is almost perpendicular to the plane; marks may be smaller."""
    for place, velocity in zip(view.contacts, view.velocities, strict=True):
        axes.plot(*place, "o", color=INK, markersize=5.0 * scale, markeredgecolor=PAPER, markeredgewidth=0.6 * scale, zorder=7.5)
        speed = float(np.linalg.norm(velocity))
        if speed < 0.05:
            axes.plot(*place, **SIGNS["ring"] | {"markersize": 12.0 * scale})
            continue
        axes.plot([], [], **SIGNS["arrow"])
        look: dict[str, Any] = {"shrinkA": 0, "shrinkB": 0, "facecolor": INK, "edgecolor": PAPER, "linewidth": scale, "zorder": 7}
        look |= {"arrowstyle": "simple,head_length=8.5,head_width=10.0,tail_width=3.0"}
        tip = place + window.arrow * velocity
        axes.add_artist(FancyArrowPatch(place, tip, mutation_scale=scale * min(1.0, 0.5 + speed), **look))


def _tags(view: View, labels: "Labels") -> None:
    """Write the number of every numbered body on its visible part."""
    nearer: PlaneShape = shapely.MultiPolygon()
    for drawn in reversed(view.drawn):
        if drawn.body in view.numbers:
            visible = shapely.difference(drawn.region, nearer)
            if visible.area > 0.15 * drawn.region.area:
                labels.tag(visible, str(view.numbers[drawn.body]))
        if not drawn.outlined:
            nearer = shapely.union(nearer, drawn.region)


class Labels:
    """Short labels on axes in plane coordinates, placed one after the other so that they cover as little as possible."""

    def __init__(self, axes: Axes, window: Window, bodies: PlaneShape):
        """Args: axes; window: what they show; bodies: all silhouettes together."""
        self._axes, self._inch, self._bodies = axes, window.inch, bodies
        self._edges: PlaneShape = bodies if bodies.is_empty else bodies.boundary
        self._window: PlaneShape = shapely.box(*window.low, *window.high)
        self._taken: PlaneShape = shapely.Polygon()

    def keep_free(self, place: Array, radius: float) -> None:
        """Let no label cover the disc around a place (2,) [m] of that radius [inches]."""
        self._taken = shapely.union(self._taken, shapely.Point(place).buffer(radius * self._inch, quad_segs=4))

    def tag(self, region: PlaneShape, text: str) -> None:
        """Write a number in a ring: at the centroid of a region, in the middle of its widest part, or beside what is too thin."""
        free = shapely.difference(shapely.intersection(region, self._window), self._taken)
        free = max(shapely.get_parts(free), key=lambda part: float(part.area), default=None)
        if free is None or free.geom_type != "Polygon" or free.is_empty:
            return
        widest = shapely.maximum_inscribed_circle(free)
        (x, y), centroid = widest.coords[0], region.centroid
        room = TAG * self._inch
        if free.contains(centroid) and free.boundary.distance(centroid) > 0.6 * min(widest.length, room):
            x, y = centroid.x, centroid.y
        if widest.length < THIN * room:
            angles = np.arange(16) * np.pi / 8.0
            away = (1.15 * room + widest.length) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
            x, y = min((np.array([x, y]) + away).tolist(), key=lambda place: round(self._covered(place, room), 9))
        self._axes.plot(x, y, "o", markersize=9.5, markerfacecolor=PAPER, markeredgecolor=INK, markeredgewidth=0.5, zorder=6.5)
        self._axes.text(x, y, text, fontsize=6.5, ha="center", va="center_baseline", zorder=6.6)
        self.keep_free(np.array([x, y]), TAG)

    def _covered(self, place: Sequence[float], radius: float) -> float:
        """What a disc covers: marks and labels count most, then what is outside, then bodies; as shares of the disc."""
        disc = shapely.Point(place).buffer(radius, quad_segs=4)
        outside = disc.difference(self._window).area
        covered = 4.0 * disc.intersection(self._taken).area + 2.0 * outside + disc.intersection(self._bodies).area
        return float(covered / disc.area)

    def place(self, mark: Array, text: str, gap: float, faint: bool = False) -> None:
        """Write a short text beside a mark (2,) [m], at a gap [inches] on the side where it covers least."""
        size = self._size(text, LETTERS)
        sides = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
        shifts = [
            np.array(side) * (farther * gap * self._inch + size / 2.0) * (1.0 if 0 in side else 0.8)
            for farther in FARTHER
            for side in sides
        ]
        look: dict[str, Any] = {"color": PALE, "fontweight": "normal"} if faint else {"fontweight": "bold"}
        self._write([mark + shift for shift in shifts], text, LETTERS, **look)

    def on_line(self, line: Array, text: str, faint: bool = False) -> None:
        """Write a short text on a line (n, 2) [m], where it covers least."""
        self._write(list(line[::6]), text, SMALL, color=PALE if faint else INK)

    def _size(self, text: str, letters: float) -> Array:
        """Width and height (2,) of a text [m]."""
        return np.asarray(np.array([0.62 * len(text) + 0.3, 1.25]) * letters / 72.0 * self._inch)

    def _write(self, middles: Sequence[Array], text: str, letters: float, **look: Any) -> None:
        """Write a text around that one of some places (2,) [m] where it covers least."""
        options, size = [], self._size(text, letters)
        for middle in middles:
            box = shapely.box(*(middle - size / 2.0), *(middle + size / 2.0))
            # What is covered counts most, then what is outside, then edges of bodies; all as shares of the label.
            cost = 4.0 * box.intersection(self._taken).area + 2.0 * box.difference(self._window).area
            cost += 0.5 * size[1] * box.intersection(self._edges).length
            options.append((round(float(cost / size.prod()), 9), middle, box))
        # Of places that cover as much the first one, which is the nearest.
        _, middle, box = min(options, key=lambda option: option[0])
        self._taken = shapely.union(self._taken, box)
        backing = {"boxstyle": "round,pad=0.06", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
        self._axes.text(middle[0], middle[1], text, fontsize=letters, ha="center", va="center", zorder=8, bbox=backing, **look)
