"""The shapes with which a frame strikes.

Those of a foot are all of its body's, those of another frame its own.
"""

from typing import NamedTuple

import pinocchio as pin

from shockpc.core.memo import memoized
from shockpc.robot.bodies_and_joints import Frame
from shockpc.robot.feet_and_sensors import each_foot, is_foot, recognised
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.geometry import UnreadShape, shapes_of


class Striking(NamedTuple):
    """The shapes with which a frame strikes.

    Attributes:
        shapes: in the frame of the body.
        unread: those that could not be read.
        is_place: whether the frame has no shapes: it is a place on a body, whose shapes these are.
        is_foot: whether it is the name of what is recognised as a foot.
    """

    shapes: tuple[Shape, ...]
    unread: tuple[UnreadShape, ...]
    is_place: bool
    is_foot: bool


@memoized()
def striking(robot: Robot, name: str) -> Striking:
    """The shapes with which a frame strikes.

    A foot strikes with its body and all that is fixed to that, another frame with its own shapes.
    What has none is a place on its body. A frame of the base marks a point.
    """
    frame = robot.frame(name)
    links = robot.bodies[frame.body].links if robot.parents[frame.body] >= 0 else ()
    of_frame, unread = own_shapes(robot, name)
    is_end = name in each_foot(robot)
    is_whole_foot = is_end and recognised(robot)
    if of_frame:
        alone = not is_end or not links or _is_ball_at_end(of_frame, frame, links)
        if alone:
            return Striking(of_frame, unread, False, is_whole_foot)
    shapes, lost = _shapes_of_links(robot, links)
    if is_whole_foot and not shapes and not lost:
        shapes = _marked_points(robot, frame.body)
    is_place = not of_frame and name not in links[:1]
    return Striking(shapes, lost, is_place, is_whole_foot)


@memoized()
def own_shapes(robot: Robot, name: str) -> tuple[tuple[Shape, ...], tuple[UnreadShape, ...]]:
    """The shapes of a link, else of what is fixed to it, or of a geom; and those not read."""
    shapes, unread = shapes_of(robot, name)
    if shapes or robot.frame(name).kind != "link":
        return shapes, unread
    shapes, lost = _shapes_of_links(robot, fixed_to(robot, name))
    return shapes, (*unread, *lost)


def _marked_points(robot: Robot, body: int) -> tuple[Shape, ...]:
    """Several sites or links without geometry that are named like a foot, as points of its sole."""
    root = robot.bodies[body].links[0]
    marks = [f for f in robot.frames.values() if f.body == body and f.kind in ("link", "site")]
    marks = [mark for mark in marks if is_foot(mark.name) and mark.name != root]
    points = tuple(Shape(root, mark.offset[None]) for mark in marks)
    return points if len(points) > 1 else ()


def _is_ball_at_end(shapes: tuple[Shape, ...], frame: Frame, links: tuple[str, ...]) -> bool:
    """True if a foot is a link with a ball at the end of another, and nothing beside is as low.

    The meshes of the shank are then not read.
    """
    if len(shapes) != 1:
        return False
    (shape,) = shapes
    is_ball = len(shape.points) == 1 and bool(shape.rounding.any())
    return is_ball and frame.kind == "link" and len(links) <= 2


def _shapes_of_links(
    robot: Robot,
    links: tuple[str, ...],
) -> tuple[tuple[Shape, ...], tuple[UnreadShape, ...]]:
    """The shapes of some links, and those that could not be read."""
    shapes, unread = list[Shape](), list[UnreadShape]()
    for link in links:
        of_link, lost = shapes_of(robot, link)
        shapes += of_link
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
