"""What the first lines of an answer say: shocks with their range over the drives, margins of parts,
and masses.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from shockpc.judgement.drive_range import Range, range_of
from shockpc.judgement.first_number import (
    first_deciding,
    first_place,
    first_range,
    shock_of,
    worst_place,
)
from shockpc.landing.places import Place
from shockpc.method.constraints import ConstraintBlock
from shockpc.quantities.records import ContactImpulse
from shockpc.quantities.selection import select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.show.header import landing_text
from shockpc.show.tables import rounded
from shockpc.show.wording import contact_name, without_common

STATUS = {"unknown": "drives unknown", "simulation model": "drives of a simulation"}
"""How well drives are known, in words."""

ASKED = 3
"""Points that were asked for in the first line."""


def drives_text(profile: ShockProfile) -> str:
    """How well the drives are known that decide, and whether some of them are not known."""
    deciding = first_deciding(profile)
    of_drives = [one for one in profile.unknowns if one.kind == "drives"]
    drives = [one for one in of_drives if one.deciding]
    if not drives:
        return "whatever the drives" if of_drives else "drives as given"
    first = min(drives, key=lambda one: deciding.index(one.deciding[0]))
    some = ", some unknown" if first.known and not all(one.known for one in drives) else ""
    return STATUS.get(first.status, f"drives {first.status}") + some


def range_text(profile: ShockProfile, found: Range | None) -> str:
    """A range in brackets, with how well the drives are known; empty where they are known exactly."""
    return "" if found is None else f" ({ends_text(found)}, {drives_text(profile)})"


def ends_text(found: Range | None) -> str:
    """The ends of a range, and whether they are those of samples; empty without a range."""
    if found is None:
        return ""
    return f"{rounded(found.smallest)} … {rounded(found.largest)}" + ", sampled" * (
        found.kind == "samples"
    )


def shock_text(profile: ShockProfile, place: Place) -> str:
    """The shock at a place with its range; with friction where a contact slides by it."""
    wanted, mu = shock_of(profile), sliding_friction(profile)
    (value,) = profile.numbers(wanted, [place]).tolist()
    text = f"{place.title} {rounded(value)}"
    found = range_text(profile, range_of(profile, wanted, place))
    if mu is None:
        return text + found
    (sticking,) = profile.numbers(select("point.shock"), [place]).tolist()
    return f"{text} with friction {mu:g}{found}, sticking {rounded(sticking)}"


def sliding_friction(profile: ShockProfile) -> float | None:
    """The friction of a landing in which not all contacts stick as in Eq. 4; None where they do, or
    none is given.
    """
    return (
        None
        if profile.friction is None or profile.friction.impact is None
        else profile.scene.friction
    )


def shown_places(profile: ShockProfile) -> list[Place]:
    """The first place, the points that were asked for, and the worst of all sensors and points."""
    first, worst = first_place(profile), worst_place(profile)
    asked = {point.label for point in profile.scene.point}
    points = [place for place in profile.bracketed[1:] if place.name in asked][:ASKED]
    return list(
        {
            place.name: place for place in (first, *points, *([] if worst is None else [worst]))
        }.values()
    )


def shock_line(profile: ShockProfile) -> str:
    """The shock at the first place and at points that were asked for, with ranges, and where it is
    worst.
    """
    worst, texts = worst_place(profile), list[str]()
    for place in shown_places(profile):
        more = (
            len(texts)
            and worst is not None
            and place.name == worst.name
            and place.name not in asked_names(profile)
        )
        texts.append("worst at " * bool(more) + shock_text(profile, place))
    return f"{landing_text(profile)}: {'; '.join(texts)}"


def asked_names(profile: ShockProfile) -> set[str]:
    """Names of the points that were asked for."""
    return {point.label for point in profile.scene.point}


def short_names(landings: Sequence[ShockProfile]) -> list[str]:
    """Names of landings: "all four feet", "FL + FR"; what all contacts' names begin or end with is
    left out.
    """
    robot = landings[0].robot
    frames = [[contact.frame for contact in profile.scene.contact] for profile in landings]
    names = dict.fromkeys([*each_foot(robot), *(name for each in frames for name in each)])
    short = dict(zip(names, without_common(list(names)), strict=True))
    texts = []
    for profile, each in zip(landings, frames, strict=True):
        whole = landing_text(profile)
        on_all = whole.startswith(("all ", "both "))
        texts.append(
            whole.removesuffix(" together") if on_all else " + ".join(short[name] for name in each)
        )
    return (
        texts if len(set(texts)) == len(texts) else [contact_name(profile) for profile in landings]
    )


def margin_line(landings: Mapping[str, ShockProfile]) -> str:
    """The smallest margin of all parts with its range and its landing; empty without a margin."""
    profiles = list(landings.values())
    found = [
        (margin, k, place, part.governed_by)
        for k, profile in enumerate(profiles)
        for place, part in zip(profile.landing.parts, profile.parts, strict=True)
        if (margin := part.part_margin) is not None
    ]
    if not found:
        return ""
    margin, k, place, by = min(found, key=lambda one: one[0])
    where = "" if len(profiles) == 1 else f", {short_names(profiles)[k]}"
    least = range_text(profiles[k], range_of(profiles[k], select("part.part_margin"), place))
    return f"{place.name} {rounded(margin)}{least} by {by}{where}"


def worst_margins(profiles: Sequence[ShockProfile]) -> list[tuple[float, str]] | None:
    """The smallest margin of each landing, and its part; None where no landing has one."""
    worst = []
    for profile in profiles:
        known = [
            (part.part_margin, part.part) for part in profile.parts if part.part_margin is not None
        ]
        worst.append(min(known, default=(np.nan, "")))
    return worst if any(name for _, name in worst) else None


def mass_text(profile: ShockProfile, contact: ContactImpulse, block: ConstraintBlock) -> str:
    """The effective mass of a contact with the rows that act, and that along the normal alone
    (Khatib) beside it.
    """
    acting = contact.effective_mass
    if len(profile.contacts) == 1 and np.isfinite(profile.effective_mass):
        acting = profile.effective_mass
    text = f"effective mass {rounded(acting)} kg"
    normal = (
        f" ({rounded(contact.effective_mass_frictionless)} kg along the normal, without friction)"
    )
    return text if slides_freely(block) else text + normal


def slides_freely(block: ConstraintBlock) -> bool:
    """Whether a contact is held along its normal alone."""
    return bool(np.linalg.matrix_rank(block.forces) == 1)


def friction_text(contact: ContactImpulse, block: ConstraintBlock) -> str:
    """Whether a contact sticks, and with which friction, or slides."""
    if slides_freely(block):
        return "slides without friction"
    if contact.friction_needed is None:
        return "has to be pulled"
    sticks = f"with friction {rounded(contact.friction_needed)} or more"
    if np.linalg.matrix_rank(block.forces) == 3:
        return f"sticks {sticks}"
    return f"slides freely along one direction, and sticks along the other {sticks}"


def mass_notes(profiles: Sequence[ShockProfile]) -> Iterator[str]:
    """What the masses and ranges of a table of landings are."""
    if any(first_range(profile) is not None for profile in profiles):
        place = first_place(profiles[0]).title
        yield f"smallest, largest: shock at {place} over the possible drives, as far as found"
    yield "mass: effective mass of all contacts; normal: effective mass along the normal, without friction"
