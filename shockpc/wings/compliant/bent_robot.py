"""A robot with links that bend: one with more bodies, rigid segments of links, and with joints that
have springs between these.

The segments have the frame of their body, in which points, axes and centres of mass stay what they
are.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from shockpc.core.frozen import frozen
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, freeze, read_only
from shockpc.robot.feet_and_sensors import feet
from shockpc.robot.robot import Robot
from shockpc.robot.tolerances import inertia_fault
from shockpc.text.errors import RobotError
from shockpc.wings.compliant.motion.segments import FINE, Division, Flex, bending_stiffness, divide

SHORT = 0.5
"""Share of a body's radius of gyration, up to which the distance of two joints does not give its
axis.
"""

ROUNDING = 1e-9
"""Distance [m] by which what is at a hinge may be before it and still moves with the segment
behind.
"""

MOST_SPRINGS = 240
"""Springs in the hinges of all links; a landing of so many takes up to a minute and 0.5 GB."""

LEAVE_OUT = "leave it out of flex, with patterns that do not fit it"
"""What to do with a link that cannot bend."""


@frozen()
class FlexibleRobot:
    """A robot whose links bend.

    Attributes:
        robot: with a body for each segment and a joint for each hinge; the names of both begin with
            "~".
        stiffness: (nv,) of the springs of hinges [N m/rad, N/m]; zero of the other velocities.
        q: (nq,) where the coordinates of the robot that was given are among those of this one.
        v: (nv,) the same of its velocities.
        segments: of each body of the robot that was given, the bodies from its joint on; one,
            unless it bends.
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

        Args: body, of the robot that was given, −1 for the world; point (3,) in its frame.
        """
        return body if body < 0 else self.segments[body][_segment(self.divisions, body, point)]

    def configuration(self, q: Array) -> Array:
        """The configuration with straight links. Args: q (nq,) of the robot that was given."""
        return _straight(self.robot.model, self.q, q)

    def velocities(self, values: np.ndarray, of_hinges: float = 0.0) -> np.ndarray:
        """Values (nv,) of all velocities.

        Args: values, of those of the robot that was given; of_hinges, of the hinges.
        """
        whole = np.full(len(self.stiffness), of_hinges, dtype=values.dtype)
        whole[self.v] = values
        return whole


@memoized(most=8)
def flexible_robot(
    robot: Robot,
    links: tuple[tuple[str, Flex], ...],
    ends: tuple[tuple[int, tuple[float, ...]], ...] = (),
    rotors: tuple[tuple[int, float], ...] = (),
) -> FlexibleRobot:
    """A robot of which some links bend.

    A link, with all that is fixed to it, bends between its joint and the farthest joint that it
    carries, foot, or other end that is given. The base, and a link without these, bend along their
    longest axis.

    Args:
        robot: the robot; it stays as it is.
        links: how they bend, each with its name or a glob; of two that fit a link the latter.
        ends: further places up to which a body bends: its index, and (3,) in its frame [m].
        rotors: inertia of each rotor that a link carries [kg m²], with the index of the body that
            it drives.

    Raises:
        UnknownName: a pattern fits no link.
        RobotError: a link has no mass, or an inertia that no body has, or not that of the rotors
            that it carries.
    """
    flexes = {body: flex for pattern, flex in links for body in robot.match_bodies(pattern)}
    if (count := sum(flex.springs for flex in flexes.values())) > MOST_SPRINGS:
        raise RobotError(
            f"links would bend with {count} springs in their hinges, and up to {MOST_SPRINGS} are "
            f"computed; name fewer links, or "
            "give them fewer hinges"
        )
    lines = {
        body: _line(robot, body, [np.array(end) for number, end in ends if number == body])
        for body in flexes
    }
    for number, flex in flexes.items():
        if flex.clamped and robot.joints[number].kind == "free":
            raise RobotError(
                f'link "{robot.bodies[number].name}" is the free base and has no joint at which it '
                f"can be clamped; give its "
                "frequency with both ends free, such as 180Hz:free, or its EI"
            )
    divisions = {
        body: _divide(robot, body, lines[body], flex.hinges) for body, flex in flexes.items()
    }
    for driven, inertia in rotors:
        if robot.parents[driven] in divisions:
            divisions[robot.parents[driven]] = _with_rotor(robot, divisions, driven, inertia)
    old, new = robot.model, pin.Model()
    new.name = old.name
    # The joints of the new model that move each segment of each body, and the stiffness of those
    # that are hinges.
    joints, springs = {(-1, 0): 0}, dict[int, Array]()
    for k, segment in _order(robot, divisions):
        body = robot.bodies[k]
        if segment == 0:
            carrier, place = _on_segment(
                robot, divisions, robot.parents[k], old.jointPlacements[body.joint]
            )
            number = new.addJoint(
                joints[robot.parents[k], carrier],
                old.joints[body.joint],
                place,
                old.names[body.joint],
            )
        else:
            flex, division = flexes[k], divisions[k]
            place = _frame(robot, divisions, k, segment - 1) * pin.SE3(
                np.eye(3), division.places[segment - 1]
            )
            number = new.addJoint(
                joints[k, segment - 1], *_hinge(flex, division, place, f"~{k}.{segment}")
            )
            springs[number] = _springs(robot, k, flex, lines[k]) / division.spacing
            frame = pin.Frame(
                f"~{k}.{segment}",
                number,
                0,
                _frame(robot, divisions, k, segment),
                pin.FrameType.BODY,
            )
            new.addFrame(frame, False)
        joints[k, segment] = number
        if k in divisions:
            parts = divisions[k]
            inertia = pin.Inertia(
                float(parts.mass[segment]), parts.com[segment], parts.inertia[segment]
            )
            new.appendBodyToJoint(number, inertia, _frame(robot, divisions, k, segment))
        else:
            new.appendBodyToJoint(number, old.inertias[body.joint], pin.SE3.Identity())
    for frame in old.frames[1:]:
        k, carrier, place = frame.parentJoint - 1, 0, frame.placement
        if k < 0 or frame.name != robot.bodies[k].name:  # that of the body is the first segment's
            carrier, place = _on_segment(robot, divisions, k, frame.placement)
        new.addFrame(pin.Frame(frame.name, joints[k, carrier], 0, place, frame.type), False)

    numbers = [joints[k, 0] for k in range(len(robot.bodies))]
    sizes = (new.idx_qs, new.nqs), (new.idx_vs, new.nvs)
    q, v = (
        np.concatenate([first[n] + np.arange(size[n]) for n in numbers]) for first, size in sizes
    )
    _copy_values(old, new, q, v)
    stiffness = np.zeros(new.nv)
    for number, of_hinge in springs.items():
        stiffness[new.idx_vs[number] + np.arange(len(of_hinge))] = of_hinge
    segments = tuple(
        tuple(
            joints[k, segment] - 1
            for segment in range(len(divisions[k].mass) if k in divisions else 1)
        )
        for k in range(len(robot.bodies))
    )
    start, relaxed = (
        None if part is None else read_only(_straight(new, q, part))
        for part in (robot.start, robot.relaxed)
    )
    assert start is not None
    whole = replace(robot, model=new, start=start, relaxed=relaxed, postures={}, loops=())
    freeze(stiffness, q, v, divisions)
    return FlexibleRobot(whole, stiffness, q, v, segments, divisions)


def _springs(robot: Robot, body: int, flex: Flex, line: tuple[Array, Array]) -> Array:
    """The bending stiffness of a body about both axes, and those of torsion and stretch that are
    given [N m², N].
    """
    EI = flex.EI
    if flex.frequency is not None:
        EI = bending_stiffness(flex.frequency, flex.clamped, _divide(robot, body, line, FINE))
    return np.array([value for value in (EI, EI, flex.GJ, flex.EA) if value is not None])


def _copy_values(old: pin.Model, new: pin.Model, q: np.ndarray, v: np.ndarray) -> None:
    """Copy limits, rotors and damping of the joints, whose coordinates are at q and velocities at v
    in the new model.
    """
    for where, names in (
        (q, ("lowerPositionLimit", "upperPositionLimit")),
        (v, ("armature", "damping")),
    ):
        for name in names:
            values = np.array(getattr(new, name))
            values[where] = getattr(old, name)
            setattr(new, name, values)


def _order(robot: Robot, divisions: Mapping[int, Division]) -> Iterator[tuple[int, int]]:
    """Bodies and their segments, each before all that it carries, and that before all else, as
    Pinocchio needs them.
    """
    carried: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for k, (body, parent) in enumerate(zip(robot.bodies, robot.parents, strict=True)):
        segment, _ = _on_segment(robot, divisions, parent, robot.model.jointPlacements[body.joint])
        carried.setdefault((parent, segment), []).append((k, 0))
    for k, division in divisions.items():
        for segment in range(1, len(division.mass)):
            carried.setdefault((k, segment - 1), []).append((k, segment))
    waiting = carried.pop((-1, 0))[::-1]
    while waiting:
        yield waiting[-1]
        waiting += carried.pop(waiting.pop(), [])[::-1]


def _straight(model: pin.Model, where: np.ndarray, q: Array) -> Array:
    whole = pin.neutral(model)
    whole[where] = q
    return np.asarray(whole)


def _segment(divisions: Mapping[int, Division], body: int, point: Array) -> int:
    """The segment that a point (3,) of a body is on."""
    if body not in divisions:
        return 0
    return int(
        np.searchsorted(
            divisions[body].along, divisions[body].axis @ point + ROUNDING, side="right"
        )
    )


def _frame(robot: Robot, divisions: Mapping[int, Division], body: int, segment: int) -> pin.SE3:
    """The frame of a body in that of the joint, or hinge, that moves a segment."""
    if segment == 0:
        return pin.SE3(robot.bodies[body].rotation, robot.bodies[body].offset)
    return pin.SE3(np.eye(3), -divisions[body].places[segment - 1])


def _on_segment(
    robot: Robot, divisions: Mapping[int, Division], body: int, place: pin.SE3
) -> tuple[int, pin.SE3]:
    """The segment that carries what is at a place in the frame of a body's joint, and that place in
    its joint's or hinge's.
    """
    if body not in divisions:
        return 0, place
    inside = _frame(robot, divisions, body, 0).actInv(place)
    segment = _segment(divisions, body, inside.translation)
    return segment, _frame(robot, divisions, body, segment) * inside if segment else place


def _hinge(
    flex: Flex, division: Division, place: pin.SE3, name: str
) -> tuple[pin.JointModelComposite, pin.SE3, str]:
    """A hinge, its place in the frame of the joint that carries it, and the names of its parts."""
    hinge, names = pin.JointModelComposite(), ["y", "z"]
    for axis in division.across:
        hinge.addJoint(pin.JointModelRevoluteUnaligned(axis))
    if flex.GJ is not None:
        names.append("x")
        hinge.addJoint(pin.JointModelRevoluteUnaligned(division.axis))
    if flex.EA is not None:
        names.append("s")
        hinge.addJoint(pin.JointModelPrismaticUnaligned(division.axis))
    return hinge, place, "+".join(f"{name}{part}" for part in names)


def _line(robot: Robot, body: int, ends: Sequence[Array]) -> tuple[Array, Array]:
    """Where a body begins to bend and where it ends, in its frame [m].

    Args: ends, places of it besides joints and feet.
    """
    one = robot.bodies[body]
    fault = inertia_fault(one.mass, one.inertia) if one.mass > 0.0 else "it has no mass"
    if fault:
        raise RobotError(
            f'link "{one.name}" cannot bend, because {fault}; correct its inertia in the file, or '
            f"{LEAVE_OUT}"
        )
    place = _frame(robot, {}, body, 0)
    start = place.actInv(np.zeros(3))
    joints = [
        robot.model.jointPlacements[robot.bodies[k].joint]
        for k, parent in enumerate(robot.parents)
        if parent == body
    ]
    places = [place.actInv(joint.translation) for joint in joints]
    places += [robot.frames[name].offset for name in feet(robot) if robot.frames[name].body == body]
    end = max(
        (*places, *ends), key=lambda point: float(np.linalg.norm(point - start)), default=start
    )
    if (
        robot.joints[body].kind != "free"
        and np.linalg.norm(end - start) > SHORT * robot.gyration[body]
    ):
        return start, np.asarray(end)
    moments, axes = np.linalg.eigh(one.inertia)
    half = np.sqrt(3.0 * (0.5 * moments.sum() - moments[0]) / one.mass) * axes[:, 0]
    half *= 1.0 if half @ (one.com - start) >= 0.0 else -1.0
    return one.com - half, one.com + half


def _with_rotor(
    robot: Robot, divisions: Mapping[int, Division], driven: int, inertia: float
) -> Division:
    """The segments of a body where that at the joint of a rotor has its inertia about its axis, of
    what all had of it.

    Args:
        robot: the robot.
        divisions: of its bodies.
        driven: index of the body that the rotor drives.
        inertia: of the rotor [kg m²].

    Raises:
        RobotError: all segments together have less.
    """
    joint, body = robot.joints[driven], robot.bodies[robot.parents[driven]]
    division = divisions[joint.parent]
    assert joint.axis is not None
    axis = body.rotation.T @ joint.rotation @ joint.axis
    moments = division.inertia @ axis @ axis
    if not inertia < moments.sum():
        raise RobotError(
            f'link "{body.name}" cannot bend, because it has less inertia than the rotor of joint '
            f'"{joint.name}" that it '
            f"carries; leave its gear out (--no-carried), or {LEAVE_OUT}"
        )
    change = -moments / moments.sum()
    change[
        _on_segment(
            robot, divisions, joint.parent, robot.model.jointPlacements[robot.bodies[driven].joint]
        )[0]
    ] += 1.0
    return division._replace(
        inertia=division.inertia + inertia * change[:, None, None] * np.outer(axis, axis)
    )


def _divide(robot: Robot, body: int, line: tuple[Array, Array], hinges: int) -> Division:
    one = robot.bodies[body]
    try:
        return divide(one.mass, one.com, one.inertia, *line, hinges)
    except ValueError as refusal:
        raise RobotError(
            f'link "{one.name}" cannot bend, because it {refusal}; {LEAVE_OUT}'
        ) from None
