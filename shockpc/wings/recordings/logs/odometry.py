"""The velocity of a base by its standing feet: they stay where they are while the joints move, so
the base moves.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.landing.contact import locate_lowest_point
from shockpc.method.approach import Motion, twist_before
from shockpc.method.constraints import constraint_wrenches
from shockpc.method.dynamics import dynamics
from shockpc.wings.recordings.logs.logged_motion import TWIST, LoggedMotion

DETERMINED = 0.02
"""Smallest singular value, in largest ones, with which the feet determine a motion: of feet nearly
on a line it is smaller.
"""

SLIP = 0.15
"""Speed with which standing feet move against each other from which no motion of the base follows
from them [m/s].
"""


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
    robot, unknown, samples = motion.robot, dict.fromkeys(TWIST, np.nan), slice(begin, end + 1)
    contacts = [c for c in contacts if motion.carried(c)]
    if not contacts:
        return unknown, "no foot stands"
    if np.isinf(motion.period["joints"]):
        return unknown, "the log has no positions of joints"
    rates = np.zeros(robot.model.nv)
    for name, rate in zip(motion.joints, motion.velocities("joints", begin, end), strict=True):
        rates[robot.joint(name).v] = rate
    for mimic in robot.mimics:
        rates[robot.joint(mimic.joint).v] = sum(
            k * rates[robot.joint(leader).v] for leader, k in mimic.leaders.items()
        )
    state = dynamics(robot, motion.Q[samples])
    legs = Motion(np.zeros(3), np.zeros(3), rates)
    rows, speeds = [], []
    for c in contacts:
        block = motion.landing.contacts[c]
        wrenches = constraint_wrenches(
            state, locate_lowest_point(block, state.rotation[:, block.body])
        )
        rows.append(wrenches.reshape(-1, 6))
        speeds.append((wrenches @ twist_before(state, legs, block.body)[..., None]).ravel())
    A, b = np.concatenate(rows), -np.concatenate(speeds)
    known, plane, planar = (
        motion.turning(begin, end, before),
        motion.landing.plane,
        motion.landing.base == "planar",
    )
    turns, moves = np.eye(6)[:, :3], np.eye(6)[:, 3:]
    if planar:
        turns, moves = turns @ plane.normal[:, None], moves @ np.stack([plane.e1, plane.e2], axis=1)
    given = np.zeros(6) if known is None else turns @ np.linalg.lstsq(turns[:3], known)[0]
    basis = moves if known is not None else np.hstack([turns, moves])
    x, _, rank, _ = np.linalg.lstsq(A @ basis, b - A @ given, rcond=DETERMINED)
    if rank < basis.shape[1]:
        feet = "1 standing foot is" if len(contacts) == 1 else f"{len(contacts)} standing feet are"
        return unknown, f"{feet} too few without a gyro (columns wx_body, wy_body and wz_body)"
    twist = given + basis @ x
    if (slips := float(np.abs(A @ twist - b).max())) > SLIP:
        return (
            unknown,
            f"the standing feet move against each other by {slips:.2g} m/s: one slips, or "
            f"positions are noisy",
        )
    return dict(zip(TWIST, (*twist[3:].tolist(), *twist[:3].tolist()), strict=True)), ""
