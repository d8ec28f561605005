"""The method on one screen: Scene → ShockProfile, three steps.

1. The impulsive equation of motion gives the jump of the joint velocities (shock paper, Eq. 4).
2. The tree's recursion turns it into the jump of every body (Eqs. 8 and 9).
3. In the plane a body's jump is a point at rest and a radius (Eqs. 11 and 12).

Everything is linear in the velocity of the strike, so steps 1 and 2 are done for 1 m/s along x, y and z, for every strike at once.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from shockpc.core.percussion import off_plane_share, percussion, shock_at
from shockpc.core.spatial import Array, Plane, velocity_at
from shockpc.errors import SceneError
from shockpc.health import gyration_radii, health_of
from shockpc.ledger import Ledger
from shockpc.model.bodies import body_jumps
from shockpc.model.contact import touch
from shockpc.model.dynamics import Dynamics, dynamics
from shockpc.model.equation import impulsive_equation, joint_jumps, solve_equation
from shockpc.model.freedom import freedom
from shockpc.model.posture import configuration, reference_name
from shockpc.model.robot import Robot, load_robot
from shockpc.readings import contact_impulses, point_shocks, shock_ranges
from shockpc.record import ShockProfile
from shockpc.scene import Scene, plane_of

__all__ = ["shock_profile"]


def shock_profile(scene: Scene, robot: Robot | None = None, ledger: Ledger | None = None) -> ShockProfile:
    """Compute the shock of one landing.

    Args:
        scene: the landing.
        robot: the scene's robot, if it is loaded already.
        ledger: collects what each stage cost and what was left out.

    Raises:
        ShockError: the robot, the scene or the model does not allow it; the text says what to change.
    """
    ledger = ledger or Ledger()
    with ledger.stage("robot file"):
        robot = robot or load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    scene = _complete(scene, robot)
    plane = plane_of(scene)
    strike = scene.strike.vector(plane)
    v_in = float(np.linalg.norm(strike))
    up = _ground_normal(plane, strike)
    _refuse_separation(scene, strike, up)

    with ledger.stage("posture, inertia and Jacobians"):
        q, outside = configuration(robot, scene.posture)
        state = dynamics(robot, q[None])
        touches = tuple(touch(robot, contact, state.rotation[0], up) for contact in scene.contact)
        G = freedom(robot, scene.base or "free", plane, state.rotation[:, 0])
    with ledger.stage("step 1: impulsive equation of motion"):
        equation = impulsive_equation(state, touches, G)
        impact = solve_equation(robot, equation)
        delta_qd = joint_jumps(equation, impact)
    with ledger.stage("step 2: bodies"):
        maps = body_jumps(state, delta_qd)[0]
    with ledger.stage("check in maximal coordinates"):
        health = health_of(robot, state, touches, equation, impact, maps, strike)
    with ledger.stage("step 3: centres and radii of percussion"):
        jump = maps @ strike
        delta_omega, delta_v = jump[:, :3], jump[:, 3:]
        rotation, position = state.rotation[0], state.position[0] + state.origin[0]
        normal = plane.normal @ rotation
        com = np.stack([body.com for body in robot.bodies])
        tolerance = max(1e-12, 10.0 * health.error_estimate)
        reduced = percussion(delta_omega, delta_v, normal, v_in, _size(robot, state), tolerance)
        off_plane = off_plane_share(delta_omega, velocity_at(delta_omega, delta_v, com), normal, gyration_radii(robot))
    with ledger.stage("shock over geometry"):
        shock_min, shock_max, unseen = shock_ranges(robot, delta_omega, delta_v, v_in)
    with ledger.stage("sensors, points and contacts"):
        points = point_shocks(robot, scene.point, rotation, position, delta_omega, delta_v, v_in)
        contacts, pulled = contact_impulses(touches, impact, strike, state, up)
    _left_out(ledger, robot, scene, equation.G is None)
    return ShockProfile(
        scene=scene,
        robot=robot,
        plane=plane,
        v_in=v_in,
        strike=strike,
        q=q,
        delta_qd=delta_qd[0] @ strike,
        maps=maps,
        position=position,
        rotation=rotation,
        delta_omega=delta_omega,
        delta_v=delta_v,
        copc=reduced.copc,
        copc_world=position + (rotation @ reduced.copc[..., None])[..., 0],
        ropc=reduced.ropc,
        translates=reduced.translates,
        pitch=reduced.pitch,
        off_plane=off_plane,
        shock_com=shock_at(delta_omega, delta_v, com, v_in),
        shock_min=shock_min,
        shock_max=shock_max,
        points=points,
        contacts=contacts,
        joint_model=_joint_model(robot),
        health=replace(health, warnings=(*robot.warnings, *outside, *health.warnings, *pulled, *unseen)),
    )


def _complete(scene: Scene, robot: Robot) -> Scene:
    """The scene with every default filled in, so that it says all that was computed."""
    if not scene.contact:
        raise SceneError(
            f'no contact is given, so nothing strikes; name a link of robot "{robot.name}", such as "{robot.links[-1]}"'
        )
    base = scene.base or ("free" if robot.free_base else "fixed")
    reference = reference_name(robot, scene.posture.reference)
    strike = scene.strike
    if strike.velocity is None and strike.drop_height is None:
        strike = replace(
            strike, speed=1.0 if strike.speed is None else strike.speed, strike_angle_deg=strike.strike_angle_deg or 0.0
        )
    return replace(
        scene,
        robot=robot.label,
        base=base,
        srdf=None if scene.srdf is None else str(Path(scene.srdf).expanduser().resolve()),
        packages={name: str(Path(folder).expanduser().resolve()) for name, folder in scene.packages.items()},
        posture=replace(scene.posture, reference=reference),
        strike=strike,
    )


def _ground_normal(plane: Plane, strike: Array) -> Array:
    """World z; in a plane seen from above, and struck within it, the plane's own upward direction."""
    level = abs(plane.normal[2]) > 1.0 - 1e-9
    return plane.e2 if level and strike[2] == 0.0 else np.array([0.0, 0.0, 1.0])


def _refuse_separation(scene: Scene, strike: Array, up: Array) -> None:
    """A contact that does not approach the ground does not strike it."""
    if not np.all(np.isfinite(strike)):
        raise SceneError(f"the strike's velocity {strike.tolist()} is not finite")
    leaving = float(strike @ up)
    if leaving >= -1e-9 * float(np.linalg.norm(strike)):
        how = "is leaving the ground at" if leaving > 1e-9 else "moves along the ground, approaching it at"
        theta = scene.strike.strike_angle_deg
        remedy = (
            f"strike angle is {theta:g} deg, try between -90 and 90 deg"
            if theta is not None
            else "turn the velocity towards the ground"
        )
        raise SceneError(f'contact "{scene.contact[0].frame}" {how} {abs(leaving):.2g} m/s, so there is no impact; {remedy}')


def _joint_model(robot: Robot) -> str:
    """How the joints' drives take part: by their reflected inertia, or not at all."""
    armature = robot.model.armature[6:] if robot.free_base else robot.model.armature
    if not np.any(armature > 0.0):
        return "free"
    return "geared" if np.all(armature > 0.0) else "mixed"


def _size(robot: Robot, state: Dynamics) -> float:
    """Length of the robot [m]: over which a rotation too small to matter is measured."""
    com = np.stack([body.com for body in robot.bodies])
    places = np.concatenate([state.position[0], state.position[0] + (state.rotation[0] @ com[..., None])[..., 0]])
    size = float(np.linalg.norm(np.ptp(places, axis=0))) + float(gyration_radii(robot).max())
    return size or 1.0


def _left_out(ledger: Ledger, robot: Robot, scene: Scene, all_free: bool) -> None:
    """Note what this scene did not need."""
    ledger.skip("closure rows", "nothing closes a loop")
    if all_free:
        ledger.skip("reduction to free velocities (Eq. 7)", "every joint velocity is free")
    if not robot.model.armature.any():
        ledger.skip("reflected inertia", "the file gives none")
    if all(len(contact.directions) == 3 for contact in scene.contact):
        ledger.skip("friction", "every contact sticks")
