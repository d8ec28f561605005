"""The rows of a sweep, part by part: many landings that differ in posture, strike, contact, inertia or joint model.

Changes of the strike are products with the maps of a posture, changes of the posture and of inertias are rows of one array, and
only the others need a landing of their own. Rows that need it are proven one by one, and so is a random sample of the others.
"""

import functools
import math
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, cast

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.evaluation.columns import Column, columns, not_approaching, prove_rows
from shockpc.evaluation.executor import in_order
from shockpc.evaluation.variation import ATTITUDE, INERTIAL, OF_A_LINK, Variation
from shockpc.evaluation.varied_scene import applied, armature_set, robot_changes
from shockpc.landing.dynamics import Design
from shockpc.landing.landing import PosedLanding, following, resolve
from shockpc.landing.posture import set_many
from shockpc.landing.scene import GRAVITY, Scene
from shockpc.profile import shock_profile
from shockpc.quantities.profile import ShockProfile
from shockpc.robot.changes import Change, Property, changed, varied_bodies
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError, refusal

GROUND = ("friction_needed", "pull", "depth", "feasible")
"""Quantities of every row that tell whether flat ground allows the landing."""

ROWS = 16384
"""Largest number of rows of a part."""

FINISHED = 4096
"""Rows whose columns are computed together."""

DEG = math.pi / 180.0


class Chunk(NamedTuple):
    """Some consecutive rows of a sweep.

    Attributes:
        first: number of the first row in the sweep.
        columns: (n,) by heading: what was varied, then what was computed; NaN where a thing does not exist. "proven" tells which
            rows hold proven numbers; "double_error" is how far double precision was off where it was compared with a proof,
            relative to the most severe shock of the same point. "row" is the number of the row, if some are left out.
        messages: why a row could not be computed, by its index in the chunk.
        refused: of a sweep, numbers of rows that flat ground does not allow, left out or not: those in which it would pull a
            contact, and the others, in which another link is below it.
    """

    first: int
    columns: dict[str, Any]
    messages: dict[int, str]
    refused: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Sweep:
    """A sweep, complete and checked.

    Attributes:
        scene: the landing that is varied.
        robot: its robot.
        variations: what differs between rows.
        computed: the computed columns.
        feasible: whether rows that flat ground does not allow are left out.
        sample: number of random rows; None for the full grid.
        lhs: whether they are a Latin hypercube.
        seed: of the random numbers.
        prove: number of random rows to prove besides those that need it.
    """

    scene: Scene
    robot: Robot = field(repr=False)
    variations: tuple[Variation, ...]
    computed: tuple[Column, ...] = field(repr=False)
    feasible: bool = False
    sample: int | None = None
    lhs: bool = False
    seed: int = 0
    prove: int = 100

    noun = "sweep"

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}

    def __iter__(self) -> Iterator[Chunk]:
        return self.chunks()

    def chunks(self, executor: Executor | None = None) -> Iterator[Chunk]:
        """All parts in order. Args: executor, computes them, for example a `ProcessPoolExecutor`; this process by default."""
        return in_order(executor, functools.partial(with_sweep, pickle.dumps(self), Sweep.chunk), range(len(self.parts)), ahead=8)

    @functools.cached_property
    def sizes(self) -> tuple[int, ...]:
        """Number of values of each variation in the grid, in the order of `axes`."""
        return tuple(len(variation.values) for variation in self.axes)

    @functools.cached_property
    def axes(self) -> tuple[Variation, ...]:
        """The variations from the slowest to the fastest: other landings, other postures and inertias, other strikes."""
        return tuple(sorted(self.variations, key=lambda variation: variation.stage))

    @property
    def strikes(self) -> int:
        """Number of strikes for each posture; those of a sample differ from row to row."""
        if self.sample is not None:
            return 1
        return math.prod(n for variation, n in zip(self.axes, self.sizes, strict=True) if variation.stage == 2)

    @property
    def solves(self) -> int:
        """Number of postures of all landings."""
        return self.sample if self.sample is not None else math.prod(self.sizes) // self.strikes

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.solves * self.strikes

    @functools.cached_property
    def alone(self) -> bool:
        """Whether every posture needs a landing of its own, because loops have to be closed."""
        return bool(self.first.loops)

    @functools.cached_property
    def parts(self) -> tuple[tuple[int, int], ...]:
        """First and last posture of every part, the last one excluded. They do not depend on who computes them."""
        nv = self.robot.model.nv
        rows = min(ROWS, max(1024, 2**25 // nv**2))
        if self.alone or (
            self.sample is not None and any(variation.stage == 0 and variation.kind != "contact" for variation in self.axes)
        ):
            rows = 1024
        most, n = max(1, rows // self.strikes), self.solves
        count = -(-n // most)
        return tuple((n * k // count, n * (k + 1) // count) for k in range(count))

    @property
    def description(self) -> dict[str, Any]:
        """What the rows depend on, besides scene and robot."""
        return {
            "vary": [
                {key: getattr(variation, key) for key in ("subject", "values", "span", "law", "factor")}
                for variation in self.variations
            ],
            "feasible rows alone": self.feasible,
            "sample": self.sample,
            "latin hypercube": self.lhs,
            "seed": self.seed,
            "rows proven for comparison": self.prove,
        }

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, without the message."""
        varied = [variation.column for variation in self.variations]
        return (*(["row"] if self.feasible else []), *varied, *self._names, "condition", "proven", "double_error")

    @property
    def feasible_column(self) -> str:
        """The name of the column that tells whether flat ground allows the landing; empty where that is not computed."""
        return next((column.name for column in self.computed if column.selection.name == "feasible"), "")

    @functools.cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(column.name for column in self.computed)

    @property
    def _pulls(self) -> list[str]:
        """The columns that tell whether the ground would have to pull; with friction a contact opens instead."""
        opens = self.scene.friction is not None or any(one.kind == "friction" for one in self.variations)
        return [column.name for column in self.computed if column.selection.name == "pull" and not opens]

    def chunk(self, k: int) -> Chunk:
        """Compute a part."""
        with one_thread(self.robot.model.nv):
            return self._chunk(k)

    def configurations(self, k: int) -> Array:
        """Configurations (m, nq) of a part, if all of its rows are of one landing."""
        return self._postures(self.first, self._values(k), np.arange(self.parts[k][1] - self.parts[k][0]))

    def case(self, row: int) -> tuple[Scene, Robot]:
        """The landing of one row, as `shock_profile` takes it.

        Raises:
            ShockError: there is no such landing.
        """
        return self._case(self.values_of(row))

    def values_of(self, row: int) -> dict[Variation, Any]:
        """What was varied, in one row."""
        part = next(k for k, (_, end) in enumerate(self.parts) if row < end * self.strikes)
        return _picked(self._values(part), *divmod(row - self.parts[part][0] * self.strikes, self.strikes))

    def _chunk(self, k: int) -> Chunk:
        (a, b), S = self.parts[k], self.strikes
        m, values = b - a, self._values(k)
        varied_columns: dict[str, Any] = {
            variation.column: np.broadcast_to(values[variation], (m, S)).ravel() for variation in self.variations
        }
        computed = {name: np.full((m, S), np.nan) for name in (*self._names, "condition")}
        prove, messages = np.zeros((m, S), dtype=bool), dict[int, str]()
        for chosen, landing in self._landings(values, m):
            if isinstance(landing, ShockError):
                messages |= {int(i) * S + s: str(landing) for i in chosen for s in range(S)}
                continue
            for begin in range(0, len(chosen), FINISHED):
                own = chosen[begin : begin + FINISHED]
                Q, strikes = self._postures(landing, values, own), self._strikes(landing, values, own)
                design, refused = self._design(landing, values, own)
                messages |= {int(own[i]) * S + s: text for i, text in refused.items() for s in range(S)}
                part, condition, unsafe, parting = columns(landing, Q, strikes, self.computed, design)
                for name, x in (part | {"condition": condition[:, None]}).items():
                    computed[name][own] = x
                prove[own] = unsafe | any(column.selection.quantity.alone(landing.scene) for column in self.computed)
                for i, s, text in not_approaching(landing, parting):
                    messages.setdefault(int(own[i]) * S + s, text)
        flat = {name: x.ravel() for name, x in computed.items()}
        compared = self._checked[(self._checked >= a * S) & (self._checked < b * S)] - a * S
        feasible = flat.get(self.feasible_column, np.ones(m * S))
        if self.feasible:
            compared = compared[feasible[compared] != 0.0]

        def profile(i: int) -> ShockProfile:
            return shock_profile(*self._case(_picked(values, *divmod(i, S))))

        proven, error = prove_rows(prove.ravel(), compared.tolist(), profile, self.computed, flat, messages)
        infeasible = feasible == 0.0
        pulled = infeasible & np.any([flat[name] > 0.0 for name in self._pulls], axis=0)
        counts = int(pulled.sum()), int((infeasible & ~pulled).sum())
        whole = varied_columns | flat | {"proven": proven, "double_error": error}
        if self.feasible:
            kept = np.flatnonzero(~infeasible)
            whole = {"row": a * S + kept} | {name: x[kept] for name, x in whole.items()}
            messages = {int(np.searchsorted(kept, i)): text for i, text in messages.items()}
        return Chunk(a * S, whole, dict(sorted(messages.items())), counts)

    @functools.cached_property
    def _checked(self) -> np.ndarray:
        """The rows (n,) that are proven to see how far double precision is off."""
        return np.random.default_rng([self.seed, 2]).choice(self.rows, min(self.prove, self.rows), replace=False, shuffle=False)

    def _values(self, k: int) -> dict[Variation, np.ndarray]:
        a, b = self.parts[k]
        if self.sample is None:
            outer = tuple(n for variation, n in zip(self.axes, self.sizes, strict=True) if variation.stage < 2)
            inner = self.sizes[len(outer) :]
            solve = np.unravel_index(np.arange(a, b), outer) if outer else ()
            strike = np.unravel_index(np.arange(self.strikes), inner) if inner else ()
            places = [i[:, None] for i in solve] + [i[None, :] for i in strike]
            return {variation: np.asarray(variation.values)[i] for variation, i in zip(self.axes, places, strict=True)}
        u = np.random.default_rng([self.seed, 1, k]).random((len(self.axes), b - a))
        if self.lhs:
            u = (u + [_strata(self.sample, np.arange(a, b), self.seed, j) for j in range(len(u))]) / self.sample
        return {variation: variation.drawn(own)[:, None] for variation, own in zip(self.axes, u, strict=True)}

    def _landings(self, values: dict[Variation, np.ndarray], m: int) -> "Iterator[tuple[np.ndarray, PosedLanding | ShockError]]":
        choices = {
            variation: x[:, 0] for variation, x in values.items() if variation.stage < 2 and (variation.stage == 0 or self.alone)
        }
        codes = [np.arange(m) if self.alone else np.zeros(m, dtype=int)]
        codes += [np.unique(x, return_inverse=True)[1] for x in choices.values()]
        _, code = np.unique(np.stack(codes), axis=1, return_inverse=True)
        order = np.argsort(code.ravel(), kind="stable")
        for group in np.split(order, np.flatnonzero(np.diff(code.ravel()[order])) + 1):
            try:
                yield group, resolve(*self._case({variation: x[group[0]] for variation, x in choices.items()}))
            except Exception as error:
                yield group, refusal(error)

    @functools.cached_property
    def first(self) -> PosedLanding:
        """The first of all landings."""
        return resolve(
            *self._case(
                {variation: (variation.values or variation.span or ())[0] for variation in self.axes if variation.stage == 0}
            )
        )

    def _postures(self, landing: PosedLanding, values: dict[Variation, np.ndarray], own: np.ndarray) -> Array:
        """Configurations (n, nq) of some rows of a part."""
        Q = np.repeat(landing.q[None], len(own), axis=0)
        if self.alone:
            return Q
        moved = {variation: x[own, 0].astype(float) for variation, x in values.items() if variation.moves}
        angles = {variation.kind: x for variation, x in moved.items() if variation.kind != "joint"}
        if angles:
            from scipy.spatial.transform import Rotation

            given = dict(zip(ATTITUDE, landing.scene.posture.base_rpy_deg or (0.0, 0.0, 0.0), strict=True)) | angles
            rpy = np.stack([np.broadcast_to(given[kind], len(own)) for kind in ATTITUDE], axis=1)
            Q[:, 3:7] = Rotation.from_euler("xyz", rpy, degrees=True).as_quat()
        joints = [
            (joint, x) for variation, x in moved.items() if variation.kind == "joint" for joint in variation.joints(self.robot)
        ]
        set_many(self.robot, [(joint, x if joint.kind == "prismatic" else x * DEG) for joint, x in joints], Q)
        return Q

    def _design(
        self, landing: PosedLanding, values: dict[Variation, np.ndarray], own: np.ndarray
    ) -> tuple[Design | None, dict[int, str]]:
        """The inertias of some rows of a part; None where all have the landing's own. And why no robot has those of a row."""
        varied = [variation for variation in values if variation.kind in INERTIAL]
        if not varied or self.alone:
            return None, {}
        x = {variation: values[variation][own, 0].astype(float) for variation in varied}
        bodies = varied_bodies(
            landing.robot,
            [
                (cast(Property, variation.kind), variation.target, x[variation], variation.factor)
                for variation in varied
                if variation.kind in OF_A_LINK
            ],
        )
        armature = np.repeat(landing.joint_model.armature[None], len(own), axis=0)
        for variation in varied:
            if variation.kind == "armature":
                chosen = armature_set(landing.scene, self.robot, variation)
                armature[:, chosen] = x[variation][:, None] * (armature[:, chosen] if variation.factor else 1.0)
        mass, com, inertia = (np.broadcast_to(part, (len(own), *part.shape[1:])) for part in bodies)
        refused = {}
        with np.errstate(all="ignore"):
            plausible = (np.where(mass > 0.0, mass, 1.0) > 1e-14) & (mass < 1e23) & (np.abs(inertia).max(axis=(-1, -2)) < 1e23)
        for i in np.flatnonzero(~plausible.all(axis=1)).tolist():
            try:
                self._case({variation: row[i] for variation, row in x.items()})
            except ShockError as error:
                refused[i] = str(error)
        return Design(mass, com, inertia, armature), refused

    def _strikes(self, landing: PosedLanding, values: dict[Variation, np.ndarray], own: np.ndarray) -> Array:
        varied = {variation.kind: x if self.sample is None else x[own] for variation, x in values.items() if variation.stage == 2}
        if not varied:
            return np.broadcast_to(landing.before.velocity, (len(own), self.strikes, 3))
        strike = landing.scene.strike
        speed = varied.get("speed", np.array([[1.0 if strike.speed is None else strike.speed]]))
        theta = varied.get("strike-angle", np.array([[strike.strike_angle_deg or 0.0]])) * DEG
        if strike.drop_height is not None:
            speed = math.sqrt(2.0 * GRAVITY * strike.drop_height) / np.cos(theta)
        up = np.array([0.0, 0.0, 1.0])
        velocity = speed[..., None] * (np.sin(theta)[..., None] * landing.plane.forward - np.cos(theta)[..., None] * up)
        return np.broadcast_to(velocity, (len(own), self.strikes, 3))

    def _case(self, choice: dict[Variation, Any]) -> tuple[Scene, Robot]:
        scene, robot, changes = self.scene, self.robot, list[Change]()
        for variation, value in choice.items():
            if own := robot_changes(robot, variation, value):
                changes += own
            else:
                scene, robot = applied(scene, robot, variation, value)
        if changes:
            robot = changed(robot, changes)  # at once, as each robot reads the places of its frames anew
        if any(variation.moves for variation in choice) and self.alone:
            scene = following(scene, self.first)
        return scene, robot


def with_sweep(pickled: bytes, function: Callable[[Any, int], Any], k: int) -> Any:
    """Call a function with a sweep and the number of a part, in whatever process this is."""
    return function(_unpickled(pickled), k)


@functools.lru_cache(maxsize=2)
def _unpickled(pickled: bytes) -> Any:
    return pickle.loads(pickled)


def _picked(values: dict[Variation, np.ndarray], solve: int, strike: int) -> dict[Variation, Any]:
    """The values of one row."""
    return {variation: x[solve if len(x) > 1 else 0, strike if x.shape[1] > 1 else 0] for variation, x in values.items()}


def _strata(n: int, rows: np.ndarray, seed: int, number: int) -> np.ndarray:
    """The strata of some rows: a permutation of all n rows of which each part is computed alone.

    A Feistel network permutes the numbers of 2 b bits, at least n of them; a number that leaves [0, n) is permuted until it comes
    back (Black and Rogaway 2002, "Ciphers with arbitrary finite domains").

    Args:
        n: number of rows.
        rows: (m,) their numbers.
        seed: of the random numbers.
        number: of the quantity, each of which has a permutation of its own.
    """
    bits = np.uint64(max(1, -(-(n - 1).bit_length() // 2)))
    low = np.uint64((1 << int(bits)) - 1)
    keys = np.random.default_rng([seed, 3, number]).integers(2**64, size=8, dtype=np.uint64)
    out, outside = rows.astype(np.uint64), np.ones(len(rows), dtype=bool)
    while outside.any():
        left, right = out[outside] >> bits, out[outside] & low
        for key in keys:
            # The mixing function of splitmix64 (Steele, Lea and Flood 2014).
            x = right + key
            x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            left, right = right, left ^ ((x ^ (x >> np.uint64(31))) & low)
        out[outside] = left << bits | right
        outside = out >= n
    return out.astype(np.int64)
