"""Random landings of random robots: landing number n is the same on every machine.

Trees of 1 to 20 bodies in URDF and MJCF with joints of every kind and masses over up to eight
decades. Bases are free, planar or fixed; contacts are points or flat, stick or slide, and rebound;
feet stand, drives have inertias over ten decades or are locked, joints move before the impact,
joints follow others, and loops are closed.
"""

import numpy as np
from trees import MJCF_KINDS, SLIDES, STICKS, URDF_KINDS, random_mechanism, robot_from, written

from shockpc import Closure, Contact, Joints, LoopEnd, Robot, Scene, Strike

DIRECTIONS = (STICKS, SLIDES, ((0.6, 0.0, 0.8),))


def random_landing(number: int) -> tuple[Robot, Scene]:
    """Robot and scene of landing number n."""
    rng = np.random.default_rng([2026, number])

    def chance(probability):
        return rng.random() < probability

    dialect = ("urdf", "mjcf")[number % 2]
    n = int(rng.integers(1, 21))
    parents = [int(rng.integers(max(0, i - 3), i)) for i in range(1, n)]
    kinds = [
        str(kind) for kind in rng.choice(URDF_KINDS if dialect == "urdf" else MJCF_KINDS, n - 1)
    ]
    mechanism = random_mechanism(rng, parents, kinds, decades=float(rng.choice((0.3, 1.5, 4.0))))
    driven = [i for i, kind in enumerate(kinds, start=1) if kind not in ("spherical", "planar")]
    mimics, base = (), "free"
    if dialect == "urdf" and len(driven) > 2 and chance(0.3):
        leader, follower = (int(i) for i in rng.choice(driven, 2, replace=False))
        mimics = ((follower, leader, float(rng.choice((-1.0, 0.5, 2.3)))),)
    if len(driven) > len(mimics):
        base = str(rng.choice(("free", "free", "free", "planar", "fixed")))
    file = written(mechanism, 0, number, dialect, mimics)
    robot = robot_from(file.text, ".xml" if dialect == "mjcf" else ".urdf")
    tied = {joint for pair in mimics for joint in pair[:2]}
    single = [i for i in driven if i not in tied]

    restitution, along = (
        float(rng.choice((0.0, 0.0, 0.5, 1.0))),
        "directions" if chance(0.5) else "normal",
    )
    contacts = []
    for _ in range(int(rng.integers(1, 4))):
        body = int(rng.integers(1 if base == "fixed" else 0, n))
        contacts.append(
            Contact(
                frame=f"body{body}",
                offset=tuple(rng.normal(0.0, 0.3, 3).tolist()),
                directions=DIRECTIONS[int(rng.integers(3))],
                kind="flat" if chance(0.2) else "point",
                restitution=restitution,
                restitution_along=along,
            )
        )
    stance = (f"body{int(rng.integers(1, n))}",) if n > 2 and chance(0.25) else ()
    closure = (_closure(rng, file, n),) if n > 3 and chance(0.25) else ()
    locked = (f"joint{single.pop()}",) if len(single) > 1 and chance(0.2) else ()
    armature = (
        {f"joint{i}": float(10.0 ** rng.uniform(-6.0, 4.0)) for i in single if chance(0.3)}
        if chance(0.4)
        else {}
    )
    rates = (
        {f"joint{i}": float(rng.uniform(-0.3, 0.3)) for i in single}
        if chance(0.3) and not closure
        else {}
    )
    spin = tuple(rng.uniform(-0.2, 0.2, 3).tolist()) if base == "free" and chance(0.3) else None
    strike = Strike(
        velocity=(
            float(rng.uniform(-1, 1)),
            float(rng.uniform(-1, 1)),
            -float(rng.uniform(0.2, 1.0)),
        ),
        angular_velocity=spin,
        joint_velocities=rates,
    )
    return robot, Scene(
        robot=f"tree{number}",
        base=base,
        plane=("xz", "yz", (1.0, 2.0, 0.5))[number // 2 % 3] if base == "planar" else "xz",
        posture=file.posture,
        strike=strike,
        contact=tuple(contacts),
        stance=stance,
        closure=closure,
        joints=Joints(armature=armature, locked=locked),
    )


def _closure(rng, file, n) -> Closure:
    """Two bodies held together at a point of the first, where they stand."""
    a, b = (int(i) for i in rng.choice(n, 2, replace=False))
    point = file.origins[a] + file.rotations[a] @ rng.normal(0.0, 0.3, 3)
    ends = [
        LoopEnd(
            frame=f"body{i}",
            offset=tuple((file.rotations[i].T @ (point - file.origins[i])).tolist()),
        )
        for i in (a, b)
    ]
    return Closure(a=ends[0], b=ends[1])
