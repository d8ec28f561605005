"""Report of identified unknowns: values, errors before and after, drives and a scene with them."""

import dataclasses
import datetime
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.landing.joint_model import JointModel, joint_model
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.robot.bodies_and_joints import IDENTIFIED
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet, sheet_of
from shockpc.show.wording import robot_line
from shockpc.text.printed import cause_lines, causes, count, few, listed
from shockpc.text.toml import toml_lines
from shockpc.wings.recordings.identify.predictor import SCALE
from shockpc.wings.recordings.identify.study import ERRORS, Identification
from shockpc.wings.recordings.identify.uncertainty import IdentifiedValue

DRIVES, SCENE = "drives.toml", "scene.toml"
"""Files of what was found."""


def identify_report(file: Path, study: Identification) -> Report:
    """The report of an identification from the table of a file."""
    table = file.name
    return Report(
        name="identify",
        title=f"Unknowns from {table}",
        body=lambda full: [
            Lines(list(_header(study, table))),
            _unknowns(study),
            _errors(study),
            Picture(
                "identify",
                "error over each unknown, and predicted against measured jumps",
                "wings.recordings.identify.figure:draw",
                (study,),
            ),
        ],
        closing=[*study.statements, *_closing(study)],
        sheets={
            "identify": lambda: _unknowns(study),
            "errors": lambda: _errors(study),
            "landings": lambda: _landings(study),
            "scans": lambda: _scans(study),
        },
        document=lambda: _document(study, table),
        tables=True,
        more=lambda folder: _files(study, table, folder),
    )


def _header(study: Identification, table: str) -> Iterator[tuple[str, str]]:
    predictor = study.predictor
    rows = predictor.rows
    yield (
        "table",
        f"{table}: {count(len(study.used), 'landing')}, of which {int(study.used.sum())} are used",
    )
    yield robot_line(predictor.robot)
    time = predictor.measured[0].time
    when = "" if time is None else f", {time:g} ms after contact"
    names = [column.name for column in predictor.measured]
    yield "measured", f"{few(names, 12, noun=' velocities')}{when}"
    used = {(column.key, column.time) for column in predictor.measured}
    unused = []
    for column in rows.measured:
        if (column.key, column.time) not in used:
            unused.append(f"{column.key} after {column.time:g} ms" if column.time else column.key)
    if unused:
        yield "not used", few(unused, 12, noun=" columns")
    yield "in the table", ", ".join(rows.given)
    yield "of the scene", ", ".join(rows.missing) or "nothing"


def _unknowns(study: Identification) -> Sheet:
    note = (
        "low, high: 95 % interval, by drawing landings with replacement (expanded percentiles); "
        "minimum, maximum: the range"
    )
    return sheet_of(study.table, "unknowns", [note])


def _errors(study: Identification) -> Sheet:
    words = {
        "before": "the scene as it is given",
        "after": "the values found",
        "left out": "the same, on landings left out",
        "free impulse": "the best impulse at the contacts, whatever its law",
    }
    rows = [(name, words[name], study.errors[name]) for name in ERRORS]
    note = (
        "median over the landings of ‖predicted − measured‖ / ‖measured‖ in the energy norm "
        "√(ΔᵀHΔ); no jump has the error 1"
    )
    return Sheet(
        "error of the predicted jumps", ("error", "prediction with", "median [-]"), rows, [note]
    )


def _landings(study: Identification) -> Sheet:
    rows = study.predictor.rows
    messages = dict(rows.messages) | dict(study.messages)
    errors = {f"error {key} [-]": study.landing_errors[key] for key in ERRORS}
    reasons = [messages.get(i) for i in range(len(rows.names))]
    return Sheet.of(
        "landings", {"landing": list(map(str, rows.names)), **errors, "message": reasons}
    )


def _scans(study: Identification) -> Sheet:
    """The error over the range of each unknown, with the others as they were found."""
    rows: list[Row] = []
    for j, unknown in enumerate(study.unknowns):
        variation = unknown.variation
        for value, error in zip(*study.scan(j), strict=True):
            rows.append((variation.subject, variation.unit, float(value), float(error)))
    return Sheet("error over each unknown", ("unknown", "unit", "value", "error"), rows)


def _closing(study: Identification) -> Iterator[str]:
    if study.messages:
        yield f"without a prediction with these values: {count(len(study.messages), 'landing')}"
        names = study.predictor.rows.names
        refused = causes((str(names[i]), text) for i, text in study.messages.items())
        yield from (f"  {line}" for line in cause_lines(refused, "landings", 3))
    variations = [unknown.variation for unknown in study.unknowns]
    of_robot = [variation.subject for variation in variations if variation.kind.of_robot]
    if of_robot:
        yield (
            f"{listed(of_robot)} belongs to the robot's file, not to a scene: change it there. "
            f"shockpc compare ROBOT "
            "--change NAME=VALUE shows its effect"
        )
    if SCALE in study.values:
        yield f"{SCALE} is of this table: multiply its velocities before the impact by it"


def _document(study: Identification, table: str) -> dict[str, Any]:
    correlation = study.correlation.astype(object)
    correlation[np.isnan(study.correlation)] = None
    return {
        "table": table,
        "robot": study.predictor.robot.name,
        "scene": study.scene,
        "landings": len(study.used),
        "used": int(study.used.sum()),
        "measured": [column.name for column in study.predictor.measured],
        "correlation": correlation.tolist(),
        "singular_values": study.singular,
        "statements": study.statements,
    }


def _files(study: Identification, table: str, folder: Path) -> Mapping[str, str]:
    """The drives, if some were unknown, and the scene with all that was found."""
    scene, files = study.scene, dict[str, str]()
    if any(unknown.variation.kind.of_drives for unknown in study.unknowns):
        files[DRIVES] = _drives_text(study, table)
        joints = dataclasses.replace(
            scene.joints, drives=str(folder / DRIVES), armature={}, rotor={}, stiffness={}
        )
        scene = dataclasses.replace(scene, joints=joints)
    return files | {SCENE: scene_text(scene, folder)}


def _share(unknown: IdentifiedValue) -> tuple[float, float]:
    """The ends of an inertia that was looked for, as shares of its value.

    They are those of the 95 % interval, and not nearer than drives of one type agree; of what was
    not identified those of the range in which it was looked for.
    """
    known = unknown.state == "identified"
    looked_for = unknown.variation.span or (unknown.value, unknown.value)
    low, high = (unknown.low, unknown.high) if known else looked_for
    spread = IDENTIFIED if known else 0.0
    return min(low / unknown.value, 1.0 - spread), max(high / unknown.value, 1.0 + spread)


def _ends(model: JointModel, v: int, share: tuple[float, float] | None) -> list[float] | None:
    """The ends of the inertia at a joint for a file of drives [kg m², kg].

    None where the inertia is exact or not known.

    Args:
        model: the drives.
        v: the joint's velocity.
        share: of an inertia that was looked for, as in `_share`.
    """
    if share is not None:
        inertia = float(model.armature[v] + model.rotor[v])
        return [share[0] * inertia, share[1] * inertia]
    low, high = float(model.low[v]), float(model.high[v])
    return [low, high] if low < high < math.inf else None


def _drives_text(study: Identification, table: str) -> str:
    """All drives of the robot with the identified values, as a file for --drives.

    Their source has today's date.
    """
    robot, joints = study.robot, study.scene.joints
    # Rigid joints have no inertia that could be written, so that the drives are taken as they are.
    if joints.model == "rigid":
        joints = dataclasses.replace(joints, model=None)
    model = joint_model(robot, joints)
    identified = _identified_drives(study, table)
    drives: dict[str, dict[str, Any]] = {}
    for name in robot.joint_names:
        source, share = identified.get(name, ({"source": "of the scene"}, None))
        v = robot.joint(name).v.start
        values = _drive_values(model, v)
        ends = _ends(model, v, share)
        if "armature" in values and ends is not None:
            values["range"] = ends
        if values:
            # Joints with the same values and source share an entry.
            entry = {"joint": [], **values, **source}
            drives.setdefault(repr((values, source)), entry)["joint"].append(name)
    return "\n".join(toml_lines({"drive": list(drives.values())})) + "\n"


def _identified_drives(
    study: Identification, table: str
) -> dict[str, tuple[dict[str, str], tuple[float, float] | None]]:
    """Status and source of the drives that were looked for by joint, and the `_share` of inertias.

    The source has today's date.
    """
    day = datetime.date.today().isoformat()
    landings = count(int(study.used.sum()), "landing")
    status: dict[str, dict[str, str]] = {}
    sources: dict[str, str] = {}
    shares: dict[str, tuple[float, float]] = {}
    for unknown in study.unknowns:
        kind = unknown.variation.kind
        if not kind.of_drives:
            continue
        names = study.robot.match_joints(unknown.variation.target)
        text = f"{table}, {landings}, {day}: {unknown.value:.4g}"
        if not math.isnan(unknown.low):
            text += f" ({unknown.low:.4g} to {unknown.high:.4g})"
        if unknown.state == "identified":
            status |= {name: {"status": "identified"} for name in names}
        else:
            text += f", {unknown.state}"
        sources |= dict.fromkeys(names, text)
        if kind.of_rotors:
            shares |= dict.fromkeys(names, _share(unknown))
    identified = {}
    for name, text in sources.items():
        identified[name] = (status.get(name, {}) | {"source": text}, shares.get(name))
    return identified


def _drive_values(model: JointModel, v: int) -> dict[str, Any]:
    """The numbers of a drive in a file of drives, without zeros. Args: v, its velocity."""
    # With a spring in the drive, the inertia is that of the rotor behind it.
    behind = np.isfinite(model.drive_stiffness[v])
    numbers = {
        "armature": float(model.rotor[v] if behind else model.armature[v]),
        "drive_stiffness": float(model.drive_stiffness[v]) if behind else 0.0,
        "stiffness": float(model.stiffness[v]),
    }
    values: dict[str, Any] = {key: value for key, value in numbers.items() if value > 0.0}
    per_turn = float(model.per_turn[v])
    if per_turn:
        values["gear_ratio"] = 1.0 / abs(per_turn)
        values["gear"] = "planetary" if per_turn > 0.0 else "harmonic"
    return values
