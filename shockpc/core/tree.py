"""A mechanism as free bodies and the joints between them: what needs no joint-space inertia starts from here."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array

__all__ = ["Tree"]


class Tree(NamedTuple):
    """Free bodies and the joints between them, in one posture; world axes, every point from one common origin.

    Attributes:
        parent: (nb,) index of the body that each body's joint hangs on; −1 for the world.
        mass: (nb,) [kg].
        com: (nb, 3) centres of mass [m].
        inertia: (nb, 3, 3) rotational inertias about the centres of mass [kg m²].
        joint: (nb, 3) a point at which each body's joint is written [m].
        S: (nb, 6, nv) twist (ω, v at that point) of each body against its parent, for unit joint rates.
        armature: (nv,) reflected inertia of each joint rate [kg m², kg].
        G: (nv, ny) which joint rates are free, q̇ = G ẏ; None where all are.
    """

    parent: np.ndarray
    mass: Array
    com: Array
    inertia: Array
    joint: Array
    S: Array
    armature: Array
    G: Array | None

    @property
    def free(self) -> int:
        """How many joint rates are free."""
        return len(self.armature) if self.G is None else self.G.shape[1]
