"""Charts of a page as Plotly reads them: the picture of a landing, and histories.

The picture leaves out the places that follow the strike.
"""

import html
from collections.abc import Iterable
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.show.figure.picture import GOLD
from shockpc.show.figure.style import BANDS, CURVES, EDGES, INK
from shockpc.show.html.surfaces import Surface
from shockpc.text.printed import printable

LIMIT = 2.5
"""Shock at the end of the scale of colours; the last band is open."""

SCALE = [
    [edge / LIMIT, colour]
    for k, colour in enumerate(BANDS)
    for edge in (EDGES[k], min(EDGES[k + 1], LIMIT))
]

NARROWEST = 0.4
"""Smallest side of the box that is shown, as a share of its longest one."""

PLAIN = {"type": "scatter3d", "hoverinfo": "none"}

STYLES: tuple[dict[str, Any], ...] = (
    {
        "type": "mesh3d",
        "hoverinfo": "none",
        "flatshading": True,
        "cmin": 0,
        "cmax": LIMIT,
        "colorscale": SCALE,
        "showscale": False,
        # In the axes of the camera; what faces the viewer has the colours of the bands.
        "lighting": {
            "ambient": 0.62,
            "diffuse": 0.45,
            "specular": 0.02,
            "roughness": 0.9,
            "facenormalsepsilon": 0,
        },
        "lightposition": {"x": 2e4, "y": 1e5, "z": -1e4},
    },
    {**PLAIN, "mode": "lines", "line": {"color": INK, "width": 6}},
    {
        "type": "cone",
        "hoverinfo": "none",
        "anchor": "tip",
        "sizemode": "absolute",
        "showscale": False,
        "colorscale": [[0, INK], [1, INK]],
    },
    {**PLAIN, "mode": "lines", "line": {"color": GOLD, "width": 4}},
    {
        **PLAIN,
        "mode": "markers",
        "marker": {
            "symbol": "diamond",
            "size": 5,
            "color": GOLD,
            "line": {"color": INK, "width": 1},
        },
    },
    {**PLAIN, "mode": "text", "textfont": {"size": 15, "color": INK}},
    {
        **PLAIN,
        "mode": "markers+text",
        "textposition": "top center",
        "textfont": {"color": INK},
        "marker": {"symbol": "cross", "size": 5, "color": INK},
    },
    {**PLAIN, "mode": "lines", "line": {"color": CURVES[3], "width": 4}},
    {**PLAIN, "mode": "markers", "marker": {"size": 1, "opacity": 0}},
)
"""Styles of the parts of the picture.

They are bodies; the strike at each contact, and its arrow head; a line to each sensor, its mark and
letter; CoPc; screw axes; and ends of the box that is shown, which are not seen.
"""

CONFIG = {
    "responsive": True,
    "displaylogo": False,
    "modeBarButtonsToRemove": ["resetCameraLastSave3d"],
}


def picture(
    name: str, points: Array, contact: Array, axes: tuple[Array, Array, Array]
) -> dict[str, Any]:
    """Size and layout of the picture of a landing.

    It is seen from the side of a contact, at a distance that shows the whole robot.

    Args:
        name: of the landing.
        points: (n, 3) of the robot, world [m].
        contact: (3,) point that is struck, world [m].
        axes: normal, first and second axis (3,) of the plane.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    size = float((high - low).max()) or 1.0
    sides = np.maximum(high - low, NARROWEST * size)
    normal, e1, e2 = axes
    if (contact - middle) @ normal < 0.0:
        normal = -normal
    eye = normal + 0.6 * e1 + 0.35 * e2
    eye *= 0.74 * size / np.linalg.norm(eye) / np.cbrt(sides.prod())
    axis = {
        "backgroundcolor": "#fff",
        "gridcolor": "#ddd",
        "zerolinecolor": "#ccc",
        "showspikes": False,
    }
    camera = {"eye": _vector(eye), "up": _vector(e2), "projection": {"type": "orthographic"}}
    scene = {
        "aspectmode": "data",
        "camera": camera,
        **{f"{x}axis": {**axis, **_title(f"{x} [m]")} for x in "xyz"},
    }
    margin = dict.fromkeys("lrtb", 0)
    layout = {
        "scene": scene,
        "showlegend": False,
        "margin": margin,
        "uirevision": printable(name),
        "hovermode": "closest",
    }
    ends = [(middle + sign * sides / 2.0).tolist() for sign in (-1.0, 1.0)]
    return {
        "size": size,
        "ends": ends,
        "middle": middle.tolist(),
        "top": float(high[2]),
        "layout": layout,
    }


def placed(surfaces: Iterable[Surface], rotation: Array, position: Array) -> Array:
    """The vertices (n, 3) of the surfaces of bodies, and their origins, in the world."""
    parts = [
        part.vertices @ R.T + p for part, R, p in zip(surfaces, rotation, position, strict=False)
    ]
    return np.concatenate([position, *parts])


def history(title: str, times: Array, curves: Iterable[tuple[str, Array]]) -> dict[str, Any]:
    """A chart of curves (T,) by name over times (T,) [s].

    Names become texts that Plotly does not interpret.
    """
    milliseconds = (1e3 * times).tolist()
    drawn: list[dict[str, Any]] = []
    for name, curve in curves:
        text = html.escape(printable(name), quote=False).replace("$", "&#36;")
        drawn.append({"x": milliseconds, "y": curve.tolist(), "mode": "lines", "name": text})
    axes = {"xaxis": _title("time from the first contact [ms]"), "yaxis": _title(title)}
    margin = {"t": 16, "r": 16, "b": 44}
    return {
        "data": drawn,
        "layout": {**axes, "colorway": CURVES, "showlegend": True, "margin": margin, "height": 280},
    }


def _vector(v: Array) -> dict[str, float]:
    return dict(zip("xyz", v.tolist(), strict=True))


def _title(text: str) -> dict[str, Any]:
    return {"title": {"text": text}}
