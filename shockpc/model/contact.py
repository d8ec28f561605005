"""Where a robot touches the ground, and what sticks there: names, offsets and directions → rows of J_c."""

import fnmatch
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.errors import SceneError, UnknownName
from shockpc.model import CHECKED
from shockpc.model.dynamics import Dynamics
from shockpc.model.motion import Motion, spin_before, terms_before, velocity_before
from shockpc.model.rows import Block, moment_block, point_block
from shockpc.robot.geometry import outline
from shockpc.robot.robot import Robot

__all__ = ["Contact", "Touch", "match_frames", "stance_block", "touch", "touch_block", "unit_directions"]

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
        kind: "point" leaves the link free to turn about the contact; "flat" is a sole that also stops it from tilting, and from
            twisting if it sticks.
        restitution: speed after impact over speed before it, along each of these directions [1].
    """

    __pydantic_config__ = CHECKED

    frame: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    at: Literal["frame", "lowest"] = "frame"
    directions: tuple[Literal["x", "y", "z"] | tuple[float, float, float], ...] = ("x", "y", "z")
    kind: Literal["point", "flat"] = "point"
    restitution: float = 0.0

    @property
    def sticks(self) -> bool:
        """Whether its directions span space, so that nothing slides."""
        return bool(np.linalg.matrix_rank(unit_directions(self.frame, self.directions)) == 3)


class Touch(NamedTuple):
    """A contact made numbers.

    Attributes:
        frame: its name.
        body: index of the body that strikes.
        point: (3,) contact point in the body's frame [m].
        directions: (n, 3) unit vectors along which the point is stopped, world axes.
        turns: (m, 3) unit vectors about which the link is stopped, world axes; m = 0 for a point.
        restitution: [1]
    """

    frame: str
    body: int
    point: Array
    directions: Array
    turns: Array
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
    if contact.restitution < 0.0 or contact.restitution > 1.0:
        raise SceneError(
            f'contact "{contact.frame}" has restitution {contact.restitution:g}; '
            "it lies between 0 (stays down) and 1 (bounces fully)"
        )
    vectors = unit_directions(f'contact "{contact.frame}"', contact.directions)
    if not np.any(np.abs(vectors @ up) > 1e-9):
        raise SceneError(
            f'contact "{contact.frame}" keeps only directions along the ground, so nothing stops its fall; '
            f"add the ground's normal ({', '.join(f'{u:g}' for u in up)}) to its directions"
        )
    point = frame.offset + frame.rotation @ np.asarray(contact.offset)
    if contact.at == "lowest":
        point = _lowest_point(robot, contact.frame, rotation[frame.body].T @ up) + frame.rotation @ np.asarray(contact.offset)
    turns = np.zeros((0, 3))
    if contact.kind == "flat":
        twist = [up] if contact.sticks else []
        turns = np.array([*_across(up), *twist])
    return Touch(contact.frame, frame.body, point, vectors, turns, contact.restitution)


def unit_directions(owner: str, directions: tuple[str | tuple[float, float, float], ...]) -> Array:
    """Directions as unit vectors (n, 3); "x", "y" and "z" are the axes.

    Raises:
        SceneError: there is none, or one has no length.
    """
    if not directions:
        raise SceneError(f'{owner} keeps no direction, so nothing stops it; valid are "x", "y", "z" and vectors')
    vectors = np.array([AXES[d] if isinstance(d, str) else d for d in directions], dtype=float)
    lengths = np.linalg.norm(vectors, axis=1)
    if not (np.all(np.isfinite(vectors)) and np.all(lengths > 0.0)):
        raise SceneError(f'{owner} has a direction without a length; valid are "x", "y", "z" and vectors')
    return np.asarray(vectors / lengths[:, None])


def touch_block(state: Dynamics, touch: Touch, before: Motion) -> Block:
    """The rows of a contact, with the speeds (1 + e) · approach that they undo.

    The first three columns of b are strikes of 1 m/s along world x, y and z, the last is the scene's own strike.

    Args:
        state: the robot in N postures.
        touch: the contact.
        before: how the robot moves before the impact.
    """
    W = point_block(state, touch.body, touch.point, touch.directions)
    approach = velocity_before(state, before, touch.body, touch.point) @ touch.directions.T
    unit = np.broadcast_to(touch.directions, (len(state.H), *touch.directions.shape))
    b = (1.0 + touch.restitution) * np.concatenate([unit, approach[..., None]], axis=-1)
    spun, moved = terms_before(state, before, touch.body, touch.point)
    terms = moved @ np.abs(touch.directions).T
    if len(touch.turns):
        W = np.concatenate([W, moment_block(state, touch.body, touch.turns)], axis=1)
        turning = spin_before(state, before, touch.body) @ touch.turns.T
        still = np.zeros((len(state.H), len(touch.turns), 3))
        terms = np.concatenate([terms, spun @ np.abs(touch.turns).T], axis=1)
        b = np.concatenate([b, (1.0 + touch.restitution) * np.concatenate([still, turning[..., None]], axis=-1)], axis=1)
    axes = np.concatenate([touch.directions, touch.turns])
    return Block(f'contact "{touch.frame}"', W, b, (1.0 + touch.restitution) * terms, axes, touch.restitution)


def stance_block(robot: Robot, state: Dynamics, frame: str) -> Block:
    """The rows of a foot that is already down: it stays where it is, whatever strikes elsewhere.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: the frame is fixed to the world.
    """
    found = robot.frame(frame)
    if found.body < 0:
        raise SceneError(f'stance "{frame}" is fixed to the world, so it stands anyway; name a frame on a moving link')
    W = point_block(state, found.body, found.offset, np.eye(3))
    return Block(f'stance "{frame}"', W, np.zeros((len(state.H), 3, 4)), np.zeros((len(state.H), 3)), np.eye(3))


def _across(up: Array) -> tuple[Array, Array]:
    """Two unit vectors that span the ground."""
    first = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    first /= np.linalg.norm(first)
    return first, np.cross(up, first)


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
    points = np.concatenate([shape.lowest(up) for shape in pieces])
    height = points @ up
    # A foot's sole is level to rounding only; its extent sets what counts as level.
    slack = 1e-6 * max(float(np.ptp(points, axis=0).max()), 1e-6)
    return np.asarray(points[height <= height.min() + slack].mean(axis=0))
