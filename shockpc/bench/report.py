"""The report: a chart of error against run time, tables of the results and of the costs; Markdown and CSV."""

import importlib.metadata
import os
import platform
from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from statistics import median

from shockpc.bench.cases import FAMILIES, Family
from shockpc.bench.measure import ACCURATE, OUTCOMES, Result
from shockpc.bench.methods import DIRECT
from shockpc.show.figure.error_time import save_error_time
from shockpc.show.files import make_folder, write_text
from shockpc.show.tables.sheets import Cell, Sheet
from shockpc.show.tables.text import as_csv, as_markdown

__all__ = ["landing_sheet", "methods_sheet", "write_landing", "write_report"]

CHART = "error-against-run-time.svg"
LIBRARIES = ("shockpc", "pin", "numpy", "python-flint", "mujoco", "example-robot-data")

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


def write_report(results: Sequence[Result], sheets: Sequence[Sheet], seconds: float, folder: Path) -> None:
    """Write report.md, error-against-run-time.svg and cases.csv.

    Args:
        results: of all cases, family by family, by every method.
        sheets: further tables.
        seconds: duration of the whole [s].
        folder: made if it does not exist.

    Raises:
        OutputError: the folder cannot be written.
    """
    make_folder(folder)
    _save_chart(results, folder)
    write_text(folder / "cases.csv", as_csv(_results_sheet(results)))
    families = [_family_sheet(FAMILIES[name], list(own)) for name, own in groupby(results, lambda one: one.case.family)]
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "")
    facts = (
        f"versions: {', '.join(map(_version, LIBRARIES))}, Python {platform.python_version()}",
        f"machine: {_processor()}, {os.cpu_count()} cores, OPENBLAS_NUM_THREADS={threads}; {platform.platform()}",
        f"run: {datetime.now(UTC):%Y-%m-%d %H:%M UTC}, {seconds:.0f} s for {len({one.case for one in results})} cases",
        REFERENCE,
        *NOTES,
    )
    parts = [
        "# Error against run time\n",
        "".join(f"- {fact}\n" for fact in facts),
        f"![error against run time]({CHART})\n",
        *map(as_markdown, (methods_sheet(results), *families, *sheets)),
        f"### Limits of the method\n\n{'; '.join(LIMITS)}.\n",
    ]
    write_text(folder / "report.md", "\n".join(parts))


def write_landing(results: Sequence[Result], folder: Path) -> None:
    """Write the table of one landing (landing.csv, landing.md) and the chart.

    Raises:
        OutputError: the folder cannot be written.
    """
    make_folder(folder)
    _save_chart(results, folder)
    write_text(folder / "landing.csv", as_csv(landing_sheet(results)))
    write_text(folder / "landing.md", as_markdown(landing_sheet(results)))


def landing_sheet(results: Sequence[Result]) -> Sheet:
    """All methods on one landing."""
    rows: list[tuple[Cell, ...]] = []
    for one in results:
        clock: tuple[Cell, ...] = (None, None)
        if one.timing:
            clock = (_micro(one.timing.median), f"{_micro(one.timing.low)}–{_micro(one.timing.high)}")
        rows.append((one.method, _largest([one]), *clock, one.outcome, one.message or None))
    header = ("method", "error [-]", "median run time [µs]", "quartiles [µs]", "outcome", "remark")
    return Sheet("error against run time on this landing", header, rows, NOTES)


def methods_sheet(results: Sequence[Result]) -> Sheet:
    """How often each method had which outcome, and its run time."""
    rows: list[tuple[Cell, ...]] = []
    for name in dict.fromkeys(one.method for one in results):
        own = [one for one in results if one.method == name]
        counted = Counter(one.outcome for one in own)
        times = [one.timing.median for one in own if one.timing]
        rows.append((name, *(str(counted[key]) for key in OUTCOMES), _micro(median(times)) if times else None, _largest(own)))
    note = "; ".join(f"{key}: {meaning}" for key, meaning in OUTCOMES.items())
    return Sheet("outcomes of every method", ("method", *OUTCOMES, "median run time [µs]", "largest error [-]"), rows, (note,))


def _family_sheet(family: Family, results: Sequence[Result]) -> Sheet:
    """One family: a column for each method, and a row for each case that one of them does not solve."""
    rows: list[tuple[Cell, ...]] = []
    total = 0
    for case, group in groupby(results, lambda one: one.case):
        total += 1
        own = {one.method: one for one in group}
        if any(one.outcome not in ("accurate", "approximate", "unsuited") for one in own.values()):
            errors = (None if name not in own else _largest([own[name]]) or own[name].outcome for name in DIRECT)
            rows.append((case.value, case.variant, *errors))
    note = family.about
    if len(rows) < total:
        note += f"; {total - len(rows)} of {total} cases are not listed: every method that can take them is accurate"
    return Sheet(f"{family.name}: error", (family.parameter, "variant", *DIRECT), rows, (note,))


def _results_sheet(results: Iterable[Result]) -> Sheet:
    """Every case by every method, for a spreadsheet."""
    header = ("family", "variant", "value", "method", "outcome", "error", "median_s", "low_s", "high_s", "runs", "message")
    rows = [
        (*one.case[:3], one.method, one.outcome, one.error, *map(float, one.timing), one.message)
        if one.timing
        else (*one.case[:3], one.method, one.outcome, one.error, None, None, None, None, one.message)
        for one in results
    ]
    return Sheet("every case by every method", header, rows)


def _save_chart(results: Iterable[Result], folder: Path) -> None:
    """Draw error against run time of every method on every case."""
    series: dict[str, list[tuple[float, float]]] = {}
    for one in results:
        if one.error is not None and one.timing:
            series.setdefault(one.method.split(", τ")[0], []).append((one.timing.median, one.error))
    save_error_time(folder / CHART, "Error against run time; for shockpc's printed numbers the proven bound", series, ACCURATE)


def _version(name: str) -> str:
    """Name and version of an installed distribution."""
    try:
        return f"{name} {importlib.metadata.version(name)}"
    except importlib.metadata.PackageNotFoundError:
        return f"{name} not installed"


def _processor() -> str:
    """Name of the processor; Python knows it on some systems only."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return (names or [platform.processor() or platform.machine()])[0]


def _micro(seconds: float) -> str:
    """A time in microseconds."""
    return f"{1e6 * seconds:.3g}" if seconds < 1e-3 else f"{1e6 * seconds:.0f}"


def _largest(results: Iterable[Result]) -> str | None:
    """The largest error of some results; the reference itself is rounded to doubles."""
    error = max((one.error for one in results if one.error is not None), default=None)
    return None if error is None else f"{error:.1e}" if error >= 1e-16 else "< 1e-16"
