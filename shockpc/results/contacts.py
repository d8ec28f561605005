"""What the ground does at every contact and standing foot, and how the robot resists it."""

from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import choose_rows
from shockpc.core.percussion import dot, norm
from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import BallMatrix, Balls, PrecisionError, balls, matrix, nearest
from shockpc.exact.proof import Enclosure, Proof
from shockpc.exact.solution import ExactImpact
from shockpc.landing import Landing
from shockpc.model.rows import Block, Equation, block_axes, block_point
from shockpc.results.variants import held_joints_enclosure

__all__ = ["ContactImpulse", "StanceImpulse", "TotalImpulse", "contact_impulses", "pulled", "stance_impulses", "total_impulse"]

STRUCTURAL = 1e-26
"""Share of the largest mobility below which one is zero. Rounding of axes and places by 1e-16 makes 1e-32 of a zero."""

NARROW = 1e-4
"""Largest radius of a pivot, as a share of that below which it is zero."""

IMMOVABLE = 1e-7
"""Part of the normal along directions that cannot move with which a sticking contact cannot give way."""


class ContactImpulse(NamedTuple):
    """What the ground does at a contact.

    Attributes:
        frame: its name.
        point: (3,) where it strikes, world [m].
        impulse: (3,) of the ground on the robot, world axes [N s]; None where only the sum over several contacts is determined.
        moment: (3,) about that point, of a flat contact, world axes [N m s]; None for a point, or without an impulse.
        friction_needed: tangential over normal impulse, the least coefficient of friction that makes it stick [1]; None without an
            impulse, or where the ground would have to pull.
        approach: (3,) velocity of the contact point before the impact, world axes [m/s].
        mass_sticking: effective mass along the ground's normal if the contact sticks [kg]; inf if it cannot give way.
        mass_frictionless: the same if it slides [kg].
        mitigation: impact mitigation factor, 1 if the joints decouple the robot from the ground [1]; None unless the base is free
            and the joints can move the contact in every direction (0 without joints that can move it).
    """

    frame: str
    point: Array
    impulse: Array | None
    moment: Array | None
    friction_needed: float | None
    approach: Array
    mass_sticking: float
    mass_frictionless: float
    mitigation: float | None


class StanceImpulse(NamedTuple):
    """What the ground does at a foot that stands already.

    Attributes:
        frame: its name.
        point: (3,) where it stands, world [m].
        impulse: (3,) of the ground on the robot, world axes [N s]; None where only the sum over several feet is determined.
        friction_needed: tangential over normal impulse [1]; None without an impulse, or where the ground would have to pull.
    """

    frame: str
    point: Array
    impulse: Array | None
    friction_needed: float | None


class TotalImpulse(NamedTuple):
    """Impulse (3,) of the ground on the robot [N s], and its moment (3,) about the robot's centre of mass [N m s], world axes."""

    force: Array
    moment: Array


def contact_impulses(landing: Landing, proof: Proof, approach: Array, equation: Equation) -> tuple[ContactImpulse, ...]:
    """Impulse, needed friction and effective masses at every contact.

    Args:
        landing: the landing.
        proof: of its solution.
        approach: (n, 3) velocity of every contact point before the impact [m/s].
        equation: of the scene's posture.
    """
    blocks = proof.enclosure.inputs.blocks
    found = []
    for k, (contact, block) in enumerate(zip(landing.contacts, blocks, strict=False)):
        impulse, friction = _impulse(landing, proof, k)
        moment = None
        if impulse is not None and len(block.moments) and _unique(proof, k).all():
            n, own = len(block.forces), _slices(proof)[k]
            moment = proof.impulse[own.start + n : own.stop, 3] @ block.moments
        sticking, frictionless, mitigation = _resistance(landing, proof, block, equation)
        point = _point(landing, proof, block)
        found.append(
            ContactImpulse(contact.frame, point, impulse, moment, friction, approach[k], sticking, frictionless, mitigation)
        )
    return tuple(found)


def stance_impulses(landing: Landing, proof: Proof) -> tuple[StanceImpulse, ...]:
    """Impulse and needed friction at every foot that stands."""
    first = len(landing.contacts)
    return tuple(
        StanceImpulse(frame, _point(landing, proof, block), *_impulse(landing, proof, first + k))
        for k, (frame, block) in enumerate(zip(landing.scene.stance, landing.stance, strict=True))
    )


def total_impulse(landing: Landing, proof: Proof) -> TotalImpulse:
    """Impulse of all contacts and standing feet together; it is unique even where its parts are not."""
    count, robot = len(landing.contacts) + len(landing.stance), landing.robot
    reach = float(np.abs(landing.state.position[0]).max()) + float(np.abs(robot.coms).max())

    def read(impact: ExactImpact) -> tuple[Array, Array]:
        force, moment = balls(np.zeros(3)), balls(np.zeros(3))
        rows, size = impact.independent_impulse[:, 3], 0.0
        for block, own in zip(impact.inputs.blocks[:count], impact.slices[:count], strict=True):
            point = block_point(impact.state, block)[0]
            axes = block_axes(impact.state, block)[0]
            for j, axis in enumerate(axes):
                part = axis * rows[own.start + j]
                size += abs(float(rows[own.start + j]))
                if j < len(block.forces):
                    force, moment = force + part, moment + np.cross(point, part)
                else:
                    moment = moment + part
        mass = balls(robot.masses)
        centre = np.sum(impact.points(range(len(mass)), robot.coms) * mass[:, None], axis=0) / np.sum(mass)
        return nearest(force, size), nearest(moment - np.cross(centre, force), size * (reach or 1.0))

    return TotalImpulse(*proof.enclosure.read(read))


def pulled(landing: Landing, proof: Proof) -> tuple[Diagnostic, ...]:
    """A warning for every contact and foot whose normal impulse would have to pull."""
    warnings = []
    for k, block in enumerate(proof.enclosure.inputs.blocks[: len(landing.contacts) + len(landing.stance)]):
        own, n = _slices(proof)[k], len(block.forces)
        along = proof.impulse[own.start : own.start + n, 3]
        rising = np.abs(block.forces @ landing.up) > 1e-9
        if not _unique(proof, k)[:n][rising].all():
            continue
        normal = float(along[rising] @ (block.forces[rising] @ landing.up))
        if normal < -1e-12 * float(np.linalg.norm(along)):
            text = (
                f"{block.name} would have to be pulled down by {-normal:.3g} N s to keep to the ground; "
                "a real foot lifts off there, so leave it out"
            )
            warnings.append(Diagnostic("contact", block.name, normal, text))
    return tuple(warnings)


def _slices(proof: Proof) -> tuple[slice, ...]:
    """Where the rows of each block lie."""
    return proof.enclosure.read(lambda impact: impact.slices)


def _unique(proof: Proof, k: int) -> np.ndarray:
    """Which impulses of a block are determined."""
    return np.asarray(proof.enclosure.inputs.choice.unique[_slices(proof)[k]])


def _point(landing: Landing, proof: Proof, block: Block) -> Array:
    """Position (3,) of the point of a block in the world [m]."""
    origin = landing.state.origin[0]
    reach = float(np.abs(origin).max()) + float(np.abs(landing.state.position[0]).max()) + 1e-3

    def read(impact: ExactImpact) -> Array:
        place = block_point(impact.state, block)[0]
        return nearest(place + balls(origin), reach)

    return proof.enclosure.read(read)


def _impulse(landing: Landing, proof: Proof, k: int) -> tuple[Array | None, float | None]:
    """Impulse (3,) of a block's forces, and the friction that it needs; None where they are not determined."""
    block, own = proof.enclosure.inputs.blocks[k], _slices(proof)[k]
    n = len(block.forces)
    if not _unique(proof, k)[:n].all():
        return None, None
    size = float(np.abs(proof.impulse[:, 3]).max(initial=0.0))

    def read(impact: ExactImpact) -> tuple[Array, Array | None]:
        along = impact.impulse[own, 3][:n]
        impulse = np.sum(along[:, None] * balls(block.forces), axis=0)
        up = balls(landing.up)
        normal = dot(impulse, up)
        # A normal impulse that may be zero is none: of a ball around zero the midpoint has either sign.
        friction = nearest(norm(impulse - normal * up) / normal, 1.0) if nearest(normal, size) > 0.0 else None
        return nearest(impulse, size), friction

    impulse, friction = proof.enclosure.read(read)
    return impulse, None if friction is None else friction.item()


def _resistance(landing: Landing, proof: Proof, block: Block, equation: Equation) -> tuple[float, float, float | None]:
    """Effective masses along the ground's normal n, and the impact mitigation factor.

    With the Delassus matrix A of the contact point, while standing feet and loops hold but other contacts do not: 1 / (nᵀ A n) if
    it slides, nᵀ A⁻¹ n if it sticks, and det(1 − Λ Λ_L⁻¹), Λ = A⁻¹ and Λ_L with every joint locked (Wensing et al., T-RO 2017).
    """
    point = block._replace(forces=np.eye(3), moments=np.zeros((0, 3)))
    held, n = _held_rows(landing, proof, equation), landing.up

    def masses(impact: ExactImpact) -> tuple[Array, Array, bool]:
        A = impact.mobility(point, held)
        axes, along = _moving_axes(A), _form(A, n)
        if not float(along.item()) > STRUCTURAL * _largest(A):
            return np.array(np.inf), np.array(np.inf), False
        sticking = _sticking(A, n, axes)
        return (
            np.array(np.inf) if sticking is None else nearest(sticking, 0.0),
            nearest(1 / along, 0.0),
            len(axes) == len(n),
        )

    sticking, frictionless, movable = proof.enclosure.read(masses)
    mitigation = None
    if landing.floating and movable:
        locked = held_joints_enclosure(proof.enclosure, landing)
        mitigation = proof.enclosure.read(lambda impact: _mitigation(impact, locked, point, held))
    return sticking.item(), frictionless.item(), mitigation


def _held_rows(landing: Landing, proof: Proof, equation: Equation) -> list[int]:
    """Independent rows of standing feet and loops."""
    first = sum(block.size for block in proof.enclosure.inputs.blocks[: len(landing.contacts)])
    J_c = equation.J_c[0, first:]
    if not len(J_c):
        return []
    size = np.sqrt(np.abs(np.diagonal(equation.H[0])))
    choice = choose_rows(J_c, equation.terms(0)[first:], size, np.ones(len(J_c)))
    return [int(row) + first for row in choice.rows]


def _largest(A: BallMatrix) -> float:
    """The largest diagonal entry of A."""
    return max(float(row[i]) for i, row in enumerate(A.table()))


def _moving_axes(A: BallMatrix, whole: float = 0.0) -> list[int]:
    """The world axes along which a point can move independently, by elimination of its mobility with the largest pivot first.

    Args:
        A: (3, 3) mobility [1/kg].
        whole: a mobility of which A is a part [1/kg].

    Raises:
        PrecisionError: a pivot is too wide to tell.
    """
    S, n = A.table(), A.nrows()
    least = STRUCTURAL * max(_largest(A), STRUCTURAL * whole)
    chosen: list[int] = []
    left = list(range(n))
    while left:
        k = max(left, key=lambda i: float(S[i][i]))
        pivot = S[k][k]
        if not float(pivot.rad()) <= NARROW * least:
            raise PrecisionError
        if not float(pivot) > least:
            break
        chosen.append(k)
        left.remove(k)
        for i in left:
            share = S[i][k] / pivot
            for j in left:
                S[i][j] -= share * S[k][j]
    return sorted(chosen)


def _form(A: BallMatrix, n: Array) -> Balls:
    """nᵀ A n."""
    column = matrix(n[:, None])
    return np.array((column.transpose() * A * column)[0, 0], dtype=object)


def _sticking(A: BallMatrix, n: Array, axes: list[int]) -> Balls | None:
    """nᵀ A⁻¹ n for a point whose mobility follows from that along some axes; None if it cannot move along n."""
    V, column = matrix(np.eye(3)[:, axes]), matrix(n[:, None])
    along = V.transpose() * column
    impulse = (V.transpose() * A * V).solve(along)
    if max(abs(float(x)) for x in (column - A * V * impulse).entries()) > IMMOVABLE:
        return None
    return np.array((along.transpose() * impulse)[0, 0], dtype=object)


def _mitigation(impact: ExactImpact, locked: Enclosure, point: Block, held: list[int]) -> float | None:
    """det(A − A_L) / det(A); None if the joints can move the point, but not in every direction."""
    A = impact.mobility(point, held)
    by_joints = A - locked.read(lambda other: other.mobility(point, []), impact.bits)
    # Across the plane of a planar mechanism the joints can do nothing, and the factor is zero whatever they are.
    if 0 < len(_moving_axes(by_joints, _largest(A))) < A.nrows():
        return None
    return nearest(np.array(by_joints.det() / A.det(), dtype=object), 1.0).item()
