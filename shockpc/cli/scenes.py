"""From the options of a command to scenes: one for each landing."""

import dataclasses
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from shockpc.cli.options import SceneOptions
from shockpc.landing.contact import (
    contact_name,
    first_contact,
    landing_frames,
    match_contacts,
)
from shockpc.landing.feet.level_feet import default_landings
from shockpc.landing.ratings import part_from
from shockpc.landing.scenes.joint_options import Joints, Rotor, with_model
from shockpc.landing.scenes.scene import Contact, Posture, Scene
from shockpc.landing.scenes.scene_file import check_scene, plane_of, points_at, robot_of, scene_of
from shockpc.landing.scenes.strike import Strike, replaced_ways
from shockpc.robot.robot import Robot
from shockpc.text.arguments import typed
from shockpc.text.errors import SceneError, UnknownName
from shockpc.text.printed import few
from shockpc.text.trace import Trace

T = TypeVar("T")

LONGEST_NAME = 200
"""Bytes of a contact's name that become a part of a file's name."""

AnyRecord = TypeVar("AnyRecord", Contact, Posture, Joints, Scene, Strike)


def scenes_from(
    robot: str, options: SceneOptions, trace: Trace | None = None
) -> tuple[Robot, list[Scene]]:
    """The robot, and one scene for each landing that the options describe.

    Without a contact they are the default landings.

    An option replaces what a scene file says.

    Args:
        robot: its name or file, a scene, or a case of a file of budgets.
        options: of the command.
        trace: collects what loading the robot cost.

    Raises:
        ShockError: an option's value is not valid, or names nothing in the robot.
    """
    scene = _with_file(scene_named(robot), options)
    with (trace or Trace()).stage("robot file"):
        loaded = _robot_of(scene, options.contact)
    scene = _with_landing(scene, loaded, options)
    changes = options.fields(Contact)
    if options.contact or changes or not scene.contact:
        typed.add(Contact.__name__)
    if options.directions is not None:
        if options.slide:
            raise SceneError(
                "--slide means --directions along the normal only; leave one of them out"
            )
        changes["directions"] = options.directions
    scenes = []
    for landing in _contacts(loaded, scene, options):
        contacts = [_with(contact, **changes) for contact in landing]
        if options.slide:
            contacts = [_sliding(contact, scene) for contact in contacts]
        scenes.append(_with(scene, contact=tuple(contacts)))
    return loaded, scenes


def _with_landing(scene: Scene, robot: Robot, options: SceneOptions) -> Scene:
    """A scene with all options but those of its robot and its contacts."""
    values = options.fields(Scene)
    values.pop("base", None)
    normal, tangential = values.pop("contact_stiffness", (None, None))
    values["posture"] = _posture(scene.posture, options)
    values["strike"] = _strike(scene.strike, options)
    stance: list[str] = []
    for text in options.stance:
        stance += match_contacts(robot, text)
    if stance:
        values["stance"] = tuple(dict.fromkeys(stance))
    values["joints"] = _joints(scene.joints, options)
    parts = [part_from(robot, at, rating) for at, rating in options.part]
    values["part"] = (*scene.part, *parts)
    points = list(scene.point)
    for text in options.at:
        points += points_at(robot, text)
    values["point"] = tuple(points)
    scene = _with(scene, **values)
    if normal is None:
        return scene
    return dataclasses.replace(scene, contact_stiffness=normal, tangential_stiffness=tangential)


def _sliding(contact: Contact, scene: Scene) -> Contact:
    """A contact that stops its point along the normal alone."""
    if contact.normal:
        return _with(contact, directions=(contact.normal,))
    return _with(contact, directions=_up(scene))


def landings_from(
    names: Iterable[str], options: SceneOptions, trace: Trace | None = None
) -> dict[str, tuple[Robot, Scene]]:
    """All landings of scenes and robots by name, each with its robot.

    Those of a robot without contacts are the default ones.
    """
    names = list(dict.fromkeys(names))
    landings: dict[str, tuple[Robot, Scene]] = {}
    stems = [Path(name).stem for name in names]
    for name, stem in zip(names, stems, strict=True):
        robot, scenes = scenes_from(name, options, trace)
        prefix = ""
        if is_scene_file(name) and len(names) > 1:
            prefix = f"{stem} " if stems.count(stem) == 1 else f"{name} "
        for scene, contact in zip(scenes, file_names(scenes), strict=True):
            landings[prefix + contact] = (robot, scene)
    return landings


def postures_from(
    names: Iterable[str], options: SceneOptions, trace: Trace | None = None
) -> tuple[Robot, dict[str, Scene]]:
    """A robot, and postures of it by the names of their scenes; of a single one the name is empty.

    Raises:
        ShockError: as for `scenes_from`; or the scenes are of different robots.
    """
    names = list(dict.fromkeys(names))
    robots: list[Robot] = []
    postures: dict[str, Scene] = {}
    for name in names:
        with_any, _ = with_contact(name, options, ["*"])
        robot, scenes = scenes_from(name, with_any, trace)
        robots.append(robot)
        key = Path(name).stem if len(names) > 1 else ""
        postures[key] = scenes[0]
    if any(robot is not robots[0] for robot in robots):
        raise SceneError(
            "the postures are of different robots; give scenes of one robot, or one robot at a time"
        )
    return robots[0], postures


def _with_file(scene: Scene, options: SceneOptions) -> Scene:
    """A scene with those options on which its robot depends."""
    return _with(
        scene,
        base=options.given.get("base"),
        xacro={**scene.xacro, **dict(options.xacro)},
        packages={**scene.packages, **options.packages},
    )


def _robot_of(scene: Scene, contacts: Iterable[str]) -> Robot:
    names: list[str] = []
    for text in contacts:
        names += [name.strip() for name in (text, *text.split("+"))]
    return robot_of(scene, names)


def with_contact(
    robot: str, options: SceneOptions, contacts: list[str]
) -> tuple[SceneOptions, list[str]]:
    """Options with a contact until the rows' are set, and the rows' contacts.

    The contact is added where neither options nor scene give one. It is the first of the rows' that
    means one landing of the robot; rows with another text are refused later. So is a row without
    any, which would have that of the others: it has a text that names nothing.

    Raises:
        ShockError: the scene or the robot cannot be read.
    """
    scene = scene_named(robot)
    if options.contact or scene.contact:
        return options, contacts
    loaded = _robot_of(_with_file(scene, options), filter(str.strip, contacts))
    chosen = first_contact(loaded, contacts)
    return options._replace(contact=(chosen,) if chosen else ()), [text or " " for text in contacts]


def file_names(scenes: list[Scene]) -> list[str]:
    """The landings' contacts as names of files, all different.

    None leads out of its folder, is hidden or is too long.
    """
    names: list[str] = []
    taken: set[str] = set()
    for scene in scenes:
        stem = re.sub(r"[^\w\-+.]", "_", contact_name(scene))
        stem = re.sub(r"^\.", "_", stem)
        stem = stem.encode()[:LONGEST_NAME].decode(errors="ignore")
        name = stem
        number = 1
        while name.casefold() in taken:  # in file systems without upper case, too
            number += 1
            name = f"{stem}-{number}"
        taken.add(name.casefold())
        names.append(name)
    return names


def one_scene(robot: str, options: SceneOptions, trace: Trace | None = None) -> tuple[Robot, Scene]:
    """The robot and the landing of a command that is about one landing of it.

    Raises:
        ShockError: as for `scenes_from`, or the options describe several landings.
    """
    loaded, scenes = scenes_from(robot, options, trace)
    if len(scenes) > 1:
        names = few([contact_name(scene) for scene in scenes], 6)
        raise SceneError(
            f'this command takes one landing, but "{robot}" has {len(scenes)}: {names}; name one, '
            f"such as "
            f"--contact {contact_name(scenes[0])}"
        )
    return loaded, scenes[0]


def scene_named(name: str) -> Scene:
    """The scene of a file, of FILE.toml:CASE, or of a robot without a scene.

    Raises:
        ShockError: a file cannot be read, or has no such case.
    """
    file, mark, case = name.partition(".toml:")
    if mark and not Path(name).exists():
        from shockpc.evaluation.budgets import read_budgets

        cases = {
            known.name: known.landings[0][1] for known in read_budgets(Path(f"{file}.toml")).cases
        }
        if case not in cases:
            raise UnknownName("case", case, cases, f"{file}.toml", "")
        return cases[case]
    return scene_of(name)


def is_scene_file(name: str) -> bool:
    """True if a scene is analysed, not a robot."""
    return Path(name).suffix.casefold() == ".toml" or ".toml:" in name


def _contacts(robot: Robot, scene: Scene, options: SceneOptions) -> list[tuple[Contact, ...]]:
    """The contacts of each landing.

    They are those that are named, else the scene's, else those of `default_landings`.
    """
    if scene.contact and not options.contact:
        return [scene.contact]
    landings: dict[tuple[str, ...], None] = {}
    for text in options.contact:
        landings |= dict.fromkeys(landing_frames(robot, text))
    if not landings:
        return default_landings(robot, scene, options.given.get("normal"))
    contacts: list[tuple[Contact, ...]] = []
    for frames in landings:
        contacts.append(tuple(Contact(frame=frame) for frame in frames))
    return contacts


def _up(scene: Scene) -> tuple[str, ...]:
    """The direction that a sliding contact keeps: z, or the world's y.

    It is y in the plane seen from above with a velocity in it.
    """
    velocity = scene.strike.velocity
    seen_from_above = plane_of(check_scene(scene)).level
    if seen_from_above and velocity is not None and velocity[2] == 0.0:
        return ("y",)
    return ("z",)


def _with(record: AnyRecord, **values: Any) -> AnyRecord:
    """A record with those values that are not None; pairs of a mapping go over what it has."""
    changes: dict[str, Any] = {}
    for name, value in values.items():
        present = getattr(record, name)
        if isinstance(present, Mapping) and isinstance(value, tuple):
            changes[name] = _replaced(present, value)
        elif value is not None:
            changes[name] = value
    return dataclasses.replace(record, **changes)


def _posture(posture: Posture, options: SceneOptions) -> Posture:
    typed_fields = options.fields(Posture)
    if "base_rpy_deg" in typed_fields:
        posture = dataclasses.replace(posture, base_quaternion=None)
    return _with(posture, **typed_fields, joints_deg=_replaced(posture.joints_deg, options.set))


def _joints(joints: Joints, options: SceneOptions) -> Joints:
    typed_fields = options.fields(Joints)
    # A model that is typed replaces what the scene says of drives; what is typed beside it counts
    # with it.
    joints = with_model(joints, typed_fields["model"]) if "model" in typed_fields else joints
    locked = tuple(dict.fromkeys([*joints.locked, *options.lock]))
    motors = [
        (name, Rotor(inertia=inertia, gear_ratio=n, stiffness=k, gear=gear))
        for name, (inertia, n, k, gear) in options.rotor
    ]
    # One way of giving a joint's drive replaces the scene's way.
    rotor = {
        name: drive for name, drive in joints.rotor.items() if name not in dict(options.armature)
    }
    armature = {
        name: drive for name, drive in joints.armature.items() if name not in dict(options.rotor)
    }
    return _with(
        joints,
        **typed_fields,
        armature=_replaced(armature, options.armature),
        rotor=_replaced(rotor, motors),
        stiffness=_replaced(joints.stiffness, options.joint_stiffness),
        locked=locked,
    )


def _strike(strike: Strike, options: SceneOptions) -> Strike:
    """The strike with the options applied.

    One way of giving the velocity replaces the scene's way.
    """
    typed_fields = options.fields(Strike)
    replaced: dict[str, Any] = dict.fromkeys(replaced_ways(typed_fields))
    strike = dataclasses.replace(strike, **replaced)
    return _with(
        strike,
        **typed_fields,
        joint_velocities=_replaced(strike.joint_velocities, options.joint_velocity),
    )


def _replaced(values: Mapping[str, T], settings: Iterable[tuple[str, T]]) -> dict[str, T]:
    """Values by name or glob with settings applied.

    Later entries take precedence, so a name that is set again moves to the end.
    """
    replacing = dict(settings)
    return {name: value for name, value in values.items() if name not in replacing} | replacing
