"""The shock of a landing in many postures, as maps from the strike with their derivatives."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.number import numbers_from
from shockpc.core.spatial import Array, cross, jump_at
from shockpc.core.threads import one_thread
from shockpc.landing.landing import Landing
from shockpc.landing.places import moving_point
from shockpc.landing.scenes.scene_file import point_at
from shockpc.method.approach import speeds_undone
from shockpc.method.constraints import constraint_axes, slices_of
from shockpc.method.dynamics import dynamics
from shockpc.method.equation import Equation
from shockpc.method.shock import solution_of
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.errors import SceneError, StudyError
from shockpc.text.printed import count

GRADIENTS = ("shock", "delta_v", "most_severe")
"""Quantities of points of which maps give the gradient."""

SINGLE = 1e-9
"""Share of the largest singular value by which the next one is less where the largest is single."""

CHUNK = 512
"""Postures that are computed together, so that their arrays stay in the processor's cache."""


class WorstStrike(NamedTuple):
    """The strike of several that is the worst in each of N postures.

    Attributes:
        shock: (N,) that it causes [1].
        strike: (N,) its index.
        gradient: (N, nv) of that shock by the tangent of q [1/m, 1/rad]; None where the maps have
            no derivatives.
    """

    shock: Array
    strike: np.ndarray
    gradient: Array | None


class ShockMaps(NamedTuple):
    """The shock of a landing in N postures.

    Δv is linear in the strike, so every strike angle and speed is a product.

    Attributes:
        landing: of which these are postures.
        Q: (N, nq) configurations.
        maps: (N, nb, 6, 3) jump (Δω, Δv at the body frame's origin) of every body for a strike of 1
            m/s along world x, y and z; world axes, double precision [rad/s, m/s].
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) origins of the body frames, from the base [m].
        rank: (N,) number of independent contact and closure rows.
        condition: (N,) estimated factor by which rounding is enlarged [1]; inf where double
            precision has no solution.
        prove: (N,) whether the posture needs a proof: its rows depend on one another, or nearly,
            rounding may show above 1e-9, or joints move so fast that it may be singular, which
            `shock_profile` refuses.
        columns: (N, 6, nv) twist that each unit joint velocity gives to the bodies behind it, world
            axes, about the base.
        derivatives: (N, nb, 6, 3, nv) of the maps by the tangent of q, Pinocchio's layout: those of
            a floating base are in its axes. A follower, a locked joint or one of a loop has a
            column too, in which the others stay. NaN in a singular posture, where fewer rows are
            independent than beside it, and where a lowest point jumps. None if they were not asked
            for.
    """

    landing: Landing
    Q: Array
    maps: Array
    rotation: Array
    position: Array
    rank: np.ndarray
    condition: Array
    prove: np.ndarray
    columns: Array
    derivatives: Array | None = None

    def __repr__(self) -> str:
        return f"ShockMaps({self.landing!r}; {count(len(self.Q), 'posture')})"

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.landing.robot

    def at(self, place: str | int, point: Array | None = None) -> Array:
        """Maps (N, 3, 3) from strike to jump of a point, world axes.

        Args:
            place: a frame, FRAME:x,y,z, or the index of a body.
            point: (3,) in the frame of the body, if that is an index [m]; by default its origin.

        Raises:
            UnknownName: the robot has no frame of that name.
            StudyError: the frame is fixed to the world, so no impact moves it.
            SceneError: there is no body of that index, or the point is not three numbers, or
                given besides a frame.
        """
        body, r = self._where(place, point)
        return np.asarray(jump_at(self.maps[:, body], self.rotation[:, body] @ r))

    def derivatives_at(self, place: str | int, point: Array | None = None) -> Array:
        """Derivatives (N, 3, 3, nv) of the maps of a point, as `at`.

        The point stays where it is on its body.

        Raises:
            UnknownName: the robot has no frame of that name.
            StudyError: the maps have no derivatives, a posture is singular, or as for `at`.
            SceneError: as for `at`.
        """
        if self.derivatives is None:
            raise StudyError(
                "these maps have no derivatives; compute them with shock_maps(landing, Q, "
                "derivatives=True)"
            )
        body, r = self._where(place, point)
        slopes = self.derivatives[:, body]
        if not np.isfinite(slopes).all():
            singular = np.flatnonzero(~np.isfinite(slopes).all(axis=(1, 2, 3)))
            raise StudyError(
                f"posture {singular[0]} (of {len(singular)} such) has no derivatives: it is "
                "singular, or nearly, so that fewer contact and closure rows are independent "
                "there than beside it, or several points of a contact are equally low; leave it "
                "out, or take a posture beside it"
            )
        n, nv = len(slopes), slopes.shape[-1]
        r = self.rotation[:, body] @ r
        moved = jump_at(slopes.reshape(n, 6, -1), r).reshape(n, 3, 3, nv)
        # r turns with the body: Δω × (ω_k × r).
        omega = self.columns[:, :3].swapaxes(1, 2) * self.robot.ancestors[body][:, None]
        turned = cross(omega, r[:, None])
        delta_omega = self.maps[:, body, :3].swapaxes(1, 2)
        by_turning = cross(delta_omega[:, :, None], turned[:, None])
        return np.asarray(moved + by_turning.transpose(0, 3, 1, 2))

    def delta_v(self, place: str | int, strike: Array | Sequence[float] | None = None) -> Array:
        """Jumps (N, 3) of the velocity of a point, world axes [m/s].

        Args:
            place: as for `at`.
            strike: (3,) or (N, 3) velocity of the robot before the impact, world axes [m/s]; that
                of the landing by default.

        Raises:
            ShockError: as for `at`; or before the landing the robot also rotates, or joints or
                contacts move: that is no strike along one vector.
        """
        return np.asarray((self.at(place) @ self._strike(strike)[..., None])[..., 0])

    def shock(self, place: str | int, strike: Array | Sequence[float] | None = None) -> Array:
        """Shock |Δv| / v_in (N,) of a point (Eq. 2). Args and errors: as for `delta_v`."""
        speed = np.linalg.norm(self.delta_v(place, strike), axis=-1)
        v_in = np.linalg.norm(self._strike(strike), axis=-1)
        return np.asarray(speed / v_in)

    @checked
    def gradient(self, quantity: str, strike: Array | Sequence[float] | None = None) -> Array:
        """The derivatives of a quantity of a point by the tangent of q [its unit per m and rad].

        Args:
            quantity: "shock@PLACE" (N, nv), "most_severe@PLACE" (N, nv), or "delta_v@PLACE" (N, 3,
                nv), world axes.
            strike: as for `delta_v`.

        Returns: NaN where a shock is zero, or the most severe strike is one of several: there it
            has a kink.

        Raises:
            ShockError: it is another quantity, a posture has no derivatives, or as for `delta_v`.
        """
        key, _, place = quantity.partition("@")
        if key not in GRADIENTS or not place:
            raise StudyError(
                f'maps have no gradient of "{quantity}"; valid are '
                + ", ".join(f"{key}@PLACE" for key in GRADIENTS)
            )
        change = self.derivatives_at(place)
        if key == "most_severe":
            # A = U S Vᵀ: the change of the largest singular value is u₁ᵀ dA v₁.
            left, s, right = np.linalg.svd(self.at(place))
            slope = np.einsum("ni,nijk,nj->nk", left[..., 0], change, right[:, 0])
            single = s[:, :1] - s[:, 1:2] > SINGLE * s[:, :1]
            return np.asarray(np.where(single, slope, np.nan))
        v = self._strike(strike)
        along = np.einsum("nijk,nj->nik", change, np.broadcast_to(v, (len(change), 3)))
        if key == "delta_v":
            return np.asarray(along)
        # The change of |Δv| / |v| is Δv · dA v / (|Δv| |v|).
        with np.errstate(invalid="ignore"):
            jump = self.delta_v(place, v)
            unit = jump / np.linalg.norm(jump, axis=-1, keepdims=True)
            slope = np.einsum("ni,nik->nk", unit, along)
            return np.asarray(slope / np.linalg.norm(v, axis=-1, keepdims=True))

    def worst(self, place: str | int, strikes: Array | Sequence[Sequence[float]]) -> WorstStrike:
        """The worst shock of a point over some strikes, with its gradient.

        There is a gradient where the maps have derivatives.

        Args:
            place: as for `at`.
            strikes: (S, 3) velocities of the robot before the impact, world axes [m/s].

        Raises:
            ShockError: as for `gradient`.
        """
        every = doubles("strikes", strikes)
        if every.ndim != 2 or every.shape[1] != 3 or not len(every):
            raise SceneError(
                f"contact velocities have shape {every.shape}; give at least one row of three "
                "numbers, (S, 3)"
            )
        shocks = np.stack([self.shock(place, strike) for strike in every], axis=1)
        k = shocks.argmax(axis=1)
        name = place if isinstance(place, str) else self.robot.bodies[place].name
        slope = None if self.derivatives is None else self.gradient(f"shock@{name}", every[k])
        return WorstStrike(shocks.max(axis=1), k, slope)

    def joint_jumps(self, qd: Array | Sequence[float]) -> Array:
        """Jumps Δq̇ (N, nv) of all joint velocities, the base's included.

        They are those of whatever velocity before the impact.

        Args:
            qd: (nv,) or (N, nv) velocities before the impact, Pinocchio's layout [rad/s, m/s].

        Raises:
            SceneError: qd has another shape, or a contact has a velocity.
        """
        return self._after(qd)[0]

    def impulse(self, qd: Array | Sequence[float]) -> Array:
        """Impulses (N, c, 3) of the ground on the robot, world axes [N s].

        They are at the contacts, then the standing feet; NaN where contact or closure rows depend
        on one another, so that the impulse is not determined. Args and errors: as for
        `joint_jumps`.
        """
        return self._after(qd)[1]

    def _after(self, qd: Array | Sequence[float]) -> tuple[Array, Array]:
        """Δq̇ (N, nv) and the impulses (N, c, 3), solved again for other speeds."""
        landing, nv, n = self.landing, self.robot.model.nv, len(self.Q)
        rates = doubles("qd", qd)
        if rates.shape not in ((nv,), (n, nv)):
            raise SceneError(
                f"qd has shape {rates.shape}; give velocities of shape ({nv},), or ({n}, {nv}) "
                "with a row for each posture"
            )
        if any(contact.velocity is not None for contact in landing.contacts):
            raise SceneError(
                "a contact has a velocity, which is no joint velocity; leave it out of the scene"
            )
        rates = np.broadcast_to(rates, (n, nv))
        jumps = np.empty((n, nv))
        impulses = list[Array]()
        with one_thread(nv):
            for k in range(0, n, CHUNK):
                chunk = slice(k, k + CHUNK)
                state = dynamics(self.robot, self.Q[chunk], landing.joint_model)
                equation = landing.equation(state, with_strike=False)
                speeds = speeds_undone(state, equation.constraints, rates[chunk])
                equation = equation._replace(b=speeds)
                limits = landing.row_limits(state, equation.constraints)
                solution = solution_of(equation, limits)
                jumps[chunk] = equation.full(solution.delta_qd)[..., 0]
                impulses.append(_impulses(landing, equation, solution))
        return jumps, np.concatenate(impulses)

    def _where(self, place: str | int, point: Array | None) -> tuple[int, Array]:
        if isinstance(place, str):
            if point is not None:
                raise SceneError(
                    f"point is given besides the frame {place}; write {place}:x,y,z, or give the "
                    "index of a body"
                )
            where = moving_point(self.robot, point_at(self.robot, place))
            return where.body, where.r
        is_index = isinstance(place, int | np.integer) and not isinstance(place, bool)
        if not is_index or place not in range(self.maps.shape[1]):
            raise SceneError(
                f"there is no body {place}; give a frame, or the index of a body below "
                f"{self.maps.shape[1]}"
            )
        r = np.zeros(3) if point is None else doubles("point", point)
        if r.shape != (3,):
            raise SceneError(f"point has shape {r.shape}; give three numbers")
        return place, r

    def _strike(self, strike: Array | Sequence[float] | None) -> Array:
        if strike is not None:
            v = doubles("strike", strike)
            has_shape = v.shape in ((3,), (len(self.Q), 3))
            if not has_shape or not np.any(v, axis=-1).all():
                raise SceneError(
                    "a contact velocity is three numbers that are not all zero, or "
                    f"({len(self.Q)}, 3) with a row for each posture"
                )
            return v
        if not self.landing.translates:
            raise SceneError(
                "before the impact the robot also rotates, or joints or contacts move "
                "independently, so there is no single contact velocity; give it, or give "
                "joint_jumps the joint velocities"
            )
        return self.landing.before.velocity


def doubles(name: str, values: Any) -> Array:
    """Numbers as an array of doubles. Args: name, by which they are given.

    Raises:
        SceneError: one is none, or not finite.
    """
    try:
        array = numbers_from(values)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    finite = np.isfinite(array)
    if not finite.all():
        row = ""
        if array.ndim > 1:
            first, *_ = np.argwhere(~finite)[0]
            row = f"row {first} of "
        raise SceneError(
            f"{row}{name} holds a number that is not finite, or something else; give finite numbers"
        )
    return array


def _impulses(landing: Landing, equation: Equation, solution: Solution) -> Array:
    """Impulses (N, c, 3) at the contacts and standing feet, world axes [N s].

    They are NaN where they are not determined.
    """
    impulses = []
    feet = equation.constraints[: len(landing.contacts) + len(landing.stance)]
    for foot, rows in zip(feet, slices_of(feet), strict=True):
        n = len(foot.forces)
        forces = slice(rows.start, rows.start + n)
        axes = constraint_axes(equation.state, foot)[:, :n]
        impulse = (solution.impulse[:, None, forces, 0] @ axes)[:, 0]
        for k, row_space in solution.row_spaces.items():
            if not row_space.unique[forces].all():
                impulse[k] = np.nan
        impulses.append(impulse)
    return np.stack(impulses, axis=1)
