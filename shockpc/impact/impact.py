"""The solution of Eq. 4, the jumps of the bodies, and the results that follow from them.

They follow by the laws of rigid bodies.

One class for three arithmetics: N postures in doubles (`solve_impact`), one in balls, or any in
symbols (`exact`). The arrays have the same shapes in all, so that a quantity is one function of an
impact, whichever arithmetic it is evaluated in.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.inertia import solve_inertia
from shockpc.core.percussion import larger, norm
from shockpc.core.spatial import Array, cross, in_body_axes, velocity_at
from shockpc.landing.end_stops import velocity_at_stop
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import twist_before
from shockpc.method.constraints import (
    Constraint,
    constraint_axes,
    constraint_point,
    constraint_wrenches,
    row_jacobian,
    slices_of,
)
from shockpc.method.dynamics import Dynamics, Inertias, geared_bodies, spatial_inertias
from shockpc.method.equation import Equation
from shockpc.method.shock import jumps_of


class Impact:
    """An impact in N postures for S strikes each; arrays of doubles, or of balls with N = S = 1.

    What is linear in the strike has k columns: for 1 m/s along world x, y and z, and for the
    landing's motion.

    Attributes:
        landing: whose posture is one of them, or that they differ from.
        state: the robot in the N postures.
        constraints: what is held, described.
        delta_qd: (N, nv, k) jumps of the joint velocities, Pinocchio's layout [rad/s, m/s].
        impulse: (N, nc, k) impulses along all rows, of the ground on the robot [N s].
        independent_impulse: (N, nc, k) the same with none along rows that depend on others, which
            does the same to the robot.
        unique: (N, nc) whether the impulse along a row is determined.
        speeds: (N, nc, k) speeds b that the impact undoes along each row [m/s, rad/s].
        jumps: (N, nb, 6, k) jumps (Δω, Δv) of the bodies, body coordinates at their frames' origins
            (Eqs. 8 and 9).
    """

    landing: PosedLanding
    state: Dynamics
    constraints: tuple[Constraint, ...]
    delta_qd: Any
    impulse: Any
    independent_impulse: Any
    unique: np.ndarray
    speeds: Any
    jumps: Any
    _columns: dict[int, int] | None = None
    has_values = True
    """True if its numbers have values that can be compared; symbols have none."""

    moments: Any = None
    """(N, nb, 3, k) impulsive moments on the bodies beside those of the rows, world axes [N m s];
    None without.
    """

    strikes: Array | None = None
    """(N, S, 3) velocities of the base before the impact [m/s]; None for the landing's alone."""

    @functools.cached_property
    def remembered(self) -> dict[Any, Any]:
        """Intermediate results that several quantities share, by formula and places, for `once`."""
        return {}

    def exact(self, values: Array) -> Any:
        """Doubles as numbers of this impact's arithmetic.

        Their products are not rounded in it.
        """
        return values

    def rounded(self, values: Any, size: Callable[[Array], Any]) -> Array:
        """Numbers of this impact's arithmetic as doubles.

        Args: size, of the doubles: their natural size, as for `to_double`.
        """
        del size
        return np.asarray(values, dtype=float)

    def along(self, columns: Any) -> Any:
        """Values (N, S, ...) for this impact's strikes, from columns (N, ..., k) linear in them.

        For strikes v of the base it is Σ_k columns_k v_k; with a fourth column, that of the
        landing's motion, v is the difference from the landing's strike.
        """
        if self.strikes is None:
            return columns[:, None, ..., 3]
        has_motion = columns.shape[-1] == 4
        v = self._strike_change if has_motion else self.strikes
        v = v.reshape(*v.shape[:2], *(1,) * (columns.ndim - 2), 3)
        total = columns[:, None, ..., 0] * v[..., 0]
        for k in (1, 2):
            total += columns[:, None, ..., k] * v[..., k]
        return total + columns[:, None, ..., 3] if has_motion else total

    @functools.cached_property
    def strike_jumps(self) -> Any:
        """Jumps (N, S, nb, 6) of the bodies for the strikes of this impact, as `jumps`."""
        return self.along(self.jumps)

    def jumps_of(self, bodies: Sequence[int]) -> Any:
        """Jumps (N, S, n, 6) of some bodies for the strikes of this impact."""
        return self.strike_jumps[:, :, self._places_of(bodies)]

    def maps_of(self, bodies: Sequence[int]) -> Any:
        """Jumps (N, n, 6, 3) of some bodies for unit strikes, body coordinates.

        The strikes are of 1 m/s along world x, y and z.
        """
        return self.jumps[:, self._places_of(bodies), :, :3]

    def _places_of(self, bodies: Sequence[int]) -> list[int]:
        """Where bodies are in the jumps."""
        if self._columns is None:
            return list(bodies)
        return [self._columns[body] for body in bodies]

    def orientations(self, bodies: Sequence[int]) -> Any:
        """Rotations (N, n, 3, 3) of the frames of bodies, body to world."""
        return self.state.rotation[:, list(bodies)]

    def points(self, bodies: Sequence[int], r: Any) -> Any:
        """Positions (N, n, 3) of points of bodies, world axes, from the base [m].

        Args: r ([N,] n, 3) in their frames [m].
        """
        arms = (self.orientations(bodies) @ r[..., None])[..., 0]
        return self.state.position[:, list(bodies)] + arms

    def velocities_before(self, bodies: Sequence[int], points: Any) -> Any:
        """Velocities (N, S, n, 3) of points of bodies before the impact, world axes [m/s].

        Args: points (N, n, 3), as above.
        """
        before = self.landing.before
        twists = np.stack([twist_before(self.state, before, body) for body in bodies], axis=1)
        velocity = velocity_at(twists[..., :3], twists[..., 3:], points)[:, None]
        return velocity if self.strikes is None else velocity + self._strike_change[:, :, None]

    @property
    def base_velocities(self) -> Array:
        """(N, S, 3) velocities of the base before the impact, world axes [m/s]."""
        if self.strikes is not None:
            return self.strikes
        velocity = self.landing.before.velocity
        return np.broadcast_to(velocity, (len(self.state.J), 3))[:, None]

    @property
    def _strike_change(self) -> Array:
        """(N or 1, S or 1, 3) velocity of the base less the landing's [m/s]."""
        if self.strikes is None:
            return np.zeros((1, 1, 3))
        return self.strikes - self.landing.before.velocity[..., None, :]

    @functools.cached_property
    def contacts(self) -> tuple[Constraint, ...]:
        """The rows of what strikes."""
        return self.constraints[: len(self.landing.contacts)]

    @functools.cached_property
    def approach(self) -> Any:
        """Velocities (N, S, c, 3) of the contact points before the impact, world axes [m/s]."""
        points = np.stack(
            [constraint_point(self.state, constraint) for constraint in self.contacts], axis=1
        )
        velocities = self.velocities_before(
            [constraint.body for constraint in self.contacts], points
        )
        for k, constraint in enumerate(self.contacts):
            if constraint.kind == "stop":
                of_stop = velocity_at_stop(self.state, constraint, self.landing.before)
                velocities[:, :, k] = of_stop[:, None]
            if constraint.velocity is not None:
                velocities[:, :, k] = self.exact(constraint.velocity)[..., None, :]
        return velocities

    @property
    def reference_velocities(self) -> Any:
        """Velocities (N, S, k, 3) before the impact, the fastest of which normalises shock [m/s].

        They are those of the contacts, or of the centre of mass.
        """
        if self.landing.scene.v_in != "com":
            return self.approach
        bodies, masses, coms = self._moving
        velocity = self.velocities_before(bodies, self.points(bodies, coms))
        momentum = np.sum(velocity * masses[:, None, :, None], axis=-2)
        total = np.sum(masses, axis=-1)[:, None, None]
        return (momentum / total)[..., None, :]

    @functools.cached_property
    def v_in(self) -> Any:
        """Speed (N, S) that normalises shock [m/s].

        It is that of the fastest contact or of the centre of mass.
        """
        speeds = norm(self.reference_velocities)
        columns = [speeds[..., k] for k in range(speeds.shape[-1])]
        return functools.reduce(larger, columns)

    @functools.cached_property
    def inertias(self) -> Inertias:
        """The inertias of the bodies and the joints, in doubles.

        There is one for each of the N postures, or one for all.
        """
        return Inertias.of(self.landing.robot, self.landing.joint_model)

    @property
    def masses(self) -> Any:
        """Masses (N or 1, nb) of the bodies [kg]."""
        return self.inertias.mass

    @property
    def coms(self) -> Any:
        """Centres of mass (N or 1, nb, 3) of the bodies, in their frames [m]."""
        return self.inertias.com

    @functools.cached_property
    def com(self) -> Any:
        """Position (N, 3) of the robot's centre of mass, world axes, from the base [m].

        A fixed base is left out.
        """
        bodies, masses, coms = self._moving
        moments = np.sum(self.points(bodies, coms) * masses[..., None], axis=1)
        return moments / np.sum(masses, axis=-1)[:, None]

    @property
    def _moving(self) -> tuple[range, Any, Any]:
        """The bodies that can move, their masses and centres of mass."""
        robot = self.landing.robot
        movable = robot.movable(self.landing.base)
        bodies = range(len(robot.bodies))[movable]
        return bodies, self.masses[:, movable], self.coms[:, movable]

    @functools.cached_property
    def joint_origins(self) -> Any:
        """Origins (N, n, 3) of the frames of the robot's `single_joints`, from the base [m].

        In world axes.
        """
        robot = self.landing.robot
        bodies: list[int] = []
        for i, joint in enumerate(robot.joints):
            bodies += [i] * len(joint.parts or (joint,))
        return self.points(bodies, robot.joint_origins(self.state.Q))

    @property
    def spatial_inertias(self) -> Any:
        """Inertias (N, nb, 6, 6) of the bodies about the base's origin, world axes.

        As `method.dynamics.spatial_inertias`.
        """
        return spatial_inertias(self.landing.robot, self.state, self.inertias)

    @functools.cached_property
    def joint_loads(self) -> Any:
        """Wrench (N, S, nb, 6) that every body receives through its joint, about the base.

        In world axes.

        Leaf to root F_i = I_i ΔV_i − f_i + Σ F_child. That of a free base is what is left over, and
        is zero.
        """
        # I_i ΔV_i
        loads = (self.spatial_inertias[:, None] @ self._world_twists[..., None])[..., 0]
        # − f_i, and its opposite on the body at the other end
        if self.moments is not None:
            loads[..., :3] -= self.along(self.moments)
        impulse = self.along(self.impulse)
        for constraint, rows in zip(self.constraints, slices_of(self.constraints), strict=True):
            wrenches = constraint_wrenches(self.state, constraint)[:, None]
            wrench = (impulse[..., None, rows] @ wrenches)[..., 0, :]
            if constraint.body >= 0:
                loads[:, :, constraint.body] -= wrench
            if constraint.other_body >= 0:
                loads[:, :, constraint.other_body] -= -1 * wrench
        # + Σ F_child
        parents = self.landing.robot.parents
        for i in range(len(parents) - 1, 0, -1):
            if parents[i] >= 0:
                loads[:, :, parents[i]] += loads[:, :, i]
        loads[..., :3] -= self.rotor_moments
        return loads

    @property
    def _world_twists(self) -> Any:
        """Jumps (N, S, nb, 6) of the bodies at the base's origin, world axes."""
        R = self.state.rotation[:, None]
        omega = (R @ self.strike_jumps[..., :3, None])[..., 0]
        v = (R @ self.strike_jumps[..., 3:, None])[..., 0]
        v = v - cross(omega, self.state.position[:, None])
        return np.concatenate([omega, v], axis=-1)

    @functools.cached_property
    def rotor_moments(self) -> Any:
        """Moments (N, S, nb, 3) of each body's inertia for its joint's coupling, world axes.

        They are c a (a·Δω), as in `spatial_inertias`.

        They are of the rotor, which the body's parent carries, so they do not go through the joint.
        """
        moments = 0.0 * self.strike_jumps[..., :3]
        for v, body in geared_bodies(self.landing.robot, self.inertias.coupling):
            R = self.state.rotation[:, None, body]
            omega = (R @ self.strike_jumps[:, :, body, :3, None])[..., 0]
            axis = self.state.J[:, None, :3, v]
            coupling = self.exact(self.inertias.coupling[:, None, v])
            spin = np.sum(axis * omega, axis=-1)
            moments[:, :, body] = axis * (coupling * spin)[..., None]
        return moments

    def joint_power(self, joints: Sequence[tuple[int, int]]) -> Any:
        """Power (N, S, n) of the wrenches through joints in unit rates.

        Args: joints, body and velocity of each.
        """
        bodies = [body for body, _ in joints]
        columns = [column for _, column in joints]
        twists = np.swapaxes(self.state.J[:, :, columns], 1, 2)[:, None]
        return np.sum(twists * self.joint_loads[:, :, bodies], axis=-1)

    @functools.cached_property
    def ground_impulse(self) -> tuple[Any, Any]:
        """Impulse (N, S, 3) of the ground [N s], and its moment (N, S, 3) [N m s], world axes.

        The moment is about the centre of mass.

        All contacts and standing feet together, which is unique even where its parts are not.
        """
        impulse = self.along(self.independent_impulse)
        force = moment = 0.0 * self.com[:, None]
        for constraint, rows in zip(self.constraints, slices_of(self.constraints), strict=True):
            if constraint.kind in ("closure", "stop"):
                continue
            n = len(constraint.forces)
            parts = constraint_axes(self.state, constraint)[:, None] * impulse[..., rows, None]
            pushed = parts[..., :n, :].sum(axis=-2)
            turned = parts[..., n:, :].sum(axis=-2)
            arm = (constraint_point(self.state, constraint) - self.com)[:, None]
            force = force + pushed
            moment = moment + turned + cross(arm, pushed)
        return force, moment

    @functools.cached_property
    def kinetic_energy_before(self) -> Any:
        """Kinetic energy (N, S) of the motion before the impact [J].

        ½ Σ Vᵀ I V + ½ q̇ᵀ diag(A − c) q̇ with the armature A and the coupling c, which is in I.
        """
        before = self.landing.before
        bodies = range(len(self.landing.robot.bodies))
        twists = np.stack([twist_before(self.state, before, body) for body in bodies], axis=1)
        # (N, S, nb, 6), also where the landing has one strike, whatever the arithmetic.
        twists = twists[:, None] + np.zeros((1, 1, 1, 1))
        linear = twists[..., 3:] + self._strike_change[..., None, :]
        twists = np.concatenate([twists[..., :3] + 0.0 * linear, linear], axis=-1)
        momenta = (self.spatial_inertias[:, None] @ self.exact(twists)[..., None])[..., 0]
        of_bodies = np.sum(momenta * twists, axis=(-1, -2))
        armature = self.exact(self.inertias.armature) - self.exact(self.inertias.coupling)
        of_drives = np.sum(armature * self.exact(before.joint_rates) ** 2, axis=-1)
        return (of_bodies + of_drives[:, None]) / 2


class DoubleImpact(Impact):
    """Steps 1 and 2 in N postures in double precision, for S strikes each.

    Args:
        landing: the landing; its posture is not used.
        equation: Eq. 4 in the postures.
        solution: of that.
        jumps: (N, n, 6, k) of bodies, body coordinates.
        bodies: which these are; all by default.
        strikes: (N, S, 3) velocities of the base before the impact, world axes [m/s]; the landing's
            by default.
        inertias: the inertias in each posture; the landing's by default.
    """

    def __init__(
        self,
        landing: PosedLanding,
        equation: Equation,
        solution: Solution,
        jumps: Array,
        bodies: Sequence[int] | None = None,
        strikes: Array | None = None,
        inertias: Inertias | None = None,
    ) -> None:
        self.landing = landing
        self.equation = equation
        self.bodies = bodies
        self.strikes = strikes
        self.state = equation.state
        self.constraints = equation.constraints
        self.speeds = equation.b
        self.delta_qd = equation.full(solution.delta_qd)
        self.impulse = solution.impulse
        self.independent_impulse = solution.independent_impulse
        self.jumps = jumps
        if bodies is not None:
            self._columns = {body: k for k, body in enumerate(bodies)}
        self.unique = np.ones(solution.impulse.shape[:2], dtype=bool)
        self.clear = np.ones(len(self.unique), dtype=bool)
        """In which postures (N,) all rows are independent, clearly."""
        for k, row_space in solution.row_spaces.items():
            self.clear[k] = False
            self.unique[k] = row_space.unique
        if inertias is not None:
            self.inertias = inertias

    def delassus(self, constraint: Constraint) -> Array:
        """Delassus matrices (N, n, n) of a constraint's rows while nothing is held [1/kg].

        J G (GᵀHG)⁻¹ Gᵀ Jᵀ.
        """
        J, G = row_jacobian(self.state, [constraint]), self.equation.G
        J = J if G is None else J @ G
        return np.asarray(J @ solve_inertia(self.equation.inertia, np.swapaxes(J, -1, -2)))

    def rigid_mobility(self, constraint: Constraint) -> Array:
        """Mobility (N, n, n) of a constraint's rows with the robot as a free rigid body [1/kg]."""
        wrenches = constraint_wrenches(self.state, constraint)
        inertia = self.spatial_inertias.sum(axis=1)
        return np.asarray(wrenches @ np.linalg.solve(inertia, np.swapaxes(wrenches, -1, -2)))


class ColumnImpact(DoubleImpact):
    """Jumps and impulses in a column each; a quantity has k values, one of each column."""

    def along(self, columns: Any) -> Any:
        """Columns (N, ..., k) as (N, k, ...)."""
        return np.moveaxis(columns, -1, 1)


def jumps_in_body_axes(
    equation: Equation, delta: Array, bodies: Sequence[int] | None = None
) -> Array:
    """Jumps (N, nb, 6, k) of some bodies in body axes, by those of the free velocities (N, ny, k).

    The bodies are all by default.
    """
    rotation = equation.state.rotation
    if bodies is not None:
        rotation = rotation[:, list(bodies)]
    return in_body_axes(jumps_of(equation, delta, bodies), rotation)
