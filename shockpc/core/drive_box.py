"""Numbers of an impact over drives of which intervals are known, while the contacts hold.

With C the mobility of the joints while the contacts hold, and x the jumps of their rates, an
inertia d more on joint i gives

    x − t C_i x_i,   Y − t B_i x_i,   C − t C_i C_iᵀ,   B − t B_i C_iᵀ,
    t = d / (1 + d C_ii),   held: t = 1 / C_ii

for any Y that is linear in the jumps and impulses, where B is its response to an impulse on each
joint (Sherman and Morrison's formula for H + d e_i e_iᵀ). So Y is affine in t, which grows with d:
a component of Y is largest and smallest at a corner of the box of all intervals, and |Y|, which is
convex in t, is largest at one. The smallest |Y| may be inside. Works on arrays alone.
"""

import copy
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

NEEDED = 1e-9
"""Share of its mobility without contacts, left with them and with others held, up to which a joint
cannot be held.

Contacts and the others hold it already, or need it to move."""

ALL_CORNERS, MOST_CORNERS = 8, 12
"""Joints up to which all corners of a box are computed; with more, corners are climbed.

More where contacts leave few joints to be held: then all of these hold the robot alike, whichever
they are, and a climb ends there."""

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
        more: (n,) from there to the largest ones, not below zero; infinite where a joint may be
            held.
        mobility: (n,) diagonal of C without contacts.
    """

    C: Array
    x: Array
    less: Array
    more: Array
    mobility: Array

    def impulses(self, change: Array) -> Array:
        """Impulses (n,) of the drives on joints whose inertias change by (n,); infinite: held.

        Of the changed joints S they are w = −(diag(1/d) + C_SS)⁻¹ x_S, with which the jumps are
        x + C w, and numbers Y + B w.
        """
        w = np.zeros(len(change))
        S = np.flatnonzero(change)
        if len(S):
            resisting = self.C[np.ix_(S, S)] + np.diag(1.0 / change[S])
            w[S] = -np.linalg.solve(resisting, self.x[S])
        return w

    @property
    def least(self) -> Array:
        """The change (n,) to the smallest inertias with which all motion still meets resistance."""
        return _Inertias(self, np.zeros(0), np.zeros((0, len(self.x)))).change

    @property
    def most(self) -> Array:
        """The change (n,) to the largest inertias that the contacts leave possible.

        A joint that they need to move, while those before it are held, keeps its smallest inertia.
        """
        inertias = _Inertias(self, np.zeros(0), np.zeros((0, len(self.x))))
        inertias.fill(range(len(self.x)))
        return inertias.change

    def lengths(self, Y: Array, B: Array) -> tuple[Array, Array]:
        """The changes (n,) of the inertias as modelled at which |Y| is smallest and largest.

        Both as far as found: the smallest, which may be inside the box, from the smallest inertias,
        those as modelled and the largest ones; the largest from the smallest and the largest ones.
        Of few joints, the largest is that of all corners.

        Args:
            Y: (m,) the vector as modelled.
            B: (m, n) its response.
        """
        low, high, modelled = _starts(self, Y, B)
        starts = [low, high]
        if modelled.d.any():
            starts.append(modelled)
        zero = ZERO * float(np.linalg.norm(Y))
        lowest = min((_lowered(start.copy(), zero) for start in starts), key=_length)
        highest = max(_tops(low, high, _lengths), key=_length)
        return lowest.change, highest.change

    def values(self, Y: Array, B: Array) -> tuple[Array, Array]:
        """The changes (n,) at which a number is smallest and largest, as far as found: corners.

        Args:
            Y: (1,) the number as modelled.
            B: (1, n) its response.
        """
        low, high, _ = _starts(self, Y, B)
        lowest = min(_tops(low, high, _opposites), key=_number)
        highest = max(_tops(low, high, _numbers), key=_number)
        return lowest.change, highest.change

    def deciding(self, Y: Array, B: Array, end: Array, nearly: float) -> list[int]:
        """The joints that account for nearly all of the way of |Y| to its value at an end.

        They are ordered by what |Y| loses of the way when one of them is as modelled again, the
        largest first, and are the fewest in this order with which it comes near the end.

        Args:
            Y: (m,) the vector as modelled.
            B: (m, n) its response.
            end: (n,) the change of the inertias there.
            nearly: share of the way that may be left.
        """
        S = np.flatnonzero(end)
        A = self.C[np.ix_(S, S)] + np.diag(1.0 / end[S])
        x = self.x[S]
        B = B[:, S]
        K = np.linalg.inv(A)
        w = -K @ x
        Y_end = Y + B @ w
        start = float(np.linalg.norm(Y))
        value = float(np.linalg.norm(Y_end))

        # Without joint i the others have w − K_i w_i / K_ii.
        without = Y_end[:, None] - (B @ K) * (w / np.diagonal(K))
        order = np.argsort(-np.abs(_lengths(without) - value), kind="stable")
        for k in range(1, len(order) + 1):
            first = order[:k]
            impulses = -np.linalg.solve(A[np.ix_(first, first)], x[first])
            reached = float(np.linalg.norm(Y + B[:, first] @ impulses))
            if abs(reached - value) <= nearly * abs(value - start):
                break
        return [int(i) for i in S[order[:k]]]


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
        self.M = np.concatenate([np.column_stack([box.C, box.x]), np.column_stack([B, Y])])
        self.d = np.zeros(n)
        self.less = self._to_smallest(box.less)
        self.span = box.more - self.less
        self.inverse_span = 1.0 / self.span
        self.left = np.where(np.isinf(self.span), NEEDED * box.mobility, 0.0)
        # Of joints S: sign −1, and no rest; of the others 1, and 1/d of their largest inertia.
        self.sign = np.ones(n)
        self.rest = self.inverse_span.copy()
        self.floor = self.left.copy()

    def _to_smallest(self, less: Array) -> Array:
        """Take M to the smallest inertias with which something resists all motion: the changes."""
        less = less.copy()
        for i in np.flatnonzero(less < 0.0).tolist():
            share = 1.0 + less[i] * self.M[i, i]
            if share > NEEDED:
                self.M -= np.outer(self.M[:, i], self.M[i]) * (less[i] / share)
            else:
                less[i] = 0.0  # nothing else would resist the joint's motion
        return less

    def copy(self) -> "_Inertias":
        """A copy of the inertias, to be changed separately."""
        copied = copy.copy(self)
        for name in ("M", "d", "sign", "rest", "floor"):
            setattr(copied, name, getattr(self, name).copy())
        return copied

    @property
    def change(self) -> Array:
        """The inertias (n,) less those as modelled."""
        return np.asarray(self.less + self.d)

    @property
    def vector(self) -> Array:
        """Y (m,)."""
        return np.asarray(self.M[len(self.d) :, -1])

    def steps(self) -> tuple[Array, Array]:
        """The change of Y by the inertia of each joint alone: Y − s V_i, with s from zero to most.

        Returns: most (n,), at the other end of its interval, zero where it cannot be held; V (m,
        n).
        """
        n = len(self.d)
        x = self.M[:n, -1]
        V = self.M[n:, :n] * (self.sign * x)
        # Without its drive a joint of S has s = 1 / K_ii; one of F gets t = 1 / (1/d + C_ii).
        diagonal = self.M.diagonal()[:n]
        divisor = self.sign * diagonal + self.rest
        most = np.zeros(n)
        np.divide(1.0, divisor, out=most, where=divisor > self.floor)
        return most, V

    def least(self) -> Array:
        """The step (n,) of each joint of S to its largest inertia, not above zero; else zero."""
        in_S = self.d > 0.0
        inverse = 1.0 / np.where(in_S, self.d, 1.0)
        e = np.where(in_S, self.inverse_span - inverse, 0.0)
        K_ii = self.M.diagonal()[: len(e)]
        return np.asarray(e / (1.0 - e * K_ii))

    def flip(self, i: int) -> None:
        """Take joint i to the other end of its interval."""
        if self.d[i] <= 0.0:
            self.set(i, self.span[i])
            return
        self._pivot(i, self.M[i, i])
        self.M[i, i] -= 1.0 / self.d[i]
        self.d[i] = 0.0
        self.sign[i] = 1.0
        self.rest[i] = self.inverse_span[i]
        self.floor[i] = self.left[i]

    def step(self, i: int, s: float, least: float, most: float) -> None:
        """Take joint i to where its inertia changes Y by −s V_i, with s from least to most."""
        if s == most:
            self.flip(i)
        elif self.d[i] > 0.0:
            inverse = self.inverse_span[i]
            if s > least:
                inverse = 1.0 / self.d[i] + s / (1.0 + s * self.M[i, i])
            self.M = self.M + s * np.outer(self.M[:, i], self.M[i])
            self.d[i] = 1.0 / inverse if inverse > 0.0 else np.inf
        else:
            inverse, largest = 1.0 / s - self.M[i, i], self.span[i]
            # Just below the largest step, rounding may take it past the end of the interval.
            self.set(i, 1.0 / inverse if inverse > self.inverse_span[i] else largest)

    def fill(self, joints: Iterable[int]) -> None:
        """Take joints to their largest inertias, but those that the contacts need to move."""
        for i in joints:
            if self.M[i, i] + self.inverse_span[i] > self.left[i]:
                self.set(i, self.span[i])

    def set(self, i: int, d: float) -> None:
        """Give joint i, which has its smallest inertia, one that is larger by d."""
        self._pivot(i, self.M[i, i] + 1.0 / d)
        self.d[i] = d
        self.sign[i] = -1.0
        self.rest[i] = 0.0
        self.floor[i] = 0.0

    def _pivot(self, i: int, pivot: float) -> None:
        """The principal pivot of M at joint i: joints S have K where the others have C."""
        row = self.M[i] / abs(pivot)
        column = self.M[:, i] / abs(pivot)
        self.M -= np.outer(self.M[:, i] / pivot, self.M[i])
        self.M[i] = row
        self.M[:, i] = column
        self.M[i, i] = -1.0 / pivot


def _starts(box: DriveBox, Y: Array, B: Array) -> tuple[_Inertias, _Inertias, _Inertias]:
    """Where searches start: the smallest inertias, the largest ones, and those as modelled."""
    low = _Inertias(box, Y, B)
    high, modelled = low.copy(), low.copy()
    high.fill(range(len(low.d)))
    for i in np.flatnonzero(low.less).tolist():
        modelled.set(i, -low.less[i])
    return low, high, modelled


def _tops(low: _Inertias, high: _Inertias, size: Callable[[Array], Array]) -> list[_Inertias]:
    """Corners of which one has the largest number, as far as found.

    Args:
        low: at the smallest inertias.
        high: at the largest ones.
        size: of vectors (m, k), the numbers (k,), convex in them.
    """
    n = len(low.d)
    few_can_be_held = bool(np.any(np.isinf(high.span) & (high.d == 0.0)))
    if n > (MOST_CORNERS if few_can_be_held else ALL_CORNERS):
        return [_raised(start.copy(), size) for start in (low, high)]
    corner = int(size(_at_corners(low).T).argmax())
    top = low.copy()
    top.fill(i for i in range(n) if corner >> i & 1)
    return [top]


def _at_corners(low: _Inertias) -> Array:
    """The vector (2ⁿ, m) at all corners; bit i of its index is set where joint i is at the top."""
    n = len(low.d)
    M = low.M[None]
    for i in range(n):
        # M − t M_i M_iᵀ with t = 1 / (1/d + M_ii), or M where joint i cannot be held.
        divisor = M[:, i, i] + low.inverse_span[i]
        exists = divisor > low.left[i]
        t = np.where(exists, 1.0 / np.where(exists, divisor, 1.0), 0.0)
        column = M[:, :, i, None]
        row = M[:, i, None, :]
        M = np.concatenate([M, M - t[:, None, None] * column * row])
    return np.asarray(M[:, n:, -1])


def _raised(inertias: _Inertias, size: Callable[[Array], Array]) -> _Inertias:
    """Inertias at which no other end of a single interval makes a number larger.

    Args:
        inertias: the start; they are changed.
        size: of vectors (m, k), the numbers (k,), convex in them.
    """
    for _ in range(STEPS * len(inertias.d)):
        now = inertias.vector[:, None]
        most, V = inertias.steps()
        moved = size(now - V * most)
        i, value = int(moved.argmax()), float(size(now)[0])
        if not moved[i] > value + RAISED * abs(value):
            break
        inertias.flip(i)
    return inertias


def _lowered(inertias: _Inertias, zero: float) -> _Inertias:
    """Inertias at which no other one of a single joint makes a length clearly smaller.

    Args:
        inertias: the start; they are changed.
        zero: the length that counts as zero.
    """
    for _ in range(STEPS * len(inertias.d)):
        most, V = inertias.steps()
        least = inertias.least()
        Y = inertias.vector
        yy = float(Y @ Y)
        yv = Y @ V
        vv = np.einsum("ik,ik->k", V, V)
        # |Y − s V|² = yy + s (s vv − 2 yv) is lowest at s = yv / vv.
        s = np.clip(yv / np.where(vv > 0.0, vv, 1.0), least, most)
        lowered = yy + s * (s * vv - 2.0 * yv)
        i = int(lowered.argmin())
        clearly = lowered[i] < yy * (1.0 - LOWERED) ** 2
        if yy <= zero**2 or not clearly:
            break
        inertias.step(i, float(s[i]), float(least[i]), float(most[i]))
    return inertias


def _length(inertias: _Inertias) -> float:
    return float(np.linalg.norm(inertias.vector))


def _number(inertias: _Inertias) -> float:
    return float(inertias.vector[0])


def _lengths(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ik,ik->k", vectors, vectors)))


def _numbers(vectors: Array) -> Array:
    return np.asarray(vectors[0])


def _opposites(vectors: Array) -> Array:
    return np.asarray(-vectors[0])
