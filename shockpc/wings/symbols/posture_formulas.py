"""A landing that sliders move: its other postures as a program, with what a page shows of them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

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
from shockpc.wings.symbols.landing_programs import kept, refuse, singular_landing, symbols_module
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
        run = "for(const part of parts)part(...given)"
        return (
            f"(()=>{{const w=new Float64Array({slots}),parts=[\n{parts}];return "
            f"(...given)=>{{{run}}}}})()"
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
    sliders = [
        *(
            Slider(
                "joint", joint.name, joint.unit, joint.value(landing.q), *_range(joint, landing.q)
            )
            for joint in moved
        ),
        *(() if boxes is None else _places(landing.contacts[0], boxes)),
        *_masses(landing),
    ]
    values = np.cumsum([0, len(moved), 0 if boxes is None else 3])

    def formulas(x: Numbers) -> Iterator[Any]:
        s, T = x[-12:-9], x[-9:].reshape(3, 3)
        data, contacts, stance = data_of(robot), list(landing.contacts), landing.stance
        if boxes is not None:
            contacts[0] = contacts[0]._replace(point=x[values[1] : values[2]])
        mass, inertia = data.mass.astype(object), data.inertia.astype(object)
        for body, value in zip(_struck(landing), x[values[2] : -12], strict=True):
            inertia[body] = inertia[body] * (value / float(mass[body]))
            mass[body] = value
        here = replace(
            landing,
            q=_configuration(
                robot,
                landing.q,
                dict(zip((joint.name for joint in moved), x[: len(moved)], strict=True)),
            ),
            before=Motion(s, *landing.before[1:]),
            contacts=tuple(_tilted(block, T) for block in contacts),
            stance=tuple(_tilted(block, T) for block in stance),
        )
        rows = symbols.RowSpace.every(sum(block.size for block in here.constraints))
        changed = data._replace(mass=mass, inertia=inertia)
        solution = symbols.SymbolSolution(here.posed, rows, changed)
        impact = symbols.SymbolImpact(solution, here)
        yield impact.state.rotation
        yield impact.state.position
        yield impact.strike_jumps
        yield quantity("contact", "impulse").compute(impact, here.places("contact"))
        if places := here.places("joint"):
            loads = [
                np.asarray(quantity("joint", key).compute(impact, places))
                for key in ("along", "force", "moment")
            ]
            yield np.concatenate([part.reshape(len(places), -1) for part in loads], axis=1)
        yield impact.condition

    try:
        made = kept(
            landing,
            ("live", tuple(slider.name for slider in sliders), boxes is None, landing.q),
            lambda: symbols.program(len(sliders) + 12, formulas).arrays(),
        )
    except SingularError as singular:
        raise singular_landing(landing, singular) from None
    return LiveLanding(
        tuple(sliders), TILTS[landing.base] if robot.free_base else (), Program.of(made)
    )


def _moved(landing: PosedLanding, more: Sequence[str]) -> Iterator[Joint]:
    """The joints that carry what strikes, or lead one that does, and others by name."""
    robot = landing.robot
    names = {name for pattern in more for name in robot.match_joints(pattern)}
    carrying = np.asarray(robot.ancestors[[block.body for block in landing.contacts]].any(axis=0))
    led = {
        name
        for mimic in robot.mimics
        if carrying[robot.joint(mimic.joint).v].any()
        for name in mimic.leaders
    }
    for joint in robot.independent_joints:
        if carrying[joint.v].any() or joint.name in led | names:
            yield joint


def _struck(landing: PosedLanding) -> list[int]:
    """The base and the bodies that carry what strikes, with mass."""
    robot = landing.robot
    found, body = {0}, landing.contacts[0].body
    while body >= 0:
        found.add(body)
        body = robot.parents[body]
    mass = data_of(robot).mass
    return [k for k in sorted(found) if mass[k] > 0.0]


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
    value, most = joint.value(q), RANGE if joint.unit == "rad" else 1.0
    low, high = (
        limit if np.isfinite(limit) else sign * most
        for limit, sign in zip(joint.limits, (-1.0, 1.0), strict=True)
    )
    return min(low, value), max(high, value)


def _configuration(robot: Robot, q: Array, values: dict[str, Any]) -> Numbers:
    """A configuration (nq,) with some joints as symbols, and those that follow them."""
    found = q.astype(object)
    for mimic in robot.mimics:
        if values.keys() & mimic.leaders.keys():
            led = (
                by * values.get(name, robot.joint(name).value(q))
                for name, by in mimic.leaders.items()
            )
            values[mimic.joint] = sum(led, start=mimic.offset)
    for name, value in values.items():
        joint = robot.joint(name)
        found[joint.q] = value.sin_cos()[::-1] if joint.kind == "continuous" else value
    return found


def _tilted(block: Constraint, T: Numbers) -> Constraint:
    """The constraint on tilted ground; rows along all axes stay, as they hold the same."""
    if block.axes_body >= 0 or (
        np.linalg.matrix_rank(block.forces) == 3
        and not len(block.moments)
        and block.rebound is None
    ):
        return block
    rebound = None if block.rebound is None else block.rebound @ T
    return block._replace(forces=block.forces @ T, moments=block.moments @ T, rebound=rebound)
