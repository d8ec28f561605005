"""Resolve a scene on a robot.

Its defaults are filled in, what it names is found, its loops are closed, and what has no meaning is
refused.
"""

import itertools
import math
import os
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from shockpc.core.pulse import Pulse, pulse_from
from shockpc.core.spatial import Array
from shockpc.landing.bandwidths import low_passes_of
from shockpc.landing.before_impact import motion_before, rates_of, separating
from shockpc.landing.closure import all_loops, assemble, follow
from shockpc.landing.contact import check_holds_normal, contact_constraint
from shockpc.landing.end_stops import is_stop, striking_stop
from shockpc.landing.feet.auto_contact import resolve_contacts
from shockpc.landing.feet.level_feet import default_landings
from shockpc.landing.joint_model import JointModel, joint_model
from shockpc.landing.landing import PosedLanding, contact_velocity
from shockpc.landing.posture import configuration, fixed_joints, outside_limits, reference_name
from shockpc.landing.ratings import check_parts, strength, torque_limits
from shockpc.landing.scenes.scene import Contact, Posture, Scene
from shockpc.landing.scenes.scene_file import (
    check_scene,
    ground_normal,
    plane_of,
    point_at,
    scene_of,
    with_paths,
    with_plane,
)
from shockpc.landing.scenes.strike import Strike
from shockpc.method.base import Base
from shockpc.method.constraints import Constraint
from shockpc.method.dynamics import dynamics
from shockpc.robot.bodies_and_joints import Loop
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
    for quantity, count, most in (
        ("contacts", contacts, MOST_CONTACTS),
        ("points", len(scene.point), MOST_POINTS),
        ("parts", len(scene.part), MOST_POINTS),
    ):
        if count > most:
            raise SceneError(
                f"the scene has {count} {quantity}, and up to {most} are computed; leave some of "
                f"them out"
            )


def _complete(scene: Scene, robot: Robot) -> Scene:
    """The scene with every default filled in and every path absolute.

    It then says all that is computed.
    """
    scene = check_scene(scene)
    _check_sizes(scene)
    if not scene.contact:
        frames = [f'"{contact.frame}"' for contact in default_landings(robot, scene)[0]]
        example = f'links of robot "{robot.name}", such as [{", ".join(frames)}]'
        if len(frames) == 1:
            example = f'a link of robot "{robot.name}", such as {frames[0]}'
        raise SceneError(f"no contact is defined; name {example}")
    strike, base = scene.strike, scene.base or _default_base(scene, robot)
    only_stops = all(is_stop(robot, contact.frame) for contact in scene.contact)
    only_joint_velocities = strike == Strike(joint_velocities=strike.joint_velocities)
    joints_move_on_fixed_base = base == "fixed" and strike.joint_velocities
    if only_joint_velocities and (only_stops or joints_move_on_fixed_base):
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
    """The motion of the base where the scene does not state it.

    It is as usual, but an arm that is struck at its base falls.
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


def _check_ground(scene: Scene, constraints: tuple[Constraint, ...]) -> None:
    """Refuse a friction or a restitution of end stops that has no meaning for the scene."""
    if scene.stop_restitution is not None and not scene.stops:
        raise SceneError(
            "a restitution of end stops is given, but they are left out; give stops = true "
            "(--stops) too"
        )
    for check_options in from_wings("landing", "check_options"):
        check_options(scene, constraints)
    if scene.friction is not None:
        for contact, constraint in zip(scene.contact, constraints, strict=True):
            _check_friction_at(contact, constraint)


def _check_friction_at(contact: Contact, constraint: Constraint) -> None:
    """Refuse friction at an end stop, and at some contacts.

    They are those that slide or are not held along the normal.
    """
    if constraint.kind == "stop":
        raise SceneError(
            f'contact "{contact.frame}" is an end stop, and friction is for the ground; '
            "leave it out"
        )
    if np.linalg.matrix_rank(constraint.forces) == 1:
        raise SceneError(
            f'contact "{contact.frame}" slides without friction, and a friction is given; leave '
            "out --slide (give it the directions x, y and z, or those along which it does not "
            "slide freely), or the friction",
            constraints=[contact.frame],
        )
    check_holds_normal(contact, constraint, "friction")


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
    chosen = _left_open(scene, robot)
    scene = _complete(scene, robot)
    pulse = pulse_of(scene)
    plane = plane_of(scene)
    up = ground_normal(plane, scene.strike.vector(plane))
    joints = joint_model(robot, scene.joints)
    q = configuration(robot, scene.posture)
    contacts = _contacts(scene, robot, q, joints, up)
    stance = _stance(scene, robot, up)
    _check_ground(scene, contacts)

    loops = all_loops(robot, scene.closure)
    assembly = None
    warnings: list[Diagnostic] = []
    if loops:
        fixed = fixed_joints(robot, scene.posture, scene.assemble)
        assembly = assemble(robot, q, loops, plane, fixed)
        q = assembly.q
        warnings += assembly.warnings(robot.name)
    warnings += outside_limits(robot, q)
    warnings += _without_effect(scene, robot, loops)

    state = dynamics(robot, q[None], joints)
    landing = PosedLanding(
        scene=scene,
        robot=robot,
        plane=plane,
        up=_common_normal((*contacts, *stance), up),
        contacts=contacts,
        lifted=(),
        stance=stance,
        loops=loops,
        joint_model=joints,
        before=motion_before(robot, scene, contacts, loops, joints, plane, state),
        pulse=pulse,
        q=np.array(q),
        state=state,
        assembly=assembly,
        warnings=tuple(warnings),
        asked=scene.contact,
        asked_rows=contacts,
        chosen=chosen,
    )
    landing = resolve_contacts(landing)
    _check_landing(landing)
    return landing


def _left_open(scene: Scene, robot: Robot) -> tuple[str, ...]:
    """The names of what a scene leaves open and its default fills in, as `PosedLanding.chosen`."""
    chosen: list[str] = []
    if scene.posture == Posture():
        chosen.append("posture")
    if scene.base is None and usual_base(robot).reason in ("arm", "legs"):
        chosen.append("base")
    return tuple(chosen)


def _contacts(
    scene: Scene, robot: Robot, q: Array, joints: JointModel, up: Array
) -> tuple[Constraint, ...]:
    """The rows of what strikes: contacts, and end stops that joints run into."""
    constraints: list[Constraint] = []
    for contact in scene.contact:
        if is_stop(robot, contact.frame):
            rates, *_ = rates_of(robot, scene, joints)
            constraints.append(striking_stop(robot, contact, q, rates))
        else:
            constraints.append(contact_constraint(robot, contact, up))
    return tuple(constraints)


def _stance(scene: Scene, robot: Robot, up: Array) -> tuple[Constraint, ...]:
    """The rows of the feet that stand."""
    feet = [point_at(robot, foot) for foot in scene.stance]
    constraints: list[Constraint] = []
    for foot in feet:
        contact = Contact(frame=foot.frame, offset=foot.offset)
        constraints.append(contact_constraint(robot, contact, up, "stance"))
    return tuple(constraints)


def _common_normal(constraints: tuple[Constraint, ...], up: Array) -> Array:
    """The normal (3,) of the ground at contacts and standing feet, where all have one; else up."""
    normals = np.array(
        [constraint.normal for constraint in constraints if constraint.kind != "stop"]
    )
    is_common = len(normals) and np.ptp(normals, axis=0).max() <= 1e-12
    return np.asarray(normals[0]) if is_common else up


def _without_effect(scene: Scene, robot: Robot, loops: tuple[Loop, ...]) -> Iterator[Diagnostic]:
    """Warnings of parts of a scene that have no effect, and of a loop that is open."""
    joints = scene.joints
    if joints.model == "rigid":
        springs = joint_model(robot, replace(joints, model=None)).springs
        if not springs.any():
            text = (
                "the springs are to be rigid, but no joint has a spring, so nothing changes; give "
                "a spring by its stiffness or behind a rotor"
            )
            yield Diagnostic("scene", robot.name, None, text)
    if joints.model == "free" and joints.drives not in (None, "none"):
        text = (
            f"free joints have no drives, so the drives of {joints.drives} have no effect; "
            "leave out the drives, or the model free"
        )
        yield Diagnostic("scene", robot.name, None, text)
    along = [
        contact.frame for contact in scene.contact if contact.restitution_along == "directions"
    ]
    restitution = any(contact.restitution for contact in scene.contact)
    if along and not restitution and scene.contact_damping is None:
        text = (
            f"the restitution of {listed(along)} is along its directions, but no contact has a "
            "restitution, so nothing changes; give a restitution"
        )
        yield Diagnostic("scene", "+".join(along), None, text)
    if loops:
        return
    if scene.assemble:
        names: list[str] = []
        for pattern in scene.assemble:
            names += robot.match_joints(pattern)
        text = f"{listed(names)} may move to close loops, but nothing closes one, so nothing moved"
        yield Diagnostic("scene", "", None, text)
    closing = closing_scene(robot.source.path)
    if closing is not None:
        text = (
            f"the loop of this robot is open here, so its ends are not held together; {closing} "
            f"closes it"
        )
        yield Diagnostic("scene", robot.name, None, text)


def _check_landing(landing: PosedLanding) -> None:
    """Refuse points that are not known or coincide, parts without a strength, and what wings do."""
    for point in landing.scene.point:
        landing.robot.frame(point.frame)
    parts = landing.scene.part
    check_parts(parts)
    torque_limits(landing.robot, parts)
    for place in landing.mounted:
        strength(parts[place.number])
    _refuse_twice(landing.constraints)
    for check_landing in from_wings("landing", "check_landing"):
        check_landing(landing)


def with_definite_contacts(scene: Scene, robot: Robot) -> Scene:
    """The scene with its contacts at the points and of the kinds that they have in its posture.

    They stay so, whatever varies later.

    Raises:
        ShockError: as for `landing_of`.
    """
    if all("auto" not in (contact.at, contact.kind) for contact in scene.contact):
        return scene
    return replace(scene, contact=landing_of(scene, robot).scene.contact)


def close_loops(scene: Scene, near: PosedLanding) -> Scene:
    """A scene whose loops start closed.

    They are assembled in the same way as those of another landing of the robot.

    The joints that close the loops, ball joints too, are followed from there while the others move,
    and set to where they come.

    Raises:
        ShockError: as for `resolve`.
    """
    robot, posture = near.robot, scene.posture
    fixed = fixed_joints(robot, posture, scene.assemble)
    q = follow(robot, near.q, configuration(robot, posture), near.loops, near.plane, fixed)
    values: dict[str, float] = {}
    for joint in robot.independent_joints:
        if not fixed[joint.v].any():
            value = joint.value(q)
            values[joint.name] = value if joint.kind == "prismatic" else math.degrees(value)
    turned: dict[str, tuple[float, ...]] = {}
    for joint in robot.single_joints:
        if joint.kind == "ball" and not fixed[joint.v].any():
            turned[joint.name] = tuple(q[joint.q].tolist())
    kept = {name: value for name, value in posture.joints_deg.items() if name not in values}
    posture = replace(
        posture,
        joints_deg={**kept, **values},
        joint_quaternions={**posture.joint_quaternions, **turned},
    )
    return replace(scene, posture=posture, assemble=(*values, *turned))


def _refuse_twice(constraints: tuple[Constraint, ...]) -> None:
    """Refuse contacts and standing feet that are the same point of the same body."""
    points = [constraint for constraint in constraints if constraint.kind != "closure"]
    for first, second in itertools.combinations(points, 2):
        if first.body != second.body or np.linalg.norm(first.point - second.point) > 1e-9:
            continue
        remedy = "remove one"
        if "contact" in (first.kind, second.kind):
            remedy += ", or move it by an offset"
        raise SceneError(
            f"{first.name} and {second.name} coincide: they are the same point of the same body; "
            f"{remedy}",
            constraints=[first.frame, second.frame],
        )


def _refuse_separation(landing: PosedLanding) -> None:
    """Refuse a contact that does not strike the ground.

    It leaves the ground, or does not approach it as no other does.
    """
    approach = np.stack(
        [contact_velocity(landing, landing.state, constraint)[0] for constraint in landing.contacts]
    )
    fastest_rate = float(np.abs(landing.before.joint_rates).max())
    parting = separating(approach, landing.contacts).tolist()
    for contact, constraint, velocity, parts in zip(
        landing.scene.contact, landing.contacts, approach, parting, strict=True
    ):
        moves = np.linalg.norm(velocity) > 1e-9 * fastest_rate
        if constraint.kind == "stop" and not moves:
            raise SceneError(
                f'the centre of mass of body "{landing.robot.bodies[constraint.body].name}" lies '
                f'on the axis of "{constraint.frame}", so its speed there is zero and cannot '
                "be v_in; use another end stop",
                constraints=[constraint.frame],
            )
        if parts:
            leaving = float(velocity @ constraint.normal)
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
                constraints=[contact.frame],
            )
