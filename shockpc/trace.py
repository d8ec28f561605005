"""What ran, how long each stage took, and what the scene did not need: the contents of `--explain`."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["Trace"]


class Trace:
    """Collects the stages of one run.

    Attributes:
        stages: (name, seconds) in the order in which they ended.
        skipped: (what, why) that was not computed.
    """

    def __init__(self) -> None:
        self.stages: list[tuple[str, float]] = []
        self.skipped: list[tuple[str, str]] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside."""
        start = time.perf_counter()
        yield
        self.stages.append((name, time.perf_counter() - start))

    def skip(self, what: str, why: str) -> None:
        """Note a part that was not computed."""
        self.skipped.append((what, why))

    def text(self) -> str:
        """The trace as lines: each stage with the time of all its runs, their sum, then what did not run and why."""
        times: dict[str, float] = {}
        for name, seconds in self.stages:
            times[name] = times.get(name, 0.0) + seconds
        lines = [f"  {1e3 * seconds:8.2f} ms  {name}" for name, seconds in [*times.items(), ("in all", sum(times.values()))]]
        skipped = [f"  {what}: {why}" for what, why in dict.fromkeys(self.skipped)]
        return "\n".join(["what ran", *lines, *(["what did not run", *skipped] if skipped else [])]) + "\n"
