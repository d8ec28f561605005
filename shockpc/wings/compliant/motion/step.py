"""The step of a landing on elements of finite stiffness to its next event."""

import numpy as np

from shockpc.wings.compliant.motion.crossing import changes, first_crossing
from shockpc.wings.compliant.motion.damped import along
from shockpc.wings.compliant.motion.ending import impact_ends
from shockpc.wings.compliant.motion.events import FORCE, TOTAL, EventKind, Watch
from shockpc.wings.compliant.motion.free_motion import FreeMotion, free_motion
from shockpc.wings.compliant.motion.segment import Segment
from shockpc.wings.compliant.motion.state import State
from shockpc.wings.compliant.motion.watches import signals_of, watches, watches_in


def step(
    state: State, time: float, horizon: float, may_end: bool
) -> tuple[Segment | None, Watch | None]:
    """Go to the next event, at most by a horizon [s].

    Returns: the segment until then, if any, and what happens there; where the motion may end,
        neither once the impact is over.
    """
    system, held = state.system, state.held
    if held.any() and not (state.sprung.any() or system.pull.any()):
        # Nothing presses what is held on the ground, so that it is released.
        released = int(np.flatnonzero(held & system.elements.normal)[0])
        return None, Watch(released, EventKind.OPENS, 0.0, 0.0, 1.0)
    loaded = state.loaded()
    if len(loaded.held.rows):
        # What held rows stop is at rest from now on.
        state.jump = state.jump - loaded.held.still @ state.u
    motion = free_motion(state, loaded)
    # With a damper the force may be largest when the spring is not yet compressed.
    larger = np.maximum(state.largest, -state.slope * motion.start[TOTAL])
    state.largest = np.where(system.viscous > 0.0, larger, state.largest)

    watched = [*watches(state), *watches_in(state, motion)]
    _, signals = signals_of(state, motion, watched)
    # What is below zero already happens at once.
    early = np.where(signals.either, np.inf, signals.start + signals.tolerance)
    if early.min(initial=np.inf) < 0.0:
        return None, watched[int(early.argmin())]
    if may_end and impact_ends(state, motion, time):
        return None, None
    length, first = first_crossing(motion.modal.oscillations.rate, signals, horizon, state.effort)
    segment = _segment(state, motion, time, length)
    _go_on(state, motion, segment)
    return segment, None if first is None else watched[first]


def _segment(state: State, motion: FreeMotion, time: float, length: float) -> Segment:
    """The motion from now on, a time [s], for a length [s]."""
    V, modal = motion.loaded.modes.V, motion.modal
    return Segment(
        start=time,
        length=length,
        rate=modal.oscillations.rate,
        level=state.system.steady - state.slope * motion.rest,
        wave=-state.slope[:, None] * motion.wave[TOTAL],
        swing=along(V, modal.oscillations.velocity),
        drift=V @ modal.drift,
        acceleration=V @ modal.acceleration,
        jump=state.jump,
        displacement=state.displacement,
    )


def _go_on(state: State, motion: FreeMotion, segment: Segment) -> None:
    """Bring a state to the end of a segment."""
    length = segment.length
    state.jump, displacement = segment.after(np.asarray(length))
    state.gap = state.gap + state.system.W @ (displacement - state.displacement)
    state.displacement = displacement
    state.z = motion.forces + changes(length * segment.rate, motion.wave[FORCE])
