"""An MJCF made plain: includes, repeated sections, defaults and orientations written out, so that nothing is left to guess.

Pinocchio reads only the first of a repeated section, and only above the bodies; it overlooks some defaults (a geom's mass, a
joint's position), and where a top-level body starts. In the plain text none of this occurs. What cannot be made plain is
refused by `mjcf_refusals`.
"""

import os
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.markup import read_markup
from shockpc.robot.mjcf_places import ORIENTATIONS, write_out_places
from shockpc.robot.mjcf_refusals import check_bodies, check_numbers, check_sections, check_ties
from shockpc.robot.mjcf_weights import weighed_by_geoms
from shockpc.robot.reach import Reach
from shockpc.robot.urdf_numbers import vector

__all__ = ["plain_mjcf"]

_FIRST = ("compiler", "default")


def plain_mjcf(root: Element, reach: Reach) -> tuple[str, tuple[str, ...]]:
    """Write out everything that an MJCF leaves implicit.

    Args:
        root: its <mujoco> element, changed in place.
        reach: what the file may read.

    Returns:
        MJCF text without includes, defaults, frames and bodies that no joint moves, and what was left out of it.

    Raises:
        RobotError: an included file is missing or out of reach, or the model holds what Pinocchio would get wrong.
    """
    file = reach.file.name
    _include(root, reach, [reach.file])
    _merge_sections(root)
    check_sections(root, file)
    world = root.find("worldbody")
    if world is None or world.find(".//body") is None:  # it may lie in a frame
        raise RobotError(f"{file} has no <body> in a <worldbody>, so there is no robot in it; is it a part for another file?")
    compiler = root.find("compiler")
    _write_out_defaults(root, world, file)
    check_ties(root, file)
    _name_bodies(world)
    check_numbers(world, file)
    write_out_places(world, compiler, file)
    warnings = weighed_by_geoms(world, compiler, file)
    check_bodies(world, file)
    warnings += _one_robot(root, world, file) + _whole_keys(root, world, file)
    if compiler is not None:
        for key in ("meshdir", "texturedir", "assetdir"):
            if key in compiler.attrib:  # the plain text may be read from another folder
                compiler.set(key, str(reach.file.parent / compiler.attrib[key]))
    return ElementTree.tostring(root, encoding="unicode"), warnings


def _include(parent: Element, reach: Reach, opened: list[object]) -> None:
    """Put the contents of included files in place of their <include>, which MuJoCo counts from the main file's folder."""
    children = list(parent)
    for child in children:
        if child.tag != "include":
            _include(child, reach, opened)
            continue
        named = child.get("file", "")
        path = reach.require(reach.file.parent / named, named)
        if not os.path.isfile(path):
            raise RobotError(f'{reach.file.name} includes "{named}", which does not exist')
        if path in opened:
            raise RobotError(f'{reach.file.name} includes "{named}" twice; MuJoCo allows a file once, so save it under two names')
        opened.append(path)
        part = read_markup(path).root
        _include(part, reach, opened)
        place = list(parent).index(child)
        parent.remove(child)
        for offset, element in enumerate(part):
            parent.insert(place + offset, element)


def _merge_sections(root: Element) -> None:
    """Make one of every repeated section, as MuJoCo does, with the compiler and the defaults first."""
    merged: dict[str, Element] = {}
    for section in list(root):
        root.remove(section)
        kept = merged.setdefault(section.tag, section)
        if kept is not section:
            kept.attrib.update(section.attrib)
            for child in section:
                alike = kept.find(child.tag) if section.tag == "default" and child.tag != "default" else None
                if alike is not None:
                    alike.attrib.update(child.attrib)
                else:
                    kept.append(child)
    root.extend(sorted(merged.values(), key=lambda section: section.tag not in _FIRST))


def _write_out_defaults(root: Element, world: Element, file: str) -> None:
    """Give every joint, geom, site, asset and equality the attributes of its class; drop the classes, and what is not active."""
    classes: dict[str, dict[str, dict[str, str]]] = {}
    top = root.find("default")
    main = top.get("class", "main") if top is not None else "main"
    pending: list[tuple[Element, dict[str, dict[str, str]]]] = [(top, {})] if top is not None else []
    classes[main] = {}
    while pending:
        default, inherited = pending.pop()
        own = dict(inherited)
        for child in default:
            if child.tag != "default":
                own[child.tag] = {**own.get(child.tag, {}), **child.attrib}
        classes[default.get("class", main)] = own
        pending += [(child, own) for child in default.findall("default")]
    if top is not None:
        root.remove(top)

    def of_class(name: str) -> dict[str, dict[str, str]]:
        if name not in classes:
            known = ", ".join(f'"{known}"' for known in sorted(classes))
            raise RobotError(f'{file}: default class "{name}" is used but not defined; there are {known}')
        return classes[name]

    parents = [(parent, main) for parent in (world, *root.findall("asset"))]
    while parents:
        parent, active = parents.pop()
        active = parent.attrib.pop("childclass", active)
        of_class(active)
        for element in parent:
            if element.tag in ("body", "frame"):
                parents.append((element, active))
            else:
                attributes = dict(of_class(element.attrib.pop("class", active)).get(element.tag, {}))
                if any(key in element.attrib for key in (*ORIENTATIONS, "fromto")):
                    attributes = {key: value for key, value in attributes.items() if key not in ORIENTATIONS}
                for key, value in attributes.items():
                    element.attrib.setdefault(key, value)
    # Pinocchio closes an inactive equality like any other.
    for section in root.findall("equality"):
        for tie in list(section):
            for key, value in of_class(tie.attrib.pop("class", main)).get("equality", {}).items():
                tie.attrib.setdefault(key, value)
            if tie.attrib.pop("active", "true") == "false":
                section.remove(tie)


def _name_bodies(world: Element) -> None:
    """Name the bodies without a name after their number, in the order of the file; Pinocchio loses joints of nameless ones."""
    taken = {body.get("name") for body in world.iter("body")}
    for number, body in enumerate(world.iter("body"), start=1):
        if not body.get("name"):
            name = f"body_{number}"
            while name in taken:
                name += "_"
            body.set("name", name)
            taken.add(name)


def _one_robot(root: Element, world: Element, file: str) -> tuple[str, ...]:
    """Keep the one top-level body that moves, and of the others the bare places that an equality ties to."""
    tops = world.findall("body")
    movers = [top for top in tops if top.find(".//joint") is not None or top.find(".//freejoint") is not None]
    if not movers:
        raise RobotError(f"{file}: no body in it has a joint, so nothing moves; give the robot's base a <freejoint/>")
    if len(movers) > 1:
        listed = ", ".join(f'"{top.get("name")}"' for top in movers)
        raise RobotError(f"{file} holds {len(movers)} separate moving bodies, {listed}; keep one robot in the file")
    robot = movers[0]
    ends = {(key[:4], name) for tie in root.findall("equality/*") for key, name in tie.items() if key[:4] in ("body", "site")}
    tied, left = [], []
    for top in tops:
        if top is not robot:
            world.remove(top)
            if ends.isdisjoint((part.tag, part.get("name")) for part in top.iter()):
                left.append(f'"{top.get("name")}"')
            else:
                tied.append(_bare(top))
    free = robot.find("freejoint") is not None or any(joint.get("type") == "free" for joint in robot.findall("joint"))
    if tied or (not free and any(key in robot.attrib for key in ("pos", *ORIENTATIONS))):
        # Pinocchio reads one top-level body, and puts it at the origin; one level down all are put where they belong.
        world.remove(robot)
        ElementTree.SubElement(world, "body", {"name": "worldbody"}).extend([*tied, robot])
    if not left:
        return ()
    return (f"{file}: {', '.join(left)} cannot move and is left out; a strike on the robot does not reach it",)


def _bare(top: Element) -> Element:
    """A body that cannot move, as a place: its bodies and sites."""
    for body in list(top.iter("body")):
        for part in list(body):
            if part.tag not in ("body", "site"):
                body.remove(part)
    return top


def _whole_keys(root: Element, world: Element, file: str) -> tuple[str, ...]:
    """Drop the keyframes that do not hold one value for each position variable; Pinocchio would refuse the whole file."""
    sizes = {"free": 7, "ball": 4}
    wanted = sum(7 for _ in world.iter("freejoint")) + sum(sizes.get(j.get("type", ""), 1) for j in world.iter("joint"))
    warnings = []
    for keys in root.findall("keyframe"):
        for key in keys.findall("key"):
            text = key.get("qpos")
            if text is not None and vector(text, wanted) is None:
                keys.remove(key)
                warnings.append(
                    f'{file}: keyframe "{key.get("name", "")}" does not hold {wanted} finite numbers; the posture is left out'
                )
    return tuple(warnings)
