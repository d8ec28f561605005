"""One's own scene on a ground that gives way: how simulation comes near the impulsive answer as the ground hardens."""

import math
import time
from typing import NamedTuple

import numpy as np

from shockpc.bench.accuracy import apart
from shockpc.bench.simulate import Stepper
from shockpc.bench.system import jumps_between, moving, system_of
from shockpc.core.spatial import Array
from shockpc.errors import SceneError
from shockpc.profile import shock_profile
from shockpc.robot.robot import Robot
from shockpc.scene import Scene
from shockpc.show.tables.sheets import Cell, Sheet

__all__ = ["Compliant", "Ground", "compliant", "compliant_sheet"]

PULSES = tuple(digit * 10.0**k for k in range(-1, -7, -1) for digit in (2.0, 1.0, 0.5))
"""Lengths of the pulse that are tried, one after another until the rigid answer is right to a thousandth [s]."""

STEPS = 200
"""Steps until the deepest point, and as many from there; twice as many change no threshold by more than a hundredth."""


class Ground(NamedTuple):
    """A landing on a ground of one stiffness.

    Attributes:
        stiffness: along the strike, at each contact [N/m].
        pulse: how long the contact pushes [s].
        travel: largest way that a contact was pushed in [m].
        error: of the rigid answer, largest over the bodies, relative to the fastest body's jump [1].
        body: where.
        gravity: what a fall as long as the pulse adds to the speed of the strike [1]; not in the error.
        seconds: that it took.
    """

    stiffness: float
    pulse: float
    travel: float
    error: float
    body: str
    gravity: float
    seconds: float


class Compliant(NamedTuple):
    """A scene on softer and harder grounds.

    Attributes:
        grounds: soft to hard.
        tenth: stiffness from which on the rigid answer is right to 10 % [N/m]; None if no ground tried was hard enough, and that
            of the softest one tried if it is right there already.
        hundredth: the same to 1 %.
        mass: effective mass of a contact along the strike [kg].
        seconds: that the rigid answer took.
    """

    grounds: tuple[Ground, ...]
    tenth: float | None
    hundredth: float | None
    mass: float
    seconds: float


def compliant(scene: Scene, robot: Robot) -> Compliant:
    """Simulate a scene on grounds from soft to hard, and hold the rigid answer against each.

    The contact makes the window: what the robot does after it has let go is no part of the impact. Nor is gravity, which the
    impulsive equation leaves out; what it would add meanwhile stands beside the error.

    Raises:
        ShockError: the scene cannot be computed, or not simulated.
    """
    shock_profile(scene, robot)
    start = time.perf_counter()
    profile = shock_profile(scene, robot)
    rigid = time.perf_counter() - start
    expected = np.hstack([profile.delta_omega, profile.delta_v])
    system = system_of(robot, scene)
    restitution = system.landing.touches[0].restitution
    if any(touch.restitution != restitution for touch in system.landing.touches):
        raise SceneError(
            "contacts that bounce differently cannot be compared with a ground that gives way; give all one restitution"
        )
    falling = Stepper(system, restitution)
    touching = moving(system, system.landing.q, falling.before)
    impedance: Array = np.asarray(np.linalg.pinv(falling.mobility(), rcond=1e-10, hermitian=True), dtype=float)
    strike = falling.speed(falling.before)
    mass = float(strike @ impedance @ strike / (strike @ strike))
    falls = float(np.linalg.norm(system.model.gravity.linear))
    grounds: list[Ground] = []
    for pulse in PULSES:
        start = time.perf_counter()
        travel = _land(falling, impedance, restitution, pulse)
        seconds = time.perf_counter() - start
        errors = np.full(len(robot.bodies), np.inf)
        if np.isfinite(travel):
            jumps = jumps_between(system, touching, moving(system, falling.q, falling.v))
            errors = apart(robot, jumps, expected)
        worst = int(np.argmax(errors))
        stiffness, gravity = mass * _frequency(restitution, pulse) ** 2, falls * pulse / profile.v_in
        grounds.append(Ground(stiffness, pulse, travel, float(errors[worst]), robot.bodies[worst].name, gravity, seconds))
        if grounds[-1].error < 1e-3:
            break
    return Compliant(tuple(grounds), _stiffness_at(grounds, 0.1), _stiffness_at(grounds, 0.01), mass, rigid)


def _frequency(restitution: float, pulse: float) -> float:
    """√(k/m) of a ground on which the pulse is that long: a quarter of a swing down, and e times as long up again [rad/s]."""
    return 0.5 * math.pi * (1.0 + restitution) / pulse


def _land(robot: Stepper, impedance: Array, restitution: float, pulse: float) -> float:
    """A landing on a ground that yields: loaded along one spring, and unloaded along one 1/e² as stiff.

    So it gives back e² of the energy, and lets go by itself. In each direction it is as stiff as the mass behind it asks, so that
    all directions come to rest together.

    Args:
        robot: what lands; it stays as it is when the contact lets go.
        impedance: effective mass (nc, nc) of the rows.
        restitution: e.
        pulse: how long it is to take [s].

    Returns: the largest way that a contact was pushed in [m], infinite if the robot does not come to rest.
    """
    k, h = _frequency(restitution, pulse) ** 2 * impedance, pulse / (1.0 + restitution) / STEPS
    robot.begin()
    x, power = np.zeros(len(k)), 0.0
    for _ in range(4 * STEPS):
        robot.assemble()
        a = robot.acceleration(-k @ x)
        last, power = power, float(x @ k @ robot.speed(robot.v + h * a))
        # In the step in which it turns around, only until there.
        part = h if power > 0.0 or not x.any() else h * last / (last - power)
        robot.step(a, part)
        x = x + part * robot.speed(robot.v)
        if part < h:
            break
    else:
        return math.inf
    deepest, force = x, k @ x
    for _ in range(4 * STEPS):
        if restitution == 0.0 or deepest @ force <= 0.0:
            return float(np.abs(deepest).max())
        robot.assemble()
        robot.step(robot.acceleration(-force), restitution * h)
        x = x + restitution * h * robot.speed(robot.v)
        force = k @ (deepest + (x - deepest) / restitution**2)
    return math.inf


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
    header = (
        "ground [N/m]", "pulse [ms]", "pushed in [mm]", "error of the rigid answer [%]", "worst body", "gravity meanwhile [%]",
        "time [ms]",
    )  # fmt: skip
    rows: list[tuple[Cell, ...]] = [
        (
            f"{one.stiffness:.1e}",
            f"{1e3 * one.pulse:.3g}",
            f"{1e3 * one.travel:.3g}",
            f"{100.0 * one.error:.2g}",
            one.body,
            f"{100.0 * one.gravity:.2g}",
            f"{1e3 * one.seconds:.0f}",
        )
        for one in found.grounds
    ]
    notes = [
        f"the rigid answer took {1e3 * found.seconds:.0f} ms",
        "error: of the jump until the contact lets go, of the worst body, relative to the fastest body's jump; without gravity, "
        "which adds so much of the strike's speed besides",
        f"ground: so stiff along the strike, where {found.mass:.3g} kg are behind each contact; in other directions, and between "
        "contacts, in proportion to the mass there, so that all come to rest together, as the rigid answer takes it: one that is "
        "equally stiff all ways lets one go before another, and ends elsewhere however hard it is",
        "bouncing: the ground is loaded along one spring and unloaded along one 1/e² as stiff; with e = 0 it stays pushed in",
    ]
    softest = found.grounds[0]
    for share, stiffness in ((0.1, found.tenth), (0.01, found.hundredth)):
        told = "on no ground that was tried" if stiffness is None else f"from {stiffness:.1e} N/m on"
        if stiffness == softest.stiffness:
            told = f"on the softest ground that was tried already, {stiffness:.1e} N/m"
        notes.append(
            f"the rigid answer is right to {100 * share:g} % {told}; gravity adds less from "
            f"{softest.stiffness * (softest.gravity / share) ** 2:.1e} N/m on"
        )
    return Sheet("landing on softer and harder ground", header, rows, tuple(notes))
