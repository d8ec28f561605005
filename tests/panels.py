"""Scenes of the robots folder, unchanged or with a few values replaced."""

from dataclasses import replace

from shockpc import read_scene, shock_profile
from shockpc.robot.catalogue import project_robots_folder


def scene(stem):
    """The scene of that name beside the models, such as "fig2_a"."""
    return read_scene(project_robots_folder() / "scenes" / f"{stem}.toml")


def land(start, joints_deg=None, contact=None, **fields):
    """The shock profile of a scene, or of the scene of that name.

    Args:
        start: the scene.
        joints_deg: other joint angles by name [deg].
        contact: other fields of every contact.
        **fields: other fields of the scene.
    """
    start = scene(start) if isinstance(start, str) else start
    angles = {**start.posture.joints_deg, **(joints_deg or {})}
    contacts = tuple(replace(each, **(contact or {})) for each in start.contact)
    posture = replace(start.posture, joints_deg=angles)
    return shock_profile(replace(start, posture=posture, contact=contacts, **fields))
