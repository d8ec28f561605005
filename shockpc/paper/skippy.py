"""Figure 3: what the paper says of Skippy, on a robot of its kind whose masses are assumed, and for other assumptions."""

import functools
import math
from collections.abc import Mapping

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing import complete, resolve
from shockpc.paper.landings import changed, land, line_shock, robot_of, scene
from shockpc.paper.statement import Reading, Statement, outcomes
from shockpc.result import ShockProfile
from shockpc.scene import GRAVITY, Scene

__all__ = ["above_contact", "skippy", "skippy_statements"]

HIP = Reading(
    "the hip angle of 38°",
    {
        "from the straight line (torso forward)": 38.0,
        "from the straight line (torso backward)": -38.0,
        "between torso and leg (torso forward)": 142.0,
        "between torso and leg (torso backward)": -142.0,
    },
)
ANKLE = Reading(
    "foot and leg",
    {
        "85° apart (toe forward)": 85.0,
        "80° apart (toe forward)": 80.0,
        "90° apart (toe forward)": 90.0,
        "85° apart (toe backward)": -85.0,
    },
)
ASSUMED = {
    "torso_mass": 1.5,
    "leg_mass": 0.3,
    "foot_mass": 0.1,
    "leg_length": 0.4,
    "foot_length": 0.16,
    "crank_mass": 0.03,
    "rod_mass": 0.03,
}
"""What is assumed and not a place of the drive: its value in the robot's file [kg, m]."""

BUILT = Reading(
    "the robot",
    {"as assumed": {}}
    | {
        f"{name.replace('_', ' ')} {words}": {name: f"{factor * value:g}"}
        for name, value in ASSUMED.items()
        for words, factor in (("halved", 0.5), ("doubled", 2.0))
    },
)
AXIS = Reading("turned about", {"the axis that points forward": (1, 2), "the axis across the sagittal plane": (2, 0)})
"""The two axes of the IMU that the turn moves."""

LEANS = Reading("the torso", {"upright": False, "leaning as it lands": True})

FALL = math.sqrt(2.0 * GRAVITY * 4.0)
"""Speed after the fall from 4 m that the paper names [m/s]."""

TURN = 2.0 * math.pi
"""A somersault at one turn a second [rad/s]."""

LANDINGS = {
    "vertical": (0.0, 0.0, 0.0),
    "30° forward": (30.0, 0.0, 0.0),
    "30° backward": (-30.0, 0.0, 0.0),
    "in a forward somersault": (0.0, TURN, 0.0),
    "in a backward somersault": (0.0, -TURN, 0.0),
    "foot swinging forward": (0.0, 0.0, 10.0),
    "foot swinging backward": (0.0, 0.0, -10.0),
}
"""Strike angle [deg], rate of the somersault, rate of the ankle [rad/s]; all of them fall from 4 m."""


def skippy_statements() -> tuple[Statement, ...]:
    """The statements, in the paper's order."""
    ways = (HIP, ANKLE, BUILT)
    return (
        Statement(
            3,
            "Section 4.2",
            "the radius of percussion of the torso is as large as 10 m",
            "RoPc of the torso [m]; 10 or more",
            outcomes(ways, lambda *how: _of(skippy(*how), "ropc"), lambda x: x >= 10.0, together=False),
            "less is kept from the torso",
        ),
        Statement(
            3,
            "Section 4.2",
            "nowhere on the torso does shock exceed 6 % of the strike",
            "greatest shock on the torso's middle line [%]",
            outcomes(ways, lambda *how: 100.0 * _greatest(skippy(*how)), lambda x: x < 6.0, together=False),
            "more reaches the torso",
        ),
        Statement(
            3,
            "Section 4.2",
            "two places near the CoPc receive less than 2 %",
            "greater shock of the two, in the middle and at 3/4 of the torso [%]",
            outcomes(ways, lambda *how: 100.0 * _imus(skippy(*how)), lambda x: x < 2.0, together=False),
            "they move more",
        ),
        Statement(
            3,
            "Section 4.2",
            "the CoPc of the torso falls outside the body",
            "distance of the CoPc from the torso's middle line [m]; above half its thickness",
            outcomes(
                ways, lambda *how: _beside(skippy(*how)), lambda x: x > 0.5 * float(scene("fig3").xacro["side"]), together=False
            ),
            "the CoPc lies on the torso's line",
        ),
        Statement(
            3,
            "Section 4.2",
            "so little shock reaches the torso because foot and leg are nearly perpendicular",
            "greatest shock on the torso with foot and leg 30° from one line, over that as shown [1]; above 2",
            outcomes(
                (HIP, BUILT),
                lambda hip, built: _greatest(skippy(hip, 30.0, built)) / _greatest(skippy(hip, 85.0, built)),
                lambda x: x > 2.0,
                together=False,
            ),
            "leg and torso, too, are far from one line",
        ),
        Statement(
            3,
            "Section 4.2",
            "other extreme landings, such as a somersault, do not change the shock at the two places significantly",
            "greater shock of the two [%], most of 30° either way, a somersault either way, a swinging foot; still below 2",
            outcomes(
                (HIP, BUILT),
                lambda *how: 100.0 * max(_imus(_landing(landing, *how)) for landing in LANDINGS.values()),
                lambda x: x < 2.0,
                together=False,
            ),
            "a strike along the foot is not kept from the leg",
        ),
        Statement(
            3,
            "Footnote 5",
            "turning the IMU by 45° raises its limit for vertical acceleration by up to √2",
            "greatest reading of its three axes for a vertical jump, over that of the turned IMU [1]; above 1, at most √2",
            outcomes((AXIS, LEANS), _turned_imu, lambda x: 1.0 < x < math.sqrt(2.0) * (1.0 + 1e-12)),
            "on a torso that leans the axes are askew already, and turning on lays one of them nearly upright",
        ),
    )


def skippy(hip: float, ankle: float, built: Mapping[str, str]) -> ShockProfile:
    """Skippy after a vertical jump, its centre of mass above the toe.

    Args:
        hip: angle of the leg from the torso's line [deg].
        ankle: angle of the foot from the leg's line [deg].
        built: arguments of the robot's file.
    """
    return _skippy(hip, ankle, tuple(sorted(built.items())))


@functools.cache
def _skippy(hip: float, ankle: float, built: tuple[tuple[str, str], ...]) -> ShockProfile:
    return land(changed(scene("fig3"), {"hip": hip, "ankle": ankle}, base_pitch_deg=_pitch(hip, ankle, built), xacro=dict(built)))


@functools.cache
def _pitch(hip: float, ankle: float, built: tuple[tuple[str, str], ...]) -> float:
    """Pitch of the torso that puts the centre of mass above the toe [deg]."""
    x, _, z = above_contact(changed(scene("fig3"), {"hip": hip, "ankle": ankle}, base_pitch_deg=0.0, xacro=dict(built)))
    return -math.degrees(math.atan2(x, z))


def above_contact(found: Scene) -> Array:
    """From the contact to the centre of mass (3,), loops closed, world axes [m]."""
    robot = robot_of(found)
    landing = resolve(complete(found, robot), robot)
    state, touch = landing.state, landing.touches[0]
    mass = np.array([body.mass for body in robot.bodies])
    com = np.stack([body.com for body in robot.bodies])
    places = state.position[0] + (state.rotation[0] @ com[..., None])[..., 0]
    contact = state.position[0, touch.body] + state.rotation[0, touch.body] @ touch.point
    return np.asarray(mass @ places / mass.sum() - contact)


def _landing(landing: tuple[float, float, float], hip: float, built: Mapping[str, str]) -> ShockProfile:
    """Another landing in the same posture: the centre of mass falls at 4 m's speed, everything turns about it."""
    angle, turn, ankle_rate = landing
    key = tuple(sorted(built.items()))
    still = _skippy(hip, 85.0, key)
    fall = FALL * np.array([math.sin(math.radians(angle)), 0.0, -math.cos(math.radians(angle))])
    omega = np.array([0.0, turn, 0.0])
    velocity = fall + np.cross(
        omega, still.position[still.bodies.index("torso")] - still.contacts[0].point - above_contact(still.scene)
    )
    strike = {
        "velocity": tuple(map(float, velocity)),
        "angular_velocity": tuple(map(float, omega)),
        "joint_velocities": {"ankle": ankle_rate},
    }
    return land(changed(scene("fig3"), {"hip": hip, "ankle": 85.0}, _pitch(hip, 85.0, key), strike, dict(built)))


def _of(profile: ShockProfile, number: str) -> float:
    """A number of the torso."""
    return float(getattr(profile, number)[profile.bodies.index("torso")])


def _greatest(profile: ShockProfile) -> float:
    """Greatest shock on the torso [1]."""
    return line_shock(profile, "torso", (np.zeros(3), np.asarray(profile.robot.frame("head").offset)))


def _imus(profile: ShockProfile) -> float:
    """Greater shock of the two places [1]."""
    return max(point.shock for point in profile.points)


def _turned_imu(moved: tuple[int, int], leans: bool) -> float:
    """What a turn by 45° about the torso's forward axis, or about that across the plane, gains for a vertical jump [1]."""
    still = land("fig3")
    reading = still.rotation[still.bodies.index("torso")][2] if leans else np.array([0.0, 0.0, 1.0])
    turned = reading.copy()
    i, j = moved
    turned[[i, j]] = np.array([reading[i] + reading[j], reading[j] - reading[i]]) / math.sqrt(2.0)
    return float(np.abs(reading).max() / np.abs(turned).max())


def _beside(profile: ShockProfile) -> float:
    """How far the torso's CoPc is from its middle line [m]."""
    x, _, z = profile.copc[profile.bodies.index("torso")]
    beyond = max(z - float(profile.robot.frame("head").offset[2]), -z, 0.0)
    return math.hypot(x, beyond)
