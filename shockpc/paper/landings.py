"""Landings of the paper's scenes, unchanged or with a few values replaced. Every robot is loaded once."""

import functools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.catalogue import own_robots_folder
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene, Strike, read_scene

__all__ = ["along", "changed", "land", "largest", "middle_lines", "robot_of", "scene"]

ORIGIN, X, Z = np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
SEGMENT = (-0.4 * Z, ORIGIN)
MIDDLE_LINES: dict[str, dict[str, tuple[Array, Array]]] = {
    "beam": {"beam": (ORIGIN, X)},
    "leg": {"foot": (-0.2 * Z, ORIGIN), "lower_leg": SEGMENT, "upper_leg": SEGMENT, "torso": (ORIGIN, 1.5 * 0.4 * Z)},
    "skippy": {"torso": (ORIGIN, 0.6 * Z)},
    "quadruped": {"hind_lower_leg": SEGMENT, "hind_upper_leg": SEGMENT, "torso": (-0.4 * X, 0.4 * X)},
}
"""Ends (3,) of the middle lines of slender bodies by robot, in their frames [m]: bodies from the ground up, lower end first."""

NOTHING: Mapping[str, Any] = {}


@functools.cache
def scene(stem: str) -> Scene:
    """The scene of that name beside the models, such as "fig2_a"."""
    return read_scene(own_robots_folder() / "scenes" / f"{stem}.toml")


def changed(
    found: Scene,
    joints_deg: Mapping[str, float] = NOTHING,
    base_pitch_deg: float | None = None,
    strike: Mapping[str, Any] = NOTHING,
    xacro: Mapping[str, str] = NOTHING,
    contact: Mapping[str, Any] = NOTHING,
) -> Scene:
    """A scene with other joint angles, pitch of the base [deg], strike, xacro arguments, or fields of every contact."""
    rpy = found.posture.base_rpy_deg if base_pitch_deg is None else (0.0, base_pitch_deg, 0.0)
    return replace(
        found,
        posture=replace(found.posture, joints_deg={**found.posture.joints_deg, **joints_deg}, base_rpy_deg=rpy),
        strike=Strike(**strike) if strike else found.strike,
        xacro={**found.xacro, **xacro},
        contact=tuple(replace(one, **contact) for one in found.contact),
    )


def land(found: Scene | str) -> ShockProfile:
    """The shock profile of a scene, or of the scene of that name."""
    found = scene(found) if isinstance(found, str) else found
    return shock_profile(found, robot_of(found))


def robot_of(found: Scene) -> Robot:
    """The robot of a scene."""
    return _robot(found.robot, tuple(sorted(found.xacro.items())))


@functools.cache
def _robot(path: str, xacro: tuple[tuple[str, str], ...]) -> Robot:
    return load_robot(path, xacro=dict(xacro))


def middle_lines(profile: ShockProfile) -> dict[str, tuple[Array, Array]]:
    """The ends of the middle lines of the bodies that this landing has, from the ground up."""
    return {body: line for body, line in MIDDLE_LINES[profile.robot.name].items() if body in profile.bodies}


def along(profile: ShockProfile, body: str, count: int = 41) -> Array:
    """Shock (count,) at evenly spaced points of a body's middle line, from its lower end [1]."""
    (low, high), share = MIDDLE_LINES[profile.robot.name][body], np.linspace(0.0, 1.0, count)[:, None]
    return profile.shock_at(body, (1.0 - share) * low + share * high)


def largest(profile: ShockProfile) -> dict[str, float]:
    """Largest shock on every middle line [1]; it occurs at an end, because |Δv| is convex."""
    return {body: float(along(profile, body, 2).max()) for body in middle_lines(profile)}
