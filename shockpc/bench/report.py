"""The report that a sceptic can rerun: Markdown, CSV, JSON and figures."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from shockpc.bench.cases import FAMILIES, Family
from shockpc.bench.header import LIMITS
from shockpc.bench.measure import CaseResult
from shockpc.bench.saving import PARTS, Saving
from shockpc.bench.tables import everything, family_sheet, outcomes, precision, promise, savings, throughput
from shockpc.bench.throughput import PeerResult
from shockpc.show.curves import Curve, save_curves
from shockpc.show.files import write_text
from shockpc.show.text import as_csv, as_markdown

__all__ = ["Bench", "summary", "write_report"]


@dataclass(frozen=True)
class Bench:
    """All that was measured.

    Attributes:
        header: name and value of what a rerun depends on.
        cases: of the suite, every one by every direct method.
        work: the cases of part 1, by simulation besides.
        savings: part 3.
        peers: part 4.
    """

    header: list[tuple[str, str]]
    cases: list[CaseResult]
    work: list[CaseResult]
    savings: list[Saving]
    peers: list[PeerResult]


def write_report(bench: Bench, folder: Path) -> None:
    """Write report.md, its figures, summary.md, cases.csv, work.csv, throughput.csv, saving.csv and bench.json.

    Raises:
        OutputError: the folder cannot be written.
    """
    families = [one for one in FAMILIES if any(case.family == one.name for case in bench.cases)]
    _work_figure(bench.work, folder / "error-against-run-time.svg")
    for one in families:
        _family_figure(one, [case for case in bench.cases if case.family == one.name], folder / _figure(one))
    write_text(folder / "cases.csv", as_csv(everything(bench.cases)))
    write_text(folder / "work.csv", as_csv(everything(bench.work)))
    write_text(folder / "throughput.csv", as_csv(throughput(bench.peers)))
    write_text(folder / "saving.csv", as_csv(savings(bench.savings)))
    write_text(folder / "bench.json", json.dumps(_document(bench), indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    write_text(folder / "summary.md", summary(bench))
    write_text(folder / "report.md", _markdown(bench, families))


def summary(bench: Bench) -> str:
    """What the README shows of it."""
    sheets = (promise(bench.cases), outcomes(bench.cases), savings(bench.savings), throughput(bench.peers))
    return "\n".join(as_markdown(sheet) for sheet in sheets)


def _document(bench: Bench) -> dict[str, Any]:
    """The report as plain tables; a number that is not finite becomes a null."""
    document = {
        "schema": "shockpc.bench/1",
        "header": dict(bench.header),
        "cases": [case.table() for case in bench.cases],
        "work": [case.table() for case in bench.work],
        "saving": [asdict(one) for one in bench.savings],
        "throughput": [asdict(one) for one in bench.peers],
    }
    finite: dict[str, Any] = json.loads(json.dumps(document), parse_constant=lambda _: None)
    return finite


def _markdown(bench: Bench, families: list[Family]) -> str:
    """The report as people read it."""
    parts = ["# Error against run time", ""]
    parts += ["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in bench.header), ""]
    parts += [
        "Errors are those of the jump of each body (velocity of the centre of mass, rotation at the radius of gyration), relative",
        "to the body's own motion, the worst body of a case; against a reference with a hundred digits that is put back into every",
        "equation. Times go from q to the velocities of all bodies, in one thread: first run left out, median and quartiles of the",
        "others.",
        "",
        "## Limits of the method",
        "",
        *(f"- {limit}" for limit in LIMITS),
        "",
        "## 1. Error against run time",
        "",
        "![error against run time](error-against-run-time.svg)",
        "",
    ]
    for case in bench.work:
        parts += [as_markdown(precision(case)), ""]
    parts += ["## 2. Stiff and extreme cases", "", as_markdown(promise(bench.cases)), "", as_markdown(outcomes(bench.cases)), ""]
    for one in families:
        parts += [f"## {one.title}", "", f"Hard: {one.hard}.", "", f"![{one.name}]({_figure(one)})", ""]
        parts += [as_markdown(family_sheet(one, [case for case in bench.cases if case.family == one.name])), ""]
    parts += ["## 3. What leaving out saves", "", "Forced on are:", "", *(f"- {part}" for part in PARTS), ""]
    parts += [as_markdown(savings(bench.savings)), ""]
    parts += ["## 4. Speed against peers on the same work", ""]
    parts += ["All bodies' jumps in many random postures. The product gives the maps of all strike directions besides.", ""]
    parts += [as_markdown(throughput(bench.peers))]
    return "\n".join(parts)


def _figure(family: Family) -> str:
    """The file of a family's figure."""
    return f"{family.name.replace(' ', '-')}.svg"


def _family_figure(family: Family, cases: list[CaseResult], path: Path) -> None:
    """Error and estimate over the parameter, a colour for each variant."""
    curves = []
    seen = sorted({case.value for case in cases})
    joined = not family.labels
    for k, variant in enumerate(family.variants):
        own = [case for case in cases if case.variant == variant]
        x = tuple(float(seen.index(case.value)) if family.labels else case.value for case in own)
        curves.append(Curve(variant, x, tuple(case.results[0].error for case in own), k, joined=joined))
        estimates = tuple(case.results[0].estimate for case in own)
        curves.append(Curve(f"{variant}: estimate", x, estimates, k, dashed=True, joined=joined))
    names = tuple(family.labels[int(value)] for value in seen) if family.labels else ()
    save_curves(path, family.title, "" if names else family.parameter, "error of the worst body [-]", curves, names)


def _work_figure(cases: list[CaseResult], path: Path) -> None:
    """Every method on every case of part 1, a mark for each method."""
    names = list(dict.fromkeys(_short(r.method) for case in cases for r in case.results if r.timing))
    curves = []
    for k, name in enumerate(names):
        found = [r for case in cases for r in case.results if _short(r.method) == name and r.timing and r.error is not None]
        x = tuple(1e6 * r.timing.median for r in found if r.timing)
        curves.append(Curve(name, x, tuple(r.error for r in found), k, joined=False))
    save_curves(path, "Error against run time", "run time [µs]", "error of the worst body [-]", curves)


def _short(method: str) -> str:
    """A method without its settings."""
    return method.partition(", τ")[0]
