"""Heights of a robot's geometry over flat ground: what of it the ground meets first, and which
contacts it touches together.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.landing.landing import Landing
from shockpc.landing.places import Place
from shockpc.landing.soles import LEVEL, most_inside
from shockpc.method.constraints import ConstraintBlock, block_point, wrenches
from shockpc.method.dynamics import Dynamics
from shockpc.quantities.quantity import Quantity
from shockpc.robot.geometry import body_outline, shapes_at
from shockpc.robot.robot import Robot


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
        others: (n,) which shapes belong to none.
        inside: how far a contact point may lie above the lowest point of its link.
        tolerance: the scene's, by how much lowest points may differ in height that flat ground
            touches together.
    """

    core: Array
    surface: Array
    contacts: Array
    of_contact: np.ndarray
    others: np.ndarray
    inside: float
    tolerance: float

    @property
    def clearance(self) -> Array:
        """Height (N,) of the lowest of the other links above the lowest contact, below zero under
        it; NaN without geometry.
        """
        if not self.others.size:
            return np.full(len(self.contacts), np.nan)
        return np.asarray(
            self.surface.T[self.others].min(axis=0, initial=np.inf) - self.contacts.min(axis=1)
        )

    @property
    def depth(self) -> Array:
        """How far (N,) other links reach below the lowest contact, 0 where they do not; NaN without
        geometry.
        """
        return np.maximum(-self.clearance, 0.0)

    @property
    def below(self) -> np.ndarray:
        """Whether (N,) other links are so far below the contacts that flat ground meets them first;
        never without geometry.
        """
        return np.asarray(self.depth > self.tolerance)

    @property
    def spread(self) -> Array:
        """Difference in height (N,) of the contacts and standing feet."""
        return np.asarray(np.ptp(self.contacts, axis=1))

    @property
    def uneven(self) -> np.ndarray:
        """Whether (N,) the contacts and standing feet differ so much in height that flat ground
        cannot touch all of them.
        """
        return np.asarray(self.spread > self.tolerance)


def on_ground(landing: Landing) -> list[int]:
    """Numbers of the contacts and standing feet on flat ground: those that have the normal of the
    first.
    """
    return [
        k
        for k, block in enumerate((*landing.contacts, *landing.stance))
        if block.normal @ landing.up > 1.0 - 1e-9
    ]


def without_shapes(landing: Landing, number: int) -> bool:
    """Whether the frame of a contact or standing foot on flat ground has no shapes, but its body
    has. Args: number, its number.
    """
    robot, frame = (
        landing.robot,
        landing.robot.frame((*landing.contacts, *landing.stance)[number].frame),
    )
    return (
        number in on_ground(landing)
        and bool(body_outline(robot).shapes[frame.body])
        and not shapes_at(robot, frame.name).any()
    )


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
    up, pieces, grounded = (
        landing.up,
        body_outline(landing.robot).pieces,
        (*landing.contacts, *landing.stance),
    )
    frames = [landing.robot.frame(grounded[k].frame) for k in on_ground(landing)]
    height = points @ up
    below = None if every else height.max(axis=1) + LEVEL
    surface = _lowest_of_shapes(
        landing, rotation, position, {frame.body for frame in frames}, below
    )
    core = surface + np.linalg.norm(pieces.rounding, axis=1).min(axis=1)
    struck, inside = (
        np.stack([shapes_at(landing.robot, frame.name) for frame in frames]),
        most_inside(landing.robot),
    )
    contacts = height.copy()
    for k, (frame, of_contact) in enumerate(zip(frames, struck, strict=True)):
        if of_contact.any():
            touching = surface[:, of_contact]
        else:
            # A frame without shapes stands for those of its body in which it may lie, such as a
            # site at the centre of a foot.
            body = pieces.body == frame.body
            touching = np.where(
                core[:, body] >= height[:, k, None] - inside, surface[:, body], np.inf
            )
        contacts[:, k] = touching.min(axis=1, initial=np.inf)
    lowest, others = np.minimum(height, contacts), np.logical_not(struck.any(axis=0))
    return Levels(
        core, surface, lowest, struck, others, inside, landing.scene.ground_tolerance + LEVEL
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
    up, start = landing.up, body_outline(landing.robot).pieces.start
    surface = np.full((len(start), len(rotation)), np.inf)
    bodies, centre, half = _by_body(landing.robot)
    # np.einsum takes five times as long for this product.
    rising, height = np.tensordot(rotation, up, axes=(2, 0)).transpose(1, 0, 2), (position @ up).T
    low = height + (rising @ centre[..., None])[..., 0] - (np.abs(rising) @ half[..., None])[..., 0]
    sought = np.full(len(rotation), np.inf) if below is None else below.copy()
    for body, n, corners, axes in sorted(
        bodies, key=lambda entry: (entry[0] not in carriers, low[entry[0]].sum())
    ):
        near = np.flatnonzero(low[body] <= sought)
        if near.size:
            towards = rising[body, near].T
            reach = np.maximum.reduceat(corners @ -towards, start[n] - start[n[0]], axis=0)
            if axes.size:
                reach += np.sqrt(((axes @ towards) ** 2).reshape(3, len(n), -1).sum(axis=0))
            surface[n[:, None], near] = reached = height[body, near] - reach
            if body not in carriers and below is not None:
                sought[near] = np.minimum(sought[near], reached.min(axis=0) + LEVEL)
    return surface.T


def _relative(
    landing: Landing, state: Dynamics, blocks: Sequence[ConstraintBlock], places: Sequence[Place]
) -> tuple[Levels, Array]:
    """Heights in N postures: all; and (N, 1 + n) `SPREAD`, and `CLEARANCE` of n bodies, inf of one
    without other shapes.
    """
    here = levels(
        landing,
        state.rotation,
        state.position,
        _grounded_points(landing, state, blocks),
        every=True,
    )
    bodies, low = body_outline(landing.robot).pieces.body, here.contacts.min(axis=1)
    shapes = (here.surface[:, here.others & (bodies == place.body)] for place in places)
    return here, np.stack(
        [here.spread, *(heights.min(axis=1, initial=np.inf) - low for heights in shapes)], axis=1
    )


def _grounded_points(landing: Landing, state: Dynamics, blocks: Sequence[ConstraintBlock]) -> Array:
    """Points (N, c, 3) of the contacts and standing feet on flat ground, from the base [m]."""
    return np.stack([block_point(state, blocks[k]) for k in on_ground(landing)], axis=1)


SPREAD = Quantity(
    "spread",
    "robot",
    "difference in height of the contacts",
    "m",
    "neither",
    lambda impact, places: _relative(impact.landing, impact.state, impact.blocks, places)[1][
        :, None, :1
    ],
)
CLEARANCE = Quantity(
    "clearance",
    "body",
    "height of the body above the lowest contact",
    "m",
    "neither",
    lambda impact, places: _relative(impact.landing, impact.state, impact.blocks, places)[1][
        :, None, 1:
    ],
)
REACH = Quantity(
    "reach",
    "contact",
    "height of the link's lowest point above the contact",
    "m",
    "neither",
    lambda impact, places: _reach(impact.landing, impact.state, impact.blocks, places)[0][:, None],
)
HEIGHTS = (SPREAD, CLEARANCE, REACH)
"""What `feasible` decides by, as numbers that a constraint can follow: they have either sign."""


def _reach(
    landing: Landing, state: Dynamics, blocks: Sequence[ConstraintBlock], places: Sequence[Place]
) -> tuple[Array, np.ndarray]:
    """`REACH` of n contacts without shapes in N postures, (N, n), and which shape (N, n) of the
    body is the lowest.

    Where it is less than a contact point may lie inside, the shape does not count as that of the
    contact, and `CLEARANCE` jumps.
    """
    here = levels(
        landing,
        state.rotation,
        state.position,
        _grounded_points(landing, state, blocks),
        every=True,
    )
    bodies, contacts = (
        body_outline(landing.robot).pieces.body,
        [blocks[place.number] for place in places],
    )
    core = np.stack(
        [np.where(here.others & (bodies == block.body), here.core, np.inf) for block in contacts],
        axis=1,
    )
    heights = np.stack([block_point(state, block) @ landing.up for block in contacts], axis=1)
    return core.min(axis=2) - heights, core.argmin(axis=2)


def reach_rates(
    landing: Landing,
    state: Dynamics,
    blocks: Sequence[ConstraintBlock],
    twists: Array,
    places: Sequence[Place],
) -> tuple[Array, Array]:
    """`REACH` of n contacts, (N, n) in N postures, and how fast (N, n, d) it changes.

    Args: as for `height_rates`.
    """
    values, lowest = _reach(landing, state, blocks, places)
    low = np.take_along_axis(lowest_points(landing, state), lowest[..., None], axis=1)
    arms = low - np.stack([block_point(state, blocks[place.number]) for place in places], axis=1)
    # Both points turn with the body.
    turning = twists[:, [blocks[place.number].body for place in places], :3]
    return values, (np.cross(arms, landing.up)[:, :, None] @ turning)[:, :, 0]


def height_rates(
    landing: Landing,
    state: Dynamics,
    blocks: Sequence[ConstraintBlock],
    twists: Array,
    places: Sequence[Place],
) -> tuple[Array, Array]:
    """`SPREAD`, and `CLEARANCE` of bodies, (N, 1 + n) in N postures, and how fast (N, 1 + n, d)
    they change.

    Spread and clearance change as the lowest points rise: each at ω · (p × n) + v · n, with the
    ground's normal n. Which points are the lowest changes at kinks.

    Args:
        landing: names the contacts and the standing feet.
        state: the robot in the postures.
        blocks: the rows of the contacts, then of the standing feet.
        twists: (N, nb, 6, d) of the bodies in d motions, world axes, about the base.
        places: the n bodies; the clearance of a place that is none is infinite.
    """
    here, values = _relative(landing, state, blocks, places)
    grounded = [blocks[k].body for k in on_ground(landing)]
    points = np.concatenate(
        [lowest_points(landing, state), _grounded_points(landing, state, blocks)], axis=1
    )
    heights, bodies = (
        points @ landing.up,
        np.append(body_outline(landing.robot).pieces.body, grounded),
    )
    # The lowest point of a contact is that of one of the link's shapes, or the contact point.
    sought = here.contacts.min(axis=1)[:, None] + np.insert(values, 0, 0.0, axis=1)
    among = np.array([bodies >= 0, bodies >= 0, *(bodies == place.body for place in places)])
    chosen = np.where(among, np.abs(heights[:, None] - sought[..., None]), np.inf).argmin(axis=2)
    pushes = wrenches(
        np.take_along_axis(points, chosen[..., None], axis=1),
        np.broadcast_to(landing.up, (*chosen.shape, 1, 3)),
        1,
    )
    rates = (pushes @ twists[np.arange(len(twists))[:, None], bodies[chosen]])[:, :, 0]
    return values, rates[:, 1:] - rates[:, :1]


def lowest_points(landing: Landing, state: Dynamics, bodies: Sequence[int] | None = None) -> Array:
    """The lowest points (N, n, 3) of the shapes of all bodies, or of some, world axes, from the
    base [m].
    """
    pieces = body_outline(landing.robot).pieces
    chosen = (
        np.arange(len(pieces.body))
        if bodies is None
        else np.flatnonzero(np.isin(pieces.body, bodies))
    )
    body, rounding = pieces.body[chosen], pieces.rounding[chosen]
    up, low = landing.up @ state.rotation, np.empty((len(state.Q), len(chosen), 3))
    ends = np.append(pieces.start, len(pieces.points))
    for k, piece in enumerate(chosen):
        corners = pieces.points[ends[piece] : ends[piece + 1]]
        low[:, k] = corners[(corners @ up[:, body[k]].T).argmin(axis=0)]
    towards = up[:, body, None] @ rounding
    length = np.linalg.norm(towards, axis=3, keepdims=True)
    low -= (towards / np.where(length > 0.0, length, 1.0) @ rounding.swapaxes(1, 2))[:, :, 0]
    return np.asarray(state.position[:, body] + (state.rotation[:, body] @ low[..., None])[..., 0])


@memoized()
def _by_body(robot: Robot) -> tuple[tuple[tuple[int, np.ndarray, Array, Array], ...], Array, Array]:
    """The pieces of the bodies that have some, and boxes around them.

    Returns: of each the body, its n pieces, their points (k, 3) and semi-axes (3n, 3), the first of
        each first, or (0, 3) where nothing is round; centres (nb, 3) and half the sides (nb, 3) of
        the boxes, in the bodies' frames [m].
    """
    pieces, found, centre, half = (
        body_outline(robot).pieces,
        [],
        *np.zeros((2, len(robot.bodies), 3)),
    )
    reach = np.linalg.norm(pieces.rounding, axis=2)[pieces.piece]
    for body in sorted(set(pieces.body.tolist())):
        n, of_body = np.flatnonzero(pieces.body == body), pieces.body[pieces.piece] == body
        axes = pieces.rounding[n].transpose(2, 0, 1).reshape(-1, 3)
        found.append((body, n, pieces.points[of_body], axes if axes.any() else axes[:0]))
        low, high = (
            (pieces.points - reach)[of_body].min(axis=0),
            (pieces.points + reach)[of_body].max(axis=0),
        )
        centre[body], half[body] = (low + high) / 2.0, (high - low) / 2.0
    return tuple(found), centre, half
