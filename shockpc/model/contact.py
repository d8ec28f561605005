"""Where a robot touches the ground, and what sticks there: names, offsets and directions → rows of J_c."""

import fnmatch
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import SceneError, UnknownName
from shockpc.model import CHECKED
from shockpc.model.outline import outline
from shockpc.model.robot import Robot

__all__ = ["Contact", "Touch", "match_frames", "touch"]

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, kw_only=True)
class Contact:
    """A contact as a scene states it.

    Attributes:
        frame: link or frame that strikes.
        offset: contact point from that frame's origin, in the frame's axes [m].
        at: "frame" takes that point; "lowest" takes the lowest point of the link's own collision geometry in this posture
            (the middle of all that are equally low), and adds the offset to it.
        directions: world axes or vectors along which the contact stops the point; the others slide.
        restitution: speed after impact over speed before it, along each of these directions [1].
    """

    __pydantic_config__ = CHECKED

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    at: Literal["frame", "lowest"] = "frame"
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")
    restitution: float = 0.0


class Touch(NamedTuple):
    """A contact made numbers.

    Attributes:
        frame: its name.
        body: index of the body that strikes.
        point: (3,) contact point in the body's frame [m].
        directions: (n, 3) unit vectors, world axes.
        restitution: [1]
    """

    frame: str
    body: int
    point: Array
    directions: Array
    restitution: float


def match_frames(robot: Robot, pattern: str) -> tuple[str, ...]:
    """The frames that a name, a glob or a part of a link's name means.

    An exact frame name means itself. Otherwise every link whose name fits the glob, or contains the text, whatever the case.

    Raises:
        UnknownName: nothing fits.
    """
    if pattern in robot.frames:
        return (pattern,)
    wanted = pattern.casefold()
    if any(sign in wanted for sign in "*?["):
        found = [link for link in robot.links if fnmatch.fnmatchcase(link.casefold(), wanted)]
    else:
        found = [link for link in robot.links if wanted and wanted in link.casefold()]
    if not found:
        raise UnknownName("link or frame", pattern, robot.frames, f'robot "{robot.name}"', f"shockpc robots {robot.label}")
    return tuple(found)


def touch(robot: Robot, contact: Contact, rotation: Array, up: Array) -> Touch:
    """Place a contact on its body.

    Args:
        robot: the robot.
        contact: as the scene states it.
        rotation: (nb, 3, 3) of every body, body to world.
        up: (3,) unit normal of the ground, world axes.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: the frame does not move, the link has no collision geometry to find a lowest point on, or a direction has no
            length.
    """
    frame = robot.frame(contact.frame)
    if frame.body < 0:
        raise SceneError(f'contact "{contact.frame}" is fixed to the world, so it cannot strike; choose a frame on a moving link')
    if not contact.directions:
        raise SceneError(f'contact "{contact.frame}" keeps no direction, so nothing stops it; valid are "x", "y", "z" and vectors')
    if contact.restitution < 0.0 or contact.restitution > 1.0:
        raise SceneError(
            f'contact "{contact.frame}" has restitution {contact.restitution:g}; it lies between 0 (stays down) and 1 (bounces fully)'
        )
    vectors = np.array([AXES[d] if isinstance(d, str) else d for d in contact.directions], dtype=float)
    lengths = np.linalg.norm(vectors, axis=1)
    if not np.all(lengths > 0.0):
        raise SceneError(f'contact "{contact.frame}" has a direction of zero length; valid are "x", "y", "z" and vectors')
    if not np.any(np.abs(vectors @ up) > 1e-9 * lengths):
        raise SceneError(
            f'contact "{contact.frame}" keeps only directions along the ground, so nothing stops its fall; '
            f"add the ground's normal ({', '.join(f'{u:g}' for u in up)}) to its directions"
        )
    point = frame.offset + frame.rotation @ np.asarray(contact.offset)
    if contact.at == "lowest":
        point = _lowest_point(robot, contact.frame, rotation[frame.body].T @ up) + frame.rotation @ np.asarray(contact.offset)
    return Touch(contact.frame, frame.body, point, vectors / lengths[:, None], contact.restitution)


def _lowest_point(robot: Robot, link: str, up: Array) -> Array:
    """The lowest point of a link's own collision geometry; the middle of the lowest ones if several tie.

    Args:
        robot: the robot.
        link: its name.
        up: (3,) the ground's normal in the axes of the link's body.

    Returns: (3,) in the body's frame [m].
    """
    pieces = [shape for shapes in outline(robot, "collision").shapes for shape in shapes if shape.link == link]
    if not pieces:
        raise SceneError(
            f'link "{link}" has no collision geometry that could be read, so it has no lowest point; '
            "give the contact point by its offset, or name a link that has collision geometry"
        )
    points = np.concatenate([shape.points - shape.radius * up for shape in pieces])
    height = points @ up
    # A foot's sole is level to rounding only; its extent sets what counts as level.
    slack = 1e-6 * max(float(np.ptp(points, axis=0).max()), 1e-6)
    return np.asarray(points[height <= height.min() + slack].mean(axis=0))
