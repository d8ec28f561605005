"""Error and run time of contacts of finite stiffness, beside MuJoCo's soft contact.

The error is against the impulse that they approach.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np

from shockpc import ShockProfile, shock_profile
from shockpc.bench.cases import known_robot, landing
from shockpc.bench.measure import timed
from shockpc.bench.methods import UnsuitedError, system_of
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.core.spatial import Array
from shockpc.judgement.accuracy import double_error
from shockpc.show.tables import Cell, Heading, Sheet
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

STIFFNESSES = (1e3, 1e4, 1e5, 1e6, 1e8, 1e10, 1e12)
"""Stiffnesses of the contact [N/m]."""

ROTOR, SPRING = 0.01, 100.0
"""Reflected inertia of every drive [kg m²], and stiffness of the spring before it [N m/rad].

The impulse does not depend on the spring.
"""


def stiff_contacts(budget: float) -> Sheet:
    """One foot of ANYmal B with rotors behind springs, on contacts of rising stiffness.

    Args: budget for each clock [s].
    """
    robot, scene = landing(known_robot("anymal_b"), "LF_FOOT")
    # What contacts tend to as they get stiffer: the foot slides here, and sticks in MuJoCo.
    slides = replace(scene, contact=(replace(scene.contact[0], directions=("z",)),))
    profile, sticks = shock_profile(slides, robot), shock_profile(scene, robot)
    rows: list[tuple[Cell, ...]] = []

    def add(
        at: ShockProfile,
        what: str,
        size: float,
        run: Callable[[], object],
        jumps: Array,
        last: tuple[float, float],
    ) -> tuple[float, float]:
        """Add a row; its stiffness and error, from which the next row's slope is taken."""
        error = double_error(at.landing, at.proof, jumps)
        # The order of convergence: d log(error) / d log(size) from one row to the next.
        slope: float | None = None
        if error > 0.0 < last[1]:
            slope = math.log(error / last[1]) / math.log(size / last[0])
        rows.append((what, error, slope, median(timed(run, budget)[1])))
        return size, error

    drives = robot.actuated_dofs
    model = profile.landing.joint_model._replace(
        rotor=np.where(drives, ROTOR, 0.0), drive_stiffness=np.where(drives, SPRING, np.inf)
    )
    last = (1.0, math.nan)
    for k in STIFFNESSES:
        stiff = replace(
            profile.landing,
            scene=replace(profile.scene, contact_stiffness=k, gravity=False),
            joint_model=model,
        )
        compliant = CompliantLanding(stiff)
        # The end of compression is where an impulse with e = 0 ends.
        jumps = compliant.impact_at(compliant.compressed).jumps[0, ..., 0]
        run = partial(CompliantLanding, stiff)
        last = add(profile, f"contact of {k:.0e} N/m", k, run, jumps, last)

    # MuJoCo's contacts are as stiff as their time constant τ is short.
    last = (1.0, math.nan)
    for name, method in MUJOCO.items():
        try:
            prepared = method(system_of(robot, scene))
        except UnsuitedError as reason:
            rows.append((f"{name}: {reason}", None, None, None))
            continue
        tau = float(name.split(" = ")[1].split()[0])
        jumps = prepared.read(prepared.run())
        last = add(sticks, name, 1.0 / tau, prepared.run, jumps, last)
    notes = (
        f"one foot of ANYmal B, rotors of {ROTOR:g} kg m² behind springs of {SPRING:g} N m/rad, a "
        f"foot that slides, at the end of "
        "compression; MuJoCo: no rotors, a foot that sticks; error: largest over the bodies, from "
        "the impulse; slope: of log error "
        "over log stiffness, or over log 1/τ",
    )
    header = ("contact", Heading("error", "error", "-", zero=0.0), "slope [-]", "run time [µs]")
    return Sheet("soft contacts against the impulse", header, rows, notes)
