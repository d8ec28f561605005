"""Columns of a table of landings, and the landing that gives what they lack.

Both follow from the table and the options of a command.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shockpc.cli.options import SceneOptions
from shockpc.cli.scenes import one_scene, with_contact
from shockpc.landing.posture import settable_joints
from shockpc.landing.scenes.scene import Posture, Scene
from shockpc.landing.scenes.scene_file import check_scene, plane_of
from shockpc.landing.scenes.strike import Strike
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError
from shockpc.wings.recordings.tables.cells import empty_cells
from shockpc.wings.recordings.tables.column_meaning import (
    FRICTION,
    StateColumns,
    column_name,
    state_columns,
)
from shockpc.wings.recordings.tables.state import ANGLES
from shockpc.wings.recordings.tables.table_files import read_table

VELOCITY, ANGULAR_VELOCITY = ("vx", "vy", "vz"), ("wx", "wy", "wz")
"""Columns of the base."""

CELLS = ("contact", "stance")
"""Columns with names of options, whose empty cells mean the values of these.

Empty cells of efforts do the same.
"""

UP = (0.0, 0.0, 1.0)


def table_and_scene(
    file: Path, robot: str, options: SceneOptions, rename: Mapping[str, str]
) -> tuple[dict[str, np.ndarray], Robot, Scene]:
    """The columns of a table of landings; and the robot and the landing that give what it lacks.

    Args:
        file: of the table.
        robot: a robot or a scene, as for `scenes_from`.
        options: of the command.
        rename: other names for columns, as for `rows_of`.

    Raises:
        ShockError: the table, the scene or the robot cannot be read; or a column of the table
            overrides an option.
    """
    columns, completed = read_table(file), options
    if "contact" in columns:
        completed, contacts = with_contact(
            robot, options, columns["contact"].astype(str).ravel().tolist()
        )
        columns["contact"] = np.reshape(contacts, columns["contact"].shape)
    loaded, scene = one_scene(robot, completed)
    refuse_overridden(options, scene, loaded, state_columns(columns, loaded, rename))
    return columns, loaded, scene


def refuse_overridden(
    options: SceneOptions, scene: Scene, robot: Robot, table: StateColumns
) -> None:
    """Refuse options that have no effect because a table gives their values.

    These are contacts, posture, motion, torques and friction.

    Of a glob of joints one that the table lacks is enough to have an effect, as is one empty cell
    of a column where an empty cell means the scene's value. Components of zero say nothing.

    Args:
        options: of the command.
        scene: what they describe.
        robot: its robot.
        table: its columns.

    Raises:
        SceneError: an option has no effect; the text names it and the column.
    """
    # What the table gives, by what an option would say of it.
    positions = _columns_by_subject(table.positions, robot, "qpos", ANGLES)
    rates = _columns_by_subject(table.rates, robot, "qvel", VELOCITY + ANGULAR_VELOCITY)
    filled = _filled_columns(table)
    efforts = [name for name in filled if name not in CELLS]
    typed = options.fields(Strike) | options.fields(Posture)
    forward = plane_of(check_scene(scene)).forward.tolist()

    overridden: list[tuple[str, str]] = []
    for name in CELLS:
        if getattr(options, name) and name in filled:
            overridden.append((f"--{name}", name))
    if "friction" in options.fields(Scene):
        overridden += [("--friction", name) for name in FRICTION if name in table.others]
    overridden += _overridden_vectors(typed, forward, positions, rates)
    # A glob loses its effect only if the table has each joint that it fits.
    for option, settings, columns in (
        ("--set", options.set, positions),
        ("--joint-velocity", options.joint_velocity, rates),
        (
            "--torque",
            options.given.get("torque") or (),
            _columns_by_subject(efforts, robot, "", ()),
        ),
    ):
        for pattern, _ in settings:
            names = [f"joint {joint.name}" for joint in settable_joints(robot, pattern)]
            if all(name in columns for name in names):
                overridden.append((f"{option} {pattern}", columns[names[0]]))
    # A reference posture counts as long as one of its numbers is not in the table.
    posture = _subjects_of_posture(robot)
    if "reference" in typed and all(name in positions for name in posture):
        overridden.append(("--posture", positions[posture[0]]))
    if overridden:
        listed = ", ".join(f'{option} (column "{column}")' for option, column in overridden)
        raise SceneError(
            f"columns override options: {listed}; leave out the options (in an option of three "
            f"numbers, set the overridden "
            "one to zero), or the columns with --map COLUMN="
        )


def _filled_columns(table: StateColumns) -> list[str]:
    """The columns of which an empty cell would take the scene's value, and that have none."""
    filled: list[str] = []
    for name, values in table.others.items():
        of_cells = name in CELLS or name.startswith("effort_")
        if of_cells and not empty_cells(values).any():
            filled.append(name)
    return filled


def _subjects_of_posture(robot: Robot) -> list[str]:
    """What a table gives if a posture with a name has no effect.

    That is all joints that can be set, and the attitude of a free base.
    """
    subjects: list[str] = []
    for joint in robot.single_joints:
        if joint.kind != "free" and joint.name not in robot.followers:
            subjects.append(f"joint {joint.name}")
    if robot.free_base:
        subjects += ANGLES
    return subjects


def _overridden_vectors(
    typed: Mapping[str, Any],
    forward: Sequence[float],
    positions: Mapping[str, str],
    rates: Mapping[str, str],
) -> list[tuple[str, str]]:
    """Options of the base's motion and attitude that columns override, each with its column.

    A column overrides an option if it gives a component that the option sets. A component of zero
    counts as not set.

    Args:
        typed: the options that were typed.
        forward: (3,) unit vector in which a strike angle turns the velocity.
        positions: columns by what they give.
        rates: likewise.
    """
    # The columns' names of the components, and the components, as far as an option sets them.
    vectors = {
        "--speed": (VELOCITY, UP if "speed" in typed else ()),
        "--drop-height": (VELOCITY, UP if "drop_height" in typed else ()),
        "--strike-angle": (VELOCITY, forward if "strike_angle_deg" in typed else ()),
        "--velocity": (VELOCITY, typed.get("velocity", ())),
        "--angular-velocity": (ANGULAR_VELOCITY, typed.get("angular_velocity", ())),
        "--base-rpy": (ANGLES, typed.get("base_rpy_deg", ())),
    }
    overridden: list[tuple[str, str]] = []
    for option, (keys, vector) in vectors.items():
        columns = positions if keys is ANGLES else rates
        for key, component in zip(keys, vector, strict=False):
            if component and key in columns:
                overridden.append((option, columns[key]))
    return overridden


def _columns_by_subject(
    columns: Iterable[str], robot: Robot, array: str, base: Sequence[str]
) -> dict[str, str]:
    """The column that gives each joint, as "joint NAME", and each number of the base.

    Args:
        columns: of positions or rates.
        robot: the robot.
        array: name of MuJoCo's column that gives all of them.
        base: the numbers of the base.
    """
    by_subject: dict[str, str] = {}
    for name in columns:
        column = column_name(name, robot)
        subjects: list[str] = []
        if name == array and name not in robot.joint_names:
            subjects = [f"joint {joint}" for joint in robot.joint_names]
            if robot.free_base:
                subjects += base
        elif column is not None and column.base == "qw":
            subjects = list(ANGLES)
        elif column is not None:
            subjects = [column.base or f"joint {column.target}"]
        by_subject |= dict.fromkeys(subjects, name)
    return by_subject
