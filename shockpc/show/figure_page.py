"""The words of the figure: title, colour bar, the list of bodies and sensors, and what the signs mean. Inches on a page."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Rectangle

from shockpc.record import ShockProfile
from shockpc.show.figure_marks import length, letter, percussion_mark, strike_in_plane
from shockpc.show.figure_view import View
from shockpc.show.palette import BANDS, EDGES, INK

__all__ = ["PANEL", "colour_bar", "panel", "panel_height", "title"]

PANEL = 2.55
"""Width of the column beside the picture [inches]."""

LINE = 0.165
ROWS = 14
JOINT_MODELS = {
    "free": "free (zero reflected inertia)",
    "geared": "geared (reflected inertia of the file)",
    "mixed": "mixed (some joints have reflected inertia, the others none)",
    "locked": "locked (no joint turns)",
}


def title(page: Axes, profile: ShockProfile, x: float, y: float) -> None:
    """Robot, posture, strike and joint model, downwards from (x, y)."""
    scene = profile.scene
    contacts = " + ".join(contact.frame for contact in profile.contacts)
    page.text(x, y, f"{profile.robot.source.name or profile.robot.name}: shock of landing on {contacts}", fontsize=11, fontweight="bold", va="top")
    posture = f"posture {scene.posture.reference}"
    changed = len(scene.posture.joints) + len(scene.posture.joints_deg)
    if changed:
        posture += f", {changed} joint{'s' if changed > 1 else ''} set"
    if scene.posture.base_rpy_deg:
        posture += ", base roll {:g}, pitch {:g}, yaw {:g}°".format(*scene.posture.base_rpy_deg)
    model = JOINT_MODELS.get(profile.joint_model, profile.joint_model)
    page.text(x, y - 0.25, f"{posture}; strike {_strike(profile)}", fontsize=8.5, va="top")
    page.text(x, y - 0.43, f"joint model: {model}; plane {_plane(profile)}", fontsize=8.5, va="top")


def _strike(profile: ShockProfile) -> str:
    """The strike in words: speed and angle in the plane, or its components where it leaves the plane."""
    e1, e2 = strike_in_plane(profile)
    if math.hypot(e1, e2) > 0.9999:
        angle = math.degrees(math.atan2(e1, -e2))
        way = "straight down" if abs(angle) < 0.05 else f"{angle:.3g}° from the vertical"
        return f"{profile.v_in:.3g} m/s, {way}"
    return "({}) m/s".format(", ".join(f"{v + 0.0:.3g}" for v in profile.strike))


def _plane(profile: ShockProfile) -> str:
    plane = profile.scene.plane
    return plane if isinstance(plane, str) else "across ({})".format(", ".join(f"{v:.3g}" for v in profile.plane.normal))


def colour_bar(page: Axes, x: float, y: float, width: float) -> None:
    """The bands side by side, from (x, y) to the right and down, with their breaks."""
    step = width / len(BANDS)
    for k, colour in enumerate(BANDS):
        page.add_patch(Rectangle((x + k * step, y - 0.15), step, 0.15, facecolor=colour, edgecolor=INK, linewidth=0.5))
        if k:
            strong = EDGES[k] == 1.0
            page.text(x + k * step, y - 0.19, f"{EDGES[k]:g}", fontsize=8 if strong else 7, fontweight="bold" if strong else "normal", ha="center", va="top")
    page.text(x, y - 0.19, "0", fontsize=7, ha="center", va="top")
    page.text(x + width - step / 2.0, y - 0.19, f"> {EDGES[-2]:g}", fontsize=7, ha="center", va="top")
    at_one = x + EDGES.index(1.0) * step
    page.plot([at_one, at_one], [y - 0.18, y + 0.05], color=INK, linewidth=1.6)
    page.text(x, y - 0.36, "normalised shock |Δv| / v_in [-]; 1 is the strike itself", fontsize=7.5, va="top")


def panel_height(profile: ShockProfile, numbers: dict[int, int]) -> float:
    """Height of the column beside the picture [inches]."""
    rows = min(len(numbers), ROWS) + (min(len(profile.points), ROWS) + 2.5 if profile.points else 0)
    return LINE * (rows + 11.5)


def panel(page: Axes, profile: ShockProfile, view: View, numbers: dict[int, int], x: float, y: float) -> None:
    """The numbered bodies, the sensors and the signs, downwards from (x, y)."""
    right = x + PANEL
    _row(page, x, y, ("", "body", "RoPc", "shock"), bold=True)
    page.plot([x, right], [y - LINE * 0.95] * 2, color=INK, linewidth=0.6)
    y -= LINE * 1.15
    listed = list(numbers.items())
    for i, number in listed[:ROWS]:
        low, high = profile.shock_min[i], profile.shock_max[i]
        seen = f"{low:.2f}–{high:.2f}" if np.isfinite(high) else f"{profile.shock_com[i]:.2f}"
        _row(page, x, y, (str(number), profile.bodies[i], "∞" if profile.translates[i] else length(float(profile.ropc[i])), seen))
        y -= LINE
    if len(listed) > ROWS:
        page.text(x, y, f"and {len(listed) - ROWS} more", fontsize=7.5, va="top")
    y -= LINE * 0.9
    if profile.points:
        _row(page, x, y, ("", "sensor or point", "", "shock"), bold=True)
        page.plot([x, right], [y - LINE * 0.95] * 2, color=INK, linewidth=0.6)
        y -= LINE * 1.15
        for k, point in enumerate(profile.points[:ROWS]):
            _row(page, x, y, (letter(k), point.frame, "", f"{point.shock:.2f}"))
            y -= LINE
        y -= LINE * 0.9
    _signs(page, profile, view, x, y)


def _row(page: Axes, x: float, y: float, cells: tuple[str, str, str, str], bold: bool = False) -> None:
    number, name, radius, shock = cells
    weight = "bold" if bold else "normal"
    page.text(x, y, number, fontsize=7.5, fontweight="bold", va="top")
    shown = name if len(name) <= 19 else name[:9] + "…" + name[-9:]
    page.text(x + 0.2, y, shown, fontsize=7.5, fontweight=weight, va="top")
    page.text(x + PANEL - 0.72, y, radius, fontsize=7.5, fontweight=weight, ha="right", va="top")
    page.text(x + PANEL, y, shock, fontsize=7.5, fontweight=weight, ha="right", va="top")


def _signs(page: Axes, profile: ShockProfile, view: View, x: float, y: float) -> None:
    """What each sign in the picture means; only those that occur."""
    sign, text = x + 0.1, x + 0.3

    def say(words: str) -> None:
        nonlocal y
        page.text(text, y, words, fontsize=7.5, va="center")
        y -= LINE

    y -= LINE / 2.0
    percussion_mark(page, sign, y)
    say("CoPc: feels no shock (small +: other bodies)")
    page.add_patch(FancyArrowPatch((x, y), (x + 0.2, y), arrowstyle="-|>", mutation_scale=9, linewidth=1.0, color=INK, shrinkA=0, shrinkB=0))
    say("CoPc so far beyond the border")
    page.plot([x, x + 0.2], [y, y], color=INK, linewidth=0.6, linestyle=(0, (5, 3)))
    say("RoPc: shock is 1 on this circle")
    page.add_patch(FancyArrowPatch((x, y), (x + 0.2, y), arrowstyle="-|>", mutation_scale=11, linewidth=1.9, color=INK, shrinkA=0, shrinkB=0))
    say("strike: velocity of the contact")
    page.plot(sign, y, "o", markersize=2.6, markerfacecolor="#ffffff", markeredgecolor=INK, markeredgewidth=0.5)
    say("joint")
    if profile.points:
        page.plot(sign, y, "D", markersize=4.2, markerfacecolor="#ffd24d", markeredgecolor=INK, markeredgewidth=0.7)
        say("sensor or point")
    if any(drawn.glass for drawn in view.drawn):
        page.add_patch(Rectangle((x, y - 0.05), 0.2, 0.1, fill=False, edgecolor="#6a6a6a", linewidth=0.5))
        say("in front of the struck limb")
    if any(drawn.box for drawn in view.drawn):
        page.add_patch(Rectangle((x, y - 0.05), 0.2, 0.1, fill=False, edgecolor=INK, linewidth=0.7, linestyle=(0, (4, 1.5, 1, 1.5))))
        say("no shape in the file: box of its inertia")
