"""Effective masses and impact mitigation factors of single contacts.

The formulas are those of `Resistance`, in balls, and of `clear_resistance`, in doubles.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.exact_impact import BallImpact
from shockpc.impact.impact import DoubleImpact, Impact
from shockpc.impact.landed import independent_rows_of
from shockpc.landing.closure import closure_constraint
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import NO_AXES, Constraint
from shockpc.method.exact.arithmetic import entries
from shockpc.method.exact.balls import BALLS, BallMatrix, Balls, PrecisionError
from shockpc.quantities.quantity import Places

STRUCTURAL = 1e-26
"""Share of the largest mobility below which one is zero.

Rounding of axes and places by 1e-16 makes 1e-32 of a zero.
"""

CLEAR = 1e-6
"""Share of the mobility from which double precision tells it from zero, with nine digits left."""

NARROW = 1e-4
"""Largest radius of a pivot, as a share of that below which it is zero."""

IMMOVABLE = 1e-7
"""Part of the normal, along directions that cannot move, that keeps a sticking contact in place."""

LEFT_OUT = 10.0
"""The part as `IMMOVABLE` where a direction is left out, relative to rounding of the file."""

TILTS = {"edge": 1, "flat": 2}
"""Number of rotations about axes along the ground that each kind of contact holds.

They are the first of its moments.
"""

HOLD_TWIST = ("corner", "edge", "flat")
"""Kinds of contact that hold the rotation about the normal if they stick."""

PARTS = ("frictionless", "sticking", "effective", "mitigation_frictionless", "mitigation")
"""The numbers of a contact, by the names of the properties of `Resistance`."""


def resistance(part: str) -> Callable[[Impact, Places], Balls]:
    """The formula of one of `PARTS` for contacts, (N, 1, n); NaN of a standing foot."""

    def compute(impact: Impact, places: Places) -> Any:
        if isinstance(impact, DoubleImpact):
            in_doubles = [clear_resistance(impact, place.number)[part] for place in places]
            return np.stack(in_doubles, axis=-1)[:, None]
        assert isinstance(impact, BallImpact)
        known = impact.resistances
        for k in range(len(impact.contacts)):
            known.setdefault(k, Resistance(impact, k))
        values: list[Any] = []
        for place in places:
            strikes = place.number in known
            values.append(getattr(known[place.number], part) if strikes else np.nan)
        return np.array(values, dtype=object)[None, None]

    return compute


class Resistance:
    """The effective masses and mitigation factors of one contact, in balls.

    Standing feet and loops hold, but other contacts do not.

    A is the Delassus matrix of the contact point, while the rotations are held that its kind holds:
    all of a flat contact, those across an edge, the twist of a corner if it sticks. The effective
    mass along the ground's normal n is 1 / (nᵀ A n) if the contact slides, and nᵀ A⁻¹ n if it
    sticks. The impact mitigation factor is the share of the mobility that is due to joints: det(1 −
    Λ Λ_L⁻¹) with Λ = A⁻¹, and Λ_L with every joint locked (Wensing et al., T-RO 2017), in the
    directions in which joints can move the point; if the contact slides, that along n alone, 1 − nᵀ
    A_L n / nᵀ A n.

    Args:
        impact: the impact.
        number: of the contact.
    """

    def __init__(self, impact: BallImpact, number: int) -> None:
        self.impact = impact
        self.landing: PosedLanding = impact.landing
        self.contact = self.landing.scene.contact[number]
        self.constraint = impact.constraints[number]
        self.n = self.constraint.normal
        self.point = self.constraint._replace(forces=np.eye(3), moments=NO_AXES)

    @property
    def effective(self) -> Any:
        """Effective mass of the contact as it is: sticking or sliding [kg]."""
        return self.sticking if self.contact.sticks else self.frictionless

    @functools.cached_property
    def frictionless(self) -> Any:
        """Effective mass if the contact slides [kg]; inf if it cannot give way.

        Of an end stop see `_stop`.
        """
        if self.constraint.kind == "stop":
            return self._stop()
        A = self._mobility(self._held_rotations(sticks=False))
        return 1 / self._along_normal(A) if self._gives_way(A) else np.inf

    @functools.cached_property
    def sticking(self) -> Any:
        """Effective mass if the contact sticks [kg]; inf if it cannot give way.

        Of an end stop see `_stop`.
        """
        if self.constraint.kind == "stop":
            return self._stop()
        held = self._held_rotations(sticks=True)
        A = self._mobility(held)
        if not self._gives_way(A):
            return np.inf

        # With the axes V along which the point can move: m = (Vᵀ n)ᵀ (Vᵀ A V)⁻¹ Vᵀ n.
        most, immovable = self._most_axes(held)
        axes = sorted(moving_axes(A)[:most])
        V = BALLS.matrix(np.eye(3)[:, axes])
        n = BALLS.matrix(self.n[:, None])
        along = V.transpose() * n
        impulse = (V.transpose() * A * V).solve(along)

        # The point is held where the normal has a part along none of these axes.
        left = (n - A * V * impulse).entries()
        if max(abs(float(x)) for x in left) > immovable:
            return np.inf
        return (along.transpose() * impulse)[0, 0]

    @functools.cached_property
    def mitigation_frictionless(self) -> Any:
        """Impact mitigation factor of the contact point if it slides [1].

        It is nᵀ (A − A_L) n / nᵀ A n; NaN where it has no meaning.
        """
        if not self.landing.floating or self.constraint.kind == "stop":
            return np.nan
        by_joints = self._along_normal(self.mobility_by_joints)
        if not float(by_joints) > STRUCTURAL * _largest(self.point_mobility):
            return 0.0
        return by_joints / self._along_normal(self.point_mobility)

    @functools.cached_property
    def mitigation(self) -> Any:
        """Impact mitigation factor of the contact point if it sticks [1].

        It is det(A⁻¹ (A − A_L)); NaN where it has no meaning.
        """
        if not self.landing.floating or self.constraint.kind == "stop":
            return np.nan
        axes = sorted(moving_axes(self.point_mobility))
        A = _part(self.point_mobility, axes, axes)
        by_joints = _part(self.mobility_by_joints, axes, axes)
        moved = sorted(moving_axes(by_joints, _largest(A)))
        if not moved:
            return 0.0
        # The determinant of A⁻¹ D over the range of D = A − A_L, which is a plane or a line where
        # the joints move the point in that alone. With columns C of D that span it:
        # det(Cᵀ A⁻¹ C) / det(D there).
        columns = _part(by_joints, list(range(len(axes))), moved)
        of_columns = (columns.transpose() * A.solve(columns)).det()
        return of_columns / _part(by_joints, moved, moved).det()

    @functools.cached_property
    def point_mobility(self) -> BallMatrix:
        """A of the contact point, whose link is free to turn."""
        return self._delassus(self.point, self._constraints(NO_AXES))

    @functools.cached_property
    def mobility_by_joints(self) -> BallMatrix:
        """A − A_L: what the joints add to the mobility of the contact point."""
        locked: BallMatrix = self.impact.rigid_mobility(self.point)
        return self.point_mobility - locked

    def _stop(self) -> Any:
        """The inertia about the joint of an end stop, or the mass along it [kg m², kg]."""
        A = self._delassus(self.constraint, self._constraints(NO_AXES))
        return 1 / entries(A)[0, 0]

    def _held_rotations(self, sticks: bool) -> Array:
        """The axes (m, 3) about which the contact is held.

        Args: sticks, whether it does, and so holds the twist too.
        """
        held = self.constraint.moments[: TILTS.get(self.contact.kind, 0)]
        if sticks and self.contact.kind in HOLD_TWIST:
            held = np.concatenate([held, self.n[None]])
        return held

    def _mobility(self, held: Array) -> BallMatrix:
        """A while the contact's rotations about some axes (m, 3) are held."""
        if not len(held):
            return self.point_mobility
        return self._delassus(self.point, self._constraints(held))

    def _constraints(self, held: Array) -> tuple[Constraint, ...]:
        """Standing feet, loops, and the contact's rotations about some axes (m, 3)."""
        loops = tuple(closure_constraint(loop) for loop in self.landing.loops)
        constraints: tuple[Constraint, ...] = (*self.landing.stance, *loops)
        if len(held):
            constraints += (self.point._replace(forces=NO_AXES, moments=held),)
        return constraints

    def _delassus(self, rows: Constraint, constraints: tuple[Constraint, ...]) -> BallMatrix:
        """The Delassus matrix of some rows while constraints hold [1/kg]."""
        independent = independent_rows_of(self.landing, constraints)
        A: BallMatrix = self.impact.delassus(rows, constraints, independent)
        return A

    def _most_axes(self, held: Array) -> tuple[int, float]:
        """The most axes along which the mechanism lets the point move.

        The second is the part of the normal along the others with which it cannot give way: along
        what is left out, the point moves only by what rounding of the file leaves.
        """
        landing = self.landing
        if landing.floating:
            return 3, IMMOVABLE
        constraints = self._constraints(held)
        rows, rounded = landing.row_limits(landing.state, (*constraints, self.point))(0)
        rows_held, _ = landing.row_limits(landing.state, constraints)(0)
        most = rows - rows_held
        if most == 3:
            return most, IMMOVABLE
        return most, max(IMMOVABLE, LEFT_OUT * rounded)

    def _along_normal(self, A: BallMatrix) -> Any:
        """nᵀ A n."""
        n = BALLS.numbers(self.n)
        return n @ entries(A) @ n

    def _gives_way(self, A: BallMatrix) -> bool:
        """True if a point of mobility A can move along the normal at all."""
        return bool(float(self._along_normal(A)) > STRUCTURAL * _largest(A))


def clear_resistance(impact: DoubleImpact, number: int) -> dict[str, Array]:
    """The numbers (N,) of `Resistance`, by the names of `PARTS`, in doubles.

    They are NaN where robot and joints do not clearly move the point in every direction.
    """
    landing = impact.landing
    constraint = impact.constraints[number]
    is_point = constraint.kind != "stop" and not len(constraint.moments)
    strikes = number < len(landing.contacts)
    is_free = landing.floating and not landing.loops
    if not (is_free and is_point and strikes):
        return dict.fromkeys(PARTS, np.full(len(impact.state.J), np.nan))
    # All three directions count, whichever of them the contact stops.
    point = constraint._replace(forces=np.eye(3), moments=NO_AXES)
    n = constraint.normal
    A = impact.delassus(point)
    by_joints = A - impact.rigid_mobility(point)

    # The smallest eigenvalues of A and A − A_L tell in doubles whether they are regular.
    trace = np.trace(A, axis1=1, axis2=2)
    robot_moves = np.linalg.eigvalsh(A)[:, 0] > CLEAR * trace
    joints_move = np.linalg.eigvalsh(by_joints)[:, 0] > CLEAR * trace
    # 1 / (nᵀ A n), nᵀ A⁻¹ n, nᵀ (A − A_L) n / nᵀ A n and det(A⁻¹ (A − A_L)).
    regular = np.where(robot_moves[:, None, None], A, np.eye(3))
    with np.errstate(all="ignore"):
        frictionless = 1.0 / (n @ A @ n)
        sticking = np.linalg.inv(regular) @ n @ n
        mitigation_frictionless = (n @ by_joints @ n) * frictionless
        mitigation = np.linalg.det(by_joints) / np.linalg.det(A)
    numbers = {
        "frictionless": np.where(robot_moves, frictionless, np.nan),
        "sticking": np.where(robot_moves, sticking, np.nan),
        "mitigation_frictionless": np.where(joints_move, mitigation_frictionless, np.nan),
        "mitigation": np.where(joints_move, mitigation, np.nan),
    }
    sticks = landing.scene.contact[number].sticks
    numbers["effective"] = numbers["sticking" if sticks else "frictionless"]
    return numbers


def _largest(A: BallMatrix) -> float:
    """The largest entry on the diagonal."""
    diagonal = [row[i] for i, row in enumerate(A.table())]
    return max(map(float, diagonal))


def _part(A: BallMatrix, rows: list[int], columns: list[int]) -> BallMatrix:
    """Some rows and columns of a matrix."""
    part: BallMatrix = BALLS.matrix(entries(A)[np.ix_(rows, columns)])
    return part


def moving_axes(A: BallMatrix, largest: float = 0.0) -> list[int]:
    """World axes along which a point of mobility A moves independently.

    They are the pivots of an elimination, largest pivot first.

    Args:
        A: mobility.
        largest: of the mobility that A is a part of [1/kg].

    Raises:
        PrecisionError: it cannot be decided whether a pivot is zero.
    """
    S = A.table()
    least = STRUCTURAL * max(_largest(A), largest)
    axes: list[int] = []
    left = list(range(A.nrows()))
    while left:
        k = max(left, key=lambda i: float(S[i][i]))
        pivot = S[k][k]
        if not float(pivot.rad()) <= NARROW * least:
            raise PrecisionError
        if not float(pivot) > least:
            break
        axes.append(k)
        left.remove(k)
        for i in left:
            share = S[i][k] / pivot
            for j in left:
                S[i][j] -= share * S[k][j]
    return axes
