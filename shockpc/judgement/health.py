"""What judges a profile: how far to trust its numbers, and every warning of it."""

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from shockpc.impact.springs import early_springs, spring_time
from shockpc.judgement.accuracy import (
    data_sensitivity,
    double_error,
    nearly_singular,
    oversized,
    redundant,
    sensitive,
    strained,
)
from shockpc.judgement.drive_range import deciding_joints, drives_advice, ranges_of
from shockpc.judgement.plausibility import (
    angles,
    gained,
    heights,
    inertias,
    masses,
    pulled,
    slipping,
)
from shockpc.judgement.standing import hanging, lying, straight
from shockpc.judgement.unknowns import not_known
from shockpc.landing.end_stops import at_stops, driven_beyond, has_stops
from shockpc.landing.ratings import TorqueStrength
from shockpc.quantities.of_parts import REMEDIES
from shockpc.quantities.ranges import sensor_peaks
from shockpc.quantities.selection import select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.trust import Health
from shockpc.text.diagnostic import Diagnostic, by_cause
from shockpc.text.wings import from_wings

CLEARLY_BEYOND = 1e-6
"""Share of the largest rate with which a joint moves beyond an end stop from which on that is no
rounding of double precision.
"""


def health_of(profile: ShockProfile) -> Health:
    """How far to trust a profile."""
    proof = profile.proof
    return Health(
        rank=len(profile.row_space.rows),
        rows=len(proof.impulse),
        error_bound=float(np.max(proof.bounds)),
        body_error_bounds=tuple(map(float, proof.bounds)),
        double_error=double_error(profile.landing, proof, profile.double_jumps[..., 3]),
        data_sensitivity=data_sensitivity(profile)[0],
        bits=proof.bits,
        warnings=profile.warnings,
    )


def _not_known(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of what nobody knows, or what looks wrong, of all that the landing takes for
    granted.
    """
    for one in not_known(profile):
        yield Diagnostic(one.kind, "+".join(one.subjects), one.effect, str(one))


def warnings_of(profile: ShockProfile) -> tuple[Diagnostic, ...]:
    """The warnings of a profile: those of `CHECKS`, one for each cause, those of the largest effect
    first.
    """
    return by_cause(warning for check in CHECKS for warning in check(profile))


def _of_wings(profile: ShockProfile) -> Iterator[Diagnostic]:
    """What wings warn of."""
    for checks in from_wings("checks", "CHECKS"):
        for check in checks:
            yield from check(profile)


def _springs(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where springs in joints have an effect while the contact lasts."""
    time = spring_time(profile.landing)
    if math.isfinite(time):
        duration = None if profile.stiffness is None else profile.impact_length
        yield from early_springs(profile.landing, time, duration)


def _saturated(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning for every sensor whose peak may exceed its range, and for a pulse without a sensor
    or point.
    """
    places, limit = profile.places("point"), profile.scene.range_g
    if profile.landing.pulse is not None and not places:
        text = (
            "a pulse is given, but there is no sensor or point to have a peak; name a point with "
            "--at"
        )
        yield Diagnostic("sensor", "", None, text)
    if limit is None:
        return
    moving, share = [place for place in places if place.body >= 0], select("range_share")
    peaks, ranges = (
        sensor_peaks(profile.landing, profile.proof, moving),
        ranges_of(profile, share, moving),
    )
    for place, peak, found in zip(moving, peaks, ranges, strict=False):
        if found is not None and found.meets(None, 1.0) is None:
            text = (
                f'"{place.name}" may saturate or not: it would see {limit * found.smallest:.3g} to '
                f"{limit * found.largest:.3g} g "
                f"over the drives, and its range is {limit:g} g; "
                f"{drives_advice(deciding_joints(profile, share, place))}"
            )
            yield Diagnostic("sensor", place.name, limit * found.largest, text)
        elif peak.peak > limit:
            text = (
                f'"{place.name}" would see {peak.peak:.3g} g {peak}, beyond its range of {limit:g} '
                f"g; its reading saturates"
            )
            yield Diagnostic("sensor", place.name, peak.peak, text)


def _overloaded(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of parts that are not judged, may have a margin below 1, or whose torque is rated
    for a shorter time.
    """
    if not profile.parts:
        return
    length, margin = profile.impact_length, select("part_margin")
    ranges = ranges_of(profile, margin, profile.landing.parts)
    for one, place, found in zip(profile.parts, profile.landing.parts, ranges, strict=True):
        if one.missing:
            yield Diagnostic(
                "part",
                one.part,
                None,
                f"{one.part} is not judged: it {one.missing}{REMEDIES.get(one.missing, '')}",
            )
        if found is not None and found.meets(1.0, None) is None:
            text = (
                f"{one.part} may be damaged or not: its margin is {found.smallest:.3g} to "
                f"{found.largest:.3g} over the drives; "
                f"{drives_advice(deciding_joints(profile, margin, place))}"
            )
            yield Diagnostic("part", one.part, found.smallest, text)
        elif one.part_margin is not None and one.part_margin < 1.0:
            text = (
                f"{one.part} may be damaged: its margin by {one.governed_by} is "
                f"{one.part_margin:.3g}, below 1"
            )
            if isinstance(one.strength, TorqueStrength):
                limit = "its momentary torque" if one.strength.given else "its effort limit"
                text = f"{one.joint} carries {1.0 / one.part_margin:.3g} times {limit}"
            yield Diagnostic("part", one.part, one.part_margin, text)
        if (
            isinstance(one.strength, TorqueStrength)
            and length is not None
            and length > one.strength.duration
        ):
            text = (
                f"the impact lasts {1e3 * length:.3g} ms, but the momentary torque of {one.joint} "
                f"is rated for "
                f"{1e3 * one.strength.duration:.3g} ms; give its torque for a longer duration"
            )
            yield Diagnostic("part", one.part, length, text)


def _beyond_stops(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of joints at a limit that the impact drives beyond it, where their end stops are
    left out.
    """
    robot, rates = profile.robot, profile.landing.before.joint_rates + profile.delta_qd
    sides = at_stops(robot, profile.q[None], profile.landing.joint_model, limits=True)[0]
    beyond, clearly = driven_beyond(sides, rates), driven_beyond(sides, rates, CLEARLY_BEYOND)
    for joint in robot.single_joints:
        counted = has_stops(robot, joint)
        if profile.scene.stops and counted and clearly[joint.v].any():
            text = (
                f"{joint.name} is driven beyond its end stop: double precision decides which stops "
                f"act, and the "
                "posture is nearly singular; set another posture"
            )
            yield Diagnostic("limits", joint.name, float(rates[joint.v.start]), text)
        elif beyond[joint.v].any() and not (profile.scene.stops and counted):
            remedy = (
                ": include it with stops = true (--stops)"
                if counted
                else ", because it shares its body with other joints"
            )
            rate = abs(float(rates[joint.v.start]))
            both = (
                " (the file has 0 for both limits, as some exports without limits do)"
                if joint.limits == (0.0, 0.0)
                else ""
            )
            text = (
                f"{joint.name} is at its limit{both}, and the impact drives it further at "
                f"{rate:.3g} {joint.unit}/s. "
                f"Its end stop is left out{remedy}"
            )
            yield Diagnostic("limits", joint.name, rate, text)


CHECKS: tuple[Callable[[ShockProfile], Iterable[Diagnostic]], ...] = (
    oversized,
    lying,
    hanging,
    _not_known,
    lambda profile: (
        Diagnostic("robot", profile.robot.name, None, text) for text in profile.robot.warnings
    ),
    lambda profile: (*profile.robot.change_warnings, *profile.landing.warnings),
    inertias,
    heights,
    straight,
    angles,
    masses,
    nearly_singular,
    redundant,
    strained,
    sensitive,
    pulled,
    slipping,
    gained,
    _of_wings,
    _springs,
    _saturated,
    _overloaded,
    _beyond_stops,
)
"""What warns of a profile; of one kind of warnings the first counts most."""
