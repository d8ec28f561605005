"""Where on a body a sensor may be: in its geometry, on the surface of that, or in a box."""

import itertools
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.geometry import GeometryKind, outline
from shockpc.robot.robot import Robot
from shockpc.robot.shapes import LARGEST_COORDINATE, HalfSpaces, facets, half_spaces
from shockpc.studies.place.best_first import box
from shockpc.studies.place.cone import ConvexCell
from shockpc.text.errors import StudyError

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lower and upper corner of a box in the body's frame [m]."""

MARKER = 0.01
"""Share of the body's size below which a shape marks a frame and is no surface to mount a sensor
on.
"""


class Region(NamedTuple):
    """Where a sensor may be.

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
    """Where on a body a sensor may be.

    Args:
        robot: the robot.
        body: index of the body.
        within: only in this box of the body's frame [m].
        surface: only on the surface of the geometry, which is the visual one for that and else the
            one for collisions; the other kind if the body has no such geometry.

    Raises:
        StudyError: there is no such place.
    """
    name = robot.bodies[body].name
    limits = None if within is None else _checked_box(within)
    preferred: tuple[GeometryKind, GeometryKind] = (
        ("visual", "collision") if surface else ("collision", "visual")
    )
    kind = next((one for one in preferred if outline(robot, one).shapes[body]), preferred[0])
    seen = outline(robot, kind)
    shapes = seen.shapes[body]
    if not shapes and (limits is None or surface):
        raise StudyError(
            f'body "{name}" has no geometry, so there is no place on it; give a box with --within'
        )
    boxes = [np.stack([-shape.reach(-np.eye(3)), shape.reach(np.eye(3))]) for shape in shapes]
    whole = (
        (np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1])
        if shapes
        else limits or (np.zeros(3), np.zeros(3))
    )
    if limits is not None and (np.any(limits[0] > whole[1]) or np.any(limits[1] < whole[0])):
        raise StudyError(
            f"the box {_box_text(limits)} is outside {name}, which is in {_box_text(whole)} of its "
            f"frame"
        )
    if limits is not None and not surface:
        corners = np.array(list(itertools.product(*zip(*limits, strict=True))))
        return Region(
            f"in the box {_box_text(limits)} of {name}",
            (ConvexCell(corners),),
            (),
            _size(limits),
            True,
            (),
        )
    if not surface:
        pieces = "1 convex piece" if len(shapes) == 1 else f"{len(shapes)} convex pieces"
        hulls = (
            ", a mesh as its convex hull" if any(shape.mesh is not None for shape in shapes) else ""
        )
        cells = [ConvexCell(shape.points, shape.rounding) for shape in shapes]
        text = f"inside the {kind} geometry of {name} ({pieces}{hulls})"
        return Region(text, tuple(cells), (), _size(whole), True, seen.warnings)
    solid = [
        shape
        for shape, one in zip(shapes, boxes, strict=True)
        if np.ptp(one, axis=0).max() > MARKER * _size(whole)
    ]
    cells = [ConvexCell(corners) for shape in solid for corners in facets(shape)]
    if limits is not None:
        cells = [part for cell in cells if (part := _cut(cell, limits)) is not None]
    box_text = "" if limits is None else f", within {_box_text(limits)}"
    text = f"on the surface of the {kind} geometry of {name} ({len(cells)} facets{box_text})"
    outside = tuple(one for shape in solid if (one := half_spaces(shape)) is not None)
    return Region(
        text,
        tuple(cells),
        outside,
        _size(whole if limits is None else limits),
        False,
        seen.warnings,
    )


def _size(limits: tuple[Array, Array]) -> float:
    return float((limits[1] - limits[0]).max())


def _cut(cell: ConvexCell, limits: tuple[Array, Array]) -> ConvexCell | None:
    part: ConvexCell | None = cell
    faces = box(*limits)
    for normal, offset in zip(faces.normals, faces.offsets, strict=True):
        # Faces that all points are inside of are no constraint.
        if part is not None and float((cell.points @ normal).max()) > offset:
            part = part.within(-normal, -offset)
    return part


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
    return (
        ", ".join(f"{axis} {a:.4g}…{b:.4g}" for axis, a, b in zip("xyz", *limits, strict=True))
        + " m"
    )
