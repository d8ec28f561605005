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

from collections.abc import Iterator

import numpy as np

from shockpc.core.crossing import Effort, Signals, changes, first_crossing
from shockpc.core.spatial import Array
from shockpc.core.stiff_motion import Elements, Event, Segment, StiffMotion

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

MOST_SEGMENTS = 4000
"""Bound of the number of segments of a motion."""

LONGEST = 2.0
"""Times the duration without constant forces by which a motion with them ends: both halves of a half-sine become at most as long as
the whole one is without them."""

STAYS_OPEN = 10.0
"""Times the motion so far for which all contacts have to stay open, so that it has ended: what closes later is another impact."""

UNDONE_ANGLE = 1e-3
"""Angle of the fastest element [rad] within which a reversal that is undone is no event: a tiny oscillation of a row at a turn."""


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
    without_forces = _State(elements._replace(load=np.zeros(len(elements.rows))), *coordinates, velocity, 0.0 * gravity)
    if without_forces.separated:
        raise ValueError("no contact approaches the ground")
    if np.any(elements.damping):
        elements = elements._replace(restitution=without_forces.damped())
        without_forces = _State(elements._replace(load=np.zeros(len(elements.rows))), *coordinates, velocity, 0.0 * gravity)
    if not (gravity.any() or np.any(elements.load)):
        return _follow(without_forces, until)
    state = _State(elements, *coordinates, velocity, gravity)
    if until is not None:
        return _follow(state, until)
    return _follow(state, _follow(without_forces, None).duration, settle=True)


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
        if {event.kind, previous.kind} == {"unloads", "reloads"} and time - previous.time < UNDONE_ANGLE / state.fastest:
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
        self.length = np.linalg.norm(self.W, axis=1)
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
        frequency = np.where(force.any(axis=1), segment.sigma[force.argmax(axis=1)], self.slope * self.length)
        e = damper_restitution(elements.damping * frequency / (2.0 * np.where(self.sprung, elements.stiffness, 1.0)))
        return np.where(np.asarray(elements.damping) > 0.0, e, elements.restitution)

    def step(self, time: float, horizon: float) -> tuple[Segment | None, tuple[int, int] | None]:
        """Go to the next event, at most by a horizon [s]; the segment until then, if any, and the element and what happens to it.

        Watched are the rate of what is loaded, the force of what is unloaded and the gap of open contacts: an element changes when
        its number falls below −tolerance.
        """
        rigid = (self.mode == UNLOADING) & self.rigid
        fixed, sprung = rigid.nonzero()[0], (self.mode != OPEN) & ~rigid & self.sprung
        if len(fixed) and not sprung.any() and not self.pull.any():
            # Nothing presses what is held on the ground, so that it is released.
            return None, (int(fixed[self.elements.normal[fixed]][0]), OPENS)
        F, z, pull = np.where(sprung, self.slope, 0.0)[:, None] * self.W, np.where(sprung, self.z, 0.0), self.pull
        # The scaled forces of all elements are to_all · z + balance.
        to_all, balance = np.diag(sprung.astype(float)), np.zeros(len(z))
        if len(fixed):
            # From H u̇ = 0 with u̇ = −Fᵀz − Hᵀm + c follows m = (H Hᵀ)⁻¹ H (c − Fᵀz); of dependent rows each takes the least share.
            H, size = self.W[fixed] / self.length[fixed, None], (self.slope * self.length)[fixed]
            least = np.linalg.pinv(H.T, rcond=1e-9)
            still = H.T @ least
            to_all[fixed], balance[fixed] = -(least @ F.T) / size[:, None], least @ pull / size
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
