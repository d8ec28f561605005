"""Landings of the paper's scenes: as they are, or with one thing changed at a time. Every robot is loaded once."""

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.paper.scenes import find_scene
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene
from shockpc.scene_file import read_scene

__all__ = ["along", "changed", "land", "line_shock", "robot_of", "scene"]


@functools.cache
def scene(stem: str) -> Scene:
    """The scene of a file beside the models."""
    return read_scene(find_scene(stem))


def changed(
    found: Scene,
    joints_deg: Mapping[str, float] | None = None,
    base_pitch_deg: float | None = None,
    strike: Mapping[str, Any] | None = None,
    xacro: Mapping[str, str] | None = None,
    contact: Mapping[str, Any] | None = None,
) -> Scene:
    """A scene with some of it changed; what is not named stays.

    Args:
        found: the scene.
        joints_deg: joints to set [deg].
        base_pitch_deg: of the base about world y [deg].
        strike: fields of the strike; they replace all of it.
        xacro: arguments of the robot's file.
        contact: fields of every contact.
    """
    posture = dataclasses.replace(
        found.posture,
        joints_deg={**found.posture.joints_deg, **(joints_deg or {})},
        base_rpy_deg=found.posture.base_rpy_deg if base_pitch_deg is None else (0.0, base_pitch_deg, 0.0),
    )
    return dataclasses.replace(
        found,
        posture=posture,
        strike=found.strike if strike is None else dataclasses.replace(type(found.strike)(), **strike),
        xacro={**found.xacro, **(xacro or {})},
        contact=tuple(dataclasses.replace(one, **(contact or {})) for one in found.contact),
    )


def land(found: Scene | str) -> ShockProfile:
    """The shock of a scene, or of the scene of that name."""
    found = scene(found) if isinstance(found, str) else found
    return shock_profile(found, robot_of(found))


def robot_of(found: Scene) -> Robot:
    """The robot of a scene."""
    return _robot(found.robot, tuple(sorted(found.xacro.items())))


@functools.cache
def _robot(path: str, xacro: tuple[tuple[str, str], ...]) -> Robot:
    return load_robot(path, xacro=dict(xacro))


def along(profile: ShockProfile, body: str, ends: tuple[Array, Array], count: int = 41) -> Array:
    """Shock (count,) at points evenly spaced along a slender body [1]. Args: ends two points (3,) in its frame [m]."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    return profile.shock_at(body, (1.0 - share) * ends[0] + share * ends[1])


def line_shock(profile: ShockProfile, body: str, ends: tuple[Array, Array]) -> float:
    """Greatest shock on the middle line of a slender body: at one of its ends, for |Δv| is convex [1]."""
    return float(along(profile, body, ends, 2).max())
