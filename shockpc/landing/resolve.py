"""Resolve a scene on a robot: fill in its defaults, find what it names, close its loops, and refuse
what has no meaning.
"""

import itertools
import math
import os
from dataclasses import replace

import numpy as np

from shockpc.core.pulse import Pulse, pulse_from
from shockpc.landing.auto_contact import resolve_contacts
from shockpc.landing.bandwidths import low_passes_of
from shockpc.landing.closure import all_loops, assemble, follow
from shockpc.landing.contact import check_holds_normal, contact_block
from shockpc.landing.end_stops import is_stop, striking_stop
from shockpc.landing.joint_model import joint_model
from shockpc.landing.landing import PosedLanding, contact_velocity
from shockpc.landing.level_feet import default_landings
from shockpc.landing.motion import motion_of, rates_of, separating
from shockpc.landing.posture import configuration, fixed_joints, outside_limits, reference_name
from shockpc.landing.ratings import check_parts, strength, torque_limits
from shockpc.landing.scene import Contact, Posture, Scene
from shockpc.landing.scene_file import (
    check_scene,
    ground_normal,
    plane_of,
    point_at,
    scene_of,
    with_paths,
    with_plane,
)
from shockpc.landing.strike import Strike
from shockpc.method.base import Base
from shockpc.method.constraints import ConstraintBlock
from shockpc.method.dynamics import dynamics
from shockpc.robot.catalogue import closing_scene
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import usual_base
from shockpc.text.arguments import checked
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import SceneError
from shockpc.text.printed import listed
from shockpc.text.wings import from_wings

MOST_CONTACTS = 100
"""Contacts of a scene, with the feet that stand; a landing on so many feet takes some 15 s and 0.7
GB.
"""

MOST_POINTS = 1000
"""Points of a scene, and its parts; with the ranges of their sensors over the drives so many take
some 10 s.
"""


def _check_sizes(scene: Scene) -> None:
    """Refuse more contacts, points or parts than are computed."""
    contacts = len(scene.contact) + len(scene.stance)
    for what, count, most in (
        ("contacts", contacts, MOST_CONTACTS),
        ("points", len(scene.point), MOST_POINTS),
        ("parts", len(scene.part), MOST_POINTS),
    ):
        if count > most:
            raise SceneError(
                f"the scene has {count} {what}, and up to {most} are computed; leave some of them "
                f"out"
            )


def _complete(scene: Scene, robot: Robot) -> Scene:
    """The scene with every default filled in and every path absolute, so that it says all that is
    computed.
    """
    scene = check_scene(scene)
    _check_sizes(scene)
    if not scene.contact:
        first, *others = (f'"{contact.frame}"' for contact in default_landings(robot, scene)[0])
        example = f'links of robot "{robot.name}", such as [{", ".join([first, *others])}]'
        if not others:
            example = f'a link of robot "{robot.name}", such as {first}'
        raise SceneError(f"no contact is defined; name {example}")
    strike, base = scene.strike, scene.base or _default_base(scene, robot)
    only_stops = all(is_stop(robot, contact.frame) for contact in scene.contact)
    if strike == Strike(joint_velocities=strike.joint_velocities) and (
        only_stops or (base == "fixed" and strike.joint_velocities)
    ):
        # The motion of a fixed base is that of the ground, of which there is none where the joints
        # move.
        strike = replace(strike, velocity=(0.0, 0.0, 0.0))
    if strike.velocity is None and strike.drop_height is None:
        speed = 1.0 if strike.speed is None else strike.speed
        strike = replace(strike, speed=speed, strike_angle_deg=strike.strike_angle_deg or 0.0)
    scene = with_paths(scene, lambda path: os.path.realpath(os.path.expanduser(path)))
    posture = replace(scene.posture, reference=reference_name(robot, scene.posture.reference))
    return with_plane(replace(scene, robot=robot.label, base=base, strike=strike, posture=posture))


def _default_base(scene: Scene, robot: Robot) -> Base:
    """How the base moves where the scene does not say so: as usual, but an arm that is struck at
    its base falls.
    """
    base, reason = usual_base(robot)
    struck = {
        robot.frames[contact.frame].body
        for contact in scene.contact
        if contact.frame in robot.frames
    }
    return "free" if reason == "arm" and 0 in struck else base


def pulse_of(scene: Scene) -> Pulse | None:
    """The scene's pulse, if it has one.

    Raises:
        SceneError: it has no known shape or no length, or a sensor's range is given without it,
            without a contact stiffness and without a bandwidth; or a bandwidth is none.
    """
    measured = bool(low_passes_of(scene))
    if scene.pulse is None:
        if scene.range_g is not None and not scene.yields and not measured:
            raise SceneError(
                "a sensor's range needs accelerations; give a pulse, such as half-sine:5ms, a "
                "contact stiffness, "
                "or the bandwidth of the sensor"
            )
        return None
    try:
        return pulse_from(scene.pulse)
    except ValueError as refusal:
        raise SceneError(f"pulse: {refusal}") from None


def _check_ground(scene: Scene, blocks: tuple[ConstraintBlock, ...]) -> None:
    """Refuse a friction or a restitution of end stops that has no meaning for the scene."""
    if scene.stop_restitution is not None and not scene.stops:
        raise SceneError(
            "a restitution of end stops is given, but they are left out; give stops = true "
            "(--stops) too"
        )
    for check_options in from_wings("landing", "check_options"):
        check_options(scene, blocks)
    if scene.friction is not None:
        for contact, block in zip(scene.contact, blocks, strict=True):
            _check_friction_at(contact, block)


def _check_friction_at(contact: Contact, block: ConstraintBlock) -> None:
    """Refuse friction at an end stop, and at a contact that slides or is not held along the
    normal.
    """
    if block.kind == "stop":
        raise SceneError(
            f'contact "{contact.frame}" is an end stop, and friction is for the ground; leave it out'
        )
    if np.linalg.matrix_rank(block.forces) == 1:
        raise SceneError(
            f'contact "{contact.frame}" slides without friction, and a friction is given; leave out '
            "--slide (give it the directions x, y and z, or those along which it does not slide "
            "freely), or the friction",
            blocks=[contact.frame],
        )
    check_holds_normal(contact, block, "friction")


@checked
def resolve(scene: Scene | str, robot: Robot) -> PosedLanding:
    """Resolve a scene on its robot.

    Raises:
        ShockError: as for `landing_of`, or a contact does not approach the ground.
    """
    landing = landing_of(scene_of(scene), robot)
    _refuse_separation(landing)
    return landing


def landing_of(scene: Scene, robot: Robot) -> PosedLanding:
    """Resolve a scene on its robot, whether or not its contacts approach the ground.

    Raises:
        ShockError: a name is not known, a loop cannot be closed, or a part of the scene has no
            meaning.
    """
    by_limbs = scene.base is None and usual_base(robot).reason in ("arm", "legs")
    chosen = (*["posture"] * (scene.posture == Posture()), *["base"] * by_limbs)
    scene = _complete(scene, robot)
    pulse, plane = pulse_of(scene), plane_of(scene)
    velocity = scene.strike.vector(plane)
    up = ground_normal(plane, velocity)
    joints = joint_model(robot, scene.joints)
    q, assembly, warnings = configuration(robot, scene.posture), None, list[Diagnostic]()
    contacts = tuple(
        striking_stop(robot, contact, q, rates_of(robot, scene, joints)[0])
        if is_stop(robot, contact.frame)
        else contact_block(robot, contact, up)
        for contact in scene.contact
    )
    standing = [point_at(robot, foot) for foot in scene.stance]
    stance = tuple(
        contact_block(robot, Contact(frame=one.frame, offset=one.offset), up, "stance")
        for one in standing
    )
    _check_ground(scene, contacts)
    normals = np.array([block.normal for block in (*contacts, *stance) if block.kind != "stop"])
    up = normals[0] if len(normals) and np.ptp(normals, axis=0).max() <= 1e-12 else up
    loops = all_loops(robot, scene.closure)
    if loops:
        assembly = assemble(
            robot, q, loops, plane, fixed_joints(robot, scene.posture, scene.assemble)
        )
        q, warnings = assembly.q, [*assembly.warnings(robot.name)]
    warnings += outside_limits(robot, q)
    if (
        scene.joints.model == "rigid"
        and not joint_model(robot, replace(scene.joints, model=None)).springs.any()
    ):
        text = (
            "the springs are to be rigid, but no joint has a spring, so nothing changes; give a "
            "spring by its stiffness or behind a rotor"
        )
        warnings.append(Diagnostic("scene", robot.name, None, text))
    if scene.joints.model == "free" and scene.joints.drives not in (None, "none"):
        text = (
            f"free joints have no drives, so the drives of {scene.joints.drives} have no effect; "
            "leave out the drives, or the model free"
        )
        warnings.append(Diagnostic("scene", robot.name, None, text))
    along = [
        contact.frame for contact in scene.contact if contact.restitution_along == "directions"
    ]
    if (
        along
        and not any(contact.restitution for contact in scene.contact)
        and scene.contact_damping is None
    ):
        text = (
            f"the restitution of {listed(along)} is along its directions, but no contact has a "
            "restitution, so nothing changes; give a restitution"
        )
        warnings.append(Diagnostic("scene", "+".join(along), None, text))
    if scene.assemble and not loops:
        named = listed(name for pattern in scene.assemble for name in robot.match_joints(pattern))
        warnings.append(
            Diagnostic(
                "scene",
                "",
                None,
                f"{named} may move to close loops, but nothing closes one, so nothing moved",
            )
        )
    if not loops and (closing := closing_scene(robot.source.path)) is not None:
        text = (
            f"the loop of this robot is open here, so its ends are not held together; {closing} "
            f"closes it"
        )
        warnings.append(Diagnostic("scene", robot.name, None, text))
    state = dynamics(robot, q[None], joints)
    before = motion_of(robot, scene, contacts, loops, joints, plane, state)
    landing = resolve_contacts(
        PosedLanding(
            scene,
            robot,
            plane,
            up,
            contacts,
            (),
            stance,
            loops,
            joints,
            before,
            pulse,
            np.array(q),
            state,
            assembly,
            tuple(warnings),
            asked=scene.contact,
            asked_rows=contacts,
            chosen=chosen,
        )
    )
    check_parts(scene.part)
    torque_limits(robot, scene.part)
    for place in landing.parts:
        if place.joint < 0:
            strength(scene.part[place.number])
    _refuse_twice(landing.blocks)
    for check_landing in from_wings("landing", "check_landing"):
        check_landing(landing)
    return landing


def with_definite_contacts(scene: Scene, robot: Robot) -> Scene:
    """The scene with its contacts at the points and of the kinds that they have in its posture,
    whatever varies later.

    Raises:
        ShockError: as for `landing_of`.
    """
    if all("auto" not in (contact.at, contact.kind) for contact in scene.contact):
        return scene
    return replace(scene, contact=landing_of(scene, robot).scene.contact)


def close_loops(scene: Scene, near: PosedLanding) -> Scene:
    """A scene whose loops start closed, assembled in the same way as those of another landing of
    the robot.

    The joints that close the loops, ball joints too, are followed from there while the others move,
    and set to where they come.

    Raises:
        ShockError: as for `resolve`.
    """
    robot, posture = near.robot, scene.posture
    fixed = fixed_joints(robot, posture, scene.assemble)
    q = follow(robot, near.q, configuration(robot, posture), near.loops, near.plane, fixed)
    values = [
        (joint, joint.value(q)) for joint in robot.independent_joints if not fixed[joint.v].any()
    ]
    given = {
        joint.name: value if joint.kind == "prismatic" else math.degrees(value)
        for joint, value in values
    }
    balls = [
        joint for joint in robot.single_joints if joint.kind == "ball" and not fixed[joint.v].any()
    ]
    turned = {ball.name: tuple(q[ball.q].tolist()) for ball in balls}
    others = {name: value for name, value in posture.joints_deg.items() if name not in given}
    posture = replace(
        posture,
        joints_deg={**others, **given},
        joint_quaternions={**posture.joint_quaternions, **turned},
    )
    return replace(scene, posture=posture, assemble=(*given, *turned))


def _refuse_twice(blocks: tuple[ConstraintBlock, ...]) -> None:
    for one, other in itertools.combinations(
        [block for block in blocks if block.kind != "closure"], 2
    ):
        if one.body == other.body and np.linalg.norm(one.point - other.point) <= 1e-9:
            raise SceneError(
                f"{one.name} and {other.name} coincide: they are the same point of the same body; "
                "remove one"
                + (", or move it by an offset" if "contact" in (one.kind, other.kind) else ""),
                blocks=[one.frame, other.frame],
            )


def _refuse_separation(landing: PosedLanding) -> None:
    """Refuse a contact that leaves the ground, or does not approach it as no other does: it does
    not strike it.
    """
    approach = np.stack(
        [contact_velocity(landing, landing.state, block)[0] for block in landing.contacts]
    )
    parting = separating(approach, landing.contacts).tolist()
    for contact, block, velocity, parts in zip(
        landing.scene.contact, landing.contacts, approach, parting, strict=True
    ):
        if block.kind == "stop" and not np.linalg.norm(velocity) > 1e-9 * float(
            np.abs(landing.before.joint_rates).max()
        ):
            raise SceneError(
                f'the centre of mass of body "{landing.robot.bodies[block.body].name}" lies on the '
                f'axis of "{block.frame}", so its '
                "speed there is no measure of the strike; let another end stop strike",
                blocks=[block.frame],
            )
        if parts:
            leaving = float(velocity @ block.normal)
            how = (
                "is leaving the ground at"
                if leaving > 1e-9
                else "moves along the ground, approaching it at"
            )
            raise SceneError(
                f'contact "{contact.frame}" {how} {abs(leaving):.2g} m/s, so there is no impact; '
                f"turn its velocity towards the "
                "ground (a strike angle between -90 and 90 deg), or list it under stance if it "
                "stands there already",
                blocks=[contact.frame],
            )
