"""Triangles from the bytes of a mesh file.

STL, OBJ and PLY are read by trimesh, COLLADA by pycollada, and MuJoCo's MSH here.

The libraries are given bytes in memory and nothing by which to find another file, so materials and
textures are never opened.
"""

import functools
import io
import re
import warnings
from typing import Any
from xml.etree import ElementTree

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.files.reading import decoded, parse_xml
from shockpc.robot.shapes.mesh import Mesh
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


def read_mesh(data: bytes, suffix: str) -> Mesh:
    """The triangles of a mesh file.

    Polygons are divided into triangles, and vertices at the same place become one.

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
    ordered = rows[order]
    differs = (ordered[1:] != ordered[:-1]).any(axis=1)
    new = np.append(True, differs)
    index = np.empty(len(rows), dtype=np.int64)
    index[order] = np.cumsum(new) - 1
    return vertices[order[new]], index


def _by_library(data: bytes, suffix: str) -> tuple[Array, np.ndarray, bool]:
    """Vertices, triangles, and True if the file says that y is up.

    Raises:
        ValueError: they cannot be read for whatever reason.
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
    """The triangles of a COLLADA scene.

    Each geometry is at every place where a node instantiates it.
    """
    from collada import Collada
    from collada.polylist import Polylist
    from collada.scene import GeometryNode, Node
    from collada.triangleset import TriangleSet

    data, unit, y_up = _collada_shape(data)
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    nodes = [(node, np.eye(4)) for node in reversed(Collada(io.BytesIO(data)).scene.nodes)]
    while nodes:
        node, placement = nodes.pop()
        if isinstance(node, Node):
            nodes += [(child, placement @ node.matrix) for child in reversed(node.children)]
        for primitive in node.geometry.primitives if isinstance(node, GeometryNode) else ():
            part = primitive.triangleset() if isinstance(primitive, Polylist) else primitive
            if isinstance(part, TriangleSet) and part.vertex is not None:
                used, index = np.unique(part.vertex_index, return_inverse=True)
                vertices.append(part.vertex[used] @ placement[:3, :3].T + placement[:3, 3])
                triangles.append(index.reshape(-1, 3) + count)
                count += len(used)
    return np.concatenate(vertices) * unit, np.concatenate(triangles), y_up


def _msh_shape(data: bytes) -> tuple[Array, np.ndarray]:
    """The vertices and triangles of MuJoCo's binary format.

    The format has four counts, vertices, normals, texture coordinates, triangles.
    """
    counts = [int.from_bytes(data[k : k + 4], "little") for k in (0, 4, 8, 12)]
    vertices, normals, coordinates, triangles = counts
    length = 16 + 12 * (vertices + normals + triangles) + 8 * coordinates
    if len(data) != length:
        raise ValueError(
            "it is not a valid MSH file (its length does not match its first four numbers)"
        )
    points = np.frombuffer(data, "<f4", 3 * vertices, 16)
    faces = np.frombuffer(data, "<i4", 3 * triangles, len(data) - 12 * triangles)
    return points.reshape(-1, 3).astype(float), faces.reshape(-1, 3).astype(np.int64)


def _collada_shape(data: bytes) -> tuple[bytes, float, bool]:
    """Reduce a COLLADA document to what its triangles depend on.

    With it come its unit [m], and True if it says that y is up.
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
    """Refuse a scene whose nodes instantiate one another too often.

    Written out, it would be too long.
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
        instantiated = sum(_INSTANCE + length(url) for url in instances)
        return instantiated + sum(map(written_out, element))

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
