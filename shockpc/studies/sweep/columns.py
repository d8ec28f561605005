"""The columns of a sweep: quantities at places, computed of many landings in double precision, or of one with a proof."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.bodies import in_body_axes
from shockpc.core.spatial import Array
from shockpc.impact import DoubleImpact
from shockpc.landing import PosedLanding
from shockpc.model.dynamics import dynamics
from shockpc.places import Place
from shockpc.profile import impact_jumps, needs_proof
from shockpc.quantities.quantity import evaluate
from shockpc.quantities.table import Selection, quantity
from shockpc.result import ShockProfile

__all__ = ["Column", "columns", "double_difference", "proven_columns"]

SHOCKS = {"shock": "most_severe", "shock_com": "most_severe", "shock_max": "most_severe"}
"""Quantities by which the error of double precision is measured, and the shock that it is relative to."""

BLOCK = 256
"""Postures that are computed together, so that their arrays stay in the processor's cache."""


class Column(NamedTuple):
    """A column of numbers: a selected quantity at a place.

    Attributes:
        selection: the quantity.
        place: where.
        asked: whether it was asked for by name, so that the summary and the figure show it.
    """

    selection: Selection
    place: Place
    asked: bool = False

    @property
    def name(self) -> str:
        """As the table of rows heads it, QUANTITY@PLACE."""
        return f"{self.selection.name}@{self.place.name}"

    @property
    def title(self) -> str:
        """The name with its unit."""
        return f"{self.name} [{self.selection.quantity.unit.replace('1', '-')}]"

    @property
    def shock(self) -> bool:
        """Whether it is a shock of the row's own strike."""
        return self.selection.quantity.key in SHOCKS


def columns(
    landing: PosedLanding, Q: Array, strikes: Array, wanted: Sequence[Column]
) -> tuple[dict[str, Array], Array, np.ndarray, np.ndarray]:
    """Every column for m postures and S strikes of each, in double precision; NaN where a proof is needed.

    Args:
        landing: the landing.
        Q: (m, nq) configurations.
        strikes: (m, S, 3) velocities of the base before the impact, world axes [m/s].
        wanted: the columns.

    Returns: columns (m, S) by name; the condition (m,) of each posture, and whether (m,) it needs a proof; and which contacts
        (m, S, c) do not approach the ground.
    """
    blocks = [_block(landing, Q[k : k + BLOCK], strikes[k : k + BLOCK], wanted) for k in range(0, len(Q), BLOCK)]
    computed = {name: np.concatenate([block[0][name] for block in blocks]) for name in blocks[0][0]}
    condition, prove, parting = (np.concatenate(parts) for parts in list(zip(*blocks, strict=True))[1:])
    return computed, condition, prove, parting


def _block(
    landing: PosedLanding, Q: Array, strikes: Array, wanted: Sequence[Column]
) -> tuple[dict[str, Array], Array, np.ndarray, np.ndarray]:
    """The same for a few postures."""
    own = bool(landing.before.omega.any() or landing.before.joint_rates.any())
    state = dynamics(landing.robot, Q, landing.joint_model.armature)
    kinds = {column.selection.quantity.of for column in wanted}
    carriers = None if kinds & {"joint", "robot"} else list(dict.fromkeys(c.place.body for c in wanted if c.place.body >= 0))
    equation, solution, jumps = impact_jumps(landing, state, own, carriers)
    condition, prove = needs_proof(landing, equation, solution)
    jumps = in_body_axes(jumps, state.rotation if carriers is None else state.rotation[:, carriers])
    impact = DoubleImpact(landing, equation, solution, jumps, carriers, strikes)
    parting = impact.approach @ landing.up >= -1e-9 * np.linalg.norm(impact.approach, axis=-1)
    return _selected(impact, wanted, strikes.shape[:2]), condition, prove, parting


def _selected(impact: DoubleImpact, wanted: Sequence[Column], shape: tuple[int, ...]) -> dict[str, Array]:
    """The columns (m, S) by name, each quantity evaluated once for all of its places."""
    computed: dict[str, Array] = {}
    with np.errstate(invalid="ignore", divide="ignore"):
        for entry in dict.fromkeys(column.selection.quantity for column in wanted):
            own = [column for column in wanted if column.selection.quantity is entry]
            places = list({column.place.name: column.place for column in own}.values())
            if entry.posed or entry.compute is None:
                computed |= {column.name: np.full(shape, np.nan) for column in own}
                continue
            values, index = evaluate(entry, impact, places), {place.name: k for k, place in enumerate(places)}
            for column in own:
                computed[column.name] = np.broadcast_to(column.selection.scalar(values[:, :, index[column.place.name]]), shape)
    return computed


def proven_columns(profile: ShockProfile, wanted: Sequence[Column]) -> dict[str, float]:
    """The same columns of one landing, proven; NaN where redundant rows leave a number undetermined."""
    unique = len(profile.choice.rows) == len(profile.proof.impulse)

    def value(column: Column) -> float:
        entry = column.selection.quantity
        known = unique or not entry.shared
        return float(column.selection.scalar(profile.values(entry, [column.place])[0])) if known else np.nan

    return {column.name: value(column) for column in wanted}


def double_difference(profile: ShockProfile, double: dict[str, float], exact: dict[str, float], wanted: Sequence[Column]) -> float:
    """Largest difference of a shock in double precision, relative to the most severe one of the same point [1]."""
    largest = 0.0
    for column in filter(lambda column: column.shock, wanted):
        entry = quantity(column.selection.quantity.of, SHOCKS[column.selection.quantity.key])
        severe = float(profile.values(entry, [column.place])[0])
        off = abs(double[column.name] - exact[column.name]) / (max(severe, abs(exact[column.name])) or 1.0)
        largest = max(largest, off) if np.isfinite(off) else np.inf if np.isfinite(exact[column.name]) else largest
    return float(largest)
