"""The words around the picture: title, colour bar and scale. Inches on a page."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from shockpc.result import ShockProfile
from shockpc.show.figure.palette import BANDS, EDGES, INK
from shockpc.show.figure.window import Window, strike_in_plane
from shockpc.show.strike import motion_text, strike_angle
from shockpc.show.tables.sheets import UNDRIVEN

__all__ = ["colour_bar", "joint_model", "scale_bar", "title"]

JOINT_MODELS = {
    "free": "free (zero reflected inertia)",
    "geared": "geared (reflected inertia of the file)",
    "mixed": "mixed (some joints have reflected inertia, the others none)",
    "locked": "locked (no joint turns)",
}


def title(page: Axes, profile: ShockProfile, x: float, y: float, width: float) -> None:
    """Robot, posture, strike and joint model, downwards from (x, y), in letters small enough for the width."""
    names = [contact.frame for contact in profile.contacts]
    contacts = " + ".join(names if len(names) <= 4 else [*names[:3], f"{len(names) - 3} more"])
    robot = profile.robot.source.name or profile.robot.name
    _line(page, x, y, f"{robot}: shock of landing on {contacts}", 11.0, width, bold=True)
    _line(page, x, y - 0.25, f"{_posture(profile)}; strike {_strike(profile)}", 8.5, width)
    _line(page, x, y - 0.43, f"joint model: {joint_model(profile)}; plane {_plane(profile)}", 8.5, width)


def joint_model(profile: ShockProfile) -> str:
    """What the drives do, in a few words."""
    return JOINT_MODELS[profile.joint_model] if profile.robot.joint_names else UNDRIVEN


def _line(page: Axes, x: float, y: float, words: str, size: float, width: float, bold: bool = False) -> None:
    """One line of text, in smaller letters if the width [inches] asks for it."""
    needed = (0.72 if bold else 0.62) * len(words) / 72.0
    page.text(x, y, words, fontsize=min(size, width / needed), fontweight="bold" if bold else "normal", va="top")


def _posture(profile: ShockProfile) -> str:
    """Posture and base in words."""
    posture, base = profile.scene.posture, profile.scene.base
    changed = len({name for pattern in (*posture.joints, *posture.joints_deg) for name in profile.robot.match_joints(pattern)})
    words = f"posture {posture.reference}" + (f", {changed} joint{'s' if changed > 1 else ''} set" if changed else "")
    turned = zip(("roll", "pitch", "yaw"), posture.base_rpy_deg or (), strict=False)
    words += "".join(f", base {name} {angle:g}°" for name, angle in turned if angle).replace("-", "−")
    return words + {"planar": ", base moves in the plane only", "fixed": ", base fixed"}.get(base or "free", "")


def _strike(profile: ShockProfile) -> str:
    """The strike in words: speed and angle in the plane, or its components where it leaves the plane."""
    e1, e2 = strike_in_plane(profile)
    if math.hypot(e1, e2) > 0.9999 and profile.plane.e2[2] > 0.9999:
        angle = strike_angle(profile)
        way = "straight down" if abs(float(angle)) < 0.05 else f"{angle}° from the vertical".replace("-", "−")
        words = f"{float(np.linalg.norm(profile.strike)):.3g} m/s, {way}"
    else:
        words = "({}) m/s".format(", ".join(f"{v + 0.0:.3g}" for v in profile.strike)).replace("-", "−")
    bounce = max((contact.restitution for contact in profile.scene.contact), default=0.0)
    slides = any(len(contact.directions) < 3 for contact in profile.scene.contact)
    moves = motion_text(profile)
    words += (" at the fastest contact" if moves and len(profile.contacts) > 1 else "") + (f", {moves}" if moves else "")
    return words + (f", restitution {bounce:g}" if bounce else "") + (", free to slide" if slides else "")


def _plane(profile: ShockProfile) -> str:
    plane = profile.scene.plane
    if isinstance(plane, str):
        return f"{plane}, {plane[0]} to the right, {plane[1]} up"
    return "across ({})".format(", ".join(f"{v:.3g}" for v in profile.plane.normal)).replace("-", "−")


def colour_bar(page: Axes, x: float, y: float, width: float) -> None:
    """The bands side by side, from (x, y) to the right and down, with their breaks."""
    step = width / len(BANDS)
    for k, colour in enumerate(BANDS):
        page.add_patch(Rectangle((x + k * step, y - 0.15), step, 0.15, facecolor=colour, edgecolor=INK, linewidth=0.5))
    for k, edge in enumerate(EDGES[:-1]):
        weight, size = ("bold", 8.0) if edge == 1.0 else ("normal", 7.0)
        page.text(x + k * step, y - 0.18, f"{edge:g}", fontsize=size, fontweight=weight, ha="center", va="top")
    page.text(x + width - step / 2.0, y - 0.18, f"> {EDGES[-2]:g}", fontsize=7, ha="center", va="top")
    at_one = x + EDGES.index(1.0) * step
    page.plot([at_one, at_one], [y - 0.15, y + 0.05], color=INK, linewidth=1.6, solid_capstyle="butt")
    page.text(x, y - 0.37, "normalised shock |Δv| / v_in [-]; 1 is the strike itself", fontsize=7.5, va="top")


def scale_bar(page: Axes, window: Window, x: float, y: float) -> None:
    """A bar of a round length near a fifth of the picture, which ends at (x, y)."""
    width = float(window.high[0] - window.low[0])
    power = 10.0 ** math.floor(math.log10(0.2 * width))
    bar = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= 0.2 * width)
    left = x - bar / window.inch
    page.plot([left, left, left, x, x, x], [y - 0.03, y + 0.03, y, y, y - 0.03, y + 0.03], color=INK, linewidth=1.0)
    page.text(left - 0.06, y, f"{bar:g} m", fontsize=7.5, ha="right", va="center")
