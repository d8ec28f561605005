"""What each stage of a run cost, and what the scene did not need: the contents of `--explain`."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["Trace"]


class Trace:
    """Collects the stages of one run.

    Attributes:
        stages: (name, seconds) in the order in which they ended.
        left_out: (what, why) that the scene did not need.
    """

    def __init__(self) -> None:
        self.stages: list[tuple[str, float]] = []
        self.left_out: list[tuple[str, str]] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside."""
        start = time.perf_counter()
        yield
        self.stages.append((name, time.perf_counter() - start))

    def skip(self, what: str, why: str) -> None:
        """Note a part that was not computed."""
        self.left_out.append((what, why))

    def text(self) -> str:
        """The trace as lines: stages with the time of all their runs, then what was left out and why."""
        total: dict[str, float] = {}
        for name, seconds in self.stages:
            total[name] = total.get(name, 0.0) + seconds
        lines = [f"  {1e3 * seconds:8.2f} ms  {name}" for name, seconds in total.items()]
        lines += [f"  left out     {what}: {why}" for what, why in dict.fromkeys(self.left_out)]
        return "what this run did:\n" + "\n".join(lines) + "\n"
