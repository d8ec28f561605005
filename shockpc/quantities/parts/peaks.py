"""Peaks of a landing over time, of contacts, points and joints."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.impact.landing_motion import LandingMotion
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.quantities.of_contacts import IMPULSE
from shockpc.quantities.of_joints import JOINTS
from shockpc.quantities.of_points import point_velocity
from shockpc.quantities.quantity import Places

FORCE, MOMENT, ALONG = JOINTS[:3]
"""Loads of a joint: linear in accelerations and forces, as they are in jumps and impulses."""

ROUNDING = 1e-10
"""Share of the largest peak through a joint below which a torque is rounding."""


def _wrench(impact: Impact, places: Places) -> Array:
    """Forces, moments, and the parts along the axes that n joints carry, (N, S, 3 n, 3)."""
    force, moment, along = (
        np.asarray(entry.compute(impact, places)) for entry in (FORCE, MOMENT, ALONG)
    )
    return np.concatenate([force, moment, along[..., None] * np.array([1.0, 0.0, 0.0])], axis=2)


def _loads(impact: Impact, _: Places) -> Array:
    """All n vectors (N, S, n, 3) whose peaks a landing shows.

    They are the forces of contacts, the velocities of points and parts, and the wrenches of
    joints.
    """
    landing = impact.landing
    shown = (
        (IMPULSE.compute, landing.contact_places),
        (point_velocity, _points(landing)),
        (_wrench, landing.places("joint")),
    )
    vectors = [np.asarray(compute(impact, places)) for compute, places in shown if places]
    return np.concatenate(vectors, axis=2)


def _points(landing: PosedLanding) -> list[Place]:
    """The points and parts that move."""
    return [place for place in (*landing.points, *landing.mounted) if place.body >= 0]


def contact_peaks(motion: LandingMotion, places: Places) -> Array:
    """Peak forces (n,) of contacts [N], and their times (n,) [s].

    They are NaN of the end stop of a hinge, which has a torque.
    """
    numbers = _numbers(places)
    hinges = np.array([not len(held.forces) for held in motion.landing.constraints])
    peaks = np.array(motion.peaks(_loads))[:, numbers]
    return np.where(hinges[numbers], np.nan, peaks)


def point_peaks(motion: LandingMotion, places: Places) -> Array:
    """Peak accelerations (n,) of points [m/s²], and when each is reached [s]."""
    landing = motion.landing
    shown = dict[tuple[int, bytes], int]()
    for k, place in enumerate(_points(landing), len(landing.contact_places)):
        shown[place.body, place.r.tobytes()] = k
    keys = [(place.body, place.r.tobytes()) for place in places]
    if not all(key in shown for key in keys):
        return np.array(motion.peaks(point_velocity, places))
    return np.array(motion.peaks(_loads))[:, [shown[key] for key in keys]]


def joint_peaks(motion: LandingMotion, places: Places) -> Array:
    """Peak forces, moments and torques along the axes (3, n) of joints.

    A torque is zero where it is rounding, and NaN where it is that of a spring before a rotor of
    unknown inertia.
    """
    joints = {place.name: k for k, place in enumerate(motion.landing.places("joint"))}
    peaks, _ = motion.peaks(_loads)
    force, moment, along = peaks[-3 * len(joints) :].reshape(3, -1)
    least = ROUNDING * max(force.max(initial=0.0), moment.max(initial=0.0))
    peaks = np.array([force, moment, np.where(along <= least, 0.0, along)])
    peaks = peaks[:, [joints[place.name] for place in places]]
    peaks[2, motion.landing.joint_model.rotor_unknown[_numbers(places)]] = np.nan
    return peaks


def _numbers(places: Places) -> list[int]:
    return [place.number for place in places]
