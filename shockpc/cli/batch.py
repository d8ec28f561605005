"""`shockpc batch`: many robots, each landing on each of its feet."""

import functools

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import QUANTITY, STRICT, OutputOptions, SceneOptions, in_output
from shockpc.cli.parse import robot_name

_in_robots = group("Robots")


@command(
    "shockpc batch anymal_c go2 solo12",
    more=(
        "Each robot stands in its standing posture and falls straight down at 1 m/s, unless options say otherwise. With"
        " --contact, only matching feet strike; a scene lands as it says. Ends with exit code 3 if some landings cannot"
        " be computed. A quantity of bodies or points is that of the trunk, the heaviest body, unless a place is named; of"
        " several places it is the worst."
    ),
)
def batch(
    *,
    names: tuple[str, ...] = argument("Robots by name, robot files and scenes.", "[ROBOT]...", robot_name),
    robots: tuple[str, ...] = _in_robots("A set of robots: quadrupeds, bipeds or all.", "SET"),
    jobs: int = _in_robots("Processes that compute at the same time; 1 by default.", "N", least=1, default=1),
    options: SceneOptions,
    quantity: tuple[str, ...] = QUANTITY,
    rank: str = in_output(
        "Quantity by which landings are ranked, the worst first; shock_max by default.", "KEY[@PLACE]", default="shock_max"
    ),
    strict: bool = _in_robots(STRICT),
    output: OutputOptions,
    figures: bool = in_output("Also draw the worst landing of each robot on one contact sheet in that folder."),
) -> int:
    from shockpc.cli.output import emit, exit_code
    from shockpc.cli.progress import progress
    from shockpc.cli.scenes import scenes_from
    from shockpc.evaluation.executor import executor
    from shockpc.robot.catalogue import robots_of_set
    from shockpc.show.reports.batch import batch_report
    from shockpc.studies import batch as study
    from shockpc.text.errors import StudyError

    every = list(dict.fromkeys([*names, *(name for set_name in robots for name in robots_of_set(set_name))]))
    if not every:
        raise StudyError("no robot is named; give names or files, or a set: shockpc batch --robots quadrupeds")
    if figures and output.out is None:
        raise StudyError("--figures needs a folder to write to; give one with --out")
    look = None
    if figures:
        from shockpc.show.figure.view import view_of

        look = view_of
    with executor(min(jobs, len(every))) as pool:
        read = functools.partial(scenes_from, options=options, on_each_foot=True)
        result = study.batch(every, read, pool, look, progress("robots computed", len(every)), quantity, rank)
    emit(batch_report(result), output)
    return exit_code(len(result.failures), len(result.rows) + len(result.failures), strict, result.table.defects)
