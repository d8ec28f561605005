"""The sensitivity of a result to its data: what a change of every datum in its last digit does to it."""

import random
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from flint import ctx

from shockpc.core.spatial import Array
from shockpc.exact.balls import Balls, SingularError
from shockpc.exact.kinematics import Data, data_of
from shockpc.exact.proof import Proof, motion
from shockpc.exact.solution import ExactImpact, Inputs
from shockpc.model.motion import Motion

__all__ = ["Sensitivity", "sensitivity"]

CHANGES = 2
"""Random changes of the data from which the sensitivity to them is estimated."""

STEPS = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
"""Changes of a datum in units in the last place; a decimal file's last digit is as large as a few of them."""

KINDS = (
    "masses and inertias",
    "placements and axes of the joints",
    "joint values of the posture",
    "contact points and motion before the impact",
)


class Sensitivity(NamedTuple):
    """What a change of every datum in its last digit does to a result: the largest effect of a few random changes.

    Attributes:
        bodies: (nb,) on the jump of each body, relative to its motion [1].
        others: (n,) on each of the other results asked for, relative to its size [1].
        causes: for each kind of datum what it alone does to all of these, (nb + n,); empty if nothing moves by more than 1e-9.
    """

    bodies: Array
    others: Array
    causes: dict[str, Array]


def sensitivity(proof: Proof, length: Array, others: Callable[[ExactImpact], list[Balls]]) -> Sensitivity:
    """The sensitivity of a landing to its data; data that are zero stay zero.

    Args:
        proof: of the landing.
        length: as for `prove`.
        others: other results, each as the components of a vector.
    """
    inputs, bits = proof.enclosure.inputs, proof.enclosure.bits
    jumps = proof.jumps[..., 3:]
    size = motion(jumps, length)[:, 0]

    own = proof.enclosure.read(others)

    def effect(kinds: tuple[str, ...], seed: int) -> Array:
        with ctx.workprec(bits):
            try:
                found = ExactImpact(*_changed(inputs, kinds, seed))
                of_bodies = motion(found.body_jumps[..., 3:].astype(float) - jumps, length)[:, 0] / np.where(size > 0.0, size, 1.0)
                return np.array([*of_bodies, *(_apart(*pair) for pair in zip(others(found), own, strict=True))])
            except SingularError:
                return np.full(len(size) + len(own), np.inf)

    every = np.max([effect(KINDS, seed) for seed in range(CHANGES)], axis=0)
    moving = np.append(size > 1e-13 * size.max(initial=0.0), np.ones(len(own), dtype=bool))
    causes = {kind: effect((kind,), 0) for kind in KINDS} if np.any(every[moving] > 1e-9) else {}
    return Sensitivity(every[: len(size)], every[len(size) :], causes)


def _apart(one: Balls, other: Balls) -> float:
    """Distance between two vectors, relative to the second one."""
    distance, size = (float(np.sum(vector * vector).mid()) for vector in (one - other, other))
    return float(np.sqrt(distance / size)) if size > 0.0 else 0.0


def _changed(inputs: Inputs, kinds: tuple[str, ...], seed: int) -> tuple[Inputs, Data]:
    """The inputs and the robot with every datum of some kinds changed in its last digit."""
    draw = random.Random(seed)
    data = data_of(inputs.robot)
    if "masses and inertias" in kinds:
        inertia = _last_digit(draw, data.inertia)
        inertia = np.triu(inertia) + np.swapaxes(np.triu(inertia, 1), 1, 2)
        data = data._replace(mass=_last_digit(draw, data.mass), lever=_last_digit(draw, data.lever), inertia=inertia)
        inputs = inputs._replace(armature=_last_digit(draw, inputs.armature))
    if "placements and axes of the joints" in kinds:
        fields = ("rotation", "offset", "axis", "body_rotation", "body_offset")
        data = data._replace(**{name: _last_digit(draw, getattr(data, name)) for name in fields})
    if "joint values of the posture" in kinds:
        inputs = inputs._replace(q=_last_digit(draw, np.asarray(inputs.q, dtype=float)))
    if "contact points and motion before the impact" in kinds:
        blocks = tuple(
            block._replace(point=_last_digit(draw, block.point), forces=_last_digit(draw, block.forces)) for block in inputs.blocks
        )
        inputs = inputs._replace(blocks=blocks, before=Motion(*(_last_digit(draw, part) for part in inputs.before)))
    return inputs, data


def _last_digit(draw: random.Random, values: Array) -> Array:
    """Doubles changed by one to four units in the last place, up or down at random; zeros stay.

    Two numbers that would change by the same amount keep their difference, so there are more amounts than one.
    """
    # The standard library's generator: numpy's takes longer to import than all changes.
    steps = STEPS[np.frombuffer(draw.randbytes(values.size), np.uint8) & 7].reshape(values.shape)
    return np.asarray(np.where(values == 0.0, values, values + steps * np.spacing(values)))
