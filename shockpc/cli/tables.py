"""From a table of landings and the options of a command to columns, and the landing that gives what these lack."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from shockpc.cli.options import SceneOptions
from shockpc.cli.scenes import one_scene, with_contact
from shockpc.evaluation.column_names import FRICTION, column_name, state_columns
from shockpc.evaluation.recorded_table import ANGLES
from shockpc.evaluation.table_files import read_table
from shockpc.landing.posture import settable_joints
from shockpc.landing.scene import Posture, Scene, Strike
from shockpc.landing.scene_file import check_scene, plane_of
from shockpc.robot.robot import Robot
from shockpc.text.errors import SceneError

VELOCITY, ANGULAR_VELOCITY = ("vx", "vy", "vz"), ("wx", "wy", "wz")
"""Columns of the base."""

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
        ShockError: the table, the scene or the robot cannot be read; or a column of the table overrides an option.
    """
    columns = read_table(file)
    if "contact" in columns:
        options, contacts = with_contact(robot, options, columns["contact"].astype(str).ravel().tolist())
        columns["contact"] = np.reshape(contacts, columns["contact"].shape)
    loaded, scene = one_scene(robot, options)
    if ignored := _ignored(options, scene, loaded, columns, rename):
        raise SceneError(
            f"columns of the table override options: {', '.join(ignored)}; leave out the options (one component of several by a "
            "zero), or the columns with --map COLUMN="
        )
    return columns, loaded, scene


def _ignored(
    options: SceneOptions, scene: Scene, robot: Robot, columns: Mapping[str, np.ndarray], rename: Mapping[str, str]
) -> list[str]:
    """The options whose posture, motion or friction the table gives, each with the column.

    Of a glob of joints one that the table lacks is enough to have an effect, and components of zero say nothing.
    """
    table = state_columns(columns, robot, rename)
    positions = _columns_by_subject(table.positions, robot, "qpos", ANGLES)
    rates = _columns_by_subject(table.rates, robot, "qvel", VELOCITY + ANGULAR_VELOCITY)
    frictions = [name for name in FRICTION if name in table.others]
    typed = options.fields(Strike) | options.fields(Posture)
    forward = plane_of(check_scene(scene)).forward.tolist()
    vectors = {
        "--speed": (VELOCITY, UP if "speed" in typed else ()),
        "--drop-height": (VELOCITY, UP if "drop_height" in typed else ()),
        "--strike-angle": (VELOCITY, forward if "strike_angle_deg" in typed else ()),
        "--forward-speed": (VELOCITY, forward if "forward_speed" in typed else ()),
        "--velocity": (VELOCITY, typed.get("velocity", ())),
        "--angular-velocity": (ANGULAR_VELOCITY, typed.get("angular_velocity", ())),
        "--base-rpy": (ANGLES, typed.get("base_rpy_deg", ())),
    }
    ignored = [("--friction", name) for name in frictions if "friction" in options.fields(Scene)]
    for option, (keys, vector) in vectors.items():
        known = positions if keys is ANGLES else rates
        ignored += [(option, known[key]) for key, x in zip(keys, vector, strict=False) if x and key in known]
    for option, settings, known in (("--set", options.set, positions), ("--joint-velocity", options.joint_velocity, rates)):
        for pattern, _ in settings:
            names = [f"joint {joint.name}" for joint in settable_joints(robot, pattern)]
            if all(name in known for name in names):
                ignored.append((f"{option} {pattern}", known[names[0]]))
    return [f'{option} (column "{column}")' for option, column in ignored]


def _columns_by_subject(columns: Iterable[str], robot: Robot, whole: str, base: Sequence[str]) -> dict[str, str]:
    """The column that gives each joint, as "joint NAME", and each number of the base.

    Args:
        columns: of positions or rates.
        robot: the robot.
        whole: name of MuJoCo's column that gives all of them.
        base: the numbers of the base.
    """
    found: dict[str, str] = {}
    for name in columns:
        column = column_name(name, robot)
        if name == whole and name not in robot.joint_names:
            found |= dict.fromkeys([f"joint {joint}" for joint in robot.joint_names] + [*base] * robot.free_base, name)
        elif column is not None:
            found |= dict.fromkeys(ANGLES if column.base == "qw" else [column.base or f"joint {column.target}"], name)
    return found
