"""What would change the shock at a point most: its derivatives with respect to every mass, inertia, joint angle and the strike.

When the inertia changes, the jump of a body changes by C dΔq̇ = −Uᵀ dH Δq̇, where the columns of U are the jumps that unit impulses
on the body cause while the contacts hold. H Δq̇ is linear in the inertial parameters, so one factorisation and one regressor give
the derivatives with respect to all of them. A joint angle changes H and the rows alike; its derivatives are central differences in
ball arithmetic, exact to the last digit. The jump is linear in the velocity of the strike, so the strike angle needs a product.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.percussion import norm, percussion
from shockpc.core.spatial import Array, read_only, velocity_at
from shockpc.errors import StudyError
from shockpc.exact.balls import Balls, balls
from shockpc.exact.derivative import derivatives, displaced
from shockpc.exact.proof import round_velocities
from shockpc.exact.solution import BallImpact
from shockpc.landing import PosedLanding
from shockpc.model.closure import closure_block
from shockpc.model.columns import free_columns
from shockpc.model.contact import locate_lowest_point
from shockpc.model.dynamics import dynamics
from shockpc.model.motion import com_velocity, twist_before
from shockpc.model.posture import held_joints
from shockpc.model.regressor import INERTIA_ENTRIES, inertia_regressor, parameter_directions
from shockpc.model.rows import row_jacobian
from shockpc.places import Place
from shockpc.profile import shock_profile
from shockpc.result import ShockProfile
from shockpc.robot.record import Joint, Robot
from shockpc.scene import Point, Scene
from shockpc.studies.question import moving_point, strike_angle
from shockpc.trace import Trace

__all__ = ["Effect", "Kind", "ShockSensitivity", "sensitivity"]

Kind = Literal["mass", "proportion", "com", "inertia", "armature", "angle", "strike"]
"""What is changed: mass alone, mass and inertia in proportion, centre of mass, inertia, reflected inertia, joint value, strike."""

LARGEST = {"mass": 0.1, "inertia": 1e-3, "com": 0.01}
"""Largest steps: 100 g, 0.001 kg m², 10 mm; a robot of small bodies has steps of a tenth, a hundredth or less of that."""

NATURAL = {"mass": 0.2, "inertia": 0.2, "com": 0.05}
"""Largest steps as shares of the median mass and inertia of the bodies, and of the robot's length."""

STILL = 1e-12
"""Shock that is zero but for rounding."""

JUMPS = 1e3
"""Speed of a lowest contact point over its foot, in metres per radian, that no turning foot has: the point jumps."""


@dataclass(frozen=True, eq=False)
class Effect:
    """The derivatives with respect to one quantity; those that do not exist are NaN.

    Attributes:
        kind: of the quantity.
        axis: which component of it, such as "x" or "xy"; empty if there is one.
        name: body or joint; empty for the strike.
        value: present value [unit].
        unit: SI unit; "1" for a proportion.
        step: a change of the size that designers make [unit].
        shock: derivative of the shock [1/unit].
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
    shock: float
    copc: Array
    ropc: float
    reason: str = ""


@dataclass(frozen=True, eq=False)
class ShockSensitivity:
    """What changes the shock at a point, and the CoPc and RoPc of its body.

    Attributes:
        profile: the landing.
        point: label of the point.
        body: the body it is fixed to.
        shock: |Δv| / v_in there [1].
        copc: (3,) centre of percussion of the body, body coordinates [m]; NaN if it has none.
        ropc: radius of percussion [m]; inf if it has none.
        effects: of every quantity: bodies first, then joints, then the strike.
    """

    profile: ShockProfile = field(repr=False)
    point: str
    body: str
    shock: float
    copc: Array
    ropc: float
    effects: tuple[Effect, ...]

    @property
    def ranked(self) -> tuple[Effect, ...]:
        """The effects that exist, the step with the largest change of the shock first."""
        known = (effect for effect in self.effects if not effect.reason)
        return tuple(sorted(known, key=lambda effect: -abs(effect.shock * effect.step)))


class _Place(NamedTuple):
    """The point in the landing's posture, for the chain rule; body axes.

    Attributes:
        point: the point.
        body: index of its body.
        omega: (3,) jump of the body's angular velocity [rad/s].
        v: (3,) jump of the velocity of its frame's origin [m/s].
        normal: (3,) of the plane.
        v_in: [m/s].
        translates: whether the body has no centre of percussion.
        steps: of every kind and unit.
    """

    point: Place
    body: int
    omega: Array
    v: Array
    normal: Array
    v_in: float
    translates: bool
    steps: dict[tuple[Kind, str], float]

    def effect(self, kind: Kind, axis: str, name: str, value: float, unit: str, changes: Array, reason: str = "") -> Effect:
        """An effect from its derivatives (5,)."""
        shock, copc, ropc = float(changes[0]), read_only(changes[1:4]), float(changes[4])
        return Effect(kind, axis, name, value, unit, self.steps[kind, unit], shock, copc, ropc, reason)

    def changes(self, d_jump: Array, d_speed: Array) -> Array:
        """Derivatives (k, 5) of shock, CoPc and RoPc. Args: d_jump (6, k) of (Δω, Δv); d_speed (k,) of v_in."""
        d_omega, d_v = d_jump[:3].T, d_jump[3:].T
        velocity = velocity_at(self.omega, self.v, self.point.r)
        speed = float(np.linalg.norm(velocity))
        d_speed = d_speed / self.v_in
        shock = velocity_at(d_omega, d_v, self.point.r) @ velocity / (speed * self.v_in) - speed / self.v_in * d_speed
        if self.translates:
            return np.column_stack([shock, np.full((len(shock), 4), np.nan)])
        turn = float(self.normal @ self.omega)
        share = d_omega @ self.normal / turn
        copc = np.cross(self.normal, d_v) / turn - np.outer(share, np.cross(self.normal, self.v) / turn)
        return np.column_stack([shock, copc, self.v_in / abs(turn) * (d_speed - share)])


def sensitivity(scene: Scene, at: Point, robot: Robot | None = None, trace: Trace | None = None) -> ShockSensitivity:
    """The derivatives of the shock at a point, and of the CoPc and RoPc of its body.

    Contact points stay where they are on their links; one that is the lowest point of a link moves as the link turns. Joints that
    follow others follow, and loops stay closed.

    Args:
        scene: the landing.
        at: the point.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost.

    Raises:
        StudyError: the point is fixed to the world, or sees no shock, so that |Δv| has no derivative.
        ShockError: the landing cannot be computed.
    """
    trace = trace or Trace()
    profile = shock_profile(scene, robot, trace)
    landing, robot = profile.landing, profile.robot
    point = moving_point(robot, at)
    body = point.body
    place = _Place(
        point,
        body,
        profile.delta_omega[body],
        profile.delta_v[body],
        landing.plane.normal @ profile.rotation[body],
        profile.v_in,
        bool(profile.translates[body]),
        _steps(landing),
    )
    velocity = velocity_at(place.omega, place.v, point.r)
    shock = float(np.linalg.norm(velocity)) / profile.v_in
    if shock <= STILL:
        raise StudyError(
            f'point "{point.name}" sees no shock in this landing, and a length has no derivative where it is zero; '
            "name another point, or change the strike"
        )
    with trace.stage("masses and inertias: regressor"):
        effects = [*_inertial(profile, place)]
    with trace.stage("joint angles: central differences in ball arithmetic"):
        effects += _angles(profile, place)
    effects += _strike(profile, place)
    return ShockSensitivity(
        profile,
        point.name,
        robot.bodies[body].name,
        shock,
        read_only(profile.copc[body]),
        float(profile.ropc[body]),
        tuple(effects),
    )


def _steps(landing: PosedLanding) -> dict[tuple[Kind, str], float]:
    """The changes that a designer of this robot thinks in, by kind and SI unit."""
    bodies = [body for body in landing.robot.bodies if body.mass > 0.0]
    natural = {
        "mass": float(np.median([body.mass for body in bodies])),
        "inertia": float(np.median([max(np.trace(body.inertia) / 3.0, 1e-30) for body in bodies])),
        "com": landing.length,
    }
    mass, inertia, com = (
        10.0 ** math.floor(math.log10(min(LARGEST[kind], NATURAL[kind] * size)) + 1e-9) for kind, size in natural.items()
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


def _inertial(profile: ShockProfile, place: _Place) -> Iterator[Effect]:
    """Masses, centres of mass and inertias of the bodies, then the armature of the joints that are not locked."""
    landing, robot = profile.landing, profile.robot
    U = profile.proof.read(lambda impact: round_velocities(impact.held_velocities(place.body)))
    jumps = -np.einsum("vk,vbp->bkp", U, inertia_regressor(robot, landing.q, profile.delta_qd))
    speeds = _speed_by_mass(landing)
    for i, body in enumerate(robot.bodies):
        directions = parameter_directions(robot, i)
        changes = place.changes(jumps[i] @ directions, speeds[i] @ directions)
        kinds: list[tuple[Kind, str, float, str]] = [("mass", "", body.mass, "kg"), ("proportion", "", 1.0, "1")]
        kinds += [("com", axis, float(x), "m") for axis, x in zip("xyz", body.com, strict=True)]
        kinds += [("inertia", "xyz"[j] + "xyz"[k], float(body.inertia[j, k]), "kg m²") for j, k in INERTIA_ENTRIES]
        for (kind, axis, value, unit), found in zip(kinds, changes, strict=True):
            yield place.effect(kind, axis, body.name, value, unit, found)
    changes = place.changes(-U.T * profile.delta_qd, np.zeros(robot.model.nv))
    for joint, axis, unit, column in _coordinates(robot):
        if not landing.joint_model.locked[column]:
            unit = "kg m²" if unit == "rad" else "kg"
            yield place.effect("armature", axis, joint.name, float(landing.joint_model.armature[column]), unit, changes[column])


def _speed_by_mass(landing: PosedLanding) -> Array:
    """Derivatives (nb, 10) of v_in with respect to the parameters of `inertia_regressor`: of the speed of the centre of mass."""
    robot, state = landing.robot, landing.state
    found = np.zeros((len(robot.bodies), 10))
    if landing.scene.v_in != "com":
        return found
    velocity = com_velocity(landing.robot, landing.state, landing.before)[0]
    towards = velocity / np.linalg.norm(velocity) / robot.mass
    for i, body in enumerate(robot.bodies):
        twist = twist_before(state, landing.before, i)[0]
        rotation = state.rotation[0, i] @ body.rotation.T
        origin = state.position[0, i] - rotation @ body.offset
        found[i, 0] = towards @ (velocity_at(twist[:3], twist[3:], origin) - velocity)
        found[i, 1:4] = [towards @ np.cross(twist[:3], axis) for axis in rotation.T]
    return found


def _strike(profile: ShockProfile, place: _Place) -> Iterator[Effect]:
    """The strike angle: the robot's velocity turns in the plane, from straight down towards forward."""
    landing, plane = profile.landing, profile.plane
    if plane.level:
        return
    velocity = landing.before.velocity
    d_velocity = np.cross(np.cross(plane.forward, [0.0, 0.0, 1.0]), velocity)
    fastest = com_velocity(landing.robot, landing.state, landing.before)[0] if profile.scene.v_in == "com" else profile.strike
    d_speed = float(fastest @ d_velocity) / profile.v_in
    d_jump = profile.maps[place.body] @ d_velocity
    yield place.effect("strike", "", "", strike_angle(landing), "rad", place.changes(d_jump[:, None], np.array([d_speed]))[0])


def _angles(profile: ShockProfile, place: _Place) -> Iterator[Effect]:
    """The joint values, in ball arithmetic."""
    landing, robot = profile.landing, profile.robot
    paths: list[Callable[[float], PosedLanding]] = []
    rows: list[tuple[str, str, float, str, int, str]] = []
    for joint, axis, unit, column in _coordinates(robot):
        rates, reason = _rates(landing, column)
        path = None if reason else _path(landing, rates)
        if path is None:
            reason = reason or "the lowest point of a contact jumps here"
        else:
            paths.append(path)
        # A rotation about several axes has no value, and counts from where it is.
        part = next((one for one in joint.parts if one.v.start == column), joint)
        value = part.value(landing.q) if part.axis is not None else 0.0
        rows.append((joint.name, axis, value, unit, len(paths) - 1, reason))

    def outputs(impact: BallImpact) -> Balls:
        jump, v_in = impact.own_jumps[0, 0, place.body], impact.v_in[0, 0]
        normal = np.sum(impact.orientations([place.body])[0, 0] * balls(landing.plane.normal)[:, None], axis=0)
        shock = norm(velocity_at(jump[:3], jump[3:], balls(place.point.r)))[()] / v_in
        if place.translates:
            return np.array([shock], dtype=object)
        none = np.zeros(1, dtype=bool)
        found = percussion(jump[None, :3], jump[None, 3:], normal[None], v_in, none, ~none)
        return np.array([shock, *found.copc[0], found.ropc[0]], dtype=object)

    nothing = np.full(5, np.nan)
    changes = derivatives(profile.proof, paths, outputs)
    for name, axis, value, unit, k, reason in rows:
        found = nothing if reason else np.append(changes[k], nothing[changes.shape[1] :])
        yield place.effect("angle", axis, name, value, unit, found, reason)


def _path(landing: PosedLanding, rates: Array) -> Callable[[float], PosedLanding] | None:
    """The landing as joints move; None where the lowest point of a contact jumps."""
    robot, h = landing.robot, 2.0**-20
    lowest = [k for k, contact in enumerate(landing.contacts) if contact.lowest]
    speeds: dict[int, Array] = {}
    if lowest:
        # What is lowest is found in double precision, so the speed of that point over its link is known to ten digits.
        state = dynamics(robot, np.stack([displaced(robot, landing.q, rates, t).astype(float) for t in (h, -h)]))
        for k in lowest:
            after, before = locate_lowest_point(landing.contacts[k], state.rotation[:, landing.contacts[k].body], landing.up).point
            speeds[k] = (after - before) / (2.0 * h)
            if np.abs(speeds[k]).max() > JUMPS:
                return None

    def path(t: float) -> PosedLanding:
        contacts = tuple(
            block._replace(point=balls(block.point) + balls(t * speeds[k]), lowest=()) if k in speeds else block
            for k, block in enumerate(landing.blocks[: len(landing.contacts)])
        )
        return replace(landing, q=displaced(robot, landing.q, rates, t), contacts=contacts)

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
