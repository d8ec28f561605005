"""Impacts whose jumps are those of a motion on finite stiffness, from which quantities are read.

What is linear in the jumps and impulses of an impact (the velocity of a point, the wrench through a
joint) is, of the accelerations for unit forces, the matrix that gives the same of the motion.
"""

from dataclasses import replace

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.spatial import Array
from shockpc.impact.impact import ColumnImpact, jumps_in_body_axes
from shockpc.impact.stops import with_stops
from shockpc.landing.before_impact import mass_lifted
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.method.constraints import Constraint
from shockpc.wings.compliant.motion.stiff_motion import StiffMotion
from shockpc.wings.compliant.over_time.element_system import ElementSystem


def impact_of(
    moving: PosedLanding, system: ElementSystem, jumps: Array, impulse: Array | None = None
) -> ColumnImpact:
    """An impact with jumps of the coordinates and impulses along all rows of Eq. 4.

    Args:
        moving: the landing, with links that bend.
        system: its elements.
        jumps: (n, S) of the coordinates in S strikes.
        impulse: (nc, at most S); the remaining strikes have none.
    """
    rows, equation = system.rows, system.rows.equation
    delta_y = (rows.basis @ jumps[: system.free.shape[1]])[None]
    impulses = np.full((1, equation.J_c.shape[1], jumps.shape[1]), np.nan)
    if impulse is not None:
        impulses[0, :, : impulse.shape[1]] = impulse
    # Of the solution of Eq. 4 only jumps and impulses are read.
    solution = Solution(
        delta_y,
        impulses,
        scale=np.ones(impulses.shape[:2]),
        rank=np.array([0]),
        condition=np.ones(1),
        row_spaces={},
        independent={},
    )
    in_body_axes = jumps_in_body_axes(equation, delta_y)
    return ColumnImpact(replace(moving, acting=system.stops), equation, solution, in_body_axes)


def impact_of_unit_forces(
    moving: PosedLanding, system: ElementSystem, motion: StiffMotion, ends: Array
) -> ColumnImpact:
    """An impact whose jumps are accelerations for unit forces, those of gravity, and other jumps.

    Those of gravity are, less gravity, those of a fall that a fixed base, standing feet and loops
    constrain; all come with what holds these. All else is linear in the forces.

    Args:
        moving: the landing, with links that bend.
        system: its elements, r of them.
        motion: the same over time.
        ends: (n, S − r − 1) other jumps, which have no impulses.
    """
    jumps = np.column_stack([motion.response, motion.gravity, ends])
    impact = impact_of(moving, system, jumps, _impulses(moving, system, motion))
    if moving.scene.gravity:
        # Accelerations of a fall, less gravity, of which body axes have R^T (0, 0, -g).
        up = moving.state.rotation[:, :, 2]
        impact.jumps[..., 3:, len(system.elements.rows)] += GRAVITY * up
    return impact


def _impulses(moving: PosedLanding, system: ElementSystem, motion: StiffMotion) -> Array:
    """Forces (nc, r + 1) along all rows for unit forces of the elements, and in the fall.

    Those of rows that hold the robot rigidly, of standing feet and loops, follow from
    H a = Jᵀ f + J_rᵀ f_r, of accelerations a and forces f along the others.
    """
    rows, equation = system.rows, system.rows.equation
    H, J = equation.H[0], equation.J_c[0]
    n, stops, unstopped = len(rows.turn), len(system.stops), len(rows.rigid)
    forces = np.zeros((len(J), len(system.elements.rows) + 1))
    forces[:unstopped, :n] = rows.turn.T
    forces[unstopped:, n : n + stops] = np.eye(stops)
    if not rows.rigid.any():
        return forces
    weight = -GRAVITY * moving.scene.gravity * mass_lifted(moving.robot, moving.state)
    if equation.G is not None:
        weight = weight @ equation.G[0]
    # Jᵀ f of unit forces of contacts, stops and the elements of joints, and of the weight.
    along = np.vstack([rows.turn @ J[:unstopped], J[unstopped:], system.along, weight])
    accelerations = np.column_stack([motion.response, motion.gravity])[: system.free.shape[1]]
    missing = H @ (rows.basis @ accelerations) - along.T
    rigid = np.flatnonzero(rows.rigid)
    forces[rigid] = np.linalg.lstsq(J[rigid].T, missing, rcond=1e-10)[0]
    return forces


def impulsive_jumps(
    landing: PosedLanding, moving: PosedLanding, system: ElementSystem, motion: StiffMotion
) -> Array:
    """Jumps (n,) of the coordinates in the impulse model.

    It reverses at once the speeds of the rows that act in it: those of contacts, those of stops
    that act at once, and hinges, which are locked there.
    """
    rows, hinges = system.rows, moving.hinges
    acting = with_stops(landing).acting if system.stops else ()
    named = [_stop_key(stop) for stop in acting]
    contacts = np.ones(len(rows.normal), dtype=bool)
    stops = np.array([_stop_key(stop) in named for stop in system.stops], dtype=bool)
    springs = np.isin(np.flatnonzero(moving.joint_model.stiffness > 0.0), hinges)
    rotors_and_motors = np.zeros(len(system.along) - len(springs), dtype=bool)
    acts = np.concatenate([contacts, stops, springs, rotors_and_motors])
    of_stops = [stop.restitution for stop in acting]
    e = np.concatenate([rows.restitution, of_stops, np.zeros(len(hinges))])
    # B Δv = −(1 + e) B v⁻, of the rows B that act.
    B, to_velocity = motion.elements.rows[acts], motion.to_velocity
    speeds = (1.0 + e) * (B @ system.velocity)
    impulses = np.linalg.lstsq(B @ to_velocity, -speeds, rcond=1e-9)[0]
    return np.asarray(to_velocity @ impulses)


def _stop_key(stop: Constraint) -> tuple[str, bytes, bytes]:
    """Key that tells stops apart: their name and directions."""
    return stop.frame, stop.forces.tobytes(), stop.moments.tobytes()
