"""The least and the greatest shock over every body's geometry."""

from shockpc.core.extremes import shock_extremes
from shockpc.core.spatial import Array
from shockpc.robot.geometry import outline
from shockpc.robot.robot import Robot

__all__ = ["shock_ranges"]


def shock_ranges(robot: Robot, delta_omega: Array, delta_v: Array, v_in: float) -> tuple[Array, Array, tuple[str, ...]]:
    """Least and greatest shock over every body's collision geometry (its visual one, if the file has no collision geometry).

    Args:
        robot: the robot.
        delta_omega: (nb, 3) body axes [rad/s].
        delta_v: (nb, 3) body axes, at the body frame's origin [m/s].
        v_in: speed that shock is normalised by [m/s].

    Returns: least (nb,), greatest (nb,) [1], NaN for a body without geometry; warnings.
    """
    seen = outline(robot, "collision" if robot.source.kind == "mjcf" or "<collision" in robot.source.xml else "visual")
    return *shock_extremes(delta_omega, delta_v, seen.pieces, v_in), seen.warnings
