"""`shockpc landings`: the landings of a table, and measured jumps against predicted ones."""

import sys
from pathlib import Path
from typing import Literal

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import QUANTITY, ROBOT, OutputOptions, SceneOptions
from shockpc.cli.parse import JointModelName, joint_models, path, renaming

_in_table, _in_run, _in_joints = group("Table"), group("How it is computed, and where it is written"), group("Joint model")


@command(
    "Compute the recorded landings of a table, and compare what was measured.",
    "shockpc landings log.csv anymal_b --contact LF_FOOT --rank delta_v@imu_link",
    "shockpc landings log.csv anymal_b --contact LF_FOOT --pulse half-sine:5ms --rank peak_g@imu_link --out landings/",
    more=(
        "A row is a touchdown (CSV, Parquet or NPZ). Columns: joint positions JOINT or q_JOINT and rates before_JOINT or qd_JOINT "
        "[rad, m]; the base's qw qx qy qz or roll pitch yaw, x y z, velocity vx vy vz and angular velocity wx wy wz in world axes, "
        "with _body in its own; contact (A+B), friction, name. _deg at the end of a name means degrees. Arrays qpos and qvel are "
        "MuJoCo's, name, position and velocity ROS's. What is missing is the scene's. Columns after_JOINT, after_vx and "
        "after_KEY@PLACE, or after6ms_… with a time, are compared with the prediction."
    ),
)
def landings(
    *,
    table: Path = argument("A table of landings: .csv, .parquet or .npz.", "TABLE", path),
    robot: str = ROBOT,
    options: SceneOptions,
    map_: tuple[tuple[str, str], ...] = _in_table(
        "Another name for a column, or for a joint in all of its columns; a * stands for the same text in both, and what is given "
        "no new name is left out.",
        "NAME=[NAME]",
        renaming,
    ),
    joints_: tuple[JointModelName, ...] | None = _in_joints(
        "All joints turn freely, resist by their reflected inertia, or are locked: free, geared, locked; several, with commas "
        "between them, are compared with what was measured.",
        "MODEL[,MODEL]",
        joint_models,
    ),
    quantity: tuple[str, ...] = QUANTITY,
    rank: str | None = _in_table("Order the landings by a quantity, the worst first.", "KEY[@PLACE]"),
    command_: str | None = _in_table(
        "Print the landing of this row, by its name, as a scene, which shockpc analyze takes, and nothing else.", "ROW"
    ),
    prove: int = _in_run("Landings that are compared with a proof; 20 by default.", "N", default=20, least=0),
    jobs: int = _in_run("Number of processes; 1 by default.", "N", least=1, default=1),
    cluster: str | None = _in_run("Compute on a running Dask cluster.", "ADDRESS"),
    rows: Literal["parquet", "csv"] | None = _in_run("With --out, write the rows in parts, which --resume continues."),
    resume: bool = _in_run("Continue a table that was interrupted; the same --out and --rows."),
    output: OutputOptions,
) -> int:
    import dataclasses

    from shockpc.cli.output import emit
    from shockpc.cli.progress import progress
    from shockpc.cli.scenes import one_scene
    from shockpc.cli.write_parts import written_parts
    from shockpc.errors import SolveError, StudyError
    from shockpc.executor import executor
    from shockpc.scene import Scene, scene_text
    from shockpc.show.parts import Parts
    from shockpc.show.reports.landings import landings_report
    from shockpc.studies.landings.comparison import compare_measured
    from shockpc.studies.landings.study import Found, compute
    from shockpc.studies.landings.study import landings as study
    from shockpc.studies.landings.table import read_table

    columns, renames = read_table(table), dict(map_)
    if "contact" in columns and not options.contact:
        # The rows have contacts of their own; the scene needs one until they are set.
        options = options._replace(contact=(str(columns["contact"][0]),))
    models = joints_ or ()
    loaded, scene = one_scene(robot, options._replace(joints=models[0] if models else None))
    if (resume or rows) and (output.out is None or not rows):
        raise StudyError("rows in parts need a folder and a format: --out DIR --rows parquet")
    made = study(columns, scene, quantity, robot=loaded, rename=renames, prove=prove, ranked_by=rank)
    if command_ is not None:
        sys.stdout.write(scene_text(made.case(made.row_named(command_)), Path.cwd()))
        return 0
    ranked = None if rank is None else made.column(rank)
    if output.out is not None and rows:
        parts = Parts(made, output.out, rows)
        with written_parts(parts, executor(jobs, cluster), resume, "landings"):
            found = Found.read(made, parts.column)
    else:
        with executor(jobs, cluster) as workers:
            found = compute(made, workers, progress("landings computed", made.rows))
    comparison = None
    if made.table.measured:
        scenes: dict[str, Scene] = {} if models else {made.first.joint_model.name: scene}
        for model in models:
            scenes[model] = dataclasses.replace(scene, joints=dataclasses.replace(scene.joints, model=model))
        comparison = compare_measured(columns, scenes, loaded, renames)
    elif len(models) > 1:
        raise StudyError("several joint models are compared with what was measured, but the table has no column after_…")
    emit(landings_report(str(table), found, ranked, comparison), output)
    return SolveError.exit_code if found.messages else 0
