"""Draw the bodies: silhouettes filled with the colours of their shock, and their edges."""

from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from shockpc.show.figure.field import Field, below
from shockpc.show.figure.palette import BANDS, EDGES, INK, faded
from shockpc.show.figure.silhouette import Region
from shockpc.show.figure.view import View

__all__ = ["BOXED", "draw_bodies", "layers", "paint"]

BOXED = (0, (4, 1.5, 1, 1.5))
"""Line style of a body that is drawn as the box of its inertia."""


def layers(region: Region, field: Field) -> list[tuple[int, Region]]:
    """Bands, highest first, each with the part of a silhouette [m] where shock is at most the band's upper limit.

    Painted one over the other, what stays visible of each part has a shock in its band.
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


def draw_bodies(axes: Axes, view: View) -> set[str]:
    """Paint every body, farthest first, on axes in plane coordinates [m]; return which signs of the key occur."""
    signs = set()
    for order, drawn in enumerate(view.drawn):
        fade = 0.35 if drawn.far or drawn.outlined else 0.0
        style: dict[str, Any] = {"zorder": 1.0 + 0.01 * order}
        if not drawn.outlined:
            for k, part in layers(drawn.region, drawn.field):
                paint(axes, part, view.size, facecolor=faded(BANDS[k], 0.6 * fade), edgecolor="none", **style)
        style |= {"linewidth": 0.5 if fade else 0.7, "linestyle": BOXED if drawn.box else "solid"}
        paint(axes, drawn.region, view.size, facecolor="none", edgecolor=faded(INK, fade), **style)
        signs |= {"outlined"} if drawn.outlined else set()
        signs |= {"box"} if drawn.box and not drawn.region.is_empty else set()
    return signs


def paint(axes: Axes, region: Region, size: float, **style: Any) -> None:
    """Draw a region as one path, with no more corners than can be seen in a figure of that size [m]."""
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
