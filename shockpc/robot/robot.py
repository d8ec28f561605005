"""A robot: URDF, xacro or MJCF in, moving bodies and frames out. What cannot be computed is refused by name."""

import fnmatch
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import UnknownName
from shockpc.robot.couplings import Loop, Mimic
from shockpc.robot.inertias import inertia_warning
from shockpc.robot.limits import refuse_drives
from shockpc.robot.source import RobotSource, read_source
from shockpc.robot.urdf_model import WORLD, build_urdf

__all__ = ["Body", "Frame", "Joint", "Robot", "load_robot"]

KINDS = {
    "FreeFlyer": "free",
    "Spherical": "ball",
    "Planar": "planar",
    "Composite": "composite",
    "P": "prismatic",
    "RevoluteUnbounded": "continuous",
    "RUB": "continuous",
    "R": "revolute",
}
"""Kinds of joint, by the beginning of what Pinocchio calls them."""

FRAMES: dict[pin.FrameType, Literal["link", "site", "geom"]] = {
    pin.FrameType.BODY: "link",
    pin.FrameType.OP_FRAME: "site",
    pin.FrameType.SENSOR: "geom",
}
"""Kinds of frame; all others are joints. Pinocchio has no kind for geoms, and no reader here makes sensors."""


class Body(NamedTuple):
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
    rotation: Array
    offset: Array
    mass: float
    com: Array
    inertia: Array


class Joint(NamedTuple):
    """How a body moves against the one that carries it.

    Attributes:
        name: as the file says.
        kind: free (q: position, quaternion x y z w; v: linear then angular, body axes), planar (x, y, cosine, sine), ball
            (quaternion), continuous (cosine, sine), revolute, prismatic, or composite (several of these after one another).
        axis: (3,) unit vector in the joint's frame; None where there is more than one.
        parent: index of the body that carries it; −1 for the world.
        rotation: (3, 3) of the joint's frame at rest in the parent's joint frame; of a part, in that of the part before it.
        offset: (3,) its origin there [m].
        q: where its configuration is in q.
        v: where its velocities are in q̇.
        limits: least and greatest value of a joint of one coordinate [rad, m].
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
        return math.atan2(*q[self.q][::-1]) if self.kind == "continuous" else float(q[self.q.start])


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


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot as loaded.

    Attributes:
        source: the file's text and where it came from.
        model: the Pinocchio model; its first joint is the base's if `free_base`.
        start: (nq,) configuration with neutral joints; a base that its file places stands there.
        postures: reference configurations by name, each (nq,).
        mimics: joints that follow others, each after the one that it follows.
        loops: what the file holds together beside the tree (MJCF connect and weld).
        notes: warnings of the file's reader.
    """

    source: RobotSource
    model: pin.Model
    start: Array
    postures: Mapping[str, Array]
    mimics: tuple[Mimic, ...]
    loops: tuple[Loop, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"Robot(name={self.name!r}, free_base={self.free_base}, mass={self.mass})"

    @property
    def name(self) -> str:
        """As the file says."""
        return self.source.robot_name

    @property
    def label(self) -> str:
        """How a command names this robot: its catalogue name, else the path of its file."""
        return self.source.label

    @property
    def links(self) -> tuple[str, ...]:
        """Every link that moves, in the order of the bodies."""
        return tuple(link for body in self.bodies for link in body.links)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Of the file's reader, and of inertias that no body has."""
        weighed = ((body.name, body.mass, body.inertia) for body in self.bodies)
        return (*self.source.warnings, *self.notes, *inertia_warning(self.source.path.name, self.label, weighed))

    @cached_property
    def free_base(self) -> bool:
        """Whether the base can move (every URDF; an MJCF whose root body has a free joint)."""
        return self.joints[0].kind == "free"

    @property
    def usual_base(self) -> Literal["free", "fixed"]:
        """How the base moves unless a scene says otherwise: a root link called "world" stands for the ground."""
        return "free" if self.free_base and self.bodies[0].name != WORLD else "fixed"

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The moving bodies, base first, then in the order of the tree; each is named after the link that its joint carries."""
        links: list[list[pin.Frame]] = [[] for _ in range(self.model.njoints)]
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY:
                links[frame.parentJoint].append(frame)
        bodies = []
        for joint, carried in list(enumerate(links))[1:]:
            placement = carried[0].placement if carried else pin.SE3.Identity()
            inertia = placement.actInv(self.model.inertias[joint])
            bodies.append(
                Body(
                    name=carried[0].name if carried else self.model.names[joint],
                    joint=joint,
                    links=tuple(frame.name for frame in carried),
                    rotation=read_only(placement.rotation),
                    offset=read_only(placement.translation),
                    mass=float(inertia.mass),
                    com=read_only(inertia.lever),
                    inertia=read_only(inertia.inertia),
                )
            )
        return tuple(bodies)

    @cached_property
    def frames(self) -> Mapping[str, Frame]:
        """Every named place, by name; where a link shares its name with another it is the link's."""
        frames: dict[str, Frame] = {}
        for frame in sorted(self.model.frames, key=lambda frame: frame.type != pin.FrameType.BODY):
            index, place = frame.parentJoint - 1, frame.placement
            if index >= 0:
                place = pin.SE3(self.bodies[index].rotation, self.bodies[index].offset).inverse() * place
            if frame.name != "universe" and frame.name not in frames:
                frames[frame.name] = Frame(
                    frame.name, index, read_only(place.rotation), read_only(place.translation), FRAMES.get(frame.type, "joint")
                )
        return frames

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joint that carries each body, in the order of `bodies`; the floating base's is the first."""
        model = self.model
        return tuple(_joint(model, model.joints[body.joint], body.joint, model.jointPlacements[body.joint]) for body in self.bodies)

    @cached_property
    def single_joints(self) -> tuple[Joint, ...]:
        """The joints as the file has them: the same, with the parts of a composite joint in its place."""
        return tuple(part for joint in self.joints for part in joint.parts or (joint,))

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints between bodies, as the file has them; the floating base's is not among them."""
        return tuple(joint.name for joint in self.single_joints[self.free_base :])

    def joint(self, name: str) -> Joint:
        """The joint of the file of that exact name."""
        return next(joint for joint in self.single_joints if joint.name == name)

    @cached_property
    def driven(self) -> np.ndarray:
        """Which joint velocities (nv,) are of joints that a drive may move or hold: all but those of floating joints."""
        driven = np.ones(self.model.nv, dtype=bool)
        for joint in self.joints:
            driven[joint.v] = joint.kind != "free"
        driven.flags.writeable = False
        return driven

    @cached_property
    def mass(self) -> float:
        """Of all bodies [kg]."""
        return sum(body.mass for body in self.bodies)

    @cached_property
    def masses(self) -> Array:
        """Mass (nb,) of every body [kg]."""
        return read_only([body.mass for body in self.bodies])

    @cached_property
    def coms(self) -> Array:
        """Centre of mass (nb, 3) of every body in its frame [m]."""
        return read_only([body.com for body in self.bodies])

    @cached_property
    def inertias(self) -> Array:
        """Inertia (nb, 3, 3) of every body about its centre of mass, axes of its frame [kg m²]."""
        return read_only([body.inertia for body in self.bodies])

    @cached_property
    def gyration(self) -> Array:
        """Radius of gyration (nb,) of every body about its centre of mass, for the mean axis [m]; 0 for a body without mass."""
        trace = np.trace(self.inertias, axis1=1, axis2=2)
        return read_only(np.sqrt(np.maximum(trace, 0.0) / 3.0 / np.where(self.masses > 0.0, self.masses, np.inf)))

    @cached_property
    def body_frames(self) -> tuple[Array, Array] | None:
        """Rotation (nb, 3, 3) and origin (nb, 3) [m] of the body frames in their joint frames; None where all are the same."""
        rotation = read_only([body.rotation for body in self.bodies])
        offset = read_only([body.offset for body in self.bodies])
        return (rotation, offset) if offset.any() or (rotation != np.eye(3)).any() else None

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """Index of the body that carries each body's joint; −1 for the world."""
        return tuple(joint.parent for joint in self.joints)

    @cached_property
    def moves(self) -> np.ndarray:
        """Which joint velocities (columns) move which bodies (rows): those of the body's own joint and of the joints before it."""
        moves = np.zeros((len(self.bodies), self.model.nv), dtype=bool)
        for i, joint in enumerate(self.joints):
            if joint.parent >= 0:
                moves[i] = moves[joint.parent]
            moves[i, joint.v] = True
        moves.flags.writeable = False
        return moves

    def match_joints(self, pattern: str) -> tuple[str, ...]:
        """The joints that an exact name or a glob means.

        Raises:
            UnknownName: none fits.
        """
        known = self.joint_names
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
    frames: Sequence[str] = (),
) -> Robot:
    """Load a robot from a file (URDF, xacro or MJCF, recognised by its content) or by name.

    Args:
        robot: a path, or a name that `shockpc robots` lists.
        xacro: arguments of a xacro file.
        packages: folders of packages, for `package://` and `$(find …)`.
        srdf: a file of reference postures; by default the one found beside the robot.
        frames: names or globs of frames that are asked for. Of several robots in an MJCF file the one that has the first of them is
            loaded, or else the one with the most joints.

    Raises:
        UnknownName: no robot has that name.
        RobotError: the file is missing, not a robot, not physical, or reads outside its own folders.
    """
    source = read_source(robot, xacro=xacro, packages=packages, srdf=srdf)
    if source.kind == "mjcf":
        from shockpc.robot.mjcf_model import build_mjcf

        built = build_mjcf(source, frames)
    else:
        built = build_urdf(source)
    refuse_drives(source.path.name, built.model.nv, float(built.model.armature.max(initial=0.0)))
    # Rotations as good as doubles allow, by Newton's iteration R ← R (3 − RᵀR) / 2: a chain of bodies multiplies what is missing.
    for place in built.model.jointPlacements:
        R = place.rotation
        # By einsum, whose rounding is the same on every processor.
        place.rotation = 0.5 * np.einsum("ij,jk->ik", R, 3.0 * np.eye(3) - np.einsum("ji,jk->ik", R, R))
    return Robot(source, **built._asdict())


def _joint(model: pin.Model, joint: Any, number: int, place: pin.SE3) -> Joint:
    """One joint of a model, or a part of one."""
    short = joint.shortname().removeprefix("JointModel")
    kind = next((kind for start, kind in KINDS.items() if short.startswith(start)), short)
    parts: tuple[Joint, ...] = ()
    axis, limits = None, (-np.inf, np.inf)
    if kind == "composite":
        inner = joint.extract()
        steps = [place * inner.jointPlacements[0], *inner.jointPlacements.tolist()[1:]]
        parts = tuple(
            _joint(model, part, number, step)._replace(name=name)
            for part, step, name in zip(inner.joints, steps, model.names[number].split("+"), strict=True)
        )
    elif joint.nv == 1:
        data = joint.createData()
        joint.calc(data, np.zeros(joint.idx_q + joint.nq), np.zeros(joint.idx_v + 1))
        twist = np.asarray(data.S, dtype=float).ravel()
        axis = read_only(twist[3:] if twist[3:].any() else twist[:3])
        if joint.nq == 1:
            limits = float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])
    return Joint(
        name=model.names[number],
        kind=kind,
        axis=axis,
        parent=int(model.parents[number]) - 1,
        rotation=read_only(place.rotation),
        offset=read_only(place.translation),
        q=slice(joint.idx_q, joint.idx_q + joint.nq),
        v=slice(joint.idx_v, joint.idx_v + joint.nv),
        limits=limits,
        parts=parts,
    )
