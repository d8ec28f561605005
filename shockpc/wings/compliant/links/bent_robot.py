"""A robot with links that bend, as a robot with more bodies and joints.

The bodies are rigid segments of links, and the joints between these have springs.

The segments have the frame of their body, in which points, axes and centres of mass stay what they
are.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.frozen import frozen
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze, read_only
from shockpc.robot.feet_and_sensors import feet
from shockpc.robot.robot import Robot
from shockpc.robot.tolerances import inertia_fault
from shockpc.text.errors import RobotError
from shockpc.wings.compliant.links.flexes import Flex, flexes_by_body
from shockpc.wings.compliant.links.segments import FINE, Division, bending_stiffness, divide

SHORT = 0.5
"""Distance from a body's joint to its end, in radii of gyration, up to which it gives no axis."""

ROUNDING = 1e-9
"""Distance of a point before a hinge with which it still moves with the segment behind [m]."""

MOST_SPRINGS = 240
"""Springs in the hinges of all links; a landing of so many takes up to a minute and 0.5 GB."""

LEAVE_OUT = "leave it out of flex, with patterns that do not fit it"
"""Advice for a link that cannot bend."""


@frozen()
class FlexibleRobot:
    """A robot whose links bend.

    Attributes:
        robot: with a body for each segment and a joint for each hinge; the names of both begin with
            "~".
        stiffness: (nv,) of the springs of hinges [N m/rad, N/m]; zero of the other velocities.
        q: (nq,) where the coordinates of the rigid robot are among those of this one.
        v: (nv,) the same of its velocities.
        segments: of each body of the rigid robot, the bodies from its joint on; one, unless it
            bends.
        divisions: of each body that bends, by its index.
    """

    robot: Robot
    stiffness: Array
    q: np.ndarray
    v: np.ndarray
    segments: tuple[tuple[int, ...], ...]
    divisions: Mapping[int, Division]

    @property
    def hinges(self) -> np.ndarray:
        """The velocities of the hinges."""
        return np.flatnonzero(self.stiffness)

    def body_at(self, body: int, point: Array) -> int:
        """The body that a point moves with.

        Args: body, of the rigid robot, −1 for the world; point (3,) in its frame.
        """
        return body if body < 0 else self.segments[body][_segment(self.divisions, body, point)]

    def configuration(self, q: Array) -> Array:
        """The configuration with straight links. Args: q (nq,) of the rigid robot."""
        return _straight(self.robot.model, self.q, q)

    def velocities(self, values: np.ndarray, of_hinges: float = 0.0) -> np.ndarray:
        """Values (nv,) of all velocities.

        Args: values, of those of the rigid robot; of_hinges, of the hinges.
        """
        of_all = np.full(len(self.stiffness), of_hinges, dtype=values.dtype)
        of_all[self.v] = values
        return of_all


@memoized(most=8)
def flexible_robot(
    robot: Robot,
    links: tuple[tuple[str, Flex], ...],
    ends: tuple[tuple[int, tuple[float, ...]], ...] = (),
    rotors: tuple[tuple[int, float], ...] = (),
) -> FlexibleRobot:
    """A robot of which some links bend.

    A link, with all that is fixed to it, bends between its joint and the farthest joint that it
    carries, foot, or further end. The base, and a link without these, bend along their longest
    axis.

    Args:
        robot: the robot; it stays as it is.
        links: how they bend, each with its name or a glob; of two that fit a link the latter.
        ends: further points up to which a body bends: its index, and (3,) in its frame [m].
        rotors: inertia of each rotor that a link carries [kg m²], with the index of the body that
            it drives.

    Raises:
        UnknownName: a pattern fits no link.
        RobotError: a link has no mass, or an inertia that no body has, or not that of the rotors
            that it carries.
    """
    flexes = flexes_by_body(robot, links)
    _refuse(robot, flexes)
    lines = {}
    for body in flexes:
        of_body = [np.array(end) for number, end in ends if number == body]
        lines[body] = _line(robot, body, of_body)

    divisions = {}
    for body, flex in flexes.items():
        divisions[body] = _divide(robot, body, lines[body], flex.hinges)
    divided = _Divided(robot, divisions)
    # A rotor sits at its joint: the segment there has the inertia that all segments had of it.
    for driven, inertia in rotors:
        carrier = robot.parents[driven]
        if carrier in divisions:
            divisions[carrier] = _with_rotor(divided, driven, inertia)

    built = _Model(divided)
    for k, segment in divided.order():
        if segment == 0:
            built.add_body(k)
        else:
            # Each hinge stands for the bending of one spacing: k = EI / spacing.
            springs = _springs(robot, k, flexes[k], lines[k]) / divisions[k].spacing
            built.add_segment(k, segment, flexes[k], springs)
    built.add_frames()

    # In the robot's own postures the links are straight.
    model, q, v = built.model, *built.indices()
    _copy_values(robot.model, model, q, v)
    start = read_only(_straight(model, q, robot.start))
    relaxed = None
    if robot.relaxed is not None:
        relaxed = read_only(_straight(model, q, robot.relaxed))
    bent = replace(robot, model=model, start=start, relaxed=relaxed, postures={}, loops=())
    stiffness = built.stiffness()
    # Landings share a robot, so that its arrays must not change.
    freeze(stiffness, q, v, divisions)
    return FlexibleRobot(bent, stiffness, q, v, built.segments(), divisions)


def _refuse(robot: Robot, flexes: Mapping[int, Flex]) -> None:
    """Refuse more springs than are computed.

    A frequency of the free base with its joint held is refused too.
    """
    count = sum(flex.springs for flex in flexes.values())
    if count > MOST_SPRINGS:
        raise RobotError(
            f"links would bend with {count} springs in their hinges, and up to {MOST_SPRINGS} are "
            f"computed; name fewer links, or give them fewer hinges"
        )
    for number, flex in flexes.items():
        if flex.clamped and robot.joints[number].kind == "free":
            raise RobotError(
                f'link "{robot.bodies[number].name}" is the free base and has no joint at which it '
                f"can be clamped; give its frequency with both ends free, such as 180Hz:free, or "
                f"its EI"
            )


class _Divided(NamedTuple):
    """A robot with rigid links, and the divisions of its bodies that bend, by their index."""

    robot: Robot
    divisions: Mapping[int, Division]

    def frame(self, body: int, segment: int) -> pin.SE3:
        """The frame of a body in that of the joint, or hinge, that moves a segment."""
        if segment == 0:
            return _frame(self.robot, body)
        return pin.SE3(np.eye(3), -self.divisions[body].hinges[segment - 1])

    def on_segment(self, body: int, placement: pin.SE3) -> tuple[int, pin.SE3]:
        """The segment that carries what has a placement on a body, and the placement on it.

        The placement is in the frame of the body's joint, the result in that of the segment's joint
        or hinge.
        """
        if body not in self.divisions:
            return 0, placement
        inside = self.frame(body, 0).actInv(placement)
        segment = _segment(self.divisions, body, inside.translation)
        if segment == 0:
            return 0, placement
        return segment, self.frame(body, segment) * inside

    def carrier(self, body: int) -> int:
        """The segment of its parent that carries a body."""
        joint = self.robot.bodies[body].joint
        placement = self.robot.model.jointPlacements[joint]
        return self.on_segment(self.robot.parents[body], placement)[0]

    def order(self) -> Iterator[tuple[int, int]]:
        """Bodies and their segments in the order that Pinocchio needs.

        Each comes before all that it carries, and that before all else.
        """
        carried: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for body, parent in enumerate(self.robot.parents):
            carried.setdefault((parent, self.carrier(body)), []).append((body, 0))
        for body, division in self.divisions.items():
            for segment in range(1, len(division.mass)):
                carried.setdefault((body, segment - 1), []).append((body, segment))
        waiting = carried.pop((-1, 0))[::-1]
        while waiting:
            yield waiting[-1]
            waiting += carried.pop(waiting.pop(), [])[::-1]


class _Model:
    """The model with segments, as it is built; whatever carries is added before what it carries.

    Args:
        divided: the robot and its divisions.

    Attributes:
        model: with what has been added.
    """

    def __init__(self, divided: _Divided) -> None:
        self._divided = divided
        self._robot, self._divisions = divided
        self.model = pin.Model()
        self.model.name = self._robot.model.name
        # The joints that move each segment of each body, and the stiffness of those that are
        # hinges.
        self._joints = {(-1, 0): 0}
        self._springs = dict[int, Array]()

    def add_body(self, k: int) -> None:
        """Add body k at its joint; its first segment where it bends."""
        robot, old = self._robot, self._robot.model
        joint, parent = robot.bodies[k].joint, robot.parents[k]
        placement = old.jointPlacements[joint]
        carrier, placement = self._divided.on_segment(parent, placement)
        moved_by = self._joints[parent, carrier]
        number = self.model.addJoint(moved_by, old.joints[joint], placement, old.names[joint])
        self._joints[k, 0] = number
        if k in self._divisions:
            self._add_inertia(number, k, 0)
        else:
            self.model.appendBodyToJoint(number, old.inertias[joint], pin.SE3.Identity())

    def add_segment(self, k: int, segment: int, flex: Flex, springs: Array) -> None:
        """Add a segment of body k at the hinge before it, with the stiffness of its springs."""
        division, name = self._divisions[k], f"~{k}.{segment}"
        at = pin.SE3(np.eye(3), division.hinges[segment - 1])
        placement = self._divided.frame(k, segment - 1) * at
        hinge, names = _hinge(flex, division, name)
        number = self.model.addJoint(self._joints[k, segment - 1], hinge, placement, names)
        self._joints[k, segment] = number
        self._springs[number] = springs
        frame = self._divided.frame(k, segment)
        self.model.addFrame(pin.Frame(name, number, 0, frame, pin.FrameType.BODY), False)
        self._add_inertia(number, k, segment)

    def _add_inertia(self, number: int, k: int, segment: int) -> None:
        """Give a joint the inertia of a segment."""
        parts = self._divisions[k]
        mass, com = float(parts.mass[segment]), parts.com[segment]
        inertia = pin.Inertia(mass, com, parts.inertia[segment])
        frame = self._divided.frame(k, segment)
        self.model.appendBodyToJoint(number, inertia, frame)

    def add_frames(self) -> None:
        """Add the frames of the robot, each on the segment that it moves with.

        That of a body is the first segment's.
        """
        robot = self._robot
        for frame in robot.model.frames[1:]:
            k, carrier, placement = frame.parentJoint - 1, 0, frame.placement
            if k < 0 or frame.name != robot.bodies[k].name:
                carrier, placement = self._divided.on_segment(k, placement)
            joint = self._joints[k, carrier]
            self.model.addFrame(pin.Frame(frame.name, joint, 0, placement, frame.type), False)

    def indices(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of the coordinates (nq,) and velocities (nv,) of the robot in the model."""
        q, v = list[np.ndarray](), list[np.ndarray]()
        for k in range(len(self._robot.bodies)):
            joint = self.model.joints[self._joints[k, 0]]
            q.append(joint.idx_q + np.arange(joint.nq))
            v.append(joint.idx_v + np.arange(joint.nv))
        return np.concatenate(q), np.concatenate(v)

    def stiffness(self) -> Array:
        """Stiffness (nv,) of the springs of hinges; zero of other velocities."""
        stiffness = np.zeros(self.model.nv)
        for number, springs in self._springs.items():
            start = self.model.joints[number].idx_v
            stiffness[start : start + len(springs)] = springs
        return stiffness

    def segments(self) -> tuple[tuple[int, ...], ...]:
        """Segments of each body of the robot, as bodies of the model."""
        segments = []
        for k in range(len(self._robot.bodies)):
            count = len(self._divisions[k].mass) if k in self._divisions else 1
            joints = [self._joints[k, n] for n in range(count)]
            segments.append(tuple(joint - 1 for joint in joints))
        return tuple(segments)


def _springs(robot: Robot, body: int, flex: Flex, line: tuple[Array, Array]) -> Array:
    """The bending stiffness of a body about both axes [N m²].

    Those of torsion [N m²] and stretch [N] follow where they are given.
    """
    EI = flex.EI
    if flex.frequency is not None:
        EI = bending_stiffness(flex.frequency, flex.clamped, _divide(robot, body, line, FINE))
    return np.array([value for value in (EI, EI, flex.GJ, flex.EA) if value is not None])


def _copy_values(old: pin.Model, new: pin.Model, q: np.ndarray, v: np.ndarray) -> None:
    """Copy limits, rotors and damping of the joints.

    Their coordinates are at q and their velocities at v in the new model.
    """
    for indices, names in (
        (q, ("lowerPositionLimit", "upperPositionLimit")),
        (v, ("armature", "damping")),
    ):
        for name in names:
            values = np.array(getattr(new, name))
            values[indices] = getattr(old, name)
            setattr(new, name, values)


def _straight(model: pin.Model, indices: np.ndarray, q: Array) -> Array:
    """The configuration with straight links, whose coordinates at some indices are q."""
    configuration = pin.neutral(model)
    configuration[indices] = q
    return np.asarray(configuration)


def _segment(divisions: Mapping[int, Division], body: int, point: Array) -> int:
    """The segment that a point (3,) of a body is on."""
    if body not in divisions:
        return 0
    division = divisions[body]
    along = division.axis @ point + ROUNDING
    return int(np.searchsorted(division.along, along, side="right"))


def _frame(robot: Robot, body: int) -> pin.SE3:
    """The frame of a body in that of its joint."""
    return pin.SE3(robot.bodies[body].rotation, robot.bodies[body].offset)


def _hinge(flex: Flex, division: Division, name: str) -> tuple[pin.JointModelComposite, str]:
    """A hinge, and the names of its parts."""
    hinge, names = pin.JointModelComposite(), ["y", "z"]
    for axis in division.across:
        hinge.addJoint(pin.JointModelRevoluteUnaligned(axis))
    if flex.GJ is not None:
        names.append("x")
        hinge.addJoint(pin.JointModelRevoluteUnaligned(division.axis))
    if flex.EA is not None:
        names.append("s")
        hinge.addJoint(pin.JointModelPrismaticUnaligned(division.axis))
    return hinge, "+".join(f"{name}{part}" for part in names)


def _line(robot: Robot, body: int, ends: Sequence[Array]) -> tuple[Array, Array]:
    """Points where a body begins to bend and where it ends, in its frame [m].

    Args: ends, points of it besides joints and feet.
    """
    link = robot.bodies[body]
    fault = inertia_fault(link.mass, link.inertia) if link.mass > 0.0 else "it has no mass"
    if fault:
        raise RobotError(
            f'link "{link.name}" cannot bend, because {fault}; correct its inertia in the file, or '
            f"{LEAVE_OUT}"
        )
    frame = _frame(robot, body)
    start = frame.actInv(np.zeros(3))
    points = [*_carried(robot, body, frame), *ends]
    end = max(points, key=lambda point: float(np.linalg.norm(point - start)), default=start)
    long = np.linalg.norm(end - start) > SHORT * robot.gyration[body]
    if long and robot.joints[body].kind != "free":
        return start, np.asarray(end)
    # Along the longest axis, as far as a uniform rod of the same inertia: half length √(3 σ²),
    # σ² = (½ tr(I) − I₁) / m.
    moments, axes = np.linalg.eigh(link.inertia)
    half = np.sqrt(3.0 * (0.5 * moments.sum() - moments[0]) / link.mass) * axes[:, 0]
    if half @ (link.com - start) < 0.0:
        half = -half
    return link.com - half, link.com + half


def _carried(robot: Robot, body: int, frame: pin.SE3) -> list[Array]:
    """Joints and feet on a body, (3,) each in its frame [m]."""
    points = []
    for k, parent in enumerate(robot.parents):
        if parent == body:
            joint = robot.model.jointPlacements[robot.bodies[k].joint]
            points.append(frame.actInv(joint.translation))
    for name in feet(robot):
        if robot.frames[name].body == body:
            points.append(robot.frames[name].offset)
    return points


def _with_rotor(divided: _Divided, driven: int, inertia: float) -> Division:
    """The segments of a body with the inertia of a rotor at its joint.

    The segment there has it about its axis, of what all had of it.

    Args:
        divided: the robot and its divisions.
        driven: index of the body that the rotor drives.
        inertia: of the rotor [kg m²].

    Raises:
        RobotError: all segments together have less.
    """
    robot = divided.robot
    joint, body = robot.joints[driven], robot.bodies[robot.parents[driven]]
    division = divided.divisions[joint.parent]
    assert joint.axis is not None
    axis = body.rotation.T @ joint.rotation @ joint.axis
    moments = division.inertia @ axis @ axis
    if not inertia < moments.sum():
        raise RobotError(
            f'link "{body.name}" cannot bend, because it has less inertia than the rotor of joint '
            f'"{joint.name}" that it '
            f"carries; leave its gear out (--no-carried), or {LEAVE_OUT}"
        )
    share = -moments / moments.sum()
    share[divided.carrier(driven)] += 1.0
    change = inertia * share[:, None, None] * np.outer(axis, axis)
    return division._replace(inertia=division.inertia + change)


def _divide(robot: Robot, body: int, line: tuple[Array, Array], hinges: int) -> Division:
    """The segments of a body along a line. Raises: RobotError: it cannot be divided."""
    link = robot.bodies[body]
    try:
        return divide(link.mass, link.com, link.inertia, *line, hinges)
    except ValueError as refusal:
        raise RobotError(
            f'link "{link.name}" cannot bend, because it {refusal}; {LEAVE_OUT}'
        ) from None
