"""The robot of an MJCF, from the model that MuJoCo compiled.

The bodies of a compiled model and the links of the robot have the same names: `compiled` names
those that have none, so that `model.body(i).name` is the name of a link in `Robot.frames`, whose
frame is MuJoCo's body frame. A MuJoCo body without joints belongs to the body that carries it.
`model.geom_bodyid`, `geom_pos` and `geom_quat` place a geom in its link's frame.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from shockpc.core.spatial import Array, read_only
from shockpc.robot.bodies_and_joints import Loop
from shockpc.robot.files.reading import parse_xml
from shockpc.robot.mjcf.actuators import armature_of, gear_ratios_of, motors_of, springs_of
from shockpc.robot.mjcf.compiled import Compiled, compiled, insert_includes
from shockpc.robot.mjcf.equalities import equalities_of, frame_at, loops_of, mimics_of
from shockpc.robot.mjcf.kinds import BALL, FREE, HINGE, MESH, SLIDE
from shockpc.robot.mjcf.several import RobotBodies, choose
from shockpc.robot.pinocchio_joints import add_joint, axis_joint, has_free_base, rotation
from shockpc.robot.robot import Robot, RobotSource
from shockpc.robot.tolerances import refuse_number, refuse_tree
from shockpc.text.errors import RobotError

__all__ = ["build", "choose", "qpos_order", "qvel_order", "read"]

# Where Pinocchio's coordinates of a joint are among MuJoCo's, whose quaternions begin with the
# scalar part.
_COORDINATES = {FREE: (0, 1, 2, 4, 5, 6, 3), BALL: (1, 2, 3, 0), SLIDE: (0,), HINGE: (0,)}
_BASE = slice(0, 7)  # coordinates of a floating base: its position and quaternion


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
    numbers, notes = chosen
    _refuse_numbers(m)
    model = _model(m, numbers)
    model.name = source.robot_name
    # Both count bodies, and the joints of a body, in the same order.
    joints = np.flatnonzero(np.isin(m.jnt_bodyid, numbers)).tolist()
    _set_limits(m, model, joints)
    dofs = np.isin(m.dof_jntid, joints)
    model.armature = armature_of(m)[dofs]
    model.damping = np.reshape(m.dof_damping, (m.nv, -1))[dofs, 0]
    if has_free_base(model) and model.armature[0]:
        notes += (_add_armature_to_base(model),)

    order = _order(m, joints)
    postures, left_out = _postures(file, order)
    warnings = (*file.warnings, *notes, *left_out)
    robot = Robot(source, model, pin.neutral(model), postures, (), (), warnings)
    equalities = [equality for equality in equalities_of(m) if {*equality.bodies} <= {*numbers}]
    robot = _with_loops(robot, tuple(loops_of(m, robot, equalities)), m.qpos0[order])
    springs = springs_of(m, joints)
    relaxed = None
    if springs:
        relaxed = read_only(np.array(m.qpos_spring[order]))
    return replace(
        robot,
        mimics=mimics_of(m, equalities),
        springs=springs,
        relaxed=relaxed,
        gear_ratios=gear_ratios_of(m, joints),
        motors=motors_of(m, joints),
    )


def _refuse_numbers(m: Any) -> None:
    """Refuse a tree that is too deep, and masses, inertias and positions that are too large."""
    names = ["", *(m.body(body).name for body in range(1, m.nbody))]  # that of the world is empty
    carriers = [names[parent] for parent in m.body_parentid]
    refuse_tree(dict(zip(names[1:], carriers[1:], strict=True)))
    for quantity, unit in (("mass", "kg"), ("inertia", "kg m²"), ("pos", "m"), ("ipos", "m")):
        of_bodies = np.reshape(getattr(m, f"body_{quantity}"), (m.nbody, -1))
        largest = np.abs(of_bodies).max(axis=1)
        for name, value in zip(names, largest, strict=True):
            refuse_number(f'body "{name}"', quantity, value, unit)


def _set_limits(m: Any, model: pin.Model, joints: Sequence[int]) -> None:
    """Give a model the limits of positions and efforts of its hinge and slide joints."""
    limited = np.flatnonzero(m.jnt_limited & (m.jnt_type >= SLIDE))
    positions = np.tile([-np.inf, np.inf], (m.nq, 1))
    positions[m.jnt_qposadr[limited]] = m.jnt_range[limited]
    order = _order(m, joints)
    model.lowerPositionLimit = positions[order, 0]
    model.upperPositionLimit = positions[order, 1]

    of_dof = m.dof_jntid
    limited = m.jnt_actfrclimited[of_dof] & (m.jnt_type[of_dof] >= SLIDE)
    largest = np.abs(m.jnt_actfrcrange[of_dof]).max(axis=1)
    efforts = np.where(limited, largest, np.inf)
    model.upperEffortLimit = efforts[np.isin(of_dof, joints)]


def _add_armature_to_base(model: pin.Model) -> str:
    """Move the armature of a free base into its inertia; return a warning."""
    extra = float(model.armature[0])
    model.armature[:6] = 0.0
    base = model.frames[model.getFrameId(model.names[1], pin.FrameType.JOINT)]
    base.inertia = pin.Inertia(extra, np.zeros(3), extra * np.eye(3))
    model.inertias[1] += base.inertia
    return (
        f'joint "{model.names[1]}" is free and has armature {extra:g}, which adds {extra:g} kg and '
        f"{extra:g} kg m² to the base, as in MuJoCo; if that is not meant, set "
        f'armature="0" there or use a <freejoint/>'
    )


def _with_loops(robot: Robot, loops: tuple[Loop, ...], drawn: Array) -> Robot:
    """A robot with its loops, and its start where they close.

    A weld of a floating base to the world is no loop: it fixes the base where it holds it,
    whatever a keyframe says, unless the base is to move.

    Args:
        robot: without loops.
        loops: of its equalities.
        drawn: (nq,) the configuration in which the file draws it.
    """
    if not has_free_base(robot.model):
        return replace(robot, loops=loops, start=read_only(robot.start))
    welds = [loop for loop in loops if _welds_base(loop)]
    loops = tuple(loop for loop in loops if not _welds_base(loop))
    robot = replace(robot, loops=loops)
    start = np.array(robot.start)
    if any(-1 in loop.bodies for loop in loops):
        # The ends of a loop through the world meet where the base is drawn.
        start[_BASE] = drawn[_BASE]
    if welds and robot.source.freed:
        released = (
            f'the weld of "{robot.bodies[0].name}" to the world is left out, because the base is '
            f"to move"
        )
        robot = replace(robot, notes=(*robot.notes, released))
    elif welds:
        start[_BASE] = _welded_place(welds[0])
        postures = {
            name: read_only([*start[_BASE], *q[_BASE.stop :]]) for name, q in robot.postures.items()
        }
        robot = replace(robot, postures=postures, welded=True)
    return replace(robot, start=read_only(start))


def _welds_base(loop: Loop) -> bool:
    """True if a loop of a robot with a floating base holds the base in the world.

    It holds its place and its orientation.
    """
    return loop.holds_orientation and set(loop.bodies) == {-1, 0}


def _welded_place(weld: Loop) -> Array:
    """Position and quaternion (7,) at which a weld holds the base in the world."""
    ends = {}
    for body, R, p in zip(weld.bodies, weld.rotations, weld.points, strict=True):
        ends[body] = pin.SE3(R, p)
    in_world, in_base = ends[-1], ends[0]
    return np.asarray(pin.SE3ToXYZQUAT(in_world * in_base.inverse()))


def qpos_order(robot: Robot) -> tuple[np.ndarray, int]:
    """The indices of the coordinates q (nq,) of a robot of an MJCF in MuJoCo's qpos.

    The second value is the length of qpos.

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
    """The indices of the velocities q̇ (nv,) of a robot of an MJCF in MuJoCo's qvel.

    The second value is the length of qvel.

    Raises:
        RobotError: as for `qpos_order`.
    """
    qpos_order(robot)
    m = compiled(robot.source).model
    order: list[int] = []
    for joint in robot.single_joints:
        first = int(m.jnt_dofadr[m.joint(joint.name).id])
        order += range(first, first + joint.v.stop - joint.v.start)
    return np.array(order), int(m.nv)


def _order(m: Any, joints: Sequence[int]) -> np.ndarray:
    """Where the coordinates of some joints stand in qpos."""
    order: list[int] = []
    for joint in joints:
        first = int(m.jnt_qposadr[joint])
        order += [first + k for k in _COORDINATES[int(m.jnt_type[joint])]]
    return np.array(order)


def _model(m: Any, bodies: Sequence[int]) -> pin.Model:
    """The model of some bodies, carriers first, with their sites and named collision geoms.

    Many geoms are feet.
    """
    model = pin.Model()
    # The joint of each body, and the body's frame in it.
    placements: dict[int, tuple[int, pin.SE3]] = {}
    carrying = {0: 0}  # the frame of each body
    for body in bodies:
        joint, placement = 0, pin.SE3.Identity()
        if body:
            parent = int(m.body_parentid[body])
            joint, carrier = placements[parent]
            placement = carrier * frame_at(m.body_pos[body], m.body_quat[body])
            above = carrying[parent]
            first = int(m.body_jntadr[body])
            numbers = range(first, first + int(m.body_jntnum[body]))
            if numbers:
                joint, placement = _add_joint(m, model, joint, placement, numbers)
                above = 0
            carrying[body] = _add_body(m, model, body, joint, above, placement)
        placements[body] = joint, placement
        _add_sites_and_geoms(m, model, body, joint, placement)
    return model


def _add_body(
    m: Any, model: pin.Model, body: int, joint: int, above: int, placement: pin.SE3
) -> int:
    """Add a body to a model; return the index of its frame.

    Args:
        m: the compiled model.
        model: which gets the frame.
        body: its number.
        joint: that carries it.
        above: frame of the parent to which it is fixed; 0 if it has a joint of its own.
        placement: its frame in that of the joint.
    """
    name = m.body(body).name
    if name == "universe":
        raise RobotError(
            'body "universe" has the name that Pinocchio gives to the world; rename it'
        )
    R = rotation(m.body_iquat[body])
    moments = R @ np.diag(m.body_inertia[body]) @ R.T
    symmetric = (moments + moments.T) / 2.0
    inertia = pin.Inertia(float(m.body_mass[body]), np.array(m.body_ipos[body]), symmetric)
    frame = pin.Frame(name, joint, above, placement, pin.FrameType.BODY, inertia)
    return int(model.addFrame(frame))


def _add_sites_and_geoms(
    m: Any, model: pin.Model, body: int, joint: int, placement: pin.SE3
) -> None:
    """Add the named sites and collision geoms of a body as frames; the first of a name counts."""
    collides = (m.geom_contype | m.geom_conaffinity) != 0
    solid = (m.geom_bodyid == body) & (m.geom_type != MESH) & collides
    site, geom = pin.FrameType.OP_FRAME, pin.FrameType.SENSOR
    items = [(m.site(number), site) for number in np.flatnonzero(m.site_bodyid == body)]
    items += [(m.geom(number), geom) for number in np.flatnonzero(solid)]
    for item, kind in items:
        known = model.existFrame(item.name, site) or model.existFrame(item.name, geom)
        if item.name and not known:
            frame = pin.Frame(item.name, joint, 0, placement * frame_at(item.pos, item.quat), kind)
            model.addFrame(frame, False)


def _add_joint(
    m: Any, model: pin.Model, carrier: int, placement: pin.SE3, numbers: range
) -> tuple[int, pin.SE3]:
    """Add the joint of a body to a model; return its index, and the body's frame in the joint's.

    Args:
        m: the compiled model.
        model: which gets the joint.
        carrier: joint that carries it.
        placement: frame of the body in that of the carrier.
        numbers: of its MuJoCo joints; several make one composite joint.
    """
    name = "+".join(m.joint(number).name for number in numbers)
    if model.existJointName(name) or name.count("+") >= max(len(numbers), 2):
        raise RobotError(
            f'joint "{name}" has a name that is used here for something else; rename it',
            joints=[name],
        )
    if m.jnt_type[numbers[0]] == FREE:
        # It stands where its configuration says; its place in the file is only a start.
        free = pin.JointModelFreeFlyer()
        return add_joint(model, carrier, free, pin.SE3.Identity(), name), pin.SE3.Identity()
    parts, steps = [], []
    for number in numbers:
        anchor = pin.SE3(np.eye(3), np.array(m.jnt_pos[number]))
        part, at_rest = _single_joint(m, number)
        parts.append(part)
        steps.append(placement * anchor * at_rest)
        placement = anchor.inverse()
    joint = parts[0]
    if len(parts) > 1:
        joint = pin.JointModelComposite()
        joint.addJoint(parts[0], pin.SE3.Identity())
        for part, step in zip(parts[1:], steps[1:], strict=True):
            joint.addJoint(part, step)
    return add_joint(model, carrier, joint, steps[0], name), placement


def _single_joint(m: Any, number: int) -> tuple[Any, pin.SE3]:
    """A ball, slide or hinge joint, and its frame at coordinate 0 in its frame as drawn."""
    kind = int(m.jnt_type[number])
    axis = np.array(m.jnt_axis[number])
    drawn = float(m.qpos0[m.jnt_qposadr[number]])
    at_rest = pin.SE3.Identity()
    if kind == SLIDE:
        at_rest.translation = -drawn * axis
        return axis_joint("prismatic", *axis.tolist()), at_rest
    if kind == HINGE:
        at_rest.rotation = pin.AngleAxis(-drawn, axis).matrix()
        return axis_joint("revolute", *axis.tolist()), at_rest
    return pin.JointModelSpherical(), at_rest


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
