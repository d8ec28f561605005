"""The peaks that an accelerometer would measure, of its range: it saturates along each of its axes
apart.

On contacts of finite stiffness these are the peaks of the motion, else those of the pulse, else,
behind a filter, the bound for a pulse of any length.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.low_pass import peak_of
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.impact import Impact
from shockpc.impact.landed import LandingProof
from shockpc.impact.motion import motion_of
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.of_points import DELTA_V, axis_jumps, low_passes, readings
from shockpc.quantities.quantity import UNPROVEN, Places, Quantity, Scope, evaluate
from shockpc.quantities.with_friction import friction_result

AXES = "x", "y", "z"


class SensorPeak(NamedTuple):
    """The largest peak at a point, relative to the range of its sensor.

    Attributes:
        peak: [g].
        axis: of the point's frame along which it is; empty where the axes of the sensor are not
            known, of the whole acceleration.
        cause: what gives the peak.
    """

    peak: float
    axis: str
    cause: str

    def __str__(self) -> str:
        return f"along {self.axis}, {self.cause}" if self.axis else self.cause


@memoized()
def _without_axes(landing: PosedLanding) -> frozenset[str]:
    """The names of points of which the axes are not known: an offset names a place on a link, not a
    sensor in a frame.
    """
    return frozenset(point.label for point in landing.scene.point if any(point.offset))


def _peaks(impact: Impact, places: Places) -> Iterator[tuple[str, Array]]:
    """What gives peaks, and these along the axes of each point, or equal ones where the axes are
    not known [g].

    Peaks are (k, n, 3) of the k columns of an impact, of a motion (1, n, 3).
    """
    landing = impact.landing
    scene, pulse, filters = landing.scene, landing.pulse, low_passes(landing, places)
    behind = np.array([one is not None for one in filters])[:, None]

    def along(components: Array, lengths: Array) -> Array:
        known = np.array([place.name not in _without_axes(landing) for place in places])
        return np.where(known[:, None], np.abs(components), lengths[..., None])

    if (motion := motion_of(landing)) is not None:
        components = motion.peaks(axis_jumps, places)[0].reshape(1, -1, 3)
        raw = along(components, motion.peaks(DELTA_V.compute, places)[0][None]) / GRAVITY
        read = (
            along(readings(impact, places, along=True)[0], readings(impact, places)[0])
            if behind.any()
            else raw
        )
        yield f"on {scene.yielding}", np.where(behind, read, raw)
    elif pulse is not None or behind.any():
        scale = np.array([peak_of(pulse, one) for one in filters])[:, None] / GRAVITY
        jumps = [("", impact)]
        if scene.friction is not None and (sliding := friction_result(landing).impact) is not None:
            jumps.append((f" with friction {scene.friction:g}", sliding))
        what = (
            "at most, for a pulse of any length" if pulse is None else f"for a pulse {scene.pulse}"
        )
        for how, of in jumps:
            components = evaluate(DELTA_V, of, places)[0]
            yield f"{what}{how}", along(components, np.linalg.norm(components, axis=2)) * scale


def _shares(impact: Impact, places: Places) -> Array:
    """The largest of these peaks (1, k, n), of the range; NaN where there is none."""
    found = (
        []
        if impact.landing.scene.range_g is None
        else [peaks.max(axis=2) for _, peaks in _peaks(impact, places)]
    )
    if not found:
        return np.full((1, 1, len(places)), np.nan)
    largest = np.fmax.reduce(found)
    return np.asarray(largest[None] / impact.landing.scene.range_g)


def sensor_peaks(
    landing: PosedLanding, proof: LandingProof, places: Sequence[Place]
) -> list[SensorPeak]:
    """The largest peak at each point, of all that `_peaks` gives; none without a pulse, a stiffness
    and a bandwidth.
    """
    named = proof.read(lambda impact: list(_peaks(impact, places))) if places else []
    largest = []
    for k, low_pass in enumerate(low_passes(landing, places) if named else ()):
        cause, peaks = max(
            ((cause, peaks[0, k]) for cause, peaks in named),
            key=lambda one: float(np.nan_to_num(one[1]).max()),
        )
        axis = "" if places[k].name in _without_axes(landing) else AXES[int(peaks.argmax())]
        cause += f", behind a filter of {low_pass}" if low_pass is not None else ""
        largest.append(SensorPeak(float(peaks.max()), axis, cause))
    return largest


RANGES = (
    Quantity(
        "range_share",
        "point",
        "largest peak along an axis, of the sensor's range",
        "1",
        "greater",
        _shares,
        scope=Scope("the scene gives no range"),
        evaluation=UNPROVEN,
    ),
)
