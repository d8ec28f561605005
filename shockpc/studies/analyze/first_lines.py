"""First lines of an answer: shocks with their range over the drives, margins of parts, masses."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from shockpc.judgement.drive_range import Range, range_of
from shockpc.judgement.first_number import (
    first_deciding,
    first_place,
    first_range,
    shock_of,
    worst_place,
)
from shockpc.landing.contact import contact_name
from shockpc.landing.places import Place
from shockpc.method.constraints import Constraint
from shockpc.quantities.records import ContactImpulse
from shockpc.quantities.selection import select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.show.header import landing_text
from shockpc.show.tables import rounded
from shockpc.show.wording import short_contact_names

STATUS = {"unknown": "drives unknown", "simulation model": "drives of a simulation"}
"""Words for how well drives are known."""

ASKED = 3
"""Points that were asked for in the first line."""


def drives_text(profile: ShockProfile) -> str:
    """Words on how well the drives are known that decide, and whether some are not known."""
    of_drives = [unknown for unknown in profile.unknowns if unknown.kind == "drives"]
    if not of_drives:
        return "drives as given"
    decisive = [unknown for unknown in of_drives if unknown.deciding]
    if not decisive:
        return "whatever the drives"
    order = first_deciding(profile)
    first = min(decisive, key=lambda unknown: order.index(unknown.deciding[0]))
    text = STATUS.get(first.status, f"drives {first.status}")
    if first.known and not all(unknown.known for unknown in decisive):
        text += ", some unknown"
    return text


def range_text(profile: ShockProfile, over_drives: Range | None) -> str:
    """A range in brackets, with how well the drives are known; empty where that is exactly."""
    return "" if over_drives is None else f" ({ends_text(over_drives)}, {drives_text(profile)})"


def ends_text(over_drives: Range | None) -> str:
    """The ends of a range, and whether they are those of samples; empty without a range."""
    if over_drives is None:
        return ""
    text = f"{rounded(over_drives.smallest)} … {rounded(over_drives.largest)}"
    return f"{text}, sampled" if over_drives.kind == "samples" else text


def range_ends(
    ranges: Iterable[Range | None],
) -> tuple[list[float | None], list[float | None]]:
    """The smallest and the largest numbers of some ranges; None where there is none."""
    smallest: list[float | None] = []
    largest: list[float | None] = []
    for over_drives in ranges:
        smallest.append(None if over_drives is None else over_drives.smallest)
        largest.append(None if over_drives is None else over_drives.largest)
    return smallest, largest


def shock_text(profile: ShockProfile, place: Place) -> str:
    """The shock at a place with its range; with friction where a contact slides by it."""
    wanted, mu = shock_of(profile), sliding_friction(profile)
    (value,) = profile.numbers(wanted, [place]).tolist()
    text = f"{place.title} {rounded(value)}"
    ends = range_text(profile, range_of(profile, wanted, place))
    if mu is None:
        return text + ends
    (sticking,) = profile.numbers(select("point.shock"), [place]).tolist()
    return f"{text} with friction {mu:g}{ends}, sticking {rounded(sticking)}"


def sliding_friction(profile: ShockProfile) -> float | None:
    """The friction of a landing in which not all contacts stick as in Eq. 4.

    None where they do, or no friction is given.
    """
    if profile.friction is None or profile.friction.impact is None:
        return None
    return profile.scene.friction


def shown_places(profile: ShockProfile) -> list[Place]:
    """The first place, the points that were asked for, and the worst of all sensors and points."""
    asked = asked_names(profile)
    points = [place for place in profile.bracketed[1:] if place.name in asked]
    places = [first_place(profile), *points[:ASKED]]
    worst = worst_place(profile)
    if worst is not None:
        places.append(worst)
    return list({place.name: place for place in places}.values())


def shock_line(profile: ShockProfile) -> str:
    """The shock at the first place and at points that were asked for, with ranges.

    The line also says where it is worst.
    """
    asked = asked_names(profile)
    worst = worst_place(profile)
    texts: list[str] = []
    for place in shown_places(profile):
        text = shock_text(profile, place)
        is_worst = worst is not None and place.name == worst.name
        if texts and is_worst and place.name not in asked:
            text = f"worst at {text}"
        texts.append(text)
    return f"{landing_text(profile)}: {'; '.join(texts)}"


def asked_names(profile: ShockProfile) -> set[str]:
    """Names of the points that were asked for."""
    return {point.label for point in profile.scene.point}


def short_names(landings: Sequence[ShockProfile]) -> list[str]:
    """Names of landings, such as "all four feet" and "FL + FR".

    What all contacts' names begin or end with is left out.
    """
    contacts = [[contact.frame for contact in profile.scene.contact] for profile in landings]
    short = short_contact_names(contacts, each_foot(landings[0].robot))
    texts = []
    for profile in landings:
        text = landing_text(profile)
        if text.startswith(("all ", "both ")):
            texts.append(text.removesuffix(" together"))
        else:
            frames = [short[contact.frame] for contact in profile.scene.contact]
            texts.append(" + ".join(frames))
    if len(set(texts)) < len(texts):
        return [contact_name(profile.scene) for profile in landings]
    return texts


def margin_line(landings: Mapping[str, ShockProfile]) -> str:
    """The smallest margin of all parts with its range and its landing; empty without a margin."""
    profiles = list(landings.values())
    margins: list[tuple[float, int, Place, str]] = []
    for k, profile in enumerate(profiles):
        for place, part in zip(profile.landing.parts, profile.parts, strict=True):
            if part.part_margin is not None:
                margins.append((part.part_margin, k, place, part.governed_by))
    if not margins:
        return ""
    margin, k, place, by = min(margins, key=lambda entry: entry[0])
    span = range_text(profiles[k], range_of(profiles[k], select("part.part_margin"), place))
    line = f"{place.name} {rounded(margin)}{span} by {by}"
    return line if len(profiles) == 1 else f"{line}, {short_names(profiles)[k]}"


def worst_margins(profiles: Sequence[ShockProfile]) -> list[tuple[float, str]] | None:
    """The smallest margin of each landing, and its part; None where no landing has one."""
    worst = []
    for profile in profiles:
        margins = []
        for part in profile.parts:
            if part.part_margin is not None:
                margins.append((part.part_margin, part.part))
        worst.append(min(margins, default=(np.nan, "")))
    return worst if any(name for _, name in worst) else None


def mass_text(profile: ShockProfile, contact: ContactImpulse, constraint: Constraint) -> str:
    """The effective mass of a contact with the rows that act, in words.

    Beside it is that along the normal alone (Khatib).
    """
    acting = contact.effective_mass
    if len(profile.contacts) == 1 and np.isfinite(profile.effective_mass):
        acting = profile.effective_mass
    text = f"effective mass {rounded(acting)} kg"
    if slides_freely(constraint):
        return text
    normal = rounded(contact.effective_mass_frictionless)
    return f"{text} ({normal} kg along the normal, without friction)"


def slides_freely(constraint: Constraint) -> bool:
    """True if a contact is held along its normal alone."""
    return bool(np.linalg.matrix_rank(constraint.forces) == 1)


def friction_text(contact: ContactImpulse, constraint: Constraint) -> str:
    """Words on whether a contact sticks, and with which friction, or slides."""
    if slides_freely(constraint):
        return "slides without friction"
    if contact.friction_needed is None:
        return "has to be pulled"
    sticks = f"with friction {rounded(contact.friction_needed)} or more"
    if np.linalg.matrix_rank(constraint.forces) == 3:
        return f"sticks {sticks}"
    return f"slides freely along one direction, and sticks along the other {sticks}"


def mass_notes(profiles: Sequence[ShockProfile]) -> Iterator[str]:
    """Notes that explain the masses and ranges of a table of landings."""
    if any(first_range(profile) is not None for profile in profiles):
        place = first_place(profiles[0]).title
        yield f"smallest, largest: shock at {place} over the possible drives, as far as found"
    yield (
        "mass: effective mass of all contacts; normal: effective mass along the normal, "
        "without friction"
    )
