"""A landing on contacts and springs of finite stiffness, in closed form.

It has forces, accelerations and their times.

The geometry is frozen. What remains is a linear system, excited by the velocity before impact and
by constant forces,

    M ẍ + Σ_i B_iᵀ κ_i (B_i x − a_i) = M g + Σ_j B_jᵀ τ_j,    x(0) = 0,    ẋ(0) = q̇⁻

Each *element* i is a spring of stiffness κ along one row B_i (a row of a contact, or the deflection
of a spring in a joint) that is without force at B_i x = a_i; one without stiffness gives a constant
force τ, as a motor. With g, the accelerations of free fall, M = LLᵀ, u = Lᵀẋ and z_i = √κ_i (B_i x
− a_i), that is

    ż = F u,    u̇ = −Fᵀ z + c,    c = Lᵀg + L⁻¹ Σ_j B_jᵀ τ_j,    F = diag(√κ) B L⁻ᵀ = U diag(σ) Vᵀ

The singular values σ are the natural frequencies. (Uᵀz − Vᵀc/σ, Vᵀu) rotate by the angles σt:
forces oscillate about those that balance c. Velocities that no spring resists, orthogonal to V,
change at the rate of their part of c; u is the part along the rows of all elements. F Fᵀ is the
Delassus matrix of step 1, scaled by the stiffness.

Restitution is hysteresis (Walton and Braun 1986, J. Rheol. 30:949): an element is loaded with the
stiffness k and, after its largest force, unloaded with k / e², which returns the share e² of its
energy. A single row then returns −e times its velocity, exactly and for every mass, and its largest
force does not depend on e. With e = 0 a row is held at rest until its force has fallen to zero
(with a small e > 0, a contact on which the robot presses hops instead, and is loaded anew); where
all rows have e = 0, the final velocity is the one of Eq. 4 for every stiffness, unless a row is
released while another one is loaded. Rows are separate elements: tangents with e < 1 or of two
stiffnesses make the result depend on their axes.

A viscous damper c beside a spring adds the force −c B_i ẋ; its element has no restitution. At the
first touch the force starts at c times the speed of approach. u̇ has −D u more, D = L⁻¹ Σ_i B_iᵀ
c_i B_i L⁻ᵀ, and the motion is a sum of oscillations that decay (`damped`).

A viscous damper c in series with a spring gives way under its force: ż_i = √κ_i B_i ẋ − (k/c) z_i.
That starts and ends at zero, without a step, for every restitution; the ground keeps the mark that
it has made.

A contact opens where its normal force falls to zero; its tangential springs lose their energy.
Where the normal is held or has a damper, the contact *slips* first: without tangential forces it
may press on the ground again, and then stays closed without friction. A contact closes where it
opened, with all springs at rest. The ground under a contact with a damper recovers: it presses
where the point is below the place of the first touch and k x + c ẋ is not positive, so that it does
not pull. Between these events the solution is exact; they are found in order (`crossing`).

A landing ends when each contact is open, or is no longer compressed, does not rebound and carries
no more than constant forces make: its force, which oscillates about that, is below it, or
oscillates by less than `EASED` of the largest force. An open contact must not close again within
`STAYS_OPEN` times the motion so far; what constant forces change in its velocity is left out there,
for gravity brings it back to the ground, which is another impact, and so are contacts that would go
down by less than `EASED` of the compression. Springs between bodies may go on oscillating. On ever
stiffer contacts all this tends to the impulse.
"""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.elastic_modes import elastic_modes
from shockpc.wings.compliant.motion.elements import Elements
from shockpc.wings.compliant.motion.events import UNFELT, Event, EventKind
from shockpc.wings.compliant.motion.segment import Segment
from shockpc.wings.compliant.motion.state import State
from shockpc.wings.compliant.motion.step import step
from shockpc.wings.compliant.motion.stiff_motion import StiffMotion
from shockpc.wings.compliant.motion.system import ScaledSystem, coordinates_along

LONGEST = 2.0
"""Periods of the slowest mode after which a motion ends at the latest.

Springs without loss may press contacts on the ground again and again.
"""

MOST_SEGMENTS = 4000
"""Bound of the number of segments of a motion."""

UNDONE_ANGLE = 1e-3
"""Angle of the fastest element within which a reversal that is undone is no event [rad].

It is a tiny oscillation of a row at a turn.
"""


def simulate_landing(
    M: Array,
    elements: Elements,
    velocity: Array,
    until: float | None = None,
    gravity: Array | None = None,
) -> StiffMotion:
    """Solve a landing with frozen geometry on elements of finite stiffness.

    Args:
        M: (n, n) inertia of the coordinates [kg, kg m, kg m²].
        elements: springs of the contacts and between bodies, and constant forces.
        velocity: (n,) q̇⁻ [rad/s, m/s].
        until: time at which the motion ends [s]; by default, when the impact is over at all
            contacts, at the latest after `LONGEST` periods of the slowest mode. Until a later time,
            springs between bodies oscillate and contacts may close again.
        gravity: (n,) accelerations of free fall [rad/s², m/s²]; none by default.

    Raises:
        ValueError: an argument is not finite, a stiffness is not above zero, a restitution is
            outside 0 to 1, a contact has not exactly one normal, or no contact approaches the
            ground.
        ArithmeticError: M is not positive definite in double precision, the frequencies lie too far
            apart to find the events, or there are too many of them.
    """
    if gravity is None:
        gravity = np.zeros(len(velocity))
    _check(M, elements, velocity, until, gravity)
    # A damper takes the energy itself, so that its element loses none by restitution.
    damped = (elements.damping > 0.0) | (elements.relaxation > 0.0)
    elements = elements._replace(restitution=np.where(damped, 1.0, elements.restitution))
    system = ScaledSystem(elements, *coordinates_along(elements.rows, M), velocity, gravity)
    state = State(system)
    if state.separated:
        raise ValueError("no contact approaches the ground")
    modes = elastic_modes(state)
    end = until
    if end is None:
        end = LONGEST / float(modes.frequency[-1])
    segments, events = _followed(state, end, may_end=until is None)
    return StiffMotion(
        elements=elements,
        modes=modes,
        segments=segments,
        events=events,
        separated=state.separated,
        to_velocity=system.to_velocity,
        unresisted_velocity=system.unresisted_velocity,
        gravity=gravity,
        unresisted_gravity=system.unresisted_gravity,
    )


def _followed(
    state: State, end: float, may_end: bool
) -> tuple[tuple[Segment, ...], tuple[Event, ...]]:
    """The segments and events of a motion from a state on.

    Args:
        state: at the impact; it is that of the end afterwards.
        end: time at which the motion ends at the latest [s].
        may_end: whether it ends when the impact is over.
    """
    segments, events = list[Segment](), list[Event]()
    time, simultaneous = 0.0, 0
    while True:
        # A contact that constant forces press down faster than it strikes counts as slow at once,
        # and its force has yet to rise.
        segment, happens = step(state, time, end - time, may_end and time > 0.0)
        simultaneous += 1
        if segment is not None:
            segments.append(segment)
            time, simultaneous = time + segment.length, 0
        if happens is None:
            return tuple(segments), tuple(events)
        # Changes that take no time could follow one another for ever.
        elements = state.system.elements
        if len(segments) >= MOST_SEGMENTS or simultaneous > 4 * len(elements.rows):
            raise ArithmeticError(
                f"elements change {len(segments)} times in {time:.3g} s, too often to follow them; "
                f"{_remedies(elements, may_end)}"
            )
        kind = state.switch(happens.element, happens.kind)
        if kind not in UNFELT:
            _add(events, Event(time, happens.element, kind), UNDONE_ANGLE / state.system.fastest)


def _add(events: list[Event], event: Event, shortest: float) -> None:
    """Add an event, or remove that which it undoes within the shortest time [s]."""
    same_element = (earlier for earlier in reversed(events) if earlier.element == event.element)
    previous = next(same_element, event)
    undone = {event.kind, previous.kind} == {EventKind.UNLOADS, EventKind.RELOADS}
    if undone and event.time - previous.time < shortest:
        events.remove(previous)
    else:
        events.append(event)


def _remedies(elements: Elements, may_end: bool) -> str:
    """Text of what to do where elements change too often to follow them."""
    remedies = ["take a softer contact, a larger restitution or none"]
    if np.any(elements.contact < 0):
        remedies.insert(0, "take springs of joints that are stiffer than the contacts as rigid")
    if not may_end:
        remedies.append("end the motion earlier")
    return ", or ".join(remedies)


def _check(
    M: Array, elements: Elements, velocity: Array, until: float | None, gravity: Array
) -> None:
    """Raise ValueError for arguments that have no meaning."""
    if not all(np.isfinite(values).all() for values in (M, velocity, gravity, *elements)):
        raise ValueError("inertia, velocity, gravity and elements must be finite")
    constant = (elements.contact < 0) & (elements.stiffness == 0.0)
    if not np.all((elements.stiffness > 0.0) | constant):
        raise ValueError(f"each stiffness must be above zero, not {elements.stiffness.min():g}")
    if np.any(elements.load[elements.contact >= 0]):
        raise ValueError("a contact has no load before the impact")
    if not np.all(elements.damping >= 0.0):
        raise ValueError(f"each damping must be zero or above, not {np.min(elements.damping):g}")
    if not np.all(elements.relaxation >= 0.0):
        raise ValueError(
            f"each relaxation must be zero or above, not {np.min(elements.relaxation):g}"
        )
    if not np.all((elements.restitution >= 0.0) & (elements.restitution <= 1.0)):
        raise ValueError(
            f"each restitution must lie in [0, 1], not {elements.restitution.tolist()}"
        )
    contacts = sorted({*elements.contact.tolist()} - {-1})
    if sorted(elements.contact[elements.normal].tolist()) != contacts:
        raise ValueError("each contact needs exactly one row that is its normal")
    if until is not None and not 0.0 < until < np.inf:
        raise ValueError(f"the end of the motion must be finite and above 0 s, not {until:g} s")
