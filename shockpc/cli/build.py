"""From the words of `shockpc analyze` to scenes: one for each landing."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shockpc.cli.parse import assignment, number, package_folders, vector, xacro_arguments
from shockpc.errors import SceneError
from shockpc.model.contact import Contact, match_frames
from shockpc.model.joint_model import Joints
from shockpc.robot.landmarks import feet
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import PLANES, Point, Scene, Strike, plane_of
from shockpc.trace import Trace

__all__ = ["ROBOT_SUFFIXES", "Options", "build", "is_scene_file"]

ROBOT_SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf")


@dataclass(frozen=True, kw_only=True)
class Options:
    """The options of `shockpc analyze` that say what to compute, as they were typed; None or empty where nothing was."""

    contact: tuple[str, ...]
    together: bool
    offset: str | None
    contact_point: Any
    slide: bool
    restitution: str | None
    posture: str | None
    srdf: str | None
    set: tuple[str, ...]
    base_rpy: str | None
    base: Any
    strike_angle: str | None
    speed: str | None
    velocity: str | None
    drop_height: str | None
    angular_velocity: str | None
    joint_velocity: tuple[str, ...]
    stance: tuple[str, ...]
    joints: Any
    armature: tuple[str, ...]
    lock: tuple[str, ...]
    assemble: tuple[str, ...]
    v_in: Any
    pulse: str | None
    range_g: str | None
    plane: str | None
    point: tuple[str, ...]
    xacro: tuple[str, ...]
    package: tuple[str, ...]


def build(robot: str, options: Options, trace: Trace) -> tuple[Robot, list[Scene]]:
    """The robot, and one scene for each landing that is meant. What is typed goes before what a scene file says.

    Raises:
        ShockError: something typed is not valid, or not known; the text names the option.
    """
    scene = Scene(robot=robot)
    if is_scene_file(robot):
        from shockpc.scene import read_scene

        scene = read_scene(Path(robot))
    scene = dataclasses.replace(
        scene,
        srdf=options.srdf or scene.srdf,
        xacro={**scene.xacro, **xacro_arguments(options.xacro)},
        packages={**scene.packages, **package_folders(options.package)},
    )
    with trace.stage("robot file"):
        loaded = load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    scene = dataclasses.replace(
        scene,
        base=options.base or scene.base,
        plane=scene.plane if options.plane is None else _plane(options.plane),
        posture=_posture(scene, options),
        strike=_strike(scene, options),
        stance=tuple(dict.fromkeys(frame for text in options.stance for frame in match_frames(loaded, text))) or scene.stance,
        joints=_joints(scene, options),
        assemble=options.assemble or scene.assemble,
        v_in=options.v_in or scene.v_in,
        pulse=options.pulse or scene.pulse,
        range_g=scene.range_g if options.range_g is None else number("--range-g", options.range_g),
        point=scene.point + tuple(_point(loaded, text) for text in options.point),
    )
    return loaded, [_with_contacts(scene, options, frames) for frames in _landings(loaded, scene, options)]


def is_scene_file(name: str) -> bool:
    """Whether a path is a scene: told by its content where the suffix leaves it open, for a robot file begins with a tag."""
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


def _landings(robot: Robot, scene: Scene, options: Options) -> list[tuple[str, ...] | None]:
    """The frames of each landing; None for the contacts that the scene file gives."""
    if not options.contact:
        if scene.contact:
            return [None]
        known = feet(robot)
        listed = ", ".join(f'"{name}"' for name in known[:8]) or f'"{robot.links[-1]}"'
        raise SceneError(f'no contact is given, so nothing strikes robot "{robot.name}"; name one with --contact, such as {listed}')
    landings: list[tuple[str, ...]] = []
    for text in options.contact:
        parts = [(text,)] if text in robot.frames else [match_frames(robot, part) for part in _names(text)]
        if len(parts) > 1:
            landings.append(tuple(dict.fromkeys(frame for part in parts for frame in part)))
        else:
            landings += [(frame,) for frame in parts[0]]
    if options.together:
        landings = [tuple(frame for landing in landings for frame in landing)]
    return list(dict.fromkeys(tuple(dict.fromkeys(landing)) for landing in landings))


def _names(text: str) -> list[str]:
    """The names or patterns in A+B."""
    names = [part.strip() for part in text.split("+")]
    if not all(names):
        raise SceneError(f'--contact: "{text}" holds an empty name; valid are a name, A+B, or a glob such as "*_foot"')
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise SceneError(f'--contact: "{text}" names "{twice[0]}" twice, and one contact strikes once; leave one of them out')
    return names


def _with_contacts(scene: Scene, options: Options, frames: tuple[str, ...] | None) -> Scene:
    """The scene of one landing."""
    changes: dict[str, Any] = {}
    if options.offset is not None:
        changes["offset"] = vector("--offset", options.offset, "0,0,-0.02")
    if options.contact_point is not None:
        changes["at"] = options.contact_point
    if options.slide:
        level = abs(plane_of(scene).normal[2]) > 1.0 - 1e-9
        velocity = scene.strike.velocity
        # In a plane seen from above, and struck within it, up is the world's y.
        changes["directions"] = ("y",) if level and velocity is not None and velocity[2] == 0.0 else ("z",)
    if options.restitution is not None:
        changes["restitution"] = number("--restitution", options.restitution)
    contacts = scene.contact if frames is None else tuple(Contact(frame=frame) for frame in frames)
    return dataclasses.replace(scene, contact=tuple(dataclasses.replace(contact, **changes) for contact in contacts))


def _posture(scene: Scene, options: Options) -> Any:
    """The posture, with what is typed put over it."""
    posture = scene.posture
    if options.posture is not None:
        posture = dataclasses.replace(posture, reference=options.posture)
    if options.base_rpy is not None:
        posture = dataclasses.replace(posture, base_rpy_deg=vector("--base-rpy", options.base_rpy, "0,15,0"), base_quaternion=None)
    sets = {}
    for text in options.set:
        name, value = assignment("--set", text, "JOINT=VALUE", "'*_knee=-60'")
        sets[name] = number(f"--set {name}", value)
    # Later words go over earlier ones, so a name that is typed again moves to the end.
    before = {name: value for name, value in posture.joints_deg.items() if name not in sets}
    return dataclasses.replace(posture, joints_deg=before | sets)


def _joints(scene: Scene, options: Options) -> Joints:
    """The drives, with what is typed put over what the scene says."""
    given = {}
    for text in options.armature:
        name, value = assignment("--armature", text, "JOINT=INERTIA", "'*_KFE=0.05'")
        given[name] = number(f"--armature {name}", value)
    before = {name: value for name, value in scene.joints.armature.items() if name not in given}
    return dataclasses.replace(
        scene.joints,
        model=options.joints or scene.joints.model,
        armature=before | given,
        locked=tuple(dict.fromkeys([*scene.joints.locked, *options.lock])),
    )


def _strike(scene: Scene, options: Options) -> Strike:
    """The strike, with what is typed put over it; a way of giving the velocity replaces the scene's way."""
    strike = scene.strike
    angle = None if options.strike_angle is None else number("--strike-angle", options.strike_angle)
    speed = None if options.speed is None else number("--speed", options.speed)
    if options.velocity is not None or options.drop_height is not None:
        strike = dataclasses.replace(
            strike,
            speed=speed,
            strike_angle_deg=angle,
            velocity=None if options.velocity is None else vector("--velocity", options.velocity, "0.5,0,-1"),
            drop_height=None if options.drop_height is None else number("--drop-height", options.drop_height),
        )
    elif angle is not None or speed is not None:
        strike = dataclasses.replace(
            strike,
            speed=strike.speed if speed is None else speed,
            strike_angle_deg=strike.strike_angle_deg if angle is None else angle,
            velocity=None,
            drop_height=None,
        )
    if options.angular_velocity is not None:
        strike = dataclasses.replace(strike, angular_velocity=vector("--angular-velocity", options.angular_velocity, "0,3,0"))
    rates = {}
    for text in options.joint_velocity:
        name, value = assignment("--joint-velocity", text, "JOINT=RATE", "'*_knee=2.5'")
        rates[name] = number(f"--joint-velocity {name}", value)
    before = {name: value for name, value in strike.joint_velocities.items() if name not in rates}
    return dataclasses.replace(strike, joint_velocities=before | rates)


def _plane(text: str) -> Any:
    """A plane's name or normal."""
    if text in PLANES:
        return text
    if "," not in text:
        raise SceneError(f'--plane: "{text}" is no plane; valid are {", ".join(PLANES)} or a normal such as 0,-1,0')
    return vector("--plane", text, "0,-1,0")


def _point(robot: Robot, text: str) -> Point:
    """FRAME or FRAME:x,y,z; the frame's own name may hold a colon."""
    frame, colon, offset = text.rpartition(":")
    if not colon or text in robot.frames:
        return Point(frame=text)
    return Point(frame=frame, offset=vector(f"--point {frame}", offset, "0,0,0.1"))
