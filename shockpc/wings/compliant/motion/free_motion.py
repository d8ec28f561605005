"""The motion of a landing on elements of finite stiffness until the next event.

No element changes until then, so that the motion is known in closed form.
"""

from typing import Any, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import ComplexArray
from shockpc.wings.compliant.motion.damped import Oscillations, along, damped, undamped
from shockpc.wings.compliant.motion.loaded import Loaded
from shockpc.wings.compliant.motion.state import State
from shockpc.wings.compliant.motion.system import ScaledSystem


class ModalState(NamedTuple):
    """The state in modes, and its oscillations.

    Attributes:
        moves: (m,) which modes have a frequency.
        deflection: (m,) from that at which constant forces balance them [√J].
        velocity: (m,) from that at which constant forces leave them [√J].
        drift: (m,) velocities that do not oscillate.
        acceleration: (m,) at which constant forces change those that no spring resists.
        oscillations: from these on.
    """

    moves: np.ndarray
    deflection: Array
    velocity: Array
    drift: Array
    acceleration: Array
    oscillations: Oscillations


class FreeMotion(NamedTuple):
    """The motion until the next event.

    Attributes:
        loaded: what it depends on.
        modal: the state at the start, in modes.
        forces: (r,) of all elements at the start, without those of dampers.
        rest: (r,) part of the forces that stays constant.
        start, linear, square, wave, bound: (5, r, ...) as in `Signals`, of each signal of each
            element.
    """

    loaded: Loaded
    modal: ModalState
    forces: Array
    rest: Array
    start: Array
    linear: Array
    square: Array
    wave: ComplexArray
    bound: Array | float


class _ModeRows(NamedTuple):
    """What each of r elements feels of unit modes.

    Attributes:
        rate: (r, m) rates, W V.
        spring: (r, m) forces of springs.
        held: (r, m) forces of held rows by velocities.
        damper: (r, m) forces of dampers.
    """

    rate: Array
    spring: Array
    held: Array
    damper: Array


def modal_state(state: State, loaded: Loaded) -> ModalState:
    """A state in the modes of the springs that are loaded."""
    modes = loaded.modes
    moves = deflects = modes.sigma > 0.0
    if modes.damped is not None:
        deflects = modes.damped.deflects
    z = np.where(loaded.sprung, state.z, 0.0)
    deflection = np.where(deflects, modes.U.T @ z - modes.balanced, 0.0)
    velocity = modes.V.T @ state.u
    drift = np.where(moves, modes.creep, velocity)
    acceleration = np.where(moves, 0.0, modes.V.T @ loaded.held.pull)
    velocity = velocity - modes.creep
    if modes.damped is None:
        oscillations = undamped(modes.sigma, deflection, velocity)
    else:
        oscillations = damped(modes.damped, deflection, velocity)
    return ModalState(moves, deflection, velocity, drift, acceleration, oscillations)


def free_motion(state: State, loaded: Loaded) -> FreeMotion:
    """The motion from a state on, in which held rows are at rest.

    Each signal is start + linear t + square t² + Re Σ_j wave_j (exp(λ_j t) − 1).
    """
    system, held = state.system, loaded.held
    modal, rows = modal_state(state, loaded), _mode_rows(system, loaded)
    u, z = state.u, np.where(loaded.sprung, state.z, 0.0)

    # What does not oscillate of the forces to_all · z + from_u · u + balance stays constant.
    forces = held.to_all @ z + held.from_u @ u + held.balance
    oscillating = np.where(modal.moves, modal.velocity, 0.0)
    rest = forces - rows.spring @ modal.deflection - rows.held @ oscillating

    # The gap is the integral of the rate.
    zero = np.zeros(len(z))
    fall, drift = rows.rate @ modal.acceleration, rows.rate @ modal.drift
    bound: Array | float = np.inf
    if loaded.modes.damped is not None:
        bound = _bounds(system, rows, modal.oscillations)
    return FreeMotion(
        loaded=loaded,
        modal=modal,
        forces=forces,
        rest=rest,
        start=_signals(system, system.W @ u, forces, state.gap, forces + loaded.damper @ u),
        linear=_signals(system, fall, zero, drift, zero),
        square=_signals(system, zero, zero, fall / 2.0, zero),
        wave=_waves(system, rows, modal.oscillations),
        bound=bound,
    )


def _mode_rows(system: ScaledSystem, loaded: Loaded) -> _ModeRows:
    """What elements feel of unit modes."""
    U, V, held = loaded.modes.U, loaded.modes.V, loaded.held
    return _ModeRows(system.W @ V, held.to_all @ U, held.from_u @ V, loaded.damper @ V)


def _waves(system: ScaledSystem, rows: _ModeRows, oscillations: Oscillations) -> ComplexArray:
    """The waves (5, r, j) of the signals; those of the gap are those of the rate, over λ_j."""
    rate, deflection, velocity, _ = oscillations
    path = np.divide(velocity, rate, out=np.zeros_like(velocity), where=rate != 0.0)
    force = along(rows.spring, deflection) + along(rows.held, velocity)
    total = force + along(rows.damper, velocity)
    rates, gaps = along(rows.rate, velocity), along(rows.rate, path)
    return np.asarray(_signals(system, rates, force, gaps, total))


def _bounds(system: ScaledSystem, rows: _ModeRows, oscillations: Oscillations) -> Array:
    """Bounds (5, r) of the second derivatives of the signals, with dampers."""
    first, second = oscillations.bounds
    springs = np.linalg.norm(rows.spring, axis=1)
    force = np.hypot(springs, np.linalg.norm(rows.held, axis=1))
    total = np.hypot(springs, np.linalg.norm(rows.held + rows.damper, axis=1))
    rates, gaps = system.length * second, system.length * first
    return np.asarray(_signals(system, rates, force * second, gaps, total * second))


def _signals(system: ScaledSystem, rate: Any, force: Any, gap: Any, total: Any) -> Any:
    """Five signals (5, r, ...), in the order of RATE to PUSH.

    They are these four, and √k gap + c rate.
    """
    shape = (-1,) + (1,) * (np.ndim(gap) - 1)
    root = system.slope.reshape(shape)
    viscous = system.viscous.reshape(shape)
    return np.array([rate, force, gap, total, root * gap + viscous * rate])
