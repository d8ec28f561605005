"""How far to trust a result: the proven bound, the error of double precision, and the sensitivity to the data."""

from typing import NamedTuple

import numpy as np

from shockpc.core.percussion import dot
from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import Balls, balls
from shockpc.exact.proof import Proof, motion
from shockpc.exact.sensitivity import sensitivity
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.model.rows import slices_of
from shockpc.results.solved import Solved, speed_in

__all__ = ["SENSITIVE", "Health", "data_warnings", "double_error", "rotation_lengths"]

SENSITIVE = 1e-9
"""A result that a change of the data in their last digits moves by more than this share carries a warning."""

AT_REST = 1e-13
"""A body that moves by less than this share of the fastest one counts as at rest where errors are compared with motion."""


class Health(NamedTuple):
    """How far to trust a profile.

    Attributes:
        rank: number of independent contact and closure rows.
        rows: number of these rows.
        error_bound: proven error of the reported jumps, relative to each body's motion, the largest over the bodies [1].
        body_error_bounds: the same for every body.
        double_error: true error of the solution in double precision, the largest over the bodies [1]; inf if it has none.
        data_sensitivity: how far the result moves when every datum changes in its last digit, the largest over the bodies [1].
        bits: precision of the ball arithmetic.
        warnings: each with its consequence.
    """

    rank: int
    rows: int
    error_bound: float
    body_error_bounds: tuple[float, ...]
    double_error: float
    data_sensitivity: float
    bits: int
    warnings: tuple[Diagnostic, ...]


def rotation_lengths(landing: Landing) -> Array:
    """Length (nb,) by which the rotation of a body counts as a speed [m]: its radius of gyration, or the others' smallest."""
    radius = landing.robot.gyration
    return np.asarray(np.where(radius > 0.0, radius, radius[radius > 0.0].min(initial=1.0)))


def double_error(landing: Landing, proof: Proof, jumps: Array) -> float:
    """True error of jumps (nb, 6) in double precision, relative to each body's motion, the largest over the bodies that move."""
    length, exact = rotation_lengths(landing), proof.jumps[..., 3:]
    size = motion(exact, length)[:, 0]
    if not np.isfinite(jumps).all():
        return np.inf
    off = motion(jumps[..., None] - exact, length)[:, 0]
    return float(np.max((off / np.where(size > 0.0, size, 1.0))[size > AT_REST * size.max(initial=0.0)], initial=0.0))


def data_warnings(of: Solved, translates: np.ndarray) -> tuple[float, tuple[Diagnostic, ...]]:
    """The sensitivity to the data [1], and warnings with their cause where it is above `SENSITIVE`.

    Besides the jumps of the bodies: the speed v_in, the radii of percussion and the impulses of the contacts, where these are small
    differences of large numbers.

    Args:
        of: the landing.
        translates: (nb,) which bodies have no radius of percussion.
    """
    landing, bodies, impulse = of.landing, of.robot.bodies, of.proof.impulse[:, 3]
    turning, length = np.flatnonzero(~translates).tolist(), rotation_lengths(landing)
    blocks = of.proof.enclosure.inputs.blocks[: len(landing.contacts) + len(landing.stance)]
    least = AT_REST * float(np.abs(impulse).max(initial=0.0))
    loaded = [
        (block, own)
        for block, own in zip(blocks, slices_of(blocks), strict=True)
        if of.choice.unique[own].all() and np.abs(impulse[own]).max() > least
    ]

    def others(impact: ExactImpact) -> list[Balls]:
        normals = np.sum(impact.orientations[turning] * balls(landing.plane.normal)[:, None], axis=1)
        turns, along = dot(normals, impact.body_jumps[turning][:, :3, 3]), impact.impulse[:, 3]
        impulses = (along[own][: len(block.forces)] @ balls(block.forces) for block, own in loaded)
        return [speed_in(impact, landing), *turns[:, None], *impulses]

    found = sensitivity(of.proof, length, others)
    size = motion(of.proof.jumps[..., 3:], length)[:, 0]
    moves = np.where(size > AT_REST * size.max(initial=0.0), found.bodies, 0.0)
    groups = (
        [(f'result of body "{body.name}"', body.name) for body in bodies],
        [("speed before the impact", "")],
        [(f'radius of percussion of body "{bodies[i].name}"', bodies[i].name) for i in turning],
        [(f"impulse of {block.name}", block.name) for block, _ in loaded],
    )
    every, first, warnings = np.append(moves, found.others), 0, []
    for group in groups:
        k = max(range(first, first + len(group)), key=every.__getitem__, default=first)
        if group and every[k] > SENSITIVE:
            cause, (what, subject) = max(found.causes, key=lambda kind: found.causes[kind][k]), group[k - first]
            text = (
                f"a change of the data in their last digits moves the {what} by {every[k]:.0e} of its size, most by the "
                f"{cause} ({found.causes[cause][k]:.0e}); digits beyond that are those of this file, not of a real robot"
            )
            warnings.append(Diagnostic("data", subject, float(every[k]), text))
        first += len(group)
    return float(np.max(moves, initial=0.0)), tuple(warnings)
