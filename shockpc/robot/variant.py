"""A robot with some masses, centres of mass, inertias or reflected inertias changed; all else is shared with the original."""

import fnmatch
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import read_only
from shockpc.errors import StudyError, UnknownName
from shockpc.robot.inertias import refuse_extremes
from shockpc.robot.robot import Body, Robot

__all__ = ["Change", "Property", "changed", "read_changes"]

Property = Literal["mass", "inertia", "com-x", "com-y", "com-z", "armature"]
"""What can be changed."""

EXAMPLE = "mass:*_shank=0.9x; com-z:trunk=-0.02; armature:*=0.01"


@dataclass(frozen=True)
class Change:
    """One change of a robot.

    Attributes:
        what: mass of a body, with its inertia in proportion and its centre of mass where it was [kg]; inertia of a body about its
            centre of mass; position of the centre of mass in the body's frame along x, y or z [m]; armature of a joint, its
            reflected inertia [kg m²; kg for a prismatic joint].
        pattern: name or glob of bodies, for armature of joints.
        value: the new value, or what the present one is multiplied by; for the centre of mass, how far it moves.
        factor: whether the present value is multiplied.
    """

    what: Property
    pattern: str
    value: float
    factor: bool

    def __post_init__(self) -> None:
        """Refuse values that no body and no joint has.

        Raises:
            StudyError: the value is not finite, not above zero, or not of the kind that the property takes.
        """
        text, com = f"change {self}", self.what.startswith("com")
        if not math.isfinite(self.value):
            raise StudyError(f"{text}: the value has to be a finite number")
        if com and self.factor:
            raise StudyError(
                f"{text}: a centre of mass is moved by metres, not by a factor; give for example {self.what}:trunk=0.02"
            )
        if self.what == "inertia" and not self.factor:
            raise StudyError(
                f"{text}: an inertia has six entries, so it is changed by a factor; give for example inertia:trunk=1.1x"
            )
        if (self.value < 0.0 and not com) or (self.value == 0.0 and self.what == "inertia"):
            raise StudyError(f"{text}: the value may not be below zero, and a factor of an inertia has to be above zero")

    def __str__(self) -> str:
        return f"{self.what}:{self.pattern}={self.value:g}{'x' * self.factor}"


def read_changes(text: str) -> tuple[Change, ...]:
    """Changes as they are typed, such as "mass:thigh=0.9x; armature:*=0.01"; x after a number makes it a factor.

    Raises:
        StudyError: it is not of that form.
    """
    found = []
    for part in filter(None, map(str.strip, text.split(";"))):
        what, colon, rest = part.partition(":")
        pattern, equals, number = (piece.strip() for piece in rest.rpartition("="))
        factor = number.endswith("x")
        try:
            value = float(number.removesuffix("x"))
        except ValueError:
            value = math.nan
        kind = next((kind for kind in get_args(Property) if kind == what.strip()), None)
        if kind is None or not (colon and equals and pattern) or math.isnan(value):
            kinds = ", ".join(get_args(Property))
            raise StudyError(
                f'"{part}" is not a change PROPERTY:NAME=VALUE or PROPERTY:NAME=FACTORx, such as {EXAMPLE}; properties are {kinds}'
            )
        found.append(Change(kind, pattern, value, factor))
    if not found:
        raise StudyError(f'"{text}" holds no change; give for example {EXAMPLE}')
    return tuple(found)


def changed(robot: Robot, changes: Iterable[Change]) -> Robot:
    """The robot with changes applied one after the other; the original stays as it is, and geometry that is read is shared.

    Raises:
        UnknownName: a pattern matches no body, or no joint.
        StudyError: a mass is set for a body that has none, whose inertia could not be scaled.
        RobotError: a body becomes too heavy or too light to compute with.
    """
    model = robot.model.copy()
    armature, bodies = np.array(model.armature), list(robot.bodies)
    for change in changes:
        if change.what == "armature":
            for name in robot.match_joints(change.pattern):
                columns = robot.joint(name).v
                armature[columns] = armature[columns] * change.value if change.factor else change.value
            continue
        for i in _matching(robot, change):
            own = _changed(bodies[i], model.inertias[bodies[i].joint], change)
            model.inertias[bodies[i].joint] = own
            seen = pin.SE3(bodies[i].rotation, bodies[i].offset).actInv(own)
            com, inertia = read_only(seen.lever), read_only(seen.inertia)
            bodies[i] = replace(bodies[i], mass=float(own.mass), com=com, inertia=inertia)
    refuse_extremes(robot.source.path.name, [(body.name, body.mass, body.inertia) for body in bodies])
    model.armature = armature
    return replace(robot, model=model, bodies=tuple(bodies), mass=sum(body.mass for body in bodies))


def _matching(robot: Robot, change: Change) -> list[int]:
    """The bodies that a change is about.

    Raises:
        UnknownName: there are none; a link that is fixed to another body has no mass of its own here.
    """
    names = [body.name for body in robot.bodies]
    found = [i for i, name in enumerate(names) if name == change.pattern or fnmatch.fnmatchcase(name, change.pattern)]
    if found:
        return found
    carrier = next((body.name for body in robot.bodies if change.pattern in body.links), None)
    if carrier is not None:
        raise StudyError(
            f'change {change}: link "{change.pattern}" is fixed to body "{carrier}" and moves as one with it; change that body'
        )
    raise UnknownName("body", change.pattern, names, f'robot "{robot.name}"', f"shockpc robots {robot.label}")


def _changed(body: Body, own: pin.Inertia, change: Change) -> pin.Inertia:
    """The inertia of a body in its joint's frame after a change."""
    if change.what == "inertia":
        return pin.Inertia(own.mass, own.lever, own.inertia * change.value)
    if change.what == "mass":
        if not change.factor and not own.mass > 0.0:
            raise StudyError(
                f'change {change}: body "{body.name}" has no mass, so its inertia cannot follow; correct the file instead'
            )
        factor = change.value if change.factor else change.value / own.mass
        mass = own.mass * change.value if change.factor else change.value
        return pin.Inertia(mass, own.lever, own.inertia * factor)
    step = np.zeros(3)
    step["xyz".index(change.what[-1])] = change.value
    return pin.Inertia(own.mass, own.lever + body.rotation @ step, own.inertia)
