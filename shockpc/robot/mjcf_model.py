"""The Pinocchio model of a compiled MJCF, and what ties its bodies together beside the tree."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.errors import RobotError
from shockpc.robot.couplings import Built, Loop, Mimic, leaders_first
from shockpc.robot.inertias import LARGEST
from shockpc.robot.mjcf import compiled
from shockpc.robot.source import RobotSource

__all__ = ["build_mjcf"]

_FREE, _BALL, _SLIDE, _HINGE = range(4)  # mjtJoint
_CONNECT, _WELD, _JOINT = range(3)  # mjtEq
_SPHERE = 2  # mjtGeom
_SITE = 6  # mjtObj


def build_mjcf(source: RobotSource) -> Built:
    """Build the Pinocchio model of an MJCF.

    A body with several joints has one composite joint. A free base stands where its configuration says; `body_pos` is only
    where it starts. Its armature, which MuJoCo adds to the inertia matrix like any other, is added to the base as mass and
    rotational inertia at the body's frame, which gives the same matrix; no joint model takes it away.

    Of several robots in one file the heaviest is built, with those that equalities tie to it.

    Raises:
        RobotError: MuJoCo refuses the file, or it holds a coupling that cannot be computed.
    """
    found = compiled(source)
    m, file = found.model, source.path.name
    _refuse_extremes(m, file)
    left_out, notes = _left_out(m, file)
    build = _Build(m, file, source.robot_name)
    for body in np.flatnonzero(~np.isin(m.body_rootid, left_out)):
        build.add(int(body))
    model = build.model
    order = np.array(build.coordinates, dtype=int)
    limited = np.flatnonzero(m.jnt_limited & (m.jnt_type >= _SLIDE))
    limits = np.tile([-np.inf, np.inf], (m.nq, 1))
    limits[m.jnt_qposadr[limited]] = m.jnt_range[limited]
    model.lowerPositionLimit, model.upperPositionLimit = limits[order].T
    model.armature = _armature(m, file)[np.array(build.velocities, dtype=int)]
    if model.joints[1].shortname() == "JointModelFreeFlyer":
        extra = float(model.armature[0])
        model.armature[:6] = 0.0
        if extra:
            model.appendBodyToJoint(1, pin.Inertia(extra, np.zeros(3), extra * np.eye(3)), pin.SE3.Identity())
            notes += (
                f'{file}: joint "{model.names[1]}" is free and has armature {extra:g}, which adds {extra:g} kg and '
                f'{extra:g} kg m² to the base, as in MuJoCo; if that is not meant, set armature="0" there or use a <freejoint/>',
            )
    postures, more = _postures(m, found.keys, order, file)
    return Built(
        model=model,
        postures=postures,
        mimics=_mimics(m, build, file),
        loops=tuple(_loops(m, build)),
        start=read_only(m.qpos0[order]),
        warnings=(*found.warnings, *notes, *more),
    )


class _Build:
    """A Pinocchio model under construction.

    Attributes:
        model: the model.
        joint: Pinocchio joint of every MuJoCo body that was added.
        place: frame of every MuJoCo body in its joint's frame.
        coordinates: index in MuJoCo's qpos of every entry of q.
        velocities: index in MuJoCo's qvel of every entry of q̇.
    """

    def __init__(self, m: Any, file: str, name: str):
        self.m, self.file = m, file
        self.model = pin.Model()
        self.model.name = name
        self.joint: dict[int, int] = {0: 0}
        self.place: dict[int, pin.SE3] = {0: pin.SE3.Identity()}
        self.coordinates: list[int] = []
        self.velocities: list[int] = []
        self._frame = {0: 0}

    def add(self, body: int) -> None:
        """Add a body after the one that carries it, with its sites, and its spheres under their names (many are feet)."""
        m, model = self.m, self.model
        if body:
            self._add_body(body)
        joint, parent = self.joint[body], self._frame[body]
        named = [m.site(number) for number in np.flatnonzero(m.site_bodyid == body)]
        named += [m.geom(number) for number in np.flatnonzero((m.geom_bodyid == body) & (m.geom_type == _SPHERE))]
        for item in named:
            if item.name and not model.existFrame(item.name, pin.FrameType.OP_FRAME):
                place = self.place[body] * _place(item.pos, item.quat)
                model.addFrame(pin.Frame(item.name, joint, parent, place, pin.FrameType.OP_FRAME))

    def _add_body(self, body: int) -> None:
        m, model = self.m, self.model
        parent = int(m.body_parentid[body])
        joint, place = self.joint[parent], self.place[parent] * _place(m.body_pos[body], m.body_quat[body])
        first, count = int(m.body_jntadr[body]), int(m.body_jntnum[body])
        name = m.body(body).name
        if count:
            if m.jnt_type[first] == _FREE:  # it stands where its configuration says; its place in the file is only a start
                place = pin.SE3.Identity()
            parts = []
            for number in range(first, first + count):
                part, at, after = self._joint(number)
                parts.append((part, place * at))
                place = after
            called = "+".join(m.joint(number).name for number in range(first, first + count))
            if model.existJointName(called):
                raise RobotError(f'{self.file}: joint "{called}" has a name that Pinocchio uses itself; rename it')
            if count == 1:
                joint = model.addJoint(joint, *parts[0], called)
            else:
                composite = pin.JointModelComposite()
                for number, (part, step) in enumerate(parts):
                    composite.addJoint(part, step if number else pin.SE3.Identity())
                joint = model.addJoint(joint, composite, parts[0][1], called)
            model.addJointFrame(joint)
        self.joint[body], self.place[body] = joint, place
        self._frame[body] = model.addFrame(pin.Frame(name, joint, self._frame[parent], place, pin.FrameType.BODY))
        if joint:
            R = _rotation(m.body_iquat[body])
            moments = R @ np.diag(m.body_inertia[body]) @ R.T
            inertia = pin.Inertia(float(m.body_mass[body]), np.array(m.body_ipos[body]), (moments + moments.T) / 2.0)
            model.appendBodyToJoint(joint, inertia, place)

    def _joint(self, number: int) -> tuple[Any, pin.SE3, pin.SE3]:
        """One joint: its Pinocchio model, its frame at rest in the body's, and the body's frame in it."""
        m = self.m
        q, v, kind = int(m.jnt_qposadr[number]), int(m.jnt_dofadr[number]), int(m.jnt_type[number])
        anchor, axis = np.array(m.jnt_pos[number]), np.array(m.jnt_axis[number])
        ref = float(m.qpos0[q])
        if kind == _FREE:  # position, then quaternion from its scalar part on, which is the last for Pinocchio
            self.coordinates += [q, q + 1, q + 2, q + 4, q + 5, q + 6, q + 3]
            self.velocities += range(v, v + 6)
            return pin.JointModelFreeFlyer(), pin.SE3.Identity(), pin.SE3.Identity()
        at, after = pin.SE3(np.eye(3), anchor), pin.SE3(np.eye(3), -anchor)
        if kind == _BALL:
            self.coordinates += [q + 1, q + 2, q + 3, q]
            self.velocities += range(v, v + 3)
            return pin.JointModelSpherical(), at, after
        self.coordinates.append(q)
        self.velocities.append(v)
        aligned = np.flatnonzero(axis)
        letter = "XYZ"[aligned[0]] if len(aligned) == 1 and axis[aligned[0]] == 1.0 else ""
        if kind == _SLIDE:
            part = getattr(pin, f"JointModelP{letter}")() if letter else pin.JointModelPrismaticUnaligned(axis)
            return part, at * pin.SE3(np.eye(3), -ref * axis), after
        part = getattr(pin, f"JointModelR{letter}")() if letter else pin.JointModelRevoluteUnaligned(axis)
        return part, at * pin.SE3(pin.AngleAxis(-ref, axis).matrix(), np.zeros(3)), after


def _rotation(quaternion: Array) -> Array:
    """The rotation (3, 3) of a quaternion whose scalar part comes first."""
    w, x, y, z = (float(value) for value in quaternion)
    return np.asarray(pin.Quaternion(w, x, y, z).normalized().matrix())


def _place(position: Array, quaternion: Array) -> pin.SE3:
    """A frame from its origin and its quaternion."""
    return pin.SE3(_rotation(quaternion), np.array(position))


def _refuse_extremes(m: Any, file: str) -> None:
    """Refuse numbers that overflow on the way, before Pinocchio asserts that inertias are symmetric."""
    for what in ("mass", "inertia", "pos", "ipos"):
        values = np.abs(getattr(m, f"body_{what}")).reshape(m.nbody, -1).max(axis=1)
        for body in np.flatnonzero(~(values <= LARGEST))[:1]:
            raise RobotError(
                f'{file}: body "{m.body(body).name}": its {what} reaches {values[body]:.3g}, which cannot be computed with; give '
                f"numbers up to {LARGEST:g}"
            )


def _armature(m: Any, file: str) -> Array:
    """Reflected inertia (nv,) of joints, and of actuators that act on a joint: gear² times the actuator's own."""
    armature = np.array(m.dof_armature)
    for number in np.flatnonzero(m.actuator_armature) if hasattr(m, "actuator_armature") else ():
        joint = int(m.actuator_trnid[number, 0])
        if m.actuator_trntype[number] > 1 or m.jnt_type[joint] < _SLIDE:
            raise RobotError(
                f'{file}: actuator "{m.actuator(number).name}" has armature and does not act on a hinge or slide joint, which is '
                "not computed; give the joints that armature, times gear² of the actuator"
            )
        armature[m.jnt_dofadr[joint]] += m.actuator_armature[number] * m.actuator_gear[number, 0] ** 2
    for number in np.flatnonzero(m.tendon_armature) if hasattr(m, "tendon_armature") else ():
        raise RobotError(
            f'{file}: tendon "{m.tendon(number).name}" has armature {m.tendon_armature[number]:g}, which couples its joints in a '
            "way that is not computed; give the joints that armature, or set it to 0"
        )
    for dof in np.flatnonzero(armature < 0):
        name = m.joint(m.dof_jntid[dof]).name
        raise RobotError(f'{file}: joint "{name}": armature {armature[dof]:g} is negative; no rotor has that')
    return armature


def _equalities(m: Any) -> Iterator[tuple[int, list[int], list[int]]]:
    """Every active equality: its number, its objects (−1 for none), and their bodies (0 for the world)."""
    for number in np.flatnonzero(m.eq_active0):
        ends = [int(m.eq_obj1id[number]), int(m.eq_obj2id[number])]
        match int(m.eq_type[number]):
            case 2:  # joint
                bodies = [int(m.jnt_bodyid[joint]) for joint in ends if joint >= 0]
            case 0 | 1:  # connect, weld
                bodies = [int(m.site_bodyid[end]) for end in ends] if m.eq_objtype[number] == _SITE else ends
            case _:
                bodies = []
        yield int(number), ends, bodies


def _left_out(m: Any, file: str) -> tuple[list[int], tuple[str, ...]]:
    """The top-level bodies that move and do not belong to the robot, and a warning if there are any."""
    roots = np.unique(m.body_rootid[m.body_jntnum > 0])
    mass = {int(root): float(m.body_mass[m.body_rootid == root].sum()) for root in roots}
    if not mass:
        raise RobotError(f"{file}: no body in it has a joint, so nothing moves; give the robot's base a <freejoint/>")
    kept = {max(mass, key=lambda root: mass[root])}
    ties = [{int(m.body_rootid[body]) for body in bodies} & set(mass) for _, _, bodies in _equalities(m)]
    while any(tie & kept and not tie <= kept for tie in ties):
        kept |= set().union(*(tie for tie in ties if tie & kept))
    if len(kept) > 1 and any(m.body_jntnum[root] and m.jnt_type[m.body_jntadr[root]] == _FREE for root in kept):
        listed = ", ".join(f'"{m.body(root).name}"' for root in sorted(kept))
        raise RobotError(
            f"{file}: equalities tie {listed} together, and a floating base can be computed only as the one top-level body that "
            'moves. Set active="false" on these equalities to compute the heaviest alone'
        )
    left = [root for root in mass if root not in kept]
    if not left:
        return [], ()
    listed = ", ".join(f'"{m.body(root).name}" ({mass[root]:.3g} kg)' for root in left)
    heaviest = m.body(max(mass, key=lambda root: mass[root])).name
    said = f'{file} holds {len(mass)} robots that move on their own: the heaviest, "{heaviest}", is computed, and {listed} left out'
    return left, (said,)


def _loops(m: Any, build: _Build) -> Iterator[Loop]:
    """The loops that active connect and weld equalities close, where MuJoCo holds them.

    MuJoCo keeps both ends in `eq_data`: of a connect the anchor in body 1 and in body 2; of a weld the anchor in body 2, then
    the frame in body 1 that is held to the frame of body 2.
    """
    carriers = {joint: body for body, joint in reversed(build.joint.items())}
    for number, ends, bodies in _equalities(m):
        if m.eq_type[number] > _WELD or not all(body in build.joint for body in bodies):
            continue
        joints = [build.joint[body] for body in bodies]
        if joints[0] == joints[1]:  # fixed to one another already
            continue
        weld, data = m.eq_type[number] == _WELD, np.array(m.eq_data[number])
        if m.eq_objtype[number] == _SITE:
            held = [_place(m.site_pos[end], m.site_quat[end]) for end in ends]
        elif weld:
            held = [_place(data[3:6], data[6:10]), pin.SE3(np.eye(3), data[:3])]
        else:
            held = [pin.SE3(np.eye(3), data[:3]), pin.SE3(np.eye(3), data[3:6])]
        places = []
        for body, joint, frame in zip(bodies, joints, held, strict=True):
            # The world's frame is its own; a body's is that of the link that its joint carries.
            base = build.place[carriers[joint]] if joint else pin.SE3.Identity()
            places.append(base.inverse() * build.place[body] * frame)
        yield Loop(
            name="–".join(m.body(carriers[joint]).name if joint else "world" for joint in joints),
            bodies=(joints[0] - 1, joints[1] - 1),
            points=(read_only(places[0].translation), read_only(places[1].translation)),
            rotations=(read_only(places[0].rotation), read_only(places[1].rotation)),
            axes=np.eye(3),
            turns=bool(weld and data[10] != 0.0),
        )


def _mimics(m: Any, build: _Build, file: str) -> tuple[Mimic, ...]:
    """The joints that active joint equalities couple: q₁ − q₁₀ = a₀ + a₁ (q₂ − q₂₀), or a constant without a second joint.

    Raises:
        RobotError: an equality couples in another way, a joint follows twice, or one has several degrees of freedom.
    """
    found: list[Mimic] = []
    for number, ends, bodies in _equalities(m):
        kind, called = int(m.eq_type[number]), m.equality(number).name
        called = f' "{called}"' if called else ""
        if kind < _JOINT or (kind == _JOINT and not all(body in build.joint for body in bodies)):
            continue
        if kind > _JOINT:
            raise RobotError(
                f"{file}: the equality{called} couples tendons or flexible parts, which is not computed, and without it the "
                'numbers would be wrong; valid are connect, weld and joint; set active="false" to do without it on purpose'
            )
        names = [m.joint(end).name if end >= 0 else "" for end in ends]
        for name, body in zip(names, bodies, strict=False):
            if m.body_jntnum[body] != 1:
                raise RobotError(
                    f'{file}: an equality couples joint "{name}", which shares body "{m.body(body).name}" with another joint; '
                    "give each of a body's joints a body"
                )
        polynomial = [float(value) for value in m.eq_data[number, :5]]
        if any(polynomial[2:]) and names[1]:
            raise RobotError(
                f"{file}: the equality joint{called} couples joints by a curve, polycoef {' '.join(f'{a:g}' for a in polynomial)}; "
                "only proportion can be computed: give it as a0 a1 0 0 0, the slope at the posture of interest"
            )
        if any(mimic.joint == names[0] for mimic in found):
            raise RobotError(
                f'{file}: two equalities have joint1="{names[0]}", and a joint can follow only once; turn one of them round '
                '(joint1 and joint2 exchanged, polycoef="-a0/a1 1/a1 0 0 0"), or set active="false" to do without it'
            )
        rest = [float(m.qpos0[m.jnt_qposadr[end]]) if end >= 0 else 0.0 for end in ends]
        slope = polynomial[1] if names[1] else 0.0
        found.append(Mimic(names[0], names[1], slope, rest[0] + polynomial[0] - slope * rest[1]))
    return leaders_first(found, build.model, file)


def _postures(
    m: Any, keys: tuple[tuple[str, tuple[float, ...]], ...], order: Array, file: str
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """The keyframes as configurations (nq,), and a warning for each that does not fit the model."""
    postures: dict[str, Array] = {}
    warnings: list[str] = []
    for name, values in keys:
        qpos = np.array(values or m.qpos0)
        if len(qpos) != m.nq or not np.isfinite(qpos).all():
            warnings.append(f'{file}: keyframe "{name}" does not hold {m.nq} finite numbers; the posture is left out')
            continue
        for joint in np.flatnonzero(m.jnt_type < _SLIDE):
            start = int(m.jnt_qposadr[joint]) + (3 if m.jnt_type[joint] == _FREE else 0)
            length = float(np.linalg.norm(qpos[start : start + 4]))
            qpos[start : start + 4] = qpos[start : start + 4] / length if length else (1.0, 0.0, 0.0, 0.0)
        postures[name] = read_only(qpos[order])
    return postures, tuple(warnings)
