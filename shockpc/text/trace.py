"""The stages of a run: the time of each, and what the scene did not need; for `--explain`."""

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Trace:
    """Collects the stages of one run.

    Attributes:
        seconds: of each stage by its name, without the stages inside it.
        left_out: what the scene did not need, with the reason.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.left_out: dict[str, str] = {}
        self._inside = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside."""
        start, before = time.perf_counter(), self._inside
        self._inside = 0.0
        try:
            yield
        finally:
            taken = time.perf_counter() - start
            self.seconds[name] = self.seconds.get(name, 0.0) + taken - self._inside
            self._inside = before + taken

    def skip(self, part: str, why: str) -> None:
        """Note a part that was not computed."""
        self.left_out[part] = why

    def text(self) -> str:
        """Each stage with its time, their sum, then what did not run and why; a line each."""
        times = [*self.seconds.items(), ("in all", sum(self.seconds.values()))]
        lines = ["what ran", *(f"  {1e3 * seconds:8.2f} ms  {name}" for name, seconds in times)]
        if self.left_out:
            lines.append("what did not run")
            lines += [f"  {part}: {why}" for part, why in self.left_out.items()]
        return "\n".join(lines) + "\n"
