"""Step 3 for every body: its centre and radius of percussion in the plane (shock paper, Eqs. 11 and 12)."""

from typing import NamedTuple

import numpy as np

from shockpc.core.percussion import norm, off_plane_share, percussion, translation
from shockpc.core.spatial import Array, velocity_at
from shockpc.exact.balls import balls, nearest
from shockpc.exact.proof import Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.results.speed import speed_in

__all__ = ["ROUNDED", "BodyPercussion", "body_percussion", "robot_length"]

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


def body_percussion(landing: Landing, proof: Proof, v_in: float) -> BodyPercussion:
    """Reduce the jump of every body."""
    state, robot = landing.state, landing.robot
    rotation, position = state.rotation[0], state.position[0] + state.origin[0]
    delta_omega, delta_v = proof.jumps[:, :3, 3], proof.jumps[:, 3:, 3]
    length = robot_length(landing)
    translates, still = translation(delta_omega, delta_v, landing.plane.normal @ rotation, v_in, length, ROUNDED)
    speed = np.linalg.norm(delta_v, axis=1)
    spin = np.where(still, 1.0, np.linalg.norm(delta_omega, axis=1))

    def reduce(impact: ExactImpact) -> tuple[Array, ...]:
        omega, v = impact.body_jumps[:, :3, 3], impact.body_jumps[:, 3:, 3]
        turned = impact.orientations
        normal = np.sum(turned * balls(landing.plane.normal)[None, :, None], axis=1)
        v_in_ball = speed_in(impact, landing)
        found = percussion(omega, v, normal, v_in_ball, translates, still)
        v_com = velocity_at(omega, v, balls(robot.coms))
        place = impact.points(range(len(robot.bodies)), np.zeros((len(robot.bodies), 3))) + balls(state.origin[0])
        world = place + np.sum(turned * found.copc[:, None, :], axis=-1)
        far = np.where(
            translates,
            1.0,
            speed / np.abs(np.where(translates, 1.0, np.sum(delta_omega * (landing.plane.normal @ rotation), axis=1))),
        )
        return (
            nearest(found.copc, (far + length)[:, None]),
            nearest(world, (far + length + np.abs(position).max())[:, None]),
            nearest(found.ropc, 0.0),
            nearest(found.pitch, speed / spin + length),
            nearest(off_plane_share(omega, v_com, normal, balls(robot.gyration)), 1.0),
            nearest(norm(v_com) / v_in_ball, np.abs(proof.jumps[..., 3]).max() / v_in),
        )

    copc, world, ropc, pitch, off_plane, shock_com = proof.enclosure.read(reduce)
    none = translates[:, None]
    return BodyPercussion(
        np.where(none, np.nan, copc),
        np.where(none, np.nan, world),
        np.where(translates, np.inf, ropc),
        translates,
        np.where(still, np.nan, pitch),
        off_plane,
        shock_com,
    )
