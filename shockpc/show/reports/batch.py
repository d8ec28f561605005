"""A batch: one row for each landing, ranked by the shock of the trunk, and a sheet of pictures where the batch has them."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from shockpc.robot.landmarks import is_imu
from shockpc.show.document import head, record
from shockpc.show.header import count
from shockpc.show.reports.report import Report
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.batch import Batch, BatchRow

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["batch_report"]

ROW = (
    "robot", "contact", "mass", "trunk", "ropc", "shock_max", "shock_com", "shock_free", "shock_locked", "joint_model", "sensors",
    "effective_mass", "friction_needed", "error_bound", "warnings", "scene",
)  # fmt: skip
"""Keys of a row of the document."""


def batch_report(batch: Batch) -> Report:
    """The landings of many robots; the Markdown document also has their warnings."""

    def draw() -> "Figure":
        from shockpc.show.figure.contact_sheet import draw_contact_sheet

        return draw_contact_sheet(batch)

    failed = [" ".join(filter(None, (one.robot, one.contact))) + f": {one.reason}" for one in batch.failures]
    return Report(
        name="batch",
        title="Landings of robots",
        tables=lambda _: [_sheet(batch)],
        closing=[f"not computed: {line}" for line in failed],
        details=list(dict.fromkeys(f"warning: {row.robot}: {warning}" for row in batch.rows for warning in row.warnings)),
        sheets={"batch": lambda: _sheet(batch, fold=False)},
        document=lambda: _document(batch),
        picture="sheet" if any(row.picture is not None for row in batch.rows) else "",
        caption="the landings, the greatest shock of the trunk first",
        draw=draw,
    )


def _document(batch: Batch) -> dict[str, Any]:
    """The document, schema `shockpc.batch/1`."""
    return {
        **head("batch"),
        "rows": [record(row, *ROW) for row in batch.rows],
        "failures": [record(one, "robot", "contact", "reason") for one in batch.failures],
    }


def _sheet(batch: Batch, fold: bool = True) -> Sheet:
    """One row for each landing.

    Args:
        batch: the landings.
        fold: for people: of several IMUs the one with the greatest shock, and no column that repeats another; otherwise all
            sensors, the trunk's name, and the landings that failed.
    """
    modelled = any(row.joint_model != "free" for row in batch.rows) or not fold
    header: tuple[str, ...] = ("robot", "contact", "mass [kg]", "trunk", "RoPc [m]", "greatest [-]", "free [-]")
    header += ("as modelled [-]",) * modelled
    header += ("locked [-]", "IMU", "at IMU [-]", "eff. mass [kg]", "friction [-]", "error bound [-]" if not fold else "error")
    header += () if fold else ("posture", "joint model", "sensors and points [-]", "warnings", "failure")
    rows = [_cells(row, modelled, fold) for row in batch.rows]
    if not fold:
        blank: tuple[Cell, ...] = (None,) * (len(header) - 3)
        rows += [(failure.robot, failure.contact, *blank, failure.reason) for failure in batch.failures]
    title = f"{count(len(batch.rows), 'landing')}, ranked by the greatest shock over the trunk"
    return Sheet(title, header, rows, tuple(_notes(batch)) if fold else ())


def _cells(row: BatchRow, modelled: bool, fold: bool) -> tuple[Cell, ...]:
    """One landing."""
    imus = {name: shock for name, shock in row.sensors.items() if is_imu(name)}
    imu = max(imus.items(), key=lambda one: one[1], default=(None, None))
    cells: tuple[Cell, ...] = (row.robot, row.contact, row.mass, row.trunk, row.ropc, row.shock_max, row.shock_free)
    cells += (row.shock_com,) * modelled
    cells += (row.shock_locked, *imu, row.effective_mass)
    if fold:
        return (*cells, "tensile" if row.friction_needed == math.inf else row.friction_needed, f"{row.error_bound:.0e}")
    sensors = "; ".join(f"{name}={value!r}" for name, value in row.sensors.items())
    cells += (row.friction_needed, row.error_bound, row.scene.posture.reference, row.joint_model)
    return (*cells, sensors, "; ".join(row.warnings), None)


def _notes(batch: Batch) -> Iterable[str]:
    """What the columns mean, and what distinguishes some rows."""
    rows = batch.rows
    yield "trunk: the heaviest body; RoPc and greatest shock are its own, free and locked: shock at its CoM with such joints"
    yield "effective mass and friction of a contact that sticks; error: proven bound, relative to each body's motion"
    models = sorted({row.joint_model for row in rows})
    if models == ["free"]:
        yield "joints are free, since nothing gives a reflected inertia; stiff gearboxes change the results considerably"
    if any(sum(map(is_imu, row.sensors)) > 1 for row in rows):
        yield "of several IMUs the one with the greatest shock; CSV and JSON hold all"
    if any(row.shock_max is None for row in rows):
        yield "–: the trunk has no geometry; such rows come last, ranked by the shock at its centre of mass"
    neutral = list(dict.fromkeys(row.robot for row in rows if row.scene.posture.reference == "neutral"))
    if neutral:
        yield f"in the neutral posture, which is taken where no standing one is known: {', '.join(neutral)}"
    warned = [row for row in rows if row.warnings]
    if warned:
        robots = ", ".join(dict.fromkeys(row.robot for row in warned))
        yield f"{count(len(warned), 'landing')} with warnings, which JSON, CSV and the report hold: {robots}"
