"""Landings that differ from one, on a grid, in a random sample, or as given.

A row has a value of everything that varies: of a grid, of a draw, or one that is given, in which
NaN leaves a thing as it is. Rows are grouped by what needs a landing of its own: contacts, ground
and places, and the posture where loops have to be closed. The rows of a group are arrays:
configurations, inertias and strikes.
"""

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.landings import GROUP, ROWS, Chunk, Group, Refusal
from shockpc.evaluation.variations.kinds.posture import JOINT_POSITION, motion_range
from shockpc.evaluation.variations.row_arrays import RowInertias, RowPostures, RowStrikes
from shockpc.evaluation.variations.row_values import (
    RowValues,
    equal_rows,
    grid_values,
    of_row,
    sample_values,
)
from shockpc.evaluation.variations.variation import Variation
from shockpc.evaluation.variations.vary import Vary, each_of, pairs, prepared, refuse_repeated
from shockpc.evaluation.variations.vary import variation as read_variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import close_loops, resolve, with_definite_contacts
from shockpc.landing.scenes.scene import Contact, Scene
from shockpc.landing.scenes.scene_file import check_scene, robot_of
from shockpc.landing.scenes.strike import Strike
from shockpc.method.dynamics import Inertias
from shockpc.profile import profile_of_scene
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.changes import Change, changed
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError, StudyError, attempt

MOST_ROWS = 10**8
"""Rows of a sweep: so many take an hour, and a column of them 0.8 GB."""

CLOSED = 4096
"""Postures whose closed loops are kept, at most."""

FEWEST_ROWS = 1024
"""Largest number of rows of a chunk whose rows take long."""

MOVED = 1e-6
"""By how much closing loops may move a joint that varies [deg, m]."""


@dataclass(frozen=True, eq=False)
class VariedLandings:
    """Landings that differ from one, on a grid or in a sample.

    Attributes:
        scene: the landing that is varied.
        robot: its robot.
        variations: what differs between rows.
        sample: number of random rows; None for the full grid.
        lhs: whether they are a Latin hypercube.
        seed: of the random numbers.
        rows_given: (sample, v) values of the rows, in the order of the variations, in place of
            random ones; NaN where a row has what the scene has.
        struck: strikes of each posture of a sample by name; by default the scene's, or one that
            varies.
    """

    scene: Scene
    robot: Robot = field(repr=False)
    variations: tuple[Variation, ...]
    sample: int | None = None
    lhs: bool = False
    seed: int = 0
    rows_given: Array | None = field(default=None, repr=False)
    struck: Mapping[str, Strike] = field(default_factory=dict, repr=False)

    noun = "sweep"
    extra_headings = ()

    def __post_init__(self) -> None:
        """Resolve where the contacts strike, in the posture of the scene, unless they vary."""
        scene = prepared(self.scene, self.variations)
        if not any(varied.kind.names_contacts for varied in self.variations):
            scene = self._definite(scene)
        object.__setattr__(self, "scene", scene)

    def _definite(self, scene: Scene) -> Scene:
        """A scene with definite contacts; as it is if its posture is no landing, as rows report."""
        try:
            return with_definite_contacts(scene, self.robot)
        except ShockError:
            return scene

    @functools.cached_property
    def contacts(self) -> dict[str, tuple[Contact, ...]]:
        """The contacts by the values of what varies, each resolved in the posture of the scene."""
        contacts = {}
        for varied in self.variations:
            if not varied.kind.names_contacts:
                continue
            for value in varied.values:
                scene, _ = varied.applied(self.scene, self.robot, value)
                contacts[str(value)] = self._definite(scene).contact
        return contacts

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @functools.cached_property
    def axes(self) -> tuple[Variation, ...]:
        """The variations from the slowest to the fastest, by `Kind.stage`."""
        return tuple(sorted(self.variations, key=lambda variation: variation.stage))

    @property
    def strikes(self) -> int:
        """Number of strikes for each posture; one that a sample varies differs from row to row."""
        if self.sample is not None:
            return len(self.struck) or 1
        return math.prod(len(varied.values) for varied in self.axes if varied.stage == 2)

    @property
    def solves(self) -> int:
        """Number of postures of all landings."""
        if self.sample is not None:
            return self.sample
        return math.prod(len(varied.values) for varied in self.axes if varied.stage < 2)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.solves * self.strikes

    @functools.cached_property
    def separate(self) -> bool:
        """True if loops have to be closed, so that each posture needs a landing of its own."""
        return bool(self.first.loops)

    @functools.cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """First and last posture of every chunk, the last one excluded.

        They do not depend on who computes them.
        """
        n = self.solves
        postures = max(1, self._rows_of_a_chunk // self.strikes)
        count = -(-n // postures)
        chunks = []
        for k in range(count):
            begin, end = n * k // count, n * (k + 1) // count
            chunks.append((begin, end))
        return tuple(chunks)

    @property
    def _rows_of_a_chunk(self) -> int:
        """Largest number of rows of a chunk: fewer of large robots, and of separate landings."""
        others = [varied for varied in self.axes if not varied.kind.names_contacts]
        of_landings = any(varied.stage == 0 for varied in others)
        if self.separate or (self.sample is not None and of_landings):
            return FEWEST_ROWS
        nv: int = self.robot.model.nv
        return min(ROWS, max(FEWEST_ROWS, 2**25 // nv**2))

    @property
    def description(self) -> dict[str, Any]:
        """The variations and the numbers of a sample, on which rows depend."""
        keys = ("subject", "values", "span", "law", "factor")
        vary = []
        for varied in self.variations:
            vary.append({key: getattr(varied, key) for key in keys})
        return {
            "vary": vary,
            "sample": self.sample,
            "lhs": self.lhs,
            "seed": self.seed,
        }

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of what varies."""
        return tuple(variation.column for variation in self.variations)

    @property
    def opens(self) -> bool:
        """True if a contact that would be pulled opens, because there is friction."""
        return self.base_scene.friction is not None

    @property
    def base_scene(self) -> Scene:
        """The first landing, which also has a friction or a contact stiffness that varies."""
        return self.first.scene

    def compared(self, count: int) -> np.ndarray:
        """Random rows (n,), at most so many."""
        generator = np.random.default_rng([self.seed, 2])
        size = min(count, self.rows)
        return generator.choice(self.rows, size, replace=False, shuffle=False)

    def data(self, k: int) -> None:
        """Nothing: the rows of a chunk follow from its number."""

    def at(self, values: Array) -> "VariedLandings":
        """Landings with these values (n, v), the rest as in these."""
        landings = replace(self, rows_given=values, sample=len(values))
        # Neither the first landing nor how loops are closed depends on the values.
        vars(landings).update(first=self.first, _closed=self._closed)
        return landings

    def resolved(self) -> tuple[Array, Array]:
        """Configurations (n, nq) and strikes (n, S, 3) of all postures, if of one landing."""
        Q: list[Array] = []
        strikes: list[Array] = []
        for k, (begin, end) in enumerate(self.chunks):
            values = self._values(k)
            rows = np.arange(end - begin)
            Q.append(self._postures(self.first, values, rows))
            strikes.append(self._strikes(self.first, values, rows))
        return np.concatenate(Q), np.concatenate(strikes)

    def case(self, row: int) -> tuple[Scene, Robot]:
        """The landing of one row, as `profile_of_scene` takes it.

        Raises:
            ShockError: there is no such landing.
        """
        return self._case(self.values_of(row), row % self.strikes)

    def values_of(self, row: int) -> dict[Variation, Any]:
        """The values of one row, by what varies."""
        posture, strike = divmod(row, self.strikes)
        chunk = next(k for k, (_, end) in enumerate(self.chunks) if posture < end)
        begin, _ = self.chunks[chunk]
        return of_row(self._values(chunk), posture - begin, strike)

    def chunk(self, k: int, data: None) -> Chunk:
        """The postures of a chunk, grouped by what needs a separate landing."""
        begin, end = self.chunks[k]
        strikes = self.strikes
        values = self._values(k)
        labels = {}
        for varied in self.variations:
            of_rows = np.broadcast_to(values[varied], (end - begin, strikes))
            labels[varied.column] = of_rows.ravel()

        def profile(i: int) -> ShockProfile:
            posture, strike = divmod(i, strikes)
            case = self._case(of_row(values, posture, strike), strike)
            return profile_of_scene(*case)

        return Chunk(labels, self._groups(values, end - begin), profile)

    def _groups(self, values: RowValues, m: int) -> "Iterator[Group | Refusal]":
        for chosen, landing in self._landings(values, m):
            if isinstance(landing, ShockError):
                yield Refusal(chosen, landing)
                continue
            for begin in range(0, len(chosen), GROUP):
                rows = chosen[begin : begin + GROUP]
                of_rows, refused = self._inertias(landing, values, rows)
                for i, error in refused.items():
                    yield Refusal(rows[i : i + 1], error)
                Q = self._postures(landing, values, rows)
                strikes = self._strikes(landing, values, rows)
                yield Group(rows, landing, Q, strikes, of_rows)

    def _values(self, k: int) -> RowValues:
        """The values of a chunk."""
        begin, end = self.chunks[k]
        if self.sample is None:
            return grid_values(self.axes, np.arange(begin, end), self.strikes)
        if self.rows_given is not None:
            columns = self.rows_given[begin:end].T
            return {
                varied: column[:, None]
                for varied, column in zip(self.variations, columns, strict=True)
            }
        rows = np.arange(begin, end)
        return sample_values(self.axes, k, rows, self.sample, self.seed, self.lhs)

    def _landings(
        self, values: RowValues, m: int
    ) -> "Iterator[tuple[np.ndarray, PosedLanding | ShockError]]":
        """The postures (m,) of a chunk in groups, each with their landing, or the error."""
        choices: dict[Variation, np.ndarray] = {}
        for varied, x in values.items():
            # `separate` is asked only where a posture varies: the first landing may not exist.
            if varied.stage == 0 or (varied.moves and self.separate):
                choices[varied] = x[:, 0]
        if not choices:
            yield np.arange(m), self.first
            return
        for group in equal_rows(list(choices.values())):
            choice = {varied: x[group[0]] for varied, x in choices.items()}
            yield group, attempt(self._landing, choice)

    def _landing(self, choice: Mapping[Variation, Any]) -> PosedLanding:
        return resolve(*self._case(choice))

    @functools.cached_property
    def _closed(self) -> dict[str, Scene]:
        """Scenes with closed loops, by their postures."""
        return {}

    @functools.cached_property
    def first(self) -> PosedLanding:
        """The first of all landings."""
        choice: dict[Variation, Any] = {}
        for varied in self.axes:
            if varied.stage == 0:
                choice[varied] = (varied.values or varied.span or ())[0]
        return self._landing(choice)

    def _postures(self, landing: PosedLanding, values: RowValues, rows: np.ndarray) -> Array:
        """Configurations (n, nq) of rows of a chunk; the landing's if loops have to be closed."""
        postures = RowPostures(landing, len(rows))
        for varied, x in values.items():
            if varied.moves and not self.separate:
                of_rows = x[rows, 0].astype(float)
                varied.kind.set_posture(varied, postures, varied.in_radians(of_rows))
        return postures.configurations()

    def _inertias(
        self, landing: PosedLanding, values: RowValues, rows: np.ndarray
    ) -> tuple[Inertias | None, dict[int, ShockError]]:
        """The inertias of some rows of a chunk, None if all have the landing's.

        And by row the error if no robot has its inertias.
        """
        varying: dict[Variation, Array] = {}
        for varied, x in values.items():
            if not varied.kind.inertial:
                continue
            of_rows = x[rows, 0].astype(float)
            # Derivatives by hundreds of masses change few of them in the group of a posture.
            if not np.isnan(of_rows).all():
                varying[varied] = of_rows
        if not varying:
            return None, {}
        of_landing = RowInertias(landing, len(rows))
        for varied, of_rows in varying.items():
            varied.kind.set_inertia(varied, of_landing, of_rows)
        of_robots, possible = of_landing.inertias()
        refused: dict[int, ShockError] = {}
        for i in np.flatnonzero(~possible).tolist():
            try:
                self._case({varied: x[i] for varied, x in varying.items()})
            except ShockError as error:
                refused[i] = error
        return of_robots, refused

    def _strikes(self, landing: PosedLanding, values: RowValues, rows: np.ndarray) -> Array:
        """Velocities (n, S, 3) of the base before the impact in some rows of a chunk [m/s]."""
        varying = {varied: x for varied, x in values.items() if varied.stage == 2}
        velocity = landing.before.velocity
        if varying:
            strikes = RowStrikes(landing)
            for varied, x in varying.items():
                # On a grid all postures have the same strikes.
                of_rows = x if self.sample is None else x[rows]
                varied.kind.set_strike(strikes, varied.in_radians(of_rows))
            velocity = strikes.velocities()
        elif len(self.struck) > 1:
            velocity = np.array([one.vector(landing.plane) for one in self.struck.values()])
        return np.broadcast_to(velocity, (len(rows), self.strikes, 3))

    def _case(self, choice: Mapping[Variation, Any], strike: int = 0) -> tuple[Scene, Robot]:
        """Scene and robot with some values, of which NaN leaves a thing as it is.

        Args: strike, number of that of `struck`.
        """
        scene, robot = self.scene, self.robot
        if self.struck:
            scene = replace(scene, strike=list(self.struck.values())[strike])
        choice = {varied: value for varied, value in choice.items() if not _is_nan(value)}
        # Contacts come first, because others change those that are struck.
        contacts_first = sorted(choice, key=lambda varied: not varied.kind.names_contacts)
        changes: list[Change] = []
        for varied in contacts_first:
            value = choice[varied]
            if varied.kind.names_contacts:
                scene = replace(scene, contact=self.contacts[str(value)])
            elif varied.kind.of_robot:
                changes += varied.kind.robot_changes(varied, robot, value)
            else:
                # `separate` asks for the first landing, and so for a case without motion.
                if varied.moves and self.separate:
                    scene = varied.kind.from_closed(varied, scene, robot, self.first.q)
                scene, robot = varied.applied(scene, robot, value)
        if changes:
            # All at once, because each changed robot reads the places of its frames anew.
            robot = changed(robot, changes)
        if any(varied.moves for varied in choice) and self.separate:
            scene = self._with_closed_loops(scene)
            _refuse_moved(scene, robot, choice)
        return scene, robot

    def _with_closed_loops(self, scene: Scene) -> Scene:
        """The scene with closed loops, from the first landing; the last results are kept."""
        key = repr((scene.posture, scene.assemble))
        if key not in self._closed:
            if len(self._closed) == CLOSED:
                self._closed.clear()
            self._closed[key] = close_loops(scene, self.first)
        closed = self._closed[key]
        return replace(scene, posture=closed.posture, assemble=closed.assemble)


def _is_nan(value: Any) -> bool:
    return not isinstance(value, str) and math.isnan(value)


def _refuse_moved(scene: Scene, robot: Robot, choice: Mapping[Variation, Any]) -> None:
    """Refuse joints that closing the loops has moved away from their values.

    Raises:
        StudyError: there is one.
    """
    for varied, value in choice.items():
        for joint in varied.kind.settable(robot, varied.target):
            closed = scene.posture.joints_deg.get(joint.name, value)
            if abs(closed - value) > MOVED:
                raise StudyError(
                    f'{varied.subject}: closing the loops moves "{joint.name}" away '
                    f"from {value:g} {varied.unit}; let other joints move with --assemble"
                )


def varied_landings(
    scene: Scene,
    vary: Vary = (),
    *,
    robot: Robot | None = None,
    vary_each: Vary = (),
    sample: int | None = None,
    lhs: bool = False,
    seed: int = 0,
    keep_joints: bool = False,
) -> VariedLandings:
    """Landings that differ from one, checked.

    Args:
        scene: the landing that is varied.
        vary: values by subject, as in `variation`: {"*_KFE": "-120:-10:200", "strike-angle": [0,
            15, 30]}.
        robot: the scene's robot, if it is loaded already.
        vary_each: the same, with a separate quantity for each joint or link that a pattern matches.
        sample: number of random rows instead of the full grid. If neither a joint nor what the
            robot and the ground are is varied, all joints are, within their limits.
        lhs: whether the sample is a Latin hypercube.
        seed: of the random numbers.
        keep_joints: whether joints that are not varied stay where the scene has them in any sample.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be
            resolved.
    """
    robot = robot or robot_of(scene)
    variations = _read_variations(robot, vary, vary_each)
    if lhs and sample is None:
        raise StudyError("a Latin hypercube is a sample; give its number of rows with --sample")
    stated = any(
        varied.uncertain or varied.kind.settable(robot, varied.target) for varied in variations
    )
    if sample is not None and not keep_joints and not stated:
        variations += [
            JOINT_POSITION.read(robot, f"joint:{joint.name}", joint.name, None)
            for joint in robot.independent_joints
        ]
    if not variations:
        raise StudyError(
            "nothing varies; name a joint or another quantity with --vary, or draw random "
            "postures with --sample"
        )
    # Without values each joint has its own range.
    single: list[Variation] = []
    for varied in variations:
        has_values = varied.values or varied.span
        single += [varied] if has_values else each_of(robot, varied)
    variations = [_complete(robot, varied, sample is not None) for varied in single]
    refuse_repeated(robot, variations)
    scene = check_scene(scene)
    for varied in variations:
        varied.kind.refuse_scene(scene)
    source = VariedLandings(scene, robot, tuple(variations), sample, lhs, seed)
    if source.rows > MOST_ROWS:
        raise StudyError(
            f"{source.rows:.4g} landings are more than {MOST_ROWS:.0e}; give fewer values, or "
            "draw a sample with --sample"
        )
    for varied in source.axes:
        varied.kind.check_landing(varied, scene, robot)
    return source


def _read_variations(robot: Robot, vary: Vary, vary_each: Vary) -> list[Variation]:
    """The variations, those of `vary_each` one by one."""
    # Pairs may repeat a subject, which is refused later; a mapping cannot.
    together, separately = pairs(vary), pairs(vary_each)
    variations = [read_variation(robot, subject, values) for subject, values in together]
    for subject, values in separately:
        variations += each_of(robot, read_variation(robot, subject, values))
    return variations


def _complete(robot: Robot, varied: Variation, sample: bool) -> Variation:
    """A variation with the range of its joint, if it was given no values."""
    if not varied.values and varied.span is None:
        joint = robot.joint(varied.target)
        low, high = motion_range([joint])
        if varied.unit != "m":
            low, high = math.degrees(low), math.degrees(high)
        if not high > low or not math.isfinite(high - low):
            raise StudyError(
                f'joint "{joint.name}" has no range of motion in the robot file; give values, '
                f"such as {joint.name}=0:0.1:5"
            )
        varied = replace(varied, subject=joint.name, span=(low, high))
    if not sample and varied.span is not None:
        raise StudyError(
            f"{varied.subject}: a range is drawn from by --sample N; for a grid give the number "
            f"of values too, such as {varied.span[0]:g}:{varied.span[1]:g}:10"
        )
    return varied
