"""Curves and events of a landing on contacts of finite stiffness, in panels over time."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.quantities.parts.peaks import ALONG
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.printed import printable
from shockpc.wings.compliant.motion.events import Event
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding
from shockpc.wings.compliant.show.histories import (
    contact_forces,
    moving_points,
    point_accelerations,
)

HAPPENS = {
    "unloads": "compression ends",
    "reloads": "compressed further",
    "reverses": "force reverses",
    "slips": "slips",
    "opens": "opens",
    "closes": "closes",
}
"""Events of a contact, in words."""

SAMPLES = 600
"""Times of a curve."""

SAME_TIME, STEP = 0.01, 0.01
"""Least distance of two events in time, and least step of a force at one along the ground.

The distance is a share of the duration, the step one of the largest force.
"""

ACCELERATION = "acceleration [g]"
"""Heading of a panel."""


class TimePanel(NamedTuple):
    """Curves over time.

    Attributes:
        heading: of the ordinate, with the unit.
        names: of the curves.
        curves: (n, T); NaN after the end, of which the last time is the instant.
    """

    heading: str
    names: list[str]
    curves: Array


def times_of(compliant: CompliantLanding) -> Array:
    """The times (T,) of the curves [s]: both sides of all events, and the end twice.

    At the end all contacts are open, and without restitution the force drops to zero in that
    instant; without springs in joints, all else with it.
    """
    motion = compliant.motion
    ends = sorted({0.0, motion.duration, *(event.time for event in motion.events)})
    even = np.linspace(0.0, motion.duration, SAMPLES)
    t = np.unique(np.concatenate([even, ends, np.nextafter(ends, np.inf)]).clip(0.0, ends[-1]))
    return np.append(t, t[-1])


def panels_of(profile: ShockProfile, compliant: CompliantLanding, t: Array) -> list[TimePanel]:
    """The panels of forces, accelerations and torques at times (T,), the last after the end."""
    separated = compliant.motion.separated
    at_rest = separated and bool((compliant.number >= 0).all())
    panels = [_force_panel(profile, compliant, t)]
    panels[0].curves[:, -1] *= not separated
    points = moving_points(profile.places("point"))
    if points:
        accelerations = point_accelerations(compliant, points, t)
        accelerations[:, -1] *= not at_rest
        panels.append(TimePanel(ACCELERATION, [place.name for place in points], accelerations))
    joints = profile.places("joint")
    acting = np.flatnonzero(profile.value("peak_torque", "joint") > 0.0).tolist()
    if acting:
        torques = compliant.history(ALONG.compute, joints, t)[:, acting, 0].T
        torques[:, -1] *= not at_rest
        panels.append(TimePanel("torque [N m, N]", [joints[k].name for k in acting], torques))
    for panel in panels:
        panel.curves[:, t > compliant.motion.duration] = np.nan
    return panels


def _force_panel(profile: ShockProfile, compliant: CompliantLanding, t: Array) -> TimePanel:
    """The forces of the contacts."""
    has_stops = any(contact.kind == "stop" for contact in profile.landing.contacts)
    unit = "N, N m" if has_stops else "N"
    names = [place.name for place in profile.places("contact")]
    return TimePanel(f"force [{unit}]", names, contact_forces(compliant, t))


def normal_forces(profile: ShockProfile, compliant: CompliantLanding, t: Array) -> Array:
    """Forces (T, c) along the normals of contacts at times (T,), the last after the end."""
    of_contacts = compliant.number < len(profile.landing.contacts)
    force = compliant.motion.at(t).force[:, compliant.motion.elements.normal & of_contacts]
    force[-1] *= not compliant.motion.separated
    return np.asarray(force)


def events_of(profile: ShockProfile, compliant: CompliantLanding) -> list[tuple[float, str]]:
    """Events of contacts, (time [s], text): at their normals, and along the ground.

    What happens at almost the same time is one text.
    """
    motion, landing = compliant.motion, profile.landing
    # The numbers of contacts come first, then those of further end stops.
    stops = [contact.frame for contact in landing.acting][len(landing.contact_places) :]
    names = [*(place.name for place in profile.places("contact")), *stops]
    several = len(set(compliant.number[compliant.number >= 0].tolist())) > 1
    events: list[tuple[float, list[str]]] = []
    for event in _visible_events(compliant):
        text = HAPPENS[event.kind]
        if not motion.elements.normal[event.element] and event.kind != "slips":
            text += " along the ground"
        if several:
            name = names[int(compliant.number[event.element])]
            text = f"{printable(name, 20)} {text}"
        if not events or event.time - events[-1][0] > SAME_TIME * motion.duration:
            events.append((event.time, []))
        if text not in events[-1][1]:
            events[-1][1].append(text)
    return [(time, ", ".join(texts)) for time, texts in events]


def _visible_events(compliant: CompliantLanding) -> Iterator[Event]:
    """Events of contacts at their normals, and those along the ground that the figure shows.

    Elements along the ground change often; only visible steps of a force are named.
    """
    motion = compliant.motion
    times = np.array([event.time for event in motion.events])
    least_step = STEP * float(np.abs(motion.at(times).force).max(initial=0.0))
    for event in motion.events:
        if compliant.number[event.element] < 0:
            continue
        # Just before the event, and just after it.
        around = np.array([event.time, np.nextafter(event.time, np.inf)])
        before, after = motion.at(around).force[:, event.element]
        if motion.elements.normal[event.element] or abs(after - before) > least_step:
            yield event
