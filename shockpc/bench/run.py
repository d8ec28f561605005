"""The whole bench: every case of a suite, then what leaving out saves, then the peers; finished parts are kept as they come."""

import os
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TypeVar

from shockpc.bench.cases import Case, family, suite
from shockpc.bench.cases.robots import FOOTED
from shockpc.bench.header import header
from shockpc.bench.measure import CaseResult, measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.bench.report import Bench, write_report
from shockpc.bench.saving import SCENES, Saving, measure_saving
from shockpc.bench.simulate import SIMULATED
from shockpc.bench.store import Store, fingerprint
from shockpc.bench.throughput import WORK, PeerResult, compete
from shockpc.bench.timing import Timing

__all__ = ["run_bench", "work_cases"]

T = TypeVar("T")

BUDGET = {"quick": 0.02, "full": 0.2}
"""Time to spend on each clock [s]."""


def work_cases() -> list[Case]:
    """The cases of part 1: two real robots, and one each of what breaks methods."""
    return [
        family("robots").case("one foot", FOOTED.index("anymal_b")),
        family("robots").case("all feet", FOOTED.index("talos")),
        family("corners").case("sticking", 4),
        family("mass ratio").case("struck heavy, rooted light", 1e8),
        family("links").case("struck at the end", 50),
    ]


def run_bench(suite_name: str, folder: Path, command: str) -> Bench:
    """Measure and write the report into a folder; parts that an interrupted run left there are taken over.

    Raises:
        OutputError: the folder cannot be written.
    """
    budget = BUDGET[suite_name]
    store = Store(folder / "parts", fingerprint(f"{suite_name} {os.environ.get('OMP_NUM_THREADS')}"))
    cases, work = list(suite(suite_name)), work_cases()
    steps = len(cases) + len(work) + len(SCENES) + len(WORK)
    done = 0

    def kept(name: str, make: Callable[[], T], to: Callable[[T], object], back: Callable[[object], T]) -> T:
        nonlocal done
        done += 1
        _say(f"[{done}/{steps}] {name}")
        found = store.get(name)
        if found is not None:
            return back(found)
        made = make()
        store.put(name, to(made))
        return made

    def case_of(case: Case, part: str, methods: tuple[object, ...]) -> CaseResult:
        return kept(
            f"{part} {case.name}",
            lambda: measure(case, methods, budget),  # type: ignore[arg-type]
            lambda made: made.table(),
            lambda table: CaseResult.from_table(table),  # type: ignore[arg-type]
        )

    found = [case_of(case, "case", DIRECT) for case in cases]
    worked = [case_of(case, "work", (*DIRECT, *SIMULATED, *MUJOCO)) for case in work]
    saved: list[Saving] = []
    for scene in SCENES:
        saved += kept(
            f"saving {scene}",
            lambda scene=scene: measure_saving(scene),  # type: ignore[misc]
            lambda made: [asdict(one) for one in made],
            lambda table: [Saving(**one) for one in table],  # type: ignore[attr-defined]
        )
    peers: list[PeerResult] = []
    for one in WORK:
        n = one.quick if suite_name == "quick" else one.full
        peers += kept(
            f"throughput {one.name}",
            lambda one=one, n=n: compete(one, n, 20.0 * budget),  # type: ignore[misc]
            lambda made: [asdict(r) | {"timing": r.timing and r.timing._asdict()} for r in made],
            lambda table: [PeerResult(**(r | {"timing": r["timing"] and Timing(**r["timing"])})) for r in table],  # type: ignore[attr-defined]
        )
    _say("")
    bench = Bench(header(command, suite_name), found, worked, saved, peers)
    write_report(bench, folder)
    return bench


def _say(text: str) -> None:
    """Progress, on a terminal only: one line that replaces the last."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\x1b[K{text[:100]}")
        sys.stderr.flush()
