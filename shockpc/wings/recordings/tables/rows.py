"""Recorded landings as rows.

A row has a configuration, a motion before the impact, contacts, and what was measured.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import contact_name
from shockpc.landing.scenes.scene import Scene
from shockpc.method.approach import Motion


class Measured(NamedTuple):
    """A jump that was measured.

    Attributes:
        name: of its column, without its beginning.
        time: after the touchdown [ms]; None where no time is given.
        group: quantities of one unit that are compared together: "joint rates", "sliding rates" (of
            prismatic joints), "base velocity", "base angular velocity", of components of a vector
            its key, or its name.
        key: quantity of the table that predicts it, KEY@PLACE; of the base its component, "vx" …
            "wz".
        unit: of the values; empty where it is that of the quantity.
        jump: (n,) after the impact less before it; NaN where it was not measured.
    """

    name: str
    time: float | None
    group: str
    key: str
    unit: str
    jump: Array


class RecordedRows(NamedTuple):
    """The rows of a table.

    Attributes:
        labels: (n,) each: "name", by default the numbers of the rows; "contact", what strikes; and
            "time", if the table has it.
        Q: (n, nq) configurations; what the table does not give is the scene's.
        before: motions before the impact, one for each row.
        scenes: landings of which the rows are, in whatever posture and motion.
        scene: (n,) which of them each row is of.
        contact_velocity: (n, c, 3) of the contacts before the impact, world axes; NaN where it is
            that of the robot's motion [m/s].
        friction: (n,) coefficients of friction; NaN where there are none.
        effort: (n, nv) torques of motors during the landing; NaN where they are the scene's [N m,
            N].
        joints: names of the joints whose positions the table gives.
        rates: names of those whose rates it gives.
        given: what the table gives, in words.
        missing: what is the scene's, in words.
        measured: jumps that were measured.
        closed: whether loops are closed in the configurations and motions already.
        messages: why a row is no landing, by its number.
        warnings: what is doubtful of columns.
    """

    labels: Mapping[str, np.ndarray]
    Q: Array
    before: Motion
    scenes: tuple[Scene, ...]
    scene: np.ndarray
    contact_velocity: Array
    friction: Array
    effort: Array
    joints: tuple[str, ...]
    rates: tuple[str, ...]
    given: tuple[str, ...]
    missing: tuple[str, ...]
    measured: tuple[Measured, ...] = ()
    closed: bool = False
    messages: Mapping[int, str] = {}
    warnings: tuple[str, ...] = ()

    @property
    def names(self) -> np.ndarray:
        """Names (n,) of the rows."""
        return self.labels["name"]

    def key(self, row: int) -> tuple[int, float | None]:
        """Key of the landing of a row, whatever its posture and motion.

        It is the number of its scene, and its friction.
        """
        mu = float(self.friction[row])
        return int(self.scene[row]), None if np.isnan(mu) else mu

    def chunk(self, a: int, b: int) -> "RecordedRows":
        """The rows a … b, without what was measured."""
        return self._replace(
            labels={name: values[a:b] for name, values in self.labels.items()},
            Q=self.Q[a:b],
            before=Motion(*(part[a:b] for part in self.before)),
            scene=self.scene[a:b],
            contact_velocity=self.contact_velocity[a:b],
            friction=self.friction[a:b],
            effort=self.effort[a:b],
            measured=(),
            messages={i - a: text for i, text in self.messages.items() if a <= i < b},
        )


def contacts_of(scenes: Sequence[Scene], index: np.ndarray) -> np.ndarray:
    """Names of what strikes in rows (n,), as `contact_name` has them.

    Args: index, (n,) which of the scenes each row is of.
    """
    return np.asarray(np.array([contact_name(scene) for scene in scenes])[index])
