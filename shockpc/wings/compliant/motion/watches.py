"""Events that are watched in the motion of a landing on elements of finite stiffness."""

from collections.abc import Iterator

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import Signals
from shockpc.wings.compliant.motion.events import (
    LOADING,
    OPEN,
    PUSH,
    RATE,
    TOTAL,
    UNLOADING,
    WATCHED,
    EventKind,
    Watch,
)
from shockpc.wings.compliant.motion.free_motion import FreeMotion
from shockpc.wings.compliant.motion.state import State
from shockpc.wings.compliant.motion.system import EASED


def watches(state: State) -> Iterator[Watch]:
    """Events that can happen to the elements as they are.

    Watched are the rate of what is loaded, the force of what is unloaded and the gap of open
    contacts.
    """
    system = state.system
    rates = system.W @ state.u
    # Numbers of Python, because those of NumPy take ten times as long one by one.
    for i, phase in enumerate(state.phase.tolist()):
        if phase == LOADING and system.lossy[i]:
            yield from _while_loading(state, i)
        elif phase == UNLOADING:
            yield from _while_unloading(state, i, float(rates[i]))
        elif phase == OPEN and system.elements.normal[i]:
            yield from _while_open(state, i)


def _while_loading(state: State, i: int) -> Iterator[Watch]:
    """Events that can load an element.

    A contact is loaded against its normal; an element without force, in the direction in which it
    moves first.
    """
    system, normal, z = state.system, bool(state.system.elements.normal[i]), float(state.z[i])
    tolerance = system.noise * float(system.length[i])
    sign = -1.0 if normal or z < 0.0 else 1.0
    either = not normal and z == 0.0
    yield Watch(i, EventKind.UNLOADS, tolerance, 0.0, sign, either)
    if system.viscous[i] and normal and not state.slow[i]:
        yield Watch(i, EventKind.SLOWS, 0.0, -float(system.slowly[i]), -1.0)


def _while_unloading(state: State, i: int, rate: float) -> Iterator[Watch]:
    """An element reaches zero, or its peak again. Args: rate, of its length [m/s]."""
    system, noise, peak = state.system, state.system.noise, float(state.peak[i])
    normal, held = bool(system.elements.normal[i]), bool(system.rigid[i])
    length, viscous = float(system.length[i]), float(system.viscous[i])
    loaded = -1.0 if normal or peak < 0.0 else 1.0
    tolerance = noise * (1.0 + viscous * length)
    if viscous and state.slipped[i]:
        # After a slip the force of a contact with a damper goes on from zero.
        tolerance *= 2.0
    if held:
        # What is held by no force is released.
        tolerance = -noise
    ends = EventKind.OPENS if normal else EventKind.REVERSES
    yield Watch(i, ends, tolerance, 0.0, loaded)
    yield Watch(i, EventKind.RELOADS, noise, abs(peak), -loaded)
    if normal and not held and rate > 2.0 * noise * length:
        yield Watch(i, EventKind.TURNS, 2.0 * noise * length, 0.0, 1.0)


def _while_open(state: State, i: int) -> Iterator[Watch]:
    """A contact closes, and one with a damper clears the ground that it had compressed."""
    system = state.system
    tolerance = system.noise * float(system.length[i]) / system.fastest
    yield Watch(i, EventKind.CLOSES, tolerance, 0.0, 1.0)
    if system.viscous[i] and state.gap[i] < -tolerance:
        yield Watch(i, EventKind.CLEARS, tolerance, 0.0, -1.0)


def watches_in(state: State, motion: FreeMotion) -> Iterator[Watch]:
    """Events that can happen in a motion, besides those of its elements.

    Forces ease to what stays constant, and dampers in series creep.
    """
    system, normal = state.system, state.system.elements.normal
    if system.pull.any():
        yields = (state.phase == UNLOADING) | ((state.phase == LOADING) & state.slow)
        eases = yields & normal & (excess(state, motion) > 4.0 * system.push_noise)
        level = motion.rest - _creeping_forces(state)
        for i in np.flatnonzero(eases).tolist():
            tolerance, offset = 2.0 * system.push_noise[i], float(level[i])
            yield Watch(i, EventKind.EASES, tolerance, offset, -1.0)
    creep = motion.start[RATE] - motion.wave[RATE].real.sum(axis=1)
    in_series = system.elements.relaxation > 0.0
    creeps = (state.phase == LOADING) & normal & ~state.slow & in_series
    for i in np.flatnonzero(creeps).tolist():
        yield Watch(i, EventKind.SLOWS, 0.0, float(creep[i] - system.slowly[i]), -1.0)


def excess(state: State, motion: FreeMotion) -> Array:
    """Forces (r,) that press beyond what constant forces make.

    They are −∞ where they oscillate little.
    """
    amplitude = np.abs(motion.wave[TOTAL]).sum(axis=1) * state.slope
    beyond = motion.rest - motion.start[TOTAL] - _creeping_forces(state)
    return np.where(amplitude <= EASED * state.largest, -np.inf, beyond)


def _creeping_forces(state: State) -> Array:
    """Scaled forces (r,) that count as none.

    They are those of contacts with a damper in series, which may decay without end.
    """
    system = state.system
    slowly, length = system.slowly, system.rigid_length
    decays = (system.elements.relaxation > 0.0) & (length > 0.0)
    return np.divide(slowly, length, out=np.zeros_like(length), where=decays)


def signals_of(
    state: State, motion: FreeMotion, watched: list[Watch]
) -> tuple[np.ndarray, Signals]:
    """The signals of what is watched: which each is, and these."""
    element = np.array([watch.element for watch in watched], dtype=int)
    values = np.array([watch[2:] for watch in watched], dtype=float).reshape(-1, 4)
    tolerance, offset, sign, either = values.T
    # Within the ground that it has compressed, an open contact with a damper closes when it would
    # be pressed.
    closes = np.array([watch.kind is EventKind.CLOSES for watch in watched], dtype=bool)
    is_damped = state.system.elements.damping[element] > 0.0
    inside = closes & is_damped & (state.gap[element] < -tolerance)
    signal = np.array([WATCHED[watch.kind] for watch in watched], dtype=int)
    signal = np.where(inside, PUSH, signal)
    tolerance = np.where(inside, state.system.push_noise[element], tolerance)
    row, bound = (signal, element), motion.bound
    if isinstance(bound, np.ndarray):
        bound = bound[row]
    return signal, Signals(
        either=either != 0.0,
        tolerance=tolerance,
        start=offset + sign * motion.start[row],
        linear=sign * motion.linear[row],
        square=sign * motion.square[row],
        wave=sign[:, None] * motion.wave[row],
        bound=bound,
    )
