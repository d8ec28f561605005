"""The scene in words, the same in tables and figures: robot, posture, base, contacts, strike, joint model and plane."""

import math
from collections.abc import Iterable, Mapping

import numpy as np

from shockpc.model.columns import Base
from shockpc.printed import few, printable
from shockpc.result import ShockProfile
from shockpc.robot.robot import WORLD, Robot

__all__ = [
    "angle_text",
    "base_text",
    "bodies_text",
    "contact_name",
    "count",
    "header_lines",
    "joint_model_text",
    "posture_text",
    "strike_text",
]

JOINT_MODELS = {
    "free": "free (zero reflected inertia; a stiff gearbox changes the results considerably)",
    "geared": "geared (every joint has the reflected inertia of its drive)",
    "locked": "locked (no joint moves, so the robot is one rigid body)",
    "mixed": "mixed (some joints have reflected inertia or are locked, the others are free)",
}
BASES = {
    "free": "falls freely; --base planar or --base fixed restrains it",
    "planar": "moves in the plane only; --base free releases it",
    "fixed": "fixed to the world; --base free releases it",
    "world": f'fixed to the world, because its root link is called "{WORLD}"; --base free releases it',
    "file": "fixed in the file; a <freejoint/> in its root body releases it",
}
PLANES = {"xz": "xz (sagittal)", "yz": "yz (frontal)", "xy": "xy (from above)"}


def header_lines(profile: ShockProfile) -> list[tuple[str, str]]:
    """What was computed, one line for each part of the scene; (name, text)."""
    robot, scene = profile.robot, profile.scene
    xacro = "".join(f", {name}:={value}" for name, value in scene.xacro.items())
    normalised = f"; shock relative to {profile.v_in:.4g} m/s of the centre of mass" if scene.v_in == "com" else ""
    lines = {
        "robot": f"{robot.label} ({robot.name}, {robot.mass:.4g} kg, {bodies_text(robot)}{xacro})",
        "posture": posture_text(profile),
        "base": base_text(robot, scene.base or "free"),
        "contact": "; ".join(_contact_text(profile, i) for i in range(len(profile.contacts))),
        "strike": f"{strike_text(profile)}: velocity ({_vector(profile.strike)}) m/s{normalised}",
        "joint model": "; ".join([joint_model_text(profile), *_drive_settings(profile)]),
        "plane": PLANES[scene.plane] if isinstance(scene.plane, str) else f"normal ({_vector(profile.plane.normal)})",
    }
    return [(name, printable(text)) for name, text in lines.items()]


def base_text(robot: Robot, base: Base) -> str:
    """How the base moves, why, and what changes it."""
    if base != "fixed" or not robot.free_base:
        return BASES[base if robot.free_base else "file"]
    return BASES["world" if robot.usual_base == "fixed" else "fixed"]


def joint_model_text(profile: ShockProfile) -> str:
    """The model of the joints, and what it means."""
    return JOINT_MODELS[profile.joint_model] if profile.robot.joint_names else "none (the robot has no joints)"


def posture_text(profile: ShockProfile) -> str:
    """The reference posture and what was set besides, with units."""
    posture = profile.scene.posture
    words = [printable(str(posture.reference))]
    words += _settings(profile.robot, posture.joints, ("rad", "m")) + _settings(profile.robot, posture.joints_deg, ("deg", "m"))
    if posture.base_rpy_deg:
        words.append("base at roll {:g}, pitch {:g}, yaw {:g} deg".format(*posture.base_rpy_deg))
    if posture.base_quaternion:
        words.append("base at quaternion ({:g}, {:g}, {:g}, {:g})".format(*posture.base_quaternion))
    return few(words, 8, what=" settings")


def strike_text(profile: ShockProfile) -> str:
    """Speed of the contact, its direction, and what moves before the impact."""
    strike = profile.scene.strike
    parts = [f"{float(np.linalg.norm(profile.strike)):.4g} m/s, {angle_text(profile)} deg from the vertical"]
    if strike.drop_height is not None:
        parts.append(f"after a fall of {strike.drop_height:g} m")
    moving = []
    if any(strike.angular_velocity or ()):
        moving.append(f"robot rotates at ({_vector(strike.angular_velocity or ())}) rad/s")
    moving += _settings(profile.robot, {k: v for k, v in strike.joint_velocities.items() if v}, ("rad/s", "m/s"))
    if moving and len(profile.contacts) > 1:
        parts.append("the fastest contact")
    return ", ".join([*parts, few(moving, 4, what=" joint rates")] if moving else parts)


def angle_text(profile: ShockProfile) -> str:
    """Angle of the contact's velocity from straight down, to four digits; below zero if it moves backward in the plane [deg]."""
    x, y, z = profile.strike
    angle = math.degrees(math.atan2(math.hypot(x, y), -z))
    backward = profile.strike @ profile.plane.forward < -1e-9 * np.linalg.norm(profile.strike)
    return f"{round(-angle if backward else angle, 9) + 0.0:.4g}"


def bodies_text(robot: Robot) -> str:
    """How many bodies move."""
    return count(len(robot.bodies), "moving body", "moving bodies")


def contact_name(profile: ShockProfile) -> str:
    """The contacts of a landing, as they are typed."""
    return "+".join(contact.frame for contact in profile.contacts)


def count(number: int, one: str, several: str = "") -> str:
    """A number with its noun, such as "1 joint" or "2 joints"."""
    return f"{number} {one if number == 1 else several or one + 's'}"


def _contact_text(profile: ShockProfile, i: int) -> str:
    """Place and kind of a contact."""
    asked, found = profile.scene.contact[i], profile.contacts[i]
    where = ", ".join(f"{x:.3f}" for x in found.point + 0.0)
    parts = [f"{asked.frame}{', its lowest point' if asked.at == 'lowest' else ''} at ({where}) m"]
    kept = [d if isinstance(d, str) else "({:g} {:g} {:g})".format(*d) for d in asked.directions]
    parts.append("sticks" if asked.sticks else f"slides, constrained along {' '.join(kept)}")
    parts += ["flat"] * (asked.kind == "flat") + [f"restitution {asked.restitution:g}"] * bool(asked.restitution)
    if np.linalg.norm(found.approach - profile.strike) > 1e-9 * np.linalg.norm(profile.strike):
        parts.append(f"approaches at ({_vector(found.approach)}) m/s")
    return ", ".join(parts)


def _drive_settings(profile: ShockProfile) -> list[str]:
    """What the scene sets of the drives, with units."""
    joints = profile.scene.joints
    found = [f"reflected inertia {text}" for text in _settings(profile.robot, joints.armature, ("kg m²", "kg"))]
    found += [f"rotor of {name}: {one.inertia:g} kg m², gear ratio {one.gear_ratio:g}" for name, one in joints.rotor.items()]
    return found + ([f"locked: {', '.join(joints.locked)}"] if joints.locked else [])


def _settings(robot: Robot, values: Mapping[str, float], units: tuple[str, str]) -> list[str]:
    """Values by pattern of joints, with the unit of the joints that turn or that slide."""
    kinds = {joint.name: joint.kind == "prismatic" for joint in robot.single_joints}
    found = []
    for pattern, value in values.items():
        slides = sorted({kinds.get(name, False) for name in robot.match_joints(pattern)})
        found.append(f"{printable(pattern)} = {value:g} {' or '.join(units[one] for one in slides)}")
    return found


def _vector(values: Iterable[float]) -> str:
    """A vector to four digits."""
    return ", ".join(f"{round(float(value), 12) + 0.0:.4g}" for value in values)
