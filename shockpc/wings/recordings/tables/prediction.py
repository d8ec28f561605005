"""Predicted jumps of what recorded landings measured, and the norm of their errors."""

from collections.abc import Mapping, Sequence

import numpy as np

from shockpc.core.inertia import solve_inertia
from shockpc.core.spatial import Array
from shockpc.evaluation.column import Column, selected
from shockpc.evaluation.evaluate import Evaluation
from shockpc.evaluation.landings import Refusal
from shockpc.landing.movable import movable_columns
from shockpc.landing.places import body_places
from shockpc.method.dynamics import Dynamics, dynamics
from shockpc.quantities.selection import select, selections
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.rows import Measured

COMPONENTS = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Those of the base's velocity, as coordinates."""


def predicting(study: RecordedLandings, friction: bool) -> dict[str, Column]:
    """The columns that predict what was measured, by its key.

    All components of the base's jump are among them.

    Args:
        study: the landings.
        friction: whether they have friction, and the jumps are those with it.
    """
    base = body_places(study.robot)[0]
    columns: dict[str, Column] = {}
    for kind, key in (("v", "delta_v"), ("w", "delta_omega")):
        for axis in "xyz":
            columns[kind + axis] = Column(select(f"body.{key}.{axis}"), base)
    for measured in study.table.measured:
        if "@" not in measured.key or measured.key in columns:
            continue
        selection, places = selected(study.first, measured.key)
        if len(places) != 1:
            raise StudyError(
                f"after_{measured.key} is one column, and means {len(places)} places; name one of "
                "them"
            )
        columns[measured.key] = Column(selection, places[0])
    if friction:
        columns = {key: _with_friction(key, column) for key, column in columns.items()}
    return columns


def _with_friction(key: str, column: Column) -> Column:
    """The quantity of a column in the impact with friction.

    Args: key, of what was measured.
    """
    selection = column.selection
    if selection.quantity.computation.exact == "never":
        return column  # of the impact with friction already
    name = selection.name.replace(selection.quantity.key, f"{selection.quantity.key}_friction")
    if name not in selections():
        raise StudyError(
            f"after_{key} cannot be predicted with friction, because {selection.name} does not "
            f"exist with it; leave the column out "
            f"with --map after_{key}=, or the friction"
        )
    return column._replace(selection=select(name))


def base_in_world(
    study: RecordedLandings, predicting: Mapping[str, Column], columns: Mapping[str, Array]
) -> dict[str, Array]:
    """The jumps (n,) by key, those of the base in world axes.

    Args: columns (n,) by name, those of the base in body axes.
    """
    jumps = {key: columns[column.name] for key, column in predicting.items()}
    for kind in "vw":
        in_body = np.stack([jumps[kind + axis] for axis in "xyz"], axis=-1)
        world = (_rotations(study) @ in_body[..., None])[..., 0]
        jumps |= {kind + axis: world[:, k] for k, axis in enumerate("xyz")}
    return jumps


def _rotations(study: RecordedLandings) -> Array:
    """Rotations (n, 3, 3) of the base's frame, body to world."""
    from scipy.spatial.transform import Rotation

    if not study.robot.free_base:
        return np.broadcast_to(study.first.state.rotation[0, 0], (study.rows, 3, 3))
    return np.asarray(
        Rotation.from_quat(study.table.Q[:, 3:7]).as_matrix() @ study.robot.bodies[0].rotation
    )


def predicted_later(
    study: RecordedLandings, by_key: Mapping[str, Column], timed: Sequence[Measured]
) -> tuple[list[Array], dict[int, str]]:
    """The changes (n,) until the time of each measured quantity, and failures by row.

    They are on contacts of finite stiffness.

    Args:
        study: the landings.
        by_key: columns by key.
        timed: what was measured, each with a time.
    """
    times = sorted({measured.time for measured in timed if measured.time})
    at_times: dict[float, dict[str, Column]] = {}
    wanted: dict[str, Column] = {}
    for time in times:
        at_times[time] = {key: column._replace(time=time) for key, column in by_key.items()}
        wanted |= {column.name: column for column in at_times[time].values()}
    results = Evaluation(study, tuple(wanted.values()), prove=0).table.without_defects()
    jumps: dict[float, dict[str, Array]] = {}
    for time, columns in at_times.items():
        jumps[time] = base_in_world(study, columns, results.columns)
    messages = dict(results.messages)
    later = []
    for measured in timed:
        if not measured.time:
            continue
        values = jumps[measured.time][measured.key]
        later.append(values)
        for i in np.flatnonzero(np.isnan(values)).tolist():
            text = "at a time after contact does not follow from velocities, or has no value"
            messages.setdefault(i, f"{measured.key} {text}")
    return later, dict(sorted(messages.items()))


def mobilities(study: RecordedLandings) -> Array:
    """W = H⁻¹ (n, nv, nv) of the landings.

    That of a free base is in the world's components of its velocity and angular velocity.

    Joints are free, and followers follow; along what the base cannot move, and of rows without a
    landing, W is zero or NaN.
    """
    robot = study.robot
    nv = robot.model.nv
    W = np.full((study.rows, nv, nv), np.nan)
    unlocked = np.zeros(nv, dtype=bool)
    for k, (first, _) in enumerate(study.chunks):
        for group in study.chunk(k, study.data(k)).groups:
            if isinstance(group, Refusal):
                continue
            landing = group.landing
            state = dynamics(robot, group.Q, landing.joint_model)
            H = state.H
            velocities = velocities_of_rates(robot, state)
            G = movable_columns(robot, landing.base, landing.plane, state.rotation[:, 0], unlocked)
            if G is not None:
                velocities = velocities @ G
                H = G.swapaxes(1, 2) @ H @ G
            # W = V H⁻¹ Vᵀ with the velocities V of unit free velocities
            inverse = solve_inertia(H, velocities.swapaxes(1, 2))
            W[first + group.postures] = velocities @ inverse
    return W


def velocities_of_rates(robot: Robot, state: Dynamics) -> Array:
    """The velocities (N, nv, nv) of `mobilities` for unit joint velocities in N postures."""
    velocities = np.broadcast_to(np.eye(robot.model.nv), state.H.shape).copy()
    if robot.free_base:
        velocities[:, :6, :6] = state.J[:, [3, 4, 5, 0, 1, 2], :6]
    return velocities


def coordinate(measured: Measured, robot: Robot) -> int:
    """Row of `mobilities` that a measured velocity has; −1 for another quantity."""
    if measured.key in COMPONENTS:
        return COMPONENTS.index(measured.key)
    if measured.group in ("joint rates", "sliding rates"):
        return int(robot.joint(measured.name).v.start)
    return -1


def energy_roots(W: Array, chosen: np.ndarray) -> Array:
    """Matrices R (n, k, k) of the least energy of jumps δ: ‖R δ‖².

    That is the smallest ΔᵀHΔ of all motions Δ in which some velocities jump by δ.

    Args:
        W: (n, nv, nv) mobilities.
        chosen: (k,) which velocities. A jump of one that cannot be does not count.
    """
    s, Q = np.linalg.eigh(W[:, chosen][:, :, chosen])
    root = np.where(s > 1e-12 * s[:, -1:], 1.0 / np.sqrt(np.where(s > 0.0, s, 1.0)), 0.0)
    return np.asarray(root[..., None] * Q.swapaxes(1, 2))


def energy_norms(W: Array, coordinates: Array, jumps: Array) -> Array:
    """√(ΔᵀHΔ) (n,), the smallest for whatever Δ there is where none was measured [√J].

    Args:
        W: (n, nv, nv) mobilities.
        coordinates: (k,) of the jumps.
        jumps: (n, k) measured parts of Δ; NaN where there is none.
    """
    norms = np.full(len(jumps), np.nan)
    measured = np.isfinite(jumps)
    known = np.isfinite(W).all(axis=(1, 2))
    for pattern in np.unique(measured[measured.any(axis=1)], axis=0):
        rows = np.flatnonzero((measured == pattern).all(axis=1) & known)
        R = energy_roots(W[rows], coordinates[pattern])
        delta = jumps[rows][:, pattern, None]
        norms[rows] = np.linalg.norm((R @ delta)[..., 0], axis=1)
    return norms
