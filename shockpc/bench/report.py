"""The benchmark and its report: the standing suite, and one landing of one's own; tables, and a chart of error against run time."""

import importlib.metadata
import math
import os
import platform
import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from statistics import median

from shockpc import Robot, Scene
from shockpc.bench.cases import FAMILIES, Case, Family
from shockpc.bench.costs import COSTS
from shockpc.bench.measure import ACCURATE, OUTCOMES, Result, measure
from shockpc.bench.methods import DIRECT, all_quantities
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.show.figure.error_time import error_time_svg
from shockpc.show.files import write_folder
from shockpc.show.tables import Cell, Sheet, as_csv, as_markdown, markdown_list

__all__ = ["PARTS", "bench_landing", "run_suite"]

PARTS = (*FAMILIES, *COSTS)
"""Parts of the suite."""

CHART = "error-against-run-time.svg"
LIBRARIES = ("shockpc", "pin", "numpy", "python-flint", "mujoco", "example-robot-data")

METHODS = DIRECT | MUJOCO
WHOLE = "shockpc, all quantities"
WHOLE_NOTE = f'"{WHOLE}": a whole analysis, from the scene to every number of the document'
NOTES = (
    "error: of the velocity jump, largest over the bodies, relative to the body's own motion; for shockpc's printed numbers the "
    "proven bound, for the robot as loaded",
    "τ: time constant of a simulated contact (without gravity): how long the impact lasts; the difference from the rigid impact "
    "becomes smaller with it",
)

REFERENCE = (
    "reference: the answer that shockpc proves by ball arithmetic; run times are from q to the velocities of all bodies, in one "
    'thread, without the first run; those of "shockpc, proven" include the proof'
)

LIMITS = """### Limits of the method

Bodies are rigid and the impact takes no time; a real one takes milliseconds. Contacts stick or slide along given directions;
whether friction suffices is reported, not enforced. A drive is free, has a reflected inertia, or is locked; gearboxes that slip are
not modelled. All contacts come to rest together, in all directions; restitution is Newton's, for each contact. Masses and
placements are taken as exact; their own uncertainty is usually the larger error by far. Impulses of contacts whose rows are
dependent are not unique, and are not given.
"""


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
    start = time.perf_counter()
    results: list[Result] = []
    tables, costs = [], []
    for name in families:
        own = [one for case in FAMILIES[name].cases() for one in measure(case, METHODS, budget)]
        results += own
        tables.append(_family_sheet(FAMILIES[name], own))
        progress(name)
    for name, table in COSTS.items():
        costs.append(table(100.0 * budget))
        progress(name)
    methods = _methods_sheet(results)
    run = f"run: {datetime.now(UTC):%Y-%m-%d %H:%M UTC}, {time.perf_counter() - start:.0f} s for"
    facts = markdown_list([*_surroundings(), f"{run} {len({one.case for one in results})} cases", REFERENCE, *NOTES])
    blocks = ["# Error against run time\n", facts, f"![error against run time]({CHART})\n"]
    blocks += [*map(as_markdown, (methods, *tables, *costs)), LIMITS]
    header = ("family", "variant", "value", "method", "outcome", "error", "low_s", "median_s", "high_s", "runs", "message")
    rows = [
        (*one.case[:3], one.method, one.outcome, one.error, *one.quartiles, float(len(one.seconds)), one.message) for one in results
    ]
    write_folder(out, {"report.md": "\n".join(blocks), "cases.csv": as_csv(Sheet("", header, rows)), CHART: _chart(results)})
    return [methods, *costs]


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
    results = measure(Case("landing", robot.name, "", lambda: (robot, scene)), METHODS | {WHOLE: all_quantities}, budget)
    rows = [(one.method, _largest([one]), *map(_micro, one.quartiles), one.outcome, one.message or None) for one in results]
    header = ("method", "error [-]", "first quartile [µs]", "median run time [µs]", "third quartile [µs]", "outcome", "remark")
    sheet = Sheet("error against run time on this landing", header, rows, (*NOTES, WHOLE_NOTE))
    if out is not None:
        write_folder(out, {"landing.csv": as_csv(sheet), "landing.md": as_markdown(sheet), CHART: _chart(results)})
    return sheet


def _surroundings() -> list[str]:
    """Versions of the libraries, and the machine."""
    installed = {one.name: one.version for one in importlib.metadata.distributions()}
    versions = [f"{name} {installed.get(name, 'not installed')}" for name in LIBRARIES]
    info = Path("/proc/cpuinfo")  # on Linux Python does not know the name of the processor
    names = re.findall(r"^model name\s*: (.*)", info.read_text(encoding="utf-8") if info.exists() else "", re.MULTILINE)
    processor, threads = (names or [platform.processor() or platform.machine()])[0], os.environ.get("OPENBLAS_NUM_THREADS", "")
    return [
        f"versions: {', '.join(versions)}, Python {platform.python_version()}",
        f"machine: {processor}, {os.cpu_count()} cores, OPENBLAS_NUM_THREADS={threads}; {platform.platform()}",
    ]


def _chart(results: Iterable[Result]) -> bytes:
    """Error against run time of every method on every case, as SVG."""
    series: dict[str, list[tuple[float, float]]] = {}
    for one in results:
        if one.error is not None:
            series.setdefault(one.method.split(", τ")[0], []).append((median(one.seconds), one.error))
    return error_time_svg("Error against run time; for shockpc's printed numbers the proven bound", series, ACCURATE)


def _methods_sheet(results: Sequence[Result]) -> Sheet:
    """How often each method had which outcome, and its run time."""
    rows: list[tuple[Cell, ...]] = []
    for name in dict.fromkeys(one.method for one in results):
        own = [one for one in results if one.method == name]
        counted = Counter(one.outcome for one in own)
        middle = [median(one.seconds) for one in own if one.seconds]
        rows.append((name, *(str(counted[key]) for key in OUTCOMES), _micro(median(middle or [math.nan])), _largest(own)))
    note = "; ".join(f"{key}: {meaning}" for key, meaning in OUTCOMES.items())
    return Sheet("outcomes of every method", ("method", *OUTCOMES, "median run time [µs]", "largest error [-]"), rows, (note,))


def _family_sheet(family: Family, results: Sequence[Result]) -> Sheet:
    """One family: a column for each method, and a row for each case that one of them does not solve."""
    rows: list[tuple[Cell, ...]] = []
    cases = [list(own) for _, own in groupby(results, lambda one: one.case)]
    for case in cases:
        if any(one.outcome not in ("accurate", "approximate", "unsuited") for one in case):
            cells = {one.method: _largest([one]) or one.outcome for one in case}
            rows.append((case[0].case.value, case[0].case.variant, *map(cells.get, DIRECT)))
    note = family.about
    if len(rows) < len(cases):
        note += f"; {len(cases) - len(rows)} of {len(cases)} cases are not listed: every method that can take them is accurate"
    return Sheet(f"{family.name}: error", (family.parameter, "variant", *DIRECT), rows, (note,))


def _micro(seconds: float | None) -> str | None:
    """A time in microseconds."""
    return None if seconds is None else f"{1e6 * seconds:.3g}" if seconds < 1e-3 else f"{1e6 * seconds:.0f}"


def _largest(results: Iterable[Result]) -> str | None:
    """The largest error of some results; the reference itself is rounded to doubles."""
    error = max((one.error for one in results if one.error is not None), default=None)
    return None if error is None else f"{error:.1e}" if error >= 1e-16 else "< 1e-16"
