"""Landings of the paper's scenes, unchanged or with a few values replaced."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from shockpc import Scene, ShockProfile, read_scene, shock_profile
from shockpc.core.spatial import Array
from shockpc.robot.catalogue import project_robots_folder

ORIGIN, X, Z = np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
SEGMENT = (-0.4 * Z, ORIGIN)
MIDDLE_LINES: dict[str, dict[str, tuple[Array, Array]]] = {
    "beam": {"beam": (ORIGIN, X)},
    "leg": {
        "foot": (-0.2 * Z, ORIGIN),
        "lower_leg": SEGMENT,
        "upper_leg": SEGMENT,
        "torso": (ORIGIN, 1.5 * 0.4 * Z),
    },
    "skippy": {"torso": (ORIGIN, 0.6 * Z)},
    "quadruped": {
        "hind_lower_leg": SEGMENT,
        "hind_upper_leg": SEGMENT,
        "torso": (-0.4 * X, 0.4 * X),
    },
}
"""Ends (3,) of the middle lines of slender bodies by robot, in their frames [m].

The bodies are listed from the ground up, the lower end of each first.
"""


def scene(stem: str) -> Scene:
    """The scene of that name beside the models, such as "fig2_a"."""
    return read_scene(project_robots_folder() / "scenes" / f"{stem}.toml")


def land(
    start: Scene | str,
    joints_deg: Mapping[str, float] = {},
    pitch_deg: float | None = None,
    xacro: Mapping[str, str] = {},
    contact: Mapping[str, Any] = {},
    **fields: Any,
) -> ShockProfile:
    """The shock profile of a scene, or of the scene of that name.

    Args:
        start: the scene.
        joints_deg: other joint angles by name [deg].
        pitch_deg: another pitch of the base [deg].
        xacro: other arguments of the robot's file.
        contact: other fields of every contact.
        **fields: other fields of the scene.
    """
    start = scene(start) if isinstance(start, str) else start
    rpy = start.posture.base_rpy_deg if pitch_deg is None else (0.0, pitch_deg, 0.0)
    changed = replace(
        start,
        posture=replace(
            start.posture, joints_deg={**start.posture.joints_deg, **joints_deg}, base_rpy_deg=rpy
        ),
        xacro={**start.xacro, **xacro},
        contact=tuple(replace(struck, **contact) for struck in start.contact),
        **fields,
    )
    return shock_profile(changed)


def middle_lines(profile: ShockProfile) -> dict[str, tuple[Array, Array]]:
    """The ends of the middle lines of the bodies that this landing has, from the ground up."""
    return {
        body: line
        for body, line in MIDDLE_LINES[profile.robot.name].items()
        if body in profile.bodies
    }


def shock_along(profile: ShockProfile, body: str, count: int = 41) -> Array:
    """Shock (count,) at evenly spaced points of a body's middle line, from its lower end [1]."""
    return profile.shock_at(body, np.linspace(*middle_lines(profile)[body], count))


def largest(profile: ShockProfile) -> dict[str, float]:
    """Largest shock on every middle line [1]; it occurs at an end, because |Δv| is convex."""
    return {body: float(shock_along(profile, body, 2).max()) for body in middle_lines(profile)}
