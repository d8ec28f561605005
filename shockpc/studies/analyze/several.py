"""Several landings of one robot: one table with a line for each, and the answer in one line."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.header import landing_text
from shockpc.show.report import Report
from shockpc.show.tables import Cell, Row, Sheet, rounded
from shockpc.show.wording import contact_name
from shockpc.text.printed import few

PLACES = 3
"""Sensors and points in the table."""


class Reports(Mapping[str, Report]):
    """The report of each landing by its name, made when it is read: the table of several landings needs none of them."""

    def __init__(self, landings: Mapping[str, ShockProfile], make: Callable[[ShockProfile], Report]) -> None:
        self._landings, self._make, self._made = landings, make, dict[str, Report]()

    def __getitem__(self, name: str) -> Report:
        if name not in self._made:
            self._made[name] = self._make(self._landings[name])
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._landings)

    def __len__(self) -> int:
        return len(self._landings)


def _keys(landings: Mapping[str, ShockProfile]) -> tuple[str, str]:
    """Quantities of shocks and joint impulses: those with friction where a contact slides; of all landings the same."""
    slides = any(profile.friction is not None and profile.friction.impact is not None for profile in landings.values())
    return ("shock_friction", "joint_impulse_friction") if slides else ("shock", "joint_impulse")


def _shocks(landings: Mapping[str, ShockProfile]) -> tuple[list[str], np.ndarray]:
    """Names of the sensors and points, or of the heaviest body without any; shock (L, n) of the landings there."""
    first, shock = next(iter(landings.values())), _keys(landings)[0]
    places = first.moving_points
    if places:
        names = [place.name for place in places]
        values = [
            dict(zip([p.name for p in one.landing.points], one.value(shock, "point"), strict=True)) for one in landings.values()
        ]
        return names, np.array([[row[name] for name in names] for row in values])
    place = first.bracketed[0]
    rows = [one.values(quantity("body", shock.replace("shock", "shock_com")), [place]) for one in landings.values()]
    return [f"CoM of {place.name}"], np.array(rows)


def worst_text(landings: Mapping[str, ShockProfile]) -> str:
    """The shock at the sensors of the first landing, the worst on a single foot, and the worst of all if that is another."""
    names, shocks = _shocks(landings)
    profiles = list(landings.values())

    def text(k: int) -> str:
        return few([f"{name} {rounded(value)}" for name, value in zip(names, shocks[k], strict=True)], PLACES)

    of_first = shocks[:, 0]
    single = [k for k, profile in enumerate(profiles) if len(profile.scene.contact) == 1]
    worst = int(np.nanargmax(of_first)) if np.isfinite(of_first).any() else 0
    if len(profiles[0].scene.contact) == 1 or not single:
        return f"worst of {len(profiles)} landings, {landing_text(profiles[worst])}: {text(worst)}"
    foot = max(single, key=lambda k: float(np.nan_to_num(of_first[k])))
    texts = [
        f"{landing_text(profiles[0])}: {text(0)}",
        f"worst single foot {rounded(of_first[foot])} ({contact_name(profiles[foot])})",
    ]
    if worst not in (0, foot):
        texts.append(f"worst of all {rounded(of_first[worst])} ({landing_text(profiles[worst])})")
    return "; ".join(texts)


def level_text(given: ShockProfile, joint: ShockProfile) -> str:
    """Which feet are level with the contacts of a landing, and what landing on all of them gives. Args: joint, that landing."""
    struck = {block.body for block in given.landing.contacts}
    others = [block.frame for block in joint.landing.contacts if block.body not in struck]
    names, shocks = _shocks({"": joint})
    found = few([f"{name} {rounded(value)}" for name, value in zip(names, shocks[0], strict=True)], PLACES)
    low = f"{few(others, 8)} {'are' if len(others) > 1 else 'is'} as low (within {1e3 * given.scene.ground_tolerance:g} mm)"
    return f"{low}; with {'them' if len(others) > 1 else 'it'}, {landing_text(joint)}: {found}"


def whole_feet_text(given: ShockProfile, whole: ShockProfile) -> str:
    """What whole feet give, of which a landing strikes parts. Args: given, that landing; whole, on the feet."""
    named = {contact.frame for contact in whole.scene.contact}
    parts = [contact.frame for contact in given.scene.contact if contact.frame not in named]
    names, shocks = _shocks({"": whole})
    found = few([f"{name} {rounded(value)}" for name, value in zip(names, shocks[0], strict=True)], PLACES)
    are_parts = "are parts of feet that are" if len(parts) > 1 else "is one part of a foot that is"
    return f"{few(parts, 8)} {are_parts} as low elsewhere; {landing_text(whole)}: {found}"


def landings_sheet(landings: Mapping[str, ShockProfile]) -> Sheet:
    """A line for each landing: shocks, the joint models' bracket at the first place, the largest joint impulse, effective mass."""
    profiles = list(landings.values())
    (shock, impulse), (names, shocks) = _keys(landings), _shocks(landings)
    mu = profiles[0].scene.friction if shock != "shock" else None
    worst = [int(np.nanargmax(column)) if np.isfinite(column).any() else -1 for column in shocks.T[:PLACES]]
    peak = _peaks(profiles)
    header = ["landing", "worst at", *(f"{name} [-]" for name in names[:PLACES])]
    header += [f"joints free{_at(names)} [-]", f"locked{_at(names)} [-]", *([] if peak is None else [f"peak{_at(names)} [g]"])]
    header += ["largest joint impulse [N s]", "through", "effective mass [kg]"]
    rows: list[Row] = []
    for k, profile in enumerate(profiles):
        row = (
            profile.bracket[min(1, len(profile.bracket) - 1)]
            if names[0] != f"CoM of {profile.bracket[0].place}"
            else profile.bracket[0]
        )
        size, joint = _largest(profile, impulse)
        marks = [name for name, number in zip(names, worst, strict=False) if number == k]
        cells: list[Cell] = [
            contact_name(profile),
            few(marks, PLACES) if marks else "",
            *shocks[k, :PLACES].tolist(),
            row.free,
            row.locked,
        ]
        rows.append((*cells, *([] if peak is None else [peak[k]]), size, joint, profile.effective_mass))
    notes = [] if mu is None else [f"shock and joint impulse with friction {mu:g}; joints free and locked of contacts that stick"]
    if len(names) > PLACES:
        notes.append(f"{len(names) - PLACES} further sensors and points with --all")
    return Sheet("shock relative to the strike, a line for each landing", header, rows, notes)


def _at(names: Sequence[str]) -> str:
    """To which place a column belongs, where there are several."""
    return f", {names[0]}" if len(names) > 1 else ""


def _peaks(profiles: Sequence[ShockProfile]) -> list[float] | None:
    """Peak acceleration at the first sensor or point [g], on contacts of finite stiffness or for a pulse; None without either."""
    scene = profiles[0].scene
    key = "peak_acceleration" if scene.contact_stiffness is not None else "peak_g" if scene.pulse is not None else ""
    if not key or not profiles[0].points:
        return None
    return [float(profile.value(key, "point")[0]) for profile in profiles]


def _largest(profile: ShockProfile, key: str) -> tuple[float, str]:
    """The largest impulse through a joint [N s], and its name; none where it is not determined."""
    places = profile.places("joint")
    if not places or not profile.choice.unique.all() or any(one.kind == "size" for one in profile.health.warnings):
        return math.nan, "not determined" if places else "no joint"
    values = profile.value(key, "joint")
    return float(values.max()), places[int(values.argmax())].name
