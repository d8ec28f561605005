"""From the words of `shockpc analyze` to scenes: one for each landing."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shockpc.cli.parse import assignment, number, package_folders, vector, xacro_arguments
from shockpc.errors import SceneError
from shockpc.ledger import Ledger
from shockpc.model.contact import Contact, match_frames
from shockpc.model.landmarks import feet
from shockpc.model.robot import Robot, load_robot
from shockpc.model.transmission import Joints
from shockpc.scene import PLANES, Point, Scene, Strike, plane_of

__all__ = ["ROBOT_SUFFIXES", "Wishes", "build", "is_scene_file"]

ROBOT_SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf")


@dataclass(frozen=True, kw_only=True)
class Wishes:
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


def build(robot: str, wishes: Wishes, ledger: Ledger) -> tuple[Robot, list[Scene]]:
    """The robot, and one scene for each landing that is meant. What is typed goes before what a scene file says.

    Raises:
        ShockError: something typed is not valid, or not known; the text names the option.
    """
    scene = Scene(robot=robot)
    if is_scene_file(robot):
        from shockpc.scene_file import read_scene

        scene = read_scene(Path(robot))
    scene = dataclasses.replace(
        scene,
        srdf=wishes.srdf or scene.srdf,
        xacro={**scene.xacro, **xacro_arguments(wishes.xacro)},
        packages={**scene.packages, **package_folders(wishes.package)},
    )
    with ledger.stage("robot file"):
        loaded = load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    scene = dataclasses.replace(
        scene,
        base=wishes.base or scene.base,
        plane=scene.plane if wishes.plane is None else _plane(wishes.plane),
        posture=_posture(scene, wishes),
        strike=_strike(scene, wishes),
        stance=tuple(dict.fromkeys(frame for text in wishes.stance for frame in match_frames(loaded, text))) or scene.stance,
        joints=_joints(scene, wishes),
        assemble=wishes.assemble or scene.assemble,
        v_in=wishes.v_in or scene.v_in,
        pulse=wishes.pulse or scene.pulse,
        range_g=scene.range_g if wishes.range_g is None else number("--range-g", wishes.range_g),
        point=scene.point + tuple(_point(loaded, text) for text in wishes.point),
    )
    return loaded, [_with_contacts(scene, wishes, frames) for frames in _landings(loaded, scene, wishes)]


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


def _landings(robot: Robot, scene: Scene, wishes: Wishes) -> list[tuple[str, ...] | None]:
    """The frames of each landing; None for the contacts that the scene file gives."""
    if not wishes.contact:
        if scene.contact:
            return [None]
        known = feet(robot)
        listed = ", ".join(f'"{name}"' for name in known[:8]) or f'"{robot.links[-1]}"'
        raise SceneError(f'no contact is given, so nothing strikes robot "{robot.name}"; name one with --contact, such as {listed}')
    landings: list[tuple[str, ...]] = []
    for text in wishes.contact:
        parts = [(text,)] if text in robot.frames else [match_frames(robot, part) for part in _names(text)]
        if len(parts) > 1:
            landings.append(tuple(dict.fromkeys(frame for part in parts for frame in part)))
        else:
            landings += [(frame,) for frame in parts[0]]
    if wishes.together:
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


def _with_contacts(scene: Scene, wishes: Wishes, frames: tuple[str, ...] | None) -> Scene:
    """The scene of one landing."""
    changes: dict[str, Any] = {}
    if wishes.offset is not None:
        changes["offset"] = vector("--offset", wishes.offset, "0,0,-0.02")
    if wishes.contact_point is not None:
        changes["at"] = wishes.contact_point
    if wishes.slide:
        level = abs(plane_of(scene).normal[2]) > 1.0 - 1e-9
        velocity = scene.strike.velocity
        # In a plane seen from above, and struck within it, up is the world's y.
        changes["directions"] = ("y",) if level and velocity is not None and velocity[2] == 0.0 else ("z",)
    if wishes.restitution is not None:
        changes["restitution"] = number("--restitution", wishes.restitution)
    contacts = scene.contact if frames is None else tuple(Contact(frame=frame) for frame in frames)
    return dataclasses.replace(scene, contact=tuple(dataclasses.replace(contact, **changes) for contact in contacts))


def _posture(scene: Scene, wishes: Wishes) -> Any:
    """The posture, with what is typed put over it."""
    posture = scene.posture
    if wishes.posture is not None:
        posture = dataclasses.replace(posture, reference=wishes.posture)
    if wishes.base_rpy is not None:
        posture = dataclasses.replace(posture, base_rpy_deg=vector("--base-rpy", wishes.base_rpy, "0,15,0"), base_quaternion=None)
    sets = {}
    for text in wishes.set:
        name, value = assignment("--set", text, "JOINT=VALUE", "'*_knee=-60'")
        sets[name] = number(f"--set {name}", value)
    # Later words go over earlier ones, so a name that is typed again moves to the end.
    before = {name: value for name, value in posture.joints_deg.items() if name not in sets}
    return dataclasses.replace(posture, joints_deg=before | sets)


def _joints(scene: Scene, wishes: Wishes) -> Joints:
    """The drives, with what is typed put over what the scene says."""
    given = {}
    for text in wishes.armature:
        name, value = assignment("--armature", text, "JOINT=INERTIA", "'*_KFE=0.05'")
        given[name] = number(f"--armature {name}", value)
    before = {name: value for name, value in scene.joints.armature.items() if name not in given}
    return dataclasses.replace(
        scene.joints,
        model=wishes.joints or scene.joints.model,
        armature=before | given,
        locked=tuple(dict.fromkeys([*scene.joints.locked, *wishes.lock])),
    )


def _strike(scene: Scene, wishes: Wishes) -> Strike:
    """The strike, with what is typed put over it; a way of giving the velocity replaces the scene's way."""
    strike = scene.strike
    angle = None if wishes.strike_angle is None else number("--strike-angle", wishes.strike_angle)
    speed = None if wishes.speed is None else number("--speed", wishes.speed)
    if wishes.velocity is not None or wishes.drop_height is not None:
        strike = dataclasses.replace(
            strike,
            speed=speed,
            strike_angle_deg=angle,
            velocity=None if wishes.velocity is None else vector("--velocity", wishes.velocity, "0.5,0,-1"),
            drop_height=None if wishes.drop_height is None else number("--drop-height", wishes.drop_height),
        )
    elif angle is not None or speed is not None:
        strike = dataclasses.replace(
            strike,
            speed=strike.speed if speed is None else speed,
            strike_angle_deg=strike.strike_angle_deg if angle is None else angle,
            velocity=None,
            drop_height=None,
        )
    if wishes.angular_velocity is not None:
        strike = dataclasses.replace(strike, angular_velocity=vector("--angular-velocity", wishes.angular_velocity, "0,3,0"))
    rates = {}
    for text in wishes.joint_velocity:
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
