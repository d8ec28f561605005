"""A landing on contacts and springs of finite stiffness: forces, accelerations, times.

They are in double precision, not proven.

The motion, which `motion.contacts` follows, is linear in the forces of its elements
(`elements`) at each time: what is linear in the jumps and impulses of an impact (the velocity
of a point, the wrench through a joint) is, of the accelerations for unit forces, the matrix that
gives the same of the motion. Accelerations are those less gravity, as an accelerometer measures
them. Without forces of the elements a free robot falls freely, with no such acceleration and no
load of a joint. A fixed base or standing feet hold their robot against gravity, which adds constant
accelerations and loads.
"""

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.low_pass import LowPass
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze
from shockpc.core.threads import one_thread
from shockpc.impact.impact import ColumnImpact, DoubleImpact, Impact, jumps_in_body_axes
from shockpc.impact.stops import with_stops
from shockpc.landing.before_impact import mass_lifted
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.constraints import Constraint, constraint_point
from shockpc.method.exact.proof import motion as size_of
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import SolveError
from shockpc.text.printed import few
from shockpc.wings.compliant.links.bent_landing import flexible_landing
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.filtered import filtered
from shockpc.wings.compliant.motion.laws import damper_restitution
from shockpc.wings.compliant.motion.stiff_motion import History, StiffMotion
from shockpc.wings.compliant.over_time.element_system import element_system

Compute = Callable[[Impact, Sequence[Place]], Any]

MANY_EVENTS = 100
"""Number of times that contacts change their state, above which durations are not reliable."""

IMPULSE_SHARE = 0.99
"""Share of a contact's normal impulse that is given within its duration.

What follows may be a tiny force that lasts long.
"""

GRAVITY_SHARE, DEEPEST_SHARE = 0.05, 0.1
"""Shares from which on a landing without gravity, or with frozen geometry, is doubtful.

The first is that of the approach speed that gravity adds during the contact; the second is that of
the robot's size by which a contact is compressed.
"""

DAMPED_SHARE = 0.01
"""Share of the change of velocities from which on the damping of joints counts."""


class CompliantLanding:
    """A landing on contacts, and on springs and rotors in its joints, of finite stiffness.

    It is computed when it is read.

    What acts is made first (`element_system`), then the motion. All else is read from these: a
    quantity at the end, its peak, its history, and how the end differs from the impulse model, with
    warnings. Links that bend have hinges, which are springs like those of joints, and move only
    here.

    Args:
        landing: the landing.
        until: time at which the motion ends [s]; by default, when all contacts are open and stay
            so.

    Attributes:
        landing: the landing.
        moving: the same, or that with links that bend.
        motion: until that time.
        number: (r,) contact of each element; −1 for a spring or a motor in a joint.

    Raises:
        SolveError: the motion cannot be followed, or no motion of the robot has the velocities
            before the impact.
    """

    def __init__(self, landing: PosedLanding, until: float | None = None) -> None:
        self.landing = self.moving = landing
        if landing.scene.flex:
            self.moving = flexible_landing(landing)
        self._system = system = element_system(self.moving)
        self._rows, self._free, self._stops = system.rows, system.free, system.stops
        self.number = system.elements.contact
        self._normal = system.elements.normal & (self.number < len(self.moving.contact_places))
        self._peaks: dict[Any, tuple[Array, Array]] = {}
        self._impacts: dict[float, DoubleImpact] = {}
        self._filtered: dict[LowPass, StiffMotion] = {}
        self.motion = self._simulate(until)

    def _simulate(self, until: float | None) -> StiffMotion:
        """The motion until a time [s]. Raises: SolveError: it cannot be followed."""
        system = self._system
        try:
            with one_thread(2 * len(self.number)):
                return simulate_landing(
                    system.inertia,
                    system.elements,
                    system.velocity,
                    gravity=system.gravity,
                    until=until,
                )
        except (ArithmeticError, np.linalg.LinAlgError) as refusal:
            raise SolveError(
                f"no verdict for contacts of {self.landing.scene.contact_stiffness:g} N/m: "
                f"{refusal}"
            ) from None

    def filtered(self, low_pass: LowPass | None) -> StiffMotion:
        """The motion with its forces behind a filter, or as it is without one.

        It goes on beyond its end as long as the filter lags.

        Springs between bodies go on oscillating after the end. Where there are none, the forces end
        with the motion: the weight that contacts may carry from then on is no part of the impact.

        Raises:
            SolveError: what springs do after the end cannot be followed.
        """
        if low_pass is None:
            return self.motion
        if low_pass not in self._filtered:
            motion, tail = self.motion, low_pass.tail
            if (self.number < 0).any():
                motion, tail = self._simulate(motion.duration + tail), 0.0
            self._filtered[low_pass] = filtered(motion, low_pass, tail)
        return self._filtered[low_pass]

    def _impact(self, jumps: Array, impulse: Array | None = None) -> ColumnImpact:
        """An impact with jumps (n, S) of the coordinates and impulses along all rows.

        The impulses are (nc, at most S); the remaining strikes have none.
        """
        equation, rows = self._rows.equation, self._rows
        delta = (rows.basis @ jumps[: self._free.shape[1]])[None]
        impulses = np.full((1, equation.J_c.shape[1], jumps.shape[1]), np.nan)
        if impulse is not None:
            impulses[0, :, : impulse.shape[1]] = impulse
        # Of the solution of Eq. 4 only these are read.
        solution = Solution(
            delta, impulses, np.ones(impulses.shape[:2]), np.array([0]), np.ones(1), {}, {}
        )
        jumps = jumps_in_body_axes(equation, delta)
        return ColumnImpact(replace(self.moving, acting=self._stops), equation, solution, jumps)

    @functools.cached_property
    def _linear(self) -> ColumnImpact:
        """An impact whose jumps are accelerations of elements, of gravity, and jumps of `ends`.

        Those of each element are for its unit force.

        Those of gravity are, less gravity, those of a fall that a fixed base, standing feet and
        loops constrain; all come with what holds these. All else is linear in the forces. The jumps
        of `ends` are those beyond the fall with straight links.
        """
        landing, falling = self.moving, self.motion.gravity
        times, turns = self._turns
        end_of_compression = times.index(self.compressed)
        beyond = []
        for k in (end_of_compression, -1):
            fall = times[k] * self._system.fall
            beyond.append(turns.jump[k] - fall)
        jumps = [self.motion.response, falling, *beyond, self._impulsive]
        linear = self._impact(np.column_stack(jumps), self._impulses)
        if landing.scene.gravity:
            # Accelerations of a fall, less gravity, of which body axes have R^T (0, 0, -g).
            up = landing.state.rotation[:, :, 2]
            linear.jumps[..., 3:, len(self.number)] += GRAVITY * up
        return linear

    @property
    def _impulses(self) -> Array:
        """Forces (nc, r + 1) along all rows for unit forces of the elements, and in the fall.

        Those of rows that hold the robot rigidly, of standing feet and loops, follow from
        H a = Jᵀ f + J_rᵀ f_r, of accelerations a and forces f along the others.
        """
        rows, equation = self._rows, self._rows.equation
        H, J = equation.H[0], equation.J_c[0]
        n, stops, unstopped = len(rows.turn), len(self._stops), len(rows.rigid)
        forces = np.zeros((len(J), len(self.number) + 1))
        forces[:unstopped, :n] = rows.turn.T
        forces[unstopped:, n : n + stops] = np.eye(stops)
        if not rows.rigid.any():
            return forces
        landing, free = self.moving, self._free.shape[1]
        weight = -GRAVITY * landing.scene.gravity * mass_lifted(landing.robot, landing.state)
        if equation.G is not None:
            weight = weight @ equation.G[0]
        of_contacts, of_stops = rows.turn @ J[:unstopped], J[unstopped:]
        along = np.vstack([of_contacts, of_stops, self._system.along, weight])
        accelerations = np.column_stack([self.motion.response, self.motion.gravity])[:free]
        missing = H @ (rows.basis @ accelerations) - along.T
        rigid = np.flatnonzero(rows.rigid)
        forces[rigid] = np.linalg.lstsq(J[rigid].T, missing, rcond=1e-10)[0]
        return forces

    def readout(self, compute: Compute, places: Sequence[Place]) -> tuple[Array, Array]:
        """Matrices (n, k, r) from the forces to a quantity, and a constant (n, k).

        The quantity is n vectors linear in jumps and impulses.
        """
        carried = tuple(map(self.moving.carried, places))
        values = np.asarray(compute(self._linear, carried), dtype=float)[0, : len(self.number) + 1]
        values = values.reshape(*values.shape[:2], -1).transpose(1, 2, 0)
        return np.ascontiguousarray(values[..., :-1]), values[..., -1]

    def ends(self, compute: Compute, places: Sequence[Place]) -> Array:
        """A quantity (1, 3, n, ...) of the jumps beyond free fall, and of the impulse.

        The jumps are those until the end of compression and until the end.
        """
        carried = tuple(map(self.moving.carried, places))
        return np.asarray(compute(self._linear, carried))[:, len(self.number) + 1 :]

    def peaks(
        self, compute: Compute, places: Sequence[Place] = (), low_pass: LowPass | None = None
    ) -> tuple[Array, Array]:
        """The largest lengths (n,) of a quantity, and when (n,) each is reached.

        The quantity is n vectors linear in jumps and impulses.

        Args:
            compute: of the quantity.
            places: where.
            low_pass: a filter that the quantity goes through.
        """
        key = (
            compute,
            tuple((place.name, place.body, place.number, place.r.tobytes()) for place in places),
            low_pass,
        )
        if key not in self._peaks:
            motion = self.filtered(low_pass)
            try:
                with one_thread(len(self.number)):
                    self._peaks[key] = motion.peak(*self.readout(compute, places))
            except ArithmeticError as refusal:
                raise SolveError(
                    f"no verdict for contacts of {self.landing.scene.contact_stiffness:g} N/m: "
                    f"{refusal}"
                ) from None
            freeze(self._peaks[key])
        return self._peaks[key]

    def history(
        self,
        compute: Compute,
        places: Sequence[Place],
        times: Array,
        low_pass: LowPass | None = None,
    ) -> Array:
        """History of a quantity (T, n, k) at times (T,)."""
        outputs, constant = self.readout(compute, places)
        force = self.filtered(low_pass).at(times).force
        return np.asarray(np.einsum("nkr,tr->tnk", outputs, force) + constant)

    def displacements(self, times: Array) -> Array:
        """Displacements (T, nv) of joints and hinges of `moving` since the impact [rad, m].

        They are at times (T,).
        """
        return np.asarray(
            self.motion.at(times).displacement[:, : self._free.shape[1]] @ self._free.T
        )

    @functools.cached_property
    def duration(self) -> Array:
        """Time (c,) by which each contact has given 99 % of its normal impulse [s]."""
        return self.motion.impulse_time(np.flatnonzero(self._normal), IMPULSE_SHARE)

    @functools.cached_property
    def stop_peaks(self) -> dict[str, float]:
        """The peak force or torque of the end stops of each joint that is at one [N, N m]."""
        rows, n = np.flatnonzero(self._system.strikes), len(self._rows.normal)
        joints, contacts = self.moving.robot.joints, self.moving.contacts
        names = [joints[contacts[self.number[row]].body].name for row in rows.tolist()]
        names += [stop.frame for stop in self._stops]
        rows = np.append(rows, np.arange(n, n + len(self._stops)))
        by_name: dict[str, float] = {}
        if not len(rows):
            return by_name
        peaks, _ = self.motion.peak(np.eye(len(self.number))[rows, None])
        for name, peak in zip(names, peaks.tolist(), strict=True):
            by_name[name] = max(peak, by_name.get(name, 0.0))
        return by_name

    @property
    def restitution(self) -> Array:
        """Restitution (c,) of each contact along its normal [1].

        With a damping it is that of the mode with its largest force only.
        """
        elements, modes = self.motion.elements, self.motion.modes
        largest = modes.force[self._normal].argmax(axis=1)
        omega = 2.0 * np.pi * modes.frequency[largest]
        c, k = elements.damping[self._normal], elements.stiffness[self._normal]
        # ζ = c ω / 2k
        of_dampers = damper_restitution(c * omega / (2.0 * k))
        return np.where(c > 0.0, of_dampers, self._rows.restitution[self._rows.normal])

    @functools.cached_property
    def _turns(self) -> tuple[list[float], History]:
        """The times of changes and the end [s], and the motion then.

        A change is such as a normal that is unloaded.
        """
        times = [segment.start + segment.length for segment in self.motion.segments]
        return times, self.motion.at(np.array(times))

    @functools.cached_property
    def compressed(self) -> float:
        """Time at which the last contact ends its first compression, or the end without one [s]."""
        first = self.motion.first("unloads")[self._normal]
        return float(first[np.isfinite(first)].max(initial=0.0)) or self.motion.duration

    def impact_at(self, time: float) -> DoubleImpact:
        """The changes of velocity from the impact until a time [s], with free fall.

        They are of the scene's strike, without impulses.
        """
        if time not in self._impacts:
            self._impacts[time] = self._impact(self.motion.at(np.array([time])).jump.T)
        return self._impacts[time]

    @functools.cached_property
    def _impulsive(self) -> Array:
        """Jumps (n,) of the coordinates in the impulse model.

        It reverses at once the speeds of the rows that act in it.

        These are the rows of contacts, those of stops that act at once, and hinges, which are
        locked there.
        """
        acting = with_stops(self.landing).acting if self._stops else ()
        named = [_stop_key(stop) for stop in acting]
        stops_act = [_stop_key(stop) in named for stop in self._stops]
        hinges = self.moving.hinges  # which are locked
        straight = np.isin(np.flatnonzero(self.moving.joint_model.stiffness > 0.0), hinges)
        contacts = np.ones(len(self._rows.normal))
        others = np.zeros(len(self._system.along) - len(straight))
        acts = np.concatenate([contacts, stops_act, straight, others]).astype(bool)
        of_stops = [stop.restitution for stop in acting]
        e = np.concatenate([self._rows.restitution, of_stops, np.zeros(len(hinges))])
        # B Δv = −(1 + e) B v⁻, of the rows B that act.
        rows, to_velocity = self.motion.elements.rows[acts], self.motion.to_velocity
        speeds = (1.0 + e) * (rows @ self._system.velocity)
        impulses = np.linalg.lstsq(rows @ to_velocity, -speeds, rcond=1e-9)[0]
        return np.asarray(to_velocity @ impulses)

    @functools.cached_property
    def difference(self) -> float:
        """Largest difference of a body's jumps at the end from those of the impulse model [1].

        It is relative to the body's largest jump.
        """
        bodies = [self.moving.carried(place).body for place in self.landing.places("body")]
        final, impulsive = np.moveaxis(self._linear.jumps[0, bodies, ..., -2:], -1, 0)
        both = np.stack([final - impulsive, impulsive], axis=-1)
        difference, size = size_of(both, self.landing.robot.rotation_lengths).T
        return float(difference.max() / size.max())

    @property
    def agrees_by_construction(self) -> bool:
        """True if the jumps at the end are those of the impulse model for every stiffness.

        This does not hold where a contact slips or is pressed.

        This does not count contacts that slip or are pressed.
        """
        elements = self.motion.elements
        return bool(np.all(elements.restitution == 0.0) and np.ptp(elements.stiffness) == 0.0)

    @functools.cached_property
    def _compression(self) -> Array:
        """Largest compression (c,) of each contact along its normal [m].

        It includes what dampers in series give way.
        """
        # It is largest where the normal is unloaded, or at the end.
        elements, turns, normal = self.motion.elements, self._turns[1], self._normal
        speeds = (self._system.velocity + turns.jump) @ elements.rows.T
        of_springs = turns.force + elements.damping * speeds
        largest = np.where(turns.force > 0.0, of_springs, 0.0).max(axis=0)
        pressed = largest[normal] / elements.stiffness[normal]
        way = -(turns.displacement @ elements.rows[normal].T).min(axis=0)
        return np.asarray(np.where(elements.relaxation[normal] > 0.0, way, pressed))

    def warnings(self) -> Iterator[Diagnostic]:
        """Warnings where what the model leaves out counts.

        That is gravity, the change of geometry, and contacts that open often.
        """
        if not self.landing.scene.gravity:
            yield from self._weightless()
        yield from self._sinks()
        yield from self._damped()
        yield from self._compressed_far()
        events = len(self.motion.events)
        if events > MANY_EVENTS:
            text = (
                f"contacts change {events} times between loading, unloading, slipping and open: "
                f"tiny changes of the landing change their order, so durations are not reliable; "
                f"take restitution above 0, or fewer contacts"
            )
            yield Diagnostic("contact", "", float(events), text)

    def _weightless(self) -> Iterator[Diagnostic]:
        """A warning where gravity, which is left out, counts."""
        rows = self.motion.elements.rows[self._normal]
        duration = float(self.duration.max())
        approach = float(-(rows @ self._system.velocity).min())
        gained = GRAVITY * duration
        if gained > GRAVITY_SHARE * approach:
            text = (
                f"gravity is left out, and in the {1e3 * duration:.3g} ms of contact it adds "
                f"{gained:.3g} m/s to an approach of {approach:.3g} m/s "
                f"({100.0 * gained / approach:.2g} %): real peak forces are larger; leave out "
                f"--no-gravity"
            )
            yield Diagnostic("contact", "", gained / approach, text)

    def _compressed_far(self) -> Iterator[Diagnostic]:
        """Warnings of contacts that are compressed so far that the geometry changes."""
        landing = self.landing
        state, robot = landing.state, landing.robot
        coms = state.position[0] + (state.rotation[0] @ robot.coms[..., None])[..., 0]
        for contact, compression in zip(landing.contacts, self._compression.tolist(), strict=True):
            if contact.kind == "stop":
                continue
            distances = np.linalg.norm(coms - constraint_point(state, contact)[0], axis=1)
            size = float((distances + robot.gyration).max())
            if compression > DEEPEST_SHARE * size:
                text = (
                    f"{contact.name} is compressed by {compression:.3g} m, on a robot that reaches "
                    f"{size:.3g} m from there: the geometry does not stay as at impact, which this "
                    f"model assumes; take a stiffer contact or a lower speed"
                )
                yield Diagnostic("contact", contact.name, compression, text)

    def _sinks(self) -> Iterator[Diagnostic]:
        """A warning where dampers in series give way faster than a contact strikes.

        They do so under constant forces.
        """
        motion, normal = self.motion, self._normal
        rows = motion.elements.rows[normal]
        strikes = -rows @ self._system.velocity
        # Of the motion along springs only that of dampers in series does not oscillate.
        sinks = -rows @ (motion.to_velocity @ motion.segments[0].drift)
        in_series = motion.elements.relaxation[normal] > 0.0
        pressed = in_series & (strikes > 0.0) & (strikes < sinks)
        for k in np.flatnonzero(pressed).tolist():
            name = self.landing.contacts[k].name
            text = (
                f"{name} hits the ground at {strikes[k]:.3g} m/s, and the weight presses the "
                f"damper of its contact down at {sinks[k]:.3g} m/s: the force rises to the "
                "weight, and the impact has little effect; take a stiffer contact"
            )
            yield Diagnostic("contact", name, float(sinks[k] / strikes[k]), text)

    def _damped(self) -> Iterator[Diagnostic]:
        """A warning where the damping of joints, which is left out, counts.

        Its impulses p = −d Δq, of the deflections Δq until the end, change velocities v by M⁻¹ p,
        or less where contacts hold the robot. Compared are the lengths √(vᵀ M v) of this change and
        of that by the impact.
        """
        M, robot, duration = self._rows.M, self.moving.robot, self.motion.duration
        beyond_fall = self._turns[1].jump[-1] - duration * self._system.fall
        jump = beyond_fall[: len(M)]
        moved = self.displacements(np.array([duration]))[0]
        impulse = np.where(self.moving.joint_model.locked, 0.0, -robot.model.damping * moved)
        along = self._free.T @ impulse
        square = along @ np.linalg.solve(M, along)
        share = float(np.sqrt(square / (jump @ M @ jump)))
        if share > DAMPED_SHARE:
            damped = [joint.name for joint in robot.single_joints if impulse[joint.v].any()]
            names = few(damped, 2, what=" joints")
            text = (
                f"the damping of {names} in the robot's file is left out; in the "
                f"{1e3 * duration:.3g} ms of the motion it may change velocities by up to "
                f"{100.0 * share:.2g} % of their jumps, and late forces by about as much. If it "
                "is there for simulation only, set it to zero in the file"
            )
            yield Diagnostic("contact", "damping", share, text)

    @functools.cached_property
    def force_shares(self) -> Array:
        """Share (c, m) of each mode in the normal force of each contact [1].

        It is its amplitude over the sum of all.
        """
        amplitude = self.motion.modes.force[self._normal]
        total = amplitude.sum(axis=1, keepdims=True)
        return np.asarray(amplitude / np.where(total > 0.0, total, 1.0))


def _stop_key(stop: Constraint) -> tuple[str, bytes, bytes]:
    """Key that tells stops apart: their name and directions."""
    return stop.frame, stop.forces.tobytes(), stop.moments.tobytes()


@memoized()
def compliant_landing(landing: PosedLanding) -> CompliantLanding:
    """The landing on contacts of the scene's stiffness, with the restitution of the contacts.

    Raises:
        SolveError: the motion cannot be followed.
    """
    return CompliantLanding(landing)
