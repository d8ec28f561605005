"""A comparison: what each letter stands for, one table for each quantity with the largest change first, and what has no partner."""

import math
from typing import Any

from shockpc.show.document import record
from shockpc.show.header import other_warnings, strike_text, unknown_lines
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Column, Lines, Sheet, sheet_of
from shockpc.show.wording import contact_name, count
from shockpc.studies.compare.study import Comparison, Differences
from shockpc.text.diagnostic import alike
from shockpc.text.printed import few


def compare_report(comparison: Comparison) -> Report:
    """Designs side by side."""
    designs, profiles = comparison.designs, comparison.profiles
    letters = comparison.letters
    header = [
        (
            letter,
            f"{design.label}: on {contact_name(profile)}, {strike_text(profile)}, joints {profile.joint_model}, "
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
                "studies.compare.figure:draw_comparison",
                (comparison, header),
            ),
            *(_sheet(comparison, differences, None if full else 8) for differences in comparison.quantities),
        ],
        lead=2,
        closing=[
            *_joint_models(comparison, letters),
            *_paired(comparison, letters),
            *_unmatched(comparison, letters),
            *_unproven(comparison),
        ],
        warnings=_warnings(comparison, letters),
        sheets={"compare": lambda: sheet_of(comparison.table)},
        document=lambda: _document(comparison),
        tables=True,
        landings={f"{k}: {design.label}": profile for k, design, profile in zip(letters, designs, profiles, strict=True)},
    )


def _unknowns(comparison: Comparison) -> list[tuple[str, str]]:
    """What each design takes for granted."""
    pairs = zip(comparison.letters, comparison.profiles, strict=True)
    return [(name, f"{letter}: {text}") for letter, profile in pairs for name, text in unknown_lines([profile])]


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
            {**record(entry, "kind", "name"), "designs": [labels[k] for k in entry.designs]} for entry in comparison.unmatched
        ],
    }


def _paired(comparison: Comparison, letters: list[str]) -> list[str]:
    """Partners of different names."""
    lines = []
    for letter, matched in zip(letters[1:], comparison.partners, strict=True):
        bodies = [f"{a} / {b}" for a, b in matched["body"].items() if a != b]
        lines += [f"partners by --pair in {letters[0]} / {letter}: {', '.join(bodies)}"] if bodies else []
    return lines


def _joint_models(comparison: Comparison, letters: list[str]) -> list[str]:
    """That the designs have different joint models, of which the changes are an effect too."""
    models = [profile.joint_model for profile in comparison.profiles]
    if len(set(models)) == 1:
        return []
    each = ", ".join(f"{letter} {model}" for letter, model in zip(letters, models, strict=True))
    return [f"the joint models differ ({each}), which is part of the changes; --joints free compares the designs without drives"]


def _unmatched(comparison: Comparison, letters: list[str]) -> list[str]:
    """What has no partner of its name in every design, by kind and by the designs that have it."""
    groups: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for place in comparison.unmatched:
        groups.setdefault((place.kind, place.designs), []).append(place.name)
    return [
        f"only in {' and '.join(letters[k] for k in designs)}: {count(len(names), kind)}: {', '.join(names)}"
        for (kind, designs), names in groups.items()
    ]


def _unproven(comparison: Comparison) -> list[str]:
    """Which numbers are those with friction, or of contacts of finite stiffness, for which there is no proof."""
    quantities = [entry.selection for entry in comparison.quantities]
    scenes = [profile.scene for profile in comparison.profiles]
    names = [one.name for one in quantities if any(one.quantity.of_ground(scene) for scene in scenes)]
    return [f"in double precision, not proven: {few(names, 6)}"] if names else []


def _warnings(comparison: Comparison, letters: list[str]) -> list[str]:
    """One line for each cause of warnings, with the designs that have it and the text of the worst."""
    pairs = zip(letters, comparison.profiles, strict=True)
    lines = []
    for every in alike((warning, letter) for letter, profile in pairs for warning in other_warnings(profile)):
        where = f" (in {every[0][1]})" if len({str(warning) for warning, _ in every}) > 1 else ""
        lines.append(f"warning of {' and '.join(sorted({letter for _, letter in every}))}: {every[0][0]}{where}")
    return lines


def _sheet(comparison: Comparison, differences: Differences, most: int | None) -> Sheet:
    """One quantity. Args: most, rows to show, those of the largest changes; None for all."""
    selection, quantity = differences.selection, differences.selection.quantity
    sheet = sheet_of(comparison.table).where(lambda row: row["quantity"] == selection.name).without("quantity", "unit")
    units = [column._replace(unit=column.unit or quantity.unit.replace("1", "-")) for column in sheet.columns[1:]]
    sheet = sheet._replace(title=f"{quantity.title} ({selection.name})", header=[Column("place", quantity.of), *units])
    # Rows are in the order of their sizes, but for those that every table has.
    sizes = [math.inf if row.always else -k for k, row in enumerate(differences.rows)]
    sheet = sheet.largest(most, quantity.of, sizes)
    shared = quantity.shared and any(profile.redundant for profile in comparison.profiles)
    notes = ["of the contact impulses of minimum norm, because rows are redundant"] * shared
    notes += [f"ranked by the change of {quantity.reciprocal}"] * bool(quantity.reciprocal)
    return sheet._replace(notes=(*notes, *sheet.notes))
