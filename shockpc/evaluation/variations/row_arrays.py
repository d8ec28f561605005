"""Configurations, inertias and strikes of many rows of one landing, as arrays."""

import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variations.kinds.joints import Armature
from shockpc.evaluation.variations.kinds.links import LinkProperty
from shockpc.evaluation.variations.kinds.posture import (
    Attitude,
    JointMotion,
    JointPosition,
)
from shockpc.evaluation.variations.variation import Variation
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import set_many
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.dynamics import Inertias
from shockpc.robot.changes import Property, varied_bodies

DEG = math.pi / 180.0

LIGHTEST, HEAVIEST = 1e-14, 1e23
"""Masses [kg] and moments of inertia [kg m²] that double precision can compute with."""


def configurations(landing: PosedLanding, moved: Mapping[Variation, Array], n: int) -> Array:
    """Configurations (n, nq) of a landing whose posture varies.

    Args:
        landing: the landing.
        moved: values (n,) of what varies of the posture, in its unit; NaN leaves a row as it is.
        n: number of rows.
    """
    robot = landing.robot
    Q = np.repeat(landing.q[None], n, axis=0)
    angles: dict[int, Array] = {}
    joints = []
    motions: list[tuple[JointMotion, Variation, Array]] = []
    for varied, values in moved.items():
        # Angles are typed in degrees.
        x = values * (DEG if varied.unit == "deg" else 1.0)
        if isinstance(varied.kind, Attitude):
            angles[varied.kind.axis] = x
        elif isinstance(varied.kind, JointPosition):
            joints += [
                (joint, _or(x, joint.value(landing.q)))
                for joint in varied.kind.joints(robot, varied)
            ]
        elif isinstance(varied.kind, JointMotion):
            motions.append((varied.kind, varied, _or(x, 0.0)))
    if angles:
        _turn_base(landing, angles, Q)
    set_many(robot, joints, Q)
    for kind, varied, x in motions:
        Q = kind.moved(robot, varied, Q, x)
    return Q


def _turn_base(landing: PosedLanding, angles: Mapping[int, Array], Q: Array) -> None:
    """Set the attitude of the base in configurations Q (n, nq).

    Args: angles (n,), of some of roll, pitch and yaw [rad]; NaN keeps that of the landing.
    """
    from scipy.spatial.transform import Rotation

    present = np.radians(landing.scene.posture.base_rpy_deg or (0.0, 0.0, 0.0))
    rpy = np.repeat(present[None], len(Q), axis=0)
    for axis, x in angles.items():
        rpy[:, axis] = _or(x, present[axis])
    turned = ~np.isnan(list(angles.values())).all(axis=0)
    Q[turned, 3:7] = Rotation.from_euler("xyz", rpy[turned]).as_quat()


def inertias(landing: PosedLanding, x: Mapping[Variation, Array]) -> tuple[Inertias, np.ndarray]:
    """The inertias of n robots, and which of them (n,) can be computed with.

    The robots are otherwise that of a landing.

    Args:
        landing: the landing.
        x: values (n,) of inertias and armatures, in their units; NaN leaves a row as it is.
    """
    n = len(next(iter(x.values())))
    changes = [
        (cast(Property, varied.kind.word), varied.target, values, varied.factor)
        for varied, values in x.items()
        if isinstance(varied.kind, LinkProperty)
    ]
    bodies = varied_bodies(landing.robot, changes)
    mass, com, inertia = (np.broadcast_to(part, (n, *part.shape[1:])) for part in bodies)
    armature = np.repeat(landing.joint_model.armature[None], n, axis=0)
    per_turn = np.repeat(landing.joint_model.per_turn[None], n, axis=0)
    for varied, values in x.items():
        if not isinstance(varied.kind, Armature):
            continue
        chosen = varied.kind.velocities(varied, landing.scene, landing.robot)
        new = values[:, None]
        if varied.factor:
            new = new * armature[:, chosen]
        else:
            # Nothing says which gear such an armature has.
            per_turn[:, chosen] = np.where(np.isnan(new), per_turn[:, chosen], 0.0)
        armature[:, chosen] = _or(new, armature[:, chosen])
    return Inertias(mass, com, inertia, armature, armature * per_turn), _possible(mass, inertia)


def _possible(mass: Array, inertia: Array) -> np.ndarray:
    """True (n,) for robots whose masses and inertias can be computed with.

    Args: mass (n, nb); inertia (n, nb, 3, 3). A body may have no mass.
    """
    with np.errstate(all="ignore"):
        not_light = (np.where(mass > 0.0, mass, 1.0) > LIGHTEST) & (mass < HEAVIEST)
        not_heavy = np.abs(inertia).max(axis=(-1, -2)) < HEAVIEST
    return np.asarray((not_light & not_heavy).all(axis=1))


def velocities(landing: PosedLanding, varied: Mapping[str, Array]) -> Array:
    """Velocities (..., 3) of the base of a landing whose strike varies, world axes [m/s].

    Args:
        landing: the landing.
        varied: values (...) of "speed" and "strike-angle" [deg]; NaN leaves a row as it is.
    """
    if not varied:
        return landing.before.velocity
    before = landing.before.velocity
    normal = landing.plane.normal
    outside = (before @ normal) * normal
    unknown = np.array([[np.nan]])
    speed = _or(varied.get("speed", unknown), float(np.linalg.norm(before - outside)))
    theta = _or(varied.get("strike-angle", unknown) * DEG, landing.strike_angle)
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


def _or(x: Array, present: Array | float) -> Array:
    """Values (...), those that are NaN replaced by the present ones."""
    return np.where(np.isnan(x), present, x)
