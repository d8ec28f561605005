"""From which time after the impact springs have an effect: those of joints, and those between
joints and their rotors.

In the instant of an impact a spring gives no impulse, because it has not moved. Afterwards the
robot, with its contacts held, swings on its springs; the motion is that of the generalised
eigenproblem K φ = ω² M φ in the geometry at the impact.
"""

from collections.abc import Iterator

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few

TAKES_PART = 0.1
"""Share of the elastic energy of a mode in a spring from which on the spring takes part in it."""

STIFF_CONTACT = 1e-3
"""Duration of a stiff contact [s], within which a spring acts as rigid where it counts."""


def early_springs(
    landing: PosedLanding, time: float, duration: float | None
) -> Iterator[Diagnostic]:
    """A warning where springs count within the contact, while the impulse model, or also finite
    stiffness, leaves them out.

    Args:
        landing: gives the springs.
        time: from which on the first spring has an effect [s].
        duration: of the contact [s]; None where the landing gives no stiffness of the contacts.
    """
    model, count = landing.joint_model, f"{1e3 * time:.2g} ms"
    joints = model.rotor_unknown
    if duration is not None and joints.any():
        names = few(
            [joint.name for joint in landing.robot.single_joints if joints[joint.v].any()],
            2,
            what=" joints",
        )
        text = (
            f"springs at {names} are left out on contacts of finite stiffness, because the "
            "inertia of the rotors behind them is unknown; they would change forces and durations "
            f"from {count} on. Give the rotors with --rotor"
        )
        yield Diagnostic("contact", "springs", time, text)
    elif time < (STIFF_CONTACT if duration is None else duration):
        within = (
            f"the {1e3 * STIFF_CONTACT:g} ms of a stiff contact"
            if duration is None
            else f"the {1e3 * duration:.3g} ms of contact"
        )
        remedy = (
            "a rotor behind such a spring acts as rigid: leave the stiffness out, lock the joint, "
            "or give --contact-stiffness"
        )
        text = (
            f"springs of joints have an effect after {count}, within {within}, but the impulse "
            f"model leaves them free; "
            + (remedy if duration is None else "see the jumps at the end of contact")
        )
        yield Diagnostic("contact", "springs", time, text)


@memoized()
def spring_time(landing: PosedLanding) -> float:
    """The time after the impact from which on the first spring has an effect, as `spring_times`
    [s]; infinite without springs.
    """
    if not landing.joint_model.springs.any():
        return np.inf
    return float(spring_times(landing).min())


def spring_times(landing: PosedLanding) -> Array:
    """The time (nv,) from which on the spring of each joint counts [s].

    It is a quarter of the period of the slowest mode that the spring takes part in. A rotor of
    unknown inertia behind a spring counts as held, which gives an earlier time. Infinite for joints
    without a spring, and where it cannot be deflected while the contacts are held.
    """
    model, equation = landing.joint_model, landing.equation(landing.state)
    times = np.full(len(model.armature), np.inf)
    H, G = equation.H[0], np.eye(len(times)) if equation.G is None else equation.G[0]
    scale = 1.0 / np.sqrt(np.diagonal(H))
    # Scaled to a unit diagonal, rows of forces and of moments compare.
    _, sizes, rows = np.linalg.svd(equation.J_c[0] * scale)
    rank = int(np.count_nonzero(sizes > 1e-9 * sizes.max(initial=0.0)))
    basis = scale[:, None] * rows[rank:].T
    M, velocities = basis.T @ H @ basis, G @ basis
    joints = np.flatnonzero(model.springs)
    behind = np.array([v for v in joints if model.rotor[v] > 0.0], dtype=int)
    jointed = np.array([v for v in joints if model.stiffness[v] > 0.0], dtype=int)
    held_rotor = np.flatnonzero(model.rotor_unknown)
    loaded = np.concatenate([jointed, held_rotor])
    n, s = len(M), len(behind)
    full = np.zeros((n + s, n + s))
    full[:n, :n], full[n:, n:] = M, np.diag(model.rotor[behind])
    B = np.zeros((len(loaded) + s, n + s))
    B[: len(loaded), :n], B[len(loaded) :, :n], B[len(loaded) :, n:] = (
        velocities[loaded],
        velocities[behind],
        -np.eye(s),
    )
    k = np.concatenate(
        [model.stiffness[jointed], model.drive_stiffness[held_rotor], model.drive_stiffness[behind]]
    )
    U, sigma, _ = np.linalg.svd(
        np.sqrt(k)[:, None] * np.linalg.solve(np.linalg.cholesky(full), B.T).T, full_matrices=False
    )
    moving = sigma > 1e-9 * sigma.max(initial=0.0)
    for row, v in enumerate([*loaded, *behind]):
        slowest = sigma[moving & (U[row] ** 2 >= TAKES_PART)].min(initial=np.inf)
        times[v] = min(times[v], np.pi / (2.0 * slowest) if np.isfinite(slowest) else np.inf)
    return times
