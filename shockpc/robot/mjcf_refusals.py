"""What Pinocchio would read wrongly, or not at all, in an MJCF: refused, so that no wrong number is printed.

Each rule stands for a small model on which the joint-space inertia of Pinocchio and of MuJoCo was seen to differ.
"""

import math
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.urdf_numbers import vector

__all__ = ["check_bodies", "check_numbers", "check_sections", "check_ties"]

_REMEDY = (
    'Have MuJoCo work it out: compile the file once with <compiler saveinertial="true"/> and give what mujoco.mj_saveLastXML writes'
)
# Compiler settings that change masses or places: attribute, values that change nothing, what it does.
_COMPILER = (
    ("coordinate", ("local",), "reads positions in the world's frame"),
    ("settotalmass", ("-1",), "scales all masses"),
    ("balanceinertia", ("false",), "changes inertias that are not physical"),
)
_UNREAD = ("replicate", "composite", "flexcomp", "attach")
_JOINTS = ("free", "ball", "slide", "hinge")
# Numbers of each element: attribute and how many (0: any number of them).
_PLACE = (("pos", 3), ("quat", 4), ("axisangle", 4), ("euler", 3), ("xyaxes", 6), ("zaxis", 3))
_NUMBERS: dict[str, tuple[tuple[str, int], ...]] = {
    "body": _PLACE,
    "frame": _PLACE,
    "camera": _PLACE,
    "inertial": (*_PLACE, ("mass", 1), ("diaginertia", 3), ("fullinertia", 6)),
    "joint": (("pos", 3), ("axis", 3), ("armature", 1), ("range", 2), ("ref", 1)),
    "geom": (*_PLACE, ("size", 0), ("fromto", 6), ("mass", 1), ("density", 1)),
    "site": (*_PLACE, ("fromto", 6)),
}


def check_sections(root: Element, file: str) -> None:
    """Refuse settings and couplings outside the bodies that would change the numbers.

    Args:
        root: the <mujoco> element, each section once.
        file: the file's name, for messages.

    Raises:
        RobotError: naming the element.
    """
    compiler = root.find("compiler")
    for key, harmless, effect in _COMPILER if compiler is not None else ():
        value = " ".join(compiler.get(key, harmless[0]).split()) if compiler is not None else ""
        if value not in harmless:
            raise RobotError(f'{file}: <compiler {key}="{value}"> {effect}, which Pinocchio does not. {_REMEDY}')
    for kind, path in (("tendon", "tendon/*"), ("actuator", "actuator/*"), ("default", "default//*")):
        for element in root.findall(path):
            if kind == "default" and element.tag in ("joint", "default"):
                continue
            if (vector(element.get("armature", "0"), 1) or (1.0,))[0] != 0:
                raise RobotError(
                    f"{file}: <{element.tag}> has armature {element.get('armature')}, which Pinocchio reads at joints only; "
                    "give the joint that armature, times gear² for an actuator"
                )


def check_ties(root: Element, file: str) -> None:
    """Refuse an equality that is not computed; those that are not active are gone by now.

    Raises:
        RobotError: naming the element.
    """
    followers: set[str] = set()
    for tie in root.findall("equality/*"):
        _check_tie(tie, file)
        if tie.tag == "joint":
            follower = tie.get("joint1", "")
            if follower in followers:
                raise RobotError(
                    f'{file}: two equalities have joint1="{follower}", and a joint can follow only once; turn one of them round '
                    '(joint1 and joint2 exchanged, polycoef="-a0/a1 1/a1 0 0 0"), or set active="false" to do without it'
                )
            followers.add(follower)


def _check_tie(tie: Element, file: str) -> None:
    """Refuse an equality that is not a loop closed by a point or a frame, or a joint that follows another in proportion."""
    name = f' "{tie.get("name")}"' if tie.get("name") else ""
    if tie.tag in ("connect", "weld"):
        _check_ends(tie, f"{file}: the equality {tie.tag}{name}")
    if tie.tag == "weld" and (vector(tie.get("torquescale", "1"), 1) or (1.0,))[0] == 0.0:
        raise RobotError(
            f'{file}: the equality weld{name} has torquescale="0", so it holds a point and no orientation; give it as a connect'
        )
    if tie.tag in ("connect", "weld"):
        return
    if tie.tag != "joint":
        raise RobotError(
            f"{file}: the equality {tie.tag}{name} couples bodies in a way that is not computed, and without it the numbers would "
            'be wrong; valid are connect, weld and joint; set active="false" to do without it on purpose'
        )
    if not tie.get("joint1"):
        raise RobotError(f"{file}: the equality joint{name} names no joint1, so nothing follows; name the joint that does")
    text = tie.get("polycoef", "0 1 0 0 0")
    curved = vector(text, len(text.split()))
    if not curved or any(curved[2:]):
        raise RobotError(
            f"{file}: the equality joint{name} couples joints by a curve, polycoef {tie.get('polycoef')}; only proportion can be "
            "computed: give it as a0 a1 0 0 0, the slope at the posture of interest"
        )


def _check_ends(tie: Element, which: str) -> None:
    """Two sites, or a body with what says where it is held; and not the same one twice."""
    needed = ("body1", "anchor") if tie.tag == "connect" else ("body1",)
    sites = "site1" in tie.attrib or "site2" in tie.attrib
    whole = all(key in tie.attrib for key in (("site1", "site2") if sites else needed))
    if not whole or (sites and any(key in tie.attrib for key in ("body1", "body2", "anchor", "relpose"))):
        raise RobotError(
            f"{which} does not say what it holds; give it site1 and site2 and nothing else, or {' and '.join(needed)}, "
            "with body2 unless that is the world"
        )
    kind = "site" if sites else "body"
    first, second = tie.get(f"{kind}1", ""), tie.get(f"{kind}2", "world")
    if first == second:
        raise RobotError(f'{which} holds {kind} "{first}" to itself, which closes no loop; name two, or take it out')
    for key, size in (("anchor", 3), ("relpose", 7)):
        if key in tie.attrib and vector(tie.get(key), size) is None:
            raise RobotError(f'{which}: {key} is "{tie.get(key)}"; it has to be {size} finite numbers')


def check_numbers(world: Element, file: str) -> None:
    """Refuse a body with a number in or on it that is not finite, or with too few or too many of them.

    Args:
        world: the <worldbody>, defaults written out, every body named.
        file: the file's name, for messages.

    Raises:
        RobotError: naming the body, the attribute and its value.
    """
    parents = [(world, "world")]
    while parents:
        parent, body = parents.pop()
        for element in parent:
            name = element.get("name", "") if element.tag == "body" else body
            for key, size in _NUMBERS.get(element.tag, ()):
                text = element.get(key)
                if text is not None and vector(text, size or len(text.split())) is None:
                    wanted = f"{size} finite number{'s' * (size > 1)}" if size else "finite numbers"
                    raise RobotError(f'{file}: body "{name}": {element.tag} {key} is "{text}"; it has to be {wanted}')
            if element.tag in ("body", "frame"):
                parents.append((element, name))


def check_bodies(world: Element, file: str) -> None:
    """Refuse bodies and joints that Pinocchio would leave out, or weigh otherwise than MuJoCo.

    Args:
        world: the <worldbody>, defaults and places written out, every body named.
        file: the file's name, for messages.

    Raises:
        RobotError: naming the body or joint.
    """
    for tag in _UNREAD:
        if world.find(f".//{tag}") is not None:
            raise RobotError(
                f"{file}: there is a <{tag}> among the bodies, and Pinocchio passes over what it stands for. {_REMEDY}"
            )
    for kind in ("body", "joint"):
        names = [element.get("name") for element in world.iter(kind) if element.get("name")]
        for name in names:
            if names.count(name) > 1:
                raise RobotError(f'{file}: two {kind} elements are called "{name}"; rename one')
    mass = 0.0
    for body in world.iter("body"):
        whose = f'{file}: body "{body.get("name")}"'
        for joint in body.findall("joint"):
            _check_joint(joint, whose)
        mass += sum(_masses(body, whose))
    if mass <= 0:
        raise RobotError(f"{file}: no body has mass, so nothing in it can be struck; give the bodies <inertial> or geoms with mass")


def _check_joint(joint: Element, whose: str) -> None:
    """A type that exists, and an axis with a direction."""
    named = f'{whose}: joint "{joint.get("name", "")}"'
    kind = joint.get("type", "hinge")
    if kind not in _JOINTS:
        raise RobotError(f'{named} is of type "{kind}", which MJCF does not have; it has {", ".join(_JOINTS)}')
    if kind in ("hinge", "slide") and not any(vector(joint.get("axis", "0 0 1"), 3) or ()):
        raise RobotError(f"{named}: its axis is 0 0 0, so it has no direction to move in; give it one")
    armature = (vector(joint.get("armature", "0"), 1) or (0.0,))[0]
    if armature < 0:
        raise RobotError(f"{named}: armature {joint.get('armature')} is negative; no rotor has that")
    if kind == "free" and armature > 0:
        raise RobotError(
            f"{named} is free and has armature {armature:g}, its own or its default class's: MuJoCo adds that to the mass and "
            'the inertia of the whole robot, but a free base has no drive; set armature="0" there, or make it a <freejoint/>, '
            "which takes no defaults"
        )


def _masses(body: Element, whose: str) -> Iterator[float]:
    """The masses that make up a body, each checked: of its <inertial>, else of its geoms."""
    inertials = body.findall("inertial")
    if len(inertials) > 1:
        raise RobotError(f"{whose} has {len(inertials)} <inertial> elements; keep one")
    for inertial in inertials:
        mass = vector(inertial.get("mass"), 1)
        moments = vector(inertial.get("diaginertia"), 3) or (vector(inertial.get("fullinertia"), 6) or ())[:3]
        if mass is None or not moments:
            missing = "mass" if mass is None else "diaginertia or fullinertia"
            raise RobotError(f"{whose}: its <inertial> has no {missing}; add it, or drop the <inertial> to take it from the geoms")
        if mass[0] < 0 or min(moments) < 0:
            raise RobotError(f"{whose}: mass {mass[0]:g} kg with moments {moments} kg m² is negative somewhere; no body has that")
        yield mass[0]
    for geom in body.findall("geom") if not inertials else ():
        density, mass = vector(geom.get("density", "1000"), 1), vector(geom.get("mass"), 1)
        weight = (mass or density or (0.0,))[0]
        if weight < 0 or not math.isfinite(weight):
            raise RobotError(f"{whose}: a geom has negative mass or density; no body has that")
        if weight > 0 and (geom.get("type") in ("mesh", "sdf", "hfield", "plane") or "mesh" in geom.attrib):
            raise RobotError(
                f"{whose} takes its mass from a mesh, and meshes are not weighed here; give it an <inertial>. {_REMEDY}"
            )
        if weight > 0 and geom.get("shellinertia", "false") == "true":
            raise RobotError(f"{whose}: a geom asks for the inertia of a shell, which Pinocchio does not compute. {_REMEDY}")
        yield weight
