"""The lines that an answer begins with.

They are shock, margin, peaks, what is not known, the largest joint impulse, warnings, and what the
ground does.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence

import numpy as np

from shockpc.landing.places import PlaceKind
from shockpc.method.constraints import Constraint
from shockpc.quantities.parts.ranges import sensor_peaks
from shockpc.quantities.records import ContactImpulse
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.header import other_warnings, unknown_lines
from shockpc.show.tables import rounded
from shockpc.studies.analyze.first_lines import (
    friction_text,
    margin_line,
    mass_text,
    shock_line,
    sliding_friction,
)
from shockpc.studies.analyze.several import worst_text
from shockpc.studies.analyze.views import readings_text
from shockpc.text.diagnostic import alike
from shockpc.text.printed import count, few

USUAL = {"posture": "standing", "base": "falls freely", "plane": "xz"}
"""Beginnings of lines of the header that say what is so unless options say otherwise."""

CLEAN = ("warnings", "no warnings")
"""The line of a summary without warnings; of several landings one line says it of all."""

WARNING = 160
"""Characters of the first warning in a summary; whole warnings follow it."""

MOST = 4
"""Points or contacts in a line."""

Line = tuple[str, str]
"""A name and a text."""


def summary_lines(profile: ShockProfile) -> list[Line]:
    """The lines of one landing."""
    first = [
        ("shock", shock_line(profile)),
        ("margin", margin_line({"": profile})),
        ("peak", _peak_text(profile)),
        ("reading", _reading_text(profile)),
    ]
    loads = [("joint", _joint_text(profile)), ("range", _range_text(profile))]
    return [
        *_with_text(first),
        *unknown_lines([profile]),
        *_with_text(loads),
        *warning_count([profile]),
        ("ground", _ground_text(profile)),
    ]


def several_lines(landings: Mapping[str, ShockProfile]) -> list[Line]:
    """The shock of several landings, the smallest margin of parts, and what is not known."""
    first = [("shock", worst_text(landings)), ("margin", margin_line(landings))]
    return [*_with_text(first), *unknown_lines(landings.values())]


def landing_lines(lines: Sequence[Line]) -> list[Line]:
    """The lines of the header that say something of this landing."""
    kept = []
    for name, text in lines:
        if name not in USUAL or not text.startswith(USUAL[name]):
            kept.append((name, text))
    return kept


def warning_count(profiles: Sequence[ShockProfile]) -> list[Line]:
    """The number of warnings, and the first one.

    The line says that there are none only where nothing is unknown.
    """
    warnings = []
    for k, profile in enumerate(profiles):
        warnings += [(warning, k) for warning in other_warnings(profile)]
    groups = alike(warnings)
    if groups:
        first, _ = groups[0][0]
        text = textwrap.shorten(str(first), WARNING, placeholder=" …")
        return [("warnings", f"{count(len(groups), 'warning')}: {text}")]
    for profile in profiles:
        if not all(unknown.known for unknown in profile.unknowns):
            return []
    return [CLEAN]


def rounding_text(profile: ShockProfile) -> str:
    """The bound on rounding, and what is in double precision."""
    text = f"error below {profile.health.error_bound:.0e}"
    if profile.friction is not None:
        text += "; those with friction in double precision"
    if profile.stiffness is not None:
        text += "; those with stiffness in double precision"
    return text


def stop_text(contact: ContactImpulse, stop: Constraint) -> str:
    """The impulse of an end stop that strikes, and what resists it."""
    if len(stop.forces):
        impulse, unit, inertia = contact.impulse, "N s", "mass along its joint"
        unit_of_inertia = "kg"
    else:
        impulse, unit, inertia = contact.moment, "N m s", "inertia about its joint"
        unit_of_inertia = "kg m²"
    size = "not determined" if impulse is None else f"{rounded(math.hypot(*impulse))} {unit}"
    effective = f"{rounded(contact.effective_mass)} {unit_of_inertia}"
    return f"{contact.frame}: impulse {size}, effective {inertia} {effective}"


def _with_text(lines: Sequence[Line]) -> list[Line]:
    return [(name, text) for name, text in lines if text]


def _with_friction(profile: ShockProfile) -> str:
    friction = sliding_friction(profile)
    return "" if friction is None else f" with friction {friction:g}"


def _value(profile: ShockProfile, key: str, kind: PlaceKind) -> np.ndarray:
    """The values of a quantity, with friction where a contact slides by it."""
    slides = sliding_friction(profile) is not None
    return profile.value(f"{key}_friction" if slides else key, kind)


def _peak_text(profile: ShockProfile) -> str:
    """The peak accelerations of points for the pulse of the scene; empty without a pulse."""
    peaks = _known_g(profile, _value(profile, "peak_g", "point"))
    if not peaks:
        return ""
    return f"{few(peaks, MOST)} for a pulse {profile.scene.pulse}{_with_friction(profile)}"


def _reading_text(profile: ShockProfile) -> str:
    """The readings of accelerometers in words; empty without one."""
    readings = _known_g(profile, profile.value("filtered_peak", "point"))
    return f"{few(readings, MOST)} {readings_text(profile)}" if readings else ""


def _known_g(profile: ShockProfile, values: np.ndarray) -> list[str]:
    """The points with a value, in g."""
    texts = []
    for place, value in zip(profile.places("point"), values.tolist(), strict=True):
        if not math.isnan(value):
            texts.append(f"{place.name} {rounded(value)} g")
    return texts


def _range_text(profile: ShockProfile) -> str:
    """The largest peak along an axis of each sensor, of its range; empty without a range."""
    limit = profile.scene.range_g
    if limit is None:
        return ""
    sensors = [place for place in profile.places("point") if place.body >= 0]
    peaks = sensor_peaks(profile.landing, profile.proof, sensors)
    if not peaks:
        return ""
    texts = []
    for sensor, peak in zip(sensors, peaks, strict=True):
        texts.append(f"{sensor.name} {rounded(peak.peak)} of {limit:g} g ({peak})")
    return few(texts, MOST, "; ")


def _joint_text(profile: ShockProfile) -> str:
    """The largest impulse through a joint, and its moment along the joint's axis."""
    text = f"largest impulse{_with_friction(profile)}: "
    if not profile.loads:
        return f"{text}none, because the robot has no joints"
    if not profile.row_space.unique.all():
        return f"{text}not determined, because rows are redundant"
    if any(warning.kind == "size" for warning in other_warnings(profile)):
        return f"{text}not determined, because the mechanism is singular or redundant here"
    impulses = _value(profile, "joint_impulse", "joint")
    largest = int(np.argmax(impulses))
    joint = profile.loads[largest].joint
    text += f"{joint} {rounded(impulses[largest])} N s"
    along = abs(float(_value(profile, "along", "joint")[largest]))
    if math.isnan(along):
        return text
    unit = "N s" if profile.robot.joint(joint).unit == "m" else "N m s"
    return f"{text}, {rounded(along)} {unit} along its axis"


def _ground_text(profile: ShockProfile) -> str:
    """Impulse, friction and effective mass at the contacts."""
    texts = []
    constraints = profile.landing.contacts
    for k, (contact, constraint) in enumerate(zip(profile.contacts, constraints, strict=True)):
        if constraint.kind == "stop":
            texts.append(stop_text(contact, constraint))
        else:
            texts.append(f"{contact.frame}: {_contact_text(profile, k)}")
    return few(texts, MOST, "; ")


def _contact_text(profile: ShockProfile, k: int) -> str:
    """Impulse, friction and effective mass at a contact."""
    contact, constraint = profile.contacts[k], profile.landing.contacts[k]
    if profile.friction is not None and sliding_friction(profile) is not None:
        size = math.hypot(*profile.value("impulse_friction", "contact")[k])
        state = profile.friction.state[k]
        return f"{state}{_with_friction(profile)}, impulse {rounded(size)} N s"
    if contact.impulse is None:
        return "impulse not determined, because rows are redundant"
    size = math.hypot(*contact.impulse)
    mass, friction = mass_text(profile, contact, constraint), friction_text(contact, constraint)
    return f"impulse {rounded(size)} N s, {mass}, {friction}"
