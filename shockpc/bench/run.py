"""The benchmark: the standing suite, and one landing of one's own."""

import time
from collections.abc import Callable, Iterable
from pathlib import Path

from shockpc.bench.cases import FAMILIES, Case
from shockpc.bench.costs import package_costs, sweep_costs
from shockpc.bench.measure import measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.bench.report import CHART, chart, landing_sheet, methods_sheet, report_files
from shockpc.bench.throughput import throughput
from shockpc.robot.robot import Robot
from shockpc.scene import Scene
from shockpc.show.files import write_folder
from shockpc.show.tables import Sheet, as_csv, as_markdown

__all__ = ["PARTS", "bench_landing", "run_suite"]

PARTS = (*FAMILIES, "costs", "many postures", "sweeps")
"""Parts of the suite."""


def run_suite(
    out: Path, families: Iterable[str] = tuple(FAMILIES), budget: float = 0.003, progress: Callable[[str], None] = lambda part: None
) -> list[Sheet]:
    """Measure every case of every family and write the report into a folder.

    Args:
        out: folder.
        families: of cases.
        budget: time to spend on each method's clock on each case [s]; a hundred times as much on each other clock.
        progress: is called with the name of each part that is done.

    Returns: the tables that are not of one family.

    Raises:
        OutputError: the folder cannot be written.
        SolveError: a command failed.
    """
    start, results, sheets = time.perf_counter(), [], []
    for name in families:
        for case in FAMILIES[name].cases():
            results += measure(case, DIRECT | MUJOCO, budget)
        progress(name)
    for name, table in (("costs", package_costs), ("many postures", throughput), ("sweeps", sweep_costs)):
        sheets.append(table(100.0 * budget))
        progress(name)
    write_folder(out, report_files(results, sheets, time.perf_counter() - start))
    return [methods_sheet(results), *sheets]


def bench_landing(robot: Robot, scene: Scene, out: Path | None = None, budget: float = 0.1) -> Sheet:
    """Error against run time of every method on one landing.

    Args:
        robot: the robot.
        scene: the landing.
        out: folder for the table and the chart; none is written without it.
        budget: time to spend on each method's clock [s].

    Raises:
        OutputError: the folder cannot be written.
    """
    results = measure(Case("landing", robot.name, "", lambda: (robot, scene)), DIRECT | MUJOCO, budget)
    sheet = landing_sheet(results)
    if out is not None:
        write_folder(out, {"landing.csv": as_csv(sheet), "landing.md": as_markdown(sheet), CHART: chart(results)})
    return sheet
