"""`shockpc landings`: the landings of a table, and measured jumps against predicted ones."""

import sys
from pathlib import Path
from typing import Literal

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import QUANTITY, ROBOT, OutputOptions, RunOptions, SceneOptions, in_run
from shockpc.cli.parse import JointModelName, joint_models, path, renaming
from shockpc.cli.process import print_error
from shockpc.landing.record import options_of
from shockpc.landing.scene import Joints

_in_table, _in_joints = group("Table"), group("Joint model")

PAGE_LANDINGS = 8
"""Landings that report.html shows."""


@command(
    "shockpc landings log.csv anymal_b --contact LF_FOOT --rank delta_v@imu_link",
    "shockpc landings log.csv anymal_b --contact LF_FOOT --pulse half-sine:5ms --rank peak_g@imu_link --out landings/",
    "shockpc landings scenes/ --rank shock@imu_link",
    more=(
        "A row is a touchdown (CSV, Parquet, NPZ; or a scene of a folder, named by its file). Columns: joint positions JOINT or "
        "q_JOINT and rates before_JOINT or qd_JOINT [rad, m]; the base's qw qx qy qz or roll pitch yaw, x y z, velocity vx vy vz "
        "and angular velocity wx wy wz in world axes, with _body in its own; contact (A+B), vx@FRAME vy@FRAME vz@FRAME of a "
        "contact whose velocity is not that of the robot's motion (empty where it is), friction, name, time. _deg at the end of a "
        "name means degrees. Arrays qpos and qvel are MuJoCo's, name, position and velocity ROS's. What is missing is the scene's."
        " Columns after_JOINT, after_vx and after_KEY@PLACE, or after6ms_… with a time, are compared with the prediction."
    ),
)
def landings(
    *,
    table: Path = argument("A table of landings: .csv, .parquet or .npz; or a folder of scenes (.toml).", "TABLE", path),
    robot: str | None = ROBOT,
    options: SceneOptions,
    map_: tuple[tuple[str, str], ...] = _in_table(
        "Another name for a column, or for a joint in all of its columns; a * stands for the same text in both, and what is given "
        "no new name is left out.",
        "NAME=[NAME]",
        renaming,
    ),
    joints_: tuple[JointModelName, ...] | None = _in_joints(
        f"{options_of(Joints)['model'].text} Several, with commas between them, are compared with what was measured.",
        "MODEL[,MODEL]",
        joint_models,
    ),
    quantity: tuple[str, ...] = QUANTITY,
    rank: str | None = _in_table("Order the landings by a quantity, the worst first.", "KEY[@PLACE]"),
    command_: str | None = _in_table(
        "Print the landing of this row, by its name, as a scene, which shockpc analyze takes, and nothing else.", "ROW"
    ),
    prove: int = in_run("Landings that are compared with a proof; 20 by default.", "N", default=20, least=0),
    rows: Literal["parquet", "csv"] | None = in_run("With --out, write the rows in parts, which --resume continues."),
    run: RunOptions,
    output: OutputOptions,
) -> int:
    import dataclasses

    from shockpc.cli.output import emit, exit_code
    from shockpc.cli.progress import progress
    from shockpc.cli.scenes import one_scene, scenes_in, with_contact
    from shockpc.cli.write_parts import written_parts
    from shockpc.evaluation.executor import executor
    from shockpc.evaluation.recorded import recorded_landings
    from shockpc.evaluation.recorded_table import rows_of, rows_of_scenes
    from shockpc.evaluation.table_files import read_table
    from shockpc.landing.landing import landing_of
    from shockpc.landing.scene import Scene
    from shockpc.landing.scene_file import scene_text
    from shockpc.show.parts import Parts
    from shockpc.show.reports.landings import landings_report
    from shockpc.studies.landings import compare_measured
    from shockpc.text.errors import ShockError, StudyError

    models = joints_ or ()
    options = options._replace(given={**options.given, "joints": models[0] if models else None})
    if (run.resume or rows) and (output.out is None or not rows):
        raise StudyError("rows in parts need a folder and a format: --out DIR --rows parquet")
    if table.is_dir():
        if robot is not None or map_:
            raise StudyError(f'the scenes of "{table}" have their robot and no columns; leave out {robot or "--map"}')
        loaded, scenes = scenes_in(table, options)
        rows_in_table = rows_of_scenes(scenes, loaded)
    else:
        columns, renames = read_table(table), dict(map_)
        if robot is None:
            raise StudyError(f"a table needs a robot: shockpc landings {table} ROBOT --contact …")
        if "contact" in columns:
            options = with_contact(robot, options, columns["contact"].astype(str).ravel().tolist())
        loaded, scene = one_scene(robot, options)
        rows_in_table = rows_of(columns, landing_of(scene, loaded), renames)
    if len(models) > 1 and not rows_in_table.measured:
        raise StudyError("several joint models are compared with what was measured, but the table has no column after_…")
    evaluation = recorded_landings(rows_in_table, loaded, quantity, prove=prove, ranked_by=rank)
    study = evaluation.landings
    if command_ is not None:
        sys.stdout.write(scene_text(study.case(study.row_named(command_)), Path.cwd()))
        return 0
    # Before anything is written, because one of several joint models may be refused.
    comparison = None
    if rows_in_table.measured:
        compared: dict[str, Scene] = {
            model: dataclasses.replace(scene, joints=dataclasses.replace(scene.joints, model=model)) for model in models
        }
        comparison = compare_measured(columns, compared or {study.first.joint_model.name: scene}, loaded, renames)
    workers = executor(run.jobs, run.cluster, print_error if run.wait else None)
    if output.out is not None and rows:
        parts = Parts(evaluation, output.out, rows)
        with written_parts(parts, workers, run.resume, "landings"):
            results = parts.table()
    else:
        with workers as pool:
            results = evaluation.table(pool, progress("landings computed", study.rows))
    ranked = None if rank is None else results.column(rank)
    worst = {}
    for i in results.worst(PAGE_LANDINGS, ranked) if output.out is not None else ():
        name = str(rows_in_table.names[i])
        try:
            worst[name] = study.profile(i)
        except ShockError as error:
            print_error(f'landing "{name}" is not in report.html: {error}')
    emit(landings_report(str(table), study, results, ranked, comparison, worst), output)
    return exit_code(len(results.messages), len(results), run.strict, results.defects)
