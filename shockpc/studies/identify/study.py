"""From measured landings to what was unknown of a robot: drives, friction, restitution, stiffness, masses.

The unknowns are those values with which predicted and measured jumps of velocities differ least, in the norm of the kinetic
energy and relative to the energy of each strike, in which the measurement after the impact has no part: dividing by a measured
jump, which is noisy, would favour values that predict small jumps. Landings that fit badly count less (soft L1).

A grid is searched first, as where contacts stick nothing changes with the friction and a gradient leads nowhere. Intervals are a
bootstrap over landings: each draw gives landings other weights, and the values follow from the derivatives at the solution. So do
the values without the landings that are left out, which are then predicted in full.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache, partial
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.declare import RenameOption, study
from shockpc.evaluation.table import Table
from shockpc.evaluation.variation import Variation, Vary, pairs, variation
from shockpc.evaluation.varied_scene import applied
from shockpc.landing.record import Option
from shockpc.landing.scene import Scene
from shockpc.recorded.files import columns_of
from shockpc.recorded.prediction import SCALE, Predicted, Predictor, coordinate, energy_norms, energy_roots, mobilities
from shockpc.recorded.source import RecordedLandings, robot_of_table, rows_of_table
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import few, listed

SEED = 0
"""Of the bootstrap and of the parts that are left out."""

SOBOL_BITS, STARTS = 8, 2
"""Binary logarithm of the most points of the Sobol sequence that is searched first; and those from which the search goes on."""

DRAWS, FOLDS = 1000, 5
"""Of the bootstrap; and parts in which landings are left out."""

STEP = 5e-3
"""With which derivatives are differences, as a share of an unknown's range."""

EDGE = 2e-3
"""Share of the range within which a value is at its bound."""

ALIKE = 0.05
"""Relative scatter of the predicted jumps over the speeds of the strikes up to which landings are all alike."""

HARD = 0.95
"""Correlation from which two unknowns are hard to tell apart."""

NO_INFLUENCE, UNSEEN = 1e-6, 1e-4
"""Shares of the jumps: what changes so little over its range has no influence, and what several change together is not seen."""

SLIGHT = 0.02
"""Share of the jumps by which they may be wrong without a word."""

SCAN = 25
"""Values of each unknown for which the error is given."""

ERRORS = ("before", "after", "left out", "free impulse")
"""The errors of an `Identification`."""

State = Literal["identified", "at its bound", "not identifiable", "no influence"]


class Unknown(NamedTuple):
    """What was found of an unknown.

    Attributes:
        variation: the unknown, with its unit and range.
        value: with which the landings are predicted best.
        low: lower end of the 95 % interval; NaN without one.
        high: its upper end.
        state: "identified", or why there is no interval.
    """

    variation: Variation
    value: float
    low: float
    high: float
    state: State


@dataclass(frozen=True, eq=False)
class Identification:
    """What measured landings say about unknowns.

    Errors of a landing are ‖predicted − measured‖ / ‖measured‖ in the energy norm √(ΔᵀHΔ); the statistic is their median. A
    landing without a prediction counts as one of no jump, whose error is 1.

    Attributes:
        unknowns: with their values.
        scene: the landing with these values; masses are none of a scene.
        robot: the robot with these values.
        predictor: of the jumps.
        before: jumps with the scene as it is given.
        after: jumps with the values that were found.
        used: (n,) which landings count: those that can be computed and whose measured jump is not zero.
        errors: "before" and "after", and "left out": of landings that had no part in finding the values (k-fold); "free impulse" is
            that of the best impulse at the contacts, whatever its law, with the inertia that was found; NaN where it has more than
            half as many directions as velocities were measured.
        landing_errors: (n,) the same by landing, NaN where it does not count.
        correlation: (p, p) of the values; NaN where one was not identified.
        singular: (p,) singular values of the derivatives by the unknowns over their ranges, relative to what is left unexplained.
        statements: what the data do not tell, and what is wrong beyond their scatter.
        messages: why landings have no prediction with these values, by number of the row.
        scan: of an unknown by its number: values (m,) over its range, and the errors (m,) with these, the others as found.
    """

    unknowns: tuple[Unknown, ...]
    scene: Scene = field(repr=False)
    robot: Robot = field(repr=False)
    predictor: Predictor = field(repr=False)
    before: Predicted = field(repr=False)
    after: Predicted = field(repr=False)
    used: np.ndarray = field(repr=False)
    errors: Mapping[str, float]
    landing_errors: Mapping[str, Array] = field(repr=False)
    correlation: Array
    singular: Array
    statements: tuple[str, ...]
    messages: Mapping[int, str]
    scan: Callable[[int], tuple[Array, Array]] = field(repr=False)

    @property
    def table(self) -> Table:
        """A row for each unknown."""
        header = ("unknown", "unit", "value", "low", "high", "least", "greatest", "state")
        rows = (
            (x.variation.subject, x.variation.unit, x.value, x.low, x.high, *(x.variation.span or (None, None)), x.state)
            for x in self.unknowns
        )
        return Table.of_rows(header, rows)

    @property
    def values(self) -> dict[str, float]:
        """The values by subject."""
        return {one.variation.subject: one.value for one in self.unknowns}


@study(
    "shockpc identify drops.csv leg.toml --unknown 'armature:*knee=1e-4:0.1:log' --out knee/",
    "shockpc identify tosses.csv blocks.urdf --map gap= --unknown friction=0:1.5 --unknown restitution=0:1",
    more=(
        "The table is one as shockpc landings takes, with velocities after the impact in columns after_…. Unknowns are found where "
        "predicted and measured jumps differ least, with 95 % intervals; what the data do not tell is said. --out has drives.toml "
        "for --drives, and scene.toml with all values, which every command takes."
    ),
    without=("at", "part", "pulse", "range_g", "v_in", "ground_tolerance"),  # as velocities alone are compared
)
def identify(
    table: str | os.PathLike[str] | Mapping[str, Any] | Table,
    scene: Scene,
    unknown: Annotated[
        Vary,
        Option(
            "What is unknown, and its range, of which :log searches the logarithm: friction, restitution, contact-stiffness [N/m], "
            "contact-damping [N s/m], armature:JOINTS [kg m²], rotor:JOINTS (of the rotor itself) [kg m²], joint-stiffness:JOINTS "
            "[N m/rad], mass:LINKS [kg], com-x:LINKS [m], inertia:LINKS (a factor), or scale:before, a factor on the velocities "
            "before the impact.",
            "What is unknown",
            "NAME=LOW:HIGH[:log]",
        ),
    ],
    *,
    robot: Robot | None = None,
    rename: RenameOption = None,
    after: Annotated[
        float | None, Option("Which of several measured times counts; by default the first.", "Table", "MS", unit="ms", above=0.0)
    ] = None,
    noise: Annotated[
        Mapping[str, float] | None,
        Option(
            "Standard deviation of measured velocities by name or glob [m/s, rad/s], the first that fits; what none fits is not "
            "used. By default all count by their energy, relative to that of the strike.",
            "How it is found",
            "NAME=SIGMA",
        ),
    ] = None,
) -> Identification:
    """Find unknowns of a robot and of the ground from measured jumps.

    Args:
        table: landings with columns after_…, as `landings` takes them; velocities alone are used.
        scene: gives what the table does not.
        robot: the scene's robot, if it is loaded already.

    Raises:
        UnknownName: an unknown names nothing in the robot.
        StudyError: a range is not valid, or the table has too little to find unknowns from.
        ShockError: the table cannot be read, or no landing can be computed.
    """
    columns = columns_of(table)
    robot = robot or robot_of_table(columns, scene)
    rows = rows_of_table(columns, scene, robot, rename)
    unknowns = tuple(_unknown(robot, *one) for one in pairs(unknown))
    if not unknowns or len({one.subject for one in unknowns}) < len(unknowns):
        raise StudyError("give each unknown once, as NAME=LOW:HIGH, such as friction=0:1.5")
    velocities = [one for one in rows.measured if coordinate(one, robot) >= 0 and np.isfinite(one.jump).any()]
    if not velocities:
        raise StudyError(
            "the table measured no velocity after the impact, such as after_JOINT or after_vz, so nothing can be found"
        )
    times = list(dict.fromkeys(column.time for column in velocities))
    if after is not None and after not in times:
        known = listed(f"{t:g}" for t in times if t is not None)
        raise StudyError(
            f"nothing was measured after {after:g} ms; "
            + (f"valid are {known}" if known else "no column names a time, such as after6ms_JOINT")
        )
    chosen = tuple(column for column in velocities if column.time == (times[0] if after is None else after))
    deviations = np.array([_noise(column.name, noise) for column in chosen])
    chosen = tuple(column for column, sigma in zip(chosen, deviations, strict=True) if sigma > 0.0)
    if not chosen:
        raise StudyError(f"--noise fits nothing that was measured; measured are {listed(column.name for column in velocities)}")
    stiff = [one.subject for one in unknowns if one.kind in ("contact-stiffness", "contact-damping")]
    if stiff and chosen[0].time is None:
        raise StudyError(
            f"{stiff[0]} changes the motion at a time after contact, and the table does not say when it was measured; name its "
            "columns after6ms_… for 6 ms"
        )
    if scene.contact_stiffness is not None and chosen[0].time is None:
        raise StudyError(
            "the scene gives a contact stiffness, which counts for velocities at a time after contact alone, and the table does "
            "not say when they were measured; name its columns after6ms_… for 6 ms, or leave the stiffness out"
        )
    if all(one.kind != "place" for one in unknowns):  # lengths alone decide how loops close
        rows = RecordedLandings(robot, rows).closed
    predictor = Predictor(rows, robot, unknowns, chosen)
    return _Fit(predictor, deviations[deviations > 0.0] if noise else None).identification(scene)


def _unknown(robot: Robot, subject: str, values: Any) -> Variation:
    """An unknown with its range."""
    if isinstance(values, tuple | list) and len(values) == 2:
        values = f"{values[0]}:{values[1]}"
    if not isinstance(values, str):
        raise StudyError(f"{subject} has no range; give LOW:HIGH, or LOW:HIGH:log, such as {subject}=0.1:1")
    if subject == SCALE:
        numbers = variation(robot, "friction", values)
        one = Variation(SCALE, "scale", "before", "-", span=numbers.span, law=numbers.law)
    else:
        one = variation(robot, subject, values)
    if one.span is None or one.law == "normal":
        raise StudyError(f"{subject}={values} is no range; give LOW:HIGH, or LOW:HIGH:log, such as {subject}=0.1:1")
    if not one.uncertain and subject != SCALE:
        raise StudyError(
            f"{subject} is of how the robot lands, which the table gives; unknown may be friction, restitution, contact-stiffness, "
            f"armature:JOINTS, rotor:JOINTS, joint-stiffness:JOINTS, mass:LINK, com-x:LINK, inertia:LINK and {SCALE}"
        )
    return one


def _noise(name: str, noise: Mapping[str, float] | None) -> float:
    """The standard deviation of a measured velocity; 1 where none is given for any."""
    if not noise:
        return 1.0
    sigma = next((sigma for pattern, sigma in noise.items() if fnmatchcase(name, pattern)), 0.0)
    if not 0.0 <= sigma < np.inf:
        raise StudyError(f"a noise of {sigma:g} for {name} is not valid; give a standard deviation above zero")
    return sigma


class _Fit:
    """The search. Unknowns are shares u (p,) of their ranges, in logarithms where these are so."""

    def __init__(self, predictor: Predictor, noise: Array | None) -> None:
        self.predictor, self.noise, self.p = predictor, noise, len(predictor.unknowns)
        for corner in (0.0, 1.0):
            _ = predictor.study(self.values(np.full(self.p, corner))).first  # what is wrong with a range is said at once
        self.before = predictor(None)
        known = np.isfinite(self.before.measured)
        W = mobilities(predictor.study(self.values(np.full(self.p, 0.5))))
        energy = predictor.strike_energy
        moved = np.nan_to_num(self.before.measured).any(axis=1)
        self.used = moved & (energy > 0.0) & np.isfinite(W).all(axis=(1, 2))
        if self.used.sum() <= self.p:
            reasons = list(dict.fromkeys([*predictor.rows.messages.values(), *self.before.messages.values()]))
            if still := np.count_nonzero(known.any(axis=1) & ~moved):
                reasons.append(f"in {still} of the table all measured velocities are those before")
            raise StudyError(
                f"{self.used.sum()} landings that can be computed do not identify {self.p} unknowns; give more"
                + (f" ({reasons[0]})" if reasons else "")
            )
        self.whitening = np.zeros((len(known), known.shape[1], known.shape[1]))
        for pattern in np.unique(known[self.used], axis=0):
            rows, columns = np.flatnonzero((known == pattern).all(axis=1) & self.used), np.flatnonzero(pattern)
            if noise is not None:
                root = np.broadcast_to(np.diag(1.0 / noise[columns]), (len(rows), len(columns), len(columns)))
            else:
                root = energy_roots(W[rows], predictor.coordinates[columns]) / np.sqrt(2.0 * energy[rows, None, None])
            self.whitening[np.ix_(rows, columns, columns)] = root
        self.scale = 1.0

    @property
    def freedoms(self) -> int:
        """Number of measured values less that of unknowns; at least 1."""
        return max(int(np.count_nonzero(self.whitening[self.used].any(axis=2))) - self.p, 1)

    def values(self, u: Array) -> tuple[float, ...]:
        """The values of the unknowns."""
        return tuple(map(_value, self.predictor.unknowns, u.tolist()))

    def residuals(self, u: Array) -> Array:
        """Predicted less measured jumps (n, k) by their energies or noise, of landings that count; without prediction no jump."""
        predicted = self.predictor(self.values(u))
        difference = np.nan_to_num(predicted.jumps) - np.nan_to_num(predicted.measured)
        return np.asarray((self.whitening @ difference[..., None])[self.used, :, 0])

    def cost(self, u: Array) -> float:
        """What is minimised."""
        return float(np.sum(np.sqrt(1.0 + np.sum(self.residuals(u) ** 2, axis=1) / self.scale**2) - 1.0))

    def derivatives(self, u: Array, step: Array | float = STEP) -> Array:
        """Derivatives (n, k, p) of the residuals: differences to both sides, as far as the range allows."""
        columns = []
        for j, h in enumerate(np.broadcast_to(step, self.p)):
            low, high = u.copy(), u.copy()
            low[j], high[j] = max(u[j] - h, 0.0), min(u[j] + h, 1.0)
            columns.append((self.residuals(high) - self.residuals(low)) / (high[j] - low[j]))
        return np.stack(columns, axis=-1)

    def solve(self) -> Array:
        """The shares u with the least cost."""
        from scipy.optimize import least_squares
        from scipy.stats import qmc

        points = qmc.Sobol(self.p, rng=SEED).random_base2(min(3 + 2 * self.p, SOBOL_BITS))
        sizes = np.array([np.linalg.norm(self.residuals(u), axis=1) for u in points])
        self.scale = max(float(np.median(sizes, axis=1).min()), 1e-9)
        order = np.argsort([np.sum(np.sqrt(1.0 + size**2 / self.scale**2)) for size in sizes])
        starts: list[Array] = []
        for u in points[order]:
            if len(starts) < STARTS and all(np.abs(u - other).max() > len(points) ** (-1.0 / self.p) for other in starts):
                starts.append(u)
        loss = partial(_soft_l1, k=len(self.predictor.measured))
        for final in (False, True):
            fits = [
                least_squares(
                    lambda u: self.residuals(u).ravel(), u, lambda u: self.derivatives(u).reshape(-1, self.p), (0.0, 1.0),
                    loss=loss, f_scale=self.scale, xtol=1e-7, ftol=1e-9, gtol=1e-12, max_nfev=40,
                ).x
                for u in starts
            ]  # fmt: skip
            best = min(fits, key=self.cost)
            if not final:
                # The size of an ordinary residual is known better now.
                self.scale, starts = max(float(np.median(np.linalg.norm(self.residuals(best), axis=1))), 1e-9), [best]
        for j in range(self.p):
            for edge in (0.0, 1.0):
                moved = np.where(np.arange(self.p) == j, edge, best)
                if abs(best[j] - edge) < 10.0 * EDGE and self.cost(moved) <= self.cost(best) * (1.0 + 1e-6):
                    best = moved
        return np.asarray(best)

    def identification(self, scene: Scene) -> Identification:
        """The values, how well they are known, and how well they predict. Args: scene, as for `identify`."""
        u = self.solve()
        predictor, unknowns, n = self.predictor, self.predictor.unknowns, int(self.used.sum())
        edge = (u < EDGE) | (u > 1.0 - EDGE)
        r, D = self.residuals(u), self.derivatives(u)
        weight = 1.0 / np.sqrt(1.0 + np.sum(r**2, axis=1) / self.scale**2)
        left = np.sqrt(np.sum(weight * np.sum(r**2, axis=1)) / self.freedoms)
        # Differences over what is not known anyway: one landing that begins to slip counts for a part of it.
        spread = left / np.maximum(np.sqrt(np.einsum("n,nkp->p", weight, D**2)), 1e-12)
        D = self.derivatives(u, np.clip(spread, STEP, 0.1))
        singular, V = np.linalg.svd(np.sqrt(weight)[:, None, None].repeat(r.shape[1], 1).reshape(-1, 1) * D.reshape(-1, self.p))[1:]
        size = float(np.linalg.norm(self.whitening[self.used] @ np.nan_to_num(predictor(self.values(u)).jumps)[self.used, :, None]))
        without = np.linalg.norm(D, axis=(0, 1)) <= NO_INFLUENCE * size
        # A direction is not seen if its 95 % interval is as wide as the range, or if it changes next to nothing.
        unseen = [V[j] for j in range(self.p) if not singular[j] > max(4.0 * left, UNSEEN * size)]
        singular = singular / max(left, 1e-300)
        vague = np.any([np.abs(v) > 0.3 for v in unseen], axis=0) if unseen else np.zeros(self.p, dtype=bool)
        spreads = self._alike(u)
        free = ~(edge | without | vague)
        steps = self._refitted(u, r, D, free, _drawn(n, DRAWS))
        state: list[State] = [
            "no influence" if without[j] else "not identifiable" if vague[j] or spreads < ALIKE else "at its bound" if edge[j]
            else "identified" for j in range(self.p)
        ]  # fmt: skip
        low, high = np.full((2, self.p), np.nan)
        for j in range(self.p):
            if state[j] == "identified":
                ends = np.quantile(np.clip(u[j] + steps[:, j], 0.0, 1.0), _tails(n, int(free.sum())))
                low[j], high[j] = (_value(unknowns[j], float(end)) for end in ends)
        correlation = np.full((self.p, self.p), np.nan)
        if free.any():
            spreads_of = np.cov(steps[:, free].T).reshape(free.sum(), free.sum())
            sizes = np.sqrt(np.maximum(np.diagonal(spreads_of), 1e-300))
            correlation[np.ix_(free, free)] = spreads_of / np.outer(sizes, sizes)
        predicted, W = predictor(self.values(u)), mobilities(predictor.study(self.values(u)))
        left_out, best = self._left_out(u, r, D, ~(without | vague), W), self._free_impulse(u, W)
        by_landing = dict(zip(ERRORS, (self._errors(W, self.before), self._errors(W, predicted), left_out, best), strict=True))
        errors = {name: float(np.median(values[self.used])) for name, values in by_landing.items()}
        fitted, robot = scene, predictor.robot
        for one, value in zip(unknowns, self.values(u), strict=True):
            if one.subject != SCALE:
                fitted, robot = applied(fitted, robot, one, value)
        results = tuple(
            Unknown(one, value, float(low[j]), float(high[j]), state[j])
            for j, (one, value) in enumerate(zip(unknowns, self.values(u), strict=True))
        )
        statements = (
            *self._unknown_statements(results, correlation, unseen, spreads), *self._model_statements(predicted, r, errors)
        )  # fmt: skip
        return Identification(
            results, fitted, robot, predictor, self.before, predicted, self.used, errors, by_landing, correlation, singular,
            statements, predicted.messages, cache(partial(self._scan, u, W=W)),
        )  # fmt: skip

    def _refitted(self, u: Array, r: Array, D: Array, free: np.ndarray, counts: Array) -> Array:
        """By how much (m, p) the shares differ where landings have other weights (m, n), with derivatives (n, k, p) held."""
        b, M, unknowns = np.einsum("nk,nkp->np", r, D), np.einsum("nkp,nkq->npq", D, D), np.flatnonzero(free)
        square, step = np.sum(r**2, axis=1), np.zeros((len(counts), self.p))
        if not len(unknowns):
            return step
        for _ in range(12):
            size = square + 2.0 * step @ b.T + np.einsum("mp,npq,mq->mn", step, M, step)
            weights = counts / np.sqrt(1.0 + np.maximum(size, 0.0) / self.scale**2)
            A = np.einsum("mn,npq->mpq", weights, M[:, unknowns][:, :, unknowns])
            right = -np.einsum("mn,np->mp", weights, b[:, unknowns])
            ridge = 1e-12 * np.einsum("mpp->m", A)[:, None, None] * np.eye(len(unknowns)) + 1e-300 * np.eye(len(unknowns))
            step[:, unknowns] = np.clip(u[unknowns] + np.linalg.solve(A + ridge, right[..., None])[..., 0], 0.0, 1.0) - u[unknowns]
        return step

    def _errors(self, W: Array, predicted: Predicted) -> Array:
        """The errors (n,) of the landings that count, as in `Identification`."""
        coordinates, measured = self.predictor.coordinates, np.where(self.used[:, None], predicted.measured, np.nan)
        difference = np.where(np.isnan(measured), np.nan, np.nan_to_num(predicted.jumps) - measured)
        with np.errstate(invalid="ignore", divide="ignore"):
            return energy_norms(W, coordinates, difference) / energy_norms(W, coordinates, measured)

    def _left_out(self, u: Array, r: Array, D: Array, free: np.ndarray, W: Array) -> Array:
        """The errors (n,) of landings that were left out when the values were found."""
        used, errors = np.flatnonzero(self.used), np.full(len(self.used), np.nan)
        parts = np.array_split(np.random.default_rng(SEED).permutation(len(used)), min(FOLDS, len(used)))
        counts = np.array([~np.isin(np.arange(len(used)), part) for part in parts], dtype=float)
        for part, step in zip(parts, self._refitted(u, r, D, free, counts), strict=True):
            errors[used[part]] = self._errors(W, self.predictor(self.values(u + step)))[used[part]]
        return errors

    def _free_impulse(self, u: Array, W: Array) -> Array:
        """The errors (n,) with the impulse at the contacts that fits each landing best; NaN where it would fit whatever jump."""
        predictor, values, errors = self.predictor, self.values(u), np.full(len(self.used), np.nan)
        measured, scale = predictor(values).measured, predictor.by_subject(values).get(SCALE, 1.0)
        for rows, problem, to_measured in predictor.problems(values)[0]:
            moves, stops = to_measured @ problem.by_impulse, (to_measured @ (scale * problem.stop)[..., None])[..., 0]
            for row, moved, stop in zip(rows.tolist(), moves, stops, strict=True):
                columns = np.flatnonzero(np.isfinite(measured[row]))
                if not self.used[row]:
                    continue
                root = energy_roots(W[row : row + 1], predictor.coordinates[columns])[0]
                U, s, _ = np.linalg.svd(root @ moved[columns], full_matrices=False)
                U, jump = U[:, s > 1e-9 * s.max(initial=0.0)], root @ (measured[row] - stop)[columns]
                if 2 * U.shape[1] <= len(columns):
                    errors[row] = np.linalg.norm(jump - U @ (U.T @ jump)) / np.linalg.norm(root @ measured[row, columns])
        return errors

    def _scan(self, u: Array, j: int, W: Array) -> tuple[Array, Array]:
        """Values (m,) of an unknown over its range, and the median errors with them."""
        shares = np.unique(np.append(np.linspace(0.0, 1.0, SCAN), u[j]))
        points = [self.values(np.where(np.arange(self.p) == j, share, u)) for share in shares]
        errors = [float(np.median(self._errors(W, self.predictor(values))[self.used])) for values in points]
        return np.array([values[j] for values in points]), np.array(errors)

    def _alike(self, u: Array) -> float:
        """Relative scatter of the predicted jumps, each by the energy or speed of its strike."""
        jumps = np.nan_to_num(self.predictor(self.values(u)).jumps)[self.used]
        if self.noise is None:
            jumps = (self.whitening[self.used] @ jumps[..., None])[..., 0]
        else:
            jumps = jumps / np.sqrt(self.predictor.strike_energy[self.used, None])
        return float(np.sqrt(np.sum((jumps - jumps.mean(axis=0)) ** 2) / max(np.sum(jumps**2), 1e-300)))

    def _unknown_statements(
        self, results: Sequence[Unknown], correlation: Array, unseen: Sequence[Array], spreads: float
    ) -> Iterable[str]:
        """What the data do not tell of the unknowns."""
        names, n = [one.variation.subject for one in results], int(self.used.sum())
        if spreads < ALIKE:
            yield (
                f"not identifiable: the {n} landings are all alike (their predicted jumps differ by {100.0 * spreads:.2g} % once "
                "the speed of the strike is taken out), so that they are one landing, measured several times; what is wrong "
                "otherwise in the model there goes into the values, and no interval shows it. Measure landings in other postures"
            )
        for name, one in zip(names, results, strict=True):
            if one.state == "no influence":
                yield f"{name} has no influence on what was measured, so any value predicts the same"
            if one.state == "at its bound":
                yield f"{name} is at the bound {one.value:.4g} of its range, so it has no interval; widen the range if it can be"
        for v in unseen:
            part = [j for j in range(self.p) if abs(v[j]) > 0.3 and results[j].state != "no influence"]
            if len(part) == 1:
                yield f"the data do not see {names[part[0]]}: over its range it changes the jumps less than what is unexplained"
            elif part:
                signs = "with" if v[part[0]] * v[part[1]] > 0.0 else "against"
                yield (
                    f"the data cannot tell {' and '.join(names[j] for j in part)} apart: one changed {signs} the other predicts "
                    "the same; fix one of them, or measure landings that differ more"
                )
        for i in range(self.p):
            for j in range(i + 1, self.p):
                if abs(correlation[i, j]) > HARD:
                    yield (
                        f"{names[i]} and {names[j]} are hard to tell apart (correlation {correlation[i, j]:.2f}): an error of one "
                        "is made up for by the other"
                    )

    def _model_statements(self, predicted: Predicted, r: Array, errors: Mapping[str, float]) -> Iterable[str]:
        """What is wrong beyond the scatter of the landings, or beyond the noise."""
        wrong, n = [], int(self.used.sum())
        counts = _drawn(n, 2 * DRAWS)
        for k, column in enumerate(self.predictor.measured):
            both = np.stack([values[self.used, k] for values in (predicted.jumps, predicted.measured)])
            x, y = np.where(np.isnan(predicted.measured[self.used, k]), 0.0, np.nan_to_num(both))
            if not (size := float(x @ x)) > 0.0:
                continue
            slopes = counts @ (x * y) / np.maximum(counts @ (x * x), 1e-300)
            low, high = np.quantile(slopes, (0.0015, 0.9985))
            if n > 5 and not (low <= 1.0 + SLIGHT and high >= 1.0 - SLIGHT):
                wrong.append(f"{column.name} {x @ y / size:.2f} ({low:.2f} … {high:.2f})")
        if wrong:
            yield (
                "the model is still wrong beyond the scatter of the landings, which no interval covers: measured jumps are, "
                "times the predicted ones, " + few(wrong, 6, what=" velocities")
            )
        if self.noise is not None:
            ratio = float(np.sqrt(np.sum(r**2) / self.freedoms))
            if ratio > 1.0 + 3.0 / np.sqrt(2.0 * n):
                yield f"the model is still wrong beyond the noise: what is left is {ratio:.3g} times the noise that was given"
        if errors["after"] > SLIGHT and errors["free impulse"] < 0.9 * errors["after"]:
            yield (
                f"of the error of {errors['after']:.2f}, {errors['free impulse']:.2f} is left with the best impulse at the "
                "contacts, whatever its law: that much is of the robot's inertia, its posture or the measurement, the rest of the "
                "law of contact"
            )


def _drawn(n: int, draws: int) -> Array:
    """How often (draws, n) each of n landings is drawn, with replacement."""
    return np.random.default_rng(SEED).multinomial(n, np.full(n, 1.0 / n), size=draws).astype(float)


def _value(one: Variation, u: float) -> float:
    """The value of an unknown for a share of its range."""
    assert one.span is not None
    low, high = one.span
    if one.law == "log-uniform":
        return float(np.clip(low * (high / low) ** u, low, high))
    return float(np.clip(low + u * (high - low), low, high))


def _soft_l1(z: Array, k: int) -> Array:
    """SciPy's loss of squares z (n k,): 2 (√(1 + Σz) − 1) of the k residuals of a landing together, along whatever axes."""
    root = np.sqrt(1.0 + z.reshape(-1, k).sum(axis=1))
    share = np.where(np.arange(len(z)) % k == 0, np.repeat(2.0 * (root - 1.0), k), 0.0)
    return np.stack([share, np.repeat(1.0 / root, k), np.zeros(len(z))])


def _tails(n: int, p: int) -> tuple[float, float]:
    """Quantiles of a bootstrap that are the ends of a 95 % interval: those of n landings and p unknowns are too narrow otherwise.

    The expanded percentiles of Hesterberg 2015, "What Teachers Should Know About the Bootstrap", The American Statistician 69:371.
    """
    from scipy.stats import norm, t

    tail = float(norm.cdf(np.sqrt(n / (n - p)) * t.ppf(0.025, n - p)))
    return tail, 1.0 - tail
