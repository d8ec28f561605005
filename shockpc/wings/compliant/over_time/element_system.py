"""The elements of a landing on contacts of finite stiffness, its inertia and its velocities.

The velocities are those before the impact.

The coordinates are the velocities with which loops stay closed, and behind them those of rotors on
springs. Gravity, the torques of motors and the loads of springs are constant forces.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.contact_rows import ContactRows, contact_rows
from shockpc.impact.stops import stop_rows
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Contact
from shockpc.landing.scenes.scene_fields import spelled
from shockpc.method.constraints import Constraint
from shockpc.text.errors import SolveError
from shockpc.wings.compliant.motion.elements import Elements, attach_rotors
from shockpc.wings.compliant.motion.laws import series_damping
from shockpc.wings.compliant.over_time.constant_forces import constant_forces

LEAST_HELD = 1e-6
"""Share of the velocities before the impact that the coordinates may lack by rounding alone [1].

The velocities are those along contacts and springs, and the rotation of flat contacts. A larger
share is refused.
"""


@dataclass(frozen=True)
class ElementSystem:
    """The elements of a landing in n coordinates.

    Coordinates are velocities without those that rigid constraints exclude, then one for each rotor
    behind a spring.

    Attributes:
        rows: of the contacts; with end stops besides these their equation has rows of those too,
            behind its own.
        free: (nv, m) joint velocities for unit values of the first m coordinates, which are not
            those of rotors.
        strikes: (c,) which of the contact rows are of end stops that strike.
        stops: end stops besides contacts, which are numbered behind these.
        along: (k, ny) speeds of the springs, those to rotors, and motors for unit free velocities;
            zero of motors behind springs.
        inertia: (n, n).
        elements: of contact rows, end stops, springs, springs to rotors and motors, in this order.
        velocity: (n,) of the coordinates before the impact.
        gravity: (n,) accelerations of the coordinates in free fall.
        fall: (n,) the same with links that stay straight, as they are before touchdown.
    """

    rows: ContactRows
    free: Array
    strikes: np.ndarray
    stops: tuple[Constraint, ...]
    along: Array
    inertia: Array
    elements: Elements
    velocity: Array
    gravity: Array
    fall: Array


class _EndStops(NamedTuple):
    """End stops at which joints are, besides those that are contacts of the scene.

    Attributes:
        stops: s of them.
        rows: (s, nv) their speeds for unit joint velocities.
        speeds: (s,) before the impact [m/s, rad/s].
    """

    stops: tuple[Constraint, ...]
    rows: Array
    speeds: Array


class _JointElements(NamedTuple):
    """Velocities of joints that have an element.

    Attributes:
        springs: those with a spring.
        geared: those with a spring before their rotor.
        motors: those with a motor that gives a torque.
        behind: which of the motors turn a rotor behind a spring; the spring carries the torque
            already.
    """

    springs: np.ndarray
    geared: np.ndarray
    motors: np.ndarray
    behind: np.ndarray


def element_system(landing: PosedLanding) -> ElementSystem:
    """The elements of a landing on contacts of finite stiffness.

    Raises:
        SolveError: a flat contact turns before the impact, or no motion of the robot has the
            velocities before it.
    """
    rows, model = contact_rows(landing, stands=True), landing.joint_model
    _refuse_turning(landing, rows)
    free = _velocities(rows)
    strikes = _of_striking_stops(landing, rows)
    stops = _end_stops(landing)
    constant = constant_forces(landing, rows, free)
    joints = _joint_elements(landing, constant.torque)

    # Elements on coordinates without those of rotors, and the velocities with which they strike.
    struck = Elements.joined(
        _of_contacts(landing, rows, free, strikes),
        _of_stops(landing, stops, free),
        _of_springs(landing, joints.springs, free, constant.load),
    )
    spring_rates = landing.before.joint_rates[joints.springs]
    speeds = np.concatenate([rows.speeds, stops.speeds, spring_rates])
    before = _coordinates(landing, free, struck.rows, speeds)

    geared = joints.geared
    M, _, gears, velocity = attach_rotors(
        rows.M, struck.rows, before, free[geared], model.rotor[geared]
    )
    elements = Elements.joined(
        struck,
        Elements.alike(gears, model.drive_stiffness[geared], load=constant.torque[geared]),
        _of_motors(joints, free, constant.torque),
    )
    # Gravity has no part along the coordinates of rotors.
    rotors = np.zeros(len(geared))
    return ElementSystem(
        rows=_with_rows_of_stops(landing, rows, stops.stops),
        free=free,
        strikes=strikes,
        stops=stops.stops,
        along=_along(rows, joints),
        inertia=M,
        elements=elements,
        velocity=velocity,
        gravity=np.append(constant.gravity, rotors),
        fall=np.append(constant.fall, rotors),
    )


def _velocities(rows: ContactRows) -> Array:
    """Joint velocities (nv, m) for unit coordinates."""
    if rows.equation.G is None:
        return rows.basis
    return np.asarray(rows.equation.G[0] @ rows.basis)


def _of_striking_stops(landing: PosedLanding, rows: ContactRows) -> np.ndarray:
    """Mask (c,) of the rows of contacts that are end stops that strike."""
    striking = [i for i, contact in enumerate(landing.contacts) if contact.kind == "stop"]
    return np.isin(rows.number, striking)


def _joint_elements(landing: PosedLanding, torque: Array) -> _JointElements:
    """Velocities of joints that have an element. Args: torque (nv,), of the motors."""
    model = landing.joint_model
    geared = np.flatnonzero(np.isfinite(model.drive_stiffness) & (model.rotor > 0.0))
    motors = np.flatnonzero(torque)
    springs = np.flatnonzero(model.stiffness > 0.0)
    return _JointElements(springs, geared, motors, np.isin(motors, geared))


def _along(rows: ContactRows, joints: _JointElements) -> Array:
    """Speeds (k, ny) of springs, those to rotors, and motors for unit free velocities."""
    G = np.eye(len(rows.basis)) if rows.equation.G is None else rows.equation.G[0]
    of_motors = np.where(joints.behind[:, None], 0.0, G[joints.motors])
    return np.concatenate([G[joints.springs], G[joints.geared], of_motors])


def _of_motors(joints: _JointElements, free: Array, torque: Array) -> Elements:
    """The elements of motors, constant forces.

    A motor turns its joint, or the coordinate of its rotor where that is behind a spring.
    """
    motors, behind, width = joints.motors, joints.behind, free.shape[1]
    turned = np.zeros((len(motors), width + len(joints.geared)))
    turned[~behind, :width] = free[motors[~behind]]
    turned[behind, width + np.searchsorted(joints.geared, motors[behind])] = 1.0
    return Elements.alike(turned, 0.0, load=torque[motors])


def _of_springs(landing: PosedLanding, springs: np.ndarray, free: Array, load: Array) -> Elements:
    """The elements of springs in joints and hinges. Args: load (nv,), at touchdown."""
    stiffness, straight = landing.joint_model.stiffness[springs], np.isin(springs, landing.hinges)
    return Elements.alike(free[springs], stiffness, load=load[springs], straight=straight)


def _of_stops(landing: PosedLanding, stops: _EndStops, free: Array) -> Elements:
    """The elements of end stops, numbered after the contacts.

    They are open at first, where their joint does not move towards them.
    """
    numbers = len(landing.contact_places) + np.arange(len(stops.stops))
    restitution = landing.scene.stop_restitution or 0.0
    return Elements.alike(stops.rows @ free, _stop_stiffness(landing), restitution, numbers, True)


def _with_rows_of_stops(
    landing: PosedLanding, rows: ContactRows, stops: tuple[Constraint, ...]
) -> ContactRows:
    """The rows, whose equation has those of stops too: they may be struck later."""
    if not stops:
        return rows
    return replace(rows, equation=replace(landing, acting=stops).equation(landing.state))


def _stop_stiffness(landing: PosedLanding) -> float:
    """That of end stops; by default that of contacts."""
    stiffness = landing.scene.stop_stiffness or landing.scene.contact_stiffness
    assert stiffness is not None
    return stiffness


def _of_contacts(
    landing: PosedLanding, rows: ContactRows, free: Array, strikes: np.ndarray
) -> Elements:
    """The elements along the rows of contacts; end stops that strike have no dampers."""
    scene = landing.scene
    assert scene.contact_stiffness is not None
    tangential = scene.tangential_stiffness or scene.contact_stiffness
    of_ground = np.where(rows.normal, scene.contact_stiffness, tangential)
    k = np.where(strikes, _stop_stiffness(landing), of_ground)
    damping = np.where(strikes, 0.0, scene.contact_damping or 0.0)
    relaxation = np.zeros(len(k))
    if scene.contact_law == "damper":
        relaxation = np.where(strikes, 0.0, series_damping(rows.restitution))
    if relaxation.any():
        relaxation = 2.0 * relaxation * rows.frequency(k, free[landing.hinges])
    return Elements.alike(
        rows.J, k, rows.restitution, rows.number, rows.normal, damping, relaxation=relaxation
    )


def _refuse_turning(landing: PosedLanding, rows: ContactRows) -> None:
    """Refuse flat contacts that turn before the impact."""
    before = landing.before
    fastest = max(np.abs(before.omega).max(), np.abs(before.joint_rates).max())
    if np.abs(rows.halt).max() > LEAST_HELD * fastest:
        raise SolveError(
            "a flat contact turns before the impact, and on contacts of finite stiffness it would "
            "have to stop turning at once; let it not turn, or make it a point: "
            f"{spelled(Contact, 'kind', 'point')}"
        )


def _end_stops(landing: PosedLanding) -> _EndStops:
    """The end stops besides contacts; none where the scene leaves them out."""
    if not landing.scene.stops:
        return _EndStops((), np.zeros((0, landing.robot.model.nv)), np.zeros(0))
    stops, along, speeds = stop_rows(landing)
    striking = {constraint.body for constraint in landing.contacts if constraint.kind == "stop"}
    kept = [k for k, stop in enumerate(stops) if stop.body not in striking]
    return _EndStops(tuple(stops[k] for k in kept), along[kept], speeds[kept])


def _coordinates(landing: PosedLanding, free: Array, B: Array, speeds: Array) -> Array:
    """Velocities of the coordinates before the impact.

    With them the rows B of the elements have their speeds.

    Where joints are locked at a rate, a contact has a velocity or the ground moves against a fixed
    base, they are not those of the robot: a motion with constant velocity, in which all of it moves
    along, changes neither forces nor jumps.

    Args:
        landing: the landing.
        free: of the coordinates.
        B: rows of contacts and springs.
        speeds: of these before the impact.

    Raises:
        SolveError: no motion of the robot has these speeds.
    """
    before = landing.before.joint_rates.copy()
    moves = np.concatenate([landing.before.omega, landing.before.velocity])
    if landing.robot.free_base:
        before[:6] = np.linalg.solve(landing.state.J[0, :, :6], moves)
    as_given = landing.robot.free_base or not moves.any()
    contacts_move = any(contact.velocity is not None for contact in landing.contacts)
    if len(free) == free.shape[1] and as_given and not contacts_move:
        return before
    velocity = np.linalg.lstsq(free, before, rcond=None)[0]
    velocity = velocity + np.linalg.lstsq(B, speeds - B @ velocity, rcond=1e-10)[0]
    if np.linalg.norm(B @ velocity - speeds) > LEAST_HELD * np.linalg.norm(speeds):
        raise SolveError(
            "no motion of the robot has the velocities before the impact along all contacts and "
            "springs; give others"
        )
    return np.asarray(velocity)
