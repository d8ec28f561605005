"""Read the triangles of a COLLADA (.dae) or a Wavefront (.obj) file, and nothing else of it.

These are the two formats that keep a mesh in several parts; coal 3.0 mixes the parts' vertices up. Units are honoured as RViz
does, and as there and in Pinocchio the up axis is not: a link's mesh is modelled in the axes of the link.
"""

import math
import warnings
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.robot.files import parse_xml

__all__ = ["Triangles", "read_collada", "read_wavefront"]

Triangles = tuple[Array, NDArray[np.int64]]
"""Vertices (n, 3) and, for each triangle, three indices into them (m, 3)."""

DEEPEST = 64
"""Most levels of nodes in a scene; more than a drawing program writes, and an end to a scene that holds itself."""


def read_collada(path: Path) -> Triangles:
    """All triangles of a COLLADA scene, in metres. Polygons are cut into fans.

    Raises:
        ValueError: it is not COLLADA, or broken; one line.
    """
    try:
        root = parse_xml(path.read_text(encoding="utf-8-sig"), path.name)
    except (RobotError, UnicodeDecodeError) as refusal:
        raise ValueError(str(refusal)) from None
    for element in root.iter():
        element.tag = element.tag.rsplit("}", 1)[-1]
    if root.tag != "COLLADA":
        raise ValueError(f"it begins with <{root.tag}>, not with <COLLADA>")
    named = {f"#{element.get('id')}": element for element in root.iter() if element.get("id")}
    geometries = {url: _geometry(element, named) for url, element in named.items() if element.tag == "geometry"}
    unit = root.find("asset/unit")
    scale = float(unit.get("meter", "1")) if unit is not None else 1.0
    vertices, triangles, count = [], [], 0
    for transform, url in _instances(root, named):
        for points, corners in geometries.get(url, ()):
            vertices.append((points @ transform[:3, :3].T + transform[:3, 3]) * scale)
            triangles.append(corners + count)
            count += len(points)
    if not triangles:
        raise ValueError("its scene holds no triangles")
    return np.concatenate(vertices), np.concatenate(triangles)


def _instances(root: Element, named: dict[str, Element]) -> list[tuple[Array, str]]:
    """Every geometry that the scene shows, by its url, with the 4×4 that places it."""
    shown = root.find("scene/instance_visual_scene")
    scene = named.get(shown.get("url", "")) if shown is not None else root.find("library_visual_scenes/visual_scene")
    found: list[tuple[Array, str]] = []
    waiting = [(node, np.eye(4), 0) for node in (scene.findall("node") if scene is not None else ())][::-1]
    while waiting:
        node, outer, depth = waiting.pop()
        if depth > DEEPEST:
            raise ValueError(f"its nodes are nested more than {DEEPEST} deep")
        inner = outer
        for step in node:
            inner = inner @ _step(step)
        found += [(inner, instance.get("url", "")) for instance in node.findall("instance_geometry")]
        again = [named[i.get("url", "")] for i in node.findall("instance_node") if i.get("url", "") in named]
        waiting += [(child, inner, depth + 1) for child in [*node.findall("node"), *again]][::-1]
    return found


def _step(element: Element) -> Array:
    """The 4×4 of one step of a node's placement; the identity for what places nothing."""
    out = np.eye(4)
    if element.tag == "matrix":
        out[:] = _numbers(element, 16).reshape(4, 4)
    elif element.tag == "translate":
        out[:3, 3] = _numbers(element, 3)
    elif element.tag == "scale":
        out[[0, 1, 2], [0, 1, 2]] = _numbers(element, 3)
    elif element.tag == "rotate":
        x, y, z, degrees = _numbers(element, 4)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) / (math.sqrt(x * x + y * y + z * z) or 1.0)
        angle = math.radians(degrees)
        out[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return out


def _geometry(geometry: Element, named: dict[str, Element]) -> list[Triangles]:
    """The triangles of a <geometry>, one entry for each of its parts."""
    parts: list[Triangles] = []
    for part in geometry.iterfind("mesh/*"):
        if part.tag not in ("triangles", "polylist", "polygons", "trifans", "tristrips"):
            continue
        inputs = {item.get("semantic"): item for item in part.findall("input")}
        if "VERTEX" not in inputs:
            raise ValueError(f"<{part.tag}> without vertices")
        stride = max(int(item.get("offset", "0")) for item in part.findall("input")) + 1
        offset = int(inputs["VERTEX"].get("offset", "0"))
        runs = [_numbers(p).astype(np.int64).reshape(-1, stride)[:, offset] for p in part.findall("p")]
        if part.tag == "polylist" and runs:
            counts = part.find("vcount")
            ends = np.cumsum(_numbers(counts).astype(np.int64)) if counts is not None else np.empty(0, np.int64)
            runs = np.split(runs[0], ends[:-1])
        if part.tag == "triangles":
            corners = [run.reshape(-1, 3) for run in runs]
        elif part.tag == "tristrips":
            corners = [np.stack([run[:-2], run[1:-1], run[2:]], axis=1) for run in runs]
        else:
            corners = [_fan(run) for run in runs]
        if corners:
            parts.append(_checked(_positions(inputs["VERTEX"], named), np.concatenate(corners)))
    return parts


def _positions(vertex: Element, named: dict[str, Element]) -> Array:
    """The points (n, 3) that a VERTEX input leads to."""
    vertices = named.get(vertex.get("source", ""))
    position = None if vertices is None else vertices.find("input[@semantic='POSITION']")
    source = named.get(position.get("source", "")) if position is not None else None
    values = source.find("float_array") if source is not None else None
    if source is None or values is None:
        raise ValueError("vertices without positions")
    accessor = source.find("technique_common/accessor")
    stride = int(accessor.get("stride", "3")) if accessor is not None else 3
    return _numbers(values).reshape(-1, stride)[:, :3]


def _numbers(element: Element, count: int | None = None) -> Array:
    """The numbers in an element's text."""
    with warnings.catch_warnings():
        # How numpy tells of text that is no number.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            values = np.fromstring(element.text or "", sep=" ")
        except DeprecationWarning:
            raise ValueError(f"<{element.tag}> holds what is no number") from None
    if count is not None and len(values) != count:
        raise ValueError(f"<{element.tag}> holds {len(values)} numbers, not {count}")
    return values


def read_wavefront(path: Path) -> Triangles:
    """All triangles of a Wavefront file, in its own unit, which is taken for metres. Polygons are cut into fans.

    Raises:
        ValueError: it is broken; one line.
    """
    points: list[list[float]] = []
    triangles = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if words and words[0] == "v":
            points.append([float(word) for word in words[1:4]])
        elif words and words[0] == "f":
            corners = np.array([int(word.split("/")[0]) for word in words[1:]])
            triangles.append(_fan(np.where(corners > 0, corners - 1, corners + len(points))))
    if not triangles or any(len(point) != 3 for point in points):
        raise ValueError("it holds no triangles, or a vertex without three coordinates")
    return _checked(np.array(points), np.concatenate(triangles))


def _fan(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """A polygon (k,) as k − 2 triangles (k − 2, 3) around its first corner."""
    return np.stack([np.repeat(corners[:1], max(len(corners) - 2, 0)), corners[1:-1], corners[2:]], axis=1)


def _checked(vertices: Array, triangles: NDArray[np.int64]) -> Triangles:
    """Vertices and triangles that fit each other. Raises ValueError if they do not."""
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(vertices)):
        raise ValueError("a triangle names a vertex that is not there")
    return vertices, triangles
