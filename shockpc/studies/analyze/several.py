"""Several landings of one robot: one table with a line for each, and the answer in one line."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from shockpc.judgement.first_number import first_place, first_range, shock_of, worst_place
from shockpc.landing.places import Place
from shockpc.quantities.contact_mass import normal_mass
from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.header import landing_text
from shockpc.show.report import Report
from shockpc.show.tables import Cell, Column, Sheet, rounded
from shockpc.show.wording import contact_name
from shockpc.studies.analyze.first_lines import (
    asked_names,
    drives_text,
    ends_text,
    mass_notes,
    short_names,
    sliding_friction,
    worst_margins,
)
from shockpc.text.printed import few

PLACES = 3
"""Sensors and points in the table."""


class Reports(Mapping[str, Report]):
    """The report of each landing by its name, made when it is read: the table of several landings
    needs none of them.
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
    """The first place of the first landing, the points that were asked for, and the worst place of
    all landings.
    """
    first = profiles[0]
    asked = [place for place in first.bracketed[1:] if place.name in asked_names(first)]
    worst = [
        (_shock(profile, place), place)
        for profile in profiles
        if (place := worst_place(profile)) is not None
    ]
    places = [
        first_place(first),
        *asked[: PLACES - 2],
        *([max(worst, key=lambda one: one[0])[1]] if worst else []),
    ]
    return list({place.name: place for place in places}.values())


def _shock(profile: ShockProfile, place: Place) -> float:
    """The shock of a landing at a place of another landing of the robot."""
    return float(profile.numbers(shock_of(profile), [place])[0])


def _worst(values: np.ndarray) -> int:
    """The number of the largest value that is known; 0 without any."""
    return int(np.nanargmax(values)) if np.isfinite(values).any() else 0


def worst_text(landings: Mapping[str, ShockProfile]) -> str:
    """The shock at the first place of the first landing, on the worst single foot, and the worst of
    all if that is another.
    """
    profiles = list(landings.values())
    place, *others = _places(profiles)
    shocks = np.array([_shock(profile, place) for profile in profiles])
    single = [k for k, profile in enumerate(profiles) if len(profile.scene.contact) == 1]
    worst = _worst(shocks)

    def text(k: int, where: str = "") -> str:
        ends = ends_text(first_range(profiles[k]))
        words = filter(None, (where, ends, "" if where or not ends else drives_text(profiles[k])))
        return f"{rounded(shocks[k])}" + (f" ({'; '.join(words)})" if where or ends else "")

    if len(profiles[0].scene.contact) == 1 or not single:
        texts = [
            f"worst of {len(profiles)} landings, {landing_text(profiles[worst])}: {place.title} "
            f"{text(worst)}"
        ]
    else:
        foot = single[_worst(shocks[single])]
        texts = [
            f"{landing_text(profiles[0])}: {place.title} {text(0)}",
            f"worst single foot {text(foot, contact_name(profiles[foot]))}",
        ]
        if worst not in (0, foot):
            texts.append(f"worst of all {text(worst, landing_text(profiles[worst]))}")
    names = short_names(profiles)
    for other in others:
        values = np.array([_shock(profile, other) for profile in profiles])
        texts.append(
            f"{other.title} up to {rounded(values[_worst(values)])} ({names[_worst(values)]})"
        )
    return "; ".join(texts)


def level_text(given: ShockProfile, joint: ShockProfile) -> str:
    """Which feet are level with the contacts of a landing, and what landing on all of them gives.

    Args: joint, that landing.
    """
    struck = {block.body for block in given.landing.contacts}
    others = [block.frame for block in joint.landing.contacts if block.body not in struck]
    found = _first_text(given, joint)
    low = (
        f"{few(others, 8)} {'are' if len(others) > 1 else 'is'} as low (within "
        f"{1e3 * given.scene.ground_tolerance:g} mm)"
    )
    return f"{low}; with {'them' if len(others) > 1 else 'it'}, {landing_text(joint)}: {found}"


def _first_text(given: ShockProfile, other: ShockProfile) -> str:
    """The shock of another landing at the first place of one that is given."""
    place = first_place(given)
    return f"{place.title} {rounded(_shock(other, place))}"


def whole_feet_text(given: ShockProfile, whole: ShockProfile) -> str:
    """What whole feet give, of which a landing strikes parts.

    Args: given, that landing; whole, on the feet.
    """
    named = {contact.frame for contact in whole.scene.contact}
    parts = [contact.frame for contact in given.scene.contact if contact.frame not in named]
    found = _first_text(given, whole)
    are_parts = "are only parts of feet" if len(parts) > 1 else "is only part of a foot"
    return (
        f"{few(parts, 8)} {are_parts}, and other parts are as low; {landing_text(whole)}: {found}"
    )


def landings_sheet(landings: Mapping[str, ShockProfile]) -> Sheet:
    """A line for each landing: shocks, the range of the first over the drives, margins, the largest
    joint impulse, masses.
    """
    profiles = list(landings.values())
    places, mu = _places(profiles), sliding_friction(profiles[0])
    shocks = np.array([[_shock(profile, place) for place in places] for profile in profiles])
    columns: dict[str | Column, Sequence[Cell]] = {
        "landing": [contact_name(profile) for profile in profiles]
    }
    columns["short name"] = short_names(profiles)
    columns["worst at"] = [_marks(places, shocks, k) for k in range(len(profiles))]
    for place, values in zip(places, shocks.T.tolist(), strict=True):
        columns[f"{place.title} [-]"] = values
    ranges = [first_range(profile) for profile in profiles]
    if any(found is not None for found in ranges):
        columns[Column("smallest_found", "smallest", "-")] = [
            None if one is None else one.smallest for one in ranges
        ]
        columns[Column("largest_found", "largest", "-")] = [
            None if one is None else one.largest for one in ranges
        ]
    if (peaks := _peaks(profiles)) is not None:
        columns[f"peak at {places[0].title} [g]"] = peaks
    if (margins := worst_margins(profiles)) is not None:
        columns["worst margin [-]"], columns["part"] = zip(*margins, strict=True)
    (
        columns[Column("largest_joint_impulse", "impulse", "N s")],
        columns[Column("through", "through joint")],
    ) = zip(*(_largest(profile) for profile in profiles), strict=True)
    columns[Column("effective_mass", "mass", "kg")] = [
        profile.effective_mass for profile in profiles
    ]
    columns[Column("normal_mass", "normal", "kg")] = [
        normal_mass(profile.landing) for profile in profiles
    ]
    notes = list(mass_notes(profiles))
    notes += [] if mu is None else [f"shock and joint impulse with friction {mu:g}"]
    hidden = len(
        {place.name for profile in profiles for place in profile.bracketed[1:]}
        - {place.name for place in places}
    )
    notes += [f"{hidden} further sensors and points with --all"] if hidden else []
    return Sheet.of("shock |Δv| / v_in, a line for each landing", columns, notes)


def landings_view(landings: Mapping[str, ShockProfile]) -> Sheet:
    """The same with short names of landings; of the places the first and those that were asked for."""
    profiles = list(landings.values())
    shown = {first_place(profiles[0]).name, *asked_names(profiles[0])}
    left = [
        Column.of(f"{place.title} [-]").key
        for place in _places(profiles)
        if place.name not in shown
    ]
    sheet = landings_sheet(landings).without("landing", *left)
    return sheet._replace(header=[Column("short_name", "landing"), *sheet.header[1:]])


def _marks(places: Sequence[Place], shocks: np.ndarray, k: int) -> str:
    """The places at which a landing has the largest shock of all."""
    return few(
        [
            place.title
            for place, values in zip(places, shocks.T, strict=True)
            if _worst(values) == k
        ],
        PLACES,
    )


def _peaks(profiles: Sequence[ShockProfile]) -> list[float] | None:
    """Peak acceleration at the first place [g], of a landing that lasts or for a pulse; None without
    either.
    """
    scene, place = profiles[0].scene, first_place(profiles[0])
    key = "peak_acceleration" if scene.yields else "peak_g" if scene.pulse is not None else ""
    if not key or not profiles[0].points:
        return None
    return [float(profile.values(quantity("point", key), [place])[0]) for profile in profiles]


def _largest(profile: ShockProfile) -> tuple[float, str]:
    """The largest impulse through a joint [N s], and its name; none where it is not determined."""
    places, key = (
        profile.places("joint"),
        "joint_impulse" if sliding_friction(profile) is None else "joint_impulse_friction",
    )
    if (
        not places
        or not profile.row_space.unique.all()
        or any(one.kind == "size" for one in profile.health.warnings)
    ):
        return math.nan, "not determined" if places else "no joint"
    values = profile.value(key, "joint")
    return float(values.max()), places[int(values.argmax())].name
