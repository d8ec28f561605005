"""The report: a chart of error against run time, one table for each family, the costs of the package; Markdown and CSV."""

import importlib.metadata
import os
import platform
import sys
from collections import Counter
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from typing import NamedTuple

import shockpc
from shockpc.bench.cases import FAMILIES, Family
from shockpc.bench.costs import Cost
from shockpc.bench.measure import ACCURATE, OUTCOMES, CaseResult, MethodResult
from shockpc.bench.methods import DIRECT
from shockpc.bench.sweeps import ProcessCost, SweepCost
from shockpc.bench.throughput import PeerResult
from shockpc.show.figure.error_time import save_error_time
from shockpc.show.files import make_folder, write_text
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.show.tables.text import as_csv, as_markdown

__all__ = [
    "Bench",
    "costs_sheet",
    "landing_sheet",
    "methods_sheet",
    "save_chart",
    "sweeps_sheet",
    "throughput_sheet",
    "write_report",
]

LIBRARIES = ("pin", "numpy", "python-flint", "mujoco", "example-robot-data")

NOTES = (
    "error: of the velocity jump, largest over the bodies, relative to the body's own motion; for shockpc's printed numbers the "
    "proven bound",
    "τ: time constant of a simulated contact (without gravity): how long the impact lasts; the difference from the rigid impact "
    "becomes smaller with it",
)

REFERENCE = (
    "reference: the answer that shockpc proves by ball arithmetic; run times are from q to the velocities of all bodies, in one "
    "thread, without the first run; those of `shockpc, proven` include the proof"
)

LIMITS = (
    "Bodies are rigid and the impact takes no time; a real one takes milliseconds",
    "contacts stick or slide along given directions; whether friction suffices is reported, not enforced",
    "a drive is free, has a reflected inertia, or is locked; gearboxes that slip are not modelled",
    "all contacts come to rest together, in all directions; restitution is Newton's, for each contact",
    "masses and placements are taken as exact; their own uncertainty is usually the larger error by far",
    "impulses of contacts whose rows are dependent are not unique, and are not given",
)
"""What the numbers of the report do not cover."""


class Bench(NamedTuple):
    """All that was measured.

    Attributes:
        cases: of all families, by every method.
        costs: of the package.
        peers: many postures.
        sweeps: cost of their rows.
        processes: two against one.
        seconds: duration of the whole [s].
    """

    cases: list[CaseResult]
    costs: list[Cost]
    peers: list[PeerResult]
    sweeps: list[SweepCost]
    processes: ProcessCost
    seconds: float


def write_report(bench: Bench, folder: Path) -> None:
    """Write report.md, error-against-run-time.svg and cases.csv.

    Raises:
        OutputError: the folder cannot be written.
    """
    make_folder(folder)
    save_chart(bench.cases, folder / "error-against-run-time.svg")
    write_text(folder / "cases.csv", as_csv(_everything(bench.cases)))
    write_text(folder / "report.md", _markdown(bench))


def save_chart(cases: list[CaseResult], path: Path) -> None:
    """Draw error against run time of every method on every case."""
    series: dict[str, list[tuple[float, float]]] = {}
    for case in cases:
        for r in case.results:
            if r.error is not None and r.timing is not None:
                series.setdefault(r.method.split(", τ")[0], []).append((r.timing.median, r.error))
    save_error_time(path, "Error against run time; for shockpc's printed numbers the proven bound", series, ACCURATE)


def methods_sheet(cases: list[CaseResult]) -> Sheet:
    """How often each method had which outcome, and its run time."""
    results: dict[str, list[MethodResult]] = {}
    for case in cases:
        for r in case.results:
            results.setdefault(r.method, []).append(r)
    rows: list[tuple[Cell, ...]] = []
    for name, own in results.items():
        counted = Counter(r.outcome for r in own)
        times = [r.timing.median for r in own if r.timing is not None]
        rows.append((name, *(str(counted[key]) for key in OUTCOMES), _micro(median(times)) if times else None, _largest(own)))
    note = "; ".join(f"{key}: {meaning}" for key, meaning in OUTCOMES.items())
    return Sheet("outcomes of every method", ("method", *OUTCOMES, "median run time [µs]", "largest error [-]"), rows, (note,))


def costs_sheet(costs: list[Cost]) -> Sheet:
    """Run time of the package."""
    rows: list[tuple[Cell, ...]] = [
        (
            one.what,
            f"{one.milliseconds:.3g}",
            one.target or None,
            None if one.ratio is None else f"{one.ratio:.2f}",
            None if one.memory is None else f"{one.memory:.0f}",
        )
        for one in costs
    ]
    return Sheet("run time of the package", ("what", "median [ms]", "target", "× import pinocchio", "memory [MB]"), rows)


def throughput_sheet(peers: list[PeerResult]) -> Sheet:
    """Many postures."""
    base = {r.robot: r.seconds for r in peers if r.peer.startswith("Pinocchio") and r.seconds is not None}
    rows: list[tuple[Cell, ...]] = []
    for r in peers:
        numbers: tuple[Cell, ...] = (None, None, None)
        if r.seconds is not None:
            numbers = (f"{1e6 * r.seconds:.1f}", f"{r.seconds / base[r.robot]:.2f}", f"{r.difference:.1e}")
        rows.append((r.robot, r.peer, *numbers, r.message or None))
    header = ("robot", "method", "per posture [µs]", "× Pinocchio loop", "difference [-]", "remark")
    return Sheet("many postures", header, rows, ("difference: from the batched path, relative to the fastest body",))


def sweeps_sheet(sweeps: list[SweepCost], processes: ProcessCost) -> Sheet:
    """Rows of sweeps."""
    rows: list[tuple[Cell, ...]] = [
        (
            one.robot,
            str(one.size),
            _micro(one.row),
            _micro(one.maps),
            f"{one.row / one.maps:.2f}",
            f"{100.0 * one.dynamics:.0f}",
            f"{100.0 * one.solution:.0f}",
        )
        for one in sweeps
    ]
    header = (
        "robot",
        "bodies × velocities",
        "row [µs]",
        "maps [µs]",
        "row / maps",
        "of the row: Pinocchio [%]",
        "of the row: Eq. 4 [%]",
    )
    notes = (
        "row: joints drawn within limits, shock at one point with its most severe direction, friction and condition, in Parquet; "
        "maps: shock_maps of all bodies in the same postures",
        f"{processes.rows} rows of {sweeps[0].robot}: {processes.one:.2f} s in one process, {processes.two:.2f} s in two: "
        f"{processes.one / processes.two:.2f} times as fast",
    )
    return Sheet("sweeps", header, rows, notes)


def landing_sheet(case: CaseResult) -> Sheet:
    """All methods on one landing."""
    rows: list[tuple[Cell, ...]] = []
    for r in case.results:
        clock: tuple[Cell, ...] = (None, None)
        if r.timing is not None:
            clock = (_micro(r.timing.median), f"{_micro(r.timing.low)}–{_micro(r.timing.high)}")
        rows.append((r.method, _largest([r]), *clock, r.outcome, r.message or None))
    header = ("method", "error [-]", "median run time [µs]", "quartiles [µs]", "outcome", "remark")
    return Sheet("error against run time on this landing", header, rows, NOTES)


def _family_sheet(family: Family, cases: list[CaseResult]) -> Sheet:
    """One family: a column for each method that is not approximate, and a row for each case that one of these does not solve."""
    methods = [method.name for method in DIRECT if not method.approximates]
    rows: list[tuple[Cell, ...]] = []
    for case in cases:
        found = {r.method: r for r in case.results}
        own = [found[name] for name in methods if name in found]
        if any(r.outcome not in ("accurate", "unsuited") for r in own):
            errors = [r.outcome if r.error is None else _rounded(r.error) for r in own]
            rows.append((case.label, case.variant, *errors, *(None,) * (len(methods) - len(own))))
    notes = [family.about]
    if len(rows) < len(cases):
        notes.append(f"{len(cases) - len(rows)} of {len(cases)} cases are not listed: every method that can take them is accurate")
    return Sheet(f"{family.name}: error", (family.parameter, "variant", *methods), rows, ("; ".join(notes),))


def _everything(cases: list[CaseResult]) -> Sheet:
    """Every case by every method, for a spreadsheet."""
    header = ("family", "variant", "value", "method", "outcome", "error", "median_s", "low_s", "high_s", "runs", "message")
    rows: list[tuple[Cell, ...]] = []
    for case in cases:
        for r in case.results:
            clock: tuple[Cell, ...] = (None,) * 4 if r.timing is None else (*r.timing[:3], float(r.timing.runs))
            rows.append((*case[:3], r.method, r.outcome, r.error, *clock, r.message))
    return Sheet("every case by every method", header, rows)


def _markdown(bench: Bench) -> str:
    """The report as text."""
    facts = [*(f"{name}: {value}" for name, value in _header(bench)), REFERENCE, *NOTES]
    parts = [
        "# Error against run time",
        "",
        *(f"- {fact}" for fact in facts),
        "",
        "![error against run time](error-against-run-time.svg)",
        "",
        as_markdown(methods_sheet(bench.cases)),
    ]
    for family in FAMILIES:
        own = [case for case in bench.cases if case.family == family.name]
        if own:
            parts += [as_markdown(_family_sheet(family, own))]
    parts += [as_markdown(costs_sheet(bench.costs)), as_markdown(throughput_sheet(bench.peers))]
    parts += [as_markdown(sweeps_sheet(bench.sweeps, bench.processes))]
    parts += ["### Limits of the method", "", f"{'; '.join(LIMITS)}.", ""]
    return "\n".join(parts)


def _header(bench: Bench) -> list[tuple[str, str]]:
    """Name and value of everything that the results may depend on."""
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "")
    return [
        (
            "versions",
            ", ".join([f"shockpc {shockpc.__version__}", *map(_version, LIBRARIES), f"Python {platform.python_version()}"]),
        ),
        ("machine", f"{_cpu()}, {os.cpu_count()} cores, OPENBLAS_NUM_THREADS={threads}; {platform.platform()}"),
        ("run", f"{datetime.now(UTC):%Y-%m-%d %H:%M UTC}, {bench.seconds:.0f} s for {len(bench.cases)} cases"),
    ]


def _version(name: str) -> str:
    """Name and version of an installed distribution."""
    try:
        return f"{name} {importlib.metadata.version(name)}"
    except importlib.metadata.PackageNotFoundError:
        return f"{name} not installed"


def _cpu() -> str:
    """Name of the processor."""
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _micro(seconds: float) -> str:
    """A time in microseconds."""
    return f"{1e6 * seconds:.3g}" if seconds < 1e-3 else f"{1e6 * seconds:.0f}"


def _rounded(error: float) -> str:
    """An error; the reference itself is rounded to doubles."""
    return f"{error:.0e}" if error >= 1e-16 else "< 1e-16"


def _largest(results: Iterable[MethodResult]) -> Cell:
    """The largest error of some results."""
    errors = [r.error for r in results if r.error is not None]
    return f"{max(errors):.1e}" if errors else None
