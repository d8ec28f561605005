"""What an impact does to the robot as a whole: impulse and moment of the ground, and the kinetic energy that it takes."""

from collections.abc import Iterator

import numpy as np

from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import balls, nearest
from shockpc.exact.solution import ExactImpact
from shockpc.model.rows import block_axes, block_point
from shockpc.results.solved import Solved

__all__ = ["energy", "gained", "total_impulse"]


def total_impulse(of: Solved) -> tuple[Array, Array]:
    """Impulse of the ground, all contacts and standing feet together; unique even where its parts are not.

    Returns: force (3,) [N s] and moment (3,) about the robot's centre of mass [N m s], world axes.
    """
    landing, robot = of.landing, of.robot
    grounded = [k for k, block in enumerate(of.proof.enclosure.inputs.blocks) if block.kind != "closure"]
    reach = float(np.abs(landing.state.position[0]).max()) + float(np.abs(robot.coms).max())

    def read(impact: ExactImpact) -> tuple[Array, Array]:
        mass, rows = balls(robot.masses), impact.independent_impulse[:, 3]
        centre = np.sum(impact.points(range(len(mass)), robot.coms) * mass[:, None], axis=0) / np.sum(mass)
        force, moment = balls(np.zeros(3)), balls(np.zeros(3))
        for k in grounded:
            block, own = impact.inputs.blocks[k], rows[impact.slices[k]]
            parts, n = block_axes(impact.state, block)[0] * own[:, None], len(block.forces)
            pushed = parts[:n].sum(axis=0)
            force, moment = force + pushed, moment + parts[n:].sum(axis=0)
            moment = moment + np.cross(block_point(impact.state, block)[0] - centre, pushed)
        size = float(np.abs(rows.astype(float)).sum())
        return nearest(force, size), nearest(moment, size * (reach or 1.0))

    return of.read(read)


def energy(of: Solved) -> tuple[float, float | None]:
    """Kinetic energy that the impact takes.

    It is −½ λᵀ (v⁻ + v⁺): with v⁺ = −e v⁻ = v⁻ − b that is −½ λᵀ b (1 − e) / (1 + e).

    Returns: energy [J], and its share of that before the impact [1]; None where that is not determined (fixed base, standing feet).
    """
    blocks = of.proof.enclosure.inputs.blocks
    e = balls(np.repeat([block.restitution for block in blocks], [block.size for block in blocks]))

    def read(impact: ExactImpact) -> tuple[float, float | None]:
        works = impact.independent_impulse[:, 3] * impact.speeds[:, 3]
        lost, before = -np.sum(works * (1 - e) / (1 + e)) / 2, impact.kinetic_energy_before
        known = of.landing.floating and float(before) > 0.0
        size = float(np.abs(works.astype(float)).sum())
        return nearest(lost, size).item(), nearest(lost / before, 1.0).item() if known else None

    return of.read(read)


def gained(of: Solved, lost: float) -> Iterator[Diagnostic]:
    """A warning where contacts of unequal restitution would make kinetic energy, which no impact does."""
    if lost < 0.0:
        text = (
            f"this impact would make {-lost:.3g} J of kinetic energy: contacts with unequal restitution push against one "
            "another; give them one restitution, or strike them one after the other"
        )
        yield Diagnostic("energy", of.robot.name, lost, text)
