"""The state of a landing on elements of finite stiffness at an event, the motion until the next one, and what changes there."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.crossing import ComplexArray, Effort, Signals, changes, first_crossing
from shockpc.core.damped import Damped, Oscillations, along, damped, damped_modes, undamped
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.core.stiff_motion import Elements, Modes, Segment

OPEN, LOADING, UNLOADING = range(3)

UNLOADS, RELOADS, REVERSES, SLIPS, OPENS, CLOSES, EASES, TURNS, SLOWS, CLEARS = range(10)

EVENTS = "unloads", "reloads", "reverses", "slips", "opens", "closes"
"""What can happen to an element; a normal that unloads is at the end of its compression. The other numbers change no force:

a normal force has *eased* to what constant forces make; after that, its contact *turns* back towards the ground; a contact with a
damper is *slow*, with which its compression counts as ended; an open one has *cleared* the ground that it had compressed.
"""

RATE, FORCE, GAP, TOTAL, PUSH = range(5)

WATCHED = np.array([RATE, FORCE, FORCE, FORCE, TOTAL, GAP, TOTAL, RATE, RATE, GAP])
"""What tells of each: the rate of an element, its force without and with that of its damper, or the gap."""

NEGLIGIBLE = 1e-11
"""Share of the motion that excites the elements, below which what moves or presses counts as rounding."""

DEPENDENT = 1e-13
"""Share of the largest frequency below which that of a mode is rounding: its rows are dependent, or it moves no spring."""

STAYS_OPEN = 10.0
"""Times the motion so far for which all contacts have to stay open, so that it has ended: what closes later is another impact."""

EASED = 0.01
"""Share of the largest force and compression of a contact, and of the speed of the impact, below which nothing is noticeable."""


class Loaded(NamedTuple):
    """What depends on which elements are loaded.

    Attributes:
        fixed: rows that are held.
        sprung: (r,) rows with a spring that is loaded.
        still: (d, d) part of u that the held rows stop.
        to_all, held: (r, r) and (r, d) from z and u to the forces of all elements, of a held row with what dampers press on it.
        balance: (r,) the same of constant forces.
        damper: (r, d) from u to the forces of dampers.
        damped: the modes with the dampers that act; None without one.
        pull: (d,) rate at which constant forces change u.
        U, sigma, V: the modes, of the frequencies sigma (m,).
    """

    fixed: np.ndarray
    sprung: np.ndarray
    still: Array
    to_all: Array
    held: Array
    balance: Array
    damper: Array
    damped: Damped | None
    pull: Array
    U: Array
    sigma: Array
    V: Array


class Free(NamedTuple):
    """The motion until the next event.

    Attributes:
        loaded: what it depends on.
        u: (d,) at the start.
        forces: (r,) of all elements at the start, without those of dampers.
        rest: (r,) part of the forces that stays constant.
        oscillations: in modes.
        start, linear, square, wave, bound: (5r, ...) as in `Signals`, of rate, force, gap, force with damper, and of the force
            that an open contact with a damper would have.
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
    """The state of elements and motion at an event, in the d coordinates of u along the rows of the elements.

    All forces are scaled: they are those of the elements divided by −slope.

    Attributes:
        W: (r, d) velocity along each element for unit u.
        to_velocity, constant, gravity, falling: as in `StiffMotion`.
        mode: (r,) OPEN, LOADING or UNLOADING.
        slope: (r,) √κ.
        z: (r,) √κ (B x − a), zero where an element is open.
        peak: (r,) z at the start of unloading.
        largest: (r,) largest force of each normal at an event [N].
        gap: (r,) B x since the contact opened; of one with a damper, since it first closed [m].
        u, jump: (d,) at the impact, and the change since then.
        pull: (d,) rate at which constant forces change u.
        displacement: (d,) ∫u dt.
        noise: size of z and u that counts as rounding.
        fastest: largest natural frequency of a single element [rad/s].
        slow: (r,) normals of contacts with a damper that are compressed further only slowly.
        slipped: (r,) normals of contacts whose tangential springs are open.
        effort: of the search for events.
    """

    def __init__(
        self, elements: Elements, W: Array, to_velocity: Array, from_velocity: Array, velocity: Array, gravity: Array
    ) -> None:
        self.elements, self.W, self.to_velocity, self.u = elements, W, to_velocity, from_velocity @ velocity
        self.constant = velocity - self.to_velocity @ self.u
        free = from_velocity @ gravity
        self.gravity, self.falling = gravity, gravity - self.to_velocity @ free
        self.normal, self.rigid, self.grounded = elements.normal.tolist(), elements.restitution == 0.0, elements.contact >= 0
        self.lossy = elements.normal | (elements.restitution < 1.0)
        self.length = np.linalg.norm(self.W, axis=1)
        self.slope = np.sqrt(elements.stiffness)
        self.sprung = elements.stiffness > 0.0
        self.damping = np.broadcast_to(np.asarray(elements.damping, dtype=float), len(self.W))
        # The force of a damper for a unit rate, scaled; 2ζ of a single row for a unit u.
        self.viscous = self.damping / np.where(self.sprung, self.slope, 1.0)
        self.z, self.peak, self.largest, self.gap = np.zeros((4, len(self.W)))
        load = np.asarray(elements.load)
        self.z[self.sprung] = -load[self.sprung] / self.slope[self.sprung]
        self.steady = np.where(self.sprung, 0.0, load)
        self.pull = free + self.W.T @ self.steady
        self.jump, self.displacement = np.zeros((2, len(self.u)))
        self.slow, self.slipped = np.zeros((2, len(self.W)), dtype=bool)
        # What single contacts come to rest at counts like the speed.
        speed, single = float(np.linalg.norm(self.u)), (self.slope * self.length)[elements.normal]
        self.noise = NEGLIGIBLE * (speed + float(np.linalg.norm(self.pull)) / float(single.min()))
        self.fastest = float((self.slope * self.length).max())
        self.effort = Effort()
        approach = elements.normal & (self.W @ self.u < -1e-13 * self.length * speed)
        closing = elements.contact[approach]
        self.mode = np.where((elements.contact < 0) | np.any(elements.contact == closing[:, None], axis=0), LOADING, OPEN)
        self.slowly = EASED * float(np.max(-(self.W @ self.u)[approach] / self.length[approach], initial=0.0)) * self.length

    @property
    def separated(self) -> bool:
        """Whether all contacts are open."""
        return not (self.mode[self.grounded] != OPEN).any()

    def _over(self, motion: "Free") -> bool:
        """Whether no contact is compressed further or rebounds, and none carries more than constant forces make.

        A contact carries no more where its force, which oscillates about what constant forces make, is below that, or oscillates
        little. Without constant forces all contacts are open then.
        """
        if self.separated or not self.pull.any():
            return self.separated
        rate = self.W @ (self.u + self.jump)
        closed, held = self.grounded & (self.mode != OPEN), (self.mode == UNLOADING) & self.rigid
        moves = np.abs(motion.wave[: len(self.z)]).sum(axis=1) > self.slowly
        loading = (self.mode == LOADING) & self.lossy & ~self.slow & (self.elements.normal | moves)
        rebounds = self.elements.normal & ~held & (rate > 2.0 * self.noise * self.length)
        if np.any(closed & (loading | rebounds)):
            return False
        normal = np.flatnonzero(closed & self.elements.normal)
        return not np.any(self._excess(motion)[normal] > 4.0 * self._push_noise()[normal])

    def _excess(self, motion: "Free") -> Array:
        """Forces (r,) that press beyond what constant forces make; −∞ where they oscillate little."""
        count = len(self.z)
        amplitude = np.abs(motion.wave[TOTAL * count : PUSH * count]).sum(axis=1) * self.slope
        beyond = motion.rest - motion.start[TOTAL * count : PUSH * count]
        return np.where(amplitude <= EASED * self.largest, -np.inf, beyond)

    def modes(self) -> Modes:
        """The modes of the elements that are loaded now, without dampers."""
        motion = self._motion(dampers=False)
        _, _, _, to_all, *_, U, sigma, V = motion.loaded
        moves, k = sigma > 0.0, self.elements.stiffness[:, None]
        shape = (self.slope[:, None] * (to_all @ U))[:, moves]
        participation = np.divide(shape**2, k, out=np.zeros_like(shape), where=k > 0.0)
        amplitude = np.abs(shape * motion.oscillations.deflection[moves])
        return Modes(sigma[moves] / (2.0 * np.pi), (V.T @ motion.u)[moves] ** 2 / 2.0, participation, amplitude)

    def _closes_again(self, motion: "Free", horizon: float) -> bool:
        """Whether an open contact closes within a horizon [s] noticeably, if constant forces change no velocity.

        As it would without force: it then goes beyond where it closes by more than a share of its largest compression.
        """
        watched = [one for one in self._watched() if one[1] == CLOSES]
        if not watched:
            return False
        count = len(self.z)
        row, signals = self._signals(motion, watched)
        # What falls in the force that it would have; the rate of a gap does not.
        fall = np.concatenate([np.zeros(PUSH * count), self.viscous * motion.linear[:count]])
        of_push = row >= PUSH * count
        depth = EASED * self.largest[row % count] / np.where(of_push, self.slope[row % count], self.elements.stiffness[row % count])
        signals = signals._replace(
            tolerance=signals.tolerance + depth, linear=signals.linear - fall[row], square=0.0 * signals.square
        )
        return first_crossing(motion.oscillations.rate, signals, horizon, self.effort)[1] is not None

    def step(self, time: float, horizon: float, may_end: bool) -> tuple[Segment | None, tuple[int, int] | None]:
        """Go to the next event, at most by a horizon [s]; the segment until then, if any, and the element and what happens to it.

        Where the motion may end there is neither once the impact is over.

        Watched are the rate of what is loaded, the force of what is unloaded and the gap of open contacts: an element changes when
        its number falls below −tolerance.
        """
        rigid = (self.mode == UNLOADING) & self.rigid
        if rigid.any() and not (self._sprung(rigid).any() or self.pull.any()):
            # Nothing presses what is held on the ground, so that it is released.
            return None, (int(np.flatnonzero(rigid & self.elements.normal)[0]), OPENS)
        motion, watched = self._motion(), list(self._watched())
        (rate, _, velocity, _), loaded = motion.oscillations, motion.loaded
        total = motion.start[TOTAL * len(self.z) : PUSH * len(self.z)]
        self.largest = np.where(self.viscous > 0.0, np.maximum(self.largest, -self.slope * total), self.largest)
        eases = ((self.mode == UNLOADING) | ((self.mode == LOADING) & self.slow)) & self.elements.normal & bool(self.pull.any())
        for i in np.flatnonzero(eases & (self._excess(motion) > 4.0 * self._push_noise())).tolist():
            watched.append((i, EASES, False, 2.0 * self._push_noise()[i], float(motion.rest[i]), -1.0))
        _, signals = self._signals(motion, watched)
        early = np.where(signals.either, np.inf, signals.start + signals.tolerance)
        if early.min(initial=np.inf) < 0.0:
            return None, watched[int(early.argmin())][:2]
        if may_end and self._over(motion) and not self._closes_again(motion, STAYS_OPEN * time):
            return None, None
        length, first = first_crossing(rate, signals, horizon, self.effort)
        count, still = len(self.z), loaded.sigma == 0.0
        drift, acceleration = (loaded.V @ np.where(still, loaded.V.T @ part, 0.0) for part in (motion.u, loaded.pull))
        segment = Segment(
            time,
            length,
            rate,
            self.steady - self.slope * motion.rest,
            -self.slope[:, None] * motion.wave[TOTAL * count : PUSH * count],
            along(loaded.V, velocity),
            drift,
            acceleration,
            self.jump,
            self.displacement,
        )
        self.jump, displacement = segment.after(np.asarray(length))
        self.gap, self.displacement = self.gap + self.W @ (displacement - self.displacement), displacement
        self.z = motion.forces + changes(length * rate, motion.wave[FORCE * count : GAP * count])
        return segment, None if first is None else watched[first][:2]

    def _sprung(self, rigid: np.ndarray) -> np.ndarray:
        """The rows (r,) with springs that are loaded, with some rows held."""
        return np.asarray((self.mode != OPEN) & ~rigid & self.sprung)

    def _loaded(self, dampers: bool) -> Loaded:
        """What depends on which elements are loaded now. Args: dampers, whether those act."""
        held = (self.mode == UNLOADING) & self.rigid
        return self._loaded_of(held.tobytes(), self._sprung(held).tobytes(), self.slope.tobytes(), dampers)

    @memoized(most=64)
    def _loaded_of(self, held_rows: bytes, sprung_rows: bytes, slopes: bytes, dampers: bool) -> Loaded:
        """The same of some rows and slopes: where contacts open and close, the same are loaded again and again.

        Args:
            held_rows: bytes of a bool array (r,), which rows are held.
            sprung_rows: the same, which have springs that are loaded.
            slopes: bytes of the slopes (r,).
            dampers: whether those act.
        """
        sprung, slope = np.frombuffer(sprung_rows, dtype=bool), np.frombuffer(slopes)
        fixed = np.flatnonzero(np.frombuffer(held_rows, dtype=bool))
        r, d = self.W.shape
        F, pull, still = np.where(sprung, slope, 0.0)[:, None] * self.W, self.pull, np.zeros((d, d))
        acting = sprung & (self.damping > 0.0) & dampers
        damper, G = np.where(acting, self.viscous, 0.0)[:, None] * self.W, np.sqrt(self.damping[acting])[:, None] * self.W[acting]
        # The scaled forces of all elements are to_all · z + held · u + balance.
        to_all, held, balance = np.diag(sprung.astype(float)), np.zeros((r, d)), np.zeros(r)
        if len(fixed):
            # From H u̇ = 0 with u̇ = −Fᵀz − GᵀGu − Hᵀm + c follows m = (H Hᵀ)⁻¹ H (c − Fᵀz − GᵀGu); of dependent rows each takes
            # the least share.
            H, size = self.W[fixed] / self.length[fixed, None], (slope * self.length)[fixed]
            least = np.linalg.pinv(H.T, rcond=1e-9)
            still = H.T @ least
            to_all[fixed], balance[fixed] = -(least @ F.T) / size[:, None], least @ pull / size
            held[fixed] = -(least @ G.T @ G) / size[:, None]
            F, G, pull = F - F @ still, G - G @ still, pull - still @ pull
        U, sigma, Vt = np.linalg.svd(F, full_matrices=False)
        sigma[sigma < DEPENDENT * sigma.max(initial=0.0)] = 0.0
        of_dampers = damped_modes(sigma, G @ Vt.T) if len(G) else None
        return Loaded(fixed, sprung, still, to_all, held, balance, damper, of_dampers, pull, U, sigma, Vt.T)

    def _motion(self, dampers: bool = True) -> Free:
        """The motion until the next event. What held rows stop is at rest from now on."""
        loaded = self._loaded(dampers)
        _, sprung, still, to_all, held, balance, damper, of_dampers, pull, U, sigma, V = loaded
        if len(loaded.fixed):
            self.jump = self.jump - still @ (self.u + self.jump)
        u, z = self.u + self.jump, np.where(sprung, self.z, 0.0)
        moves = sigma > 0.0
        inverse = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=moves)
        # From the deflection in which they are at rest.
        velocity, pulled = V.T @ u, V.T @ pull
        deflection = np.where(moves, U.T @ z - inverse * pulled, 0.0)
        oscillations = undamped(sigma, deflection, velocity) if of_dampers is None else damped(of_dampers, deflection, velocity)
        rate, p, speed, (first, second) = oscillations
        of_u, of_z, of_held, of_damper = self.W @ V, to_all @ U, held @ V, damper @ V
        forces = to_all @ z + held @ u + balance
        rest = forces - of_z @ deflection - of_held @ np.where(moves, velocity, 0.0)
        falling, drifting, zero = of_u @ np.where(moves, 0.0, pulled), of_u @ np.where(moves, 0.0, velocity), np.zeros(len(z))
        path = np.divide(speed, rate, out=np.zeros_like(speed), where=rate != 0.0)
        of_rate, of_force, of_gap = along(of_u, speed), along(of_z, p) + along(of_held, speed), along(of_u, path)
        rates, push = self.W @ u, np.sqrt(self.elements.stiffness)
        start = [rates, forces, self.gap, forces + damper @ u, push * self.gap + self.viscous * rates]
        linear = [falling, zero, drifting, zero, push * drifting + self.viscous * falling]
        square = [zero, zero, falling / 2.0, zero, push * falling / 2.0]
        wave = [
            of_rate,
            of_force,
            of_gap,
            of_force + along(of_damper, speed),
            push[:, None] * of_gap + self.viscous[:, None] * of_rate,
        ]
        bound: Array | float = np.inf
        if of_dampers is not None:
            of_forces = np.hypot(np.linalg.norm(of_z, axis=1), np.linalg.norm(of_held, axis=1))
            of_total = np.hypot(np.linalg.norm(of_z, axis=1), np.linalg.norm(of_held + of_damper, axis=1))
            sizes = [self.length * second, of_forces * second, self.length * first, of_total * second]
            bound = np.concatenate([*sizes, push * sizes[GAP] + self.viscous * sizes[RATE]])
        parts = np.concatenate(start), np.concatenate(linear), np.concatenate(square)
        return Free(loaded, u, forces, rest, oscillations, *parts, np.concatenate(wave), bound)

    def _signals(self, motion: Free, watched: list[tuple[int, int, bool, float, float, float]]) -> tuple[np.ndarray, Signals]:
        """The rows of some signals, and these."""
        element, kind, either, tolerance, offset, sign = np.array(watched).reshape(-1, 6).T
        block = WATCHED[kind.astype(int)]
        # Within the ground that it has compressed, an open contact with a damper closes when it would be pressed.
        inside = (kind == CLOSES) & (self.damping[element.astype(int)] > 0.0) & (self.gap[element.astype(int)] < -tolerance)
        row = (element + len(self.z) * np.where(inside, PUSH, block)).astype(int)
        tolerance = np.where(inside, self._push_noise()[element.astype(int)], tolerance)
        bound = motion.bound[row] if isinstance(motion.bound, np.ndarray) else motion.bound
        start = offset + sign * motion.start[row]
        linear, square, wave = sign * motion.linear[row], sign * motion.square[row], sign[:, None] * motion.wave[row]
        return row, Signals(either != 0.0, tolerance, start, linear, square, wave, bound)

    def _push_noise(self) -> Array:
        """Scaled forces (r,) of spring and damper that count as rounding."""
        return np.asarray(self.noise * (1.0 + self.viscous * self.length))

    def _watched(self) -> Iterator[tuple[int, int, bool, float, float, float]]:
        """What can change: element, event, whether its number counts with the sign that it has first, tolerance, constant, sign."""
        # Numbers of Python, because those of NumPy take ten times as long one by one.
        deflection, peak, rigid, noise = self.z.tolist(), self.peak.tolist(), self.rigid.tolist(), self.noise
        viscous, gap, rate = self.viscous.tolist(), self.gap.tolist(), (self.W @ (self.u + self.jump)).tolist()
        for i, (mode, normal, length) in enumerate(zip(self.mode.tolist(), self.normal, self.length.tolist(), strict=True)):
            if mode == LOADING and self.lossy[i]:
                # A contact is loaded against its normal; an element without force, in the direction in which it moves first.
                either = not normal and deflection[i] == 0.0
                yield i, UNLOADS, either, noise * length, 0.0, -1.0 if normal or deflection[i] < 0.0 else 1.0
                if viscous[i] and normal and not self.slow[i]:
                    yield i, SLOWS, False, 0.0, -float(self.slowly[i]), -1.0
            elif mode == UNLOADING:
                loaded = -1.0 if normal or peak[i] < 0.0 else 1.0
                # After a slip the force of a contact with a damper goes on from zero.
                push = noise * (1.0 + viscous[i] * length) * (2.0 if viscous[i] and self.slipped[i] else 1.0)
                # What is held by no force is released.
                yield i, OPENS if normal else REVERSES, False, -noise if rigid[i] else push, 0.0, loaded
                yield i, RELOADS, False, noise, abs(peak[i]), -loaded
                if normal and not rigid[i] and rate[i] > 2.0 * noise * length:
                    yield i, TURNS, False, 2.0 * noise * length, 0.0, 1.0
            elif mode == OPEN and normal:
                tolerance = noise * length / self.fastest
                yield i, CLOSES, False, tolerance, 0.0, 1.0
                if viscous[i] and gap[i] < -tolerance:
                    yield i, CLEARS, False, tolerance, 0.0, -1.0

    def switch(self, i: int, kind: int) -> int:
        """Let an event happen to element i; what it is in full."""
        e = 1.0 if self.rigid[i] else float(self.elements.restitution[i])
        rows = self.elements.contact == self.elements.contact[i]
        if kind in (EASES, TURNS, SLOWS, CLEARS):
            self.slow[i] |= kind == SLOWS
            return kind
        if kind == UNLOADS:
            self.mode[i], self.slope[i], self.z[i] = UNLOADING, self.slope[i] / e, self.z[i] * e
            self.peak[i] = self.z[i]
            self.largest[i] = max(self.largest[i], self.slope[i] * abs(self.z[i]))
            return kind
        if kind in (RELOADS, REVERSES):
            self.mode[i], self.slope[i] = LOADING, self.slope[i] * e
            # The force of a row that is held jumps where another one is held too; the row is then loaded from its peak.
            self.z[i] = 0.0 if kind == REVERSES else self.peak[i] if self.rigid[i] else self.z[i] / e
            return kind
        slips = bool(self.rigid[i]) or self.damping[i] > 0.0
        if kind == OPENS and slips and np.any(self.mode[rows & ~self.elements.normal] != OPEN):
            rows, kind = rows & ~self.elements.normal, SLIPS
        # The ground under a contact with a damper keeps its place.
        gap = self.gap[i] if kind == CLOSES else self.z[i] / np.sqrt(self.elements.stiffness[i])
        self.mode[rows], self.z[rows], self.gap[rows] = LOADING if kind == CLOSES else OPEN, 0.0, 0.0
        self.slope[rows] = np.sqrt(self.elements.stiffness[rows])
        self.slow[rows], self.slipped[i] = False, kind == SLIPS
        if self.damping[i] > 0.0 and kind == CLOSES:
            self.z[i], self.largest[i] = self.slope[i] * gap, 0.0
        elif self.damping[i] > 0.0 and kind == OPENS:
            self.gap[i] = gap
        return kind
