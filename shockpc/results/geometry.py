"""The least and the greatest shock over every body's geometry."""

import numpy as np

from shockpc.core.extremes import Pieces, shock_extremes
from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.robot.geometry import body_outline
from shockpc.robot.robot import Robot

__all__ = ["body_pieces", "shock_ranges"]


def shock_ranges(robot: Robot, jumps: Array, v_in: float) -> tuple[Array, Array, tuple[Diagnostic, ...]]:
    """Least and greatest shock over every body's collision geometry (its visual one, if the file has no collision geometry).

    Computed in double precision from the proven jumps: right to 1e-15 of |Δv| + |Δω| |r| at the farthest point r of the body.

    Args:
        robot: the robot.
        jumps: (nb, 6) of every body, body axes at its frame's origin.
        v_in: speed by which shock is normalised [m/s].

    Returns: least (nb,), greatest (nb,) [1], NaN for a body without geometry; warnings.
    """
    seen = body_outline(robot)
    least, greatest = shock_extremes(jumps[:, :3], jumps[:, 3:], seen.pieces, v_in)
    warnings = tuple(Diagnostic("geometry", robot.name, None, text) for text in seen.warnings)
    return np.asarray(least), np.asarray(greatest), warnings


def body_pieces(robot: Robot, body: int) -> Pieces:
    """The same geometry of one body alone, which becomes the only body of the pieces."""
    return Pieces.of([[(shape.points, shape.radius) for shape in body_outline(robot).shapes[body]]])
