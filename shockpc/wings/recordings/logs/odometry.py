"""The velocity of a base by its standing feet.

They stay where they are while the joints move, so the base moves.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.spatial import Array
from shockpc.landing.contact import locate_lowest_point
from shockpc.method.approach import Motion, twist_before
from shockpc.method.constraints import constraint_wrenches
from shockpc.method.dynamics import dynamics
from shockpc.wings.recordings.logs.logged_motion import TWIST, LoggedMotion

DETERMINED = 0.02
"""Smallest singular value with which the feet determine a motion, in largest ones.

It is smaller of feet nearly on a line.
"""

SLIP = 0.15
"""Relative speed of standing feet from which no motion of the base follows from them [m/s]."""


def base_velocity(
    motion: LoggedMotion, contacts: Sequence[int], begin: int, end: int, before: bool
) -> tuple[dict[str, float], str]:
    """The velocities of the base by name, as `TWIST`, in world axes, and why they are NaN.

    The rows of all standing feet in all samples have no speed, in the sense of least squares. The
    angular velocity is that of the gyro or of the attitude where the log has one.

    Args:
        motion: of the log.
        contacts: numbers of the feet that stand in these samples.
        begin: first sample.
        end: last one.
        before: whether a touchdown follows on it.
    """
    unknown = dict.fromkeys(TWIST, np.nan)
    contacts = [c for c in contacts if motion.carried(c)]
    if not contacts:
        return unknown, "no foot stands"
    if np.isinf(motion.period["joints"]):
        return unknown, "the log has no positions of joints"
    A, b = _standing_rows(motion, contacts, begin, end)
    turns, moves = _base_motions(motion)
    known = motion.turning(begin, end, before)
    fixed = np.zeros(6)
    basis = np.hstack([turns, moves])
    if known is not None:
        fixed = turns @ np.linalg.lstsq(turns[:3], known)[0]
        basis = moves
    # Least squares of A (fixed + basis x) = b
    x, _, rank, _ = np.linalg.lstsq(A @ basis, b - A @ fixed, rcond=DETERMINED)
    if rank < basis.shape[1]:
        feet = f"{len(contacts)} standing feet are"
        if len(contacts) == 1:
            feet = "1 standing foot is"
        return unknown, f"{feet} too few without a gyro (columns wx_body, wy_body and wz_body)"
    twist = fixed + basis @ x
    slips = float(np.abs(A @ twist - b).max())
    if slips > SLIP:
        return (
            unknown,
            f"the standing feet move against each other by {slips:.2g} m/s: one slips, or "
            f"positions are noisy",
        )
    velocity = [*twist[3:].tolist(), *twist[:3].tolist()]
    return dict(zip(TWIST, velocity, strict=True)), ""


def _standing_rows(
    motion: LoggedMotion, contacts: Sequence[int], begin: int, end: int
) -> tuple[Array, Array]:
    """Rows A (r, 6) by the base's twist (ω, v), and b (r,), with A twist = b.

    Standing feet have no speed while the joints move.
    """
    robot = motion.robot
    rates = np.zeros(robot.model.nv)
    for name, rate in zip(motion.joints, motion.velocities("joints", begin, end), strict=True):
        rates[robot.joint(name).v] = rate
    for mimic in robot.mimics:
        led = sum(k * rates[robot.joint(leader).v] for leader, k in mimic.leaders.items())
        rates[robot.joint(mimic.joint).v] = led
    state = dynamics(robot, motion.Q[begin : end + 1])
    legs = Motion(np.zeros(3), np.zeros(3), rates)
    rows = []
    speeds = []
    for c in contacts:
        contact = motion.landing.contacts[c]
        lowest = locate_lowest_point(contact, state.rotation[:, contact.body])
        wrenches = constraint_wrenches(state, lowest)
        twists = twist_before(state, legs, contact.body)
        rows.append(wrenches.reshape(-1, 6))
        speeds.append((wrenches @ twists[..., None]).ravel())
    return np.concatenate(rows), -np.concatenate(speeds)


def _base_motions(motion: LoggedMotion) -> tuple[Array, Array]:
    """Columns (6, ·) of the base's rotations and translations that its mount allows."""
    turns = np.eye(6)[:, :3]
    moves = np.eye(6)[:, 3:]
    if motion.landing.base == "planar":
        plane = motion.landing.plane
        turns = turns @ plane.normal[:, None]
        moves = moves @ np.stack([plane.e1, plane.e2], axis=1)
    return turns, moves
