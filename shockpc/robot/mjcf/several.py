"""The robot of an MJCF that holds several robots."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from shockpc.robot.mjcf.compiled import compiled
from shockpc.robot.mjcf.equalities import equalities_of
from shockpc.robot.mjcf.kinds import FREE
from shockpc.robot.robot import RobotSource
from shockpc.text.errors import RobotError
from shockpc.text.names import matches
from shockpc.text.printed import listed


class RobotBodies(NamedTuple):
    """The bodies of an MJCF that belong to one robot.

    Attributes:
        numbers: of the bodies, with the world and what is fixed to it.
        warnings: about the robots that are left out.
    """

    numbers: tuple[int, ...]
    warnings: tuple[str, ...]


def choose(source: RobotSource, frames: Sequence[str]) -> RobotBodies:
    """The robot of an MJCF that holds several, with a warning about the others.

    It is the one that has the first of the `frames` asked for, or else the most joints, together
    with the robots that equalities couple to it. A robot is named by the number of its top-level
    body, its root.

    Args:
        source: of the robot.
        frames: names or globs of bodies, sites and geoms.

    Raises:
        RobotError: as `compiled`; nothing moves, or a floating base is coupled to another body.
    """
    m = compiled(source).model
    moving = np.unique(m.body_rootid[m.body_jntnum > 0])
    mass: dict[int, float] = {}
    for root in moving:
        of_robot = m.body_rootid == root
        mass[int(root)] = float(m.body_mass[of_robot].sum())
    if not mass:
        raise RobotError(
            "no body in it has a joint, so nothing moves; give the robot's base a <freejoint/>"
        )
    asked_for = [root for root in _roots_with(m, frames) if root in mass]
    chosen = asked_for[0] if asked_for else _with_most_joints(m, mass)
    coupled = _coupled_to(m, chosen, set(mass))
    _refuse_floating(m, coupled)

    uncoupled = [root for root in mass if root not in coupled]
    bodies = tuple(np.flatnonzero(~np.isin(m.body_rootid, uncoupled)).tolist())
    if not uncoupled:
        return RobotBodies(bodies, ())
    names = " and ".join(f'"{m.body(root).name}"' for root in sorted(coupled))
    reason = "which has the contact" if asked_for else "with the most joints"
    left_out = ", ".join(f'"{m.body(root).name}" ({mass[root]:.3g} kg)' for root in uncoupled)
    warning = (
        f"it holds {len(mass)} robots that move independently: {names}, {reason}, is computed, "
        f"and {left_out} left out"
    )
    return RobotBodies(bodies, (warning,))


def _roots_with(m: Any, frames: Sequence[str]) -> list[int]:
    """The root of each body, site and geom that is asked for, in the order of the frames."""
    roots: dict[str, list[int]] = {}
    owners = ((m.body, range(m.nbody)), (m.site, m.site_bodyid), (m.geom, m.geom_bodyid))
    for item, bodies in owners:
        for number, body in enumerate(bodies):
            name = item(number).name
            if name:
                roots.setdefault(name, []).append(int(m.body_rootid[body]))
    matching = []
    for frame in frames:
        for name in matches(frame, roots):
            matching += roots[name]
    return matching


def _with_most_joints(m: Any, mass: dict[int, float]) -> int:
    """The root of the robot with the most joints; of several, the heaviest."""

    # Not by mass first: a box may weigh more than the robot.
    def rank(root: int) -> tuple[int, float]:
        of_robot = m.body_rootid == root
        return int(m.body_jntnum[of_robot].sum()), mass[root]

    return max(mass, key=rank)


def _coupled_to(m: Any, root: int, moving: set[int]) -> set[int]:
    """A root, and those that equalities couple to it, directly or through others."""
    couplings = []
    for equality in equalities_of(m):
        couplings.append({int(m.body_rootid[body]) for body in equality.bodies} & moving)
    coupled = {root}
    grown = True
    while grown:
        before = len(coupled)
        for coupling in couplings:
            if coupling & coupled:
                coupled |= coupling
        grown = len(coupled) > before
    return coupled


def _refuse_floating(m: Any, roots: set[int]) -> None:
    """Refuse several coupled robots of which one has a floating base."""
    floating = [
        root for root in roots if m.body_jntnum[root] and m.jnt_type[m.body_jntadr[root]] == FREE
    ]
    if len(roots) > 1 and floating:
        coupled = listed(m.body(root).name for root in sorted(roots))
        remedy = (
            "with a floating base only one top-level body that moves can be computed; set "
            'active="false" on them'
        )
        raise RobotError(f"equalities couple {coupled}, and {remedy}")
