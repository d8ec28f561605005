"""Numbers of an impact over drives of which intervals are known, while the contacts hold.

With C the mobility of the joints while the contacts hold, and x the jumps of their rates, an
inertia d more on joint i gives

    x − t C_i x_i,    Y − t B_i x_i,    C − t C_i C_iᵀ,    B − t B_i C_iᵀ,        t = d / (1 + d C_ii),   held: t = 1 / C_ii

for any Y that is linear in the jumps and impulses, where B is its response to an impulse on each
joint (Sherman and Morrison's formula for H + d e_i e_iᵀ). So Y is affine in t, which grows with d:
a component of Y is largest and smallest at a corner of the box of all intervals, and |Y|, which is
convex in t, is largest at one. The smallest |Y| may be inside. Works on arrays alone.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

NEEDED = 1e-9
"""Share of its mobility, left while others are held, up to which a joint cannot be held.

The contacts need it to move."""

RAISED = 1e-9
"""Share by which a step of a climb has to raise a number."""

LOWERED = 1e-4
"""Share by which a step of a descent has to lower it."""

ZERO = 1e-6
"""Share of the number as modelled below which a descent has found zero."""

STEPS = 4
"""Steps of a climb or a descent, as a multiple of the number of joints."""


class DriveBox(NamedTuple):
    """Intervals of the drives of n joints, and how the joints move while the contacts hold.

    Attributes:
        C: (n, n) jumps of their rates for unit impulses on them, with the inertias as modelled.
        x: (n,) jumps of their rates by the impact, likewise.
        less: (n,) from the inertias as modelled to the smallest ones, not above zero [kg m², kg].
        more: (n,) from the inertias as modelled to the largest ones, not below zero; infinite where a joint may be held.
    """

    C: Array
    x: Array
    less: Array
    more: Array

    def impulses(self, change: Array) -> Array:
        """Impulses (n,) of the drives on joints whose inertias change by (n,); infinite: held.

        Of the changed joints S they are w = −(diag(1/d) + C_SS)⁻¹ x_S, with which the jumps are
        x + C w, and numbers Y + B w.
        """
        w, chosen = np.zeros(len(change)), np.flatnonzero(change)
        if len(chosen):
            w[chosen] = -np.linalg.solve(self.C[np.ix_(chosen, chosen)] + np.diag(1.0 / change[chosen]), self.x[chosen])
        return w

    @property
    def most(self) -> Array:
        """The change (n,) of the inertias as modelled to the largest ones that contacts leave possible.

        A joint that they need to move, while those before it are held, keeps its smallest inertia.
        """
        inertias = _Inertias(self, np.zeros(0), np.zeros((0, len(self.x))))
        inertias.fill()
        return inertias.change

    def largest(self, Y: Array, B: Array, size: Callable[[Array], Array] | None = None) -> Array:
        """The change (n,) of the inertias as modelled at which a number is largest, as far as found.

        It is a corner of the box.

        From the smallest inertias and from the largest ones, the drive that raises the number most
        goes to its other end, until none does.

        Args:
            Y: (m,) the vector as modelled.
            B: (m, n) its response.
            size: of vectors (m, k), the numbers (k,), convex in them; their lengths by default.
        """
        size = _lengths if size is None else size
        best, change = -np.inf, self.less
        for inertias in _starts(self, Y, B, with_modelled=False):
            for _ in range(STEPS * len(self.x)):
                _, most, V = inertias.steps()
                now, moved = size(inertias.vector[:, None])[0], size(inertias.vector[:, None] - V * most)
                i = int(np.argmax(moved))
                if not moved[i] > now + RAISED * abs(now):
                    break
                inertias.flip(i)
            if now > best:
                best, change = now, inertias.change
        return change

    def smallest(self, Y: Array, B: Array) -> Array:
        """The change (n,) of the inertias as modelled at which a length is smallest, as far as found.

        From the smallest inertias, those as modelled and the largest ones, the drive that lowers
        the length most goes to where it is lowest, until none lowers it. That may be inside the box.
        Arguments are those of `largest`.
        """
        best, change, zero = np.inf, self.less, (ZERO * np.linalg.norm(Y)) ** 2
        for inertias in _starts(self, Y, B, with_modelled=True):
            for _ in range(STEPS * len(self.x)):
                least, most, V = inertias.steps()
                now, slope, square = float(inertias.vector @ inertias.vector), inertias.vector @ V, np.sum(V**2, axis=0)
                # |Y − s V|² is lowest at s = Y·V / V·V.
                s = np.clip(slope / np.where(square > 0.0, square, 1.0), least, most)
                lowered = now + s * (s * square - 2.0 * slope)
                i = int(np.argmin(lowered))
                if now <= zero or not lowered[i] < now * (1.0 - LOWERED) ** 2:
                    break
                inertias.step(i, float(s[i]), float(least[i]), float(most[i]))
            if now < best:
                best, change = now, inertias.change
        return change


class _Inertias:
    """Inertias in a box, and what follows at them, kept from one step of a joint to the next.

    The joints S have inertias d above their smallest ones, the joints F the smallest. With C, x, Y
    and B at the smallest inertias, and K = (diag(1/d) + C_SS)⁻¹,

        M = [ −K       K C_SF               K x_S            ]
            [ C_FS K   C_FF − C_FS K C_SF   x_F − C_FS K x_S ]
            [ B_S K    B_F − B_S K C_SF     Y − B_S K x_S    ]

    A joint joins S, or leaves it, by a principal pivot of M. One whose 1/d grows by e adds
    s M_i M_iᵀ to M, with s = e / (1 + e K_ii).
    """

    def __init__(self, box: DriveBox, Y: Array, B: Array) -> None:
        n = len(box.x)
        self.M = np.block([[box.C, box.x[:, None]], [B, Y[:, None]]])
        self.d, self.less, self.mobility = np.zeros(n), box.less.copy(), np.diagonal(box.C).copy()
        for i in np.flatnonzero(self.less < 0.0).tolist():
            share = 1.0 + self.less[i] * self.M[i, i]
            if share > NEEDED:
                self.M = self.M - np.outer(self.M[:, i], self.M[i]) * (self.less[i] / share)
            else:
                self.less[i] = 0.0  # nothing else would resist the joint's motion
        self.span = box.more - self.less
        self.inverse_span = 1.0 / self.span

    @property
    def change(self) -> Array:
        """The inertias (n,) less those as modelled."""
        return np.asarray(self.less + self.d)

    @property
    def vector(self) -> Array:
        """Y (m,)."""
        return np.asarray(self.M[len(self.d) :, -1])

    def steps(self) -> tuple[Array, Array, Array]:
        """What the inertia of each joint alone changes: Y − s V_i, with s from `least` to `most`.

        Returns: least (n,), at the largest inertia of a joint that has some, else zero; most (n,),
            at the other end of its interval; V (m, n).
        """
        n, on = len(self.d), self.d > 0.0
        diagonal = np.diagonal(self.M)[:n]
        V = self.M[n:, :n] * np.where(on, -self.M[:n, -1], self.M[:n, -1])
        e = self.inverse_span - 1.0 / np.where(on, self.d, self.span)
        least = np.where(on, e / (1.0 - e * diagonal), 0.0)
        # Without its drive a joint has s = 1 / K_ii; with the largest one t = 1 / (1/d + C_ii).
        exists = on | (self.inverse_span > 0.0) | (diagonal > NEEDED * self.mobility)
        divisor = np.where(on, -diagonal, self.inverse_span + diagonal)
        return least, np.where(exists, 1.0 / np.where(exists, divisor, 1.0), 0.0), V

    def flip(self, i: int) -> None:
        """Take joint i to the other end of its interval."""
        if self.d[i] > 0.0:
            self._pivot(i, self.M[i, i])
            self.M[i, i] -= 1.0 / self.d[i]
            self.d[i] = 0.0
        else:
            self._set(i, self.span[i])

    def step(self, i: int, s: float, least: float, most: float) -> None:
        """Take joint i to where its inertia changes Y by −s V_i; the ends of s are as `steps` gives them."""
        on = self.d[i] > 0.0
        if s == most:
            self.flip(i)
        elif on:
            inverse = self.inverse_span[i] if s == least else 1.0 / self.d[i] + s / (1.0 + s * self.M[i, i])
            self.M = self.M + s * np.outer(self.M[:, i], self.M[i])
            self.d[i] = 1.0 / inverse if inverse > 0.0 else np.inf
        else:
            self._set(i, 1.0 / (1.0 / s - self.M[i, i]))

    def fill(self) -> None:
        """Take every joint to its largest inertia, but those that the contacts need to move."""
        for i in range(len(self.d)):
            if self.inverse_span[i] > 0.0 or self.M[i, i] > NEEDED * self.mobility[i]:
                self._set(i, self.span[i])

    def to(self, d: Array) -> None:
        """Give joints without an inertia above the smallest one some (n,)."""
        for i in np.flatnonzero(d).tolist():
            self._set(i, d[i])

    def _set(self, i: int, d: float) -> None:
        self._pivot(i, self.M[i, i] + 1.0 / d)
        self.d[i] = d

    def _pivot(self, i: int, pivot: float) -> None:
        """The principal pivot of M at joint i: joints S have K where the others have C."""
        row, column = self.M[i] / abs(pivot), self.M[:, i] / abs(pivot)
        self.M = self.M - np.outer(self.M[:, i], self.M[i]) / pivot
        self.M[i], self.M[:, i] = row, column
        self.M[i, i] = -1.0 / pivot


def _starts(box: DriveBox, Y: Array, B: Array, with_modelled: bool) -> list[_Inertias]:
    """Where a search starts: the smallest inertias, the largest, and those as modelled if asked."""
    low, high, modelled = (_Inertias(box, Y, B) for _ in range(3))
    high.fill()
    modelled.to(-modelled.less)
    return [low, high, *([modelled] if with_modelled and modelled.d.any() else [])]


def _lengths(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=0))
