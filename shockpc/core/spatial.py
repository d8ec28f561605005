"""Spatial velocities, their jumps from body to body, and the plane of a study.

A spatial velocity is a 6-vector (ω, v): angular part first [rad/s], then the velocity of the point
it is written at [m/s] (Featherstone's order, the shock paper's Section 3.2). All arrays may carry
leading axes.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

Array: TypeAlias = np.ndarray[Any, np.dtype[np.float64]]


class Plane(NamedTuple):
    """The plane in which shock is reduced to a point and a radius; world axes.

    Right-handed: e1 × e2 = normal.

    Attributes:
        normal: (3,) unit vector across the plane.
        e1: (3,) unit vector forward in the plane.
        e2: (3,) unit vector up in the plane.
    """

    normal: Array
    e1: Array
    e2: Array

    @property
    def level(self) -> bool:
        """True if the plane is horizontal, so that it has no vertical."""
        return abs(float(self.normal[2])) > 1.0 - 1e-9

    @property
    def forward(self) -> Array:
        """Unit vector (3,) forward: along e1 or against it, whichever points to world x.

        In a plane across x, whichever points to world y.
        """
        x, y = self.e1[:2]
        across_x = abs(x) <= 1e-9
        if x > 1e-9 or (across_x and y > 0.0):
            return self.e1
        return -self.e1


def plane_from(normal: Array | Sequence[float]) -> Plane:
    """The plane across a normal, with e2 as near to world z as it can be.

    In a level plane e2 is as near to world y as it can be.

    The sagittal plane (forward x, up z) has the normal −y, because x × z = −y.

    Args:
        normal: (3,) any length but zero, world axes.

    Raises:
        ValueError: the normal has no length or is not finite.
    """
    n = np.asarray(normal, dtype=float)
    length = float(np.linalg.norm(n))
    if not np.isfinite(length) or length == 0.0:
        raise ValueError(f"a plane's normal needs a finite length above zero, not {n.tolist()}")
    n = n / length
    up = np.array([0.0, 0.0, 1.0])
    if np.hypot(n[0], n[1]) < 1e-9:
        up = np.array([0.0, 1.0, 0.0])
    e1 = np.cross(up, n)
    e1 /= np.linalg.norm(e1)
    # Adding zero turns -0.0 into 0.0, which would otherwise reach printed files.
    return Plane(n + 0.0, e1 + 0.0, np.cross(n, e1) + 0.0)


def cross_matrix(r: Array) -> Array:
    """The matrix [r]× with [r]× u = r × u. Args: r (..., 3). Returns: (..., 3, 3)."""
    x, y, z = r[..., 0], r[..., 1], r[..., 2]
    out = np.zeros((*r.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2] = -z, y
    out[..., 1, 0], out[..., 1, 2] = z, -x
    out[..., 2, 0], out[..., 2, 1] = -y, x
    return out


def cross(a: Any, b: Any) -> Any:
    """The products a × b of vectors (..., 3).

    `np.cross` takes several times as long for a few of them.
    """
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    out = np.empty((*np.shape(first), 3), dtype=np.asarray(first).dtype)
    out[..., 0] = first
    out[..., 1] = z * u - x * w
    out[..., 2] = x * v - y * u
    return out


def motion_cross(V: Array) -> Array:
    """The matrix (..., 6, 6) of the product V × W.

    By it a rigid motion V (..., 6) changes a twist W that it carries.

    A wrench or a momentum that it carries changes by minus the transpose (Featherstone 2008,
    section 2.9).
    """
    out = np.zeros((*V.shape[:-1], 6, 6))
    out[..., :3, :3] = out[..., 3:, 3:] = cross_matrix(V[..., :3])
    out[..., 3:, :3] = cross_matrix(V[..., 3:])
    return out


def corners_of_box(points: Array) -> Array:
    """The minimum and maximum coordinates (2, k) of points (n, k).

    NumPy's minima along the first axis take 70 times as long.
    """
    return np.array([(x.min(), x.max()) for x in points.T]).T


def velocity_at(omega: Any, v: Any, r: Any) -> Any:
    """Velocity of a point of a rigid body: v + ω × r (the shock paper, Eq. 10).

    Args:
        omega: (..., 3) angular velocity [rad/s].
        v: (..., 3) velocity of the origin [m/s].
        r: (..., 3) point from that origin, in the same axes [m].
    """
    return v + cross(omega, r)


def jump_at(jumps: Any, r: Any) -> Any:
    """Jumps (N, 3, k) of the velocities of points, Δv + Δω × r (Eq. 10), for k strikes.

    Args:
        jumps: (N, 6, k) of the points' bodies (Δω, Δv), each at an origin [rad/s, m/s].
        r: (N, 3) points from these origins, in the same axes [m].
    """
    a, b, c = jumps[:, 0], jumps[:, 1], jumps[:, 2]
    x, y, z = r[:, 0, None], r[:, 1, None], r[:, 2, None]
    by_rotation = np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)
    return jumps[:, 3:] + by_rotation


def body_jumps(
    J: Array,
    dofs: Sequence[slice],
    parent: Sequence[int],
    position: Array,
    delta_qd: Array,
    bodies: Sequence[int] | None = None,
) -> Array:
    """Jump of every body's spatial velocity at the body frame's origin, world axes.

    Source: shock paper, Eqs. 8 and 9.

    The recursion Δv̂_i = Δv̂_parent(i) + S_i Δq̇_i from the base to the leaves, for all postures at
    once.

    Args:
        J: (N, 6, nv) twist (ω, v at the common origin) that each joint velocity gives to the bodies
            behind it.
        dofs: joint velocities of each body's joint.
        parent: index of the body that carries each body's joint; −1 for the world.
        position: (N, nb, 3) origins of the body frames, from the common origin [m].
        delta_qd: (N, nv, k) jumps of the joint velocities [rad/s, m/s].
        bodies: indices of those that are wanted, in that order; all by default.

    Returns: (N, nb, 6, k), angular part first [rad/s, m/s].
    """
    if bodies is not None:
        return _jumps_of(J, dofs, parent, position, delta_qd, bodies)
    # The posture comes last, so that every operation runs over contiguous numbers.
    S = J.transpose(2, 1, 0).copy()
    rates = delta_qd.transpose(1, 2, 0).copy()
    origins = position.transpose(1, 2, 0).copy()

    # Δv̂_i at the common origin
    jumps = np.empty((len(parent), 6, *rates.shape[1:]), dtype=rates.dtype)
    for jump, columns, before in zip(jumps, dofs, parent, strict=True):
        if columns.stop - columns.start == 1:
            np.multiply(S[columns.start, :, None], rates[columns.start], out=jump)
        else:
            np.einsum("cin,ckn->ikn", S[columns], rates[columns], out=jump)
        if before >= 0:
            jump += jumps[before]

    # v_i = v_O + ω × p_i
    x, y, z = origins[:, 0, None], origins[:, 1, None], origins[:, 2, None]
    a, b, c = jumps[:, 0], jumps[:, 1], jumps[:, 2]
    jumps[:, 3] += b * z - c * y
    jumps[:, 4] += c * x - a * z
    jumps[:, 5] += a * y - b * x
    return jumps.transpose(3, 0, 1, 2)


def _jumps_of(
    J: Array,
    dofs: Sequence[slice],
    parent: Sequence[int],
    position: Array,
    delta_qd: Array,
    bodies: Sequence[int],
) -> Array:
    """The jumps of some bodies, for which only those that carry them are computed."""
    carriers: set[int] = set()
    for body in bodies:
        while body >= 0:
            carriers.add(body)
            body = parent[body]
    carried = sorted(carriers)
    index = {body: i for i, body in enumerate(carried)}
    parents = [index.get(parent[body], -1) for body in carried]
    joints = [dofs[body] for body in carried]
    jumps = body_jumps(J, joints, parents, position[:, carried], delta_qd)
    return jumps[:, [index[body] for body in bodies]]


def in_body_axes(jumps: Array, rotation: Array) -> Array:
    """Jumps (N, nb, 6, k) in the axes of the bodies' frames.

    Args: jumps, in world axes; rotation (N, nb, 3, 3), body to world.
    """
    to_body = np.swapaxes(rotation, -1, -2)[..., None, :, :]
    parts = jumps.reshape(*jumps.shape[:2], 2, 3, -1)
    return np.asarray(to_body @ parts).reshape(jumps.shape)


def quaternion_of(rotation: Array) -> Array:
    """A quaternion (x, y, z, w) of a rotation (3, 3), of any length.

    Quarter turns about an axis, and none, stay exact.

    It is a row of 4 q qᵀ, whose entries are sums of those of the rotation.
    """
    (a, b, c), (d, e, f), (g, h, i) = rotation
    products = np.array(
        [
            [1.0 + a - e - i, b + d, c + g, h - f],
            [b + d, 1.0 - a + e - i, f + h, c - g],
            [c + g, f + h, 1.0 - a - e + i, d - b],
            [h - f, c - g, d - b, 1.0 + a + e + i],
        ]
    )
    largest = int(np.argmax(np.diagonal(products)))
    quaternion = products[largest] / products[largest, largest]
    integers = np.round(quaternion)
    rounding = np.abs(quaternion - integers)
    exact = rounding < 4.0 * np.finfo(float).eps
    return np.asarray(np.where(exact, integers, quaternion))


def freeze(*values: Any) -> None:
    """Make arrays read-only, those in tuples and dictionaries too, at any depth.

    Other values are left as they are.
    """
    for value in values:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        elif isinstance(value, tuple):
            freeze(*value)
        elif isinstance(value, dict):
            freeze(*value.values())


def read_only(values: Array | Sequence[Any]) -> Array:
    """A copy that outlives the buffer it was read from and cannot be changed."""
    out = np.array(values, dtype=float)
    out.flags.writeable = False
    return out
