"""What a landing on flat ground cannot be, and numbers that look as if they were meant in another unit."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.landing.dynamics import dynamics
from shockpc.landing.landing import Landing, PosedLanding
from shockpc.landing.posture import reference_name, set_joints
from shockpc.landing.rows import NO_AXES, block_point, row_jacobian
from shockpc.robot.geometry import body_outline, inflated_inertias, robot_size
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.printed import few, listed

INSIDE, SHARE = 0.02, 0.01
"""A contact point may lie in the middle of a foot or on the centre line of a beam: 2 cm [m] and a hundredth of the robot's size
above the lowest point of its link."""

STRAIGHT = 0.02
"""A limb cannot move its end in a direction in which the joints move it by less than this share of what they do elsewhere [1]."""

BEND = 0.7
"""By how much every joint is moved to count the directions in which a limb that is not straight moves its end [rad, m]."""

ROUNDING = 1e-12
"""Share of the work of the impulse below which a gain of energy is the rounding of the data: a full rebound loses none."""

SMALL_ANGLES = (0.1, 3.2)
"""Angles in degrees of which the largest lies between these may be meant in radians, where half a turn is 3.14."""

HEAVY, LIGHT, ARMATURE = 2000.0, 200.0, 10.0
"""Mass of a robot beyond which its file may give grams [kg]; reflected inertia [kg m²] that no robot below the second mass has."""


def implausible(landing: PosedLanding, mitigation: Mapping[str, float | None]) -> tuple[Diagnostic, ...]:
    """Warnings about placeholders of inertias, heights, a limb that is straight because no posture is known, and units."""
    return (*_inertias(landing), *heights(landing), *_straight(landing, mitigation), *_angles(landing), *_masses(landing))


class Levels(NamedTuple):
    """Heights of a robot's geometry over its base in N postures [m].

    Attributes:
        core: (N, n) as `surface`, without the least semi-axis of the ellipsoid that rounds a shape.
        surface: (N, n) the lowest points of the shapes; inf of those of a body that is wholly above all contact points.
        contacts: (N, c) the lowest points of the contacts and standing feet: of their shapes, or the contact points.
        own: (c, n) which shapes belong to each of these.
        others: (n,) which shapes belong to none.
        inside: how far a contact point may lie above the lowest point of its link.
        tolerance: the scene's, by how much lowest points may differ in height that flat ground touches together.
    """

    core: Array
    surface: Array
    contacts: Array
    own: np.ndarray
    others: np.ndarray
    inside: float
    tolerance: float

    @property
    def clearance(self) -> Array:
        """Height (N,) of the lowest of the other links above the lowest contact, below zero under it; NaN without geometry."""
        if not self.others.size:
            return np.full(len(self.contacts), np.nan)
        return np.asarray(self.surface[:, self.others].min(axis=1, initial=np.inf) - self.contacts.min(axis=1))

    @property
    def depth(self) -> Array:
        """How far (N,) other links reach below the lowest contact, 0 where they do not; NaN without geometry."""
        return np.maximum(-self.clearance, 0.0)

    @property
    def below(self) -> np.ndarray:
        """Whether (N,) other links are so far below the contacts that flat ground meets them first; never without geometry."""
        return np.asarray(self.depth > self.tolerance)

    @property
    def spread(self) -> Array:
        """Difference in height (N,) of the contacts and standing feet."""
        return np.asarray(np.ptp(self.contacts, axis=1))

    @property
    def uneven(self) -> np.ndarray:
        """Whether (N,) the contacts and standing feet differ so much in height that flat ground cannot touch all of them."""
        return np.asarray(self.spread > self.tolerance)


def on_ground(landing: Landing) -> list[int]:
    """Numbers of the contacts and standing feet on flat ground: those that have the normal of the first."""
    return [k for k, block in enumerate((*landing.contacts, *landing.stance)) if block.normal @ landing.up > 1.0 - 1e-9]


def levels(landing: Landing, rotation: Array, position: Array, points: Array) -> Levels:
    """Heights of the geometry in N postures.

    Args:
        landing: names the contacts and the standing feet.
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) their origins, from the base [m].
        points: (N, c, 3) of the contacts and standing feet on flat ground, from the base [m].
    """
    robot, up, outline = landing.robot, landing.up, body_outline(landing.robot)
    shapes, pieces = [shape for own in outline.shapes for shape in own], outline.pieces
    surface, ground = np.full((len(shapes), len(rotation)), np.inf), (points @ up).max(axis=1)
    for body, (n, corners, axes, radius) in enumerate(_by_body(robot)):
        rising, height = up @ rotation[:, body], position[:, body] @ up
        low = np.flatnonzero(height - radius <= ground)
        if low.size:
            reach = np.maximum.reduceat(corners @ -rising[low].T, pieces.start[n] - pieces.start[n[0]], axis=0)
            if axes.any():
                reach += np.sqrt(((axes @ rising[low].T) ** 2).reshape(3, len(n), -1).sum(axis=0))
            surface[n[:, None], low] = height[low] - reach
    surface = surface.T
    core = surface + np.linalg.norm(pieces.rounding, axis=1).min(axis=1)
    held, inside, height = (*landing.contacts, *landing.stance), INSIDE + SHARE * robot_size(robot), points @ up
    frames = [robot.frame(held[k].frame) for k in on_ground(landing)]
    struck = np.array([[shape.belongs_to(frame) for shape in shapes] for frame in frames], dtype=bool)
    contacts = height.copy()
    for k, (frame, own) in enumerate(zip(frames, struck, strict=True)):
        if own.any():
            touching = surface[:, own]
        else:
            # A frame without shapes stands for those of its body in which it may lie, such as a site at the centre of a foot.
            body = pieces.body == frame.body
            touching = np.where(core[:, body] >= height[:, k, None] - inside, surface[:, body], np.inf)
        contacts[:, k] = touching.min(axis=1, initial=np.inf)
    lowest, others = np.minimum(height, contacts), np.logical_not(struck.any(axis=0))
    return Levels(core, surface, lowest, struck, others, inside, landing.scene.ground_tolerance)


@memoized()
def _by_body(robot: Robot) -> tuple[tuple[np.ndarray, Array, Array, float], ...]:
    """For each body: its n pieces, their points (k, 3), semi-axes (3n, 3), the first of each first; a radius around all."""
    pieces, found = body_outline(robot).pieces, []
    sizes = np.linalg.norm(pieces.points, axis=1) + np.linalg.norm(pieces.rounding, axis=1).max(axis=1)[pieces.piece]
    for body in range(len(robot.bodies)):
        n, own = np.flatnonzero(pieces.body == body), pieces.body[pieces.piece] == body
        axes = pieces.rounding[n].transpose(2, 0, 1).reshape(-1, 3)
        found.append((n, pieces.points[own], axes, float(sizes[own].max(initial=-np.inf))))
    return tuple(found)


def heights(landing: PosedLanding) -> Iterator[Diagnostic]:
    """Warnings about geometry below the contacts, and about contacts and standing feet that flat ground cannot touch together.

    A round foot may be struck at its centre: below a contact counts what its link's shapes reach without the least semi-axis of
    their ellipsoids.
    """
    state, up = landing.state, landing.up
    if not (level := on_ground(landing)):
        return
    along = "" if up[2] > 1.0 - 1e-9 else " (along the ground's normal)"
    outline = body_outline(landing.robot)
    shapes = [shape for own in outline.shapes for shape in own]
    names = [landing.blocks[k].frame for k in level]
    points = np.stack([block_point(state, landing.blocks[k]) for k in level], axis=1)
    here = levels(landing, state.rotation, state.position, points)
    core, surface, lowest = here.core[0], here.surface[0], here.contacts[0].tolist()
    below = {}
    for k, name in enumerate(names[: sum(number < len(landing.contacts) for number in level)]):
        point = float(points[0, k] @ up)
        if point - min([point, *core[here.own[k]]]) > here.inside:
            below[name] = point - lowest[k]
    if below:
        low = max(below.values())
        text = (
            f"{listed(below, 4)} {'reach up to' if len(below) > 1 else 'reaches'} {low:.2g} m{along} below the contact point; "
            "strike the lowest point with --contact-point lowest"
        )
        yield Diagnostic("height", "+".join(below), low, text)
    first, last = names[int(np.argmin(lowest))], names[int(np.argmax(lowest))]
    low = max(lowest) - min(lowest)
    if here.uneven[0]:
        text = f'"{last}" is {low:.2g} m{along} above "{first}", so flat ground cannot touch both; '
        text += "change the posture, or leave one out"
        yield Diagnostic("height", last, low, text)
    if landing.base != "fixed" and here.below[0]:
        low, others, remedy = float(here.depth[0]), here.others, "change the posture, or name what strikes"
        struck = {contact.body for contact in landing.contacts}
        own = others & np.array([body in struck for body, carried in enumerate(outline.shapes) for _ in carried])
        # The struck body itself is named where it reaches as low as another, on whose posture the warning then does not depend.
        if surface[own].min(initial=np.inf) <= surface[others].min() + here.tolerance:
            others, remedy = own, "it moves with the contact, so strike it: --contact with its name, --contact-point lowest"
        k = int(np.argmin(np.where(others, surface, np.inf)))
        meets = f'so flat ground meets "{shapes[k].link}" first'
        text = f'"{first}": {low:.2g} m of the robot{along} is below the contact, {meets}; {remedy}'
        yield Diagnostic("height", first, low, text)


def _straight(landing: PosedLanding, mitigation: Mapping[str, float | None]) -> Iterator[Diagnostic]:
    """Warnings of limbs that are straight in the neutral posture, which was taken because the robot has no other."""
    robot, posture = landing.robot, landing.scene.posture
    chosen = {posture.reference, reference_name(robot, None)} != {"neutral"} or "neutral" in robot.postures
    if chosen or posture.joints or posture.joints_deg or landing.loops:
        return
    bent, single = landing.q.copy(), [joint for joint in robot.single_joints if joint.axis is not None]
    set_joints(robot, [(joint, joint.value(bent) + BEND) for joint in single], bent)
    state = dynamics(robot, np.stack([landing.q, bent]))
    straight = []
    for block in landing.blocks[: len(landing.contacts)]:
        moved = row_jacobian(state, [block._replace(forces=np.eye(3), moments=NO_AXES)])[..., 6 * robot.free_base :]
        size = np.linalg.svd(moved, compute_uv=False)
        here, elsewhere = np.sum(size > STRAIGHT * size.max(initial=0.0), axis=1)
        if here < elsewhere:
            straight.append(block.frame)
    if straight:
        least = min((factor for frame in straight if (factor := mitigation[frame]) is not None), default=None)
        limbs = "limb" if len(straight) == 1 else "limbs"
        remedy = "the file a keyframe" if robot.source.kind == "mjcf" else "reference postures with --srdf"
        if robot.postures:
            remedy = f"one of its postures with --posture: {listed(robot.postures, 4)}"
        text = (
            f"no standing posture found: neutral, with straight {limbs} at {listed(straight, 4)}"
            f"{'' if least is None else f'; mitigation {least:.2g}'}; set joints with --set, or give {remedy}"
        )
        yield Diagnostic("posture", "+".join(straight), least, text)


def _angles(landing: PosedLanding) -> Iterator[Diagnostic]:
    """Warnings of degrees that look like radians, and of radians beyond a whole turn."""
    robot, posture = landing.robot, landing.scene.posture
    turns = {joint.name for joint in robot.single_joints if joint.kind != "prismatic"}
    given = {name: value for name, value in posture.joints_deg.items() if turns.intersection(robot.match_joints(name))}
    given |= zip(("roll", "pitch", "yaw"), posture.base_rpy_deg or (), strict=False)
    given |= {"strike angle": landing.scene.strike.strike_angle_deg or 0.0}
    given = {name: value for name, value in given.items() if value}
    least, most = SMALL_ANGLES
    if least <= max(map(abs, given.values()), default=0.0) <= most and any(value % 1.0 for value in given.values()):
        text = few([f"{name} = {value:g} deg" for name, value in given.items()], 4)
        meant = few([f"{math.degrees(value):.4g}" for value in given.values()], 4)
        yield Diagnostic("unit", "angles", max(given.values(), key=abs), f"{text}: if radians are meant, give {meant} deg")
    for name, value in posture.joints.items():
        if abs(value) > 2.0 * math.pi and turns.intersection(robot.match_joints(name)):
            text = f"{name} = {value:g} rad: if degrees are meant, give {math.radians(value):.4g} rad"
            yield Diagnostic("unit", name, value, text)


def _inertias(landing: PosedLanding) -> Iterator[Diagnostic]:
    """A warning of links with moments of inertia that no body within the robot has: placeholders, or another unit."""
    found = sorted(inflated_inertias(landing.robot), key=lambda one: -one[1])
    if found:
        radii = few([f'"{name}" ({radius:.3g} m)' for name, radius, _ in found], 4)
        text = (
            f"the radius of gyration of {radii} is above the size of the robot, {found[0][2]:.3g} m: a placeholder, or moments in "
            "another unit than kg m²; what moves with such a link hardly turns, so every shock is wrong; correct the file"
        )
        yield Diagnostic("inertia", "+".join(name for name, *_ in found), found[0][1], text)


def _masses(landing: PosedLanding) -> Iterator[Diagnostic]:
    """Warnings of masses that look like grams, and of reflected inertias that look like kg cm²."""
    robot = landing.robot
    if robot.mass > HEAVY:
        text = f"the robot weighs {robot.mass:.4g} kg; if its file gives grams, that is {robot.mass / 1000.0:.4g} kg"
        yield Diagnostic("unit", "mass", robot.mass, text)
    armature = [(joint.name, landing.joint_model.armature[joint.v].max()) for joint in robot.single_joints if joint.unit == "rad"]
    large = {name: float(inertia) for name, inertia in armature if inertia > ARMATURE}
    if large and robot.mass < LIGHT:
        most = max(large.values())
        text = (
            f"{listed(large, 4)}: reflected inertia up to {most:g} kg m², on a robot of {robot.mass:.3g} kg; "
            f"if kg cm² are meant, give {most * 1e-4:g} kg m²"
        )
        yield Diagnostic("unit", "armature", most, text)


def pulled(landing: PosedLanding, pull: Array, friction: Sequence[str] | None) -> Iterator[Diagnostic]:
    """Warnings of contacts and standing feet that the ground would have to pull.

    Args:
        landing: names them.
        pull: (n,) of each [N s].
        friction: what each does with the friction of the scene: "sticks", "slides" or "separates"; None without friction.
    """
    for number, (block, size) in enumerate(zip(landing.blocks, pull.tolist(), strict=False)):
        if size > 0.0:
            end = "keep to the ground; a real foot lifts off there, so leave it out"
            if friction is not None and friction[number] != "sticks":
                end = (
                    f"stick; with the friction given it {friction[number]}, so the results with friction are those of this landing"
                )
            text = f"{block.name} would have to be pulled by {size:.3g} N s to {end}"
            yield Diagnostic("contact", block.name, -size, text)


def slipping(landing: PosedLanding, needed: Array) -> Iterator[Diagnostic]:
    """Warnings of contacts and standing feet that need more friction to stick than the scene gives. Args: needed (n,) [1]."""
    for block, friction in zip(landing.blocks, needed.tolist(), strict=False):
        if landing.scene.friction is not None and friction > landing.scene.friction:
            pairs = ((f"{friction:.{n}g}", f"{landing.scene.friction:.{n}g}") for n in range(3, 18))
            needed_text, given_text = next(pair for pair in pairs if pair[0] != pair[1])
            text = (
                f"{block.name} needs a friction of {needed_text} to stick and slides at {given_text}; the results "
                "with friction are those of this landing, the others those of contacts that stick"
            )
            yield Diagnostic("contact", block.name, friction, text)


def gained(robot: str, lost: float, size: float) -> Iterator[Diagnostic]:
    """A warning where restitution would make kinetic energy, which no impact does.

    Args:
        robot: its name.
        lost: kinetic energy [J].
        size: work of the impulse on the approach [J], of which a gain by the rounding of the data is a tiny part.
    """
    if lost < -ROUNDING * size:
        text = (
            f"this impact would make {-lost:.3g} J of kinetic energy: contacts with unequal restitution push against one "
            "another, or restitution along the normal meets an approach along the ground; take less restitution, one for all "
            "contacts, or --restitution-along directions"
        )
        yield Diagnostic("energy", robot, lost, text)


def saturated(landing: PosedLanding, peaks: Mapping[str, float | None]) -> Iterator[Diagnostic]:
    """A warning for every sensor whose peak [g] exceeds its range, and for a pulse without a sensor or point."""
    if landing.pulse is not None and not peaks:
        text = "a pulse is given, but the robot has no sensor and no point is asked for, so there is no peak; name one with --at"
        yield Diagnostic("sensor", "", None, text)
    limit = landing.scene.range_g or math.inf
    for name, peak in peaks.items():
        if peak is not None and peak > limit:
            text = f'"{name}" would see {peak:.3g} g, beyond its range of {limit:g} g; its reading saturates'
            yield Diagnostic("sensor", name, peak, text)
