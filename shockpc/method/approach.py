"""The speeds that an impact undoes along each row: b of Eq. 4."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.method.constraints import NO_AXES, Constraint, constraint_axes, constraint_wrenches
from shockpc.method.dynamics import Dynamics


class Motion(NamedTuple):
    """A motion before an impact: one, or one for each of N postures, with a leading axis (N, …).

    Attributes:
        velocity: (3,) of the base frame's origin, world axes [m/s].
        omega: (3,) angular velocity of the base, world axes [rad/s].
        joint_rates: (nv,) rates of the joints [rad/s, m/s]; the base's entries are not used.
    """

    velocity: Array
    omega: Array
    joint_rates: Array

    @property
    def of_joints(self) -> "Motion":
        """The motion of the joints without that of the base."""
        return self._replace(velocity=0.0 * self.velocity, omega=0.0 * self.omega)


def twist_before(state: Dynamics, before: Motion, body: int) -> Array:
    """Twist (N, 6) of a body before the impact, world axes [rad/s, m/s].

    It is ω, and the velocity v of the body's point at the base's origin.
    """
    of_base = np.concatenate([before.omega, before.velocity], axis=-1)
    if not before.joint_rates.any():
        return np.broadcast_to(of_base, (len(state.J), 6))
    rates = np.where(state.ancestors[body], before.joint_rates, 0.0)
    return np.asarray(of_base + (state.J @ rates[..., None])[..., 0])


def relative_twist(state: Dynamics, stop: Constraint, before: Motion) -> Array:
    """Twist (N, 6) of a stop's body relative to the body before its joint, before the impact.

    Both turn alike with the base, so only the rates of joints are included.
    """
    twist = twist_before(state, before.of_joints, stop.body)
    if stop.other_body < 0:
        return twist
    return np.asarray(twist - twist_before(state, before.of_joints, stop.other_body))


def approach_speeds(
    state: Dynamics, constraints: Sequence[Constraint], before: Motion | None
) -> Array:
    """The speeds b (N, nc, 4 or 3) that an impact undoes along each row [m/s, rad/s].

    b = (1 + e) J_c q̇⁻.

    The first three columns are strikes of 1 m/s along world x, y and z; the last is that of a
    motion, if one is given. Rows of standing feet and of loops have none. The speed of a stop is
    that of its joint.

    Where only the velocity along a direction n rebounds, a row of a force along a has
    a·v + e (a·n) (n·v), for the velocity v of the contact's point. A row of a moment about a has
    a·ω + e (a·ω − (a·n) (n·ω)): at each point of a flat contact the velocity along n rebounds.
    """
    b = []
    for constraint in constraints:
        wrenches = constraint_wrenches(state, constraint)
        speeds = np.zeros((*wrenches.shape[:2], 3 if before is None else 4), dtype=wrenches.dtype)
        if constraint.kind == "contact":
            _set_contact_speeds(speeds, state, constraint, wrenches, before)
        elif constraint.kind == "stop" and before is not None:
            twist = relative_twist(state, constraint, before)
            speeds[..., 3:] = (1.0 + constraint.restitution) * (wrenches @ twist[..., None])
        b.append(speeds)
    return np.concatenate(b, axis=1)


def _set_contact_speeds(
    speeds: Array, state: Dynamics, constraint: Constraint, wrenches: Array, before: Motion | None
) -> None:
    """Set the speeds (N, k, 4 or 3) that an impact undoes along the rows of a contact.

    A contact with a velocity of its own is not moved by unit strikes of the robot.
    """
    rows = _undone(state, constraint, wrenches)
    n = len(constraint.forces)
    if constraint.velocity is None:
        speeds[..., :3] = rows[..., 3:]
    if before is not None:
        speeds[..., 3:] = rows @ twist_before(state, before, constraint.body)[..., None]
        if constraint.velocity is not None:
            speeds[:, :n, 3] = (rows[:, :n, 3:] @ constraint.velocity[..., None])[..., 0]


def speeds_undone(state: Dynamics, constraints: Sequence[Constraint], qd: Array) -> Array:
    """The speeds b (N, nc, 1) that an impact undoes along each row, for velocities (N, nv)."""
    b = []
    for constraint in constraints:
        wrenches = constraint_wrenches(state, constraint)
        undone = (
            _undone(state, constraint, wrenches) if constraint.kind == "contact" else 0.0 * wrenches
        )
        moving = np.where(state.ancestors[constraint.body], qd, 0.0)
        b.append(undone @ (state.J @ moving[..., None]))
    return np.concatenate(b, axis=1)


def _undone(state: Dynamics, constraint: Constraint, wrenches: Array) -> Array:
    """The wrenches (N, k, 6) whose power is the speed that the impact undoes along each row.

    Without a direction n of rebound they are (1 + e) W. With it, the wrench of a force along a
    gains e (a·n) times that of a force along n, and that of a moment e times its part across n.
    """
    e, n = constraint.restitution, constraint.rebound
    if not e:
        return wrenches
    if n is None:
        return np.asarray(wrenches + e * wrenches)
    m = len(constraint.forces)
    share = (constraint_axes(state, constraint) @ n)[..., None]
    along_n = constraint_wrenches(state, constraint._replace(forces=n[None], moments=NO_AXES))
    about_n = constraint_wrenches(state, constraint._replace(forces=NO_AXES, moments=n[None]))
    of_forces = share[:, :m] * along_n
    of_moments = wrenches[:, m:] - share[:, m:] * about_n
    return np.asarray(wrenches + e * np.concatenate([of_forces, of_moments], axis=1))
