"""An optimum: what it gains, what holds it there, what each variable does, and how the worst landing changes."""

import math
from typing import Any

import numpy as np

from shockpc.evaluation.variation import OF_A_LINK
from shockpc.landing.scene_file import scene_table
from shockpc.quantities.profile import ShockProfile
from shockpc.show.document import record
from shockpc.show.reports.compare import compare_report
from shockpc.show.reports.report import Picture, Report, Section
from shockpc.show.tables import Lines, Sheet, sheet_of
from shockpc.show.wording import at_place, count, proof_text, shared_lines, shared_warnings
from shockpc.studies.compare import STANDARD, Design, compare
from shockpc.studies.improve import BEST, Improvement
from shockpc.text.printed import few
from shockpc.text.toml import toml_lines

MORE = ["--out writes how the other numbers change"]
"""The last line on a terminal."""


def improve_report(study: Improvement) -> Report:
    """The optimum."""
    designs = [Design(label, one.scene, one.robot) for label, one in _worst(study).items()]
    further = [text for text in study.cost.quantities if "," not in text and text.partition("@")[0] not in STANDARD]
    compared = compare_report(compare(designs, further))
    picture = Picture(
        "improve", "the worst landing as given and at the optimum, and the runs", "improve:draw_improvement", (study,)
    )
    front = [Picture("front", "the front of two numbers", "improve:draw_front", (study,))] if study.front else []
    return Report(
        name="improve",
        title=f"The least {few(list(map(at_place, study.cost.quantities)), 2)}",
        body=lambda full: [
            Lines([*shared_lines(study.after), *_lines(study)]),
            picture,
            *front,
            _variables(study),
            *([_front(study)] if study.front else []),
            *(_compared(compared, True) if full else [*_compared(compared, False)[:3], Lines(MORE)]),
        ],
        lead=3 + 2 * bool(study.front),
        closing=compared.closing,
        warnings=shared_warnings(study.after),
        sheets={"variables": lambda: _variables(study), **({"front": lambda: _front(study)} if study.front else {})},
        document=lambda: _document(study),
        more=lambda _: {name: "\n".join(toml_lines(scene_table(one.scene))) + "\n" for name, one in _scenes(study).items()},
        landings={f"{label}: {study.worst}": one for label, one in _worst(study).items()},
    )


def _compared(compared: Report, full: bool) -> list[Section]:
    """Lines and tables of the comparison: what the letters mean, the shock at points, at centres of mass, and others."""
    return [part for part in compared.body(full) if not isinstance(part, Picture)]


def _worst(study: Improvement) -> dict[str, ShockProfile]:
    """The landing that is the worst at the optimum, as given and there."""
    return {"as given": study.before[study.worst], "optimum": study.after[study.worst]}


def _scenes(study: Improvement) -> dict[str, ShockProfile]:
    """The landings at the optimum, by the names of their files."""
    return {f"optimum-{k}.toml": profile for k, profile in enumerate(study.after.values(), start=1)}


def _number(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".removesuffix(" -")


def _lines(study: Improvement) -> list[tuple[str, str]]:
    """Before and after, what holds the optimum, and how far it can be trusted."""
    cost, lines = study.cost, list[tuple[str, str]]()
    for text, (before, after), column in zip(cost.quantities, study.values, study.columns, strict=True):
        unit = column.unit
        gain = f" ({100.0 * (after / before - 1.0):+.3g} %)" if before and math.isfinite(after / before) else ""
        over = f", the worst of {count(len(study.after), 'landing')}" if len(study.after) > 1 else ""
        lines.append((at_place(text), f"{_number(before, unit)} → {_number(after, unit)}{gain}{over}"))
    (before, after), *_ = study.values
    if (before < after) == (study.columns[0].selection.quantity.worse == "greater") and before != after:
        reason = f"it lies outside the range of {few(list(study.outside), 4)}" if study.outside else "it misses constraints"
        lines.append(("as given", f"better than the optimum: {reason}"))
    bounds = [f"{one.name} at its {'least' if one.bound == 'low' else 'greatest'} value" for one in study.variables if one.bound]
    lines.append(("held by", few([*bounds, *study.held], 6) or "nothing: it lies inside all ranges and constraints"))
    runs = count(len(study.ends), "run") + (f", the best {BEST} to their ends" if len(study.ends) > BEST else "")
    lines.append(("runs", f"{runs}; {study.agreeing} at the optimum; seed {study.seed}; no proof that nothing better exists"))
    profiles = (*study.before.values(), *study.after.values())
    unproven = any(column.selection.quantity.of_ground(profile.scene) for column in study.columns for profile in profiles)
    proof = proof_text(max(profile.health.error_bound for profile in profiles))
    lines.append(("proven", "not: these values are in double precision" if unproven else f"both values, {proof}"))
    return lines


def _variables(study: Improvement) -> Sheet:
    notes = [
        "5 %: the range of it alone, up to its bounds, in which the target is at most 5 % worse than at the optimum",
        "set back, and 5 %: the constraints may not hold there",
    ]
    if changed := [one.subject for one in study.cost.variations if one.kind in (*OF_A_LINK, "place")]:
        notes.append(f"{few(changed, 4)}: of the robot itself, and so not in the scene; change it in its file")
    return sheet_of(study.table, "what each variable does", notes)


def _front(study: Improvement) -> Sheet:
    numbers = [f"{at_place(text)} [{column.unit}]" for text, column in zip(study.cost.quantities, study.columns, strict=True)]
    rows = [(*point.values.tolist(), *point.x.tolist()) for point in study.front]
    return Sheet("front, in double precision", (*numbers, *study.cost.names), rows, [])


def _document(study: Improvement) -> dict[str, Any]:
    """The document, schema `shockpc.improve/1`; variables in the units of their names."""
    return {
        "quantities": [
            {"quantity": text, "before": before, "after": after}
            for text, (before, after) in zip(study.cost.quantities, study.values, strict=True)
        ],
        "worst": study.worst or None,
        "held": study.held,
        "variables": [record(one, *one._fields) for one in study.variables],
        "runs": [np.asarray(run).tolist() for run in study.runs],
        "agreeing": study.agreeing,
        "seed": study.seed,
        "front": [{"values": point.values.tolist(), "x": point.x.tolist()} for point in study.front],
        "landings": [
            {"landing": name or None, "before": study.before[name].scene, "after": profile.scene}
            for name, profile in study.after.items()
        ],
    }
