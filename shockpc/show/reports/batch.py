"""A batch: one row for each landing, ranked by the shock of the trunk, and a sheet of pictures where the batch has them."""

from collections.abc import Iterable
from typing import Any

from shockpc.quantities.table import select
from shockpc.robot.landmarks import BENT, is_imu
from shockpc.show.header import count, proof_text
from shockpc.show.reports.report import Picture, Report
from shockpc.show.tables import Lines, Row, Sheet
from shockpc.studies.batch import Batch, BatchRow


def batch_report(batch: Batch) -> Report:
    """The landings of many robots; the Markdown document also has their warnings."""
    caption = "the landings, the greatest shock of the trunk first"
    drawn = any(row.picture is not None for row in batch.rows)
    picture = [Picture("sheet", caption, "contact_sheet:draw_contact_sheet", (batch,))] if drawn else []
    warnings = list(dict.fromkeys(f"warning: {row.robot}: {warning}" for row in batch.rows for warning in row.warnings))
    return Report(
        name="batch",
        title="Landings of robots",
        body=lambda full: [*picture, _sheet(batch), *([Lines(warnings)] if full else [])],
        closing=[
            f"not computed: {' '.join(filter(None, (failure.robot, failure.contact)))}: {failure.reason}"
            for failure in batch.failures
        ],
        sheets={"batch": lambda: _sheet(batch, for_terminal=False)},
        document=lambda: {
            "rows": [_record(row) for row in batch.rows],
            "failures": list(map(vars, batch.failures)),
        },
    )


def _record(row: BatchRow) -> dict[str, Any]:
    values = {key: value for key, value in vars(row).items() if key not in ("values", "picture")}
    return {"robot": row.robot, "contact": row.contact, "trunk": row.trunk, **row.values, **values}


def _sheet(batch: Batch, for_terminal: bool = True) -> Sheet:
    """One row for each landing. Args: for_terminal, without columns that repeat another, all sensors, and what failed."""
    names = list(batch.columns)
    if for_terminal:
        free = all(row.joint_model == "free" for row in batch.rows)
        names = [name for name in names if name not in ("error_bound", "feasible") and not (free and name == "shock_com")]
    units = (select(name.partition("@")[0]).quantity.unit.replace("1", "-") for name in names)
    header = ["robot", "contact", "trunk", *(f"{name} [{unit}]" for name, unit in zip(names, units, strict=True))]
    header += [
        "IMU",
        "at IMU [-]",
        *([] if for_terminal else ["posture", "joint model", "sensors and points [-]", "warnings", "failure"]),
    ]
    rows: list[Row] = []
    for row in batch.rows:
        imus = {name: shock for name, shock in row.sensors.items() if is_imu(name)}
        imu = max(imus.items(), key=lambda pair: pair[1], default=(None, None))
        cells: Row = (row.robot, row.contact, row.trunk, *(row.values[name] for name in names), *imu)
        if not for_terminal:
            sensors = "; ".join(f"{name}={value!r}" for name, value in row.sensors.items())
            cells += (row.scene.posture.reference, row.joint_model, sensors, "; ".join(row.warnings), None)
        rows.append(cells)
    if not for_terminal:
        rows += [(failure.robot, failure.contact, *[None] * (len(header) - 3), failure.reason) for failure in batch.failures]
    title = f"{count(len(batch.rows), 'landing')}, ranked by the greatest shock over the trunk"
    return Sheet(title, header, rows, list(_notes(batch)) if for_terminal else ())


def _notes(batch: Batch) -> Iterable[str]:
    """What the columns mean, and what distinguishes some rows."""
    rows = batch.rows
    yield "trunk: the heaviest body; bodies' quantities are its own, points' its centre of mass's; of several places the worst"
    if rows:
        bound = max(row.values["error_bound"] or 0.0 for row in rows)
        yield f"jumps {proof_text(bound)}; shockpc quantities lists what the columns mean"
    if drives := [row.drives for row in rows if row.drives]:
        yield "; ".join(
            [*dict.fromkeys(drives), *(["--drives none for free joints"] if rows[0].scene.joints.drives is None else [])]
        )
    if free := list(dict.fromkeys(row.robot for row in rows if row.joint_model == "free" and not row.drives)):
        what = "joints are free, since nothing gives a reflected inertia; stiff gearboxes change the results considerably"
        yield what if len(free) == len({row.robot for row in rows}) else f"{', '.join(free)}: {what}"
    if any(sum(map(is_imu, row.sensors)) > 1 for row in rows):
        yield "of several IMUs the one with the greatest shock; CSV and JSON hold all"
    if any(row.values["shock_max"] is None for row in rows):
        yield "–: the trunk has no geometry; such rows come last, ranked by the shock at its centre of mass"
    neutral = list(dict.fromkeys(row.robot for row in rows if row.scene.posture.reference in ("neutral", BENT)))
    if neutral:
        bent = "with straight legs bent where they can be"
        yield f"in the neutral posture, {bent}, which is taken where no standing one is known: {', '.join(neutral)}"
    refused = [f"{row.robot} {row.contact}" for row in rows if row.values["feasible"] == 0.0]
    if refused:
        yield f"flat ground does not allow {count(len(refused), 'landing')}, as the warnings say: {', '.join(refused)}"
    warned = [row for row in rows if row.warnings]
    if warned:
        robots = ", ".join(dict.fromkeys(row.robot for row in warned))
        yield f"{count(len(warned), 'landing')} with warnings, which JSON, CSV and the report hold: {robots}"
