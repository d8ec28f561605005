"""A landing solved in doubles in N postures, and proven in its own.

An impact that is not possible is refused by name.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from shockpc.core.impulse import (
    TOLERANCE,
    UNCERTAIN,
    RowSpace,
    Solution,
    column_sizes,
    in_terms,
    weakest_columns,
)
from shockpc.core.inertia import definite
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, velocity_at
from shockpc.impact.exact_impact import BallImpact
from shockpc.impact.last_digits import last_digits_changed
from shockpc.landing.landing import Landing, PosedLanding
from shockpc.method.constraints import (
    Constraint,
    constraint_axes,
    row_jacobian,
    row_terms,
    slices_of,
)
from shockpc.method.dynamics import Dynamics
from shockpc.method.equation import Equation, Posed, equation_of
from shockpc.method.exact.arithmetic import SingularError
from shockpc.method.exact.balls import BallSolution
from shockpc.method.exact.enclosed import enclosed
from shockpc.method.exact.proof import Proof
from shockpc.method.shock import Solved, jumps_of, solution_of
from shockpc.robot.bodies_and_joints import Joint
from shockpc.robot.robot import Robot
from shockpc.text.errors import SolveError
from shockpc.text.printed import few, listed

T = TypeVar("T")

UNPHYSICAL = 1e6
"""Motion relative to the strike beyond which it is that of a singular posture, and not physically
plausible [1].
"""

FAST = 100.0
"""Motion relative to the strike above which rounding of the file may be all that keeps the posture
from being singular.
"""

NO_INERTIA = 1e-30
"""Share of the largest diagonal entry of the inertia below which one is what rounding of the file
made of a zero.
"""

CONTRADICTION = 1e-9
"""Share of the strike with which a dependent row may be left; more is a contradiction."""


class LandingProof(Proof):
    """The proof of a landing; what it reads are functions of the impact in balls.

    Args:
        landing: the landing.
        posed: its system in its posture, and what is held.
        row_space: which of its rows are independent.

    Attributes:
        landing: the landing.
    """

    def __init__(self, landing: PosedLanding, posed: Posed, row_space: RowSpace) -> None:
        self.landing = landing
        super().__init__(posed, row_space)

    def numbers_of(self, solution: BallSolution) -> BallImpact:
        """The impact of the landing."""
        return BallImpact(solution, self.landing)

    def with_last_digits_changed(self, compute: Callable[[BallImpact], T], pattern: int) -> T:
        """The value of a function of the impact with every datum changed in its last digit.

        The changes are those of the pattern with that number.

        Raises:
            PrecisionError: a ball is too wide.
            SingularError: that impact has no solution.
        """
        landing, data = last_digits_changed(self.landing, pattern)
        return self.with_other_data(
            lambda solution: compute(BallImpact(solution, landing)), landing.posed, data
        )


def solved(
    landing: Landing,
    state: Dynamics | None = None,
    with_strike: bool = True,
    bodies: Sequence[int] | None = None,
) -> Solved:
    """Steps 1 and 2 of a landing in N postures, in doubles.

    Args:
        landing: the landing.
        state: the robot in the postures, with the armature of its joints; by default in the posture
            of the landing, whose solution is computed once.
        with_strike: whether the scene's strike is computed besides those of 1 m/s along world x, y
            and z (k = 4 or 3).
        bodies: indices of those whose jumps are wanted, in that order; all by default.
    """
    posed = isinstance(landing, PosedLanding) and (state is None or state is landing.state)
    if isinstance(landing, PosedLanding) and posed and with_strike:
        equation = landing.equation(landing.state)
        solution = solution_in_doubles(landing)
    else:
        assert state is not None
        equation = landing.equation(state, with_strike)
        solution = solution_of(equation, landing.row_limits(state, equation.constraints))
    return Solved(equation, solution, jumps_of(equation, solution.delta_qd, bodies))


@memoized()
def solution_in_doubles(landing: PosedLanding) -> Solution:
    """Step 1 of a landing in its posture; computed once."""
    equation = landing.equation(landing.state)
    return solution_of(equation, landing.row_limits(landing.state, equation.constraints))


def proven(landing: PosedLanding) -> LandingProof:
    """The proof of a landing: which rows are independent, and the impact in balls.

    Raises:
        SolveError: no inertia resists a motion, the mechanism cannot meet its contacts, rounding
            can change which rows are independent, or the posture is so nearly singular that the
            result is not physically plausible.
    """
    equation = landing.equation(landing.state)
    H, size = equation.H[0], np.abs(np.diagonal(equation.H[0]))
    if not np.isfinite(H).all():
        raise without_kinetic_energy(landing, equation.state.H)
    if not np.all(np.diagonal(H) > NO_INERTIA * size.max(initial=0.0)):
        raise without_inertia(landing, equation)
    limits = landing.row_limits(landing.state, landing.constraints)
    try:
        proof = enclosed(
            equation,
            landing.posed,
            solution_in_doubles(landing),
            limits,
            partial(LandingProof, landing),
        )
    except SingularError:
        raise without_inertia(landing, equation) from None
    if proof is not None:
        _refuse_contradiction(landing, equation, proof)
        _refuse_singular(landing, equation, proof, len(proof.row_space.rows))
        if not proof.row_space.uncertain:
            return proof
    rows = ", ".join(constraint.name for constraint in landing.constraints)
    raise SolveError(
        f"no verdict: in {_posture(landing)} the rows of {rows} depend on one another so nearly "
        "that rounding can change how many of them are independent. Leave one out (a contact, a "
        "direction, the rotation of a flat one), put points that nearly meet exactly together or a "
        "billionth of the robot apart, or set another posture with --set",
        constraints=[constraint.frame for constraint in landing.constraints],
    )


def without_kinetic_energy(landing: PosedLanding, H: Array) -> SolveError:
    """Why the inertia matrix that the numbers of the robot's file make is not one of a mechanism.

    Args:
        landing: the landing.
        H: (n, nv, nv) as computed, before it is tested.
    """
    if not np.isfinite(H).all():
        return SolveError(
            f'the inertia matrix of robot "{landing.robot.name}" is not finite: its masses and '
            f"lengths are too large for double "
            "precision; give them in kg and m"
        )
    return SolveError(
        f'in {_posture(landing)} the inertia matrix of robot "{landing.robot.name}" is not '
        f"positive definite, so some motion "
        "would have no or a negative kinetic energy, because of the principal moments of "
        f"{few(landing.robot.negative_moments, 4)}; none can be negative: correct them in the file"
    )


def rows_as_meant(landing: PosedLanding) -> tuple[Array, Array]:
    """The rows J_c G (nc, ny) and speeds (nc,) to be undone, without rounding of the file.

    The speeds are those of the scene's strike.
    """
    equation = landing.equation(landing.state)
    limit = landing.row_limits(landing.state, landing.constraints)(0)
    J = equation.J_c[0]
    b = equation.b[0, :, 3]
    if limit.most == len(J):
        return J, b
    # Combinations of rows, in units of their terms, of which only rounding of the file is left.
    rounding = equation.row_space(limit).infeasible
    terms = equation.terms()[0]
    size = column_sizes(terms)
    term_size, scaled = in_terms(J, terms, size)
    J_left = rounding.T @ (rounding @ scaled)
    b_left = rounding.T @ (rounding @ (b / term_size))
    return J - J_left * term_size[:, None] * size, b - b_left * term_size


def independent_rows_of(landing: PosedLanding, constraints: tuple[Constraint, ...]) -> list[int]:
    """Indices of independent rows of some constraints, alone, in the landing's posture."""
    if not constraints:
        return []
    state = landing.state
    equation = equation_of(landing.system._replace(before=None), state, constraints)
    row_space = equation.row_space(landing.row_limits(state, constraints)(0))
    return [int(row) for row in row_space.rows]


def _posture(landing: PosedLanding) -> str:
    return f'posture "{landing.scene.posture.reference}"'


def without_inertia(landing: PosedLanding, equation: Equation) -> SolveError:
    """The error for an inertia that cannot be inverted.

    It names the bodies whose joints carry none, and the joints to be locked.
    """
    robot = landing.robot
    velocities = weakest_columns(equation.H[0])
    if equation.G is not None:
        velocities = [int(np.argmax(np.abs(equation.G[0, :, k]))) for k in velocities]
    moves = np.zeros(robot.model.nv, dtype=bool)
    moves[velocities] = True
    pairs = zip(robot.bodies, robot.joints, strict=True)
    names = [body.name for body, joint in pairs if moves[joint.v].any()]
    lock = _to_be_locked(robot, moves)
    several = "bodies" if len(names) > 1 else "body"
    light_base = landing.base != "fixed" and robot.bodies[0].name in names and not robot.masses[0]
    bolt = "bolt the robot's massless root down with --base fixed, or " if light_base else ""
    or_lock = f", or lock {listed(lock, 12)} with --lock" if lock else ""
    return SolveError(
        f'{several} {listed(names, 6)} of robot "{robot.name}" can move, but no mass or inertia '
        f"resists it, so the inertia matrix cannot be inverted; {bolt}give mass and inertia in the "
        f"file (mass on a joint's axis does not resist turning about it){or_lock}",
        bodies=names,
        joints=lock,
    )


def _to_be_locked(robot: Robot, moves: np.ndarray) -> list[str]:
    """The joints whose velocities are some of (nv,), with all that are geared to them."""
    joints = {
        joint.name for joint in robot.single_joints if joint.kind != "free" and moves[joint.v].any()
    }
    # all that are geared to one another are locked together
    for mimic in (*robot.mimics, *reversed(robot.mimics)):
        geared = {mimic.joint, *mimic.leaders}
        if joints & geared:
            joints |= geared
    return [name for name in robot.joint_names if name in joints]


class Residual(NamedTuple):
    """The speeds left along dependent rows, of those that an impact undoes.

    The four columns are as of `Proof.jumps`.

    A strike for which more is left than `CONTRADICTION` of its largest speed and rounding
    contradicts the rows: it has no verdict.

    Attributes:
        rows: (n,) numbers of the dependent rows.
        left: (n, 4) along these rows [m/s, rad/s].
        speeds: (nc, 4) that are to be undone, along all rows [m/s, rad/s].
        rounding: (n,) largest share of the length of the motion that is left by rounding.
        motion: (nv, 4) jumps of the joint velocities in units of the rows.
    """

    rows: np.ndarray
    left: Array
    speeds: Array
    rounding: Array
    motion: Array

    @property
    def excess(self) -> Array:
        """The excess (n,) of what is left of the landing's strike.

        Above zero the rows are contradicted.
        """
        of_speeds = CONTRADICTION * np.abs(self.speeds[:, 3]).max()
        of_rounding = self.rounding * np.linalg.norm(self.motion[:, 3])
        return np.asarray(np.abs(self.left[:, 3]) - (of_speeds + of_rounding))


def residual(proof: LandingProof) -> Residual:
    """The speeds that a solution leaves along the dependent rows."""
    landing = proof.landing
    state = landing.state
    equation = landing.equation(state)
    b = equation.b[0]
    rows = np.delete(np.arange(len(b)), proof.row_space.rows)
    left = row_jacobian(state, landing.constraints)[0] @ proof.delta_qd + b
    # The independent rows are met to the last digit of the proof. In the others a share of each
    # term is rounding: that of double precision here, and that with which they were found
    # dependent. That of a file's digits counts only where rows differ by it.
    tolerance = UNCERTAIN[1] * TOLERANCE
    if proof.row_space.discarded:
        tolerance = equation.tolerance
    tolerance = max(tolerance, proof.row_space.slack)
    terms = row_terms(state, landing.constraints)[0]
    size = column_sizes(terms)
    rounding = tolerance * len(b) * np.linalg.norm(terms / size, axis=1)
    return Residual(rows, left[rows], b, rounding[rows], size[:, None] * proof.delta_qd)


def _refuse_contradiction(landing: PosedLanding, equation: Equation, proof: LandingProof) -> None:
    """Refuse rows that cannot be met.

    They contradict one another, or ask for a motion that the mechanism does not have.
    """
    residuals = residual(proof)
    if not residuals.excess.max(initial=0.0) > 0.0:
        return
    k = int(np.argmax(residuals.excess))
    worst, left = int(residuals.rows[k]), float(residuals.left[k, 3])
    constraint, axis = _direction(equation, worst)
    free = ""
    if not landing.robot.free_base:
        free = (
            '; its file fixes the base: free it with base = "free" (--base free); if several '
            "limbs hang on the world, put them into one body with a <freejoint/> first"
        )
    elif landing.base != "free" and landing.robot.bodies[0].mass:
        free = ", or free the base"
    raise SolveError(
        f"no verdict: {constraint.name} cannot be stopped in {_posture(landing)}: "
        f"{abs(left):.3g} m/s are left along ({axis}), because the mechanism cannot move that way "
        "here, or another contact asks for the opposite; leave that direction out of the contact "
        f"or of the contact velocity, take another contact point or posture{free}",
        constraints=[constraint.frame],
        rows=[worst],
    )


def _direction(equation: Equation, row: int) -> tuple[Constraint, str]:
    """The contact, standing foot, loop or stop that a row belongs to, and the row's axis."""
    k = next(k for k, rows in enumerate(slices_of(equation.constraints)) if row < rows.stop)
    constraint = equation.constraints[k]
    rows = slices_of(equation.constraints)[k]
    axis = constraint_axes(equation.state, constraint)[0, row - rows.start] + 0.0
    return constraint, " ".join(f"{u:.3g}" for u in axis)


def greatest_motion(landing: PosedLanding, jumps: Array, length: Array) -> tuple[float, int]:
    """The largest motion of a body relative to the approach of the fastest contact [1].

    The second value is the body's index.

    Args:
        landing: the landing.
        jumps: (nb, 6) of the bodies (Δω, Δv), body coordinates.
        length: (nb,) by which their rotation counts as a speed [m].
    """
    speeds = body_speeds(landing.robot, jumps, length)
    return float(speeds.max()) / landing.fastest_approach, int(np.argmax(speeds))


def body_speeds(robot: Robot, jumps: Array, length: Array) -> Array:
    """Speed (nb,) of the centre of mass, or the rotation times a length (nb,) if that is more.

    Args: jumps (nb, 6).
    """
    omega = jumps[:, :3]
    of_centre = np.linalg.norm(velocity_at(omega, jumps[:, 3:], robot.coms), axis=1)
    of_rotation = np.linalg.norm(omega, axis=1) * length
    return np.asarray(np.fmax(of_centre, of_rotation))


def _refuse_singular(
    landing: PosedLanding, equation: Equation, proof: LandingProof, rank: int
) -> None:
    """Refuse a posture that is so nearly singular that the impact is not physically plausible.

    Also one whose impact is left by rounding of the file.

    Args: rank, number of independent rows.
    """
    robot = landing.robot
    times, body = greatest_motion(landing, proof.jumps[..., 3], _lengths(landing))
    # The turning of joints counts as a speed at the largest radius of gyration.
    fastest = float(np.abs(proof.delta_qd[:, 3]).max())
    turning = fastest * float(robot.gyration.max()) / landing.fastest_approach

    # A joint without inertia moves fast in any posture; another posture would not help.
    if max(times, turning) > FAST and not np.isfinite(definite(equation.H)).all():
        raise without_inertia(landing, equation)

    if not times <= UNPHYSICAL:
        raise _singular(landing, equation, proof, times, body, "")
    # Below the limit, a fast motion is refused only where rounding alone leaves a row independent.
    if times > FAST:
        independent = landing.mechanism.independent_here(landing.constraints, landing.state)
        if independent < rank:
            digits = ", up to rounding of the angles and lengths in the file"
            raise _singular(landing, equation, proof, times, body, digits)


def _singular(
    landing: PosedLanding,
    equation: Equation,
    proof: LandingProof,
    times: float,
    body: int,
    digits: str,
) -> SolveError:
    """The error of a posture that is nearly singular.

    Args:
        landing: in its posture.
        equation: Eq. 4.
        proof: of it.
        times: how many times as fast as the contact the fastest body would move.
        body: that one.
        digits: up to what the posture is singular, in words.
    """
    robot = landing.robot
    # The fast joints are those whose values make the posture singular.
    rates = np.abs(proof.delta_qd[:, 3])
    moving = sorted(robot.independent_joints, key=lambda joint: -float(rates[joint.v].max()))
    fast = [joint for joint in moving if rates[joint.v] > 0.01 * rates.max()]
    first = fast[0].name if fast else "JOINT"
    where = _posture(landing)
    if fast:
        where += f" with {few([_value(joint, landing.q) for joint in fast], 4)}"
    constraint, axis = _direction(equation, int(np.argmax(np.abs(proof.impulse[:, 3]))))
    return SolveError(
        f'no verdict: body "{robot.bodies[body].name}" would move {times:.0e} times as fast as '
        f"the contact, because {where} is singular or nearly so ({constraint.name} has almost no "
        f"motion along ({axis}) there{digits}), or almost no inertia resists that motion. Set "
        f"another posture, such as with --set {first}=ANGLE, leave that direction out of the "
        "contact or of the contact velocity, or lock joints without inertia with --lock",
        constraints=[constraint.frame],
        bodies=[robot.bodies[body].name],
        joints=[joint.name for joint in fast],
    )


def _lengths(landing: PosedLanding) -> Array:
    """The lengths (nb,) by which rotations of bodies count as speeds [m].

    Each is the distance to the body's farthest point, and at least the radius of gyration.
    """
    length = landing.robot.gyration.copy()
    for point in landing.points:
        if point.body >= 0:
            arm = float(np.linalg.norm(point.r - landing.robot.coms[point.body]))
            length[point.body] = max(length[point.body], arm)
    return length


def _value(joint: Joint, q: Array) -> str:
    """A joint and its value in words."""
    value = joint.value(q)
    if joint.unit == "m":
        return f'"{joint.name}" at {value:.3g} m'
    return f'"{joint.name}" at {math.degrees(value):.3g} deg'
