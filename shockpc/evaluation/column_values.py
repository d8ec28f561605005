"""The numbers of columns: of many landings in double precision, or of one with a proof."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.spatial import Array, in_body_axes
from shockpc.evaluation.column import Column
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import solved
from shockpc.impact.landing_motion import motion_of
from shockpc.landing.before_impact import separating
from shockpc.landing.end_stops import at_stops, driven_beyond, missed_stops
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.scenes.scene import Scene
from shockpc.method.dynamics import Inertias, dynamics
from shockpc.method.equation import Equation
from shockpc.profile import needs_proof
from shockpc.quantities.quantity import Quantity, quantity_values
from shockpc.quantities.selection import Selection
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.errors import ShockError, SolveError, StudyError

BLOCK = 512
"""Number of postures that are computed together.

More leave the processor's cache, and fewer cost more calls of NumPy for each.
"""


class DoubleColumns(NamedTuple):
    """Columns in double precision, of m postures with S strikes each.

    Attributes:
        values: (m, S) by the names of the columns; NaN where a number needs a proof, or redundant
            rows leave it undetermined.
        condition: (m,) of each posture.
        prove: (m, S) which rows need a proof, those too that friction may refuse or in which an end
            stop acts.
        parting: (m, S, c) which contacts do not approach the ground.
    """

    values: dict[str, Array]
    condition: Array
    prove: np.ndarray
    parting: np.ndarray


class Postures(NamedTuple):
    """Steps 1 and 2 in m postures, for whatever strikes.

    Attributes:
        landing: of which these are postures.
        Q: (m, nq) configurations.
        equation: Eq. 4.
        solution: of that.
        jumps: (m, n, 6, k) of bodies, body axes.
        bodies: which these are; None for all.
        condition: (m,) of each posture.
        prove: (m,) whether it needs a proof.
        inertias: the inertias in each posture; None where they are the landing's.
    """

    landing: PosedLanding
    Q: Array
    equation: Equation
    solution: Solution
    jumps: Array
    bodies: list[int] | None
    condition: Array
    prove: np.ndarray
    inertias: Inertias | None = None

    def impact(self, strikes: Array | None) -> DoubleImpact:
        """The impact of some strikes.

        Args: strikes (m, S, 3), velocities of the base before the impact, world axes [m/s]; None
        for the landing's (S = 1).
        """
        return DoubleImpact(
            self.landing,
            self.equation,
            self.solution,
            self.jumps,
            self.bodies,
            strikes,
            self.inertias,
        )

    def columns(
        self, strikes: Array | None, wanted: Sequence[Column], more: bool = False
    ) -> DoubleColumns:
        """The columns of an impact.

        Args:
            strikes: as for `impact`.
            wanted: the columns.
            more: as for `values_of`.
        """
        impact = self.impact(strikes)
        parting = separating(impact.approach, self.landing.contacts)
        shape = parting.shape[:2]
        values = values_of(impact, wanted, shape, more)
        # What the ground decides, or what is computed in one posture at a time, is NaN where double
        # precision does not tell it.
        decided = [
            values[column.name]
            for column in wanted
            if column.selection.quantity.decided_by_ground or column.per_landing(self.landing.scene)
        ]
        prove = self.prove[:, None] | stops_act(impact)
        if decided:
            prove = prove | np.any(np.isnan(decided), axis=0)
        return DoubleColumns(values, self.condition, np.broadcast_to(prove, shape), parting)


def postures(
    landing: PosedLanding,
    Q: Array,
    wanted: Sequence[Column],
    inertias: Inertias | None = None,
    max_condition: float | None = None,
) -> Postures:
    """Steps 1 and 2 in a few postures, in double precision.

    Args:
        landing: the landing.
        Q: (m, nq) configurations.
        wanted: what will be read of them.
        inertias: the inertias in each posture; the landing's by default.
        max_condition: as for `needs_proof`.
    """
    with_strike = landing.before.velocity.ndim > 1 or not landing.translates
    state = dynamics(landing.robot, Q, landing.joint_model, inertias)
    bodies = _bodies_of(wanted)
    equation, solution, jumps = solved(landing, state, with_strike, bodies)
    condition, prove = needs_proof(landing, equation, solution, max_condition)
    rotation = state.rotation if bodies is None else state.rotation[:, bodies]
    jumps = in_body_axes(jumps, rotation)
    return Postures(landing, Q, equation, solution, jumps, bodies, condition, prove, inertias)


def _bodies_of(wanted: Sequence[Column]) -> list[int] | None:
    """The bodies whose jumps some columns need; None for all, as joints need."""
    if any(column.selection.quantity.of == "joint" for column in wanted):
        return None
    bodies = dict.fromkeys(column.place.body for column in wanted if column.place.body >= 0)
    return list(bodies) or [0]


def columns(
    landing: PosedLanding,
    Q: Array,
    strikes: Array | None,
    wanted: Sequence[Column],
    inertias: Inertias | None = None,
    max_condition: float | None = None,
) -> DoubleColumns:
    """Every column for m postures and S strikes of each, in double precision.

    Args:
        landing: the landing.
        Q: (m, nq) configurations.
        strikes: (m, S, 3) velocities of the base before the impact, world axes [m/s]; None for the
            landing's, of which each posture has one (S = 1).
        wanted: the columns.
        inertias: the inertias in each posture; the landing's by default.
        max_condition: as for `needs_proof`; with it, quantities of one posture at a time are
            computed where double precision has them.
    """
    landing = landing.without_stops
    parts: list[DoubleColumns] = []
    ranks: list[np.ndarray] = []
    for k in range(0, len(Q), BLOCK):
        rows = slice(k, k + BLOCK)
        moving, of_rows, of_bodies = landing, strikes, inertias
        if strikes is None:
            moving = landing.motions(rows)
        else:
            of_rows = strikes[rows]
        if inertias is not None:
            of_bodies = inertias.rows(rows)
        solved_postures = postures(moving, Q[rows], wanted, of_bodies, max_condition)
        parts.append(solved_postures.columns(of_rows, wanted, more=max_condition is not None))
        ranks.append(solved_postures.solution.rank)
    values: dict[str, Array] = {}
    for name in parts[0].values:
        values[name] = np.concatenate([part.values[name] for part in parts])

    # Redundant rows leave shared impulses undetermined; a rank below the others needs a proof.
    rank = np.concatenate(ranks)
    constraint_rows = solved_postures.equation.J_c.shape[1]
    for column in wanted:
        if column.selection.quantity.scope.shared:
            values[column.name][rank < constraint_rows] = np.nan
    condition = np.concatenate([part.condition for part in parts])
    parting = np.concatenate([part.parting for part in parts])
    prove = np.concatenate([part.prove for part in parts])
    prove |= (rank < rank.max())[:, None]
    return DoubleColumns(values, condition, prove, parting)


def stops_act(impact: DoubleImpact) -> np.ndarray:
    """True (N, S) where a stop acts, or one that is to strike does not.

    A stop acts where its joint is at it and would move beyond it; a scene that leaves stops out has
    none that act. One that is to strike is missed where its joint is not at it, or does not move
    towards it.
    """
    landing = impact.landing
    robot = landing.robot
    before = landing.before.joint_rates
    striking = [constraint for constraint in landing.contacts if constraint.kind == "stop"]
    missed = missed_stops(robot, striking, impact.state.Q, before)[:, None]
    if not landing.scene.stops:
        return missed
    rates = impact.along(impact.delta_qd) + np.asarray(before)[..., None, :]
    sides = at_stops(robot, impact.state.Q, landing.joint_model)[:, None]
    return np.asarray(driven_beyond(sides, rates).any(axis=-1) | missed)


def values_of(
    impact: DoubleImpact, wanted: Sequence[Column], shape: tuple[int, ...], more: bool = False
) -> dict[str, Array]:
    """The columns (m, S) of an impact by name, each quantity evaluated once for all of its places.

    Args:
        impact: the impact.
        wanted: the columns.
        shape: m and S.
        more: whether those count that are otherwise proven in one posture at a time, where double
            precision has them.
    """
    values = {column.name: np.full(shape, np.nan) for column in wanted}
    by_quantity: dict[Quantity, list[Column]] = {}
    for column in wanted:
        if column.time is None:
            by_quantity.setdefault(column.selection.quantity, []).append(column)
    with np.errstate(invalid="ignore", divide="ignore"):
        for quantity, of_quantity in by_quantity.items():
            if _has_doubles(quantity, impact.landing.scene, more):
                values |= _values_of_quantity(impact, quantity, of_quantity, shape)
    return values


def _has_doubles(quantity: Quantity, scene: Scene, more: bool) -> bool:
    """True if many postures of a scene have values in double precision; `more` as above."""
    if not quantity.per_landing(scene):
        return True
    evaluation = quantity.computation
    return evaluation.postures == "clear" and (more or evaluation.exact == "never")


def _values_of_quantity(
    impact: DoubleImpact, quantity: Quantity, wanted: Sequence[Column], shape: tuple[int, ...]
) -> dict[str, Array]:
    """The columns (m, S) of a quantity, of those whose places the landing has."""
    places = _places_of(wanted, impact.landing)
    if not places:
        return {}
    # One of the columns of a place stands for all components of a vector there.
    index = {name: k for k, name in enumerate(places)}
    numbers = quantity_values(quantity, impact, list(places.values()))
    values: dict[str, Array] = {}
    for column in wanted:
        if column.place.name in index:
            at_place = numbers[:, :, index[column.place.name]]
            values[column.name] = np.broadcast_to(column.selection.scalar(at_place), shape)
    return values


def _places_of(wanted: Sequence[Column], landing: PosedLanding) -> dict[str, Place]:
    """The places of columns in a landing, by name; those that it does not have are left out."""
    places: dict[str, Place] = {}
    for column in wanted:
        place = column.at(landing)
        if place is not None:
            places[column.place.name] = place
    return places


def proven_columns(profile: ShockProfile, wanted: Sequence[Column]) -> dict[str, float]:
    """The columns of one landing, proven; NaN if redundant rows leave a number undetermined."""
    values = {column.name: np.nan for column in wanted}
    by_selection: dict[Selection, list[Column]] = {}
    for column in wanted:
        if column.time is None:
            by_selection.setdefault(column.selection, []).append(column)
    for selection, of_selection in by_selection.items():
        places = _places_of(of_selection, profile.landing)
        numbers = profile.numbers(selection, list(places.values())).tolist()
        by_place = dict(zip(places, numbers, strict=True))
        for column in of_selection:
            if column.place.name in by_place:
                values[column.name] = by_place[column.place.name]
    return values


def columns_at_times(landing: PosedLanding, wanted: Sequence[Column]) -> dict[str, float]:
    """The columns of one landing that lasts, at times.

    They are changes of velocity until the time.

    Raises:
        SolveError: the motion cannot be followed.
        StudyError: the scene gives no contact stiffness.
    """
    by_time: dict[float, list[Column]] = {}
    for column in wanted:
        if column.time is not None:
            by_time.setdefault(column.time, []).append(column)
    motion = motion_of(landing, max(by_time) / 1e3)
    if motion is None:
        raise StudyError(
            "a quantity at a time after the impact needs a contact stiffness; give "
            "contact_stiffness"
        )
    computed: dict[str, float] = {}
    for time in sorted(by_time):
        until = motion.impact_at(time / 1e3)
        # The motion until a time is an impact, whose columns have no time.
        of_impact = [column._replace(time=None) for column in by_time[time]]
        values = values_of(until, of_impact, (1, 1))
        for column, of_column in zip(by_time[time], of_impact, strict=True):
            computed[column.name] = float(values[of_column.name][0, 0])
    return computed


def double_difference(
    profile: ShockProfile,
    double: dict[str, float],
    exact: dict[str, float],
    wanted: Sequence[Column],
) -> float:
    """Largest error of a shock in doubles, relative to the most severe one of the point [1]."""
    largest = 0.0
    for column in wanted:
        most_severe = column.selection.quantity.relations.most_severe
        if not column.shock or most_severe is None:
            continue
        severe = float(profile.value(most_severe.key, most_severe.of, [column.place])[0])
        value = exact[column.name]
        size = max(severe, abs(value)) or 1.0
        difference = abs(double[column.name] - value) / size
        if np.isfinite(difference):
            largest = max(largest, difference)
        elif np.isfinite(value):
            # Double precision has no number where there is one.
            largest = np.inf
    return float(largest)


def not_approaching(
    landing: PosedLanding, parting: np.ndarray
) -> Iterator[tuple[int, int, ShockError]]:
    """Posture, strike and error of the landings that are no impact.

    Args: parting (m, S, c), as `columns` gives it.
    """
    for i, s, c in np.argwhere(parting).tolist():
        text = (
            f'contact "{landing.contacts[c].frame}" does not approach the ground, so there is no '
            f"impact"
        )
        yield i, s, SolveError(text, constraints=[landing.contacts[c].frame])
