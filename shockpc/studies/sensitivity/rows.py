"""Landings that differ from one in one parameter at a time: masses, inertias, joint values and the strike, beside their values.

Everything but the closing of loops is linear in these parameters, so they are known by the rates at which they change the inertias,
the joints and the velocity before the impact; such rows share their landing, and are one group. What else a sweep varies, each
row sets as a sweep does.
"""

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from shockpc.core.spatial import Array
from shockpc.evaluation.source import Chunk, Group, LandingsBeside, Refusal
from shockpc.evaluation.variation import Variation
from shockpc.evaluation.varied import VariedLandings
from shockpc.evaluation.varied_scene import present_value, refuse_given_otherwise
from shockpc.landing.closure import assemble, closure_block
from shockpc.landing.dynamics import Inertias, dynamics
from shockpc.landing.freedom import free_columns
from shockpc.landing.landing import PosedLanding
from shockpc.landing.posture import displaced, fixed_joints
from shockpc.landing.rows import row_jacobian
from shockpc.profile import profile_of, profile_of_scene
from shockpc.quantities.profile import ShockProfile
from shockpc.robot.changes import Property, links_with_mass, varied_bodies, with_inertias
from shockpc.robot.elements import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import ShockError

ParameterKind: TypeAlias = str
"""What is changed: "mass" alone, mass and inertia in "proportion", "com", "inertia", "armature" (reflected inertia), "angle" (joint
value), "strike" (angle), or a word of what a sweep varies."""

INERTIA_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""The entries of an inertia by row and column; those off the diagonal stand for both of their places."""

STEP = 2.0**-11
"""Largest step of a row from the value of its parameter, as a share of the parameter's size."""

LEAST_SHARE = 1e-6
"""Least share of the inertia by which a parameter's size is taken to change it."""

STEPS = np.array([1.0, 0.5, -1.0, -0.5])
"""The steps of the rows of a parameter, as shares of the largest."""


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
        rates: by how much a unit of it changes "mass" (nb,), "com" (nb, 3) and "inertia" (nb, 3, 3) of the bodies and "armature"
            (nv,) of the joints, as in `Inertias`, "joints" (nv,) by velocity, and "velocity" (3,) of the base before the impact.
        reason: why it cannot change; empty if it can.
        varied: what a sweep varies, where no rates say what a change does.
    """

    kind: ParameterKind
    axis: str
    name: str
    value: float
    unit: str
    size: float
    rates: Mapping[str, Array]
    reason: str = ""
    varied: Variation | None = None


@dataclass(frozen=True, eq=False)
class VariedOneByOne(LandingsBeside):
    """Landings beside a given one, four for each of some parameters: a step and half of it to both sides.

    Attributes:
        landing: the given one.
        parameters: which can change.
    """

    parameters: tuple[Parameter, ...] = field(repr=False)

    noun, strikes, headings = "sensitivity", 1, ("parameter", "step")

    @functools.cached_property
    def steps(self) -> Array:
        """The largest step (p,) of each parameter [its unit]: that of an inertia changes H by the share `STEP` of itself.

        What follows from H varies on the scale on which H does, and not with the size of a body that hardly counts. With A = H⁻¹ dH
        for a change by the size, H + t dH is singular for no |t| below 1 / √tr A², in which the sum of A's squared eigenvalues is;
        with a centre of mass H changes as its square, too.
        """
        sizes = np.array([parameter.size or 1.0 for parameter in self.parameters])
        landing, n = self.landing, len(sizes)
        changed = dynamics(landing.robot, np.repeat(landing.q[None], n, axis=0), None, self._inertias(sizes, np.ones(1))).H
        H, change, G = landing.state.H[0], changed - landing.state.H, landing.free_columns(landing.state)
        if G is not None:
            H, change = G[0].T @ H @ G[0], G[0].T @ change @ G[0]
        A = np.linalg.solve(H, change)
        share = np.maximum(np.sqrt(np.abs(np.einsum("nij,nji->n", A, A))), LEAST_SHARE)
        share = np.where([parameter.kind == "com" for parameter in self.parameters], np.maximum(share, np.sqrt(share)), share)
        inertial = [not parameter.rates.keys().isdisjoint(Inertias._fields) for parameter in self.parameters]
        return STEP * sizes / np.where(inertial, share, 1.0)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(STEPS) * len(self.parameters)

    @property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """All rows at once."""
        return ((0, self.rows),)

    @property
    def kinds(self) -> tuple[str, ...]:
        """What varies."""
        return tuple(parameter.kind for parameter in self.parameters)

    @property
    def description(self) -> dict[str, Any]:
        """The names of the parameters."""
        return {"parameters": [parameter[:3] for parameter in self.parameters], "steps": self.steps.tolist()}

    def chunk(self, k: int, data: None) -> Chunk:
        """All rows, in the order of the parameters, those of a parameter in the order of `STEPS`."""
        landing, robot, n = self.landing, self.robot, len(STEPS)
        names = [" ".join(filter(None, parameter[:3])) for parameter in self.parameters]
        labels = {"parameter": np.repeat(names, n), "step": np.outer(self.steps, STEPS).ravel()}
        inertias, velocity = self._inertias(self.steps, STEPS), self._varied("velocity", landing.before.velocity, self.steps, STEPS)
        moved = self._varied("joints", np.zeros(robot.model.nv), self.steps, STEPS)
        Q = displaced(robot, np.broadcast_to(landing.q, (len(moved), len(landing.q))), moved)
        groups, as_swept = list[Group | Refusal](), self._as_swept()
        solved = ~np.isin(np.arange(self.rows), list(as_swept))
        for i, source in as_swept.items():
            groups += [group._replace(postures=np.array([i])) for group in source.chunk(0, None).groups]
        fixed = fixed_joints(robot, self.scene.posture, self.scene.assemble) | robot.velocities(robot.followers)
        for i in np.flatnonzero(solved & (landing.q != Q).any(axis=1)).tolist() if landing.loops else ():
            try:
                Q[i] = assemble(robot, Q[i], landing.loops, landing.plane, fixed).q
            except ShockError as error:
                solved[i] = False
                groups.append(Refusal(np.array([i]), error))
        chosen = Inertias(*(x[solved] for x in inertias))
        if solved.any():
            groups.append(Group(np.flatnonzero(solved), landing, Q[solved], velocity[solved, None], chosen))

        def profile(i: int) -> ShockProfile:
            if i in as_swept:
                return profile_of_scene(*as_swept[i].case(0))
            whole = robot
            if self.parameters[i // n].rates.keys() & {"mass", "com", "inertia"}:
                whole = with_inertias(robot, inertias.mass[i], inertias.com[i], inertias.inertia[i])
            state, joints = (
                dynamics(whole, Q[i : i + 1], inertias.armature[i]),
                landing.joint_model._replace(armature=inertias.armature[i]),
            )
            before = landing.before._replace(velocity=velocity[i])
            return profile_of(replace(landing, robot=whole, joint_model=joints, before=before, q=Q[i], state=state))

        return Chunk(labels, groups, profile)

    def _as_swept(self) -> dict[int, VariedLandings]:
        """The rows of parameters that a sweep varies, each by its number."""
        rows = dict[int, VariedLandings]()
        for k, (parameter, step) in enumerate(zip(self.parameters, self.steps.tolist(), strict=True)):
            if parameter.varied is None:
                continue
            for j, share in enumerate(STEPS.tolist()):
                value = (parameter.value + share * step) * (math.degrees(1.0) if parameter.unit == "rad" else 1.0)
                varied = replace(parameter.varied, values=(value,), span=None)
                rows[len(STEPS) * k + j] = VariedLandings(self.scene, self.robot, (varied,))
        return rows

    def _inertias(self, steps: Array, shares: Array) -> Inertias:
        present = Inertias.of(self.robot, self.landing.joint_model.armature)
        return Inertias(*(self._varied(name, value[0], steps, shares) for name, value in present._asdict().items()))

    def _varied(self, what: str, value: Array, steps: Array, shares: Array) -> Array:
        """What the rates of a name change (p s, ...), after shares (s,) of steps (p,). Args: value, in the given landing."""
        out = np.repeat(value[None], len(steps) * len(shares), axis=0)
        for rows, parameter, step in zip(np.split(out, len(steps)), self.parameters, steps, strict=True):
            if what in parameter.rates:
                rows += np.multiply.outer(step * shares, parameter.rates[what])
        return out


def parameters(landing: PosedLanding) -> list[Parameter]:
    """All parameters of a landing: bodies first, then joints, then the strike."""
    return [*_inertial(landing.robot), *_armatures(landing), *_joint_values(landing), *_strike(landing)]


def swept_parameter(landing: PosedLanding, varied: Variation) -> Parameter:
    """What a sweep varies as a parameter of a landing, for what has no rates.

    Raises:
        StudyError: as for `refuse_given_otherwise`.
    """
    refuse_given_otherwise(landing.scene, varied.kind)
    value, unit, scale = present_value(landing, varied), varied.unit, 1.0
    reason = "" if math.isfinite(value) else "the landing gives it no value, or not a single one, that could be changed; give one"
    if varied.factor:
        unit = "1"
    elif unit == "deg":
        unit, scale = "rad", math.radians(1.0)
    size = landing.length if unit == "m" else 1.0 if unit in ("1", "rad") else abs(value) or 1.0
    return Parameter(varied.kind, "", varied.target, scale * value, unit, size, {}, reason, varied)


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
    moved, added, h = what.startswith("com"), what.startswith("inertia-"), 1e-5
    about = {link: 0.0 if moved or added else 1.0 if factor else mass for link, mass in links.items()}
    # The bodies' inertias are smooth functions of each value, so that about ten digits of their differences are left.
    near = [(what, link, np.array([value + h, value - h]), factor) for link, value in about.items()]
    rates = {name: (x[0] - x[1]) / (2.0 * h) for name, x in zip(Inertias._fields, varied_bodies(robot, near), strict=False)}
    kind, axis = ("proportion", "") if what == "mass" else what.partition("-")[::2]
    unit = "1" if factor else "m" if moved else "kg m²" if added else "kg"
    for i in sorted({robot.frames[link].body for link in links}):
        name = f"{pattern} on {robot.bodies[i].name}"
        moment = float(np.trace(robot.inertias[i])) / 3.0
        size = 1.0 if factor else float(robot.gyration[i]) if moved else moment if added else float(robot.masses[i])
        yield Parameter(kind, axis, name, math.nan, unit, size, {key: _of_one(x[i], i, x) for key, x in rates.items()})


def _of_one(rate: Array | float, body: int, like: Array) -> Array:
    """The rate of one body among zeros for the others. Args: like (nb, ...), of all bodies."""
    out = np.zeros_like(like)
    out[body] = rate
    return out


def _inertial(robot: Robot) -> Iterator[Parameter]:
    mass, com, inertia = robot.masses, robot.coms, robot.inertias
    for i, body in enumerate(robot.bodies):
        # As of a point at the centre of mass, and with everything in proportion.
        yield Parameter("mass", "", body.name, body.mass, "kg", body.mass, {"mass": _of_one(1.0, i, mass)})
        whole = {"mass": _of_one(body.mass, i, mass), "inertia": _of_one(body.inertia, i, inertia)}
        yield Parameter("proportion", "", body.name, 1.0, "1", 1.0, whole)
        for axis, x, along in zip("xyz", body.com, np.eye(3), strict=True):
            yield Parameter("com", axis, body.name, float(x), "m", float(robot.gyration[i]), {"com": _of_one(along, i, com)})
        for j, k in INERTIA_ENTRIES:
            entry = np.zeros((3, 3))
            entry[[j, k], [k, j]] = 1.0
            size, rates = float(np.trace(body.inertia)) / 3.0, {"inertia": _of_one(entry, i, inertia)}
            yield Parameter("inertia", "xyz"[j] + "xyz"[k], body.name, float(body.inertia[j, k]), "kg m²", size, rates)


def _armatures(landing: PosedLanding) -> Iterator[Parameter]:
    model, moved = landing.joint_model, np.diag(landing.state.H[0])
    for joint, axis, unit, v in _coordinates(landing.robot):
        if not model.locked[v]:
            unit, value = "kg m²" if unit == "rad" else "kg", float(model.armature[v])
            rates = {"armature": _of_one(1.0, v, model.armature)}
            yield Parameter("armature", axis, joint.name, value, unit, value or float(moved[v]), rates)


def _strike(landing: PosedLanding) -> Iterator[Parameter]:
    """The strike angle: the robot's velocity turns in the plane, from straight down towards forward.

    After a fall from a drop height its vertical component stays, and the forward one changes.
    """
    if not landing.plane.level:
        forward, velocity = landing.plane.forward, landing.before.velocity
        turn = np.cross(np.cross(forward, [0.0, 0.0, 1.0]), velocity)
        if landing.scene.strike.drop_height is not None:
            turn = -velocity[2] / math.cos(landing.strike_angle) ** 2 * forward
        yield Parameter("strike", "", "", landing.strike_angle, "rad", 1.0, {"velocity": turn})


def _joint_values(landing: PosedLanding) -> Iterator[Parameter]:
    for joint, axis, unit, v in _coordinates(landing.robot):
        rates, reason = _rates(landing, v)
        # A rotation about several axes has no value, and counts from where it is.
        part = next((part for part in joint.parts if part.v.start == v), joint)
        value = part.value(landing.q) if part.axis is not None else 0.0
        size = 1.0 if unit == "rad" else landing.length
        yield Parameter("angle", axis, joint.name, value, unit, size, {"joints": rates}, reason)


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
    fixed = fixed_joints(robot, landing.scene.posture, landing.scene.assemble)
    fixed |= robot.velocities(robot.followers)
    fixed[column] = True
    if not fixed.all():
        others = free_columns(robot, "fixed", landing.plane, rotation, fixed)
        if others is not None:
            rates = rates + others[0] @ np.linalg.lstsq(K @ others[0], -K @ rates, rcond=1e-10)[0]
    if np.abs(K @ rates).max() > 1e-9 * np.abs(rates).max():
        return rates, "the loops, and the joints that the posture sets, hold it"
    return rates, ""


def _coordinates(robot: Robot) -> Iterator[tuple[Joint, str, str, int]]:
    """The velocities of the joints that follow no other: joint, which of its velocities, unit of the coordinate, column."""
    for joint in robot.single_joints[robot.free_base :]:
        if joint.name not in robot.followers:
            for axis, unit, column in zip(*COORDINATES.get(joint.kind, ONE), range(joint.v.start, joint.v.stop), strict=True):
                yield joint, axis, joint.unit if joint.axis is not None else unit, column


ONE = ("",), ("rad",)
COORDINATES = {
    "ball": (("x", "y", "z"), ("rad",) * 3),
    "planar": (("x", "y", "turn"), ("m", "m", "rad")),
    "free": (("x", "y", "z", "turn x", "turn y", "turn z"), ("m",) * 3 + ("rad",) * 3),
}
"""Of joints with several velocities: their names and the units of what they move."""
