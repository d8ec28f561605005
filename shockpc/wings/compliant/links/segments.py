"""A slender body that bends, as rigid segments joined by springs.

These finite segments keep mass, centre of mass and inertia.

A body of length L gets n hinges at (i + ½) L/n along its axis. Each bends about the two axes across
it with the stiffness EI n/L; where they are given, it also stretches along the axis with EA n/L and
twists about it with GJ n/L. Of the mass along the axis the body's inertia gives three moments,
which a uniform tube with a lump at each end has, or with lumps elsewhere. Across the axis all
segments are alike, so that the inertia of the whole is that of the body.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, cross_matrix

LEAST_TUBE = 0.01
"""Least share of the mass of a tube beside two lumps.

Below it segments between them would have next to none.
"""

ROUNDING = 1e-15
"""Share of the mass that counts as rounding."""

FINE = 12
"""Hinges of the division with which a frequency is converted to a bending stiffness."""


class Division(NamedTuple):
    """A body in n + 1 segments with n hinges between them; all in the body's frame.

    Attributes:
        axis: (3,) unit vector from the joint along the body.
        along: (n,) how far the hinges are along it, from the origin of the frame [m].
        hinges: (n, 3) the hinges [m].
        spacing: length of the body that each hinge stands for [m].
        mass: (n + 1,) of the segments [kg].
        com: (n + 1, 3) their centres of mass [m].
        inertia: (n + 1, 3, 3) about these [kg m²].
    """

    axis: Array
    along: Array
    hinges: Array
    spacing: float
    mass: Array
    com: Array
    inertia: Array

    @property
    def across(self) -> Array:
        """(2, 3) unit vectors across the axis, about which the body bends."""
        first = np.cross(self.axis, np.eye(3)[np.abs(self.axis).argmin()])
        first /= np.linalg.norm(first)
        return np.array([first, np.cross(self.axis, first)])


def divide(
    mass: float, com: Array, inertia: Array, start: Array, end: Array, hinges: int
) -> Division:
    """Divide a body along the line from one point to another.

    Args:
        mass: of the body [kg].
        com: (3,) its centre of mass [m].
        inertia: (3, 3) about that [kg m²].
        start: (3,) where it begins, its joint [m].
        end: (3,) where it ends [m].
        hinges: their number n.

    Raises:
        ValueError: the body has no mass, or no extent along the line.
    """
    length = float(np.linalg.norm(end - start))
    axis, spacing = (end - start) / length, length / hinges
    along = spacing * (np.arange(hinges) + 0.5)
    body = _along_axis(mass, com, inertia, start, axis)
    if not body.variance > 1e-9 * length**2:
        raise ValueError("has no mass, or no extent along its axis")
    line = _line(body.centre, body.variance, length)
    segments = []
    for low, high in itertools.pairwise([-np.inf, *along.tolist(), np.inf]):
        share, middle, variance = _moments(line, low, high)
        # I = tr(S) 1 − S of the second moments S, along the line of the centres and across it.
        S = mass * share * (variance * np.outer(body.slope, body.slope) + body.across)
        centre = com + body.slope * (middle - body.centre)
        segments.append((mass * share, centre, np.trace(S) * np.eye(3) - S))
    masses, coms, inertias = map(np.array, zip(*segments, strict=True))
    hinge_points = start + along[:, None] * axis
    return Division(axis, hinge_points @ axis, hinge_points, spacing, masses, coms, inertias)


class _AlongAxis(NamedTuple):
    """The mass of a body along an axis, and what is across it.

    Attributes:
        centre: of mass, from the start of the axis [m].
        variance: of the mass along the axis [m²].
        slope: (3,) of the line on which the centres of mass of segments lie, which leaves the
            products of inertia as they are; 1 along the axis.
        across: (3, 3) second moments across that line, over the mass [m²].
    """

    centre: float
    variance: float
    slope: Array
    across: Array


def _along_axis(mass: float, com: Array, inertia: Array, start: Array, axis: Array) -> _AlongAxis:
    """The mass of a body along an axis. Args: as of `divide`, and the unit vector of the axis."""
    # Second moments of the mass ∫ r rᵀ dm / m = (½ tr(I) 1 − I) / m
    second = np.zeros((3, 3))
    if mass > 0.0:
        second = (0.5 * np.trace(inertia) * np.eye(3) - inertia) / mass
    variance = float(axis @ second @ axis)
    slope = np.zeros(3)
    if variance > 0.0:
        slope = second @ axis / variance
    across = second - variance * np.outer(slope, slope)
    return _AlongAxis(float(axis @ (com - start)), variance, slope, across)


def _moments(line: Array, low: float, high: float) -> tuple[float, float, float]:
    """Share of the mass of a line between two points, its middle [m] and variance [m²].

    Args: line, rows as of `_line`.
    """
    share, a, b = line.T
    lump = b == a
    inside = np.clip(b, low, high) - np.clip(a, low, high)
    has_lump = (a >= low) & (a < high)
    length = np.where(lump, 1.0, b - a)
    part = np.where(lump, has_lump, inside / length)
    weight = share * part
    a = np.where(lump, a, np.clip(a, low, high))
    b = np.where(lump, b, np.clip(b, low, high))
    # Of mass uniform from a to b the mean of x is (a + b) / 2, that of x² (a² + a b + b²) / 3.
    total = weight.sum()
    middle = weight @ (a + b) / 2.0 / total
    square = weight @ (a * a + a * b + b * b) / 3.0 / total
    variance = square - middle**2
    return total, middle, variance


def _line(centre: float, variance: float, length: float) -> Array:
    """Rows of mass along an axis with given moments, and from where to where each is uniform [m].

    The mass is 1.

    It is a tube of the whole length, so that no segment is without mass, and two lumps equally far
    from its middle: at its ends, or, where one of these would be negative, a single lump, or, where
    the tube would, lumps beyond the ends.
    """
    off, tube_variance = centre - length / 2.0, length**2 / 12.0
    about_middle = off**2 + variance
    # The share of the tube with lumps at the ends, and with a single lump.
    at_ends = (length**2 / 4.0 - about_middle) / (length**2 / 6.0)
    both = about_middle + tube_variance
    root = math.sqrt(max(both**2 - 4.0 * tube_variance * variance, 0.0))
    single = 2.0 * variance / (both + root)
    tube = min(max(at_ends, LEAST_TUBE), single)

    lumps, apart = 1.0 - tube, 0.0
    if lumps > ROUNDING:
        apart = math.sqrt(max(about_middle - tube * tube_variance, 0.0) / lumps)
    uneven = off / apart if apart > 0.0 else 0.0
    near, far = length / 2.0 - apart, length / 2.0 + apart
    return np.array(
        [
            (tube, 0.0, length),
            (lumps / 2.0 - uneven / 2.0, near, near),
            (lumps / 2.0 + uneven / 2.0, far, far),
        ]
    )


def chain_inertia(division: Division) -> Array:
    """Inertia (6 + 2n, 6 + 2n) of a body that bends.

    It is that of its twist (ω, v at the origin), then of the angles of its hinges.
    """
    n, across = len(division.along), division.across
    axes, hinges = np.tile(across, (n, 1)), np.repeat(division.hinges, 2, axis=0)
    M = np.zeros((6 + 2 * n, 6 + 2 * n))
    for k, (m, com, inertia) in enumerate(
        zip(division.mass, division.com, division.inertia, strict=True)
    ):
        carried = (np.arange(2 * n) < 2 * k)[:, None]
        omega = np.concatenate([np.eye(3), np.zeros((3, 3)), np.where(carried, axes, 0.0)])
        v = np.concatenate(
            [cross_matrix(com), np.eye(3), np.where(carried, np.cross(axes, com - hinges), 0.0)]
        )
        M += omega @ inertia @ omega.T + m * v @ v.T
    return M


def elastic_frequencies(M: Array, rows: Array, stiffness: Array) -> Array:
    """Frequencies (k,) with which a system swings on k springs, from the lowest [Hz].

    Args:
        M: (n, n) inertia.
        rows: (k, n) speeds of the springs for unit velocities.
        stiffness: (k,) of the springs.
    """
    values, vectors = np.linalg.eigh(M)
    # a slender body has no inertia about its axis, and no spring turns it so
    moved = values > ROUNDING * values[-1]
    # The singular values of √k B V / √λ, with M = V λ Vᵀ, are the angular frequencies.
    scaled = np.sqrt(stiffness)[:, None] * rows
    factor = scaled @ (vectors[:, moved] / np.sqrt(values[moved]))
    return np.asarray(np.linalg.svd(factor, compute_uv=False)[::-1] / (2.0 * math.pi))


def bending_frequency(division: Division, EI: float, clamped: bool) -> float:
    """The first bending frequency of a body [Hz], free at both ends, or clamped at its joint."""
    M, n = chain_inertia(division), 2 * len(division.along)
    M = M[6:, 6:] if clamped else M
    rows = np.eye(len(M))[-n:]
    stiffness = np.full(n, EI / division.spacing)
    return float(elastic_frequencies(M, rows, stiffness)[0])


def bending_stiffness(frequency: float, clamped: bool, fine: Division) -> float:
    """The EI [N m²] of a body with a first bending frequency [Hz].

    Args: fine, its division by `FINE` hinges.
    """
    return (frequency / bending_frequency(fine, 1.0, clamped)) ** 2
