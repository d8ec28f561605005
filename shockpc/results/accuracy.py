"""How far to trust a result: the proven bound, the error of double precision, and the sensitivity to the data."""

from dataclasses import dataclass

import numpy as np

from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.exact.proof import Proof, motion, sensitivity
from shockpc.landing import Landing

__all__ = ["SENSITIVE", "Health", "data_warnings", "double_error", "rotation_lengths"]

SENSITIVE = 1e-9
"""A result that a change of the data in their last digits moves by more than this share carries a warning."""

AT_REST = 1e-13
"""A body that moves by less than this share of the fastest one counts as at rest where errors are compared with motion."""


@dataclass(frozen=True)
class Health:
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


def data_warnings(landing: Landing, proof: Proof) -> tuple[float, tuple[Diagnostic, ...]]:
    """The sensitivity to the data [1], and a warning with its cause where it is above `SENSITIVE`."""
    length = rotation_lengths(landing)
    effect, causes = sensitivity(proof, length)
    size = motion(proof.jumps[..., 3:], length)[:, 0]
    moving = size > AT_REST * size.max(initial=0.0)
    most = float(np.max(effect[moving], initial=0.0))
    if not causes:
        return most, ()
    body = landing.robot.bodies[int(np.argmax(np.where(moving, effect, -1.0)))].name
    kind = max(causes, key=lambda name: causes[name])
    text = (
        f'a change of the data in their last digits moves the result of body "{body}" by {most:.0e} of its motion, most by the '
        f"{kind} ({causes[kind]:.0e}); digits beyond that are those of this file, not of a real robot"
    )
    return most, (Diagnostic("data", body, most, text),)
