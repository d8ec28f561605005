"""The robot of an MJCF, from the model that MuJoCo compiled.

The bodies of a compiled model and the links of the robot have the same names: `compiled` names
those that have none, so that `model.body(i).name` is the name of a link in `Robot.frames`, whose
frame is MuJoCo's body frame. A MuJoCo body without joints belongs to the body that carries it.
`model.geom_bodyid`, `geom_pos` and `geom_quat` place a geom in its link's frame.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.elements import Frame, Loop, Mimic
from shockpc.robot.mjcf_compiled import Compiled, compiled, insert_includes
from shockpc.robot.reading import parse_xml
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.tolerances import refuse_number, refuse_tree
from shockpc.robot.tree import add_joint, axis_joint, rotation
from shockpc.text.errors import RobotError
from shockpc.text.names import matches
from shockpc.text.printed import listed

_FREE, _BALL, _SLIDE, _HINGE = range(4)  # mjtJoint
_CONNECT, _WELD, _JOINT, _TENDON = range(4)  # mjtEq
_WRAPPED_JOINT = 1  # mjtWrap
_MESH = 7  # mjtGeom; its frame depends on the file of the mesh
_SITE = 6  # mjtObj
_NO_EQUALITY = 2  # mjtDisableBit
# Where Pinocchio's coordinates of a joint are among MuJoCo's, whose quaternions begin with the
# scalar part.
_COORDINATES = {_FREE: (0, 1, 2, 4, 5, 6, 3), _BALL: (1, 2, 3, 0), _SLIDE: (0,), _HINGE: (0,)}

Equality: TypeAlias = tuple[int, list[int], list[int]]
"""Its number, its objects (−1 for none), and their bodies (0 for the world)."""


class RobotBodies(NamedTuple):
    """The bodies of an MJCF that belong to one robot: their numbers, with the world and what is
    fixed to it, and warnings.
    """

    numbers: tuple[int, ...]
    warnings: tuple[str, ...]


def read(source: RobotSource, xacro: Mapping[str, str]) -> RobotSource:
    """Insert the includes of an MJCF; neither xacro nor an SRDF belongs to it."""
    name = source.path.name
    if source.srdf is not None:
        remedy = "leave it out, or write its postures as <key> elements of a <keyframe>"
        raise RobotError(
            f"{name} is an MJCF, so the SRDF {source.srdf.name} has no effect; {remedy}"
        )
    return replace(source, xml=insert_includes(parse_xml(source.xml, name), source.folders))


def build(source: RobotSource, chosen: RobotBodies) -> Robot:
    """Build the Pinocchio model of a robot of an MJCF.

    A body with several joints has one composite joint. A free base stands where its configuration
    says; `body_pos` is only where it starts. Its armature, which MuJoCo adds to the inertia matrix
    like any other, is added to the base as mass and rotational inertia at the body's frame, which
    gives the same matrix; no joint model takes it away.

    Raises:
        RobotError: MuJoCo refuses the file, or it holds a coupling that cannot be computed.
    """
    file = compiled(source)
    m = file.model
    names = [m.body(body).name if body else "" for body in range(m.nbody)]
    refuse_tree({names[body]: names[m.body_parentid[body]] for body in range(1, m.nbody)})
    for what, unit in (("mass", "kg"), ("inertia", "kg m²"), ("pos", "m"), ("ipos", "m")):
        for name, value in zip(
            names, np.abs(getattr(m, f"body_{what}")).reshape(m.nbody, -1).max(axis=1), strict=True
        ):
            refuse_number(f'body "{name}"', what, value, unit)
    numbers, notes = chosen
    model = _model(m, numbers)
    model.name = source.robot_name
    # Both count bodies, and the joints of a body, in the same order.
    joints = np.flatnonzero(np.isin(m.jnt_bodyid, numbers)).tolist()
    order = _order(m, joints)
    limited = np.flatnonzero(m.jnt_limited & (m.jnt_type >= _SLIDE))
    limits = np.tile([-np.inf, np.inf], (m.nq, 1))
    limits[m.jnt_qposadr[limited]] = m.jnt_range[limited]
    model.lowerPositionLimit, model.upperPositionLimit = limits[order].T
    limited = m.jnt_actfrclimited[m.dof_jntid] & (m.jnt_type[m.dof_jntid] >= _SLIDE)
    effort = np.where(limited, np.abs(m.jnt_actfrcrange[m.dof_jntid]).max(axis=1), np.inf)
    model.upperEffortLimit = effort[np.isin(m.dof_jntid, joints)]
    model.armature = _armature(m)[np.isin(m.dof_jntid, joints)]
    model.damping = np.reshape(m.dof_damping, (m.nv, -1))[np.isin(m.dof_jntid, joints), 0]
    floats = model.joints[1].shortname() == "JointModelFreeFlyer"
    if floats:
        extra = float(model.armature[0])
        model.armature[:6] = 0.0
        if extra:
            base = model.frames[model.getFrameId(model.names[1], pin.FrameType.JOINT)]
            base.inertia = pin.Inertia(extra, np.zeros(3), extra * np.eye(3))
            model.inertias[1] += base.inertia
            notes += (
                f'joint "{model.names[1]}" is free and has armature {extra:g}, which adds '
                f"{extra:g} kg and "
                f"{extra:g} kg m² to the base, as in MuJoCo; if that is not meant, set "
                f'armature="0" there or use a <freejoint/>',
            )
    start = pin.neutral(model)
    postures, left_out = _postures(file, order)
    robot = Robot(source, model, start, postures, (), (), (*file.warnings, *notes, *left_out))
    equalities = [equality for equality in _equalities(m) if set(equality[2]) <= set(numbers)]
    loops = tuple(_loops(m, robot, equalities))
    welds = [loop for loop in loops if floats and _welds_base(loop)]
    loops = tuple(loop for loop in loops if not (floats and _welds_base(loop)))
    if floats and any(-1 in loop.bodies for loop in loops):  # where they meet
        start[:7] = m.qpos0[order][:7]
    if welds and source.freed:
        released = (
            f'the weld of "{robot.bodies[0].name}" to the world is left out, because the base is '
            f"to move"
        )
        robot = replace(robot, notes=(*robot.notes, released))
    elif welds:  # where it holds the base, whatever a keyframe says
        ends = {
            body: pin.SE3(*end)
            for body, *end in zip(welds[0].bodies, welds[0].rotations, welds[0].points, strict=True)
        }
        start[:7] = pin.SE3ToXYZQUAT(ends[-1] * ends[0].inverse())
        references = {name: read_only([*start[:7], *q[7:]]) for name, q in postures.items()}
        robot = replace(robot, postures=references, welded=True)
    springs, gear_ratios = _springs_and_ratios(m, joints)
    start, relaxed = (
        read_only(start),
        read_only(np.array(m.qpos_spring[order])) if springs else None,
    )
    mimics = _mimics(m, equalities)
    robot = replace(
        robot, start=start, loops=loops, mimics=mimics, springs=springs, relaxed=relaxed
    )
    return replace(robot, gear_ratios=gear_ratios, motors=_motors(m, joints))


def _welds_base(loop: Loop) -> bool:
    """Whether a loop of a robot with a floating base holds the place and the orientation of the
    base in the world.
    """
    return loop.holds_orientation and set(loop.bodies) == {-1, 0}


def qpos_order(robot: Robot) -> tuple[np.ndarray, int]:
    """Where the coordinates q (nq,) of a robot of an MJCF stand in MuJoCo's qpos, and the length of
    qpos.

    Raises:
        RobotError: the robot is not of an MJCF.
    """
    if robot.source.kind != "mjcf":
        raise RobotError(
            f'robot "{robot.name}" is not of an MJCF, so the order of a qpos is not known; give '
            f"the joints by name, as columns of "
            "a table (q_knee, x, y, z, qw, qx, qy, qz) or in Python: "
            'configuration(robot, joints={"knee": 0.3}, base=qpos[:7], quaternion="wxyz")'
        )
    m = compiled(robot.source).model
    return _order(m, [m.joint(joint.name).id for joint in robot.single_joints]), int(m.nq)


def qvel_order(robot: Robot) -> tuple[np.ndarray, int]:
    """Where the velocities q̇ (nv,) of a robot of an MJCF stand in MuJoCo's qvel, and the length of
    qvel.

    Raises:
        RobotError: as for `qpos_order`.
    """
    qpos_order(robot)
    m = compiled(robot.source).model
    first = [
        (m.jnt_dofadr[m.joint(joint.name).id], joint.v.stop - joint.v.start)
        for joint in robot.single_joints
    ]
    return np.array([start + k for start, size in first for k in range(size)]), int(m.nv)


def _order(m: Any, joints: Sequence[int]) -> np.ndarray:
    """Where the coordinates of some joints stand in qpos."""
    return np.array(
        [m.jnt_qposadr[joint] + k for joint in joints for k in _COORDINATES[int(m.jnt_type[joint])]]
    )


def _model(m: Any, bodies: Sequence[int]) -> pin.Model:
    """The model of some bodies, carriers first, with their sites and named collision geoms (many
    are feet).
    """
    model = pin.Model()
    places: dict[int, tuple[int, pin.SE3]] = {}
    carrying = {0: 0}  # the frame of each body
    for body in bodies:
        joint, place = 0, pin.SE3.Identity()
        if body:
            (joint, carrier), first = places[int(m.body_parentid[body])], int(m.body_jntadr[body])
            place = carrier * _place(m.body_pos[body], m.body_quat[body])
            if m.body_jntnum[body]:
                joint, place = _add_joint(
                    m, model, joint, place, range(first, first + int(m.body_jntnum[body]))
                )
            R = rotation(m.body_iquat[body])
            moments = R @ np.diag(m.body_inertia[body]) @ R.T
            inertia = pin.Inertia(
                float(m.body_mass[body]), np.array(m.body_ipos[body]), (moments + moments.T) / 2.0
            )
            if (name := m.body(body).name) == "universe":
                raise RobotError(
                    'body "universe" has the name that Pinocchio gives to the world; rename it'
                )
            # A body without joints is fixed to its parent.
            above = 0 if m.body_jntnum[body] else carrying[int(m.body_parentid[body])]
            carrying[body] = model.addFrame(
                pin.Frame(name, joint, above, place, pin.FrameType.BODY, inertia)
            )
        places[body] = joint, place
        items = [
            (m.site(number), pin.FrameType.OP_FRAME)
            for number in np.flatnonzero(m.site_bodyid == body)
        ]
        solid = (
            (m.geom_bodyid == body)
            & (m.geom_type != _MESH)
            & ((m.geom_contype | m.geom_conaffinity) != 0)
        )
        items += [(m.geom(number), pin.FrameType.SENSOR) for number in np.flatnonzero(solid)]
        for item, kind in items:
            if item.name and not any(
                model.existFrame(item.name, other)
                for other in (pin.FrameType.OP_FRAME, pin.FrameType.SENSOR)
            ):
                model.addFrame(
                    pin.Frame(item.name, joint, 0, place * _place(item.pos, item.quat), kind), False
                )
    return model


def _add_joint(
    m: Any, model: pin.Model, carrier: int, place: pin.SE3, numbers: range
) -> tuple[int, pin.SE3]:
    """Add the joint of a body placed so in the carrier's frame; return its index, and the body's
    frame in the joint's.
    """
    name = "+".join(m.joint(number).name for number in numbers)
    if model.existJointName(name) or name.count("+") >= max(len(numbers), 2):
        raise RobotError(
            f'joint "{name}" has a name that is used here for something else; rename it',
            joints=[name],
        )
    # it stands where its configuration says; its place in the file is only a start
    if m.jnt_type[numbers[0]] == _FREE:
        return add_joint(
            model, carrier, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name
        ), pin.SE3.Identity()
    parts, steps = [], []
    for number in numbers:
        anchor = pin.SE3(np.eye(3), np.array(m.jnt_pos[number]))
        kind, axis, drawn = (
            int(m.jnt_type[number]),
            np.array(m.jnt_axis[number]),
            float(m.qpos0[m.jnt_qposadr[number]]),
        )
        # Where its coordinate is 0, in the frame where it is `drawn`, its value in the model as
        # drawn.
        rest, part = pin.SE3.Identity(), pin.JointModelSpherical()
        if kind == _SLIDE:
            rest.translation, part = -drawn * axis, axis_joint("prismatic", *axis.tolist())
        elif kind == _HINGE:
            rest.rotation, part = (
                pin.AngleAxis(-drawn, axis).matrix(),
                axis_joint("revolute", *axis.tolist()),
            )
        parts.append(part)
        steps.append(place * anchor * rest)
        place = anchor.inverse()
    joint = parts[0]
    if len(parts) > 1:
        joint = pin.JointModelComposite()
        for part, step in zip(parts, [pin.SE3.Identity(), *steps[1:]], strict=True):
            joint.addJoint(part, step)
    return add_joint(model, carrier, joint, steps[0], name), place


def _place(position: Array, quaternion: Array) -> pin.SE3:
    """A frame from its origin and its quaternion, whose scalar part comes first."""
    return pin.SE3(rotation(quaternion), np.array(position))


def _armature(m: Any) -> Array:
    """Reflected inertia (nv,) of joints, and of actuators that act on a joint: gear² times the
    actuator's.
    """
    armature = np.array(m.dof_armature)
    refused = [
        ("tendon", m.tendon(number).name)
        for number in np.flatnonzero(getattr(m, "tendon_armature", ()))
    ]
    for number in np.flatnonzero(getattr(m, "actuator_armature", ())):
        joint = int(m.actuator_trnid[number, 0])
        if m.actuator_trntype[number] > 1 or m.jnt_type[joint] < _SLIDE:
            refused.append(("actuator", m.actuator(number).name))
        else:
            armature[m.jnt_dofadr[joint]] += (
                m.actuator_armature[number] * m.actuator_gear[number, 0] ** 2
            )
    refused += [("joint", m.joint(m.dof_jntid[dof]).name) for dof in np.flatnonzero(armature < 0)]
    for kind, name in refused:
        remedy = (
            "give one not below zero to the hinge or slide joints, that of an actuator times "
            "gear², or set it to 0"
        )
        raise RobotError(f'{kind} "{name}" has an armature that is not computed; {remedy}')
    return armature


def _springs_and_ratios(m: Any, joints: Sequence[int]) -> tuple[dict[str, float], dict[str, float]]:
    """Stiffness of the joints with a spring, and gear of the actuators of joints without reflected
    inertia, by joint.
    """
    stiffness = np.reshape(m.jnt_stiffness, (m.njnt, -1))[:, 0]
    springs = {
        m.joint(joint).name: float(stiffness[joint])
        for joint in joints
        if stiffness[joint] > 0 and m.jnt_type[joint]
    }
    armature, ratios = _armature(m), {}
    for number in np.flatnonzero(m.actuator_trntype <= 1):  # acts on a joint
        joint, gear = int(m.actuator_trnid[number, 0]), float(m.actuator_gear[number, 0])
        if (
            joint in joints
            and m.jnt_type[joint] >= _SLIDE
            and gear != 1.0
            and not armature[m.jnt_dofadr[joint]]
        ):
            ratios[m.joint(joint).name] = gear
    return springs, ratios


def _motors(m: Any, joints: Sequence[int]) -> dict[str, float]:
    """What the actuators of joints can exert, by joint; infinite where the file gives no limit [N
    m, N].

    The force of an actuator is limited by its forcerange; that of a motor, whose force is its
    control, by its ctrlrange too. Its gear multiplies it.
    """
    motors: dict[str, float] = {}
    for number in np.flatnonzero(m.actuator_trntype <= 1):
        joint, force = int(m.actuator_trnid[number, 0]), np.inf
        if m.actuator_forcelimited[number]:
            force = np.abs(m.actuator_forcerange[number]).max()
        if (
            m.actuator_ctrllimited[number]
            and m.actuator_gaintype[number] == m.actuator_biastype[number] == 0
        ):
            control = np.abs(m.actuator_ctrlrange[number]).max()
            force = min(force, abs(m.actuator_gainprm[number, 0]) * control)
        if joint in joints and m.jnt_type[joint] >= _SLIDE:
            motors[m.joint(joint).name] = float(force * abs(m.actuator_gear[number, 0]))
    return motors


def _equalities(m: Any) -> Iterator[Equality]:
    for number in np.flatnonzero(m.eq_active0 * (not m.opt.disableflags & _NO_EQUALITY)):
        ends = [int(m.eq_obj1id[number]), int(m.eq_obj2id[number])]
        match int(m.eq_type[number]):
            case 2 | 3 as kind:  # joint, tendon
                bodies = [
                    int(m.jnt_bodyid[joint]) for end in ends for joint in _terms(m, kind, end) or ()
                ]
            case 0 | 1:  # connect, weld
                bodies = (
                    [int(m.site_bodyid[end]) for end in ends]
                    if m.eq_objtype[number] == _SITE
                    else ends
                )
            case _:
                bodies = []
        yield int(number), ends, bodies


def choose(source: RobotSource, frames: Sequence[str]) -> RobotBodies:
    """Choose the robot of an MJCF that holds several, with a warning of the others.

    It is the one that has the first of the `frames` asked for, names or globs of bodies, sites and
    geoms, or else the most joints, with those that equalities couple to it.

    Raises:
        RobotError: as `compiled`; nothing moves, or a floating base is coupled to another body.
    """
    m = compiled(source).model
    roots = np.unique(m.body_rootid[m.body_jntnum > 0])
    mass = {int(root): float(m.body_mass[m.body_rootid == root].sum()) for root in roots}
    if not mass:
        raise RobotError(
            "no body in it has a joint, so nothing moves; give the robot's base a <freejoint/>"
        )
    owners = ((m.body, range(m.nbody)), (m.site, m.site_bodyid), (m.geom, m.geom_bodyid))
    places = [(item(k).name, int(body)) for item, bodies in owners for k, body in enumerate(bodies)]
    wanted = [
        name for frame in frames for name in matches(frame, (name for name, _ in places if name))
    ]
    matching = [int(m.body_rootid[body]) for one in wanted for name, body in places if name == one]
    # a box may weigh more
    largest = max(
        mass, key=lambda root: (int(m.body_jntnum[m.body_rootid == root].sum()), mass[root])
    )
    chosen = next((root for root in matching if root in mass), largest)
    coupled_roots = {chosen}
    couplings = [
        {int(m.body_rootid[body]) for body in bodies} & set(mass) for _, _, bodies in _equalities(m)
    ]
    while any(coupling & coupled_roots and not coupling <= coupled_roots for coupling in couplings):
        coupled_roots |= set().union(
            *(coupling for coupling in couplings if coupling & coupled_roots)
        )
    if len(coupled_roots) > 1 and any(
        m.body_jntnum[root] and m.jnt_type[m.body_jntadr[root]] == _FREE for root in coupled_roots
    ):
        coupled = listed(m.body(root).name for root in sorted(coupled_roots))
        remedy = (
            "with a floating base only one top-level body that moves can be computed; set "
            'active="false" on them'
        )
        raise RobotError(f"equalities couple {coupled}, and {remedy}")
    others = [root for root in mass if root not in coupled_roots]
    bodies = tuple(np.flatnonzero(~np.isin(m.body_rootid, others)).tolist())
    if not others:
        return RobotBodies(bodies, ())
    left_out = ", ".join(f'"{m.body(root).name}" ({mass[root]:.3g} kg)' for root in others)
    names = " and ".join(f'"{m.body(root).name}"' for root in sorted(coupled_roots))
    computed = (
        f"{names}, {'which has the contact' if chosen in matching else 'with the most joints'}, is "
        f"computed"
    )
    return RobotBodies(
        bodies,
        (
            f"it holds {len(mass)} robots that move independently: {computed}, and {left_out} left "
            f"out",
        ),
    )


def _loops(m: Any, robot: Robot, equalities: Sequence[Equality]) -> Iterator[Loop]:
    """The loops that connect and weld equalities close, where MuJoCo holds them."""
    ground = Frame("world", -1, np.eye(3), np.zeros(3), "link")
    for number, ends, bodies in equalities:
        carried = [robot.frames[m.body(body).name] if body else ground for body in bodies]
        # the same: fixed to one another already
        if m.eq_type[number] > _WELD or carried[0].body == carried[1].body:
            continue
        # Data of a connect: the anchors in body 1 and 2; of a weld: the anchor in body 2, then the
        # frame of body 2 in body 1.
        weld, data = m.eq_type[number] == _WELD, np.array(m.eq_data[number])
        if m.eq_objtype[number] == _SITE:
            frames = [_place(m.site_pos[end], m.site_quat[end]) for end in ends]
        elif weld:
            frames = [_place(data[3:6], data[6:10]), pin.SE3(np.eye(3), data[:3])]
        else:
            frames = [pin.SE3(np.eye(3), data[:3]), pin.SE3(np.eye(3), data[3:6])]
        first, second = (
            pin.SE3(place.rotation, place.offset) * frame
            for place, frame in zip(carried, frames, strict=True)
        )
        yield Loop(
            name="–".join(
                robot.bodies[place.body].name if place.body >= 0 else ground.name
                for place in carried
            ),
            bodies=(carried[0].body, carried[1].body),
            points=(read_only(first.translation), read_only(second.translation)),
            rotations=(read_only(first.rotation), read_only(second.rotation)),
            axes=np.eye(3),
            holds_orientation=bool(weld and data[10] != 0.0),
        )


def _mimics(m: Any, equalities: Sequence[Equality]) -> tuple[Mimic, ...]:
    """The joints that equalities of joints and tendons couple: x₁ − x₁₀ = a₀ + a₁ (x₂ − x₂₀), or a
    constant without x₂.
    """
    mimics: list[Mimic] = []
    for number, ends, _ in equalities:
        kind, title = int(m.eq_type[number]), m.equality(number).name
        title = f' "{title}"' if title else ""
        if kind < _JOINT:
            continue
        if kind > _TENDON or any(_terms(m, kind, end) is None for end in ends):
            valid = (
                'valid are connect, weld, joint, and fixed tendons; set active="false" to do '
                "without it on purpose"
            )
            raise RobotError(
                f"the equality{title} couples tendons that are not fixed, or flexible parts; "
                f"{valid}"
            )
        polynomial = [float(value) for value in m.eq_data[number, :5]]
        if any(polynomial[2:]) and ends[1] >= 0:
            remedy = (
                "only proportion can be computed: give it as a0 a1 0 0 0, the slope at the posture "
                "of interest"
            )
            curve = " ".join(f"{a:g}" for a in polynomial)
            raise RobotError(
                f"the equality{title} couples joints by a curve, polycoef {curve}; {remedy}"
            )
        # x is the value of a joint, or the length of a fixed tendon, a sum of multiples of such
        # values. The equality is solved for a joint that does not follow yet, of the first object
        # if there is one, with the largest multiple.
        sums: dict[str, float] = {}
        constant = polynomial[0]
        for end, factor in zip(ends, (1.0, -polynomial[1]), strict=True):
            for joint, multiple in (_terms(m, kind, end) or {}).items():
                name = m.joint(joint).name
                sums[name] = sums.get(name, 0.0) + factor * multiple
                constant += factor * multiple * float(m.qpos0[m.jnt_qposadr[joint]])
        first = [m.joint(joint).name for joint in _terms(m, kind, ends[0]) or ()]
        free = [
            name
            for name, multiple in sums.items()
            if multiple and all(mimic.joint != name for mimic in mimics)
        ]
        if not free:
            remedy = 'and a joint can follow only once; set active="false" on one of them to do without it'
            raise RobotError(
                f"the equality{title} couples {listed(sums)}, but each of these follows already, "
                f"{remedy}",
                joints=sums,
            )
        follower = max(free, key=lambda name: (name in first, abs(sums[name])))
        leaders = {
            name: -multiple / sums[follower]
            for name, multiple in sums.items()
            if multiple and name != follower
        }
        mimics.append(Mimic(follower, leaders, constant / sums[follower]))
    return tuple(mimics)


def _terms(m: Any, kind: int, number: int) -> dict[int, float] | None:
    """The multiple of each joint in an object of an equality, none without an object; None of a
    tendon that is not fixed.
    """
    if number < 0 or kind == _JOINT:
        return {number: 1.0} if number >= 0 else {}
    wraps = range(m.tendon_adr[number], m.tendon_adr[number] + m.tendon_num[number])
    fixed = all(m.wrap_type[wrap] == _WRAPPED_JOINT for wrap in wraps)
    return {int(m.wrap_objid[wrap]): float(m.wrap_prm[wrap]) for wrap in wraps} if fixed else None


def _postures(file: Compiled, order: Array) -> tuple[dict[str, Array], tuple[str, ...]]:
    """The keyframes as configurations (nq,), and a warning for each that does not fit the model."""
    from mujoco import mj_normalizeQuat

    postures: dict[str, Array] = {}
    warnings: list[str] = []
    m = file.model
    for name, values in file.keys:
        qpos = np.array(values or m.qpos0)
        if len(qpos) != m.nq or not np.isfinite(qpos).all():
            warnings.append(
                f'keyframe "{name}" does not hold {m.nq} finite numbers; the posture is left out'
            )
            continue
        mj_normalizeQuat(m, qpos)
        postures[name] = read_only(qpos[order])
    return postures, tuple(warnings)
