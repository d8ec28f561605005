"""The time after the impact from which springs have an effect.

They are those of joints, and those between joints and their rotors.

In the instant of an impact a spring gives no impulse, because it has not moved. Afterwards the
robot, with its contacts held, swings on its springs; the motion is that of the generalised
eigenproblem K φ = ω² M φ in the geometry at the impact.
"""

from collections.abc import Iterator
from typing import NamedTuple

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
    """A warning where springs have an effect within the contact, but are left out.

    The impulse model leaves them out, or also the landing over time.

    Args:
        landing: gives the springs.
        time: from which on the first spring has an effect [s].
        duration: of the contact [s]; None where the landing gives no stiffness of the contacts.
    """
    unknown = landing.joint_model.rotor_unknown
    after = f"{1e3 * time:.2g} ms"
    if duration is not None and unknown.any():
        joints = [joint.name for joint in landing.robot.single_joints if unknown[joint.v].any()]
        names = few(joints, 2, noun=" joints")
        text = (
            f"springs at {names} are left out on contacts of finite stiffness, because the "
            "inertia of the rotors behind them is unknown; they would change forces and durations "
            f"from {after} on. Give the rotors with --rotor"
        )
        yield Diagnostic("contact", "springs", time, text)
        return
    if duration is None:
        contact = STIFF_CONTACT
        within = f"the {1e3 * STIFF_CONTACT:g} ms of a stiff contact"
        remedy = (
            "a rotor behind such a spring acts as rigid: leave the stiffness out, lock the joint, "
            "or give --contact-stiffness"
        )
    else:
        contact = duration
        within = f"the {1e3 * duration:.3g} ms of contact"
        remedy = "see the jumps at the end of contact"
    if time < contact:
        text = (
            f"springs of joints have an effect after {after}, within {within}, but the impulse "
            f"model leaves them free; {remedy}"
        )
        yield Diagnostic("contact", "springs", time, text)


@memoized()
def spring_time(landing: PosedLanding) -> float:
    """The time after the impact from which on the first spring has an effect [s].

    As `spring_times`; infinite without springs.
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
    springs = _springs(landing)
    times = np.full(len(landing.joint_model.armature), np.inf)
    # Modes of K φ = ω² M φ, K = Bᵀ k B and M = L Lᵀ: the singular values of √k B L⁻ᵀ are ω.
    L = np.linalg.cholesky(springs.M)
    scaled = np.sqrt(springs.stiffness)[:, None] * np.linalg.solve(L, springs.B.T).T
    U, omega, _ = np.linalg.svd(scaled, full_matrices=False)
    moving = omega > 1e-9 * omega.max(initial=0.0)
    for share, v in zip(U**2, springs.joints, strict=True):
        slowest = omega[moving & (share >= TAKES_PART)].min(initial=np.inf)
        if np.isfinite(slowest):
            times[v] = min(times[v], np.pi / (2.0 * slowest))
    return times


class _Springs(NamedTuple):
    """Springs between coordinates that leave the contacts held.

    Attributes:
        M: (m, m) inertia of the coordinates, the last of which are rotors behind springs.
        B: (n, m) deflections for unit coordinates.
        stiffness: (n,) k [N m/rad, N/m].
        joints: (n,) joint velocities to which the springs belong.
    """

    M: Array
    B: Array
    stiffness: Array
    joints: np.ndarray


def _springs(landing: PosedLanding) -> _Springs:
    """The springs of joints, and those between joints and rotors that are held or move."""
    model = landing.joint_model
    basis = _held_basis(landing)
    equation = landing.equation(landing.state)
    rates = basis if equation.G is None else equation.G[0] @ basis
    has_spring = model.springs
    of_joint = np.flatnonzero(has_spring & (model.stiffness > 0.0))
    to_held_rotor = np.flatnonzero(model.rotor_unknown)
    to_rotor = np.flatnonzero(has_spring & (model.rotor > 0.0))

    n, rotors = basis.shape[1], len(to_rotor)
    M = np.zeros((n + rotors, n + rotors))
    M[:n, :n] = basis.T @ equation.H[0] @ basis
    M[n:, n:] = np.diag(model.rotor[to_rotor])
    joints = np.concatenate([of_joint, to_held_rotor, to_rotor])
    B = np.zeros((len(joints), n + rotors))
    B[:, :n] = rates[joints]
    B[len(joints) - rotors :, n:] = -np.eye(rotors)
    stiffness = np.concatenate(
        [
            model.stiffness[of_joint],
            model.drive_stiffness[to_held_rotor],
            model.drive_stiffness[to_rotor],
        ]
    )
    return _Springs(M, B, stiffness, joints)


def _held_basis(landing: PosedLanding) -> Array:
    """Free velocities (ny, m), a basis of those that leave the contacts held."""
    equation = landing.equation(landing.state)
    scale = 1.0 / np.sqrt(np.diagonal(equation.H[0]))
    # Scaled to a unit diagonal, rows of forces and of moments compare.
    _, sizes, rows = np.linalg.svd(equation.J_c[0] * scale)
    rank = int(np.count_nonzero(sizes > 1e-9 * sizes.max(initial=0.0)))
    return np.asarray(scale[:, None] * rows[rank:].T)
