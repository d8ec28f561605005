"""`shockpc batch`: landings of many robots."""

import functools
from typing import Any

from shockpc.cli.declared import argument, command, group
from shockpc.cli.options import JOBS, STRICT, OutputOptions, SceneOptions, in_output
from shockpc.cli.output import emit, exit_code
from shockpc.cli.parse import typed_robot, whole_number
from shockpc.cli.progress import progress
from shockpc.cli.scenes import scenes_from
from shockpc.cli.study_command import help_of, study_arguments, study_options
from shockpc.cli.unused_options import refuse_unasked
from shockpc.evaluation.executor import executor
from shockpc.robot.catalogue import robots_of_set
from shockpc.studies.batch.report import batch_report
from shockpc.studies.batch.study import batch as study
from shockpc.text.errors import StudyError

_in_robots = group("Robots")


@command(**help_of(study))
def batch(
    *,
    names: tuple[str, ...] = argument(
        "Robots by name, robot files and scenes.", "[ROBOT]...", typed_robot
    ),
    robots: tuple[str, ...] = _in_robots(
        "A set of robots: quadrupeds, bipeds, humanoids (bipeds with a trunk and arms) or all.",
        "SET",
    ),
    jobs: int = _in_robots(JOBS.text, JOBS.form, whole_number(JOBS), default=1),
    typed: Any = study_options(study),
    options: SceneOptions,
    strict: bool = _in_robots(STRICT),
    output: OutputOptions,
    landings: bool = in_output("Print every landing instead of the worst of each robot."),
    figures: bool = in_output(
        "Also draw the worst landing of each robot on one contact sheet in that folder."
    ),
) -> int:
    given_names = [*names]
    for set_name in robots:
        given_names += robots_of_set(set_name)
    every = list(dict.fromkeys(given_names))
    if not every:
        raise StudyError(
            "no robot is named; give names or files, or a set: shockpc batch --robots quadrupeds"
        )
    if output.format == "pdf" and not figures:
        raise StudyError(
            "batch draws a figure only with --figures; give --figures with --format pdf"
        )
    if figures and output.out is None:
        raise StudyError("--figures needs a folder to write to; give one with --out")
    refuse_unasked(study, options, typed)
    draw = None
    if figures:
        from shockpc.show.figure.view import view_of  # which imports matplotlib

        draw = view_of
    with executor(min(jobs, len(every))) as pool:
        read = functools.partial(scenes_from, options=options)
        result = study(
            every,
            read,
            pool,
            draw,
            functools.partial(progress, "robots computed"),
            **study_arguments(study, typed),
        )
    emit(batch_report(result, landings), output)
    return exit_code(
        len(result.failures), len(result.rows) + len(result.failures), strict, result.defects
    )
