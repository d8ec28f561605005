"""The region of a body where a sensor may be: its geometry, the surface of that, or a box."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.convex import LARGEST_COORDINATE, HalfSpaces, Shape, facets, half_spaces
from shockpc.robot.shapes.geometry import GeometryKind, outline
from shockpc.studies.place.best_first import box_faces
from shockpc.studies.place.cone import ConvexCell
from shockpc.text.errors import StudyError

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lower and upper corner of a box in the body's frame [m]."""

MARKER = 0.01
"""Share of the body's size below which a shape marks a frame, and carries no sensor."""


class Region(NamedTuple):
    """A region where a sensor may be.

    Attributes:
        text: in words.
        cells: convex sets that make it up.
        outside: convex sets whose inside does not belong to it.
        size: the longest side of its box [m].
        solid: whether it has an inside, which a surface has not.
        warnings: about shapes that could not be read.
    """

    text: str
    cells: tuple[ConvexCell, ...]
    outside: tuple[HalfSpaces, ...]
    size: float
    solid: bool
    warnings: tuple[str, ...]


def region_of(robot: Robot, body: int, within: Box | None, surface: bool) -> Region:
    """The region of a body where a sensor may be.

    Args:
        robot: the robot.
        body: index of the body.
        within: only in this box of the body's frame [m].
        surface: only on the surface of the geometry, which is the visual one for that and else the
            one for collisions; the other kind if the body has no such geometry.

    Raises:
        StudyError: there is no such place.
    """
    limits = None if within is None else _checked_box(within)
    name = robot.bodies[body].name
    # Collision geometry says where the inside is, and visual geometry what surface is seen.
    kinds: tuple[GeometryKind, ...] = ("collision", "visual")
    if surface:
        kinds = ("visual", "collision")
    kind = next((kind for kind in kinds if outline(robot, kind).shapes[body]), kinds[0])
    geometry = outline(robot, kind)
    shapes = geometry.shapes[body]
    if not shapes and (surface or limits is None):
        raise StudyError(
            f'body "{name}" has no geometry, so there is no place on it; give a box with --within'
        )
    if shapes and limits is not None:
        _refuse_apart(limits, _extent(shapes), name)
    if surface:
        region = _surface_of(shapes, f"{kind} geometry of {name}", limits)
        return region._replace(warnings=geometry.warnings)
    # A box is the region, whatever the geometry.
    if limits is not None:
        corners = np.array(list(itertools.product(*zip(*limits, strict=True))))
        text = f"in the box {_box_text(limits)} of {name}"
        return Region(text, (ConvexCell(corners),), (), _size(limits), True, ())
    # Without a box, the inside of all shapes; a mesh counts as its hull.
    pieces = "1 convex piece" if len(shapes) == 1 else f"{len(shapes)} convex pieces"
    if any(shape.mesh is not None for shape in shapes):
        pieces += ", a mesh as its convex hull"
    text = f"inside the {kind} geometry of {name} ({pieces})"
    hulls = tuple(ConvexCell(shape.points, shape.rounding) for shape in shapes)
    return Region(text, hulls, (), _size(_extent(shapes)), True, geometry.warnings)


def _surface_of(
    shapes: Sequence[Shape], geometry: str, limits: tuple[Array, Array] | None
) -> Region:
    """The surface of some shapes, only that within a box if there is one.

    The surface of one shape inside of another one is no surface of the body.
    """
    size = _size(_extent(shapes))
    solid = [shape for shape in shapes if _size(_extent([shape])) > MARKER * size]
    cells: list[ConvexCell] = []
    for shape in solid:
        cells += [ConvexCell(corners) for corners in facets(shape)]
    within = ""
    # A box cuts the facets, and then sets the size of the region.
    if limits is not None:
        cells = _cut(cells, limits)
        size = _size(limits)
        within = f", within {_box_text(limits)}"
    text = f"on the surface of the {geometry} ({len(cells)} facets{within})"
    outside = tuple(hull for hull in map(half_spaces, solid) if hull is not None)
    return Region(text, tuple(cells), outside, size, False, ())


def _extent(shapes: Sequence[Shape]) -> tuple[Array, Array]:
    """Lower and upper corner (3,) of the box of some shapes [m]."""
    low = [-shape.reach(-np.eye(3)) for shape in shapes]
    high = [shape.reach(np.eye(3)) for shape in shapes]
    return np.min(low, axis=0), np.max(high, axis=0)


def _refuse_apart(limits: tuple[Array, Array], extent: tuple[Array, Array], name: str) -> None:
    """Refuse a box that does not meet the box of a body.

    Raises:
        StudyError: the text says where the body is.
    """
    (low, high), (body_low, body_high) = limits, extent
    if np.any(low > body_high) or np.any(high < body_low):
        raise StudyError(
            f"the box {_box_text(limits)} is outside {name}, which is in {_box_text(extent)} of "
            f"its frame"
        )


def _size(limits: tuple[Array, Array]) -> float:
    """The longest side of a box [m]."""
    return float((limits[1] - limits[0]).max())


def _cut(cells: Sequence[ConvexCell], limits: tuple[Array, Array]) -> list[ConvexCell]:
    """The parts of cells that are in a box."""
    faces = box_faces(*limits)
    parts = []
    for cell in cells:
        part: ConvexCell | None = cell
        for normal, offset in zip(faces.normals, faces.offsets, strict=True):
            # Faces that all points are inside of are no constraint.
            if part is not None and float((cell.points @ normal).max()) > offset:
                part = part.within(-normal, -offset)
        if part is not None:
            parts.append(part)
    return parts


def _checked_box(within: Box) -> tuple[Array, Array]:
    """Lower and upper corner of a box.

    Raises:
        StudyError: a lower limit is above the upper one, or one is too large.
    """
    low, high = (np.array(corner, dtype=float) for corner in within)
    for axis, a, b in zip("xyz", low, high, strict=True):
        if not -LARGEST_COORDINATE <= a <= b <= LARGEST_COORDINATE:
            raise StudyError(
                f"the box has no {axis} between {a:g} and {b:g} m; give the lower limit first, up "
                f"to {LARGEST_COORDINATE:g}"
            )
    return low, high


def _box_text(limits: tuple[Array, Array]) -> str:
    """A box in words, such as "x -0.1…0.1, y -0.1…0.1, z 0…0.1 m"."""
    low, high = limits
    sides = [f"{axis} {a:.4g}…{b:.4g}" for axis, a, b in zip("xyz", low, high, strict=True)]
    return f"{', '.join(sides)} m"
