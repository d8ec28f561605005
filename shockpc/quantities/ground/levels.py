"""Heights of a robot's geometry over flat ground.

They tell what of it the ground meets first, and which contacts it touches together.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.landing.feet.soles import LEVEL, most_inside
from shockpc.landing.landing import Landing
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import Dynamics
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import body_outline, shapes_at


class Levels(NamedTuple):
    """Heights of a robot's geometry over its base in N postures [m].

    Attributes:
        core: (N, n) as `surface`, without the smallest semi-axis of the ellipsoid that rounds a
            shape.
        surface: (N, n) the lowest points of the shapes; inf of those of a body that is wholly above
            all contact points, or above another that strikes nothing, unless every body was asked
            for.
        contacts: (N, c) the lowest points of the contacts and standing feet: of their shapes, or
            the contact points.
        of_contact: (c, n) which shapes belong to each of these.
        of_no_contact: (n,) which shapes belong to none.
        inside: how far a contact point may lie above the lowest point of its link.
        tolerance: the scene's, by how much lowest points may differ in height that flat ground
            touches together.
    """

    core: Array
    surface: Array
    contacts: Array
    of_contact: np.ndarray
    of_no_contact: np.ndarray
    inside: float
    tolerance: float

    @property
    def clearance(self) -> Array:
        """Height (N,) of the lowest of the other links above the lowest contact.

        It is below zero under that, and NaN without geometry.
        """
        if not self.of_no_contact.size:
            return np.full(len(self.contacts), np.nan)
        lowest = self.surface.T[self.of_no_contact].min(axis=0, initial=np.inf)
        return np.asarray(lowest - self.contacts.min(axis=1))

    @property
    def depth(self) -> Array:
        """Depth (N,) of the lowest of the other links below the lowest contact.

        It is 0 where it is not below that, and NaN without geometry.
        """
        return np.maximum(-self.clearance, 0.0)

    @property
    def below(self) -> np.ndarray:
        """(N,) bool, True where flat ground meets other links first; never without geometry."""
        return np.asarray(self.depth > self.tolerance)

    @property
    def spread(self) -> Array:
        """Difference in height (N,) of the contacts and standing feet."""
        return np.asarray(np.ptp(self.contacts, axis=1))

    @property
    def uneven(self) -> np.ndarray:
        """(N,) bool, True where flat ground cannot touch all contacts and standing feet."""
        return np.asarray(self.spread > self.tolerance)


def _held(landing: Landing) -> tuple[Constraint, ...]:
    """The contacts and the standing feet."""
    return (*landing.contacts, *landing.stance)


def on_ground(landing: Landing) -> list[int]:
    """Numbers of the contacts and standing feet on flat ground: those whose normal points up."""
    upwards = [held.normal @ landing.up for held in _held(landing)]
    return [k for k, cosine in enumerate(upwards) if cosine > 1.0 - 1e-9]


def without_shapes(landing: Landing, number: int) -> bool:
    """True if the frame of a contact on flat ground has no shapes, but its body has.

    Args:
        landing: the landing.
        number: of the contact or standing foot.
    """
    robot = landing.robot
    frame = robot.frame(_held(landing)[number].frame)
    of_body = body_outline(robot).shapes[frame.body]
    of_frame = shapes_at(robot, frame.name)
    return number in on_ground(landing) and bool(of_body) and not of_frame.any()


def levels(
    landing: Landing, rotation: Array, position: Array, points: Array, every: bool = False
) -> Levels:
    """Heights of the geometry in N postures.

    Args:
        landing: names the contacts and the standing feet.
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) their origins, from the base [m].
        points: (N, c, 3) of the contacts and standing feet on flat ground, from the base [m].
        every: whether every body is measured, or only those that may be the lowest.
    """
    robot = landing.robot
    pieces = body_outline(robot).pieces
    frames = [robot.frame(_held(landing)[k].frame) for k in on_ground(landing)]
    height = points @ landing.up
    below = None if every else height.max(axis=1) + LEVEL
    carriers = {frame.body for frame in frames}
    surface = _lowest_of_shapes(landing, rotation, position, carriers, below)
    core = surface + np.linalg.norm(pieces.rounding, axis=1).min(axis=1)

    # The lowest point of each contact, of its shapes or itself.
    of_contact = np.stack([shapes_at(robot, frame.name) for frame in frames])
    inside = most_inside(robot)
    lowest = height.copy()
    for k, frame in enumerate(frames):
        if of_contact[k].any():
            touching = surface[:, of_contact[k]]
        else:
            # A frame without shapes stands for those of its body in which it may lie, such as a
            # site at the centre of a foot.
            own = pieces.body == frame.body
            around = core[:, own] >= height[:, k, None] - inside
            touching = np.where(around, surface[:, own], np.inf)
        lowest[:, k] = touching.min(axis=1, initial=np.inf)
    return Levels(
        core=core,
        surface=surface,
        contacts=np.minimum(height, lowest),
        of_contact=of_contact,
        of_no_contact=np.logical_not(of_contact.any(axis=0)),
        inside=inside,
        tolerance=landing.scene.ground_tolerance + LEVEL,
    )


def _lowest_of_shapes(
    landing: Landing, rotation: Array, position: Array, carriers: set[int], below: Array | None
) -> Array:
    """Heights (N, n) of the lowest points of the shapes, as `Levels.surface`.

    Bodies are taken from the lowest one upwards, by the boxes around them, until all others lie
    above what is sought.

    Args:
        landing: names the robot and the ground's normal.
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) their origins, from the base [m].
        carriers: the bodies of the contacts, which are measured first.
        below: (N,) height above which no body is measured [m]; None to measure all.
    """
    up = landing.up
    pieces = body_outline(landing.robot).pieces
    surface = np.full((len(pieces.body), len(rotation)), np.inf)
    bodies, boxes = _by_body(landing.robot)

    # Of each body in each posture (nb, N): the ground's normal in its axes, the height of its
    # origin, and that of the lowest corner of the box around it.
    # np.einsum takes five times as long for this product.
    rising = np.tensordot(rotation, up, axes=(2, 0)).transpose(1, 0, 2)
    height = (position @ up).T
    middle = (rising @ boxes.centre[..., None])[..., 0]
    low = height + middle - (np.abs(rising) @ boxes.half[..., None])[..., 0]

    sought = np.full(len(rotation), np.inf) if below is None else below.copy()
    # Contacts come first, because they do not lower what is sought; the lowest bodies next, because
    # they do, which leaves fewer to measure.
    upwards = sorted(bodies, key=lambda group: (group.body not in carriers, low[group.body].sum()))
    for group in upwards:
        body = group.body
        near = np.flatnonzero(low[body] <= sought)
        if not near.size:
            continue
        lowest = height[body, near] - group.reach_down(rising[body, near].T)
        surface[group.numbers[:, None], near] = lowest
        if body not in carriers and below is not None:
            sought[near] = np.minimum(sought[near], lowest.min(axis=0) + LEVEL)
    return surface.T


class _BodyPieces(NamedTuple):
    """The pieces of geometry of one body.

    Attributes:
        body: its index.
        numbers: (n,) of its pieces.
        points: (k, 3) of these pieces, one after the other [m].
        first: (n,) index of the first of these points of each piece.
        axes: (3 n, 3) semi-axes of the ellipsoids that round the pieces, the first of each first;
            (0, 3) where nothing is round [m].
    """

    body: int
    numbers: np.ndarray
    points: Array
    first: np.ndarray
    axes: Array

    def reach_down(self, up: Array) -> Array:
        """How far (n, m) each piece reaches against directions (3, m) from the body's origin [m].

        That is max(corner · −up) + √Σ (a_k · up)², with the axes a_k of its rounding.
        """
        reach = np.maximum.reduceat(self.points @ -up, self.first, axis=0)
        if self.axes.size:
            along = (self.axes @ up).reshape(3, len(self.numbers), -1)
            reach += np.sqrt((along**2).sum(axis=0))
        return np.asarray(reach)


class _Boxes(NamedTuple):
    """Boxes around the pieces of the bodies, in the bodies' frames.

    Attributes:
        centre: (nb, 3) [m].
        half: (nb, 3) half the sides [m].
    """

    centre: Array
    half: Array


@memoized()
def _by_body(robot: Robot) -> tuple[tuple[_BodyPieces, ...], _Boxes]:
    """The pieces of the bodies that have some, and boxes around them."""
    pieces = body_outline(robot).pieces
    boxes = _Boxes(np.zeros((len(robot.bodies), 3)), np.zeros((len(robot.bodies), 3)))
    reach = np.linalg.norm(pieces.rounding, axis=2)[pieces.piece]
    least = pieces.points - reach
    most = pieces.points + reach
    by_body = []
    for body in sorted(set(pieces.body.tolist())):
        numbers = np.flatnonzero(pieces.body == body)
        of_body = pieces.body[pieces.piece] == body
        axes = pieces.rounding[numbers].transpose(2, 0, 1).reshape(-1, 3)
        if not axes.any():
            axes = axes[:0]
        first = pieces.start[numbers] - pieces.start[numbers[0]]
        by_body.append(_BodyPieces(body, numbers, pieces.points[of_body], first, axes))
        low = least[of_body].min(axis=0)
        high = most[of_body].max(axis=0)
        boxes.centre[body] = (low + high) / 2.0
        boxes.half[body] = (high - low) / 2.0
    return tuple(by_body), boxes


def lowest_points_of_shapes(
    landing: Landing, state: Dynamics, bodies: Sequence[int] | None = None
) -> Array:
    """The lowest points (N, n, 3) of the n shapes of bodies, world axes, from the base [m].

    Args:
        landing: names the robot and the ground's normal.
        state: the robot in N postures.
        bodies: some; by default all.
    """
    pieces = body_outline(landing.robot).pieces
    numbers = np.arange(len(pieces.body))
    if bodies is not None:
        numbers = np.flatnonzero(np.isin(pieces.body, bodies))
    body = pieces.body[numbers]
    rounding = pieces.rounding[numbers]
    up = landing.up @ state.rotation

    # The lowest corner of each shape, in the frame of its body.
    low = np.empty((len(state.Q), len(numbers), 3))
    ends = np.append(pieces.start, len(pieces.points))
    for k, piece in enumerate(numbers):
        corners = pieces.points[ends[piece] : ends[piece + 1]]
        lowest = (corners @ up[:, body[k]].T).argmin(axis=0)
        low[:, k] = corners[lowest]

    # From there down to the surface of the ellipsoid E that rounds it: Eᵀ E n / |E n|.
    towards = up[:, body, None] @ rounding
    length = np.linalg.norm(towards, axis=3, keepdims=True)
    unit = towards / np.where(length > 0.0, length, 1.0)
    low -= (unit @ rounding.swapaxes(1, 2))[:, :, 0]
    turned = (state.rotation[:, body] @ low[..., None])[..., 0]
    return np.asarray(state.position[:, body] + turned)
