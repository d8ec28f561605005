"""The parts of a robot: bodies, joints, frames, couplings, loops and drives.

The first three are read from Pinocchio's model.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.frozen import frozen
from shockpc.core.interval import Interval, ends, middle
from shockpc.core.spatial import Array, read_only
from shockpc.robot.gear import SENSE, Gear
from shockpc.text.printed import listed

KINDS = {
    "FreeFlyer": "free",
    "Spherical": "ball",
    "Planar": "planar",
    "Composite": "composite",
    "P": "prismatic",
}
KINDS |= {"RevoluteUnbounded": "continuous", "RUB": "continuous", "R": "revolute"}
"""Kinds of joint, by the beginning of what Pinocchio calls them."""

WORLD = "world"
"""A root link of this name stands for the ground."""

IDENTIFIED = 0.2
"""Share by which identified inertias of drives of one type differ: ANYmal D's twelve, by one
standard deviation.
"""

FRAMES: dict[pin.FrameType, Literal["link", "site", "geom"]]
FRAMES = {pin.FrameType.BODY: "link", pin.FrameType.OP_FRAME: "site", pin.FrameType.SENSOR: "geom"}
"""Kinds of frame; all others are joints.

Pinocchio has no kind for geoms, and no reader here makes sensors.
"""


class Body(NamedTuple):
    """A body that moves as one: a link and all that is fixed to it.

    Attributes:
        name: the link that the body's moving joint carries; the root link for the base.
        joint: index of that joint in the Pinocchio model.
        links: every link of the body, that of the name first.
        rotation: (3, 3) of the body frame in the joint's frame.
        offset: (3,) origin of the body frame in the joint's frame [m].
        mass: [kg]
        com: (3,) centre of mass in the body frame [m].
        inertia: (3, 3) about the centre of mass, axes of the body frame [kg m²].
    """

    name: str
    joint: int
    links: tuple[str, ...]
    rotation: Array
    offset: Array
    mass: float
    com: Array
    inertia: Array


class Joint(NamedTuple):
    """The motion of a body against the one that carries it.

    Attributes:
        name: as the file says.
        kind: free (q: position, quaternion x y z w; v: linear then angular, body axes), planar (x,
            y, cosine, sine), ball (quaternion), continuous (cosine, sine), revolute, prismatic, or
            composite (several of these after one another).
        axis: (3,) unit vector in the joint's frame; None where there is more than one.
        parent: index of the body that carries it; −1 for the world.
        rotation: (3, 3) of the joint's frame at rest in the parent's joint frame; of a part, in
            that of the part before it.
        offset: (3,) its origin there [m].
        q: where its configuration is in q.
        v: where its velocities are in q̇.
        limits: smallest and largest value of a joint of one coordinate [rad, m].
        parts: of a composite, in their order; its name is theirs, joined by "+".
    """

    name: str
    kind: str
    axis: Array | None
    parent: int
    rotation: Array
    offset: Array
    q: slice
    v: slice
    limits: tuple[float, float]
    parts: "tuple[Joint, ...]" = ()

    @property
    def unit(self) -> str:
        """Unit of its coordinate."""
        return "m" if self.kind == "prismatic" else "rad"

    def value(self, q: Array) -> float:
        """The coordinate of a joint of one degree of freedom [rad, m]. Args: q (nq,)."""
        if self.kind == "continuous":
            cosine, sine = q[self.q]
            return math.atan2(sine, cosine)
        return float(q[self.q.start])

    def coordinates(self, q: Array) -> tuple[float, ...]:
        """The coordinates of a joint of several degrees of freedom [rad, m].

        A planar one has an angle among them.

        Args: q (nq,).
        """
        values = q[self.q].tolist()
        if self.kind == "planar":
            x, y, cosine, sine = values
            return x, y, math.atan2(sine, cosine)
        return tuple(values)

    def set(self, value: float, q: Array) -> None:
        """Set the coordinate of a joint of one degree of freedom [rad, m].

        Args: q (nq,), which is changed.
        """
        q[self.q] = (math.cos(value), math.sin(value)) if self.kind == "continuous" else value


class Frame(NamedTuple):
    """A named place on a body.

    Attributes:
        name: link, joint, site or geom.
        body: index into `Robot.bodies`; −1 if it is fixed to the world.
        rotation: (3, 3) in the body frame.
        offset: (3,) origin in the body frame [m].
        kind: what the file calls it.
    """

    name: str
    body: int
    rotation: Array
    offset: Array
    kind: Literal["link", "joint", "site", "geom"]


class Mimic(NamedTuple):
    """A joint that follows others: q_joint = Σ multiplier · q_leader + offset.

    Attributes:
        joint: the follower's name.
        leaders: multiplier [1] by the name of each joint that it follows; none if it stands still.
        offset: [rad, m]
    """

    joint: str
    leaders: Mapping[str, float]
    offset: float

    @property
    def led(self) -> str:
        """The leaders that the joint follows, for messages."""
        return (
            f"joint{'s' * (len(self.leaders) > 1)} {listed(self.leaders)}"
            if self.leaders
            else "a constant"
        )


class Loop(NamedTuple):
    """Two bodies that a joint outside the tree holds together.

    Attributes:
        name: of the two ends.
        bodies: index of each end's body; −1 for the world.
        points: (3,) each end in its body's frame [m].
        rotations: (3, 3) each end's frame in its body's frame.
        axes: (n, 3) unit vectors along which the points are held, in the first end's frame.
        holds_orientation: whether the orientations are held too.
    """

    name: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    rotations: tuple[Array, Array]
    axes: Array
    holds_orientation: bool


@frozen(kw_only=True)
class Drive:
    """The drive of some joints.

    Attributes:
        joint: names or globs of joints.
        robot: names of robots; all if none is given.
        armature: reflected inertia, or its smallest and largest value [kg m²; kg for a prismatic
            joint].
        rotor_inertia: of the rotor about its axis, or its ends [kg m²].
        gear_ratio: turns of the rotor for one of the joint, or its ends [1].
        gear: its kind, from which the sense in which the rotor turns follows.
        drive_stiffness: of a spring between gearbox and joint [N m/rad, N/m].
        stiffness: of a spring of the joint itself [N m/rad, N/m].
        range: smallest and largest inertia at the joint that the source allows, beside the number
            that is computed with [kg m², kg].
        status: published; derived from parts that are published; identified from measured landings;
            of a simulation model; or unknown, where a source gives something, and not the inertia.
        source: where it is from.
    """

    joint: tuple[str, ...]
    robot: tuple[str, ...] = ()
    armature: Interval | None = None
    rotor_inertia: Interval | None = None
    gear_ratio: Interval | None = None
    gear: Gear | None = None
    drive_stiffness: float | None = None
    stiffness: float | None = None
    range: tuple[float, float] | None = None
    status: Literal["published", "derived", "identified", "simulation model", "unknown"] | None = (
        None
    )
    source: str = ""

    @property
    def reflected(self) -> float | None:
        """Inertia at the joint [kg m², kg]; None where it is not known.

        It is the armature, or rotor_inertia · gear_ratio².

        Of intervals it is that of their middles.
        """
        if self.rotor_inertia is None or self.gear_ratio is None:
            return None if self.armature is None else middle(self.armature)
        return middle(self.rotor_inertia) * middle(self.gear_ratio) ** 2

    @property
    def interval(self) -> tuple[float, float]:
        """Smallest and largest inertia at the joint that is possible [kg m², kg].

        Infinite is a joint that is held.

        A number of a simulation model says nothing. An identified one is no better than identified
        drives of one type agree.
        """
        if self.range is not None:
            return self.range
        if self.rotor_inertia is not None and self.gear_ratio is not None:
            (low, high), ratios = ends(self.rotor_inertia), sorted(map(abs, ends(self.gear_ratio)))
            low, high = low * ratios[0] ** 2, high * ratios[1] ** 2
        elif self.armature is not None:
            low, high = ends(self.armature)
        else:
            # a spring of the joint, and no motor
            alone = self.drive_stiffness is None and self.status != "unknown"
            return 0.0, 0.0 if alone else math.inf
        if self.status == "simulation model":
            return 0.0, math.inf
        spread = IDENTIFIED if self.status == "identified" and low == high else 0.0
        return (1.0 - spread) * low, (1.0 + spread) * high

    @property
    def per_turn(self) -> float:
        """Turns of the joint for one of its rotor, below zero where it turns against it.

        It is 0 where gear or ratio is not known.
        """
        if self.gear is None or self.gear_ratio is None:
            return 0.0
        return SENSE[self.gear] / abs(middle(self.gear_ratio))


class Drives(NamedTuple):
    """The data known of the drives of a robot's joints beside the model.

    Attributes:
        label: where they are from; empty if nothing is known.
        by_joint: the drive of each joint of which it is known.
    """

    label: str
    by_joint: Mapping[str, Drive]


def bodies_of(model: pin.Model) -> tuple[Body, ...]:
    """The moving bodies of a model in the order of the tree, base first.

    Each is named after the link that its joint carries.

    A root link called "world" that has no mass is the ground: the body is then named after the
    first link that is fixed to it.
    """
    links: list[list[pin.Frame]] = [[] for _ in range(model.njoints)]
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            links[frame.parentJoint].append(frame)
    bodies = []
    for joint, carried in list(enumerate(links))[1:]:
        if carried[0].name == WORLD and not carried[0].inertia.mass:
            carried.sort(key=lambda frame: not frame.inertia.mass)  # stable: links with mass first
        placement = carried[0].placement
        inertia = placement.actInv(model.inertias[joint])
        body = Body(
            name=carried[0].name,
            joint=joint,
            links=tuple(frame.name for frame in carried),
            rotation=read_only(placement.rotation),
            offset=read_only(placement.translation),
            mass=float(inertia.mass),
            com=read_only(inertia.lever),
            inertia=read_only(inertia.inertia),
        )
        bodies.append(body)
    return tuple(bodies)


def frames_of(model: pin.Model, bodies: Sequence[Body]) -> Mapping[str, Frame]:
    """Every named place of a model, by name.

    Where a link shares its name with another place, the name is the link's.
    """
    frames: dict[str, Frame] = {}
    from_joints = [pin.SE3(body.rotation, body.offset).inverse() for body in bodies]
    for frame in sorted(model.frames, key=lambda frame: frame.type != pin.FrameType.BODY):
        index, placement = frame.parentJoint - 1, frame.placement
        if index >= 0:
            placement = from_joints[index] * placement
        if frame.name != "universe" and frame.name not in frames:
            frames[frame.name] = Frame(
                frame.name,
                index,
                read_only(placement.rotation),
                read_only(placement.translation),
                FRAMES.get(frame.type, "joint"),
            )
    return frames


def joints_of(model: pin.Model) -> tuple[Joint, ...]:
    """The joints of a model, in its order, which is that of the bodies.

    The floating base's is the first.
    """
    # Joint 0 is the world.
    return tuple(
        _joint(model, model.joints[number], number, model.jointPlacements[number])
        for number in range(1, model.njoints)
    )


def _joint(model: pin.Model, joint: Any, number: int, placement: pin.SE3) -> Joint:
    """One joint of a model, or a part of one."""
    type_name = joint.shortname().removeprefix("JointModel")
    kind = next(kind for start, kind in KINDS.items() if type_name.startswith(start))
    single = joint.nv == 1 and kind != "composite"
    limits = (-np.inf, np.inf)
    # A joint of which q is a cosine and a sine has no limits.
    if single and joint.nq == 1:
        lower = model.lowerPositionLimit[joint.idx_q]
        limits = (float(lower), float(model.upperPositionLimit[joint.idx_q]))
    return Joint(
        name=model.names[number],
        kind=kind,
        axis=_axis(joint) if single else None,
        parent=int(model.parents[number]) - 1,
        rotation=read_only(placement.rotation),
        offset=read_only(placement.translation),
        q=slice(joint.idx_q, joint.idx_q + joint.nq),
        v=slice(joint.idx_v, joint.idx_v + joint.nv),
        limits=limits,
        parts=_parts(model, joint, number, placement) if kind == "composite" else (),
    )


def _axis(joint: Any) -> Array:
    """The axis (3,) of a joint of one degree of freedom.

    The motion subspace S (6,) is [0; axis] of a revolute, [axis; 0] of a prismatic joint.
    """
    data = joint.createData()
    joint.calc(data, np.zeros(joint.idx_q + joint.nq), np.zeros(joint.idx_v + 1))
    twist = np.asarray(data.S, dtype=float).ravel()
    linear, angular = twist[:3], twist[3:]
    return read_only(angular if angular.any() else linear)


def _parts(model: pin.Model, joint: Any, number: int, placement: pin.SE3) -> tuple[Joint, ...]:
    """The parts of a composite joint, each placed in the part before, the first in the parent."""
    composite = joint.extract()
    first, *after = composite.jointPlacements.tolist()
    names = model.names[number].split("+")
    parts: list[Joint] = []
    for part, step, name in zip(composite.joints, [placement * first, *after], names, strict=True):
        parts.append(_joint(model, part, number, step)._replace(name=name))
    return tuple(parts)
