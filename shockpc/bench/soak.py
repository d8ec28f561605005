"""Random trees by the thousand: is the error estimate ever too small?"""

import gc
import multiprocessing.pool
import signal
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields

from shockpc.bench.cases import Case
from shockpc.bench.measure import MethodResult, measure
from shockpc.bench.methods import DIRECT
from shockpc.bench.random_trees import random_landing
from shockpc.bench.store import Store
from shockpc.health import DOUBTFUL

__all__ = ["LOOSE", "Soaked", "Tally", "soak", "soak_one", "tally_text"]

BLOCK = 50
"""Trees that are tried and kept together: a few seconds."""

LOOSE = 1000.0
"""An estimate more than so many times the error is loose; errors below rounding itself count as rounding."""


@dataclass(frozen=True)
class Soaked:
    """What came of one random tree.

    Attributes:
        number: of the tree.
        bodies: how many it has.
        result: of the product; None if the drawing made no landing.
    """

    number: int
    bodies: int
    result: MethodResult | None


@dataclass
class Tally:
    """Counts over many trees.

    Attributes:
        trees: drawn.
        none: drawings that are no landing (a loop that cannot be closed, a contact that leaves the ground).
        solved: with an answer.
        refused: with a message in words.
        broken: error above 10 × the estimate + 1e-14 at some body.
        silent: error above 1e-9 without a warning.
        failed: not a number, a library's exception, or an answer where there is none.
        loose: estimate above 1000 × the error.
        warned: estimate above 1e-10, and said so.
        offenders: numbers of the trees that broke a promise.
    """

    trees: int = 0
    none: int = 0
    solved: int = 0
    refused: int = 0
    broken: int = 0
    silent: int = 0
    failed: int = 0
    loose: int = 0
    warned: int = 0
    offenders: tuple[int, ...] = ()

    def __add__(self, other: "Tally") -> "Tally":
        """Both together."""
        return Tally(*(getattr(self, each.name) + getattr(other, each.name) for each in fields(self)))

    def add(self, one: Soaked) -> None:
        """Count one more."""
        self.trees += 1
        result = one.result
        if result is None:
            self.none += 1
            return
        if result.outcome == "refused":
            self.refused += 1
            return
        bad = 0
        if result.outcome in ("nan", "failed", "invented"):
            self.failed += 1
            bad = 1
        elif result.error is not None and result.estimate is not None and result.margin is not None:
            self.solved += 1
            self.broken += result.margin > 1.0
            self.silent += result.outcome == "wrong"
            self.loose += result.estimate > LOOSE * max(result.error, 2.0**-53)
            self.warned += result.outcome == "told" or result.estimate > DOUBTFUL
            bad = result.margin > 1.0 or result.outcome == "wrong"
        if bad:
            self.offenders = (*self.offenders, one.number)

    @property
    def violations(self) -> int:
        """Promises broken."""
        return self.broken + self.silent + self.failed


def soak(first: int, count: int, workers: int, store: Store | None = None) -> Iterator[Tally]:
    """Try trees number `first` to `first + count − 1`, in as many processes.

    Args:
        first: number of the first tree.
        count: how many trees.
        workers: processes.
        store: keeps the counts of finished blocks, so that a run that was broken off goes on from there.

    Yields: the counts of one block of trees after another, in no order.
    """
    blocks = [(begin, min(begin + BLOCK, first + count)) for begin in range(first, first + count, BLOCK)]
    kept = {block: None if store is None else store.get(_name(block)) for block in blocks}
    yield from (Tally(**(part | {"offenders": tuple(part["offenders"])})) for part in kept.values() if part is not None)
    left = [block for block, part in kept.items() if part is None]
    if workers <= 1 or len(left) <= 1:
        found = map(_soak_block, left)
        yield from (_keep(store, *each) for each in found)
        return
    pool, interrupted = _deaf_pool(min(workers, len(left))), False
    try:
        yield from (_keep(store, *each) for each in pool.imap_unordered(_soak_block, left))
    except KeyboardInterrupt:
        interrupted = True  # raised anew below: its traceback would keep the pool alive
    finally:
        pool.terminate()
        pool.join()
        del pool
        gc.collect()  # the command ends without Python's own exit, where semaphores would be given back
    if interrupted:
        raise KeyboardInterrupt


def _deaf_pool(workers: int) -> multiprocessing.pool.Pool:
    """Processes that leave Ctrl-C to this one, from their first moment on: what is ignored here they inherit."""
    heard = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        return multiprocessing.get_context("spawn").Pool(workers)
    finally:
        signal.signal(signal.SIGINT, heard)


def _soak_block(block: tuple[int, int]) -> tuple[tuple[int, int], Tally]:
    """The counts of a block of trees, and which it was."""
    tally = Tally()
    for number in range(*block):
        tally.add(soak_one(number))
    return block, tally


def _keep(store: Store | None, block: tuple[int, int], tally: Tally) -> Tally:
    """The counts, kept."""
    if store is not None:
        store.put(_name(block), asdict(tally))
    return tally


def _name(block: tuple[int, int]) -> str:
    return f"trees {block[0]} to {block[1] - 1}"


def soak_one(number: int) -> Soaked:
    """Draw a tree, let it land, and hold the product against the reference."""
    robot, scene = random_landing(number)
    case = Case("random tree", "", float(number), str(number), lambda: (robot, scene))
    found = measure(case, DIRECT[:1], budget=0.0).results[0]
    none = found.outcome == "refused" and any(
        word in found.message for word in ("cannot be closed", "no impact", "one point of one body")
    )
    return Soaked(number, len(robot.bodies), None if none else found)


def tally_text(tally: Tally) -> str:
    """The counts as lines."""
    share = 100.0 * (tally.solved - tally.loose) / max(tally.solved, 1)
    lines = [
        f"random trees                                     {tally.trees}",
        f"  drawn, but no landing                          {tally.none}",
        f"  refused in words                               {tally.refused}",
        f"  solved                                         {tally.solved}",
        f"    warned of                                    {tally.warned}",
        f"    estimate within {LOOSE:g} × of the error         {share:.1f} %",
        f"violations                                       {tally.violations}",
        f"  error above 10 × estimate + 1e-14              {tally.broken}",
        f"  error above 1e-9 without a warning             {tally.silent}",
        f"  not a number, exception, invented answer       {tally.failed}",
    ]
    if tally.offenders:
        lines.append(f"numbers of the trees: {', '.join(map(str, sorted(tally.offenders)[:20]))} (--soak 1 --seed NUMBER)")
    return "\n".join(lines) + "\n"
