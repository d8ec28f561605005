"""Assumptions of a landing.

That is drives that nobody gave, what was chosen, and what looks wrong in the robot's file.
"""

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from shockpc.judgement.first_number import first_deciding, first_range
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.trust import Unknown
from shockpc.robot.drives.drive_file import similar_robots
from shockpc.robot.drives.motors import effort_hint
from shockpc.robot.robot import Robot
from shockpc.robot.shapes.geometry import body_outline, inertias_about_origins
from shockpc.text.printed import few, listed

NOT_KNOWN = ("unknown", "simulation model")
"""Status of drives that are not known: nothing is known, or a number that was not measured.

Such a number is of a simulation.
"""

CATALOGUE = ("published", "derived", "identified")
"""Status of drives that are known from somewhere."""

DECIDING = 3
"""Joints that decide, in a text."""

CARRIES = {"flat": "its flat sole", "edge": "an edge of its sole", "corner": "a corner of its sole"}
"""The part of a contact that carries, by its kind, in words."""

CONTACT_OPTIONS = "--contact-point and --contact-kind change it"
"""Remedy for a contact that was chosen."""


def unknowns_of(profile: ShockProfile) -> tuple[Unknown, ...]:
    """Assumptions of a landing, a record for each cause.

    What is not known comes before what was chosen, and of each the largest effect on the first
    number of the answer.
    """
    every = itertools.chain.from_iterable(cause(profile) for cause in CAUSES)
    return tuple(sorted(every, key=lambda unknown: (unknown.known, -unknown.effect)))


def not_known(profile: ShockProfile) -> tuple[Unknown, ...]:
    """Those of `unknowns_of` that nobody knows.

    The ranges of what is known, which take as long as the landing, are not computed.
    """
    every = itertools.chain.from_iterable(cause(profile) for cause in NOBODY_KNOWS)
    return tuple(sorted(every, key=lambda unknown: -unknown.effect))


def merged(landings: Iterable[tuple[Unknown, ...]]) -> list[Unknown]:
    """Assumptions of several landings, one record a cause.

    It is that of the largest effect, with the names of all.
    """
    causes: dict[object, list[Unknown]] = {}
    for unknown in itertools.chain.from_iterable(landings):
        text = unknown.text if unknown.kind == "contact" else ""
        causes.setdefault((unknown.kind, unknown.status, text), []).append(unknown)
    records = []
    for alike in causes.values():
        names = dict.fromkeys(itertools.chain.from_iterable(unknown.subjects for unknown in alike))
        largest = max(alike, key=lambda unknown: unknown.effect)
        records.append(largest._replace(subjects=tuple(names)))
    return sorted(records, key=lambda unknown: (unknown.known, -unknown.effect))


def _unknown_drives(profile: ShockProfile) -> Iterator[Unknown]:
    """Drives that nothing gives, and those of a simulation."""
    return _drives(profile, NOT_KNOWN)


def _known_drives(profile: ShockProfile) -> Iterator[Unknown]:
    """Drives of the catalogue, with the interval that is known."""
    return _drives(profile, CATALOGUE)


def _drives(profile: ShockProfile, statuses: Sequence[str]) -> Iterator[Unknown]:
    """Drives of some statuses, a record for each."""
    for status in statuses:
        joints = list[str]()
        for source in profile.landing.joint_model.sources:
            if source.status == status:
                joints += source.joints
        if joints:
            yield _drives_of(profile, status, tuple(joints))


def _drives_of(profile: ShockProfile, status: str, joints: tuple[str, ...]) -> Unknown:
    """The drives of one status."""
    decide = tuple(name for name in first_deciding(profile) if name in joints)
    where = some_joints(profile.robot, joints)
    match status:
        case "unknown":
            text = f"the drives of {where} are not known"
        case "simulation model":
            text = f"the reflected inertia of {where} is one number, a setting of a simulator"
        case _:
            text = f"drives of {where}: {status}, {_interval(profile, joints)}"
    remedy = ""
    if status in NOT_KNOWN:
        hint = effort_hint(profile.robot, joints)
        if hint:
            text += f" ({hint})"
        if 0 < len(decide) < len(joints):
            verb = "decides" if len(decide) == 1 else "decide"
            text += f"; {few(decide, DECIDING)} {verb}"
        remedy = _remedy(profile, joints)
    effect = _effect(profile) if decide else 1.0
    return Unknown("drives", status, joints, decide, text, remedy, effect)


def _effect(profile: ShockProfile) -> float:
    """Largest over smallest value of the first number over the drives.

    It is 1 where all are known exactly, and inf where the smallest is zero.
    """
    over_drives = first_range(profile)
    if over_drives is None or over_drives.largest == over_drives.smallest:
        return 1.0
    if not over_drives.smallest > 0.0:
        return math.inf
    return over_drives.largest / over_drives.smallest


def _assumed(kind: str, status: str, subjects: tuple[str, ...], text: str, remedy: str) -> Unknown:
    """An assumption besides drives, of which no effect is computed."""
    return Unknown(kind, status, subjects, (), text, remedy, 1.0)


def _interval(profile: ShockProfile, joints: tuple[str, ...]) -> str:
    """The smallest and the largest inertia of some joints, in words."""
    model, v = profile.landing.joint_model, profile.robot.velocities(joints)
    low, high = float(model.low[v].min()), float(model.high[v].max())
    if low == high:
        return f"{low:.2g} kg m²"
    return f"{low:.2g} to {high:.2g} kg m²" if math.isfinite(high) else f"{low:.2g} kg m² or more"


def some_joints(robot: Robot, joints: Sequence[str]) -> str:
    """Some joints in words."""
    every = sum(joint.kind != "free" for joint in robot.single_joints)
    if len(joints) == every:
        return f"all {every} joints" if every > 1 else "the joint"
    return few(list(joints), 2, noun=" joints")


def _remedy(profile: ShockProfile, joints: tuple[str, ...]) -> str:
    """Advice where drives are not known."""
    robot = profile.robot
    if like := similar_robots(robot):
        return f"joints are named like those of {few(like, 4)}: --drives {like[0]}"
    if ratios := [name for name in joints if abs(robot.gear_ratios.get(name, 1.0)) != 1.0]:
        ratio = f"{ratios[0]} {robot.gear_ratios[ratios[0]]:g}"
        return f"the file has gear ratios ({ratio}): give the inertia of the rotors with --rotor"
    return (
        "give the drives with --drives, --rotor or --armature, or state with --joints free that "
        "there are none"
    )


def _springs(profile: ShockProfile) -> Iterator[Unknown]:
    """Drives behind springs, and springs of joints."""
    springs = profile.landing.joint_model.springs
    joints = [joint.name for joint in profile.robot.single_joints if springs[joint.v].any()]
    if joints:
        text = (
            f"springs at {some_joints(profile.robot, joints)}: free for an instant; a longer "
            "contact may be different"
        )
        remedy = "--contact-stiffness computes a contact that lasts"
        yield _assumed("springs", "assumed", tuple(joints), text, remedy)


def _inertias(profile: ShockProfile) -> Iterator[Unknown]:
    """Inertias that look as if they were about the links' origins."""
    links = inertias_about_origins(profile.robot)
    if links:
        text = (
            f"the inertias of {listed(links, 3)} look as if they were about the links' origins, "
            "but files should give them about the centres of mass"
        )
        remedy = "correct the file; shock is computed from them as they are"
        yield _assumed("inertia", "implausible", links, text, remedy)


def _meshes(profile: ShockProfile) -> Iterator[Unknown]:
    """Geometry that could not be read."""
    outline = body_outline(profile.robot)
    links = tuple(dict.fromkeys(lost.link for lost in outline.unread))
    remedy = "say where meshes are with --package or --meshes"
    for text in outline.warnings:
        yield _assumed("geometry", "missing", links, text, remedy)


def _contacts(profile: ShockProfile) -> Iterator[Unknown]:
    """Contact points and soles that were chosen because the scene leaves them open."""
    landing = profile.landing
    left_open = {contact.frame for contact in landing.asked if "auto" in (contact.at, contact.kind)}
    frames_by_text: dict[str, list[str]] = {}
    for contact, constraint in zip(profile.scene.contact, landing.contacts, strict=True):
        if constraint.kind != "stop" and contact.frame in left_open:
            point = "its lowest point" if contact.at == "lowest" else "the origin of its frame"
            text = CARRIES.get(contact.kind, f"a point at {point}")
            frames_by_text.setdefault(text, []).append(contact.frame)
    for text, frames in frames_by_text.items():
        yield _assumed("contact", "chosen", tuple(frames), text, CONTACT_OPTIONS)


def _posture(profile: ShockProfile) -> Iterator[Unknown]:
    """A posture that was chosen because the scene names none."""
    if "posture" in profile.landing.chosen:
        name = str(profile.landing.scene.posture.reference)
        remedy = "--posture and --set change it"
        yield _assumed("posture", "chosen", (name,), f'posture "{name}"', remedy)


def _base(profile: ShockProfile) -> Iterator[Unknown]:
    """Motion of the base, where the limbs of the robot decide that and not its file."""
    if "base" in profile.landing.chosen:
        text = "the base is freed, because legs hang on it"
        if profile.landing.base == "fixed":
            text = "the base is fixed, because the robot is an arm"
        name = profile.robot.bodies[0].name
        yield _assumed("base", "chosen", (name,), text, "--base changes it")


def _duration(profile: ShockProfile) -> Iterator[Unknown]:
    """The duration of contact, where a peak is asked for with a pulse."""
    if profile.landing.pulse is not None and profile.stiffness is None:
        text = (
            f"the contact lasts as long as the pulse {profile.scene.pulse}; peaks are in inverse "
            f"proportion to its length"
        )
        yield _assumed("duration", "assumed", (), text, "--contact-stiffness computes it")


NOBODY_KNOWS: tuple[Callable[[ShockProfile], Iterator[Unknown]], ...] = (
    _unknown_drives,
    _inertias,
    _meshes,
)
"""Functions that give what is not known, or what looks wrong."""

CAUSES = (*NOBODY_KNOWS, _known_drives, _springs, _contacts, _posture, _base, _duration)
"""Functions that give the assumptions of a landing; of equal effect the first counts most."""
