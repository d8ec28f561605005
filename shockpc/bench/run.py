"""The benchmark: the standing suite, and one landing of one's own."""

import sys
import time
from pathlib import Path

from shockpc.bench.cases import FAMILIES, Case, Family
from shockpc.bench.costs import analysis_costs, command_costs
from shockpc.bench.measure import CaseResult, measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.bench.report import Bench, landing_sheet, save_chart, write_report
from shockpc.bench.sweeps import process_costs, sweep_costs
from shockpc.bench.throughput import SCENES, compete
from shockpc.robot.robot import Robot
from shockpc.scene import Scene
from shockpc.show.files import make_folder, write_text
from shockpc.show.tables.sheets import Sheet
from shockpc.show.tables.text import as_csv, as_markdown

__all__ = ["SIMULATED_CASES", "bench_landing", "run_suite"]

SIMULATED_CASES = ("robots / one foot / anymal_b", "robots / all feet / talos", "corners / sticking / 4")
"""Cases that are simulated as well."""


def run_suite(
    out: Path, families: tuple[Family, ...] = FAMILIES, postures: int = 512, budget: float = 0.003, runs: int = 5, rows: int = 16384
) -> Bench:
    """Measure every case of every family and write the report into a folder.

    Args:
        out: folder.
        families: of cases.
        postures: in the comparison of many postures.
        budget: time to spend on each method's clock on each case [s].
        runs: of each command.
        rows: of the sweeps; sixteen times as many where two processes are compared with one.

    Raises:
        OutputError: the folder cannot be written.
        SolveError: a command failed.
    """
    start = time.perf_counter()
    make_folder(out)
    cases: list[CaseResult] = []
    for family in families:
        _say(family.name)
        for case in family.cases():
            methods = (*DIRECT, *MUJOCO[1::2]) if case.name in SIMULATED_CASES else DIRECT
            cases.append(measure(case, methods, budget))
    _say("costs")
    costs = [*analysis_costs(100.0 * budget), *command_costs(runs)]
    peers = []
    for name in SCENES:
        _say(f"many postures of {name}")
        peers += compete(name, postures, 100.0 * budget)
    _say("sweeps")
    sweeps, processes = sweep_costs(rows, 100.0 * budget), process_costs(16 * rows)
    _say("")
    bench = Bench(cases, costs, peers, sweeps, processes, time.perf_counter() - start)
    write_report(bench, out)
    return bench


def bench_landing(robot: Robot, scene: Scene, out: Path | None = None, budget: float = 0.1) -> Sheet:
    """Error against run time of every method on one landing.

    Args:
        robot: the robot.
        scene: the landing.
        out: folder for the table (landing.csv, landing.md) and the chart; none is written without it.
        budget: time to spend on each method's clock [s].

    Raises:
        OutputError: the folder cannot be written.
    """
    case = Case("landing", robot.name, "", lambda: (robot, scene))
    result: CaseResult = measure(case, (*DIRECT, *MUJOCO), budget)
    sheet = landing_sheet(result)
    if out is not None:
        make_folder(out)
        save_chart([result], out / "error-against-run-time.svg")
        write_text(out / "landing.csv", as_csv(sheet))
        write_text(out / "landing.md", as_markdown(sheet))
    return sheet


def _say(text: str) -> None:
    """Progress, on a terminal only: one line that replaces the last."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\x1b[K{text}")
        sys.stderr.flush()
