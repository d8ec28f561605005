"""The constant forces of a landing: gravity, torques of motors, and loads of springs.

The loads are those that springs of joints carry at touchdown.

Before touchdown the robot falls freely. Motors then need no torque to hold a posture, but for what
loaded springs press on them: these torques they keep by default. They do not carry the weight, so
the robot begins to collapse, which has little effect in milliseconds.

Links that bend are straight at touchdown and do not vibrate: their hinges carry from the start what
they carry in a robot of rigid links that falls with the same forces.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.contact_rows import ContactRows
from shockpc.landing.before_impact import mass_lifted
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.strike import GRAVITY


class ConstantForces(NamedTuple):
    """The constant forces of a landing in m coordinates.

    Attributes:
        gravity: (m,) accelerations under gravity only [rad/s², m/s²].
        fall: (m,) the same while links stay straight, as before touchdown.
        torque: (nv,) of the motors [N m, N].
        load: (nv,) of the springs of joints and of hinges at touchdown [N m, N].
    """

    gravity: Array
    fall: Array
    torque: Array
    load: Array


def constant_forces(landing: PosedLanding, rows: ContactRows, free: Array) -> ConstantForces:
    """The constant forces of a landing. Args: as of `free_fall`.

    With forces p on the coordinates, and motions N of the coordinates that leave hinges straight, a
    robot of rigid links accelerates by a = N (Nᵀ M N)⁻¹ Nᵀ p. The loads f of the hinges are those
    with which the others do so too: Sᵀ f = M a − p, with the rates S of the hinges.
    """
    gravity, load, hinges = free_fall(landing, rows, free), spring_loads(landing), landing.hinges
    if not len(hinges):
        torque = motor_torques(landing, load, rows.M, rows.J, free, gravity)
        return ConstantForces(gravity, gravity, torque, load)
    S = free[hinges]
    N = _motions_without(S)
    M = N.T @ rows.M @ N
    fall: Array = np.asarray(np.linalg.solve(M, N.T @ rows.M @ gravity))
    torque = motor_torques(landing, load, M, rows.J @ N, free @ N, fall)
    # a = N (Nᵀ M N)⁻¹ Nᵀ p, and Sᵀ f = M a − p
    p = rows.M @ gravity + free.T @ (torque + load)
    a = N @ np.linalg.solve(M, N.T @ p)
    load[hinges] = np.linalg.lstsq(S.T, rows.M @ a - p, rcond=1e-9)[0]
    return ConstantForces(gravity, N @ fall, torque, load)


def _motions_without(S: Array) -> Array:
    """Motions (m, n − rank) of the coordinates in which no row of S (h, m) has a rate."""
    _, sizes, motions = np.linalg.svd(S)
    rank = int(np.count_nonzero(sizes > 1e-9 * sizes[0]))
    return np.asarray(motions[rank:].T)


def free_fall(landing: PosedLanding, rows: ContactRows, free: Array) -> Array:
    """Accelerations (m,) of the coordinates under gravity only [rad/s², m/s²].

    They are zero where the scene leaves gravity out.

    Every body of a robot whose base is free has that of gravity; no joint has any. A base that
    moves in a plane has the part in it.

    Args:
        landing: the landing.
        rows: its coordinates and their inertia.
        free: (nv, m) joint velocities for unit rates of the coordinates.
    """
    if not landing.scene.gravity:
        return np.zeros(free.shape[1])
    state, falling = landing.state, np.zeros(len(free))
    if not landing.robot.free_base:
        weight = -GRAVITY * mass_lifted(landing.robot, state)
        return np.asarray(np.linalg.solve(rows.M, free.T @ weight))
    falling[:6] = np.linalg.solve(state.J[0, :, :6], [0.0, 0.0, 0.0, 0.0, 0.0, -GRAVITY])
    return np.asarray(np.linalg.solve(rows.M, free.T @ (state.H[0] @ falling)))


def spring_loads(landing: PosedLanding) -> Array:
    """Torques (nv,) that springs of joints give at touchdown [N m, N].

    A spring gives −k times its deflection from `springref`.

    Without gravity the springs are not loaded either: before touchdown its effects and theirs
    balance.
    """
    model = landing.joint_model
    if not landing.scene.gravity:
        return np.zeros(len(model.stiffness))
    return np.asarray(-model.stiffness * model.deflection(landing.robot, landing.q))


def motor_torques(
    landing: PosedLanding, load: Array, M: Array, J: Array, free: Array, gravity: Array
) -> Array:
    """Torques (nv,) of the motors, constant during the landing [N m, N].

    They are those of the scene, or those that hold what is loaded.

    In flight, the default, these are the smallest with which the loads of springs accelerate the
    robot as little as possible, √(aᵀ M a). Standing torques hold the robot on the contacts that
    strike. Their forces are the smallest that hold it as one rigid body, or, where they cannot hold
    all of it, as one foot, that leave the smallest acceleration; with these forces the torques are
    found as before.

    Args:
        landing: the landing.
        load: (nv,) torques of its springs [N m, N].
        M: (m, m) inertia of its coordinates.
        J: (n, m) speeds along the rows of contacts for unit rates of the coordinates.
        free: (nv, m) joint velocities for these.
        gravity: (m,) accelerations of free fall.
    """
    model, motors = landing.joint_model, landing.scene.joints.motors
    p = free.T @ load
    torques: Array = np.zeros(len(free))
    if motors == "standing":
        p = M @ gravity + p
    if motors == "standing" or (motors != "none" and p.any()):
        drives = _motors(landing)
        # With M = L Lᵀ, the length of L⁻¹ p is that of the accelerations that forces p give.
        to_length = np.linalg.inv(np.linalg.cholesky(M))
        missing = to_length @ -p
        if motors == "standing":
            missing = missing - _by_contacts(to_length, J, free, missing)
        torques[drives] = np.linalg.lstsq(to_length @ free[drives].T, missing, rcond=1e-9)[0]
    torques = np.where(np.isnan(model.torque), torques, model.torque)
    return np.where(model.locked, 0.0, torques)


def _by_contacts(to_length: Array, J: Array, free: Array, missing: Array) -> Array:
    """L⁻¹ Jᵀ f (m,) of the smallest contact forces f that hold a robot as one rigid body.

    In motions of the robot as one rigid body, springs and torques do no work.

    Args:
        to_length: (m, m) L⁻¹.
        J: (n, m) speeds along the rows of contacts.
        free: (nv, m) joint velocities; the first six are those of the base.
        missing: (m,) L⁻¹ of the forces that are missing.
    """
    by_force = to_length @ J.T
    base = np.eye(len(free))[:, :6]
    still = np.linalg.lstsq(free, base, rcond=None)[0]
    rigid = np.linalg.qr(np.linalg.inv(to_length).T @ still)[0]
    force = np.linalg.lstsq(rigid.T @ by_force, rigid.T @ missing, rcond=1e-9)[0]
    return np.asarray(by_force @ force)


def _motors(landing: PosedLanding) -> np.ndarray:
    """The velocities of the joints that have a motor.

    Those are joints with a reflected inertia, or if none has one all without a spring.
    """
    model, robot = landing.joint_model, landing.robot
    possible = robot.actuated_dofs & ~model.locked & ~robot.velocities(robot.followers)
    driven = possible & (model.armature + model.rotor > 0.0)
    if not driven.any():
        driven = possible & ~(model.stiffness > 0.0)
    return np.flatnonzero(driven)
