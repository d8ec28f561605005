"""The report: a chart of error against run time, tables of the results; Markdown and CSV."""

import importlib.metadata
import math
import os
import platform
from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from statistics import median

import numpy as np

from shockpc.bench.cases import FAMILIES, Family
from shockpc.bench.measure import ACCURATE, OUTCOMES, Result
from shockpc.bench.methods import DIRECT
from shockpc.show.figure.error_time import error_time_svg
from shockpc.show.tables import Cell, Sheet, as_csv, as_markdown

__all__ = ["CHART", "chart", "landing_sheet", "methods_sheet", "report_files"]

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

LIMITS = """### Limits of the method

Bodies are rigid and the impact takes no time; a real one takes milliseconds. Contacts stick or slide along given directions;
whether friction suffices is reported, not enforced. A drive is free, has a reflected inertia, or is locked; gearboxes that slip are
not modelled. All contacts come to rest together, in all directions; restitution is Newton's, for each contact. Masses and
placements are taken as exact; their own uncertainty is usually the larger error by far. Impulses of contacts whose rows are
dependent are not unique, and are not given.
"""


def report_files(results: Sequence[Result], sheets: Sequence[Sheet], seconds: float) -> dict[str, str | bytes]:
    """The files of the report, by name.

    Args:
        results: of all cases, family by family, by every method.
        sheets: further tables.
        seconds: duration of the whole [s].
    """
    families = [_family_sheet(FAMILIES[name], list(own)) for name, own in groupby(results, lambda one: one.case.family)]
    installed = {one.name: one.version for one in importlib.metadata.distributions()}
    versions = [f"{name} {installed.get(name, 'not installed')}" for name in LIBRARIES]
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "")
    facts = (
        f"versions: {', '.join(versions)}, Python {platform.python_version()}",
        f"machine: {_processor()}, {os.cpu_count()} cores, OPENBLAS_NUM_THREADS={threads}; {platform.platform()}",
        f"run: {datetime.now(UTC):%Y-%m-%d %H:%M UTC}, {seconds:.0f} s for {len({one.case for one in results})} cases",
        REFERENCE,
        *NOTES,
    )
    tables = map(as_markdown, (methods_sheet(results), *families, *sheets))
    listed = "".join(f"- {fact}\n" for fact in facts)
    report = "\n".join(["# Error against run time\n", listed, f"![error against run time]({CHART})\n", *tables, LIMITS])
    header = ("family", "variant", "value", "method", "outcome", "error", "low_s", "median_s", "high_s", "runs", "message")
    rows = [
        (*one.case[:3], one.method, one.outcome, one.error, *_quartiles(one), float(len(one.seconds)), one.message)
        for one in results
    ]
    return {"report.md": report, "cases.csv": as_csv(Sheet("", header, rows)), CHART: chart(results)}


def chart(results: Iterable[Result]) -> bytes:
    """Error against run time of every method on every case, as SVG."""
    series: dict[str, list[tuple[float, float]]] = {}
    for one in results:
        if one.error is not None:
            series.setdefault(one.method.split(", τ")[0], []).append((median(one.seconds), one.error))
    return error_time_svg("Error against run time; for shockpc's printed numbers the proven bound", series, ACCURATE)


def landing_sheet(results: Iterable[Result]) -> Sheet:
    """All methods on one landing."""
    rows: list[tuple[Cell, ...]] = []
    for one in results:
        rows.append((one.method, _largest([one]), *map(_micro, _quartiles(one)), one.outcome, one.message or None))
    header = ("method", "error [-]", "first quartile [µs]", "median run time [µs]", "third quartile [µs]", "outcome", "remark")
    return Sheet("error against run time on this landing", header, rows, NOTES)


def methods_sheet(results: Sequence[Result]) -> Sheet:
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


def _processor() -> str:
    """Name of the processor; Python knows it on some systems only."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return (names or [platform.processor() or platform.machine()])[0]


def _quartiles(one: Result) -> list[float | None]:
    """First quartile, median and third quartile of the run times [s]."""
    return np.quantile(one.seconds, (0.25, 0.5, 0.75)).tolist() if one.seconds else [None] * 3


def _micro(seconds: float | None) -> str | None:
    """A time in microseconds."""
    return None if seconds is None else f"{1e6 * seconds:.3g}" if seconds < 1e-3 else f"{1e6 * seconds:.0f}"


def _largest(results: Iterable[Result]) -> str | None:
    """The largest error of some results; the reference itself is rounded to doubles."""
    error = max((one.error for one in results if one.error is not None), default=None)
    return None if error is None else f"{error:.1e}" if error >= 1e-16 else "< 1e-16"
