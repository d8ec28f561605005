"""Draw the bodies: silhouettes filled with bands of shock, a line where shock is 1, and the edge."""

from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from shockpc.show.figure.field import Field, below
from shockpc.show.figure.palette import BANDS, EDGES, INK, PAPER, faded
from shockpc.show.figure.silhouette import Region
from shockpc.show.figure.view import Drawn, View

__all__ = ["BOXED", "draw_bodies", "layers"]

BOXED = (0, (4, 1.5, 1, 1.5))
"""Line around a body that is only the box of its inertia."""


def layers(region: Region, field: Field) -> list[tuple[int, Region]]:
    """What to paint over what, so that the part of a silhouette that stays visible of band k has shock in that band.

    Args:
        region: silhouette in plane coordinates [m].
        field: shock over the plane.

    Returns: bands, highest first, each with the part of the silhouette where shock is at most the band's upper edge.
    """
    if region.is_empty:
        return []
    x0, y0, x1, y1 = region.bounds
    slack = 0.01 * max(x1 - x0, y1 - y0)
    box = (x0 - slack, y0 - slack, x1 + slack, y1 + slack)
    found: list[tuple[int, Region]] = []
    for k, upper in enumerate(EDGES[1:]):
        part = shapely.intersection(region, below(field, upper, box))
        if part.area > 0.0:
            found.append((k, part))
        if part.area >= region.area * (1.0 - 1e-12):
            break
    return found[::-1]


def draw_bodies(axes: Axes, view: View) -> None:
    """Paint every body, farthest first.

    Args:
        axes: in plane coordinates [m].
        view: the bodies.
    """
    for order, drawn in enumerate(view.drawn):
        z = 1.0 + 0.01 * order
        fade = 0.35 if drawn.far or drawn.glass else 0.0
        if not drawn.glass:
            for k, part in layers(drawn.region, drawn.field):
                _patch(axes, part, view.size, facecolor=faded(BANDS[k], 0.6 * fade), edgecolor="none", zorder=z)
            _unit_line(axes, drawn, view.size, z)
        _patch(
            axes,
            drawn.region,
            view.size,
            facecolor="none",
            edgecolor=faded(INK, fade),
            linewidth=0.5 if fade else 0.7,
            linestyle=BOXED if drawn.box else "solid",
            zorder=z,
        )


def _unit_line(axes: Axes, drawn: Drawn, size: float, zorder: float) -> None:
    """The line inside a silhouette along which shock equals the strike."""
    if drawn.region.is_empty:
        return
    x0, y0, x1, y1 = drawn.region.bounds
    slack = 0.05 * max(x1 - x0, y1 - y0)
    limit = below(drawn.field, 1.0, (x0 - slack, y0 - slack, x1 + slack, y1 + slack))
    line = shapely.intersection(limit.boundary, drawn.region)
    for part in shapely.get_parts(shapely.line_merge(line) if line.geom_type == "MultiLineString" else line):
        if part.geom_type == "LineString" and not part.is_empty:
            x, y = np.asarray(part.simplify(size / 4000.0).coords).T
            axes.plot(x, y, color=PAPER, linewidth=1.1, zorder=zorder, solid_capstyle="butt")


def _patch(axes: Axes, region: Region, size: float, **style: Any) -> None:
    """Draw a region as one path, with no more corners than can be seen in a picture of that size [m]."""
    vertices, codes = [], []
    for part in shapely.get_parts(shapely.simplify(region, size / 4000.0)):
        if part.geom_type != "Polygon" or part.is_empty:
            continue
        for ring in (part.exterior, *part.interiors):
            corners = np.asarray(ring.coords)
            vertices.append(corners)
            codes += [Path.MOVETO, *[Path.LINETO] * (len(corners) - 2), Path.CLOSEPOLY]
    if vertices:
        axes.add_patch(PathPatch(Path(np.concatenate(vertices), codes), joinstyle="round", **style))
