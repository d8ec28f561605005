"""Whether a robot whose base nobody turned stands on its feet, or lies: on its side as its file has it, or with its legs spread."""

from collections.abc import Iterator

import numpy as np

from shockpc.core.spatial import Array
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.bent_legs import ends_leg
from shockpc.robot.feet_and_sensors import each_foot
from shockpc.robot.geometry import body_outline
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

BESIDE = 0.1
"""Distance of the centre of mass from the support of three feet or more, as a share of its height, up to which they carry it."""

TURNS = {(0, 1): "0,90,0", (0, -1): "0,-90,0", (1, 1): "-90,0,0", (1, -1): "90,0,0", (2, 1): "180,0,0"}
"""What turns the axis of the base along which all feet lie, and its sign, downward: roll, pitch, yaw [deg]."""


def lying(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where the feet are not below the belly, or do not have the centre of mass above them.

    The belly is the lowest point of the base; without geometry it is its centre of mass. One or two feet may have the centre of
    mass beside them, but not farther than it is above them; a single one whose joints are set, as of a leg on a rig, anywhere.
    """
    landing, robot, posture = profile.landing, profile.robot, profile.landing.scene.posture
    feet = [robot.frame(name) for name in each_foot(robot) if ends_leg(robot, name, wheels=False)]
    turned = posture.base_rpy_deg is not None or posture.base_quaternion is not None
    if not feet or turned or landing.base == "fixed" or landing.up[2] < 1.0 - 1e-9:
        return
    rotation, position, shapes = landing.state.rotation[0], landing.state.position[0], body_outline(robot).shapes

    def lowest(body: int, point: Array) -> float:
        """Height of the shapes of a body, and without any of a point of it."""
        down = -rotation[body][2]
        reach = [float(shape.reach(down[None])[0]) for shape in shapes[body]] or [float(down @ point)]
        return float(position[body][2]) - max(reach)

    ground, belly = min(lowest(foot.body, foot.offset) for foot in feet), lowest(0, robot.bodies[0].com)
    places = np.array([rotation[foot.body] @ foot.offset + position[foot.body] for foot in feet])
    centres = [R @ body.com + p for R, p, body in zip(rotation, position, robot.bodies, strict=True)]
    com = robot.masses @ centres / robot.masses.sum()
    beside, above = _distance(places[:, :2], com[:2]), float(com[2]) - ground
    if ground > belly - landing.scene.ground_tolerance:
        found = f"lie {max(ground - belly, 0.0):.2g} m above the lowest point of the base"
    elif beside > above * (BESIDE if len(feet) > 2 else 1.0) and not (len(feet) == 1 and (posture.joints or posture.joints_deg)):
        found = f"have the centre of mass {beside:.2g} m beside their support and {above:.2g} m above it"
    else:
        return
    towards = (places - com) @ rotation[0]
    axis = int(np.abs(towards.mean(axis=0)).argmax())
    sides = set(np.sign(towards[:, axis]).tolist())  # of legs that sprawl both, so no turn brings all of them below
    turn = TURNS.get((axis, int(sides.pop()))) if len(sides) == 1 else None
    remedy = f"turn it with --base-rpy {turn}" if turn else "set its joints with --set, or turn it with --base-rpy"
    text = f"the robot does not stand in this posture; {remedy}: its feet, {listed((foot.name for foot in feet), 4)}, {found}"
    yield Diagnostic("standing", robot.bodies[0].name, max(ground - belly, beside), text)


def _distance(points: Array, place: Array) -> float:
    """Distance of a place (2,) from the convex hull of points (k, 2), zero inside."""
    start, along = points[:, None], points - points[:, None]
    share = np.sum((place - start) * along, axis=2) / np.maximum(np.sum(along**2, axis=2), 1e-300)
    away = (place - start - np.clip(share, 0.0, 1.0)[..., None] * along).reshape(-1, 2)  # from the segments between points
    nearest = away[np.linalg.norm(away, axis=1).argmin()]
    return float(np.linalg.norm(nearest)) if ((points - place) @ nearest < 0.0).all() else 0.0
