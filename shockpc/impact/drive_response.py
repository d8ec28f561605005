"""The response of an impact to the drives: the landing with other inertias.

It is in closed form or solved anew.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shockpc.core.drive_box import DriveBox
from shockpc.core.impulse import Solution
from shockpc.core.inertia import solve_inertia
from shockpc.core.memo import memoized
from shockpc.core.spatial import Array
from shockpc.impact.impact import ColumnImpact, jumps_in_body_axes
from shockpc.impact.landed import solution_in_doubles
from shockpc.impact.stops import with_stops
from shockpc.landing.feet.auto_contact import with_own_faces
from shockpc.landing.landing import PosedLanding
from shockpc.method.dynamics import dynamics, geared_bodies
from shockpc.method.shock import solution_of
from shockpc.text.errors import SceneError, SolveError

MOST_LANDINGS = 8
"""Landings with other inertias that a landing keeps."""


class DriveResponse(NamedTuple):
    """The response of a landing to impulses of its drives, with the contacts held.

    Attributes:
        box: the drives that are not known exactly.
        columns: (n,) their joint velocities.
        solution: of Eq. 4 as modelled, then of unit impulses of each of these drives.
        jumps: (1, nb, 6, 1 + n) of the bodies, likewise, body axes.
        moments: (1, nb, 3, 1 + n) that these impulses give to the bodies that carry rotors, world
            axes.
    """

    box: DriveBox
    columns: np.ndarray
    solution: Solution
    jumps: Array
    moments: Array

    def at(self, landing: PosedLanding, changes: list[Array]) -> ColumnImpact:
        """Impacts, one a column, with other inertias.

        Args:
            landing: that this is the response of.
            changes: (nv,) each, from the inertias as modelled; infinite where a joint is held.
        """
        weights = [[1.0, *self.box.impulses(change[self.columns])] for change in changes]
        return self.combined(landing, np.array(weights).T)

    def combined(self, landing: PosedLanding, weights: Array) -> ColumnImpact:
        """Impacts, one a column, for weights (1 + n, k) of these solutions."""
        equation, solution = landing.equation(landing.state), self.solution
        combined = solution._replace(
            delta_qd=solution.delta_qd @ weights,
            impulse=solution.impulse @ weights,
            independent={k: part @ weights for k, part in solution.independent.items()},
        )
        b = np.repeat(equation.b[..., 3:], weights.shape[1], axis=2)
        impact = ColumnImpact(landing, equation._replace(b=b), combined, self.jumps @ weights)
        impact.moments = self.moments @ weights
        return impact


@memoized()
def drive_response(landing: PosedLanding) -> DriveResponse:
    """The response of a landing to those of its drives that are not known exactly.

    Of a unit impulse on a joint, H Δẏ − Jᵀ λ = Gᵀ e_i and J Δẏ = 0: first without contacts,
    Δẏ = H⁻¹ Gᵀ e_i, then as an impact that undoes its speeds along the rows.
    """
    equation = landing.equation(landing.state)
    model = landing.joint_model
    # A drive that is known exactly needs no response.
    columns = np.flatnonzero(model.low < model.high)
    turns, moments = _turns(landing)
    on_joints = turns[:, columns]
    reduced = on_joints if equation.G is None else equation.G[0].T @ on_joints
    unheld = solve_inertia(equation.inertia, reduced[None])
    limits = landing.row_limits(landing.state, equation.constraints)
    held = solution_of(equation._replace(b=equation.J_c @ unheld), limits)

    # Columns of the landing's strike as modelled, then of each drive.
    modelled = solution_in_doubles(landing)
    independent: dict[int, Array] = {}
    for k, part in modelled.independent.items():
        independent[k] = np.column_stack([part[:, 3:], held.independent[k]])
    solution = modelled._replace(
        delta_qd=np.concatenate([modelled.delta_qd[..., 3:], unheld + held.delta_qd], axis=2),
        impulse=np.concatenate([modelled.impulse[..., 3:], held.impulse], axis=2),
        independent=independent,
    )
    delta_qd = equation.full(solution.delta_qd)
    rates = on_joints.T @ delta_qd[0]
    # `less` and `more` are how far each inertia may lie below and above the modelled one.
    box = DriveBox(
        C=rates[:, 1:],
        x=rates[:, 0],
        less=model.low[columns] - model.armature[columns],
        more=model.high[columns] - model.armature[columns],
        mobility=np.sum(on_joints * equation.full(unheld)[0], axis=0),
    )
    # The first column is the strike, in which no unit impulse acts on a joint.
    of_strike = np.zeros((1, *moments.shape[:2], 1))
    return DriveResponse(
        box=box,
        columns=columns,
        solution=solution,
        jumps=jumps_in_body_axes(equation, solution.delta_qd),
        moments=np.append(of_strike, moments[None, ..., columns], axis=3),
    )


def _turns(landing: PosedLanding) -> tuple[Array, Array]:
    """On what each drive acts: its joint's rate, or the turns of its rotor over ±n, q̇ + (a·ω)/±n.

    ω is that of the link that carries the rotor. Of a drive that may be infinite, which is a joint
    that is held, the joint's own rate counts alone.

    Returns: the impulses (nv, nv) of unit ones of each drive along the joint velocities, as
        columns; and their moments (nb, 3, nv) on the links that carry rotors, world axes.
    """
    robot = landing.robot
    model = landing.joint_model
    axes = landing.state.J[0, :3]
    nv = len(model.armature)
    turns = np.eye(nv)
    moments = np.zeros((len(robot.bodies), 3, nv))
    coupling = np.where(np.isinf(model.high), 0.0, model.coupling)
    for v, body in geared_bodies(robot, coupling):
        parent = robot.parents[body]
        moment = model.per_turn[v] * axes[:, v]
        moments[parent, :, v] = moment
        turns[:, v] += robot.ancestors[parent] * (moment @ axes)
    return turns, moments


def extreme_changes(landing: PosedLanding) -> list[Array]:
    """Changes (nv,) from the inertias as modelled to the smallest ones, and to the largest ones.

    Where the contacts need joints to move, a third one holds as many of them as it can.
    """
    model, response = landing.joint_model, drive_response(landing)
    held = np.zeros(len(model.armature))
    held[response.columns] = response.box.most
    changes = [model.low - model.armature, model.high - model.armature, held]
    return changes[:2] if np.array_equal(held, changes[1]) else changes


def with_inertias(landing: PosedLanding, change: Array) -> PosedLanding | None:
    """A landing with other inertias, and the stops and faces of soles that act with them.

    Args:
        landing: the landing.
        change: (nv,) from the inertias as modelled; infinite where a joint is held.

    Returns: None where it cannot be resolved, or has no contact left.
    """
    return _with_inertias(landing, change.tobytes())


@memoized(most=MOST_LANDINGS)
def _with_inertias(landing: PosedLanding, data: bytes) -> PosedLanding | None:
    """The value of `with_inertias` for the bytes of the change, by which it is kept."""
    model, change = landing.joint_model, np.frombuffer(data)
    held, moved = np.isinf(change), change != 0.0
    armature = np.where(held, 0.0, model.armature + np.where(held, 0.0, change))
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
    changed = replace(landing.without_stops, joint_model=joints, state=state)
    try:
        changed = with_own_faces(changed)
        if not changed.contacts:
            return None
        return with_stops(changed) if landing.scene.stops else changed
    except (SceneError, SolveError):
        return None
