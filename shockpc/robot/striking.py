"""The shapes with which a frame strikes the ground: a foot with all of its body, another frame with its own."""

from typing import NamedTuple

import pinocchio as pin

from shockpc.core.memo import memoized
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.geometry import Unread, shapes_of
from shockpc.robot.robot import Robot
from shockpc.robot.shapes import Shape


class Striking(NamedTuple):
    """The shapes with which a frame strikes.

    Attributes:
        shapes: in the frame of the body.
        unread: those that could not be read.
        of_frame: whether they are the frame's `own_shapes`, on which its lowest point is sought, and no others.
        marks: whether the frame, which has no shapes, is a place on a body that has some, and is no foot.
    """

    shapes: tuple[Shape, ...]
    unread: tuple[Unread, ...]
    of_frame: bool
    marks: bool


@memoized()
def striking(robot: Robot, name: str) -> Striking:
    """The shapes with which a frame strikes.

    A foot strikes with its body and all that is fixed to that, another frame with its own shapes. What
    has none marks a place on its body. A frame of the base marks a point.
    """
    frame = robot.frame(name)
    links = robot.bodies[frame.body].links if robot.parents[frame.body] >= 0 else ()
    own, unread = own_shapes(robot, name)
    is_foot = name in each_foot(robot)
    if own and (not is_foot or _is_ball(own, links)):
        return Striking(own, unread, True, False)
    shapes, lost = _shapes_of_links(robot, links)
    if is_foot and (own or name in links[:1]):
        return Striking(shapes or own, lost, len(shapes) == len(own), False)
    return Striking(own or shapes, unread, bool(own), not own)


@memoized()
def own_shapes(robot: Robot, name: str) -> tuple[tuple[Shape, ...], tuple[Unread, ...]]:
    """The shapes of a link, else of what is fixed to it, or of a geom; and those that cannot be read."""
    shapes, unread = shapes_of(robot, name)
    if shapes or robot.frame(name).kind != "link":
        return shapes, unread
    shapes, lost = _shapes_of_links(robot, fixed_to(robot, name))
    return shapes, (*unread, *lost)


def _is_ball(shapes: tuple[Shape, ...], links: tuple[str, ...]) -> bool:
    """Whether a foot is a ball at the end of a link, beside which nothing of its body is as low.

    The meshes of the shank are then not read.
    """
    ball = len(shapes) == 1 and len(shapes[0].points) == 1 and bool(shapes[0].rounding.any())
    return ball and len(links) <= 2


def _shapes_of_links(
    robot: Robot,
    links: tuple[str, ...],
) -> tuple[tuple[Shape, ...], tuple[Unread, ...]]:
    """The shapes of some links, and those that could not be read."""
    shapes, unread = list[Shape](), list[Unread]()
    for link in links:
        found, lost = shapes_of(robot, link)
        shapes += found
        unread += lost
    return tuple(shapes), tuple(unread)


def fixed_to(robot: Robot, name: str) -> tuple[str, ...]:
    """The links that fixed joints carry behind a link."""
    frames = robot.model.frames
    start = robot.model.getFrameId(name, pin.FrameType.BODY)
    carried, links = {start}, list[str]()
    for number in range(start + 1, len(frames)):
        frame = frames[number]
        moves_along = frame.parentJoint == frames[start].parentJoint
        is_fixed = frame.type in (pin.FrameType.BODY, pin.FrameType.FIXED_JOINT)
        if is_fixed and moves_along and frame.parentFrame in carried:
            carried.add(number)
            if frame.type == pin.FrameType.BODY:
                links.append(frame.name)
    return tuple(links)
