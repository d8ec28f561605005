"""What a landing on flat ground cannot be, and numbers that look as if they were meant in another
unit.
"""

import math
from collections.abc import Iterator

import numpy as np

from shockpc.landing.record import spelled
from shockpc.landing.scene import Contact
from shockpc.method.constraints import block_point
from shockpc.quantities.heights import levels, on_ground
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.geometry import body_outline, inflated_inertias, size_text
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few, listed

SMALL_ANGLES = (0.1, 3.2)
"""Angles in degrees of which the largest lies between these may be meant in radians, where half a
turn is 3.14.
"""

HEAVY, LIGHT, ARMATURE = 2000.0, 200.0, 10.0
"""Mass of a robot beyond which its file may give grams [kg]; reflected inertia [kg m²] that no
robot below the second mass has.
"""


def heights(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings about geometry below the contacts, and about contacts and standing feet that flat
    ground cannot touch together.

    A round foot may be struck at its centre: below a contact counts what its link's shapes reach
    without the smallest semi-axis of their ellipsoids.
    """
    landing = profile.landing
    state, up = landing.state, landing.up
    if not (level := on_ground(landing)):
        return
    along = "" if up[2] > 1.0 - 1e-9 else " (along the ground's normal)"
    outline = body_outline(landing.robot)
    shapes = [shape for carried in outline.shapes for shape in carried]
    names = [landing.blocks[k].frame for k in level]
    points = np.stack([block_point(state, landing.blocks[k]) for k in level], axis=1)
    here = levels(landing, state.rotation, state.position, points)
    core, surface, lowest = here.core[0], here.surface[0], here.contacts[0].tolist()
    below = {}
    for k, name in enumerate(names[: sum(number < len(landing.contacts) for number in level)]):
        point = float(points[0, k] @ up)
        if point - min([point, *core[here.of_contact[k]]]) > here.inside:
            below[name] = point - lowest[k]
    if below:
        low = max(below.values())
        text = (
            f"{listed(below, 4)} {'reach up to' if len(below) > 1 else 'reaches'} {low:.2g} "
            f"m{along} below the contact point; "
            f"strike the lowest point: {spelled(Contact, 'at', 'lowest')}"
        )
        yield Diagnostic("height", "+".join(below), low, text)
    first, last = names[int(np.argmin(lowest))], names[int(np.argmax(lowest))]
    low = max(lowest) - min(lowest)
    if here.uneven[0]:
        text = f'"{last}" is {low:.2g} m{along} above "{first}", so flat ground cannot touch both; '
        text += "change the posture, or leave one out"
        yield Diagnostic("height", last, low, text)
    if landing.base != "fixed" and here.below[0]:
        low, others, remedy = (
            float(here.depth[0]),
            here.others,
            "change the posture, or name what strikes",
        )
        struck = {contact.body for contact in landing.contacts}
        together = others & np.array(
            [body in struck for body, carried in enumerate(outline.shapes) for _ in carried]
        )
        # The struck body itself is named where it reaches as low as another, on whose posture the
        # warning then does not depend.
        if surface[together].min(initial=np.inf) <= surface[others].min() + here.tolerance:
            others = together
            remedy = (
                f"it moves with the contact, so name it as the contact, with "
                f"{spelled(Contact, 'at', 'lowest')}"
            )
        k = int(np.argmin(np.where(others, surface, np.inf)))
        meets = f'so flat ground meets "{shapes[k].link}" first'
        text = f'"{first}": {low:.2g} m of the robot{along} is below the contact, {meets}; {remedy}'
        yield Diagnostic("height", first, low, text)


def angles(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of degrees that look like radians, and of radians beyond a whole turn."""
    robot, posture = profile.robot, profile.scene.posture
    turns = {joint.name for joint in robot.single_joints if joint.kind != "prismatic"}
    given = {
        name: value
        for name, value in posture.joints_deg.items()
        if turns.intersection(robot.match_joints(name))
    }
    given |= zip(("roll", "pitch", "yaw"), posture.base_rpy_deg or (), strict=False)
    given |= {"strike angle": profile.scene.strike.strike_angle_deg or 0.0}
    given = {name: value for name, value in given.items() if value}
    least, most = SMALL_ANGLES
    if least <= max(map(abs, given.values()), default=0.0) <= most and any(
        value % 1.0 for value in given.values()
    ):
        text = few([f"{name} = {value:g} deg" for name, value in given.items()], 4)
        meant = few([f"{math.degrees(value):.4g}" for value in given.values()], 4)
        yield Diagnostic(
            "unit",
            "angles",
            max(given.values(), key=abs),
            f"{text}: if radians are meant, give {meant} deg",
        )
    for name, value in posture.joints.items():
        if abs(value) > 2.0 * math.pi and turns.intersection(robot.match_joints(name)):
            text = (
                f"{name} = {value:g} rad: if degrees are meant, give {math.radians(value):.4g} rad"
            )
            yield Diagnostic("unit", name, value, text)


def inertias(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of links with moments of inertia that no body within the robot has: placeholders,
    or another unit.
    """
    links = sorted(inflated_inertias(profile.robot), key=lambda one: -one[1])
    if links:
        radii = few([f'"{name}" ({radius:.3g} m)' for name, radius in links], 4)
        text = (
            f"the radius of gyration of {radii} is too large, as {size_text(profile.robot)}: the "
            f"inertia is a placeholder, "
            "or in another unit than kg m². Bodies with such a link turn far too little and every "
            "shock is wrong: "
            "correct the file"
        )
        yield Diagnostic("inertia", "+".join(name for name, _ in links), links[0][1], text)


def masses(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of masses that look like grams, and of reflected inertias that look like kg cm²."""
    robot = profile.robot
    if robot.mass > HEAVY:
        text = (
            f"the robot weighs {robot.mass:.4g} kg; if its file gives grams, that is "
            f"{robot.mass / 1000.0:.4g} kg"
        )
        yield Diagnostic("unit", "mass", robot.mass, text)
    armature = [
        (joint.name, profile.landing.joint_model.armature[joint.v].max())
        for joint in robot.single_joints
        if joint.unit == "rad"
    ]
    large = {name: float(inertia) for name, inertia in armature if inertia > ARMATURE}
    if large and robot.mass < LIGHT:
        most = max(large.values())
        text = (
            f"{listed(large, 4)}: reflected inertia up to {most:g} kg m², on a robot of "
            f"{robot.mass:.3g} kg; "
            f"if kg cm² are meant, give {most * 1e-4:g} kg m²"
        )
        yield Diagnostic("unit", "armature", most, text)


def pulled(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of contacts and standing feet that the ground would have to pull."""
    friction = profile.friction
    for number, size in enumerate(profile.value("tensile_impulse", "contact").tolist()):
        if size > 0.0:
            name, end = (
                profile.landing.blocks[number].name,
                "keep to the ground. A real foot lifts off there: leave it out",
            )
            if friction is not None and friction.state[number] != "sticks":
                end = (
                    f"stick. With the given friction it {friction.state[number]}, so use the "
                    f"results with friction"
                )
            text = f"{name} would have to be pulled by {size:.3g} N s to {end}"
            yield Diagnostic("contact", name, -size, text)


def slipping(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of contacts and standing feet that need more friction to stick than the scene gives."""
    if (given := profile.scene.friction) is None:
        return
    for block, friction in zip(
        profile.landing.blocks, profile.value("friction_needed", "contact").tolist(), strict=False
    ):
        if friction > given:
            pairs = ((f"{friction:.{n}g}", f"{given:.{n}g}") for n in range(3, 18))
            needed_text, given_text = next(pair for pair in pairs if pair[0] != pair[1])
            text = (
                f"{block.name} needs a friction of {needed_text} to stick and slides at "
                f"{given_text}. Use the results "
                "with friction; the others are for contacts that stick"
            )
            yield Diagnostic("contact", block.name, friction, text)


def gained(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where restitution would make kinetic energy, which no impact does."""
    (made,) = profile.value("energy_gained", "robot").tolist()
    if made > 0.0:
        text = (
            f"this impact would gain {made:.3g} J of kinetic energy: contacts have unequal "
            "restitution, or the restitution acts along the normal and the approach is along the "
            "ground. Take less restitution, the same for all contacts, or --restitution-along "
            "directions"
        )
        yield Diagnostic("energy", profile.robot.name, profile.energy_lost, text)
