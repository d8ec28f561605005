"""The robot and the landing with every datum changed in its last digit: the effect of rounding in
the input data.
"""

from dataclasses import replace

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import Motion
from shockpc.method.exact.kinematics import Data, data_of

STEPS = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
"""Changes of a datum in units in the last place; a decimal file's last digit is as large as a few
of them.
"""


def last_digits_changed(landing: PosedLanding, pattern: int) -> tuple[PosedLanding, Data]:
    """A landing, and the numbers of its robot, with every datum changed by one to four units in the
    last place; zeros stay.

    The signs and sizes are one of several fixed pseudo-random patterns. Two numbers that would
    change by the same amount keep their difference, so there are more amounts than one.
    """
    data, joints, place = data_of(landing.robot), landing.joint_model, 7919 * pattern

    def changed(values: Array) -> Array:
        nonlocal place
        n = np.arange(place, place + values.size)
        place += values.size
        steps = STEPS[(n * 2654435761 >> 7) & 7].reshape(values.shape)
        return np.asarray(np.where(values == 0.0, values, values + steps * np.spacing(values)))

    inertia = changed(data.inertia)
    inertia = np.triu(inertia) + np.swapaxes(np.triu(inertia, 1), 1, 2)
    fields = {name: changed(getattr(data, name)) for name in Data._fields if name != "inertia"}
    contacts, stance = (
        tuple(
            block._replace(point=changed(block.point), forces=changed(block.forces), lowest=())
            for block in blocks
        )
        for blocks in (landing.blocks[: len(landing.contacts)], landing.stance)
    )
    moved = replace(
        landing,
        q=changed(landing.q),
        before=Motion(*map(changed, landing.before)),
        joint_model=joints._replace(
            armature=changed(joints.armature), per_turn=changed(joints.per_turn)
        ),
        contacts=contacts,
        stance=stance,
    )
    return moved, data._replace(**fields, inertia=inertia)
