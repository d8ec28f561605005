"""A landing in symbols: against balls, against maps in doubles, and its gradients against differences and derivatives in balls."""

import casadi
import numpy as np
import pinocchio as pin
import pytest
from robot_texts import LIMIT, joint, link, urdf
from test_derivatives import IN_SERIES, in_balls, on
from trees import known_robot, robot_from

from shockpc import Closure, Contact, Joints, SceneError, Scene, SolveError, StudyError, Strike, resolve, shock_maps, symbolic
from shockpc.core.program import OPERATIONS, Program
from shockpc.evaluation.symbolic import SymbolicLanding
from shockpc.impact.exact.arithmetic import NoValueError
from shockpc.impact.exact.symbols import SymbolImpact, program_of
from shockpc.profile import ILL_CONDITIONED, profile_of
from shockpc.quantities.table import QUANTITIES
from shockpc.text.cache import cache_folder

MOVING = Strike(strike_angle_deg=20.0, angular_velocity=(0.2, -0.4, 0.1), joint_velocities={"LF_KFE": 1.5})

LANDINGS = {
    "one foot, moving": on("anymal_b", "LF_FOOT", at="frame", strike=MOVING),
    "two feet, geared": on("anymal_b", "LF_FOOT", "RH_FOOT", at="frame", joints=Joints(armature={"*_KFE": 0.05})),
    "base in the plane, locked": on(
        "anymal_b", "LF_FOOT", base="planar", at="frame", directions=("x", "z"), joints=Joints(locked=("*_HAA", "RH*"))
    ),
    "sliding": on("hyq", "lf_foot", at="frame", directions=("z",), stance=()),
    "followers": on("panda", "panda_leftfinger", at="frame"),
    "several joints of one body": on(IN_SERIES, "shank", at="frame"),
}

NEED_VALUES = {
    "energy_made", "depth", "feasible", "needs_tilt", "off_plane", "shock_min", "shock_max", "delta_v_max", "energy_share",
    "most_severe", "most_severe_direction", "least_severe", "least_severe_direction", "friction_needed", "pull",
}  # fmt: skip
"""Quantities that compare or search; those of all landings here."""


def landing_of(name):
    scene = LANDINGS[name]
    return resolve(scene, robot_from(IN_SERIES, ".xml") if scene.robot == IN_SERIES else known_robot(scene.robot))


def postures(landing, n, size=0.3):
    robot, rng = landing.robot, np.random.default_rng(1)
    Q = np.array([pin.integrate(robot.model, landing.q, size * rng.standard_normal(robot.model.nv)) for _ in range(n)])
    for q in Q:
        robot.set_followers(q)
    return Q


@pytest.mark.parametrize("name", LANDINGS)
def test_every_quantity_is_that_of_balls_or_refused(name):
    landing = landing_of(name)
    q, before = casadi.SX.sym("q", landing.robot.model.nq), casadi.SX.sym("before", 3)
    impact, asked, values, refused = SymbolImpact.of(landing, q, before), [], [], set()
    for entry in QUANTITIES:
        places = [place for place in landing.places(entry.of) if place.body >= 0 or entry.of != "point"]
        if entry.on != "scene" or entry.needs_posture or entry.unproven or not places or entry.of == "part":
            continue
        try:
            values.append(np.asarray(entry.compute(impact, places), dtype=object).ravel())
            asked.append((entry, places))
        except NoValueError:
            refused.add(entry.key)
    assert refused <= NEED_VALUES
    flat = [getattr(value, "e", value) for part in values for value in part]
    program = program_of((q, before), casadi.densify(casadi.vertcat(*map(casadi.SX, flat))))
    Q = postures(landing, 2)
    found = program(np.concatenate([Q, np.tile(landing.before.velocity, (2, 1))], axis=1))
    for k, q in enumerate(Q):
        profile, start = profile_of(landing.at(q)), 0
        for entry, places in asked:
            wanted = np.asarray(profile.values(entry, places), dtype=float)
            here = found[k, start : start + wanted.size].reshape(wanted.shape)
            start += wanted.size
            known = np.isfinite(wanted)
            size = np.abs(wanted[known]).max(initial=1e-3)
            np.testing.assert_allclose(here[known], wanted[known], rtol=1e-9, atol=1e-10 * size, err_msg=entry.key)
