"""Numbers that are known to fewer digits than the jumps of the bodies: a warning for each kind.

The jumps carry their own estimate. What is computed from them, or from the same equations, may lose more digits on the way (an
impulse of a light foot, the load of a joint that hardly carries any), so each is held against the solution in maximal coordinates,
and said to be doubtful where ten times what they are apart is more than 1e-9.
"""

from collections.abc import Sequence

import numpy as np

from shockpc.core.contact_mass import effective_masses
from shockpc.core.impulse import independent_rows, least_impulse, solve_impact
from shockpc.core.loads import energy_lost, joint_impulses
from shockpc.core.maximal import mobility, refine
from shockpc.core.rounding import units_of
from shockpc.core.spatial import Array
from shockpc.core.tree import Tree
from shockpc.health import DOUBTFUL, ONE_DRAW, SAMPLES, TRUSTED, UNMOVED, Verdict
from shockpc.model.bodies import at_com, speed_of, turning_lengths
from shockpc.model.contact import Touch
from shockpc.model.dynamics import Dynamics
from shockpc.model.rows import Rows, about_com, point_block
from shockpc.result import ContactImpulse, JointLoad
from shockpc.results.contacts import total_impulse
from shockpc.robot.robot import Robot

__all__ = [
    "direction_doubts",
    "ill_posed",
    "impulse_doubts",
    "load_doubts",
    "mass_doubts",
    "percussion_doubts",
    "total_doubts",
    "turn_errors",
]


def ill_posed(state: Dynamics, condition: float) -> bool:
    """Whether an inertia enlarges rounding so far that numbers which were solved for with it have to be held against others."""
    return units_of(state.rotation[0]) * condition > 1e-2 * DOUBTFUL


def turn_errors(robot: Robot, state: Dynamics, bodies: Tree, rows: Rows, verdict: Verdict, normal: Array) -> Array:
    """Estimated error (nb,) of every body's jump of angular velocity about the plane's normal [rad/s].

    At most it is a body's whole error, all of it turning. Where that leaves few digits, it is the difference between the solutions
    and what rounding in the placements does, tried out.

    Args:
        robot: the robot.
        state: first posture.
        bodies: the same as free bodies and joints.
        rows: what is held.
        verdict: on the solution.
        normal: (3,) of the plane, world axes.
    """
    motion = at_com(robot, state, verdict.solution.jumps[0, ..., -1])
    speed = speed_of(robot, motion) / turning_lengths(robot)
    most = np.where(speed > 0.0, np.array(verdict.health.body_errors), 0.0) * speed
    second = verdict.second
    if second is None or not np.any(most > TRUSTED * np.abs(motion[:, :3] @ normal)):
        return most
    refined, spread = second.found, second.spread
    if spread is None:
        refined, spread = refine(bodies, about_com(rows.W[0], bodies)[second.rows], refined, SAMPLES, units_of(state.rotation[0]))
    apart = np.abs((motion[:, :3] - refined.twists[:, :3, -1]) @ normal)
    return np.minimum(most, ONE_DRAW * apart + spread[:, :3, -1] @ np.abs(normal))


def percussion_doubts(robot: Robot, turn: Array, error: Array, translates: np.ndarray) -> tuple[str, ...]:
    """Bodies that turn so little that their centre and radius of percussion are known to few digits.

    Args:
        robot: the robot.
        turn: (nb,) jump of angular velocity about the plane's normal [rad/s].
        error: (nb,) of `turn_errors`.
        translates: (nb,) bodies without such numbers.
    """
    share = np.where(translates, 0.0, error / np.where(translates, 1.0, np.abs(turn)))
    return _doubt("centre and radius of percussion", [body.name for body in robot.bodies], share)


def impulse_doubts(rows: Rows, verdict: Verdict) -> tuple[str, ...]:
    """Contacts, feet and closures whose impulse is known to few digits."""
    if verdict.second is None:
        return ()
    impact, chosen = verdict.solution.impact, verdict.second.rows
    alone = np.flatnonzero(impact.unique[0, chosen])
    ours, theirs = impact.impulse[0, chosen[alone], -1], verdict.second.found.impulse[alone, -1]
    names, apart = [], []
    for block, own in zip(rows.blocks, rows.slices, strict=True):
        of_block = (chosen[alone] >= own.start) & (chosen[alone] < own.stop)
        names.append(block.name)
        apart.append([np.linalg.norm((ours - theirs)[of_block]), np.linalg.norm(theirs[of_block])])
    return _doubt("impulse", names, ONE_DRAW * _share(*np.array(apart).T))


def total_doubts(rows: Rows, grounded: int, com: Array, size: float, verdict: Verdict) -> tuple[str, ...]:
    """Whether the ground's impulse as a whole, with its moment, and the energy lost are known to few digits.

    Args:
        rows: what is held.
        grounded: how many of its blocks are the ground's.
        com: (3,) point that the moment is about, from the base [m].
        size: of the robot, by which moments are compared with forces [m].
        verdict: with the second solution.
    """
    if verdict.second is None:
        return ()
    ours, theirs = verdict.solution.impact.impulse[0, :, -1], np.zeros(len(rows.W[0]))
    theirs[verdict.second.rows] = verdict.second.found.impulse[:, -1]
    apart, whole = (
        float(np.linalg.norm([force, moment / size]))
        for force, moment in (total_impulse(rows, grounded, one, com) for one in (ours - theirs, theirs))
    )
    lost, other = (energy_lost(one, rows.b[0, :, -1], rows.restitution) for one in (ours, theirs))
    share = ONE_DRAW * _share(np.array([apart, abs(lost - other)]), np.array([whole, abs(other)]))
    return (*_doubt("total impulse", ["the ground"], share[:1]), *_doubt("loss of kinetic energy", ["the robot"], share[1:]))


def load_doubts(
    robot: Robot, bodies: Tree, rows: Rows, loads: Sequence[JointLoad], verdict: Verdict, size: float
) -> tuple[str, ...]:
    """Joints whose load is known to few digits, and how many carry next to nothing; of loads that are not unique, the least.

    Args:
        robot: the robot.
        bodies: the same as free bodies and joints.
        rows: what is held.
        loads: of its joints, in its order.
        verdict: with the second solution.
        size: of the robot, by which moments are compared with forces [m].
    """
    if verdict.second is None or not loads:
        return ()
    other, chosen = verdict.second.found, verdict.second.rows
    through = other.through[..., -1]
    if len(chosen) < len(rows.W[0]):
        impulse = least_impulse(verdict.solution.equation.J_c[0], verdict.solution.impact.scale[0], chosen, other.impulse)
        through = joint_impulses(bodies, other.twists[..., -1], np.einsum("c,cbk->bk", impulse[:, -1], rows.W[0]))
    names = [robot.model.names[body.joint] for body in robot.bodies]
    through = through[[names.index(load.joint) for load in loads]]
    scale = np.array([1.0 / size] * 3 + [1.0] * 3)
    ours = np.array([[*load.moment, *load.force] for load in loads])
    carried, apart = np.linalg.norm(ours * scale, axis=1), np.linalg.norm((ours - through) * scale, axis=1)
    least = UNMOVED * carried.max()
    idle = int(np.sum((carried > 0.0) & (carried <= least)))
    share = np.where(carried > least, _share(apart, carried), 0.0)
    found = _doubt("load", [f'joint "{load.joint}"' for load in loads], ONE_DRAW * share)
    if idle and np.any(apart[carried <= least] > TRUSTED * carried[carried <= least]):
        which = "1 joint carries" if idle == 1 else f"{idle} joints carry"
        found += (f"{which} less than {UNMOVED:.0e} of the largest load; such loads are rounding",)
    return found


def direction_doubts(robot: Robot, state: Dynamics, verdict: Verdict) -> tuple[str, ...]:
    """Bodies for which strikes from other directions, and so the most and the least severe strike, are known to few digits."""
    if verdict.second is None:
        return ()
    columns = range(3)
    ours = [at_com(robot, state, verdict.solution.jumps[0, ..., k]) for k in columns]
    theirs = [verdict.second.found.twists[..., k] for k in columns]
    size = np.linalg.norm([speed_of(robot, motion) for motion in theirs], axis=0)
    apart = np.linalg.norm([speed_of(robot, one - other) for one, other in zip(ours, theirs, strict=True)], axis=0)
    # What no strike moves to speak of has a warning of its own.
    share = np.where(size > UNMOVED * size.max(), ONE_DRAW * _share(apart, size), 0.0)
    return _doubt("most and least severe impact direction", [body.name for body in robot.bodies], share)


def mass_doubts(
    robot: Robot, state: Dynamics, bodies: Tree, touches: tuple[Touch, ...], rows: Rows, verdict: Verdict,
    contacts: tuple[ContactImpulse, ...], up: Array,
) -> tuple[str, ...]:  # fmt: skip
    """Contacts whose effective masses are known to few digits, where the inertia is so ill-conditioned that they may be.

    Args:
        robot: the robot.
        state: first posture.
        bodies: the same as free bodies and joints.
        touches: the contacts; their rows come first.
        rows: what is held.
        verdict: on the solution.
        contacts: what is reported of the touches.
        up: (3,) unit normal of the ground.
    """
    equation, impact = verdict.solution.equation, verdict.solution.impact
    H, K = equation.H[0], equation.J_c[0, rows.slices[len(touches) - 1].stop :]

    def may_be_off(contact: ContactImpulse) -> bool:
        enlarged = max(1.0, contact.mass_sticking / contact.mass_frictionless, contact.mass_sticking / robot.mass)
        return bool(np.isfinite(enlarged)) and ill_posed(state, float(impact.condition[0]) * enlarged)

    suspects = [pair for pair in zip(touches, contacts, strict=True) if may_be_off(pair[1])]
    if not suspects:
        return ()
    held = solve_impact(H, K, np.zeros((len(K), 1)))
    kept = len(equation.J_c[0]) - len(K) + independent_rows(H, K, int(held.rank), held.dead)
    shares = []
    for found, contact in suspects:
        at = about_com(point_block(state, found.body, found.point, np.eye(3))[0], bodies)
        try:
            A = mobility(bodies, about_com(rows.W[0], bodies)[kept], at)
        except np.linalg.LinAlgError:
            shares.append(np.inf)
            continue
        free, stuck = effective_masses(0.5 * (A + A.T), up)
        apart = [abs(free / contact.mass_frictionless - 1.0), abs(stuck / contact.mass_sticking - 1.0)]
        shares.append(ONE_DRAW * max(apart))
    return _doubt("effective masses", [f'contact "{contact.frame}"' for _, contact in suspects], np.array(shares))


def _share(apart: Array, whole: Array) -> Array:
    """A difference as a share of the whole, elementwise; nothing where there is no difference."""
    return np.where(apart > 0.0, apart / np.where(whole > 0.0, whole, np.finfo(float).tiny), 0.0)


def _doubt(what: str, names: Sequence[str], share: Array) -> tuple[str, ...]:
    """The warning for a kind of number; nothing if all of it is trustworthy. Args: share (n,), estimated relative error [1]."""
    share = np.nan_to_num(np.asarray(share, dtype=float), nan=np.inf)
    bad = [name for name, one in zip(names, share, strict=True) if one > TRUSTED]
    if not bad:
        return ()
    listed = ", ".join(bad[:4]) + (f" and {len(bad) - 4} more" if len(bad) > 4 else "")
    return (f"{what} of {listed}: good to about {min(float(share.max()), 1.0):.0e} of itself only",)
