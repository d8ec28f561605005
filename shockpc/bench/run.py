"""The whole bench: cases, what leaving out saves, peers, report. Every finished part is kept, so that a run can be broken off."""

import os
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from shockpc.bench.cases import Case, family, suite
from shockpc.bench.cases.contacts import THROUGH_COM
from shockpc.bench.cases.robots import FOOTED
from shockpc.bench.header import header
from shockpc.bench.measure import CaseResult, measure
from shockpc.bench.methods import DIRECT, Method
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.bench.percussion import Radius, radii
from shockpc.bench.report import Bench, write_report
from shockpc.bench.saving import SCENES, Saving, measure_saving
from shockpc.bench.simulate import SIMULATED
from shockpc.bench.store import Store, fingerprint
from shockpc.bench.throughput import WORK, PeerResult, Work, compete
from shockpc.bench.timing import Timing

__all__ = ["Plan", "plan_of", "run_bench"]


class Plan(NamedTuple):
    """What is to be measured.

    Attributes:
        name: of the suite.
        cases: by every direct method.
        work: cases of part 1, by simulation besides.
        scenes: of part 3.
        peers: works of part 4, with how many postures.
        budget: time to spend on each clock [s].
    """

    name: str
    cases: tuple[Case, ...]
    work: tuple[Case, ...]
    scenes: tuple[str, ...]
    peers: tuple[tuple[Work, int], ...]
    budget: float


def plan_of(name: str) -> Plan:
    """The suite "quick", within two minutes, or "full"."""
    quick = name == "quick"
    # Two real robots, and one each of what breaks methods: repeated rows, masses far apart, a long chain.
    work = (
        family("robots").case("one foot", FOOTED.index("anymal_b")),
        family("robots").case("all feet", FOOTED.index("talos")),
        family("corners").case("sticking", 4),
        family("mass ratio").case("struck heavy, rooted light", 1e8),
        family("links").case("struck at the end", 50),
    )
    peers = tuple((one, one.quick if quick else one.full) for one in WORK)
    return Plan(name, tuple(suite(name)), work, tuple(SCENES), peers, 0.02 if quick else 0.2)


def run_bench(plan: Plan, folder: Path, command: str) -> Bench:
    """Measure and write the report into a folder; parts that an earlier run of the same plan left there are taken over.

    Raises:
        OutputError: the folder cannot be written.
    """
    settings = f"{plan.name} {plan.budget} {os.environ.get('OMP_NUM_THREADS')}"
    store = Store(folder / "parts", fingerprint(settings))
    steps = len(plan.cases) + len(plan.work) + len(plan.scenes) + len(plan.peers) + 1
    done = 0

    def part(name: str, make: Callable[[], Any]) -> Any:
        """A part as plain tables: kept from before, or made and kept."""
        nonlocal done
        done += 1
        _say(f"[{done}/{steps}] {name}")
        found = store.get(name)
        if found is None:
            found = make()
            store.put(name, found)
        return found

    def solved(kind: str, case: Case, methods: tuple[Method, ...]) -> CaseResult:
        return CaseResult.from_table(part(f"{kind} {case.name}", lambda: measure(case, methods, plan.budget).table()))

    cases = [solved("case", case, DIRECT) for case in plan.cases]
    work = [solved("work", case, (*DIRECT, *SIMULATED, *MUJOCO)) for case in plan.work]
    struck = [case for case in plan.cases if case.family == THROUGH_COM.name]
    rows = part("percussion", lambda: [asdict(one) for case in struck for one in radii(case)])
    percussion = [Radius(**row) for row in rows]
    savings, peers = [], []
    for scene in plan.scenes:
        savings += [Saving(**row) for row in part(f"saving {scene}", lambda scene=scene: _saving(scene))]  # type: ignore[misc]
    for one, n in plan.peers:
        rows = part(f"peers {one.name}", lambda one=one, n=n: _peers(one, n, 20.0 * plan.budget))  # type: ignore[misc]
        peers += [PeerResult(**(row | {"timing": row["timing"] and Timing(**row["timing"])})) for row in rows]
    _say("")
    bench = Bench(header(command, plan.name), cases, work, savings, peers, percussion)
    write_report(bench, folder)
    return bench


def _saving(scene: str) -> list[dict[str, Any]]:
    """Part 3 as plain tables."""
    return [asdict(one) for one in measure_saving(scene)]


def _peers(work: Work, n: int, budget: float) -> list[dict[str, Any]]:
    """Part 4 as plain tables."""
    return [asdict(one) | {"timing": one.timing and one.timing._asdict()} for one in compete(work, n, budget)]


def _say(text: str) -> None:
    """Progress, on a terminal only: one line that replaces the last."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\x1b[K{text[:100]}")
        sys.stderr.flush()
