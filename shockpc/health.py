"""How far to trust a profile: rank, residual, and a second solution that shares nothing with the first."""

import numpy as np

from shockpc.core.impulse import Impact, residual
from shockpc.core.maximal import solve_maximal
from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError
from shockpc.model.contact import Touch
from shockpc.model.dynamics import Dynamics, tree
from shockpc.model.equation import Equation
from shockpc.model.robot import Robot
from shockpc.record import Health

__all__ = ["gyration_radii", "health_of"]

TRUSTED = 1e-9
"""Two solutions that differ by more than this are reported with a warning."""


def health_of(
    robot: Robot,
    state: Dynamics,
    touches: tuple[Touch, ...],
    equation: Equation,
    impact: Impact,
    maps: Array,
    strike: Array,
) -> Health:
    """Judge a solution for one strike.

    Args:
        robot: the robot.
        state: its dynamics, first posture.
        touches: the contacts.
        equation: what was solved.
        impact: its solution for unit strikes.
        maps: (nb, 6, 3) jumps of the bodies for unit strikes.
        strike: (3,) velocity of the strike [m/s].

    Raises:
        SceneError: the mechanism cannot meet its contacts, because they contradict one another or ask for a motion that it does not
            have.
    """
    v = strike[:, None]
    b = equation.b[0] @ v
    left = float(residual(equation.H[0], equation.J_c[0], b, impact.delta_qd[0] @ v, impact.impulse[0] @ v))
    if left > 1e-6:
        raise SceneError(_contradiction(touches, equation.J_c[0] @ impact.delta_qd[0] @ v + b))
    difference = _difference(robot, state, touches, equation, impact, maps @ strike, b)
    worst = int(np.argmax(difference))
    estimate = float(difference[worst])
    warnings: tuple[str, ...] = ()
    if estimate > TRUSTED:
        digits = max(0, int(-np.log10(estimate)))
        warnings = (
            f'two independent solutions differ by {estimate:.1e} at body "{robot.bodies[worst].name}", so its numbers hold to '
            f"{digits} digits at best; very light bodies under heavy ones, or a nearly singular chain, are the usual cause",
        )
    return Health(
        rank=int(impact.rank[0]),
        rows=equation.J_c.shape[1],
        residual=left,
        error_estimate=estimate,
        method="joint space (Eq. 4), checked in maximal coordinates",
        warnings=warnings,
    )


def gyration_radii(robot: Robot) -> Array:
    """Radius of gyration of every body about its centre of mass, for the mean axis (nb,) [m]; 0 for a body without mass."""
    mass = np.array([body.mass for body in robot.bodies])
    trace = np.array([np.trace(body.inertia) for body in robot.bodies])
    return np.asarray(np.sqrt(np.maximum(trace, 0.0) / 3.0 / np.where(mass > 0.0, mass, np.inf)))


def _difference(
    robot: Robot, state: Dynamics, touches: tuple[Touch, ...], equation: Equation, impact: Impact, jump: Array, b: Array
) -> Array:
    """Relative difference (nb,) between every body's jump (nb, 6) and the one found in maximal coordinates."""
    bodies = tree(robot, state, equation.G)
    rows = []
    for touch in touches:
        arm = state.position[0, touch.body] + state.rotation[0, touch.body] @ touch.point - bodies.com[touch.body]
        row = np.zeros((len(touch.directions), len(robot.bodies), 6))
        row[:, touch.body, :3] = np.cross(arm, touch.directions)
        row[:, touch.body, 3:] = touch.directions
        rows.append(row)
    combine = impact.combine[0, : int(impact.rank[0])]
    independent = np.einsum("mc,cbk->mbk", combine, np.concatenate(rows))
    other = solve_maximal(bodies, independent, combine @ b)[..., 0]

    rotation = state.rotation[0]
    com = np.stack([body.com for body in robot.bodies])
    omega = (rotation @ jump[:, :3, None])[..., 0]
    v_com = (rotation @ velocity_at(jump[:, :3], jump[:, 3:], com)[..., None])[..., 0]
    length = np.maximum(gyration_radii(robot), 1e-6)

    def size(omega: Array, v: Array) -> Array:
        return np.asarray(np.hypot(np.linalg.norm(v, axis=-1), length * np.linalg.norm(omega, axis=-1)))

    own = size(omega, v_com)
    # A body that hardly moves is measured against what 1e-9 of the fastest one would be: below that there is nothing to be wrong.
    return np.asarray(size(omega - other[:, :3], v_com - other[:, 3:]) / np.maximum(own, 1e-9 * own.max()))


def _contradiction(touches: tuple[Touch, ...], left: Array) -> str:
    """The message for contacts that cannot be met: which one, along what, by how much."""
    row = int(np.argmax(np.abs(left[:, 0])))
    names = [(touch.frame, direction) for touch in touches for direction in touch.directions]
    frame, direction = names[row]
    axis = " ".join(f"{u:.3g}" for u in direction + 0.0)
    return (
        f'contact "{frame}" cannot be stopped: {abs(left[row, 0]):.3g} m/s are left along ({axis}), because the mechanism cannot move '
        "that way here, or another contact asks for the opposite; leave that direction out of the contact or of the strike, or free "
        "the base"
    )
