"""What is read off a solution: shock over geometry, at sensors and points, and what the ground does at each contact."""

import numpy as np

from shockpc.core.extremes import shock_extremes
from shockpc.core.impulse import Impact
from shockpc.core.spatial import Array, velocity_at
from shockpc.model.contact import Touch
from shockpc.model.dynamics import Dynamics
from shockpc.model.landmarks import sensors
from shockpc.model.outline import outline
from shockpc.model.robot import Robot
from shockpc.record import ContactImpulse, PointShock
from shockpc.scene import Point

__all__ = ["contact_impulses", "point_shocks", "shock_ranges"]


def shock_ranges(robot: Robot, delta_omega: Array, delta_v: Array, v_in: float) -> tuple[Array, Array, tuple[str, ...]]:
    """Least and greatest shock over every body's collision geometry (its visual one, if the file has no collision geometry).

    Args:
        robot: the robot.
        delta_omega: (nb, 3) body axes [rad/s].
        delta_v: (nb, 3) body axes, at the body frame's origin [m/s].
        v_in: speed of the strike [m/s].

    Returns: least (nb,), greatest (nb,) [1], NaN for a body without geometry; warnings.
    """
    kind = "collision" if robot.source.kind == "mjcf" or "<collision" in robot.source.xml else "visual"
    seen = outline(robot, kind)
    least, greatest = np.full(len(robot.bodies), np.nan), np.full(len(robot.bodies), np.nan)
    for i, shapes in enumerate(seen.shapes):
        if shapes:
            found = [shock_extremes(delta_omega[i], delta_v[i], shape.points, shape.radius, v_in) for shape in shapes]
            least[i], greatest[i] = min(low for low, _ in found), max(high for _, high in found)
    return least, greatest, seen.warnings


def point_shocks(
    robot: Robot,
    asked: tuple[Point, ...],
    rotation: Array,
    position: Array,
    delta_omega: Array,
    delta_v: Array,
    v_in: float,
) -> tuple[PointShock, ...]:
    """Shock at the robot's sensors, then at the points asked for.

    Args:
        robot: the robot.
        asked: frames and offsets.
        rotation: (nb, 3, 3) body to world.
        position: (nb, 3) world [m].
        delta_omega: (nb, 3) body axes [rad/s].
        delta_v: (nb, 3) body axes, at the body frame's origin [m/s].
        v_in: speed of the strike [m/s].

    Raises:
        UnknownName: the robot has no frame of that name.
    """
    named = {name: (robot.frames[name], np.zeros(3)) for name in sensors(robot)}
    for point in asked:
        offset = np.asarray(point.offset, dtype=float)
        label = point.frame + (":" + ",".join(f"{x:g}" for x in point.offset) if offset.any() else "")
        named[label] = (robot.frame(point.frame), offset)
    found = []
    for label, (frame, offset) in named.items():
        r = frame.offset + frame.rotation @ offset
        if frame.body < 0:
            found.append(PointShock(label, "world", r, np.zeros(3), 0.0))
            continue
        jump = velocity_at(delta_omega[frame.body], delta_v[frame.body], r)
        world = position[frame.body] + rotation[frame.body] @ r
        name = robot.bodies[frame.body].name
        found.append(PointShock(label, name, world, frame.rotation.T @ jump, float(np.linalg.norm(jump)) / v_in))
    return tuple(found)


def contact_impulses(
    touches: tuple[Touch, ...], impact: Impact, strike: Array, state: Dynamics, up: Array
) -> tuple[tuple[ContactImpulse, ...], tuple[str, ...]]:
    """Impulse at every contact, with a warning where the ground would have to pull.

    Args:
        touches: the contacts.
        impact: solution for unit strikes.
        strike: (3,) velocity of the strike [m/s].
        state: dynamics, first posture.
        up: (3,) unit normal of the ground, world axes.
    """
    contacts, warnings = [], []
    first = 0
    for touch in touches:
        rows = slice(first, first + len(touch.directions))
        first = rows.stop
        point = state.origin[0] + state.position[0, touch.body] + state.rotation[0, touch.body] @ touch.point
        if not impact.unique[0, rows].all():
            contacts.append(ContactImpulse(touch.frame, point, None, None))
            continue
        impulse = (impact.impulse[0, rows] @ strike) @ touch.directions
        normal = float(impulse @ up)
        friction = None
        if normal > 0.0:
            friction = float(np.linalg.norm(impulse - normal * up)) / normal
        else:
            warnings.append(
                f'contact "{touch.frame}" would have to be pulled down by {-normal:.3g} N s to keep to the ground; a real foot lifts '
                "off there, so leave that contact out"
            )
        contacts.append(ContactImpulse(touch.frame, point, impulse, friction))
    return tuple(contacts), tuple(warnings)
