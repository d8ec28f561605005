"""Landings of a table: every row's own configuration and motion before the impact, in arrays; rows that need it are proven."""

import functools
import hashlib
import itertools
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.errors import SceneError, ShockError, StudyError, UnknownName, refusal
from shockpc.executor import in_order
from shockpc.landing import PosedLanding, resolve, with_loops
from shockpc.model.closure import assemble, closure_block, follow
from shockpc.model.contact import Contact, landing_frames
from shockpc.model.dynamics import dynamics
from shockpc.model.motion import Motion
from shockpc.places import Place
from shockpc.printed import listed
from shockpc.profile import profile_of
from shockpc.quantities.table import select
from shockpc.result import ShockProfile
from shockpc.robot.record import Robot
from shockpc.scene import Scene, robot_of
from shockpc.studies.columns import Column, columns, double_difference, proven_columns, selected
from shockpc.studies.landings.table import Rows, rows_of
from shockpc.studies.sweep.rows import ROWS, Chunk, with_sweep

OPEN = 0.1
"""Largest change of a position that the table gives, to close a loop [rad, m]."""

CLOSED_BY, RATES_BY = "closed by", "rates closed by"
"""Columns: the largest change of a given position [rad, m], and of a given rate [rad/s, m/s], that closes the loops."""

Key = tuple[str, float]


@dataclass(frozen=True, eq=False)
class Landings:
    """The landings of a table, to be computed in parts.

    Attributes:
        scene: what the table does not give.
        robot: the robot.
        table: the rows.
        computed: the computed columns.
        prove: number of rows, evenly spaced, that are compared with a proof, besides those that need one.
    """

    scene: Scene
    robot: Robot = field(repr=False)
    table: Rows = field(repr=False)
    computed: tuple[Column, ...] = ()
    prove: int = 20

    noun, strikes = "table", 1

    def __getstate__(self) -> dict[str, Any]:
        return {key: getattr(self, key) for key in ("scene", "robot", "table", "computed", "prove")}

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.table.Q)

    @functools.cached_property
    def parts(self) -> tuple[tuple[int, int], ...]:
        """First and last row of every part, the last one excluded."""
        most = 1024 if self.first.loops else min(ROWS, max(1024, 2**25 // self.robot.model.nv**2))
        count = -(-self.rows // most)
        return tuple((self.rows * k // count, self.rows * (k + 1) // count) for k in range(count))

    @functools.cached_property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, without the message."""
        closing = (CLOSED_BY, RATES_BY) if self.first.loops else ()
        return ("row", *(column.name for column in self.computed), *closing, "condition", "proven", "double_error")

    @property
    def description(self) -> dict[str, Any]:
        """What the rows depend on, besides scene and robot."""
        table = self.table
        text = hashlib.sha256(np.ascontiguousarray(table.Q).tobytes())
        for part in (*table.before, table.contact, table.friction):
            text.update(b"" if part is None else np.ascontiguousarray(part).tobytes())
        return {"table": {"rows": len(table.Q), "sha256": text.hexdigest()}, "rows proven for comparison": self.prove}

    @functools.cached_property
    def first(self) -> PosedLanding:
        """The landing of the first row's contacts, in the scene's posture."""
        return self._landing(self._keys[0])

    @functools.cached_property
    def _keys(self) -> list[Key]:
        """What decides the landing of each row: contacts, and friction."""
        table = self.table
        contacts = [""] * self.rows if table.contact is None else map(str, table.contact)
        friction = [np.nan] * self.rows if table.friction is None else table.friction.tolist()
        return list(zip(contacts, friction, strict=True))

    @functools.lru_cache(maxsize=64)  # noqa: B019 - a study lives as long as its process
    def _landing(self, key: Key) -> PosedLanding:
        """The landing of rows of one key; whether they approach the ground is looked at later."""
        return resolve(self._scene(key), self.robot)

    def _scene(self, key: Key) -> Scene:
        scene, (contact, friction) = self.scene, key
        if contact:
            frames = landing_frames(self.robot, contact)
            if len(frames) > 1:
                raise StudyError(f'contact "{contact}" of a row means {len(frames)} landings; name the frames, with + between them')
            scene = replace(scene, contact=tuple(Contact(frame=frame) for frame in frames[0]))
        return scene if np.isnan(friction) else replace(scene, friction=friction)

    def chunk(self, k: int) -> Chunk:
        """Compute a part."""
        with one_thread(self.robot.model.nv):
            return self._chunk(*self.parts[k])

    def _chunk(self, a: int, b: int) -> Chunk:
        n = b - a
        found = {name: np.full(n, np.nan) for name in self.headings if name not in ("proven", "row")}
        posed = any(column.selection.quantity.posed for column in self.computed)
        prove, messages = np.full(n, posed), dict[int, str]()
        groups: dict[Key, list[int]] = {}
        for i, key in enumerate(self._keys[a:b]):
            groups.setdefault((key[0], np.nan) if np.isnan(key[1]) else key, []).append(i)
        Q, rates = self.table.Q[a:b].copy(), self.table.before.joint_rates[a:b].copy()
        before = Motion(self.table.before.velocity[a:b], self.table.before.omega[a:b], rates)
        for key, chosen in groups.items():
            try:
                landing = self._landing(key)
            except ShockError as error:
                messages |= dict.fromkeys(chosen, str(error))
                continue
            for i in chosen if landing.loops else ():
                try:
                    Q[i], rates[i], found[CLOSED_BY][i], found[RATES_BY][i] = self._closed(landing, Q[i], rates[i])
                except ShockError as error:
                    messages[i] = str(error)
            own = np.array([i for i in chosen if i not in messages], dtype=int)
            if not own.size:
                continue
            part, condition, unsafe, parting = columns(landing, Q[own], Motion(*(x[own] for x in before)), self.computed)
            for name, values in part.items():
                found[name][own] = values[:, 0]
            found["condition"][own] = condition
            prove[own] |= unsafe
            for i, _, c in np.argwhere(parting).tolist():
                text = f'contact "{landing.contacts[c].frame}" does not approach the ground, so there is no impact'
                messages.setdefault(int(own[i]), text)
        proven, checked = np.zeros(n, dtype=bool), {row - a for row in self._checked if a <= row < b}
        for i in sorted({*np.flatnonzero(prove).tolist(), *checked} - messages.keys()):
            try:
                profile = self._profile(a + i, Q[i], Motion(*(x[i] for x in before)))
                exact = proven_columns(profile, self.computed)
                double = {name: float(found[name][i]) for name in exact}
                found["double_error"][i] = double_difference(profile, double, exact, self.computed)
            except Exception as unexpected:
                messages[i] = str(refusal(unexpected))
                continue
            if prove[i]:
                proven[i] = True
                for name, value in exact.items():
                    found[name][i] = value
        for column in self.computed if messages else ():
            found[column.name][list(messages)] = np.nan
        names = {"row": self.table.names[a:b]}
        return Chunk(
            a, {name: (names | found | {"proven": proven})[name] for name in self.headings}, dict(sorted(messages.items()))
        )

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
        robot, blocks = self.robot, [closure_block(loop) for loop in landing.loops]
        others = np.zeros(robot.model.nv, dtype=bool)
        others[:6] |= robot.free_base
        chosen = {name for pattern in self.scene.assemble for name in robot.match_joints(pattern)}
        for name in robot.joint_names if chosen else ():
            others[robot.joint(name).v] |= name not in chosen
        try:
            closed = follow(robot, landing.q, q, landing.loops, landing.plane, others | self._held(self.table.joints))
        except SceneError:
            closed = assemble(robot, q, landing.loops, landing.plane, others).q
        changes = [
            abs(joint.value(closed) - joint.value(q)) for joint in map(robot.joint, self.table.joints) if joint.axis is not None
        ]
        by = max(changes, default=0.0)
        if by > OPEN:
            raise SceneError(
                f"the loops are open: closing them changes a joint that the table gives by {by:.3g} rad (m), and at most {OPEN:g} "
                "is taken for a measuring error; correct the table, or leave columns out with --map COLUMN="
            )
        # What is locked in the impact may have moved before it, and keeps its rate.
        state = dynamics(robot, closed[None])
        held = others | self._held([mimic.joint for mimic in robot.mimics])
        try:
            moving = with_loops(robot, state, blocks, rates, held | self._held(self.table.rates), landing.plane)
        except SceneError:
            moving = with_loops(robot, state, blocks, rates, held, landing.plane)
        return closed, moving, by, float(np.abs((moving - rates)[self._held(self.table.rates)]).max(initial=0.0))

    def _held(self, names: Sequence[str]) -> np.ndarray:
        """Which joint velocities (nv,) are of some joints."""
        held = np.zeros(self.robot.model.nv, dtype=bool)
        for name in names:
            held[self.robot.joint(name).v] = True
        return held

    def profile(self, row: int) -> ShockProfile:
        """The landing of one row, with a proof.

        Raises:
            ShockError: it cannot be computed.
        """
        landing = self.landing(row)
        return self._profile(row, landing.q, landing.before)

    def landing(self, row: int) -> PosedLanding:
        """The landing of one row, in whose configuration and motion the loops are closed.

        Raises:
            ShockError: they cannot be closed.
        """
        landing, before = self._landing(self._keys[row]), Motion(*(x[row] for x in self.table.before))
        q = self.table.Q[row]
        if landing.loops:
            q, rates, *_ = self._closed(landing, q, before.joint_rates)
            before = before._replace(joint_rates=rates)
        return replace(landing.at(q), before=before)

    def _profile(self, row: int, q: Array, before: Motion) -> ShockProfile:
        """The same with a proof, for a configuration and a motion in which the loops are closed."""
        landing = replace(self._landing(self._keys[row]).at(q), before=before)
        return profile_of(replace(landing, scene=self._written(landing)))

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
        named = [one for one in self.computed if one.selection == select(selection) and place in ("", one.place.name)]
        if len(named) != 1:
            raise StudyError(f'"{text}" means {listed((one.name for one in named), 6)}; name one of them')
        return named[0]

    def case(self, row: int) -> Scene:
        """The landing of one row as a scene."""
        return self.profile(row).landing.scene

    def _written(self, landing: PosedLanding) -> Scene:
        """The scene of a posed landing: with loops, the joints that the table gives, from which the others follow."""
        robot, q, before = self.robot, landing.q, landing.before
        followers = {mimic.joint for mimic in robot.mimics}
        names = [name for name in robot.joint_names if robot.joint(name).axis is not None and name not in followers]
        kept = [name for name in names if not landing.loops or name in self.table.joints]
        moving = [name for name in names if before.joint_rates[robot.joint(name).v].any()]
        posture, strike = landing.scene.posture, landing.scene.strike
        if robot.free_base:
            position, quaternion = tuple(q[:3].tolist()), tuple(q[3:7].tolist())
            posture = replace(posture, base_rpy_deg=None, base_position=position, base_quaternion=quaternion)
        posture = replace(posture, joints={name: robot.joint(name).value(q) for name in kept}, joints_deg={})
        strike = replace(
            strike, speed=None, strike_angle_deg=None, drop_height=None, velocity=tuple(before.velocity.tolist()),
            angular_velocity=tuple(before.omega.tolist()) if before.omega.any() else None,
            joint_velocities={name: float(before.joint_rates[robot.joint(name).v][0]) for name in moving},
        )  # fmt: skip
        return replace(landing.scene, posture=posture, strike=strike)


def landings(
    table: Mapping[str, np.ndarray],
    scene: Scene,
    quantities: Sequence[str] = (),
    *,
    robot: Robot | None = None,
    rename: Mapping[str, str] | None = None,
    prove: int = 20,
    ranked_by: str | None = None,
) -> Landings:
    """The landings of a table.

    Args:
        table: columns by name, as `read_table` gives them.
        scene: what the table does not give.
        quantities: columns, QUANTITY or QUANTITY@PLACES; by default jump and shock at the sensors and points, or of the base.
        robot: the scene's robot, if it is loaded already.
        rename: other names for columns of the table, as for `rows_of`.
        prove: number of rows that are compared with a proof, besides those that need one.
        ranked_by: a further column.

    Raises:
        ShockError: a name is not known, a number cannot be right, or the scene cannot be resolved.
    """
    robot = robot or robot_of(scene)
    made = Landings(scene, robot, rows_of(table, resolve(scene, robot), rename), (), prove)
    landing = made.first
    points = [place for place in landing.points if place.body >= 0]
    usual = [f"{key}@{place.name}" for place in points for key in ("delta_v", "shock")]
    usual = usual or [f"{key}@{robot.bodies[0].name}" for key in ("delta_v_com", "shock_com")]
    sets = list(dict.fromkeys(key[0] for key in made._keys))
    most = max(len(made._scene((contacts, np.nan)).contact) for contacts in sets)
    computed: list[Column] = []
    for text in dict.fromkeys([*(quantities or usual), *([ranked_by] if ranked_by else [])]):
        selection, places = selected(landing, text)
        if len(sets) > 1 and selection.quantity.of == "contact":
            if "@" in text:
                raise StudyError(f'the contact varies, so "{text}" cannot name one; leave the @ and what follows out')
            places = tuple(Place(f"contact {k + 1}", number=k) for k in range(most))
        if not places:
            raise StudyError(f'"{text}": there is no such place; links of the robot: {listed(robot.links, 6)}')
        computed += [Column(selection, place, asked=True) for place in places]
    return replace(made, computed=tuple({column.name: column for column in computed}.values()))


class Found(NamedTuple):
    """The computed landings of a table.

    Attributes:
        made: what was computed.
        columns: (n,) by heading, but the names of the rows.
        messages: why a row could not be computed, by its number.
    """

    made: Landings
    columns: Mapping[str, Array]
    messages: Mapping[int, str]

    @classmethod
    def read(cls, made: Landings, read: Callable[[str], Iterator[Any]]) -> "Found":
        """The landings of files. Args: read, heading of a column, or "message" → its parts in order."""
        columns = {name: np.concatenate(list(read(name))) for name in made.headings[1:]}
        return cls(made, columns, {i: text for i, text in enumerate(itertools.chain.from_iterable(read("message"))) if text})

    def ranked(self, column: Column | None) -> list[int]:
        """The rows, the worst value of a column first, those without one last; in the order of the table without a column."""
        if column is None:
            return list(range(self.made.rows))
        values = np.abs(self.columns[column.name])
        worst = values if column.selection.quantity.worse == "less" else -values
        return [int(i) for i in np.argsort(worst, kind="stable")]


def compute(made: Landings, executor: Executor | None = None, done: Callable[..., None] = lambda parts: None) -> Found:
    """Compute all landings of a table.

    Args:
        made: the landings.
        executor: computes the parts; this process by default.
        done: is called with the number of rows of each part that is done.
    """
    chunks: list[Chunk] = []
    for chunk in in_order(executor, functools.partial(with_sweep, pickle.dumps(made), Landings.chunk), range(len(made.parts))):
        chunks.append(chunk)
        done(parts=len(chunk.columns["proven"]))
    columns = {name: np.concatenate([chunk.columns[name] for chunk in chunks]) for name in made.headings[1:]}
    return Found(made, columns, {chunk.first + i: text for chunk in chunks for i, text in chunk.messages.items()})
