"""The report that a sceptic can rerun: Markdown, CSV, JSON and figures."""

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from shockpc.bench.cases import FAMILIES, Family
from shockpc.bench.cases.contacts import THROUGH_COM
from shockpc.bench.header import LIMITS
from shockpc.bench.measure import CaseResult
from shockpc.bench.percussion import Radius
from shockpc.bench.saving import PARTS, Saving
from shockpc.bench.tables import everything, family_sheet, outcomes, percussion, precision, promise, savings, throughput
from shockpc.bench.throughput import CLOCK, PeerResult
from shockpc.health import TRUSTED
from shockpc.show.figure.panels import Panel, save_panels
from shockpc.show.files import write_text
from shockpc.show.tables.text import as_csv, as_markdown

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
        percussion: centres and radii of percussion where the strike passes the centre of mass.
    """

    header: list[tuple[str, str]]
    cases: list[CaseResult]
    work: list[CaseResult]
    savings: list[Saving]
    peers: list[PeerResult]
    percussion: list[Radius]


def write_report(bench: Bench, folder: Path) -> None:
    """Write report.md, its figures, summary.md, bench.json, and cases, work, throughput, saving and percussion as CSV.

    Raises:
        OutputError: the folder cannot be written.
    """
    families = [one for one in FAMILIES if any(case.family == one.name for case in bench.cases)]
    _work_figure(bench.work, folder / "error-against-run-time.svg")
    write_text(folder / "cases.csv", as_csv(everything(bench.cases)))
    write_text(folder / "work.csv", as_csv(everything(bench.work)))
    write_text(folder / "throughput.csv", as_csv(throughput(bench.peers)))
    write_text(folder / "saving.csv", as_csv(savings(bench.savings)))
    write_text(folder / "percussion.csv", as_csv(percussion(bench.percussion)))
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
        "percussion": [asdict(one) for one in bench.percussion],
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
        "others. Simulations land without gravity, whose share would grow with the time that is simulated, until the contact is at",
        "rest; the harder it is, the nearer they come.",
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
        parts += [f"## {one.title}", "", f"Hard: {one.hard}.", ""]
        parts += [as_markdown(family_sheet(one, [case for case in bench.cases if case.family == one.name])), ""]
        if one is THROUGH_COM:
            parts += [as_markdown(percussion(bench.percussion)), ""]
    parts += ["## 3. What leaving out saves", "", "Forced on are:", "", *(f"- {part}" for part in PARTS), ""]
    parts += [as_markdown(savings(bench.savings)), ""]
    parts += ["## 4. Speed against peers on the same work", ""]
    parts += [*CLOCK, "", as_markdown(throughput(bench.peers))]
    return "\n".join(parts)


def _work_figure(cases: list[CaseResult], path: Path) -> None:
    """A panel for each case of part 1; a colour for each kind of method, a mark for each method, a line for each simulation."""
    looks: dict[str, tuple[int, int]] = {}
    for name in dict.fromkeys(_series(r.method) for case in cases for r in case.results):
        colour = next(k for k, kind in enumerate(KINDS) if name.startswith(kind))
        looks[name] = (colour, sum(used == colour for used, _ in looks.values()))
    panels = []
    for case in cases:
        points: dict[str, list[tuple[float, float]]] = {}
        absent: dict[str, list[str]] = {}
        for r in case.results:
            name = _series(r.method)
            if r.error is not None and r.timing is not None:
                points.setdefault(name, []).append((1e6 * r.timing.median, r.error))
            elif name not in absent.setdefault(r.outcome, []):
                absent[r.outcome].append(name)
        panels.append(Panel(f"{case.family}\n{case.variant}: {case.label}", points, absent))
    title = "Error against run time; lines join landings simulated on harder and harder ground"
    save_panels(path, title, "run time [µs]", "error of the worst body [-]", looks, panels, TRUSTED)


KINDS = ("shockpc", "pin.", "simulated on ABA", "simulated in MuJoCo", "")
"""How the names of methods begin that share a colour."""


def _series(method: str) -> str:
    """A method without the time constant of its contact, which is what varies along a line."""
    return re.sub(r", τ = [^,]+", "", method)
