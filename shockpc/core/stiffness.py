"""A landing on contacts and springs of finite stiffness: forces, accelerations and their times, in closed form.

The geometry is frozen, and gravity and motor torques are left out: during a contact of milliseconds they change little. What
remains is a linear system, excited by the velocity before impact,

    M ẍ + Σ_i B_iᵀ κ_i (B_i x − a_i) = 0,    x(0) = 0,    ẋ(0) = q̇⁻

Each *element* i is a spring of stiffness κ along one row B_i (a row of a contact, or the deflection of a spring in a joint) that
is without force at B_i x = a_i. With M = LLᵀ, u = Lᵀẋ and z_i = √κ_i (B_i x − a_i) the motion is a rotation, which keeps
½|u|² + ½|z|²:

    ż = F u,    u̇ = −Fᵀ z,    F = diag(√κ) B L⁻ᵀ = U diag(σ) Vᵀ

The singular values σ are the natural frequencies, and (Uᵀz, Vᵀu) rotate by the angles σt. Velocities that no spring resists are
orthogonal to V and stay as they are. F Fᵀ is the Delassus matrix of step 1, scaled by the stiffness.

Restitution is hysteresis (Walton and Braun 1986, J. Rheol. 30:949): an element is loaded with the stiffness k and, after its
largest force, unloaded with k / e², which returns the share e² of its energy. A single row then returns −e times its velocity,
exactly and for every mass, and its largest force does not depend on e. A viscous damper instead starts with a step of the force,
does not reach e = 0, and gives each effective mass another e. With e = 0 a row is held at rest until its force has fallen to zero
(with a small e > 0, a contact on which the robot presses hops instead, and is loaded anew); where all rows have e = 0, the final
velocity is the one of Eq. 4 for every stiffness, unless a row is released while another one is loaded. Rows are separate elements:
tangents with e < 1 or of two stiffnesses make the result depend on their axes.

A contact opens where its normal force falls to zero; its tangential springs lose their energy. Where the normal is held, the
contact *slips* first: without tangential forces it may press on the ground again, and then stays closed without friction. A contact
closes where it opened, with all springs at rest.
Between these events the solution is exact; they are found in order (`crossing`).
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.crossing import MOST_SAMPLES, Signals, first_crossing, rate_of_change
from shockpc.core.spatial import Array

OPEN, LOADING, UNLOADING = range(3)

UNLOADS, RELOADS, REVERSES, SLIPS, OPENS, CLOSES = range(6)

EVENTS = "unloads", "reloads", "reverses", "slips", "opens", "closes"
"""What can happen to an element; a normal that unloads is at the end of its compression."""

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
    """

    rows: Array
    stiffness: Array
    restitution: Array
    contact: np.ndarray
    normal: np.ndarray


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
    """

    frequency: Array
    energy: Array
    participation: Array


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
        V: (n, m) modes in u.
        zeta: (m,) Uᵀz at the start.
        upsilon: (m,) Vᵀu at the start.
        rest: (p,) part of z that stays constant.
        drift: (n,) part of u that stays constant.
        F: (p, n) with u̇ = −Fᵀz.
        forces: (r, p) with the forces of all elements = forces · z.
        jump: (n,) u(start) − u(0).
        displacement: (n,) Lᵀx(start).
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
        """The change of u (..., n) since impact at times t (...) after the start."""
        angle = t[..., None] * self.sigma
        return np.asarray(self.jump - (np.sin(angle) * self.zeta + 2.0 * np.sin(angle / 2.0) ** 2 * self.upsilon) @ self.V.T)

    def displacement_after(self, t: Array) -> Array:
        """Lᵀx (..., n) at times t (...) after the start."""
        t = t[..., None]
        half = t * self.sigma / 2.0
        modal = t * (np.sinc(2.0 / np.pi * half) * self.upsilon - np.sin(half) * np.sinc(half / np.pi) * self.zeta)
        return np.asarray(self.displacement + t * self.drift + modal @ self.V.T)


class Motion(NamedTuple):
    """A landing, solved.

    Attributes:
        elements: the springs that it was computed for.
        segments: in order; the motion ends with the last.
        events: in order.
        separated: whether all contacts are open at the end.
        to_velocity: (n, n) L⁻ᵀ, from u to ẋ.
    """

    elements: Elements
    segments: tuple[Segment, ...]
    events: tuple[Event, ...]
    separated: bool
    to_velocity: Array

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
        return Modes(first.sigma / (2.0 * np.pi), first.upsilon**2 / 2.0, participation)

    def at(self, times: Array) -> History:
        """The motion at times (T,) from 0 to the duration [s]; at an event, just before it."""
        times = np.asarray(times, dtype=float)
        ends = np.array([segment.start + segment.length for segment in self.segments])
        which = np.minimum(np.searchsorted(ends, times), len(ends) - 1)
        (r, n), T = self.elements.rows.shape, len(times)
        force, displacement, jump, acceleration = (np.empty((T, columns)) for columns in (r, n, n, n))
        for k in np.unique(which):
            now, segment = which == k, self.segments[k]
            t = times[now] - segment.start
            z = segment.deflection_after(t)
            force[now], acceleration[now] = z @ segment.forces.T, -z @ segment.F
            displacement[now], jump[now] = segment.displacement_after(t), segment.jump_after(t)
        return History(force, *(values @ self.to_velocity.T for values in (displacement, jump, acceleration)))

    def peak(self, outputs: Array, forces: Array | None = None) -> tuple[Array, Array]:
        """The largest lengths of vectors that are linear in accelerations and forces, G ẍ + P f, and when they are reached.

        Args:
            outputs: (m, k, n) G; for the acceleration of a point its Jacobian.
            forces: (m, k, r) P, zero by default.

        Returns: (m,) lengths and (m,) times [s]. Each oscillation is sampled thirty times, and the largest local maxima of the
            samples are refined to rounding.

        Raises:
            ArithmeticError: the frequencies lie too far apart to sample the motion.
        """
        m, k, n = outputs.shape
        G = outputs.reshape(m * k, n) @ self.to_velocity
        P = np.zeros((m * k, len(self.elements.rows))) if forces is None else forces.reshape(m * k, -1)
        largest, when = np.full(m, -1.0), np.zeros(m)
        for segment in self.segments:
            output = P @ segment.forces - G @ segment.F.T
            constant, modal = (output @ segment.rest).reshape(m, k), (output @ segment.U).reshape(m, k, -1)
            cosine, sine = modal * segment.zeta, modal * segment.upsilon
            amplitude = np.abs(cosine) + np.abs(sine)
            rate = float(rate_of_change(segment.sigma, amplitude.reshape(m * k, -1), np.abs(constant).ravel()).max(initial=0.0))
            t = _samples(segment.length, 0.2 / max(rate, 1e-300))
            angle = np.outer(t, segment.sigma)
            waves = np.concatenate([cosine, sine], axis=2).reshape(m * k, -1)
            value = constant.ravel() + np.hstack([np.cos(angle), np.sin(angle)]) @ waves.T
            square = (value * value).reshape(len(t), m, k).sum(axis=2)
            # A sample at the end of a segment may exceed those of the next, whose maximum lies between its samples: refine each.
            border = np.full((1, m), -1.0)
            local = (square > np.concatenate([border, square[:-1]])) & (square >= np.concatenate([square[1:], border]))
            highest = np.argsort(np.where(local, -square, 1.0), axis=0)[:MOST_MAXIMA]
            height = np.take_along_axis(np.where(local, square, -1.0), highest, axis=0)
            rank, mine = np.nonzero(height >= NEAR_MAXIMUM * np.maximum(square.max(axis=0), largest * np.abs(largest)))
            start = t[highest[rank, mine]]
            low, high = np.maximum(start - t[1], 0.0), np.minimum(start + t[1], segment.length)
            length, at = _refined(segment.sigma, constant[mine], cosine[mine], sine[mine], start, low, high)
            refined, times = np.full((2, *height.shape), -1.0)
            refined[rank, mine], times[rank, mine] = length, segment.start + at
            best = refined.argmax(axis=0), np.arange(m)
            when = np.where(refined[best] > largest, times[best], when)
            largest = np.maximum(refined[best], largest)
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
    to_velocity = _inverse_factor(M)
    W = elements.rows @ to_velocity
    state = _State(elements, W, np.asarray(np.linalg.solve(to_velocity, velocity), dtype=float))
    if state.separated:
        raise ValueError("no contact approaches the ground")
    segments: list[Segment] = []
    events: list[Event] = []
    time, simultaneous = 0.0, 0
    while not (until is None and state.separated):
        watched = state.watch()
        hit, simultaneous = watched.fallen, simultaneous + 1
        if hit is None:
            segment, signals = state.segment(time, watched)
            length, hit = first_crossing(segment.sigma, signals, np.inf if until is None else until - time)
            segments.append(segment._replace(length=length))
            state.advance(segments[-1])
            time, simultaneous = time + length, 0
        if hit is None:
            break
        if len(events) == MOST_EVENTS or simultaneous > 4 * len(W):
            remedies = (
                ["take springs of joints that are stiffer than the contacts as rigid"] if np.any(elements.contact < 0) else []
            )
            remedies += ["take a softer contact or a larger restitution"]
            remedies += ["end the motion earlier"] if until is not None else []
            text = f"elements change {len(events)} times in {time:.3g} s, too often to follow them; "
            raise ArithmeticError(text + ", or ".join(remedies))
        element = int(watched.element[hit])
        events.append(Event(time, element, EVENTS[state.switch(element, int(watched.kind[hit]))]))
    return Motion(elements, tuple(segments), tuple(events), state.separated, to_velocity)


def _check(M: Array, elements: Elements, velocity: Array, until: float | None) -> None:
    """Raise ValueError for arguments that have no meaning."""
    if not all(np.isfinite(values).all() for values in (M, velocity, elements.rows, elements.stiffness)):
        raise ValueError("inertia, velocity, rows and stiffness must be finite")
    if not np.all(elements.stiffness > 0.0):
        raise ValueError(f"each stiffness must be above zero, not {elements.stiffness.min():g}")
    if not np.all((elements.restitution >= 0.0) & (elements.restitution <= 1.0)):
        raise ValueError(f"each restitution must lie in [0, 1], not {elements.restitution.tolist()}")
    if sorted(elements.contact[elements.normal]) != np.unique(elements.contact[elements.contact >= 0]).tolist():
        raise ValueError("each contact needs exactly one row that is its normal")
    if until is not None and not 0.0 < until < np.inf:
        raise ValueError(f"the end of the motion must be finite and above 0 s, not {until:g} s")


def _inverse_factor(M: Array) -> Array:
    """L⁻ᵀ for M = LLᵀ, from M scaled to a unit diagonal."""
    diagonal = np.diagonal(M)
    if np.all(diagonal > 0.0):
        size = np.sqrt(diagonal)
        try:
            L = np.linalg.cholesky(M / size / size[:, None])
        except np.linalg.LinAlgError:
            L = np.zeros_like(M)
        if np.diagonal(L).min() > SMALLEST_PIVOT:
            return np.asarray(np.linalg.inv(L).T / size[:, None])
    raise ArithmeticError("the inertia is not positive definite in double precision; give moving bodies mass, or lock their joints")


class _Watched(NamedTuple):
    """Springs and quantities that change an element when they fall below −tolerance: constant + of_z z + of_u u + of_path ∫u dt.

    Attributes:
        F: (p, n) of the p elements that are springs.
        z: (p,) their scaled deflections.
        to_all: (r, p) scaled forces of all elements, over z.
        element: (s,) element that changes.
        kind: (s,) how, as an index of `EVENTS`.
        either: (s,) whether the quantity may have either sign at first, and counts with that sign.
        tolerance, constant: (s,).
        of_z: (s, p).
        of_u, of_path: (s, n).
        fallen: which has fallen already, if any.
    """

    F: Array
    z: Array
    to_all: Array
    element: np.ndarray
    kind: np.ndarray
    either: np.ndarray
    tolerance: Array
    constant: Array
    of_z: Array
    of_u: Array
    of_path: Array
    fallen: int | None


class _State:
    """The state of elements and motion at an event.

    Attributes:
        mode: (r,) OPEN, LOADING or UNLOADING.
        slope: (r,) √κ.
        z: (r,) √κ (B x − a), zero where an element is open.
        peak: (r,) z at the start of unloading.
        gap: (r,) B x since the contact opened [m].
        jump: (n,) u − u(0).
        displacement: (n,) Lᵀx.
        noise: size of z and u that counts as rounding; zero before the first segment.
        fastest: largest natural frequency at first [rad/s].
    """

    def __init__(self, elements: Elements, W: Array, u: Array):
        self.elements, self.W, self.u = elements, W, u
        self.normal, self.rigid = elements.normal.tolist(), elements.restitution == 0.0
        self.lossy = elements.normal | (elements.restitution < 1.0)
        self.length = np.linalg.norm(W, axis=1)
        self.slope = np.sqrt(elements.stiffness)
        self.z, self.peak, self.gap = np.zeros((3, len(W)))
        self.jump, self.displacement = np.zeros((2, len(u)))
        closing = elements.contact[elements.normal & (W @ u < -1e-13 * self.length * np.linalg.norm(u))]
        self.mode = np.where((elements.contact < 0) | np.any(elements.contact == closing[:, None], axis=0), LOADING, OPEN)
        self.noise, self.fastest = 0.0, 0.0

    @property
    def separated(self) -> bool:
        """Whether all contacts are open."""
        return bool(np.all(self.mode[self.elements.contact >= 0] == OPEN))

    def watch(self) -> "_Watched":
        """What can change next: the rate of what is loaded, the force of what is unloaded and the gap of open contacts."""
        held = np.flatnonzero((self.mode == UNLOADING) & self.rigid)
        sprung = np.flatnonzero((self.mode == LOADING) | ((self.mode == UNLOADING) & ~self.rigid))
        F = self.slope[sprung, None] * self.W[sprung]
        to_all = np.zeros((len(self.W), len(sprung)))
        to_all[sprung, np.arange(len(sprung))] = 1.0
        if len(held):
            F, to_all[held] = self._hold(F, held)
        u, z, noise, watched = self.u + self.jump, self.z[sprung], self.noise, []
        # Numbers of Python, because those of NumPy take ten times as long one by one.
        deflection, peak, gap, rigid = self.z.tolist(), self.peak.tolist(), self.gap.tolist(), self.rigid.tolist()
        for i, (mode, normal, length) in enumerate(zip(self.mode.tolist(), self.normal, self.length.tolist(), strict=True)):
            if mode == LOADING and self.lossy[i]:
                # A contact is loaded against its normal; an element without force, in the direction in which it moves first.
                either = not normal and deflection[i] == 0.0
                watched.append((i, UNLOADS, either, noise * length, 0.0, -1.0 if normal or deflection[i] < 0.0 else 1.0))
            elif mode == UNLOADING:
                loaded = -1.0 if normal or peak[i] < 0.0 else 1.0
                # What is held by no force is released.
                watched.append((i, OPENS if normal else REVERSES, False, -noise if rigid[i] else noise, 0.0, loaded))
                watched.append((i, RELOADS, False, noise, abs(peak[i]), -loaded))
            elif mode == OPEN and normal:
                watched.append((i, CLOSES, False, noise * length / (self.fastest or 1.0), gap[i], 1.0))
        table = np.array(watched, dtype=float).reshape(-1, 6)
        element, kind, either = table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2] > 0.0
        tolerance, constant, sign, column = table[:, 3], table[:, 4], table[:, 5:], kind[:, None]
        along = sign * self.W[element]
        of_u, of_path = along * (column == UNLOADS), along * (column == CLOSES)
        of_z = sign * to_all[element] * ((column != UNLOADS) & (column != CLOSES))
        start = np.where(either, np.inf, constant + tolerance + of_z @ z + of_u @ u)
        fallen = int(start.argmin()) if start.min(initial=np.inf) < 0.0 else None
        return _Watched(F, z, to_all, element, kind, either, tolerance, constant, of_z, of_u, of_path, fallen)

    def segment(self, time: float, watched: "_Watched") -> tuple[Segment, Signals]:
        """The motion from here on, of length zero, and what is watched as signals."""
        F, z, u = watched.F, watched.z, self.u + self.jump
        U, sigma, V = _graded_svd(F)
        sigma[sigma < DEPENDENT * (np.linalg.norm(F, axis=1) @ np.abs(U))] = 0.0
        zeta, upsilon = U.T @ z, V.T @ u
        if not self.noise:
            self.noise, self.fastest = NEGLIGIBLE * float(np.linalg.norm(upsilon)), float(sigma[0])
        rest, drift, forces = z - U @ zeta, u - V @ upsilon, -self.slope[:, None] * watched.to_all
        segment = Segment(time, 0.0, sigma, U, V, zeta, upsilon, rest, drift, F, forces, self.jump, self.displacement)
        of_z, of_u, path, still = watched.of_z @ U, watched.of_u @ V, watched.of_path @ V, sigma == 0.0
        linear = watched.of_path @ drift + (path * still) @ upsilon
        path = np.where(still, 0.0, path / np.where(still, 1.0, sigma))
        constant = watched.constant + watched.of_z @ rest + watched.of_u @ drift - path @ zeta
        cosine, sine = of_z * zeta + of_u * upsilon + path * zeta, of_z * upsilon - of_u * zeta + path * upsilon
        return segment, Signals(watched.either, watched.tolerance, constant, linear, cosine, sine)

    def _hold(self, F: Array, held: np.ndarray) -> tuple[Array, Array]:
        """Keep rows at rest: F without their directions, and what takes the place of their z (h, p), over z.

        From H u̇ = 0 with u̇ = −Fᵀz − Hᵀm follows m = −(H Hᵀ)⁻¹ H Fᵀ z; of dependent rows each takes the least share.
        """
        Q, s, Pt = np.linalg.svd((self.W[held] / self.length[held, None]).T, full_matrices=False)
        independent = s > 1e-9 * s[0]
        Q, P = Q[:, independent], Pt[independent].T / s[independent]
        self.jump = self.jump - Q @ (Q.T @ (self.u + self.jump))
        along = F @ Q
        return F - along @ Q.T, -(P @ along.T) / (self.slope[held] * self.length[held])[:, None]

    def advance(self, segment: Segment) -> None:
        """Go to the end of a segment."""
        t = np.asarray(segment.length)
        displacement = segment.displacement_after(t)
        self.gap = self.gap + self.W @ (displacement - self.displacement)
        self.jump, self.displacement = segment.jump_after(t), displacement
        self.z = -(segment.forces @ segment.deflection_after(t)) / self.slope

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


def _graded_svd(F: Array) -> tuple[Array, Array, Array]:
    """F = U diag(σ) Vᵀ for a matrix whose rows differ by orders of magnitude.

    The rows are sorted by length and reduced by a QR factorisation first. Each singular value then keeps its own digits, instead of
    those of the largest (Drmač and Veselić 2008, SIAM J. Matrix Anal. Appl. 29:1322).
    """
    length = np.linalg.norm(F, axis=1)
    if length.max(initial=0.0) <= 1e3 * length.min(initial=np.inf):
        U, sigma, Vt = np.linalg.svd(F, full_matrices=False)
        return U, sigma, Vt.T
    order = np.argsort(-length)
    Q, R = np.linalg.qr(F[order].T)
    A, sigma, Bt = np.linalg.svd(R, full_matrices=False)
    return Bt.T[np.argsort(order)], sigma, Q @ A


def _refined(sigma: Array, constant: Array, cosine: Array, sine: Array, t: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """The largest length (m,) of vectors constant + Σ cosine cos σt + sine sin σt near times t (m,), and its time, between bounds.

    Newton's method on half the derivative of the squared length.
    """
    length, best = np.full(len(t), -1.0), t
    for _ in range(8):
        angle = (t[:, None] * sigma)[..., None]
        c, s = np.cos(angle), np.sin(angle)
        value, out_of_phase = constant + (cosine @ c + sine @ s)[..., 0], sigma * sine
        rate = (out_of_phase @ c - (sigma * cosine) @ s)[..., 0]
        curve = -((sigma**2 * cosine) @ c + (sigma**2 * sine) @ s)[..., 0]
        found = np.sqrt((value * value).sum(axis=1))
        length, best = np.where(found > length, found, length), np.where(found > length, t, best)
        slope, bend = (value * rate).sum(axis=1), (rate * rate + value * curve).sum(axis=1)
        # Where the square is not concave, go to the bound that lies uphill.
        t = np.clip(t + np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.sign(slope) * (high - low)), low, high)
    return length, best


def _samples(length: float, step: float) -> Array:
    """Times from 0 to a length, at most a step apart."""
    if length > step * MOST_SAMPLES:
        raise ArithmeticError(
            f"the fastest mode oscillates more than {MOST_SAMPLES // 30} times in {length:.3g} s; take the stiffest as rigid"
        )
    return np.linspace(0.0, length, int(length / step) + 2)
