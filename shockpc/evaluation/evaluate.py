"""The engine: many landings are solved in double precision, proven where needed, and tabled."""

import functools
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from shockpc.core.threads import one_thread
from shockpc.evaluation.chunk_rows import ChunkRows
from shockpc.evaluation.column import Column
from shockpc.evaluation.executor import in_order
from shockpc.evaluation.landings import Landings
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.quantities.selection import Selection
from shockpc.text.display import brief, shown_by
from shockpc.text.printed import count

MAX_CONDITION = 1e10
"""Condition up to which double precision suffices.

It is for what is compared with measurements, or proven or compared afterwards.
"""

AHEAD = 8
"""Number of chunks that other processes may compute before the first one has been read.

It limits the memory.
"""


L = TypeVar("L", bound=Landings)


@dataclass(frozen=True, eq=False)
class Evaluation(Generic[L]):
    """Landings, and what is computed of them.

    Attributes:
        landings: the source of the rows.
        computed: the columns.
        prove: number of rows that are compared with a proof, besides those that need one.
        feasible: whether rows that flat ground does not allow, tilted a little or not, are left
            out. Those without a result are not.
        max_condition: condition up to which rows keep the numbers of double precision also where
            contacts or loops are redundant, or the quantity is otherwise proven in one posture at a
            time; None where all of these need a proof.
        elsewhere: what the study computes of these landings besides the columns.

    Raises:
        StudyError: the landings have a friction or a contact stiffness on which nothing depends
            that is computed.
    """

    landings: L
    computed: tuple[Column, ...] = field(default=(), repr=False)
    prove: int = 100
    feasible: bool = False
    max_condition: float | None = None
    elsewhere: tuple[Selection, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        scene = self.landings.base_scene
        if scene is not None:
            selections = [column.selection for column in self.computed]
            refuse_unused_ground(scene, (*selections, *self.elsewhere))

    _repr_html_ = shown_by("show.report:evaluation_report")

    def __repr__(self) -> str:
        names = [column.name for column in self.computed]
        rows = count(self.landings.rows, "row")
        return brief(self, rows, ", ".join([*self.landings.headings, *names][:8]))

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "table"}

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, without the message."""
        names = [column.name for column in self.computed]
        numbers = (*names, *self.landings.extra_headings, "condition", "proven", "double_error")
        row = ("row",) if self.feasible else ()
        return (*row, *self.landings.headings, *numbers)

    @property
    def description(self) -> dict[str, Any]:
        """The inputs on which the rows depend, besides scene and robot."""
        return {
            **self.landings.description,
            "feasible": self.feasible,
            "prove": self.prove,
        }

    def __iter__(self) -> Iterator[Table]:
        return self.tables()

    def chunk(self, k: int) -> Table:
        """Compute a chunk."""
        return self.compute(k, self.landings.data(k))

    @functools.cached_property
    def table(self) -> Table:
        """All rows, which are computed once, in this process; `computed_table` takes others."""
        return self.computed_table()

    def computed_table(
        self, executor: Executor | None = None, done: Callable[..., object] = lambda parts: None
    ) -> Table:
        """All rows, computed anew.

        Args:
            executor: computes them; this process by default.
            done: is called with the number of rows of each chunk that is done.
        """
        tables = []
        for table in self.tables(executor):
            tables.append(table)
            done(parts=len(table))
        return Table.joined(tables)

    def tables(self, executor: Executor | None = None) -> Iterator[Table]:
        """The tables of all chunks in order.

        Args: executor, computes them, as a `ProcessPoolExecutor`; this process by default.
        """
        return self.each(range(len(self.landings.chunks)), Table, executor)

    def each(
        self, chunks: "range | list[int]", make: Callable[..., Any], executor: Executor | None
    ) -> Iterator[Any]:
        """The results of `make` for some chunks, in order.

        Args:
            chunks: numbers of the chunks.
            make: is given the evaluation and the table of a chunk, and its number; `Table` for the
                tables themselves.
            executor: computes the chunks; this process by default. Only the rows of a chunk are
                sent with it.
        """
        parts = ((k, self.landings.data(k)) for k in chunks)
        if executor is None:
            return (self._made(make, k, data) for k, data in parts)
        task = functools.partial(_computed, pickle.dumps(self), make)
        return in_order(executor, task, parts, ahead=AHEAD)

    def _made(self, make: Callable[..., Any], k: int, data: Any) -> Any:
        table = self.compute(k, data)
        return table if make is Table else make(self, table, k)

    def compute(self, k: int, data: Any) -> Table:
        """Compute a chunk. Args: data, what it needs of the source's rows."""
        with one_thread(self.landings.robot.model.nv):
            chunk = self.landings.chunk(k, data)
            rows = ChunkRows(self.landings, self.computed, k)
            for group in chunk.groups:
                rows.solve(group, self.max_condition)
            # A row that needs a proof counts as allowed by the ground, whatever the proof says.
            allowed = rows.ground_allows()
            compared = rows.within(self.landings.compared(self.prove))
            if self.feasible:
                compared = compared[allowed[compared]]
            rows.prove(chunk, compared)
            left_out = ~allowed if self.feasible else None
            return rows.table(chunk.labels, rows.refused(~allowed), self.headings, left_out)


def _computed(pickled: bytes, make: Callable[..., Any], chunk: tuple[int, Any]) -> Any:
    """The result of `make` for a chunk, in whatever process this is."""
    return _unpickled(pickled)._made(make, *chunk)


@functools.lru_cache(maxsize=2)
def _unpickled(pickled: bytes) -> Evaluation[Any]:
    """An evaluation that was sent to this process; the last two are kept for their next chunks."""
    evaluation: Evaluation[Any] = pickle.loads(pickled)
    return evaluation
