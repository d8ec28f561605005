"""The state of a landing on elements of finite stiffness at an event, the motion until the next
one, and what changes there.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import (
    ComplexArray,
    Effort,
    Signals,
    changes,
    first_crossing,
)
from shockpc.wings.compliant.motion.damped import Oscillations, along, damped, undamped
from shockpc.wings.compliant.motion.events import (
    FORCE,
    GAP,
    LOADING,
    OPEN,
    PUSH,
    RATE,
    TOTAL,
    UNFELT,
    UNLOADING,
    WATCHED,
    EventKind,
    Watch,
)
from shockpc.wings.compliant.motion.motion import Modes, Segment
from shockpc.wings.compliant.motion.system import EASED, Loaded, System

STAYS_OPEN = 10.0
"""Times the motion so far for which all contacts have to stay open, so that it has ended: what
closes later is another impact.
"""


class Free(NamedTuple):
    """The motion until the next event.

    Attributes:
        loaded: what it depends on.
        u: (d,) at the start.
        forces: (r,) of all elements at the start, without those of dampers.
        rest: (r,) part of the forces that stays constant.
        oscillations: in modes.
        start, linear, square, wave, bound: (5, r, ...) as in `Signals`, of each signal of each
            element.
    """

    loaded: Loaded
    u: Array
    forces: Array
    rest: Array
    oscillations: Oscillations
    start: Array
    linear: Array
    square: Array
    wave: ComplexArray
    bound: Array | float


class State:
    """What each element does at an event, and the velocity then: `step` goes to the next event,
    `switch` lets it happen.

    Between two events every element is open, loading or unloading, so that the motion is linear.

    Attributes:
        system: what does not change.
        phase: (r,) OPEN, LOADING or UNLOADING.
        slope: (r,) √κ.
        z: (r,) √κ (B x − a), zero where an element is open.
        peak: (r,) z at the start of unloading.
        largest: (r,) largest force of each normal at an event [N].
        gap: (r,) B x since the contact opened; of one with a damper, since it first closed [m].
        jump: (d,) change of u since the impact.
        displacement: (d,) ∫u dt.
        slow: (r,) normals of contacts with a damper that are compressed further only slowly.
        slipped: (r,) normals of contacts whose tangential springs are open.
        effort: of the search for events.
    """

    def __init__(self, system: System) -> None:
        elements, r = system.elements, len(system.W)
        self.system, self.effort = system, Effort()
        self.slope = np.sqrt(elements.stiffness)
        self.z, self.peak, self.largest, self.gap = np.zeros((4, r))
        self.z[system.sprung] = (
            -np.asarray(elements.load)[system.sprung] / self.slope[system.sprung]
        )
        self.jump, self.displacement = np.zeros((2, len(system.u)))
        self.slow, self.slipped = np.zeros((2, r), dtype=bool)
        closing = elements.contact[system.approaches]
        self.phase = np.where(
            (elements.contact < 0) | np.any(elements.contact == closing[:, None], axis=0),
            LOADING,
            OPEN,
        )

    @property
    def separated(self) -> bool:
        """Whether all contacts are open."""
        return not (self.phase[self.system.grounded] != OPEN).any()

    def _over(self, motion: Free) -> bool:
        """Whether no contact is compressed further or rebounds, and none carries more than constant
        forces make.

        A contact carries no more where its force, which oscillates about what constant forces make,
        is below that, or oscillates little. Without constant forces all contacts are open then.
        """
        system, elements = self.system, self.system.elements
        if self.separated or not system.pull.any():
            return self.separated
        rate = system.W @ (system.u + self.jump)
        closed, held = (
            system.grounded & (self.phase != OPEN),
            (self.phase == UNLOADING) & system.rigid,
        )
        moves = np.abs(motion.wave[RATE]).sum(axis=1) > system.slowly
        loading = (self.phase == LOADING) & system.lossy & ~self.slow & (elements.normal | moves)
        rebounds = elements.normal & ~held & (rate > 2.0 * system.noise * system.length)
        if np.any(closed & (loading | rebounds)):
            return False
        normal = np.flatnonzero(closed & elements.normal)
        return not np.any(self._excess(motion)[normal] > 4.0 * system.push_noise[normal])

    def _excess(self, motion: Free) -> Array:
        """Forces (r,) that press beyond what constant forces make; −∞ where they oscillate little."""
        amplitude = np.abs(motion.wave[TOTAL]).sum(axis=1) * self.slope
        beyond = motion.rest - motion.start[TOTAL] - self._left
        return np.where(amplitude <= EASED * self.largest, -np.inf, beyond)

    @property
    def _left(self) -> Array:
        """Scaled forces (r,) that count as none: of contacts with a damper in series, which may
        decay without end.
        """
        slowly, length = self.system.slowly, self.system.rigid_length
        return np.divide(
            slowly,
            length,
            out=np.zeros_like(length),
            where=(self.system.relaxation > 0.0) & (length > 0.0),
        )

    def modes(self) -> Modes:
        """The modes of the elements that are loaded now, without dampers."""
        motion = self._motion(dampers=False)
        to_all, U, sigma, V = (
            motion.loaded.to_all,
            motion.loaded.U,
            motion.loaded.sigma,
            motion.loaded.V,
        )
        moves, k = sigma > 0.0, self.system.elements.stiffness[:, None]
        shape = (self.slope[:, None] * (to_all @ U))[:, moves]
        participation = np.divide(shape**2, k, out=np.zeros_like(shape), where=k > 0.0)
        amplitude = np.abs(shape * motion.oscillations.deflection[moves])
        return Modes(
            sigma[moves] / (2.0 * np.pi),
            (V.T @ motion.u)[moves] ** 2 / 2.0,
            participation,
            amplitude,
        )

    def _closes_again(self, motion: Free, horizon: float) -> bool:
        """Whether an open contact closes within a horizon [s] noticeably, if constant forces change
        no velocity.

        As it would without force: it then goes beyond where it closes by more than a share of its
        largest compression.
        """
        watched = [watch for watch in self._watched() if watch.kind is EventKind.CLOSES]
        if not watched:
            return False
        signal, signals = self._signals(motion, watched)
        element, of_push = np.array([watch.element for watch in watched]), signal == PUSH
        # What falls in the force that it would have; the rate of a gap does not.
        fall = np.where(of_push, (self.system.viscous * motion.linear[RATE])[element], 0.0)
        depth = (
            EASED
            * self.largest[element]
            / np.where(of_push, self.slope[element], self.system.elements.stiffness[element])
        )
        signals = signals._replace(
            tolerance=signals.tolerance + depth,
            linear=signals.linear - fall,
            square=0.0 * signals.square,
        )
        return (
            first_crossing(motion.oscillations.rate, signals, horizon, self.effort)[1] is not None
        )

    def step(
        self, time: float, horizon: float, may_end: bool
    ) -> tuple[Segment | None, Watch | None]:
        """Go to the next event, at most by a horizon [s]; the segment until then, if any, and what
        happens there.

        Where the motion may end there is neither once the impact is over. Watched are the rate of
        what is loaded, the force of what is unloaded and the gap of open contacts.
        """
        system = self.system
        rigid = (self.phase == UNLOADING) & system.rigid
        if rigid.any() and not (self._sprung(rigid).any() or system.pull.any()):
            # Nothing presses what is held on the ground, so that it is released.
            return None, Watch(
                int(np.flatnonzero(rigid & system.elements.normal)[0]),
                EventKind.OPENS,
                0.0,
                0.0,
                1.0,
            )
        motion = self._motion()
        self.largest = np.where(
            system.viscous > 0.0,
            np.maximum(self.largest, -self.slope * motion.start[TOTAL]),
            self.largest,
        )
        watched = [*self._watched(), *self._watched_in(motion)]
        _, signals = self._signals(motion, watched)
        early = np.where(signals.either, np.inf, signals.start + signals.tolerance)
        if early.min(initial=np.inf) < 0.0:
            return None, watched[int(early.argmin())]
        if may_end and self._over(motion) and not self._closes_again(motion, STAYS_OPEN * time):
            return None, None
        length, first = first_crossing(motion.oscillations.rate, signals, horizon, self.effort)
        segment = self._segment(motion, time, length)
        self.jump, displacement = segment.after(np.asarray(length))
        self.gap, self.displacement = (
            self.gap + system.W @ (displacement - self.displacement),
            displacement,
        )
        self.z = motion.forces + changes(length * segment.rate, motion.wave[FORCE])
        return segment, None if first is None else watched[first]

    def _segment(self, motion: Free, time: float, length: float) -> Segment:
        """The motion from now on, a time [s], for a length [s]."""
        loaded, oscillations = motion.loaded, motion.oscillations
        still = loaded.sigma == 0.0
        drift = loaded.V @ np.where(still, loaded.V.T @ motion.u, loaded.creep)
        acceleration = loaded.V @ np.where(still, loaded.V.T @ loaded.pull, 0.0)
        return Segment(
            time,
            length,
            oscillations.rate,
            self.system.steady - self.slope * motion.rest,
            -self.slope[:, None] * motion.wave[TOTAL],
            along(loaded.V, oscillations.velocity),
            drift,
            acceleration,
            self.jump,
            self.displacement,
        )

    def _sprung(self, rigid: np.ndarray) -> np.ndarray:
        """The rows (r,) with springs that are loaded, with some rows held."""
        return np.asarray((self.phase != OPEN) & ~rigid & self.system.sprung)

    def _loaded(self, dampers: bool) -> Loaded:
        """What depends on which elements are loaded now. Args: dampers, whether those act."""
        held = (self.phase == UNLOADING) & self.system.rigid
        return self.system.loaded(
            held.tobytes(), self._sprung(held).tobytes(), self.slope.tobytes(), dampers
        )

    def _motion(self, dampers: bool = True) -> Free:
        """The motion until the next event. What held rows stop is at rest from now on."""
        system = self.system
        loaded = self._loaded(dampers)
        to_all, held, damper, U, sigma, V = (
            loaded.to_all,
            loaded.held,
            loaded.damper,
            loaded.U,
            loaded.sigma,
            loaded.V,
        )
        if len(loaded.fixed):
            self.jump = self.jump - loaded.still @ (system.u + self.jump)
        u, z = system.u + self.jump, np.where(loaded.sprung, self.z, 0.0)
        moves = sigma > 0.0
        deflects = moves if loaded.damped is None else loaded.damped.deflects
        # From the deflection, and the velocity, at which constant forces leave them.
        velocity, pulled = V.T @ u, V.T @ loaded.pull
        deflection, drift = (
            np.where(deflects, U.T @ z - loaded.balanced, 0.0),
            np.where(moves, loaded.creep, velocity),
        )
        velocity = velocity - loaded.creep
        oscillations = (
            undamped(sigma, deflection, velocity)
            if loaded.damped is None
            else damped(loaded.damped, deflection, velocity)
        )
        rate, p, speed, (first, second) = oscillations
        of_u, of_z, of_held, of_damper = system.W @ V, to_all @ U, held @ V, damper @ V
        forces = to_all @ z + held @ u + loaded.balance
        rest = forces - of_z @ deflection - of_held @ np.where(moves, velocity, 0.0)
        falling, drifting, zero = (
            of_u @ np.where(moves, 0.0, pulled),
            of_u @ drift,
            np.zeros(len(z)),
        )
        path = np.divide(speed, rate, out=np.zeros_like(speed), where=rate != 0.0)
        of_rate, of_force, of_gap = (
            along(of_u, speed),
            along(of_z, p) + along(of_held, speed),
            along(of_u, path),
        )
        # Of each signal, in the order of RATE to PUSH, the value at the start and the factors of t,
        # of t² and of the oscillations.
        rates, push = system.W @ u, np.sqrt(system.elements.stiffness)
        start = np.array(
            [rates, forces, self.gap, forces + damper @ u, push * self.gap + system.viscous * rates]
        )
        linear = np.array(
            [falling, zero, drifting, zero, push * drifting + system.viscous * falling]
        )
        square = np.array([zero, zero, falling / 2.0, zero, push * falling / 2.0])
        of_push = push[:, None] * of_gap + system.viscous[:, None] * of_rate
        wave = np.array([of_rate, of_force, of_gap, of_force + along(of_damper, speed), of_push])
        bound: Array | float = np.inf
        if loaded.damped is not None:
            of_forces = np.hypot(np.linalg.norm(of_z, axis=1), np.linalg.norm(of_held, axis=1))
            of_total = np.hypot(
                np.linalg.norm(of_z, axis=1), np.linalg.norm(of_held + of_damper, axis=1)
            )
            sizes = [
                system.length * second,
                of_forces * second,
                system.length * first,
                of_total * second,
            ]
            bound = np.array([*sizes, push * sizes[GAP] + system.viscous * sizes[RATE]])
        return Free(loaded, u, forces, rest, oscillations, start, linear, square, wave, bound)

    def _signals(self, motion: Free, watched: list[Watch]) -> tuple[np.ndarray, Signals]:
        """The signals of what is watched: which each is, and these."""
        element = np.array([watch.element for watch in watched], dtype=int)
        signal = np.array([WATCHED[watch.kind] for watch in watched], dtype=int)
        tolerance, offset, sign, either = (
            np.array([watch[2:] for watch in watched], dtype=float).reshape(-1, 4).T
        )
        # Within the ground that it has compressed, an open contact with a damper closes when it
        # would be pressed.
        closes = np.array([watch.kind is EventKind.CLOSES for watch in watched], dtype=bool)
        inside = closes & (self.system.damping[element] > 0.0) & (self.gap[element] < -tolerance)
        signal, tolerance = (
            np.where(inside, PUSH, signal),
            np.where(inside, self.system.push_noise[element], tolerance),
        )
        row = signal, element
        bound = motion.bound[row] if isinstance(motion.bound, np.ndarray) else motion.bound
        start = offset + sign * motion.start[row]
        linear, square, wave = (
            sign * motion.linear[row],
            sign * motion.square[row],
            sign[:, None] * motion.wave[row],
        )
        return signal, Signals(either != 0.0, tolerance, start, linear, square, wave, bound)

    def _watched(self) -> Iterator[Watch]:
        """What can happen to the elements as they are."""
        system = self.system
        # Numbers of Python, because those of NumPy take ten times as long one by one.
        deflection, peak, rigid, noise = (
            self.z.tolist(),
            self.peak.tolist(),
            system.rigid.tolist(),
            system.noise,
        )
        viscous, gap, rate = (
            system.viscous.tolist(),
            self.gap.tolist(),
            (system.W @ (system.u + self.jump)).tolist(),
        )
        for i, (phase, normal, length) in enumerate(
            zip(
                self.phase.tolist(),
                system.elements.normal.tolist(),
                system.length.tolist(),
                strict=True,
            )
        ):
            if phase == LOADING and system.lossy[i]:
                # A contact is loaded against its normal; an element without force, in the direction
                # in which it moves first.
                either = not normal and deflection[i] == 0.0
                sign = -1.0 if normal or deflection[i] < 0.0 else 1.0
                yield Watch(i, EventKind.UNLOADS, noise * length, 0.0, sign, either)
                if viscous[i] and normal and not self.slow[i]:
                    yield Watch(i, EventKind.SLOWS, 0.0, -float(system.slowly[i]), -1.0)
            elif phase == UNLOADING:
                loaded = -1.0 if normal or peak[i] < 0.0 else 1.0
                # After a slip the force of a contact with a damper goes on from zero.
                push = (
                    noise
                    * (1.0 + viscous[i] * length)
                    * (2.0 if viscous[i] and self.slipped[i] else 1.0)
                )
                # What is held by no force is released.
                ends = EventKind.OPENS if normal else EventKind.REVERSES
                yield Watch(i, ends, -noise if rigid[i] else push, 0.0, loaded)
                yield Watch(i, EventKind.RELOADS, noise, abs(peak[i]), -loaded)
                if normal and not rigid[i] and rate[i] > 2.0 * noise * length:
                    yield Watch(i, EventKind.TURNS, 2.0 * noise * length, 0.0, 1.0)
            elif phase == OPEN and normal:
                tolerance = noise * length / system.fastest
                yield Watch(i, EventKind.CLOSES, tolerance, 0.0, 1.0)
                if viscous[i] and gap[i] < -tolerance:
                    yield Watch(i, EventKind.CLEARS, tolerance, 0.0, -1.0)

    def _watched_in(self, motion: Free) -> Iterator[Watch]:
        """What can happen besides, in a motion: forces that ease to what stays constant, and
        dampers in series that creep.
        """
        system, normal = self.system, self.system.elements.normal
        eases = (
            ((self.phase == UNLOADING) | ((self.phase == LOADING) & self.slow))
            & normal
            & bool(system.pull.any())
        )
        for i in np.flatnonzero(eases & (self._excess(motion) > 4.0 * system.push_noise)).tolist():
            yield Watch(
                i,
                EventKind.EASES,
                2.0 * system.push_noise[i],
                float((motion.rest - self._left)[i]),
                -1.0,
            )
        creep = motion.start[RATE] - motion.wave[RATE].real.sum(axis=1)
        for i in np.flatnonzero(
            (self.phase == LOADING) & normal & ~self.slow & (system.relaxation > 0.0)
        ).tolist():
            yield Watch(i, EventKind.SLOWS, 0.0, float(creep[i] - system.slowly[i]), -1.0)

    def switch(self, i: int, kind: EventKind) -> EventKind:
        """Let an event happen to element i; what it is in full: a contact that would open may slip
        first.
        """
        system, elements = self.system, self.system.elements
        e = 1.0 if system.rigid[i] else float(elements.restitution[i])
        rows = elements.contact == elements.contact[i]
        if kind in UNFELT:
            self.slow[i] |= kind is EventKind.SLOWS
            return kind
        if kind is EventKind.UNLOADS:
            self.phase[i], self.slope[i], self.z[i] = UNLOADING, self.slope[i] / e, self.z[i] * e
            self.peak[i] = self.z[i]
            self.largest[i] = max(self.largest[i], self.slope[i] * abs(self.z[i]))
            return kind
        if kind in (EventKind.RELOADS, EventKind.REVERSES):
            self.phase[i], self.slope[i] = LOADING, self.slope[i] * e
            # The force of a row that is held jumps where another one is held too; the row is then
            # loaded from its peak.
            self.z[i] = (
                0.0
                if kind is EventKind.REVERSES
                else self.peak[i]
                if system.rigid[i]
                else self.z[i] / e
            )
            return kind
        slips = bool(system.rigid[i]) or system.damping[i] > 0.0
        if (
            kind is EventKind.OPENS
            and slips
            and np.any(self.phase[rows & ~elements.normal] != OPEN)
        ):
            rows, kind = rows & ~elements.normal, EventKind.SLIPS
        # The ground under a contact with a damper keeps its place.
        gap = (
            self.gap[i] if kind is EventKind.CLOSES else self.z[i] / np.sqrt(elements.stiffness[i])
        )
        self.phase[rows], self.z[rows], self.gap[rows] = (
            LOADING if kind is EventKind.CLOSES else OPEN,
            0.0,
            0.0,
        )
        self.slope[rows] = np.sqrt(elements.stiffness[rows])
        self.slow[rows], self.slipped[i] = False, kind is EventKind.SLIPS
        if system.damping[i] > 0.0 and kind is EventKind.CLOSES:
            self.z[i], self.largest[i] = self.slope[i] * gap, 0.0
        elif system.damping[i] > 0.0 and kind is EventKind.OPENS:
            self.gap[i] = gap
        return kind
