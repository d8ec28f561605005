"""Many landings that differ in posture, strike, contact, inertia or joint model: a full grid, or a sample.

Changes of the strike are products with the maps of a posture, changes of the posture are rows of one array, and only the others
need a landing of their own. Rows that ask for it are proven one by one, and so is a random sample of the others.
"""

import functools
import math
import pickle
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.errors import ShockError, StudyError, UnknownName
from shockpc.executor import in_order
from shockpc.landing import Landing, resolve
from shockpc.profile import shock_profile
from shockpc.results.geometry import body_pieces
from shockpc.robot.robot import Robot
from shockpc.scene import Point, Scene, plane_of, robot_of
from shockpc.studies.question import moving_spot
from shockpc.studies.sweep.case import applied
from shockpc.studies.sweep.columns import Targets, columns, proven_columns, solve
from shockpc.studies.sweep.variation import ATTITUDE, Variation, each_of, variation

__all__ = ["Chunk", "Sweep", "sweep", "sweep_of", "with_sweep"]

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
            rows hold proven numbers; "double error [-]" is how far double precision was off where it was compared with a proof,
            relative to the most severe shock of the same point.
        messages: why a row could not be computed, by its index in the chunk.
    """

    first: int
    columns: dict[str, Any]
    messages: dict[int, str]


@dataclass(frozen=True, eq=False)
class Sweep:
    """A sweep, complete and checked.

    Attributes:
        scene: the landing that is varied.
        robot: its robot.
        variations: what differs between rows.
        targets: what the columns are about.
        sample: number of random rows; None for the full grid.
        lhs: whether they are a Latin hypercube.
        seed: of the random numbers.
        prove: number of random rows to prove besides those that ask for it.
    """

    scene: Scene
    robot: Robot = field(repr=False)
    variations: tuple[Variation, ...]
    targets: Targets = field(repr=False)
    sample: int | None = None
    lhs: bool = False
    seed: int = 0
    prove: int = 100

    def __getstate__(self) -> dict[str, Any]:
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @functools.cached_property
    def sizes(self) -> tuple[int, ...]:
        """Number of values of each variation in the grid, in the order of `axes`."""
        return tuple(len(one.values) for one in self.axes)

    @functools.cached_property
    def axes(self) -> tuple[Variation, ...]:
        """The variations from the slowest to the fastest: other landings, other postures, other strikes."""
        return tuple(sorted(self.variations, key=lambda one: one.stage))

    @property
    def strikes(self) -> int:
        """Number of strikes for each posture; those of a sample differ from row to row."""
        if self.sample is not None:
            return 1
        return math.prod(n for one, n in zip(self.axes, self.sizes, strict=True) if one.stage == 2)

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
        return bool(self._first.loops)

    @functools.cached_property
    def parts(self) -> tuple[tuple[int, int], ...]:
        """First and last posture of every part, the last one excluded. They do not depend on who computes them."""
        nv = self.robot.model.nv
        rows = min(ROWS, max(1024, 2**25 // nv**2))
        if self.alone or (self.sample is not None and any(one.stage == 0 and one.kind != "contact" for one in self.axes)):
            rows = 1024
        most, n = max(1, rows // self.strikes), self.solves
        least = -(-n // most)
        # Parts of one size, where the number of rows allows it, make Latin hypercubes of parts one of all rows.
        count = next((k for k in range(least, 2 * least) if n % k == 0), least)
        return tuple((n * k // count, n * (k + 1) // count) for k in range(count))

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of all columns, without the message."""
        return (*(one.column for one in self.variations), *self.targets.headings(self.robot), "proven", "double error [-]")

    def chunk(self, k: int) -> Chunk:
        """Compute a part."""
        with one_thread(self.robot.model.nv):
            return self._chunk(k)

    def configurations(self, k: int) -> Array:
        """Configurations (m, nq) of a part, if all of its rows are of one landing."""
        return self._postures(self._first, self._values(k), np.arange(self.parts[k][1] - self.parts[k][0]))

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
        found: dict[str, Any] = {one.column: np.broadcast_to(values[one], (m, S)).ravel() for one in self.variations}
        computed = {name: np.full((m, S), np.nan) for name in self.targets.headings(self.robot)}
        prove, messages = np.zeros((m, S), dtype=bool), dict[int, str]()
        for chosen, landing in self._landings(values, m):
            if isinstance(landing, ShockError):
                messages |= {int(i) * S + s: str(landing) for i in chosen for s in range(S)}
                continue
            for begin in range(0, len(chosen), FINISHED):
                own = chosen[begin : begin + FINISHED]
                solved = solve(landing, self._postures(landing, values, own), self.targets)
                strikes = self._strikes(landing, values, own)
                part, parting = columns(landing, solved, strikes, self.targets)
                for name, x in part.items():
                    computed[name][own] = x
                prove[own] = solved.prove[:, None]
                for i, s, c in np.argwhere(parting).tolist():
                    text = f'contact "{landing.contacts[c].frame}" does not approach the ground, so there is no impact'
                    messages.setdefault(int(own[i]) * S + s, text)
        flat = {name: x.ravel() for name, x in computed.items()}
        flagged = np.flatnonzero(prove.ravel())
        proven, error = np.zeros(m * S, dtype=bool), np.full(m * S, np.nan)
        checked = self._checked[(self._checked >= a * S) & (self._checked < b * S)] - a * S
        for i in sorted({*flagged.tolist(), *checked.tolist()} - messages.keys()):
            try:
                exact = proven_columns(shock_profile(*self._case(_picked(values, *divmod(i, S)))), self.targets)
            except ShockError as refusal:
                messages[i] = str(refusal)
                continue
            error[i] = self._difference({name: float(flat[name][i]) for name in exact}, exact)
            if prove.ravel()[i]:
                proven[i] = True
                for name, value in exact.items():
                    flat[name][i] = value
        for name in flat:
            if messages and name != "condition [-]":
                flat[name][list(messages)] = np.nan
        return Chunk(a * S, found | flat | {"proven": proven, "double error [-]": error}, dict(sorted(messages.items())))

    def _difference(self, double: dict[str, float], exact: dict[str, float]) -> float:
        """Largest difference of a shock, relative to the most severe one of the same point."""
        largest = 0.0
        for name in self.targets.shock_headings(self.robot):
            label = name.removesuffix(" shock [-]").removesuffix(" shock at CoM [-]").removesuffix(" greatest")
            severe = exact.get(f"{label} most severe shock [-]", exact.get(f"{label} CoM most severe shock [-]", 0.0))
            size = max(severe, abs(exact[name]))
            off = abs(double[name] - exact[name]) / size if size > 0.0 else abs(double[name])
            largest = max(largest, off) if not math.isnan(off) else math.inf if not math.isnan(exact[name]) else largest
        return largest

    @functools.cached_property
    def _checked(self) -> np.ndarray:
        """The rows (n,) that are proven to see how far double precision is off."""
        return np.random.default_rng([self.seed, 2]).choice(self.rows, min(self.prove, self.rows), replace=False, shuffle=False)

    def _values(self, k: int) -> dict[Variation, np.ndarray]:
        """The values of a part: (m, 1), or (1, S) for strikes of a grid."""
        a, b = self.parts[k]
        if self.sample is None:
            outer = tuple(n for one, n in zip(self.axes, self.sizes, strict=True) if one.stage < 2)
            inner = self.sizes[len(outer) :]
            solve = np.unravel_index(np.arange(a, b), outer) if outer else ()
            strike = np.unravel_index(np.arange(self.strikes), inner) if inner else ()
            places = [i[:, None] for i in solve] + [i[None, :] for i in strike]
            return {one: np.asarray(one.values)[i] for one, i in zip(self.axes, places, strict=True)}
        n, d = b - a, len(self.axes)
        rng = np.random.default_rng([self.seed, 1, k])
        u = _hypercube(n, d, k, len(self.parts), [self.seed, 1], rng) if self.lhs else rng.random((d, n)).T
        found: dict[Variation, np.ndarray] = {}
        for j, one in enumerate(self.axes):
            if one.span is None:
                x: np.ndarray = np.asarray(one.values)[np.minimum((u[:, j] * len(one.values)).astype(int), len(one.values) - 1)]
            else:
                x = one.span[0] + (one.span[1] - one.span[0]) * u[:, j]
            found[one] = x[:, None]
        return found

    def _landings(self, values: dict[Variation, np.ndarray], m: int) -> "Iterator[tuple[np.ndarray, Landing | ShockError]]":
        """The landings of a part, each with the postures (n,) that belong to it."""
        choices = {one: x[:, 0] for one, x in values.items() if one.stage < 2 and (one.stage == 0 or self.alone)}
        codes = [np.arange(m) if self.alone else np.zeros(m, dtype=int)]
        codes += [np.unique(x, return_inverse=True)[1] for x in choices.values()]
        _, code = np.unique(np.stack(codes), axis=1, return_inverse=True)
        order = np.argsort(code.ravel(), kind="stable")
        for group in np.split(order, np.flatnonzero(np.diff(code.ravel()[order])) + 1):
            try:
                yield group, self._landing({one: x[group[0]] for one, x in choices.items()})
            except ShockError as refusal:
                yield group, refusal

    def _landing(self, choice: dict[Variation, Any]) -> Landing:
        return resolve(*self._case(choice))

    @functools.cached_property
    def _first(self) -> Landing:
        """The first of all landings."""
        return self._landing({one: (one.values or one.span or ())[0] for one in self.axes if one.stage == 0})

    def _postures(self, landing: Landing, values: dict[Variation, np.ndarray], own: np.ndarray) -> Array:
        """Configurations (n, nq) of some rows of a part."""
        Q = np.repeat(landing.q[None], len(own), axis=0)
        if self.alone:
            return Q
        moved = {one: x[own, 0].astype(float) for one, x in values.items() if one.stage == 1}
        angles = {one.kind: x for one, x in moved.items() if one.kind != "joint"}
        if angles:
            given = dict(zip(ATTITUDE, landing.scene.posture.base_rpy_deg or (0.0, 0.0, 0.0), strict=True)) | angles
            Q[:, 3:7] = _quaternion(*(0.5 * DEG * np.broadcast_to(given[kind], len(own)) for kind in ATTITUDE))
        for one, x in moved.items():
            for name in one.joints(self.robot) if one.kind == "joint" else ():
                joint = self.robot.joint(name)
                _set(Q, joint.q, joint.kind, x if joint.kind == "prismatic" else x * DEG)
        for mimic in self.robot.mimics:
            follower, led = self.robot.joint(mimic.joint), np.full(len(own), mimic.offset)
            for name, multiplier in mimic.leaders.items():
                cosine, *sine = Q[:, self.robot.joint(name).q].T
                led += multiplier * (np.arctan2(sine[0], cosine) if sine else cosine)
            _set(Q, follower.q, follower.kind, led)
        return Q

    def _strikes(self, landing: Landing, values: dict[Variation, np.ndarray], own: np.ndarray) -> Array:
        """Velocities (n, S, 3) of the base before the impact."""
        varied = {one.kind: x if self.sample is None else x[own] for one, x in values.items() if one.stage == 2}
        if not varied:
            return np.broadcast_to(landing.before.velocity, (len(own), self.strikes, 3))
        strike = landing.scene.strike
        speed = varied.get("speed", np.array([[1.0 if strike.speed is None else strike.speed]]))
        theta = varied.get("strike-angle", np.array([[strike.strike_angle_deg or 0.0]])) * DEG
        up = np.array([0.0, 0.0, 1.0])
        velocity = speed[..., None] * (np.sin(theta)[..., None] * landing.plane.forward - np.cos(theta)[..., None] * up)
        return np.broadcast_to(velocity, (len(own), self.strikes, 3))

    def _case(self, choice: dict[Variation, Any]) -> tuple[Scene, Robot]:
        """The scene and the robot with some values set."""
        scene, robot = self.scene, self.robot
        for one, value in choice.items():
            scene, robot = applied(scene, robot, one, value)
        return scene, robot


def _picked(values: dict[Variation, np.ndarray], solve: int, strike: int) -> dict[Variation, Any]:
    """The values of one row."""
    return {one: x[solve if len(x) > 1 else 0, strike if x.shape[1] > 1 else 0] for one, x in values.items()}


def _set(Q: Array, place: slice, kind: str, x: Array) -> None:
    """Set a joint of one coordinate in many postures [rad, m]."""
    Q[:, place] = np.stack([np.cos(x), np.sin(x)] if kind == "continuous" else [x], axis=1)


def _quaternion(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Quaternions (n, 4) in the order x, y, z, w, from half the angles about the world's fixed x, y and z [rad]."""
    (a, b, c), (x, y, z) = (np.cos(half) for half in (roll, pitch, yaw)), (np.sin(half) for half in (roll, pitch, yaw))
    return np.stack([x * b * c - a * y * z, a * y * c + x * b * z, a * b * z - x * y * c, a * b * c + x * y * z], axis=-1)


def _hypercube(n: int, d: int, k: int, parts: int, seed: Sequence[int], rng: np.random.Generator) -> Array:
    """Part k of a Latin hypercube (n, d): a hypercube of n strata, each of which is divided between the parts."""
    from scipy.stats.qmc import LatinHypercube

    centre: Array = LatinHypercube(d, scramble=False, rng=rng).random(n)
    stratum = np.floor(centre * n)
    shift = np.random.default_rng(seed).integers(parts, size=(n + 1, d))
    inner = (shift[stratum.astype(int), np.arange(d)] + k) % parts
    return np.asarray((stratum + (inner + rng.random((n, d))) / parts) / n)


def sweep_of(
    scene: Scene,
    robot: Robot,
    vary: Mapping[str, Any] | Iterable[tuple[str, Any]] = (),
    *,
    vary_each: Mapping[str, Any] | Iterable[tuple[str, Any]] = (),
    at: Sequence[Point | str] = (),
    bodies: Sequence[str] = (),
    greatest: bool = False,
    sample: int | None = None,
    lhs: bool = False,
    seed: int = 0,
    prove: int = 100,
) -> Sweep:
    """A sweep, checked.

    Args:
        scene: the landing that is varied.
        robot: its robot.
        vary: values by subject, as in `variation`.
        vary_each: the same, with a quantity of its own for each joint that a pattern matches.
        at: points, as `Point` or names of frames.
        bodies: names of bodies; the base by default, if there are no points either.
        greatest: whether to add the greatest shock over the geometry of the bodies.
        sample: number of random rows instead of the full grid. If no joint is varied, all are, within their limits.
        lhs: whether the sample is a Latin hypercube.
        seed: of the random numbers.
        prove: number of random rows that are compared with a proof, besides those that need one.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be resolved.
    """
    # A mapping holds each subject once; pairs may repeat one, which is refused below.
    vary, vary_each = (given.items() if isinstance(given, Mapping) else given for given in (vary, vary_each))
    found = [variation(robot, subject, values) for subject, values in vary]
    found += [one for subject, values in vary_each for one in each_of(robot, variation(robot, subject, values))]
    if sample is not None:
        if sample < 1:
            raise StudyError(f"a sample of {sample} rows is empty; give a number above zero")
        if not any(one.kind == "joint" for one in found):
            found += _all_joints(robot)
    elif lhs:
        raise StudyError("a Latin hypercube is a sample; give its number of rows with --sample")
    if not found:
        raise StudyError("nothing varies; name a joint or another quantity with --vary, or draw random postures with --sample")
    found = [part for one in found for part in ((one,) if one.values or one.span else each_of(robot, one))]
    found = [_complete(robot, one, sample is not None) for one in found]
    _refuse_twice(robot, found)
    if scene.posture.base_quaternion is not None and any(one.kind.startswith("base-") for one in found):
        raise StudyError("the base's attitude is varied, but the scene gives it as a quaternion; give base_rpy_deg instead")
    points = tuple(Point(frame=point) if isinstance(point, str) else point for point in at)
    scene = replace(scene, point=points)
    made = Sweep(scene, robot, tuple(found), _targets(robot, points, bodies, greatest), sample, lhs, seed, prove)
    plane = plane_of(scene)
    for one in made.axes:
        for value in (one.values or one.span or ()) if one.stage == 2 else ():
            applied(scene, robot, one, value)[0].strike.vector(plane)
    _ = made._first
    return made


def sweep(
    scene: Scene,
    vary: Mapping[str, Any] | Iterable[tuple[str, Any]] = (),
    *,
    robot: Robot | None = None,
    executor: Executor | None = None,
    **options: Any,
) -> Iterator[Chunk]:
    """Compute many landings that differ from one; yield them in chunks of some ten thousand rows, in order.

    Args:
        scene: the landing that is varied.
        vary: values by subject, as in `variation`: {"*_KFE": "-120:-10:200", "strike-angle": [0, 15, 30]}.
        robot: the scene's robot, if it is loaded already.
        executor: computes chunks, for example a `ProcessPoolExecutor`; this process by default.
        **options: of `sweep_of`.

    Raises:
        ShockError: a name is not known, values do not fit, nothing varies, or the landing cannot be resolved. A row that cannot be
            computed is no error: its message is in the chunk.
    """
    robot = robot or robot_of(scene)
    made = sweep_of(scene, robot, vary, **options)
    return in_order(
        executor,
        functools.partial(with_sweep, pickle.dumps(made), _chunk_of),
        range(len(made.parts)),
        ahead=8,
    )


def with_sweep(pickled: bytes, function: Callable[[Sweep, int], Any], k: int) -> Any:
    """Call a function with a sweep and the number of a part, in whatever process this is."""
    return function(_unpickled(pickled), k)


def _chunk_of(made: Sweep, k: int) -> Chunk:
    return made.chunk(k)


@functools.lru_cache(maxsize=2)
def _unpickled(pickled: bytes) -> Sweep:
    """A sweep; reading it takes longer than a small part."""
    made: Sweep = pickle.loads(pickled)
    return made


def _targets(robot: Robot, points: tuple[Point, ...], names: Sequence[str], greatest: bool) -> Targets:
    """What the columns are about: the points and bodies that are named, or the base."""
    asked = (moving_spot(robot, point) for point in points)
    chosen = tuple({spot.label: spot for spot in asked}.values())
    indices = []
    for name in names:
        found = next((i for i, body in enumerate(robot.bodies) if name == body.name or name in body.links), None)
        if found is None:
            raise UnknownName("body", name, robot.links, f'robot "{robot.name}"', f"shockpc robots {robot.label}")
        indices.append(found)
    if not chosen and not indices:
        indices = [0]
    indices = list(dict.fromkeys(indices))
    return Targets(chosen, tuple(indices), tuple(body_pieces(robot, i) for i in indices) if greatest else ())


def _all_joints(robot: Robot) -> list[Variation]:
    """Every joint of one coordinate that does not follow another."""
    followers = {mimic.joint for mimic in robot.mimics}
    free = [joint.name for joint in robot.single_joints if joint.axis is not None and joint.name not in followers]
    return [variation(robot, f"joint:{name}") for name in free]


def _complete(robot: Robot, one: Variation, sample: bool) -> Variation:
    """A variation with the range of its joint, if it was given no values."""
    if not one.values and one.span is None:
        joint = robot.joint(one.target)
        size = 1.0 if one.unit == "m" else 1.0 / DEG
        low, high = (limit * size for limit in joint.limits)
        if joint.kind == "continuous" or (one.unit == "deg" and not high - low < 1e6):
            low, high = -180.0, 180.0
        if not high > low or not math.isfinite(high - low):
            raise StudyError(
                f'joint "{joint.name}" has no range of motion in the robot file; give values, such as {joint.name}=0:0.1:5'
            )
        one = replace(one, subject=joint.name, span=(low, high))
    if not sample and one.span is not None:
        raise StudyError(
            f"{one.subject}: a range is drawn from by --sample N; for a grid give the number of values too, such as "
            f"{one.span[0]:g}:{one.span[1]:g}:10"
        )
    return one


def _refuse_twice(robot: Robot, found: list[Variation]) -> None:
    """Refuse one quantity that is varied twice."""
    seen: dict[str, str] = {}
    for one in found:
        own = one.joints(robot) if one.kind == "joint" else [one.subject]
        for name in own:
            if name in seen:
                raise StudyError(f'"{name}" is varied twice, by "{seen[name]}" and by "{one.subject}"; keep one of them')
            seen[name] = one.subject
