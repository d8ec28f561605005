"""The rows along which contacts act with friction or on springs.

Each contact has rows along tangents of the ground and its normal.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.landed import independent_rows_of, rows_as_meant
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.directions import across
from shockpc.method.constraints import NO_AXES, Constraint, slices_of
from shockpc.method.equation import Equation


@dataclass(frozen=True)
class RowLayout:
    """The n rows of contacts and standing feet, whatever the posture.

    They are along the tangents of the ground along which a contact is stopped, none to two, and
    along its normal.

    Attributes:
        constraints: which constraints of Eq. 4 have some.
        rigid: (nc,) which rows of the equation are held rigidly: of loops, the tilt of soles, and
            of feet that stay where they are.
        turn: (n, nc) the rows of contacts, of those of the equation.
        axes: (n, 3) along which they are, world axes.
        number: (n,) contact or standing foot of each row.
        axis: (n,) tangent 0 or 1, or normal 2, of each row.
        restitution: (n,) e of each row: of a contact that sticks, with restitution along the
            normal, zero along the tangents.
    """

    constraints: list[int]
    rigid: np.ndarray
    turn: Array
    axes: Array
    number: np.ndarray
    axis: np.ndarray
    restitution: Array

    @property
    def normal(self) -> np.ndarray:
        """Mask (n,) of the rows along the normal of their contact."""
        return np.asarray(self.axis == 2)

    @property
    def index(self) -> np.ndarray:
        """Indices (n,) of the rows where every contact has three: two tangents and the normal."""
        return np.asarray(3 * self.number + self.axis)


@dataclass(frozen=True)
class ContactRows(RowLayout):
    """The rows in a posture, in coordinates with which what is held rigidly stays so.

    Attributes:
        equation: Eq. 4 of the landing.
        speeds: (n,) along each row before the impact, and after what is held rigidly has stopped
            [m/s].
        halt: (ny,) jump with which a sole that turns stops turning [rad/s, m/s].
        basis: (ny, m) the free velocities for unit coordinates.
        M: (m, m) inertia.
        J: (n, m) speeds along the rows.
    """

    equation: Equation
    speeds: Array
    halt: Array
    basis: Array
    M: Array
    J: Array

    def frequency(self, stiffness: Array, straight: Array) -> float:
        """The natural frequency ω [rad/s] of the mass m that sticking contacts stop.

        ω² = Σ k s² / Σ m s² of the speeds s.

        Args:
            stiffness: (n,) k of the rows [N/m].
            straight: (h, m) speeds for unit coordinates of what the contacts stop too, as of hinges
                in links that bend.
        """
        rows = np.vstack([self.J, straight])
        speeds = np.append(self.speeds, np.zeros(len(straight)))
        delassus = rows @ np.linalg.solve(self.M, rows.T)
        impulse = np.linalg.lstsq(delassus, speeds, rcond=1e-10)[0]
        stiffness_sum = (stiffness * self.speeds) @ self.speeds
        return float(np.sqrt(stiffness_sum / (speeds @ impulse)))


def contact_rows(landing: PosedLanding, stands: bool = False) -> ContactRows:
    """The rows of contacts and standing feet.

    A contact that slides along a direction has only the rows along the others.

    An end stop that strikes has one row, like a normal; those that merely act are left out.

    Args:
        landing: in its posture.
        stands: whether standing feet stay where they are, as in Eq. 4, and have no rows.
    """
    landing = landing.without_stops
    equation = landing.equation(landing.state)
    layout = row_layout(landing.constraints, stands)
    J, b = rows_as_meant(landing)
    H = equation.H[0]
    basis = np.eye(len(H))
    halt = np.zeros(len(H))
    if layout.rigid.any():
        # Of what is held rigidly, K: the jump −H⁻¹ Kᵀ (K H⁻¹ Kᵀ)⁻¹ b, and the null space.
        independent = _independent_rigid_rows(landing, layout)
        K = equation.J_c[0, independent]
        by_impulse = np.linalg.solve(H, K.T)
        halt = -by_impulse @ np.linalg.solve(K @ by_impulse, equation.b[0, independent, 3])
        basis = np.linalg.qr(K.T, mode="complete")[0][:, len(K) :]
    along = layout.turn @ J
    before = layout.turn @ b / (1.0 + layout.restitution)
    return ContactRows(
        **{field.name: getattr(layout, field.name) for field in fields(layout)},
        equation=equation,
        speeds=before + along @ halt,
        halt=halt,
        basis=basis,
        M=basis.T @ H @ basis,
        J=along @ basis,
    )


def _independent_rigid_rows(landing: PosedLanding, layout: RowLayout) -> np.ndarray:
    """The rows of Eq. 4, of those held rigidly, from which all of these follow."""
    constraints = list(landing.constraints)
    for k in layout.constraints:
        constraints[k] = _without_rows(constraints[k])
    independent = independent_rows_of(
        landing, tuple(constraint for constraint in constraints if constraint.size)
    )
    return np.asarray(np.flatnonzero(layout.rigid)[independent])


def row_layout(constraints: tuple[Constraint, ...], stands: bool = False) -> RowLayout:
    """The rows of contacts and standing feet. Args: as of `contact_rows`."""
    # Feet that stay where they are, as in Eq. 4, have no rows.
    kinds = ("contact", "stop") if stands else ("contact", "stop", "stance")
    having_rows = [k for k, constraint in enumerate(constraints) if constraint.kind in kinds]
    # What stays rigid are loops, the tilt of soles, and feet that stay where they are.
    rigid = np.ones(sum(constraint.size for constraint in constraints), dtype=bool)
    parts: list[_ContactLayout] = []
    for k in having_rows:
        part = _contact_layout(constraints[k], slices_of(constraints)[k].start, len(rigid))
        rigid[part.forces] = False
        parts.append(part)
    return RowLayout(
        constraints=having_rows,
        rigid=rigid,
        turn=np.concatenate([part.turn for part in parts]),
        axes=np.concatenate([part.axes for part in parts]),
        number=np.repeat(np.arange(len(parts)), [len(part.axis) for part in parts]),
        axis=np.concatenate([part.axis for part in parts]),
        restitution=np.concatenate([part.restitution for part in parts]),
    )


class _ContactLayout(NamedTuple):
    """The k rows of one contact, arrays as of `RowLayout`; forces, where its rows in Eq. 4 are."""

    forces: slice
    turn: Array
    axes: Array
    axis: np.ndarray
    restitution: Array


def _contact_layout(constraint: Constraint, start: int, size: int) -> _ContactLayout:
    """The rows of a contact. Args: start, its first row in Eq. 4; size, the number of these."""
    axes, axis = _axes(constraint)
    # A stop has one row, along the rate of its joint; of others Fᵀ x = aᵀ for each axis a.
    forces = slice(start, start + 1)
    by_forces: Array = np.ones((1, 1))
    if constraint.kind != "stop":
        forces = slice(start, start + len(constraint.forces))
        by_forces = np.asarray(np.linalg.lstsq(constraint.forces.T, axes.T, rcond=None)[0].T)
    turn = np.zeros((len(axes), size))
    turn[:, forces] = by_forces
    # With a direction of rebound, the normal alone has restitution.
    bounces = (axis == 2) | (constraint.rebound is None)
    return _ContactLayout(forces, turn, axes, axis, np.where(bounces, constraint.restitution, 0.0))


def _without_rows(constraint: Constraint) -> Constraint:
    """A contact without the rows that are not held rigidly on springs or with friction.

    An end stop has no other rows.
    """
    return constraint._replace(
        forces=NO_AXES, moments=NO_AXES if constraint.kind == "stop" else constraint.moments
    )


def _axes(constraint: Constraint) -> tuple[Array, np.ndarray]:
    """The axes (n, 3) of a contact and their numbers (n,): 0 and 1 for tangents, 2 for the normal.

    The tangents are those of the ground along which the contact is stopped.
    """
    if constraint.kind == "stop":
        return np.zeros((1, 3)), np.array([2])
    _, size, basis = np.linalg.svd(constraint.forces)
    rounding = 3.0 * np.finfo(float).eps * size[0]
    rank = int(np.sum(size > rounding))
    normal = constraint.normal
    if rank == 3:
        return np.array([*across(normal), normal]), np.arange(3)
    if rank == 1:
        return normal[None], np.array([2])
    # The plane in which it is stopped holds the normal; their tangent is across its own normal.
    tangent = np.cross(np.cross(*basis[:2]), normal)
    return np.array([tangent, normal]), np.array([0, 2])
