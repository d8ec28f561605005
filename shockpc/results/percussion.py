"""Step 3 for every body: its centre and radius of percussion in the plane (shock paper, Eqs. 11 and 12)."""

from typing import NamedTuple

import numpy as np

from shockpc.core.extremes import shock_extremes
from shockpc.core.percussion import off_plane_share, percussion, translation
from shockpc.core.spatial import Array, velocity_at
from shockpc.exact.balls import balls, nearest
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.results.solved import Solved, shock_in, speed_in, world
from shockpc.robot.geometry import body_outline

__all__ = ["ROUNDED", "BodyPercussion", "body_percussion", "robot_length", "shock_ranges"]

ROUNDED = 1e-9
"""Rotation that moves no point of the robot by more than this share of the strike is no rotation: files give angles and lengths
with ten digits or so, and their rounding rotates bodies by as much."""


class BodyPercussion(NamedTuple):
    """Step 3; index i of every array is body i.

    Attributes:
        copc: (nb, 3) centre of percussion, body coordinates [m]; NaN where the body does not rotate in the plane.
        copc_world: (nb, 3) the same in the world [m].
        ropc: (nb,) radius of percussion [m]; inf where the body does not rotate in the plane.
        translates: (nb,) whether the body does not rotate in the plane, by more than the rounding of files.
        pitch: (nb,) pitch of the spatial screw [m/rad]; NaN where the body does not rotate at all.
        off_plane: (nb,) share of the jump that the plane cannot show [1].
        shock_com: (nb,) shock at the centre of mass [1].
    """

    copc: Array
    copc_world: Array
    ropc: Array
    translates: np.ndarray
    pitch: Array
    off_plane: Array
    shock_com: Array


def robot_length(landing: Landing) -> float:
    """Length of the robot [m]: over which a rotation too small to matter is measured."""
    state, robot = landing.state, landing.robot
    com = state.position[0] + (state.rotation[0] @ robot.coms[..., None])[..., 0]
    extent = np.ptp(np.concatenate([state.position[0], com]), axis=0)
    return float(np.linalg.norm(extent)) + float(robot.gyration.max()) or 1.0


def body_percussion(of: Solved) -> BodyPercussion:
    """Centres and radii of percussion (Eqs. 11 and 12)."""
    landing, robot, length, jumps = of.landing, of.robot, robot_length(of.landing), of.proof.jumps[..., 3]
    normals = landing.plane.normal @ landing.state.rotation[0]
    translates, still = translation(jumps[:, :3], jumps[:, 3:], normals, of.v_in, length, ROUNDED)
    bodies = range(len(robot.bodies))

    def reduce(impact: ExactImpact) -> tuple[Array, ...]:
        omega, v = impact.body_jumps[:, :3, 3], impact.body_jumps[:, 3:, 3]
        normal = np.sum(impact.orientations * balls(landing.plane.normal)[None, :, None], axis=1)
        found = percussion(omega, v, normal, speed_in(impact, landing), translates, still)
        spin = np.where(still, 1.0, np.linalg.norm(jumps[:, :3], axis=1))
        return (
            nearest(found.copc, length + np.abs(found.copc.astype(float)).max(axis=1, keepdims=True)),
            world(impact, landing, bodies, found.copc),
            nearest(found.ropc, 0.0),
            nearest(found.pitch, length + np.linalg.norm(jumps[:, 3:], axis=1) / spin),
            nearest(off_plane_share(omega, velocity_at(omega, v, balls(robot.coms)), normal, balls(robot.gyration)), 1.0),
            shock_in(impact, landing, bodies, robot.coms),
        )

    copc, copc_world, ropc, pitch, off_plane, shock_com = of.read(reduce)
    copc[translates], copc_world[translates], ropc[translates], pitch[still] = np.nan, np.nan, np.inf, np.nan
    return BodyPercussion(copc, copc_world, ropc, translates, pitch, off_plane, shock_com)


def shock_ranges(of: Solved) -> tuple[Array, Array]:
    """Least and greatest shock over the bodies' geometry.

    Returns: least (nb,), greatest (nb,) [1]; NaN without geometry. Of a file without collision geometry the visual one is taken.
    Computed in double precision from the proven jumps: right to 1e-15 of |Δv| + |Δω| |r| at the farthest point r of the body.
    """
    jumps = of.proof.jumps[..., 3]
    return shock_extremes(jumps[:, :3], jumps[:, 3:], body_outline(of.robot).pieces, of.v_in)
