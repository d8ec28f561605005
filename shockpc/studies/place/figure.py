"""The figure of a placement: the largest shock over a body in three views, with present sensors,
places found and CoPcs.
"""

import math
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shockpc.core.spatial import Array, Plane
from shockpc.robot.shapes import Shape
from shockpc.show.figure.labels import Labels
from shockpc.show.figure.layout import LEFT, Page, TableRows, column_height, cut, short
from shockpc.show.figure.picture import GOLD, SIGNS, letter, outlined, sign
from shockpc.show.figure.silhouette import Edges, projection, silhouette, surface, to_plane
from shockpc.show.figure.style import INK, shock_levels
from shockpc.show.figure.view import Window, body_shapes
from shockpc.show.header import joint_model_text, posture_text
from shockpc.show.wording import count, robot_name
from shockpc.studies.place.study import PlaceStudy
from shockpc.text.printed import printable

ROOM, FOOT, GAP, PAD = 6.6, 0.85, 0.28, 0.2
"""Largest width and height of the views together, room for coordinates and the colour bar, between
views, and around the body in
each view [inches]."""

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


def draw_place(study: PlaceStudy) -> Figure:
    """Draw the body in its frame, from the side, from above and from the front.

    The colours are what places are compared by, in the plane through the best place.
    """
    shapes, _ = body_shapes(study.robot)[study.body]
    cells = [
        Shape("", cell.points, cell.rounding) for cell in study.region.cells if study.region.solid
    ]
    marks = np.array([place.position for place in (*study.today, *study.places)])
    marks = np.concatenate([marks, surface(cells)]) if cells else marks
    solid = surface(shapes) if shapes else marks
    points = np.concatenate([solid, marks])
    near = NEARBY_SHARE * max(float(np.ptp(points, axis=0).max()), 1e-6)
    copc = np.array([profile.copc[study.body] for profile in study.profiles])
    copc = copc[
        np.all((copc > points.min(axis=0) - near) & (copc < points.max(axis=0) + near), axis=1)
    ]
    points = np.concatenate([points, copc])
    low, high = points.min(axis=0), np.maximum(points.max(axis=0), points.min(axis=0) + 0.15 * near)
    extent = high - low
    inch = float(max(extent[0] + extent[1], extent[2] + extent[1])) / (ROOM - GAP - 4.0 * PAD)
    low, high = low - PAD * inch, high + PAD * inch
    width, depth, height = (high - low) / inch
    tables, notes = [_rows(study)], _notes(study, len(copc))
    # Above the front view, if there is room.
    column = (
        LEFT + width + 2.0 * GAP if column_height(tables, notes, signs=4) < depth + GAP else None
    )
    page = Page(
        LEFT + width + GAP + depth,
        FOOT + height + GAP + depth,
        _heading(study),
        tables,
        notes,
        column,
    )
    views, seen, edges = [], [study.fields.at(marks)], dict[int, Edges]()
    lines = np.linspace(low, high, CELLS + 1)
    for pair in VIEWS.values():
        e1, e2 = np.eye(3)[list(pair)]
        plane = Plane(np.cross(e1, e2), e1, e2)
        region = silhouette(shapes, plane, inch * ROOM / 4000.0, edges)
        coordinates = [
            lines[:, k] if k in pair else study.places[0].position[k : k + 1] for k in range(3)
        ]
        points = np.stack(np.meshgrid(*coordinates, indexing="ij"), axis=-1).reshape(-1, 3)
        values = study.fields.at(points)
        seen.append(
            values[shapely.contains_xy(region, *to_plane(points, plane).T)] if shapes else values
        )
        views.append((plane, region, values.reshape(CELLS + 1, CELLS + 1).T))
    shocks = np.concatenate(seen)
    levels, colours = shock_levels(float(shocks.min()), float(shocks.max()))
    places = (LEFT, 0.0), (LEFT, height + GAP), (LEFT + width + GAP, 0.0)
    for (name, pair), (x, y), (plane, region, values) in zip(
        VIEWS.items(), places, views, strict=True
    ):
        i, j = pair
        window = Window(low[[i, j]], high[[i, j]], inch)
        axes = page.picture(
            x,
            page.low + FOOT + y,
            window,
            "xyz"[i] + "xyz"[j],
            left=name != "front",
            bottom=name != "top",
        )
        if not region.is_empty:
            edge = outlined(
                axes, region, inch * ROOM / 4000.0, edgecolor=INK, linewidth=0.7, zorder=2.0
            )
            # The last of all bands has no end, beyond which matplotlib cannot extend.
            extend: Any = "min" if math.isinf(levels[-1]) else "both"
            sides, shades = (
                (low[i], high[i], low[j], high[j]),
                [colours[0], *colours, *colours[-1:] * (extend == "both")],
            )
            filled = axes.contourf(
                values, levels=levels, colors=shades, extend=extend, extent=sides, zorder=1.0
            )
            # Edges of the same colour close the gaps that anti-aliasing leaves between neighbours.
            filled.set(edgecolor="face", linewidth=0.3, clip_path=edge)
        hulls = [projection(cell, plane) for cell in cells]
        if hulls:
            style: dict[str, Any] = {
                "edgecolor": INK,
                "linewidth": 0.6,
                "linestyle": (0, (4, 2)),
                "zorder": 3.0,
            }
            outlined(
                axes,
                shapely.union_all(hulls),
                inch * ROOM / 4000.0,
                label="where a sensor may be",
                **style,
            )
        _mark(axes, study, plane, Labels(axes, window, region), copc)
        axes.text(0.02, 0.98, name, fontstyle="italic", va="top", transform=axes.transAxes)
    number = (
        "maximum normalised shock over the landings"
        if study.weights is None
        else "weighted mean of the normalised shock"
    )
    page.bar(
        LEFT,
        width + GAP + depth,
        levels,
        colours,
        f"{number} |Δv| / v_in [-], in the plane through place 1",
    )
    page.key()
    return page.figure


def _mark(axes: Axes, study: PlaceStudy, plane: Plane, labels: Labels, copc: Array) -> None:
    """Mark CoPcs (n, 3), today's sensors and the places found, with labels."""
    for place in to_plane(copc, plane):
        labels.keep_free(place, 0.03)
        axes.plot(*place, **DOT)
    signs = [
        (to_plane(place.position, plane), SIGNS["sensor"], letter(k))
        for k, place in enumerate(study.today)
    ]
    signs += [
        (to_plane(place.position, plane), STAR, str(k))
        for k, place in enumerate(study.places, start=1)
    ]
    for place, look, _ in signs:
        labels.keep_free(place, 0.07)
        axes.plot(*place, **look)
    for place, _, text in signs:
        labels.place(place, text, gap=0.08)


def _heading(study: PlaceStudy) -> tuple[str, str, str]:
    robot = robot_name(study.robot)
    body = printable(study.robot.bodies[study.body].name, 30)
    what = "place" if study.count == 1 else f"places of {study.count} sensors"
    texts = [
        {text(profile) for profile in study.profiles} for text in (posture_text, joint_model_text)
    ]
    posture, model = (shared.pop() if len(shared) == 1 else "differs" for shared in texts)
    landings = f"{count(len(study.landings), 'landing')}; posture {posture}; {study.region.text}"
    return (
        f"{robot}: {what} of minimum shock on {body}",
        printable(landings),
        f"joint model: {model}",
    )


def _rows(study: PlaceStudy) -> TableRows:
    """Sensors and places: position in the body's frame and shock."""
    rows: TableRows = [("", "place", "x", "y", "z [m]", "shock [-]")]
    signs = [*map(letter, range(len(study.today))), *map(str, range(1, len(study.places) + 1))]
    for mark, place in zip(signs, (*study.today, *study.places), strict=True):
        rows.append(
            (
                mark,
                cut(place.name, 18),
                *(short(x, 3) for x in place.position),
                f"{place.combined:.3g}",
            )
        )
    if study.count > 1:
        rows.append(
            (
                "",
                "the better one" if study.count == 2 else "the best one",
                "",
                "",
                "",
                f"{study.combined:.3g}",
            )
        )
    return rows


def _notes(study: PlaceStudy, near: int) -> list[str]:
    """What the views cannot show."""
    notes = []
    translating = sum(bool(profile.translates[study.body]) for profile in study.profiles)
    if far := len(study.profiles) - near - translating:
        notes.append(f"CoPc of {far} of {count(len(study.profiles), 'landing')} outside the views")
    if translating:
        notes.append(
            f"no CoPc in {count(translating, 'landing')}, in which the body does not rotate in the "
            f"plane"
        )
    if study.failures:
        notes.append(f"{count(len(study.failures), 'landing')} could not be computed")
    return notes
