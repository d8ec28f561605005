"""The state of a landing on elements of finite stiffness at an event.

It has the motion until the next event, and what changes there.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

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
"""Multiple of the duration so far for which all contacts have to stay open after the end.

What closes later is another impact.
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


class _InModes(NamedTuple):
    """The state in modes, and its oscillations.

    Attributes:
        moves: (m,) which modes have a frequency.
        deflection: (m,) from that at which constant forces balance them [√J].
        velocity: (m,) from that at which constant forces leave them [√J].
        drift: (m,) velocities that do not oscillate.
        oscillations: from these on.
    """

    moves: np.ndarray
    deflection: Array
    velocity: Array
    drift: Array
    oscillations: Oscillations


def _in_modes(loaded: Loaded, u: Array, z: Array) -> _InModes:
    """The state in modes. Args: u (d,), and z (r,) of the springs that are loaded."""
    moves = deflects = loaded.sigma > 0.0
    if loaded.damped is not None:
        deflects = loaded.damped.deflects
    deflection = np.where(deflects, loaded.U.T @ z - loaded.balanced, 0.0)
    velocity = loaded.V.T @ u
    drift = np.where(moves, loaded.creep, velocity)
    velocity = velocity - loaded.creep
    if loaded.damped is None:
        oscillations = undamped(loaded.sigma, deflection, velocity)
    else:
        oscillations = damped(loaded.damped, deflection, velocity)
    return _InModes(moves, deflection, velocity, drift, oscillations)


class State:
    """Phases of the elements at an event, and the velocity then.

    `step` goes to the next event, `switch` lets it happen.

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
        load = np.asarray(elements.load)[system.sprung]
        self.z[system.sprung] = -load / self.slope[system.sprung]
        self.jump, self.displacement = np.zeros((2, len(system.u)))
        self.slow, self.slipped = np.zeros((2, r), dtype=bool)
        closing = elements.contact[system.approaches]
        strikes = np.any(elements.contact == closing[:, None], axis=0)
        self.phase = np.where((elements.contact < 0) | strikes, LOADING, OPEN)

    @property
    def separated(self) -> bool:
        """True if all contacts are open."""
        return not (self.phase[self.system.grounded] != OPEN).any()

    def _over(self, motion: Free) -> bool:
        """True if no contact compresses further, rebounds or carries more than its constant load.

        Constant forces make that load.

        A contact carries no more where its force, which oscillates about what constant forces make,
        is below that, or oscillates little. Without constant forces all contacts are open then.
        """
        system, elements = self.system, self.system.elements
        if self.separated or not system.pull.any():
            return self.separated
        rate = system.W @ (system.u + self.jump)
        closed = system.grounded & (self.phase != OPEN)
        held = (self.phase == UNLOADING) & system.rigid
        moves = np.abs(motion.wave[RATE]).sum(axis=1) > system.slowly
        loading = (self.phase == LOADING) & system.lossy & ~self.slow & (elements.normal | moves)
        rebounds = elements.normal & ~held & (rate > 2.0 * system.noise * system.length)
        if np.any(closed & (loading | rebounds)):
            return False
        normal = np.flatnonzero(closed & elements.normal)
        return not np.any(self._excess(motion)[normal] > 4.0 * system.push_noise[normal])

    def _excess(self, motion: Free) -> Array:
        """Forces (r,) that press beyond what constant forces make.

        They are −∞ where they oscillate little.
        """
        amplitude = np.abs(motion.wave[TOTAL]).sum(axis=1) * self.slope
        beyond = motion.rest - motion.start[TOTAL] - self._left
        return np.where(amplitude <= EASED * self.largest, -np.inf, beyond)

    @property
    def _left(self) -> Array:
        """Scaled forces (r,) that count as none.

        They are those of contacts with a damper in series, which may decay without end.
        """
        slowly, length = self.system.slowly, self.system.rigid_length
        decays = (self.system.relaxation > 0.0) & (length > 0.0)
        return np.divide(slowly, length, out=np.zeros_like(length), where=decays)

    def modes(self) -> Modes:
        """The modes of the elements that are loaded now, without dampers."""
        motion = self._motion(dampers=False)
        loaded, k = motion.loaded, self.system.elements.stiffness[:, None]
        moves = loaded.sigma > 0.0
        # Forces of the elements for a unit deflection of each mode [N/√J].
        shape = (self.slope[:, None] * (loaded.to_all @ loaded.U))[:, moves]
        return Modes(
            frequency=loaded.sigma[moves] / (2.0 * np.pi),
            energy=(loaded.V.T @ motion.u)[moves] ** 2 / 2.0,
            participation=np.divide(shape**2, k, out=np.zeros_like(shape), where=k > 0.0),
            force=np.abs(shape * motion.oscillations.deflection[moves]),
        )

    def _closes_again(self, motion: Free, horizon: float) -> bool:
        """True if an open contact closes noticeably within a horizon [s].

        Constant forces are taken to change no velocity.

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
        k = np.where(of_push, self.slope[element], self.system.elements.stiffness[element])
        depth = EASED * self.largest[element] / k
        signals = signals._replace(
            tolerance=signals.tolerance + depth,
            linear=signals.linear - fall,
            square=0.0 * signals.square,
        )
        _, first = first_crossing(motion.oscillations.rate, signals, horizon, self.effort)
        return first is not None

    def step(
        self, time: float, horizon: float, may_end: bool
    ) -> tuple[Segment | None, Watch | None]:
        """Go to the next event, at most by a horizon [s].

        The result is the segment until then, if any, and what happens there.

        Where the motion may end there is neither once the impact is over. Watched are the rate of
        what is loaded, the force of what is unloaded and the gap of open contacts.
        """
        system = self.system
        rigid = (self.phase == UNLOADING) & system.rigid
        if rigid.any() and not (self._sprung(rigid).any() or system.pull.any()):
            # Nothing presses what is held on the ground, so that it is released.
            released = int(np.flatnonzero(rigid & system.elements.normal)[0])
            return None, Watch(released, EventKind.OPENS, 0.0, 0.0, 1.0)
        motion = self._motion()
        # With a damper the force may be largest when the spring is not yet compressed.
        larger = np.maximum(self.largest, -self.slope * motion.start[TOTAL])
        self.largest = np.where(system.viscous > 0.0, larger, self.largest)
        watched = [*self._watched(), *self._watched_in(motion)]
        _, signals = self._signals(motion, watched)
        # What is below zero already happens at once.
        early = np.where(signals.either, np.inf, signals.start + signals.tolerance)
        if early.min(initial=np.inf) < 0.0:
            return None, watched[int(early.argmin())]
        if may_end and self._over(motion) and not self._closes_again(motion, STAYS_OPEN * time):
            return None, None
        # Until then no element changes, and the motion is known in closed form.
        length, first = first_crossing(motion.oscillations.rate, signals, horizon, self.effort)
        segment = self._segment(motion, time, length)
        self.jump, displacement = segment.after(np.asarray(length))
        self.gap = self.gap + system.W @ (displacement - self.displacement)
        self.displacement = displacement
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
        """The quantities that depend on which elements are loaded now.

        Args: dampers, whether those act.
        """
        held = (self.phase == UNLOADING) & self.system.rigid
        sprung = self._sprung(held)
        return self.system.loaded(held.tobytes(), sprung.tobytes(), self.slope.tobytes(), dampers)

    def _motion(self, dampers: bool = True) -> Free:
        """The motion until the next event. What held rows stop is at rest from now on."""
        system = self.system
        loaded = self._loaded(dampers)
        if len(loaded.fixed):
            self.jump = self.jump - loaded.still @ (system.u + self.jump)
        u, z = system.u + self.jump, np.where(loaded.sprung, self.z, 0.0)
        at = _in_modes(loaded, u, z)
        rate, p, speed, _ = at.oscillations

        # What elements feel of unit modes: rates, forces of springs, of held rows by velocities,
        # and of dampers.
        of_u, of_z = system.W @ loaded.V, loaded.to_all @ loaded.U
        of_held, of_damper = loaded.held @ loaded.V, loaded.damper @ loaded.V
        forces = loaded.to_all @ z + loaded.held @ u + loaded.balance
        oscillating = np.where(at.moves, at.velocity, 0.0)
        rest = forces - of_z @ at.deflection - of_held @ oscillating

        # Each signal is start + linear t + square t² + Re Σ_j wave_j (exp(λ_j t) − 1). The gap is
        # the integral of the rate: its waves are those of the rate divided by λ_j.
        start = self._with_push(system.W @ u, forces, self.gap, forces + loaded.damper @ u)
        zero = np.zeros(len(z))
        falling = of_u @ np.where(at.moves, 0.0, loaded.V.T @ loaded.pull)
        linear = self._with_push(falling, zero, of_u @ at.drift, zero)
        square = self._with_push(zero, zero, falling / 2.0, zero)
        path = np.divide(speed, rate, out=np.zeros_like(speed), where=rate != 0.0)
        of_forces = along(of_z, p) + along(of_held, speed)
        of_total = of_forces + along(of_damper, speed)
        wave = self._with_push(along(of_u, speed), of_forces, along(of_u, path), of_total)
        bound: Array | float = np.inf
        if loaded.damped is not None:
            first, second = at.oscillations.bounds
            of_springs = np.linalg.norm(of_z, axis=1)
            by_held = np.hypot(of_springs, np.linalg.norm(of_held, axis=1))
            in_all = np.hypot(of_springs, np.linalg.norm(of_held + of_damper, axis=1))
            bound = self._with_push(
                system.length * second, by_held * second, system.length * first, in_all * second
            )
        return Free(loaded, u, forces, rest, at.oscillations, start, linear, square, wave, bound)

    def _with_push(self, rate: Any, force: Any, gap: Any, total: Any) -> Any:
        """Five signals (5, r, ...), in the order of RATE to PUSH.

        They are these four, and √k gap + c rate.
        """
        shape = (-1,) + (1,) * (np.ndim(gap) - 1)
        root = np.sqrt(self.system.elements.stiffness).reshape(shape)
        viscous = self.system.viscous.reshape(shape)
        return np.array([rate, force, gap, total, root * gap + viscous * rate])

    def _signals(self, motion: Free, watched: list[Watch]) -> tuple[np.ndarray, Signals]:
        """The signals of what is watched: which each is, and these."""
        element = np.array([watch.element for watch in watched], dtype=int)
        signal = np.array([WATCHED[watch.kind] for watch in watched], dtype=int)
        values = np.array([watch[2:] for watch in watched], dtype=float).reshape(-1, 4)
        tolerance, offset, sign, either = values.T
        # Within the ground that it has compressed, an open contact with a damper closes when it
        # would be pressed.
        closes = np.array([watch.kind is EventKind.CLOSES for watch in watched], dtype=bool)
        is_damped = self.system.damping[element] > 0.0
        inside = closes & is_damped & (self.gap[element] < -tolerance)
        signal = np.where(inside, PUSH, signal)
        tolerance = np.where(inside, self.system.push_noise[element], tolerance)
        row = signal, element
        bound = motion.bound
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

    def _watched(self) -> Iterator[Watch]:
        """Events that can happen to the elements as they are."""
        rates = self.system.W @ (self.system.u + self.jump)
        # Numbers of Python, because those of NumPy take ten times as long one by one.
        for i, phase in enumerate(self.phase.tolist()):
            if phase == LOADING and self.system.lossy[i]:
                yield from self._watched_loading(i)
            elif phase == UNLOADING:
                yield from self._watched_unloading(i, float(rates[i]))
            elif phase == OPEN and self.system.elements.normal[i]:
                yield from self._watched_open(i)

    def _watched_loading(self, i: int) -> Iterator[Watch]:
        """Events that can load an element.

        A contact is loaded against its normal; an element without force, in the direction in which
        it moves first.
        """
        system, normal, z = self.system, bool(self.system.elements.normal[i]), float(self.z[i])
        tolerance = system.noise * float(system.length[i])
        sign = -1.0 if normal or z < 0.0 else 1.0
        either = not normal and z == 0.0
        yield Watch(i, EventKind.UNLOADS, tolerance, 0.0, sign, either)
        if system.viscous[i] and normal and not self.slow[i]:
            yield Watch(i, EventKind.SLOWS, 0.0, -float(system.slowly[i]), -1.0)

    def _watched_unloading(self, i: int, rate: float) -> Iterator[Watch]:
        """An element reaches zero, or its peak again. Args: rate, of its length [m/s]."""
        system, normal, noise = self.system, bool(self.system.elements.normal[i]), self.system.noise
        length, viscous, peak = float(system.length[i]), float(system.viscous[i]), self.peak[i]
        held = bool(system.rigid[i])
        loaded = -1.0 if normal or peak < 0.0 else 1.0
        tolerance = noise * (1.0 + viscous * length)
        if viscous and self.slipped[i]:
            # After a slip the force of a contact with a damper goes on from zero.
            tolerance *= 2.0
        if held:
            # What is held by no force is released.
            tolerance = -noise
        ends = EventKind.OPENS if normal else EventKind.REVERSES
        yield Watch(i, ends, tolerance, 0.0, loaded)
        yield Watch(i, EventKind.RELOADS, noise, abs(float(peak)), -loaded)
        if normal and not held and rate > 2.0 * noise * length:
            yield Watch(i, EventKind.TURNS, 2.0 * noise * length, 0.0, 1.0)

    def _watched_open(self, i: int) -> Iterator[Watch]:
        """A contact closes, and one with a damper clears the ground that it had compressed."""
        system = self.system
        tolerance = system.noise * float(system.length[i]) / system.fastest
        yield Watch(i, EventKind.CLOSES, tolerance, 0.0, 1.0)
        if system.viscous[i] and self.gap[i] < -tolerance:
            yield Watch(i, EventKind.CLEARS, tolerance, 0.0, -1.0)

    def _watched_in(self, motion: Free) -> Iterator[Watch]:
        """Further events that can happen in a motion.

        Forces ease to what stays constant, and dampers in series creep.
        """
        system, normal = self.system, self.system.elements.normal
        if system.pull.any():
            yields = (self.phase == UNLOADING) | ((self.phase == LOADING) & self.slow)
            eases = yields & normal & (self._excess(motion) > 4.0 * system.push_noise)
            level = motion.rest - self._left
            for i in np.flatnonzero(eases).tolist():
                tolerance, offset = 2.0 * system.push_noise[i], float(level[i])
                yield Watch(i, EventKind.EASES, tolerance, offset, -1.0)
        creep = motion.start[RATE] - motion.wave[RATE].real.sum(axis=1)
        creeps = (self.phase == LOADING) & normal & ~self.slow & (system.relaxation > 0.0)
        for i in np.flatnonzero(creeps).tolist():
            yield Watch(i, EventKind.SLOWS, 0.0, float(creep[i] - system.slowly[i]), -1.0)

    def switch(self, i: int, kind: EventKind) -> EventKind:
        """Let an event happen to element i; returns what it is in full.

        A contact that would open may slip first.
        """
        system, elements = self.system, self.system.elements
        e = 1.0 if system.rigid[i] else float(elements.restitution[i])
        rows = elements.contact == elements.contact[i]
        if kind in UNFELT:
            self.slow[i] |= kind is EventKind.SLOWS
            return kind
        if kind is EventKind.UNLOADS:
            # The force, slope · z, stays; the energy z² / 2 becomes e² times as large.
            self.phase[i], self.slope[i], self.z[i] = UNLOADING, self.slope[i] / e, self.z[i] * e
            self.peak[i] = self.z[i]
            self.largest[i] = max(self.largest[i], self.slope[i] * abs(self.z[i]))
            return kind
        if kind in (EventKind.RELOADS, EventKind.REVERSES):
            self.phase[i], self.slope[i] = LOADING, self.slope[i] * e
            if kind is EventKind.REVERSES:
                self.z[i] = 0.0
            elif system.rigid[i]:
                # The force of a row that is held jumps where another one is held too; the row is
                # then loaded from its peak.
                self.z[i] = self.peak[i]
            else:
                self.z[i] = self.z[i] / e
            return kind
        slips = bool(system.rigid[i]) or system.damping[i] > 0.0
        tangents = rows & ~elements.normal
        if kind is EventKind.OPENS and slips and np.any(self.phase[tangents] != OPEN):
            rows, kind = tangents, EventKind.SLIPS
        # The ground under a contact with a damper keeps its place.
        closes = kind is EventKind.CLOSES
        gap = self.gap[i]
        if not closes:
            gap = self.z[i] / np.sqrt(elements.stiffness[i])
        self.phase[rows] = LOADING if closes else OPEN
        self.z[rows], self.gap[rows] = 0.0, 0.0
        self.slope[rows] = np.sqrt(elements.stiffness[rows])
        self.slow[rows], self.slipped[i] = False, kind is EventKind.SLIPS
        if system.damping[i] > 0.0 and kind is EventKind.CLOSES:
            self.z[i], self.largest[i] = self.slope[i] * gap, 0.0
        elif system.damping[i] > 0.0 and kind is EventKind.OPENS:
            self.gap[i] = gap
        return kind
