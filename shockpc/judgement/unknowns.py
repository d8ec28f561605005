"""What a landing takes for granted: drives that nobody gave, what was chosen, and what looks wrong
in the robot's file.
"""

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from shockpc.judgement.first_number import first_deciding, first_range
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.trust import Unknown
from shockpc.robot.drives import similar_robots
from shockpc.robot.geometry import body_outline, inertias_about_origins
from shockpc.robot.motors import effort_hint
from shockpc.robot.robot import Robot
from shockpc.text.printed import few, listed

NOT_KNOWN = ("unknown", "simulation model")
"""Status of drives that nobody knows: nothing is known, or a number of a simulation, which nobody
measured.
"""

CATALOGUE = ("published", "derived", "identified")
"""Status of drives that are known from somewhere."""

DECIDING = 3
"""Joints that decide, in a text."""

CARRIES = {"flat": "its flat sole", "edge": "an edge of its sole", "corner": "a corner of its sole"}
"""What of a contact carries, by its kind."""

CONTACT_OPTIONS = "--contact-point and --contact-kind change it"
"""What changes a contact that was chosen."""


def unknowns_of(profile: ShockProfile) -> tuple[Unknown, ...]:
    """What a landing takes for granted, a record for each cause.

    What is not known comes before what was chosen, and of each the largest effect on the first
    number of the answer.
    """
    found = [one for cause in CAUSES for one in cause(profile)]
    return tuple(sorted(found, key=lambda one: (one.known, -one.effect)))


def not_known(profile: ShockProfile) -> tuple[Unknown, ...]:
    """Those of `unknowns_of` that nobody knows, without the ranges of what is known, which take as
    long as the landing.
    """
    found = [one for cause in NOBODY_KNOWS for one in cause(profile)]
    return tuple(sorted(found, key=lambda one: -one.effect))


def merged(landings: Iterable[tuple[Unknown, ...]]) -> list[Unknown]:
    """What several landings take for granted, one record a cause: that of the largest effect; of
    contacts with all names.
    """
    causes: dict[object, list[Unknown]] = {}
    for one in itertools.chain.from_iterable(landings):
        causes.setdefault(
            (one.kind, one.status, one.text if one.kind == "contact" else ""), []
        ).append(one)
    found = []
    for alike in causes.values():
        names = tuple(dict.fromkeys(name for one in alike for name in one.subjects))
        found.append(max(alike, key=lambda one: one.effect)._replace(subjects=names))
    return sorted(found, key=lambda one: (one.known, -one.effect))


def _unknown_drives(profile: ShockProfile) -> Iterator[Unknown]:
    """Drives that nothing gives, and those of a simulation."""
    return _drives(profile, NOT_KNOWN)


def _known_drives(profile: ShockProfile) -> Iterator[Unknown]:
    """Drives of the catalogue, with the interval that is known."""
    return _drives(profile, CATALOGUE)


def _drives(profile: ShockProfile, statuses: Sequence[str]) -> Iterator[Unknown]:
    """Drives of some statuses, a record for each."""
    model = profile.landing.joint_model
    for status in statuses:
        sources = [source for source in model.sources if source.status == status]
        joints = tuple(name for source in sources for name in source.joints)
        if not joints:
            continue
        decide = tuple(name for name in first_deciding(profile) if name in joints)
        where = some_joints(profile.robot, joints)
        match status:
            case "unknown":
                text = f"the drives of {where} are not known"
            case "simulation model":
                text = f"the reflected inertia of {where} is one number, a setting of a simulator"
            case _:
                text = f"drives of {where}: {status}, {_interval(profile, joints)}"
        if status in NOT_KNOWN:
            hint = effort_hint(profile.robot, joints)
            text += f" ({hint})" if hint else ""
            decides = f"; {few(decide, DECIDING)} decide{'s' * (len(decide) == 1)}"
            text += decides if 0 < len(decide) < len(joints) else ""
        remedy = "" if status in CATALOGUE else _remedy(profile, joints)
        yield Unknown(
            "drives", status, joints, decide, text, remedy, _effect(profile) if decide else 1.0
        )


def _effect(profile: ShockProfile) -> float:
    """Largest over smallest value of the first number over the drives; 1 where all are known
    exactly.
    """
    found = first_range(profile)
    if found is None or found.largest == found.smallest:
        return 1.0
    return found.largest / found.smallest if found.smallest > 0.0 else math.inf


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
    return few(list(joints), 2, what=" joints")


def _remedy(profile: ShockProfile, joints: tuple[str, ...]) -> str:
    """What to give where drives are not known."""
    robot = profile.robot
    if like := similar_robots(robot):
        return f"joints are named like those of {few(like, 4)}: --drives {like[0]}"
    if ratios := [name for name in joints if abs(robot.gear_ratios.get(name, 1.0)) != 1.0]:
        ratio = f"{ratios[0]} {robot.gear_ratios[ratios[0]]:g}"
        return f"the file has gear ratios ({ratio}): give the inertia of the rotors with --rotor"
    return (
        "give the drives with --drives, --rotor or --armature, or say with --joints free that "
        "there are none"
    )


def _springs(profile: ShockProfile) -> Iterator[Unknown]:
    """Drives behind springs, and springs of joints."""
    springs = profile.landing.joint_model.springs
    if joints := tuple(
        joint.name for joint in profile.robot.single_joints if springs[joint.v].any()
    ):
        text = (
            f"springs at {some_joints(profile.robot, joints)}: free for an instant; a longer "
            "contact may be different"
        )
        yield Unknown(
            "springs",
            "assumed",
            joints,
            (),
            text,
            "--contact-stiffness computes a contact that lasts",
            1.0,
        )


def _inertias(profile: ShockProfile) -> Iterator[Unknown]:
    """Inertias that look as if they were about the links' origins."""
    if links := inertias_about_origins(profile.robot):
        text = (
            f"the inertias of {listed(links, 3)} look as if they were about the links' origins, "
            f"but files should give them "
            "about the centres of mass"
        )
        yield Unknown(
            "inertia",
            "implausible",
            links,
            (),
            text,
            "correct the file; shock is computed from them as they are",
            1.0,
        )


def _meshes(profile: ShockProfile) -> Iterator[Unknown]:
    """Geometry that could not be read."""
    found = body_outline(profile.robot)
    links = tuple(dict.fromkeys(lost.link for lost in found.unread))
    for text in found.warnings:
        yield Unknown(
            "geometry",
            "missing",
            links,
            (),
            text,
            "say where meshes are with --package or --meshes",
            1.0,
        )


def _contacts(profile: ShockProfile) -> Iterator[Unknown]:
    """Contact points and soles that were chosen because the scene leaves them open."""
    landing = profile.landing
    open_ = {contact.frame for contact in landing.asked if "auto" in (contact.at, contact.kind)}
    chosen: dict[str, list[str]] = {}
    for contact, block in zip(profile.scene.contact, landing.contacts, strict=True):
        if block.kind != "stop" and contact.frame in open_:
            place = "its lowest point" if contact.at == "lowest" else "the origin of its frame"
            how = CARRIES.get(contact.kind, f"a point at {place}")
            chosen.setdefault(how, []).append(contact.frame)
    for how, names in chosen.items():
        yield Unknown("contact", "chosen", tuple(names), (), how, CONTACT_OPTIONS, 1.0)


def _posture(profile: ShockProfile) -> Iterator[Unknown]:
    """A posture that was chosen because the scene names none."""
    if "posture" in profile.landing.chosen:
        name = str(profile.landing.scene.posture.reference)
        yield Unknown(
            "posture",
            "chosen",
            (name,),
            (),
            f'posture "{name}"',
            "--posture and --set change it",
            1.0,
        )


def _base(profile: ShockProfile) -> Iterator[Unknown]:
    """How the base moves, where the limbs of the robot decide that and not its file."""
    if "base" in profile.landing.chosen:
        held = profile.landing.base == "fixed"
        text = (
            "the base is fixed, because the robot is an arm"
            if held
            else "the base is freed, because legs hang on it"
        )
        yield Unknown(
            "base", "chosen", (profile.robot.bodies[0].name,), (), text, "--base changes it", 1.0
        )


def _duration(profile: ShockProfile) -> Iterator[Unknown]:
    """The duration of contact, where a peak is asked for with a pulse."""
    if profile.landing.pulse is not None and profile.stiffness is None:
        text = (
            f"the contact lasts as long as the pulse {profile.scene.pulse}; peaks are in inverse "
            f"proportion to its length"
        )
        yield Unknown("duration", "assumed", (), (), text, "--contact-stiffness computes it", 1.0)


NOBODY_KNOWS: tuple[Callable[[ShockProfile], Iterator[Unknown]], ...] = (
    _unknown_drives,
    _inertias,
    _meshes,
)
"""What nobody knows, or what looks wrong."""

CAUSES = (*NOBODY_KNOWS, _known_drives, _springs, _contacts, _posture, _base, _duration)
"""What a landing takes for granted; of equal effect the first counts most."""
