"""The judgement of a profile: the errors of its numbers, and every warning."""

import itertools
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
from shockpc.judgement.exceeded import beyond_stops, overloaded, saturated, without_sensors
from shockpc.judgement.plausibility import (
    angles,
    gained,
    heights,
    large_inertias,
    masses,
    pulled,
    slipping,
)
from shockpc.judgement.standing import hanging, lying, straight
from shockpc.judgement.unknowns import not_known
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.trust import Health
from shockpc.text.diagnostic import Diagnostic, by_cause
from shockpc.text.wings import from_wings


def health_of(profile: ShockProfile) -> Health:
    """The errors of a profile, with its warnings."""
    proof = profile.proof
    jumps = profile.double_jumps[..., 3]
    sensitivity, _ = data_sensitivity(profile)
    return Health(
        rank=len(profile.row_space.rows),
        rows=len(proof.impulse),
        error_bound=float(np.max(proof.bounds)),
        body_error_bounds=tuple(map(float, proof.bounds)),
        double_error=double_error(profile.landing, proof, jumps),
        data_sensitivity=sensitivity,
        bits=proof.bits,
        warnings=profile.warnings,
    )


def _not_known(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of what nobody knows, or what looks wrong, of what the landing takes for granted."""
    for unknown in not_known(profile):
        subjects = "+".join(unknown.subjects)
        yield Diagnostic(unknown.kind, subjects, unknown.effect, str(unknown))


def all_warnings(profile: ShockProfile) -> tuple[Diagnostic, ...]:
    """The warnings of a profile, one for each cause, those of the largest effect first."""
    return by_cause(itertools.chain.from_iterable(check(profile) for check in CHECKS))


def _of_robot_and_scene(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of the robot's file, of changes of the robot, and of the scene as resolved."""
    for text in profile.robot.warnings:
        yield Diagnostic("robot", profile.robot.name, None, text)
    yield from profile.robot.change_warnings
    yield from profile.landing.warnings


def _of_wings(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of wings."""
    for checks in from_wings("checks", "CHECKS"):
        for check in checks:
            yield from check(profile)


def _springs(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where springs in joints have an effect while the contact lasts."""
    time = spring_time(profile.landing)
    if math.isfinite(time):
        duration = None if profile.stiffness is None else profile.impact_length
        yield from early_springs(profile.landing, time, duration)


CHECKS: tuple[Callable[[ShockProfile], Iterable[Diagnostic]], ...] = (
    oversized,
    lying,
    hanging,
    _not_known,
    _of_robot_and_scene,
    large_inertias,
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
    without_sensors,
    saturated,
    overloaded,
    beyond_stops,
)
"""Functions that warn of a profile; of warnings of a kind the first counts most."""
