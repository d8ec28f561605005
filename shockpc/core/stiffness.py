"""A landing on contacts and springs of finite stiffness: forces, accelerations and their times, in closed form.

The geometry is frozen. What remains is a linear system, excited by the velocity before impact and by constant forces,

    M ẍ + Σ_i B_iᵀ κ_i (B_i x − a_i) = M g + Σ_j B_jᵀ τ_j,    x(0) = 0,    ẋ(0) = q̇⁻

Each *element* i is a spring of stiffness κ along one row B_i (a row of a contact, or the deflection of a spring in a joint) that
is without force at B_i x = a_i; one without stiffness gives a constant force τ, as a motor. With g, the accelerations of free fall,
M = LLᵀ, u = Lᵀẋ and z_i = √κ_i (B_i x − a_i), that is

    ż = F u,    u̇ = −Fᵀ z + c,    c = Lᵀg + L⁻¹ Σ_j B_jᵀ τ_j,    F = diag(√κ) B L⁻ᵀ = U diag(σ) Vᵀ

The singular values σ are the natural frequencies. (Uᵀz − Vᵀc/σ, Vᵀu) rotate by the angles σt: forces oscillate about those that
balance c. Velocities that no spring resists, orthogonal to V, change at the rate of their part of c; u is the part along the
rows of all elements. F Fᵀ is the Delassus matrix of step 1, scaled by the stiffness.

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

Gravity brings a contact that has opened back to the ground, which is another impact, or it keeps a contact closed, which then
stands. So a landing lasts as long as it would without constant forces, until all contacts are open and stay so; and, where a
contact is compressed or rebounds then, until it no longer does. On ever stiffer contacts all this tends to the impulse.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.crossing import MOST_SAMPLES, ComplexArray, Effort, Signals, changes, first_crossing, oscillations, rate_of_change
from shockpc.core.spatial import Array

OPEN, LOADING, UNLOADING = range(3)

UNLOADS, RELOADS, REVERSES, SLIPS, OPENS, CLOSES, TURNS = range(7)

EVENTS = "unloads", "reloads", "reverses", "slips", "opens", "closes"
"""What can happen to an element; a normal that unloads is at the end of its compression."""

WATCHED = np.array([0, 1, 1, 1, 1, 2, 0])
"""What tells of each: the rate (0), the force (1) or the gap (2) of an element."""

NEGLIGIBLE = 1e-11
"""Share of the motion that excites the elements, below which what moves or presses counts as rounding."""

SMALLEST_PIVOT = 1e-7
"""Smallest diagonal entry of the Cholesky factor of M, scaled to a unit diagonal, with which M counts as positive definite."""

DEPENDENT = 1e-13
"""Share of the largest frequency below which that of a mode is rounding: its rows are dependent, or it moves no spring."""

NEAR_MAXIMUM, MOST_MAXIMA = 0.95, 64
"""Share of the largest squared sample from which a local maximum is refined; the largest number that is."""

MOST_TOGETHER, SAMPLES_TOGETHER = 32, 2**13
"""Numbers of segments and of samples that are searched together for peaks: what was found before limits what is searched."""

MOST_SEGMENTS = 4000
"""Bound of the number of segments of a motion."""

LONGEST = 2.0
"""Times the duration without constant forces by which a motion with them ends: both halves of a half-sine become at most as long as
the whole one is without them."""

STAYS_OPEN = 10.0
"""Times the motion so far for which all contacts have to stay open, so that it has ended: what closes later is another impact."""

AT_ONCE = 1e-3
"""Angle of the fastest element [rad] within which a reversal that is undone is no event: a tiny oscillation of a row at a turn."""


class Elements(NamedTuple):
    """The springs of a landing, one for each of r rows.

    Attributes:
        rows: (r, n) velocity along each element for unit velocities of the n coordinates [m, 1].
        stiffness: (r,) k [N/m, N m/rad].
        restitution: (r,) e from 0 to 1; 1 for a spring without loss.
        contact: (r,) number of the contact that a row belongs to, −1 for a spring between bodies.
        normal: (r,) whether a row is the normal of its contact, along which the ground pushes. Each contact has one.
        damping: (r,) c of a viscous damper beside the spring, which replaces e [N s/m, N m s/rad]; zero for none.
        load: (r,) force on the robot along the row at the impact [N, N m]: of a spring between bodies that is deflected already, or
            constant where the stiffness is zero. Contacts have none.
    """

    rows: Array
    stiffness: Array
    restitution: Array
    contact: np.ndarray
    normal: np.ndarray
    damping: Array | float = 0.0
    load: Array | float = 0.0


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
    """The motion between two events, in d modes.

    Attributes:
        start: time of the first event [s].
        length: time until the second [s].
        sigma: (d,) natural frequencies [rad/s].
        V: (d, d) modes in u.
        velocity, acceleration: (d,) υ = Vᵀu and its rate at the start.
        shape: (r, d) forces of all elements for unit modes in z.
        level: (r,) part of the forces of all elements that stays constant; at rest they would have it.
        wave: (r, d) with their other part, Re(wave · exp(iσt)).
        jump: (d,) u(start) − u(0).
        displacement: (d,) ∫u dt until the start.
    """

    start: float
    length: float
    sigma: Array
    V: Array
    velocity: Array
    acceleration: Array
    shape: Array
    level: Array
    wave: ComplexArray
    jump: Array
    displacement: Array

    def forces(self, t: Array) -> Array:
        """The forces (..., r) at times t (...) after the start."""
        return self.level + oscillations(t[..., None] * self.sigma, self.wave)

    def after(self, t: Array) -> tuple[Array, Array]:
        """The change of u since impact and ∫u dt (..., d), at times t (...) after the start."""
        t = t[..., None]
        half = t / 2.0 * self.sigma
        # 2 sin(σt/2) / σ, t for a mode without frequency: of slow modes no digits cancel.
        chord = np.divide(2.0 * np.sin(half), self.sigma, out=t + 0.0 * half, where=self.sigma > 0.0)
        once, twice = chord * np.cos(half), chord * chord / 2.0
        change = once * self.acceleration - twice * self.sigma**2 * self.velocity
        path = once * self.velocity + twice * self.acceleration
        return self.jump + change @ self.V.T, self.displacement + path @ self.V.T

    def impulse(self, t: float) -> Array:
        """The impulses (r,) of the forces from the start until a time t after it."""
        half = t * self.sigma / 2.0
        return np.asarray(t * (self.level + oscillations(half, np.sinc(half / np.pi) * self.wave)))


class StiffMotion(NamedTuple):
    """A landing, solved.

    Attributes:
        elements: the springs that it was computed for, dampers as restitution.
        segments: in order; the motion ends with the last.
        events: in order.
        separated: whether all contacts are open at the end.
        to_velocity: (n, d) from u to ẋ.
        constant: (n,) part of ẋ before impact that no element resists [rad/s, m/s].
        gravity: (n,) accelerations of free fall [rad/s², m/s²].
        falling: (n,) part of these that no element resists.
    """

    elements: Elements
    segments: tuple[Segment, ...]
    events: tuple[Event, ...]
    separated: bool
    to_velocity: Array
    constant: Array
    gravity: Array
    falling: Array

    @property
    def duration(self) -> float:
        """Time from impact to the end [s]."""
        return self.segments[-1].start + self.segments[-1].length

    def first(self, kind: str) -> Array:
        """The time (r,) of the first event of a kind at each element [s]; infinite where there is none."""
        times = {event.element: event.time for event in reversed(self.events) if event.kind == kind}
        return np.array([times.get(i, np.inf) for i in range(len(self.elements.rows))])

    def impulse_time(self, rows: np.ndarray, share: float) -> Array:
        """The time (c,) by which each of c rows has given a share of its impulse until the end; its force never changes sign."""
        given = np.cumsum([segment.impulse(segment.length)[rows] for segment in self.segments], axis=0)
        times = np.zeros(len(rows))
        for i, (row, total) in enumerate(zip(rows.tolist(), given[-1].tolist(), strict=True)):
            k = int(np.argmax(given[:, i] >= share * total))
            segment, missing = self.segments[k], share * total - (given[k - 1, i] if k else 0.0)
            t, low, high, wave, level = segment.length, 0.0, segment.length, segment.wave[row], float(segment.level[row])
            # The impulse grows with time: Newton's method within bounds.
            for _ in range(60 if total > 0.0 else 0):
                half = t / 2.0 * segment.sigma
                turn = np.exp(1j * half) * wave
                last, excess = t, t * (level + float(turn.real @ np.sinc(half / np.pi))) - missing
                force = level + float((np.exp(1j * half) @ turn).real)
                low, high = (t, high) if excess < 0.0 else (low, t)
                t = t - excess / force if force > 0.0 else high
                t = t if low < t < high else (low + high) / 2.0
                if abs(t - last) <= 1e-8 * segment.length:
                    break
            times[i] = segment.start + t if total > 0.0 else 0.0
        return times

    @property
    def response(self) -> Array:
        """(n, r) M⁻¹Bᵀ: accelerations for unit forces of the elements [1/kg, 1/(kg m), 1/(kg m²)]."""
        return np.asarray(self.to_velocity @ (self.elements.rows @ self.to_velocity).T)

    @property
    def modes(self) -> Modes:
        """The modes of the elements that are loaded first."""
        first, k = self.segments[0], self.elements.stiffness[:, None]
        moves = first.sigma > 0.0
        sigma, velocity, shape = first.sigma[moves], first.velocity[moves], first.shape[:, moves]
        participation = np.divide(shape**2, k, out=np.zeros_like(shape), where=k > 0.0)
        return Modes(sigma / (2.0 * np.pi), velocity**2 / 2.0, participation, np.abs(first.wave[:, moves]))

    def at(self, times: Array) -> History:
        """The motion at times (T,) from 0 to the duration [s]; at an event, just before it."""
        times = np.asarray(times, dtype=float)
        ends = np.array([segment.start + segment.length for segment in self.segments])
        which = np.minimum(np.searchsorted(ends, times), len(ends) - 1)
        (r, d), T = (len(self.elements.rows), self.to_velocity.shape[1]), len(times)
        force, displacement, jump = (np.empty((T, columns)) for columns in (r, d, d))
        for k in np.unique(which):
            now, segment = which == k, self.segments[k]
            force[now] = segment.forces(times[now] - segment.start)
            jump[now], displacement[now] = segment.after(times[now] - segment.start)
        displacement = displacement @ self.to_velocity.T + np.outer(times, self.constant) + np.outer(times**2 / 2.0, self.falling)
        jump = jump @ self.to_velocity.T + np.outer(times, self.falling)
        return History(force, displacement, jump, force @ self.response.T + self.gravity)

    def peak(self, outputs: Array) -> tuple[Array, Array]:
        """The largest lengths of vectors P f that are linear in the forces f, and when they are reached.

        Args:
            outputs: (m, k, r) P; of what is linear in accelerations beyond free fall, G (ẍ − g), it is G `response`.

        Returns: (m,) lengths, NaN where P is, and (m,) times [s]. Each oscillation is sampled thirty times, and the largest local
            maxima of the samples are refined to rounding.

        Raises:
            ArithmeticError: the frequencies lie too far apart to sample the motion, or it takes too many terms.
        """
        P = np.nan_to_num(outputs)
        starts = np.array([segment.level + segment.wave.real.sum(axis=1) for segment in self.segments])
        largest, when = _peak(P, self.segments, np.square(P @ starts.T).sum(axis=1).max(axis=1), Effort())
        return np.where(np.isnan(outputs).any(axis=(1, 2)), np.nan, largest), when


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


def simulate_landing(
    M: Array, elements: Elements, velocity: Array, until: float | None = None, gravity: Array | None = None
) -> StiffMotion:
    """Solve a landing with frozen geometry on elements of finite stiffness.

    Args:
        M: (n, n) inertia of the coordinates [kg, kg m, kg m²].
        elements: springs of the contacts and between bodies, and constant forces.
        velocity: (n,) q̇⁻ [rad/s, m/s].
        until: time at which the motion ends [s]; by default, when all contacts open and stay so (`STAYS_OPEN`), without constant
            forces. Until a later time, springs between bodies oscillate and contacts may close again.
        gravity: (n,) accelerations of free fall [rad/s², m/s²]; none by default.

    Raises:
        ValueError: an argument is not finite, a stiffness is not above zero, a restitution is outside 0 to 1, a contact has not
            exactly one normal, or no contact approaches the ground.
        ArithmeticError: M is not positive definite in double precision, the frequencies lie too far apart to find the events, or
            there are too many of them.
    """
    gravity = np.zeros(len(velocity)) if gravity is None else gravity
    elements = elements._replace(load=np.broadcast_to(elements.load, len(elements.rows)))
    _check(M, elements, velocity, until, gravity)
    coordinates = _coordinates(M, elements.rows)
    alone = _State(elements._replace(load=np.zeros(len(elements.rows))), *coordinates, velocity, 0.0 * gravity)
    if alone.separated:
        raise ValueError("no contact approaches the ground")
    if np.any(elements.damping):
        elements = elements._replace(restitution=alone.damped())
        alone = _State(elements._replace(load=np.zeros(len(elements.rows))), *coordinates, velocity, 0.0 * gravity)
    if not (gravity.any() or np.any(elements.load)):
        return _follow(alone, until)
    state = _State(elements, *coordinates, velocity, gravity)
    if until is not None:
        return _follow(state, until)
    return _follow(state, _follow(alone, None).duration, settle=True)


def _follow(state: "_State", until: float | None, settle: bool = False) -> StiffMotion:
    """The motion from a state. Args: until, as for `simulate_landing`; settle, whether contacts that are moving then go on."""
    elements = state.elements
    segments: list[Segment] = []
    events: list[Event] = []
    time, simultaneous, settling = 0.0, 0, False
    while not settling or state.moving.any():
        opened = until is None and state.separated
        end = np.inf if until is None else LONGEST * until if settling else until
        segment, hit = state.step(time, STAYS_OPEN * time if opened else end - time)
        if opened and hit is None:
            break
        simultaneous += 1
        if segment is not None:
            segments.append(segment)
            time, simultaneous = time + segment.length, 0
        if hit is None:
            if settle and not settling:
                settling = True
                state.settle()
                continue
            break
        if hit[1] == TURNS:
            state.moving[hit[0]] = False
            continue
        if len(segments) >= MOST_SEGMENTS or simultaneous > 4 * len(elements.rows):
            remedies = (
                ["take springs of joints that are stiffer than the contacts as rigid"] if np.any(elements.contact < 0) else []
            )
            remedies += ["take a softer contact, a larger restitution or none"]
            remedies += ["end the motion earlier"] if until is not None and not settle else []
            text = f"elements change {len(segments)} times in {time:.3g} s, too often to follow them; "
            raise ArithmeticError(text + ", or ".join(remedies))
        event = Event(time, hit[0], EVENTS[state.switch(*hit)])
        previous = next((one for one in reversed(events) if one.element == event.element), event)
        if {event.kind, previous.kind} == {"unloads", "reloads"} and time - previous.time < AT_ONCE / state.fastest:
            events.remove(previous)
        else:
            events.append(event)
    return StiffMotion(
        elements, tuple(segments), tuple(events), state.separated, state.to_velocity, state.constant, state.gravity, state.falling
    )


def _check(M: Array, elements: Elements, velocity: Array, until: float | None, gravity: Array) -> None:
    """Raise ValueError for arguments that have no meaning."""
    if not all(np.isfinite(values).all() for values in (M, velocity, gravity, *elements)):
        raise ValueError("inertia, velocity, gravity and elements must be finite")
    constant = (elements.contact < 0) & (elements.stiffness == 0.0)
    if not np.all((elements.stiffness > 0.0) | constant):
        raise ValueError(f"each stiffness must be above zero, not {elements.stiffness.min():g}")
    if np.any(np.asarray(elements.load)[elements.contact >= 0]):
        raise ValueError("a contact has no load before the impact")
    if not np.all(np.asarray(elements.damping) >= 0.0):
        raise ValueError(f"each damping must be zero or above, not {np.min(elements.damping):g}")
    if not np.all((elements.restitution >= 0.0) & (elements.restitution <= 1.0)):
        raise ValueError(f"each restitution must lie in [0, 1], not {elements.restitution.tolist()}")
    if sorted(elements.contact[elements.normal].tolist()) != sorted({*elements.contact.tolist()} - {-1}):
        raise ValueError("each contact needs exactly one row that is its normal")
    if until is not None and not 0.0 < until < np.inf:
        raise ValueError(f"the end of the motion must be finite and above 0 s, not {until:g} s")


def _coordinates(M: Array, rows: Array) -> tuple[Array, Array, Array]:
    """The coordinates u along some rows: W as in `_State`, and to_velocity and from_velocity, with u = from_velocity q̇.

    From M = LLᵀ, scaled to a unit diagonal: they have unit inertia.
    """
    diagonal = np.diagonal(M)
    if np.all(diagonal > 0.0):
        size = np.sqrt(diagonal)
        try:
            L = np.linalg.cholesky(M / size / size[:, None])
        except np.linalg.LinAlgError:
            L = np.zeros_like(M)
        if np.diagonal(L).min() > SMALLEST_PIVOT:
            inverse = np.linalg.inv(L).T / size[:, None]
            Q, R = np.linalg.qr((rows @ inverse).T)
            return R.T, inverse @ Q, Q.T @ (L.T * size)
    raise ArithmeticError("the inertia is not positive definite in double precision; give moving bodies mass, or lock their joints")


class _State:
    """The state of elements and motion at an event, in the d coordinates of u along the rows of the elements.

    Attributes:
        W: (r, d) velocity along each element for unit u.
        to_velocity, constant: as in `StiffMotion`.
        mode: (r,) OPEN, LOADING or UNLOADING.
        slope: (r,) √κ.
        z: (r,) √κ (B x − a), zero where an element is open.
        peak: (r,) z at the start of unloading.
        gap: (r,) B x since the contact opened [m].
        u, jump: (d,) at the impact, and the change since then.
        pull: (d,) rate at which constant forces change u.
        displacement: (d,) ∫u dt.
        noise: size of z and u that counts as rounding.
        fastest: largest natural frequency of a single element [rad/s].
        moving: (r,) normals of contacts for whose rebound the motion goes on.
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
        self.length = _lengths(self.W)
        self.slope = np.sqrt(elements.stiffness)
        self.sprung = elements.stiffness > 0.0
        self.z, self.peak, self.gap = np.zeros((3, len(self.W)))
        load = np.asarray(elements.load)
        self.z[self.sprung] = -load[self.sprung] / self.slope[self.sprung]
        self.steady = np.where(self.sprung, 0.0, load)
        self.pull = free + self.W.T @ self.steady
        self.jump, self.displacement = np.zeros((2, len(self.u)))
        self.moving = np.zeros(len(self.W), dtype=bool)
        # What single contacts come to rest at counts like the speed.
        speed, single = float(np.linalg.norm(self.u)), (self.slope * self.length)[elements.normal]
        self.noise = NEGLIGIBLE * (speed + float(np.linalg.norm(self.pull)) / float(single.min()))
        self.fastest = float((self.slope * self.length).max())
        self.effort = Effort()
        closing = elements.contact[elements.normal & (self.W @ self.u < -1e-13 * self.length * speed)]
        self.mode = np.where((elements.contact < 0) | np.any(elements.contact == closing[:, None], axis=0), LOADING, OPEN)

    @property
    def separated(self) -> bool:
        """Whether all contacts are open."""
        return not (self.mode[self.grounded] != OPEN).any()

    def settle(self) -> None:
        """Let the motion go on until each contact that is compressed further or rebounds now has ended that once."""
        rebounds = (self.mode == UNLOADING) & ~self.rigid & (self.W @ (self.u + self.jump) > self.noise * self.length)
        self.moving = self.elements.normal & ((self.mode == LOADING) | rebounds)

    def damped(self) -> Array:
        """The restitution (r,) with the dampers: for the mode with the largest force of an element, or for an open one alone."""
        elements = self.elements
        segment, _ = self.step(0.0, np.inf)
        assert segment is not None
        force = np.abs(segment.wave)
        own = np.where(force.any(axis=1), segment.sigma[force.argmax(axis=1)], self.slope * self.length)
        e = damper_restitution(elements.damping * own / (2.0 * np.where(self.sprung, elements.stiffness, 1.0)))
        return np.where(np.asarray(elements.damping) > 0.0, e, elements.restitution)

    def step(self, time: float, horizon: float) -> tuple[Segment | None, tuple[int, int] | None]:
        """Go to the next event, at most by a horizon [s]; the segment until then, if any, and the element and what happens to it.

        Watched are the rate of what is loaded, the force of what is unloaded and the gap of open contacts: an element changes when
        its number falls below −tolerance.
        """
        rigid = (self.mode == UNLOADING) & self.rigid
        held, sprung = rigid.nonzero()[0], (self.mode != OPEN) & ~rigid & self.sprung
        if len(held) and not sprung.any() and not self.pull.any():
            # Nothing presses what is held on the ground, so that it is released.
            return None, (int(held[self.elements.normal[held]][0]), OPENS)
        F, z, pull = np.where(sprung, self.slope, 0.0)[:, None] * self.W, np.where(sprung, self.z, 0.0), self.pull
        # The scaled forces of all elements are to_all · z + balance.
        to_all, balance = np.diag(sprung.astype(float)), np.zeros(len(z))
        if len(held):
            # From H u̇ = 0 with u̇ = −Fᵀz − Hᵀm + c follows m = (H Hᵀ)⁻¹ H (c − Fᵀz); of dependent rows each takes the least share.
            H, size = self.W[held] / self.length[held, None], (self.slope * self.length)[held]
            least = np.linalg.pinv(H.T, rcond=1e-9)
            still = H.T @ least
            to_all[held], balance[held] = -(least @ F.T) / size[:, None], least @ pull / size
            self.jump, F, pull = self.jump - still @ (self.u + self.jump), F - F @ still, pull - still @ pull
        u = self.u + self.jump
        watched = list(self._watched())
        element, kind, either, tolerance, offset, sign = np.array(watched).T
        row, either = (element + len(z) * WATCHED[kind.astype(int)]).astype(int), either != 0.0
        forces = to_all @ z + balance
        start = offset + sign * np.concatenate([self.W @ u, forces, self.gap])[row]
        early = np.where(either, np.inf, start + tolerance)
        if early.min() < 0.0:
            return None, watched[int(early.argmin())][:2]
        U, sigma, Vt = np.linalg.svd(F, full_matrices=False)
        sigma[sigma < DEPENDENT * sigma[0]] = 0.0
        V, still = Vt.T, sigma == 0.0
        velocity, acceleration = Vt @ u, Vt @ pull - sigma * (U.T @ z)
        inverse = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=~still)
        turning = -inverse * acceleration - 1j * np.where(still, 0.0, velocity)
        of_u, of_z, zero = self.W @ V, to_all @ U, np.zeros(len(z))
        falling = of_u @ np.where(still, acceleration, 0.0)
        linear = np.concatenate([falling, zero, of_u @ np.where(still, velocity, 0.0)])
        square = np.concatenate([zero, zero, falling / 2.0])
        wave = np.concatenate([1j * of_u, of_z, of_u * inverse]) * turning
        signals = Signals(either, tolerance, start, sign * linear[row], sign * square[row], sign[:, None] * wave[row])
        length, first = first_crossing(sigma, signals, horizon, self.effort)
        shape = -self.slope[:, None] * of_z
        level = self.steady - self.slope * forces + shape @ (inverse * acceleration)
        segment = Segment(
            time, length, sigma, V, velocity, acceleration, shape, level, shape * turning, self.jump, self.displacement
        )
        self.jump, displacement = segment.after(np.asarray(length))
        self.gap, self.displacement = self.gap + self.W @ (displacement - self.displacement), displacement
        self.z = forces + changes(length * sigma, wave[len(z) : 2 * len(z)])
        return segment, None if first is None else watched[first][:2]

    def _watched(self) -> Iterator[tuple[int, int, bool, float, float, float]]:
        """What can change: element, event, whether its number counts with the sign that it has first, tolerance, constant, sign."""
        # Numbers of Python, because those of NumPy take ten times as long one by one.
        deflection, peak, rigid, noise = self.z.tolist(), self.peak.tolist(), self.rigid.tolist(), self.noise
        moving = self.moving.tolist()
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
                if moving[i] and not rigid[i]:
                    yield i, TURNS, False, 2.0 * noise * length, 0.0, 1.0
            elif mode == OPEN and normal:
                yield i, CLOSES, False, noise * length / self.fastest, 0.0, 1.0

    def switch(self, i: int, kind: int) -> int:
        """Let an event happen to element i; what it is in full."""
        e = 1.0 if self.rigid[i] else float(self.elements.restitution[i])
        self.moving[i] &= kind == UNLOADS and not self.rigid[i]
        rows = self.elements.contact == self.elements.contact[i]
        if kind == UNLOADS:
            self.mode[i], self.slope[i], self.z[i] = UNLOADING, self.slope[i] / e, self.z[i] * e
            self.peak[i] = self.z[i]
            return kind
        if kind in (RELOADS, REVERSES):
            self.mode[i], self.slope[i] = LOADING, self.slope[i] * e
            # The force of a row that is held jumps where another one is held too; the row is then loaded from its peak.
            self.z[i] = 0.0 if kind == REVERSES else self.peak[i] if self.rigid[i] else self.z[i] / e
            return kind
        if kind == OPENS and self.rigid[i] and np.any(self.mode[rows & ~self.elements.normal] != OPEN):
            rows, kind = rows & ~self.elements.normal, SLIPS
        self.mode[rows], self.z[rows], self.gap[rows] = LOADING if kind == CLOSES else OPEN, 0.0, 0.0
        self.slope[rows] = np.sqrt(self.elements.stiffness[rows])
        return kind


def _lengths(vectors: Array) -> Array:
    """The lengths (m,) of vectors (m, k)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1)))


def _peak(outputs: Array, segments: Sequence[Segment], least: Array, effort: Effort) -> tuple[Array, Array]:
    """As `StiffMotion.peak`, within some segments; zero where they have none above the square root of least (m,)."""
    (m, k, r), count = outputs.shape, len(segments)

    def in_halves() -> tuple[Array, Array]:
        first, early = _peak(outputs, segments[: count // 2], least, effort)
        second, late = _peak(outputs, segments[count // 2 :], np.maximum(least, first**2), effort)
        return np.maximum(first, second), np.where(second > first, late, early)

    if count > MOST_TOGETHER:
        return in_halves()
    modes, P = 1 + segments[0].wave.shape[1], outputs.reshape(m * k, r)
    start, lengths = np.array([(segment.start, segment.length) for segment in segments]).T
    omega, wave = np.zeros((count, modes)), np.zeros((count, r, modes), dtype=complex)
    for i, segment in enumerate(segments):
        # What stays constant has the frequency zero.
        omega[i, 1:], wave[i, :, 0], wave[i, :, 1:] = segment.sigma, segment.level, segment.wave
    waves = (P @ wave.view(float)).view(complex).reshape(count, m, k, modes)
    size = np.abs(waves)
    larger = np.square(size.sum(axis=3)).sum(axis=2) >= (1.0 - 1e-9) * least
    kept, own = larger.any(axis=1), larger.any(axis=0)
    if not (kept.all() and own.all()):
        largest, when = np.zeros((2, m))
        if kept.any():
            largest[own], when[own] = _peak(outputs[own], [segments[i] for i in np.flatnonzero(kept).tolist()], least[own], effort)
        return largest, when
    rate = np.where(larger[..., None], rate_of_change(omega[:, None, None], size), 0.0).max(axis=(1, 2))
    steps = np.minimum(lengths * rate / 0.2, 2.0 * MOST_SAMPLES).astype(int) + 1
    if count > 1 and steps.sum() > SAMPLES_TOGETHER:
        return in_halves()
    if steps.sum() > MOST_SAMPLES:
        raise ArithmeticError(
            f"the fastest mode oscillates more than {MOST_SAMPLES // 30} times in {lengths[0]:.3g} s; take the stiffest as rigid"
        )
    effort.spend(int((steps + 1).sum()) * r * (modes + m * k))
    ends, step = np.cumsum(steps + 1), lengths / steps
    begins, own = ends - steps - 1, np.repeat(np.arange(count), steps + 1)
    t = (np.arange(len(own)) - begins[own]) * step[own]
    force = [oscillations(t[a:b, None] * omega[i], wave[i]) for i, (a, b) in enumerate(zip(begins, ends, strict=True))]
    square = np.square(np.concatenate(force) @ P.T).reshape(-1, m, k).sum(axis=2)
    # A sample at the end of a segment may exceed those of the next, whose maximum lies between its samples: refine each.
    rises, falls = np.ones((2, *square.shape), dtype=bool)
    rises[1:] = square[1:] > square[:-1]
    falls[:-1] = ~rises[1:]
    rises[begins], falls[ends - 1] = True, True
    local = rises & falls & (square >= NEAR_MAXIMUM * square.max(axis=0))
    if np.count_nonzero(local) > MOST_MAXIMA * m:
        local &= square >= np.partition(np.where(local, square, -1.0), -MOST_MAXIMA, axis=0)[-MOST_MAXIMA]
    sample, vector = np.nonzero(local)
    at, own = t[sample], own[sample]
    low, high = np.maximum(at - step[own], 0.0), np.minimum(at + step[own], lengths[own])
    length, at = _refined(omega[own], waves[own, vector], at, low, high)
    # Of values that are assigned to one place the last one stays: the largest, and of equal ones the first.
    order, (largest, when) = np.argsort(-length, kind="stable")[::-1], np.zeros((2, m))
    largest[vector[order]], when[vector[order]] = length[order], (start[own] + at)[order]
    return largest, when


def _refined(omega: Array, waves: Array, t: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """The largest length (m,) of vectors near times t (m,), and its time, between bounds.

    The vectors are the real parts of waves (m, k, j) · exp(iωt), ω (m, j). Newton's method on half the derivative of the squared
    length.
    """
    length, best, turning = np.full(len(t), -1.0), t, 1j * omega[:, None]
    derivatives = np.concatenate([waves, waves * turning, waves * turning**2], axis=1)
    for _ in range(8):
        values = (derivatives @ np.exp(turning[:, 0] * t[:, None])[..., None]).real.reshape(len(t), 3, -1)
        value, rate, curve = values[:, 0], values[:, 1], values[:, 2]
        found = _lengths(value)
        length, best = np.where(found > length, found, length), np.where(found > length, t, best)
        slope, bend = (value * rate).sum(axis=1), (rate * rate + value * curve).sum(axis=1)
        # Where the square is not concave, go to the bound that lies uphill.
        last, step = t, np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.sign(slope) * (high - low))
        t = np.clip(t + step, low, high)
        if np.all(np.abs(t - last) <= 1e-6 * (high - low)):
            break
    return length, np.where(np.abs(t - best) <= 1e-6 * (high - low), t, best)
