"""What is held during an impact, as rows: contacts, feet that stand, loops that are closed.

A row is a unit impulse: a wrench on one or two bodies. Its velocity is what that wrench does work on, so one description serves
the joint-space equation, the check in maximal coordinates, and the impulses in the joints.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.core.tree import Tree
from shockpc.model.dynamics import Dynamics

__all__ = ["Block", "Rows", "about_com", "force_block", "moment_block", "point_block", "row_jacobian", "stack"]


class Block(NamedTuple):
    """The rows of one contact, foot or closure.

    Attributes:
        name: what holds, such as 'contact "foot"'.
        W: (N, n, nb, 6) unit wrench (moment about the common origin, force) of each row on each body, world axes.
        b: (N, n, k) speed to be undone along each row; zero where nothing was moving.
        terms: (N, n) size of the terms that the last column of b is a sum of.
        axes: (n, 3) direction of each row, world axes.
        restitution: e of the rows [1]; b holds (1 + e) times their approach.
    """

    name: str
    W: Array
    b: Array
    terms: Array
    axes: Array
    restitution: float = 0.0


class Rows(NamedTuple):
    """All rows of a scene, stacked; attributes as in `Block`, with where each block begins and ends.

    Attributes:
        W: (N, nc, nb, 6)
        b: (N, nc, k)
        slices: rows of each block.
        blocks: the blocks.
    """

    W: Array
    b: Array
    slices: tuple[slice, ...]
    blocks: tuple[Block, ...]

    @property
    def terms(self) -> Array:
        """Size (N, nc) of the terms that the last column of b is a sum of."""
        return np.concatenate([block.terms for block in self.blocks], axis=1)

    @property
    def restitution(self) -> Array:
        """The e (nc,) of every row [1]."""
        return np.concatenate([np.full(block.W.shape[1], block.restitution) for block in self.blocks])


def point_block(state: Dynamics, body: int, point: Array, axes: Array) -> Array:
    """Wrenches (N, n, nb, 6) of unit impulses along axes at a point of a body.

    Args:
        state: the robot in N postures.
        body: index of the body.
        point: (3,) in the body's frame [m].
        axes: (n, 3) unit vectors, world axes; or (N, n, 3) where they turn with the posture.
    """
    return force_block(state, body, state.position[:, body] + state.rotation[:, body] @ point, axes)


def force_block(state: Dynamics, body: int, place: Array, axes: Array) -> Array:
    """The same with the point given by where it is (N, 3), world axes, from the base [m]; none at all on the world (body −1)."""
    n = len(state.H)
    axes = np.broadcast_to(axes, (n, *axes.shape[-2:]))
    W = np.zeros((n, axes.shape[1], len(state.moves), 6))
    if body >= 0:
        W[:, :, body, :3] = np.cross(place[:, None, :], axes)
        W[:, :, body, 3:] = axes
    return W


def moment_block(state: Dynamics, body: int, axes: Array) -> Array:
    """Wrenches (N, n, nb, 6) of unit moments about axes (n, 3) or (N, n, 3), world axes, on a body; none on the world (body −1)."""
    n = len(state.H)
    axes = np.broadcast_to(axes, (n, *axes.shape[-2:]))
    W = np.zeros((n, axes.shape[1], len(state.moves), 6))
    if body >= 0:
        W[:, :, body, :3] = axes
    return W


def stack(blocks: list[Block]) -> Rows:
    """Put the blocks under one another."""
    ends = np.cumsum([block.W.shape[1] for block in blocks])
    slices = tuple(slice(int(end) - block.W.shape[1], int(end)) for end, block in zip(ends, blocks, strict=True))
    W = np.concatenate([block.W for block in blocks], axis=1)
    return Rows(W, np.concatenate([block.b for block in blocks], axis=1), slices, tuple(blocks))


def about_com(W: Array, bodies: Tree) -> Array:
    """Wrenches (..., nb, 6) about the common origin, written about every body's centre of mass."""
    return np.concatenate([W[..., :3] - np.cross(bodies.com, W[..., 3:]), W[..., 3:]], axis=-1)


def row_jacobian(state: Dynamics, W: Array) -> Array:
    """Velocity (N, nc, nv) of each row for unit joint velocities: the power of its wrench.

    What is left of terms that cancel to within their rounding is a zero that the mechanism means, such as the velocity of a point
    on the only axis that turns: nothing later could tell it from a lever of 1e-16 m.
    """
    J_c = np.zeros((*W.shape[:2], state.J.shape[-1]))
    terms, J = np.zeros_like(J_c), np.abs(state.J)
    for body in np.flatnonzero(W.any(axis=(0, 1, 3))):
        J_c += (W[:, :, body] @ state.J) * state.moves[body]
        terms += (np.abs(W[:, :, body]) @ J) * state.moves[body]
    return np.where(np.abs(J_c) > 8.0 * np.finfo(float).eps * terms, J_c, 0.0)
