"""The benchmark and its report: the standing suite, and one given landing.

The report has tables, and a chart of error against run time.
"""

import importlib.metadata
import math
import os
import platform
import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from functools import partial
from itertools import groupby
from pathlib import Path
from statistics import median

from shockpc import Robot, Scene
from shockpc.bench.cases import FAMILIES, Family, Trial
from shockpc.bench.costs import COSTS
from shockpc.bench.measure import ACCURATE, OUTCOMES, Result, measure
from shockpc.bench.methods import DIRECT, all_quantities
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.show.report import Picture, Report, Section
from shockpc.show.tables import Cell, Heading, Lines, Row, Sheet

PARTS = (*FAMILIES, *COSTS)
"""Parts of the suite."""

LIBRARIES = ("shockpc", "pin", "numpy", "python-flint", "mujoco", "example-robot-data")

METHODS = DIRECT | MUJOCO
ERROR = Heading("error", "error", "-", zero=0.0)
ALL_QUANTITIES = "shockpc, all quantities"
ALL_QUANTITIES_NOTE = (
    f'"{ALL_QUANTITIES}": a whole analysis, from the scene to every number of the document'
)
NOTES = (
    "error: of the velocity jump, largest over the bodies, relative to the body's motion; for "
    "shockpc's printed numbers the bound on rounding, for the robot as loaded. Below 1e-16 it is "
    "the error of the reference, which is rounded to doubles",
    "τ: time constant of a simulated contact (without gravity): how long the impact lasts; the "
    "difference from the rigid impact "
    "becomes smaller with it",
)

REFERENCE = (
    "reference: shockpc's answer in ball arithmetic. Run times are from q to the velocities of "
    'all bodies, in one thread, without the first run; those of "shockpc, exact" include the ball '
    "arithmetic"
)

LIMITS = (
    "bodies are rigid; without a contact stiffness the impact takes no time, but a real impact "
    "takes milliseconds",
    "without a coefficient of friction contacts stick, or slide along given directions; whether "
    "friction suffices is reported",
    "a drive is free, has a reflected inertia, with or without a spring, or is locked; gearboxes "
    "that slip are not modelled",
    "all contacts come to rest together; restitution is Newton's, for each contact",
    "masses and placements are taken as exact; their uncertainty is usually the larger error by "
    "far",
    "impulses of contacts whose rows are dependent are not unique, and are not given",
)


def suite_report(
    families: Iterable[str] = tuple(FAMILIES),
    budget: float = 0.003,
    progress: Callable[[str], None] = lambda part: None,
) -> Report:
    """Measure every case of every family, and what the package costs.

    Args:
        families: of cases.
        budget: time to spend on each method's clock on each case [s]; a hundred times as much on
            each other clock.
        progress: is called with the name of each part that is done.

    Raises:
        SolveError: a command failed.
    """
    start = time.perf_counter()
    results: list[Result] = []
    summaries: dict[str, Sheet] = {}
    for name in families:
        of_family: list[Result] = []
        for case in FAMILIES[name].cases():
            of_family += measure(case, METHODS, budget)
        results += of_family
        summaries[name] = _family_sheet(FAMILIES[name], of_family)
        progress(name)
    # The clocks run longer here, because whole analyses, commands and sweeps are timed.
    costs: dict[str, Sheet] = {}
    for name, table in COSTS.items():
        costs[name.replace(" ", "_")] = table(100.0 * budget)
        progress(name)
    summaries = {"methods": _methods_sheet(results), **summaries, **costs}
    cases = len({result.case for result in results})
    seconds = time.perf_counter() - start
    run = f"run: {datetime.now(UTC):%Y-%m-%d %H:%M UTC}, {seconds:.0f} s for {cases} cases"
    # Run times mean little without the machine and the versions that they were measured on.
    facts = Lines([*_surroundings(), run, REFERENCE, *NOTES])

    def body(full: bool) -> list[Section]:
        if not full:
            return [summaries["methods"], *costs.values()]
        limits = Lines(LIMITS, "limits of the method")
        return [facts, _chart(results), *summaries.values(), limits]

    # The table of every case is too long to print, so that it is a sheet only.
    sheets = {"cases": _cases_sheet(results), **summaries}
    return Report(
        name="bench",
        title="Error against run time",
        body=body,
        sheets={name: partial(sheets.__getitem__, name) for name in sheets},
        document=lambda: {"surroundings": _surroundings()},
        tables=True,
    )


def _cases_sheet(results: Iterable[Result]) -> Sheet:
    """A row for each method on each case."""
    header = (
        "family",
        "variant",
        "value",
        "method",
        "outcome",
        ERROR,
        "low [s]",
        "median [s]",
        "high [s]",
        "runs",
        "message",
    )
    rows: list[Row] = []
    for result in results:
        family, variant, value, _ = result.case
        cells = (family, variant, value, result.method, result.outcome, result.error)
        rows.append((*cells, *result.quartiles, len(result.seconds), result.message or None))
    return Sheet("", header, rows)


def bench_report(robot: Robot, scene: Scene, budget: float = 0.1) -> Report:
    """Error against run time of every method on one landing. Args: budget for each clock [s]."""
    case = Trial("landing", robot.name, "", lambda: (robot, scene))
    results = measure(case, METHODS | {ALL_QUANTITIES: all_quantities}, budget)
    rows: list[Row] = []
    for result in results:
        error = _largest([result])
        remark = result.message or None
        rows.append((result.method, error, *result.quartiles, result.outcome, remark))
    header = (
        "method",
        ERROR,
        "first quartile [µs]",
        "median run time [µs]",
        "third quartile [µs]",
        "outcome",
        "remark",
    )
    sheet = Sheet(
        "error against run time on this landing", header, rows, (*NOTES, ALL_QUANTITIES_NOTE)
    )
    return Report(
        name="landing",
        page="landing",
        body=lambda _: [sheet, _chart(results)],
        sheets={"landing": lambda: sheet},
        document=lambda: {"scene": scene},
        tables=True,
    )


def _surroundings() -> list[str]:
    """Versions of the libraries, and the machine."""
    installed = {package.name: package.version for package in importlib.metadata.distributions()}
    versions = [f"{name} {installed.get(name, 'not installed')}" for name in LIBRARIES]
    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")  # on Linux Python does not know the name of the processor
    if info.exists():
        text = info.read_text(encoding="utf-8")
        named = re.search(r"^model name\s*: (.*)", text, re.MULTILINE)
        processor = named[1] if named else processor
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "")
    return [
        f"versions: {', '.join(versions)}, Python {platform.python_version()}",
        f"machine: {processor}, {os.cpu_count()} cores, OPENBLAS_NUM_THREADS={threads}; "
        f"{platform.platform()}",
    ]


def _chart(results: Iterable[Result]) -> Picture:
    series: dict[str, list[tuple[float, float]]] = {}
    for result in results:
        if result.error is not None:
            points = series.setdefault(result.method.split(", τ")[0], [])
            points.append((median(result.seconds), result.error))
    title = "Error against run time; for shockpc's printed numbers the bound on rounding"
    return Picture(
        "error-against-run-time",
        "error against run time",
        "bench.figure:draw_error_time",
        (title, series, ACCURATE),
    )


def _methods_sheet(results: Sequence[Result]) -> Sheet:
    """A row for each method: the number of each outcome, and its run time."""
    rows: list[Row] = []
    for name in dict.fromkeys(result.method for result in results):
        of_method = [result for result in results if result.method == name]
        counted = Counter(result.outcome for result in of_method)
        outcomes = [counted[key] for key in OUTCOMES]
        medians = [median(result.seconds) for result in of_method if result.seconds]
        rows.append((name, *outcomes, median(medians or [math.nan]), _largest(of_method)))
    note = "; ".join(f"{key}: {meaning}" for key, meaning in OUTCOMES.items())
    return Sheet(
        "outcomes of every method",
        ("method", *OUTCOMES, "median run time [µs]", ERROR),
        rows,
        (note,),
    )


def _family_sheet(family: Family, results: Sequence[Result]) -> Sheet:
    """One family: a column for each method, a row for each case that one of them does not solve."""
    rows: list[Row] = []
    cases = [list(of_case) for _, of_case in groupby(results, lambda result: result.case)]
    for case in cases:
        if all(result.outcome in ("accurate", "approximate", "unsuited") for result in case):
            continue
        cells: dict[str, Cell] = {}
        for result in case:
            cells[result.method] = result.outcome if result.error is None else result.error
        first = case[0].case
        rows.append((first.value, first.variant, *map(cells.get, DIRECT)))
    note = family.about
    if len(rows) < len(cases):
        note += (
            f"; {len(cases) - len(rows)} of {len(cases)} cases are not listed: every method that "
            f"can take them is accurate"
        )
    return Sheet(
        f"{family.name}: error",
        (family.parameter, "variant", *(Heading(name, name, zero=0.0) for name in DIRECT)),
        rows,
        (note,),
    )


def _largest(results: Iterable[Result]) -> float | None:
    """The largest error of some results."""
    return max((result.error for result in results if result.error is not None), default=None)
