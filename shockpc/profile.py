"""The method on one screen: Scene → ShockProfile, three steps.

1. The impulsive equation of motion gives the jump of the joint velocities (shock paper, Eq. 4; Eq. 7 where joints depend on
others). 2. The tree's recursion turns it into the jump of every body (Eqs. 8 and 9). 3. In the plane, a body's jump is a point at
rest and a radius (Eqs. 11 and 12).

Everything is linear in the velocity of the strike, so steps 1 and 2 are done for 1 m/s along x, y and z besides the scene's own
strike: every strike angle, and the most severe one, is a product afterwards. The same equations in ball arithmetic enclose the
    exact answer, which is what a profile reports.
"""

from typing import NamedTuple

import numpy as np

from shockpc.core.bodies import body_jumps
from shockpc.core.impulse import TOLERANCE, Impact, RowChoice, choose_rows, is_singular, solve_impact, weakest_columns
from shockpc.core.spatial import Array
from shockpc.errors import SceneError, SolveError
from shockpc.exact.equation import SingularError
from shockpc.exact.proof import Proof, prove
from shockpc.exact.solution import Inputs
from shockpc.landing import Landing, resolve
from shockpc.model.dynamics import Dynamics, dynamics
from shockpc.model.equation import Equation, impulsive_equation
from shockpc.model.rows import block_axes, row_jacobian, row_terms, slices_of
from shockpc.result import ShockProfile, Solution
from shockpc.results.accuracy import rotation_lengths
from shockpc.robot.robot import Robot, load_robot
from shockpc.scene import Scene
from shockpc.trace import Trace

__all__ = ["ShockMaps", "shock_maps", "shock_profile"]


def shock_profile(scene: Scene, robot: Robot | None = None, trace: Trace | None = None) -> ShockProfile:
    """Compute the shock of one landing.

    Args:
        scene: the landing.
        robot: the scene's robot, if it is loaded already.
        trace: collects what each stage cost and what was left out.

    Raises:
        ShockError: the robot, the scene or the model does not allow it; the text says what to change.
    """
    trace = trace or Trace()
    with trace.stage("robot file"):
        robot = robot or load_robot(scene.robot, xacro=scene.xacro, packages=scene.packages, srdf=scene.srdf)
    with trace.stage("landing: posture, contacts, joint model"):
        landing = resolve(scene, robot)
    with trace.stage("step 1: impulsive equation of motion (Eqs. 4 and 7)"):
        equation, b, impact = impact_of(landing, landing.state)
    with trace.stage("step 2: jumps of the bodies (Eqs. 8 and 9)"):
        jumps = jumps_of(robot, landing.state, equation.full(impact.delta_qd))[0]
        to_body = np.swapaxes(landing.state.rotation[0], -1, -2)
        jumps = (to_body[:, None] @ jumps.reshape(-1, 2, 3, 4)).reshape(-1, 6, 4)
    with trace.stage("proof: the same in ball arithmetic"):
        choice, proof = _proven(landing, equation, impact)
    _refuse_contradiction(equation, b[0], choice, proof)
    _note_omissions(trace, landing, equation)
    return ShockProfile(landing, Solution(equation, choice, jumps, impact.impulse[0]), proof, trace)


def impact_of(landing: Landing, state: Dynamics) -> tuple[Equation, Array, Impact]:
    """Step 1 in N postures: Eq. 4 in the free velocities, the speeds b to be undone, and its solution."""
    blocks = landing.rows(state)
    equation = impulsive_equation(state, blocks, landing.joint_model.armature, landing.columns(state))
    b = landing.approach(state, blocks)
    return equation, b, solve_impact(equation.H, equation.J_c, b, equation.terms)


def jumps_of(robot: Robot, state: Dynamics, delta_qd: Array) -> Array:
    """Step 2 in N postures: the jumps (N, nb, 6, k) of every body, world axes, at its frame's origin."""
    return body_jumps(state.J, [joint.v for joint in robot.joints], robot.parents, state.position, delta_qd)


class ShockMaps(NamedTuple):
    """The shock of a landing in N postures: Δv is linear in the strike, so every strike angle and speed is a product.

    Attributes:
        maps: (N, nb, 6, 3) jump (Δω, Δv at the body frame's origin) of every body for a strike of 1 m/s along world x, y and z;
            world axes, double precision [rad/s, m/s].
        rotation: (N, nb, 3, 3) of the body frames, body to world.
        position: (N, nb, 3) origins of the body frames, from the base [m].
        rank: (N,) number of independent contact and closure rows.
        condition: (N,) estimated factor by which rounding is enlarged [1]; inf where double precision has no solution.
        prove: (N,) whether the posture needs a proof: its rows depend on one another, or nearly, or rounding may show above 1e-9.
    """

    maps: Array
    rotation: Array
    position: Array
    rank: np.ndarray
    condition: Array
    prove: np.ndarray

    def at(self, body: int, point: Array) -> Array:
        """Maps (N, 3, 3) from strike to jump of a point of a body, world axes. Args: point (3,) in the body's frame [m]."""
        x, y, z = ((self.rotation[:, body] @ point)[:, i, None] for i in range(3))
        (a, b, c), v = (self.maps[:, body, i] for i in range(3)), self.maps[:, body, 3:]
        return v + np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)


CHUNK = 256
"""Postures that are computed together, so that their arrays stay in the processor's cache."""

NO_INERTIA = 1e-30
"""Below this share of the largest, a diagonal of the inertia is what rounding of the file made of a zero, such as a mass on its
axis.
"""

ILL_CONDITIONED = 1e4
"""Condition above which rounding may show above 1e-9 of a body's motion: some hundred times ε for each unit of it."""


CONTRADICTION = 1e-9
"""Share of the strike that a dependent row may be left with; more is a contradiction."""


def shock_maps(landing: Landing, Q: Array) -> ShockMaps:
    """Steps 1 and 2 in many postures, in double precision.

    Args:
        landing: the landing; its own posture is not used. Loops have to be closed in each of the postures.
        Q: (N, nq) configurations in Pinocchio's layout.
    """
    parts = [_maps(landing, Q[k : k + CHUNK]) for k in range(0, max(len(Q), 1), CHUNK)]
    return parts[0] if len(parts) == 1 else ShockMaps(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def _maps(landing: Landing, Q: Array) -> ShockMaps:
    """One chunk of `shock_maps`."""
    state = dynamics(landing.robot, Q)
    blocks = landing.rows(state)
    equation = impulsive_equation(state, blocks, landing.joint_model.armature, landing.columns(state))
    impact = solve_impact(equation.H, equation.J_c, landing.unit_strikes(state, blocks), equation.terms)
    maps = jumps_of(landing.robot, state, equation.full(impact.delta_qd))
    condition = impact.condition
    if landing.base != "free" or landing.loops:
        condition = condition * equation.cancellation()
    condition = np.where(np.isnan(condition), np.inf, condition)
    prove = condition > ILL_CONDITIONED
    prove[list(impact.choices)] = True
    return ShockMaps(maps, state.rotation, state.position, impact.rank, condition, prove)


def _proven(landing: Landing, equation: Equation, impact: Impact) -> tuple[RowChoice, Proof]:
    """Choose the independent rows, and enclose the impact.

    Raises:
        SolveError: no inertia resists a motion, or rows that should be independent are not.
    """
    joints, length = landing.joint_model, rotation_lengths(landing)
    blocks = tuple(block._replace(point=np.reshape(block.point, 3)) for block in equation.blocks)
    choice = impact.choices.get(0, RowChoice.every(equation.J_c.shape[1]))
    diagonal = np.diagonal(equation.H[0])
    if not np.all(diagonal > NO_INERTIA * diagonal.max(initial=0.0)):
        raise SolveError(_without_inertia(landing.robot, equation, -1))
    for attempt in range(2):
        try:
            return choice, prove(
                Inputs(
                    landing.robot,
                    landing.q,
                    blocks,
                    choice,
                    landing.base,
                    landing.plane,
                    joints.armature,
                    joints.locked,
                    landing.before,
                ),
                length,
            )
        except SingularError as singular:
            if singular.body >= 0 or is_singular(equation.H[0]):
                raise SolveError(_without_inertia(landing.robot, equation, singular.body)) from None
            if attempt:
                break
            size = np.sqrt(np.abs(np.diagonal(equation.H[0])))
            choice = choose_rows(equation.J_c[0], equation.terms(0), size, impact.scale[0])
    names = ", ".join(block.name for block in blocks)
    raise SolveError(f"the rows of {names} depend on one another, and the independent ones cannot be told; leave out a contact")


def _without_inertia(robot: Robot, equation: Equation, body: int) -> str:
    """The message for an inertia that cannot be inverted: the bodies whose joints carry none."""
    columns = weakest_columns(equation.H[0])
    velocities = columns if equation.G is None else [int(np.argmax(np.abs(equation.G[0, :, column]))) for column in columns]
    names = [
        name.name
        for i, (name, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True))
        if i == body or any(joint.v.start <= v < joint.v.stop for v in velocities)
    ]
    listed = ", ".join(f'"{name}"' for name in names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
    return (
        f'{"bodies" if len(names) > 1 else "body"} {listed} of robot "{robot.name}" can move, but no mass or inertia resists it, '
        "so the inertia matrix cannot be inverted; give mass and inertia in the file (mass on a joint's axis does not resist "
        "turning about it), or lock the joints with --lock"
    )


def _refuse_contradiction(equation: Equation, b: Array, choice: RowChoice, proof: Proof) -> None:
    """Refuse rows that cannot be met, because they contradict one another or ask for a motion that the mechanism does not have."""
    others = np.setdiff1d(np.arange(len(b)), choice.rows)
    if not len(others):
        return
    # The independent rows are met to the last digit of the proof. In the others a share of each term is rounding: that of double
    # precision here, and that with which they were found dependent.
    delta_qd = proof.delta_qd[:, 3]
    left = (row_jacobian(equation.state, equation.blocks)[0] @ delta_qd + b[:, 3])[others]
    rounding = TOLERANCE * np.sqrt(len(b)) * (row_terms(equation.state, equation.blocks)[0] @ np.abs(delta_qd))[others]
    excess = np.abs(left) - CONTRADICTION * np.abs(b[:, 3]).max() - rounding
    if excess.max() <= 0.0:
        return
    worst = int(np.argmax(excess))
    row = int(others[worst])
    block, own = next(
        (block, own) for block, own in zip(equation.blocks, slices_of(equation.blocks), strict=True) if row < own.stop
    )
    axis = " ".join(f"{u:.3g}" for u in block_axes(equation.state, block)[0, row - own.start] + 0.0)
    raise SceneError(
        f"{block.name} cannot be stopped: {abs(left[worst]):.3g} m/s are left along ({axis}), because the mechanism cannot move "
        "that way here, or another contact asks for the opposite; leave that direction out of the contact or of the strike, "
        "or free the base"
    )


def _note_omissions(trace: Trace, landing: Landing, equation: Equation) -> None:
    """Note what this scene did not need."""
    reasons = {
        "closure rows and assembly": ("nothing closes a loop", not landing.loops),
        "reduction to free velocities (Eq. 7)": ("every joint velocity is free", equation.G is None),
        "reflected inertia": ("no joint has any", not landing.joint_model.armature.any()),
        "stance rows": ("no foot stands already", not landing.stance),
        "peak accelerations": ("no pulse is given", landing.scene.pulse is None),
    }
    for what, (why, needless) in reasons.items():
        if needless:
            trace.skip(what, why)
