"""The package's own answers: the proven one, from which every error is measured, and those in double precision."""

import functools
import importlib.util
from pathlib import Path
from typing import Any

import numpy as np

import shockpc
from shockpc.core.impulse import independent_rows
from shockpc.core.percussion import percussion
from shockpc.core.spatial import Array
from shockpc.landing import Landing, resolve
from shockpc.model.closure import all_loops, closure_block
from shockpc.model.columns import freedom
from shockpc.model.contact import stance_block, touch_block
from shockpc.model.dynamics import dynamics
from shockpc.model.equation import solve
from shockpc.model.rows import stack
from shockpc.profile import shock_profile
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["double_jumps", "double_percussion", "maps_in_many", "reference"]

CHUNK = 128
"""Postures that are solved together, so that their matrices stay in the cache."""


def reference(scene: Scene, robot: Robot) -> Array:
    """The proven jumps (nb, 6, 4) of all bodies (Δω, Δv), body coordinates at the body frames' origins, as the nearest doubles.

    Columns: unit strikes along world x, y and z, then the strike of the scene.

    Raises:
        ShockError: the landing has no answer.
    """
    profile = shock_profile(scene, robot)
    landing = resolve(profile.scene, robot)
    found = solve(robot, landing.state, landing.rows, landing.drives.armature, landing.G)
    equation, impact = found.equation, found.impact
    rows = independent_rows(equation.H[0], equation.J_c[0], int(impact.rank[0]), impact.dead[0])
    return np.asarray(np.vectorize(float)(_oracle().maximal_jumps(robot, profile.scene, landing, rows).jumps))


@functools.cache
def _oracle() -> Any:
    """The independent solution of the tests."""
    place = Path(shockpc.__file__).parents[1] / "tests" / "maximal.py"
    spec = importlib.util.spec_from_file_location("maximal", place)
    if spec is None or spec.loader is None:
        raise FileNotFoundError(place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def double_jumps(robot: Robot, scene: Scene, landing: Landing) -> Array:
    """Steps 1 and 2 in double precision for the scene's strike: jumps (nb, 6) in body coordinates at the body frames' origins."""
    return _solve(robot, scene, landing, landing.q[None])[0, ..., 3]


def double_percussion(robot: Robot, scene: Scene, landing: Landing) -> Array:
    """Steps 1 to 3 in double precision: centres and radii of percussion (nb, 4) [m]."""
    jumps = double_jumps(robot, scene, landing)
    normal = landing.plane.normal @ landing.state.rotation[0]
    found = percussion(jumps[:, :3], jumps[:, 3:], normal, 1.0, 1.0, 0.0)
    return np.column_stack([found.copc, found.ropc])


def maps_in_many(robot: Robot, scene: Scene, landing: Landing, Q: Array) -> Array:
    """Steps 1 and 2 in double precision for many postures Q (N, nq): maps (N, nb, 6, 3) from strike velocity to jump."""
    return np.concatenate([_solve(robot, scene, landing, Q[k : k + CHUNK])[..., :3] for k in range(0, len(Q), CHUNK)])


def _solve(robot: Robot, scene: Scene, landing: Landing, Q: Array) -> Array:
    """Steps 1 and 2 in some postures: jumps (N, nb, 6, 4)."""
    state = dynamics(robot, Q)
    rows = stack(
        [
            *(touch_block(state, touch, landing.before) for touch in landing.touches),
            *(stance_block(robot, state, frame) for frame in scene.stance),
            *(closure_block(state, loop) for loop in all_loops(robot, scene.closure)),
        ]
    )
    G = freedom(robot, scene.base or "free", landing.plane, state.rotation[:, 0], landing.drives.locked)
    return solve(robot, state, rows, landing.drives.armature, G).jumps
