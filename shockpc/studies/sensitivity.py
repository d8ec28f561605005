"""What would change a number of a landing most: its derivatives by every mass, inertia, joint value and the strike.

Each parameter is changed by 2^-100 in ball arithmetic, and the quantity is computed anew (`exact.derivative`): one way for every
quantity of the table and every parameter, exact to the last digit of a double.
"""

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.impulse import RowChoice
from shockpc.core.spatial import Array, read_only
from shockpc.errors import StudyError
from shockpc.exact.balls import Balls, balls
from shockpc.exact.derivative import Path, derivatives, displaced
from shockpc.exact.kinematics import data_of
from shockpc.exact.solution import BallImpact
from shockpc.landing import PosedLanding
from shockpc.model.closure import closure_block
from shockpc.model.columns import free_columns
from shockpc.model.contact import locate_lowest_point
from shockpc.model.dynamics import Dynamics, dynamics
from shockpc.model.posture import held_joints
from shockpc.model.rows import row_jacobian
from shockpc.places import Place, body_places
from shockpc.profile import shock_profile
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.table import quantity
from shockpc.result import ShockProfile
from shockpc.robot.record import Joint, Robot
from shockpc.scene import Point, Scene
from shockpc.studies.columns import Column, column
from shockpc.studies.question import refuse_ground, strike_angle
from shockpc.trace import Trace

Kind = Literal["mass", "proportion", "com", "inertia", "armature", "angle", "strike"]
"""What is changed: mass alone, mass and inertia in proportion, centre of mass, inertia, reflected inertia, joint value, strike."""

INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""The entries of an inertia by row and column; those off the diagonal stand for both of their places."""

LARGEST_STEP = {"mass": 0.1, "inertia": 1e-3, "com": 0.01}
"""Largest steps: 100 g, 0.001 kg m², 10 mm; a robot of small bodies has steps of a tenth, a hundredth or less of that."""

STEP_SHARE = {"mass": 0.2, "inertia": 0.2, "com": 0.05}
"""Largest steps as shares of the median mass and inertia of the bodies, and of the robot's length."""

ZERO = 1e-12
"""Share of its natural size below which a number is zero but for rounding."""

FASTEST_LOWEST_POINT = 1e3
"""Speed of a lowest contact point over its foot, in metres per radian, that no turning foot has: the point jumps."""


INDEPENDENT = 1e-6
"""Rate at which rows that depend on others become independent of them as a joint moves, above which they do [m/rad, 1/rad]."""


NEAR = 2.0**-20
"""Step of differences in double precision [rad, m]."""


@dataclass(frozen=True, eq=False)
class Effect:
    """The derivatives by one parameter; those that do not exist are NaN.

    Attributes:
        kind: of the parameter.
        axis: which component of it, such as "x" or "xy"; empty if there is one.
        name: body or joint; empty for the strike.
        value: present value [unit].
        unit: SI unit; "1" for a proportion.
        step: a change of the size that designers make [unit].
        derivative: of the target [its unit/unit].
        copc: (3,) derivative of the centre of percussion, body coordinates [m/unit].
        ropc: derivative of the radius of percussion [m/unit].
        reason: why there are no derivatives; empty if there are.
    """

    kind: Kind
    axis: str
    name: str
    value: float
    unit: str
    step: float
    derivative: float
    copc: Array
    ropc: float
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What changes a number of a landing, and the CoPc and RoPc of the body that it belongs to.

    Attributes:
        profile: the landing.
        target: the number.
        value: of it [its unit].
        body: the body that it belongs to; None of contacts and of the robot as a whole.
        copc: (3,) centre of percussion of the body, body coordinates [m]; NaN if it has none.
        ropc: radius of percussion [m]; inf if it has none.
        effects: of every parameter: bodies first, then joints, then the strike.
    """

    profile: ShockProfile = field(repr=False)
    target: Column
    value: float
    body: str | None
    copc: Array
    ropc: float
    effects: tuple[Effect, ...]

    @property
    def ranked(self) -> tuple[Effect, ...]:
        """The effects that exist, the step with the largest change of the target first."""
        known = (effect for effect in self.effects if not effect.reason)
        return tuple(sorted(known, key=lambda effect: -abs(effect.derivative * effect.step)))


class _Parameter(NamedTuple):
    """A parameter of a landing.

    Attributes:
        kind: as in `Effect`.
        axis: as in `Effect`.
        name: as in `Effect`.
        value: as in `Effect`.
        unit: as in `Effect`.
        path: how it changes the impact; None where it cannot change.
        reason: why it cannot.
    """

    kind: Kind
    axis: str
    name: str
    value: float
    unit: str
    path: Path | None
    reason: str = ""


def sensitivity(scene: Scene, target: str | Point, robot: Robot | None = None, trace: Trace | None = None) -> Sensitivity:
    """The derivatives of a number of a landing, and of the CoPc and RoPc of the body that it belongs to.

    Contact points stay where they are on their links; one that is the lowest point of a link moves as the link turns. Joints that
    follow others follow, and loops stay closed.

    Args:
        scene: the landing.
        target: QUANTITY@PLACE, or QUANTITY of the robot as a whole; a point means the shock there.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        UnknownName: there is no such quantity or place.
        StudyError: the number does not exist in this landing, or is zero, where a length has no derivative.
        ShockError: the landing cannot be computed.
    """
    trace = trace or Trace()
    refuse_ground(scene)
    profile = shock_profile(scene, robot, trace)
    text = f"shock@{target.label}" if isinstance(target, Point) else target
    asked = column(profile, text, lambda entry: entry.compute is not None and not entry.posed and entry.worse != "neither")
    value, size = _value(profile, asked)
    landing, body, nothing = profile.landing, asked.place.body, np.full(3, np.nan)
    copc, ropc = (profile.copc[body], float(profile.ropc[body])) if body >= 0 else (nothing, np.nan)
    parameters = [*_inertial(landing.robot), *_armatures(landing), *_joint_values(profile), *_strike(landing)]
    paths = [parameter.path for parameter in parameters if parameter.path is not None]
    sizes = np.array([size, *3 * [landing.length + np.nan_to_num(np.linalg.norm(copc))], ropc])
    with trace.stage("differences in ball arithmetic"):
        rows = iter(derivatives(profile.proof, paths, functools.partial(_outputs, asked), sizes))
    steps, effects = _steps(landing), []
    for kind, axis, name, now, unit, path, reason in parameters:
        by = np.full(5, np.nan) if path is None else next(rows)
        step = steps[kind, unit]
        effects.append(Effect(kind, axis, name, now, unit, step, float(by[0]), read_only(by[1:4]), float(by[4]), reason))
    carrier = landing.robot.bodies[body].name if body >= 0 else None
    return Sensitivity(profile, asked, value, carrier, read_only(copc), ropc, tuple(effects))


def _steps(landing: PosedLanding) -> dict[tuple[Kind, str], float]:
    """The changes that a designer of this robot thinks in, by kind and SI unit."""
    bodies = [body for body in landing.robot.bodies if body.mass > 0.0]
    natural = {
        "mass": float(np.median([body.mass for body in bodies])),
        "inertia": float(np.median([max(np.trace(body.inertia) / 3.0, 1e-30) for body in bodies])),
        "com": landing.length,
    }
    mass, inertia, com = (
        10.0 ** math.floor(math.log10(min(LARGEST_STEP[kind], STEP_SHARE[kind] * size)) + 1e-9) for kind, size in natural.items()
    )
    degree = math.radians(1.0)
    return {
        ("mass", "kg"): mass,
        ("proportion", "1"): 0.1,
        ("com", "m"): com,
        ("inertia", "kg m²"): inertia,
        ("armature", "kg m²"): inertia,
        ("armature", "kg"): mass,
        ("angle", "rad"): degree,
        ("angle", "m"): com,
        ("strike", "rad"): degree,
    }


def _value(profile: ShockProfile, asked: Column) -> tuple[float, float]:
    """The number, and its natural size.

    Raises:
        StudyError: there is none, it is computed in double precision, or it is zero.
    """
    entry = asked.selection.quantity
    value = float(asked.selection.scalar(profile.values(entry, [asked.place]))[0])
    if not math.isfinite(value):
        raise StudyError(f"there is no {asked.title} in this landing: {entry.missing or 'it is infinite'}")

    def natural_size(impact: BallImpact) -> float:
        assert entry.compute is not None
        values = entry.compute(impact, [asked.place])
        if values.dtype != object:
            raise StudyError(f"{entry.title} is computed in double precision, so it has no derivative; choose another quantity")
        return float(np.max(entry.size(impact, values.astype(float))))

    size = max(profile.proof.read(natural_size), abs(value))
    if abs(value) <= ZERO * size:
        raise StudyError(
            f"{asked.title} is zero in this landing: a length has no derivative where it is zero, and changes cannot be relative "
            "to it; name another place, or change the strike"
        )
    return value, size


def _outputs(asked: Column, impact: BallImpact) -> Balls:
    """The number, CoPc (3,) and RoPc of the body that it belongs to; NaN without one."""

    def values(entry: Quantity, place: Place) -> Balls:
        assert entry.compute is not None
        return np.asarray(entry.compute(impact, [place])[0, 0])

    parts = [asked.selection.scalar(values(asked.selection.quantity, asked.place)), np.full(4, np.nan)]
    if asked.place.body >= 0:
        body = body_places(impact.landing.robot)[asked.place.body]
        parts[1:] = [values(quantity("body", "copc"), body)[0], values(quantity("body", "ropc"), body)]
    return np.concatenate(parts)


def _inertial(robot: Robot) -> Iterator[_Parameter]:
    data, none = data_of(robot), (0.0, np.zeros(3), np.zeros((3, 3)))
    for i, (body, mass, inertia) in enumerate(zip(robot.bodies, data.mass, data.inertia, strict=True)):

        def path(*rates: Array | float, i: int = i) -> Path:
            """A change of mass, lever and inertia."""
            return lambda impact, t: impact.with_body(i, *(x + t * by for x, by in zip(impact.carried(i), rates, strict=True)))

        # As of a point at the centre of mass, and with everything in proportion.
        yield _Parameter("mass", "", body.name, body.mass, "kg", path(1.0, *none[1:]))
        yield _Parameter("proportion", "", body.name, 1.0, "1", path(mass, none[1], inertia))
        for axis, x, along in zip("xyz", body.com, body.rotation.T, strict=True):
            yield _Parameter("com", axis, body.name, float(x), "m", path(0.0, along, none[2]))
        for j, k in INERTIA_ENTRIES:
            entry = np.outer(body.rotation[:, j], body.rotation[:, k])
            by = path(*none[:2], entry if j == k else entry + entry.T)
            yield _Parameter("inertia", "xyz"[j] + "xyz"[k], body.name, float(body.inertia[j, k]), "kg m²", by)


def _armatures(landing: PosedLanding) -> Iterator[_Parameter]:
    model = landing.joint_model
    for joint, axis, unit, v in _coordinates(landing.robot):

        def path(impact: BallImpact, t: float, v: int = v) -> BallImpact:
            armature = balls(model.armature)
            armature[v] += t
            return BallImpact(replace(landing, joint_model=model._replace(armature=armature)), impact.choice)

        if not model.locked[v]:
            unit = "kg m²" if unit == "rad" else "kg"
            yield _Parameter("armature", axis, joint.name, float(model.armature[v]), unit, path)


def _strike(landing: PosedLanding) -> Iterator[_Parameter]:
    """The strike angle: the robot's velocity turns in the plane, from straight down towards forward."""
    forward, before = landing.plane.forward, landing.before
    if landing.plane.level:
        return

    def path(impact: BallImpact, t: float) -> BallImpact:
        turn = np.cross(balls(np.cross(forward, [0.0, 0.0, 1.0])), before.velocity)
        return BallImpact(replace(landing, before=before._replace(velocity=before.velocity + t * turn)), impact.choice)

    yield _Parameter("strike", "", "", strike_angle(landing), "rad", path)


def _joint_values(profile: ShockProfile) -> Iterator[_Parameter]:
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
        yield _Parameter("angle", axis, joint.name, value, unit, path, reason)


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
    held[column] = True
    for mimic in robot.mimics:
        held[robot.joint(mimic.joint).v] = True
    if not held.all():
        others = free_columns(robot, "fixed", landing.plane, rotation, held)
        if others is not None:
            rates = rates + others[0] @ np.linalg.lstsq(K @ others[0], -K @ rates, rcond=1e-10)[0]
    if np.abs(K @ rates).max() > 1e-9 * np.abs(rates).max():
        return rates, "the loops, and the joints that the posture sets, hold it"
    return rates, ""


def _coordinates(robot: Robot) -> Iterator[tuple[Joint, str, str, int]]:
    """The velocities of the joints that follow no other: joint, which of its velocities, unit of the coordinate, column."""
    followers = {mimic.joint for mimic in robot.mimics}
    for joint in robot.single_joints[robot.free_base :]:
        if joint.name not in followers:
            for axis, unit, column in zip(*AXES.get(joint.kind, ONE), range(joint.v.start, joint.v.stop), strict=True):
                yield joint, axis, joint.unit if joint.axis is not None else unit, column


ONE = ("",), ("rad",)
AXES = {
    "ball": (("x", "y", "z"), ("rad",) * 3),
    "planar": (("x", "y", "turn"), ("m", "m", "rad")),
    "free": (("x", "y", "z", "turn x", "turn y", "turn z"), ("m",) * 3 + ("rad",) * 3),
}
"""Of joints with several velocities: their names and the units of what they move."""
