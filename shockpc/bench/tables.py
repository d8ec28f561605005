"""Results as tables: one title for ever, so that two reports can be laid side by side."""

from collections import Counter

from shockpc.bench.cases import Family
from shockpc.bench.measure import OUTCOMES, CaseResult, MethodResult
from shockpc.bench.percussion import Radius
from shockpc.bench.saving import Saving
from shockpc.bench.soak import LOOSE
from shockpc.bench.throughput import PeerResult
from shockpc.show.tables.sheets import Cell, Sheet

__all__ = ["everything", "family_sheet", "outcomes", "percussion", "precision", "promise", "savings", "throughput"]


def precision(case: CaseResult) -> Sheet:
    """Part 1: all methods on one case."""
    header = ("method", "error [-]", "of the fastest body [-]", "outcome", "median [µs]", "quartiles [µs]", "runs")
    rows: list[tuple[Cell, ...]] = []
    for r in case.results:
        median, quartiles, runs = _clock(r)
        rows.append((r.method, _sci(r.error), _sci(r.whole), r.outcome, median, quartiles, runs))
    return Sheet(f"error against run time: {case.name}", header, rows)


def _clock(r: MethodResult) -> tuple[Cell, Cell, Cell]:
    """Median, quartiles and runs, as text."""
    if r.timing is None:
        return None, None, None
    low, median, high = (f"{1e6 * value:.3g}" for value in (r.timing.low, r.timing.median, r.timing.high))
    return median, f"{low}–{high}", str(r.timing.runs)


def _sci(value: float | None) -> Cell:
    """A number of which only the size matters."""
    return None if value is None else f"{value:.1e}"


def outcomes(cases: list[CaseResult]) -> Sheet:
    """How often each method came to what, over the whole suite."""
    names = list(dict.fromkeys(r.method for case in cases for r in case.results))
    counted = {name: Counter(r.outcome for case in cases for r in case.results if r.method == name) for name in names}
    rows: list[tuple[Cell, ...]] = [(name, *(str(counted[name][key]) for key in OUTCOMES)) for name in names]
    notes = tuple(f"{key}: {meaning}" for key, meaning in OUTCOMES.items())
    return Sheet("outcomes over the suite", ("method", *OUTCOMES), rows, notes)


def promise(cases: list[CaseResult]) -> Sheet:
    """Whether the product's error estimate held."""
    held = [(case, r) for case in cases for r in case.results if r.margin is not None and r.error is not None]
    broken = [(case, r) for case, r in held if (r.margin or 0.0) > 1.0]
    tight = sum((r.estimate or 0.0) <= LOOSE * max(r.error or 0.0, 2.0**-53) for _, r in held)
    silent = [case for case in cases for r in case.results if r.kind == "product" and r.margin is not None and r.outcome == "wrong"]
    rows: list[tuple[Cell, ...]] = [
        ("cases with a number and an estimate", str(len(held))),
        ("error above 10 × estimate + 1e-14 at some body", str(len(broken))),
        ("error above 1e-9 without a warning", str(len(silent))),
        ("estimate within 1000 × of the error", f"{tight} ({100 * tight / max(len(held), 1):.0f} %)"),
    ]
    notes = tuple(f"{case.name}: error {r.error:.1e}, estimate {r.estimate:.1e}" for case, r in broken)
    return Sheet("the promise of the error estimate", ("what", "cases"), rows, notes)


def family_sheet(family: Family, cases: list[CaseResult]) -> Sheet:
    """Part 2: one family, value by value."""
    header = (family.parameter, "variant", "rank", "error [-]", "estimate [-]", "outcome", "best other [-]", "whose")
    rows: list[tuple[Cell, ...]] = []
    for case in cases:
        own = case.results[0]
        others = [r for r in case.results if r.kind == "direct" and r.error is not None]
        best = min(others, key=lambda r: r.error or 0.0, default=None)
        rank = f"{case.rank} of {case.rows}" if case.rows else None
        rows.append(
            (
                case.label, case.variant, rank, _sci(own.error), _sci(own.estimate), own.outcome,
                _sci(best.error) if best else None, best.method if best else None,
            )
        )  # fmt: skip
    notes = tuple(dict.fromkeys(f"{case.name}: {r.message}" for case in cases for r in case.results[:1] if r.message))
    return Sheet(f"{family.name}: error and estimate", header, rows, notes)


def percussion(found: list[Radius]) -> Sheet:
    """Part 2: centres and radii of percussion of bodies that hardly turn."""
    header = ("distance over length [-]", "body", "exact RoPc [m]", "error of RoPc [-]", "error of CoPc [-]", "warned")
    rows: list[tuple[Cell, ...]] = [
        (
            r.label, r.body, f"{r.exact:.4g}", "translates" if r.ropc is None else _sci(r.ropc),
            "translates" if r.copc is None else _sci(r.copc), "yes" if r.warned else "no",
        )
        for r in found
    ]  # fmt: skip
    notes = ("translates: no radius and no centre are told, because the body turns by no more than rounding in a file makes",)
    return Sheet("centre and radius of percussion", header, rows, notes)


def savings(found: list[Saving]) -> Sheet:
    """Part 3: needed parts against all parts."""
    rows: list[tuple[Cell, ...]] = [
        (one.scene, one.parts, f"{1e3 * one.start:.0f}", f"{1e3 * one.work:.1f}", f"{one.memory:.0f}") for one in found
    ]
    return Sheet("what leaving out saves", ("scene", "parts", "robot and imports [ms]", "analysis [ms]", "memory [MB]"), rows)


def throughput(found: list[PeerResult]) -> Sheet:
    """Part 4: all peers on all works."""
    header = ("work", "peer", "postures", "apart [-]", "per posture [µs]", "quartiles [µs]", "times the product", "remark")
    product = {r.work: r.timing.median for r in found if r.peer.startswith("shockpc") and r.timing}
    rows: list[tuple[Cell, ...]] = []
    for r in found:
        clock: tuple[Cell, Cell, Cell] = (None, None, None)
        if r.timing:
            low, median, high = (f"{1e6 * value:.1f}" for value in (r.timing.low, r.timing.median, r.timing.high))
            clock = (median, f"{low}–{high}", f"{r.timing.median / product[r.work]:.2f}")
        rows.append((r.work, r.peer, str(r.postures), _sci(r.apart), *clock, r.message or None))
    return Sheet("many postures against peers", header, rows)


def everything(cases: list[CaseResult]) -> Sheet:
    """Every case by every method, for a spreadsheet."""
    header = (
        "family", "variant", "value", "label", "answer", "rank", "rows", "method", "kind", "outcome", "error", "whole", "estimate",
        "margin", "median_s", "low_s", "high_s", "runs", "message",
    )  # fmt: skip
    rows: list[tuple[Cell, ...]] = []
    for case in cases:
        for r in case.results:
            clock = (None, None, None, None) if r.timing is None else (*r.timing[:3], float(r.timing.runs))
            rows.append(
                (
                    case.family, case.variant, case.value, case.label, str(case.answer), float(case.rank), float(case.rows),
                    r.method, r.kind, r.outcome, r.error, r.whole, r.estimate, r.margin, *clock, r.message,
                )
            )  # fmt: skip
    return Sheet("every case by every method", header, rows)
