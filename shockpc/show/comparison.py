"""The report of a comparison, with a table for each quantity, the largest change first.

It also says what each letter stands for, and what has no partner.
"""

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, TypeAlias

from shockpc.evaluation.comparison import Comparison, Differences
from shockpc.evaluation.designs import Design
from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND, MOVED, End
from shockpc.landing.contact import contact_name
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.header import other_warnings, strike_text, unknown_lines
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Heading, Lines, Row, Sheet, sheet_of
from shockpc.text.diagnostic import alike
from shockpc.text.errors import ShockError
from shockpc.text.printed import count, few

Values: TypeAlias = tuple[float | None, ...]
"""A number of each design; None where it does not exist."""

ROUNDED = 1e-12
"""Difference of numbers that rounding leaves, in their units."""


ROWS = 8
"""Rows of each table in the short report."""


def compare_report(comparison: Comparison) -> Report:
    """Designs side by side."""
    header = _header(comparison)
    picture = Picture(
        "compare",
        "what changes between the designs",
        "show.figure.comparison:draw_comparison",
        (comparison, header),
    )
    profiles: dict[str, ShockProfile] = {}
    for letter, design, profile in _designs(comparison):
        profiles[f"{letter}: {design.label}"] = profile

    def body(full: bool) -> list[Section]:
        most = None if full else ROWS
        sections: list[Section] = [Lines([*header, *_unknowns(comparison)]), picture]
        for differences in comparison.quantities:
            sections.append(_sheet(comparison, differences, most))
        if _moved(comparison):
            sections.append(_drives(comparison, most))
        return sections

    sheets: dict[str, Callable[[], Sheet]] = {"compare": lambda: sheet_of(comparison.table)}
    if comparison.ends:
        sheets["drives"] = lambda: _drives(comparison)
    return Report(
        name="compare",
        title="Comparison",
        body=body,
        lead=2,
        closing=[
            *_over_drives(comparison),
            *_joint_models(comparison),
            *_paired(comparison),
            *_unmatched(comparison),
            *_unproven(comparison),
        ],
        warnings=_warnings(comparison),
        sheets=sheets,
        document=lambda: _document(comparison),
        tables=True,
        landings=profiles,
    )


def _designs(comparison: Comparison) -> Iterator[tuple[str, Design, ShockProfile]]:
    """The letter, the design and the profile of each."""
    return zip(comparison.letters, comparison.designs, comparison.profiles, strict=True)


def _header(comparison: Comparison) -> list[tuple[str, str]]:
    """The letter of each design, and what it is."""
    lines = []
    for letter, design, profile in _designs(comparison):
        (mass,) = profile.value("mass", "robot").tolist()
        lines.append(
            (
                letter,
                f"{design.label}: on {contact_name(profile.scene)}, {strike_text(profile)}, joints "
                f"{profile.joint_model}, {mass:.4g} kg",
            )
        )
    return lines


def _unknowns(comparison: Comparison) -> list[tuple[str, str]]:
    """The assumptions of each design."""
    lines = []
    for letter, _, profile in _designs(comparison):
        for name, text in unknown_lines([profile]):
            lines.append((name, f"{letter}: {text}"))
    return lines


class _Number(NamedTuple):
    """A number of all designs, as modelled and at the ends of the drives.

    Attributes:
        quantity: its name.
        unit: of it.
        place: where.
        modelled: of each design.
        ends: of each design, by end; only of ends that have it.
    """

    quantity: str
    unit: str
    place: str
    modelled: Values
    ends: dict[End, Values]

    @property
    def moves(self) -> bool:
        """True if the number of a design differs by more than 1 % between the ends."""
        for values in self.ends.values():
            for modelled, value in zip(self.modelled, values, strict=True):
                if modelled is not None and value is not None and _order(modelled, value):
                    return True
        return False

    @property
    def reversed(self) -> bool:
        """True if a design has more than the first one at one end, and less at another.

        Each differs by more than 1 %.
        """
        first, *others = zip(self.modelled, *self.ends.values(), strict=True)
        for design in others:
            orders = {_order(a, b) for a, b in zip(first, design, strict=True)}
            if {1, -1} <= orders:
                return True
        return False


def _order(first: float | None, value: float | None) -> int:
    """1 if a value is more than the first one, −1 if it is less.

    0 where they differ by at most 1 %, or one of them does not exist.
    """
    if first is None or value is None:
        return 0
    if math.isclose(first, value, rel_tol=MOVED, abs_tol=ROUNDED):
        return 0
    return 1 if value > first else -1


def _numbers(comparison: Comparison) -> list[_Number]:
    """All numbers, at the ends too."""
    at_ends: dict[End, dict[tuple[str, str], Values]] = {}
    for end, result in comparison.ends.items():
        if isinstance(result, Comparison):
            at_ends[end] = {}
            for entry in result.quantities:
                for row in entry.rows:
                    at_ends[end][entry.selection.name, row.place] = row.values
    numbers = []
    for entry in comparison.quantities:
        unit = entry.selection.quantity.unit_text
        for row in entry.rows:
            key = entry.selection.name, row.place
            ends = {end: values[key] for end, values in at_ends.items() if key in values}
            numbers.append(_Number(entry.selection.name, unit, row.place, row.values, ends))
    return numbers


def _moved(comparison: Comparison) -> bool:
    """True if some number differs by more than 1 % between the ends of the drives."""
    return bool(comparison.ends) and any(number.moves for number in _numbers(comparison))


def _drives(comparison: Comparison, most: int | None = None) -> Sheet:
    """Every number of every design at the ends.

    Args:
        comparison: of the designs.
        most: rows to show, those first whose order changes; None for all.
    """
    letters, numbers = comparison.letters, _numbers(comparison)
    ends = [f"{letter} {end}" for letter, end in itertools.product(letters, comparison.ends)]
    nothing: Values = (None,) * len(letters)
    rows: list[Row] = []
    for number in numbers:
        by_end = [number.ends.get(end, nothing) for end in comparison.ends]
        by_design = itertools.chain.from_iterable(zip(*by_end, strict=True))
        same_order = not number.reversed
        rows.append((number.quantity, number.unit, number.place, *by_design, same_order))
    sheet = Sheet(AT_BOTH, ("quantity", "unit", "place", *ends, "same order"), rows, [BEYOND])
    # Numbers whose order changes come first, then those in the order of the tables.
    n = len(numbers)
    sizes = [n * (1 + number.reversed) - k for k, number in enumerate(numbers)]
    return sheet.largest(most, "number", sizes)


def _over_drives(comparison: Comparison) -> list[str]:
    """Lines on whether it depends on the drives which design has less."""
    if not comparison.ends:
        return []
    lines = []
    for end, result in comparison.ends.items():
        if isinstance(result, ShockError):
            lines.append(f"with the {end} inertias of the drives there is no answer: {result}")
    numbers = _numbers(comparison)
    changing = [f"{number.quantity}@{number.place}" for number in numbers if number.reversed]
    if not any(number.moves for number in numbers):
        lines.append(f"drives: from {BETWEEN}, no number changes by more than 1 %")
    elif not changing:
        lines.append(f"drives: numbers change from {BETWEEN}, and the order of the designs stays")
    else:
        named = f"{len(changing)} of {len(numbers)} numbers: {few(changing, 4)}"
        lines.append(f"drives: from {BETWEEN}, the order of the designs changes for {named}")
    return lines


def _document(comparison: Comparison) -> dict[str, Any]:
    labels = [design.label for design in comparison.designs]
    unmatched = []
    for entry in comparison.unmatched:
        designs = [labels[k] for k in entry.designs]
        unmatched.append({**record(entry, "kind", "name"), "designs": designs})
    return {
        "designs": [
            {
                "label": design.label,
                "robot": profile.robot.label,
                "changes": design.changes,
                "joint_model": profile.joint_model,
                "error_bound": profile.health.error_bound,
                "scene": profile.scene,
                "warnings": profile.health.warnings,
            }
            for design, profile in zip(comparison.designs, comparison.profiles, strict=True)
        ],
        "quantities": [
            {"quantity": entry.selection.name, **record(entry.selection.quantity, "title", "unit")}
            for entry in comparison.quantities
        ],
        "unmatched": unmatched,
    }


def _paired(comparison: Comparison) -> list[str]:
    """Partners of different names."""
    first, *others = comparison.letters
    lines = []
    for letter, matched in zip(others, comparison.partners, strict=True):
        bodies = [f"{a} / {b}" for a, b in matched["body"].items() if a != b]
        if bodies:
            lines.append(f"partners by --pair in {first} / {letter}: {', '.join(bodies)}")
    return lines


def _joint_models(comparison: Comparison) -> list[str]:
    """That the designs have different joint models, of which the changes are an effect too."""
    models = [profile.joint_model for profile in comparison.profiles]
    if len(set(models)) == 1:
        return []
    pairs = zip(comparison.letters, models, strict=True)
    each = ", ".join(f"{letter} {model}" for letter, model in pairs)
    return [
        f"the joint models differ ({each}), which is part of the changes; --joints free compares "
        f"the designs without drives"
    ]


def _unmatched(comparison: Comparison) -> list[str]:
    """Lines on what some designs lack a partner for, by kind and by the designs that have it."""
    groups: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for place in comparison.unmatched:
        groups.setdefault((place.kind, place.designs), []).append(place.name)
    lines = []
    for (kind, designs), names in groups.items():
        letters = " and ".join(comparison.letters[k] for k in designs)
        lines.append(f"only in {letters}: {count(len(names), kind)}: {', '.join(names)}")
    return lines


def _unproven(comparison: Comparison) -> list[str]:
    """Lines on numbers without a proof: those with friction, or of a landing that lasts."""
    quantities = [entry.selection for entry in comparison.quantities]
    scenes = [profile.scene for profile in comparison.profiles]
    names = []
    for selection in quantities:
        if any(map(selection.quantity.of_ground, scenes)):
            names.append(selection.name)
    return [f"in double precision: {few(names, 6)}"] if names else []


def _warnings(comparison: Comparison) -> list[str]:
    """A line for each cause of warnings, with its designs and the text of the worst."""
    pairs = []
    for letter, _, profile in _designs(comparison):
        pairs += [(warning, letter) for warning in other_warnings(profile)]
    lines = []
    for group in alike(pairs):
        worst, letter = group[0]
        letters = sorted({letter for _, letter in group})
        line = f"warning of {' and '.join(letters)}: {worst}"
        if len({str(warning) for warning, _ in group}) > 1:
            line += f" (in {letter})"
        lines.append(line)
    return lines


def _sheet(comparison: Comparison, differences: Differences, most: int | None) -> Sheet:
    """The table of one quantity.

    Args:
        comparison: of the designs.
        differences: of the quantity.
        most: rows to show, those of the largest changes; None for all.
    """
    selection, quantity = differences.selection, differences.selection.quantity
    sheet = sheet_of(comparison.table).where(lambda row: row["quantity"] == selection.name)
    sheet = sheet.without("quantity", "unit")
    unit = quantity.unit_text
    values = [heading._replace(unit=heading.unit or unit) for heading in sheet.headings[1:]]
    title = f"{quantity.title} ({selection.name})"
    sheet = sheet._replace(title=title, header=[Heading("place", quantity.of), *values])
    # Rows are in the order of their sizes, but for those that every table has.
    sizes = [-float(k) for k in range(len(differences.rows))]
    for k, row in enumerate(differences.rows):
        if row.always:
            sizes[k] = math.inf
    sheet = sheet.largest(most, quantity.of, sizes)
    notes = []
    if quantity.scope.shared and any(profile.redundant for profile in comparison.profiles):
        notes.append("of the contact impulses of minimum norm, because rows are redundant")
    reciprocal = quantity.relations.reciprocal
    if reciprocal:
        notes.append(f"ranked by the change of {reciprocal}")
    return sheet._replace(notes=(*notes, *sheet.notes))
