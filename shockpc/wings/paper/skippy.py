"""Figure 3: the claims about Skippy, for a robot of its kind with assumed masses."""

import functools
import math
from typing import Any

import numpy as np

from shockpc import ShockProfile, Strike
from shockpc.core.spatial import Array
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.wings.paper.claim import Options, Panel, PaperFigure
from shockpc.wings.paper.panel_landings import land, largest, middle_lines

SKIPPY = PaperFigure(
    3,
    "Skippy",
    "Assumed, not published with the paper: all masses, most lengths, the drive, and the IMU "
    "locations a and b.",
    (Panel("Skippy", "fig3", "after a vertical jump"),),
)

ASSUMED = dict(
    torso_mass=1.5,
    leg_mass=0.3,
    foot_mass=0.1,
    leg_length=0.4,
    foot_length=0.16,
    crank_mass=0.03,
    rod_mass=0.03,
)
"""Assumed values that are halved and doubled, as in the robot's file [kg, m]."""

OPEN: Options = {
    "torso backward": {"hip": -38.0},
    "38° between torso and leg, torso backward": {"hip": -142.0},
    "80° between foot and leg": {"ankle": 80.0},
} | {
    f"{name.replace('_', ' ')} {word}": {name: f"{factor * value:g}"}
    for name, value in ASSUMED.items()
    for word, factor in (("halved", 0.5), ("doubled", 2.0))
}
"""Other values of what the text leaves open, each as arguments of `skippy`."""

AS_DRAWN = "hip 38° from the straight line, torso forward, 85° between foot and leg, as drawn"
drawn = functools.partial(SKIPPY.claim, interpretation=AS_DRAWN, options=OPEN)

FALL = math.sqrt(2.0 * GRAVITY * 4.0)
"""Speed after a fall from 4 m, the height that the paper names [m/s]."""

TURN, SWING = 2.0 * math.pi, 10.0
"""Rates of a somersault, one turn a second, and of a swinging foot [rad/s]."""

LANDINGS = (
    (0, 0, 0),
    (30, 0, 0),
    (-30, 0, 0),
    (0, TURN, 0),
    (0, -TURN, 0),
    (0, 0, SWING),
    (0, 0, -SWING),
)
"""Strike angle [deg], rates of the base and of the ankle [rad/s]."""

EXTREME = "strikes at ±30°, somersaults and a swinging foot both ways; still below 2 %"


@functools.cache
def skippy(hip: float = 38.0, ankle: float = 85.0, **built: str) -> ShockProfile:
    """Skippy after a vertical jump, its centre of mass above the toe.

    Args:
        hip: angle of the leg from the line of the torso [deg].
        ankle: angle of the foot from the line of the leg [deg].
        **built: arguments of the robot's file.
    """
    joints = {"hip": hip, "ankle": ankle}
    x, _, z = above_contact(land("fig3", joints, 0.0, xacro=built))
    return land("fig3", joints, -math.degrees(math.atan2(x, z)), xacro=built)


def above_contact(profile: ShockProfile) -> Array:
    """From the contact point to the centre of mass of the robot (3,), world axes [m]."""
    mass, com = profile.robot.masses, profile.robot.coms
    places = profile.position + (profile.rotation @ com[..., None])[..., 0]
    return np.asarray(mass @ places / mass.sum() - profile.contacts[0].point)


def _landing(angle: float, rate: float, ankle_rate: float, **how: Any) -> ShockProfile:
    """Another landing in the same posture, falling from 4 m.

    The centre of mass has the speed of that fall, and the robot rotates about it.
    """
    still = skippy(**how)
    radians = math.radians(angle)
    fall = FALL * np.array([math.sin(radians), 0.0, -math.cos(radians)])
    omega = np.array([0.0, rate, 0.0])
    # From the centre of mass to the base.
    arm = still.position[0] - still.contacts[0].point - above_contact(still)
    strike = Strike(
        velocity=tuple(fall + np.cross(omega, arm)),
        angular_velocity=tuple(omega),
        joint_velocities={"ankle": ankle_rate},
    )
    return land(still.scene, strike=strike)


def _torso(**how: Any) -> float:
    """Largest shock on the torso [1]."""
    return largest(skippy(**how))["torso"]


def _at_imus(*profiles: ShockProfile) -> float:
    """Largest shock at an IMU [%]."""
    shocks = []
    for profile in profiles:
        shocks += [point.shock for point in profile.points]
    return 100.0 * max(shocks)


@drawn(
    "Section 4.2: the radius of percussion of the torso is as large as 10 m",
    "RoPc of the torso [m]",
    above=10.0,
)
def _radius(**how: Any) -> float:
    return float(skippy(**how).ropc[0])


@drawn(
    "Section 4.2: nowhere on the torso does shock exceed 6 % of the applied shock",
    "largest shock on the middle line of the torso [%]",
    below=6.0,
)
def _on_torso(**how: Any) -> float:
    return 100.0 * _torso(**how)


@drawn(
    "Section 4.2: two mounting locations near the CoPc receive less than 2 % of the applied shock",
    "larger shock of the middle and 3/4 of the torso [%]",
    below=2.0,
)
def _mounted(**how: Any) -> float:
    return _at_imus(skippy(**how))


@drawn(
    "Section 4.2: the CoPc of the torso falls outside the physical body",
    "distance of the CoPc from the middle line over half the thickness of the torso [1]",
    above=1.0,
)
def _outside(**how: Any) -> float:
    profile = skippy(**how)
    x, _, z = profile.copc[0]
    _, top = middle_lines(profile)["torso"]
    return math.hypot(x, max(z - float(top[2]), -z, 0.0)) / (
        0.5 * float(profile.scene.xacro["side"])
    )


@drawn(
    "Section 4.2: so little shock reaches the torso because foot and leg are nearly perpendicular",
    "largest shock on the torso with 30° between foot and leg, over that as drawn [1]",
    above=2.0,
)
def _perpendicular(**how: Any) -> float:
    return _torso(**how | {"ankle": 30.0}) / _torso(**how)


@drawn(
    "Section 4.2: other extreme landings, such as a somersault, do not change the shock at the two "
    "locations significantly",
    "larger shock of the two [%]",
    below=2.0,
    interpretation=EXTREME,
)
def _extreme_landings(**how: Any) -> float:
    return _at_imus(*(_landing(*landing, **how) for landing in LANDINGS))


@SKIPPY.claim(
    "Footnote 5: an IMU rotated by 45° about the sagittal axis has up to √2 times the limit for "
    "vertical acceleration",
    "largest reading of its axes in a vertical jump over that of the rotated IMU [1]",
    above=1.0,
    below=math.sqrt(2.0) * (1.0 + 1e-12),
    interpretation="torso upright, rotated about its forward axis",
    options={
        "torso leaning, rotated about the axis across the sagittal plane": {
            "leaning": True,
            "axes": (2, 0),
        }
    },
)
def _rotated_imu(axes: tuple[int, int] = (1, 2), leaning: bool = False) -> float:
    reading = land("fig3").rotation[0][2] if leaning else np.array([0.0, 0.0, 1.0])
    rotated = reading.copy()
    i, j = axes
    rotated[[i, j]] = np.array([reading[i] + reading[j], reading[j] - reading[i]]) / math.sqrt(2.0)
    return float(np.abs(reading).max() / np.abs(rotated).max())
