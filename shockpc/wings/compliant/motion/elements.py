"""The elements of a landing: springs, dampers and constant forces along rows."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array


class Elements(NamedTuple):
    """The springs of a landing, one for each of r rows; `Elements.alike` has values by default.

    Attributes:
        rows: (r, n) velocity along each element for unit velocities of the n coordinates [m, 1].
        stiffness: (r,) k [N/m, N m/rad].
        restitution: (r,) e from 0 to 1; 1 for a spring without loss.
        contact: (r,) number of the contact that a row belongs to, −1 for a spring between bodies.
        normal: (r,) whether a row is the normal of its contact, along which the ground pushes. Each
            contact has one.
        damping: (r,) c of a viscous damper beside the spring [N s/m, N m s/rad]; zero for none.
            With one, e has no effect.
        load: (r,) force on the robot along the row at the impact [N, N m]: of a spring between
            bodies that is deflected already, or constant where the stiffness is zero. Contacts have
            none.
        relaxation: (r,) rate k / c at which a viscous damper c in series with the spring lets its
            force decay [1/s]; zero for none. With one, e has no effect.
        straight: (r,) whether a spring between bodies is one that keeps a link straight. What is
            left of a contact's force is compared with that of a robot in which these are rigid.
    """

    rows: Array
    stiffness: Array
    restitution: Array
    contact: np.ndarray
    normal: np.ndarray
    damping: Array
    load: Array
    relaxation: Array
    straight: np.ndarray

    @staticmethod
    def alike(
        rows: Array,
        stiffness: Array | float,
        restitution: Array | float = 1.0,
        contact: np.ndarray | int = -1,
        normal: np.ndarray | bool = False,
        damping: Array | float = 0.0,
        load: Array | float = 0.0,
        relaxation: Array | float = 0.0,
        straight: np.ndarray | bool = False,
    ) -> "Elements":
        """Elements along some rows, with one value for all of them or one for each.

        By default they are springs between bodies.
        """
        values = stiffness, restitution, contact, normal, damping, load, relaxation, straight
        return Elements(rows, *(np.broadcast_to(value, len(rows)) for value in values))

    @staticmethod
    def joined(*groups: "Elements") -> "Elements":
        """Groups of elements, one after the other.

        Rows of fewer coordinates do not move the last ones.
        """
        width = max(group.rows.shape[1] for group in groups)
        rows = []
        for group in groups:
            missing = width - group.rows.shape[1]
            rows.append(np.pad(group.rows, ((0, 0), (0, missing))))
        values = zip(*[group[1:] for group in groups], strict=True)
        return Elements(np.concatenate(rows), *map(np.concatenate, values))


def attach_rotors(
    M: Array, rows: Array, velocity: Array, joints: Array, inertia: Array
) -> tuple[Array, Array, Array, Array]:
    """Add rotors that springs connect to their joints; each is one more coordinate.

    Args:
        M: (n, n) inertia without these rotors [kg, kg m, kg m²].
        rows: (r, n) rows of contacts and other springs.
        velocity: (n,) before impact. Rotors move with their joints.
        joints: (s, n) rates of the joints for unit velocities of the coordinates.
        inertia: (s,) reflected inertia of each rotor, its inertia times the squared ratio [kg m²,
            kg].

    Returns: M (n + s, n + s), the rows (r, n + s), rows (s, n + s) of the springs, joint less
        rotor, and the velocity (n + s,).
    """
    n, s = len(M), len(joints)
    full = np.zeros((n + s, n + s))
    full[:n, :n], full[n:, n:] = M, np.diag(inertia)
    return (
        full,
        np.pad(rows, ((0, 0), (0, s))),
        np.hstack([joints, -np.eye(s)]),
        np.append(velocity, joints @ velocity),
    )
