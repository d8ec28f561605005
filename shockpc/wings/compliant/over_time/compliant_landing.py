"""A landing on contacts and springs of finite stiffness: forces, accelerations, times.

They are in double precision, not proven.

The motion, which `motion.contacts` follows, is linear in the forces of its elements
(`element_system`) at each time, and so is what is read from it (`linear_impact`). Accelerations are
those less gravity, as an accelerometer measures them. Without forces of the elements a free robot
falls freely, with no such acceleration and no load of a joint. A fixed base or standing feet hold
their robot against gravity, which adds constant accelerations and loads.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from shockpc.core.low_pass import LowPass
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze
from shockpc.core.threads import one_thread
from shockpc.impact.impact import ColumnImpact, DoubleImpact, Impact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place
from shockpc.method.exact.proof import motion as size_of
from shockpc.text.errors import SolveError
from shockpc.wings.compliant.links.bent_landing import flexible_landing
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.filtered import filtered
from shockpc.wings.compliant.motion.laws import damper_restitution
from shockpc.wings.compliant.motion.stiff_motion import History, StiffMotion
from shockpc.wings.compliant.over_time.element_system import element_system
from shockpc.wings.compliant.over_time.linear_impact import (
    impact_of,
    impact_of_unit_forces,
    impulsive_jumps,
)

Compute = Callable[[Impact, Sequence[Place]], Any]

IMPULSE_SHARE = 0.99
"""Share of a contact's normal impulse that is given within its duration.

What follows may be a tiny force that lasts long.
"""


class CompliantLanding:
    """A landing on contacts, and on springs and rotors in its joints, of finite stiffness.

    It is computed when it is read.

    What acts is made first (`element_system`), then the motion. All else is read from these: a
    quantity at the end, its peak, its history, and how the end differs from the impulse model.
    Links that bend have hinges, which are springs like those of joints, and move only here.

    Args:
        landing: the landing.
        until: time at which the motion ends [s]; by default, when all contacts are open and stay
            so.

    Attributes:
        landing: the landing.
        moving: the same, or that with links that bend.
        system: its elements.
        motion: until that time.
        normal: (r,) which elements are normals of contacts of the scene.
        number: (r,) contact of each element; −1 for a spring or a motor in a joint.

    Raises:
        SolveError: the motion cannot be followed, or no motion of the robot has the velocities
            before the impact.
    """

    def __init__(self, landing: PosedLanding, until: float | None = None) -> None:
        self.landing = self.moving = landing
        if landing.scene.flex:
            self.moving = flexible_landing(landing)
        self.system = element_system(self.moving)
        self.number = self.system.elements.contact
        of_scene = self.number < len(self.moving.contact_places)
        self.normal = self.system.elements.normal & of_scene
        self._peaks: dict[Any, tuple[Array, Array]] = {}
        self.motion = self._simulate(until)

    def _simulate(self, until: float | None) -> StiffMotion:
        """The motion until a time [s]. Raises: SolveError: it cannot be followed."""
        system = self.system
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
            raise self._refused(refusal) from None

    def _refused(self, refusal: Exception) -> SolveError:
        """The error of a motion that cannot be followed, or of a peak that cannot be found."""
        k = self.landing.scene.contact_stiffness
        return SolveError(f"no verdict for contacts of {k:g} N/m: {refusal}")

    @memoized()
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
        motion, tail = self.motion, low_pass.tail
        if (self.number < 0).any():
            motion, tail = self._simulate(motion.duration + tail), 0.0
        return filtered(motion, low_pass, tail)

    @functools.cached_property
    def _linear(self) -> ColumnImpact:
        """An impact with the accelerations for unit forces, those of gravity, and jumps of `ends`.

        The latter are those beyond the fall with straight links, until the end of compression and
        until the end, and those of the impulse model.
        """
        system, motion = self.system, self.motion
        times, then = self.changes
        beyond_fall = []
        for k in (times.index(self.compressed), -1):
            beyond_fall.append(then.jump[k] - times[k] * system.fall)
        impulsive = impulsive_jumps(self.landing, self.moving, system, motion)
        ends = np.column_stack([*beyond_fall, impulsive])
        return impact_of_unit_forces(self.moving, system, motion, ends)

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
        points = [(place.name, place.body, place.number, place.r.tobytes()) for place in places]
        key = compute, tuple(points), low_pass
        if key not in self._peaks:
            motion = self.filtered(low_pass)
            try:
                with one_thread(len(self.number)):
                    self._peaks[key] = motion.peak(*self.readout(compute, places))
            except ArithmeticError as refusal:
                raise self._refused(refusal) from None
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
        free = self.system.free
        return np.asarray(self.motion.at(times).displacement[:, : free.shape[1]] @ free.T)

    @functools.cached_property
    def duration(self) -> Array:
        """Time (c,) by which each contact has given 99 % of its normal impulse [s]."""
        return self.motion.impulse_time(np.flatnonzero(self.normal), IMPULSE_SHARE)

    @functools.cached_property
    def stop_peaks(self) -> dict[str, float]:
        """The peak force or torque of the end stops of each joint that is at one [N, N m]."""
        system, joints, contacts = self.system, self.moving.robot.joints, self.moving.contacts
        rows, n = np.flatnonzero(system.strikes), len(system.strikes)
        names = [joints[contacts[self.number[row]].body].name for row in rows.tolist()]
        names += [stop.frame for stop in system.stops]
        rows = np.append(rows, np.arange(n, n + len(system.stops)))
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
        elements, modes, rows = self.motion.elements, self.motion.modes, self.system.rows
        largest = modes.force[self.normal].argmax(axis=1)
        omega = 2.0 * np.pi * modes.frequency[largest]
        c, k = elements.damping[self.normal], elements.stiffness[self.normal]
        # ζ = c ω / 2k
        of_dampers = damper_restitution(c * omega / (2.0 * k))
        return np.where(c > 0.0, of_dampers, rows.restitution[rows.normal])

    @functools.cached_property
    def changes(self) -> tuple[list[float], History]:
        """The times at which elements change, such as a normal that is unloaded, and the end [s].

        The second is the motion then.
        """
        times = [segment.start + segment.length for segment in self.motion.segments]
        return times, self.motion.at(np.array(times))

    @functools.cached_property
    def compressed(self) -> float:
        """Time at which the last contact ends its first compression, or the end without one [s]."""
        first = self.motion.first("unloads")[self.normal]
        return float(first[np.isfinite(first)].max(initial=0.0)) or self.motion.duration

    @memoized()
    def impact_at(self, time: float) -> DoubleImpact:
        """The changes of velocity from the impact until a time [s], with free fall.

        They are of the scene's strike, without impulses.
        """
        return impact_of(self.moving, self.system, self.motion.at(np.array([time])).jump.T)

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

        Contacts that slip or are pressed are not looked at.
        """
        elements = self.motion.elements
        return bool(np.all(elements.restitution == 0.0) and np.ptp(elements.stiffness) == 0.0)

    @functools.cached_property
    def force_shares(self) -> Array:
        """Share (c, m) of each mode in the normal force of each contact [1].

        It is its amplitude over the sum of all.
        """
        amplitude = self.motion.modes.force[self.normal]
        total = amplitude.sum(axis=1, keepdims=True)
        return np.asarray(amplitude / np.where(total > 0.0, total, 1.0))


@memoized()
def compliant_landing(landing: PosedLanding) -> CompliantLanding:
    """The landing on contacts of the scene's stiffness, with the restitution of the contacts.

    Raises:
        SolveError: the motion cannot be followed.
    """
    return CompliantLanding(landing)
