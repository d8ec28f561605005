"""`shockpc recorded`: the landings of a table, and measured jumps against predicted ones."""

import dataclasses
import sys
from pathlib import Path
from typing import Any, Literal

from shockpc.cli.computed_rows import computed
from shockpc.cli.declared import argument, command, group
from shockpc.cli.options import ROBOT, OutputOptions, RunOptions, SceneOptions, in_run
from shockpc.cli.output import emit, exit_code
from shockpc.cli.parse import joint_models, path
from shockpc.cli.process import print_error
from shockpc.cli.study_command import help_of, study_arguments, study_options
from shockpc.cli.unused_options import refuse_unasked
from shockpc.landing.joint_model import joint_model
from shockpc.landing.posture import spelled_out
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.joint_options import JointModelName, Joints, with_model
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import options_of
from shockpc.landing.scenes.scene_file import scene_text
from shockpc.robot.robot import Robot
from shockpc.text.errors import DefectError, ShockError, StudyError
from shockpc.wings.recordings.logs.evaluation import recorded_landings
from shockpc.wings.recordings.logs.reader import rows_of
from shockpc.wings.recordings.recorded.report import recorded_report
from shockpc.wings.recordings.recorded.study import compare_measured, refuse_unused
from shockpc.wings.recordings.recorded.study import recorded as study
from shockpc.wings.recordings.recorded_table import table_and_scene

_in_table, _in_joints = group("Table"), group(options_of(Joints)["model"].heading)

PAGE_LANDINGS = 8
"""Landings that report.html shows."""


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
    rank = asked_for.get("rank")
    renames = asked_for.pop("rename", {})
    # A single joint model is an option of the landings; of several each has its own scene.
    model = models[0] if len(models) == 1 else None
    options = options._replace(given={**options.given, "joints": model})
    if table.is_dir():
        raise StudyError(
            f'"{table}" is a folder, not a table of landings; for a folder of scenes: shockpc '
            f"batch {table}/*.toml"
        )
    if robot is None:
        raise StudyError(f"a table needs a robot: shockpc recorded {table} ROBOT --contact …")
    columns, loaded, scene = table_and_scene(table, robot, options, renames)
    modelled = _with_models(scene, loaded, models)
    if models[1:]:
        scene = next(iter(modelled.values()))
    rows_in_table = rows_of(columns, landing_of(scene, loaded), renames)
    if len(models) > 1 and not rows_in_table.measured:
        raise StudyError(
            "several joint models are compared with measured jumps, but the table has no column "
            "after_…"
        )
    evaluation = recorded_landings(rows_in_table, loaded, **asked_for)
    source = evaluation.landings
    if command_ is not None:
        if output.out is not None or output.format != "table":
            raise StudyError(
                "--command prints only the scene of one landing; leave out --out and --format"
            )
        sys.stdout.write(
            scene_text(spelled_out(source.case(source.row_named(command_)), loaded), Path.cwd())
        )
        return 0
    refuse_unasked(
        study,
        options,
        typed,
        (measured.key for measured in rows_in_table.measured if "@" in measured.key),
    )
    refuse_unused(scene, rows_in_table, evaluation)
    # Before anything is written, because one of several joint models may be refused.
    comparison, defects = None, list[str]()
    if rows_in_table.measured:
        try:
            comparison = compare_measured(
                columns, modelled or {source.first.joint_model.name: scene}, loaded, renames
            )
        except DefectError as defect:  # the rows are given nevertheless
            defects = [defect.trace]
    with computed(evaluation, "landings", output.out, rows, run) as results:
        ranked = None if rank is None else results.column(rank)
        # The page has room for the worst landings only.
        worst = {}
        for i in results.worst(PAGE_LANDINGS, ranked) if output.out is not None else ():
            name = str(rows_in_table.names[i])
            try:
                worst[name] = source.profile(i)
            except ShockError as error:
                print_error(f'landing "{name}" is not in report.html: {error}')
        emit(recorded_report(str(table), source, results, ranked, comparison, worst), output)
    return exit_code(len(results.messages), len(results), run.strict, (*results.defects, *defects))


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
