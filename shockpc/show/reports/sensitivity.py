"""What changes a number of a landing, in a designer's units: one row for every parameter, the largest effect first."""

import math
from typing import Any

from shockpc.result import ShockProfile
from shockpc.show.document import record
from shockpc.show.header import count, shared_lines, shared_warnings, shown_as, vector_text
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, largest
from shockpc.studies.sensitivity import Effect, Sensitivity

PARAMETERS = {
    "mass": "mass (at its CoM)",
    "proportion": "mass and inertia",
    "com": "CoM",
    "inertia": "inertia",
    "armature": "reflected inertia",
    "strike": "strike angle",
}


def sensitivity_report(study: Sensitivity, most: int) -> Report:
    """The effects. Args: most, rows of the table on a terminal."""
    landings = _named(study)
    now = f"{study.target.title}: {study.value:.4g} {study.target.unit}".removesuffix(" -")
    if len(landings) > 1:
        now += f", {_over(study)}; the worst is {study.worst}"
    if math.isfinite(study.ropc):
        now += f"; CoPc of {study.body} at ({vector_text(study.copc)}) m, RoPc {study.ropc:.4g} m"
    return Report(
        name="sensitivity",
        title=f"What changes the {study.target.title}",
        body=lambda full: [
            Lines([*shared_lines(landings), ("target", now)]),
            Picture("sensitivity", f"the largest effects on the {study.target.title}", "tornado:draw_tornado", (study,)),
            _table(study, None if full else most),
        ],
        warnings=shared_warnings(landings),
        sheets={"sensitivity": lambda: _spreadsheet(study)},
        document=lambda: _document(study),
    )


def _named(study: Sensitivity) -> dict[str, ShockProfile]:
    return dict(zip(study.landings, study.profiles, strict=True))


def _over(study: Sensitivity) -> str:
    return f"{'mean' if study.mean else 'the worst'} of {count(len(study.landings), 'landing')}"


def change_words(change: Effect) -> str:
    """What is changed."""
    joint = "joint position" if change.unit == "m" else "joint angle"
    return f"{PARAMETERS.get(change.kind, joint)} {change.axis}".strip()


def step_words(change: Effect) -> str:
    """How far it is changed, in a designer's units."""
    if change.unit == "1":
        return f"+{100.0 * change.step:.3g} %"
    if change.unit == "kg":
        return f"+{1e3 * change.step:.3g} g"
    return f"+{shown_as(change.step, change.unit)}"


def _document(study: Sensitivity) -> dict[str, Any]:
    """The document, schema `shockpc.sensitivity/1`: derivatives in SI units, and the step that tables and figure use."""
    return {
        "target": study.target.name,
        "unit": study.target.selection.quantity.unit,
        "worse": study.target.selection.quantity.worse,
        "over": "mean" if study.mean else "worst",
        **record(study, "value", "percent", "body", "copc", "ropc"),
        "landings": [
            {"landing": name or None, "value": float(value), "warnings": profile.health.warnings, "scene": profile.scene}
            for name, value, profile in zip(study.landings, study.values, study.profiles, strict=True)
        ],
        "effects": [
            {
                "parameter": effect.kind,
                "axis": effect.axis or None,
                "of": effect.name or None,
                **record(effect, "value", "unit", "step"),
                "parts": [{"of": name or None, "axis": axis or None, "weight": w} for (_, axis, name), w in effect.parts.items()],
                **record(effect, "derivatives", "up", "down"),
                "d_copc": effect.percussion[:3],
                "d_ropc": effect.percussion[3],
                "reason": effect.reason or None,
            }
            for effect in study.effects
        ],
    }


def _table(study: Sensitivity, most: int | None) -> Sheet:
    """The effects of one step. Args: most, number of rows; None for all."""
    rows: list[Row] = []
    single = len(study.landings) == 1
    for effect in study.ranked:
        now = None if effect.unit == "1" or math.isnan(effect.value) else shown_as(effect.value, effect.unit, 4)
        ropc, *copc = (float(x) * effect.step for x in (effect.percussion[3], *effect.percussion[:3]))
        further = (100.0 * ropc / study.ropc, *(1e3 * x for x in copc)) if single else (100.0 * effect.down / study.value,)
        changes = (effect.up, 100.0 * effect.up / study.value, *further)
        rows.append((change_words(effect), effect.name or None, now, step_words(effect), *changes))
    rows, left = largest(rows, most, "parameter")
    key, unit = study.target.selection.name, study.target.unit
    further_heads = ("RoPc [%]", "CoPc x [mm]", "CoPc y [mm]", "CoPc z [mm]") if single else (f"{key}, opposite change [%]",)
    header = ("parameter", "of", "now", "change", f"{key} [{unit}]", f"{key} [%]", *further_heads)
    joints = "; ".join(
        f'joint "{effect.name}" has no effect of its own: {effect.reason}' for effect in study.effects if effect.reason
    )
    opposite = (
        "a change of the opposite sign has the opposite effect" if single or study.mean else "another landing may become the worst"
    )
    notes = [
        f"change: {study.percent:g} % of the range given, or else of the mass, mean moment of inertia, radius of gyration (CoM), "
        "reflected inertia (without one: the inertia that the joint moves), of a radian, or of the robot's length",
        f"to first order: {opposite}; of a larger one the effect is not in proportion",
        *left,
        *([joints] if joints else []),
    ]
    where = f"{'' if study.body is None else f', and on RoPc and CoPc of {study.body}'}{'' if single else f', {_over(study)}'}"
    return Sheet(f"effect on the {study.target.title}{where}", header, rows, notes)


def _spreadsheet(study: Sensitivity) -> Sheet:
    rows: list[Row] = []
    for effect in study.ranked:
        what = (f"{effect.kind} {effect.axis}".strip(), effect.name or None, effect.value, effect.unit, effect.step)
        rows.append(
            (*what, effect.up, effect.down, *(effect.step * float(x) for x in (effect.percussion[3], *effect.percussion[:3])))
        )
    target = f"{study.target.selection.name} [{study.target.unit}]"
    changes = (target, f"opposite {target}", "RoPc [m]", "CoPc x [m]", "CoPc y [m]", "CoPc z [m]")
    return Sheet("", ("parameter", "of", "value", "unit", "step", *changes), rows)
