"""Designs side by side: what changes from the first one to each of the others, ranked, partner by
partner.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

from shockpc.evaluation.column import selected
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.designs import Design
from shockpc.evaluation.drive_ends import End, at_drive_ends
from shockpc.evaluation.profiles import proven
from shockpc.evaluation.table import Table
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.record import Option
from shockpc.landing.scene import Scene
from shockpc.quantities.selection import Selection, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.changes import Change, changed, read_changes
from shockpc.studies.compare.partners import KINDS, Partners, matching, partners
from shockpc.text.errors import SceneError, ShockError, SolveError, StudyError
from shockpc.text.printed import listed
from shockpc.text.shown import brief, shown_by

STANDARD = (
    "shock",
    "shock_com",
    "shock_max",
    "ropc",
    "effective_mass_sticking",
    "effective_mass_frictionless",
    "joint_impulse",
    "joint_moment",
)
WITH_FRICTION = (
    "shock_friction",
    "shock_com_friction",
    "ropc_friction",
    "joint_impulse_friction",
    "joint_moment_friction",
)
"""Quantities that are always compared: of contacts that stick, or with friction where all designs
land with friction.
"""


class Difference(NamedTuple):
    """One number of every design.

    Attributes:
        place: name of the body, point, contact or joint.
        values: one for each design; None where it does not exist. An infinite radius is inf.
        body: of the first design that it belongs to; −1 for the robot and contacts.
        always: whether it is of the base, of the limb that is struck, or of a point, which short
            tables have too.
    """

    place: str
    values: tuple[float | None, ...]
    body: int
    always: bool

    @property
    def changes(self) -> tuple[float | None, ...]:
        """From the first design to each of the others; None where one of the two does not exist."""
        first = self.values[0]
        return tuple(
            None if first is None or value is None else 0.0 if value == first else value - first
            for value in self.values[1:]
        )


class Differences(NamedTuple):
    """A quantity at all places that the designs have in common.

    Attributes:
        selection: the quantity.
        rows: the limb that is struck first, from the contact up, then the largest change first; of
            radii of percussion that of their reciprocals, the shock per metre.
    """

    selection: Selection
    rows: tuple[Difference, ...]


class Unmatched(NamedTuple):
    """What some designs lack.

    Attributes:
        kind: "body", "point" or "joint".
        name: its name.
        designs: indices of those that have it.
    """

    kind: PlaceKind
    name: str
    designs: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Designs side by side.

    Attributes:
        designs: the first is the one that the others are compared with.
        profiles: of their landings.
        quantities: what was compared, of what all designs have.
        unmatched: what has no partner in every other design.
        partners: of the first design's bodies, points and joints, in each of the others.
        ends: the comparison with all drives of all designs at the smallest inertias that what is
            known allows, and at the largest, or why there is none; empty where all drives are known
            exactly.
    """

    designs: tuple[Design, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    quantities: tuple[Differences, ...]
    unmatched: tuple[Unmatched, ...]
    partners: tuple[Partners, ...] = field(repr=False)
    ends: Mapping[End, "Comparison | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.compare.report:compare_report")

    def __repr__(self) -> str:
        return brief(
            self,
            " against ".join(design.label for design in self.designs),
            f"{len(self.quantities)} quantities",
        )

    @property
    def letters(self) -> list[str]:
        """What tables call the designs."""
        return [
            chr(ord("A") + k) if k < 26 else f"design {k + 1}" for k in range(len(self.designs))
        ]

    @property
    def table(self) -> Table:
        """A row for each quantity at each place that the designs have in common: its values, and
        their changes from the first.
        """
        first, *others = self.letters
        rows = []
        for differences in self.quantities:
            for row in differences.rows:
                named = (
                    differences.selection.name,
                    differences.selection.quantity.unit.replace("1", "-"),
                    row.place,
                )
                shares = (
                    100.0 * x / abs(row.values[0]) if x is not None and row.values[0] else None
                    for x in row.changes
                )
                rows.append(
                    (
                        *named,
                        *row.values,
                        *row.changes,
                        *(x if x is None or math.isfinite(x) else None for x in shares),
                    )
                )
        changes = (
            *(f"{name} - {first}" for name in others),
            *(f"change of {name} [%]" for name in others),
        )
        return Table.of_rows(("quantity", "unit", "place", first, *others, *changes), rows)


def design_with(design: Design, changes: Sequence[Change]) -> Design:
    """A design with its robot changed.

    Raises:
        UnknownName: a pattern matches no link, or no joint.
        StudyError: a changed armature has no effect, because the scene sets that of the same joint.
    """
    joints = design.scene.joints
    for change in changes:
        if change.what != "armature":
            continue
        given = [
            name
            for pattern in (*joints.armature, *joints.rotor)
            for name in design.robot.match_joints(pattern)
        ]
        covered = [name for name in design.robot.match_joints(change.pattern) if name in given]
        file = joints.drives if joints.drives != "none" else None
        if covered or joints.model == "free" or file:
            why = (
                f'sets that of joint "{covered[0]}"'
                if covered
                else f"takes the drives from {file}"
                if file
                else "makes all joints free"
            )
            raise StudyError(
                f"change {change} has no effect, because the scene {why}; leave one of the two out"
            )
    robot = replace(design.robot, default_drives=None) if joints.drives == "none" else design.robot
    label = "; ".join([design.label, *map(str, changes)])
    return Design(label, design.scene, changed(robot, changes), (*design.changes, *changes))


@study(
    'shockpc compare go2 --contact FL_foot --change "mass:*_calf=0.9x"',
    "shockpc compare anymal_b anymal_c --contact LF_FOOT --out compare/",
    more=(
        "The options of the landing hold for every design. Give one --contact for all designs, or "
        "one for each. With --friction the numbers are with friction."
    ),
    reads="designs",
)
def compare(
    designs: Iterable[Design | Scene | str],
    quantities: QuantityOption = (),
    pairs: Annotated[
        Sequence[tuple[str, str]],
        Option(
            "Partners with different names: a body, joint or point of the first design and of the "
            "others. A * in both stands for the same text. By default names are equal.",
            "Designs",
            "A=B",
            "pair",
        ),
    ] = (),
    *,
    changes: Annotated[
        Sequence[str],
        Option(
            "Another design, as changes of the given design, such as 'mass:*_shank=0.9x; "
            "armature:*=0.01': "
            "mass, point-mass (added), inertia (a factor), inertia-xx … -yz (added), com-x, -y, -z "
            "(moved by) of links, "
            "armature of joints, place of joints (also fixed joints) in the frame of the link that "
            "carries them, "
            "such as 'place:*_KFE=0,0,-0.3' or =1.1x for "
            "longer thighs.",
            "Designs",
            "CHANGES",
            "change",
        ),
    ] = (),
) -> Comparison:
    """Compute the landings of some designs, and what differs.

    Args:
        designs: the first is the one that the others are compared with.

    Raises:
        ShockError: there are fewer than two designs, one of them cannot be computed, or lacks a
            place that is named; or a quantity has no value at any place that all of them have.
    """
    every = tuple(map(Design.of, designs))
    if changes and len(every) > 1:
        raise StudyError(
            "--change makes designs from one file, but several files are given; give one file, or "
            "a file for each design"
        )
    read = [read_changes(text) for text in changes]
    every += tuple(design_with(every[0], of_design) for of_design in read)
    if len(every) < 2:
        raise StudyError(
            "a single design cannot be compared; give a second one, or a change with --change"
        )
    slides = all(design.scene.friction is not None for design in every)
    texts = tuple(dict.fromkeys((*quantities, *(WITH_FRICTION if slides else STANDARD))))
    profiles = _profiles(every, [select(text.partition("@")[0]) for text in texts])
    for pair in pairs:
        if not any(any(matching(profiles[0], profile, *pair).values()) for profile in profiles[1:]):
            names = "; ".join(
                f"bodies of {design.label}: {', '.join(profile.bodies)}"
                for design, profile in zip(every, profiles, strict=True)
            )
            raise StudyError(
                f'--pair "{"=".join(pair)}" names no body, joint or point of both designs; {names}'
            )
    matched = tuple(partners(profiles[0], profile, pairs) for profile in profiles[1:])
    differences = {text: _differences(profiles, matched, text) for text in texts}
    for text in quantities:
        if not differences[text].rows:
            raise StudyError(_nothing(every, profiles, matched, text))
    modelled = Comparison(
        every,
        profiles,
        tuple(filter(lambda table: table.rows, differences.values())),
        _unmatched(profiles, matched),
        matched,
    )

    def at_end(scenes: dict[str, Scene]) -> Comparison:
        others = [
            replace(design, scene=scene)
            for design, scene in zip(every, scenes.values(), strict=True)
        ]
        return compare(others, quantities, pairs)

    cases = {str(k): (design.scene, design.robot) for k, design in enumerate(every)}
    return replace(modelled, ends=at_drive_ends(modelled, cases, at_end))


def _nothing(
    designs: Sequence[Design],
    profiles: Sequence[ShockProfile],
    matched: Sequence[Partners],
    text: str,
) -> str:
    """Why a quantity cannot be compared: designs without a place in common, or values that are
    missing.
    """
    selections = [selected(profile.landing, text.partition("@")[0]) for profile in profiles]
    quantity, names = (
        selections[0][0].quantity,
        [[place.name for place in places] for _, places in selections],
    )
    if quantity.of in ("robot", "contact"):
        apart, rule = len({*map(len, names)}) > 1, "their number has to be the same"
    else:
        apart, rule = (
            not all(known[quantity.of] for known in matched),
            "partners have the same name, or are given by --pair",
        )
    if not apart:
        why = quantity.scope.missing or "it is not defined there"
        return (
            f'"{text}" has no value at any {quantity.of} that the designs have in common: {why}; '
            f"leave it out"
        )
    owned = ", ".join(
        f"of {design.label} {listed(some, 4) or 'none'}"
        for design, some in zip(designs, names, strict=True)
    )
    return (
        f'"{text}" cannot be compared, because the designs have no {quantity.of}s in common: '
        f"{owned}; {rule}"
    )


def _profiles(
    designs: Sequence[Design], selections: Sequence[Selection]
) -> tuple[ShockProfile, ...]:
    """The profiles of designs; a refusal names the design."""
    results = proven(
        {str(k): (design.scene, design.robot) for k, design in enumerate(designs)}, selections
    )
    for design, result in zip(designs, results.values(), strict=True):
        if isinstance(result, (SceneError, SolveError)):
            raise type(result)(f"{design.label}: {result}", **result.data)
        if isinstance(result, ShockError):
            raise result
    return tuple(result for result in results.values() if isinstance(result, ShockProfile))


def _differences(
    profiles: Sequence[ShockProfile], matched: Sequence[Partners], text: str
) -> Differences:
    """The numbers of what all designs have."""
    selection, first = selected(profiles[0].landing, text)
    columns = [
        first,
        *(
            _partners_of(first, profile, match, text)
            for profile, match in zip(profiles[1:], matched, strict=True)
        ),
    ]
    rows = (
        [places for places in zip(*columns, strict=True) if None not in places]
        if len({*map(len, columns)}) == 1
        else []
    )
    numbers = [
        profile.numbers(selection, partners).tolist()
        for profile, partners in zip(profiles, zip(*rows, strict=True), strict=False)
    ]
    robot = profiles[0].robot
    order = list(
        dict.fromkeys(
            i
            for contact in profiles[0].scene.contact
            for i in robot.limb(robot.frame(contact.frame).body)
        )
    )
    differences = []
    for places, values in zip(rows, zip(*numbers, strict=True), strict=True):
        body = places[0].body
        always = body in (0, *order) or selection.quantity.of == "point"
        known = tuple(None if math.isnan(x) else x for x in values)
        differences.append(
            Difference(
                " / ".join(dict.fromkeys(place.name for place in places)), known, body, always
            )
        )
    differences = [row for row in differences if any(value is not None for value in row.values)]

    def rank(row: Difference) -> tuple[int, float]:
        above = (
            order.index(row.body)
            if row.body in order and selection.quantity.of != "point"
            else len(order)
        )
        return above, -_size(row, bool(selection.quantity.relations.reciprocal))

    return Differences(selection, tuple(sorted(differences, key=rank)))


def _partners_of(
    first: Sequence[Place], profile: ShockProfile, matched: Partners, text: str
) -> list[Place | None]:
    """The places of another design that are partners of those of the first; robots and contacts in
    their order.
    """
    selection, kind = text.partition("@")[0], select(text.partition("@")[0]).quantity.of
    if kind in ("robot", "contact"):
        return list(selected(profile.landing, text)[1])
    known = {place.name: place for place in profile.places(kind)}
    partners_ = [known.get(matched[kind].get(place.name, "")) for place in first]
    if "@" in text and partners_ == [None]:  # a point that is not one of the scene's
        return list(selected(profile.landing, f"{selection}@{first[0].name}")[1])
    return partners_


def _size(row: Difference, reciprocal: bool) -> float:
    """The largest change, or that of the reciprocals: of an infinite radius of percussion the shock
    per metre is finite.
    """
    first, *others = (
        None if value is None else 1.0 / value if reciprocal else value for value in row.values
    )
    return max(
        (abs(value - first) for value in others if value is not None and first is not None),
        default=-1.0,
    )


def _unmatched(
    profiles: Sequence[ShockProfile], matched: Sequence[Partners]
) -> tuple[Unmatched, ...]:
    """Bodies, points and joints that are not partners of one of every other design."""
    unmatched = []
    for kind in KINDS:
        having: dict[str, list[int]] = {}
        for place in profiles[0].places(kind):
            owners = [k for k, known in enumerate(matched, start=1) if place.name in known[kind]]
            having |= {place.name: [0, *owners]} if len(owners) < len(matched) else {}
        for k, (profile, known) in enumerate(zip(profiles[1:], matched, strict=True), start=1):
            for place in profile.places(kind):
                if place.name not in known[kind].values():
                    having.setdefault(place.name, []).append(k)
        unmatched += [Unmatched(kind, name, tuple(owners)) for name, owners in having.items()]
    return tuple(unmatched)
