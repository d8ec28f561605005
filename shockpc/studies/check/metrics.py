"""What a budget can limit, and where: each metric belongs to points, bodies, joints or contacts of a robot."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.pulse import peak_acceleration
from shockpc.errors import StudyError
from shockpc.landing import Landing, pulse_of
from shockpc.printed import printable
from shockpc.result import ShockProfile
from shockpc.robot.landmarks import sensors
from shockpc.robot.record import Robot
from shockpc.scene import GRAVITY, Point, Scene, points_at

__all__ = ["METRICS", "Metric", "MetricName", "Place", "measure", "places", "with_points"]

MetricName = Literal["shock", "shock_max", "peak_g", "ropc", "joint_impulse", "friction_needed", "effective_mass"]


class Metric(NamedTuple):
    """A number of a landing.

    Attributes:
        place: what it belongs to: a point, a body, a joint or a contact.
        unit: of its value; 1 if it has none.
        worse: which change makes a design worse.
    """

    place: Literal["point", "body", "joint", "contact"]
    unit: str
    worse: Literal["greater", "less"]


METRICS: dict[str, Metric] = {
    "shock": Metric("point", "1", "greater"),  # |Δv| relative to the strike
    "shock_max": Metric("body", "1", "greater"),  # greatest shock over the geometry
    "peak_g": Metric("point", "g", "greater"),  # peak acceleration for the scene's pulse
    "ropc": Metric("body", "m", "less"),  # radius of percussion
    "joint_impulse": Metric("joint", "N s", "greater"),  # magnitude of the impulse through the joint
    "friction_needed": Metric("contact", "1", "greater"),  # tangential over normal impulse
    "effective_mass": Metric("contact", "kg", "greater"),  # along the ground's normal
}
"""The metrics by their names in a file."""


class Place(NamedTuple):
    """Where a metric is taken.

    Attributes:
        name: as tables and the baseline show it.
        body: index of a body; −1 for a point, a joint or a contact.
        point: the point, if it is one.
    """

    name: str
    body: int = -1
    point: Point | None = None


def places(landing: Landing, metric: str, at: str) -> tuple[Place, ...]:
    """The places that a name or a glob means.

    A body means its centre of mass where a point is needed; a link that is fixed to another body means that body where a body is
    needed.

    Args:
        landing: the landing.
        metric: key of `METRICS`.
        at: an exact name, a glob, or FRAME:x,y,z for a point with an offset in the frame [m].

    Raises:
        UnknownName: nothing fits; the text names the nearest.
        StudyError: the place has no such number.
    """
    robot, scene = landing.robot, landing.scene
    bodies = [body.name for body in robot.bodies]
    if metric == "peak_g" and scene.pulse is None:
        raise StudyError('peak_g needs the duration of the impact, and the scene has none; give it a pulse = "half-sine:5ms"')
    match METRICS[metric].place:
        case "joint":
            return tuple(Place(name) for name in robot.match_joints(at))
        case "contact":
            struck = [contact.frame for contact in scene.contact]
            known = struck if metric == "effective_mass" else [*struck, *scene.stance]
            return tuple(Place(name) for name in robot.match("contact", at, known))
        case "body":
            carried = f" (carries {at})" if at in robot.frames and at not in bodies else ""
            return tuple(Place(bodies[i] + carried, i) for i in robot.match_bodies(at))
        case "point":
            return tuple(
                Place(f"{one} (centre of mass)", bodies.index(one)) if isinstance(one, str) else _point(robot, one)
                for one in _points(robot, scene, at, bodies)
            )


def with_points(scene: Scene, found: Iterable[Place]) -> Scene:
    """The scene with the points of some places."""
    return replace(scene, point=(*scene.point, *dict.fromkeys(place.point for place in found if place.point is not None)))


def measure(profile: ShockProfile, metric: str, place: Place) -> tuple[float | None, str]:
    """The value of a metric, or None and the reason why there is none.

    Args:
        profile: of a scene that has the points of the place.
        metric: key of `METRICS`.
        place: one of those that `places` found for it.
    """
    match metric:
        case "shock" | "peak_g":
            return _at_point(profile, metric, place), ""
        case "shock_max":
            value = float(profile.shock_max[place.body])
            return (
                (None, "the body has no geometry to take the greatest shock over; limit its shock at a point instead")
                if np.isnan(value)
                else (value, "")
            )
        case "ropc":
            return float(profile.ropc[place.body]), ""
        case "joint_impulse":
            if len(profile.choice.rows) < len(profile.proof.impulse):
                return None, "contacts or loops are redundant, so the impulse through a joint is not determined"
            load = next(load for load in profile.loads if load.joint == place.name)
            return float(np.linalg.norm(load.force)), ""
        case "friction_needed":
            both = [(one.frame, one.impulse, one.friction_needed) for one in profile.contacts]
            both += [(one.frame, one.impulse, one.friction_needed) for one in profile.stance]
            impulse, friction = next((impulse, friction) for frame, impulse, friction in both if frame == place.name)
            if impulse is None:
                return None, "contacts are redundant, so the impulse of a single one is not determined"
            return friction, "" if friction is not None else "the contact receives no impulse, or the ground would have to pull it"
        case _:
            k = [contact.frame for contact in profile.contacts].index(place.name)
            contact = profile.contacts[k]
            return (contact.mass_sticking if profile.scene.contact[k].sticks else contact.mass_frictionless), ""


def _at_point(profile: ShockProfile, metric: str, place: Place) -> float | None:
    """Shock or peak acceleration at a point, or at a body's centre of mass."""
    if place.point is not None:
        point = next(point for point in profile.points if point.frame == place.name)
        return point.shock if metric == "shock" else point.peak_g
    shock, pulse = float(profile.shock_com[place.body]), pulse_of(profile.scene)
    if metric == "shock":
        return shock
    return None if pulse is None else peak_acceleration(shock * profile.v_in, pulse) / GRAVITY


def _points(robot: Robot, scene: Scene, at: str, bodies: list[str]) -> list[str | Point]:
    """The names of bodies and the points that a name, a glob or FRAME:x,y,z means."""
    listed = {name: Point(frame=name) for name in sensors(robot)} | {point.label: point for point in scene.point}
    if at in bodies or at in listed:
        return [at if at in bodies else listed[at]]
    if at in robot.frames:
        return [Point(frame=at)]
    frame, colon, _ = at.rpartition(":")
    if colon and frame in robot.frames:
        return [*points_at(robot, at)]
    names = robot.match("point or body", at, [*bodies, *listed], robot.frames)
    return [name if name in bodies else listed[name] for name in names]


def _point(robot: Robot, point: Point) -> Place:
    """A point as a place."""
    if robot.frame(point.frame).body < 0:
        raise StudyError(
            f'"{printable(point.frame)}" is fixed to the world, so no impact moves it; choose a point on a moving link'
        )
    return Place(point.label, -1, point)
