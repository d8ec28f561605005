"""One's own scene on a ground that gives way: how simulation comes near the impulsive answer as the ground hardens."""

import math
import time
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from shockpc.bench.accuracy import apart
from shockpc.bench.simulate import heaviest_mass, land, spring
from shockpc.bench.system import bodies_from, system_of
from shockpc.errors import SceneError
from shockpc.model.robot import Robot
from shockpc.profile import shock_profile
from shockpc.scene import Scene
from shockpc.show.sheets import Cell, Sheet

__all__ = ["Compliant", "Ground", "compliant", "compliant_sheet"]

PULSES = (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
"""Lengths of the pulse that are tried, one after another until the rigid answer is right to a thousandth [s]."""


class Ground(NamedTuple):
    """A landing on a ground of one stiffness.

    Attributes:
        stiffness: [N/m].
        pulse: length of a half-sine on it, π √(m / k) with the heaviest effective mass [s].
        travel: largest way that a contact was pushed in [m].
        error: of the rigid answer, largest over the bodies, relative to the fastest body's jump [1].
        body: where.
        steps: of the integration.
        seconds: that it took.
    """

    stiffness: float
    pulse: float
    travel: float
    error: float
    body: str
    steps: int
    seconds: float


class Compliant(NamedTuple):
    """A scene on softer and harder grounds.

    Attributes:
        grounds: soft to hard.
        tenth: stiffness from which on the rigid answer is right to 10 % [N/m]; None if no ground tried was hard enough.
        hundredth: the same to 1 %.
        mass: effective mass of the heaviest direction of the contacts, which the pulses are counted for [kg].
        seconds: that the rigid answer took.
    """

    grounds: tuple[Ground, ...]
    tenth: float | None
    hundredth: float | None
    mass: float
    seconds: float


def compliant(scene: Scene, robot: Robot) -> Compliant:
    """Simulate a scene on grounds from soft to hard, with gravity, and hold the rigid answer against each.

    The contact is a spring, damped so that the foot stays down (e = 0); with a restitution, its change of velocity counts 1 + e
    times, as it does in the impulsive equation.

    Raises:
        ShockError: the scene cannot be computed, or not simulated.
    """
    shock_profile(scene, robot)
    start = time.perf_counter()
    profile = shock_profile(scene, robot)
    rigid = time.perf_counter() - start
    expected = np.hstack([profile.delta_omega, profile.delta_v])
    system = system_of(robot, scene)
    data = system.model.createData()
    bounce = 1.0 + system.setting.touches[0].restitution
    if any(1.0 + touch.restitution != bounce for touch in system.setting.touches):
        raise SceneError(
            "contacts that bounce differently cannot be compared with a ground that gives way; give all one restitution"
        )
    grounds: list[Ground] = []
    mass = heaviest_mass(system)
    for pulse in PULSES:
        stiffness = mass * (math.pi / pulse) ** 2
        start = time.perf_counter()
        landing = land(system, spring(mass, stiffness))
        seconds = time.perf_counter() - start
        if np.all(np.isfinite(landing.delta)):
            pin.forwardKinematics(system.model, data, system.setting.q, bounce * landing.delta)
            errors = apart(robot, bodies_from(system, data.v), expected)
        else:
            errors = np.full(len(robot.bodies), np.inf)
        worst = int(np.argmax(errors))
        name = robot.bodies[worst].name
        grounds.append(Ground(stiffness, pulse, landing.travel, float(errors[worst]), name, landing.steps, seconds))
        if grounds[-1].error < 1e-3:
            break
    return Compliant(tuple(grounds), _stiffness_at(grounds, 0.1), _stiffness_at(grounds, 0.01), mass, rigid)


def _stiffness_at(grounds: list[Ground], error: float) -> float | None:
    """The stiffness from which on the error stays below a bound, between two grounds on logarithmic scales."""
    for softer, harder in zip(reversed(grounds[:-1]), reversed(grounds[1:]), strict=True):
        if harder.error > error:
            return None
        if softer.error > error:
            if not math.isfinite(softer.error):
                return harder.stiffness
            share = math.log(softer.error / error) / math.log(softer.error / harder.error)
            return float(softer.stiffness * (harder.stiffness / softer.stiffness) ** share)
    return grounds[0].stiffness if grounds[0].error <= error else None


def compliant_sheet(found: Compliant) -> Sheet:
    """The grounds as a table, and from which stiffness on the rigid answer holds."""
    header = ("ground [N/m]", "pulse [ms]", "pushed in [mm]", "error of the rigid answer [%]", "worst body", "steps", "time [ms]")
    rows: list[tuple[Cell, ...]] = [
        (
            f"{one.stiffness:.1e}",
            f"{1e3 * one.pulse:.3g}",
            f"{1e3 * one.travel:.3g}",
            f"{100.0 * one.error:.2g}",
            one.body,
            str(one.steps),
            f"{1e3 * one.seconds:.0f}",
        )
        for one in found.grounds
    ]
    notes = [
        f"the rigid answer took {1e3 * found.seconds:.0f} ms",
        f"pulse: a half-sine of the contact's heaviest effective mass, {found.mass:.3g} kg; gravity acts all the time",
        "error: of the jump of the worst body, relative to the jump of the fastest",
    ]
    for share, stiffness in (("10 %", found.tenth), ("1 %", found.hundredth)):
        told = "on no ground that was tried" if stiffness is None else f"from {stiffness:.1e} N/m on"
        notes.append(f"the rigid answer is right to {share} {told}")
    return Sheet("landing on softer and harder ground", header, rows, tuple(notes))
