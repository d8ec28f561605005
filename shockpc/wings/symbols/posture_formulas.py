"""A landing that sliders move: its other postures as a program, with what a page shows of them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from shockpc.core.impulse import RowSpace
from shockpc.core.spatial import Array
from shockpc.landing.landing import PosedLanding
from shockpc.method.approach import Motion
from shockpc.method.constraints import Constraint
from shockpc.method.exact.arithmetic import Numbers, SingularError
from shockpc.method.exact.kinematics import data_of
from shockpc.quantities.selection import quantity
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError
from shockpc.wings.symbols.c_and_javascript import JAVASCRIPT, pieces
from shockpc.wings.symbols.landing_programs import (
    cached_arrays,
    refuse,
    singular_landing,
    symbols_module,
)
from shockpc.wings.symbols.programs import Program

RANGE = np.pi
"""Largest angle of a slider of a joint without limits [rad]."""

TILTS = {"free": ("pitch", "roll"), "planar": ("pitch",), "fixed": ()}
"""Rotations of the base that its mount allows."""


class Slider(NamedTuple):
    """A number that the page changes.

    Attributes:
        kind: of what: a joint, the point of the first contact, or the mass of a body.
        name: of the joint, the coordinate, or the body.
        unit: of its value.
        value: of the landing.
        low: least value.
        high: largest value.
    """

    kind: Literal["joint", "contact", "mass"]
    name: str
    unit: str
    value: float
    low: float
    high: float


class LiveLanding(NamedTuple):
    """A landing in whatever posture its sliders say.

    The base stays as the landing has it. Where it tilts, the ground tilts against it instead: a
    tilt T (3, 3) takes the axes of the landing to those of the world.

    Attributes:
        sliders: of joints, of the contact and of masses.
        tilts: rotations of the base that are possible.
        program: of the sliders' values, the strike Tᵀ v (3,) and T (9,) row after row: rotations
            (nb, 3, 3) and positions (nb, 3) of the bodies, body to world and from the base, before
            the tilt; jumps (nb, 6) in body coordinates; impulses (nc, 3) of the ground before the
            tilt; impulses through the joints (nj, 7), along the axis, force and moment; and the
            condition.
    """

    sliders: tuple[Slider, ...]
    tilts: tuple[str, ...]
    program: Program

    def javascript(self) -> str:
        """JavaScript of a function (x, s, t, out) of the program's inputs that writes `out`."""
        bodies, slots = pieces(
            self.program, {"x": len(self.sliders), "s": 3, "t": 9}, JAVASCRIPT, "const", 700
        )
        parts = ",\n".join(
            "(x,s,t,out)=>{{\n{}\n}}".format(body.replace(";\nconst ", ",\n")) for body in bodies
        )
        run = "for(const part of parts)part(...inputs)"
        return (
            f"(()=>{{const w=new Float64Array({slots}),parts=[\n{parts}];return "
            f"(...inputs)=>{{{run}}}}})()"
        )


def live_landing(
    landing: PosedLanding, joints: Sequence[str] = (), boxes: Array | None = None
) -> LiveLanding:
    """A landing with sliders for the joints that carry what strikes.

    Args:
        landing: the landing.
        joints: names or globs of further joints.
        boxes: (nb, 2, 3) least and largest coordinates of each body in its frame, for a contact's
            place [m]; without them there are no sliders of it.

    Raises:
        SceneError, SolveError: it cannot be written in symbols.
        StudyError: CasADi is not installed.
        UnknownName: the robot has no such joint.
    """
    symbols = symbols_module()
    if not landing.translates:
        raise SceneError(
            "before the impact the robot rotates, or joints or contacts move on their own; leave "
            "that out"
        )
    refuse(landing)
    robot = landing.robot
    moved = list(_moved(landing, joints))
    sliders: list[Slider] = []
    for joint in moved:
        low, high = _range(joint, landing.q)
        value = joint.value(landing.q)
        sliders.append(Slider("joint", joint.name, joint.unit, value, low, high))
    if boxes is not None:
        sliders += _places(landing.contacts[0], boxes)
    sliders += _masses(landing)
    formulas = _PostureFormulas(landing, moved, boxes is not None)
    names = tuple(slider.name for slider in sliders)
    try:
        arrays = cached_arrays(
            landing,
            ("live", names, boxes is None, landing.q),
            lambda: symbols.program(len(sliders) + 12, formulas).arrays(),
        )
    except SingularError as singular:
        raise singular_landing(landing, singular) from None
    tilts = TILTS[landing.base] if robot.free_base else ()
    return LiveLanding(tuple(sliders), tilts, Program.of(arrays))


class _PostureFormulas:
    """The numbers of a landing as formulas of what sliders say.

    Args:
        landing: the landing.
        moved: joints with a slider.
        moves_contact: the point of the first contact has sliders.
    """

    def __init__(self, landing: PosedLanding, moved: Sequence[Joint], moves_contact: bool) -> None:
        self.landing = landing
        self.moved = moved
        self.moves_contact = moves_contact

    def __call__(self, x: Numbers) -> Iterator[Any]:
        """The outputs of a `LiveLanding`. Args: x, sliders, the strike and the tilt, as there."""
        symbols = symbols_module()
        sliders = x[:-12]
        here = self._landing(sliders, x[-12:-9], x[-9:].reshape(3, 3))
        rows = RowSpace.every(sum(constraint.size for constraint in here.constraints))
        solution = symbols.SymbolSolution(here.posed, rows, self._data(sliders))
        impact = symbols.SymbolImpact(solution, here)
        yield impact.state.rotation
        yield impact.state.position
        yield impact.strike_jumps
        yield quantity("contact", "impulse").compute(impact, here.places("contact"))
        places = here.places("joint")
        if places:
            loads = []
            for key in ("along", "force", "moment"):
                load = np.asarray(quantity("joint", key).compute(impact, places))
                loads.append(load.reshape(len(places), -1))
            yield np.concatenate(loads, axis=1)
        yield impact.condition

    def _landing(self, sliders: Numbers, strike: Numbers, T: Numbers) -> PosedLanding:
        """The landing with symbols. Args: strike, velocity (3,); T, tilt (3, 3)."""
        landing = self.landing
        n = len(self.moved)
        contacts = list(landing.contacts)
        if self.moves_contact:
            contacts[0] = contacts[0]._replace(point=sliders[n : n + 3])
        values = {joint.name: x for joint, x in zip(self.moved, sliders[:n], strict=True)}
        return replace(
            landing,
            q=_configuration(landing.robot, landing.q, values),
            before=Motion(strike, *landing.before[1:]),
            contacts=tuple(_tilted(contact, T) for contact in contacts),
            stance=tuple(_tilted(foot, T) for foot in landing.stance),
        )

    def _data(self, sliders: Numbers) -> Any:
        """Numbers of the robot, with the masses of sliders; inertias are in proportion."""
        data = data_of(self.landing.robot)
        mass = data.mass.astype(object)
        inertia = data.inertia.astype(object)
        first = len(self.moved) + 3 * self.moves_contact
        for body, value in zip(_struck(self.landing), sliders[first:], strict=True):
            inertia[body] = inertia[body] * (value / float(mass[body]))
            mass[body] = value
        return data._replace(mass=mass, inertia=inertia)


def _moved(landing: PosedLanding, more: Sequence[str]) -> Iterator[Joint]:
    """The joints that carry what strikes, or lead one that does, and others by name."""
    robot = landing.robot
    names: set[str] = set()
    for pattern in more:
        names.update(robot.match_joints(pattern))
    struck = [contact.body for contact in landing.contacts]
    carrying = np.asarray(robot.ancestors[struck].any(axis=0))
    for mimic in robot.mimics:
        if carrying[robot.joint(mimic.joint).v].any():
            names.update(mimic.leaders)
    for joint in robot.independent_joints:
        if carrying[joint.v].any() or joint.name in names:
            yield joint


def _struck(landing: PosedLanding) -> list[int]:
    """The base and the bodies that carry what strikes, with mass."""
    robot = landing.robot
    bodies = {0}
    body = landing.contacts[0].body
    while body >= 0:
        bodies.add(body)
        body = robot.parents[body]
    mass = data_of(robot).mass
    return [k for k in sorted(bodies) if mass[k] > 0.0]


def _masses(landing: PosedLanding) -> Iterator[Slider]:
    for body in _struck(landing):
        mass = float(data_of(landing.robot).mass[body])
        yield Slider("mass", landing.robot.bodies[body].name, "kg", mass, 0.2 * mass, 3.0 * mass)


def _places(contact: Constraint, boxes: Array) -> Iterator[Slider]:
    for k, axis in enumerate("xyz"):
        value = float(contact.point[k])
        low, high = boxes[contact.body][:, k].tolist()
        yield Slider(
            "contact", f"{contact.frame} {axis}", "m", value, min(low, value), max(high, value)
        )


def _range(joint: Joint, q: Array) -> tuple[float, float]:
    """Least and largest value of the slider of a joint."""
    value = joint.value(q)
    most = RANGE if joint.unit == "rad" else 1.0
    low, high = joint.limits
    if not np.isfinite(low):
        low = -most
    if not np.isfinite(high):
        high = most
    return min(low, value), max(high, value)


def _configuration(robot: Robot, q: Array, values: dict[str, Any]) -> Numbers:
    """A configuration (nq,) with some joints as symbols, and those that follow them."""
    in_symbols = q.astype(object)
    for mimic in robot.mimics:
        if values.keys() & mimic.leaders.keys():
            angle = mimic.offset
            for name, factor in mimic.leaders.items():
                angle = angle + factor * values.get(name, robot.joint(name).value(q))
            values[mimic.joint] = angle
    for name, value in values.items():
        joint = robot.joint(name)
        in_symbols[joint.q] = value.sin_cos()[::-1] if joint.kind == "continuous" else value
    return in_symbols


def _tilted(constraint: Constraint, T: Numbers) -> Constraint:
    """The constraint on tilted ground; rows along all axes stay, as they hold the same."""
    if constraint.axes_body >= 0:
        return constraint
    rebound = constraint.rebound
    all_axes = np.linalg.matrix_rank(constraint.forces) == 3 and not len(constraint.moments)
    if all_axes and rebound is None:
        return constraint
    if rebound is not None:
        rebound = rebound @ T
    return constraint._replace(
        forces=constraint.forces @ T, moments=constraint.moments @ T, rebound=rebound
    )
