"""The state of a landing on elements of finite stiffness at an event, and what changes there."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.crossing import Effort
from shockpc.wings.compliant.motion.events import LOADING, OPEN, UNFELT, UNLOADING, EventKind
from shockpc.wings.compliant.motion.loaded import Loaded, loaded_elements
from shockpc.wings.compliant.motion.system import ScaledSystem


class State:
    """Phases of the elements at an event, and the velocity then.

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

    def __init__(self, system: ScaledSystem) -> None:
        elements, r = system.elements, len(system.W)
        self.system, self.effort = system, Effort()
        self.slope = system.slope.copy()
        self.z, self.peak, self.largest, self.gap = np.zeros((4, r))
        sprung = system.sprung
        self.z[sprung] = -elements.load[sprung] / self.slope[sprung]
        self.jump, self.displacement = np.zeros((2, len(system.u)))
        self.slow, self.slipped = np.zeros((2, r), dtype=bool)
        closing = elements.contact[system.approaches]
        strikes = np.any(elements.contact == closing[:, None], axis=0)
        self.phase = np.where((elements.contact < 0) | strikes, LOADING, OPEN)

    @property
    def u(self) -> Array:
        """The coordinates (d,) now."""
        return np.asarray(self.system.u + self.jump)

    @property
    def separated(self) -> bool:
        """True if all contacts are open."""
        return not (self.phase[self.system.grounded] != OPEN).any()

    @property
    def held(self) -> np.ndarray:
        """Mask (r,) of the rows that are held."""
        return np.asarray((self.phase == UNLOADING) & self.system.rigid)

    @property
    def sprung(self) -> np.ndarray:
        """Mask (r,) of the rows with a spring that is loaded."""
        return np.asarray((self.phase != OPEN) & ~self.held & self.system.sprung)

    def loaded(self, dampers: bool = True) -> Loaded:
        """Quantities that depend on which elements are loaded now.

        Args: dampers, whether those act.
        """
        held, sprung, slope = self.held.tobytes(), self.sprung.tobytes(), self.slope.tobytes()
        return loaded_elements(self.system, held, sprung, slope, dampers)

    def switch(self, i: int, kind: EventKind) -> EventKind:
        """Let an event happen to element i; returns what it is in full.

        A contact that would open may slip first.
        """
        if kind in UNFELT:
            self.slow[i] |= kind is EventKind.SLOWS
        elif kind is EventKind.UNLOADS:
            self._unload(i)
        elif kind in (EventKind.RELOADS, EventKind.REVERSES):
            self._load_again(i, kind)
        elif kind is EventKind.CLOSES:
            self._close(i)
        else:
            return self._open(i)
        return kind

    def _restitution(self, i: int) -> float:
        """The e of an element; 1 of one that is held, which has no slope of unloading."""
        return 1.0 if self.system.rigid[i] else float(self.system.elements.restitution[i])

    def _unload(self, i: int) -> None:
        """Unload an element: the force, slope · z, stays; its energy z² / 2 becomes e² z² / 2."""
        e = self._restitution(i)
        self.phase[i] = UNLOADING
        self.slope[i] /= e
        self.z[i] *= e
        self.peak[i] = self.z[i]
        self.largest[i] = max(self.largest[i], self.slope[i] * abs(self.z[i]))

    def _load_again(self, i: int, kind: EventKind) -> None:
        """Load an element that is unloaded: in the other direction, or from its peak."""
        e = self._restitution(i)
        self.phase[i] = LOADING
        self.slope[i] *= e
        if kind is EventKind.REVERSES:
            self.z[i] = 0.0
        elif self.system.rigid[i]:
            # The force of a row that is held jumps where another one is held too; the row is then
            # loaded from its peak.
            self.z[i] = self.peak[i]
        else:
            self.z[i] /= e

    def _close(self, i: int) -> None:
        """Close the contact of normal i, on ground that one with a damper may have compressed."""
        gap = self.gap[i]
        self._release(self._rows_of_contact(i), LOADING)
        self.slipped[i] = False
        if self.system.elements.damping[i] > 0.0:
            self.z[i], self.largest[i] = self.slope[i] * gap, 0.0

    def _open(self, i: int) -> EventKind:
        """Open the contact of normal i, or its tangents alone where it slips."""
        system, rows = self.system, self._rows_of_contact(i)
        tangents = rows & ~system.elements.normal
        may_slip = bool(system.rigid[i]) or system.elements.damping[i] > 0.0
        self.slipped[i] = may_slip and bool(np.any(self.phase[tangents] != OPEN))
        if self.slipped[i]:
            self._release(tangents, OPEN)
            return EventKind.SLIPS
        gap = self.z[i] / system.slope[i]
        self._release(rows, OPEN)
        if system.elements.damping[i] > 0.0:
            # The ground under a contact with a damper keeps its place.
            self.gap[i] = gap
        return EventKind.OPENS

    def _rows_of_contact(self, i: int) -> np.ndarray:
        """Mask (r,) of the rows of the contact that row i belongs to."""
        contact = self.system.elements.contact
        return np.asarray(contact == contact[i])

    def _release(self, rows: np.ndarray, phase: int) -> None:
        """Let rows be without force, in a phase from now on."""
        self.phase[rows] = phase
        self.z[rows], self.gap[rows] = 0.0, 0.0
        self.slope[rows] = self.system.slope[rows]
        self.slow[rows] = False
