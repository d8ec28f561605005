"""What varies without a landing of its own, as arrays: configurations, inertias and strikes of many
rows of one landing.
"""

import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.variation import ATTITUDE, COMPONENT, OF_A_LINK, Variation, several_joints
from shockpc.evaluation.varied_scene import armature_set
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import displaced, set_many
from shockpc.landing.strike import GRAVITY
from shockpc.method.dynamics import Inertias
from shockpc.robot.changes import Property, varied_bodies

DEG = math.pi / 180.0


def configurations(landing: PosedLanding, moved: Mapping[Variation, Array], n: int) -> Array:
    """Configurations (n, nq) of a landing whose posture varies.

    Args:
        landing: the landing.
        moved: values (n,) of what varies of the posture, in its unit; NaN leaves a row as it is.
        n: number of rows.
    """
    robot, Q = landing.robot, np.repeat(landing.q[None], n, axis=0)
    if not moved:
        return Q
    # As they are typed: angles in degrees.
    moved = {
        variation: x * (DEG if variation.unit == "deg" else 1.0) for variation, x in moved.items()
    }
    angles = {variation.kind: x for variation, x in moved.items() if variation.kind in ATTITUDE}
    if angles:
        from scipy.spatial.transform import Rotation

        present = dict(
            zip(
                ATTITUDE,
                np.radians(landing.scene.posture.base_rpy_deg or (0.0, 0.0, 0.0)),
                strict=True,
            )
        )
        rpy = np.stack(
            [_or(angles.get(kind, np.full(n, np.nan)), present[kind]) for kind in ATTITUDE], axis=1
        )
        turned = ~np.isnan([*angles.values()]).all(axis=0)
        Q[turned, 3:7] = Rotation.from_euler("xyz", rpy[turned]).as_quat()
    joints = [
        (joint, x)
        for varied, x in moved.items()
        if varied.kind == "joint"
        for joint in varied.joints(robot)
    ]
    set_many(robot, [(joint, _or(x, joint.value(landing.q))) for joint, x in joints], Q)
    for varied, x in moved.items():
        if varied.kind in COMPONENT:
            steps = np.zeros((n, robot.model.nv))
            chosen = [
                v for _, v in several_joints(robot, varied.subject, varied.kind, varied.target)
            ]
            steps[:, chosen] = _or(x, 0.0)[:, None]
            Q = displaced(robot, Q, steps)
    return Q


def inertias(landing: PosedLanding, x: Mapping[Variation, Array]) -> tuple[Inertias, np.ndarray]:
    """The inertias of n robots that are otherwise that of a landing, and which of them (n,) can be
    computed with.

    Args:
        landing: the landing.
        x: values (n,) of inertias and armatures, in their units; NaN leaves a row as it is.
    """
    n = len(next(iter(x.values())))
    of_links = [
        (cast(Property, varied.kind), varied.target, values, varied.factor)
        for varied, values in x.items()
        if varied.kind in OF_A_LINK
    ]
    bodies = varied_bodies(landing.robot, of_links)
    armature, per_turn = (
        np.repeat(part[None], n, axis=0)
        for part in (landing.joint_model.armature, landing.joint_model.per_turn)
    )
    for varied, values in x.items():
        if varied.kind == "armature":
            chosen = armature_set(landing.scene, landing.robot, varied)
            new = values[:, None] * (armature[:, chosen] if varied.factor else 1.0)
            armature[:, chosen] = _or(new, armature[:, chosen])
            if not varied.factor:  # nothing says of what gear such an armature is
                per_turn[:, chosen] = np.where(np.isnan(new), per_turn[:, chosen], 0.0)
    mass, com, inertia = (np.broadcast_to(part, (n, *part.shape[1:])) for part in bodies)
    with np.errstate(all="ignore"):
        plausible = (
            (np.where(mass > 0.0, mass, 1.0) > 1e-14)
            & (mass < 1e23)
            & (np.abs(inertia).max(axis=(-1, -2)) < 1e23)
        )
    return Inertias(mass, com, inertia, armature, armature * per_turn), plausible.all(axis=1)


def velocities(landing: PosedLanding, varied: Mapping[str, Array]) -> Array:
    """Velocities (..., 3) of the base of a landing whose strike varies, world axes [m/s].

    Args:
        landing: the landing.
        varied: values (...) of "speed" and "strike-angle" [deg]; NaN leaves a row as it is.
    """
    if not varied:
        return landing.before.velocity
    strike = landing.scene.strike
    before, normal = landing.before.velocity, landing.plane.normal
    outside = (before @ normal) * normal
    nothing = np.array([[np.nan]])
    speed = _or(varied.get("speed", nothing), float(np.linalg.norm(before - outside)))
    theta = _or(varied.get("strike-angle", nothing) * DEG, landing.strike_angle)
    if strike.drop_height is not None:
        speed = math.sqrt(2.0 * GRAVITY * strike.drop_height) / np.cos(theta)
    up = np.array([0.0, 0.0, 1.0])
    velocity: Array = outside + speed[..., None] * (
        np.sin(theta)[..., None] * landing.plane.forward - np.cos(theta)[..., None] * up
    )
    return velocity


def _or(x: Array, present: Array | float) -> Array:
    """Values (...), those that are NaN replaced by the present ones."""
    return np.where(np.isnan(x), present, x)
