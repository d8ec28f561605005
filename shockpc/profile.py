"""The method on one screen: Scene → ShockProfile.

Step 1: the impulsive equation of motion gives the jump of the joint velocities (shock paper, Eq. 4;
Eq. 7 where some are not free). Step 2: the recursion along the tree turns it into the jump of every
body (Eqs. 8 and 9). Step 3: in the plane, the jump of a body is a point without shock and a radius
(Eqs. 11 and 12).

Everything is linear in the velocity of the strike, so steps 1 and 2 are done for 1 m/s along x, y
and z besides the scene's strike: every strike angle, and the most severe one, is a product
afterwards. The same equations in ball arithmetic enclose the exact answer, and that is what a
profile reports.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from shockpc.core.impulse import Solution
from shockpc.core.spatial import Array, freeze, in_body_axes
from shockpc.core.threads import one_thread
from shockpc.impact.companions import Companions
from shockpc.impact.landed import proven, solved
from shockpc.impact.stops import refuse_missed, with_stops
from shockpc.judgement.health import all_warnings, health_of
from shockpc.judgement.unknowns import unknowns_of
from shockpc.landing.landing import Landing, PosedLanding
from shockpc.landing.posture import check_rotations
from shockpc.landing.resolve import resolve
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import robot_of, scene_of
from shockpc.method.dynamics import dynamics
from shockpc.method.equation import Equation
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.trust import Judge
from shockpc.robot.robot import Robot
from shockpc.text.arguments import checked
from shockpc.text.diagnostic import warn
from shockpc.text.errors import SceneError, StudyError
from shockpc.text.trace import Trace

if TYPE_CHECKING:
    from shockpc.quantities.maps import ShockMaps

JUDGE = Judge(health_of, all_warnings, unknowns_of)
"""Judges every profile."""

FASTEST_PLAUSIBLE_RATE = 1e4
"""Jump of a joint velocity for a strike of 1 m/s above which a posture may be nearly singular.

A proof may refuse it then.
"""

ILL_CONDITIONED = 3e5
"""Condition above which rounding may show above 1e-9 of a body's motion."""


@checked
def shock_profile(
    scene: Scene | str, robot: Robot | None = None, trace: Trace | None = None
) -> ShockProfile:
    """Compute the shock of one landing.

    Args:
        scene: the landing; in its place, here as everywhere, a text may be the name of a scene
            file, or of a robot.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost and what was left out.

    Raises:
        ShockError: the robot, the scene or the model does not allow it; the text says what to
            change.

    Warns:
        ShockWarning: what `health.warnings` holds.
    """
    profile = profile_of_scene(scene_of(scene), robot, trace)
    warn(lambda: profile.warnings)
    return profile


def profile_of_scene(
    scene: Scene, robot: Robot | None = None, trace: Trace | None = None
) -> ShockProfile:
    """The profile of a scene without Python warnings, for callers that return these themselves."""
    trace = trace or Trace()
    with trace.stage("robot file"):
        robot = robot or robot_of(scene)
    with one_thread(robot.model.nv), trace.stage("landing: posture, contacts, joint model"):
        landing = resolve(scene, robot)
    landing.note_omissions(trace)
    return profile_of(landing, trace)


def profile_of(landing: PosedLanding, trace: Trace | None = None) -> ShockProfile:
    """The shock of a resolved landing.

    Raises:
        ShockError: as for `shock_profile`.
    """
    trace = trace or Trace()
    with one_thread(landing.robot.model.nv):
        refuse_missed(landing)
        if landing.scene.stops:
            with trace.stage("end stops that act"):
                landing = with_stops(landing)
        with trace.stage("steps 1 and 2: impulsive equation of motion, jumps of the bodies"):
            jumps = solved(landing).jumps
        with trace.stage("proof: the same in ball arithmetic"):
            proof = proven(landing)
    double_jumps = in_body_axes(jumps, landing.state.rotation)[0]
    freeze(double_jumps)
    profile = ShockProfile(landing, double_jumps, proof, Companions(landing, proof), trace, JUDGE)
    if landing.scene.v_in == "com" and not profile.v_in > 0.0:
        raise SceneError(
            "the robot's centre of mass is at rest before the impact, so it cannot normalise "
            'shock; use v_in = "contact"'
        )
    if landing.scene.friction is not None or landing.scene.yields:
        with (
            one_thread(landing.robot.model.nv),
            trace.stage("ground: friction, or a landing that lasts"),
        ):
            _ = profile.friction, profile.stiffness
    return profile


@checked
def shock_maps(
    landing: Landing | Scene | str, Q: Array | Sequence[Sequence[float]], derivatives: bool = False
) -> "ShockMaps":
    """Steps 1 and 2 in many postures, in double precision.

    Args:
        landing: the landing, or its scene; its posture is not used. Loops have to be closed in each
            of the postures.
        Q: (N, nq) configurations in Pinocchio's layout.
        derivatives: whether those of the maps by the tangent of q are computed too, which takes six
            to eight times as long for a quadruped, and longer with more joints.

    Raises:
        SceneError: Q has another shape, no row, or a rotation whose length is not 1; or the landing
            counts end stops, with which the jumps are not linear in the strike.
        StudyError: an argument is of another type, or the derivatives do not fit into the memory.
    """
    from shockpc.impact.derivatives import derivatives as map_derivatives
    from shockpc.quantities.maps import CHUNK, ShockMaps

    if isinstance(landing, Scene | str):
        scene = scene_of(landing)
        landing = resolve(scene, robot_of(scene))
    if landing.scene.stops:
        raise SceneError(
            "with end stops the jumps are not linear in the contact velocity, so there are no "
            "maps; leave stops out"
        )
    Q = _configurations(landing, Q)
    slopes = _room_for_derivatives(landing, len(Q)) if derivatives else None
    nv = landing.robot.model.nv
    arrays = list[Any]()
    with one_thread(3 * nv if derivatives else nv):
        for k in range(0, len(Q), CHUNK):
            chunk = slice(k, k + CHUNK)
            equation, solution, parts = _in_postures(landing, Q[chunk])
            # The arrays of a single chunk are those of all postures, without a copy.
            if len(Q) <= CHUNK:
                arrays = parts
            else:
                arrays = arrays or [_room_like(part, len(Q)) for part in parts]
                for array, part in zip(arrays, parts, strict=True):
                    array[chunk] = part
            if slopes is not None:
                map_derivatives(landing, equation, solution, out=slopes[chunk])
    return ShockMaps(landing, Q, *arrays)._replace(derivatives=slopes)


def _in_postures(landing: Landing, Q: Array) -> tuple[Equation, Solution, list[Any]]:
    """Step 1 in postures, its solution, and the arrays of `ShockMaps` from `maps` to `columns`."""
    state = dynamics(landing.robot, Q, landing.joint_model)
    equation, solution, maps = solved(landing, state, with_strike=False)
    condition, prove = needs_proof(landing, equation, solution)
    of_bodies = [maps, state.rotation, state.position]
    return equation, solution, [*of_bodies, solution.rank, condition, prove, state.J]


def _configurations(landing: Landing, Q: Any) -> Array:
    """Configurations (N, nq) as they are given, checked.

    Raises:
        SceneError: Q has another shape, no row, or a rotation whose length is not 1.
    """
    from shockpc.quantities.maps import doubles

    configurations = doubles("Q", Q)
    shape, nq = configurations.shape, landing.robot.model.nq
    if len(shape) != 2 or shape[1] != nq or not shape[0]:
        raise SceneError(
            f'Q has shape {shape}; the configurations of robot "{landing.robot.name}" are rows of '
            f"{nq} numbers, shape (N, {nq}); for one posture give q[None]"
        )
    check_rotations(landing.robot, configurations)
    return configurations


def _room_for_derivatives(landing: Landing, postures: int) -> Array:
    """An array for the derivatives of the maps in some postures.

    Raises:
        StudyError: it does not fit into the memory.
    """
    shape = (postures, len(landing.robot.bodies), 6, 3, landing.robot.model.nv)
    try:
        return np.empty(shape)
    except MemoryError:
        raise StudyError(
            f"the derivatives of all maps in {postures} postures take "
            f"{math.prod(shape) / 2**27:.3g} GiB; give fewer postures at a time"
        ) from None


def _room_like(part: Array, postures: int) -> Array:
    """An array for some postures in the memory layout of one for fewer."""
    last = np.moveaxis(part, 0, -1)
    if last.flags.c_contiguous:
        return np.moveaxis(np.empty((*last.shape[:-1], postures), part.dtype), -1, 0)
    return np.empty((postures, *part.shape[1:]), part.dtype)


def needs_proof(
    landing: Landing, equation: Equation, solution: Solution, max_condition: float | None = None
) -> tuple[Array, np.ndarray]:
    """The condition (N,) of a solution of step 1, and where (N,) it needs a proof.

    Both are as in `ShockMaps`.

    Args:
        landing: the landing.
        equation: step 1 in N postures.
        solution: of it.
        max_condition: condition up to which double precision is kept, also where rows are
            redundant, unless rounding can change how many are independent; by default it is kept up
            to `ILL_CONDITIONED`, and nowhere where rows are redundant.
    """
    condition = np.where(np.isnan(solution.condition), np.inf, solution.condition)
    if landing.base != "free" or landing.loops:
        condition = condition * equation.cancellation()
    limit = ILL_CONDITIONED if max_condition is None else max_condition
    slow = np.abs(solution.delta_qd).max(axis=(1, 2)) < FASTEST_PLAUSIBLE_RATE
    prove = (condition > limit) | ~slow
    for k, row_space in solution.row_spaces.items():
        if max_condition is None or row_space.uncertain:
            prove[k] = True
    return condition, prove
