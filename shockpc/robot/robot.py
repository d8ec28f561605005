"""A robot as read of its file, and what follows from its bodies, joints and frames."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from shockpc.core.frozen import frozen
from shockpc.core.spatial import Array, freeze, read_only
from shockpc.robot.bodies_and_joints import (
    Body,
    Drives,
    Frame,
    Joint,
    Loop,
    Mimic,
    bodies_of,
    frames_of,
    joints_of,
)
from shockpc.robot.files.reading import OpenFolders
from shockpc.robot.tolerances import POINT, inertia_fault, negative_moment
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.display import shown_by
from shockpc.text.errors import UnknownName
from shockpc.text.names import match
from shockpc.text.printed import few

STOP = "stop:"
"""Before the name of a joint: its end stop, as what strikes."""


@dataclass(eq=False, repr=False)
class RobotSource:
    """The source of a robot: its text, where it came from, and what may be read with it.

    Attributes:
        name: its catalogue name, if it was asked for by name; what it was, if there is no file.
        kind: of `FORMATS`, such as "urdf" (xacro included) or "mjcf", or "pinocchio".
        xml: the robot's text. URDF: after xacro, mesh paths as found. MJCF: with its includes
            inserted and mesh paths relative to the file. SDFormat: as a URDF. Pinocchio: the model
            as it is serialised there, and its shapes as links of a URDF.
        robot_name: as the file says, else the file's stem.
        srdf: the file of reference postures, given or found beside the robot.
        folders: the robot file, and what may be read along with it.
        warnings: what was met on the way, each with its consequence.
        freed: whether the base of an MJCF without one that moves gets a free joint.
        expanded: whether xacro made the text.
        all_driven: whether a joint without an effort limit has a motor all the same, of unlimited
            effort, by the rules of the file's format.
    """

    name: str | None
    kind: str
    xml: str
    robot_name: str
    srdf: Path | None
    folders: OpenFolders
    warnings: tuple[str, ...]
    freed: bool = False
    expanded: bool = False
    all_driven: bool = False

    @property
    def path(self) -> Path:
        """The robot file, absolute."""
        return self.folders.file


@frozen()
class Robot:
    """A robot as loaded.

    What takes a name raises UnknownName where nothing fits; the text names the nearest.

    Attributes:
        source: the file's text and where it came from.
        model: the Pinocchio model; its first joint is the base's if `free_base`.
        start: (nq,) configuration with neutral joints, each at zero or the limit nearest to it; a
            base that its file places stands there.
        postures: reference configurations by name, each (nq,).
        mimics: joints that follow others, each after the one that it follows.
        loops: what the file holds together beside the tree (MJCF connect and weld, loop joints of a
            URDF).
        notes: warnings of the file's reader, without the file's name.
        change_warnings: of what was changed after it was loaded.
        springs: stiffness of the joints that the file gives a spring at the joint [N m/rad, N/m].
        relaxed: (nq,) configuration in which these springs are without force; None where the file
            gives none.
        gear_ratios: by joint, where the file gives a ratio without the inertia of the rotor [1].
        motors: what the actuators of an MJCF can exert, by joint; infinite without a limit [N m,
            N].
        settings: joints whose reflected inertia is a setting of a simulator, as in
            `simulator_settings`.
        default_drives: of a robot of the catalogue, which go over what its file gives; None where
            none are known.
        welded: whether the file welds the base, which could move freely, to the world; its postures
            have it where it is held.
        imus: names of the places that the file says are those of IMUs, whatever they are called.
    """

    source: RobotSource
    model: pin.Model
    start: Array
    postures: Mapping[str, Array]
    mimics: tuple[Mimic, ...]
    loops: tuple[Loop, ...]
    notes: tuple[str, ...]
    change_warnings: tuple[Diagnostic, ...] = ()
    springs: Mapping[str, float] = field(default_factory=dict)
    relaxed: Array | None = None
    gear_ratios: Mapping[str, float] = field(default_factory=dict)
    motors: Mapping[str, float] = field(default_factory=dict)
    settings: frozenset[str] = frozenset()
    default_drives: Drives | None = None
    welded: bool = False
    imus: tuple[str, ...] = ()

    _repr_html_ = shown_by("studies.robots.report:robot_report")

    def __repr__(self) -> str:
        return f"Robot(name={self.name!r}, free_base={self.free_base}, mass={self.mass})"

    @property
    def name(self) -> str:
        """As the file says."""
        return self.source.robot_name

    def deflection(self, q: Array) -> Array:
        """Deflection (nv,) of the springs of the file in a configuration (nq,) [rad, m].

        It is zero where there is no spring.
        """
        out = np.zeros(self.model.nv)
        if self.relaxed is not None:
            for v in (self.joint(name).v for name in self.springs):
                out[v] = pin.difference(self.model, self.relaxed, q)[v]
        return out

    @property
    def label(self) -> str:
        """The name of this robot in commands: its catalogue name, else the path of its file."""
        return self.source.name or str(self.source.path)

    @property
    def links(self) -> tuple[str, ...]:
        """Every link that moves, in the order of the bodies."""
        return tuple(link for body in self.bodies for link in body.links)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the file's reader, and one of inertias that no body has.

        The last is one for all bodies whose inertia, with that of all that is fixed to them, no
        body has.
        """
        implausible = []
        for body in self.bodies:
            if body.mass > 0 and inertia_fault(body.mass, body.inertia):
                moments = np.linalg.eigvalsh(body.inertia)
                # Moments of a point are rounding alone.
                moments[np.abs(moments) <= POINT * body.mass] = 0.0
                numbers = ", ".join(f"{moment:.3g}" for moment in moments)
                implausible.append(f'"{body.name}" ({numbers} kg m²)')
        notes = list(self.notes)
        if implausible:
            notes.append(
                f"no body has such principal moments: {few(implausible, 4)}; none can be negative "
                "or above the sum of the other two, and not all can be zero. Correct the file; "
                f"shockpc robots {self.label} lists the links"
            )
        file = self.source.path.name
        return (*self.source.warnings, *(f"{file}: {note}" for note in notes))

    @cached_property
    def negative_moments(self) -> tuple[str, ...]:
        """Links with a negative principal moment of inertia, with their moments.

        They are links of bodies that have one with all their links.
        """
        names = []
        for body in self.bodies:
            if negative_moment(body.mass, body.inertia):
                links = {
                    frame.name: frame.inertia
                    for frame in self.model.frames
                    if frame.name in body.links
                }
                tensors = {
                    name: link.inertia
                    for name, link in links.items()
                    if negative_moment(link.mass, link.inertia)
                }
                for name, tensor in (tensors or {body.name: body.inertia}).items():
                    moments = ", ".join(f"{moment:.3g}" for moment in np.linalg.eigvalsh(tensor))
                    names.append(f'"{name}" ({moments} kg m²)')
        return tuple(names)

    @cached_property
    def free_base(self) -> bool:
        """True if the base can move (every URDF; an MJCF whose root body has a free joint)."""
        return self.joints[0].kind == "free"

    @cached_property
    def root(self) -> str:
        """The link of the file that carries all others; it belongs to the first body."""
        links = (frame for frame in self.model.frames if frame.type == pin.FrameType.BODY)
        return next(
            (str(link.name) for link in links if link.parentJoint == 1), self.bodies[0].name
        )

    def movable(self, base: str) -> slice:
        """The bodies that can move: all but the base if that is "fixed".

        In a file that fixes the base, it is none of the bodies.
        """
        return slice(int(self.free_base and base == "fixed"), None)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The moving bodies, as in `bodies_of`."""
        return bodies_of(self.model)

    @cached_property
    def frames(self) -> Mapping[str, Frame]:
        """Every named place, as in `frames_of`."""
        return frames_of(self.model, self.bodies)

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joint that carries each body, as in `joints_of`."""
        return joints_of(self.model)

    def joint_origins(self, Q: Array) -> Array:
        """Origins (N, n, 3) of the frames of `single_joints`, in the frames of their bodies [m].

        The body of a joint is the one that it moves.

        A frame moves with its joint: that of a prismatic joint slides. Args: Q (N, nq)
        configurations.
        """
        origins = np.empty((len(Q), len(self.single_joints), 3))
        first = 0
        for body, joint in zip(self.bodies, self.joints, strict=True):
            placement = pin.SE3(body.rotation, body.offset)
            end = first + len(joint.parts or (joint,))
            # the last part's frame is that which carries the body
            origins[:, end - 1] = placement.actInv(np.zeros(3))
            if joint.parts:
                model = self.model.joints[body.joint]
                data = model.createData()
                for k, q in enumerate(Q):
                    model.calc(data, q)
                    # The placement of the last part's frame in that of each part but the last.
                    placements = data.extract().iMlast.tolist()[1:]
                    origins[k, first : end - 1] = [
                        placement.actInv(last.inverse().translation) for last in placements
                    ]
            first = end
        return origins

    @cached_property
    def single_joints(self) -> tuple[Joint, ...]:
        """The joints as the file has them.

        They are `joints`, with the parts of a composite joint in its place.
        """
        return tuple(part for joint in self.joints for part in joint.parts or (joint,))

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints between bodies, as the file has them.

        The floating base's is not among them.
        """
        return tuple(joint.name for joint in self.single_joints[self.free_base :])

    def joint(self, name: str) -> Joint:
        """The joint of the file of that exact name."""
        if (joint := self._joints_by_name.get(name)) is None:
            raise self.unknown("joint", name, self._joints_by_name)
        return joint

    @cached_property
    def _joints_by_name(self) -> Mapping[str, Joint]:
        """The joints of the file."""
        return {joint.name: joint for joint in self.single_joints}

    @cached_property
    def followers(self) -> frozenset[str]:
        """Names of the joints that follow others."""
        return frozenset(mimic.joint for mimic in self.mimics)

    @cached_property
    def independent_joints(self) -> tuple[Joint, ...]:
        """The joints of one coordinate that follow no other."""
        return tuple(
            joint
            for joint in self.single_joints
            if joint.axis is not None and joint.name not in self.followers
        )

    def velocities(self, names: Iterable[str]) -> np.ndarray:
        """Mask (nv,) of the velocities of the joints of these exact names."""
        chosen = np.zeros(self.model.nv, dtype=bool)
        for name in names:
            chosen[self.joint(name).v] = True
        return chosen

    @cached_property
    def actuated_dofs(self) -> np.ndarray:
        """Mask (nv,) of the velocities of joints that a drive may move or hold.

        They are all but those of floating joints.
        """
        sizes = [joint.v.stop - joint.v.start for joint in self.joints]
        driven = np.repeat([joint.kind != "free" for joint in self.joints], sizes)
        freeze(driven)
        return driven

    @cached_property
    def mass(self) -> float:
        """Mass of all bodies [kg]."""
        # rounded as in a landing, which `sum` of Python's own numbers is not since 3.12
        return float(sum(self.masses))

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
        """Radius of gyration (nb,) of every body about its centre of mass [m].

        It is that for the mean axis, and 0 for a body without mass.
        """
        # k² = tr I / 3 m
        trace = np.maximum(np.trace(self.inertias, axis1=1, axis2=2), 0.0)
        masses = np.where(self.masses > 0.0, self.masses, np.inf)
        return read_only(np.sqrt(trace / 3.0 / masses))

    @cached_property
    def rotation_lengths(self) -> Array:
        """Length (nb,) by which the rotation of a body counts as a speed [m].

        It is the body's radius of gyration, or the others' smallest.
        """
        k = self.gyration
        smallest = k[k > 0.0].min(initial=1.0)
        return read_only(np.where(k > 0.0, k, smallest))

    @cached_property
    def body_frames(self) -> tuple[Array, Array] | None:
        """Rotation (nb, 3, 3) and origin (nb, 3) [m] of the body frames in their joint frames.

        None where all are the same.
        """
        rotation = read_only([body.rotation for body in self.bodies])
        offset = read_only([body.offset for body in self.bodies])
        same = not offset.any() and (rotation == np.eye(3)).all()
        return None if same else (rotation, offset)

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """Index of the body that carries each body's joint; −1 for the world."""
        return tuple(joint.parent for joint in self.joints)

    @cached_property
    def depth_first(self) -> bool:
        """True if all that a body carries follows it without others between.

        It is so in all files; a model that is built may differ.
        """
        moves, joints = self.ancestors, self.joints
        for i, parent in enumerate(self.parents):
            # the body before this one is the parent, or one that the parent carries
            if parent >= 0 and not moves[i - 1, joints[parent].v.start]:
                return False
        return True

    def limb(self, body: int) -> list[int]:
        """The bodies from one to the base, which is not among them."""
        limb: list[int] = []
        while body > 0:
            limb.append(body)
            body = self.parents[body]
        return limb

    @cached_property
    def ancestors(self) -> np.ndarray:
        """Mask (nb, nv) of the joint velocities (columns) that move bodies (rows).

        They are those of the joints from the base to the body.
        """
        # the last row is the world's
        ancestors = np.zeros((len(self.bodies) + 1, self.model.nv), dtype=bool)
        for i, joint in enumerate(self.joints):
            ancestors[i] = ancestors[joint.parent]
            ancestors[i, joint.v] = True
        freeze(ancestors)
        return ancestors[:-1]

    def match(
        self,
        kind: str,
        pattern: str,
        names: Iterable[str],
        known: Iterable[str] = (),
        hint: str = "",
    ) -> tuple[str, ...]:
        """The names that an exact name or a glob means, as in `names.match`."""
        return match(
            pattern,
            names,
            kind,
            f'robot "{self.name}"',
            f"shockpc robots {self.label}",
            known,
            hint,
        )

    def match_joints(self, pattern: str) -> tuple[str, ...]:
        """The joints that an exact name or a glob means."""
        return self.match("joint", pattern, self.joint_names)

    def match_frames(self, pattern: str, kind: str = "frame", hint: str = "") -> tuple[str, ...]:
        """The frame of an exact name, or the frames that a glob means.

        A glob means links, sites and geoms on moving bodies.
        """
        return (
            (pattern,)
            if pattern in self.frames
            else self.match(kind, pattern, self._places, self.frames, hint)
        )

    def match_bodies(self, pattern: str) -> tuple[int, ...]:
        """Indices of the bodies that a name or a glob means.

        The name of a link, site or geom means the body that it belongs to.
        """
        return tuple(
            sorted({self._places[name] for name in self.match("body", pattern, self._places)})
        )

    def body(self, pattern: str) -> int:
        """Index of the one body that a name or a glob means, as in `match_bodies`."""
        bodies = self.match_bodies(pattern)
        if len(bodies) > 1:
            raise self.unknown("single body", pattern, (self.bodies[i].name for i in bodies))
        return bodies[0]

    @cached_property
    def _places(self) -> Mapping[str, int]:
        """The bodies of the links, sites and geoms that move."""
        return {
            frame.name: frame.body
            for frame in self.frames.values()
            if frame.kind != "joint" and frame.body >= 0
        }

    def set_followers(self, q: Array) -> None:
        """Set the joints that follow others. Args: q (nq,), which is changed."""
        for mimic in self.mimics:
            # q_follower = sum of multiplier · q_leader, + offset
            parts: list[float] = []
            for leader, multiplier in mimic.leaders.items():
                parts.append(multiplier * self.joint(leader).value(q))
            led = sum(parts)
            self.joint(mimic.joint).set(led + mimic.offset, q)

    def joint_placements(self, q: Array) -> list[pin.SE3]:
        """Placements of Pinocchio's joints in the world.

        They are computed without `pin.Data`, whose size is as the cube of the number of joints.
        """
        placements, model = [pin.SE3.Identity()], self.model
        for joint, placement, parent in list(
            zip(model.joints, model.jointPlacements, model.parents, strict=True)
        )[1:]:
            data = joint.createData()
            joint.calc(data, q)
            placements.append(placements[parent] * (placement * data.M))
        return placements

    def body_placements(self, q: Array) -> list[pin.SE3]:
        """Placements of the bodies' frames in the world, as `joint_placements`."""
        joints = self.joint_placements(q)
        return [joints[body.joint] * pin.SE3(body.rotation, body.offset) for body in self.bodies]

    def frame(self, name: str) -> Frame:
        """The frame of that exact name.

        Of the end stop of a joint it is the centre of mass of the body that the joint carries.
        """
        if name not in self.frames and name.startswith(STOP):
            body = next(
                (i for i, joint in enumerate(self.joints) if joint.name == name.removeprefix(STOP)),
                None,
            )
            if body is None:
                raise self.unknown("joint", name.removeprefix(STOP), self.joint_names)
            return Frame(name, body, np.eye(3), self.bodies[body].com, "site")
        if name not in self.frames:
            raise self.unknown("frame", name, self.frames)
        return self.frames[name]

    def unknown(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> UnknownName:
        """The error for a name that is none of this robot's."""
        return UnknownName(
            kind, name, known, f'robot "{self.name}"', f"shockpc robots {self.label}", hint
        )
