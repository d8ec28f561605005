"""A landing on contacts and springs of finite stiffness: forces, accelerations and their times, in closed form.

The geometry is frozen, and gravity, motor torques and the springs' loads at touchdown, which balance one another before it, are
left out: during a contact of milliseconds they change little. What
remains is a linear system, excited by the velocity before impact,

    M ẍ + Σ_i B_iᵀ κ_i (B_i x − a_i) = 0,    x(0) = 0,    ẋ(0) = q̇⁻

Each *element* i is a spring of stiffness κ along one row B_i (a row of a contact, or the deflection of a spring in a joint) that
is without force at B_i x = a_i. With M = LLᵀ, u = Lᵀẋ and z_i = √κ_i (B_i x − a_i) the motion is a rotation, which keeps
½|u|² + ½|z|²:

    ż = F u,    u̇ = −Fᵀ z,    F = diag(√κ) B L⁻ᵀ = U diag(σ) Vᵀ

The singular values σ are the natural frequencies, and (Uᵀz, Vᵀu) rotate by the angles σt. Velocities that no spring resists are
orthogonal to V and stay as they are; u is the part along the rows of all elements. F Fᵀ is the Delassus matrix of step 1, scaled by
the stiffness.

Restitution is hysteresis (Walton and Braun 1986, J. Rheol. 30:949): an element is loaded with the stiffness k and, after its
largest force, unloaded with k / e², which returns the share e² of its energy. A single row then returns −e times its velocity,
exactly and for every mass, and its largest force does not depend on e. A viscous damper instead starts with a step of the force,
does not reach e = 0, and gives each effective mass another e: it counts as the e that it gives the mode that carries its element
(`damper_restitution`). With e = 0 a row is held at rest until its force has fallen to zero
(with a small e > 0, a contact on which the robot presses hops instead, and is loaded anew); where all rows have e = 0, the final
velocity is the one of Eq. 4 for every stiffness, unless a row is released while another one is loaded. Rows are separate elements:
tangents with e < 1 or of two stiffnesses make the result depend on their axes.

A contact opens where its normal force falls to zero; its tangential springs lose their energy. Where the normal is held, the
contact *slips* first: without tangential forces it may press on the ground again, and then stays closed without friction. A contact
closes where it opened, with all springs at rest.
Between these events the solution is exact; they are found in order (`crossing`).
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.crossing import MOST_SAMPLES, Signals, first_crossing, rate_of_change
from shockpc.core.spatial import Array

OPEN, LOADING, UNLOADING = range(3)

UNLOADS, RELOADS, REVERSES, SLIPS, OPENS, CLOSES = range(6)

EVENTS = "unloads", "reloads", "reverses", "slips", "opens", "closes"
"""What can happen to an element; a normal that unloads is at the end of its compression."""

WATCHED = np.array([0, 1, 1, 1, 1, 2])
"""What tells of each: the rate (0), the force (1) or the gap (2) of an element."""

NEGLIGIBLE = 1e-11
"""Share of the motion that excites the elements, below which what moves or presses counts as rounding."""

SMALLEST_PIVOT = 1e-7
"""Smallest diagonal entry of the Cholesky factor of M, scaled to a unit diagonal, with which M counts as positive definite."""

DEPENDENT = 1e-13
"""Share of the lengths of its rows below which the frequency of a mode is rounding: the rows are dependent, its forces constant."""

NEAR_MAXIMUM, MOST_MAXIMA = 0.95, 16
"""Share of the largest squared sample from which a local maximum is refined; the largest number of these in a segment."""

MOST_EVENTS = 2000
"""Bound of the number of events of a motion."""


class Elements(NamedTuple):
    """The springs of a landing, one for each of r rows.

    Attributes:
        rows: (r, n) velocity along each element for unit velocities of the n coordinates [m, 1].
        stiffness: (r,) k [N/m, N m/rad].
        restitution: (r,) e from 0 to 1; 1 for a spring without loss.
        contact: (r,) number of the contact that a row belongs to, −1 for a spring between bodies.
        normal: (r,) whether a row is the normal of its contact, along which the ground pushes. Each contact has one.
        damping: (r,) c of a viscous damper beside the spring, which replaces e [N s/m, N m s/rad]; zero for none.
    """

    rows: Array
    stiffness: Array
    restitution: Array
    contact: np.ndarray
    normal: np.ndarray
    damping: Array | float = 0.0


class Event(NamedTuple):
    """What happens to an element at a time [s], one of `EVENTS`; to a contact, at its normal."""

    time: float
    element: int
    kind: str


class Modes(NamedTuple):
    """The m modes of the elements that are loaded first.

    Attributes:
        frequency: (m,) natural frequencies [Hz], descending.
        energy: (m,) kinetic energy before impact in each mode [J]. Its sum is the energy that the elements can take up.
        participation: (r, m) share of the elastic energy of each mode that is in each element [1].
        force: (r, m) amplitude of the force of each element in each mode [N, N m].
    """

    frequency: Array
    energy: Array
    participation: Array
    force: Array


class History(NamedTuple):
    """The motion at T times.

    Attributes:
        force: (T, r) force of each element on the robot along its row [N, N m]; positive along a normal where the ground pushes.
        displacement: (T, n) x [rad, m].
        jump: (T, n) change of velocity ẋ(t) − q̇⁻ [rad/s, m/s].
        acceleration: (T, n) ẍ [rad/s², m/s²].
    """

    force: Array
    displacement: Array
    jump: Array
    acceleration: Array


class Segment(NamedTuple):
    """The motion between two events, with m modes of the p elements that are springs at that time.

    Attributes:
        start: time of the first event [s].
        length: time until the second [s].
        sigma: (m,) natural frequencies [rad/s].
        U: (p, m) modes in z.
        V: (d, m) modes in u.
        zeta: (m,) Uᵀz at the start.
        upsilon: (m,) Vᵀu at the start.
        rest: (p,) part of z that stays constant.
        drift: (d,) part of u that stays constant.
        F: (p, d) with u̇ = −Fᵀz.
        forces: (r, p) with the forces of all elements = forces · z.
        jump: (d,) u(start) − u(0).
        displacement: (d,) ∫u dt until the start.
    """

    start: float
    length: float
    sigma: Array
    U: Array
    V: Array
    zeta: Array
    upsilon: Array
    rest: Array
    drift: Array
    F: Array
    forces: Array
    jump: Array
    displacement: Array

    def deflection_after(self, t: Array) -> Array:
        """The scaled deflections z (..., p) at times t (...) after the start."""
        angle = t[..., None] * self.sigma
        return np.asarray(self.rest + (np.cos(angle) * self.zeta + np.sin(angle) * self.upsilon) @ self.U.T)

    def jump_after(self, t: Array) -> Array:
        """The change of u (..., d) since impact at times t (...) after the start."""
        angle = t[..., None] * self.sigma
        return np.asarray(self.jump - (np.sin(angle) * self.zeta + 2.0 * np.sin(angle / 2.0) ** 2 * self.upsilon) @ self.V.T)

    def displacement_after(self, t: Array) -> Array:
        """∫u dt (..., d) at times t (...) after the start."""
        t = t[..., None]
        half = t * self.sigma / 2.0
        modal = t * np.sinc(half / np.pi) * (np.cos(half) * self.upsilon - np.sin(half) * self.zeta)
        return np.asarray(self.displacement + t * self.drift + modal @ self.V.T)


class Motion(NamedTuple):
    """A landing, solved.

    Attributes:
        elements: the springs that it was computed for, dampers as restitution.
        segments: in order; the motion ends with the last.
        events: in order.
        separated: whether all contacts are open at the end.
        to_velocity: (n, d) from u to ẋ.
        constant: (n,) part of ẋ that no element resists [rad/s, m/s].
    """

    elements: Elements
    segments: tuple[Segment, ...]
    events: tuple[Event, ...]
    separated: bool
    to_velocity: Array
    constant: Array

    @property
    def duration(self) -> float:
        """Time from impact to the end [s]."""
        return self.segments[-1].start + self.segments[-1].length

    def first(self, kind: str) -> Array:
        """The time (r,) of the first event of a kind at each element [s]; infinite where there is none."""
        times = {event.element: event.time for event in reversed(self.events) if event.kind == kind}
        return np.array([times.get(i, np.inf) for i in range(len(self.elements.rows))])

    @property
    def modes(self) -> Modes:
        """The modes of the elements that are loaded first."""
        first = self.segments[0]
        participation = np.zeros((len(self.elements.rows), len(first.sigma)))
        participation[np.any(first.forces != 0.0, axis=1)] = first.U**2
        return Modes(first.sigma / (2.0 * np.pi), first.upsilon**2 / 2.0, participation, _amplitudes(first))

    def at(self, times: Array) -> History:
        """The motion at times (T,) from 0 to the duration [s]; at an event, just before it."""
        times = np.asarray(times, dtype=float)
        ends = np.array([segment.start + segment.length for segment in self.segments])
        which = np.minimum(np.searchsorted(ends, times), len(ends) - 1)
        (r, d), T = (len(self.elements.rows), self.to_velocity.shape[1]), len(times)
        force, displacement, jump, acceleration = (np.empty((T, columns)) for columns in (r, d, d, d))
        for k in np.unique(which):
            now, segment = which == k, self.segments[k]
            t = times[now] - segment.start
            z = segment.deflection_after(t)
            force[now], acceleration[now] = z @ segment.forces.T, -z @ segment.F
            displacement[now], jump[now] = segment.displacement_after(t), segment.jump_after(t)
        displacement, jump, acceleration = (values @ self.to_velocity.T for values in (displacement, jump, acceleration))
        return History(force, displacement + np.outer(times, self.constant), jump, acceleration)

    def peak(self, outputs: Array, forces: Array | None = None) -> tuple[Array, Array]:
        """The largest lengths of vectors that are linear in accelerations and forces, G ẍ + P f, and when they are reached.

        Args:
            outputs: (m, k, n) G; for the acceleration of a point its Jacobian.
            forces: (m, k, r) P, zero by default.

        Returns: (m,) lengths, NaN where G is, and (m,) times [s]. Each oscillation is sampled thirty times, and the largest local
            maxima of the samples are refined to rounding.

        Raises:
            ArithmeticError: the frequencies lie too far apart to sample the motion.
        """
        G = outputs @ self.to_velocity
        largest, when = np.where(np.isnan(G).any(axis=(1, 2)), np.nan, -1.0), np.zeros(len(G))
        for segment in self.segments:
            output = -G @ segment.F.T + (0.0 if forces is None else forces @ segment.forces)
            constant, modal = output @ segment.rest, output @ segment.U
            waves = np.concatenate([modal * segment.zeta, modal * segment.upsilon], axis=2)
            amplitude = np.abs(modal) * (np.abs(segment.zeta) + np.abs(segment.upsilon))
            own = np.flatnonzero(_lengths(np.abs(constant) + amplitude.sum(axis=2)) > largest)
            if not len(own):
                continue
            constant, waves, amplitude = constant[own], waves[own], amplitude[own]
            rate = float(rate_of_change(segment.sigma, amplitude, np.abs(constant)).max())
            t = _samples(segment.length, 0.2 / max(rate, 1e-300))
            angle = t[:, None] * segment.sigma
            value = np.concatenate([np.cos(angle), np.sin(angle)], axis=1) @ waves.reshape(constant.size, -1).T + constant.ravel()
            square = np.einsum("tik,tik->ti", *[value.reshape(len(t), *constant.shape)] * 2)
            # A sample at the end of a segment may exceed those of the next, whose maximum lies between its samples: refine each.
            local = square >= NEAR_MAXIMUM * np.maximum(square.max(axis=0), largest[own] * np.abs(largest[own]))
            local[1:] &= square[1:] > square[:-1]
            local[:-1] &= square[:-1] >= square[1:]
            rank, mine = np.nonzero(local)
            if len(rank) > MOST_MAXIMA * len(own):
                highest = np.sort(np.where(local, square, -1.0), axis=0)[-MOST_MAXIMA:][0]
                rank, mine = np.nonzero(local & (square >= highest))
            low, high = np.maximum(t[rank] - t[1], 0.0), np.minimum(t[rank] + t[1], segment.length)
            length, at = _refined(segment.sigma, constant[mine], waves[mine], t[rank], low, high)
            for i, value_there, time in zip(own[mine].tolist(), length.tolist(), (segment.start + at).tolist(), strict=True):
                if value_there > largest[i]:
                    largest[i], when[i] = value_there, time
        return largest, when


def attach_rotors(M: Array, rows: Array, velocity: Array, joints: Array, inertia: Array) -> tuple[Array, Array, Array, Array]:
    """Add rotors that springs connect to their joints; each is one more coordinate.

    Args:
        M: (n, n) inertia without these rotors [kg, kg m, kg m²].
        rows: (r, n) rows of contacts and other springs.
        velocity: (n,) before impact. Rotors move with their joints.
        joints: (s, n) rates of the joints for unit velocities of the coordinates.
        inertia: (s,) reflected inertia of each rotor, its inertia times the squared ratio [kg m², kg].

    Returns: M (n + s, n + s), the rows (r, n + s), rows (s, n + s) of the springs, joint less rotor, and the velocity (n + s,).
    """
    n, s = len(M), len(joints)
    full = np.zeros((n + s, n + s))
    full[:n, :n], full[n:, n:] = M, np.diag(inertia)
    return full, np.pad(rows, ((0, 0), (0, s))), np.hstack([joints, -np.eye(s)]), np.append(velocity, joints @ velocity)


def damper_restitution(ratio: Array) -> Array:
    """The restitution of a mass on a spring and a viscous damper, until their force falls to zero: they do not pull.

    e = exp(−2ζ acos ζ / √(1 − ζ²)), beyond ζ = 1 with acosh ζ and √(ζ² − 1) (Schwager and Pöschel 2007, Granular Matter 9:465).
    Args: ratio ζ = c / (2 √(k m)) of the damping to the critical one.
    """
    size = np.abs(np.sqrt((1.0 - ratio) * (1.0 + ratio) + 0.0j))
    angle = np.abs(np.arccos(ratio + 0.0j))
    return np.asarray(np.exp(-2.0 * ratio * np.where(size > 0.0, angle / np.where(size > 0.0, size, 1.0), 1.0)))


def simulate_landing(M: Array, elements: Elements, velocity: Array, until: float | None = None) -> Motion:
    """Solve a landing with frozen geometry on elements of finite stiffness.

    Args:
        M: (n, n) inertia of the coordinates [kg, kg m, kg m²].
        elements: springs of the contacts and between bodies.
        velocity: (n,) q̇⁻ [rad/s, m/s].
        until: time at which the motion ends [s]; by default, when all contacts are open. Until a later time, springs between bodies
            oscillate and contacts may close again.

    Raises:
        ValueError: an argument is not finite, a stiffness is not above zero, a restitution is outside 0 to 1, a contact has not
            exactly one normal, or no contact approaches the ground.
        ArithmeticError: M is not positive definite in double precision, the frequencies lie too far apart to find the events, or
            there are too many of them.
    """
    _check(M, elements, velocity, until)
    factors = _factors(M)
    state = _State(elements, *factors, velocity)
    if state.separated:
        raise ValueError("no contact approaches the ground")
    if np.any(elements.damping):
        elements = elements._replace(restitution=state.damped())
        state = _State(elements, *factors, velocity)
    segments: list[Segment] = []
    events: list[Event] = []
    time, simultaneous = 0.0, 0
    while not (until is None and state.separated):
        segment, hit = state.step(time, np.inf if until is None else until - time)
        simultaneous += 1
        if segment is not None:
            segments.append(segment)
            time, simultaneous = time + segment.length, 0
        if hit is None:
            break
        if len(events) == MOST_EVENTS or simultaneous > 4 * len(elements.rows):
            remedies = (
                ["take springs of joints that are stiffer than the contacts as rigid"] if np.any(elements.contact < 0) else []
            )
            remedies += ["take a softer contact or a larger restitution"]
            remedies += ["end the motion earlier"] if until is not None else []
            text = f"elements change {len(events)} times in {time:.3g} s, too often to follow them; "
            raise ArithmeticError(text + ", or ".join(remedies))
        events.append(Event(time, hit[0], EVENTS[state.switch(*hit)]))
    return Motion(elements, tuple(segments), tuple(events), state.separated, state.to_velocity, state.constant)


def _check(M: Array, elements: Elements, velocity: Array, until: float | None) -> None:
    """Raise ValueError for arguments that have no meaning."""
    if not all(np.isfinite(values).all() for values in (M, velocity, *elements)):
        raise ValueError("inertia, velocity and elements must be finite")
    if not np.all(elements.stiffness > 0.0):
        raise ValueError(f"each stiffness must be above zero, not {elements.stiffness.min():g}")
    if not np.all(np.asarray(elements.damping) >= 0.0):
        raise ValueError(f"each damping must be zero or above, not {np.min(elements.damping):g}")
    if not np.all((elements.restitution >= 0.0) & (elements.restitution <= 1.0)):
        raise ValueError(f"each restitution must lie in [0, 1], not {elements.restitution.tolist()}")
    if sorted(elements.contact[elements.normal].tolist()) != sorted({*elements.contact.tolist()} - {-1}):
        raise ValueError("each contact needs exactly one row that is its normal")
    if until is not None and not 0.0 < until < np.inf:
        raise ValueError(f"the end of the motion must be finite and above 0 s, not {until:g} s")


def _factors(M: Array) -> tuple[Array, Array]:
    """Lᵀ and L⁻ᵀ for M = LLᵀ, from M scaled to a unit diagonal."""
    diagonal = np.diagonal(M)
    if np.all(diagonal > 0.0):
        size = np.sqrt(diagonal)
        try:
            L = np.linalg.cholesky(M / size / size[:, None])
        except np.linalg.LinAlgError:
            L = np.zeros_like(M)
        if np.diagonal(L).min() > SMALLEST_PIVOT:
            return np.asarray(L.T * size), np.asarray(np.linalg.inv(L).T / size[:, None])
    raise ArithmeticError("the inertia is not positive definite in double precision; give moving bodies mass, or lock their joints")


class _State:
    """The state of elements and motion at an event, in the d coordinates of u along the rows of the elements.

    Attributes:
        W: (r, d) velocity along each element for unit u.
        to_velocity, constant: as in `Motion`.
        mode: (r,) OPEN, LOADING or UNLOADING.
        slope: (r,) √κ.
        z: (r,) √κ (B x − a), zero where an element is open.
        peak: (r,) z at the start of unloading.
        gap: (r,) B x since the contact opened [m].
        u, jump: (d,) at the impact, and the change since then.
        displacement: (d,) ∫u dt.
        noise: size of z and u that counts as rounding.
        fastest: largest natural frequency of a single element [rad/s].
    """

    def __init__(self, elements: Elements, factor: Array, inverse: Array, velocity: Array):
        Q, R = np.linalg.qr((elements.rows @ inverse).T)
        self.elements, self.W, self.to_velocity, self.u = elements, R.T, inverse @ Q, Q.T @ (factor @ velocity)
        self.constant = velocity - self.to_velocity @ self.u
        self.normal, self.rigid = elements.normal.tolist(), elements.restitution == 0.0
        self.lossy = elements.normal | (elements.restitution < 1.0)
        self.length = _lengths(self.W)
        self.slope = np.sqrt(elements.stiffness)
        self.z, self.peak, self.gap = np.zeros((3, len(self.W)))
        self.jump, self.displacement = np.zeros((2, len(self.u)))
        speed = float(np.linalg.norm(self.u))
        self.noise = NEGLIGIBLE * speed
        self.fastest = float((self.slope * self.length).max())
        closing = elements.contact[elements.normal & (self.W @ self.u < -1e-13 * self.length * speed)]
        self.mode = np.where((elements.contact < 0) | np.any(elements.contact == closing[:, None], axis=0), LOADING, OPEN)

    @property
    def separated(self) -> bool:
        """Whether all contacts are open."""
        return not (self.mode[self.elements.contact >= 0] != OPEN).any()

    def damped(self) -> Array:
        """The restitution (r,) with the dampers: for the mode with the largest force of an element, or for an open one alone."""
        elements = self.elements
        segment, _ = self.step(0.0, np.inf)
        assert segment is not None
        force = _amplitudes(segment)
        own = np.where(force.any(axis=1), segment.sigma[force.argmax(axis=1)], self.slope * self.length)
        e = damper_restitution(elements.damping * own / (2.0 * elements.stiffness))
        return np.where(np.asarray(elements.damping) > 0.0, e, elements.restitution)

    def step(self, time: float, horizon: float) -> tuple[Segment | None, tuple[int, int] | None]:
        """Go to the next event, at most by a horizon [s]; the segment until then, if any, and the element and what happens to it.

        Watched are the rate of what is loaded, the force of what is unloaded and the gap of open contacts: an element changes when
        its number falls below −tolerance.
        """
        rigid = (self.mode == UNLOADING) & self.rigid
        held, sprung = rigid.nonzero()[0], ((self.mode != OPEN) & ~rigid).nonzero()[0]
        F = self.slope[sprung, None] * self.W[sprung]
        # The scaled forces of all elements are to_all · z.
        to_all = np.zeros((len(self.W), len(sprung)))
        to_all[sprung, np.arange(len(sprung))] = 1.0
        if len(held):
            F, to_all[held] = self._hold(F, held)
        element, kind, either, tolerance, offset, sign = (np.array(column) for column in zip(*self._watched(), strict=True))
        row = element + len(self.W) * WATCHED[kind]
        u, z = self.u + self.jump, self.z[sprung]
        start = offset + tolerance + sign * np.concatenate([self.W @ u, to_all @ z, self.gap])[row]
        start[either] = np.inf
        if start.min() < 0.0:
            hit = int(start.argmin())
            return None, (int(element[hit]), int(kind[hit]))
        U, sigma, V = _graded_svd(F)
        sigma[sigma < DEPENDENT * (_lengths(F) @ np.abs(U))] = 0.0
        zeta, upsilon = U.T @ z, V.T @ u
        rest, drift = z - U @ zeta, u - V @ upsilon
        of_z, of_u, still, along = to_all @ U, self.W @ V, sigma == 0.0, self.W @ drift
        path, none = np.where(still, 0.0, of_u / np.where(still, 1.0, sigma)), np.zeros(2 * len(along))
        constant = np.concatenate([along, to_all @ rest, self.gap - path @ zeta])
        linear = np.concatenate([none, along + (of_u * still) @ upsilon])
        cosine = np.concatenate([of_u * upsilon, of_z * zeta, path * zeta])
        sine = np.concatenate([-of_u * zeta, of_z * upsilon, path * upsilon])
        turned = (sign[:, None] * waves[row] for waves in (cosine, sine))
        signals = Signals(either, tolerance, offset + sign * constant[row], sign * linear[row], *turned)
        length, first = first_crossing(sigma, signals, horizon)
        forces = -self.slope[:, None] * to_all
        segment = Segment(time, length, sigma, U, V, zeta, upsilon, rest, drift, F, forces, self.jump, self.displacement)
        end = np.asarray(length)
        displacement = segment.displacement_after(end)
        self.gap = self.gap + self.W @ (displacement - self.displacement)
        self.jump, self.displacement = segment.jump_after(end), displacement
        self.z = to_all @ segment.deflection_after(end)
        return segment, None if first is None else (int(element[first]), int(kind[first]))

    def _watched(self) -> Iterator[tuple[int, int, bool, float, float, float]]:
        """What can change: element, event, whether its number counts with the sign that it has first, tolerance, constant, sign."""
        # Numbers of Python, because those of NumPy take ten times as long one by one.
        deflection, peak, rigid, noise = self.z.tolist(), self.peak.tolist(), self.rigid.tolist(), self.noise
        for i, (mode, normal, length) in enumerate(zip(self.mode.tolist(), self.normal, self.length.tolist(), strict=True)):
            if mode == LOADING and self.lossy[i]:
                # A contact is loaded against its normal; an element without force, in the direction in which it moves first.
                either = not normal and deflection[i] == 0.0
                yield i, UNLOADS, either, noise * length, 0.0, -1.0 if normal or deflection[i] < 0.0 else 1.0
            elif mode == UNLOADING:
                loaded = -1.0 if normal or peak[i] < 0.0 else 1.0
                # What is held by no force is released.
                yield i, OPENS if normal else REVERSES, False, -noise if rigid[i] else noise, 0.0, loaded
                yield i, RELOADS, False, noise, abs(peak[i]), -loaded
            elif mode == OPEN and normal:
                yield i, CLOSES, False, noise * length / self.fastest, 0.0, 1.0

    def _hold(self, F: Array, held: np.ndarray) -> tuple[Array, Array]:
        """Keep rows at rest: F without their directions, and what takes the place of their z (h, p), over z.

        From H u̇ = 0 with u̇ = −Fᵀz − Hᵀm follows m = −(H Hᵀ)⁻¹ H Fᵀ z; of dependent rows each takes the least share.
        """
        if not len(F):
            return F, np.zeros((len(held), 0))
        Q, s, Pt = np.linalg.svd((self.W[held] / self.length[held, None]).T, full_matrices=False)
        independent = s > 1e-9 * s[0]
        Q, P = Q[:, independent], Pt[independent].T / s[independent]
        self.jump = self.jump - Q @ (Q.T @ (self.u + self.jump))
        along = F @ Q
        return F - along @ Q.T, -(P @ along.T) / (self.slope[held] * self.length[held])[:, None]

    def switch(self, i: int, kind: int) -> int:
        """Let an event happen to element i; what it is in full."""
        e = 1.0 if self.rigid[i] else float(self.elements.restitution[i])
        rows = self.elements.contact == self.elements.contact[i]
        if kind == UNLOADS:
            self.mode[i], self.slope[i], self.z[i] = UNLOADING, self.slope[i] / e, self.z[i] * e
            self.peak[i] = self.z[i]
            return kind
        if kind in (RELOADS, REVERSES):
            self.mode[i], self.slope[i] = LOADING, self.slope[i] * e
            self.z[i] = self.z[i] / e if kind == RELOADS else 0.0
            return kind
        if kind == OPENS and self.rigid[i] and np.any(self.mode[rows & ~self.elements.normal] != OPEN):
            rows, kind = rows & ~self.elements.normal, SLIPS
        self.mode[rows], self.z[rows], self.gap[rows] = LOADING if kind == CLOSES else OPEN, 0.0, 0.0
        self.slope[rows] = np.sqrt(self.elements.stiffness[rows])
        return kind


def _lengths(vectors: Array) -> Array:
    """The lengths (m,) of vectors (m, k)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1)))


def _amplitudes(segment: Segment) -> Array:
    """The amplitude (r, m) of the force of each element in each mode of a segment [N, N m]."""
    return np.abs((segment.forces @ segment.U) * np.hypot(segment.zeta, segment.upsilon))


def _graded_svd(F: Array) -> tuple[Array, Array, Array]:
    """F = U diag(σ) Vᵀ for a matrix whose rows differ by orders of magnitude.

    The rows are sorted by length and reduced by a QR factorisation first. Each singular value then keeps its own digits, instead of
    those of the largest (Drmač and Veselić 2008, SIAM J. Matrix Anal. Appl. 29:1322).
    """
    length = _lengths(F)
    if length.max(initial=0.0) <= 1e3 * length.min(initial=np.inf):
        U, sigma, Vt = np.linalg.svd(F, full_matrices=False)
        return U, sigma, Vt.T
    order = np.argsort(-length)
    Q, R = np.linalg.qr(F[order].T)
    A, sigma, Bt = np.linalg.svd(R, full_matrices=False)
    return Bt.T[np.argsort(order)], sigma, Q @ A


def _refined(sigma: Array, constant: Array, waves: Array, t: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """The largest length (m,) of vectors near times t (m,), and its time, between bounds.

    The vectors are constant (m, k) + waves (m, k, 2j) · (cos σt, sin σt). Newton's method on half the derivative of the squared
    length.
    """
    length, best = np.full(len(t), -1.0), t
    twice = np.concatenate([sigma, sigma])
    for _ in range(8):
        angle = t[:, None] * sigma
        cos, sin = np.cos(angle), np.sin(angle)
        there, ahead = np.concatenate([cos, sin], axis=1)[..., None], np.concatenate([-sin, cos], axis=1)[..., None]
        wave, value = waves @ (twice[:, None] ** 2 * there), constant + (waves @ there)[..., 0]
        rate, curve = (waves @ (twice[:, None] * ahead))[..., 0], -wave[..., 0]
        found = _lengths(value)
        length, best = np.where(found > length, found, length), np.where(found > length, t, best)
        slope, bend = (value * rate).sum(axis=1), (rate * rate + value * curve).sum(axis=1)
        # Where the square is not concave, go to the bound that lies uphill.
        last, step = t, np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.sign(slope) * (high - low))
        t = np.clip(t + step, low, high)
        if np.all(np.abs(t - last) <= 1e-9 * (high - low)):
            break
    return length, best


def _samples(length: float, step: float) -> Array:
    """Times from 0 to a length, at most a step apart."""
    if length > step * MOST_SAMPLES:
        raise ArithmeticError(
            f"the fastest mode oscillates more than {MOST_SAMPLES // 30} times in {length:.3g} s; take the stiffest as rigid"
        )
    count = int(length / step) + 1
    return np.asarray(np.arange(count + 1.0) * (length / count))
