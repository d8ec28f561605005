"""Several landings of one robot: one table with a line for each, and the answer in one line."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from shockpc.judgement.first_number import first_place, first_range, shock_of, worst_place
from shockpc.landing.contact import contact_name
from shockpc.landing.places import Place
from shockpc.quantities.contact_mass import normal_mass
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.header import landing_text
from shockpc.show.report import Report
from shockpc.show.tables import Cell, Heading, Sheet, rounded
from shockpc.studies.analyze.first_lines import (
    asked_names,
    drives_text,
    ends_text,
    mass_notes,
    range_ends,
    short_names,
    sliding_friction,
    worst_margins,
)
from shockpc.text.printed import few

PLACES = 3
"""Sensors and points in the table."""


class Reports(Mapping[str, Report]):
    """The report of each landing by its name, made when it is read.

    The table of several landings needs none of them.
    """

    def __init__(
        self, landings: Mapping[str, ShockProfile], make: Callable[[ShockProfile], Report]
    ) -> None:
        self._landings, self._make, self._made = landings, make, dict[str, Report]()

    def __getitem__(self, name: str) -> Report:
        if name not in self._made:
            self._made[name] = self._make(self._landings[name])
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._landings)

    def __len__(self) -> int:
        return len(self._landings)


def _places(profiles: Sequence[ShockProfile]) -> list[Place]:
    """The first landing's first place, points that were asked for, and the worst place of all."""
    first = profiles[0]
    asked = [place for place in first.bracketed[1:] if place.name in asked_names(first)]
    places = [first_place(first), *asked[: PLACES - 2]]
    worst = []
    for profile in profiles:
        place = worst_place(profile)
        if place is not None:
            worst.append((_shock(profile, place), place))
    if worst:
        _, place = max(worst, key=lambda pair: pair[0])
        places.append(place)
    return list({place.name: place for place in places}.values())


def _shock(profile: ShockProfile, place: Place) -> float:
    """The shock of a landing at a place of another landing of the robot."""
    return float(profile.numbers(shock_of(profile), [place])[0])


def _worst(values: np.ndarray) -> int:
    """The number of the largest value that is known; 0 without any."""
    return int(np.nanargmax(values)) if np.isfinite(values).any() else 0


def worst_text(landings: Mapping[str, ShockProfile]) -> str:
    """The shock at the first place of the first landing, on the worst single foot, and the worst.

    The worst of all is given if it is another one.
    """
    profiles = list(landings.values())
    place, *further_places = _places(profiles)
    texts = _first_place_texts(profiles, place)
    names = short_names(profiles)
    # At each further place another landing may be the worst.
    for further in further_places:
        values = np.array([_shock(profile, further) for profile in profiles])
        k = _worst(values)
        texts.append(f"{further.title} up to {rounded(values[k])} ({names[k]})")
    return "; ".join(texts)


def _first_place_texts(profiles: Sequence[ShockProfile], place: Place) -> list[str]:
    """The shock at the first place in the landings that matter, in words."""
    shocks = np.array([_shock(profile, place) for profile in profiles])
    single = [k for k, profile in enumerate(profiles) if len(profile.scene.contact) == 1]
    worst = _worst(shocks)
    named = [rounded(shock) for shock in shocks]
    # A first landing on several feet, beside landings on single ones, has texts of its own.
    if 0 in single or not single:
        number = named[worst] + _first_range_text(profiles[worst])
        text = f"worst of {len(profiles)} landings, {landing_text(profiles[worst])}"
        return [f"{text}: {place.title} {number}"]
    foot = single[_worst(shocks[single])]
    number = named[0] + _first_range_text(profiles[0])
    of_foot = _where_text(profiles[foot], contact_name(profiles[foot].scene))
    texts = [
        f"{landing_text(profiles[0])}: {place.title} {number}",
        f"worst single foot {named[foot]} ({of_foot})",
    ]
    if worst not in (0, foot):
        of_worst = _where_text(profiles[worst], landing_text(profiles[worst]))
        texts.append(f"worst of all {named[worst]} ({of_worst})")
    return texts


def _first_range_text(profile: ShockProfile) -> str:
    """The range of the first number in brackets, and how well drives are known; may be empty."""
    ends = ends_text(first_range(profile))
    return f" ({ends}; {drives_text(profile)})" if ends else ""


def _where_text(profile: ShockProfile, name: str) -> str:
    """A landing's name, and the range of its first number."""
    ends = ends_text(first_range(profile))
    return f"{name}; {ends}" if ends else name


def level_text(profile: ShockProfile, on_all: ShockProfile) -> str:
    """Words on feet that are level with the contacts of a landing, and on a landing on all of them.

    Args: on_all, that landing.
    """
    struck = {contact.body for contact in profile.landing.contacts}
    left_out = [contact.frame for contact in on_all.landing.contacts if contact.body not in struck]
    are, them = ("are", "them") if len(left_out) > 1 else ("is", "it")
    within = f"within {1e3 * profile.scene.ground_tolerance:g} mm"
    return (
        f"{few(left_out, 8)} {are} as low ({within}); with {them}, {landing_text(on_all)}: "
        f"{_first_text(profile, on_all)}"
    )


def _first_text(profile: ShockProfile, landing: ShockProfile) -> str:
    """The shock of another landing at the first place of a landing."""
    place = first_place(profile)
    return f"{place.title} {rounded(_shock(landing, place))}"


def whole_feet_text(profile: ShockProfile, on_feet: ShockProfile) -> str:
    """Words on a landing on whole feet, of which a landing strikes parts.

    Args: profile, that landing; on_feet, the other.
    """
    named = {contact.frame for contact in on_feet.scene.contact}
    parts = [contact.frame for contact in profile.scene.contact if contact.frame not in named]
    shock = _first_text(profile, on_feet)
    are_parts = "are only parts of feet" if len(parts) > 1 else "is only part of a foot"
    return (
        f"{few(parts, 8)} {are_parts}, and other parts are as low; {landing_text(on_feet)}: {shock}"
    )


def landings_sheet(landings: Mapping[str, ShockProfile]) -> Sheet:
    """A row for each landing: shocks, margins, the largest joint impulse, and masses.

    The first shock has its range over the drives.
    """
    profiles = list(landings.values())
    places = _places(profiles)
    shocks = np.empty((len(profiles), len(places)))
    for k, profile in enumerate(profiles):
        shocks[k] = [_shock(profile, place) for place in places]
    columns: dict[str | Heading, Sequence[Cell]] = {
        "landing": [contact_name(profile.scene) for profile in profiles],
        "short name": short_names(profiles),
        "worst at": [_marks(places, shocks, k) for k in range(len(profiles))],
    }
    for place, values in zip(places, shocks.T.tolist(), strict=True):
        columns[f"{place.title} [-]"] = values
    columns |= _range_columns(profiles)
    # Peaks need a contact stiffness or a pulse, and margins a part: without these there is no
    # column.
    peaks = _peaks(profiles)
    if peaks is not None:
        columns[f"peak at {places[0].title} [g]"] = peaks
    margins = worst_margins(profiles)
    if margins is not None:
        columns["worst margin [-]"] = [margin for margin, _ in margins]
        columns["part"] = [part for _, part in margins]
    # What a designer of joints and feet asks for stands last.
    largest = [_largest(profile) for profile in profiles]
    columns[Heading("largest_joint_impulse", "impulse", "N s")] = [size for size, _ in largest]
    columns[Heading("through", "through joint")] = [joint for _, joint in largest]
    masses = [profile.effective_mass for profile in profiles]
    columns[Heading("effective_mass", "mass", "kg")] = masses
    normal_masses = [normal_mass(profile.landing) for profile in profiles]
    columns[Heading("normal_mass", "normal", "kg")] = normal_masses
    title = "shock |Δv| / v_in, a line for each landing"
    return Sheet.of(title, columns, _notes(profiles, places))


def _range_columns(profiles: Sequence[ShockProfile]) -> dict[str | Heading, Sequence[Cell]]:
    """The ends of the first number's range over the drives; none where no landing has one."""
    smallest, largest = range_ends(map(first_range, profiles))
    if all(end is None for end in smallest):
        return {}
    return {
        Heading("smallest_found", "smallest", "-"): smallest,
        Heading("largest_found", "largest", "-"): largest,
    }


def _notes(profiles: Sequence[ShockProfile], places: Sequence[Place]) -> list[str]:
    """Notes that explain the columns, and count the sensors and points without one."""
    notes = list(mass_notes(profiles))
    friction = sliding_friction(profiles[0])
    if friction is not None:
        notes.append(f"shock and joint impulse with friction {friction:g}")
    hidden: set[str] = set()
    for profile in profiles:
        hidden.update(place.name for place in profile.bracketed[1:])
    hidden -= {place.name for place in places}
    if hidden:
        notes.append(f"{len(hidden)} further sensors and points with --all")
    return notes


def landings_view(landings: Mapping[str, ShockProfile]) -> Sheet:
    """The table of `landings_sheet` with short names of landings, and with fewer places.

    These are the first place, and those that were asked for.
    """
    profiles = list(landings.values())
    shown = {first_place(profiles[0]).name, *asked_names(profiles[0])}
    hidden = [place for place in _places(profiles) if place.name not in shown]
    left_out = [Heading.of(f"{place.title} [-]").key for place in hidden]
    sheet = landings_sheet(landings).without("landing", *left_out)
    return sheet._replace(header=[Heading("short_name", "landing"), *sheet.header[1:]])


def _marks(places: Sequence[Place], shocks: np.ndarray, k: int) -> str:
    """The places at which a landing has the largest shock of all."""
    titles = []
    for place, values in zip(places, shocks.T, strict=True):
        if _worst(values) == k:
            titles.append(place.title)
    return few(titles, PLACES)


def _peaks(profiles: Sequence[ShockProfile]) -> list[float] | None:
    """Peak acceleration at the first place [g], of a landing that lasts or for a pulse.

    None without either.
    """
    first = profiles[0]
    if first.scene.yields:
        key = "peak_acceleration"
    elif first.scene.pulse is not None:
        key = "peak_g"
    else:
        return None
    if not first.points:
        return None
    place = first_place(first)
    return [float(profile.value(key, "point", [place])[0]) for profile in profiles]


def _largest(profile: ShockProfile) -> tuple[float, str]:
    """The largest impulse through a joint [N s], and its name; none where it is not determined."""
    places = profile.places("joint")
    if not places:
        return math.nan, "no joint"
    singular = any(warning.kind == "size" for warning in profile.health.warnings)
    if singular or not profile.row_space.unique.all():
        return math.nan, "not determined"
    sticks = sliding_friction(profile) is None
    values = profile.value("joint_impulse" if sticks else "joint_impulse_friction", "joint")
    return float(values.max()), places[int(values.argmax())].name
