"""A second, independent reader of a URDF: yourdfpy.

The kinematics are composed here from what it read.

Nothing else imports this module, because importing yourdfpy takes a second.
"""

import copy
import io
import logging
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple
from xml.etree.ElementTree import tostring

import numpy as np
import pinocchio as pin
import yourdfpy

from shockpc.core.spatial import Array
from shockpc.robot.bodies_and_joints import Mimic
from shockpc.robot.files.reading import shared_xml
from shockpc.robot.robot import Robot
from shockpc.text.errors import RobotError
from shockpc.text.printed import listed

TOLERANCE = 1e-12
"""Difference up to which numbers agree, relative to their size where that is above 1."""

CONFIGURATIONS = 3
_KINDS = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "planar": "planar",
    "floating": "free",
}


class SecondReading(NamedTuple):
    """The reading of a URDF by yourdfpy, compared with the robot that is computed.

    Attributes:
        links: number of links that it reads.
        joints: number of joints, fixed ones included.
        largest: the largest difference of a placement, in rotation matrices and metres, relative to
            distances above 1 m.
        differences: what does not agree, by the name of the link or joint.
        faults: what yourdfpy's `validate` finds.
    """

    links: int
    joints: int
    largest: float
    differences: tuple[str, ...]
    faults: tuple[str, ...]


def second_reading(robot: Robot) -> SecondReading:
    """Read the URDF of a robot a second time, and compare the two readings.

    Compared are links, joints, limits, mimics, inertias and placements of links.

    Placements are compared at random configurations, with the base where it starts.

    Raises:
        RobotError: the robot is not of a URDF, or yourdfpy cannot read it.
    """
    if robot.source.kind != "urdf":
        raise RobotError("only a URDF is read a second time")
    root = copy.deepcopy(shared_xml(robot.source.xml, robot.source.path.name))
    root.set("name", robot.name)
    for element in root.iter():  # undeclared prefixes, such as those of xacro, are not read by lxml
        element[:] = [child for child in element if ":" not in child.tag]
        for key in [key for key in element.attrib if ":" in key]:
            del element.attrib[key]
    logger = logging.getLogger("yourdfpy.urdf")
    logger.disabled = True  # it writes to standard error
    try:
        urdf = yourdfpy.URDF.load(
            io.BytesIO(tostring(root)), load_meshes=False, build_scene_graph=False
        )
        urdf.validate()
    except (ValueError, KeyError, AttributeError, TypeError, IndexError) as refusal:
        raise RobotError(f"yourdfpy cannot read it ({type(refusal).__name__}: {refusal})") from None
    finally:
        logger.disabled = False
    record = urdf.robot
    joints = {joint.name: joint for joint in record.joints}
    differences = [*_names(robot, record), *_joints(robot, joints), *_inertias(robot, record)]
    largest, apart = 0.0, ""
    generator = np.random.default_rng(0)
    # Where names or joints differ already, placements cannot be compared.
    for _ in range(0 if differences else CONFIGURATIONS):
        for link, error in _placement_errors(robot, record, generator):
            if error > largest or np.isnan(error):
                largest, apart = error, link
    # `not <=`, so that NaN is a difference too.
    if not largest <= TOLERANCE:
        differences.append(
            f'link "{apart}" stands {largest:.2g} elsewhere at a random configuration'
        )
    faults = tuple(f"{count} × {text}" for text, count in Counter(map(str, urdf.errors)).items())
    return SecondReading(len(record.links), len(joints), largest, tuple(differences), faults)


def _names(robot: Robot, record: Any) -> Iterator[str]:
    """Links and joints that only one of the readers has."""
    frames = robot.model.frames
    links = {frame.name for frame in frames if frame.type == pin.FrameType.BODY}
    moving = {joint.name for joint in robot.single_joints} - {"root_joint"}
    fixed = {frame.name for frame in frames if frame.type == pin.FrameType.FIXED_JOINT}
    fixed.discard("universe")
    their_links = {link.name for link in record.links}
    their_moving = {joint.name for joint in record.joints if joint.type != "fixed"}
    their_fixed = {joint.name for joint in record.joints if joint.type == "fixed"}
    for kind, ours, theirs in (
        ("links", links, their_links),
        ("moving joints", moving, their_moving),
        ("fixed joints", fixed, their_fixed),
    ):
        for only, missing in (("this", ours - theirs), ("the second", theirs - ours)):
            if missing:
                yield f"{kind} that only {only} reader has: {listed(sorted(missing), 4)}"


def _joints(robot: Robot, joints: Mapping[str, Any]) -> Iterator[str]:
    """Differences of the joints: their kinds, limits and followers."""
    rules = {mimic.joint: mimic for mimic in robot.mimics}
    for joint in robot.single_joints:
        record = joints.get(joint.name)
        if record is None:
            continue
        # a planar joint of the base is computed as a floating one
        base = robot.free_base and joint is robot.joints[0]
        if _KINDS.get(record.type) != joint.kind and not base:
            yield f'joint "{joint.name}" is {joint.kind} here and {record.type} there'
        if joint.kind in ("revolute", "prismatic"):
            limits = _limits(record, joint.limits)
            if limits != joint.limits:
                yield f'joint "{joint.name}" has limits {joint.limits} here and {limits} there'
        if not _same_rule(rules.get(joint.name), joint.name, record.mimic, joints):
            yield (
                f'joint "{joint.name}" mimics another joint in another way, or one of the readers '
                f"has no mimic"
            )


def _limits(joint: Any, unwritten: tuple[float, float]) -> tuple[float, float]:
    """The limits of a joint as yourdfpy has them; a single one that is not written is zero.

    Args:
        joint: of yourdfpy.
        unwritten: the limits where none is written.
    """
    lower, upper = joint.limit.lower, joint.limit.upper
    if lower is None and upper is None:
        return unwritten
    return lower or 0.0, upper or 0.0


def _same_rule(rule: Mimic | None, joint: str, mimic: Any, joints: Mapping[str, Any]) -> bool:
    """True if a joint follows others by the same rule in both readers.

    Args:
        rule: of our reader.
        joint: name of the joint.
        mimic: of yourdfpy.
        joints: of yourdfpy, by name.
    """
    if mimic is not None and (mimic.joint == joint or mimic.joint not in joints):
        mimic = None  # of which the reader of the file warns
    if rule is None or mimic is None:
        return rule is None and mimic is None
    leaders = {mimic.joint: mimic.multiplier}
    if joints[mimic.joint].type == "fixed":
        leaders = {}
    return (rule.leaders, rule.offset) == (leaders, mimic.offset)


def _inertias(robot: Robot, record: Any) -> Iterator[str]:
    """Differences of the masses, centres of mass and inertias of links."""
    ours = {}
    for frame in robot.model.frames:
        if frame.type == pin.FrameType.BODY:
            ours[frame.name] = frame.inertia
    for link in record.links:
        inertia = ours.get(link.name)
        if inertia is None:
            continue
        mass, placement, tensor = 0.0, np.eye(4), np.zeros((3, 3))
        if link.inertial is not None:
            mass = link.inertial.mass
            if link.inertial.origin is not None:
                placement = link.inertial.origin
            R = placement[:3, :3]
            tensor = R @ link.inertial.inertia @ R.T
        for quantity, here, there in (
            ("mass", inertia.mass, mass),
            ("centre of mass", inertia.lever, placement[:3, 3]),
            ("inertia", inertia.inertia, tensor),
        ):
            tolerance = TOLERANCE * max(1.0, np.abs(there).max())
            if not np.allclose(here, there, rtol=0.0, atol=tolerance):
                yield f'link "{link.name}" has another {quantity} there'


def _placement_errors(
    robot: Robot, record: Any, generator: np.random.Generator
) -> Iterator[tuple[str, float]]:
    """Difference of the placement of every link at one random configuration.

    It is relative to distances above 1 m.
    """
    values = {}
    for joint in robot.single_joints:
        if joint.axis is not None:
            values[joint.name] = float(generator.uniform(-2.0, 2.0))
    for mimic in robot.mimics:
        led = [by * values[name] for name, by in mimic.leaders.items()]
        values[mimic.joint] = sum(led, mimic.offset)
    q = np.array(robot.start)
    for joint in robot.single_joints:
        if joint.axis is not None:
            joint.set(values[joint.name], q)
    joints = robot.joint_placements(q)

    # The second reader's root link stands where it is here.
    children = {joint.child for joint in record.joints}
    (root,) = [link.name for link in record.links if link.name not in children]
    for name, there in _placed(record, root, _placement(robot, joints, root), values).items():
        here = _placement(robot, joints, name)
        yield name, float(np.abs(here - there).max() / max(1.0, np.abs(there).max()))


def _placement(robot: Robot, joints: list[pin.SE3], link: str) -> Array:
    """The placement (4, 4) of a link in the world."""
    frame = robot.model.frames[robot.model.getFrameId(link, pin.FrameType.BODY)]
    return np.array(joints[frame.parentJoint] * frame.placement)


def _placed(
    record: Any, root: str, root_placement: Array, values: Mapping[str, float]
) -> dict[str, Array]:
    """The placement (4, 4) of every link by the joints of the second reader.

    Args:
        record: of yourdfpy.
        root: link that no joint carries.
        root_placement: (4, 4) of it.
        values: of the joints [rad, m].
    """
    below: dict[str, list[Any]] = {}
    for joint in record.joints:
        below.setdefault(joint.parent, []).append(joint)
    placements = {root: root_placement}
    waiting = [root]
    while waiting:
        link = waiting.pop()
        for joint in below.get(link, ()):
            motion = np.eye(4)
            if joint.type in ("revolute", "continuous"):
                motion = yourdfpy.urdf.tra.rotation_matrix(values[joint.name], joint.axis)
            elif joint.type == "prismatic":
                motion[:3, 3] = values[joint.name] * joint.axis / np.linalg.norm(joint.axis)
            origin = np.eye(4) if joint.origin is None else joint.origin
            placements[joint.child] = placements[link] @ origin @ motion
            waiting.append(joint.child)
    return placements
