"""End stops: which joints are at a limit, and the rows along which their stops push."""

import math
from dataclasses import replace

import numpy as np

from shockpc.core.spatial import Array, velocity_at
from shockpc.landing.joint_model import JointModel
from shockpc.landing.scenes.scene import Contact
from shockpc.method.approach import Motion, relative_twist
from shockpc.method.constraints import NO_AXES, Constraint, constraint_point
from shockpc.method.dynamics import Dynamics
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import STOP, Robot
from shockpc.robot.tolerances import LIMIT_SLACK
from shockpc.text.errors import SceneError

ROUNDING = 1e-9
"""Share of the largest rate, those of the base too, below which one is rounding."""


def is_stop(robot: Robot, frame: str) -> bool:
    """True if a contact is the end stop of a joint: "stop:JOINT", if no frame has that name."""
    return frame.startswith(STOP) and frame not in robot.frames


def has_stops(robot: Robot, joint: Joint) -> bool:
    """True if a joint can have stops.

    It has one coordinate, and no other joint in its body but those that carry it.
    """
    return joint.kind in ("revolute", "prismatic") and any(
        joint is carrying for carrying in robot.joints
    )


def stop_constraint(
    robot: Robot, joint: Joint, side: float, restitution: float = 0.0
) -> Constraint:
    """The row of a stop: a unit moment, or force, on the joint's body away from the stop.

    The opposite is on the body before the joint.

    Args:
        robot: the robot.
        joint: that has stops.
        side: 1 for the stop at the smallest value, which pushes the coordinate up; −1 for that at
            the largest.
        restitution: of the stop [1].
    """
    assert joint.axis is not None
    body = next(i for i, carried in enumerate(robot.joints) if carried is joint)
    axis = side * (robot.bodies[body].rotation.T @ joint.axis)[None]
    slides = joint.kind == "prismatic"
    return Constraint(
        kind="stop",
        frame=joint.name,
        body=body,
        point=np.zeros(3),
        forces=axis if slides else NO_AXES,
        moments=NO_AXES if slides else axis,
        other_body=joint.parent,
        axes_body=body,
        restitution=restitution,
    )


def striking_stop(robot: Robot, contact: Contact, q: Array, rates: Array) -> Constraint:
    """The row of an end stop that strikes: a joint runs into the stop towards which it moves.

    Its contact point is the centre of mass of the joint's body, whose velocity is that relative to
    the body before it.

    Args:
        robot: the robot.
        contact: whose frame is "stop:JOINT".
        q: (nq,) configuration.
        rates: (nv,) of the joints before the impact [rad/s, m/s].

    Raises:
        UnknownName: the robot has no such joint.
        SceneError: the joint has no stops, does not move, or is not at the stop towards which it
            moves; or the contact has what a stop does not.
    """
    name = contact.frame.removeprefix(STOP)
    # Not a glob, as for the frame of any contact: several joints would be several stops.
    if name not in robot.joint_names:
        raise robot.unknown("joint", name, robot.joint_names)
    joint = robot.joint(name)
    rate = float(rates[joint.v.start])
    fault = _stop_fault(robot, contact, joint, joint.value(q), rate)
    if fault:
        raise SceneError(fault, constraints=[contact.frame], joints=[name])
    side = -1.0 if rate > 0.0 else 1.0
    constraint = stop_constraint(robot, joint, side, contact.restitution)
    return constraint._replace(frame=contact.frame, point=robot.bodies[constraint.body].com)


def _stop_fault(robot: Robot, contact: Contact, joint: Joint, value: float, rate: float) -> str:
    """Why a joint with this value and rate strikes no end stop; empty if it does."""
    name = joint.name
    bare = replace(contact, restitution=0.0, restitution_along="normal")
    frame = contact.frame
    if bare not in (Contact(frame=frame), Contact(frame=frame, at="frame", kind="point")):
        return (
            f'contact "{frame}" is an end stop, which takes only a restitution; leave the other '
            "keys out"
        )
    if not has_stops(robot, joint):
        return (
            f'joint "{name}" has no end stop: it is continuous, or shares its body with other '
            "joints"
        )
    if rate == 0.0:
        return (
            f'joint "{name}" does not move, so it does not reach its end stop; give its rate, as '
            f"--joint-velocity {name}=-2"
        )
    low, high = joint.limits
    side, limit, direction = (-1.0, high, "up") if rate > 0.0 else (1.0, low, "down")
    if side in sides_of(joint, value):
        return ""
    size, unit = (1.0, "m") if joint.kind == "prismatic" else (math.degrees(1.0), "deg")
    where = "no limit is read there from its file"
    if math.isfinite(limit):
        where = f"its stop is at {size * limit:.6g} {unit}"
    return (
        f'joint "{name}" is at {size * value:.6g} {unit} and moves {direction}, but {where}; '
        "set it there with --set, or let it move the other way"
    )


def missed_stops(robot: Robot, stops: list[Constraint], Q: Array, rates: Array) -> np.ndarray:
    """Mask (N,) of the postures in which a joint misses the stop that it strikes.

    The joint is not at the stop, or does not move towards it.

    Args:
        robot: the robot.
        stops: rows of end stops that strike.
        Q: (N, nq) configurations.
        rates: ([N,] nv) of the joints before the impact [rad/s, m/s].
    """
    missed = np.zeros(len(Q), dtype=bool)
    for stop in stops:
        joint, side = robot.joints[stop.body], side_of(robot, stop)
        there = [side in sides_of(joint, joint.value(q)) for q in Q]
        missed |= ~np.array(there) | (side * rates[..., joint.v.start] >= 0.0)
    return missed


def velocity_at_stop(state: Dynamics, stop: Constraint, before: Motion) -> Array:
    """Velocity (N, 3) of an end stop's contact point, world axes [m/s].

    It is relative to the body before the joint.
    """
    relative = relative_twist(state, stop, before)
    return np.asarray(velocity_at(relative[:, :3], relative[:, 3:], constraint_point(state, stop)))


def side_of(robot: Robot, stop: Constraint) -> float:
    """The side of the row of a stop, as of `stop_constraint`."""
    axis = robot.joints[stop.body].axis
    assert axis is not None
    row = np.concatenate([stop.forces, stop.moments])[0]
    return float(np.sign(row @ robot.bodies[stop.body].rotation.T @ axis))


def sides_of(joint: Joint, value: float) -> tuple[float, ...]:
    """At which of its stops a joint is, or beyond it, as the side of `stop_constraint`.

    Args: value of its coordinate [rad, m].
    """
    low, high = joint.limits
    sides: list[float] = []
    if value <= low + LIMIT_SLACK:
        sides.append(1.0)
    if value >= high - LIMIT_SLACK:
        sides.append(-1.0)
    return tuple(sides)


def stops_at(robot: Robot, q: Array, model: JointModel) -> list[tuple[Joint, float]]:
    """The joints that are at a stop in a configuration (nq,) and not locked, and its side.

    The side is that of `stop_constraint`.
    """
    stops: list[tuple[Joint, float]] = []
    for joint in robot.single_joints:
        if has_stops(robot, joint) and not model.locked[joint.v].any():
            stops += [(joint, side) for side in sides_of(joint, joint.value(q))]
    return stops


def at_stops(robot: Robot, Q: Array, model: JointModel, limits: bool = False) -> Array:
    """Sides (N, nv) of the stops that joints are at in N postures.

    1 at the smallest value, −1 at the largest, NaN at both, else 0.

    Args:
        robot: the robot.
        Q: (N, nq) configurations.
        model: which joints are locked, and so never are.
        limits: whether limits of joints count too that can have no stops.
    """
    sides = np.zeros((len(Q), robot.model.nv))
    for joint in robot.single_joints:
        stops = joint.kind in ("revolute", "prismatic") if limits else has_stops(robot, joint)
        if stops and not model.locked[joint.v].any():
            low, high = joint.limits
            value = Q[:, joint.q.start]
            at_low = value <= low + LIMIT_SLACK
            at_high = value >= high - LIMIT_SLACK
            side = at_low.astype(float) - at_high
            sides[:, joint.v.start] = np.where(at_low & at_high, np.nan, side)
    return sides


def driven_beyond(sides: Array, rates: Array, rounding: float = ROUNDING) -> np.ndarray:
    """Mask (..., nv) of the joints that would move beyond stops that they are at.

    They would move by more than rounding.

    Args:
        sides: (..., nv) as of `at_stops`.
        rates: (..., nv) of the joints after the impact, and the jumps of those of the base [rad/s,
            m/s].
        rounding: share of the largest of these below which one is rounding.
    """
    beyond = np.where(np.isnan(sides), -np.abs(rates), np.nan_to_num(sides) * rates)
    largest = np.abs(rates).max(axis=-1, keepdims=True)
    return np.asarray(beyond < -rounding * largest)
