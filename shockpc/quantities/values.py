"""The values of quantities of one landing, each computed when it is first read."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, get_args

import numpy as np

from shockpc.core.frozen import frozen
from shockpc.core.impulse import RowSpace
from shockpc.core.spatial import Array, read_only
from shockpc.core.threads import one_thread
from shockpc.impact.companions import Companions, Other
from shockpc.impact.landed import LandingProof
from shockpc.landing.landing import OfLanding, PosedLanding
from shockpc.landing.places import Place, PlaceKind
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.selection import Selection, quantity
from shockpc.quantities.trust import Health, Judge
from shockpc.text.errors import UnknownName
from shockpc.text.trace import Trace


@frozen()
class LandingValues(OfLanding):
    """The values of quantities of one landing, in doubles.

    Attributes: those of `ShockProfile`.
    """

    landing: PosedLanding
    double_jumps: Array
    proof: LandingProof
    companions: Companions
    trace: Trace
    judge: Judge

    def places(self, kind: PlaceKind) -> tuple[Place, ...]:
        """The places of one kind, as those of the landing.

        Raises:
            UnknownName: there is no such kind.
        """
        kinds = get_args(PlaceKind)
        if kind not in kinds:
            raise UnknownName("kind of place", str(kind), kinds, "", "")
        return self.landing.places(kind)

    def value(self, key: str, kind: PlaceKind, places: Sequence[Place] | None = None) -> Array:
        """The values (n,) or (n, 3) of a quantity at some places, NaN where there is none.

        A point that is fixed to the world does not move.

        Args:
            key: of the quantity; `shockpc quantities` lists all.
            kind: of its places.
            places: where; by default all places of its kind.

        Raises:
            UnknownName: there is no such quantity.
        """
        return self._values(quantity(kind, key), places)

    def _values(self, wanted: Quantity, places: Sequence[Place] | None) -> Array:
        """The values of a quantity, which may be one that the table does not list."""
        known_by = None
        if places is not None:
            known_by = tuple((p.name, p.body, p.number, *p.r.tolist()) for p in places)
        request = wanted.of, wanted.key, known_by
        if request not in self._cache:
            at = self.places(wanted.of) if places is None else places
            self._cache[request] = read_only(self._computed(wanted, at))
        return self._cache[request]

    def numbers(self, selection: Selection, places: Sequence[Place]) -> Array:
        """The numbers (n,) by which places are compared: of a vector a component, or the length.

        They are NaN where there is none, or redundant rows leave it undetermined.
        """
        wanted = selection.quantity
        numbers = selection.scalar(self._values(wanted, places))
        if wanted.scope.shared and self.redundant:
            return np.full(len(places), np.nan)
        return np.asarray(numbers)

    def proof_with(self, name: Other) -> LandingProof | None:
        """The proof of the same landing with other joints.

        Args:
            name: "free" or "locked" joints, or "springs_free" with all others locked.

        Returns: None where that has no verdict, or the landing no springs.
        """
        return self.companions.proof(name)

    @property
    def unsolved_joints(self) -> Mapping[str, str]:
        """The reasons why there is no solution with other joints, by name as in `proof_with`."""
        return self.companions.refused

    @property
    def row_space(self) -> RowSpace:
        """The rows that are independent."""
        return self.proof.row_space

    @property
    def redundant(self) -> bool:
        """True where contact or closure rows depend on one another.

        Their impulses are then one solution of many.
        """
        return len(self.row_space.rows) < len(self.proof.impulse)

    @cached_property
    def health(self) -> Health:
        """Errors of the numbers, with the warnings."""
        with one_thread(self.robot.model.nv), self.trace.stage("accuracy and warnings"):
            return self.judge.health(self)

    @cached_property
    def _cache(self) -> dict[Any, Array]:
        return {}

    def _computed(self, wanted: Quantity, places: Sequence[Place]) -> Array:
        """The values of a quantity at places, of which points may be fixed to the world."""
        held = [wanted.of == "point" and place.body < 0 for place in places]
        moving = [place for place, is_held in zip(places, held, strict=True) if not is_held]
        shape = (len(places), 3) if wanted.vector else (len(places),)
        values = np.full(shape, np.nan)
        with self.trace.stage(wanted.title):
            if any(held) and not wanted.scope.lacks(self.landing):
                for k in np.flatnonzero(held).tolist():
                    values[k] = wanted.scope.fixed(places[k])
            if moving:
                values[np.logical_not(held)] = self._of_moving(wanted, moving)
        return values

    def _of_moving(self, wanted: Quantity, places: list[Place]) -> Any:
        """The values of a quantity at places that move; NaN where a companion has no verdict."""
        on = wanted.computation.on
        if on == "health":
            return wanted.compute(self.health, places)
        proof = self.proof if on == "scene" else self.proof_with(on)
        if proof is None:
            return np.nan
        return proof.read(wanted.compute, places, size=wanted.size)[0, 0]
