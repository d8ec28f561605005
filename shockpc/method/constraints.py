"""The rows held during an impact: contacts, standing feet and loops, described once.

A row is a unit force or moment on one body, and its opposite on another, at a point fixed in a
body, along an axis fixed in the world or in a body. The description does not know the posture. It
is evaluated for N postures, in doubles or, for a proof, in balls.
"""

import itertools
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.impulse import DATA_TOLERANCE, TOLERANCE
from shockpc.core.percussion import larger, norm
from shockpc.core.spatial import Array, cross
from shockpc.method.dynamics import Dynamics
from shockpc.robot.shapes.convex import Shape

NO_AXES, NO_NORMAL = np.zeros((0, 3)), np.zeros(3)


class Constraint(NamedTuple):
    """The rows of one contact, standing foot, closure or end stop: its forces, then its moments.

    Attributes:
        kind: only the rows of a contact and of a stop have a speed to undo.
        frame: name of what is held.
        body: index of the body on which the unit impulses act; −1 for the world.
        point: (3,), or (N, 3) where it differs between postures, at which they act, in the body's
            frame [m].
        forces: (n, 3) axes of the unit forces.
        moments: (m, 3) axes of the unit moments.
        other_body: index of the body on which the opposite impulses act; −1 for the ground or the
            world.
        axes_body: index of the body in whose frame the axes are fixed; −1 for the world.
        restitution: e, by which the impact reverses the speed [1].
        rebound: (3,) unit direction along which it does so, at each point of a flat contact; None
            where along each row (Eq. 4).
        normal: (3,) unit normal of the ground at a contact or standing foot, world axes.
        velocity: (3,), or (N, 3) where it differs between postures, of the point before the impact,
            world axes, where it is not that of the robot's motion [m/s].
        sole: (n, 3) corners of the sole of which what carries is held, in the body's frame [m];
            none of a point.
        lowest: shapes of which the lowest point is the contact in each posture; until the postures
            are known, `point` is an offset from it. Empty where the point is fixed in the body.
    """

    kind: Literal["contact", "stance", "closure", "stop"]
    frame: str
    body: int
    point: Array
    forces: Array
    moments: Array = NO_AXES
    other_body: int = -1
    axes_body: int = -1
    restitution: float = 0.0
    rebound: Array | None = None
    normal: Array = NO_NORMAL
    velocity: Array | None = None
    sole: Array = NO_AXES
    lowest: tuple[Shape, ...] = ()

    @property
    def name(self) -> str:
        """For messages, such as 'contact "foot"'."""
        return f'{self.kind} "{self.frame}"'

    @property
    def size(self) -> int:
        """Number of its rows."""
        return len(self.forces) + len(self.moments)


def slices_of(constraints: Sequence[Constraint]) -> tuple[slice, ...]:
    """Where the rows of each constraint lie among all rows."""
    ends = itertools.accumulate(constraint.size for constraint in constraints)
    return tuple(
        slice(end - constraint.size, end) for constraint, end in zip(constraints, ends, strict=True)
    )


def constraint_point(state: Dynamics, constraint: Constraint) -> Array:
    """Position (N, 3) of the point of a constraint, world axes, from the base [m]."""
    return world_point(state, constraint.body, constraint.point)


def world_point(state: Dynamics, body: int, point: Array) -> Array:
    """Position (N, 3) of a point of a body or of the world, world axes, from the base [m].

    Args: point (3,) or (N, 3).
    """
    if body < 0:
        return np.asarray(point - state.origin)
    arm = (state.rotation[:, body] @ point[..., None])[..., 0]
    return np.asarray(state.position[:, body] + arm)


def constraint_axes(state: Dynamics, constraint: Constraint) -> Array:
    """Axes (N, n + m, 3) of the forces, then of the moments, in the world."""
    axes = np.concatenate([constraint.forces, constraint.moments])
    if constraint.axes_body < 0:
        # Adding zeros makes balls of them where the posture is in balls, before doubles are
        # multiplied with doubles and rounded.
        return np.asarray(axes + 0.0 * state.origin[:, None])
    return np.asarray(axes @ np.swapaxes(state.rotation[:, constraint.axes_body], -1, -2))


def constraint_wrenches(state: Dynamics, constraint: Constraint) -> Array:
    """Wrenches (N, n + m, 6) of the unit forces, then of the unit moments, world axes.

    A wrench is the moment about the origin [m], then the force.
    """
    return wrenches(
        constraint_point(state, constraint),
        constraint_axes(state, constraint),
        len(constraint.forces),
    )


def wrenches(point: Array, axes: Array, n: int) -> Array:
    """Wrenches (..., n + m, 6) of n unit forces at a point (..., 3), then of m unit moments.

    Laid out as those of `constraint_wrenches`.

    Args: axes (..., n + m, 3) of the forces, then of the moments.
    """
    out = np.zeros((*axes.shape[:-1], 6), dtype=axes.dtype)
    forces = axes[..., :n, :]
    out[..., :n, :3] = cross(point[..., None, :], forces)
    out[..., :n, 3:] = forces
    out[..., n:, :3] = axes[..., n:, :]
    return out


def row_jacobian(state: Dynamics, constraints: Sequence[Constraint]) -> Array:
    """J_c (N, nc, nv): the speed along each row for unit joint velocities (shock paper, Eq. 4).

    It is the power of the row's wrench.
    """
    rows = []
    for constraint in constraints:
        rows.append(constraint_wrenches(state, constraint) @ state.J * row_signs(state, constraint))
    return np.concatenate(rows, axis=1)


def row_terms(state: Dynamics, constraints: Sequence[Constraint]) -> Array:
    """Sizes (N, nc, nv) of the terms that the entries of J_c are sums of.

    Rounding in an entry is a share of its terms.

    They are lengths of vectors, not of their components: a rotation spreads the rounding of a
    vector over all its components, so the speed of a planar robot across its plane is a rounding
    error of the speed in it.
    """
    angular = norm(np.swapaxes(state.J[:, :3], 1, 2))
    linear = norm(np.swapaxes(state.J[:, 3:], 1, 2))
    # The linear part of a rotating joint is a product of its axis and its origin, which may be
    # parallel.
    origin = norm(state.position)[:, np.argmax(state.ancestors, axis=0)]
    linear = larger(linear, angular * origin)
    terms = []
    for constraint in constraints:
        r = norm(constraint_point(state, constraint))[:, None]
        moved = np.abs(row_signs(state, constraint))
        terms += [(r * angular + linear) * moved] * len(constraint.forces)
        terms += [angular * moved] * len(constraint.moments)
    return np.stack(terms, axis=1)


def row_tolerance(constraints: Sequence[Constraint]) -> float:
    """Relative error of the terms of some rows.

    It is rounding, or the error of the data where a loop is closed.
    """
    return (
        DATA_TOLERANCE
        if any(constraint.kind == "closure" for constraint in constraints)
        else TOLERANCE
    )


def row_signs(state: Dynamics, constraint: Constraint) -> Array:
    """Signs (nv,) by which each joint velocity moves one end of a constraint against the other.

    1 or −1; 0 where it moves neither or both.
    """
    return moved_by(state, constraint.body) - moved_by(state, constraint.other_body)


def moved_by(state: Dynamics, body: int) -> Array:
    """Signs (nv,) of the joint velocities that move a body: 1, and 0 for the others.

    For the world, body −1, all are 0.
    """
    return np.asarray(np.where(body < 0, 0.0, state.ancestors[body].astype(float)))
