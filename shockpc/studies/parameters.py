"""What can be changed in a landing: masses, inertias, joint values and the strike, each as a path of impacts in ball arithmetic."""

import functools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array
from shockpc.impact.exact.balls import balls
from shockpc.impact.exact.derivative import Path, displaced
from shockpc.impact.exact.kinematics import data_of
from shockpc.impact.exact.solution import BallImpact
from shockpc.landing.closure import closure_block
from shockpc.landing.contact import locate_lowest_point
from shockpc.landing.dynamics import Dynamics, dynamics
from shockpc.landing.freedom import free_columns
from shockpc.landing.landing import PosedLanding
from shockpc.landing.motion import Motion
from shockpc.landing.posture import held_joints
from shockpc.landing.rows import row_jacobian
from shockpc.quantities.profile import ShockProfile
from shockpc.robot.changes import Property, links_with_mass, varied_bodies, with_inertias
from shockpc.robot.robot import Joint, Robot

Kind = Literal["mass", "proportion", "com", "inertia", "armature", "angle", "strike"]
"""What is changed: mass alone, mass and inertia in proportion, centre of mass, inertia, reflected inertia, joint value, strike."""

INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""The entries of an inertia by row and column; those off the diagonal stand for both of their places."""

FASTEST_LOWEST_POINT = 1e3
"""Speed of a lowest contact point over its foot, in metres per radian, that no turning foot has: the point jumps."""

INDEPENDENT = 1e-6
"""Rate at which rows that depend on others become independent of them as a joint moves, above which they do [m/rad, 1/rad]."""

NEAR = 2.0**-20
"""Step of differences in double precision [rad, m]."""


class Parameter(NamedTuple):
    """A parameter of a landing.

    Attributes:
        kind: of the parameter.
        axis: which component of it, such as "x" or "xy"; empty if there is one.
        name: body or joint; empty for the strike.
        value: present value [unit].
        unit: SI unit; "1" for a proportion.
        size: what a change is compared with: the mass, the mean moment of inertia and the radius of gyration of the body, the
            reflected inertia of the joint (without one, the inertia that the joint moves), a radian, or the robot's length [unit].
        path: how it changes the impact; None where it cannot change.
        reason: why it cannot.
    """

    kind: Kind
    axis: str
    name: str
    value: float
    unit: str
    size: float
    path: Path | None
    reason: str = ""


def parameters(profile: ShockProfile) -> list[Parameter]:
    """All parameters of a landing: bodies first, then joints, then the strike."""
    landing = profile.landing
    return [*_inertial(landing.robot), *_armatures(landing), *_joint_values(profile), *_strike(landing)]


def in_doubles(impact: BallImpact) -> PosedLanding:
    """The landing, in double precision, of an impact that a path gives."""
    landing, model = impact.landing, impact.landing.joint_model
    carried = [[part.astype(float) for part in map(np.asarray, impact.carried(i))] for i in range(len(landing.robot.bodies))]
    robot = with_inertias(landing.robot, *map(np.array, zip(*carried, strict=True)))
    q, armature = landing.q.astype(float), model.armature.astype(float)
    contacts = tuple(block._replace(point=block.point.astype(float)) for block in landing.contacts)
    before = Motion(*(part.astype(float) for part in landing.before))
    return replace(
        landing, robot=robot, joint_model=model._replace(armature=armature), contacts=contacts, before=before, q=q,
        state=dynamics(robot, q[None], armature),
    )  # fmt: skip


def link_parameters(robot: Robot, what: Property, pattern: str, factor: bool) -> Iterator[Parameter]:
    """Mass, inertia or centre of mass of all links that a pattern means, changed together as in `robot.changes.Change`.

    Args:
        robot: the robot.
        what: is changed.
        pattern: name or glob of links.
        factor: whether it is multiplied; its unit is then "1".

    Returns: the part of each body; the effect is the sum of theirs.
    """
    links = links_with_mass(robot, pattern)
    moved, h = what.startswith("com"), 1e-5
    about = {link: 0.0 if moved else 1.0 if factor else mass for link, mass in links.items()}
    # The bodies' inertias are smooth functions of each value, so that about ten digits of their differences are left.
    near = [(what, link, np.array([value + h, value - h]), factor) for link, value in about.items()]
    mass, com, inertia = ((two[0] - two[1]) / (2.0 * h) for two in varied_bodies(robot, near))
    kind: Kind = "com" if moved else "inertia" if what == "inertia" else "proportion"
    unit = "1" if factor else "m" if moved else "kg"
    for i in sorted({robot.frames[link].body for link in links}):
        R = robot.bodies[i].rotation
        path = _inertial_path(i, mass[i], R @ com[i], R @ inertia[i] @ R.T)
        axis, name = what[-1] if moved else "", f"{pattern} on {robot.bodies[i].name}"
        size = 1.0 if factor else float(robot.gyration[i] if moved else robot.masses[i])
        yield Parameter(kind, axis, name, math.nan, unit, size, path)


def _inertial_path(body: int, *rates: Array | float) -> Path:
    """A change of mass, lever and inertia of a body."""
    return lambda impact, t: impact.with_body(body, *(x + t * by for x, by in zip(impact.carried(body), rates, strict=True)))


def _inertial(robot: Robot) -> Iterator[Parameter]:
    data, none = data_of(robot), (0.0, np.zeros(3), np.zeros((3, 3)))
    for i, (body, mass, inertia) in enumerate(zip(robot.bodies, data.mass, data.inertia, strict=True)):
        path = functools.partial(_inertial_path, i)
        # As of a point at the centre of mass, and with everything in proportion.
        yield Parameter("mass", "", body.name, body.mass, "kg", body.mass, path(1.0, *none[1:]))
        yield Parameter("proportion", "", body.name, 1.0, "1", 1.0, path(mass, none[1], inertia))
        for axis, x, along in zip("xyz", body.com, body.rotation.T, strict=True):
            yield Parameter("com", axis, body.name, float(x), "m", float(robot.gyration[i]), path(0.0, along, none[2]))
        for j, k in INERTIA_ENTRIES:
            entry = np.outer(body.rotation[:, j], body.rotation[:, k])
            by = path(*none[:2], entry if j == k else entry + entry.T)
            mean = float(np.trace(body.inertia)) / 3.0
            yield Parameter("inertia", "xyz"[j] + "xyz"[k], body.name, float(body.inertia[j, k]), "kg m²", mean, by)


def _armatures(landing: PosedLanding) -> Iterator[Parameter]:
    model, moved = landing.joint_model, np.diag(landing.state.H[0])
    for joint, axis, unit, v in _coordinates(landing.robot):

        def path(impact: BallImpact, t: float, v: int = v) -> BallImpact:
            armature = balls(model.armature)
            armature[v] += t
            return BallImpact(replace(landing, joint_model=model._replace(armature=armature)), impact.choice)

        if not model.locked[v]:
            unit, value = "kg m²" if unit == "rad" else "kg", float(model.armature[v])
            yield Parameter("armature", axis, joint.name, value, unit, value or float(moved[v]), path)


def _strike(landing: PosedLanding) -> Iterator[Parameter]:
    """The strike angle: the robot's velocity turns in the plane, from straight down towards forward."""
    forward, before = landing.plane.forward, landing.before
    if landing.plane.level:
        return

    def path(impact: BallImpact, t: float) -> BallImpact:
        turn = np.cross(balls(np.cross(forward, [0.0, 0.0, 1.0])), before.velocity)
        return BallImpact(replace(landing, before=before._replace(velocity=before.velocity + t * turn)), impact.choice)

    yield Parameter("strike", "", "", landing.strike_angle, "rad", 1.0, path)


def _joint_values(profile: ShockProfile) -> Iterator[Parameter]:
    landing = profile.landing
    for joint, axis, unit, v in _coordinates(landing.robot):
        rates, reason = _rates(landing, v)
        path = None if reason else _path(landing, rates)
        if path is None:
            reason = reason or "the lowest point of a contact jumps here"
        elif profile.redundant and _become_independent(landing, profile.choice, rates):
            path, reason = None, "contacts or loops depend on one another at this value alone, so that the impact jumps here"
        # A rotation about several axes has no value, and counts from where it is.
        part = next((part for part in joint.parts if part.v.start == v), joint)
        value = part.value(landing.q) if part.axis is not None else 0.0
        yield Parameter("angle", axis, joint.name, value, unit, 1.0 if unit == "rad" else landing.length, path, reason)


def _beside(landing: PosedLanding, rates: Array) -> Dynamics:
    """The robot in two postures (N = 2) beside that of a landing, `NEAR` along and against some joint rates."""
    Q = np.stack([displaced(landing.robot, landing.q, rates, t).astype(float) for t in (NEAR, -NEAR)])
    return dynamics(landing.robot, Q, landing.joint_model.armature)


def _become_independent(landing: PosedLanding, choice: RowChoice, rates: Array) -> bool:
    """Whether rows that depend on others do so in this posture alone: beside it they hold motions that the others allow."""
    J, (after, before) = landing.equation(landing.state).J_c[0], landing.equation(_beside(landing, rates)).J_c
    rows, change = choice.rows, (after - before) / (2.0 * NEAR)
    allowed = np.linalg.svd(J[rows])[2][len(rows) :].T
    # J = J J⁺ J of the rows, so that on the motions that these allow the change of all rows has to be the same product of theirs.
    return bool(np.abs((change - J @ np.linalg.pinv(J[rows]) @ change[rows]) @ allowed).max(initial=0.0) > INDEPENDENT)


def _path(landing: PosedLanding, rates: Array) -> Path | None:
    """The impact as joints move; None where the lowest point of a contact jumps."""
    robot = landing.robot
    lowest = [k for k, contact in enumerate(landing.contacts) if contact.lowest]
    speeds: dict[int, Array] = {}
    if lowest:
        # What is lowest is found in double precision, so the speed of that point over its link is known to ten digits.
        state = _beside(landing, rates)
        for k in lowest:
            after, before = locate_lowest_point(landing.contacts[k], state.rotation[:, landing.contacts[k].body]).point
            speeds[k] = (after - before) / (2.0 * NEAR)
            if np.abs(speeds[k]).max() > FASTEST_LOWEST_POINT:
                return None

    def path(impact: BallImpact, t: float) -> BallImpact:
        contacts = tuple(
            block._replace(point=balls(block.point) + balls(t * speeds[k]), lowest=()) if k in speeds else block
            for k, block in enumerate(landing.blocks[: len(landing.contacts)])
        )
        return BallImpact(replace(landing, q=displaced(robot, landing.q, rates, t), contacts=contacts), impact.choice)

    return path


def _rates(landing: PosedLanding, column: int) -> tuple[Array, str]:
    """The rates (nv,) of all joints when one moves at unit rate: followers follow, and loops stay closed by the least motion.

    Returns: the rates, and why there are none.
    """
    robot, state = landing.robot, landing.state
    only = np.ones(robot.model.nv, dtype=bool)
    only[column] = False
    rotation = state.rotation[:, 0]
    G = free_columns(robot, "fixed", landing.plane, rotation, only)
    rates = np.ones(1) if G is None else G[0, :, 0]
    if not landing.loops:
        return rates, ""
    if landing.before.joint_rates.any():
        return rates, "the loops tie the joints that move before the impact, and how fast they move depends on the posture"
    K = row_jacobian(state, [closure_block(loop) for loop in landing.loops])[0]
    held = held_joints(robot, landing.scene.posture, landing.scene.assemble)
    held |= robot.velocities(robot.followers)
    held[column] = True
    if not held.all():
        others = free_columns(robot, "fixed", landing.plane, rotation, held)
        if others is not None:
            rates = rates + others[0] @ np.linalg.lstsq(K @ others[0], -K @ rates, rcond=1e-10)[0]
    if np.abs(K @ rates).max() > 1e-9 * np.abs(rates).max():
        return rates, "the loops, and the joints that the posture sets, hold it"
    return rates, ""


def _coordinates(robot: Robot) -> Iterator[tuple[Joint, str, str, int]]:
    """The velocities of the joints that follow no other: joint, which of its velocities, unit of the coordinate, column."""
    for joint in robot.single_joints[robot.free_base :]:
        if joint.name not in robot.followers:
            for axis, unit, column in zip(*AXES.get(joint.kind, ONE), range(joint.v.start, joint.v.stop), strict=True):
                yield joint, axis, joint.unit if joint.axis is not None else unit, column


ONE = ("",), ("rad",)
AXES = {
    "ball": (("x", "y", "z"), ("rad",) * 3),
    "planar": (("x", "y", "turn"), ("m", "m", "rad")),
    "free": (("x", "y", "z", "turn x", "turn y", "turn z"), ("m",) * 3 + ("rad",) * 3),
}
"""Of joints with several velocities: their names and the units of what they move."""
