"""Changes of a robot: inertias of links, reflected inertia and place of joints."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, cross_matrix
from shockpc.robot.bodies_and_joints import Drives
from shockpc.robot.robot import Robot
from shockpc.robot.tolerances import refuse_number
from shockpc.text.diagnostic import Diagnostic
from shockpc.text.errors import StudyError, UnknownName
from shockpc.text.printed import listed

ENTRIES = ("inertia-xx", "inertia-yy", "inertia-zz", "inertia-xy", "inertia-xz", "inertia-yz")
"""The entries of an inertia."""

ADDED = ("point-mass", "com-x", "com-y", "com-z", *ENTRIES)
"""The properties whose value is added to the present one."""

PROPERTIES = ("mass", "inertia", "armature", "place", *ADDED)
"""All properties that a change may have."""

SMALL = 0.01
"""Share of a body's mass below which a change of its links is probably not the change of the body
that was meant.
"""


@dataclass(frozen=True)
class Change:
    """One change of a robot.

    Attributes:
        what: one of `PROPERTIES`: mass of a link, with its inertia in proportion and its centre of
            mass where it was [kg]; a point mass at that centre, which leaves the inertia about it
            [kg]; inertia of a link about its centre of mass, all of it or an entry in axes of the
            link's frame [kg m²]; position of the centre of mass along x, y or z of that frame [m];
            armature of a joint, its reflected inertia [kg m²; kg for a prismatic joint]; place of a
            joint, which may be fixed, with all that it carries: its origin in the frame of the link
            that carries it, such as (0, 0, -length) of a knee [m].
        pattern: name or glob of links, for armature and place of joints.
        value: the new value, or what the present one is multiplied by; of `ADDED` what is added.
        factor: whether the present value is multiplied.
    """

    what: str
    pattern: str
    value: float | tuple[float, ...]
    factor: bool

    def __post_init__(self) -> None:
        """Refuse unknown properties, and values that no link and no joint has.

        Raises:
            UnknownName: there is no such property.
            StudyError: the value is not finite, not above zero, or not of the kind that the
                property takes.
        """
        if self.what not in PROPERTIES:
            raise UnknownName("property", self.what, PROPERTIES, "", "")
        fault = self._fault()
        if fault:
            raise StudyError(f"change {self}: {fault}")

    def _fault(self) -> str:
        """The reason why no link and no joint has the value; empty if one may have it."""
        values = np.ravel(self.value)
        added = self.what in ADDED
        sets_place = self.what == "place" and not self.factor
        if not np.isfinite(values).all():
            return "the value has to be a finite number"
        if sets_place:
            if len(values) == 3:
                return ""
            example = f"{self.what}:{self.pattern}=0,0,-0.3"
            return f"a place is three numbers [m] or a factor; give for example {example}"
        if len(values) != 1:
            return "the value has to be one number"
        if added and self.factor:
            return (
                "a centre of mass is moved by metres, a point mass is added in kg, an entry of an "
                f"inertia in kg m², not by a factor; give for example {self.what}:trunk=0.02"
            )
        if self.what == "inertia" and not self.factor:
            return (
                "an inertia has six entries, so it is changed by a factor; give for example "
                "inertia:trunk=1.1x, or an entry, such as inertia-xx:trunk=0.01"
            )
        too_small = self.number < 0.0 or (self.number == 0.0 and self.what == "inertia")
        if too_small and not added:
            return (
                "the value may not be below zero, and a factor of an inertia has to be above zero"
            )
        return ""

    @property
    def number(self) -> float:
        """The value, where it is one number."""
        return float(np.ravel(self.value)[0])

    def __str__(self) -> str:
        values = ",".join(f"{value:g}" for value in np.ravel(self.value))
        suffix = "x" if self.factor else ""
        return f"{self.what}:{self.pattern}={values}{suffix}"


def changed(robot: Robot, changes: Iterable[Change]) -> Robot:
    """The robot with changes applied one after the other.

    The original stays as it is. Both share the geometry that is read.

    Raises:
        UnknownName: a pattern matches no link with mass, or no joint.
        StudyError: a reflected inertia of zero is multiplied, or a link would have less than no
            mass.
        RobotError: a body becomes too heavy or too light to compute with.
    """
    model = pin.Model(robot.model)
    warnings = robot.change_warnings
    drives = robot.default_drives
    settings = robot.settings
    for change in changes:
        if change.what == "armature":
            drives = _change_armature(robot, model, drives, change)
            if not change.factor:
                settings -= set(robot.match_joints(change.pattern))
        elif change.what == "place":
            for name in robot.match("joint", change.pattern, _joint_frames(robot)):
                _change_place(robot, model, name, change)
            # The next change reads the frames of this robot.
            robot = replace(robot, model=model)
            model = pin.Model(model)
        else:
            links = links_with_mass(robot, change.pattern, model)
            warnings += tuple(_small_parts(robot, model, change, links))
            for link in links:
                _change_link(model, link, change)
    robot = replace(
        robot, model=model, change_warnings=warnings, default_drives=drives, settings=settings
    )
    for body in robot.bodies:
        where = f'{robot.source.path.name}: body "{body.name}"'
        refuse_number(where, "mass", body.mass, "kg")
        refuse_number(where, "inertia", float(np.abs(body.inertia).max()), "kg m²")
    return robot


def varied_bodies(
    robot: Robot, changes: Iterable[tuple[str, str, Array, bool]]
) -> tuple[Array, Array, Array]:
    """The bodies of N robots that `changed` makes of one, each with another value.

    Args:
        robot: the robot.
        changes: kind, pattern of links, values (N,), and whether they are factors, as in `Change`;
            one after the other. NaN changes nothing.

    Returns: masses (N, nb) [kg], centres of mass (N, nb, 3) in the bodies' frames [m], and inertias
        (N, nb, 3, 3) about them, axes of the frames [kg m²].
    """
    links: dict[str, _Inertias] = {}
    n = 1
    for kind, pattern, values, factor in changes:
        n = len(values)
        for link in links_with_mass(robot, pattern):
            before = links.get(link) or _repeated(_frame(robot.model, link).inertia, n)
            links[link] = _changed_inertia(kind, np.asarray(values, float), factor, before)
    # Bodies without a changed link stay as they are; the others are summed anew over their links.
    mass = np.repeat(robot.masses[None], n, axis=0).astype(float)
    com = np.repeat(robot.coms[None], n, axis=0).astype(float)
    inertia = np.repeat(robot.inertias[None], n, axis=0).astype(float)
    for i in sorted({robot.frames[link].body for link in links}):
        parts = [part.moved(placement) for placement, part in _parts_of(robot, i, links)]
        # m = Σ m_k,  c = Σ m_k c_k / m
        mass[:, i] = sum(part.mass for part in parts)
        moment = sum(part.mass[:, None] * part.com for part in parts)
        com[:, i] = moment / mass[:, i, None]
        # I = Σ I_k − m_k [c_k − c]ײ
        total = np.zeros((n, 3, 3))
        for part in parts:
            C = cross_matrix(part.com - com[:, i])
            total += part.inertia - part.mass[:, None, None] * (C @ C)
        inertia[:, i] = total
    return mass, com, inertia


class _Inertias(NamedTuple):
    """The inertias of one part in N robots, or in all of them (N = 1).

    Attributes:
        mass: (N,) [kg].
        com: (N, 3) centres of mass [m].
        inertia: (N, 3, 3) about them [kg m²].
    """

    mass: Array
    com: Array
    inertia: Array

    def moved(self, placement: pin.SE3) -> "_Inertias":
        """The inertias in the frame in which their own frame is placed."""
        R = placement.rotation
        return _Inertias(self.mass, self.com @ R.T + placement.translation, R @ self.inertia @ R.T)


def _repeated(Y: pin.Inertia, n: int) -> _Inertias:
    """The inertia of a part that is the same in n robots."""
    return _Inertias(np.full(n, Y.mass), np.tile(Y.lever, (n, 1)), np.tile(Y.inertia, (n, 1, 1)))


def _parts_of(
    robot: Robot, body: int, links: Mapping[str, _Inertias]
) -> Iterator[tuple[pin.SE3, _Inertias]]:
    """The parts of a body with their places in its frame; those of some links are given."""
    record = robot.bodies[body]
    in_body = pin.SE3(record.rotation, record.offset)
    for frame in robot.model.frames:
        is_link = frame.type == pin.FrameType.BODY
        if frame.parentJoint == record.joint and (is_link or frame.inertia.mass):
            part = links.get(frame.name) if is_link else None
            yield in_body.actInv(frame.placement), part or _repeated(frame.inertia, 1)


def _change_armature(
    robot: Robot, model: pin.Model, drives: Drives | None, change: Change
) -> Drives | None:
    """Change the reflected inertia of some joints.

    Returns: the default drives; a joint that is given a number has none of them.
    """
    names = robot.match_joints(change.pattern)
    chosen = robot.velocities(names)
    by_joint = {} if drives is None else dict(drives.by_joint)
    of_joints = {name: by_joint.pop(name) for name in names if name in by_joint}
    if not change.factor:
        model.armature[chosen] = change.number
    else:
        known = any(drive.reflected for drive in of_joints.values())
        if not known and not model.armature[chosen].any():
            raise StudyError(
                f"change {change} has no effect, because these joints of robot "
                f'"{robot.name}" have no reflected inertia; give a number, such as '
                f"armature:{change.pattern}=0.01",
                joints=names,
            )
        model.armature[chosen] = model.armature[chosen] * change.number
        for name, drive in of_joints.items():
            inertia = change.number * (drive.reflected or 0.0)
            low, high = drive.interval
            ends = (change.number * low, change.number * high)
            by_joint[name] = replace(drive, armature=inertia, rotor_inertia=None, range=ends)
    return None if drives is None else drives._replace(by_joint=by_joint)


def _changed_inertia(kind: str, x: Array, factor: bool, before: _Inertias) -> _Inertias:
    """The inertias of a link after a change by values x (N,), as in `varied_bodies`."""
    mass, com, inertia = before
    if kind in ADDED:
        x = np.where(np.isnan(x), 0.0, x)
        if kind == "point-mass":
            return _Inertias(mass + x, com, inertia)
        if kind.startswith("com"):
            axis = np.eye(3)["xyz".index(kind[-1])]
            return _Inertias(mass, com + x[..., None] * axis, inertia)
        j, k = "xyz".index(kind[-2]), "xyz".index(kind[-1])
        entry = np.zeros((3, 3))
        entry[[j, k], [k, j]] = 1.0
        return _Inertias(mass, com, inertia + x[..., None, None] * entry)
    unchanged = 1.0 if factor else mass
    x = np.where(np.isnan(x), unchanged, x)
    ratio = x if factor else x / mass
    # A mass that changes keeps the shape of its body; an inertia that changes keeps the mass.
    scaled = inertia * ratio[..., None, None]
    return _Inertias(mass * ratio if kind == "mass" else mass, com, scaled)


def _change_link(model: pin.Model, link: str, change: Change) -> None:
    """Change the mass, the centre of mass or the inertia of a link."""
    frame = _frame(model, link)
    inertia = frame.inertia.copy()
    before = _Inertias(np.array(inertia.mass), inertia.lever, inertia.inertia)
    after = _changed_inertia(change.what, np.array(change.number), change.factor, before)
    if after.mass < 0.0:
        raise StudyError(
            f"change {change}: {link} has {before.mass:g} kg, so less than nothing would be left"
        )
    inertia.mass = float(after.mass)
    inertia.lever = after.com
    inertia.inertia = after.inertia
    frame.inertia = inertia
    _sum_inertias(model, frame.parentJoint)


def _sum_inertias(model: pin.Model, joint: int) -> None:
    """Make the inertia of a body that of its links."""
    total = pin.Inertia.Zero()
    for part in model.frames:
        is_part = part.type == pin.FrameType.BODY or part.inertia.mass
        if part.parentJoint == joint and is_part:
            total += part.placement.act(part.inertia)
    model.inertias[joint] = total


def _joint_frames(robot: Robot) -> dict[str, int]:
    """The frames of joints, fixed ones too, by name; that of a floating base has no place."""
    kinds = (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
    free = robot.joints[0].name if robot.free_base else ""
    return {
        frame.name: k
        for k, frame in enumerate(robot.model.frames)
        if frame.type in kinds and frame.name != free
    }


def _change_place(robot: Robot, model: pin.Model, name: str, change: Change) -> None:
    """Move a joint with all that it carries.

    Its rotation against the link that carries it stays.
    """
    number = _joint_frames(robot)[name]
    frame = model.frames[number]
    joint = frame.parentJoint
    moves = frame.type == pin.FrameType.JOINT
    carrier = model.frames[frame.parentFrame].placement
    if moves and not frame.parentFrame and model.parents[joint]:
        # Without a parent frame the frame of the body that carries the joint stands for it.
        body = robot.bodies[model.parents[joint] - 1]
        carrier = pin.SE3(body.rotation, body.offset)
    old = model.jointPlacements[joint] if moves else frame.placement
    old = old.copy()
    placement = carrier.actInv(old)
    if change.factor:
        placement.translation = placement.translation * change.value
    else:
        placement.translation = np.array(change.value)
    if moves:
        model.jointPlacements[joint] = carrier * placement
        return

    # A fixed joint moves all frames behind it, and the joints there, each after what carries it.
    shift = carrier * placement * old.inverse()
    moved = {number}
    for k, part in enumerate(model.frames):
        if k != number and part.parentFrame not in moved:
            continue
        if part.parentJoint == joint:
            moved.add(k)
            part.placement = shift * part.placement
        else:
            behind = model.jointPlacements[part.parentJoint]
            model.jointPlacements[part.parentJoint] = shift * behind
    _sum_inertias(model, joint)


def links_with_mass(robot: Robot, pattern: str, model: pin.Model | None = None) -> dict[str, float]:
    """Mass [kg] of each link that a name or a glob means, without links that are fixed to it.

    Args:
        robot: the robot.
        pattern: name or glob.
        model: its model, of which some links may have changed; that of the robot by default.

    Raises:
        UnknownName: no link that moves and has mass fits. The text names the main link of the body,
            if the name is of a part of it.
    """
    masses = {link: _mass(model or robot.model, link) for link in robot.links}
    masses = {link: mass for link, mass in masses.items() if mass > 0.0}
    frame, hint = robot.frames.get(pattern), ""
    if frame is not None and frame.body >= 0 and pattern not in masses:
        main = _main_link(robot, frame.body)
        hint = f'"{pattern}" has no mass; the main link of its body is "{main}"'
    names = robot.match("link with mass", pattern, masses, (), hint)
    return {name: masses[name] for name in names}


def link_inertia(robot: Robot, link: str) -> pin.Inertia:
    """The inertia of a link without that of the links that are fixed to it, in its frame.

    Args: link, its exact name.
    """
    return _frame(robot.model, link).inertia


def _small_parts(
    robot: Robot, model: pin.Model, change: Change, links: Mapping[str, float]
) -> Iterator[Diagnostic]:
    """A warning for each body of which the links hold next to no mass."""
    for i, body in enumerate(robot.bodies):
        chosen = [link for link in body.links if link in links]
        if not chosen:
            continue
        share = sum(links[link] for link in chosen) / model.inertias[body.joint].mass
        if share < SMALL:
            main = _main_link(robot, i)
            text = (
                f"change {change.what}:{change.pattern}: {listed(chosen, 4)} has "
                f"{100.0 * share:.1g} % of the mass of its body; to change the body, name its "
                f'main link "{main}" ({_mass(model, main):.4g} kg)'
            )
            yield Diagnostic("robot", body.name, share, text)


def _main_link(robot: Robot, body: int) -> str:
    return max(robot.bodies[body].links, key=lambda link: _mass(robot.model, link))


def _mass(model: pin.Model, link: str) -> float:
    return float(_frame(model, link).inertia.mass)


def _frame(model: pin.Model, link: str) -> pin.Frame:
    """The frame of a link in the Pinocchio model.

    The model keeps the inertia of only the link with it.
    """
    return model.frames[model.getFrameId(link, pin.FrameType.BODY)]
