"""The robot and the landing with every datum changed in its last digit.

They show the effect of rounding in the input data.
"""

from dataclasses import replace

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import Motion
from shockpc.method.constraints import Constraint
from shockpc.method.exact.kinematics import Data, data_of

STEPS = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
"""Changes of a datum in units in the last place; a decimal file's last digit is as large as a few
of them.
"""


def last_digits_changed(landing: PosedLanding, pattern: int) -> tuple[PosedLanding, Data]:
    """A landing, and the numbers of its robot, with every datum changed in its last digit.

    Each changes by one to four units in the last place; zeros stay.

    The signs and sizes are one of several fixed pseudo-random patterns. Two numbers that would
    change by the same amount keep their difference, so there are more amounts than one.
    """
    changed = _LastDigits(7919 * pattern)
    data = data_of(landing.robot)
    upper = np.triu(changed(data.inertia))
    inertia = upper + np.swapaxes(np.triu(upper, 1), 1, 2)
    fields = {name: changed(getattr(data, name)) for name in Data._fields if name != "inertia"}
    struck = landing.constraints[: len(landing.contacts)]
    contacts = tuple(_changed_rows(constraint, changed) for constraint in struck)
    stance = tuple(_changed_rows(constraint, changed) for constraint in landing.stance)
    joints = landing.joint_model
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


class _LastDigits:
    """Changes numbers by a few units in the last place, by the next entries of a pattern.

    Args:
        start: entry of the pattern to begin with.
    """

    def __init__(self, start: int) -> None:
        self._next = start

    def __call__(self, values: Array) -> Array:
        """Values of any shape, changed; zeros stay."""
        n = np.arange(self._next, self._next + values.size)
        self._next += values.size
        steps = STEPS[(n * 2654435761 >> 7) & 7].reshape(values.shape)
        return np.asarray(np.where(values == 0.0, values, values + steps * np.spacing(values)))


def _changed_rows(constraint: Constraint, changed: _LastDigits) -> Constraint:
    """The rows of a contact with other numbers."""
    point = changed(constraint.point)
    return constraint._replace(point=point, forces=changed(constraint.forces), lowest=())
