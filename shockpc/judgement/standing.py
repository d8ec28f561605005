"""Warnings of robots that do not land as robots do.

They may lie, hang on their base, or stand on straight legs, in a posture that nobody chose.
"""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.posture import reference_name, set_joints
from shockpc.landing.scenes.scene import Scene
from shockpc.method.constraints import NO_AXES, row_jacobian
from shockpc.method.dynamics import dynamics
from shockpc.quantities.ground.support import (
    centre_of_mass,
    most_beside,
    places_of_feet,
    standing_feet,
    stands,
    support,
)
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.feet_and_sensors import BENT
from shockpc.robot.shapes.geometry import body_outline
from shockpc.robot.shapes.lowest import height_of_lowest
from shockpc.robot.usual_base import hangs
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

STRAIGHT = 0.05
"""Share of the largest motion of a limb's end, below which the smallest means a straight limb [1].

The motions are along several directions, by the limb's joints.
"""

BEND = 0.7
"""Motion of every joint of a limb with which it is not straight [rad, m].

With it the directions are counted in which the limb moves its end.
"""

MARKS = {"standing": "lies", "straight": "legs straight"}
"""Words in the row of a table for a landing with a warning, by kind."""

TURNS = {
    (0, 1): "0,90,0",
    (0, -1): "0,-90,0",
    (1, 1): "-90,0,0",
    (1, -1): "90,0,0",
    (2, 1): "180,0,0",
}
"""Roll, pitch and yaw [deg] that turn an axis of the base downward, by axis and sign.

It is the axis along which all feet lie.
"""


def lying(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where the feet are not below the belly, or not below the centre of mass.

    The belly is the lowest point of the base; without geometry it is its centre of mass. One or two
    feet may have the centre of mass beside them, but not farther than it is above them; a single
    one whose joints are set, as of a leg on a rig, anywhere.
    """
    landing, robot = profile.landing, profile.robot
    posture = landing.scene.posture
    if not stands(landing):
        return
    feet = standing_feet(robot)
    over = support(landing, landing.state)
    beside, above = float(over.beside[0]), float(over.above[0])
    (com,) = centre_of_mass(robot, landing.state)
    ground = float(com[2]) - above
    belly = _belly(profile)
    on_a_rig = len(feet) == 1 and bool(posture.joints or posture.joints_deg)
    if ground > belly - landing.scene.ground_tolerance:
        where = f"lie {max(ground - belly, 0.0):.2g} m above the lowest point of the base"
    elif beside > above * most_beside(len(feet)) and not on_a_rig:
        where = (
            f"have the centre of mass {beside:.2g} m beside their support "
            f"and {above:.2g} m above it"
        )
    else:
        return
    turn = _turn_to_feet(profile, com)
    remedy = "set its joints with --set, or turn it with --base-rpy"
    if turn is not None:
        remedy = f"turn it with --base-rpy {turn}"
    text = (
        f"the robot does not stand in this posture; {remedy}: its feet, "
        f"{listed((foot.name for foot in feet), 4)}, {where}"
    )
    yield Diagnostic("standing", robot.bodies[0].name, max(ground - belly, beside), text)


def _turn_to_feet(profile: ShockProfile, com: Array) -> str | None:
    """The roll, pitch and yaw of the base that turn the feet downward [deg].

    Returns: None for legs that sprawl both ways, as no turn brings all of them below.
    """
    landing = profile.landing
    (places,) = places_of_feet(landing, landing.state)
    towards = (places - com) @ landing.state.rotation[0, 0]
    axis = int(np.abs(towards.mean(axis=0)).argmax())
    sides = set(np.sign(towards[:, axis]).tolist())
    if len(sides) > 1:
        return None
    return TURNS.get((axis, int(sides.pop())))


def _belly(profile: ShockProfile) -> float:
    """Height of the base's lowest point, or of its centre of mass where it has no shapes [m]."""
    state = profile.landing.state
    up = state.rotation[0, 0][2]
    shapes = body_outline(profile.robot).shapes[0]
    height = float(state.position[0, 0][2])
    if not shapes:
        return height + float(up @ profile.robot.bodies[0].com)
    return height + height_of_lowest(shapes, up)


def hanging(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where the file holds the base of a robot with legs.

    It hangs in the air, and a strike is no landing.
    """
    robot = profile.robot
    if hangs(robot, profile.landing.base):
        remedy = "release it with --base free"
        if robot.source.kind == "pinocchio":
            remedy = "load it with a free base"
        text = (
            "the file holds the base, so the robot hangs on it, and an impact at its feet is no "
            f"landing; {remedy}"
        )
        yield Diagnostic("base", robot.bodies[0].name, None, text)


def straight(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of limbs that are straight, or nearly so, in a posture that nobody chose."""
    if not _posture_by_default(profile):
        return
    robot = profile.robot
    remedy = "the file of reference postures as srdf in a scene"
    if robot.source.kind == "mjcf":
        remedy = "the file a keyframe"
    postures = [name for name in robot.postures if name != BENT]
    if postures:
        remedy = f"one of its postures with --posture: {listed(postures, 4)}"
    for k in _straight_limbs(profile):
        name = profile.landing.contacts[k].frame
        factor = float(profile.value("mitigation", "contact")[k])
        known = not math.isnan(factor)
        reference = profile.landing.scene.posture.reference
        text = f'no standing posture found: {reference}, with a straight limb at "{name}"'
        if known:
            text += f"; mitigation {factor:.2g}"
        text += f"; set joints with --set, or give {remedy}"
        yield Diagnostic("straight", name, factor if known else None, text)


def _posture_by_default(profile: ShockProfile) -> bool:
    """True if the posture was taken as the robot's file has no other."""
    robot, landing = profile.robot, profile.landing
    posture = landing.scene.posture
    has_joints = posture.joints or posture.joints_deg
    if "neutral" in robot.postures or has_joints or landing.loops:
        return False
    default = reference_name(robot, None)
    return posture.reference == default and default in ("neutral", BENT)


def _straight_limbs(profile: ShockProfile) -> list[int]:
    """The contacts at the ends of straight limbs.

    With the singular values s of the Jacobian of the limb's end, it is straight if fewer of them
    than in a bent posture are above 5 % of the largest one.
    """
    landing, robot = profile.landing, profile.robot
    bent = landing.q.copy()
    single = [joint for joint in robot.single_joints if joint.axis is not None]
    set_joints(robot, [(joint, joint.value(bent) + BEND) for joint in single], bent)
    state = dynamics(robot, np.stack([landing.q, bent]))
    limbs = []
    for k, contact in enumerate(landing.contacts):
        point = contact._replace(forces=np.eye(3), moments=NO_AXES)
        of_joints = row_jacobian(state, [point])[..., 6 * robot.free_base :]
        size = np.linalg.svd(of_joints, compute_uv=False)
        least = STRAIGHT * size.max(axis=1, initial=0.0, keepdims=True)
        here, elsewhere = np.sum(size > least, axis=1)
        if here < elsewhere:
            limbs.append(k)
    return limbs


def posture_marks(scene: Scene, warnings: Iterable[Diagnostic]) -> tuple[str, ...]:
    """The reasons why a robot does not stand on bent legs in a landing, in a few words each.

    There are none if it does.

    Args:
        scene: of the landing, with every default filled in.
        warnings: of its profile.
    """
    kinds = {warning.kind for warning in warnings}
    marks = [mark for kind, mark in MARKS.items() if kind in kinds]
    if scene.base == "fixed":
        marks.append("base fixed")
    return tuple(marks)
