"""Figures 2 and 4, and what Section 3.4 says of chains: the human leg under every reading of the text."""

import functools
import math

import numpy as np

from shockpc.core.spatial import Array
from shockpc.paper.landings import changed, land, line_shock, scene
from shockpc.paper.statement import Reading
from shockpc.result import ShockProfile
from shockpc.robot.robot import Robot

__all__ = [
    "ANGLE_ABC",
    "ANGLE_EF",
    "BODIES",
    "FOOT",
    "LOWER_LEG",
    "case",
    "cases",
    "ends",
    "greatest",
    "lower_leg_centre",
    "segment",
]

KNEE_AT_UPRIGHT = -15.0
"""Knee angle at which the lower leg is vertical, the upper leg being turned by 15 degrees [deg]."""

LOWER_LEG = Reading("lower leg's angle", {"0°": 0.0, "−5°": -5.0, "−10°": -10.0, "−15°": -15.0})
FOOT = Reading(
    "the foot's 75°",
    {
        "counted from the knee (toes forward)": 105.0,
        "counted from the lower leg's line (toes forward)": 75.0,
        "counted from the knee (toes backward)": -105.0,
        "counted from the lower leg's line (toes backward)": -75.0,
    },
)
ANGLE_ABC = Reading(
    "strike angles of A, B and C",
    {
        "15/45/75°": (15.0, 45.0, 75.0),
        "15/60/75°": (15.0, 60.0, 75.0),
        "0/30/60°": (0.0, 30.0, 60.0),
        "30/60/80°": (30.0, 60.0, 80.0),
    },
)
ANGLE_EF = Reading("strike angle of E and F", {f"{angle}°": float(angle) for angle in (15, 0, 30, 45, 60, 75)})

BODIES = ("lower_leg", "upper_leg", "torso")
"""From the ground up."""


_SCENES = {"A": "fig2_a", "B": "fig2_a", "C": "fig2_a", "D": "fig2_e", "E": "fig2_e", "F": "fig2_f"}
"""Cases that differ by the strike alone share a scene."""


def case(letter: str, strike: float, lower_leg: float = 0.0, ankle: float = 105.0) -> ShockProfile:
    """One case of Figure 2, with what the text leaves open said.

    Args:
        letter: A to F.
        strike: angle from the vertical [deg].
        lower_leg: angle from the vertical, counter-clockwise [deg].
        ankle: of the foot from the lower leg's line [deg]; cases without a foot ignore it.
    """
    return _case(_SCENES[letter], strike, lower_leg, ankle if letter == "F" else None)


@functools.cache
def _case(stem: str, strike: float, lower_leg: float, ankle: float | None) -> ShockProfile:
    joints = {"knee": KNEE_AT_UPRIGHT + lower_leg, **({} if ankle is None else {"ankle": ankle})}
    return land(changed(scene(stem), joints_deg=joints, strike={"speed": 1.0, "strike_angle_deg": strike}))


def cases(lower_leg: float, angles: tuple[float, float, float], steep: float, ankle: float = 105.0) -> list[ShockProfile]:
    """Cases A to F: the strike angles of A, B and C, and that of E and F [deg]; D is struck as C is."""
    strikes = dict(zip("ABCDEF", (*angles, angles[2], steep, steep), strict=True))
    return [case(letter, strike, lower_leg, ankle) for letter, strike in strikes.items()]


def segment(robot: Robot) -> float:
    """Length of a leg segment [m]."""
    return -float(robot.frame("heel").offset[2])


def ends(robot: Robot, body: str) -> tuple[Array, Array]:
    """The two ends of a body's middle line, in its frame [m]."""
    low, high = {
        "upper_leg": (-1.0, 0.0),
        "lower_leg": (-1.0, 0.0),
        "torso": (0.0, 1.5),
        "foot": (-0.5, 0.0),
    }[body]
    length = segment(robot)
    return np.array([0.0, 0.0, low * length]), np.array([0.0, 0.0, high * length])


def greatest(profile: ShockProfile, body: str) -> float:
    """Greatest shock on the middle line of a body [1]."""
    return line_shock(profile, body, ends(profile.robot, body))


def lower_leg_centre(profile: ShockProfile) -> tuple[float, float]:
    """CoPc of the lower leg: how far in front of its line, and how far from the nearest point of its line, over its length [1]."""
    i = profile.bodies.index("lower_leg")
    length = segment(profile.robot)
    front, _, along = profile.copc[i] / length
    beyond = max(along - 0.0, -1.0 - along, 0.0)
    return float(front), math.hypot(front, beyond)
