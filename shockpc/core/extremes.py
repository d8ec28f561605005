"""The minimum and the maximum of |Δv + Δω × r| over the geometry of bodies.

Geometry is a union of convex pieces: the hull of some points, or an ellipsoid swept along a segment
(a sphere, a capsule; a cylinder, whose ellipsoid is flat, a disc). The part of Δv(r) along Δω is
the same at all r; the part across it maps a piece linearly to a set in a plane, a polygon or a
swept ellipse, so that what is sought are this set's points farthest from the origin and nearest to
it. The farthest is a corner of the polygon, or on an ellipse at an end; the nearest is found by
Wolfe's algorithm (`_distances`) or on an ellipse (`_to_ellipses`), for all pieces of all bodies at
once.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array, cross_matrix

TINY = 1e-300
"""Divisors are at least this."""

MOST_NUMBERS = 1_000_000
"""Points times landings that are computed at once."""


class Pieces(NamedTuple):
    """Convex pieces of bodies, one after the other.

    Attributes:
        points: (k, 3) points that span the pieces, each in its body's frame [m]; of a round piece
            four: the ends of the segment, a and b, as a, b, a, b.
        start: (n,) where each piece's points begin; every piece has at least one.
        rounding: (n, 3, 3) semi-axes of each piece's ellipsoid in orthogonal columns [m]; zero for
            the hull of points.
        body: (n,) index of the body each piece belongs to, ascending.
        piece: (k,) the piece each point belongs to.
        round: (m,) the pieces whose rounding is not zero.
    """

    points: Array
    start: np.ndarray
    rounding: Array
    body: np.ndarray
    piece: np.ndarray
    round: np.ndarray

    @staticmethod
    def of(bodies: list[list[tuple[Array, Array]]]) -> "Pieces":
        """Join the pieces of all bodies.

        Args:
            bodies: for each of them a list of (points (k, 3), semi-axes (3, 3)) [m].

        Raises:
            ValueError: a round piece has more than two points.
        """
        spans: list[Array] = []
        semi_axes: list[Array] = []
        owners: list[int] = []
        is_round: list[bool] = []
        for body, pieces in enumerate(bodies):
            for points, rounding in pieces:
                is_round.append(bool(rounding.any()))
                if is_round[-1] and len(points) > 2:
                    raise ValueError(
                        "an ellipsoid is swept along a segment only: a round piece has one point "
                        "or two"
                    )
                spans.append(np.resize(points, (4, 3)) if is_round[-1] else points)
                semi_axes.append(rounding)
                owners.append(body)
        counts = np.array([len(points) for points in spans], dtype=int)
        return Pieces(
            points=np.concatenate([np.zeros((0, 3)), *spans]),
            start=np.cumsum(counts) - counts,
            rounding=np.array(semi_axes, dtype=float).reshape(-1, 3, 3),
            body=np.array(owners, dtype=int),
            piece=np.repeat(np.arange(len(spans)), counts),
            round=np.flatnonzero(is_round),
        )


def shock_extremes(
    delta_omega: Array, delta_v: Array, pieces: Pieces, v_in: float
) -> tuple[Array, Array]:
    """Compute the minimum and the maximum of |Δv + Δω × r| / v_in over every body.

    Args:
        delta_omega: (nb, 3) jump of angular velocity, body axes [rad/s].
        delta_v: (nb, 3) jump of velocity of the body frame's origin, body axes [m/s].
        pieces: the pieces of the bodies.
        v_in: speed of the strike [m/s].

    Returns: minimum (nb,), maximum (nb,) [1], right to 1e-15 of (|Δv| + |Δω| |r|) / v_in at the
        farthest point r; NaN for a body without pieces, and where an input is NaN.
    """
    along, offset, turning = _across(delta_omega, delta_v)
    p = _images(offset, turning, pieces)
    farthest = np.sqrt(np.maximum.reduceat(_dot(p, p), pieces.start))
    nearest = np.full(len(pieces.start), np.inf)
    if pieces.round.size:
        corners = pieces.start[pieces.round] + np.arange(4)[:, None]
        M = turning[pieces.body[pieces.round]] @ pieces.rounding[pieces.round]
        far, near = _to_ellipses(p[:, corners[:2]], M)
        farthest[pieces.round] = far.max(axis=0)
        nearest[pieces.round] = near.min(axis=0)
        p[:, corners] += _to_tangents(p[:, corners[0]] - p[:, corners[1]], M)
    nearest = np.minimum(nearest, _distances(p, pieces))

    # The part along Δω is the same at all points of a body.
    minimum = np.full(len(along), np.nan)
    maximum = np.full(len(along), np.nan)
    bodies, first = np.unique(pieces.body, return_index=True)
    along_pieces = along[pieces.body]
    minimum[bodies] = np.minimum.reduceat(np.hypot(nearest, along_pieces), first) / v_in
    maximum[bodies] = np.maximum.reduceat(np.hypot(farthest, along_pieces), first) / v_in
    return minimum, maximum


def _images(offset: Array, turning: Array, pieces: Pieces) -> Array:
    """The points p = offset + turning · r (2, k) in the plane, of all pieces' points r.

    Args: offset (nb, 2) and turning (nb, 2, 3), as `_across` gives them.
    """
    body = pieces.body[pieces.piece]
    x, y, z = pieces.points.T
    p = np.empty((2, len(body)))
    for k in range(2):
        ex, ey, ez = turning[:, k].T
        turned = ex[body] * x + ey[body] * y + ez[body] * z
        p[k] = offset[:, k][body] + turned
    return p


def maximum_shock(delta_omega: Array, delta_v: Array, pieces: Pieces) -> Array:
    """The largest |Δv + Δω × r| over one body in many landings [m/s], as in `shock_extremes`.

    Args:
        delta_omega: (..., 3) jumps of angular velocity, body axes [rad/s].
        delta_v: (..., 3) jumps of velocity of the body frame's origin [m/s].
        pieces: of this body only.

    Returns: (...); NaN without pieces.
    """
    omega = delta_omega.reshape(-1, 3)
    v = delta_v.reshape(-1, 3)
    maximum = np.full(len(omega), np.nan)
    if len(pieces.points):
        chunk = max(1, MOST_NUMBERS // len(pieces.points))
        for k in range(0, len(omega), chunk):
            part = slice(k, k + chunk)
            maximum[part] = _maximum(omega[part], v[part], pieces)
    return maximum.reshape(delta_omega.shape[:-1])


def _maximum(omega: Array, v: Array, pieces: Pieces) -> Array:
    """The maximum (n,) of `maximum_shock` for jumps (n, 3), all at once."""
    along, offset, turning = _across(omega, v)
    p = np.swapaxes(offset[..., None] + turning @ pieces.points.T, 0, 1)
    farthest = np.sqrt(_dot(p, p).max(axis=-1))
    if pieces.round.size:
        ends = pieces.start[pieces.round] + np.arange(2)[:, None]
        semi_axes = pieces.rounding[pieces.round].swapaxes(0, 1).reshape(3, -1)
        M = (turning @ semi_axes).reshape(len(along), 1, 2, -1, 3).swapaxes(2, 3)
        far, *_ = _to_ellipses(p[..., ends], M, nearest=False)
        farthest = np.maximum(farthest, far.max(axis=(1, 2)))
    return np.asarray(np.hypot(farthest, along))


def _across(delta_omega: Array, delta_v: Array) -> tuple[Array, Array, Array]:
    """Separate jumps into parts along and perpendicular to ω.

    They are: along (...), offset (..., 2) and turning (..., 2, 3).

    With the unit vectors e perpendicular to ω, e · (Δv + Δω × r) = e · Δv + (e × Δω) · r = offset +
    turning · r.
    """
    spin = np.linalg.norm(delta_omega, axis=-1, keepdims=True)
    # A body that does not rotate has the same velocity everywhere, so any axis will do.
    rests = spin == 0.0
    axis = np.where(rests, [0.0, 0.0, 1.0], delta_omega / np.where(rests, 1.0, spin))
    x, y, z = np.moveaxis(axis, -1, 0)
    # Duff et al. 2017, "Building an orthonormal basis, revisited".
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    first = np.stack([1.0 + sign * x * x * a, sign * x * y * a, -sign * x], axis=-1)
    second = np.stack([x * y * a, sign + y * y * a, -y], axis=-1)
    e = np.stack([first, second], axis=-2)
    along = _inner(axis, delta_v)
    offset = _inner(e, delta_v[..., None, :])
    return along, offset, e @ cross_matrix(delta_omega)


def _to_ellipses(centres: Array, images: Array, nearest: bool = True) -> list[Array]:
    """Distances of the origin from the farthest and the nearest points of ellipses.

    One rotation in the plane makes the rows of M orthogonal (Hestenes 1958), which keeps the digits
    of a flat ellipse. Along its axes, from the centre (x, y) ≥ 0, the farthest point is at (major
    c, minor s) and the nearest at −(major c, minor s), with unit vectors (c, s) ≥ 0 that follow
    from Lagrange's condition.

    Args:
        centres: (2, ...).
        images: (..., 2, 3) M; an ellipse is the points centre + M b with |b| ≤ 1.
        nearest: whether the nearest points are wanted too.

    Returns: (...) to the farthest points, and to the nearest ones, 0 if the origin is inside.
    """
    u = images[..., 0, :]
    w = images[..., 1, :]
    # The rows cos α u + sin α w and cos α w − sin α u are orthogonal with tan 2α = 2 u·w / (u·u −
    # w·w).
    angle = 0.5 * np.arctan2(2.0 * _inner(u, w), _inner(u, u) - _inner(w, w))
    c = np.cos(angle)
    s = np.sin(angle)
    x = np.abs(c * centres[0] + s * centres[1])
    y = np.abs(c * centres[1] - s * centres[0])
    long = c[..., None] * u + s[..., None] * w
    short = c[..., None] * w - s[..., None] * u
    major = np.sqrt(_inner(long, long))
    minor = np.sqrt(_inner(short, short))

    # Of the farthest point (a, b) = (major x, minor y), of the nearest (minor y, major x).
    wanted = 1 + nearest
    a = np.array([major * x, minor * y])[:wanted]
    b = np.array([minor * y, major * x])[:wanted]
    delta = np.maximum((major - minor) * (major + minor), 0.0)
    first, second = _unit_vector(a, b, delta)
    distances = [np.hypot(x + major * first[0], y + minor * second[0])]
    if nearest:
        # From inside of the ellipse the distance is zero.
        to_x = np.maximum(x - major * second[1], 0.0)
        to_y = np.maximum(y - minor * first[1], 0.0)
        distances.append(np.hypot(to_x, to_y))
    return distances


def _to_tangents(sides: Array, images: Array) -> Array:
    """The corners of the parallelogram between the two straight sides of a swept ellipse.

    They follow from the ends a, b, a, b of the ellipse.

    Such an ellipse is the union of the ellipses at its ends and of this parallelogram, whose
    corners are where the sides touch them: the support points of the ellipse M b, |b| ≤ 1, in the
    two directions n perpendicular to the sides, ± M Mᵀ n / |Mᵀ n|.

    Args:
        sides: (2, m) from b to a.
        images: (m, 2, 3) M of each ellipse.

    Returns: (2, 4, m).
    """
    x, y = sides
    normal = x[:, None] * images[:, 1] - y[:, None] * images[:, 0]
    length = np.maximum(np.sqrt(_inner(normal, normal)), TINY)
    unit = normal / length[:, None]
    tangent = _inner(images, unit[:, None]).T
    signs = np.array([[1.0], [1.0], [-1.0], [-1.0]])
    return np.asarray(signs * tangent[:, None])


def _unit_vector(a: Array, b: Array, delta: Array) -> tuple[Array, Array]:
    """Solve |(a / μ, b / (μ + δ))| = 1 for that vector; all of a, b, δ and μ are ≥ 0.

    If no μ > 0 does, the vector is (√(1 − b²/δ²), b / δ).

    The reciprocal of the length is a concave function of μ, so from a μ where the length is at
    least 1 Newton's iteration increases to the root, in the end quadratically (Moré and Sorensen
    1983).
    """
    mu = np.maximum(a, np.hypot(a, b) - delta)
    step = np.array(np.inf)
    while True:
        lower = np.maximum(mu, TINY)
        upper = np.maximum(mu + delta, TINY)
        first = a / lower
        second = b / upper
        if not np.any(step > 1e-8 * mu):
            break
        # Of the squared length f: −f′ / 2 = (a / μ)² / μ + (b / (μ + δ))² / (μ + δ).
        squared = first * first + second * second
        slope = first * first / lower + second * second / upper
        step = squared * (np.sqrt(squared) - 1.0) / np.maximum(slope, TINY)
        step = np.maximum(step, 0.0)
        mu = mu + step
    rest = np.sqrt(np.maximum(1.0 - second * second, 0.0))
    first = np.where(mu > TINY, first, rest)
    length = np.hypot(first, second)
    return first / length, second / length


def _inner(a: Array, b: Array) -> Array:
    """Scalar products of vectors (..., 3)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _distances(p: Array, pieces: Pieces) -> Array:
    """Distance (n,) of the origin from the convex hull of every piece's points p (2, k).

    It is 0 inside, and NaN where a point is not finite.

    The origin is inside unless all points, seen from it, lie within less than half a turn. Outside,
    the algorithm is Wolfe's (1976) in the plane: take the corner with the minimum component along
    the nearest point so far, and continue with the nearer of the two segments from the ends of the
    present edge to it. Every step reduces the distance, and the number of segments is finite.
    """
    piece = pieces.piece
    undefined = ~np.isfinite(np.add.reduceat(_dot(p, p), pieces.start))
    p = np.where(undefined[piece], 0.0, p)
    corner = p[:, _lowest(_dot(p, p), pieces)]
    outside = _turn_seen(p, corner, pieces) < np.pi
    nearest = np.where(outside, corner, 0.0)
    a = b = nearest
    while True:
        corner = p[:, _lowest(_dot(nearest[:, piece], p), pieces)]
        near_a = _nearest_on_segments(a, corner)
        near_b = _nearest_on_segments(b, corner)
        from_a = _dot(near_a, near_a) <= _dot(near_b, near_b)
        feature = np.where(from_a, near_a, near_b)
        closer = _dot(feature, feature) < _dot(nearest, nearest)
        if not closer.any():
            return np.where(undefined, np.nan, np.sqrt(_dot(nearest, nearest)))
        a = np.where(closer & ~from_a, b, a)
        b = np.where(closer, corner, b)
        nearest = np.where(closer, feature, nearest)


def _turn_seen(p: Array, corner: Array, pieces: Pieces) -> Array:
    """The angle (n,) within which the origin sees each piece's points p (2, k) [rad].

    Args: corner (2, n), a point of each piece, from which angles are counted.
    """
    x, y = corner[:, pieces.piece]
    angle = np.arctan2(x * p[1] - y * p[0], x * p[0] + y * p[1])
    first = np.minimum.reduceat(angle, pieces.start)
    last = np.maximum.reduceat(angle, pieces.start)
    return np.asarray(last - first)


def _dot(a: Array, b: Array) -> Array:
    """Scalar products (n,) of the columns of a and b (2, n)."""
    x, y = a
    u, v = b
    return np.asarray(x * u + y * v)


def _lowest(values: Array, pieces: Pieces) -> np.ndarray:
    """Index (n,) of each piece's first point with its smallest value (k,)."""
    hits = np.flatnonzero(values == np.minimum.reduceat(values, pieces.start)[pieces.piece])
    return np.asarray(hits[np.searchsorted(hits, pieces.start)])


def _nearest_on_segments(a: Array, b: Array) -> Array:
    """The points of the segments a–b nearest to the origin, all (2, n)."""
    towards = b - a
    squared = _dot(towards, towards)
    share = -_dot(towards, a) / np.where(squared > 0.0, squared, 1.0)
    return np.asarray(a + np.clip(share, 0.0, 1.0) * towards)
