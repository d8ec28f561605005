"""The same landing with other joints: all free, all locked."""

import numpy as np

from shockpc.core.impulse import RowChoice
from shockpc.exact.proof import Enclosure
from shockpc.landing import Landing

__all__ = ["held_joints_enclosure"]


def held_joints_enclosure(enclosure: Enclosure, landing: Landing) -> Enclosure:
    """The robot with every joint locked and its base free, without rows: only what its inertia resists can be read from it."""
    none, nothing = RowChoice.every(0), np.zeros(landing.robot.model.nv)
    return Enclosure(enclosure.inputs._replace(blocks=(), choice=none, base="free", armature=nothing, locked=landing.robot.driven))
