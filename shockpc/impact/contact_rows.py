"""The rows along which contacts act with friction or on springs: of each contact, tangents of the
ground and its normal.
"""

from dataclasses import dataclass, fields

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.landed import independent_rows_of, rows_as_meant
from shockpc.landing.directions import across
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import NO_AXES, ConstraintBlock, slices_of
from shockpc.method.equation import Equation


@dataclass(frozen=True)
class RowLayout:
    """The n rows of contacts and standing feet, whatever the posture.

    They are along the tangents of the ground along which a contact is stopped, none to two, and
    along its normal.

    Attributes:
        blocks: which blocks of Eq. 4 have some.
        rigid: (nc,) which rows of the equation are held rigidly: of loops, the tilt of soles, and
            of feet that stay where they are.
        turn: (n, nc) the rows of contacts, of those of the equation.
        axes: (n, 3) along which they are, world axes.
        number: (n,) contact or standing foot of each row.
        place: (n,) tangent 0 or 1, or normal 2, of each row.
        restitution: (n,) e of each row: of a contact that sticks, with restitution along the
            normal, zero along the tangents.
    """

    blocks: list[int]
    rigid: np.ndarray
    turn: Array
    axes: Array
    number: np.ndarray
    place: np.ndarray
    restitution: Array

    @property
    def normal(self) -> np.ndarray:
        """Whether each row (n,) is along the normal of its contact."""
        return np.asarray(self.place == 2)

    @property
    def index(self) -> np.ndarray:
        """Which (n,) these are, where every contact has three rows: two tangents and the normal."""
        return np.asarray(3 * self.number + self.place)


@dataclass(frozen=True)
class ContactRows(RowLayout):
    """The rows in a posture, in coordinates with which what is held rigidly stays so.

    Attributes:
        equation: Eq. 4 of the landing.
        speeds: (n,) along each row before the impact, and after what is held rigidly has stopped
            [m/s].
        stop: (ny,) jump with which a sole that turns stops turning [rad/s, m/s].
        basis: (ny, m) the free velocities for unit coordinates.
        M: (m, m) inertia.
        J: (n, m) speeds along the rows.
    """

    equation: Equation
    speeds: Array
    stop: Array
    basis: Array
    M: Array
    J: Array

    def frequency(self, stiffness: Array, straight: Array) -> float:
        """The natural frequency ω [rad/s] of the mass m that sticking contacts stop: ω² = Σ k s² /
        Σ m s² of the speeds s.

        Args:
            stiffness: (n,) k of the rows [N/m].
            straight: (h, m) speeds for unit coordinates of what the contacts stop too, as of hinges
                in links that bend.
        """
        rows, speeds = (
            np.vstack([self.J, straight]),
            np.append(self.speeds, np.zeros(len(straight))),
        )
        impulse = np.linalg.lstsq(rows @ np.linalg.solve(self.M, rows.T), speeds, rcond=1e-10)[0]
        return float(np.sqrt((stiffness * self.speeds) @ self.speeds / (speeds @ impulse)))


def contact_rows(landing: PosedLanding, stands: bool = False) -> ContactRows:
    """The rows of contacts and standing feet; of a contact that slides along a direction, the
    others.

    An end stop that strikes has one row, like a normal; those that merely act are left out.

    Args:
        landing: in its posture.
        stands: whether standing feet stay where they are, as in Eq. 4, and have no rows.
    """
    landing = landing.without_stops
    equation, blocks = landing.equation(landing.state), landing.blocks
    layout = row_layout(blocks, stands)
    turn, rigid = layout.turn, layout.rigid
    basis, H = np.eye(equation.H.shape[1]), equation.H[0]
    stop, (J, b) = np.zeros(len(H)), rows_as_meant(landing)
    rigid_blocks = tuple(
        _without_rows(block) if i in layout.blocks else block for i, block in enumerate(blocks)
    )
    if rigid.any():
        chosen = np.flatnonzero(rigid)[
            independent_rows_of(landing, tuple(block for block in rigid_blocks if block.size))
        ]
        K, by_impulse = equation.J_c[0, chosen], np.linalg.solve(H, equation.J_c[0, chosen].T)
        stop = -by_impulse @ np.linalg.solve(K @ by_impulse, equation.b[0, chosen, 3])
        basis = np.linalg.qr(K.T, mode="complete")[0][:, len(K) :]
    speeds = turn @ b / (1.0 + layout.restitution) + turn @ J @ stop
    fixed = {field.name: getattr(layout, field.name) for field in fields(layout)}
    return ContactRows(
        **fixed,
        equation=equation,
        speeds=speeds,
        stop=stop,
        basis=basis,
        M=basis.T @ H @ basis,
        J=turn @ J @ basis,
    )


def row_layout(blocks: tuple[ConstraintBlock, ...], stands: bool = False) -> RowLayout:
    """The rows of contacts and standing feet. Args: as of `contact_rows`."""
    contact_indices = [
        k
        for k, block in enumerate(blocks)
        if block.kind in ("contact", "stop") or (block.kind == "stance" and not stands)
    ]
    sides = [_axes(blocks[k]) for k in contact_indices]
    axes, place = (np.concatenate(part) for part in zip(*sides, strict=True))
    number = np.repeat(np.arange(len(contact_indices)), [len(part) for part, _ in sides])
    e, every = (
        np.array(part)[number]
        for part in zip(
            *((blocks[k].restitution, blocks[k].rebound is None) for k in contact_indices),
            strict=True,
        )
    )
    size = sum(block.size for block in blocks)
    turn, rigid = np.zeros((len(number), size)), np.ones(size, dtype=bool)
    for k, (i, (along, _)) in enumerate(zip(contact_indices, sides, strict=True)):
        start, stop = slices_of(blocks)[i].start, blocks[i].kind == "stop"
        forces = slice(start, start + (1 if stop else len(blocks[i].forces)))
        turn[number == k, forces] = (
            1.0 if stop else np.linalg.lstsq(blocks[i].forces.T, along.T, rcond=None)[0].T
        )
        rigid[forces] = False
    return RowLayout(
        contact_indices, rigid, turn, axes, number, place, np.where((place == 2) | every, e, 0.0)
    )


def _without_rows(block: ConstraintBlock) -> ConstraintBlock:
    """A contact without the rows that are not held rigidly on springs or with friction: an end stop
    has no other.
    """
    return block._replace(
        forces=NO_AXES, moments=NO_AXES if block.kind == "stop" else block.moments
    )


def _axes(block: ConstraintBlock) -> tuple[Array, np.ndarray]:
    """The axes (n, 3) of a contact: tangents of the ground along which it is stopped, and the
    normal; and which (n,) they are.
    """
    if block.kind == "stop":
        return np.zeros((1, 3)), np.array([2])
    _, size, basis = np.linalg.svd(block.forces)
    rank = int(np.sum(size > 3.0 * np.finfo(float).eps * size[0]))
    if rank == 3:
        return np.array([*across(block.normal), block.normal]), np.arange(3)
    if rank == 1:
        return block.normal[None], np.array([2])
    return np.array([np.cross(np.cross(*basis[:2]), block.normal), block.normal]), np.array([0, 2])
