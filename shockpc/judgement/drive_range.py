"""The range of a number over the drives: its smallest and largest value for all inertias that what is known of the joints allows.

Of what is linear in the jumps and impulses, or a length of that, both follow from the one solution that is there, by the law of
`core.drive_box`: the largest value over drives that are independent of one another is at a corner of their intervals, which a climb
finds; the smallest is sought. Effective masses, and the energy lost, only grow with inertia, so that theirs are at the smallest and
at the largest inertias. All others are computed anew at some corners, and so are all numbers where end stops act, friction, or
contacts of finite stiffness: the range is then that of samples.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.drive_box import DriveBox
from shockpc.core.impulse import Solution
from shockpc.core.inertia import solve_inertia
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.exact.arithmetic import SingularError
from shockpc.impact.friction import jumps_of
from shockpc.impact.impact import ColumnImpact, DoubleImpact
from shockpc.impact.solve import solve_exactly, solve_in_doubles
from shockpc.impact.stops import with_stops
from shockpc.landing.dynamics import dynamics, geared_bodies
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, joint_places
from shockpc.quantities.quantity import Quantity, evaluate
from shockpc.quantities.selection import Selection, quantity
from shockpc.quantities.shock_profile import ShockProfile, mass_of_contacts
from shockpc.text.errors import SceneError, SolveError
from shockpc.text.printed import few, printable

Kind = Literal["corners", "exact", "samples"]

NEARLY = 0.05
"""Share of the way to an end of a range that joints which do not decide account for, together; and of the range, of an end."""


class Range(NamedTuple):
    """The smallest and the largest value of a number over the drives.

    Attributes:
        smallest: in the unit of the number.
        largest: likewise.
        kind: "corners": the largest is at a corner of the intervals, as far as a climb found it, and the smallest is sought; of a
            component, both are at corners. "exact": both are those of the smallest and the largest inertias. "samples": those of
            some corners.
    """

    smallest: float
    largest: float
    kind: Kind

    def meets(self, least: float | None, most: float | None) -> bool | None:
        """Whether limits are met whatever the drives, or not met by any; None where the drives decide.

        Args:
            least: smallest value allowed; None for any.
            most: largest value allowed; None for any.
        """
        least, most = -np.inf if least is None else least, np.inf if most is None else most
        if least <= self.smallest and self.largest <= most:
            return True
        return False if self.smallest > most or self.largest < least else None


def drives_advice(joints: Sequence[str]) -> str:
    """What to give where the drives of some joints, as `deciding_joints` has them, decide."""
    return (
        f"the drives of {few([printable(name) for name in joints], 4)} decide: give them more closely with --drives, --rotor or "
        "--armature (in files joints.drives, joints.rotor and joints.armature), or state that there are none: "
        'joints.model = "free" (--joints free)'
    )


class _Linear(NamedTuple):
    """What a number follows from that is linear in jumps and impulses.

    Attributes:
        quantity: the linear one.
        place: where.
        axis: of the component that the number grows with; None for the length.
        signed: whether the number is that component with its sign, else the magnitude.
    """

    quantity: Quantity
    place: Place
    axis: int | None = None
    signed: bool = False


class _Response(NamedTuple):
    """How a landing responds to the drives, with the contacts held.

    Attributes:
        box: the drives that are not known exactly.
        columns: (n,) their joint velocities.
        solution: of Eq. 4 as modelled, then of unit impulses on each of these joints.
        jumps: (1, nb, 6, 1 + n) of the bodies, likewise, body axes.
    """

    box: DriveBox
    columns: np.ndarray
    solution: Solution
    jumps: Array

    def impacts(self, landing: PosedLanding, weights: Array) -> ColumnImpact:
        """Impacts, one a column, for weights (1 + n, k) of these solutions."""
        equation, solution = landing.equation(landing.state), self.solution
        combined = solution._replace(
            delta_qd=solution.delta_qd @ weights,
            impulse=solution.impulse @ weights,
            independent={k: part @ weights for k, part in solution.independent.items()},
        )
        b = np.repeat(equation.b[..., 3:], weights.shape[1], axis=2)
        return ColumnImpact(landing, equation._replace(b=b), combined, self.jumps @ weights)


def has_range(landing: PosedLanding) -> bool:
    """Whether some drive of a landing is not known exactly."""
    model = landing.joint_model
    return bool(np.any(model.low < model.high))


def range_of(profile: ShockProfile, selection: Selection, place: Place) -> Range | None:
    """The range of a number of a profile over the drives.

    Args:
        profile: the landing; its own value is in the range.
        selection: the number.
        place: where.

    Returns: None where every drive is known exactly, where the number has no value, or where no drive reaches it: at a point that
        is fixed to the world, of another joint model, or of how far the numbers are proven.
    """
    landing, wanted = profile.landing, selection.quantity
    if wanted.on != "scene" or (wanted.of == "point" and place.body < 0) or not has_range(landing):
        return None
    value = float(profile.numbers(selection, [place])[0])
    if np.isnan(value):
        return None
    values = [found for _, found in _searched(landing, selection, place)]
    return Range(min(value, *values), max(value, *values), _kind(landing, selection, place)) if values else None


def effective_mass_range(profile: ShockProfile) -> Range | None:
    """The range of the effective mass of all contacts together, as `ShockProfile.effective_mass` [kg]; None as for `range_of`."""
    landing, value = profile.landing, profile.effective_mass
    if not has_range(landing) or np.isnan(value):
        return None
    masses = [value]
    for change in _extremes(landing):
        if (end := _changed(landing, change)) is not None:
            impulse = solve_in_doubles(end, end.equation(end.state)).impulse[0]
            masses.append(mass_of_contacts(end, impulse))
    known = [mass for mass in masses if np.isfinite(mass)]
    return Range(min(known), max(known), "samples" if landing.scene.stops else "exact")


def deciding_joints(profile: ShockProfile, selection: Selection, place: Place) -> tuple[str, ...]:
    """Names of the joints whose drives account for nearly all of the range of a number, those with the largest effect first.

    At each end of the range the joints are ordered by what the number loses when one of them is as modelled again. Those decide
    with which, one after the other, the number comes within a twentieth of the end.
    """
    landing = profile.landing
    if not has_range(landing) or not (found := _searched(landing, selection, place)):
        return ()
    start = _read(landing, selection, place, [np.zeros(landing.robot.model.nv)])[0]
    ends = [pick(found, key=lambda one: one[1]) for pick in (min, max)]
    width = max(abs(value - start) for _, value in ends)
    decide: list[int] = []
    for change, value in ends:
        if abs(value - start) > NEARLY * width:
            decide += _nearly_all(landing, selection, place, change, value, start)
    names = {v: joint.name for joint in landing.robot.single_joints for v in range(joint.v.start, joint.v.stop)}
    return tuple(dict.fromkeys(names[v] for v in decide))


def _nearly_all(landing: PosedLanding, selection: Selection, place: Place, end: Array, value: float, start: float) -> list[int]:
    """The joint velocities that account for nearly all of the way of a number from its start to an end."""
    changed = np.flatnonzero(end)
    without = [np.where(np.arange(len(end)) == i, 0.0, end) for i in changed]
    lost = np.abs(np.array(_read(landing, selection, place, without)) - value)
    order = changed[np.argsort(-np.nan_to_num(lost, nan=np.inf), kind="stable")]
    first = [np.where(np.isin(np.arange(len(end)), order[:k]), end, 0.0) for k in range(1, len(order) + 1)]
    left = np.abs(np.array(_read(landing, selection, place, first)) - value)
    enough = np.flatnonzero(left <= NEARLY * abs(value - start))
    return [int(i) for i in order[: enough[0] + 1 if len(enough) else len(order)]]


def _kind(landing: PosedLanding, selection: Selection, place: Place) -> Kind:
    """How the ends of a range are found."""
    if landing.scene.stops or selection.quantity.of_ground(landing.scene):
        return "samples"
    if (selection.quantity.of, selection.quantity.key) in GROWING:
        return "exact"
    return "samples" if _linear(landing, selection, place) is None else "corners"


def _searched(landing: PosedLanding, selection: Selection, place: Place) -> list[tuple[Array, float]]:
    """Changes (nv,) of the inertias among which a range has its ends, and the values there."""
    kind, wanted, scene = _kind(landing, selection, place), selection.quantity, landing.scene
    changes = [] if kind == "corners" else _extremes(landing)
    # A motion on contacts of finite stiffness takes long, so it is computed of few.
    if kind != "exact" and not (wanted.of_ground(scene) and scene.contact_stiffness is not None):
        changes += _ends(landing, selection, place)
    values = _read(landing, selection, place, changes)
    return [(change, value) for change, value in zip(changes, values, strict=True) if not np.isnan(value)]


GROWING = {
    ("contact", "effective_mass"), ("contact", "mass_sticking"), ("contact", "mass_frictionless"),
    ("contact", "mitigation_frictionless"), ("robot", "energy_lost"),
}  # fmt: skip
"""Quantities that only grow, or only fall, with every inertia: bᵀΛb, since H grows, J H⁻¹ Jᵀ falls and Λ grows."""

LENGTHS = {
    ("joint", "joint_impulse"): "force",
    ("joint", "joint_moment"): "moment",
    ("joint", "joint_torque_share"): "along",
    ("point", "filtered_peak"): "delta_v",
    ("point", "filtered_peak_axes"): "delta_v",
}
"""Quantities that are the length of another one at the same place, but for a factor."""

LINEAR = {
    ("joint", "force"), ("joint", "moment"), ("joint", "along"), ("contact", "moment"), ("robot", "total_impulse"),
    ("robot", "total_moment"),
}  # fmt: skip
"""Quantities that are linear in the jumps and impulses in one posture, besides those that are so in all."""


def _linear(landing: PosedLanding, selection: Selection, place: Place) -> _Linear | None:
    """What a number follows from; None where it is of another kind."""
    wanted, key = selection.quantity, (selection.quantity.of, selection.quantity.key)
    if wanted.of == "part":
        if place.joint < 0:
            return _Linear(quantity("point", "delta_v"), place, selection.axis, selection.axis is not None)
        joint = next(one for one in joint_places(landing.robot) if one.number == place.joint)
        return _Linear(quantity("joint", "along"), joint, signed=wanted.key == "along")
    if key == ("joint", "rate_after"):
        return _Linear(quantity("joint", "delta_qd"), place, signed=True)
    if wanted.linear or key in LINEAR:
        signed = selection.axis is not None or not wanted.vector
        return _Linear(wanted, place, selection.axis, signed)
    if key in LENGTHS:
        return _Linear(quantity(wanted.of, LENGTHS[key]), place, selection.axis)
    return None if wanted.length_of is None else _Linear(wanted.length_of, place)


@memoized()
def _response(landing: PosedLanding) -> _Response:
    """How a landing responds to its drives."""
    equation, model = landing.equation(landing.state), landing.joint_model
    columns = np.flatnonzero(model.low < model.high)
    modelled = solve_in_doubles(landing, equation)
    # H Δẏ − Jᵀ λ = Gᵀ e_i and J Δẏ = 0 for a unit impulse on joint i: Δẏ = H⁻¹ Gᵀ e_i, and what undoes its speeds along the rows.
    on_joints = _turns(landing)[:, columns]
    unheld = solve_inertia(equation.inertia, (on_joints if equation.G is None else equation.G[0].T @ on_joints)[None])
    held = solve_in_doubles(landing, equation._replace(b=equation.J_c @ unheld))
    solution = modelled._replace(
        delta_qd=np.concatenate([modelled.delta_qd[..., 3:], unheld + held.delta_qd], axis=2),
        impulse=np.concatenate([modelled.impulse[..., 3:], held.impulse], axis=2),
        independent={k: np.column_stack([part[:, 3:], held.independent[k]]) for k, part in modelled.independent.items()},
    )
    delta_qd = equation.full(solution.delta_qd)
    rates = on_joints.T @ delta_qd[0]
    less, more = model.low - model.armature, model.high - model.armature
    box = DriveBox(rates[:, 1:], rates[:, 0], less[columns], more[columns])
    return _Response(box, columns, solution, jumps_of(landing, delta_qd, equation.state))


def _turns(landing: PosedLanding) -> Array:
    """The joint velocities (nv, nv) on which the drive of each joint acts, as columns: the joint's own, or the turns of its rotor.

    A rotor turns by q̇ + (a·ω)/±n for one turn of the joint, with ω of the link that carries it. Of a
    drive that may be infinite, which is a joint that is held, the joint's own rate counts alone.
    """
    model, J = landing.joint_model, landing.state.J[0, :3]
    turns = np.eye(len(model.armature))
    for v, body in geared_bodies(landing.robot, np.where(np.isinf(model.high), 0.0, model.coupling)):
        carried = landing.robot.ancestors[landing.robot.parents[body]]
        turns[:, v] += model.per_turn[v] * carried * (J[:, v] @ J)
    return turns


def _ends(landing: PosedLanding, selection: Selection, place: Place) -> list[Array]:
    """Changes (nv,) of the inertias as modelled at which a number is smallest and largest, as far as found.

    Of a number that is no length or component of what is linear, they are those of the jump at its place, or of the heaviest body.
    """
    response = _response(landing)
    linear = _linear(landing, selection, place)
    if linear is None:
        bodies = landing.places("body")
        moving = place if place.body >= 0 else bodies[int(np.argmax(landing.robot.masses))]
        linear = _Linear(quantity("point", "delta_v"), moving)
    every = response.impacts(landing, np.eye(1 + len(response.columns)))
    vectors = evaluate(linear.quantity, every, [linear.place])[0, :, 0]
    vectors = vectors[:, None] if vectors.ndim == 1 else vectors
    vectors = vectors if linear.axis is None else vectors[:, linear.axis, None]
    Y, B = vectors[0], vectors[1:].T
    if not (np.isfinite(Y).all() and np.isfinite(B).all()):
        return []
    box = response.box
    if linear.signed:
        ends = [box.largest(Y, B, lambda vectors: -vectors[0]), box.largest(Y, B, lambda vectors: vectors[0])]
    else:
        ends = [box.smallest(Y, B), box.largest(Y, B)]
    changes = np.zeros((2, len(landing.joint_model.armature)))
    changes[:, response.columns] = ends
    return list(changes)


def _read(landing: PosedLanding, selection: Selection, place: Place, changes: Sequence[Array]) -> list[float]:
    """The values of a number at changes (nv,) of the inertias as modelled; NaN where there is none."""
    if _kind(landing, selection, place) == "corners":
        response = _response(landing)
        weights = np.array([[1.0, *response.box.impulses(change[response.columns])] for change in changes]).T
        values = selection.scalar(evaluate(selection.quantity, response.impacts(landing, weights), [place]))
        return [float(value) for value in values[0, :, 0]]
    return [_value_of(_changed(landing, change), selection, place) for change in changes]


def _extremes(landing: PosedLanding) -> list[Array]:
    """Changes (nv,) from the inertias as modelled to the smallest ones and to the largest ones.

    If no landing has these, because the contacts need joints to move, some are held in place of all.
    """
    model = landing.joint_model
    box, columns, *_ = _response(landing)
    held = np.zeros(len(model.armature))
    held[columns] = box.most
    changes = [model.low - model.armature, model.high - model.armature, held]
    return changes[:2] if np.array_equal(held, changes[1]) else changes


def _changed(landing: PosedLanding, change: Array) -> PosedLanding | None:
    """A landing with other inertias by a change (nv,), infinite where a joint is held; None where it cannot be solved."""
    return _changed_by(landing, change.tobytes())


@memoized(most=8)
def _changed_by(landing: PosedLanding, data: bytes) -> PosedLanding | None:
    """The same for the bytes of the change, by which it is kept."""
    model, change = landing.joint_model, np.frombuffer(data)
    held = np.isinf(change)
    armature = np.where(held, 0.0, model.armature + np.where(held, 0.0, change))
    moved = change != 0.0
    joints = model._replace(
        armature=armature,
        locked=model.locked | held,
        name="mixed",
        stiffness=np.where(held, 0.0, model.stiffness),
        drive_stiffness=np.where(moved, np.inf, model.drive_stiffness),
        rotor=np.where(moved, 0.0, model.rotor),
        low=armature,
        high=armature,
        sources=(),
    )
    state = dynamics(landing.robot, landing.q[None], joints)
    other = replace(landing.without_stops, joint_model=joints, state=state)
    try:
        return with_stops(other) if landing.scene.stops else other
    except (SceneError, SolveError):
        return None


def _value_of(landing: PosedLanding | None, selection: Selection, place: Place) -> float:
    """A number of a landing in doubles, or with a proof where doubles do not have it; NaN where it has none."""
    if landing is None:
        return np.nan
    wanted = selection.quantity
    try:
        equation = landing.equation(landing.state)
        solution = solve_in_doubles(landing, equation)
        jumps = jumps_of(landing, equation.full(solution.delta_qd), equation.state)
        value = selection.scalar(evaluate(wanted, DoubleImpact(landing, equation, solution, jumps), [place]))[0, 0, 0]
        if np.isnan(value) and wanted.needs_posture:
            proof = solve_exactly(landing, equation, solution)
            value = selection.scalar(proof.read(wanted.compute, [place], size=wanted.size))[0, 0, 0]
        return float(value)
    except (SceneError, SolveError, SingularError):
        return np.nan
