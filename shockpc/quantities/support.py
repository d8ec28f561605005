"""Whether a robot stands over its feet: where its centre of mass is beside their support, and how
fast that changes.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.landing.landing import Landing
from shockpc.method.dynamics import Dynamics
from shockpc.quantities.heights import lowest_points
from shockpc.quantities.quantity import Quantity
from shockpc.robot.bent_legs import ends_leg
from shockpc.robot.elements import Frame
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.geometry import body_outline
from shockpc.robot.robot import Robot

BESIDE = 0.1
"""Distance of the centre of mass from the support of three feet or more, as a share of its height,
up to which they carry it.
"""


class Support(NamedTuple):
    """The centre of mass over the feet, in N postures.

    Attributes:
        beside: (N,) its horizontal distance from the convex hull of the feet, zero inside [m].
        above: (N,) its height above the lowest foot [m].
        away: (N, 2) horizontal direction from the nearest point of the hull to it; zero inside.
        ends: (N, 2) numbers of the two feet between which that point is.
        share: (N,) of the way from the first to the second of them.
    """

    beside: Array
    above: Array
    away: Array
    ends: np.ndarray
    share: Array


@memoized()
def standing_feet(robot: Robot) -> tuple[Frame, ...]:
    """The feet of a robot that end legs; a wheel ends none."""
    return tuple(
        robot.frames[name] for name in each_foot(robot) if ends_leg(robot, name, wheels=False)
    )


def stands(landing: Landing) -> bool:
    """Whether a robot has feet, under a base that is free and that nobody turned, on ground that is
    level.
    """
    posture = landing.scene.posture
    turned = posture.base_rpy_deg is not None or posture.base_quaternion is not None
    return (
        bool(standing_feet(landing.robot))
        and not turned
        and landing.base != "fixed"
        and bool(landing.up[2] >= 1.0 - 1e-9)
    )


def support(landing: Landing, state: Dynamics) -> Support:
    """The centre of mass over the feet, in the postures of a state; in doubles, of a state in balls
    too.
    """
    rotation, position = (
        part.astype(float, copy=False) for part in (state.rotation, state.position)
    )
    state = state._replace(rotation=rotation, position=position)
    feet, places = standing_feet(landing.robot), _places(landing, state)
    com = _centre_of_mass(landing.robot, state)
    low = _lowest_of_feet(landing, state)
    points = places[..., :2]

    # The nearest points of the segments between all feet, (N, k, k, 2).
    start, along = points[:, :, None], points[:, None] - points[:, :, None]
    to_com = com[:, None, None, :2] - start
    share = np.clip(
        np.sum(to_com * along, axis=3) / np.maximum(np.sum(along**2, axis=3), 1e-300), 0.0, 1.0
    )
    away = (to_com - share[..., None] * along).reshape(len(com), -1, 2)
    every = np.arange(len(com))
    nearest = np.linalg.norm(away, axis=2).argmin(axis=1)
    towards = away[every, nearest]

    # The centre of mass is outside where all feet are behind the nearest point.
    behind = np.sum((points - com[:, None, :2]) * towards[:, None], axis=2)
    beside = np.linalg.norm(towards, axis=1) * (behind < 0.0).all(axis=1)
    unit = np.where(
        beside[:, None] > 0.0, towards / np.where(beside > 0.0, beside, 1.0)[:, None], 0.0
    )
    ends = np.stack(np.unravel_index(nearest, (len(feet), len(feet))), axis=1)
    return Support(
        beside, com[:, 2] - low[:, 2], unit, ends, share.reshape(len(com), -1)[every, nearest]
    )


def most_beside(feet: int) -> float:
    """Distance from the support of some feet, as a share of the height, up to which they carry the
    centre of mass.
    """
    return BESIDE if feet > 2 else 1.0


OVERHANG = Quantity(
    "overhang",
    "robot",
    "distance of the centre of mass beside the support, beyond what feet carry",
    "m",
    "neither",
    lambda impact, places: _overhang(impact.landing, support(impact.landing, impact.state))[
        :, None, None
    ],
)
"""At most zero where the feet carry the robot; a constraint can follow it."""


def _overhang(landing: Landing, here: Support) -> Array:
    return np.asarray(here.beside - most_beside(len(standing_feet(landing.robot))) * here.above)


def overhang_rates(landing: Landing, state: Dynamics, twists: Array) -> tuple[Array, Array]:
    """`OVERHANG` (N,) in N postures, and how fast (N, d) it changes.

    The distance d = n · (c − (1 − s) p_i − s p_j) changes as its points move along n; the share s
    is the best one.

    Args:
        landing: names the robot.
        state: the robot in the postures.
        twists: (N, nb, 6, d) of the bodies in d motions, world axes, about the base.
    """
    robot, here = landing.robot, support(landing, state)
    feet, every = standing_feet(robot), np.arange(len(state.Q))
    bodies = np.array([foot.body for foot in feet])
    centres = np.stack([body.com for body in robot.bodies])
    at = state.position + (state.rotation @ centres[..., None])[..., 0]
    com = np.einsum("b,nbxd->nxd", robot.masses / robot.masses.sum(), _velocities(at, twists))
    moved = _velocities(_places(landing, state), twists[:, bodies])
    ends = [moved[every, here.ends[:, k]] for k in (0, 1)]
    nearest = ends[0] + here.share[:, None, None] * (ends[1] - ends[0])
    beside = np.sum(here.away[..., None] * (com - nearest)[:, :2], axis=1)
    low = _lowest_of_feet(landing, state)
    sinking = _velocities(low[:, None, :3], twists[every, low[:, 3].astype(int)][:, None])[:, 0, 2]
    rates = beside - most_beside(len(feet)) * (com[:, 2] - sinking)
    return _overhang(landing, here), np.asarray(rates)


def _velocities(points: Array, twists: Array) -> Array:
    """Velocities (N, k, 3, d) v + ω × p of points (N, k, 3), for twists (N, k, 6, d) about the
    base.
    """
    return np.asarray(twists[..., 3:, :] + np.cross(twists[..., :3, :], points[..., None], axis=2))


def _places(landing: Landing, state: Dynamics) -> Array:
    """The frames (N, k, 3) of the feet, world axes, from the base [m]."""
    feet = standing_feet(landing.robot)
    places = [
        (state.rotation[:, foot.body] @ foot.offset) + state.position[:, foot.body] for foot in feet
    ]
    return np.stack(places, axis=1)


def _centre_of_mass(robot: Robot, state: Dynamics) -> Array:
    """The centre of mass (N, 3) of the robot, world axes, from the base [m]."""
    centres = np.stack([body.com for body in robot.bodies])
    at = state.position + (state.rotation @ centres[..., None])[..., 0]
    return np.asarray(np.einsum("b,nbx->nx", robot.masses / robot.masses.sum(), at))


def _lowest_of_feet(landing: Landing, state: Dynamics) -> Array:
    """The lowest points of the bodies of the feet, and the numbers of these bodies, (N, 4); a foot
    without shapes is a point.
    """
    robot, places = landing.robot, _places(landing, state)
    bodies = [foot.body for foot in standing_feet(robot)]
    low, found = lowest_points(landing, state, bodies), list[Array]()
    of_shape = body_outline(robot).pieces.body
    of_shape = of_shape[np.isin(of_shape, bodies)]
    for k, foot in enumerate(standing_feet(robot)):
        own = of_shape == foot.body
        points = low[:, own] if own.any() else places[:, k : k + 1]
        found.append(
            np.concatenate([points, np.full((*points.shape[:2], 1), float(foot.body))], axis=2)
        )
    points = np.concatenate(found, axis=1)
    return np.asarray(points[np.arange(len(points)), points[..., 2].argmin(axis=1)])
