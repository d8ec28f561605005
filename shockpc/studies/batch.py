"""Many robots at once: each lands on each of its feet alone, in its standing posture."""

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from shockpc.errors import refusal
from shockpc.executor import in_order
from shockpc.model.contact import Contact
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.landmarks import each_foot
from shockpc.robot.load import load_robot
from shockpc.robot.record import Robot
from shockpc.scene import Scene

__all__ = ["Batch", "BatchRow", "Failure", "Read", "batch", "landings_on_each_foot"]

Read = Callable[[str], tuple[Robot, Iterable[Scene]]]
"""From a robot's name or file to the robot and its landings."""


@dataclass(frozen=True, eq=False)
class BatchRow:
    """One landing of one robot. The trunk is the robot's heaviest body.

    Attributes:
        robot: its name in the catalogue, or its file.
        contact: what strikes; frames with + between them.
        mass: of the robot [kg].
        trunk: name of the trunk.
        ropc: radius of percussion of the trunk [m]; inf where it does not rotate in the plane.
        shock_max: greatest shock over the trunk's geometry [1]; None without geometry.
        shock_com: shock at the trunk's centre of mass, with the joints as modelled [1].
        shock_free: the same with free joints; None if it cannot be computed with them.
        shock_locked: the same with locked joints; None if it cannot be computed with them.
        joint_model: free, geared, locked or mixed.
        sensors: shock at each of the robot's sensors, and at each point of the scene [1].
        effective_mass: of the contact along the ground's normal, if it sticks [kg]; the smallest over several contacts.
        friction_needed: coefficient of friction that makes every contact stick [1]; inf where the ground would have to pull; None
            where only the sum of the impulses is determined.
        error_bound: proven error of the jumps of the bodies, relative to each body's motion, the largest over the bodies [1].
        warnings: of the landing.
        scene: what was computed, with every default filled in.
        picture: what the caller's `look` made of the profile; None without it.
    """

    robot: str
    contact: str
    mass: float
    trunk: str
    ropc: float
    shock_max: float | None
    shock_com: float
    shock_free: float | None
    shock_locked: float | None
    joint_model: str
    sensors: Mapping[str, float]
    effective_mass: float
    friction_needed: float | None
    error_bound: float
    warnings: tuple[str, ...]
    scene: Scene = field(repr=False)
    picture: Any = field(default=None, repr=False)


@dataclass(frozen=True)
class Failure:
    """A landing that could not be computed, and why.

    Attributes:
        robot: its name, or its file.
        contact: what strikes; empty if the robot or all of its landings are concerned.
        reason: what was found and what to change.
    """

    robot: str
    contact: str
    reason: str


class Batch(NamedTuple):
    """The landings of many robots.

    Attributes:
        rows: what was computed, the greatest shock of the trunk first; rows without it follow, by the shock at its centre of mass.
        failures: what could not be computed, in the order of the robots.
    """

    rows: tuple[BatchRow, ...]
    failures: tuple[Failure, ...]


def landings_on_each_foot(name: str) -> tuple[Robot, list[Scene]]:
    """A robot, and its landings on each foot alone, 1 m/s straight down in its standing posture.

    Raises:
        ShockError: the robot cannot be loaded.
    """
    robot = load_robot(name)
    return robot, [Scene(robot=name, contact=(Contact(frame=foot),)) for foot in each_foot(robot)]


def batch(
    robots: Iterable[str],
    read: Read = landings_on_each_foot,
    executor: Executor | None = None,
    look: Callable[[ShockProfile], Any] | None = None,
    done: Callable[[str], None] | None = None,
) -> Batch:
    """Compute the landings of many robots, one robot after the other or several at once.

    Args:
        robots: names and files.
        read: finds the landings of each.
        executor: computes each robot; in this process by default. Others need `read` and `look` to be picklable.
        look: makes something of each profile, such as a picture, where the profile is computed.
        done: is called with the name of each robot that is computed, in the order of `robots`.
    """
    names = list(robots)
    cases: list[BatchRow | Failure] = []
    found_of = functools.partial(_landings, read, look)
    for name, found in zip(names, in_order(executor, found_of, names), strict=True):
        cases += found
        if done is not None:
            done(name)
    rows = [case for case in cases if isinstance(case, BatchRow)]
    rows.sort(key=lambda row: (-math.inf if row.shock_max is None else row.shock_max, row.shock_com), reverse=True)
    return Batch(tuple(rows), tuple(case for case in cases if isinstance(case, Failure)))


def _landings(read: Read, look: Callable[[ShockProfile], Any] | None, name: str) -> list[BatchRow | Failure]:
    """All landings of one robot."""
    try:
        robot, scenes = read(name)
    except Exception as error:
        return [Failure(name, "", str(refusal(error)))]
    cases: list[BatchRow | Failure] = []
    for scene in scenes:
        try:
            cases.append(_row(shock_profile(scene, robot), look))
        except Exception as error:
            cases.append(Failure(name, _contact(scene), str(refusal(error))))
    return cases


def _row(profile: ShockProfile, look: Callable[[ShockProfile], Any] | None) -> BatchRow:
    """What a profile says in short."""
    trunk = int(np.argmax(profile.robot.masses))
    bracket = profile.bracket[0]
    greatest = float(profile.shock_max[trunk])
    return BatchRow(
        robot=profile.robot.label,
        contact=_contact(profile.scene),
        mass=profile.robot.mass,
        trunk=profile.bodies[trunk],
        ropc=float(profile.ropc[trunk]),
        shock_max=greatest if math.isfinite(greatest) else None,
        shock_com=float(profile.shock_com[trunk]),
        shock_free=bracket.free,
        shock_locked=bracket.locked,
        joint_model=profile.joint_model,
        sensors={point.frame: point.shock for point in profile.points},
        effective_mass=min(contact.mass_sticking for contact in profile.contacts),
        friction_needed=_friction(profile),
        error_bound=float(profile.health.error_bound),
        warnings=tuple(str(warning) for warning in profile.health.warnings),
        scene=profile.scene,
        picture=None if look is None else look(profile),
    )


def _friction(profile: ShockProfile) -> float | None:
    """The greatest friction needed over the contacts."""
    if any(contact.impulse is None for contact in profile.contacts):
        return None
    return max(math.inf if contact.friction_needed is None else contact.friction_needed for contact in profile.contacts)


def _contact(scene: Scene) -> str:
    """What strikes."""
    return "+".join(contact.frame for contact in scene.contact)
