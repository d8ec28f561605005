"""A robot: URDF, xacro or MJCF in, moving bodies and frames out. What cannot be computed is refused by name."""

import fnmatch
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array
from shockpc.errors import RobotError, UnknownName
from shockpc.model.build import FREE_FLYER, build_model
from shockpc.model.markup import parse_markup
from shockpc.model.source import RobotSource, read_source
from shockpc.model.srdf import srdf_postures

__all__ = ["Body", "Frame", "Loop", "Mimic", "Robot", "load_robot"]

SITES = (pin.FrameType.OP_FRAME, pin.FrameType.SENSOR)


@dataclass(frozen=True)
class Body:
    """What moves as one: a link and all that is fixed to it.

    Attributes:
        name: the link that the body's moving joint carries; the root link for the base.
        joint: index of that joint in the Pinocchio model.
        links: every link of the body, its own name first.
        rotation: (3, 3) of the body frame in the joint's frame.
        offset: (3,) origin of the body frame in the joint's frame [m].
        mass: [kg]
        com: (3,) centre of mass in the body frame [m].
        inertia: (3, 3) about the centre of mass, axes of the body frame [kg m²].
    """

    name: str
    joint: int
    links: tuple[str, ...]
    rotation: Array = field(repr=False)
    offset: Array = field(repr=False)
    mass: float
    com: Array = field(repr=False)
    inertia: Array = field(repr=False)


@dataclass(frozen=True)
class Frame:
    """A named place on a body.

    Attributes:
        name: link, joint or site.
        body: index into `Robot.bodies`; −1 if it is fixed to the world.
        rotation: (3, 3) in the body frame.
        offset: (3,) origin in the body frame [m].
        kind: what the file calls it.
    """

    name: str
    body: int
    rotation: Array = field(repr=False)
    offset: Array = field(repr=False)
    kind: Literal["link", "joint", "site"]


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: q_joint = multiplier · q_leader + offset.

    Attributes:
        joint: the follower's name.
        leader: the name of the joint that it follows.
        multiplier: [1]
        offset: [rad, m]
    """

    joint: str
    leader: str
    multiplier: float
    offset: float


class Loop(NamedTuple):
    """Two bodies that are held together.

    Attributes:
        name: of the two ends.
        bodies: index of each end's body; −1 for the world.
        points: (3,) each end in its body's frame [m].
        rotations: (3, 3) each end's frame in its body's frame.
        axes: (n, 3) unit vectors along which the points are held, in the first end's frame.
        turns: whether the orientations are held too.
    """

    name: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    rotations: tuple[Array, Array]
    axes: Array
    turns: bool


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot ready to be struck.

    Attributes:
        name: as the file says.
        source: the file's text and where it came from.
        model: the Pinocchio model; its first joint is the base's if `free_base`.
        bodies: the moving bodies, base first, then in the order of the tree.
        frames: every named place, by name; where a link and a joint share a name it is the link's.
        postures: reference configurations by name, each (nq,).
        mimics: joints that follow others, each after the one that it follows.
        loops: what the file holds together beside the tree (MJCF connect and weld).
        free_base: whether the base can move (every URDF; an MJCF whose root body has a free joint).
        mass: of all bodies [kg].
        warnings: what the file's reader met.
    """

    name: str
    source: RobotSource = field(repr=False)
    model: pin.Model = field(repr=False)
    bodies: tuple[Body, ...] = field(repr=False)
    frames: Mapping[str, Frame] = field(repr=False)
    postures: Mapping[str, Array] = field(repr=False)
    mimics: tuple[Mimic, ...] = field(repr=False)
    loops: tuple[Loop, ...] = field(repr=False)
    free_base: bool
    mass: float
    warnings: tuple[str, ...] = field(repr=False)

    @property
    def links(self) -> tuple[str, ...]:
        """Every link that moves, in the order of the bodies."""
        return tuple(link for body in self.bodies for link in body.links)

    @property
    def label(self) -> str:
        """How a command names this robot: its catalogue name, else the path of its file."""
        return self.source.name or str(self.source.path)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints between bodies; the floating base's is not among them."""
        return tuple(self.model.names[body.joint] for body in self.bodies if not (self.free_base and body.joint == 1))

    def match_joints(self, pattern: str) -> tuple[str, ...]:
        """The joints that an exact name or a glob means.

        Raises:
            UnknownName: none fits.
        """
        known = self.joints
        found = (pattern,) if pattern in known else tuple(name for name in known if fnmatch.fnmatchcase(name, pattern))
        if not found:
            raise UnknownName("joint", pattern, known, f'robot "{self.name}"', f"shockpc robots {self.label}")
        return found

    def frame(self, name: str) -> Frame:
        """The frame of that exact name.

        Raises:
            UnknownName: there is none; the text names the nearest.
        """
        if name not in self.frames:
            raise UnknownName("frame", name, self.frames, f'robot "{self.name}"', f"shockpc robots {self.label}")
        return self.frames[name]


def load_robot(
    robot: str,
    *,
    xacro: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    srdf: str | None = None,
) -> Robot:
    """Load a robot from a file (URDF, xacro or MJCF, told by content) or by name.

    Args:
        robot: a path, or a name that `shockpc robots` lists.
        xacro: arguments of a xacro file.
        packages: folders of packages, for `package://` and `$(find …)`.
        srdf: a file of reference postures; by default the one found beside the robot.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, not physical, or reads outside its own folders.
    """
    source = read_source(robot, xacro=xacro or {}, packages=packages or {}, srdf=srdf)
    model, constraints = build_model(source)
    if model.njoints < 2:
        raise RobotError(f"{source.path.name}: nothing in it moves: it has no joint and no free base, so nothing can be struck")
    free_base = model.joints[1].shortname() == FREE_FLYER
    bodies = _bodies(model)
    frames = _frames(model, bodies)
    return Robot(
        name=source.robot_name,
        source=source,
        model=model,
        bodies=bodies,
        frames=frames,
        postures=_postures(source, model),
        mimics=_mimics(source, model),
        loops=_loops(constraints, bodies),
        free_base=free_base,
        mass=sum(body.mass for body in bodies),
        warnings=source.warnings,
    )


def _postures(source: RobotSource, model: pin.Model) -> dict[str, Array]:
    """Reference configurations: an MJCF's keyframes, or the group states of the SRDF beside a URDF."""
    if source.kind == "mjcf":
        return {entry.key(): _read_only(entry.data()) for entry in model.referenceConfigurations if entry.key() != "qpos0"}
    return {} if source.srdf is None else {n: _read_only(q) for n, q in srdf_postures(source.srdf, model).items()}


def _loops(constraints: list[Any], bodies: tuple[Body, ...]) -> tuple[Loop, ...]:
    """The loops that Pinocchio read, written in body frames."""
    loops = []
    for constraint in constraints:
        ends = []
        for joint, placement in (
            (constraint.joint1_id, constraint.joint1_placement),
            (constraint.joint2_id, constraint.joint2_placement),
        ):
            body = joint - 1
            place = placement if body < 0 else pin.SE3(bodies[body].rotation, bodies[body].offset).inverse() * placement
            ends.append((body, _read_only(place.translation), _read_only(place.rotation)))
        a, b = ends
        names = ["world" if body < 0 else bodies[body].name for body in (a[0], b[0])]
        turns = isinstance(constraint, pin.FrameAnchorConstraintModel)
        loops.append(Loop("–".join(names), (a[0], b[0]), (a[1], b[1]), (a[2], b[2]), np.eye(3), turns))
    return tuple(loops)


def _mimics(source: RobotSource, model: pin.Model) -> tuple[Mimic, ...]:
    """The joints that follow others, leaders before followers. Pinocchio reads them as free ones; `freedom` ties them.

    A fixed joint follows nothing, whatever its file says; one that follows a fixed joint stays where its offset puts it.
    """
    if source.kind != "urdf" or "<mimic" not in source.xml:
        return ()
    found: list[Mimic] = []
    for joint in parse_markup(source.xml, source.path.name).iter("joint"):
        for mimic in joint.findall("mimic"):
            if not model.existJointName(joint.get("name", "")):
                continue
            multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
            found.append(Mimic(joint.get("name", ""), mimic.get("joint", ""), multiplier, offset))
    ordered: list[Mimic] = []
    while found:
        waiting = {mimic.joint for mimic in found}
        ready = [mimic for mimic in found if mimic.leader not in waiting]
        if not ready:
            names = ", ".join(f'"{mimic.joint}"' for mimic in found)
            raise RobotError(f"{source.path.name}: mimic joints {names} follow one another in a circle; one of them has to lead")
        ordered += ready
        found = [mimic for mimic in found if mimic.leader in waiting]
    return tuple(ordered)


def _read_only(values: Array) -> Array:
    """A copy that outlives Pinocchio's buffers and cannot be changed."""
    out = np.array(values, dtype=float)
    out.flags.writeable = False
    return out


def _bodies(model: pin.Model) -> tuple[Body, ...]:
    """The moving bodies: one for each joint, named after the link that the joint carries."""
    links: dict[int, list[pin.Frame]] = {joint: [] for joint in range(model.njoints)}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            links[frame.parentJoint].append(frame)
    bodies = []
    for joint in range(1, model.njoints):
        carried = links[joint]
        placement = carried[0].placement if carried else pin.SE3.Identity()
        inertia = placement.actInv(model.inertias[joint])
        bodies.append(
            Body(
                name=carried[0].name if carried else model.names[joint],
                joint=joint,
                links=tuple(frame.name for frame in carried),
                rotation=_read_only(placement.rotation),
                offset=_read_only(placement.translation),
                mass=float(inertia.mass),
                com=_read_only(inertia.lever),
                inertia=_read_only(inertia.inertia),
            )
        )
    return tuple(bodies)


def _frames(model: pin.Model, bodies: tuple[Body, ...]) -> dict[str, Frame]:
    """Every named frame, written in its body's frame. Links win over joints and sites of the same name."""
    frames: dict[str, Frame] = {}
    for wanted in (True, False):
        for frame in model.frames:
            if (frame.type == pin.FrameType.BODY) != wanted or frame.name in frames or frame.name == "universe":
                continue
            index = frame.parentJoint - 1
            place = frame.placement
            if index >= 0:
                place = pin.SE3(bodies[index].rotation, bodies[index].offset).inverse() * place
            kind: Literal["link", "joint", "site"] = "link" if wanted else "site" if frame.type in SITES else "joint"
            frames[frame.name] = Frame(frame.name, index, _read_only(place.rotation), _read_only(place.translation), kind)
    return frames
