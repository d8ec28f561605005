"""The method on one screen: Scene → ShockProfile, three steps.

1. The impulsive equation of motion gives the jump of the joint velocities (shock paper, Eq. 4).
2. The tree's recursion turns it into the jump of every body (Eqs. 8 and 9).
3. In the plane a body's jump is a point at rest and a radius (Eqs. 11 and 12).

Everything is linear in the velocity of the strike, so steps 1 and 2 are done for 1 m/s along x, y and z besides the scene's own
strike: every strike angle, and the worst one, is a product afterwards.
"""

from dataclasses import replace

import numpy as np

from shockpc.core.directions import extreme_directions
from shockpc.core.percussion import off_plane_share, percussion, shock_at
from shockpc.core.pulse import Pulse, pulse_from
from shockpc.core.spatial import velocity_at
from shockpc.errors import SceneError
from shockpc.health import judge
from shockpc.landing import Landing, complete, resolve
from shockpc.model.bodies import gyration_radii
from shockpc.model.dynamics import tree
from shockpc.model.equation import solve
from shockpc.result import PointShock, ShockProfile
from shockpc.results.bracket import drive_bracket
from shockpc.results.contacts import contact_impulses, stance_impulses, total_impulse
from shockpc.results.doubts import (
    direction_doubts,
    impulse_doubts,
    load_doubts,
    mass_doubts,
    percussion_doubts,
    total_doubts,
    turn_errors,
)
from shockpc.results.geometry import shock_ranges
from shockpc.results.loads import energy, joint_loads
from shockpc.results.points import point_maps, point_shocks, spots
from shockpc.results.speed import normalising_speed
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene
from shockpc.trace import Trace

__all__ = ["shock_profile"]

ROUNDED = 1e-9
"""Rotation that moves no point of the robot by more than this share of the strike is no rotation: files give angles and lengths
with ten digits or so, and their rounding turns bodies by as much."""


def shock_profile(scene: Scene, robot: Robot | None = None, trace: Trace | None = None) -> ShockProfile:
    """Compute the shock of one landing.

    Args:
        scene: the landing.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost and what was left out.

    Raises:
        ShockError: the robot, the scene or the model does not allow it; the text says what to change.
    """
    trace = trace or Trace()
    with trace.stage("robot file"):
        robot = robot or load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    scene = complete(scene, robot)
    pulse = _pulse(scene)
    with trace.stage("posture, inertia, Jacobians and rows"):
        landing = resolve(scene, robot)
        state, rows, up = landing.state, landing.rows, landing.up
        v_in, strike, unsure = normalising_speed(scene, robot, landing)
        com = np.stack([body.com for body in robot.bodies])
    with trace.stage("steps 1 and 2: impulsive equation of motion, bodies"):
        solution = solve(robot, state, rows, landing.drives.armature, landing.G)
    with trace.stage("check in maximal coordinates"):
        bodies = tree(robot, state, landing.drives.armature, landing.G)
        verdict = judge(robot, state, bodies, rows, solution)
        solution, health = verdict.solution, verdict.health
        maps, jump = solution.jumps[0, ..., :3], solution.jumps[0, ..., 3]
        delta_omega, delta_v = jump[:, :3], jump[:, 3:]
    with trace.stage("step 3: centres and radii of percussion"):
        rotation, position = state.rotation[0], state.position[0] + state.origin[0]
        normal = landing.plane.normal @ rotation
        size, turn_error = _size(robot, landing), turn_errors(robot, state, bodies, rows, verdict, landing.plane.normal)
        reduced = percussion(delta_omega, delta_v, normal, v_in, size, ROUNDED, turn_error)
        unsure += percussion_doubts(robot, np.sum(delta_omega * normal, axis=-1), turn_error, reduced.translates)
        off_plane = off_plane_share(delta_omega, velocity_at(delta_omega, delta_v, com), normal, gyration_radii(robot))
    with trace.stage("shock over geometry"):
        shock_min, shock_max, unseen = shock_ranges(robot, delta_omega, delta_v, v_in)
    with trace.stage("sensors, points and contacts"):
        found = spots(robot, scene.point)
        points = point_shocks(robot, found, rotation, position, jump, maps, v_in, up, pulse)
        floating = scene.base == "free" and not scene.stance and not landing.anchored
        contacts, pulled = contact_impulses(state, landing.touches, rows, solution, landing.approach, up, floating)
        stance, dragged = stance_impulses(robot, scene.stance, len(landing.touches), state, rows, solution, up)
        grounded = len(landing.touches) + len(scene.stance)
        centre = bodies.mass @ bodies.com / robot.mass
        force, moment = total_impulse(rows, grounded, solution.impact.impulse[0, :, -1], centre)
    with trace.stage("loads, energy and the bracket of drives"):
        loads = joint_loads(robot, state, bodies, rows, solution)
        lost, share = energy(robot, state, bodies, rows, solution, landing.before, floating)
        gained = (*_gained(lost, robot.mass, landing), *_saturated(scene, points))
        bracket, unchecked = drive_bracket(robot, scene, landing, solution, found, v_in)
    with trace.stage("doubts about what follows from the jumps"):
        unsure += (
            *direction_doubts(robot, state, verdict),
            *impulse_doubts(rows, verdict),
            *total_doubts(rows, grounded, centre, size, verdict),
            *load_doubts(robot, bodies, rows, loads, verdict, size),
            *mass_doubts(robot, state, bodies, landing.touches, rows, verdict, contacts, up),
            *unchecked,
        )
    _left_out(trace, scene, landing, points)
    return ShockProfile(
        scene=scene,
        robot=robot,
        plane=landing.plane,
        v_in=v_in,
        strike=strike,
        q=landing.q,
        delta_qd=solution.delta_qd[0, :, 3],
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
        stance=stance,
        total_impulse=force,
        total_moment=moment,
        directions=extreme_directions(point_maps(maps, com), up),
        loads=loads,
        energy_lost=lost,
        energy_share=share,
        bracket=bracket,
        assembly=landing.assembly,
        joint_model=landing.drives.model,
        health=replace(
            health, warnings=(*robot.warnings, *landing.warnings, *health.warnings, *unsure, *pulled, *dragged, *gained, *unseen)
        ),
    )


def _gained(lost: float, mass: float, landing: Landing) -> tuple[str, ...]:
    """A warning where contacts that bounce differently would make energy, which no impact does."""
    if lost >= -1e-9 * mass * float(np.linalg.norm(landing.approach, axis=1).max()) ** 2:
        return ()
    made = f"this impact would make {-lost:.3g} J of kinetic energy"
    if len({touch.restitution for touch in landing.touches}) == 1:
        return (f"{made}, which none does, so rounding has taken its numbers; do not use them",)
    return (
        f"{made}: contacts with unequal restitution push against one another; give them one restitution, or strike them one after "
        "the other",
    )


def _saturated(scene: Scene, points: tuple[PointShock, ...]) -> tuple[str, ...]:
    """A warning for every sensor that would see more than its range, and where there is none for a pulse to be felt by."""
    if scene.pulse is not None and not points:
        return ("a pulse is given, but the robot has no sensor and no point is asked for, so no peak is; name one with --point",)
    if scene.range_g is None:
        return ()
    return tuple(
        f'"{point.frame}" would see {point.peak_g:.3g} g, beyond its range of {scene.range_g:g} g; its reading saturates'
        for point in points
        if point.peak_g is not None and point.peak_g > scene.range_g
    )


def _pulse(scene: Scene) -> Pulse | None:
    """The scene's pulse, if it has one."""
    if scene.range_g is not None and not scene.range_g > 0.0:
        raise SceneError(f"a sensor's range of {scene.range_g:g} g has to be above zero")
    if scene.pulse is None:
        if scene.range_g is not None:
            raise SceneError("a sensor's range is given in g, but no pulse; give one too, such as half-sine:5ms")
        return None
    try:
        return pulse_from(scene.pulse)
    except ValueError as refusal:
        raise SceneError(f"pulse: {refusal}") from None


def _size(robot: Robot, landing: Landing) -> float:
    """Length of the robot [m]: over which a rotation too small to matter is measured."""
    state = landing.state
    com = np.stack([body.com for body in robot.bodies])
    places = np.concatenate([state.position[0], state.position[0] + (state.rotation[0] @ com[..., None])[..., 0]])
    size = float(np.linalg.norm(np.ptp(places, axis=0))) + float(gyration_radii(robot).max())
    return size or 1.0


def _left_out(trace: Trace, scene: Scene, landing: Landing, points: tuple[PointShock, ...]) -> None:
    """Note what this scene did not need."""
    if landing.assembly is None:
        trace.skip("closure rows and assembly", "nothing closes a loop")
    if landing.G is None:
        trace.skip("reduction to free velocities (Eq. 7)", "every joint velocity is free, save where the bracket locks the drives")
    if not landing.drives.armature.any():
        trace.skip("reflected inertia", "no drive has any")
    if not scene.stance:
        trace.skip("stance rows", "no foot stands already")
    if scene.pulse is None:
        trace.skip("peak accelerations", "no pulse is given")
    if not points:
        trace.skip("sensors and points", "the robot has no sensor, and no point is asked for")
    if all(contact.sticks for contact in scene.contact):
        trace.skip("sliding", "every contact sticks")
