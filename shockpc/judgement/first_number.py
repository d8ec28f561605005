"""The first number of an answer, the shock where it matters most, and its range over the drives."""

import numpy as np

from shockpc.core.memo import memoized
from shockpc.judgement.drive_range import Range, deciding_joints, range_of
from shockpc.landing.places import Place
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import is_imu


def shock_of(profile: ShockProfile) -> Selection:
    """The shock at points, with friction where a contact slides by it.

    There the shock with friction is the answer.
    """
    slides = profile.friction is not None and profile.friction.impact is not None
    return select("point.shock_friction" if slides else "point.shock")


@memoized()
def first_place(profile: ShockProfile) -> Place:
    """The robot's IMU, else its worst sensor or point, else its heaviest body's centre of mass."""
    imus = imu_places(profile)
    return imus[0] if imus else worst_place(profile) or profile.bracketed[0]


def imu_places(profile: ShockProfile) -> list[Place]:
    """The IMUs of a robot: sensors and points whose name or kind says so."""
    points = profile.bracketed[1:]
    return [place for place in points if is_imu(place.name) or place.name in profile.robot.imus]


@memoized()
def worst_place(profile: ShockProfile) -> Place | None:
    """The sensor or point with the largest shock; None without any."""
    points = profile.bracketed[1:]
    if not points:
        return None
    shocks = profile.numbers(shock_of(profile), points)
    return points[int(np.argmax(np.nan_to_num(shocks)))]


@memoized()
def first_range(profile: ShockProfile) -> Range | None:
    """The range of the first number over the drives; None where all are known exactly."""
    return range_of(profile, shock_of(profile), first_place(profile))


@memoized()
def first_deciding(profile: ShockProfile) -> tuple[str, ...]:
    """Names of the joints whose drives decide about the first number, the largest effect first."""
    return deciding_joints(profile, shock_of(profile), first_place(profile))
