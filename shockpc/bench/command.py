"""`shockpc bench`: error against run time of several methods."""

import os
import sys
from pathlib import Path

from shockpc.cli.declared import argument, command
from shockpc.cli.options import SceneOptions, in_output
from shockpc.cli.parse import out_folder, typed_robot

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@command(
    examples=("shockpc bench anymal_b --contact LF_FOOT",),
)
def bench(
    *,
    options: SceneOptions,
    robot: str | None = argument(
        "A robot file, a robot's name or a scene (TOML); without it the standing suite runs.",
        "ROBOT",
        typed_robot,
    ),
    out: Path | None = in_output(
        "Folder of the report. [default: out/bench for the suite, none for a landing]",
        "DIR",
        out_folder,
    ),
) -> None:
    # Set before numpy is loaded: the run times are those of one thread.
    for name in THREADS:
        os.environ[name] = "1"
    from shockpc.text.errors import SceneError

    if robot is not None:
        _landings(robot, options, out)
    elif not options.typed:
        _suite(out or Path("out/bench"))
    else:
        raise SceneError(
            "the options of a landing need a robot: shockpc bench robot.urdf --contact foot"
        )


def _suite(out: Path) -> None:
    from shockpc.bench.report import PARTS, suite_report
    from shockpc.cli.progress import progress
    from shockpc.show.folder import write_report_folder

    report = suite_report(progress=progress("parts measured", len(PARTS)))
    write_report_folder(out, report)
    sys.stdout.write(f"{report.text('table')}\nthe report: {out / 'report.md'}\n")


def _landings(robot: str, options: SceneOptions, out: Path | None) -> None:
    """Measure the landings that the options describe, each with a table.

    Several have a folder each in `out`.
    """
    from shockpc.bench.report import bench_report
    from shockpc.cli.scenes import file_names, scenes_from
    from shockpc.show.folder import write_report_folder

    loaded, scenes = scenes_from(robot, options)
    for scene, name in zip(scenes, file_names(scenes), strict=True):
        report = bench_report(loaded, scene)
        if out is not None:
            write_report_folder(out if len(scenes) == 1 else out / name, report)
        sys.stdout.write((f"{name}\n" if len(scenes) > 1 else "") + report.text("table"))
