"""The end of a landing on elements of finite stiffness."""

import numpy as np

from shockpc.wings.compliant.motion.crossing import first_crossing
from shockpc.wings.compliant.motion.events import LOADING, OPEN, PUSH, RATE, EventKind
from shockpc.wings.compliant.motion.free_motion import FreeMotion
from shockpc.wings.compliant.motion.state import State
from shockpc.wings.compliant.motion.system import EASED
from shockpc.wings.compliant.motion.watches import excess, signals_of, watches

STAYS_OPEN = 10.0
"""Multiple of the duration so far for which all contacts have to stay open after the end.

What closes later is another impact.
"""


def impact_ends(state: State, motion: FreeMotion, time: float) -> bool:
    """True if the impact is over at a time [s], and no contact closes again soon."""
    return _is_over(state, motion) and not _closes_again(state, motion, STAYS_OPEN * time)


def _is_over(state: State, motion: FreeMotion) -> bool:
    """True if no contact compresses further, rebounds or carries more than its constant load.

    Constant forces make that load.

    A contact carries no more where its force, which oscillates about what constant forces make, is
    below that, or oscillates little. Without constant forces all contacts are open then.
    """
    system, normal = state.system, state.system.elements.normal
    if state.separated or not system.pull.any():
        return state.separated
    closed = system.grounded & (state.phase != OPEN)
    moves = np.abs(motion.wave[RATE]).sum(axis=1) > system.slowly
    loads = (state.phase == LOADING) & system.lossy & ~state.slow & (normal | moves)
    rises = system.W @ state.u > 2.0 * system.noise * system.length
    rebounds = normal & ~state.held & rises
    if np.any(closed & (loads | rebounds)):
        return False
    pressed = np.flatnonzero(closed & normal)
    return not np.any(excess(state, motion)[pressed] > 4.0 * system.push_noise[pressed])


def _closes_again(state: State, motion: FreeMotion, horizon: float) -> bool:
    """True if an open contact closes noticeably within a horizon [s].

    Constant forces are taken to change no velocity.

    As it would without force: it then goes beyond where it closes by more than a share of its
    largest compression.
    """
    watched = [watch for watch in watches(state) if watch.kind is EventKind.CLOSES]
    if not watched:
        return False
    system = state.system
    signal, signals = signals_of(state, motion, watched)
    element, of_push = np.array([watch.element for watch in watched]), signal == PUSH
    # What falls in the force that it would have; the rate of a gap does not.
    fall = np.where(of_push, (system.viscous * motion.linear[RATE])[element], 0.0)
    k = np.where(of_push, state.slope[element], system.elements.stiffness[element])
    depth = EASED * state.largest[element] / k
    signals = signals._replace(
        tolerance=signals.tolerance + depth,
        linear=signals.linear - fall,
        square=0.0 * signals.square,
    )
    _, first = first_crossing(motion.modal.oscillations.rate, signals, horizon, state.effort)
    return first is not None
