"""Centre and radius of percussion against the reference, where a body hardly turns: RoPc = v_in / |n·ω| runs to infinity."""

from dataclasses import dataclass

import numpy as np
from mpmath import mp

from shockpc.bench.cases import Case
from shockpc.bench.exact import DIGITS, cross, widen
from shockpc.bench.reference import reference
from shockpc.bench.system import system_of
from shockpc.profile import shock_profile

__all__ = ["Radius", "radii"]


@dataclass(frozen=True)
class Radius:
    """Centre and radius of percussion of one body.

    Attributes:
        label: value of the case's parameter.
        body: variant and name of the body.
        exact: RoPc of the reference [m]; infinite if the body does not turn.
        ropc: relative error of the product's RoPc [1]; None if it says that the body translates.
        copc: error of its CoPc, relative to the distance of the exact one from the body frame's origin [1]; None likewise.
        warned: whether the product warned of anything.
    """

    label: str
    body: str
    exact: float
    ropc: float | None
    copc: float | None
    warned: bool


def radii(case: Case) -> list[Radius]:
    """Hold every body's centre and radius of percussion against exact ones.

    Raises:
        ShockError: the case has no answer.
    """
    robot, scene = case.build()
    system = system_of(robot, scene)
    truth, profile = reference(robot, system.scene, system.landing), shock_profile(scene, robot)
    found: list[Radius] = []
    with mp.workdps(DIGITS):
        for i, body in enumerate(robot.bodies):
            normal = widen(np.asarray(profile.plane.normal @ profile.rotation[i]))
            turn = normal @ truth.jumps[i][:3]
            exact = profile.v_in / abs(turn) if turn else mp.inf
            ropc = copc = None
            if not profile.translates[i]:
                centre = cross(normal, truth.jumps[i][3:]) / turn if turn else widen(np.full(3, np.inf))
                off = widen(profile.copc[i]) - centre
                ropc = float(abs(float(profile.ropc[i]) / exact - 1))
                copc = float(mp.sqrt(off @ off) / mp.sqrt(centre @ centre))
            found.append(
                Radius(case.label, f"{case.variant}, {body.name}", float(exact), ropc, copc, bool(profile.health.warnings))
            )
    return found
