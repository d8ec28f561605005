"""Loops: two bodies held together at a point or a frame.

They are rows, and the posture in which the two ends meet.

The rows K Δq̇ = 0 are stacked under the contacts (shock paper, Section 3.1.1); restitution never
applies to them. Redundant rows, such as a planar loop closed by a point in space, are normal: the
solver counts the rank.
"""

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, Plane
from shockpc.landing.movable import movable_columns
from shockpc.landing.scenes.directions import unit_directions
from shockpc.landing.scenes.scene import Closure
from shockpc.method.constraints import NO_AXES, Constraint, row_jacobian, world_point
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.robot.bodies_and_joints import Loop
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import SceneError
from shockpc.text.printed import few, listed

CLOSED, SEEN, DIGITS = 1e-12, 1e-9, 1e-4
"""A loop is closed when its gap is below the first share of the robot's size: what rounding leaves.
A gap above the second is
reported. Up to the third one may be left by lengths with six digits, of which differences
decide."""

EXACT = 1e-10
"""Share of the largest singular value of K G below which one is rounding."""

NEARBY = 1e-2
"""Largest motion of joints to close exactly what is closed to the digits of a file [rad, m]."""

STEPS, NEAR_STEPS, RETRIES, SPREAD = 50, 12, 8, 0.25
"""Steps of Gauss–Newton, from anywhere and from nearby; other starts, and how much farther away
each is than the last [rad, m].
"""

STRIDE, LEAP, SHORTEST = 0.2, 0.5, 1e-3
"""Following loops: first stride of the held joints, how far the others may move in one stride, and
shortest stride [rad, m].
"""


def all_loops(robot: Robot, closures: Sequence[Closure]) -> tuple[Loop, ...]:
    """The loops of the robot's file, then those of a scene.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: one makes no sense, or two tie the same points: where those are only almost the
            same, rounding would determine what they hold.
    """
    loops = (*robot.loops, *(loop_of(robot, closure) for closure in closures))
    for earlier, later in itertools.combinations(loops, 2):
        if _tie_the_same(earlier, later):
            raise SceneError(
                f'closures "{earlier.name}" and "{later.name}" tie the same points of the same '
                "bodies, so they are one closure; keep one, which holds everything that both "
                "should hold",
                constraints=[earlier.name, later.name],
            )
    return loops


def _tie_the_same(a: Loop, b: Loop) -> bool:
    """True if two loops tie the same points of the same bodies."""
    ends_a = dict(zip(a.bodies, a.points, strict=True))
    ends_b = dict(zip(b.bodies, b.points, strict=True))
    if ends_a.keys() != ends_b.keys():
        return False
    apart = [np.linalg.norm(point - ends_b[body]) for body, point in ends_a.items()]
    return all(distance <= 1e-9 for distance in apart)


def loop_of(robot: Robot, closure: Closure) -> Loop:
    """The loop that a closure of a scene means.

    Raises:
        UnknownName: the robot has no such frame.
        SceneError: both ends are on one body, or a direction has no length.
    """
    a, b = robot.frame(closure.a.frame), robot.frame(closure.b.frame)
    name = f"{closure.a.frame}–{closure.b.frame}"
    if a.body == b.body:
        shared = f'body "{robot.bodies[a.body].name}"' if a.body >= 0 else "the world"
        raise SceneError(
            f'closure "{name}" holds {shared} to itself, which closes no loop; name frames on two '
            f"bodies",
            constraints=[name],
        )
    return Loop(
        name=name,
        bodies=(a.body, b.body),
        points=(
            a.offset + a.rotation @ np.asarray(closure.a.offset),
            b.offset + b.rotation @ np.asarray(closure.b.offset),
        ),
        rotations=(a.rotation, b.rotation),
        axes=unit_directions(f'closure "{name}"', closure.directions),
        holds_orientation=closure.kind == "frame",
    )


def closure_constraint(loop: Loop) -> Constraint:
    """The rows of a loop: the two ends may not separate along the loop's axes.

    The axes turn with the loop's first body.

    Both impulses act at the second end: along an axis that is left free the first end may be
    elsewhere, and opposite impulses at two places would turn the robot. It is also what makes the
    rows the derivative of `closure_gap`.
    """
    (a, b), frame = loop.bodies, loop.rotations[0]
    return Constraint(
        kind="closure",
        frame=loop.name,
        body=b,
        point=loop.points[1],
        forces=loop.axes @ frame.T,
        moments=frame.T if loop.holds_orientation else NO_AXES,
        other_body=a,
        axes_body=a,
    )


def closure_gap(state: Dynamics, loop: Loop) -> Array:
    """Distance (N, n) of the second end of a loop from the first.

    Along its axes [m], then about them [rad] if it holds these.
    """
    a, b = loop.bodies
    p_a, p_b = loop.points
    R_a = _orientation(state, a, loop.rotations[0])
    apart = world_point(state, b, p_b) - world_point(state, a, p_a)
    gap = np.einsum("nij,ki,nj->nk", np.swapaxes(R_a, -1, -2), loop.axes, apart)
    if not loop.holds_orientation:
        return np.asarray(gap)
    R_b = _orientation(state, b, loop.rotations[1])
    turned = [pin.log3(first.T @ second) for first, second in zip(R_a, R_b, strict=True)]
    return np.concatenate([gap, np.stack(turned)], axis=1)


def _orientation(state: Dynamics, body: int, rotation: Array) -> Array:
    """Orientation (N, 3, 3) of a frame on a body, or on the world."""
    n = len(state.J)
    return np.broadcast_to(rotation, (n, 3, 3)) if body < 0 else state.rotation[:, body] @ rotation


class Assembly(NamedTuple):
    """A posture in which every loop meets.

    Attributes:
        q: (nq,) configuration.
        gap: largest distance between two ends before [m].
        turn: largest angle between two ends before, of closures that hold orientations [rad].
        moved: (joint, by how much, unit) of each joint that had to move; a ball joint by its angle.
        left: largest distance that is left between two ends of loops that contradict one another in
            the last digits of a file [m].
        retried: whether they close only from another start, so perhaps assembled in another way.
    """

    q: Array
    gap: float
    turn: float
    moved: tuple[tuple[str, float, str], ...]
    left: float
    retried: bool

    def warnings(self, robot: str) -> Iterator[Diagnostic]:
        """Warnings of loops that are not closed as the scene says. Args: robot: its name."""
        if self.left:
            text = (
                f"the loops contradict one another in the last digits of the file: ends stay "
                f"{1e3 * self.left:.2g} mm apart"
            )
            yield Diagnostic("posture", robot, self.left, f"{text}, closed by least squares")
        if self.retried:
            moved = few([f'"{name}" by {by:.3g} {unit}' for name, by, unit in self.moved], 4)
            text = (
                f"the loops close only far from the joint values given, perhaps assembled in "
                f"another way: {moved}"
            )
            yield Diagnostic(
                "posture",
                robot,
                None,
                f"{text}; if another way is meant, set these joints nearer to it",
            )


def assemble(
    robot: Robot, q: Array, loops: tuple[Loop, ...], plane: Plane, fixed: np.ndarray
) -> Assembly:
    """Close every loop by Gauss–Newton with steps of minimum norm, K G Δy = −gap.

    Loops that contradict one another by no more than the digits of a file are closed by least
    squares. Where neither is possible, other starts are tried, and the closed posture nearest to q
    is taken.

    Args:
        robot: its base stays where it is; joints that follow others keep following.
        q: (nq,) configuration to start from.
        loops: to be closed.
        plane: of the study.
        fixed: (nv,) joint velocities that may not move.

    Raises:
        SceneError: the loops cannot be closed; the text gives the gap that is left, in millimetres.
    """
    linkage = _Linkage(robot, loops, plane, fixed)
    closed = linkage.closed(q, DIGITS)
    retried = closed is None
    if closed is None:
        closed = linkage.nearest_closed(q)
    if closed is None:
        raise linkage.refusal(q)
    before = [_apart(dynamics(robot, q[None]), loop) for loop in loops]
    state = dynamics(robot, closed[None])
    left = max(_apart(state, loop)[0] for loop in loops)
    if not left > SEEN * _size(state):
        left = 0.0
    return Assembly(
        q=closed,
        gap=max(distance for distance, _ in before),
        turn=max(angle for _, angle in before),
        moved=moved_joints(robot, q, closed),
        left=left,
        retried=retried,
    )


def follow(
    robot: Robot, near: Array, q: Array, loops: tuple[Loop, ...], plane: Plane, fixed: np.ndarray
) -> Array:
    """Follow closed loops while the held joints move from one posture to another.

    The loops stay assembled in the same way.

    Args:
        robot: as in `assemble`.
        near: (nq,) closed configuration to start from.
        q: (nq,) configuration that has the held joints where they shall be.
        loops: to be kept closed.
        plane: of the study.
        fixed: (nv,) joint velocities that do not close the loops.

    Returns: (nq,) the closed configuration.

    Raises:
        SceneError: the loops cannot be closed on the way.
    """
    linkage = _Linkage(robot, loops, plane, fixed)
    # As much may be left on the way as at its beginning.
    _, gap = linkage.reached(near, DIGITS, 0)
    allowed = max(CLOSED, 2.0 * gap)
    way = np.where(fixed, pin.difference(robot.model, near, q), 0.0)
    length = max(float(np.abs(way).max()), 1e-300)
    here = near
    done = 0.0
    step = min(1.0, STRIDE / length)
    while done < 1.0:
        step = min(step, 1.0 - done)
        there = pin.integrate(robot.model, here, step * way)
        if done + step == 1.0:
            # without the rounding of the steps
            moved = np.where(fixed, 0.0, pin.difference(robot.model, q, here))
            there = pin.integrate(robot.model, q, moved)
        robot.set_followers(there)
        closed = linkage.closed(there, allowed, NEAR_STEPS)
        # The loops move far only where they are nearly singular, and there another posture is near
        # in which they are closed.
        if closed is not None and _largest_step(robot, there, closed) <= LEAP:
            here = closed
            done += step
            step *= 2.0
            continue
        step /= 2.0
        if step * length < SHORTEST:
            raise linkage.refusal(there)
    return here


def _largest_step(robot: Robot, q: Array, q_after: Array) -> float:
    """The largest displacement of a joint between two configurations (nq,) [rad, m]."""
    return float(np.abs(pin.difference(robot.model, q, q_after)).max())


def closed_nearby(
    robot: Robot, q: Array, loops: tuple[Loop, ...], plane: Plane, fixed: np.ndarray
) -> Array | None:
    """The closed configuration (nq,) nearby, or None where the loops do not close from there.

    Arguments are as of `assemble`.
    """
    return _Linkage(robot, loops, plane, fixed).closed(q, DIGITS)


class _Linkage(NamedTuple):
    """Loops of a robot, and which joints may move to close them; as the arguments of `assemble`."""

    robot: Robot
    loops: tuple[Loop, ...]
    plane: Plane
    fixed: np.ndarray

    def gap(self, state: Dynamics) -> Array:
        """All gaps (n,) [m, rad]."""
        return np.concatenate([closure_gap(state, loop)[0] for loop in self.loops])

    def columns(self, state: Dynamics) -> tuple[Array, Array]:
        """The directions G (nv, ny) in which joints may move, and the change of the gaps.

        The change of the gaps is K G (n, ny).
        """
        if not _movable(self.robot, self.fixed):
            return np.zeros((len(self.fixed), 0)), np.zeros((len(self.gap(state)), 0))
        G = movable_columns(self.robot, "fixed", self.plane, state.rotation[:, 0], self.fixed)
        columns = np.eye(self.robot.model.nv) if G is None else G[0]
        K = row_jacobian(state, [closure_constraint(loop) for loop in self.loops])[0]
        return columns, K @ columns

    def refusal(self, q: Array) -> SceneError:
        """The error for loops that cannot be closed from q."""
        state = dynamics(self.robot, self.reached(q, EXACT, STEPS)[0][None])
        worst = max(self.loops, key=lambda loop: float(np.abs(closure_gap(state, loop)).max()))
        left, turned = _apart(state, worst)
        angle = f" and {np.degrees(turned):.3g} deg turned" if worst.holds_orientation else ""
        movable = _movable(self.robot, self.fixed)
        return SceneError(
            f'closure "{worst.name}" cannot be closed: its ends stay {1e3 * left:.3g} mm '
            f"apart{angle} (joints that may move: {listed(movable) or 'none'}); let other joints "
            "move with --assemble, or start from joint values nearer to the closed loop",
            constraints=[worst.name],
            joints=movable,
        )

    def nearest_closed(self, q: Array) -> Array | None:
        """The closed configuration (nq,) nearest to q that other starts lead to.

        None if there is none.
        """
        nearest = None
        distance = np.inf
        for start in self.starts(q, RETRIES):
            closed = self.closed(start, DIGITS)
            if closed is None:
                continue
            away = float(np.linalg.norm(pin.difference(self.robot.model, q, closed)))
            if away < distance:
                nearest = closed
                distance = away
        return nearest

    def steps(self, q: Array, cut: float, most: int) -> Iterator[tuple[Dynamics, Array, float]]:
        """Gauss–Newton from q: state, configuration and size of the step that follows.

        Args:
            q: (nq,) configuration to start from.
            cut: share of the largest singular value of K G below which one counts as zero.
            most: how many steps.
        """
        for _ in range(most + 1):
            state = dynamics(self.robot, q[None])
            G, K_G = self.columns(state)
            dy = np.linalg.lstsq(K_G, -self.gap(state), rcond=cut)[0]
            size = float(np.abs(dy).max(initial=0.0))
            yield state, q, size
            if not size:
                return
            # A long step leaves the range in which a linear model of the linkage means anything.
            q = pin.integrate(self.robot.model, q, G @ dy * min(1.0, 0.5 / size))

    def closed(self, q: Array, allowed: float, most: int = STEPS) -> Array | None:
        """The closed configuration (nq,) that is reached from q; None if there is none.

        Directions in which the loops resist by no more than the digits of a file are left alone at
        first: bars that are parallel to these digits would move far to make up for what is missing
        in their lengths.

        Args:
            q: (nq,) configuration to start from.
            allowed: share of the robot's size that may be left as a gap where it cannot be closed
                nearby.
            most: how many steps.
        """
        coarse, left = self.reached(q, DIGITS, most)
        if left <= CLOSED:
            return coarse
        start = coarse if left <= DIGITS else q
        exact, left_exactly = self.reached(start, EXACT, most)
        is_nearby = left > DIGITS or _largest_step(self.robot, coarse, exact) <= NEARBY
        if left_exactly <= CLOSED and is_nearby:
            return exact
        return coarse if left <= allowed else None

    def reached(self, q: Array, cut: float, most: int) -> tuple[Array, float]:
        """The configuration with the smallest gap on the way from q, and that gap.

        The gap is a share of the robot's size; as in `steps`.
        """
        best = q
        smallest_gap = np.inf
        last = False
        for state, passed, step in self.steps(q, cut, most):
            gap = float(np.abs(self.gap(state)).max()) / _size(state)
            if gap < smallest_gap:
                best = passed
                smallest_gap = gap
            if gap <= CLOSED or last:
                break
            last = step <= CLOSED  # one more, as it may close what is almost closed
        return best, smallest_gap

    def starts(self, q: Array, count: int) -> Iterator[Array]:
        """So many other configurations, farther and farther away."""
        G, _ = self.columns(dynamics(self.robot, q[None]))
        rng = np.random.default_rng(0)
        for k in range(count):
            direction = G @ rng.uniform(-1.0, 1.0, G.shape[1])
            yield pin.integrate(self.robot.model, q, direction * (k + 1) * SPREAD)


def _size(state: Dynamics) -> float:
    return max(float(np.ptp(state.position[0], axis=0).max()), 1e-3)


def _apart(state: Dynamics, loop: Loop) -> tuple[float, float]:
    """Distance [m] and angle [rad] between the ends of a loop."""
    apart, turned = np.split(closure_gap(state, loop)[0], [len(loop.axes)])
    return float(np.linalg.norm(apart)), float(np.linalg.norm(turned))


def _movable(robot: Robot, fixed: np.ndarray) -> list[str]:
    """The joints that may move by themselves: neither held nor following another."""
    movable = []
    for name in robot.joint_names:
        is_held = fixed[robot.joint(name).v].any()
        if name not in robot.followers and not is_held:
            movable.append(name)
    return movable


def moved_joints(robot: Robot, before: Array, after: Array) -> tuple[tuple[str, float, str], ...]:
    """The joints that moved by more than rounding: name, displacement and unit.

    A ball joint has an angle.
    """
    step = pin.difference(robot.model, before, after)
    moved: list[tuple[str, float, str]] = []
    for joint in map(robot.joint, robot.joint_names):
        part = step[joint.v]
        by = float(np.linalg.norm(part))
        if len(part) == 1:
            by = float(part[0])
        if abs(by) > 1e-9:
            moved.append((joint.name, by, joint.unit))
    return tuple(moved)
