"""Warnings of landings that flat ground does not allow, and of numbers in another unit."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.scenes.scene import Contact
from shockpc.landing.scenes.scene_fields import spelled
from shockpc.method.constraints import constraint_point
from shockpc.quantities.ground.levels import Levels, levels, on_ground
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.geometry import body_outline, inflated_inertias, size_text
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few, listed

SMALL_ANGLES = (0.1, 3.2)
"""Range of the largest of some angles in degrees that may be meant in radians.

Half a turn is 3.14 rad.
"""

HEAVY, LIGHT, ARMATURE = 2000.0, 200.0, 10.0
"""Limits of plausible masses [kg] and reflected inertias [kg m²].

Beyond the first mass the file of a robot may give grams. No robot below the second mass has the
reflected inertia.
"""


class _OnGround(NamedTuple):
    """The contacts and standing feet on flat ground.

    Attributes:
        names: (c,) of them; the contacts come first.
        points: (c, 3) their points, from the base [m].
        levels: heights of the robot's geometry.
        along: along what heights are, in words; empty for the vertical.
    """

    names: list[str]
    points: Array
    levels: Levels
    along: str


def heights(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings about heights over flat ground of contacts, standing feet and other geometry."""
    landing, state = profile.landing, profile.landing.state
    numbers = on_ground(landing)
    if not numbers:
        return
    held = [landing.constraints[k] for k in numbers]
    points = np.stack([constraint_point(state, constraint) for constraint in held], axis=1)
    level_ground = landing.up[2] > 1.0 - 1e-9
    ground = _OnGround(
        names=[constraint.frame for constraint in held],
        points=points[0],
        levels=levels(landing, state.rotation, state.position, points),
        along="" if level_ground else " (along the ground's normal)",
    )
    yield from _below_their_points(profile, ground)
    yield from _uneven(ground)
    yield from _below_the_contacts(profile, ground)


def _below_their_points(profile: ShockProfile, ground: _OnGround) -> Iterator[Diagnostic]:
    """A warning of contacts whose links reach below the contact point.

    A round foot may be struck at its centre: below a contact counts what its link's shapes reach
    without the smallest semi-axis of their ellipsoids.
    """
    landing, here = profile.landing, ground.levels
    contacts = [k for k in on_ground(landing) if k < len(landing.contacts)]
    below = dict[str, float]()
    for k, name in enumerate(ground.names[: len(contacts)]):
        point = float(ground.points[k] @ landing.up)
        lowest = min([point, *here.core[0][here.of_contact[k]]])
        if point - lowest > here.inside:
            below[name] = point - float(here.contacts[0, k])
    if below:
        depth = max(below.values())
        reach = "reach up to" if len(below) > 1 else "reaches"
        text = (
            f"{listed(below, 4)} {reach} {depth:.2g} m{ground.along} below the contact point; "
            f"land on the lowest point: {spelled(Contact, 'at', 'lowest')}"
        )
        yield Diagnostic("height", "+".join(below), depth, text)


def _uneven(ground: _OnGround) -> Iterator[Diagnostic]:
    """A warning of contacts and standing feet that flat ground cannot touch together."""
    if ground.levels.uneven[0]:
        lowest = ground.levels.contacts[0]
        first = ground.names[int(lowest.argmin())]
        last = ground.names[int(lowest.argmax())]
        height = float(lowest.max()) - float(lowest.min())
        text = (
            f'"{last}" is {height:.2g} m{ground.along} above "{first}", so flat ground cannot '
            f"touch both; change the posture, or leave one out"
        )
        yield Diagnostic("height", last, height, text)


def _below_the_contacts(profile: ShockProfile, ground: _OnGround) -> Iterator[Diagnostic]:
    """A warning of other links that flat ground meets before the contacts."""
    landing, here = profile.landing, ground.levels
    if landing.base == "fixed" or not here.below[0]:
        return
    struck = {contact.body for contact in landing.contacts}
    shapes = list[Shape]()
    of_struck = list[bool]()
    for body, carried in enumerate(body_outline(landing.robot).shapes):
        shapes += carried
        of_struck += [body in struck] * len(carried)

    # The struck body itself is named where it reaches as low as another, on whose posture the
    # warning then does not depend.
    surface = here.surface[0]
    first_met = here.of_no_contact
    remedy = "change the posture, or name what strikes"
    together = first_met & np.array(of_struck)
    lowest = surface[first_met].min()
    if surface[together].min(initial=np.inf) <= lowest + here.tolerance:
        first_met = together
        remedy = (
            f"it moves with the contact, so name it as the contact, with "
            f"{spelled(Contact, 'at', 'lowest')}"
        )
    link = shapes[int(np.argmin(np.where(first_met, surface, np.inf)))].link
    first = ground.names[int(here.contacts[0].argmin())]
    depth = float(here.depth[0])
    text = (
        f'"{first}": {depth:.2g} m of the robot{ground.along} is below the contact, so flat ground '
        f'meets "{link}" first; {remedy}'
    )
    yield Diagnostic("height", first, depth, text)


def angles(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of degrees that look like radians, and of radians beyond a whole turn."""
    robot, posture = profile.robot, profile.scene.posture
    turns = {joint.name for joint in robot.single_joints if joint.kind != "prismatic"}
    degrees = dict[str, float]()
    for name, value in posture.joints_deg.items():
        if turns.intersection(robot.match_joints(name)):
            degrees[name] = value
    degrees.update(zip(("roll", "pitch", "yaw"), posture.base_rpy_deg or (), strict=False))
    degrees["strike angle"] = profile.scene.strike.strike_angle_deg or 0.0
    degrees = {name: value for name, value in degrees.items() if value}
    yield from _looks_like_radians(degrees)
    for name, value in posture.joints.items():
        if abs(value) > 2.0 * math.pi and turns.intersection(robot.match_joints(name)):
            text = (
                f"{name} = {value:g} rad: if degrees are meant, give {math.radians(value):.4g} rad"
            )
            yield Diagnostic("unit", name, value, text)


def _looks_like_radians(degrees: dict[str, float]) -> Iterator[Diagnostic]:
    """A warning of angles in degrees that are as small as radians, and not all whole."""
    least, most = SMALL_ANGLES
    largest = max(degrees.values(), key=abs, default=0.0)
    are_whole = not any(value % 1.0 for value in degrees.values())
    if not least <= abs(largest) <= most or are_whole:
        return
    texts = [f"{name} = {value:g} deg" for name, value in degrees.items()]
    meant = [f"{math.degrees(value):.4g}" for value in degrees.values()]
    text = f"{few(texts, 4)}: if radians are meant, give {few(meant, 4)} deg"
    yield Diagnostic("unit", "angles", largest, text)


def large_inertias(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning of links with moments of inertia that no body within the robot has.

    They are placeholders, or in another unit.
    """
    links = sorted(inflated_inertias(profile.robot), key=lambda link: -link[1])
    if links:
        radii = few([f'"{name}" ({radius:.3g} m)' for name, radius in links], 4)
        text = (
            f"the radius of gyration of {radii} is too large, as {size_text(profile.robot)}: the "
            "inertia is a placeholder, or in another unit than kg m². Bodies with such a link turn "
            "far too little and every shock is wrong: correct the file"
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
    armature = profile.landing.joint_model.armature
    large = dict[str, float]()
    for joint in robot.single_joints:
        inertia = float(armature[joint.v].max())
        if joint.unit == "rad" and inertia > ARMATURE:
            large[joint.name] = inertia
    if large and robot.mass < LIGHT:
        most = max(large.values())
        text = (
            f"{listed(large, 4)}: reflected inertia up to {most:g} kg m², on a robot of "
            f"{robot.mass:.3g} kg; if kg cm² are meant, give {most * 1e-4:g} kg m²"
        )
        yield Diagnostic("unit", "armature", most, text)


def pulled(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of contacts and standing feet that the ground would have to pull."""
    friction = profile.friction
    for number, size in enumerate(profile.value("tensile_impulse", "contact").tolist()):
        if size > 0.0:
            name = profile.landing.constraints[number].name
            end = "keep to the ground. A real foot lifts off there: leave it out"
            if friction is not None and friction.state[number] != "sticks":
                end = (
                    f"stick. With the given friction it {friction.state[number]}, so use the "
                    f"results with friction"
                )
            text = f"{name} would have to be pulled by {size:.3g} N s to {end}"
            yield Diagnostic("contact", name, -size, text)


def slipping(profile: ShockProfile) -> Iterator[Diagnostic]:
    """Warnings of contacts and standing feet that need more friction to stick than is given."""
    friction = profile.scene.friction
    if friction is None:
        return
    needed = profile.value("friction_needed", "contact").tolist()
    for contact, least in zip(profile.landing.constraints, needed, strict=False):
        if least > friction:
            of_scene, to_stick = _told_apart(friction, least)
            text = (
                f"{contact.name} needs a friction of {to_stick} to stick and slides at {of_scene}. "
                "Use the results with friction; the others are for contacts that stick"
            )
            yield Diagnostic("contact", contact.name, least, text)


def _told_apart(first: float, second: float) -> tuple[str, str]:
    """Two numbers with as many digits as tell them apart, at least three."""
    for digits in range(3, 17):
        texts = f"{first:.{digits}g}", f"{second:.{digits}g}"
        if texts[0] != texts[1]:
            return texts
    return f"{first:.17g}", f"{second:.17g}"


def gained(profile: ShockProfile) -> Iterator[Diagnostic]:
    """A warning where restitution would make kinetic energy, which no impact does."""
    # Without restitution v⁺ = 0, and the impact loses −λᵀ v⁻ / 2 = v⁻ᵀ Λ v⁻ / 2 ≥ 0.
    if not any(constraint.restitution for constraint in profile.landing.constraints):
        return
    (energy,) = profile.value("energy_gained", "robot").tolist()
    if energy > 0.0:
        text = (
            f"this impact would gain {energy:.3g} J of kinetic energy: contacts have unequal "
            "restitution, or the restitution acts along the normal and the approach is along the "
            "ground. Take less restitution, the same for all contacts, or --restitution-along "
            "directions"
        )
        yield Diagnostic("energy", profile.robot.name, profile.energy_lost, text)
