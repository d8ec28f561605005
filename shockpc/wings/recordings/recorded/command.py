"""`shockpc recorded`: the landings of a table, and measured jumps against predicted ones."""

import dataclasses
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from shockpc.cli.computed_rows import computed
from shockpc.cli.declared import argument, command, group
from shockpc.cli.options import ROBOT, OutputOptions, RunOptions, SceneOptions, in_run
from shockpc.cli.output import emit, exit_code
from shockpc.cli.parse import joint_models, path
from shockpc.cli.process import print_error
from shockpc.cli.study_command import help_of, study_arguments, study_options
from shockpc.cli.unused_options import refuse_unasked
from shockpc.evaluation.column import Column
from shockpc.evaluation.table import Table
from shockpc.landing.joint_model import joint_model
from shockpc.landing.posture import spelled_out
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.joint_options import JointModelName, Joints, with_model
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import options_of
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.errors import DefectError, ShockError, StudyError
from shockpc.wings.recordings.recorded.report import recorded_report
from shockpc.wings.recordings.recorded.study import Validation, compare_measured, refuse_unused
from shockpc.wings.recordings.recorded.study import recorded as study
from shockpc.wings.recordings.recorded_table import table_and_scene
from shockpc.wings.recordings.tables.evaluation import recorded_landings
from shockpc.wings.recordings.tables.landings import RecordedLandings
from shockpc.wings.recordings.tables.reader import rows_of
from shockpc.wings.recordings.tables.rows import RecordedRows

_in_table, _in_joints = group("Table"), group(options_of(Joints)["model"].heading)

PAGE_LANDINGS = 8
"""Landings that report.html shows."""


class ModelledTable(NamedTuple):
    """A table of landings, with the joint models that are compared with what it measured.

    Attributes:
        columns: by name.
        renames: other names for columns.
        robot: the robot.
        scene: gives what the table lacks.
        models: the scene with each joint model that was asked for, by its name.
        rows: of the table.
    """

    columns: dict[str, np.ndarray]
    renames: Mapping[str, str]
    robot: Robot
    scene: Scene
    models: dict[str, Scene]
    rows: RecordedRows


@command(**help_of(study))
def recorded(
    *,
    table: Path = argument("A table of landings: .csv, .parquet or .npz.", "TABLE", path),
    robot: str | None = ROBOT,
    typed: Any = study_options(study),
    options: SceneOptions,
    joints_: tuple[JointModelName, ...] | None = _in_joints(
        "One joint model, or several with commas between them, to be compared with the measured "
        f"jumps. {options_of(Joints)['model'].text}",
        "MODEL[,MODEL]",
        joint_models,
    ),
    command_: str | None = _in_table(
        "Print the landing of this row, by its name, as a scene, which shockpc analyze takes, and "
        "nothing else.",
        "ROW",
    ),
    rows: Literal["parquet", "csv"] | None = in_run(
        "With --out, write the rows; --resume continues those in Parquet."
    ),
    run: RunOptions,
    output: OutputOptions,
) -> int:
    models = joints_ or ()
    asked_for = study_arguments(study, typed)
    renames = asked_for.pop("rename", {})
    # A single joint model is an option of the landings; of several each has its own scene.
    model = models[0] if len(models) == 1 else None
    options = options._replace(given={**options.given, "joints": model})
    read = _read_table(table, robot, options, models, renames)
    evaluation = recorded_landings(read.rows, read.robot, **asked_for)
    source = evaluation.landings
    if command_ is not None:
        _print_scene(source, command_, output)
        return 0
    keys = [measured.key for measured in read.rows.measured if "@" in measured.key]
    refuse_unasked(study, options, typed, keys)
    refuse_unused(read.scene, read.rows, evaluation)
    # Before anything is written, because one of several joint models may be refused.
    comparison, defects = _compared(read, source)
    with computed(evaluation, "landings", output.out, rows, run) as results:
        rank = asked_for.get("rank")
        ranked = None if rank is None else results.column(rank)
        worst = _worst_profiles(source, results, ranked) if output.out is not None else {}
        emit(recorded_report(str(table), source, results, ranked, comparison, worst), output)
    return exit_code(len(results.messages), len(results), run.strict, (*results.defects, *defects))


def _read_table(
    table: Path,
    robot: str | None,
    options: SceneOptions,
    models: tuple[JointModelName, ...],
    renames: Mapping[str, str],
) -> ModelledTable:
    """Read a table of landings.

    Raises:
        ShockError: it is none, has no robot, or several joint models have nothing to be compared
            with.
    """
    if table.is_dir():
        raise StudyError(
            f'"{table}" is a folder, not a table of landings; for a folder of scenes: shockpc '
            f"batch {table}/*.toml"
        )
    if robot is None:
        raise StudyError(f"a table needs a robot: shockpc recorded {table} ROBOT --contact …")
    columns, loaded, scene = table_and_scene(table, robot, options, renames)
    by_model = _with_models(scene, loaded, models)
    if len(models) > 1:
        scene = next(iter(by_model.values()))
    rows = rows_of(columns, landing_of(scene, loaded), renames)
    if len(models) > 1 and not rows.measured:
        raise StudyError(
            "several joint models are compared with measured jumps, but the table has no column "
            "after_…"
        )
    return ModelledTable(columns, renames, loaded, scene, by_model, rows)


def _print_scene(source: RecordedLandings, name: str, output: OutputOptions) -> None:
    """Print the landing of the row of a name as a scene."""
    if output.out is not None or output.format != "table":
        raise StudyError(
            "--command prints only the scene of one landing; leave out --out and --format"
        )
    scene = spelled_out(source.case(source.row_named(name)), source.robot)
    sys.stdout.write(scene_text(scene, Path.cwd()))


def _compared(read: ModelledTable, source: RecordedLandings) -> tuple[Validation | None, list[str]]:
    """What the table measured against predictions, if it did; and traces of defects."""
    if not read.rows.measured:
        return None, []
    models = read.models or {source.first.joint_model.name: read.scene}
    try:
        return compare_measured(read.columns, models, read.robot, read.renames), []
    except DefectError as defect:  # the rows are given nevertheless
        return None, [defect.trace]


def _worst_profiles(
    source: RecordedLandings, results: Table, ranked: Column | None
) -> dict[str, ShockProfile]:
    """The worst landings by name, for which the page has room."""
    worst: dict[str, ShockProfile] = {}
    for i in results.worst(PAGE_LANDINGS, ranked):
        name = str(source.table.names[i])
        try:
            worst[name] = source.profile(i)
        except ShockError as error:
            print_error(f'landing "{name}" is not in report.html: {error}')
    return worst


def _with_models(
    scene: Scene, robot: Robot, models: tuple[JointModelName, ...]
) -> dict[str, Scene]:
    """The scene with each of some joint models, by name.

    Of several models, rigid is left out where no joint has a spring.
    """
    scenes: dict[str, Scene] = {}
    for model in models:
        scenes[model] = dataclasses.replace(scene, joints=with_model(scene.joints, model))
    if len(models) < 2 or "rigid" not in models:
        return scenes
    if not joint_model(robot, with_model(scene.joints, None)).springs.any():
        print_error(
            f'joint model rigid is left out, because no joint of "{robot.name}" has a spring'
        )
        del scenes["rigid"]
    return scenes
