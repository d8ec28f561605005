"""Postures that differ in the value of a joint: what follows it moves along, and loops are followed."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.closure import follow
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import fixed_joints, set_many
from shockpc.robot.robot import Joint
from shockpc.text.errors import SceneError, StudyError


@dataclass(frozen=True, eq=False)
class JointPath:
    """Configurations of a robot by the value of one joint, or of several with the same value.

    Attributes:
        landing: from whose posture loops are followed.
        joints: that are moved.
    """

    landing: PosedLanding
    joints: Sequence[Joint]

    @cached_property
    def fixed(self) -> np.ndarray:
        """Which joint velocities (nv,) closing loops leaves as they are."""
        robot, moved = self.landing.robot, {joint.name for joint in self.joints}
        led = [mimic.joint for mimic in robot.mimics if not moved.isdisjoint(mimic.leaders)]
        fixed = fixed_joints(robot, self.landing.scene.posture, self.landing.scene.assemble)
        return np.asarray(fixed | robot.velocities([*moved, *led]))

    def at(self, values: Array, near: Array) -> Array:
        """Configurations (m, nq) at values (m,) [rad, m]. Args: near (m, nq) closed ones, from which each of them is followed.

        Raises:
            SceneError: a loop cannot be closed.
        """
        Q = np.array(near)
        set_many(self.landing.robot, [(joint, values) for joint in self.joints], Q)
        loops, plane = self.landing.loops, self.landing.plane
        for i in range(len(Q)) if loops else ():
            Q[i] = follow(self.landing.robot, near[i], Q[i], loops, plane, self.fixed)
        return Q

    def along(self, values: Array, fine: float) -> tuple[Array, Array, list[tuple[float, float, str]]]:
        """The values (n,) among some that can be reached, ascending, and their configurations (n, nq).

        Loops are followed from the landing's posture in both directions, each from the one before, so that they stay assembled
        in the same way; where they can no longer be closed, the walk ends.

        Args:
            values: ascending [rad, m].
            fine: to which the value is found beyond which a loop cannot be closed [rad, m].

        Returns: these, and the least and greatest value of each range that cannot be reached, with the reason.

        Raises:
            StudyError: no loop can be closed at any value.
        """
        q = self.landing.q
        if not self.landing.loops:
            return values, self.at(values, np.repeat(q[None], len(values), axis=0)), []
        start = int(np.argmin(np.abs(values - self.joints[0].value(q))))
        reached: dict[float, Array] = {}
        refused: list[tuple[float, float, str]] = []
        for walk in (values[start:].tolist(), values[start::-1].tolist()):
            near, last = q, None
            for value in walk:
                try:
                    near = self._closed(value, near)
                except SceneError as refusal:
                    if last is not None:
                        last, near = self._farthest(last, value, near, fine)
                        reached[last] = near
                    beyond = value if last is None else last
                    refused.append((min(beyond, walk[-1]), max(beyond, walk[-1]), str(refusal)))
                    break
                reached[value], last = near, value
        if not reached:
            raise StudyError(f"no value in the range can be assembled: {refused[0][2]}")
        ascending = sorted(reached)
        return np.array(ascending), np.stack([reached[value] for value in ascending]), refused

    def _closed(self, value: float, near: Array) -> Array:
        return np.asarray(self.at(np.array([value]), near[None])[0])

    def _farthest(self, good: float, bad: float, near: Array, fine: float) -> tuple[float, Array]:
        """The last value that loops can reach between one that they can and one that they cannot, and its configuration."""
        while abs(bad - good) > fine:
            middle = (good + bad) / 2.0
            try:
                near, good = self._closed(middle, near), middle
            except SceneError:
                bad = middle
        return good, near
