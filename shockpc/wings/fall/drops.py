"""The strikes of a robot that is dropped in several attitudes."""

import math
from collections.abc import Iterator

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.wings.fall.body import UP, Rigid, tilt
from shockpc.wings.fall.strikes import FallStrike, near_links, with_pressing_contacts

SIDES = (("back", "", "front"), ("right", "", "left"), ("bottom", "", "top"))
"""Names of the sides of the box around the robot, along x, y and z."""


def drops(
    rigid: Rigid, posture: str, height: float, count: int | None, together: float
) -> Iterator[FallStrike]:
    """The strikes of drops in all attitudes.

    Args:
        rigid: the robot.
        posture: its name.
        height: of the drop [m].
        count: of attitudes spread over all orientations; None for those of the box around it.
        together: height within which parts strike together [m].
    """
    speed = math.sqrt(2.0 * GRAVITY * height)
    attitudes = _box_attitudes(rigid) if count is None else _spread(count)
    for name, down in attitudes.items():
        attitude = _turned_down(down)
        points, links = rigid.on_ground(attitude, together)
        spots = rigid.spots(attitude, points, links)
        strike = FallStrike(
            fall=f"{posture} {name}".strip(),
            number=1,
            struck={spot.link: speed for spot in spots},
            near=near_links(rigid, attitude, links, together),
            motion="is in the air",
            rotation=0.0,
            rate=0.0,
            energy=0.5 * rigid.mass * speed**2,
            scene=rigid.scene(attitude, -speed * UP, np.zeros(3), spots, ()),
        )
        yield with_pressing_contacts(strike, rigid.landing.robot)


def _turned_down(direction: Array) -> Array:
    """The rotation (3, 3), about a level axis, after which a unit vector points down."""
    level = np.linalg.norm(direction[:2])
    forward = np.array([0.0, -1.0, 0.0])
    if level > 1e-12:
        forward = np.append(direction[:2], 0.0) / level
    return tilt(forward, math.atan2(level, -direction[2]))


def _box_attitudes(rigid: Rigid) -> dict[str, Array]:
    """Unit vectors (3,) from the centre of mass to the box around the posture, by name.

    They point to its faces, edges and corners.
    """
    points, _ = rigid.points(np.vstack([np.eye(3), -np.eye(3)]))
    low = points.min(axis=0) - rigid.com
    high = points.max(axis=0) - rigid.com
    sides = np.array([low, np.zeros(3), high])
    kinds = {1: "face", 2: "edge", 3: "corner"}
    by_kind: dict[str, dict[str, Array]] = {kind: {} for kind in kinds.values()}
    # Along each axis a point is on the low side, in the middle or on the high side.
    for signs in np.ndindex(3, 3, 3):
        on_sides = sum(sign != 1 for sign in signs)
        if not on_sides:
            continue
        point = sides[signs, range(3)]
        names = [SIDES[axis][sign] for axis, sign in enumerate(signs) if sign != 1]
        name = f"{kinds[on_sides]} {'-'.join(names)}"
        by_kind[kinds[on_sides]][name] = point / np.linalg.norm(point)
    return by_kind["face"] | by_kind["edge"] | by_kind["corner"]


def _spread(count: int) -> dict[str, Array]:
    """Unit vectors (3,) spread evenly over the sphere along a spiral.

    Rotation about the vertical does not matter.
    """
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle = math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    attitudes: dict[str, Array] = {}
    for i in range(count):
        direction = [r[i] * math.cos(angle[i]), r[i] * math.sin(angle[i]), z[i]]
        attitudes[f"attitude {i + 1}"] = np.array(direction)
    return attitudes
