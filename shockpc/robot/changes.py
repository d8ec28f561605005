"""Changes of a robot as they are typed: of the mass, centre of mass and inertia of links, and of reflected inertias of joints."""

import fnmatch
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import pinocchio as pin

from shockpc.errors import RobotError, StudyError, UnknownName
from shockpc.robot.limits import refuse_number
from shockpc.robot.record import Robot

__all__ = ["Change", "Property", "changed", "link_mass", "read_changes"]

Property = Literal["mass", "inertia", "com-x", "com-y", "com-z", "armature"]
"""What can be changed."""

EXAMPLE = "mass:*_shank=0.9x; com-z:trunk=-0.02; armature:*=0.01"


@dataclass(frozen=True)
class Change:
    """One change of a robot.

    Attributes:
        what: mass of a link, with its inertia in proportion and its centre of mass where it was [kg]; inertia of a link about its
            centre of mass; position of the centre of mass along x, y or z of the link's frame [m]; armature of a joint, its
            reflected inertia [kg m²; kg for a prismatic joint].
        pattern: name or glob of links, for armature of joints.
        value: the new value, or what the present one is multiplied by; for the centre of mass, how far it moves.
        factor: whether the present value is multiplied.
    """

    what: Property
    pattern: str
    value: float
    factor: bool

    def __post_init__(self) -> None:
        """Refuse values that no link and no joint has.

        Raises:
            StudyError: the value is not finite, not above zero, or not of the kind that the property takes.
        """
        what, com = self.what, self.what.startswith("com")
        faults = {
            "the value has to be a finite number": not math.isfinite(self.value),
            f"a centre of mass is moved by metres, not by a factor; give for example {what}:trunk=0.02": com and self.factor,
            "an inertia has six entries, so it is changed by a factor; give for example inertia:trunk=1.1x": (
                what == "inertia" and not self.factor
            ),
            "the value may not be below zero, and a factor of an inertia has to be above zero": (
                (self.value < 0.0 and not com) or (self.value == 0.0 and what == "inertia")
            ),
        }
        for message, wrong in faults.items():
            if wrong:
                raise StudyError(f"change {self}: {message}")

    def __str__(self) -> str:
        return f"{self.what}:{self.pattern}={self.value:g}{'x' * self.factor}"


def read_changes(text: str) -> tuple[Change, ...]:
    """Changes as they are typed, such as "mass:thigh=0.9x; armature:*=0.01"; x after a number makes it a factor.

    Raises:
        StudyError: it is not of that form.
    """
    changes = []
    for part in filter(None, map(str.strip, text.split(";"))):
        written, colon, rest = part.partition(":")
        pattern, equals, number = (piece.strip() for piece in rest.rpartition("="))
        factor = number.endswith("x")
        try:
            value = float(number.removesuffix("x"))
        except ValueError:
            value = math.nan
        kind = next((kind for kind in get_args(Property) if kind == written.strip()), None)
        if kind is None or not (colon and equals and pattern) or math.isnan(value):
            kinds = ", ".join(get_args(Property))
            raise StudyError(
                f'"{part}" is not a change PROPERTY:NAME=VALUE or PROPERTY:NAME=FACTORx, such as {EXAMPLE}; properties are {kinds}'
            )
        changes.append(Change(kind, pattern, value, factor))
    if not changes:
        raise StudyError(f'"{text}" holds no change; give for example {EXAMPLE}')
    return tuple(changes)


def changed(robot: Robot, changes: Iterable[Change]) -> Robot:
    """The robot with changes applied one after the other; the original stays as it is, and geometry that is read is shared.

    Raises:
        UnknownName: a pattern matches no link, or no joint.
        StudyError: a reflected inertia of zero is multiplied.
        RobotError: a link does not move or has no mass, or a body becomes too heavy or too light to compute with.
    """
    model = pin.Model(robot.model)
    for change in changes:
        if change.what == "armature":
            _change_armature(robot, model, change)
            continue
        known = robot.links
        names = [change.pattern] if change.pattern in known else fnmatch.filter(known, change.pattern)
        if names != [change.pattern]:  # a glob means the links that have mass
            names = [name for name in names if model.frames[_link(robot, name)].inertia.mass > 0.0]
        if not names:
            raise UnknownName("link with mass", change.pattern, known, f'robot "{robot.name}"', f"shockpc robots {robot.label}")
        for name in names:
            _change_link(robot, model, name, change)
    result = replace(robot, model=model)
    for body in result.bodies:
        for what, value, unit in (("mass", body.mass, "kg"), ("inertia", float(np.abs(body.inertia).max()), "kg m²")):
            refuse_number(f'{robot.source.path.name}: body "{body.name}"', what, value, unit)
    return result


def _change_armature(robot: Robot, model: pin.Model, change: Change) -> None:
    """Change the reflected inertia of some joints."""
    chosen = np.concatenate([np.arange(model.nv)[robot.joint(name).v] for name in robot.match_joints(change.pattern)])
    if change.factor and not model.armature[chosen].any():
        reason = f'the file of robot "{robot.name}" gives these joints no reflected inertia'
        raise StudyError(f"change {change} has no effect, because {reason}; give a number, such as armature:{change.pattern}=0.01")
    model.armature[chosen] = model.armature[chosen] * change.value if change.factor else change.value


def _change_link(robot: Robot, model: pin.Model, link: str, change: Change) -> None:
    """Change one link, and with it the body that it belongs to."""
    frame = model.frames[_link(robot, link)]
    inertia = frame.inertia.copy()
    if not inertia.mass > 0.0:
        raise RobotError(
            f'link "{link}" of robot "{robot.name}" has no mass, so its inertia cannot be varied; name a link with mass'
        )
    if change.what == "mass":
        factor = change.value if change.factor else change.value / inertia.mass
        inertia.mass, inertia.inertia = inertia.mass * factor, inertia.inertia * factor
    elif change.what == "inertia":
        inertia.inertia = inertia.inertia * change.value
    else:
        inertia.lever = inertia.lever + change.value * np.eye(3)["xyz".index(change.what[-1])]
    frame.inertia = inertia
    whole = pin.Inertia.Zero()
    for part in model.frames:
        if part.parentJoint == frame.parentJoint and (part.type == pin.FrameType.BODY or part.inertia.mass):
            whole += part.placement.act(part.inertia)
    model.inertias[frame.parentJoint] = whole


def link_mass(robot: Robot, link: str) -> float:
    """Mass of a link [kg], without that of the links that are fixed to it.

    Raises:
        UnknownName: the robot has no such link.
        RobotError: the link does not move.
    """
    return float(robot.model.frames[_link(robot, link)].inertia.mass)


def _link(robot: Robot, name: str) -> int:
    """The frame of a link that moves, in the Pinocchio model, which keeps the inertia of the link alone with it."""
    frame = robot.frame(name)
    if frame.kind != "link":
        raise RobotError(f'"{name}" of robot "{robot.name}" is a {frame.kind}, which has no mass; name a link')
    if frame.body < 0:
        raise RobotError(f'link "{name}" of robot "{robot.name}" is fixed to the world, so its mass does not matter')
    return int(robot.model.getFrameId(name, pin.FrameType.BODY))
