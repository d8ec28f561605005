"""The rows of one chunk of landings: solved in double precision, proven where that is needed."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from shockpc.evaluation.column import Column
from shockpc.evaluation.column_values import (
    columns,
    columns_at_times,
    double_difference,
    not_approaching,
    proven_columns,
)
from shockpc.evaluation.landings import Chunk, Group, Landings, Refusal
from shockpc.evaluation.table import Table
from shockpc.landing.contact import contact_name
from shockpc.text.errors import DefectError, ShockError, attempt


class ChunkRows:
    """The rows of a chunk while they are computed: n = m S of m postures with S strikes each.

    Args:
        landings: the source of the rows.
        computed: the columns.
        k: number of the chunk.

    Attributes:
        first: number of the first row.
        values: (n,) by heading; NaN where there is no number.
        needs_proof: (n,) which rows need one.
        proven: (n,) which rows have proven numbers.
        double_error: (n,) difference of double precision, as `double_difference`.
        messages: why a row could not be computed, by its index.
        defects: descriptions of unexpected exceptions.
    """

    def __init__(self, landings: Landings, computed: Sequence[Column], k: int) -> None:
        self.landings = landings
        self.computed = tuple(computed)
        begin, end = landings.chunks[k]
        self.first = begin * landings.strikes
        n = (end - begin) * landings.strikes
        names = [column.name for column in computed]
        headings = (*names, *landings.extra_headings, "condition")
        self.values = {heading: np.full(n, np.nan) for heading in headings}
        self.needs_proof = np.zeros(n, dtype=bool)
        self.proven = np.zeros(n, dtype=bool)
        self.double_error = np.full(n, np.nan)
        self.messages: dict[int, str] = {}
        self.defects: list[str] = []

    def solve(self, group: Group | Refusal, max_condition: float | None) -> None:
        """Fill in the rows of a group in double precision.

        Args: max_condition, as for `columns`.
        """
        strikes = self.landings.strikes
        rows = group.postures[:, None] * strikes + np.arange(strikes)
        error = group.error if isinstance(group, Refusal) else None
        if isinstance(group, Group):
            error = attempt(self._solve, group, rows, max_condition)
        if error is not None:
            self._note(rows.ravel().tolist(), error)

    def _solve(self, group: Group, rows: np.ndarray, max_condition: float | None) -> None:
        """Fill in the rows (m, S) of a group."""
        landing = group.landing
        solved = columns(
            landing, group.Q, group.strikes, self.computed, group.inertias, max_condition
        )
        for name, values in solved.values.items():
            self.values[name][rows] = values
        for name, of_postures in group.extra_columns.items():
            self.values[name][rows] = of_postures[:, None]
        self.values["condition"][rows] = solved.condition[:, None]
        self.needs_proof[rows] = solved.prove
        for i, s, error in not_approaching(landing, solved.parting):
            self._note([int(rows[i, s])], error)

    def within(self, numbers: np.ndarray) -> np.ndarray:
        """The indices of those rows of the source that are in the chunk."""
        index = numbers - self.first
        return index[(index >= 0) & (index < len(self.needs_proof))]

    def prove(self, chunk: Chunk, compared: np.ndarray) -> None:
        """Prove the rows that need it, which then have these numbers; compare others with a proof.

        Args: compared, their indices.
        """
        rows = {*np.flatnonzero(self.needs_proof).tolist(), *compared.tolist()}
        for i in sorted(rows - self.messages.keys()):
            error = attempt(self._prove, chunk, i)
            if error is not None:
                self._note([i], error)
        failed = list(self.messages)
        for column in self.computed:
            self.values[column.name][failed] = np.nan

    def _prove(self, chunk: Chunk, i: int) -> None:
        """Prove a row."""
        impulsive = [column for column in self.computed if column.time is None]
        if len(impulsive) < len(self.computed):
            # Columns at times need no proof.
            landing = chunk.profile(i).landing if chunk.landing is None else chunk.landing(i)
            self._set(i, columns_at_times(landing, self.computed))
            if not impulsive:
                return
        profile = chunk.profile(i)
        exact = proven_columns(profile, impulsive)
        double = {name: float(self.values[name][i]) for name in exact}
        self.double_error[i] = double_difference(profile, double, exact, self.computed)
        if self.needs_proof[i]:
            self.proven[i] = True
            self._set(i, exact)

    def _set(self, i: int, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            self.values[name][i] = value

    def _note(self, rows: Iterable[int], error: ShockError) -> None:
        """Note the error of some rows; those that have one keep it."""
        for i in rows:
            self.messages.setdefault(i, str(error))
        if isinstance(error, DefectError):
            self.defects.append(error.trace)

    def _of_role(self, role: str) -> list[np.ndarray]:
        """The values of the columns with a role in what the ground allows."""
        return [
            self.values[column.name]
            for column in self.computed
            if column.selection.quantity.relations.role == role
        ]

    def ground_allows(self) -> np.ndarray:
        """True (n,) if flat ground allows a row, or that is not computed or not known."""
        flags = self._of_role("feasible")[:1]
        if not flags:
            return np.ones(len(self.needs_proof), dtype=bool)
        # A landing whose contacts are named stays where a small tilt makes it feasible.
        tilts = self._of_role("tilt")[:1]
        return np.asarray(np.sum([*flags, *tilts], axis=0) != 0.0)

    def refused(self, infeasible: np.ndarray) -> tuple[int, int, int]:
        """Numbers of infeasible rows (n,) that pull a contact, that gain energy, and of others."""
        pulled = np.zeros_like(infeasible)
        if not self.landings.opens:
            for pull in self._of_role("pull"):
                pulled |= infeasible & (pull > 0.0)
        gained = np.zeros_like(infeasible)
        for gain in self._of_role("gain"):
            gained |= infeasible & ~pulled & (gain > 0.0)
        for_height = infeasible & ~pulled & ~gained
        return int(pulled.sum()), int(gained.sum()), int(for_height.sum())

    def table(
        self,
        labels: Mapping[str, np.ndarray],
        refused: tuple[int, int, int],
        headings: Sequence[str],
        left_out: np.ndarray | None,
    ) -> Table:
        """The rows as a table.

        Args:
            labels: (n,) columns that tell the rows apart.
            refused: as for `Table`.
            headings: of the columns in order.
            left_out: (n,) which rows are left out; None without numbers of rows in the table.
        """
        results = {
            **labels,
            **self.values,
            "proven": self.proven,
            "double_error": self.double_error,
        }
        messages = self.messages
        if left_out is not None:
            kept = np.flatnonzero(~left_out)
            results = {name: values[kept] for name, values in results.items()}
            results["row"] = self.first + kept
            messages = {int(np.searchsorted(kept, i)): text for i, text in messages.items()}
        by_heading = {name: results[name] for name in headings if name in results}
        common = {"robot": self.landings.robot.label}
        scene = self.landings.base_scene
        if scene is not None and "contact" not in by_heading:
            common["contact"] = contact_name(scene)
        return Table(
            self.computed,
            by_heading,
            dict(sorted(messages.items())),
            refused,
            tuple(self.defects),
            first=self.first,
            common=common,
        )
