"""A robot with the inertia of one link changed: mass, centre of mass or moments of inertia."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import RobotError
from shockpc.robot.robot import Robot

__all__ = ["changed_link", "link_mass"]


def link_mass(robot: Robot, link: str) -> float:
    """Mass of a link [kg], without that of the links that are fixed to it.

    Raises:
        UnknownName: the robot has no such link.
        RobotError: the link does not move, or the model does not keep its inertia apart from that of others.
    """
    return float(_inertia(robot, link)[1].mass)


def changed_link(robot: Robot, link: str, mass: float = 1.0, shift: Array | None = None, inertia: float = 1.0) -> Robot:
    """The robot with one link changed; everything else is shared with the robot.

    Args:
        robot: the robot.
        link: to be changed.
        mass: factor of its mass, and of its moments of inertia with it, as if its material were denser [1].
        shift: (3,) by which its centre of mass moves, in the link's frame [m].
        inertia: factor of the moments of inertia about its centre of mass, at the same mass [1].

    Raises:
        UnknownName: the robot has no such link.
        RobotError: the link does not move, has no mass of its own, or its inertia is not kept apart from that of others.
    """
    joint, own = _inertia(robot, link)
    if not own.mass > 0.0:
        raise RobotError(
            f'link "{link}" of robot "{robot.name}" has no mass, so its inertia cannot be varied; name a link with mass'
        )
    frame = robot.frames[link]
    body = robot.bodies[frame.body]
    moved = np.zeros(3) if shift is None else body.rotation @ frame.rotation @ shift
    model = pin.Model(robot.model)
    if mass != 1.0 or inertia != 1.0 or moved.any():
        new = pin.Inertia(own.mass * mass, own.lever + moved, own.inertia * (mass * inertia))
        rest = _difference(model.inertias[joint], own)
        model.inertias[joint] = new if rest is None else rest + new
    return replace(robot, model=model)


def _inertia(robot: Robot, link: str) -> tuple[int, pin.Inertia]:
    """The joint that carries a link, and the inertia of the link alone in the joint's frame."""
    frame = robot.frame(link)
    if frame.kind != "link":
        raise RobotError(f'"{link}" of robot "{robot.name}" is a {frame.kind}, which has no mass; name a link')
    if frame.body < 0:
        raise RobotError(f'link "{link}" of robot "{robot.name}" is fixed to the world, so its mass does not matter')
    body, model = robot.bodies[frame.body], robot.model
    whole = model.inertias[body.joint]
    if len(body.links) == 1:
        return body.joint, whole.copy()
    if robot.source.kind == "mjcf":
        raise RobotError(
            f'"{link}" of robot "{robot.name}" is joined with {", ".join(name for name in body.links if name != link)}, and of an '
            "MJCF file only the inertia of all of them together is known; vary a body that carries no other one rigidly"
        )
    # Pinocchio keeps the inertia of a link behind a fixed joint with the frame of that joint.
    fixed = [f for f in model.frames if f.parentJoint == body.joint and f.type == pin.FrameType.FIXED_JOINT]
    placed = model.frames[model.getFrameId(link, pin.FrameType.BODY)]
    if link != body.links[0]:
        holder = model.frames[placed.parentFrame]
        return body.joint, holder.placement.act(holder.inertia)
    own: pin.Inertia | None = whole.copy()
    for holder in fixed:
        if holder.inertia.mass > 0.0 and own is not None:
            own = _difference(own, holder.placement.act(holder.inertia))
    return body.joint, pin.Inertia.Zero() if own is None else own


def _difference(whole: pin.Inertia, part: pin.Inertia) -> pin.Inertia | None:
    """What is left of a rigid body without a part of it; None if nothing is left but rounding."""
    mass = whole.mass - part.mass
    if not mass > 1e-9 * whole.mass:
        return None
    com = (whole.mass * whole.lever - part.mass * part.lever) / mass

    def about(body: pin.Inertia, point: Array) -> Array:
        d = body.lever - point
        return np.asarray(body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d)))

    return pin.Inertia(mass, com, about(whole, com) - about(part, com))
