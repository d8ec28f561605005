"""End stops: which joints are at a limit, and the rows along which their stops push."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.joint_model import JointModel
from shockpc.landing.rows import NO_AXES, Block
from shockpc.robot.robot import Joint, Robot
from shockpc.robot.slack import LIMIT_SLACK


def has_stops(robot: Robot, joint: Joint) -> bool:
    """Whether a joint can have stops: it has one coordinate, and a body of its own with those that carry it."""
    return joint.kind in ("revolute", "prismatic") and any(joint is one for one in robot.joints)


def stop_block(robot: Robot, joint: Joint, side: float, restitution: float = 0.0) -> Block:
    """The row of a stop: a unit moment, or force, on the joint's body away from the stop, and its opposite on the body before it.

    Args:
        robot: the robot.
        joint: that has stops.
        side: 1 for the stop at the least value, which pushes the coordinate up; −1 for that at the greatest.
        restitution: of the stop [1].
    """
    assert joint.axis is not None
    body = next(i for i, one in enumerate(robot.joints) if one is joint)
    axis = side * (robot.bodies[body].rotation.T @ joint.axis)[None]
    forces, moments = (axis, NO_AXES) if joint.kind == "prismatic" else (NO_AXES, axis)
    return Block("stop", joint.name, body, np.zeros(3), forces, moments, joint.parent, body, restitution)


def side_of(robot: Robot, stop: Block) -> float:
    """The side of the row of a stop, as of `stop_block`."""
    axis = robot.joints[stop.body].axis
    assert axis is not None
    return float(np.sign(np.concatenate([stop.forces, stop.moments])[0] @ robot.bodies[stop.body].rotation.T @ axis))


def sides_of(joint: Joint, value: float) -> tuple[float, ...]:
    """At which of its stops a joint is, or beyond it, as the side of `stop_block`. Args: value of its coordinate [rad, m]."""
    low, high = joint.limits
    return (1.0,) * (value <= low + LIMIT_SLACK) + (-1.0,) * (value >= high - LIMIT_SLACK)


def stops_at(robot: Robot, q: Array, model: JointModel) -> list[tuple[Joint, float]]:
    """The joints that are at a stop in a configuration (nq,) and not locked, with the side of it as that of `stop_block`."""
    free = [joint for joint in robot.single_joints if has_stops(robot, joint) and not model.locked[joint.v].any()]
    return [(joint, side) for joint in free for side in sides_of(joint, joint.value(q))]


def at_stops(robot: Robot, Q: Array, model: JointModel) -> Array:
    """Whether a joint is at a stop in N postures: (N, nv) 1 at the least value, −1 at the greatest, NaN at both, else 0."""
    found = np.zeros((len(Q), robot.model.nv))
    for joint in robot.single_joints:
        if has_stops(robot, joint) and not model.locked[joint.v].any():
            low, high = joint.limits
            value = Q[:, joint.q.start]
            lower, upper = value <= low + LIMIT_SLACK, value >= high - LIMIT_SLACK
            found[:, joint.v.start] = np.where(lower & upper, np.nan, lower.astype(float) - upper)
    return found


def driven_beyond(sides: Array, rates: Array) -> np.ndarray:
    """Whether joints would move beyond stops that they are at, by more than rounding.

    Args:
        sides: (..., nv) as of `at_stops`.
        rates: (..., nv) of the joints after the impact, and the jumps of those of the base [rad/s, m/s].
    """
    beyond = np.where(np.isnan(sides), -np.abs(rates), np.nan_to_num(sides) * rates)
    return np.asarray(beyond < -ROUNDING * np.abs(rates).max(axis=-1, keepdims=True))


ROUNDING = 1e-9
"""Share of the largest rate, those of the base too, below which one is rounding."""
