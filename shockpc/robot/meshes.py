"""Meshes of a robot, from files of any kind that robots come with, inside the folders that the robot may read."""

from pathlib import Path
from typing import Any, NamedTuple

import coal
import numpy as np
from numpy.typing import NDArray

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.robot.source import RobotSource, resolve_asset

__all__ = ["Mesh", "Meshes", "last_words", "mesh_of", "read_mesh"]

_NOISE = ("From file", "in function", "at line", "message:", "Hint")


class Mesh(NamedTuple):
    """A surface that need not be convex, nor closed.

    Attributes:
        vertices: (n, 3) [m].
        triangles: (m, 3) indices into the vertices; none where only the hull of the vertices is known.
    """

    vertices: Array
    triangles: NDArray[np.int64]


class Meshes:
    """The meshes of one robot; each file is read once.

    Args:
        source: the robot.
    """

    def __init__(self, source: RobotSource):
        self._source = source
        self._read: dict[str, Mesh] = {}
        self._scaled: dict[tuple[str, tuple[float, ...]], Mesh] = {}

    def load(self, uri: str, scale: tuple[float, ...] = (1.0, 1.0, 1.0)) -> Mesh:
        """A mesh; the same object for the same file and scale.

        Args:
            uri: as the robot file names it.
            scale: along its axes [1].

        Raises:
            ValueError: it cannot be had; one line.
        """
        if uri not in self._read:
            try:
                path = resolve_asset(self._source, uri)
            except RobotError as refusal:
                raise ValueError(str(refusal)) from None
            try:
                self._read[uri] = read_mesh(path)
            except ValueError as refusal:
                raise ValueError(f'"{uri}": {refusal}') from None
        if (uri, scale) not in self._scaled:
            mesh = self._read[uri]
            self._scaled[uri, scale] = Mesh(mesh.vertices * np.array(scale), mesh.triangles)
        return self._scaled[uri, scale]


def read_mesh(path: Path) -> Mesh:
    """Read a mesh file: COLLADA, Wavefront, or what coal can read (STL and many more).

    Args:
        path: an existing file.

    Raises:
        ValueError: it is no mesh, or a broken one; one line.
    """
    from shockpc.robot.collada import read_collada, read_wavefront

    readers = {".dae": read_collada, ".obj": read_wavefront}
    try:
        if path.suffix.lower() in readers:
            mesh = Mesh(*readers[path.suffix.lower()](path))
        else:
            # The cheapest tree of boxes that coal can build: nobody here asks for collisions.
            mesh = mesh_of(coal.MeshLoader(coal.NODE_TYPE.BV_AABB).load(str(path), np.ones(3)))
    except OSError as refusal:
        raise ValueError(f"it cannot be read: {refusal.strerror}") from None
    except (ValueError, RuntimeError) as refusal:
        raise ValueError(last_words(refusal)) from None
    if not len(mesh.vertices) or not np.isfinite(mesh.vertices).all():
        raise ValueError("it has no vertices, or some that are not numbers")
    return mesh


def mesh_of(model: Any) -> Mesh:
    """Copy a coal mesh.

    coal 3.0 counts the vertices of a file's second part from the first part's beginning again. Then some vertices belong to no
    triangle, which its reader never leaves of a sound file, and only the hull can be trusted.
    """
    vertices = np.array(model.vertices(), dtype=float)
    corners = [model.tri_indices(i) for i in range(model.num_tris)]
    triangles = np.array([(c[0], c[1], c[2]) for c in corners], dtype=np.int64).reshape(-1, 3)
    sound = len(np.unique(triangles)) == len(vertices)
    return Mesh(vertices, triangles if sound else triangles[:0])


def last_words(refusal: Exception) -> str:
    """What a reader of meshes meant in one line, without the place in its source that it was raised from."""
    lines = [line.strip() for line in str(refusal).splitlines()]
    wanted = [line for line in lines if line and not line.startswith(_NOISE)]
    return wanted[-1].rstrip(".") if wanted else "the mesh reader refuses it"
