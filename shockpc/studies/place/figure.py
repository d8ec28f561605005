"""The figure of a placement: the largest shock over a body in three views.

It shows the present sensors, the best places and the CoPcs.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.spatial import Array, Plane
from shockpc.robot.shapes.convex import Shape
from shockpc.show.figure.body_shapes import body_shapes
from shockpc.show.figure.labels import Labels
from shockpc.show.figure.layout import LEFT, Page, TableRows, column_height, cut, short
from shockpc.show.figure.picture import GOLD, SIGNS, letter, outlined, sign
from shockpc.show.figure.silhouette import (
    Edges,
    PlaneShape,
    projection,
    silhouette,
    surface,
    to_plane,
)
from shockpc.show.figure.style import INK, shock_levels
from shockpc.show.figure.window import Window
from shockpc.show.header import joint_model_text, posture_text
from shockpc.show.wording import robot_name
from shockpc.studies.place.study import PlaceStudy
from shockpc.text.printed import count, printable

ROOM, FOOT, GAP, PAD = 6.6, 0.85, 0.28, 0.2
"""Sizes of the figure [inches].

They are the largest width and height of the views together, and the room for coordinates and the
colour bar, between views, and around the body in each view.
"""

NEARBY_SHARE = 0.3
"""Distance of a CoPc from the body, as a share of its size, up to which it is in the views."""

CELLS = 64
"""Cells along each side of the grid on which shock is contoured."""

STAR = sign(
    "place found", 7.5, marker="*", markersize=9.0, markerfacecolor=GOLD, markeredgewidth=0.7
)
DOT = sign("CoPc of a landing", 6.0, marker="o", markersize=3.2, markeredgewidth=0.7)

VIEWS = {"side": (0, 2), "top": (0, 1), "front": (1, 2)}
"""Axes of the body's frame that point to the right and up."""

REGION_STYLE: dict[str, Any] = {
    "edgecolor": INK,
    "linewidth": 0.6,
    "linestyle": (0, (4, 2)),
    "zorder": 3.0,
    "label": "where a sensor may be",
}
"""Style of the outline of the region."""


class _Content(NamedTuple):
    """The content of the views, in the body's frame.

    Attributes:
        shapes: of the body.
        cells: convex pieces of the region, if it has an inside.
        marks: (n, 3) places, and points of the region [m].
        copc: (m, 3) the CoPcs near the body [m].
    """

    shapes: tuple[Shape, ...]
    cells: list[Shape]
    marks: Array
    copc: Array


class _Frame(NamedTuple):
    """The box of the body's frame that the views show, and their scale.

    Attributes:
        low: (3,) lower corner [m].
        high: (3,) upper corner [m].
        inch: length that is an inch on the page [m].
    """

    low: Array
    high: Array
    inch: float

    @property
    def sides(self) -> tuple[float, float, float]:
        """Width of the side view, width of the front view, and height of both [inches]."""
        x, y, z = ((self.high - self.low) / self.inch).tolist()
        return x, y, z

    @property
    def across(self) -> float:
        """Width of the side view and the front view beside it [inches]."""
        width, depth, _ = self.sides
        return width + GAP + depth

    def corner(self, view: str) -> tuple[float, float]:
        """Lower left corner of a view over the lower edge of the page's content [inches]."""
        width, _, height = self.sides
        if view == "top":
            return LEFT, FOOT + height + GAP
        return (LEFT if view == "side" else LEFT + width + GAP), FOOT

    @property
    def detail(self) -> float:
        """Length below which outlines are not resolved [m]."""
        return self.inch * ROOM / 4000.0


class _View(NamedTuple):
    """A view of the body.

    Attributes:
        plane: of the picture.
        region: outline of the body, in plane coordinates [m].
        values: (CELLS + 1, CELLS + 1) what places are compared by, on a grid through the best
            place, a row for each height [1].
        seen: (n,) those of the values that lie on the body [1].
    """

    plane: Plane
    region: PlaneShape
    values: Array
    seen: Array


def draw_place(placement: PlaceStudy) -> Figure:
    """Draw the body in its frame, from the side, from above and from the front.

    The colours are what places are compared by, in the plane through the best place.
    """
    content, frame = _content_and_frame(placement)
    page = _page(placement, frame, len(content.copc))
    # The edges of a mesh are the same in all views.
    edges: dict[int, Edges] = {}
    views = [_view(placement, content, frame, pair, edges) for pair in VIEWS.values()]
    # One scale of colours for all views and marks.
    at_marks = placement.fields.at(content.marks)
    shocks = np.concatenate([at_marks, *(view.seen for view in views)])
    bands = shock_levels(float(shocks.min()), float(shocks.max()))

    for name, view in zip(VIEWS, views, strict=True):
        i, j = VIEWS[name]
        window = Window(frame.low[[i, j]], frame.high[[i, j]], frame.inch)
        x, y = frame.corner(name)
        outer = {"left": name != "front", "bottom": name != "top"}
        axes = page.picture(x, page.low + y, window, "xyz"[i] + "xyz"[j], **outer)
        if not view.region.is_empty:
            _colour(axes, view, window, frame.detail, bands)
        # Cells of the region may overlap; their union has one outline.
        hulls = [projection(cell, view.plane) for cell in content.cells]
        if hulls:
            outlined(axes, shapely.union_all(hulls), frame.detail, **REGION_STYLE)
        _mark(axes, placement, view.plane, Labels(axes, window, view.region), content.copc)
        axes.text(0.02, 0.98, name, fontstyle="italic", va="top", transform=axes.transAxes)
    number = "maximum normalised shock over the landings |Δv| / v_in [-]"
    page.bar(LEFT, frame.across, *bands, f"{number}, in the plane through place 1")
    page.key()
    return page.figure


def _page(placement: PlaceStudy, frame: _Frame, near: int) -> Page:
    """The page with its heading, table and notes. Args: near, number of CoPcs in the views."""
    width, depth, height = frame.sides
    tables = [_rows(placement)]
    notes = _notes(placement, near)
    # The column is above the front view, if there is room.
    column = None
    if column_height(tables, notes, signs=4) < depth + GAP:
        column = LEFT + width + 2.0 * GAP
    size = LEFT + frame.across, FOOT + height + GAP + depth
    return Page(*size, _heading(placement), tables, notes, column)


def _content_and_frame(placement: PlaceStudy) -> tuple[_Content, _Frame]:
    """The content of the views, and the box around it."""
    shapes, _ = body_shapes(placement.robot)[placement.body]
    cells = []
    if placement.region.solid:
        cells = [Shape("", cell.points, cell.rounding) for cell in placement.region.cells]
    marks = np.array([sensor.position for sensor in (*placement.today, *placement.places)])
    if cells:
        marks = np.concatenate([marks, surface(cells)])
    points = np.concatenate([surface(shapes), marks]) if shapes else marks
    near = NEARBY_SHARE * max(float(np.ptp(points, axis=0).max()), 1e-6)
    copc = _nearby_copc(placement, points, near)
    frame = _frame(np.concatenate([points, copc]), 0.15 * near)
    return _Content(shapes, cells, marks, copc), frame


def _nearby_copc(placement: PlaceStudy, points: Array, near: float) -> Array:
    """The CoPcs (m, 3) of the landings at most a distance from the box of points (n, 3) [m]."""
    copc = np.array([profile.copc[placement.body] for profile in placement.profiles])
    is_near = (copc > points.min(axis=0) - near) & (copc < points.max(axis=0) + near)
    return np.asarray(copc[is_near.all(axis=1)])


def _frame(points: Array, least: float) -> _Frame:
    """The box of points (n, 3) with sides of a least length, and the scale of views of it [m]."""
    low = points.min(axis=0)
    high = np.maximum(points.max(axis=0), low + least)
    x, y, z = high - low
    # Length of an inch of paper: two views and their pads are side by side in the room.
    drawn = ROOM - GAP - 4.0 * PAD
    inch = float(max(x + y, z + y)) / drawn
    return _Frame(low - PAD * inch, high + PAD * inch, inch)


def _view(
    placement: PlaceStudy,
    content: _Content,
    frame: _Frame,
    pair: tuple[int, int],
    edges: dict[int, Edges],
) -> _View:
    """A view of the body, and what places are compared by in its plane through the best place.

    Args:
        placement: the result.
        content: of the views.
        frame: of the views.
        pair: axes of the body's frame that point to the right and up.
        edges: of meshes, which are computed once for all views.
    """
    e1, e2 = np.eye(3)[list(pair)]
    plane = Plane(np.cross(e1, e2), e1, e2)
    region = silhouette(content.shapes, plane, frame.detail, edges)
    # A grid over the two axes; the third is that of the best place.
    lines = np.linspace(frame.low, frame.high, CELLS + 1)
    coordinates = [placement.places[0].position[k : k + 1] for k in range(3)]
    for k in pair:
        coordinates[k] = lines[:, k]
    points = np.stack(np.meshgrid(*coordinates, indexing="ij"), axis=-1).reshape(-1, 3)
    values = seen = placement.fields.at(points)
    if content.shapes:
        seen = values[shapely.contains_xy(region, *to_plane(points, plane).T)]
    return _View(plane, region, values.reshape(CELLS + 1, CELLS + 1).T, seen)


def _colour(
    axes: Axes,
    view: _View,
    window: Window,
    detail: float,
    bands: tuple[list[float], list[str]],
) -> None:
    """Draw the outline of the body, filled with the colours of its shocks.

    Args: bands, limits of shock and colours.
    """
    levels, colours = bands
    edge = outlined(axes, view.region, detail, edgecolor=INK, linewidth=0.7, zorder=2.0)
    shades = [colours[0], *colours]
    extend: Any = "min"
    # The last of all bands has no end, beyond which matplotlib cannot extend.
    if not math.isinf(levels[-1]):
        shades.append(colours[-1])
        extend = "both"
    (left, low), (right, high) = window.low, window.high
    filled = axes.contourf(
        view.values,
        levels=levels,
        colors=shades,
        extend=extend,
        extent=(left, right, low, high),
        zorder=1.0,
    )
    # Edges of the same colour close the gaps that anti-aliasing leaves between neighbours.
    filled.set(edgecolor="face", linewidth=0.3, clip_path=edge)


def _mark(axes: Axes, placement: PlaceStudy, plane: Plane, labels: Labels, copc: Array) -> None:
    """Mark CoPcs (n, 3), today's sensors and the places found, with labels."""
    for point in to_plane(copc, plane):
        labels.keep_free(point, 0.03)
        axes.plot(*point, **DOT)
    signs = []
    for k, sensor in enumerate(placement.today):
        signs.append((to_plane(sensor.position, plane), SIGNS["sensor"], letter(k)))
    for k, sensor in enumerate(placement.places, start=1):
        signs.append((to_plane(sensor.position, plane), STAR, str(k)))
    for point, style, _ in signs:
        labels.keep_free(point, 0.07)
        axes.plot(*point, **style)
    for point, _, text in signs:
        labels.place(point, text, gap=0.08)


def _heading(placement: PlaceStudy) -> tuple[str, str, str]:
    """The title, the landings, and the joint model."""
    body = printable(placement.robot.bodies[placement.body].name, 30)
    postures = {posture_text(profile) for profile in placement.profiles}
    posture = postures.pop() if len(postures) == 1 else "differs"
    models = {joint_model_text(profile) for profile in placement.profiles}
    model = models.pop() if len(models) == 1 else "differs"
    landings = (
        f"{count(len(placement.landings), 'landing')}; posture {posture}; {placement.region.text}"
    )
    return (
        f"{robot_name(placement.robot)}: place of minimum shock on {body}",
        printable(landings),
        f"joint model: {model}",
    )


def _rows(placement: PlaceStudy) -> TableRows:
    """Sensors and places: position in the body's frame and shock."""
    rows: TableRows = [("", "place", "x", "y", "z [m]", "shock [-]")]
    signs = [
        *map(letter, range(len(placement.today))),
        *map(str, range(1, len(placement.places) + 1)),
    ]
    for mark, sensor in zip(signs, (*placement.today, *placement.places), strict=True):
        position = [short(x, 3) for x in sensor.position]
        rows.append((mark, cut(sensor.name, 18), *position, f"{sensor.combined:.3g}"))
    return rows


def _notes(placement: PlaceStudy, near: int) -> list[str]:
    """Notes on what the views cannot show.

    Args:
        placement: the result.
        near: number of CoPcs in the views.
    """
    landings = len(placement.profiles)
    translating = sum(bool(profile.translates[placement.body]) for profile in placement.profiles)
    far = landings - near - translating
    notes = []
    if far:
        notes.append(f"CoPc of {far} of {count(landings, 'landing')} outside the views")
    if translating:
        notes.append(
            f"no CoPc in {count(translating, 'landing')}, in which the body does not rotate in the "
            f"plane"
        )
    if placement.failures:
        notes.append(f"{count(len(placement.failures), 'landing')} could not be computed")
    return notes
