"""Choose the independent rows of a landing, enclose its impact, and refuse what no impact can do."""

import itertools
from collections.abc import Iterator

import numpy as np

from shockpc.core.impulse import TOLERANCE, Impact, RowChoice, choose_rows, is_singular, weakest_columns
from shockpc.errors import SceneError, SolveError
from shockpc.exact.equation import SingularError
from shockpc.exact.proof import Proof, prove
from shockpc.exact.solution import Inputs
from shockpc.landing import Landing
from shockpc.model.equation import Equation
from shockpc.model.rows import block_axes, row_jacobian, row_terms, slices_of
from shockpc.results.accuracy import rotation_lengths
from shockpc.results.speed import normalising_speed
from shockpc.robot.robot import Robot

__all__ = ["proven"]

NO_INERTIA = 1e-30
"""Share of the largest diagonal entry of the inertia below which one is what rounding of the file made of a zero."""

CONTRADICTION = 1e-9
"""Share of the strike with which a dependent row may be left; more is a contradiction."""


def proven(landing: Landing, equation: Equation, impact: Impact) -> tuple[RowChoice, Proof]:
    """Choose the independent rows, and enclose the impact.

    Args:
        landing: the landing.
        equation: in its posture.
        impact: solution of that in double precision.

    Raises:
        SolveError: no inertia resists a motion, or rows that should be independent are not.
        SceneError: the mechanism cannot meet its contacts.
    """
    if not np.isfinite(equation.H).all():
        raise SolveError(
            f'the inertia matrix of robot "{landing.robot.name}" is not finite: its masses and lengths are too large for double '
            "precision; give them in kg and m"
        )
    diagonal = np.diagonal(equation.H[0])
    if not np.all(diagonal > NO_INERTIA * diagonal.max(initial=0.0)):
        raise SolveError(_without_inertia(landing.robot, equation, -1))
    joints, length = landing.joint_model, rotation_lengths(landing)
    blocks = tuple(block._replace(point=np.reshape(block.point, 3)) for block in equation.blocks)
    every = RowChoice.every(equation.J_c.shape[1])
    for choice in [impact.choices[0]] if impact.choices else itertools.chain([every], _chosen(equation, impact)):
        inputs = Inputs(
            landing.robot, landing.q, blocks, choice, landing.base, landing.plane, joints.armature, joints.locked, landing.before
        )
        try:
            proof = prove(inputs, length)
        except SingularError as singular:
            if singular.body >= 0 or is_singular(equation.H[0]):
                raise SolveError(_without_inertia(landing.robot, equation, singular.body)) from None
            continue
        _refuse_contradiction(equation, choice, proof)
        if landing.scene.v_in == "com":
            normalising_speed(landing, proof.enclosure)  # which refuses a centre of mass at rest
        return choice, proof
    names = ", ".join(block.name for block in blocks)
    raise SolveError(f"the rows of {names} depend on one another, and rounding decides which; leave out a contact")


def _chosen(equation: Equation, impact: Impact) -> Iterator[RowChoice]:
    """The rows that are independent on a closer look than `solve_impact` took."""
    size = np.sqrt(np.abs(np.diagonal(equation.H[0])))
    yield choose_rows(equation.J_c[0], equation.terms(0), size, impact.scale[0])


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


def _refuse_contradiction(equation: Equation, choice: RowChoice, proof: Proof) -> None:
    """Refuse rows that cannot be met, because they contradict one another or ask for a motion that the mechanism does not have."""
    b = equation.b[0]
    others = np.delete(np.arange(len(b)), choice.rows)
    if not len(others):
        return
    # The independent rows are met to the last digit of the proof. In the others a share of each term is rounding: that of double
    # precision here, and that with which they were found dependent.
    delta_qd = proof.delta_qd[:, 3]
    left = (row_jacobian(equation.state, equation.blocks)[0] @ delta_qd + b[:, 3])[others]
    rounding = TOLERANCE * np.sqrt(len(b)) * (row_terms(equation.state, equation.blocks)[0] @ np.abs(delta_qd))[others]
    excess = np.abs(left) - CONTRADICTION * np.abs(b[:, 3]).max() - rounding
    worst = int(np.argmax(excess))
    if excess[worst] <= 0.0:
        return
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
