"""What the ground does at every contact and standing foot, and how the robot resists it."""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from shockpc.core.percussion import dot, norm
from shockpc.core.spatial import Array, cross
from shockpc.impact.exact_impact import BallImpact
from shockpc.impact.impact import DoubleImpact, Impact
from shockpc.impact.landed import independent_rows_of
from shockpc.landing.closure import closure_block
from shockpc.method.constraints import (
    NO_AXES,
    ConstraintBlock,
    block_axes,
    block_point,
    slices_of,
    world_point,
)
from shockpc.method.exact.arithmetic import entries
from shockpc.method.exact.balls import BALLS, BallMatrix, Balls, PrecisionError
from shockpc.quantities.quantity import (
    IN_DOUBLES_WHERE_CLEAR,
    Places,
    Quantity,
    Relations,
    Scope,
    cached,
    reach,
)

STRUCTURAL = 1e-26
"""Share of the largest mobility below which one is zero.

Rounding of axes and places by 1e-16 makes 1e-32 of a zero.
"""

CLEAR = 1e-6
"""Share of the mobility from which double precision tells it from zero, with nine digits left."""

NARROW = 1e-4
"""Largest radius of a pivot, as a share of that below which it is zero."""

IMMOVABLE = 1e-7
"""Part of the normal along directions that cannot move with which a sticking contact cannot give
way.
"""

LEFT_OUT = 10.0
"""The same where a direction is left out, relative to what rounding of the file makes of it."""

STANDS = "a standing foot has no contact velocity"
TILTS = {"edge": 1, "flat": 2}
"""How many rotations about axes along the ground each kind of contact holds: the first of its
moments.
"""

HOLD_TWIST = ("corner", "edge", "flat")
"""Kinds of contact that hold the rotation about the normal if they stick."""

REDUNDANT = "contacts are redundant, so the impulse of a single one is not determined"
PULLED = f"{REDUNDANT}; or the contact receives no impulse, or the ground would have to pull it"
MITIGATION = (
    "it requires a free base, no stance, no loop that ties the robot to the world, and no end stop"
)


def _rows(impact: Impact, places: Places) -> list[tuple[ConstraintBlock, slice]]:
    """The block of each contact, and where its rows are."""
    slices = slices_of(impact.blocks)
    return [(impact.blocks[place.number], slices[place.number]) for place in places]


def _force(impact: Impact, block: ConstraintBlock, rows: slice) -> Any:
    """Impulse (N, S, 3) of a contact [N s], determined or not."""
    n = len(block.forces)
    axes = (
        block_axes(impact.state, block)[:, None, :n]
        if block.kind == "stop"
        else impact.exact(block.forces)
    )
    impulse = impact.along(impact.impulse)[..., rows][..., :n]
    # A hinge's stop has no force, whose sum is no ball.
    return (
        (impulse[..., None, :] @ axes)[..., 0, :] + impact.exact(np.zeros(3))
        if block.kind == "stop"
        else impulse @ axes
    )


def _determined(impact: Impact, places: Places) -> np.ndarray:
    """Whether the impulse of each contact (N, 1, n) is determined."""
    return np.stack(
        [
            impact.unique[:, None, rows][..., : len(b.forces)].all(axis=-1)
            for b, rows in _rows(impact, places)
        ],
        axis=-1,
    )


def _moment_determined(impact: Impact, places: Places) -> np.ndarray:
    """Whether force and moment of each contact (N, 1, n) are determined."""
    return np.stack(
        [impact.unique[:, None, rows].all(axis=-1) for _, rows in _rows(impact, places)], axis=-1
    )


def _point(impact: Impact, places: Places) -> Any:
    """Where the contacts strike (N, 1, n, 3), world [m]."""
    origin = impact.exact(impact.state.origin)
    return np.stack(
        [block_point(impact.state, block) + origin for block, _ in _rows(impact, places)], axis=1
    )[:, None]


def _impulse(impact: Impact, places: Places) -> Any:
    forces = np.stack(
        [_force(impact, block, rows) for block, rows in _rows(impact, places)], axis=-2
    )
    return np.where(_determined(impact, places)[..., None], forces, np.nan)


def _moment(impact: Impact, places: Places) -> Any:
    """Moment (N, S, n, 3) about the contact points [N m s]; NaN of a point."""
    moments, impulse = [], impact.along(impact.impulse)
    for block, rows in _rows(impact, places):
        n = len(block.forces)
        axes = (
            block_axes(impact.state, block)[:, None, n:]
            if block.kind == "stop"
            else impact.exact(block.moments)
        )
        moment = (impulse[..., rows][..., None, n:] @ axes)[..., 0, :]
        known = len(block.moments) and impact.unique[:, None, rows].all(axis=-1, keepdims=True)
        moments.append(np.where(known, moment, np.nan))
    return np.stack(moments, axis=-2)


def friction_needed(impact: Impact, places: Places) -> Any:
    """Tangential over normal impulse (N, S, n) [1]; NaN where the ground would have to pull."""
    impulse = np.stack(
        [_force(impact, block, rows) for block, rows in _rows(impact, places)], axis=-2
    )
    normal, up, pressed = _normal_impulse(impact, places)
    return np.where(
        pressed, norm(impulse - normal[..., None] * up) / np.where(pressed, normal, 1), np.nan
    )


def _normal_impulse(impact: Impact, places: Places) -> tuple[Any, Any, np.ndarray]:
    """Impulses (N, S, n) of contacts along their normals, these (n, 3), and whether the ground
    pushes (N, S, n).
    """
    impulse = np.stack(
        [_force(impact, block, rows) for block, rows in _rows(impact, places)], axis=-2
    )
    up = impact.exact(np.array([block.normal for block, _ in _rows(impact, places)]))
    normal = dot(impulse, up)
    # A normal impulse that may be zero is none: of a ball around zero the midpoint has either sign.
    pressed = (
        impact.rounded(normal, lambda values: _impulse_size(impact, values)) > 0.0
    ) & _determined(impact, places)
    return normal, up, pressed


def _centre_of_pressure(impact: Impact, places: Places) -> Any:
    """Where the normal impulse of each contact acts (N, S, n, 3), world [m]: r = p + n × M / (n ·
    ι) of the contact point p.
    """
    normal, up, pressed = _normal_impulse(impact, places)
    pressed = pressed & _moment_determined(impact, places)
    points = np.broadcast_to(_point(impact, places), (*pressed.shape, 3))
    # A point, and a corner that slides, have no moment.
    has_moment = np.array([len(block.moments) > 0 for block, _ in _rows(impact, places)])
    moment = np.where(
        (pressed & has_moment)[..., None], _moment(impact, places), impact.exact(np.zeros(3))
    )
    aside = (
        cross(np.broadcast_to(up, moment.shape), moment) / np.where(pressed, normal, 1)[..., None]
    )
    return np.where(pressed[..., None], points + aside, np.nan)


def _twist_needed(impact: Impact, places: Places) -> Any:
    """Friction (N, S, n) that the twist of each contact needs: |n · M| / (n · ι · d) [1]; NaN of a
    point.

    d is the mean distance of the corners of the sole from the centre of pressure, as if each
    carried the same.
    """
    normal, up, pressed = _normal_impulse(impact, places)
    pressed = pressed & _moment_determined(impact, places)
    twist = np.abs(dot(_moment(impact, places), up))
    centres = _centre_of_pressure(impact, places) - impact.exact(impact.state.origin)[:, None, None]
    needed = []
    for k, (block, _) in enumerate(_rows(impact, places)):
        if not len(block.sole) or not len(block.moments):
            needed.append(np.full(pressed.shape[:-1], np.nan))
            continue
        corners = [world_point(impact.state, block.body, corner) for corner in block.sole]
        distances = [norm(centres[:, :, k] - corner[:, None]) for corner in corners]
        arm = np.sum(distances, axis=0) / len(corners)
        known = pressed[..., k]
        needed.append(
            np.where(known, twist[..., k] / np.where(known, normal[..., k] * arm, 1), np.nan)
        )
    return np.stack(needed, axis=-1)


@cached
def pull(impact: Impact, places: Places) -> Any:
    """By how much (N, S, n) the ground would have to pull [N s]; 0 where it pushes, NaN where the
    impulse is not determined.
    """
    pulls, impulse = [], impact.along(impact.impulse)
    for block, rows in _rows(impact, places):
        if block.kind == "stop":
            push = impulse[..., rows.start].astype(float)
            pulls.append(
                np.where(impact.unique[:, None, rows.start], np.maximum(-push, 0.0), np.nan)
            )
            continue
        rising = block.forces @ block.normal
        steep = np.flatnonzero(np.abs(rising) > 1e-9)
        along = impulse[..., rows][..., : len(rising)].astype(float)
        normal, size = along[..., steep] @ rising[steep], np.linalg.norm(along, axis=-1)
        known = impact.unique[:, None, rows][..., steep].all(axis=-1)
        pulls.append(np.where(known, np.where(normal < -1e-12 * size, -normal, 0.0), np.nan))
    return np.stack(pulls, axis=-1)


def _approach(impact: Impact, places: Places) -> Any:
    """Velocity (N, S, n, 3) of the contact points before the impact; NaN of a standing foot."""
    none = np.full((*impact.approach.shape[:2], 3), np.nan)
    first = len(impact.contacts)
    return np.stack(
        [impact.approach[:, :, p.number] if p.number < first else none for p in places], axis=-2
    )


def _impulse_size(impact: Impact, values: Array) -> float:
    """The largest impulse along a row [N s, N m s]."""
    del values
    return float(np.abs(impact.along(impact.impulse).astype(float)).max(initial=0.0))


def _resistance(part: str) -> Callable[[Impact, Places], Balls]:
    """The formula for effective masses, or mitigation factors (N, 1, n), of contacts; NaN of a
    standing foot.
    """

    def compute(impact: Impact, places: Places) -> Any:
        if isinstance(impact, DoubleImpact):
            return np.stack(
                [_clear_resistance(impact, place.number)[part] for place in places], axis=-1
            )[:, None]
        assert isinstance(impact, BallImpact)
        for k in range(len(impact.contacts)):
            impact.resistances.setdefault(k, _Resistance(impact, k))
        values = [
            getattr(impact.resistances[p.number], part)
            if p.number in impact.resistances
            else np.nan
            for p in places
        ]
        return np.array(values, dtype=object)[None, None]

    return compute


def _fastest(impact: Impact, values: Array) -> float:
    """The largest component of the motion before the impact [m/s, rad/s]."""
    del values
    return float(np.abs(np.concatenate(impact.landing.before)).max())


class _Resistance:
    """The effective masses and mitigation factors of one contact, while standing feet and loops
    hold but other contacts do not.

    A is the Delassus matrix of the contact point, while the rotations are held that its kind holds:
    all of a flat contact, those across an edge, the twist of a corner if it sticks. The effective
    mass along the ground's normal n is 1 / (nᵀ A n) if the contact slides, and nᵀ A⁻¹ n if it
    sticks. The impact mitigation factor is the share of the mobility that is due to joints: det(1 −
    Λ Λ_L⁻¹) with Λ = A⁻¹, and Λ_L with every joint locked (Wensing et al., T-RO 2017), in the
    directions in which joints can move the point; if the contact slides, that along n alone, 1 − nᵀ
    A_L n / nᵀ A n.
    """

    def __init__(self, impact: BallImpact, contact: int) -> None:
        block = self.block = impact.blocks[contact]
        self.impact, self.n, self.contact = (
            impact,
            block.normal,
            impact.landing.scene.contact[contact],
        )
        self.point = block._replace(forces=np.eye(3), moments=NO_AXES)

    def _held_rotations(self, sticks: bool) -> Array:
        """The axes (m, 3) about which the contact is held.

        Args: sticks, whether it does, and so holds the twist too.
        """
        tilts = self.block.moments[: TILTS.get(self.contact.kind, 0)]
        twist = self.n[None] if sticks and self.contact.kind in HOLD_TWIST else NO_AXES
        return np.concatenate([tilts, twist])

    def _mobility(self, moments: Array) -> BallMatrix:
        """A while standing feet, loops and the contact's rotation about some axes are held."""
        blocks = self._constraints(moments)
        A: BallMatrix = self.impact.delassus(
            self.point, blocks, independent_rows_of(self.impact.landing, blocks)
        )
        return A

    def _constraints(self, moments: Array) -> tuple[ConstraintBlock, ...]:
        """Standing feet, loops, and the contact's rotation about some axes."""
        landing = self.impact.landing
        blocks: tuple[ConstraintBlock, ...] = (
            *landing.stance,
            *(closure_block(loop) for loop in landing.loops),
        )
        return (
            (*blocks, self.point._replace(forces=NO_AXES, moments=moments))
            if len(moments)
            else blocks
        )

    @functools.cached_property
    def point_mobility(self) -> BallMatrix:
        """A of the contact point, whose link is free to turn."""
        return self._mobility(NO_AXES)

    def _along_normal(self, A: BallMatrix) -> Any:
        """nᵀ A n."""
        return BALLS.numbers(self.n) @ entries(A) @ BALLS.numbers(self.n)

    def _gives_way(self, A: BallMatrix) -> bool:
        """Whether a point of mobility A can move along the normal at all."""
        return bool(float(self._along_normal(A)) > STRUCTURAL * _largest(A))

    def _stop(self) -> Any:
        """What resists at an end stop: the inertia about its joint, or the mass along it [kg m²,
        kg].
        """
        blocks = self._constraints(NO_AXES)
        A = self.impact.delassus(
            self.block, blocks, independent_rows_of(self.impact.landing, blocks)
        )
        return 1 / entries(A)[0, 0]

    @functools.cached_property
    def frictionless(self) -> Any:
        """Effective mass if the contact slides [kg]; inf if it cannot give way.

        Of an end stop see `_stop`.
        """
        if self.block.kind == "stop":
            return self._stop()
        moments = self._held_rotations(sticks=False)
        A = self._mobility(moments) if len(moments) else self.point_mobility
        return 1 / self._along_normal(A) if self._gives_way(A) else np.inf

    @functools.cached_property
    def sticking(self) -> Any:
        """Effective mass if the contact sticks [kg]; inf if it cannot give way.

        Of an end stop see `_stop`.
        """
        if self.block.kind == "stop":
            return self._stop()
        moments = self._held_rotations(sticks=True)
        A = self._mobility(moments) if len(moments) else self.point_mobility
        if not self._gives_way(A):
            return np.inf
        # Solved in the axes along which the point can move; it is held where the normal has a part
        # in none of them.
        axes, landing, blocks = _moving_axes(A), self.impact.landing, self._constraints(moments)
        # Along what is left out, the point moves only by what rounding of the file leaves.
        most, rounded = 3, 0.0
        if not landing.floating:
            most, rounded = landing.most_independent(landing.state, (*blocks, self.point))(0)
            most -= landing.most_independent(landing.state, blocks)(0)[0]
        immovable = IMMOVABLE if most == 3 else max(IMMOVABLE, LEFT_OUT * rounded)
        V, column = BALLS.matrix(np.eye(3)[:, sorted(axes[:most])]), BALLS.matrix(self.n[:, None])
        part = V.transpose() * column
        impulse = (V.transpose() * A * V).solve(part)
        if max(abs(float(x)) for x in (column - A * V * impulse).entries()) > immovable:
            return np.inf
        return (part.transpose() * impulse)[0, 0]

    @functools.cached_property
    def mobility_by_joints(self) -> BallMatrix:
        """A − A_L: what the joints add to the mobility of the contact point."""
        locked: BallMatrix = self.impact.rigid_mobility(self.point)
        return self.point_mobility - locked

    @functools.cached_property
    def mitigation_frictionless(self) -> Any:
        """Impact mitigation factor of the contact point if it slides [1]; NaN where it has no
        meaning.
        """
        if not self.impact.landing.floating or self.block.kind == "stop":
            return np.nan
        by_joints = self._along_normal(self.mobility_by_joints)
        if not float(by_joints) > STRUCTURAL * _largest(self.point_mobility):
            return 0.0
        return by_joints / self._along_normal(self.point_mobility)

    @functools.cached_property
    def mitigation(self) -> Any:
        """Impact mitigation factor of the contact point if it sticks [1]; NaN where it has no
        meaning.
        """
        if not self.impact.landing.floating or self.block.kind == "stop":
            return np.nan
        A, by_joints = self.point_mobility, self.mobility_by_joints
        axes = sorted(_moving_axes(A))
        A, by_joints = _part(A, axes, axes), _part(by_joints, axes, axes)
        moved = sorted(_moving_axes(by_joints, _largest(A)))
        if not moved:
            return 0.0
        # The determinant of A⁻¹ (A − A_L) over its range: a plane or a line where the joints move
        # the point in that alone.
        columns = _part(by_joints, list(range(len(axes))), moved)
        return (columns.transpose() * A.solve(columns)).det() / _part(by_joints, moved, moved).det()

    @property
    def effective(self) -> Any:
        """Effective mass of the contact as it is: sticking or sliding [kg]."""
        return self.sticking if self.contact.sticks else self.frictionless


def _clear_resistance(impact: DoubleImpact, contact: int) -> dict[str, Array]:
    """The numbers (N,) of `_Resistance` by name, where robot and joints clearly move the point in
    every direction; else NaN.
    """
    landing, block = impact.landing, impact.blocks[contact]
    names = ("frictionless", "sticking", "effective", "mitigation_frictionless", "mitigation")
    if (
        not landing.floating
        or landing.loops
        or len(block.moments)
        or block.kind == "stop"
        or contact >= len(landing.contacts)
    ):
        return dict.fromkeys(names, np.full(len(impact.state.J), np.nan))
    point, n = block._replace(forces=np.eye(3), moments=NO_AXES), block.normal
    A = impact.delassus(point)
    by_joints = A - impact.rigid_mobility(point)
    least, whole = (
        (np.linalg.eigvalsh(part)[:, 0] for part in (A, by_joints)),
        np.trace(A, axis1=1, axis2=2),
    )
    robot_moves, joints_move = (part > CLEAR * whole for part in least)
    with np.errstate(all="ignore"):
        frictionless, sticking = (
            1.0 / (n @ A @ n),
            np.linalg.inv(np.where(robot_moves[:, None, None], A, np.eye(3))) @ n @ n,
        )
        numbers = {
            "frictionless": np.where(robot_moves, frictionless, np.nan),
            "sticking": np.where(robot_moves, sticking, np.nan),
            "mitigation_frictionless": np.where(
                joints_move, (n @ by_joints @ n) * frictionless, np.nan
            ),
            "mitigation": np.where(
                joints_move, np.linalg.det(by_joints) / np.linalg.det(A), np.nan
            ),
        }
    sticks = landing.scene.contact[contact].sticks
    return numbers | {"effective": numbers["sticking" if sticks else "frictionless"]}


def _largest(A: BallMatrix) -> float:
    return max(float(row[i]) for i, row in enumerate(A.table()))


def _part(A: BallMatrix, rows: list[int], columns: list[int]) -> BallMatrix:
    part: BallMatrix = BALLS.matrix(entries(A)[np.ix_(rows, columns)])
    return part


def _moving_axes(A: BallMatrix, whole: float = 0.0) -> list[int]:
    """World axes along which a point of mobility A, part of a whole, moves independently:
    elimination, largest pivot first.
    """
    S, n = A.table(), A.nrows()
    least = STRUCTURAL * max(_largest(A), whole)
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
    return chosen


IMPULSE = Quantity(
    "impulse",
    "contact",
    "impulse of the ground on the robot, world axes",
    "N s",
    "greater",
    _impulse,
    _impulse_size,
    form="vector",
    scope=Scope(REDUNDANT),
    relations=Relations(also=("friction",), linear=True),
)

CONTACTS = (
    Quantity(
        "point", "contact", "contact point, world", "m", "neither", _point, reach, form="vector"
    ),
    IMPULSE,
    Quantity(
        "friction_needed",
        "contact",
        "friction to stick",
        "1",
        "greater",
        friction_needed,
        lambda i, x: 1.0,
        scope=Scope(PULLED),
    ),
    Quantity(
        "approach",
        "contact",
        "velocity before the impact, world axes",
        "m/s",
        "neither",
        _approach,
        _fastest,
        form="vector",
        scope=Scope(STANDS, strikes=True),
    ),
    Quantity(
        "effective_mass_sticking",
        "contact",
        "effective mass if it sticks",
        "kg",
        "greater",
        _resistance("sticking"),
        scope=Scope(STANDS, strikes=True),
        evaluation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "effective_mass_frictionless",
        "contact",
        "effective mass if it slides",
        "kg",
        "greater",
        _resistance("frictionless"),
        scope=Scope(STANDS, strikes=True),
        evaluation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "mitigation",
        "contact",
        "impact mitigation factor if it sticks",
        "1",
        "less",
        _resistance("mitigation"),
        lambda i, x: 1.0,
        scope=Scope(MITIGATION),
        evaluation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "mitigation_frictionless",
        "contact",
        "impact mitigation factor if it slides",
        "1",
        "less",
        _resistance("mitigation_frictionless"),
        lambda i, x: 1.0,
        scope=Scope(MITIGATION),
        evaluation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "moment",
        "contact",
        "moment about the contact point, world axes",
        "N m s",
        "greater",
        _moment,
        _impulse_size,
        form="vector",
        scope=Scope(f"{REDUNDANT}; or it is a point"),
    ),
    Quantity(
        "effective_mass",
        "contact",
        "effective mass",
        "kg",
        "greater",
        _resistance("effective"),
        scope=Scope(STANDS, strikes=True),
        evaluation=IN_DOUBLES_WHERE_CLEAR,
    ),
    Quantity(
        "centre_of_pressure",
        "contact",
        "centre of pressure, world",
        "m",
        "neither",
        _centre_of_pressure,
        reach,
        form="vector",
        scope=Scope(PULLED),
    ),
    Quantity(
        "twist_needed",
        "contact",
        "friction against twist",
        "1",
        "greater",
        _twist_needed,
        lambda i, x: 1.0,
        scope=Scope(f"{PULLED}; or it is a point, or a sole that is not known"),
    ),
    Quantity(
        "tensile_impulse",
        "contact",
        "impulse with which the ground would have to pull",
        "N s",
        "greater",
        pull,
        scope=Scope(REDUNDANT),
        relations=Relations(role="pull"),
    ),
)
