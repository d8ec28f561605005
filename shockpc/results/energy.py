"""The kinetic energy that an impact takes."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import Balls, balls, nearest
from shockpc.exact.proof import Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing

__all__ = ["Energy", "energy", "gained"]


class Energy(NamedTuple):
    """Kinetic energy that the impact takes.

    Attributes:
        lost: [J]
        share: of the kinetic energy before the impact [1]; None where that is not determined (fixed base, standing feet).
    """

    lost: float
    share: float | None


def energy(landing: Landing, proof: Proof) -> Energy:
    """Energy lost, −½ λᵀ (v⁻ + v⁺): with v⁺ = −e v⁻ = v⁻ − b that is −½ λᵀ b (1 − e) / (1 + e)."""

    def read(impact: ExactImpact) -> tuple[Array, Array | None]:
        e = balls(np.repeat([block.restitution for block in impact.inputs.blocks], [block.size for block in impact.inputs.blocks]))
        works = impact.independent_impulse[:, 3] * impact.speeds[:, 3]
        lost, size = -np.sum(works * (1 - e) / (1 + e)) / 2, float(np.abs(works.astype(float)).sum())
        if not landing.floating:
            return nearest(_one(lost), size), None
        before = impact.kinetic_energy_before
        return nearest(_one(lost), size), nearest(_one(lost / before), 1.0) if float(before) > 0.0 else None

    lost, share = proof.enclosure.read(read)
    return Energy(lost.item(), None if share is None else share.item())


def gained(landing: Landing, found: Energy) -> tuple[Diagnostic, ...]:
    """A warning where contacts of unequal restitution would make kinetic energy, which no impact does."""
    if found.lost >= 0.0:
        return ()
    text = (
        f"this impact would make {-found.lost:.3g} J of kinetic energy: contacts with unequal restitution push against one "
        "another; give them one restitution, or strike them one after the other"
    )
    return (Diagnostic("energy", landing.robot.name, found.lost, text),)


def _one(value: object) -> Balls:
    return np.array(value, dtype=object)
