"""The figure of a placement: the greatest shock over a body in three views, with present sensors, places found and CoPcs."""

import itertools
import textwrap
from typing import Any, NamedTuple

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from shockpc.core.spatial import Array, Plane
from shockpc.printed import printable
from shockpc.show.figure.bodies import paint
from shockpc.show.figure.canvas import add_axes, new_page
from shockpc.show.figure.labels import Labels
from shockpc.show.figure.marks import SIGNS, letter
from shockpc.show.figure.page import LINE, colour_bar, coordinates, legend, remarks, table, title
from shockpc.show.figure.palette import BANDS, INK, PAPER
from shockpc.show.figure.silhouette import Region, contoured, silhouette, to_plane
from shockpc.show.figure.view import body_shapes
from shockpc.show.figure.window import Window
from shockpc.show.header import count, joint_model_text, posture_text
from shockpc.studies.place.cone import Cell
from shockpc.studies.place.study import PlaceStudy, SensorPlace

__all__ = ["draw_place"]

ROOM = 6.6
"""Largest width and height of the views together [inches]."""

MARGIN, LEFT, HEAD, FOOT, GAP, COLUMN, PAD = 0.2, 0.62, 0.95, 1.05, 0.28, 3.5, 0.2
"""Room around everything, for the vertical coordinate, the title, the colour bar, between views, for the column beside them, and
around the body in each view [inches]."""

NEAR = 0.3
"""Distance of a CoPc from the body, as a share of its size, up to which it is in the views."""

CELLS = 160
"""Cells along the longer side of the grid on which shock is contoured."""

_MARK: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.7}
STAR = _MARK | {"marker": "*", "markersize": 9.0, "markerfacecolor": "#ffd24d", "zorder": 7.5}
DOT = _MARK | {"marker": "o", "markersize": 3.2, "markerfacecolor": PAPER, "zorder": 6}

DASHED = (0, (4, 2))
"""Line style of the region in which a sensor may be."""


class _View(NamedTuple):
    """One view of the body along an axis of its frame."""

    name: str
    axes: tuple[int, int]
    depth: int

    @property
    def plane(self) -> Plane:
        """The plane of the view in the body's frame."""
        e1, e2 = np.eye(3)[list(self.axes)]
        return Plane(np.cross(e1, e2), e1, e2)


SIDE, TOP, FRONT = _View("side", (0, 2), 1), _View("top", (0, 1), 2), _View("front", (1, 2), 0)


def draw_place(study: PlaceStudy) -> Figure:
    """Draw the body in its own frame, from the side, from above and from the front.

    The colours are what places are compared by, in the plane through the best place.

    Args:
        study: where a sensor sees least shock.
    """
    shapes, _ = body_shapes(study.robot)[study.body]
    marks = np.array([one.position for one in (*study.today, *study.places)])
    if study.region.solid:
        marks = np.concatenate([marks, *(cell.points + s * cell.radius for cell in study.region.cells for s in (-1.0, 1.0))])
    solid = np.concatenate([shape.points + s * shape.radius for shape in shapes for s in (-1.0, 1.0)]) if shapes else marks
    low, high = np.minimum(solid.min(axis=0), marks.min(axis=0)), np.maximum(solid.max(axis=0), marks.max(axis=0))
    size = float((high - low).max())
    copc = np.array([profile.copc[study.body] for profile in study.profiles])
    copc = copc[np.all((copc > low - NEAR * size) & (copc < high + NEAR * size), axis=1)]
    low, high = np.minimum(low, copc.min(axis=0, initial=np.inf)), np.maximum(high, copc.max(axis=0, initial=-np.inf))
    extent = np.maximum(high - low, 0.05 * size)
    inch = max(extent[0] + extent[1], extent[2] + extent[1]) / (ROOM - GAP - 4.0 * PAD)
    sides = extent / inch + 2.0 * PAD
    rows, notes = _rows(study), _notes(study, len(copc))
    across = sides[0] + GAP + sides[1]
    tall = max(sides[2] + GAP + sides[1], LINE * (len(rows) + len(notes) + 6.0) - FOOT + 0.3)
    x, y = LEFT + across + 2.0 * MARGIN, FOOT + tall
    figure, page = new_page(x + COLUMN + MARGIN, y + HEAD)
    levels, colours = _scale(study, low, high, solid)
    up = y - sides[2] - GAP - sides[1]
    places = {SIDE: (LEFT, up), TOP: (LEFT, up + sides[2] + GAP), FRONT: (LEFT + sides[0] + GAP, up)}
    for view, (left, bottom) in places.items():
        pair = list(view.axes)
        middle, half = (low + high)[pair] / 2.0, sides[pair] * inch / 2.0
        window = Window(middle - half, middle + half, inch)
        axes = add_axes(figure, left, bottom, *sides[pair])
        coordinates(axes, window, ["xyz"[k] for k in pair], left=view is not FRONT, bottom=view is not TOP, apart=0.4)
        region = silhouette(shapes, np.eye(3), np.zeros(3), view.plane, 1e-3 * float((2.0 * half).max())) if shapes else None
        _paint_view(axes, study, view, window, region or shapely.Polygon(), dict(zip(colours, levels, strict=False)))
        _mark_view(axes, study, view, window, region or shapely.Polygon(), copc)
    title(page, MARGIN, y + HEAD - 0.14, _title(study), x + COLUMN - MARGIN)
    number = "greatest normalised shock over the landings" if study.weights is None else "weighted mean of the normalised shock"
    text = f"{number} |Δv| / v_in [-], in the plane through place 1"
    labels = [f"{round(float(level), 12):g}" for level in levels]
    colour_bar(figure, (LEFT, up - 0.57, across), levels.tolist(), colours, labels, text)
    y = remarks(page, x, table(page, x, y, (0.0, 0.25, 1.75, 2.2, 2.65, COLUMN), rows), notes)
    signs = {"place found": STAR} | ({"present sensor or point": SIGNS["sensor"]} if study.today else {})
    signs |= {"CoPc of a landing": DOT} if len(copc) else {}
    signs |= {"where a sensor may be": {"color": INK, "linewidth": 0.6, "linestyle": DASHED}} if study.region.solid else {}
    legend(page, [Line2D([], [], **style) for style in signs.values()], list(signs), (x, y - LINE))
    return figure


def _paint_view(axes: Axes, study: PlaceStudy, view: _View, window: Window, region: Region, levels: dict[str, float]) -> None:
    """Paint the silhouette with its shock, and the region where a sensor may be. Args: levels, the lower one of each colour."""
    size = float((window.high - window.low).max())
    for colour, part in _bands(study, view, window, region, levels):
        paint(axes, part, size, facecolor=colour, edgecolor="none", zorder=1.0)
    paint(axes, region, size, facecolor="none", edgecolor=INK, linewidth=0.7, zorder=2.0)
    if study.region.solid:
        allowed = shapely.union_all([_projected(cell, view.plane) for cell in study.region.cells])
        paint(axes, allowed, size, facecolor="none", edgecolor=INK, linewidth=0.6, linestyle=DASHED, zorder=3.0)


def _mark_view(axes: Axes, study: PlaceStudy, view: _View, window: Window, region: Region, copc: Array) -> None:
    """Mark CoPcs (n, 3), today's sensors and the places found, with labels."""
    labels = Labels(axes, window, region)
    for place in (dots := to_plane(copc, view.plane)):
        labels.keep_free(place, 0.03)
    axes.plot(*dots.T, **DOT)
    signs = [(to_plane(one.position, view.plane), SIGNS["sensor"], letter(k)) for k, one in enumerate(study.today)]
    signs += [(to_plane(one.position, view.plane), STAR, str(k)) for k, one in enumerate(study.places, start=1)]
    for place, _, _ in signs:
        labels.keep_free(place, 0.07)
    for place, sign, text in signs:
        axes.plot(*place, **sign)
        labels.place(place, text, gap=0.08)
    axes.text(0.02, 0.98, view.name, fontstyle="italic", va="top", transform=axes.transAxes)


def _projected(cell: Cell, plane: Plane) -> Region:
    """The projection of a convex set."""
    hull = shapely.MultiPoint(to_plane(cell.points, plane)).convex_hull
    return hull.buffer(cell.radius) if cell.radius > 0.0 else hull


def _bands(study: PlaceStudy, view: _View, window: Window, region: Region, levels: dict[str, float]) -> list[tuple[str, Region]]:
    """The parts of a silhouette between two levels, with their colours; in the plane through the best place."""
    if region.is_empty:
        return []
    n = np.maximum(np.ceil(CELLS * (window.high - window.low) / (window.high - window.low).max()).astype(int), 2)
    x, y = (np.linspace(window.low[k], window.high[k], n[k] + 1) for k in (0, 1))
    points = np.empty((len(y), len(x), 3))
    points[..., view.axes[0]], points[..., view.axes[1]] = np.meshgrid(x, y)
    points[..., view.depth] = study.places[0].position[view.depth]
    values = study.fields.at(points.reshape(-1, 3)).reshape(len(y), len(x))
    # The least and the last level are open.
    edges = [-1.0, *list(levels.values())[1:], 1e30]
    parts = (contoured(x, y, values, low, high) for low, high in itertools.pairwise(edges))
    return [(colour, shapely.intersection(part, region)) for colour, part in zip(levels, parts, strict=True)]


def _scale(study: PlaceStudy, low: Array, high: Array, corners: Array) -> tuple[Array, list[str]]:
    """Round levels from the least to the greatest shock over the body, and a colour for each step, darker for more.

    Args:
        study: where a sensor sees least shock.
        low: (3,) lower corner of what is drawn [m].
        high: (3,) upper corner [m].
        corners: (n, 3) of the body, where shock is greatest [m].
    """
    grid = np.stack(np.meshgrid(*(np.linspace(low[k], high[k], 16) for k in range(3))), axis=-1).reshape(-1, 3)
    least = min(float(study.fields.at(grid).min()), *(one.combined for one in study.places))
    most = float(study.fields.at(corners).max())
    levels = np.asarray(MaxNLocator(nbins=9, steps=[1, 2, 2.5, 5, 10]).tick_values(least, max(most, least + 1e-9)))
    levels = np.unique(np.maximum(levels, 0.0))
    ramp = LinearSegmentedColormap.from_list("shock", [*BANDS[:5], "#3a6ea8", "#23406e"])
    return levels, [to_hex(ramp(t)) for t in np.linspace(0.0, 1.0, len(levels) - 1)]


def _title(study: PlaceStudy) -> tuple[str, str, str]:
    """Robot and body; landings; joint model."""
    robot = printable(study.robot.source.name or study.robot.name, 40)
    body = printable(study.robot.bodies[study.body].name, 30)
    what = "place" if study.count == 1 else f"places of {study.count} sensors"
    postures = {posture_text(profile) for profile in study.profiles}
    models = {joint_model_text(profile) for profile in study.profiles}
    posture = postures.pop() if len(postures) == 1 else "differs"
    landings = f"{count(len(study.landings), 'landing')}; posture {posture}; {study.region.text}"
    model = models.pop() if len(models) == 1 else "differs"
    return f"{robot}: {what} of least shock on {body}", printable(landings), f"joint model: {model}"


def _rows(study: PlaceStudy) -> list[tuple[str, ...]]:
    """Sensors and places: position in the body's frame and shock."""
    head = "greatest [-]" if study.weights is None else "mean [-]"
    rows: list[tuple[str, ...]] = [("", "place", "x", "y", "z [m]", head)]

    def row(mark: str, one: SensorPlace) -> tuple[str, ...]:
        x, y, z = (f"{round(float(value), 3) + 0.0:.3f}".replace("-", "−") for value in one.position)
        return mark, printable(one.name, 14), x, y, z, f"{one.combined:.3g}"

    rows += [row(letter(k), one) for k, one in enumerate(study.today)]
    rows += [row(str(k + 1), one) for k, one in enumerate(study.places)]
    if study.count > 1:
        rows.append(("", "the better one" if study.count == 2 else "the best one", "", "", "", f"{study.combined:.3g}"))
    return rows


def _notes(study: PlaceStudy, near: int) -> list[str]:
    """What the views cannot show; lines of text."""
    notes = []
    translating = sum(bool(profile.translates[study.body]) for profile in study.profiles)
    far = len(study.profiles) - near - translating
    if far:
        notes.append(f"CoPc of {far} of {count(len(study.profiles), 'landing')} outside the views")
    if translating:
        notes.append(f"no CoPc in {count(translating, 'landing')}, in which the body does not rotate in the plane")
    if study.failures:
        notes.append(f"{count(len(study.failures), 'landing')} could not be computed")
    return [part for note in notes for part in textwrap.wrap(note, 58)]
