"""Random trees by the thousand: is the error estimate ever too small?

Tree number n is the same on every machine: 1 to 30 bodies, masses over eight decades, joints of every kind, one to three contacts,
and now and then a closed loop.
"""

import multiprocessing
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shockpc.bench.build import Link, robot_of
from shockpc.bench.cases import Case
from shockpc.bench.measure import MethodResult, measure
from shockpc.bench.methods import DIRECT
from shockpc.core.spatial import Array
from shockpc.health import DOUBTFUL
from shockpc.model.closure import Closure, Place
from shockpc.model.contact import Contact
from shockpc.model.dynamics import dynamics
from shockpc.model.posture import Posture, configuration
from shockpc.model.robot import Robot
from shockpc.scene import Scene, Strike

__all__ = ["LOOSE", "Soaked", "Tally", "random_landing", "soak", "soak_one", "tally_text"]

DECADES = (-4.0, 4.0)
"""Masses lie between 1e-4 and 1e4 kg."""

KINDS = (("revolute", "continuous", "prismatic"), ("revolute", "prismatic", "spherical", "planar"))
"""Joints of even trees and of odd ones."""

LOOSE = 1000.0
"""An estimate more than so many times the error is loose; errors below rounding itself count as rounding."""


@dataclass(frozen=True)
class Soaked:
    """What came of one random tree.

    Attributes:
        number: of the tree.
        bodies: how many it has.
        result: of the product; None if the drawing made no landing.
    """

    number: int
    bodies: int
    result: MethodResult | None


@dataclass
class Tally:
    """Counts over many trees.

    Attributes:
        trees: drawn.
        none: drawings that are no landing (a loop that cannot be closed, a contact that leaves the ground).
        solved: with an answer.
        refused: with a message in words.
        broken: error above 10 × the estimate + 1e-14 at some body.
        silent: error above 1e-9 without a warning.
        failed: not a number, a library's exception, or an answer where there is none.
        loose: estimate above 1000 × the error.
        warned: estimate above 1e-10, and said so.
        offenders: numbers of the trees that broke a promise.
    """

    trees: int = 0
    none: int = 0
    solved: int = 0
    refused: int = 0
    broken: int = 0
    silent: int = 0
    failed: int = 0
    loose: int = 0
    warned: int = 0
    offenders: tuple[int, ...] = ()

    def add(self, one: Soaked) -> None:
        """Count one more."""
        self.trees += 1
        result = one.result
        if result is None:
            self.none += 1
            return
        if result.outcome == "refused":
            self.refused += 1
            return
        bad = 0
        if result.outcome in ("nan", "failed", "invented"):
            self.failed += 1
            bad = 1
        elif result.error is not None and result.estimate is not None and result.margin is not None:
            self.solved += 1
            self.broken += result.margin > 1.0
            self.silent += result.outcome == "wrong"
            self.loose += result.estimate > LOOSE * max(result.error, 2.0**-53)
            self.warned += result.outcome == "told" or result.estimate > DOUBTFUL
            bad = result.margin > 1.0 or result.outcome == "wrong"
        if bad:
            self.offenders = (*self.offenders, one.number)

    @property
    def violations(self) -> int:
        """Promises broken."""
        return self.broken + self.silent + self.failed


def soak(first: int, count: int, workers: int) -> Iterator[Soaked]:
    """Try trees number `first` to `first + count − 1`, in as many processes, in their order."""
    numbers = range(first, first + count)
    if workers <= 1:
        yield from map(soak_one, numbers)
        return
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        yield from pool.imap(soak_one, numbers, chunksize=16)


def soak_one(number: int) -> Soaked:
    """Draw a tree, let it land, and hold the product against the reference."""
    robot, scene = random_landing(number)
    case = Case("random tree", "", float(number), str(number), lambda: (robot, scene))
    found = measure(case, DIRECT[:1], budget=0.0).results[0]
    none = found.outcome == "refused" and any(
        word in found.message for word in ("cannot be closed", "no impact", "one point of one body")
    )
    return Soaked(number, len(robot.bodies), None if none else found)


def random_landing(number: int) -> tuple[Robot, Scene]:
    """Tree number n and its landing."""
    rng = np.random.default_rng([2021, number])
    # A URDF has continuous joints, an MJCF has ball joints and planar ones: every other tree is written as the one or the other.
    kinds = KINDS[number % 2]
    n = int(rng.integers(1, 31))
    links = [_link(rng, int(rng.integers(max(0, i - 3), i)) if i else -1, str(rng.choice(kinds))) for i in range(n)]
    robot = robot_of(links, f"tree{number}")
    joints = {
        name: float(rng.uniform(-1.5, 1.5)) for name in robot.joints if robot.model.joints[robot.model.getJointId(name)].nv == 1
    }
    quaternion = tuple(float(c) for c in _unit(rng, 4))
    posture = Posture(base_quaternion=quaternion, joints=joints)  # type: ignore[arg-type]
    e = float(rng.choice((0.0, 0.0, 0.5, 1.0)))
    contacts = tuple(_contact(rng, n, e) for _ in range(int(rng.integers(1, 4))))
    strike = Strike(velocity=(float(rng.uniform(-1, 1)), float(rng.uniform(-1, 1)), -float(rng.uniform(0.2, 1.0))))
    closure = (_closure(rng, robot, posture, n),) if n > 3 and rng.random() < 0.25 else ()
    return robot, Scene(robot=f"tree{number}", posture=posture, strike=strike, contact=contacts, closure=closure)


def _unit(rng: np.random.Generator, n: int) -> Array:
    v = rng.normal(size=n)
    return np.asarray(v / np.linalg.norm(v))


def _link(rng: np.random.Generator, parent: int, kind: str) -> Link:
    """A box of random sides, anywhere within its reach."""
    mass = float(10.0 ** rng.uniform(*DECADES))
    sides = 10.0 ** rng.uniform(-1.5, 0.0, 3)
    turn = pin.Quaternion(*_unit(rng, 4)).matrix()
    moments = mass / 12.0 * (np.sum(sides**2) - sides**2)
    inertia = turn @ np.diag(moments) @ turn.T
    rpy = tuple(float(a) for a in rng.uniform(-1.5, 1.5, 3))
    origin, com = rng.normal(0.0, 0.3, 3), rng.normal(0.0, 0.2, 3)
    return Link(parent, kind, origin, _unit(rng, 3), mass, com, 0.5 * (inertia + inertia.T), rpy)  # type: ignore[arg-type]


def _contact(rng: np.random.Generator, n: int, e: float) -> Contact:
    """A point of any link, sticking, sliding, or stopped along a slant."""
    kept = (("x", "y", "z"), ("z",), ((0.6, 0.0, 0.8),))[int(rng.integers(3))]
    offset = tuple(float(x) for x in rng.normal(0.0, 0.3, 3))
    return Contact(frame=f"link{int(rng.integers(n))}", offset=offset, directions=kept, restitution=e)  # type: ignore[arg-type]


def _closure(rng: np.random.Generator, robot: Robot, posture: Posture, n: int) -> Closure:
    """Two links held together where a point of the first is: the loop is closed as drawn."""
    a, b = (int(i) for i in rng.choice(n, 2, replace=False))
    state = dynamics(robot, configuration(robot, posture)[None])
    index = {body.name: i for i, body in enumerate(robot.bodies)}
    i, j = index[f"link{a}"], index[f"link{b}"]
    point = rng.normal(0.0, 0.3, 3)
    place = state.position[0, i] + state.rotation[0, i] @ point
    other = state.rotation[0, j].T @ (place - state.position[0, j])
    ends = [tuple(float(x) for x in values) for values in (point, other)]
    return Closure(a=Place(frame=f"link{a}", offset=ends[0]), b=Place(frame=f"link{b}", offset=ends[1]))  # type: ignore[arg-type]


def tally_text(tally: Tally) -> str:
    """The counts as lines."""
    share = 100.0 * (tally.solved - tally.loose) / max(tally.solved, 1)
    lines = [
        f"random trees                                     {tally.trees}",
        f"  drawn, but no landing                          {tally.none}",
        f"  refused in words                               {tally.refused}",
        f"  solved                                         {tally.solved}",
        f"    warned of                                    {tally.warned}",
        f"    estimate within {LOOSE:g} × of the error         {share:.1f} %",
        f"violations                                       {tally.violations}",
        f"  error above 10 × estimate + 1e-14              {tally.broken}",
        f"  error above 1e-9 without a warning             {tally.silent}",
        f"  not a number, exception, invented answer       {tally.failed}",
    ]
    if tally.offenders:
        lines.append(f"numbers of the trees: {', '.join(map(str, tally.offenders[:20]))} (--soak 1 --seed NUMBER)")
    return "\n".join(lines) + "\n"
