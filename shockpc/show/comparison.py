"""A comparison: what each letter stands for, one table for each quantity with the largest change
first, and what has no partner.
"""

import math
from typing import Any, NamedTuple, TypeAlias

from shockpc.evaluation.comparison import Comparison, Differences
from shockpc.evaluation.drive_ends import AT_BOTH, BETWEEN, BEYOND, MOVED, End
from shockpc.show.document import record
from shockpc.show.header import other_warnings, strike_text, unknown_lines
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Row, Sheet, sheet_of
from shockpc.show.wording import contact_name
from shockpc.text.diagnostic import alike
from shockpc.text.errors import ShockError
from shockpc.text.printed import count, few

Values: TypeAlias = tuple[float | None, ...]
"""A number of each design; None where it does not exist."""

ROUNDED = 1e-12
"""Difference of numbers that rounding leaves, in their units."""


def compare_report(comparison: Comparison) -> Report:
    """Designs side by side."""
    designs, profiles = comparison.designs, comparison.profiles
    letters = comparison.letters
    header = [
        (
            letter,
            f"{design.label}: on {contact_name(profile)}, {strike_text(profile)}, joints "
            f"{profile.joint_model}, "
            f"{float(profile.value('mass', 'robot')[0]):.4g} kg",
        )
        for letter, design, profile in zip(letters, designs, profiles, strict=True)
    ]
    return Report(
        name="compare",
        title="Comparison",
        body=lambda full: [
            Lines([*header, *_unknowns(comparison)]),
            Picture(
                "compare",
                "what changes between the designs",
                "show.figure.comparison:draw_comparison",
                (comparison, header),
            ),
            *(
                _sheet(comparison, differences, None if full else 8)
                for differences in comparison.quantities
            ),
            *([_drives(comparison, None if full else 8)] if _moved(comparison) else []),
        ],
        lead=2,
        closing=[
            *_over_drives(comparison),
            *_joint_models(comparison, letters),
            *_paired(comparison, letters),
            *_unmatched(comparison, letters),
            *_unproven(comparison),
        ],
        warnings=_warnings(comparison, letters),
        sheets={"compare": lambda: sheet_of(comparison.table)}
        | ({"drives": lambda: _drives(comparison)} if comparison.ends else {}),
        document=lambda: _document(comparison),
        tables=True,
        landings={
            f"{k}: {design.label}": profile
            for k, design, profile in zip(letters, designs, profiles, strict=True)
        },
    )


def _unknowns(comparison: Comparison) -> list[tuple[str, str]]:
    """What each design takes for granted."""
    pairs = zip(comparison.letters, comparison.profiles, strict=True)
    return [
        (name, f"{letter}: {text}")
        for letter, profile in pairs
        for name, text in unknown_lines([profile])
    ]


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
        """Whether the number of a design differs by more than 1 % between the ends."""
        every = [self.modelled, *self.ends.values()]
        return any(
            not math.isclose(a, b, rel_tol=MOVED, abs_tol=ROUNDED)
            for one in every
            for a, b in _both(self.modelled, one)
        )

    @property
    def reversed(self) -> bool:
        """Whether a design has more than the first one at one end, and less at another, each by
        more than 1 %.
        """
        orders = [_order(values) for values in (self.modelled, *self.ends.values())]
        return any({1, -1} <= set(signs) for signs in zip(*orders, strict=True))


def _both(one: Values, another: Values) -> list[tuple[float, float]]:
    """Pairs of values that both exist."""
    return [(a, b) for a, b in zip(one, another, strict=True) if a is not None and b is not None]


def _order(values: Values) -> list[int]:
    """Whether each of the other designs has more (1) or less (−1) than the first one; 0 where they
    differ by at most 1 %.
    """
    first, *others = values
    signs = []
    for value in others:
        if (
            first is None
            or value is None
            or math.isclose(first, value, rel_tol=MOVED, abs_tol=ROUNDED)
        ):
            signs.append(0)
        else:
            signs.append(1 if value > first else -1)
    return signs


def _numbers(comparison: Comparison) -> list[_Number]:
    """All numbers, at the ends too."""
    found: dict[End, dict[tuple[str, str], Values]] = {}
    for end, one in comparison.ends.items():
        if isinstance(one, Comparison):
            found[end] = {
                (entry.selection.name, row.place): row.values
                for entry in one.quantities
                for row in entry.rows
            }
    numbers = []
    for entry in comparison.quantities:
        for row in entry.rows:
            key = entry.selection.name, row.place
            ends = {end: values[key] for end, values in found.items() if key in values}
            numbers.append(
                _Number(
                    key[0],
                    entry.selection.quantity.unit.replace("1", "-"),
                    row.place,
                    row.values,
                    ends,
                )
            )
    return numbers


def _moved(comparison: Comparison) -> bool:
    """Whether some number differs by more than 1 % between the ends of the drives."""
    return bool(comparison.ends) and any(one.moves for one in _numbers(comparison))


def _drives(comparison: Comparison, most: int | None = None) -> Sheet:
    """Every number of every design at the ends.

    Args: most, rows to show, those first whose order changes; None for all.
    """
    letters, numbers = comparison.letters, _numbers(comparison)
    header = (
        "quantity",
        "unit",
        "place",
        *(f"{letter} {end}" for letter in letters for end in comparison.ends),
        "same order",
    )
    rows: list[Row] = []
    for one in numbers:
        nothing: Values = (None,) * len(letters)
        known = [one.ends.get(end, nothing) for end in comparison.ends]
        of_designs = [values[k] for k in range(len(letters)) for values in known]
        rows.append((one.quantity, one.unit, one.place, *of_designs, not one.reversed))
    sheet = Sheet(AT_BOTH, header, rows, [BEYOND])
    # Numbers whose order changes come first, then those in the order of the tables.
    sizes = [len(numbers) * (1 + one.reversed) - k for k, one in enumerate(numbers)]
    return sheet.largest(most, "number", sizes)


def _over_drives(comparison: Comparison) -> list[str]:
    """Whether which design has less depends on the drives."""
    if not comparison.ends:
        return []
    lines = [
        f"with the {end} inertias of the drives there is no answer: {one}"
        for end, one in comparison.ends.items()
        if isinstance(one, ShockError)
    ]
    numbers = _numbers(comparison)
    if not _moved(comparison):
        return [*lines, f"drives: from {BETWEEN}, no number changes by more than 1 %"]
    changing = [f"{one.quantity}@{one.place}" for one in numbers if one.reversed]
    if not changing:
        return [
            *lines,
            f"drives: numbers change from {BETWEEN}, and the order of the designs stays",
        ]
    named = f"{len(changing)} of {len(numbers)} numbers: {few(changing, 4)}"
    return [*lines, f"drives: from {BETWEEN}, the order of the designs changes for {named}"]


def _document(comparison: Comparison) -> dict[str, Any]:
    labels = [design.label for design in comparison.designs]
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
        "unmatched": [
            {**record(entry, "kind", "name"), "designs": [labels[k] for k in entry.designs]}
            for entry in comparison.unmatched
        ],
    }


def _paired(comparison: Comparison, letters: list[str]) -> list[str]:
    """Partners of different names."""
    lines = []
    for letter, matched in zip(letters[1:], comparison.partners, strict=True):
        bodies = [f"{a} / {b}" for a, b in matched["body"].items() if a != b]
        lines += (
            [f"partners by --pair in {letters[0]} / {letter}: {', '.join(bodies)}"]
            if bodies
            else []
        )
    return lines


def _joint_models(comparison: Comparison, letters: list[str]) -> list[str]:
    """That the designs have different joint models, of which the changes are an effect too."""
    models = [profile.joint_model for profile in comparison.profiles]
    if len(set(models)) == 1:
        return []
    each = ", ".join(f"{letter} {model}" for letter, model in zip(letters, models, strict=True))
    return [
        f"the joint models differ ({each}), which is part of the changes; --joints free compares "
        f"the designs without drives"
    ]


def _unmatched(comparison: Comparison, letters: list[str]) -> list[str]:
    """What has no partner of its name in every design, by kind and by the designs that have it."""
    groups: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for place in comparison.unmatched:
        groups.setdefault((place.kind, place.designs), []).append(place.name)
    return [
        f"only in {' and '.join(letters[k] for k in designs)}: {count(len(names), kind)}: "
        f"{', '.join(names)}"
        for (kind, designs), names in groups.items()
    ]


def _unproven(comparison: Comparison) -> list[str]:
    """Which numbers are those with friction, or of contacts of finite stiffness, for which there is
    no proof.
    """
    quantities = [entry.selection for entry in comparison.quantities]
    scenes = [profile.scene for profile in comparison.profiles]
    names = [
        one.name for one in quantities if any(one.quantity.of_ground(scene) for scene in scenes)
    ]
    return [f"in double precision: {few(names, 6)}"] if names else []


def _warnings(comparison: Comparison, letters: list[str]) -> list[str]:
    """One line for each cause of warnings, with the designs that have it and the text of the worst."""
    pairs = zip(letters, comparison.profiles, strict=True)
    lines = []
    for every in alike(
        (warning, letter) for letter, profile in pairs for warning in other_warnings(profile)
    ):
        where = f" (in {every[0][1]})" if len({str(warning) for warning, _ in every}) > 1 else ""
        lines.append(
            f"warning of {' and '.join(sorted({letter for _, letter in every}))}: "
            f"{every[0][0]}{where}"
        )
    return lines


def _sheet(comparison: Comparison, differences: Differences, most: int | None) -> Sheet:
    """One quantity. Args: most, rows to show, those of the largest changes; None for all."""
    selection, quantity = differences.selection, differences.selection.quantity
    sheet = (
        sheet_of(comparison.table)
        .where(lambda row: row["quantity"] == selection.name)
        .without("quantity", "unit")
    )
    units = [
        column._replace(unit=column.unit or quantity.unit.replace("1", "-"))
        for column in sheet.columns[1:]
    ]
    sheet = sheet._replace(
        title=f"{quantity.title} ({selection.name})", header=[Column("place", quantity.of), *units]
    )
    # Rows are in the order of their sizes, but for those that every table has.
    sizes = [math.inf if row.always else -k for k, row in enumerate(differences.rows)]
    sheet = sheet.largest(most, quantity.of, sizes)
    shared = quantity.scope.shared and any(profile.redundant for profile in comparison.profiles)
    notes = ["of the contact impulses of minimum norm, because rows are redundant"] * shared
    notes += [f"ranked by the change of {quantity.relations.reciprocal}"] * bool(
        quantity.relations.reciprocal
    )
    return sheet._replace(notes=(*notes, *sheet.notes))
