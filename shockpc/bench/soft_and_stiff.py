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
from shockpc.bench.methods import PinocchioSystem, UnsuitedError, system_of
from shockpc.bench.mujoco_peer import MUJOCO
from shockpc.core.spatial import Array
from shockpc.judgement.accuracy import double_error
from shockpc.show.tables import Heading, Row, Sheet
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

STIFFNESSES = (1e3, 1e4, 1e5, 1e6, 1e8, 1e10, 1e12)
"""Stiffnesses of the contact [N/m]."""

ROTOR, SPRING = 0.01, 100.0
"""Reflected inertia of every drive [kg m²], and stiffness of the spring before it [N m/rad].

The impulse does not depend on the spring.
"""


class _Approach:
    """Landings that approach a rigid contact, the stiffest last, a row for each.

    Args:
        limit: the landing on rigid contacts.
        budget: for each clock [s].
    """

    def __init__(self, limit: ShockProfile, budget: float) -> None:
        self._limit, self._budget = limit, budget
        # Of the last row; without an error the first row has no slope.
        self._size, self._error = 1.0, math.nan

    def row(self, name: str, size: float, run: Callable[[], object], jumps: Array) -> Row:
        """The row of a landing with these jumps (nb, 6), timed by `run`.

        Args: size, stiffness or its like, of which the error is a power.
        """
        error = double_error(self._limit.landing, self._limit.proof, jumps)
        # The order of convergence: d log(error) / d log(size) from one row to the next.
        slope: float | None = None
        if error > 0.0 < self._error:
            slope = math.log(error / self._error) / math.log(size / self._size)
        self._size, self._error = size, error
        return name, error, slope, median(timed(run, self._budget)[1])


def stiff_contacts(budget: float) -> Sheet:
    """One foot of ANYmal B with rotors behind springs, on contacts of rising stiffness.

    Args: budget for each clock [s].
    """
    robot, scene = landing(known_robot("anymal_b"), "LF_FOOT")
    # What contacts tend to as they get stiffer: the foot slides here, and sticks in MuJoCo.
    slides = replace(scene, contact=(replace(scene.contact[0], directions=("z",)),))
    rows = _compliant_rows(shock_profile(slides, robot), budget)
    rows += _mujoco_rows(shock_profile(scene, robot), system_of(robot, scene), budget)
    notes = (
        f"one foot of ANYmal B, rotors of {ROTOR:g} kg m² behind springs of {SPRING:g} N m/rad, a "
        f"foot that slides, at the end of "
        "compression; MuJoCo: no rotors, a foot that sticks; error: largest over the bodies, from "
        "the impulse; slope: of log error "
        "over log stiffness, or over log 1/τ",
    )
    header = ("contact", Heading("error", "error", "-", zero=0.0), "slope [-]", "run time [µs]")
    return Sheet("soft contacts against the impulse", header, rows, notes)


def _compliant_rows(limit: ShockProfile, budget: float) -> list[Row]:
    """The package's landings on contacts of rising stiffness, with rotors behind springs."""
    approach = _Approach(limit, budget)
    drives = limit.robot.actuated_dofs
    joint_model = limit.landing.joint_model._replace(
        rotor=np.where(drives, ROTOR, 0.0), drive_stiffness=np.where(drives, SPRING, np.inf)
    )
    rows = []
    for k in STIFFNESSES:
        scene = replace(limit.scene, contact_stiffness=k, gravity=False)
        stiff = replace(limit.landing, scene=scene, joint_model=joint_model)
        compliant = CompliantLanding(stiff)
        # The end of compression is where an impulse with e = 0 ends.
        jumps = compliant.impact_at(compliant.compressed).jumps[0, ..., 0]
        run = partial(CompliantLanding, stiff)
        rows.append(approach.row(f"contact of {k:.0e} N/m", k, run, jumps))
    return rows


def _mujoco_rows(limit: ShockProfile, system: PinocchioSystem, budget: float) -> list[Row]:
    """MuJoCo's landings; its contacts are as stiff as their time constant τ is short."""
    approach = _Approach(limit, budget)
    rows: list[Row] = []
    for name, method in MUJOCO.items():
        try:
            prepared = method(system)
        except UnsuitedError as reason:
            rows.append((f"{name}: {reason}", None, None, None))
            continue
        tau = float(name.split(" = ")[1].split()[0])
        jumps = prepared.read(prepared.run())
        rows.append(approach.row(name, 1.0 / tau, prepared.run, jumps))
    return rows
