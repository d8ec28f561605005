"""The numbers of columns: of many landings in double precision, or of one with a proof."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, cast

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.spatial import Array, in_body_axes
from shockpc.evaluation.column import Column
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import solved
from shockpc.impact.motion import motion_of
from shockpc.landing.end_stops import at_stops, driven_beyond, missed_stops
from shockpc.landing.landing import PosedLanding
from shockpc.landing.motion import separating
from shockpc.method.dynamics import Inertias, dynamics
from shockpc.method.equation import Equation
from shockpc.profile import needs_proof
from shockpc.quantities.quantity import Quantity, evaluate
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.errors import ShockError, SolveError, StudyError

BLOCK = 512
"""Postures that are computed together: more leave the processor's cache, and fewer cost more calls
of NumPy for each.
"""


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

    def values(
        self, strikes: Array | None, wanted: Sequence[Column], more: bool = False
    ) -> tuple[dict[str, Array], np.ndarray, np.ndarray]:
        """Every column (m, S) by name; which contacts (m, S, c) do not approach the ground; and
        where (m, S) an end stop acts.

        Args:
            strikes: (m, S, 3) velocities of the base before the impact, world axes [m/s]; None for
                the landing's (S = 1).
            wanted: the columns.
            more: as for `values_of`.
        """
        impact = DoubleImpact(
            self.landing,
            self.equation,
            self.solution,
            self.jumps,
            self.bodies,
            strikes,
            self.inertias,
        )
        parting = separating(impact.approach, self.landing.contacts)
        return (
            values_of(impact, wanted, parting.shape[:2], more),
            parting,
            np.broadcast_to(stops_act(impact), parting.shape[:2]),
        )


def postures(
    landing: PosedLanding,
    Q: Array,
    wanted: Sequence[Column],
    inertias: Inertias | None = None,
    trusted: float | None = None,
) -> Postures:
    """Steps 1 and 2 in a few postures, in double precision.

    Args:
        landing: the landing.
        Q: (m, nq) configurations.
        wanted: what will be read of them.
        inertias: the inertias in each posture; the landing's by default.
        trusted: as for `needs_proof`.
    """
    with_strike = landing.before.velocity.ndim > 1 or not landing.translates
    state = dynamics(landing.robot, Q, landing.joint_model, inertias)
    everywhere = any(column.selection.quantity.of == "joint" for column in wanted)
    carriers = (
        None
        if everywhere
        else list(dict.fromkeys(c.place.body for c in wanted if c.place.body >= 0)) or [0]
    )
    equation, solution, jumps = solved(landing, state, with_strike, carriers)
    condition, prove = needs_proof(landing, equation, solution, trusted)
    jumps = in_body_axes(jumps, state.rotation if carriers is None else state.rotation[:, carriers])
    return Postures(landing, Q, equation, solution, jumps, carriers, condition, prove, inertias)


def columns(
    landing: PosedLanding,
    Q: Array,
    strikes: Array | None,
    wanted: Sequence[Column],
    inertias: Inertias | None = None,
    trusted: float | None = None,
) -> tuple[dict[str, Array], Array, np.ndarray, np.ndarray]:
    """Every column for m postures and S strikes of each, in double precision; NaN where redundant
    rows leave a number undetermined.

    Args:
        landing: the landing.
        Q: (m, nq) configurations.
        strikes: (m, S, 3) velocities of the base before the impact, world axes [m/s]; None for the
            landing's, of which each posture has one (S = 1).
        wanted: the columns.
        inertias: the inertias in each posture; the landing's by default.
        trusted: as for `needs_proof`; with it, quantities of one posture at a time are computed
            where double precision has them.

    Returns: columns (m, S) by name, NaN where proofs are needed; the condition (m,) of each
        posture; which rows (m, S) need one, those too that friction may refuse or in which an end
        stop acts; and which contacts (m, S, c) do not approach the ground.
    """
    landing = landing.without_stops
    parts, feasible = (
        [],
        [column.name for column in wanted if column.selection.quantity.decided_by_ground],
    )
    for k in range(0, len(Q), BLOCK):
        rows = slice(k, k + BLOCK)
        moving = landing.motions(rows) if strikes is None else landing
        block = postures(
            moving, Q[rows], wanted, None if inertias is None else inertias.rows(rows), trusted
        )
        values, parting, acting = block.values(
            None if strikes is None else strikes[rows], wanted, trusted is not None
        )
        undecided = [
            values[c.name] for c in wanted if c.name in feasible or c.per_landing(landing.scene)
        ]
        prove = block.prove[:, None] | acting | np.any(np.isnan(undecided), axis=0)
        parts.append(
            (
                values,
                block.condition,
                np.broadcast_to(prove, parting.shape[:2]),
                parting,
                block.solution.rank,
            )
        )
    computed = {
        name: np.concatenate([values[name] for values, *_ in parts]) for name in parts[0][0]
    }
    condition, prove, parting, rank = (
        np.concatenate(of_all) for of_all in list(zip(*parts, strict=True))[1:]
    )
    for column in wanted:
        if column.selection.quantity.scope.shared:
            computed[column.name][rank < block.equation.J_c.shape[1]] = np.nan
    prove = prove | (rank < rank.max())[:, None]
    return computed, condition, prove, parting


def stops_act(impact: DoubleImpact) -> np.ndarray:
    """Whether (N, S) a joint would move beyond an end stop that it is at, or one that strikes is
    not at its stop.

    Never for a scene that leaves stops out.
    """
    landing = impact.landing
    striking = [block for block in landing.contacts if block.kind == "stop"]
    missed = missed_stops(landing.robot, striking, impact.state.Q, landing.before.joint_rates)[
        :, None
    ]
    if not landing.scene.stops:
        return missed
    rates = impact.along(impact.delta_qd) + np.asarray(landing.before.joint_rates)[..., None, :]
    sides = at_stops(landing.robot, impact.state.Q, landing.joint_model)[:, None]
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
    computed = {column.name: np.full(shape, np.nan) for column in wanted if column.time is not None}
    wanted = [column for column in wanted if column.time is None]
    with np.errstate(invalid="ignore", divide="ignore"):
        for entry in dict.fromkeys(column.selection.quantity for column in wanted):
            of_entry = [column for column in wanted if column.selection.quantity is entry]
            computed |= {column.name: np.full(shape, np.nan) for column in of_entry}
            known = {
                column.place.name: place
                for column in of_entry
                if (place := column.at(impact.landing)) is not None
            }
            places = list(known.values())
            in_doubles = entry.evaluation.exact == "never"
            if not places or (
                entry.per_landing(impact.landing.scene)
                and not ((more or in_doubles) and entry.evaluation.postures == "clear")
            ):
                continue
            values, index = (
                evaluate(entry, impact, places),
                {place.name: k for k, place in enumerate(places)},
            )
            for column in (column for column in of_entry if column.place.name in known):
                computed[column.name] = np.broadcast_to(
                    column.selection.scalar(values[:, :, index[column.place.name]]), shape
                )
    return computed


def proven_columns(profile: ShockProfile, wanted: Sequence[Column]) -> dict[str, float]:
    """The same columns of one landing, proven; NaN where redundant rows leave a number
    undetermined.
    """
    computed = {column.name: np.nan for column in wanted}
    for selection in dict.fromkeys(column.selection for column in wanted if column.time is None):
        of_it = [
            column for column in wanted if column.selection == selection and column.time is None
        ]
        places = {
            column.name: place
            for column in of_it
            if (place := column.at(profile.landing)) is not None
        }
        computed |= dict(
            zip(places, profile.numbers(selection, list(places.values())).tolist(), strict=True)
        )
    return computed


def columns_at_times(landing: PosedLanding, wanted: Sequence[Column]) -> dict[str, float]:
    """Those columns of one landing that are changes of velocity until a time, on contacts of finite
    stiffness.

    Raises:
        SolveError: the motion cannot be followed.
        StudyError: the scene gives no contact stiffness.
    """
    timed = [column for column in wanted if column.time is not None]
    times = sorted({column.time for column in timed if column.time is not None})
    motion, computed = motion_of(landing, times[-1] / 1e3), dict[str, float]()
    if motion is None:
        raise StudyError(
            "a quantity at a time after the impact needs a contact stiffness; give "
            "contact_stiffness"
        )
    for time in times:
        at_time = {
            column._replace(time=None).name: column for column in timed if column.time == time
        }
        values = values_of(
            motion.impact_at(time / 1e3),
            [column._replace(time=None) for column in at_time.values()],
            (1, 1),
        )
        computed |= {at_time[name].name: float(value[0, 0]) for name, value in values.items()}
    return computed


def double_difference(
    profile: ShockProfile,
    double: dict[str, float],
    exact: dict[str, float],
    wanted: Sequence[Column],
) -> float:
    """Largest difference of a shock in double precision, relative to the most severe one of the
    same point [1].
    """
    largest = 0.0
    for column in filter(lambda column: column.shock, wanted):
        severe = float(
            profile.values(
                cast(Quantity, column.selection.quantity.relations.most_severe), [column.place]
            )[0]
        )
        off = abs(double[column.name] - exact[column.name]) / (
            max(severe, abs(exact[column.name])) or 1.0
        )
        largest = (
            max(largest, off)
            if np.isfinite(off)
            else np.inf
            if np.isfinite(exact[column.name])
            else largest
        )
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
        yield i, s, SolveError(text, blocks=[landing.contacts[c].frame])
