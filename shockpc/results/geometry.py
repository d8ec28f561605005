"""The least and the greatest shock over every body's geometry."""

from shockpc.core.extremes import Pieces, shock_extremes
from shockpc.core.spatial import Array
from shockpc.results.solved import Solved
from shockpc.robot.geometry import body_outline
from shockpc.robot.robot import Robot

__all__ = ["body_pieces", "shock_ranges"]


def shock_ranges(of: Solved) -> tuple[Array, Array]:
    """Least and greatest shock (nb,) over the bodies' geometry (collision; visual, if the file has no other) [1]; NaN without any.

    Computed in double precision from the proven jumps: right to 1e-15 of |Δv| + |Δω| |r| at the farthest point r of the body.
    """
    jumps = of.proof.jumps[..., 3]
    return shock_extremes(jumps[:, :3], jumps[:, 3:], body_outline(of.robot).pieces, of.v_in)


def body_pieces(robot: Robot, body: int) -> Pieces:
    """The same geometry of one body alone, which becomes the only body of the pieces."""
    return Pieces.of([[(shape.points, shape.radius) for shape in body_outline(robot).shapes[body]]])
