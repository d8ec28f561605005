"""Whether a robot whose posture nobody chose lands as robots do: it may lie, hang on its base, or
stand on straight legs.
"""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from shockpc.landing.posture import reference_name, set_joints
from shockpc.landing.scene import Scene
from shockpc.method.constraints import NO_AXES, row_jacobian
from shockpc.method.dynamics import dynamics
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.support import most_beside, standing_feet, stands, support
from shockpc.robot.feet_and_sensors import BENT
from shockpc.robot.geometry import body_outline
from shockpc.robot.lowest import height_of_lowest
from shockpc.robot.usual_base import hangs
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

STRAIGHT = 0.05
"""A limb is nearly straight if there is a direction in which its joints move its end by less than
this share of the most [1].
"""

BEND = 0.7
"""By how much every joint is moved to count the directions in which a limb that is not straight
moves its end [rad, m].
"""

MARKS = {"standing": "lies", "straight": "legs straight"}
"""What a row of a table says of a landing with a warning of these kinds."""

TURNS = {
    (0, 1): "0,90,0",
    (0, -1): "0,-90,0",
    (1, 1): "-90,0,0",
    (1, -1): "90,0,0",
    (2, 1): "180,0,0",
}
"""What turns the axis of the base along which all feet lie, and its sign, downward: roll, pitch,
yaw [deg].
"""


def lying(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where the feet are not below the belly, or do not have the centre of mass above
    them.

    The belly is the lowest point of the base; without geometry it is its centre of mass. One or two
    feet may have the centre of mass beside them, but not farther than it is above them; a single
    one whose joints are set, as of a leg on a rig, anywhere.
    """
    landing, robot, posture = profile.landing, profile.robot, profile.landing.scene.posture
    if not stands(landing):
        return
    feet, state = standing_feet(robot), landing.state
    here = support(landing, state)
    rotation, position = state.rotation[0], state.position[0]
    places = np.array([rotation[foot.body] @ foot.offset + position[foot.body] for foot in feet])
    centres = [
        R @ body.com + p for R, p, body in zip(rotation, position, robot.bodies, strict=True)
    ]
    com = robot.masses @ centres / robot.masses.sum()
    beside, above = float(here.beside[0]), float(here.above[0])
    ground, belly = float(com[2]) - above, _belly(profile)
    if ground > belly - landing.scene.ground_tolerance:
        found = f"lie {max(ground - belly, 0.0):.2g} m above the lowest point of the base"
    elif beside > above * most_beside(len(feet)) and not (
        len(feet) == 1 and (posture.joints or posture.joints_deg)
    ):
        found = f"have the centre of mass {beside:.2g} m beside their support and {above:.2g} m above it"
    else:
        return
    towards = (places - com) @ rotation[0]
    axis = int(np.abs(towards.mean(axis=0)).argmax())
    # of legs that sprawl both, so no turn brings all of them below
    sides = set(np.sign(towards[:, axis]).tolist())
    turn = TURNS.get((axis, int(sides.pop()))) if len(sides) == 1 else None
    remedy = (
        f"turn it with --base-rpy {turn}"
        if turn
        else "set its joints with --set, or turn it with --base-rpy"
    )
    text = (
        f"the robot does not stand in this posture; {remedy}: its feet, "
        f"{listed((foot.name for foot in feet), 4)}, {found}"
    )
    yield Diagnostic("standing", robot.bodies[0].name, max(ground - belly, beside), text)


def _belly(profile: ShockProfile) -> float:
    """Height of the lowest point of the base, or of its centre of mass where it has no shapes [m]."""
    state = profile.landing.state
    up = state.rotation[0, 0][2]
    shapes = body_outline(profile.robot).shapes[0]
    height = float(state.position[0, 0][2])
    if not shapes:
        return height + float(up @ profile.robot.bodies[0].com)
    return height + height_of_lowest(shapes, up)


def hanging(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where the file holds the base of a robot with legs: it hangs in the air, and a
    strike is no landing.
    """
    robot = profile.robot
    if hangs(robot, profile.landing.base):
        remedy = (
            "load it with a free base"
            if robot.source.kind == "pinocchio"
            else "release it with --base free"
        )
        text = (
            f"the file holds the base, so the robot hangs on it, and a strike at its feet is no "
            f"landing; {remedy}"
        )
        yield Diagnostic("base", robot.bodies[0].name, None, text)


def straight(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of limbs that are straight, or nearly so, in the neutral posture, which was taken as
    the robot has no other.

    With the singular values s of the Jacobian of the limb's end, it is straight if fewer of them
    than in a bent posture are above 5 % of the largest one.
    """
    landing, robot, posture = profile.landing, profile.robot, profile.landing.scene.posture
    by_default = posture.reference == reference_name(robot, None) and posture.reference in (
        "neutral",
        BENT,
    )
    if (
        not by_default
        or "neutral" in robot.postures
        or posture.joints
        or posture.joints_deg
        or landing.loops
    ):
        return
    bent, single = (
        landing.q.copy(),
        [joint for joint in robot.single_joints if joint.axis is not None],
    )
    set_joints(robot, [(joint, joint.value(bent) + BEND) for joint in single], bent)
    state = dynamics(robot, np.stack([landing.q, bent]))
    limbs = []
    for k, block in enumerate(landing.contacts):
        moved = row_jacobian(state, [block._replace(forces=np.eye(3), moments=NO_AXES)])[
            ..., 6 * robot.free_base :
        ]
        size = np.linalg.svd(moved, compute_uv=False)
        here, elsewhere = np.sum(
            size > STRAIGHT * size.max(axis=1, initial=0.0, keepdims=True), axis=1
        )
        if here < elsewhere:
            limbs.append(k)
    remedy = (
        "the file a keyframe" if robot.source.kind == "mjcf" else "reference postures with --srdf"
    )
    others = [name for name in robot.postures if name != BENT]
    if others:
        remedy = f"one of its postures with --posture: {listed(others, 4)}"
    for k in limbs:
        name, factor = landing.contacts[k].frame, float(profile.value("mitigation", "contact")[k])
        text = f'no standing posture found: {posture.reference}, with a straight limb at "{name}"'
        text += "" if math.isnan(factor) else f"; mitigation {factor:.2g}"
        text += f"; set joints with --set, or give {remedy}"
        yield Diagnostic("straight", name, None if math.isnan(factor) else factor, text)


def posture_marks(scene: Scene, warnings: Iterable[Diagnostic]) -> tuple[str, ...]:
    """Why a landing is another than that of a robot that stands on bent legs, in a few words each;
    empty if it is not.

    Args:
        scene: of the landing, with every default filled in.
        warnings: of its profile.
    """
    kinds = {warning.kind for warning in warnings}
    return (
        *(mark for kind, mark in MARKS.items() if kind in kinds),
        *["base fixed"] * (scene.base == "fixed"),
    )
