"""Whether a robot whose base nobody turned stands on its feet, or lies: on its side as its file has it, or with its legs spread."""

from collections.abc import Iterator

import numpy as np

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.support import most_beside, standing_feet, stands, support
from shockpc.robot.geometry import body_outline
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import listed

TURNS = {(0, 1): "0,90,0", (0, -1): "0,-90,0", (1, 1): "-90,0,0", (1, -1): "90,0,0", (2, 1): "180,0,0"}
"""What turns the axis of the base along which all feet lie, and its sign, downward: roll, pitch, yaw [deg]."""


def lying(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where the feet are not below the belly, or do not have the centre of mass above them.

    The belly is the lowest point of the base; without geometry it is its centre of mass. One or two feet may have the centre of
    mass beside them, but not farther than it is above them; a single one whose joints are set, as of a leg on a rig, anywhere.
    """
    landing, robot, posture = profile.landing, profile.robot, profile.landing.scene.posture
    if not stands(landing):
        return
    feet, state = standing_feet(robot), landing.state
    here = support(landing, state)
    rotation, position = state.rotation[0], state.position[0]
    places = np.array([rotation[foot.body] @ foot.offset + position[foot.body] for foot in feet])
    centres = [R @ body.com + p for R, p, body in zip(rotation, position, robot.bodies, strict=True)]
    com = robot.masses @ centres / robot.masses.sum()
    beside, above = float(here.beside[0]), float(here.above[0])
    ground, belly = float(com[2]) - above, _belly(profile)
    if ground > belly - landing.scene.ground_tolerance:
        found = f"lie {max(ground - belly, 0.0):.2g} m above the lowest point of the base"
    elif beside > above * most_beside(len(feet)) and not (len(feet) == 1 and (posture.joints or posture.joints_deg)):
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


def _belly(profile: ShockProfile) -> float:
    """Height of the lowest point of the base, or of its centre of mass where it has no shapes [m]."""
    state, shapes = profile.landing.state, body_outline(profile.robot).shapes[0]
    down = -state.rotation[0, 0][2]
    reach = [float(shape.reach(down[None])[0]) for shape in shapes] or [float(down @ profile.robot.bodies[0].com)]
    return float(state.position[0, 0][2]) - max(reach)
