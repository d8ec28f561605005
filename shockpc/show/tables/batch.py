"""A batch as a table: one row for each landing, ranked by the shock of the trunk."""

import math
from collections.abc import Iterable

from shockpc.robot.landmarks import is_imu
from shockpc.show.header import count
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.studies.batch import Batch, BatchRow

__all__ = ["batch_sheet", "failure_lines"]


def batch_sheet(batch: Batch, fold: bool = True) -> Sheet:
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
    imu, shock = _greatest(row)
    cells: tuple[Cell, ...] = (row.robot, row.contact, row.mass, row.trunk, row.ropc, row.shock_max, row.shock_free)
    cells += (row.shock_com,) * modelled
    cells += (row.shock_locked, imu, shock, row.effective_mass)
    if fold:
        return (*cells, "tensile" if row.friction_needed == math.inf else row.friction_needed, f"{row.error_bound:.0e}")
    sensors = "; ".join(f"{name}={value!r}" for name, value in row.sensors.items())
    cells += (row.friction_needed, row.error_bound, row.scene.posture.reference, row.joint_model)
    return (*cells, sensors, "; ".join(row.warnings), None)


def failure_lines(batch: Batch) -> list[str]:
    """What could not be computed and why, one line each."""
    return [" ".join(filter(None, (one.robot, one.contact))) + f": {one.reason}" for one in batch.failures]


def _greatest(row: BatchRow) -> tuple[str | None, float | None]:
    """The IMU with the greatest shock."""
    imus = {name: shock for name, shock in row.sensors.items() if is_imu(name)}
    if not imus:
        return None, None
    name = max(imus, key=imus.__getitem__)
    return name, imus[name]


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
