"""Configurations, inertias and strikes of many rows of one landing, as arrays.

Each is set by what varies, one quantity after the other; NaN leaves a row as it is.
"""

import math

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import displaced, set_many
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.dynamics import Inertias
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.changes import varied_bodies

LIGHTEST, HEAVIEST = 1e-14, 1e23
"""Masses [kg] and moments of inertia [kg m²] that double precision can compute with."""


class RowPostures:
    """The postures of n rows of a landing.

    Attributes:
        rpy: (n, 3) roll, pitch and yaw of the base [rad]; NaN where they are those of the landing.
    """

    def __init__(self, landing: PosedLanding, n: int) -> None:
        self.landing = landing
        self.rpy = np.full((n, 3), np.nan)
        self._positions: list[tuple[Joint, Array]] = []
        self._steps: list[Array] = []

    def set_position(self, joint: Joint, x: Array) -> None:
        """Set the position of a joint. Args: x (n,) [rad, m]."""
        self._positions.append((joint, or_present(x, joint.value(self.landing.q))))

    def move(self, velocities: list[int], x: Array) -> None:
        """Move along joint velocities, after attitude and positions are set.

        Args: velocities, their indices; x (n,), how far [rad, m].
        """
        steps = np.zeros((len(x), self.landing.robot.model.nv))
        steps[:, velocities] = or_present(x, 0.0)[:, None]
        self._steps.append(steps)

    def configurations(self) -> Array:
        """Configurations (n, nq)."""
        robot = self.landing.robot
        Q = np.repeat(self.landing.q[None], len(self.rpy), axis=0)
        self._turn_base(Q)
        set_many(robot, self._positions, Q)
        for steps in self._steps:
            Q = displaced(robot, Q, steps)
        return Q

    def _turn_base(self, Q: Array) -> None:
        """Set the attitude of the base in configurations Q (n, nq)."""
        turned = ~np.isnan(self.rpy).all(axis=1)
        if not turned.any():
            return
        from scipy.spatial.transform import Rotation

        present = np.radians(self.landing.scene.posture.base_rpy_deg or (0.0, 0.0, 0.0))
        rpy = or_present(self.rpy, present)
        Q[turned, 3:7] = Rotation.from_euler("xyz", rpy[turned]).as_quat()


class RowInertias:
    """The inertias of n rows of a landing.

    Attributes:
        armature: (n, nv) reflected inertias [kg m², kg].
        per_turn: (n, nv) as `JointModel.per_turn`.
    """

    def __init__(self, landing: PosedLanding, n: int) -> None:
        self.landing = landing
        self.armature = np.repeat(landing.joint_model.armature[None], n, axis=0)
        self.per_turn = np.repeat(landing.joint_model.per_turn[None], n, axis=0)
        self._changes: list[tuple[str, str, Array, bool]] = []

    def change_links(self, kind: str, pattern: str, x: Array, factor: bool) -> None:
        """Change a property of links. Args: x (n,), values as in `varied_bodies`."""
        self._changes.append((kind, pattern, x, factor))

    def set_armature(self, velocities: np.ndarray, x: Array, factor: bool) -> None:
        """Set the reflected inertia of some joints.

        Args:
            velocities: (nv,) of these joints, as a mask.
            x: (n,) inertias, or factors of the present ones.
            factor: whether they are factors.
        """
        present = self.armature[:, velocities]
        new = x[:, None]
        if factor:
            new = new * present
        else:
            # Nothing says which gear such an armature has.
            gears = self.per_turn[:, velocities]
            self.per_turn[:, velocities] = np.where(np.isnan(new), gears, 0.0)
        self.armature[:, velocities] = or_present(new, present)

    def inertias(self) -> tuple[Inertias, np.ndarray]:
        """The inertias, and which of them (n,) can be computed with."""
        n = len(self.armature)
        bodies = varied_bodies(self.landing.robot, self._changes)
        mass, com, inertia = (np.broadcast_to(part, (n, *part.shape[1:])) for part in bodies)
        coupled = self.armature * self.per_turn
        return Inertias(mass, com, inertia, self.armature, coupled), _possible(mass, inertia)


def _possible(mass: Array, inertia: Array) -> np.ndarray:
    """True (n,) for robots whose masses and inertias can be computed with.

    Args: mass (n, nb); inertia (n, nb, 3, 3). A body may have no mass.
    """
    with np.errstate(all="ignore"):
        not_light = (np.where(mass > 0.0, mass, 1.0) > LIGHTEST) & (mass < HEAVIEST)
        not_heavy = np.abs(inertia).max(axis=(-1, -2)) < HEAVIEST
    return np.asarray((not_light & not_heavy).all(axis=1))


class RowStrikes:
    """The strikes of rows of a landing, as arrays (...) that broadcast against each other.

    Attributes:
        speed: in the plane of the strike [m/s]; NaN where it is the landing's.
        angle: from straight down towards forward [rad]; NaN where it is the landing's.
    """

    def __init__(self, landing: PosedLanding) -> None:
        self.landing = landing
        self.speed: Array = np.array([[np.nan]])
        self.angle: Array = np.array([[np.nan]])

    def velocities(self) -> Array:
        """Velocities (..., 3) of the base before the impact, world axes [m/s]."""
        landing = self.landing
        before = landing.before.velocity
        normal = landing.plane.normal
        outside = (before @ normal) * normal
        speed = or_present(self.speed, float(np.linalg.norm(before - outside)))
        theta = or_present(self.angle, landing.strike_angle)
        drop_height = landing.scene.strike.drop_height
        if drop_height is not None:
            # A drop has the vertical velocity √(2 g h) at any angle.
            speed = math.sqrt(2.0 * GRAVITY * drop_height) / np.cos(theta)
        # v = v_outside + |v| (sin θ forward − cos θ up)
        up = np.array([0.0, 0.0, 1.0])
        forward = np.sin(theta)[..., None] * landing.plane.forward
        downward = np.cos(theta)[..., None] * up
        velocity: Array = outside + speed[..., None] * (forward - downward)
        return velocity


def or_present(x: Array, present: Array | float) -> Array:
    """Values (...), those that are NaN replaced by the present ones."""
    return np.where(np.isnan(x), present, x)
