"""The peaks that an accelerometer would measure, of its range: each of its axes saturates apart.

In a landing that lasts these are the peaks of the motion, else those of the pulse, else,
behind a filter, the bound for a pulse of any length.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.low_pass import LowPass, peak_of
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.impact.landed import LandingProof
from shockpc.impact.landing_motion import LandingMotion, motion_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import DELTA_V, axis_jumps, low_passes, readings
from shockpc.quantities.quantity import IN_DOUBLES, Places, Quantity, Scope, quantity_values
from shockpc.quantities.with_friction import friction_result

AXES = "x", "y", "z"


class SensorPeak(NamedTuple):
    """The largest peak at a point, relative to the range of its sensor.

    Attributes:
        peak: [g].
        axis: of the point's frame along which it is; empty where the axes of the sensor are not
            known, of the lengths acceleration.
        cause: what gives the peak.
    """

    peak: float
    axis: str
    cause: str

    def __str__(self) -> str:
        return f"along {self.axis}, {self.cause}" if self.axis else self.cause


@memoized()
def _without_axes(landing: PosedLanding) -> frozenset[str]:
    """The names of points of which the axes are not known.

    An offset names a place on a link, not a sensor in a frame.
    """
    return frozenset(point.label for point in landing.scene.point if any(point.offset))


def _peaks(impact: Impact, places: Places) -> list[tuple[str, Array]]:
    """The peaks along the axes of points, with a text that says what gives them [g].

    Peaks are (k, n, 3) of the k columns of an impact, (1, n, 3) of a motion. There are none without
    a pulse, a stiffness and a bandwidth.
    """
    filters = low_passes(impact.landing, places)
    motion = motion_of(impact.landing)
    if motion is not None:
        return [_of_motion(motion, impact, places, filters)]
    if impact.landing.pulse is not None or any(low_pass is not None for low_pass in filters):
        return _of_pulse(impact, places, filters)
    return []


def _of_motion(
    motion: LandingMotion, impact: Impact, places: Places, filters: list[LowPass | None]
) -> tuple[str, Array]:
    """The peaks of a motion, behind a filter where a sensor has one, as `_peaks`."""
    landing = impact.landing
    along, _ = motion.peaks(axis_jumps, places)
    lengths, _ = motion.peaks(DELTA_V.compute, places)
    peaks = _along_axes(landing, places, along.reshape(1, -1, 3), lengths[None]) / GRAVITY
    filtered = np.array([low_pass is not None for low_pass in filters])
    if filtered.any():
        along = readings(impact, places, along=True)[0]
        lengths = readings(impact, places)[0]
        behind = _along_axes(landing, places, along, lengths)
        peaks = np.where(filtered[:, None], behind, peaks)
    return f"on {landing.scene.yielding}", peaks


def _of_pulse(
    impact: Impact, places: Places, filters: list[LowPass | None]
) -> list[tuple[str, Array]]:
    """The peaks of the scene's pulse, of contacts that stick and of those that slide."""
    landing = impact.landing
    scene = landing.scene
    cause = "at most, for a pulse of any length"
    if landing.pulse is not None:
        cause = f"for a pulse {scene.pulse}"
    impacts = {cause: impact}
    if scene.friction is not None:
        sliding = friction_result(landing).impact
        if sliding is not None:
            impacts[f"{cause} with friction {scene.friction:g}"] = sliding

    # Each jump times the peak for a jump of 1 m/s.
    scale = np.array([peak_of(landing.pulse, low_pass) for low_pass in filters])[:, None] / GRAVITY
    causes = []
    for text, pulsed in impacts.items():
        jumps = quantity_values(DELTA_V, pulsed, places)[0]
        sizes = _along_axes(landing, places, jumps, np.linalg.norm(jumps, axis=2))
        causes.append((text, sizes * scale))
    return causes


def _along_axes(landing: PosedLanding, places: Places, along: Array, lengths: Array) -> Array:
    """Sizes (k, n, 3) along the axes of points; where these are not known, those of the vectors.

    Args:
        landing: the landing.
        places: the n points.
        along: (k, n, 3) components.
        lengths: (k, n) lengths.
    """
    known = np.array([place.name not in _without_axes(landing) for place in places])
    return np.where(known[:, None], np.abs(along), lengths[..., None])


def _shares(impact: Impact, places: Places) -> Array:
    """The largest of these peaks (1, k, n), of the range; NaN where there is none."""
    limit = impact.landing.scene.range_g
    nothing = np.full((1, 1, len(places)), np.nan)
    if limit is None:
        return nothing
    peaks = [along.max(axis=2) for _, along in _peaks(impact, places)]
    if not peaks:
        return nothing
    return np.asarray(np.fmax.reduce(peaks)[None] / limit)


def sensor_peaks(
    landing: PosedLanding, proof: LandingProof, places: Sequence[Place]
) -> list[SensorPeak]:
    """The largest peak at each point; none without a pulse, a stiffness and a bandwidth."""
    if not places:
        return []
    causes = proof.read(lambda impact: _peaks(impact, places))
    if not causes:
        return []
    sensors = []
    for k, low_pass in enumerate(low_passes(landing, places)):
        largest = [float(np.nan_to_num(peaks[0, k]).max()) for _, peaks in causes]
        cause, every = causes[int(np.argmax(largest))]
        peaks = every[0, k]
        axis = AXES[int(peaks.argmax())]
        if places[k].name in _without_axes(landing):
            axis = ""
        if low_pass is not None:
            cause += f", behind a filter of {low_pass}"
        sensors.append(SensorPeak(float(peaks.max()), axis, cause))
    return sensors


RANGES = (
    Quantity(
        "range_share",
        "point",
        "largest peak along an axis, of the sensor's range",
        "1",
        "greater",
        _shares,
        scope=Scope("the scene gives no range"),
        computation=IN_DOUBLES,
    ),
)
