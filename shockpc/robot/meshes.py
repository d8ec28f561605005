"""The bytes of a mesh file become triangles: STL, OBJ and PLY, read by trimesh, COLLADA, read by
pycollada, and MuJoCo's MSH.

The libraries are given bytes in memory and nothing by which to find another file, so materials and
textures are never opened.
"""

import functools
import io
import itertools
import re
import warnings
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.reading import decoded, parse_xml
from shockpc.text.paths import LARGEST_FILE

FORMATS = ("stl", "obj", "dae", "ply", "msh")
"""Suffixes of the files that are read."""

_NO_SHAPE = {
    *(
        f"library_{kind}"
        for kind in (
            "animations",
            "cameras",
            "controllers",
            "effects",
            "images",
            "lights",
            "materials",
        )
    ),
    *("bind_material", "instance_camera", "instance_controller", "instance_light", "extra"),
}
"""Elements of COLLADA on which no triangle depends; many files have broken references among them.
"""

_RELATIVE_FACE = rb"(?m)^f[^\n]*[ \t]-\d"
"""An OBJ face that counts its vertices backwards; trimesh counts from the end of the file, not from
the face.
"""

_LONGEST = 2 * LARGEST_FILE
"""Characters of a COLLADA scene in which every instance is written out."""

_INSTANCE = 1000
"""Characters that are read in the time that an instance takes by itself."""


FEW = 100
"""Vertices of which none is left out."""

_FLAT, _BENEATH = 1e-5, 1e-6
"""Six times the volume of a tetrahedron up to which it is left out, for points scaled to a cube;
depth below its outer face, as a
share of its height, from which a point counts as inside. Barycentric coordinates of 1e-11 are
rounding then."""


class Mesh(NamedTuple):
    """A surface that need not be convex, nor closed.

    Attributes:
        vertices: (n, 3) [m].
        triangles: (m, 3) indices into the vertices.
        y_up: whether it is from a COLLADA file that says that y is up.
    """

    vertices: Array
    triangles: np.ndarray
    y_up: bool = False


def read_mesh(data: bytes, suffix: str) -> Mesh:
    """The triangles of a mesh file; polygons are divided into triangles, vertices at the same place
    become one.

    The unit of a COLLADA document is applied. Its up axis is not: most meshes are modelled in the
    axes of the link, whatever the file says, and Pinocchio reads them so. COLLADA coordinates are
    held in single precision, as in STL files.

    Raises:
        ValueError: the format is not read, or the file is broken; one line.
    """
    if suffix not in FORMATS:
        raise ValueError(
            f"meshes are read from {', '.join(known.upper() for known in FORMATS)} files only"
        )
    y_up = False
    if suffix == "msh":
        vertices, triangles = _msh_shape(data)
    elif suffix == "stl" and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        vertices, triangles = _binary_stl(data)
    else:
        vertices, triangles, y_up = _by_library(data, suffix)
    if not len(triangles):
        raise ValueError("it holds no triangles")
    if not np.isfinite(vertices).all():
        raise ValueError("it has vertices that are not finite numbers")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ValueError("a triangle refers to a vertex that does not exist")
    distinct, index = _without_repeats(vertices)
    return Mesh(distinct, index[triangles], y_up)


def _binary_stl(data: bytes) -> tuple[Array, np.ndarray]:
    """The vertices and triangles of a binary STL file.

    trimesh reads these too; its import takes longer than an analysis of a robot whose meshes are
    all of this kind.
    """
    layout = [("normal", "<f4", 3), ("corners", "<f4", 9), ("attribute", "<u2")]
    corners = np.frombuffer(data, layout, offset=84)["corners"]
    vertices = corners.reshape(-1, 3).astype(float)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _without_repeats(vertices: Array) -> tuple[Array, np.ndarray]:
    """Distinct vertices (m, 3), and for each of the given ones (n, 3) which of them it is (n,).

    STL files repeat a vertex for every triangle.
    """
    # Adding zero turns −0 into 0, so that equal numbers are equal bytes.
    rows = np.ascontiguousarray(vertices + 0.0).view(">u8")
    # Sorted by lexsort, which is a hundred times as fast as numpy.unique of rows.
    order = np.lexsort(rows.astype("=u8").T[::-1])
    differs = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    new = np.append(True, differs)
    index = np.empty(len(rows), dtype=np.int64)
    index[order] = np.cumsum(new) - 1
    return vertices[order[new]], index


def _by_library(data: bytes, suffix: str) -> tuple[Array, np.ndarray, bool]:
    """Vertices, triangles, and whether the file says that y is up; ValueError if they cannot be
    read for whatever reason.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # NumPy's report of a word among numbers, a warning in its older versions.
            warnings.filterwarnings("error", "string or file could not be read to its end")
            if suffix == "dae":
                return _by_pycollada(data)
            if suffix == "obj" and re.search(_RELATIVE_FACE, data[: max(data.rfind(b"\nv "), 0)]):
                raise ValueError(
                    "a face with negative vertex numbers stands before other vertices; write "
                    "absolute numbers"
                )
            # Imported here, because it takes longer to import than an analysis without meshes takes
            # to run.
            from trimesh.exchange.load import mesh_loaders

            # The loader itself, because a `trimesh.Trimesh` made of its result may omit triangles
            # silently.
            return *_joined(
                mesh_loaders[suffix](io.BytesIO(data), file_type=suffix, skip_materials=True)
            ), False
    except Exception as refusal:  # of many kinds, and the robot is computed without the mesh
        kind = type(refusal).__name__
        # pycollada's messages begin with their class
        reason = " ".join(str(refusal).split()).removeprefix(f"{kind}: ") or kind
        raise ValueError(f"it is not a valid {suffix.upper()} file ({reason})") from None


def _by_pycollada(data: bytes) -> tuple[Array, np.ndarray, bool]:
    """The triangles of a COLLADA scene, each geometry at every place where a node instantiates it."""
    from collada import Collada
    from collada.polylist import Polylist
    from collada.scene import GeometryNode, Node
    from collada.triangleset import TriangleSet

    data, unit, y_up = _collada_shape(data)
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    nodes = [(node, np.eye(4)) for node in reversed(Collada(io.BytesIO(data)).scene.nodes)]
    while nodes:
        node, place = nodes.pop()
        if isinstance(node, Node):
            nodes += [(child, place @ node.matrix) for child in reversed(node.children)]
        for primitive in node.geometry.primitives if isinstance(node, GeometryNode) else ():
            part = primitive.triangleset() if isinstance(primitive, Polylist) else primitive
            if isinstance(part, TriangleSet) and part.vertex is not None:
                used, index = np.unique(part.vertex_index, return_inverse=True)
                vertices.append(part.vertex[used] @ place[:3, :3].T + place[:3, 3])
                triangles.append(index.reshape(-1, 3) + count)
                count += len(used)
    return np.concatenate(vertices) * unit, np.concatenate(triangles), y_up


def hull(points: Array) -> Any | None:
    """The convex hull of points (n, 3), of SciPy; None if it has no volume."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


def hull_corners(vertices: Array) -> Array:
    """Return those of the vertices (n, 3) that are corners of their hull; all if they lie in a
    plane, for then it has no volume.
    """
    convex = hull(vertices) if len(vertices) > 4 else None
    return vertices if convex is None else np.asarray(vertices[convex.vertices])


def outer_vertices(vertices: Array) -> Array:
    """The vertices (n, 3) without those that are clearly inside their hull, in their order.

    Every analysis evaluates the extremes over them. Some that are no corners remain: a vertex is
    left out where it is inside a tetrahedron of which three corners are the vertices that reach
    farthest in neighbouring directions, and the fourth is the mean of all such. The hull itself
    would need SciPy's module for it, which takes longer to import than most analyses.
    """
    with np.errstate(all="ignore"):
        size = np.ptp(vertices, axis=0)
        if len(vertices) <= FEW or not (size > 0.0).all():
            return vertices
        x = (vertices - vertices.mean(axis=0)) / size
        for level in (1, 2):
            outside = ~_inside(x, level)
            x, vertices = x[outside], vertices[outside]
    return vertices


def _inside(x: Array, level: int) -> np.ndarray:
    """Which points (n,) of x (n, 3) are inside one of the tetrahedra of `outer_vertices`."""
    directions, triangles = _directions(level)
    farthest = np.array([(x @ direction).argmax() for direction in directions])
    middle = x[sorted(set(farthest.tolist()))].mean(axis=0)
    edges = np.swapaxes(x[farthest[triangles]] - middle, -1, -2)
    solid = np.abs(np.linalg.det(edges)) > _FLAT
    inverse = np.linalg.inv(edges[solid])
    inside = []
    for part in np.split(x - middle, range(FEW, len(x), FEW)):
        # A point is Σ share_k edge_k from the middle; inside, all shares are positive, and their
        # sum is below 1.
        shares = (inverse.reshape(-1, 3) @ part.T).reshape(len(inverse), 3, len(part))
        positive = shares.min(axis=1) >= 0.0
        beneath = shares.sum(axis=1) < 1.0 - _BENEATH
        inside.append((positive & beneath).any(axis=0))
    return np.concatenate(inside)


@functools.cache
def _directions(level: int) -> tuple[Array, np.ndarray]:
    """Directions (n, 3), and the triangles (m, 3) of neighbours: those of an octahedron, each
    divided into four so many times.
    """
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
    triangles = signs[:, :, None] * np.eye(3)
    for _ in range(level):
        middles = triangles + triangles[:, [1, 2, 0]]
        middles /= np.linalg.norm(middles, axis=-1, keepdims=True)
        corners = []
        for k in range(3):
            corner = [triangles[:, k], middles[:, k], middles[:, k - 1]]
            corners.append(np.stack(corner, axis=1))
        triangles = np.concatenate([middles, *corners])
    points = [tuple(point) for point in (triangles.reshape(-1, 3) + 0.0).tolist()]
    directions = sorted(set(points))
    index = {point: n for n, point in enumerate(directions)}
    neighbours = np.array([index[point] for point in points])
    return np.array(directions), neighbours.reshape(-1, 3)


def _msh_shape(data: bytes) -> tuple[Array, np.ndarray]:
    """The vertices and triangles of MuJoCo's binary format: four counts, vertices, normals, texture
    coordinates, triangles.
    """
    counts = [int.from_bytes(data[k : k + 4], "little") for k in (0, 4, 8, 12)]
    vertices, normals, coordinates, triangles = counts
    if len(data) != 16 + 12 * (vertices + normals + triangles) + 8 * coordinates:
        raise ValueError(
            "it is not a valid MSH file (its length is not that which its first four numbers give)"
        )
    points = np.frombuffer(data, "<f4", 3 * vertices, 16)
    faces = np.frombuffer(data, "<i4", 3 * triangles, len(data) - 12 * triangles)
    return points.reshape(-1, 3).astype(float), faces.reshape(-1, 3).astype(np.int64)


def _collada_shape(data: bytes) -> tuple[bytes, float, bool]:
    """Reduce a COLLADA document to what its triangles depend on; with it, its unit [m], and whether
    it says that y is up.
    """
    root = parse_xml(decoded(data), "the file")
    if root.tag != "COLLADA":
        raise ValueError(f"it begins with <{root.tag}>, not with <COLLADA>")
    for element in root.iter():
        element[:] = [child for child in element if child.tag not in _NO_SHAPE]
    inputs = root.iterfind(".//vertices/input[@semantic='POSITION']")
    positions = {item.get("source", "")[1:] for item in inputs}
    for source in root.iter("source"):
        numbers = source.find("float_array")
        if numbers is None:
            continue
        if source.get("id") not in positions:
            numbers.text = ""  # normals and the like, half of the file
        elif "nan" in (numbers.text or "").lower():  # pycollada would make zeros of them
            raise ValueError("it has vertices that are not finite numbers")
    for item in root.iter("input"):
        if item.get("semantic") not in ("POSITION", "VERTEX"):
            item.set("semantic", "COLOR")  # whose indices count, and whose values are not looked at
    _refuse_growth(root)
    unit = root.find("asset/unit")
    metres = 1.0 if unit is None else float(unit.get("meter", "1"))
    y_up = root.findtext("asset/up_axis", "").strip() == "Y_UP"
    return ElementTree.tostring(root), metres, y_up


def _refuse_growth(root: ElementTree.Element) -> None:
    """Refuse a scene whose nodes instantiate one another so often that it would be too long if it
    were written out.
    """
    known = {}
    for element in root.iter():
        if element.tag in ("geometry", "node"):
            known[f"#{element.get('id')}"] = element

    @functools.cache
    def length(url: str) -> int:
        """Characters of a geometry, or of a node as `written_out`."""
        element = known.get(url)
        if element is None:
            return 0
        if element.tag == "geometry":
            return sum(map(len, element.itertext()))
        return written_out(element)

    def written_out(element: ElementTree.Element) -> int:
        """Characters of a node with what it and its children instantiate."""
        instances = [part.get("url", "") for part in element if part.tag.startswith("instance_")]
        return sum(_INSTANCE + length(url) for url in instances) + sum(map(written_out, element))

    characters = sum(map(written_out, root.iter("visual_scene")))
    if characters > _LONGEST:
        raise ValueError(
            f"with every instance written out it has {characters:.2g} characters, and up to "
            f"{_LONGEST:.2g} are read"
        )


def _joined(content: dict[str, Any]) -> tuple[Array, np.ndarray]:
    """Join the parts of a file, as trimesh's loaders return them."""
    from trimesh.geometry import triangulate_quads

    parts = content.get("geometry", {"": content})
    if "graph" in content:
        used = [parts[node["geometry"]] for node in content["graph"]]
    else:
        used = list(parts.values())
    vertices = [np.zeros((0, 3))]
    triangles = [np.zeros((0, 3), dtype=np.int64)]
    count = 0
    for part in used:
        vertices.append(np.asarray(part["vertices"], dtype=float) + 0.0)
        triangles.append(triangulate_quads(part["faces"]) + count)
        count += len(part["vertices"])
    return np.concatenate(vertices), np.concatenate(triangles)
