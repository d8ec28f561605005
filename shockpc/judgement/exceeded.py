"""Warnings of what a landing may exceed: ranges of sensors, ratings of parts, limits of joints."""

from collections.abc import Iterator

from shockpc.judgement.drive_range import Range, deciding_joints, drives_advice, ranges_of
from shockpc.landing.end_stops import at_stops, driven_beyond, has_stops
from shockpc.landing.places import Place
from shockpc.landing.ratings import TorqueStrength
from shockpc.quantities.parts.of_parts import REMEDIES
from shockpc.quantities.parts.ranges import sensor_peaks
from shockpc.quantities.records import PartMargin
from shockpc.quantities.selection import select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.bodies_and_joints import Joint
from shockpc.text.diagnostic import Diagnostic

CLEARLY_BEYOND = 1e-6
"""Share of the largest rate with which a joint clearly moves beyond an end stop [1].

Less may be rounding of double precision.
"""


def without_sensors(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of a pulse without a sensor or point."""
    if profile.landing.pulse is not None and not profile.places("point"):
        text = (
            "a pulse is given, but there is no sensor or point to have a peak; name a point with "
            "--at"
        )
        yield Diagnostic("sensor", "", None, text)


def saturated(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning for every sensor whose peak may exceed its range."""
    limit = profile.scene.range_g
    if limit is None:
        return
    share = select("range_share")
    moving = [place for place in profile.places("point") if place.body >= 0]
    peaks = sensor_peaks(profile.landing, profile.proof, moving)
    if not peaks:
        return
    ranges = ranges_of(profile, share, moving)
    for place, peak, shares in zip(moving, peaks, ranges, strict=True):
        if shares is not None and shares.meets(None, 1.0) is None:
            advice = drives_advice(deciding_joints(profile, share, place))
            low, high = limit * shares.smallest, limit * shares.largest
            text = (
                f'"{place.name}" may saturate or not: it would see {low:.3g} to {high:.3g} g over '
                f"the drives, and its range is {limit:g} g; {advice}"
            )
            yield Diagnostic("sensor", place.name, high, text)
        elif peak.peak > limit:
            text = (
                f'"{place.name}" would see {peak.peak:.3g} g {peak}, beyond its range of {limit:g} '
                f"g; its reading saturates"
            )
            yield Diagnostic("sensor", place.name, peak.peak, text)


def overloaded(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of the parts of the scene."""
    if not profile.landing.parts:
        return
    ranges = ranges_of(profile, select("part_margin"), profile.landing.parts)
    places = profile.landing.parts
    for part, place, margins in zip(profile.parts, places, ranges, strict=True):
        yield from _not_judged(part)
        yield from _damaged(profile, part, place, margins)
        yield from _loaded_too_long(profile, part)


def _not_judged(part: PartMargin) -> Iterator[Diagnostic]:
    """A warning of a part without a margin."""
    if part.missing:
        remedy = REMEDIES.get(part.missing, "")
        text = f"{part.part} is not judged: it {part.missing}{remedy}"
        yield Diagnostic("part", part.part, None, text)


def _damaged(
    profile: ShockProfile, part: PartMargin, place: Place, margins: Range | None
) -> Iterator[Diagnostic]:
    """A warning of a part whose margin is, or over the drives may be, below 1."""
    if margins is not None and margins.meets(1.0, None) is None:
        advice = drives_advice(deciding_joints(profile, select("part_margin"), place))
        text = (
            f"{part.part} may be damaged or not: its margin is {margins.smallest:.3g} to "
            f"{margins.largest:.3g} over the drives; {advice}"
        )
        yield Diagnostic("part", part.part, margins.smallest, text)
    elif part.part_margin is not None and part.part_margin < 1.0:
        if isinstance(part.strength, TorqueStrength):
            limit = "its momentary torque" if part.strength.in_part else "its effort limit"
            text = f"{part.joint} carries {1.0 / part.part_margin:.3g} times {limit}"
        else:
            text = (
                f"{part.part} may be damaged: its margin by {part.governed_by} is "
                f"{part.part_margin:.3g}, below 1"
            )
        yield Diagnostic("part", part.part, part.part_margin, text)


def _loaded_too_long(profile: ShockProfile, part: PartMargin) -> Iterator[Diagnostic]:
    """A warning of a part whose torque is rated for a shorter time than the impact lasts."""
    length = profile.impact_length
    if not isinstance(part.strength, TorqueStrength) or length is None:
        return
    if length > part.strength.duration:
        text = (
            f"the impact lasts {1e3 * length:.3g} ms, but the momentary torque of {part.joint} is "
            f"rated for {1e3 * part.strength.duration:.3g} ms; give its torque for a longer "
            f"duration"
        )
        yield Diagnostic("part", part.part, length, text)


def beyond_stops(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of joints at a limit that the impact drives beyond it."""
    robot = profile.robot
    rates = profile.landing.before.joint_rates + profile.delta_qd
    sides = at_stops(robot, profile.q[None], profile.landing.joint_model, limits=True)[0]
    beyond = driven_beyond(sides, rates)
    clearly = driven_beyond(sides, rates, CLEARLY_BEYOND)
    for joint in robot.single_joints:
        rate = float(rates[joint.v.start])
        included = profile.scene.stops and has_stops(robot, joint)
        if included and clearly[joint.v].any():
            text = (
                f"{joint.name} is driven beyond its end stop: double precision decides which stops "
                f"act, and the posture is nearly singular; set another posture"
            )
            yield Diagnostic("limits", joint.name, rate, text)
        elif not included and beyond[joint.v].any():
            yield _left_out(profile, joint, abs(rate))


def _left_out(profile: ShockProfile, joint: Joint, rate: float) -> Diagnostic:
    """A warning of an end stop that would act, but is left out."""
    both = ""
    if joint.limits == (0.0, 0.0):
        both = " (the file has 0 for both limits, as some exports without limits do)"
    remedy = ", because it shares its body with other joints"
    if has_stops(profile.robot, joint):
        remedy = ": include it with stops = true (--stops)"
    text = (
        f"{joint.name} is at its limit{both}, and the impact drives it further at {rate:.3g} "
        f"{joint.unit}/s. Its end stop is left out{remedy}"
    )
    return Diagnostic("limits", joint.name, rate, text)
