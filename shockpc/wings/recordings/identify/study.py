"""Unknowns of a robot from measured landings: drives, friction, restitution, stiffness, masses.

The unknowns are those values with which predicted and measured jumps of velocities differ least, in
the norm of the kinetic energy and relative to the energy of each strike, in which the measurement
after the impact has no part: dividing by a measured jump, which is noisy, would favour values that
predict small jumps. Landings that fit badly count less (soft L1).

A grid is searched first, as where contacts stick nothing changes with the friction and a gradient
leads nowhere.
"""

import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.declare import study
from shockpc.evaluation.table import Table
from shockpc.evaluation.variations.variation import Kind, Variation
from shockpc.evaluation.variations.vary import Vary, pairs, variation
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.landing.scenes.scene_file import scene_of
from shockpc.robot.robot import Robot
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import StudyError
from shockpc.text.printed import listed
from shockpc.wings.recordings.identify.fit import Fit, FittedValues, fit_of, fitted_values
from shockpc.wings.recordings.identify.predictor import SCALE, Predicted, Predictor
from shockpc.wings.recordings.identify.remarks import of_control, of_errors, of_model, of_unknowns
from shockpc.wings.recordings.identify.uncertainty import (
    IdentifiedValue,
    confirmed,
    errors_left_out,
    errors_of_free_impulse,
    uncertainty,
    unidentified,
)
from shockpc.wings.recordings.tables.column_meaning import RenameOption
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.prediction import coordinate
from shockpc.wings.recordings.tables.reader import robot_of_table, rows_of_table
from shockpc.wings.recordings.tables.rows import Measured, RecordedRows
from shockpc.wings.recordings.tables.table_files import columns_of

SCAN = 25
"""Values of each unknown for which the error is given."""

ERRORS = ("before", "after", "left out", "free impulse")
"""The errors of an `Identification`."""


@dataclass(frozen=True, eq=False)
class Identification:
    """Unknowns of a robot identified from measured landings.

    Errors of a landing are ‖predicted − measured‖ / ‖measured‖ in the energy norm √(ΔᵀHΔ); the
    statistic is their median. A landing without a prediction counts as one of no jump, whose error
    is 1.

    Attributes:
        unknowns: with their values.
        scene: the landing with these values; masses are none of a scene.
        robot: the robot with these values.
        predictor: of the jumps.
        before: jumps with the scene as it is given.
        after: jumps with the values that were found.
        used: (n,) which landings are used: those that can be computed and whose measured jump is
            not zero.
        errors: "before" and "after", and "left out": of landings that had no part in finding the
            values (k-fold); "free impulse" is that of the best impulse at the contacts, whatever
            its law, with the inertia that was found; NaN where it has more than half as many
            directions as velocities were measured.
        landing_errors: (n,) the same by landing, NaN where it does not count.
        correlation: (p, p) of the values; NaN where one was not identified.
        singular: (p,) singular values of the derivatives by the unknowns over their ranges,
            relative to what is left unexplained.
        statements: what the data cannot distinguish, and what is wrong beyond their scatter.
        messages: why landings have no prediction with these values, by number of the row.
        scan: of an unknown by its number: values (m,) over its range, and the errors (m,) with
            these, the others as found.
    """

    unknowns: tuple[IdentifiedValue, ...]
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

    _repr_html_ = shown_by("wings.recordings.identify.report:identify_report", Path("a table"))

    def __repr__(self) -> str:
        return brief(
            self,
            *(f"{unknown.variation.subject} {unknown.value:.4g}" for unknown in self.unknowns[:6]),
        )

    @property
    def table(self) -> Table:
        """A row for each unknown."""
        header = ("unknown", "unit", "value", "low", "high", "minimum", "maximum", "state")
        rows = []
        for x in self.unknowns:
            variation = x.variation
            span = variation.span or (None, None)
            rows.append((variation.subject, variation.unit, x.value, x.low, x.high, *span, x.state))
        return Table.of_rows(header, rows)

    @property
    def values(self) -> dict[str, float]:
        """The values by subject."""
        return {unknown.variation.subject: unknown.value for unknown in self.unknowns}


@study(
    "shockpc identify drops.csv leg.toml --unknown 'armature:*knee=1e-4:0.1:log' --out knee/",
    "shockpc identify tosses.csv blocks.urdf --map gap= --unknown friction=0:1.5 --unknown "
    "restitution=0:1",
    more=(
        "The table is like that of shockpc recorded, with velocities after the impact in columns "
        "after_…. The values minimise the difference between predicted and measured jumps, and "
        "have 95 % intervals. The report names unknowns that the data do not determine. --out "
        "writes drives.toml for --drives, and scene.toml with all values, which every command "
        "takes."
    ),
    # as velocities alone are compared
    without=("at", "part", "pulse", "range_g", "imu_bandwidth", "v_in", "ground_tolerance"),
    reads="table",
)
def identify(
    table: str | os.PathLike[str] | Mapping[str, Any] | Table,
    scene: Scene | str,
    unknown: Annotated[
        Vary,
        Option(
            "An unknown and its range (with :log searched in logarithms): friction, restitution, "
            "contact-stiffness [N/m], "
            "contact-damping [N s/m], armature:JOINTS [kg m²], rotor:JOINTS (of the rotor itself) "
            "[kg m²], joint-stiffness:JOINTS "
            "[N m/rad], mass:LINKS [kg], com-x:LINKS [m], inertia:LINKS (a factor), flex:LINKS (EI "
            "[N m²]), or scale:before, a "
            "factor on the velocities before the impact.",
            "What is unknown",
            "NAME=LOW:HIGH[:log]",
        ),
    ],
    *,
    robot: Robot | None = None,
    rename: RenameOption = None,
    after: Annotated[
        float | None,
        Option(
            "Which of several measured times is used.",
            "Table",
            "MS",
            unit="ms",
            above=0.0,
            default="first",
        ),
    ] = None,
    noise: Annotated[
        Mapping[str, float] | None,
        Option(
            "Standard deviation of measured velocities by name or glob [m/s, rad/s]. The first "
            "match is used; velocities without a match are not used. By default all are weighted "
            "by their energy, relative to the energy of the impact.",
            "How it is found",
            "NAME=SIGMA",
        ),
    ] = None,
) -> Identification:
    """Find unknowns of a robot and of the ground from measured jumps.

    Args:
        table: landings with columns after_…, as `landings` takes them; only velocities are used.
        scene: gives what the table does not.
        robot: the scene's robot, if it is loaded already.

    Raises:
        UnknownName: an unknown names nothing in the robot.
        StudyError: a range is not valid, or the table has too little to find unknowns from.
        ShockError: the table cannot be read, or no landing can be computed.
    """
    columns = columns_of(table)
    scene = scene_of(scene)
    robot = robot or robot_of_table(columns, scene)
    rows = rows_of_table(columns, scene, robot, rename)
    unknowns = tuple(_unknown(robot, subject, values) for subject, values in pairs(unknown))
    if not unknowns or len({unknown.subject for unknown in unknowns}) < len(unknowns):
        raise StudyError("give each unknown once, as NAME=LOW:HIGH, such as friction=0:1.5")
    measured = _velocities(rows, robot)
    velocities = _at_one_time(measured, after)
    # Where noises are given, a velocity without one has zero, and is not used.
    deviations = np.array([_noise(column.name, noise) for column in velocities])
    compared = tuple(itertools.compress(velocities, deviations > 0.0))
    if not compared:
        raise StudyError(
            f"--noise fits nothing that was measured; measured are "
            f"{listed(column.name for column in measured)}"
        )
    if compared[0].time is None:
        _refuse_stiffness(unknowns, scene)
    # Only lengths decide how loops close.
    if not any(unknown.kind.changes_lengths for unknown in unknowns):
        rows = RecordedLandings(robot, rows).closed
    predictor = Predictor(rows, robot, unknowns, compared)
    fit = fit_of(predictor, deviations[deviations > 0.0] if noise else None)
    return _identification(fit, scene)


def _velocities(rows: RecordedRows, robot: Robot) -> list[Measured]:
    """The measured velocities of a table.

    Raises:
        StudyError: it has none.
    """
    velocities = []
    for column in rows.measured:
        if coordinate(column, robot) >= 0 and np.isfinite(column.jump).any():
            velocities.append(column)
    if not velocities:
        raise StudyError(
            "the table measured no velocity after the impact, such as after_JOINT or after_vz, so "
            "nothing can be found"
        )
    return velocities


def _at_one_time(velocities: Sequence[Measured], after: float | None) -> list[Measured]:
    """The velocities at one time after contact, by default at the first.

    Raises:
        StudyError: nothing was measured at that time.
    """
    times = list(dict.fromkeys(column.time for column in velocities))
    if after is not None and after not in times:
        known = listed(f"{t:g}" for t in times if t is not None)
        raise StudyError(
            f"nothing was measured after {after:g} ms; "
            + (f"valid are {known}" if known else "no column names a time, such as after6ms_JOINT")
        )
    time = times[0] if after is None else after
    return [column for column in velocities if column.time == time]


def _refuse_stiffness(unknowns: Sequence[Variation], scene: Scene) -> None:
    """Refuse a stiffness beside jumps without a time.

    These are those of an impulse, on which stiffness has no effect.
    """
    for unknown in unknowns:
        if unknown.kind.word in ("contact-stiffness", "contact-damping"):
            raise StudyError(
                f"{unknown.subject} changes the motion at a time after contact, and the table "
                f"does not say when it was measured; name its columns after6ms_… for 6 ms"
            )
    if scene.yields:
        raise StudyError(
            "the scene gives a contact stiffness, which has an effect only on velocities at a time "
            "after contact, and the table "
            "does not say when they were measured; name its columns after6ms_… for 6 ms, or leave "
            "the stiffness out"
        )


def _unknown(robot: Robot, subject: str, values: Any) -> Variation:
    """An unknown with its range."""
    if isinstance(values, tuple | list) and len(values) == 2:
        values = f"{values[0]}:{values[1]}"
    if not isinstance(values, str):
        raise StudyError(
            f"{subject} has no range; give LOW:HIGH, or LOW:HIGH:log, such as {subject}=0.1:1"
        )
    if subject == SCALE:
        # The range is read as that of a friction.
        of_range = variation(robot, "friction", values)
        kind = Kind("scale", "-")
        unknown = Variation(SCALE, kind, "before", "-", span=of_range.span, law=of_range.law)
    else:
        unknown = variation(robot, subject, values)
    if unknown.span is None or unknown.law == "normal":
        raise StudyError(
            f"{subject}={values} is no range; give LOW:HIGH, or LOW:HIGH:log, such as "
            f"{subject}=0.1:1"
        )
    if not unknown.uncertain and subject != SCALE:
        raise StudyError(
            f"{subject} is of how the robot lands, which the table gives; unknown may be friction, "
            f"restitution, contact-stiffness, "
            f"armature:JOINTS, rotor:JOINTS, joint-stiffness:JOINTS, mass:LINK, com-x:LINK, "
            f"inertia:LINK, flex:LINK and {SCALE}"
        )
    return unknown


def _noise(name: str, noise: Mapping[str, float] | None) -> float:
    """The standard deviation of a measured velocity; 1 where none is given for any."""
    if not noise:
        return 1.0
    sigma = next((sigma for pattern, sigma in noise.items() if fnmatchcase(name, pattern)), 0.0)
    if not 0.0 <= sigma < np.inf:
        raise StudyError(
            f"a noise of {sigma:g} for {name} is not valid; give a standard deviation above zero"
        )
    return sigma


def _identification(fit: Fit, scene: Scene) -> Identification:
    """The values, how well they are known, and how well they predict.

    Args: scene, as for `identify`.
    """
    solution = fitted_values(fit)
    known = uncertainty(fit, solution)
    W = solution.mobilities
    by_landing = {
        "before": fit.errors(W, fit.before),
        "after": fit.errors(W, solution.predicted),
        "left out": errors_left_out(fit, solution, known.seen),
        "free impulse": errors_of_free_impulse(fit, solution),
    }
    errors = {name: float(np.median(values[fit.used])) for name, values in by_landing.items()}
    if not (errors["after"] < errors["before"] or confirmed(fit, solution)):
        known = unidentified(known)
    robot = fit.predictor.robot
    for unknown in known.unknowns:
        if unknown.variation.subject != SCALE:
            scene, robot = unknown.variation.applied(scene, robot, unknown.value)
    statements = (
        *of_errors(known, errors),
        *of_unknowns(known, int(fit.used.sum())),
        *of_control(fit),
        *of_model(fit, solution, errors),
    )
    return Identification(
        unknowns=known.unknowns,
        scene=scene,
        robot=robot,
        predictor=fit.predictor,
        before=fit.before,
        after=solution.predicted,
        used=fit.used,
        errors=errors,
        landing_errors=by_landing,
        correlation=known.correlation,
        singular=known.singular,
        statements=statements,
        messages=solution.predicted.messages,
        scan=cache(partial(_scan, fit, solution)),
    )


def _scan(fit: Fit, solution: FittedValues, j: int) -> tuple[Array, Array]:
    """Values (m,) of an unknown over its range, and the median errors with them."""
    shares = np.unique(np.append(np.linspace(0.0, 1.0, SCAN), solution.u[j]))
    values = np.empty(len(shares))
    errors = np.empty(len(shares))
    for k, share in enumerate(shares):
        u = np.where(np.arange(fit.p) == j, share, solution.u)
        at_share = fit.values(u)
        values[k] = at_share[j]
        by_landing = fit.errors(solution.mobilities, fit.predictor(at_share))
        errors[k] = np.median(by_landing[fit.used])
    return values, errors
