"""The one engine: landings are solved in double precision, proven where that is needed, and read as
columns of a table.
"""

import functools
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from shockpc.core.threads import one_thread
from shockpc.evaluation.column import Column
from shockpc.evaluation.column_values import (
    columns,
    columns_at_times,
    double_difference,
    not_approaching,
    proven_columns,
)
from shockpc.evaluation.executor import in_order
from shockpc.evaluation.landings import Chunk, Group, Landings, Refusal
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.landing.contact import contact_name
from shockpc.landing.scene import Scene
from shockpc.profile import profile_of_scene
from shockpc.quantities.selection import Selection
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import warn
from shockpc.text.errors import DefectError, ShockError, attempt, refusal
from shockpc.text.shown import brief, counted, shown_by
from shockpc.text.trace import Trace

TRUSTED = 1e10
"""Condition up to which double precision suffices for what is compared with measurements, or proven
or compared afterwards.
"""

AHEAD = 8
"""Chunks that other processes may compute before the first one has been read, which limits the
memory.
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
        trusted: condition up to which rows keep the numbers of double precision also where contacts
            or loops are redundant, or the quantity is otherwise proven in one posture at a time;
            None where all of these need a proof.
        elsewhere: what the study computes of these landings besides the columns.

    Raises:
        StudyError: the landings have a friction or a contact stiffness on which nothing depends
            that is computed.
    """

    landings: L
    computed: tuple[Column, ...] = field(default=(), repr=False)
    prove: int = 100
    feasible: bool = False
    trusted: float | None = None
    elsewhere: tuple[Selection, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        if (scene := self.landings.base_scene) is not None:
            refuse_unused_ground(
                scene, (*(column.selection for column in self.computed), *self.elsewhere)
            )

    _repr_html_ = shown_by("show.report:evaluation_report")

    def __repr__(self) -> str:
        names = [column.name for column in self.computed]
        rows = counted(self.landings.rows, "row")
        return brief(self, rows, ", ".join([*self.landings.headings, *names][:8]))

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "table"}

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, without the message."""
        landings, names = self.landings, [column.name for column in self.computed]
        numbers = (*names, *landings.further, "condition", "proven", "double_error")
        return (*(["row"] if self.feasible else []), *landings.headings, *numbers)

    @property
    def description(self) -> dict[str, Any]:
        """What the rows depend on, besides scene and robot."""
        return {
            **self.landings.description,
            "feasible rows only": self.feasible,
            "rows proven for comparison": self.prove,
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
        """What is made of some chunks, in order and where they are computed.

        Args:
            chunks: numbers of the chunks.
            make: is given the evaluation and the table of a chunk, and its number; `Table` for the
                tables themselves.
            executor: computes the chunks; this process by default. Only the rows of a chunk are
                sent with it.
        """
        if executor is None:
            return (self._made(make, k, self.landings.data(k)) for k in chunks)
        task = functools.partial(_computed, pickle.dumps(self), make)
        return in_order(executor, task, ((k, self.landings.data(k)) for k in chunks), ahead=AHEAD)

    def _made(self, make: Callable[..., Any], k: int, data: Any) -> Any:
        table = self.compute(k, data)
        return table if make is Table else make(self, table, k)

    def compute(self, k: int, data: Any) -> Table:
        """Compute a chunk. Args: data, what it needs of the source's rows."""
        with one_thread(self.landings.robot.model.nv):
            return self._computed(k, self.landings.chunk(k, data))

    def _computed(self, k: int, chunk: Chunk) -> Table:
        """The rows of a chunk in double precision, with a proof where that is needed."""
        (a, b), S = self.landings.chunks[k], self.landings.strikes
        errors = _Errors()
        names = [column.name for column in self.computed]
        whole = {
            name: np.full((b - a, S), np.nan)
            for name in (*names, *self.landings.further, "condition")
        }
        prove = np.zeros((b - a, S), dtype=bool)
        for group in chunk.groups:
            rows = group.postures[:, None] * S + np.arange(S)
            if isinstance(group, Refusal):
                errors.note(rows.ravel().tolist(), group.error)
                continue
            with errors.of(rows.ravel()):
                self._solve(group, rows, whole, prove, errors)
        flat = {name: x.ravel() for name, x in whole.items()}
        compared = self.landings.compared(self.prove)
        compared = compared[(compared >= a * S) & (compared < b * S)] - a * S
        flags, tilts, pulls, gains = (
            [c.name for c in self.computed if c.selection.quantity.relations.role == role]
            for role in ("feasible", "tilt", "pull", "gain")
        )
        # A landing whose contacts are named stays where a small tilt makes it feasible.
        feasible = (
            np.sum([flat[name] for name in (*flags[:1], *tilts[:1])], axis=0)
            if flags
            else np.ones(len(prove) * S)
        )
        if self.feasible:
            compared = compared[feasible[compared] != 0.0]
        proven, difference = self._prove(chunk, prove.ravel(), compared, flat, errors)
        infeasible = feasible == 0.0
        pulled = infeasible & np.any(
            [flat[name] > 0.0 for name in pulls if not self.landings.opens], axis=0
        )
        gained = infeasible & ~pulled & np.any([flat[name] > 0.0 for name in gains], axis=0)
        refused = int(pulled.sum()), int(gained.sum()), int((infeasible & ~pulled & ~gained).sum())
        results = {**chunk.labels, **flat, "proven": proven, "double_error": difference}
        if self.feasible:
            chosen = np.flatnonzero(~infeasible)
            results = {"row": a * S + chosen} | {name: x[chosen] for name, x in results.items()}
            errors.messages = {
                int(np.searchsorted(chosen, i)): text for i, text in errors.messages.items()
            }
        return self._table(k, results, errors, refused)

    def _solve(
        self,
        group: Group,
        rows: np.ndarray,
        whole: dict[str, Any],
        prove: np.ndarray,
        errors: "_Errors",
    ) -> None:
        """Fill in the columns (n, S) of a group, and which rows (n, S) need a proof."""
        landing = group.landing
        values, condition, unsafe, parting = columns(
            landing, group.Q, group.strikes, self.computed, group.inertias, self.trusted
        )
        further = {name: x[:, None] for name, x in group.further.items()}
        for name, x in (values | further | {"condition": condition[:, None]}).items():
            whole[name][group.postures] = x
        prove[group.postures] = unsafe
        for i, s, error in not_approaching(landing, parting):
            errors.note([int(rows[i, s])], error)

    def _prove(
        self,
        chunk: Chunk,
        needed: np.ndarray,
        compared: np.ndarray,
        values: dict[str, np.ndarray],
        errors: "_Errors",
    ) -> tuple[np.ndarray, np.ndarray]:
        """Prove the rows (n,) that need it, whose numbers become the proven ones, and compare
        others with a proof.

        Returns: which rows (n,) have proven numbers; and the difference (n,) of double precision,
        as `double_difference`.
        """
        proven, difference = np.zeros(len(needed), dtype=bool), np.full(len(needed), np.nan)
        impulsive = [column for column in self.computed if column.time is None]
        for i in sorted(
            {*np.flatnonzero(needed).tolist(), *compared.tolist()} - errors.messages.keys()
        ):
            with errors.of([i]):
                for name, value in self._later(chunk, i).items():
                    values[name][i] = value
                if self.computed and not impulsive:
                    continue
                profile = chunk.profile(i)
                exact = proven_columns(profile, impulsive)
                difference[i] = double_difference(
                    profile, {name: float(values[name][i]) for name in exact}, exact, self.computed
                )
                if needed[i]:
                    proven[i] = True
                    for name, value in exact.items():
                        values[name][i] = value
        for column in self.computed if errors.messages else ():
            values[column.name][list(errors.messages)] = np.nan
        return proven, difference

    def _later(self, chunk: Chunk, i: int) -> dict[str, float]:
        """The columns at times of a row, which need no proof."""
        if all(column.time is None for column in self.computed):
            return {}
        return columns_at_times(
            chunk.profile(i).landing if chunk.landing is None else chunk.landing(i), self.computed
        )

    def _table(
        self, k: int, results: dict[str, Any], errors: "_Errors", refused: tuple[int, int, int]
    ) -> Table:
        columns = {name: results[name] for name in self.headings if name in results}
        messages = dict(sorted(errors.messages.items()))
        first = self.landings.chunks[k][0] * self.landings.strikes
        common, scene = {"robot": self.landings.robot.label}, self.landings.base_scene
        common |= (
            {"contact": contact_name(scene)}
            if scene is not None and "contact" not in columns
            else {}
        )
        return Table(
            self.computed,
            columns,
            messages,
            refused,
            tuple(errors.defects),
            first=first,
            common=common,
        )


class _Errors:
    """Why rows could not be computed, as a context in which some of them are."""

    def __init__(self) -> None:
        self._rows: Sequence[int] | np.ndarray = ()
        self.messages, self.defects = dict[int, str](), list[str]()

    def of(self, rows: Sequence[int] | np.ndarray) -> "_Errors":
        """The context of some rows."""
        self._rows = rows
        return self

    def note(self, rows: list[int], error: ShockError) -> None:
        """Note the error of some rows, of which those keep theirs that have one."""
        for i in rows:
            self.messages.setdefault(i, str(error))
        if isinstance(error, DefectError):
            self.defects.append(error.trace)

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> bool:
        if isinstance(error, Exception):
            self.note(np.asarray(self._rows).tolist(), refusal(error))
            return True
        return False


def _computed(pickled: bytes, make: Callable[..., Any], chunk: tuple[int, Any]) -> Any:
    """What is made of a chunk, in whatever process this is."""
    return _unpickled(pickled)._made(make, *chunk)


@functools.lru_cache(maxsize=2)
def _unpickled(pickled: bytes) -> Evaluation[Any]:
    """An evaluation that was sent to this process, with a separate robot; the last two are kept for
    their next chunks.
    """
    evaluation: Evaluation[Any] = pickle.loads(pickled)
    return evaluation


def proven(
    cases: Mapping[str, tuple[Scene, Robot]],
    selections: Sequence[Selection] | None,
    trace: Trace | None = None,
    done: Callable[[str], object] = str,
) -> dict[str, ShockProfile | ShockError]:
    """Landings one by one, each with its proof: the profiles by name, or why there is none.

    Their warnings are Python warnings.

    Args:
        cases: scene and robot of each landing, by name.
        selections: what is read of the profiles; None where they are read as a whole, or columns of
            the same landings follow.
        trace: collects what each stage cost.
        done: is called with the name of each landing that is computed.

    Raises:
        StudyError: a landing has a friction or a contact stiffness on which none of the selections
            depends.
    """
    for scene, _ in cases.values() if selections is not None else ():
        refuse_unused_ground(scene, selections or ())
    results = dict[str, ShockProfile | ShockError]()
    for name, (scene, robot) in cases.items():
        results[name] = attempt(profile_of_scene, scene, robot, trace)
        done(name)
    warn(
        lambda: (
            one
            for profile in results.values()
            if isinstance(profile, ShockProfile)
            for one in profile.health.warnings
        )
    )
    return results


def profiles(
    cases: Mapping[str, tuple[Scene, Robot]], trace: Trace | None = None
) -> dict[str, ShockProfile]:
    """Like `proven`, for landings that a study reads as a whole, but raises if one of them cannot
    be computed.

    Raises:
        ShockError: the first of these.
    """
    results = proven(cases, None, trace)
    for result in results.values():
        if isinstance(result, ShockError):
            raise result
    return {name: result for name, result in results.items() if isinstance(result, ShockProfile)}
