"""From the options of a command to scenes: one for each landing."""

import dataclasses
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import typer

from shockpc.cli.options import SceneOptions
from shockpc.cli.parse import Setting, vector
from shockpc.errors import SceneError, ShockError
from shockpc.model.contact import Contact, landing_frames, match_frames
from shockpc.model.joint_model import Joints
from shockpc.model.posture import Posture
from shockpc.robot.landmarks import each_foot, feet
from shockpc.robot.robot import Robot
from shockpc.scene import Point, Scene, Strike, plane_of, robot_of
from shockpc.trace import Trace

__all__ = ["ROBOT_SUFFIXES", "is_scene_file", "one_scene", "point_from", "scenes_from"]

Record = TypeVar("Record", Contact, Posture, Joints, Strike)

ROBOT_SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf")


def scenes_from(
    robot: str, options: SceneOptions, trace: Trace | None = None, on_each_foot: bool = False
) -> tuple[Robot, list[Scene]]:
    """The robot, and one scene for each landing that the options describe. An option replaces what a scene file says.

    Args:
        robot: its name or file, or a scene.
        options: of the command.
        trace: collects what loading the robot cost.
        on_each_foot: whether a robot for which no contact is given lands on each of its feet.

    Raises:
        ShockError: an option's value is not valid, or names nothing in the robot.
    """
    scene = Scene(robot=robot)
    if is_scene_file(robot):
        from shockpc.scene import read_scene

        scene = read_scene(Path(robot))
    scene = dataclasses.replace(
        scene,
        srdf=scene.srdf if options.srdf is None else str(options.srdf),
        xacro={**scene.xacro, **dict(options.xacro)},
        packages={**scene.packages, **dict(options.package)},
    )
    with (trace or Trace()).stage("robot file"):
        loaded = robot_of(scene, [name.strip() for text in options.contact for name in (text, *text.split("+"))])
    scene = dataclasses.replace(
        scene,
        base=options.base or scene.base,
        plane=scene.plane if options.plane is None else options.plane,
        posture=_posture(scene.posture, options),
        strike=_strike(scene.strike, options),
        stance=tuple(dict.fromkeys(frame for text in options.stance for frame in match_frames(loaded, text))) or scene.stance,
        joints=_joints(scene.joints, options),
        assemble=tuple(options.assemble) or scene.assemble,
        v_in=options.v_in or scene.v_in,
        pulse=options.pulse or scene.pulse,
        range_g=scene.range_g if options.range_g is None else options.range_g,
        point=scene.point + tuple(point_from(loaded, text, "--point") for text in options.point),
    )
    return loaded, [_with_contacts(scene, options, frames) for frames in _landings(loaded, scene, options, on_each_foot)]


def one_scene(robot: str, options: SceneOptions, trace: Trace | None = None) -> tuple[Robot, Scene]:
    """The robot and the landing of a command that is about one landing of it.

    Raises:
        ShockError: as for `scenes_from`, or the options describe several landings.
    """
    loaded, scenes = scenes_from(robot, options, trace)
    if len(scenes) > 1:
        listed = ", ".join("+".join(contact.frame for contact in scene.contact) for scene in scenes[:6])
        raise SceneError(
            f'this command takes one landing, but "{robot}" is given {len(scenes)} landings: {listed}; name one --contact'
        )
    return loaded, scenes[0]


def is_scene_file(name: str) -> bool:
    """Whether a path is a scene: decided by its content where the suffix leaves it open, because a robot file begins with a tag."""
    path = Path(name)
    suffix = path.suffix.casefold()
    if suffix in (".toml", *ROBOT_SUFFIXES):
        return suffix == ".toml"
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            head = file.read(4096).removeprefix(b"\xef\xbb\xbf").lstrip()
    except OSError:
        return False
    return bool(head) and not head.startswith(b"<")


def _landings(robot: Robot, scene: Scene, options: SceneOptions, on_each_foot: bool) -> list[tuple[str, ...] | None]:
    """The frames of each landing; None for the contacts that the scene file gives."""
    if not options.contact:
        if scene.contact:
            return [None]
        if on_each_foot:
            return [(foot,) for foot in each_foot(robot)]
        known = feet(robot)
        names = ", ".join(f'"{name}"' for name in known[:8] or robot.links[-1:])
        first = _with_contacts(scene, options, known[:1] or robot.links[-1:])
        asked = f'no contact is defined for robot "{robot.name}"; name one with --contact, such as {names}'
        raise SceneError(asked + _reach(first, robot))
    landings = [landing for text in options.contact for landing in landing_frames(robot, text)]
    if options.together:
        landings = [tuple(dict.fromkeys(frame for landing in landings for frame in landing))]
    return list(dict.fromkeys(landings))


def _reach(scene: Scene, robot: Robot) -> str:
    """How far a contact's link reaches below the contact point, as the end of a message; empty if it does not."""
    from shockpc.landing import resolve
    from shockpc.results.plausibility import heights

    with suppress(ShockError):
        return "".join(f"; {one}" for one in heights(resolve(scene, robot)))
    return ""


def _with_contacts(scene: Scene, options: SceneOptions, frames: tuple[str, ...] | None) -> Scene:
    """The scene of one landing."""
    directions = None
    if options.slide:
        horizontal = plane_of(scene).level
        velocity = scene.strike.velocity
        # In the plane seen from above, and with a velocity in it, up is the world's y.
        directions = ("y",) if horizontal and velocity is not None and velocity[2] == 0.0 else ("z",)
    changes = {"offset": options.offset, "at": options.contact_point, "restitution": options.restitution, "directions": directions}
    contacts = scene.contact if frames is None else tuple(Contact(frame=frame) for frame in frames)
    return dataclasses.replace(scene, contact=tuple(_with(contact, **changes) for contact in contacts))


def _with(record: Record, **values: Any) -> Record:
    """A record with those values that are not None."""
    return dataclasses.replace(record, **{name: value for name, value in values.items() if value is not None})


def _posture(posture: Posture, options: SceneOptions) -> Posture:
    """The posture with the options applied."""
    if options.base_rpy is not None:
        posture = dataclasses.replace(posture, base_quaternion=None)
    joints = _replaced(posture.joints_deg, options.set)
    return _with(posture, reference=options.posture, base_rpy_deg=options.base_rpy, joints_deg=joints)


def _joints(joints: Joints, options: SceneOptions) -> Joints:
    """The joint model with the options applied."""
    locked = tuple(dict.fromkeys([*joints.locked, *options.lock]))
    return _with(joints, model=options.joints, armature=_replaced(joints.armature, options.armature), locked=locked)


def _strike(strike: Strike, options: SceneOptions) -> Strike:
    """The strike with the options applied; one way of giving the velocity replaces the scene's way."""
    if options.velocity is not None or options.drop_height is not None:
        strike = dataclasses.replace(strike, speed=None, strike_angle_deg=None, velocity=None, drop_height=None)
    elif options.strike_angle is not None or options.speed is not None:
        strike = dataclasses.replace(strike, velocity=None, drop_height=None)
    return _with(
        strike,
        speed=options.speed,
        strike_angle_deg=options.strike_angle,
        velocity=options.velocity,
        drop_height=options.drop_height,
        angular_velocity=options.angular_velocity,
        joint_velocities=_replaced(strike.joint_velocities, options.joint_velocity),
    )


def _replaced(values: Mapping[str, float], settings: Iterable[Setting]) -> dict[str, float]:
    """Values by name or glob with settings applied. Later entries take precedence, so a name that is set again moves to the end."""
    given = dict(settings)
    return {name: value for name, value in values.items() if name not in given} | given


def point_from(robot: Robot, text: str, option: str) -> Point:
    """FRAME or FRAME:X,Y,Z as the value of an option; the frame's own name may hold a colon.

    Raises:
        SceneError: the offset is not three numbers.
    """
    frame, colon, offset = text.rpartition(":")
    if not colon or text in robot.frames:
        return Point(frame=text)
    try:
        return Point(frame=frame, offset=vector(offset, "X,Y,Z"))
    except typer.BadParameter as refusal:
        raise SceneError(f"{option} {frame}: {refusal.message}") from None
