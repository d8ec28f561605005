"""Sliders for the posture of a landing, its contact, masses and sensors, with their code.

The code of the page computes the numbers that they change.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.show.html.posture import PostureSliders
from shockpc.show.html.surfaces import Surface
from shockpc.text.errors import ShockError
from shockpc.text.printed import printable
from shockpc.wings.symbols.posture_formulas import LiveLanding, Slider, live_landing

TILT = np.pi / 3
"""Largest angle by which a slider tilts the base [rad]."""


def posture_of(
    landing: PosedLanding, drawn: Sequence[Surface], joints: Sequence[str]
) -> PostureSliders:
    """The sliders of a landing.

    Args: drawn, surfaces of its bodies; joints, names or globs of those that have sliders besides.
    """
    boxes = np.array([_box(part.vertices) for part in drawn])
    sensors: list[dict[str, Any]] = []
    for k, place in enumerate(landing.points):
        sensors += _sensor(place, boxes, k)
    try:
        live = live_landing(landing, joints, boxes)
    except ShockError as refused:
        note = f"The posture has no sliders: {printable(str(refused))}."
        return PostureSliders(sensors, "null", note)
    tilts = [
        Slider("joint", name, "rad", 0.0, -TILT, TILT)._asdict() | {"kind": "tilt"}
        for name in live.tilts
    ]
    of_landing = [
        {**slider._asdict(), "name": printable(slider.name), "limits": _limits(landing, slider)}
        for slider in live.sliders
    ]
    return PostureSliders([*tilts, *of_landing, *sensors], live.javascript(), _note(landing, live))


def _limits(landing: PosedLanding, slider: Slider) -> tuple[float, float] | None:
    """The limits of a joint that has some on both sides [rad, m]."""
    if slider.kind != "joint":
        return None
    limits = landing.robot.joint(slider.name).limits
    return limits if np.isfinite(limits).all() else None


def _note(landing: PosedLanding, live: LiveLanding) -> str:
    parts = ["The posture of the scene is exact; others are computed in double precision"]
    if any(slider.kind == "mass" for slider in live.sliders):
        parts.append("a body's inertia is in proportion to its mass")
    if len(landing.contacts) > 1:
        parts.append("the contact is the first one")
    return "; ".join(parts) + "."


def _box(vertices: Array) -> Array:
    """Least and largest coordinates (2, 3) of the surface of a body."""
    return np.stack([vertices.min(axis=0, initial=0.0), vertices.max(axis=0, initial=0.0)]).astype(
        float
    )


def _sensor(place: Place, boxes: Array, k: int) -> Iterator[dict[str, Any]]:
    for axis, value, low, high in zip(
        "xyz", place.r.tolist(), *boxes[place.body].tolist(), strict=True
    ):
        yield {
            "kind": "point",
            "name": f"{printable(place.name)} {axis}",
            "unit": "m",
            "value": value,
            "point": k,
            "low": min(low, value),
            "high": max(high, value),
        }
