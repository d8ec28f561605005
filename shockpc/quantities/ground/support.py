"""The centre of mass of a robot over the support of its feet, and how fast it moves beside that."""

from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.landing.landing import Landing
from shockpc.method.dynamics import Dynamics
from shockpc.quantities.ground.levels import lowest_points_of_shapes
from shockpc.quantities.quantity import Places, Quantity
from shockpc.robot.bent_legs import ends_leg
from shockpc.robot.bodies_and_joints import Frame
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import body_outline

BESIDE = 0.1
"""Distance of the centre of mass from a support that carries it, as a share of its height.

It is for three feet or more.
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
    """True if a robot has feet, under a free base that nobody turned, on level ground."""
    posture = landing.scene.posture
    turned = posture.base_rpy_deg is not None or posture.base_quaternion is not None
    if turned or landing.base == "fixed" or not standing_feet(landing.robot):
        return False
    return bool(landing.up[2] >= 1.0 - 1e-9)


def support(landing: Landing, state: Dynamics) -> Support:
    """The centre of mass over the feet, in the postures of a state.

    It is computed in doubles, of a state in balls too.
    """
    state = state._replace(
        rotation=state.rotation.astype(float, copy=False),
        position=state.position.astype(float, copy=False),
    )
    com = centre_of_mass(landing.robot, state)
    low, _ = _lowest_of_feet(landing, state)
    points = places_of_feet(landing, state)[..., :2]
    towards, ends, share = _from_nearest(points, com[:, :2])

    # The centre of mass is outside where all feet are behind the nearest point.
    behind = np.sum((points - com[:, None, :2]) * towards[:, None], axis=2)
    beside = np.linalg.norm(towards, axis=1) * (behind < 0.0).all(axis=1)
    outside = beside[:, None] > 0.0
    length = np.where(outside, beside[:, None], 1.0)
    return Support(
        beside=beside,
        above=com[:, 2] - low[:, 2],
        away=np.where(outside, towards / length, 0.0),
        ends=ends,
        share=share,
    )


def _from_nearest(points: Array, com: Array) -> tuple[Array, np.ndarray, Array]:
    """Vectors (N, 2) to points (N, 2) from the nearest ones of the segments between feet.

    The second and the third value are the ends (N, 2) of the nearest segment, and the share (N,) of
    the way to its second end, as in `Support`.

    Args:
        points: (N, k, 2) of the feet.
        com: (N, 2) the points.
    """
    # The nearest points of all segments, (N, k, k, 2): p_i + s (p_j − p_i) with
    # s = (c − p_i) · (p_j − p_i) / |p_j − p_i|² within [0, 1].
    start = points[:, :, None]
    along = points[:, None] - start
    to_com = com[:, None, None] - start
    # A foot with itself has no length; it is its own nearest point.
    square = np.maximum(np.sum(along**2, axis=3), 1e-300)
    share = np.clip(np.sum(to_com * along, axis=3) / square, 0.0, 1.0)
    away = to_com - share[..., None] * along

    postures, feet, _ = points.shape
    away = away.reshape(postures, -1, 2)
    every = np.arange(postures)
    nearest = np.linalg.norm(away, axis=2).argmin(axis=1)
    ends = np.stack(np.unravel_index(nearest, (feet, feet)), axis=1)
    return away[every, nearest], ends, share.reshape(postures, -1)[every, nearest]


def most_beside(feet: int) -> float:
    """Distance from the support up to which some feet carry the centre of mass.

    It is a share of the height.
    """
    return BESIDE if feet > 2 else 1.0


def _overhang(landing: Landing, over: Support) -> Array:
    """`OVERHANG` (N,) in N postures [m]."""
    feet = len(standing_feet(landing.robot))
    return np.asarray(over.beside - most_beside(feet) * over.above)


def _overhang_of(impact: Impact, places: Places) -> Array:
    """`OVERHANG` (N, 1, 1) in N postures [m]."""
    del places
    over = support(impact.landing, impact.state)
    return _overhang(impact.landing, over)[:, None, None]


OVERHANG = Quantity(
    "overhang",
    "robot",
    "distance of the centre of mass beside the support, beyond what feet carry",
    "m",
    "neither",
    _overhang_of,
)
"""At most zero where the feet carry the robot; a constraint can follow it."""


def overhang_rates(landing: Landing, state: Dynamics, twists: Array) -> tuple[Array, Array]:
    """`OVERHANG` (N,) in N postures, and how fast (N, d) it changes.

    The distance d = n · (c − (1 − s) p_i − s p_j) changes as its points move along n; the share s
    is the best one.

    Args:
        landing: names the robot.
        state: the robot in the postures.
        twists: (N, nb, 6, d) of the bodies in d motions, world axes, about the base.
    """
    robot = landing.robot
    over = support(landing, state)
    feet = standing_feet(robot)
    every = np.arange(len(state.Q))

    # The centre of mass, and the nearest point between two feet.
    velocities = _velocities(_centres(robot, state), twists)
    com = np.einsum("b,nbxd->nxd", robot.masses / robot.masses.sum(), velocities)
    of_feet = twists[:, [foot.body for foot in feet]]
    moving = _velocities(places_of_feet(landing, state), of_feet)
    first = moving[every, over.ends[:, 0]]
    second = moving[every, over.ends[:, 1]]
    nearest = first + over.share[:, None, None] * (second - first)
    beside = np.sum(over.away[..., None] * (com - nearest)[:, :2], axis=1)

    # The lowest point of the feet.
    low, bodies = _lowest_of_feet(landing, state)
    of_lowest = twists[every, bodies][:, None]
    sinking = _velocities(low[:, None], of_lowest)[:, 0, 2]
    rates = beside - most_beside(len(feet)) * (com[:, 2] - sinking)
    return _overhang(landing, over), np.asarray(rates)


def _velocities(points: Array, twists: Array) -> Array:
    """Velocities (N, k, 3, d) v + ω × p of points (N, k, 3).

    Args:
        points: from the base [m].
        twists: (N, k, 6, d) about the base.
    """
    return np.asarray(twists[..., 3:, :] + np.cross(twists[..., :3, :], points[..., None], axis=2))


def places_of_feet(landing: Landing, state: Dynamics) -> Array:
    """The frames (N, k, 3) of the feet, world axes, from the base [m]."""
    frames = []
    for foot in standing_feet(landing.robot):
        turned = state.rotation[:, foot.body] @ foot.offset
        frames.append(turned + state.position[:, foot.body])
    return np.stack(frames, axis=1)


def _centres(robot: Robot, state: Dynamics) -> Array:
    """The centres of mass (N, nb, 3) of the bodies, world axes, from the base [m]."""
    centres = np.stack([body.com for body in robot.bodies])
    return np.asarray(state.position + (state.rotation @ centres[..., None])[..., 0])


def centre_of_mass(robot: Robot, state: Dynamics) -> Array:
    """The centre of mass (N, 3) of the robot, world axes, from the base [m]."""
    shares = robot.masses / robot.masses.sum()
    return np.asarray(np.einsum("b,nbx->nx", shares, _centres(robot, state)))


def _lowest_of_feet(landing: Landing, state: Dynamics) -> tuple[Array, np.ndarray]:
    """The lowest points (N, 3) of the bodies of the feet, and the indices (N,) of these bodies.

    A foot without shapes is a point.
    """
    feet = standing_feet(landing.robot)
    frames = places_of_feet(landing, state)
    of_feet = [foot.body for foot in feet]
    low = lowest_points_of_shapes(landing, state, of_feet)
    of_shapes = body_outline(landing.robot).pieces.body
    of_shapes = of_shapes[np.isin(of_shapes, of_feet)]
    points = []
    bodies = list[int]()
    for k, foot in enumerate(feet):
        own = of_shapes == foot.body
        points.append(low[:, own] if own.any() else frames[:, k : k + 1])
        bodies += [foot.body] * points[-1].shape[1]
    among = np.concatenate(points, axis=1)
    lowest = among[..., 2].argmin(axis=1)
    every = np.arange(len(among))
    return among[every, lowest], np.array(bodies)[lowest]
