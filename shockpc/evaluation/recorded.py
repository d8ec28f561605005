"""Landings of a table: every row's own configuration and motion before the impact, in arrays; rows that need it are proven."""

import contextlib
import functools
import hashlib
import itertools
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.evaluation.columns import Column, columns, not_approaching, prove_rows, selected
from shockpc.evaluation.executor import in_order
from shockpc.evaluation.recorded_table import Rows
from shockpc.evaluation.varied import ROWS, Chunk, with_sweep
from shockpc.landing.closure import assemble, closure_block, follow, moved_joints
from shockpc.landing.dynamics import dynamics
from shockpc.landing.landing import PosedLanding, landing_of, with_loops
from shockpc.landing.motion import Motion
from shockpc.landing.places import Place, point_places
from shockpc.landing.posture import Posture, held_joints
from shockpc.landing.scene import Scene, Strike
from shockpc.profile import profile_of
from shockpc.quantities.profile import ShockProfile
from shockpc.quantities.table import Selection, select
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError, ShockError, StudyError, UnknownName
from shockpc.text.printed import listed

OPEN = 0.1
"""Largest change of a position that the table gives, to close a loop [rad, m]."""

CLOSED_BY, RATES_BY = "closed by", "rates closed by"
"""Columns: the largest change of a given position [rad, m], and of a given rate [rad/s, m/s], that closes the loops."""

Key = tuple[int, float | None]
"""Number of a scene, and coefficient of friction where it is the row's own."""


@dataclass(frozen=True, eq=False)
class Landings:
    """The landings of a table, to be computed in parts.

    Attributes:
        robot: the robot.
        table: the rows.
        computed: the computed columns.
        prove: number of rows, evenly spaced, that are compared with a proof, besides those that need one.
    """

    robot: Robot = field(repr=False)
    table: Rows = field(repr=False)
    computed: tuple[Column, ...] = ()
    prove: int = 20

    noun, strikes = "table", 1

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.table.Q)

    @property
    def scene(self) -> Scene:
        """The scene of the first row that has one."""
        return self.table.scenes[self._key(min(set(range(self.rows)) - self.table.messages.keys()))[0]]

    @functools.cached_property
    def parts(self) -> tuple[tuple[int, int], ...]:
        """First and last row of every part, the last one excluded."""
        most = 1024 if self.closes else min(ROWS, max(1024, 2**25 // self.robot.model.nv**2))
        count = -(-self.rows // most)
        return tuple((self.rows * k // count, self.rows * (k + 1) // count) for k in range(count))

    @functools.cached_property
    def numbers(self) -> tuple[str, ...]:
        """The headings of the columns of numbers."""
        closing = (CLOSED_BY, RATES_BY) if self.closes else ()
        return (*(column.name for column in self.computed), *closing, "condition", "proven", "double_error")

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, without the message."""
        return (*self.table.labels, *self.numbers)

    @property
    def description(self) -> dict[str, Any]:
        """What the rows depend on, besides scene and robot."""
        table = self.table
        text = hashlib.sha256(repr((table.scenes, {key: x.tolist() for key, x in table.labels.items()}, table.messages)).encode())
        for part in (table.Q, *table.before, table.scene, table.contact_velocity, table.friction):
            text.update(np.ascontiguousarray(part).tobytes())
        return {"table": {"rows": self.rows, "sha256": text.hexdigest()}, "rows proven for comparison": self.prove}

    @functools.cached_property
    def first(self) -> PosedLanding:
        """The landing of the first row that has one, in the posture of its scene."""
        return self._landing((self.table.scenes.index(self.scene), None))

    @property
    def closes(self) -> bool:
        """Whether there are loops that the rows may leave open."""
        return bool(self.first.loops) and not self.table.own

    @functools.cached_property
    def _by_friction(self) -> bool:
        """Whether rows of different friction are computed apart, because a column depends on it in arrays too."""
        return any(column.selection.name == "feasible" for column in self.computed)

    def _key(self, row: int) -> Key:
        """What decides the landing of a row, whatever its posture and motion: its scene, and its friction."""
        mu = float(self.table.friction[row])
        return int(self.table.scene[row]), None if np.isnan(mu) else mu

    @functools.cached_property
    def _known(self) -> dict[int, PosedLanding]:
        return {}

    def _landing(self, key: Key) -> PosedLanding:
        """The landing of rows of one key; whether they approach the ground is looked at later."""
        number, friction = key
        if number not in self._known:
            self._known[number] = landing_of(self.table.scenes[number], self.robot)
        landing = self._known[number]
        return landing if friction is None else replace(landing, scene=replace(landing.scene, friction=friction))

    def chunk(self, k: int) -> Chunk:
        """Compute a part."""
        with one_thread(self.robot.model.nv):
            return self._chunk(*self.parts[k])

    def _chunk(self, a: int, b: int) -> Chunk:
        n, table = b - a, self.table
        computed = {name: np.full(n, np.nan) for name in self.numbers if name != "proven"}
        prove, messages = np.zeros(n, dtype=bool), {i - a: text for i, text in table.messages.items() if a <= i < b}
        known = np.array([i for i in range(n) if i not in messages], dtype=int)
        friction = np.nan_to_num(table.friction[a:b] if self._by_friction else np.zeros(n), nan=-1.0)[known]
        _, first, group = np.unique(np.stack([table.scene[a:b][known], friction]), axis=1, return_index=True, return_inverse=True)
        Q, velocities = table.Q[a:b].copy(), table.contact_velocity[a:b]
        before = Motion(table.before.velocity[a:b], table.before.omega[a:b], table.before.joint_rates[a:b].copy())
        for k, i in enumerate(known[first].tolist()):
            chosen = known[group.ravel() == k].tolist()
            try:
                landing = self._landing(self._key(a + i))
            except ShockError as error:
                messages |= dict.fromkeys(chosen, str(error))
                continue
            for i in chosen if self.closes else ():
                try:
                    Q[i], before.joint_rates[i], computed[CLOSED_BY][i], computed[RATES_BY][i] = self._closed(
                        landing, Q[i], before.joint_rates[i]
                    )
                except ShockError as error:
                    messages[i] = str(error)
            own = np.array([i for i in chosen if i not in messages], dtype=int)
            if not own.size:
                continue
            moving = landing.moving(Motion(*(part[own] for part in before)), velocities[own])
            values, condition, unsafe, parting = columns(moving, Q[own], None, self.computed)
            for name, value in values.items():
                computed[name][own] = value[:, 0]
            computed["condition"][own] = condition
            prove[own] = unsafe[:, 0] | any(column.selection.quantity.alone(landing.scene) for column in self.computed)
            for i, _, text in not_approaching(landing, parting):
                messages.setdefault(int(own[i]), text)

        def profile(i: int) -> ShockProfile:
            motion = Motion(*(part[i] for part in before))
            return profile_of(self._written(a + i, self._landing(self._key(a + i)).at(Q[i]).moving(motion, velocities[i])))

        checked = [row - a for row in self._checked if a <= row < b]
        proven, difference = prove_rows(prove, checked, profile, self.computed, computed, messages)
        labels = {name: values[a:b] for name, values in table.labels.items()}
        results = labels | computed | {"proven": proven, "double_error": difference}
        return Chunk(a, {name: results[name] for name in self.headings}, dict(sorted(messages.items())))

    @functools.cached_property
    def _checked(self) -> set[int]:
        return set(np.linspace(0, self.rows - 1, min(self.prove, self.rows)).astype(int).tolist())

    def _closed(self, landing: PosedLanding, q: Array, rates: Array) -> tuple[Array, Array, float, float]:
        """A configuration and rates with which all loops are closed, and the largest changes of what the table gives.

        First by the joints that the table does not give; if these cannot close them, by the least change of all, or of those of the
        scene's `assemble`.

        Raises:
            SceneError: the loops cannot be closed, or not within the limit.
        """
        robot, table, blocks = self.robot, self.table, [closure_block(loop) for loop in landing.loops]
        others = held_joints(robot, Posture(), landing.scene.assemble)
        given, followers = robot.velocities(table.joints), robot.velocities(robot.followers)
        try:
            closed = follow(robot, landing.q, q, landing.loops, landing.plane, others | given)
        except SceneError:
            closed = assemble(robot, q, landing.loops, landing.plane, others).q
        by = max((abs(by) for name, by, _ in moved_joints(robot, q, closed) if name in table.joints), default=0.0)
        if by > OPEN:
            raise SceneError(
                f"the loops are open: closing them changes a joint that the table gives by {by:.3g} rad (m), and at most {OPEN:g} "
                "is taken for a measuring error; correct the table, or leave columns out with --map COLUMN="
            )
        # What is locked in the impact may have moved before it, and keeps its rate.
        state, known = dynamics(robot, closed[None]), robot.velocities(table.rates)
        try:
            moving = with_loops(robot, state, blocks, rates, others | followers | known, landing.plane)
        except SceneError:
            moving = with_loops(robot, state, blocks, rates, others | followers, landing.plane)
        return closed, moving, by, float(np.abs((moving - rates)[known]).max(initial=0.0))

    def profile(self, row: int) -> ShockProfile:
        """The landing of one row, with a proof.

        Raises:
            ShockError: it cannot be computed.
        """
        return profile_of(self.landing(row))

    def landing(self, row: int) -> PosedLanding:
        """The landing of one row, in whose configuration and motion the loops are closed, with its scene.

        Raises:
            ShockError: there is none, or they cannot be closed.
        """
        if row in self.table.messages:
            raise StudyError(self.table.messages[row])
        landing, before = self._landing(self._key(row)), Motion(*(x[row] for x in self.table.before))
        q = self.table.Q[row]
        if self.closes:
            q, rates, *_ = self._closed(landing, q, before.joint_rates)
            before = before._replace(joint_rates=rates)
        return self._written(row, landing.at(q).moving(before, self.table.contact_velocity[row]))

    @property
    def resolved(self) -> Iterator[PosedLanding]:
        """The landings of which the rows are, those that can be resolved."""
        for number in range(len(self.table.scenes)):
            with contextlib.suppress(ShockError):
                yield self._landing((number, None))

    def row_named(self, name: str) -> int:
        """The number of the row of a name.

        Raises:
            UnknownName: there is none.
        """
        if name not in self.table.names:
            raise UnknownName("landing", name, self.table.names[:1000].tolist(), "the table", "")
        return int(np.flatnonzero(self.table.names == name)[0])

    def column(self, text: str) -> Column:
        """The computed column that a text names, KEY@PLACE.

        Raises:
            StudyError: it names several.
        """
        selection, _, place = text.partition("@")
        named = [column for column in self.computed if column.selection == select(selection) and place in ("", column.place.name)]
        if len(named) != 1:
            raise StudyError(f'"{text}" means {listed((column.name for column in named), 6)}; name one of them')
        return named[0]

    def case(self, row: int) -> Scene:
        """The landing of one row as a scene.

        Raises:
            ShockError: there is none, or a scene cannot hold its posture.
        """
        landing = self.landing(row)
        if not self.table.own:
            for joint in self.robot.single_joints[self.robot.free_base :]:
                moved = joint.kind != "ball" and not np.array_equal(landing.q[joint.q], self.first.q[joint.q])
                # Rates that the table does not give follow from the loops.
                turns = joint.name in self.table.rates and landing.before.joint_rates[joint.v].any()
                if joint.axis is None and (moved or turns):
                    raise StudyError(
                        f'joint "{joint.name}" has {joint.v.stop - joint.v.start} degrees of freedom, whose '
                        f"{'position' if moved else 'rates'} a scene cannot hold; analyze the landing in Python, as profile(row)"
                    )
        return landing.scene

    def _written(self, row: int, landing: PosedLanding) -> PosedLanding:
        """A landing with the scene of its row, in which loops are closed already."""
        if self.table.own:
            return replace(landing, scene=self.table.own[row] or landing.scene)
        robot, q, before, scene = self.robot, landing.q, landing.before, landing.scene
        loops_move = bool(landing.loops) and before.joint_rates.any()
        moving = [joint for joint in robot.independent_joints if loops_move or before.joint_rates[joint.v].any()]
        balls = [
            joint for joint in robot.single_joints if joint.kind == "ball" and (landing.loops or joint.name in self.table.joints)
        ]
        posture = replace(
            scene.posture,
            joints={joint.name: joint.value(q) for joint in robot.independent_joints},
            joints_deg={},
            joint_quaternions={**scene.posture.joint_quaternions, **{ball.name: tuple(q[ball.q].tolist()) for ball in balls}},
        )
        if robot.free_base:
            position, quaternion = tuple(q[:3].tolist()), tuple(q[3:7].tolist())
            posture = replace(posture, base_rpy_deg=None, base_position=position, base_quaternion=quaternion)
        strike = Strike(
            velocity=tuple(before.velocity.tolist()),
            angular_velocity=tuple(before.omega.tolist()) if before.omega.any() else None,
            joint_velocities={joint.name: float(before.joint_rates[joint.v][0]) for joint in moving},
        )
        velocities = (None if block.velocity is None else tuple(block.velocity.tolist()) for block in landing.contacts)
        contact = tuple(replace(c, velocity=velocity) for c, velocity in zip(scene.contact, velocities, strict=True))
        return replace(landing, scene=replace(scene, posture=posture, strike=strike, contact=contact))


def landings(
    table: Rows, robot: Robot, quantities: Sequence[str] = (), *, prove: int = 20, ranked_by: str | None = None
) -> Landings:
    """The landings of a table.

    Args:
        table: the rows.
        robot: their robot.
        quantities: columns, QUANTITY or QUANTITY@PLACES; by default jump and shock at the sensors and points, or of the base.
        prove: number of rows that are compared with a proof, besides those that need one.
        ranked_by: a further column.

    Raises:
        ShockError: a name is not known, or a scene cannot be resolved.
    """
    study = Landings(robot, table, (), prove)
    points = {place.name: place for scene in table.scenes for place in point_places(robot, scene.point) if place.body >= 0}
    usual = [f"{key}@{name}" for name in points for key in ("delta_v", "shock")]
    usual = usual or [f"{key}@{robot.bodies[0].name}" for key in ("delta_v_com", "shock_com")]
    contacts = {tuple(contact.frame for contact in scene.contact) for scene in table.scenes}
    computed: list[Column] = []
    for text in dict.fromkeys([*(quantities or usual), *([ranked_by] if ranked_by else [])]):
        selection, places = _places(study, text)
        if len(contacts) > 1 and selection.quantity.of == "contact":
            if "@" in text:
                raise StudyError(f'the contact varies, so "{text}" cannot name one; leave the @ and what follows out')
            places = tuple(Place(f"contact {k + 1}", number=k) for k in range(max(map(len, contacts))))
        if not places:
            raise StudyError(f'"{text}": there is no such place; links of the robot: {listed(robot.links, 6)}')
        computed += [Column(selection, place, asked=True) for place in places]
    return replace(study, computed=tuple({column.name: column for column in computed}.values()))


def _places(study: Landings, text: str) -> tuple[Selection, tuple[Place, ...]]:
    """What QUANTITY[@PLACES] means in all landings of a table, of which only some may have a pulse or parts.

    Raises:
        ShockError: it means nothing in any of them.
    """
    places: dict[str, Place] = {}
    refusals = []
    for landing in study.resolved:
        try:
            places |= {place.name: place for place in selected(landing, text)[1] if place.name not in places}
        except (StudyError, UnknownName) as refusal:
            refusals.append(refusal)
    if refusals and not places:
        raise refusals[0]
    return select(text.partition("@")[0]), tuple(places.values())


class Results(NamedTuple):
    """The computed landings of a table.

    Attributes:
        study: what was computed.
        columns: (n,) by heading, but the names of the rows.
        messages: why a row could not be computed, by its number.
    """

    study: Landings
    columns: Mapping[str, Array]
    messages: Mapping[int, str]

    @classmethod
    def read(cls, study: Landings, read: Callable[[str], Iterator[Any]]) -> "Results":
        """The landings of files. Args: read, heading of a column, or "message" → its parts in order."""
        columns = {name: np.concatenate(list(read(name))) for name in study.numbers}
        return cls(study, columns, {i: text for i, text in enumerate(itertools.chain.from_iterable(read("message"))) if text})

    def ranked(self, column: Column | None) -> list[int]:
        """The rows, the worst value of a column first, those without one last; in the order of the table without a column."""
        if column is None:
            return list(range(self.study.rows))
        values = np.abs(self.columns[column.name])
        severity = values if column.selection.quantity.worse == "less" else -values
        return [int(i) for i in np.argsort(severity, kind="stable")]

    def worst(self, count: int, column: Column | None = None) -> list[int]:
        """The rows with the worst values of a column, at most so many; without a column, the worst of every column in turn."""
        columns = self.study.computed if column is None else (column,)
        orders = ([i for i in self.ranked(each)[:count] if np.isfinite(self.columns[each.name][i])] for each in columns)
        rows = dict.fromkeys(i for places in itertools.zip_longest(*orders) for i in places if i is not None)
        return list(rows)[:count]


def compute(study: Landings, executor: Executor | None = None, done: Callable[..., None] = lambda parts: None) -> Results:
    """Compute all landings of a table.

    Args:
        study: the landings.
        executor: computes the parts; this process by default.
        done: is called with the number of rows of each part that is done.
    """
    chunks: list[Chunk] = []
    for chunk in in_order(executor, functools.partial(with_sweep, pickle.dumps(study), Landings.chunk), range(len(study.parts))):
        chunks.append(chunk)
        done(parts=len(chunk.columns["proven"]))
    columns = {name: np.concatenate([chunk.columns[name] for chunk in chunks]) for name in study.numbers}
    return Results(study, columns, {chunk.first + i: text for chunk in chunks for i, text in chunk.messages.items()})
