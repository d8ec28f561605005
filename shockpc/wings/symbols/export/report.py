"""Code of a landing: what it is given, what it computes, and how far it is from what is proven."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shockpc.landing.scenes.scene_file import scene_text
from shockpc.profile import ILL_CONDITIONED
from shockpc.show.report import Report
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.text.printed import count
from shockpc.wings.symbols.export.study import RUNS, Export

LANGUAGES = {"c": "C99", "js": "JavaScript", "casadi": "a function of CasADi"}


def export_report(study: Export) -> Report:
    """The code, its inputs and outputs, and the comparison."""
    return Report(
        name="export",
        title=f"Code of a landing of {study.landing.robot.name}",
        body=lambda _: [Lines(_lines(study)), _outputs(study), _inputs(study)],
        warnings=_warnings(study),
        sheets={"outputs": lambda: _outputs(study), "inputs": lambda: _inputs(study)},
        document=lambda: _document(study),
        more=lambda folder: _files(study, folder),
        tables=True,
    )


def _lines(study: Export) -> list[tuple[str, str]]:
    landing, n = study.landing, len(study.samples.inputs)
    contacts = [constraint.name for constraint in (*landing.contacts, *landing.stance)]
    left_out = f"; {count(study.singular, 'other')} singular or nearly so" if study.singular else ""
    lines = [
        ("robot", f"{landing.robot.label} ({landing.robot.name})"),
        ("contact", ", ".join(contacts)),
        (
            "code",
            f"{LANGUAGES[study.lang]}, {len(study.symbols.program.operation)} operations; files of "
            f"--out: {', '.join(study.files)}",
        ),
        (
            "compared",
            f"with exact landings in {count(n, 'random posture')}: maximum error "
            f"{study.error:.1e} of a number{left_out}",
        ),
    ]
    if study.tested is not None:
        lines.append(
            ("the code", f"run by {RUNS[study.lang][0]}: maximum error {study.tested:.1e}")
        )
    lines.append(
        (
            "condition",
            f"do not trust the numbers where it is above {ILL_CONDITIONED:g}: a singular posture "
            f"is near",
        )
    )
    return lines


def _warnings(study: Export) -> list[str]:
    if study.tested is None:
        return [
            f"warning: the code itself was not run, because {RUNS[study.lang][0]} is not "
            f"installed; run its test where it is"
        ]
    return []


def _outputs(study: Export) -> Sheet:
    rows = [(name, title, unit) for name, title, unit in study.outputs]
    return Sheet("Outputs", ("output", "meaning", "unit"), rows)


def _inputs(study: Export) -> Sheet:
    rows: list[Row] = []
    for k, (joint, unit, low, high) in enumerate(study.joints):
        minimum = low if math.isfinite(low) else None
        maximum = high if math.isfinite(high) else None
        rows.append((f"q[{k}]", joint, unit, minimum, maximum))
    return Sheet("Configuration", ("input", "joint", "unit", "minimum", "maximum"), rows)


def _files(study: Export, folder: Path) -> Mapping[str, str]:
    return {**study.files, "landing.toml": scene_text(study.landing.scene, folder)}


def _document(study: Export) -> dict[str, Any]:
    return {
        "robot": {"name": study.landing.robot.name, "file": study.landing.robot.label},
        "scene": study.landing.scene,
        "language": study.lang,
        "before": study.symbols.before,
        "operations": len(study.symbols.program.operation),
        "postures": len(study.samples.inputs),
        "left_out": study.singular,
        "error": study.error,
        "error_of_its_test": study.tested,
        "most_condition": ILL_CONDITIONED,
    }
