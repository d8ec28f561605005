"""Parts of a robot that a URDF holds beside links and joints.

They are named places, and joints that close loops.
"""

from collections.abc import Container, Iterator, Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.bodies_and_joints import Frame, Loop
from shockpc.robot.robot import Robot
from shockpc.robot.tolerances import LINKS
from shockpc.robot.urdf.numbers import finite_numbers, grouped, place_of
from shockpc.text.errors import RobotError

LEVER = 0.1
"""Distance along the axis of a hinge at which a loop holds a second point, so that its axes stay
aligned [m].
"""

LOOPS = 200
"""Largest number of joints that close loops."""

AXIS = " (axis)"
"""End of the name of a loop that holds this second point."""

_HINGES, _BALLS = ("revolute", "continuous"), ("spherical", "ball")
_OPEN = "so the loop is left open: its bodies move as if nothing held them together"


def add_places(root: Element, model: pin.Model) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Add the places of a URDF to the model.

    They are those of <frame>, <drake:frame>, <fixed_frame> and <sensor>, and of the IMUs of
    <gazebo>.

    A place with the name of a link or joint, or of another place, is left out: the first is what
    the name means.

    Returns: the names of the IMUs, and a warning for each place that cannot be read.

    Raises:
        RobotError: there are too many.
    """
    imus: list[str] = []
    faults: list[tuple[str, str, str]] = []
    places = list(_places(root))
    if len(places) > LINKS:
        raise RobotError(
            f"it names {len(places)} places by frames and sensors, and up to {LINKS} are read; "
            f"leave some out"
        )
    for element, link, placement in places:
        name, kind = element.get("name", ""), element.tag
        fault = _add_place(model, name, link, placement)
        if fault:
            faults.append((kind, name, fault))
        elif kind == "sensor" and element.get("type") == "imu":
            imus.append(name)
    return tuple(dict.fromkeys(imus)), grouped(faults)


def _add_place(model: pin.Model, name: str, link: str, placement: pin.SE3 | None) -> str:
    """Add a place on a link to a model, if it is new; say why it cannot be added, else nothing."""
    if placement is None:
        return "has a place that is not read; it is left out"
    if not model.existFrame(link, pin.FrameType.BODY):
        return f'is on "{link}", which is no link of the file; it is left out'
    number = model.getFrameId(link, pin.FrameType.BODY)
    joint = model.frames[number].parentJoint
    at = model.frames[number].placement * placement
    if not model.existFrame(name):
        model.addFrame(pin.Frame(name, joint, number, at, pin.FrameType.OP_FRAME), False)
        return ""
    for frame in model.frames:
        on_joint = frame.name == name and frame.parentJoint == joint
        if on_joint and at.isApprox(frame.placement, 1e-9):
            return ""
    return "has the name of something else at another place, so it is left out; rename it"


def _places(root: Element) -> Iterator[tuple[Element, str, pin.SE3 | None]]:
    """The elements that name a place on a link, with the link and the place in its frame.

    The place is None where its pose is not read.
    """
    for tag in ("frame", "drake:frame", "fixed_frame", "sensor"):
        for element in root.findall(tag):
            parent, origin = element.find("parent"), element.find("origin")
            link = element.get("link", "") if parent is None else parent.get("link", "")
            if link and element.get("name"):  # a sensor of a joint has no place
                yield element, link, _placed(element if origin is None else origin, element)
    links = {link.get("name") for link in root.findall("link")}
    for extension in root.findall("gazebo"):
        link = extension.get("reference", "")
        for element in extension.findall("sensor"):
            is_imu = element.get("type") == "imu" and element.get("name")
            if is_imu and link in links:
                yield element, link, _pose(element.find("pose"))


def _placed(origin: Element, element: Element) -> pin.SE3:
    """A place by the attributes xyz and rpy of an element."""
    holder = Element("place")
    SubElement(holder, "origin", {key: origin.get(key, "0 0 0") for key in ("xyz", "rpy")})
    return place_of(holder, f'{element.tag} "{element.get("name", "")}"')


def _pose(pose: Element | None) -> pin.SE3 | None:
    """A <pose> of SDFormat in the frame of its link; None if it is in another frame or no pose."""
    if pose is None:
        return pin.SE3.Identity()
    in_other_frame = pose.get("relative_to")
    by_angles = pose.get("rotation_format", "euler_rpy") == "euler_rpy"
    values = np.zeros(6)
    if (pose.text or "").strip():
        read = finite_numbers(pose.text, 6)
        if read is None:
            return None
        values = read
    if in_other_frame or not by_angles:
        return None
    angles = values[3:]
    if pose.get("degrees", "").casefold() in ("true", "1"):
        angles = np.radians(angles)
    return pin.SE3(pin.rpy.rpyToMatrix(angles), values[:3])


def ball_joints(
    root: Element,
    order: Mapping[str, tuple[str, str]],
    joints: Mapping[str, Element],
    masses: Mapping[str, float],
) -> dict[str, str]:
    """The joints that are parts of a ball joint which a loop closes, by name.

    The values are the names of these loops.

    A rod with a ball joint at its end is written as links without mass, whose joints have their
    axes through one point, and a loop there. By themselves such links can turn without resistance;
    with the loop these joints hold the point and nothing else.

    Args:
        root: the <robot>.
        order: the joint above each link, and the link that carries it, carriers first.
        joints: by name.
        masses: of the links [kg].
    """
    carried = dict(masses)
    for link in reversed(list(order)):
        if carrier := order[link][1]:
            carried[carrier] += carried[link]
    parts: dict[str, str] = {}
    for loop in root.findall("loop_joint"):
        kind = loop.get("type", "spherical" if loop.find("axis") is None else "revolute")
        free = {**dict.fromkeys(_HINGES, 1), **dict.fromkeys(_BALLS, 3)}.get(kind, 0)
        for end in loop:
            if end.tag not in ("link1", "link2") or end.get("link") not in order:
                continue
            link = end.get("link", "")
            placement = _placed(end, loop)
            chain: list[str] = []
            while not carried[link] and order[link][0]:
                joint = joints[order[link][0]]
                if joint.get("type") != "fixed":
                    at_end = np.abs(placement.translation).max() <= 1e-9
                    if joint.get("type") not in _HINGES or not at_end:
                        break
                    chain.append(order[link][0])
                link, placement = order[link][1], place_of(joint, "joint") * placement
            else:
                if len(chain) + free >= 3:
                    parts |= dict.fromkeys(chain, loop.get("name", ""))
    return parts


def read_loops(
    root: Element, robot: Robot, balls: Container[str]
) -> tuple[tuple[Loop, ...], tuple[str, ...]]:
    """The loops that joints and constraints of other programs close.

    They are <loop_joint> of Isaac Sim and Drake and <drake:ball_constraint>; with them comes a
    warning for each left open.

    A <loop_joint> joins a frame on each of two links, at xyz and rpy of its <link1> and <link2>.
    Without a type it is a hinge if it has an axis, as in Drake, and a ball joint if not. The axis
    is the same in both frames, (1, 0, 0) where none is written.

    Args:
        root: the <robot>.
        robot: it, without loops.
        balls: names of the loops that are ball joints with the joints before them, as `ball_joints`
            finds them.

    Returns: the loops, of a hinge two each; and the warnings.

    Raises:
        RobotError: there are too many.
    """
    count = sum(part.tag in ("loop_joint", "drake:ball_constraint") for part in root)
    if count > LOOPS:
        raise RobotError(
            f"it has {count} joints that close loops, and up to {LOOPS} are computed; leave some "
            f"out"
        )
    loops: list[Loop] = []
    faults: list[tuple[str, str, str]] = []
    for number, joint in enumerate(root.findall("loop_joint"), start=1):
        name = joint.get("name") or f"loop_{number}"
        closed = _loop_joint(robot, joint, name, name in balls)
        if isinstance(closed, str):
            faults.append(("loop_joint", name, f"{closed}, {_OPEN}"))
        else:
            loops += closed
    for number, constraint in enumerate(root.findall("drake:ball_constraint"), start=1):
        name = constraint.get("name") or f"ball_constraint_{number}"
        closed = _ball_constraint(robot, constraint, name)
        if isinstance(closed, str):
            faults.append(("drake:ball_constraint", name, f"{closed}, {_OPEN}"))
        else:
            loops += closed
    return tuple(loops), grouped(faults)


def _loop_joint(robot: Robot, joint: Element, name: str, is_ball: bool) -> list[Loop] | str:
    """The loops of a <loop_joint>, or why it closes none.

    Args:
        robot: without loops.
        joint: the element.
        name: of the loop.
        is_ball: whether it is a ball joint with the joints before it.
    """
    ends = [end for end in joint if end.tag in ("link1", "link2")]
    links = [end.get("link", "") for end in ends]
    fault = _fault(robot, links)
    if fault:
        return fault
    axis = joint.find("axis")
    kind = joint.get("type", "spherical" if axis is None else "revolute")
    if kind not in (*_HINGES, *_BALLS, "fixed", "prismatic"):
        return f'is of type "{kind}", which closes no loop that is computed'
    written = "1 0 0" if axis is None else axis.get("xyz", "1 0 0")
    direction = finite_numbers(written, 3)
    if direction is None or not 1e-100 < np.abs(direction).max() < 1e100:
        return "has an axis without a direction"
    a, b = (
        _end(robot.frames[link], _placed(end, joint)) for link, end in zip(links, ends, strict=True)
    )
    if is_ball:
        kind = "ball"
    return _closed(name, kind, a, b, direction / np.linalg.norm(direction))


def _ball_constraint(robot: Robot, constraint: Element, name: str) -> list[Loop] | str:
    """The loop of a <drake:ball_constraint>, or why it closes none."""
    parts = {part.tag.removeprefix("drake:ball_constraint_"): part for part in constraint}
    links = [parts[key].get("name", "") for key in ("body_A", "body_B") if key in parts]
    fault = _fault(robot, links)
    if fault:
        return fault
    ends = []
    for link, key in zip(links, ("p_AP", "p_BQ"), strict=True):
        point: Array | None = np.zeros(3)
        if key in parts:
            point = finite_numbers(parts[key].get("value"), 3)
        if point is None:
            return "has a point that cannot be read"
        ends.append(_end(robot.frames[link], pin.SE3(np.eye(3), point)))
    return _closed(name, "ball", ends[0], ends[1], np.array([1.0, 0.0, 0.0]))


def _fault(robot: Robot, links: list[str]) -> str:
    """Why a joint between two links closes no loop; empty if it does."""
    if len(links) != 2 or not all(links):
        return f"names {len(list(filter(None, links)))} links, and a loop has two ends"
    for link in links:
        if link not in robot.frames or robot.frames[link].kind != "link":
            return f'is on "{link}", which is no link of the file'
    if robot.frames[links[0]].body == robot.frames[links[1]].body:
        return f'joins "{links[0]}" and "{links[1]}", which are fixed to one another'
    return ""


def _end(frame: Frame, placement: pin.SE3) -> tuple[int, pin.SE3]:
    """One end of a loop: its body, and the end's place in the body's frame."""
    return frame.body, pin.SE3(frame.rotation, frame.offset) * placement


def _closed(
    name: str, kind: str, a: tuple[int, pin.SE3], b: tuple[int, pin.SE3], axis: Array
) -> list[Loop]:
    """The loops that a joint of some kind between two ends holds.

    Args: axis (3,), of length 1, in the frames of both ends.
    """
    across = np.linalg.svd(axis[None])[2][1:]
    (body_a, end_a), (body_b, end_b) = a, b

    def loop(name: str, point: Array, axes: Array, holds_orientation: bool = False) -> Loop:
        return Loop(
            name=name,
            bodies=(body_a, body_b),
            points=(read_only(end_a.act(point)), read_only(end_b.act(point))),
            rotations=(read_only(end_a.rotation), read_only(end_b.rotation)),
            axes=read_only(axes),
            holds_orientation=holds_orientation,
        )

    if kind == "prismatic":
        return [loop(name, np.zeros(3), across, True)]
    first = loop(name, np.zeros(3), np.eye(3), kind == "fixed")
    if kind not in _HINGES:
        return [first]
    # A second point on the axis, held across it, keeps the axes of a hinge aligned.
    return [first, loop(f"{name}{AXIS}", LEVER * axis, across)]
