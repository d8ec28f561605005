"""The landing in maximal coordinates with a hundred digits: an independent formulation of what the
package proves.

Every body has a twist V_i of its own, written at the world's origin. The wrench F_i that its joint
transmits, the joint's rates q̇_i and the impulse λ along each row are unknowns as well, and all
equations are solved at once, without using that the robot is a tree:

    I_i V_i - F_i + Σ (F_child + c a q̇_child) = Σ W_i λ   momentum of every body, and of the rotors that it carries
    V_i - V_parent(i) - S_i q̇_i = 0          what its joint allows
    S_iᵀ F_i + a_i q̇_i + c aᵀ V_parent = Σ τ λ   nothing but armature, rotors and couplings acts along the joint
    Σ W_iᵀ V_i + τᵀ q̇ = -b                   every row

No joint-space inertia, Jacobian, composite or articulated body is ever formed. The doubles of the
loaded robot (masses, inertias, joint placements, axes, armature), q and the scene's rows are taken
as exact. Numbers are Arb balls, or those of mpmath, which the package does not use.
"""

import heapq
from collections.abc import Callable
from typing import Any, NamedTuple

import flint
import mpmath
import numpy as np

from shockpc.core.spatial import quaternion_of
from shockpc.landing.closure import loop_of
from shockpc.landing.contact import locate_lowest_point

DIGITS, MOST_DIGITS = 100, 3200
"""Digits to begin with; they are doubled until the balls are narrow, or no more than so many are
needed.
"""

NARROW = 1e-45
"""Radius of the widest ball over the largest number."""


class Arithmetic(NamedTuple):
    """Long numbers: how a double becomes one, and the functions of one."""

    number: Callable[[float], Any]
    sqrt: Callable[[Any], Any]
    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]


BALLS = Arithmetic(flint.arb, flint.arb.sqrt, flint.arb.sin, flint.arb.cos)
MPMATH = Arithmetic(mpmath.mpf, mpmath.sqrt, mpmath.sin, mpmath.cos)


class Answer(NamedTuple):
    """A solved landing; the four columns are unit strikes along world x, y and z, and the scene's
    strike.

    Attributes:
        jumps: (nb, 6, 4) jump (Δω, Δv) of every body, body coordinates at its frame's origin.
        at_com: (nb, 6, 4) the same in world axes, with the velocity of the centre of mass.
        impulse: (nr, 4) along the rows that were used, the mimic rows last.
        missed: (nc,) speed that is left along every row of the scene for its strike, over the
            largest speed to be undone [1].
    """

    jumps: np.ndarray
    at_com: np.ndarray
    impulse: np.ndarray
    missed: np.ndarray


class Rows(NamedTuple):
    """What is held: unit impulses as wrenches (nb, 6, nr) about the world's origin and joint
    torques (n, nr); speeds b (nr, 4).
    """

    wrench: np.ndarray
    torque: list[np.ndarray]
    b: np.ndarray


def maximal_jumps(landing, chosen=None, arithmetic=BALLS) -> Answer:
    """Solve a landing.

    Args:
        landing: q, the motion before the impact, contact points and joint model are taken from it;
            rows are read from its scene.
        chosen: indices of the independent rows: contacts, then stance, then closures; all rows by
            default.
        arithmetic: kind of the numbers.

    Raises:
        ZeroDivisionError: the chosen rows repeat one another, or nothing resists a joint.
    """
    digits = DIGITS
    while True:
        with flint.ctx.workdps(digits), mpmath.workdps(digits):
            try:
                answer = _Mechanism(landing, arithmetic).solve(chosen)
            except ZeroDivisionError:
                if digits >= MOST_DIGITS:
                    raise
            else:
                if arithmetic is MPMATH or _narrow(answer):
                    return answer
        digits *= 2


def _narrow(answer) -> bool:
    """Whether the balls leave no doubt about the digits that are compared."""
    values = [*answer.jumps.ravel(), *answer.at_com.ravel()]
    return max(float(value.rad()) for value in values) <= NARROW * max(
        abs(float(value.mid())) for value in values
    )


def cross_matrix(r):
    """The matrix (3, 3) with [r]× u = r × u."""
    x, y, z = r
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)


class _Mechanism:
    """Bodies and joints of a robot in its posture; world axes, twists (ω, v) at the world's origin."""

    def __init__(self, landing, arithmetic):
        self.robot, self.scene, self.landing, self.math = robot, _, _, _ = (
            landing.robot,
            landing.scene,
            landing,
            arithmetic,
        )
        self.parent = robot.parents
        self.inertia, self.S, self.armature, self.rotation, self.position, self.com = (
            [],
            [],
            [],
            [],
            [],
            [],
        )
        # momenta c a (6, k) of the parent for unit rates of each joint, of the rotors that it
        # carries
        self.rotors = []
        self.place = {}  # joint velocity -> (body, column of S)
        q, frames = self.exact(landing.q), []
        for i, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
            above = (
                frames[joint.parent]
                if joint.parent >= 0
                else (self.exact(np.eye(3)), self.exact(np.zeros(3)))
            )
            R, p, columns = self.moved(*above, joint, q)
            frames.append((R, p))
            S, numbers = self.free_columns(i, joint, columns, p)
            self.place |= {v: (i, k) for k, v in enumerate(numbers) if v >= 0}
            self.S.append(S)
            self.armature.append(
                self.exact([0.0 if v < 0 else landing.joint_model.armature[v] for v in numbers])
            )
            coupling = self.exact(
                [0.0 if v < 0 else landing.joint_model.coupling[v] for v in numbers]
            )
            self.rotors.append(S * coupling * self.exact([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])[:, None])
            spatial = robot.model.inertias[body.joint]
            com = p + R @ self.exact(spatial.lever)
            self.inertia.append(
                self.about_origin(
                    self.exact([spatial.mass])[0], com, R @ self.exact(spatial.inertia) @ R.T
                )
            )
            self.rotation.append(R @ self.orthogonal(body.rotation))
            self.position.append(p + R @ self.exact(body.offset))
            self.com.append(com)

    def exact(self, values):
        """Doubles as long numbers."""
        values = np.asarray(values, dtype=float)
        out = np.empty(values.size, dtype=object)
        out[:] = [self.math.number(value) for value in values.ravel().tolist()]
        return out.reshape(values.shape)

    def unit(self, vector):
        return vector / self.math.sqrt(vector @ vector)

    def orthogonal(self, values):
        """The rotation of the quaternion that is read from nine doubles, which are orthogonal to
        rounding only.
        """
        return self.quaternion(self.exact(quaternion_of(np.array(values))))

    def turned(self, axis, cosine, sine):
        """Rotation about a unit axis (Rodrigues)."""
        K = cross_matrix(axis)
        return self.exact(np.eye(3)) + K * sine + (K @ K) * (1 - cosine)

    def quaternion(self, values):
        *vector, w = self.unit(values)
        K = cross_matrix(vector)
        return self.exact(np.eye(3)) + K * (2 * w) + (K @ K) * 2

    def moved(self, R, p, joint, q):
        """A placement carried through a joint, and the columns (6,) of the joint's motion in the
        world, one for each velocity.
        """
        if joint.parts:
            columns = []
            for part in joint.parts:
                R, p, step = self.moved(R, p, part, q)
                columns += step
            return R, p, columns
        p, R = p + R @ self.exact(joint.offset), R @ self.orthogonal(joint.rotation)
        at = q[joint.q]
        match joint.kind:
            case "free":
                p, R = p + R @ at[:3], R @ self.quaternion(at[3:])
                return R, p, [*slides(R.T), *turns(R.T, p)]
            case "ball":
                R = R @ self.quaternion(at)
                return R, p, turns(R.T, p)
            case "planar":
                p = p + R[:, 0] * at[0] + R[:, 1] * at[1]
                R = R @ self.turned(self.exact([0.0, 0.0, 1.0]), *self.unit(at[2:]))
                return R, p, [*slides(R.T[:2]), *turns(R.T[2:], p)]
            case "prismatic":
                axis = R @ self.unit(self.exact(joint.axis))
                return R, p + axis * at[0], slides([axis])
        axis = self.unit(self.exact(joint.axis))
        cosine_sine = (
            self.unit(at)
            if joint.kind == "continuous"
            else (self.math.cos(at[0]), self.math.sin(at[0]))
        )
        return R @ self.turned(axis, *cosine_sine), p, turns([R @ axis], p)

    def free_columns(self, i, joint, columns, p):
        """The columns of a body's joint that may move, and which joint velocity each one is; -1 for
        those of a planar base.
        """
        numbers = list(range(joint.v.start, joint.v.stop))
        kept = [k for k, v in enumerate(numbers) if not self.landing.joint_model.locked[v]]
        if i == 0 and self.robot.free_base and self.scene.base == "fixed":
            kept = []
        if i == 0 and self.robot.free_base and self.scene.base == "planar":
            e1, e2, normal = (
                self.exact(v)
                for v in (self.landing.plane.e1, self.landing.plane.e2, self.landing.plane.normal)
            )
            columns, numbers, kept = (
                [*slides([e1, e2]), *turns([normal], p)],
                [-1, -1, -1],
                [0, 1, 2],
            )
        S = np.stack([columns[k] for k in kept], axis=1) if kept else np.empty((6, 0), dtype=object)
        return S, [numbers[k] for k in kept]

    def about_origin(self, m, c, I_c):
        """Spatial inertia (6, 6) about the world's origin of a mass m at c with I_c about c."""
        K, one = cross_matrix(c), self.exact(np.eye(3))
        return np.block([[I_c - K @ K * m, K * m], [K * -m, one * m]])

    # What is held

    def before(self):
        """Twist (6, 4) of every body before the impact; the first three columns are unit velocities
        of the whole robot.
        """
        motion = self.landing.before
        omega, velocity = self.exact(motion.omega), self.exact(motion.velocity)
        origin = self.position[0] if self.robot.free_base else self.exact(np.zeros(3))
        base = self.exact(np.zeros((6, 4)))
        base[3:, :3] = self.exact(np.eye(3))
        base[:, 3] = [*omega, *(velocity - cross_matrix(omega) @ origin)]
        twists = []
        for i, parent in enumerate(self.parent):
            twist = (base if parent < 0 else twists[parent]).copy()
            for v, (body, k) in self.place.items():
                if body == i and motion.joint_rates[v] != 0.0:
                    twist[:, 3] = twist[:, 3] + self.S[i][:, k] * self.math.number(
                        float(motion.joint_rates[v])
                    )
            twists.append(twist)
        return twists

    def rows(self, chosen):
        """The rows of contacts, stance and closures, read from the scene; all, or those chosen;
        then the rows of mimic joints.
        """
        before, held = self.before(), []
        still = self.exact(np.zeros(4))
        for touch in self.landing.contacts:
            point = locate_lowest_point(touch, self.landing.state.rotation[:, touch.body]).point
            at, e = self.world(touch.body, point.reshape(3)), self.exact([touch.restitution])[0]
            wrenches = [*forces(self.exact(touch.forces), at), *moments(self.exact(touch.moments))]
            speeds = [wrench @ before[touch.body] for wrench in wrenches]
            back = speeds
            if touch.rebound is not None:
                n = self.exact(touch.rebound)
                (rise,), (spin,) = (
                    (w @ before[touch.body] for w in kind)
                    for kind in (forces(n[None], at), moments(n[None]))
                )
                back = [(axis @ n) * rise for axis in self.exact(touch.forces)]
                turns = zip(self.exact(touch.moments), speeds[len(back) :], strict=True)
                back += [speed - (axis @ n) * spin for axis, speed in turns]
            held += [
                ({touch.body: w}, v + e * r) for w, v, r in zip(wrenches, speeds, back, strict=True)
            ]
        for frame in map(self.robot.frame, self.scene.stance):
            held += [
                ({frame.body: w}, still)
                for w in forces(self.exact(np.eye(3)), self.world(frame.body, frame.offset))
            ]
        for loop in (
            *self.robot.loops,
            *(loop_of(self.robot, closure) for closure in self.scene.closure),
        ):
            a, b = loop.bodies
            R, frame = self.exact(np.eye(3)) if a < 0 else self.rotation[a], loop.rotations[0]
            wrenches = forces(self.exact(loop.axes @ frame.T) @ R.T, self.world(b, loop.points[1]))
            wrenches += moments(self.exact(frame.T) @ R.T) if loop.holds_orientation else []
            held += [
                ({body: w * sign for body, sign in ((b, 1), (a, -1)) if body >= 0}, still)
                for w in wrenches
            ]
        held = held if chosen is None else [held[k] for k in chosen]
        tied = [self.mimic(mimic) for mimic in self.robot.mimics]
        tied = [row for row in tied if row]
        n = len(held) + len(tied)
        wrench, b = self.exact(np.zeros((len(self.parent), 6, n))), self.exact(np.zeros((n, 4)))
        torque = [self.exact(np.zeros((S.shape[1], n))) for S in self.S]
        for k, (wrenches, speed) in enumerate(held):
            b[k] = speed
            for body, w in wrenches.items():
                wrench[body, :, k] = w
        for k, row in enumerate(tied, start=len(held)):
            for (body, column), value in row.items():
                torque[body][column, k] = value
        return Rows(wrench, torque, b)

    def mimic(self, mimic):
        """q̇_follower - Σ multiplier · q̇_leader = 0, as torques on all; the package leaves the
        follower out instead.
        """
        velocity = {joint.name: joint.v.start for joint in self.robot.joints}
        row = {
            self.place.get(velocity[name]): -self.math.number(float(by))
            for name, by in mimic.leaders.items()
        }
        row = {self.place.get(velocity[mimic.joint]): self.math.number(1.0)} | row
        return (
            {}
            if next(iter(row)) is None
            else {place: by for place, by in row.items() if place is not None}
        )

    def world(self, body, point):
        """A point of a body in the world; body -1 is the world itself."""
        point = self.exact(point)
        return point if body < 0 else self.position[body] + self.rotation[body] @ point

    # The solution

    def equations(self, rows):
        """All equations as sparse rows {unknown: factor}, and where the unknowns of V, F and q̇ of
        each body and of λ begin.
        """
        n = 0
        V, F, rates = [], [], []
        for S in self.S:
            V, F, rates, n = [*V, n], [*F, n + 6], [*rates, n + 12], n + 12 + S.shape[1]
        found = [{} for _ in range(n + len(rows.b))]

        def put(first, column, block):
            for (r, c), value in np.ndenumerate(block):
                if not (isinstance(value, int) or value == 0):
                    found[first + r][column + c] = value

        one = self.exact(np.eye(6))
        for i, parent in enumerate(self.parent):
            put(V[i], V[i], self.inertia[i])
            put(V[i], F[i], -one)
            put(F[i], V[i], one)
            put(F[i], rates[i], -self.S[i])
            put(rates[i], F[i], self.S[i].T)
            put(rates[i], rates[i], np.diag(self.armature[i]))
            if parent >= 0:
                put(V[parent], F[i], one)
                put(F[i], V[parent], -one)
                put(V[parent], rates[i], self.rotors[i])
                put(rates[i], V[parent], self.rotors[i].T)
            put(V[i], n, -rows.wrench[i])
            put(rates[i], n, -rows.torque[i])
            put(n, V[i], rows.wrench[i].T)
            put(n, rates[i], rows.torque[i].T)
        return found, V, n

    def solve(self, chosen):
        rows = self.rows(chosen)
        found, V, n = self.equations(rows)
        right = self.exact(np.zeros((len(found), 4)))
        right[n:] = -rows.b
        solution = solved(found, right)
        twists = [solution[k : k + 6] for k in V]
        everything = rows if chosen is None else self.rows(None)
        after = sum(w.T @ v for w, v in zip(everything.wrench, twists, strict=True))[:, 3]
        contacts = len(everything.b) - sum(bool(self.mimic(mimic)) for mimic in self.robot.mimics)
        largest = max((abs(float(speed)) for speed in everything.b[:, 3]), default=0.0) or 1.0
        missed = np.array(
            [abs(float(value)) / largest for value in (after + everything.b[:, 3])[:contacts]]
        )
        at_com = np.stack(
            [written_at(twist, com) for twist, com in zip(twists, self.com, strict=True)]
        )
        at_frame = [written_at(twist, p) for twist, p in zip(twists, self.position, strict=True)]
        jumps = np.stack(
            [
                np.concatenate([R.T @ t[:3], R.T @ t[3:]])
                for R, t in zip(self.rotation, at_frame, strict=True)
            ]
        )
        return Answer(jumps, at_com, solution[n:], missed)


def slides(axes):
    """Columns of translations along axes: (0, a)."""
    return [np.concatenate([0 * axis, axis]) for axis in axes]


def turns(axes, p):
    """Columns of rotations about axes through p: (a, p × a)."""
    return [np.concatenate([axis, cross_matrix(p) @ axis]) for axis in axes]


def forces(axes, p):
    """Unit impulses along axes at p, as wrenches about the world's origin."""
    return [np.concatenate([cross_matrix(p) @ axis, axis]) for axis in axes]


def moments(axes):
    """Unit moments about axes."""
    return [np.concatenate([axis, 0 * axis]) for axis in axes]


def written_at(twist, p):
    """A twist (6, k) at the world's origin, with the velocity of the point p instead."""
    return np.concatenate([twist[:3], twist[3:] - cross_matrix(p) @ twist[:3]])


def solved(rows, right):
    """Solution (n, k) of sparse equations by elimination: always the shortest equation left, and in
    it the unknown in the fewest.

    Args:
        rows: {unknown: factor} of each equation; used up.
        right: (n, k) right-hand sides; used up.

    Raises:
        ZeroDivisionError: a pivot may be zero.
    """
    where = [set() for _ in rows]
    for r, row in enumerate(rows):
        for c in row:
            where[c].add(r)
    left, order = set(range(len(rows))), []
    shortest = [(len(row), r) for r, row in enumerate(rows)]
    heapq.heapify(shortest)
    while left:
        length, r = heapq.heappop(shortest)
        if r not in left or length != len(rows[r]):  # it was solved, or has changed since
            continue
        size = {
            c: abs(float(value.mid() if isinstance(value, flint.arb) else value))
            for c, value in rows[r].items()
        }
        c = min(
            (c for c in size if size[c] >= 0.01 * max(size.values())),
            key=lambda k: len(where[k]),
            default=-1,
        )
        if c < 0 or not abs(rows[r][c]) > 0:
            raise ZeroDivisionError(
                f"{len(left)} equations are left: rows repeat one another, or nothing resists a "
                f"joint"
            )
        left.remove(r)
        order.append((r, c))
        for k in rows[r]:
            where[k].discard(r)
        for other in where[c]:
            factor = rows[other].pop(c) / rows[r][c]
            for k, value in rows[r].items():
                if k != c:
                    where[k].add(other)
                    rows[other][k] = (
                        rows[other][k] - factor * value if k in rows[other] else -factor * value
                    )
            right[other] = right[other] - right[r] * factor
            heapq.heappush(shortest, (len(rows[other]), other))
    solution = np.empty_like(right)
    for r, c in reversed(order):
        rest = sum((solution[k] * value for k, value in rows[r].items() if k != c), 0 * right[r])
        solution[c] = (right[r] - rest) / rows[r][c]
    return solution
