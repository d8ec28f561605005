"""The strike in words, the same in tables, reports and figures: that of the contact, with all that moves before the impact."""

import math

import numpy as np

from shockpc.result import ShockProfile

__all__ = ["motion_text", "strike_angle", "strike_text"]


def strike_angle(profile: ShockProfile) -> str:
    """Angle of the contact's velocity from straight down, to four digits; below zero if it moves backward in the plane [deg]."""
    x, y, z = profile.strike
    angle = math.degrees(math.atan2(math.hypot(x, y), -z))
    backward = profile.strike @ profile.plane.forward < -1e-9 * np.linalg.norm(profile.strike)
    return f"{round(-angle if backward else angle, 9) + 0.0:.4g}"


def motion_text(profile: ShockProfile) -> str:
    """What moves before the impact besides the fall: the robot's rotation and the joint rates; empty if nothing does."""
    strike, words = profile.scene.strike, []
    if any(strike.angular_velocity or ()):
        words.append("turning at ({}) rad/s".format(", ".join(f"{w:g}" for w in strike.angular_velocity or ())))
    rates = [f"{name} at {rate:g}" for name, rate in strike.joint_velocities.items() if rate]
    if rates:
        shown = rates if len(rates) <= 4 else [*rates[:3], f"{len(rates) - 3} more"]
        words.append(f"joint rates {', '.join(shown)} (rad/s, m/s)")
    return ", ".join(words)


def strike_text(profile: ShockProfile) -> str:
    """Speed of the contact, how it came about, and its velocity in the world."""
    strike = profile.scene.strike
    moves = motion_text(profile)
    how = [] if strike.drop_height is None else [f"after a fall of {strike.drop_height:g} m"]
    if strike.velocity is not None and not moves:
        how = ["as given"]
    elif moves or not how:
        how.append(f"{strike_angle(profile)} deg from the vertical")
    velocity = ", ".join(f"{v:.4g}" for v in profile.strike.round(12) + 0.0)
    text = f"{float(np.linalg.norm(profile.strike)):.4g} m/s, {', '.join(how)}: velocity ({velocity}) m/s"
    if moves:
        text += f"{' of the fastest contact' if len(profile.contacts) > 1 else ''}; {moves}"
    return text + (f"; shock relative to the centre of mass's {profile.v_in:.4g} m/s" if profile.scene.v_in == "com" else "")
