"""What the ground does at every contact and standing foot, and how the robot resists it."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shockpc.core.impulse import choose_rows
from shockpc.core.percussion import dot, norm
from shockpc.core.spatial import Array
from shockpc.diagnostic import Diagnostic
from shockpc.exact.balls import BallMatrix, PrecisionError, balls, entries, matrix, nearest
from shockpc.exact.solution import ExactImpact
from shockpc.model.rows import NO_AXES, Block, slices_of
from shockpc.results.solved import Solved, world

__all__ = ["ContactImpulse", "StanceImpulse", "contact_impulses", "pulled", "stance_impulses"]

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
    """What the ground does at a foot that stands already; the attributes are as in `ContactImpulse`."""

    frame: str
    point: Array
    impulse: Array | None
    friction_needed: float | None


def contact_impulses(of: Solved) -> tuple[ContactImpulse, ...]:
    """Impulses, friction and effective masses of the contacts."""
    found = []
    for k, contact in enumerate(of.landing.contacts):
        block, own, unique = _block(of, k)
        point, impulse, friction = _impulse(of, k)
        moment = of.proof.impulse[own, 3][len(block.forces) :] @ block.moments if len(block.moments) and unique.all() else None
        found.append(ContactImpulse(contact.frame, point, impulse, moment, friction, of.approach[k], *_resistance(of, k)))
    return tuple(found)


def stance_impulses(of: Solved) -> tuple[StanceImpulse, ...]:
    """Impulses of the standing feet."""
    first = len(of.landing.contacts)
    return tuple(StanceImpulse(frame, *_impulse(of, first + k)) for k, frame in enumerate(of.landing.scene.stance))


def pulled(of: Solved) -> Iterator[Diagnostic]:
    """A warning for every contact and foot whose normal impulse would have to pull."""
    up = of.landing.up
    for k in range(len(of.landing.contacts) + len(of.landing.stance)):
        block, own, unique = _block(of, k)
        along, rising = of.proof.impulse[own, 3][: len(block.forces)], block.forces @ up
        steep = np.abs(rising) > 1e-9
        normal = float(along[steep] @ rising[steep])
        if unique[: len(along)][steep].all() and normal < -1e-12 * float(np.linalg.norm(along)):
            text = (
                f"{block.name} would have to be pulled down by {-normal:.3g} N s to keep to the ground; "
                "a real foot lifts off there, so leave it out"
            )
            yield Diagnostic("contact", block.name, normal, text)


def _block(of: Solved, k: int) -> tuple[Block, slice, np.ndarray]:
    """A contact or standing foot, where its rows are, and which of its impulses are determined."""
    blocks = of.proof.enclosure.inputs.blocks
    own = slices_of(blocks)[k]
    return blocks[k], own, of.choice.unique[own]


def _impulse(of: Solved, k: int) -> tuple[Array, Array | None, float | None]:
    """Point (3,), impulse (3,) and needed friction of a contact or standing foot; None where they are not determined."""
    block, own, unique = _block(of, k)
    n, up, size = len(block.forces), balls(of.landing.up), float(np.abs(of.proof.impulse[:, 3]).max(initial=0.0))

    def read(impact: ExactImpact) -> tuple[Array, Array | None, float | None]:
        (point,) = world(impact, of.landing, [block.body], np.reshape(block.point, (1, 3)))
        if not unique[:n].all():
            return point, None, None
        impulse = impact.impulse[own, 3][:n] @ balls(block.forces)
        normal = dot(impulse, up)
        # A normal impulse that may be zero is none: of a ball around zero the midpoint has either sign.
        pressed = nearest(normal, size) > 0.0
        return point, nearest(impulse, size), nearest(norm(impulse - normal * up) / normal, 1.0).item() if pressed else None

    return of.read(read)


def _resistance(of: Solved, k: int) -> tuple[float, float, float | None]:
    """Effective masses along the ground's normal n, and the impact mitigation factor.

    With the Delassus matrix A of the contact point, while standing feet and loops hold but other contacts do not: 1 / (nᵀ A n) if
    it slides, nᵀ A⁻¹ n if it sticks, and det(1 − Λ Λ_L⁻¹), Λ = A⁻¹ and Λ_L with every joint locked (Wensing et al., T-RO 2017).
    """
    point = _block(of, k)[0]._replace(forces=np.eye(3), moments=NO_AXES)
    held, n = _held_rows(of), of.landing.up

    def read(impact: ExactImpact) -> tuple[float, float, float | None]:
        A = impact.mobility(point, held)
        along = balls(n) @ entries(A) @ balls(n)
        if not float(along) > STRUCTURAL * _largest(A):
            return np.inf, np.inf, None
        axes, factor = _moving_axes(A), None
        if of.landing.floating and len(axes) == len(n):
            by_joints = A - impact.rigid_mobility(point)
            # Across the plane of a planar mechanism the joints can do nothing, and the factor is zero whatever they are.
            if len(_moving_axes(by_joints, _largest(A))) in (0, len(n)):
                factor = nearest(by_joints.det() / A.det(), 1.0).item()
        return _sticking(A, n, axes), nearest(1 / along, 0.0).item(), factor

    return of.read(read)


def _held_rows(of: Solved) -> list[int]:
    """Independent rows of standing feet and loops."""
    first = sum(block.size for block in of.equation.blocks[: len(of.landing.contacts)])
    J_c = of.equation.J_c[0, first:]
    if not len(J_c):
        return []
    size = np.sqrt(np.abs(np.diagonal(of.equation.H[0])))
    rows = choose_rows(J_c, of.equation.terms(0)[first:], size, np.ones(len(J_c))).rows
    return [int(row) + first for row in rows]


def _largest(A: BallMatrix) -> float:
    """The largest diagonal entry of A."""
    return max(float(row[i]) for i, row in enumerate(A.table()))


def _moving_axes(A: BallMatrix, whole: float = 0.0) -> list[int]:
    """The world axes along which a point of mobility A, part of a whole, moves independently: elimination, largest pivot first."""
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


def _sticking(A: BallMatrix, n: Array, axes: list[int]) -> float:
    """nᵀ A⁻¹ n of a point whose mobility follows from that along some axes; inf if it cannot move along n."""
    V, column = matrix(np.eye(3)[:, axes]), matrix(n[:, None])
    along = V.transpose() * column
    impulse = (V.transpose() * A * V).solve(along)
    if max(abs(float(x)) for x in (column - A * V * impulse).entries()) > IMMOVABLE:
        return np.inf
    return nearest((along.transpose() * impulse)[0, 0], 0.0).item()
